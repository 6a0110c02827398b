//! Volume strain of nodes, for elements that average it
//! ([`Element::averaged_volume`](crate::elements::Element::averaged_volume)).
//!
//! A node has one mean for each part around it, over the elements of all workers in ascending
//! global id. So it has the same bits on every worker.

use super::Blocks;
use crate::nodes::Nodes;
use crumple_math::row::Row;
use crumple_proto::ids::ElemId;

/// Largest number of nodes of an element that averages: that of a wedge.
const MOST_NODES: usize = 6;

/// An element of another worker that averages, with at least one local node.
#[derive(Clone, Copy, Debug)]
pub struct RemoteVolume {
    /// The element.
    pub elem: ElemId,
    /// Index of its part.
    pub part: u32,
    /// Its local nodes; `None` for the others.
    pub nodes: [Option<u32>; MOST_NODES],
}

impl RemoteVolume {
    /// Creates an element without local nodes.
    pub fn new(elem: ElemId, part: u32) -> Self {
        Self { elem, part, nodes: [None; MOST_NODES] }
    }

    /// Adds a local node.
    pub fn add(&mut self, node: u32) {
        if let Some(free) = self.nodes.iter_mut().find(|n| n.is_none()) {
            *free = Some(node);
        }
    }
}

/// Means over the elements around the nodes.
#[derive(Debug, Default)]
pub struct NodalVolumes {
    /// Own elements, by block and index in the block.
    own: Vec<[usize; 2]>,
    /// Start of each own element in `corners`.
    first_corner: Vec<u32>,
    /// Indices of the means of the nodes, own element by own element.
    corners: Vec<u32>,
    /// For each mean, the start of its elements in `elements`.
    start: Vec<u32>,
    /// Indices into `changes`, mean by mean, in ascending element id.
    elements: Vec<u32>,
    /// Volume in the middle of the step and its change, each times the averaged share and over the
    /// number of nodes of the element [length^3]: of own elements, then of received ones.
    pub changes: Vec<[f64; 2]>,
    means: Vec<f64>,
}

impl NodalVolumes {
    /// Returns the own elements that average their volume strain, by block and index in the block.
    pub fn own_elements(blocks: &Blocks) -> Vec<[usize; 2]> {
        let averaging = blocks.blocks.iter().enumerate();
        let averaging = averaging.filter(|(_, b)| b.element.averaged_volume().is_some() && !b.idle);
        averaging.flat_map(|(block, b)| (0..b.count).map(move |i| [block, i])).collect()
    }

