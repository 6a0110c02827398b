//! `crumple diff --rerun`: the first cycle in which the nodes, and the elements, of two runs part.
//!
//! Rows of histories and checkpoints are many cycles apart. So both jobs are run again, side by
//! side in this process, without a master and without files. After each cycle the workers of both
//! runs compare their states by digests, which feel every bit. What runs without a master lack (new
//! boxes where the load is uneven, outputs) changes no state.

use super::checkpoints::{ElementColumns, SavedState, components, of_elements, of_nodes};
use super::{Difference, NAMED, line};
use crate::analysis::reproduce::{KnownRun, refuse_mpi};
use crate::features;
use crate::input::job::{self, Model};
use crate::results::provenance::ProgramStart;
use crate::results::steering;
use crate::run::decompose::{Before, Centres, bisect};
use crate::run::embedded::{RENEW_AT, centres, deal, on_threads};
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::ElemId;
use crumple_proto::job::Restart;
use crumple_proto::partition::NodeRecord;
use crumple_proto::steering::{Steer, Steered};
use crumple_proto::transport::Transport;
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::Block;
use crumple_worker::parallel::partition::PartitionData;
use crumple_worker::step::step;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Number of cycles after that of the first row that differs. A row has velocities of the next
/// mid-step, so it may see what the state has one cycle later; elements follow their nodes after
/// one more.
const LATER: u64 = 2;
/// Interval between lines about the progress.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// A job that is run again.
struct Repeated {
    model: Model,
    workers: usize,
    tree: CutTree,
}

/// Runs the jobs of two folders again until they part. `differs_by` is the cycle of the first row
/// that differs, if there is one. Returns a description of the first differences.
///
/// # Errors
/// One of the runs cannot be repeated, or they do not part: the reasons.
pub(super) fn run(dirs: [&Path; 2], differs_by: Option<u64>) -> Result<String, Vec<String>> {
    let mut problems: Vec<String> = refuse_mpi("diff --rerun").err().into_iter().collect();
    let mut runs = Vec::new();
    for dir in dirs {
        match repeated(dir) {
            Ok(one) => runs.push(one),
            Err(why) => problems.extend(why),
        }
    }
    let Ok([(a, of_a), (b, of_b)]) = <[_; 2]>::try_from(runs) else { return Err(problems) };
    if !problems.is_empty() {
        return Err(problems);
    }
    let ends = of_a.cycles().min(of_b.cycles());
    let until = differs_by.map_or(ends, |cycle| ends.min(cycle + LATER));
    eprintln!(
        "both jobs are run again, on {} and {} workers, for at most {until} cycles",
        a.workers, b.workers
    );
    let seen = side_by_side(&[a, b], until);
    if seen.iter().all(|run| run.copies.iter().all(Option::is_none)) {
        let made = [&of_a.start, &of_b.start].map(ProgramStart::program);
        return Err(vec![same_now(dirs, &seen, made)]);
    }
    Ok(describe(&seen))
}

