//! Rigid bodies: free fall and bounce (A13), oblique impact with friction (A14).

use super::bench::Finished;
use super::laws::Law;
use super::measure::{mean_velocity, position};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::{Bench, Check};

/// Check of A13.
pub const FALL: Check = Check { name: "cube from 0.1 m", quick: true, run: fall };
/// Check of A14.
pub const OBLIQUE: Check =
    Check { name: "a ball's inertia on one point", quick: true, run: oblique };

/// Adds a fixed plate of one cell with its top at z = 0.
fn plate(scene: &mut Scene, reach: f64) {
    let plate = scene.block(2, [1; 3], |p| {
        [reach * (2.0 * p[0] - 1.0), reach * (2.0 * p[1] - 1.0), reach * (p[2] - 1.0)]
    });
    scene.solid_part(2, "steel", "");
    scene.fix(plate.all(), "x y z");
}

fn fall(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (g, height, m) = (9.81f64, 0.1f64, 1.0f64);
    let side = (m / STEEL.rho).cbrt();
    let (time, speed) = ((2.0 * height / g).sqrt(), (2.0 * g * height).sqrt());
    let mut all = Vec::new();
    let targets = std::iter::once(None).chain(Law::ALL.iter().map(Some));
    for law in targets {
        let mut scene = Scene::new(time + 0.02);
        let cube = scene
            .block(1, [1; 3], |p| [side * (p[0] - 0.5), side * (p[1] - 0.5), height + side * p[2]]);
        scene.elastic("steel", STEEL);
        scene.solid_part(1, "steel", "");
        scene.add("[[rigid]]\nname = \"cube\"\nparts = [1]");
        scene.start(cube.all(), [0.0; 3], [0.0; 3]);
        scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]", -g));
        match law {
            None => {
                scene.wall([0.0; 3], [0.0, 0.0, 1.0], 0.0);
                scene.time("dt_max = 1e-5");
            }
            Some(law) => {
                plate(&mut scene, 2.0 * side);
                scene.add(&law.undamped());
            }
        }
        let name = law.map_or("wall", |l| l.name);
        let (mut touch, mut fastest, mut after) = (f64::NAN, 0.0f64, f64::NEG_INFINITY);
        let mut before = 0.0;
        let run = bench.watch(&format!("A13 {name}"), &scene, |e| {
            let v = mean_velocity(e, cube.all(), 2);
            fastest = fastest.min(v);
            // It falls by g dt in a step until contact.
            if touch.is_nan() && v > before - 0.5 * g * e.clock.last_dt && before < 0.0 {
                touch = e.clock.time - e.clock.last_dt;
            }
            if !touch.is_nan() {
                after = after.max(v);
            }
            before = v;
        })?;
        let variant = format!("{name}, 1 kg");
        let e = after / speed;
        let rebound = CheckRow::new("restitution", &variant, "", e);
        all.push(CheckRow::new("time of impact", &variant, "s", touch).near(
            time,
            1e-3,
            "[D] sqrt(2h/g)",
        ));
        all.push(CheckRow::new("velocity of impact", &variant, "m/s", -fastest).near(
            speed,
            1e-3,
            "[D] sqrt(2gh)",
        ));
        all.push(if law.is_some_and(Law::is_spring) {
            rebound.near(1.0, 0.01, "[D] a spring returns the energy that it stores")
        } else {
            rebound.within(0.0, 0.01, "[D] plastic: v = 0 afterwards, as documented")
        });
        all.push(run.given_row(&variant));
        let low = position(&run.engine, cube.at([0; 3]))[2];
        all.push(
            CheckRow::new("sunk in at the end / side", &variant, "", -low / side)
                .at_most(1e-3, "[D] no penetration"),
        );
    }
    Ok(all)
}

const FIRST: &str = "the slip of a new contact starts at zero after the force of its first step: \
                     that step has no friction, and its part of the impulse depends on the time of \
                     impact within the step";

/// Velocity along the plane and spin times radius after an impact with restitution 1 on springs
/// with k_t = k_n, at v_t = 0.7 v_n (`tests/references/balls.txt`).
const ON_SPRINGS: [f64; 2] = [0.42728, 0.68180];

/// Result of a ball thrown at a plate: final velocity along it, final spin times the radius,
/// final velocity away from it [m/s], and the run.
struct Thrown {
    along: f64,
    turning: f64,
    up: f64,
    run: Finished,
}

/// Friction coefficient, normal velocity [m/s], side of the cube that has a ball's inertia [m].
const MU: f64 = 0.2;
const NORMAL: f64 = 1.0;
const CUBE: f64 = 0.02;

