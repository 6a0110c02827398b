//! Contact laws. One file per law, one row in [`CONTACT_LAWS`].

mod kinematic;
mod lagrange;
mod mortar;
mod penalty;
#[cfg(test)]
mod tests;

pub use lagrange::ITERATIONS;
pub use penalty::FORMS as PENALTY_FORMS;

use crate::contact::geometry::V3;
use crate::contact::pairs::Pair;
use crate::contact::surface::Segment;
use crate::nodes::Row;
use crumple_proto::job::Contact;

/// Steps of the central difference scheme around the present time.
#[derive(Clone, Copy, Debug)]
pub struct StepSizes {
    /// To the next time: positions move by `dt` times the mid-step velocity [time].
    pub dt: f64,
    /// From the last to the next mid-step: velocities change by `mid` times the acceleration
    /// [time].
    pub dt_velocity: f64,
    /// The same for the forces of contact and walls, which come after damping: with the damping a
    /// they change velocities by `mid / (1 + a mid / 2)` times the acceleration, so that what is at
    /// rest needs no other forces than without [time].
    pub dt_damped: f64,
    /// The step that elements and contact allow, which `dt` falls short of where a run comes to its
    /// end [time].
    pub dt_stable: f64,
}

impl StepSizes {
    /// What a force gives over the change of momentum that it makes beside damping, `mid / push`.
    pub fn given(&self) -> f64 {
        self.dt_velocity / self.dt_damped
    }
}

/// What laws know of the parts that touch.
#[derive(Clone, Debug, Default)]
pub struct Elasticity {
    /// Fraction of the elements' stable step that is used.
    pub safety: f64,
    /// Young's modulus per part [force/length^2].
    pub moduli: Vec<f64>,
    /// Wave speed per part, that of a plate [length/time].
    pub speeds: Vec<f64>,
    /// See [`with_edges`](crate::contact::beams::with_edges).
    pub with_edges: bool,
}

/// How the forces of all pairs, which feel each other through common nodes, come about within a
/// step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Iteration {
    /// All pairs are updated from the same state, each nodal mass split among the pairs that use
    /// it. Converges whatever the masses: an update is damped by no less than the coupling.
    Split,
    /// One pair after the other in ascending (node, segment), each with full masses and feeling
    /// those before it. Projected Gauss-Seidel: converges whatever the masses, faster than `Split`
    /// where nodes have few pairs.
    GaussSeidel,
    /// First guesses for all pairs, then corrections by how segments would move under all of them.
    /// Where two surfaces are slaves of each other, one of them gets this fraction of the
    /// correction.
    Correct {
        /// See above.
        partition: f64,
        /// Fraction of a force below which what it still needs counts as nothing.
        little: f64,
    },
}

