//! Cohesive elements: forces, conservation, stable step, removal. Units mm, ms, kg, so kN and GPa.

use super::*;
use crate::elements::testing::{Noise, Patch, material, part};
use crumple_proto::partition::{Material, Param};

const K: [f64; 2] = [20.0, 8.0];
const T: [f64; 2] = [0.04, 0.025];
/// Mass per area.
const DENSITY: f64 = 1e-6;
/// A parallelogram.
const FACE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.5, 1.0, 0.0], [0.5, 1.0, 0.0]];
const AREA: f64 = 2.0;

type Surface = Patch<8>;

fn law(name: &str) -> Material {
    let numbers = [("stiffness_normal", K[0]), ("stiffness_shear", K[1])];
    let strength = [("strength_normal", T[0]), ("strength_shear", T[1])];
    let toughness = [("toughness_normal", 8e-4), ("toughness_shear", 2.4e-3)];
    let numbers = match name {
        "cohesive_elastic" => numbers.to_vec(),
        _ => [numbers, strength, toughness].concat(),
    };
    let mut material = material(name, DENSITY, &numbers);
    material.parameters.insert("density_per_area".into(), Param::Flag(true));
    material
}

fn element(name: &str, part: Part, nodes: &[[f64; 3]; 8]) -> Surface {
    let part = Part { element: Some(COHESIVE.into()), ..part };
    Surface::new(part, law(name), nodes, &[[0, 1, 2, 3, 4, 5, 6, 7]])
}

/// Returns both faces, this far apart along z.
fn faces(apart: f64) -> [[f64; 3]; 8] {
    std::array::from_fn(|k| {
        let [x, y, z] = FACE[k % 4];
        [x, y, if k < 4 { z } else { z + apart }]
    })
}

/// Returns distorted faces at a random place in space.
fn distorted(noise: &mut Noise, apart: f64) -> [[f64; 3]; 8] {
    faces(apart).map(|x| x.map(|c| c + 0.15 * noise.next()))
}

/// Returns the resultant force and moment of the forces on all nodes.
fn resultants(surface: &Surface) -> [V3; 2] {
    let (mut force, mut moment) = (V3::zeros(), V3::zeros());
    for c in 0..8 {
        let f = V3::from(surface.corner(0, c).0);
        force += f;
        moment += V3::from(xyz(&surface.x[c])).cross(&f);
    }
    [force, moment]
}

/// Moves the second face by `way`, in one step.
fn open(surface: &mut Surface, way: [f64; 3]) {
    for (k, v) in surface.v.iter_mut().enumerate() {
        v[..3].copy_from_slice(if k < 4 { &[0.0; 3] } else { &way });
    }
    surface.step(1.0);
}

/// A uniform opening gives the traction of the law times the area, a quarter at each node of a
/// parallelogram, with both integrations and any thickness.
#[test]
fn a_uniform_opening_has_the_traction_of_the_law() {
    for integration in ["gauss", "nodes"] {
        for apart in [0.0, 0.3] {
            let of = part(0.0).with("integration", integration);
            let mut surface = element("cohesive_elastic", of, &faces(apart));
            open(&mut surface, [1e-3, -2e-3, 4e-3]);
            let load = [K[1] * 1e-3, -K[1] * 2e-3, K[0] * 4e-3].map(|t| AREA * t);
            let [force, _] = resultants(&surface);
            assert!(force.norm() < 1e-15, "{force}");
            let upper = (4..8).map(|c| V3::from(surface.corner(0, c).0)).sum::<V3>();
            // With a thickness the couple of the shear acts on both faces alike.
            let lower = (0..4).map(|c| V3::from(surface.corner(0, c).0)).sum::<V3>();
            assert!((upper - V3::from(load)).norm() < 1e-12, "{apart}: {upper}");
            assert!((lower + V3::from(load)).norm() < 1e-12, "{apart}: {lower}");
            if apart == 0.0 {
                let first = V3::from(surface.corner(0, 4).0);
                assert!((first - 0.25 * V3::from(load)).norm() < 0.01 * V3::from(load).norm());
            }
            let stress = surface.fields(0).stress;
            let wanted = [0.0, 0.0, K[0] * 4e-3, 0.0, -K[1] * 2e-3, K[1] * 1e-3];
            for (got, wanted) in stress.iter().zip(wanted) {
                assert!((got - wanted).abs() < 1e-12, "{stress:?}");
            }
        }
    }
}

