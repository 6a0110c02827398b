//! Sections of shells: thicknesses of single shells (A41), middle surfaces offset from the nodes
//! (A42).

use super::measure::{Crossings, displacement};
use super::row::CheckRow;
use super::scene::{Elastic, STEEL, Scene};
use super::{Bench, Check};
use std::f64::consts::TAU;

/// Check of A41.
pub const STEPPED: Check = Check { name: "bar of two thicknesses", quick: true, run: stepped };
/// Check of A42.
pub const PULLED: Check =
    Check { name: "strip pulled beside its middle", quick: true, run: pulled }; // words: allow

const FORMULATIONS: [&str; 3] = ["stabilised_quad", "belytschko_tsay", "fully_integrated_quad"];

/// Returns steel without transverse strain.
fn plain() -> Elastic {
    STEEL.with_nu(0.0)
}

/// Computes the first axial frequency of a bar that is held at one end. The half at the free end
/// is twice as thick as the half at the root. With areas A1 at the root and A2, halves of length
/// a and b = w/c: `tan^2(b a) = A1/A2` (Graff 1975, ch. 2, by continuity of displacement and
/// force).
fn stepped(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 40;
    let (half, thin) = (0.1, 1e-3);
    let angle = 0.5f64.sqrt().atan();
    let wanted = angle / half * plain().c() / TAU;
    let mut all = Vec::new();
    for element in FORMULATIONS {
        let mut scene = Scene::new(3.3 / wanted);
        scene.elastic("steel", plain());
        scene.part(1, "steel", thin, &format!("element = \"{element}\""));
        let side = 2.0 * half / N as f64;
        let grid = scene.grid(1, [N, 1], |x, y| [2.0 * half * x, side * y, 0.0]);
        (N / 2..N).for_each(|e| scene.thicken(e as u32 + 1, 2.0 * thin));
        scene.fix(grid.all(), "y z rx ry rz");
        scene.fix(&grid.row(0), "x");
        for i in 1..=N {
            let x = 2.0 * half * i as f64 / N as f64;
            let b = angle / half;
            // The other half continues from the middle: sin(b a) cos(b (2 a - x))/cos(b a).
            let shape =
                if x <= half { (b * x).sin() } else { angle.tan() * (b * (2.0 * half - x)).cos() };
            scene.start(&grid.row(i), [0.01 * shape, 0.0, 0.0], [0.0; 3]);
        }
        let mut crossings = Crossings::default();
        let run = bench.watch(&format!("A41 {element}"), &scene, |e| {
            crossings.add_sample(e.clock.time, displacement(e, grid.at(N, 0))[0]);
        })?;
        let variant = format!("{element}, {N} shells");
        all.push(CheckRow::new("frequency 1", &variant, "kHz", 1e-3 * crossings.frequency()).near(
            1e-3 * wanted,
            1e-3,
            "[D] tan^2(w a/c) = A1/A2; lumped masses on 20 shells per half",
        ));
        all.push(run.closing_row(&variant, 1e-3));
    }
    Ok(all)
}

/// Pulls a strip along its nodes, at the offset e from its middle, until it is at rest. Its tip
/// rises by `e (1 - 1/cosh k L)`, `k^2 = F/EI`, and turns by `e k tanh k L`, as a beam under
/// bending and tension (Timoshenko & Gere 1961, ch. 1).
fn pulled(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 10;
    let (length, width, thickness, force) = (0.1, 0.01, 2e-3, 400.0);
    let stiffness = plain().e * width * thickness * thickness * thickness / 12.0;
    let k = (force / stiffness).sqrt();
    let (kl, c) = (k * length, plain().c());
    // Frequency of the first mode without tension.
    let omega = 3.516 * thickness / 12f64.sqrt() * c / (length * length);
    let mut all = Vec::new();
    for (element, offset) in
        FORMULATIONS.into_iter().flat_map(|element| [(element, 1.0), (element, -0.5)])
    {
        let mut scene = Scene::new(12.0 / omega);
        scene.elastic("steel", plain());
        scene.part(1, "steel", thickness, &format!("element = \"{element}\"\noffset = {offset:?}"));
        let grid = scene.grid(1, [N, 1], |x, y| [length * x, width * y, 0.0]);
        scene.fix(&grid.row(0), "x y z rx ry rz");
        let tip = scene.set(&grid.row(N));
        scene.add(&format!("[[load]]\nnodes = \"{tip}\"\nforce = [{force:?}, 0.0, 0.0]"));
        scene.time(&format!("damping = {:?}", 2.0 * omega));
        let run = bench.watch(&format!("A42 {element} {offset}"), &scene, |_| {})?;
        let variant = format!("{element}, {N} shells, offset {offset}");
        let e = 0.5 * offset * thickness;
        let rise = e * (1.0 - 1.0 / kl.cosh());
        let found = displacement(&run.engine, grid.at(N, 0))[2];
        const D: &str = "[D] beam under an eccentric tensile force; one point per element has the \
                         mean curvature";
        all.push(CheckRow::new("rise of the tip", &variant, "mm", 1e3 * found).near(
            1e3 * rise,
            0.005,
            D,
        ));
    }
    Ok(all)
}
