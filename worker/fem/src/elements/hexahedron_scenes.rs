//! Hexahedra in motion: large strain, stability, frequencies, bending, incompressibility. The names
//! are those of the verification catalogue.

use super::super::solid_testing::*;
use super::super::testing::*;
use super::*;
use crate::materials::Elastic;

const E: f64 = 210.0;
const NU: f64 = 0.3;
const G: f64 = 0.5 * E / (1.0 + NU);

fn cube(material: crumple_proto::partition::Material) -> Solids {
    let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
    Solids::new(solid_part(HourglassForm::Stiffness, None), material, &nodes, &cells)
}

/// A26 (a): uniaxial strain gives (lambda + 2 mu) ln(stretch).
#[test]
fn uniaxial_strain_is_logarithmic() {
    let mut solids = cube(elastic(E, NU, 1.0));
    for (stretch, wanted, digit) in [(0.9, -29.78, 0.01), (0.5, -195.9, 0.1), (0.1, -650.9, 0.1)] {
        let from = solids.x[7][2];
        let factor = (stretch / from).powf(1.0 / 1000.0);
        (0..1000).for_each(|_| _ = solids.go(|x| [x[0], x[1], factor * x[2]]));
        let stress = solids.fields(0).stress[2];
        assert_close(stress, wanted, 0.51 * digit, "half of the catalogue's last digit");
        let exact = (E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))) * f64::ln(stretch);
        assert_close(stress, exact, 1e-5 * exact.abs(), "third order in steps of at most 1.6e-3");
    }
}

/// A26 (b): simple shear under Jaumann's rate gives sin and 1 - cos.
#[test]
fn simple_shear_is_that_of_jaumann() {
    let error = |steps: u32| {
        let mut solids = cube(elastic(E, NU, 1.0));
        let mut worst = 0.0_f64;
        for step in 1..=4 * steps {
            let by = 1.0 / f64::from(steps);
            solids.go(|x| [x[0] + by * x[2], x[1], x[2]]);
            let gamma = f64::from(step) * by;
            let stress = solids.fields(0).stress;
            worst = worst
                .max((stress[5] / G - gamma.sin()).abs())
                .max((stress[0] / G - (1.0 - gamma.cos())).abs());
        }
        worst
    };
    let (coarse, fine) = (error(25), error(250));
    assert!(
        fine < 1e-3 / 16.0,
        "the catalogue requires 1e-3 with 1000 steps to gamma = 4: {fine:e}"
    );
    assert!(coarse > 80.0 * fine && coarse < 120.0 * fine, "second order: {coarse:e} and {fine:e}");
}

/// A26 (c): isochoric compression to half the height gives no pressure, and yields at sigma_y/sqrt
/// 3.
#[test]
fn isochoric_squash_makes_no_pressure() {
    let yields = 0.8;
    let mut solids = cube(material(
        "j2",
        1.0,
        &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", yields)],
    ));
    let factor = 0.5_f64.powf(1.0 / 500.0);
    (0..500).for_each(|_| _ = solids.go(|x| [x[0] / factor, x[1], x[2] * factor]));
    let s = solids.fields(0).stress;
    assert!((s[0] + s[1] + s[2]).abs() < 3e-9, "the catalogue's bound: {s:?}");
    assert_close(s[2], -yields / 3.0_f64.sqrt(), 1e-9, "return to the surface, exactly");
}