/// How the force of a pair follows from its gap and relative velocity.
///
/// Forces are updated sweep after sweep. A law leaves a force exactly as it is once it is good
/// enough: when no force changes any more, further sweeps would change nothing, and stopping early
/// is not felt in the bits.
pub trait ContactLaw: Send + Sync {
    /// Most sweeps within a step.
    fn sweeps(&self) -> usize;
    /// How sweeps are made.
    fn iteration(&self) -> Iteration;
    /// Whether sweeps go on until every pair has the force that it should have, so that more of
    /// them, or faster ones, are nearer to it. Passes of prediction and correction are no such
    /// sweeps: where they are left off they have taken energy, and where they are accelerated they
    /// give it.
    fn converges(&self) -> bool {
        false
    }
    /// What plain sweeps may leave undone before accelerated ones follow, over what may be left at
    /// all ([`ContactLaw::refine`]).
    fn coarse(&self) -> f64 {
        1.0
    }
    /// Whether segments meet segments, where they face each other, in place of nodes.
    fn by_segments(&self) -> bool {
        false
    }
    /// Stiffness that contact with a segment has, from its material and its initial shape at
    /// coordinates `x0` [force/length]; `None` from laws that want none.
    fn segment_stiffness(&self, _segment: &Segment, _x0: &[Row]) -> Option<f64> {
        None
    }
    /// Force that a pair starts the step with, given what is remembered.
    fn initial_force(&self, pair: &Pair, steps: StepSizes) -> V3;
    /// First guess of what is to be added to a pair's force, as if its segment stood still; for
    /// [`Iteration::Correct`].
    fn guess(&self, _pair: &Pair, _velocity: &V3, _steps: StepSizes) -> V3 {
        V3::zeros()
    }
    /// New force of a pair whose node moves with `velocity` relative to the contact point at the
    /// next mid-step, all present forces felt; `None` if the present force is good enough. It
    /// depends on nothing else: a pair is not asked again before one of its nodes moves otherwise.
    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3>;
    /// The force that [`ContactLaw::update`] gives, also where the present one is good enough, and
    /// what that leaves undone over what may be left: above 1 if it is not good enough. For
    /// accelerated sweeps, which need the residuals of all pairs. `None` if the pair can have no
    /// other force.
    fn refine(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<(V3, f64)> {
        self.update(pair, velocity, steps).map(|force| (force, f64::INFINITY))
    }
    /// Tangential distance from the stick point after the step.
    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3;
    /// Whether the pair is held softer than the job asks, so that the step stays stable.
    fn is_capped(&self, _pair: &Pair, _steps: StepSizes) -> bool {
        false
    }
}

/// A row of the table of laws.
pub struct LawRow {
    /// Name in the job.
    pub name: &'static str,
    /// What it is, in a line.
    pub meaning: &'static str,
    /// Makes the law from the job's numbers. Panics on names that the master's checks refuse.
    pub build: fn(&Contact, &Elasticity) -> Box<dyn ContactLaw>,
}

/// All contact laws.
pub const CONTACT_LAWS: &[LawRow] = &[lagrange::LAW, kinematic::LAW, penalty::LAW, mortar::LAW];

/// Whether segments meet segments in an interface of a job.
pub fn by_segments(job: &Contact) -> bool {
    job.each().any(|c| c.law == mortar::LAW.name)
}

/// The laws of a job's interfaces.
pub struct Laws {
    /// By interface; none where nothing touches.
    of: Vec<Option<Box<dyn ContactLaw>>>,
    /// Ways to iterate that they have, each once.
    iterations: Vec<Iteration>,
    sweeps: usize,
    coarse: f64,
}

impl Laws {
    /// Of `[contact]` and its interfaces.
    ///
    /// # Panics
    /// On a law that is not in the table; the master checks names before it deals out work.
    pub fn new(job: &Contact, parts: &Elasticity) -> Self {
        let build = |contact: Contact| {
            let row = CONTACT_LAWS.iter().find(|row| row.name == contact.law);
            let row = row.unwrap_or_else(|| panic!("no contact law {}", contact.law));
            (row.build)(&contact, parts)
        };
        let of = job.each().map(|c| (c.law != Contact::NO_LAW).then(|| build(c)));
        let of: Vec<Option<Box<dyn ContactLaw>>> = of.collect();
        let mut iterations = Vec::new();
        for iteration in of.iter().flatten().map(|law| law.iteration()) {
            if !iterations.contains(&iteration) {
                iterations.push(iteration);
            }
        }
        let sweeps = of.iter().flatten().map(|law| law.sweeps()).max().unwrap_or(0);
        let coarse = of.iter().flatten().filter(|law| law.converges()).map(|law| law.coarse());
        let coarse = coarse.fold(f64::INFINITY, f64::min);
        Self { of, iterations, sweeps, coarse }
    }

    /// Number of interfaces.
    pub fn count(&self) -> usize {
        self.of.len()
    }

    /// By interface, whether segments meet segments there.
    pub fn by_segments(&self) -> Vec<bool> {
        self.of.iter().map(|law| law.as_ref().is_some_and(|law| law.by_segments())).collect()
    }

    /// The law of an own pair.
    ///
    /// # Panics
    /// If nothing touches in its interface: there are no such pairs.
    pub fn of_pair(&self, pair: &Pair) -> &dyn ContactLaw {
        self.of[pair.interface as usize].as_deref().expect("what touches has a law")
    }

    /// Ways to iterate that the laws have, each once, in the order of the interfaces.
    pub fn iterations(&self) -> &[Iteration] {
        &self.iterations
    }

