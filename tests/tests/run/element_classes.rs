//! Classes of elements by the boxes of the workers (Wang et al. 2007, sec. 2.1): ghosts are exactly
//! the interface elements of other workers that reach into the external box, and no worker
//! needs an interior element of another one.

use crumple::input::job::Model;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::ElemId;
use crumple_tests::brittle::{block, rod_on_plate};
use crumple_tests::{Trace, case, read, watch_side_by_side};
use crumple_worker::contact::surface::{ContactParts, segments_of};
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::{Class, Portion};
use crumple_worker::math::row::xyz;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

/// Partition of one worker after a renewal or after elements have failed.
struct Partition {
    worker: u32,
    cycle: u64,
    /// Updates after failures so far, and elements that have failed.
    erosions: u64,
    failed: usize,
    /// Class, and boxes around the contact faces, of each own element.
    elements: BTreeMap<ElemId, (Class, Vec<Aabb>)>,
    /// Nodes of own elements, by element.
    nodes: BTreeMap<ElemId, Vec<u64>>,
    ghosts: BTreeSet<ElemId>,
    external: Aabb,
    /// Half thickness and scale of the surface at nodes: those of own segments, and those that the
    /// worker holds for its local nodes.
    own_widths: BTreeMap<u64, [f64; 2]>,
    held_widths: BTreeMap<u64, [f64; 2]>,
    /// True without a second decomposition: with one, thickness includes that of ghosts.
    with_boxes: bool,
}

