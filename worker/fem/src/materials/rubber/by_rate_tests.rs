//! Rubber and foam by tests at several rates: each test again, between two of them, relaxation to
//! the slowest one, energy of cycles.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, material, problems, table};
use crumple_proto::partition::{Material, Param};

/// Rates of the tests, and their stress over that of the slowest one.
const TESTS: [[f64; 2]; 3] = [[0.1, 1.0], [1.0, 1.3], [10.0, 2.0]];

/// Nominal stress of the slowest test [MPa].
fn slowest(strain: f64) -> f64 {
    let l = 1.0 + strain;
    0.5 * (l - l.powi(-2)) + 0.02 * (l.powi(3) - l.powf(-3.0))
}

/// Points from a strain of -0.6 to 2.
fn strains() -> impl Iterator<Item = f64> + Clone {
    (-6..=20).map(|k| 0.1 * f64::from(k))
}

fn by_rate(key: (&str, f64), nominal: bool) -> Material {
    let rows: Vec<[f64; 3]> = TESTS
        .iter()
        .flat_map(|&[rate, factor]| strains().map(move |e| [rate, e, factor * slowest(e)]))
        .collect();
    let nominal = Param::Flag(nominal);
    material(
        "tabulated_rubber",
        &[key],
        &[("curve_by_rate", table(&rows)), ("nominal_rate", nominal)],
    )
}

/// The law of the slowest test alone.
fn slow(key: (&str, f64)) -> Material {
    let points: Vec<[f64; 2]> = strains().map(|e| [e, slowest(e)]).collect();
    material("tabulated_rubber", &[key], &[("curve", table(&points))])
}

const RUBBER: (&str, f64) = ("bulk_modulus", 1e5);
const FOAM: (&str, f64) = ("poisson", 0.3);

/// Stretches a cube along x at a constant rate with free sides.
fn stretch_at(cube: &mut Cube, to: f64, steps: usize, (rate, nominal): (f64, bool)) {
    let each = (to.ln() - cube.strain[0]) / steps as f64;
    for _ in 0..steps {
        let stretch = (cube.strain[0] + each).exp();
        let dt = each.abs() * if nominal { stretch } else { 1.0 } / rate;
        cube.pull([2.0 * (0.5 * each).tanh(), 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], dt);
    }
}

/// Returns the nominal stress along x.
fn nominal_stress(cube: &Cube) -> f64 {
    cube.state[0] * (cube.strain[1] + cube.strain[2]).exp()
}

/// A uniaxial test at a constant rate, true or nominal, has the stress of its curve; between two
/// rates it is linear, beyond them constant. The tolerance is the rest of the sum of f; in rubber
/// also the stress over K, and the steps in which the mean of the rate begins.
#[test]
fn a_test_at_a_constant_rate_has_its_curve() {
    for (key, nominal) in
        [(RUBBER, false), (RUBBER, true), (FOAM, false), (FOAM, true), (("poisson", 0.0), false)]
    {
        let law = by_rate(key, nominal);
        for [rate, factor] in [[0.01, 1.0], [0.55, 1.15], [5.5, 1.65], [50.0, 2.0]] {
            for strain in [-0.5, 1.5] {
                let mut cube = Cube::new(&law);
                stretch_at(&mut cube, 1.0 + strain, 500, (rate, nominal));
                let off = nominal_stress(&cube) / (factor * slowest(strain)) - 1.0;
                assert!(off.abs() < 2e-4, "{key:?} {nominal} {rate} {strain}: {off:e}");
            }
        }
    }
}

/// At rest the stress is that of the slowest test, and unloading follows it at any rate: the energy
/// of a cycle is the area between the curves, within the steps in which the rate begins.
#[test]
fn rest_and_unloading_have_the_slowest_curve() {
    for key in [RUBBER, FOAM] {
        for to in [0.5, 1.8] {
            let [mut fast, mut rest] = [by_rate(key, false), slow(key)].map(|law| Cube::new(&law));
            stretch_at(&mut fast, to, 800, (10.0, false));
            let loaded = fast.work;
            fast.step([0.0; 6], 1e-3);
            // The same strain without a rate.
            let mut strain = fast.strain;
            (0..3).for_each(|c| strain[c] /= 800.0);
            (0..800).for_each(|_| _ = rest.step(strain.map(|e| 2.0 * (0.5 * e).tanh()), 1.0));
            for c in 0..3 {
                let size = rest.state[0].abs().max(1.0);
                assert!((fast.state[c] - rest.state[c]).abs() < 1e-5 * size, "{key:?} {to} {c}");
            }
            stretch_at(&mut fast, 1.0, 800, (10.0, false));
            // The fastest curve is twice the slowest one: half of the work is lost.
            let lost = fast.work / loaded - 0.5;
            assert!(lost.abs() < 5e-3, "{key:?} {to}: {lost}");
        }
    }
}

