//! Collects the nodes and quads of a scene, then numbers them so that neighbours in space are neighbours in number.

use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, Shape};
use std::collections::BTreeMap;

/// A mesh in the making; nodes are indices into `points` until [`Builder::finish`] gives them ids.
#[derive(Default)]
pub struct Builder {
    points: Vec<[f64; 3]>,
    quads: Vec<(u32, [usize; 4])>,
    sets: BTreeMap<String, Vec<usize>>,
}

impl Builder {
    /// Adds a node at `x` [length] and returns its index.
    pub fn point(&mut self, x: [f64; 3]) -> usize {
        self.points.push(x);
        self.points.len() - 1
    }

    /// Position of a node [length].
    pub fn at(&self, index: usize) -> [f64; 3] {
        self.points[index]
    }

    /// Adds a four-node shell of a part.
    pub fn quad(&mut self, part: u32, corners: [usize; 4]) {
        self.quads.push((part, corners));
    }

    /// Joins two rows of nodes of equal length by a row of quads; a closed row returns to its start.
    pub fn strip(&mut self, part: u32, one: &[usize], other: &[usize], closed: bool) {
        debug_assert_eq!(one.len(), other.len());
        let n = one.len();
        for i in 0..if closed { n } else { n - 1 } {
            let j = (i + 1) % n;
            self.quad(part, [one[i], other[i], other[j], one[j]]);
        }
    }

    /// Adds nodes to a named set.
    pub fn set(&mut self, name: &str, nodes: impl IntoIterator<Item = usize>) {
        self.sets.entry(name.to_string()).or_default().extend(nodes);
    }

    /// The mesh, numbered from 1 in slices of width `slice` [length] along x, within a slice along y, then z.
    pub fn finish(self, slice: f64) -> Mesh {
        // Whole thousandths of a slice, so that round-off between mirrored points does not decide an order.
        let key = |x: [f64; 3], tie: usize| {
            let [x, y, z] = x.map(|c| (c / slice * 1e3).round() as i64);
            (x.div_euclid(1000), y, z, x, tie)
        };
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.sort_by_key(|&i| key(self.points[i], i));
        let mut id = vec![NodeId(0); self.points.len()];
        for (k, &i) in order.iter().enumerate() {
            id[i] = NodeId(k as u64 + 1);
        }
        let centre =
            |corners: &[usize; 4]| [0, 1, 2].map(|c| 0.25 * corners.iter().map(|&i| self.points[i][c]).sum::<f64>());
        let mut quads: Vec<usize> = (0..self.quads.len()).collect();
        quads.sort_by_key(|&e| key(centre(&self.quads[e].1), e));
        Mesh {
            nodes: order.iter().map(|&i| MeshNode { id: id[i], x: self.points[i] }).collect(),
            elements: quads
                .iter()
                .zip(1..)
                .map(|(&e, number)| {
                    let (part, corners) = self.quads[e];
                    MeshElement::new(ElemId(number), part, Shape::Quad4, &corners.map(|i| id[i]))
                })
                .collect(),
            node_sets: self
                .sets
                .into_iter()
                .map(|(name, nodes)| {
                    let mut nodes: Vec<NodeId> = nodes.into_iter().map(|i| id[i]).collect();
                    nodes.sort_unstable();
                    nodes.dedup();
                    (name, nodes)
                })
                .collect(),
        }
    }
}
