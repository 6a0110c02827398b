//! `*CONTROL_ADAPTIVE`: `[adaptivity]` of the parts with adpopt 1. Units mm, ms, kg.

use crate::base::model_of;
use crumple::input::job::Model;

/// Returns a deck of two square shells, parts 1 and 2, of which part 1 has `adpopt`.
fn sheets(adpopt: u32, lines: &str) -> String {
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n0.1\n*PART\nfirst\n1,1,1,0,0,0,{adpopt}\n*PART\nsecond\n\
         2,1,1\n*SECTION_SHELL\n1,2,,5\n1.0,1.0,1.0,1.0\n\
         *MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.3,1.0\n\
         *NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n4,0,1,0\n5,1,1,0\n6,2,1,0\n\
         *ELEMENT_SHELL\n1,1,1,2,5,4\n2,2,2,3,6,5\n\
         *INITIAL_VELOCITY_GENERATION\n1,2,0,0,0,1.0\n{lines}"
    )
}

fn warnings(model: &Model) -> String {
    model.warnings.iter().map(|w| format!("{}\n", w.message)).collect()
}

#[test]
fn the_card_divides_the_parts_that_ask_for_it() {
    let card = "*CONTROL_ADAPTIVE\n0.01,4.0,2,3,0.02,0.08\n";
    let model = model_of(&sheets(1, card));
    let found = model.settings.adaptivity.expect("adaptivity");
    assert_eq!(found.parts, [0]);
    assert!((found.angle.to_degrees() - 4.0).abs() < 1e-12, "{}", found.angle);
    assert_eq!((found.levels, found.rings, found.interval), (2, 1, 0.01));
    assert_eq!(found.window, [0.02, 0.08]);
    assert!(found.kept.is_empty());
}

/// Without a part that asks for it, with another kind, with one level or where adaptivity does not
/// work, the mesh stays as it is, and a warning says so.
#[test]
fn what_is_not_possible_is_warned_of() {
    let damped = "*DAMPING_PART_MASS\n1,9,3.0\n*DEFINE_CURVE\n9\n0,1\n1,1\n";
    for (adpopt, card, why) in [
        (0, "0.01,4.0,2,3".to_string(), "no part has adpopt 1"),
        (1, "0.01,4.0,4,3".to_string(), "only adptyp 1 and 2"),
        (1, "0.01,,2,3".to_string(), "only adptyp 1 and 2"),
        (1, "0.01,4.0,2,1".to_string(), "maxlvl 1 has no refinement"),
        (1, format!("0.01,4.0,2,3\n{damped}"), "does not work with damping"),
    ] {
        let model = model_of(&sheets(adpopt, &format!("*CONTROL_ADAPTIVE\n{card}\n")));
        assert!(model.settings.adaptivity.is_none(), "{card}");
        assert!(warnings(&model).contains(why), "{card}: {}", warnings(&model));
    }
}
