//! Tests of the one-point hexahedron: rigid motion, patches, balance, energy, lanes.

use super::super::solid_testing::*;
use super::super::testing::*;
use super::*;
use crate::materials;
use crumple_math::lanes::{LANES, Lane, dot};
use crumple_proto::mesh::OwnSection;
use std::collections::BTreeMap;

const E: f64 = 1e6;
const NU: f64 = 0.25;
const FORMS: [HourglassForm; 3] =
    [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain];

/// Returns a unit cube of eight elements, with all inner and face nodes displaced if `by` is not
/// zero.
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

/// Volume and mean gradient agree with their definitions.
#[test]
fn gradient_is_the_derivative_of_the_volume() {
    let mut noise = Noise(2);
    let mut x: [[f64; 3]; 8] = block([1, 1, 1], [1.0, 2.0, 0.5]).1[0]
        .map(|n| block([1, 1, 1], [1.0, 2.0, 0.5]).0[n as usize]);
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
        volume += dot(xi, crumple_math::lanes::cross(eta, zeta));
    }
    let gradient = Gradient::new(&modes);
    assert_close(gradient.volume(), volume, 1e-14, "round-off");
    // b by central differences of a cubic, which has an error from the third derivative, at h^2.
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
            let exact =
                gradient.gradient_of(&modes_of_corners(&unit), 1.0)[i][i] * gradient.volume();
            assert_close((volume(h) - volume(-h)) / (2.0 * h), exact, 1e-10, "round-off over 1e-5");
        }
    }
    // It is exact for linear fields.
    let k = gradient
        .gradient_of(&modes_of_corners(&x.map(|p| [2.0 * p[0] + p[2], p[1], 3.0 * p[0]])), 1.0);
    let wanted = [[2.0, 0.0, 1.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]];
    k.iter()
        .flatten()
        .zip(wanted.iter().flatten())
        .for_each(|(k, w)| assert_close(*k, *w, 1e-14, "round-off"));
}

/// Verification A19 (a): no stress at 90, 180 and 360 degrees, for any angle per step.
#[test]
fn rigid_rotation_leaves_no_stress() {
    for form in FORMS {
        for (steps, axis) in [
            (100, [0.0, 0.0, 1.0]),
            (100, [0.48, -0.64, 0.6]),
            (1000, [0.6, 0.0, 0.8]),
            (4, [1.0, 0.0, 0.0]),
        ] {
            let mut solids = cubes(form, 0.1);
            let angle = axis.map(|c| c * std::f64::consts::TAU / f64::from(steps));
            for step in 1..=steps {
                solids.go(|x| rotate(angle, x.map(|c| c + 0.01)));
                if [steps / 4, steps / 2, steps].contains(&step) {
                    for element in 0..8 {
                        let largest = solids
                            .fields(element)
                            .stress
                            .iter()
                            .fold(0.0, |m: f64, s| m.max(s.abs()));
                        assert!(
                            largest < 1e-10 * E,
                            "the catalogue's bound: step {step} of {steps}: {largest:e}"
                        );
                    }
                    assert!(
                        solids.largest().0 < 1e-10 * E,
                        "step {step} of {steps}: force {:e}",
                        solids.largest().0
                    );
                }
            }
        }
    }
}

