//! Newtonian fluid of solid elements, as `*MAT_NULL`: viscous stress `s = 2 eta e'` with the
//! deviator e' of the strain rate, and the pressure of an equation of state, which it needs
//! (`equation_of_state.rs`).
//!
//! A cell of a fluid has no stiffness against a change of its shape. Hourglass modes of hexahedra
//! are damped only (viscous form), and cells that flow far distort: give the fluid limits of volume
//! (`erosion_volume_strain`), or use particles.
//!
//! The step falls with the viscosity: with `c = 4 eta / (3 M)`, M the modulus of the pressure, the
//! viscous forces are half a step old, which is stable for `(w dt/2)^2 + c w^2 dt/2 <= 1`; so M
//! counts `1 + 2 c/dt` times. The linear bulk viscosity, a fraction of critical damping, grows with
//! it.

use super::parameters::Parameters;
use super::{DefaultValue, Elastic, Form, Law, ParameterRow, Solid, SolidLawResult, SolidPoint};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "fluid",
    meaning: "A fluid of solids: viscous stress, and the pressure of its equation of state.",
    constants: &[],
    parameters: &[ParameterRow {
        key: "viscosity",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.0),
        range: None,
        meaning: "Dynamic viscosity [force*time/length^2].",
    }],
    build: None,
    solid: Some(solid),
    cohesive: None,
};

struct ViscousFluid {
    density: f64,
    viscosity: f64,
}

fn solid(material: &Material) -> SolidLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let viscosity = parameters.optional("viscosity", "0 or above", |eta| eta >= 0.0);
    parameters.finish()?;
    Ok(Box::new(ViscousFluid { density, viscosity: viscosity.unwrap_or(0.0) }))
}

impl ViscousFluid {
    #[inline(always)]
    fn point<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        // Twice the viscosity per step; an element that has not moved may have a step of zero.
        let twice = if dt > 0.0 { 2.0 * self.viscosity / dt } else { 0.0 };
        let (twice, half) = (R::splat(twice), R::splat(0.5));
        let eps = point.strain;
        let mean = R::splat(1.0 / 3.0) * (eps[0] + eps[1] + eps[2]);
        for (c, (stress, &eps)) in point.state.iter_mut().zip(eps).enumerate() {
            let deviator = if c < 3 { eps - mean } else { half * eps };
            *stress = twice * deviator;
        }
        R::splat(1.0)
    }
}

impl Solid for ViscousFluid {
    fn history(&self) -> &'static [&'static str] {
        &[]
    }
    /// Returns no stiffness: that of the equation of state is added.
    fn elastic(&self) -> Elastic {
        Elastic { youngs_modulus: 0.0, poisson: 0.0, density: self.density }
    }
    fn viscosity(&self) -> Option<f64> {
        Some(self.viscosity)
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.point(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.point(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.point(point, dt)
    }
}

#[cfg(test)]
#[path = "fluid_tests.rs"]
mod tests;
