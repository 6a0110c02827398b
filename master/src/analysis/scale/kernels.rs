//! Costs of the parts of a step on this machine, from steps of one worker with the whole mesh.
//!
//! Phases are timed by the wall clock and corrected for other load on the machine: the phases of
//! a step are scaled together so that their sum is the CPU time of the step.

use super::census::Count;
use crate::analysis::bench::median;
use crate::analysis::cost::element_seconds;
use crate::input::job::Model;
use crumple_proto::report::Phase;
use crumple_proto::report::PhaseSeconds;
use crumple_proto::transport::{RankLost, thread_cpu};
use crumple_worker::engine::Engine;
use crumple_worker::math::rigid_motion::MotionTracker;
use std::time::Duration;

/// Number of timed steps; phases are medians over them.
pub const STEPS: usize = 60;
/// Number of timings of the rigid motion fit.
const FITS: usize = 9;

/// Times of the steps of one worker, per phase.
pub struct Watch {
    before: EngineCounters,
    seconds: Vec<PhaseSeconds>,
    /// Time of the search phase of steps with a global search [s].
    searching: Vec<f64>,
    /// Number of sweeps of all steps.
    sweeps: u64,
}

/// Counters of an engine between two steps.
struct EngineCounters {
    phases: PhaseSeconds,
    searches: u64,
    sweeps: u64,
    cpu: Duration,
}

/// Time per unit of work [s].
#[derive(Clone, Debug, Default)]
pub struct Kernels {
    /// Force computation of an element in its lane, per part.
    pub element: Vec<f64>,
    /// Assembly, acceleration, loads and motion of a local node.
    pub node: f64,
    /// Motion fit of a local node since the last redecomposition.
    pub motion: f64,
    /// Check of a local or ghost node for a new global search.
    pub watch: f64,
    /// Global search for a segment or slave, times the number of searches per step.
    pub search: f64,
    /// Local search for a slave, and for a candidate of the near list. One of the two is zero.
    pub local: [f64; 2],
    /// Enforcement for a slave, and for a pair. One of the two is zero.
    pub contact: [f64; 2],
    /// Number of contact sweeps per step.
    pub sweeps: f64,
}

impl Watch {
    /// Starts with the next step of the engine. From then on unstrained elements are computed, as
    /// in the samples of the parts.
    pub fn new(engine: &mut Engine) -> Self {
        engine.blocks.compute_all();
        engine.timer.restart();
        let before = EngineCounters::new(engine);
        Self { before, seconds: Vec::new(), searching: Vec::new(), sweeps: 0 }
    }

    /// Adds the step that the engine has just done. Returns true if there are enough steps.
    pub fn sample(&mut self, engine: &mut Engine) -> bool {
        let (now, before) = (EngineCounters::new(engine), &self.before);
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
        self.before = EngineCounters::new(engine);
        self.seconds.len() + self.searching.len() >= STEPS
    }

    /// Returns the cost of each unit of work. `whole` holds the counts of the single worker.
    ///
    /// # Errors
    /// A sample of elements could not be set up.
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
        // The first search always happens, so it is not counted for the frequency.
        let searches = engine.contact.as_ref().map_or(0, |c| c.searches).saturating_sub(1);
        let often = searches as f64 / engine.clock.cycle.max(1) as f64;
        let search = (median(self.searching.iter().copied()) - phase(Phase::Search)).max(0.0);
        let split =
            |s: f64, n: u64| if n > 0 { [0.0, per(s, n)] } else { [per(s, whole.slaves), 0.0] };
        Ok(Kernels {
            element: tried.into_iter().map(|s| s * as_measured).collect(),
            node: per(
                [Phase::Assemble, Phase::Constraints, Phase::Energy, Phase::Advance]
                    .into_iter()
                    .map(phase)
                    .sum::<f64>(),
                whole.held,
            ),
            motion: if engine.contact.is_some() { per(fit(engine), whole.held) } else { 0.0 },
            watch: per(phase(Phase::Search), whole.held),
            search: per(often * search, whole.segments + whole.slaves),
            local: split(phase(Phase::Local), whole.near),
            contact: split(phase(Phase::Contact), whole.pairs),
            sweeps: self.sweeps as f64 / (self.seconds.len() + self.searching.len()) as f64,
        })
    }
}

impl EngineCounters {
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

/// Returns the time of the motion fit of all nodes [s].
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
