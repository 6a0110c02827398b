//! Bits do not depend on workers: the union of workers' pairs equals the pairs of the serial run
//! at every step, and the state is the same to the last bit, for any number and position of
//! boxes.

use crumple::run::embedded::run_alone;
use crumple_proto::boxes::CutTree;
use crumple_proto::transport::threads;
use crumple_tests::program::{crumple_with, run};
use crumple_tests::restart::assert_same_histories;
use crumple_tests::{Trace, case, read, run_side_by_side, watch_side_by_side};
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::Portion;
use crumple_worker::time::ElementSet;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::{LazyLock, Mutex};

/// Runs four tubes and three plates that fly at each other, tumbling.
fn tumble(workers: usize, cycles: u64, force_every: u64) -> Trace {
    run_side_by_side(&read(&case("tumble"), &[]), workers, cycles, force_every)
}

fn assert_same(serial: &Trace, parallel: &Trace, what: &str) {
    for (cycle, (a, b)) in serial.pairs.iter().zip(&parallel.pairs).enumerate() {
        assert_eq!(a, b, "{what}: pairs in cycle {cycle}");
    }
    assert_eq!(serial.pairs.len(), parallel.pairs.len(), "{what}: cycles");
    assert_eq!(serial.digest(), parallel.digest(), "{what}: state");
}

const CYCLES: u64 = 2500;

/// The run of one worker, with which tests compare.
static SERIAL: LazyLock<Trace> = LazyLock::new(|| tumble(1, CYCLES, 0));

#[test]
fn union_of_workers_pairs_is_the_serial_runs() {
    let serial = &*SERIAL;
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(met > 1000, "there is contact: {met} pairs");
    for workers in [2, 3, 4, 7] {
        assert_same(serial, &tumble(workers, CYCLES, 0), &format!("{workers} workers"));
    }
}

#[test]
fn forced_redecompositions_of_either_kind_change_no_bit() {
    let serial = &*SERIAL;
    for workers in [2, 5] {
        let forced = tumble(workers, CYCLES, 7);
        assert!(forced.renewals >= CYCLES / 7);
        assert_same(serial, &forced, &format!("{workers} workers, boxes renewed every 7 cycles"));
    }
}

/// Pairs in order, too many to be replicated: forces travel after each phase of a sweep.
#[test]
fn many_pairs_in_order_give_the_same_bits() {
    let model = read(&case("brick-wall"), &["contact.iteration=gauss_seidel"]);
    let serial = run_side_by_side(&model, 1, 80, 0);
    assert!(serial.pairs.iter().all(|pairs| pairs.len() >= 300), "contact is dense");
    for workers in [2, 3] {
        let parallel = run_side_by_side(&model, workers, 80, 0);
        assert_same(&serial, &parallel, &format!("{workers} workers"));
    }
}

/// A second decomposition of contact: workers search for nodes, edges and segments of others, in
/// shells and solids, with folds, friction, the mortar law, walls, subcycles and elements that
/// fail. Forced renewals move the cuts.
#[test]
fn a_second_decomposition_of_contact_changes_no_bit() {
    let coarse = "scene.elements=6";
    let mortar = "contact.law=\"mortar\"";
    let penalty = "contact.law=\"penalty\"";
    let fails = "material.0.failure_strain=0.02";
    for (name, cycles, sets) in [
        ("tumble", 1200, &["contact.friction=0.2"][..]),
        ("tumble", 600, &[mortar]),
        ("tumble", 600, &[penalty]),
        ("tube-crush", 2500, &[coarse]),
        ("brick-wall", 60, &[]),
        ("can-crush", 120, &[]),
        ("pipe-whip", 150, &[]),
        ("tumble", 600, &["time.subcycles=2"]),
        ("tumble", 900, &[fails]),
    ] {
        let serial = run_side_by_side(&read(&case(name), sets), 1, cycles, 0);
        assert!(serial.pairs.iter().any(|p| !p.is_empty()), "{name} {sets:?}: no contact");
        let with_rcb = read(&case(name), &[sets, &["parallel.contact=\"rcb\""]].concat());
        for (workers, force_every) in [(2, 0), (5, 7)] {
            let parallel = run_side_by_side(&with_rcb, workers, cycles, force_every);
            let what = format!("{name} {sets:?}: {workers} workers, forced {force_every}");
            assert_same(&serial, &parallel, &what);
        }
    }
}

