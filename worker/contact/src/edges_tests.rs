//! Tests of edges in contact: which folds are used, and the history of their pairs.

use super::*;
use crate::search::SEARCHES;
use crate::surface::Segment;
use crate::testing::Free;
use crumple_fem::testing::nodes_at;
use crumple_proto::ids::SegmentId;

/// Half thickness of the roof and of the plate.
const HALF: f64 = 0.2;

/// A ridge along y with flanks at these angles [degree] from x towards z, and the rim of a plate
/// across it at this height.
fn ridge_and_rim(angles: [f64; 2], height: f64) -> (Nodes, Surface) {
    let mut points = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for angle in angles {
        let (s, c) = f64::to_radians(angle).sin_cos();
        points.extend([[c, 1.0, s], [c, 0.0, s]]);
    }
    points.extend([[-0.5, 0.5], [0.5, 0.5], [0.5, 2.5], [-0.5, 2.5]].map(|[x, y]| [x, y, height]));
    let segment = |(nodes, id): ([u32; 4], u64)| Segment {
        id: SegmentId(8 * id),
        nodes,
        behind: [NOT_LOCAL; 4],
        half_thickness: HALF,
        offset: 0.0,
        scale: HALF,
        part: 0,
        own: true,
        searched: true,
    };
    let segments =
        [[0, 1, 2, 3], [0, 1, 4, 5], [6, 7, 8, 9]].into_iter().zip(1..).map(segment).collect();
    (nodes_at(&points), Surface { segments, ..Surface::default() })
}

fn search(edges: &mut Edges, surface: &Surface, nodes: &Nodes) {
    edges.search(surface, nodes, &Free, SEARCHES[0].find, 0.1);
    edges.pick(nodes, surface, (0.05, 0.0));
}

fn pairs(edges: &mut Edges, surface: &Surface, nodes: &Nodes) -> Vec<PairKey> {
    let mut pairs = Vec::new();
    edges.find_pairs(nodes, (surface, &[true]), &[], (1e-3, 0.0), &mut pairs);
    pairs.iter().map(|p| p.key).collect()
}

/// Returns the key of the pair of ridge and rim.
fn ridge_on_rim() -> PairKey {
    PairKey::of_edges([NodeId(1), NodeId(2)], [NodeId(7), NodeId(8)])
}

/// A fold of 7.5 degrees is too flat for contact, but close to the limit (6.4 of 9.2). The search
/// includes it in advance, so that it touches the rim without another search when it becomes sharp.
/// A fold of 5.5 degrees needs another search.
#[test]
fn folds_that_nearly_stand_out_are_searched_for_beforehand() {
    let flanks = |fold: f64| [-0.5 * fold, 180.0 + 0.5 * fold];
    for (fold, beforehand) in [(7.5, true), (5.5, false)] {
        let (mut nodes, surface) = ridge_and_rim(flanks(fold), 2.0 * HALF);
        let mut edges = Edges::new(&surface, &nodes, |_| Vec::new(), false);
        search(&mut edges, &surface, &nodes);
        assert!(
            !edges.is_stale() && pairs(&mut edges, &surface, &nodes).is_empty(),
            "the fold is too flat"
        );
        let (folded, _) = ridge_and_rim(flanks(10.0), 2.0 * HALF);
        nodes.x.clone_from(&folded.x);
        nodes.seen.clone_from(&folded.x);
        edges.update_folds(&surface, &nodes);
        assert_eq!(edges.is_stale(), !beforehand, "from {fold} degrees to 10");
        let met = pairs(&mut edges, &surface, &nodes);
        assert_eq!(
            met,
            if beforehand { vec![ridge_on_rim()] } else { vec![] },
            "from {fold} degrees to 10"
        );
        search(&mut edges, &surface, &nodes);
        assert_eq!(pairs(&mut edges, &surface, &nodes), [ridge_on_rim()], "after another search");
        assert!(!edges.is_stale());
    }
}

