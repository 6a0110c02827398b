//! Redundant pairs: two pairs that close the same gap.
//!
//! Where a node of one surface faces a node of the other, as on matched meshes, each of the two
//! is the slave of a pair with the other surface. Both pairs prevent the same relative motion of
//! the same nodes. Velocities do not depend on the division of the force among them, and sweeps
//! pass it from one to the other for long: 70 sweeps per step in the first 0.5 ms of
//! `cases/brick-wall`, and 34 % of the steps end with residuals above the tolerance. So only one
//! of the two pairs, the deeper one, gets a force: 33 sweeps, and all residuals are small.

use super::Peers;
use super::{Pair, PairTable};
use crate::surface::NOT_LOCAL;
use crumple_math::row::V3;
use crumple_proto::transport::RankLost;
use std::cmp::Ordering;

/// Smallest force weight of the node in the pair of the other node. With 0.9, the above figures are
/// 42 sweeps and 1 % of the steps.
const FACING: f64 = 0.7;
/// Largest cosine of the angle between the normals of the two pairs.
const OPPOSITE: f64 = -0.9;
/// Gaps are compared in units of this fraction of the contact thickness. So round-off does not
/// change from step to step which pair gets the force.
const RESOLUTION: f64 = 1e-6;

/// Returns the node of the target that the contact point nearly coincides with, if it is a local
/// node or a ghost.
fn faced_node(pair: &Pair) -> Option<u32> {
    let roles = pair.slave_node_count()..pair.node_count();
    let mut faced = roles.filter(|&r| pair.share(r) >= FACING).map(|r| pair.nodes[r]);
    faced.next().filter(|&n| pair.key.is_node() && n != NOT_LOCAL)
}

/// Orders pairs by depth, the deepest first, then by key.
fn by_depth(a: &Pair, b: &Pair) -> Ordering {
    // Copies of pairs of other workers have no `gap`.
    let gap = |p: &Pair| -p.penetration - p.tolerated_gap;
    // Zero has one sign, so that the round-off of a closed gap decides nothing.
    let depth = |p: &Pair| (gap(p) / (RESOLUTION * p.contact_thickness)).round() + 0.0;
    depth(a).total_cmp(&depth(b)).then(a.key.cmp(&b.key))
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
        let redundant = |p: &Pair| p.is_owned && is_iterated(p) && self.has_deeper_twin(p);
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

    /// Returns true if a deeper pair of the same interface closes the same gap. Its owner and the
    /// owner of `pair` both know both pairs, because each pair acts on the slave of the other.
    fn has_deeper_twin(&self, pair: &Pair) -> bool {
        let Some(faced) = faced_node(pair) else { return false };
        let Ok(place) = self.touched.binary_search(&faced) else { return false };
        let is_twin = |&(q, role): &(u32, u8)| {
            let other = &self.pairs[q as usize];
            role == 0
                && other.interface == pair.interface
                && faced_node(other) == Some(pair.nodes[0])
                && other.normal.dot(&pair.normal) < OPPOSITE
                && by_depth(other, pair).is_lt()
        };
        self.roles_at(place).iter().any(is_twin)
    }
}
