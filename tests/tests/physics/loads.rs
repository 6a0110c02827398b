//! Loads and prescribed motion compared with closed forms, and the same bits on any number of
//! workers. Units mm, ms, kg, so kN and GPa.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;
use crumple_worker::math::row::xyz;

const RHO: f64 = 7.85e-6;
const E: f64 = 207.0;

/// Returns a square plate of side `side` in the plane z = 0 with `n` x `n` shells, part 1; set
/// `all` holds its nodes, `edge` those at x = 0, `lower` the first half. `rest` is the rest of
/// the job.
fn plate(side: f64, n: usize, thickness: f64, end_time: f64, rest: &str) -> Model {
    model_of(&plate_text(side, n, thickness, end_time, rest), &[])
}

/// Returns the text of the job of [`plate`].
fn plate_text(side: f64, n: usize, thickness: f64, end_time: f64, rest: &str) -> String {
    let mut scene = Scene::default();
    let at = |i: usize| side * i as f64 / n as f64;
    let grid = scene.lattice(1, [n, n], |i, j| [at(i), at(j), 0.0]);
    scene.set_named("all", grid.all());
    scene.set_named("edge", &grid.row(0));
    scene.set_named("lower", &grid.all()[..grid.all().len() / 2]);
    format!(
        "end_time = {end_time:?}\n{}\
         [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
         density = {RHO:?}\n\
         youngs_modulus = {E:?}\npoisson = 0.3\n[[part]]\nid = 1\nmaterial = \"steel\"\n\
         thickness = {thickness:?}\n{rest}",
        scene.mesh_text()
    )
}

/// The energy balance at whole times, as in history rows.
#[derive(Default)]
struct Balance {
    initial: f64,
    /// Largest error of the balance, and external work.
    left: f64,
    work: f64,
}

impl Balance {
    fn from(initial: f64) -> Self {
        Self { initial, ..Self::default() }
    }

    fn record(&mut self, e: &Engine) {
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        self.left = self.left.max(energies.balance(self.initial).abs());
        self.work = energies.external;
    }
}

/// Free fall: `z = -g t^2 / 2` at every step except for the change of the last two; all work
/// becomes kinetic energy.
#[test]
fn gravity_makes_all_fall_alike() {
    let g = 9.81e-3;
    let mut worst = 0.0f64;
    let model = plate(
        20.0,
        2,
        1.0,
        1.0,
        &format!(
            "[[gravity]]\nacceleration = [0.0, 0.0, {:?}]\n[[mass]]\nnodes = \"edge\"\n\
             mass = 0.1\n",
            -g
        ),
    );
    let mut balance = Balance::default();
    run_alone(&model, |e| {
        balance.record(e);
        let t = e.clock.time;
        let place = |i: usize| (e.nodes.x[i][2] + 0.5 * g * t * t).abs();
        worst = (0..e.nodes.local_count).map(place).fold(worst, f64::max);
    });
    // The scheme is exact for a constant force and step; its error is the square of a change of
    // the step.
    assert!(worst < 1e-7 * g, "{worst}");
    let Balance { left, work, .. } = balance;
    assert!(
        work > 1e-6 && left < 1e-12 * work,
        "round-off of the sums of 600 steps: {left} of {work}"
    );
}

