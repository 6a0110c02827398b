//! Histories of contact pairs with divided shells.

use super::division::NumberedDivision;
use crate::contact::pairs::{PairHistory, PairKey};
use crate::parallel::history_message::Memories;
use crumple_proto::ids::{ElemId, NodeId, SegmentId};
use std::collections::HashMap;

/// Gives the pair histories of nodes with divided shells to the quarters of these. The quarters lie
/// on the surface of the shell, so that the side and the penetration remain. Pairs of segments with
/// divided shells start again.
pub(super) fn hand_over(memories: &mut Memories, by_id: &HashMap<ElemId, &NumberedDivision>) {
    let division = |segment: u64| by_id.get(&SegmentId(segment).elem()).copied();
    let segments = |h: &PairHistory| {
        let count = if h.name.is_segment() { 2 } else { usize::from(h.name.is_node()) };
        [h.name.target[0], h.name.slave.0].into_iter().take(count)
    };
    let is_stale = |h: &PairHistory| segments(h).any(|segment| division(segment).is_some());
    for (&node, list) in memories.iter_mut().filter(|(_, list)| list.iter().any(is_stale)) {
        let mut new: Vec<PairHistory> = list.iter().filter(|h| !is_stale(h)).copied().collect();
        for history in list.iter().filter(|h| h.name.is_node()) {
            let quarters = division(history.name.target[0]).map(|d| d.quarters);
            new.extend(
                quarters.into_iter().flatten().map(|quarter| of_quarter(node, quarter, history)),
            );
        }
        new.sort_unstable_by_key(|h| h.name);
        *list = new;
    }
}

/// Returns the history of the pair of a node with a quarter.
fn of_quarter(node: NodeId, quarter: ElemId, whole: &PairHistory) -> PairHistory {
    PairHistory { name: PairKey::of_node(node, SegmentId::new(quarter, 0)), ..*whole }
}