/// In steady flow the resistance of an hourglass mode is that of a fluid of viscosity
/// `sig_y/(3 d eps_p/dt)`: the stress that varies over the element is `E/(1-nu^2) e` for elastic
/// steps e, of which `sig_y/(3 G d eps_p)` remains. Unloading is elastic.
#[test]
fn flow_bounds_what_hourglass_modes_store() {
    let (yields, rate, ratio) = (0.2, 1e-4, 0.5);
    let mut solids = cube(material(
        "j2",
        1.0,
        &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", yields)],
    ));
    let part = solid_part(HourglassForm::AssumedStrain, None);
    let soft =
        material("j2", 1.0, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", yields)]);
    let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
    let mut assumed = Solids::new(part, soft, &nodes, &cells);
    let stretch = |solids: &mut Solids, rate: f64| {
        for (v, x) in solids.v.iter_mut().zip(&nodes) {
            let bent = 0.5 * ratio * rate * (2.0 * x[0] - 1.0) * (2.0 * x[1] - 1.0);
            *v = [bent - 0.5 * rate * x[0], -0.5 * rate * x[1], rate * x[2], 0.0];
        }
        solids.step(1.0)
    };
    let mut kept = Vec::new();
    for _ in 0..200 {
        stretch(&mut solids, rate);
        stretch(&mut assumed, rate);
        kept.push(
            assumed.history.element(0).at(assumed.element.columns() - hourglass::COLUMNS + 4),
        );
    }
    let bound = E / (1.0 - NU * NU) * ratio * yields / (3.0 * G);
    assert_close(kept[199], bound, 0.03 * bound, "a strain of 2 %");
    assert_close(kept[199], kept[99], 0.02 * bound, "steady except for the change of shape");
    // P of mode xi eta: (kappa/16) (lambda + 2 mu) V (B_iI B_iI) dq: B_iI B_iI is 1.5 on the unit
    // cube, dq the sum of 8 corners.
    let modulus = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU));
    let bound = 0.05 / 16.0 * modulus * 1.5 * 4.0 * ratio * yields / (3.0 * G);
    let p = solids.history.element(0).at(solids.element.columns() - hourglass::COLUMNS + 6);
    assert_close(p, bound, 0.03 * bound, "a strain of 2 %");
    // Backwards: the first step is elastic.
    let before = kept[199];
    stretch(&mut assumed, -0.1 * rate);
    let after = assumed.history.element(0).at(assumed.element.columns() - hourglass::COLUMNS + 4);
    let wanted = E / (1.0 - NU * NU) * ratio * 0.1 * rate;
    assert_close(before - after, wanted, 0.03 * wanted, "a strain of 2 %");
}

/// Returns the largest velocity after 1000 steps over that at the start.
fn growth(form: HourglassForm, nodes: &[[f64; 3]], cells: &[[u32; 8]], nu: f64, dt: f64) -> f64 {
    let part = solid_part(form, Some(0.05));
    let mut solids = Solids::new(part, elastic(1.0, nu, 1.0), nodes, cells);
    let masses = solids.masses();
    let mut noise = Noise(4);
    solids.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = 1e-9 * noise.next()));
    for _ in 0..1000 {
        solids.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| {});
        let largest = solids.v.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        if largest.is_nan() || largest > 1e-4 {
            break;
        }
    }
    solids.v.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs())) / 1e-9
}

