//! Line elements: beams that vibrate and yield (A34), springs and dampers (A35).

use super::bars::BAR;
use super::measure::{Crossings, displacement};
use super::row::CheckRow;
use super::scene::Scene;
use super::{Bench, Check};
use std::f64::consts::TAU;

/// Check of A34, elastic.
pub const SWING: Check = Check { name: "cantilever of beams", quick: true, run: swing };
/// Check of A34, plastic.
pub const HINGE: Check = Check { name: "plastic hinge", quick: false, run: hinge };
/// Check of A35.
pub const OSCILLATOR: Check =
    Check { name: "mass on spring and damper", quick: true, run: oscillator };

/// Cantilever of A15: length, width and depth [m].
const SIZE: [f64; 3] = [0.2, 0.02, 0.004];

/// Adds `n` beams from the origin along x, the second axis of the section along z; returns their
/// nodes.
fn cantilever(scene: &mut Scene, n: usize, keys: &str) -> Vec<u32> {
    let [length, width, depth] = SIZE;
    let nodes: Vec<u32> =
        (0..=n).map(|i| scene.node([length * i as f64 / n as f64, 0.0, 0.0])).collect();
    let up = scene.node([0.0, 0.0, length]);
    nodes.windows(2).for_each(|pair| scene.beam(1, [pair[0], pair[1], up]));
    scene.add(&format!(
        "[[part]]\nid = 1\nmaterial = \"steel\"\n[part.beam]\nsection = \"rectangle\"\n\
         height = {depth:?}\nwidth = {width:?}\n{keys}"
    ));
    scene.fix(&nodes[..1], "x y z rx ry rz");
    nodes
}

fn swing(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    // The static shape under a force at the tip is close to the first mode but not orthogonal to
    // any other: means over four periods.
    for n in [10, 20] {
        let f = 83.55;
        let mut scene = Scene::new(4.3 / f);
        scene.elastic("steel", BAR);
        let nodes = cantilever(&mut scene, n, "");
        for &node in &nodes[1..] {
            let x = scene.at(node)[0] / SIZE[0];
            let slope = (3.0 * x - 1.5 * x * x) / SIZE[0];
            scene.start(
                &[node],
                [0.0, 0.0, 0.01 * 0.5 * x * x * (3.0 - x)],
                [0.0, -0.01 * slope, 0.0],
            );
        }
        let mut crossings = Crossings::default();
        let run = bench.watch(&format!("A34 swing {n}"), &scene, |e| {
            crossings.add_sample(e.clock.time, displacement(e, nodes[n])[2]);
        })?;
        let variant = format!("{n} beams");
        let row = CheckRow::new("cantilever, frequency 1", &variant, "Hz", crossings.frequency());
        // Lumped masses: second order in the mesh.
        const D: &str = "[D] Euler-Bernoulli, catalogue A15";
        all.push(if n == 20 { row.near(f, 0.01, D) } else { row.reference(f, D) });
        all.push(run.closing_row(&variant, 1e-3));
    }
    Ok(all)
}

