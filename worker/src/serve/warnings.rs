//! Warnings of a worker: more threads than cores, deleted shells, reduced penalties, edges that
//! cross surfaces.

use super::RunningWorker;
use crate::math::threads;
use crumple_proto::message::{EdgeCrossings, ToMaster};
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::post;

/// Largest number of deleted elements that a worker names.
const NAMED: u64 = 20;

impl RunningWorker {
    pub(super) fn capped(&self) -> u64 {
        self.engine.contact.as_ref().map_or(0, |c| c.capped_pairs)
    }

    /// Warns of own elements that were deleted: inverted ones, and solids with too short a step.
    pub(super) fn warn_of_inverted(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let inverted = std::mem::take(&mut self.engine.inverted);
        let clock = &self.engine.clock;
        for elem in inverted {
            self.named += 1;
            let end = match self.named {
                ..NAMED => "the job permits this",
                NAMED => {
                    "the job permits this. This worker reports no further elements; summary.json \
                     counts them by part"
                }
                _ => return Ok(()),
            };
            let (cycle, time) = (clock.cycle, clock.time);
            let warning = format!(
                "element {elem} was inverted, or its step too short, and is deleted by cycle \
                 {cycle}, time {time:.6e}: {end} (part.inverted)"
            );
            post(comm, 0, Tag::Report, &ToMaster::Warning(warning))?;
        }
        Ok(())
    }

    /// Warns if the threads of the first worker have to wait for each other.
    pub(super) fn warn_of_few_cores(&self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let threads = self.engine.settings.threads;
        let cores = std::thread::available_parallelism().map_or(usize::MAX, usize::from);
        let workers = if comm.name() == "threads" { comm.size() - 1 } else { 1 };
        if threads == 1 || comm.rank() != 1 {
            return Ok(());
        }
        let warning = if threads::count() < threads {
            format!("the system did not start {threads} threads of a worker; it has a single one")
        } else if threads * workers > cores {
            format!(
                "{workers} workers with {threads} threads may use {cores} cores, so threads wait \
                 for each other: give fewer --workers or --threads or, under mpirun, let a rank \
                 use more cores with --bind-to none or --map-by slot:PE={threads}"
            )
        } else {
            return Ok(());
        };
        post(comm, 0, Tag::Report, &ToMaster::Warning(warning))
    }

    /// Warns once that penalty stiffness was lowered. The summary has the final number of pairs.
    pub(super) fn warn_of_caps(&self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let (pairs, clock) = (self.capped(), &self.engine.clock);
        let warning = format!(
            "contact: in cycle {}, time {:.6e}, the penalty stiffness of {pairs} pairs was \
             reduced to keep the step stable, as it will be in later cycles; penetrations become \
             larger than the job requests: reduce time.safety to allow a higher stiffness, or \
             contact.penalty_scale to request a lower one",
            clock.cycle, clock.time
        );
        post(comm, 0, Tag::Report, &ToMaster::Warning(warning))
    }

    /// Warns once of edges that have crossed surfaces where this contact cannot detect it.
    pub(super) fn warn_of_crossings(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let e = &self.engine;
        let found = e
            .contact
            .as_ref()
            .filter(|_| !self.crossed)
            .map_or(Vec::new(), |c| c.crossings(&e.nodes, e.clock.time));
        let Some(first) = found.first() else { return Ok(()) };
        self.crossed = true;
        let crossings = EdgeCrossings {
            cycle: e.clock.cycle,
            time: e.clock.time,
            count: found.len() as u64,
            edge: first.edge,
            surface: first.surface,
        };
        post(comm, 0, Tag::Report, &ToMaster::Crossed(crossings))
    }
}
