//! Edges of the surface, and which of them stand out: rims of shells, folds, edges of more than two segments, and sharp
//! convex edges of solids.
//!
//! How sharp an edge is depends on where its nodes are now and on nothing else, so that workers agree on it whenever they look.
//! From an edge every segment that has it goes off in a direction at right angles to it, its arm. Where all arms lie within less
//! than half a turn the edge has an outside, and the outermost two of them make its wedge: it is folded by what half a
//! turn is more than the angle between them.

use crate::contact::geometry::V3;
use crate::contact::surface::{Segment, Surface};
use crate::nodes::{Nodes, Row, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;

/// Folds of shells that are sharper than this [rad] begin to meet other edges, here 20 degrees. What is less sharp sinks in by at
/// most half an edge's length times the tangent of half of that, 0.09 of the length, before nodes meet segments.
const FOLD: f64 = 0.349;
/// A contact that is there lasts while the fold is sharper than this [rad], here 15 degrees.
const STAYS: f64 = 0.262;
/// The same of solids: 45 and 40 degrees.
const SOLID_FOLD: f64 = 0.785;
const SOLID_STAYS: f64 = 0.698;

/// What kind of edge it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// That of one shell alone.
    Rim,
    /// Of two segments or more, some of them shells.
    Fold,
    /// Of two faces of solids.
    Solid,
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
pub struct Lines {
    /// Edges in ascending order of their local nodes.
    pub all: Vec<Edge>,
    /// Indices of the segments of each edge, ascending; run after run.
    segments: Vec<u32>,
}

impl Lines {
    /// Those of a surface that stand out or could: faces of solids have no rims, and more than two are no wedge.
    pub fn of(surface: &Surface, nodes: &Nodes) -> Self {
        let mut sides: Vec<Side> = Vec::with_capacity(4 * surface.segments.len());
        for (g, s) in surface.segments.iter().enumerate() {
            let corners = if s.is_triangle() { 3 } else { 4 };
            for k in 0..corners {
                let (a, b) = (s.nodes[k], s.nodes[(k + 1) % corners]);
                sides.push((if nodes.id[a as usize] < nodes.id[b as usize] { [a, b] } else { [b, a] }, g as u32));
            }
        }
        sides.sort_unstable();
        let mut lines = Self::default();
        for run in sides.chunk_by(|a, b| a.0 == b.0) {
            let is_solid = |side: &Side| surface.segments[side.1 as usize].is_solid();
            let kind = match (run, run.iter().all(is_solid)) {
                ([_], false) => Kind::Rim,
                (_, false) => Kind::Fold,
                ([_, _], true) => Kind::Solid,
                (_, true) => continue,
            };
            let (first, count) = (lines.segments.len() as u32, run.len() as u32);
            lines.all.push(Edge { nodes: run[0].0, kind, first, count });
            lines.segments.extend(run.iter().map(|side| side.1));
        }
        lines.all.shrink_to_fit();
        lines.segments.shrink_to_fit();
        lines
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.segments[..])
    }

    /// Indices of the segments that have an edge, ascending.
    pub fn segments(&self, edge: &Edge) -> &[u32] {
        &self.segments[edge.first as usize..(edge.first + edge.count) as usize]
    }

    /// The lowest segment that has an edge.
    pub fn lowest<'a>(&self, edge: &Edge, surface: &'a Surface) -> &'a Segment {
        &surface.segments[self.segments[edge.first as usize] as usize]
    }

    /// Half thickness of an edge and the length that its gaps are judged by: the largest of its shells, or of the lowest of two
    /// faces of solids [length].
    pub fn size(&self, edge: &Edge, surface: &Surface) -> (f64, f64) {
        let lowest = self.lowest(edge, surface);
        let shells = self.segments(edge).iter().map(|&g| &surface.segments[g as usize]).filter(|s| !s.is_solid());
        let size = shells.fold((0.0, 0.0), |(half, scale): (f64, f64), s| (half.max(s.half), scale.max(s.scale)));
        if edge.kind == Kind::Solid { (lowest.half, lowest.scale) } else { size }
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

    /// Outermost arms of an edge, unit vectors. `None` without an outside, or where a segment has no area.
    pub fn wedge(&self, edge: &Edge, surface: &Surface, x: &[Row]) -> Option<[V3; 2]> {
        let axis = Axis::of(edge, x);
        let arm = |g: u32| axis.arm(&surface.segments[g as usize], x).try_normalize(0.0);
        match *self.segments(edge) {
            [g] => arm(g).map(|a| [a, a]),
            [g, h] => Some([arm(g)?, arm(h)?]),
            ref all => outermost(&all.iter().map(|&g| arm(g)).collect::<Option<Vec<V3>>>()?),
        }
    }

    /// Whether an edge with these outermost arms stands out: for a contact that is there, if it `stays`.
    pub fn stands_out(&self, edge: &Edge, [a, b]: &[V3; 2], surface: &Surface, x: &[Row], stays: bool) -> bool {
        let sharper = |limit: f64| -a.dot(b) < limit.cos();
        match edge.kind {
            Kind::Rim => true,
            Kind::Fold => sharper(if stays { STAYS } else { FOLD }),
            // Convex: the other face lies behind this one.
            Kind::Solid => {
                sharper(if stays { SOLID_STAYS } else { SOLID_FOLD })
                    && self.lowest(edge, surface).middle_normal(x).is_some_and(|n| b.dot(&n) < 0.0)
            }
        }
    }

    /// Whether an edge could come to stand out before two nodes have moved by more than `skin` against each other [length].
    pub fn could_stand_out(&self, edge: &Edge, surface: &Surface, x: &[Row], skin: f64) -> bool {
        let limit = match edge.kind {
            Kind::Rim => return true,
            Kind::Fold => FOLD,
            Kind::Solid => SOLID_FOLD,
        };
        let [g, h] = *self.segments(edge) else { return true };
        let axis = Axis::of(edge, x);
        let [(a, turn_a), (b, turn_b)] = [g, h].map(|g| axis.turning(&surface.segments[g as usize], x, skin));
        // No cosine is above this one's first terms.
        let least = limit - turn_a - turn_b;
        if least <= 0.0 {
            return true;
        }
        let cos = 1.0 - least * least / 2.0 + least.powi(4) / 24.0;
        let product = -a.dot(&b);
        !(product * product.abs() > cos * cos.abs() * a.norm_squared() * b.norm_squared())
    }
}

