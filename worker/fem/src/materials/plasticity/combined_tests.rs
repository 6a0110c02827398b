//! Mixed hardening and rates on paths with known results. Units as GPa and ms: E = 210, nu = 0.3,
//! yield 0.25.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, Sheet, material, problems, table};
use crumple_proto::partition::{Material, Param};

const E: f64 = 210.0;
const NU: f64 = 0.3;
const YIELD: f64 = 0.25;
const STEEL: [(&str, f64); 2] = [("youngs_modulus", E), ("poisson", NU)];

fn steel(more: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    material("j2", &[&STEEL, more].concat(), others)
}

/// Uniaxial stress to 2 % strain, back to -1 % and to 2 % again: with the isotropic modulus h and
/// the kinematic modulus k each branch is a straight line of known ends (Bauschinger effect).
#[test]
fn reversed_uniaxial_stress_follows_the_closed_form() {
    for (h, k) in [(0.0, 2.0), (1.0, 1.0), (1.5, 0.5)] {
        let law = steel(
            &[("yield_stress", YIELD), ("hardening_modulus", h), ("kinematic_modulus", k)],
            &[],
        );
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        let (mut strain, mut plastic, mut sum) = (0.0, 0.0, 0.0);
        for (to, sign) in [(0.02, 1.0), (-0.01, -1.0), (0.02, 1.0)] {
            let step = (to - strain) / 300.0;
            for _ in 0..300 {
                cube.pull([step, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
                sheet.pull(step, 1.0);
            }
            // sigma = E (to - plastic) = k plastic + sign (yield + h sum), with the sum of all
            // plastic strains.
            strain = to;
            let before = (plastic, sum);
            plastic = (E * to - sign * (YIELD + h * before.1) + h * before.0) / (E + h + k);
            sum += sign * (plastic - before.0);
            let exact = E * (to - plastic);
            for (name, got) in [("cube", cube.state[0]), ("sheet", sheet.state[0])] {
                assert!((got / exact - 1.0).abs() < 1e-9, "{name} {h} {k}: {got} for {exact}");
            }
            assert!((cube.at("plastic_strain") - sum).abs() < 1e-10 && sum > 0.0);
            assert!((sheet.state[3] - sum).abs() < 1e-10);
        }
    }
}

/// The work without the elastic energy and that of the back stress never decreases on a random
/// path.
#[test]
fn dissipation_never_decreases() {
    let k = 20.0;
    let law = steel(&[("yield_stress", YIELD), ("kinematic_modulus", k)], &[]);
    let mut cube = Cube::new(&law);
    let (g, bulk) = (0.5 * E / (1.0 + NU), E / (3.0 * (1.0 - 2.0 * NU)));
    let mut noise = Noise(3);
    let (mut last, mut flow) = (0.0, [0.0; 6]);
    for step in 0..4000 {
        if step % 50 == 0 {
            flow = std::array::from_fn(|c| 2e-5 * noise.next() - if c < 3 { 0.0 } else { 1e-6 });
        }
        // The work is that of small strains.
        cube.strain = [0.0; 6];
        cube.step(flow, 1.0);
        let s = &cube.state;
        let mean = (s[0] + s[1] + s[2]) / 3.0;
        let square = |t: &[f64], mean: f64| {
            t[..3].iter().map(|x| (x - mean) * (x - mean)).sum::<f64>()
                + 2.0 * t[3..6].iter().map(|x| x * x).sum::<f64>()
        };
        let stored = square(s, mean) / (4.0 * g)
            + mean * mean / (2.0 * bulk)
            + 0.75 * square(&s[6..], 0.0) / k;
        let lost = cube.work - stored;
        assert!(lost > last - 1e-7, "step {step}: {lost} after {last}");
        last = lost;
    }
    assert!(last > 1e-3, "the path must flow, by several times the elastic energy: {last}");
}

/// In steady shear the whole rate is plastic: the stress is that of the curve at this rate, by
/// Cowper and Symonds, by a curve of factors, and by tables.
#[test]
fn viscoplastic_flow_has_the_stress_of_its_rate() {
    let viscoplastic = ("viscoplastic", Param::Flag(true));
    let yields =
        |more: (&str, Param)| steel(&[("yield_stress", YIELD)], &[viscoplastic.clone(), more]);
    let rate = 100.0 / 3.0_f64.sqrt();
    let rows = [[0.0, 0.0, 0.2], [0.0, 1.0, 0.3], [100.0, 0.0, 0.4], [100.0, 1.0, 0.7]];
    let between = rate / 100.0;
    type Stress<'a> = &'a dyn Fn(f64) -> f64;
    let cases: [(Material, Stress<'_>); 3] = [
        (yields(("cowper_symonds", Param::List(vec![40.0, 5.0]))), &|_| {
            YIELD * (1.0 + (rate / 40.0).powf(0.2))
        }),
        (yields(("rate_factors", table(&[[0.0, 1.0], [50.0, 1.5], [100.0, 1.8]]))), &|_| {
            YIELD * (1.5 + 0.3 * (rate - 50.0) / 50.0)
        }),
        (steel(&[], &[viscoplastic.clone(), ("hardening_by_rate", table(&rows))]), &|eps| {
            (1.0 - between) * (0.2 + 0.1 * eps) + between * (0.4 + 0.3 * eps)
        }),
    ];
    for (law, stress) in cases {
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        for _ in 0..2000 {
            cube.step([0.0, 0.0, 0.0, 0.0, 1e-4, 0.0], 1e-6);
            sheet.step([0.0, 0.0, 1e-4], 1e-6);
        }
        let exact = stress(cube.at("plastic_strain"));
        // Hardening keeps a part of the rate elastic: 0.3/(3 G) of it.
        for (name, got) in [("cube", cube.von_mises()), ("sheet", 3.0_f64.sqrt() * sheet.state[2])]
        {
            assert!((got / exact - 1.0).abs() < 2e-3, "{name}: {got} for {exact}");
            assert!(got > 1.05 * YIELD, "the rate must act: {got}");
        }
    }
}

/// At a given rate of the total strain the stress is that of the table at this rate, below, between
/// and above its rates.
#[test]
fn tables_by_rate_are_interpolated() {
    let rows =
        [[1.0, 0.0, 0.2], [1.0, 0.1, 0.3], [1.0, 0.5, 0.35], [11.0, 0.0, 0.4], [11.0, 0.5, 0.8]];
    let law = steel(&[], &[("hardening_by_rate", table(&rows))]);
    let low = |eps: f64| if eps < 0.1 { 0.2 + eps } else { 0.3 + 0.125 * (eps - 0.1) };
    for rate in [0.1, 1.0, 3.0, 8.5, 11.0, 100.0] {
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        let (shear, dt) = (1e-3, 1e-3 / 3.0_f64.sqrt() / rate);
        let share = ((rate - 1.0) / 10.0).clamp(0.0, 1.0);
        for _ in 0..400 {
            cube.step([0.0, 0.0, 0.0, shear, 0.0, 0.0], dt);
            sheet.step([0.0, 0.0, shear], dt);
            for (got, eps) in [
                (cube.von_mises(), cube.at("plastic_strain")),
                (3.0_f64.sqrt() * sheet.state[2], sheet.state[3]),
            ] {
                let exact = (1.0 - share) * low(eps) + share * (0.4 + 0.8 * eps);
                let yields = eps > 0.0;
                assert!(!yields || (got / exact - 1.0).abs() < 1e-9, "{rate} {eps}: {got} {exact}");
            }
        }
        assert!(cube.at("plastic_strain") > 0.2 && sheet.state[3] > 0.2);
    }
}

/// The same law by either code: without kinematic hardening, and with a table of one rate.
#[test]
fn one_rate_is_isotropic_hardening() {
    let plain = steel(&[], &[("hardening", table(&[[0.0, 0.25], [0.02, 0.3], [0.05, 0.6]]))]);
    let rows = [[0.0, 0.0, 0.25], [0.0, 0.02, 0.3], [0.0, 0.05, 0.6]];
    let by_rate = steel(&[("failure_strain", 0.045)], &[("hardening_by_rate", table(&rows))]);
    let mut cubes = [&plain, &by_rate].map(Cube::new);
    let mut sheets = [&plain, &by_rate].map(Sheet::new);
    let mut noise = Noise(5);
    for _ in 0..300 {
        let strain: [f64; 6] = std::array::from_fn(|_| 1e-3 * noise.next());
        cubes.iter_mut().for_each(|cube| _ = cube.step(strain, 1e-3));
        let [x, y, t, ..] = strain;
        sheets.iter_mut().for_each(|sheet| sheet.step([x, y, t], 1e-3));
        if cubes[1].at("failed") + sheets[1].state[4] > 0.0 {
            break;
        }
        for c in 0..7 {
            let [a, b] = [cubes[0].state[c], cubes[1].state[c]];
            assert!((a - b).abs() < 1e-9, "cube {c}: {a} {b}");
        }
        for c in 0..4 {
            let [a, b] = [sheets[0].state[c], sheets[1].state[c]];
            assert!((a - b).abs() < 1e-9, "sheet {c}: {a} {b}");
        }
    }
    let [failed, other] = [cubes[1].at("plastic_strain"), sheets[1].state[3]];
    assert!(failed.max(other) > 0.044, "the path must flow to failure: {failed} {other}");
}

/// Each wrong parameter has an error that names it.
#[test]
fn wrong_tables_are_refused() {
    let falling = table(&[[0.0, 0.0, 0.3], [0.0, 0.1, 0.2]]);
    let crossing = table(&[[0.0, 0.0, 0.3], [0.0, 0.1, 0.6], [1.0, 0.0, 0.4], [1.0, 0.2, 0.7]]);
    let unsorted = table(&[[2.0, 0.0, 0.3], [1.0, 0.0, 0.4]]);
    for (law, words) in [
        (steel(&[], &[("hardening_by_rate", falling)]), "decreases from one row of a rate"),
        (steel(&[], &[("hardening_by_rate", unsorted)]), "do not increase"),
        (steel(&[], &[("hardening_by_rate", table(&[[1.0, 2.0]]))]), "rows [[rate, eps_p"),
        (
            steel(&[("yield_stress", 1.0)], &[("hardening_by_rate", table(&[[0.0, 0.0, 1.0]]))]),
            "together with yield_stress",
        ),
        (
            steel(&[("yield_stress", 1.0)], &[("rate_factors", table(&[[0.0, 2.0], [1.0, 1.0]]))]),
            "wrong order",
        ),
        (
            steel(&[("yield_stress", 1.0)], &[("viscoplastic", Param::Flag(true))]),
            "without a dependence",
        ),
        (steel(&[("yield_stress", 1.0), ("viscoplastic", 1.0)], &[]), "not a flag"),
        (steel(&[], &[("hardening_by_rate", crossing)]), "rate 1 and the plastic strain 0.1"),
        (steel(&[("yield_stress", 1.0), ("kinematic_modulus", -1.0)], &[]), "0 or above"),
    ] {
        let text = problems(&law);
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// A table whose lowest rate has one row is constant beyond the last row of its other rates.
#[test]
fn a_table_is_constant_beyond_its_last_row() {
    let rows = [[1.0, 0.0, 0.3], [2.0, 0.0, 0.4], [2.0, 0.01, 0.6]];
    let mut cube = Cube::new(&steel(&[], &[("hardening_by_rate", table(&rows))]));
    (0..400).for_each(|_| _ = cube.step([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1e-6));
    assert!(cube.at("plastic_strain") > 0.1 && (cube.von_mises() / 0.6 - 1.0).abs() < 1e-9);
}

/// The fraction that is left is that of the deviator, not of the stress relative to the back
/// stress: 1 - 3 G y/trial in the first step, and near 1 where the back stress carries the stress.
#[test]
fn what_is_left_is_of_the_deviator() {
    let law = steel(&[("yield_stress", YIELD), ("kinematic_modulus", 20.0)], &[]);
    let mut cube = Cube::new(&law);
    let g = 0.5 * E / (1.0 + NU);
    for step in 0..200 {
        let trial = cube.state[3] + g * 1e-3;
        let left = cube.step([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1.0);
        assert!((left - (cube.state[3] / trial).min(1.0)).abs() < 1e-12, "{step}: {left}");
    }
    assert!(cube.von_mises() > 5.0 * YIELD, "the back stress is larger than the yield stress");
}

/// A step of no time with stress and strain gives numbers, at rates and with viscoplastic flow.
#[test]
fn a_step_without_time_is_finite() {
    let rate = ("cowper_symonds", Param::List(vec![40.0, 5.0]));
    for viscoplastic in [false, true] {
        let flag = ("viscoplastic", Param::Flag(viscoplastic));
        let numbers = [("yield_stress", YIELD), ("kinematic_modulus", 1.0)];
        let law = steel(&numbers, &[rate.clone(), flag]);
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        for (shear, dt) in [(0.0, 0.0), (1e-2, 1e-3), (0.0, 0.0), (1e-2, 0.0)] {
            cube.step([0.0, 0.0, 0.0, shear, 0.0, 0.0], dt);
            sheet.step([0.0, 0.0, shear], dt);
            let all = cube.state.iter().chain(&sheet.state);
            assert!(all.into_iter().all(|value| value.is_finite()), "{:?}", cube.state);
        }
    }
}

/// The thickness strain of the step in which a point fails is that before its stress is removed.
#[test]
fn failure_does_not_thicken_a_sheet() {
    let numbers = [("yield_stress", YIELD), ("kinematic_modulus", 1.0)];
    let [mut fails, mut holds] = [[("failure_strain", 0.01)].as_slice(), &[]]
        .map(|more| Sheet::new(&steel(&[&numbers, more].concat(), &[])));
    for _ in 0..200 {
        _ = [&mut fails, &mut holds].map(|sheet| sheet.step([1e-4, 0.0, 0.0], 1.0));
        assert!((fails.strain[3] - holds.strain[3]).abs() < 1e-15, "{:?}", fails.strain);
        if fails.state[0] == 0.0 {
            return;
        }
    }
    panic!("it must fail");
}
