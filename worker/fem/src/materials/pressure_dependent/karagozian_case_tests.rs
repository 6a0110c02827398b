//! Concrete of three surfaces against closed forms: strength on the meridians, peaks and softening
//! of bars, compaction, energy. Constants of a concrete of 45.4 MPa (Malvar et al. 1997). Units
//! mm, ms, kg (GPa).

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, material, problems, table};
use crumple_proto::partition::{Material, Param};

const FC: f64 = 0.0454;
const FT: f64 = 0.0038;
const BULK: f64 = 14.53;
const NU: f64 = 0.19;
const SCALING: [f64; 3] = [1.6, 1.35, 1.15];

fn list<const N: usize>(numbers: [f64; N]) -> Param {
    Param::List(numbers.to_vec())
}

/// Largest strength on the compressive meridian, from a third of f_c on.
fn largest(p: f64) -> f64 {
    0.2956 * FC + p / (0.4463 + 0.0808 * p / FC)
}

fn residual(p: f64) -> f64 {
    p / (0.4417 + 0.1183 * p / FC)
}

/// lambda and eta.
const CURVE: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [8e-6, 0.85],
    [2.4e-5, 0.97],
    [4e-5, 0.99],
    [5.6e-5, 1.0],
    [7.2e-5, 0.99],
    [8.8e-5, 0.97],
    [3.2e-4, 0.5],
    [5.2e-4, 0.1],
    [5.7e-4, 0.0],
];

/// Volume strain, and pressure and modulus of unloading over the bulk modulus.
const COMPACTION: [[f64; 3]; 10] = [
    [0.0, 0.0, 1.0],
    [0.0015, 0.0015, 1.0],
    [0.0043, 0.00327, 1.014],
    [0.0101, 0.00525, 1.065],
    [0.0305, 0.009975, 1.267],
    [0.0513, 0.015045, 1.47],
    [0.0726, 0.021345, 1.672],
    [0.0943, 0.032655, 1.825],
    [0.174, 0.19065, 4.106],
    [0.208, 0.2916, 5.0],
];

fn concrete(others: &[(&str, Param)]) -> Material {
    let rows = COMPACTION.map(|[e, p, k]| [e, BULK * p, BULK * k]);
    let lists = [
        ("largest_surface", list([0.2956 * FC, 0.4463, 0.0808 / FC])),
        ("yield_surface", list([0.2232 * FC, 0.625, 0.2575 / FC])),
        ("residual_surface", list([0.4417, 0.1183 / FC])),
        ("damage_curve", table(&CURVE)),
        ("damage_scaling", list(SCALING)),
        ("compaction", table(&rows)),
    ];
    material(
        "karagozian_case_concrete",
        &[("poisson", NU), ("tensile_strength", FT)],
        &[&lists, others].concat(),
    )
}

fn pressure(cube: &Cube) -> f64 {
    -cube.state[..3].iter().sum::<f64>() / 3.0
}

/// Presses a cube on all sides to a pressure.
fn press(cube: &mut Cube, to: f64) {
    while pressure(cube) < to {
        cube.step([-1e-6, -1e-6, -1e-6, 0.0, 0.0, 0.0], 1.0);
    }
}

/// The curve of eta at a lambda, and what is beyond its peak.
fn eta(lambda: f64) -> f64 {
    let next = CURVE.iter().position(|point| point[0] > lambda);
    let Some(next) = next else { return 0.0 };
    let [low, high] = [CURVE[next - 1], CURVE[next]];
    low[1] + (high[1] - low[1]) * (lambda - low[0]) / (high[0] - low[0])
}

/// Triaxial compression with the pressure on the sides: the largest stress is on the compressive
/// meridian of the largest strength, and much later on that of the residual strength. The
/// tolerance is that of steps of 2e-6.
#[test]
fn triaxial_compression_has_the_meridians() {
    for sides in [0.005, 0.02, 0.06] {
        let mut cube = Cube::new(&concrete(&[("dilatancy", list([0.5, 1.0]))]));
        press(&mut cube, sides);
        let mut best = 0.0f64;
        let mut peak = [0.0; 2];
        for _ in 0..30_000 {
            let size = 4e-6;
            cube.pull_against([-2e-6, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], (-sides, size), 1.0);
            if cube.von_mises() > best {
                best = cube.von_mises();
                peak = [pressure(&cube), best];
            }
        }
        let off = peak[1] / largest(peak[0]) - 1.0;
        assert!(off.abs() < 2e-3, "{sides}: {off:e} at {peak:?}");
        let lambda = cube.at("modified plastic strain");
        let p = pressure(&cube);
        let now = eta(lambda) * largest(p) + (1.0 - eta(lambda)) * residual(p);
        let off = cube.von_mises() / now - 1.0;
        assert!(off.abs() < 5e-3, "{sides}: {off:e}, lambda {lambda}");
    }
}

