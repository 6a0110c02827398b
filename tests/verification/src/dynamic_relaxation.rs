//! Shells at rest under loads, by damping in proportion to mass: large deflections (A30), curved
//! and twisted shells (B09), a folded section (B10).
//!
//! A first run without damping finds half a period, from rest to the largest deflection. The
//! second run is damped critically for that period and continues until nothing moves.

use super::bars::BAR;
use super::bench::Finished;
use super::measure::{displacement, fields};
use super::row::CheckRow;
use super::scene::{Elastic, Grid, STEEL, Scene};
use super::solids::Weld;
use super::{Bench, Check};
use crumple_worker::engine::Engine;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

/// Check of A16, static.
pub const SAGGED: Check = Check { name: "plate under its load, static", quick: true, run: sagged };
/// Check of A17, in gravity.
pub const HANGING: Check = Check { name: "bar with a mass, hanging", quick: true, run: hanging };
/// Check of A30 (a).
pub const STRIP: Check = Check { name: "cantilever under end shear", quick: true, run: strip };
/// Check of A30 (b).
pub const ROLL: Check = Check { name: "roll-up by an end moment", quick: true, run: roll };
/// Check of A30 (c).
pub const HEMISPHERE: Check =
    Check { name: "pinched hemisphere, large", quick: false, run: large_hemisphere };
/// Check of A30 (d).
pub const PULLED: Check = Check { name: "pull-out of a cylinder", quick: false, run: pulled };
/// Check of B09.
pub const CURVED: Check = Check { name: "roof, cylinder, hemisphere", quick: false, run: curved };
/// Check of B09.
pub const TWISTED: Check = Check { name: "thick twisted beam", quick: false, run: twisted };
/// Check of B09.
pub const THIN: Check = Check { name: "thin twisted beam", quick: false, run: thin };
/// Check of B10.
pub const FOLDED: Check = Check { name: "Z-section", quick: false, run: folded };

const FORMULATIONS: [&str; 2] = ["belytschko_tsay", "stabilised_quad"];
/// Upper limit of the time until rest, in radians of the lowest frequency.
const LONGEST: f64 = 200.0;
const SIDEWAYS: &str = "with one shell across, only the hourglass control resists part of the \
                        twist: at the default coefficient the strip deflects sideways just before \
                        the circle closes, at 0.2 it does not";
const CLAMPED: &str = "x y z rx ry rz";

