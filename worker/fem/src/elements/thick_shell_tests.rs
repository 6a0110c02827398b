//! Tests of thick shells: rigid motion, patches, bending, plastic hinge, thickness, balance, stable
//! step, lanes, failure.

use super::super::plate_tests::cantilever_frequency;
use super::super::solid_testing::block;
use super::super::solid_tests::{alone, crush, growth, swing, turn_once};
use super::super::testing::*;
use super::*;
use crumple_proto::partition::Material;

const E: f64 = 1e6;
const NU: f64 = 0.25;

fn sheet() -> Part {
    part_of(THICK_SHELL, 0.0)
}

/// Returns a plate of 3 by 3 by 1 whose nodes are displaced by noise up to `by`, in the plane by
/// `in_plane` as much.
fn plate(law: Material, by: f64, in_plane: f64) -> Patch<8> {
    let (mut nodes, cells) = block([3, 3, 1], [3.0, 3.0, 0.7]);
    let mut noise = Noise(11);
    for x in &mut nodes {
        (0..3).for_each(|i| x[i] += by * noise.next() * if i < 2 { in_plane } else { 1.0 });
    }
    Patch::new(sheet(), law, &nodes, &cells)
}

/// A rigid rotation with translation leaves no stress and no force, in distorted elements too.
#[test]
fn rigid_rotation_leaves_no_stress() {
    turn_once(plate(elastic(E, NU, 1.0), 0.1, 1.0));
}

/// Forces and moments balance in any motion, and the work that is booked is theirs.
#[test]
fn forces_balance_and_do_the_work_that_is_booked() {
    swing(plate(elastic(E, NU, 1.0), 0.1, 1.0));
}

/// Verification A21: a linear field in plane stress gives its stress in all elements of a flat
/// plate, with quads of any shape and directors that are not upright, and the nodes inside are in
/// equilibrium, as sums over the thickness.
#[test]
fn a_membrane_patch_is_exact() {
    let (mut nodes, cells) = block([3, 3, 1], [3.0, 3.0, 0.7]);
    let mut noise = Noise(7);
    for x in &mut nodes {
        (0..2).for_each(|i| x[i] += 0.2 * noise.next());
    }
    let mut patch = Patch::new(sheet(), elastic(E, NU, 1.0), &nodes, &cells);
    let size = 1e-9;
    let across = -NU / (1.0 - NU) * 3.0 * size;
    patch.go(|[x, y, z]| {
        [x + size * (x + 0.4 * y), y + size * (0.2 * x + 2.0 * y), z * (1.0 + across)]
    });
    let factor = E / (1.0 - NU * NU);
    let shear = 0.6 * E / (2.0 * (1.0 + NU));
    let wanted = [factor * (1.0 + 2.0 * NU), factor * (2.0 + NU), 0.0, shear, 0.0, 0.0];
    for element in 0..patch.cells.len() {
        let stress = patch.fields(element).stress.map(|s| s / size);
        for (c, (stress, wanted)) in stress.into_iter().zip(wanted).enumerate() {
            assert!((stress - wanted).abs() < 1e-6 * E, "{element} {c}: {stress} {wanted}");
        }
    }
    let (force, _) = patch.nodal();
    let largest = patch.largest().0;
    for inside in [5, 6, 9, 10] {
        for (below, above) in force[inside].iter().zip(&force[inside + 16]) {
            let sum = below + above;
            assert!(sum.abs() < 1e-6 * largest, "{inside}: {sum:e} of {largest:e}");
        }
    }
}

/// Returns the moment per width of a strip of three shells of thickness 0.4 and width 0.5, after a
/// step in which it is bent to the curvatures `kappa` along its length and `across`.
fn moment_of(strip: &mut Patch<8>, nodes: &[[f64; 3]], [kappa, across]: [f64; 2]) -> f64 {
    // The middle surface is a polygon with sides as long as at the start, and directors lean
    // against the normals of both shells by half of the turn of a shell.
    let (radius, longer) = (0.5 / (0.5 * kappa).sin(), 1.0 / (0.5 * kappa).cos());
    for (n, &[x, y, z]) in nodes.iter().enumerate() {
        let (s, angle) = (longer * (z - 0.2), kappa * x);
        let sag = 2.0 * radius * (0.5 * angle).sin().powi(2) + 0.5 * across * y * y;
        let to = [angle.sin() * (radius - s), y * (1.0 - across * s), 0.2 + sag + s * angle.cos()];
        (0..3).for_each(|i| strip.v[n][i] = to[i] - strip.x[n][i]);
    }
    strip.step(1.0);
    let (force, _) = strip.nodal();
    let (sin, cos) = (3.0 * kappa).sin_cos();
    let end = |n: &usize| nodes[*n][0] == 3.0;
    let of = |n: usize| -longer * (nodes[n][2] - 0.2) * (force[n][0] * cos + force[n][2] * sin);
    (0..nodes.len()).filter(end).map(of).sum::<f64>() / 0.5
}

