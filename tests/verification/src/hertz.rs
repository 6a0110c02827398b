//! A10 (b): a steel cylinder pressed on a rigid plane, in plane strain.

use super::laws::Law;
use super::measure::{contact_force, position};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::{Bench, Check};
use crumple_cases::graded;
use std::f64::consts::PI;

/// Check of A10 (b).
pub const CYLINDER: Check =
    Check { name: "cylinder on a rigid plane", quick: false, run: cylinder };

const YIELDING: &str = "penalty springs are compliant in addition to the cells: the contact is \
                        wider and the pressure lower, less so on a finer mesh. Experiment: half \
                        the step permits stiffer springs. With 1, 4 and 16 times the default \
                        stiffness of law penalty, the half width is off by +5.2, +1.1 and -0.7 %, \
                        the pressure by -6.6, -1.8 and -0.2 %; the Lagrange law has -0.9 and +0.3 \
                        %. Mortar: +4.8, +1.1 and -0.7 %, and -6.7, -1.8 and -0.2 %. The form \
                        `stiffness` is limited by the step: at half the step penalty has -1.5 and \
                        +0.2 % at the same scale, mortar +3.9 and -5.3 %, with four times the \
                        scale 0.0 and -1.2 %";
const RADIUS: f64 = 0.01;
/// Line load [N/m].
const LOAD: f64 = 1e6;

/// Duration of a run [s].
const END: f64 = 120e-6;

/// Half of the cylinder on the plane.
struct Pressed {
    scene: Scene,
    /// Both nodes at each position along the contact.
    foot: Vec<[u32; 2]>,
    /// Depth of the slice [m].
    deep: f64,
}

impl Pressed {
    /// Builds the scene with a number of cells on half of the expected width of the contact [m].
    fn new(law: &Law, cells: usize, width: f64) -> Self {
        // Half of the cylinder by symmetry; twenty half widths of contact replace all of it.
        let (first, size) = (width / cells as f64, 20.0 * width);
        let along = graded(first, 3 * cells / 2, size);
        let up = graded(first, 1, size);
        let deep = 2.0 * first;
        let index =
            |p: f64, places: &[f64]| places[(p * (places.len() - 1) as f64).round() as usize];
        // Contact and modes of the block: a period of about 15 us.
        let (ramp, omega) = (40e-6, 4.5e5);
        let mut scene = Scene::new(END);
        let block = scene.block(1, [along.len() - 1, 1, up.len() - 1], |[x, y, z]| {
            let (x, z) = (index(x, &along), index(z, &up) / size);
            let low = RADIUS - (RADIUS * RADIUS - x * x).sqrt();
            [x, deep * y, low + (size - low) * z]
        });
        // Cells of the plane are slightly larger, and none of its lines coincides with a line of
        // the block.
        let coarse = 1.3 * first;
        let count = (2.5 * width / coarse).ceil() as usize;
        let base = scene.block(2, [count, 1, 1], |[x, y, z]| {
            [coarse * (count as f64 * x - 0.4), deep * (2.0 * y - 0.5), coarse * (z - 1.0)]
        });
        scene.elastic("steel", STEEL);
        (1..=2).for_each(|part| scene.solid_part(part, "steel", INVISCID));
        scene.fix(base.all(), "x y z");
        scene.fix(block.all(), "y");
        scene.fix(&block.layer(0, 0), "x");
        scene.ramp(ramp);
        scene.press(&block.last(2), 0.5 * LOAD / size);
        scene.time(&format!("damping = {:?}", 2.0 * omega));
        scene.add(&law.table());
        let foot = (0..along.len()).map(|i| [block.at([i, 0, 0]), block.at([i, 1, 0])]).collect();
        Self { scene, foot, deep }
    }
}

/// Fits p^2 = p0^2 (1 - x^2/b^2) to the pressures at the nodes above a fifth of the largest.
/// Returns p0^2 and -p0^2/b^2 from places [m] and forces per depth [N/m].
fn fit_pressure(places: &[f64], forces: &[f64]) -> [f64; 2] {
    let mut at = Vec::new();
    for i in 0..places.len() - 1 {
        let left = if i == 0 { 0.0 } else { 0.5 * (places[i] - places[i - 1]) };
        at.push((
            places[i].powi(2),
            (forces[i] / (left + 0.5 * (places[i + 1] - places[i]))).powi(2),
        ));
    }
    let most = at.iter().map(|a| a.1).fold(0.0, f64::max);
    at.retain(|a| a.1 > 0.04 * most);
    let n = at.len() as f64;
    let [x, y] = [at.iter().map(|a| a.0).sum::<f64>() / n, at.iter().map(|a| a.1).sum::<f64>() / n];
    let slope = at.iter().map(|a| (a.0 - x) * (a.1 - y)).sum::<f64>()
        / at.iter().map(|a| (a.0 - x).powi(2)).sum::<f64>();
    [y - slope * x, slope]
}

fn cylinder(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] Hertz, plane strain, at the applied load";
    let stiff = STEEL.e / (1.0 - STEEL.nu * STEEL.nu);
    let width = (4.0 * LOAD * RADIUS / (PI * stiff)).sqrt();
    let peak = 2.0 * LOAD / (PI * width);
    let mut all = Vec::new();
    for law in Law::all() {
        for cells in [4, 8] {
            let Pressed { scene, foot, deep } = Pressed::new(law, cells, width);
            let mut forces = vec![0.0; foot.len()];
            let mut samples = 0.0;
            let run = bench.watch(&format!("A10 {} {cells}", law.name), &scene, |e| {
                if e.clock.time > 0.8 * END {
                    forces
                        .iter_mut()
                        .zip(&foot)
                        .for_each(|(f, pair)| *f += contact_force(e, pair, 2));
                    samples += 1.0;
                }
            })?;
            forces.iter_mut().for_each(|f| *f /= samples * deep);
            let felt = 2.0 * forces.iter().sum::<f64>();
            let places: Vec<f64> = foot.iter().map(|n| position(&run.engine, n[0])[0]).collect();
            let [square, slope] = fit_pressure(&places, &forces);
            let variant = format!("{}, {cells} cells on the half width", law.name);
            all.push(run.given_row(&variant));
            all.push(CheckRow::new("force", &variant, "kN/m", 1e-3 * felt).near(
                1e-3 * LOAD,
                0.01,
                "[D] the load",
            ));
            let half = CheckRow::new(
                "half width of the contact",
                &variant,
                "mm",
                1e3 * (square / -slope).sqrt(),
            );
            let top =
                CheckRow::new("largest pressure, fitted", &variant, "GPa", 1e-9 * square.sqrt());
            if cells < 8 {
                all.push(half.reference(1e3 * width, D));
                all.push(top.reference(1e-9 * peak, D));
            } else {
                let known = if law.is_spring() { YIELDING } else { "" };
                all.push(half.near(1e3 * width, 0.02, D).known(known));
                all.push(top.near(1e-9 * peak, 0.03, D).known(known));
            }
        }
    }
    Ok(all)
}
