//! Values of the formula, heating, and failure. 42CrMo4 of verification B02 in mm, ms, kg: GPa
//! and J/(kg K).

use crate::materials::{PlaneStress, Points, Solid, SolidPoint, build, build_solid};
use crumple_proto::partition::{Material, Param};

const A: f64 = 0.806;
const B: f64 = 0.614;
const N: f64 = 0.168;
const C: f64 = 0.0089;
const M: f64 = 1.1;
const RHO: f64 = 7.83e-6;

fn steel(more: &[(&str, Param)]) -> Material {
    let numbers = [
        ("youngs_modulus", 206.9),
        ("poisson", 0.3),
        ("a", A),
        ("b", B),
        ("n", N),
        ("c", C),
        ("reference_rate", 1e-3),
        ("m", M),
        ("reference_temperature", 20.0),
        ("melting_temperature", 1540.0),
        ("specific_heat", 460.0),
    ];
    let mut parameters: std::collections::BTreeMap<_, _> =
        numbers.iter().map(|&(key, value)| (key.to_string(), Param::Number(value))).collect();
    parameters.extend(more.iter().map(|(key, value)| (key.to_string(), value.clone())));
    Material { name: "42CrMo4".into(), law: "johnson_cook".into(), density: RHO, parameters }
}

fn solid(more: &[(&str, Param)]) -> Box<dyn Solid> {
    build_solid(&steel(more)).map_err(|problems| format!("{problems:?}")).unwrap()
}

/// Returns the stress of the formula at a plastic strain, a rate over the reference rate, and a
/// temperature rise.
fn formula(eps_p: f64, rate: f64, rise: f64) -> f64 {
    (A + B * eps_p.powf(N)) * (1.0 + C * rate.max(1.0).ln()) * (1.0 - (rise / 1520.0).powf(M))
}

/// Applies a shear of `gamma` in `dt`: effective rate gamma/(sqrt 3 dt).
fn shear(law: &dyn Solid, state: &mut [f64], gamma: f64, dt: f64) {
    law.update_one(SolidPoint { state, strain: &[0.0, 0.0, 0.0, gamma, 0.0, 0.0] }, dt);
}

#[test]
fn stress_is_that_of_the_formula() {
    // By hand: (806 + 614 0.67920) (1 + 0.0089 6.90776) (1 - 0.155541) MPa.
    assert!((formula(0.1, 1e3, 280.0) - 1.09629).abs() < 1e-5, "{}", formula(0.1, 1e3, 280.0));
    let law = solid(&[]);
    for (eps_p, rise) in [(0.0, 0.0), (1e-3, 0.0), (0.1, 280.0), (1.0, 900.0)] {
        for rate in [1e-2, 1.0, 1e3, 1e5] {
            let mut state = [0.0; 10];
            (state[6], state[7]) = (eps_p, rise);
            let gamma = 0.05;
            shear(&*law, &mut state, gamma, gamma / 3.0_f64.sqrt() / (1e-3 * rate));
            let wanted = formula(state[6], rate, rise);
            let stress = 3.0_f64.sqrt() * state[3];
            assert!(state[6] > eps_p);
            assert!(
                (stress - wanted).abs() < 1e-9 * wanted,
                "return to 1e-10 of yield: {stress} for {wanted}"
            );
        }
    }
}

/// Above the strain at which a + b eps^n reaches the largest stress, the yield stress is that
/// stress times the factors of rate and temperature, in solids and in shells.
#[test]
fn hardening_ends_at_the_largest_stress() {
    const LARGEST: f64 = 1.1;
    let with_limit = [("largest_stress", Param::Number(LARGEST))];
    let factors = (1.0 + C * 1e3_f64.ln()) * (1.0 - (280.0_f64 / 1520.0).powf(M));
    let law = solid(&with_limit);
    // 0.806 + 0.614 0.0243^0.168 = 1.1353: the curve is above the limit from 0.0125 on.
    for (eps_p, wanted) in [(1e-4, None), (0.012, Some(LARGEST)), (0.5, Some(LARGEST))] {
        let mut state = [0.0; 10];
        (state[6], state[7]) = (eps_p, 280.0);
        let gamma = 0.05;
        shear(&*law, &mut state, gamma, gamma / 3.0_f64.sqrt());
        let static_stress = (A + B * state[6].powf(N)).min(LARGEST);
        assert!(wanted.is_none_or(|wanted| wanted == static_stress));
        let wanted = static_stress * factors;
        let stress = 3.0_f64.sqrt() * state[3];
        assert!(
            (stress - wanted).abs() < 1e-9 * wanted,
            "return to 1e-10 of yield: {stress} for {wanted}"
        );
    }
    let shell = build(&steel(&with_limit)).map_err(|problems| format!("{problems:?}")).unwrap();
    let (mut state, mut thinning) = ([0.0; 7], [0.0]);
    (state[3], state[4]) = (0.012, 280.0);
    let strain = [[0.0, 0.0, 0.05]];
    let points = Points { state: &mut state, strain: &strain, thickness_strain: &mut thinning };
    shell.update_one(points, 0.05 / 3.0_f64.sqrt());
    let (stress, wanted) = (3.0_f64.sqrt() * state[2], LARGEST * factors);
    assert!(
        (stress - wanted).abs() < 1e-9 * wanted,
        "return to 1e-10 of yield: {stress} for {wanted}"
    );
    assert!(build_solid(&steel(&[("largest_stress", Param::Number(0.9 * A))])).is_err());
}

