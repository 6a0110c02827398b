//! Contact laws. One file per law, one row in [`CONTACT_LAWS`].

mod lagrange;
mod penalty;
#[cfg(test)]
mod tests;

use crate::contact::geometry::V3;
use crate::contact::pairs::Pair;
use crumple_proto::job::Contact;

/// Steps of the central difference scheme around the present time.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// To the next time: positions move by `dt` times the mid-step velocity [time].
    pub dt: f64,
    /// From the last to the next mid-step: velocities change by `mid` times the acceleration [time].
    pub mid: f64,
}

/// How the force of a pair follows from its gap and relative velocity.
///
/// All pairs are updated from the same state, then their forces are added up, sweep after sweep. A law leaves a
/// force exactly as it is once it is good enough: when no force changes any more, further sweeps would change
/// nothing, and stopping early is not felt in the bits.
pub trait ContactLaw: Send + Sync {
    /// Most sweeps within a step.
    fn sweeps(&self) -> usize;
    /// Whether the mass of a node is split among its pairs.
    fn splits_mass(&self) -> bool;
    /// Force that a pair starts the step with, given what is remembered.
    fn start(&self, pair: &Pair, steps: Steps) -> V3;
    /// New force of a pair whose node moves with `velocity` relative to the contact point at the next mid-step,
    /// all present forces felt; `None` if the present force is good enough.
    fn update(&self, pair: &Pair, velocity: &V3, steps: Steps) -> Option<V3>;
    /// Tangential distance from the stick point after the step.
    fn slip(&self, pair: &Pair, velocity: &V3, steps: Steps) -> V3;
}

/// A row of the table of laws.
pub struct LawRow {
    /// Name in the job.
    pub name: &'static str,
    /// Makes the law from the job's numbers.
    pub build: fn(&Contact) -> Box<dyn ContactLaw>,
}

/// All contact laws.
pub const CONTACT_LAWS: &[LawRow] = &[lagrange::LAW, penalty::LAW];

/// The part of `f` along `normal`, and the rest.
fn split(f: &V3, normal: &V3) -> (f64, V3) {
    let along = f.dot(normal);
    (along, f - normal * along)
}

/// Tangential force held within the friction cone of normal force `pressed`.
fn within_cone(tangential: V3, pressed: f64, friction: f64) -> V3 {
    let (size, limit) = (tangential.norm(), friction * pressed);
    if size > limit { tangential * (limit / size) } else { tangential }
}
