//! Strips whose edges collide between nodes (C04).

use super::laws::is_spring;
use super::measure::{mean_velocity, position};
use super::row::CheckRow;
use super::scene::{Grid, STEEL, Scene};
use super::{Bench, Check};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

/// Check of C04: upright strips.
pub const UPRIGHT: Check =
    Check { name: "strips that meet with their edges", quick: true, run: upright };
/// Check of C04: strips that lie flat on each other.
pub const FLAT: Check = Check { name: "flat strips that cross", quick: true, run: flat };

/// Strips of 100 by 10 by 1 mm [m], and the approach velocity [m/s].
const LENGTH: f64 = 0.1;
const WIDTH: f64 = 0.01;
const THICKNESS: f64 = 1e-3;
const V: f64 = 5.0;
/// Distance to the first contact [m].
const AIR: f64 = 2e-4;

const BEAM: &str =
    "[C] two beams, see `swapped` in edges.rs; tolerance of the catalogue for a full swap";

/// Crossing of two strips: the upper one is along x, the lower one at an angle; they cross at
/// the distance `off` from the middle of both [m].
struct Crossing {
    name: &'static str,
    angle: f64,
    off: f64,
}

const CROSSINGS: &[Crossing] = &[
    Crossing { name: "at 90 degrees", angle: 90.0, off: 0.0 },
    Crossing { name: "at 60 degrees, off the middle", angle: 60.0, off: 0.015 },
];

/// Contact between two beams: rigid, or a spring and a dashpot [N/m], [N s/m].
#[derive(Clone, Copy)]
pub enum Hold {
    /// Rigid contact.
    Stiff,
    /// Stiffness [N/m] and damping [N s/m].
    Soft(f64, f64),
}

/// Returns the velocity that the struck one of two equal free beams takes over, as a fraction of
/// the other's initial velocity. By symmetry the point of contact rests in the frame of both.
/// Each beam falls with half the velocity on this point, at `off` from its middle, and may
/// separate from it. The model is Timoshenko's theory with 100 linear elements, one point each,
/// lumped masses and central differences; with 40 elements the result is the same within 0.003.
///
/// Beams bend and vibrate afterwards, so they do not exchange their velocities in full: the
/// result is 0.90 and not 1 in the middle.
pub fn swapped(off: f64, hold: Hold, until: f64) -> f64 {
    const N: usize = 100;
    let (area, second) = (THICKNESS * WIDTH, THICKNESS * WIDTH.powi(3) / 12.0);
    let shear = 5.0 / 6.0 * STEEL.e / (2.0 * (1.0 + STEEL.nu)) * area;
    let dx = LENGTH / N as f64;
    let (mass, inertia) =
        (STEEL.rho * area * dx, STEEL.rho * (second * dx + area * dx.powi(3) / 12.0));
    let at_end = |i: usize| if i == 0 || i == N { 0.5 } else { 1.0 };
    let (mut w, mut turn) = ([0.0; N + 1], [0.0; N + 1]);
    let (mut dw, mut dturn) = ([-1.0f64; N + 1], [0.0f64; N + 1]);
    let place = ((0.5 * LENGTH + off) / dx).round() as usize;
    let dt = 0.5 * dx / STEEL.c();
    for _ in 0..(until / dt) as usize {
        let (mut force, mut moment) = ([0.0; N + 1], [0.0; N + 1]);
        for e in 0..N {
            let sheared = shear * ((w[e + 1] - w[e]) / dx - 0.5 * (turn[e + 1] + turn[e]));
            let bent = STEEL.e * second * (turn[e + 1] - turn[e]) / dx;
            force[e] += sheared;
            force[e + 1] -= sheared;
            moment[e] += bent + 0.5 * sheared * dx;
            moment[e + 1] -= bent - 0.5 * sheared * dx;
        }
        if let Hold::Soft(k, c) = hold
            && w[place] < 0.0
        {
            // Each side has half of the approach of the two beams.
            force[place] += (-2.0 * (k * w[place] + c * dw[place])).max(0.0);
        }
        for i in 0..=N {
            dw[i] += dt * force[i] / (mass * at_end(i));
            dturn[i] += dt * moment[i] / (inertia * at_end(i));
        }
        if matches!(hold, Hold::Stiff) {
            dw[place] = dw[place].max(-w[place] / dt);
        }
        for i in 0..=N {
            w[i] += dt * dw[i];
            turn[i] += dt * dturn[i];
        }
    }
    let mean = (0..=N).map(|i| at_end(i) * dw[i]).sum::<f64>() / N as f64;
    0.5 * (1.0 + mean)
}

