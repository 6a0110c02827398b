//! Coupons of composites compared with laminate theory, and the same bits on any number of workers.
//! Units mm, ms, kg, so kN, GPa and J.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;

const EA: f64 = 165.0;
const EB: f64 = 9.0;
const XT: f64 = 2.56;
const YT: f64 = 0.073;
const LENGTH: f64 = 20.0;
const WIDTH: f64 = 10.0;
/// Thickness of a layer.
const LAYER: f64 = 0.25;

/// A coupon of plies without contraction, [0/90/90/0] to the axis x, that is pulled along x at
/// 1 mm/ms. `more` are further keys of the material, `part` those of the part.
fn coupon(end_time: f64, more: &str, part: &str) -> Model {
    let mut scene = Scene::default();
    let grid = scene.grid(1, [8, 4], |x, y| [LENGTH * x, WIDTH * y, 0.0]);
    scene.set_named("held", &grid.row(0));
    scene.set_named("pulled", &grid.row(8));
    let all: Vec<u32> = (1..=scene.count()).collect();
    scene.set_named("all", &all);
    let layers: String = [0.0, 90.0, 90.0, 0.0]
        .map(|angle| format!("{{ thickness = {LAYER}, angle = {angle:?}, points = 1 }},"))
        .concat();
    let text = format!(
        "end_time = {end_time:?}\n{}[output]\nfield_interval = -1.0\n[[material]]\nname = \"ply\"\n\
         law = \"orthotropic\"\ndensity = 1.58e-6\nyoungs_modulus = {EA}\nyoungs_modulus_b = {EB}\n\
         poisson = 0.0\nshear_modulus = 5.6\nstrength_tension_a = {XT}\nstrength_tension_b = {YT}\n\
         {more}\n[[part]]\nid = 1\nmaterial = \"ply\"\nlayer = [{layers}]\n{part}\n\
         [[fix]]\nnodes = \"held\"\ndofs = [\"x\"]\n\
         [[fix]]\nnodes = \"all\"\ndofs = [\"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[motion]]\nnodes = \"pulled\"\ndofs = [\"x\"]\nvelocity = [1.0, 0.0, 0.0]\n",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

fn internal(e: &Engine) -> f64 {
    e.ledger.energies(&e.nodes, &e.blocks).values().internal
}

/// Work of stress per volume of the plies along x up to a strain: elastic, and those across x at
/// their strength.
fn work(strain: f64) -> f64 {
    let across = if strain < YT / EB {
        0.5 * EB * strain * strain
    } else {
        YT * strain - 0.5 * YT * YT / EB
    };
    0.5 * (0.5 * EA * strain * strain + across)
}

/// The work up to just before the fibres break is that of laminate theory, with the plies across at
/// their strength. The end moves at 1/6000 of the speed of waves, which bounds the kinetic energy.
#[test]
fn a_coupon_takes_the_work_of_laminate_theory() {
    for element in ["stabilised_quad", "belytschko_tsay", "fully_integrated_quad"] {
        let breaks = LENGTH * XT / EA;
        let model = coupon(0.9 * breaks, "", &format!("element = \"{element}\""));
        assert_eq!(model.job.part[0].thickness, 4.0 * LAYER);
        let end = run_alone(&model, |_| {});
        // Logarithmic strain of the mid-step configuration; the volume is that of the start.
        let strain = (end.nodes.x.iter().map(|x| x[0]).fold(0.0, f64::max) / LENGTH).ln();
        let volume = 4.0 * LAYER * LENGTH * WIDTH;
        let (got, wanted) = (internal(&end), volume * work(strain));
        assert!((got / wanted - 1.0).abs() < 0.02, "{element}: {got} J, not {wanted} J");
        assert!(end.blocks.elements.iter().all(|e| !e.record.failed), "{element}");
    }
}

/// At X_T the fibres along x break, while the plies across keep the elements; they go at the strain
/// of failure along their axis a or b.
#[test]
fn elements_leave_when_all_their_layers_have_failed() {
    let beyond = 1.5 * LENGTH * XT / EA;
    let kept = run_alone(&coupon(beyond, "", ""), |_| {});
    assert!(kept.blocks.elements.iter().all(|e| !e.record.failed));
    let gone = run_alone(&coupon(beyond, "failure_strain_b = 0.018", ""), |_| {});
    assert!(gone.blocks.elements.iter().any(|e| e.record.failed));
}

#[test]
fn one_digest_on_any_workers() {
    let model = coupon(1.5 * LENGTH * XT / EA, "failure_strain_b = 0.018", "");
    let serial = run_side_by_side(&model, 1, 1500, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (3, 0), (3, 11)] {
        let parallel = run_side_by_side(&model, workers, 1500, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
