//! Ties that fail, and the bonds that they leave.

use super::*;
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::run_side_by_side;

/// Rate at which the acceleration of the plate rises [mm/ms^3], and thickness of its patch [mm].
const JERK: f64 = 4.0e4;
const THICKNESS: f64 = 1.0;

/// Returns a plate whose acceleration along a direction rises as `JERK t`, with a patch on it that
/// is tied with a failure.
fn accelerated(direction: [f64; 3], failure: &str) -> Scene {
    let mut scene = steel(0.2);
    let large = plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = plate(&mut scene, 2, [[13.0, 12.0], [27.0, 31.0]], 0.1, [3, 2]);
    scene.set_named("large", large.all());
    scene.set_named("patch", patch.all());
    let points: Vec<String> = (0..=4000)
        .map(|i| 0.2 * f64::from(i) / 4000.0)
        .map(|t| format!("[{t:?}, {:?}]", JERK * t.powi(2) / 2.0))
        .collect();
    let [x, y, z] = direction;
    scene.add(&format!(
        "[[tie]]\nnodes = \"patch\"\nparts = [1]\nfailure = {{ {failure} }}\n\
         [[curve]]\nname = \"ramp\"\npoints = [{}]\n\
         [[motion]]\nnodes = \"large\"\nvelocity = [{x:?}, {y:?}, {z:?}]\ncurve = \"ramp\"",
        points.join(", ")
    ));
    scene
}

/// Returns the time of the forces that break the first tie of a scene, and the time one step
/// before; none if none breaks.
fn first_break(scene: &Scene) -> Option<[f64; 2]> {
    let mut found = None;
    let end = run_alone(&model(scene).unwrap(), |e: &Engine| {
        let ties = &e.constraints.ties;
        // In some cycles ties are released at once.
        if found.is_none() && (ties.has_broken() || ties.is_empty()) {
            let time = e.clock.time - e.clock.last_dt;
            found = Some([time, time - e.clock.last_dt]);
        }
    });
    assert_eq!(end.constraints.ties.is_empty(), found.is_some(), "all break or none");
    found
}

/// On a patch in uniform acceleration a act the forces `m a` of its nodes, as stress `rho h a`. So
/// ties break when `(rho h a cos/N)^n + (rho h a sin/S)^m = 1`, in tension, in shear, and with
/// both; under compression they never do.
#[test]
fn ties_break_at_the_stress_of_the_limit() {
    let limits = [0.03, 0.02];
    let failure = |exponents: &str| {
        format!("limits = \"stress\", normal = 0.03, shear = 0.02, exponents = {exponents}")
    };
    let stress = |time: f64| RHO * THICKNESS * JERK * time;
    // The patch lags behind a plate that rises: it is pulled against its motion.
    for (angle, exponents) in
        [(0.0, [2.0, 2.0]), (90.0, [2.0, 2.0]), (40.0, [2.0, 2.0]), (40.0, [1.0, 3.0])]
    {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let scene = accelerated([sin, 0.0, -cos], &failure(&format!("{exponents:?}")));
        let [time, before] = first_break(&scene).expect("it breaks");
        let [n, m] = exponents;
        let load =
            |t: f64| (stress(t) * cos / limits[0]).powf(n) + (stress(t) * sin / limits[1]).powf(m);
        // The acceleration is that of a polyline of the velocity, exact to 0.1 %.
        let loads = [load(time * 1.001), load(before * 0.999)];
        assert!(loads[0] >= 1.0 && loads[1] < 1.0, "{angle}, {exponents:?}: {loads:?}");
    }
    assert_eq!(first_break(&accelerated([0.0, 0.0, 1.0], &failure("[2.0, 2.0]"))), None);
}

/// Forces on nodes: the node with the largest mass, in the middle of the patch, breaks first, when
/// its mass times the acceleration is the limit.
#[test]
fn ties_break_at_the_force_of_the_limit() {
    let [time, before] =
        first_break(&accelerated([0.0, 1.0, 0.0], "shear = 0.4")).expect("it breaks");
    let inner = RHO * THICKNESS * (14.0 / 3.0) * (19.0 / 2.0);
    let exact = 0.4 / (inner * JERK);
    assert!(time * 1.001 >= exact && before * 0.999 < exact, "{before} {exact} {time}");
}

