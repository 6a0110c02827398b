//! The boxes of a worker and the classes of its elements (Wang et al. 2007, sec. 2.1, fig. 1).
//!
//! The buffer straddles every face of the *subdomain box*. The *internal box* is the subdomain box
//! without the inner half of the buffer, the *external box* reaches to its outer half.
//!
//! An own element is *interior* if it lies in the internal box, otherwise it is an *interface*
//! element. The *exterior* elements of a worker, its ghosts, are exactly the interface elements
//! of other workers with a contact face that reaches into its external box.
//!
//! Wang's half buffer is b/2. It is wider here by three terms, see [`half_width`]:
//!
//! - b/2: either of two bodies may use the buffer, and both may move;
//! - the reach of the contact search, within which a pair must be found;
//! - the protrusion: the centre of an element decides on its box, so its nodes lie up to half an
//!   element outside.
//!
//! With a second decomposition of contact (`contact_decomposition.rs`) the boxes are those of its
//! cuts, and the external box is that around the entities for which the worker searches. The half
//! width is the distance around them that ghosts cover. Interface elements are then those with a
//! copy or a shared node.
//!
//! Motion between two renewals adds nothing: boxes and classes are those of the last renewal, and
//! the next one is due before the relative motion exceeds b (`ghosts.rs`).

use crate::contact::surface::Surface;
use crate::nodes::Nodes;
use crumple_proto::boxes::{Aabb, CutTree};

/// Relative amount by which the buffer is wider than computed, so that round-off of coordinates
/// cannot move a copied element into the internal box.
const ROUND_OFF: f64 = 1e-9;

/// The boxes of a worker at its last renewal.
#[derive(Clone, Copy, Debug)]
pub struct WorkerBoxes {
    /// Box of the worker in the tree of cuts; outer faces are at infinity.
    pub subdomain: Aabb,
    /// Subdomain box without the inner half of the buffer.
    pub internal: Aabb,
    /// Box around the contact entities of the worker, extended by reach and buffer: the part of
    /// the subdomain box with the outer half of the buffer in which ghosts can be needed. Empty
    /// without contact.
    pub external: Aabb,
    /// Half the width of the buffer, equal on all workers [length].
    pub half_width: f64,
}

impl WorkerBoxes {
    /// Returns the boxes of worker `me`; the external box is not known yet.
    pub fn new(tree: &CutTree, me: usize, half_width: f64) -> Self {
        let subdomain = tree.boxes()[me];
        let internal = subdomain.grown(-half_width);
        Self { subdomain, internal, external: Aabb::EMPTY, half_width }
    }

    /// Returns true if an element with this box around its nodes lies in the internal box.
    pub fn is_interior(&self, element: &Aabb) -> bool {
        !self.internal.is_empty() && self.internal.contains_box(element)
    }
}

impl Default for WorkerBoxes {
    /// Returns the boxes of a single worker.
    fn default() -> Self {
        Self::new(&CutTree::single(), 0, 0.0)
    }
}

/// Returns half the width of the buffer [length]. `bounds` are the boxes around the nodes of each
/// worker's elements; `covered` is the distance around its contact entities within which a worker
/// needs ghosts, or b/2 without contact.
///
/// The contact entities of a worker lie in its `bounds`, so its external box lies in its
/// subdomain box extended by this width. Subdomain boxes do not overlap: an element that reaches
/// into the external box of another worker is not in the internal box of its own. The same holds
/// for an element at a shared node, since the node lies in both `bounds`.
pub fn half_width(tree: &CutTree, bounds: &[Aabb], covered: f64) -> f64 {
    let protrusions = tree.boxes().into_iter().zip(bounds).map(|(own, held)| {
        let sides = (0..3).flat_map(|c| [own.min[c] - held.min[c], held.max[c] - own.max[c]]);
        if held.is_empty() { 0.0 } else { sides.fold(0.0, f64::max) }
    });
    let widest = protrusions.fold(0.0, f64::max);
    (widest + covered) * (1.0 + ROUND_OFF)
}

/// Numbers of elements and nodes by class, at the last renewal or update of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClassCounts {
    /// Own elements in the internal box.
    pub interior: u64,
    /// Own elements that other workers may need.
    pub interface: u64,
    /// Ghost elements.
    pub exterior: u64,
    /// Ghost nodes.
    pub exterior_nodes: u64,
}

impl ClassCounts {
    /// Counts ghost elements and ghost nodes.
    pub fn count_exterior(&mut self, surface: &Surface, nodes: &Nodes) {
        self.exterior = surface.ghost_elements().count() as u64;
        self.exterior_nodes = (nodes.len() - nodes.local_count) as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::boxes::Cut;

    fn halves() -> CutTree {
        let cut = Cut::Plane { axis: 0, at: 10.0, below: 1, above: 2 };
        CutTree { entries: vec![cut, Cut::Leaf(0), Cut::Leaf(1)] }
    }

    fn cell(from: f64, to: f64) -> Aabb {
        Aabb { min: [from, 0.0, 0.0], max: [to, 1.0, 1.0] }
    }

    /// Elements of length 4 whose nodes protrude by 1 over the cut, and 2 that are covered: the
    /// internal box begins at a distance of 3 from the cut.
    #[test]
    fn the_buffer_holds_what_protrudes_and_what_is_covered() {
        let tree = halves();
        let bounds = [cell(-50.0, 11.0), cell(9.5, 90.0)];
        let half = half_width(&tree, &bounds, 2.0);
        assert!((half - 3.0).abs() < 1e-6, "{half}");
        let boxes = WorkerBoxes::new(&tree, 0, half);
        assert!(boxes.is_interior(&cell(-1e9, 6.9)), "outer faces are at infinity");
        assert!(!boxes.is_interior(&cell(3.0, 7.0)));
        assert!(WorkerBoxes::new(&tree, 1, half).is_interior(&cell(13.1, 17.0)));
        let none = half_width(&tree, &[Aabb::EMPTY, cell(10.0, 90.0)], 2.0);
        assert!((none - 2.0).abs() < 1e-6, "a worker without elements: {none}");
    }

    #[test]
    fn a_box_narrower_than_the_buffer_has_no_interior() {
        let cuts = [
            Cut::Plane { axis: 1, at: 0.0, below: 1, above: 2 },
            Cut::Leaf(0),
            Cut::Plane { axis: 1, at: 2.0, below: 3, above: 4 },
            Cut::Leaf(1),
            Cut::Leaf(2),
        ];
        let boxes = WorkerBoxes::new(&CutTree { entries: cuts.to_vec() }, 1, 1.5);
        assert!(!boxes.is_interior(&Aabb { min: [0.0, 1.0, 0.0], max: [0.0, 1.0, 0.0] }));
        assert!(WorkerBoxes::default().is_interior(&cell(-1e300, 1e300)), "a single worker");
    }
}
