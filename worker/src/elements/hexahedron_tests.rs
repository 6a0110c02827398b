//! What a one-point hexahedron has to do: rigid motion, patches, balance, energy, lanes.

use super::super::solid_testing::*;
use super::super::testing::*;
use super::*;

use crumple_proto::job::HourglassForm;

const E: f64 = 1e6;
const NU: f64 = 0.25;
const FORMS: [HourglassForm; 3] = [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain];

/// A unit cube of eight elements, all of whose inner and face nodes are out of place if `by` is not nought.
fn distorted(by: f64) -> (Vec<[f64; 3]>, Vec<[u32; 8]>) {
    let (mut nodes, cells) = block([2, 2, 2], [1.0; 3]);
    let mut noise = Noise(11);
    nodes.iter_mut().flatten().for_each(|c| *c += by * noise.next());
    (nodes, cells)
}

fn cubes(hourglass: HourglassForm, by: f64) -> Solids {
    let (nodes, cells) = distorted(by);
    Solids::new(solid_part(hourglass, Some(0.1)), elastic(E, NU, 1.0), &nodes, &cells)
}

fn shake(solids: &mut Solids, noise: &mut Noise, size: f64) {
    solids.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = size * noise.next()));
}

/// The volume and the mean gradient against what defines them.
#[test]
fn gradient_is_the_derivative_of_the_volume() {
    let mut noise = Noise(2);
    let mut x: [[f64; 3]; 8] =
        block([1, 1, 1], [1.0, 2.0, 0.5]).1[0].map(|n| block([1, 1, 1], [1.0, 2.0, 0.5]).0[n as usize]);
    assert_close(Gradient::new(&modes_of_corners(&x)).volume(), 1.0, 1e-15, "round-off");
    x.iter_mut().flatten().for_each(|c| *c += 0.2 * noise.next());
    let modes = modes_of_corners(&x);
    // Gauss points of 2 x 2 x 2 integrate the Jacobian exactly: it is quadratic in each coordinate.
    let point = 1.0 / 3.0_f64.sqrt();
    let mut volume = 0.0;
    for gauss in 0..8_usize {
        let [a, b, c] = [0, 1, 2].map(|bit| if gauss >> bit & 1 == 1 { point } else { -point });
        let along = |terms: [(usize, f64); 4]| -> [f64; 3] {
            std::array::from_fn(|i| terms.iter().map(|&(k, f)| 0.125 * f * modes[k][i]).sum())
        };
        let xi = along([(0, 1.0), (4, c), (5, b), (6, b * c)]);
        let eta = along([(1, 1.0), (3, c), (5, a), (6, a * c)]);
        let zeta = along([(2, 1.0), (3, b), (4, a), (6, a * b)]);
        volume += dot(xi, crate::lanes::cross(eta, zeta));
    }
    let gradient = Gradient::new(&modes);
    assert_close(gradient.volume(), volume, 1e-14, "round-off");
    // b by differences of a cubic: central ones leave the third derivative, at h^2.
    let h = 1e-5;
    for c in 0..8 {
        for i in 0..3 {
            let volume = |by: f64| {
                let mut moved = x;
                moved[c][i] += by;
                Gradient::new(&modes_of_corners(&moved)).volume()
            };
            let mut unit = [[0.0; 3]; 8];
            unit[c][i] = 1.0;
            let exact = gradient.of(&modes_of_corners(&unit))[i][i] * gradient.volume();
            assert_close((volume(h) - volume(-h)) / (2.0 * h), exact, 1e-10, "round-off over 1e-5");
        }
    }
    // And it is exact for linear fields.
    let k = gradient.of(&modes_of_corners(&x.map(|p| [2.0 * p[0] + p[2], p[1], 3.0 * p[0]])));
    let wanted = [[2.0, 0.0, 1.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]];
    k.iter().flatten().zip(wanted.iter().flatten()).for_each(|(k, w)| assert_close(*k, *w, 1e-14, "round-off"));
}

/// Verification A19 (a): no stress at 90, 180 and 360 degrees, whatever the angle of a step.
#[test]
fn rigid_rotation_leaves_no_stress() {
    for form in FORMS {
        for (steps, axis) in
            [(100, [0.0, 0.0, 1.0]), (100, [0.48, -0.64, 0.6]), (1000, [0.6, 0.0, 0.8]), (4, [1.0, 0.0, 0.0])]
        {
            let mut solids = cubes(form, 0.1);
            let angle = axis.map(|c| c * std::f64::consts::TAU / f64::from(steps));
            for step in 1..=steps {
                solids.go(|x| rotate(angle, x.map(|c| c + 0.01)));
                if [steps / 4, steps / 2, steps].contains(&step) {
                    for element in 0..8 {
                        let largest = solids.fields(element).stress.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
                        assert!(largest < 1e-10 * E, "the catalogue's bound: step {step} of {steps}: {largest:e}");
                    }
                    assert!(solids.largest() < 1e-10 * E, "step {step} of {steps}: force {:e}", solids.largest());
                }
            }
        }
    }
}