/// Gravity carries a part of the acceleration of the slave, and the tie has to overcome its
/// damping: the force is `m (a - g)`, and `m (a + c v)` with the damping c. A field of gravity is
/// not known to ties if it is of parts only.
#[test]
fn gravity_and_damping_count_in_the_force() {
    let inner = RHO * THICKNESS * (14.0 / 3.0) * (19.0 / 2.0);
    let limit = 0.4 / inner;
    let (gravity, damping) = (0.3 * limit, 20.0);
    let mut falling = accelerated([0.0, 1.0, 0.0], "shear = 0.4");
    falling.add(&format!("[[gravity]]\nacceleration = [0.0, {gravity:?}, 0.0]"));
    let mut damped = accelerated([0.0, 1.0, 0.0], "shear = 0.4");
    damped.time(&format!("damping = {damping:?}"));
    // JERK (t + c t^2/2) = limit
    let root = (1.0 + 2.0 * damping * limit / JERK).sqrt();
    for (scene, exact) in [(&falling, (limit + gravity) / JERK), (&damped, (root - 1.0) / damping)]
    {
        let [time, before] = first_break(scene).expect("it breaks");
        assert!(time * 1.001 >= exact && before * 0.999 < exact, "{before} {exact} {time}");
    }
    for part in [1, 2] {
        let mut of_part = accelerated([0.0, 1.0, 0.0], "shear = 0.4");
        let gravity = "[[gravity]]\nacceleration = [0.0, 1.0, 0.0]\nparts";
        of_part.add(&format!("{gravity} = [{part}]"));
        let text = model(&of_part).err().expect("errors");
        assert!(text.contains(&format!("part {part}, which has a gravity of its own")), "{text}");
    }
}

/// Limit of the stress [GPa] and opening [mm] of the bonds.
const STRESS: f64 = 0.005;
const OPENING: f64 = 0.02;

/// Returns two blocks, the second tied to the first with damage, that fly apart.
fn torn(end_time: f64) -> Scene {
    let mut scene = steel(end_time);
    let one = block(&mut scene, 1, [[0.0; 3], [4.0, 4.0, 4.0]], [2, 2, 2]);
    let other = block(&mut scene, 2, [[4.0, 0.0, 0.0], [8.0, 4.0, 4.0]], [3, 3, 3]);
    scene.set_named("one", one.all());
    scene.set_named("other", other.all());
    scene.set_named("face", &other.layer(0, 0));
    scene.add(&format!(
        "[contact]\nfriction = 0.3\n\
         [[tie]]\nnodes = \"face\"\nparts = [1]\nfailure = {{ limits = \"stress\", \
         normal = {STRESS:?}, shear = {STRESS:?}, opening = {OPENING:?} }}\n\
         [[initial_velocity]]\nnodes = \"one\"\nvelocity = [-2.0, 0.0, 0.1]\n\
         [[initial_velocity]]\nnodes = \"other\"\nvelocity = [2.0, 0.2, 0.0]"
    ));
    scene
}

/// Two blocks tear their bonds: these take the work under their curve, stress times area times
/// opening over two, and momentum is kept to round-off. No energy is gained; the releases lose
/// that of the motion of masters against each other.
#[test]
fn bonds_take_the_work_under_their_curve() {
    let model = model(&torn(0.06)).unwrap();
    let (mut watch, mut works, mut gained, mut had) = (Watch::default(), Vec::new(), 0.0f64, false);
    let (mut was_free, mut last) = (false, 0.0);
    let end = run_alone(&model, |e: &Engine| {
        watch.record(e);
        works.push(-e.ledger.links.total());
        // Right after the release the velocities belong to the masses before.
        let free = e.constraints.ties.is_empty();
        if free == was_free {
            let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            last = energies.balance(watch.initial) / watch.initial;
            gained = gained.max(last);
        }
        was_free = free;
        had |= !e.constraints.bonds.is_empty();
    });
    let gone = [end.constraints.ties.is_empty(), end.constraints.bonds.is_empty()];
    assert!(had && gone == [true; 2], "{gone:?}");
    let exact = 0.5 * STRESS * 16.0 * OPENING;
    let work = works.last().copied().unwrap();
    // The nodes do not part exactly along the forces of the failure, which are oblique.
    assert!((work / exact - 1.0).abs() < 1e-2, "{work} {exact}");
    let mass = RHO * 128.0;
    assert!(watch.changed[0] < 1e-12 * mass * 4.0, "momentum: {:?}", watch.changed);
    // The elements alone, before the failure, keep the balance to 2e-7.
    // Faces of 2 mm lose the energy of the motion of their nodes against each other.
    assert!(gained < 1e-6 && last > -0.01, "{gained} gained, {last} at the end");
}

