//! Linear elasticity in rate form, `d sigma = C d eps`. In plane stress `C = E/(1-nu^2) [1 nu 0;
//! nu 1 0; 0 0 (1-nu)/2]` (the last for the engineering shear strain). In three dimensions `d
//! sigma = lambda tr(d eps) 1 + 2 G d eps`.
//!
//! Valid for small strains and large rotations. With the logarithmic strains of the elements it
//! is a Hencky law as long as the principal axes of strain do not rotate in the material.

use super::parameters::Parameters;
use super::{
    ELASTIC, Elastic, Law, LawResult, PlaneStress, Points, Solid, SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "elastic",
    meaning: "Linear elasticity, large rotations.",
    constants: ELASTIC,
    parameters: &[],
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

struct LinearElastic {
    elastic: Elastic,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(parameters: Parameters<'_>, elastic: Elastic) -> Result<LinearElastic, Vec<Problem>> {
    parameters.finish()?;
    Ok(LinearElastic { elastic })
}

/// Returns the law in three dimensions with these constants.
pub fn solid_law(elastic: Elastic) -> Box<dyn Solid> {
    Box::new(LinearElastic { elastic })
}

/// Returns the law in plane stress with these constants.
pub fn law(elastic: Elastic) -> Box<dyn PlaneStress> {
    Box::new(LinearElastic { elastic })
}

impl LinearElastic {
    #[inline(always)]
    fn solid_stress<R: Real>(&self, point: SolidPoint<'_, R>) -> R {
        let (lame, g) = (R::splat(self.elastic.lame()), R::splat(self.elastic.shear_modulus()));
        let eps = point.strain;
        let pressure = lame * (eps[0] + eps[1] + eps[2]);
        for c in 0..3 {
            point.state[c] += (g + g).mul_add(eps[c], pressure);
            point.state[3 + c] = g.mul_add(eps[3 + c], point.state[3 + c]);
        }
        R::splat(1.0)
    }

    fn stress<R: Real>(&self, points: Points<'_, R>) {
        let [c11, c12, g] = self.elastic.plane_stress().map(R::splat);
        let thinning = R::splat(self.elastic.thinning());
        let (states, _) = points.state.as_chunks_mut::<3>();
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
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
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.stress(points);
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.stress(points);
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.stress(points);
    }
}

impl Solid for LinearElastic {
    fn history(&self) -> &'static [&'static str] {
        &[]
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, _dt: f64) -> Lane {
        self.solid_stress(point)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, _dt: f64) -> Lane32 {
        self.solid_stress(point)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, _dt: f64) -> f64 {
        self.solid_stress(point)
    }
}
