//! Walls that have a mass: what nodes give them in a step.
//!
//! A node of mass m that would be behind the wall goes on with the wall's velocity V, plastically,
//! and closes its gap g: it gets the impulse `m (V - u)` with `u = v + g / dt`, the velocity of the
//! wall at which the two would just touch. The wall gets the opposite, `M (V0 - V) = sum m (V - u)`
//! over all nodes with u < V. The sum grows with V, so there is one solution: the nodes join in
//! ascending u until the next one is ahead of the wall.
//!
//! Every worker tells every other of its own nodes that may touch, and all solve alike, to the bit.

use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{RankLost, Tag, Transport};

/// A node that may touch a wall.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RecoilCandidate {
    /// Global id.
    pub node: NodeId,
    /// Mass that can move along the wall's normal [mass].
    pub mass: f64,
    /// Velocity of the wall along its normal at which it would just touch the node [length/time].
    pub touching: f64,
}

/// Adds the nodes of all other workers.
///
/// # Errors
/// A worker is gone.
pub fn collect(
    comm: &mut dyn Transport,
    near: &mut Vec<RecoilCandidate>,
    words: &mut Vec<u64>,
) -> Result<(), RankLost> {
    let mine = comm.rank();
    let others = move |size: usize| (1..size).filter(move |&w| w != mine);
    for w in others(comm.size()) {
        comm.send(w, Tag::Walls, bytemuck::cast_slice(near))?;
    }
    for w in others(comm.size()) {
        comm.recv(w, Tag::Walls, words)?;
        near.extend_from_slice(bytemuck::cast_slice(words));
    }
    Ok(())
}

/// Velocity along its normal of a wall of mass `mass` that came with `speed`, after it has met the
/// nodes [length/time].
pub fn speed_after(mass: f64, speed: f64, near: &mut [RecoilCandidate]) -> f64 {
    near.sort_unstable_by(|a, b| a.touching.total_cmp(&b.touching).then(a.node.cmp(&b.node)));
    let (mut together, mut momentum, mut after) = (mass, mass * speed, speed);
    for n in near.iter() {
        if n.touching >= after {
            break;
        }
        together += n.mass;
        momentum += n.mass * n.touching;
        after = momentum / together;
    }
    after
}
