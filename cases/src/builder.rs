//! Collects the nodes and elements of a scene and numbers them so that neighbours in space have
//! nearby numbers.

use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{EDGES_OF_TET10, Mesh, MeshElement, MeshNode, Shape};
use std::collections::BTreeMap;

/// Growth of [`graded`] from one step to the next.
const GROWTH: f64 = 1.2;

/// Returns the same mesh with randomly permuted ids. `seed` sets the permutation.
pub fn shuffled(mut mesh: Mesh, seed: u64) -> Mesh {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut nodes: Vec<NodeId> = mesh.nodes.iter().map(|n| n.id).collect();
    let mut elements: Vec<ElemId> = mesh.elements.iter().map(|e| e.id).collect();
    random.shuffle(&mut nodes);
    random.shuffle(&mut elements);
    let of: BTreeMap<NodeId, NodeId> = mesh.nodes.iter().map(|n| n.id).zip(nodes).collect();
    mesh.nodes.iter_mut().for_each(|n| n.id = of[&n.id]);
    mesh.nodes.sort_by_key(|n| n.id);
    for (e, id) in mesh.elements.iter_mut().zip(elements) {
        (e.id, e.nodes) = (id, e.nodes.map(|n| of[&n]));
    }
    mesh.elements.sort_by_key(|e| e.id);
    for set in mesh.node_sets.values_mut() {
        set.iter_mut().for_each(|n| *n = of[n]);
        set.sort_unstable();
    }
    mesh
}

/// A mesh under construction. Nodes are indices into `points`; [`Builder::finish`] assigns ids.
#[derive(Default)]
pub struct Builder {
    points: Vec<[f64; 3]>,
    elements: Vec<(u32, Shape, Vec<usize>)>,
    sets: BTreeMap<String, Vec<usize>>,
}

impl Builder {
    /// Adds a node at `x` [length] and returns its index.
    pub fn point(&mut self, x: [f64; 3]) -> usize {
        self.points.push(x);
        self.points.len() - 1
    }

    /// Returns the position of a node [length].
    pub fn at(&self, index: usize) -> [f64; 3] {
        self.points[index]
    }

    /// Adds a four-node shell of a part.
    pub fn quad(&mut self, part: u32, corners: [usize; 4]) {
        self.elements.push((part, Shape::Quad4, corners.to_vec()));
    }

    /// Adds a three-node shell of a part.
    pub fn triangle(&mut self, part: u32, corners: [usize; 3]) {
        self.elements.push((part, Shape::Tri3, corners.to_vec()));
    }

    /// Adds a particle of a part at a node.
    pub fn particle(&mut self, part: u32, node: usize) {
        self.elements.push((part, Shape::Point1, vec![node]));
    }

