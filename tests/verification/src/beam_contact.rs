//! Contact of beams with each other, with free edges and faces of shells, and with edges of
//! solids (C20).

use super::bench::Finished;
use super::edges::{Hold, swapped};
use super::laws::Law;
use super::measure::{mean_velocity, position};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::{Bench, Check};
use crumple_worker::energy::momentum;

/// Check of C20: rigid beams.
pub const RIGID: Check = Check { name: "rigid beams that cross", quick: true, run: rigid };
/// Check of C20: elastic beams.
pub const ELASTIC: Check = Check { name: "elastic beams that cross", quick: true, run: elastic };
/// Check of C20: a rigid beam on a free edge.
pub const EDGE: Check =
    Check { name: "a beam on the free edge of a shell", quick: true, run: edge };
/// Check of C20: bodies at rest.
pub const REST: Check =
    Check { name: "a beam on a sheet, a cube on three beams", quick: true, run: rest };

/// Length of a beam, its radius and the thickness of shells [m]; approach velocity of elastic
/// bodies [m/s].
const LENGTH: f64 = 0.1;
const RADIUS: f64 = 2e-3;
const THICKNESS: f64 = 1e-3;
const V: f64 = 5.0;
/// Approach velocity of rigid bodies [m/s].
const FAST: f64 = 20.0;
/// Number of beams of a rigid bar; no node is at the point of contact.
const CELLS: usize = 11;
/// Distance of the impact from the middle [m].
const OFF: f64 = 0.02;

/// Adds the nodes of a bar of `n` beams.
fn bar(scene: &mut Scene, n: usize, from: [f64; 3], to: [f64; 3]) -> Vec<u32> {
    let at = |i: usize| [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * i as f64 / n as f64);
    (0..=n).map(|i| scene.node(at(i))).collect()
}

/// Adds beams along bars, each with its part. All other nodes must exist already.
fn beams(scene: &mut Scene, bars: &[(u32, &[u32])]) {
    let third = scene.node([0.31, 0.47, 0.59]);
    for (part, nodes) in bars {
        nodes.windows(2).for_each(|pair| scene.beam(*part, [pair[0], pair[1], third]));
    }
}

fn tube(scene: &mut Scene, part: u32) {
    scene.add(&format!(
        "[[part]]\nid = {part}\nmaterial = \"steel\"\n[part.beam]\nsection = \"tube\"\n\
         radius = {RADIUS:?}"
    ));
}

/// Returns the fraction of its momentum that a free bar gives off if it is stopped at the
/// distance `off` from its middle: `1/(1 + m d^2/I)`, with the inertia of the nodes, `m L^2/12
/// (1 + 2/n^2)`.
fn given_off(off: f64) -> f64 {
    let inertia = LENGTH * LENGTH / 12.0 * (1.0 + 2.0 / (CELLS * CELLS) as f64);
    1.0 / (1.0 + off * off / inertia)
}

const CLOSED: &str =
    "[D] impulse and momentum of rigid bars; inertia of the cross-sections, below 1 %";
const EXACT: &str = "exact; round-off of some thousand steps";
const TURNED: &str = "exact; nodes of rigid bodies move along chords, an error of order (w dt)^2";

