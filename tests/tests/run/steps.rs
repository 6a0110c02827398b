//! The stable step if several features share the masses of nodes: springs, ties with an offset,
//! and shells in penalty contact. The computed step is valid at any safety up to 1 (with
//! contact, up to the safety that the contact law assumes). The limit is therefore found by
//! bisection, as in A23 and A24 of the catalogue. Units: modulus and density of the shells are
//! 1.

use crumple::analysis::spectrum;
use crumple::input::job::Model;
use crumple::run::embedded::run_alone;
use crumple_tests::model_of;
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};
use std::ops::ControlFlow;

/// A mesh, and all other keys of the job.
#[derive(Default)]
struct UnitScene {
    mesh: Scene,
    rest: String,
    /// Damping in proportion to mass [1/time].
    damping: f64,
}

impl UnitScene {
    fn part(&mut self, id: u32, element: &str, thickness: f64) {
        let element = if element == "c0_triangle" {
            String::new()
        } else {
            format!("element = {element:?}\n")
        };
        self.rest += &format!(
            "[[part]]\nid = {id}\nmaterial = \"unit\"\nthickness = {thickness:?}\n{element}"
        );
    }

    fn model(mut self, sets: &[(&str, &[u32])], nu: f64, safety: f64, cycles: usize) -> Model {
        sets.iter().for_each(|(name, nodes)| self.mesh.set_named(name, nodes));
        let text = format!(
            "end_time = 1e9\n{}\
             [output]\nfield_interval = -1.0\n[time]\nsafety = {safety:?}\nmax_cycles = {cycles}\n\
             dt_min_ratio = 0.0\ndamping = {:?}\n\
             [[material]]\nname = \"unit\"\nlaw = \"elastic\"\ndensity = 1.0\n\
             youngs_modulus = 1.0\npoisson = {nu:?}\n{}",
            self.mesh.mesh_text(),
            self.damping,
            self.rest
        );
        model_of(&text, &[])
    }
}