fn strip(law: Material) -> (Vec<[f64; 3]>, Patch<8>) {
    let (mut nodes, cells) = block([3, 1, 1], [3.0, 0.5, 0.4]);
    nodes.iter_mut().for_each(|x| x[1] -= 0.25);
    let strip = Patch::new(sheet(), law, &nodes, &cells);
    (nodes, strip)
}

/// One element through the thickness has the bending stiffness of a beam and of a plate.
#[test]
fn bending_is_exact() {
    let kappa = 1e-7;
    let (nodes, mut beam) = strip(elastic(E, NU, 1.0));
    let wanted = E * f64::powi(0.4, 3) / 12.0 * kappa;
    let found = moment_of(&mut beam, &nodes, [kappa, -NU * kappa]);
    assert_close(found, wanted, 1e-5 * wanted, "curvatures of 1e-7");
    let (nodes, mut plate) = strip(elastic(E, NU, 1.0));
    let found = moment_of(&mut plate, &nodes, [kappa, 0.0]);
    let wanted = wanted / (1.0 - NU * NU);
    assert_close(found, wanted, 1e-5 * wanted, "curvatures of 1e-7");
}

/// The plastic hinge of a plate has the moment 2/sqrt 3 sig t^2/4, of which five points of Gauss
/// give the sum of their weights times places, 0.9448.
#[test]
fn a_plastic_hinge_has_its_moment() {
    let numbers = [("youngs_modulus", E), ("poisson", 0.3), ("yield_stress", 1e-3 * E)];
    let (nodes, mut plate) = strip(material("j2", 1.0, &numbers));
    let mut found = 0.0;
    for step in 1..=60 {
        found = moment_of(&mut plate, &nodes, [2e-3 * f64::from(step), 0.0]);
    }
    let wanted = 0.9448 * 2.0 / 3.0_f64.sqrt() * 1e-3 * E * 0.04;
    assert_close(found, wanted, 0.002 * wanted, "elastic strains next to plastic ones");
}

/// A small strain of any kind has the stress of the solid.
#[test]
fn small_strains_are_those_of_the_solid() {
    let (nodes, cells) = block([1, 1, 1], [1.0, 2.0, 0.5]);
    for nu in [0.0, 0.3, 0.4] {
        let mut one = Patch::new(sheet(), elastic(E, nu, 1.0), &nodes, &cells);
        let strain = [1e-8, -2e-8, 3e-8];
        one.go(|[x, y, z]| {
            [x * (1.0 + strain[0]) + 2e-8 * y, y * (1.0 + strain[1]), z * (1.0 + strain[2])]
        });
        let shear = E / (2.0 * (1.0 + nu));
        let lame = 2.0 * shear * nu / (1.0 - 2.0 * nu);
        let direct = strain.map(|e| lame * 2e-8 + 2.0 * shear * e);
        let wanted = [direct[0], direct[1], direct[2], shear * 2e-8, 0.0, 0.0];
        for (found, wanted) in one.fields(0).stress.into_iter().zip(wanted) {
            assert_close(found, wanted, 1e-6 * E * 1e-8, "strains of 1e-8");
        }
    }
}

/// In plastic flow the thickness of the law follows the strain, and the faces are drawn after it.
#[test]
fn the_faces_follow_the_thickness_of_the_law() {
    let numbers = [("youngs_modulus", E), ("poisson", 0.3), ("yield_stress", 1e-4 * E)];
    let (nodes, cells) = block([1, 1, 1], [1.0, 1.0, 0.5]);
    let mut one = Patch::new(sheet(), material("j2", 1.0, &numbers), &nodes, &cells);
    for _ in 0..200 {
        one.go(|[x, y, z]| [1.0005 * x, y, z]);
    }
    let stretch = 1.0005_f64.powi(200);
    let thickness = one.fields(0).thickness;
    assert_close(thickness, 0.5 / stretch, 2e-4, "elastic strains of 1e-4, steps of 5e-4");
    let ratio = 0.5 / thickness;
    let modulus = E * 0.7 / (1.3 * 0.4);
    let wanted = 0.5 * modulus * (ratio - 1.0 / ratio) * one.x[1][0] / 4.0;
    assert_close(one.corner(0, 6).0[2], wanted, 1e-9 * wanted, "a quarter of the face each");
    // Faces at the thickness of the law are at rest.
    one.go(|[x, y, z]| [x, y, if z > 0.0 { thickness } else { 0.0 }]);
    assert!(one.corner(0, 6).0[2].abs() < 1e-9 * E);
}

/// Verification A15: first mode of a cantilever strip, 83.55 Hz; nu = 0 makes it a beam.
#[test]
fn cantilever_swings_at_its_frequency() {
    let (nodes, cells) = block([20, 2, 1], [0.2, 0.02, 0.004]);
    let mut patch = Patch::new(sheet(), elastic(210e9, 0.0, 7850.0), &nodes, &cells);
    let found = cantilever_frequency(&mut patch);
    assert_close(found, 83.55, 0.01 * 83.55, "20 elements long");
}

