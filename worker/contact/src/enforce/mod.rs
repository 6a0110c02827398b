//! Contact laws: one file per law, one row in [`CONTACT_LAWS`].

mod kinematic;
mod lagrange;
mod mortar;
mod penalty;
#[cfg(test)]
mod tests;

use crate::pairs::Pair;
use crate::surface::Segment;
use crumple_fem::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_fem::registry::{Named, Registry};
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::job::ContactInput;
use crumple_proto::problem::Problem;

/// Data of the parts for the contact laws.
#[derive(Clone, Debug, Default)]
pub struct Elasticity {
    /// Fraction of the elements' stable step that is used.
    pub safety: f64,
    /// Young's modulus per part [force/length^2].
    pub moduli: Vec<f64>,
    /// Wave speed per part, that of a plate [length/time].
    pub speeds: Vec<f64>,
    /// See [`with_edges`](crate::beams::with_edges).
    pub with_edges: bool,
    /// True for the laws of steps with many pairs; [`LawSets::new`] sets it.
    pub is_dense: bool,
}

/// Number of pairs of a step, of all workers, from which on contact is dense. Then the messages
/// of a sweep count, and laws may select another iteration. The jeep frame has up to 32 pairs to
/// 12 ms and the brick wall up to 1500; the limit between them is a choice
/// (`cases/bench/RESULTS.md`, sweeps with momentum).
const DENSE: u64 = 300;

/// Method that computes the forces of all pairs within a step. The pairs are coupled through
/// common nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Iteration {
    /// All pairs are updated from the same state. Each nodal mass is split among the pairs that
    /// use it. Converges whatever the masses: an update is damped by no less than the coupling.
    /// Laws that converge add momentum (`nesterov.rs`).
    Split,
    /// One pair after the other in the order of `pairs/schedule.rs`, each with full masses and
    /// with the new forces of the pairs before it. Projected Gauss-Seidel: converges whatever the
    /// masses.
    GaussSeidel,
    /// Predictor forces of all pairs, then corrections by the motion of the segments under all
    /// of them. Where two surfaces are slaves of each other, one of them gets the fraction
    /// `partition` of the correction.
    Correct {
        /// Fraction of the correction, see above.
        partition: f64,
        /// Fraction of a force below which a missing force counts as zero.
        little: f64,
    },
}

