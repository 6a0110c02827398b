//! Reports that workers send to the master during the run.

use crate::exact_sum::ExactSum;
use crate::histories::{HistoryShares, each_value, merge_each};
use crate::ids::ElemId;
use crate::place::{ModelPlace, Peak, comes_first};
use serde::{Deserialize, Serialize};

/// Progress report, sent every few cycles without waiting for an answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step in use [time].
    pub dt: f64,
    /// CPU time of each cycle since the last report, without waiting [s].
    pub cpu: Vec<f32>,
    /// CPU time of renewals of boxes and membership since the last report, without waiting [s].
    pub renewal_s: f64,
    /// Largest accumulated displacement of this worker since the last report.
    pub displacement: Displacement,
    /// Active contact pairs that this worker owns.
    pub pairs: u64,
    /// Candidates of the last global search.
    pub candidates: u64,
    /// Own nodes that may touch segments.
    pub slaves: u64,
    /// Elements that this worker owns.
    pub elements: u64,
    /// Own elements in the buffer around the box; the other own elements are interior.
    pub interface: u64,
    /// Ghost elements.
    pub exterior: u64,
    /// Ghost nodes.
    pub exterior_nodes: u64,
    /// Mean displacement of the worker's elements since the boxes were last renewed [length].
    pub drift: [f64; 3],
    /// CPU time by phase since the last report, without waiting [s]. It is measured in one cycle
    /// of the report, and scaled to all of its cycles.
    pub phase_cpu: PhaseSeconds,
    /// Messages sent since the last report.
    pub messages: u64,
    /// Bytes sent since the last report.
    pub bytes: u64,
    /// Renewals because elements have failed, so far.
    pub erosions: u64,
    /// Number of the last order that was executed.
    pub order: u64,
}

impl StepReport {
    /// Adds a later report of the same worker: times and traffic add up, the largest displacement
    /// counts, and the rest is that of the later report.
    pub fn append(&mut self, mut later: Self) {
        let mut cpu = std::mem::take(&mut self.cpu);
        cpu.append(&mut later.cpu);
        later.cpu = cpu;
        later.renewal_s += self.renewal_s;
        later.messages += self.messages;
        later.bytes += self.bytes;
        later.phase_cpu.iter_mut().zip(self.phase_cpu).for_each(|(l, s)| *l += s);
        later.displacement = later.displacement.or_larger(self.displacement);
        *self = later;
    }
}

/// Accumulated displacement of a worker since the last renewal: the relative motion of its contact
/// nodes and those of the other worker whose ghosts it endangers most. Rigid motion that both
/// have in common does not count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Displacement {
    /// Relative motion [length].
    pub moved: f64,
    /// Motion that the ghosts allow [length]; 0 if nothing can use it up.
    pub margin: f64,
    /// `moved` over `margin`.
    pub share: f64,
}

impl Displacement {
    /// Returns the displacement `moved` with a `margin` above 0 [length].
    pub fn new(moved: f64, margin: f64) -> Self {
        Self { moved, margin, share: moved / margin }
    }

    /// Returns the one with the larger share.
    pub fn or_larger(self, other: Self) -> Self {
        if other.share > self.share { other } else { self }
    }
}

/// Magnitude of the kinetic energy at the turning point of a vibration at 0.9 of the stable
/// step, over the energy of the vibration: `s^2 / (1 - s^2)`. The kinetic energy is negative
/// there.
const MIN_KINETIC: f64 = 0.81 / 0.19;

/// Energies of one worker's partition, as exact sums, or of the whole model, as numbers [energy].
/// The work of contact and walls is positive if it accelerates the nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies<N = f64> {
    /// Kinetic energy: product of the velocities of the mid-steps before and after.
    pub kinetic: N,
    /// Kinetic energy from the mean square of both mid-step velocities, minus `kinetic`: large
    /// if velocities oscillate from step to step.
    pub swing: N,
    /// Internal energy: stored elastically and dissipated plastically.
    pub internal: N,
    /// Energy of hourglass control and drilling stiffness.
    pub hourglass: N,
    /// Work of contact forces, friction included.
    pub contact: N,
    /// Part of `contact` that is done by friction.
    pub friction: N,
    /// Part of `contact` from pairs that penetrated at the start of the run, until they first
    /// separate.
    pub starting: N,
    /// Work of rigid walls on nodes, friction included, and work on walls that have a mass.
    pub wall: N,
    /// Work of friction on rigid walls, in the motion relative to them: minus what it dissipates.
    pub wall_friction: N,
    /// Work of loads, damping and prescribed motion.
    pub external: N,
}

