//! Engines in this process without a master, observed step by step. Verification, benchmarks,
//! predictions of efficiency and tests use them.

use crate::input::job::Model;
use crate::results::summary::state_digest;
use crate::run::decompose::{Before, Centres, bisect};
use crumple_proto::boxes::{Cut, CutTree};
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::mesh::MeshElement;
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::report::PhaseSeconds;
use crumple_proto::transport::{RankLost, Traffic, Transport, threads};
use crumple_worker::engine::{Engine, StepFailure};
use crumple_worker::parallel::partition::PartitionData;
use crumple_worker::step::step;
use crumple_worker::timer::busy;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::time::Instant;

/// Fraction of the ghost margin used at which membership is updated.
pub(crate) const RENEW_AT: f64 = 0.7;

/// Slave node and segment of a contact pair.
pub type PairIds = (NodeId, SegmentId);

/// End of a run on one engine.
pub struct Ended {
    /// The engine at the end.
    pub engine: Engine,
    /// Failure, if the run had to end.
    pub trouble: Option<StepFailure>,
}

/// Runs a job on one engine in this thread. `look` is called at every time from 0 to the end. It
/// sees coordinates at `clock.time` and velocities half a step before. It may set velocities of
/// fixed degrees of freedom, which then move with them in the next step of `clock.dt`. It may
/// also end the run.
///
/// # Errors
/// The engine could not be set up.
pub fn run_alone(
    model: &Model,
    mut look: impl FnMut(&mut Engine) -> ControlFlow<()>,
) -> Result<Ended, RankLost> {
    let Alone { mut engine, mut comm, _master } = Alone::new(model)?;
    let mut trouble = None;
    while look(&mut engine).is_continue()
        && trouble.is_none()
        && !engine.clock.is_over(&engine.settings)
    {
        trouble = step(&mut engine, &mut comm)?.failure;
    }
    Ok(Ended { engine, trouble })
}

/// One engine with the whole job, and its connection to a master that does not read.
pub struct Alone {
    /// The engine.
    pub engine: Engine,
    /// The engine's end of the connection.
    pub comm: threads::Threads,
    /// The master's end. Messages, history rows among them, stay here unread.
    _master: threads::Threads,
}

impl Alone {
    /// Sets up the engine at time 0.
    ///
    /// # Errors
    /// The engine could not be set up.
    pub fn new(model: &Model) -> Result<Self, RankLost> {
        let (elements, nodes) = model.records();
        let elements = elements.into_iter().map(|e| (e, Vec::new())).collect();
        let share = PartitionData { elements, nodes, ..PartitionData::default() };
        let mut ends = threads::connect(2);
        let (mut comm, _master) = (ends.remove(1), ends.remove(0));
        // Its times are those of one core.
        let settings = Settings { threads: 1, ..model.settings.clone() };
        let engine = Engine::new(&mut comm, settings, CutTree::single(), share)?;
        Ok(Self { engine, comm, _master })
    }

    /// Advances by one step.
    ///
    /// # Errors
    /// An element has failed.
    pub fn forward(&mut self) -> Result<(), String> {
        let agreed = step(&mut self.engine, &mut self.comm).map_err(|lost| lost.to_string())?;
        match agreed.failure {
            Some(failure) => {
                Err(format!("the run failed {failure} at time {}", self.engine.clock.time))
            }
            None => Ok(()),
        }
    }
}

/// Result of a run with several engines.
pub struct Trace {
    /// Pairs of all workers per cycle, ascending. A pair that two workers own would appear twice.
    pub pairs: Vec<Vec<PairIds>>,
    /// State of all nodes at the end.
    pub nodes: Vec<NodeRecord>,
    /// Number of redecompositions.
    pub renewals: u64,
    /// Failure, if the run had to end.
    pub trouble: Option<StepFailure>,
}

impl Trace {
    /// Returns the digest of the state.
    pub fn digest(&self) -> String {
        state_digest(&mut self.nodes.clone())
    }
}

/// Returns the element centres at the start [length].
pub(crate) fn centres(model: &Model) -> Vec<[f64; 3]> {
    let of_id: HashMap<_, _> = model.mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let centre = |e: &MeshElement| {
        let corners = e.corners();
        std::array::from_fn(|c| {
            corners.iter().map(|n| of_id[n][c]).sum::<f64>() / corners.len() as f64
        })
    };
    model.mesh.elements.iter().map(centre).collect()
}

