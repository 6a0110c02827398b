//! Contact between edges, of shells and of solids: the same bits whichever workers own the
//! edges.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};

/// Distance below the edges of the lower layer from which its nodes are held [mm].
const FLOOR: f64 = 4.0;

/// Position of a body: a point, its length along a direction in the plane, and true if it is in
/// the upper layer [mm].
struct Place {
    at: [f64; 3],
    length: f64,
    angle: f64,
    above: bool,
}

impl Place {
    /// Returns the position after `i` of `cells` along the body, at a point of its profile: across
    /// and away from the other layer.
    fn point(&self, i: usize, cells: usize, [across, up]: [f64; 2]) -> [f64; 3] {
        let along = self.length * (i as f64 / cells as f64 - 0.5);
        let (sin, cos) = self.angle.to_radians().sin_cos();
        let z = if self.above { up } else { -up };
        let [x, y, middle] = self.at;
        [x + cos * along - sin * across, y + sin * along + cos * across, middle + z]
    }

    /// Returns the part of this layer.
    fn part(&self, [above, below]: [u32; 2]) -> u32 {
        if self.above { above } else { below }
    }
}

/// Upright strip of shells, 4 mm high, its free edge towards the other layer.
const STRIP: [[f64; 2]; 2] = [[0.0, 0.6], [0.0, 4.6]];
/// Sheet of shells that is bent along its middle, 5 mm high, its ridge towards the other layer.
const ROOF: [[f64; 2]; 5] = [[-5.0, 5.6], [-2.5, 3.1], [0.0, 0.6], [2.5, 3.1], [5.0, 5.6]];

/// Adds a sheet of shells with this profile.
fn sheet(scene: &mut Scene, p: &Place, cells: usize, profile: &[[f64; 2]]) {
    let across = profile.len() - 1;
    scene.lattice(p.part([1, 2]), [cells, across], |i, j| p.point(i, cells, profile[j]));
}

/// Adds a bar of cubes, 4 mm wide, that stands on an edge, its lowest or highest.
fn bar(scene: &mut Scene, p: &Place, cells: usize) {
    let d = 8f64.sqrt();
    let profile = [[0.0, 0.1], [d, 0.1 + d], [0.0, 0.1 + 2.0 * d], [-d, 0.1 + d]];
    let rows: Vec<[u32; 4]> =
        (0..=cells).map(|i| profile.map(|at| scene.node(p.point(i, cells, at)))).collect();
    // A reflection of the axes across and up reverses the order of the corners.
    let around = if p.above { [0, 1, 2, 3] } else { [0, 3, 2, 1] };
    for pair in rows.windows(2) {
        let corner = |k: usize| pair[k / 4][around[k % 4]];
        scene.solid(p.part([3, 4]), std::array::from_fn(corner));
    }
}

/// Returns a job with strips, bars and bent sheets in two layers. The upper layer falls and
/// slides over the lower one, from edge to edge, also across workers.
fn grid(contact: &str, cells: usize, velocity: [f64; 3], weight: f64) -> Model {
    let mut scene = Scene::new(1.0).in_units("mm, ms, kg");
    for (above, angle) in [(true, 0.0), (false, 70.0)] {
        for k in [-1.9, -0.9, 0.1, 1.2, 2.1] {
            let at = if above { [0.0, 12.0 * k, 0.0] } else { [12.0 * k, 0.0, 0.0] };
            sheet(&mut scene, &Place { at, length: 70.0, angle, above }, cells, &STRIP);
        }
    }
    for (above, angle) in [(true, 5.0), (false, 80.0)] {
        bar(&mut scene, &Place { at: [1.0, 60.0, 0.0], length: 50.0, angle, above }, 11);
    }
    for (above, angle, sides) in [(true, 0.0, [-6.0, 7.0]), (false, 75.0, [-7.0, 6.0])] {
        for side in sides {
            let at = if above { [0.0, side - 60.0, 0.0] } else { [side, -60.0, 0.0] };
            sheet(&mut scene, &Place { at, length: 40.0, angle, above }, 9, &ROOF);
        }
    }
    let nodes = |scene: &Scene, of: fn(f64) -> bool| -> Vec<u32> {
        (1..=scene.count()).filter(|&n| of(scene.at(n)[2])).collect()
    };
    let (upper, floor) = (nodes(&scene, |z| z > 0.0), nodes(&scene, |z| z < -FLOOR));
    scene.elastic("steel", Elastic { e: 200.0, nu: 0.3, rho: 7.85e-6 });
    (1..=2).for_each(|part| scene.part(part, "steel", 1.0, "points = 2"));
    (3..=4).for_each(|part| scene.solid_part(part, "steel", ""));
    scene.start(&upper, velocity, [0.0; 3]);
    scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]", -weight));
    scene.fix(&floor, "x y z");
    scene.add(&format!("[contact]\nfriction = 0.2\n{contact}"));
    model_of(&scene.text("Strips, bars and roofs across each other"), &[])
}

const LAWS: [&str; 5] = [
    "",
    "iteration = \"split\"",
    "law = \"kinematic\"",
    "law = \"penalty\"",
    "law = \"penalty\"\npenalty_form = \"stiffness\"\npenalty_scale = 0.5",
];

#[test]
fn edges_across_workers_give_the_same_bits() {
    for law in LAWS {
        let model = grid(law, 29, [40.0, 25.0, -2.0], 150.0);
        let alone = run_side_by_side(&model, 1, 900, 0);
        assert_eq!(alone.trouble, None);
        let most = if law.is_empty() { 9 } else { 5 };
        for (workers, every) in [(2, 0), (most, 3)] {
            let many = run_side_by_side(&model, workers, 900, every);
            let differs = many.pairs.iter().zip(&alone.pairs).position(|(a, b)| a != b);
            assert_eq!(
                differs, None,
                "{law}: cycle in which the pairs of {workers} workers differ, renewed every {every}"
            );
            assert_eq!(
                many.digest(),
                alone.digest(),
                "{law}: {workers} workers, renewed every {every}"
            );
        }
    }
}

/// With contact of edges the layers rebound; without it the upper layer goes through.
#[test]
fn edges_hold_what_would_pass_between_nodes() {
    let ends = [true, false].map(|edges| {
        let model = grid(&format!("edges = {edges}"), 13, [4.0, 2.0, -8.0], 0.0);
        let end = run_alone(&model, |_| {});
        end.contact.as_ref().unwrap().crossings(&end.nodes, end.clock.time).len()
    });
    assert_eq!(ends[0], 0);
    assert!(ends[1] > 0, "without edges the strips pass through: {ends:?}");
}