/// An edge above a flank that rises from the ridge. Nodes must keep it off that flank. The pair
/// with the ridge is found as soon as the distance is the contact thickness; an edge that is
/// already deeper is not found.
#[test]
fn an_edge_across_a_fold_is_paired_when_it_touches() {
    let met_at = |height: f64| {
        let (nodes, surface) = ridge_and_rim([15.0, 240.0], height * 2.0 * HALF);
        let mut edges = Edges::new(&surface, &nodes, |_| Vec::new(), false);
        search(&mut edges, &surface, &nodes);
        pairs(&mut edges, &surface, &nodes).contains(&ridge_on_rim())
    };
    assert!(!met_at(1.03), "not yet");
    assert!(met_at(1.01) && met_at(0.99));
    assert!(!met_at(0.9), "its side is not known");
}

/// An edge that follows another one, as slave or as target, gets its history except the slip.
#[test]
fn what_an_edge_had_goes_to_the_next_one() {
    let name =
        |slave: [u64; 2], other: [u64; 2]| PairKey::of_edges(slave.map(NodeId), other.map(NodeId));
    let pair = Pair {
        normal: V3::z(),
        tolerated_gap: -0.25,
        force: V3::new(0.5, 0.0, 2.0),
        slip: V3::x(),
        ..Pair::new(name([5, 6], [8, 9]), SegmentId(1), [0; 5])
    };
    // With a lower key, and across: another contact of the same edge.
    let other = Pair { key: name([4, 6], [8, 9]), normal: V3::x(), ..pair };
    let mut edges = Edges::default();
    edges.store_history([other, pair].iter());
    let recall = |slave, other, normal: &V3| edges.recall_history(&name(slave, other), normal);
    assert_eq!(recall([5, 6], [8, 9], &V3::z()), Some(pair.to_history()), "its own");
    let next = PairHistory { slip: V3::zeros(), ..pair.to_history() };
    assert_eq!(recall([6, 7], [8, 9], &V3::z()), Some(next), "along the slave's row");
    assert_eq!(
        recall([5, 6], [9, 12], &-V3::z()),
        Some(next),
        "along the other row, in either direction"
    );
    let turned = PairHistory { normal: -next.normal, force: -next.force, ..next };
    assert_eq!(recall([4, 8], [6, 7], &V3::z()), Some(turned), "slave and other edge exchanged");
    assert_eq!(recall([6, 7], [8, 9], &V3::y()), None, "another contact, with another normal");
    assert_eq!(recall([5, 6], [10, 11], &V3::z()), None, "an edge elsewhere");
}

/// A pair that is lost with a deep penetration returns on its side with its tolerated gap, if this
/// is soon enough. A pair that only touched is new.
#[test]
fn what_is_lost_while_it_is_deep_is_remembered_for_some_steps() {
    let name = PairKey::of_edges([NodeId(5), NodeId(6)], [NodeId(8), NodeId(9)]);
    let deep = Pair {
        normal: V3::z(),
        tolerated_gap: -0.25,
        penetration: 0.5,
        contact_thickness: 1.0,
        force: V3::z(),
        ..Pair::new(name, SegmentId(1), [0; 5])
    };
    let after = |pair: Pair, steps: usize| {
        let mut edges = Edges::default();
        edges.store_history([pair].iter());
        (0..steps).for_each(|_| edges.store_history([].iter()));
        edges.recall_history(&name, &V3::z())
    };
    let back = after(deep, 3).unwrap();
    assert_eq!((back.age, back.normal, back.depth, back.tolerated), (3, V3::z(), 0.5, -0.25));
    assert_eq!(back.force, V3::zeros(), "a lost pair has no force");
    assert!(after(deep, 50).is_some() && after(deep, 51).is_none());
    assert!(after(Pair { penetration: 0.005, ..deep }, 1).is_none());
    assert!(back.is_fresh(0.1, 1.0) && !back.is_fresh(0.2, 1.0), "three steps of 0.2 are too far");
}