#[test]
fn plastic_work_becomes_heat() {
    let law = solid(&[]);
    let (mut state, mut work) = ([0.0; 10], 0.0);
    for _ in 0..2000 {
        let before = state[6];
        shear(&*law, &mut state, 1e-3, 1e-3);
        work += 3.0_f64.sqrt() * state[3] * (state[6] - before);
    }
    let wanted = 0.9 * work / (RHO * 460.0);
    assert!(
        state[7] > 300.0 && (state[7] - wanted).abs() < 1e-9 * wanted,
        "temperature from the dissipated work: {} for {wanted}",
        state[7]
    );
    assert!(3.0_f64.sqrt() * state[3] < 0.9 * formula(state[6], 577.0, 0.0), "and softens");
}

/// In shear the mean stress is zero: eps_f = (D1 + D2)(1 + D4 ln rate*).
#[test]
fn damage_adds_up_to_failure() {
    let d = [0.05, 0.1, -2.0, 0.01, 0.0];
    let law = solid(&[("damage", Param::List(d.to_vec()))]);
    let mut state = [0.0; 10];
    let rate = 1e-3 / 3.0_f64.sqrt() / 1e-3 / 1e-3;
    let wanted = (d[0] + d[1]) * (1.0 + d[3] * rate.ln());
    while state[9] == 0.0 {
        shear(&*law, &mut state, 1e-3, 1e-3);
        assert!(state[6] < 1.0, "the point must fail");
    }
    assert!((state[6] - wanted).abs() < 6e-4, "one step of 5.8e-4: {} for {wanted}", state[6]);
    assert!(state[..6].iter().all(|s| *s == 0.0));

    // With additional hydrostatic tension, at sig* = 1.5 and above, it fails at once; under
    // pressure it fails late.
    let strain_to_failure = |pressure: f64| {
        let mut state = [0.0; 10];
        (0..3).for_each(|c| state[c] = -pressure);
        while state[9] == 0.0 {
            shear(&*law, &mut state, 1e-3, 1e-3);
        }
        state[6]
    };
    assert!(
        strain_to_failure(-5.0)
            < (d[0] + d[1] * (-3.0_f64).exp()) * (1.0 + d[3] * rate.ln()) + 6e-4
    );
    assert!(strain_to_failure(1.0) > 2.0 * wanted);
}

/// Shells use the same law: in pure shear, plane stress equals the three-dimensional state.
#[test]
fn shells_and_solids_agree_in_shear() {
    let damage = ("damage", Param::List(vec![0.05, 0.1, -2.0, 0.01, 0.5]));
    let flat = build(&steel(std::slice::from_ref(&damage)))
        .map_err(|problems| format!("{problems:?}"))
        .unwrap();
    let law = solid(&[damage]);
    assert_eq!(PlaneStress::history(&*flat), Solid::history(&*law));
    let (mut plane, mut cube) = ([0.0; 7], [0.0; 10]);
    for _ in 0..400 {
        let mut thinning = [0.0];
        let points = Points {
            state: &mut plane,
            strain: &[[0.0, 0.0, 1e-3]],
            thickness_strain: &mut thinning,
        };
        flat.update_one(points, 1e-3);
        shear(&*law, &mut cube, 1e-3, 1e-3);
        for (a, b) in [(2, 3), (3, 6), (4, 7), (5, 8), (6, 9)] {
            assert!(
                (plane[a] - cube[b]).abs() <= 1e-7 * cube[b].abs(),
                "1e-10 of yield, summed: {plane:?} {cube:?}"
            );
        }
    }
    assert_eq!(plane[6], 1.0, "both points have failed");
}

#[test]
fn missing_or_wrong_parameters_are_reported() {
    let mut material = steel(&[
        ("damage", Param::List(vec![1.0, 2.0])),
        ("melting_temperature", Param::Number(10.0)),
    ]);
    material.parameters.remove("reference_rate");
    let problems = build(&material).err().expect("three errors");
    let paths: Vec<_> = problems.iter().map(|problem| problem.path.as_str()).collect();
    assert_eq!(paths, ["damage", "reference_rate", "melting_temperature"]);
}
