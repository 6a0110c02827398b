//! Finds the pairs and nodes that a sweep has to look at, if it updates all pairs from one state.
//!
//! The force of a pair depends on the motion of its nodes only. So a sweep updates the pairs with a
//! node on which another force has changed, and sums the forces of the nodes of changed pairs.

use super::PairTable;
use crate::surface::NOT_LOCAL;
use crumple_math::row::V3;

/// Activity of the pairs in the sweeps of a step.
#[derive(Debug, Default)]
pub struct Activity {
    /// True for each pair that the next sweep updates.
    is_due: Vec<bool>,
    /// Own pairs with a node that moves the pair, but on which no force of the pair acts. They are
    /// always due.
    always: Vec<u32>,
    /// Own pairs with a new force since the last sums.
    updated: Vec<u32>,
    /// Pairs of other workers.
    copies: Vec<u32>,
    /// Force of each pair in the sums of its nodes [force].
    summed: Vec<V3>,
    /// Nodes with changed forces, as indices of the table's `touched`, and true for each of these.
    changed: Vec<u32>,
    is_changed: Vec<bool>,
}

impl Activity {
    /// Ends the sweeps of a step.
    pub(super) fn reset(&mut self) {
        self.is_due.clear();
    }

    /// Returns true if the sweeps of this step use it.
    pub(super) fn is_started(&self) -> bool {
        !self.is_due.is_empty()
    }
}

impl PairTable {
    /// Starts the sweeps of a step, or continues them after velocities have changed other than by
    /// the forces of pairs: all own pairs are due. The nodes have the sums of the present forces.
    pub fn start_activity(&mut self) {
        let a = &mut self.activity;
        a.summed.clear();
        a.summed.extend(self.pairs.iter().map(|p| p.force));
        a.is_due.clear();
        a.is_due.extend(self.pairs.iter().map(|p| p.is_owned));
        a.is_changed.clear();
        a.is_changed.resize(self.touched.len(), false);
        [&mut a.always, &mut a.copies, &mut a.updated].into_iter().for_each(Vec::clear);
        for (i, pair) in (0..).zip(&self.pairs) {
            let only_moves = |r: usize| {
                pair.nodes[r] != NOT_LOCAL && pair.shape[r] != 0.0 && pair.share(r) == 0.0
            };
            if !pair.is_owned {
                a.copies.push(i);
            } else if (0..pair.node_count()).any(only_moves) {
                a.always.push(i);
            }
        }
    }

    /// Returns the own pairs that are due, ascending, after which none are due.
    pub fn take_due(&mut self) -> Vec<u32> {
        let a = &mut self.activity;
        a.always.iter().for_each(|&i| a.is_due[i as usize] = true);
        let due = |(i, due): (u32, &mut bool)| std::mem::take(due).then_some(i);
        (0..).zip(&mut a.is_due).filter_map(due).collect()
    }

    /// Sets a new force of an own pair.
    pub fn set_force(&mut self, i: u32, force: V3) {
        self.pairs[i as usize].force = force;
        self.activity.updated.push(i);
        // It is not accurate enough yet, even if it did not change.
        self.activity.is_due[i as usize] = true;
    }

    /// Sums the forces again on each node on which a force has changed. Calls `apply` with the
    /// index of the node in `touched`.
    pub fn sum_changed_forces(&mut self, mut apply: impl FnMut(&Self, usize)) {
        let mut a = std::mem::take(&mut self.activity);
        for &i in a.updated.iter().chain(&a.copies) {
            let i = i as usize;
            if std::mem::replace(&mut a.summed[i], self.pairs[i].force) == self.pairs[i].force {
                continue;
            }
            for &t in self.slots[i].iter().filter(|&&t| t != NOT_LOCAL) {
                if !std::mem::replace(&mut a.is_changed[t as usize], true) {
                    a.changed.push(t);
                }
            }
        }
        a.updated.clear();
        for t in a.changed.drain(..) {
            let t = t as usize;
            a.is_changed[t] = false;
            self.sum_forces_at(t);
            for &(q, _) in self.roles_at(t) {
                a.is_due[q as usize] |= self.pairs[q as usize].is_owned;
            }
            apply(self, t);
        }
        self.activity = a;
    }
}
