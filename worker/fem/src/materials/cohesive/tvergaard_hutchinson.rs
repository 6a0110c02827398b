//! Trilinear cohesive law of Tvergaard & Hutchinson 1992 (J. Mech. Phys. Solids 40, 1377-1397), as
//! in `*MAT_COHESIVE_TH` (LS-DYNA Keyword User's Manual, vol. II, material 185).
//!
//! With the openings at separation of pure modes `N, S` and the strength sigma, the tractions are
//! the derivatives of a potential of one scalar opening l:
//! ```text
//! l = sqrt((max(u_n, 0)/N)^2 + (u_s/S)^2 + (u_t/S)^2),   P = N integral_0^l t(l') dl'
//! t_n = t(l)/l u_n/N,   t_s = t(l)/l N u_s/S^2,   t_t = t(l)/l N u_t/S^2
//! t(l) = sigma l/l_1   up to l_1,   sigma   up to l_2,   sigma (1 - l)/(1 - l_2)   up to 1
//! ```
//! That is the form of all laws, with `K_n = sigma/(l_1 N)`, `K_s = sigma N/(l_1 S^2)` and `1 - D =
//! t(l) l_1/(sigma l)`. Increasing openings of any mixture take the work `sigma N (1 - l_1 +
//! l_2)/2`, so there is one toughness only. Under pressure the stiffness is a multiple of K_n.
//!
//! The paper has increasing openings; here points unload along the line to the origin.

use super::{Cohesive, CohesiveFace, CohesiveLawResult, FACE, row};
use crate::materials::parameters::Parameters;
use crate::materials::{DefaultValue, Law};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "cohesive_tvergaard_hutchinson",
    meaning: "Cohesive law with a plateau before it softens, and one toughness of all mixtures.",
    constants: &[],
    parameters: &[
        row(
            "strength",
            DefaultValue::Needed,
            "Largest traction of pure opening, in tension [force/length^2]; in pure sliding it is \
             this times `separation_normal`/`separation_shear`.",
        ),
        row(
            "separation_normal",
            DefaultValue::Needed,
            "Opening at separation without sliding [length].",
        ),
        row(
            "separation_shear",
            DefaultValue::Needed,
            "Sliding at separation without opening [length].",
        ),
        row(
            "peak_share",
            DefaultValue::Needed,
            "Share of the opening at separation at which the strength is reached; above 0, at most \
             1.",
        ),
        row(
            "softening_share",
            DefaultValue::Needed,
            "Share of the opening at separation from which on the traction falls; from \
             `peak_share` to 1.",
        ),
        row(
            "pressure_factor",
            DefaultValue::Number(1.0),
            "Stiffness under pressure over that of opening; not below 0, and with 0 the faces pass \
             through each other.",
        ),
        FACE[2],
    ],
    build: None,
    solid: None,
    cohesive: Some(build),
};

struct TvergaardHutchinson {
    face: CohesiveFace,
    /// N and S [length].
    separation: [f64; 2],
    /// l_1 and l_2.
    shares: [f64; 2],
}

fn build(material: &Material) -> CohesiveLawResult {
    let mut parameters = Parameters::new(material);
    let density = parameters.density();
    let per_area = parameters.flag("density_per_area");
    let [strength, normal, shear] = ["strength", "separation_normal", "separation_shear"]
        .map(|key| parameters.required(key, "above 0", |x| x > 0.0));
    let first = parameters.required("peak_share", "above 0, at most 1", |l| l > 0.0 && l <= 1.0);
    let wanted = "at least peak_share, at most 1";
    let second = parameters.required("softening_share", wanted, |l| l >= first && l <= 1.0);
    let factor = parameters.optional("pressure_factor", "at least 0", |f| f >= 0.0).unwrap_or(1.0);
    parameters.finish()?;
    let stiffness = [strength / (first * normal), strength * normal / (first * shear * shear)];
    let face = CohesiveFace { stiffness, pressed: factor * stiffness[0], density, per_area };
    let (separation, shares) = ([normal, shear], [first, second]);
    Ok(Box::new(TvergaardHutchinson { face, separation, shares }))
}

impl Cohesive for TvergaardHutchinson {
    fn face(&self) -> CohesiveFace {
        self.face
    }

    fn damage(&self, [n, s, t]: [f64; 3]) -> f64 {
        let [normal, shear] = self.separation;
        let [first, second] = self.shares;
        let opening = (n.max(0.0) / normal).hypot(s.hypot(t) / shear);
        if opening >= 1.0 {
            1.0
        } else if opening <= first {
            0.0
        } else if opening <= second {
            1.0 - first / opening
        } else {
            1.0 - first * (1.0 - opening) / (opening * (1.0 - second))
        }
    }
}