/// A bar in compression has the strength f_c, and one in tension f_t; both soften, to nothing in
/// tension.
#[test]
fn bars_have_their_strengths_and_soften() {
    for (sign, strength, left) in [(-1.0, FC, 0.5), (1.0, FT, 0.05)] {
        let mut cube = Cube::new(&concrete(&[("dilatancy", list([0.5, 1.0]))]));
        let mut best = 0.0f64;
        let steps = if sign < 0.0 { 10_000 } else { 4000 };
        for _ in 0..steps {
            let size = 3e-6;
            cube.pull_against([sign * 1e-6, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], (0.0, size), 1.0);
            best = best.max(sign * cube.state[0]);
        }
        assert!((best / strength - 1.0).abs() < 0.02, "{sign}: {best} {strength}");
        let last = sign * cube.state[0];
        assert!(last < left * strength, "{sign}: {last} of {strength} is left");
        assert!(cube.at("damage") > 0.5, "{}", cube.at("damage"));
    }
}

/// In pure shear below the peak lambda grows by the plastic strain over the pressure; the strength
/// is that of first yield and of the largest surface by eta, on the shear meridian (cos 3 theta is
/// 0).
#[test]
fn shear_hardens_by_the_curve() {
    let mut cube = Cube::new(&concrete(&[]));
    press(&mut cube, 0.02);
    let p = pressure(&cube);
    let mut before = [0.0; 2];
    for _ in 0..4000 {
        let now = ["plastic_strain", "modified plastic strain"].map(|name| cube.at(name));
        before = now;
        cube.step([0.0, 0.0, 0.0, 2e-6, 0.0, 0.0], 1.0);
    }
    let exact = before[0] / (1.0 + p / FT).powf(SCALING[0]);
    assert!((before[1] / exact - 1.0).abs() < 1e-9, "{before:?} {exact}");
    let psi = 0.5 + 1.5 * FT / FC;
    let at_biaxial = 1.15 / (0.2956 + (2.3 / 3.0) / (0.4463 + 0.0808 * 2.3 / 3.0));
    let share = (p / FC - 1.0 / 3.0) / (2.3 / 3.0 - 1.0 / 3.0);
    let psi = psi + share * (at_biaxial - psi);
    // Willam & Warnke at 30 degrees.
    let (c, a, b) = (0.75_f64.sqrt(), 1.0 - psi * psi, 2.0 * psi - 1.0);
    let ratio = (2.0 * a * c + b * (4.0 * a * c * c + 5.0 * psi * psi - 4.0 * psi).sqrt())
        / (4.0 * a * c * c + b * b);
    let e = eta(before[1]);
    let other =
        if before[1] > 5.6e-5 { residual(p) } else { 0.2232 * FC + p / (0.625 + 0.2575 * p / FC) };
    let exact = ratio * (e * largest(p) + (1.0 - e) * other);
    // The bar by the surface has 0.99997 of f_c, on which psi depends.
    assert!((cube.von_mises() / exact - 1.0).abs() < 1e-4, "{} {exact}", cube.von_mises());
    assert!((pressure(&cube) - p).abs() < 1e-12, "without dilatancy shear has no pressure");
}

/// The pressure is the table in loading; unloading and loading again have the modulus there.
#[test]
fn compaction_follows_the_table() {
    let mut cube = Cube::new(&concrete(&[]));
    let to = |cube: &mut Cube, strain: f64| {
        let each = -(strain + cube.at("logarithm of volume")) / 3000.0;
        (0..1000).for_each(|_| _ = cube.step([each, each, each, 0.0, 0.0, 0.0], 1.0));
    };
    for two in COMPACTION.windows(2) {
        let middle: [f64; 3] = std::array::from_fn(|c| 0.5 * (two[0][c] + two[1][c]));
        for [e, p, k] in [middle, two[1]] {
            to(&mut cube, e);
            assert!((pressure(&cube) / (BULK * p) - 1.0).abs() < 1e-9, "{e}: {}", pressure(&cube));
            to(&mut cube, e - 0.3 * p / k);
            let exact = 0.7 * BULK * p;
            assert!((pressure(&cube) / exact - 1.0).abs() < 1e-9, "{e}: {}", pressure(&cube));
            assert!((cube.at("stiffening") - (k - 1.0)).abs() < 1e-9, "{e}");
        }
    }
}

/// Tension along all axes stops at f_t and makes damage by b3, so that the limit falls.
#[test]
fn tension_along_all_axes_makes_damage() {
    let mut cube = Cube::new(&concrete(&[]));
    let mut best = 0.0f64;
    for _ in 0..2000 {
        cube.step([3e-7, 3e-7, 3e-7, 0.0, 0.0, 0.0], 1.0);
        best = best.max(-pressure(&cube));
    }
    assert!((best / FT - 1.0).abs() < 1e-9, "{best}");
    assert!(pressure(&cube).abs() < 1e-12 && cube.at("damage") > 1.0 - 1e-9);
}