/// Reads the job of a folder.
///
/// # Errors
/// All reasons why the run cannot be repeated.
fn repeated(dir: &Path) -> Result<(Repeated, KnownRun), Vec<String>> {
    let known = KnownRun::read(dir).map_err(|why| vec![why])?;
    let mut problems: Vec<String> = known.obstacle(dir).into_iter().collect();
    let changed = known.changed_files();
    if !changed.is_empty() {
        problems.extend(changed);
        problems.push("restore these files".into());
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let start = &known.start;
    let report = |report: job::Report| vec![report.to_string()];
    let mut model = job::read(&start.job_file, &start.set).map_err(report)?;
    if model.job.restart != Restart::default() {
        return Err(vec![format!(
            "{}: `restart` changes a run that continues: one run from time 0 does not repeat it",
            start.job_file.display()
        )]);
    }
    if let Some(orders) = known.steering(dir) {
        model.settings.planned = steering::read(&orders).map_err(|why| vec![why])?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = model.workers(Some(start.workers.min(cores)), cores).map_err(report)?;
    let tree = cut(&model, workers).map_err(|why| vec![why])?;
    Ok((Repeated { model, workers, tree }, known))
}

/// Returns the boxes of the workers at the start.
fn cut(model: &Model, workers: usize) -> Result<CutTree, String> {
    bisect(&mut Centres(centres(model)), workers, Before::default())
        .map_err(|lost| lost.to_string())
}

/// Cycles done, and time [time].
type CycleAndTime = (u64, f64);

/// Observations of one run.
#[derive(Default)]
struct RunSeen {
    /// The last state that was compared.
    last: CycleAndTime,
    /// Nodes after the first cycle in which they differ, then elements.
    copies: [Option<(CycleAndTime, SavedState)>; 2],
}

/// Runs both jobs until nodes and elements have parted, but at most `until` cycles.
fn side_by_side(runs: &[Repeated; 2], until: u64) -> [RunSeen; 2] {
    let meeting = Meeting::new(runs.iter().map(|run| run.workers).sum());
    let limits = SideBySide { until, meeting: &meeting };
    std::thread::scope(|scope| {
        let watch = |which: usize| {
            let (run, limits) = (&runs[which], &limits);
            move || {
                let shares = deal(&run.model, &centres(&run.model), &run.tree, run.workers);
                let seen =
                    on_threads(shares, |comm, share| advance(which, run, (comm, share), limits));
                merged(seen)
            }
        };
        let threads = [0, 1].map(|which| scope.spawn(watch(which)));
        threads.map(|thread| thread.join().expect("a worker was lost"))
    })
}

/// Joins what the workers of a run have seen.
fn merged(shares: Vec<RunSeen>) -> RunSeen {
    let mut all = RunSeen::default();
    for share in shares {
        all.last = share.last;
        for (known, copy) in all.copies.iter_mut().zip(share.copies) {
            let Some((moment, state)) = copy else { continue };
            let (_, joined) = known.get_or_insert_with(|| (moment, SavedState::default()));
            joined.nodes.extend(state.nodes);
            joined.elements.extend(state.elements);
        }
    }
    all
}

/// Limit of the runs, and the place where they meet.
struct SideBySide<'a> {
    until: u64,
    meeting: &'a Meeting,
}

/// Runs one worker of the run `which`.
fn advance(
    which: usize,
    run: &Repeated,
    (comm, share): (&mut dyn Transport, PartitionData),
    limits: &SideBySide<'_>,
) -> RunSeen {
    let _seat = Seat(limits.meeting);
    let settings = run.model.settings.clone();
    let mut engine =
        Engine::new(comm, settings, run.tree.clone(), share).expect("all workers live");
    let mut seen = RunSeen::default();
    let mut said = Instant::now();
    let is_speaker = which == 0 && comm.rank() == 1;
    while let Some(equal) = limits.meeting.compare(which, digests(&engine)) {
        let moment = (engine.clock.cycle, engine.clock.time);
        seen.last = moment;
        let copies: [fn(&Engine) -> SavedState; 2] = [copy_of_nodes, copy_of_elements];
        for (kind, copy) in copies.iter().enumerate().filter(|(kind, _)| !equal[*kind]) {
            seen.copies[kind].get_or_insert_with(|| (moment, copy(&engine)));
        }
        let is_over = moment.0 >= limits.until || engine.clock.is_over(&engine.settings);
        if is_over || seen.copies.iter().all(Option::is_some) {
            break;
        }
        if is_speaker && said.elapsed() > LINE_EVERY {
            said = Instant::now();
            eprintln!("cycle {} of at most {}, time {:.4e}", moment.0, limits.until, moment.1);
        }
        obey(&mut engine);
        let agreed = step(&mut engine, comm).expect("all workers live");
        if agreed.failure.is_some() {
            break;
        }
        if agreed.margin_used > RENEW_AT {
            engine.renew(comm, run.tree.clone()).expect("all workers live");
        }
    }
    seen
}

/// Carries out the orders of users that change settings, in the cycles of the known run.
fn obey(engine: &mut Engine) {
    let Engine { settings, clock, .. } = engine;
    if !clock.starts_outer_step(settings) {
        return;
    }
    while settings.planned.first().is_some_and(|planned| planned.cycle <= clock.cycle) {
        let steer = settings.planned.remove(0).steer;
        let (rows, fields) = (clock.rows, clock.fields as u64);
        let at = Steered { steer, cycle: clock.cycle, time: clock.time, rows, fields };
        if let Steer::Set(change) = steer {
            settings.change(change, &at);
        }
    }
}

/// Digests of the nodes and of the elements of a worker. The sum over workers does not depend on
/// how many there are.
type Digests = [u64; 2];

fn digests(engine: &Engine) -> Digests {
    let values = |node: &NodeRecord| components(node).map(|(_, value)| value);
    let nodes = owned(engine).map(|node| digest(node.id.label(), &values(&node)));
    let elements = own(engine).map(|(id, block, i)| digest(id.label(), &block.columns(i)));
    let sum = |each: &mut dyn Iterator<Item = u64>| each.fold(0, u64::wrapping_add);
    [sum(&mut { nodes }), sum(&mut { elements })]
}

/// Returns a number that changes with every bit of an id and values. Zeros have no sign.
fn digest(id: u64, values: &[f64]) -> u64 {
    let mix = |state: u64, bits: u64| {
        let mixed = (state ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        mixed ^ (mixed >> 32)
    };
    values.iter().map(|value| (value + 0.0).to_bits()).fold(mix(0, id + 1), mix)
}

/// Returns the nodes that a worker owns.
fn owned(engine: &Engine) -> impl Iterator<Item = NodeRecord> + '_ {
    let nodes = &engine.nodes;
    (0..nodes.local_count).filter(|&i| nodes.is_owned(i)).map(|i| nodes.record(i))
}

/// Returns the elements of a worker, with their blocks and places there.
fn own(engine: &Engine) -> impl Iterator<Item = (ElemId, &Block, usize)> {
    let records = &engine.blocks.elements;
    engine.blocks.blocks.iter().flat_map(move |block| {
        (0..block.count).map(move |i| (records[block.first + i].record.id, block, i))
    })
}

fn copy_of_nodes(engine: &Engine) -> SavedState {
    let nodes = owned(engine).map(|node| (node.id, node)).collect();
    SavedState { nodes, ..SavedState::default() }
}

fn copy_of_elements(engine: &Engine) -> SavedState {
    let mut state = SavedState::default();
    let mut names: (usize, Arc<[String]>) = (usize::MAX, Arc::new([]));
    for (id, block, i) in own(engine) {
        if names.0 != block.first {
            names = (block.first, Block::names_of(&*block.element).into());
        }
        let columns = ElementColumns { names: names.1.clone(), values: block.columns(i) };
        state.elements.insert(id, columns);
    }
    state
}

/// Place where all workers of both runs meet after each cycle.
struct Meeting {
    /// Number of workers.
    workers: usize,
    state: Mutex<Attendance>,
    changed: Condvar,
}

#[derive(Default)]
struct Attendance {
    /// Number of workers that have come.
    here: usize,
    /// Number of meetings that were held.
    held: u64,
    /// Sums of the digests of each run.
    sums: [Digests; 2],
    /// Result of the last meeting: true for nodes, and for elements, that are equal.
    equal: [bool; 2],
    /// True if a worker has left.
    is_closed: bool,
}

/// Worker that takes part in a meeting. When one has left, there is no further meeting: none waits
/// for a run that has failed.
struct Seat<'a>(&'a Meeting);

