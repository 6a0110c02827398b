//! Kernels that `kernels.rs` times. Two files measure more:
//!
//! - `instructions.rs`: one of them under an instruction counter
//! - `assembly.rs`: cost of ordered nodal sums

pub mod assembly;
pub mod instructions;

use crumple::input::job::read_text;
use crumple::run::embedded::run_alone;
use crumple_proto::boxes::Aabb;
use crumple_proto::transport::{Tag, Transport, threads};
use crumple_worker::contact::search::{SEARCHES, accepted};
use crumple_worker::coupling::ContactCoupling;
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::Portion;
use crumple_worker::math::row::xyz;
use crumple_worker::parallel::ghosts::Ghosts;
use crumple_worker::time::ElementSet;
use std::hint::black_box;
use std::ops::ControlFlow;

/// A piece of work that can be done again and again.
pub type Work = Box<dyn FnMut()>;

/// A kernel of the step.
pub struct Kernel {
    /// One word.
    pub name: &'static str,
    /// Objects that it processes, and their number.
    pub of: (&'static str, usize),
    /// Makes it ready.
    pub ready: fn() -> Work,
}

/// Every kernel.
pub const KERNELS: &[Kernel] = &[
    Kernel {
        name: "belytschko_tsay",
        of: ("shells", 7220),
        ready: || elements("tube-crush", PLAIN),
    },
    Kernel {
        name: "stabilised_quad",
        of: ("shells", 7220),
        ready: || elements("tube-crush", STABILISED),
    },
    Kernel {
        name: "fully_integrated_quad",
        of: ("shells", 7220),
        ready: || elements("tube-crush", INTEGRATED),
    },
    Kernel { name: "hexahedron", of: ("solids", 16_384), ready: || elements("bench/hex-bar", &[]) },
    Kernel { name: "search_cells", of: ("points", 7296), ready: || search(0) },
    Kernel { name: "search_boxes", of: ("points", 7296), ready: || search(1) },
    Kernel { name: "contact_pass", of: ("nodes without a pair", 7296), ready: contact },
    Kernel { name: "message", of: ("words", MESSAGE), ready: message },
];

const PLAIN: &[&str] = &["part.tube.element=belytschko_tsay"];
const STABILISED: &[&str] = &["part.tube.element=stabilised_quad"];
const INTEGRATED: &[&str] = &["part.tube.element=fully_integrated_quad"];
/// Words of a message: the corner forces of some 80 shared nodes.
pub const MESSAGE: usize = 1000;
/// Cycles before the first: some elements are strained and turn then.
const CYCLES: u64 = 20;

/// An engine some cycles into a job that is in the program.
fn engine(job: &str, sets: &[&str]) -> Engine {
    let text = crumple_cases::job(job).expect("the program has this job");
    let sets: Vec<String> = sets.iter().map(|&s| s.to_string()).collect();
    let model =
        read_text(job.into(), text.into(), &sets).unwrap_or_else(|report| panic!("{report}"));
    let enough = |e: &mut Engine| {
        if e.clock.cycle < CYCLES { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    run_alone(&model, enough).expect("one worker").engine
}

fn elements(job: &str, sets: &[&str]) -> Work {
    let mut e = engine(job, sets);
    e.blocks.compute_all();
    Box::new(move || {
        black_box(e.blocks.add_internal_forces(
            &mut e.nodes,
            e.clock.dt,
            ElementSet::All,
            Portion::Interior,
        ));
    })
}

fn search(method: usize) -> Work {
    let e = engine("tube-crush", &[]);
    let surface = &e.contact.as_ref().expect("it has contact").surface;
    let boxes: Vec<Aabb> = surface.segments.iter().map(|s| s.bounds(&e.nodes.x, 3.0)).collect();
    let points: Vec<[f64; 3]> =
        surface.slaves.iter().map(|&i| xyz(&e.nodes.x[i as usize])).collect();
    Box::new(move || {
        black_box(accepted(SEARCHES[method].find, &boxes, &points, |b, p| (b ^ p) % 2 == 0));
    })
}

fn contact() -> Work {
    let mut e = engine("tube-crush", &[]);
    let steps = e.clock.steps(e.loads.damp_at(e.clock.time));
    let mut ends = threads::connect(2);
    Box::new(move || {
        let contact = e.contact.as_mut().expect("it has contact");
        contact.refresh_candidates(
            &e.nodes,
            &e.constraints,
            (e.clock.time, steps.dt),
            [steps.dt; 2],
        );
        contact.find_pairs(&e.nodes, &e.constraints, e.clock.time, steps);
        let comm = &mut ends[1];
        e.pair_exchange
            .exchange_pairs(comm, &e.nodes, &Ghosts::default(), &mut contact.table)
            .expect("no rank is lost");
        let mut around = ContactCoupling {
            comm,
            constraints: &mut e.constraints,
            pair_exchange: &mut e.pair_exchange,
            replicated: &e.replicated_pairs,
        };
        contact.enforce(&mut e.nodes, &mut around, steps).expect("no rank is lost");
    })
}

/// Sends a message to another worker in the same thread, so that no rank waits.
fn message() -> Work {
    let mut ends = threads::connect(3);
    let (mut there, mut here) = (ends.remove(2), ends.remove(1));
    let message = vec![1u64; MESSAGE];
    let mut words = Vec::new();
    Box::new(move || {
        here.send(2, Tag::Corners, &message).expect("no rank is lost");
        there.recv(1, Tag::Corners, &mut words).expect("no rank is lost");
        black_box(&words);
    })
}
