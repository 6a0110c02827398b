//! Time of a run: step sizes of the central-difference scheme with mid-step velocities, and the
//! times at which output is due.

use crumple_proto::checkpoint::{Captured, MOST};
use crumple_proto::partition::Settings;
use serde::{Deserialize, Serialize};

/// Step sizes of the central difference scheme around the present time.
#[derive(Clone, Copy, Debug)]
pub struct StepSizes {
    /// Step to the next time: positions move by `dt` times the mid-step velocity [time].
    pub dt: f64,
    /// Step from the last to the next mid-step: velocities change by `dt_velocity` times the
    /// acceleration [time].
    pub dt_velocity: f64,
    /// Velocity step for the forces of contact and walls, which are computed after damping. With
    /// the damping a they change velocities by `dt_velocity / (1 + a dt_velocity / 2)` times the
    /// acceleration, so that bodies at rest need the same forces as without damping [time].
    pub dt_damped: f64,
    /// Stable step of elements and contact [time]. `dt` is smaller where a run comes to its end.
    pub dt_stable: f64,
}

impl StepSizes {
    /// Returns the impulse of a force over the change of momentum that it causes under damping,
    /// `dt_velocity / dt_damped`.
    #[inline]
    pub fn given(&self) -> f64 {
        self.dt_velocity / self.dt_damped
    }

    /// Returns the step from the last to the present time, 0 in the first cycle [time].
    pub fn dt_before(&self) -> f64 {
        2.0 * self.dt_velocity - self.dt
    }
}

/// Elements that a cycle computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementSet {
    /// All elements: an outer step begins, or the run has no subcycles.
    All,
    /// All but the slow elements: the other cycles of an outer step.
    Fast,
}

/// Time, cycle and step sizes. All of it is state, equal on all workers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Clock {
    /// Simulated time [time].
    pub time: f64,
    /// Cycles done.
    pub cycle: u64,
    /// Step size of the present cycle [time].
    pub dt: f64,
    /// Step size of the present cycle, if the end of the run did not shorten it [time].
    pub whole_dt: f64,
    /// Smallest step limit since the step could last increase [time].
    least_dt: f64,
    /// Step size of the previous cycle, 0 in the first [time].
    pub last_dt: f64,
    /// Length of the previous velocity step, t(n-1/2) - t(n-3/2) [time].
    pub last_mid: f64,
    /// Step size of the first cycle [time].
    pub first_dt: f64,
    /// Smallest step size so far [time].
    pub min_dt: f64,
    /// Number of history rows written.
    pub rows: u64,
    /// Number of field outputs written.
    pub fields: usize,
    /// Time up to which requested times of checkpoints have passed, negative at the start [time].
    passed: f64,
}

/// Relative round-off: a time this close to a due time has reached it, and a number of steps this
/// close to a whole number is whole.
const SLACK: f64 = 1e-9;
/// Number of steps before the end that are of equal length. While the stable step is constant,
/// none of them is shorter by more than a thousandth.
const LAST_STEPS: f64 = 1000.0;
/// Number of outer steps after which the step may increase, to the smallest limit of these. This
/// is much longer than a period of any motion that the step resolves coarsely.
const HELD: u64 = 256;

/// Returns the stable step of a mesh whose squared frequencies grow by at most `frequency2`
/// [1/time^2], from that without the growth [time].
pub fn stiffened(stable_dt: f64, frequency2: f64) -> f64 {
    if frequency2 > 0.0 {
        1.0 / (1.0 / (stable_dt * stable_dt) + 0.25 * frequency2).sqrt()
    } else {
        stable_dt
    }
}

