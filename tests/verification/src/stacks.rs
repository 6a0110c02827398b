//! Bodies on each other: two plates pressed together (C08), foam on steel (C02), a stack of
//! blocks, a block in a corner of walls (C15 b, c).

use super::laws::Law;
use super::measure::{contact_force, mass, mean_velocity, position};
use super::row::CheckRow;
use super::scene::{Elastic, Grid, STEEL, Scene};
use super::solid_bars::INVISCID;
use super::solids::Block;
use super::{Bench, Check};
use std::ops::ControlFlow;

/// Check of C08.
pub const PLATES: Check = Check { name: "two plates pressed together", quick: false, run: plates };
/// Check of C08: undamped.
pub const LONG: Check = Check { name: "two plates, 1e5 steps", quick: false, run: long };
/// Check of C02, foam on steel.
pub const FOAM: Check = Check { name: "foam on steel", quick: true, run: foam };
/// Check of C15 (b).
pub const STACK: Check = Check { name: "stack of blocks", quick: true, run: stack };
/// Check of C15 (c).
pub const CORNER: Check = Check { name: "corner of three walls", quick: true, run: corner };

const SWINGS: &str = "the forces of a contact at rest still oscillate from step to step";
/// Damping rate [1/s]. Contact forces at rest are too small by half of this in a step, here by a
/// few thousandths, because damping acts on the bodies but not on contact.
const DAMPING: f64 = 2e3;
/// Side, thickness and pressure of the plates of C08 [m], [Pa].
const SIDE: f64 = 0.1;
const THICKNESS: f64 = 2e-3;
const PRESSURE: f64 = 1e6;

/// Returns two plates of `n` by `n` shells, pressed from outside after a ramp; first the lower,
/// then the upper one.
fn pressed(law: &Law, [below, above]: [usize; 2], more: &str, end: f64) -> (Scene, [Grid; 2]) {
    let mut scene = Scene::new(end);
    let mut plate =
        |part: u32, n: usize, z: f64| scene.grid(part, [n, n], |x, y| [SIDE * x, SIDE * y, z]);
    let grids = [plate(1, below, 0.0), plate(2, above, THICKNESS + 1e-6)];
    scene.elastic("steel", STEEL);
    (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, ""));
    grids.iter().for_each(|g| scene.fix(g.all(), "x y rz"));
    scene.ramp(0.3e-3);
    for (part, sign) in [(1, -1.0), (2, 1.0)] {
        scene.add(&format!(
            "[[pressure]]\nparts = [{part}]\npressure = {:?}\ncurve = \"ramp\"",
            sign * PRESSURE
        ));
    }
    scene.add(&format!("{}{more}", law.table()));
    (scene, grids)
}

fn plates(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const CATALOGUE: &str = "limit of the catalogue";
    let mut all = Vec::new();
    for law in Law::ALL {
        for (n, more, how) in [
            ([6, 6], "", "coincident meshes"),
            ([5, 6], "", "5 by 5 below 6 by 6"),
            ([6, 6], "parts = [1, 2, 1, 2]", "coincident meshes, parts named twice"),
        ] {
            let (mut scene, [_, upper]) = pressed(law, n, more, 10e-3);
            scene.time(&format!("damping = {DAMPING:?}"));
            let variant = format!("{}, {how}", law.name);
            let mut means = vec![0.0; upper.all().len()];
            let (mut samples, mut least, mut most) = (0.0, f64::INFINITY, 0.0f64);
            let name = format!("C08 {} {how}", law.name);
            let run = bench.watch(&name, &scene, |e| {
                if e.clock.time > 8e-3 {
                    let forces = upper.all().iter().map(|&i| contact_force(e, &[i], 2));
                    means.iter_mut().zip(forces).for_each(|(m, f)| *m += f);
                    let sum = contact_force(e, upper.all(), 2);
                    (least, most, samples) = (least.min(sum), most.max(sum), samples + 1.0);
                }
            })?;
            let whole = PRESSURE * SIDE * SIDE;
            let resultant = means.iter().sum::<f64>() / samples;
            all.push(CheckRow::new("resultant", &variant, "kN", 1e-3 * resultant).near(
                1e-3 * whole,
                0.01,
                CATALOGUE,
            ));
            let swing = CheckRow::new(
                "swing of the resultant / resultant",
                &variant,
                "",
                0.5 * (most - least) / whole,
            );
            all.push(swing.at_most(0.01, CATALOGUE).known(SWINGS));
            let m = n[1];
            let share = |i: usize| if i == 0 || i == m { 0.5 } else { 1.0 };
            let off = |k: usize| {
                let own = whole / (m * m) as f64 * share(k / (m + 1)) * share(k % (m + 1));
                (means[k] / samples / own - 1.0).abs()
            };
            let worst = (0..means.len()).map(off).fold(0.0, f64::max);
            let row =
                CheckRow::new("largest |nodal force / p A of the node - 1|", &variant, "", worst);
            all.push(row.at_most(if n[0] == m { 0.01 } else { 0.2 }, CATALOGUE));
            all.push(run.given_row(&variant));
            let rest = run.energies.kinetic / run.energies.external.abs();
            all.push(
                CheckRow::new(
                    "kinetic energy / work of the pressure, at the end",
                    &variant,
                    "",
                    rest,
                )
                .at_most(
                    1e-3,
                    "limit of the catalogue, there over internal energy, which is zero here",
                ),
            );
        }
    }
    Ok(all)
}

