//! Contact searches and contact laws selected in a job, on seven bodies in collision.

use crumple_tests::program::{crumple_with, root, run};
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::{STEEL, Scene};

/// The search keeps its candidates as long as no node has moved far. It takes the motion of a step
/// from the range of displacements by velocities, also of the nodes of rigid bodies.
#[test]
fn the_range_of_displacements_contains_the_motion_of_each_node() {
    /// Differences of places near 100 mm have a round-off of 1e-14 mm.
    const ROUND_OFF: f64 = 1e-13;
    for scene in [root().join("tests/decks/scenes/bodies.toml"), case("tumble")] {
        let mut before = Vec::new();
        let mut largest = 0.0f64;
        run_alone(&read(&scene, &["time.max_cycles=300"]), |e| {
            let now = e.nodes.x[..e.nodes.local_count].to_vec();
            let [low, high] = e.nodes.displacements.bounds();
            for (was, is) in before.iter().zip(&now) {
                for (c, (from, to)) in std::iter::zip(was, is).take(3).enumerate() {
                    let by: f64 = to - from;
                    let [low, high] = [low[c] - ROUND_OFF, high[c] + ROUND_OFF];
                    assert!(low <= by && by <= high, "{by} is not in {low} .. {high}");
                    largest = largest.max(by.abs());
                }
            }
            before = now;
        });
        assert!(largest > 1e-4, "nodes move: {largest}");
    }
}

/// Both global searches find the same candidates, point in box, so the results are the same.
#[test]
fn both_searches_give_the_same_bits() {
    for workers in [1, 3] {
        let [cells, boxes] = ["cells", "boxes"].map(|s| {
            run_side_by_side(
                &read(&case("tumble"), &[&format!("contact.search={s}")]),
                workers,
                u64::MAX,
                0,
            )
        });
        assert_eq!(cells.digest(), boxes.digest(), "{workers} workers");
        assert!(cells.pairs == boxes.pairs && cells.pairs.iter().any(|p| !p.is_empty()));
    }
}

/// Two plates with meshes that do not match are pressed together, and come to rest. Contact creates
/// no energy: its work is minus that of the pressure, which closes the gap.
#[test]
fn pressed_plates_with_other_meshes_come_to_rest() {
    const SIDE: f64 = 0.1;
    const THICKNESS: f64 = 2e-3;
    for n in [[5, 6], [9, 10]] {
        let mut scene = Scene::new(4e-3);
        let grids = [(1, n[0], 0.0), (2, n[1], THICKNESS + 1e-6)]
            .map(|(part, n, z)| scene.grid(part, [n, n], |x, y| [SIDE * x, SIDE * y, z]));
        scene.elastic("steel", STEEL);
        scene.ramp(0.3e-3);
        for (part, pressure) in [(1, -1e6), (2, 1e6)] {
            scene.part(part, "steel", THICKNESS, "");
            scene.add(&format!(
                "[[pressure]]\nparts = [{part}]\npressure = {pressure:?}\ncurve = \"ramp\""
            ));
        }
        grids.iter().for_each(|grid| scene.fix(grid.all(), "x y rz"));
        scene.time("damping = 2e3");
        scene.add("[contact]\nlaw = \"lagrange\"");
        let mut work = Vec::new();
        let end = run_alone(&model_of(&scene.text("plates"), &[]), |e| {
            if e.clock.time > 1e-3 {
                work.push(e.energies(false).values().contact);
            }
        });
        let [first, last] = [work[0], work[work.len() - 1]];
        assert!(first < 0.0 && (last / first - 1.0).abs() < 1e-3, "{n:?}: {first} to {last}");
        let kinetic = end.energies(false).values().kinetic;
        assert!(kinetic < 1e-3 * first.abs(), "{n:?}: {kinetic}");
    }
}

/// Every law in every form gives the same bits on any number of workers, also with repartitions.
#[test]
fn every_law_gives_the_same_bits_on_any_number_of_workers() {
    let forms: [&[&str]; 13] = [
        &["contact.iteration=gauss_seidel"],
        &["contact.iteration=split"],
        &["contact.iteration=split", "contact.weighting=mass", "contact.friction=0.2"],
        &["contact.impact=moving_surface", "contact.choice=node_normal"],
        &["contact.law=kinematic"],
        &["contact.law=kinematic", "contact.weighting=mass", "contact.partition=0.3"],
        &["contact.law=penalty", "contact.penalty_form=stiffness"],
        &["contact.law=penalty", "contact.penalty_form=stiffness", "contact.penalty_scale=10"],
        &["contact.law=mortar", "contact.friction=0.2"],
        &["contact.friction=0.3", "contact.friction_limit=0.01"],
        &["contact.friction=0.3", "contact.friction_limit=0.01", "parallel.contact=\"rcb\""],
        &["contact.interface=[{parts=[1, 5], law=\"kinematic\"}]", "contact.friction=0.2"],
        &["contact.law=mortar", "contact.penalty_form=stiffness"],
    ];
    // Contact begins before cycle 200; until cycle 450 there are some 2000 pairs.
    let cycles = 450;
    for sets in forms {
        let model = read(&case("tumble"), sets);
        let serial = run_side_by_side(&model, 1, cycles, 0);
        assert!(
            serial.pairs.iter().map(Vec::len).sum::<usize>() > 1000,
            "{sets:?}: there is contact"
        );
        for (workers, force_every) in [(2, 0), (5, 7)] {
            let parallel = run_side_by_side(&model, workers, cycles, force_every);
            assert_eq!(serial.digest(), parallel.digest(), "{sets:?}: {workers} workers");
            assert!(serial.pairs == parallel.pairs, "{sets:?}: {workers} workers");
        }
    }
}

