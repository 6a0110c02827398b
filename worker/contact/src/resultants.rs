//! Contact forces between parts and between surfaces, for histories.

use super::Contact;
use super::pairs::Pair;
use crumple_fem::nodes::Nodes;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::Transducer;
use crumple_proto::ids::NodeId;
use std::collections::BTreeMap;

impl Contact {
    /// Adds the `share` of the forces of the own pairs of the last step to the sum of their two
    /// parts. Pairs within one part are left out. A node that several parts share counts for the
    /// lowest of them that is in contact.
    pub fn add_forces_between_parts(
        &self,
        share: f64,
        sums: &mut BTreeMap<[u32; 2], [ExactSum; 3]>,
    ) {
        for pair in self.owned_table() {
            let Some([slave, met]) = self.parts_of(pair).filter(|[a, b]| a != b) else { continue };
            let share = if slave < met { share } else { -share };
            let sum = sums.entry([slave.min(met), slave.max(met)]).or_default();
            (0..3).for_each(|c| sum[c].add(share * pair.force[c]));
        }
    }

    /// Adds the `share` of the forces of the own pairs of the last step to the sum of each
    /// transducer. A node that several parts share counts for the lowest of them that is in
    /// contact.
    pub fn add_forces_on(
        &self,
        transducers: &[Transducer],
        share: f64,
        nodes: &Nodes,
        sums: &mut [[ExactSum; 3]],
    ) {
        if transducers.is_empty() {
            return;
        }
        for pair in self.owned_table() {
            let Some([slave, met]) = self.parts_of(pair) else { continue };
            let ids = pair.nodes.map(|n| nodes.id.get(n as usize).copied().unwrap_or(NodeId(0)));
            let (first, rest) = ids[..pair.node_count()].split_at(pair.slave_node_count());
            for (transducer, sum) in transducers.iter().zip(&mut *sums) {
                let (on, from) = (&transducer.on, &transducer.from);
                let pushed = on.has(slave, first) && from.has(met, rest);
                let pushing = on.has(met, rest) && from.has(slave, first);
                let sign = f64::from(i8::from(pushed) - i8::from(pushing));
                if sign != 0.0 {
                    (0..3).for_each(|c| sum[c].add(share * sign * pair.force[c]));
                }
            }
        }
    }

    /// Returns the parts of the slave and of the target of an own pair.
    fn parts_of(&self, pair: &Pair) -> Option<[u32; 2]> {
        let s = &self.surface;
        let met = s.segments[s.segments.binary_search_by_key(&pair.segment, |g| g.id).ok()?].part;
        let slave = if pair.key.is_segment() {
            s.segments
                [s.segments.binary_search_by_key(&pair.key.slave_quarter().0, |g| g.id).ok()?]
            .part
        } else if pair.key.is_edge() {
            s.segments[self.edges.segment_of([pair.nodes[0], pair.nodes[1]])? as usize].part
        } else {
            s.precedes(s.slaves.binary_search(&pair.nodes[0]).ok()?).0
        };
        Some([slave, met])
    }
}
