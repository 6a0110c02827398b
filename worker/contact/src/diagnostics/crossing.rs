//! Detection of edges that have gone through a surface without a contact. Nodes touch segments,
//! and exposed edges touch each other (`edges.rs`). An edge can still pass if it cuts into a
//! curved face between its nodes, or comes through where no fold is sharp enough. All edges of
//! the surface are checked for this from time to time, and crossings are reported. Where contact
//! uses the offsets of shells, both are compared at their middle surfaces.

use crate::folds::{Edge, EdgeTable};
use crate::geometry::project_edges;
use crate::search::{Search, accepted};
use crate::surface::{Segment, Surface};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{Row, V3};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::ElemId;

/// Distance of both ends of an edge from the face where it goes through, along the normal there,
/// above which it is a crossing, as a fraction of the segment's scale.
const THROUGH: f64 = 0.1;

/// An edge that goes through a segment and did not at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    /// Element of the edge.
    pub edge: ElemId,
    /// Element of the segment.
    pub surface: ElemId,
}

/// Returns the crossings of own edges in ascending order, each once. An edge is own if this worker
/// searches for its lowest segment. All edges of shells are checked, and the edges between two
/// faces of solids. The call is valid only when all nodes of the surface are at the same time, up
/// to one step.
pub fn crossings(surface: &Surface, nodes: &Nodes, time: f64, find: Search) -> Vec<Crossing> {
    let lines = EdgeTable::new(surface, nodes);
    let edges: Vec<&Edge> =
        lines.all.iter().filter(|e| lines.lowest_segment(e, surface).searched).collect();
    let half = |e: &&Edge| 0.5 * (e.ends(&nodes.x)[0] - e.ends(&nodes.x)[1]).norm();
    let longest = edges.iter().map(half).fold(0.0, f64::max);
    let middles: Vec<[f64; 3]> =
        edges.iter().map(|e| ((e.ends(&nodes.x)[0] + e.ends(&nodes.x)[1]) * 0.5).into()).collect();
    let grown = longest + surface.shift_reach();
    let boxes: Vec<Aabb> = surface.segments.iter().map(|s| s.bounds(&nodes.x, grown)).collect();
    let shifted = |e: &Edge, interface: u16, x: &[Row]| {
        let shift = lines.shift(e, (surface, interface), x);
        e.ends(x).map(|end| end + shift)
    };
    let through = |s: &Segment, e: &Edge, interface: u16, x: &[Row]| {
        let shift = surface.shift_of_segment(interface, s, x);
        let ([p, q], [a, b, c, d]) = (shifted(e, interface, x), s.corners(x).map(|q| q + shift));
        // An edge on a face, or with a penetration that contact permits, is no crossing.
        let deep = |(at, normal): (V3, V3)| {
            let [above, below] = [p - at, q - at].map(|end| end.dot(&normal).abs());
            above.min(below) > THROUGH * s.scale
        };
        if s.is_triangle() {
            return pierces(&p, &q, [&a, &b, &c]).is_some_and(deep);
        }
        pierces_patch(&p, &q, [&a, &b, &c, &d]).into_iter().flatten().any(deep)
    };
    // Edges in contact penetrate as nodes do. An edge that touches an edge of the segment is no
    // crossing.
    let meets = |e: &Edge| lines.is_exposed(e, surface, &nodes.x);
    let held = |s: &Segment, e: &Edge, interface: u16| {
        let sides = (0..4).map(|k| [s.nodes[k], s.nodes[(k + 1) % 4]]);
        let ascending = |[a, b]: [u32; 2]| {
            if nodes.id[a as usize] < nodes.id[b as usize] { [a, b] } else { [b, a] }
        };
        let of_segment = sides.filter_map(|n| lines.place(ascending(n))).map(|i| &lines.all[i]);
        let near = |o: &&Edge| {
            let passed =
                project_edges(&shifted(e, interface, &nodes.x), &shifted(o, interface, &nodes.x));
            passed.is_some_and(|p| p.height.abs() <= THROUGH * s.scale)
        };
        let mut near = of_segment.filter(near).peekable();
        near.peek().is_some() && meets(e) && near.any(meets)
    };
    let is_crossing = |g: u32, i: u32| {
        let (s, e) = (&surface.segments[g as usize], edges[i as usize]);
        let apart = !e.nodes.iter().any(|n| s.nodes.contains(n) || s.behind.contains(n));
        let touch = || {
            let parts = lines.segments(e).iter().map(|&g| surface.segments[g as usize].part);
            let interface = surface.interfaces.for_pair(parts, std::iter::once(s.part));
            interface.filter(|&i| surface.interfaces.is_alive(i, time))
        };
        let passed =
            |i: u16| through(s, e, i, &nodes.x) && !through(s, e, i, &nodes.x0) && !held(s, e, i);
        apart && touch().is_some_and(passed)
    };
    let crossing = |[g, i]: [u32; 2]| Crossing {
        edge: lines.lowest_segment(edges[i as usize], surface).id.elem(),
        surface: surface.segments[g as usize].id.elem(),
    };
    let found = accepted(find, &boxes, &middles, is_crossing);
    let mut found: Vec<Crossing> = found.into_iter().map(crossing).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Computes the point where the line from `p` to `q` goes through the inside of a triangle, with
/// the unit normal there (Moller & Trumbore 1997).
fn pierces(p: &V3, q: &V3, [a, b, c]: [&V3; 3]) -> Option<(V3, V3)> {
    let (along, e1, e2) = (q - p, b - a, c - a);
    let h = along.cross(&e2);
    let det = e1.dot(&h);
    if det == 0.0 {
        return None;
    }
    let from = (p - a) / det;
    let u = from.dot(&h);
    let k = from.cross(&e1);
    let (v, t) = (along.dot(&k), e2.dot(&k));
    let inside = u > 0.0 && v > 0.0 && u + v < 1.0 && t > 0.0 && t < 1.0;
    inside.then(|| (p + along * t, e1.cross(&e2).normalize()))
}

/// Computes the points where the line from `p` to `q` goes through the inside of the bilinear
/// patch that a quad is in contact, with the unit normals there. In each of two planes that
/// contain the line, `S(u, v) = a + u (b - a) + v (d - a) + u v (a - b + c - d)` gives an
/// equation `k_0 + k_1 u + k_2 v + k_3 u v = 0`. Elimination of v gives a quadratic equation for
/// u (Ramsey, Potter & Hansen 2004). Two triangles would be the same where the quad is flat.
/// Where its corners lie h off its plane, two triangles are up to h off the patch.
fn pierces_patch(p: &V3, q: &V3, [a, b, c, d]: [&V3; 4]) -> [Option<(V3, V3)>; 2] {
    let (along, by_u, by_v, by_uv) = (q - p, b - a, d - a, a - b + c - d);
    let across = along.cross(&V3::ith(along.iamin(), 1.0));
    let of_plane = |n: &V3| [a - p, by_u, by_v, by_uv].map(|k| k.dot(n));
    let (k, l) = (of_plane(&across), of_plane(&along.cross(&across)));
    let minor = |i: usize, j: usize| k[i] * l[j] - k[j] * l[i];
    let roots = roots(minor(1, 3), minor(0, 3) + minor(1, 2), minor(0, 2));
    roots.map(|root| {
        let u = root?;
        // Use the plane whose equation determines v better.
        let [(k_over, k_under), (l_over, l_under)] =
            [k, l].map(|m| (m[0] + m[1] * u, m[2] + m[3] * u));
        let v = if k_under.abs() > l_under.abs() { -k_over / k_under } else { -l_over / l_under };
        let at = a + by_u * u + by_v * v + by_uv * (u * v);
        let t = (at - p).dot(&along) / along.norm_squared();
        let inside = [u, v, t].iter().all(|&x| x > 0.0 && x < 1.0);
        inside.then(|| (at, (by_u + by_uv * v).cross(&(by_v + by_uv * u)).normalize()))
    })
}

/// Returns the real roots of `a x^2 + b x + c`.
fn roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let under = b * b - 4.0 * a * c;
    if under < 0.0 {
        return [None; 2];
    }
    let most = -0.5 * (b + under.sqrt().copysign(b));
    [(most, a), (c, most)].map(|(over, under)| (under != 0.0).then(|| over / under))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_a_triangle_and_lines_that_miss() {
        let (a, b, c) = (V3::zeros(), V3::x(), V3::y());
        let hits = |p: V3, q: V3| pierces(&p, &q, [&a, &b, &c]).is_some();
        assert!(hits(V3::new(0.2, 0.2, -1.0), V3::new(0.3, 0.3, 2.0)));
        assert!(!hits(V3::new(0.2, 0.2, 0.5), V3::new(0.3, 0.3, 2.0)), "ends before the face");
        assert!(!hits(V3::new(0.8, 0.8, -1.0), V3::new(0.8, 0.8, 1.0)), "outside the face");
        assert!(!hits(V3::new(0.2, 0.2, 0.0), V3::new(0.4, 0.2, 0.0)), "in the plane of the face");
    }

    /// A quad with two opposite corners up and two down is the saddle `z = x y`: its diagonals
    /// are on it, no triangle is.
    #[test]
    fn a_line_goes_through_a_warped_quad_where_that_is() {
        let corner = |x: f64, y: f64| V3::new(x, y, x * y);
        let [a, b, c, d] =
            [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let hits = |p: V3, q: V3| pierces_patch(&p, &q, [&a, &b, &c, &d]);
        let found = |hits: [Option<(V3, V3)>; 2]| -> Vec<V3> {
            hits.into_iter().flatten().map(|(at, _)| at).collect()
        };
        let one = found(hits(V3::new(0.3, -0.4, -2.0), V3::new(0.3, -0.4, 1.0)));
        assert!(one.len() == 1 && (one[0] - corner(0.3, -0.4)).norm() < 1e-12, "{one:?}");
        let (_, normal) = hits(V3::new(0.0, 0.0, -1.0), V3::new(0.0, 0.0, 1.0))
            .into_iter()
            .flatten()
            .next()
            .unwrap();
        assert!((normal.z.abs() - 1.0).abs() < 1e-12);
        // Both triangles of the cut from a to c lie above the saddle there.
        assert!(found(hits(V3::new(0.5, -0.5, 0.9), V3::new(0.4, -0.4, 0.1))).is_empty());
        assert!(
            pierces(&V3::new(0.5, -0.5, 0.9), &V3::new(0.4, -0.4, 0.1), [&a, &b, &c]).is_some()
        );
        // Along the diagonal x = -y the saddle is z = -x^2: a level line goes through it twice.
        let two = found(hits(V3::new(-0.9, 0.9, -0.25), V3::new(0.9, -0.9, -0.25)));
        assert_eq!(two.len(), 2);
        assert!(
            two.iter().all(|at| (at.x.abs() - 0.5).abs() < 1e-12 && (at.z + 0.25).abs() < 1e-12),
            "{two:?}"
        );
        assert!(
            found(hits(V3::new(1.2, 0.3, -2.0), V3::new(1.2, 0.3, 2.0))).is_empty(),
            "outside the face"
        );
    }
}
