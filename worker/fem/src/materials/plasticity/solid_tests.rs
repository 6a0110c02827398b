//! Strain paths with known results, verification A27. Steel in GPa: E = 210, nu = 0.3, yield
//! 0.25, as in common test drivers.

use crate::elements::testing::Noise;
use crate::materials::{Solid, SolidPoint, build_solid};
use crumple_proto::partition::{Material, Param};

const E: f64 = 210.0;
const YIELD: f64 = 0.25;

fn steel(extra: &[(&str, Param)]) -> Box<dyn Solid> {
    let mut parameters: std::collections::BTreeMap<_, _> =
        extra.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
    parameters.insert("youngs_modulus".into(), Param::Number(E));
    parameters.insert("poisson".into(), Param::Number(0.3));
    if !parameters.contains_key("hardening") {
        parameters.insert("yield_stress".into(), Param::Number(YIELD));
    }
    let material =
        Material { name: "steel".into(), law: "j2".into(), density: 7.85e-6, parameters };
    build_solid(&material).map_err(|problems| format!("{problems:?}")).unwrap()
}

fn linear(modulus: f64) -> Box<dyn Solid> {
    steel(&[("hardening_modulus", Param::Number(modulus))])
}

fn advance(law: &dyn Solid, state: &mut [f64], strain: [f64; 6], dt: f64) {
    law.update_one(SolidPoint { state, strain: &strain }, dt);
}

/// Applies a step with `eps` along x. Along the axes in `free` it finds the strain with zero
/// stress; the other strains are zero.
fn pull(law: &dyn Solid, state: &mut [f64], eps: f64, free: &[usize], dt: f64) {
    let strain = |lateral: f64| {
        let mut strain = [eps, 0.0, 0.0, 0.0, 0.0, 0.0];
        free.iter().for_each(|&axis| strain[axis] = lateral);
        strain
    };
    let (mut low, mut high) = (-eps.abs(), eps.abs());
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let mut trial = state.to_vec();
        advance(law, &mut trial, strain(middle), dt);
        if trial[free[0]] > 0.0 { high = middle } else { low = middle }
    }
    advance(law, state, strain(0.5 * (low + high)), dt);
}

fn von_mises(s: &[f64]) -> f64 {
    let direct = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    (0.5 * direct + 3.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])).sqrt()
}

#[test]
fn uniaxial_stress_follows_the_bilinear_curve_and_unloads_with_e() {
    let law = linear(1.0);
    let mut state = [0.0; 7];
    (0..500).for_each(|_| pull(&*law, &mut state, 1e-4, &[1, 2], 1.0));
    let eps_p = (E * 0.05 - YIELD) / (E + 1.0);
    assert!((state[0] - (YIELD + eps_p)).abs() < 1e-9, "round-off over 500 steps: {}", state[0]);
    assert!((state[0] - 0.29858).abs() < 5e-6, "the digits of the catalogue");
    assert!((state[6] - eps_p).abs() < 1e-9, "round-off over 500 steps: {}", state[6]);
    let before = state[0];
    pull(&*law, &mut state, -1e-4, &[1, 2], 1.0);
    assert!(((before - state[0]) / 1e-4 - E).abs() < 1e-7 * E, "round-off of a difference");
}

#[test]
fn simple_paths_yield_where_they_should() {
    let law = linear(0.0);
    let mut shear = [0.0; 7];
    (0..100).for_each(|_| advance(&*law, &mut shear, [0.0, 0.0, 0.0, 0.0, 1e-4, 0.0], 1.0));
    assert!(
        (shear[4] - YIELD / 3.0_f64.sqrt()).abs() < 1e-12,
        "radial return is exact: {}",
        shear[4]
    );

    let mut plane = [0.0; 7];
    (0..1000).for_each(|_| pull(&*law, &mut plane, 1e-4, &[1], 1.0));
    let exact = 2.0 * YIELD / 3.0_f64.sqrt();
    assert!(
        (plane[0] - exact).abs() < 1e-6 * exact,
        "elastic part negligible after 10 %: {} for {exact}",
        plane[0]
    );
}