impl Energies<ExactSum> {
    /// Adds the energies of another worker.
    pub fn merge(&mut self, o: &Self) {
        self.kinetic.merge(&o.kinetic);
        self.swing.merge(&o.swing);
        self.internal.merge(&o.internal);
        self.hourglass.merge(&o.hourglass);
        self.contact.merge(&o.contact);
        self.friction.merge(&o.friction);
        self.starting.merge(&o.starting);
        self.wall.merge(&o.wall);
        self.wall_friction.merge(&o.wall_friction);
        self.external.merge(&o.external);
    }

    /// Returns the kinetic, internal and hourglass energy [energy].
    pub fn stored(&self) -> ExactSum {
        let mut sum = self.kinetic.clone();
        sum.merge(&self.internal);
        sum.merge(&self.hourglass);
        sum
    }

    /// Returns the energies as numbers [energy].
    pub fn values(&self) -> Energies {
        Energies {
            kinetic: self.kinetic.value(),
            swing: self.swing.value(),
            internal: self.internal.value(),
            hourglass: self.hourglass.value(),
            contact: self.contact.value(),
            friction: self.friction.value(),
            starting: self.starting.value(),
            wall: self.wall.value(),
            wall_friction: self.wall_friction.value(),
            external: self.external.value(),
        }
    }
}

impl Energies {
    /// Returns the `initial` energy plus the energy supplied since [energy].
    pub fn supplied(&self, initial: f64) -> f64 {
        initial.max(0.0) + self.external.abs() + self.wall.max(0.0) + self.contact.max(0.0)
    }

    /// Returns the unexplained change since the `initial` kinetic energy [energy].
    ///
    /// At the turning point of a vibration the product of two mid-step velocities is negative,
    /// by `(omega dt / 2)^2` times the energy stored then. An unstable step keeps the balance
    /// too, but its kinetic energy is below any value that a stable step can reach. The part
    /// below that limit counts as missing, so that the growth shows in the balance.
    pub fn balance(&self, initial: f64) -> f64 {
        let kinetic = self.kinetic.max(-MIN_KINETIC * self.supplied(initial));
        kinetic + self.internal + self.hourglass
            - self.contact
            - self.wall
            - self.external
            - initial
    }
}

/// Contribution of one worker to a history row, with exact sums, or the row of all workers, with
/// numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistoryPart<N = f64> {
    /// Number of the row.
    pub row: u64,
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step in use [time].
    pub dt: f64,
    /// Energies of the worker.
    pub energies: Energies<N>,
    /// Linear momentum [mass length/time].
    pub momentum: [N; 3],
    /// Angular momentum about the origin [mass length^2/time].
    pub angular_momentum: [N; 3],
    /// Impulse that each wall has exerted on this worker's nodes so far [force time].
    pub wall_impulse: Vec<[N; 3]>,
    /// Displacement of each wall since the start, equal on all workers [length].
    pub wall_displacement: Vec<[f64; 3]>,
    /// Active contact pairs.
    pub pairs: u64,
    /// Largest penetration since the last row, as a fraction of the pair's contact thickness.
    pub penetration: f64,
    /// Node with this penetration.
    pub deepest: ModelPlace,
    /// Largest work of friction of one pair in one step since the last row [energy].
    pub sliding: Peak,
    /// Smallest Jacobian at a corner of an element, over its value at the start; infinite without
    /// shells and solids.
    pub corner_left: f64,
    /// Element with this corner.
    pub flattest: ModelPlace,
    /// Smallest stable step of the worker's elements, before the safety factor [time].
    pub controlling_dt: f64,
    /// Element with the smallest stable step.
    pub controlling: ModelPlace,
    /// Largest step for which contact prevents slaves from passing through their targets,
    /// before the safety factor; equal on all workers [time].
    pub contact_dt: f64,
    /// Requested histories.
    pub shares: HistoryShares<N>,
}

