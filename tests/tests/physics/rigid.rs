//! Rigid bodies made of shells: falling, guided, with prescribed motion, in contact, on any
//! number of workers. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;
use std::collections::BTreeMap;

/// Bodies of square shells, one part each.
#[derive(Default)]
pub struct Bodies {
    pub scene: Scene,
    /// Nodes of each part.
    parts: Vec<Vec<u32>>,
}

impl Bodies {
    /// Returns the number of the next part.
    fn next(&self) -> u32 {
        self.parts.len() as u32 + 1
    }

    /// Adds a plate in the plane z = `at[2]`, `cells` squares of side `side`.
    pub fn plate(&mut self, at: [f64; 3], cells: [usize; 2], side: f64) {
        let place = |i: usize, j: usize| [at[0] + side * i as f64, at[1] + side * j as f64, at[2]];
        let grid = self.scene.lattice(self.next(), cells, place);
        self.parts.push(grid.all().to_vec());
    }

    /// Adds a closed box from `at` with `cells` squares of side `side` along its edges.
    pub fn cuboid(&mut self, at: [f64; 3], cells: [usize; 3], side: f64) {
        let part = self.next();
        let mut known: BTreeMap<[usize; 3], u32> = BTreeMap::new();
        for axis in 0..3 {
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            for level in [0, cells[axis]] {
                for i in 0..cells[a] {
                    for j in 0..cells[b] {
                        let mut corner = |u: usize, v: usize| {
                            let mut place = [0; 3];
                            (place[axis], place[a], place[b]) = (level, i + u, j + v);
                            *known.entry(place).or_insert_with(|| {
                                self.scene.node([0, 1, 2].map(|c| at[c] + side * place[c] as f64))
                            })
                        };
                        let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        let outward =
                            if level == 0 { [quad[0], quad[3], quad[2], quad[1]] } else { quad };
                        self.scene.shell(part, &outward);
                    }
                }
            }
        }
        self.parts.push(known.into_values().collect());
    }

    /// Returns the job with sets of all nodes of each part, `part_1` and so on; `rest` is the
    /// rest of the job.
    pub fn job(&self, end_time: f64, rest: &str) -> Model {
        let mut scene = self.scene.clone();
        for (p, nodes) in (1..).zip(&self.parts) {
            let mut nodes = nodes.clone();
            nodes.sort_unstable();
            scene.set_named(&format!("part_{p}"), &nodes);
        }
        let part = |p| format!("[[part]]\nid = {p}\nmaterial = \"steel\"\nthickness = 1.0\n");
        let parts: String = (1..=self.parts.len()).map(part).collect();
        let text = format!(
            "end_time = {end_time:?}\n{}\
             [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
             density = 7.85e-6\n\
             youngs_modulus = 207.0\npoisson = 0.3\n{parts}{rest}",
            scene.mesh_text()
        );
        model_of(&text, &[])
    }
}

fn cube(rest: &str, end_time: f64, look: impl FnMut(&Engine)) -> Engine {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0; 3], [2, 2, 2], 5.0);
    run_alone(
        &bodies.job(end_time, &format!("[[rigid]]\nname = \"cube\"\nparts = [1]\n{rest}")),
        look,
    )
}

