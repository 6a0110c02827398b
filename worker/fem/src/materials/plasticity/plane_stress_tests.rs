//! Strain paths with known results. Steel in GPa: E = 210, nu = 0.3, yield 0.25, as in common
//! test drivers.

use super::super::{FailureCriterion, Rate, YieldCurve};
use super::*;
use crate::materials::build;
use crumple_math::lanes::LANES;
use crumple_proto::partition::{Material, Param};

/// Columns per point: stress xx, yy, xy, effective plastic strain.
const COLUMNS: usize = 4;
const E: f64 = 210.0;
const NU: f64 = 0.3;
const YIELD: f64 = 0.25;

fn steel(extra: &[(&str, Param)]) -> Box<dyn PlaneStress> {
    let mut parameters: std::collections::BTreeMap<_, _> =
        extra.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
    parameters.insert("youngs_modulus".into(), Param::Number(E));
    parameters.insert("poisson".into(), Param::Number(NU));
    if !parameters.contains_key("hardening") {
        parameters.insert("yield_stress".into(), Param::Number(YIELD));
    }
    let material =
        Material { name: "steel".into(), law: "j2".into(), density: 7.85e-6, parameters };
    build(&material).map_err(|problems| format!("{problems:?}")).unwrap()
}

fn linear(modulus: f64) -> Box<dyn PlaneStress> {
    steel(&[("hardening_modulus", Param::Number(modulus))])
}

/// Applies one increment and returns the strain increment through the thickness.
fn advance(law: &dyn PlaneStress, state: &mut [f64; COLUMNS], eps: [f64; 3], dt: f64) -> f64 {
    let mut eps_z = [0.0];
    law.update_one(Points { state, strain: &[eps], thickness_strain: &mut eps_z }, dt);
    eps_z[0]
}

fn von_mises([x, y, t, _]: [f64; COLUMNS]) -> f64 {
    (x * x + y * y - x * y + 3.0 * t * t).sqrt()
}

/// Applies strain along x. In each step it finds the lateral strain with zero lateral stress.
fn pull(law: &dyn PlaneStress, state: &mut [f64; COLUMNS], eps: f64, dt: f64) {
    let (mut low, mut high) = (-eps.abs(), eps.abs());
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let mut trial = *state;
        advance(law, &mut trial, [eps, middle, 0.0], dt);
        if trial[1] > 0.0 { high = middle } else { low = middle }
    }
    advance(law, state, [eps, 0.5 * (low + high), 0.0], dt);
}

#[test]
fn uniaxial_stress_follows_the_bilinear_curve_and_unloads_with_e() {
    let law = linear(1.0);
    let mut state = [0.0; COLUMNS];
    (0..500).for_each(|_| pull(&*law, &mut state, 1e-4, 1.0));
    let eps_p = (E * 0.05 - YIELD) / (E + 1.0);
    let exact = YIELD + eps_p;
    assert!((exact - 0.29858).abs() < 5e-6);
    // The path is proportional, so steps of any size return to the same line.
    assert!(
        (state[0] - exact).abs() < 1e-9 * exact,
        "return to 1e-10 of yield: {} for {exact}",
        state[0]
    );
    assert!((state[3] - eps_p).abs() < 1e-8, "round-off over 500 steps: {} for {eps_p}", state[3]);
    let before = state[0];
    pull(&*law, &mut state, -1e-4, 1.0);
    let slope = (before - state[0]) / 1e-4;
    assert!((slope - E).abs() < 1e-7 * E, "round-off of a difference: {slope}");
}

