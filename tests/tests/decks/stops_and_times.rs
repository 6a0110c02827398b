//! Stops of rigid bodies, walls with birth and death, preloads of beams, sensors, and contact
//! inside of solids.

use super::base::{
    BASE, MOVES, STEEL, assert_same_when_written, model_of, refused, report_of, with,
};
use crumple::input::check::describe;

/// The plate of the base as a rigid body, part 1.
const RIGID: &str = "*MAT_RIGID\n9,7.85e-6,207.0,0.3\n";

/// Returns the base with a rigid plate and these lines.
fn rigid(lines: &str) -> String {
    let base = BASE.replace("plate\n1,1,1\n", "plate\n1,1,9\n");
    format!("{base}{STEEL}{RIGID}{MOVES}{lines}")
}

const BOUNDS: &str = "*DEFINE_CURVE\n5\n0,1.5\n20,1.5\n*DEFINE_CURVE\n6\n0,-2.5\n20,-2.5\n";

/// Each bound of a card has its form; vectors have a tail and a head.
#[test]
fn stoppers_become_stops_of_the_body() {
    let text = rigid(&format!(
        "{BOUNDS}*CONSTRAINED_RIGID_BODY_STOPPERS\n1,-5,-6,0,0,0,3\n0.5,8.0\n1,5,-6,0,0,0,4,7\n\n\
         *DEFINE_VECTOR\n7,1,1,1,4,5,1\n"
    ));
    let model = model_of(&text);
    let stops = &model.job.rigid[0].stop;
    let found: Vec<_> = stops
        .iter()
        .map(|s| {
            (s.direction, s.lower.as_deref(), s.upper.as_deref(), s.position, s.birth, s.death)
        })
        .collect();
    let (five, six) = (Some("curve-5"), Some("curve-6"));
    let along = [3.0, 4.0, 0.0];
    assert_eq!(
        found,
        [
            ([0.0, 0.0, 1.0], six, five, false, 0.5, Some(8.0)),
            (along, six, None, false, 0.0, None),
            (along, None, five, true, 0.0, None),
        ]
    );
    let resolved = &model.settings.rigid[0].stops;
    assert_eq!(resolved[0].window, Some([0.5, 8.0]));
    assert_eq!(resolved[1].direction, [0.6, 0.8, 0.0]);
    assert_eq!(resolved[1].window, None);
}

/// A stopper that the engine lacks is refused with a cure, and a wrong one names its place.
#[test]
fn other_stoppers_are_refused() {
    let card = |fields: &str| format!("{BOUNDS}*CONSTRAINED_RIGID_BODY_STOPPERS\n{fields}\n\n");
    for (fields, words) in [
        ("1,-5,0,0,0,0,6", "`dir` = 6 is not supported: a stop of a rotation"),
        ("1,-5,0,3,0,0,1", "`psidmx` = 3 is not supported: bodies that stop when"),
        ("1,-5,0,0,3,0,1", "`psidmn` = 3 is not supported: bodies that stop when"),
        ("1,-5,0,0,0,5,1", "`lcvmnx` = 5 is not supported: a limit of the velocity"),
        ("1,-5,0,0,0,0,4,9", "there is no *DEFINE_VECTOR with the id 9"),
        ("2,-5,0,0,0,0,1", "there is no rigid part with the id 2"),
        ("1,-8,0,0,0,0,1", "there is no *DEFINE_CURVE with the id 8"),
        ("1,-6,0,0,0,0,1", "does not admit the place at the start: `upper` is -2.5"),
        ("1,0,-5,0,0,0,1", "does not admit the place at the start: `lower` is 1.5"),
    ] {
        let report = super::base::report_of(&rigid(&card(fields)));
        assert!(report.contains(words), "{fields}: {report}");
    }
    let report = super::base::report_of(&rigid(&format!(
        "{BOUNDS}*CONSTRAINED_RIGID_BODY_STOPPERS\n1,-5,0,0,0,0,1\n4.0,3.0\n"
    )));
    assert!(report.contains("begins at 4.0 and ends at 3.0"), "{report}");
    let none = format!("{}*DEFINE_VECTOR\n7,1,1,1,1,1,1\n", card("1,-5,0,0,0,0,4,7"));
    let report = super::base::report_of(&rigid(&none));
    assert!(report.contains("has no direction") && report.contains("deck.k"), "{report}");
    let held = rigid(&card("1,-5,0,0,0,0,3")).replace("0.3\n*INITIAL", "0.3\n1,3,0\n*INITIAL");
    let report = super::base::report_of(&held);
    assert!(report.contains("a direction in which the body cannot move"), "{report}");
    let model = model_of(&rigid(&card("1,0,0,0,0,0,1")));
    assert!(model.warnings.iter().any(|w| w.message.contains("it has no bound")));
}

