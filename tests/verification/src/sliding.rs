//! Blocks of solids that slide with Coulomb friction on a flat base of several facets: A07, A08,
//! A09, C09.

use super::bench::Finished;
use super::laws::Law;
use super::measure::{contact_force, displacement, mean_velocity};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::solids::Block;
use super::{Bench, Check};
use crumple_worker::engine::Engine;
use std::f64::consts::TAU;

/// Check of A07.
pub const STOP: Check = Check {
    name: "stops by friction",
    quick: true,
    run: |b| stop(b, &Law::ALL.iter().collect::<Vec<_>>()),
};
/// Check of A07 with masses split among pairs.
pub const ITERATIONS: Check =
    Check { name: "stops by friction, split", quick: true, run: |b| stop(b, &[&Law::SPLIT]) };
/// Check of A07, in gravity.
pub const HEAVY: Check = Check { name: "stops by friction, in gravity", quick: true, run: heavy };
/// Check of A08.
pub const SHAKEN: Check = Check { name: "stick-slip", quick: false, run: shaken };
/// Check of A09.
pub const INCLINE: Check = Check { name: "on an incline", quick: false, run: incline };
/// Check of C09.
pub const REVERSAL: Check = Check { name: "reversing load", quick: false, run: reversal };

const MU: f64 = 0.3;
const CREEP: &str = "in stick, the friction of the penalty law is a spring of its own stiffness";
const FLUTTER: &str = "undamped bending of the block's bricks flutters under friction through \
                       Poisson's coupling: nodes stick one by one, and the total force is below mu \
                       N. The block stops on time with hourglass = \"stiffness\" (the other rows) \
                       or with poisson = 0 (cases/slide: 2.672 ms, theory 2.667 ms). Bulk \
                       viscosity, the tolerance of the sweeps and half the step do not change this";
const PASSES: &str = "the kinematic law creeps where it should stick. The reason is not known; it \
                      is not too few sweeps: ten times as many at a tolerance of 1e-7 change the \
                      creep by 3 %";
/// Hourglass controls of the block's bricks: the one that does not flutter under friction, and
/// the default.
const STIFF: &str = "stiffness";
const DEFAULT: &str = "assumed_strain";
/// Block of steel, 20 x 20 x 10 mm [m].
const SIZE: [f64; 3] = [0.02, 0.02, 0.01];

/// Base on which the block slides.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Base {
    /// Solids, top at z = 0.
    Cubes,
    /// Shells of 2 mm, upper side at z = 0.
    Shells,
}

/// Adds a block at rest on a base of 80 x 40 mm with facets of 10 mm, rotated so that no mesh
/// lines coincide. Returns the nodes of the base and the block. References are for a rigid
/// block: bricks flutter with any hourglass control except stiffness, see [`FLUTTER`].
fn on_base(scene: &mut Scene, kind: Base, control: &str) -> (Vec<u32>, Block) {
    let (s, c) = 7f64.to_radians().sin_cos();
    let place = |x: f64, y: f64, z: f64| {
        let [x, y] = [0.08 * x - 0.02, 0.04 * (y - 0.5)];
        [c * x - s * y, s * x + c * y, z]
    };
    scene.elastic("steel", STEEL);
    let base = match kind {
        Base::Cubes => {
            scene.solid_part(1, "steel", INVISCID);
            scene.block(1, [8, 4, 1], |p| place(p[0], p[1], 0.01 * (p[2] - 1.0))).all().to_vec()
        }
        Base::Shells => {
            scene.part(1, "steel", 2e-3, "");
            scene.grid(1, [8, 4], |x, y| place(x, y, -1e-3)).all().to_vec()
        }
    };
    let block = scene
        .block(2, [2, 2, 1], |p| [SIZE[0] * (p[0] - 0.5), SIZE[1] * (p[1] - 0.5), SIZE[2] * p[2]]);
    scene.solid_part(2, "steel", &format!("{INVISCID}\nhourglass = \"{control}\"\n"));
    (base, block)
}

