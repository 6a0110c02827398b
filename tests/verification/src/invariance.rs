//! Conservation (A29) and independence of the number of workers (A31): bodies in collision,
//! bodies in a box, scenes of other entries.

use super::bench::{Finished, run_watched};
use super::laws::{Law, is_spring};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::{Bench, Check};
use crumple::run::embedded::run_side_by_side;
use crumple_cases::jobs::{BARS, SLIDE, TUMBLE};
use crumple_worker::energy::momentum;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Check of A29.
pub const CONSERVATION: Check =
    Check { name: "bodies in collision", quick: false, run: conservation };
/// Check of A29: bodies in a box.
pub const BOX: Check =
    Check { name: "blocks and plates in a closed box", quick: false, run: closed_box };
/// Check of A31, scenes of other entries.
pub const SCENES: Check = Check { name: "A01 and A07 on 1 to 8 workers", quick: true, run: scenes };
/// Check of A31.
pub const WORKERS: Check = Check { name: "1, 2, 4 workers", quick: false, run: workers };

/// Remark on the energy that springs lose or gain in a box of bodies.
const GAINS: &str = "a single contact keeps its energy (C02). Experiment: 12 other initial states \
                     of this box, contact work per run +0.58 % of the energy (standard error \
                     0.23 %), with a scatter of 0.8 % (standard deviation), so that a state is \
                     within 0.5 % in four of ten cases. Before the first and last impulses of \
                     springs were reduced, 8 other states gave +1.1 % (0.6 %), with a scatter of \
                     1.8 %. The cause of the mean was not tested";
/// Remark on friction work that the penalty law gives back.
const RETURNS: &str = "in stick, the friction of the penalty law is a spring, which returns \
                       energy. Experiment: the run returns 4.7e-6 of the energy in a single event \
                       of two steps, in which the stick springs release 1.9e-5. The sum of \
                       friction work and energy of the stick springs never rises in this run. With \
                       a quarter and half of the tangential stiffness the run returns 3.2e-5 and \
                       1.5e-5. At two thirds of the step it returns 1.7e-6, with four times the \
                       tangential stiffness nothing";

fn conservation(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in bench.laws() {
        for friction in [0.0, 0.2] {
            let sets = [
                format!("contact.law={law}"),
                format!("contact.friction={friction:?}"),
                "contact.penalty_damping=0".into(),
            ];
            let model =
                bench.model_of(&format!("A29 {law} friction {friction}"), TUMBLE.into(), &sets)?;
            let mut rising = 0.0f64;
            let mut least = 0.0f64;
            let run = run_watched(&model, |e| {
                let work = e.ledger.energies(&e.nodes, &e.blocks).values().friction;
                rising = rising.max(work - least);
                least = least.min(work);
                ControlFlow::Continue(())
            })?;
            let variant = format!("{law}, friction {friction}, 7 bodies of shells");
            let [p, l] = drifts(&run);
            all.push(
                CheckRow::new("change of linear momentum / sum of sizes", &variant, "", p)
                    .at_most(1e-10, "limit of the catalogue"),
            );
            all.push(
                CheckRow::new("change of angular momentum / its size", &variant, "", l)
                    .at_most(1e-10, "limit of the catalogue"),
            );
            let work = CheckRow::new(
                "contact work / energy at the start",
                &variant,
                "",
                run.energies.contact / run.initial,
            );
            // Springs give some energy on average, where no damping takes it.
            all.push(match is_spring(law) {
                true => work.at_most(5e-3, "limit of the catalogue: half a per cent for springs"),
                false => work.at_most(0.0, "[D] contact gives no energy"),
            });
            all.push(
                CheckRow::new(
                    "friction work given back / energy at the start",
                    &variant,
                    "",
                    rising / run.initial,
                )
                .at_most(1e-6, "limit of the catalogue: friction only absorbs energy")
                .known(RETURNS),
            );
            all.extend(run.energy_rows(&variant, 1e-2));
            all.push(run.closing_row(&variant, 1e-2));
            all.push(run.hourglass_row(&variant));
        }
    }
    Ok(all)
}

