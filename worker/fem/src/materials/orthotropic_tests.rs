//! Plies on paths of strain: moduli off the axes, strengths, residual strengths, loss of stress,
//! nonlinear shear, dissipation.

use super::super::build;
use super::super::testing::{material, problems};
use super::*;
use crate::elements::testing::Noise;

/// Carbon fibres in epoxy, in MPa.
const PLY: [(&str, f64); 4] = [
    ("youngs_modulus", 165e3),
    ("youngs_modulus_b", 9e3),
    ("poisson", 0.0185),
    ("shear_modulus", 5.6e3),
];
const XT: f64 = 2560.0;
const XC: f64 = 1590.0;
const YT: f64 = 73.0;
const YC: f64 = 185.0;
const S: f64 = 90.0;
const STRENGTHS: [(&str, f64); 5] = [
    ("strength_tension_a", XT),
    ("strength_compression_a", XC),
    ("strength_tension_b", YT),
    ("strength_compression_b", YC),
    ("strength_shear", S),
];

/// Returns the law with these numbers besides the elastic constants.
fn law(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Box<dyn PlaneStress> {
    let all: Vec<_> = PLY.iter().chain(numbers).copied().collect();
    build(&material("orthotropic", &all, others)).map_err(|p| format!("{p:?}")).unwrap()
}

/// Returns a law with all strengths and with large strains at failure, except for these numbers.
fn failing(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Box<dyn PlaneStress> {
    let given = |key: &str| numbers.iter().any(|(name, _)| *name == key);
    let mut all = [&STRENGTHS[..], numbers].concat();
    if !given("failure_strain_tension_a") {
        all.push(("failure_strain_tension_a", 10.0));
    }
    law(&all, others)
}

/// A point with its state; its axis a at an angle to the first axis.
struct Sheet {
    law: Box<dyn PlaneStress>,
    state: Vec<f64>,
    work: f64,
}

impl Sheet {
    fn new(law: Box<dyn PlaneStress>, angle: f64) -> Self {
        let mut state = vec![0.0; 3 + law.history().len()];
        (state[COSINE], state[SINE]) = (angle.cos() - 1.0, angle.sin());
        Self { law, state, work: 0.0 }
    }

    /// Adds a strain in steps; returns the stress.
    fn add(&mut self, strain: [f64; 3], steps: usize) -> [f64; 3] {
        let strain = strain.map(|e| e / steps as f64);
        for _ in 0..steps {
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

    fn failed(&self) -> bool {
        self.state[FAILED] > 0.5
    }
}

/// Returns the strain for a stress along the axes.
fn elastic_strain([a, b, ab]: [f64; 3]) -> [f64; 3] {
    let [(_, ea), (_, eb), (_, nu), (_, g)] = PLY;
    [a / ea - nu / eb * b, b / eb - nu / eb * a, ab / g]
}

#[track_caller]
fn assert_near(stress: [f64; 3], wanted: [f64; 3], what: &str) {
    for (s, w) in stress.iter().zip(wanted) {
        assert!((s - w).abs() < 1e-9 * XT, "{what}: {stress:?}, not {wanted:?}");
    }
}

/// Young's modulus at an angle to the fibres: Jones, Mechanics of Composite Materials, 2nd ed.,
/// ch. 2.
#[test]
fn modulus_off_the_axes() {
    let [(_, ea), (_, eb), (_, nu), (_, g)] = PLY;
    for degrees in [0.0, 20.0, 45.0, 70.0, 90.0_f64] {
        let angle = degrees.to_radians();
        // Compliance along x: invert the stiffness, whose columns are stresses of unit strains.
        let unit = |k: usize| {
            let mut strain = [0.0; 3];
            strain[k] = 1.0;
            Sheet::new(law(&[], &[]), angle).add(strain, 1)
        };
        let stiffness = nalgebra::Matrix3::from_columns(&[0, 1, 2].map(|k| unit(k).into()));
        let compliance = stiffness.try_inverse().expect("a stiffness");
        let (s, c) = angle.sin_cos();
        let mixed = 1.0 / g - 2.0 * nu / eb;
        let wanted = c.powi(4) / ea + mixed * (s * c).powi(2) + s.powi(4) / eb;
        assert!((compliance[(0, 0)] / wanted - 1.0).abs() < 1e-12, "{degrees} degrees");
    }
}

/// A stress along one axis reaches its strength and stays there; unloading is elastic, and the
/// strain that remains is what was beyond the strength.
#[test]
fn strengths_along_the_axes() {
    let cases = [
        ([1.0, 0.0, 0.0], XT),
        ([-1.0, 0.0, 0.0], XC),
        ([0.0, 1.0, 0.0], YT),
        ([0.0, -1.0, 0.0], YC),
        ([0.0, 0.0, 1.0], S),
        ([0.0, 0.0, -1.0], S),
    ];
    for (direction, strength) in cases {
        for angle in [0.0, 0.5] {
            let mut sheet = Sheet::new(failing(&[], &[]), angle);
            // Strain of the axes of the ply as one of the element, and stress the other way.
            let to_element = |e: [f64; 3]| strain_along(e, angle.cos(), -angle.sin());
            let to_ply = |s: [f64; 3]| stress_along(s, angle.cos(), angle.sin());
            let at = direction.map(|d| d * strength);
            let just = elastic_strain(at);
            let stress = to_ply(sheet.add(to_element(just.map(|e| 0.999 * e)), 7));
            assert_near(stress, at.map(|s| 0.999 * s), "below the strength");
            assert!(sheet.state[MODES..=FAILED].iter().all(|&mode| mode == 0.0));
            let beyond = direction.map(|d| 0.01 * d);
            sheet.add(to_element(just.map(|e| 0.001 * e)), 1);
            let stress = to_ply(sheet.add(to_element(beyond), 50));
            assert_near(stress, at, "at the strength");
            assert!(!sheet.failed());
            let stress = to_ply(sheet.add(to_element(just.map(|e| -e)), 9));
            assert_near(stress, [0.0; 3], "unloaded");
        }
    }
}

/// Every stress beyond the limits ends on its criterion, by either criterion of the matrix.
#[test]
fn combined_stresses_end_on_the_criteria() {
    for tsai_wu in [false, true] {
        for (b, ab) in [(60.0, 80.0), (-150.0, 70.0), (-100.0, 200.0), (30.0, -150.0)] {
            let law = failing(&[], &[("tsai_wu", Param::Flag(tsai_wu))]);
            let mut sheet = Sheet::new(law, 0.0);
            let [_, b, ab] = sheet.add(elastic_strain([0.0, 2.0 * b, 2.0 * ab]), 40);
            let shear = (ab / S).powi(2);
            let on = if tsai_wu {
                b * b / (YC * YT) + (1.0 / YT - 1.0 / YC) * b + shear
            } else if b > 0.0 {
                (b / YT).powi(2) + shear
            } else {
                (0.5 * b / S).powi(2) + ((0.5 * YC / S).powi(2) - 1.0) * b / YC + shear
            };
            assert!((on - 1.0).abs() < 1e-9, "tsai_wu {tsai_wu}, ({b}, {ab}): {on}");
        }
    }
    let mut sheet = Sheet::new(failing(&[("shear_weight", 0.5)], &[]), 0.0);
    let [a, _, ab] = sheet.add(elastic_strain([3000.0, 0.0, 70.0]), 40);
    assert!(((a / XT).powi(2) + 0.5 * (ab / S).powi(2) - 1.0).abs() < 1e-9, "{a}, {ab}");
}

/// After failure a mode keeps its residual fraction; fibres lose strength after compressive failure
/// of the matrix.
#[test]
fn residual_and_crushed_strengths() {
    let residual = Param::List(vec![0.5, 0.4, 0.3, 0.2, 0.1]);
    let cases = [
        ([6000.0, 0.0, 0.0], 0, 0.5 * XT),
        ([-6000.0, 0.0, 0.0], 0, -0.4 * XC),
        ([0.0, 600.0, 0.0], 1, 0.3 * YT),
        ([0.0, -600.0, 0.0], 1, -0.2 * YC),
        ([0.0, 0.0, 300.0], 2, 0.1 * S),
    ];
    for (elastic, component, wanted) in cases {
        let law = failing(&[], &[("residual_strengths", residual.clone())]);
        let stress = Sheet::new(law, 0.0).add(elastic_strain(elastic), 100);
        let got = stress[component];
        assert!((got / wanted - 1.0).abs() < 1e-9, "{elastic:?}: {got}, not {wanted}");
    }
    let crushed = [("crushed_tension_a", 1000.0), ("crushed_compression_a", 370.0)];
    for (sign, wanted) in [(1.0, 1000.0), (-1.0, 370.0)] {
        let mut sheet = Sheet::new(failing(&crushed, &[]), 0.0);
        sheet.add([0.0, -0.05, 0.0], 50);
        let [a, ..] = sheet.add([0.05 * sign, 0.0, 0.0], 50);
        assert!((a * sign / wanted - 1.0).abs() < 1e-9, "{a}, not {wanted}");
    }
}

/// A ply loses its stress at each of its largest strains, and without one along a at X_T.
#[test]
fn a_ply_fails_at_its_strains() {
    let effective =
        |[a, b, ab]: [f64; 3]| (4.0 / 3.0 * (a * a + a * b + b * b + 0.25 * ab * ab)).sqrt();
    let mixed = [0.004, -0.002, 0.01];
    let cases = [
        ("failure_strain_tension_a", [1.0, 0.0, 0.0], 0.03),
        ("failure_strain_compression_a", [-1.0, 0.0, 0.0], 0.02),
        ("failure_strain_b", [0.0, -1.0, 0.0], 0.04),
        ("failure_strain_b", [0.0, 1.0, 0.0], 0.04),
        ("failure_strain_shear", [0.0, 0.0, -1.0], 0.05),
        ("failure_strain_effective", mixed.map(|e| e / effective(mixed)), 0.06),
    ];
    for (key, direction, strain) in cases {
        let mut sheet = Sheet::new(failing(&[(key, strain)], &[]), 0.3);
        let along =
            strain_along(direction.map(|d| 0.99 * strain * d), 0.3_f64.cos(), -(0.3_f64.sin()));
        sheet.add(along, 100);
        assert!(!sheet.failed(), "{key} below");
        sheet.add(along.map(|e| 0.02 * e), 1);
        assert!(sheet.failed(), "{key} above");
        let stress = sheet.add([0.01, 0.02, 0.03], 3);
        assert_eq!(stress, [0.0; 3], "{key}: a failed ply has no stress");
    }
    let mut sheet = Sheet::new(law(&STRENGTHS, &[]), 0.0);
    sheet.add(elastic_strain([0.999 * XT, 0.0, 0.0]), 10);
    assert!(!sheet.failed());
    sheet.add(elastic_strain([0.002 * XT, 0.0, 0.0]), 1);
    assert!(sheet.failed());
}

/// The shear stress is the root of g = t/G + alpha t^3, loading and unloading.
#[test]
fn nonlinear_shear() {
    let alpha = 2e-8;
    let mut sheet = Sheet::new(failing(&[("shear_nonlinearity", alpha)], &[]), 0.0);
    let mut strain = 0.0;
    for step in [0.002, 0.004, 0.004, -0.006, -0.008, 0.003] {
        let [.., t] = sheet.add([0.0, 0.0, step], 10);
        strain += step;
        let wanted = t / 5.6e3 + alpha * t.powi(3);
        assert!((wanted - strain).abs() < 1e-12, "{t}: {wanted}, not {strain}");
    }
}

/// With `shear_energy` a ply cracks where the energy of its shear and the square of the tension
/// across are one together; fibres break in the same way.
#[test]
fn shear_counts_by_its_energy() {
    let alpha = 2e-8;
    let energy = |t: f64| t * t / (2.0 * 5.6e3) + 0.75 * alpha * t.powi(4);
    for share in [0.3, 0.7, 1.0] {
        let t = S * share;
        let part = energy(t) / energy(S);
        for (axis, strength) in [(1, YT), (0, XT)] {
            for (factor, fails) in [(0.999, false), (1.001, true)] {
                let numbers = [("shear_nonlinearity", alpha), ("shear_weight", 1.0)];
                let law = failing(&numbers, &[("shear_energy", Param::Flag(true))]);
                let mut sheet = Sheet::new(law, 0.0);
                let mut stress = [0.0; 3];
                stress[axis] = strength * (1.0 - part).max(0.0).sqrt();
                stress = stress.map(|s| factor * s);
                let mut strain = elastic_strain(stress);
                let t = factor * t;
                strain[2] = t / 5.6e3 + alpha * t.powi(3);
                sheet.add(strain, 50);
                let modes = sheet.state[MODES] + sheet.state[MODES + 2] + sheet.state[MODES + 3];
                assert_eq!(modes > 0.5, fails, "{share} {axis} {factor}");
            }
        }
    }
}

/// On random closed paths of strain the work is never negative: failure dissipates.
#[test]
fn failure_dissipates() {
    let mut noise = Noise(7);
    let mut random = || 0.5 + 0.5 * noise.next();
    for run in 0..200 {
        let numbers = [
            ("shear_weight", 0.3),
            ("shear_nonlinearity", if run % 2 == 0 { 2e-8 } else { 0.0 }),
            ("crushed_compression_a", 370.0),
        ];
        let residual = Param::List(vec![0.2 + 0.8 * random(); 5]);
        let tsai_wu = ("tsai_wu", Param::Flag(run % 3 == 0));
        let by_energy = ("shear_energy", Param::Flag(run % 3 == 1));
        let law = failing(&numbers, &[("residual_strengths", residual), tsai_wu, by_energy]);
        let angle = random();
        let mut sheet = Sheet::new(law, if run % 4 < 2 { 0.0 } else { angle });
        let mut at = [0.0; 3];
        // Half of the paths leave the fibres alone: the energy of the matrix is much smaller.
        let of_matrix = run % 4 < 2;
        for _ in 0..6 {
            let along = if of_matrix { 0.0 } else { 0.03 };
            let strain = [along, 0.06, 0.08].map(|size| size * (random() - 0.5));
            at = std::array::from_fn(|c| at[c] + strain[c]);
            sheet.add(strain, 400);
        }
        sheet.add(at.map(|e| -e), 400);
        // Half a step of the trapezoidal rule over a drop to the residual strength.
        let allowed = if of_matrix { 0.02 } else { 1e-3 * XT };
        assert!(sheet.work > -allowed, "run {run}: {}", sheet.work);
    }
}

#[test]
fn wrong_parameters_are_all_reported() {
    let numbers = [
        ("youngs_modulus", 10.0),
        ("poisson", 0.4),
        ("youngs_modulus_b", 1.0),
        ("strength_tension_a", -1.0),
        ("shear_weight", 2.0),
    ];
    let others = [("tsai_wu", Param::Flag(true)), ("residual_strengths", Param::List(vec![1.0]))];
    let text = problems(&material("orthotropic", &numbers, &others));
    for wanted in [
        "shear_modulus is missing",
        "gives no stable ply",
        "strength_tension_a is -1",
        "shear_weight is 2",
        "without the strengths of the matrix",
        "no list of five fractions",
        "for shells only",
    ] {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}
