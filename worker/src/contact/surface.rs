//! What can touch: both sides of shells with thickness. Nodes of these shells against their segments.

use crate::blocks::LocalElement;
use crate::contact::geometry::V3;
use crate::nodes::{Nodes, Row};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::ElemId;
use crumple_proto::partition::Settings;

/// A face that nodes can touch.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// The element that it belongs to.
    pub id: ElemId,
    /// Local nodes (a triangle repeats its third).
    pub nodes: [u32; 4],
    /// Half the shell's thickness [length].
    pub half: f64,
    /// Index of its part.
    pub part: u32,
    /// Whether the element is this worker's own.
    pub own: bool,
}

/// Segments and nodes of the contact surface that a worker knows.
#[derive(Debug, Default)]
pub struct Surface {
    /// Segments of own and exterior elements, in ascending element id.
    pub segments: Vec<Segment>,
    /// Owned nodes that may touch segments, ascending.
    pub slaves: Vec<u32>,
    /// Half thickness per held node, the largest of its shells; 0 off the surface [length].
    pub node_half: Vec<f64>,
}

impl Segment {
    /// The segment of an element.
    pub fn of(e: &LocalElement, half: f64) -> Self {
        Self { id: e.record.id, nodes: [0, 1, 2, 3].map(|c| e.nodes[c]), half, part: e.record.part, own: true }
    }

    /// Whether the segment is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.nodes[2] == self.nodes[3]
    }

    /// Corner coordinates.
    pub fn corners(&self, x: &[Row]) -> [V3; 4] {
        self.nodes.map(|n| {
            let r = &x[n as usize];
            V3::new(r[0], r[1], r[2])
        })
    }

    /// Box around the corners, grown by `reach`.
    pub fn bounds(&self, x: &[Row], reach: f64) -> Aabb {
        Aabb::around(self.nodes.map(|n| crate::nodes::xyz(&x[n as usize]))).grown(reach)
    }
}

/// Half thickness per part that takes part in contact, 0 for the others [length].
pub fn contact_half(settings: &Settings) -> Vec<f64> {
    let takes_part = |id: u32| settings.contact.as_ref().is_some_and(|c| c.parts.is_empty() || c.parts.contains(&id));
    settings.parts.iter().map(|p| if takes_part(p.id) { 0.5 * p.thickness } else { 0.0 }).collect()
}

impl Surface {
    /// Segments of elements and what they make of the first `held` nodes; `half_of` is the half thickness per part.
    pub fn of(elements: &[LocalElement], held: usize, half_of: &[f64]) -> Self {
        let mut s = Self { node_half: vec![0.0; held], ..Self::default() };
        for e in elements {
            let half = half_of[e.record.part as usize];
            if half > 0.0 {
                s.segments.push(Segment::of(e, half));
                e.nodes.iter().for_each(|&n| s.node_half[n as usize] = s.node_half[n as usize].max(half));
            }
        }
        s
    }

    /// Largest half thickness of a node [length].
    pub fn largest_half(&self) -> f64 {
        self.node_half.iter().copied().fold(0.0, f64::max)
    }

    /// Finds the slaves: owned nodes that lie on the surface.
    pub fn collect_slaves(&mut self, nodes: &Nodes) {
        let on_surface = |i: &u32| nodes.is_own(*i as usize) && self.node_half[*i as usize] > 0.0;
        self.slaves = (0..nodes.held as u32).filter(on_surface).collect();
    }
}