impl Drop for Seat<'_> {
    fn drop(&mut self) {
        self.0.attendance().is_closed = true;
        self.0.changed.notify_all();
    }
}

impl Meeting {
    fn new(workers: usize) -> Self {
        Self { workers, state: Mutex::default(), changed: Condvar::new() }
    }

    fn attendance(&self) -> MutexGuard<'_, Attendance> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for all others, and returns true for what is equal in both runs: nodes, and elements.
    /// Returns `None` if one has left.
    fn compare(&self, run: usize, own: Digests) -> Option<[bool; 2]> {
        let mut now = self.attendance();
        let sums = &mut now.sums[run];
        sums.iter_mut().zip(own).for_each(|(sum, own)| *sum = sum.wrapping_add(own));
        now.here += 1;
        let held = now.held;
        if now.here == self.workers && !now.is_closed {
            let [a, b] = std::mem::take(&mut now.sums);
            now.equal = [a[0] == b[0], a[1] == b[1]];
            (now.here, now.held) = (0, held + 1);
            self.changed.notify_all();
        }
        while now.held == held && !now.is_closed {
            now = self.changed.wait(now).unwrap_or_else(PoisonError::into_inner);
        }
        (now.held > held).then_some(now.equal)
    }
}

/// Says that the runs do not part any more.
fn same_now(dirs: [&Path; 2], seen: &[RunSeen; 2], made: [String; 2]) -> String {
    let commit = features::COMMIT.get().copied().map(String::from);
    let this = ProgramStart { version: env!("CARGO_PKG_VERSION").into(), commit, ..<_>::default() };
    format!(
        "the runs do not part when they are run again: all nodes and elements are equal after each \
         of {} cycles; {} was made by {}, {} by {}, and this program is {}. Look for the \
         difference in programs and machines, and in values that no node and no element has",
        seen[0].last.0,
        dirs[0].display(),
        made[0],
        dirs[1].display(),
        made[1],
        this.program()
    )
}