/// Contact law: computes the force of a pair from its gap and relative velocity.
///
/// Forces are updated in sweeps. A law does not change a force once it is accurate enough. When
/// no force changes any more, further sweeps would change nothing. Therefore stopping early does
/// not change the bits of the result.
pub trait ContactLaw: Send + Sync {
    /// Returns the largest number of sweeps within a step.
    fn sweeps(&self) -> usize;
    /// Returns the method of the sweeps.
    fn iteration(&self) -> Iteration;
    /// Returns true if sweeps converge to the exact force of every pair, so that more sweeps or
    /// accelerated sweeps come nearer to it. Passes of prediction and correction do not converge
    /// in this sense: if they stop early they have dissipated energy, and if they are
    /// accelerated they create energy. Of two pairs that close the same gap, such a law gives a
    /// force to one only (`pairs/redundant.rs`), and with [`Iteration::Split`] its sweeps have
    /// momentum (`nesterov.rs`).
    fn converges(&self) -> bool {
        false
    }
    /// Returns the largest number of accelerated sweeps within a step.
    fn accelerated(&self) -> usize {
        0
    }
    /// Returns the residual of plain sweeps above which accelerated sweeps follow, as a multiple
    /// of the permitted residual ([`ContactLaw::refine`]).
    fn coarse(&self) -> f64 {
        1.0
    }
    /// Returns true if segments touch segments, where they face each other, in place of nodes.
    fn by_segments(&self) -> bool {
        false
    }
    /// Returns the stiffness of contact with a segment, from its material and its initial shape
    /// at coordinates `x0` [force/length]; `None` from laws that need none.
    fn segment_stiffness(&self, _segment: &Segment, _x0: &[Row]) -> Option<f64> {
        None
    }
    /// Returns the force with which a pair starts the step, from its history [force].
    fn initial_force(&self, pair: &Pair, steps: StepSizes) -> V3;
    /// Returns the predictor force: the amount to add to a pair's force if its segment stood
    /// still [force]. For [`Iteration::Correct`].
    fn guess(&self, _pair: &Pair, _velocity: &V3, _steps: StepSizes) -> V3 {
        V3::zeros()
    }
    /// Returns the new force of a pair whose node moves with `velocity` relative to the contact
    /// point at the next mid-step, with all present forces applied; `None` if the present force
    /// is accurate enough. The result depends on nothing else: a pair is updated again only
    /// after one of its nodes has changed its motion.
    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3>;
    /// Returns the force of [`ContactLaw::update`], also if the present force is accurate
    /// enough, and the residual of the present force as a multiple of the permitted residual
    /// (above 1: not accurate enough). Used by accelerated sweeps, which need the residuals of
    /// all pairs. Returns `None` if the pair can have no other force.
    fn refine(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<(V3, f64)> {
        self.update(pair, velocity, steps).map(|force| (force, f64::INFINITY))
    }
    /// Returns the tangential distance from the stick point after the step [length].
    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3;
    /// Returns true if the pair is softer than the job requests, so that the step stays stable.
    fn is_capped(&self, _pair: &Pair, _steps: StepSizes) -> bool {
        false
    }
}

/// A row of the table of laws.
pub struct LawRow {
    /// Name in the job.
    pub name: &'static str,
    /// Description in one line.
    pub meaning: &'static str,
    /// Its keys in `[contact]` and in interfaces, besides those of all laws. Laws with the same key
    /// have the same row of it.
    pub parameters: &'static [ParameterRow],
    /// Its keys in `[contact]` that interfaces cannot change.
    pub global: &'static [ParameterRow],
    /// Returns a conflict of its values with a safety factor of the step, with a path relative to
    /// the job.
    pub conflict: fn(&Values<'_>, f64) -> Option<Problem>,
    /// Builds the law from its values. Panics on words that the master's checks reject.
    pub build: fn(&Values<'_>, &Elasticity) -> Box<dyn ContactLaw>,
}

impl Named for LawRow {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl LawRow {
    /// Returns all its keys.
    pub fn keys(&self) -> impl Iterator<Item = &'static ParameterRow> + use<> {
        self.parameters.iter().chain(self.global)
    }

    /// Returns its values in the settings of an interface.
    pub fn values<'a>(&self, contact: &'a ContactInput) -> Values<'a> {
        Values::new([self.parameters, self.global], &contact.parameters)
    }
}

/// All contact laws.
pub static CONTACT_LAWS: Registry<LawRow> =
    Registry::new(&[lagrange::LAW, kinematic::LAW, penalty::LAW, mortar::LAW]);

/// Key of laws that iterate.
const SWEEPS: ParameterRow = ParameterRow {
    key: "sweeps",
    form: Form::Whole,
    otherwise: DefaultValue::Whole(20),
    range: Some(Range { wanted: "at least 1", fits: |n| n >= 1.0 }),
    meaning: "Largest number of plain sweeps over all pairs in a step (Lagrange; four times as \
              many with momentum), or of passes (kinematic; 1 in PRONTO3D).",
};

/// Key of laws that iterate.
const TOLERANCE: ParameterRow = ParameterRow {
    key: "tolerance",
    form: Form::Number,
    otherwise: DefaultValue::Number(1e-6),
    range: Some(Range { wanted: "above 0; 1e-6 is usual", fits: |x| x > 0.0 }),
    meaning: "Velocity that a force leaves to be changed, over the velocity that it has to change \
              (Lagrange). Relative change below which a force stays as it is (kinematic). See \
              `cases/studies/README.md`, bars.",
};

/// Returns true if segments touch segments in an interface of a job.
pub fn by_segments(job: &ContactInput) -> bool {
    job.each().any(|c| c.law == mortar::LAW.name)
}

/// Law of an interface, with its values that each update of a pair needs.
pub struct InterfaceLaw {
    /// The law.
    pub law: Box<dyn ContactLaw>,
    /// See [`ContactLaw::sweeps`].
    pub sweeps: usize,
    /// See [`ContactLaw::iteration`].
    pub iteration: Iteration,
    /// See [`ContactLaw::converges`].
    pub converges: bool,
}

impl InterfaceLaw {
    fn new(law: Box<dyn ContactLaw>) -> Self {
        let (sweeps, iteration, converges) = (law.sweeps(), law.iteration(), law.converges());
        Self { law, sweeps, iteration, converges }
    }
}

/// Laws of a job's interfaces, for steps with few and with many pairs.
pub struct LawSets([Laws; 2]);

impl LawSets {
    /// Builds the laws as [`Laws::new`].
    pub fn new(job: &ContactInput, parts: &Elasticity) -> Self {
        let build = |is_dense| Laws::new(job, &Elasticity { is_dense, ..parts.clone() });
        Self([false, true].map(build))
    }