impl HistoryPart<ExactSum> {
    /// Adds the contribution of another worker. The controlling element is that of the worker with
    /// the smallest step, with the lowest id of several; all workers use this step.
    pub fn merge(&mut self, o: &Self) {
        self.energies.merge(&o.energies);
        merge_each(&mut self.momentum, &o.momentum);
        merge_each(&mut self.angular_momentum, &o.angular_momentum);
        let walls = self.wall_impulse.iter_mut().zip(&o.wall_impulse);
        walls.for_each(|(a, b)| merge_each(a, b));
        self.shares.merge(&o.shares);
        self.pairs += o.pairs;
        if comes_first(-o.penetration, &o.deepest, -self.penetration, &self.deepest) {
            (self.penetration, self.deepest) = (o.penetration, o.deepest);
        }
        self.sliding.raise(o.sliding.value, || o.sliding.at);
        if comes_first(o.corner_left, &o.flattest, self.corner_left, &self.flattest) {
            (self.corner_left, self.flattest) = (o.corner_left, o.flattest);
        }
        let own = (self.controlling_dt, &self.controlling);
        if comes_first(o.controlling_dt, &o.controlling, own.0, own.1) {
            (self.controlling, self.controlling_dt) = (o.controlling, o.controlling_dt);
        }
    }

    /// Returns the row with numbers.
    pub fn values(&self) -> HistoryPart {
        HistoryPart {
            row: self.row,
            cycle: self.cycle,
            time: self.time,
            dt: self.dt,
            energies: self.energies.values(),
            momentum: each_value(&self.momentum),
            angular_momentum: each_value(&self.angular_momentum),
            wall_impulse: self.wall_impulse.iter().map(each_value).collect(),
            wall_displacement: self.wall_displacement.clone(),
            pairs: self.pairs,
            penetration: self.penetration,
            deepest: self.deepest,
            sliding: self.sliding,
            corner_left: self.corner_left,
            flattest: self.flattest,
            controlling_dt: self.controlling_dt,
            controlling: self.controlling,
            contact_dt: self.contact_dt,
            shares: self.shares.values(),
        }
    }
}

/// Reason for which a worker cannot continue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Element in which the failure was found, if any.
    pub elem: Option<ElemId>,
    /// Cycle in which the failure was found.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Description of the failure, with a suggestion.
    pub why: String,
}

/// Timed phases of a step, in the order in which they run.
pub const PHASES: [&str; 11] = [
    "elements",
    "assemble",
    "constraints",
    "halo",
    "search",
    "local",
    "contact",
    "energy",
    "advance",
    "output",
    "renewal",
];

/// Timed stages of a step; indices into [`PHASES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Phase {
    /// Internal forces.
    Elements,
    /// Assembly, loads, velocities without constraints and contact.
    Assemble,
    /// Prescribed motions, rigid bodies, ties and walls.
    Constraints,
    /// Messages, including the wait for them.
    Halo,
    /// Global search, and the rigid-motion fit that shows how far ghosts stay valid.
    Search,
    /// Local search.
    Local,
    /// Contact forces.
    Contact,
    /// Work of contact, constraints and loads.
    Energy,
    /// Positions of nodes, rigid bodies and walls.
    Advance,
    /// History and field files.
    Output,
    /// Migration and build of the new partition.
    Renewal,
}

/// Load of a step in two parts: CPU time without contact, and of contact [s]. Contact needs the
/// velocities of ghosts. Their owners know them only when all their elements are computed. So
/// workers wait for each other between the two, and a step takes the largest time of each.
pub type StepLoads = [f64; 2];

impl Phase {
    /// Phases of contact, the second part of [`StepLoads`].
    pub const OF_CONTACT: [Self; 3] = [Self::Search, Self::Local, Self::Contact];
}

/// Returns the time of a worker without contact, and of contact [s].
pub fn step_loads(seconds: &PhaseSeconds) -> StepLoads {
    let contact = Phase::OF_CONTACT.iter().map(|&p| seconds[p as usize]).sum::<f64>();
    [seconds.iter().sum::<f64>() - contact, contact]
}

