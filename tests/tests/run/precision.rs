//! Single precision in elements: nearly the result of double precision, the same bits on any
//! number of workers.

use crumple::input::job::{self, Model};
use crumple_tests::{case, read, run_alone, run_side_by_side};

const SINGLE: &str = "elements.precision=single";

/// Returns a short coarse tube that folds onto itself.
fn tube(elements: usize, sets: &[&str]) -> Model {
    let elements = format!("scene.elements={elements}");
    let mut all = vec![elements.as_str()];
    all.extend(sets);
    read(&case("tube"), &all)
}

/// Buckling amplifies round-off and steps that are shorter by a 4096th. Eight runs in double
/// precision whose steps differ by 0.02 % have internal energies with a standard deviation of 7e-6
/// (3e-5 with 8 shells over a side). The bound is three times that of a difference of two runs.
#[test]
fn a_tube_folds_as_in_double_precision() {
    let [double, single] = [&[][..], &[SINGLE]].map(|sets| {
        let mut met = 0;
        let engine = run_alone(&tube(12, sets), |e| {
            met += e.contact.iter().map(|c| c.owned_pairs().count()).sum::<usize>()
        });
        assert!(met > 0, "there is contact between the folds");
        (engine.ledger.energies(&engine.nodes, &engine.blocks).values(), engine.clock.cycle)
    });
    let off = single.0.internal / double.0.internal - 1.0;
    assert!(
        double.0.internal > 100.0 && off.abs() < 3e-5 && off != 0.0,
        "{} J, off by {off:e}",
        double.0.internal
    );
    let cycles = single.1 as f64 / double.1 as f64 - 1.0;
    assert!((0.0..1e-3).contains(&cycles), "{} cycles, then {}", double.1, single.1);
}

#[test]
fn bits_do_not_depend_on_workers() {
    let model = tube(8, &[SINGLE]);
    let alone = run_side_by_side(&model, 1, 800, 0);
    for (workers, force_every) in [(2, 0), (3, 0), (3, 50)] {
        let trace = run_side_by_side(&model, workers, 800, force_every);
        assert_eq!(
            trace.digest(),
            alone.digest(),
            "{workers} workers, boxes renewed every {force_every} cycles"
        );
    }
    let double = run_side_by_side(&tube(8, &[]), 1, 800, 0);
    assert_ne!(double.digest(), alone.digest(), "the precision has an effect");
}

#[test]
fn a_wrong_precision_is_reported_with_the_valid_ones() {
    let sets = ["elements.precision=\"half\"".to_string()];
    let report =
        job::read(&case("tube"), &sets).err().expect("there is no such precision").to_string();
    for word in ["elements.precision", "half", "double", "single"] {
        assert!(report.contains(word), "no '{word}' in: {report}");
    }
}