/// A deck that is written from stops and walls with times gives the same bits.
#[test]
fn stops_and_times_are_written_as_cards() {
    assert_same_when_written(
        &rigid(&format!(
            "*INITIAL_VELOCITY\n0\n3.0,1.0,0.0\n{BOUNDS}*CONSTRAINED_RIGID_BODY_STOPPERS\n\
             1,-5,-6,0,0,0,4,7\n0.1,0.9\n*DEFINE_VECTOR\n7,0,0,0,3,4,0.1\n"
        )),
        "end_time=1.0",
        "*CONSTRAINED_RIGID_BODY_STOPPERS",
    );
    for wall in [
        "*RIGIDWALL_PLANAR_ID\n3,floor\n0,0,0,0,0.3,0.7\n10.3,0,0,9,0,0,0.1\n",
        "*RIGIDWALL_GEOMETRIC_SPHERE_ID\n3,ball\n0,0,0,0.3,0.7\n22,0,12,9,0,0,0.1\n1.5\n",
    ] {
        assert_same_when_written(
            &format!("{BASE}{STEEL}*INITIAL_VELOCITY\n0\n5.0\n{wall}"),
            "end_time=1.0",
            "0.7",
        );
    }
}

/// Birth and death of all walls of the format, and of the faces of a box.
#[test]
fn walls_have_birth_and_death() {
    for (card, faces) in [
        ("*RIGIDWALL_PLANAR\n0,0,0,0,2.0,7.0\n50,0,0,9,0,0\n", 1),
        ("*RIGIDWALL_GEOMETRIC_SPHERE\n0,0,0,2.0,7.0\n50,0,0,9,0,0\n3.0\n", 1),
        ("*RIGIDWALL_GEOMETRIC_CYLINDER\n0,0,0,2.0,7.0\n50,0,0,9,0,0\n3.0\n", 1),
        ("*RIGIDWALL_GEOMETRIC_PRISM\n0,0,0,2.0,7.0\n50,0,0,9,0,0\n50,1,0,3,3,3\n", 6),
    ] {
        let model = with(card);
        assert_eq!(model.job.wall.len(), faces);
        for (wall, resolved) in model.job.wall.iter().zip(&model.settings.walls) {
            assert_eq!((wall.birth, wall.death), (2.0, Some(7.0)), "{card}");
            assert_eq!(resolved.window, Some([2.0, 7.0]), "{card}");
        }
    }
    // A death after the run is none.
    let model = with("*RIGIDWALL_PLANAR\n0,0,0,0,0,99.0\n50,0,0,9,0,0\n");
    assert_eq!(model.settings.walls[0].window, None);
    let report = refused("*RIGIDWALL_PLANAR\n0,0,0,0,5.0,3.0\n50,0,0,9,0,0\n");
    assert!(report.contains("a wall begins at 5.0 and ends at 3.0"), "{report}");
    assert!(report.contains("deck.k"), "{report}");
}

/// Beams 31 and 32 of part 3, and 33 of part 4.
const BEAMS: &str = "*PART\nbolts\n3,3,1\nbars\n4,4,1\n*SECTION_BEAM\n3,9\n2.0,2.0\n\
    *SECTION_BEAM\n4,3\n1.5\n*ELEMENT_BEAM\n31,3,1,5\n32,3,2,6\n33,4,3,7\n\
    *DEFINE_CURVE\n5\n0,0\n1,0.1\n2,0.1\n";

#[test]
fn axial_forces_become_preloads_of_parts() {
    let card = |set: &str, kbend: &str| {
        format!("{BEAMS}{set}*INITIAL_AXIAL_FORCE_BEAM\n8,5,2.0,{kbend}\n")
    };
    let list = "*SET_BEAM\n8\n31,32\n";
    for (set, kbend, bending) in
        [(list, "0", false), (list, "1", true), ("*SET_BEAM_GENERATE\n8\n31,32\n", "2", true)]
    {
        let model = with(&card(set, kbend));
        let part = model.job.part.iter().find(|p| p.id == 3).unwrap();
        let beam = part.beam.as_ref().unwrap();
        assert_eq!(beam.preload, [[0.0, 0.0], [1.0, 0.2], [2.0, 0.2]]);
        assert_eq!(beam.preload_bending, bending);
        assert!(describe(&model).contains("starts with a preload"));
    }
    // The exported deck keeps the curve in comments.
    assert_same_when_written(
        &format!("{BASE}{STEEL}{MOVES}{}", card(list, "1")),
        "end_time=0.05",
        "preload_bending",
    );
    for (set, words) in [
        ("*SET_BEAM\n8\n31\n", "1 of the 2 beams of part 3"),
        ("*SET_BEAM\n8\n33\n", "the beams of part 4 are trusses or discrete beams"),
        ("*SET_BEAM\n8\n77\n", "set 8 has no beams of the deck"),
        ("*SET_BEAM\n9\n31,32\n", "there is no *SET_BEAM with the id 8"),
    ] {
        let report = refused(&card(set, "0"));
        assert!(report.contains(words), "{set}: {report}");
    }
    let twice = refused(&format!("{}*INITIAL_AXIAL_FORCE_BEAM\n8,5\n", card(list, "0")));
    assert!(twice.contains("the beams of part 3 have two preloads"), "{twice}");
    let both = card(list, "0").replace("1,0.1\n", "1,-0.1\n");
    let report = refused(&both);
    assert!(report.contains("its preload goes from -0.2 to 0.2"), "{report}");
    let plastic = "*MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.15\n";
    let report = report_of(&format!("{BASE}{plastic}{MOVES}{}", card(list, "0")));
    assert!(report.contains("reaches 0.2, and its material yields at 0.15"), "{report}");
}