/// Verification A19 (b): stress rotates with the body.
#[test]
fn stress_turns_with_the_body() {
    let angle = [0.3, -0.5, 0.2];
    for form in FORMS {
        let mut solids = cubes(form, 0.1);
        solids.go(|x| [1.001 * x[0] + 0.002 * x[1], x[1] - 0.001 * x[2], 0.9995 * x[2]]);
        let before: Vec<_> = (0..8).map(|e| solids.fields(e)).collect();
        let forces = solids.nodal().0;
        (0..30).for_each(|_| _ = solids.go(|x| rotate(angle, x)));
        for (e, before) in before.iter().enumerate() {
            let after = solids.fields(e);
            assert_close(
                after.von_mises,
                before.von_mises,
                1e-10 * before.von_mises,
                "the catalogue's bound",
            );
            let trace = |s: [f64; 6]| s[0] + s[1] + s[2];
            assert_close(
                trace(after.stress),
                trace(before.stress),
                1e-10 * before.von_mises,
                "the catalogue's bound",
            );
        }
        // Forces, with hourglass resistance, also rotate; viscous resistance ends with its rate.
        if form != HourglassForm::Viscous {
            let largest = solids.largest().0;
            for (after, before) in solids.nodal().0.into_iter().zip(forces) {
                let wanted = (0..30).fold(before, |f, _| rotate(angle, f));
                (0..3).for_each(|i| {
                    assert_close(after[i], wanted[i], 1e-10 * largest, "the catalogue's bound")
                });
            }
        }
    }
}

/// Verification A21: u = 1e-3 (2 x + y + z)/2 and so on give 2000 and 400 in every distorted
/// element.
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
            for (c, stress) in stress.into_iter().enumerate() {
                let wanted = if c < 3 { 2000.0 } else { 400.0 };
                assert_close(stress, wanted, 1e-10 * wanted, "round-off, and a strain of 1e-12");
            }
        }
        let inner = solids.nodal().0[13];
        let largest = solids.largest().0;
        assert!(
            inner.iter().all(|f| f.abs() < 1e-10 * largest),
            "the middle node is in equilibrium: {inner:?} of {largest}"
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
            // Forwards and backwards, so that strain stays small and hourglass modes move.
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
            let largest = solids.largest().0;
            assert!(
                force.iter().chain(&moment).all(|s| s.abs() < 1e-12 * largest.max(1.0)),
                "round-off: {force:?} {moment:?}"
            );
            if step == 499 {
                assert!(hourglass > 0.0 && booked > 0.0);
                assert_close(
                    booked,
                    work,
                    1e-3 * work,
                    "second order in strain steps of 2e-5; forces at two times",
                );
            }
        }
        // Everything is elastic, so the work is recovered.
        match form {
            HourglassForm::AssumedStrain => {
                assert!(
                    booked.abs() < 1e-11 * peak,
                    "a reversed step restores the state: {booked:e}"
                )
            }
            // Their stiffness is that of the end of the step, which is the other end on the way
            // back.
            HourglassForm::Stiffness => {
                assert!(
                    booked.abs() < 1e-6 * peak,
                    "stiffness changes by 1e-5 per step: {booked:e}"
                )
            }
            HourglassForm::Viscous => {
                assert!(booked > 1e-6 * peak, "hourglass motion is damped: {booked:e}")
            }
        }
    }
}

/// Verification C10 (d): no hourglass force in any linear field of a distorted element.
#[test]
fn hourglass_forces_vanish_in_linear_fields() {
    for form in FORMS {
        let mut noise = Noise(23);
        for _ in 0..10 {
            let mut solids = cubes(form, 0.15);
            let l: [[f64; 3]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| 1e-3 * noise.next()));
            solids.go(|x| std::array::from_fn(|i| x[i] + dot(l[i], x)));
            let columns = solids.element.columns();
            let own =
                |e: usize| (columns - hourglass::COLUMNS..columns).map(move |column| (e, column));
            let all = (0..solids.cells.len())
                .flat_map(own)
                .map(|(e, column)| solids.history.element(e).at(column));
            let largest = all.fold(0.0, |m: f64, h| m.max(h.abs()));
            assert!(largest < 1e-12 * E, "round-off: {largest:e}");
        }
    }
}

