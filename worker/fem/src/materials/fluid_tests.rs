//! Stress of fluids in closed form. Water in mm, ms, kg, GPa.

use crate::materials::testing::{Cube, material, problems, table};
use crate::materials::{build_solid, contact_constants};
use crumple_proto::partition::{Material, Param};

const DENSITY: f64 = 1e-6;
const BULK: f64 = 2.25;
/// Far thicker than water, so that its stress shows [GPa ms].
const VISCOSITY: f64 = 1e-3;

fn water(more: &[(&str, Param)]) -> Material {
    let constants = Param::List(vec![BULK, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let equation = [("eos_polynomial", constants)];
    let mut law = material("fluid", &[("viscosity", VISCOSITY)], &[&equation, more].concat());
    law.density = DENSITY;
    law
}

/// Shear at a constant rate has the stress `eta gamma'`, and none once it stops; the pressure is
/// that of the volume.
#[test]
fn stress_is_viscous_and_pressure_is_that_of_the_volume() {
    let mut cube = Cube::new(&water(&[]));
    let dt = 0.02;
    for _ in 0..50 {
        cube.step([0.0, 0.0, 0.0, 4e-3, 0.0, -2e-3], dt);
    }
    let expected = [VISCOSITY * 4e-3 / dt, VISCOSITY * -2e-3 / dt];
    assert!((cube.state[3] - expected[0]).abs() < 1e-15, "{}", cube.state[3]);
    assert!((cube.state[5] - expected[1]).abs() < 1e-15, "{}", cube.state[5]);
    cube.step([0.0; 6], dt);
    assert_eq!(cube.state[..6], [0.0; 6], "at rest, without compression");

    // Uniaxial compression: stress along it exceeds the pressure by 4/3 eta eps'.
    cube.step([-0.02, 0.0, 0.0, 0.0, 0.0, 0.0], dt);
    let pressure = BULK * (0.02f64.exp() - 1.0);
    let along = -pressure - 4.0 / 3.0 * VISCOSITY * 0.02 / dt;
    let across = -pressure + 2.0 / 3.0 * VISCOSITY * 0.02 / dt;
    for (c, exact) in [along, across, across].into_iter().enumerate() {
        assert!((cube.state[c] - exact).abs() < 1e-14, "{c}: {} for {exact}", cube.state[c]);
    }
}

/// A closed path of strain costs the work of the viscosity. The mean of two stresses loses that of
/// one step at each of the three reversals, of 800; the volume differs by up to 4 %, in both ways.
#[test]
fn a_closed_path_gives_no_energy() {
    let mut cube = Cube::new(&water(&[]));
    let mut exact = 0.0;
    for step in 0..800 {
        let sign = if (200..600).contains(&step) { -1.0 } else { 1.0 };
        cube.step([sign * 2e-4, 0.0, 0.0, sign * 1e-3, 0.0, 0.0], 0.01);
        // Per step 2 eta e':e' dt, with the volume of about one.
        exact += VISCOSITY * (4.0 / 3.0 * 2e-4 * 2e-4 + 1e-3 * 1e-3) / 0.01;
    }
    assert!(cube.strain[0].abs() < 1e-12, "the path is closed: {}", cube.strain[0]);
    assert!((cube.work / exact - 1.0).abs() < 0.01, "{} for {exact}", cube.work);
}

/// The modulus that the step counts has `2 (4 eta/3)/dt` more than that of the pressure.
#[test]
fn viscosity_shortens_the_step() {
    let dt = 0.02;
    let mut cube = Cube::new(&water(&[]));
    cube.step([0.0, 0.0, 0.0, 1e-6, 0.0, 0.0], dt);
    let expected = 8.0 / 3.0 * VISCOSITY / dt / BULK;
    let got = cube.at("stiffening");
    assert!((got / expected - 1.0).abs() < 1e-5, "{got} for {expected}");
    let elastic = build_solid(&water(&[])).expect("a law").elastic();
    let speed = (BULK / DENSITY).sqrt();
    assert!((elastic.dilatational_wave_speed() / speed - 1.0).abs() < 1e-5);
    let (modulus, wave) = contact_constants(&water(&[])).expect("constants");
    assert!((modulus / BULK - 1.0).abs() < 1e-6 && (wave / speed - 1.0).abs() < 1e-5);
}

/// A table is linear between its points and beyond them, on both sides of a kink at zero.
#[test]
fn a_table_gives_the_pressure() {
    let rows = [[-0.1, -5.0, 0.4], [0.0, 0.0, 0.4], [0.1, 0.3, 0.4], [0.2, 1.5, 0.6]];
    let fluid = material("fluid", &[], &[("eos_table", table(&rows))]);
    // At constant volume strain of one step, E follows from p = C + gamma T E, E = -p dV/2.
    for (strain, cold, thermal) in [
        (-0.05, -2.5, 0.4),
        (-0.15, -7.5, 0.4),
        (0.05, 0.15, 0.4),
        (0.15, 0.9, 0.5),
        (0.25, 2.1, 0.7),
    ] {
        let mut cube = Cube::new(&fluid);
        cube.step([-strain, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        let change = f64::exp(-strain) - 1.0;
        let exact = cold / (1.0 + 0.5 * thermal * change);
        let got = -cube.state[0];
        assert!((got - exact).abs() < 1e-12, "{strain}: {got} for {exact}");
        assert!((cube.at("eos energy") + 0.5 * exact * change).abs() < 1e-12);
    }
    // The steeper side of the kink bounds the step.
    let bulk = build_solid(&fluid).expect("a law").elastic().bulk_modulus();
    assert!((bulk / 50.0 - 1.0).abs() < 1e-6, "{bulk}");
}

#[test]
fn wrong_fluids_are_refused() {
    let text = problems(&material("fluid", &[("viscosity", -1.0)], &[]));
    assert!(text.contains("viscosity is -1"), "{text}");
    let text = problems(&material("fluid", &[], &[]));
    assert!(text.contains("has no pressure") && text.contains("eos_table"), "{text}");
    for (rows, wanted) in [
        (&[[0.0, 0.1, 0.0], [0.1, 0.5, 0.0]][..], "0 at -ln V = 0"),
        (&[[0.0, 0.0, 0.0], [0.1, -0.5, 0.0]], "may not descend"),
        (&[[0.0, 0.0, 0.0], [0.0, 0.5, 0.0]], "ascends"),
        (&[[0.0, 0.0, 0.0]], "two rows or more"),
    ] {
        let text = problems(&material("fluid", &[], &[("eos_table", table(rows))]));
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
    let two = [("eos_table", table(&[[0.0, 0.0, 0.0], [0.1, 0.5, 0.0]]))];
    assert!(problems(&water(&two)).contains("only one"));
}
