//! On which side of each other two edges are when their contact begins: folds are touched from
//! outside, edges of solids from where their faces look.

use crate::folds::{Edge, EdgeTable, FoldWedge, Kind};
use crate::geometry::EdgeProjection;
use crate::reach::{ACTIVE, BEHIND, OUTSIDE};
use crate::surface::Surface;
use crumple_fem::nodes::Nodes;
use crumple_math::row::V3;

/// Tolerance of the normal of a contact. Solids: how far it may leave the angle between the
/// normals of the two faces, as a difference of cosines against their mean; for solids that lie
/// flat on each other it is one of these normals. Folds: sine of the angle by which the other
/// edge may lie behind a segment.
const CONE: f64 = 0.1;
/// Distance from the end of an edge, as a fraction of the scale, within which a new contact of
/// shells is left to the node there. The node keeps the other edge at a distance of at least
/// `sqrt(1 - END^2)` of the thickness.
const END: f64 = 0.1;
/// Depth of two edges behind each other, as a fraction of the thickness, up to which they count
/// as a penetration from before they became exposed. This applies if each is in front of the other
/// in the direction in which both are folded. A fold that is not exposed permits this penetration.
const SUNK: f64 = 0.5;

/// Returns the side on which a new pair begins; `None` if the two edges are behind their folds.
/// `side` is the side of the slave edge, and `thickness` and `scale` are those of the
/// pair [length].
pub fn side_of_folds(
    (lines, nodes, surface): (&EdgeTable, &Nodes, &Surface),
    edges: [&Edge; 2],
    met: &EdgeProjection,
    (thickness, scale): (f64, f64),
    side: f64,
) -> Option<f64> {
    let folds = Folds::new(lines, nodes, edges)?;
    if folds.are_met_from(&(met.normal * side)) {
        return Some(side);
    }
    // Edges at the start of contact are on their correct sides, even if other pairs keep them
    // apart. If nodes had to keep them apart until the fold turns, they would penetrate before
    // that.
    let touches = met.height * side - thickness >= -ACTIVE * scale;
    if touches && !lines.are_neighbours(edges, surface) {
        return Some(side);
    }
    // They may have touched before they became exposed.
    let sunk = met.height.abs() < SUNK * thickness && folds.are_before(&(met.normal * -side));
    sunk.then_some(-side)
}

/// Returns true if a pair of edges without history may begin: it is not too deep, and it is not at
/// the end of an edge. `gap` and `scale` are those of the pair [length].
pub fn may_begin(
    nodes: &Nodes,
    edges: [&Edge; 2],
    met: &EdgeProjection,
    (gap, scale): (f64, f64),
    solid: bool,
) -> bool {
    let to_end = |k: usize| {
        let [p, q] = edges[k].ends(&nodes.x);
        met.along[k].min(1.0 - met.along[k]) * (q - p).norm()
    };
    // An upright edge that stands a little deep in a face has the same depth and distance at the
    // face's edges. It must not touch these edges.
    let margin = if solid { (OUTSIDE * scale).max(-gap) } else { END * scale };
    (!solid || gap >= -BEHIND * scale) && to_end(0).min(to_end(1)) >= margin
}

/// Wedges of the slave edge and of the other edge; `None` for an edge that is no fold.
struct Folds {
    of: [Option<FoldWedge>; 2],
}

impl Folds {
    /// Returns the wedges of those of the two edges that are folds. Returns `None` if a fold has
    /// no outside any more.
    fn new(lines: &EdgeTable, nodes: &Nodes, edges: [&Edge; 2]) -> Option<Self> {
        let mut folds = Self { of: [None; 2] };
        for (edge, fold) in
            edges.into_iter().zip(&mut folds.of).filter(|(e, _)| e.kind == Kind::Fold)
        {
            *fold = Some(lines.wedge(edge, &nodes.x)?);
        }
        Some(folds)
    }

    /// Returns each wedge with the direction to the other edge, if `normal` points to the
    /// slave's side.
    fn each(&self, normal: &V3) -> impl Iterator<Item = (&FoldWedge, V3)> {
        self.of.iter().zip([-normal, *normal]).filter_map(|(w, d)| Some((w.as_ref()?, d)))
    }

    /// Returns true if, for each fold, the other edge lies behind none of its segments.
    fn are_met_from(&self, normal: &V3) -> bool {
        self.each(normal).all(|(wedge, to)| wedge.arms.iter().all(|arm| to.dot(arm) <= CONE))
    }

    /// Returns true if both edges are folds and their outsides face each other.
    fn are_before(&self, normal: &V3) -> bool {
        /// Cosine between the direction of the other edge and the outward direction of a fold.
        const TOWARDS: f64 = 0.7;
        let out = |w: &FoldWedge| (w.arms[0] + w.arms[1]).try_normalize(0.0).map(|m| -m);
        self.of.iter().all(|w| w.is_some())
            && self.are_met_from(normal)
            && self.each(normal).all(|(wedge, to)| out(wedge).is_some_and(|o| o.dot(&to) > TOWARDS))
    }
}

/// Returns the sign with which `normal`, perpendicular to both edges, points out of the solid of
/// the second edge and into the solid of the first edge. Edges of shells are ignored. Returns
/// `None` if neither sign does.
pub fn facing(
    lines: &EdgeTable,
    surface: &Surface,
    nodes: &Nodes,
    edges: [&Edge; 2],
    normal: &V3,
) -> Option<f64> {
    let mut sign = 0.0;
    for (edge, out) in edges.into_iter().zip([-1.0, 1.0]) {
        if edge.kind != Kind::Solid {
            continue;
        }
        let &[one, two] = lines.segments(edge) else { return None };
        let [face, next] = [one, two].map(|g| surface.segments[g as usize].middle_normal(&nodes.x));
        let (face, next) = (face?, next?);
        let middle = (face + next).try_normalize(0.0)?;
        let along = middle.dot(normal);
        let of_this = if along < 0.0 { -out } else { out };
        if along.abs() < middle.dot(&face) - CONE || sign * of_this < 0.0 {
            return None;
        }
        sign = of_this;
    }
    Some(sign)
}
