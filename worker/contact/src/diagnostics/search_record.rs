//! Record of the parts that ever were near to contact and of those that ever had a pair, which
//! `crumple advise` reads after a run.
//!
//! Nodes are marked, not segments: a part counts as near or touched if any node of its segments
//! is marked. Parts with common nodes count together, so no part with contact is reported as
//! free of contact.

use crate::surface::{NOT_LOCAL, Segment};

/// Marks of a node that was in a candidate ([`NEAR`]) or in a pair ([`TOUCHED`]).
const NEAR: u8 = 1;
const TOUCHED: u8 = 2;

/// Marks of local nodes since the surface was last renewed, and marks of parts before that.
#[derive(Debug, Default)]
pub struct SearchRecord {
    nodes: Vec<u8>,
    parts: Vec<u8>,
}

impl SearchRecord {
    /// Transfers the marks of nodes to the parts of `segments` and clears them. `count` is the
    /// number of nodes from now on; they may have other indices then.
    pub fn renew(&mut self, segments: &[Segment], count: usize) {
        self.parts = self.of_parts(segments);
        self.nodes.clear();
        self.nodes.resize(count, 0);
    }

    /// Marks a candidate: a node and a segment within reach of each other.
    pub fn near(&mut self, slave: u32, segment: &Segment) {
        self.nodes[slave as usize] |= NEAR;
        segment.nodes.iter().for_each(|&n| self.nodes[n as usize] |= NEAR);
    }

    /// Marks the nodes of a pair.
    pub fn touched(&mut self, nodes: &[u32]) {
        nodes
            .iter()
            .filter(|&&n| n != NOT_LOCAL)
            .for_each(|&n| self.nodes[n as usize] |= NEAR | TOUCHED);
    }

    /// Returns true if the part with index `part` ever was near, and true if it ever was
    /// touched.
    pub fn part_seen(&self, segments: &[Segment], part: usize) -> (bool, bool) {
        let marks = self.of_parts(segments).get(part).copied().unwrap_or(0);
        (marks & NEAR != 0, marks & TOUCHED != 0)
    }

    /// Returns the bytes in use.
    pub fn bytes(&self) -> usize {
        self.nodes.len() + self.parts.len()
    }

    /// Sets the marks of parts from a checkpoint.
    pub fn restore(&mut self, parts: Vec<u8>) {
        self.parts = parts;
    }

    /// Returns the marks of all parts so far.
    pub fn of_parts(&self, segments: &[Segment]) -> Vec<u8> {
        let mut parts = self.parts.clone();
        for s in segments {
            let marks = s
                .nodes
                .iter()
                .fold(0, |m, &n| m | self.nodes.get(n as usize).copied().unwrap_or(0));
            let part = s.part as usize;
            parts.resize(parts.len().max(part + 1), 0);
            parts[part] |= marks;
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::{ElemId, SegmentId};

    #[test]
    fn parts_keep_their_marks_when_nodes_get_new_numbers() {
        let segment = |part, nodes| Segment {
            id: SegmentId::new(ElemId(1), 0),
            nodes,
            behind: [NOT_LOCAL; 4],
            half_thickness: 1.0,
            offset: 0.0,
            scale: 1.0,
            part,
            own: true,
            searched: true,
        };
        let before =
            [segment(0, [0, 1, 2, 3]), segment(1, [4, 5, 6, 7]), segment(2, [8, 9, 10, 11])];
        let mut record = SearchRecord::default();
        record.renew(&[], 12);
        record.near(0, &before[1]);
        assert_eq!(record.part_seen(&before, 0), (true, false));
        assert_eq!(record.part_seen(&before, 1), (true, false));
        assert_eq!(record.part_seen(&before, 2), (false, false));
        record.touched(&[5, 0, 1, 2, 3]);
        record.renew(&before, 4);
        let after = [segment(2, [0, 1, 2, 3])];
        assert_eq!(
            [0, 1, 2].map(|p| record.part_seen(&after, p)),
            [(true, true), (true, true), (false, false)]
        );
    }
}
