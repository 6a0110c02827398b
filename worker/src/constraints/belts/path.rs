//! A belt from one end to the other: its nodes in order, its segments, and how nodes pass rings and
//! go into retractors.
//!
//! A ring or a retractor is a node of the path. When the segment next to it has become short, the
//! next node passes: it changes places with the ring in the path, which joins the short segment to
//! the one beyond it and cuts a piece off the segment on the other side. The unstretched length of
//! the path does not change. The node is put on the straight line of that segment, at the strain
//! that it has, so that the tensions of both sides change only by the difference between the joined
//! segments. It gets the velocity of the belt there: in a segment of the unstretched
//! length l from the ring at `x_0` to `x_1`, into which belt slides at the rate w, the material at
//! the unstretched distance s from the ring has
//! `v = v_0 + (s/l) (v_1 - v_0) + (x_1 - x_0) (w/l) (1 - s/l)`.

use super::BeltMotions;
use crate::math::row::V3;
use crumple_proto::belt::BeltPath;
use crumple_proto::ids::NodeId;
use serde::{Deserialize, Serialize};

/// Length of the piece that a node gets when it has passed, over the smallest length: above 1, so
/// that it does not return at once.
const PIECE: f64 = 1.1;

/// State of a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SegmentState {
    /// Unstretched length [length].
    pub length: f64,
    /// Largest strain so far.
    pub largest: f64,
    /// Tension of the last step, with damping [force].
    pub tension: f64,
    /// Belt that has come in during the last step [length].
    pub fed: f64,
}

/// State of a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathState {
    /// Nodes in their present order, and whether they may pass.
    pub nodes: Vec<(NodeId, bool)>,
    /// Segments between them.
    pub segments: Vec<SegmentState>,
}

/// Where a node is put when it has passed.
#[derive(Clone, Copy, Debug)]
pub struct PassedNode {
    /// The node.
    pub node: NodeId,
    /// Coordinates [length].
    pub x: V3,
    /// Velocity [length/time].
    pub v: V3,
}

/// The side of a ring or a retractor: that before it or that after it in the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeltSide {
    /// Towards the first node.
    Before,
    /// Towards the last node.
    After,
}

impl BeltSide {
    /// Returns the other side.
    pub fn other(self) -> Self {
        if self == Self::Before { Self::After } else { Self::Before }
    }

    /// Returns the segment on this side of the node at `place`.
    pub fn segment(self, place: usize) -> Option<usize> {
        if self == Self::Before { place.checked_sub(1) } else { Some(place) }
    }

    /// Returns the place of the next node on this side.
    fn next(self, place: usize) -> Option<usize> {
        if self == Self::Before { place.checked_sub(1) } else { Some(place + 1) }
    }
}

impl PathState {
    /// Returns the state at the start.
    pub fn new(job: &BeltPath) -> Self {
        let segment = |length| SegmentState { length, ..SegmentState::default() };
        Self {
            nodes: job.nodes.iter().copied().zip(job.loose.iter().copied()).collect(),
            segments: job.segments.iter().map(|s| segment(s.length)).collect(),
        }
    }

    /// Returns true if it is a state of a job's path.
    pub fn fits(&self, job: &BeltPath) -> bool {
        let mut own: Vec<NodeId> = self.nodes.iter().map(|n| n.0).collect();
        let mut wanted = job.nodes.clone();
        own.sort_unstable();
        wanted.sort_unstable();
        let sound = |s: &SegmentState| {
            let SegmentState { length, largest, tension, fed } = *s;
            [length, largest, tension, fed].iter().all(|n| n.is_finite()) && length >= 0.0
        };
        own == wanted
            && self.segments.len() == job.segments.len()
            && self.segments.iter().all(sound)
    }

    /// Returns the place of a node.
    ///
    /// # Panics
    /// It is not in the path.
    pub fn place(&self, node: NodeId) -> usize {
        self.nodes.iter().position(|n| n.0 == node).expect("a ring or retractor of this path")
    }