/// The line of an edge.
struct Axis {
    from: V3,
    along: V3,
    length2: f64,
    nodes: [u32; 2],
}

impl Axis {
    fn of(edge: &Edge, x: &[Row]) -> Self {
        let [p, q] = edge.ends(x);
        Self { from: p, along: q - p, length2: (q - p).norm_squared(), nodes: edge.nodes }
    }

    /// Middle of a segment's corners that are not the edge's, and its place along the line, from 0 to 1 beside the edge.
    fn far(&self, segment: &Segment, x: &[Row]) -> (V3, f64) {
        let others = segment.nodes.iter().filter(|n| !self.nodes.contains(n));
        let (sum, count) = others.fold((V3::zeros(), 0.0), |(s, c), &n| (s + V3::from(xyz(&x[n as usize])), c + 1.0));
        let middle = sum / count;
        (middle, (middle - self.from).dot(&self.along) / self.length2)
    }

    /// From the line to a segment's far side, at right angles [length].
    fn arm(&self, segment: &Segment, x: &[Row]) -> V3 {
        let (middle, place) = self.far(segment, x);
        middle - self.from - self.along * place
    }

    /// The arm, and the most by which it may turn about the line before two nodes have moved by more than `skin` against each other
    /// [rad]. Its ends then move by `skin` against each other, by more where its foot lies beside the edge, and the line turns by what
    /// its ends move.
    fn turning(&self, segment: &Segment, x: &[Row], skin: f64) -> (V3, f64) {
        /// No arc is longer than this many of its sines where these are below a half.
        const ARC: f64 = 1.05;
        let (middle, place) = self.far(segment, x);
        let arm = middle - self.from - self.along * place;
        let beyond = 1.0 + 2.0 * (-place).max(place - 1.0).max(0.0);
        let line = skin / self.length2.sqrt();
        let sine = beyond * skin / arm.norm() + ARC * line;
        (arm, if sine < 0.5 && line < 0.5 { ARC * sine } else { f64::INFINITY })
    }
}

