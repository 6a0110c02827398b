//! The surroundings of contact: constraints on its nodes, and other workers.
//!
//! Contact knows neither. It states what it needs from them, and the caller implements these traits
//! (`worker/src/coupling.rs`). So the contact iteration is serial: it works on the pairs of this
//! worker and on copies of the pairs of other workers, as if there were one worker only.

use crate::pairs::Pair;
use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::transport::RankLost;

/// Nodes and segments that cannot move relative to each other and are excluded from contact.
pub trait Exclusions {
    /// Returns true if the node and the segment belong to one rigid body, or if one is tied to the
    /// other.
    fn excludes(&self, node: u32, segment: &[u32; 4]) -> bool;
    /// Returns true if one of them is tied to the other.
    fn are_tied(&self, node: u32, segment: &[u32; 4]) -> bool;
}

/// Contact forces on nodes.
#[derive(Clone, Copy, Debug)]
pub struct NodalForces<'a> {
    /// Local nodes that pairs touch, ascending.
    pub touched: &'a [u32],
    /// Force on each of them [force].
    pub total: &'a [V3],
    /// Moment of friction on each of them; empty if no pair has one [force length].
    pub couples: &'a [V3],
}

/// Constraints on the velocities that contact changes.
///
/// A node is free, or it belongs to a rigid body. A free node gets the velocity of its contact
/// force, corrected by [`VelocityConstraint::allowed_velocity`]. The velocities of the nodes of a
/// body follow from the forces on all of them ([`VelocityConstraint::apply_forces`]).
pub trait VelocityConstraint {
    /// Prepares the sweeps over pairs that touch these nodes; with `couples` friction rotates
    /// nodes. Returns true if contact pairs involve a rigid body on any worker.
    ///
    /// # Errors
    /// A worker is gone.
    fn prepare(&mut self, nodes: &Nodes, touched: &[u32], couples: bool) -> Result<bool, RankLost>;
    /// Returns true if the node belongs to a rigid body.
    fn is_in_body(&self, node: u32) -> bool;
    /// Returns the inverse mass of a node with which compliances are computed [1/mass].
    fn inv_mass(&self, nodes: &Nodes, node: u32) -> Row;
    /// Returns the inverse rotational inertia of a node with which compliances are computed
    /// [1/(mass length^2)].
    fn inv_inertia(&self, nodes: &Nodes, node: u32) -> Row;
    /// Returns the velocity of a free node that would have the velocity `v`: walls stop it
    /// [length/time].
    fn allowed_velocity(&self, nodes: &Nodes, node: u32, v: Row, dt: f64) -> Row;
    /// Applies the forces to rigid bodies and sets the velocities of their touched nodes. Returns
    /// true if `changed` is true on any worker.
    ///
    /// # Errors
    /// A worker is gone.
    fn apply_forces(
        &mut self,
        nodes: &mut Nodes,
        forces: NodalForces<'_>,
        steps: StepSizes,
        changed: bool,
    ) -> Result<bool, RankLost>;
}

/// The other workers. A pair is shared if several workers know it; its owner sends the new values.
pub trait Peers {
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
    /// Returns the maximum of a number over all workers.
    ///
    /// # Errors
    /// A worker is gone.
    fn max(&mut self, value: f64) -> Result<f64, RankLost>;
    /// Adds integers over all workers, one by one.
    ///
    /// # Errors
    /// A worker is gone.
    fn sum(&mut self, values: &mut [i64]) -> Result<(), RankLost>;
}
