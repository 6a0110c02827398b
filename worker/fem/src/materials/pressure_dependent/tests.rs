//! Laws with strength by pressure against closed forms. Units mm, ms, kg (GPa).

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, material, problems, table};
use crumple_proto::partition::{Material, Param};

fn list<const N: usize>(numbers: [f64; N]) -> Param {
    Param::List(numbers.to_vec())
}

/// Compresses a cube on all sides to a compaction rho/rho_0 - 1.
fn press(cube: &mut Cube, compaction: f64, steps: usize) {
    let left = -(compaction.ln_1p() + cube.at("logarithm of volume")) / 3.0 / steps as f64;
    (0..steps).for_each(|_| _ = cube.step([left, left, left, 0.0, 0.0, 0.0], 1.0));
}

fn pressure(cube: &Cube) -> f64 {
    -cube.state[..3].iter().sum::<f64>() / 3.0
}

/// Shears a cube at a constant volume by so much plastic strain.
fn shear(cube: &mut Cube, plastic_strain: f64, dt: f64) {
    let end = cube.at("plastic_strain") + plastic_strain;
    while cube.at("plastic_strain") < end && cube.at("failed") == 0.0 {
        cube.step([0.0, 0.0, 0.0, 2e-5, 0.0, 0.0], dt);
    }
}

const ALUMINA_G: f64 = 90.0;
const K: [f64; 3] = [131.0, 20.0, 30.0];
const INTACT: [f64; 2] = [0.93, 0.6];
const BROKEN: [f64; 2] = [0.31, 0.7];
const LIMIT: [f64; 2] = [2.79, 1.46];
const TENSION: f64 = 0.2;

fn alumina(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let constants = [("shear_modulus", ALUMINA_G), ("tensile_strength", TENSION)];
    let lists = [
        ("intact_strength", list(INTACT)),
        ("fractured_strength", list(BROKEN)),
        ("hugoniot_elastic_limit", list(LIMIT)),
        ("pressure", list(K)),
    ];
    let numbers = [&constants, numbers].concat();
    material("johnson_holmquist_ceramic", &numbers, &[&lists, others].concat())
}

/// Strengths of intact and of broken ceramic.
fn strengths(pressure: f64) -> [f64; 2] {
    let at_limit = 1.5 * (LIMIT[0] - LIMIT[1]);
    let over = |p: f64| (p / LIMIT[1]).max(0.0);
    [
        at_limit * INTACT[0] * over(pressure + TENSION).powf(INTACT[1]),
        at_limit * BROKEN[0] * over(pressure).powf(BROKEN[1]),
    ]
}

/// Pressure is the cubic of the compaction, tension the bulk modulus up to its limit.
#[test]
fn ceramic_has_the_pressure_of_its_volume() {
    let mut cube = Cube::new(&alumina(&[], &[]));
    for mu in [0.01, 0.03, 0.1, 0.05] {
        press(&mut cube, mu, 10);
        let exact = K[0] * mu + K[1] * mu * mu + K[2] * mu * mu * mu;
        assert!((pressure(&cube) / exact - 1.0).abs() < 1e-12, "{mu}: {}", pressure(&cube));
        let bulk = (1.0 + mu) * (K[0] + 2.0 * K[1] * mu + 3.0 * K[2] * mu * mu);
        let over = (bulk - K[0]) / (K[0] + 4.0 / 3.0 * ALUMINA_G);
        assert!((cube.at("stiffening") - over).abs() < 1e-12, "{mu}");
    }
    press(&mut cube, -0.001, 10);
    assert!((pressure(&cube) + 0.001 * K[0]).abs() < 1e-12);
    press(&mut cube, -0.01, 10);
    assert!((pressure(&cube) + TENSION).abs() < 1e-12);
    assert_eq!(cube.at("failed"), 0.0);
    let mut tears = Cube::new(&alumina(&[], &[("fails_in_tension", Param::Flag(true))]));
    press(&mut tears, -TENSION / K[0] * 0.999, 10);
    assert_eq!(tears.at("failed"), 0.0);
    press(&mut tears, -TENSION / K[0] * 1.001, 1);
    assert_eq!((tears.at("failed"), &tears.state[..6]), (1.0, &[0.0; 6][..]));
}