/// The two of some arms about a line, unit vectors, that all others lie between; `None` where these take half a turn or more.
fn outermost(arms: &[V3]) -> Option<[V3; 2]> {
    /// Round-off of unit vectors.
    const BETWEEN: f64 = 1e-9;
    for (i, a) in arms.iter().enumerate() {
        for b in &arms[i + 1..] {
            let Some(middle) = (a + b).try_normalize(BETWEEN) else { continue };
            let half = middle.dot(a);
            if half > BETWEEN && arms.iter().all(|c| middle.dot(c) >= half - BETWEEN) {
                return Some([*a, *b]);
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
    use proptest::prelude::*;

    /// Squares with one edge in common, along y, that go off at these angles [degree] from x towards z.
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
                half,
                scale: 0.1,
                part: 0,
                own: true,
            });
        }
        (nodes_at(&points), Surface { segments, ..Surface::default() })
    }

    fn stands_out(angles: &[f64], stays: bool) -> bool {
        let (nodes, surface) = star(angles, 0.1);
        let lines = Lines::of(&surface, &nodes);
        let edge = lines.all[lines.place([0, 1]).unwrap()];
        let wedge = lines.wedge(&edge, &surface, &nodes.x);
        wedge.is_some_and(|w| lines.stands_out(&edge, &w, &surface, &nodes.x, stays))
    }

    #[test]
    fn a_fold_stands_out_from_twenty_degrees_on_and_stays_down_to_fifteen() {
        assert!(stands_out(&[30.0], false), "a rim");
        assert!(!stands_out(&[0.0, 180.0], false) && !stands_out(&[0.0, 180.0], true), "flat");
        assert!(!stands_out(&[0.0, 162.0], false) && stands_out(&[0.0, 162.0], true), "by 18 degrees");
        assert!(!stands_out(&[0.0, 166.0], true), "by 14");
        assert!(stands_out(&[0.0, 158.0], false) && stands_out(&[0.0, 202.0], false), "by 22, either way");
        assert!(stands_out(&[0.0, 0.0], false), "folded up");
    }

    #[test]
    fn an_edge_of_three_stands_out_where_it_has_an_outside() {
        assert!(!stands_out(&[0.0, 180.0, 270.0], false), "a T has none but its flat back");
        assert!(stands_out(&[-30.0, 210.0, 270.0], false), "its flange bent back by 60 degrees");
        assert!(stands_out(&[-30.0, 270.0, 210.0], false), "in whatever order");
        assert!(!stands_out(&[0.0, 120.0, 240.0], false), "a Y");
        assert!(stands_out(&[0.0, 10.0, 90.0, 100.0], false), "four to one side");
    }

    proptest! {
        /// What is said not to stand out does not, however nodes move within the skin.
        #[test]
        fn nothing_that_could_not_stand_out_does(
            fold in 0.0..40.0f64,
            skew in prop::array::uniform6(prop::array::uniform3(-0.3..0.3f64)),
            moves in prop::array::uniform6(prop::array::uniform3(-1.0..1.0f64)),
            skin in 0.0..0.2f64,
        ) {
            let (mut nodes, surface) = star(&[0.0, 180.0 - fold], 0.1);
            let change = |nodes: &mut Nodes, by: &[[f64; 3]; 6], scale: f64| {
                nodes.x.iter_mut().zip(by).for_each(|(x, d)| (0..3).for_each(|c| x[c] += scale * d[c]));
            };
            change(&mut nodes, &skew, 1.0);
            let lines = Lines::of(&surface, &nodes);
            let edge = lines.all[lines.place([0, 1]).unwrap()];
            let could = lines.could_stand_out(&edge, &surface, &nodes.x, skin);
            change(&mut nodes, &moves, 0.5 * skin / 3f64.sqrt());
            let wedge = lines.wedge(&edge, &surface, &nodes.x).unwrap();
            let does = lines.stands_out(&edge, &wedge, &surface, &nodes.x, false);
            prop_assert!(could || !does);
        }
    }
}