/// Throws a ball at a plate. A cube on its vertex touches in one point, R below its centre, and
/// has the inertia of a ball of that radius.
fn thrown(bench: &Bench, name: &str, law: &Law, vt: f64, air: f64) -> Result<Thrown, String> {
    let radius = 0.75f64.sqrt() * CUBE;
    let inertia = 0.4 * STEEL.rho * CUBE.powi(3) * radius * radius;
    // The run lasts several contact times and ends before the ball has turned far.
    let mut scene = Scene::new(3e-4);
    // Axes of the cube, its diagonal along z.
    let (a, b, c) = ((2f64 / 3.0).sqrt(), 0.5f64.sqrt(), 3f64.sqrt().recip());
    let axes = [[a, 0.0, c], [-0.5 * a, b, c], [-0.5 * a, -b, c]];
    let cube = scene.block(1, [1; 3], |p| {
        std::array::from_fn(|k| {
            CUBE * (0..3).map(|i| p[i] * axes[i][k]).sum::<f64>() + if k == 2 { air } else { 0.0 }
        })
    });
    scene.elastic("steel", STEEL);
    scene.solid_part(1, "steel", "");
    scene.add(&format!(
        "[[rigid]]\nname = \"ball\"\nparts = [1]\n\
         inertia = [{inertia:?}, {inertia:?}, {inertia:?}, 0.0, 0.0, 0.0]"
    ));
    plate(&mut scene, 0.03);
    scene.start(cube.all(), [vt, 0.0, -NORMAL], [0.0; 3]);
    scene.add(&format!("{}friction = {MU:?}", law.undamped()));
    let run = bench.watch(name, &scene, |_| {})?;
    let [along, _, up] = [0, 1, 2].map(|c| mean_velocity(&run.engine, cube.all(), c));
    let turning = radius * run.engine.nodes.w[cube.at([0; 3]) as usize - 1][1];
    Ok(Thrown { along, turning, up, run })
}

fn oblique(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const RIGID: &str = "[D] rigid Coulomb theory, catalogue A14";
    const SPRINGS: &str =
        "[D] a ball on springs k_t = k_n, tests/references/balls.py; Maw, Barber & Fawcett 1976";
    let mut all = Vec::new();
    for law in Law::ALL {
        let bounce = if law.is_spring() { 1.0 } else { 0.0 };
        let most = 3.5 * MU * (1.0 + bounce) * NORMAL;
        for vt in [0.5 * most, 3.0] {
            let ball = thrown(bench, &format!("A14 {} {vt}", law.name), law, vt, 1e-5)?;
            let ([after, turning], source) = if vt > most {
                let slowed = MU * (1.0 + bounce) * NORMAL;
                ([vt - slowed, 2.5 * slowed], RIGID)
            } else if law.is_spring() {
                (ON_SPRINGS, SPRINGS)
            } else {
                ([5.0 / 7.0 * vt; 2], RIGID)
            };
            let variant = format!("{}, v_t = {vt:.2} v_n, e = {bounce}", law.name);
            all.push(
                CheckRow::new("tangential velocity after", &variant, "m/s", ball.along)
                    .near(after, 0.02, source),
            );
            all.push(
                CheckRow::new("spin R after", &variant, "m/s", ball.turning)
                    .near(turning, 0.02, source),
            );
            all.push(CheckRow::new("normal velocity after", &variant, "m/s", ball.up).within(
                bounce * NORMAL,
                0.02,
                RIGID,
            ));
            all.push(ball.run.given_row(&variant));
        }
        // The ball slides throughout, at any time of impact within a step.
        let step = thrown(bench, &format!("A14 {} step", law.name), law, 3.0, 1e-5)?
            .run
            .engine
            .clock
            .first_dt;
        let (mut least, mut largest) = (f64::INFINITY, 0.0f64);
        for k in 0..10 {
            let air = 1e-5 + 0.1 * f64::from(k) * step * NORMAL;
            let ball = thrown(bench, &format!("A14 {} phase {k}", law.name), law, 3.0, air)?;
            let ratio = (3.0 - ball.along) / (MU * (ball.up + NORMAL));
            (least, largest) = (least.min(ratio), largest.max(ratio));
        }
        let variant = format!("{}, v_t = 3 v_n, ten places in a step", law.name);
        for (what, ratio) in [("least", least), ("largest", largest)] {
            let row = CheckRow::new(
                format!("{what} friction impulse / (mu normal impulse)"),
                &variant,
                "",
                ratio,
            );
            let row = row.near(1.0, 0.01, "[D] Coulomb, sliding throughout");
            all.push(row.known(if law.is_spring() { FIRST } else { "" }));
        }
    }
    Ok(all)
}