/// Catalogue A13: a cube of 1 kg falls 100 mm under g = 9.81 m/s2. It hits the floor after
/// 142.78 ms with 1.40071 m/s and stays there: the impact is plastic.
#[test]
fn a_rigid_cube_falls_and_lands() {
    let rest = "mass = 1.0\n[time]\ndt_max = 0.05\n[[gravity]]\n\
                acceleration = [0.0, 0.0, -9.81e-3]\n\
                [[wall]]\npoint = [0.0, 0.0, -100.0]\nnormal = [0.0, 0.0, 1.0]\nfriction = 0.3\n";
    let (mut landed, mut fastest) = (0.0, 0.0f64);
    let mut dip = 0.0f64;
    let end = cube(rest, 160.0, |e| {
        let v = e.constraints.bodies.bodies[0].last.velocity.z;
        if v < -1.0 {
            landed = e.clock.time;
        }
        fastest = fastest.min(v);
        dip = (0..e.nodes.local_count).map(|i| e.nodes.x[i][2] + 100.0).fold(dip, f64::min);
    });
    assert!((end.constraints.bodies.bodies[0].mass - 1.0).abs() < 1e-12);
    assert!((landed - 142.78).abs() < 0.06, "within one step: {landed}");
    assert!(
        (fastest + 1.40071).abs() < 1.5 * 0.05 * 9.81e-3,
        "mid-step, and within one step: \
        {fastest}"
    );
    assert!(
        end.constraints.bodies.bodies[0].last.velocity.norm() < 1e-9
            && end.constraints.bodies.bodies[0].last_spin.norm() < 1e-9
    );
    assert!(dip > -1e-9, "no node is below the wall: {dip}");
    let wall = end.ledger.energies(&end.nodes, &end.blocks).values().wall;
    assert!(
        (wall / (-0.5 * 1.40071f64.powi(2)) - 1.0).abs() < 1e-3,
        "all kinetic energy is lost: \
        {wall}"
    );
}

/// A body that is guided along x accelerates with F / m under any other loads, and one that may
/// only turn about z with M / J.
#[test]
fn guided_bodies_follow_what_is_left_free() {
    let dofs = |list: &str| {
        format!(
            "fixed = [{list}]\n[time]\ndt_max = 0.01\n[[load]]\nnodes = \"part_1\"\n\
             force = [0.3, 0.7, -0.2]\nmoment = [1.0, 2.0, 3.0]\n"
        )
    };
    let end = cube(&dofs("\"y\", \"z\", \"rx\", \"ry\", \"rz\""), 1.0, |_| {});
    let body = &end.constraints.bodies.bodies[0];
    let way = 0.5 * 0.3 / body.mass;
    assert!(
        (body.centre.x - 5.0 - way).abs() < 1e-11 * way
            && body.centre.y == 5.0
            && body.turn.angle() == 0.0,
        "{}",
        body.centre
    );
    let end = cube(&dofs("\"x\", \"y\", \"z\", \"rx\", \"ry\""), 1e-2, |_| {});
    let body = &end.constraints.bodies.bodies[0];
    // The inertia of the cube is the same about all axes; 1/2 M/J t^2, and half a step more at
    // mid-steps.
    let spin = 3.0 / body.inertia[(2, 2)] * (end.clock.time - 0.5 * end.clock.last_dt);
    assert!(
        (body.last_spin.z / spin - 1.0).abs() < 1e-9 && body.last_spin.x.abs() < 1e-12,
        "{} {spin}",
        body.last_spin
    );
}

/// A cube with prescribed spin carries a deformable plate through ten turns: its nodes end at
/// their initial positions.
#[test]
fn a_prescribed_body_moves_its_nodes() {
    let turns = 10.0 * std::f64::consts::TAU;
    let rest = format!(
        "[time]\ndt_max = 0.01\n[[motion]]\nrigid = \"cube\"\nspin = [{:?}, 0.0, {:?}]\n\
         [[motion]]\nrigid = \"cube\"\nvelocity = [1.0, 2.0, 3.0]\n",
        0.6 * turns,
        0.8 * turns
    );
    let end = cube(&rest, 1.0, |_| {});
    let off = |i: usize| {
        (0..3)
            .map(|c| (end.nodes.x[i][c] - end.nodes.x0[i][c] - (c + 1) as f64).abs())
            .fold(0.0, f64::max)
    };
    let worst = (0..end.nodes.local_count).map(off).fold(0.0, f64::max);
    assert!(worst < 1e-11, "63 radians in 100 steps, eps each, on 10 mm: {worst:e}");
}

