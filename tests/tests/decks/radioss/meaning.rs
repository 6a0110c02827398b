//! Values whose meaning in Radioss differs from that in a job: signs, defaults, main nodes.

use super::{deck, mesh, model, moves, properties, reading, said, with};
use crumple::input::deck::radioss::export::export;

/// Nodes of the cube, a main node above it and a body of both.
const BODY: &str = "/NODE
    i90 r5 r5 r5
    /GRNOD/PART/2
    =cube nodes
    i2";

/// Returns a deck with another material.
fn of_law(law: &str) -> String {
    mesh() + &properties() + &moves() + &deck(law)
}

/// A positive pressure acts along the right-hand normal of a face: it pulls at the outside of a
/// solid and lifts a shell whose normal is up. In a job a positive one acts against the normal.
#[test]
fn a_pressure_acts_along_the_normal() {
    let lines = |nodes: &str| {
        format!(
            "/FUNCT/1\n=one\nr0 r1\nr10 r1\n/SURF/SEG/1\n=face\ni1 {nodes}\n/PLOAD/1\n=press\n\
             i1 i1 i0 _ _ _ r1 r0.5"
        )
    };
    for (nodes, along, what) in [
        ("i11 i12 i15 i14", true, "a shell, in the order of its nodes"),
        ("i14 i15 i12 i11", false, "a shell, in the other order"),
        ("i5 i6 i7 i8", true, "the top of the cube, normal outwards"),
        ("i8 i7 i6 i5", false, "the top of the cube, normal inwards"),
    ] {
        let found = model(&with(&lines(nodes)));
        let expected = if along { -0.5 } else { 0.5 };
        assert_eq!(found.job.pressure[0].pressure, expected, "{what}");
    }
    // The writer has the same sign: pressure on a part.
    let whole = lines("i1").replace("/SURF/SEG/1\n=face\ni1 i1", "/SURF/PART/1\n=face\ni1");
    let text = export(&model(&with(&whole)), "again").unwrap().starter;
    let card = text.lines().skip_while(|l| !l.starts_with("/PLOAD")).nth(2).unwrap();
    let value = card.split_whitespace().last().unwrap();
    assert_eq!(value.parse::<f64>().unwrap(), 0.5, "{card}");
}

/// An initial velocity needs a group. One of nodes of a body without its main node gives a
/// warning, as the body would not move in Radioss.
#[test]
fn initial_velocities_are_those_of_main_nodes() {
    let none = with("/INIVEL/TRA/2\n=fall\nr0 r0 r-1 i0");
    let report = reading(&none, &[]).err().unwrap();
    assert!(report.contains("/INIVEL/TRA: no group is given"), "{report}");
    let body = format!("{BODY}\n/RBODY/1\n=the cube\ni90 i0 i0 i0 r0 i2");
    let said = said(&model(&with(&body)));
    assert!(said.contains("its main node 90 has none"), "{said}");
    let both = format!("{body}\n/GRNOD/NODE/3\n=main\ni90\n/INIVEL/TRA/2\n=main\nr1 r0 r0 i3");
    let found = model(&with(&both));
    let all = super::said(&found);
    assert!(!all.contains("its main node 90 has none"), "{all}");
    // The writer puts main nodes into the groups.
    let text = export(&found, "again").unwrap().starter;
    let after = |from: &str, name: &str| {
        let lines: Vec<String> = from.lines().map(String::from).collect();
        let at = lines.iter().position(|l| l == name).unwrap_or_else(|| panic!("{name}\n{text}"));
        lines[at + 1..].iter().take_while(|l| !l.starts_with('/')).cloned().collect::<Vec<_>>()
    };
    let main = after(&text, "/RBODY/1")[1].split_whitespace().next().unwrap().to_string();
    let group = after(&text, "/INIVEL/TRA/1")[1].split_whitespace().last().unwrap().to_string();
    let nodes = after(&text, &format!("/GRNOD/NODE/{group}")).join(" ");
    assert!(nodes.split_whitespace().any(|n| n == main), "{main} in {nodes}");
}

/// Ioptoff, Iexpams and Ifail have their columns; a body that fails has one more line.
#[test]
fn the_fourth_line_of_a_body_has_its_columns() {
    let body = |last: &str| {
        let head = format!("{BODY}\n/RBODY/1\n=the cube\ni90 i0 i0 i0 r0 i2 i1\n_\n_\n");
        with(&(head + last))
    };
    assert!(reading(&body("i0 i2 i0"), &[]).is_ok(), "the default of Iexpams is 2");
    let said = said(&model(&body("i0 i1 i0")));
    assert!(said.contains("iexpams 1"), "{said}");
    let report = reading(&body("i0 i2 i1\nr5 r6 r2 r2"), &[]).err().unwrap();
    assert!(report.contains("`ifail` = 1 is not supported"), "{report}");
    assert!(!report.contains("more lines"), "{report}");
}