/// Plates slide off each other, tied half a thickness apart: bonds with arms act on nodes that
/// rotate, and keep momentum and angular momentum to round-off. A release does not keep the
/// latter: until then the masters had the masses of the slaves, half a thickness away.
#[test]
fn bonds_with_arms_keep_both_momenta() {
    let mut scene = steel(0.06);
    let large = plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = plate(&mut scene, 2, [[13.0, 12.0], [27.0, 31.0]], 0.5, [3, 2]);
    scene.set_named("large", large.all());
    scene.set_named("patch", patch.all());
    scene.add(&format!(
        "[[tie]]\nnodes = \"patch\"\nparts = [1]\noffset = true\nfailure = {{ limits = \"stress\", \
         shear = {STRESS:?}, opening = {OPENING:?} }}\n\
         [[initial_velocity]]\nnodes = \"large\"\nvelocity = [-2.0, 0.0, 0.0]\n\
         [[initial_velocity]]\nnodes = \"patch\"\nvelocity = [2.0, 1.0, 0.0]"
    ));
    let (mut watch, mut held) = (Watch::default(), 0);
    let (mut between, mut ties) = (Watch::default(), 0);
    let mut angular = 0.0f64;
    let end = run_alone(&model(&scene).unwrap(), |e: &Engine| {
        watch.record(e);
        if e.constraints.ties.count() != ties {
            (between, ties) = (Watch::default(), e.constraints.ties.count());
        }
        between.record(e);
        angular = angular.max(between.changed[1]);
        held += usize::from(!e.constraints.bonds.is_empty());
    });
    assert!(held > 5 && end.constraints.ties.is_empty(), "bonds in {held} steps");
    let mass = RHO * (40.0 * 40.0 + 14.0 * 19.0);
    let linear = watch.changed[0];
    assert!(linear < 1e-12 * mass * 4.0, "{linear}");
    assert!(angular < 1e-12 * mass * 4.0 * 40.0, "{angular}");
}

/// A patch is torn from a plate whose nodes all have the same velocity: the energy of the run has
/// the work of the bonds, to round-off.
#[test]
fn the_energy_has_the_work_of_bonds() {
    let (normal, opening) = (0.03, 0.5);
    let failure = format!("limits = \"stress\", normal = {normal:?}, opening = {opening:?}");
    let model = model(&accelerated([0.0, 0.0, -1.0], &failure)).unwrap();
    let end = run_alone(&model, |_| {});
    assert!(end.constraints.ties.is_empty() && end.constraints.bonds.is_empty());
    let exact = 0.5 * normal * 14.0 * 19.0 * opening;
    let work = -end.ledger.links.total();
    // A step opens by 5 % of the opening: the last one errs by a quarter of its square.
    assert!((work / exact - 1.0).abs() < 2e-3, "{work} {exact}");
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    assert!(
        energies.balance(0.0).abs() < 1e-9 * energies.external,
        "{} of {}",
        energies.balance(0.0),
        energies.external
    );
}

