//! Effect of facets in contact: a block that slides inside a drum (C18).

use super::bench::Finished;
use super::facets::{CATALOGUE, FIXED, THICKNESS};
use super::laws::Law;
use super::measure::{mass, position};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::solids::Block;
use super::{Bench, Check};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use std::f64::consts::{PI, TAU};

/// Check of C18, drum.
pub const DRUM: Check = Check { name: "inside a drum of 72 facets", quick: false, run: drum };

const FACETS: usize = 72;
/// Radius of the drum and side of the block [m], speed of the block [m/s].
const RADIUS: f64 = 0.1;
const SIDE: f64 = 8e-3;
const SPEED: f64 = 10.0;
const POLYGON: &str = "[C] rigid block in this polygon, plastic impacts, tests/references/drum.py";

const ROUND: &str = "[C] rigid block in a nearly round drum, tests/references/drum.py";
/// Values of `contact.surface`.
const FLAT: &str = "flat";
const SMOOTH: &str = "smooth";

fn drum(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    let surfaces = [FLAT, SMOOTH];
    for (law, surface) in Law::ALL.iter().flat_map(|law| surfaces.map(|surface| (law, surface))) {
        for friction in [0.0, 0.3] {
            let (scene, block) = block_in_drum(law, surface, friction);
            let (mut turned, mut start) = (Turned::default(), 0.0);
            let name = format!("C18 drum {} {friction} {surface}", law.name);
            let run = bench.watch(&name, &scene, |e| {
                turned.add_step(e, &block);
                if e.clock.cycle == 0 {
                    start = e.ledger.energies(&e.nodes, &e.blocks).values().kinetic;
                }
            })?;
            let on = if surface == SMOOTH { ", smooth surface" } else { "" };
            let variant = format!("{}, friction {friction}, in the drum{on}", law.name);
            let crossed = turned.angle.abs() / TAU * FACETS as f64;
            let end = run.engine.ledger.energies(&run.engine.nodes, &run.engine.blocks).values();
            let kept = (end.kinetic + end.internal + end.hourglass) / start;
            let expected = (-2.0 * friction * turned.angle.abs()).exp();
            match (friction == 0.0, surface == SMOOTH) {
                (true, false) => all.extend(frictionless_rows(&variant, (kept - 1.0) / crossed)),
                (true, true) => {
                    let row = CheckRow::new(
                        "change of energy per facet",
                        &variant,
                        "",
                        (kept - 1.0) / crossed,
                    );
                    all.push(row.within(0.0, 5e-4, CATALOGUE));
                }
                (false, false) => all.push(friction_row(law, &variant, kept / expected)),
                (false, true) => {
                    let row = CheckRow::new(
                        "energy kept / exp(-2 mu angle)",
                        &variant,
                        "",
                        kept / expected,
                    );
                    all.push(row.near(0.904, 0.05, ROUND));
                }
            }
            let row = CheckRow::new("facets crossed", &variant, "", crossed);
            all.push(row.reference(0.5 * FACETS as f64, "[D] half a turn"));
            all.push(run.given_row(&variant));
            all.push(aside_row(&run, &block, &variant, friction));
        }
    }
    Ok(all)
}

/// Builds a block that slides half a turn on the inner side of the drum.
fn block_in_drum(law: &Law, surface: &str, friction: f64) -> (Scene, Block) {
    let half_turn = PI;
    // Friction reduces the velocity as exp(-mu angle).
    let time =
        if friction > 0.0 { ((friction * half_turn).exp() - 1.0) / friction } else { half_turn };
    // The drum's facets are chords; the block's face is flat, and its front and rear edges slide
    // on them.
    let inner = RADIUS * (PI / FACETS as f64).cos() - 0.5 * THICKNESS;
    let low = (inner * inner - 0.25 * SIDE * SIDE).sqrt();
    let centre = low - 0.5 * SIDE;
    let mut scene = Scene::new(time * centre / SPEED);
    let drum = scene.grid(1, [FACETS, 4], |t, y| {
        let (s, c) = (TAU * (t + 0.5 / FACETS as f64)).sin_cos();
        [RADIUS * s, 0.04 * (y - 0.5), -RADIUS * c]
    });
    let block = scene.block(2, [1; 3], |p| {
        let [x, y, z] = p.map(|q| SIDE * (q - 0.5));
        // The lines of the two meshes are at 7 degrees about the radius.
        let (s, c) = 7f64.to_radians().sin_cos();
        [c * x - s * y, s * x + c * y, z - centre + 2e-5]
    });
    scene.elastic("steel", STEEL);
    scene.part(1, "steel", THICKNESS, "points = 2");
    scene.solid_part(2, "steel", INVISCID);
    scene.fix(drum.all(), FIXED);
    // The block turns about the axis of the drum as a rigid body.
    let set = scene.set(block.all());
    let spin = -SPEED / centre;
    scene.add(&format!(
        "[[initial_velocity]]\nnodes = \"{set}\"\nvelocity = [0.0, 0.0, 0.0]\n\
         spin = [0.0, {spin:?}, 0.0]"
    ));
    scene.start(drum.all(), [0.0; 3], [0.0; 3]);
    scene.add(&format!("{}surface = \"{surface}\"\nfriction = {friction:?}", law.table()));
    (scene, block)
}

/// Angle of the block about the axis of the drum since the start [radian].
#[derive(Default)]
struct Turned {
    angle: f64,
    before: Option<f64>,
}

impl Turned {
    fn add_step(&mut self, e: &Engine, block: &Block) {
        let at = [0, 2].map(|c| block.all().iter().map(|&n| position(e, n)[c]).sum::<f64>() / 8.0);
        let now = at[0].atan2(-at[1]);
        if let Some(then) = self.before {
            let step: f64 = now - then;
            self.angle += step - TAU * (step / TAU).round();
        }
        self.before = Some(now);
    }
}

/// Returns the rows of the relative change of energy per facet. A corner of the polygon turns the
/// path by 5 degrees: no law that treats facets as flat can keep all of the energy.
fn frictionless_rows(variant: &str, change: f64) -> [CheckRow; 3] {
    [
        CheckRow::new("energy lost per facet", variant, "", -change).at_most(0.00661, POLYGON),
        CheckRow::new("energy won per facet", variant, "", change).at_most(5e-4, CATALOGUE),
        CheckRow::new("change of energy per facet", variant, "", change)
            .reference(5e-4, "limit of the catalogue, for a smooth surface"),
    ]
}

fn friction_row(law: &Law, variant: &str, kept: f64) -> CheckRow {
    let row = CheckRow::new("energy kept / exp(-2 mu angle)", variant, "", kept);
    match law.is_spring() {
        // The block is thrown off at corners, turns over and flies.
        true => row.reference(0.904, ROUND),
        false => row.within(
            0.8027,
            0.1014,
            "[C] rigid block, plastic impacts: 0.7013 in this polygon, 0.9041 in a nearly round \
             drum, tests/references/drum.py",
        ),
    }
}

fn aside_row(run: &Finished, block: &Block, variant: &str, friction: f64) -> CheckRow {
    let momentum = momentum(&run.engine.nodes).0[1].abs();
    let aside = momentum / (mass(&run.engine, block.all()) * SPEED);
    let row = CheckRow::new("momentum along the axis / m v", variant, "", aside);
    if friction > 0.0 {
        row.reference(0.0, "[D] zero except for the 7 degrees")
    } else {
        row.at_most(1e-3, "[D] no friction; bound of C03")
    }
}
