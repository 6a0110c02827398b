//! Layers: columns of different laws, constants, angles.

use super::super::build;
use super::super::testing::material;
use super::*;
use crumple_proto::partition::Param;

fn steel(yield_stress: f64) -> Box<dyn PlaneStress> {
    let numbers = [("youngs_modulus", 200.0), ("poisson", 0.3), ("yield_stress", yield_stress)];
    build(&material("j2", &numbers, &[])).unwrap()
}

fn ply() -> Box<dyn PlaneStress> {
    let numbers = [
        ("youngs_modulus", 150.0),
        ("youngs_modulus_b", 10.0),
        ("poisson", 0.02),
        ("shear_modulus", 5.0),
        ("shear_modulus_bc", 3.0),
        ("angle", 10.0),
        ("strength_tension_b", 0.05),
        ("failure_strain_tension_a", 0.1),
    ];
    build(&material("orthotropic", &numbers, &[("tsai_wu", Param::Flag(false))])).unwrap()
}

fn point(law: usize, weight: f64, degrees: f64) -> LayerPoint {
    LayerPoint { law, weight, angle: f64::to_radians(degrees) }
}

/// Updates all points by the same strain increment.
fn update(law: &dyn PlaneStress, state: &mut [f64], points: usize, strain: [f64; 3]) {
    let points =
        Points { state, strain: &vec![strain; points], thickness_strain: &mut vec![0.0; points] };
    law.update_one(points, 1.0);
}

/// Each point has exactly the state that its law alone gives, in the columns of its names.
#[test]
fn each_point_follows_its_own_law() {
    let points = [point(0, 1.0, 0.0), point(1, 0.5, 0.0), point(0, 1.0, 0.0), point(0, 0.2, 0.0)];
    let both = layered(vec![steel(0.2), ply()], points.to_vec());
    let swapped = layered(vec![ply(), steel(0.2)], points.to_vec());
    assert_eq!(swapped.history()[0], "plastic_strain", "the section saves the first columns");
    let stride = 3 + both.history().len();
    let column = |name: &str| 3 + both.history().iter().position(|&n| n == name).expect(name);
    let mut state = vec![0.0; points.len() * stride];
    let alone = [steel(0.2), ply()];
    let mut own: Vec<Vec<f64>> =
        alone.iter().map(|law| vec![0.0; 3 + law.history().len()]).collect();
    for step in 0..40 {
        let strain = [3e-4, -1e-4 * f64::from(step), 2e-4];
        update(&*both, &mut state, points.len(), strain);
        own.iter_mut().zip(&alone).for_each(|(state, law)| update(&**law, state, 1, strain));
    }
    assert!(own[0][3] > 0.0, "the steel has yielded");
    for (k, point) in points.iter().enumerate() {
        let (of, wanted) = (&state[k * stride..][..stride], &own[point.law]);
        assert_eq!(of[..3], wanted[..3], "stress of point {k}");
        for (c, name) in alone[point.law].history().iter().enumerate() {
            assert_eq!(of[column(name)], wanted[3 + c], "{name} of point {k}");
        }
    }
}

/// More points than a law takes at once.
#[test]
fn many_layers_of_one_law() {
    let points: Vec<LayerPoint> = (0..30).map(|k| point(0, 1.0, f64::from(k))).collect();
    let law = layered(vec![ply()], points);
    let stride = 3 + law.history().len();
    let mut state = vec![0.0; 30 * stride];
    update(&*law, &mut state, 30, [1e-3, 2e-3, 0.0]);
    assert!(state.chunks(stride).all(|point| point[..3] == state[..3] && point[0] > 0.0));
    for k in [0, 7, 29] {
        let angle = law.orientation(k).expect("axes").angle.to_degrees();
        assert!((angle - 10.0 - k as f64).abs() < 1e-12, "{angle}");
    }
}

/// The bound is stiffer than every law for equal, opposite and shear strains; densities and
/// stabilising constants are means.
#[test]
fn constants_of_layers() {
    let laws = || vec![steel(0.2), ply()];
    let points = vec![point(0, 1.0, 0.0), point(1, 3.0, 0.0)];
    let law = layered(laws(), points);
    let stiffness = |of: Elastic| {
        let [c11, c12, g] = of.plane_stress();
        [c11 + c12, c11 - c12, 2.0 * g]
    };
    let bound = stiffness(law.elastic());
    for own in laws() {
        for (most, own) in bound.iter().zip(stiffness(own.elastic())) {
            assert!(*most > own * (1.0 - 1e-12), "{bound:?}");
        }
    }
    let [of_steel, of_ply] = [&laws()[0], &laws()[1]].map(|law| law.stabilising().youngs_modulus);
    let mean = 0.25 * of_steel + 0.75 * of_ply;
    assert!((law.stabilising().youngs_modulus / mean - 1.0).abs() < 1e-12);
    assert_eq!(law.transverse_shear(0).map(|[ca, bc]| ca == bc), Some(true));
    assert_eq!(law.transverse_shear(1), Some([5.0, 3.0]));
}

/// Each isotropic layer has its own modulus of transverse shear, not that of the stiffest.
#[test]
fn isotropic_layers_have_their_own_transverse_shear() {
    let soft = build(&material("elastic", &[("youngs_modulus", 2.0), ("poisson", 0.25)], &[]));
    let points = vec![point(0, 1.0, 0.0), point(1, 2.0, 0.0)];
    let law = layered(vec![steel(0.2), soft.unwrap()], points);
    assert_eq!(law.transverse_shear(1), Some([0.8; 2]));
    let of_steel = steel(0.2).elastic().shear_modulus();
    assert_eq!(law.transverse_shear(0), Some([of_steel; 2]));
}

/// Layers of one law without angles are that law.
#[test]
fn one_law_remains_as_it_is() {
    let law = layered(vec![steel(0.2)], vec![point(0, 1.0, 0.0); 3]);
    assert_eq!(law.elastic(), steel(0.2).elastic());
    assert_eq!(law.initial_yield_stress(), 0.2);
}
