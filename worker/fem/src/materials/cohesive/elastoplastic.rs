//! Elastic-plastic cohesive law in mixed mode that softens after a plateau, as in
//! `*MAT_COHESIVE_MIXED_MODE_ELASTOPLASTIC_RATE` without rates (LS-DYNA Keyword User's Manual, vol.
//! II, material 240; Marzi, Hesebeck, Brede & Kleiner 2009, 7th European LS-DYNA Conference).
//!
//! With the opening `u = sqrt(max(u_n, 0)^2 + u_s^2 + u_t^2)`, its shares `c = max(u_n, 0)/u` and
//! `s = sqrt(1 - c^2)`, strengths T, S, toughnesses G_I, G_II and the shares f of them that flow
//! takes, the openings of pure modes at yield and at the start of damage are
//! ```text
//! u_1 = T/K_n,   u_2 = u_1 + f_I G_I/T,   and alike with S, K_s, f_II, G_II
//! ```
//! Those of a mixture, and the end by the power law with the exponent 1, are
//! ```text
//! u_i = u_iI u_iII / sqrt((c u_iII)^2 + (s u_iI)^2),   i = 1, 2
//! u_f = u_1 - u_2 + 2/(u_1 (c^2 K_n/G_I + s^2 K_s/G_II))
//! D = (u - u_2)/(u_f - u_2)
//! ```
//! so that on an increasing opening of one mixture the works of both modes over their toughnesses
//! add up to one. A point without damage that would have `u_f < u_2` breaks at u_2. D is the
//! largest so far. Flow is that of all laws that flow, with the yield tractions T and S: on
//! increasing openings of one mixture it is that of the manual, on other paths it never gives
//! energy.
//!
//! Left out: rates, the criteria of yield other than the quadratic one, toughnesses over the
//! thickness.

use super::{Cohesive, CohesiveFace, CohesiveLawResult, FACE, row};
use crate::materials::parameters::Parameters;
use crate::materials::{DefaultValue, Law};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "cohesive_elastoplastic",
    meaning: "Cohesive law that flows at its strength, then softens, in mixed mode.",
    constants: &[],
    parameters: &[
        FACE[0],
        FACE[1],
        FACE[2],
        row(
            KEYS[0].strength,
            DefaultValue::Needed,
            "Traction along the normal, in tension, at which the surface flows [force/length^2].",
        ),
        row(
            KEYS[1].strength,
            DefaultValue::Needed,
            "Traction in the surface at which it flows [force/length^2].",
        ),
        row(
            KEYS[0].toughness,
            DefaultValue::Needed,
            "Work to separation by opening, G_Ic, per area [force/length].",
        ),
        row(
            KEYS[1].toughness,
            DefaultValue::Needed,
            "Work to separation by sliding, G_IIc, per area [force/length].",
        ),
        row(
            KEYS[0].plateau,
            DefaultValue::Number(0.0),
            "Share of `toughness_normal` that flow at the strength takes; below \
             1 - T^2/(2 K_n G_Ic).",
        ),
        row(
            KEYS[1].plateau,
            DefaultValue::Number(0.0),
            "Share of `toughness_shear` that flow at the strength takes; below \
             1 - S^2/(2 K_s G_IIc).",
        ),
    ],
    build: None,
    solid: None,
    cohesive: Some(build),
};

/// Keys of one mode.
struct ModeKeys {
    stiffness: &'static str,
    strength: &'static str,
    toughness: &'static str,
    plateau: &'static str,
}

const KEYS: [ModeKeys; 2] = [
    ModeKeys {
        stiffness: "stiffness_normal",
        strength: "strength_normal",
        toughness: "toughness_normal",
        plateau: "plateau_normal",
    },
    ModeKeys {
        stiffness: "stiffness_shear",
        strength: "strength_shear",
        toughness: "toughness_shear",
        plateau: "plateau_shear",
    },
];

struct ElastoPlastic {
    face: CohesiveFace,
    /// T and S [force/length^2].
    strength: [f64; 2],
    /// G_I and G_II [force/length].
    toughness: [f64; 2],
    /// Openings of pure modes at yield and at the start of damage [length].
    yields: [f64; 2],
    softens: [f64; 2],
}

fn build(material: &Material) -> CohesiveLawResult {
    let mut parameters = Parameters::new(material);
    let face = super::face(&mut parameters);
    let positive = |x: f64| x > 0.0;
    let strength = KEYS.each_ref().map(|k| parameters.required(k.strength, "above 0", positive));
    let toughness = KEYS.each_ref().map(|k| parameters.required(k.toughness, "above 0", positive));
    let plateau = KEYS.each_ref().map(|k| {
        let share = parameters.optional(k.plateau, "from 0 to 1", |f| (0.0..1.0).contains(&f));
        share.unwrap_or(0.0)
    });
    let yields = [0, 1].map(|k| strength[k] / face.stiffness[k]);
    for (k, keys) in KEYS.iter().enumerate() {
        // A missing number is reported already.
        let all_given =
            [keys.stiffness, keys.strength, keys.toughness].iter().all(|key| parameters.given(key));
        let elastic = 0.5 * strength[k] * yields[k];
        if !all_given {
            continue;
        }
        if toughness[k] <= elastic {
            let help = format!(
                "it has to be above the work {elastic} up to the strength: raise it or the \
                 stiffness, or lower the strength"
            );
            parameters.wrong(keys.toughness, format_args!("is {}", toughness[k]), help);
        } else if plateau[k] >= 1.0 - elastic / toughness[k] {
            let help = format!(
                "it has to be below {}, so that work is left for softening",
                1.0 - elastic / toughness[k]
            );
            parameters.wrong(keys.plateau, format_args!("is {}", plateau[k]), help);
        }
    }
    parameters.finish()?;
    let softens = [0, 1].map(|k| yields[k] + plateau[k] * toughness[k] / strength[k]);
    Ok(Box::new(ElastoPlastic { face, strength, toughness, yields, softens }))
}

/// Returns the opening of a mixture from those of pure modes [length], on an ellipse.
fn of_mixture([first, second]: [f64; 2], c: f64, s: f64) -> f64 {
    first * second / (c * second).hypot(s * first)
}

impl Cohesive for ElastoPlastic {
    fn face(&self) -> CohesiveFace {
        self.face
    }

    fn yield_tractions(&self) -> Option<[f64; 2]> {
        Some(self.strength)
    }

    fn damage(&self, [n, s, t]: [f64; 3]) -> f64 {
        let (normal, shear) = (n.max(0.0), s.hypot(t));
        let opening = normal.hypot(shear);
        if opening == 0.0 {
            return 0.0;
        }
        let (c, s) = (normal / opening, shear / opening);
        let ([kn, ks], [gn, gs]) = (self.face.stiffness, self.toughness);
        let [first, second] = [self.yields, self.softens].map(|of| of_mixture(of, c, s));
        let end = first - second + 2.0 / (first * (c * c * kn / gn + s * s * ks / gs));
        if opening <= second {
            0.0
        } else if opening >= end {
            1.0
        } else {
            (opening - second) / (end - second)
        }
    }
}
