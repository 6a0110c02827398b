//! The other workers, as contact sees them. The caller implements the trait
//! (`worker/src/coupling.rs`). So the contact iteration is serial: it works on the pairs of this
//! worker and on copies of the pairs of other workers, as if there were one worker only.

use super::Pair;
use crumple_math::row::V3;
use crumple_proto::transport::RankLost;

/// The other workers. A pair is shared if several workers know it; its owner sends the new values.
pub trait Peers {
    /// Returns the number of pairs of all workers, if it is known before the sweeps. Then workers
    /// without pairs need not take part in sums and maxima.
    fn known_pairs(&self) -> Option<u64>;
    /// Returns true if this worker takes part in sums and maxima.
    fn takes_part(&self) -> bool;
    /// Returns true if some pairs are shared.
    fn has_shared_pairs(&self) -> bool;
    /// Exchanges the forces of shared pairs after a sweep. `changed` is true if the sweep has
    /// changed the force of an own pair. Returns true if all workers that are connected by shared
    /// pairs have converged.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_forces(&mut self, pairs: &mut [Pair], changed: bool) -> Result<bool, RankLost>;
    /// Exchanges the forces of shared pairs within a sweep.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_intermediate_forces(&mut self, pairs: &mut [Pair]) -> Result<(), RankLost>;
    /// Exchanges the predictor forces of shared pairs.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_predictor_forces(&mut self, pairs: &mut [Pair]) -> Result<(), RankLost>;
    /// Exchanges flags of shared pairs, by pair.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_flags(&mut self, flags: &mut [bool]) -> Result<(), RankLost>;
    /// Exchanges the phases of shared pairs, by pair. `changed` is true if an own pair has a new
    /// phase. Returns true if no connected worker has changed one, so that the phases are final.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_phases(&mut self, phases: &mut [u32], changed: bool) -> Result<bool, RankLost>;
    /// Sends the forces of the own shared pairs of a phase and receives those of other workers, in
    /// the order in which they are to be applied: indices of pairs, with their forces.
    ///
    /// # Errors
    /// A worker is gone.
    fn exchange_phase_forces(
        &mut self,
        pairs: &[Pair],
        phases: &[u32],
        phase: u32,
        received: &mut Vec<(u32, V3)>,
    ) -> Result<(), RankLost>;
    /// Returns the maximum of a number over all workers that take part.
    ///
    /// # Errors
    /// A worker is gone.
    fn max(&mut self, value: f64) -> Result<f64, RankLost>;
    /// Adds integers over all workers that take part, one by one.
    ///
    /// # Errors
    /// A worker is gone.
    fn sum(&mut self, values: &mut [i64]) -> Result<(), RankLost>;
}
