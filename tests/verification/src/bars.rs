//! A01: two bars collide end to end. A bar is a strip of square shells with Poisson's ratio 0.
//! It carries only plane waves of speed `c = sqrt(E/rho)`.

use super::bench::Finished;
use super::laws::{UNDAMPED, is_spring};
use super::measure::{Push, mass, mean_velocity};
use super::row::CheckRow;
use super::scene::{Elastic, STEEL, Scene};
use super::{Bench, Check};

/// Material of the bars: steel with nu = 0.
pub const BAR: Elastic = Elastic { nu: 0.0, ..STEEL };
const LENGTH: f64 = 1.0;
/// Thickness of the shells [m], smaller than any side: a strip touches itself if a side is
/// shorter than the shell is thick.
const THICKNESS: f64 = 3e-3;
const V: f64 = 10.0;

/// Reason why the penalty law deviates for bars.
pub const SOFT: &str = "at its default scale of 0.35 the penalty law is a soft spring between the \
                        bars, with 0.13 of the stiffness of an element: it delays the front and is \
                        compressed by (v/2c) L_e/beta";
/// Smallest and largest energy loss of end nodes that are stopped, over their kinetic energy. An
/// impact within a step stops them in two steps, and the bar behind pushes them meanwhile.
const STOPPED: [f64; 2] = [1.0, 1.405];

/// Compares the energy lost where end nodes with this share of the energy are stopped.
pub fn stopped(row: CheckRow, share: f64) -> CheckRow {
    let [least, most] = STOPPED;
    row.near(
        0.5 * (least + most) * share,
        (most - least) / (most + least),
        "[C] chains of masses and springs, tests/references/plastic.py: 1 to 1.405 times the \
         energy of the end nodes, depending on the time of impact within a step",
    )
}

/// Check of A01 on a matching mesh.
pub const PAIR: Check = Check { name: "head-on, matching", quick: true, run: |b| pair(b, 1) };
/// Check of A01 with ends that do not match.
pub const PAIR_UNEQUAL: Check =
    Check { name: "head-on, non-matching", quick: true, run: |b| pair(b, 3) };
/// Check of A01: dependence of the loss and the restitution on the mesh.
pub const PAIR_ORDER: Check = Check { name: "order in the mesh size", quick: true, run: order };

struct Met {
    /// Times of the first and the last contact [s].
    span: (f64, f64),
    /// Mean stress over the plateau [Pa].
    stress: f64,
    /// Velocities of the bars at the end [m/s].
    after: [f64; 2],
    /// Work of contact as a fraction of the energy.
    work: f64,
    run: Finished,
    /// Reference momentum [kg m/s].
    scale: f64,
}

/// Collides two bars of `n` squares each; the second one has `across` elements over its width.
fn collide(bench: &Bench, law: &str, n: usize, across: usize, v: [f64; 2]) -> Result<Met, String> {
    let c = BAR.c();
    let mut scene = Scene::new(3.2 * LENGTH / c);
    let width = LENGTH / n as f64;
    // Surfaces touch at the mean thickness. The gap of 1e-6 m is 1e-7 s of flight.
    let from = LENGTH + THICKNESS + 1e-6;
    let one = scene.grid(1, [n, 1], |x, y| [LENGTH * x, width * y, 0.0]);
    let two = scene.grid(2, [n, across], |x, y| [from + LENGTH * x, width * y, 0.0]);
    scene.elastic("steel", BAR);
    (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, "points = 2"));
    scene.start(one.all(), [v[0], 0.0, 0.0], [0.0; 3]);
    scene.start(two.all(), [v[1], 0.0, 0.0], [0.0; 3]);
    scene.add(&format!("[contact]\nlaw = \"{law}\"\n{UNDAMPED}"));
    let mut push = Push::default();
    let name = format!("A01 {law} {n} by {across} at {} and {}", v[0], v[1]);
    let run = bench.watch(&name, &scene, |e| {
        let gained = mass(e, two.all()) * (mean_velocity(e, two.all(), 0) - v[1]);
        push.add_sample(e.clock.time - 0.5 * e.clock.last_dt, gained);
    })?;
    let time = LENGTH / c;
    let area = width * THICKNESS;
    let expected = 0.5 * BAR.rho * c * (v[0] - v[1]) * area;
    let contact = run.energies.contact / run.initial;
    let scale = mass(&run.engine, one.all()) * (v[0] - v[1]);
    Ok(Met {
        span: push.span(0.5 * expected, 0.05 * time),
        stress: push.mean_force(0.2 * time, 1.8 * time) / area,
        after: [one.all(), two.all()].map(|nodes| mean_velocity(&run.engine, nodes, 0)),
        work: contact,
        run,
        scale,
    })
}

