//! Fluids of particles: waves compared with acoustics, conserved momentum, the energy balance, and
//! the same bits on any number of workers. Units mm, ms, kg.

use crumple::input::job::{self, Model};
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use crumple_worker::fem::elements::particle::slope_over_distance;

const RHO: f64 = 1e-6;
const C: f64 = 1500.0;

/// Returns the part of particles at a distance of 1; `more` are further keys.
fn fluid(id: u32, more: &str) -> String {
    format!(
        "[[part]]\nid = {id}\n[part.particles]\nspacing = 1.0\ndensity = {RHO:?}\n\
         sound_speed = {C:?}\n{more}\n"
    )
}

/// Adds a block of particles with `n` particles along each axis, from `from`.
fn block(scene: &mut Scene, part: u32, n: [usize; 3], from: [f64; 3]) -> Vec<u32> {
    let mut nodes = Vec::new();
    for k in 0..n[0] * n[1] * n[2] {
        let at = [k / (n[1] * n[2]), k / n[2] % n[1], k % n[2]];
        let node = scene.node([0, 1, 2].map(|c| from[c] + at[c] as f64));
        scene.particle(part, node);
        nodes.push(node);
    }
    nodes
}

/// Returns the gradient of the coordinate x by the sum over the neighbours in the lattice, with the
/// smoothing length 1.2: a wave that is long against the spacing has this speed, over that of
/// sound.
fn gradient_of_lattice() -> f64 {
    let places = || (-2i32..=2).map(f64::from);
    let all = places().flat_map(|x| places().map(move |y| (x, y)));
    let all = all.flat_map(|(x, y)| places().map(move |z| (x, (x * x + y * y + z * z).sqrt())));
    all.filter(|&(_, r)| r > 0.0).map(|(x, r)| -x * x * slope_over_distance(r, 1.2)).sum()
}

/// Two halves of a column meet with the velocity V each: fronts run from the middle with the speed
/// c of sound, behind them the fluid is at rest under the pressure `rho c V`. All particles are led
/// along x, so that the column is a tube; its outer particles lack neighbours, the inner ones are
/// measured. In the lattice c is 0.982 of that of the fluid. The speed of the front is taken
/// between two times, since it needs some spacings to form; behind it the pressure oscillates by
/// 10 %, and the mean over ten particles is taken.
#[test]
fn a_front_has_the_speed_of_sound_and_the_impedance_of_the_fluid() {
    const V: f64 = 1.0;
    let (long, wide) = (40, 13);
    let mut scene = Scene::default();
    let left = block(&mut scene, 1, [long, wide, wide], [0.5 - long as f64, 0.0, 0.0]);
    let right = block(&mut scene, 1, [long, wide, wide], [0.5, 0.0, 0.0]);
    scene.set_named("left", &left);
    scene.set_named("right", &right);
    let text = format!(
        "end_time = {:?}\n{}[output]\nfield_interval = -1.0\n{}\
         [[fix]]\nnodes = \"left\"\ndofs = [\"y\", \"z\"]\n\
         [[fix]]\nnodes = \"right\"\ndofs = [\"y\", \"z\"]\n\
         [[initial_velocity]]\nnodes = \"left\"\nvelocity = [{V:?}, 0.0, 0.0]\n\
         [[initial_velocity]]\nnodes = \"right\"\nvelocity = [{:?}, 0.0, 0.0]\n",
        20.0 / C,
        scene.mesh_text(),
        fluid(1, "viscosity = [0.5, 0.0]"),
        -V
    );
    let axis = right.len() / long / 2;
    let front = |e: &Engine| {
        let place = |i: usize| right[i * wide * wide + axis] as usize - 1;
        let v = |i: usize| e.nodes.v[place(i)][0];
        let i = (1..long).find(|&i| v(i) < -0.5 * V).unwrap();
        e.nodes.x[place(i - 1)][0] + (0.5 * V + v(i - 1)) / (v(i - 1) - v(i))
    };
    let mut early = None;
    let end = run_alone(&model_of(&text, &[]), |e| {
        if e.clock.time > 8.0 / C {
            early.get_or_insert_with(|| (e.clock.time, front(e)));
        }
    });
    let (time, place) = early.unwrap();
    let speed = (front(&end) - place) / (end.clock.time - time);
    let c = C * gradient_of_lattice();
    assert!((speed / c - 1.0).abs() < 0.005, "{speed} {c}");
    let mean = (1..11).map(|i| pressure(&end, right[i * wide * wide + axis])).sum::<f64>() / 10.0;
    assert!((mean / (RHO * c * V) - 1.0).abs() < 0.03, "{mean} {}", RHO * c * V);
}

/// Returns the pressure of the particle at a node [force/length^2].
fn pressure(e: &Engine, node: u32) -> f64 {
    let found = e.blocks.elements.iter().position(|own| own.nodes[0] == node - 1).unwrap();
    let b = e.blocks.blocks.iter().find(|b| (b.first..b.first + b.count).contains(&found)).unwrap();
    -b.element.fields(b.state(found - b.first), &[[0.0; 3]; 8]).stress[0]
}