/// Elements of any shape are stable at their own step with the usual safety, and plates of one
/// thickness are not much beyond it.
#[test]
fn the_stable_step_is_below_the_limit_and_near_it() {
    for nu in [0.0, 0.3, 0.45] {
        for size in [[2.0, 2.0, 0.1], [2.0, 2.0, 1.0], [2.0, 2.0, 3.0], [4.0, 2.0, 0.5]] {
            let (nodes, cells) = block([2, 2, 1], size);
            let fresh = || Patch::new(sheet(), elastic(1.0, nu, 1.0), &nodes, &cells);
            let dt = fresh().stable_dt();
            let [below, above] = [0.9, 1.3].map(|share| growth(fresh(), share * dt));
            assert!(below < 100.0 && above > 1e4, "{nu} {size:?}: {below:e} {above:e}");
        }
    }
    // Needles and towers, with the largest hourglass coefficient.
    for size in [[50.0, 1.0, 0.2], [1.0, 1.0, 20.0], [50.0, 1.0, 5.0]] {
        for nu in [0.0, 0.3] {
            let (nodes, cells) = block([1, 1, 1], size);
            let part = sheet().with("hourglass_coefficient", 1.0);
            let fresh = || Patch::new(part.clone(), elastic(1.0, nu, 1.0), &nodes, &cells);
            let below = growth(fresh(), 0.9 * fresh().stable_dt());
            assert!(below < 100.0, "{nu} {size:?}: {below:e}");
        }
    }
    let mut widest = [0.0_f64; 3];
    let mut unstable = Vec::new();
    for seed in 1..60 {
        let mut noise = Noise(seed);
        let height = [0.1, 0.3, 1.0, 2.0][seed as usize % 4];
        let (mut nodes, cells) = block([1, 1, 1], [1.0, 1.0, height]);
        let by = [0.1, 0.2, 0.3][seed as usize % 3];
        for x in &mut nodes {
            (0..2).for_each(|i| x[i] += by * noise.next());
            x[2] += by * height * noise.next();
        }
        let fresh = || Patch::new(sheet(), elastic(1.0, 0.3, 1.0), &nodes, &cells);
        let dt = fresh().stable_dt();
        if growth(fresh(), 0.9 * dt) > 100.0 {
            unstable.push(seed);
        }
        let beyond = (10..40).map(|k| 0.1 * f64::from(k)).find(|k| growth(fresh(), k * dt) > 100.0);
        let of_noise = &mut widest[seed as usize % 3];
        *of_noise = of_noise.max(beyond.unwrap_or(4.0));
    }
    assert!(unstable.is_empty(), "{unstable:?}");
    assert!(widest[0] < 3.0, "2.7 at a tenth of the sides, the bound is wide: {widest:?}");
}

/// All laws of sheets: each lane gives the result of its element alone.
#[test]
fn every_lane_is_what_it_would_be_alone() {
    for law in laws() {
        alone(&law, plate(law.clone(), 0.1, 1.0), sheet());
    }
}

/// An inverted element, one with wild strain or numbers that are none is trouble; a part may let
/// inverted ones fail.
#[test]
fn an_inverted_or_wildly_strained_element_is_trouble() {
    crush(|| plate(elastic(E, NU, 1.0), 0.0, 1.0));
    let (nodes, cells) = block([3, 3, 1], [3.0, 3.0, 0.7]);
    let deleting = sheet().with("inverted", "delete");
    let mut patch = Patch::new(deleting, elastic(E, NU, 1.0), &nodes, &cells);
    for _ in 0..3 {
        let totals = patch.go(|[x, y, z]| [x, y, -z]);
        assert_eq!((totals.trouble, patch.largest().0), (None, 0.0));
        assert_eq!(totals.stable_dt, f64::INFINITY);
        assert!((0..9).all(|e| patch.fields(e).failed));
    }
}

/// An element whose step falls below that of its part is deleted, and the others stay.
#[test]
fn a_short_step_deletes_an_element() {
    let (nodes, cells) = block([3, 1, 1], [3.0, 1.0, 0.5]);
    let step = Patch::new(sheet(), elastic(E, NU, 1.0), &nodes, &cells).stable_dt();
    let part = sheet().with("deletion_step", 0.8 * step);
    let mut patch = Patch::new(part, elastic(E, NU, 1.0), &nodes, &cells);
    let mut steps = 0;
    while !patch.fields(2).failed {
        let totals = patch.go(|[x, y, z]| [x, y, if x > 2.5 { 0.98 * z } else { z }]);
        assert_eq!(totals.trouble, None);
        steps += 1;
        assert!(steps < 100, "the step goes with the thickness");
    }
    assert!(steps > 5 && !patch.fields(0).failed && !patch.fields(1).failed, "{steps}");
    assert!((0..8).all(|c| patch.corner(2, c).0 == [0.0; 3]));
}

/// A part of thick shells has neither a thickness nor an offset.
#[test]
fn a_thickness_of_the_part_is_an_error() {
    let part = Part { thickness: 1.0, offset: 0.5, ..sheet() };
    let built = super::super::build_block(&settings(part, elastic(E, NU, 1.0)), 0, Shape::Hex8);
    let found = built.err().expect("the nodes give the thickness");
    let paths: Vec<&str> = found.iter().map(|problem| &*problem.path).collect();
    assert_eq!(paths, ["part.0.thickness", "part.0.offset"]);
}
