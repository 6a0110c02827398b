//! Fluids of particles in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fluid of a part of particles (smoothed particle hydrodynamics); its elements are the rows of
/// `mesh.particles`. Each particle has the mass of a cube of side `spacing`. The pressure follows
/// from the density by the equation of Murnaghan, `p = (density c^2 / n) ((rho / density)^n - 1)`
/// with `c = sound_speed` and `n = exponent`, or by that of Mie and Gruneisen with `hugoniot`, but
/// not below `-tension`. There are no shear stresses.
///
/// Particles of all parts push each other. Other bodies touch them by contact only, as nodes with a
/// radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticlesInput {
    /// Distance of neighbouring particles at the start [length].
    pub spacing: f64,
    /// Density without pressure [mass/length^3].
    pub density: f64,
    /// Speed of sound without pressure [length/time]. For slow flow, ten times the largest speed
    /// of the flow is enough: the density then changes by about one percent.
    pub sound_speed: f64,
    /// Exponent n of the equation of Murnaghan; 7 (default) is usual for water, 1 is linear in the
    /// density.
    #[serde(default)]
    pub exponent: Option<f64>,
    /// `[s1, s2, s3, gamma, a]`, in place of `exponent`: slopes of the shock velocity over the
    /// velocity of the fluid, Gruneisen's coefficient and its first-order change, as in
    /// `eos_gruneisen` of materials. The pressure is that of compression without shocks, as no
    /// particle has a temperature.
    #[serde(default)]
    pub hugoniot: Option<[f64; 5]>,
    /// Largest tension [force/length^2]. With 0 (default) particles do not hold each other, so
    /// that a drop can break up.
    #[serde(default)]
    pub tension: f64,
    /// Linear and quadratic coefficient of the artificial viscosity (Monaghan 1992).
    #[serde(default = "unit_and_double")]
    pub viscosity: [f64; 2],
    /// Smoothing length over the spacing. Particles within twice the smoothing length push each
    /// other.
    #[serde(default = "usual_smoothing")]
    pub smoothing: f64,
    /// Contact radius of a particle [length]. Without it, half of the spacing.
    #[serde(default)]
    pub contact_radius: Option<f64>,
}

fn unit_and_double() -> [f64; 2] {
    [1.0, 2.0]
}

fn usual_smoothing() -> f64 {
    1.2
}

/// Exponent of the equation of Murnaghan for water.
const OF_WATER: f64 = 7.0;

impl ParticlesInput {
    /// Returns the exponent of the equation of Murnaghan.
    pub fn exponent(&self) -> f64 {
        self.exponent.unwrap_or(OF_WATER)
    }

    /// Returns the contact radius of a particle [length].
    pub fn radius(&self) -> f64 {
        self.contact_radius.unwrap_or(0.5 * self.spacing)
    }

    /// Returns the bulk modulus without pressure [force/length^2].
    pub fn bulk_modulus(&self) -> f64 {
        self.density * self.sound_speed * self.sound_speed
    }
}