#[test]
fn simple_paths_yield_where_they_should() {
    let law = linear(0.0);
    let mut shear = [0.0; COLUMNS];
    (0..100).for_each(|_| _ = advance(&*law, &mut shear, [0.0, 0.0, 1e-4], 1.0));
    assert!(
        (shear[2] - YIELD / 3.0_f64.sqrt()).abs() < 1e-9 * YIELD,
        "return to 1e-10 of yield: {}",
        shear[2]
    );

    let mut equal = [0.0; COLUMNS];
    (0..100).for_each(|_| _ = advance(&*law, &mut equal, [1e-4, 1e-4, 0.0], 1.0));
    assert!((equal[0] - YIELD).abs() < 1e-9 * YIELD, "return to 1e-10 of yield: {}", equal[0]);

    let mut plane = [0.0; COLUMNS];
    let mut eps_z = 0.0;
    (0..1000).for_each(|_| eps_z += advance(&*law, &mut plane, [1e-4, 0.0, 0.0], 1.0));
    let exact = 2.0 * YIELD / 3.0_f64.sqrt();
    // The lateral stress approaches one half of the axial stress as elastic strain becomes small
    // against plastic strain.
    assert!(
        (plane[0] - exact).abs() < 1e-6 * exact,
        "elastic part negligible after 10 %: {} for {exact}",
        plane[0]
    );
    let bulk = (1.0 - 2.0 * NU) / E * (plane[0] + plane[1]);
    assert!((0.1 + eps_z - bulk).abs() < 1e-12, "plastic flow is exactly isochoric: {eps_z}");
}