/// The normals of the smooth surface depend on all segments around a node: each worker has them,
/// with either decomposition, between shells and between solids, with folds and elements that
/// fail. Forced renewals move the boxes.
#[test]
fn a_smooth_surface_changes_the_motion_and_no_bit_with_the_workers() {
    let fails = "material.0.failure_strain=0.02";
    for (name, cycles, sets) in [
        ("tumble", 1200, &["contact.friction=0.2"][..]),
        ("tumble", 900, &[fails]),
        ("tube-crush", 2500, &["scene.elements=6"]),
        ("pipe-whip", 150, &[]),
        ("can-crush", 120, &[]),
    ] {
        let with_surface = |surface: &str, more: &[&str]| {
            let surface = format!("contact.surface=\"{surface}\"");
            read(&case(name), &[sets, &[surface.as_str()], more].concat())
        };
        let serial = run_side_by_side(&with_surface("smooth", &[]), 1, cycles, 0);
        let flat = run_side_by_side(&with_surface("flat", &[]), 1, cycles, 0);
        assert_ne!(serial.digest(), flat.digest(), "{name} {sets:?}: the option has no effect");
        let with_boxes = with_surface("smooth", &[]);
        let with_rcb = with_surface("smooth", &["parallel.contact=\"rcb\""]);
        for (model, workers, force_every) in
            [(&with_boxes, 2, 0), (&with_boxes, 5, 7), (&with_rcb, 3, 0)]
        {
            let parallel = run_side_by_side(model, workers, cycles, force_every);
            let what = format!("{name} {sets:?}: {workers} workers, forced {force_every}");
            assert_same(&serial, &parallel, &what);
        }
    }
}

/// A block is on a long segment of another worker before it changes workers. Its worker needs the
/// segments around all corners of that one.
#[test]
fn a_smooth_surface_has_the_segments_around_a_far_corner() {
    let digest = |workers: &str| {
        let job = case("drum");
        let words = [
            &["run", job.to_str().expect("UTF-8"), "--workers", workers, "--no-report"][..],
            &["--set", "scene.facets=20", "--set", "time.max_cycles=3000"],
            &["--set", "output.field_interval=-1", "--set", "parallel.imbalance=1000"],
        ];
        run(crumple_with(&words.concat())).with_code(0).digest()
    };
    assert_eq!(digest("1"), digest("2"));
}

/// Elements fail in contact, and their segments leave the surface; more workers than contact nodes
/// leave some workers without any.
#[test]
fn a_second_decomposition_follows_erosion_and_has_workers_without_nodes() {
    let rcb = "parallel.contact=\"rcb\"";
    let model = read(&case("tumble"), &["material.0.failure_strain=0.02", rcb]);
    let eroded = Mutex::new(0);
    watch_side_by_side(&model, 3, [900, 0], &|e: &Engine| {
        let mut most = eroded.lock().unwrap();
        *most = e.erosions.max(*most);
    });
    assert!(*eroded.lock().unwrap() > 0, "no element has failed");
    let sets = ["scene.elements=2"];
    let serial = run_side_by_side(&read(&case("bars"), &sets), 1, 60, 0);
    let with_rcb = read(&case("bars"), &[&sets[..], &[rcb]].concat());
    assert_same(&serial, &run_side_by_side(&with_rcb, 20, 60, 9), "20 workers");
}