fn long(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 4;
    let mut all = Vec::new();
    for law in Law::ALL {
        let (mut scene, grids) = pressed(law, [N, N], "", 1.0);
        scene.time("max_cycles = 100000");
        let mut most = 0.0f64;
        let run = bench.run(&format!("C08 long {}", law.name), &scene, |e| {
            if e.clock.time > 1e-3 {
                most = most.max(mean_velocity(e, grids[1].all(), 2).abs());
            }
            ControlFlow::Continue(())
        })?;
        let variant = format!("{}, coincident meshes, undamped", law.name);
        let work = run.energies.external.abs();
        let drift = if run.trouble {
            f64::INFINITY
        } else {
            run.energies.balance(run.initial).abs() / work
        };
        all.push(
            CheckRow::new("energy not accounted for after 1e5 steps / work", &variant, "", drift)
                .at_most(1e-3, "limit of the catalogue"),
        );
        all.push(run.given_row(&variant));
        // Scale: the speed that the full pressure gives a plate in the time of the ramp.
        let scale = PRESSURE * SIDE * SIDE / mass(&run.engine, grids[1].all()) * 0.3e-3;
        all.push(
            CheckRow::new(
                "largest speed of a plate afterwards / p A t/m",
                &variant,
                "",
                most / scale,
            )
            .at_most(1e-3, "[D] at rest; far below the speed from one unbalanced ramp"),
        );
    }
    Ok(all)
}

fn foam(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (side, cells, v) = (0.04, 4, 5.0);
    let light = Elastic { e: 1e6, nu: 0.0, rho: 50.0 };
    let time = 2.0 * side / light.c();
    let mut all = Vec::new();
    for law in Law::ALL {
        let mut scene = Scene::new(1.5 * time);
        let steel = scene.block(1, [3, 3, 1], |p| {
            [1.5 * side * (p[0] - 0.5), 1.5 * side * (p[1] - 0.5), 0.02 * (p[2] - 1.0)]
        });
        let block = scene.block(2, [cells; 3], |p| {
            [side * (p[0] - 0.5), side * (p[1] - 0.5), 1e-4 + side * p[2]]
        });
        scene.elastic("steel", STEEL);
        scene.elastic("foam", light);
        scene.solid_part(1, "steel", INVISCID);
        scene.solid_part(2, "foam", INVISCID);
        scene.fix(&steel.layer(2, 0), "x y z");
        scene.start(block.all(), [0.0, 0.0, -v], [0.0; 3]);
        scene.start(steel.all(), [0.0; 3], [0.0; 3]);
        scene.add(&law.table());
        let foot = block.layer(2, 0);
        let mut deepest = 0.0f64;
        let run = bench.watch(&format!("C02 foam {}", law.name), &scene, |e| {
            // The steel hardly moves: its upper side stays at zero.
            deepest = foot.iter().fold(deepest, |d, &n| d.max(-position(e, n)[2]));
        })?;
        let variant = format!("{}, foam of 1 MPa and 50 kg/m3 at 5 m/s on steel", law.name);
        let row = CheckRow::new(
            "largest penetration / side of a cell",
            &variant,
            "",
            deepest * cells as f64 / side,
        );
        all.push(row.at_most(0.05, "limit of the catalogue"));
        all.extend([run.given_row(&variant), run.hourglass_row(&variant)]);
        let share = CheckRow::new(
            "rebound / v",
            &variant,
            "",
            mean_velocity(&run.engine, block.all(), 2) / v,
        );
        all.push(
            share.reference(1.0, "[D] a bar without lateral strain, less the remaining vibration"),
        );
    }
    Ok(all)
}

