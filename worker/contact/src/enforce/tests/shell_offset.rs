//! Contact at the middle surface of shells with an offset: distances against closed forms.

use super::*;

/// Offset of a plate, and the sign of its normal along z.
#[derive(Clone, Copy, Debug)]
struct Side {
    offset: f64,
    up: bool,
}

impl Side {
    /// Returns the height of the middle surface above the nodes.
    fn height(self) -> f64 {
        if self.up { self.offset } else { -self.offset }
    }

    fn corners(self, [a, b, c, d]: [u32; 4]) -> [u32; 4] {
        if self.up { [a, b, c, d] } else { [a, d, c, b] }
    }
}

/// Returns all combinations of signs of the offsets and of orientations of the normals.
fn combinations() -> Vec<[Side; 2]> {
    let sides = [(0.8, true), (0.8, false), (-0.8, true), (-0.8, false), (0.0, true), (-2.0, true)]
        .map(|(of_half, up)| Side { offset: of_half * HALF, up });
    sides.iter().flat_map(|&a| sides.iter().map(move |&b| [a, b])).collect()
}

/// Returns the distance of the nodes of a lower and an upper plate at which they touch.
fn touching([low, high]: [Side; 2]) -> f64 {
    THICK + low.height() - high.height()
}

fn with_offsets(of: &ContactInput) -> ContactInput {
    ContactInput { shell_offset: true, ..of.clone() }
}

/// Returns two squares, the upper one smaller and with a velocity, at a distance `apart` of their
/// nodes.
fn plates(of: &ContactInput, sides: [Side; 2], apart: f64, v: [f64; 3]) -> Scene {
    let upper = square([1.0; 4]).into_iter().map(|p| {
        let [x, y, _] = p.x;
        NodeRecord { inertia: 0.01, ..mass([0.5 * x + 0.1, 0.5 * y, apart], v, 1.0) }
    });
    let lower = square([2.0; 4]).into_iter().map(|p| NodeRecord { inertia: 0.01, ..p });
    let points: Vec<NodeRecord> = lower.chain(upper).collect();
    let segments = [sides[0].corners([0, 1, 2, 3]), sides[1].corners([4, 5, 6, 7])];
    let offsets = sides.map(|s| s.offset);
    Scene::with_offsets(of, &points, &segments, &offsets, &[0, 1, 2, 3, 4, 5, 6, 7], 1e-3)
}

fn laws() -> Vec<(String, ContactInput)> {
    let mut laws = all_laws();
    laws.push(("mortar".into(), job("mortar")));
    laws.into_iter().map(|(name, of)| (name, with_offsets(&of))).collect()
}

/// Penetration and normal of all pairs, with every law; nothing just above the distance at which
/// pairs become active. Without the option the nodes are at their distance.
#[test]
fn plates_touch_at_their_middle_surfaces_for_all_signs_and_normals() {
    for (name, of) in laws() {
        for sides in combinations() {
            let label = format!("{name} {sides:?}");
            let depth = 1e-3 * THICK;
            let mut scene = plates(&of, sides, touching(sides) - depth, [0.0; 3]);
            scene.step();
            assert!(scene.pairs().len() >= 4, "{label}: {} pairs", scene.pairs().len());
            for p in scene.pairs() {
                assert!((p.penetration - depth).abs() < 1e-14, "{label}: {}", p.penetration);
                assert!((p.normal.z.abs() - 1.0).abs() < 1e-14, "{label}: {}", p.normal);
            }
            let mut open = plates(&of, sides, touching(sides) + 0.05 * THICK, [0.0; 3]);
            open.step();
            assert!(open.pairs().is_empty(), "{label}: pairs at a gap above the active one");
            let plain = ContactInput { shell_offset: false, ..of.clone() };
            let mut scene = plates(&plain, sides, THICK - depth, [0.0; 3]);
            scene.step();
            assert!(
                !scene.pairs().is_empty()
                    && scene.pairs().iter().all(|p| (p.penetration - depth).abs() < 1e-14),
                "{label}: contact at the nodes"
            );
        }
    }
}

/// Runs a plate that flies at another one. Returns the scene at the end and the smallest distance
/// of the plates.
fn fly(of: &ContactInput, sides: [Side; 2], apart: f64) -> (Scene, f64) {
    let mut scene = plates(of, sides, apart, [0.4, 0.1, -2.0]);
    let (mut nearest, mut touched) = (f64::INFINITY, false);
    for _ in 0..60 {
        scene.step();
        let of = |range: std::ops::Range<usize>| range.map(|i| scene.x(i).z);
        nearest = nearest.min(0.25 * (of(4..8).sum::<f64>() - of(0..4).sum::<f64>()));
        touched |= scene.pairs().iter().any(|p| p.force.norm() > 0.0);
    }
    assert!(touched, "no force in {of:?} {sides:?}");
    (scene, nearest)
}