fn touch(scene: &mut Scene, law: &Law) {
    scene.add(&format!("{}friction = {MU:?}", law.table()));
}

fn mass() -> f64 {
    STEEL.rho * SIZE.iter().product::<f64>()
}

fn stop(bench: &Bench, laws: &[&Law]) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] t = v/a, s = v^2/2a, a = mu N/m; half a ramp of 0.1 ms later";
    let (force, v, ramped) = (400.0, 10.0, 1e-4);
    let a = MU * force / mass();
    // During the ramp the block loses a ramped/2 over the distance v ramped - a ramped^2/6.
    let left = v - 0.5 * a * ramped;
    let (time, way) =
        (ramped + left / a, v * ramped - a * ramped * ramped / 6.0 + left * left / (2.0 * a));
    let mut all = Vec::new();
    let plain =
        laws.iter().flat_map(|&law| [(law, Base::Shells, STIFF), (law, Base::Cubes, STIFF)]);
    for (law, kind, control) in plain.chain([(laws[0], Base::Shells, DEFAULT)]) {
        let mut scene = Scene::new(time + 0.3e-3);
        let (base, block) = on_base(&mut scene, kind, control);
        scene.fix(&base, "x y z rx ry rz");
        scene.start(block.all(), [v, 0.0, 0.0], [0.0; 3]);
        scene.start(&base, [0.0; 3], [0.0; 3]);
        scene.ramp(ramped);
        let pressure = force / (SIZE[0] * SIZE[1]);
        scene.press(&block.last(2), pressure);
        touch(&mut scene, law);
        let (mut stopped, mut drift, mut aside) = (f64::NAN, 0.0f64, 0.0f64);
        let run = bench.watch(&format!("A07 {} {kind:?}", law.name), &scene, |e| {
            let now = mean_velocity(e, block.all(), 0);
            if stopped.is_nan() && now <= 0.0 {
                stopped = e.clock.time;
            }
            if e.clock.time > time + 0.1e-3 {
                drift = drift.max(now.abs());
            }
            aside = aside.max(mean_velocity(e, block.all(), 1).abs());
        })?;
        let way_of = |run: &Finished| {
            block.all().iter().map(|&n| displacement(&run.engine, n)[0]).sum::<f64>()
                / block.all().len() as f64
        };
        let of = if control == STIFF { "" } else { ", bricks of assumed strain" };
        let variant = format!(
            "{}, 1 MPa, on {}{of}",
            law.name,
            if kind == Base::Cubes { "cubes" } else { "shells" }
        );
        all.push(
            CheckRow::new("time to stop", &variant, "ms", 1e3 * stopped)
                .near(1e3 * time, 0.005, D)
                .known(if control == STIFF { "" } else { FLUTTER }),
        );
        all.push(CheckRow::new("way to stop", &variant, "mm", 1e3 * way_of(&run)).near(
            1e3 * way,
            0.005,
            D,
        ));
        let heat = -run.energies.friction / run.initial;
        all.push(
            CheckRow::new("friction work / energy at the start", &variant, "", heat)
                .near(1.0, 0.005, "[D]"),
        );
        let slow = CheckRow::new("largest velocity after / v", &variant, "", drift / v);
        all.push(slow.at_most(1e-3, "limit of the catalogue").known(if law.is_spring() {
            CREEP
        } else {
            ""
        }));
        all.push(
            CheckRow::new("largest velocity aside / v", &variant, "", aside / v)
                .at_most(1e-3, "[D] by symmetry"),
        );
        all.extend(run.energy_rows(&variant, 1e-3));
    }
    Ok(all)
}