/// All laws and forms: each lane gives the result of its element alone, with elements next to each
/// other that yield, fail and stay at rest.
#[test]
fn every_lane_is_what_it_would_be_alone() {
    let steel = [("youngs_modulus", 210.0), ("poisson", 0.3)];
    let with = |law: &str, more: &[(&str, f64)]| material(law, 7.85e-6, &[&steel, more].concat());
    let cook =
        [("a", 0.8), ("b", 0.6), ("n", 0.17), ("c", 0.01), ("reference_rate", 1e-3), ("m", 1.1)];
    let heat = [
        ("melting_temperature", 1540.0),
        ("reference_temperature", 20.0),
        ("specific_heat", 460.0),
    ];
    let materials = [
        with("elastic", &[]),
        with("j2", &[("yield_stress", 0.25), ("hardening_modulus", 1.0)]),
        with("j2", &[("yield_stress", 0.25), ("failure_strain", 0.03)]),
        with("johnson_cook", &[&cook[..], &heat[..]].concat()),
    ];
    for steel in &materials {
        for form in FORMS {
            let law = materials::build_solid(steel).map_err(|p| format!("{p:?}")).unwrap();
            let defaults = BTreeMap::new();
            let values = Values::new(ROW.parameters, &defaults);
            let elastic = law.elastic();
            let element = Hexahedron {
                material: SolidMaterial::new(&values, law),
                hourglass: Hourglass { form, coefficient: 0.05, elastic },
            };
            let columns = element.columns();
            let mut wide = vec![Lane::splat(0.0); columns];
            let mut alone = vec![vec![0.0; columns]; LANES];
            let mut noise = Noise(9);
            let mut x: [HexahedronModes<f64>; LANES] = std::array::from_fn(|_| {
                let (nodes, _) = distorted(0.1);
                modes_of_corners(&std::array::from_fn(|c| nodes[[0, 1, 4, 3, 9, 10, 13, 12][c]]))
            });
            for _ in 0..40 {
                let v: [HexahedronModes<f64>; LANES] = [0.0, 1e-4, 3e-3, 3e-2].map(|size| {
                    std::array::from_fn(|_| std::array::from_fn(|_| size * noise.next()))
                });
                for (x, v) in x.iter_mut().zip(&v) {
                    x.iter_mut()
                        .flatten()
                        .zip(v.iter().flatten())
                        .for_each(|(x, v)| *x += 0.01 * v);
                }
                let lanes = |modes: &[HexahedronModes<f64>; LANES]| -> HexahedronModes<Lane> {
                    std::array::from_fn(|k| {
                        std::array::from_fn(|i| {
                            Lane::new(std::array::from_fn(|lane| modes[lane][k][i]))
                        })
                    })
                };
                let group = element.respond(&lanes(&x), &lanes(&v), &mut wide, 0.01);
                for lane in 0..LANES {
                    let one = element.respond(&x[lane], &v[lane], &mut alone[lane], 0.01);
                    let same = |a: Lane, b: f64| {
                        assert_eq!(a.lane(lane).to_bits(), b.to_bits(), "{}", steel.law)
                    };
                    let forces = group.force.iter().flatten().zip(one.force.iter().flatten());
                    forces.for_each(|(a, b)| same(*a, *b));
                    same(group.totals.internal, one.totals.internal);
                    same(group.totals.hourglass, one.totals.hourglass);
                    same(group.totals.stable_dt, one.totals.stable_dt);
                    wide.iter().zip(&alone[lane]).for_each(|(a, b)| same(*a, *b));
                }
            }
        }
    }
}

/// The corners of a cell have the same order in `modes_of`, in `corners_of` and in the mesh.
#[test]
fn modes_and_corners_are_each_others_transpose() {
    let mut noise = Noise(31);
    let x: [f64; 8] = std::array::from_fn(|_| noise.next());
    let f: [f64; 7] = std::array::from_fn(|_| noise.next());
    let by_modes: f64 = modes::modes_of(x).iter().zip(&f).map(|(a, b)| a * b).sum();
    let by_corners: f64 = modes::corners_of(f).iter().zip(&x).map(|(a, b)| a * b).sum();
    assert_close(by_modes, by_corners, 1e-14, "round-off");
}