/// Returns the changes of linear and angular momentum, the former over the sum of its absolute
/// values at the nodes, since the sum itself may cancel.
fn drifts(run: &Finished) -> [f64; 2] {
    let nodes = &run.engine.nodes;
    let now: [[f64; 3]; 2] = momentum(nodes).into();
    let far =
        |k: usize| (0..3).map(|c| (now[k][c] - run.momentum[k][c]).powi(2)).sum::<f64>().sqrt();
    let size = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let total: f64 = (0..nodes.local_count)
        .map(|i| nodes.mass[i] * size(&crumple_worker::math::row::xyz(&nodes.v[i])))
        .sum();
    [far(0) / total, far(1) / size(&run.momentum[1])]
}

fn workers(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in bench.laws() {
        let sets = [format!("contact.law={law}"), "contact.friction=0.2".into()];
        let model = bench.model_of(&format!("A31 {law}"), TUMBLE.into(), &sets)?;
        let runs = [(1, 0), (2, 0), (4, 0), (3, 50)]
            .map(|(workers, every)| run_side_by_side(&model, workers, 1500, every));
        let digests: BTreeSet<String> = runs.iter().map(|r| r.digest()).collect();
        let variant = format!("{law}, 1, 2, 4 workers, and 3 with boxes cut anew every 50 cycles"); // words: allow
        all.push(CheckRow::new("different end states", &variant, "", digests.len() as f64).within(
            1.0,
            0.0,
            "[D] the same bits",
        ));
        let unlike = runs.iter().filter(|r| r.pairs != runs[0].pairs).count();
        all.push(
            CheckRow::new("runs with other contact pairs", &variant, "", unlike as f64).within(
                0.0,
                0.0,
                "[D] the same pairs",
            ),
        );
        let most = runs[0].pairs.iter().map(Vec::len).max().unwrap_or(0);
        all.push(
            CheckRow::new("most contact pairs of a cycle", &variant, "", most as f64)
                .at_least(5.0, "bodies are in contact"),
        );
    }
    Ok(all)
}

fn scenes(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for law in bench.laws() {
        for (what, job, sets, cycles) in [
            (
                "A01, bars of 40 cubes",
                BARS,
                &["scene.across=1", "part.one.thickness=0.0", "part.two.thickness=0.0"][..],
                150,
            ),
            ("A07, block on facets", SLIDE, &["scene.facets=8"][..], 300),
        ] {
            let mut sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
            sets.push(format!("contact.law={law}"));
            let model = bench.model_of(&format!("A31 {law} {what}"), job.into(), &sets)?;
            let runs = [(1, 0), (2, 0), (3, 25), (4, 0), (8, 0)];
            let runs =
                runs.map(|(workers, every)| run_side_by_side(&model, workers, cycles, every));
            let digests: BTreeSet<String> = runs.iter().map(|r| r.digest()).collect();
            let variant = format!("{what}, {law}, 1, 2, 4, 8 workers, and 3 with boxes cut anew"); // words: allow
            let row = CheckRow::new("different end states", &variant, "", digests.len() as f64);
            all.push(row.within(1.0, 0.0, "[D] the same bits"));
            let unlike = runs.iter().filter(|r| r.pairs != runs[0].pairs).count();
            let row = CheckRow::new("runs with other contact pairs", &variant, "", unlike as f64);
            all.push(row.within(0.0, 0.0, "[D] the same pairs"));
            let most = runs[0].pairs.iter().map(Vec::len).max().unwrap_or(0);
            all.push(
                CheckRow::new("most contact pairs of a cycle", &variant, "", most as f64)
                    .at_least(1.0, "they are in contact"),
            );
        }
    }
    Ok(all)
}

