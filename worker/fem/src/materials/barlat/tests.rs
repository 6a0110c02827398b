//! The law of Barlat and Lian against von Mises plasticity and closed forms. Units mm, ms, kg.

use super::surface::Three;
use super::*;
use crate::elements::testing::Noise;
use crate::materials::build;
use crate::materials::testing::{Sheet, material, problems, table};
use crumple_proto::partition::Param;

const E: f64 = 70.0;
const NU: f64 = 0.33;
const YIELD: f64 = 0.15;

fn sheet(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let elastic = [("youngs_modulus", E), ("poisson", NU)];
    material("barlat", &[&elastic[..], numbers].concat(), others)
}

const SHEETS: [(f64, [f64; 3]); 5] = [
    (2.0, [1.0; 3]),
    (2.0, [0.7, 1.6, 0.9]),
    (6.0, [1.8, 1.3, 2.2]),
    (8.0, [0.67, 0.43, 0.71]),
    (14.0, [0.8, 1.1, 0.6]),
];

fn surface(&(m, ratios): &(f64, [f64; 3])) -> BarlatSurface {
    BarlatSurface::new(m, ratios).expect("ratios in reach")
}

/// Gradient of the equivalent stress by central differences: an error of 1e-10.
fn gradient(surface: &BarlatSurface, stress: Three) -> Three {
    let size = 1e-5 * stress.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
    std::array::from_fn(|k| {
        let at = |by: f64| {
            let mut moved = stress;
            moved[k] += by;
            surface.equivalent(moved)
        };
        (8.0 * (at(size) - at(-size)) - (at(2.0 * size) - at(-2.0 * size))) / (12.0 * size)
    })
}

/// In tension at 0, 45 and 90 degrees the plastic strains across and through the sheet have the
/// given ratios, and along a the equivalent stress is the tension.
#[test]
fn tension_has_the_given_ratios() {
    for of in &SHEETS {
        let surface = surface(of);
        for (degrees, wanted) in [(0.0_f64, of.1[0]), (45.0, of.1[1]), (90.0, of.1[2])] {
            let (s, c) = degrees.to_radians().sin_cos();
            let stress = [c * c, s * s, s * c].map(|share| YIELD * share);
            let [a, b, ab] = gradient(&surface, stress);
            // Strain across the tension, with half of the engineering shear; the volume is kept.
            let across = s * s * a + c * c * b - s * c * ab;
            let through = -(a + b);
            assert!((across / through - wanted).abs() < 1e-7, "{of:?} {degrees}");
            // Work: the equivalent stress is homogeneous.
            let work = stress[0] * a + stress[1] * b + stress[2] * ab;
            assert!((work - surface.equivalent(stress)).abs() < 1e-9, "{of:?}");
        }
        assert!((surface.equivalent([YIELD, 0.0, 0.0]) - YIELD).abs() < 1e-15);
        assert!(BarlatSurface::new(of.0, [1.0, 1e9, 1.0]).is_none());
    }
}

/// Von Mises' condition with ratios of one and m = 2, and Tresca's hexagon for a large m: in pure
/// shear it yields at half of the tension.
#[test]
fn special_cases_are_those_of_mises_and_tresca() {
    let mut noise = Noise(2);
    let mises = surface(&SHEETS[0]);
    for _ in 0..100 {
        let [a, b, ab] = [noise.next(), noise.next(), noise.next()];
        let exact = (a * a - a * b + b * b + 3.0 * ab * ab).sqrt();
        assert!((mises.equivalent([a, b, ab]) - exact).abs() < 1e-12);
    }
    let tresca = BarlatSurface::new(200.0, [1.0; 3]).expect("ratios in reach");
    // (1 + 2^(m-1))^(1/m) of a shear stress of one: 2 except for a factor 2^(-1/m).
    let shear = tresca.equivalent([1.0, -1.0, 0.0]);
    assert!((shear - 2.0 * 0.5_f64.powf(1.0 / 200.0)).abs() < 1e-9, "{shear}");
}