fn larger(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

fn partition_of(e: &Engine) -> Partition {
    let parts = ContactParts::from_settings(&e.settings);
    // Ghosts are selected at the positions of the last renewal. Without contact, none is kept.
    let x = match e.contact {
        Some(_) => e.motion.reference(),
        None => &e.nodes.x,
    };
    let (mut elements, mut nodes) = (BTreeMap::new(), BTreeMap::new());
    let mut own_widths = BTreeMap::new();
    for b in &e.blocks.blocks {
        for (i, element) in e.blocks.elements[b.first..b.first + b.count].iter().enumerate() {
            // Storage follows the classes, and so does the order of computation.
            assert_eq!(element.class == Class::Interface, i < b.interface, "place in the block");
            let early = b.portion_of(i) != Portion::Interior;
            assert!(early || element.class == Class::Interior, "an interface element comes late");
            assert!(!element.shared || b.portion_of(i) == Portion::Shared, "others wait for it");
            let around = Aabb::around(element.nodes.map(|n| xyz(&x[n as usize])));
            let inside = e.boxes.internal.contains_box(&around);
            // With a second decomposition of contact, the boxes are not those of the elements.
            if e.halo.regions.is_none() {
                assert_eq!(element.class == Class::Interior, inside, "{}", element.record.id);
            }
            let segments = match e.settings.contact {
                Some(_) => segments_of(element, &e.nodes, &parts),
                None => Vec::new(),
            };
            for s in &segments {
                for &n in &s.nodes {
                    let width =
                        own_widths.entry(e.nodes.id[n as usize].label()).or_insert([0.0; 2]);
                    *width = larger(*width, [s.half_thickness, s.scale]);
                }
            }
            let faces = segments.iter().map(|s| s.bounds(x, 0.0)).collect();
            elements.insert(element.record.id, (element.class, faces));
            let corners = element.nodes[..element.record.shape.corners()].iter();
            nodes.insert(
                element.record.id,
                corners.map(|&n| e.nodes.id[n as usize].label()).collect(),
            );
        }
    }
    let held_widths = e.contact.iter().flat_map(|c| {
        let widths = c.surface.node_half.iter().zip(&c.surface.node_scale).map(|(&h, &s)| [h, s]);
        e.nodes.id[..e.nodes.local_count].iter().map(|id| id.label()).zip(widths)
    });
    let ghosts: BTreeSet<ElemId> =
        e.contact.iter().flat_map(|c| c.surface.ghost_elements()).collect();
    let of = |class| elements.values().filter(|v| v.0 == class).count() as u64;
    let c = e.classes;
    assert_eq!([c.interior, c.interface], [of(Class::Interior), of(Class::Interface)]);
    assert_eq!(c.exterior, ghosts.len() as u64);
    Partition {
        worker: e.nodes.me,
        cycle: e.clock.cycle,
        erosions: e.erosions,
        failed: e.blocks.elements.iter().filter(|e| e.record.failed).count(),
        elements,
        nodes,
        ghosts,
        external: e.boxes.external,
        own_widths,
        held_widths: held_widths.collect(),
        with_boxes: e.halo.regions.is_none(),
    }
}

/// Runs a scene and returns its partitions, by cycle.
fn watch(
    name: &str,
    sets: &[&str],
    workers: usize,
    run: [u64; 2],
) -> (Trace, BTreeMap<u64, Vec<Partition>>) {
    watch_model(&read(&case(name), sets), workers, run)
}

/// Runs a model and returns its partitions, by cycle.
fn watch_model(
    model: &Model,
    workers: usize,
    run: [u64; 2],
) -> (Trace, BTreeMap<u64, Vec<Partition>>) {
    let seen = Mutex::new(Vec::new());
    let look = |e: &Engine| seen.lock().expect("no test fails here").push(partition_of(e));
    let trace = watch_side_by_side(model, workers, run, &look);
    let mut by_cycle: BTreeMap<u64, Vec<Partition>> = BTreeMap::new();
    for p in seen.into_inner().expect("no test failed") {
        by_cycle.entry(p.cycle).or_default().push(p);
    }
    (trace, by_cycle)
}

/// Checks ghosts against the classes and external boxes of all workers. Returns the numbers of
/// ghosts, of interior and of interface elements, summed over all renewals.
fn check(partitions: &BTreeMap<u64, Vec<Partition>>, workers: usize) -> [usize; 3] {
    let mut sums = [0; 3];
    for (cycle, all) in partitions {
        assert_eq!(all.len(), workers, "cycle {cycle}");
        for p in all {
            let (mut wanted, mut not_interface) = (BTreeSet::new(), 0);
            for other in all.iter().filter(|o| o.worker != p.worker) {
                for (&id, (class, faces)) in &other.elements {
                    let reaches =
                        !p.external.is_empty() && faces.iter().any(|f| f.intersects(&p.external));
                    if reaches {
                        wanted.insert(id);
                        not_interface += usize::from(*class != Class::Interface);
                    }
                }
            }
            assert_eq!(not_interface, 0, "cycle {cycle}: an interior element is needed");
            assert_eq!(p.ghosts, wanted, "cycle {cycle}, worker {}", p.worker);
            let interior = p.elements.values().filter(|e| e.0 == Class::Interior).count();
            let counts = [p.ghosts.len(), interior, p.elements.len() - interior];
            sums.iter_mut().zip(counts).for_each(|(s, c)| *s += c);
        }
        // All workers that have a node know its thickness in the surface of the whole model.
        let mut widths: BTreeMap<u64, [f64; 2]> = BTreeMap::new();
        for (&node, &width) in all.iter().flat_map(|p| &p.own_widths) {
            let largest = widths.entry(node).or_insert(width);
            *largest = larger(*largest, width);
        }
        for p in all.iter().filter(|p| p.with_boxes) {
            for (node, held) in &p.held_widths {
                let largest = widths.get(node).copied().unwrap_or_default();
                assert_eq!(*held, largest, "cycle {cycle}, worker {}, node {node}", p.worker);
            }
        }
        // Elements at shared nodes are interface elements.
        let mut holders: BTreeMap<u64, BTreeSet<u32>> = BTreeMap::new();
        for p in all {
            p.nodes.values().flatten().for_each(|&n| {
                holders.entry(n).or_default().insert(p.worker);
            });
        }
        for p in all {
            for (id, nodes) in &p.nodes {
                let shared = nodes.iter().any(|n| holders[n].len() > 1);
                assert!(!shared || p.elements[id].0 == Class::Interface, "cycle {cycle}: {id}");
            }
        }
    }
    sums
}

/// Four tubes and three plates that fly at each other, tumbling; with renewals when the margin is
/// used up, and with forced ones in other boxes.
#[test]
fn ghosts_are_the_interface_elements_in_the_external_box() {
    for (workers, force_every) in [(2, 0), (4, 0), (3, 40), (7, 90)] {
        let (trace, partitions) = watch("tumble", &[], workers, [2500, force_every]);
        assert!(trace.renewals > 3, "{workers} workers: {} renewals", trace.renewals);
        let [ghosts, interior, interface] = check(&partitions, workers);
        assert!(ghosts > 500 && interior > 500, "{workers}: {ghosts}, {interior}, {interface}");
    }
}

/// With a second decomposition of contact, the external box is that around the entities for which a
/// worker searches.
#[test]
fn ghosts_of_a_second_decomposition_are_interface_elements() {
    let rcb = ["parallel.contact=\"rcb\""];
    for (workers, force_every) in [(2, 0), (4, 60)] {
        let (_, partitions) = watch("tumble", &rcb, workers, [1500, force_every]);
        let [ghosts, interior, interface] = check(&partitions, workers);
        assert!(ghosts > 500 && interior > 500, "{workers}: {ghosts}, {interior}, {interface}");
    }
    let (_, partitions) = watch("can-crush", &rcb, 4, [120, 30]);
    let [ghosts, interior, _] = check(&partitions, 4);
    assert!(partitions.len() == 5 && ghosts > 100 && interior > 100, "{ghosts}, {interior}");
}

/// Solids, of which only free faces are copied.
#[test]
fn ghosts_of_solids_are_interface_elements_too() {
    let (_, partitions) = watch("can-crush", &[], 4, [120, 30]);
    let [ghosts, interior, _] = check(&partitions, 4);
    assert!(partitions.len() == 5 && ghosts > 100 && interior > 100, "{ghosts}, {interior}");
}

/// Elements that fail leave the ghosts, and solids behind them join them, although no worker
/// renews its members.
#[test]
fn ghosts_follow_elements_that_fail() {
    for workers in [2, 3, 5, 8] {
        let (trace, partitions) = watch_model(&rod_on_plate(4), workers, [400, 0]);
        let [ghosts, ..] = check(&partitions, workers);
        let all: Vec<&Vec<Partition>> = partitions.values().collect();
        let failed: usize = all[all.len() - 1].iter().map(|p| p.failed).sum();
        assert!(ghosts > 20 && failed > 3, "{workers} workers: {ghosts}, {failed} failed");
        let ids = |all: &[Partition]| -> BTreeSet<ElemId> {
            all.iter().flat_map(|p| p.ghosts.clone()).collect()
        };
        let updates = all.windows(2).filter(|w| w[1][0].erosions > w[0][0].erosions);
        let changes: Vec<_> = updates.map(|w| (ids(w[0]), ids(w[1]))).collect();
        assert!(all.len() as u64 > trace.renewals + 3, "updates are no renewals");
        let leave = changes.iter().any(|(before, after)| !before.is_subset(after));
        let join = changes.iter().any(|(before, after)| !after.is_subset(before));
        assert!(leave, "{workers} workers: failed elements are no ghosts");
        assert!(join, "{workers} workers: solids behind them become ghosts");
    }
    // Many failures in a thin wall, with renewals between them.
    let sets = ["material.mild steel.failure_strain=0.02"];
    let (trace, partitions) = watch("can-crush", &sets, 4, [400, 150]);
    check(&partitions, 4);
    let updates = partitions.last_key_value().map_or(0, |(_, all)| all[0].erosions);
    assert!(updates > 5 && trace.renewals > 1, "{updates} updates, {} renewals", trace.renewals);
}

/// A worker inside of a block has no surface, but gets ghosts if solids of the block can fail: its
/// solids can come to the surface before its members are renewed.
#[test]
fn a_worker_inside_of_a_block_that_can_fail_has_an_external_box() {
    for (failure, inside) in [("", 8), ("failure_strain = 0.1", 0)] {
        let seen = Mutex::new(Vec::new());
        let look = |e: &Engine| seen.lock().expect("no test fails here").push(partition_of(e));
        // 2 x 2 x 2 cubes for each of 4 x 4 x 4 workers.
        watch_side_by_side(&block(8, failure), 64, [1, 0], &look);
        let all = seen.into_inner().expect("no test failed");
        assert!(all.iter().all(|p| p.elements.len() == 8));
        let empty = all.iter().filter(|p| p.external.is_empty()).count();
        assert_eq!(empty, inside, "{failure}: workers without free faces need no ghosts");
    }
}

/// Without contact nothing is copied, and the buffer holds the elements at shared nodes.
#[test]
fn classes_are_exact_without_contact() {
    for name in ["plate", "beam"] {
        let (_, partitions) = watch(name, &[], 3, [20, 10]);
        let [ghosts, interior, interface] = check(&partitions, 3);
        assert!(ghosts == 0 && interior > 0 && interface > 0, "{name}: {interior}, {interface}");
    }
}
