//! Directions of springs that follow two nodes: the owners of the nodes send their positions to all
//! workers, which compute the same unit vectors and store them in the columns of their springs.
//! Scenes have few such springs.

use crate::fem::blocks::Blocks;
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use bytemuck::{Pod, Zeroable};
use crumple_proto::partition::Settings;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport};

/// Position of a followed node [length].
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct FollowedNode {
    /// Its place in the list of all followed nodes.
    place: u64,
    x: [f64; 3],
}

/// Stores the directions of springs at the present time in their columns. Collective.
///
/// # Errors
/// A worker is gone.
pub fn follow_nodes(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    blocks: &mut Blocks,
    settings: &Settings,
) -> Result<(), RankLost> {
    let ids = settings.followed.iter().flat_map(|(_, ids)| ids);
    let own: Vec<FollowedNode> = ids
        .zip(0..)
        .filter_map(|(&id, place)| {
            let n = nodes.local_index(id).filter(|&n| nodes.is_owned(n as usize))?;
            Some(FollowedNode { place, x: xyz(&nodes.x[n as usize]) })
        })
        .collect();
    let mut places = vec![[0.0; 3]; 2 * settings.followed.len()];
    let mut mail = Mailbox::default();
    mail.start();
    mail.extend(&own);
    own.iter().for_each(|node| places[node.place as usize] = node.x);
    mail.exchange_with_all(comm, Tag::Followed, |mail| {
        for node in mail.rest::<FollowedNode>() {
            places[node.place as usize] = node.x;
        }
    })?;
    let (pairs, _) = places.as_chunks::<2>();
    for ((part, _), &[from, to]) in settings.followed.iter().zip(pairs) {
        let line = V3::from(to) - V3::from(from);
        blocks.set_directions(*part, line.try_normalize(0.0).unwrap_or_default().into());
    }
    Ok(())
}