    /// Returns the laws of a step, if the step before had this number of pairs on all workers.
    pub fn select(&self, pairs: u64) -> &Laws {
        &self.0[usize::from(Self::is_dense(pairs))]
    }

    /// Returns true if contact with this number of pairs on all workers is dense.
    pub fn is_dense(pairs: u64) -> bool {
        pairs >= DENSE
    }
}

/// Laws of a job's interfaces.
pub struct Laws {
    /// Law of each interface; `None` where nothing touches.
    of: Vec<Option<InterfaceLaw>>,
    /// Methods of iteration of the laws, each once.
    iterations: Vec<Iteration>,
    sweeps: usize,
    accelerated: usize,
    coarse: f64,
}

impl Laws {
    /// Builds the laws of `[contact]` and its interfaces.
    ///
    /// # Panics
    /// On a law that is not in the table; the master checks names before it distributes work.
    pub fn new(job: &ContactInput, parts: &Elasticity) -> Self {
        let build = |contact: ContactInput| {
            let row = CONTACT_LAWS.iter().find(|row| row.name == contact.law);
            let row = row.unwrap_or_else(|| panic!("no contact law {}", contact.law));
            (row.build)(&row.values(&contact), parts)
        };
        let of = job
            .each()
            .map(|c| (c.law != ContactInput::NO_LAW).then(|| InterfaceLaw::new(build(c))));
        let of: Vec<Option<InterfaceLaw>> = of.collect();
        let mut iterations = Vec::new();
        for iteration in of.iter().flatten().map(|law| law.iteration) {
            if !iterations.contains(&iteration) {
                iterations.push(iteration);
            }
        }
        let sweeps = of.iter().flatten().map(|law| law.sweeps).max().unwrap_or(0);
        let accelerated = of.iter().flatten().map(|law| law.law.accelerated()).max().unwrap_or(0);
        let coarse = of.iter().flatten().filter(|law| law.converges).map(|law| law.law.coarse());
        let coarse = coarse.fold(f64::INFINITY, f64::min);
        Self { of, iterations, sweeps, accelerated, coarse }
    }

    /// Returns the number of interfaces.
    pub fn count(&self) -> usize {
        self.of.len()
    }

    /// Returns for each interface true if segments touch segments there.
    pub fn by_segments(&self) -> Vec<bool> {
        self.of.iter().map(|law| law.as_ref().is_some_and(|law| law.law.by_segments())).collect()
    }

    /// Returns the law of an own pair.
    ///
    /// # Panics
    /// If nothing touches in its interface: there are no such pairs.
    pub fn of_pair(&self, pair: &Pair) -> &dyn ContactLaw {
        &*self.of_interface(pair).law
    }

    /// Returns the law of an own pair, with the values that each of its updates needs. Panics as
    /// [`Laws::of_pair`].
    #[inline]
    pub fn of_interface(&self, pair: &Pair) -> &InterfaceLaw {
        self.of[pair.interface as usize].as_ref().expect("an interface with pairs has a law")
    }