/// Nodal forces and moments give the whole set its acceleration, a curve scales them, and
/// damping alone slows the plate by exp(-a t).
#[test]
fn nodal_loads_and_damping() {
    let (side, thickness) = (20.0, 1.0);
    let mass = RHO * side * side * thickness;
    let rest = "[[curve]]\nname = \"ramp\"\npoints = [[0.0, 0.0], [0.2, 2.0]]\n[[load]]\n\
                nodes = \"all\"\n\
                force = [0.3, 0.0, 0.0]\nmoment = [0.0, 0.0, 0.0]\ncurve = \"ramp\"\n";
    let mut balance = Balance::default();
    let end = run_alone(&plate(side, 2, thickness, 0.2, rest), |e| balance.record(e));
    let momentum: f64 =
        (0..end.nodes.local_count).map(|i| end.nodes.mass[i] * end.nodes.v[i][0]).sum();
    let t = end.clock.time - 0.5 * end.clock.last_dt; // mid-step
    let steps = end.clock.cycle as f64;
    assert!(
        (momentum / (0.3 * 5.0 * t * t) - 1.0).abs() < 1.0 / (steps * steps),
        "a rectangle rule: {momentum}"
    );
    let Balance { left, work, .. } = balance;
    assert!(
        left < 1e-6 * work,
        "waves between nodes of different mass, second order: {left} of {work}"
    );

    let rest = "[time]\ndamping = 5.0\n[[initial_velocity]]\nvelocity = [0.0, 3.0, 0.0]\n";
    let mut balance = Balance::from(0.5 * mass * 9.0);
    let end = run_alone(&plate(side, 2, thickness, 0.3, rest), |e| balance.record(e));
    let t = end.clock.time - 0.5 * end.clock.last_dt;
    let v = end.nodes.v[0][1];
    assert!(
        (v / (3.0 * (-5.0 * t).exp()) - 1.0).abs() < 1e-4,
        "second order: (a dt)^2 a t / 12 = 1e-5: {v}"
    );
    let Balance { left, work, .. } = balance;
    assert!(work < 0.0 && left < 1e-12 * mass * 9.0, "{left} of {work}");
}

/// A free plate under pressure accelerates against its normal with p A / m, in any orientation:
/// its momentum is p A t.
#[test]
fn pressure_acts_against_the_normal_and_turns_with_the_plate() {
    let (side, p) = (20.0, 1e-3);
    let mut balance = Balance::default();
    let rest = format!("[[pressure]]\nparts = [1]\npressure = {p:?}\n");
    let end = run_alone(&plate(side, 4, 1.0, 0.3, &rest), |e| balance.record(e));
    let momentum: f64 =
        (0..end.nodes.local_count).map(|i| end.nodes.mass[i] * end.nodes.v[i][2]).sum();
    let t = end.clock.time - 0.5 * end.clock.last_dt;
    // The only error is bending, since nodal masses are proportional to nodal areas only to
    // round-off.
    assert!((momentum / (-p * side * side * t) - 1.0).abs() < 1e-9, "{momentum}");
    let Balance { left, work, .. } = balance;
    assert!(left < 1e-9 * work, "{left} of {work}");

    // A quarter turn about y during the run: the force turns from -z to -x, so that its impulse
    // is 2 p A T / pi in each direction.
    let turn = std::f64::consts::FRAC_PI_2 / 0.3;
    let rest = format!(
        "[[pressure]]\nnodes = \"all\"\npressure = {p:?}\n[[initial_velocity]]\n\
         velocity = [0.0, 0.0, 0.0]\n\
         spin = [0.0, {turn:?}, 0.0]\ncentre = [10.0, 10.0, 0.0]\n"
    );
    let end = run_alone(&plate(side, 4, 1.0, 0.3, &rest), |_| {});
    let sum = |c: usize| {
        (0..end.nodes.local_count).map(|i| end.nodes.mass[i] * end.nodes.v[i][c]).sum::<f64>()
    };
    let expected = 2.0 * p * side * side * 0.3 / std::f64::consts::PI;
    for c in [0, 2] {
        // A spin of 5.2/ms stretches the plate by rho (w r)^2 / E = 1e-4 and more in its area.
        assert!((sum(c) / -expected - 1.0).abs() < 5e-3, "{c}: {} {expected}", sum(c));
    }
}