/// A23 (b): stable just below the true limit, not just above; the element's own step is slightly
/// below it.
#[test]
fn the_stable_step_is_below_the_limit_and_near_it() {
    // Elements, size of one, Poisson's ratio, the limit in L/c_d, smallest ratio of the element's
    // own step to the limit.
    let cases = [
        ([1, 1, 1], [1.0, 1.0, 1.0], 0.0, 1.0, 0.999),
        ([1, 1, 1], [1.0, 1.0, 1.0], 0.3, 0.734, 0.999),
        ([1, 1, 1], [1.0, 1.0, 1.0], 0.45, 0.616, 0.999),
        ([1, 1, 1], [1.0, 1.0, 1.0], 0.49, 0.585, 0.999),
        ([1, 1, 1], [1.0, 1.0, 0.1], 0.3, 0.0998, 0.98),
        ([1, 1, 1], [1.0, 0.1, 0.1], 0.3, 0.0836, 0.93),
        ([2, 2, 2], [1.0, 1.0, 1.0], 0.3, 0.939, 0.7),
        ([8, 1, 1], [1.0, 1.0, 1.0], 0.3, 0.811, 0.7),
    ];
    for (n, size, nu, limit, near) in cases {
        let (nodes, cells) = block(n, std::array::from_fn(|i| size[i] * n[i] as f64));
        let c_d = elastic_of(nu).dilatational_wave_speed();
        let wanted = limit / c_d;
        let own = Solids::new(
            solid_part(HourglassForm::Stiffness, None),
            elastic(1.0, nu, 1.0),
            &nodes,
            &cells,
        );
        let own = own.stable_dt();
        // The catalogue gives three digits.
        assert!(
            own < 1.002 * wanted && own > near * 0.998 * wanted,
            "{n:?} {size:?} nu {nu}: {own} of {wanted}"
        );
        // Hourglass modes are slower than the modes that determine the step, also in the default
        // form.
        for form in [HourglassForm::Stiffness, HourglassForm::AssumedStrain] {
            let grown = |share: f64| growth(form, &nodes, &cells, nu, share * wanted);
            let (below, above) = (grown(0.98), grown(1.02));
            assert!(below < 100.0, "{form:?} {n:?} {size:?} nu {nu}: grew by {below:e} at 0.98");
            assert!(above > 1e4, "{form:?} {n:?} {size:?} nu {nu}: grew by {above:e} only at 1.02");
        }
    }
}

fn elastic_of(nu: f64) -> Elastic {
    Elastic { youngs_modulus: 1.0, poisson: nu, density: 1.0 }
}

/// Bulk viscosity lowers the step so that it stays stable.
#[test]
fn bulk_viscosity_damps_and_stays_stable() {
    let (nodes, cells) = block([2, 2, 2], [2.0; 3]);
    let part = solid_part(HourglassForm::Stiffness, None).with("bulk_viscosity", [0.5, 1.5]);
    let mut solids = Solids::new(part, elastic(1.0, NU, 1.0), &nodes, &cells);
    let plain = Solids::new(
        solid_part(HourglassForm::Stiffness, None),
        elastic(1.0, NU, 1.0),
        &nodes,
        &cells,
    );
    let (dt, masses) = (solids.stable_dt(), solids.masses());
    assert_close(dt / plain.stable_dt(), 1.25_f64.sqrt() - 0.5, 1e-12, "round-off");
    // Breathing mode: pure compression half of the time.
    solids
        .v
        .iter_mut()
        .zip(&nodes)
        .for_each(|(v, x)| (0..3).for_each(|i| v[i] = 1e-3 * (1.0 - x[i])));
    let kinetic = |solids: &Solids| -> f64 {
        solids
            .v
            .iter()
            .zip(&masses)
            .map(|(v, (m, _))| 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]))
            .sum()
    };
    let (start, mut booked) = (kinetic(&solids), 0.0);
    for _ in 0..3000 {
        let totals = solids.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| {});
        booked += totals.internal + totals.hourglass;
    }
    let end = kinetic(&solids);
    assert!(end < 0.2 * start, "damped: {end} of {start}");
    assert!(booked > 0.7 * start && booked < 1.02 * start, "in the ledger: {booked} of {start}");
}

