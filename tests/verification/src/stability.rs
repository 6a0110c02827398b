//! Limits of the step other than elements: a penalty spring of known stiffness (A24), a sliver
//! (C14).

use super::bars::BAR;
use super::laws::UNDAMPED;
use super::measure::{contact_force, displacement, position};
use super::row::CheckRow;
use super::scene::{Elastic, STEEL, Scene};
use super::solid_bars::INVISCID;
use super::solids::Block;
use super::{Bench, Check};
use std::ops::ControlFlow;

/// Check of A24.
pub const SPRING: Check = Check { name: "rods on a penalty spring", quick: true, run: spring };
/// Check of C14.
pub const SLIVER: Check = Check { name: "plate with a sliver", quick: true, run: sliver };

/// Side of the cubes [m].
const SIDE: f64 = 0.01;
/// Axial stress that keeps the contact closed, as a fraction of Young's modulus.
const PRESSED: f64 = 1e-4;

/// Support of a rod of cubes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum On {
    /// A fixed block.
    Block,
    /// An equal rod, fixed at its other end.
    Rod,
}

/// A rod of `n` cubes, pressed on its support with a spring of `beta` E A/L between them.
struct Sprung {
    scene: Scene,
    rod: Block,
    support: Block,
}

/// Builds the rod and its support. The support has three times the width and a ninth of modulus
/// and density: its axial stiffness and mass are those of the rod, and none of its nodes touches
/// the rod.
fn sprung(n: usize, on: On, beta: f64, capped: bool) -> Sprung {
    // The ramp is slow: five hundred transit times of a cube, and twice as many for
    // instabilities to grow.
    let transit = SIDE / BAR.c();
    let mut scene = Scene::new(1500.0 * transit);
    let rod = scene.block(1, [1, 1, n], |p| {
        [SIDE * (p[0] - 0.5), SIDE * (p[1] - 0.5), n as f64 * SIDE * p[2]]
    });
    let (layers, deep) = if on == On::Rod { (n, n as f64 * SIDE) } else { (1, 3.0 * SIDE) };
    let wide = 3.0 * SIDE;
    let support = scene.block(2, [1, 1, layers], |p| {
        [wide * (p[0] - 0.5), wide * (p[1] - 0.5), deep * (p[2] - 1.0)]
    });
    scene.elastic("rod", BAR);
    scene.elastic("support", Elastic { e: BAR.e / 9.0, rho: BAR.rho / 9.0, ..BAR });
    scene.solid_part(1, "rod", INVISCID);
    scene.solid_part(2, "support", INVISCID);
    match on {
        On::Block => scene.fix(support.all(), "x y z"),
        On::Rod => scene.fix(&support.layer(2, 0), "z"),
    }
    scene.ramp(500.0 * transit);
    let top = scene.set(&rod.last(2));
    scene.add(&format!(
        "[[pressure]]\nnodes = \"{top}\"\npressure = {:?}\ncurve = \"ramp\"",
        PRESSED * BAR.e
    ));
    // Four nodes on a face with E A/d = (E/9) 9 L^2/d, with the depth d of the cell behind it: 3
    // L for the block, L for the rod.
    let scale = 0.25 * beta * deep / (layers as f64 * SIDE);
    scene.add(&format!(
        "[contact]\nlaw = \"penalty\"\npenalty_form = \"stiffness\"\n\
         penalty_scale = {scale:?}\npenalty_cap = {capped}\n{UNDAMPED}"
    ));
    Sprung { scene, rod, support }
}

/// Result of a run: whether it grew, the measured spring, and whether the penalty was capped.
struct Came {
    grew: bool,
    beta: f64,
    capped: bool,
}