/// A trial of any size returns to the surface along C n, as the closest point.
#[test]
fn trials_return_to_the_closest_point() {
    let mut noise = Noise(9);
    let elastic = Elastic { youngs_modulus: E, poisson: NU, density: 1.0 };
    let [c11, c12, g] = elastic.plane_stress();
    for of in &SHEETS {
        let surface = surface(of);
        for size in [1.001, 1.1, 2.0, 10.0, 100.0] {
            for k in 0..200 {
                let mut trial: Three = [noise.next(), noise.next(), noise.next()];
                // Some on axes of symmetry, where K2 or a term vanishes.
                match k % 10 {
                    7 => trial[2] = 0.0,
                    8 => (trial[1], trial[2]) = (0.0, 0.0),
                    9 => trial = [1.0, 1.0 / surface.weights()[0], 0.0],
                    _ => {}
                }
                let factor = size * YIELD / surface.equivalent(trial);
                let trial = trial.map(|s| factor * s);
                let before = YieldState { stress: [0.0; 3], plastic_strain: 0.0 };
                let hardening = |strain: f64| [YIELD + 0.3 * strain, 0.3];
                let YieldState { stress, plastic_strain: y } =
                    surface.returned(before, trial, [c11, c12, g], &hardening);
                let off = surface.equivalent(stress) / hardening(y)[0] - 1.0;
                assert!(off.abs() < 1e-10, "{of:?} {size} {k}: {off}");
                assert!(y > 0.0);
                if size <= 2.0 {
                    let n = gradient(&surface, stress);
                    let along = [c11 * n[0] + c12 * n[1], c12 * n[0] + c11 * n[1], g * n[2]];
                    for c in 0..3 {
                        let rest = stress[c] - trial[c] + y * along[c];
                        assert!(rest.abs() < 1e-6 * YIELD * size, "{of:?} {size} {k}: {rest}");
                    }
                }
            }
        }
    }
}

/// With ratios of one and m = 2 the law is von Mises plasticity on any path: stress, plastic strain
/// and thickness.
#[test]
fn the_isotropic_case_is_von_mises_plasticity() {
    let curve = table(&[[0.0, YIELD], [0.01, 0.2], [0.05, 0.24]]);
    let isotropic = [("exponent", 2.0)];
    let linear = [("yield_stress", YIELD), ("hardening_modulus", 0.5)];
    let elastic = [("youngs_modulus", E), ("poisson", NU)];
    for (numbers, others) in [(&linear[..], vec![]), (&[], vec![("hardening", curve)])] {
        let mut ours = Sheet::new(&sheet(&[&isotropic[..], numbers].concat(), &others));
        let mut mises = Sheet::new(&material("j2", &[&elastic[..], numbers].concat(), &others));
        let mut noise = Noise(4);
        for step in 0..2000 {
            let size = [1e-5, 1e-3, 1e-2][step % 3];
            let eps = [noise.next(), noise.next(), noise.next()].map(|e| size * e);
            ours.step(eps, 1.0);
            mises.step(eps, 1.0);
            for c in 0..4 {
                let off = ours.state[c] - mises.state[c];
                assert!(off.abs() < 1e-9 * mises.state[c].abs().max(YIELD), "{step} {c}: {off}");
            }
            assert!((ours.strain[3] - mises.strain[3]).abs() < 1e-9, "{step}");
        }
        assert!(ours.state[3] > 1.0, "it flows: {}", ours.state[3]);
    }
}