fn stack(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const BLOCKS: usize = 5;
    let (side, g) = (0.01, 1e4);
    let height = BLOCKS as f64 * side;
    // A column of this height, fixed below, has a period of 4 h/c.
    let period = 4.0 * height / STEEL.c();
    let mut all = Vec::new();
    for law in Law::ALL {
        let mut scene = Scene::new(60.0 * period);
        let base = scene.block(1, [1; 3], |p| {
            [3.0 * side * (p[0] - 0.5), 3.0 * side * (p[1] - 0.5), side * (p[2] - 1.0)]
        });
        // From top to bottom.
        let blocks: Vec<Block> = (0..BLOCKS)
            .map(|i| {
                let from = height - (i + 1) as f64 * side;
                scene.block(2 + i as u32, [1; 3], |p| {
                    [side * (p[0] - 0.5), side * (p[1] - 0.5), from + side * p[2]]
                })
            })
            .collect();
        scene.elastic("steel", STEEL);
        (1..=BLOCKS as u32 + 1).for_each(|part| scene.solid_part(part, "steel", INVISCID));
        scene.fix(base.all(), "x y z");
        scene.ramp(5.0 * period);
        scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]\ncurve = \"ramp\"", -g));
        scene.add(&law.table());
        scene.time(&format!("damping = {:?}", 4.0 * DAMPING));
        let (mut sums, mut samples) = ([0.0; BLOCKS], 0.0);
        let (mut least, mut most) = ([f64::INFINITY; BLOCKS], [f64::NEG_INFINITY; BLOCKS]);
        let mut fastest = 0.0f64;
        let run = bench.watch(&format!("C15b {}", law.name), &scene, |e| {
            if e.clock.time > 40.0 * period && e.clock.time < 59.5 * period {
                let mut under = 0.0;
                for (i, block) in blocks.iter().enumerate() {
                    under += contact_force(e, block.all(), 2);
                    sums[i] += under;
                    (least[i], most[i]) = (least[i].min(under), most[i].max(under));
                    fastest = fastest.max(mean_velocity(e, block.all(), 2).abs());
                }
                samples += 1.0;
            }
        })?;
        let weight = STEEL.rho * side * side * side * g;
        let mut worst = 0.0f64;
        for i in 0..BLOCKS {
            let (number, variant) =
                ((i + 1) as f64, format!("{}, block {} from the top", law.name, i + 1));
            let row = CheckRow::new(
                "mean force under it / (m g)",
                &variant,
                "",
                sums[i] / samples / weight,
            );
            all.push(row.near(number, 0.01, "[D] i m g; limit of the catalogue"));
            worst = worst.max(0.5 * (most[i] - least[i]) / (number * weight));
        }
        let swing = CheckRow::new(
            "largest swing of these forces from step to step / themselves",
            law.name,
            "",
            worst,
        );
        all.push(swing.at_most(0.01, "limit of the catalogue").known(SWINGS));
        all.push(run.given_row(law.name));
        // Velocity that gravity gives in the period of the column.
        let row = CheckRow::new(
            "largest speed of a block / (g period)",
            law.name,
            "",
            fastest / (g * period),
        );
        all.push(row.at_most(1e-3, "[D] at rest"));
    }
    Ok(all)
}

fn corner(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (side, g) = (0.01, 1e4);
    let period = 4.0 * side / STEEL.c();
    let mut all = Vec::new();
    for friction in [0.0, 0.3] {
        let mut scene = Scene::new(300.0 * period);
        let block = scene.block(1, [2; 3], |p| p.map(|x| 1e-6 + side * x));
        scene.elastic("steel", STEEL);
        scene.solid_part(1, "steel", INVISCID);
        for c in 0..3 {
            scene.wall([0.0; 3], std::array::from_fn(|k| f64::from(u8::from(k == c))), friction);
        }
        scene.ramp(100.0 * period);
        scene.add(&format!("[[gravity]]\nacceleration = {:?}\ncurve = \"ramp\"", [-g; 3]));
        scene.time(&format!("damping = {:?}", 4.0 * DAMPING));
        let (mut from, mut fastest) = (None, 0.0f64);
        let run = bench.watch(&format!("C15c {friction}"), &scene, |e| {
            if e.clock.time > 200.0 * period {
                from.get_or_insert_with(|| (e.clock.time, e.constraints.walls.impulses.clone()));
                fastest =
                    (0..3).fold(fastest, |m, c| m.max(mean_velocity(e, block.all(), c).abs()));
            }
        })?;
        let (since, before) = from.ok_or("C15c: the run ended too early")?;
        let weight = STEEL.rho * side * side * side * g;
        let variant = format!("friction {friction}");
        let span = run.engine.clock.time - since;
        let reaction = |c: usize| -> f64 {
            let walls = run.engine.constraints.walls.impulses.iter().zip(&before);
            walls.map(|(now, then)| now[c].value() - then[c].value()).sum::<f64>() / span
        };
        all.push(run.given_row(&variant));
        for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let row = CheckRow::new(
                format!("reaction of the walls along {axis} / (m g)"),
                &variant,
                "",
                reaction(c) / weight,
            );
            all.push(row.near(1.0, 0.01, "[D] m g; limit of (b)"));
        }
        let row = CheckRow::new(
            "largest speed at rest / (g period)",
            &variant,
            "",
            fastest / (g * period),
        );
        all.push(row.at_most(1e-3, "[D] zero momentum, no jitter"));
    }
    Ok(all)
}
