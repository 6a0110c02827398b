//! Linear elasticity in plane stress, in rate form: `d sigma = C d eps` with
//! `C = E/(1-nu^2) [1 nu 0; nu 1 0; 0 0 (1-nu)/2]` (the last for the engineering shear strain).
//!
//! Valid for small strains and large rotations; with the logarithmic strains of the elements it is a
//! Hencky law as long as the principal axes of strain do not turn in the material.

use super::parameters::Parameters;
use super::{Built, Elastic, Law, PlaneStress, Points};
use crate::lanes::{Lane, Real};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law { name: "elastic", build };

struct LinearElastic {
    elastic: Elastic,
}

fn build(material: &Material) -> Built {
    let mut parameters = Parameters::new(material);
    let elastic = parameters.elastic();
    parameters.finish()?;
    Ok(law(elastic))
}

/// The law with these constants.
pub fn law(elastic: Elastic) -> Box<dyn PlaneStress> {
    Box::new(LinearElastic { elastic })
}

impl LinearElastic {
    fn stress<R: Real>(&self, points: Points<'_, R>) {
        let [c11, c12, g] = self.elastic.plane_stress().map(R::splat);
        let thinning = R::splat(self.elastic.thinning());
        let (states, _) = points.state.as_chunks_mut::<3>();
        for ((state, eps), eps_z) in states.iter_mut().zip(points.strain).zip(points.thickness_strain) {
            let dx = c11.mul_add(eps[0], c12 * eps[1]);
            let dy = c11.mul_add(eps[1], c12 * eps[0]);
            state[0] += dx;
            state[1] += dy;
            state[2] = g.mul_add(eps[2], state[2]);
            *eps_z = thinning.mul_add(dx + dy, -(eps[0] + eps[1]));
        }
    }
}

impl PlaneStress for LinearElastic {
    fn history(&self) -> &'static [&'static str] {
        &[]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.stress(points);
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.stress(points);
    }
}
