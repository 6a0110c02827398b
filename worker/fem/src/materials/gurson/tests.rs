//! Plasticity with voids against closed forms. Units mm, ms, kg.

use super::surface::VoidSurface;
use super::*;
use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, Sheet, material, problems, table};

const E: f64 = 200.0;
const NU: f64 = 0.3;
const YIELD: f64 = 0.4;
const NUMBERS: [(&str, f64); 4] =
    [("youngs_modulus", E), ("poisson", NU), ("yield_stress", YIELD), ("hardening_modulus", 0.5)];

fn metal(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    material("gurson", &[&NUMBERS[..], numbers].concat(), others)
}

/// The equivalent stress fulfils the condition, and its derivatives are those of differences.
#[test]
fn the_equivalent_stress_is_on_the_surface() {
    let surface = VoidSurface { q1: 1.5, q2: 1.1, critical: f64::INFINITY };
    let mut noise = Noise(5);
    for voids in [0.0, 1e-9, 1e-4, 0.01, 0.2, 0.6] {
        let weakening = surface.weakening(voids, f64::INFINITY);
        for _ in 0..200 {
            let [mises, mean] = [noise.next().abs(), 3.0 * noise.next()];
            let now = surface.equivalent([mises, mean], weakening);
            let (q, w) = (mises / now.stress, 1.65 * mean / now.stress);
            let condition = q * q + 2.0 * weakening * w.cosh() - 1.0 - weakening * weakening;
            assert!(condition.abs() < 1e-11, "{voids} {mises} {mean}: {condition}");
            let at = |[q, p]: [f64; 2]| surface.equivalent([q, p], weakening).stress;
            let by = 1e-5 * mises;
            let slopes = [
                (at([mises + by, mean]) - at([mises - by, mean])) / (2.0 * by),
                (at([mises, mean + by]) - at([mises, mean - by])) / (2.0 * by),
            ];
            for (slope, got) in slopes.into_iter().zip([now.of_mises, now.of_mean]) {
                // Central differences of a step of 1e-5.
                assert!((slope - got).abs() < 1e-6 * (1.0 + slope.abs()), "{voids}: {slope} {got}");
            }
            let inside = [mises, mean].map(|s| (1.0 - 1e-9) * s);
            let outside = [mises, mean].map(|s| (1.0 + 1e-9) * s);
            assert!(surface.holds(inside, weakening, now.stress));
            assert!(!surface.holds(outside, weakening, now.stress));
        }
    }
}

/// Without voids the law is von Mises plasticity on any path, in sheets and cubes.
#[test]
fn without_voids_it_is_von_mises_plasticity() {
    let (ours, mises) = (metal(&[], &[]), material("j2", &NUMBERS, &[]));
    let (mut sheet, mut sheet_of_mises) = (Sheet::new(&ours), Sheet::new(&mises));
    let (mut cube, mut cube_of_mises) = (Cube::new(&ours), Cube::new(&mises));
    let mut noise = Noise(4);
    for step in 0..2000 {
        let size = [1e-5, 1e-4, 1e-3][step % 3];
        let eps: [f64; 6] = std::array::from_fn(|_| size * noise.next());
        cube.step(eps, 1.0);
        cube_of_mises.step(eps, 1.0);
        for c in 0..7 {
            let off = cube.state[c] - cube_of_mises.state[c];
            assert!(off.abs() < 1e-9 * cube.state[c].abs().max(YIELD), "{step} {c}: {off}");
        }
        sheet.step([eps[0], eps[1], eps[3]], 1.0);
        sheet_of_mises.step([eps[0], eps[1], eps[3]], 1.0);
        for c in 0..4 {
            let off = sheet.state[c] - sheet_of_mises.state[c];
            assert!(off.abs() < 1e-8 * sheet.state[c].abs().max(YIELD), "{step} {c}: {off}");
        }
    }
    let through = [&sheet, &sheet_of_mises].map(|sheet| sheet.strain[3]);
    assert!((through[0] - through[1]).abs() < 1e-7, "{through:?}");
    assert!(cube.state[6] > 1e-3 && sheet.state[3] > 1e-3, "{}", sheet.state[3]);
}

