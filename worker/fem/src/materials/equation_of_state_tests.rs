//! Pressures against their formulas, adiabats and the Hugoniot in closed form. Copper in mm, ms,
//! kg, GPa: rho 8.93e-6 kg/mm^3, c 3940 mm/ms, s1 1.489, gamma 2.02 (Steinberg 1996).

use crate::materials::testing::{Cube, material, problems};
use crumple_proto::partition::{Material, Param};

const DENSITY: f64 = 8.93e-6;
const C: f64 = 3940.0;
const S: f64 = 1.489;
const GAMMA: f64 = 2.02;
const A: f64 = 0.47;

/// A material with very little strength and one of these equations.
fn copper(key: &str, constants: [f64; 6], more: &[(&str, Param)]) -> Material {
    let numbers = [("youngs_modulus", 1e-3), ("poisson", 0.3), ("yield_stress", 1e-9)];
    let list = [(key, Param::List(constants.to_vec()))];
    let mut law = material("j2", &numbers, &[&list, more].concat());
    law.density = DENSITY;
    law
}

fn gruneisen() -> Material {
    copper("eos_gruneisen", [C, S, 0.0, 0.0, GAMMA, A], &[])
}

fn pressure(cube: &Cube) -> f64 {
    -cube.state[..3].iter().sum::<f64>() / 3.0
}

/// Compresses on all sides to a ratio of volumes.
fn compress(cube: &mut Cube, volume: f64, steps: usize) {
    let each = (volume.ln() - cube.strain[..3].iter().sum::<f64>()) / (3 * steps) as f64;
    (0..steps).for_each(|_| _ = cube.step([each, each, each, 0.0, 0.0, 0.0], 1.0));
}