/// With bonds, contact and friction the bits are the same on any number of workers, with forced
/// renewals of the boxes, and after a restart while bonds hold.
#[test]
fn bits_of_ties_that_fail_do_not_depend_on_workers() {
    let model = model(&torn(0.06)).unwrap();
    let mut held = Vec::new();
    run_alone(&model, |e: &Engine| {
        if !e.constraints.bonds.is_empty() {
            held.push(e.clock.cycle);
        }
    });
    let (middle, cycles) = (held[held.len() / 2], held.last().unwrap() + 40);
    let serial = run_side_by_side(&model, 1, cycles, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (3, 0), (2, 5), (3, 7)] {
        let parallel = run_side_by_side(&model, workers, cycles, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
    for (at, workers) in [(middle, [1, 2]), (middle, [3, 1]), (held[0] - 3, [2, 3])] {
        let digest = run_interrupted(&model, Plan { at, cycles, workers });
        assert_eq!(serial.digest(), digest, "interrupted at {at}, {workers:?} workers");
    }
}

/// After the failure without damage a block falls back onto the face, which holds it: contact.
#[test]
fn released_nodes_are_in_contact() {
    let mut scene = steel(0.4);
    let base = block(&mut scene, 1, [[0.0; 3], [6.0, 6.0, 2.0]], [2, 2, 1]);
    let top = block(&mut scene, 2, [[1.0, 1.0, 2.0], [4.0, 4.0, 5.0]], [2, 2, 2]);
    scene.set_named("base", base.all());
    scene.set_named("top", top.all());
    scene.set_named("foot", &top.layer(2, 0));
    scene.add(
        "[contact]\n[[fix]]\nnodes = \"base\"\ndofs = [\"x\", \"y\", \"z\"]\n\
         [[tie]]\nnodes = \"foot\"\nparts = [1]\nfailure = { normal = 0.02 }\n\
         [[gravity]]\nacceleration = [0.0, 0.0, -400.0]\n\
         [[initial_velocity]]\nnodes = \"top\"\nvelocity = [0.0, 0.0, 8.0]",
    );
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let end = run_alone(&model(&scene).unwrap(), |e: &Engine| {
        for &node in &top.layer(2, 0) {
            let z = position(e, node)[2] - 2.0;
            (least, most) = (least.min(z), most.max(z));
        }
    });
    assert!(end.constraints.ties.is_empty());
    // It rises, falls back, and sinks in by less than it falls in two steps.
    assert!(most > 0.01 && least > -1e-3, "{least} {most}");
}

/// Wrong limits, ties without a face, faces of rigid bodies, chains and nodes without an area are
/// refused by name.
#[test]
fn wrong_failures_are_refused() {
    let report = |failure: &str, more: &str| {
        let (mut scene, _) = bars(0.01, 0.0);
        scene.add(&format!("{TIE}failure = {{ {failure} }}\n{more}"));
        model(&scene).err().expect("errors")
    };
    for (failure, words) in [
        ("", "has no limit"),
        ("normal = -1.0", "normal of a tie is -1"),
        ("shear = inf", "`shear` has to be a finite number"),
        ("normal = 1.0, exponents = [0.0, 2.0]", "exponents of a tie are 0, 2"),
        ("normal = 1.0, opening = -0.1", "opening of a tie is -0.1"),
    ] {
        let text = report(failure, "");
        assert!(text.contains(words), "{failure}: {text}");
    }
    let rigid = report("normal = 1.0", "[[rigid]]\nname = \"body\"\nparts = [1]");
    assert!(rigid.contains("are on faces of rigid bodies"), "{rigid}");
    let (mut scene, second) = bars(0.01, 0.0);
    scene.set_named("line", &second.layer(0, 0)[..3]);
    scene.add(
        "[[tie]]\nnodes = \"line\"\nparts = [1]\nfailure = { limits = \"stress\", normal = 1.0 }",
    );
    let bare = model(&scene).err().expect("errors");
    assert!(bare.contains("3 nodes have no area"), "{bare}");
    // A plate in the plane of the other one: its tension has no direction, its shear has.
    let mut scene = steel(0.01);
    plate(&mut scene, 1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = plate(&mut scene, 2, [[13.0, 12.0], [27.0, 31.0]], 0.0, [3, 2]);
    scene.set_named("patch", patch.all());
    let tied = |limits: &str| {
        let mut scene = scene.clone();
        let tie = "[[tie]]\nnodes = \"patch\"\nparts = [1]\nfailure =";
        scene.add(&format!("{tie} {{ {limits} }}"));
        model(&scene).err()
    };
    let flat = tied("normal = 1.0").expect("errors");
    assert!(flat.contains("tension and compression are the same"), "{flat}");
    assert_eq!(tied("shear = 1.0"), None);
    let moved =
        report("normal = 1.0", "[[motion]]\nnodes = \"second\"\nvelocity = [1.0, 0.0, 0.0]");
    assert!(moved.contains("have a prescribed motion that they would lose"), "{moved}");
    let (mut scene, second) = bars(0.01, 0.0);
    scene.set_named("third", &second.layer(0, 1)[..2]);
    scene.add(&format!(
        "{TIE}failure = {{ normal = 1.0 }}\n\
         [[tie]]\nnodes = \"third\"\nparts = [2]\ntolerance = 2.0"
    ));
    let chain = model(&scene).err().expect("errors");
    assert!(chain.contains("in a chain of ties of which one can fail"), "{chain}");
}