const WALL: &str = "*RIGIDWALL_PLANAR_ID\n3,floor\n\n50,0,0,9,0,0\n";

/// A switch of time gives a wall or a contact its birth and death.
#[test]
fn sensors_of_time_switch_walls_and_contacts() {
    let switches = "*SENSOR_SWITCH\n1,TIME,0,GT,2.0\n2,TIME,0,GT,5.0,0,1.0,0.5\n";
    let control = |of: &str, first: &str, own: &str| {
        format!("{switches}*SENSOR_CONTROL\n10,{of},3\n{first},{own}\n")
    };
    for (first, own, birth, death) in [
        ("ON", "1", 0.0, Some(2.0)),
        ("OFF", "1", 2.0, None),
        ("OFF", "1,2", 2.0, Some(6.5)),
        ("ON", "", 0.0, None),
    ] {
        let model = with(&format!("{WALL}{}", control("RWALL", first, own)));
        let wall = &model.job.wall[0];
        assert_eq!((wall.birth, wall.death), (birth, death), "{first} {own}");
        assert!(describe(&model).contains("*SENSOR_CONTROL 10"), "{}", describe(&model));
    }
    let contact = "*CONTACT_AUTOMATIC_SINGLE_SURFACE_ID\n3,all\n0,0,5\n0.1,0.1\n\n";
    let model = with(&format!("{contact}{}", control("CONTACT", "OFF", "1,2")));
    let contact = model.job.contact.as_ref().unwrap();
    assert_eq!((contact.birth, contact.death), (2.0, Some(6.5)));
}

/// Every other control is an error that names what it would have switched and by what.
#[test]
fn other_sensors_are_named_with_what_they_would_switch() {
    let sensors = "*SENSOR_DEFINE_NODE\n4,11,12,,,VEL\n*SENSOR_SWITCH\n1,SENSOR,4,GT,2.5\n\
                   2,TIME,0,LT,5.0\n3,TIME,0,GT,5.0\n*SENSOR_SWITCH_CALC-LOGIC\n6,1,-2\n";
    for (card, words) in [
        (
            "7,RWALL,3\nON,1",
            "*SENSOR_CONTROL 7: rigid wall 3, on at the start, would be switched by switch 1 \
             (*SENSOR_DEFINE_NODE 4 > 2.5)",
        ),
        ("7,RWALL,3\nON,2", "switch 2 (time < 5)"),
        ("7,RWALL,99\nON,3", "rigid wall 99, on at the start"),
        ("7,RWALL,3,,2\nON,3", "by switch 3 (time > 5)"),
        (
            "7,JOINT,8\nOFF,3,6",
            "joint 8, off at the start, would be switched by switch 3 (time > 5)",
        ),
        ("7,JOINT,8\nOFF,3,6", "then switch 6 (a combination of the switches 1, -2)"),
        ("7,SPC,8\nON,9", "switch 9, which is not in the deck"),
        ("7,BELTPRET,8\nOFF,1", "BELTPRET 8, off at the start"),
    ] {
        let report = refused(&format!("{WALL}{sensors}*SENSOR_CONTROL\n{card}\n"));
        let flat = report.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(words), "{card}: {report}");
    }
    let allowed = super::base::read_with(
        &["mesh.allow_unsupported=true"],
        &format!("{WALL}{sensors}*SENSOR_CONTROL\n7,RWALL,3\nON,1\n"),
    );
    let said: String =
        allowed.warnings.iter().map(|w| format!("{} {}\n", w.message, w.help)).collect();
    assert!(said.contains("rigid wall 3 acts as its own card says, in the whole run"), "{said}");
    assert_eq!((allowed.job.wall[0].birth, allowed.job.wall[0].death), (0.0, None));
}