/// Along an adiabat the energy per volume at the start is the work of the pressure, and both agree
/// with the equation, which is integrated here by Runge and Kutta's rule of fourth order.
#[test]
fn an_adiabat_is_that_of_the_equation() {
    let of_gruneisen = |mu: f64, e: f64| {
        let d = 1.0 - (S - 1.0) * mu;
        let n = mu * (1.0 + (1.0 - 0.5 * GAMMA) * mu - 0.5 * A * mu * mu);
        let cold = DENSITY * C * C * if mu > 0.0 { n / (d * d) } else { mu };
        cold + (GAMMA + A * mu) * e
    };
    let c = [140.0, 280.0, 560.0, 1.9, 0.6, 0.3];
    let of_polynomial = |mu: f64, e: f64| {
        let [c2, c6] = if mu > 0.0 { [c[1], c[5]] } else { [0.0; 2] };
        c[0] * mu + c2 * mu * mu + c[2] * mu.powi(3) + (c[3] + c[4] * mu + c6 * mu * mu) * e
    };
    type Of<'a> = &'a dyn Fn(f64, f64) -> f64;
    let cases: [(Material, Of<'_>); 2] =
        [(gruneisen(), &of_gruneisen), (copper("eos_polynomial", c, &[]), &of_polynomial)];
    for (law, of) in cases {
        for volume in [0.7, 1.05] {
            let mut cube = Cube::new(&law);
            compress(&mut cube, volume, 4000);
            let slope = |v: f64, e: f64| -of(1.0 / v - 1.0, e);
            let (steps, mut e) = (2000, 0.0);
            let h = (volume - 1.0) / steps as f64;
            for step in 0..steps {
                let v = 1.0 + h * step as f64;
                let k1 = slope(v, e);
                let k2 = slope(v + 0.5 * h, e + 0.5 * h * k1);
                let k3 = slope(v + 0.5 * h, e + 0.5 * h * k2);
                let k4 = slope(v + h, e + h * k3);
                e += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            }
            let exact = of(1.0 / volume - 1.0, e);
            let got = (pressure(&cube), cube.at("eos energy"));
            assert!((got.0 - exact).abs() < 1e-5 * exact.abs(), "V {volume}: {got:?}, {exact}");
            assert!((got.1 - e).abs() < 1e-5 * e.abs(), "V {volume}: {got:?}, {e}");
            assert!((cube.work - e).abs() < 1e-5 * e.abs(), "work {} for {e}", cube.work);
        }
    }
}

/// A jump in one step, with the mean of both pressures as that of the work, obeys the energy
/// equation of Rankine and Hugoniot. So it ends on the Hugoniot that the constants stand for,
/// `p = rho c^2 eta/(1 - s eta)^2` with `eta = 1 - V`.
#[test]
fn a_jump_ends_on_the_hugoniot() {
    for eta in [0.01, 0.1, 0.25] {
        let mut law = gruneisen();
        // The relation between the constants and U_s = c + s u holds for the plain form.
        law.parameters
            .insert("eos_gruneisen".into(), Param::List(vec![C, S, 0.0, 0.0, GAMMA, 0.0]));
        let mut cube = Cube::new(&law);
        cube.step([(1.0f64 - eta).ln(), 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        let exact = DENSITY * C * C * eta / (1.0 - S * eta).powi(2);
        let got = pressure(&cube);
        assert!((got - exact).abs() < 1e-7 * exact, "eta {eta}: {got} for {exact}");
        let energy = 0.5 * exact * eta;
        assert!((cube.at("eos energy") - energy).abs() < 1e-7 * energy);
    }
}

/// The law keeps its deviator: with strength, yield in uniaxial strain is as without the equation,
/// and the heat of plastic work raises the pressure by Gruneisen's coefficient.
#[test]
fn strength_is_that_of_the_law() {
    let numbers = [("youngs_modulus", 125.0), ("poisson", 0.34), ("yield_stress", 0.5)];
    let list = [("eos_gruneisen", Param::List(vec![C, S, 0.0, 0.0, GAMMA, 0.0]))];
    let mut law = material("j2", &numbers, &list);
    law.density = DENSITY;
    let mut cube = Cube::new(&law);
    (0..400).for_each(|_| _ = cube.step([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], 1.0));
    assert!((cube.von_mises() - 0.5).abs() < 1e-9, "{}", cube.von_mises());
    // Volume is constant: all work is energy, elastic and plastic.
    assert!((cube.at("eos energy") - cube.work).abs() < 1e-9);
    assert!((pressure(&cube) - GAMMA * cube.work).abs() < 1e-9 * cube.work, "{}", pressure(&cube));
}

/// The stiffening bounds the modulus of waves in compression, and is not twice too large.
#[test]
fn stiffening_is_that_of_the_adiabat() {
    for law in [gruneisen(), copper("eos_polynomial", [140.0, 280.0, 560.0, 1.9, 0.6, 0.3], &[])] {
        let mut cube = Cube::new(&law);
        let first = crate::materials::build_solid(&law).expect("a law").elastic();
        let bulk = first.lame() + 2.0 * first.shear_modulus();
        for volume in [0.99, 0.9, 0.8, 0.7] {
            compress(&mut cube, volume, 1000);
            let mut next = cube.clone();
            next.step([1e-7, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
            let modulus = (next.state[0] - cube.state[0]) / 1e-7;
            let bound = bulk * (1.0 + cube.at("stiffening"));
            assert!((modulus / bound - 1.0).abs() < 1e-3, "V {volume}: {modulus} {bound}");
        }
        assert!(cube.at("stiffening") > 1.0);
    }
}

/// The pressure does not fall below its limit, and a failed point has none.
#[test]
fn tension_is_cut_off() {
    let more = [("eos_min_pressure", Param::Number(-1.5))];
    let mut cube = Cube::new(&copper("eos_gruneisen", [C, S, 0.0, 0.0, GAMMA, A], &more));
    compress(&mut cube, 1.1, 200);
    assert!((pressure(&cube) + 1.5).abs() < 1e-12);
    let more = [("erosion_min_pressure", Param::Number(-1.5))];
    let mut cube = Cube::new(&copper("eos_gruneisen", [C, S, 0.0, 0.0, GAMMA, A], &more));
    compress(&mut cube, 1.1, 200);
    assert!(cube.at("failed") == 1.0 && cube.state[..6].iter().all(|s| *s == 0.0));
}

/// Compression beyond the pole of the Hugoniot has no finite pressure, so that the run stops.
#[test]
fn beyond_the_pole_there_is_no_pressure() {
    // A cut-off must not hide it, nor the sign of the numerator, negative here with gamma 3.
    for (gamma, more) in [(GAMMA, None), (3.0, Some(("eos_min_pressure", Param::Number(-1.0))))] {
        let more: Vec<_> = more.into_iter().collect();
        let mut cube = Cube::new(&copper("eos_gruneisen", [C, S, 0.0, 0.0, gamma, A], &more));
        cube.step([(0.2f64).ln(), 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
        assert!(!cube.state[0].is_finite(), "{:?}", cube.state);
    }
}

#[test]
fn wrong_constants_are_refused() {
    let list = |numbers: &[f64]| Param::List(numbers.to_vec());
    let all = [1.0, 1.5, 0.0, 0.0, 2.0, 0.0];
    for (more, words) in [
        (vec![("eos_gruneisen", list(&all[..4]))], "six numbers"),
        (vec![("eos_polynomial", list(&[0.0; 6]))], "the first above 0"),
        (vec![("eos_gruneisen", list(&all)), ("eos_polynomial", list(&all))], "only one of them"),
        (vec![("eos_min_pressure", Param::Number(-1.0))], "without an equation of state"),
        (vec![("eos_gruneisen", list(&all)), ("eos_min_pressure", Param::Number(1.0))], "or below"),
        (vec![("eos_gruneisen", list(&all))], "for solids"),
    ] {
        let numbers = [("youngs_modulus", 1.0), ("poisson", 0.3), ("yield_stress", 1.0)];
        let text = problems(&material("j2", &numbers, &more));
        assert!(text.contains(words), "{text}");
    }
    let rubber = material("blatz_ko", &[("shear_modulus", 1.0)], &[("eos_gruneisen", list(&all))]);
    assert!(problems(&rubber).contains("a pressure of its own"));
}