/// Returns true if small random initial velocities grow.
fn grows(model: &Model) -> bool {
    const NOISE: f64 = 1e-12;
    let mut random = fastrand::Rng::with_seed(7);
    let mut grown = false;
    let ended = run_alone(model, |e: &mut Engine| {
        if e.clock.cycle == 0 {
            for n in (0..e.nodes.local_count).filter(|&n| e.nodes.fixed[n] & 0b111 == 0) {
                (0..3).for_each(|c| e.nodes.v[n][c] += NOISE * (2.0 * random.f64() - 1.0));
            }
        }
        let largest = e.nodes.v.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
        grown |= largest.is_nan() || largest > 1e4 * NOISE;
        if grown { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    grown || ended.expect("one worker").trouble.is_some()
}

/// Returns the largest safety at which a scene does not grow, to a hundredth.
fn limit(model: impl Fn(f64) -> Model) -> f64 {
    let (mut low, mut high) = (0.5, 2.5);
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if grows(&model(middle)) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

const SHELLS: [&str; 3] = ["belytschko_tsay", "stabilised_quad", "c0_triangle"];

/// Returns a square, or two triangles, regular or distorted, with springs from its corners
/// outwards along the diagonals to the ground.
fn lone(element: &str, distorted: bool, stiffness: f64, damping: f64) -> (UnitScene, Vec<u32>) {
    let mut scene = UnitScene::default();
    let far = if distorted { [1.4, 0.7] } else { [1.0, 1.0] };
    let corners = [[0.0, 0.0], [1.0, 0.0], far, [0.0, 1.0]];
    let nodes = corners.map(|[x, y]| scene.mesh.node([x, y, 0.0]));
    match element {
        "c0_triangle" => [[0, 1, 2], [0, 2, 3]]
            .iter()
            .for_each(|t| _ = scene.mesh.shell(1, &t.map(|c: usize| nodes[c]))),
        _ => _ = scene.mesh.shell(1, &nodes),
    }
    let ground: Vec<u32> =
        corners.iter().map(|[x, y]| scene.mesh.node([3.0 * x - 1.0, 3.0 * y - 1.0, 0.0])).collect();
    (0..4).for_each(|c| scene.mesh.spring(2, [nodes[c], ground[c]]));
    scene.part(1, element, 0.01);
    scene.rest += &format!(
        "[[part]]\nid = 2\n[part.spring]\nstiffness = {stiffness:?}\ndamping = {damping:?}\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n"
    );
    (scene, ground)
}

/// A single element with four springs is stable at full safety, for any stiffness of the
/// springs: each mode of both has its share of the mass. It was unstable at 0.9 when the single
/// square's own 5 % and the springs' 10 % were both taken from the safety.
#[test]
fn a_lone_element_with_four_springs_is_stable_at_its_step() {
    for element in SHELLS {
        for distorted in [false, true] {
            for nu in [0.0, 0.3] {
                // The corner's mass is 0.0025, the square of its highest frequency about 5:
                // springs of a fiftieth of that and more.
                for stiffness in [2e-4, 2e-3, 1e-2, 1.0] {
                    let of = |safety: f64| {
                        let (scene, ground) = lone(element, distorted, stiffness, 0.0);
                        scene.model(&[("ground", &ground)], nu, safety, 1500)
                    };
                    let limit = limit(of);
                    assert!(
                        limit > 0.98,
                        "{element}, distorted {distorted}, nu {nu}, stiffness {stiffness}: {limit}"
                    );
                }
            }
        }
    }
}

/// Dampers need mass in proportion to their strength, not to its square: weak ones reduce the
/// step very little.
#[test]
fn a_lone_element_with_dampers_is_stable_at_its_step_and_weak_ones_cost_nothing() {
    let first = |damping: f64| {
        let (scene, ground) = lone("belytschko_tsay", false, 0.0, damping);
        scene.model(&[("ground", &ground)], 0.3, 0.9, 1).first_dt().0
    };
    assert!(first(1e-7) > 0.999 * first(1e-12), "{} {}", first(1e-7), first(1e-12));
    for damping in [1e-5, 1e-4, 1e-3, 0.1] {
        let of = |safety: f64| {
            let (scene, ground) = lone("belytschko_tsay", false, 0.0, damping);
            scene.model(&[("ground", &ground)], 0.3, safety, 1500)
        };
        let limit = limit(of);
        assert!(limit > 0.98, "damping {damping}: {limit}");
    }
}

/// Returns a single square, or two triangles, whose edge is at the end of arms from a plate.
fn tied(element: &str, arm: f64, safety: f64) -> Model {
    let mut scene = UnitScene::default();
    let plate = [[-2.0, -2.0], [3.0, -2.0], [3.0, 3.0], [-2.0, 3.0]]
        .map(|[x, y]| scene.mesh.node([x, y, 0.0]));
    scene.mesh.shell(1, &plate);
    let corners = [[0.0, 0.0, arm], [1.0, 0.0, arm], [1.0, 1.0, arm], [0.0, 1.0, arm]];
    let nodes = corners.map(|x| scene.mesh.node(x));
    match element {
        "c0_triangle" => [[0, 1, 2], [0, 2, 3]]
            .iter()
            .for_each(|t| _ = scene.mesh.shell(2, &t.map(|c: usize| nodes[c]))),
        _ => _ = scene.mesh.shell(2, &nodes),
    }
    scene.part(1, "belytschko_tsay", 0.02);
    scene.part(2, element, 0.01);
    scene.rest += &format!(
        "[[tie]]\nnodes = \"edge\"\nparts = [1]\noffset = true\ntolerance = {:?}\n",
        2.0 * arm
    );
    scene.model(&[("edge", &nodes[..2])], 0.3, safety, 1500)
}

/// The step is stable at full safety.
#[test]
fn a_lone_element_tied_with_an_offset_is_stable_at_its_step() {
    for element in SHELLS {
        for arm in [0.6, 5.0] {
            let limit = limit(|safety| tied(element, arm, safety));
            assert!(limit > 0.98, "{element}, arm {arm}: {limit}");
        }
    }
}

/// Returns a square that lies on another one, smaller or rotated, pressed on by springs of a
/// contact with the largest permitted stiffness.
fn pressed(turned: bool, form: &str, safety: f64) -> Model {
    let mut scene = UnitScene { damping: 0.1, ..UnitScene::default() };
    let thickness = 0.05;
    let square = |half: f64, turn: f64, z: f64| {
        [0.0, 1.0, 2.0, 3.0].map(|k: f64| {
            let (s, c) = (turn + (k - 1.5) * FRAC_PI_2).sin_cos();
            [half * SQRT_2 * c, half * SQRT_2 * s, z]
        })
    };
    let below = square(0.5, 0.0, 0.0).map(|x| scene.mesh.node(x));
    let (half, turn) = if turned { (0.35, FRAC_PI_4) } else { (0.3, 0.0) };
    let above = square(half, turn, 1.0001 * thickness).map(|x| scene.mesh.node(x));
    scene.mesh.shell(1, &below);
    scene.mesh.shell(2, &above);
    [1, 2].iter().for_each(|&part| scene.part(part, "belytschko_tsay", thickness));
    let (load, share) = (1e-7, 4.0 * half * half);
    scene.rest += &format!(
        "[contact]\nlaw = \"penalty\"\npenalty_form = {form:?}\npenalty_scale = 1e3\n\
         penalty_damping = 0.0\n\
         [[pressure]]\nparts = [2]\npressure = {load:?}\n[[pressure]]\nparts = [1]\n\
         pressure = {:?}\n",
        -share * load
    );
    scene.model(&[], 0.3, safety, 6000)
}

/// Contact springs between two shells at their bound are stable at the step that the engine
/// takes. The law assumes a safety of 0.9 and leaves half of the margin, so the step may be at
/// least 0.951 of the limit of the elements; bisection finds the true limit.
#[test]
fn shells_in_penalty_contact_are_stable_at_their_step() {
    for turned in [false, true] {
        for form in ["soft", "stiffness"] {
            // A scene that comes to rest is stable; `safety` is that of the step, the law
            // assumes 0.9.
            let still = |safety: f64| {
                let (mut touching, mut largest) = (0, 0.0f64);
                let ended = run_alone(&pressed(turned, form, 0.9), |e: &mut Engine| {
                    e.settings.safety = safety;
                    touching = e.contact.as_ref().expect("there is contact").owned_pairs().count();
                    largest = e.nodes.v.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
                    if largest < 1.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                });
                let still = largest < 1e-12 && ended.is_ok_and(|ended| ended.trouble.is_none());
                assert!(!still || touching == 4, "turned {turned}, {form}: {touching} pairs");
                still
            };
            assert!(still(0.9), "turned {turned}, {form}: stable at the step of the run");
            let (mut low, mut high) = (0.9, 1.5);
            while high - low > 0.005 {
                let middle = 0.5 * (low + high);
                if still(middle) { low = middle } else { high = middle }
            }
            println!("turned {turned}, {form}: stable up to {low} of the step of the elements");
            assert!(low > 0.945, "turned {turned}, {form}: {low}");
        }
    }
}

/// Checks the limit from the highest frequency of the assembled system, without a run, against
/// the limits at which runs begin to grow.
fn assert_found(what: &str, of: impl Fn(f64) -> Model, at: f64, bisected: f64) {
    let model = of(0.3);
    let found = spectrum::assembled(&model, at).unwrap_or_else(|why| panic!("{what}: {why}"));
    let unit = found.taken / model.settings.safety;
    let share = found.limit / (bisected * unit);
    assert!(
        (share - 1.0).abs() < 0.02,
        "{what}: found {}, bisected {bisected}, {found:?}",
        share * bisected
    );
}

/// The limit of the assembled system is found to 2 % for a single square with springs, distorted
/// squares and triangles, plates that are tied with arms, and a patch.
#[test]
fn the_limit_of_the_assembled_system_is_found() {
    for element in SHELLS {
        for (distorted, stiffness) in [(false, 2e-3), (true, 1.0), (true, 1e-9)] {
            let of = |safety: f64| {
                let (scene, ground) = lone(element, distorted, stiffness, 0.0);
                scene.model(&[("ground", &ground)], 0.3, safety, 1500)
            };
            assert_found(
                &format!("{element}, distorted {distorted}, springs of {stiffness}"),
                of,
                0.0,
                limit(of),
            );
        }
        let of = |safety: f64| tied(element, 0.6, safety);
        assert_found(&format!("{element} at the end of an arm"), of, 0.0, limit(of));
    }
    let of = |safety: f64| {
        let mut scene = UnitScene::default();
        let n = 6;
        let place = |i: usize| i as f64 + 0.2 * ((i * i) as f64).sin();
        scene.mesh.lattice(1, [n, n], |i, j| [place(i), place(j) + 0.2 * place(i), 0.0]);
        scene.part(1, "stabilised_quad", 0.02);
        scene.model(&[], 0.3, safety, 3000)
    };
    assert_found("a patch", of, 0.0, limit(of));
}

/// A sheet is stretched by a half along x and held. At the time at which it comes to rest its
/// limit is equal to the bisected one from there, with redistributed mass and stress stiffening.
#[test]
fn the_limit_of_a_stretched_sheet_is_found() {
    let (n, end) = (4, 500.0);
    let of = |safety: f64| {
        let mut scene = UnitScene::default();
        let grid = scene.mesh.lattice(1, [n, n], |i, j| [i as f64, j as f64, 0.0]);
        scene.part(1, "belytschko_tsay", 0.1);
        scene.damping = 0.2; // it is at rest at `end`
        let [near, far] = [0, n].map(|i| grid.row(i));
        scene.rest += "[[fix]]\nnodes = \"near\"\ndofs = [\"x\", \"y\", \"z\"]\n\
             [[fix]]\nnodes = \"far\"\ndofs = [\"y\", \"z\"]\n\
             [[curve]]\nname = \"slow\"\npoints = [[0.0, 0.0], [100.0, 1.0], [1000.0, 1.0]]\n\
             [[motion]]\nnodes = \"far\"\ndisplacement = [2.0, 0.0, 0.0]\ndofs = [\"x\"]\n\
             curve = \"slow\"\n";
        scene.model(&[("near", &near), ("far", &far)], 0.3, safety, 0)
    };
    // From the time of rest on, with another safety and small added velocities.
    let grows_at = |safety: f64| {
        let (mut cycles, mut grown) = (0, false);
        let ended = run_alone(&of(0.3), |e: &mut Engine| {
            if e.clock.time < end {
                return ControlFlow::Continue(());
            }
            let largest = e.nodes.v.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
            if cycles == 0 {
                assert!(largest < 1e-9, "the sheet is not at rest: {largest}");
                e.settings.safety = safety;
                e.clock.whole_dt = f64::INFINITY;
                e.loads.stop_damping();
                // In all directions: round-off alone may leave a direction exactly at rest.
                for i in 0..e.nodes.local_count {
                    (0..3).for_each(|c| e.nodes.v[i][c] += 1e-9 * ((i * i + c) as f64).sin());
                }
            }
            cycles += 1;
            grown |= largest.is_nan() || largest > 1e-5;
            if grown || cycles > 3000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        grown || ended.expect("one worker").trouble.is_some()
    };
    let (mut low, mut high) = (0.5, 2.5);
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if grows_at(middle) { high = middle } else { low = middle }
    }
    assert_found("a stretched sheet", of, end, 0.5 * (low + high));
}

/// A wall that moves against the edge of a patch adds no frequency.
#[test]
fn a_moving_wall_does_not_change_the_limit() {
    let limit = |wall: &str| {
        let mut scene = UnitScene::default();
        scene.mesh.lattice(1, [4, 4], |i, j| [i as f64, j as f64, 0.0]);
        scene.part(1, "stabilised_quad", 0.1);
        scene.rest += wall;
        let model = scene.model(&[], 0.3, 0.9, 0);
        spectrum::assembled(&model, 0.0).unwrap_or_else(|why| panic!("{wall}: {why}")).limit
    };
    let (free, moving) = (
        limit(""),
        limit(
            "[[wall]]\nname = \"ram\"\npoint = [0.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n\
             mass = 10.0\nspeed = 0.01\n",
        ),
    );
    assert_eq!(free, moving);
}