/// Damage is the plastic strain over that to fracture; the strength goes from that of intact to
/// that of broken material. The rate raises both.
#[test]
fn ceramic_breaks_to_rubble() {
    let damage = [0.02, 0.8];
    for (dt, factor) in [(1.0, 1.0), (1e-6, f64::NAN)] {
        let others = [("damage", list(damage)), ("rate", list([0.05, 0.01]))];
        let mut cube = Cube::new(&alumina(&[], &others));
        press(&mut cube, 0.02, 100);
        let p = pressure(&cube);
        let [intact, broken] = strengths(p);
        // The rate of a shear increment: 2e-5 / sqrt(3) over the step.
        let rate = 2e-5 / 3.0_f64.sqrt() / dt;
        let factor = if factor == 1.0 { 1.0 } else { 1.0 + 0.05 * (rate / 0.01).ln() };
        let to_fracture = damage[0] * ((p + TENSION) / LIMIT[1]).powf(damage[1]);
        for part in [0.25, 0.5, 0.75, 1.0, 1.25] {
            let before = cube.at("plastic_strain");
            shear(&mut cube, part * to_fracture - before, dt);
            let strain = cube.at("plastic_strain");
            let exact = (strain / to_fracture).min(1.0);
            assert!((cube.at("damage") - exact).abs() < 1e-10, "{} {exact}", cube.at("damage"));
            assert!((pressure(&cube) - p).abs() < 1e-10, "shear has no pressure");
            cube.step([0.0, 0.0, 0.0, 2e-5, 0.0, 0.0], dt);
            let strength = factor * (intact + exact * (broken - intact));
            let mises = cube.von_mises();
            assert!((mises / strength - 1.0).abs() < 1e-10, "{part}: {mises} {strength}");
        }
    }
}

/// Without a strain to fracture it breaks where it yields. The elastic energy that the deviator
/// loses is the energy that bulking adds: `(K1 mu + dp)^2 - (K1 mu)^2 = 2 beta K1 dU`.
#[test]
fn bulking_takes_the_energy_of_the_deviator() {
    for beta in [0.5, 1.0] {
        let brittle = [("damage", list([0.0, 1.0]))];
        let mut cube = Cube::new(&alumina(&[("bulking", beta)], &brittle));
        press(&mut cube, 0.02, 100);
        let p = pressure(&cube);
        shear(&mut cube, 1e-9, 1.0);
        assert_eq!(cube.at("damage"), 1.0);
        let of = |y: f64| y * y / (6.0 * ALUMINA_G);
        let elastic = K[0] * 0.02;
        // The broken strength is that in the pressure with a first estimate of the rise.
        let rise = |at: f64| {
            let lost = of(strengths(p)[0]) - of(strengths(at)[1]);
            (elastic * elastic + 2.0 * beta * K[0] * lost).sqrt() - elastic
        };
        let exact = rise(p + rise(p));
        cube.step([0.0; 6], 1.0);
        let more = pressure(&cube) - p;
        assert!((more / exact - 1.0).abs() < 1e-9 && more > 0.005, "{beta}: {more} {exact}");
        let mut brittle = Cube::new(&alumina(&[], &brittle));
        press(&mut brittle, 0.02, 100);
        shear(&mut brittle, 1e-3, 1.0);
        assert!((pressure(&brittle) - p).abs() < 1e-12, "without beta the pressure stays");
        // Rubble has no tension.
        press(&mut brittle, -0.01, 100);
        assert_eq!(pressure(&brittle), 0.0);
        assert_eq!(brittle.von_mises(), 0.0);
    }
}

const CONCRETE_G: f64 = 14.86;
const FC: f64 = 0.048;
const CRUSHES: [f64; 2] = [0.001, 0.016];
const LOCKS: [f64; 2] = [0.1, 0.8];
const FULL: [f64; 3] = [85.0, -171.0, 208.0];
const PULL: f64 = 0.004;