/// Factors of the rate multiply the strength: that of the compressive side in a pressure above a
/// third of f_c.
#[test]
fn rates_raise_the_strength() {
    let factors = ("rate_factors", table(&[[-1.0, 3.0], [0.0, 1.0], [1.0, 1.5]]));
    let mut cubes = [&[][..], &[factors]].map(|others| Cube::new(&concrete(others)));
    for cube in &mut cubes {
        press(cube, 0.03);
        // Damage of 3000 steps at a rate of 1, from fresh.
        let dt = 2e-6 / 3.0_f64.sqrt();
        (0..3000).for_each(|_| _ = cube.step([0.0, 0.0, 0.0, 2e-6, 0.0, 0.0], dt));
    }
    let p = pressure(&cubes[1]);
    let [slow, fast] = cubes.each_ref().map(|cube| cube.von_mises());
    assert!(fast > 1.1 * slow && fast < 1.5 * largest(p), "{slow} {fast}");
}

/// Closed random paths give no energy and stay finite, in tension, compression and far compaction.
#[test]
fn closed_paths_of_concrete_cost_work() {
    let fast = ("rate_factors", table(&[[-1.0, 3.0], [0.0, 1.0], [1.0, 1.5]]));
    let laws = [
        concrete(&[]),
        concrete(&[("dilatancy", list([0.5, 1.0])), fast.clone()]),
        concrete(&[("dilatancy", list([1.0, 0.0]))]),
    ];
    for law in &laws {
        for size in [1e-6, 1e-5, 1e-4, 1e-3] {
            for seed in 0..20 {
                let mut cube = Cube::new(law);
                let mut noise = Noise(seed);
                let path: Vec<[f64; 6]> =
                    (0..4).map(|_| std::array::from_fn(|_| size * noise.next())).collect();
                let mut most = 0.0f64;
                for e in path.iter().chain(&path.clone()).enumerate().map(|(k, e)| {
                    let sign = if k < 4 { 1.0 } else { -1.0 };
                    e.map(|e| sign * e)
                }) {
                    for _ in 0..40 {
                        cube.step(e, 1e-4);
                        most = most.max(cube.work);
                    }
                }
                assert!(cube.state.iter().all(|x| x.is_finite()), "{:?}", cube.state);
                // The energy of the deviator and of the pressure may come back later.
                let k = BULK * (1.0 + cube.at("stiffening"));
                let g = 1.5 * k * (1.0 - 2.0 * NU) / (1.0 + NU);
                let p = pressure(&cube);
                let stored = cube.von_mises().powi(2) / (6.0 * g) + p * p / (2.0 * k);
                // The tolerance is that of work by trapezoids.
                let off = cube.work - stored;
                assert!(off > -1e-3 * most, "{size} {seed}: {} {stored} {most}", cube.work);
            }
        }
    }
}

/// A crack that opens slowly and closes fast, with the strength of a high rate, gives no energy.
#[test]
fn a_crack_that_closes_fast_gives_no_energy() {
    let fast = ("rate_factors", table(&[[-1.0, 3.0], [0.0, 1.0], [1.0, 1.5]]));
    let mut cube = Cube::new(&concrete(&[fast]));
    let open = 1e-6;
    for _ in 0..500 {
        cube.step([open, open, open, 0.0, 0.0, 0.0], 1e3);
    }
    let opened = cube.work;
    assert!(opened > 0.0);
    for k in 0..500 {
        let shear = if k % 2 == 0 { 1e-7 } else { -1e-7 };
        cube.step([-open, -open, -open, shear, 0.0, 0.0], 1e-8);
    }
    assert!(cube.work > 0.0, "{} of {opened}", cube.work);
}

#[test]
fn wrong_constants_of_concrete_are_refused() {
    let text = problems(&material("karagozian_case_concrete", &[], &[]));
    for key in ["poisson", "tensile_strength", "largest_surface", "damage_curve", "compaction"] {
        assert!(text.contains(&format!("{key} is missing")), "{key}: {text}");
    }
    for (key, value, words) in [
        ("largest_surface", list([0.01, 0.3, 0.0]), "no strength"),
        ("damage_curve", table(&[[0.0, 0.0], [1e-5, 0.9]]), "no peak of 1"),
        ("damage_curve", table(&[[0.0, 0.0], [1e-5, 1.0], [2e-5, 0.5], [3e-5, 0.6]]), "no peak"),
        ("dilatancy", list([1.5, 1.0]), "omega from 0 to 1"),
        ("compaction", table(&[[0.0, 0.0, 10.0], [0.1, 2.0, 10.0]]), "gives back more work"),
        ("compaction", table(&[[0.0, 0.0, 10.0], [0.1, 0.5, 9.0]]), "moduli that do not decrease"),
    ] {
        let mut law = concrete(&[]);
        law.parameters.insert(key.into(), value);
        assert!(problems(&law).contains(words), "{words}: {}", problems(&law));
    }
    let mut law = concrete(&[]);
    law.parameters.insert("tensile_strength".into(), Param::Number(0.02));
    assert!(problems(&law).contains("above a third"), "{}", problems(&law));
}
