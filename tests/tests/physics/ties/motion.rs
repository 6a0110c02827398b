//! Motion of tied bodies: shared displacements, waves, rotation, arms, chains, bending.

use super::*;

/// The nodes at the end of the second bar share the displacements of one node. The bar starts
/// with a velocity: the tied nodes move together, and momentum is conserved.
#[test]
fn nodes_share_displacements() {
    let (mut scene, second) = bars(0.02, 0.0);
    let [master, slaves @ ..] = &second.layer(0, 0)[..] else { panic!("the bar has an end") };
    scene.set_named("rest", slaves);
    scene.add(&format!("[[tie]]\nnodes = \"rest\"\nnode = {master}"));
    scene.start(second.all(), [1.0, 0.0, 0.0], [0.0; 3]);
    let mut watch = Watch::default();
    let end = run_alone(&model(&scene).unwrap(), |e: &Engine| watch.record(e));
    let velocity = |node: u32| end.nodes.v[local(&end, node)];
    assert_eq!(slaves.len(), 15);
    for &slave in slaves {
        assert_eq!(velocity(slave), velocity(*master), "{slave}");
    }
    let whole = RHO * SIDE * SIDE * LENGTH;
    assert!(watch.changed[0] < 1e-12 * whole, "round-off: {:?}", watch.changed);
    // A tie to a node with another velocity changes no momentum: it is that of the mesh.
    let came = watch.first.unwrap()[0][0];
    assert!((came - whole).abs() < 1e-12 * whole, "{came} {whole}");
}

/// The first bar hits the second one, which is at rest. A wave with half its velocity goes
/// through both, the momentum of the second bar grows by the stress `rho c v / 2` times the
/// area, and the front arrives at its middle with the velocity of waves. The tolerance of 1 %
/// covers oscillations behind the front in means over 30 cells; the front is two cells wide.
#[test]
fn a_wave_goes_through_a_tie() {
    let c = (E / RHO).sqrt();
    let rest = "[[initial_velocity]]\nvelocity = [1.0, 0.0, 0.0]\n[[initial_velocity]]\n\
                nodes = \"second\"\nvelocity = [0.0, 0.0, 0.0]\n";
    let half = 0.5 * LENGTH / c;
    let (mut scene, _) = bars(1.4 * half, 0.0);
    scene.add(&format!("{TIE}{rest}"));
    let tied = model(&scene).unwrap();
    assert_eq!(tied.settings.ties.len(), 16);
    let mut watch = Watch::default();
    let (mut arrival, mut at_half) = (None, None);
    run_alone(&tied, |e: &Engine| {
        watch.record(e);
        let middle = (0..e.nodes.local_count).find(|&i| e.nodes.x0[i][0] == 1.5 * LENGTH).unwrap();
        if e.nodes.v[middle][0] > 0.25 {
            arrival.get_or_insert(e.clock.time);
        }
        if e.clock.time >= half && at_half.is_none() {
            // The masters carry the mass of the tied end, which is that of half a cell.
            let tied = 0.5 * CELL * SIDE * SIDE * RHO * 0.5;
            let second = (0..e.nodes.local_count).filter(|&i| e.nodes.x0[i][0] > LENGTH + 0.1);
            let given: f64 = second.map(|i| e.nodes.mass[i] * e.nodes.v[i][0]).sum::<f64>() + tied;
            let near = |&i: &usize| (e.nodes.x0[i][0] - LENGTH).abs() < 0.4 * LENGTH;
            let near: Vec<f64> =
                (0..e.nodes.local_count).filter(near).map(|i| e.nodes.v[i][0]).collect();
            // Velocities are those in the middle of the last step.
            at_half = Some((given / (e.clock.time - 0.5 * e.clock.last_dt), near));
        }
    });
    let (force, near) = at_half.unwrap();
    let expected = 0.5 * RHO * c * SIDE * SIDE;
    assert!((force / expected - 1.0).abs() < 0.01, "{force} {expected}");
    let mean = near.iter().sum::<f64>() / near.len() as f64;
    assert!((mean - 0.5).abs() < 0.005, "{mean}");
    let arrival = arrival.unwrap();
    assert!((arrival - half).abs() < 2.0 * CELL / c, "{arrival} {half}");
    let whole = RHO * SIDE * SIDE * LENGTH;
    let changed = watch.changed[0];
    assert!(changed < 1e-12 * whole, "round-off of sums over 1000 nodes: {changed} of {whole}");
    // The same bars as one mesh: the step changes with the strain, which causes this error of
    // the balance.
    let mut scene = steel(1.4 * half);
    let along = (2.0 * LENGTH / CELL) as usize;
    let whole_bar = block(&mut scene, 1, [[0.0; 3], [2.0 * LENGTH, SIDE, SIDE]], [along, 2, 2]);
    let second: Vec<u32> =
        (along / 2 + 1..=along).flat_map(|step| whole_bar.layer(0, step)).collect();
    scene.set_named("second", &second);
    scene.add(rest);
    let mut one = Watch::default();
    run_alone(&model(&scene).unwrap(), |e: &Engine| one.record(e));
    let (unexplained, of_one) = (watch.unexplained, one.unexplained);
    assert!(unexplained < 2.0 * of_one && of_one < 1e-6, "{unexplained}, in one mesh {of_one}");
}

