//! Tests of the first touch of a moving point and a moving segment: closed forms, and many random
//! cases against a fine sampling in time.

use super::*;
use crate::geometry::nearest;
use nalgebra::Rotation3;

/// Returns the motion from one place to another.
fn path(from: [f64; 3], to: [f64; 3]) -> NodePath {
    NodePath { from: from.into(), by: V3::from(to) - V3::from(from) }
}

/// Returns the corners of the unit square in its plane z = 0 that move to these heights.
fn lifted(to: [f64; 4]) -> [NodePath; 4] {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    std::array::from_fn(|k| {
        let [x, y] = corners[k];
        path([x, y, 0.0], [x, y, to[k]])
    })
}

/// Returns a random number from -1 to 1; splitmix64.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn random_vector(state: &mut u64) -> V3 {
    V3::from_fn(|_, _| random(state))
}

fn at(of: &NodePath, time: f64) -> V3 {
    of.from + of.by * time
}

/// Returns the point of the segment in an impact.
fn point(q: &[NodePath; 4], found: &Impact) -> V3 {
    q.iter().zip(found.shape).map(|(q, n)| at(q, found.time) * n).sum()
}

fn assert_impact(found: Option<Impact>, time: f64, shape: [f64; 4], case: &str) -> Impact {
    let found = found.unwrap_or_else(|| panic!("{case}: no impact"));
    assert!((found.time - time).abs() < 1e-14, "{case}: {} instead of {time}", found.time);
    let off = found.shape.iter().zip(shape).map(|(n, m)| (n - m).abs()).fold(0.0, f64::max);
    assert!(off < 1e-14, "{case}: {:?} instead of {shape:?}", found.shape);
    found
}

/// A face that turns about one of its edges has z = w x t; a node at (x, y) with z = h - v t meets
/// it at t = h / (v + w x).
#[test]
fn a_rotating_face_is_met_where_it_is_then() {
    let (h, v, w) = (0.4, 0.25, 0.8);
    for (x, y) in [(0.5, 0.25), (0.9, 0.1), (0.3, 0.6)] {
        let node = path([x, y, h], [x, y, h - v]);
        let time = h / (v + w * x);
        let face = lifted([0.0, w, w, 0.0]);
        let shape = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
        let case = format!("quad at {x}, {y}");
        let found = first_crossing(&node, &face, false);
        if time > 1.0 {
            assert!(found.is_none(), "{case}: {found:?}");
            continue;
        }
        let normal = assert_impact(found, time, shape, &case).normal;
        let expected = V3::new(-w * time, 0.0, 1.0).normalize();
        assert!((normal - expected).norm() < 1e-14, "{case}: normal {normal}");
        let triangle = [face[0], face[1], face[3], face[3]];
        let case = format!("triangle at {x}, {y}");
        let found = first_crossing(&node, &triangle, true);
        assert_impact(found, time, [1.0 - x - y, x, y, 0.0], &case);
    }
}