#[test]
fn returned_stress_lies_on_the_surface_whatever_the_step() {
    let rows = [[0.0, 0.25], [0.02, 0.3], [0.05, 0.6], [0.3, 0.65]];
    let table = Param::Table(rows.iter().map(|row| row.to_vec()).collect());
    let by_rows = |eps_p: f64| {
        let row = rows.windows(2).find(|pair| eps_p < pair[1][0]);
        row.map_or(0.65, |p| {
            p[0][1] + (p[1][1] - p[0][1]) * (eps_p - p[0][0]) / (p[1][0] - p[0][0])
        })
    };
    type YieldCurve<'a> = &'a dyn Fn(f64) -> f64;
    let laws: [(_, YieldCurve<'_>); 4] = [
        (linear(0.0), &|_| YIELD),
        (linear(1.0), &|eps_p| YIELD + eps_p),
        (linear(50.0), &|eps_p| YIELD + 50.0 * eps_p),
        (steel(&[("hardening", table)]), &by_rows),
    ];
    for (law, curve) in laws {
        for k in 0..1000 {
            let angle = 0.0314 * f64::from(k);
            let size = 10.0_f64.powf(-4.0 + 0.004 * f64::from(k));
            let mut state = [0.1, -0.05, 0.02, 0.0002 * f64::from(k)];
            let before = state[3];
            advance(
                &*law,
                &mut state,
                [size * angle.cos(), size * angle.sin(), size * (2.7 * angle).sin()],
                1.0,
            );
            let (vm, sig_y) = (von_mises(state), curve(state[3]));
            if state[3] > before {
                assert!(
                    (vm - sig_y).abs() < 1.1e-10 * sig_y,
                    "tolerance of the law, 1e-10: step {size}, {vm} for {sig_y}"
                );
            } else {
                assert!(vm <= sig_y, "elastic above yield: {vm} for {sig_y}");
            }
        }
    }
}

#[test]
fn tables_are_straight_lines_and_then_constant() {
    let rows = vec![vec![0.0, 0.25], vec![0.02, 0.30], vec![0.05, 0.33]];
    let law = steel(&[("hardening", Param::Table(rows))]);
    for (eps, wanted) in [(0.01, 0.275), (0.02, 0.30), (0.035, 0.315), (0.08, 0.33)] {
        let mut state = [0.0; COLUMNS];
        while state[3] < eps {
            pull(&*law, &mut state, 2e-5, 1.0);
        }
        assert!(
            (state[0] - wanted).abs() < 1e-4,
            "one step of 2e-5 at a slope of 2.5 GPa: {} for {wanted}",
            state[0]
        );
    }
}

#[test]
fn rate_multiplies_the_yield_stress() {
    // (C, p) = (40/s, 5); 100/s gives 1 + 2.5^0.2.
    let law = steel(&[("cowper_symonds", Param::List(vec![40.0, 5.0]))]);
    let mut state = [0.0; COLUMNS];
    (0..200).for_each(|_| pull(&*law, &mut state, 1e-4, 1e-6));
    let exact = YIELD * (1.0 + 2.5_f64.powf(0.2));
    // The lateral elastic strain of a uniaxial path is not isochoric, but the flow at the end is.
    assert!(
        (state[0] - exact).abs() < 1e-6 * exact,
        "rate of isochoric flow, exactly: {} for {exact}",
        state[0]
    );
}

#[test]
fn every_lane_is_what_it_would_be_alone() {
    let rate = ("cowper_symonds", Param::List(vec![0.04, 5.0]));
    let table =
        ("hardening", Param::Table(vec![vec![0.0, 0.25], vec![0.02, 0.3], vec![0.05, 0.6]]));
    let laws = [linear(1.0), steel(std::slice::from_ref(&rate)), steel(&[rate.clone(), table])];
    let mut noise = crate::elements::testing::Noise(7);
    for law in laws {
        const N: usize = 5;
        // Lanes from elastic to strongly plastic; one lane has no strain.
        let mut wide = [Lane::splat(0.0); N * COLUMNS];
        let mut alone = [[0.0; N * COLUMNS]; LANES];
        let mut shuffled = wide;
        for _ in 0..50 {
            let sizes = [0.0, 1e-5, 1e-3, 1e-2];
            let eps: [[[f64; 3]; N]; LANES] = sizes
                .map(|size| std::array::from_fn(|_| std::array::from_fn(|_| size * noise.next())));
            let lanes = |of: &dyn Fn(usize) -> usize| -> [[Lane; 3]; N] {
                std::array::from_fn(|k| {
                    std::array::from_fn(|c| {
                        Lane::new(std::array::from_fn(|lane| eps[of(lane)][k][c]))
                    })
                })
            };
            let mut eps_z = [Lane::splat(0.0); N];
            let strain = lanes(&|lane| lane);
            law.update(
                Points { state: &mut wide, strain: &strain, thickness_strain: &mut eps_z },
                0.01,
            );
            // The same elements in reverse order, lane 1 twice.
            let strain = lanes(&|lane| [3, 2, 1, 1][lane]);
            let mut other_z = eps_z;
            law.update(
                Points { state: &mut shuffled, strain: &strain, thickness_strain: &mut other_z },
                0.01,
            );
            for (lane, state) in alone.iter_mut().enumerate() {
                let mut z = [0.0; N];
                law.update_one(
                    Points { state, strain: &eps[lane], thickness_strain: &mut z },
                    0.01,
                );
                for k in 0..N {
                    assert_eq!(eps_z[k].lane(lane).to_bits(), z[k].to_bits());
                }
                for (column, value) in state.iter().enumerate() {
                    assert_eq!(
                        wide[column].lane(lane).to_bits(),
                        value.to_bits(),
                        "lane {lane}, column {column}"
                    );
                }
            }
            for (column, lane) in
                (0..N * COLUMNS).flat_map(|column| (0..LANES).map(move |lane| (column, lane)))
            {
                let there = wide[column].lane([3, 2, 1, 1][lane]);
                assert_eq!(
                    shuffled[column].lane(lane).to_bits(),
                    there.to_bits(),
                    "other lanes changed a lane"
                );
            }
        }
    }
}

#[test]
fn bisection_finds_what_halley_finds() {
    let elastic = Elastic { youngs_modulus: E, poisson: NU, density: 1.0 };
    let curve = YieldCurve::lines(YIELD, 1.0, &[(0.01, -0.5)]);
    let (rate, thermal, failure) = (Rate::None, None, FailureCriterion::None);
    let coefficients = Coefficients::new(&elastic, YIELD);
    let law =
        Plasticity { elastic, yield_stress: YIELD, curve, rate, thermal, failure, coefficients };
    let start = Return { p: 1.6, q: 4.8, eps_p: 0.005, scale: 1.2, y: 0.0 };
    let (mut halley, mut halved) = ([start], start);
    law.solve(&mut halley, &[true]);
    law.bisect(&mut halved, true);
    let off = (halley[0].y - halved.y).abs() / halved.y;
    assert!(off < 1e-9, "the solver stops at 1e-10 of yield: {off}");
    // A converged lane does not move, not even by round-off.
    let there = halley[0].y;
    law.bisect(&mut halley[0], true);
    assert_eq!(halley[0].y.to_bits(), there.to_bits());
}

#[test]
fn a_bad_table_is_refused_with_its_fault() {
    let bad = [
        vec![vec![0.1, 0.25]],
        vec![vec![0.0, 0.25], vec![0.0, 0.3]],
        vec![vec![0.0, 0.25], vec![0.1]],
        vec![],
    ];
    for rows in bad {
        let parameters = [("hardening".to_string(), Param::Table(rows))];
        let material = Material {
            name: "m".into(),
            law: "j2".into(),
            density: 1.0,
            parameters: parameters.into(),
        };
        let problems = build(&material).err().expect("the table is wrong");
        assert!(problems.iter().any(|problem| problem.path == "hardening"), "{problems:?}");
    }
}

/// Lankford's coefficient R: the plastic strain across the sheet over that through it in uniaxial
/// tension is R, and yield is at `sig_y`, in equal biaxial tension at `sig_y sqrt((1 + R)/2)`, in
/// shear at `sig_y sqrt((1 + R)/(2 (1 + 2 R)))` (Hill 1948). Also with a curve of factors over the
/// rate, which takes the other solver.
#[test]
fn anisotropy_through_the_thickness() {
    let factors = Param::Table(vec![vec![0.0, 1.0], vec![1.0, 1.0]]);
    for r in [0.6, 1.0, 1.8] {
        for more in [&[][..], &[("rate_factors", factors.clone())]] {
            let law = steel(&[&[("lankford", Param::Number(r))], more].concat());
            let mut state = [0.0; COLUMNS];
            let (mut across, mut through) = (0.0, 0.0);
            (0..200).for_each(|_| pull(&*law, &mut state, 1e-4, 1.0));
            assert!((state[0] - YIELD).abs() < 1e-9 * YIELD, "{state:?}");
            // The stress is constant from here on, so that all strains are plastic.
            for _ in 0..10 {
                let (mut low, mut high) = (-1e-4, 1e-4);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let mut trial = state;
                    advance(&*law, &mut trial, [1e-4, middle, 0.0], 1.0);
                    if trial[1] > 0.0 { high = middle } else { low = middle }
                }
                let lateral = 0.5 * (low + high);
                across += lateral;
                through += advance(&*law, &mut state, [1e-4, lateral, 0.0], 1.0);
            }
            assert!((across / through - r).abs() < 1e-6 * r, "{} for {r}", across / through);
            for (strain, column, exact) in [
                ([1e-3, 1e-3, 0.0], 0, (0.5 * (1.0 + r)).sqrt()),
                ([0.0, 0.0, 1e-3], 2, (0.5 * (1.0 + r) / (1.0 + 2.0 * r)).sqrt()),
            ] {
                let mut state = [0.0; COLUMNS];
                (0..20).for_each(|_| {
                    advance(&*law, &mut state, strain, 1.0);
                });
                let got = state[column] / YIELD;
                assert!((got - exact).abs() < 1e-8, "R {r}, {strain:?}: {got} for {exact}");
                // Work: the plastic strain is that of the equivalent stress.
                let before = state;
                advance(&*law, &mut state, strain, 1.0);
                let work: f64 = (0..3).map(|c| before[c] * strain[c]).sum();
                let flow = YIELD * (state[3] - before[3]);
                assert!((work - flow).abs() < 1e-7 * work, "{work} for {flow}");
            }
        }
    }
}
