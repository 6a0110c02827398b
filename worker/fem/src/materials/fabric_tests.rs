//! Fabric on paths of strain: tension, shear, no compression, yarns at an angle, energy.

use super::super::build;
use super::super::testing::material;
use super::*;
use crumple_proto::partition::Param;

const E: f64 = 0.3;
const NU: f64 = 0.3;

/// Returns the law with these numbers besides the isotropic constants.
fn law(numbers: &[(&str, f64)], compression: bool) -> Box<dyn PlaneStress> {
    let constants = [("youngs_modulus", E), ("poisson", NU)];
    let all: Vec<_> = constants.iter().chain(numbers).copied().collect();
    build(&material("fabric", &all, &[("compression", Param::Flag(compression))])).unwrap()
}

/// A point with its state; yarns at an angle to the first axis.
struct Sheet {
    law: Box<dyn PlaneStress>,
    state: [f64; COLUMNS],
    work: f64,
}

impl Sheet {
    fn new(law: Box<dyn PlaneStress>, angle: f64) -> Self {
        let mut state = [0.0; COLUMNS];
        (state[6], state[7]) = (angle.cos() - 1.0, angle.sin());
        Self { law, state, work: 0.0 }
    }

    /// Goes to a total strain in steps; returns the stress.
    fn go(&mut self, to: [f64; 3], steps: usize) -> [f64; 3] {
        let from = [3, 4, 5].map(|c| self.state[c]);
        for _ in 0..steps {
            let strain = [0, 1, 2].map(|c| (to[c] - from[c]) / steps as f64);
            let before: [f64; 3] = std::array::from_fn(|c| self.state[c]);
            let points =
                Points { state: &mut self.state, strain: &[strain], thickness_strain: &mut [0.0] };
            self.law.update_one(points, 1.0);
            for c in 0..3 {
                self.work += 0.5 * (before[c] + self.state[c]) * strain[c];
            }
        }
        std::array::from_fn(|c| self.state[c])
    }
}

fn assert_near(stress: [f64; 3], wanted: [f64; 3], what: &str) {
    for (s, w) in stress.iter().zip(wanted) {
        assert!((s - w).abs() < 1e-12 * E, "{what}: {stress:?}, not {wanted:?}");
    }
}

/// Tension along one axis has E e, along both E e/(1 - nu), in any direction; compression and what
/// is slack have nothing, and shear leaves a tension of E g/2 along its diagonal.
#[test]
fn isotropic_fabric_carries_tension_only() {
    let e = 1e-2;
    let free = |strain: [f64; 3]| Sheet::new(law(&[], false), 0.0).go(strain, 3);
    assert_near(free([e, -NU * e, 0.0]), [E * e, 0.0, 0.0], "tension");
    assert_near(free([e, -3.0 * e, 0.0]), [E * e, 0.0, 0.0], "tension of a wrinkled sheet");
    let both = E * e / (1.0 - NU);
    assert_near(free([e, e, 0.0]), [both, both, 0.0], "tension along both axes");
    assert_near(free([-e, -0.5 * e, 0.0]), [0.0; 3], "compression");
    assert_near(free([0.0, 0.0, e]), [0.25 * E * e; 3], "shear");
    let stiff = |strain| Sheet::new(law(&[], true), 0.0).go(strain, 3);
    assert_near(stiff([-e, NU * e, 0.0]), [-E * e, 0.0, 0.0], "compression that is carried");
    assert_near(stiff([0.0, 0.0, e]), [0.0, 0.0, 0.5 * E * e / (1.0 + NU)], "shear with it");
}

/// Each yarn has its own modulus; one that is slack has no stress, and the other one its modulus
/// alone. Shear has G. At an angle, strain and stress turn.
#[test]
fn yarns_have_their_own_moduli_in_their_directions() {
    let (eb, g, e) = (0.1, 0.02, 1e-2);
    let new = |angle: f64| {
        Sheet::new(law(&[("youngs_modulus_b", eb), ("shear_modulus", g)], false), angle)
    };
    let nu_ab = NU * E / eb;
    assert!(nu_ab * NU < 1.0);
    assert_near(new(0.0).go([e, -nu_ab * e, 0.0], 2), [E * e, 0.0, 0.0], "along a");
    assert_near(new(0.0).go([-NU * e, e, 0.0], 2), [0.0, eb * e, 0.0], "along b");
    assert_near(new(0.0).go([e, -2.0 * e, 0.0], 2), [E * e, 0.0, 0.0], "b is slack");
    assert_near(new(0.0).go([-e, -e, e], 2), [0.0, 0.0, g * e], "shear of a slack fabric");
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_near(new(quarter).go([e, -NU * e, 0.0], 2), [eb * e, 0.0, 0.0], "turned by 90 degrees");
    // Uniaxial stress s at 45 degrees: half of it on each yarn and as shear.
    let s = 1e-4;
    let (a, b) = (0.5 * s * (1.0 / E - NU / eb), 0.5 * s * (1.0 / eb - NU / eb));
    let ab = -0.5 * s / g;
    // Strain in axes turned back by 45 degrees.
    let strain = [0.5 * (a + b - ab), 0.5 * (a + b + ab), a - b];
    assert_near(new(0.5 * quarter).go(strain, 2), [s, 0.0, 0.0], "at 45 degrees");
}