/// A prescribed rotation is that of its curve at any time, and gives the same places as the spin
/// whose integral it is.
#[test]
fn a_prescribed_rotation_follows_its_curve() {
    let curve = "[[curve]]\nname = \"turn\"\npoints = [[0.0, 0.0], [0.4, 0.5], [1.0, 2.0]]\n";
    let of = |form: &str, amount: f64, curve: &str| {
        format!(
            "[time]\ndt_max = 0.01\n{curve}[[motion]]\nrigid = \"cube\"\n\
             {form} = [{:?}, 0.0, {:?}]\ncurve = \"turn\"\n",
            0.6 * amount,
            0.8 * amount
        )
    };
    let end = cube(&of("rotation", 1.5, curve), 1.0, |_| {});
    let turned = end.constraints.bodies.bodies[0].turn.scaled_axis();
    let off = (turned - nalgebra::Vector3::new(0.6, 0.0, 0.8) * 3.0).norm();
    assert!(off < 1e-11, "{turned} for 3 radians");
    // The end of the curve is steeper: 1.5 times 1.5/0.6.
    let spin = end.constraints.bodies.bodies[0].last_spin.norm();
    assert!((spin / 3.75 - 1.0).abs() < 1e-9, "{spin}");
    let rates = "[[curve]]\nname = \"turn\"\npoints = [[0.0, 2.0], [1.0, 2.0]]\n";
    let spun = cube(&of("spin", 1.5, rates), 1.0, |_| {});
    let worst = (0..end.nodes.local_count)
        .flat_map(|i| (0..3).map(move |c| (i, c)))
        .map(|(i, c)| (end.nodes.x[i][c] - spun.nodes.x[i][c]).abs())
        .fold(0.0, f64::max);
    assert!(worst < 1e-11, "{worst:e}");
}

/// A rigid cube hits a free elastic plate off its middle: linear and angular momentum of both
/// are conserved to round-off, energy does not grow, and the plate takes its share.
#[test]
fn contact_with_a_deformable_plate_keeps_momentum() {
    let mut bodies = Bodies::default();
    bodies.cuboid([8.0, 12.0, 2.0], [2, 2, 2], 5.0);
    bodies.plate([0.0, 0.0, 0.0], [6, 6], 5.0);
    for law in ["lagrange", "penalty"] {
        let rest = format!(
            "[[rigid]]\nname = \"cube\"\nparts = [1]\n[[initial_velocity]]\nnodes = \"part_1\"\n\
             velocity = [0.0, 1.0, -10.0]\n\
             spin = [0.1, 0.2, 0.3]\ncentre = [13.0, 17.0, 7.0]\n[contact]\nlaw = \"{law}\"\n\
             friction = 0.2\n"
        );
        let sums = |e: &Engine| {
            let (p, l) = crumple_worker::energy::momentum(&e.nodes);
            [p, l]
        };
        let (mut first, mut worst, mut pairs, mut deepest) = (None, [0.0f64; 2], 0, 0.0f64);
        let end = run_alone(&bodies.job(0.6, &rest), |e| {
            let now = sums(e);
            let first = *first.get_or_insert(now);
            for k in 0..2 {
                worst[k] = (0..3).map(|c| (now[k][c] - first[k][c]).abs()).fold(worst[k], f64::max);
            }
            let contact = e.contact.as_ref().unwrap();
            pairs += contact.owned_pairs().count();
            deepest = deepest.max(contact.penetration);
        });
        let body = &end.constraints.bodies.bodies[0];
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        let initial = 0.5 * body.mass * 101.0;
        eprintln!(
            "{law}: momentum {worst:?}, {energies:?}, initial {initial}, penetration {deepest}"
        );
        assert!(
            pairs > 20 && body.last.velocity.z > -9.0,
            "there is contact: {pairs}, {}",
            body.last.velocity
        );
        let p = body.mass * 10.0;
        assert!(worst[0] < 1e-12 * p, "{law}: round-off of a thousand steps: {worst:?} of {p}");
        // Positions and velocities are half a step apart, which changes L by F x v dt/2 during
        // contact only.
        assert!(worst[1] < 0.01 * p * 10.0, "{law}: {worst:?}");
        let kept = energies.kinetic + energies.internal + energies.hourglass;
        assert!(kept < initial * 1.01, "{law}: {kept} of {initial}");
        assert!(deepest < 0.5, "{law}: the mid-surfaces stay apart: {deepest}");
    }
}

