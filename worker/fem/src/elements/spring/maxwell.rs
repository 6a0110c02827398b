//! Springs whose stiffness relaxes from `K_0` to `K_i` with the rate beta.
//!
//! By increments: a spring `K_i` parallel to a Maxwell element (a spring `K_0 - K_i` and a damper
//! in line), as Herrmann & Peterson 1968 have it for viscoelastic solids:
//! ```text
//! F = K_i s + q,   dq/dt = (K_0 - K_i) ds/dt - beta q
//! ```
//! Exact for a constant rate in the step: with `x = beta dt`, `q <- e^-x q + (K_0 - K_i) (1 -
//! e^-x)/x ds`. With ageing the stiffness depends on the time since the start of the run instead
//! (Schwer 1991): `F = (K_i + (K_0 - K_i) e^(-beta t)) s`. From a cutoff time on the force is
//! constant.
//!
//! Stable step: with `r = e^-x`, `a = mu dt^2 (K_0 - K_i) (1 - r)/x`, `b = mu dt^2 K_i` the central
//! differences have the polynomial `(z - 1)^2 (z - r) + b z (z - r) + a z (z - 1)`. By Jury's
//! conditions its roots are within the unit circle if `b + 2 a/(1 + r) <= 4`. As `2 (1 - r)/(x (1 +
//! r)) = tanh(x/2)/(x/2) <= 1`, the step of the stiffness `K_0` is a bound. The dissipated power
//! is `beta q^2/(K_0 - K_i)`, with ageing `beta (K_0 - K_i) e^(-beta t) s^2/2`.

use super::{AddSpringProblem, SpringLaw, number};
use crumple_proto::job::MaxwellSpring;

/// Columns: time since the start [time], elongation at the last step [length], q [force].
const AGE: usize = 0;
const WAY: usize = 1;
const RELAXING: usize = 2;

/// Parameters of a spring that relaxes.
pub struct Maxwell(MaxwellSpring);

impl Maxwell {
    /// Builds the law, or reports what is wrong.
    pub fn new(input: &MaxwellSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let short = input.short_time_stiffness;
        let mut sound = true;
        let mut check = |key: &str, value: f64, range: &str, fits: &dyn Fn(f64) -> bool| {
            sound &= number(&format!("maxwell.{key}"), value, range, fits, say);
        };
        check("short_time_stiffness", short, "above 0", &|k| k > 0.0);
        let range = "from 0 to `short_time_stiffness`";
        check("long_time_stiffness", input.long_time_stiffness, range, &|k| {
            (0.0..=short).contains(&k)
        });
        check("decay", input.decay, "0 or above", &|rate| rate >= 0.0);
        check("cutoff_force", input.cutoff_force, "a number", &|_| true);
        if let Some(time) = input.cutoff_time {
            check("cutoff_time", time, "above 0", &|time| time > 0.0);
        } else if input.cutoff_force != 0.0 {
            let help = "give a cutoff_time, or remove it";
            say("maxwell.cutoff_force", "cutoff_force acts after a cutoff_time".into(), help);
            sound = false;
        }
        sound.then(|| Self(input.clone()))
    }
}

impl SpringLaw for Maxwell {
    fn names(&self) -> &'static [&'static str] {
        &["age", "elongation", "relaxing force"]
    }

    fn force(&self, state: &mut [f64], way: f64, dt: f64) -> f64 {
        let MaxwellSpring { short_time_stiffness, long_time_stiffness, decay, .. } = self.0;
        let relaxing = short_time_stiffness - long_time_stiffness;
        state[AGE] += dt;
        let step = way - std::mem::replace(&mut state[WAY], way);
        let x = decay * dt;
        let lost = -(-x).exp_m1();
        let mean = if x > 0.0 { lost / x } else { 1.0 };
        state[RELAXING] = (1.0 - lost) * state[RELAXING] + relaxing * mean * step;
        if self.0.cutoff_time.is_some_and(|time| state[AGE] >= time) {
            self.0.cutoff_force
        } else if self.0.ageing {
            (long_time_stiffness + relaxing * (-decay * state[AGE]).exp()) * way
        } else {
            long_time_stiffness * way + state[RELAXING]
        }
    }

    fn steepest(&self) -> f64 {
        self.0.short_time_stiffness
    }
}