fn concrete(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let constants = [
        ("shear_modulus", CONCRETE_G),
        ("compressive_strength", FC),
        ("tensile_strength", PULL),
        ("largest_strength", 7.0),
    ];
    let lists = [
        ("strength_constants", list([0.79, 1.6, 0.61])),
        ("crushing_point", list(CRUSHES)),
        ("locking_point", list(LOCKS)),
        ("pressure", list(FULL)),
    ];
    let numbers = [&constants, numbers].concat();
    material("johnson_holmquist_concrete", &numbers, &[&lists, others].concat())
}

fn full(m: f64) -> f64 {
    FULL[0] * m + if m > 0.0 { FULL[1] * m * m + FULL[2] * m * m * m } else { 0.0 }
}

/// Modulus of unloading at the end of the line: that with the work of the curve, by a fine sum.
fn last_modulus() -> f64 {
    let end = (line_end() - LOCKS[0]) / (1.0 + LOCKS[0]);
    let steps = 100_000;
    let pressure = |k: usize| full(end * (k as f64 + 0.5) / steps as f64);
    let work = (0..steps).map(pressure).sum::<f64>() * end / steps as f64 * (1.0 + LOCKS[0]);
    LOCKS[1] * LOCKS[1] / (2.0 * work)
}

/// The compaction at the end of the line, by Newton's method.
fn line_end() -> f64 {
    let mut m = LOCKS[1] / FULL[0];
    for _ in 0..20 {
        let slope = FULL[0] + 2.0 * FULL[1] * m + 3.0 * FULL[2] * m * m;
        m -= (full(m) - LOCKS[1]) / slope;
    }
    LOCKS[0] + m * (1.0 + LOCKS[0])
}

/// Pressure in the three ranges of compaction, and on unloading from each.
#[test]
fn concrete_is_crushed_and_locks() {
    let elastic = CRUSHES[1] / CRUSHES[0];
    let (end, last) = (line_end(), last_modulus());
    let slope = (LOCKS[1] - CRUSHES[1]) / (end - CRUSHES[0]);
    let mut cube = Cube::new(&concrete(&[], &[]));
    let check = |cube: &Cube, exact: f64| {
        let got = pressure(cube);
        assert!((got - exact).abs() < 1e-11, "{got} {exact}");
    };
    press(&mut cube, 0.0005, 10);
    check(&cube, 0.0005 * elastic);
    press(&mut cube, -0.0001, 10);
    check(&cube, -0.0001 * elastic);
    press(&mut cube, -0.001, 10);
    check(&cube, -PULL);
    for mu in [0.02, 0.06, 0.11] {
        press(&mut cube, mu, 50);
        let line = CRUSHES[1] + slope * (mu - CRUSHES[0]);
        check(&cube, line);
        let part = (mu - CRUSHES[0]) / (end - CRUSHES[0]);
        let unloading = elastic + part * (last - elastic);
        press(&mut cube, mu - 1e-4, 10);
        check(&cube, line - unloading * 1e-4);
        let over = ((1.0 + mu - 1e-4) * unloading - elastic) / (elastic + 4.0 / 3.0 * CONCRETE_G);
        assert!((cube.at("stiffening") - over).abs() < 1e-9, "{over}");
        let plastic = mu - line / unloading;
        press(&mut cube, plastic - 1e-5, 10);
        check(&cube, -1e-5 * unloading);
    }
    for mu in [0.12, 0.2, 0.3, 0.15] {
        press(&mut cube, mu, 50);
        check(&cube, full((mu - LOCKS[0]) / (1.0 + LOCKS[0])));
    }
    press(&mut cube, LOCKS[0] - 1e-5, 50);
    check(&cube, full(-1e-5 / (1.0 + LOCKS[0])));
}

