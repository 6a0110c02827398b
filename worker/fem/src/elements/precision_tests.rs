//! Single precision against double: forces, energies, steps, laws, and quantities that must be
//! kept.

use super::HourglassForm;
use super::solid_testing::{Solids, solids};
use super::testing::{
    BOTH, E, FORMULATIONS, Noise, Patch, YIELD, laws, laws_of_solids, material, part, shells, steel,
};
use crumple_proto::job::Precision;
use crumple_proto::partition::Param;

/// Both precisions get the same random motion: strains of a few per cent in all, most of them
/// plastic. Round-off of a step is 6e-8 of the stress and of the strain's 1e-3 there; forces and
/// energies agree to a few 1e-6.
#[test]
fn shells_give_nearly_the_forces_of_double_precision() {
    for steel in laws() {
        for kind in 0..FORMULATIONS.len() {
            let ends = BOTH.map(|precision| {
                let mut patch = shells(precision, &steel, [0.0; 3]).into_iter().nth(kind).unwrap();
                let (mut noise, mut energy) = (Noise(11), [0.0; 2]);
                for _ in 0..60 {
                    for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
                        (0..3).for_each(|i| v[i] = 1.0 + 0.3 * noise.next());
                        (0..3).for_each(|i| w[i] = 0.1 * noise.next());
                    }
                    let totals = patch.step(0.01);
                    assert_eq!(totals.trouble, None, "{} {kind}", steel.law);
                    energy = [energy[0] + totals.internal, energy[1] + totals.hourglass];
                }
                (patch, energy)
            });
            let [(long, energy), (short, short_energy)] = ends;
            let (force, moment) = long.largest();
            let off = |a: &[[f64; 4]], b: &[[f64; 4]]| {
                a.iter()
                    .flatten()
                    .zip(b.iter().flatten())
                    .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
            };
            // Corners beyond the last element are padding, of which one precision has more.
            let corners = 4 * long.cells.len();
            let off = [
                off(&long.force[..corners], &short.force[..corners]) / force,
                off(&long.moment[..corners], &short.moment[..corners]) / moment,
                (short_energy[0] / energy[0] - 1.0).abs(),
                (short_energy[1] / energy[1] - 1.0).abs(),
            ];
            assert!(off.iter().all(|&o| o < 2e-5), "{} {kind}: {off:?}", steel.law);
            assert!(off[0] > 1e-9, "{} {kind}: nothing was rounded, {off:?}", steel.law);
            let strain = |patch: &Patch| {
                (0..patch.cells.len()).map(|e| patch.fields(e).plastic_strain).sum::<f64>()
            };
            let (flowed, short_flowed) = (strain(&long), strain(&short));
            let without_flow = [
                "elastic",
                "viscoelastic",
                "general_viscoelastic",
                "fabric",
                "orthotropic",
                "mooney_rivlin",
            ];
            let flows = !without_flow.contains(&steel.law.as_str());
            assert!(!flows || flowed > 0.01, "{} {kind}: {flowed}", steel.law);
            assert!(
                (short_flowed - flowed).abs() <= 2e-5 * flowed,
                "{} {kind}: {flowed} {short_flowed}",
                steel.law
            );
        }
    }
}

/// Corners are sums of modes in double precision: the sum of the forces of an element vanishes as
/// it does there.
#[test]
fn forces_of_an_element_sum_to_zero() {
    let law = &laws()[0];
    for mut patch in shells(Precision::Single, law, [0.0; 3]) {
        let mut noise = Noise(3);
        patch.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = noise.next()));
        patch.step(0.01);
        let ([x, y, z], _) = patch.sums();
        let (force, _) = patch.largest();
        assert!(
            x.abs().max(y.abs()).max(z.abs()) < 1e-14 * force,
            "round-off of sums of {force}: {x:e} {y:e} {z:e}"
        );
    }
}

/// Differences of corners are taken before they are rounded. So far from the origin and at high
/// speed the forces agree with those at the origin, except for the last digits of coordinates: at
/// 1e7 these are 2e-9 of a side's length.
#[test]
fn large_coordinates_and_speeds_cost_nothing() {
    let law = &laws()[0];
    let runs = [([0.0; 3], 0.0), ([1e7, -2e7, 3e6], 1e4)].map(|(at, speed)| {
        shells(Precision::Single, law, at).map(|mut patch| {
            let mut noise = Noise(3);
            patch.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = speed + noise.next()));
            patch.step(0.01);
            patch
        })
    });
    let [home, away] = runs;
    for (home, away) in home.iter().zip(&away) {
        let (force, _) = home.largest();
        for (a, b) in home.force.iter().flatten().zip(away.force.iter().flatten()) {
            assert!((a - b).abs() < 1e-6 * force, "{a} {b} of {force}");
        }
    }
}

