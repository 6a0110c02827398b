//! Contact inside of solids in decks: which parts have it, and a block that is crushed.

use crate::base::{BASE, MOVES, STEEL, model_of, report_of, with};
use crumple::input::job::Model;
use crumple_proto::job::Setting;
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// Returns the value of a part, if it has one.
fn of_part(model: &Model, id: u32) -> Option<Vec<f64>> {
    let part = model.job.part.iter().find(|part| part.id == id).expect("a part");
    part.parameters.get("interior_contact").map(|value| match value {
        Setting::List(list) => list.clone(),
        other => panic!("{other:?}"),
    })
}

/// Attributes of the set are factor and fraction; only deformable solids have the contact.
#[test]
fn parts_of_solids_have_it() {
    let model = with("*SET_PART_LIST\n4\n1,2\n*CONTACT_INTERIOR\n4\n");
    assert_eq!([of_part(&model, 1), of_part(&model, 2)], [None, Some(vec![0.1, 1.0])]);
    let said: String =
        model.mapping.iter().map(|m| format!("{}: {} -> {}\n", m.of, m.asked, m.used)).collect();
    assert!(said.contains("part 1: contact inside of solids -> not used"), "{said}");
    let model = with("*SET_PART_LIST\n4,0.5,0.2,3.0,2.0\n2\n*CONTACT_INTERIOR\n4\n");
    assert_eq!(of_part(&model, 2), Some(vec![0.2, 0.5]));
    let said: String = model.mapping.iter().map(|m| m.asked.clone() + "\n").collect();
    assert!(said.contains("with the modulus 3, also in shear"), "{said}");
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    let set = "*SET_PART_LIST\n4\n2\n*CONTACT_INTERIOR\n4\n";
    let rigid = model_of(&format!("{base}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,200,0.3\n{set}"));
    assert_eq!(of_part(&rigid, 2), None);
    let missing = report_of(&format!("{BASE}{STEEL}{MOVES}*CONTACT_INTERIOR\n9\n"));
    assert!(missing.contains("SET_PART"), "{missing}");
    let wide = "*SET_PART_LIST\n4,1.0,1.5\n2\n*CONTACT_INTERIOR\n4\n";
    let report = report_of(&format!("{BASE}{STEEL}{MOVES}{wide}"));
    assert!(report.contains("begins at 1.5 of the volume"), "{report}");
}

/// A soft block under a heavy mass turns inside out; with the contact it is crushed to a few
/// percent of its volume, and keeps its energy.
#[test]
fn a_crushed_block_does_not_turn_inside_out() {
    let deck = "*KEYWORD\n*CONTROL_TERMINATION\n2.0\n*PART\nblock\n1,1,1\n*SECTION_SOLID\n1,1\n\
         *MAT_ELASTIC\n1,1.0e-7,1.0e-3,0.0\n*NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n\
         5,0,0,10\n6,10,0,10\n7,10,10,10\n8,0,10,10\n*ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n\
         *ELEMENT_MASS\n5,5,0.01\n6,6,0.01\n7,7,0.01\n8,8,0.01\n*SET_NODE_LIST\n1\n1,2,3,4\n\
         *SET_NODE_LIST\n2\n5,6,7,8\n*BOUNDARY_SPC_SET\n1,0,1,1,1,1,1,1\n\
         *BOUNDARY_SPC_SET\n2,0,1,1,0,1,1,1\n*INITIAL_VELOCITY\n2\n0,0,-10.0\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let result = |more: &str| {
        fs::write(&path, format!("{deck}{more}*END\n")).unwrap();
        run(crumple_with(&["run", path.to_str().unwrap(), "--set", "output.field_interval=-1"]))
    };
    let alone = result("").with_code(3);
    assert!(alone.said().contains("about to invert"), "{}", alone.said());
    let with = result("*SET_PART_LIST\n4,20.0\n1\n*CONTACT_INTERIOR\n4\n").with_code(0);
    assert!(with.said().contains("NORMAL TERMINATION"), "{}", with.said());
    let error = with.history().column("energy error [-]");
    let most = error.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    // The step falls with the square of the volume.
    assert!(most < 0.02, "{most}");
}
