//! Larger steps: mass scaling of colliding bodies (A39), subcycles (A40).

use super::bars::BAR;
use super::laws::UNDAMPED;
use super::measure::{displacement, mass, mean_velocity};
use super::row::CheckRow;
use super::scene::{Grid, Scene};
use super::{Bench, Check};

/// Check of A39.
pub const SCALED: Check = Check { name: "bars with added mass, head-on", quick: true, run: scaled };
/// Check of A40.
pub const SUBCYCLES: Check =
    Check { name: "bar with short shells, 1 and 4 subcycles", quick: true, run: subcycles };

const LENGTH: f64 = 1.0;
const THICKNESS: f64 = 1e-3;

/// Adds a strip of `n` cells along x from `from`; the cells in `short` are a fifth as long as
/// the others.
fn strip(
    scene: &mut Scene,
    part: u32,
    n: usize,
    short: std::ops::Range<usize>,
    from: f64,
    width: f64,
) -> Grid {
    let lengths: Vec<f64> = (0..n).map(|i| if short.contains(&i) { 0.2 } else { 1.0 }).collect();
    let whole: f64 = lengths.iter().sum();
    let ends: Vec<f64> = std::iter::once(0.0)
        .chain(lengths.iter().scan(0.0, |sum, l| {
            *sum += l;
            Some(*sum)
        }))
        .collect();
    scene.grid(part, [n, 1], |x, y| {
        [from + LENGTH * ends[(x * n as f64).round() as usize] / whole, width * y, 0.0]
    })
}

fn scaled(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 40;
    const D: &str = "[D] two identical bars, mirror images of each other";
    let (v, width) = (10.0, LENGTH / 40.0);
    let mut all = Vec::new();
    for law in bench.laws() {
        let build = |scaling: Option<f64>| {
            let mut scene = Scene::new(3.2 * LENGTH / BAR.c());
            // The short cells are near the colliding ends, where added mass has the largest
            // effect. The second bar is the mirror image of the first one.
            let one = strip(&mut scene, 1, N, N - 6..N - 2, 0.0, width);
            let two = strip(&mut scene, 2, N, 2..6, LENGTH + THICKNESS + 1e-6, width);
            scene.elastic("steel", BAR);
            (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, "points = 2"));
            scene.start(one.all(), [v, 0.0, 0.0], [0.0; 3]);
            scene.start(two.all(), [0.0; 3], [0.0; 3]);
            scene.add(&format!("[contact]\nlaw = \"{law}\"\n{UNDAMPED}"));
            if let Some(dt) = scaling {
                scene.time(&format!("mass_scaling_dt = {dt:?}\nmass_scaling_limit = 1.0"));
            }
            (scene, [one, two])
        };
        let (plain, bars) = build(None);
        let natural = bench.model(&format!("A39 {law} natural"), &plain)?.first_dt().0 / 0.9;
        let wanted = 2.0 * natural;
        let (scene, _) = build(Some(wanted));
        let model = bench.model(&format!("A39 {law}"), &scene)?;
        let said = model.scaled_mass();
        let own = 2.0 * BAR.rho * LENGTH * width * THICKNESS;
        let run = bench.watch(&format!("A39 {law} run"), &scene, |_| {})?;
        let variant = format!("{law}, bars of {N} shells, four short ones, twice their step");
        let nodes: Vec<u32> = bars.iter().flat_map(|b| b.all().to_vec()).collect();
        let carried = mass(&run.engine, &nodes) - own;
        all.push(
            CheckRow::new("step / that without", &variant, "", model.first_dt().0 / 0.9 / natural)
                .near(2.0, 0.01, "the value in the job"),
        );
        all.push(
            CheckRow::new(
                "mass said to be added / mass of the nodes beyond their own",
                &variant,
                "",
                said / carried,
            )
            .near(1.0, 1e-9, "exact"),
        );
        all.push(
            CheckRow::new("mass added / mass", &variant, "", said / own)
                .at_least(1e-3, "mass is added"),
        );
        let scale = mass(&run.engine, bars[0].all()) * v;
        all.push(
            CheckRow::new("change of momentum / m v", &variant, "", run.momentum_drift(0, scale))
                .at_most(1e-10, "exact"),
        );
        let after = [0, 1].map(|b| mean_velocity(&run.engine, bars[b].all(), 0));
        // The tolerance covers the oscillation of 40 cells, as for 50 cubes in A01, and the
        // springs of the penalty.
        all.push(CheckRow::new("velocity of bar 1 after", &variant, "m/s", after[0]).within(
            0.0,
            0.03 * v,
            D,
        ));
        all.push(CheckRow::new("velocity of bar 2 after", &variant, "m/s", after[1]).within(
            v,
            0.03 * v,
            D,
        ));
        all.push(run.given_row(&variant));
    }
    Ok(all)
}