/// A worker searches for a part of the contact nodes that is as large as those of the others, and
/// owns only some of them. Elements stay.
#[test]
fn a_second_decomposition_divides_the_contact_nodes_evenly_and_elements_stay() {
    let model = read(&case("tumble"), &["parallel.contact=\"rcb\""]);
    let workers = 4;
    let looked: Mutex<Vec<(u64, usize, usize, usize)>> = Mutex::default();
    watch_side_by_side(&model, workers, [1500, 50], &|e: &Engine| {
        let surface = &e.contact.as_ref().expect("contact").surface;
        let foreign = surface.slaves.iter().filter(|&&s| !e.nodes.is_owned(s as usize)).count();
        // Each segment is searched by the worker in whose part its first node lies.
        let cuts = &e.halo.regions.as_ref().expect("a second decomposition").tree;
        let place = |n: u32| std::array::from_fn(|c| e.nodes.x[n as usize][c]);
        for s in &surface.segments {
            let is_mine = cuts.worker_of(place(s.nodes[0])) == e.nodes.me as usize;
            assert_eq!(s.searched, is_mine, "{:?}", s.id);
        }
        // The range of velocities is that of the owned nodes: those of ghosts come later in a step.
        let owned = (0..e.nodes.local_count).filter(|&i| e.nodes.is_owned(i));
        let largest = owned.map(|i| e.nodes.v[i][0]).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(surface.velocities(&e.nodes)[0], largest);
        let counts = (e.clock.cycle, surface.slaves.len(), foreign, e.blocks.elements.len());
        looked.lock().unwrap().push(counts);
    });
    let looked = looked.into_inner().unwrap();
    let elements = |cycle: u64| -> Vec<usize> {
        let mut all: Vec<usize> = looked.iter().filter(|l| l.0 == cycle).map(|l| l.3).collect();
        all.sort_unstable();
        all
    };
    let cycles: BTreeSet<u64> = looked.iter().map(|l| l.0).collect();
    assert!(cycles.len() > 20);
    for cycle in cycles {
        let at: Vec<_> = looked.iter().filter(|l| l.0 == cycle).collect();
        let all: usize = at.iter().map(|l| l.1).sum();
        assert_eq!(all, model.mesh.nodes.len(), "each node of the shells belongs to one worker");
        for (_, slaves, _, _) in &at {
            // Two levels of cuts, each with up to 0.5 % of the nodes in its box on the wrong side,
            // which is 1 % of a half: 2 %, and nodes with equal coordinates.
            let mean = all as f64 / workers as f64;
            assert!((*slaves as f64 - mean).abs() <= 0.03 * mean, "cycle {cycle}: {slaves}");
        }
        assert_eq!(elements(cycle), elements(0));
    }
    assert!(looked.iter().any(|l| l.2 > l.1 / 10), "no worker searches for many nodes of others");
}

/// Where contact does not limit the step, a skin only saves time: candidates that are not in
/// contact do not change the result.
#[test]
fn how_far_candidates_are_collected_changes_no_bit() {
    for (name, cycles, skins) in
        [("tumble", CYCLES, ["0.1", "10"]), ("can-crush", 300, ["0.05", "20"])]
    {
        let run = |sets: &[&str]| run_side_by_side(&read(&case(name), sets), 1, cycles, 0);
        let default = run(&[]);
        assert!(default.pairs.iter().any(|p| !p.is_empty()), "{name}: there is no contact");
        for skin in skins {
            assert_same(
                &default,
                &run(&[&format!("contact.skin={skin}")]),
                &format!("{name}, skin {skin}"),
            );
        }
    }
}