/// The stress is that of an energy: a closed path through taut, wrinkled and slack states does no
/// work, except for the error of the trapezoidal rule.
#[test]
fn a_closed_path_of_strain_does_no_work() {
    for numbers in [&[][..], &[("youngs_modulus_b", 0.1), ("shear_modulus", 0.02)][..]] {
        let mut sheet = Sheet::new(law(numbers, false), 0.4);
        let mut largest = 0.0f64;
        for to in [
            [2e-2, 1e-2, 0.0],
            [1e-2, -3e-2, 2e-2],
            [-1e-2, -1e-2, 1e-2],
            [0.0, 2e-2, -3e-2],
            [0.0; 3],
        ] {
            sheet.go(to, 2000);
            largest = largest.max(sheet.work);
        }
        assert!(sheet.work.abs() < 1e-5 * largest, "{} of {largest}", sheet.work);
        assert!(largest > 1e-6);
    }
}

/// The liner has its fraction of the thickness and carries compression. Damping adds stress in
/// proportion to the increment, and none at rest.
#[test]
fn liner_and_damping() {
    let liner = [("liner_fraction", 0.2), ("liner_youngs_modulus", 0.05)];
    let e = -1e-2;
    let stress = Sheet::new(law(&liner, false), 0.0).go([e, 0.0, 0.0], 1);
    assert_near(stress, [0.2 * 0.05 * e, 0.0, 0.0], "a liner without a Poisson's ratio");
    let mut sheet = Sheet::new(law(&[("damping", 0.1)], false), 0.0);
    let c11 = E / (1.0 - NU * NU);
    assert_near(sheet.go([e, 0.0, 0.0], 1), [0.1 * c11 * e, 0.1 * NU * c11 * e, 0.0], "damping");
    assert_near(sheet.go([e, 0.0, 0.0], 1), [0.0; 3], "at rest");
    // The stable step: c of the undamped fabric over that of the law.
    let plain = law(&[], false).elastic().plate_wave_speed();
    let damped = sheet.law.elastic().plate_wave_speed();
    assert!((plain / damped - ((1.0f64 + 0.01).sqrt() - 0.1)).abs() < 1e-12);
}

/// The constants for the stable step bound the stiffness in all directions.
#[test]
fn the_bound_is_nowhere_below_the_fabric() {
    for (eb, g) in [(0.1, 0.02), (0.9, 0.02), (0.3, 0.5)] {
        let law = law(&[("youngs_modulus_b", eb), ("shear_modulus", g)], true);
        let [c11, c12, shear] = law.elastic().plane_stress();
        for k in 0..60 {
            let (s, c) = (f64::from(k) * 0.1).sin_cos();
            for xy in [0.0, 0.5, 2.0] {
                let e = [c, s, xy].map(|e| 1e-3 * e);
                let mut sheet = Sheet::new(build_again(eb, g), 0.7);
                let stress = sheet.go(e, 1);
                let own: f64 = (0..3).map(|c| stress[c] * e[c]).sum();
                let bound = c11 * (e[0] * e[0] + e[1] * e[1])
                    + 2.0 * c12 * e[0] * e[1]
                    + shear * xy * xy * 1e-6;
                assert!(own <= bound * (1.0 + 1e-12), "{own} {bound}");
            }
        }
    }
}

fn build_again(eb: f64, g: f64) -> Box<dyn PlaneStress> {
    law(&[("youngs_modulus_b", eb), ("shear_modulus", g)], true)
}

/// A criterion of failure around the law keeps the directions of its yarns.
#[test]
fn a_fabric_that_fails_keeps_its_directions() {
    let yarns = [("youngs_modulus_b", 0.2), ("shear_modulus", 0.01), ("angle", 30.0)];
    let plain = law(&yarns, false).orientation();
    let failing = [&yarns[..], &[("erosion_principal_stress", 0.01)]].concat();
    assert!(plain.is_some());
    assert_eq!(law(&failing, false).orientation(), plain);
}