/// Describes the first differences of nodes and elements.
fn describe(seen: &[RunSeen; 2]) -> String {
    type Find = fn([&SavedState; 2]) -> Vec<Difference>;
    type Count = fn([&SavedState; 2]) -> [usize; 3];
    let kinds: [(&str, Find, Count); 2] = [
        ("nodes", of_nodes, |[a, b]| {
            counts([&a.nodes, &b.nodes], |x, y| components(x) == components(y))
        }),
        ("elements", of_elements, |[a, b]| {
            counts([&a.elements, &b.elements], |x, y| x.values == y.values)
        }),
    ];
    let mut out = String::from("\nrun again, all digits\n");
    for (at, (name, find, count)) in kinds.into_iter().enumerate() {
        // Writing to a string cannot fail.
        let [Some((moment, a)), Some((of_b, b))] = seen.each_ref().map(|run| &run.copies[at])
        else {
            let _ = writeln!(out, "{name}: equal after each of {} cycles", seen[0].last.0);
            continue;
        };
        let states = [a, b];
        let [differ, both, single] = count(states);
        let after = match moment.0 {
            0 => "differ from the start".to_string(),
            cycle => format!("first differ after cycle {cycle} (equal after {})", cycle - 1),
        };
        let times = match moment.1 == of_b.1 {
            true => format!("time {:.6e}", moment.1),
            false => format!("times {:e} / {:e}", moment.1, of_b.1),
        };
        let _ = writeln!(out, "{name}: {after}, {times}: {differ} of {both}");
        if single > 0 {
            let _ = writeln!(out, "  only one of the runs has {single} {name}");
        }
        let found = find(states);
        found.iter().take(NAMED).for_each(|one| out += &line(one));
    }
    out
}