/// The inertia of the main node adds to that of the nodes, unless it would replace it.
#[test]
fn the_inertia_of_a_main_node_is_added_to_its_body() {
    let of = |ispher: &str, icog: &str| {
        let head = format!("i90 i0 i0 {ispher} r0 i2 i1 {icog}");
        model(&with(&format!("{BODY}\n/RBODY/1\n=b\n{head}\nr5 r6 r7\nr0.1 r0.2 r0.3")))
    };
    let found = of("i0", "i0");
    assert_eq!(found.job.rigid[0].added_inertia, Some([5.0, 6.0, 7.0, 0.1, 0.2, 0.3]));
    assert!(!said(&found).contains("jxx"), "{}", said(&found));
    for (ispher, icog) in [("i1", "i0"), ("i0", "i4")] {
        let found = of(ispher, icog);
        assert_eq!(found.job.rigid[0].added_inertia, None);
        let words = "the inertia of the main node is ignored";
        assert!(said(&found).contains(words), "{}", said(&found));
    }
}

/// A wall stops nodes in front of it only, and nodes of a body only with Ikrem 1.
#[test]
fn walls_stop_nodes_in_front_and_of_bodies_with_a_flag() {
    let wall = "/RWALL/PLANE/1\n=floor\ni0 i0\nr99 r0 r0\nr0 r0 r5\nr0 r0 r6";
    let nodes = |lines: &str| {
        let found = model(&with(lines));
        let set = found.job.wall[0].nodes.clone();
        set.map(|set| found.mesh.node_sets[&set].iter().map(|n| n.label()).collect::<Vec<u64>>())
    };
    let above = vec![5, 6, 7, 8, 11, 12, 13, 14, 15, 16];
    assert_eq!(nodes(wall), Some(above), "1 to 4 are behind it");
    let low = wall.replace("r0 r0 r5\nr0 r0 r6", "r0 r0 r0\nr0 r0 r1");
    let body = |flag: &str| format!("{BODY}\n/RBODY/1\n=b\ni90 i0 i0 i0 r0 i2 {flag}\n{low}");
    assert_eq!(nodes(&body("i1")), None, "all nodes");
    assert_eq!(nodes(&body("i0")), Some((11..17).collect()), "the plate only");
}

/// A zero is a default where the format says so.
#[test]
fn zeros_are_defaults() {
    let head = "=m\nr7.85e-6\nr200.0 r0.3";
    let linear = model(&of_law(&format!("/MAT/LAW2/1\n{head}\nr0.3 r0.5 r0")));
    assert_eq!(linear.job.material[0].law, "j2", "n 0 is 1");
    let hot = format!("/MAT/LAW2/1\n{head}\nr0.3 r0.4 r0.5\nr0.01 r1e-3\nr0 r1700 r3.6e-3 r0");
    let found = model(&of_law(&hot));
    let of = |key: &str| found.job.material[0].parameters[key].as_float();
    assert_eq!((of("m"), of("reference_temperature")), (Some(1.0), Some(300.0)));
    for rate in ["r0", ""] {
        let law = format!("/MAT/LAW2/1\n{head}\nr0.3 r0.4 r0.5\nr0.01 {rate}");
        let report = reading(&of_law(&law), &[]).err().unwrap();
        assert!(report.contains("c = 0.01 without a reference rate eps0"), "{report}");
    }
    for exponent in ["r0", ""] {
        let law = format!("/MAT/LAW44/1\n{head}\nr0.3 r0.5 r0\nr40 {exponent}");
        let found = model(&of_law(&law));
        let of = |key: &str| found.job.material[0].parameters.get(key).cloned();
        let pair = of("cowper_symonds").unwrap();
        assert_eq!([0, 1].map(|i| pair[i].as_float().unwrap()), [40.0, 1.0]);
        assert!(of("hardening_modulus").is_some(), "n 0 is 1");
    }
}

/// A tie that breaks is refused; Spotflag 4 leaves rotations free.
#[test]
fn ties_have_the_degrees_of_freedom_of_their_flag() {
    let tie = |flag: &str| {
        with(&format!(
            "/GRNOD/NODE/4\n=rim\ni11 i14\n/SURF/SEG/2\n=top\ni1 i5 i6 i7 i8\n/INTER/TYPE2/3\n\
             =tied\ni4 i2 i0 {flag} _ _ _ _ r3.0"
        ))
    };
    assert!(model(&tie("i5")).job.tie[0].rotations);
    assert!(!model(&tie("i4")).job.tie[0].rotations);
    let report = reading(&tie("i21"), &[]).err().unwrap();
    assert!(report.contains("`spotflag` = 21 is not supported"), "{report}");
}

