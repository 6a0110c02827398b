//! Cost of bits that do not depend on the number of workers: nodes sum element nodal forces in
//! ascending element id. It is compared with the same kernels whose elements add to their nodes in
//! the order of storage.
//!
//! The three are timed in turn in one loop, by CPU time, so that a machine that slows down slows
//! all of them.

use super::engine;
use crumple_proto::transport::thread_cpu;
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::Portion;
use crumple_worker::math::lanes::Lane;
use crumple_worker::time::ElementSet;
use std::hint::black_box;

/// Shells over a side of the tube: in the first case all is in the cache at once, as a batch of
/// elements is in larger ones.
const SIDES: [(&str, usize, usize); 2] = [("4", 320, 200), ("19", 7220, 10)];
/// Rounds, of which the median counts.
const ROUNDS: usize = 301;

/// An element's nodes and its first corner slot.
type Scatter = Vec<([u32; 4], usize)>;

/// Measures and prints a table; with `once` it only checks that the kernels run.
pub fn run(once: bool) {
    let rounds = if once { 1 } else { ROUNDS };
    println!(
        "| shells | kernels alone [ns a shell] | nodes gather, in order | elements add, \
         in no order | of the kernels and this |"
    );
    println!("|---:|---:|---:|---:|---:|");
    for (side, count, times) in SIDES {
        let set = format!("scene.elements={side}");
        let mut ordered = engine("tube-crush", &[&set]);
        let mut plain = engine("tube-crush", &[&set]);
        [&mut ordered, &mut plain].into_iter().for_each(|e| e.blocks.compute_all());
        assert_eq!(ordered.blocks.elements.len(), count);
        // All nodes wait, so that kernels are alone.
        plain.blocks.build_assembly(plain.nodes.local_count, &[], |_| true);
        let nodes =
            plain.blocks.elements.iter().map(|e| [e.nodes[0], e.nodes[1], e.nodes[2], e.nodes[3]]);
        let scatter: Scatter = nodes.zip(plain.blocks.first_slots()).collect();
        let mut spent = [const { Vec::new() }; 3];
        for _ in 0..rounds {
            spent[0].push(timed(times, || kernels(&mut plain)));
            spent[1].push(timed(times, || kernels(&mut ordered)));
            spent[2].push(timed(times, || {
                kernels(&mut plain);
                add(&mut plain, &scatter);
            }));
        }
        let [alone, gathered, scattered] =
            spent.map(|all| 1e9 * median(all) / (times * count) as f64);
        println!(
            "| {count} | {alone:.1} | +{:.1} | +{:.1} | {:+.1} % |",
            gathered - alone,
            scattered - alone,
            100.0 * (gathered / scattered - 1.0)
        );
    }
}

fn kernels(e: &mut Engine) {
    black_box(e.blocks.add_internal_forces(
        &mut e.nodes,
        e.clock.dt,
        ElementSet::All,
        Portion::Interior,
    ));
}

/// Adds element nodal forces to the nodes, which start from zero.
fn add(e: &mut Engine, elements: &Scatter) {
    let (nodes, blocks) = (&mut e.nodes, &e.blocks);
    nodes.force.fill([0.0; 4]);
    nodes.moment.fill([0.0; 4]);
    for (corners, slot) in elements {
        let slots = blocks.force[*slot..*slot + 4].iter().zip(&blocks.moment[*slot..*slot + 4]);
        for (&n, (force, moment)) in corners.iter().zip(slots) {
            let (f, m) = (&mut nodes.force[n as usize], &mut nodes.moment[n as usize]);
            *f = (Lane::new(*f) - Lane::new(*force)).to_array();
            *m = (Lane::new(*m) - Lane::new(*moment)).to_array();
        }
    }
    black_box(&nodes.force);
}

/// CPU time of doing it so many times [s].
fn timed(times: usize, mut work: impl FnMut()) -> f64 {
    let start = thread_cpu();
    (0..times).for_each(|_| work());
    (thread_cpu() - start).as_secs_f64()
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}