/// A plate held at one edge under pressure and damping comes to rest at the deflection of a
/// cantilever, p b L^4/(8 E I) (nu = 0.3 restrains the strip's curvature at the root only), and
/// the balance contains the work.
#[test]
fn dynamic_relaxation_finds_the_static_answer() {
    let (side, thickness, p) = (100.0, 4.0, 1e-4);
    // First frequency of a cantilever: 3.516/L^2 sqrt(E I/(rho A)); damping of twice its
    // circular frequency is critical.
    let w = 3.516 / (side * side) * (E * thickness * thickness / 12.0 / RHO).sqrt();
    let rest = format!(
        "[time]\ndamping = {:?}\n[[fix]]\nnodes = \"edge\"\n\
         dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[pressure]]\nparts = [1]\npressure = {:?}\n",
        2.0 * w,
        -p
    );
    let mut balance = Balance::default();
    let end = run_alone(&plate(side, 10, thickness, 12.0 / w, &rest), |e| balance.record(e));
    let beam = p * side.powi(4) / (8.0 * E * thickness.powi(3) / 12.0);
    let tips: Vec<f64> = (110..121).map(|i| end.nodes.x[i][2]).collect();
    let tip = tips.iter().sum::<f64>() / 11.0;
    // A square cantilever plate is stiffer than the beam (coefficient 0.129 against 1/8 of p L^4
    // / D, D = E I/(1 - nu^2)).
    assert!((tip / (0.129 * 8.0 * 0.91 * beam) - 1.0).abs() < 0.02, "{tip} {beam}");
    let Balance { left, work, .. } = balance;
    assert!(left < 0.01 * work.abs(), "energy balance of the elements: {left} of {work}");
}

/// Catalogue A19 (a): a full turn, prescribed in 100 and in 1000 steps, leaves no stress at a
/// quarter, a half and the end.
#[test]
fn a_prescribed_turn_leaves_no_stress() {
    for steps in [100.0, 1000.0] {
        let (dt, _) = plate(20.0, 2, 1.0, 1.0, "").first_dt();
        let end = steps * dt * (1.0 - 1e-9);
        for axis in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]] {
            let spin = axis.map(|a: f64| a * std::f64::consts::TAU / end);
            let rest =
                format!("[[motion]]\nnodes = \"all\"\nspin = {spin:?}\ncentre = [3.0, 4.0, 5.0]\n");
            let mut worst = 0.0f64;
            let mut cycles = 0;
            run_alone(&plate(20.0, 2, 1.0, end, &rest), |e| {
                cycles += 1;
                for b in &e.blocks.blocks {
                    for (i, el) in e.blocks.elements[b.first..b.first + b.count].iter().enumerate()
                    {
                        let fields = b
                            .element
                            .fields(b.state(i), &el.nodes.map(|n| xyz(&e.nodes.x[n as usize])));
                        worst = worst.max(fields.von_mises / E);
                    }
                }
            });
            eprintln!("{cycles} steps about {axis:?}: stress {worst:e} E");
            assert!(worst < 1e-10, "{cycles} steps about {axis:?}: {worst:e}");
        }
    }
}

/// Runs a plate of 10 mm thickness and 31.4 g: the block of the catalogue's A07 and A09.
fn block(end_time: f64, rest: &str, look: impl FnMut(&Engine)) -> Engine {
    let wall = "[[wall]]\nname = \"floor\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n\
                friction = 0.3\n";
    run_alone(&plate(20.0, 4, 10.0, end_time, &format!("{wall}{rest}")), look)
}

/// Catalogue A07: a block under 1 MPa slides with 10 m/s, mu = 0.3. It stops after 2.6167 ms and
/// 13.083 mm and stays there.
#[test]
fn a_pressed_block_slides_to_a_stop() {
    let rest = "[[pressure]]\nparts = [1]\npressure = 1e-3\n[[initial_velocity]]\n\
                velocity = [10.0, 0.0, 0.0]\n";
    let (mut stop, mut fastest_after) = (0.0, 0.0f64);
    let end = block(3.0, rest, |e| {
        let v = e.nodes.v[12][0];
        if v.abs() > 1e-2 {
            stop = e.clock.time;
        }
        if e.clock.time > 2.7 {
            fastest_after = fastest_after.max(v.abs());
        }
    });
    assert!((stop / 2.6167 - 1.0).abs() < 0.005, "stops at {stop}");
    assert!(
        (end.nodes.x[12][0] - 10.0 - 13.083).abs() < 0.005 * 13.083,
        "after {}",
        end.nodes.x[12][0] - 10.0
    );
    assert!(fastest_after < 1e-2, "remains at rest: {fastest_after}");
    let e = end.ledger.energies(&end.nodes, &end.blocks).values();
    assert!(
        (e.wall / -1.570 - 1.0).abs() < 0.005,
        "friction dissipates all kinetic energy: {}",
        e.wall
    );
}

