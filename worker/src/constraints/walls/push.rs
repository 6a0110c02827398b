//! Walls with a mass: impulses of nodes on them in a step.
//!
//! A node of mass m that would end behind the wall takes the wall's velocity V in a plastic
//! impact and closes its gap g. It receives the impulse `m (V - u)` with `u = v + g / dt`, the
//! velocity of the wall at which both would just touch. The wall receives the opposite, `M (V0 -
//! V) = sum m (V - u)` over all nodes with u < V. The sum increases with V, so there is one
//! solution: nodes are added in ascending u until the next one moves ahead of the wall.
//!
//! Every worker sends its owned nodes that may touch the wall to all others, and all solve for
//! the same bits.

use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport};

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

/// Adds the candidates of all other workers.
///
/// # Errors
/// A worker is gone.
pub fn collect(
    comm: &mut dyn Transport,
    near: &mut Vec<RecoilCandidate>,
    mail: &mut Mailbox,
) -> Result<(), RankLost> {
    mail.start();
    mail.extend(near);
    mail.exchange_with_all(comm, Tag::Walls, |mail| near.extend_from_slice(mail.rest()))
}

/// Returns the velocity along the normal, after the impact of nodes, of a wall of mass `mass`
/// with the initial velocity `speed` [length/time].
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
