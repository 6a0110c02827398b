//! Single kernels: the elements of a part, a global search, a contact pass, a message between
//! workers.
//!
//! `cargo bench -p crumple-master` times all by criterion; `cargo test --benches -p crumple-master`
//! runs each once. With `-- assembly` it measures the cost of ordered nodal sums; `count NAME
//! TIMES` is for
//! `deploy/instructions.sh`.

mod work;

use criterion::Criterion;
use crumple_proto::transport::{Tag, Transport, threads};
use work::{KERNELS, MESSAGE, assembly, instructions};

/// Times a message from one thread to another and back.
fn round_trip(c: &mut Criterion) {
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
        c.bench_function(&format!("{MESSAGE} words to another thread and back"), |b| {
            b.iter(|| {
                here.send(2, Tag::Corners, &message).expect("no rank is lost");
                here.recv(2, Tag::Corners, &mut words).expect("no rank is lost");
            });
        });
        here.send(2, Tag::Corners, &[]).expect("no rank is lost");
    });
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    // As criterion has it: `cargo bench` says so, `cargo test --benches` says nothing.
    let has = |flag: &str| words.iter().any(|word| word == flag);
    let once = has("--test") || !has("--bench");
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["count"] => std::process::exit(instructions::run(None, 0)),
        ["count", name, times] => {
            std::process::exit(instructions::run(Some(name), times.parse().unwrap_or(1)))
        }
        ["assembly", ..] => return assembly::run(false),
        _ => {}
    }
    let mut c = Criterion::default().configure_from_args();
    for kernel in KERNELS {
        let mut work = (kernel.ready)();
        c.bench_function(&format!("{}, {} {}", kernel.name, kernel.of.1, kernel.of.0), |b| {
            b.iter(&mut work)
        });
    }
    round_trip(&mut c);
    c.final_summary();
    if once {
        assembly::run(true);
    }
}
