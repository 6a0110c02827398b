//! Ties together with failure, prescribed motion and other constraints, on any number of workers.

use super::*;
use crumple_tests::run_side_by_side;

/// A plate of two elements, the brittle one under a patch that is tied to it. Under tension the
/// brittle element fails: the patch is released with its mass and velocity and continues alone,
/// on any number of workers.
#[test]
fn a_face_that_fails_lets_go() {
    let mut scene = steel(0.2);
    let place = |u: f64, v: f64| [10.0 * u, 10.0 * v, 0.0];
    let pulled = scene.grid(1, [1, 1], place).row(1);
    scene.part(1, "brittle", 1.0, "");
    let patch = plate(&mut scene, 3, [[2.0, 2.0], [8.0, 8.0]], 1.0, [2, 2]);
    scene.set_named("patch", patch.all());
    scene.set_named("pulled", &pulled);
    scene.add(
        "[[material]]\nname = \"brittle\"\nlaw = \"j2\"\ndensity = 7.85e-6\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         yield_stress = 0.2\nfailure_strain = 0.01\n\
         [[tie]]\nnodes = \"patch\"\nparts = [1]\noffset = true\n[contact]\n\
         [[initial_velocity]]\nvelocity = [0.0, 1.0, 0.0]\n\
         [[initial_velocity]]\nnodes = \"pulled\"\nvelocity = [100.0, 1.0, 0.0]",
    );
    let model = model(&scene).unwrap();
    assert_eq!(model.settings.ties.len(), 9);
    let mut watch = Watch::default();
    let (mut whole, mut left) = (Vec::new(), None);
    let end = run_alone(&model, |e: &Engine| {
        watch.record(e);
        whole.push((0..e.nodes.local_count).map(|i| e.nodes.mass[i]).sum::<f64>());
        if e.constraints.ties.is_empty() && left.is_none() {
            left = Some((
                e.clock.time,
                patch.all().iter().map(|&n| position(e, n)).collect::<Vec<_>>(),
            ));
        }
    });
    let (time, places) = left.expect("the tie is released");
    assert!(end.constraints.ties.is_empty() && time < 0.1, "{time}");
    let mass = whole[0];
    assert!(whole.iter().all(|m| (m - mass).abs() < 1e-14 * mass * 100.0), "masses are restored");
    assert!(watch.changed[0] < 1e-10 * mass * 10.0, "momentum: {:?}", watch.changed);
    // After release the patch continues as a whole with its own momentum.
    let mean =
        |x: &[[f64; 3]]| [0, 1].map(|c| x.iter().map(|p| p[c]).sum::<f64>() / x.len() as f64);
    let now: Vec<[f64; 3]> = patch.all().iter().map(|&n| position(&end, n)).collect();
    let went = [0, 1].map(|c| (mean(&now)[c] - mean(&places)[c]) / (end.clock.time - time));
    assert!(went[0] > 10.0 && went[0] < 90.0 && (went[1] - 1.0).abs() < 0.3, "{went:?}");
    let serial = run_side_by_side(&model, 1, 120, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (4, 7)] {
        let parallel = run_side_by_side(&model, workers, 120, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

/// A prescribed motion of a plate and of the nodes tied to it moves both in the same way, and
/// does the work of both masses once.
#[test]
fn prescribed_nodes_move_tied_slaves() {
    let mut scene = steel(1.0);
    let large = plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = plate(&mut scene, 2, [[13.0, 12.0], [27.0, 31.0]], 0.0, [3, 2]);
    scene.set_named("patch", patch.all());
    scene.set_named("both", &[large.all(), patch.all()].concat());
    scene.add(
        "[[tie]]\nnodes = \"patch\"\nparts = [1]\n[[curve]]\nname = \"ramp\"\n\
         points = [[0.0, 0.0], [1.0, 2.0]]\n\
         [[motion]]\nnodes = \"both\"\nvelocity = [1.0, 0.0, 0.0]\ncurve = \"ramp\"",
    );
    let model = model(&scene).unwrap();
    let end = run_alone(&model, |_| {});
    let speeds: Vec<f64> = end.nodes.v.iter().map(|v| v[0]).collect();
    // Round-off of positions over the length of a step.
    assert!(speeds.iter().all(|v| (v - speeds[0]).abs() < 1e-10), "{speeds:?}");
    let mass = RHO * (40.0 * 40.0 + 14.0 * 19.0);
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    let exact = 0.5 * mass * speeds[0].powi(2);
    // The velocities and the work are half a step apart.
    assert!(
        (energies.external / exact - 1.0).abs() < 0.01 && speeds[0] > 1.9,
        "{energies:?} {exact}"
    );
    assert!(energies.balance(0.0).abs() < 1e-9 * exact, "{}", energies.balance(0.0));
}

/// A fine patch is tied to a coarse plate, posts of beams are tied with their rotations between
/// it and a plate above, a rigid foot carries a plate's edge, and a block falls on the patch,
/// above a wall: the same bits on 1, 2 and 4 workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut scene = steel(1.0);
    plate(&mut scene, 1, [[0.0, 0.0], [80.0, 80.0]], 0.0, [8, 8]);
    let patch = plate(&mut scene, 2, [[13.0, 17.0], [53.0, 59.0]], 1.1, [7, 6]);
    plate(&mut scene, 3, [[0.0, 0.0], [80.0, 30.0]], 20.0, [6, 3]);
    let mut ends = Vec::new();
    for (x, y) in [(4.0, 5.0), (66.0, 12.0), (71.0, 24.0)] {
        let post = [0.0, 10.0, 20.0].map(|z| scene.node([x, y, z]));
        ends.extend([post[0], post[2]]);
        for pair in post.windows(2) {
            scene.beam(4, [pair[0], pair[1], 1]);
        }
    }
    scene.add(
        "[[part]]\nid = 4\nmaterial = \"steel\"\n[part.beam]\nsection = \"tube\"\nradius = 2.0",
    );
    let falling = block(&mut scene, 5, [[22.0, 27.0, 2.7], [41.0, 49.0, 12.0]], [3, 4, 2]);
    block(&mut scene, 6, [[80.0, 0.0, 15.0], [90.0, 30.0, 25.0]], [1, 2, 1]);
    let edge = plate(&mut scene, 7, [[90.0, 3.0], [110.0, 27.0]], 21.0, [3, 4]).row(0);
    scene.set_named("patch", patch.all());
    scene.set_named("ends", &ends);
    scene.set_named("edge", &edge);
    scene.set_named("block", falling.all());
    scene.add(
        "[[tie]]\nname = \"patch\"\nnodes = \"patch\"\nparts = [1]\noffset = true\n\
         [[tie]]\nname = \"posts\"\nnodes = \"ends\"\nparts = [1, 3]\nrotations = true\n\
         [[tie]]\nname = \"edge\"\nnodes = \"edge\"\nparts = [6]\n\
         [[rigid]]\nname = \"foot\"\nparts = [6]\n[contact]\nfriction = 0.2\n\
         [[wall]]\npoint = [0.0, 0.0, -1.0]\nnormal = [0.1, 0.0, 1.0]\n\
         [[initial_velocity]]\nvelocity = [0.0, 0.0, -8.0]\n\
         [[initial_velocity]]\nnodes = \"block\"\nvelocity = [3.0, 0.0, -30.0]",
    );
    let model = model(&scene).unwrap();
    assert_eq!(model.settings.ties.len(), 56 + 6);
    assert!(model.settings.ties.iter().filter(|t| t.rotations).count() == 6);
    assert_eq!(model.settings.rigid[0].nodes.len(), 12 + 5, "the edge belongs to the foot");
    let serial = run_side_by_side(&model, 1, 600, 0);
    assert!(serial.trouble.is_none(), "{:?} in cycle {}", serial.trouble, serial.pairs.len());
    assert!(serial.pairs.iter().any(|p| !p.is_empty()), "it touches");
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 600, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
