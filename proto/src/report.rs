//! What workers tell the master while they run.

use crate::histories::HistoryShares;
use crate::ids::ElemId;
use serde::{Deserialize, Serialize};

/// Sent every few cycles, without waiting for an answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Cycles done.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step in use [time].
    pub dt: f64,
    /// CPU seconds of each cycle since the last report, waiting left out.
    pub cpu: Vec<f32>,
    /// CPU seconds of renewals of boxes and membership since the last report, waiting left out.
    pub renewal_s: f64,
    /// Relative motion since the boxes were last renewed, as a fraction of what the exterior copies
    /// cover.
    pub urgency: f64,
    /// Active contact pairs that this worker owns.
    pub pairs: u64,
    /// Elements that this worker owns.
    pub elements: u64,
    /// Mean displacement of the worker's elements since the boxes were last renewed [length].
    pub drift: [f64; 3],
    /// Seconds of contact work and of element work since the last report.
    pub contact_s: f64,
    /// See `contact_s`.
    pub element_s: f64,
    /// Last order carried out.
    pub order: u64,
}

/// Kinetic energy at the turn of a vibration at 0.9 of the stable step, `-s^2 / (1 - s^2)` of the
/// energy of the vibration.
const MIN_KINETIC: f64 = 0.81 / 0.19;

/// Energies of one worker's share [energy]; the work of contact and walls is positive when it
/// drives the nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic, by the product of the velocities of the mid-steps before and after.
    pub kinetic: f64,
    /// What the mean of their squares has beyond that: large where velocities swing from step to
    /// step.
    pub swing: f64,
    /// Internal: elastic stored and plastically dissipated.
    pub internal: f64,
    /// Hourglass and drilling.
    pub hourglass: f64,
    /// Work of contact between bodies, friction included.
    pub contact: f64,
    /// Part of `contact` that friction did.
    pub friction: f64,
    /// Part of `contact` that pairs did that started inside each other's thickness, as long as they
    /// had not come apart.
    pub starting: f64,
    /// Work of rigid walls, friction included, and of what they are given on walls that have a
    /// mass.
    pub wall: f64,
    /// Work of loads, damping and prescribed motion.
    pub external: f64,
}

impl Energies {
    /// Adds another worker's share.
    pub fn add(&mut self, o: &Self) {
        self.kinetic += o.kinetic;
        self.swing += o.swing;
        self.internal += o.internal;
        self.hourglass += o.hourglass;
        self.contact += o.contact;
        self.friction += o.friction;
        self.starting += o.starting;
        self.wall += o.wall;
        self.external += o.external;
    }

    /// Energy there was at first and what has come in since [energy].
    pub fn supplied(&self, initial: f64) -> f64 {
        initial.max(0.0) + self.external.abs() + self.wall.max(0.0) + self.contact.max(0.0)
    }

    /// What is left unexplained of the change since `initial` kinetic energy [energy]. The product
    /// of two mid-step velocities is below nought where a vibration turns, by `(omega dt / 2)^2` of
    /// what is stored then; an unstable step keeps the balance too, but with a kinetic energy below
    /// any that a stable one can have. What lies below counts as missing, so that growth shows.
    pub fn balance(&self, initial: f64) -> f64 {
        let kinetic = self.kinetic.max(-MIN_KINETIC * self.supplied(initial));
        kinetic + self.internal + self.hourglass
            - self.contact
            - self.wall
            - self.external
            - initial
    }
}