/// Strength over pressure, damage and rate; the limit of the strength.
#[test]
fn concrete_has_strength_by_pressure() {
    for mu in [0.0005, 0.02, 0.08, 0.2] {
        let mut cube = Cube::new(&concrete(&[], &[]));
        press(&mut cube, mu, 50);
        let p = pressure(&cube);
        shear(&mut cube, 1e-3, 1.0);
        let exact = FC * (0.79 + 1.6 * (p / FC).powf(0.61)).min(7.0);
        let got = cube.von_mises();
        assert!((got / exact - 1.0).abs() < 1e-12, "{mu}: {got} {exact}");
    }
    // Half of the tension takes half of the strength.
    let mut cube = Cube::new(&concrete(&[], &[]));
    press(&mut cube, -0.5 * PULL / 16.0, 10);
    shear(&mut cube, 1e-4, 1.0);
    assert!((cube.von_mises() / (0.5 * 0.79 * FC) - 1.0).abs() < 1e-12);
    let mut cube = Cube::new(&concrete(&[], &[("rate", list([0.007, 1e-3]))]));
    press(&mut cube, 0.0005, 50);
    let p = pressure(&cube);
    shear(&mut cube, 1e-3, 1e-4);
    let factor = 1.0 + 0.007 * (2e-5 / 3.0_f64.sqrt() / 1e-4 / 1e-3).ln();
    let exact = FC * (0.79 + 1.6 * (p / FC).powf(0.61)) * factor;
    assert!((cube.von_mises() / exact - 1.0).abs() < 1e-12 && factor > 1.03);
}

/// Damage by plastic strain and by plastic compaction; the least strain to fracture.
#[test]
fn concrete_has_damage_by_flow_and_by_crushing() {
    let damage = [("damage", list([0.04, 1.0]))];
    let mut cube = Cube::new(&concrete(&[("least_fracture_strain", 0.01)], &damage));
    press(&mut cube, 0.0003, 50);
    let p = pressure(&cube);
    assert_eq!(cube.at("damage"), 0.0, "no pores are crushed yet");
    let least: f64 = 0.04 * (p + PULL) / FC;
    assert!(least.max(0.01) == 0.01, "the least strain acts");
    shear(&mut cube, 0.004, 1.0);
    let exact = cube.at("plastic_strain") / 0.01;
    assert!((cube.at("damage") - exact).abs() < 1e-12 && exact < 0.5);
    let strength = FC * (0.79 * (1.0 - exact) + 1.6 * (p / FC).powf(0.61));
    cube.step([0.0, 0.0, 0.0, 2e-5, 0.0, 0.0], 1.0);
    assert!((cube.von_mises() / strength - 1.0).abs() < 1e-12);

    // Crushing: sum of the plastic compaction over the strain to fracture, by fine steps.
    let mut cube = Cube::new(&concrete(&[], &damage));
    press(&mut cube, 0.03, 20_000);
    let (end, elastic) = (line_end(), CRUSHES[1] / CRUSHES[0]);
    let last = last_modulus();
    let line = |mu: f64| {
        let part = (mu - CRUSHES[0]) / (end - CRUSHES[0]);
        let p = CRUSHES[1] + part * (LOCKS[1] - CRUSHES[1]);
        (p, mu - p / (elastic + part * (last - elastic)))
    };
    let steps = 20_000;
    let at = |k: usize| line(CRUSHES[0] + (0.03 - CRUSHES[0]) * k as f64 / steps as f64);
    let one = |k: usize| {
        let ((p, before), (_, after)) = (at(k), at(k + 1));
        (after - before) / (0.04 * (p + PULL) / FC)
    };
    let exact: f64 = (0..steps).map(one).sum();
    let got = cube.at("damage");
    assert!((got / exact - 1.0).abs() < 1e-3 && exact > 0.05, "{got} {exact}");
}

