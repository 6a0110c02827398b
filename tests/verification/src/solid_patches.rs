//! Solids, single or few: patch test (A21), prescribed rotation (A19 a, b), blocks at their
//! stable step (A23 a, b), an elastic-plastic wave (A06), a thick cylinder that yields (C12), a
//! block sunk into another one (C06).

use super::bars::BAR;
use super::laws::Law;
use super::measure::{Push, displacement, drive, fields, lead, mean_velocity};
use super::row::CheckRow;
use super::scene::{Elastic, STEEL, Scene};
use super::solid_bars::INVISCID;
use super::walls::plastic_shock;
use super::{Bench, Check};
use crumple_worker::fem::elements::ElementFields;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::ControlFlow;

/// Check of A21 with solids.
pub const PATCH: Check = Check { name: "patch of seven solids", quick: true, run: patch };
/// Check of A19 (a), (b) with solids.
pub const TURNED: Check = Check { name: "prescribed rotation of a cube", quick: true, run: turned };
/// Check of A23 (a), (b): blocks.
pub const ROD: Check =
    Check { name: "rods and blocks of cubes at their step", quick: true, run: rod };
/// Check of A06 with solids.
pub const PLASTIC: Check = Check { name: "elastic-plastic wave, cubes", quick: true, run: plastic };
/// Check of C06 with solids.
pub const SUNK: Check = Check { name: "block sunk into a base", quick: true, run: sunk };

/// Safety below 1: a single cube is stable up to its own bound, but a run with prescribed motion
/// drifts.
const SAFE: &str = "safety = 0.8";

/// Inner nodes in the unit cube, near those of MacNeal & Harder; the stress does not depend on
/// their positions [m].
const INNER: [[f64; 3]; 8] = [
    [0.249, 0.342, 0.192],
    [0.826, 0.288, 0.288],
    [0.850, 0.649, 0.263],
    [0.273, 0.750, 0.230],
    [0.320, 0.250, 0.643],
    [0.677, 0.305, 0.683],
    [0.788, 0.693, 0.644],
    [0.165, 0.745, 0.702],
];
/// Faces of a cube, corners in the order in which the normal points inwards.
const FACES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];

fn patch(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    // So small that the change of shape is below the tolerance.
    let (scale, end) = (1e-6, 0.05);
    let mut all = Vec::new();
    for form in ["stiffness", "viscous", "assumed_strain"] {
        let mut scene = Scene::new(end);
        let corner = |i: usize| {
            [
                f64::from(u8::from((1..3).contains(&(i % 4)))),
                f64::from(u8::from(i % 4 > 1)),
                (i / 4) as f64,
            ]
        };
        let outer: Vec<u32> = (0..8).map(|i| scene.node(corner(i))).collect();
        let inner: Vec<u32> = INNER.iter().map(|&x| scene.node(x)).collect();
        for face in FACES {
            let (out, within) = (face.map(|i| outer[i]), face.map(|i| inner[i]));
            scene.solid(1, std::array::from_fn(|i| if i < 4 { out[i] } else { within[i - 4] }));
        }
        scene.solid(1, std::array::from_fn(|i| inner[i]));
        scene.elastic("soft", Elastic { e: 1e6, nu: 0.25, rho: 1000.0 });
        scene.solid_part(1, "soft", &format!("{INVISCID}\nhourglass = \"{form}\""));
        scene.fix(&outer, "x y z");
        let speed = |[x, y, z]: [f64; 3]| {
            let sum = x + y + z;
            [x, y, z].map(|own| 0.5e-3 * scale / end * (sum + own))
        };
        for &n in outer.iter().chain(&inner) {
            scene.start(&[n], speed(scene.at(n)), [0.0; 3]);
        }
        let run = bench.run(&format!("A21 solids {form}"), &scene, |e| {
            outer.iter().for_each(|&n| drive(e, n, speed(scene.at(n)), [0.0; 3]));
            ControlFlow::Continue(())
        })?;
        // The stress is that of the time before the last step.
        let reached = scale * (end - run.engine.clock.last_dt) / end;
        let worst = |parts: [usize; 3], expected: f64| {
            let far = |f: &ElementFields| {
                let off = parts.map(|c| f.stress[c] / reached);
                off.into_iter()
                    .max_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()))
                    .unwrap_or(f64::NAN)
            };
            let each = fields(&run.engine).iter().map(far).collect::<Vec<f64>>();
            each.into_iter()
                .max_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()))
                .unwrap_or(f64::NAN)
        };
        for (parts, what, expected) in [([0, 1, 2], "direct", 2000.0), ([3, 4, 5], "shear", 400.0)]
        {
            let quantity = format!("patch of solids, {what} stress of the worst element");
            let row =
                CheckRow::new(quantity, format!("hexahedron {form}"), "Pa", worst(parts, expected));
            all.push(row.near(expected, 1e-8, "[D] MacNeal & Harder, inner nodes of our own"));
        }
    }
    Ok(all)
}

