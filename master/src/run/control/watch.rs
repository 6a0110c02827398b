//! Warnings and failures that the master finds in the rows of the history.

use super::Control;
use crumple_proto::message::Action;
use crumple_proto::report::Failure;

/// Penetration over contact thickness above which a warning is given.
const SUNK: f64 = 0.5;
/// Relative energy error above which the run has failed. Crash codes are accepted with 0.01.
const MOST_ENERGY_ERROR: f64 = 0.1;
/// Step of contact over step of the elements below which a warning is given.
const MUCH_SHORTER: f64 = 0.5;
/// Energy created by contact, as a fraction of the largest energy so far: limit for a warning,
/// and limit for the failure of the run.
const LITTLE_CREATED: f64 = 0.01;
const MOST_CREATED: f64 = 0.1;

impl Control<'_> {
    /// Warns of histories that were removed during the run.
    pub(super) fn watch_files(&mut self) {
        if let Some(path) = self.of_workers.lost.take() {
            self.history.add_lost(&path);
        }
        self.history.take_unsaid().iter().for_each(|message| self.warn(message));
    }

    /// Warns once of deep penetration, and once if contact shortens the step much.
    pub(super) fn watch_contact(&mut self) {
        let (depth, time) = (
            self.history.course.penetration,
            self.history.course.last.as_ref().map_or(0.0, |r| r.sum.time),
        );
        if depth > SUNK && !self.penetration_warned {
            self.penetration_warned = true;
            let message = format!(
                "at time {time:.6e} the largest penetration is {depth:.2} of the contact \
                 thickness; from 1 on a node may pass through. Unless the mesh starts with this \
                 penetration, increase contact.sweeps or contact.penalty_scale, change \
                 contact.iteration, or reduce time.dt_max"
            );
            tracing::warn!(depth, time, message);
            self.announce(&format!("warning: {message}"));
        }
        let steps =
            self.history.course.last.as_ref().map(|r| [r.sum.contact_dt, r.sum.controlling_dt]);
        if let Some([contact, elements]) =
            steps.filter(|[contact, elements]| *contact < MUCH_SHORTER * elements)
            && !self.step_warned
        {
            self.step_warned = true;
            let message = format!(
                "at time {time:.6e} the stable step of contact is {contact:.3e}, that of elements \
                 {elements:.3e}: in a longer step, fast bodies could pass through others. \
                 Increase the contact thickness, or exclude fast fragments and thin foils from \
                 contact"
            );
            tracing::warn!(contact, elements, time, message);
            self.announce(&format!("warning: {message}"));
        }
    }

    /// Stops the run if the energy balance is violated, or if velocities keep oscillating from
    /// step to step. Plasticity can keep an unstable step bounded, but it then violates one
    /// of the two criteria.
    pub(super) fn watch_energy(&mut self) {
        let Some(row) = self.history.course.last.as_ref() else { return };
        let what = if row.error.abs() > MOST_ENERGY_ERROR {
            format!("the error of the energy balance is {:.0} %", 100.0 * row.error)
        } else if self.history.swings_on(self.model.settings.safety > 1.0) {
            format!(
                "the step is unstable: velocities oscillate from step to step with {:.0} % of the \
                 energy",
                100.0 * row.swing
            )
        } else {
            return;
        };
        let sum = &row.sum;
        let element = sum
            .controlling
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
        self.fail(Failure { elem: sum.controlling, cycle: sum.cycle, time: sum.time, why });
    }

    /// Warns once if contact creates energy, and stops the run if the energy exceeds a limit.
    pub(super) fn watch_work(&mut self) {
        let Some(row) =
            self.history.course.last.as_ref().filter(|row| row.created > LITTLE_CREATED)
        else {
            return;
        };
        let (created, time, cycle) = (row.created, row.sum.time, row.sum.cycle);
        let what = format!(
            "contact has created an energy of {:.3e}, {:.1} % of the largest energy so far",
            row.sum.energies.contact,
            100.0 * created
        );
        let cure = "look for parts that penetrate each other at the start (`crumple check` names \
                    them) or are pressed through each other; try a smaller time.dt_max, more \
                    contact.sweeps or a smaller contact.penalty_scale";
        if created > MOST_CREATED {
            self.fail(Failure { elem: None, cycle, time, why: format!("{what}; {cure}") });
        } else if !self.energy_warned {
            self.energy_warned = true;
            let message = format!(
                "at time {time:.6e} {what}; {cure}. The run stops at {:.0} %",
                100.0 * MOST_CREATED
            );
            tracing::warn!(created, time, message);
            self.announce(&format!("warning: {message}"));
        }
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