/// Runs `cycles` cycles on `workers` engines. Membership is updated when the ghost margin is used
/// up, and every `force_every` cycles (0 for never), alternately within the old boxes and with
/// boxes that are cut in another direction.
///
/// # Panics
/// Panics if a worker is lost.
pub fn run_side_by_side(model: &Model, workers: usize, cycles: u64, force_every: u64) -> Trace {
    watch_side_by_side(model, workers, [cycles, force_every], &|_| ())
}

/// Runs like [`run_side_by_side`] with `[cycles, force_every]`. `look` sees each engine after
/// each build of its partition and after each failure of elements, once in a cycle.
///
/// # Panics
/// Panics if a worker is lost.
pub fn watch_side_by_side(
    model: &Model,
    workers: usize,
    [cycles, force_every]: [u64; 2],
    look: &(dyn Fn(&Engine) + Sync),
) -> Trace {
    let centres = centres(model);
    let cut = |stretch: [f64; 3]| {
        let stretched =
            centres.iter().map(|c| std::array::from_fn(|k| c[k] * stretch[k])).collect();
        let mut tree = bisect(&mut Centres(stretched), workers, Before::default())
            .expect("no worker is asked");
        for entry in &mut tree.entries {
            if let Cut::Plane { axis, at, .. } = entry {
                *at /= stretch[*axis];
            }
        }
        tree
    };
    // A stretched axis is the longest, so that cuts are made across it.
    let trees = [cut([1.0; 3]), cut([1.0, 50.0, 1.0]), cut([1.0, 1.0, 80.0])];
    let shares = deal(model, &centres, &trees[0], workers);
    let plan = Plan { cycles, force_every, trees, look };
    let traces = on_threads(shares, |comm, share| one_engine(model, comm, share, &plan));
    let mut all = Trace {
        pairs: vec![Vec::new(); traces[0].pairs.len()],
        nodes: Vec::new(),
        renewals: 0,
        trouble: None,
    };
    for t in traces {
        all.pairs.iter_mut().zip(t.pairs).for_each(|(a, b)| a.extend(b));
        all.nodes.extend(t.nodes);
        (all.renewals, all.trouble) = (t.renewals, t.trouble);
    }
    all.pairs.iter_mut().for_each(|p| p.sort_unstable());
    all
}

/// Returns the partition of each worker by the boxes of `tree`.
pub(crate) fn deal(
    model: &Model,
    centres: &[[f64; 3]],
    tree: &CutTree,
    workers: usize,
) -> Vec<PartitionData> {
    let (elements, nodes) = model.records();
    let record: HashMap<NodeId, &NodeRecord> = nodes.iter().map(|r| (r.id, r)).collect();
    let mut shares: Vec<PartitionData> = (0..workers).map(|_| PartitionData::default()).collect();
    for (e, &c) in elements.iter().zip(centres) {
        shares[tree.worker_of(c)].elements.push((*e, Vec::new()));
    }
    for share in &mut shares {
        let mut ids: Vec<NodeId> = share.elements.iter().flat_map(|(e, _)| e.nodes).collect();
        ids.sort_unstable();
        ids.dedup();
        share.nodes = ids.iter().filter_map(|id| record.get(id).map(|&&n| n)).collect();
    }
    shares
}

/// Runs one worker per partition, each in a thread. Their messages to the master stay unread.
pub(crate) fn on_threads<T: Send>(
    shares: Vec<PartitionData>,
    run: impl Fn(&mut dyn Transport, PartitionData) -> T + Sync,
) -> Vec<T> {
    let mut ends = threads::connect(shares.len() + 1);
    let _master = ends.remove(0);
    std::thread::scope(|scope| {
        let run = &run;
        let start = |(mut end, share)| scope.spawn(move || run(&mut end, share));
        let threads: Vec<_> = ends.into_iter().zip(shares).map(start).collect();
        threads.into_iter().map(|t| t.join().expect("a worker was lost")).collect()
    })
}