/// C10 (a): a single mode has the frequency sqrt(6 kappa) c_d/L; viscous resistance dissipates its
/// energy.
#[test]
fn an_hourglass_mode_has_its_frequency() {
    let (l, speed) = (10.0, 1e-6);
    let (nodes, cells) = block([1, 1, 1], [l; 3]);
    let steel = Elastic { youngs_modulus: E, poisson: NU, density: 7.85e-6 };
    let omega = 0.3_f64.sqrt() * steel.dilatational_wave_speed() / l;
    let dt = 0.01 / omega;
    let run = |form| {
        let mut solids =
            Solids::new(solid_part(form, Some(0.05)), elastic(E, NU, 7.85e-6), &nodes, &cells);
        let masses = solids.masses();
        let mode = |x: [f64; 3]| if (x[0] > 0.0) == (x[1] > 0.0) { speed } else { -speed };
        solids.v.iter_mut().zip(&nodes).for_each(|(v, &x)| v[2] = mode(x));
        let mut largest = 0.0_f64;
        for _ in 0..158 {
            solids.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| {});
            largest = largest.max((solids.x[0][2] - nodes[0][2]).abs());
        }
        (largest, solids.v[0][2])
    };
    let (largest, end) = run(HourglassForm::Stiffness);
    assert_close(largest * omega / speed, 1.0, 0.01, "half a step of 0.01 at the start");
    assert!(end.abs() < 0.02 * speed, "a quarter period is 157 steps: {end:e}");
    let (_, end) = run(HourglassForm::Viscous);
    // Critical damping is that of kappa = 1: rate 2 r sqrt(6) c_d/L.
    let wanted = (-2.0 * 0.05 * (1.0 / 0.05_f64).sqrt() * 1.58).exp();
    assert_close(end / speed, wanted, 0.01 * wanted, "steps of 0.01");
}

/// Returns the first bending frequency of a cantilever of L/h = 10 and cubes, nu = 0, over that of
/// Euler and Bernoulli.
fn cantilever(form: HourglassForm, kappa: Option<f64>, n: usize, nu: f64) -> f64 {
    let length = 10.0;
    let (nodes, cells) = block([10 * n, n, n], [length, 1.0, 1.0]);
    let mut solids = Solids::new(solid_part(form, kappa), elastic(1.0, nu, 1.0), &nodes, &cells);
    let masses = solids.masses();
    // Free vibration from its own shape (Blevins 1979, table 8-1).
    let (beta, sigma) = (1.875104068711961 / length, 0.734095513754);
    let shape = |x: f64| {
        (beta * x).cosh() - (beta * x).cos() - sigma * ((beta * x).sinh() - (beta * x).sin())
    };
    let slope = |x: f64| {
        beta * ((beta * x).sinh() + (beta * x).sin()
            - sigma * ((beta * x).cosh() - (beta * x).cos()))
    };
    for (v, x) in solids.v.iter_mut().zip(&nodes) {
        (v[0], v[2]) = (-1e-7 * (x[2] - 0.5) * slope(x[0]), 1e-7 * shape(x[0]));
    }
    let dt = 0.9 * solids.stable_dt();
    let tip = 10 * n;
    let mut crossings = Vec::new();
    let mut time = 0.5 * dt;
    // From one end of the first half to the end of the third: one period.
    while crossings.len() < 3 {
        let before = solids.x[tip][2];
        let fix = |node: usize, v: &mut [f64; 4], _: &mut [f64; 4]| {
            if nodes[node][0] == 0.0 {
                *v = [0.0; 4]
            }
        };
        solids.explicit(dt, &masses, |_| [0.0; 3], fix);
        time += dt;
        let now = solids.x[tip][2];
        if time > 2.0 * dt && (before > 0.0) != (now > 0.0) {
            crossings.push(time - dt * now / (now - before));
        }
    }
    let bernoulli = beta * beta * (1.0 / 12.0_f64).sqrt();
    std::f64::consts::TAU / (crossings[2] - crossings[0]) / bernoulli
}

/// A15: the table of one-point hexahedra with stiffness control, f over that of Euler and
/// Bernoulli.
#[test]
fn cantilevers_have_the_frequencies_of_the_table() {
    let table = [
        (0.05, 1, 0.470),
        (0.05, 2, 0.892),
        (0.1, 1, 0.664),
        (0.1, 2, 0.922),
        (0.01, 1, 0.210),
        (0.01, 2, 0.867),
    ];
    for (kappa, n, wanted) in table {
        let f = cantilever(HourglassForm::Stiffness, Some(kappa), n, 0.0);
        assert_close(
            f,
            wanted,
            0.005 * wanted,
            "the catalogue requires 0.5 %: this checks the formula itself",
        );
    }
}

