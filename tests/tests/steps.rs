//! The stable step where masses of nodes are shared: with springs, ties with an offset, and shells in penalty contact. What the step
//! is reckoned with holds at any safety up to 1 (or where contact is, up to what it is told of the safety), so the limit is bisected
//! as in A23 and A24 of the catalogue. Units: modulus and density of the shells are 1.

use crumple::embedded::run_alone;
use crumple::job::{self, Model};
use crumple_worker::engine::Engine;
use std::ops::ControlFlow;

/// Nodes, shells and springs of a mesh in the making, and all else of the job.
#[derive(Default)]
struct Scene {
    nodes: String,
    shells: String,
    springs: String,
    rest: String,
    count: usize,
    elements: usize,
}

impl Scene {
    fn node(&mut self, [x, y, z]: [f64; 3]) -> usize {
        self.count += 1;
        self.nodes += &format!("[{}, {x:?}, {y:?}, {z:?}],\n", self.count);
        self.count
    }

    fn shell(&mut self, part: u32, corners: &[usize]) {
        self.elements += 1;
        let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
        self.shells += &format!("[{}, {part}, {}],\n", self.elements, corners.join(", "));
    }

    fn spring(&mut self, part: u32, ends: [usize; 2]) {
        self.elements += 1;
        self.springs += &format!("[{}, {part}, {}, {}],\n", self.elements, ends[0], ends[1]);
    }

    fn part(&mut self, id: u32, element: &str, thickness: f64) {
        let element = if element == "c0_triangle" { String::new() } else { format!("element = {element:?}\n") };
        self.rest += &format!("[[part]]\nid = {id}\nmaterial = \"unit\"\nthickness = {thickness:?}\n{element}");
    }

    fn model(&self, sets: &[(&str, &[usize])], nu: f64, safety: f64, cycles: usize) -> Model {
        let sets: Vec<String> = sets.iter().map(|(name, ids)| format!("{name} = {ids:?}")).collect();
        let text = format!(
            "end_time = 1e9\n[mesh]\nnodes = [{}]\nshells = [{}]\nsprings = [{}]\nnode_sets = {{ {} }}\n\
             [output]\nfield_interval = -1.0\n[time]\nsafety = {safety:?}\nmax_cycles = {cycles}\ndt_min_ratio = 0.0\n\
             [[material]]\nname = \"unit\"\nlaw = \"elastic\"\ndensity = 1.0\nyoungs_modulus = 1.0\npoisson = {nu:?}\n{}",
            self.nodes,
            self.shells,
            self.springs,
            sets.join(", "),
            self.rest
        );
        let there = tempfile::tempdir().unwrap();
        let path = there.path().join("steps.toml");
        std::fs::write(&path, text).unwrap();
        job::read(&path, &[]).unwrap_or_else(|report| panic!("{report}"))
    }
}

