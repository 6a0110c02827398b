//! The stable step of elements that keep their mass while area and thickness change.

use super::testing::{BOTH, FORMULATIONS, Noise, Patch, elastic, grid, part_of, triangles};
use crumple_proto::job::{Part, Precision};
use crumple_proto::mesh::OwnSection;

/// Returns a sheet of `n` by `n` squares of side 1, stretched by these factors in twenty steps.
fn stretched(
    of: Part,
    triangular: bool,
    nu: f64,
    n: usize,
    by: [f64; 2],
    precision: Precision,
) -> Patch {
    const STEPS: usize = 20;
    let (nodes, quads) = grid(n, n, n as f64, n as f64);
    let cells = if triangular { triangles(&quads) } else { quads };
    let mut patch = Patch::in_precision(precision, of, elastic(1.0, nu, 1.0), &nodes, &cells);
    patch.forces(0.0);
    for k in 1..=STEPS {
        let to = |k: usize, c: usize| 1.0 + (by[c] - 1.0) * k as f64 / STEPS as f64;
        let further = [0, 1].map(|c| to(k, c) / to(k - 1, c));
        patch.aim(1.0, |x| [x[0] * further[0], x[1] * further[1], x[2]], [0.0; 3]);
        patch.step(1.0);
    }
    let still = vec![[0.0; 4]; nodes.len()];
    (patch.v, patch.w) = (still.clone(), still);
    patch
}

/// Returns the masses before the stretch.
fn masses_at_first(of: Part, triangular: bool, nu: f64, n: usize) -> Vec<(f64, f64)> {
    stretched(of, triangular, nu, n, [1.0; 2], Precision::Double).masses()
}

/// A sheet that is stretched, held and brought back slowly by its rim does not vibrate: its nodes
/// are never much faster than the rim. Tension of half the modulus stiffens it transversely, which
/// the safety factor covers.
#[test]
fn a_stretched_sheet_does_not_swing_up() {
    const N: usize = 6;
    const HELD: usize = 400;
    const BACK: usize = 1000;
    for (element, triangular) in FORMULATIONS {
        for (thinning, t) in [(false, 0.1), (true, 0.1), (false, 2.0), (true, 2.0)] {
            let of = part_of(element, t).with("thinning", thinning);
            let masses = masses_at_first(of.clone(), triangular, 0.3, N);
            let mut patch = stretched(of, triangular, 0.3, N, [1.4; 2], Precision::Double);
            let mut noise = Noise(3);
            for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
                (0..3).for_each(|i| (v[i], w[i]) = (1e-6 * noise.next(), 1e-6 * noise.next()));
            }
            let rim =
                |node: usize| [node % (N + 1), node / (N + 1)].iter().any(|&i| i == 0 || i == N);
            let mut dt = 0.9 * patch.forces(0.0).stable_dt;
            let speed = 0.4 * N as f64 / (BACK as f64 * dt); // where the rim is fastest
            for step in 0..HELD + BACK {
                let totals = patch.explicit(
                    dt,
                    &masses,
                    |_| [0.0; 3],
                    |node, v, w| {
                        if rim(node) {
                            (*v, *w) = ([0.0; 4], [0.0; 4]);
                            let place = [node % (N + 1), node / (N + 1)];
                            if step >= HELD {
                                (0..2).for_each(|c| v[c] = -speed * place[c] as f64 / N as f64);
                            }
                        }
                    },
                );
                dt = dt.min(0.9 * totals.stable_dt);
                let fastest = patch.v.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
                assert!(
                    fastest < if step < HELD { 1e-4 } else { 5.0 * speed },
                    "{element}, thinning {thinning}, t {t}: {fastest} in step {step} of {dt}"
                );
            }
        }
    }
}

