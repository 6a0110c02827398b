//! Forces that parts exert on each other by contact, for histories.

use super::Contact;
use super::pairs::Pair;
use crumple_proto::histories::ContactShare;
use std::collections::BTreeMap;

impl Contact {
    /// Forces of the own pairs of the last step by the parts that they are between, ascending. Within a part there is none.
    /// A node that several parts share counts for the lowest of them that is in contact.
    pub fn forces_between_parts(&self) -> Vec<ContactShare> {
        let mut sums: BTreeMap<[u32; 2], [f64; 3]> = BTreeMap::new();
        for pair in self.own_table() {
            let Some([slave, met]) = self.parts_of(pair).filter(|[a, b]| a != b) else { continue };
            let sign = if slave < met { 1.0 } else { -1.0 };
            let sum = sums.entry([slave.min(met), slave.max(met)]).or_default();
            (0..3).for_each(|c| sum[c] += sign * pair.force[c]);
        }
        sums.into_iter().map(|(parts, force)| ContactShare { parts, force }).collect()
    }

    /// Parts of an own pair's slave and of what it meets.
    fn parts_of(&self, pair: &Pair) -> Option<[u32; 2]> {
        let s = &self.surface;
        let met = s.segments[s.segments.binary_search_by_key(&pair.segment, |g| g.id).ok()?].part;
        let slave = if pair.name.is_edge() {
            s.segments[self.edges.segment_of([pair.nodes[0], pair.nodes[1]])? as usize].part
        } else {
            s.first[s.slaves.binary_search(&pair.nodes[0]).ok()?].0
        };
        Some([slave, met])
    }
}
