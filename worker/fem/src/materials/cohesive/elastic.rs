//! Elastic cohesive law: a point fails at once where a traction reaches its limit, as in
//! `*MAT_COHESIVE_ELASTIC` (LS-DYNA Keyword User's Manual, vol. II, material 184):
//! ```text
//! t_n >= N   or   sqrt(t_s^2 + t_t^2) >= S
//! ```

use super::{Cohesive, CohesiveFace, CohesiveLawResult, FACE, face, row};
use crate::materials::parameters::Parameters;
use crate::materials::{DefaultValue, Law};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "cohesive_elastic",
    meaning: "Elastic cohesive law with limits of the tractions.",
    constants: &[],
    parameters: &[
        FACE[0],
        FACE[1],
        FACE[2],
        row(
            "strength_normal",
            DefaultValue::Absent,
            "Traction along the normal, in tension, from which on a point fails [force/length^2].",
        ),
        row(
            "strength_shear",
            DefaultValue::Absent,
            "Traction in the surface from which on a point fails [force/length^2].",
        ),
    ],
    build: None,
    solid: None,
    cohesive: Some(build),
};

struct ElasticFace {
    face: CohesiveFace,
    /// Limits of the tractions [force/length^2].
    strength: [f64; 2],
}

fn build(material: &Material) -> CohesiveLawResult {
    let mut parameters = Parameters::new(material);
    let face = face(&mut parameters);
    let strength = ["strength_normal", "strength_shear"].map(|key| {
        parameters.optional(key, "above 0", |limit| limit > 0.0).unwrap_or(f64::INFINITY)
    });
    parameters.finish()?;
    Ok(Box::new(ElasticFace { face, strength }))
}

/// Returns a law without failure with these stiffnesses [force/length^3].
pub fn law(stiffness: f64) -> Box<dyn Cohesive> {
    let face = CohesiveFace {
        stiffness: [stiffness; 2],
        pressed: stiffness,
        density: 1.0,
        per_area: true,
    };
    Box::new(ElasticFace { face, strength: [f64::INFINITY; 2] })
}

impl Cohesive for ElasticFace {
    fn face(&self) -> CohesiveFace {
        self.face
    }
    fn damage(&self, [n, s, t]: [f64; 3]) -> f64 {
        let [normal, shear] = self.face.stiffness;
        let fails = normal * n >= self.strength[0] || shear * s.hypot(t) >= self.strength[1];
        if fails { 1.0 } else { 0.0 }
    }
}