    /// Returns the distance of the nodes of a segment [length].
    pub fn distance(&self, segment: usize, motions: &BeltMotions) -> f64 {
        let at = |n: usize| motions[&self.nodes[n].0].x;
        (at(segment + 1) - at(segment)).norm()
    }

    /// Lets the next node on the `short` side of the ring at `place` pass it; `rate` is that of the
    /// belt into the other side [length/time]. Returns where it is put; `None` if the ring stops
    /// it, or if the other side has no length for it.
    pub fn pass(
        &mut self,
        (place, short): (usize, BeltSide),
        least: f64,
        rate: f64,
        motions: &BeltMotions,
    ) -> Option<PassedNode> {
        let (next, long) = (short.next(place)?, short.other());
        let beyond = short.segment(next)?;
        let (drained, cut) = (short.segment(place)?, long.segment(place)?);
        if beyond >= self.segments.len() || cut >= self.segments.len() || !self.nodes[next].1 {
            return None;
        }
        let end = long.next(place)?;
        let whole = self.segments[cut];
        let piece = PIECE * least;
        if whole.length < 2.0 * piece {
            return None;
        }
        let passed = self.put(next, (place, end), (piece, whole.length), rate, motions);
        let joined = self.segments[drained].length;
        self.segments[beyond].length += joined;
        self.segments[beyond].fed = self.segments[drained].fed;
        self.segments[cut] = SegmentState { length: whole.length - piece, fed: 0.0, ..whole };
        self.segments[drained] = SegmentState { length: piece, ..whole };
        self.nodes.swap(place, next);
        Some(passed)
    }

    /// Takes the next node on the `open` side into the retractor at `place`. Returns it; `None` if
    /// it cannot go in.
    pub fn wind_up(&mut self, place: usize, open: BeltSide) -> Option<NodeId> {
        let (next, drained) = (open.next(place)?, open.segment(place)?);
        let beyond = open.segment(next).filter(|&s| s < self.segments.len())?;
        let (node, is_loose) = self.nodes[next];
        if !is_loose {
            return None;
        }
        let joined = self.segments[drained].length;
        self.segments[beyond].length += joined;
        self.segments[beyond].fed = self.segments[drained].fed;
        self.segments[drained] = SegmentState::default();
        self.nodes.swap(place, next);
        Some(node)
    }

    /// Lets a node come out of the retractor at `place` on its `open` side, once the segment there
    /// is longer than `fed`. Returns where it is put.
    pub fn unwind(
        &mut self,
        (place, open): (usize, BeltSide),
        (least, fed): (f64, f64),
        rate: f64,
        motions: &BeltMotions,
    ) -> Option<PassedNode> {
        let (first, end) = (open.other().next(place)?, open.next(place)?);
        let (inside, outside) = (open.other().segment(place)?, open.segment(place)?);
        if first >= self.nodes.len() || !self.nodes[first].1 {
            return None;
        }
        let whole = self.segments[outside];
        let piece = PIECE * least;
        if whole.length <= fed.max(2.0 * piece) {
            return None;
        }
        let passed = self.put(first, (place, end), (piece, whole.length), rate, motions);
        self.segments[inside] = SegmentState { length: piece, ..whole };
        self.segments[outside] = SegmentState { length: whole.length - piece, fed: 0.0, ..whole };
        self.nodes.swap(place, first);
        Some(passed)
    }

