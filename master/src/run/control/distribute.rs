//! Distribution of the model over the workers: at the start, from a checkpoint, and again.

use super::{Control, Results, RunError};
use crate::input::job::Model;
use crate::results::fields;
use crate::run::balance::Due;
use crate::run::checkpoint::find::{self, Resumption};
use crate::run::decompose::{Before, ElementLoads, Workers, bisect, drifted};
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::message::{Action, ToMaster, ToWorker};
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::{await_message, post};
use rustc_hash::{FxHashMap, FxHashSet};
use std::path::Path;

/// Number of high redecompositions whose lines go to clients. All are in `log.jsonl`.
const MOST_SAID: u64 = 10;

/// Returns the settings of the workers of a run in the folder `out`.
fn settings(model: &Model, out: &Path) -> Settings {
    let mut settings = model.settings.clone();
    settings.field_dir = out.join(fields::DIR).to_string_lossy().into_owned();
    settings.checkpoint.dir = out.join(find::DIR).to_string_lossy().into_owned();
    settings
}

/// Lets the workers read a checkpoint, computes boxes with them, and waits until all are ready to
/// continue. Nothing else in the folder of the run is changed.
///
/// # Errors
/// A worker was lost, the checkpoint cannot be used, or a change does not fit its state.
pub(super) fn restore(
    model: &Model,
    comm: &mut dyn Transport,
    results: Results<'_>,
    from: &mut Resumption,
) -> Result<CutTree, RunError> {
    from.folder = find::publish(&from.folder).map_err(RunError::Unusable)?;
    let workers = comm.size() - 1;
    let resume = ToWorker::Resume {
        settings: Box::new(settings(model, results.out)),
        folder: from.folder.to_string_lossy().into_owned(),
        common: from.manifest.common.clone(),
        pieces: from.manifest.pieces.clone(),
        changes: from.changes.clone(),
        trace: results.trace.is_some(),
    };
    order(comm, &resume)?;
    await_ready(comm, RunError::Unusable)?;
    // The cost of a contact pair is not known yet.
    let mut load = Workers { comm, pair_s: 0.0, aside: Vec::new() };
    let tree = bisect(&mut load, workers, Before::default())?;
    order(comm, &ToWorker::Cuts(tree.clone()))?;
    await_ready(comm, RunError::Refused)?;
    Ok(tree)
}

/// Sends a message to all workers.
fn order(comm: &mut dyn Transport, message: &ToWorker) -> Result<(), RankLost> {
    (1..comm.size()).try_for_each(|rank| post(comm, rank, Tag::Order, message))
}

/// Waits until all workers are ready.
///
/// # Errors
/// A worker was lost, or one has given a reason why it cannot continue; all of them then end.
fn await_ready(
    comm: &mut dyn Transport,
    refusal: impl Fn(String) -> RunError,
) -> Result<(), RunError> {
    let mut refused = None;
    for rank in 1..comm.size() {
        if let ToMaster::Trouble(trouble) = await_message(comm, rank, Tag::Report)? {
            refused = Some(trouble.why);
        }
    }
    let Some(why) = refused else { return Ok(()) };
    let _ = order(comm, &ToWorker::Quit); // a worker may have ended
    Err(refusal(why))
}

