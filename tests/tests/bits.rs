//! Bits do not depend on workers: the union of workers' pairs is the serial run's at every step, and the state is the
//! same to the last bit, however often and wherever boxes are cut.

use crumple_tests::{Trace, case, read, run_side_by_side};

/// Four tubes and three plates that fly at each other, tumbling.
fn tumble(workers: usize, cycles: u64, force_every: u64) -> Trace {
    run_side_by_side(&read(&case("tumble"), &[]), workers, cycles, force_every)
}

fn assert_same(serial: &Trace, parallel: &Trace, what: &str) {
    for (cycle, (a, b)) in serial.pairs.iter().zip(&parallel.pairs).enumerate() {
        assert_eq!(a, b, "{what}: pairs in cycle {cycle}");
    }
    assert_eq!(serial.pairs.len(), parallel.pairs.len(), "{what}: cycles");
    assert_eq!(serial.digest(), parallel.digest(), "{what}: state");
}

const CYCLES: u64 = 2500;

#[test]
fn union_of_workers_pairs_is_the_serial_runs() {
    let serial = tumble(1, CYCLES, 0);
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(met > 1000, "the bodies do meet: {met} pairs");
    for workers in [2, 3, 4, 7] {
        assert_same(&serial, &tumble(workers, CYCLES, 0), &format!("{workers} workers"));
    }
}

#[test]
fn forced_redecompositions_of_either_kind_change_no_bit() {
    let serial = tumble(1, CYCLES, 0);
    for workers in [2, 5] {
        let forced = tumble(workers, CYCLES, 7);
        assert!(forced.renewals >= CYCLES / 7);
        assert_same(&serial, &forced, &format!("{workers} workers, boxes renewed every 7 cycles"));
    }
}

/// A skin is there to save time: what a search collects beyond what touches changes nothing.
#[test]
fn how_far_candidates_are_collected_changes_no_bit() {
    for (name, cycles, skins) in [("tumble", CYCLES, ["0.1", "10"]), ("can-crush", 300, ["0.05", "20"])] {
        let run = |sets: &[&str]| run_side_by_side(&read(&case(name), sets), 1, cycles, 0);
        let default = run(&[]);
        assert!(default.pairs.iter().any(|p| !p.is_empty()), "{name}: nothing touches");
        for skin in skins {
            assert_same(&default, &run(&[&format!("contact.skin={skin}")]), &format!("{name}, skin {skin}"));
        }
    }
}
