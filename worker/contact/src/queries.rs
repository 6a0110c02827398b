//! Data of contact that other stages read: histories, counts, forces, memory.

use super::Contact;
use super::diagnostics::crossing::{self, Crossing};
use super::enforce::Laws;
use super::pairs::{Pair, PairHistory, accelerated_velocity};
use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::ids::{NodeId, SegmentId};

impl Contact {
    /// Returns the bytes in use without pairs and without spare capacity of lists: surface,
    /// candidates, and the data that decides when to search.
    pub fn bytes(&self) -> usize {
        self.surface.bytes()
            + self.candidates.bytes()
            + self.histories.bytes()
            + size_of_val(&self.stiffness[..])
            + self.motion_since_near_list.bytes()
            + self.near_list.bytes()
            + self.projected_pairs.bytes()
            + self.record.bytes()
            + self.edges.bytes()
            + self.facets.bytes()
    }

    /// Returns the pair histories of each slave. Histories of edges are listed at all nodes of
    /// their pairs, those of segments at the segments' own nodes.
    pub fn pair_histories(&self) -> impl Iterator<Item = (u32, &[PairHistory])> {
        let of_slave = |(i, &slave)| (slave, self.histories.of_slave(i));
        let of_nodes = self.surface.slaves.iter().enumerate().map(of_slave);
        let others = self.edges.pair_histories().chain(self.facets.pair_histories());
        of_nodes.chain(others.map(|(n, m)| (n, std::slice::from_ref(m))))
    }

    /// Returns the edges that have passed through a surface, see [`crossing`].
    pub fn crossings(&self, nodes: &Nodes, time: f64) -> Vec<Crossing> {
        crossing::crossings(&self.surface, nodes, time, self.search_method)
    }

    /// Returns the range of the velocities of nodes that can be in contact, see
    /// [`Surface::velocities`].
    pub fn velocities(&self, nodes: &Nodes) -> [f64; 6] {
        self.surface.velocities(nodes)
    }

    /// Returns true if a part ever was near to contact, and true if it ever had a pair, as far
    /// as this worker knows.
    pub fn record_of(&self, part: usize) -> (bool, bool) {
        self.record.part_seen(&self.surface.segments, part)
    }

    /// Returns the active pairs of owned nodes after the last local search: ids of the slave, or
    /// its lower node, and of the segment.
    pub fn owned_pairs(&self) -> impl Iterator<Item = (NodeId, SegmentId)> + '_ {
        self.table.pairs.iter().filter(|p| p.is_owned).map(|p| (p.key.slave, p.segment))
    }

    /// Returns local nodes of the slaves of own pairs, to estimate the load.
    pub fn owned_pair_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.table.pairs.iter().filter(|p| p.is_owned).map(|p| p.nodes[0])
    }

    /// Returns the active pairs of owned nodes and edges after the last local search.
    pub fn owned_table(&self) -> impl Iterator<Item = &Pair> {
        self.table.pairs.iter().filter(|p| p.is_owned)
    }

    /// Returns the slaves that have near candidates, each with their number. Call it after
    /// [`Self::refresh_candidates`].
    pub fn count_near(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let runs = self.near_list.list.chunk_by(|a, b| a.slave_index == b.slave_index);
        runs.map(|run| (self.surface.slaves[run[0].slave_index as usize], run.len()))
    }

    /// Returns the slaves, each with the number of candidates that the last global search found
    /// for it.
    pub fn count_candidates(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        self.surface.slaves.iter().copied().zip(self.candidates.counts())
    }

    /// Returns the number of candidates of the last global search.
    pub fn candidates(&self) -> u64 {
        self.candidates.count() as u64
    }

    /// Returns the laws of the interfaces for the number of pairs of the last step.
    pub fn laws(&self) -> &Laws {
        self.laws.select(self.pairs)
    }

    /// Returns the nodes that pairs touch, ascending, with their velocities after contact but
    /// before walls [length/time].
    pub fn contact_forces<'a>(
        &'a self,
        nodes: &'a Nodes,
        steps: StepSizes,
    ) -> impl Iterator<Item = (u32, Row)> + 'a {
        let touched = self.table.touched.iter().zip(&self.table.total).zip(&self.free_velocities);
        touched.map(move |((&n, f), free)| {
            (n, accelerated_velocity(free, f, &nodes.inv_mass[n as usize], steps.dt_damped))
        })
    }

    /// Returns the contact force on local node `n` in this step [force].
    pub fn force_on(&self, n: u32) -> V3 {
        self.table.touched.binary_search(&n).map_or(V3::zeros(), |k| self.table.total[k])
    }

    /// Returns the moment of friction on local node `n` in this step [force length].
    pub fn couple_on(&self, n: u32) -> V3 {
        let place = self.table.touched.binary_search(&n).ok();
        place.and_then(|k| self.table.couples.get(k).copied()).unwrap_or(V3::zeros())
    }
}
