//! Inverted shells are reported as trouble, or are deleted if their part allows it. NaN is reported
//! as trouble in either case.

use super::testing::{BOTH, FORMULATIONS, Patch, elastic, part_of, steel};
use crumple_proto::job::Precision;
use crumple_proto::partition::{Material, Param};

/// Returns two adjacent squares of side 1, or triangles; nodes 4 and 5 belong to the second one
/// alone.
fn pair(
    element: &str,
    triangular: bool,
    inverted: &str,
    steel: Material,
    precision: Precision,
) -> Patch {
    let nodes = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
    ];
    let cells =
        if triangular { [[0, 1, 2, 2], [1, 4, 5, 5]] } else { [[0, 1, 2, 3], [1, 4, 5, 2]] };
    let part = part_of(element, 0.1).with("inverted", inverted).with("thinning", true);
    let mut patch = Patch::in_precision(precision, part, steel, &nodes, &cells);
    assert_eq!(patch.forces(0.0).trouble, None);
    patch
}

/// Moves the far side of the second shell to this x in one step of 1, and stops it there.
fn fold(patch: &mut Patch, to: f64) -> super::testing::Passed {
    patch.aim(1.0, |x| [if x[0] > 1.5 { to } else { 1.0001 * x[0] }, x[1], x[2]], [0.0; 3]);
    let totals = patch.step(1.0);
    patch.v.fill([0.0; 4]);
    totals
}

/// Fold onto a line, and through it.
const FOLDS: [f64; 2] = [1.0, 0.8];

#[test]
fn an_inverted_shell_is_trouble_unless_its_part_lets_it_fail() {
    for ((element, triangular), precision) in
        FORMULATIONS.into_iter().flat_map(|f| BOTH.map(|p| (f, p)))
    {
        for to in FOLDS {
            let sheet = elastic(210.0, 0.3, 7.85e-6);
            let mut stops = pair(element, triangular, "stop", sheet.clone(), precision);
            assert_eq!(fold(&mut stops, to).trouble, Some(1), "{element} {to}");
            assert!(!stops.element.can_fail() && !stops.element.failed(stops.history.element(1)));

            let mut patch = pair(element, triangular, "delete", sheet, precision);
            let healthy = patch.forces(0.0).stable_dt;
            for step in 0..3 {
                let totals = if step == 0 { fold(&mut patch, to) } else { patch.step(1.0) };
                assert_eq!(totals.trouble, None, "{element} {to}");
                assert!(totals.internal.is_finite() && totals.hourglass.is_finite());
                assert!(
                    totals.stable_dt > 0.9 * healthy && totals.stable_dt < 1.1 * healthy,
                    "stable step of the other element"
                );
                let at = |i: usize| {
                    (
                        patch.element.failed(patch.history.element(i)),
                        patch.element.is_deleted(patch.history.element(i)),
                    )
                };
                assert_eq!([at(0), at(1)], [(false, false), (true, true)]);
                for corner in 0..4 {
                    assert_eq!(
                        patch.corner(1, corner),
                        ([0.0; 3], [0.0; 3]),
                        "{element}: the deleted element has no forces"
                    );
                }
                assert!(
                    patch.largest().0 > 0.0 && patch.largest().0.is_finite(),
                    "the other element has forces from its strain"
                );
                assert!(
                    !patch.element.is_unstrained(patch.history.element(1)),
                    "its stable step must not be computed"
                );
                assert!(
                    patch.history.element(1).to_vec().iter().all(|c| c.is_finite()),
                    "the history that migrates is finite"
                );
                assert!(patch.fields(1).failed && !patch.fields(0).failed);
            }
        }
    }
}

#[test]
fn numbers_that_are_none_are_trouble_even_where_inverted_shells_may_fail() {
    for ((element, triangular), precision) in
        FORMULATIONS.into_iter().flat_map(|f| BOTH.map(|p| (f, p)))
    {
        for what in 0..3 {
            let sheet = elastic(210.0, 0.3, 7.85e-6);
            let mut patch = pair(element, triangular, "delete", sheet, precision);
            let column = [&mut patch.x, &mut patch.v, &mut patch.w].into_iter().nth(what).unwrap();
            column[4][1] = f64::NAN;
            assert_eq!(patch.forces(1.0).trouble, Some(1), "{element}, column {what}");
            assert!(!patch.element.failed(patch.history.element(1)));
        }
        // NaN stress in a shell of valid shape: an error of the law, or of a restored state.
        let mut patch =
            pair(element, triangular, "delete", elastic(210.0, 0.3, 7.85e-6), precision);
        let mut state = patch.history.element(0).to_vec();
        state[6] = f64::NAN;
        patch.history.set(0, &state);
        assert_eq!(patch.forces(1.0).trouble, Some(0), "{element}: a stress");
    }
}

/// Elements that failed by their law before are not counted as inverted.
#[test]
fn elements_failed_by_their_law_are_not_inverted() {
    for (element, triangular) in FORMULATIONS {
        let brittle = steel(
            "j2",
            &[("yield_stress", Param::Number(0.25)), ("failure_strain", Param::Number(0.1))],
        );
        let mut patch = pair(element, triangular, "delete", brittle, Precision::Double);
        for _ in 0..10 {
            patch.aim(1.0, |x| [if x[0] > 1.5 { 1.03 * x[0] } else { x[0] }, x[1], x[2]], [0.0; 3]);
            patch.step(1.0);
        }
        assert!(patch.element.failed(patch.history.element(1)), "{element}");
        assert_eq!(fold(&mut patch, 1.0).trouble, None);
        assert!(
            patch.element.failed(patch.history.element(1))
                && !patch.element.is_deleted(patch.history.element(1)),
            "{element}"
        );
    }
}

/// A shell is deleted in the first step in which its stable step is below that of its part: the
/// same shell of a part without one shows which step that is.
#[test]
fn shells_are_deleted_below_the_step_of_their_part() {
    for ((element, triangular), precision) in
        FORMULATIONS.into_iter().flat_map(|f| BOTH.map(|p| (f, p)))
    {
        let sheet = || elastic(210.0, 0.3, 7.85e-6);
        let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let cell = if triangular { [0, 1, 2, 2] } else { [0, 1, 2, 3] };
        let of = |part| Patch::in_precision(precision, part, sheet(), &nodes, &[cell]);
        let mut whole = of(part_of(element, 0.1));
        let least = 0.8 * whole.forces(0.0).stable_dt;
        let mut patch = of(part_of(element, 0.1).with("deletion_step", least));
        let shrink = |x: [f64; 3]| [0.98 * x[0], x[1], x[2]];
        let mut steps = 0;
        loop {
            let [kept, own] = [&mut whole, &mut patch].map(|p| p.go(shrink));
            steps += 1;
            let failed = patch.element.is_deleted(patch.history.element(0));
            assert_eq!(failed, kept.stable_dt < least, "{element}, step {steps}");
            if failed {
                assert_eq!((own.stable_dt, own.trouble), (f64::INFINITY, None));
                assert_eq!(patch.largest().0, 0.0);
                break;
            }
            assert_eq!(own.stable_dt, kept.stable_dt, "{element}");
            assert!(steps < 60, "{element} must be deleted");
        }
        assert!(steps > 5, "{element}: {steps}");
        assert_eq!(patch.go(shrink).stable_dt, f64::INFINITY, "{element}: it stays deleted");
    }
}