fn heavy(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str =
        "[D] v/(mu g), v^2/(2 mu g), scaled from 9.81 m/s2 and 1 m/s: 0.33979 s, 0.16989 m";
    // Gravity is a thousandfold and the speed five times as high; gravity acts from the start.
    let (g, v) = (9810.0, 5.0);
    let (time, way) = (v / (MU * g), v * v / (2.0 * MU * g));
    let mut all = Vec::new();
    for law in Law::ALL {
        let mut scene = Scene::new(1.1 * time);
        let (base, block) = on_base(&mut scene, Base::Shells, STIFF);
        scene.fix(&base, "x y z rx ry rz");
        scene.start(block.all(), [v, 0.0, 0.0], [0.0; 3]);
        scene.start(&base, [0.0; 3], [0.0; 3]);
        scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]", -g));
        touch(&mut scene, law);
        let mut stopped = f64::NAN;
        let run = bench.watch(&format!("A07 gravity {}", law.name), &scene, |e| {
            if stopped.is_nan() && mean_velocity(e, block.all(), 0) <= 0.0 {
                stopped = e.clock.time;
            }
        })?;
        let slid = block.all().iter().map(|&n| displacement(&run.engine, n)[0]).sum::<f64>()
            / block.all().len() as f64;
        let variant = format!("{}, gravity, on shells", law.name);
        let (to, on) = (v * 9.81 / g, v * v * 9.81 / g);
        all.push(CheckRow::new("time to stop", &variant, "s", stopped / to).near(
            time / to,
            0.005,
            D,
        ));
        all.push(CheckRow::new("way to stop", &variant, "m", slid / on).near(way / on, 0.005, D));
        all.extend(run.energy_rows(&variant, 1e-3));
        all.push(run.closing_row(&variant, 1e-3));
    }
    Ok(all)
}

/// Motion of a rigid block in a cycle, in which slip counts above [`SEEN`]:
/// `tests/references/slip.txt`.
struct Cycle {
    r: f64,
    slips: f64,
    fastest: f64,
    slid: f64,
}

/// Relative speed, over mu g/w, above which a block counts as slipping; a sticking block still
/// vibrates.
const SEEN: f64 = 0.01;

const CYCLES: [Cycle; 5] = [
    Cycle { r: 0.9, slips: 0.0, fastest: 0.9, slid: 0.0 },
    Cycle { r: 1.2, slips: 0.5023, fastest: 1.2, slid: 0.3107 },
    Cycle { r: 1.5, slips: 0.7796, fastest: 1.4753, slid: 1.6151 },
    Cycle { r: 1.8, slips: 0.9368, fastest: 1.5686, slid: 3.5456 },
    Cycle { r: 3.0, slips: 0.9971, fastest: 0.25 * TAU, slid: 10.2233 },
];

/// Gravity of A08, with which it has a shorter period [m/s^2].
const SHAKEN_G: f64 = 2.5e3;
/// Period of the base [s]. So slow that the penalty spring is stiff: with it, r = 1.8 slips longer
/// by 0.06 of the cycle at 2 ms, by 0.004 at 8 ms.
const PERIOD: f64 = 8e-3;
/// Time in which the block comes to rest on the base [s], and number of cycles after it.
const SETTLE: f64 = 0.5 * PERIOD;
const SHAKES: f64 = 6.0;

/// Builds a block on a base whose velocity has the amplitude `r` mu g/w. Returns the nodes of the
/// base and the block.
fn shaken_block(law: &Law, r: f64) -> (Scene, Vec<u32>, Block) {
    // Fewer points would make the steps in the base's acceleration noticeable.
    const POINTS: usize = 1000;
    let omega = TAU / PERIOD;
    let mut scene = Scene::new(SETTLE + SHAKES * PERIOD);
    let (base, block) = on_base(&mut scene, Base::Shells, STIFF);
    // Rigid like the block of the reference. A block of bricks bends and flutters (see
    // [`FLUTTER`]), which counts as slip.
    scene.add("[[rigid]]\nname = \"block\"\nparts = [2]");
    scene.ramp(0.5 * SETTLE);
    let count = (SHAKES * POINTS as f64) as usize;
    let times = (0..=count).map(|k| k as f64 * PERIOD / POINTS as f64);
    let sine = times.skip(1).map(|t| (SETTLE + t, (omega * t).sin()));
    scene.curve("shake", std::iter::once((0.0, 0.0)).chain(sine));
    scene
        .add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]\ncurve = \"ramp\"", -SHAKEN_G));
    let set = scene.set(&base);
    // The base is rigid: friction on its surface does not bend it.
    scene.fix(&base, "rx ry rz");
    // Zero until the block is at rest.
    scene.add(&format!(
        "[[motion]]\nnodes = \"{set}\"\nvelocity = [{:?}, 0.0, 0.0]\ncurve = \"shake\"",
        r * (MU * SHAKEN_G / omega)
    ));
    touch(&mut scene, law);
    (scene, base, block)
}