/// General sets: ranges with an increment and blanks, segments with a blank id that are taken away,
/// the key SUBS, and a set that comes later.
#[test]
fn general_sets_have_their_content() {
    let found = model(
        &with(
            "/SET/GENERAL/21
        =early
        wSET i23
        wPART_D i1
        /SET/GENERAL/22
        =ranges
        wNODE_G i1 i7 i3 i11 i12 i0
        /SET/GENERAL/23
        =late
        wSUBS i5
        wPART i2
        /SUBSET/5
        =plate only
        /SET/GENERAL/24
        =faces
        wSEG _ i11 i12 i15 i14
        _ i2 i12 i13 i16 i15
        wSEG_D i0 i14 i15 i12 i11
        /FUNCT/1
        =one
        r0 r1
        r10 r1
        /PLOAD/1
        =press
        i24 i1 i0 _ _ _ r1 r0.5",
        )
        .replacen(
            "/PART/1\nplate\n         1         1         0",
            "/PART/1\nplate\n         1         1         5",
            1,
        ),
    );
    let set = |id: u64| {
        let nodes = &found.mesh.node_sets[&format!("set-{id}")];
        nodes.iter().map(|n| n.label()).collect::<Vec<u64>>()
    };
    assert_eq!(set(23), [1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 13, 14, 15, 16]);
    assert_eq!(set(21), [1, 2, 3, 4, 5, 6, 7, 8], "set 23 without part 1");
    assert_eq!(set(22), [1, 4, 7, 11, 12]);
    let [press] = &found.job.pressure[..] else { panic!("one face is left") };
    let nodes = &found.mesh.node_sets[press.nodes.as_ref().unwrap()];
    assert_eq!(nodes.iter().map(|n| n.label()).collect::<Vec<u64>>(), [12, 13, 15, 16]);
}

/// Values that are the defaults of the format are accepted: flags of 1, function 0 as a factor of
/// one, `/UNIT` in the units that a blank `/BEGIN` means.
#[test]
fn defaults_are_accepted() {
    let found = model(&with(
        "/GRNOD/NODE/1\n=two\ni11 i12\n/SURF/PART/1\n=plate\ni1\n/CLOAD/1\n=pull\n\
         i0 wY i0 i0 i1 i1 r1 r0.25\n/GRAV/1\n=fall\ni0 wZ i0 i0 i0 _ r1 r-1e-3\n/PLOAD/1\n=press\n\
         i1 i0 i0 i0 i1 _ r1 r0.5\n/IMPVEL/1\n=v\ni0 wX i0 i0 i1\nr1 r2",
    ));
    assert_eq!(found.job.curve.len(), 1, "one curve of ones");
    assert!(found.job.curve[0].points.iter().all(|p| p[1] == 1.0));
    assert_eq!((found.job.load.len(), found.job.gravity.len(), found.job.motion.len()), (1, 1, 1));
    let begin = format!("{:>20}{:>20}{:>20}\n", "kg", "mm", "ms");
    let blank =
        with("/UNIT/3\n=si\nrkg rm rs\n/MAT/ELAST/2/3\n=m\nr1\nr1 r0").replace(&begin, "\n");
    assert!(reading(&blank, &[]).is_ok());
    let mega = with("").replace("                  mm", "                  Mm");
    assert!(!model_units(&mega).contains("mm"), "Mm is a megametre");
}

/// Returns the units of a deck, or the report on them.
fn model_units(text: &str) -> String {
    reading(text, &[]).map_or_else(|report| report, |found| found.job.units)
}

