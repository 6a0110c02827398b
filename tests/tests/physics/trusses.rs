//! Trusses compared with closed forms, and the same bits on any number of workers. Units mm, ms,
//! kg.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
const AREA: f64 = 8.0;

/// Returns the model of a scene whose trusses are part 1; `law` are further keys of its material,
/// `rest` those of the job.
fn model(scene: &Scene, law: &str, end_time: f64, rest: &str) -> Model {
    let text = format!(
        "end_time = {end_time:?}\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"steel\"\ndensity = {RHO:?}\nyoungs_modulus = {E:?}\npoisson = 0.3\n\
         {law}\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\n[part.truss]\narea = {AREA:?}\n{rest}",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

const ELASTIC: &str = "law = \"elastic\"";

/// Returns the axial stress of a truss along x, by its index [force/length^2].
fn stress(e: &Engine, index: usize) -> f64 {
    let b = &e.blocks.blocks[0];
    let x = e.blocks.elements[b.first + index].nodes.map(|n| {
        let [x, y, z, _] = e.nodes.x[n as usize];
        [x, y, z]
    });
    b.element.fields(b.state(index), &x).stress[0]
}

/// Two bars meet at 45 degrees; a load P at the joint moves it by `P L / (2 E A cos^2 45)` along
/// itself. With 1e-4 of the length, the error of small displacements is 1e-4.
#[test]
fn two_bars_bear_a_load_as_in_the_textbook() {
    let mut scene = Scene::default();
    let ends = [[-100.0, 100.0, 0.0], [100.0, 100.0, 0.0]].map(|x| scene.node(x));
    let joint = scene.node([0.0; 3]);
    ends.iter().for_each(|&end| scene.truss(1, [end, joint]));
    scene.set_named("ends", &ends);
    scene.set_named("joint", &[joint]);
    let length = 100.0 * 2.0f64.sqrt();
    let down = 1e-4 * length;
    let load = down * 2.0 * E * AREA * 0.5 / length;
    let w = (E * AREA / length / (RHO * AREA * length)).sqrt();
    let rest = format!(
        "[time]\ndamping = {:?}\n[[fix]]\nnodes = \"ends\"\ndofs = [\"x\", \"y\", \"z\"]\n\
         [[load]]\nnodes = \"joint\"\nforce = [0.0, {:?}, 0.0]\n",
        2.0 * w,
        -load
    );
    let model = model(&scene, ELASTIC, 40.0 / w, &rest);
    assert!(!model.settings.rotations, "trusses have no rotations");
    let end = run_alone(&model, |_| {});
    let y = end.nodes.x[joint as usize - 1][1];
    assert!((-y / down - 1.0).abs() < 2e-4, "{y} {down}");
    let energy = end.ledger.energies(&end.nodes, &end.blocks).values().internal;
    assert!((energy / (0.5 * load * down) - 1.0).abs() < 1e-3, "{energy}");
}

/// A front runs along a row of trusses with `c = sqrt(E/rho)` and the stress `rho c v` behind it
/// (Graff 1975, ch. 2). Central differences with lumped masses spread the front over a few of the
/// 200 trusses and oscillate behind it: the mean over 40 trusses is taken, within 1 %.
#[test]
fn a_front_runs_along_a_row_with_the_speed_of_a_bar() {
    let (n, length, v) = (200, 400.0, 5.0);
    let c = (E / RHO).sqrt();
    let mut scene = Scene::default();
    let nodes: Vec<u32> =
        (0..=n).map(|i| scene.node([length * i as f64 / n as f64, 0.0, 0.0])).collect();
    nodes.windows(2).for_each(|ends| scene.truss(1, [ends[0], ends[1]]));
    scene.set_named("start", &nodes[..1]);
    let rest =
        format!("[[motion]]\nnodes = \"start\"\ndofs = [\"x\"]\nvelocity = [{v:?}, 0.0, 0.0]\n");
    let end = run_alone(&model(&scene, ELASTIC, 0.5 * length / c, &rest), |_| {});
    let mean = (20..60).map(|i| stress(&end, i)).sum::<f64>() / 40.0;
    assert!((-mean / (RHO * c * v) - 1.0).abs() < 0.01, "{mean} {}", RHO * c * v);
    let front = (0..n).find(|&i| -stress(&end, i) < 0.5 * RHO * c * v).unwrap();
    assert!((front as f64 - 100.0).abs() < 3.0, "front in truss {front}, time {}", end.clock.time);
}

/// A truss is pulled slowly beyond yield and back: the stress is `s_y + H e_p` with the plastic
/// modulus H, and the plastic work is that of the closed form. The strain is 2 %. The end moves at
/// 0.2 mm/ms; its waves of `rho c v` are 3e-5 of the yield stress.
#[test]
fn a_truss_yields_along_its_law() {
    let mut scene = Scene::default();
    let nodes = [0.0, 50.0].map(|x| scene.node([x, 0.0, 0.0]));
    scene.truss(1, nodes);
    scene.set_named("root", &nodes[..1]);
    scene.set_named("tip", &nodes[1..]);
    let law = "law = \"j2\"\nyield_stress = 0.3\nhardening_modulus = 2.0";
    let rest = "[[fix]]\nnodes = \"root\"\ndofs = [\"x\", \"y\", \"z\"]\n[[motion]]\n\
                nodes = \"tip\"\ndofs = [\"x\"]\nvelocity = [0.2, 0.0, 0.0]\n";
    let end = run_alone(&model(&scene, law, 5.0, rest), |_| {});
    // The last stress is that before the last step.
    let strain = (end.nodes.x[1][0] - 0.2 * end.clock.last_dt) / 50.0 - 1.0;
    let plastic = (strain - 0.3 / E) / (1.0 + 2.0 / E);
    let exact = 0.3 + 2.0 * plastic;
    assert!((stress(&end, 0) / exact - 1.0).abs() < 1e-4, "{} {exact}", stress(&end, 0));
    let work = 0.5 * exact * exact / E + 0.3 * plastic + plastic * plastic;
    let energy = end.ledger.energies(&end.nodes, &end.blocks).values().internal / (AREA * 50.0);
    assert!((energy / work - 1.0).abs() < 2e-3, "{energy} {work}");
}

/// A net of trusses falls on a plate and rebounds: its nodes and lines touch with a radius. The
/// bits are the same on 1, 2 and 3 workers with forced renewals; momentum is conserved.
#[test]
fn a_net_falls_on_a_plate_with_the_same_bits() {
    let mut scene = Scene::default();
    scene.lattice(2, [6, 6], |i, j| [10.0 * i as f64, 10.0 * j as f64, 0.0]);
    let net: Vec<u32> = (0..25)
        .map(|k| scene.node([13.0 + 7.0 * (k % 5) as f64, 14.0 + 7.0 * (k / 5) as f64, 2.8]))
        .collect();
    for k in 0..25 {
        if k % 5 < 4 {
            scene.truss(1, [net[k], net[k + 1]]);
        }
        if k < 20 {
            scene.truss(1, [net[k], net[k + 5]]);
        }
    }
    scene.set_named("net", &net);
    let rest = "contact_radius = 1.0\n[[part]]\nid = 2\nmaterial = \"steel\"\nthickness = 1.0\n\
                [[initial_velocity]]\nnodes = \"net\"\nvelocity = [3.0, 1.0, -20.0]\n[contact]\n\
                law = \"lagrange\"\nfriction = 0.2\n";
    let model = model(&scene, ELASTIC, 0.3, rest);
    let (mut pairs, mut first) = (0, None);
    let alone = run_alone(&model, |e| {
        pairs = pairs.max(e.contact.as_ref().map_or(0, |c| c.owned_pairs().count()));
        first.get_or_insert_with(|| momentum(&e.nodes).0);
    });
    assert!(pairs > 10, "{pairs} pairs");
    let (before, after) = (first.unwrap(), momentum(&alone.nodes).0);
    for c in 0..3 {
        assert!((after[c] - before[c]).abs() < 1e-12 * before[2].abs(), "{before:?} {after:?}");
    }
    let serial = run_side_by_side(&model, 1, 300, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (3, 0), (2, 7), (3, 11)] {
        let parallel = run_side_by_side(&model, workers, 300, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
