//! Laws of cohesive elements: tractions between two faces over the opening between them.
//!
//! The opening is that of a point of the surface in axes that turn with it: along the normal, then
//! along two directions in the surface. All laws are functions of the opening and of a damage D
//! that never falls:
//! ```text
//! t_n = (1 - D) K_n u_n   if u_n > 0,   else K_p u_n
//! t_s = (1 - D) K_s u_s,   t_t = (1 - D) K_s u_t
//! ```
//! So a point unloads to the origin, and a closed path takes `dD` times the stored energy of a
//! point without damage, which is never negative. With D = 1 the faces only push. K_p is K_n in
//! most laws.

pub mod elastic;
pub mod mixed_mode;
#[cfg(test)]
mod tests;
pub mod tvergaard_hutchinson;

use super::parameters::Parameters;
use super::{DefaultValue, Form, ParameterRow};
use crumple_proto::problem::Problem;

/// A law of cohesive elements, or all problems of its material.
pub type CohesiveLawResult = Result<Box<dyn Cohesive>, Vec<Problem>>;

/// A point of a cohesive element, as a law sees it.
pub struct CohesivePoint<'a> {
    /// Opening along the normal and along two directions in the surface [length].
    pub opening: [f64; 3],
    /// Columns of [`HISTORY`]. Updated in place.
    pub history: &'a mut [f64],
}

/// A law of cohesive elements.
pub trait Cohesive: Send + Sync {
    /// Returns stiffness and mass.
    fn face(&self) -> CohesiveFace;

    /// Returns the damage, from 0 to 1, of a point that has come straight to an opening along the
    /// normal and along two directions in the surface [length].
    fn damage(&self, opening: [f64; 3]) -> f64;
}

impl dyn Cohesive {
    /// Updates the history and returns the traction along the directions of the opening
    /// [force/length^2].
    pub fn update(&self, point: CohesivePoint<'_>) -> [f64; 3] {
        let damage = self.damage(point.opening);
        self.face().traction(point, damage)
    }
}

/// Stiffness and mass of a cohesive surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CohesiveFace {
    /// Stiffness along the normal and in the surface [force/length^3].
    pub stiffness: [f64; 2],
    /// Stiffness along the normal under pressure [force/length^3].
    pub pressed: f64,
    /// Density [mass/length^2 or mass/length^3].
    pub density: f64,
    /// True if the density is one per area.
    pub per_area: bool,
}

/// Columns of the history of all laws, which start at zero: damage, and 1 from failure on, where
/// points only push.
pub const HISTORY: [&str; 2] = ["damage", "failed"];

impl CohesiveFace {
    /// Returns the largest stiffness, for the stable step [force/length^3].
    pub fn stiffest(&self) -> f64 {
        let [normal, shear] = self.stiffness;
        normal.max(shear).max(self.pressed)
    }

    /// Raises the damage of a point to `damage`, 1 at most, and returns its traction
    /// [force/length^2].
    fn traction(&self, point: CohesivePoint<'_>, damage: f64) -> [f64; 3] {
        let damage = point.history[0].max(damage);
        point.history.copy_from_slice(&[damage, if damage < 1.0 { 0.0 } else { 1.0 }]);
        let [normal, shear] = self.stiffness;
        let left = 1.0 - damage;
        let [n, s, t] = point.opening;
        let normal = if n > 0.0 { left * normal } else { self.pressed };
        [normal * n, left * shear * s, left * shear * t]
    }
}

/// Creates a row of a number.
const fn row(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

/// Stiffnesses and kind of density, of all laws.
const FACE: [ParameterRow; 3] = [
    row(
        "stiffness_normal",
        DefaultValue::Needed,
        "Traction along the normal per opening [force/length^3].",
    ),
    row(
        "stiffness_shear",
        DefaultValue::Needed,
        "Traction in the surface per sliding [force/length^3].",
    ),
    ParameterRow {
        key: "density_per_area",
        form: Form::Flag,
        otherwise: DefaultValue::Flag(false),
        range: None,
        meaning: "True if `density` is a mass per area, which elements without a thickness need.",
    },
];

/// Reads stiffness and mass.
fn face(parameters: &mut Parameters<'_>) -> CohesiveFace {
    let density = parameters.density();
    let stiffness = ["stiffness_normal", "stiffness_shear"]
        .map(|key| parameters.required(key, "above 0", |k| k > 0.0));
    let per_area = parameters.flag("density_per_area");
    CohesiveFace { stiffness, pressed: stiffness[0], density, per_area }
}