fn shaken(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] catalogue A08, Code_Aster SDND104 [V:S8], measured in the same way in \
                     tests/references/slip.py";
    let omega = TAU / PERIOD;
    let unit = MU * SHAKEN_G / omega;
    let mut all = Vec::new();
    for law in Law::ALL {
        for Cycle { r, slips, fastest, slid } in CYCLES {
            let (scene, base, block) = shaken_block(law, r);
            let (mut slipping, mut whole, mut way, mut most) = (0.0, 0.0, 0.0, 0.0f64);
            let (mut net, mut farthest) = (0.0f64, 0.0f64);
            let last = SETTLE + (SHAKES - 1.0) * PERIOD;
            let run = bench.watch(&format!("A08 {} r {r}", law.name), &scene, |e| {
                if e.clock.time > last {
                    let dt = e.clock.last_dt;
                    let now = mean_velocity(e, block.all(), 0);
                    let relative = now - mean_velocity(e, &base, 0);
                    whole += dt;
                    way += relative.abs() * dt;
                    net += relative * dt;
                    farthest = farthest.max(net.abs());
                    slipping += if relative.abs() > SEEN * unit { dt } else { 0.0 };
                    most = most.max(now.abs());
                }
            })?;
            let variant = format!("{}, r = {r}", law.name);
            all.push(
                CheckRow::new("largest velocity / (mu g/w)", &variant, "", most / unit)
                    .near(fastest, 0.02, D),
            );
            all.push(run.given_row(&variant));
            if r < 1.0 {
                let [net, farthest] = [net.abs(), farthest].map(|way| way * omega / (r * unit));
                all.extend(stuck_rows(law, &variant, net, farthest));
                continue;
            }
            all.push(
                CheckRow::new("fraction of time in slip", &variant, "", slipping / whole)
                    .within(slips, 0.02, D),
            );
            let slides =
                CheckRow::new("sliding in a cycle / (mu g/w^2)", &variant, "", way * omega / unit);
            all.push(slides.near(slid, 0.02, D));
        }
    }
    Ok(all)
}

/// Returns the rows of a block that should stick to the shaken base: displacement at the end and
/// largest displacement in a cycle, as fractions of the amplitude.
fn stuck_rows(law: &Law, variant: &str, net: f64, farthest: f64) -> [CheckRow; 2] {
    // Stick springs are elastic, so their vibration does not count as slip.
    let left = CheckRow::new("left behind after a cycle / amplitude", variant, "", net);
    let far =
        CheckRow::new("farthest from its place in a cycle / amplitude", variant, "", farthest);
    [
        left.at_most(1e-3, "[D] zero for a rigid block; bound of the vibration, as in C09")
            .known(creep(law)),
        far.reference(0.0, "catalogue: 1e-6, F/k_t for springs"),
    ]
}