/// Times of a worker for a number of cycles.
pub struct Timing {
    /// Number of timed cycles.
    pub cycles: u64,
    /// CPU time without the time of waiting for others [s].
    pub cpu_s: f64,
    /// Wall time [s].
    pub wall_s: f64,
    /// Wall time by phase [s].
    pub phases: PhaseSeconds,
    /// Messages and bytes sent to other workers.
    pub traffic: Traffic,
}

/// Times `cycles` cycles of several workers after the first `skip` cycles. The boxes are those of
/// the start; membership is updated when the ghost margin is used up. Unstrained elements are
/// computed like the others, because most of a run has strained elements.
///
/// # Errors
/// A worker was lost, or the run ended too early.
pub fn time_side_by_side(
    model: &Model,
    workers: usize,
    skip: u64,
    cycles: u64,
) -> Result<Vec<Timing>, String> {
    let centres = centres(model);
    let tree = bisect(&mut Centres(centres.clone()), workers, Before::default())
        .map_err(|lost| lost.to_string())?;
    let shares = deal(model, &centres, &tree, workers);
    let timed = |comm: &mut dyn Transport, share| -> Result<Timing, String> {
        let mut engine = Engine::new(comm, model.settings.clone(), tree.clone(), share)
            .map_err(|l| l.to_string())?;
        engine.blocks.compute_all();
        let mut before = (busy(comm), Instant::now(), engine.timer.seconds, comm.traffic());
        while engine.clock.cycle < skip + cycles {
            if engine.clock.cycle == skip {
                engine.timer.restart();
                before = (busy(comm), Instant::now(), engine.timer.seconds, comm.traffic());
            }
            let agreed = step(&mut engine, comm).map_err(|lost| lost.to_string())?;
            if let Some(failure) = agreed.failure {
                return Err(format!("the run failed {failure} in cycle {}", engine.clock.cycle));
            }
            if engine.clock.is_over(&engine.settings) {
                return Err(format!("the run ends too early: {} cycles", engine.clock.cycle));
            }
            if agreed.margin_used > RENEW_AT {
                engine.renew(comm, tree.clone()).map_err(|lost| lost.to_string())?;
            }
        }
        let (cpu_before, start, seconds, sent) = before;
        let traffic = comm.traffic();
        Ok(Timing {
            cycles,
            cpu_s: busy(comm).saturating_sub(cpu_before).as_secs_f64(),
            wall_s: start.elapsed().as_secs_f64(),
            phases: std::array::from_fn(|p| engine.timer.seconds[p] - seconds[p]),
            traffic: Traffic {
                messages: traffic.messages - sent.messages,
                bytes: traffic.bytes - sent.bytes,
            },
        })
    };
    on_threads(shares, timed).into_iter().collect()
}

struct Plan<'a> {
    cycles: u64,
    force_every: u64,
    trees: [CutTree; 3],
    look: &'a (dyn Fn(&Engine) + Sync),
}

fn one_engine(
    model: &Model,
    comm: &mut dyn Transport,
    share: PartitionData,
    plan: &Plan<'_>,
) -> Trace {
    let tree = plan.trees[0].clone();
    let mut engine =
        Engine::new(comm, model.settings.clone(), tree, share).expect("all workers live");
    let mut trace = Trace { pairs: Vec::new(), nodes: Vec::new(), renewals: 0, trouble: None };
    (plan.look)(&engine);
    while engine.clock.cycle < plan.cycles && !engine.clock.is_over(&engine.settings) {
        let agreed = step(&mut engine, comm).expect("all workers live");
        trace.pairs.push(engine.contact.iter().flat_map(|c| c.owned_pairs()).collect());
        trace.trouble = agreed.failure;
        if agreed.failure.is_some() {
            break;
        }
        let forced = plan.force_every > 0 && engine.clock.cycle.is_multiple_of(plan.force_every);
        let is_due = forced || agreed.margin_used > RENEW_AT;
        if is_due {
            trace.renewals += 1;
            let which = if forced { trace.renewals as usize / 2 % plan.trees.len() } else { 0 };
            engine.renew(comm, plan.trees[which].clone()).expect("all workers live");
        }
        if is_due || agreed.eroded {
            (plan.look)(&engine);
        }
    }
    trace.nodes = (0..engine.nodes.local_count)
        .filter(|&i| engine.nodes.is_owned(i))
        .map(|i| engine.nodes.record(i))
        .collect();
    trace
}