/// Tension on all sides: the mean stress is that of the surface, and the matrix keeps its volume,
/// `(1 - f) exp(e) = 1 - f_0` with the plastic volume strain e.
#[test]
fn voids_grow_by_the_volume_of_the_matrix() {
    let voids = 0.01;
    let law = metal(&[("void_fraction", voids), ("hardening_modulus", 0.0)], &[]);
    let mut cube = Cube::new(&law);
    let bulk = E / (3.0 * (1.0 - 2.0 * NU));
    for _ in 0..20_000 {
        cube.step([1e-5, 1e-5, 1e-5, 0.0, 0.0, 0.0], 1.0);
    }
    let mean = cube.state[0];
    let plastic = 20_000.0 * 3e-5 - mean / bulk;
    let fraction = voids + cube.at("void_fraction_rise");
    let wanted = 1.0 - (1.0 - voids) * (-plastic).exp();
    // The error is of first order in the step, 3e-5.
    assert!((fraction / wanted - 1.0).abs() < 1e-4, "{fraction} for {wanted}");
    let weakening: f64 = 1.5 * fraction;
    let limit = ((1.0 + weakening * weakening) / (2.0 * weakening)).acosh() / 1.5 * YIELD;
    assert!((mean / limit - 1.0).abs() < 1e-3, "{mean} for {limit}");
    // Compressed by as much, voids end at their first size.
    for _ in 0..40_000 {
        cube.step([-1e-5, -1e-5, -1e-5, 0.0, 0.0, 0.0], 1.0);
    }
    assert_eq!(cube.at("void_fraction_rise"), 0.0);
    let changed = |key: &str| {
        let mut cube = Cube::new(&metal(
            &[("void_fraction", voids), ("hardening_modulus", 0.0)],
            &[(key, Param::Flag(true))],
        ));
        (0..2000).for_each(|_| {
            cube.step([-1e-5, -1e-5, -1e-5, 0.0, 0.0, 0.0], 1.0);
        });
        cube.at("void_fraction_rise")
    };
    assert_eq!(changed("voids_only_grow"), 0.0);
    let closed = changed("voids_close");
    assert!(closed < -0.5 * voids && closed >= -voids, "{closed}");
}

