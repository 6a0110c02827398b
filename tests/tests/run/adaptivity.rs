//! Shells that are divided where they bend: the same bits on any number of workers, with either
//! decomposition and after an interruption; what a division keeps; hanging nodes and nodes of
//! prescribed motion. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;

/// Tubes and plates that tumble into each other, with friction, and a tube with two levels of
/// divisions.
const TUMBLE: [&str; 4] = [
    "output.field_interval=-1.0",
    "contact.friction=0.2",
    "adaptivity.angle=1.0",
    "adaptivity.interval=0.05",
];
const TUBE: [&str; 5] = [
    "output.field_interval=-1.0",
    "scene.elements=4",
    "adaptivity.levels=2",
    "adaptivity.angle=2.0",
    "adaptivity.interval=0.05",
];

#[test]
fn divided_shells_give_the_same_bits_on_any_workers() {
    let rcb = "parallel.contact=\"rcb\"";
    for (name, sets, cycles) in [("tumble", &TUMBLE[..], 1500), ("tube-crush", &TUBE[..], 2500)] {
        let model = |more: &[&str]| read(&case(name), &[sets, more].concat());
        let serial = run_side_by_side(&model(&[]), 1, cycles, 0);
        let (before, after) = (model(&[]).mesh.nodes.len(), serial.nodes.len());
        assert!(after > 2 * before, "{name}: {before} nodes became {after}");
        let touching = serial.pairs.iter().filter(|pairs| pairs.len() > 10).count();
        assert!(name != "tumble" || touching > 100, "contact in {touching} cycles");
        for (workers, force_every, more) in
            [(2, 0, &[][..]), (3, 7, &[]), (5, 0, &[]), (3, 0, &[rcb])]
        {
            let parallel = run_side_by_side(&model(more), workers, cycles, force_every);
            let what = format!("{name}: {workers} workers, {more:?}");
            for (cycle, (a, b)) in serial.pairs.iter().zip(&parallel.pairs).enumerate() {
                assert_eq!(a, b, "{what}: pairs in cycle {cycle}");
            }
            assert_eq!(serial.digest(), parallel.digest(), "{what}");
        }
    }
}

#[test]
fn a_run_with_divided_shells_continues_with_the_same_bits() {
    let model = read(&case("tumble"), &TUMBLE);
    let cycles = 1200;
    let whole = run_side_by_side(&model, 1, cycles, 0);
    assert!(whole.nodes.len() > 2 * model.mesh.nodes.len(), "{} nodes", whole.nodes.len());
    // Before the first division, and after many.
    for (at, workers) in [(30, [2, 1]), (700, [3, 2]), (1000, [1, 4])] {
        let digest = run_interrupted(&model, Plan { at, cycles, workers });
        assert_eq!(digest, whole.digest(), "cycle {at}");
    }
}

/// Returns a strip of 16 square shells of side 4, bent as its end moves down.
fn strip(more: &[&str]) -> Model {
    let mut scene = Scene::default();
    let rows: Vec<[u32; 3]> = (0..=8)
        .map(|i| [0, 1, 2].map(|j| scene.node([4.0 * f64::from(i), 4.0 * f64::from(j), 0.0])))
        .collect();
    for ends in rows.windows(2) {
        for j in 0..2 {
            scene.shell(1, &[ends[0][j], ends[1][j], ends[1][j + 1], ends[0][j + 1]]);
        }
    }
    scene.set_named("root", &rows[0]);
    scene.set_named("tip", &rows[8]);
    let text = format!(
        "end_time = 0.6\n{}[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
         law = \"j2\"\ndensity = 7.85e-6\nyoungs_modulus = 207.0\npoisson = 0.3\n\
         yield_stress = 0.2\nhardening_modulus = 1.0\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[fix]]\nnodes = \"root\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[motion]]\nnodes = \"tip\"\ndofs = [\"z\"]\n\
         velocity = [0.0, 0.0, -20.0]\n\
         [adaptivity]\nangle = 3.0\nrings = 0\ninterval = 0.02\n",
        scene.mesh_text(),
    );
    model_of(&text, more)
}

