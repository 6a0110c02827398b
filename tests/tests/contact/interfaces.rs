//! Contact interfaces: parts with their own contact settings, or without contact. Units mm, ms,
//! kg.

use crumple::input::job;
use crumple_tests::sheets::distance_at_contact;
use crumple_tests::{case, read, run_alone, run_side_by_side};
use crumple_worker::contact::surface::Segment;
use crumple_worker::engine::Engine;

/// Pressing weight, mass and velocity of the block of `cases/slide`, and the duration of the
/// ramp of the weight.
const WEIGHT: f64 = 0.4;
const MASS: f64 = 0.0314;
const SPEED: f64 = 10.0;
const RAMP: f64 = 0.1;

/// Returns the mean velocity and height of the block's nodes.
fn block(e: &Engine) -> ([f64; 3], f64) {
    let part = |id: u32| e.settings.parts.iter().position(|p| p.id == id).unwrap() as u32;
    let mut nodes: Vec<u32> = e
        .blocks
        .elements
        .iter()
        .filter(|l| l.record.part == part(2))
        .flat_map(|l| l.nodes)
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mean = |of: &dyn Fn(usize) -> f64| {
        nodes.iter().map(|&n| of(n as usize)).sum::<f64>() / nodes.len() as f64
    };
    let velocity = std::array::from_fn(|c| mean(&|n| e.nodes.v[n][c]));
    (velocity, mean(&|n| e.nodes.x[n][2]))
}

fn digest(sets: &[&str]) -> String {
    run_side_by_side(&read(&case("slide"), sets), 1, u64::MAX, 0).digest()
}

#[test]
fn an_interface_of_the_two_parts_gives_the_bits_of_one_contact() {
    let short = "time.max_cycles=300";
    let plain = digest(&[short]);
    let frictionless = digest(&[short, "contact.friction=0"]);
    assert_ne!(plain, frictionless, "friction has an effect");
    let pair = "contact.interface=[{parts=[1], against=[2], friction=0.3}]";
    assert_eq!(digest(&[short, "contact.friction=0", pair]), plain);
    let turned = "contact.interface=[{parts=[2], against=[1], friction=0.3}]";
    assert_eq!(digest(&[short, "contact.friction=0", turned]), plain, "in either order");
    let other = "contact.interface=[{parts=[2], friction=0.3}]";
    assert_eq!(
        digest(&[short, "contact.friction=0", other]),
        frictionless,
        "only the block with itself"
    );
    let alone = "contact.interface=[{parts=[1], against=[2]}]";
    assert_eq!(
        digest(&[short, "contact.law=none", "contact.friction=0.3", alone]),
        plain,
        "there are no other pairs"
    );
}

/// Nodes of the block slide on faces of the base; or nodes of the base are held by faces of the
/// block. In both cases no pair has the other direction, and no edges touch.
#[test]
fn contact_of_one_way_holds_the_nodes_of_its_parts_only() {
    for (parts, against) in [(2, 1), (1, 2)] {
        let key =
            format!("contact.interface=[{{parts=[{parts}], against=[{against}], one_way=true}}]");
        let sets = ["end_time=0.3", "contact.law=none", &key];
        let model = read(&case("slide"), &sets);
        let index = |id: u32| model.settings.parts.iter().position(|p| p.id == id).unwrap() as u32;
        let mut seen = 0;
        let parts_of = [parts, against].map(index);
        run_alone(&model, |e| {
            let surface = &e.contact.as_ref().unwrap().surface;
            let part_of = |node: u32| {
                let has = |s: &&Segment| s.nodes.contains(&node);
                surface.segments.iter().find(has).unwrap().part
            };
            for pair in e.contact.as_ref().unwrap().owned_table() {
                let segment = surface.segments.iter().find(|s| s.id == pair.segment).unwrap();
                assert_eq!([part_of(pair.nodes[0]), segment.part], parts_of);
                assert!(pair.key.is_node(), "{:?}", pair.key);
                seen += 1;
            }
        });
        assert!(seen > 0, "{parts} against {against}");
        let digests: Vec<String> = [1, 2, 3]
            .into_iter()
            .map(|workers| run_side_by_side(&model, workers, u64::MAX, 0).digest())
            .collect();
        assert!(digests.iter().all(|d| *d == digests[0]), "{digests:?}");
    }
}

