//! Local Lagrange multipliers (Wang, Wang, Cheng & Yao 2007, eq. 10 to 14): the force that closes the gap at the end
//! of the step, given what all other pairs do, iterated over all pairs.
//!
//! With the compliance c = 1/M1 + 1/M2 of the pair (masses split among the pairs that use them) eq. 10 reads
//! `df_n = -(g/dt + n.v) / (mid c)`, where v is the relative mid-step velocity with all present forces felt.
//! The total normal force may not pull; the tangential one sticks to the stick point within the cone mu f_n.

use super::{ContactLaw, LawRow, Steps, split, within_cone};
use crate::contact::geometry::V3;
use crate::contact::pairs::Pair;

pub(super) const LAW: LawRow = LawRow {
    name: "lagrange",
    build: |c| Box::new(Lagrange { friction: c.friction, sweeps: c.sweeps, tolerance: c.tolerance }),
};

/// A force is good enough when it leaves less than this fraction of the contact thickness of the gap unclosed.
const GAP: f64 = 1e-4;
/// Most penetration that is taken out in one step, as a fraction of the contact thickness. What a sweep leaves over is
/// far below; a node that comes upon a segment from its rim must not be thrown out within a step.
const CORRECT: f64 = 0.002;

struct Lagrange {
    friction: f64,
    sweeps: usize,
    tolerance: f64,
}

impl ContactLaw for Lagrange {
    fn sweeps(&self) -> usize {
        self.sweeps
    }

    fn splits_mass(&self) -> bool {
        true
    }

    fn start(&self, pair: &Pair, _: Steps) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let pressed = pressed.max(0.0);
        pair.normal * pressed + within_cone(sheared, pressed, self.friction)
    }

    fn update(&self, pair: &Pair, velocity: &V3, steps: Steps) -> Option<V3> {
        let [soft_n, soft_t] = pair.compliance.map(|c| steps.mid * c);
        if soft_n <= 0.0 {
            return None; // both sides are held fixed
        }
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (opening, sliding) = split(velocity, &pair.normal);
        let gap = pair.gap.max(-CORRECT * pair.thickness);
        let new_pressed = (pressed - (gap / steps.dt + opening) / soft_n).max(0.0);
        let new_sheared = if self.friction > 0.0 {
            within_cone(sheared - (pair.slip / steps.dt + sliding) / soft_t, new_pressed, self.friction)
        } else {
            V3::zeros()
        };
        let change = (new_pressed - pressed).abs().max((new_sheared - sheared).norm());
        let floor = GAP * pair.thickness / (steps.dt * soft_n);
        // A force that has nothing left to do ends, however small: left as it is, it would go on pushing.
        let ends = pressed > 0.0 && new_pressed == 0.0;
        (ends || change > floor.max(self.tolerance * new_pressed.max(pressed)))
            .then(|| pair.normal * new_pressed + new_sheared)
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: Steps) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let (_, sliding) = split(velocity, &pair.normal);
        let sticks = pressed > 0.0 && sheared.norm() < self.friction * pressed * (1.0 - 1e-9);
        if sticks { pair.slip + sliding * steps.dt } else { V3::zeros() }
    }
}