/// Prescribes a slow downward motion of the tip: beyond the elastic limit the moment at the root
/// is that of a plastic hinge.
fn hinge(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 20;
    let [length, width, depth] = SIZE;
    let yield_stress = 250e6;
    let moment = yield_stress * width * depth * depth / 4.0;
    // The elastic limit of the tip is 2 sigma L^2/(3 E h) = 8 mm; it moves to 30 mm in 15
    // periods of the cantilever.
    let (way, time) = (0.03, 15.0 / 83.55);
    let mut scene = Scene::new(time);
    scene.plastic("steel", BAR, yield_stress, 0.0);
    let nodes = cantilever(&mut scene, N, "");
    let tip = scene.set(&nodes[N..]);
    // The motion starts smoothly.
    scene.add(&format!(
        "[[curve]]\nname = \"start\"\npoints = [[0.0, 0.0], [{:?}, 1.0]]",
        0.2 * time
    ));
    let speed = way / (0.9 * time);
    scene.add(&format!(
        "[[motion]]\nnodes = \"{tip}\"\ndofs = [\"z\"]\nvelocity = [0.0, 0.0, {:?}]\n\
         curve = \"start\"",
        -speed
    ));
    let (mut first, mut last) = (None, (0.0, 0.0));
    let run = bench.watch("A34 hinge", &scene, |e| {
        let at = (
            -displacement(e, nodes[N])[2],
            e.ledger.energies(&e.nodes, &e.blocks).values().external,
        );
        if at.0 > 0.7 * way {
            first.get_or_insert(at);
        }
        last = at;
    })?;
    let (from, until) = (first.ok_or("A34 hinge: the run ended too early")?, last);
    // The work is that of the time before the last step: the displacement of one step is far
    // below the tolerance.
    let force = (until.1 - from.1) / (until.0 - from.0);
    let variant = format!("{N} beams, perfectly plastic, tip led to 0.15 L");
    // The arm of the force is the length minus the shortening of the bent cantilever, 3/5 w^2/L;
    // the hinge has the length of an element.
    let middle = 0.5 * (from.0 + until.0);
    let arm = length - 0.6 * middle * middle / length;
    let mut rows = vec![
        CheckRow::new(
            "force at the tip / (plastic moment / arm)",
            &variant,
            "",
            force * arm / moment,
        )
        .near(
            1.0,
            0.05,
            "[D] sigma_y b h^2/4; the one point of an element yields half an element from the \
                 root",
        ),
    ];
    rows.push(run.closing_row(&variant, 1e-3));
    Ok(rows)
}

fn oscillator(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] damped oscillator";
    let (k, m, v) = (1e6f64, 1.0f64, 1.0f64);
    let w = (k / m).sqrt();
    let mut all = Vec::new();
    for share in [0.0, 0.05, 0.3] {
        let damping = 2.0 * share * (k * m).sqrt();
        let periods = 10.0;
        let mut scene = Scene::new(periods * TAU / w);
        let nodes = [scene.node([0.0; 3]), scene.node([1.0, 0.0, 0.0])];
        scene.spring(1, nodes);
        scene.add(&format!(
            "[[part]]\nid = 1\n[part.spring]\nstiffness = {k:?}\ndamping = {damping:?}"
        ));
        scene.fix(&nodes[..1], "x y z");
        scene.mass(&nodes[1..], m);
        scene.start(&nodes[1..], [v, 0.0, 0.0], [0.0; 3]);
        // The damper lags by half a step: first order.
        scene.time(&format!("dt_max = {:?}", 0.003 / w));
        let mut crossings = Crossings::default();
        let mut largest = (0.0f64, 0.0f64);
        let free = w * (1.0 - share * share).sqrt();
        let run = bench.watch(&format!("A35 {share}"), &scene, |e| {
            let (t, u) = (e.clock.time, displacement(e, nodes[1])[0]);
            crossings.add_sample(t, u);
            if t < TAU / free {
                largest.0 = largest.0.max(u);
            } else if t < 2.0 * TAU / free {
                largest.1 = largest.1.max(u);
            }
        })?;
        let variant = format!("{share} of critical damping");
        let row = CheckRow::new("frequency", &variant, "Hz", crossings.frequency());
        all.push(row.near(free / TAU, 1e-3, D));
        let decrement = TAU * share / (1.0 - share * share).sqrt();
        let row = CheckRow::new("peak / the one before", &variant, "", largest.1 / largest.0);
        all.push(row.near((-decrement).exp(), 0.01, D));
        let peak = v / w
            * (-share / (1.0 - share * share).sqrt() * (1.0 - share * share).sqrt().atan2(share))
                .exp();
        all.push(CheckRow::new("first peak", &variant, "mm", 1e3 * largest.0).near(
            1e3 * peak,
            2e-3,
            D,
        ));
        all.push(run.closing_row(&variant, 1e-2));
    }
    Ok(all)
}
