//! Rigid walls that move, are finite or are round, on any number of workers. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

const RHO: f64 = 7.85e-6;

/// Returns a job with square plates of shells of 1 mm, each with a part and a node set `part_1`
/// and so on: corner, sides and cells along x and y. `rest` is the rest of the job.
fn job(plates: &[([f64; 3], [f64; 2], [usize; 2])], end_time: f64, rest: &str) -> Model {
    let (mut scene, mut parts) = (Scene::default(), String::new());
    for (p, &(at, side, cells)) in (1..).zip(plates) {
        let along = |c: usize, i: usize| at[c] + side[c] * i as f64 / cells[c] as f64;
        let grid = scene.lattice(p, cells, |i, j| [along(0, i), along(1, j), at[2]]);
        scene.set_named(&format!("part_{p}"), grid.all());
        parts += &format!("[[part]]\nid = {p}\nmaterial = \"steel\"\nthickness = 1.0\n");
    }
    let text = format!(
        "end_time = {end_time:?}\n{}\
         [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
         density = {RHO:?}\n\
         youngs_modulus = 207.0\npoisson = 0.3\n{parts}{rest}",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

/// Returns the momentum along z of nodes and walls at the last mid-step.
fn along_z(e: &Engine) -> f64 {
    momentum(&e.nodes).0[2] + e.constraints.walls.carried(true).1.z
}

/// A plate, deformable or rigid, falls flat on a wall of mass M that moves towards it. Both
/// continue with the common velocity (m v + M V) / (m + M), to round-off. The energy loss m M /
/// (m + M) (V - v)^2 / 2 is in the ledger.
#[test]
fn a_plate_on_a_wall_with_a_mass_is_a_plastic_impact() {
    let (big, mass, speed, v) = (0.004, RHO * 20.0 * 20.0, 2.0, -10.0);
    for rigid in ["", "[[rigid]]\nname = \"plate\"\nparts = [1]\n[time]\ndt_max = 1e-3\n"] {
        let rest = format!(
            "[[wall]]\npoint = [0.0, 0.0, -0.05]\nnormal = [0.0, 0.0, 1.0]\nmass = {big:?}\n\
             speed = {speed:?}\n\
             [[initial_velocity]]\nvelocity = [0.0, 0.0, {v:?}]\n{rigid}"
        );
        let model = job(&[([0.0; 3], [20.0, 20.0], [4, 4])], 0.02, &rest);
        let initial = 0.5 * (mass * v * v + big * speed * speed);
        let (mut left, mut drift, start) = (0.0f64, 0.0f64, mass * v + big * speed);
        let end = run_alone(&model, |e| {
            let mut energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            energies.kinetic += e.constraints.walls.carried(false).0;
            left = left.max(energies.balance(initial).abs());
            drift = drift.max((along_z(e) - start).abs());
        });
        let after = start / (mass + big);
        let worst = (0..end.nodes.local_count)
            .map(|i| (end.nodes.v[i][2] - after).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-9, "{rigid}: {worst} from {after}");
        assert!(
            (end.constraints.walls.each()[0].velocity().z - after).abs() < 1e-9,
            "{:?}",
            end.constraints.walls.each()[0].velocity()
        );
        assert!(drift < 1e-11 * mass * 10.0, "{rigid}: round-off of all steps: {drift}");
        let lost = 0.5 * mass * big / (mass + big) * (speed - v) * (speed - v);
        let wall = end.ledger.energies(&end.nodes, &end.blocks).values().wall;
        assert!((wall + lost).abs() < 1e-6 * lost, "{rigid}: {wall} of {lost}");
        assert!(left < 1e-9 * initial, "{rigid}: {left} of {initial}");
        let given = end.constraints.walls.impulse(0)[2];
        assert!((given - mass * (after - v)).abs() < 1e-9 * mass * 10.0, "{rigid}: {given}");
    }
}

/// A rigid plate and another one touch a light wall in the same step, while a third plate
/// presses on the rigid one: the wall takes the velocity of the touching plates, and never more.
#[test]
fn bodies_and_nodes_do_not_both_use_a_walls_momentum() {
    let rest = "[[wall]]\npoint = [0.0, 0.0, -0.1]\nnormal = [0.0, 0.0, 1.0]\nmass = 1e-6\n\
                [[rigid]]\nname = \"plate\"\nparts = [1]\n[contact]\n\
                [[initial_velocity]]\nvelocity = [0.0, 0.0, -10.0]\n\
                [[initial_velocity]]\nnodes = \"part_3\"\nvelocity = [0.0, 0.0, -10.5]\n";
    let (side, cells) = ([20.0, 20.0], [4, 4]);
    let plates = [
        ([0.0; 3], side, cells),
        ([40.0, 0.0, 0.0], side, cells),
        ([0.0, 0.0, 1.001], side, cells),
    ];
    let (mut fastest, mut pairs) = (0.0f64, false);
    run_alone(&job(&plates, 0.03, rest), |e| {
        fastest = fastest.min(e.constraints.walls.each()[0].velocity().z);
        pairs |= fastest == 0.0 && e.contact.as_ref().unwrap().owned_table().next().is_some();
    });
    assert!(pairs, "there are pairs before the wall moves");
    assert!((-10.5..-9.0).contains(&fastest), "the plates arrive with 10 and 10.5: {fastest}");
}

/// Two strips fall: the strip above the rectangle rests on it, the other one falls past it.
/// Rigid strips do the same.
#[test]
fn nodes_outside_a_rectangle_pass_it() {
    let strips = [([1.0, 1.0, 0.2], [6.0, 6.0], [3, 3]), ([12.0, 1.0, 0.2], [6.0, 6.0], [3, 3])];
    for rigid in [
        "",
        "[[rigid]]\nname = \"on\"\nparts = [1]\n[[rigid]]\nname = \"next\"\nparts = [2]\n[time]\n\
         dt_max = 1e-3\n",
    ] {
        let rest = format!(
            "[[wall]]\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\nedge = [1.0, 0.0, 0.3]\n\
             lengths = [9.0, 9.0]\n\
             friction = 0.2\n[[initial_velocity]]\nvelocity = [0.3, 0.0, -10.0]\n{rigid}"
        );
        let end = run_alone(&job(&strips, 0.3, &rest), |_| {});
        let range = |ids: std::ops::Range<usize>| {
            ids.map(|i| end.nodes.x[i][2])
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], z| [l.min(z), h.max(z)])
        };
        let [on, next] = [range(0..16), range(16..32)];
        assert!(on[0] > -1e-9 && on[1] < 0.2, "{rigid}: {on:?}");
        assert!(next.iter().all(|z| (z + 2.8).abs() < 1e-9), "{rigid}: {next:?}");
    }
}

