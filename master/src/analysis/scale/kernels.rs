//! What the parts of a step cost on this machine, from steps of one worker that has the whole mesh.
//!
//! Phases are timed by the wall clock, and what else the machine does meanwhile is taken out: the
//! phases of a step are reduced in common to the CPU time that it took.

use crate::analysis::bench::median;
use crate::analysis::cost::element_seconds;
use crate::input::job::Model;
use crumple_proto::report::PhaseSeconds;
use crumple_proto::transport::{RankLost, thread_cpu};
use crumple_worker::engine::{Engine, Phase};
use crumple_worker::math::rigid_motion::MotionTracker;
use crumple_worker::parallel::census::Count;
use std::time::Duration;

/// Steps that are timed; phases are medians over them.
pub const STEPS: usize = 60;
/// How often the fit of the common motion is timed.
const FITS: usize = 9;

/// Steps of one worker, phase by phase.
pub struct Watch {
    before: State,
    seconds: Vec<PhaseSeconds>,
    /// Seconds of the search phase of steps that searched.
    searching: Vec<f64>,
    /// Sweeps of all steps.
    sweeps: u64,
}

/// Of an engine between two steps.
struct State {
    phases: PhaseSeconds,
    searches: u64,
    sweeps: u64,
    cpu: Duration,
}

/// Seconds per unit of work.
#[derive(Clone, Debug, Default)]
pub struct Kernels {
    /// An element in its lane, by part.
    pub element: Vec<f64>,
    /// A held node: gathered, accelerated, loaded and moved.
    pub node: f64,
    /// A held node whose motion since the last renewal is watched.
    pub motion: f64,
    /// A local node, held or copied, watched for whether a search is due.
    pub watch: f64,
    /// A segment or a slave in a global search, times how often one comes in a step.
    pub search: f64,
    /// A slave, and a candidate that is near, in the local search: one of them has all of it.
    pub local: [f64; 2],
    /// A slave, and a pair, in the enforcement of contact: one of them has all of it.
    pub contact: [f64; 2],
    /// Sweeps of contact in a step.
    pub sweeps: f64,
}

impl Watch {
    /// Begins with the engine's next step. Unstrained elements are computed from then on, as those
    /// are that the parts are tried with.
    pub fn new(engine: &mut Engine) -> Self {
        engine.blocks.compute_all();
        engine.timer.restart();
        let before = State::new(engine);
        Self { before, seconds: Vec::new(), searching: Vec::new(), sweeps: 0 }
    }

    /// Takes in the step that the engine has just made; whether there are enough.
    pub fn sample(&mut self, engine: &mut Engine) -> bool {
        let (now, before) = (State::new(engine), &self.before);
        let by_clock: PhaseSeconds = std::array::from_fn(|p| now.phases[p] - before.phases[p]);
        let cpu = now.cpu.saturating_sub(before.cpu).as_secs_f64();
        let running = (cpu / by_clock.iter().sum::<f64>().max(f64::MIN_POSITIVE)).min(1.0);
        let spent = by_clock.map(|s| s * running);
        self.sweeps += now.sweeps - before.sweeps;
        match now.searches - before.searches {
            0 => self.seconds.push(spent),
            _ => self.searching.push(spent[Phase::Search as usize]),
        }
        engine.timer.restart();
        self.before = State::new(engine);
        self.seconds.len() + self.searching.len() >= STEPS
    }

    /// What units of work cost; `whole` is what the one worker has.
    ///
    /// # Errors
    /// The elements of a part could not be tried.
    pub fn kernels(
        &self,
        model: &Model,
        engine: &Engine,
        whole: &Count,
    ) -> Result<Kernels, RankLost> {
        let of: PhaseSeconds = std::array::from_fn(|p| median(self.seconds.iter().map(|s| s[p])));
        let phase = |p: Phase| of[p as usize];
        let per = |seconds: f64, units: u64| seconds / (units as f64).max(1.0);
        let tried = element_seconds(model)?;
        let alone: f64 = tried.iter().zip(&whole.lanes).map(|(s, &n)| s * n as f64).sum();
        let as_measured = if alone > 0.0 { phase(Phase::Elements) / alone } else { 0.0 };
        // The first search is no sign of how often one comes.
        let searches = engine.contact.as_ref().map_or(0, |c| c.searches).saturating_sub(1);
        let often = searches as f64 / engine.clock.cycle.max(1) as f64;
        let search = (median(self.searching.iter().copied()) - phase(Phase::Search)).max(0.0);
        let split =
            |s: f64, n: u64| if n > 0 { [0.0, per(s, n)] } else { [per(s, whole.slaves), 0.0] };
        Ok(Kernels {
            element: tried.into_iter().map(|s| s * as_measured).collect(),
            node: per(phase(Phase::Assemble) + phase(Phase::Advance), whole.held),
            motion: if engine.contact.is_some() { per(fit(engine), whole.held) } else { 0.0 },
            watch: per(phase(Phase::Search), whole.held),
            search: per(often * search, whole.segments + whole.slaves),
            local: split(phase(Phase::Local), whole.near),
            contact: split(phase(Phase::Contact), whole.pairs),
            sweeps: self.sweeps as f64 / (self.seconds.len() + self.searching.len()) as f64,
        })
    }
}

impl State {
    fn new(engine: &Engine) -> Self {
        let contact = engine.contact.as_ref();
        Self {
            phases: engine.timer.seconds,
            searches: contact.map_or(0, |c| c.searches),
            sweeps: contact.map_or(0, |c| c.sweeps),
            cpu: thread_cpu(),
        }
    }
}

/// Time of watching the motion of all nodes [s].
fn fit(engine: &Engine) -> f64 {
    let x = &engine.nodes.x[..engine.nodes.local_count];
    let mut motion = MotionTracker::since(x);
    let once = |_| {
        let start = thread_cpu();
        std::hint::black_box(motion.update(x));
        thread_cpu().saturating_sub(start).as_secs_f64()
    };
    median((0..FITS).map(once))
}