/// Tied bars turn in free flight. Momentum and angular momentum are conserved, the tie is
/// strained only by the centrifugal load, and tied nodes keep their positions on the faces.
#[test]
fn tied_bars_turn_without_strain() {
    let spin = 2.0;
    let (mut scene, _) = bars(0.4, 0.0);
    scene.add(&format!(
        "{TIE}[[initial_velocity]]\nvelocity = [1.0, 2.0, -3.0]\nspin = [0.1, 0.3, {spin:?}]\n\
         centre = [{LENGTH:?}, 2.0, 2.0]"
    ));
    let model = model(&scene).unwrap();
    let mut watch = Watch::default();
    let end = run_alone(&model, |e: &Engine| watch.record(e));
    let Watch { changed: worst, unexplained, .. } = watch;
    let whole = 2.0 * RHO * SIDE * SIDE * LENGTH;
    assert!(worst[0] < 1e-11 * whole && worst[1] < 1e-10 * whole * 100.0, "{worst:?} of {whole}");
    assert!(unexplained < 1e-6, "{unexplained}");
    let at = |id| position_of(&end, id);
    for tie in &model.settings.ties {
        let stand = tie
            .masters
            .iter()
            .fold([0.0; 3], |s, &(id, n)| std::array::from_fn(|c| s[c] + n * at(id)[c]));
        let off = (0..3).map(|c| (stand[c] - at(tie.node)[c]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12 * 1000.0, "round-off of the steps: {off}");
    }
}

/// A patch at the end of arms above a plate, in free flight: it turns about an axis of the plate
/// or is struck at one end. Momentum and angular momentum are conserved, arms keep their length,
/// and without the impact there is no strain.
#[test]
fn arms_turn_with_their_face() {
    for struck in [false, true] {
        let mut scene = steel(1.0);
        let large = plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
        let patch = plate(&mut scene, 2, [[8.0, 9.0], [31.0, 32.0]], 1.1, [4, 3]);
        scene.set_named("patch", patch.all());
        scene.add(
            "[[tie]]\nnodes = \"patch\"\nparts = [1]\noffset = true\n\
             [[initial_velocity]]\nvelocity = [1.0, 0.0, 2.0]\nspin = [0.8, -0.5, 0.2]\n\
             centre = [20.0, 20.0, 0.0]",
        );
        if struck {
            let far = [large.at(0, 0), large.at(1, 0)];
            scene.start(&far, [0.0, 3.0, 5.0], [0.0; 3]);
        }
        let model = model(&scene).unwrap();
        assert!(model.settings.ties.iter().all(|t| t.offset) && model.settings.ties.len() == 20);
        let mut watch = Watch::default();
        let end = run_alone(&model, |e: &Engine| watch.record(e));
        let Watch { changed: worst, unexplained, initial, .. } = watch;
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        // The arms turn exactly, but their moments are those of small steps: the error is the
        // square of rotations within a step.
        let (strained, left) = if struck { (0.5, 1e-3) } else { (1e-4, 1e-5) };
        assert!(
            energies.internal < strained * initial && unexplained < left,
            "{unexplained} of {energies:?}"
        );
        let at = |id| position_of(&end, id);
        for tie in &model.settings.ties {
            let foot = tie
                .masters
                .iter()
                .fold([0.0; 3], |s, &(id, n)| std::array::from_fn(|c| s[c] + n * at(id)[c]));
            let arm = (0..3).map(|c| (at(tie.node)[c] - foot[c]).powi(2)).sum::<f64>().sqrt();
            assert!((arm - 1.1).abs() < 1e-10, "{arm}: round-off of several thousand rotations");
        }
        assert!(worst[0] < 1e-14 && worst[1] < 1e-12, "round-off: {worst:?}");
    }
}

/// Chained ties: a strip on a strip on a strip, struck at one end, conserve their momentum and
/// move together. A chain at the end of arms is refused.
#[test]
fn ties_stand_on_ties_but_for_arms() {
    let chain = |offset: bool, shift: f64| {
        let mut scene = steel(0.5);
        plate(&mut scene, 1, [[0.0, 0.0], [40.0, 10.0]], 0.0, [4, 1]);
        let second = plate(&mut scene, 2, [[30.0, 1.0], [70.0, 9.0]], shift, [4, 1]);
        let third = plate(&mut scene, 3, [[31.0, 2.0], [39.0, 8.0]], 2.0 * shift, [2, 1]);
        scene.set_named("second", &[second.row(0), second.row(1)].concat());
        scene.set_named("third", third.all());
        for (nodes, part) in [("second", 1), ("third", 2)] {
            scene
                .add(&format!("[[tie]]\nnodes = \"{nodes}\"\nparts = [{part}]\noffset = {offset}"));
        }
        scene.start(third.all(), [3.0, 1.0, 0.0], [0.0; 3]);
        (third, model(&scene))
    };
    let (_, refused) = chain(true, 1.0);
    let refused = refused.err().expect("offsets in a chain are refused");
    assert!(
        refused.contains("which is itself tied") && refused.contains("no offsets in a chain"),
        "{refused}"
    );
    let (third, model) = chain(false, 0.0);
    let model = model.unwrap();
    assert!(
        model.warnings.iter().any(|w| w.message.contains("have other initial velocities")),
        "{:?}",
        model.warnings
    );
    // The third strip lies between nodes of the second one, all of them tied: its masters are
    // nodes of the first one.
    let own = |n: u64| third.all().contains(&(n as u32));
    let of_third: Vec<_> = model.settings.ties.iter().filter(|t| own(t.node.0)).collect();
    assert!(
        of_third.len() == 6
            && of_third.iter().all(|t| t.masters.iter().all(|c| c.0.0 <= 10) && t.faces.len() > 1)
    );
    let mut watch = Watch::default();
    run_alone(&model, |e: &Engine| watch.record(e));
    let mass = RHO * 8.0 * 6.0;
    let came = watch.first.unwrap()[0];
    for (came, velocity) in came.into_iter().zip([3.0, 1.0, 0.0]) {
        assert!((came - mass * velocity).abs() < 1e-12 * mass, "{came}");
    }
    assert!(
        watch.changed[0] < 1e-11 * mass && watch.unexplained < 1e-3,
        "{:?} {}",
        watch.changed,
        watch.unexplained
    );
}

/// A cantilever of two strips of shells; the edge of the second strip is tied across the last
/// row of cells of the first one. With tied rotations its tip deflects by P L^3 / 3 E I as that
/// of one strip, without them the tie is a hinge. 2 %: the tie bends the row's cells bilinearly.
#[test]
fn a_tied_edge_bends_as_one_strip() {
    let (length, width) = (100.0f64, 10.0);
    let bending = E * width / 12.0;
    let force = 3.0 * bending / length.powi(3);
    let w = 1.875_104_07f64.powi(2) * (bending / (RHO * width * length.powi(4))).sqrt();
    let down = |rotations: bool| {
        let mut scene = steel(16.0 / w);
        let first = plate(&mut scene, 1, [[0.0, 0.0], [50.0, width]], 0.0, [10, 2]);
        let second = plate(&mut scene, 2, [[47.0, 0.0], [length, width]], 0.0, [10, 3]);
        scene.set_named("edge", &second.row(0));
        scene.set_named("tip", &second.row(10));
        scene.time(&format!("damping = {:?}", 2.0 * w));
        scene.fix(&first.row(0), "x y z rx ry rz");
        scene.add(&format!(
            "[[tie]]\nnodes = \"edge\"\nparts = [1]\nrotations = {rotations}\n\
             [[load]]\nnodes = \"tip\"\nforce = [0.0, 0.0, {:?}]",
            -force
        ));
        let end = run_alone(&model(&scene).unwrap(), |_| {});
        -position(&end, second.at(10, 0))[2]
    };
    let (bent, hung) = (down(true), down(false));
    assert!((bent - 1.0).abs() < 0.02, "{bent}");
    assert!(hung > 3.0, "{hung}");
}
