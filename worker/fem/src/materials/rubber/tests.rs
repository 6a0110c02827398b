//! Rubbers on paths with known stress, near incompressibility and compressible. Stresses in MPa.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, material, problems, table};
use crumple_proto::partition::{Material, Param};

/// Near incompressibility; volume and stress change by about the stress over K.
const NU: f64 = 0.499999;
const TOLERANCE: f64 = 1e-4;
const STRETCHES: [f64; 5] = [0.4, 0.8, 1.1, 2.0, 3.0];

/// Cauchy stress of incompressible rubber at a stretch: uniaxial, equal in two directions, and
/// along x with the width held.
struct Closed {
    law: Material,
    uniaxial: fn(f64) -> f64,
    biaxial: fn(f64) -> f64,
    held: fn(f64) -> f64,
}

/// Constants of Mooney and Rivlin: `a + b factor`.
fn mooney(factor: f64) -> f64 {
    0.3 + 0.1 * factor
}

/// Derivatives of the polynomial energy of the test by I1 and I2.
fn slopes(i1: f64, i2: f64) -> [f64; 2] {
    let (x, y) = (i1 - 3.0, i2 - 3.0);
    [0.4 + 0.01 * y + 2.0 * 0.02 * x + 3.0 * 0.003 * x * x, 0.05 + 0.01 * x + 2.0 * 0.004 * y]
}

const OGDEN: [[f64; 2]; 3] = [[0.63, 1.3], [0.0012, 5.0], [-0.01, -2.0]];

fn ogden(power: impl Fn(f64) -> f64) -> f64 {
    OGDEN.iter().map(|[mu, alpha]| mu * power(*alpha)).sum()
}

fn closed() -> [Closed; 3] {
    let c = Param::List(vec![0.4, 0.05, 0.01, 0.02, 0.004, 0.003]);
    [
        Closed {
            law: material("mooney_rivlin", &[("a", 0.3), ("b", 0.1), ("poisson", NU)], &[]),
            uniaxial: |l| 2.0 * (l * l - 1.0 / l) * mooney(1.0 / l),
            biaxial: |l| 2.0 * (l * l - l.powi(-4)) * mooney(l * l),
            held: |l| 2.0 * (l * l - l.powi(-2)) * mooney(1.0),
        },
        Closed {
            law: material("polynomial_rubber", &[("poisson", NU)], &[("coefficients", c)]),
            uniaxial: |l| {
                let [w1, w2] = slopes(l * l + 2.0 / l, 2.0 * l + l.powi(-2));
                2.0 * (l * l - 1.0 / l) * (w1 + w2 / l)
            },
            biaxial: |l| {
                let [w1, w2] = slopes(2.0 * l * l + l.powi(-4), l.powi(4) + 2.0 * l.powi(-2));
                2.0 * (l * l - l.powi(-4)) * (w1 + w2 * l * l)
            },
            held: |l| {
                let i = l * l + 1.0 + l.powi(-2);
                let [w1, w2] = slopes(i, i);
                2.0 * (l * l - l.powi(-2)) * (w1 + w2)
            },
        },
        Closed {
            law: material("ogden", &[("poisson", NU)], &[("terms", table(&OGDEN))]),
            uniaxial: |l| ogden(|alpha| l.powf(alpha) - l.powf(-0.5 * alpha)),
            biaxial: |l| ogden(|alpha| l.powf(alpha) - l.powf(-2.0 * alpha)),
            held: |l| ogden(|alpha| l.powf(alpha) - l.powf(-alpha)),
        },
    ]
}

/// The other rubbers: of Blatz and Ko, by a curve, and the foam by a curve.
fn others() -> [Material; 3] {
    let points: Vec<[f64; 2]> = (-12..=40)
        .map(|k| 1.0 + 0.05 * f64::from(k))
        .map(|l| [l - 1.0, if l == 1.0 { 0.0 } else { 0.8 * (l - l.powi(-2)) }])
        .collect();
    let by_curve = |key| material("tabulated_rubber", &[key], &[("curve", table(&points))]);
    let blatz_ko = material("blatz_ko", &[("shear_modulus", 0.7)], &[]);
    [blatz_ko, by_curve(("bulk_modulus", 8.0)), by_curve(("poisson", 0.3))]
}

