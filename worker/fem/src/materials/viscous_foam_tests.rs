//! Tests of foam with a damper that grows with the change of volume.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, material, problems};
use crumple_proto::partition::Material;

/// Moduli in GPa, times in ms.
const YOUNG: f64 = 1e-3;
const POISSON: f64 = 0.05;
const STIFFENS: f64 = 4.0;
const SERIES: f64 = 0.1;
const THICKENS: f64 = 0.2;

fn ribs(viscosity: f64) -> Material {
    let numbers = [
        ("youngs_modulus", YOUNG),
        ("poisson", POISSON),
        ("stiffness_exponent", STIFFENS),
        ("viscous_coefficient", viscosity),
        ("viscous_modulus", SERIES),
        ("viscous_exponent", THICKENS),
    ];
    material("viscous_foam", &numbers, &[])
}

/// Returns the modulus of a uniaxial strain over Young's modulus.
fn uniaxial() -> f64 {
    (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
}

/// Without a damper a compression to a fifth has the stress `M (1 - V^-n)/n`, and none is left
/// after the way back. The middle rule of the shape has an error of the square of the step times n:
/// `(4 * 1.6e-3)^2/24` = 1.7e-6.
#[test]
fn slow_compression_follows_the_power_of_the_volume() {
    let mut cube = Cube::new(&ribs(0.0));
    let each = -1.6e-3;
    let mut most = 0.0f64;
    for step in 1..=1000 {
        cube.step([each, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        let volume = (each * f64::from(step)).exp();
        let exact = YOUNG * uniaxial() * (1.0 - volume.powf(-STIFFENS)) / STIFFENS;
        assert!((cube.state[0] / exact - 1.0).abs() < 2e-6, "{step}: {}", cube.state[0] / exact);
        most = most.max(cube.work);
    }
    for _ in 0..1000 {
        cube.step([-each, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
    }
    assert!(cube.work.abs() < 1e-9 * most, "{} of {most}", cube.work);
    assert!(cube.state[..6].iter().all(|s| s.abs() < 1e-9), "{:?}", &cube.state[..6]);
}

/// Compressed foam that is sheared at a constant rate, then held: the damper has the closed form of
/// a Maxwell element with the viscosity of this volume (rounding, and the series of short steps).
#[test]
fn the_damper_relaxes_with_the_viscosity_of_the_volume() {
    let viscosity = 0.02;
    let mut cube = Cube::new(&ribs(viscosity));
    let press = -0.5 / 300.0;
    (0..100).for_each(|_| _ = cube.step([press, press, press, 0.0, 0.0, 0.0], 1e3));
    let volume = (-0.5f64).exp();
    let per = 0.5 / (1.0 + POISSON);
    let eta = viscosity * (1.0 - volume).powf(THICKENS);
    let slow = YOUNG * volume.powf(-STIFFENS) * per;
    let (rate, ramp, dt) = (1e-2, 0.3, 0.01);
    let mut time = 0.0;
    for step in 0..60 {
        let shear = if step < 30 { rate * dt } else { 0.0 };
        cube.step([0.0, 0.0, 0.0, shear, 0.0, 0.0], dt);
        time += dt;
        let since = (time - ramp).max(0.0);
        let loaded = time.min(ramp);
        let decay = SERIES / eta;
        let held = (-decay * since).exp() * -(-decay * loaded).exp_m1();
        let exact = rate * (slow * loaded + per * eta * held);
        assert!((cube.state[3] / exact - 1.0).abs() < 1e-9, "{time}: {}", cube.state[3] / exact);
    }
}

/// Random paths from the start, with large changes of the volume, cost work, except for half a step
/// of the rule of the trapezoid, 1/800 of a leg.
#[test]
fn random_paths_give_no_energy() {
    let mut noise = Noise(5);
    for path in 0..60 {
        let mut cube = Cube::new(&ribs(if path % 2 == 0 { 0.02 } else { 0.0 }));
        let mut target: [f64; 6] = [0.0; 6];
        let mut most = 0.0f64;
        for leg in 0..12 {
            let before = target;
            target = match leg {
                11 => [0.0; 6],
                _ => std::array::from_fn(|c| {
                    if c < 3 { 0.3 * (noise.next() - 0.5) } else { 0.4 * noise.next() }
                }),
            };
            let dt = 10f64.powf(2.0 * noise.next());
            for _ in 0..400 {
                cube.step(std::array::from_fn(|c| (target[c] - before[c]) / 400.0), dt);
                most = most.max(cube.work);
                assert!(cube.work > -2e-3 * most, "{path}, {leg}: {} of {most}", cube.work);
            }
        }
    }
}

#[test]
fn bad_constants_are_refused_all_at_once() {
    let numbers = [
        ("youngs_modulus", 1.0),
        ("poisson", 0.1),
        ("stiffness_exponent", -1.0),
        ("viscous_coefficient", 1.0),
        ("viscous_modulus", 0.0),
    ];
    let text = problems(&material("viscous_foam", &numbers, &[]));
    assert!(text.contains("stiffness_exponent is -1"), "{text}");
    assert!(text.contains("the damper would have no effect"), "{text}");
}
