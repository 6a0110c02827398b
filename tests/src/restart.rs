//! Runs that are interrupted and continue from files, on engines in this process.

use crate::fields::assert_same_fields;
use crumple::input::job::Model;
use crumple::results::histories::NAMES;
use crumple::results::summary::state_digest;
use crumple::run::decompose::{Before, Centres, bisect};
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::{Captured, FileRecord, partial_name};
use crumple_proto::ids::NodeId;
use crumple_proto::job::Compression;
use crumple_proto::partition::NodeRecord;
use crumple_proto::transport::{Transport, threads};
use crumple_worker::checkpoint::fit::{Expected, InitialModel, verify};
use crumple_worker::checkpoint::{read_state, writer::Task};
use crumple_worker::engine::Engine;
use crumple_worker::parallel::partition::PartitionData;
use crumple_worker::step::step;
use crumple_worker::time::Clock;
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Fraction of the ghost margin used at which membership is updated.
const RENEW_AT: f64 = 0.7;

/// When a run is interrupted and ends [cycles], and its workers before and after.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// First cycle at which it may be interrupted; it is, when the next outer step begins.
    pub at: u64,
    /// Last cycle.
    pub cycles: u64,
    /// Number of workers before and after.
    pub workers: [usize; 2],
}

/// Runs a job with an interruption. Returns the digest of the state at the end.
///
/// # Panics
/// When a worker is lost or a file cannot be written or read.
pub fn run_interrupted(model: &Model, plan: Plan) -> String {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let tree = |workers| {
        bisect(&mut Centres(centres(model)), workers, Before::default()).expect("one process")
    };
    let (first, second) = (tree(plan.workers[0]), tree(plan.workers[1]));
    let written = side_by_side(plan.workers[0], |comm| {
        let share = share_of(model, &first, comm.rank() - 1);
        let mut engine = Engine::new(comm, model.settings.clone(), first.clone(), share).unwrap();
        advance(&mut engine, comm, &first, |e| {
            e.clock.cycle >= plan.at && e.clock.starts_outer_step(&e.settings)
        });
        let task = Task {
            copied: engine.copy_state(comm).unwrap(),
            dir: dir.path().to_owned(),
            cycle: plan.at,
            repeat: 0,
            worker: comm.rank() - 1,
            compression: Compression::Zstd,
            copy: Duration::ZERO,
            progress: Default::default(),
        };
        let Clock { cycle, time, rows, fields, .. } = engine.clock;
        let captured = Captured { cycle, time, rows, fields: fields as u64 };
        (task.run().files.unwrap(), captured)
    });
    let (common, captured) = (written[0].0[1].clone(), written[0].1);
    let pieces: Vec<FileRecord> = written.into_iter().map(|(f, _)| f[0].clone()).collect();
    let folder = dir.path().join(partial_name(plan.at, 0));
    assert_fits(model, &folder, (&common, &pieces), captured);
    let nodes = side_by_side(plan.workers[1], |comm| {
        let place = (comm.rank() - 1, comm.size() - 1);
        let mut engine = restored(comm, model, &second, (&folder, &common, &pieces), place);
        advance(&mut engine, comm, &second, |e| e.clock.cycle >= plan.cycles);
        (0..engine.nodes.local_count)
            .filter(|&i| engine.nodes.is_owned(i))
            .map(|i| engine.nodes.record(i))
            .collect::<Vec<NodeRecord>>()
    });
    state_digest(&mut nodes.concat())
}

/// Checks that a run accepts its own files as a state of its job.
fn assert_fits(
    model: &Model,
    folder: &Path,
    (common, pieces): (&FileRecord, &[FileRecord]),
    captured: Captured,
) {
    let (elements, nodes) = model.records();
    let source = InitialModel { settings: &model.settings, elements: &elements, nodes: &nodes };
    let expected = Expected { captured, elements: elements.len() };
    verify(folder, common, pieces, source, expected).unwrap();
}

fn restored(
    comm: &mut dyn Transport,
    model: &Model,
    tree: &CutTree,
    (folder, common, pieces): (&Path, &FileRecord, &[FileRecord]),
    place: (usize, usize),
) -> Engine {
    let read = read_state(folder, &model.settings, common, pieces, place).unwrap();
    let (settings, state) = (model.settings.clone(), (read.common, read.own));
    Engine::restore(comm, settings, tree.clone(), read.share, state).unwrap()
}

