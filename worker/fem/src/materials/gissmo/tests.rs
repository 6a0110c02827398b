//! Damage over the triaxiality against closed forms. Units mm, ms, kg.

use super::*;
use crate::materials::testing::{Cube, Sheet, material, problems, table};
use crumple_proto::partition::Param;

const E: f64 = 200.0;
const YIELD: f64 = 0.2;
const MODULUS: f64 = 0.3;
/// Strain to failure over the triaxiality, and strain from which on the stress falls.
const FAILS: [[f64; 2]; 4] = [[-0.5, 2.0], [0.0, 0.2], [1.0 / 3.0, 0.1], [2.0 / 3.0, 0.16]];
const BEGINS: [[f64; 2]; 3] = [[0.0, 0.08], [1.0 / 3.0, 0.06], [2.0 / 3.0, 0.04]];

fn metal(law: &str, numbers: &[(&str, f64)], curves: &[(&str, Param)]) -> Material {
    let elastic = [("youngs_modulus", E), ("poisson", 0.3), ("yield_stress", YIELD)];
    let hardening = [("hardening_modulus", MODULUS)];
    let numbers = [&elastic[..], &hardening, numbers].concat();
    material(law, &numbers, &[&[(FAILURE, table(&FAILS))], curves].concat())
}

fn linear(curve: &[[f64; 2]], x: f64) -> f64 {
    let two = curve.windows(2).find(|two| x <= two[1][0] + 1e-12).expect("within the points");
    two[0][1] + (two[1][1] - two[0][1]) * (x - two[0][0]) / (two[1][0] - two[0][0])
}

/// Share of the effective stress that acts at a plastic strain, by the closed form
/// `1 - (((e/e_f)^n - (e_c/e_f)^n)/(1 - (e_c/e_f)^n))^m`.
fn intact(strain: f64, [fails, begins]: [f64; 2], [n, m]: [f64; 2]) -> f64 {
    let (damage, critical) = ((strain / fails).powf(n), (begins / fails).powf(n));
    1.0 - ((damage - critical) / (1.0 - critical)).max(0.0).powf(m)
}

