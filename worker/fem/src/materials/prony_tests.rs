//! Tests of linear viscoelasticity with series of decays.

use crate::elements::testing::Noise;
use crate::materials::testing::{Cube, Sheet, material, problems, table};
use crumple_proto::partition::Material;

/// Moduli in GPa, rates in 1/ms: three shear terms with one that stays, and two bulk terms.
const SHEAR: [[f64; 2]; 3] = [[0.1, 0.0], [0.3, 0.5], [0.2, 40.0]];
const BULK: f64 = 1.5;
const BULK_TERMS: [[f64; 2]; 2] = [[0.4, 0.3], [0.1, 5.0]];

fn polymer() -> Material {
    let terms = [("shear_terms", table(&SHEAR)), ("bulk_terms", table(&BULK_TERMS))];
    material("general_viscoelastic", &[("bulk_modulus", BULK)], &terms)
}

/// Returns the integral of `sum M_k exp(-b_k (t - tau))` over tau from 0 to `ramp`, at a time.
fn convolved(terms: &[[f64; 2]], time: f64, ramp: f64) -> f64 {
    let loaded = time.min(ramp);
    let since = time - loaded;
    let of_term = |&[modulus, rate]: &[f64; 2]| match rate {
        0.0 => modulus * loaded,
        _ => modulus * ((-rate * since).exp() - (-rate * time).exp()) / rate,
    };
    terms.iter().map(of_term).sum()
}

/// Shear and a change of volume at constant rates for a time, then held: the stress is the
/// integral of the series, for any steps (rounding).
#[test]
fn stress_is_the_convolution_with_the_series() {
    let (rate, ramp) = (2e-3, 3.0);
    let mut cube = Cube::new(&polymer());
    let mut sheet = Sheet::new(&polymer());
    let bulk: Vec<[f64; 2]> = [[BULK, 0.0]].into_iter().chain(BULK_TERMS).collect();
    let mut time = 0.0;
    for step in 0..60 {
        let dt = if step % 2 == 0 { 0.05 } else { 0.15 };
        let e = if step < 30 { rate * dt } else { 0.0 };
        cube.step([-e, -e, -e, 0.0, e, 0.0], dt);
        sheet.step([0.0, 0.0, e], dt);
        time += dt;
        let sheared = rate * convolved(&SHEAR, time, ramp);
        let pressed = -3.0 * rate * convolved(&bulk, time, ramp);
        for (name, got, exact) in [
            ("shear of the cube", cube.state[4], sheared),
            ("shear of the sheet", sheet.state[2], sheared),
            ("mean stress", cube.state[0], pressed),
        ] {
            assert!((got / exact - 1.0).abs() < 1e-12, "{name} at {time}: {got} for {exact}");
        }
    }
}

/// One term and a part that stays are the law with one decay, in both forms (rounding).
#[test]
fn one_term_is_the_law_with_one_decay() {
    let [bulk, fast, slow, decay] = [2.0, 0.6, 0.1, 0.5];
    let numbers = [
        ("youngs_modulus", 9.0 * bulk * fast / (3.0 * bulk + fast)),
        ("poisson", (3.0 * bulk - 2.0 * fast) / (2.0 * (3.0 * bulk + fast))),
        ("long_term_shear_modulus", slow),
        ("decay_rate", decay),
    ];
    let one = material("viscoelastic", &numbers, &[]);
    let terms = [("shear_terms", table(&[[fast - slow, decay], [slow, 0.0]]))];
    let series = material("general_viscoelastic", &[("bulk_modulus", bulk)], &terms);
    let mut noise = Noise(3);
    let [mut a, mut b] = [&one, &series].map(Cube::new);
    let [mut c, mut d] = [&one, &series].map(Sheet::new);
    for _ in 0..200 {
        let strain: [f64; 6] = std::array::from_fn(|_| 1e-3 * noise.next());
        let dt = 0.1 * (1.5 + noise.next());
        a.step(strain, dt);
        b.step(strain, dt);
        c.step([strain[0], strain[1], strain[3]], dt);
        d.step([strain[0], strain[1], strain[3]], dt);
        assert!((0..6).all(|k| (a.state[k] - b.state[k]).abs() < 1e-13));
        assert!((0..3).all(|k| (c.state[k] - d.state[k]).abs() < 1e-13));
        assert!((c.strain[3] - d.strain[3]).abs() < 1e-13);
    }
}

/// A sheet is a cube whose sides have no stress, also where the bulk modulus relaxes.
#[test]
fn a_sheet_is_a_cube_with_free_sides() {
    let (mut cube, mut sheet) = (Cube::new(&polymer()), Sheet::new(&polymer()));
    for step in 0..50 {
        let eps = if step < 20 { 1e-3 } else { -2e-4 };
        cube.pull([eps, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 0.1);
        sheet.pull(eps, 0.1);
        let (got, exact) = (sheet.state[0], cube.state[0]);
        assert!((got - exact).abs() < 1e-9 * exact.abs() + 1e-14, "{got} for {exact}");
        assert!((sheet.strain[3] - sheet.strain[1]).abs() < 1e-12, "the sides are alike");
    }
}

/// Random paths from a stress of zero cost work, except for the rule of the trapezoid in a step:
/// the cube of its part of the shortest time of relaxation, 0.04, over 72.
#[test]
fn random_paths_give_no_energy() {
    let mut noise = Noise(17);
    for path in 0..50 {
        let (mut cube, mut sheet) = (Cube::new(&polymer()), Sheet::new(&polymer()));
        let mut work = 0.0;
        for step in 0..200 {
            // The same scale of strains in the end as at the start, so that the volume is one.
            let strain: [f64; 6] = std::array::from_fn(|_| 1e-6 * noise.next());
            let dt = 10f64.powf(noise.next() - 4.0);
            cube.step(strain, dt);
            let before: [f64; 3] = std::array::from_fn(|c| sheet.state[c]);
            let plane = [strain[0], strain[1], strain[3]];
            sheet.step(plane, dt);
            work += (0..3).map(|c| 0.5 * (before[c] + sheet.state[c]) * plane[c]).sum::<f64>();
            let least = -1e-6 * (1e-6f64).powi(2);
            assert!(cube.work > least && work > least, "{path}, {step}: {} {work}", cube.work);
        }
    }
}

#[test]
fn bad_series_are_refused_all_at_once() {
    let terms = [("shear_terms", table(&[[0.0, 1.0]])), ("bulk_terms", table(&[[1.0, -1.0]]))];
    let text = problems(&material("general_viscoelastic", &[("bulk_modulus", -1.0)], &terms));
    for part in ["bulk_modulus is -1", "no modulus above 0", "bulk_terms has a number below 0"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let many: Vec<[f64; 2]> = (0..20).map(|k| [1.0, 1.0 + f64::from(k)]).collect();
    let terms = [("shear_terms", table(&many))];
    let text = problems(&material("general_viscoelastic", &[("bulk_modulus", 1.0)], &terms));
    assert!(text.contains("20 terms that decay") && text.contains("18 at most"), "{text}");
}