    /// Returns where the node at `which` is put in the segment between two places, at an
    /// unstretched distance of a length from the first.
    fn put(
        &self,
        which: usize,
        (from, to): (usize, usize),
        (piece, length): (f64, f64),
        rate: f64,
        motions: &BeltMotions,
    ) -> PassedNode {
        let (ring, end) = (&motions[&self.nodes[from].0], &motions[&self.nodes[to].0]);
        let share = piece / length;
        let along = end.x - ring.x;
        let slides = along * (rate / length * (1.0 - share));
        PassedNode {
            node: self.nodes[which].0,
            x: ring.x + along * share,
            v: ring.v + (end.v - ring.v) * share + slides,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::BeltMotion;
    use super::*;

    /// Five nodes along x with the ring in the middle, which is node 3.
    fn path(lengths: [f64; 4]) -> (PathState, BeltMotions) {
        let segment = |length| SegmentState { length, ..SegmentState::default() };
        let nodes = (1..=5).map(|id| (NodeId(id), id != 3)).collect();
        let at =
            |id: u64| BeltMotion { x: V3::new(id as f64, 0.0, 0.0), v: V3::zeros(), inv_mass: 1.0 };
        let motions = (1..=5).map(|id| (NodeId(id), at(id))).collect();
        (PathState { nodes, segments: lengths.map(segment).to_vec() }, motions)
    }

    fn lengths(path: &PathState) -> Vec<f64> {
        path.segments.iter().map(|s| s.length).collect()
    }

    fn order(path: &PathState) -> Vec<u64> {
        path.nodes.iter().map(|n| n.0.0).collect()
    }

    #[test]
    fn nodes_pass_to_either_side_and_keep_the_length() {
        let (mut belt, motions) = path([1.0, 2.0, 0.1, 1.0]);
        let put = belt.pass((2, BeltSide::After), 0.1, 4.0, &motions).expect("it passes");
        assert_eq!(order(&belt), [1, 2, 4, 3, 5]);
        let expected = [1.0, 2.0 - 0.11, 0.11, 1.1];
        lengths(&belt).iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
        // From the ring at x = 3 towards the node at x = 2.
        assert!((put.x.x - (3.0 - 0.11 / 2.0)).abs() < 1e-15 && put.node == NodeId(4));
        assert!((put.v.x + 4.0 / 2.0 * (1.0 - 0.055)).abs() < 1e-15);
        let (mut belt, motions) = path([1.0, 0.1, 2.0, 1.0]);
        belt.pass((2, BeltSide::Before), 0.1, 0.0, &motions).expect("it passes");
        assert_eq!(order(&belt), [1, 3, 2, 4, 5]);
        let expected = [1.1, 0.11, 2.0 - 0.11, 1.0];
        lengths(&belt).iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
    }

    #[test]
    fn ends_and_held_nodes_do_not_pass() {
        let (mut belt, motions) = path([1.0, 2.0, 0.1, 1.0]);
        belt.nodes[3].1 = false;
        assert!(belt.pass((2, BeltSide::After), 0.1, 0.0, &motions).is_none());
        let (mut belt, motions) = path([0.1, 2.0, 1.0, 1.0]);
        assert!(belt.pass((1, BeltSide::Before), 0.1, 0.0, &motions).is_none());
        assert_eq!(belt.wind_up(1, BeltSide::Before), None);
    }

    #[test]
    fn a_node_goes_into_a_retractor_and_comes_out_again() {
        let (mut belt, motions) = path([0.1, 2.0, 1.0, 1.0]);
        belt.nodes[0].1 = false;
        assert_eq!(belt.wind_up(0, BeltSide::After), Some(NodeId(2)));
        assert_eq!((order(&belt), lengths(&belt)), (vec![2, 1, 3, 4, 5], vec![0.0, 2.1, 1.0, 1.0]));
        assert!(belt.unwind((1, BeltSide::After), (0.1, 3.0), 0.0, &motions).is_none());
        let put =
            belt.unwind((1, BeltSide::After), (0.1, 1.0), 0.0, &motions).expect("it comes out");
        assert_eq!((order(&belt), put.node), (vec![1, 2, 3, 4, 5], NodeId(2)));
        assert!((belt.segments[0].length - 0.11).abs() < 1e-15);
        assert!((belt.segments[1].length - 1.99).abs() < 1e-15);
        assert!(belt.unwind((0, BeltSide::After), (0.1, 1.0), 0.0, &motions).is_none());
    }
}