/// Returns the largest step for which a stretched sheet without stress is stable, over the stable
/// step of its elements.
fn critical(of: &Part, triangular: bool, nu: f64, n: usize, by: [f64; 2]) -> f64 {
    let masses = masses_at_first(of.clone(), triangular, nu, n);
    let grows = |factor: f64| {
        let mut patch = stretched(of.clone(), triangular, nu, n, by, Precision::Double);
        let each = patch.history.element(0).to_vec().len();
        for place in 0..patch.groups.len() / 4 {
            let state: Vec<f64> = (0..each)
                .map(|c| if c < 3 { patch.history.element(place).at(c) } else { 0.0 })
                .collect();
            patch.history.set(place, &state);
        }
        let mut noise = Noise(1);
        for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
            (0..3).for_each(|i| (v[i], w[i]) = (1e-12 * noise.next(), 1e-12 * noise.next()));
        }
        let dt = factor * patch.forces(0.0).stable_dt;
        for _ in 0..600 {
            patch.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| ());
        }
        !patch.v.iter().flatten().all(|v| v.abs() <= 1e-9)
    };
    let (mut low, mut high) = (0.5, 3.0);
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Bisection as in A23: stretched and compressed elements are stable for 0.9 of their step, as
/// undeformed ones are.
#[test]
fn stretched_and_pressed_elements_are_stable_at_their_step_with_the_usual_safety() {
    for (element, triangular) in FORMULATIONS {
        for by in [[1.4, 1.4], [2.0, 2.0], [2.0, 1.0], [3.0, 0.5], [0.6, 0.6]] {
            for (n, nu, t, thinning) in [
                (1, 0.3, 0.01, false),
                (1, 0.0, 0.01, true),
                (3, 0.3, 0.01, true),
                (1, 0.3, 0.5, true),
                (3, 0.3, 2.0, false),
            ] {
                let of = part_of(element, t).with("thinning", thinning);
                let limit = critical(&of, triangular, nu, n, by);
                assert!(
                    limit > 0.91,
                    "{element}: by {by:?}, {n} x {n}, nu {nu}, t {t}, thinning {thinning}: {limit}"
                );
            }
        }
    }
}

/// Shells with an offset of the middle surface are also stable, undeformed and stretched: fine
/// meshes, whose offset is long compared with their sides, and coarse ones.
#[test]
fn shells_with_an_offset_are_stable_at_their_step_with_the_usual_safety() {
    for (element, triangular) in FORMULATIONS {
        for offset in [1.0, -1.0, 4.0] {
            for (n, nu, t, by) in [
                (1, 0.3, 0.01, 1.0),
                (1, 0.0, 0.3, 1.0),
                (3, 0.3, 0.3, 1.0),
                (3, 0.3, 2.0, 1.0),
                (3, 0.0, 1.0, 1.0),
                (3, 0.3, 0.5, 1.4),
                (1, 0.3, 0.5, 0.6),
            ] {
                let of = Part { offset, ..part_of(element, t) }.with("thinning", true);
                let limit = critical(&of, triangular, nu, n, [by; 2]);
                let case = format!(
                    "{element}: offset {offset}, {n} x {n}, nu {nu}, t {t}, by {by}: {limit}"
                );
                assert!(limit > 0.91, "{case}");
                // A step that is far too short gives no growth for any factor.
                assert!(limit < 2.5, "{case}");
            }
        }
    }
}

/// The step of a sheet that is stretched depends on `sqrt(A0 t0/(A t))` in addition to its shape,
/// in both precisions and for all functions that return it.
#[test]
fn the_step_of_a_stretched_element_goes_with_the_mass_per_area() {
    for (element, triangular) in FORMULATIONS {
        for precision in BOTH {
            // Thick, so that its own inertia is enough for shear.
            let of = part_of(element, 4.0).with("thinning", true);
            let [patch, fresh] =
                [1.4, 1.0].map(|by| stretched(of.clone(), triangular, 0.3, 1, [by; 2], precision));
            let shape = patch.element.stable_dt(&patch.corners(0), OwnSection::default());
            let thickness = patch.fields(0).thickness;
            let now = patch.element.stable_dt_now(patch.history.element(0), &patch.corners(0));
            let wanted = shape * (4.0 / (1.96 * thickness)).sqrt();
            assert!(
                thickness < 3.9 && (now / wanted - 1.0).abs() < 1e-6,
                "{element}: {now} for {wanted}"
            );
            let mut patch = patch;
            let stable_dt = patch.forces(0.0).stable_dt;
            assert!(
                (stable_dt / now - 1.0).abs() < 1e-3,
                "{element}: {stable_dt} for {now}: slightly less in single precision"
            );
            let as_built = fresh.element.stable_dt_now(fresh.history.element(0), &fresh.corners(0));
            assert!(
                (as_built / fresh.element.stable_dt(&fresh.corners(0), OwnSection::default())
                    - 1.0)
                    .abs()
                    < 1e-6
            );
        }
    }
}