/// A plate that flies at another one comes as near to the distance of the closed form as plates
/// without offsets do to theirs. Both momenta stay, with and without friction.
#[test]
fn plates_that_fly_at_each_other_stop_at_their_middle_surfaces() {
    let turning = |scene: &Scene| {
        let spins = scene.nodes.inertia.iter().zip(&scene.nodes.w);
        scene.spin() + spins.map(|(i, w)| V3::from(xyz(w)) * *i).sum::<V3>()
    };
    for (name, of) in laws().into_iter().filter(|(_, of)| of.weighting != "mass") {
        let flat = Side { offset: 0.0, up: true };
        let wanted = fly(&of, [flat; 2], 1.5 * THICK).1 - THICK;
        for sides in combinations() {
            for friction in [0.0, 0.3] {
                let label = format!("{name} {sides:?} friction {friction}");
                let of = ContactInput { friction, ..of.clone() };
                let start = touching(sides) + 0.5 * THICK;
                let before = plates(&of, sides, start, [0.4, 0.1, -2.0]);
                let (scene, nearest) = fly(&of, sides, start);
                let depth = nearest - touching(sides);
                // Friction rotates the nodes and acts with another lever arm. Sweeps leave up to
                // 1e-6 of a velocity (`tolerance`): 2e-8 of the thickness in a step.
                if friction == 0.0 {
                    assert!((depth - wanted).abs() < 1e-6 * THICK, "{label}: {depth}, {wanted}");
                }
                let size = before.momentum().norm();
                let moved = (scene.momentum() - before.momentum()).norm() / size;
                let turned = (turning(&scene) - turning(&before)).norm() / size;
                assert!(moved < 1e-12 && turned < 1e-12, "{label}: {moved:e} {turned:e}");
            }
        }
    }
}

/// Two strips cross with their rims only: no node of one is over the other.
#[test]
fn edges_touch_at_their_middle_surfaces() {
    let strip = |along: usize, z: f64| {
        [[-2.0, -0.2], [2.0, -0.2], [2.0, 0.2], [-2.0, 0.2]].map(|[a, b]| {
            let [x, y] = if along == 0 { [a, b] } else { [b, -a] };
            mass([x, y, z], [0.0; 3], 1.0)
        })
    };
    for (name, of) in laws() {
        for sides in combinations() {
            let depth = 1e-3 * THICK;
            let run = |apart: f64| {
                let points = [strip(0, 0.0), strip(1, apart)].concat();
                let segments = [sides[0].corners([0, 1, 2, 3]), sides[1].corners([4, 5, 6, 7])];
                let offsets = sides.map(|s| s.offset);
                let slaves = [0, 1, 2, 3, 4, 5, 6, 7];
                let mut scene =
                    Scene::with_offsets(&of, &points, &segments, &offsets, &slaves, 1e-3);
                scene.step();
                scene
            };
            let scene = run(touching(sides) - depth);
            let edges: Vec<&Pair> = scene.pairs().iter().filter(|p| p.key.is_edge()).collect();
            assert_eq!(edges.len(), 4, "{name} {sides:?}: four crossings");
            for p in edges {
                assert!((p.penetration - depth).abs() < 1e-14, "{name} {sides:?}: {p:?}");
            }
            assert!(run(touching(sides) + 0.05 * THICK).pairs().is_empty(), "{name} {sides:?}");
        }
    }
}

/// A loaded node slides over two segments, the second one with its corners in the other sense and
/// its offset with the other sign. Its force stays that of the load.
#[test]
fn a_node_passes_to_the_next_segment_without_a_jump_of_force() {
    for offset in [0.8, -0.8, 2.0] {
        let points: Vec<NodeRecord> = [-1.0, 1.0, 3.0]
            .iter()
            .flat_map(|&x| [[x, -1.0, 0.0], [x, 1.0, 0.0]].map(held))
            .chain([mass([0.9, 0.1, THICK + offset * HALF], [4.0, 0.0, 0.0], 1.0)])
            .collect();
        let segments = [[0, 2, 3, 1], [2, 3, 5, 4]];
        let offsets = [offset * HALF, -offset * HALF];
        let of = with_offsets(&job("lagrange"));
        let mut scene = Scene::with_offsets(&of, &points, &segments, &offsets, &[6], 1e-3);
        scene.load[6] = V3::new(0.0, 0.0, -50.0);
        for step in 0..60 {
            scene.step();
            let force: f64 = scene.pairs().iter().map(|p| p.force.dot(&V3::z())).sum();
            assert!((force / 50.0 - 1.0).abs() < 1e-6, "offset {offset}, step {step}: {force}");
        }
        assert!(scene.x(6).x > 1.1, "it is over the second segment");
        let rest = scene.x(6).z - THICK - offset * HALF;
        assert!(rest.abs() < 1e-6 * THICK, "offset {offset}: moved by {rest} across");
    }
}

