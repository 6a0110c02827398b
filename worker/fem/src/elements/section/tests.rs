use super::*;
use crate::elements::testing;
use crate::materials::{self, LayerPoint};
use crumple_proto::job::{LayerInput, Setting};
use crumple_proto::partition::Param;
use nalgebra::{Matrix3, Vector3};

/// n Gauss points integrate polynomials of degree 2n - 1 exactly (Abramowitz & Stegun 25.4.29).
#[test]
fn gauss_points_integrate_what_they_should() {
    for n in 1..=MAX_POINTS {
        let (zeta, weight) = gauss_legendre(n);
        for degree in 0..2 * n {
            let sum: f64 = (0..n).map(|k| weight[k] * zeta[k].powi(degree as i32)).sum();
            let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
            assert!(
                (sum - exact).abs() < 1e-14,
                "round-off: {n} points, degree {degree}: {sum} for {exact}"
            );
        }
    }
}

/// A laminate [0/45/-45/90] with plies of different thickness has the stiffness A, B, D of laminate
/// theory (Jones, Mechanics of Composite Materials, 2nd ed., ch. 4), and the
/// transverse shear stiffness 5/6 of the turned moduli; its axis a starts along a direction.
#[test]
fn layers_have_the_stiffness_of_laminate_theory() {
    const ANGLES: [f64; 4] = [0.0, 45.0, -45.0, 90.0];
    const THICKNESS: [f64; 4] = [0.2, 0.1, 0.3, 0.25];
    let (ea, eb, nu, g, bc) = (150.0, 10.0, 0.02, 5.0, 3.0);
    let numbers = [
        ("youngs_modulus", ea),
        ("youngs_modulus_b", eb),
        ("poisson", nu),
        ("shear_modulus", g),
        ("shear_modulus_bc", bc),
        ("angle", 15.0),
    ];
    let mut ply = testing::material("orthotropic", 1.0, &numbers);
    ply.parameters.insert("direction".into(), Param::List(vec![1.0, 2.0, 7.0]));
    let layer = |k: usize| LayerInput {
        thickness: THICKNESS[k],
        material: String::new(),
        angle: ANGLES[k],
        points: 2,
    };
    let whole: f64 = THICKNESS.iter().sum();
    let part = Part { layer: (0..4).map(layer).collect(), ..testing::part(whole) };
    let row = crate::elements::formulation(&part, crumple_proto::mesh::Shape::Quad4).unwrap();
    let law = materials::build(&ply).unwrap();
    let points = (0..8).map(|p| LayerPoint {
        law: 0,
        weight: THICKNESS[p / 2],
        angle: ANGLES[p / 2].to_radians(),
    });
    let law = materials::layered(vec![law], points.collect());
    let section = Section::new(&part, &row.values(&part), law).unwrap();

    let mut state = vec![0.0; section.columns()];
    section.start(&mut state, OwnSection::default());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    section.orient(
        &mut state,
        OwnSection { angle: 5.0, ..OwnSection::default() },
        &axes,
        [1.0, 0.0, 0.0],
    );
    let strains =
        Strains { eps: [1e-3, -2e-3, 5e-4], kappa: [3e-3, 1e-3, -2e-3], gamma: [1e-3, -4e-3] };
    let exact = {
        let (mut n, mut m, mut q) = ([0.0; 3], [0.0; 3], [0.0; 2]);
        let mut z = -0.5 * whole;
        for (angle, t) in ANGLES.iter().zip(THICKNESS) {
            let turned = f64::atan2(2.0, 1.0) + (angle + 15.0 + 5.0_f64).to_radians();
            let (s, c) = turned.sin_cos();
            // Q' = T^-1 Q T^-T of the ply.
            let product = nu * nu * ea / eb;
            let own =
                Matrix3::new(ea, nu * ea, 0.0, nu * ea, eb, 0.0, 0.0, 0.0, g * (1.0 - product))
                    / (1.0 - product);
            let turn = Matrix3::new(
                c * c,
                s * s,
                2.0 * c * s,
                s * s,
                c * c,
                -2.0 * c * s,
                -c * s,
                c * s,
                c * c - s * s,
            );
            let back = turn.try_inverse().unwrap();
            let ply = back * own * back.transpose();
            let (low, high) = (z, z + t);
            let moments = [1, 2, 3].map(|p| (high.powi(p) - low.powi(p)) / f64::from(p));
            let (e, k) = (Vector3::from(strains.eps), Vector3::from(strains.kappa));
            let force = ply * (e * moments[0] + k * moments[1]);
            let moment = ply * (e * moments[1] + k * moments[2]);
            let shear = [
                (g * c * c + bc * s * s, (g - bc) * c * s),
                (g * s * s + bc * c * c, (g - bc) * c * s),
            ];
            for i in 0..3 {
                n[i] += force[i];
                m[i] += moment[i];
            }
            for i in 0..2 {
                let (own, other) = (strains.gamma[i], strains.gamma[1 - i]);
                q[i] += SHEAR_CORRECTION * t * (shear[i].0 * own + shear[i].1 * other);
            }
            z = high;
        }
        (n, m, q)
    };
    let mut many = state.clone();
    let with_eight = section.update::<f64, 8>(&mut state, &strains, 1.0);
    let with_most = section.update::<f64, MAX_LAYER_POINTS>(&mut many, &strains, 1.0);
    assert_eq!(state, many, "the number of points that the kernel allows for has no effect");
    for Resultants { n, m, q, .. } in [with_eight, with_most] {
        let got = [&n[..], &m[..], &q[..]].concat();
        let wanted = [&exact.0[..], &exact.1[..], &exact.2[..]].concat();
        for (got, wanted) in got.iter().zip(&wanted) {
            assert!((got - wanted).abs() < 1e-12, "{got}, not {wanted}");
        }
    }
}

/// Plastic strain `eps |zeta|` of bending is eps at the outer fibres with any number of points;
/// strain of the membrane does not count, except with two points.
#[test]
fn plastic_strain_of_bending_is_that_of_the_outer_fibres() {
    let numbers = [("youngs_modulus", 210.0), ("poisson", 0.3), ("yield_stress", 0.2)];
    let steel = testing::material("j2", 1.0, &numbers);
    for points in 1..=MAX_POINTS {
        let mut part = testing::part(1.0);
        part.parameters.insert("points".into(), Setting::Whole(points as i64));
        let row = crate::elements::formulation(&part, crumple_proto::mesh::Shape::Quad4).unwrap();
        let law = materials::build(&steel).unwrap();
        let section = Section::new(&part, &row.values(&part), law).unwrap();
        let strain = section.plastic_strain.expect("a plastic law");
        let of = |bending: f64, membrane: f64| {
            let mut history = crate::columns::HistoryColumns::new(
                crumple_proto::job::Precision::Double,
                1,
                section.columns(),
            );
            let mut state = vec![0.0; section.columns()];
            for k in 0..points {
                state[POINTS + k * section.stride + strain] =
                    membrane + bending * section.zeta[k].abs();
            }
            history.set(0, &state);
            section.plastic_bending_strain(history.element(0))
        };
        let wanted = if points == 1 { 0.0 } else { 0.02 };
        assert!((of(0.02, 0.0) - wanted).abs() < 1e-14, "{points} points: {}", of(0.02, 0.0));
        assert_eq!(of(0.0, 0.03) > 0.0, points == 2, "{points} points");
    }
}