/// The ways in which an element of concrete fails.
#[test]
fn concrete_fails_as_asked() {
    let flag = |key| [(key, Param::Flag(true))];
    let strain = PULL / 16.0;
    let mut cube = Cube::new(&concrete(&[], &flag("fails_in_tension")));
    press(&mut cube, -0.99 * strain, 5);
    assert_eq!(cube.at("failed"), 0.0);
    press(&mut cube, -1.01 * strain, 1);
    assert_eq!(cube.at("failed"), 1.0);
    // With half of the damage, half of the tension is left.
    let damage = [("damage", list([0.0, 1.0])), ("fails_in_damaged_tension", Param::Flag(true))];
    let mut cube = Cube::new(&concrete(&[("least_fracture_strain", 0.01)], &damage));
    press(&mut cube, 0.0005, 5);
    shear(&mut cube, 0.005, 1.0);
    let left = 1.0 - cube.at("damage");
    assert!((left - 0.5).abs() < 1e-3);
    let back = -cube.state[3] / CONCRETE_G;
    cube.step([0.0, 0.0, 0.0, back, 0.0, 0.0], 1.0);
    press(&mut cube, -0.45 * strain, 5);
    assert_eq!(cube.at("failed"), 0.0);
    press(&mut cube, -0.55 * strain, 1);
    assert_eq!(cube.at("failed"), 1.0);
    let mut cube = Cube::new(&concrete(&[("failure_strain", 0.01)], &[]));
    shear(&mut cube, 1.0, 1.0);
    assert!((cube.at("plastic_strain") - 0.01).abs() < 2e-5 && cube.at("failed") == 1.0);
}

const COMPACTS: [[f64; 2]; 4] = [[0.0, 0.0], [0.05, 0.002], [0.1, 0.006], [0.3, 0.05]];
const BULK: f64 = 0.4;

fn soil(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let constants = [("shear_modulus", 0.1), ("bulk_modulus", BULK)];
    let lists = [("yield_constants", list([1e-7, 2e-4, 0.3])), ("pressure", table(&COMPACTS))];
    let numbers = [&constants, numbers].concat();
    material("soil", &numbers, &[&lists, others].concat())
}

/// The pressure follows the curve, unloads with the bulk modulus and stops at the cutoff; the
/// strength follows the pressure.
#[test]
fn soil_is_compacted() {
    let mut cube = Cube::new(&soil(&[("tension_cutoff", 5e-4)], &[]));
    let mu = |strain: f64| strain.exp_m1();
    press(&mut cube, mu(0.05), 10);
    assert!((pressure(&cube) - 0.002).abs() < 1e-12);
    press(&mut cube, mu(0.2), 10);
    assert!((pressure(&cube) - 0.028).abs() < 1e-12);
    press(&mut cube, mu(0.15), 10);
    assert!((pressure(&cube) - (0.028 - BULK * 0.05)).abs() < 1e-12);
    press(&mut cube, mu(0.2), 10);
    let p = pressure(&cube);
    assert!((p - 0.028).abs() < 1e-12, "reloading returns to the curve");
    shear(&mut cube, 1e-2, 1.0);
    let exact = (3.0 * (1e-7 + 2e-4 * p + 0.3 * p * p)).sqrt();
    assert!((cube.von_mises() / exact - 1.0).abs() < 1e-12);
    press(&mut cube, mu(0.0), 10);
    assert_eq!(pressure(&cube), -5e-4);
    assert!(
        (cube.von_mises() - (3.0 * (1e-7 - 2e-4 * 5e-4 + 0.3 * 25e-8_f64)).max(0.0).sqrt()).abs()
            < 1e-9
    );
    let mut cube = Cube::new(&soil(&[], &[("reversible", Param::Flag(true))]));
    press(&mut cube, mu(0.2), 10);
    press(&mut cube, mu(0.05), 10);
    assert!((pressure(&cube) - 0.002).abs() < 1e-12);
}

