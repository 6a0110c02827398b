//! Bilinear cohesive law in mixed mode, as in `*MAT_COHESIVE_MIXED_MODE` (LS-DYNA Keyword User's
//! Manual, vol. II, material 138; Camanho & Davila 2002).
//!
//! With the opening `u = sqrt(max(u_n, 0)^2 + u_s^2 + u_t^2)`, its shares `c = max(u_n, 0)/u` and
//! `s = sqrt(1 - c^2)`, and the openings at the peaks of pure modes `u_I = T/K_n`, `u_II = S/K_s`,
//! damage begins at
//! ```text
//! u_0 = u_I u_II / sqrt((c u_II)^2 + (s u_I)^2)
//! ```
//! which is `(t_n/T)^2 + (t_s/S)^2 = 1`, and ends, by the power law with the exponent m or by
//! Benzeggagh & Kenane 1996 with the exponents m and g, at
//! ```text
//! u_f = 2/u_0 ((c^2 K_n/G_I)^m + (s^2 K_s/G_II)^m)^(-1/m)
//! u_f = 2/(u_0 (c^2 K_n^g + s^2 K_s^g)^(1/g)) (G_I + (G_II - G_I) (s^2 K_s/(c^2 K_n + s^2 K_s))^m)
//! D = u_f (u - u_0)/(u (u_f - u_0))
//! ```
//! With one mixture on the whole path the work is then that of the criterion; Benzeggagh & Kenane
//! only with g = 1 or equal stiffnesses. A point without damage that would have `u_f < u_0` breaks
//! at u_0. D is the largest so far, also if the mixture changes.

use super::{Cohesive, CohesiveFace, CohesiveLawResult, FACE, face, row};
use crate::materials::parameters::Parameters;
use crate::materials::{DefaultValue, Law};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "cohesive_mixed_mode",
    meaning: "Cohesive law that softens linearly, with toughnesses of both modes and of mixtures.",
    constants: &[],
    parameters: &[
        FACE[0],
        FACE[1],
        FACE[2],
        row(
            "strength_normal",
            DefaultValue::Needed,
            "Largest traction along the normal, in tension [force/length^2].",
        ),
        row(
            "strength_shear",
            DefaultValue::Needed,
            "Largest traction in the surface [force/length^2].",
        ),
        row(
            "toughness_normal",
            DefaultValue::Needed,
            "Work to separation by opening, G_Ic, per area [force/length].",
        ),
        row(
            "toughness_shear",
            DefaultValue::Needed,
            "Work to separation by sliding, G_IIc, per area [force/length].",
        ),
        row(
            "power_exponent",
            DefaultValue::Number(1.0),
            "Exponent of the power law of mixtures, (G_I/G_Ic)^m + (G_II/G_IIc)^m = 1.",
        ),
        row(
            "benzeggagh_kenane",
            DefaultValue::Absent,
            "Exponent of Benzeggagh and Kenane, in place of the power law.",
        ),
        row(
            "stiffness_exponent",
            DefaultValue::Absent,
            "Exponent g of the mean stiffness, with `benzeggagh_kenane`; 1 if it is not given.",
        ),
    ],
    build: None,
    solid: None,
    cohesive: Some(build),
};

/// Criterion of mixtures.
enum Mixture {
    /// Power law with this exponent.
    Power(f64),
    /// Exponents m and g of Benzeggagh & Kenane.
    BenzeggaghKenane(f64, f64),
}

struct MixedMode {
    face: CohesiveFace,
    /// Openings at the peaks of pure modes [length].
    peak: [f64; 2],
    /// Toughnesses [force/length].
    toughness: [f64; 2],
    mixture: Mixture,
}

fn build(material: &Material) -> CohesiveLawResult {
    let mut parameters = Parameters::new(material);
    let face = face(&mut parameters);
    let mut positive = |key| parameters.required(key, "above 0", |x| x > 0.0);
    let strength = ["strength_normal", "strength_shear"].map(&mut positive);
    let keys = ["toughness_normal", "toughness_shear"];
    let toughness = keys.map(&mut positive);
    let mut exponent = |key| parameters.optional(key, "above 0", |x| x > 0.0);
    let [power, kenane, of_stiffness] =
        ["power_exponent", "benzeggagh_kenane", "stiffness_exponent"].map(&mut exponent);
    for (k, key) in keys.into_iter().enumerate() {
        let elastic = 0.5 * strength[k] * strength[k] / face.stiffness[k];
        // A missing number is reported already.
        let all_given = [keys[k], ["strength_normal", "strength_shear"][k]]
            .iter()
            .chain(&[["stiffness_normal", "stiffness_shear"][k]])
            .all(|key| parameters.given(key));
        if all_given && toughness[k] <= elastic {
            let what = format_args!("is {}", toughness[k]);
            let help = format!(
                "it has to be above the work {elastic} up to the strength: raise it or the \
                 stiffness, or lower the strength"
            );
            parameters.wrong(key, what, help);
        }
    }
    if kenane.is_some() && power.is_some() {
        parameters.wrong("power_exponent", "is given with benzeggagh_kenane", "remove one of them");
    }
    if kenane.is_none() && of_stiffness.is_some() {
        let help = "remove it, or add benzeggagh_kenane";
        parameters.wrong("stiffness_exponent", "is given without benzeggagh_kenane", help);
    }
    parameters.finish()?;
    let peak = [0, 1].map(|k| strength[k] / face.stiffness[k]);
    let mixture = match kenane {
        Some(exponent) => Mixture::BenzeggaghKenane(exponent, of_stiffness.unwrap_or(1.0)),
        None => Mixture::Power(power.unwrap_or(1.0)),
    };
    Ok(Box::new(MixedMode { face, peak, toughness, mixture }))
}

impl MixedMode {
    /// Returns the openings at which damage begins and ends, with this share of opening along the
    /// normal and of sliding [length].
    fn limits(&self, c: f64, s: f64) -> [f64; 2] {
        let [first, second] = self.peak;
        let begin = first * second / (c * second).hypot(s * first);
        let ([normal, shear], [of_first, of_second]) = (self.face.stiffness, self.toughness);
        let (normal_part, shear_part) = (c * c * normal, s * s * shear);
        let end = match self.mixture {
            Mixture::Power(m) => {
                let sum = (normal_part / of_first).powf(m) + (shear_part / of_second).powf(m);
                2.0 / begin * sum.powf(-1.0 / m)
            }
            Mixture::BenzeggaghKenane(m, g) => {
                let mean = (c * c * normal.powf(g) + s * s * shear.powf(g)).powf(1.0 / g);
                let of_shear = (shear_part / (normal_part + shear_part)).powf(m);
                2.0 / (begin * mean) * (of_first + (of_second - of_first) * of_shear)
            }
        };
        [begin, end]
    }
}

impl Cohesive for MixedMode {
    fn face(&self) -> CohesiveFace {
        self.face
    }

    fn damage(&self, [n, s, t]: [f64; 3]) -> f64 {
        let (normal, shear) = (n.max(0.0), s.hypot(t));
        let opening = normal.hypot(shear);
        if opening == 0.0 {
            return 0.0;
        }
        let [begin, end] = self.limits(normal / opening, shear / opening);
        if opening <= begin {
            0.0
        } else if opening >= end {
            1.0
        } else {
            end * (opening - begin) / (opening * (end - begin))
        }
    }
}