/// The mass of the elements that are left and of the new ones is that of the mesh; the energy
/// balance goes on; a node in the middle of a side of a larger shell stays in the middle.
#[test]
fn a_division_keeps_mass_and_energy_and_hanging_nodes_in_their_places() {
    let model = strip(&[]);
    let mass = |e: &Engine| e.nodes.mass.iter().sum::<f64>();
    let (mut first, mut hung) = (None, 0);
    let end = run_alone(&model, |e| {
        let first = *first.get_or_insert(mass(e));
        assert!((mass(e) / first - 1.0).abs() < 1e-12, "{} of {first}", mass(e));
        let place = |id| {
            let i = e.nodes.local_index(id).unwrap() as usize;
            e.nodes.x[i]
        };
        for (node, side) in e.adaptivity.as_ref().unwrap().hanging() {
            hung += 1;
            let [a, b, m] = [side[0], side[1], node].map(place);
            let off = (0..3).map(|k| (m[k] - 0.5 * (a[k] + b[k])).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "node {node} is {off} off its side");
        }
    });
    let divided = end.adaptivity.as_ref().unwrap().divided();
    assert!((4..16).contains(&divided), "{divided} of 16 shells");
    assert!(hung > 100, "{hung}");
    assert_eq!(end.blocks.elements.len() as u64, 16 + 3 * divided);
    let energies = end.energies(true);
    let [internal, external] = [&energies.internal, &energies.external].map(|e| e.value());
    let error = energies.kinetic.value() + internal + energies.hourglass.value() - external;
    assert!(internal > 0.2 && error.abs() < 0.01 * internal, "{error} of {internal}");
}

/// The edge with the prescribed motion and the clamped edge stay straight and whole, also when
/// their shells are divided.
#[test]
fn new_nodes_of_constrained_edges_are_constrained() {
    let model = strip(&["adaptivity.rings=4"]);
    let end = run_alone(&model, |_| ());
    assert_eq!(end.adaptivity.as_ref().unwrap().divided(), 16, "all are divided");
    assert_eq!(end.nodes.local_count, 17 * 5);
    let nodes = &end.nodes;
    let (mut root, mut tip) = (0, 0);
    for i in 0..nodes.local_count {
        if nodes.x0[i][0] == 0.0 {
            root += 1;
            assert_eq!(nodes.x[i], nodes.x0[i], "a node of the root has moved");
        } else if nodes.x0[i][0] == 32.0 {
            tip += 1;
            assert!((nodes.x[i][2] + 12.0).abs() < 1e-9, "{}", nodes.x[i][2]);
        }
    }
    assert_eq!([root, tip], [5, 5]);
}

/// The angle of a strip bent over a known plastic strain: shells are divided where it is reached,
/// and nowhere if the limit is above it.
#[test]
fn shells_are_divided_from_the_given_angle_on() {
    let divided = |angle: &str| {
        let end = run_alone(&strip(&[angle]), |_| ());
        end.adaptivity.as_ref().unwrap().divided()
    };
    assert_eq!(divided("adaptivity.angle=170.0"), 0);
    let (few, many) = (divided("adaptivity.angle=8.0"), divided("adaptivity.angle=1.0"));
    assert!(0 < few && few < many, "{few} {many}");
}

/// All forms of four-node shells, with offsets and layers of points, in either precision.
#[test]
fn all_quads_can_be_divided() {
    for more in [
        "part.1.element=\"belytschko_tsay\"",
        "part.1.element=\"fully_integrated_quad\"",
        "part.1.offset=1.0",
        "elements.precision=\"single\"",
        "adaptivity.levels=3",
    ] {
        let end = run_alone(&strip(&[more]), |_| ());
        let divided = end.adaptivity.as_ref().unwrap().divided();
        assert!(divided >= 4, "{more}: {divided}");
        let energies = end.energies(true);
        let internal = energies.internal.value();
        let error = energies.kinetic.value() + internal + energies.hourglass.value()
            - energies.external.value();
        assert!(error.abs() < 0.01 * internal, "{more}: {error} of {internal}");
    }
}