/// Returns the velocity at a time of a mass under friction that depends on the velocity, by
/// small steps of the midpoint rule.
fn slowed(friction: impl Fn(f64) -> f64, end: f64) -> f64 {
    let steps = 20_000;
    let (dt, mut v, mut t) = (end / f64::from(steps), SPEED, 0.0f64);
    let slope = |t: f64, v: f64| -friction(v) * WEIGHT * (t / RAMP).min(1.0) / MASS;
    for _ in 0..steps {
        let middle = v + 0.5 * dt * slope(t, v);
        v += dt * slope(t + 0.5 * dt, middle);
        t += dt;
    }
    v
}

#[test]
fn friction_falls_with_the_sliding_speed() {
    let end = 1.5;
    let (fs, fd, decay) = (0.4, 0.1, 0.25);
    let expected = slowed(|v| fd + (fs - fd) * (-decay * v).exp(), end);
    let constant = slowed(|_| fs, end);
    for law in ["lagrange", "kinematic", "penalty"] {
        let law = format!("contact.law={law}");
        let numbers =
            ["contact.friction=0.4", "contact.friction_dynamic=0.1", "contact.friction_decay=0.25"];
        let engine = run_alone(
            &read(&case("slide"), &[&numbers[..], &[&law, "end_time=1.5"]].concat()),
            |_| {},
        );
        let lost = SPEED - block(&engine).0[0];
        let right = SPEED - expected;
        assert!(
            (lost / right - 1.0).abs() < 0.01,
            "{law}: velocity loss {lost}, closed form \
            {right}"
        );
        assert!(
            (right / (SPEED - constant) - 1.0).abs() > 0.3,
            "constant friction differs \
            measurably"
        );
    }
}

/// Without contact the weight drives the block down: with w(t) = W t/T up to T, and W after it,
/// its displacement is W/m (t^2/2 - T t/2 + T^2/6).
#[test]
fn parts_that_do_not_touch_pass_through_each_other() {
    let end = 0.5;
    let sets = ["end_time=0.5", "contact.interface=[{parts=[1], against=[2], law=\"none\"}]"];
    let model = read(&case("slide"), &sets);
    let mut first = None;
    let engine = run_alone(&model, |e| {
        first.get_or_insert(block(e).1);
    });
    let sunk = first.unwrap() - block(&engine).1;
    let expected = WEIGHT / MASS * (0.5 * end * end - 0.5 * RAMP * end + RAMP * RAMP / 6.0);
    assert!((sunk / expected - 1.0).abs() < 0.01, "displacement {sunk}, closed form {expected}");
    assert_eq!(engine.ledger.energies(&engine.nodes, &engine.blocks).values().contact, 0.0);
}

#[test]
fn contact_is_there_from_birth_to_death() {
    let model = read(&case("slide"), &["end_time=0.6", "contact.birth=0.2", "contact.death=0.4"]);
    let (mut seen, mut speeds) = ([0usize; 3], Vec::new());
    run_alone(&model, |e| {
        let period = if e.clock.time < 0.2 {
            0
        } else if e.clock.time < 0.4 {
            1
        } else {
            2
        };
        // The clock has advanced since the pairs were found.
        let near = [0.2, 0.4].iter().any(|t| (e.clock.time - t).abs() < 2.0 * e.clock.last_dt);
        if !near {
            seen[period] += e.contact.as_ref().unwrap().owned_table().count();
        }
        speeds.push((e.clock.time, block(e).0[2]));
    });
    assert!(
        seen[0] == 0 && seen[1] > 100 && seen[2] == 0,
        "pairs before, between and after: {seen:?}"
    );
    let at = |t: f64| speeds.iter().find(|s| s.0 >= t).unwrap().1;
    assert!(at(0.19) < -1.0, "the block falls: {}", at(0.19));
    assert!(at(0.38) > at(0.19) + 1.0, "the block is stopped: {} after {}", at(0.38), at(0.19));
    assert!(at(0.59) < at(0.41) - 1.0, "the block falls again: {} after {}", at(0.59), at(0.41));
}

/// Two sheets of 1 mm that fly at each other turn back when their middles are at the distance
/// that the interface sets.
#[test]
fn sheets_meet_at_the_thickness_of_their_interface() {
    let pair = "[contact]\n[[contact.interface]]\nparts = [1]\nagainst = [2]\n";
    let expected = [
        ("[contact]\n".to_string(), 1.0),
        (format!("{pair}thickness = 3.0\n"), 3.0),
        (format!("{pair}thickness_scale = 0.4\n"), 0.4),
        ("[[contact]]\nthickness = 3.0\n[[contact]]\nparts = [2]\n".to_string(), 3.0),
        ("[[contact]]\nthickness = 2.0\n[[contact]]\nthickness_scale = 0.5\n".to_string(), 0.5),
    ];
    for (contact, thickness) in expected {
        let apart = distance_at_contact(&contact, &[]);
        assert!((apart - thickness).abs() < 0.01, "{contact}: distance {apart}");
    }
}

