//! Soft penalty: a spring between node and contact point whose stiffness follows from their masses and the step,
//! `k = scale / (c dt mid)` with the compliance c = 1/M1 + 1/M2, so that it stays below the central difference
//! limit whatever the material (the kind that LS-DYNA calls SOFT=1; Hallquist, LS-DYNA theory manual, ch. 29).
//! Friction is a tangential spring of the same stiffness from the stick point, held within the cone.

use super::{ContactLaw, LawRow, Steps, split, within_cone};
use crate::contact::geometry::V3;
use crate::contact::pairs::Pair;

pub(super) const LAW: LawRow =
    LawRow { name: "penalty", build: |c| Box::new(Penalty { friction: c.friction, scale: c.penalty_scale }) };

struct Penalty {
    friction: f64,
    scale: f64,
}

impl Penalty {
    fn stiffness(&self, pair: &Pair, steps: Steps) -> f64 {
        if pair.compliance[0] > 0.0 { self.scale / (pair.compliance[0] * steps.dt * steps.mid) } else { 0.0 }
    }
}

impl ContactLaw for Penalty {
    fn sweeps(&self) -> usize {
        1
    }

    fn splits_mass(&self) -> bool {
        true
    }

    fn start(&self, _: &Pair, _: Steps) -> V3 {
        V3::zeros()
    }

    fn update(&self, pair: &Pair, _: &V3, steps: Steps) -> Option<V3> {
        let k = self.stiffness(pair, steps);
        let pressed = (-k * pair.gap).max(0.0);
        Some(pair.normal * pressed + within_cone(pair.slip * -k, pressed, self.friction))
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: Steps) -> V3 {
        let (pressed, sheared) = split(&pair.force, &pair.normal);
        let k = self.stiffness(pair, steps);
        if pressed <= 0.0 || k <= 0.0 {
            return V3::zeros();
        }
        // Where the cone cut the force, the stick point is dragged along.
        let stretched = sheared / -k;
        let (_, sliding) = split(velocity, &pair.normal);
        stretched + sliding * steps.dt
    }
}