/// Moves ten cubes and ten plates of 10 mm in a box of 70 mm with rigid walls, without friction,
/// for 1e5 steps.
fn closed_box(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    // Springs without dashpots have to keep the energy; with dashpots they may not give any.
    let damped =
        Law::ALL.iter().filter(|law| law.is_spring()).map(|law| (law, law.table(), " damped"));
    for (law, contact, how) in Law::ALL.iter().map(|law| (law, law.undamped(), "")).chain(damped) {
        let mut scene = bodies_in_box();
        scene.add(&contact);
        let mut hit = 0;
        let run = bench.run(&format!("A29 box {}{how}", law.name), &scene, |e| {
            hit += u64::from(e.contact.as_ref().is_some_and(|c| c.owned_pairs().next().is_some()));
            ControlFlow::Continue(())
        })?;
        let variant = format!("{}{how}, 10 cubes and 10 plates, 1e5 steps", law.name);
        all.push(momentum_row(&run, &variant));
        let energies = &run.energies;
        let kept = (energies.kinetic + energies.internal + energies.hourglass) / run.initial;
        let row = CheckRow::new("energy at the end / at the start", &variant, "", kept);
        let keeps = law.is_spring() && how.is_empty();
        all.push(match keeps {
            // The walls take their share of the energy of nodes that hit them; the ledger books
            // it.
            true => row.reference(1.0, "[D] 1 less the energy that the walls absorb"),
            false => row.at_most(1.0, "limit of the catalogue: never grows"),
        });
        let gained = energies.contact / run.initial;
        let row = CheckRow::new("work of contact / energy at the start", &variant, "", gained);
        all.push(match keeps {
            true => row.within(0.0, 5e-3, "limit of the catalogue").known(GAINS),
            false => row.at_most(0.0, "limit of the catalogue: never grows"),
        });
        let drift = energies.balance(run.initial).abs() / run.initial;
        all.push(
            CheckRow::new("energy not accounted for at the end", &variant, "", drift)
                .at_most(5e-3, "limit of the catalogue"),
        );
        all.push(
            CheckRow::new("cycles in contact", &variant, "", hit as f64)
                .at_least(100.0, "bodies are in contact"),
        );
    }
    Ok(all)
}

/// Builds the bodies on a lattice of 3 x 3 x 3 in the box, with velocities from -10 to 10 m/s by a
/// linear congruential generator.
fn bodies_in_box() -> Scene {
    const EACH: usize = 10;
    let (room, side, thickness) = (0.07, 0.01, 1e-3);
    let mut scene = Scene::new(1.0);
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
    };
    for body in 0..2 * EACH {
        let at =
            [body % 3, body / 3 % 3, body / 9].map(|i| (i as f64 + 0.5) * room / 3.0 - 0.5 * side);
        let part = body as u32 + 1;
        let velocity = [0; 3].map(|_| 10.0 * random());
        let nodes = if body % 2 == 0 {
            scene.solid_part(part, "steel", INVISCID);
            scene
                .block(part, [1; 3], |p| std::array::from_fn(|c| at[c] + side * p[c]))
                .all()
                .to_vec()
        } else {
            scene.part(part, "steel", thickness, "points = 2");
            scene
                .grid(part, [1, 1], |x, y| [at[0] + side * x, at[1] + side * y, at[2] + 0.5 * side])
                .all()
                .to_vec()
        };
        scene.start(&nodes, velocity, [0.0; 3]);
    }
    scene.elastic("steel", STEEL);
    for c in 0..3 {
        let unit = |s: f64| std::array::from_fn(|k| if k == c { s } else { 0.0 });
        scene.wall([0.0; 3], unit(1.0), 0.0);
        scene.wall([room; 3], unit(-1.0), 0.0);
    }
    // A single shell is not stable at a larger step (A23).
    scene.time("max_cycles = 100000\nsafety = 0.8");
    scene
}

/// Returns the row of the momentum that neither the bodies nor the box have.
fn momentum_row(run: &Finished, variant: &str) -> CheckRow {
    let pushed =
        |c: usize| run.engine.constraints.walls.impulses.iter().map(|p| p[c].value()).sum::<f64>();
    let now = momentum(&run.engine.nodes).0;
    let sizes: f64 =
        (0..run.engine.nodes.local_count).map(|i| run.engine.nodes.mass[i] * 10.0).sum();
    let off = (0..3).map(|c| (now[c] - run.momentum[0][c] - pushed(c)).abs()).fold(0.0, f64::max);
    let off = if run.trouble { f64::INFINITY } else { off / sizes };
    CheckRow::new("change of momentum less the impulse of the box / m v", variant, "", off)
        .at_most(1e-10, "limit of the catalogue")
}