    /// Most sweeps of any law within a step.
    pub fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// The least that a law which converges has as [`ContactLaw::coarse`].
    pub fn coarse(&self) -> f64 {
        self.coarse
    }

    /// Whether any law has [`ContactLaw::converges`].
    pub fn converge(&self) -> bool {
        self.of.iter().flatten().any(|law| law.converges())
    }

    /// See [`ContactLaw::segment_stiffness`]: laws that have one agree on it.
    pub fn segment_stiffness(&self, segment: &Segment, x0: &[Row]) -> Option<f64> {
        self.of.iter().flatten().find_map(|law| law.segment_stiffness(segment, x0))
    }
}

/// A force is good enough when it leaves less than this fraction of the contact thickness of the
/// gap unclosed: little enough for a block that rests under its own weight (a coarser limit leaves
/// forces that push on by themselves and pump energy into what is at rest), enough to end sweeps
/// over forces of round-off.
const GAP: f64 = 1e-11;
/// Speed at which penetration is taken out at most, as a fraction of the wave speed of what
/// touches. A surface that is moved with the speed v sends out a wave of the strain v/c (Graff
/// 1975, ch. 2): this one, some 8 MPa and 0.2 m/s in steel, harms nothing, whatever the step, the
/// thickness and the mesh. What a step leaves over is far below; where sweeps cannot do better, or
/// a node comes upon a segment from its rim, it must not be thrown out.
const CORRECT: f64 = 4e-5;
/// A stick point lasts through steps in which its pair bears nothing, as long as it stays touching
/// and within this fraction of the contact thickness: where several pairs hold a body, which of
/// them bears the load changes from step to step. What has lifted off or slid farther sticks anew;
/// friction does no more than mu N times this length beyond its due.
const STAY: f64 = 1e-4;

/// The gap that is to be closed, or the part of a penetration that is to be taken out in this step
/// [length].
fn overlap(pair: &Pair, steps: StepSizes) -> f64 {
    pair.gap.max(-CORRECT * pair.speed * steps.dt)
}

/// Tangential distance from the stick point after the step, nought where the node slides or leaves
/// [length]. It slides if the force that would bring it back to its stick point leaves the cone;
/// what the force at hand is does not tell, since a law may leave it a little short of the cone.
fn stuck(pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
    if pair.friction_coefficient == 0.0 {
        return V3::zeros(); // the cone is a line: nothing sticks
    }
    let (pressed, sheared) = split(&pair.force, &pair.normal);
    let (opening, sliding) = split(velocity, &pair.normal);
    let slip = pair.slip + sliding * steps.dt;
    if pressed <= 0.0 {
        let near = STAY * pair.contact_thickness;
        let stays = pair.gap + opening * steps.dt <= near && slip.norm() <= near;
        return if stays { slip } else { V3::zeros() };
    }
    let back = sheared - (pair.slip / steps.dt + sliding) / (steps.dt_damped * pair.compliance[1]);
    let sticks = back.norm() < pair.friction_force(pressed) * (1.0 - 1e-9);
    if sticks { slip } else { V3::zeros() }
}

/// Speed at which a pair's gap would be passed in the step at this velocity, 0 if it would not be
/// [length/time].
pub fn demand(pair: &Pair, velocity: &V3, steps: StepSizes) -> f64 {
    (-overlap(pair, steps) / steps.dt - velocity.dot(&pair.normal)).max(0.0)
}

/// The part of `f` along `normal`, and the rest.
fn split(f: &V3, normal: &V3) -> (f64, V3) {
    let along = f.dot(normal);
    (along, f - normal * along)
}

/// Tangential force held within the friction cone of normal force `pressed`, which the limit of
/// friction cuts to a cylinder.
pub fn within_cone(tangential: V3, pressed: f64, pair: &Pair) -> V3 {
    no_longer(tangential, pair.friction_force(pressed))
}

/// A vector, shortened to `limit`.
fn no_longer(v: V3, limit: f64) -> V3 {
    let size = v.norm();
    if size > limit { v * (limit / size) } else { v }
}
