//! Warnings and failures that the master finds in the rows of the history.

use super::Control;
use crate::results::history::wall_names;
use crate::results::warnings::{self, CREATED_CURE, EngineeringWarning, WatchedRow};
use crumple_proto::message::{Action, EdgeCrossings};
use crumple_proto::report::Failure;

/// Relative energy error above which the run has failed. Crash codes are accepted with 0.01.
const MOST_ENERGY_ERROR: f64 = 0.1;
/// Energy created by contact, as a fraction of the largest energy so far, above which the run has
/// failed.
const MOST_CREATED: f64 = 0.1;

impl Control<'_> {
    /// Warns of histories that were removed during the run.
    pub(super) fn watch_files(&mut self) {
        if let Some(path) = self.of_workers.lost.take() {
            self.history.add_lost(&path);
        }
        self.history.take_unsaid().iter().for_each(|message| self.warn(message));
    }

    /// Gives the engineering warnings of mass scaling, before the model is distributed.
    pub(super) fn watch_mass(&mut self) {
        self.add_warnings(warnings::of_added_mass(self.model));
    }

    /// Gives the engineering warnings of the last row that are new.
    pub(super) fn watch_row(&mut self) {
        let (parts, course) = (&self.model.settings.parts[..], &self.history.course);
        let levels = self.model.settings.adaptivity.as_ref().map_or(0, |a| a.levels);
        let found = WatchedRow { parts, course, levels }.warnings();
        self.add_warnings(found);
    }

    /// Gives the warnings of a complete run: what it had, and never used.
    pub(super) fn watch_end(&mut self) {
        let settings = &self.model.settings;
        let row = WatchedRow { parts: &settings.parts, course: &self.history.course, levels: 0 };
        let found = row.unused(settings.contact.is_some(), &wall_names(&settings.walls));
        self.add_warnings(found);
    }

    /// Gives the warning of edges that have passed through segments.
    pub(super) fn watch_crossings(&mut self, crossings: &EdgeCrossings) {
        self.add_warnings(vec![warnings::of_crossings(crossings)]);
    }

    fn add_warnings(&mut self, found: Vec<EngineeringWarning>) {
        let known = warnings::merge(&mut self.warnings, found);
        let new: Vec<String> = self.warnings[known..]
            .iter()
            .map(|one| {
                let line = one.line();
                // Kind and part identify the warning of the summary for readers of the log.
                tracing::warn!(warning = line, kind = one.kind.name(), part = one.part);
                line
            })
            .collect();
        new.iter().for_each(|line| self.announce(&format!("warning: {line}")));
    }

    /// Stops the run if the energy balance is violated, or if velocities keep oscillating from
    /// step to step. Plasticity can keep an unstable step bounded, but it then violates one
    /// of the two criteria.
    pub(super) fn watch_energy(&mut self) {
        let Some(row) = self.history.course.last.as_ref() else { return };
        let sum = &row.sum;
        if row.error.is_infinite() {
            let why =
                "the energies are not numbers; look at the last fields and checkpoints before \
                       it, and at materials and loads there"
                    .to_string();
            let (cycle, time) = (sum.cycle, sum.time);
            return self.fail(Failure { elem: None, cycle, time, why });
        }
        let what = if row.error.abs() > MOST_ENERGY_ERROR {
            format!("the error of the energy balance is {:.0} %", 100.0 * row.error)
        } else if self.history.course.swings_on(self.model.settings.safety > 1.0) {
            format!(
                "the step is unstable: velocities oscillate from step to step with {:.0} % of the \
                 energy",
                100.0 * row.swing
            )
        } else {
            return;
        };
        let element = sum
            .controlling
            .element
            .map_or(String::new(), |id| format!("; element {id} has the smallest stable step"));
        let safety = self.model.settings.safety;
        let cure = if safety > 1.0 { "0.9 or less" } else { "a smaller value" };
        let subcycled = self.model.settings.subcycles > 1;
        let or = if subcycled {
            ", or reduce time.subcycles, or increase time.subcycle_layers"
        } else {
            ""
        };
        let why = format!("{what}{element}; time.safety is {safety}, use {cure}{or}");
        self.fail(Failure { elem: sum.controlling.element, cycle: sum.cycle, time: sum.time, why });
    }

    /// Stops the run if contact creates more energy than a limit.
    pub(super) fn watch_work(&mut self) {
        let Some(row) = self.history.course.last.as_ref().filter(|row| row.created > MOST_CREATED)
        else {
            return;
        };
        let why = format!(
            "contact has created an energy of {:.3e}, {:.1} % of the largest energy so far",
            row.sum.energies.contact,
            100.0 * row.created
        );
        let (cycle, time) = (row.sum.cycle, row.sum.time);
        self.fail(Failure { elem: None, cycle, time, why: format!("{why}. {}", CREATED_CURE) });
    }

    /// Stops the run as failed, unless it is already ending.
    fn fail(&mut self, trouble: Failure) {
        if self.trouble.is_none() && !self.stop_ordered {
            self.trouble = Some(trouble);
            self.stop_ordered = true;
            self.order(Action::Fail);
        }
    }
}
