//! Edges of the surface, and which of them stand out: rims of shells, folds, edges of more than two
//! segments, sharp convex edges of solids, and beams.
//!
//! How sharp an edge is depends on where its nodes were when surfaces were last looked at for folds
//! ([`Nodes::seen`]): in the same cycle on all workers, and known to those too that have the edge
//! since. From an edge every segment that has it goes off in a direction at right angles to it, its
//! arm. Where all arms lie within less than half a turn the edge has an outside, and the outermost
//! two of them make its wedge: it is folded by what half a turn is more than the angle between
//! them.

use crate::contact::geometry::V3;
use crate::contact::surface::{Segment, Surface};
use crate::nodes::{Nodes, Row, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;

/// Folds of shells begin to meet other edges where these would sink in by more than this fraction
/// of the thickness before nodes meet segments: half the width of a segment times the tangent of
/// half the fold.
const SINKS: f64 = 0.1;
/// They do so from 20 degrees on however narrow their segments are, and below 5 degrees however
/// wide these are, they do not [rad].
const FOLD: f64 = 0.349;
const LEAST: f64 = 0.087;
/// Edges of solids begin at 45 degrees [rad].
const SOLID_FOLD: f64 = 0.785;

/// The fold from which on an edge of shells begins to meet others, by its half thickness and the
/// width of its segments [rad].
fn limit(half: f64, width: f64) -> f64 {
    (2.0 * SINKS * 2.0 * half / (0.5 * width)).clamp(LEAST, FOLD)
}

/// The outermost arms of an edge.
#[derive(Clone, Copy, Debug)]
pub struct FoldWedge {
    /// Unit vectors.
    pub arms: [V3; 2],
    /// Length of the longer one, the width of its segment [length].
    pub width: f64,
}

/// What kind of edge it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// That of one shell alone.
    Rim,
    /// Of two segments or more, some of them shells.
    Fold,
    /// Of two faces of solids.
    Solid,
    /// A beam, whatever else has its nodes for an edge.
    Beam,
}

/// An edge of the surface that stands out, or could.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Local nodes, in ascending id.
    pub nodes: [u32; 2],
    /// What kind it is.
    pub kind: Kind,
    first: u32,
    count: u32,
    /// Half thickness, the largest of its shells and beams, or of the lowest of two faces of solids
    /// [length].
    pub half: f64,
    /// Length that its gaps are judged by, of the same [length].
    pub scale: f64,
}

impl Edge {
    /// Its ends [length].
    pub fn ends(&self, x: &[Row]) -> [V3; 2] {
        self.nodes.map(|n| V3::from(xyz(&x[n as usize])))
    }

    /// Ids of its nodes.
    pub fn ids(&self, nodes: &Nodes) -> [NodeId; 2] {
        self.nodes.map(|n| nodes.id[n as usize])
    }

    /// Box around it.
    pub fn bounds(&self, x: &[Row]) -> Aabb {
        Aabb::around(self.nodes.map(|n| xyz(&x[n as usize])))
    }
}

/// A segment's edge: local nodes in ascending id, and the segment.
type Side = ([u32; 2], u32);

/// Edges of a surface with the segments that have them.
#[derive(Debug, Default)]
pub struct EdgeTable {
    /// Edges in ascending order of their local nodes.
    pub all: Vec<Edge>,
    /// Indices of the segments of each edge, ascending; run after run.
    segments: Vec<u32>,
    /// Of each of them the two corners that are not the edge's, twice the same of a triangle.
    far: Vec<[u32; 2]>,
}