/// Catalogue A09: on an incline with mu = 0.3 a block accelerates with g (sin a - mu cos a) at
/// 20 and 25 degrees and does not creep at 15. Rotated gravity represents the incline.
#[test]
fn a_block_on_an_incline() {
    for (degrees, acceleration) in [(15.0f64, 0.0), (20.0, 0.5897e-3), (25.0, 1.4786e-3)] {
        let (s, c) = degrees.to_radians().sin_cos();
        let g = 9.81e-3;
        let rest = format!("[[gravity]]\nacceleration = [{:?}, 0.0, {:?}]\n", g * s, -g * c);
        let end = block(2.0, &rest, |_| {});
        let way = end.nodes.x[12][0] - 10.0;
        let expected = 0.5 * acceleration * 4.0;
        assert!((way - expected).abs() < 0.01 * expected + 1e-9, "{degrees}: {way} {expected}");
    }
}

/// A plate on planes of symmetry is a quarter of a plate: the degrees of freedom that the planes
/// hold do not move, the others do.
#[test]
fn planes_of_symmetry_hold_what_they_must() {
    let rest = "[[symmetry]]\npoint = [0.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n[[symmetry]]\n\
                point = [0.0, 0.0, 0.0]\n\
                normal = [0.0, -3.0, 0.0]\n[[initial_velocity]]\nvelocity = [1.0, 1.0, 1.0]\n\
                spin = [1.0, 1.0, 1.0]\n";
    let model = plate(20.0, 2, 1.0, 1.0, rest);
    let (_, nodes) = model.records();
    // x, ry, rz on the first plane; y, rx, rz on the second; all of these in the corner.
    assert_eq!(
        [nodes[0].fixed, nodes[1].fixed, nodes[3].fixed, nodes[4].fixed],
        [0b11_1011, 0b11_0001, 0b10_1010, 0]
    );
    assert_eq!((nodes[1].v[0], nodes[1].w, nodes[1].v[2] != 0.0), (0.0, [1.0, 0.0, 0.0], true));
}