/// Closed random paths give no energy: the work is no less than what the deviator still stores.
#[test]
fn closed_paths_of_these_laws_cost_work() {
    let damage = |d1: f64| [("damage", list([d1, 1.0]))];
    let laws = [
        (alumina(&[], &damage(0.02)), 1e-3, ALUMINA_G),
        (concrete(&[], &damage(0.04)), 2e-4, CONCRETE_G),
        (concrete(&[], &damage(0.04)), 3e-3, CONCRETE_G),
        (soil(&[], &[]), 5e-3, 0.1),
    ];
    for (law, size, shear) in &laws {
        for seed in 0..20 {
            let mut cube = Cube::new(law);
            let mut noise = Noise(seed);
            let path: Vec<[f64; 6]> =
                (0..4).map(|_| std::array::from_fn(|_| size * noise.next())).collect();
            for sign in [1.0, -1.0] {
                for e in &path {
                    (0..40).for_each(|_| _ = cube.step(e.map(|e| sign * e), 1.0));
                }
            }
            // The pressure stores more. The tolerance is that of work by trapezoids.
            let stored = cube.von_mises().powi(2) / (6.0 * shear);
            let off = cube.work - stored;
            assert!(off > -1e-3 * stored, "{} {seed}: {} {stored}", law.law, cube.work);
        }
    }
}

/// The work that crushing takes and unloading gives back: no cycle of compaction gives energy, also
/// across the end of the line.
#[test]
fn cycles_of_compaction_cost_work() {
    let law = concrete(&[], &[]);
    let mut cube = Cube::new(&law);
    let zero = |most: f64| {
        let (end, last) = (line_end(), last_modulus());
        let part = (most - CRUSHES[0]) / (end - CRUSHES[0]);
        let p = CRUSHES[1] + part * (LOCKS[1] - CRUSHES[1]);
        let elastic = CRUSHES[1] / CRUSHES[0];
        most - p / (elastic + part * (last - elastic))
    };
    press(&mut cube, zero(0.05).max(0.0), 2000);
    let mut before = 0.0;
    for most in [0.05, 0.08, 0.1, 0.109, 0.1104, 0.1125, 0.12, 0.15] {
        press(&mut cube, most, 4000);
        let end = if most < line_end() { zero(most) } else { LOCKS[0] };
        press(&mut cube, end, 4000);
        // Without pores the pressure is that of the volume, and the cycle costs nothing.
        assert!(cube.work > before - 1e-9, "{most}: {} {before}", cube.work);
        assert!(pressure(&cube).abs() < 1e-6);
        before = cube.work;
    }
}

#[test]
fn wrong_constants_are_refused() {
    let text = problems(&material("johnson_holmquist_ceramic", &[], &[]));
    for key in ["shear_modulus", "intact_strength", "hugoniot_elastic_limit", "pressure"] {
        assert!(text.contains(&format!("{key} is missing")), "{key}: {text}");
    }
    let text = problems(&alumina(&[], &[("hugoniot_elastic_limit", list([1.0, 2.0]))]));
    assert!(text.contains("below the stress"), "{text}");
    let text = problems(&concrete(&[], &[("crushing_point", list([0.01, 0.016]))]));
    assert!(text.contains("the last the largest"), "{text}");
    let text = problems(&concrete(&[], &[("locking_point", list([0.1, 1e9]))]));
    assert!(text.contains("never gives the pressure"), "{text}");
    let text = problems(&concrete(&[], &[("pressure", list([10.0, 0.0, 0.0]))]));
    assert!(text.contains("the last the largest"), "{text}");
    for law in [concrete, alumina] {
        let text = problems(&law(&[], &[("pressure", list([85.0, -171.0, 100.0]))]));
        assert!(text.contains("falls in compression"), "{text}");
        let tears = [("fails_in_tension", Param::Flag(true))];
        let text = problems(&law(&[("tensile_strength", 0.0)], &tears));
        assert!(text.contains("without a tensile strength"), "{text}");
    }
    let text = problems(&soil(&[("bulk_modulus", 0.1)], &[]));
    assert!(text.contains("at least the largest slope"), "{text}");
    let text = problems(&soil(&[], &[("pressure", table(&[[0.0, 0.1], [0.1, 0.2]]))]));
    assert!(text.contains("begin it with [0, 0]"), "{text}");
}