impl Clock {
    /// Checks that the clock of a checkpoint shows what its manifest says.
    ///
    /// # Errors
    /// It does not, or it has a step that is no time: the reason.
    pub fn validate(&self, captured: &Captured) -> Result<(), String> {
        let Captured { cycle, time, rows, fields } = *captured;
        let same = self.cycle == cycle
            && self.time.to_bits() == time.to_bits()
            && self.rows == rows
            && self.fields as u64 == fields;
        if !same {
            return Err(format!(
                "its clock shows cycle {}, time {:?}, and the manifest has cycle {cycle}, time \
                 {time:?}",
                self.cycle, self.time
            ));
        }
        let steps = [self.dt, self.whole_dt, self.last_dt, self.last_mid, self.first_dt, time];
        let is_time = |t: &f64| t.is_finite() && *t >= 0.0;
        let limits = [self.least_dt, self.min_dt];
        if !steps.iter().all(is_time)
            || limits.iter().any(|t| t.is_nan() || *t < 0.0)
            || !self.passed.is_finite()
            || [cycle, rows, fields].iter().any(|&count| count > MOST)
        {
            return Err("the step of its clock is not a valid time".into());
        }
        Ok(())
    }

    /// Returns true if an outer step begins: slow elements are computed, and the step may change.
    #[inline]
    pub fn starts_outer_step(&self, settings: &Settings) -> bool {
        self.cycle.is_multiple_of(settings.subcycles)
    }

    /// Returns the elements that the present cycle computes.
    #[inline]
    pub fn element_set(&self, settings: &Settings) -> ElementSet {
        if self.starts_outer_step(settings) { ElementSet::All } else { ElementSet::Fast }
    }

    /// Creates a clock at time 0. `stable_dt` is the first stable step, without the safety factor
    /// [time].
    pub fn new(settings: &Settings, stable_dt: f64) -> Self {
        let mut c = Self {
            time: 0.0,
            cycle: 0,
            dt: 0.0,
            whole_dt: 0.0,
            least_dt: f64::INFINITY,
            last_dt: 0.0,
            last_mid: 0.0,
            first_dt: 0.0,
            min_dt: f64::INFINITY,
            rows: 0,
            fields: 0,
            passed: -1.0,
        };
        c.select_dt(settings, stable_dt);
        c.first_dt = c.dt;
        c
    }

    /// Selects the next step size from the global stable step `stable_dt` of the elements [time].
    ///
    /// The step decreases at once and increases only every `HELD` outer steps: a step that
    /// follows the lengths of vibrating elements adds energy to them or removes it (Skeel & Gear
    /// 1992). The step is constant within an outer step.
    ///
    /// The run ends exactly on time: the last steps are equal parts of the remaining time. A very
    /// short last step would give very large velocities where a gap must be closed. A jump of the
    /// step changes the energy balance by an amount proportional to the oscillating energy.
    pub fn select_dt(&mut self, settings: &Settings, stable_dt: f64) {
        let largest = if settings.dt_max > 0.0 { settings.dt_max } else { f64::INFINITY };
        let limit = (settings.safety * stable_dt).min(largest);
        self.least_dt = self.least_dt.min(limit);
        if !self.starts_outer_step(settings) {
            return;
        }
        let dt = if (self.cycle / settings.subcycles).is_multiple_of(HELD) {
            std::mem::replace(&mut self.least_dt, f64::INFINITY)
        } else {
            // The smallest limit within the finished outer step counts too.
            self.whole_dt.min(self.least_dt)
        };
        self.set_dt(settings, dt);
    }

    /// Shortens the present step, if the stable step of the elements has become `stable_dt` since
    /// it was selected [time]. An outer step must begin.
    pub fn shorten_dt(&mut self, settings: &Settings, stable_dt: f64) {
        let limit = settings.safety * stable_dt;
        self.least_dt = self.least_dt.min(limit);
        if limit < self.whole_dt {
            self.set_dt(settings, limit);
        }
    }

    /// Returns true if [`Self::shorten_dt`] would shorten the step.
    pub fn needs_shorter_dt(&self, settings: &Settings, stable_dt: f64) -> bool {
        settings.safety * stable_dt < self.whole_dt
    }