/// With a small q1 voids hardly grow: those of the particles form, half of them up to the mean
/// strain, in tension only.
#[test]
fn voids_form_at_particles() {
    let nucleation = Param::List(vec![0.04, 0.1, 0.02]);
    let law = metal(&[("q1", 1e-6)], &[("nucleation", nucleation)]);
    for direction in [1.0, -1.0] {
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        let mut half = [0.0; 2];
        while cube.at("plastic_strain") < 0.25 {
            cube.pull([direction * 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
            sheet.pull(direction * 1e-3, 1.0);
            for (half, [strain, rise]) in half.iter_mut().zip([
                [cube.at("plastic_strain"), cube.at("void_fraction_rise")],
                [sheet.state[3], sheet.state[4]],
            ]) {
                if strain < 0.1 {
                    *half = rise;
                }
            }
        }
        for (half, all) in half.into_iter().zip([cube.at("void_fraction_rise"), sheet.state[4]]) {
            if direction < 0.0 {
                assert_eq!(all, 0.0);
                continue;
            }
            // A step of 1e-3 of a peak of 0.8 per strain.
            assert!((half - 0.02).abs() < 8e-4, "{half}");
            assert!((all - 0.04).abs() < 1e-4, "{all}");
        }
    }
}

/// A sheet in tension has the stress, the voids and the thickness of a cube with a free side.
#[test]
fn a_sheet_is_a_cube_with_a_free_side() {
    let nucleation = Param::List(vec![0.04, 0.1, 0.05]);
    let law = metal(
        &[
            ("void_fraction", 0.01),
            ("critical_void_fraction", 0.05),
            ("failure_void_fraction", 0.2),
        ],
        &[("nucleation", nucleation)],
    );
    let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
    let mut through = 0.0;
    for step in 0..10_000 {
        // Biaxial tension: much mean stress.
        let [x, y] = [2e-5, 1.2e-5];
        cube.pull([x, y, 0.0, 0.0, 0.0, 0.0], &[2], 1.0);
        through = cube.strain[2];
        sheet.step([x, y, 0.0], 1.0);
        for (c, of_cube) in [cube.state[0], cube.state[1]].into_iter().enumerate() {
            let off = (sheet.state[c] - of_cube).abs();
            assert!(off < 1e-8 * YIELD, "{step} {c}: {off} of {of_cube}");
        }
        let off = (sheet.state[4] - cube.at("void_fraction_rise")).abs();
        let rise = cube.at("void_fraction_rise");
        assert!(off < 1e-7 * rise + 1e-12, "{step}: {off} of {rise}");
        if cube.at("failed") > 0.5 || sheet.state[5] > 0.5 {
            break;
        }
    }
    let thinner = sheet.strain[3] / through - 1.0;
    assert!(thinner.abs() < 1e-6, "{thinner}");
    assert!(cube.at("void_fraction_rise") > 0.09, "{}", cube.at("void_fraction_rise"));
}

/// Coalescence takes the strength; a point fails at the fraction of its size.
#[test]
fn points_fail_at_the_fraction_of_their_size() {
    let sizes = table(&[[1.0, 0.3], [5.0, 0.15]]);
    for (size, failure) in [(0.5, 0.3), (3.0, 0.225), (9.0, 0.15)] {
        let law = metal(
            &[("void_fraction", 0.02), ("critical_void_fraction", 0.1)],
            &[("failure_void_fractions", sizes.clone())],
        );
        let mut cube = Cube::new(&law);
        cube.set(SIZE_COLUMN, size);
        let (mut most, mut last, mut fraction) = (0.0, 0.0, 0.0);
        for _ in 0..20_000 {
            if cube.at("failed") > 0.5 {
                break;
            }
            last = cube.state[0];
            most = f64::max(most, last);
            fraction = 0.02 + cube.at("void_fraction_rise");
            cube.step([1e-4, 1e-5, 1e-5, 0.0, 0.0, 0.0], 1.0);
        }
        // A step of 1e-4 of strain lets voids grow by as much at most.
        assert!(fraction < failure && failure - fraction < 1.5e-4, "{size}: {fraction}");
        assert!(last < 0.01 * most, "{size}: {last} of {most}");
        assert_eq!(cube.state[..6], [0.0; 6]);
        cube.step([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        assert_eq!(cube.state[..6], [0.0; 6]);
    }
}

/// Trials of up to 100 times the yield stress return to the surface.
#[test]
fn large_trials_return_to_the_surface() {
    let law = metal(&[("void_fraction", 0.05)], &[]);
    let surface = VoidSurface { q1: 1.5, q2: 1.0, critical: f64::INFINITY };
    let mut noise = Noise(8);
    for size in [1.01, 2.0, 10.0, 100.0] {
        for _ in 0..100 {
            let mut cube = Cube::new(&law);
            let eps: [f64; 6] = std::array::from_fn(|_| 0.01 * size * noise.next());
            cube.step(eps, 1.0);
            let s = deviator(&std::array::from_fn(|k| cube.state[k]));
            let mean = (cube.state[0] + cube.state[1] + cube.state[2]) / 3.0;
            let of = [(1.5 * inner(&s, &s)).sqrt(), mean];
            let stress = surface.equivalent(of, 1.5 * 0.05).stress;
            let limit = YIELD + 0.5 * cube.at("plastic_strain");
            assert!(stress < limit * (1.0 + 1e-11), "{size}: {stress} {limit}");
            assert!(cube.at("plastic_strain") >= 0.0);
        }
    }
}

#[test]
fn wrong_parameters_are_reported() {
    let wrong = metal(
        &[
            ("void_fraction", 0.7),
            ("critical_void_fraction", 0.3),
            ("failure_void_fraction", 0.2),
            ("q2", 0.0),
        ],
        &[
            ("nucleation", Param::List(vec![0.1, 0.2])),
            ("failure_void_fractions", table(&[[2.0, 0.2], [1.0, 0.3]])),
            ("voids_only_grow", Param::Flag(true)),
            ("voids_close", Param::Flag(true)),
        ],
    );
    let found = problems(&wrong);
    for text in [
        "void_fraction leaves no strength",
        "critical_void_fraction is 0.3, which is not below the fraction of failure 0.2",
        "q2 is 0",
        "nucleation is not [f_N, e_N, s_N]",
        "failure_void_fractions is not such a curve",
        "failure_void_fractions is given with failure_void_fraction",
        "voids_close is given with voids_only_grow",
    ] {
        assert!(found.contains(text), "{text}: {found}");
    }
    let many = [("void_fraction", 0.3), ("critical_void_fraction", 0.1)];
    let many = metal(&[&many[..], &[("failure_void_fraction", 0.2)]].concat(), &[]);
    let text = "void_fraction is 0.3, which is not below the fraction of failure 0.2";
    assert!(problems(&many).contains(text), "{}", problems(&many));
    let weak = [("critical_void_fraction", 0.7), ("failure_void_fraction", 0.9)];
    let weak = problems(&metal(&weak, &[]));
    assert!(weak.contains("is 0.7, at which no strength is left"), "{weak}");
    let alone = metal(&[("critical_void_fraction", 0.1)], &[]);
    assert!(problems(&alone).contains("without a fraction of failure"));
}
