//! Frequencies of beams and plates of shells (A15, A16), with added masses (A17), and spinning
//! bodies (A19 c, d).
//!
//! A body starts with velocities in the shape of a mode. The frequency follows from the zero
//! crossings of its amplitude, which is the displacement projected on that shape.

use super::bars::BAR;
use super::measure::{Crossings, amplitude, fields, mass, position};
use super::row::CheckRow;
use super::scene::{Elastic, Grid, STEEL, Scene};
use super::{Bench, Check};
use std::f64::consts::{PI, TAU};

/// Check of A15.
pub const BEAMS: Check = Check { name: "beams", quick: true, run: beams };
/// Check of A15, free ends on finer meshes.
pub const FREE_BEAM: Check = Check { name: "free beam, order", quick: false, run: free_beam };
/// Check of A16, simply supported.
pub const PLATE: Check = Check { name: "simply supported plate", quick: false, run: supported };
/// Check of A16, clamped and cantilevered.
pub const CLAMPED_PLATE: Check =
    Check { name: "clamped plate, cantilever plate", quick: false, run: clamped_plate };
/// Check of A16, FV12.
pub const FREE_PLATE: Check = Check { name: "free plate FV12", quick: false, run: free_plate };
/// Check of A17.
pub const MASSES: Check = Check { name: "added masses", quick: true, run: masses };
/// Check of A19 (c).
pub const SPINNING_BAR: Check = Check { name: "spinning bar", quick: false, run: spinning_bar };
/// Check of A19 (d).
pub const SPINNING_SHELL: Check =
    Check { name: "spinning shell", quick: true, run: spinning_shell };

const INERTIA: &str = "the rotational inertia of a corner is raised to A/7 per mass at nu = 0 \
                       (A/11.7 at nu = 0.3) to keep a large stable step. Eigenvalues of the \
                       assembled system (tests/references/plates.py) give each frequency to 0.04 \
                       %. The error of a free beam has two parts: masses lumped on 20 cells cause \
                       0.8, 1.2 and 1.5 %, the raised inertia causes 0.8, 1.7 and 2.8 %. In the \
                       plates, lumped masses cause about half of the error. Both parts vanish with \
                       the second order of the mesh size. Softer shear (residual bending, MacNeal \
                       1978) is not used: with it, 2.6 times its own inertia is enough for a thin \
                       cell. But frequencies of free beams were still 1.0, 1.9 and 2.8 % too low, \
                       and deflections of coarse plates grew by 4 to 7 % (B08)";

/// Initial velocity, small enough that no result depends on it [m/s].
const SPEED: f64 = 1e-3;
/// Length of the strip of A15 [m].
const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.02;
const DEPTH: f64 = 0.004;

/// Mode over 0..1: returns the deflection and its slope.
pub type Mode = Box<dyn Fn(f64) -> (f64, f64)>;

/// Returns the mode `cosh - cos - s (sinh - sin)` of a clamped beam, or with plus signs of a
/// free one, with its wave number.
pub fn clamped(k: f64, s: f64, sign: f64) -> Mode {
    Box::new(move |x| {
        let z = k * x;
        let value = z.cosh() - sign * z.cos() - s * (z.sinh() - sign * z.sin());
        (value, k * (z.sinh() + sign * z.sin() - s * (z.cosh() - sign * z.cos())))
    })
}

/// Gives a strip or plate in the xy plane a velocity along z in the shape of `w`, and the spins
/// that belong to it. `w` returns the deflection and its slopes over x and y [1/m]. Returns the
/// shape.
pub fn pluck(
    scene: &mut Scene,
    nodes: &[u32],
    w: impl Fn([f64; 3]) -> (f64, [f64; 2]),
) -> Vec<(u32, f64)> {
    let mut shape = Vec::new();
    for &n in nodes {
        let (value, slope) = w(scene.at(n));
        scene.start(&[n], [0.0, 0.0, SPEED * value], [SPEED * slope[1], -SPEED * slope[0], 0.0]);
        shape.push((n, value));
    }
    shape
}

/// Returns the frequency of a shape with displacement along one axis [Hz].
pub fn frequency(
    bench: &Bench,
    name: &str,
    scene: &Scene,
    shape: &[(u32, f64)],
    axis: usize,
) -> Result<f64, String> {
    let mut crossings = Crossings::default();
    bench.watch(name, scene, |e| crossings.add_sample(e.clock.time, amplitude(e, shape, axis)))?;
    Ok(crossings.frequency())
}