/// The contact detail of PRONTO3D gives the same bits on any number of workers, also between
/// solids. It changes the motion of the brick wall.
#[test]
fn options_of_the_contact_detail_give_the_same_bits_on_any_number_of_workers() {
    let options = [
        "contact.impact=moving_surface",
        "contact.choice=node_normal",
        "contact.push_back=last_face",
    ];
    let (cycles, by_default) = (60, read(&case("brick-wall"), &[]));
    let model = read(&case("brick-wall"), &options);
    let serial = run_side_by_side(&model, 1, cycles, 0);
    assert!(serial.pairs.iter().map(Vec::len).sum::<usize>() > 1000, "there is contact");
    assert_ne!(serial.digest(), run_side_by_side(&by_default, 1, cycles, 0).digest());
    for (workers, force_every) in [(2, 0), (3, 25), (4, 0)] {
        let parallel = run_side_by_side(&model, workers, cycles, force_every);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers");
        assert!(serial.pairs == parallel.pairs, "{workers} workers");
    }
}

/// A block of solids slides over facets. Segments in contact belong to other workers, and change
/// workers.
#[test]
fn segments_on_segments_give_the_same_bits_on_any_number_of_workers() {
    let model = read(&case("slide"), &["scene.facets=8", "contact.law=mortar"]);
    let serial = run_side_by_side(&model, 1, 300, 0);
    assert!(serial.pairs.iter().map(Vec::len).sum::<usize>() > 1000, "there is contact");
    for (workers, force_every) in [(2, 0), (3, 25), (4, 0)] {
        let parallel = run_side_by_side(&model, workers, 300, force_every);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers");
        assert!(serial.pairs == parallel.pairs, "{workers} workers");
    }
}

/// Penalty and mass weights give the same bits on any number of workers and a correct energy
/// balance.
#[test]
fn other_laws_and_weights_keep_bits_momentum_and_energy() {
    for (set, bound) in [("contact.law=penalty", 0.01), ("contact.weighting=mass", 0.01)] {
        let runs = ["1", "4"].map(|workers| {
            let args = [
                "run",
                "cases/tumble",
                "--workers",
                workers,
                "--set",
                set,
                "--set",
                "output.field_interval=-1",
            ];
            run(crumple_with(&args)).with_code(0)
        });
        for r in &runs {
            assert_eq!(r.digest(), runs[0].digest(), "{set}");
            let s = r.summary();
            let e = &s["energy"];
            eprintln!(
                "{set}: error {}, penetration {}",
                e["error_max"], s["contact"]["penetration_max"]
            );
            assert!(s["contact"]["pairs_max"].as_u64() > Some(5), "there is contact");
            // Contact work is force times displacement for every law, so the balance is as good
            // as that of the elements: a trapezoid over steps in which bodies yield.
            assert!(e["error_max"].as_f64().unwrap() < bound, "{set}: {e}");
            // Contact may only take energy: all of it comes from 216 J of motion. A penalty
            // spring stores some temporarily and returns it.
            let contact = e["contact"].as_f64().unwrap();
            assert!(
                contact < 0.0 && -contact < e["total_initial"].as_f64().unwrap(),
                "{set}: contact work {contact}"
            );
            let history = r.history();
            for c in ["momentum x", "momentum y", "momentum z"] {
                let p = history.column(c);
                // 0.4 kg mm/ms, given with ten digits; no external force acts on the bodies.
                p.iter().for_each(|now| {
                    assert!((now - p[0]).abs() < 1e-9, "{set}: {c} from {} to {now}", p[0])
                });
            }
        }
    }
}

/// A rod hits a wall of bricks that lie on each other. A brick's node in a bed joint has touched
/// the brick above it, whose face is parallel to that of the rod, but its contact with the rod
/// is new. When it was treated as the old contact, its penetration exceeded the depth of that
/// contact, and the penalty law pushed it out.
#[test]
fn nodes_in_a_joint_of_bricks_are_new_to_what_hits_them() {
    for law in ["lagrange", "penalty"] {
        let set = format!("contact.law={law}");
        let args = [
            "run",
            "cases/brick-wall",
            "--set",
            "time.max_cycles=40",
            "--set",
            &set,
            "--workers",
            "2",
        ];
        let summary = run(crumple_with(&args)).with_code(0).summary();
        assert!(summary["contact"]["pairs_max"].as_u64() > Some(100), "there is contact");
        let depth = summary["contact"]["penetration_max"].as_f64().unwrap();
        assert!(depth < 0.3, "{law}: penetration {depth}, earlier 1.27");
    }
}

/// A tube of shells that are shorter than thick touches itself around its corners from the
/// start, unless contact limits the thickness of shells to the length of their sides.
#[test]
fn fine_shells_do_not_touch_round_a_corner() {
    let fine = [
        "scene.elements=40",
        "scene.side=40",
        "scene.length=12",
        "scene.trigger=0",
        "time.max_cycles=5",
    ];
    let pairs = ["1", "0"].map(|limit| {
        let limit = format!("contact.thickness_limit={limit}");
        let mut most = 0;
        let model = read(&case("tube-crush"), &[&fine[..], &[&limit]].concat());
        run_alone(&model, |e| most = most.max(e.contact.as_ref().unwrap().owned_table().count()));
        most
    });
    assert_eq!(pairs[0], 0);
    assert!(pairs[1] > 0, "the tube has no contact pairs: {pairs:?}");
}