/// Returns a point turned by an angle about an axis.
fn turn(x: [f64; 3], axis: usize, angle: f64) -> [f64; 3] {
    let (s, c) = angle.sin_cos();
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut y = x;
    (y[a], y[b]) = (c * x[a] - s * x[b], s * x[a] + c * x[b]);
    y
}

/// Moves a cube of 0.1 m along `place`, a function of the corner and the time over that of the
/// run; `at` receives the time and the fields.
fn led_cube(
    bench: &Bench,
    name: &str,
    steps: f64,
    place: impl Fn([f64; 3], f64) -> [f64; 3],
    mut at: impl FnMut(f64, &ElementFields),
) -> Result<(), String> {
    let side = 0.1;
    let scene = |end: f64| {
        let mut scene = Scene::new(end);
        let cube = scene.block(1, [1; 3], |p| p.map(|x| side * (x - 0.5)));
        scene.elastic("steel", STEEL);
        scene.solid_part(1, "steel", INVISCID);
        scene.fix(cube.all(), "x y z");
        scene.time(SAFE);
        scene
    };
    let dt = bench.model(name, &scene(1.0))?.first_dt().0;
    let end = steps * dt;
    let scene = scene(end);
    let corners: Vec<[f64; 3]> = (1..=8).map(|n| scene.at(n)).collect();
    let run = bench.run(name, &scene, |e| {
        let (t, dt) = (e.clock.time, e.clock.last_dt);
        if dt > 0.0 {
            // The stress is still that of the previous time.
            at((t - dt) / end, &fields(e)[0]);
            for (n, &x) in (1..).zip(&corners) {
                let pose = |t: f64| (place(x, t / end), [0.0; 3]);
                lead(e, n, pose(t - dt), pose(t));
            }
        }
        ControlFlow::Continue(())
    })?;
    if run.trouble {
        Err(format!("{name}: the run stopped because an element failed"))
    } else {
        Ok(())
    }
}

fn turned(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    let largest = |f: &ElementFields| f.stress.iter().fold(f.von_mises, |m, s| m.max(s.abs()));
    for steps in [100.0, 1000.0] {
        let mut worst = [0.0f64; 3];
        led_cube(
            bench,
            &format!("A19a cube {steps}"),
            steps,
            |x, t| turn(x, 2, TAU * t),
            |t, f| {
                // Largest errors until a quarter, a half and the whole turn.
                for (w, until) in worst.iter_mut().zip([FRAC_PI_2, PI, TAU]) {
                    if TAU * t <= until {
                        *w = w.max(largest(f) / STEEL.e);
                    }
                }
            },
        )?;
        for (w, degrees) in worst.iter().zip([90, 180, 360]) {
            let variant = format!("one cube, {steps} steps a turn");
            let quantity = format!("largest stress / E up to {degrees} degrees");
            all.push(CheckRow::new(quantity, variant, "", *w).at_most(1e-10, "exact"));
        }
    }
    // (b) stretched by 1e-3 in a tenth of the time, then turned about each axis across the stretch.
    for axis in [1, 2] {
        let place = |x: [f64; 3], t: f64| {
            let s = 1e-3 * (10.0 * t).min(1.0);
            turn([x[0] * (1.0 + s), x[1], x[2]], axis, TAU * (t - 0.1).max(0.0) / 0.9)
        };
        let (mut before, mut worst, mut end) = (None, [0.0f64; 2], 0.0);
        led_cube(bench, &format!("A19b cube {axis}"), 1000.0, place, |t, f| {
            if t > 0.11 {
                let now = [f.von_mises, f.stress[0] + f.stress[1] + f.stress[2]];
                let first = *before.get_or_insert(now);
                worst = std::array::from_fn(|i| worst[i].max((now[i] / first[i] - 1.0).abs()));
                end = f.stress[0];
            }
        })?;
        let variant = format!("one cube, about {}", ["x", "y", "z"][axis]);
        for (w, what) in worst.into_iter().zip(["von Mises stress", "trace"]) {
            let quantity = format!("change of the {what} of a stretched cube that turns");
            all.push(CheckRow::new(quantity, &variant, "", w).at_most(1e-10, "exact"));
        }
    }
    Ok(all)
}