fn incline(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    // A thousandfold gravity turns seconds into milliseconds.
    let g = 9810.0;
    let (ramped, time) = (0.5e-3, 4e-3);
    let mut all = Vec::new();
    for law in Law::ALL {
        for degrees in [15.0f64, 20.0, 25.0] {
            let (s, c) = degrees.to_radians().sin_cos();
            let mut scene = Scene::new(time);
            let (base, block) = on_base(&mut scene, Base::Shells, STIFF);
            scene.fix(&base, "x y z rx ry rz");
            scene.ramp(ramped);
            scene.add(&format!(
                "[[gravity]]\nacceleration = [{:?}, 0.0, {:?}]\ncurve = \"ramp\"",
                g * s,
                -g * c
            ));
            touch(&mut scene, law);
            let mut seen: Vec<(f64, f64)> = Vec::new();
            let run = bench.watch(&format!("A09 {} {degrees}", law.name), &scene, |e| {
                seen.push((e.clock.time - 0.5 * e.clock.last_dt, mean_velocity(e, block.all(), 0)));
            })?;
            let variant = format!("{}, {degrees} degrees", law.name);
            all.push(run.given_row(&variant));
            let a = g * (s - MU * c);
            if a < 0.0 {
                let way = displacement(&run.engine, block.at([0, 0, 0]))[0];
                let free = 0.5 * g * s * time * time;
                let row =
                    CheckRow::new("creep / way without friction", &variant, "", way.abs() / free);
                all.push(
                    row.at_most(1e-4, "[D] must not creep: far below the effect of 1 % of a")
                        .known(creep(law)),
                );
            } else {
                let from = seen.partition_point(|s| s.0 < 2.0 * ramped);
                let (first, last) = (seen[from], seen[seen.len() - 1]);
                let ours = (last.1 - first.1) / (last.0 - first.0);
                let row =
                    CheckRow::new("acceleration, gravity 9.81 m/s2", &variant, "m/s2", 1e-3 * ours);
                all.push(row.near(1e-3 * a, 0.01, "[D] g (sin - mu cos)"));
            }
        }
    }
    Ok(all)
}

/// Returns the reason why a block that should stick creeps.
fn creep(law: &Law) -> &'static str {
    if law.is_spring() { CREEP } else { PASSES }
}

/// Normal force of C09 [N], period of the load [s], and time of the ramp of the normal force [s].
const PRESSED: f64 = 400.0;
const LOAD_PERIOD: f64 = 1e-3;
const RAMPED: f64 = 0.2e-3;
/// Number of cycles of the load.
const LOAD_CYCLES: usize = 20;

/// Builds a block on a base, pulled to and fro by 1.5 mu N.
fn reversed_block(law: &Law) -> (Scene, Block) {
    const POINTS: usize = 50;
    let mut scene = Scene::new(RAMPED + LOAD_CYCLES as f64 * LOAD_PERIOD);
    let (base, block) = on_base(&mut scene, Base::Shells, STIFF);
    scene.fix(&base, "x y z rx ry rz");
    scene.ramp(RAMPED);
    let points = (0..=LOAD_CYCLES * POINTS).map(|k| k as f64 / POINTS as f64);
    let wave = points.map(|p| (RAMPED + p * LOAD_PERIOD, (TAU * p).sin()));
    scene.curve("wave", std::iter::once((0.0, 0.0)).chain(wave));
    scene.press(&block.last(2), PRESSED / (SIZE[0] * SIZE[1]));
    let set = scene.set(&block.layer(2, 0));
    scene.add(&format!(
        "[[load]]\nnodes = \"{set}\"\nforce = [{:?}, 0.0, 0.0]\ncurve = \"wave\"",
        1.5 * MU * PRESSED
    ));
    touch(&mut scene, law);
    (scene, block)
}

/// Quantities of the block of C09 that are observed in a run.
struct Reversals {
    /// Way of its lower face [m].
    slid: f64,
    /// Sum of displacements [m] and number of steps per cycle.
    means: Vec<(f64, u32)>,
    /// Largest displacement while it should stick [m], and turns of the friction force meanwhile.
    early: f64,
    turns: u32,
    held: f64,
    /// Range of the displacement in the second half [m].
    low: f64,
    high: f64,
    /// Largest friction work, and largest loss of it [J].
    heat: f64,
    back: f64,
}

