//! Elements near a limit, with their places, for the rows of the history.

use super::{Blocks, LocalElement};
use crate::nodes::Nodes;
use crumple_math::row::xyz;
use crumple_proto::ids::ElemId;
use crumple_proto::mesh::Shape;
use crumple_proto::place::ModelPlace;
use crumple_proto::quality::corner_jacobians;

/// Initial Jacobian of a corner, over the largest of the element, below which the corner is left
/// out: a quad that has degenerated to a triangle has such a corner.
const DEGENERATE: f64 = 1e-3;

impl Blocks {
    /// Returns the place of an own element.
    pub fn place(&self, id: ElemId, nodes: &Nodes) -> ModelPlace {
        let found = self.elements.iter().find(|e| e.record.id == id);
        found.map_or_else(ModelPlace::default, |e| Self::place_of(e, nodes))
    }

    /// Returns the place of an element.
    pub fn place_of(element: &LocalElement, nodes: &Nodes) -> ModelPlace {
        let record = &element.record;
        let corners = &element.nodes[..record.shape.corners()];
        let mut x = [0.0; 3];
        for &n in corners {
            let at = xyz(&nodes.x[n as usize]);
            (0..3).for_each(|c| x[c] += at[c] / corners.len() as f64);
        }
        ModelPlace { element: Some(record.id), node: None, part: Some(record.part), x }
    }

    /// Returns the own shell or solid with the smallest Jacobian at a corner, over its value at the
    /// start. Rigid and failed elements are left out.
    pub fn flattest(&self, nodes: &Nodes) -> Option<(f64, ElemId)> {
        let of_block = |b: &super::Block| {
            let own = self.elements[b.first..b.first + b.count].iter().enumerate();
            let sound = own.filter(|(i, e)| {
                let has_failed = b.element.can_fail() && b.element.failed(b.state(*i));
                !e.record.failed && !has_failed
            });
            let left = sound.map(|(_, e)| {
                let x0 = e.nodes.map(|n| xyz(&nodes.x0[n as usize]));
                let x = e.nodes.map(|n| xyz(&nodes.x[n as usize]));
                (corner_left(e.record.shape, &x0, &x), e.record.id)
            });
            left.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };
        let blocks = self.blocks.iter().filter(|b| !b.idle);
        let all = blocks.filter_map(of_block).filter(|(left, _)| left.is_finite());
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }
}

/// Returns the smallest Jacobian at a corner of an element over its value at the start; infinite if
/// it has none.
fn corner_left(shape: Shape, x0: &[[f64; 3]], x: &[[f64; 3]]) -> f64 {
    let (before, now) = (corner_jacobians(shape, x0), corner_jacobians(shape, x));
    let least = DEGENERATE * before.iter().copied().fold(0.0, f64::max);
    let corners = before.iter().zip(&now).filter(|(before, _)| **before > least);
    corners.map(|(before, now)| now / before).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_corner_keeps_a_share_of_its_jacobian() {
        let moved = |corner: usize, x: [f64; 3]| {
            let mut moved = SQUARE;
            moved[corner] = x;
            moved
        };
        let left = |x: &[[f64; 3]; 4]| corner_left(Shape::Quad4, &SQUARE, x);
        assert_eq!(left(&SQUARE), 1.0);
        let pressed = left(&SQUARE.map(|[x, y, z]| [0.1 * x, y, z]));
        assert!((pressed - 0.1).abs() < 1e-15, "{pressed}");
        // The two sides at the corner are on one line.
        assert!(left(&moved(2, [0.5, 0.5, 0.0])).abs() < 1e-15);
        assert!(left(&moved(2, [0.4, 0.4, 0.0])) < 0.0, "folded");
        // A triangle written as a quad.
        let flat = moved(3, [0.0, 0.0, 0.0]);
        assert_eq!(corner_left(Shape::Quad4, &flat, &flat), 1.0);
        assert_eq!(corner_left(Shape::Line2, &SQUARE, &SQUARE), f64::INFINITY);
    }

    #[test]
    fn a_flat_solid_has_lost_its_corners() {
        let raised = |h: f64| {
            let up = SQUARE.map(|[x, y, _]| [x, y, h]);
            [SQUARE, up].concat()
        };
        let left = corner_left(Shape::Hex8, &raised(1.0), &raised(0.05));
        assert!((left - 0.05).abs() < 1e-15, "{left}");
    }
}
