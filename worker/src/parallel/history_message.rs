//! Pair histories of nodes in messages and checkpoints.

use crate::contact::pairs::PairHistory;
use crumple_proto::ids::NodeId;
use crumple_proto::transport::Mailbox;
use std::collections::BTreeMap;

/// Pair histories by node.
pub type Memories = BTreeMap<NodeId, Vec<PairHistory>>;

/// Appends the pair histories of a node.
pub fn put_histories(mail: &mut Mailbox, node: NodeId, list: &[PairHistory]) {
    mail.push(node);
    mail.push(list.len() as u64);
    mail.extend(list);
}

/// Takes the pair histories of a node. Returns `None` if the message has none.
pub fn take_histories(mail: &mut Mailbox) -> Option<(NodeId, Vec<PairHistory>)> {
    let (node, count): (NodeId, u64) = (mail.checked_take()?, mail.checked_take()?);
    Some((node, mail.checked_take_many(count)?.to_vec()))
}
