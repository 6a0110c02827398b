//! Joints of parts in keyword decks: beams, ties and welds. Each deck here adds lines to two
//! plates above each other.

use crumple::input::job::{Model, read};
use crumple_proto::job::BeamSection;
use std::fs;

/// Two plates; units mm, ms, kg. Part 1: two shells at z = 0, nodes 1 to 6; part 2: two at z =
/// 2, nodes 11 to 16.
const BASE: &str = "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*PART\nlow\n1,1,1\nhigh\n2,1,1\n\
    *SECTION_SHELL\n1,2,1.0,3\n1.0\n\
    *MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n*INITIAL_VELOCITY\n0\n1.0\n*NODE\n1,0,0,0\n2,10,0,0\n\
    3,20,0,0\n4,0,10,0\n5,10,10,0\n\
    6,20,10,0\n11,0,0,2\n12,10,0,2\n13,20,0,2\n14,0,10,2\n15,10,10,2\n16,20,10,2\n*ELEMENT_SHELL\n\
    1,1,1,2,5,4\n\
    2,1,2,3,6,5\n3,2,11,12,15,14\n4,2,12,13,16,15\n";

fn with(lines: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{lines}*END\n")).unwrap();
    read(&path, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Returns the unit vectors of the second axes of beams, perpendicular to their lines.
fn second_axes(model: &Model) -> Vec<[f64; 3]> {
    let at = |id| model.mesh.nodes.iter().find(|n| n.id == id).map(|n| n.x).unwrap();
    let beam = |id| model.mesh.elements.iter().find(|e| e.id == id).unwrap();
    let axis = |&(id, towards): &(crumple_proto::ids::ElemId, [f64; 3])| {
        let [a, b] = [0, 1].map(|c| at(beam(id).nodes[c]));
        let line = [0, 1, 2].map(|c| b[c] - a[c]);
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
        let across = [0, 1, 2].map(|c| towards[c] - line[c] * dot(line, towards) / dot(line, line));
        across.map(|c| (c / dot(across, across).sqrt() * 1e12).round() / 1e12)
    };
    model.settings.axes.iter().map(axis).collect()
}

#[test]
fn beams_have_their_sections_and_axes() {
    let model = with(
        "*PART\nrib\n3,3,1\ntube\n4,4,1\n*SECTION_BEAM\n3,1\n3.0,3.0,2.0,2.0\n*SECTION_BEAM\n\
        4,1,1.0,2,1.0\n\
        4.0,4.0,3.0,3.0\n*NODE\n99,0,50,0\n*ELEMENT_BEAM\n21,3,1,2,99\n22,4,2,3\n\
        *ELEMENT_BEAM_ORIENTATION\n23,3,1,4\n\
        3.0,4.0,4.0\n",
    );
    let [rib, tube] = [2, 3].map(|i| model.job.part[i].beam.clone().unwrap());
    assert_eq!(
        (rib.section, rib.height, rib.width),
        (BeamSection::Rectangle, 3.0, 2.0),
        "s is the second axis"
    );
    assert_eq!(
        (tube.section, tube.radius, tube.wall),
        (BeamSection::Tube, 2.0, 0.5),
        "diameters 4 and 3"
    );
    assert_eq!(rib.shear_areas, [6.0, 6.0], "shrf is 1");
    assert!((tube.shear_areas[0] / (0.25 * std::f64::consts::PI * 7.0) - 1.0).abs() < 1e-14);
    let slanted = 1.0 / 25.0f64.sqrt();
    let rounded = |x: f64| (x * 1e12).round() / 1e12;
    assert_eq!(second_axes(&model)[0], [0.0, 1.0, 0.0], "direction to node 99");
    assert_eq!(
        second_axes(&model)[2],
        [rounded(3.0 * slanted), 0.0, rounded(4.0 * slanted)],
        "a vector"
    );
    assert_eq!(
        second_axes(&model)[1].map(f64::abs).iter().sum::<f64>(),
        1.0,
        "along a coordinate axis, perpendicular to the beam"
    );
    assert_eq!(model.mesh.nodes.len(), 12, "the orientation node is not in the model");
    let text = crumple::input::check::describe(&model);
    assert!(
        text.contains(
            "beams, elform 1 (Hughes-Liu) -> corotational beam, section tube; elastic shear \
             deformation"
        ),
        "{text}"
    );
}

#[test]
fn resultants_are_general_sections() {
    let model =
        with("*PART\nbeam\n3,3,1\n*SECTION_BEAM\n3,2\n5.0,7.0,9.0\n*ELEMENT_BEAM\n1,3,1,2,4\n");
    let beam = model.job.part[2].beam.clone().unwrap();
    assert_eq!(
        (beam.area, beam.second_moments, beam.torsion),
        (5.0, [7.0, 9.0], 16.0),
        "j is iss + itt if blank"
    );
    assert_eq!(beam.shear_areas, [0.0; 2], "no sa, no shear");
    let timoshenko = with(
        "*PART\nbeam\n3,3,1\n*SECTION_BEAM\n3,13\n5.0,7.0,9.0,2.0,4.0\n*ELEMENT_BEAM\n1,3,1,2,4\n",
    );
    assert_eq!(timoshenko.job.part[2].beam.as_ref().unwrap().shear_areas, [4.0; 2]);
    assert!(
        crumple::input::check::describe(&model)
            .contains("beams: ids that other elements have too -> ids raised by 10\n")
    );
}

#[test]
fn spot_welds_of_beams_break() {
    let model = with(
        "*PART\nweld\n3,3,2\n*SECTION_BEAM\n3,9,1.0,2,1.0\n5.0\n*MAT_100\n\
        2,7.85e-6,207.0,0.3,0.4,2.0\n\
        0.5,3.0,4.0,4.0,0.0,6.0,6.0\n*ELEMENT_BEAM\n21,3,2,12\n",
    );
    let weld = model.job.part[2].beam.clone().unwrap().weld.unwrap();
    assert_eq!([weld.normal, weld.shear, weld.bending, weld.torsion], [3.0, 4.0, 6.0, 0.0]);
    let steel = model.job.material.iter().find(|m| m.law == "j2").unwrap();
    let number = |key: &str| steel.parameters[key].as_float().unwrap();
    let numbers = ["yield_stress", "hardening_modulus", "failure_strain"].map(number);
    assert_eq!(numbers, [0.4, 2.0, 0.5]);
}

/// A fixed node that only gives a beam its axes is no error; one of the beam itself stays fixed.
#[test]
fn nodes_for_axes_of_beams_are_not_fixed() {
    let fixes = |held: &str, card: &str| {
        let model = with(&format!(
            "*PART\nbar\n3,3,2\n*SECTION_BEAM\n3,2,1.0\n4.0,1.3,1.3,2.6,3.3\n*MAT_ELASTIC\n\
             2,7.85e-6,207.0,0.3\n*NODE\n31,1,2,30,7,7\n*ELEMENT_BEAM\n21,3,2,12,31\n\
             *SET_NODE_LIST\n9\n{held}\n{card}"
        ));
        let is_listed = model.mapping.iter().any(|m| m.asked.contains("for axes of beams"));
        let sets = model.job.fix.iter().map(|f| f.nodes.clone()).collect::<Vec<_>>();
        (is_listed, sets.iter().filter(|s| set(&model, s) == [31]).count(), sets.len())
    };
    let of_set = "*BOUNDARY_SPC_SET\n9,0,1,1,1\n";
    for (of_axis, of_beam) in
        [("*BOUNDARY_SPC_NODE\n31,0,1,1,1\n", "*BOUNDARY_SPC_NODE\n12,0,1,1,1\n"), (of_set, of_set)]
    {
        let (axis, beam) = (fixes("31", of_axis), fixes("12", of_beam));
        assert_eq!((axis.0, axis.1, beam.1), (true, 0, 0), "{of_axis}");
        assert_eq!(beam.2, axis.2 + 1, "{of_axis}");
    }
}

/// The forces of welds on one of their ends are in `sections.csv`.
#[test]
fn forces_of_welds_have_histories() {
    let weld = "*PART\nweld\n3,3,2\n*SECTION_BEAM\n3,9,1.0,2,1.0\n5.0\n*MAT_100\n\
                2,7.85e-6,207.0,0.3,0.4,2.0\n\n*ELEMENT_BEAM\n21,3,2,12\n";
    let model = with(&format!("{weld}*DATABASE_SWFORC\n0.1\n"));
    let section = &model.job.output.section[0];
    assert_eq!((section.name.as_str(), &section.elements[..]), ("weld-21", &[21][..]));
    assert_eq!(set(&model, &section.nodes), [12]);
    let cut = "*SET_NODE_LIST\n5\n12\n*SET_BEAM\n6\n21\n*DATABASE_CROSS_SECTION_SET\n5,0,6\n";
    let model = with(&format!("{weld}{cut}"));
    assert_eq!(model.job.output.section[0].elements, [21], "a set of beams");
    let none = |interval: &str| with(&format!("*DATABASE_SWFORC\n{interval}\n"));
    let warned = |model: &Model| {
        model.warnings.iter().any(|w| w.message.contains("no spot weld is an element"))
    };
    assert!(none("0.1").job.output.section.is_empty());
    assert!(warned(&none("0.1")) && !warned(&none("0.0")));
}

fn set(model: &Model, name: &str) -> Vec<u64> {
    model
        .mesh
        .node_sets
        .get(name)
        .unwrap_or_else(|| panic!("no {name}"))
        .iter()
        .map(|n| n.0)
        .collect()
}

#[test]
fn contacts_tie() {
    let sets = "*SET_NODE_LIST\n5\n12,15\n*SET_SEGMENT\n6\n1,2,5,4\n*SET_PART_LIST\n7\n1\n";
    let model = with(&format!(
        "{sets}*CONTACT_TIED_NODES_TO_SURFACE_ID\n1,seam\n5,6,4,0\n\n0,0,-2.5,0.0\n*SET_NODE_LIST\n\
         9\n11\n\
         *CONTACT_TIED_SHELL_EDGE_TO_SURFACE_BEAM_OFFSET\n9,7,4,2\n\n0,0,4.0,2.0\n"
    ));
    let [seam, edge] = [0, 1].map(|i| model.job.tie[i].clone());
    assert_eq!((seam.name.as_str(), seam.nodes.as_str(), seam.tolerance), ("seam", "set-5", 2.5));
    assert_eq!(set(&model, seam.faces.as_deref().unwrap()), [1, 2, 4, 5]);
    assert!(!seam.rotations && !seam.offset && seam.parts.is_empty());
    assert_eq!(
        (edge.name.as_str(), edge.parts.as_slice(), edge.thicknesses),
        ("tie-2", [1].as_slice(), [4.0, 2.0])
    );
    assert!(edge.rotations && edge.offset);
    let at = |id: u64| model.mesh.nodes.iter().find(|n| n.id.0 == id).unwrap().x[2];
    assert_eq!([at(11), at(12), at(15)], [2.0, 0.0, 0.0], "nodes are moved without an offset");
    let text = crumple::input::check::describe(&model);
    for said in [
        "tied         3 nodes, 1 with rotations, 1 with offset",
        "tie 1: tied nodes to surface -> displacements tied, nodes moved onto the surface",
        "tie 2: tied shell edge to surface, beam offset -> displacements, at the end of arms, and \
         rotations tied",
    ] {
        assert!(text.contains(said), "missing text: {said}\n{text}");
    }
}

/// A beam between two plates is tied to the middle of a shell of each by `*CONTACT_SPOTWELD`.
#[test]
fn spot_weld_contacts_tie_beams() {
    let model = with(
        "*NODE\n21,5,5,0\n22,5,5,2\n*PART\nweld\n3,3,2\n*SECTION_BEAM\n3,9,1.0,2,1.0\n5.0\n\
        *MAT_100\n\
        2,7.85e-6,207.0,0.3,0.4,2.0\n0.0,3.0,4.0,4.0\n*ELEMENT_BEAM\n21,3,21,22\n*SET_PART_LIST\n\
        8\n1,2\n\
        *CONTACT_SPOTWELD\n3,8,3,2\n\n\n",
    );
    let ties = &model.settings.ties;
    let carriers = |i: usize| ties[i].masters.iter().map(|c| (c.0.0, c.1)).collect::<Vec<_>>();
    assert_eq!(carriers(0), [(1, 0.25), (2, 0.25), (4, 0.25), (5, 0.25)]);
    assert_eq!(carriers(1), [(11, 0.25), (12, 0.25), (14, 0.25), (15, 0.25)]);
    assert!(ties.iter().all(|t| t.rotations && !t.offset));
}

#[test]
fn welds_are_bodies_or_beams_that_break() {
    let model = with(
        "*CONSTRAINED_SPOTWELD\n1,11\n3,13,3.0,2.0,1.0,4.0\n*NODE\n31,0,0,4\n\
        *CONSTRAINED_SPOTWELD_ID\n7\n11,12\n\
        *CONSTRAINED_GENERALIZED_WELD_SPOT\n5\n\n*SET_NODE_LIST\n5\n6,16\n",
    );
    let bodies: Vec<Vec<u64>> =
        model.settings.rigid.iter().map(|b| b.nodes.iter().map(|n| n.0).collect()).collect();
    assert_eq!(bodies, [vec![1, 11, 12], vec![6, 16]], "welds with a common node are one body");
    let part = &model.job.part[2];
    let beam = part.beam.clone().unwrap();
    let weld = beam.weld.unwrap();
    assert_eq!((part.id, part.material.as_str(), beam.section), (3, "mat-1", BeamSection::Tube));
    assert_eq!((beam.radius, weld.normal, weld.shear, weld.exponents), (1.0, 3.0, 2.0, [1.0, 4.0]));
    let beams: Vec<_> = model.mesh.elements.iter().filter(|e| e.part == 3).collect();
    assert_eq!(
        beams.iter().map(|e| e.corners().iter().map(|n| n.0).collect()).collect::<Vec<Vec<u64>>>(),
        [[3, 13]]
    );
}

#[test]
fn null_shells_are_skins() {
    let model = with("*PART\nskin\n3,1,2\n*MAT_NULL\n2,1.0e-9\n*ELEMENT_SHELL\n7,3,1,2,5,4\n");
    assert_eq!([0, 2].map(|i| model.job.part[i].skin), [false, true]);
    assert!(model.elements.stable_dt[4].is_infinite() && model.elements.mass[4] > 0.0);
    assert_eq!(model.job.units, "mm, ms, kg (guessed)", "null shells do not count");
    assert!(!model.warnings.iter().any(|w| w.message.contains("no solid")), "{:?}", model.warnings);
}

/// A plate on a skin, written as a deck and read back: the skin is a skin again, bit for bit.
#[test]
fn exported_skins_are_skins() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin.k");
    let lines = "*PART\nskin\n3,1,2\n*MAT_NULL\n2,1.0e-9\n*ELEMENT_SHELL\n7,3,1,2,5,4\n\
                 *CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n\n\n";
    let model = with(lines);
    fs::write(&path, crumple::input::deck::export::export(&model).unwrap().text).unwrap();
    let again = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!([0, 2].map(|i| again.job.part[i].skin), [false, true]);
    let run = |model: &Model| crumple_tests::run_side_by_side(model, 2, 50, 0).digest();
    assert_eq!(run(&model), run(&again));
    // The material of the skin matters: an elastic one gives a different result.
    assert_ne!(
        run(&model),
        run(&with(&lines.replace("MAT_NULL\n2,1.0e-9", "MAT_ELASTIC\n2,1.0e-9,1.0,0.3")))
    );
}

/// Two sections with one title are distinguished by their numbers.
#[test]
fn cross_sections_of_one_name_are_two() {
    let section =
        |id: u32, title: &str| format!("*DATABASE_CROSS_SECTION_SET_ID\n{id},{title}\n5,0,0,6\n");
    let lines = format!(
        "{}{}{}*SET_NODE_LIST\n5\n1,4\n*SET_SHELL_LIST\n6\n1\n",
        section(1, "rail"),
        section(2, "rail"),
        section(3, "door")
    );
    let names: Vec<String> =
        with(&lines).job.output.section.iter().map(|s| s.name.clone()).collect();
    assert_eq!(names, ["rail", "rail (2)", "door"]);
}

#[test]
fn node_sets_share_displacements() {
    let model = with("*CONSTRAINED_NODE_SET\n5,7\n*SET_NODE_LIST\n5\n13,3,2\n");
    let ties: Vec<_> =
        model.settings.ties.iter().map(|t| (t.node.0, t.masters[0].0.0, t.masters[0].1)).collect();
    assert_eq!(ties, [(3, 2, 1.0), (13, 2, 1.0)]);
    assert_eq!(
        model.mesh.nodes.iter().find(|n| n.id.0 == 13).unwrap().x,
        [20.0, 0.0, 2.0],
        "where it is"
    );
}
