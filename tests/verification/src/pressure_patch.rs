//! A22: two blocks pressed together. Uniform pressure on a free block gives uniform stress in
//! both, for any meshes.

use super::laws::Law;
use super::measure::fields;
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::{Bench, Check};

/// Check of A22.
pub const PATCH: Check = Check { name: "two stacked blocks of cubes", quick: true, run: patch };

const PRESSURE: f64 = 1e6;
const HEIGHT: f64 = 0.5;
const SWINGS: &str = "vibration of the blocks that remains after the damping";
const FEW: &str = "the default of 20 sweeps is too few for the coupling of nodes that share \
                   facets. The remaining error gives work to the bodies: 1.7e-5 of the energy with \
                   100 sweeps, 3.6e-4 with 20 sweeps at half the step";
const LOCAL: &str = "nodes press on segments at their own positions: on non-matching meshes the \
                     pressure is not uniform, as the catalogue expects of node-to-segment contact \
                     (5-30 %)";

fn patch(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const LAYERS: usize = 2;
    let mut all = Vec::new();
    for law in Law::all() {
        for (below, above) in [(4, 4), (3, 4), (4, 3)] {
            // A bar of 1 m oscillates at c/4L; with damping near that frequency the slowest mode
            // decays within a few periods.
            let period = 4.0 / STEEL.c();
            let mut scene = Scene::new(16.0 * period);
            let mut block = |part: u32, n: usize, from: f64| {
                scene.block(part, [n, n, LAYERS], |p| [p[0], p[1], from + HEIGHT * p[2]])
            };
            let (one, two) = (block(1, below, 0.0), block(2, above, HEIGHT));
            scene.elastic("steel", STEEL);
            (1..=2).for_each(|part| scene.solid_part(part, "steel", INVISCID));
            scene.fix(&one.layer(2, 0), "z");
            // Rollers: the sides x = 0 and y = 0 are planes of symmetry, the others are free.
            scene.symmetry([0.0; 3], [1.0, 0.0, 0.0]);
            scene.symmetry([0.0; 3], [0.0, 1.0, 0.0]);
            let top = scene.set(&two.last(2));
            scene.ramp(2.0 * period);
            scene.add(&format!(
                "[[pressure]]\nnodes = \"{top}\"\npressure = {PRESSURE:?}\ncurve = \"ramp\""
            ));
            scene.add(&law.table());
            scene.time(&format!("damping = {:?}", 2.0 * std::f64::consts::TAU / period));
            // The last step is cut short, which changes forces that depend on the step: stop
            // before it.
            let mut stresses = Vec::new();
            let run =
                bench.watch(&format!("A22 {} {below} under {above}", law.name), &scene, |e| {
                    if e.clock.time < 15.5 * period {
                        stresses = fields(e).iter().map(|f| f.stress[2]).collect();
                    }
                })?;
            // Elements are in columns of two. At the interface are the upper elements of the
            // lower block and the lower elements of the upper block.
            let (lower, upper): (&[f64], &[f64]) = stresses.split_at(below * below * LAYERS);
            let near = [&lower[LAYERS - 1..], upper]
                .map(|s| s.iter().copied().step_by(LAYERS).collect::<Vec<f64>>());
            let off = |s: f64| (s / PRESSURE + 1.0).abs();
            let worst = near.iter().flatten().fold(0.0f64, |m, &s| m.max(off(s)));
            let mean = off(near[0].iter().sum::<f64>() / near[0].len() as f64);
            let variant = format!("{}, {below} by {below} under {above} by {above}", law.name);
            let row =
                CheckRow::new("largest |sigma_z/p + 1| at the interface", &variant, "", worst);
            all.push(if below == above || law.by_segments() {
                row.at_most(1e-6, "exact; 1e-6 for the remaining vibration").known(SWINGS)
            } else {
                row.at_most(0.05, "catalogue: 1-5 % for weights that share").known(LOCAL)
            });
            all.push(run.given_row(&variant).known(FEW));
            let resultant = CheckRow::new("error of the resultant / (p A)", &variant, "", mean);
            all.push(resultant.at_most(1e-6, "limit of the catalogue").known(SWINGS));
        }
    }
    Ok(all)
}