impl Control<'_> {
    /// Prints from which checkpoint the run continues.
    pub(super) fn continue_from(&mut self, from: &Resumption) {
        let captured = &from.manifest.captured;
        for why in &from.refused {
            self.warn(&format!("a newer checkpoint cannot be used: {why}"));
        }
        self.history.lost.extend(from.lost.iter().cloned());
        self.watch_files();
        tracing::info!(cycle = captured.cycle, time = captured.time, "run continues");
        self.announce(&format!(
            "continues from T={:.4e}, cycle {}: {}",
            captured.time,
            captured.cycle,
            from.folder.display()
        ));
        for removed in &from.removed {
            let name = removed.file_name().unwrap_or_default().to_string_lossy();
            self.announce(&format!("the later checkpoint {name} was removed"));
        }
        self.model.forget_mesh();
    }

    /// Cuts space into boxes and sends to every worker the elements and nodes of its box.
    pub(super) fn deal_out(&mut self) -> Result<(), RankLost> {
        let (elements, nodes) = self.model.records();
        let of_id: FxHashMap<NodeId, &NodeRecord> = nodes.iter().map(|n| (n.id, n)).collect();
        let centre = |e: &crumple_proto::partition::ElementRecord| {
            let corners = &e.nodes[..e.shape.corners()];
            std::array::from_fn(|c| {
                corners.iter().map(|n| of_id[n].x[c]).sum::<f64>() / corners.len() as f64
            })
        };
        let centres: Vec<[f64; 3]> = elements.iter().map(centre).collect();
        let load = |e| [self.model.settings.load(e), 0.0];
        let loads = centres.iter().copied().zip(elements.iter().map(load)).collect();
        self.tree = bisect(&mut ElementLoads(loads), self.workers, Before::default())?;
        let mut shares = vec![Vec::new(); self.workers];
        for (e, &c) in elements.iter().zip(&centres) {
            shares[self.tree.worker_of(c)].push(*e);
        }
        let mut settings = settings(self.model, &self.out);
        let initial = std::mem::take(&mut settings.initial);
        for (worker, elements) in shares.into_iter().enumerate() {
            let mut ids: Vec<NodeId> = elements.iter().flat_map(|e| e.nodes).collect();
            ids.sort_unstable();
            ids.dedup();
            tracing::info!(worker, elements = elements.len(), nodes = ids.len(), "partition sent");
            let nodes = ids.iter().map(|id| *of_id[id]).collect();
            let trace = self.trace.is_some();
            let mut settings = Box::new(settings.clone());
            let own: FxHashSet<ElemId> = match initial.is_empty() {
                true => FxHashSet::default(),
                false => elements.iter().map(|e| e.id).collect(),
            };
            let own = initial.iter().filter(|point| own.contains(&point.element));
            settings.initial = own.copied().collect();
            let tree = self.tree.clone();
            let start = ToWorker::Start { settings, tree, elements, nodes, trace };
            post(self.comm, worker + 1, Tag::Order, &start)?;
        }
        self.model.forget_mesh();
        Ok(())
    }

    pub(super) fn redecompose(&mut self, due: &Due) {
        let last = self.balance.last.iter().max_by_key(|r| r.cycle).cloned().unwrap_or_default();
        let (kind, why) = match due {
            Due::High { why } => ("high", why),
            Due::Low { why } => ("low", why),
        };
        let _span = tracing::debug_span!("redecomposition", kind).entered();
        tracing::info!(kind, why, cycle = last.cycle, time = last.time, "redecomposition ordered");
        match due {
            Due::High { .. } => {
                let drift: Vec<[f64; 3]> = self.balance.last.iter().map(|r| r.drift).collect();
                let elements: Vec<u64> = self.balance.last.iter().map(|r| r.elements).collect();
                self.tree = drifted(&self.tree, &drift, &elements);
                self.order(Action::Renew(self.tree.clone()));
            }
            Due::Low { .. } => self.order(Action::Recut),
        }
        self.balance.ordered(self.orders, due);
        let (time, cycle) = (last.time, last.cycle);
        let line = format!("{kind} redecomposition at T={time:.4e}, cycle {cycle}: {why}");
        self.progress.print_detail(&line);
        if self.balance.low + self.balance.high <= MOST_SAID || matches!(due, Due::Low { .. }) {
            self.tell_clients(&line);
        }
    }

    /// Repartitions while all workers wait: measures the load on the workers, computes new boxes,
    /// and lets the workers migrate elements.
    pub(super) fn recut(&mut self) -> Result<(), RunError> {
        let _span = tracing::debug_span!("redecomposition", kind = "low").entered();
        let pair_s = self.balance.pair_seconds();
        let mut load = Workers { comm: self.comm, pair_s, aside: Vec::new() };
        let before = Before { tree: Some(&self.tree), buffer: self.model.settings.buffer };
        self.tree = bisect(&mut load, self.workers, before)?;
        let aside = load.aside;
        order(self.comm, &ToWorker::Cuts(self.tree.clone()))?;
        self.ready.clear();
        if let Some(since) = self.ready_since.take() {
            // Migration takes about as long as the measurement and the new boxes.
            self.balance.low_took(2.0 * since.elapsed().as_secs_f64());
        }
        aside.into_iter().try_for_each(|(worker, message)| self.receive(worker, message))
    }
}