/// Several laws in one scene: the same bits on any number of workers, conserved momentum, and no
/// created energy.
#[test]
fn interfaces_of_several_laws_give_the_same_bits_on_any_number_of_workers() {
    let laws = "contact.interface=[{parts=[1], law=\"kinematic\"}, {parts=[2], against=[1, 3], \
                law=\"penalty\", friction=0.2}, \
                {parts=[3], law=\"none\"}]";
    let model = read(&case("tumble"), &["time.max_cycles=900", laws]);
    assert!(model.settings.parts.len() >= 3, "parts of the scene: {}", model.settings.parts.len());
    let serial = run_side_by_side(&model, 1, 900, 0);
    assert!(serial.pairs.iter().map(Vec::len).sum::<usize>() > 500, "there is contact");
    for (workers, force_every) in [(2, 0), (3, 0), (4, 7)] {
        let parallel = run_side_by_side(&model, workers, 900, force_every);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers");
        assert!(serial.pairs == parallel.pairs, "{workers} workers");
    }
    let plain = run_side_by_side(&read(&case("tumble"), &["time.max_cycles=900"]), 1, 900, 0);
    assert_ne!(plain.digest(), serial.digest(), "the laws have an effect");
    let mut momentum: Option<[f64; 3]> = None;
    let engine = run_alone(&model, |e| {
        let sum = |c: usize| {
            (0..e.nodes.len()).map(|n| e.nodes.v[n][c] / e.nodes.inv_mass[n][c]).sum::<f64>()
        };
        let now = [sum(0), sum(1), sum(2)];
        let first = momentum.get_or_insert(now);
        (0..3).for_each(|c| {
            assert!(
                (now[c] - first[c]).abs() < 1e-9,
                "cycle {}: {now:?} from {first:?}",
                e.clock.cycle
            )
        });
    });
    let energies = engine.ledger.energies(&engine.nodes, &engine.blocks).values();
    assert!(energies.contact < 0.0, "contact dissipates energy: {energies:?}");
}

/// Friction that depends on velocity, a birth and a death time: the same bits on any number of
/// workers.
#[test]
fn friction_by_speed_gives_the_same_bits_on_any_number_of_workers() {
    let numbers = [
        "contact.friction=0.4",
        "contact.friction_dynamic=0.1",
        "contact.friction_decay=0.5",
        "contact.death=2.5",
    ];
    for scene in ["tumble", "slide"] {
        let model = read(&case(scene), &[&numbers[..], &["time.max_cycles=900"]].concat());
        let serial = run_side_by_side(&model, 1, 900, 0);
        assert!(serial.pairs.iter().map(Vec::len).sum::<usize>() > 500, "there is contact");
        for (workers, force_every) in [(2, 0), (3, 11), (4, 0)] {
            assert_eq!(
                serial.digest(),
                run_side_by_side(&model, workers, 900, force_every).digest(),
                "{scene}: {workers}"
            );
        }
    }
}

#[test]
fn mistakes_in_interfaces_are_reported_all_at_once() {
    let sets = [
        "contact.interface=[{name=\"a\", parts=[9], friction=-0.1}, {law=\"glue\", death=0.0}, \
         {parts=[1], skin=1.0}]"
            .to_string(),
        "contact.thickness_scale=0".to_string(),
    ];
    let report = job::read(&case("slide"), &sets).err().expect("it is wrong").to_string();
    let wanted = [
        "there is no part 9",
        "`friction` is -0.1",
        "there is no law `glue`",
        "`death` is 0",
        "unknown key `skin`",
        "`thickness_scale` is 0",
    ];
    for words in wanted {
        assert!(report.contains(words), "{words} in\n{report}");
    }
    assert_eq!(
        report.matches("thickness_scale` is").count(),
        1,
        "the inherited error is reported once\n{report}"
    );
    let hidden = "contact.interface=[{name=\"first\", parts=[1]}, {name=\"all\"}]".to_string();
    let model = job::read(&case("slide"), &[hidden]).unwrap_or_else(|report| panic!("{report}"));
    assert!(
        model
            .warnings
            .iter()
            .any(|w| w.message.contains("no pair of parts uses the interface `first`"))
    );
}
