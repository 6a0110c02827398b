//! Axes a and b of a material in the plane of a shell, and its elastic constants along them.
//!
//! The axes are fixed in the axes of the element, which turn with it. With nu_ab/E_a = nu_ba/E_b
//! (Jones, Mechanics of Composite Materials, 2nd ed., ch. 2):
//! ```text
//! s_a = C_aa e_a + C_ab e_b,  s_b = C_ab e_a + C_bb e_b,  s_ab = G g_ab
//! C_aa = E_a/(1 - nu_ab nu_ba),  C_ab = nu_ba C_aa,  C_bb = E_b/(1 - nu_ab nu_ba)
//! ```

use super::parameters::Parameters;
use super::{DefaultValue, Elastic, Form, ParameterRow};
use crumple_math::lanes::Real;

/// History columns of the axis a in the axes of the element: its cosine less 1, and its sine.
pub const DIRECTION_COLUMNS: [&str; 2] = ["direction cosine - 1", "direction sine"];

/// Direction of the axis a at the start, as a parameter.
pub const DIRECTION: ParameterRow = ParameterRow {
    key: "direction",
    form: Form::List("[x, y, z]"),
    otherwise: DefaultValue::Absent,
    range: None,
    meaning: "Direction whose projection on an element is the axis a at the start. Without it the \
              axis is along the side of the nodes 1 and 2.",
};

/// Angle of the axis a from [`DIRECTION`], as a parameter.
pub const ANGLE: ParameterRow = ParameterRow {
    key: "angle",
    form: Form::Number,
    otherwise: DefaultValue::Absent,
    range: None,
    meaning: "Angle by which the axis a is turned from there about the normal [degrees].",
};

/// Axes of a material at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orientation {
    /// Direction whose projection is the axis a; the side of the nodes 1 and 2 if `None`.
    pub direction: Option<[f64; 3]>,
    /// Angle from there about the normal [rad].
    pub angle: f64,
}

impl Orientation {
    /// Reads [`DIRECTION`] and [`ANGLE`].
    pub fn read(parameters: &mut Parameters<'_>) -> Self {
        let direction = parameters.direction("direction");
        let angle = parameters.optional("angle", "a number", |_| true).unwrap_or(0.0);
        Self { direction, angle: angle.to_radians() }
    }
}

/// Elastic constants along the axes [force/length^2].
#[derive(Clone, Copy, Debug)]
pub struct Orthotropic {
    /// Young's moduli E_a and E_b.
    pub ea: f64,
    pub eb: f64,
    /// Stiffness in plane stress.
    pub caa: f64,
    pub cab: f64,
    pub cbb: f64,
    /// Shear modulus.
    pub g: f64,
}

impl Orthotropic {
    /// Returns the constants for `nu_ba`, the contraction along a due to tension along b. Reports
    /// constants that are not stable as a problem of `poisson`.
    pub fn new(
        parameters: &mut Parameters<'_>,
        [ea, eb, g]: [f64; 3],
        nu_ba: f64,
        called: &str,
    ) -> Self {
        // nu_ab nu_ba
        let product = nu_ba * nu_ba * ea / eb;
        let caa = ea / (1.0 - product);
        if !(caa > 0.0 && caa.is_finite()) {
            let what = format!("gives no stable {called} with E_a/E_b = {}", ea / eb);
            parameters.wrong("poisson", what, "its square times E_a/E_b has to be below 1");
        }
        Self { ea, eb, caa, cab: nu_ba * caa, cbb: eb / (1.0 - product), g }
    }

    /// Returns isotropic constants with a stiffness that is nowhere below this one, for the stable
    /// step. `shear` are further shear moduli.
    pub fn bound(&self, shear: &[f64], density: f64) -> Elastic {
        let g = shear.iter().fold(self.g, |most, &g| most.max(g));
        bound([self.caa, self.cab, self.cbb, g], density)
    }
}

/// Returns isotropic constants with a stiffness that is nowhere below that of C_aa, C_ab, C_bb, G.
pub fn bound([caa, cab, cbb, g]: [f64; 4], density: f64) -> Elastic {
    let largest = caa.max(cbb).max(2.0 * g + cab);
    let poisson = cab / largest;
    Elastic { youngs_modulus: largest * (1.0 - poisson * poisson), poisson, density }
}

/// Returns the stress of the constants C_aa, C_ab, C_bb, G.
#[inline(always)]
pub fn linear<R: Real>(e: [R; 3], [caa, cab, cbb, g]: [R; 4]) -> [R; 3] {
    [caa.mul_add(e[0], cab * e[1]), cab.mul_add(e[0], cbb * e[1]), g * e[2]]
}

/// Returns strains (engineering shear) of the axes of the element in the axes of the material,
/// whose axis a has the direction (c, s).
#[inline(always)]
pub fn strain_along<R: Real>([x, y, xy]: [R; 3], c: R, s: R) -> [R; 3] {
    let two = R::splat(2.0);
    let (cc, ss, cs) = (c * c, s * s, c * s);
    [cc * x + ss * y + cs * xy, ss * x + cc * y - cs * xy, two * cs * (y - x) + (cc - ss) * xy]
}

/// Returns stresses of the axes of the material in those of the element.
#[inline(always)]
pub fn stress_across<R: Real>([a, b, ab]: [R; 3], c: R, s: R) -> [R; 3] {
    let two = R::splat(2.0);
    let (cc, ss, cs) = (c * c, s * s, c * s);
    [
        cc * a + ss * b - two * cs * ab,
        ss * a + cc * b + two * cs * ab,
        cs * (a - b) + (cc - ss) * ab,
    ]
}

/// Returns stresses of the axes of the element in those of the material.
#[inline(always)]
pub fn stress_along<R: Real>(stress: [R; 3], c: R, s: R) -> [R; 3] {
    stress_across(stress, c, R::zero() - s)
}
