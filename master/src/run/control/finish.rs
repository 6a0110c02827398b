//! The end of a run: its summary.

use super::{Control, RunError};
use crate::input::job::histories;
use crate::results::summary::{self, RunEnd, Summary};
use crate::results::{figures, requirements};
use crate::run::balance::URGENT;
use crumple_proto::report::FinalReport;

/// Reason of a run that has come to its end time.
const AT_END: &str = "end_time";

impl Control<'_> {
    /// Writes the summary after all final reports have arrived.
    pub(super) fn finish(&mut self) -> Result<Summary, RunError> {
        self.finish_reports()?;
        let missing = |error| RunError::Output { path: self.out.clone(), error };
        std::fs::create_dir_all(&self.out)
            .and_then(|()| self.history.check_files())
            .map_err(missing)?;
        self.watch_files();
        let first = self.closings.iter().flatten().next();
        if first.is_some_and(|end| self.ending(end).1 == AT_END) {
            self.watch_end();
        }
        let mut summary = self.summary();
        let rigid: Vec<u32> = summary.parts.iter().filter(|p| p.rigid).map(|p| p.id).collect();
        (summary.crush, summary.head_injury) = figures::read(&self.out, &rigid, &summary.heads);
        let path = self.out.join("summary.json");
        let unwritten = |error| RunError::Output { path: path.clone(), error };
        summary.write(&path).map_err(unwritten)?;
        if summary.status == RunEnd::Completed && !self.model.job.require.is_empty() {
            // Quantities are read from the files of the run, this one among them.
            summary.requirements = requirements::judge(&self.model.job.require, &self.out);
            summary.write(&path).map_err(unwritten)?;
        }
        Ok(summary)
    }

    /// Returns how the run ended, and why.
    fn ending(&self, end: &FinalReport) -> (RunEnd, String) {
        match &self.trouble {
            Some(t) => {
                (RunEnd::Failed, format!("cycle {}, time {:.6e}: {}", t.cycle, t.time, t.why))
            }
            None if end.stopped => (RunEnd::Stopped, "stopped by the user".into()),
            None if end.time < self.model.settings.end_time * (1.0 - 1e-9) => {
                (RunEnd::Completed, "max_cycles".into())
            }
            None => (RunEnd::Completed, AT_END.into()),
        }
    }

    fn summary(&mut self) -> Summary {
        let wall_s = self.wall();
        let closings: Vec<FinalReport> =
            std::mem::take(&mut self.closings).into_iter().flatten().collect();
        let end = closings[0].clone();
        let (status, reason) = self.ending(&end);
        let count: usize = self.outline.elements.values().sum();
        let computed = count as u64 * end.cycles + end.divisions.computed;
        let (job, balance) = (&self.model.job, &self.balance);
        let threads = self.model.settings.threads;
        Summary {
            title: job.title.clone(),
            units: job.units.clone(),
            status,
            reason,
            end_time: end.time,
            cycles: end.cycles,
            nodes: self.outline.nodes,
            workers: self.workers,
            threads,
            transport: self.comm.name().into(),
            wall_s,
            grind_ns: 1e9 * wall_s * (self.workers * threads) as f64 / computed.max(1) as f64,
            phase_s: summary::phases(&closings),
            cpu_s: self.cpu(&closings),
            energy: self.energy(),
            momentum: self.momentum(),
            dt: summary::Steps { first: end.dt[0], min: end.dt[1], last: end.dt[2] },
            redecompositions: summary::Redecompositions {
                low: balance.low,
                high: balance.high,
                erosion: end.erosions,
            },
            thresholds: summary::RedecompositionThresholds {
                margin: URGENT,
                imbalance: self.model.decomposition.imbalance,
            },
            classes: summary::classes(&closings),
            imbalance: summary::MeanMax { mean: balance.mean_imbalance(), max: balance.worst },
            contact: self.contact(&closings),
            unsupported: self.model.unsupported.clone(),
            parts: summary::parts(job, &self.outline, &self.model.settings.parts, &closings),
            walls: job.wall.clone(),
            elements: self.outline.elements.clone(),
            adaptivity: job.adaptivity.as_ref().map(|_| summary::AdaptivitySummary {
                divided: end.divisions.divided,
                elements: count as u64 + 3 * end.divisions.divided,
                nodes: self.states.len(),
            }),
            restarts: self.restarts.clone(),
            steering: self.steering.records(),
            checkpoints: self.checkpoints.summary,
            lost: self.history.lost.clone(),
            warnings: std::mem::take(&mut self.warnings),
            crush: Vec::new(),
            heads: histories::heads(job),
            head_injury: Vec::new(),
            requirements: Vec::new(),
            state_digest: summary::state_digest(&mut self.states),
        }
    }

    fn cpu(&self, closings: &[FinalReport]) -> summary::Cpu {
        let cycles = closings[0].cycles.max(1) as f64;
        summary::Cpu {
            total: self.balance.total_s,
            critical_path: self.balance.critical_s,
            renewal: self.balance.renewal_s.iter().copied().fold(0.0, f64::max),
            messages_per_cycle: mean(closings, |c| c.messages) / cycles,
            bytes_per_cycle: mean(closings, |c| c.bytes) / cycles,
        }
    }

    fn energy(&self) -> summary::EnergySummary {
        let course = &self.history.course;
        let initial = course.first.clone().unwrap_or_default().sum.energies;
        let last = course.last.clone().unwrap_or_default();
        let energies = last.sum.energies;
        summary::EnergySummary {
            kinetic: energies.kinetic,
            internal: energies.internal,
            contact: energies.contact,
            friction: energies.friction,
            contact_starting: energies.starting,
            wall: energies.wall,
            wall_friction: energies.wall_friction,
            hourglass: energies.hourglass,
            external: energies.external,
            total_initial: initial.kinetic + initial.internal + initial.hourglass,
            error: last.error,
            error_max: course.worst_error,
            contact_created: course.worst_created,
        }
    }

    fn momentum(&self) -> summary::LinearMomentum {
        let course = &self.history.course;
        let first = course.first.clone().unwrap_or_default().sum;
        let last = course.last.clone().unwrap_or_default().sum;
        summary::LinearMomentum {
            start: first.momentum,
            end: last.momentum,
            wall_impulse: std::array::from_fn(|c| last.wall_impulse.iter().map(|p| p[c]).sum()),
        }
    }

    fn contact(&self, closings: &[FinalReport]) -> summary::ContactSummary {
        let cycles = closings[0].cycles.max(1) as f64;
        let most = |which: usize| closings.iter().map(|c| c.unsettled[which]).max().unwrap_or(0);
        summary::ContactSummary {
            pairs_max: self.history.course.pairs,
            penetration_max: self.history.course.penetration,
            searches: mean(closings, |c| c.searches),
            sweeps_per_cycle: mean(closings, |c| c.sweeps) / cycles,
            accelerated_steps: most(0),
            unsettled_steps: most(1),
            capped_per_cycle: closings.iter().map(|c| c.capped).sum::<u64>() as f64 / cycles,
        }
    }
}

/// Returns the mean of a number over workers.
fn mean(closings: &[FinalReport], of: fn(&FinalReport) -> u64) -> f64 {
    closings.iter().map(of).sum::<u64>() as f64 / closings.len() as f64
}