/// Computes steps until `ends`, the end of the run, or a failure.
fn advance(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    tree: &CutTree,
    ends: impl Fn(&Engine) -> bool,
) {
    while !ends(engine) && !engine.clock.is_over(&engine.settings) {
        let agreed = step(engine, comm).unwrap();
        if agreed.failure.is_some() {
            return;
        }
        if agreed.margin_used > RENEW_AT {
            engine.renew(comm, tree.clone()).unwrap();
        }
    }
}

fn side_by_side<T: Send>(workers: usize, run: impl Fn(&mut dyn Transport) -> T + Sync) -> Vec<T> {
    let mut ends = threads::connect(workers + 1);
    let _master = ends.remove(0);
    std::thread::scope(|scope| {
        let run = &run;
        let start = |mut end| scope.spawn(move || run(&mut end));
        let threads: Vec<_> = ends.into_iter().map(start).collect();
        threads.into_iter().map(|t| t.join().expect("a worker was lost")).collect()
    })
}

fn centres(model: &Model) -> Vec<[f64; 3]> {
    let (elements, nodes) = model.records();
    let of_id: HashMap<NodeId, [f64; 3]> = nodes.iter().map(|n| (n.id, n.x)).collect();
    let centre = |e| crumple_worker::parallel::migrate::centre_of_record(e, |id| of_id[&id]);
    elements.iter().map(centre).collect()
}

fn share_of(model: &Model, tree: &CutTree, worker: usize) -> PartitionData {
    let (elements, nodes) = model.records();
    let own = elements.into_iter().zip(centres(model));
    let own: Vec<_> =
        own.filter(|(_, c)| tree.worker_of(*c) == worker).map(|(e, _)| (e, Vec::new())).collect();
    let mut ids: Vec<NodeId> = own.iter().flat_map(|(e, _)| e.nodes).collect();
    ids.sort_unstable();
    ids.dedup();
    let is_own = |n: &NodeRecord| ids.binary_search(&n.id).is_ok();
    let nodes = nodes.into_iter().filter(is_own).collect();
    PartitionData { elements: own, nodes, ..PartitionData::default() }
}

/// Words in the titles of columns of costs and of the partition.
const OF_WORKERS: [&str; 4] = ["wall [s]", "cpu", "redecompositions", " elements"];

/// Checks that two runs of a job have the same histories, byte for byte, except for columns of
/// costs and of the partition.
///
/// # Panics
/// When they differ.
pub fn assert_same_histories(one: &Path, other: &Path) {
    for name in NAMES.iter().chain([&"history.csv"]) {
        assert_eq!(one.join(name).exists(), other.join(name).exists(), "{name}");
        if !one.join(name).exists() {
            continue; // the scene has none
        }
        let [a, b] = [one, other].map(|folder| fs::read_to_string(folder.join(name)).unwrap());
        assert_eq!(a.lines().count(), b.lines().count(), "{name}: rows");
        let titles: Vec<&str> = a.lines().next().unwrap().split(',').collect();
        for (number, (x, y)) in a.lines().zip(b.lines()).enumerate() {
            let (x, y): (Vec<&str>, Vec<&str>) = (x.split(',').collect(), y.split(',').collect());
            assert_eq!((x.len(), y.len()), (titles.len(), titles.len()), "{name}, row {number}");
            for (title, (x, y)) in titles.iter().zip(x.iter().zip(&y)) {
                let of_workers = OF_WORKERS.iter().any(|w| title.contains(w));
                assert!(of_workers || x == y, "{name}, row {number}, {title}: {x} and {y}");
            }
        }
    }
}

/// Checks the files of a run that continued against those of one that did not: histories as in
/// [`assert_same_histories`], and fields as in [`assert_same_fields`].
///
/// # Panics
/// When they differ.
pub fn assert_same_files(whole: &Path, continued: &Path) {
    assert_same_histories(whole, continued);
    assert_same_fields(whole, continued);
}

/// Returns the names of the complete checkpoints of a run, ascending.
///
/// # Panics
/// When the folder cannot be read.
pub fn checkpoints(out: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(out.join("checkpoints")) else { return Vec::new() };
    let name = |e: fs::DirEntry| e.file_name().to_string_lossy().into_owned();
    let mut names: Vec<String> = entries.map(|e| name(e.unwrap())).collect();
    names.retain(|n| out.join("checkpoints").join(n).join("MANIFEST").exists());
    names.sort();
    names
}

/// Copies a folder with all its content.
///
/// # Panics
/// When a file cannot be read or written.
pub fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_folder(&path, &target);
        } else if path.is_file() {
            fs::copy(&path, &target).unwrap(); // not the socket of a run that was killed
        }
    }
}