impl Reversals {
    fn new() -> Self {
        Self {
            slid: 0.0,
            means: vec![(0.0, 0); LOAD_CYCLES],
            early: 0.0,
            turns: 0,
            held: 0.0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            heat: 0.0,
            back: 0.0,
        }
    }

    fn add_step(&mut self, e: &Engine, block: &Block) {
        let x = displacement(e, block.at([1, 1, 0]))[0];
        let since = (e.clock.time - RAMPED) / LOAD_PERIOD;
        if since > 0.0 {
            self.slid += mean_velocity(e, &block.layer(2, 0), 0).abs() * e.clock.last_dt;
            let cycle = (since as usize).min(LOAD_CYCLES - 1);
            self.means[cycle] = (self.means[cycle].0 + x, self.means[cycle].1 + 1);
            // |T| is below mu N until sin = 2/3.
            if since < (2.0f64 / 3.0).asin() / TAU {
                self.early = self.early.max(x.abs());
                let now = contact_force(e, block.all(), 0);
                // The rest of the ramp, 3e-8 of mu N on springs, can have either sign.
                if now.abs() > 1e-6 * MU * PRESSED {
                    self.turns += u32::from(now * self.held < 0.0);
                    self.held = now;
                }
            }
            if cycle > LOAD_CYCLES / 2 {
                (self.low, self.high) = (self.low.min(x), self.high.max(x));
            }
        }
        let now = -e.ledger.energies(&e.nodes, &e.blocks).values().friction;
        self.back = self.back.max(self.heat - now);
        self.heat = self.heat.max(now);
    }

    fn mean(&self, cycle: usize) -> f64 {
        self.means[cycle].0 / f64::from(self.means[cycle].1)
    }
}

fn reversal(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in Law::ALL {
        let (scene, block) = reversed_block(law);
        let mut seen = Reversals::new();
        let run =
            bench.watch(&format!("C09 {}", law.name), &scene, |e| seen.add_step(e, &block))?;
        let amplitude = 0.5 * (seen.high - seen.low);
        let variant = format!("{}, 1.5 mu N at 1 kHz", law.name);
        let known = creep(law);
        all.push(
            CheckRow::new(
                "largest displacement while it should stick / amplitude",
                &variant,
                "",
                seen.early / amplitude,
            )
            .at_most(1e-3, "[D] zero for a stiff block; 1e-3 for its own elasticity")
            .known(known),
        );
        let row = CheckRow::new(
            "turns of the friction force while it should stick",
            &variant,
            "",
            f64::from(seen.turns),
        );
        all.push(row.at_most(1.0, "limit of the catalogue"));
        let work = -run.energies.friction / (MU * PRESSED * seen.slid);
        all.push(CheckRow::new("friction work / mu N way", &variant, "", work).near(
            1.0,
            0.005,
            "limit of the catalogue",
        ));
        let back = seen.back / seen.heat;
        let given = CheckRow::new("friction work given back / all of it", &variant, "", back);
        // A stick spring returns (mu N)^2/2k at a reversal. With F/k a thousandth of the
        // amplitude, as above, that is a 160th of a thousandth of the work of 20 cycles.
        all.push(match law.is_spring() {
            true => given.at_most(
                1e-3 / 160.0,
                "[D] energy that a stick spring stores; the catalogue allows F/k_t",
            ),
            false => given.at_most(1e-6, "[D] never negative; round-off").known(known),
        });
        all.push(run.given_row(&variant));
        let drift = (seen.mean(LOAD_CYCLES - 1) - seen.mean(4)).abs() / amplitude;
        all.push(
            CheckRow::new("drift from cycle 5 to 20 / amplitude", &variant, "", drift)
                .at_most(0.01, "limit of the catalogue"),
        );
    }
    Ok(all)
}