/// Forces of distorted, opened elements have no resultant, force or moment, and those of elements
/// that were turned by large angles are zero.
#[test]
fn momentum_and_angular_momentum_are_conserved() {
    let mut noise = Noise(3);
    for k in 0..20 {
        let nodes = distorted(&mut noise, [0.0, 0.4][k % 2]);
        let mut surface = element("cohesive_elastic", part(0.0), &nodes);
        surface.go(|x| {
            // A rotation by about 2 rad about a slanted axis, and a way.
            let turned = nalgebra::Rotation3::new(V3::new(1.0, -1.5, 0.7)) * V3::from(x);
            [turned[0] + 3.0, turned[1] - 1.0, turned[2] + 0.5]
        });
        let largest = (0..8).map(|c| V3::from(surface.corner(0, c).0).norm()).fold(0.0, f64::max);
        assert!(largest < 1e-13 * K[0], "no force of a rigid motion: {largest}");
        surface.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = 0.1 * noise.next()));
        surface.step(1.0);
        let [force, moment] = resultants(&surface);
        let largest = (0..8).map(|c| V3::from(surface.corner(0, c).0).norm()).fold(0.0, f64::max);
        assert!(largest > 0.1, "it is opened: {largest}");
        assert!(force.norm() < 1e-13 * largest, "{force}");
        assert!(moment.norm() < 1e-12 * largest, "{moment}");
    }
}

/// The energy of an elastic element is the work on its nodes: the difference falls with the square
/// of the step, by a factor of four for half of it.
#[test]
fn the_energy_is_the_work_on_the_nodes() {
    let error = |steps: usize| {
        let mut noise = Noise(11);
        let nodes = distorted(&mut noise, 0.3);
        let mut surface = element("cohesive_elastic", part(0.0), &nodes);
        let (mut energy, mut work) = (0.0, 0.0);
        let mut before = [V3::zeros(); 8];
        for _ in 0..4 {
            let way: Vec<[f64; 3]> =
                (0..8).map(|_| [0.0; 3].map(|_: f64| 0.2 * noise.next())).collect();
            for _ in 0..steps {
                for (v, way) in surface.v.iter_mut().zip(&way) {
                    (0..3).for_each(|i| v[i] = way[i] / steps as f64);
                }
                energy += surface.step(1.0).internal;
                for (c, before) in before.iter_mut().enumerate() {
                    let now = V3::from(surface.corner(0, c).0);
                    work += 0.5 * (*before + now).dot(&V3::from(xyz(&surface.v[c])));
                    *before = now;
                }
            }
        }
        assert!(energy > 0.1, "{energy}");
        (energy - work).abs() / energy
    };
    let [coarse, fine] = [50, 100].map(error);
    assert!(coarse < 1e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// Returns the largest displacement of a free element in so many steps of this size, over the first
/// one.
fn growth(nodes: &[[f64; 3]; 8], integration: &str, dt: f64) -> f64 {
    let of = part(0.0).with("integration", integration);
    let mut surface = element("cohesive_elastic", of, nodes);
    let (mass, _) = surface.element.corner_mass(nodes, OwnSection::default());
    let mut noise = Noise(29);
    // Small, so that the geometry stays that of the start.
    let small = 1e-9;
    surface.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = small / dt * noise.next()));
    let mut most = 0.0_f64;
    for _ in 0..2000 {
        surface.step(dt);
        for c in 0..8 {
            let force = surface.corner(0, c).0;
            (0..3).for_each(|i| surface.v[c][i] -= dt * force[i] / mass);
            let opened = (0..3).map(|i| (surface.v[c][i] * dt).abs()).fold(0.0, f64::max);
            most = most.max(opened / small);
        }
        if most.is_nan() || most >= 1e8 {
            return f64::INFINITY;
        }
    }
    most
}

/// The stable step is one, and not too small: of a parallelogram without thickness with points at
/// the nodes it is exact.
#[test]
fn no_mode_grows_at_the_stable_step() {
    let mut noise = Noise(7);
    let mut shapes = vec![(faces(0.0), 1.0), (faces(0.2), 0.7)];
    shapes.extend((0..4).map(|k| (distorted(&mut noise, 0.1 * f64::from(k)), 0.4)));
    for (nodes, least) in shapes {
        for integration in ["gauss", "nodes"] {
            let of = part(0.0).with("integration", integration);
            let surface = element("cohesive_elastic", of, &nodes);
            let limit = surface.element.stable_dt(&nodes, OwnSection::default());
            assert!(growth(&nodes, integration, 0.999 * limit) < 100.0, "{integration} {nodes:?}");
            let (mut low, mut high) = (0.999 * limit, 4.0 * limit);
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                match growth(&nodes, integration, middle) {
                    most if most < 1e4 => low = middle,
                    _ => high = middle,
                }
            }
            println!("{integration}: bisected step over the limit {:.4}", high / limit);
            assert!(limit / high > least - 0.01, "{integration}: {limit} for {high}");
        }
    }
}

