//! Friction that depends on the contact pressure: a largest shear stress, and coefficients by
//! pressure and speed. Closed forms, and the same bits on any number of workers. Units mm, ms, kg.

use crate::beam_contact::{RADIUS, RHO, at, bar, gravity, in_contact, lines, ride};
use crumple::input::job::{self, Model};
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;

const LAWS: [&str; 4] = ["lagrange", "kinematic", "penalty", "mortar"];

fn near(found: f64, wanted: f64, tolerance: f64, why: &str) {
    assert!((found / wanted - 1.0).abs() < tolerance, "{found}, expected {wanted}: {why}");
}

/// Pressing weight, mass, velocity and foot area of the block of `cases/slide`, and the duration
/// of the ramp of the weight.
const WEIGHT: f64 = 0.4;
const MASS: f64 = 0.0314;
const SPEED: f64 = 10.0;
const FOOT: f64 = 400.0;
const RAMP: f64 = 0.1;

/// Returns the mean velocity of the block along x.
fn sliding(e: &Engine) -> f64 {
    let part = e.settings.parts.iter().position(|p| p.id == 2).unwrap() as u32;
    let mut nodes: Vec<u32> =
        e.blocks.elements.iter().filter(|l| l.record.part == part).flat_map(|l| l.nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.iter().map(|&n| e.nodes.v[n as usize][0]).sum::<f64>() / nodes.len() as f64
}

/// Runs the block of `cases/slide` with each law, with a limit of a third of Coulomb's friction.
/// Once the limit is reached, the block loses the velocity `tau A/m` per unit time. Returns the
/// measured loss over the expected one, by law.
fn limited(read: impl Fn(&[&str]) -> Model) -> [f64; 4] {
    let (friction, end) = (0.3, 1.5);
    let limit = friction * WEIGHT / FOOT / 3.0;
    // In the first third of the ramp Coulomb's friction grows up to the limit.
    let lost = limit * FOOT / MASS * (end - 0.5 * RAMP / 3.0);
    LAWS.map(|law| {
        let sets = [
            format!("contact.law={law}"),
            format!("contact.friction_limit={limit:?}"),
            format!("end_time={end:?}"),
        ];
        let engine = run_alone(&read(&sets.each_ref().map(String::as_str)), |_| {});
        (SPEED - sliding(&engine)) / lost
    })
}

/// Returns the job of `cases/slide` on one large fixed facet: only nodes of the block touch, and
/// their areas are known.
fn on_one_facet() -> String {
    let mut scene = Scene::default();
    let block =
        scene.block(2, [2, 2, 1], |u| [20.0 * u[0] - 30.0, 20.0 * u[1] - 10.0, 10.0 * u[2] + 1.0]);
    let base = scene.grid(1, [1, 1], |u, v| [120.0 * u - 60.0, 80.0 * v - 40.0, 0.0]);
    scene.set_named("base", base.all());
    scene.set_named("block", block.all());
    scene.set_named("top", &block.last(2));
    let job = std::fs::read_to_string(case("slide").join("job.toml")).unwrap();
    format!("end_time = 1.5\n{}{}", scene.mesh_text(), &job[job.find("[output]").unwrap()..])
}

/// The block slides on one large fixed facet: only its own nodes touch, and their areas are
/// known.
#[test]
fn friction_is_no_more_than_its_limit_times_the_area() {
    let text = on_one_facet();
    // As in the catalogue, A07: bricks of assumed strain flutter.
    let read = |sets: &[&str]| model_of(&text, &[sets, &["part.2.hourglass=stiffness"]].concat());
    for (found, law) in limited(read).into_iter().zip(LAWS) {
        near(found, 1.0, 0.02, law);
    }
    let [high, none] =
        [&["time.max_cycles=300", "contact.friction_limit=1.0"][..], &["time.max_cycles=300"]];
    let digest = |sets| run_side_by_side(&read(sets), 1, 300, 0).digest();
    assert_eq!(digest(high), digest(none), "a limit that is never reached changes nothing");
}

/// On facets half as large as the block, nodes of the base carry forces too, and the boundary of
/// the block between them is not known.
#[test]
fn limited_friction_on_coarse_facets_is_right_within_a_tenth() {
    for (found, law) in limited(|sets| read(&case("slide"), sets)).into_iter().zip(LAWS) {
        near(found, 1.0, 0.1, law);
    }
}

#[test]
fn limited_friction_gives_the_same_bits_on_any_number_of_workers() {
    for (scene, limit) in
        [("tumble", "contact.friction_limit=0.01"), ("slide", "contact.friction_limit=1e-4")]
    {
        for law in LAWS {
            let law = format!("contact.law={law}");
            let sets = ["time.max_cycles=600", "contact.friction=0.3", law.as_str()];
            let model = read(&case(scene), &[&sets[..], &[limit]].concat());
            let serial = run_side_by_side(&model, 1, 600, 0);
            assert_ne!(
                serial.digest(),
                run_side_by_side(&read(&case(scene), &sets), 1, 600, 0).digest(),
                "it matters"
            );
            for (workers, force_every) in [(2, 0), (3, 11)] {
                let parallel = run_side_by_side(&model, workers, 600, force_every);
                assert_eq!(serial.digest(), parallel.digest(), "{scene}, {law}: {workers} workers");
            }
        }
    }
}

/// Rows of pressure, speed and coefficient. Friction is small, so that it does not tilt the
/// block and its pressure is uniform.
const TABLE: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.04],
    [0.0, 20.0, 0.02],
    [0.001, 0.0, 0.03],
    [0.001, 20.0, 0.015],
    [0.002, 0.0, 0.01],
    [0.002, 20.0, 0.01],
    [0.004, 0.0, 0.005],
    [0.004, 20.0, 0.0025],
];

