//! Redundant pairs: two pairs that close the same gap.
//!
//! Where a node of one surface faces a node of the other, as on matched meshes, each of the two
//! is the slave of a pair with the other surface. Both pairs prevent the same relative motion of
//! the same nodes. Velocities hardly depend on the division of the force among them, and sweeps
//! pass it from one to the other for long: 125 sweeps per step in the first 0.5 ms of
//! `cases/brick-wall`, and 113 of 410 steps end with residuals above the tolerance. So only one of
//! the two pairs gets a force: 85 sweeps, 4 such steps, and 0.4 of the time.
//!
//! At the first touch it is the deeper one, later the one that had the force in the step before. If
//! the meshes do not quite match, the pair without force sinks. At the depth `SINK_LIMIT` it gets a
//! force of its own. Were the deeper pair chosen in each step, each of the two would sink and close
//! its gap again within a step, in turn. This creates energy: plates of 5 by 5 and of 6 by 6 shells
//! that are pressed together would not come to rest (case C08 of the catalogue). Without the limit,
//! folds of the jeep frame are 0.1 of the contact thickness deep at 25 ms; with it 0.02.

use super::Peers;
use super::{Pair, PairTable};
use crate::surface::NOT_LOCAL;
use crumple_math::row::V3;
use crumple_proto::transport::RankLost;
use std::cmp::Ordering;

/// Smallest force weight of the node in the pair of the other node. The lower it is, the fewer
/// sweeps are made: contact of `cases/brick-wall` to 0.5 ms takes 2.4 s with 0.9, 1.8 s with 0.85
/// and 1.1 s with 0.7. But then pairs of meshes that only nearly match lose constraints that they
/// need. With 0.7, the forces on nodes of 5 by 5 below 6 by 6 shells (weights 0.80 and 0.83) are
/// 24 % off (C08), and limited friction on coarse facets is 13 % too low.
const FACING: f64 = 0.85;
/// Largest cosine of the angle between the normals of the two pairs.
const OPPOSITE: f64 = -0.9;
/// Gaps at the first touch are compared in units of this fraction of the contact thickness, so that
/// round-off does not decide which pair gets the force.
const RESOLUTION: f64 = 1e-6;
/// Depth to which a pair without force may sink, as a fraction of the contact thickness. A pair
/// that gets a force closes its gap, which adds energy, so this is to be rare: plates of 9 by 9 and
/// of 10 by 10 shells as in C08 sink to 3e-4 under 10 MPa.
const SINK_LIMIT: f64 = 1e-2;

/// Returns the node of the target that the contact point nearly coincides with, if it is a local
/// node or a ghost.
fn faced_node(pair: &Pair) -> Option<u32> {
    let roles = pair.slave_node_count()..pair.node_count();
    let mut faced = roles.filter(|&r| pair.share(r) >= FACING).map(|r| pair.nodes[r]);
    faced.next().filter(|&n| pair.key.is_node() && n != NOT_LOCAL)
}

/// Returns the gap that the law closes. Copies of pairs of other workers have no `gap` [length].
fn gap(pair: &Pair) -> f64 {
    -pair.penetration - pair.tolerated_gap
}

/// Returns true if the pair had a force in the step before.
fn had_force(pair: &Pair) -> bool {
    pair.force != V3::zeros()
}

/// Orders pairs by depth, the deepest first, then by key.
fn by_depth(a: &Pair, b: &Pair) -> Ordering {
    // Zero has one sign, so that the round-off of a closed gap decides nothing.
    let depth = |p: &Pair| (gap(p) / (RESOLUTION * p.contact_thickness)).round() + 0.0;
    depth(a).total_cmp(&depth(b)).then(a.key.cmp(&b.key))
}

/// Returns true if `other` closes the gap of its twin `pair`, which needs no force then.
fn replaces(other: &Pair, pair: &Pair) -> bool {
    match [other, pair].map(had_force) {
        [_, true] => false,
        [true, false] => gap(pair) >= -SINK_LIMIT * pair.contact_thickness,
        [false, false] => by_depth(other, pair).is_lt(),
    }
}

impl PairTable {
    /// Finds the redundant pairs among the pairs for which `is_iterated` returns true, and removes
    /// their forces and their effect on compliances. All workers that know a pair agree on it.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn remove_redundant_forces(
        &mut self,
        peers: &mut impl Peers,
        is_iterated: impl Fn(&Pair) -> bool,
    ) -> Result<(), RankLost> {
        let redundant = |p: &Pair| p.is_owned && is_iterated(p) && self.is_replaced(p);
        let mut flags: Vec<bool> = self.pairs.iter().map(redundant).collect();
        if peers.has_shared_pairs() {
            peers.exchange_flags(&mut flags)?;
        }
        for (pair, _) in self.pairs.iter_mut().zip(flags).filter(|&(_, is_redundant)| is_redundant)
        {
            (pair.force, pair.area) = (V3::zeros(), 0.0);
        }
        Ok(())
    }

    /// Returns true if another pair of the same interface closes the same gap in its place. Its
    /// owner and the owner of `pair` both know both pairs, because each pair acts on the slave of
    /// the other.
    fn is_replaced(&self, pair: &Pair) -> bool {
        let Some(faced) = faced_node(pair) else { return false };
        let Ok(place) = self.touched.binary_search(&faced) else { return false };
        let is_twin = |&(q, role): &(u32, u8)| {
            let other = &self.pairs[q as usize];
            role == 0
                && other.interface == pair.interface
                && faced_node(other) == Some(pair.nodes[0])
                && other.normal.dot(&pair.normal) < OPPOSITE
                && replaces(other, pair)
        };
        self.roles_at(place).iter().any(is_twin)
    }
}
