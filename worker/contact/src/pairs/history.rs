//! The history of a pair, which its slave keeps.

use super::PairKey;
use bytemuck::{Pod, Zeroable};
use crumple_math::row::V3;
use crumple_proto::ids::{NodeId, SegmentId};

/// History of a pair of the last step or of a lost pair, kept by its slave.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PairHistory {
    /// See [`Pair::key`].
    pub name: PairKey,
    /// See [`Pair::side`].
    pub side: f64,
    /// See [`Pair::tolerated_gap`].
    pub tolerated: f64,
    /// See [`Pair::initial_gap`].
    pub kept: f64,
    /// See [`Pair::penetration`].
    pub depth: f64,
    /// See [`Pair::normal`].
    pub normal: V3,
    /// See [`Pair::force`].
    pub force: V3,
    /// See [`Pair::slip`].
    pub slip: V3,
    /// See [`Pair::contact_thickness`].
    pub thickness: f64,
    /// See [`Pair::pressure`].
    pub pressure: f64,
    /// Number of steps since the pair was lost, 0 for a pair of the last step.
    pub age: u64,
}

/// Number of steps for which the history of a lost pair is kept, if its penetration was larger
/// than the fraction [`KEPT_PENETRATION`] of its contact thickness.
const KEPT_STEPS: u64 = 50;
const KEPT_PENETRATION: f64 = 0.01;
/// Distance that a lost pair may have moved before it counts as new, as a fraction of its scale.
const KEPT_DISTANCE: f64 = 0.5;

impl PairHistory {
    /// Returns true if it can be a history of `owner`. `knows` returns true for a node of the mesh,
    /// `is_face` for a face of one of its elements.
    pub fn is_valid(
        &self,
        owner: NodeId,
        knows: impl Fn(NodeId) -> bool,
        is_face: impl Fn(SegmentId) -> bool,
    ) -> bool {
        let name = &self.name;
        let is_known = if name.is_node() {
            name.slave == owner && is_face(SegmentId(name.target[0])) && name.target[1] == 0
        } else if name.is_segment() {
            let faces = [name.slave.0, name.target[0]].map(SegmentId);
            faces.into_iter().all(&is_face) && name.target[1] < 16
        } else {
            name.edge_nodes().into_iter().all(&knows)
        };
        let vectors = [self.normal, self.force, self.slip];
        let is_number = vectors.iter().flat_map(|v| v.iter()).all(|a| a.is_finite());
        let lengths = [self.tolerated, self.kept, self.depth, self.thickness, self.pressure];
        // Pairs of edges and of segments lose their side with the pair.
        let is_side = self.side.abs() == 1.0 || (!name.is_node() && self.side == 0.0);
        is_known
            && is_number
            && !lengths.iter().any(|a| a.is_nan())
            && is_side
            && self.age <= KEPT_STEPS
    }

    /// Returns the history after one more step in which the pair does not exist. It keeps the
    /// side, the penetration and the tolerated gap, so that a pair that is found again continues
    /// from them. Returns `None` if the pair is lost for too long, or if its penetration was
    /// small: then the side can be found from the geometry.
    pub fn after_loss(self) -> Option<Self> {
        let kept = self.age < KEPT_STEPS && self.depth > KEPT_PENETRATION * self.thickness;
        kept.then(|| Self { age: self.age + 1, force: V3::zeros(), slip: V3::zeros(), ..self })
    }

    /// Returns true if the pair existed in the last step, or cannot have moved far since it was
    /// lost. `moved` is its relative motion per step [length], `scale` the length to compare
    /// with [length].
    pub fn is_fresh(&self, moved: f64, scale: f64) -> bool {
        self.age as f64 * moved <= KEPT_DISTANCE * scale
    }

    /// Returns the stored force for a new normal: the same normal part, and the tangential part
    /// projected onto the new tangent plane [force].
    pub fn force_along(&self, normal: &V3) -> V3 {
        let pressed = self.force.dot(&self.normal);
        let sheared = self.force - self.normal * pressed;
        normal * pressed.max(0.0) + (sheared - normal * normal.dot(&sheared))
    }

    /// Returns the stored slip projected onto a new tangent plane [length].
    pub fn slip_along(&self, normal: &V3) -> V3 {
        self.slip - normal * normal.dot(&self.slip)
    }

    /// Returns the target segment of a slave node.
    pub fn segment(&self) -> SegmentId {
        SegmentId(self.name.target[0])
    }

    /// Returns true if the history belongs to the slave's pair with this segment.
    pub fn is_of(&self, segment: SegmentId) -> bool {
        self.name.target == [segment.0, 0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_of_other_meshes_and_impossible_values_are_not_valid() {
        let [own, other] = [NodeId(4), NodeId(5)];
        let (segment, absent) = (SegmentId(16), SegmentId(32));
        let history = |name| PairHistory { name, side: 1.0, ..PairHistory::zeroed() };
        let of_node = history(PairKey::of_node(own, segment));
        let of_edges = history(PairKey::of_edges([own, other], [other, own]));
        let of_segments = history(PairKey::of_segments([segment; 2], [1, 3]));
        let is_valid =
            |h: PairHistory| h.is_valid(own, |n| n == own || n == other, |s| s == segment);
        let lost = [of_edges, of_segments].map(|h| PairHistory { side: 0.0, ..h });
        for good in [of_node, of_edges, of_segments, lost[0], lost[1]] {
            assert!(is_valid(good), "{good:?}");
        }
        for bad in [
            history(PairKey::of_node(other, segment)),
            history(PairKey::of_node(own, absent)),
            history(PairKey::of_edges([own, NodeId(6)], [other, own])),
            history(PairKey::of_segments([segment, absent], [1, 3])),
            PairHistory { side: 0.0, ..of_node },
            PairHistory { side: f64::NAN, ..of_node },
            PairHistory { age: KEPT_STEPS + 1, ..of_node },
            PairHistory { depth: f64::NAN, ..of_node },
            PairHistory { force: V3::repeat(f64::INFINITY), ..of_node },
        ] {
            assert!(!is_valid(bad), "{bad:?}");
        }
    }
}