/// Adds the loads of an element to the bin of its centre in a histogram over the range `lo` to
/// `hi` [length]; centres outside count in the outer bins. `at` is the coordinate of the centre
/// [length].
pub fn add_to_bin(histogram: &mut [StepLoads], (lo, hi): (f64, f64), at: f64, loads: StepLoads) {
    let place = (at - lo) / (hi - lo).max(f64::MIN_POSITIVE) * histogram.len() as f64;
    let last = histogram.len() - 1;
    let bin = &mut histogram[(place.max(0.0) as usize).min(last)];
    bin.iter_mut().zip(loads).for_each(|(sum, load)| *sum += load);
}

/// Wall-clock time of one worker in each of [`PHASES`] [s]; `halo` includes waiting for others.
pub type PhaseSeconds = [f64; PHASES.len()];

/// Summary of a worker's run, sent at its end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FinalReport {
    /// Cycles completed.
    pub cycles: u64,
    /// Simulated time reached [time].
    pub time: f64,
    /// Time per phase [s].
    pub phases: PhaseSeconds,
    /// First, smallest and last step [time].
    pub dt: [f64; 3],
    /// Messages sent to other ranks.
    pub messages: u64,
    /// Bytes sent to other ranks.
    pub bytes: u64,
    /// Number of global searches.
    pub searches: u64,
    /// Number of contact sweeps.
    pub sweeps: u64,
    /// Number of steps with accelerated sweeps, and number of steps whose sweeps ended before
    /// all forces reached the tolerance. Without nodes of pairs a worker may not know of them.
    pub unsettled: [u64; 2],
    /// Contact pairs with a penalty stiffness below the requested one, summed over cycles.
    pub capped: u64,
    /// Renewals because elements have failed.
    pub erosions: u64,
    /// Divisions of shells, of all workers.
    pub divisions: DivisionCounts,
    /// Elements in the internal box, in the buffer, and ghosts, at the end.
    pub classes: [u64; 3],
    /// Half the width of the buffer at the last renewal [length].
    pub half_buffer: f64,
    /// True if an order stopped the run.
    pub stopped: bool,
    /// Summary of each part, in the order of the settings.
    pub parts: Vec<PartRecord>,
}

/// Divisions of shells so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DivisionCounts {
    /// Number of shells that were divided.
    pub divided: u64,
    /// Number of computations of elements that their quarters have added.
    pub computed: u64,
}

/// Summary of one worker's elements of a part, and of the surfaces of the part that the worker
/// saw.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartRecord {
    /// Elements at the end, without failed ones.
    pub elements: u64,
    /// Failed elements.
    pub failed: u64,
    /// Failed elements that were inverted.
    pub inverted: u64,
    /// Largest effective plastic strain at the end.
    pub plastic_strain: f64,
    /// Largest von Mises stress at the end [force/length^2].
    pub von_mises: f64,
    /// Largest difference of effective plastic strain between two of the worker's elements that
    /// share a node, at the end.
    pub strain_jump: f64,
    /// Largest difference of von Mises stress between two such elements [force/length^2].
    pub stress_jump: f64,
    /// Work of the stresses of the worker's elements [energy].
    pub internal: ExactSum,
    /// Work of hourglass control and drilling stiffness of the worker's elements [energy].
    pub hourglass: ExactSum,
    /// True if a global search ever found a candidate among its nodes and segments, that is,
    /// within reach and skin.
    pub near: bool,
    /// True if any of its nodes was ever part of a contact pair.
    pub touched: bool,
}

impl PartRecord {
    /// Merges the summary of another worker.
    pub fn add(&mut self, o: &Self) {
        self.elements += o.elements;
        self.failed += o.failed;
        self.inverted += o.inverted;
        self.plastic_strain = self.plastic_strain.max(o.plastic_strain);
        self.von_mises = self.von_mises.max(o.von_mises);
        self.strain_jump = self.strain_jump.max(o.strain_jump);
        self.stress_jump = self.stress_jump.max(o.stress_jump);
        self.internal.merge(&o.internal);
        self.hourglass.merge(&o.hourglass);
        self.near |= o.near;
        self.touched |= o.touched;
    }
}