/// Returns the coefficient of `TABLE` at a pressure between two of its rows `low` and `low + 2`.
fn tabulated(low: usize, pressure: f64, speed: f64) -> f64 {
    let of = |row: usize| {
        let [[p, _, at_rest], [_, fast, at_speed]] = [TABLE[row], TABLE[row + 1]];
        (p, at_rest + (at_speed - at_rest) * speed / fast)
    };
    let ((a, low), (b, high)) = (of(low), of(low + 2));
    low + (high - low) * (pressure - a) / (b - a)
}

/// The block under three weights: its loss of velocity is that of the equation of motion
/// `m dv/dt = -mu(p, v) p A`, with the pressure of the ramp.
#[test]
fn friction_follows_a_table_of_pressure_and_speed() {
    let (text, end, steps) = (on_one_facet(), 1.5, 3000);
    let loss = |pressure: f64| {
        let (dt, mut v) = (end / f64::from(steps), SPEED);
        for step in 0..steps {
            let p = pressure * ((f64::from(step) + 0.5) * dt / RAMP).min(1.0);
            let row = if p < 0.001 {
                0
            } else if p < 0.002 {
                2
            } else {
                4
            };
            v -= dt * tabulated(row, p, v) * p * FOOT / MASS;
        }
        SPEED - v
    };
    let table = format!("contact.friction_table={TABLE:?}");
    for pressure in [0.0005, 0.0015, 0.003] {
        let wanted = loss(pressure);
        for law in LAWS {
            let sets = [
                table.clone(),
                format!("contact.law={law}"),
                "contact.friction=0.0".to_string(),
                format!("end_time={end:?}"),
                "part.2.hourglass=stiffness".to_string(),
            ];
            let text = text.replace("pressure = 0.001", &format!("pressure = {pressure:?}"));
            let engine = run_alone(&model_of(&text, &sets.each_ref().map(String::as_str)), |_| {});
            near(SPEED - sliding(&engine), wanted, 0.02, &format!("{law}, pressure {pressure}"));
        }
    }
}

