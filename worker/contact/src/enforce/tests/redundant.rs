//! Tests of redundant pairs: nodes that face nodes.

use super::*;

/// Two square plates of unit corner masses at a distance of the thickness. The upper one has the
/// offset `x` and falls with unit speed; its corners have the heights `tilt` above that.
fn plates(x: f64, tilt: [f64; 4], iteration: &str) -> Scene {
    let lower = square([1.0; 4]);
    let upper = lower
        .iter()
        .zip(tilt)
        .map(|(p, above)| mass([p.x[0] + x, p.x[1], THICK + above], [0.0, 0.0, -1.0], 1.0));
    let points: Vec<NodeRecord> = lower.iter().copied().chain(upper).collect();
    let slaves: Vec<u32> = (0..8).collect();
    let job = job("lagrange").with("iteration", iteration);
    Scene::new(&job, &points, &[[0, 1, 2, 3], [4, 5, 6, 7]], &slaves, 1e-3)
}

/// Each corner is the slave of a pair, but only one pair of two corners that face each other has a
/// force. The plates end with the common velocity.
#[test]
fn one_of_two_pairs_of_facing_nodes_has_a_force() {
    for iteration in ["split", "gauss_seidel"] {
        let mut scene = plates(0.0, [0.0; 4], iteration);
        scene.step();
        let corners = scene.pairs().iter().filter(|p| p.key.is_node());
        let forces: Vec<f64> = corners.map(|p| p.force.norm()).collect();
        assert_eq!(forces.len(), 8, "{iteration}");
        let expected = 0.5 / 1e-3; // each corner changes its velocity by 1/2 in a step of 1e-3
        let pressed = forces.iter().filter(|&&f| (f / expected - 1.0).abs() < 0.1).count();
        let forceless = forces.iter().filter(|&&f| f == 0.0).count();
        assert_eq!([pressed, forceless], [4, 4], "{iteration}: {forces:?}");
        for i in 0..8 {
            assert!((scene.v(i).z + 0.5).abs() < 1e-3, "{iteration}, node {i}: {}", scene.v(i).z);
        }
    }
}

/// At the first touch the deeper pair of the two has the force. The upper plate is warped, so that
/// the gaps of the two pairs differ.
#[test]
fn the_deeper_pair_has_the_force() {
    for iteration in ["split", "gauss_seidel"] {
        // Corners go down by more than this in a step, so all pairs are closed.
        let low = 1e-4 * THICK;
        let mut scene = plates(0.02, [0.0, low, 0.0, low], iteration);
        scene.step();
        let pairs: Vec<Pair> = scene.pairs().iter().filter(|p| p.key.is_node()).copied().collect();
        let mut compared = 0;
        for p in &pairs {
            let faced = p.nodes[1..5].iter().zip(&p.weight[1..5]).find(|(_, w)| **w > 0.7);
            let twin = faced.and_then(|(n, _)| pairs.iter().find(|q| q.nodes[0] == *n));
            let Some(twin) = twin.filter(|q| p.penetration > q.penetration + 2e-6 * THICK) else {
                continue;
            };
            assert!(p.force.norm() > 0.0 && twin.force.norm() == 0.0, "{iteration}: {p:?}");
            compared += 1;
        }
        assert!(compared > 0, "{iteration}: {pairs:?}");
    }
}

/// The pair that has the force keeps it, also if the other one is deeper in later steps.
#[test]
fn the_force_stays_with_its_pair() {
    for iteration in ["split", "gauss_seidel"] {
        let mut scene = warping(iteration);
        let first = pressing(&mut scene);
        assert_eq!(first.len(), 4, "{iteration}");
        for step in 1..6 {
            assert_eq!(pressing(&mut scene), first, "{iteration}, step {step}");
        }
    }
}

/// A pair without force that sinks too deep gets a force of its own. Strips of two segments each
/// are pressed together. The middle nodes face each other with weights of 0.9. One end of the lower
/// strip is pressed harder, so that the upper middle nodes sink.
#[test]
fn a_pair_that_sinks_gets_a_force() {
    for iteration in ["split", "gauss_seidel"] {
        let strip = |x: f64, z: f64| {
            (0..6).map(move |i| mass([x + f64::from(i % 3), f64::from(i / 3), z], [0.0; 3], 1.0))
        };
        let points: Vec<NodeRecord> = strip(0.0, 0.0).chain(strip(0.1, THICK)).collect();
        let segments = [0, 1, 6, 7].map(|i| [i, i + 1, i + 4, i + 3]);
        let slaves: Vec<u32> = (0..12).collect();
        let job = job("lagrange").with("iteration", iteration);
        let mut scene = Scene::new(&job, &points, &segments, &slaves, 1e-3);
        for i in 0..12 {
            scene.load[i].z = if i < 6 { 10.0 } else { -10.0 };
        }
        scene.step();
        for end in [2, 5] {
            scene.load[end].z = 100.0;
        }
        // Force and relative depth of the pair of a node.
        let state = |scene: &Scene, node: u32| {
            let is_of = |p: &&Pair| p.key.is_node() && p.nodes[0] == node;
            let pair = *scene.pairs().iter().find(is_of).expect("the node touches");
            (pair.force.norm(), pair.penetration / pair.contact_thickness)
        };
        let mut depth = 0.0;
        while depth < 0.01 {
            scene.step();
            let [lower, upper] = [1, 7].map(|node| state(&scene, node));
            assert!(upper.1 > depth, "{iteration}: {upper:?} does not sink from {depth}");
            depth = upper.1;
            let forced = [lower, upper].map(|(force, _)| force > 0.0);
            assert_eq!(forced[1], depth >= 0.01, "{iteration}: {upper:?}");
            assert!(forced[0] || forced[1], "{iteration}: {lower:?}, {upper:?}");
        }
        assert!(depth < 0.012, "{iteration}: {depth}");
        scene.step();
        assert!(state(&scene, 7).1 < depth, "{iteration}: the gap closes");
    }
}

/// Returns plates under loads that differ from corner to corner, so that they warp.
fn warping(iteration: &str) -> Scene {
    let low = 1e-4 * THICK;
    let mut scene = plates(0.02, [0.0, low, 0.0, low], iteration);
    for i in 0..8 {
        let load = 100.0 + 10.0 * (i % 3) as f64;
        scene.load[i].z = if i < 4 { load } else { -load };
    }
    scene
}

/// Makes a step, and returns the corners whose pairs have a force.
fn pressing(scene: &mut Scene) -> Vec<u32> {
    scene.step();
    let corners = scene.pairs().iter().filter(|p| p.key.is_node() && p.force.norm() > 0.0);
    corners.map(|p| p.nodes[0]).collect()
}

/// Nodes that face the inside of a segment are slaves of their own, whatever faces them.
#[test]
fn nodes_that_face_no_node_keep_their_pairs() {
    let mut scene = plates(0.7, [0.0; 4], "split");
    scene.step();
    let corners = scene.pairs().iter().filter(|p| p.key.is_node());
    let forces: Vec<f64> = corners.map(|p| p.force.norm()).collect();
    assert_eq!(forces.len(), 4, "two corners of either plate are within the other");
    assert!(forces.iter().all(|&f| f > 0.0), "{forces:?}");
}