    /// Sets the step size; near the end of the run to a part of the remaining time.
    fn set_dt(&mut self, settings: &Settings, dt: f64) {
        self.min_dt = self.min_dt.min(dt);
        self.whole_dt = dt;
        let left = (settings.end_time - self.time).max(0.0);
        let cycles = settings.subcycles as f64;
        let steps = left / (cycles * dt);
        self.dt = if steps <= LAST_STEPS {
            left / (cycles * (steps * (1.0 - SLACK)).ceil().max(1.0))
        } else {
            dt
        };
    }

    /// Returns the time from the last to the next mid-step [time].
    #[inline]
    pub fn mid(&self) -> f64 {
        0.5 * (self.last_dt + self.dt)
    }

    /// Returns the step sizes around the present time. `damping` is proportional to mass
    /// [1/time]. Velocities start at time 0, half a step before the first mid-step.
    #[inline]
    pub fn steps(&self, damping: f64) -> StepSizes {
        let mid = self.mid();
        StepSizes {
            dt: self.dt,
            dt_velocity: mid,
            dt_damped: mid / (1.0 + 0.5 * damping * mid),
            dt_stable: self.whole_dt,
        }
    }

    /// Advances to the next time.
    pub fn advance(&mut self) {
        self.time += self.dt;
        self.last_mid = self.mid();
        self.last_dt = self.dt;
        self.cycle += 1;
    }

    /// Returns true if the run is over.
    #[inline]
    pub fn is_over(&self, settings: &Settings) -> bool {
        let out_of_cycles = settings.max_cycles > 0 && self.cycle >= settings.max_cycles;
        out_of_cycles || self.time >= settings.end_time * (1.0 - SLACK)
    }

    /// Returns the stable step below which the step has collapsed [time], with the round-off of
    /// single precision above it.
    pub fn least_dt(&self, settings: &Settings) -> f64 {
        settings.dt_min_ratio * self.first_dt / settings.safety * (1.0 + 1e-6)
    }

    /// Returns true if the step has collapsed.
    pub fn has_collapsed(&self, settings: &Settings, stable_dt: f64) -> bool {
        stable_dt.is_nan() || settings.safety * stable_dt < settings.dt_min_ratio * self.first_dt
    }

    /// Returns true if a history row is due at the present time. Rows are due only when an outer
    /// step begins, since all stresses are known then.
    pub fn is_history_due(&self, settings: &Settings) -> bool {
        let (row, from) = settings.output.rows_from;
        let due = from + (self.rows - row) as f64 * settings.history_interval;
        self.starts_outer_step(settings) && self.time >= due * (1.0 - SLACK)
    }

    /// Returns true if a time at which the job requests a checkpoint has passed since the last call
    /// that returned true.
    pub fn pass_checkpoint_time(&mut self, times: &[f64]) -> bool {
        let before = std::mem::replace(&mut self.passed, self.time);
        times.iter().map(|t| t * (1.0 - SLACK)).any(|t| before < t && t <= self.time)
    }

