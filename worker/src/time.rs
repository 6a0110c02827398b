//! Time of a run: steps of the central difference scheme with mid-step velocities, and when what is due.

use crate::contact::enforce::Steps;
use crumple_proto::partition::Settings;

/// Simulated time, cycles and steps.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Simulated time [time].
    pub time: f64,
    /// Cycles done.
    pub cycle: u64,
    /// Step of the cycle at hand [time].
    pub dt: f64,
    /// The same, not cut short by the end of the run [time].
    pub whole_dt: f64,
    /// Step of the cycle before, 0 in the first [time].
    pub last_dt: f64,
    /// By how much velocities were changed last: from the mid-step before the last one to that [time].
    pub last_mid: f64,
    /// First and smallest step so far [time].
    pub first_dt: f64,
    /// See `first_dt`.
    pub min_dt: f64,
    /// Rows of history written.
    pub rows: u64,
    /// Field files written.
    pub fields: usize,
}

/// Cycles within round-off of a due time count as having reached it.
const SLACK: f64 = 1e-9;

impl Clock {
    /// At time 0 with the first stable step, safety factor not yet applied.
    pub fn start(settings: &Settings, stable_dt: f64) -> Self {
        let mut c = Self {
            time: 0.0,
            cycle: 0,
            dt: 0.0,
            whole_dt: 0.0,
            last_dt: 0.0,
            last_mid: 0.0,
            first_dt: 0.0,
            min_dt: f64::INFINITY,
            rows: 0,
            fields: 0,
        };
        c.choose(settings, stable_dt);
        c.first_dt = c.dt;
        c
    }

    /// Takes the global smallest stable step of the elements. The run ends on time; what is left of less than two steps
    /// is halved, since a last step of next to nothing would make enormous velocities of whatever gap is to be closed.
    pub fn choose(&mut self, settings: &Settings, stable_dt: f64) {
        let largest = if settings.dt_max > 0.0 { settings.dt_max } else { f64::INFINITY };
        let dt = (settings.safety * stable_dt).min(largest);
        self.min_dt = self.min_dt.min(dt);
        self.whole_dt = dt;
        let left = (settings.end_time - self.time).max(0.0);
        self.dt = if left <= dt { left } else { dt.min(0.5 * left) };
    }

    /// The steps around the present time. Velocities start at time 0, half a step before the first mid-step.
    pub fn steps(&self) -> Steps {
        Steps { dt: self.dt, mid: 0.5 * (self.last_dt + self.dt), whole: self.whole_dt }
    }

    /// Goes on to the next time.
    pub fn tick(&mut self) {
        self.time += self.dt;
        self.last_mid = self.steps().mid;
        self.last_dt = self.dt;
        self.cycle += 1;
    }

    /// Whether the run is over.
    pub fn is_over(&self, settings: &Settings) -> bool {
        let out_of_cycles = settings.max_cycles > 0 && self.cycle >= settings.max_cycles;
        out_of_cycles || self.time >= settings.end_time * (1.0 - SLACK)
    }

    /// Whether the step has collapsed.
    pub fn has_collapsed(&self, settings: &Settings, stable_dt: f64) -> bool {
        stable_dt.is_nan() || settings.safety * stable_dt < settings.dt_min_ratio * self.first_dt
    }

    /// Whether a history row is due at the present time.
    pub fn row_due(&self, settings: &Settings) -> bool {
        self.time >= self.rows as f64 * settings.history_interval * (1.0 - SLACK)
    }

    /// Whether field files are due at the present time.
    pub fn fields_due(&self, settings: &Settings) -> bool {
        settings.field_times.get(self.fields).is_some_and(|&t| self.time >= t * (1.0 - SLACK))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_velocity_step_is_a_half_and_the_last_step_ends_on_time() {
        let settings = crate::testing::settings();
        let mut c = Clock::start(&settings, 0.4 / settings.safety);
        assert_eq!(c.steps().mid, 0.2);
        c.tick();
        c.choose(&settings, 0.4 / settings.safety);
        assert!((c.steps().mid - 0.35).abs() < 1e-12);
        c.tick();
        c.choose(&settings, 0.4 / settings.safety);
        assert!((c.dt - 0.3).abs() < 1e-12 && !c.is_over(&settings), "0.6 is left: two steps of 0.3, not 0.4 and 0.2");
        c.tick();
        c.choose(&settings, 0.4 / settings.safety);
        c.tick();
        assert!(c.is_over(&settings));
        assert!(c.has_collapsed(&settings, f64::NAN) && c.has_collapsed(&settings, 1e-9));
    }
}
