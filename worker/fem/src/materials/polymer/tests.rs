//! Tests of polymers: their test curves, flow ratios, damage, and dissipation.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, Sheet, material, problems, table};
use crumple_proto::partition::{Material, Param};

/// Moduli and stresses in GPa.
const YOUNG: f64 = 2.0;
const NU: f64 = 0.35;
const TENSION: [[f64; 2]; 3] = [[0.0, 0.03], [0.05, 0.04], [0.5, 0.05]];
const COMPRESSION: [[f64; 2]; 3] = [[0.0, 0.04], [0.05, 0.055], [0.5, 0.07]];
const SHEAR: [[f64; 2]; 3] = [[0.0, 0.022], [0.05, 0.03], [0.5, 0.036]];

fn polymer(more: &[(&str, Param)]) -> Material {
    material("polymer", &[("youngs_modulus", YOUNG), ("poisson", NU)], more)
}

fn of_tests(ratio: f64, tests: usize) -> Material {
    let curves = [("tension", TENSION), ("compression", COMPRESSION), ("shear", SHEAR)];
    let curves = curves[..tests].iter().map(|(key, rows)| (*key, table(rows)));
    let ratio = [("plastic_poisson", Param::Number(ratio))];
    polymer(&curves.chain(ratio).collect::<Vec<_>>())
}

/// Returns the ordinate of a curve.
fn at(curve: &[[f64; 2]], x: f64) -> f64 {
    let after = curve.iter().position(|point| point[0] > x).unwrap_or(curve.len() - 1).max(1);
    let [[x0, y0], [x1, y1]] = [curve[after - 1], curve[after]];
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).min(1.0)
}

const SIDES: [usize; 2] = [1, 2];

/// Uniaxial tests follow their curves, with the flow ratio across: in a cube with free sides and in
/// a sheet (bisection for the free sides).
#[test]
fn uniaxial_tests_follow_their_curves() {
    for ratio in [0.0, 0.2, 0.5] {
        for (sign, curve) in [(1.0, TENSION), (-1.0, COMPRESSION)] {
            let (mut cube, mut sheet) =
                (Cube::new(&of_tests(ratio, 3)), Sheet::new(&of_tests(ratio, 3)));
            for _ in 0..150 {
                cube.pull([sign * 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], &SIDES, 1.0);
                sheet.pull(sign * 1e-3, 1.0);
            }
            let stress = cube.state[0];
            let plastic = sign * (0.15 - sign * stress / YOUNG);
            let wanted = sign * at(&curve, plastic.abs());
            assert!((stress / wanted - 1.0).abs() < 1e-6, "{ratio} {sign}: {stress} {wanted}");
            assert!((sheet.state[0] / wanted - 1.0).abs() < 1e-6, "{:?}", sheet.state);
            assert!((cube.at("strain of tension") / plastic.abs() - 1.0).abs() < 1e-6);
            // Strains of the sheet are sums of increments.
            for across in [sheet.strain[1], sheet.strain[3]] {
                let flowed = across + NU * stress / YOUNG;
                assert!((flowed + ratio * plastic).abs() < 1e-6, "{ratio} {sign}: {across}");
            }
        }
    }
}