/// Returns the changes of linear and angular momentum in a run, as fractions of those of one
/// strip.
fn momentum_rows(variant: &str, start: &[[f64; 3]; 2], e: &Engine) -> [CheckRow; 2] {
    const EXACT: &str = "exact; round-off of some thousand steps";
    let now: [[f64; 3]; 2] = momentum(&e.nodes).into();
    let change = |k: usize| (0..3).map(|c| (now[k][c] - start[k][c]).powi(2)).sum::<f64>().sqrt();
    let had = start[0][2].abs();
    [
        CheckRow::new("change of momentum / m v", variant, "", change(0) / had)
            .at_most(1e-12, EXACT),
        CheckRow::new(
            "change of angular momentum / m v L",
            variant,
            "",
            change(1) / (had * LENGTH),
        )
        .at_most(1e-12, EXACT),
    ]
}

/// Collides two upright strips, one above the other, edge against edge.
fn upright(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let cells = [41, 4]; // no node at the crossing
    let mut all = Vec::new();
    for law in bench.laws() {
        for crossing in CROSSINGS {
            let way = AIR + 0.5 * WIDTH;
            let mut scene = Scene::new(way / V);
            let along = |x: f64| LENGTH * (x - 0.5) - crossing.off;
            let (sin, cos) = crossing.angle.to_radians().sin_cos();
            let z = 0.5 * (THICKNESS + AIR);
            let above = scene.grid(1, cells, |x, y| [along(x), 0.0, z + WIDTH * y]);
            let below =
                scene.grid(2, cells, |x, y| [cos * along(x), sin * along(x), -z - WIDTH * y]);
            scene.elastic("steel", STEEL);
            (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, "points = 2"));
            scene.start(above.all(), [0.0, 0.0, -V], [0.0; 3]);
            scene.add(&format!("[contact]\nlaw = \"{law}\""));
            let run = bench.watch(&format!("C04 {law} {}", crossing.name), &scene, |_| {})?;
            let variant = format!("{law}, strips upright {}", crossing.name);
            let hold = if is_spring(law) {
                // Four nodes with half the mass of an element; default scale and damping.
                let node =
                    0.5 * STEEL.rho * THICKNESS * LENGTH * WIDTH / (cells[0] * cells[1]) as f64;
                let s = (cells[0] as f64 * (0.5 + crossing.off / LENGTH)).fract();
                let reduced = node / (2.0 * (s * s + (1.0 - s).powi(2)));
                let k = 0.35 * reduced / run.engine.clock.first_dt.powi(2);
                Hold::Soft(k, 2.0 * 0.1 * (k * reduced).sqrt())
            } else {
                Hold::Stiff
            };
            let struck = -mean_velocity(&run.engine, below.all(), 2) / V;
            let reference = swapped(crossing.off, hold, (way - AIR) / V);
            all.push(
                CheckRow::new("velocity of the struck strip / v", &variant, "", struck)
                    .within(reference, 0.05, BEAM),
            );
            all.extend(momentum_rows(&variant, &run.momentum, &run.engine));
            all.extend(run.energy_rows(&variant, 0.01));
            let crossed = run
                .engine
                .contact
                .as_ref()
                .map_or(0, |c| c.crossings(&run.engine.nodes, run.engine.clock.time).len());
            all.push(
                CheckRow::new("edges seen in surfaces", &variant, "", crossed as f64)
                    .at_most(0.0, "exact"),
            );
        }
    }
    Ok(all)
}

/// Returns the height of the middle of the patch, which has no node there [m].
fn middle(e: &Engine, grid: &Grid) -> f64 {
    let k = grid.along() / 2;
    [(k, 0), (k + 1, 0), (k, 1), (k + 1, 1)]
        .map(|(i, j)| position(e, grid.at(i, j))[2])
        .iter()
        .sum::<f64>()
        / 4.0
}

/// Collides two flat strips, one above the other, each one element wide: at the crossing no node
/// is on the other strip.
fn flat(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let cells = [5, 1];
    let mut all = Vec::new();
    for law in bench.laws() {
        let mut scene = Scene::new(10.0 * (AIR + THICKNESS) / V);
        let z = 0.5 * (THICKNESS + AIR);
        let above = scene.grid(1, cells, |x, y| [LENGTH * (x - 0.5), WIDTH * (y - 0.5), z]);
        let below = scene.grid(2, cells, |x, y| [WIDTH * (y - 0.5), LENGTH * (x - 0.5), -z]);
        scene.elastic("steel", STEEL);
        (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, "points = 2"));
        scene.start(above.all(), [0.0, 0.0, -V], [0.0; 3]);
        scene.add(&format!("[contact]\nlaw = \"{law}\""));
        let mut nearest = f64::INFINITY;
        let run = bench.watch(&format!("C04 {law} flat"), &scene, |e| {
            nearest = nearest.min(middle(e, &above) - middle(e, &below));
        })?;
        let variant = format!("{law}, strips flat");
        all.push(
            CheckRow::new(
                "least distance of the middles / thickness",
                &variant,
                "",
                nearest / THICKNESS,
            )
            .at_least(0.95, "limit of the catalogue: contact at (t1 + t2)/2"),
        );
        all.extend(momentum_rows(&variant, &run.momentum, &run.engine));
        all.extend(run.energy_rows(&variant, 0.01));
        all.push(run.closing_row(&variant, 0.01));
    }
    Ok(all)
}