/// One worker's share of a history row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistoryPart {
    /// Number of the row.
    pub row: u64,
    /// Cycles done.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step in use [time].
    pub dt: f64,
    /// Energies.
    pub energies: Energies,
    /// Linear momentum [mass length/time].
    pub momentum: [f64; 3],
    /// Angular momentum about the origin [mass length^2/time].
    pub angular_momentum: [f64; 3],
    /// Impulse that each wall has given to this worker's nodes so far [force time].
    pub wall_impulse: Vec<[f64; 3]>,
    /// How far each wall has gone since the start, which all workers know alike [length].
    pub wall_displacement: Vec<[f64; 3]>,
    /// Active contact pairs.
    pub pairs: u64,
    /// Largest penetration since the last row as a fraction of the pair's contact thickness.
    pub penetration: f64,
    /// Smallest stable step of the worker's elements, safety factor not applied [time].
    pub controlling_dt: f64,
    /// Element that has it.
    pub controlling: Option<ElemId>,
    /// Step that contact leaves, for nothing to pass through what it meets, before the safety
    /// factor; all workers know it alike [time].
    pub contact_dt: f64,
    /// What else is recorded.
    pub shares: HistoryShares,
}

/// Why a worker cannot go on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Element at fault.
    pub elem: Option<ElemId>,
    /// Cycle in which it was seen.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// What is wrong and what to try.
    pub why: String,
}

/// The stages of a step that are timed, in the order in which they run.
pub const PHASES: [&str; 9] =
    ["elements", "assemble", "halo", "search", "local", "contact", "advance", "output", "renewal"];

/// Seconds of one worker in each of [`PHASES`], wall clock; `halo` includes waiting for others.
pub type PhaseSeconds = [f64; PHASES.len()];

/// How a worker's run went, sent at its end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FinalReport {
    /// Cycles done.
    pub cycles: u64,
    /// Simulated time reached [time].
    pub time: f64,
    /// Seconds per phase.
    pub phases: PhaseSeconds,
    /// First, smallest and last step [time].
    pub dt: [f64; 3],
    /// Messages sent to other ranks.
    pub messages: u64,
    /// Bytes sent to other ranks.
    pub bytes: u64,
    /// Global searches done.
    pub searches: u64,
    /// Contact sweeps done.
    pub sweeps: u64,
    /// Steps whose sweeps were accelerated, and steps whose sweeps ended before all forces were
    /// good enough.
    pub unsettled: [u64; 2],
    /// Contact pairs held softer than the job asks, summed over cycles.
    pub capped: u64,
    /// Whether the run was stopped by an order.
    pub stopped: bool,
    /// What became of each part, in the order of the settings.
    pub parts: Vec<PartRecord>,
}

/// What became of one worker's elements of a part, and of the surfaces of the part that it saw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartRecord {
    /// Elements at the end, without those that have failed.
    pub elements: u64,
    /// Elements that have failed.
    pub failed: u64,
    /// Those of them that were inverted.
    pub inverted: u64,
    /// Largest effective plastic strain at the end.
    pub plastic_strain: f64,
    /// Largest von Mises stress at the end [force/length^2].
    pub von_mises: f64,
    /// Largest difference of effective plastic strain between two of the worker's elements with a
    /// node in common, at the end.
    pub strain_jump: f64,
    /// The same of von Mises stress [force/length^2].
    pub stress_jump: f64,
    /// Work of its stresses, done on this worker [energy].
    pub internal: f64,
    /// Work of its hourglass control and drilling stiffness, likewise [energy].
    pub hourglass: f64,
    /// Whether a global search ever found a candidate among its nodes and segments: within contact
    /// reach and skin.
    pub near: bool,
    /// Whether any of its nodes was ever part of a contact pair.
    pub touched: bool,
}

impl PartRecord {
    /// Takes in what another worker knows of the part.
    pub fn add(&mut self, o: &Self) {
        self.elements += o.elements;
        self.failed += o.failed;
        self.inverted += o.inverted;
        self.plastic_strain = self.plastic_strain.max(o.plastic_strain);
        self.von_mises = self.von_mises.max(o.von_mises);
        self.strain_jump = self.strain_jump.max(o.strain_jump);
        self.stress_jump = self.stress_jump.max(o.stress_jump);
        self.internal += o.internal;
        self.hourglass += o.hourglass;
        self.near |= o.near;
        self.touched |= o.touched;
    }
}
