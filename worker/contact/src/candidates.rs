//! Candidate pairs, one by one and in batches.

use crate::kernels::Vector;
use crate::surface::{Segment, Surface};
use crumple_math::lanes::{LANES, Lane, Lanes, Real};
use crumple_math::row::Row;

/// A slave and a segment that it may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Index of the slave in the surface's slaves.
    pub slave_index: u32,
    /// Index of the segment in the surface's segments.
    pub segment: u32,
    /// Bit mask of the segment's nodes that also belong to a segment around the slave. It is set
    /// for shell segments that are separated from the slave by one segment.
    pub shared_node_mask: u8,
}

/// Batch of [`LANES`] slaves and segments.
pub struct PairBatch<'a> {
    /// Nodes of the slaves.
    pub slave: [u32; LANES],
    /// Segments.
    pub segment: [&'a Segment; LANES],
}

impl<'a> PairBatch<'a> {
    /// Returns the batch of up to [`LANES`] items, with the last item repeated; `of` returns the
    /// candidate pair of an item.
    pub fn gather<T>(surface: &'a Surface, some: &[T], of: impl Fn(&T) -> CandidatePair) -> Self {
        let lane = |lane: usize| of(&some[lane.min(some.len() - 1)]);
        Self {
            slave: std::array::from_fn(|l| surface.slaves[lane(l).slave_index as usize]),
            segment: std::array::from_fn(|l| &surface.segments[lane(l).segment as usize]),
        }
    }

    /// Returns the vectors at the slaves.
    pub fn slaves(&self, of: &[Row]) -> Vector<Lane> {
        Vector(Lane::from_rows(self.slave.map(|n| Lane::new(of[n as usize]))))
    }

    /// Returns the vectors at the segments' corners.
    pub fn corners(&self, of: &[Row]) -> [Vector<Lane>; 4] {
        [0, 1, 2, 3].map(|k| {
            Vector(Lane::from_rows(self.segment.map(|s| Lane::new(of[s.nodes[k] as usize]))))
        })
    }

    /// Returns the mask of segments that are triangles.
    pub fn triangles(&self) -> Lane {
        Lane::new(self.segment.map(|s| f64::from(u8::from(s.is_triangle())))).gt(Lane::splat(0.5))
    }
}