/// Random closed paths at changing rates never give energy, beyond the half of a step in which the
/// overstress of loading still acts where the path turns.
#[test]
fn closed_paths_at_all_rates_take_energy() {
    let mut noise = Noise(11);
    for key in [("bulk_modulus", 20.0), FOAM] {
        for nominal in [false, true] {
            let mut lost = 0.0;
            for _ in 0..6 {
                let mut cube = Cube::new(&by_rate(key, nominal));
                let path: Vec<[f64; 6]> =
                    (0..4).map(|_| std::array::from_fn(|_| 1e-3 * noise.next())).collect();
                let back = path.iter().rev().map(|e| e.map(|e| -e));
                let mut most = 0.0f64;
                for e in path.iter().copied().chain(back) {
                    let dt = 1e-4 * (3.0 * noise.next()).exp();
                    for _ in 0..200 {
                        cube.step(e, dt);
                        most = most.max(cube.work);
                        assert!(cube.work > -1e-3 * most, "{key:?} {nominal}: {}", cube.work);
                    }
                }
                lost += cube.work / most;
            }
            assert!(lost > 0.1, "{key:?} {nominal}: {lost}");
        }
    }
}

/// With a time of averaging the stress after a sudden start is late by this time.
#[test]
fn a_time_of_averaging_delays_the_rate() {
    let mut law = by_rate(RUBBER, false);
    law.parameters.insert("rate_averaging_time".into(), Param::Number(0.05));
    let mut cube = Cube::new(&law);
    let steps = 1000;
    stretch_at(&mut cube, 0.25f64.exp(), steps, (5.5, false));
    // The mean of a constant rate over a time t is late by exp(-t/0.05).
    let exact = 5.5 * (1.0 - (-0.25 / 5.5 / 0.05_f64).exp());
    assert!((cube.at("strain rate") / exact - 1.0).abs() < 5e-3, "{}", cube.at("strain rate"));
}

/// Each wrong parameter has an error that names it.
#[test]
fn wrong_curves_by_rate_are_refused() {
    let of = |rows: &[[f64; 3]], others: &[(&str, Param)]| {
        let others = [&[("curve_by_rate", table(rows))], others].concat();
        problems(&material("tabulated_rubber", &[("bulk_modulus", 100.0)], &others))
    };
    let line = |rate: f64, factor: f64| {
        [-0.5, 0.0, 0.5].map(|e: f64| [rate, e, factor * (1.0 + e - (1.0 + e).powi(-2))])
    };
    let two = [line(0.0, 1.0), line(1.0, 2.0)].concat();
    let crossing = [line(0.0, 1.0), line(1.0, 0.9)].concat();
    let back = [line(1.0, 1.0), line(0.0, 2.0)].concat();
    let curve = ("curve", table(&[[-0.5, -1.0], [0.0, 0.0], [0.5, 0.8]]));
    for (text, words) in [
        (of(&two, &[curve]), "together with curve"),
        (of(&crossing, &[]), "lies below that of the rate before it"),
        (of(&back, &[]), "rates in the wrong order"),
        (of(&two[2..], &[]), "the sign of the strain"),
        (of(&two, &[("rate_averaging_time", Param::Number(0.0))]), "above 0"),
        (of(&[line(0.0, 1.0), line(1.0, 500.0)].concat(), &[]), "2/3 of the shear modulus"),
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let mut slow = slow(RUBBER);
    slow.parameters.insert("nominal_rate".into(), Param::Flag(true));
    assert!(problems(&slow).contains("without curve_by_rate"));
}