/// Whether what is moved by next to nothing at first grows; `at` sees all nodes' velocities.
fn grows(model: &Model) -> bool {
    const NOISE: f64 = 1e-12;
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        NOISE * ((seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    };
    let mut grown = false;
    let ended = run_alone(model, |e: &mut Engine| {
        if e.clock.cycle == 0 {
            for n in (0..e.nodes.held).filter(|&n| e.nodes.fixed[n] & 0b111 == 0) {
                (0..3).for_each(|c| e.nodes.v[n][c] += random());
            }
        }
        let largest = e.nodes.v.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
        grown |= largest.is_nan() || largest > 1e4 * NOISE;
        if grown { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    grown || ended.expect("one worker").trouble.is_some()
}

/// Largest safety at which a scene does not grow, to a hundredth.
fn limit(model: impl Fn(f64) -> Model) -> f64 {
    let (mut low, mut high) = (0.5, 2.5);
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if grows(&model(middle)) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

const SHELLS: [&str; 3] = ["belytschko_tsay", "stabilised_quad", "c0_triangle"];

/// A square, or two triangles, as it lies or out of shape, with springs from its corners outwards along the diagonals to the ground.
fn lone(element: &str, distorted: bool, stiffness: f64, damping: f64) -> (Scene, Vec<usize>) {
    let mut scene = Scene::default();
    let far = if distorted { [1.4, 0.7] } else { [1.0, 1.0] };
    let corners = [[0.0, 0.0], [1.0, 0.0], far, [0.0, 1.0]];
    let nodes = corners.map(|[x, y]| scene.node([x, y, 0.0]));
    match element {
        "c0_triangle" => [[0, 1, 2], [0, 2, 3]].iter().for_each(|t| scene.shell(1, &t.map(|c: usize| nodes[c]))),
        _ => scene.shell(1, &nodes),
    }
    let ground: Vec<usize> = corners.iter().map(|[x, y]| scene.node([3.0 * x - 1.0, 3.0 * y - 1.0, 0.0])).collect();
    (0..4).for_each(|c| scene.spring(2, [nodes[c], ground[c]]));
    scene.part(1, element, 0.01);
    scene.rest += &format!(
        "[[part]]\nid = 2\n[part.spring]\nstiffness = {stiffness:?}\ndamping = {damping:?}\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n"
    );
    (scene, ground)
}

/// A lone element with four springs is stable at full safety, however stiff they are against it: each mode of both has its share of
/// the mass. It was not at 0.9 while the lone square's own 5 % and the springs' 10 % were both taken from the safety.
#[test]
fn a_lone_element_with_four_springs_bears_its_step() {
    for element in SHELLS {
        for distorted in [false, true] {
            for nu in [0.0, 0.3] {
                // The corner's mass is 0.0025, the square of its highest frequency some 5: springs of a fiftieth of that and more.
                for stiffness in [2e-4, 2e-3, 1e-2, 1.0] {
                    let of = |safety: f64| {
                        let (scene, ground) = lone(element, distorted, stiffness, 0.0);
                        scene.model(&[("ground", &ground)], nu, safety, 1500)
                    };
                    let limit = limit(of);
                    assert!(limit > 0.98, "{element}, distorted {distorted}, nu {nu}, stiffness {stiffness}: {limit}");
                }
            }
        }
    }
}

/// Dampers need mass in proportion to their strength, not to its square: weak ones take next to none of the step.
#[test]
fn a_lone_element_with_dampers_bears_its_step_and_weak_ones_cost_nothing() {
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

/// A lone square whose edge stands at the end of arms from a plate: at full safety.
#[test]
fn a_lone_element_tied_with_an_offset_bears_its_step() {
    for element in SHELLS {
        for arm in [0.6, 5.0] {
            let of = |safety: f64| {
                let mut scene = Scene::default();
                let plate = [[-2.0, -2.0], [3.0, -2.0], [3.0, 3.0], [-2.0, 3.0]].map(|[x, y]| scene.node([x, y, 0.0]));
                scene.shell(1, &plate);
                let corners = [[0.0, 0.0, arm], [1.0, 0.0, arm], [1.0, 1.0, arm], [0.0, 1.0, arm]];
                let nodes = corners.map(|x| scene.node(x));
                match element {
                    "c0_triangle" => {
                        [[0, 1, 2], [0, 2, 3]].iter().for_each(|t| scene.shell(2, &t.map(|c: usize| nodes[c])))
                    }
                    _ => scene.shell(2, &nodes),
                }
                scene.part(1, "belytschko_tsay", 0.02);
                scene.part(2, element, 0.01);
                scene.rest +=
                    &format!("[[tie]]\nnodes = \"edge\"\nparts = [1]\noffset = true\ntolerance = {:?}\n", 2.0 * arm);
                scene.model(&[("edge", &nodes[..2])], 0.3, safety, 1500)
            };
            let limit = limit(of);
            assert!(limit > 0.98, "{element}, arm {arm}: {limit}");
        }
    }
}