/// Verification A19 (b): stress turns with the body.
#[test]
fn stress_turns_with_the_body() {
    let angle = [0.3, -0.5, 0.2];
    for form in FORMS {
        let mut solids = cubes(form, 0.1);
        solids.go(|x| [1.001 * x[0] + 0.002 * x[1], x[1] - 0.001 * x[2], 0.9995 * x[2]]);
        let before: Vec<_> = (0..8).map(|e| solids.fields(e)).collect();
        let forces = solids.nodal();
        (0..30).for_each(|_| _ = solids.go(|x| rotate(angle, x)));
        for (e, before) in before.iter().enumerate() {
            let after = solids.fields(e);
            assert_close(after.von_mises, before.von_mises, 1e-10 * before.von_mises, "the catalogue's bound");
            let trace = |s: [f64; 6]| s[0] + s[1] + s[2];
            assert_close(trace(after.stress), trace(before.stress), 1e-10 * before.von_mises, "the catalogue's bound");
        }
        // The forces turn too, hourglass resistance with them; viscous resistance ends with its rate.
        if form != HourglassForm::Viscous {
            let largest = solids.largest();
            for (after, before) in solids.nodal().into_iter().zip(forces) {
                let wanted = (0..30).fold(before, |f, _| rotate(angle, f));
                (0..3).for_each(|i| assert_close(after[i], wanted[i], 1e-10 * largest, "the catalogue's bound"));
            }
        }
    }
}

/// Verification A21: u = 1e-3 (2 x + y + z)/2 and so on give 2000 and 400 in every distorted element.
#[test]
fn distorted_patch_is_exact() {
    for form in FORMS {
        let mut solids = cubes(form, 0.1);
        let size = 1e-12;
        for (v, x) in solids.v.iter_mut().zip(&solids.x) {
            let half = 0.5 * size * (x[0] + x[1] + x[2]);
            (0..3).for_each(|i| v[i] = half + 0.5 * size * x[i]);
        }
        solids.forces(1.0);
        for element in 0..8 {
            let stress = solids.fields(element).stress.map(|s| s * 1e-3 / size);
            for c in 0..6 {
                let wanted = if c < 3 { 2000.0 } else { 400.0 };
                assert_close(stress[c], wanted, 1e-10 * wanted, "round-off, and a strain of 1e-12");
            }
        }
        let inner = solids.nodal()[13];
        let largest = solids.largest();
        assert!(
            inner.iter().all(|f| f.abs() < 1e-10 * largest),
            "the middle node is in balance: {inner:?} of {largest}"
        );
    }
}

#[test]
fn forces_and_moments_balance_and_do_the_work_that_is_booked() {
    for form in FORMS {
        let mut noise = Noise(5);
        let mut solids = cubes(form, 0.15);
        let dt = 1e-3;
        let (mut work, mut booked, mut hourglass, mut peak) = (0.0, 0.0, 0.0, 0.0_f64);
        shake(&mut solids, &mut noise, 0.02);
        for step in 0..1000 {
            // Back and forth, so that strain stays small and hourglass modes move.
            if step == 500 {
                solids.v.iter_mut().flatten().for_each(|v| *v = -*v);
            }
            let before = solids.power();
            let totals = solids.step(dt);
            work += 0.5 * dt * (before + solids.power());
            booked += totals.internal + totals.hourglass;
            hourglass += totals.hourglass;
            peak = peak.max(booked);
            let (force, moment) = solids.sums();
            let largest = solids.largest();
            assert!(
                force.iter().chain(&moment).all(|s| s.abs() < 1e-12 * largest.max(1.0)),
                "round-off: {force:?} {moment:?}"
            );
            if step == 499 {
                assert!(hourglass > 0.0 && booked > 0.0);
                assert_close(booked, work, 1e-3 * work, "second order in steps of 2e-5 strain; forces at two times");
            }
        }
        // Elastic all through: what was put in comes back.
        match form {
            HourglassForm::AssumedStrain => {
                assert!(booked.abs() < 1e-11 * peak, "a step back undoes a step: {booked:e}")
            }
            // Their stiffness is that of the end of the step, which is the other end on the way back.
            HourglassForm::Stiffness => assert!(booked.abs() < 1e-6 * peak, "1e-5 of change a step: {booked:e}"),
            HourglassForm::Viscous => assert!(booked > 1e-6 * peak, "hourglass motion is damped: {booked:e}"),
        }
    }
}
