//! Edges of the surface and their classification. Edges that can be exposed are the rims of
//! shells, folds, edges of more than two segments, sharp convex edges of solids, and beams.
//!
//! The sharpness of an edge is computed from node positions that are refreshed in certain cycles
//! only ([`Nodes::seen`]). The cycle is the same on all workers, and the positions migrate with
//! the nodes. From an edge, every segment that has it extends in a direction perpendicular to
//! the edge, its arm. If all arms lie within less than 180 degrees, the edge has an outside, and
//! its two outermost arms form its wedge. The fold angle is 180 degrees minus the angle between
//! these two arms.
use crate::surface::{Segment, Surface};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{Row, V3, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;

/// Penetration of another edge before nodes touch segments, as a fraction of the thickness. A fold
/// of shells is exposed if this depth is larger. The depth is half the width of a segment times
/// the tangent of half the fold angle.
const SINKS: f64 = 0.1;
/// Limits of the fold angle of shells. From 20 degrees on a fold is exposed, however narrow its
/// segments are. Below 5 degrees it is not, however wide they are [rad].
const FOLD: f64 = 0.349;
const LEAST: f64 = 0.087;
/// Fold angle from which on an edge of solids is exposed, 45 degrees [rad].
const SOLID_FOLD: f64 = 0.785;

/// Returns the fold angle from which on an edge of shells is exposed [rad]. `half` is its half
/// thickness and `width` the width of its segments [length].
fn limit(half: f64, width: f64) -> f64 {
    (2.0 * SINKS * 2.0 * half / (0.5 * width)).clamp(LEAST, FOLD)
}

/// Returns half the square of an angle [rad]; one minus it is a lower bound of the cosine.
fn half_square(angle: f64) -> f64 {
    0.5 * angle * angle
}

/// Returns an upper bound of the cosine of this fraction of the least fold angle of shells.
fn flat_cosine(fraction: f64) -> f64 {
    let least = half_square(fraction * LEAST);
    1.0 - least + least * least / 6.0
}

/// The two outermost arms of an edge.
#[derive(Clone, Copy, Debug)]
pub struct FoldWedge {
    /// Unit vectors.
    pub arms: [V3; 2],
    /// Length of the longer arm, the width of its segment [length].
    pub width: f64,
}

/// Kind of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Edge of one shell only.
    Rim,
    /// Edge of two segments or more, some of them shells.
    Fold,
    /// Edge of two faces of solids.
    Solid,
    /// A beam, whatever other segments have the edge.
    Beam,
}

/// An edge of the surface that is exposed or could become so.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Local nodes, in ascending id.
    pub nodes: [u32; 2],
    /// Kind of the edge.
    pub kind: Kind,
    first: u32,
    count: u32,
    /// Half thickness: the largest of its shells and beams, or that of the lower one of two
    /// faces of solids [length].
    pub half: f64,
    /// Its part of the contact thickness, from the same segments [length].
    pub scale: f64,
}

impl Edge {
    /// Returns the coordinates of its ends [length].
    pub fn ends(&self, x: &[Row]) -> [V3; 2] {
        self.nodes.map(|n| V3::from(xyz(&x[n as usize])))
    }

    /// Returns the ids of its nodes.
    pub fn ids(&self, nodes: &Nodes) -> [NodeId; 2] {
        self.nodes.map(|n| nodes.id[n as usize])
    }

    /// Returns the box around it.
    pub fn bounds(&self, x: &[Row]) -> Aabb {
        Aabb::around(self.nodes.map(|n| xyz(&x[n as usize])))
    }
}

/// An edge of a segment: local nodes in ascending id, and the index of the segment.
type Side = ([u32; 2], u32);