/// Returns how many entries that both have differ, how many both have, and how many only one has.
fn counts<K: Ord, V>(
    [a, b]: [&BTreeMap<K, V>; 2],
    is_equal: impl Fn(&V, &V) -> bool,
) -> [usize; 3] {
    let both = a.iter().filter_map(|(id, x)| Some((x, b.get(id)?)));
    let equal: Vec<bool> = both.map(|(x, y)| is_equal(x, y)).collect();
    let differ = equal.iter().filter(|is_equal| !**is_equal).count();
    [differ, equal.len(), a.len() + b.len() - 2 * equal.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Step [ms]. It is a power of two, so that times are exact.
    const STEP: f64 = 1.0 / 1024.0;
    /// A strip of four shells at rest.
    const STRIP: &str = r#"
        end_time = 10.0
        [mesh]
        nodes = [
            [1, 0, 0, 0], [2, 10, 0, 0], [3, 20, 0, 0], [4, 30, 0, 0], [5, 40, 0, 0],
            [6, 0, 10, 0], [7, 10, 10, 0], [8, 20, 10, 0], [9, 30, 10, 0], [10, 40, 10, 0]]
        shells = [[1, 1, 1, 2, 7, 6], [2, 1, 2, 3, 8, 7], [3, 1, 3, 4, 9, 8], [4, 1, 4, 5, 10, 9]]
        node_sets = { tip = [5] }
        [time]
        dt_max = 0.0009765625
        [[material]]
        name = "steel"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 207.0
        poisson = 0.3
        [[part]]
        id = 1
        material = "steel"
        thickness = 1.0
    "#;
    /// A force on node 5 that is 0 in the steps up to the one that begins at 20 steps, and not 0 in
    /// the next one.
    const LATER_FORCE: &str = r#"
        [[curve]]
        name = "later"
        points = [[0.0, 0.0], [0.01953125, 0.0], [0.02, 1.0], [10.0, 1.0]]
        [[load]]
        nodes = "tip"
        force = [0.0, 0.001, 0.0]
        curve = "later"
    "#;

    fn strip(more: &str, workers: usize, sets: &[&str]) -> Repeated {
        let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
        let model = job::read_text("strip.toml".into(), format!("{STRIP}{more}"), &sets);
        let model = model.unwrap_or_else(|report| panic!("{report}"));
        let tree = cut(&model, workers).unwrap();
        Repeated { model, workers, tree }
    }

    /// The step of cycle 22 is the first one that begins with a force. It moves one node; the
    /// element at this node is strained one cycle later.
    #[test]
    fn a_force_that_begins_later_is_first_seen_at_its_node_then_in_its_element() {
        for workers in [1, 2] {
            let runs = [strip("", 1, &[]), strip(LATER_FORCE, workers, &[])];
            let seen = side_by_side(&runs, 60);
            let said = describe(&seen);
            let nodes = "nodes: first differ after cycle 22 (equal after 21), time 2.148438e-2: \
                         1 of 10\n  node 5: velocity y 0e0 / ";
            assert!(said.contains(nodes), "{said}");
            let elements = "elements: first differ after cycle 23 (equal after 22), time \
                            2.246094e-2: 1 of 4\n  element 4: ";
            assert!(said.contains(elements), "{said}");
            assert_eq!(seen[0].last, (23, 23.0 * STEP), "the runs end when both have parted");
        }
    }

    #[test]
    fn runs_that_part_only_after_the_last_cycle_are_equal() {
        let runs = [strip("", 1, &[]), strip(LATER_FORCE, 2, &[])];
        let seen = side_by_side(&runs, 21);
        assert!(seen.iter().flat_map(|run| &run.copies).all(Option::is_none));
        let said = same_now([Path::new("a"), Path::new("b")], &seen, ["1", "2"].map(String::from));
        assert!(said.contains("after each of 21 cycles; a was made by 1, b by 2"), "{said}");
        assert!(describe(&side_by_side(&runs, 22)).contains("elements: equal after each of 22"));
    }

    /// Neither run waits for the other when one has come to its end.
    #[test]
    fn a_run_that_ends_ends_the_other_one() {
        let runs = [strip("", 2, &["time.max_cycles=10"]), strip("", 1, &[])];
        let seen = side_by_side(&runs, 60);
        assert_eq!(seen.map(|run| run.last.0), [10, 10]);
    }

    #[test]
    fn a_digest_feels_the_last_bit_and_no_sign_of_a_zero() {
        let of = |value: f64| digest(7, &[0.0, value]);
        assert_ne!(of(1.0), of(1.0 + f64::EPSILON));
        assert_ne!(of(1.0), digest(8, &[0.0, 1.0]));
        assert_ne!(of(1.0), digest(7, &[1.0, 0.0]));
        assert_eq!(of(0.0), of(-0.0));
    }
}