/// Masses on a main node go to its body; a group of parts is refused; masses on nodes of walls are
/// named.
#[test]
fn masses_do_not_vanish() {
    let body = format!("{BODY}\n/RBODY/1\n=the cube\ni90 i0 i0 i0 r0 i2\n");
    let group = "/GRNOD/NODE/3\n=main and corner\ni90 i11\n/ADMAS/0/1\n=each\nr0.5 i3";
    let found = model(&with(&(body.clone() + group)));
    let masses: Vec<(usize, f64)> =
        found.job.mass.iter().map(|m| (found.mesh.node_sets[&m.nodes].len(), m.mass)).collect();
    assert!(masses.contains(&(8, 0.5)) && masses.contains(&(1, 0.5)), "{masses:?}");
    let single = model(&with(&(body + "/ADMAS/5/1\n=single\nr0.75 i90")));
    assert_eq!(single.job.mass[0].mass, 0.75);
    let report = reading(&with("/ADMAS/3/1\n=part\nr1 i1"), &[]).err().unwrap();
    assert!(report.contains("`kind` = 3 is not supported"), "{report}");
    let wall = "/NODE\ni91 r0 r0 r-9\n/GRNOD/NODE/4\n=wall\ni91\n/RWALL/PLANE/1\n=w\ni91 i0\nr99\n\
                r2 r0 r0 r0\nr0 r0 r0";
    for card in ["/ADMAS/0/1\n=m\nr1 i4", "/BCS/1\n=b\n", "/INIVEL/TRA/2\n=v\nr0 r0 r1 i4"] {
        let mut text = with(&format!("{wall}\n{card}"));
        if card.starts_with("/BCS") {
            text += "   111 111         0         4\n";
        }
        let said = said(&model(&text));
        assert!(said.contains("on node 91, that of a wall, is ignored"), "{card}\n{said}");
    }
}

/// Sets that are made for conditions of one id have different names, and no set replaces another.
#[test]
fn sets_of_one_id_are_different() {
    let found = model(&with(&format!(
        "{BODY}\n/RBODY/1\n=floor\ni90 i0 i0 i0 r0 i1 i1\n/GRNOD/NODE/1\n=feet\ni1 i2 i3\n\
         /RWALL/PLANE/1\n=floor\ni0 i0 i2\nr0\nr0 r0 r-1\nr0 r0 r0\n/FUNCT/1\n=one\nr0 r1\nr9 r1\n\
         /GRNOD/NODE/5\n=a\ni11 i90\n/GRNOD/NODE/6\n=b\ni12 i90\n/IMPVEL/7\n=v\ni1 wX i0 i0 i5\n\
         /IMPACC/7\n=a\ni1 wY i0 i0 i6\n/GRNOD/NODE/9\n=floor nodes\ni13"
    )));
    let set = |name: &str| found.mesh.node_sets[name].iter().map(|n| n.label()).collect::<Vec<_>>();
    assert_eq!(set(found.job.rigid[0].nodes.as_ref().unwrap()), [1, 2, 3]);
    let of_nodes = found.job.motion.iter().filter_map(|m| m.nodes.as_ref());
    assert_eq!(of_nodes.map(|name| set(name)).collect::<Vec<_>>(), [vec![11], vec![12]]);
}

/// Solids with several points, walls that tie and failure with the first point give warnings.
#[test]
fn what_is_weaker_than_in_radioss_gives_a_warning() {
    let full = with("").replacen("block\n        24", "block\n        17", 1);
    assert!(said(&model(&full)).contains("isolid 17 has several points"));
    let tied = with("/RWALL/PLANE/1\n=w\ni0 i1\nr99\nr0 r0 r-1\nr0 r0 r0");
    assert!(said(&model(&tied)).contains("Slide 1 ties nodes"));
    let law = |flag: &str| {
        of_law(&format!(
            "/MAT/LAW2/1\n=m\nr7.85e-6\nr200.0 r0.3\nr0.3 r0.4 r0.5\n/FAIL/JOHNSON/1\n\
             r0.1 r1.2 r-2 r0 r0\nr1 {flag}"
        ))
    };
    assert!(said(&model(&law("i1"))).contains("Ifail_sh 1 removes a shell"));
    assert!(!said(&model(&law("i2"))).contains("Ifail_sh 1 removes a shell"));
}

/// The writer keeps titles from being keywords, writes rectangles and refuses long ids.
#[test]
fn the_writer_keeps_to_the_format() {
    let wall = "/RWALL/PARAL/1\n=#floor\ni0 i0\nr99\nr0 r0 r-1\nr20 r0 r-1\nr0 r10 r-1";
    let text = with(wall).replacen("#floor", "floor", 1);
    let mut found = model(&text);
    found.job.wall[0].name = "/floor".into();
    found.job.title = "# a plate".into();
    let starter = export(&found, "again").unwrap().starter;
    assert!(starter.contains("/RWALL/PARAL/1\n /floor\n"), "{starter}");
    let again = model(&starter.replace("/BEGIN", "/RUN/A/1\n10.0\n/END/ENGINE\n/BEGIN"));
    assert_eq!(again.job.title, "# a plate");
    let [one, other] = [&again, &found].map(|m| &m.job.wall[0]);
    assert_eq!((one.normal, one.lengths), (other.normal, other.lengths));
    found.mesh.nodes.last_mut().unwrap().id = crumple_proto::ids::NodeId(20_000_000_000);
    let refused = export(&found, "again").err().unwrap();
    assert!(refused.contains("more digits than the 10 columns"), "{refused}");
}