/// Compares `subcycles` 1 and 4 for a bar whose middle cells are a fifth as long. It is held at
/// one end, under a step traction at the other, as in A05.
fn subcycles(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 60;
    const D: &str = "[D] one-dimensional wave theory; 1 % for the dispersion of the front on 60 \
                     cells, twice as much for the return";
    let (stress, width) = (100e6, LENGTH / 60.0);
    let time = LENGTH / BAR.c();
    let mut all = Vec::new();
    let mut peaks = Vec::new();
    for subcycles in [1, 4] {
        let mut scene = Scene::new(7.8 * time);
        let bar = strip(&mut scene, 1, N, 26..34, 0.0, width);
        scene.elastic("steel", BAR);
        scene.part(1, "steel", THICKNESS, "points = 2");
        scene.fix(&bar.row(0), "x y z rx ry rz");
        let end = scene.set(&bar.row(N));
        let force = stress * width * THICKNESS;
        scene.add(&format!("[[load]]\nnodes = \"{end}\"\nforce = [{force:?}, 0.0, 0.0]"));
        scene.time(&format!("subcycles = {subcycles}"));
        let (mut far, mut near, mut sum, mut samples) = (0.0f64, f64::INFINITY, 0.0, 0.0);
        let run = bench.watch(&format!("A40 {subcycles}"), &scene, |e| {
            let u = displacement(e, bar.at(N, 0))[0];
            far = far.max(u);
            if e.clock.time > 3.0 * time {
                near = near.min(u);
            }
            if e.clock.time < 4.0 * time {
                (sum, samples) = (sum + u * e.clock.last_dt, samples + e.clock.last_dt);
            }
        })?;
        let variant = format!("{N} shells, 8 of a fifth, {subcycles} subcycles");
        let peak = 2.0 * stress * LENGTH / BAR.e;
        all.push(
            CheckRow::new(
                "largest displacement of the end / (2 sigma L/E)",
                &variant,
                "",
                far / peak,
            )
            .near(1.0, 0.01, D),
        );
        all.push(
            CheckRow::new(
                "mean over a period / (sigma L/E)",
                &variant,
                "",
                sum / samples / (0.5 * peak),
            )
            .near(1.0, 0.01, D),
        );
        all.push(
            CheckRow::new("return after a period / (2 sigma L/E)", &variant, "", near / peak)
                .within(0.0, 0.02, D),
        );
        // At the end only: earlier the fraction is large while there is hardly any work and the
        // slow elements have not reacted.
        let open = run.energies.balance(run.initial).abs() / run.came_in;
        all.push(
            CheckRow::new("energy not accounted for at the end", &variant, "", open)
                .at_most(1e-2, "limit of the catalogue"),
        );
        peaks.push([far / peak, sum / samples / (0.5 * peak)]);
    }
    for (k, what) in ["largest displacement", "mean displacement"].into_iter().enumerate() {
        let row = CheckRow::new(
            format!("{what}, 4 subcycles / 1"),
            format!("{N} shells, 8 of a fifth"),
            "",
            peaks[1][k] / peaks[0][k],
        );
        all.push(row.near(1.0, 5e-3, "[D] the same bar; half of the bound for the mesh"));
    }
    Ok(all)
}