impl EdgeTable {
    /// Those of a surface that stand out or could: faces of solids have no rims, and more than two
    /// are no wedge.
    pub fn new(surface: &Surface, nodes: &Nodes) -> Self {
        let mut sides: Vec<Side> = Vec::with_capacity(4 * surface.segments.len());
        for (g, s) in surface.segments.iter().enumerate() {
            let corners = if s.is_triangle() { 3 } else { 4 };
            for k in 0..if s.is_line() { 1 } else { corners } {
                let (a, b) = (s.nodes[k], s.nodes[(k + 1) % corners]);
                sides.push((
                    if nodes.id[a as usize] < nodes.id[b as usize] { [a, b] } else { [b, a] },
                    g as u32,
                ));
            }
        }
        sides.sort_unstable();
        let mut lines = Self::default();
        for run in sides.chunk_by(|a, b| a.0 == b.0) {
            let is_solid = |side: &Side| surface.segments[side.1 as usize].is_solid();
            let is_line = |side: &Side| surface.segments[side.1 as usize].is_line();
            let kind = match (run, run.iter().all(is_solid)) {
                _ if surface.has_lines && run.iter().any(is_line) => Kind::Beam,
                ([_], false) => Kind::Rim,
                (_, false) => Kind::Fold,
                ([_, _], true) => Kind::Solid,
                (_, true) => continue,
            };
            let (first, count) = (lines.segments.len() as u32, run.len() as u32);
            let segments = run.iter().map(|side| &surface.segments[side.1 as usize]);
            let shells = segments.clone().filter(|s| kind == Kind::Solid || !s.is_solid());
            let counted = shells.take(if kind == Kind::Solid { 1 } else { run.len() });
            let largest =
                |of: (f64, f64), s: &Segment| (of.0.max(s.half_thickness), of.1.max(s.scale));
            let (half, scale) = counted.fold((0.0, 0.0), largest);
            lines.all.push(Edge { nodes: run[0].0, kind, first, count, half, scale });
            lines.segments.extend(run.iter().map(|side| side.1));
            lines.far.extend(segments.map(|s| {
                let mut others = s.nodes.into_iter().filter(|n| !run[0].0.contains(n));
                let one = others.next().unwrap_or(s.nodes[0]);
                [one, others.next().unwrap_or(one)]
            }));
        }
        lines.all.shrink_to_fit();
        lines.segments.shrink_to_fit();
        lines.far.shrink_to_fit();
        lines
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.segments[..]) + size_of_val(&self.far[..])
    }

    /// Indices of the segments that have an edge, ascending.
    pub fn segments(&self, edge: &Edge) -> &[u32] {
        &self.segments[edge.first as usize..(edge.first + edge.count) as usize]
    }

    /// The lowest segment that has an edge.
    pub fn lowest_segment<'a>(&self, edge: &Edge, surface: &'a Surface) -> &'a Segment {
        &surface.segments[self.segments[edge.first as usize] as usize]
    }

    /// Interface of two edges; `None` if they do not touch.
    pub fn interface(&self, edges: [&Edge; 2], surface: &Surface) -> Option<u16> {
        let [ahead, behind] =
            edges.map(|e| self.segments(e).iter().map(|&g| surface.segments[g as usize].part));
        surface.interfaces.for_pair(ahead, behind)
    }

    /// Place of the edge between these local nodes, in the order in which edges have them.
    pub fn place(&self, nodes: [u32; 2]) -> Option<usize> {
        self.all.binary_search_by_key(&nodes, |e| e.nodes).ok()
    }

    /// Whether a segment or a solid that has this edge has any of `others`.
    pub fn has_beside(&self, edge: &Edge, surface: &Surface, others: &[u32; 2]) -> bool {
        let has = |s: &Segment| others.iter().any(|n| s.nodes.contains(n) || s.behind.contains(n));
        self.segments(edge).iter().any(|&g| has(&surface.segments[g as usize]))
    }

    /// Whether a segment of one edge and a segment of the other have a node in common.
    pub fn are_neighbours(&self, edges: [&Edge; 2], surface: &Surface) -> bool {
        let [mut one, other] = edges
            .map(|e| self.segments(e).iter().flat_map(|&g| surface.segments[g as usize].nodes));
        one.any(|n| other.clone().any(|m| m == n))
    }

    /// Outermost arms of an edge. `None` without an outside, or where a segment has no area.
    pub fn wedge(&self, edge: &Edge, x: &[Row]) -> Option<FoldWedge> {
        let axis = Axis::new(edge, x);
        let arm = |far: &[u32; 2]| axis.arm(far, x);
        match &self.far[edge.first as usize..(edge.first + edge.count) as usize] {
            [g] => FoldWedge::between(arm(g), arm(g)),
            [g, h] => FoldWedge::between(arm(g), arm(h)),
            all => outermost(&all.iter().map(arm).collect::<Vec<V3>>()),
        }
    }

    /// Whether an edge stands out, with nodes at `x`.
    pub fn is_exposed(&self, edge: &Edge, surface: &Surface, x: &[Row]) -> bool {
        let [out] = self.is_folded(edge, surface, x, [1.0]);
        out
    }

    /// Whether it is folded by these fractions of the angle at which it stands out.
    pub fn is_folded<const N: usize>(
        &self,
        edge: &Edge,
        surface: &Surface,
        x: &[Row],
        by: [f64; N],
    ) -> [bool; N] {
        if matches!(edge.kind, Kind::Rim | Kind::Beam) {
            return [true; N];
        }
        let Some(FoldWedge { arms: [a, b], width }) = self.wedge(edge, x) else {
            return [false; N];
        };
        let turned = -a.dot(&b);
        if edge.kind == Kind::Solid {
            // Of a solid it is convex: the other face lies behind this one.
            let convex = || {
                self.lowest_segment(edge, surface).middle_normal(x).is_some_and(|n| b.dot(&n) < 0.0)
            };
            return by.map(|fraction| turned < (fraction * SOLID_FOLD).cos() && convex());
        }
        by.map(|fraction| {
            // Most are flatter or sharper than any limit: by bounds of the cosine they are told
            // without it.
            let [least, most] =
                [LEAST, FOLD].map(|angle| 0.5 * (fraction * angle) * (fraction * angle));
            let flat = turned >= 1.0 - least + least * least / 6.0;
            let sharp = turned < 1.0 - most;
            !flat && (sharp || turned < (fraction * limit(edge.half, width)).cos())
        })
    }
}