/// Tension along a and b with each form of hardening: the stress is the curve at the plastic
/// strain, times the yield ratio of the direction, and the strain across has the ratio of the
/// direction.
#[test]
fn tension_follows_the_hardening() {
    let (m, ratios) = SHEETS[3];
    let of_sheet = [
        ("exponent", m),
        ("lankford_0", ratios[0]),
        ("lankford_45", ratios[1]),
        ("lankford_90", ratios[2]),
    ];
    let linear = [("yield_stress", YIELD), ("hardening_modulus", 0.5)];
    let curve = table(&[[0.0, YIELD], [0.01, 0.2], [0.05, 0.24]]);
    let swift = Param::List(vec![0.5, 0.003, 0.22]);
    type Curve = fn(f64) -> f64;
    type Numbers<'a> = &'a [(&'a str, f64)];
    type Lists<'a> = Vec<(&'a str, Param)>;
    let forms: [(Numbers<'_>, Lists<'_>, Curve); 3] = [
        (&linear, vec![], |g| YIELD + 0.5 * g),
        (&[], vec![("hardening", curve)], |g| match g {
            _ if g < 0.01 => YIELD + 5.0 * g,
            _ => f64::min(0.2 + (g - 0.01), 0.24),
        }),
        (&[], vec![("swift", swift)], |g| 0.5 * (0.003 + g).powf(0.22)),
    ];
    for (numbers, others, exact) in forms {
        for (angle, ratio) in [(0.0_f64, ratios[0]), (90.0, ratios[2])] {
            let law = sheet(&[&of_sheet[..], numbers].concat(), &others);
            let mut tension = Sheet::new(&law);
            // The element sets the direction of a.
            let (s, c) = angle.to_radians().sin_cos();
            (tension.state[COSINE], tension.state[SINE]) = (c - 1.0, s);
            let surface = surface(&SHEETS[3]);
            let of_direction = surface.equivalent([c * c, s * s, 0.0]);
            for _ in 0..100 {
                tension.pull(5e-4, 1.0);
                let (stress, g) = (tension.state[0], tension.state[STRAIN]);
                let wanted = exact(g) / of_direction;
                if g > 0.0 {
                    assert!((stress - wanted).abs() < 1e-9, "{angle}: {stress} for {wanted}");
                }
            }
            let stress = tension.state[0];
            let [_, across, _, through] = tension.strain;
            let elastic = -NU * stress / E;
            let got = (across - elastic) / (through - elastic);
            assert!((got - ratio).abs() < 1e-6, "{angle}: {got} for {ratio}");
        }
    }
}

/// No closed path of strain gives energy.
#[test]
fn no_closed_path_gives_energy() {
    let mut noise = Noise(21);
    for (m, ratios) in SHEETS {
        for path in 0..40 {
            let law = build(&sheet(
                &[
                    ("exponent", m),
                    ("lankford_0", ratios[0]),
                    ("lankford_45", ratios[1]),
                    ("lankford_90", ratios[2]),
                    ("yield_stress", YIELD),
                    ("hardening_modulus", 0.5),
                ],
                &[],
            ))
            .map_err(|found| format!("{found:?}"))
            .unwrap();
            let mut state = [0.0; COLUMNS];
            let mut work = 0.0;
            let mut corners: Vec<Three> = (0..5)
                .map(|_| [noise.next(), noise.next(), noise.next()].map(|e| 0.01 * e))
                .collect();
            corners.push([0.0; 3]);
            let mut from = [0.0; 3];
            for to in corners {
                let eps: Three = std::array::from_fn(|c| (to[c] - from[c]) / 100.0);
                for _ in 0..100 {
                    let before = state;
                    law.update_one(
                        Points { state: &mut state, strain: &[eps], thickness_strain: &mut [0.0] },
                        1.0,
                    );
                    work += (0..3).map(|c| 0.5 * (before[c] + state[c]) * eps[c]).sum::<f64>();
                }
                from = to;
            }
            assert!(work > -1e-12, "{m} {path}: {work}");
            assert!(state[STRAIN] > 0.0);
        }
    }
}

#[test]
fn wrong_parameters_are_refused_at_once() {
    let text = problems(&sheet(
        &[("exponent", 1.5), ("lankford_90", -1.0), ("lankford_45", 1e7), ("yield_stress", 0.2)],
        &[("swift", Param::List(vec![0.5, 0.0, 0.2]))],
    ));
    for words in [
        "exponent is 1.5",
        "lankford_90 is -1",
        "cannot be reached",
        "swift is not [k, e0, n]",
        "is given together with yield_stress",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(problems(&sheet(&[], &[])).contains("yield_stress is missing"));
}