#[test]
fn solids_give_nearly_the_forces_of_double_precision() {
    for steel in laws_of_solids() {
        for form in [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain]
        {
            let [long, short] = BOTH.map(|precision| {
                let mut all = solids(precision, &steel, form);
                let mut noise = Noise(29);
                for _ in 0..60 {
                    all.v
                        .iter_mut()
                        .for_each(|v| (0..3).for_each(|i| v[i] = 1.0 + 0.3 * noise.next()));
                    assert_eq!(all.step(0.01).trouble, None, "{}", steel.law);
                }
                all
            });
            let (size, sums) = (long.largest().0, short.sums().0);
            for (a, b) in long.nodal().0.iter().flatten().zip(short.nodal().0.iter().flatten()) {
                // Stress that softens enlarges round-off.
                let tolerance = if steel.law == "cscm" { 2e-4 } else { 2e-5 };
                let apart = (a - b).abs() / size;
                assert!(apart < tolerance, "{} {form:?}: {a} {b} of {size}", steel.law);
            }
            assert!(
                sums.iter().all(|s| s.abs() < 1e-13 * size),
                "{} {form:?}: {sums:?} of {size}",
                steel.law
            );
        }
    }
}

/// The step in single precision is never longer, and shorter by less than a thousandth; nu = 0
/// gives differences of equal numbers.
#[test]
fn the_stable_step_is_not_longer_than_in_double_precision() {
    let mut noise = Noise(41);
    for poisson in [0.0, 0.3, 0.49] {
        let law = material("elastic", 7.85e-6, &[("youngs_modulus", E), ("poisson", poisson)]);
        for round in 0..400 {
            // Squares and cubes first, then increasingly distorted shapes.
            let size = 1e-3 * f64::from(round);
            let mut moved = |x: [f64; 3]| x.map(|c| 5.0 * c + size * noise.next());
            let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
                .map(&mut moved);
            let cube: [[f64; 3]; 8] = [0, 1, 2, 3, 4, 5, 6, 7]
                .map(|c| moved([[0.0, 1.0, 1.0, 0.0][c % 4], (c / 2 % 2) as f64, (c / 4) as f64]));
            let triangle = &[[0, 1, 2, 2]];
            let steps = BOTH.map(|precision| {
                let shell = |cells| {
                    Patch::in_precision(precision, part(1.0), law.clone(), &square, cells)
                        .forces(0.0)
                };
                let mut solid = Solids::in_precision(
                    precision,
                    part(0.0),
                    law.clone(),
                    &cube,
                    &[[0, 1, 2, 3, 4, 5, 6, 7]],
                );
                [
                    shell(&[[0, 1, 2, 3]]).stable_dt,
                    shell(triangle).stable_dt,
                    solid.forces(0.0).stable_dt,
                ]
            });
            for (long, short) in steps[0].iter().zip(steps[1]) {
                assert!(
                    short <= *long && short > 0.999 * long,
                    "nu {poisson}, round {round}: {long} {short}"
                );
            }
        }
    }
}

/// A single step far beyond yield, up to a thousand times: powers of the trial stress must stay in
/// the range of f32.
#[test]
fn large_trials_return_to_the_yield_surface() {
    let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for yield_stress in [YIELD, 1e-2, 1e-4] {
        let steel = steel("j2", &[("yield_stress", Param::Number(yield_stress))]);
        let mut patch = Patch::in_precision(
            Precision::Single,
            part(0.1).with("points", 2),
            steel,
            &nodes,
            &[[0, 1, 2, 3]],
        );
        patch.forces(0.0);
        let strain = f64::min(0.3, 1e3 * yield_stress / E);
        patch.aim(1.0, |x| [x[0] * (1.0 + strain), x[1] * (1.0 - 0.2 * strain), 0.0], [0.0; 3]);
        assert_eq!(patch.step(1.0).trouble, None);
        let off = patch.fields(0).von_mises / yield_stress - 1.0;
        assert!(off.abs() < 1e-5, "yield stress {yield_stress}: off by {off:e}");
    }
}