/// Runs a scene until it is at rest; returns the deflection there and the run.
fn rest(
    bench: &Bench,
    name: &str,
    scene: &Scene,
    deflection: impl Fn(&Engine) -> f64,
) -> Result<(f64, Finished), String> {
    let (mut most, mut half) = (0.0, 0.0);
    bench.run(&format!("{name} free"), scene, |e| {
        let now = deflection(e).abs();
        if now > most {
            (most, half) = (now, e.clock.time);
        }
        if now < 0.6 * most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    // Criterion of rest: three times in succession the deflection changes by at most 1e-5 within
    // one radian. A mode five times slower is then damped far above its own critical value and
    // is still off by ten times that.
    let omega = PI / half;
    let mut damped = scene.clone().until(LONGEST / omega);
    damped.time(&format!("damping = {:?}", 2.0 * omega));
    let (mut before, mut next, mut still) = (0.0, 1.0 / omega, 0);
    let run = bench.run(name, &damped, |e| {
        if e.clock.time >= next {
            let now = deflection(e);
            still = if (now - before).abs() <= 1e-5 * now.abs() { still + 1 } else { 0 };
            (before, next) = (now, next + 1.0 / omega);
        }
        if still == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if still < 3 {
        return Err(format!(
            "{name}: deflection {before:e} is not at rest after {LONGEST} radians of the lowest \
             frequency"
        ));
    }
    Ok((before, run))
}

fn load(scene: &mut Scene, nodes: &[u32], force: [f64; 3]) {
    let set = scene.set(nodes);
    scene.add(&format!("[[load]]\nnodes = \"{set}\"\nforce = {force:?}"));
}

fn hanging(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 50;
    let (length, thickness, g) = (1.0, 0.01, 9.81);
    let width = length / N as f64;
    let mut all = Vec::new();
    for times in [1.0, 10.0] {
        let mut scene = Scene::new(1.0);
        let bar = scene.grid(1, [N, 1], |x, y| [length * x, width * y, 0.0]);
        scene.elastic("steel", BAR);
        scene.part(1, "steel", thickness, "points = 2");
        scene.fix(&bar.row(0), CLAMPED);
        scene.mass(&bar.row(N), times * BAR.rho * length * width * thickness);
        scene.add(&format!("[[gravity]]\nacceleration = [{g:?}, 0.0, 0.0]"));
        let (ours, _) = rest(bench, &format!("A17 hanging {times}"), &scene, |e| {
            displacement(e, bar.at(N, 0))[0]
        })?;
        let expected = (times + 0.5) * BAR.rho * g * length * length / BAR.e;
        let quantity = format!("elongation in gravity with {times} times its mass at the end");
        all.push(CheckRow::new(quantity, "50 shells", "um", 1e6 * ours).near(
            1e6 * expected,
            0.005,
            "[D] (M + m/2) g L/EA",
        ));
    }
    Ok(all)
}

fn sagged(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 16;
    let (side, thickness, pressure) = (0.2, 0.004, 100.0);
    let bending =
        STEEL.e * thickness * thickness * thickness / (12.0 * (1.0 - STEEL.nu * STEEL.nu));
    let mut all = Vec::new();
    for element in FORMULATIONS {
        let mut scene = Scene::new(1.0);
        let grid = scene.grid(1, [N, N], |x, y| [side * x, side * y, 0.0]);
        scene.elastic("steel", STEEL);
        scene.part(1, "steel", thickness, &format!("points = 2\nelement = \"{element}\""));
        // Hard support: the edge does not rotate about its normal either.
        for i in [0, N] {
            scene.fix(&grid.row(i), "z rx");
            let column: Vec<u32> = (0..=N).map(|j| grid.at(j, i)).collect();
            scene.fix(&column, "z ry");
        }
        scene.add(&format!("[[pressure]]\nparts = [1]\npressure = {pressure:?}"));
        let middle = |e: &Engine| -displacement(e, grid.at(N / 2, N / 2))[2];
        let (ours, _) = rest(bench, &format!("A16 static {element}"), &scene, middle)?;
        let variant = format!("{element}, {N} by {N}");
        let row = CheckRow::new(
            "static deflection D w/(q a^4)",
            variant,
            "",
            ours * bending / (pressure * side.powi(4)),
        );
        all.push(row.near(0.00406235, 0.01, "[V:S10]"));
    }
    Ok(all)
}

/// Returns the cantilever of Sze et al.: 10 by 1 by 0.1, 16 by 1 shells, bending stiffness 100;
/// without units. `keys` are those of the part.
fn cantilever(keys: &str) -> (Scene, Grid) {
    let mut scene = Scene::new(1e3);
    let grid = scene.grid(1, [16, 1], |x, y| [10.0 * x, y, 0.0]);
    scene.elastic("strip", Elastic { e: 1.2e6, nu: 0.0, rho: 1.0 });
    scene.part(1, "strip", 0.1, &format!("points = 2\n{keys}"));
    scene.fix(&grid.row(0), CLAMPED);
    (scene, grid)
}

fn strip(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const SZE: &str = "[V:S18] Sze et al. 2004";
    let mut all = Vec::new();
    for element in FORMULATIONS {
        for (force, w, u) in [(1.0, 3.015, 0.563), (2.0, 4.933, 1.604), (4.0, 6.698, 3.286)] {
            let (mut scene, grid) = cantilever(&format!("element = \"{element}\""));
            load(&mut scene, &grid.row(16), [0.0, 0.0, force]);
            let (ours, run) = rest(bench, &format!("A30a {element} {force}"), &scene, |e| {
                displacement(e, grid.at(16, 0))[2]
            })?;
            let variant = format!("{element}, 16 by 1, P = {force}");
            all.push(CheckRow::new("deflection of the tip", &variant, "", ours).near(w, 0.02, SZE));
            let back = -displacement(&run.engine, grid.at(16, 0))[0];
            all.push(CheckRow::new("shortening at the tip", &variant, "", back).near(u, 0.02, SZE));
        }
    }
    Ok(all)
}

fn roll(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] the strip is an arc of angle M L/EI; full circle [V:S11]";
    // Lowest frequency of the cantilever: 3.516 sqrt(EI/(m L^4)) = 1.11.
    let (length, stiffness, omega, end) = (10.0, 100.0, 1.11, 40.0);
    let mut all = Vec::new();
    for (element, hourglass) in
        [("belytschko_tsay", 0.03), ("belytschko_tsay", 0.2), ("stabilised_quad", 0.03)]
    {
        let (scene, grid) =
            cantilever(&format!("element = \"{element}\"\nhourglass_coefficient = {hourglass:?}"));
        let mut scene = scene.until(end);
        let tip = scene.set(&grid.row(16));
        // The load rises to half a circle, rests, rises to the full circle and rests.
        scene.add(&format!(
            "[[curve]]\nname = \"steps\"\n\
             points = [[0.0, 0.0], [{:?}, 0.5], [{:?}, 0.5], [{:?}, 1.0]]",
            0.25 * end,
            0.5 * end,
            0.75 * end
        ));
        let moment = 2.0 * PI * stiffness / length;
        scene.add(&format!(
            "[[load]]\nnodes = \"{tip}\"\nmoment = [0.0, {:?}, 0.0]\ncurve = \"steps\"",
            -moment
        ));
        scene.time(&format!("damping = {:?}", 2.0 * omega));
        let mut half = [f64::NAN; 3];
        let run = bench.watch(&format!("A30b {element} {hourglass}"), &scene, |e| {
            if e.clock.time < 0.5 * end {
                half = displacement(e, grid.at(16, 0));
            }
        })?;
        let variant = format!("{element}, 16 by 1, hourglass {hourglass}");
        let whole = displacement(&run.engine, grid.at(16, 0));
        let far = |u: [f64; 3], x: f64, z: f64| (u[0] + length - x).hypot(u[2] - z) / length;
        let quantity = "tip from the end of the half circle / L, M = pi EI/L";
        let ours = far(half, 0.0, 2.0 * length / PI);
        all.push(CheckRow::new(quantity, &variant, "", ours).within(0.0, 0.02, D));
        let quantity = "tip from the root / L, M = 2 pi EI/L";
        let row = CheckRow::new(quantity, &variant, "", far(whole, 0.0, 0.0)).within(0.0, 0.02, D);
        all.push(row.known(SIDEWAYS));
    }
    Ok(all)
}

/// Adds a quarter of a hemisphere with a hole of 18 degrees, `n` by `n`; returns the loaded
/// corners on the x and the y axis.
fn hemisphere(scene: &mut Scene, n: usize, section: &str) -> [u32; 2] {
    let grid = scene.grid(1, [n, n], |s, r| {
        let (sin, cos) = (s * FRAC_PI_2).sin_cos();
        let (up, out) = (r * 72f64.to_radians()).sin_cos();
        [10.0 * out * cos, 10.0 * out * sin, 10.0 * up]
    });
    scene.elastic("shell", Elastic { e: 6.825e7, nu: 0.3, rho: 1.0 });
    scene.part(1, "shell", 0.04, section);
    scene.symmetry([0.0; 3], [0.0, 1.0, 0.0]);
    scene.symmetry([0.0; 3], [1.0, 0.0, 0.0]);
    scene.fix(&[grid.at(0, 0)], "z");
    [grid.at(0, 0), grid.at(n, 0)]
}

fn large_hemisphere(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 16;
    const U: &str = "[U] Sze et al. 2004";
    let mut all = Vec::new();
    for element in FORMULATIONS {
        let mut scene = Scene::new(1e3);
        let [a, b] = hemisphere(&mut scene, N, &format!("points = 2\nelement = \"{element}\""));
        // A node on a plane of symmetry gets half of P = 400.
        load(&mut scene, &[a], [200.0, 0.0, 0.0]);
        load(&mut scene, &[b], [0.0, -200.0, 0.0]);
        let (inward, run) =
            rest(bench, &format!("A30c {element}"), &scene, |e| -displacement(e, b)[1])?;
        let variant = format!("{element}, {N} by {N} on a quarter, P = 400");
        let outward = displacement(&run.engine, a)[0];
        all.push(CheckRow::new("outward displacement", &variant, "", outward).reference(4.067, U));
        all.push(CheckRow::new("inward displacement", &variant, "", inward).reference(8.178, U));
    }
    Ok(all)
}

fn pulled(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const SZE: &str = "[V:S18] Sze et al. 2004, geometry [U]";
    const MESH: [usize; 2] = [16, 24];
    let (radius, length) = (4.953, 10.35);
    let mut all = Vec::new();
    for element in FORMULATIONS {
        for (share, w) in [(0.1, 1.707), (0.5, 2.473), (1.0, 2.768)] {
            let mut scene = Scene::new(1e3);
            // An eighth of the cylinder: the load is at x = 0, on top.
            let grid = scene.grid(1, MESH, |x, s| {
                let (sin, cos) = (s * FRAC_PI_2).sin_cos();
                [0.5 * length * x, radius * sin, radius * cos]
            });
            scene.elastic("shell", Elastic { e: 10.5e6, nu: 0.3125, rho: 1.0 });
            scene.part(1, "shell", 0.094, &format!("points = 2\nelement = \"{element}\""));
            (0..3).for_each(|c| {
                scene.symmetry([0.0; 3], std::array::from_fn(|k| f64::from(u8::from(k == c))))
            });
            load(&mut scene, &[grid.at(0, 0)], [0.0, 0.0, 0.25 * share * 40_000.0]);
            let top = |e: &Engine| displacement(e, grid.at(0, 0))[2];
            let (ours, _) = rest(bench, &format!("A30d {element} {share}"), &scene, top)?;
            let variant = format!("{element}, {} by {} on an eighth, {share} P", MESH[0], MESH[1]);
            all.push(
                CheckRow::new("displacement under the load", &variant, "", ours).near(w, 0.05, SZE),
            );
        }
    }
    Ok(all)
}

/// Factor of small loads: deflections stay far below the thickness.
const SMALL: f64 = 1e-3;
const TABLE: &str = "[C] exact linear solution of Belytschko-Tsay with r = 0.02, catalogue B09";
const TARGET: &str = "target; limit of the catalogue at n = 16";

/// Returns the section of B09, with hourglass coefficient 0.02.
fn section(element: &str, drilling: f64) -> String {
    format!(
        "points = 2\nelement = \"{element}\"\nhourglass_coefficient = 0.02\ndrilling = {drilling:?}"
    )
}

fn roof(bench: &Bench, name: &str, n: usize, section: &str) -> Result<f64, String> {
    let thickness = 0.25;
    let mut scene = Scene::new(1e6);
    let grid = scene.grid(1, [n, n], |r, s| {
        let (sin, cos) = (s * 40f64.to_radians()).sin_cos();
        [25.0 * r, 25.0 * sin, 25.0 * cos]
    });
    scene.elastic("shell", Elastic { e: 4.32e8, nu: 0.0, rho: 1.0 });
    scene.part(1, "shell", thickness, section);
    scene.symmetry([0.0; 3], [1.0, 0.0, 0.0]);
    scene.symmetry([0.0; 3], [0.0, 1.0, 0.0]);
    scene.fix(&grid.row(n), "y z");
    scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]", -SMALL * 90.0 / thickness));
    Ok(rest(bench, name, &scene, |e| -displacement(e, grid.at(0, n))[2])?.0 / (SMALL * 0.3024))
}

fn cylinder(bench: &Bench, name: &str, n: usize, section: &str) -> Result<f64, String> {
    let mut scene = Scene::new(1e9);
    let grid = scene.grid(1, [n, n], |r, s| {
        let (sin, cos) = (s * FRAC_PI_2).sin_cos();
        [300.0 * r, 300.0 * sin, 300.0 * cos]
    });
    scene.elastic("shell", Elastic { e: 3e6, nu: 0.3, rho: 1.0 });
    scene.part(1, "shell", 3.0, section);
    (0..3).for_each(|c| {
        scene.symmetry([0.0; 3], std::array::from_fn(|k| f64::from(u8::from(k == c))))
    });
    scene.fix(&grid.row(n), "y z");
    // The deflection is far below the thickness and far above round-off.
    let force = 1e3;
    load(&mut scene, &[grid.at(0, 0)], [0.0, 0.0, -0.25 * force]);
    Ok(rest(bench, name, &scene, |e| -displacement(e, grid.at(0, 0))[2])?.0 / (force * 1.82488e-5))
}

fn small_hemisphere(bench: &Bench, name: &str, n: usize, section: &str) -> Result<f64, String> {
    let mut scene = Scene::new(1e6);
    let [a, b] = hemisphere(&mut scene, n, section);
    load(&mut scene, &[a], [SMALL, 0.0, 0.0]);
    load(&mut scene, &[b], [0.0, -SMALL, 0.0]);
    Ok(rest(bench, name, &scene, |e| displacement(e, a)[0])?.0 / (SMALL * 0.093))
}

fn curved(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    /// Function that builds and runs a scene and divides the result by the target.
    type Scenes = fn(&Bench, &str, usize, &str) -> Result<f64, String>;
    let scenes: [(&str, Scenes); 3] = [
        ("Scordelis-Lo roof", roof),
        ("pinched cylinder", cylinder),
        ("hemisphere", small_hemisphere),
    ];
    let mut all = Vec::new();
    for (element, drilling, coarse, fine) in [
        ("belytschko_tsay", 0.01, [1.040, 0.806, 0.978], [1.007, 0.960, 1.005]),
        ("belytschko_tsay", 0.1, [1.029, 0.792, 0.719], [1.004, 0.958, 0.981]),
        ("stabilised_quad", 0.01, [f64::NAN; 3], [f64::NAN; 3]),
    ] {
        for (n, table) in [(8, coarse), (16, fine)] {
            for ((what, scene), known) in scenes.into_iter().zip(table) {
                let variant = format!("{element}, {n} by {n}, drilling {drilling}");
                let ours =
                    scene(bench, &format!("B09 {what} {variant}"), n, &section(element, drilling))?;
                let quantity = format!("{what}, deflection / target");
                if known.is_finite() {
                    all.push(CheckRow::new(&quantity, &variant, "", ours).near(known, 0.01, TABLE));
                }
                let row = CheckRow::new(
                    format!("{what}, deflection"),
                    format!("{variant}, against the target"),
                    "",
                    ours,
                );
                // The cylinder is known to need a finer mesh; at n = 8 there is no bound.
                all.push(match n == 16 && what != "pinched cylinder" {
                    true => row.near(1.0, 0.03, TARGET),
                    false => row.reference(1.0, "target"),
                });
            }
        }
    }
    Ok(all)
}

/// Computes the deflection of the tip of a strip under a load along its width there (z) or
/// across it (y), over the target. The strip of 12 by 1.1 is twisted by a right angle and has
/// `n` shells along it and a sixth of that across.
fn twist(
    bench: &Bench,
    element: &str,
    thickness: f64,
    n: usize,
    drilling: f64,
    along: bool,
) -> Result<f64, String> {
    let (m, c) = (n / 6, if along { 2 } else { 1 });
    let mut scene = Scene::new(1e9);
    let grid = scene.grid(1, [n, m], |r, s| {
        let (sin, cos) = (r * FRAC_PI_2).sin_cos();
        [12.0 * r, 1.1 * (s - 0.5) * cos, 1.1 * (s - 0.5) * sin]
    });
    scene.elastic("strip", Elastic { e: 29e6, nu: 0.22, rho: 1.0 });
    scene.part(1, "strip", thickness, &section(element, drilling));
    scene.fix(&grid.row(0), CLAMPED);
    let (force, targets) =
        if thickness > 0.1 { (1.0, [1.7532e-3, 5.4245e-3]) } else { (1e-6, [1.294e-3, 5.256e-3]) };
    let (tip, small) = (grid.at(n, m / 2), if thickness > 0.1 { 1.0 } else { SMALL });
    load(&mut scene, &[tip], std::array::from_fn(|k| if k == c { small * force } else { 0.0 }));
    let name = format!(
        "B09 twisted {element} {thickness} {n} drilling {drilling} along {}",
        ["x", "y", "z"][c]
    );
    Ok(rest(bench, &name, &scene, |e| displacement(e, tip)[c])?.0 / (small * targets[c - 1]))
}

fn twisted(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for (element, drilling, table) in [
        // Values of the table on the same mesh and on the finest one.
        ("belytschko_tsay", 0.01, [0.978, 1.017, 1.028]),
        ("belytschko_tsay", 0.1, [0.952, 0.989, 0.998]),
        ("stabilised_quad", 0.01, [f64::NAN; 3]),
    ] {
        for (n, known) in [24, 48].into_iter().zip(table) {
            let variant = format!("{element}, {n} by {}, drilling {drilling}", n / 6);
            let z = twist(bench, element, 0.32, n, drilling, true)?;
            if known.is_finite() {
                // In the table's code the rigid rotation of warped shells excites hourglass
                // rates, here it does not. Results on coarse meshes therefore agree with its
                // finest mesh and with a direct solution with our kernels.
                let row = |of: &str| {
                    CheckRow::new(
                        format!("thick, load along z, deflection / target{of}"),
                        &variant,
                        "",
                        z,
                    )
                };
                all.push(row(", as on 96 by 16").near(table[2], 0.01, TABLE));
                all.push(row("").reference(known, TABLE));
            }
            let against = format!("{variant}, against the target");
            all.push(
                CheckRow::new("thick, load along z, deflection", &against, "", z)
                    .reference(1.0, "target"),
            );
            if n == 24 {
                let y = twist(bench, element, 0.32, n, drilling, false)?;
                all.push(
                    CheckRow::new("thick, load along y, deflection", &against, "", y)
                        .reference(1.0, "target"),
                );
            }
        }
    }
    Ok(all)
}

fn thin(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 12;
    let mut all = Vec::new();
    for element in FORMULATIONS {
        let variant = format!("{element}, {N} by {}, drilling 0.01, against the target", N / 6);
        for (along, axis) in [(true, "z"), (false, "y")] {
            let ours = twist(bench, element, 0.0032, N, 0.01, along)?;
            let quantity = format!("thin, load along {axis}, deflection");
            all.push(CheckRow::new(quantity, &variant, "", ours).reference(
                1.0,
                "target; [C] .003 at 24 by 4 if rigid rotation excites hourglass rates",
            ));
        }
    }
    Ok(all)
}

fn folded(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (length, force) = (10.0, 0.6e6);
    let mut all = Vec::new();
    for element in FORMULATIONS {
        for n in [2, 4] {
            // Shells of 1/n m: flanges of 1 m at y = -1 and 1, in the directions -z and z, and
            // the web of 2 m between them.
            let along = 10 * n;
            let mut scene = Scene::new(1e3);
            let mut weld = Weld::new(1e-6);
            let low =
                scene.welded_grid(1, [along, n], &mut weld, |x, s| [length * x, -1.0, s - 1.0]);
            scene
                .welded_grid(1, [along, 2 * n], &mut weld, |x, s| [length * x, 2.0 * s - 1.0, 0.0]);
            let high = scene.welded_grid(1, [along, n], &mut weld, |x, s| [length * x, 1.0, s]);
            scene.elastic("steel", STEEL);
            scene.part(1, "steel", 0.1, &format!("points = 2\nelement = \"{element}\""));
            let root: Vec<u32> = (1..=scene.count()).filter(|&i| scene.at(i)[0] < 1e-9).collect();
            scene.fix(&root, "x y z");
            // Uniform shear on the ends of the flanges: nodes at the corners carry half.
            for (flange, sign) in [(&low, -1.0), (&high, 1.0)] {
                let share = sign * SMALL * force / n as f64;
                let end = flange.row(along);
                load(&mut scene, &end[1..n], [0.0, 0.0, share * (n as f64 - 1.0)]);
                load(&mut scene, &[end[0], end[n]], [0.0, 0.0, share]);
            }
            let tip = high.at(along, n);
            let name = format!("B10 {element} {n}");
            let (_, run) = rest(bench, &name, &scene, |e| displacement(e, tip)[2])?;
            // Axial stress at the free edge of a flange, 2.5 m from the root: the mean of the
            // shells before and after, extrapolated linearly from the two nearest to the edge.
            let stresses = fields(&run.engine);
            let first = along * 3 * n;
            let at = |i: usize, j: usize| stresses[first + i * n + j].stress[0];
            let pair = |j: usize| 0.5 * (at(along / 4 - 1, j) + at(along / 4, j));
            let edge = pair(n - 1) + 0.5 * (pair(n - 1) - pair(n - 2));
            let variant = format!("{element}, sides of {} m", 1.0 / n as f64);
            let row = CheckRow::new(
                "|axial stress| at the edge of a flange",
                &variant,
                "MPa",
                1e-6 * edge.abs() / SMALL,
            );
            // With two shells over a flange, half the side halves the distance from the 111.2
            // MPa of converged codes, and more.
            const LE5: &str = "[V:S10] NAFEMS LE5; converged codes 111.2";
            all.push(if n > 2 { row.near(108.0, 0.05, LE5) } else { row.reference(108.0, LE5) });
        }
    }
    Ok(all)
}
