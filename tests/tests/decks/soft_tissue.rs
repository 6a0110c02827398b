//! `*MAT_SOFT_TISSUE` without fibres, a rubber. Units mm, ms, kg.

use super::base::{BASE, MOVES, STEEL, assert_refused, model_of};

fn deck(tissue: &str) -> String {
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    format!("{base}{STEEL}{MOVES}{tissue}")
}

/// Its shear modulus is 2 (c1 + c2), and Poisson's ratio is that of the bulk modulus.
#[test]
fn a_tissue_without_fibres_is_a_rubber() {
    let card = "*MAT_SOFT_TISSUE_TITLE\ncell\n2,1.0e-6,0.0003,0.0001\n0.05\n\n0,0,0,1\n";
    let model = model_of(&deck(card));
    let law = model.job.material.iter().find(|m| m.law == "polynomial_rubber").expect("a rubber");
    let coefficients = law.parameters["coefficients"].as_array().expect("a list");
    let first: Vec<f64> = coefficients.iter().take(2).filter_map(|c| c.as_float()).collect();
    assert_eq!(first, [0.0003, 0.0001]);
    let nu = law.parameters["poisson"].as_float().expect("a number");
    let (shear, bulk) = (0.0008, 0.05);
    let of_nu = 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    assert!((of_nu / bulk - 1.0).abs() < 1e-9, "{of_nu}");
}

/// Fibres, relaxation and a missing bulk modulus are errors.
#[test]
fn fibres_and_relaxation_are_refused() {
    let fibres = "*MAT_091\n2,1.0e-6,0.0003,0.0001,0.002\n0.05\n";
    assert_refused(&deck(fibres), &["`c3` = 0.002", "fibres"]);
    let relaxes = "*MAT_SOFT_TISSUE_VISCO\n2,1.0e-6,0.0003\n0.05\n\n\n0.1\n1.0\n";
    assert_refused(&deck(relaxes), &["`s` = 0.1", "relaxation of the stress"]);
    let soft = "*MAT_091\n2,1.0e-6,0.0003\n\n";
    assert_refused(&deck(soft), &["xk is 0", "give a bulk modulus xk"]);
}
