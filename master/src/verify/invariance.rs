//! Conservation (A29) and independence of the number of workers (A31), on the scene of bodies in collision.

use super::bench::{Finished, run_watched};
use super::row::Row;
use super::{Bench, Check};
use crate::embedded::run_side_by_side;
use crumple_worker::energy::momentum;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// A29.
pub const CONSERVATION: Check = Check { name: "bodies in collision", quick: false, run: conservation };
/// A31.
pub const WORKERS: Check = Check { name: "1, 2, 4 workers", quick: false, run: workers };

const TUMBLE: &str = include_str!("../../../cases/tumble/job.toml");

fn conservation(bench: &Bench) -> Result<Vec<Row>, String> {
    let mut all = Vec::new();
    for law in bench.laws() {
        for friction in [0.0, 0.2] {
            let sets = [
                format!("contact.law={law}"),
                format!("contact.friction={friction:?}"),
                "contact.penalty_damping=0".into(),
            ];
            let model = bench.model_of(&format!("A29 {law} friction {friction}"), TUMBLE.into(), &sets)?;
            let mut rising = 0.0f64;
            let mut least = 0.0f64;
            let run = run_watched(&model, |e| {
                let work = e.ledger.energies(&e.nodes).friction;
                rising = rising.max(work - least);
                least = least.min(work);
                ControlFlow::Continue(())
            })?;
            let variant = format!("{law}, friction {friction}, 7 bodies of shells");
            let [p, l] = drifts(&run);
            all.push(
                Row::new("change of linear momentum / sum of sizes", &variant, "", p)
                    .at_most(1e-10, "gate of the catalogue"),
            );
            all.push(
                Row::new("change of angular momentum / its size", &variant, "", l)
                    .at_most(1e-10, "gate of the catalogue").known("friction acts on the middle surfaces of both shells, which lie a thickness apart: the pair of forces turns them"),
            );
            all.push(
                Row::new("contact work / energy at the start", &variant, "", run.energies.contact / run.initial)
                    .at_most(0.0, "[D] contact gives no energy")
                    .known("the penalty law gives energy here; why has not been found yet"),
            );
            all.push(
                Row::new("friction work given back / energy at the start", &variant, "", rising / run.initial)
                    .at_most(1e-6, "gate of the catalogue: friction only takes")
                    .known("where it sticks, the friction of the penalty law is a spring, which gives back"),
            );
            all.extend(run.energy_rows(&variant, 1e-2));
        }
    }
    Ok(all)
}

/// Changes of linear and angular momentum: the former against the sum of its sizes over nodes, which may cancel.
fn drifts(run: &Finished) -> [f64; 2] {
    let nodes = &run.engine.nodes;
    let now: [[f64; 3]; 2] = momentum(nodes).into();
    let far = |k: usize| (0..3).map(|c| (now[k][c] - run.momentum[k][c]).powi(2)).sum::<f64>().sqrt();
    let size = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let total: f64 = (0..nodes.held).map(|i| nodes.mass[i] * size(&crumple_worker::nodes::xyz(&nodes.v[i]))).sum();
    [far(0) / total, far(1) / size(&run.momentum[1])]
}

fn workers(bench: &Bench) -> Result<Vec<Row>, String> {
    let mut all = Vec::new();
    for law in bench.laws() {
        let sets = [format!("contact.law={law}"), "contact.friction=0.2".into()];
        let model = bench.model_of(&format!("A31 {law}"), TUMBLE.into(), &sets)?;
        let runs =
            [(1, 0), (2, 0), (4, 0), (3, 50)].map(|(workers, every)| run_side_by_side(&model, workers, 1500, every));
        let digests: BTreeSet<String> = runs.iter().map(|r| r.digest()).collect();
        let variant = format!("{law}, 1, 2, 4 workers, and 3 with boxes cut anew every 50 cycles");
        all.push(Row::new("different end states", &variant, "", digests.len() as f64).within(
            1.0,
            0.0,
            "[D] the same bits",
        ));
        let unlike = runs.iter().filter(|r| r.pairs != runs[0].pairs).count();
        all.push(Row::new("runs with other contact pairs", &variant, "", unlike as f64).within(
            0.0,
            0.0,
            "[D] the same pairs",
        ));
        let most = runs[0].pairs.iter().map(Vec::len).max().unwrap_or(0);
        all.push(Row::new("most contact pairs of a cycle", &variant, "", most as f64).at_least(5.0, "bodies do meet"));
    }
    Ok(all)
}
