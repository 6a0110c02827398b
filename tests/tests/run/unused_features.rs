//! A scene has no cost for features that it does not use: solids have no rotations, and the
//! result is the same.

use crumple_tests::{case, read, run_side_by_side};
use std::ops::ControlFlow;

/// Half a can under a plate: solids in contact from the first cycles on.
#[test]
fn solids_without_rotations_move_as_with_them() {
    let mut model = read(&case("can-crush"), &[]);
    assert!(!model.settings.rotations, "the model has no rotations");
    let cycles = 40;
    let alone = run_side_by_side(&model, 1, cycles, 0);
    let parted = run_side_by_side(&model, 3, cycles, 7);
    model.settings.rotations = true;
    let turning = run_side_by_side(&model, 2, cycles, 0);
    assert_eq!(alone.digest(), parted.digest(), "workers exchange only forces");
    assert_eq!(alone.digest(), turning.digest(), "the columns of rotation were zero");
    assert_eq!(alone.pairs, turning.pairs);
}

#[test]
fn what_cannot_turn_has_no_columns_for_it() {
    let sizes = |scene: &str| {
        let model = read(&case(scene), &[]);
        let mut sizes = (0, 0);
        let look = |e: &mut crumple_worker::engine::Engine| {
            sizes = (e.blocks.bytes().moment, e.nodes.bytes()[1]);
            ControlFlow::Break(())
        };
        crumple::run::embedded::run_alone(&model, look).expect("one worker");
        sizes
    };
    assert_eq!(sizes("can-crush"), (0, 0));
    let (moment, turning) = sizes("bars");
    assert!(moment > 0 && turning > 0, "shells turn");
}