/// Catalogue C06: a rigid cube starts 0.1 mm deep in a plate that is held. The contact law
/// reduces the penetration gradually, by 0.002 of the depth per step. The cube therefore leaves
/// with at most twice 0.002 d / dt, not with d / dt, and gains less than 1e-3 J.
#[test]
fn an_initial_penetration_does_not_throw_a_body_out() {
    let mut bodies = Bodies::default();
    bodies.cuboid([8.0, 12.0, 0.9], [2, 2, 2], 5.0);
    bodies.plate([0.0, 0.0, 0.0], [6, 6], 5.0);
    let rest = "[[rigid]]\nname = \"cube\"\nparts = [1]\n[contact]\n[[fix]]\nnodes = \"part_2\"\n\
                dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let (mut fastest, mut energy) = (0.0f64, 0.0f64);
    let end = run_alone(&bodies.job(0.3, rest), |e| {
        fastest = fastest.max(e.constraints.bodies.bodies[0].last.velocity.norm());
        energy = energy.max(e.constraints.bodies.bodies[0].energy());
    });
    eprintln!("{fastest} m/s, {energy} J, compared with {} m/s", 0.1 / end.clock.first_dt);
    assert!(
        fastest < 2.0 * 0.002 * 0.1 / end.clock.first_dt && energy < 1e-3,
        "{fastest} {energy}"
    );
}

/// A rigid cube carries a deformable plate by shared nodes, falls and slides on a wall, and is
/// hit by a second rigid body and by an elastic one: the same bits on 1, 2 and 4 workers, with
/// forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut bodies = Bodies::default();
    bodies.cuboid([0.0, 0.0, 0.0], [3, 3, 3], 5.0);
    bodies.cuboid([2.0, 3.0, 17.0], [4, 2, 2], 5.0);
    bodies.plate([-5.0, -3.0, 29.0], [5, 5], 5.0);
    // A flap on the first cube shares the nodes of one edge.
    let scene = &mut bodies.scene;
    let on_cube = |j: usize| [15.0, 5.0 * j as f64, 15.0];
    let edge: Vec<u32> = (0..4)
        .map(|j| (1..=scene.count()).find(|&n| scene.at(n) == on_cube(j)).expect("its edge"))
        .collect();
    let outer: Vec<u32> = (0..4).map(|j| scene.node([20.0, 5.0 * j as f64, 15.0])).collect();
    (0..3).for_each(|j| _ = scene.shell(4, &[edge[j], outer[j], outer[j + 1], edge[j + 1]]));
    bodies.parts.push([edge, outer].concat());
    let rest = "[time]\ndamping = 0.05\n[[rigid]]\nname = \"lower\"\nparts = [1]\n[[rigid]]\n\
                name = \"upper\"\nparts = [2]\nmass = 0.03\n\
                inertia = [1.0, 1.5, 1.2, 0.1, 0.0, 0.2]\n\
                [[wall]]\npoint = [0.0, 0.0, -0.4]\nnormal = [0.1, 0.0, 1.0]\nfriction = 0.2\n\
                [[gravity]]\nacceleration = [0.0, 0.0, -5.0]\n[[pressure]]\nparts = [2, 4]\n\
                pressure = 0.001\n\
                [[initial_velocity]]\nnodes = \"part_2\"\nvelocity = [0.5, -1.0, -6.0]\n\
                spin = [0.2, 0.3, -0.1]\ncentre = [12.0, 8.0, 22.0]\n\
                [[initial_velocity]]\nnodes = \"part_3\"\nvelocity = [0.0, 0.0, -9.0]\n[contact]\n\
                friction = 0.3\n";
    let model = bodies.job(2.0, rest);
    let serial = run_side_by_side(&model, 1, 1500, 0);
    let met: usize = serial.pairs.iter().map(Vec::len).sum();
    assert!(serial.trouble.is_none() && met > 1000, "{met} pairs in {} cycles", serial.pairs.len());
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 1500, force);
        for (cycle, (a, b)) in serial.pairs.iter().zip(&parallel.pairs).enumerate() {
            assert_eq!(a, b, "{workers} workers, renewed every {force}: pairs in cycle {cycle}");
        }
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