fn press(bench: &Bench, name: &str, sprung: &Sprung) -> Result<Came, String> {
    let Sprung { scene, rod, support } = sprung;
    let foot = rod.layer(2, 0);
    let head = support.last(2)[0];
    let (mut forces, mut depths, mut before, mut grew) = (0.0, 0.0, 0.0, false);
    let volume = SIDE * SIDE * SIDE * (rod.all().len() / 4 - 1) as f64;
    let stored = 0.5 * PRESSED * PRESSED * BAR.e * volume;
    let run = bench.run(name, scene, |e| {
        let kinetic = e.ledger.energies(&e.nodes, &e.blocks).values().kinetic.abs();
        // The ramp leaves about 1e-4 of this in motion.
        grew |= kinetic.is_nan() || kinetic > 0.1 * stored;
        if e.clock.time > 2.0 / 3.0 * scene.end() {
            forces += contact_force(e, &foot, 2);
            // Forces are those of the previous time.
            depths += before;
        }
        before = position(e, head)[2] - position(e, foot[0])[2];
        if grew { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let capped = run.engine.contact.as_ref().is_some_and(|c| c.capped_pairs > 0);
    Ok(Came { grew: grew || run.trouble, beta: forces / depths / (BAR.e * SIDE), capped })
}

fn spring(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 20;
    let one = |beta: f64| {
        let omega2 = 0.5 * (2.0 + beta) + (1.0 + 0.25 * beta * beta).sqrt();
        (2.0 / omega2).sqrt()
    };
    type Limits = [(f64, f64); 5];
    let cases: [(&str, usize, On, Limits); 3] = [
        ("one cube on a block", 1, On::Block, [0.5, 1.0, 2.0, 5.0, 10.0].map(|b| (b, one(b)))),
        (
            "20 cubes on a block",
            N,
            On::Block,
            [(0.5, 0.972), (1.0, 0.910), (2.0, 0.786), (5.0, 0.573), (10.0, 0.425)],
        ),
        (
            "20 cubes on a rod",
            N,
            On::Rod,
            [(0.5, 0.910), (1.0, 0.786), (2.0, 0.625), (5.0, 0.425), (10.0, 0.308)],
        ),
    ];
    let mut all = Vec::new();
    for (what, n, on, limits) in cases {
        for (beta, limit) in limits {
            let variant = format!("{what}, beta {beta}");
            let mut measured = f64::NAN;
            for (share, bounded) in [(0.98, true), (1.02, false)] {
                let mut sprung = sprung(n, on, beta, false);
                let unit = bench.model("A24", &sprung.scene)?.first_dt().0 / 0.9 * BAR.c() / SIDE;
                sprung.scene.time(&format!("safety = {:?}", share * limit / unit));
                let came = press(bench, &format!("A24 {variant} {share}"), &sprung)?;
                if bounded {
                    measured = came.beta;
                }
                let row = CheckRow::new(
                    format!("grows at {share} of the limit"),
                    &variant,
                    "",
                    f64::from(u8::from(came.grew)),
                );
                all.push(row.within(
                    if bounded { 0.0 } else { 1.0 },
                    0.0,
                    "[D] catalogue A24, closed form for one cube",
                ));
            }
            all.push(CheckRow::new("force / depth / (E A/L)", &variant, "", measured).near(
                beta,
                0.01,
                "[D] the requested stiffness",
            ));
        }
    }
    for beta in [1.0, 10.0] {
        let came =
            press(bench, &format!("A24 capped beta {beta}"), &sprung(N, On::Rod, beta, true))?;
        let variant = format!("20 cubes on a rod, beta {beta}, capped, safety 0.9");
        let holds = f64::from(u8::from(!came.grew && came.capped));
        all.push(
            CheckRow::new(
                "stays bounded, and says that it lowers the stiffness",
                &variant,
                "",
                holds,
            )
            .within(1.0, 0.0, "the code reduces k or dt and reports it"),
        );
    }
    Ok(all)
}

const BREATHES: &str =
    "[D] highest mode of a single rectangle; the 0.877 L/c_p of the catalogue is for squares";

/// Returns the largest stable step of a single rectangle of sides a and b with lumped masses
/// [s]. It stretches along both sides, with the stiffness `E' [1 nu; nu 1]` and the masses
/// `rho/4 [a^2, b^2]` per volume.
fn breathing_step(a: f64, b: f64) -> f64 {
    let [p, q] = [a, b].map(|side| (2.0 * STEEL.c_plate() / side).powi(2));
    let highest = 0.5 * (p + q) + (0.25 * (p - q).powi(2) + STEEL.nu.powi(2) * p * q).sqrt();
    2.0 / highest.sqrt()
}

fn sliver(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 10;
    let (side, thin, thickness, wanted) = (0.1, 1e-5, 1e-3, 0.5e-6);
    let scene = |scaled: bool| {
        let mut scene = Scene::new(100.0 * wanted);
        let grid = scene.grid(1, [N, N], |x, y| [side * x, side * y, 0.0]);
        let out = [4, 5].map(|j| scene.node([side + thin, side * j as f64 / N as f64, 0.0]));
        scene.shell(1, &[grid.at(N, 4), out[0], out[1], grid.at(N, 5)]);
        scene.elastic("steel", STEEL);
        scene.part(1, "steel", thickness, "");
        // An initial velocity, which an instability would amplify.
        scene.start(&grid.row(0), [0.0, 0.0, 1.0], [0.0; 3]);
        if scaled {
            scene.time(&format!("mass_scaling_dt = {wanted:?}\nmass_scaling_limit = 1.0"));
        }
        (scene, out)
    };
    let natural = bench.model("C14 sliver", &scene(false).0)?.first_dt().0 / 0.9;
    let (scaled, out) = scene(true);
    let model = bench.model("C14 sliver scaled", &scaled)?;
    let share = model.scaled_mass() / model.structure_mass();
    let refused = bench
        .model_of(
            "C14 sliver refused",
            scaled.text("C14 sliver"),
            &["time.mass_scaling_limit=0.1".into()],
        )
        .is_err();
    let own = STEEL.rho * side / N as f64 * thin * thickness;
    let run = bench.watch("C14 sliver scaled", &scaled, |_| {})?;
    let moved = out.iter().map(|&n| displacement(&run.engine, n)[2].abs()).fold(0.0, f64::max);
    let variant = "plate of 100 mm with a shell of 10 mm by 10 um";
    Ok(vec![
        CheckRow::new("stable step", variant, "ns", 1e9 * natural).near(
            1e9 * breathing_step(side / N as f64, thin),
            0.05,
            BREATHES,
        ),
        CheckRow::new(
            "stable step with mass scaling",
            variant,
            "us",
            1e6 * model.first_dt().0 / 0.9,
        )
        .near(1e6 * wanted, 0.01, "the value in the job"),
        CheckRow::new(
            "mass of the sliver, scaled / own",
            variant,
            "",
            (own + model.scaled_mass()) / own,
        )
        .near(
            (wanted / natural).powi(2),
            0.01,
            "[D] (dt/dt_natural)^2 of our own step, about 1e5",
        ),
        CheckRow::new(
            "mass added / mass of the plate, with mass_scaling_limit = 1",
            variant,
            "",
            share,
        )
        .reference(0.01, "limit of the catalogue, or the job is refused"),
        CheckRow::new(
            "refused at the default limit, 1 for yes",
            variant,
            "",
            f64::from(u8::from(refused)),
        )
        .near(1.0, 0.01, "limit of the catalogue, or the job is refused"),
        CheckRow::new(
            "largest way of the sliver / way of free flight",
            variant,
            "",
            moved / (100.0 * wanted),
        )
        .at_most(1.0, "[D] stays with the plate"),
    ])
}
