//! Shells that buckle and fold: tubes crushed along their axis (B11, B12, B13), and a beam bent by a blow (B04).

use super::measure::{displacement, mean_velocity};
use super::row::Row;
use super::scene::{Elastic, STEEL, Scene};
use super::{Bench, Check};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// B04.
pub const BEAM: Check = Check { name: "impulsively loaded beam", quick: false, run: beam };
/// B11.
pub const SQUARE: Check = Check { name: "square tube", quick: false, run: square };
/// B12.
pub const MEAN_FORCE: Check = Check { name: "square tube, mean force formula", quick: false, run: mean_force };
/// B13.
pub const ROUND: Check = Check { name: "circular tube", quick: false, run: round };

fn beam(bench: &Bench) -> Result<Vec<Row>, String> {
    const N: usize = 50;
    let (half, width, depth, loaded) = (0.127, 0.01524, 3.175e-3, 0.0254);
    let mut scene = Scene::new(2e-3);
    // A quarter: the middle at x = 0, the axis at y = 0, clamped at x = 127 mm.
    let grid = scene.grid(1, [N, 6], |x, y| [half * x, width * y, 0.0]);
    scene.plastic("aluminium", Elastic { e: 71.71e9, nu: 0.33, rho: 2789.0 }, 285.4e6, 0.0);
    scene.part(1, "aluminium", depth, "points = 5");
    scene.fix(&grid.row(N), "x y z rx ry rz");
    scene.fix(&grid.row(0), "x ry rz");
    let axis: Vec<u32> = (0..=N).map(|i| grid.at(i, 0)).collect();
    scene.fix(&axis, "y rx rz");
    for i in 0..=N {
        let x = half * i as f64 / N as f64;
        // The row on the border carries the momentum of the half that is loaded.
        let share = if (x - loaded).abs() < 1e-9 { 0.5 } else { 1.0 };
        if x < loaded + 1e-9 {
            scene.start(&grid.row(i), [0.0, 0.0, -127.0 * share], [0.0; 3]);
        }
    }
    let (mut peak, mut when, mut residual, mut time) = (0.0, 0.0, 0.0, 0.0);
    let mut early = Vec::new();
    let run = bench.watch("B04 beam", &scene, |e| {
        let (t, w) = (e.clock.time, -displacement(e, grid.at(0, 0))[2]);
        if w > peak {
            (peak, when) = (w, t);
        }
        if early.len() < 4 && t >= 1e-4 * (early.len() + 1) as f64 {
            early.push(w);
        }
        if t > 1.2e-3 {
            residual += w * e.clock.last_dt;
            time += e.clock.last_dt;
        }
    })?;
    let variant = "belytschko_tsay, quarter of 50 by 6, 5 points";
    const C: &str = "[C] layered fibre beam code";
    let mut all = vec![
        Row::new("peak deflection", variant, "mm", 1e3 * peak).near(18.69, 0.04, C),
        Row::new("time of the peak", variant, "us", 1e6 * when)
            .beside(475.0, "[C] flat maximum from 480 to 620 us with BT shells"),
        Row::new("mean deflection from 1.2 to 2 ms", variant, "mm", 1e3 * residual / time).near(17.6, 0.04, C),
    ];
    for ((w, expected), t) in early.iter().zip([10.98, 13.11, 15.68, 18.21]).zip([100, 200, 300, 400]) {
        all.push(Row::new(format!("deflection at {t} us"), variant, "mm", 1e3 * w).near(expected, 0.04, C));
    }
    all.extend(run.energy_rows(variant, 1e-2));
    Ok(all)
}

/// A tube that stands on a rigid wall and is crushed by a mass.
struct Tube<'a> {
    /// Section: from 0..1 around to x, y, and the outward normal, with the depth of the trigger there [m].
    section: &'a dyn Fn(f64) -> ([f64; 2], [f64; 2]),
    around: usize,
    along: usize,
    length: f64,
    /// Heights between which the trigger is half a sine [m].
    trigger: [f64; 2],
    thickness: f64,
    yield_stress: f64,
    modulus: f64,
    mass: f64,
    speed: f64,
    friction: f64,
}