    /// Returns true if field files are due at the present time. Fields are due only one cycle
    /// after the start of an outer step: then no stress is older than that.
    pub fn are_fields_due(&self, settings: &Settings) -> bool {
        let fresh = self.cycle == 0 || self.cycle % settings.subcycles == 1 % settings.subcycles;
        fresh
            && settings
                .field_times
                .get(self.fields)
                .is_some_and(|&t| self.time >= t * (1.0 - SLACK))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_velocity_step_is_a_half_and_the_last_steps_are_equal_and_end_on_time() {
        let settings = Settings { end_time: 310.1, ..crate::testing::settings() };
        let stable = 0.31 / settings.safety;
        let mut c = Clock::new(&settings, stable);
        assert!((c.steps(0.0).dt_velocity - 0.155).abs() < 1e-12);
        assert!(c.steps(0.0).dt_before().abs() < 1e-12, "there is no step before");
        let mut steps = vec![c.dt];
        while !c.is_over(&settings) {
            c.advance();
            c.select_dt(&settings, stable);
            assert!((c.steps(0.0).dt_before() - steps[steps.len() - 1]).abs() < 1e-12);
            steps.push(c.dt);
        }
        assert!((c.time - 310.1).abs() < 1e-9, "{}", c.time);
        assert_eq!(c.cycle, 1001, "310.1 / 0.31 and the remainder");
        assert!(steps[..1001].iter().all(|d| *d <= 0.31 && *d > 0.999 * 0.31), "{steps:?}");
        assert!(steps[2..1001].windows(2).all(|d| (d[0] - d[1]).abs() < 1e-12), "{steps:?}");
        assert!(c.has_collapsed(&settings, f64::NAN) && c.has_collapsed(&settings, 1e-9));
    }

    /// With subcycles, outer steps are complete and begin and end with the run. The step is
    /// constant in each of them.
    #[test]
    fn outer_steps_are_whole_and_of_one_step() {
        let settings = Settings { end_time: 310.1, subcycles: 4, ..crate::testing::settings() };
        let mut c = Clock::new(&settings, 0.31 / settings.safety);
        let (mut steps, mut wholes) = (vec![c.dt], vec![c.whole_dt]);
        let (mut rows, mut fields) = (Vec::new(), Vec::new());
        while !c.is_over(&settings) {
            let stable = if c.cycle == 401 { 0.2 } else { 0.31 } / settings.safety;
            c.advance();
            c.select_dt(&settings, stable);
            steps.push(c.dt);
            wholes.push(c.whole_dt);
            rows.extend(c.is_history_due(&settings).then_some(c.cycle));
            fields.extend(
                c.are_fields_due(&Settings { field_times: vec![100.0], ..settings.clone() })
                    .then_some(c.cycle),
            );
        }
        assert!(
            (c.time - 310.1).abs() < 1e-9 && c.cycle.is_multiple_of(4),
            "{} in {}",
            c.time,
            c.cycle
        );
        assert!(
            steps[..steps.len() - 1].chunks(4).all(|outer| outer.iter().all(|d| *d == outer[0])),
            "{steps:?}"
        );
        assert!(
            rows.iter().all(|r| r % 4 == 0) && fields.iter().all(|f| f % 4 == 1),
            "{rows:?} {fields:?}"
        );
        assert!(!rows.is_empty() && !fields.is_empty());
        assert!(
            wholes[403] == wholes[0] && (wholes[404] - 0.2).abs() < 1e-9,
            "a limit in an outer step takes effect when the next outer step begins"
        );
    }

    #[test]
    fn the_step_falls_at_once_and_rises_now_and_then_to_what_has_been_stable_meanwhile() {
        let settings = Settings { end_time: 1e9, ..crate::testing::settings() };
        let mut c = Clock::new(&settings, 1.0);
        let mut go = |stable: f64| {
            c.advance();
            c.select_dt(&settings, stable);
            c.dt / settings.safety
        };
        // Elements oscillate by a thousandth with a period of seven cycles.
        let swing: Vec<f64> =
            (1..3 * HELD).map(|i| go(1.0 + 1e-3 * (i as f64 * 0.9).sin())).collect();
        let least = swing.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            least < 0.99901
                && swing[HELD as usize..].windows(2).filter(|d| d[0] != d[1]).count() < 6,
            "{swing:?}"
        );
        assert!(swing[HELD as usize..].iter().all(|d| d / least < 1.0001), "{swing:?}");
        assert_eq!(go(0.5), 0.5, "immediately, and here every {HELD} cycles");
        let after: Vec<f64> = (0..2 * HELD).map(|_| go(2.0)).collect();
        assert!(after[..HELD as usize - 1].iter().all(|&d| d == 0.5), "{after:?}");
        assert_eq!(after[2 * HELD as usize - 1], 2.0);
    }
}