/// Returns a job's engine after some cycles.
fn engine(name: &str, sets: &[&str], cycles: u64, compute_all: bool) -> Engine {
    let look = |e: &mut Engine| {
        if compute_all {
            e.blocks.compute_all();
        }
        if e.clock.cycle < cycles { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let ended = run_alone(&read(&case(name), sets), look).expect("one worker");
    assert_eq!((ended.trouble, ended.engine.clock.cycle), (None, cycles), "{name}");
    ended.engine
}

/// Held rims, pressure, contact, a wall, solids.
#[test]
fn leaving_out_elements_that_nothing_has_strained_changes_no_bit() {
    let tube = ["scene.elements=5"];
    for (name, sets, cycles) in [
        ("plate", &[][..], 60),
        ("beam", &[], 40),
        ("tube-crush", &tube, 60),
        ("brick-wall", &[], 30),
    ] {
        let [some, all] = [false, true].map(|compute_all| engine(name, sets, cycles, compute_all));
        let bits = |rows: &[[f64; 4]]| {
            rows.as_flattened().iter().map(|c| (c + 0.0).to_bits()).collect::<Vec<_>>()
        };
        let columns = |e: &Engine| {
            [&e.nodes.x, &e.nodes.v, &e.nodes.w, &e.nodes.force].map(|column| bits(column))
        };
        assert!(columns(&some) == columns(&all), "{name}");
        assert!(some.clock.dt > 0.0 && some.clock.dt == all.clock.dt, "{name}");
    }
}

/// A renewal determines again which elements are unstrained, also in groups with strained ones.
#[test]
fn strained_elements_that_stand_still_keep_their_forces() {
    let mut e = engine("plate", &["initial_velocity.0.velocity=[0, 0, 0.5]"], 5, false);
    e.nodes.v.fill([0.0; 4]);
    e.nodes.w.fill([0.0; 4]);
    let forces = |e: &mut Engine| {
        for portion in Portion::ALL {
            e.blocks.add_internal_forces(&mut e.nodes, e.clock.dt, ElementSet::All, portion);
        }
        e.blocks.assemble(&mut e.nodes, ElementSet::All);
        e.nodes.force.clone()
    };
    let before = forces(&mut e);
    let forced = before.iter().filter(|f| **f != [0.0; 4]).count();
    assert!(forced > 0 && forced < before.len(), "{forced} of {} nodes have forces", before.len());
    let mut ends = threads::connect(2);
    e.renew(&mut ends[1], CutTree::single()).expect("one worker");
    assert_eq!(forces(&mut e), before);
}

/// The last row has velocities and contact forces of the last step, which a redecomposition after
/// this step forgets.
#[test]
fn a_redecomposition_after_the_last_step_does_not_change_the_last_row() {
    let on = |workers: &str, force_every: &str| {
        let set = format!("parallel.force_every={force_every}");
        let transducer = "output.transducer=[{name=\"all\", parts=[1]}]";
        let words = ["run", "cases/tumble", "--no-report", "--workers", workers, "--set", &set];
        let more = ["--set=time.max_cycles=400", "--set=checkpoint.every=off", "--set", transducer];
        run(crumple_with(&[&words[..], &more].concat())).with_code(0)
    };
    let undisturbed = on("1", "0");
    for workers in ["1", "2"] {
        let redecomposed = on(workers, "1");
        let count = &redecomposed.summary()["redecompositions"];
        let of = |kind: &str| count[kind].as_u64().unwrap();
        assert_eq!(of("high") + of("low"), 400, "one after each step: {count}");
        assert_same_histories(&undisturbed.out(), &redecomposed.out());
    }
}

/// Histories of all kinds, of walls with and without a mass, with subcycles, friction, erosion,
/// loads and damping: the same bytes on any number of workers and threads.
#[test]
fn histories_have_the_same_bytes_on_any_number_of_workers() {
    let panel = "output.section=[{nodes=\"side\", parts=[1, 2]}]";
    let tumble = "output.transducer=[{name=\"all\", parts=[1]}]";
    let scenes: [(&str, &str, &[&str]); 7] = [
        ("jeep-frame", "300", &["gravity=[{acceleration=[0.0, 0.0, -0.01]}]"]),
        ("tumble", "900", &[tumble, "parallel.force_every=70"]),
        ("graded", "200", &["time.subcycles=4", "output.history_interval=0.01"]),
        ("panel", "150", &[panel, "time.damping=10.0"]),
        ("pipe-whip", "150", &[]),
        ("brick-wall", "20", &[]),
        ("can-crush", "100", &["elements.precision=single"]),
    ];
    for (scene, cycles, sets) in scenes {
        let on = |workers: &str, threads: &str| {
            let job = format!("cases/{scene}");
            let limit = format!("time.max_cycles={cycles}");
            let mut words = vec!["run", &job, "--no-report", "--workers", workers];
            words.extend(["--threads", threads, "--set", &limit, "--set=checkpoint.every=off"]);
            words.extend(sets.iter().flat_map(|set| ["--set", set]));
            run(crumple_with(&words)).with_code(0)
        };
        let one = on("1", "1");
        for (workers, threads) in [("2", "3"), ("3", "1")] {
            let other = on(workers, threads);
            println!("{scene}, {workers} workers of {threads} threads");
            assert_eq!(other.summary()["threads"].to_string(), threads, "{scene}");
            assert_same_histories(&one.out(), &other.out());
            assert_eq!(one.summary()["energy"], other.summary()["energy"], "{scene}");
            assert_eq!(one.summary()["momentum"], other.summary()["momentum"], "{scene}");
        }
    }
}