/// A strip, rigid or deformable, falls across a cylinder and hangs over it: its middle stays
/// outside and its ends move down. A cylinder that moves upwards by prescribed motion through
/// the set of its ends passes them.
#[test]
fn a_cylinder_catches_a_strip() {
    let strip = [([-20.0, 0.0, 10.5], [40.0, 4.0], [20, 2])];
    for (rigid, led) in [
        ("", ""),
        ("[[rigid]]\nname = \"strip\"\nparts = [1]\n[time]\ndt_max = 1e-3\n", ""),
        ("", "velocity = [0.0, 0.0, 5.0]\n"),
    ] {
        let rest = format!(
            "[[wall]]\npoint = [0.0, -1.0, 0.0]\naxis = [0.0, 1.0, 0.0]\nradius = 10.0\n\
             length = 6.0\n{led}\
             [[initial_velocity]]\nvelocity = [0.0, 0.0, -5.0]\n{rigid}"
        );
        let (mut deepest, mut pressed) = (f64::INFINITY, 0.0f64);
        let end = run_alone(&job(&strip, 0.5, &rest), |e| {
            let axis = e.constraints.walls.each()[0].surface.position().z;
            let off = |i: usize| e.nodes.x[i][0].hypot(e.nodes.x[i][2] - axis) - 10.0;
            deepest = (0..e.nodes.local_count).map(off).fold(deepest, f64::min);
            pressed = pressed.max(e.constraints.walls.impulse(0)[2]);
        });
        assert!(deepest > -1e-6, "{rigid}{led}: {deepest}");
        assert!(pressed > 0.0, "{rigid}{led}: the wall has an impulse");
        let middle = end.nodes.x[10 * 3][2];
        let axis = end.constraints.walls.each()[0].surface.position().z;
        assert!(middle > 10.0 - 1e-6 + axis, "{rigid}{led}: {middle}");
        assert!((axis - if led.is_empty() { 0.0 } else { 2.5 }).abs() < 1e-12, "{axis}");
    }
}