/// Returns the changes of momentum and angular momentum, as fractions of `had` [kg m/s] and of
/// `had` times the length; `angular` bounds the second one.
fn momentum_rows(variant: &str, run: &Finished, angular: (f64, &'static str)) -> [CheckRow; 2] {
    let now: [[f64; 3]; 2] = momentum(&run.engine.nodes).into();
    let change =
        |k: usize| (0..3).map(|c| (now[k][c] - run.momentum[k][c]).powi(2)).sum::<f64>().sqrt();
    let had = run.momentum[0][2].abs();
    let turning = change(1) / (had * LENGTH);
    [
        CheckRow::new("change of momentum / m v", variant, "", change(0) / had)
            .at_most(1e-12, EXACT),
        CheckRow::new("change of angular momentum / m v L", variant, "", turning)
            .at_most(angular.0, angular.1),
    ]
}

fn crossings(variant: &str, run: &Finished) -> CheckRow {
    let e = &run.engine;
    let seen = e.contact.as_ref().map_or(0, |c| c.crossings(&e.nodes, e.clock.time).len());
    CheckRow::new("lines seen in surfaces", variant, "", seen as f64).at_most(0.0, "exact")
}

/// Collides two equal rigid bars at right angles: the impulse is `m v (1 + e)/2` times the
/// fraction that is given off, with the restitution e.
fn rigid(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in Law::ALL {
        for off in [0.0, OFF] {
            let mut scene = Scene::new(1e-4);
            let z = RADIUS + 2e-4;
            let along = |s: f64| LENGTH * (s - 0.5) - off;
            let above = bar(&mut scene, CELLS, [along(0.0), 0.0, z], [along(1.0), 0.0, z]);
            let below = bar(&mut scene, CELLS, [0.0, along(0.0), -z], [0.0, along(1.0), -z]);
            beams(&mut scene, &[(1, &above), (2, &below)]);
            scene.elastic("steel", STEEL);
            (1..=2).for_each(|part| tube(&mut scene, part));
            scene.add(
                "[[rigid]]\nname = \"above\"\nparts = [1]\n\
                 [[rigid]]\nname = \"below\"\nparts = [2]",
            );
            scene.time("dt_max = 2e-7");
            scene.start(&above, [0.0, 0.0, -FAST], [0.0; 3]);
            scene.add(&law.undamped());
            // With the default tolerance of 1e-3 the forces on rigid bodies are up to 1.1 % off.
            scene.add("tolerance = 1e-6\nsweeps = 200");
            let variant = format!("{}, rigid, {} mm off the middles", law.name, 1e3 * off);
            let run = bench.watch(&format!("C20 {variant}"), &scene, |_| {})?;
            // Bars stay together under laws without compliance. On an undamped spring they
            // separate with the velocity of approach.
            let rebound = if law.is_spring() { 1.0 } else { 0.0 };
            let expected = 0.5 * (1.0 + rebound) * given_off(off);
            let struck = -middle_velocity(&run, &below) / FAST;
            all.push(
                CheckRow::new("velocity of the struck bar / v", &variant, "", struck)
                    .near(expected, 0.01, CLOSED),
            );
            all.extend(momentum_rows(&variant, &run, (1e-7, TURNED)));
            all.push(run.given_row(&variant));
        }
    }
    Ok(all)
}

/// Returns the velocity of the middle of a bar along z, the mean over its nodes weighted by mass
/// [m/s].
fn middle_velocity(run: &Finished, nodes: &[u32]) -> f64 {
    mean_velocity(&run.engine, nodes, 2)
}

/// Collides the strips of C04, modelled as beams; the reference is Timoshenko's theory.
fn elastic(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 41;
    const DEEP: f64 = 0.01;
    let air = 2e-4;
    let mut all = Vec::new();
    for law in bench.laws() {
        for off in [0.0, 0.015] {
            let until = 0.5 * DEEP / V;
            let mut scene = Scene::new(until + air / V);
            let along = |x: f64| LENGTH * (x - 0.5) - off;
            let z = RADIUS + 0.5 * air;
            let above = bar(&mut scene, N, [along(0.0), 0.0, z], [along(1.0), 0.0, z]);
            let below = bar(&mut scene, N, [0.0, along(0.0), -z], [0.0, along(1.0), -z]);
            beams(&mut scene, &[(1, &above), (2, &below)]);
            scene.elastic("steel", STEEL);
            let (area, second) = (THICKNESS * DEEP, THICKNESS * DEEP.powi(3) / 12.0);
            let sheared = 5.0 / 6.0 * area;
            for part in 1..=2 {
                scene.add(&format!(
                    "[[part]]\nid = {part}\nmaterial = \"steel\"\n[part.beam]\n\
                     section = \"general\"\narea = {area:e}\n\
                     second_moments = [{second:e}, {second:e}]\ntorsion = {second:e}\n\
                     shear_areas = [{sheared:e}, {sheared:e}]\n\
                     contact_radius = {RADIUS:e}"
                ));
            }
            scene.start(&above, [0.0, 0.0, -V], [0.0; 3]);
            scene.add(&format!("[contact]\nlaw = \"{law}\""));
            let variant = format!("{law}, elastic, {} mm off the middles", 1e3 * off);
            let run = bench.watch(&format!("C20 {variant}"), &scene, |_| {})?;
            let hold = if law == "penalty" {
                // Four nodes with the mass of a beam; default scale and damping.
                let node = STEEL.rho * area * LENGTH / N as f64;
                let s = (N as f64 * (0.5 + off / LENGTH)).fract();
                let reduced = node / (2.0 * (s * s + (1.0 - s).powi(2)));
                let k = 0.35 * reduced / run.engine.clock.first_dt.powi(2);
                Hold::Soft(k, 2.0 * 0.1 * (k * reduced).sqrt())
            } else {
                Hold::Stiff
            };
            let reference = swapped(off, hold, until);
            let struck = -middle_velocity(&run, &below) / V;
            const BEAM: &str =
                "[C] two beams, see `swapped` in edges.rs; tolerance of the catalogue for C04";
            all.push(
                CheckRow::new("velocity of the struck beam / v", &variant, "", struck)
                    .within(reference, 0.05, BEAM),
            );
            all.extend(momentum_rows(&variant, &run, (1e-12, EXACT)));
            all.extend(run.energy_rows(&variant, 0.01));
            all.push(crossings(&variant, &run));
        }
    }
    Ok(all)
}

/// Drops a rigid bar on the free edge of an upright sheet that is held. The bar touches the edge
/// off its middle and turns about it.
fn edge(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in Law::ALL {
        let mut scene = Scene::new(2e-4);
        let apart = RADIUS + 0.5 * THICKNESS;
        let z = apart + 2e-4;
        let bar =
            bar(&mut scene, CELLS, [0.0, OFF - 0.5 * LENGTH, z], [0.0, OFF + 0.5 * LENGTH, z]);
        let sheet = scene.grid(2, [3, 2], |x, y| [0.03 * (x - 0.5), 0.0, -0.02 * y]);
        beams(&mut scene, &[(1, &bar)]);
        scene.elastic("steel", STEEL);
        tube(&mut scene, 1);
        scene.part(2, "steel", THICKNESS, "");
        scene.add("[[rigid]]\nname = \"bar\"\nparts = [1]");
        scene.time("dt_max = 2e-7");
        scene.fix(sheet.all(), "x y z rx ry rz");
        scene.start(&bar, [0.0, 0.0, -FAST], [0.0; 3]);
        scene.add(&law.undamped());
        let mut nearest = f64::INFINITY;
        let run = bench.watch(&format!("C20 edge {}", law.name), &scene, |e| {
            let [[_, y0, z0], [_, y1, z1]] = [bar[0], bar[CELLS]].map(|n| position(e, n));
            // Distance of the edge, which is the origin, from the line of the bar.
            nearest = nearest.min((y0 * z1 - y1 * z0).abs() / (y1 - y0).hypot(z1 - z0));
        })?;
        let rebound = if law.is_spring() { 1.0 } else { 0.0 };
        let kept = 1.0 - (1.0 + rebound) * given_off(OFF);
        let goes_on = -middle_velocity(&run, &bar) / FAST;
        let variant = format!("{}, over a free edge", law.name);
        all.push(
            CheckRow::new("velocity of the middle / v", &variant, "", goes_on)
                .within(kept, 0.01, CLOSED),
        );
        all.push(
            CheckRow::new("least distance / (r + t/2)", &variant, "", nearest / apart)
                .at_least(0.95, "limit of the catalogue for C04: contact at (t1 + t2)/2"),
        );
        all.push(run.given_row(&variant));
        all.push(crossings(&variant, &run));
    }
    Ok(all)
}

/// Compares bodies at rest under gravity. A beam rests on a sheet at the height `r + t/2`. A
/// cube stands on its corner between three beams that touch its edges: the corner is `(r - rho
/// cos a)/sin a` from the plane of the beams, with the distance `rho` from the axis to a beam
/// and `cos a = 1/sqrt(3)`.
fn rest(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const GRAVITY: &str = "[[gravity]]\nacceleration = [0.0, 0.0, -200.0]";
    let mut all = Vec::new();
    for law in bench.laws() {
        let mut scene = Scene::new(0.012);
        let apart = RADIUS + 0.5 * THICKNESS;
        let beam = bar(&mut scene, 5, [-0.035, 0.003, apart + 1e-4], [0.035, 0.005, apart + 1e-4]);
        let sheet = scene.grid(2, [7, 6], |x, y| [0.09 * (x - 0.5), 0.07 * (y - 0.5), 0.0]);
        beams(&mut scene, &[(1, &beam)]);
        scene.elastic("steel", STEEL);
        tube(&mut scene, 1);
        scene.part(2, "steel", THICKNESS, "");
        scene.fix(sheet.all(), "x y z rx ry rz");
        scene.time("damping = 2e3");
        scene.add(GRAVITY);
        scene.add(&format!("[contact]\nlaw = \"{law}\""));
        let run = bench.watch(&format!("C20 sheet {law}"), &scene, |_| {})?;
        let far = |n: &u32| position(&run.engine, *n)[2] / apart;
        let [low, high] =
            [f64::min, f64::max].map(|pick| beam.iter().map(far).fold(far(&beam[0]), pick));
        let variant = format!("{law}, a beam on a sheet");
        const PLACE: &str =
            "[D] sum of radius and half thickness; the weight compresses a spring by 1e-4 of it";
        all.push(
            CheckRow::new("least height / (r + t/2)", &variant, "", low).near(1.0, 0.005, PLACE),
        );
        all.push(
            CheckRow::new("largest height / (r + t/2)", &variant, "", high).near(1.0, 0.005, PLACE),
        );

        let (rho, side) = (0.015, 0.04);
        let (cos, sin) = ((1.0f64 / 3.0).sqrt(), (2.0f64 / 3.0).sqrt());
        let depth = (RADIUS - rho * cos) / sin;
        let mut scene = Scene::new(0.012);
        let turned = |k: usize| (k as f64 * 120f64.to_radians()).sin_cos();
        let mut bars = Vec::new();
        for (s, c) in (0..3).map(turned) {
            let end = |along: f64| [rho * c - along * s, rho * s + along * c, 0.0];
            bars.push(bar(&mut scene, 3, end(-0.024), end(0.024)));
        }
        // Edges rise from the corner in the planes through the axis and the middles of the
        // beams.
        let edges: [[f64; 3]; 3] =
            [0, 1, 2].map(turned).map(|(s, c)| [side * sin * c, side * sin * s, side * cos]);
        let cube = scene.block(2, [1; 3], |p| {
            [0, 1, 2].map(|c| {
                let start = if c == 2 { depth + 5e-5 } else { 0.0 };
                start + (0..3).map(|e| p[e] * edges[e][c]).sum::<f64>()
            })
        });
        beams(
            &mut scene,
            &[1, 1, 1].into_iter().zip(bars.iter().map(Vec::as_slice)).collect::<Vec<_>>(),
        );
        scene.elastic("steel", STEEL);
        tube(&mut scene, 1);
        scene.solid_part(2, "steel", "");
        scene.fix(&bars.concat(), "x y z rx ry rz");
        scene.time("damping = 1e3");
        scene.add(GRAVITY);
        scene.add(&format!("[contact]\nlaw = \"{law}\"\nfriction = 0.3"));
        let run = bench.watch(&format!("C20 cage {law}"), &scene, |_| {})?;
        let low =
            cube.all().iter().map(|&n| position(&run.engine, n)[2]).fold(f64::INFINITY, f64::min);
        let variant = format!("{law}, a cube on three beams");
        const HELD: &str = "[D] closed form of the position; a fiftieth of the radius for the \
                            elasticity of the cube and of springs";
        all.push(CheckRow::new("corner below the beams / r", &variant, "", -low / RADIUS).within(
            -depth / RADIUS,
            0.02,
            HELD,
        ));
        all.push(crossings(&variant, &run));
    }
    Ok(all)
}