    /// Returns the methods of iteration of the laws, each once, in the order of the interfaces.
    pub fn iterations(&self) -> &[Iteration] {
        &self.iterations
    }

    /// Returns the largest number of sweeps of any law within a step.
    pub fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// Returns the largest number of accelerated sweeps of any law within a step.
    pub fn accelerated(&self) -> usize {
        self.accelerated
    }

    /// Returns the smallest [`ContactLaw::coarse`] of the laws that converge.
    pub fn coarse(&self) -> f64 {
        self.coarse
    }

    /// Returns true if any law has [`ContactLaw::converges`].
    pub fn converge(&self) -> bool {
        self.of.iter().flatten().any(|law| law.converges)
    }

    /// Returns true if a law predicts and corrects. Then the slaves' masses are needed, see
    /// [`Pair::set_slave_mass`].
    pub fn predict(&self) -> bool {
        self.iterations.iter().any(|iteration| matches!(iteration, Iteration::Correct { .. }))
    }

    /// Returns [`ContactLaw::segment_stiffness`]; all laws that have one return the same value.
    pub fn segment_stiffness(&self, segment: &Segment, x0: &[Row]) -> Option<f64> {
        self.of.iter().flatten().find_map(|law| law.law.segment_stiffness(segment, x0))
    }
}

/// Part of the gap that a force may leave open, as a fraction of the contact thickness. It is
/// small enough for a block that rests under its own weight: with a coarser limit residual
/// forces continue to push and feed energy into bodies at rest. It is large enough to end sweeps
/// over forces of round-off.
const GAP: f64 = 1e-11;
/// Largest speed at which penetration is removed, as a fraction of the wave speed of the parts
/// in contact. A surface that moves with the speed v sends out a wave of the strain v/c (Graff
/// 1975, ch. 2). With this value it is about 8 MPa and 0.2 m/s in steel and does no harm,
/// whatever the step, the thickness and the mesh. The penetration that a step leaves is far
/// smaller. The limit ensures that a node is not thrown out where sweeps do not converge or
/// where it meets a segment from its rim.
const CORRECT: f64 = 4e-5;
/// Distance within which a stick point survives steps in which its pair has no force, as a
/// fraction of the contact thickness. The pair must still touch within this distance. The
/// reason: if several pairs support a body, the load moves between them from step to step. A
/// pair that lifted off or slid farther gets a new stick point. The work of friction exceeds the
/// exact value by at most mu N times this length.
const STAY: f64 = 1e-4;

/// Returns the gap that is to be closed, or the part of a penetration that is to be removed in
/// this step [length].
fn overlap(pair: &Pair, steps: StepSizes) -> f64 {
    pair.gap.max(-CORRECT * pair.speed * steps.dt)
}

/// Returns the tangential distance from the stick point after the step; zero if the node slides
/// or leaves [length]. The node slides if the force that would return it to its stick point is
/// outside the cone. The present force cannot decide this, because a law may leave it slightly
/// inside the cone.
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

/// Returns the speed at which a pair's gap would be passed in the step at this velocity, 0 if it
/// would not be passed [length/time].
pub fn demand(pair: &Pair, velocity: &V3, steps: StepSizes) -> f64 {
    (-overlap(pair, steps) / steps.dt - velocity.dot(&pair.normal)).max(0.0)
}

/// Returns the component of `f` along `normal`, and the rest.
fn split(f: &V3, normal: &V3) -> (f64, V3) {
    let along = f.dot(normal);
    (along, f - normal * along)
}

/// Limits a tangential force to the friction cone of the normal force `pressed`. The limit of
/// friction cuts the cone to a cylinder.
pub fn within_cone(tangential: V3, pressed: f64, pair: &Pair) -> V3 {
    no_longer(tangential, pair.friction_force(pressed))
}

/// Returns a vector, shortened to `limit`.
fn no_longer(v: V3, limit: f64) -> V3 {
    let size = v.norm();
    if size > limit { v * (limit / size) } else { v }
}