/// A tilted face and a node translate: t = n.(q - p) / n.(dp - dq), whatever the scale and the
/// attitude.
#[test]
fn a_translating_tilted_face_is_met_at_any_scale() {
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let (a, b, time) = (0.3, 0.65, 0.37);
    let shape = [(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b];
    let (drift, speed) = (V3::new(0.2, -0.1, 0.3), V3::new(-0.4, 0.3, -1.1));
    for exponent in -9..=9 {
        let scale = 10f64.powi(exponent);
        let face = lifted([0.0; 4])
            .map(|c| NodePath { from: turn * c.from * scale, by: turn * drift * scale });
        // The node is at the point (a, b) of the face at the given time.
        let met: V3 = face.iter().zip(shape).map(|(q, n)| at(q, time) * n).sum();
        let by = turn * speed * scale;
        let node = NodePath { from: met - by * time, by };
        let found = first_crossing(&node, &face, false);
        let found = assert_impact(found, time, shape, &format!("scale 1e{exponent}"));
        assert!((found.normal - turn * V3::z()).norm() < 1e-14);
    }
}

/// A quad that warps during the step has z = a b t.
#[test]
fn a_face_that_warps_is_met_on_its_bilinear_surface() {
    let (x, y, h, v) = (0.75, 0.5, 0.5, 0.625);
    let node = path([x, y, h], [x, y, h - v]);
    let shape = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
    let found = first_crossing(&node, &lifted([0.0, 0.0, 1.0, 0.0]), false);
    let time = h / (v + x * y);
    let normal = assert_impact(found, time, shape, "warped").normal;
    let expected = V3::new(-y * time, -x * time, 1.0).normalize();
    assert!((normal - expected).norm() < 1e-14, "{normal}");
}

/// Over the diagonal of the surface z = x y at rest, a node that moves along x = -y has the height
/// z + x^2 above it. It grazes for z = 0, is too high for z > 0, and crosses at x = -sqrt(-z).
#[test]
fn a_node_that_grazes_a_face_is_found() {
    let corner = |x: f64, y: f64| path([x, y, x * y], [x, y, x * y]);
    let saddle = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let graze = |z: f64| {
        first_crossing(&path([-0.5, 0.5, z], [0.5, -0.5, z]), &saddle, false).map(|i| i.time)
    };
    // A double root has half of the digits.
    let time = graze(0.0).expect("it touches");
    assert!((time - 0.5).abs() < 1e-6, "{time}");
    assert_eq!(graze(1e-9), None, "above");
    let time = graze(-1e-9).expect("it crosses twice");
    assert!((time - (0.5 - 1e-9f64.sqrt())).abs() < 1e-9, "the first of two: {time}");
}

/// Touches at the start, at the end and on the border belong to the step and to the face; touches
/// beyond by more than round-off do not.
#[test]
fn ends_of_the_step_and_borders_of_the_face_count() {
    let face = lifted([0.0; 4]);
    let from = |x: f64, y: f64, z: f64| {
        first_crossing(&path([x, y, z], [x, y, z - 1.0]), &face, false).map(|i| i.time)
    };
    assert_eq!(from(0.5, 0.5, 0.0), Some(0.0), "at the start");
    assert_eq!(from(0.5, 0.5, 1.0), Some(1.0), "at the end");
    assert_eq!(from(0.5, 0.5, -1e-9), None, "before the start");
    assert_eq!(from(0.5, 0.5, 1.0 + 1e-9), None, "after the end");
    for (x, y) in [(0.0, 0.5), (1.0, 0.25), (0.5, 0.0), (0.25, 1.0), (0.0, 0.0), (1.0, 1.0)] {
        assert_eq!(from(x, y, 0.5), Some(0.5), "on the border at {x}, {y}");
        let outside = |x: f64| x + (x - 0.5).signum() * 1e-9;
        assert_eq!(from(outside(x), outside(y), 0.5), None, "outside of {x}, {y}");
    }
    let triangle = [face[0], face[1], face[3], face[3]];
    let over = |x: f64, y: f64| {
        first_crossing(&path([x, y, 0.5], [x, y, -0.5]), &triangle, true).map(|i| i.time)
    };
    assert_eq!(over(0.5, 0.5), Some(0.5), "on the long side of a triangle");
    assert_eq!(over(0.5, 0.5 + 1e-9), None, "outside the long side");
}

/// A node that passes through the common edge of two faces meets at least one of them, with any
/// round-off.
#[test]
fn no_node_passes_between_two_faces() {
    let mut state = 7;
    for case in 0..2000 {
        let corner: [NodePath; 6] = std::array::from_fn(|k| {
            let place = V3::new((k % 3) as f64, (k / 3) as f64, 0.0);
            let from = place + random_vector(&mut state) * 0.2;
            NodePath { from, by: random_vector(&mut state) * 0.2 }
        });
        let [a, b, c, d, e, f] = corner;
        let along = 0.5 + 0.5 * random(&mut state);
        let time = 0.5 + 0.5 * random(&mut state);
        let met = at(&b, time) * (1.0 - along) + at(&e, time) * along;
        let by = random_vector(&mut state) - V3::z() * 1.5;
        let node = NodePath { from: met - by * time, by };
        let quads = [[a, b, e, d], [b, c, f, e]].map(|q| first_crossing(&node, &q, false));
        let triangles = [[a, b, e, e], [b, c, e, e]].map(|q| first_crossing(&node, &q, true));
        for (found, what) in [(quads, "quads"), (triangles, "triangles")] {
            let least = found.iter().flatten().map(|i| i.time).fold(f64::INFINITY, f64::min);
            assert!(least <= time + 1e-9, "case {case}, {what}: {found:?}, expected {time}");
        }
    }
}

/// Returns the height of a node above the nearest point of a face at a time, if that point lies
/// inside the face. On a strongly warped quad the projection of a far node may not converge; then
/// the node is not above the point.
fn height(p: &NodePath, q: &[NodePath; 4], triangle: bool, time: f64) -> Option<f64> {
    let p = at(p, time);
    let near = nearest(&p, &q.map(|c| at(&c, time)), triangle).filter(|near| !near.rim)?;
    let height = (p - near.point).dot(&near.normal);
    (p - near.point - near.normal * height).norm().lt(&1e-6).then_some(height)
}

/// Returns a time at which a node crosses the inside of a face by bisection of an interval in which
/// its height changes its sign; `None` if the height jumps instead, or the node leaves the face.
fn crossing_by_bisection(
    height: impl Fn(f64) -> Option<f64>,
    [mut low, mut high]: [f64; 2],
) -> Option<f64> {
    let sign = height(low)?.signum();
    if height(high)?.signum() == sign {
        return None;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let same = height(middle)?.signum() == sign;
        if same { low = middle } else { high = middle }
    }
    (height(low)?.abs() < 1e-9).then_some(low)
}

/// In 1e5 random cases each impact is one, to round-off, and it is the first: a sampling with 48
/// intervals finds no crossing that is missed or earlier.
#[test]
fn random_impacts_are_neither_missed_nor_false() {
    const CASES: usize = 100_000;
    const SAMPLES: usize = 48;
    let mut state = 1;
    let (mut hits, mut misses) = (0, 0);
    for case in 0..CASES {
        let triangle = case % 3 == 0;
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mut face: [NodePath; 4] = std::array::from_fn(|k| {
            let from = V3::new(square[k][0], square[k][1], 0.0) + random_vector(&mut state) * 0.4;
            NodePath { from, by: random_vector(&mut state) }
        });
        if triangle {
            face[3] = face[2];
        }
        let node = NodePath {
            from: random_vector(&mut state) + V3::z() * 0.5,
            by: random_vector(&mut state) - V3::z(),
        };
        let found = first_crossing(&node, &face, triangle);
        if let Some(found) = found {
            hits += 1;
            let off = (point(&face, &found) - at(&node, found.time)).norm();
            assert!(off < 1e-13, "case {case}: false by {off}");
            let is_in = found.shape.iter().all(|n| (0.0..=1.0).contains(n));
            let sum: f64 = found.shape.iter().sum();
            assert!(is_in && (sum - 1.0).abs() < 1e-14, "case {case}: {:?}", found.shape);
            assert!((0.0..=1.0).contains(&found.time), "case {case}");
        } else {
            misses += 1;
        }
        // Up to shortly before the impact.
        let until = found.map_or(1.0, |i| i.time * (1.0 - 1e-6));
        let times: [f64; SAMPLES + 1] = std::array::from_fn(|k| until * k as f64 / SAMPLES as f64);
        let above = |time: f64| height(&node, &face, triangle, time);
        let heights = times.map(above);
        for k in 0..SAMPLES {
            let (Some(was), Some(is)) = (heights[k], heights[k + 1]) else { continue };
            if was.signum() != is.signum() {
                let crossed = crossing_by_bisection(above, [times[k], times[k + 1]]);
                assert!(crossed.is_none(), "case {case}: found {found:?}, it is at {crossed:?}");
            }
        }
    }
    assert!(hits > CASES / 10 && misses > CASES / 10, "{hits} hits, {misses} misses");
}

/// The signed volume of a node and a moving triangle is a cubic in time. Its first root with the
/// node inside, found by bisection in the monotone pieces, is the time of the impact.
#[test]
fn impacts_on_triangles_are_roots_of_the_cubic() {
    let mut state = 3;
    let mut compared = 0;
    for case in 0..20_000 {
        let mut corner = || NodePath {
            from: random_vector(&mut state) * 1.5,
            by: random_vector(&mut state) * 2.0,
        };
        let (a, b, c) = (corner(), corner(), corner());
        let node = corner();
        let relative = |time: f64| [&a, &b, &c].map(|q| at(q, time) - at(&node, time));
        let volume = |time: f64| {
            let [a, b, c] = relative(time);
            a.dot(&b.cross(&c))
        };
        // Coefficients from four values, then the roots of the derivative.
        let [v0, v1, v2, v3] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(volume);
        let cubic = (9.0 * (v3 - v0) - 27.0 * (v2 - v1)) / 2.0;
        let square = (18.0 * v0 - 45.0 * v1 + 36.0 * v2 - 9.0 * v3) / 2.0;
        let linear = (-11.0 * v0 + 18.0 * v1 - 9.0 * v2 + 2.0 * v3) / 2.0;
        let root = (square * square - 3.0 * cubic * linear).max(0.0).sqrt();
        let mut pieces = vec![0.0, 1.0];
        pieces.extend([-1.0, 1.0].map(|s| (-square + s * root) / (3.0 * cubic)));
        pieces.retain(|t| (0.0..=1.0).contains(t));
        pieces.sort_by(f64::total_cmp);
        let mut first = None;
        for piece in pieces.windows(2) {
            let [mut low, mut high] = [piece[0], piece[1]];
            if volume(low) * volume(high) > 0.0 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let same = volume(low) * volume(middle) > 0.0;
                if same { low = middle } else { high = middle }
            }
            let [a, b, c] = relative(low);
            let normal = (b - a).cross(&(c - a));
            let shares = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|s| s.dot(&normal));
            if shares.iter().all(|&s| s >= 0.0) {
                first = Some(low);
                break;
            }
        }
        let found = first_crossing(&node, &[a, b, c, c], true).map(|i| i.time);
        let agree = match (first, found) {
            (Some(expected), Some(found)) => (expected - found).abs() < 1e-8,
            (None, None) => true,
            _ => false,
        };
        assert!(agree, "case {case}: {found:?}, by the cubic {first:?}");
        compared += usize::from(found.is_some());
    }
    assert!(compared > 500, "{compared} impacts");
}