/// A15 with assumed strain: one element through the thickness bends as a beam does.
#[test]
fn assumed_strain_bends_without_a_coefficient() {
    for (n, nu) in [(1, 0.0), (2, 0.0), (1, 0.3), (2, 0.3)] {
        let f = cantilever(HourglassForm::AssumedStrain, None, n, nu);
        // At L/h = 10 shear and rotary inertia lower the frequency by 1 % relative to Euler and
        // Bernoulli; the clamped end suppresses Poisson's strain.
        assert_close(f, 0.99, 0.02, "ten elements long");
    }
}

/// Returns u_r(a) at rest of a thick cylinder in plane strain under inner pressure (C12).
fn cylinder(form: HourglassForm, nu: f64) -> f64 {
    let (a, b, pressure, radial, around) = (10.0, 20.0, 0.01, 6, 10);
    let quarter = std::f64::consts::FRAC_PI_2;
    let (flat, cells) = block([radial, around, 1], [1.0, 1.0, 1.0]);
    let polar = |x: &[f64; 3]| {
        let (r, phi) = (a + (b - a) * x[0], quarter * x[1]);
        [r * phi.cos(), r * phi.sin(), x[2]]
    };
    let nodes: Vec<_> = flat.iter().map(polar).collect();
    let mut solids = Solids::new(solid_part(form, None), elastic(E, nu, 1.0), &nodes, &cells);
    let masses = solids.masses();
    let dt = 0.9 * solids.stable_dt();
    // The force on the chord is pressure times its length, along its normal, a quarter at each
    // corner of the face.
    let chord = 2.0 * a * (0.5 * quarter / around as f64).sin();
    let along = |node: usize| -> [f64; 3] {
        if flat[node][0] > 0.0 {
            return [0.0; 3];
        }
        let quarter_force = 0.25 * pressure * chord;
        let mut force = [0.0; 3];
        for side in [-0.5, 0.5] {
            let at = flat[node][1] + side / around as f64;
            if (0.0..1.0).contains(&at) {
                force[0] += quarter_force * (quarter * at).cos();
                force[1] += quarter_force * (quarter * at).sin();
            }
        }
        force
    };
    // Critically damped breathing, about sqrt(E/rho)/15.
    let damping = 2.0 * E.sqrt() / 15.0 * dt;
    let fix = |node: usize, v: &mut [f64; 4], _: &mut [f64; 4]| {
        v.iter_mut().for_each(|c| *c *= 1.0 - damping);
        v[2] = 0.0;
        if flat[node][1] == 0.0 {
            v[1] = 0.0;
        }
        if flat[node][1] == 1.0 {
            v[0] = 0.0;
        }
    };
    // After this time (1 + 13) exp(-13) of the motion remains.
    for _ in 0..(26.0 / damping) as usize {
        solids.explicit(dt, &masses, along, fix);
    }
    solids.x[0][0] - a
}

#[test]
fn assumed_strain_does_not_lock_when_nearly_incompressible() {
    for (nu, wanted) in [(0.3, 0.90794e-3), (0.49, 0.95076e-3), (0.499, 0.95222e-3)] {
        let u = cylinder(HourglassForm::AssumedStrain, nu);
        assert_close(
            u,
            wanted,
            0.01 * wanted,
            "the catalogue's bound for one-point elements, six radially",
        );
    }
}

/// Stiffness control is bounded by the shear modulus: as accurate at 0.49 as at 0.3.
#[test]
fn stiffness_control_is_right_for_nearly_incompressible_solids() {
    let u = cylinder(HourglassForm::Stiffness, 0.3);
    assert_close(
        u,
        0.90794e-3,
        0.01 * 0.90794e-3,
        "the catalogue's bound for one-point elements, six radially",
    );
    let u = cylinder(HourglassForm::Stiffness, 0.49);
    assert_close(u, 0.95076e-3, 0.01 * 0.95076e-3, "the same bound");
}