/// A strip, rigid or deformable, falls on a sphere off its centre, with friction: no node is ever
/// inside, the impulse of the sphere is the change of momentum, and energy is in balance. A sphere
/// that moves by prescribed motion ends where its velocity leads.
#[test]
fn a_sphere_dents_a_strip() {
    let strip = [([-18.0, -3.0, 10.5], [40.0, 8.0], [20, 4])];
    let mass = RHO * 40.0 * 8.0;
    for (rigid, led) in [
        ("", ""),
        ("[[rigid]]\nname = \"strip\"\nparts = [1]\n[time]\ndt_max = 1e-3\n", ""),
        ("", "velocity = [0.0, 0.0, 5.0]\n"),
    ] {
        let rest = format!(
            "[[wall]]\npoint = [0.0, 0.0, 0.0]\nradius = 10.0\nfriction = 0.3\n{led}\
             [[initial_velocity]]\nvelocity = [1.0, 0.0, -5.0]\n{rigid}"
        );
        let initial = 0.5 * mass * 26.0;
        let (mut deepest, mut left) = (f64::INFINITY, 0.0f64);
        let end = run_alone(&job(&strip, 0.5, &rest), |e| {
            let centre = e.constraints.walls.each()[0].surface.position();
            let off = |i: usize| {
                let x = e.nodes.x[i];
                (0..3).map(|c| (x[c] - centre[c]).powi(2)).sum::<f64>().sqrt() - 10.0
            };
            deepest = (0..e.nodes.local_count).map(off).fold(deepest, f64::min);
            let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            left = left.max(energies.balance(initial).abs());
        });
        assert!(deepest > -1e-6, "{rigid}{led}: {deepest}");
        let given = end.constraints.walls.impulse(0);
        let change = momentum(&end.nodes).0;
        let start = [mass, 0.0, -5.0 * mass];
        for c in 0..3 {
            let error = (given[c] - (change[c] - start[c])).abs();
            assert!(error < 1e-9 * mass, "{rigid}{led}: {given:?} {change:?}");
        }
        assert!(given[2] > 0.1 * mass && given[0] < 0.0, "pressed and rubbed: {given:?}");
        assert!(left < 0.01 * initial, "{rigid}{led}: {left} of {initial}");
        let place = end.constraints.walls.each()[0].surface.position().z;
        assert!((place - if led.is_empty() { 0.0 } else { 2.5 }).abs() < 1e-12, "{place}");
    }
}

/// A wall with a mass throws two plates and a rigid one against each other, against a rectangle,
/// a cylinder and a sphere with prescribed motion, and a plane that acts on some nodes only: the
/// same bits on 1, 2 and 4 workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let plates = [
        ([0.0, 0.0, 0.0], [40.0, 20.0], [8, 4]),
        ([5.0, -3.0, 2.0], [30.0, 30.0], [6, 6]),
        ([10.0, 2.0, 4.0], [15.0, 15.0], [3, 3]),
    ];
    let rest = "[[rigid]]\nname = \"top\"\nparts = [3]\n[contact]\nfriction = 0.2\n\
                [[wall]]\npoint = [0.0, 0.0, -0.1]\nnormal = [0.02, 0.0, 1.0]\nmass = 0.01\n\
                speed = 12.0\nfriction = 0.3\n\
                [[wall]]\npoint = [20.0, -10.0, 3.5]\nnormal = [0.0, 0.0, -1.0]\n\
                edge = [1.0, 0.0, 0.0]\nlengths = [15.0, 0.0]\n\
                [[wall]]\npoint = [30.0, -20.0, 9.0]\naxis = [0.0, 1.0, 0.0]\nradius = 6.0\n\
                velocity = [1.0, 0.0, -8.0]\nfriction = 0.1\n\
                [[wall]]\npoint = [8.0, 6.0, 13.0]\nradius = 7.0\n\
                velocity = [0.0, 1.0, -9.0]\nfriction = 0.2\n\
                [[wall]]\npoint = [0.0, 0.0, 3.0]\nnormal = [0.0, 0.0, -1.0]\nmass = 0.004\n\
                speed = 1.0\nnodes = \"part_1\"\n\
                [[wall]]\npoint = [0.0, 0.0, 6.0]\nnormal = [0.0, 0.0, -1.0]\nexcept = \"part_2\"\n\
                [[initial_velocity]]\nnodes = \"part_3\"\nvelocity = [0.0, 1.0, -6.0]\n";
    let model = job(&plates, 2.0, rest);
    let serial = run_side_by_side(&model, 1, 800, 0);
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(serial.trouble.is_none() && met > 500, "{met} pairs in {} cycles", serial.pairs.len());
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 800, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
