//! Single kernels: the elements of a part, a global search, a contact pass, a message between workers.
//!
//! `cargo bench -p crumple`; `cargo test --benches -p crumple` runs each once.

use criterion::Criterion;
use crumple::embedded::run_alone;
use crumple::job::read_text;
use crumple_proto::boxes::Aabb;
use crumple_proto::transport::{Tag, Transport, threads};
use crumple_worker::contact::search::SEARCHES;
use crumple_worker::engine::Engine;
use crumple_worker::halo::Halo;
use crumple_worker::nodes::xyz;
use crumple_worker::ties::Joined;
use std::hint::black_box;
use std::ops::ControlFlow;

/// Words of a message: the corner forces of some 80 shared nodes.
const MESSAGE: usize = 1000;

/// An engine at the start of a job that is in the program.
fn engine(job: &str) -> Engine {
    let text = crumple_cases::job(job).expect("the program has this job");
    let model = read_text(job.into(), text.into(), &[]).unwrap_or_else(|report| panic!("{report}"));
    run_alone(&model, |_| ControlFlow::Break(())).expect("one worker").engine
}

fn elements(c: &mut Criterion) {
    for (name, job) in [("7220 shells", "tube-crush"), ("16384 solids", "bench/hex-bar")] {
        let mut e = engine(job);
        let dt = e.clock.dt;
        c.bench_function(name, |b| b.iter(|| black_box(e.blocks.add_internal_forces(&mut e.nodes, dt, false))));
    }
}

fn search(c: &mut Criterion) {
    let e = engine("tube-crush");
    let surface = &e.contact.as_ref().expect("it has contact").surface;
    let boxes: Vec<Aabb> = surface.segments.iter().map(|s| s.bounds(&e.nodes.x, 3.0)).collect();
    let points: Vec<[f64; 3]> = surface.slaves.iter().map(|&i| xyz(&e.nodes.x[i as usize])).collect();
    for method in SEARCHES {
        let name = format!("search by {}, 7220 boxes, 7296 points", method.name);
        c.bench_function(&name, |b| b.iter(|| black_box((method.find)(&boxes, &points))));
    }
}

fn contact(c: &mut Criterion) {
    let mut e = engine("tube-crush");
    let steps = e.clock.steps(e.loads.damping);
    let contact = e.contact.as_mut().expect("it has contact");
    let mut ends = threads::connect(2);
    contact.refresh_candidates(&e.nodes, Joined { bodies: &e.bodies, ties: &e.ties }, steps.dt);
    c.bench_function("contact pass, 7296 nodes, no pair", |b| {
        b.iter(|| {
            contact.refresh_candidates(&e.nodes, Joined { bodies: &e.bodies, ties: &e.ties }, steps.dt);
            contact.find_pairs(&e.nodes, steps);
            contact.share_pairs(&mut ends[1], &e.nodes, &Halo::default()).expect("nobody is lost");
            contact.enforce(&mut ends[1], &mut e.nodes, &e.walls, &mut e.bodies, steps).expect("nobody is lost");
        });
    });
}

fn halo(c: &mut Criterion) {
    let mut ends = threads::connect(3);
    let (mut there, mut here) = (ends.remove(2), ends.remove(1));
    let message = vec![1u64; MESSAGE];
    std::thread::scope(|scope| {
        // Sends back what comes, until an empty message.
        scope.spawn(move || {
            let mut words = Vec::new();
            while there.recv(1, Tag::Corners, &mut words).is_ok() && !words.is_empty() {
                if there.send(1, Tag::Corners, &words).is_err() {
                    break;
                }
            }
        });
        let mut words = Vec::new();
        c.bench_function("1000 words to another worker and back", |b| {
            b.iter(|| {
                here.send(2, Tag::Corners, &message).expect("nobody is lost");
                here.recv(2, Tag::Corners, &mut words).expect("nobody is lost");
            });
        });
        here.send(2, Tag::Corners, &[]).expect("nobody is lost");
    });
}

fn main() {
    let mut c = Criterion::default().configure_from_args();
    [elements, search, contact, halo].into_iter().for_each(|bench| bench(&mut c));
    c.final_summary();
}