/// A shear test follows its curve, or that of the cone or of von Mises without it.
#[test]
fn shear_follows_its_curve_or_that_of_the_other_tests() {
    for tests in 1..=3 {
        let (mut cube, mut sheet) =
            (Cube::new(&of_tests(0.5, tests)), Sheet::new(&of_tests(0.5, tests)));
        for _ in 0..200 {
            cube.step([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1.0);
            sheet.step([0.0, 0.0, 1e-3], 1.0);
        }
        let g = YOUNG / (2.0 * (1.0 + NU));
        for stress in [cube.state[3], sheet.state[2]] {
            let plastic = 0.5 * (0.2 - stress / g);
            let strain = 2.0 / 3f64.sqrt() * plastic;
            let [t, c] = [TENSION, COMPRESSION].map(|curve| at(&curve, strain));
            let wanted = match tests {
                1 => t / 3f64.sqrt(),
                2 => 2.0 / 3f64.sqrt() * t * c / (t + c),
                _ => at(&SHEAR, plastic),
            };
            assert!((stress / wanted - 1.0).abs() < 1e-9, "{tests}: {stress} for {wanted}");
        }
    }
}

/// Tension on all sides: with flow that changes the volume the mean stress ends where the surface
/// has no deviator, and without it the apex still bounds the stress.
#[test]
fn tension_on_all_sides_is_bounded_by_the_surface() {
    for ratio in [0.0, 0.5] {
        let mut cube = Cube::new(&of_tests(ratio, 2));
        for _ in 0..200 {
            cube.step([1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0], 1.0);
        }
        let strain = cube.at("strain of tension");
        let [t, c] = [TENSION, COMPRESSION].map(|curve| at(&curve, strain));
        // The cone through both tests: q = B0 + B1 p.
        let wanted = 2.0 * t * c / (t + c) / (3.0 * (c - t) / (c + t));
        let got = cube.state[0];
        assert!((got / wanted - 1.0).abs() < 1e-6, "{ratio}: {got} for {wanted}");
        assert!(cube.von_mises() < 1e-9);
    }
}

/// Large steps end on the surface as well as small ones, for any direction.
#[test]
fn returns_end_on_the_surface() {
    let mut noise = Noise(11);
    for k in 0..500 {
        let ratio = [0.0, 0.3, 0.5][k % 3];
        let mut cube = Cube::new(&of_tests(ratio, 1 + k % 3));
        let size = 10f64.powf(2.0 * noise.next() - 1.0);
        cube.step(std::array::from_fn(|_| size * noise.next()), 1.0);
        let q = cube.von_mises();
        let p = -(cube.state[0] + cube.state[1] + cube.state[2]) / 3.0;
        let [e, tension] = ["plastic_strain", "strain of tension"].map(|name| cube.at(name));
        if e == 0.0 {
            continue;
        }
        let t = at(&TENSION, tension);
        let c = if k % 3 == 0 { t } else { at(&COMPRESSION, tension) };
        let s = match k % 3 {
            2 => at(&SHEAR, 0.5 * 3f64.sqrt() * e),
            _ => 2.0 / 3f64.sqrt() * t * c / (t + c),
        };
        let a = [3.0 * s * s, 9.0 * s * s * (c - t) / (c * t), 9.0 * (1.0 - 3.0 * s * s / (c * t))];
        let beyond = (q * q - a[0] - a[1] * p - a[2] * p * p) / (q * q + a[0]);
        assert!(beyond.abs() < 1e-9, "{k}, {size}: {beyond:e}");
    }
}

/// The yield stress is that of the plastic strain rate, in compression too.
#[test]
fn the_rate_raises_all_yield_stresses() {
    let rows = [[0.0, 0.0, 0.03], [0.0, 0.5, 0.03], [0.1, 0.0, 0.045], [0.1, 0.5, 0.045]];
    let flat = [[0.0, 0.04]];
    let law = polymer(&[("tension_by_rate", table(&rows)), ("compression", table(&flat))]);
    for (rate, factor) in [(0.05, 1.25), (1.0, 1.5)] {
        for (sign, slow) in [(1.0, 0.03), (-1.0, 0.04)] {
            let mut cube = Cube::new(&law);
            let each = 2e-4;
            for _ in 0..1000 {
                cube.pull([sign * each, 0.0, 0.0, 0.0, 0.0, 0.0], &SIDES, each / rate);
            }
            let wanted = sign * factor * slow;
            assert!((cube.state[0] / wanted - 1.0).abs() < 1e-6, "{rate} {sign}: {wanted}");
        }
    }
}

/// Damage lowers stress and modulus; from the strain of failure on the stress fades to zero, where
/// the point fails.
#[test]
fn damage_lowers_stress_and_modulus_until_failure() {
    let law = polymer(&[
        ("tension", table(&TENSION[..1])),
        ("plastic_poisson", Param::Number(0.5)),
        ("damage", table(&[[0.0, 0.0], [0.1, 0.4], [1.0, 0.4]])),
        ("failure_strain", Param::Number(0.15)),
        ("fading_strain", Param::Number(0.1)),
    ]);
    let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
    for step in 1..=290 {
        cube.pull([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0], &SIDES, 1.0);
        sheet.pull(1e-3, 1.0);
        let strain = cube.at("plastic_strain");
        if step == 100 || step == 200 {
            let left = (1.0 - (4.0 * strain).min(0.4)) * (1.0 - ((strain - 0.15) / 0.1).max(0.0));
            assert!((cube.at("damage") - (1.0 - left)).abs() < 1e-12, "{strain}");
            assert!((cube.state[0] / (0.03 * left) - 1.0).abs() < 1e-6, "{strain}");
            assert!((sheet.state[0] / (0.03 * left) - 1.0).abs() < 1e-6, "{strain}");
            let mut unloaded = cube.clone();
            unloaded.pull([-1e-4, 0.0, 0.0, 0.0, 0.0, 0.0], &SIDES, 1.0);
            let modulus = (cube.state[0] - unloaded.state[0]) / 1e-4;
            assert!((modulus / (YOUNG * left) - 1.0).abs() < 1e-6, "{modulus}");
        }
    }
    assert_eq!(cube.at("failed"), 1.0);
    assert!(cube.state[..6].iter().chain(&sheet.state[..3]).all(|s| *s == 0.0));
}

/// With the factor of convexity the yield stress in shear is at least that of the paraboloid.
#[test]
fn a_factor_makes_the_surface_convex() {
    let curves = [("tension", TENSION), ("compression", COMPRESSION), ("shear", [[0.0, 0.01]; 3])];
    let mut more: Vec<_> = curves[..2].iter().map(|(key, rows)| (*key, table(rows))).collect();
    more.push(("shear", table(&[[0.0, 0.01]])));
    more.push(("plastic_poisson", Param::Number(0.5)));
    more.push(("convexity", Param::Number(1.1)));
    let mut cube = Cube::new(&polymer(&more));
    for _ in 0..100 {
        cube.step([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1.0);
    }
    let strain = cube.at("strain of tension");
    let wanted = 1.1 * (at(&TENSION, strain) * at(&COMPRESSION, strain) / 3.0).sqrt();
    assert!((cube.state[3] / wanted - 1.0).abs() < 1e-9);
}

/// Random paths from a stress of zero cost work, also with damage, rates and a surface that is not
/// convex.
#[test]
fn random_paths_give_no_energy() {
    let weak = [[0.0, 0.012], [0.5, 0.02]];
    let by_rate = [[0.0, 0.0, 0.03], [0.0, 0.5, 0.05], [1.0, 0.0, 0.05], [1.0, 0.5, 0.06]];
    let mut noise = Noise(29);
    for path in 0..80 {
        let mut more = vec![
            ("compression", table(&COMPRESSION)),
            ("plastic_poisson", Param::Number([0.0, 0.2, 0.5][path % 3])),
        ];
        match path % 4 {
            0 => more.push(("tension", table(&TENSION))),
            1 => more.extend([("tension", table(&TENSION)), ("shear", table(&SHEAR))]),
            2 => more.extend([("tension", table(&TENSION)), ("shear", table(&weak))]),
            _ => more.push(("tension_by_rate", table(&by_rate))),
        }
        if path % 5 == 0 {
            more.push(("damage", table(&[[0.0, 0.0], [0.4, 0.7]])));
        }
        let law = polymer(&more);
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        let (mut work, mut most) = (0.0, 0.0f64);
        for _ in 0..20 {
            let leg: [f64; 6] = std::array::from_fn(|_| 2e-4 * noise.next());
            let dt = 10f64.powf(2.0 * noise.next() - 3.0);
            for _ in 0..100 {
                cube.step(leg, dt);
                let before: [f64; 3] = std::array::from_fn(|c| sheet.state[c]);
                let plane = [leg[0], leg[1], leg[3]];
                sheet.step(plane, dt);
                work += (0..3).map(|c| 0.5 * (before[c] + sheet.state[c]) * plane[c]).sum::<f64>();
                most = most.max(work).max(cube.work);
                assert!(cube.work > -1e-6 * most && work > -1e-6 * most, "{path}: {}", cube.work);
            }
        }
    }
}

#[test]
fn bad_curves_are_refused_all_at_once() {
    let text = problems(&polymer(&[
        ("tension", table(&[[0.1, 0.03], [0.05, 0.04]])),
        ("shear", table(&SHEAR)),
        ("plastic_poisson", Param::Number(0.7)),
        ("damage", table(&[[0.0, 0.5], [0.1, 0.2]])),
        ("fading_strain", Param::Number(0.1)),
    ]));
    for part in [
        "tension is not such a curve",
        "shear is given without compression",
        "plastic_poisson is 0.7",
        "damage falls",
        "damage begins with a damage",
        "fading_strain is given without",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = problems(&polymer(&[]));
    assert!(text.contains("tension is missing"), "{text}");
}
