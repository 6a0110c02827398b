//! A slave and a segment near to it, and several such side by side.

use crate::contact::kernels::Vector;
use crate::contact::surface::{Segment, Surface};
use crate::math::lanes::{LANES, Lane, Lanes, Real};
use crate::nodes::Row;

/// A slave and a segment that it may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Place of the slave in the surface's slaves.
    pub slave_index: u32,
    /// Place of the segment in the surface's segments.
    pub segment: u32,
    /// The segment's nodes that a segment has on which the slave lies, bit by bit: of a shell next
    /// but one to the slave.
    pub shared_node_mask: u8,
    /// Whether the slave remembered nothing when it was given the segment; what one with memories
    /// may meet is then left out.
    pub has_no_history: bool,
}

/// Slaves and segments side by side.
pub struct PairBatch<'a> {
    /// Nodes of the slaves.
    pub slave: [u32; LANES],
    /// Segments.
    pub segment: [&'a Segment; LANES],
}

impl<'a> PairBatch<'a> {
    /// Those of a few neighbours, the last repeated; `of` tells which.
    pub fn of<T>(surface: &'a Surface, some: &[T], of: impl Fn(&T) -> CandidatePair) -> Self {
        let lane = |lane: usize| of(&some[lane.min(some.len() - 1)]);
        Self {
            slave: std::array::from_fn(|l| surface.slaves[lane(l).slave_index as usize]),
            segment: std::array::from_fn(|l| &surface.segments[lane(l).segment as usize]),
        }
    }

    /// Vectors at the slaves.
    pub fn slaves(&self, of: &[Row]) -> Vector<Lane> {
        Vector(Lane::from_rows(self.slave.map(|n| Lane::new(of[n as usize]))))
    }

    /// Vectors at the segments' corners.
    pub fn corners(&self, of: &[Row]) -> [Vector<Lane>; 4] {
        [0, 1, 2, 3].map(|k| {
            Vector(Lane::from_rows(self.segment.map(|s| Lane::new(of[s.nodes[k] as usize]))))
        })
    }

    /// Which segments are triangles.
    pub fn triangles(&self) -> Lane {
        Lane::new(self.segment.map(|s| f64::from(u8::from(s.is_triangle())))).gt(Lane::splat(0.5))
    }
}