/// Paths of constant triaxiality: tension, shear and equal biaxial tension of a sheet; tension of a
/// cube. The stress is the closed form at the plastic strain, until failure at that of the curve.
#[test]
fn constant_triaxiality_has_a_closed_form() {
    let begins = [(CRITICAL, table(&BEGINS))];
    for [n, m] in [[1.0, 1.0], [2.0, 1.5], [1.7, 3.0]] {
        let exponents = [(EXPONENT, n), (FADING, m)];
        for law in ["j2", "barlat"] {
            let isotropic = if law == "barlat" { &[("exponent", 2.0)][..] } else { &[] };
            let law = metal(law, &[&exponents[..], isotropic].concat(), &begins);
            for (triaxiality, step) in [
                (1.0 / 3.0, None),
                (0.0, Some([0.0, 0.0, 4e-5])),
                (2.0 / 3.0, Some([2e-5, 2e-5, 0.0])),
            ] {
                let mut sheet = Sheet::new(&law);
                let limits = [&FAILS[..], &BEGINS].map(|curve| linear(curve, triaxiality));
                let last = sheet.state.len() - 1;
                // The plastic strain of the last step with stress; that of the step of failure has
                // no meaning, since no strain across gives a stress there.
                let mut strain = 0.0;
                loop {
                    match step {
                        None => sheet.pull(2e-5, 1.0),
                        Some(step) => sheet.step(step, 1.0),
                    }
                    if sheet.state[last] == 1.0 {
                        break;
                    }
                    strain = sheet.state[3];
                    assert!(strain < limits[0], "{triaxiality}: it fails");
                    let [x, y, xy, ..] = sheet.state[..] else { panic!("a state") };
                    let mises = (x * x - x * y + y * y + 3.0 * xy * xy).sqrt();
                    let exact = (YIELD + MODULUS * strain) * intact(strain, limits, [n, m]);
                    let off = mises - exact;
                    assert!(strain == 0.0 || off.abs() < 1e-8, "{triaxiality} {strain}: {off}");
                }
                assert!(limits[0] - strain < 4.1e-5, "{triaxiality}: failed after {strain}");
                sheet.step([1e-3, 1e-3, 1e-3], 1.0);
                assert_eq!(sheet.state[..3], [0.0; 3]);
            }
        }
        let mut cube = Cube::new(&metal("j2", &exponents, &begins));
        let limits = [&FAILS[..], &BEGINS].map(|curve| linear(curve, 1.0 / 3.0));
        let mut strain = 0.0;
        loop {
            cube.pull([2e-5, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
            if cube.at("failed") == 1.0 {
                break;
            }
            strain = cube.at("plastic_strain");
            assert!(strain < limits[0], "it fails");
            let exact = (YIELD + MODULUS * strain) * intact(strain, limits, [n, m]);
            assert!(strain == 0.0 || (cube.state[0] - exact).abs() < 1e-8, "{strain}");
        }
        assert!(limits[0] - strain < 2.1e-5, "failed after {strain}");
    }
}

/// With a constant critical damage the stress falls from it on; without any it acts until failure.
#[test]
fn damage_can_begin_at_a_constant_or_not_at_all() {
    for (critical, n) in [(Some(0.0), 2.0), (Some(0.3), 2.0), (None, 1.0)] {
        let numbers: Vec<(&str, f64)> =
            critical.map(|d| (CRITICAL_DAMAGE, d)).into_iter().chain([(EXPONENT, n)]).collect();
        let mut sheet = Sheet::new(&metal("j2", &numbers, &[]));
        for _ in 0..3000 {
            sheet.pull(2e-5, 1.0);
            let strain = sheet.state[3];
            let left = match critical {
                None => 1.0,
                Some(d) => 1.0 - (((strain / 0.1).powf(n) - d) / (1.0 - d)).max(0.0),
            };
            let exact = (YIELD + MODULUS * strain) * left;
            if strain > 0.0 {
                assert!((sheet.state[0] - exact).abs() < 1e-9, "{critical:?} {strain}");
            }
        }
    }
}

/// On a path of two triaxialities the shares of the strains to failure add up to one, in any order,
/// whatever the exponent.
#[test]
fn shares_of_a_path_add_up() {
    let mut ends = Vec::new();
    for n in [1.0, 2.5] {
        for shear_first in [true, false] {
            let mut sheet = Sheet::new(&metal("j2", &[(EXPONENT, n)], &[]));
            let mut strains = [0.0; 2];
            let last = sheet.state.len() - 1;
            while sheet.state[last] == 0.0 {
                let before = sheet.state[3];
                let first = before < 0.05;
                let is_shear = first == shear_first;
                // The stress of the other path has to go first: small elastic steps.
                if is_shear {
                    sheet.step([0.0, 0.0, 2e-5], 1.0)
                } else {
                    sheet.pull(1e-5, 1.0)
                }
                strains[usize::from(is_shear)] += sheet.state[3] - before;
            }
            let sum = strains[0] / 0.1 + strains[1] / 0.2;
            // Between both paths the triaxiality changes over strains of the size of that at yield.
            assert!((sum - 1.0).abs() < 0.02, "{n} {shear_first}: {strains:?}");
            ends.push(strains);
        }
    }
    // The exponent does not change the failure.
    assert_eq!(ends[..2], ends[2..]);
}

/// The strain to failure has the factor of the size of the element.
#[test]
fn the_size_scales_the_strain_to_failure() {
    let sizes = [(SIZES, table(&[[0.5, 1.2], [2.0, 0.6]]))];
    for (size, factor) in [(0.1, 1.2), (0.5, 1.2), (1.25, 0.9), (5.0, 0.6)] {
        let law = metal("j2", &[], &sizes);
        let mut cube = Cube::new(&law);
        // Columns: plastic strain, root of damage, size, failure.
        assert_eq!(cube.state.len(), 10);
        cube.state[8] = size;
        while cube.at("failed") == 0.0 {
            cube.pull([2e-5, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
        }
        let strain = cube.at("plastic_strain");
        assert!((strain - 0.1 * factor).abs() < 2e-5, "{size}: {strain}");
        assert_eq!(cube.at(SIZE_COLUMN), size);
    }
}

#[test]
fn wrong_damage_is_refused_at_once() {
    let numbers = [(EXPONENT, 0.0), (CRITICAL_DAMAGE, 0.1), (POINTS, 1.5), ("gissmo_exponnt", 1.0)];
    let curves = [(CRITICAL, table(&[[0.0, 0.1], [0.0, 0.2]])), (SIZES, table(&[[1.0, 0.0]]))];
    let mut law = metal("j2", &numbers, &curves);
    law.parameters.remove(FAILURE);
    let text = problems(&law);
    for words in [
        "gissmo_failure_strain is missing",
        "gissmo_exponent is 0",
        "gissmo_critical_damage is given with",
        "gissmo_failed_points is 1.5",
        "gissmo_critical_strain is not such a curve",
        "gissmo_size_factors is not such a curve",
        "'gissmo_exponent'?",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let glass = [("youngs_modulus", E), ("poisson", 0.3)];
    let text = problems(&material("elastic", &glass, &[(FAILURE, table(&FAILS))]));
    assert!(text.contains("no plastic strain"), "{text}");
}