/// Around a fold of 12 degrees the smallest gap changes by no more than the node moves.
#[test]
fn the_gap_has_no_jump_at_a_fold() {
    let angle = 12.0f64.to_radians();
    for offset in [0.8, -0.8] {
        let (c, s) = (angle.cos(), angle.sin());
        let corners = [[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
        let points = corners.into_iter().chain([[c, -1.0, -s], [c, 1.0, -s]]);
        let radius = THICK + offset * HALF - 0.02 * THICK;
        let gap = |turn: f64| {
            let at = [radius * turn.sin(), 0.0, radius * turn.cos()];
            let all: Vec<NodeRecord> =
                points.clone().map(held).chain([mass(at, [0.0; 3], 1.0)]).collect();
            let segments = [[0, 2, 3, 1], [2, 4, 5, 3]];
            let of = with_offsets(&job("lagrange"));
            let mut scene =
                Scene::with_offsets(&of, &all, &segments, &[offset * HALF; 2], &[6], 1e-3);
            scene.step();
            scene.pairs().iter().map(|p| -p.penetration).fold(f64::INFINITY, f64::min)
        };
        let count = 200;
        let gaps: Vec<f64> = (0..=count)
            .map(|k| gap(angle * (2.0 * f64::from(k) / f64::from(count) - 0.5)))
            .collect();
        let path = radius * angle * 2.0 / f64::from(count);
        for (k, pair) in gaps.windows(2).enumerate() {
            let change = (pair[1] - pair[0]).abs();
            assert!(change <= 1.001 * path, "offset {offset}, place {k}: {change} over {path}");
        }
    }
}

/// The shift of a node of two segments at a right angle lies on both middle surfaces, whatever
/// the senses of their normals.
#[test]
fn a_corner_lies_on_both_middle_surfaces() {
    let points: Vec<NodeRecord> = [
        [-1.0, -1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, -1.0],
        [0.0, 1.0, -1.0],
    ]
    .map(held)
    .into();
    let of = with_offsets(&job("lagrange"));
    for (segments, offsets) in [
        ([[0, 2, 3, 1], [2, 4, 5, 3]], [0.7 * HALF, 0.7 * HALF]),
        ([[0, 2, 3, 1], [2, 3, 5, 4]], [0.7 * HALF, -0.7 * HALF]),
    ] {
        let slaves = [0, 1, 2, 3, 4, 5];
        let scene = Scene::with_offsets(&of, &points, &segments, &offsets, &slaves, 1e-3);
        let shift = scene.contact.surface.shift_of_slave(0, 2, &scene.nodes.x);
        let wanted = V3::new(0.7 * HALF, 0.0, 0.7 * HALF);
        assert!((shift - wanted).norm() < 1e-15, "{shift}");
    }
}

/// A node next to the rim of a segment, a little below its plane, with a shift upwards: its
/// distance is that from the rim.
#[test]
fn a_node_next_to_a_rim_is_not_in_the_segment() {
    let of = with_offsets(&job("lagrange"));
    for height in [-0.01 * HALF, 0.01 * HALF] {
        let next_to = [[1.0, -0.5], [3.0, -0.5], [3.0, 0.5], [1.0, 0.5]]
            .map(|[x, y]| held([x + 0.95 * THICK, y, height]));
        let points: Vec<NodeRecord> = square([1.0; 4]).into_iter().chain(next_to).collect();
        let segments = [[0, 1, 2, 3], [4, 5, 6, 7]];
        let slaves = [0, 1, 2, 3, 4, 5, 6, 7];
        let mut scene =
            Scene::with_offsets(&of, &points, &segments, &[0.0, 0.5 * HALF], &slaves, 1e-3);
        scene.step();
        let of_nodes: Vec<&Pair> = scene.pairs().iter().filter(|p| p.nodes[0] >= 4).collect();
        assert_eq!(of_nodes.len(), 2, "both corners are next to the rim");
        for p in of_nodes {
            // The shift is almost perpendicular to the normal.
            assert!((p.penetration / THICK - 0.05).abs() < 0.01, "{height}: {}", p.penetration);
            assert!(p.normal.x > 0.99, "{height}: {}", p.normal);
        }
    }
}

/// Three segments around a node, two at about a right angle: the shift has no jump when this angle
/// passes 90 degrees.
#[test]
fn the_shift_has_no_jump_when_an_angle_passes_a_right_angle() {
    let of = with_offsets(&job("lagrange"));
    let shift = |angle: f64| {
        // Segments about the y axis; their directions from it turn downwards.
        let arm = |degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            [[c, 0.0, -s], [c, 1.0, -s]].map(held)
        };
        let axis = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(held);
        let points = [axis, arm(0.0), arm(angle), arm(40.0)].concat();
        let segments = [[0, 2, 3, 1], [0, 4, 5, 1], [0, 6, 7, 1]];
        let scene = Scene::with_offsets(&of, &points, &segments, &[0.7 * HALF; 3], &[0], 1e-3);
        scene.contact.surface.shift_of_slave(0, 0, &scene.nodes.x)
    };
    let change = (shift(90.0 + 1e-6) - shift(90.0 - 1e-6)).norm();
    assert!(change < 1e-7 * HALF, "two millionths of a degree change it by {change}");
}
