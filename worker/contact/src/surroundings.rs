//! The surroundings of contact: constraints on its nodes. Contact does not know them. It states
//! what it needs from them, and the caller implements these traits (`worker/src/coupling.rs`).

use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::transport::RankLost;

/// Nodes and segments that cannot move relative to each other and are excluded from contact.
pub trait Exclusions: Sync {
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