fn strip(scene: &mut Scene, elements: usize) -> Grid {
    let grid = scene.grid(1, [elements, 2], |x, y| [LENGTH * x, WIDTH * y, 0.0]);
    scene.elastic("steel", BAR);
    scene.part(1, "steel", DEPTH, "");
    grid
}

fn beams(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 20;
    // Wave numbers k L of Euler-Bernoulli beams; `s` fulfils the conditions at the far end.
    let cantilever = |k: f64| clamped(k, (k.cosh() + k.cos()) / (k.sinh() + k.sin()), 1.0);
    let ends = |k: f64, sign: f64| clamped(k, (k.cosh() - k.cos()) / (k.sinh() - k.sin()), sign);
    let sine =
        |n: f64| -> Mode { Box::new(move |x| ((n * PI * x).sin(), n * PI * (n * PI * x).cos())) };
    let (of_clamped, of_both) =
        ([1.87510407, 4.69409113, 7.85475744], [4.73004074, 7.85320462, 10.99560784]);
    type Case =
        (&'static str, [f64; 3], Box<dyn Fn(usize) -> Mode>, Box<dyn Fn(&mut Scene, &Grid)>);
    let cases: [Case; 4] = [
        (
            "cantilever",
            [83.55, 523.6, 1466.1],
            Box::new(move |i| cantilever(of_clamped[i])),
            Box::new(|s, g| s.fix(&g.row(0), "x y z rx ry rz")),
        ),
        (
            "simply supported",
            [234.40, 936.0, 2110.8],
            Box::new(move |i| sine(1.0 + i as f64)),
            Box::new(|s, g| [0, N].iter().for_each(|&i| s.fix(&g.row(i), "z"))),
        ),
        (
            "clamped-clamped",
            [531.7, 1465.5, 2873.0],
            Box::new(move |i| ends(of_both[i], 1.0)),
            Box::new(|s, g| [0, N].iter().for_each(|&i| s.fix(&g.row(i), "x y z rx ry rz"))),
        ),
        (
            "free-free",
            [531.7, 1465.5, 2873.0],
            Box::new(move |i| ends(of_both[i], -1.0)),
            Box::new(|_, _| {}),
        ),
    ];
    let mut all = Vec::new();
    for (support, expected, mode, hold) in cases {
        for (i, &f) in expected.iter().enumerate() {
            let mut scene = Scene::new(3.2 / f);
            let grid = strip(&mut scene, N);
            hold(&mut scene, &grid);
            let of = mode(i);
            let shape = pluck(&mut scene, grid.all(), |x| {
                let (value, slope) = of(x[0] / LENGTH);
                (value, [slope / LENGTH, 0.0])
            });
            let name = format!("A15 {support} mode {}", i + 1);
            let ours = frequency(bench, &name, &scene, &shape, 2)?;
            let tolerance = if i == 2 { 0.015 } else { 0.01 };
            let quantity = format!("{support}, frequency {}", i + 1);
            let source = if support == "simply supported" && i < 2 {
                "[D] Timoshenko"
            } else {
                "[D] Euler-Bernoulli"
            };
            let row =
                CheckRow::new(quantity, "20 by 2 shells", "Hz", ours).near(f, tolerance, source);
            all.push(row.known(INERTIA));
        }
    }
    Ok(all)
}

/// Compares the first frequencies of a free beam on meshes of 20, 40 and 80 shells along it, and
/// the order of their error.
fn free_beam(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for (k, f, number) in [(4.73004074, 531.7, 1), (7.85320462, 1465.5, 2)] {
        let mut errors = Vec::new();
        for n in [20, 40, 80] {
            let mut scene = Scene::new(3.2 / f);
            let grid = scene.grid(1, [n, n / 10], |x, y| [LENGTH * x, WIDTH * y, 0.0]);
            scene.elastic("steel", BAR);
            scene.part(1, "steel", DEPTH, "");
            let of = clamped(k, (k.cosh() - k.cos()) / (k.sinh() - k.sin()), -1.0);
            let shape = pluck(&mut scene, grid.all(), |x| {
                let (value, slope) = of(x[0] / LENGTH);
                (value, [slope / LENGTH, 0.0])
            });
            let ours = frequency(bench, &format!("A15 free {number} by {n}"), &scene, &shape, 2)?;
            let variant = format!("{n} by {} shells, series of meshes", n / 10);
            all.push(
                CheckRow::new(format!("free-free, frequency {number}"), variant, "Hz", ours)
                    .reference(f, "[D] Euler-Bernoulli"),
            );
            errors.push(ours - f);
        }
        // The differences between meshes remove shear and rotary inertia of the beam itself.
        let order = ((errors[1] - errors[0]) / (errors[2] - errors[1])).log2();
        let quantity = format!("free-free, frequency {number}, order");
        all.push(CheckRow::new(quantity, "20, 40, 80 shells", "", order).near(
            2.0,
            0.15,
            "[D] second order",
        ));
    }
    Ok(all)
}

fn supported(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 16;
    let side = 0.2;
    let mut all = Vec::new();
    for (p, q, f) in [(1.0, 1.0, 491.0), (1.0, 2.0, 1224.8), (2.0, 2.0, 1955.5), (1.0, 3.0, 2440.9)]
    {
        let mut scene = Scene::new(3.2 / f);
        let grid = scene.grid(1, [N, N], |x, y| [side * x, side * y, 0.0]);
        scene.elastic("steel", STEEL);
        scene.part(1, "steel", 0.004, "");
        // Hard support: the edge does not rotate about its normal either.
        for i in [0, N] {
            scene.fix(&grid.row(i), "z rx");
            let column: Vec<u32> = (0..=N).map(|j| grid.at(j, i)).collect();
            scene.fix(&column, "z ry");
        }
        let (p, q) = (p * PI / side, q * PI / side);
        let shape = pluck(&mut scene, grid.all(), |x| {
            let (a, b) = (p * x[0], q * x[1]);
            (a.sin() * b.sin(), [p * a.cos() * b.sin(), q * a.sin() * b.cos()])
        });
        let mode = format!("({:.0},{:.0})", p * side / PI, q * side / PI);
        let ours = frequency(bench, &format!("A16 supported {mode}"), &scene, &shape, 2)?;
        all.push(
            CheckRow::new(format!("frequency {mode}"), "16 by 16 shells", "Hz", ours)
                .near(f, 0.01, "[D] Mindlin")
                .known(INERTIA),
        );
    }
    Ok(all)
}

fn clamped_plate(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 16;
    let (side, first) = (0.2, 4.73004074f64);
    let s = (first.cosh() - first.cos()) / (first.sinh() - first.sin());
    let both = clamped(first, s, 1.0);
    let root = 1.87510407f64;
    let one = clamped(root, (root.cosh() + root.cos()) / (root.sinh() + root.sin()), 1.0);
    let mut all = Vec::new();
    for (what, f) in [("clamped", 896.4), ("cantilever", 86.5)] {
        let mut scene = Scene::new(6.2 / f);
        let grid = scene.grid(1, [N, N], |x, y| [side * x, side * y, 0.0]);
        scene.elastic("steel", STEEL);
        scene.part(1, "steel", 0.004, "");
        let held = if what == "clamped" { grid.rim() } else { grid.row(0) };
        scene.fix(&held, "x y z rx ry rz");
        // These shapes are near the modes; over many periods the zeros are those of the mode.
        let shape = pluck(&mut scene, grid.all(), |x| {
            let ((a, of_a), (b, of_b)) = match what {
                "clamped" => (both(x[0] / side), both(x[1] / side)),
                _ => (one(x[0] / side), (1.0, 0.0)),
            };
            (a * b, [of_a * b / side, a * of_b / side])
        });
        let ours = frequency(bench, &format!("A16 {what} plate"), &scene, &shape, 2)?;
        all.push(
            CheckRow::new(format!("{what} plate, frequency 1"), "16 by 16 shells", "Hz", ours)
                .reference(f, "[U] coefficients 35.985 and 3.471"),
        );
    }
    Ok(all)
}

fn free_plate(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 16;
    let material = Elastic { e: 200e9, nu: 0.3, rho: 8000.0 };
    type Shape = fn(f64, f64) -> (f64, [f64; 2]);
    // These shapes are near the modes and have their symmetry; x and y run from -1 to 1. Over
    // many periods the zeros are those of the mode.
    let modes: [(f64, Shape); 3] = [
        (1.622, |x, y| (x * y, [y, x])),
        (2.360, |x, y| (x * x - y * y, [2.0 * x, -2.0 * y])),
        (2.922, |x, y| (x * x + y * y - 2.0 / 3.0, [2.0 * x, 2.0 * y])),
    ];
    let mut all = Vec::new();
    for (number, (f, of)) in (1..).zip(modes) {
        let mut scene = Scene::new(6.2 / f);
        let grid = scene.grid(1, [N, N], |x, y| [10.0 * x, 10.0 * y, 0.0]);
        scene.elastic("steel", material);
        scene.part(1, "steel", 0.05, "");
        let shape = pluck(&mut scene, grid.all(), |x| {
            let (value, slope) = of(x[0] / 5.0 - 1.0, x[1] / 5.0 - 1.0);
            (value, slope.map(|s| s / 5.0))
        });
        let ours = frequency(bench, &format!("A16 free plate {f}"), &scene, &shape, 2)?;
        all.push(
            CheckRow::new(format!("free plate, frequency {number}"), "16 by 16 shells", "Hz", ours)
                .near(f, 0.01, "[V:S10] NAFEMS FV12")
                .known(INERTIA),
        );
    }
    Ok(all)
}

fn masses(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    // Bar of 1 m, fixed at one end: x tan x = m/M.
    const N: usize = 50;
    let (length, thickness) = (1.0, 0.01);
    let width = length / N as f64;
    let bar_mass = BAR.rho * length * width * thickness;
    for (times, x, f) in [(1.0, 0.86033, 708.2), (10.0, 0.31105, 256.05)] {
        let mut scene = Scene::new(3.2 / f);
        let bar = scene.grid(1, [N, 1], |x, y| [length * x, width * y, 0.0]);
        scene.elastic("steel", BAR);
        scene.part(1, "steel", thickness, "points = 2");
        scene.fix(&bar.row(0), "x");
        scene.mass(&bar.row(N), times * bar_mass);
        let mut shape = Vec::new();
        for &n in bar.all() {
            let phi = (x * scene.at(n)[0] / length).sin();
            scene.start(&[n], [SPEED * phi, 0.0, 0.0], [0.0; 3]);
            shape.push((n, phi));
        }
        let ours = frequency(bench, &format!("A17 bar {times}"), &scene, &shape, 0)?;
        let quantity = format!("bar with {times} times its mass at the end, frequency");
        all.push(CheckRow::new(quantity, "50 shells", "Hz", ours).near(
            f,
            0.005,
            "[D] x tan x = m/M",
        ));
    }
    for (times, f) in [(1.0, 37.006), (5.0, 17.987)] {
        let mut scene = Scene::new(2.2 / f);
        let grid = strip(&mut scene, 20);
        scene.fix(&grid.row(0), "x y z rx ry rz");
        scene.mass(&grid.row(20), times * BAR.rho * LENGTH * WIDTH * DEPTH);
        // Shape under a force at the tip: near the first mode if a mass is there.
        let shape = pluck(&mut scene, grid.all(), |x| {
            let z = x[0] / LENGTH;
            (0.5 * z * z * (3.0 - z), [(3.0 * z - 1.5 * z * z) / LENGTH, 0.0])
        });
        let ours = frequency(bench, &format!("A17 cantilever {times}"), &scene, &shape, 2)?;
        let quantity = format!("cantilever with {times} times its mass at the tip, frequency");
        all.push(CheckRow::new(quantity, "20 by 2 shells", "Hz", ours).near(f, 0.005, "[D]"));
    }
    Ok(all)
}

fn spinning_bar(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 40;
    let spin = 1000.0;
    let period = 2.0 * LENGTH / BAR.c();
    // Ten turns; means over a whole number of axial periods.
    let mut scene = Scene::new(10.0 * TAU / spin);
    let bar = scene.grid(1, [N, 2], |x, y| [LENGTH * (x - 0.5), WIDTH * (y - 0.5), 0.0]);
    scene.elastic("steel", BAR);
    scene.part(1, "steel", DEPTH, "");
    scene.add(&format!(
        "[[initial_velocity]]\nvelocity = [0.0, 0.0, 0.0]\nspin = [0.0, 0.0, {spin:?}]"
    ));
    let (mut stress, mut stretch, mut samples) = (0.0, 0.0, 0.0);
    let until = (10.0 * TAU / spin / period).floor() * period;
    let run = bench.watch("A19c spinning bar", &scene, |e| {
        // Every eighth step is enough for a mean.
        if e.clock.cycle % 8 != 1 || e.clock.time > until {
            return;
        }
        // In the middle: two elements on either side of the centre, in the direction of the bar.
        let (a, b) = (position(e, bar.at(0, 1)), position(e, bar.at(N, 1)));
        let long = (0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt();
        let t: [f64; 3] = std::array::from_fn(|c| (b[c] - a[c]) / long);
        let all = fields(e);
        let along =
            |s: &[f64; 6]| s[0] * t[0] * t[0] + s[1] * t[1] * t[1] + 2.0 * s[3] * t[0] * t[1];
        let middle = [N - 2, N - 1, N, N + 1].map(|i| along(&all[i].stress));
        stress += e.clock.last_dt * middle.iter().sum::<f64>() / 4.0;
        stretch += e.clock.last_dt * 0.5 * (long - LENGTH);
        samples += e.clock.last_dt;
    })?;
    let variant = "40 by 2 shells, ten turns";
    let [_, start] = run.momentum;
    let end = crumple_worker::energy::momentum(&run.engine.nodes).1;
    Ok(run.with_energy(
        variant,
        1e-3,
        vec![
            CheckRow::new("mean stress at the middle", variant, "MPa", 1e-6 * stress / samples)
                .near(39.25, 0.01, "[D] rho w^2 L^2/8"),
            CheckRow::new("mean stretch of an end", variant, "um", 1e6 * stretch / samples).near(
                12.46,
                0.01,
                "[D] rho w^2 (L/2)^3/3E",
            ),
            CheckRow::new(
                "change of angular momentum",
                variant,
                "",
                (end[2] / start[2] - 1.0).abs(),
            )
            .at_most(1e-10, "exact"),
            CheckRow::new("mass", variant, "kg", mass(&run.engine, bar.all())).near(
                BAR.rho * LENGTH * WIDTH * DEPTH,
                1e-12,
                "exact",
            ),
        ],
    ))
}

fn spinning_shell(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (side, spin) = (0.01, 100.0);
    let mut all = Vec::new();
    for (how, axis) in [("in its plane", [0.0, 0.0, spin]), ("out of its plane", [spin, 0.0, 0.0])]
    {
        let mut scene = Scene::new(10.0 * TAU / spin);
        let grid = scene.grid(1, [1, 1], |x, y| [side * (x - 0.5), side * (y - 0.5), 0.0]);
        scene.elastic("steel", STEEL);
        scene.part(1, "steel", 1e-3, "");
        scene.add(&format!("[[initial_velocity]]\nvelocity = [0.0, 0.0, 0.0]\nspin = {axis:?}"));
        let (mut early, mut late) = ([0.0f64; 2], [0.0f64; 2]);
        let run = bench.watch(&format!("A19d spinning {how}"), &scene, |e| {
            let x = |i, j| position(e, grid.at(i, j));
            let length = |a: [f64; 3], b: [f64; 3]| {
                (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
            };
            let diagonal = length(x(0, 0), x(1, 1)) / (side * 2f64.sqrt()) - 1.0;
            let turns = e.clock.time * spin / TAU;
            // The stretch oscillates about that of the rotation. A drift is a change of the mean
            // from turn to turn.
            let mean = if turns < 1.0 { &mut early } else { &mut late };
            if !(1.0..9.0).contains(&turns) {
                *mean = [mean[0] + e.clock.last_dt * diagonal, mean[1] + e.clock.last_dt];
            }
        })?;
        let drift = (late[0] / late[1] - early[0] / early[1]).abs();
        let variant = format!("one shell, {how}, ten turns");
        all.push(
            CheckRow::new("drift of the size", &variant, "", drift)
                .at_most(1e-6, "limit of the catalogue"),
        );
        all.extend(run.energy_rows(&variant, 1e-3));
    }
    Ok(all)
}