/// Returns true if the energy of a block grows at a step of `limit` L/c_d. The block has n cells
/// each way, their sides are in units of L = 10 mm, and all of its modes are excited.
fn grows(
    bench: &Bench,
    name: &str,
    (n, sides): ([usize; 3], [f64; 3]),
    material: Elastic,
    limit: f64,
    steps: u64,
) -> Result<bool, String> {
    let side = 0.01;
    let nu = material.nu;
    let fast = ((1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))).sqrt() * material.c();
    let scene = |safety: f64| {
        let mut scene = Scene::new(1.0);
        let block =
            scene.block(1, n, |p| std::array::from_fn(|c| side * sides[c] * n[c] as f64 * p[c]));
        scene.elastic("steel", material);
        scene.solid_part(1, "steel", INVISCID);
        scene.time(&format!("safety = {safety:?}\nmax_cycles = {steps}"));
        for (i, &node) in block.all().iter().enumerate() {
            scene.start(
                &[node],
                std::array::from_fn(|c| 1e-5 * (((7 * i + 3 * c) * (i + 1)) % 11) as f64 - 5e-5),
                [0.0; 3],
            );
        }
        scene
    };
    let unit = bench.model(name, &scene(1.0))?.first_dt().0 * fast / side;
    let (mut start, mut grown) = (0.0, false);
    let run = bench.run(name, &scene(limit / unit), |e| {
        let now = e.ledger.energies(&e.nodes, &e.blocks).values().kinetic.abs();
        if e.clock.cycle == 0 {
            start = now;
        }
        // Near the limit the energy of a mode rises up to 1/(1 - (w dt/2)^2) times its value
        // before it falls again.
        grown |= now.is_nan() || now > 1e6 * start;
        if grown { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    Ok(grown || run.trouble)
}

fn rod(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const CUBES: &str = "[D] eigenvalues, catalogue A23";
    let mut all = Vec::new();
    /// Name, cells each way, their sides, material, limit, fractions of it below and above,
    /// source.
    type Case = (&'static str, [usize; 3], [f64; 3], Elastic, f64, [f64; 2], &'static str);
    const CUBE: [f64; 3] = [1.0; 3];
    let cases: [Case; 9] = [
        ("rod of 20 cubes, nu = 0", [20, 1, 1], CUBE, BAR, 1.0, [0.999, 1.001], "[D] L/c exactly"),
        ("row of 8 cubes, nu = 0.3", [8, 1, 1], CUBE, STEEL, 0.811, [0.98, 1.02], CUBES),
        ("6 by 6 by 1 cubes, nu = 0.3", [6, 6, 1], CUBE, STEEL, 0.899, [0.98, 1.02], CUBES),
        ("2 by 2 by 2 cubes, nu = 0.3", [2; 3], CUBE, STEEL, 0.939, [0.98, 1.02], CUBES),
        ("3 by 3 by 3 cubes, nu = 0.3", [3; 3], CUBE, STEEL, 0.931, [0.98, 1.02], CUBES),
        ("4 by 4 by 4 cubes, nu = 0.3", [4; 3], CUBE, STEEL, 0.971, [0.98, 1.02], CUBES),
        ("8 by 8 by 8 cubes, nu = 0.3", [8; 3], CUBE, STEEL, 0.981, [0.98, 1.02], CUBES),
        ("flat brick 1 by 1 by 0.1", [1; 3], [1.0, 1.0, 0.1], STEEL, 0.0998, [0.98, 1.02], CUBES),
        ("needle 1 by 0.1 by 0.1", [1; 3], [1.0, 0.1, 0.1], STEEL, 0.0836, [0.98, 1.02], CUBES),
    ];
    for (what, n, sides, material, limit, shares, source) in cases {
        for (share, expected) in shares.into_iter().zip([0.0, 1.0]) {
            let grown = grows(
                bench,
                &format!("A23 {what} {share}"),
                (n, sides),
                material,
                share * limit,
                4000,
            )?;
            let row = CheckRow::new(
                format!("grows at {share} of {limit} L/c_d in 4000 steps"),
                what,
                "",
                f64::from(u8::from(grown)),
            );
            all.push(row.within(expected, 0.0, source));
        }
    }
    Ok(all)
}

fn plastic(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 200;
    let (length, v, yield_stress) = (1.0, 20.0, 200e6);
    let tangent = BAR.e / 100.0;
    // True stress over logarithmic plastic strain.
    let modulus = BAR.e * tangent / (BAR.e - tangent);
    let time = length / BAR.c();
    let side = length / N as f64;
    let mut scene = Scene::new(1.8 * time);
    let bar = scene.block(1, [N, 1, 1], |p| [length * p[0], side * p[1], side * p[2]]);
    scene.plastic("steel", BAR, yield_stress, modulus);
    scene.solid_part(1, "steel", INVISCID);
    scene.start(bar.all(), [-v, 0.0, 0.0], [0.0; 3]);
    scene.wall([0.0; 3], [1.0, 0.0, 0.0], 0.0);
    let mut push = Push::default();
    let run = bench.watch("A06 cubes", &scene, |e| {
        push.add_sample(e.clock.time, e.constraints.walls.impulse(0)[0])
    })?;
    let [from, to] = [0.02, 0.1].map(|x| bar.at([(x * N as f64) as usize, 0, 0]));
    let strain = (displacement(&run.engine, from)[0] - displacement(&run.engine, to)[0]) / 0.08;
    let stress = push.mean_force(0.4 * time, 1.7 * time) / (side * side);
    let variant = format!("wall, {N} cubes, j2");
    let (finite_stress, finite_strain) =
        plastic_shock(yield_stress, tangent, v - yield_stress / (BAR.rho * BAR.c()));
    // At 3 % compression stiffens the nominal tangent E_t by 2 sigma_y/E_t: the catalogue
    // assumes small strains.
    Ok(run.with_energy(
        &variant,
        1e-3,
        vec![
            CheckRow::new("stress behind the plastic front", &variant, "MPa", 1e-6 * stress)
                .reference(261.2, "[D] sigma_y + rho c_t (V - v_y), small strains"),
            CheckRow::new("strain behind the plastic front", &variant, "", strain)
                .reference(0.0301, "[D] sigma_y/E + (V - v_y)/c_t, small strains"),
            CheckRow::new(
                "stress behind the plastic front, finite strain",
                &variant,
                "MPa",
                1e-6 * stress,
            )
            .near(1e-6 * finite_stress, 0.02, "[D] shock in nominal stress"),
            CheckRow::new("strain behind the plastic front, finite strain", &variant, "", strain)
                .near(finite_strain, 0.02, "[D] shock in nominal stress"),
        ],
    ))
}

fn sunk(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (side, depth) = (0.01, 1e-4);
    let mut all = Vec::new();
    for law in Law::ALL {
        let mut scene = Scene::new(2e-4);
        let base = scene.block(1, [3, 3, 1], |p| {
            [3.0 * side * (p[0] - 0.5), 3.0 * side * (p[1] - 0.5), side * (p[2] - 1.0)]
        });
        let block = scene
            .block(2, [2; 3], |p| [side * (p[0] - 0.5), side * (p[1] - 0.5), side * p[2] - depth]);
        scene.elastic("steel", STEEL);
        (1..=2).for_each(|part| scene.solid_part(part, "steel", INVISCID));
        scene.fix(base.all(), "x y z");
        scene.add(&law.table());
        let (mut fastest, mut energy) = (0.0f64, 0.0f64);
        let run = bench.run(&format!("C06 block {}", law.name), &scene, |e| {
            for &n in block.all() {
                fastest = fastest.max(mean_velocity(e, &[n], 2).abs());
            }
            let now = e.ledger.energies(&e.nodes, &e.blocks).values();
            energy = energy.max(now.kinetic + now.internal + now.hourglass);
            ControlFlow::Continue(())
        })?;
        let variant = format!("{}, block of 10 mm, 0.1 mm inside a fixed base", law.name);
        const LIMIT: &str = "limit of the catalogue";
        let (fastest, energy) =
            if run.trouble { (f64::INFINITY, f64::INFINITY) } else { (fastest, energy) };
        all.push(
            CheckRow::new("largest velocity of a node", &variant, "m/s", fastest)
                .at_most(0.1, LIMIT),
        );
        all.push(CheckRow::new("largest energy given", &variant, "J", energy).at_most(1e-3, LIMIT));
    }
    Ok(all)
}