/// Stress against the closed forms of incompressible rubber, in tension and compression.
#[test]
fn nearly_incompressible_rubber_has_the_stress_of_the_closed_forms() {
    let mut worst = 0.0f64;
    for Closed { law, uniaxial, biaxial, held } in closed() {
        for stretch in STRETCHES {
            // An equal stretch of two sides of 0.4 makes the third 6.25.
            let stretch_of_two = stretch.clamp(0.6, 2.0);
            let steps = 400;
            let each = |l: f64| 2.0 * (0.5 * l.ln() / f64::from(steps)).tanh();
            let mut cubes = [(); 3].map(|_| Cube::new(&law));
            let [one, two, plane] = &mut cubes;
            for _ in 0..steps {
                one.pull([each(stretch), 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
                let e = each(stretch_of_two);
                two.pull([e, e, 0.0, 0.0, 0.0, 0.0], &[2], 1.0);
                plane.pull([each(stretch), 0.0, 0.0, 0.0, 0.0, 0.0], &[2], 1.0);
            }
            for (cube, exact, name) in [
                (one, uniaxial(stretch), "uniaxial"),
                (two, biaxial(stretch_of_two), "biaxial"),
                (plane, held(stretch), "held"),
            ] {
                let off = (cube.state[0] / exact - 1.0).abs();
                worst = worst.max(off);
                assert!(off < TOLERANCE, "{} {name} {stretch}: {off:e} of {exact}", law.law);
            }
        }
    }
    assert!(worst > 1e-8, "a compressible law cannot meet them exactly: {worst}");
}

/// Rubber of Blatz and Ko in uniaxial stress: the lateral stretch is lambda^-nu, exactly.
#[test]
fn blatz_ko_has_the_stress_of_its_closed_form() {
    let law = material("blatz_ko", &[("shear_modulus", 0.7)], &[]);
    let nu = 0.463;
    for stretch in STRETCHES {
        let mut cube = Cube::new(&law);
        cube.stretch(stretch, 400, 1.0);
        let exact =
            0.7 * stretch.powf(2.0 * nu - 1.0) * (stretch * stretch - stretch.powf(-2.0 * nu));
        assert!((cube.state[0] / exact - 1.0).abs() < 1e-10, "{}: {exact}", cube.state[0]);
        assert!((cube.strain[1] + nu * stretch.ln()).abs() < 1e-10, "{:?}", cube.strain);
    }
}

/// All rubbers at small strain are linear elastic with their shear and bulk modulus, also in
/// simple shear, and the stable modulus is that of waves there.
#[test]
fn small_strain_is_linear() {
    let compressible = |law: &Material| {
        let mut law = law.clone();
        law.parameters.entry("poisson".into()).and_modify(|nu| *nu = Param::Number(0.45));
        law
    };
    let all = closed().map(|closed| (compressible(&closed.law), 0.45));
    let others = [(material("blatz_ko", &[("shear_modulus", 0.7)], &[]), 0.463)];
    for (law, nu) in all.into_iter().chain(others) {
        let elastic = super::super::build_solid(&law).expect("a law").elastic();
        assert_eq!(elastic.poisson, nu);
        let e = [1e-7, -2e-7, 3e-7, 4e-7, -1e-7, 2e-7];
        let mut cube = Cube::new(&law);
        cube.step(e, 1.0);
        let (g, lame) = (elastic.shear_modulus(), elastic.lame());
        for c in 0..6 {
            let exact = if c < 3 { 2.0 * g * e[c] + lame * (e[0] + e[1] + e[2]) } else { g * e[c] };
            let got = cube.state[c];
            assert!((got - exact).abs() < 2e-5 * g * 1e-7 * 10.0, "{} {c}: {got} {exact}", law.law);
        }
        // The energies of the bound: uniaxial strain.
        let mut cube = Cube::new(&law);
        cube.step([1e-6, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        assert!((cube.state[0] / 1e-6 / (lame + 2.0 * g) - 1.0).abs() < 1e-4, "{}", law.law);
        assert!(cube.at("stiffening") < 1e-4);
    }
}

/// A closed path of large strain gives no energy: the work is zero within the second order of the
/// step, and the stress vanishes where the path began.
#[test]
fn a_closed_path_leaves_nothing() {
    for mut law in closed().into_iter().map(|closed| closed.law).chain(others()) {
        law.parameters.entry("poisson".into()).and_modify(|nu| *nu = Param::Number(0.45));
        let mut cube = Cube::new(&law);
        let mut noise = Noise(7);
        let path: Vec<[f64; 6]> =
            (0..4).map(|_| std::array::from_fn(|_| 1e-3 * noise.next())).collect();
        let mut most = 0.0f64;
        for e in &path {
            for _ in 0..200 {
                cube.step(*e, 1.0);
                most = most.max(cube.work);
            }
        }
        for e in path.iter().rev() {
            (0..200).for_each(|_| _ = cube.step(e.map(|e| -e), 1.0));
        }
        let left = cube.state[..6].iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        assert!(most > 1e-2 && cube.work.abs() < 1e-9 * most, "{} {} {most}", law.law, cube.work);
        assert!(left < 1e-11, "{}: {left}", law.law);
    }
}

/// The stiffening bounds the modulus of waves: of a small stretch along an axis, at any
/// deformation.
#[test]
fn stiffening_bounds_the_modulus_of_waves() {
    for mut law in closed().into_iter().map(|closed| closed.law).chain(others()) {
        law.parameters.entry("poisson".into()).and_modify(|nu| *nu = Param::Number(0.45));
        let elastic = super::super::build_solid(&law).expect("a law").elastic();
        let first = elastic.lame() + 2.0 * elastic.shear_modulus();
        for [x, y, z] in [
            [1.2, -0.5, -0.6],
            [-0.9, 0.4, 0.4],
            [-0.2, -0.2, -0.2],
            [0.8, 0.8, -1.5],
            [-0.5, -0.5, -0.5],
            [0.3, 0.3, 0.3],
            [1.5, -0.75, -0.75],
        ] {
            let mut cube = Cube::new(&law);
            (0..300).for_each(|_| _ = cube.step([x, y, z, 0.0, 0.0, 0.0].map(|e| e / 300.0), 1.0));
            let bound = first * (1.0 + cube.at("stiffening"));
            for axis in 0..3 {
                let mut next = cube.clone();
                let mut e = [0.0; 6];
                e[axis] = 1e-6;
                next.step(e, 1.0);
                // d sigma + sigma d ln J - 2 sigma + sigma: the wave modulus of the present state.
                let modulus = (next.state[axis] - cube.state[axis]) / 1e-6;
                assert!(modulus < 1.001 * bound, "{} {axis}: {modulus} {bound}", law.law);
                assert!(bound < 12.0 * first.max(modulus), "{}: a useless bound {bound}", law.law);
            }
            // All directions at once: three times the bulk modulus.
            let mut next = cube.clone();
            next.step([1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0], 1.0);
            let sum = |cube: &Cube| cube.state[..3].iter().sum::<f64>();
            let modulus = (sum(&next) - sum(&cube)) / 3e-6 + 2.0 / 3.0 * sum(&cube);
            let bound = 3.0 * elastic.bulk_modulus() * (1.0 + cube.at("stiffening"));
            assert!(modulus < 1.001 * bound, "{} volume: {modulus} {bound}", law.law);
        }
    }
}

/// Tension on all sides gives tension, at the smallest Poisson's ratio that is accepted.
#[test]
fn tension_on_all_sides_is_tension() {
    let numbers = [("a", 0.3), ("b", 0.1), ("poisson", 0.4231)];
    let mut cube = Cube::new(&material("mooney_rivlin", &numbers, &[]));
    for step in 0..1000 {
        cube.step([1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0], 1.0);
        assert!(cube.state[0] > 0.0, "{step}: {}", cube.state[0]);
    }
}

/// Each wrong parameter has an error that names it.
#[test]
fn wrong_rubbers_are_refused() {
    let nu = ("poisson", 0.49);
    for (law, words) in [
        (material("mooney_rivlin", &[("a", 0.0), ("b", 0.0), nu], &[]), "shear modulus 0"),
        (material("mooney_rivlin", &[("a", 1.0), ("b", 0.0), ("poisson", 0.5)], &[]), "below 0.5"),
        (material("mooney_rivlin", &[("a", 1.0), ("b", 0.0), ("poisson", 0.39)], &[]), "0.4000"),
        (material("mooney_rivlin", &[("a", 0.0), ("b", 1.0), ("poisson", 0.45)], &[]), "0.4545"),
        (material("ogden", &[nu], &[("terms", table(&[[1.0, -2.0]]))]), "mu alpha"),
        (material("ogden", &[nu], &[]), "terms is missing"),
        (
            material("polynomial_rubber", &[nu], &[("coefficients", Param::List(vec![1.0]))]),
            "six numbers",
        ),
        (
            material(
                "polynomial_rubber",
                &[nu],
                &[("coefficients", Param::List(vec![1.0, 0.0, 0.0, -0.3, 0.0, 0.0]))],
            ),
            "keep the sign of the strain",
        ),
        (material("blatz_ko", &[("shear_modulus", -1.0)], &[]), "above 0"),
    ] {
        let text = problems(&law);
        assert!(text.contains(words), "{words}: {text}");
    }
    let law = material("blatz_ko", &[("shear_modulus", 1.0)], &[]);
    let text = format!("{:?}", super::super::build(&law).err());
    assert!(text.contains("for solids only") && text.contains("johnson_cook"), "{text}");
}