/// All loads together on 1, 2 and 4 workers, with forced renewals of the boxes: the same bits.
#[test]
fn bits_do_not_depend_on_workers() {
    let rest = "[time]\ndamping = 0.5\n[[curve]]\nname = \"wave\"\n\
                points = [[0.0, 0.0], [0.1, 1.0], [0.2, -0.5]]\n\
                [[gravity]]\nacceleration = [0.0, 0.3, -0.7]\ncurve = \"wave\"\n[[gravity]]\n\
                acceleration = [0.1, 0.0, 0.0]\n\
                [[load]]\nnodes = \"lower\"\nforce = [0.3, -0.2, 0.5]\nmoment = [0.1, 0.2, 0.3]\n\
                curve = \"wave\"\n\
                [[pressure]]\nparts = [1]\npressure = 0.01\n[[pressure]]\nnodes = \"lower\"\n\
                pressure = -0.02\ncurve = \"wave\"\n\
                [[motion]]\nnodes = \"edge\"\nspin = [0.3, 1.0, 0.0]\ncurve = \"wave\"\n\
                [[wall]]\npoint = [0.0, 0.0, -0.5]\nnormal = [0.0, 0.0, 1.0]\nfriction = 0.1\n\
                [contact]\nfriction = 0.1\n";
    let model = plate(60.0, 8, 1.0, 0.3, rest);
    let serial = run_side_by_side(&model, 1, 400, 0);
    assert!(serial.trouble.is_none() && serial.pairs.len() > 150, "{} cycles", serial.pairs.len());
    for (workers, force) in [(2, 0), (4, 0), (3, 7), (4, 5)] {
        let parallel = run_side_by_side(&model, workers, 400, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

/// A plate falls freely, is led at a constant velocity for a while, and falls on with this
/// velocity: `z = v (t2 - t1) - g t1^2/2 + v (t - t2) - g (t - t2)^2/2`, except for the steps at
/// which it begins and ends. The work of the motion is in the balance.
#[test]
fn a_motion_begins_and_ends() {
    let (g, v, [birth, death], end) = (0.5, 2.0, [0.3, 0.7], 1.0);
    let rest = format!(
        "[[gravity]]\nacceleration = [0.0, 0.0, {:?}]\n[[motion]]\nnodes = \"all\"\n\
         dofs = [\"z\"]\nvelocity = [0.0, 0.0, {v:?}]\nbirth = {birth:?}\ndeath = {death:?}\n",
        -g
    );
    let model = plate(10.0, 2, 1.0, end, &rest);
    let mut balance: Option<Balance> = None;
    let (mut worst, mut dt) = (0.0f64, 0.0f64);
    let last = run_alone(&model, |e| {
        balance.get_or_insert_with(|| Balance::from(0.0)).record(e);
        dt = dt.max(e.clock.dt);
        let t = e.clock.time;
        let fall = |t: f64| -0.5 * g * t * t;
        let expected = if t <= birth {
            fall(t)
        } else if t <= death {
            fall(birth) + v * (t - birth)
        } else {
            fall(birth) + v * (t - birth) + fall(t - death)
        };
        worst = worst.max((e.nodes.x[0][2] - expected).abs());
    });
    assert!(last.clock.time > death, "{}", last.clock.time);
    assert!(worst < 3.0 * v * dt, "three steps: {worst:e} {dt:e}");
    assert!(last.nodes.fixed.iter().all(|f| *f == 0), "all are free at the end");
    let balance = balance.unwrap();
    assert!(balance.left < 1e-9 * balance.work.abs(), "{} {}", balance.left, balance.work);
    let one = run_side_by_side(&model, 1, 1_000_000, 0).digest();
    for workers in [2, 3] {
        assert_eq!(run_side_by_side(&model, workers, 1_000_000, 0).digest(), one);
    }
}

/// Two motions in the same direction may follow each other, but not overlap. A rigid body is led
/// in a window in the same way.
#[test]
fn motions_follow_each_other() {
    let motion = |v: f64, birth: f64, death: f64, of: &str| {
        format!(
            "[[motion]]\n{of}\ndofs = [\"z\"]\nvelocity = [0.0, 0.0, {v:?}]\nbirth = {birth:?}\n\
             death = {death:?}\n"
        )
    };
    for (of, body) in [
        ("nodes = \"all\"", ""),
        ("rigid = \"one\"", "[time]\ndt_max = 1e-3\n[[rigid]]\nname = \"one\"\nparts = [1]\n"),
    ] {
        let both = motion(1.0, 0.0, 0.4, of) + &motion(-3.0, 0.4, 0.6, of);
        let model = plate(10.0, 2, 1.0, 1.0, &format!("{body}{both}"));
        let mut dt = 0.0f64;
        let end = run_alone(&model, |e| dt = dt.max(e.clock.dt));
        // Free flight with the last velocity from 0.6 on.
        let expected = 0.4 - 3.0 * (end.clock.time - 0.4);
        let z = end.nodes.x[0][2];
        assert!((z - expected).abs() < 12.0 * dt, "{of}: {z} {expected} {dt}");
    }
    let overlap =
        motion(1.0, 0.0, 0.4, "nodes = \"all\"") + &motion(-3.0, 0.3, 0.6, "nodes = \"all\"");
    let text = plate_text(10.0, 2, 1.0, 1.0, &overlap);
    let report = crumple::input::job::read_text("job.toml".into(), text, &[]).err().unwrap();
    assert!(report.to_string().contains("not free to follow a motion"), "{report}");
}

/// Gravity on the nodes of an edge gives them the momentum `m g t` with their mass, of elements and
/// lumped, on any number of workers.
#[test]
fn gravity_acts_on_nodes() {
    let g = 9.81e-3;
    let mut scene = Scene::default();
    let plate = scene.lattice(1, [2, 2], |i, j| [5.0 * i as f64, 5.0 * j as f64, 0.0]);
    let edge: Vec<u64> = plate.row(2).iter().map(|&n| u64::from(n)).collect();
    let text = format!(
        "end_time = 0.3\n{}[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
         law = \"elastic\"\ndensity = {RHO:?}\nyoungs_modulus = {E:?}\npoisson = 0.3\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[mass]]\nnodes = {{ rule = \"nodes\", ids = {edge:?} }}\nmass = 0.01\n\
         [[gravity]]\nacceleration = [0.0, 0.0, {:?}]\nnodes = \"mass.0.nodes\"\n",
        scene.mesh_text(),
        -g
    );
    let model = model_of(&text, &[]);
    // A quarter of the plate of 10 x 10 x 1: its edge has half of one of two rows.
    let mass = 0.01 + 0.25 * RHO * 100.0;
    let mut worst = 0.0f64;
    run_alone(&model, |e| {
        let p = crumple_worker::energy::momentum(&e.nodes).0[2];
        let expected = -mass * g * (e.clock.time - 0.5 * e.clock.last_dt);
        worst = worst.max((p - expected).abs() / (mass * g * 0.3));
    });
    assert!(worst < 1e-9, "{worst:e}");
    let one = run_side_by_side(&model, 1, 100, 0).digest();
    assert_eq!(run_side_by_side(&model, 3, 100, 0).digest(), one);
}

/// Gravity on one of two parts with common nodes gives them the momentum `m g t` with the mass m of
/// this part, and the work of this force.
#[test]
fn gravity_acts_on_parts() {
    let g = 9.81e-3;
    let mut scene = Scene::default();
    let first = scene.lattice(1, [2, 2], |i, j| [5.0 * i as f64, 5.0 * j as f64, 0.0]);
    let shared = first.row(2);
    // The second part begins at the last row of the first one.
    let next: Vec<u32> = (0..3).map(|j| scene.node([15.0, 5.0 * f64::from(j), 0.0])).collect();
    for j in 0..2 {
        scene.shell(2, &[shared[j], next[j], next[j + 1], shared[j + 1]]);
    }
    let part = |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
    let text = format!(
        "end_time = 0.5\n{}[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
         law = \"elastic\"\ndensity = {RHO:?}\nyoungs_modulus = {E:?}\npoisson = 0.3\n{}{}\
         [[gravity]]\nacceleration = [0.0, 0.0, {:?}]\nparts = [2]\n",
        scene.mesh_text(),
        part(1),
        part(2),
        -g
    );
    let model = model_of(&text, &[]);
    let mass = RHO * 5.0 * 10.0;
    let mut worst = 0.0f64;
    let mut balance = Balance::from(0.0);
    let end = run_alone(&model, |e| {
        balance.record(e);
        let p = crumple_worker::energy::momentum(&e.nodes).0[2];
        // Velocities are those in the middle of the last step.
        let expected = -mass * g * (e.clock.time - 0.5 * e.clock.last_dt);
        worst = worst.max((p - expected).abs() / (mass * g * 0.5));
    });
    assert!(worst < 1e-9, "{worst:e}");
    assert!(end.clock.time >= 0.5 && balance.left < 1e-3 * balance.work.abs());
    let one = run_side_by_side(&model, 1, 100, 0).digest();
    assert_eq!(run_side_by_side(&model, 3, 100, 0).digest(), one);
}