/// The line of an edge.
struct Axis {
    from: V3,
    along: V3,
    length2: f64,
}

impl Axis {
    fn new(edge: &Edge, x: &[Row]) -> Self {
        let [p, q] = edge.ends(x);
        Self { from: p, along: q - p, length2: (q - p).norm_squared() }
    }

    /// From the line to the middle of a segment's far corners, at right angles [length].
    fn arm(&self, far: &[u32; 2], x: &[Row]) -> V3 {
        let [one, two] = far.map(|n| V3::from(xyz(&x[n as usize])));
        let middle = (one + two) / 2.0;
        let place = (middle - self.from).dot(&self.along) / self.length2;
        middle - self.from - self.along * place
    }
}

impl FoldWedge {
    /// Between two arms [length].
    fn between(a: V3, b: V3) -> Option<Self> {
        let [one, two] = [a.norm(), b.norm()];
        (one > 0.0 && two > 0.0).then(|| Self { arms: [a / one, b / two], width: one.max(two) })
    }
}

/// The two of some arms about a line [length] that all others lie between; `None` where these take
/// half a turn or more.
fn outermost(arms: &[V3]) -> Option<FoldWedge> {
    /// Round-off of unit vectors.
    const BETWEEN: f64 = 1e-9;
    let units: Vec<V3> = arms.iter().map(|a| a.try_normalize(0.0)).collect::<Option<_>>()?;
    for (i, a) in units.iter().enumerate() {
        for (b, k) in units.iter().zip(0..).skip(i + 1) {
            let Some(middle) = (a + b).try_normalize(BETWEEN) else { continue };
            let half = middle.dot(a);
            if half > BETWEEN && units.iter().all(|c| middle.dot(c) >= half - BETWEEN) {
                return FoldWedge::between(arms[i], arms[k]);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::surface::NOT_LOCAL;
    use crate::testing::nodes_at;
    use crumple_proto::ids::SegmentId;

    /// Squares with one edge in common, along y, that go off at these angles [degree] from x
    /// towards z.
    fn star(angles: &[f64], half: f64) -> (Nodes, Surface) {
        let mut points = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut segments = Vec::new();
        for (i, angle) in angles.iter().enumerate() {
            let (s, c) = angle.to_radians().sin_cos();
            points.extend([[c, 1.0, s], [c, 0.0, s]]);
            let n = points.len() as u32;
            segments.push(Segment {
                id: SegmentId(8 * (i as u64 + 1)),
                nodes: [0, 1, n - 2, n - 1],
                behind: [NOT_LOCAL; 4],
                half_thickness: half,
                scale: 0.1,
                part: 0,
                own: true,
            });
        }
        (nodes_at(&points), Surface { segments, ..Surface::default() })
    }

    fn stands_out(angles: &[f64], half: f64) -> bool {
        let (nodes, surface) = star(angles, half);
        let lines = EdgeTable::new(&surface, &nodes);
        lines.is_exposed(&lines.all[lines.place([0, 1]).unwrap()], &surface, &nodes.x)
    }

    #[test]
    fn a_fold_stands_out_from_twenty_degrees_on_or_where_it_would_sink_in() {
        assert!(stands_out(&[30.0], 0.2), "a rim");
        assert!(!stands_out(&[0.0, 180.0], 0.5), "flat");
        assert!(!stands_out(&[0.0, 162.0], 0.5), "by 18 degrees");
        assert!(
            stands_out(&[0.0, 158.0], 0.5) && stands_out(&[0.0, 202.0], 0.5),
            "by 22, either way"
        );
        assert!(stands_out(&[0.0, 0.0], 0.5), "folded up");
        // Half the width of 1 times the tangent of half of 9 degrees is 0.039, a tenth of a
        // thickness of 0.39.
        assert!(stands_out(&[0.0, 171.0], 0.19) && !stands_out(&[0.0, 171.0], 0.205));
    }

    #[test]
    fn an_edge_of_three_stands_out_where_it_has_an_outside() {
        assert!(!stands_out(&[0.0, 180.0, 270.0], 0.2), "a T has none but its flat back");
        assert!(stands_out(&[-30.0, 210.0, 270.0], 0.2), "its flange bent back by 60 degrees");
        assert!(stands_out(&[-30.0, 270.0, 210.0], 0.2), "in whatever order");
        assert!(!stands_out(&[0.0, 120.0, 240.0], 0.2), "a Y");
        assert!(stands_out(&[0.0, 10.0, 90.0, 100.0], 0.2), "four to one side");
    }
}