/// Returns the rows that are compared for every law and mesh.
fn rows(m: &Met, variant: &str, v: [f64; 2]) -> Vec<CheckRow> {
    const D: &str = "[D] one-dimensional wave theory";
    let us = 1e6;
    m.run.with_energy(
        variant,
        1e-3,
        vec![
            CheckRow::new("contact duration 2L/c", variant, "us", us * (m.span.1 - m.span.0))
                .near(386.68, 0.01, D),
            CheckRow::new("mean interface stress rho c v/2", variant, "MPa", 1e-6 * m.stress)
                .near(203.0, 0.01, D),
            CheckRow::new("velocity of bar 1 after", variant, "m/s", m.after[0]).within(
                v[1],
                0.01 * V,
                D,
            ),
            CheckRow::new("velocity of bar 2 after", variant, "m/s", m.after[1]).within(
                v[0],
                0.01 * V,
                D,
            ),
            CheckRow::new(
                "change of momentum / m v",
                variant,
                "",
                m.run.momentum_drift(0, m.scale),
            )
            .at_most(1e-10, "exact"),
        ],
    )
}

fn pair(bench: &Bench, across: usize) -> Result<Vec<CheckRow>, String> {
    const N: usize = 100;
    let mut all = Vec::new();
    for law in bench.laws() {
        for v in [[V, 0.0], [0.5 * V, -0.5 * V]] {
            let met = collide(bench, law, N, across, v)?;
            let mesh = if across == 1 { "matching" } else { "non-matching" };
            let variant = format!("{law}, {mesh}, {N} shells, {:+} and {:+} m/s", v[0], v[1]);
            all.extend(
                rows(&met, &variant, v)
                    .into_iter()
                    .map(|r| if is_spring(law) && r.known.is_empty() { r.known(SOFT) } else { r }),
            );
            if across > 1 {
                continue;
            }
            // The end nodes, 1/(2 N) of a bar each, take a common velocity: the loss is 1/2
            // m_red v^2.
            let share = if v[1] == 0.0 { 0.25 } else { 0.5 } / N as f64;
            let lost = CheckRow::new("energy lost in contact / E0", &variant, "", -met.work);
            all.push(match is_spring(law) {
                true => lost
                    .within(
                        0.0,
                        1e-3,
                        "[D] a spring returns the energy that it stores; limit of part A",
                    )
                    .known(SOFT),
                // 1/(2 N) of E0 at +-v/2, 1/(4 N) at v and 0.
                false => stopped(lost, share),
            });
            all.push(met.run.closing_row(&variant, 1e-3));
        }
    }
    Ok(all)
}

fn order(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const SIZES: [usize; 3] = [20, 40, 80];
    let mut all = Vec::new();
    for law in bench.laws() {
        let met = SIZES.map(|n| collide(bench, law, n, 1, [0.5 * V, -0.5 * V]));
        let [a, b, c] = met;
        let met = [a?, b?, c?];
        let restitution = met.each_ref().map(|m| (m.after[1] - m.after[0]) / V);
        for (n, e) in SIZES.iter().zip(restitution) {
            let row = CheckRow::new("restitution", format!("{law}, {n} shells"), "", e);
            all.push(row.reference(1.0, "[D] 1 as the mesh is refined"));
        }
        let halving = |q: [f64; 3]| (q[0] / q[2]).log2() / 2.0;
        let to_one = halving(restitution.map(|e| (1.0 - e).abs()));
        let variant = || format!("{law}, {SIZES:?} shells");
        all.push(
            CheckRow::new("order of 1 - restitution", variant(), "", to_one)
                .reference(1.0, "[D] first order, plus dispersion of the front"),
        );
        if !is_spring(law) {
            let order = halving(met.each_ref().map(|m| -m.work));
            all.push(
                CheckRow::new("order of the energy lost", variant(), "", order)
                    .near(1.0, 0.05, "[D] 1/2N"),
            );
        }
    }
    Ok(all)
}