/// Edges of a surface with the segments that have them.
#[derive(Debug, Default)]
pub struct EdgeTable {
    /// Edges in ascending order of their local nodes.
    pub all: Vec<Edge>,
    /// Indices of the segments of each edge, ascending, edge after edge.
    segments: Vec<u32>,
    /// For each entry of `segments` the two corners that are not on the edge; twice the same
    /// corner for a triangle.
    far: Vec<[u32; 2]>,
}

impl EdgeTable {
    /// Builds the table of edges that are exposed or could become so. Edges of solids need
    /// exactly two faces: one face has no rim, and more than two have no wedge.
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

    /// Returns the number of bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.segments[..]) + size_of_val(&self.far[..])
    }

    /// Returns the indices of the segments that have an edge, ascending.
    pub fn segments(&self, edge: &Edge) -> &[u32] {
        &self.segments[edge.first as usize..(edge.first + edge.count) as usize]
    }

    /// Returns the lowest segment that has an edge.
    pub fn lowest_segment<'a>(&self, edge: &Edge, surface: &'a Surface) -> &'a Segment {
        &surface.segments[self.segments[edge.first as usize] as usize]
    }

    /// Returns the interface of two edges; `None` if they do not touch.
    pub fn interface(&self, edges: [&Edge; 2], surface: &Surface) -> Option<u16> {
        let [ahead, behind] =
            edges.map(|e| self.segments(e).iter().map(|&g| surface.segments[g as usize].part));
        surface.interfaces.for_pair(ahead, behind)
    }

    /// Returns the index of the edge between these local nodes; `nodes` are in the order of
    /// [`Edge::nodes`].
    pub fn place(&self, nodes: [u32; 2]) -> Option<usize> {
        self.all.binary_search_by_key(&nodes, |e| e.nodes).ok()
    }

    /// Returns true if a segment or a solid that has this edge has any of the nodes `others`.
    pub fn has_adjacent(&self, edge: &Edge, surface: &Surface, others: &[u32; 2]) -> bool {
        let has = |s: &Segment| others.iter().any(|n| s.nodes.contains(n) || s.behind.contains(n));
        self.segments(edge).iter().any(|&g| has(&surface.segments[g as usize]))
    }

    /// Returns true if a segment of one edge and a segment of the other have a common node.
    pub fn are_neighbours(&self, edges: [&Edge; 2], surface: &Surface) -> bool {
        let [mut one, other] = edges
            .map(|e| self.segments(e).iter().flat_map(|&g| surface.segments[g as usize].nodes));
        one.any(|n| other.clone().any(|m| m == n))
    }

    /// Returns the outermost arms of an edge. Returns `None` if the edge has no outside or if a
    /// segment has no area.
    pub fn wedge(&self, edge: &Edge, x: &[Row]) -> Option<FoldWedge> {
        let axis = Axis::new(edge, x);
        let arm = |far: &[u32; 2]| axis.arm(far, x);
        match &self.far[edge.first as usize..(edge.first + edge.count) as usize] {
            [g] => FoldWedge::between(arm(g), arm(g)),
            [g, h] => FoldWedge::between(arm(g), arm(h)),
            all => outermost(&all.iter().map(arm).collect::<Vec<V3>>()),
        }
    }

    /// Returns true if an edge is exposed, with nodes at `x`.
    pub fn is_exposed(&self, edge: &Edge, surface: &Surface, x: &[Row]) -> bool {
        let [out] = self.is_folded(edge, surface, x, [1.0]);
        out
    }

    /// Returns true if an edge of two segments is certainly folded by less than the fraction `by`
    /// of the angle at which the widest segments expose it. Most edges are; this shows it without
    /// the unit vectors of the arms.
    fn is_flat(&self, edge: &Edge, x: &[Row], by: f64) -> bool {
        /// Margin for round-off.
        const MARGIN: f64 = 1e-9;
        let [one, two] = &self.far[edge.first as usize..(edge.first + edge.count) as usize] else {
            return false;
        };
        let axis = Axis::new(edge, x);
        let [a, b] = [one, two].map(|far| axis.arm(far, x));
        let along = -a.dot(&b);
        let limit = flat_cosine(by) + MARGIN;
        along > 0.0 && along * along > limit * limit * a.norm_squared() * b.norm_squared()
    }

    /// Returns for each fraction in `by` true if the edge is folded by this fraction of the
    /// angle at which it is exposed.
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
        if edge.kind == Kind::Fold && self.is_flat(edge, x, by.into_iter().fold(1.0, f64::min)) {
            return [false; N];
        }
        let Some(FoldWedge { arms: [a, b], width }) = self.wedge(edge, x) else {
            return [false; N];
        };
        let turned = -a.dot(&b);
        if edge.kind == Kind::Solid {
            // The edge of a solid is convex if the other face lies behind this one.
            let convex = || {
                self.lowest_segment(edge, surface).middle_normal(x).is_some_and(|n| b.dot(&n) < 0.0)
            };
            return by.map(|fraction| turned < (fraction * SOLID_FOLD).cos() && convex());
        }
        by.map(|fraction| {
            // Most folds are flatter or sharper than any limit. Bounds of the cosine identify
            // them without evaluating it.
            let flat = turned >= flat_cosine(fraction);
            let sharp = turned < 1.0 - half_square(fraction * FOLD);
            !flat && (sharp || turned < (fraction * limit(edge.half, width)).cos())
        })
    }
}

