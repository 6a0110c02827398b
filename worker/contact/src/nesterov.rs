//! Momentum of sweeps with split masses: Nesterov's accelerated gradient method (Nesterov 1983;
//! for contact Mazhar, Heyn, Negrut & Tasora 2015, algorithm 1).
//!
//! With split masses the update of all pairs from one state, `x = G(y)`, is a projected gradient
//! step of length 1 in the metric of the pairs' own compliances, and 1 is not above the inverse of
//! the Lipschitz constant. The next sweep starts from
//!
//! `y' = x + (k - 1) / (k + 2) (x - x_before)`, projected onto the friction cone.
//!
//! The momentum of a pair restarts, k = 1, where the step and the momentum point in opposite
//! directions, `(y - x) . (x - x_before) > 0` (O'Donoghue & Candès 2015, sec. 3.2). They sum this
//! product over all unknowns. Here each pair has its own product, so a sweep needs no global
//! reduction: the forces of shared pairs are its only messages.

use crate::acceleration::within_friction_cone;
use crate::pairs::Pair;
use crumple_math::row::V3;

/// Momentum of the own pairs of a step.
#[derive(Debug, Default)]
pub struct NesterovMomentum {
    /// Force of each pair after the last sweep that changed it, before the momentum [force].
    before: Vec<V3>,
    /// Number of sweeps since the last restart of each pair.
    count: Vec<u32>,
}

impl NesterovMomentum {
    /// Starts a step with the first forces of all pairs, without momentum.
    pub fn start(&mut self, pairs: &[Pair]) {
        self.before.clear();
        self.before.extend(pairs.iter().map(|p| p.force));
        self.count.clear();
        self.count.resize(pairs.len(), 0);
    }

    /// Ends the momentum of pair `i`: its force is accurate enough, or is not updated.
    pub fn stop(&mut self, i: usize, pair: &Pair) {
        (self.before[i], self.count[i]) = (pair.force, 0);
    }

    /// Returns the force with which pair `i` starts the next sweep, if a sweep changes its force to
    /// `force` [force].
    pub fn advance(&mut self, i: usize, pair: &Pair, force: V3) -> V3 {
        let step = force - self.before[i];
        let is_opposed = (pair.force - force).dot(&step) > 0.0;
        self.before[i] = force;
        self.count[i] = if is_opposed { 0 } else { self.count[i] + 1 };
        let k = f64::from(self.count[i].max(1));
        within_friction_cone(pair, force + step * ((k - 1.0) / (k + 2.0)))
    }
}