/// A ball of particles of two fluids hits a free plate of shells at an angle, with friction.
fn collision() -> Model {
    let mut scene = Scene::default();
    scene.lattice(1, [8, 8], |i, j| [3.0 * i as f64 - 12.0, 3.0 * j as f64 - 12.0, 0.0]);
    let below = block(&mut scene, 2, [7, 6, 3], [-3.2, -2.9, 1.4]);
    let above = block(&mut scene, 3, [7, 6, 3], [-3.2, -2.9, 4.4]);
    scene.set_named("drop", &[below, above].concat());
    let text = format!(
        "end_time = 0.05\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"sheet\"\nlaw = \"elastic\"\ndensity = 2.7e-6\n\
         youngs_modulus = 70.0\npoisson = 0.33\n\
         [[part]]\nid = 1\nmaterial = \"sheet\"\nthickness = 1.0\n{}{}\
         [[initial_velocity]]\nnodes = \"drop\"\nvelocity = [60.0, 20.0, -150.0]\n\
         [contact]\nfriction = 0.1\n",
        scene.mesh_text(),
        fluid(2, ""),
        fluid(3, "tension = 1e-4\nexponent = 1.0").replace("density = 1e-6", "density = 2e-6"),
    );
    model_of(&text, &[])
}

/// Forces between particles are opposite to the last bit, and contact conserves momentum: what is
/// left is the round-off of sums. The energy balance is that of all elements.
#[test]
fn momentum_and_energy_are_conserved() {
    let (mut pairs, mut start) = (0, None);
    let energies = |e: &Engine| e.ledger.energies(&e.nodes, &e.blocks).values();
    let total = |e: &Engine| {
        let energies = energies(e);
        energies.kinetic + energies.internal + energies.hourglass
            - energies.contact
            - energies.external
            - energies.wall
    };
    let mut worst = 0.0f64;
    let end = run_alone(&collision(), |e| {
        pairs = pairs.max(e.contact.as_ref().map_or(0, |c| c.owned_pairs().count()));
        let (first, before) = *start.get_or_insert_with(|| (momentum(&e.nodes).0, total(e)));
        worst = worst.max((total(e) / before - 1.0).abs());
        let now = momentum(&e.nodes).0;
        for c in 0..3 {
            assert!((now[c] - first[c]).abs() < 1e-12 * first[2].abs(), "{first:?} {now:?}");
        }
    });
    assert!(pairs > 10, "{pairs} pairs");
    assert!(worst < 0.01, "{worst}");
    let energies = energies(&end);
    assert!(energies.internal > 0.0 && energies.contact < 0.0, "{energies:?}");
}

/// The drop breaks up and spreads over the boxes of all workers, also with forced renewals and
/// after a restart on another number of workers.
#[test]
fn bits_do_not_depend_on_workers() {
    let model = collision();
    let serial = run_side_by_side(&model, 1, 200, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (3, 0), (4, 0), (2, 7), (3, 11), (4, 13)] {
        let parallel = run_side_by_side(&model, workers, 200, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
    for workers in [[3, 2], [1, 4]] {
        let plan = Plan { at: 70, cycles: 200, workers };
        assert_eq!(serial.digest(), run_interrupted(&model, plan), "{plan:?}");
    }
}

/// The scene `splash` on 1 and 3 workers.
#[test]
fn a_drop_splashes_with_the_same_bits() {
    let model = read(&case("splash/job.toml"), &["scene.radius=4.0", "scene.shells=12"]);
    let [one, three] = [1, 3].map(|workers| run_side_by_side(&model, workers, 150, 0));
    assert!(one.trouble.is_none(), "{:?}", one.trouble);
    assert_eq!(one.digest(), three.digest());
}

/// All that is wrong with particles is reported at once.
#[test]
fn what_particles_cannot_be_is_reported_at_once() {
    let mut scene = Scene::default();
    let nodes = block(&mut scene, 1, [2, 2, 2], [0.0; 3]);
    scene.particle(1, nodes[0]);
    let text = format!(
        "end_time = 1.0\n{}[time]\nsubcycles = 2\n[parallel]\ncontact = \"rcb\"\n{}\
         [[rigid]]\nname = \"body\"\nparts = [1]\n[contact]\n",
        scene.mesh_text(),
        fluid(1, "smoothing = 3.0\nviscosity = [-1.0, 0.0]")
            .replace("[part.particles]", "skin = true\n[part.particles]")
    );
    let report = job::read_text("job.toml".into(), text, &[]).err().unwrap().to_string();
    for wanted in [
        "have no subcycles",
        "does not know particles",
        "cannot be rigid",
        "node of a particle",
        "smoothing is 3",
        "viscosity.0 is -1",
        "cannot be a skin",
    ] {
        assert!(report.contains(wanted), "{wanted}: {report}");
    }
}