/// Line of an edge.
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

    /// Returns the vector from the line to the middle of a segment's far corners, perpendicular
    /// to the line [length].
    fn arm(&self, far: &[u32; 2], x: &[Row]) -> V3 {
        let [one, two] = far.map(|n| V3::from(xyz(&x[n as usize])));
        let middle = (one + two) / 2.0;
        let place = (middle - self.from).dot(&self.along) / self.length2;
        middle - self.from - self.along * place
    }
}

impl FoldWedge {
    /// Builds the wedge of two arms [length]; `None` if one of them has no length.
    fn between(a: V3, b: V3) -> Option<Self> {
        let [one, two] = [a.norm(), b.norm()];
        (one > 0.0 && two > 0.0).then(|| Self { arms: [a / one, b / two], width: one.max(two) })
    }
}

/// Returns the two arms about a line [length] between which all others lie. Returns `None` if
/// the arms extend over 180 degrees or more.
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
    use crate::surface::NOT_LOCAL;
    use crumple_fem::testing::nodes_at;
    use crumple_proto::ids::SegmentId;

    /// Returns squares with one common edge along y. They extend at these angles [degree] from x
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
                offset: 0.0,
                scale: 0.1,
                part: 0,
                own: true,
                searched: true,
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
        assert!(!stands_out(&[0.0, 162.0], 0.5), "folded by 18 degrees");
        assert!(
            stands_out(&[0.0, 158.0], 0.5) && stands_out(&[0.0, 202.0], 0.5),
            "folded by 22 degrees, in both directions"
        );
        assert!(stands_out(&[0.0, 0.0], 0.5), "folded up");
        // Half the width of 1 times the tangent of half of 9 degrees is 0.039, a tenth of a
        // thickness of 0.39.
        assert!(stands_out(&[0.0, 171.0], 0.19) && !stands_out(&[0.0, 171.0], 0.205));
    }

    #[test]
    fn an_edge_of_three_stands_out_where_it_has_an_outside() {
        assert!(!stands_out(&[0.0, 180.0, 270.0], 0.2), "a T has only its flat back");
        assert!(
            stands_out(&[-30.0, 210.0, 270.0], 0.2),
            "a T with a flange bent back by 60 degrees"
        );
        assert!(stands_out(&[-30.0, 270.0, 210.0], 0.2), "in another order");
        assert!(!stands_out(&[0.0, 120.0, 240.0], 0.2), "a Y");
        assert!(stands_out(&[0.0, 10.0, 90.0, 100.0], 0.2), "four to one side");
    }
}