/// The stable step of a rectangle without thickness is that of its mass per area, `sqrt(m/K)`.
#[test]
fn the_step_without_thickness_has_a_closed_form() {
    for integration in ["gauss", "nodes"] {
        let of = part(0.0).with("integration", integration);
        let surface = element("cohesive_elastic", of, &faces(0.0));
        let limit = surface.element.stable_dt(&faces(0.0), OwnSection::default());
        assert!((limit / (DENSITY / K[0]).sqrt() - 1.0).abs() < 1e-12, "{limit}");
        let (mass, inertia) = surface.element.corner_mass(&faces(0.0), OwnSection::default());
        assert!((mass - DENSITY * AREA / 8.0).abs() < 1e-18 && inertia == 0.0);
    }
}

/// A larger stiffness under pressure shortens the step to that of a pressed element.
#[test]
fn the_step_is_that_of_the_largest_stiffness() {
    let numbers = [
        ("strength", T[0]),
        ("separation_normal", 0.04),
        ("separation_shear", 0.1),
        ("peak_share", 0.05),
        ("softening_share", 0.5),
        ("pressure_factor", 9.0),
    ];
    let mut material = material("cohesive_tvergaard_hutchinson", DENSITY, &numbers);
    material.parameters.insert("density_per_area".into(), Param::Flag(true));
    let of = Part { element: Some(COHESIVE.into()), ..part(0.0) };
    let surface = Surface::new(of, material, &faces(0.0), &[[0, 1, 2, 3, 4, 5, 6, 7]]);
    let limit = surface.element.stable_dt(&faces(0.0), OwnSection::default());
    let pressed = 9.0 * T[0] / (0.05 * 0.04);
    assert!((limit / (DENSITY / pressed).sqrt() - 1.0).abs() < 1e-12, "{limit}");
}

/// An element goes when so many of its points have failed; with 0 it stays, and its faces push.
#[test]
fn an_element_goes_with_its_points() {
    let turn = |surface: &mut Surface, by: f64| {
        // The second face opens in proportion to x.
        for k in 4..8 {
            surface.v[k] = [0.0, 0.0, by * surface.x[k][0], 0.0];
        }
        surface.step(1.0);
    };
    for (points, wanted) in [(2_i64, true), (3, false), (0, false)] {
        let of = part(0.0).with("failed_points", points);
        let mut surface = element("cohesive_mixed_mode", of, &faces(0.0));
        assert_eq!(surface.element.can_fail(), points > 0);
        // The end of mode I is at 2 G/T = 0.04; only the two points at larger x get there.
        turn(&mut surface, 0.04);
        assert_eq!(surface.element.failed(surface.history.element(0)), wanted, "{points}");
        open(&mut surface, [0.0, 0.0, 1.0]);
        let is_removed = surface.element.failed(surface.history.element(0));
        assert_eq!(is_removed, points > 0, "{points}");
        assert!((0..8).all(|c| surface.corner(0, c).0 == [0.0; 3]));
        open(&mut surface, [0.0, 0.0, -1.2]);
        let pushes = surface.corner(0, 4).0[2] < -0.1;
        assert_eq!(pushes, points == 0, "{points}");
    }
}

/// The work to separation of an element is toughness times area, at any orientation.
#[test]
fn separation_takes_toughness_times_area() {
    let ways = [([0.0, 0.0, 1.0], 8e-4), ([0.6, 0.8, 0.0], 2.4e-3)];
    let laws = ["cohesive_mixed_mode", "cohesive_elastoplastic"];
    for ((way, toughness), law) in ways.into_iter().flat_map(|way| laws.map(|law| (way, law))) {
        let mut surface = element(law, part(0.0), &faces(0.0));
        let (peak, end) =
            if toughness == 8e-4 { (T[0] / K[0], 0.04) } else { (T[1] / K[1], 0.192) };
        let mut energy = 0.0;
        for size in [peak, end - peak] {
            for k in 4..8 {
                (0..3).for_each(|i| surface.v[k][i] = size * way[i]);
            }
            energy += surface.step(1.0).internal;
        }
        // The surface in the middle does not turn: the tangents of both faces are the same.
        assert!((energy / (toughness * AREA) - 1.0).abs() < 1e-9, "{law}: {energy}");
    }
}