#[test]
fn returned_stress_lies_on_the_surface_whatever_the_step() {
    let rows = [[0.0, 0.25], [0.02, 0.3], [0.05, 0.6], [0.3, 0.65]];
    let by_rows = |eps_p: f64| {
        let row = rows.windows(2).find(|pair| eps_p < pair[1][0]);
        row.map_or(0.65, |p| {
            p[0][1] + (p[1][1] - p[0][1]) * (eps_p - p[0][0]) / (p[1][0] - p[0][0])
        })
    };
    let table = Param::Table(rows.iter().map(|row| row.to_vec()).collect());
    let law = steel(&[("hardening", table)]);
    let mut noise = Noise(1);
    let mut yielded = 0;
    for k in 0..2000 {
        let size = 10.0_f64.powf(-4.0 + 0.002 * f64::from(k));
        let mut state = [0.1, -0.05, 0.02, 0.03, -0.02, 0.01, 0.0002 * f64::from(k)];
        let before = state;
        let strain = std::array::from_fn(|_| size * noise.next());
        advance(&*law, &mut state, strain, 1.0);
        let (vm, sig_y) = (von_mises(&state), by_rows(state[6]));
        if state[6] > before[6] {
            yielded += 1;
            assert!(
                (vm - sig_y).abs() < 1e-11 * sig_y,
                "exact except for round-off: step {size}, {vm} for {sig_y}"
            );
        } else {
            assert!(vm <= sig_y, "elastic above yield: {vm} for {sig_y}");
        }
        let bulk = E / (3.0 * 0.4) * (strain[0] + strain[1] + strain[2]);
        let mean = (state[0] + state[1] + state[2] - before[0] - before[1] - before[2]) / 3.0;
        assert!((mean - bulk).abs() < 1e-13 * (1.0 + bulk.abs()), "plastic flow is isochoric");
    }
    assert!(yielded > 500, "the test must reach the yield surface: {yielded}");
}

#[test]
fn rate_multiplies_the_yield_stress() {
    let law = steel(&[("cowper_symonds", Param::List(vec![40.0, 5.0]))]);
    let mut state = [0.0; 7];
    // Shear of 1e-4 in 1e-6: sqrt(1/3) 100/s.
    (0..200).for_each(|_| advance(&*law, &mut state, [0.0, 0.0, 0.0, 1e-4, 0.0, 0.0], 1e-6));
    let exact = YIELD * (1.0 + (100.0 / 3.0_f64.sqrt() / 40.0).powf(0.2));
    assert!(
        (von_mises(&state) - exact).abs() < 1e-12,
        "exactly: {} for {exact}",
        von_mises(&state)
    );
}

#[test]
fn a_point_fails_at_its_strain_and_stays_failed() {
    let law = steel(&[("failure_strain", Param::Number(0.05))]);
    let mut state = [0.0; 10];
    assert_eq!(law.history()[3], "failed");
    let mut last = 0.0;
    while state[9] == 0.0 {
        last = von_mises(&state);
        advance(&*law, &mut state, [0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1.0);
        assert!(state[6] < 0.06, "the point must fail");
    }
    assert!(
        (last - YIELD).abs() < 1e-12 && (0.05..0.0506).contains(&state[6]),
        "within a step of 5.8e-4: {state:?}"
    );
    let strain = state[6];
    advance(&*law, &mut state, [0.1, 0.0, 0.0, 0.1, 0.0, 0.0], 1.0);
    assert!(state[..6].iter().all(|s| *s == 0.0) && state[6] == strain && state[9] == 1.0);
}

#[test]
fn an_incompressible_solid_is_refused() {
    let numbers = [("youngs_modulus", 1.0), ("poisson", 0.5), ("yield_stress", 1.0)];
    let parameters = numbers.map(|(key, value)| (key.to_string(), Param::Number(value)));
    let material = Material {
        name: "m".into(),
        law: "j2".into(),
        density: 1.0,
        parameters: parameters.into(),
    };
    let problems = build_solid(&material).err().expect("the bulk modulus is not finite");
    assert!(problems[0].path == "poisson" && problems[0].help.contains("0.499"), "{problems:?}");
    assert!(crate::materials::build(&material).is_ok(), "a shell may be incompressible");
}