    /// Adds a body of solids with `count` elements along each of three directions, which form a
    /// right-handed system. `place` returns the position of node (i, j, k) [length]. Returns the
    /// nodes with k as the fastest index, then j.
    pub fn block(
        &mut self,
        part: u32,
        count: [usize; 3],
        place: impl Fn([usize; 3]) -> [f64; 3],
    ) -> BlockNodes {
        let [a, b, c] = count.map(|n| n + 1);
        let all = (0..a * b * c).map(|n| self.point(place([n / (b * c), n / c % b, n % c])));
        let grid = BlockNodes { nodes: all.collect(), count };
        for n in 0..count.iter().product::<usize>() {
            let [i, j, k] = [n / (count[1] * count[2]), n / count[2] % count[1], n % count[2]];
            let ring = |k| {
                [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]].map(|at| grid.node(at))
            };
            self.elements.push((part, Shape::Hex8, [ring(k), ring(k + 1)].concat()));
        }
        grid
    }

    /// Cuts all hexahedra into solids of another shape: six tetrahedra around a diagonal, with four
    /// or ten nodes, or two wedges. Nodes on edges are in their middles.
    pub fn cut(&mut self, shape: Shape) {
        if shape == Shape::Hex8 {
            return;
        }
        let mut middles = BTreeMap::new();
        for (part, of, c) in std::mem::take(&mut self.elements) {
            if of != Shape::Hex8 {
                self.elements.push((part, of, c));
                continue;
            }
            if shape == Shape::Wedge6 {
                for wedge in [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]] {
                    self.elements.push((part, shape, wedge.map(|n: usize| c[n]).to_vec()));
                }
                continue;
            }
            let around = [1, 2, 3, 7, 4, 5];
            for i in 0..6 {
                let mut corners =
                    [0, around[i], around[(i + 1) % 6], 6].map(|n: usize| c[n]).to_vec();
                if shape == Shape::Tet10 {
                    for [a, b] in EDGES_OF_TET10 {
                        let ends: [usize; 2] = [corners[a], corners[b]];
                        corners.push(self.middle(ends, &mut middles));
                    }
                }
                self.elements.push((part, shape, corners));
            }
        }
    }

    /// Returns the node in the middle of an edge, which is added if there is none yet.
    fn middle(&mut self, ends: [usize; 2], known: &mut BTreeMap<[usize; 2], usize>) -> usize {
        let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        if let Some(&node) = known.get(&key) {
            return node;
        }
        let [from, to] = key.map(|n| self.points[n]);
        let node = self.point([0, 1, 2].map(|c| 0.5 * (from[c] + to[c])));
        known.insert(key, node);
        node
    }

    /// Returns the nodes whose coordinate along `axis` is exactly that of this node, as it is for
    /// nodes of a plane and the middles between them.
    pub fn plane(&self, axis: usize, of: usize) -> Vec<usize> {
        let at = self.points[of][axis];
        (0..self.points.len()).filter(|&n| self.points[n][axis] == at).collect()
    }

    /// Connects two rows of nodes of equal length by a row of quads. A closed row returns to its
    /// start.
    pub fn strip(&mut self, part: u32, one: &[usize], other: &[usize], closed: bool) {
        debug_assert_eq!(one.len(), other.len());
        let n = one.len();
        for i in 0..if closed { n } else { n - 1 } {
            let j = (i + 1) % n;
            self.quad(part, [one[i], other[i], other[j], one[j]]);
        }
    }

    /// Connects two closed rows by shells. Each side on `coarse` is opposite to the same number of
    /// sides on `fine`. The shells are triangles, with a quad in the middle if that number is odd.
    pub fn fans(&mut self, part: u32, fine: &[usize], coarse: &[usize]) {
        let (n, pieces) = (coarse.len(), fine.len() / coarse.len());
        debug_assert_eq!(fine.len(), n * pieces);
        let (first, second) = (pieces / 2, pieces.div_ceil(2));
        for i in 0..n {
            let [here, there] = [coarse[i], coarse[(i + 1) % n]];
            let at = |k: usize| fine[(i * pieces + k) % fine.len()];
            for k in (0..pieces).filter(|k| !(first..second).contains(k)) {
                let tip = if k < first { here } else { there };
                self.triangle(part, [at(k), tip, at(k + 1)]);
            }
            if first == second {
                self.triangle(part, [at(first), here, there]);
            } else {
                self.quad(part, [at(first), here, there, at(second)]);
            }
        }
    }

    /// Adds nodes to a named set.
    pub fn set(&mut self, name: &str, nodes: impl IntoIterator<Item = usize>) {
        self.sets.entry(name.to_string()).or_default().extend(nodes);
    }

    /// Returns the mesh, numbered from 1 in slices of width `slice` [length] along x; within a
    /// slice along y, then z.
    pub fn finish(self, slice: f64) -> Mesh {
        // Rounded to thousandths of a slice, so that the order does not depend on round-off
        // between mirrored points.
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
        let centre = |corners: &[usize]| {
            [0, 1, 2].map(|c| {
                corners.iter().map(|&i| self.points[i][c]).sum::<f64>() / corners.len() as f64
            })
        };
        let mut elements: Vec<usize> = (0..self.elements.len()).collect();
        elements.sort_by_key(|&e| key(centre(&self.elements[e].2), e));
        Mesh {
            nodes: order.iter().map(|&i| MeshNode { id: id[i], x: self.points[i] }).collect(),
            elements: elements
                .iter()
                .zip(1..)
                .map(|(&e, number)| {
                    let (part, shape, corners) = &self.elements[e];
                    let corners: Vec<NodeId> = corners.iter().map(|&i| id[i]).collect();
                    MeshElement::new(ElemId(number), *part, *shape, &corners)
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
            initial: Vec::new(),
        }
    }
}

/// The nodes of a [`Builder::block`].
pub struct BlockNodes {
    nodes: Vec<usize>,
    count: [usize; 3],
}

impl BlockNodes {
    /// Node (i, j, k).
    pub fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        self.nodes[(i * (self.count[1] + 1) + j) * (self.count[2] + 1) + k]
    }

    /// All nodes.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.nodes.iter().copied()
    }

    /// Returns the nodes on one of the six faces: the first (`end` false) or last along `axis`.
    pub fn face(&self, axis: usize, end: bool) -> Vec<usize> {
        let [a, b, c] = self.count.map(|n| n + 1);
        let at = if end { self.count[axis] } else { 0 };
        let number = |n: usize| [n / (b * c), n / c % b, n % c];
        (0..a * b * c).map(number).filter(|ijk| ijk[axis] == at).map(|ijk| self.node(ijk)).collect()
    }
}

/// Returns positions from 0 to `end` [length]: `fine` steps of size `first`, then growing steps,
/// scaled so that the last position is `end`.
pub fn graded(first: f64, fine: usize, end: f64) -> Vec<f64> {
    let mut places: Vec<f64> = (0..=fine).map(|i| i as f64 * first).collect();
    let mut step = first;
    while places[places.len() - 1] + step < end {
        step *= GROWTH;
        places.push(places[places.len() - 1] + step);
    }
    let (from, last) = (places[fine], places[places.len() - 1]);
    places[fine + 1..]
        .iter_mut()
        .for_each(|x| *x = from + (*x - from) * (end - from) / (last - from));
    places
}