#[test]
fn friction_by_pressure_gives_the_same_bits_on_any_number_of_workers() {
    // Pressures of `tumble` and `slide` differ by far.
    for (scene, scale) in [("tumble", 100.0), ("slide", 1.0)] {
        let rows = TABLE.map(|[p, v, mu]| [scale * p, v, 10.0 * mu]);
        let table = format!("contact.friction_table={rows:?}");
        for law in LAWS {
            let law = format!("contact.law={law}");
            let sets = ["time.max_cycles=600", "contact.friction=0.0", table.as_str(), &law];
            let model = read(&case(scene), &sets);
            let serial = run_side_by_side(&model, 1, 600, 0);
            let without = read(&case(scene), &[sets[0], sets[1], sets[3]]);
            let without = run_side_by_side(&without, 1, 600, 0);
            assert_ne!(serial.digest(), without.digest(), "it matters");
            for (workers, force_every) in [(2, 0), (3, 11)] {
                let parallel = run_side_by_side(&model, workers, 600, force_every);
                assert_eq!(serial.digest(), parallel.digest(), "{scene}, {law}: {workers} workers");
            }
        }
    }
}

/// A beam slides along another beam that it crosses at an angle, pressed by its weight. Both are
/// strips as wide as their diameter d and have the area `d^2/sin(angle)` in common. Returns the
/// deceleration over the pressing acceleration, by law.
fn crossed(angle: f64, weight: f64, contact: &str) -> [f64; 3] {
    let end = 1.0;
    ["lagrange", "kinematic", "penalty"].map(|law| {
        let mut scene = lines(end);
        let track = bar(&mut scene, 1, 1, [-40.0, 0.0, 0.0], [40.0, 0.0, 0.0]);
        let (s, c) = angle.to_radians().sin_cos();
        let at_end = |x: f64| [x * c - 3.0, x * s, 2.0 * RADIUS];
        let rider = bar(&mut scene, 2, 1, at_end(-15.0), at_end(15.0));
        ride(&mut scene, &track, &rider, 5.0);
        gravity(&mut scene, weight);
        let model = in_contact(&scene, &format!("law = \"{law}\"\n{contact}"));
        let engine = run_alone(&model, |_| {});
        (5.0 - at(&engine, rider[0]).1[0]) / end / weight
    })
}

#[test]
fn friction_of_crossed_edges_is_limited_by_their_common_area() {
    let mass = RHO * std::f64::consts::PI * RADIUS * RADIUS * 30.0;
    let weight = 1.5;
    for angle in [90.0f64, 40.0] {
        let area = 4.0 * RADIUS * RADIUS / angle.to_radians().sin();
        for part in [0.25, 0.5, 2.0] {
            // A limit of this part of Coulomb's friction; the last one has no effect.
            let limit = part * 0.4 * mass * weight / area;
            let found =
                crossed(angle, weight, &format!("friction = 0.4\nfriction_limit = {limit:?}"));
            for (found, law) in found.into_iter().zip(LAWS) {
                near(found, 0.4 * f64::min(part, 1.0), 0.02, &format!("{law}, {angle}, {part}"));
            }
        }
    }
}

#[test]
fn friction_of_crossed_edges_follows_a_table_of_pressure() {
    let mass = RHO * std::f64::consts::PI * RADIUS * RADIUS * 30.0;
    let angle = 50.0f64;
    let area = 4.0 * RADIUS * RADIUS / angle.to_radians().sin();
    let unit = mass / area; // pressure under the acceleration 1
    let rows = [[0.0, 0.0, 0.4], [2.0 * unit, 0.0, 0.2], [4.0 * unit, 0.0, 0.1]];
    for (weight, friction) in [(0.5, 0.35), (1.5, 0.25), (3.0, 0.15)] {
        let found = crossed(angle, weight, &format!("friction_table = {rows:?}"));
        for (found, law) in found.into_iter().zip(LAWS) {
            near(found, friction, 0.02, &format!("{law}, weight {weight}"));
        }
    }
}

#[test]
fn mistakes_in_a_table_of_friction_are_reported_all_at_once() {
    let sets = [
        "contact.friction_table=[[0.0, 1.0, 0.3], [0.0, 1.0, 0.2], [0.1, 0.0, -0.1]]".to_string(),
        "contact.friction=0.1".to_string(),
    ];
    let report = job::read(&case("tumble"), &sets).err().expect("it is wrong").to_string();
    for words in [
        "the row [0.0, 1.0, 0.2] follows [0.0, 1.0, 0.3]",
        "has the row [0.1, 0.0, -0.1]",
        "`friction` and `friction_table` are both given",
    ] {
        assert!(report.contains(words), "{words} in\n{report}");
    }
}
