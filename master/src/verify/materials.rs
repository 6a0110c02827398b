//! A27: J2 plasticity in plane stress, driven through a whole shell along strain paths of known outcome.

use super::measure::{fields, lead};
use super::row::Row;
use super::scene::{STEEL, Scene};
use super::{Bench, Check};
use crumple_worker::elements::ElementFields;
use std::ops::ControlFlow;

/// A27, uniaxial.
pub const UNIAXIAL: Check = Check { name: "uniaxial stress", quick: true, run: uniaxial };
/// A27, paths led in both directions.
pub const PATHS: Check = Check { name: "led strain paths", quick: true, run: paths };

const YIELD: f64 = 250e6;
const MODULUS: f64 = 1e9;
const SIDE: f64 = 0.01;

/// One shell whose logarithmic strains along x and y grow at the rates that `rates` gives, per run of 1 s, from the
/// time and the stress of a step ago. Calls `at` with the strains and the fields of the same time.
fn led(
    bench: &Bench,
    name: &str,
    modulus: f64,
    steps: f64,
    mut rates: impl FnMut(f64, f64, &ElementFields) -> [f64; 2],
    mut at: impl FnMut([f64; 2], &ElementFields),
) -> Result<(), String> {
    let scene = |end: f64| {
        let mut scene = Scene::new(end);
        let grid = scene.grid(1, [1, 1], |x, y| [SIDE * x, SIDE * y, 0.0]);
        scene.plastic("steel", STEEL, YIELD, modulus);
        scene.part(1, "steel", 1e-3, "");
        scene.fix(grid.all(), "x y z rx ry rz");
        (scene, grid)
    };
    let dt = bench.model(name, &scene(1.0).0)?.first_dt().0;
    let end = steps * dt;
    let (scene, grid) = scene(end);
    let mut strain = [0.0; 2];
    let run = bench.run(name, &scene, |e| {
        let (t, dt) = (e.clock.time, e.clock.last_dt);
        if dt > 0.0 {
            // Stress is still that of the time before, and so is the strain.
            let before = fields(e)[0];
            at(strain, &before);
            let rate = rates((t - dt) / end, dt / end, &before);
            let next: [f64; 2] = std::array::from_fn(|c| strain[c] + rate[c] * dt / end);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let pose = |s: [f64; 2]| ([SIDE * i as f64 * s[0].exp(), SIDE * j as f64 * s[1].exp(), 0.0], [0.0; 3]);
                lead(e, grid.at(i, j), pose(strain), pose(next));
            }
            strain = next;
        }
        ControlFlow::Continue(())
    })?;
    if run.trouble { Err(format!("{name} ended in trouble")) } else { Ok(()) }
}

fn uniaxial(bench: &Bench) -> Result<Vec<Row>, String> {
    // Where to begin: elastic, and once it yields without change of volume. The rest is corrected.
    let (mut across, mut yielded) = (-STEEL.nu * 0.05, false);
    let (mut last, mut worst, mut normal) = (([0.0; 2], ElementFields::default()), 0.0f64, 0.0f64);
    led(
        bench,
        "A27 uniaxial stress",
        MODULUS,
        20_000.0,
        |_, dt, f| {
            if !yielded && f.plastic_strain > 0.0 {
                (across, yielded) = (-0.5 * 0.05, true);
            }
            // The width follows so that it carries no stress.
            across -= 0.2 * f.stress[1] / (STEEL.e * dt);
            [0.05, across]
        },
        |strain, f| {
            if f.plastic_strain > 0.0 {
                worst = worst.max((f.von_mises - YIELD - MODULUS * f.plastic_strain).abs() / YIELD);
            }
            normal = normal.max(f.stress[2].abs() / YIELD);
            last = (strain, *f);
        },
    )?;
    let (strain, f) = last;
    let plastic = (STEEL.e * strain[0] - YIELD) / (STEEL.e + MODULUS);
    let variant = "j2, belytschko_tsay, 20000 steps";
    Ok(vec![
        Row::new("uniaxial stress at a strain of 5 %", variant, "MPa", 1e-6 * f.stress[0]).near(
            1e-6 * (YIELD + MODULUS * plastic),
            1e-6,
            "[D] 298.58 MPa at 0.05",
        ),
        Row::new("plastic strain there", variant, "", f.plastic_strain).near(plastic, 1e-6, "[D] 0.04858 at 0.05"),
        Row::new("largest distance from the yield surface / sigma_y", variant, "", worst)
            .at_most(1e-8, "limit of the catalogue"),
        Row::new("largest normal stress / sigma_y", variant, "", normal).at_most(1e-8, "limit of the catalogue"),
    ])
}

fn paths(bench: &Bench) -> Result<Vec<Row>, String> {
    let variant = "perfect j2, belytschko_tsay, 2000 steps";
    let end = |name: &str, along: [f64; 2]| -> Result<ElementFields, String> {
        let mut last = ElementFields::default();
        led(bench, &format!("A27 {name}"), 0.0, 2000.0, |_, _, _| along, |_, f| last = *f)?;
        Ok(last)
    };
    let shear = end("pure shear", [0.02, -0.02])?;
    let both = end("equibiaxial", [0.02, 0.02])?;
    let held = end("plane strain", [0.05, 0.0])?;
    let mut seen: Vec<(f64, f64)> = Vec::new();
    let there_and_back = |t: f64, _: f64, _: &ElementFields| if t < 0.5 { [0.02; 2] } else { [-0.001; 2] };
    led(bench, "A27 unloading", 0.0, 2000.0, there_and_back, |s, f| seen.push((s[0], f.stress[0])))?;
    let (from, to) = (seen[seen.len() * 6 / 10], seen[seen.len() - 1]);
    let slope = (to.1 - from.1) / (to.0 - from.0);
    let mpa = 1e-6;
    Ok(vec![
        Row::new("yield in pure shear", variant, "MPa", mpa * 0.5 * (shear.stress[0] - shear.stress[1])).near(
            mpa * YIELD / 3f64.sqrt(),
            1e-6,
            "[D] sigma_y / sqrt 3",
        ),
        Row::new("yield in equibiaxial tension", variant, "MPa", mpa * both.stress[0]).near(
            mpa * YIELD,
            1e-6,
            "[D] sigma_y",
        ),
        Row::new("tension with the width held, at 5 %", variant, "MPa", mpa * held.stress[0]).near(
            mpa * 2.0 * YIELD / 3f64.sqrt(),
            1e-6,
            "[D] 2 sigma_y / sqrt 3",
        ),
        Row::new("slope of equibiaxial unloading", variant, "GPa", 1e-9 * slope).near(
            1e-9 * STEEL.e / (1.0 - STEEL.nu),
            1e-6,
            "[D] E/(1-nu)",
        ),
    ])
}