    /// Creates the means of the own elements, with elements of other workers; `None` without own
    /// elements.
    pub fn new(blocks: &Blocks, own: Vec<[usize; 2]>, remote: &[RemoteVolume]) -> Option<Self> {
        let corner = |node: u32, part: u32, elem: ElemId, index: usize| (part, node, elem, index);
        let mut around = Vec::with_capacity(MOST_NODES * (own.len() + remote.len()));
        let mut first_corner = vec![0];
        for (index, &[block, i]) in own.iter().enumerate() {
            let e = &blocks.elements[blocks.blocks[block].first + i];
            let nodes = e.nodes[..e.record.shape.corners()].iter();
            around.extend(nodes.map(|&n| corner(n, e.record.part, e.record.id, index)));
            first_corner.push(around.len() as u32);
        }
        let corners = vec![0; around.len()];
        for (index, e) in (own.len()..).zip(remote) {
            around.extend(e.nodes.iter().flatten().map(|&n| corner(n, e.part, e.elem, index)));
        }
        around.sort_unstable();
        let mut all =
            Self { corners, changes: vec![[0.0; 2]; own.len() + remote.len()], ..Self::default() };
        let mut next = first_corner.clone();
        for run in around.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let mean = all.start.len() as u32;
            all.start.push(all.elements.len() as u32);
            for &(.., index) in run {
                all.elements.push(index as u32);
                if index < own.len() {
                    all.corners[next[index] as usize] = mean;
                    next[index] += 1;
                }
            }
        }
        all.means = vec![0.0; all.start.len()];
        all.start.push(all.elements.len() as u32);
        (all.own, all.first_corner) = (own, first_corner);
        (!all.own.is_empty()).then_some(all)
    }

    /// Computes volumes and their changes in the last step, of size `dt` [time], of own elements.
    pub fn measure(&mut self, blocks: &Blocks, nodes: &Nodes, dt: f64) {
        let row = |[x, y, z, _]: Row| [x, y, z];
        for (change, &[block, i]) in self.changes.iter_mut().zip(&self.own) {
            let b = &blocks.blocks[block];
            let e = &blocks.elements[b.first + i];
            let has_failed =
                e.record.failed || b.element.can_fail() && b.element.failed(b.state(i));
            *change = if has_failed {
                [0.0; 2]
            } else {
                let n = e.record.shape.corners();
                let of = |rows: &[Row]| -> [[f64; 3]; MOST_NODES] {
                    std::array::from_fn(|c| row(rows[e.nodes[c.min(n - 1)] as usize]))
                };
                let [x, v] = [of(&nodes.x), of(&nodes.v)];
                let part = 1.0 / n as f64;
                b.element.volume_change([&x[..n], &v[..n]], dt).map(|of_all| part * of_all)
            };
        }
    }

    /// Computes the means from all changes and stores them in the histories of the own elements.
    pub fn store(&mut self, blocks: &mut Blocks) {
        for (mean, run) in self.means.iter_mut().zip(self.start.windows(2)) {
            let [mut volume, mut change] = [0.0; 2];
            for &index in &self.elements[run[0] as usize..run[1] as usize] {
                let [v, dv] = self.changes[index as usize];
                volume += v;
                change += dv;
            }
            *mean = if volume > 0.0 { change / volume } else { 0.0 };
        }
        for (&[block, i], range) in self.own.iter().zip(self.first_corner.windows(2)) {
            let corners = &self.corners[range[0] as usize..range[1] as usize];
            let of = |pair: &[u32]| pair.iter().map(|&mean| self.means[mean as usize]).sum::<f64>();
            let sum: f64 = corners.chunks(2).map(of).sum();
            blocks.blocks[block].set_averaged_volume(i, sum / corners.len() as f64);
        }
    }

    /// Returns the bytes in use, without unused capacity.
    pub fn bytes(&self) -> usize {
        let Self { own, first_corner, corners, start, elements, changes, means } = self;
        size_of_val(&own[..])
            + size_of_val(&first_corner[..])
            + size_of_val(&corners[..])
            + size_of_val(&start[..])
            + size_of_val(&elements[..])
            + size_of_val(&changes[..])
            + size_of_val(&means[..])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Class, LocalElement};
    use super::*;
    use crate::testing;
    use crumple_proto::ids::NodeId;
    use crumple_proto::job::Part;
    use crumple_proto::mesh::{OwnSection, Shape, corner_nodes};
    use crumple_proto::partition::{ElementRecord, Material, Settings};

    /// Height of the first tetrahedron over the common face; that of the second one is 1.
    const HEIGHT: f64 = 2.0;

    /// Returns two tetrahedra on both sides of a face, of these parts, and their nodes; the apex of
    /// the first one sinks by `sink` in a step of 1.
    fn pair(parts: [u32; 2], sink: f64) -> (Blocks, Nodes) {
        let below = [0.0, 0.0, -1.0];
        elements([(parts[0], &[1, 2, 3, 4]), (parts[1], &[1, 3, 2, 5])], &[below], sink)
    }

    /// Returns a tetrahedron as in `pair` and a wedge below it, of the height 1.
    fn with_wedge(sink: f64) -> (Blocks, Nodes) {
        let below = [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]];
        elements([(0, &[1, 2, 3, 4]), (0, &[5, 6, 7, 1, 2, 3])], &below, sink)
    }

    /// Returns two elements with ids 7 and 3, by part and nodes, and their nodes. The first three
    /// nodes are a right triangle of legs 1; node 4 is above it and sinks; those `below` follow.
    fn elements(two: [(u32, &[u64]); 2], below: &[[f64; 3]], sink: f64) -> (Blocks, Nodes) {
        let part = soft_part();
        let materials = vec![Material {
            name: "soft".into(),
            law: "elastic".into(),
            density: 1.0,
            // Wedges average above nu = 0.3.
            parameters: crate::elements::testing::elastic(1.0, 0.4, 1.0).parameters,
        }];
        let settings =
            Settings { parts: vec![part.clone(), part], materials, ..testing::settings() };
        let record = |id: u64, part: u32, nodes: &[u64]| ElementRecord {
            id: ElemId(id),
            part,
            shape: if nodes.len() == 4 { Shape::Tet4 } else { Shape::Wedge6 },
            nodes: corner_nodes(&nodes.iter().map(|&n| NodeId(n)).collect::<Vec<_>>()),
            free_faces: 0,
            failed: false,
            own: OwnSection::default(),
            mass_factor: 1.0,
            share: 1.0,
            slow: false,
            stable_dt: f64::INFINITY,
        };
        let above = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, HEIGHT - sink]];
        let mut nodes = testing::nodes_at(&[&above[..], below].concat());
        nodes.v[3] = [0.0, 0.0, -sink, 0.0];
        let local = |record: ElementRecord| LocalElement {
            nodes: record.nodes.map(|n| (n.0 as u32).saturating_sub(1)),
            record,
            shared: false,
            class: Class::Interior,
        };
        let all = [7, 3].into_iter().zip(two);
        let all = all.map(|(id, (part, nodes))| (local(record(id, part, nodes)), Vec::new()));
        (Blocks::new(&settings, all.collect()), nodes)
    }

    fn soft_part() -> Part {
        Part { material: "soft".into(), ..crate::elements::testing::part(0.0) }
    }

    /// Returns the stored volume strain increments of the two elements by id.
    fn stored(blocks: &mut Blocks, nodes: &Nodes) -> Vec<(ElemId, f64)> {
        let mut volumes = NodalVolumes::new(blocks, NodalVolumes::own_elements(blocks), &[])
            .expect("own elements");
        volumes.measure(blocks, nodes, 1.0);
        volumes.store(blocks);
        let mut all: Vec<(ElemId, f64)> = blocks
            .blocks
            .iter()
            .flat_map(|b| (0..b.count).map(move |i| (b, i)))
            .map(|(b, i)| {
                let column = b.element.averaged_volume().expect("it averages");
                (blocks.elements[b.first + i].record.id, b.state(i).at(column))
            })
            .collect();
        all.sort_by_key(|a| a.0);
        all
    }

    /// Nodes average over the elements around them, weighted by volume, but not over two parts.
    #[test]
    fn nodes_average_within_a_part() {
        let sink = 0.1;
        let (mid, change) = ((HEIGHT - 0.5 * sink) / 6.0, -sink / 6.0);
        let common = change / (mid + 1.0 / 6.0);
        let near = |found: Vec<(ElemId, f64)>, wanted: [f64; 2]| {
            let ids: Vec<u64> = found.iter().map(|f| f.0.0).collect();
            assert_eq!(ids, [3, 7]);
            for ((_, found), wanted) in found.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-15, "{found} for {wanted}");
            }
        };
        let (mut blocks, nodes) = pair([0, 0], sink);
        let wanted = [0.75 * common, 0.25 * (3.0 * common + change / mid)];
        near(stored(&mut blocks, &nodes), wanted);
        let (mut blocks, nodes) = pair([0, 1], sink);
        near(stored(&mut blocks, &nodes), [0.0, change / mid]);
    }

    /// A tetrahedron counts by a quarter of its volume at each node, a wedge by a sixth of the
    /// share that it averages: 1 - 13/28 at nu = 0.4.
    #[test]
    fn tetrahedra_and_wedges_average_together() {
        let sink = 0.1;
        let (mut blocks, nodes) = with_wedge(sink);
        let (mid, change) = ((HEIGHT - 0.5 * sink) / 6.0, -sink / 6.0);
        let averaged = 15.0 / 28.0;
        let common = (change / 4.0) / (mid / 4.0 + averaged * 0.5 / 6.0);
        let wanted = [3.0 * common / 6.0, 0.25 * (3.0 * common + change / mid)];
        for ((_, found), wanted) in stored(&mut blocks, &nodes).into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-15, "{found} for {wanted}");
        }
        // The wedge alone is strained.
        let (mut blocks, mut nodes) = with_wedge(0.0);
        let rate = 0.01;
        (4..7).for_each(|n| nodes.v[n] = [0.0, 0.0, rate, 0.0]);
        let [(_, own), (_, other)] = stored(&mut blocks, &nodes)[..] else { panic!("two") };
        let mid = 0.5 * (1.0 + 0.5 * rate);
        let strain = -0.5 * rate / mid;
        let weight = averaged * mid / 6.0;
        let share = weight / (weight + HEIGHT / 24.0);
        assert!((own - 0.5 * strain * (1.0 + share)).abs() < 1e-15, "{own}");
        assert!((other - 0.75 * strain * share).abs() < 1e-15, "{other}");
    }

    /// The pressure of a tetrahedron changes with the strain of a wedge as that of the wedge with
    /// the strain of the tetrahedron, times the share that the wedge averages: stress and strain
    /// have a potential.
    #[test]
    fn tetrahedra_and_wedges_have_a_potential() {
        let small = 1e-6;
        let averaged = 15.0 / 28.0;
        let [tetrahedron, wedge] = [HEIGHT / 6.0, 0.5];
        // Strains of one element, and what the other one averages.
        let (mut blocks, nodes) = with_wedge(small);
        let of_wedge = stored(&mut blocks, &nodes)[0].1 / (-small / HEIGHT);
        let (mut blocks, mut nodes) = with_wedge(0.0);
        (4..7).for_each(|n| nodes.v[n] = [0.0, 0.0, small, 0.0]);
        let of_tetrahedron = stored(&mut blocks, &nodes)[1].1 / -small;
        let (one, other) = (averaged * wedge * of_wedge, tetrahedron * of_tetrahedron);
        assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
    }

    /// An element of another worker counts at its local nodes, and a failed one does not.
    #[test]
    fn remote_elements_count_and_failed_ones_do_not() {
        let (blocks, nodes) = pair([0, 0], 0.1);
        let own = NodalVolumes::own_elements(&blocks);
        let (mut alone, mut whole) = (pair([0, 0], 0.1).0, pair([0, 0], 0.1).0);
        let wanted = stored(&mut whole, &nodes);
        // The second element comes from another worker.
        let second = own
            .iter()
            .position(|&[b, i]| blocks.elements[blocks.blocks[b].first + i].record.id == ElemId(3));
        let second = second.expect("it is there");
        let first = own[1 - second];
        let mut remote = RemoteVolume::new(ElemId(3), 0);
        remote.add(0);
        remote.add(1);
        remote.add(2);
        let mut volumes = NodalVolumes::new(&alone, vec![first], &[remote]).expect("own elements");
        volumes.measure(&alone, &nodes, 1.0);
        volumes.changes[1] = [1.0 / 24.0, 0.0];
        volumes.store(&mut alone);
        let column = alone.blocks[first[0]].element.averaged_volume().expect("it averages");
        let found = alone.blocks[first[0]].state(first[1]).at(column);
        assert!((found - wanted[1].1).abs() < 1e-15, "{found} {wanted:?}");
        let (mut gone, _) = pair([0, 0], 0.1);
        gone.elements.iter_mut().filter(|e| e.record.id == ElemId(3)).for_each(|e| {
            e.record.failed = true;
        });
        let left = stored(&mut gone, &nodes)[1].1;
        assert!((left + 0.1 / (HEIGHT - 0.05)).abs() < 1e-15, "{left}");
    }
}