impl Tube<'_> {
    /// Crushes it by `depth`; energy that the head has lost at each of `at` [m], in J, and the energy error.
    fn crush(&self, bench: &Bench, name: &str, law: &str, at: &[f64]) -> Result<(Vec<f64>, f64), String> {
        let depth = at.last().copied().unwrap_or(0.0);
        let mut scene = Scene::new(1.3 * depth / self.speed);
        let (m, n) = (self.around, self.along);
        let mut nodes = Vec::new();
        for i in 0..=n {
            let z = self.length * i as f64 / n as f64;
            let [low, high] = self.trigger;
            let wave = if z > low && z < high { (PI * (z - low) / (high - low)).sin() } else { 0.0 };
            for k in 0..m {
                let ([x, y], [dx, dy]) = (self.section)(k as f64 / m as f64);
                nodes.push(scene.node([x + wave * dx, y + wave * dy, z]));
            }
        }
        for i in 0..n {
            for k in 0..m {
                let (a, b) = (i * m + k, i * m + (k + 1) % m);
                scene.shell(1, &[nodes[a], nodes[b], nodes[b + m], nodes[a + m]]);
            }
        }
        scene.plastic("steel", STEEL, self.yield_stress, self.modulus);
        scene.part(1, "steel", self.thickness, "points = 5");
        let top = nodes[n * m..].to_vec();
        scene.fix(&top, "x y rx ry rz");
        scene.mass(&top, self.mass);
        scene.start(&nodes, [0.0, 0.0, -self.speed], [0.0; 3]);
        scene.wall([0.0; 3], [0.0, 0.0, 1.0], self.friction);
        scene.add(&format!("[contact]\nlaw = \"{law}\"\nfriction = {:?}", self.friction));
        let mut absorbed = Vec::new();
        let run = bench.run(name, &scene, |e| {
            let mean = top.iter().map(|&n| -displacement(e, n)[2]).sum::<f64>() / top.len() as f64;
            while at.get(absorbed.len()).is_some_and(|&a| mean >= a) {
                let v = mean_velocity(e, &top, 2);
                absorbed.push(0.5 * self.mass * (self.speed * self.speed - v * v));
            }
            if absorbed.len() == at.len() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        if run.trouble || absorbed.len() < at.len() {
            return Err(format!("{name} ended at {:e} s, before it was crushed by {depth} m", run.engine.clock.time));
        }
        Ok((absorbed, run.energy_error))
    }
}

/// A square around the origin from 0..1, and the trigger of B11: inwards on the x faces, outwards on the y faces.
fn square_section(side: f64, depth: f64) -> impl Fn(f64) -> ([f64; 2], [f64; 2]) {
    move |s| {
        let h = 0.5 * side;
        let (face, t) = ((4.0 * s).floor() as usize, (4.0 * s).fract());
        let (along, bulge) = (side * t - h, depth * (PI * t).sin());
        match face {
            0 => ([h, along], [-bulge, 0.0]),
            1 => ([-along, h], [0.0, bulge]),
            2 => ([-h, -along], [bulge, 0.0]),
            _ => ([along, -h], [0.0, -bulge]),
        }
    }
}

fn square(bench: &Bench) -> Result<Vec<Row>, String> {
    const AT: [f64; 7] = [0.025, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175];
    const ABSORBED: [f64; 7] = [1.04, 1.75, 2.55, 3.22, 3.96, 4.63, 5.37];
    let section = square_section(0.06, 5e-4);
    let tube = Tube {
        section: &section,
        around: 48,
        along: 60,
        length: 0.3,
        trigger: [0.01, 0.04],
        thickness: 1.5e-3,
        yield_stress: 250e6,
        modulus: 1e9,
        mass: 650.0,
        speed: 15.0,
        friction: 0.1,
    };
    let mut all = Vec::new();
    for law in bench.laws() {
        let (absorbed, error) = tube.crush(bench, &format!("B11 {law}"), law, &AT)?;
        let variant = format!("{law}, belytschko_tsay, 5 mm, head as a guided mass");
        for ((a, ours), expected) in AT.iter().zip(&absorbed).zip(ABSORBED) {
            let quantity = format!("energy absorbed at {:.0} mm", 1e3 * a);
            all.push(Row::new(quantity, &variant, "kJ", 1e-3 * ours).beside(expected, "[C] OpenRadioss, BT 5 mm"));
        }
        let mean = absorbed[5] / 0.15;
        all.push(Row::new("mean force from 0 to 150 mm", &variant, "kN", 1e-3 * mean).near(
            30.9,
            0.08,
            "[C] OpenRadioss, BT 5 mm",
        ));
        all.push(
            Row::new("energy not accounted for, largest", &variant, "", error).at_most(0.01, "limit of the catalogue"),
        );
    }
    Ok(all)
}

fn mean_force(bench: &Bench) -> Result<Vec<Row>, String> {
    let mut all = Vec::new();
    // 52.22 M0 (C/t)^(1/3) with M0 = 300 MPa t^2/4; two fold lengths of the formula trigger.
    for (side, thickness, around, along, trigger, expected) in
        [(0.03707, 1.152e-3, 40, 54, [0.006, 0.029], 16.5), (0.04931, 1.63e-3, 40, 54, [0.008, 0.039], 32.4)]
    {
        let section = square_section(side, 4e-4);
        let length = if side < 0.04 { 0.2 } else { 0.266 };
        let tube = Tube {
            section: &section,
            around,
            along,
            length,
            trigger,
            thickness,
            yield_stress: 300e6,
            modulus: 0.0,
            mass: 300.0,
            speed: 15.0,
            friction: 0.1,
        };
        let depth = 0.6 * length;
        let name = if side < 0.04 { "B12 lagrange".into() } else { format!("B12 lagrange {side}") };
        let (absorbed, error) = tube.crush(bench, &name, "lagrange", &[depth])?;
        let variant = format!(
            "lagrange, belytschko_tsay, {:.1} mm, 300 MPa{}",
            4e3 * side / around as f64,
            if side < 0.04 { String::new() } else { format!(", {} by {} mm", 1e3 * side, 1e3 * thickness) }
        );
        let quantity = format!("mean force from 0 to {:.0} mm", 1e3 * depth);
        all.push(Row::new(quantity, &variant, "kN", 1e-3 * absorbed[0] / depth).near(
            expected,
            0.2,
            "[V:S22] section, [D] 52.22 M0 (C/t)^(1/3)",
        ));
        all.push(
            Row::new("energy not accounted for, largest", &variant, "", error).at_most(0.01, "gate of the catalogue"),
        );
    }
    Ok(all)
}

fn round(bench: &Bench) -> Result<Vec<Row>, String> {
    let radius = 0.025;
    let section = |s: f64| {
        let (y, x) = (TAU * s).sin_cos();
        // A ring bulge of a fifth of the thickness starts the first fold.
        ([radius * x, radius * y], [2e-4 * x, 2e-4 * y])
    };
    let tube = Tube {
        section: &section,
        around: 64,
        along: 40,
        length: 0.1,
        trigger: [0.0, 0.01],
        thickness: 1e-3,
        yield_stress: 200e6,
        modulus: 0.0,
        mass: 100.0,
        speed: 15.0,
        friction: 0.1,
    };
    let (absorbed, error) = tube.crush(bench, "B13 lagrange", "lagrange", &[0.05])?;
    let variant = "lagrange, belytschko_tsay, 2.5 mm";
    Ok(vec![
        Row::new("mean force from 0 to 50 mm", variant, "kN", 1e-3 * absorbed[0] / 0.05).near(
            12.64,
            0.2,
            "[V:S23] 72.3 (D/t)^0.32 M_p",
        ),
        Row::new("energy not accounted for, largest", variant, "", error).at_most(0.01, "gate of the catalogue"),
    ])
}
