//! Nodes that follow the mean motion of others: momentum, angular momentum and energy.

use super::*;
use crumple_tests::run_side_by_side;

/// A block of solids that starts with a velocity and a spin, one corner of which follows the mean
/// motion of the four nodes at the end of a second block at rest, at a distance from it.
fn scene(end_time: f64) -> (Scene, u32, Vec<u32>) {
    let mut scene = steel(end_time);
    let first = block(&mut scene, 1, [[0.0; 3], [8.0, 4.0, 4.0]], [4, 1, 1]);
    let second = block(&mut scene, 2, [[9.0, 2.5, 1.5], [13.0, 5.5, 4.5]], [2, 1, 1]);
    let (masters, slave) = (first.layer(0, 4), second.layer(0, 0)[0]);
    scene.set_named("masters", &masters);
    scene.set_named("slave", &[slave]);
    scene.start(second.all(), [0.2, -0.1, 0.3], [0.0, 0.02, 0.0]);
    (scene, slave, masters)
}

const MEAN: &str = "[[tie]]\nname = \"mean\"\nnodes = \"slave\"\nmean_of = \"masters\"\n\
                    weights = [1.0, 2.0, 3.0, 4.0]\n";

/// Two blocks of which one pulls the other by a mean motion keep momentum to round-off and energy;
/// the node moves with the masters that it has at first.
#[test]
fn a_mean_motion_keeps_momentum_and_energy() {
    let (mut scene, slave, _) = scene(0.4);
    scene.add(MEAN);
    let model = model(&scene).unwrap();
    let tie = &model.settings.ties[0];
    assert!(tie.mean && tie.masters.len() == 4);
    assert!((tie.masters[1].1 - 0.2).abs() < 1e-15, "weights in the order of ids");
    let mut watch = Watch::default();
    let mut angular: Vec<[f64; 3]> = Vec::new();
    let (mut off, mut swing) = (0.0f64, 0.0f64);
    run_alone(&model, |e: &Engine| {
        watch.record(e);
        angular.push(momentum(&e.nodes).1);
        let foot = tie.masters.iter().fold([0.0; 3], |sum, (id, share)| {
            let x = position_of(e, *id);
            [0, 1, 2].map(|c| sum[c] + share * x[c])
        });
        let x = position(e, slave);
        let arm = (0..3).map(|c| (x[c] - foot[c]).powi(2)).sum::<f64>().sqrt();
        off = off.max(arm);
        swing = swing.max((x[0] - 9.0).abs());
    });
    let mass = RHO * (8.0 * 16.0 + 4.0 * 9.0);
    let [p, l] = watch.changed;
    assert!(p < 1e-12 * mass, "round-off: {p:e}");
    assert!(watch.unexplained < 2e-3, "{:e}", watch.unexplained);
    assert!(off > 0.5 && swing > 1e-3, "{off} {swing}");
    // The mass of the node is that of the masters, where its force acts.
    let size = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let largest = angular.iter().map(|v| size(*v)).fold(0.0, f64::max);
    assert!(l < 1e-12 * largest, "round-off: {l:e} of {largest:e}");
}

/// No bit depends on the workers.
#[test]
fn a_mean_motion_is_the_same_on_any_workers() {
    let (mut scene, ..) = scene(0.1);
    scene.add(MEAN);
    let model = model(&scene).unwrap();
    let one = run_side_by_side(&model, 1, 200, 0).digest();
    for workers in [2, 3, 4] {
        assert_eq!(run_side_by_side(&model, workers, 200, 0).digest(), one, "{workers}");
    }
}

/// Masters on a line, wrong weights and a surface are refused.
#[test]
fn mean_motions_that_cannot_be_are_refused() {
    let refused = |keys: &str, count: usize| {
        let (mut scene, _, masters) = scene(0.1);
        scene.set_named("few", &masters[..count]);
        scene.add(&format!("[[tie]]\nnodes = \"slave\"\nmean_of = \"few\"\n{keys}\n"));
        model(&scene).err().unwrap_or_else(|| panic!("it passes: {keys}"))
    };
    assert!(refused("", 2).contains("on one line"));
    assert!(refused("weights = [1.0]", 4).contains("1 weights for 4 masters"));
    assert!(refused("weights = [1.0, 0.0, 1.0]", 3).contains("a weight is 0"));
    assert!(refused("parts = [1]", 4).contains("also `parts`"));
}
