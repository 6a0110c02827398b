//! Contact forces between parts and between surfaces, for histories.

use super::Contact;
use super::pairs::Pair;
use crate::nodes::Nodes;
use crumple_proto::histories::{ContactShare, PairForce, Transducer};
use crumple_proto::ids::NodeId;
use std::collections::BTreeMap;

impl Contact {
    /// Returns the forces of the own pairs of the last step, summed for each pair of parts,
    /// ascending. Pairs within one part are left out. A node that several parts share counts for
    /// the lowest of them that is in contact.
    pub fn forces_between_parts(&self) -> Vec<ContactShare> {
        let mut sums: BTreeMap<[u32; 2], [f64; 3]> = BTreeMap::new();
        for pair in self.owned_table() {
            let Some([slave, met]) = self.parts_of(pair).filter(|[a, b]| a != b) else { continue };
            let sign = if slave < met { 1.0 } else { -1.0 };
            let sum = sums.entry([slave.min(met), slave.max(met)]).or_default();
            (0..3).for_each(|c| sum[c] += sign * pair.force[c]);
        }
        sums.into_iter().map(|(parts, force)| ContactShare { parts, force }).collect()
    }

    /// Returns the forces of the own pairs of the last step on transducers, ascending by
    /// transducer and pair. A node that several parts share counts for the lowest of them that
    /// is in contact.
    pub fn forces_on_transducers(
        &self,
        transducers: &[Transducer],
        nodes: &Nodes,
    ) -> Vec<PairForce> {
        let mut felt = Vec::new();
        for pair in self.owned_table() {
            let Some([slave, met]) = self.parts_of(pair) else { continue };
            let ids = pair.nodes.map(|n| nodes.id.get(n as usize).copied().unwrap_or(NodeId(0)));
            let (first, rest) = ids[..pair.node_count()].split_at(pair.slave_node_count());
            for (transducer, number) in transducers.iter().zip(0..) {
                let (on, from) = (&transducer.on, &transducer.from);
                let pushed = on.has(slave, first) && from.has(met, rest);
                let pushing = on.has(met, rest) && from.has(slave, first);
                let sign = f64::from(i8::from(pushed) - i8::from(pushing));
                if sign != 0.0 {
                    let name = &pair.key;
                    let words = [name.slave.0, name.slave_end.0, name.target[0], name.target[1]];
                    let force = (pair.force * sign).into();
                    felt.push(PairForce { transducer: number, pair: words, force });
                }
            }
        }
        felt.sort_unstable_by_key(|p| (p.transducer, p.pair));
        felt
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
