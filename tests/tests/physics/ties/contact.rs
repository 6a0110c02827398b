//! Contact and walls at tied nodes, and skins.

use super::*;

/// A block hits the patch of the same plate: the momentum that the block loses the plate gains,
/// and no energy is created.
#[test]
fn contact_on_tied_nodes_keeps_momentum_and_makes_no_energy() {
    let mut scene = steel(0.6);
    plate(&mut scene, 1, [[0.0, 0.0], [80.0, 80.0]], 0.0, [8, 8]);
    let patch = plate(&mut scene, 2, [[13.0, 17.0], [53.0, 59.0]], 0.0, [7, 6]);
    let block = block(&mut scene, 5, [[22.0, 27.0, 1.6], [41.0, 49.0, 12.0]], [3, 4, 2]);
    scene.set_named("patch", patch.all());
    scene.start(block.all(), [3.0, 0.0, -30.0], [0.0; 3]);
    scene.add("[[tie]]\nnodes = \"patch\"\nparts = [1]");
    // The kinematic law needs the masses of the nodes themselves, but tied nodes have passed
    // theirs to the masters.
    for law in ["lagrange", "kinematic"] {
        let mut scene = scene.clone();
        scene.add(&format!("[contact]\nlaw = \"{law}\""));
        let model = model(&scene).unwrap();
        let (mut watch, mut least, mut deepest) = (Watch::default(), 0.0f64, 0.0f64);
        let end = run_alone(&model, |e: &Engine| {
            watch.record(e);
            deepest = deepest.max(e.contact.as_ref().unwrap().penetration);
            least =
                least.max(e.ledger.energies(&e.nodes, &e.blocks).values().contact / watch.initial);
        });
        let Watch { changed: [worst, _], unexplained: most, initial, .. } = watch;
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        assert!(
            energies.contact < -0.01 * initial,
            "{law}: there is an impact: {energies:?} of \
            {initial}"
        );
        assert!(least < 1e-3, "{law}: contact adds energy: {least}");
        assert!(worst < 1e-11, "{law}: {worst}");
        assert!(most < 0.01, "{law}: {most}");
        // The measured value is 0.016 of the thickness for both laws; if tied nodes had no mass,
        // it would be 0.89 for the kinematic law.
        assert!(deepest < 0.05, "{law}: {deepest}");
    }
}

/// A block falls on a patch that is tied to a plate, which lies on a rigid wall with a mass. The
/// wall receives the impulse in the same step, and the total momentum is conserved.
#[test]
fn a_wall_with_a_mass_receives_impacts_on_tied_nodes() {
    let mut scene = steel(0.3);
    let plate_nodes = plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = plate(&mut scene, 2, [[9.0, 8.0], [33.0, 31.0]], 0.0, [6, 6]);
    let block = block(&mut scene, 3, [[15.0, 14.0, 1.2], [26.0, 25.0, 9.0]], [3, 3, 2]);
    scene.set_named("patch", patch.all());
    scene.start(block.all(), [0.0, 0.0, -20.0], [0.0; 3]);
    scene.add(
        "[[tie]]\nnodes = \"patch\"\nparts = [1]\n[contact]\n\
         [[wall]]\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\nmass = 0.02\n\
         except = \"patch\"",
    );
    let model = model(&scene).unwrap();
    let (mut deepest, mut first, mut worst) = (0.0f64, None, 0.0f64);
    let end = run_alone(&model, |e: &Engine| {
        let wall = &e.constraints.walls.each()[0];
        let floor = wall.displacement()[2];
        let plate = plate_nodes.all().iter().map(|&n| position(e, n)[2]);
        let plate = plate.fold(f64::INFINITY, f64::min);
        deepest = deepest.max(floor - plate);
        let all = momentum(&e.nodes).0[2] + e.constraints.walls.carried(true).1[2];
        worst = worst.max((all - *first.get_or_insert(all)).abs());
    });
    let wall = end.constraints.walls.carried(true).1[2];
    let came = -20.0 * RHO * 11.0 * 11.0 * 7.8;
    assert!(wall < 0.2 * came, "the wall takes a large part of the impulse: {wall} of {came}");
    // A delay of one step in the force on the wall would give a penetration by the displacement
    // of that step.
    assert!(deepest < 1e-9, "{deepest}");
    assert!(worst < 1e-10 * came.abs(), "{worst} of {came}");
}

/// A block falls on one large skin between the corners of a frame, which stops it; without the
/// skin it falls through. The skin has mass, does not limit the step and carries no load: a
/// moving corner does not act on the others.
#[test]
fn a_skin_touches_and_bears_nothing() {
    let run = |skin: bool| {
        let mut scene = steel(3.0);
        let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]]
            .map(|[x, y]| scene.node([x, y, 0.0]));
        let block = block(&mut scene, 1, [[15.0, 15.0, 1.0], [25.0, 25.0, 11.0]], [2, 2, 2]);
        scene.start(block.all(), [0.0, 0.0, -5.0], [0.0; 3]);
        scene.add("[contact]");
        if skin {
            scene.shell(2, &corners);
            scene.part(2, "steel", 1.0, "skin = true");
            scene.start(&corners[..1], [1.0, 0.0, 0.0], [0.0; 3]);
        }
        let model = model(&scene).unwrap();
        let end = run_alone(&model, |_| {});
        (model.first_dt().0, end, block.at([0; 3]), corners)
    };
    let (with, without) = (run(true), run(false));
    assert_eq!(with.0, without.0, "the step");
    let low = |run: &(f64, Engine, u32, [u32; 4])| position(&run.1, run.2)[2];
    assert!(
        (low(&without) - (1.0 - 15.0)).abs() < 1e-9,
        "the block falls freely: {}",
        low(&without)
    );
    let [a, b, ..] = with.3.map(|n| position(&with.1, n));
    let skin = b[2];
    assert!(skin < -0.5, "the block moves the skin: {skin}");
    assert!(low(&with) > skin - 0.1, "the block does not pass through: {} {skin}", low(&with));
    // An elastic skin would pull both to the same velocity. The block pushes along a normal that
    // tilts with the corners, by 1e-6.
    assert!(
        (a[0] - 3.0).abs() < 1e-4 && (b[0] - 40.0).abs() < 1e-4,
        "corners do not affect each other: {a:?} {b:?}"
    );
}

/// A coarse patch in the plane of a fine plate that carries it: contact finds no penetration of
/// either, from either side, and has no effect.
#[test]
fn contact_ignores_tied_nodes() {
    let mut scene = steel(0.2);
    plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [16, 16]);
    let patch = plate(&mut scene, 2, [[9.0, 8.0], [33.0, 31.0]], 0.0, [2, 2]);
    scene.set_named("patch", patch.all());
    scene.add(
        "[[tie]]\nnodes = \"patch\"\nparts = [1]\n[contact]\n[[initial_velocity]]\n\
         velocity = [1.0, 0.0, 5.0]",
    );
    let model = model(&scene).unwrap();
    assert!(
        !model.warnings.iter().any(|w| w.message.contains("start inside")),
        "{:?}",
        model.warnings
    );
    let end = run_alone(&model, |_| {});
    let off = end
        .nodes
        .v
        .iter()
        .flat_map(|v| [v[0] - 1.0, v[1], v[2] - 5.0])
        .fold(0.0, |m: f64, d| m.max(d.abs()));
    assert!(off < 1e-11, "round-off: {off}");
}