#[test]
fn an_inverted_or_wildly_strained_element_is_trouble() {
    let mut solids = cubes(HourglassForm::Stiffness, 0.0);
    assert_eq!(solids.go(|x| x).trouble, None);
    assert_eq!(
        solids.go(|x| [x[0], x[1], 0.4 * x[2]]).trouble,
        Some(0),
        "strained by 0.86 in one step"
    );
    let mut solids = cubes(HourglassForm::Stiffness, 0.0);
    assert!(solids.go(|x| [x[0], x[1], -x[2]]).trouble.is_some(), "inside out");
    assert!(
        solids.stable_dt().is_nan()
            || solids.element.stable_dt(&solids.corners(0), OwnSection::default()).is_nan()
    );
    solids.v[3][1] = f64::NAN;
    assert!(solids.forces(1.0).trouble.is_some());
}

/// A failed element has no force, limits no step and is not reported as trouble.
#[test]
fn a_failed_element_lets_go() {
    let steel =
        [("youngs_modulus", E), ("poisson", NU), ("yield_stress", 1e3), ("failure_strain", 0.05)];
    let (nodes, cells) = distorted(0.1);
    let part = || solid_part(HourglassForm::AssumedStrain, None);
    let mut solids = Solids::new(part(), material("j2", 1.0, &steel), &nodes, &cells);
    for step in 0..100 {
        solids.go(|x| [1.002 * x[0], x[1], x[2]]);
        if step == 5 {
            assert!(solids.largest().0 > 1.0 && !solids.fields(0).failed);
        }
    }
    let totals = solids.go(|x| [3.0 * x[0], x[1], x[2]]);
    assert!((0..8).all(|e| solids.fields(e).failed && solids.fields(e).von_mises == 0.0));
    assert_eq!((solids.largest().0, totals.internal, totals.trouble), (0.0, 0.0, None));
    assert_eq!(totals.stable_dt, f64::INFINITY);
}

/// A spot weld that lies at an angle and turns fails at the same strain as one across z: its plane
/// is that of its first face, and it turns with the material.
#[test]
fn welds_keep_their_plane_in_any_position() {
    let e = 200.0;
    let limits = [("erosion_weld_normal_stress", 0.4), ("erosion_weld_shear_stress", 0.1)];
    let weld = material(
        "elastic",
        1e-6,
        &[&[("youngs_modulus", e), ("poisson", 0.0)], &limits[..]].concat(),
    );
    let rotated = |angle: [f64; 3], x: [f64; 3]| match angle {
        [0.0, 0.0, 0.0] => x,
        angle => rotate(angle, x),
    };
    let fails_at = |lie: [f64; 3], turn: [f64; 3]| {
        let (nodes, cells) = block([1, 1, 1], [2.0, 2.0, 1.0]);
        let laid: Vec<[f64; 3]> = nodes.iter().map(|&x| rotated(lie, x)).collect();
        let part = solid_part(HourglassForm::Stiffness, None);
        let mut solids = Solids::new(part, weld.clone(), &laid, &cells);
        for step in 1..=4000 {
            let share = f64::from(step) / 4000.0;
            for (k, x) in nodes.iter().enumerate() {
                let pulled = [x[0], x[1], x[2] * (1.0 + 4e-3 * share)];
                let to = rotated(turn.map(|a| a * share), rotated(lie, pulled));
                let now = solids.x[k];
                (0..3).for_each(|i| solids.v[k][i] = to[i] - now[i]);
            }
            solids.step(1.0);
            if solids.element.failed(solids.history.element(0)) {
                return 4e-3 * share;
            }
        }
        panic!("it holds: {lie:?} {turn:?}")
    };
    let plain = fails_at([0.0; 3], [0.0; 3]);
    // 0.4/200, in steps of 1e-6.
    assert!((plain - 2e-3).abs() < 4e-6, "{plain}");
    for (lie, turn) in [
        ([0.3, -1.1, 0.7], [0.0; 3]),
        ([0.0; 3], [0.9, 0.4, -0.5]),
        ([1.2, 0.5, 2.0], [0.3, 1.0, 0.2]),
    ] {
        let got = fails_at(lie, turn);
        assert!((got - plain).abs() < 4e-6, "{lie:?} {turn:?}: {got} for {plain}");
    }
}