/// A node within the plane of a face has no defined time, but the search ends.
#[test]
fn a_node_that_moves_within_the_face_ends_the_search() {
    let face = lifted([0.0; 4]);
    let _ = first_crossing(&path([-0.5, 0.5, 0.0], [1.5, 0.6, 0.0]), &face, false);
    let _ = first_crossing(&path([0.5, 0.5, 0.0], [0.5, 0.5, 0.0]), &face, false);
    let above = first_crossing(&path([-0.5, 0.5, 1e-9], [1.5, 0.6, 1e-9]), &face, false);
    assert!(above.is_none(), "{above:?}");
}

/// With a thickness the touch is at that distance from the moving face, along its normal, and no
/// earlier: the distance by the nearest point is larger until then.
#[test]
fn a_thick_face_is_touched_at_its_thickness() {
    let mut state = 11;
    let (thick, mut touched) = (0.1, 0);
    for case in 0..2000 {
        let triangle = case % 2 == 0;
        let mut face = lifted([0.0; 4]).map(|c| NodePath {
            from: c.from + random_vector(&mut state) * 0.05,
            by: random_vector(&mut state) * 0.2,
        });
        if triangle {
            face[3] = face[2];
        }
        let spread = 0.3 * V3::new(random(&mut state), random(&mut state), 0.0);
        let side = if case % 4 < 2 { 1.0 } else { -1.0 };
        let node = NodePath {
            from: V3::new(0.6, 0.4, 0.3 * side) + spread,
            by: random_vector(&mut state) * 0.1 - V3::z() * 0.3 * side,
        };
        let found = first_touch(&node, (&face, triangle), V3::z() * side, |_| thick);
        let Some(found) = found else { continue };
        touched += 1;
        let apart = at(&node, found.time) - point(&face, &found);
        assert!((apart - found.normal * thick).norm() < 1e-9, "case {case}: {apart}");
        assert!(found.normal.z * side > 0.0, "case {case}: on the side of the node");
        for sample in 0..50 {
            let time = found.time * 0.999 * f64::from(sample) / 50.0;
            let corners = face.map(|c| at(&c, time));
            let near = nearest(&at(&node, time), &corners, triangle).expect("it has area");
            let distance = (at(&node, time) - near.point).norm();
            assert!(distance > thick, "case {case}: already {distance} at {time}");
        }
    }
    assert!(touched > 500, "{touched} touches");
}
