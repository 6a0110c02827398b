//! Edges that have gone through a surface without any node meeting it. Nodes meet segments, and edges that stand out
//! (`edges.rs`) each other; an edge that cuts into a curved face between its nodes, or comes through where no fold is sharp
//! enough, still gets through. That is looked for now and then, for all edges of the surface, and told.

use crate::contact::geometry::{V3, passing};
use crate::contact::ridges::{Edge, Lines};
use crate::contact::search::Search;
use crate::contact::surface::{Segment, Surface};
use crate::nodes::{Nodes, Row};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::ElemId;

/// How far both ends of an edge must be from a face, as a fraction of the segment's scale.
const THROUGH: f64 = 0.1;

/// An edge in a segment that it did not go through at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    /// Element of the edge.
    pub edge: ElemId,
    /// Element of the segment.
    pub surface: ElemId,
}

/// Crossings of own edges, by the nodes with the lower id: of all that shells have, and of those between two faces of solids. In
/// ascending order, each once. To be called where all nodes of the surface are at the same time, but for a step.
pub fn crossings(surface: &Surface, nodes: &Nodes, time: f64, find: Search) -> Vec<Crossing> {
    let lines = Lines::of(surface, nodes);
    let edges: Vec<&Edge> = lines.all.iter().filter(|e| nodes.is_own(e.nodes[0] as usize)).collect();
    let half = |e: &&Edge| 0.5 * (e.ends(&nodes.x)[0] - e.ends(&nodes.x)[1]).norm();
    let longest = edges.iter().map(half).fold(0.0, f64::max);
    let middles: Vec<[f64; 3]> =
        edges.iter().map(|e| ((e.ends(&nodes.x)[0] + e.ends(&nodes.x)[1]) * 0.5).into()).collect();
    let boxes: Vec<Aabb> = surface.segments.iter().map(|s| s.bounds(&nodes.x, longest)).collect();
    let through = |s: &Segment, e: &Edge, x: &[Row]| {
        let ([p, q], [a, b, c, d]) = (e.ends(x), s.corners(x));
        let Some(normal) = s.middle_normal(x) else { return false };
        // What lies on a face, or sinks in as contact lets it, is not through.
        let (above, below) = ((p - a).dot(&normal), (q - a).dot(&normal));
        let deep = above.abs().min(below.abs()) > THROUGH * s.scale;
        deep && (pierces(&p, &q, [&a, &b, &c]) || !s.is_triangle() && pierces(&p, &q, [&a, &c, &d]))
    };
    // Edges that meet sink in as nodes do: one that is held by an edge of the segment is not through.
    let meets = |e: &Edge| lines.stands_out(e, surface, &nodes.x);
    let held = |s: &Segment, e: &Edge| {
        let sides = (0..4).map(|k| [s.nodes[k], s.nodes[(k + 1) % 4]]);
        let ascending = |[a, b]: [u32; 2]| if nodes.id[a as usize] < nodes.id[b as usize] { [a, b] } else { [b, a] };
        let of_segment = sides.filter_map(|n| lines.place(ascending(n))).map(|i| &lines.all[i]);
        let near = |o: &&Edge| {
            let passed = passing(&e.ends(&nodes.x), &o.ends(&nodes.x));
            passed.is_some_and(|p| p.height.abs() <= THROUGH * s.scale)
        };
        let mut near = of_segment.filter(near).peekable();
        near.peek().is_some() && meets(e) && near.any(meets)
    };
    let mut found: Vec<Crossing> = Vec::new();
    find(&boxes, &middles, &mut |g, i| {
        let (s, e) = (&surface.segments[g as usize], edges[i as usize]);
        let apart = !e.nodes.iter().any(|n| s.nodes.contains(n) || s.behind.contains(n));
        let touch = || {
            let parts = lines.segments(e).iter().map(|&g| surface.segments[g as usize].part);
            let interface = surface.interfaces.between(parts, std::iter::once(s.part));
            interface.is_some_and(|i| surface.interfaces.is_alive(i, time))
        };
        if apart && touch() && through(s, e, &nodes.x) && !through(s, e, &nodes.x0) && !held(s, e) {
            found.push(Crossing { edge: lines.lowest(e, surface).id.elem(), surface: s.id.elem() });
        }
    });
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether the line from `p` to `q` goes through the inside of a triangle (Moller & Trumbore 1997).
fn pierces(p: &V3, q: &V3, [a, b, c]: [&V3; 3]) -> bool {
    let (along, e1, e2) = (q - p, b - a, c - a);
    let h = along.cross(&e2);
    let det = e1.dot(&h);
    if det == 0.0 {
        return false;
    }
    let from = (p - a) / det;
    let u = from.dot(&h);
    let k = from.cross(&e1);
    let (v, t) = (along.dot(&k), e2.dot(&k));
    u > 0.0 && v > 0.0 && u + v < 1.0 && t > 0.0 && t < 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_a_triangle_and_lines_that_miss() {
        let (a, b, c) = (V3::zeros(), V3::x(), V3::y());
        let hits = |p: V3, q: V3| pierces(&p, &q, [&a, &b, &c]);
        assert!(hits(V3::new(0.2, 0.2, -1.0), V3::new(0.3, 0.3, 2.0)));
        assert!(!hits(V3::new(0.2, 0.2, 0.5), V3::new(0.3, 0.3, 2.0)), "ends before it");
        assert!(!hits(V3::new(0.8, 0.8, -1.0), V3::new(0.8, 0.8, 1.0)), "beside it");
        assert!(!hits(V3::new(0.2, 0.2, 0.0), V3::new(0.4, 0.2, 0.0)), "within its plane");
    }
}
