//! Laws of cohesive elements: tractions between two faces over the opening between them.
//!
//! The opening is that of a point of the surface in axes that turn with it: along the normal, then
//! along two directions in the surface. All laws are functions of the elastic part e of the opening
//! u and of a damage D that never falls:
//! ```text
//! t_n = (1 - D) K_n e_n   if e_n > 0,   else K_p e_n
//! t_s = (1 - D) K_s e_s,   t_t = (1 - D) K_s e_t
//! ```
//! Most laws do not flow: e = u, and a point unloads to the origin. Damage takes `dD` times the
//! stored energy of a point without damage, and flow takes the work of the traction; neither is
//! negative. With D = 1 the faces only push. K_p is K_n in most laws.

pub mod elastic;
pub mod elastoplastic;
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
    /// Columns of the law, from [`HISTORY`]. Updated in place.
    pub history: &'a mut [f64],
}

/// A law of cohesive elements.
pub trait Cohesive: Send + Sync {
    /// Returns stiffness and mass.
    fn face(&self) -> CohesiveFace;

    /// Returns the damage, from 0 to 1, of a point that has come straight to an opening along the
    /// normal and along two directions in the surface [length].
    fn damage(&self, opening: [f64; 3]) -> f64;

    /// Returns the tractions T and S along the normal and in the surface at which a point flows, if
    /// it does [force/length^2].
    fn yield_tractions(&self) -> Option<[f64; 2]> {
        None
    }
}

impl dyn Cohesive {
    /// Returns the columns of the history.
    pub fn history(&self) -> &'static [&'static str] {
        if self.yield_tractions().is_some() { &HISTORY } else { &HISTORY[..FLOW] }
    }

    /// Updates the history and returns the traction along the directions of the opening
    /// [force/length^2].
    pub fn update(&self, point: CohesivePoint<'_>) -> [f64; 3] {
        let CohesivePoint { opening, history } = point;
        let damage = history[0].max(self.damage(opening));
        let is_broken = damage >= 1.0;
        history[..FLOW].copy_from_slice(&[damage, if is_broken { 1.0 } else { 0.0 }]);
        let face = self.face();
        let elastic = match self.yield_tractions() {
            // The faces of a broken point touch where they did at the start.
            Some(limits) if !is_broken => face.flow(limits, opening, &mut history[FLOW..]),
            _ => opening,
        };
        face.traction(elastic, damage)
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

/// Columns of the history, which start at zero: damage, and 1 from failure on, where points only
/// push. Laws that flow also have the opening that has flowed, along the normal and along two
/// directions in the surface [length].
pub const HISTORY: [&str; 5] = ["damage", "failed", "flow n", "flow s", "flow t"];
/// First column of the flow.
const FLOW: usize = 2;

impl CohesiveFace {
    /// Returns the largest stiffness, for the stable step [force/length^3].
    pub fn stiffest(&self) -> f64 {
        let [normal, shear] = self.stiffness;
        normal.max(shear).max(self.pressed)
    }

    /// Lets a point flow until its traction without damage is on the surface `(t_n/T)^2 + (t_s^2 +
    /// t_t^2)/S^2 = 1`, where it was beyond; pressure does not count. Returns the elastic part of
    /// the opening [length]. Flow is along that part, so that it takes work of `(1 - D) K_n e_n^2`
    /// and so on times a positive number: never negative.
    fn flow(&self, limits: [f64; 2], opening: [f64; 3], flowed: &mut [f64]) -> [f64; 3] {
        let [n, s, t] = std::array::from_fn(|c| opening[c] - flowed[c]);
        let [normal, shear] = self.stiffness;
        let beyond = (normal * n.max(0.0) / limits[0]).hypot(shear * s.hypot(t) / limits[1]);
        if beyond <= 1.0 {
            return [n, s, t];
        }
        let elastic = [if n > 0.0 { n / beyond } else { n }, s / beyond, t / beyond];
        flowed.iter_mut().enumerate().for_each(|(c, f)| *f = opening[c] - elastic[c]);
        elastic
    }

    /// Returns the traction of a point with this elastic part of its opening [force/length^2].
    fn traction(&self, [n, s, t]: [f64; 3], damage: f64) -> [f64; 3] {
        let [normal, shear] = self.stiffness;
        let left = 1.0 - damage;
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
