//! Values of decks that stop nothing: cards for pre-processors, defaults, sections without parts,
//! times near the start. Units mm, ms, kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, model_of, with};
use super::fates::said;

/// A tree of parts is for pre-processors.
#[test]
fn a_tree_of_parts_is_not_read() {
    let all = said(&with("*SET_PART_TREE\n11\nfront\n-1,-2\n"));
    assert!(all.contains("*SET_PART_TREE is not read"), "{all}");
}

/// ihq 8 of the whole deck is for shells; that of a control that solids have is refused.
#[test]
fn an_hourglass_control_of_shells_leaves_solids_theirs() {
    let base = BASE.replace("1,2,1.0,3", "1,16,1.0,3");
    let model = model_of(&format!("{base}{STEEL}{MOVES}*CONTROL_HOURGLASS\n8,0.05\n"));
    let cube = model.job.part.iter().find(|part| part.id == 2).expect("the cube");
    assert_eq!(cube.parameters["hourglass_coefficient"].number(), Some(0.1), "the default");
    let words = "part 2: ihq 8 of *CONTROL_HOURGLASS is for shells";
    assert!(said(&model).contains(words), "{}", said(&model));
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,1,0,5\n");
    let own = format!("{base}{STEEL}{MOVES}*HOURGLASS\n5,8,0.1\n");
    assert_refused(&own, &["part 2: ihq 8 is not supported"]);
}

/// A tie that begins within a thousandth of the run is there from the start.
#[test]
fn a_tie_that_begins_at_once_is_there_from_the_start() {
    let tie = |birth: f64| {
        format!(
            "*CONTACT_TIED_NODES_TO_SURFACE_OFFSET\n9,2,4,3\n0,0,0,0,0,0,{birth}\n0,0,-5.0\n\
             *SET_NODE_LIST\n9\n11,12\n"
        )
    };
    let model = with(&tie(0.01));
    assert_eq!(model.job.tie.len(), 1);
    assert!(said(&model).contains("tied from the start"), "{}", said(&model));
    let late = format!("{BASE}{STEEL}{MOVES}{}", tie(0.02));
    assert_refused(&late, &["`bt` = 0.02"]);
}

/// Defaults that a card spells out, and sections that no part has, give no warning.
#[test]
fn defaults_and_unused_sections_are_no_warnings() {
    let lines = "*CONTACT_FORCE_TRANSDUCER_PENALTY\n1,0,3\n0,0,0,0,0,0,0,1e20\n\n\
                 *SECTION_SHELL\n9,2,1.0,5\n3.89,3.89,3.89,3.89\n\
                 *INITIAL_VELOCITY_GENERATION\n1,2,0,1.0\n0,0,0,0,1.0,0\n";
    let model = with(lines);
    let warnings: Vec<&str> = model.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(warnings.iter().all(|w| !w.contains("is not used")), "{warnings:?}");
    assert!(said(&model).contains("no part refers to it"), "{}", said(&model));
}
