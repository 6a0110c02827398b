//! Yield stress over the effective plastic strain, of laws that return each element alone:
//! `yield_stress` and `hardening_modulus`, the table `hardening`, or `swift = [k, e0, n]`, the
//! stress `k (e0 + eps_p)^n` (Swift 1952).

use super::j2;
use super::parameters::Parameters;
use super::polyline::{Beyond, RampCurve};
use super::{DefaultValue, Form, ParameterRow};
use crumple_math::lanes::{LANES32, Real};
use crumple_proto::partition::Param;

const SWIFT: &str = "swift";

/// Keys of hardening.
pub const HARDENING: [ParameterRow; 4] = [
    ParameterRow {
        otherwise: DefaultValue::Depends("needed without `hardening` and `swift`"),
        ..j2::HARDENING[0]
    },
    j2::HARDENING[1],
    j2::HARDENING[2],
    ParameterRow {
        key: SWIFT,
        form: Form::List("[k, e0, n]"),
        otherwise: DefaultValue::Absent,
        range: None,
        meaning: "Yield stress `k (e0 + eps_p)^n` in place of the other keys of hardening; k is a \
                  stress [force/length^2].",
    },
];

/// Yield stress over the effective plastic strain.
pub enum Hardening {
    /// Straight lines.
    Lines(RampCurve),
    /// `k (e0 + eps_p)^n`.
    Swift {
        /// Strength k [force/length^2].
        k: f64,
        /// Strain e0.
        e0: f64,
        /// Exponent n.
        n: f64,
    },
}

impl Hardening {
    /// Reads the keys of [`HARDENING`].
    pub fn read(parameters: &mut Parameters<'_>) -> Self {
        if let Some([k, e0, n]) = swift(parameters) {
            for row in &HARDENING[..3] {
                if parameters.get(row.key).is_some() {
                    let what = format!("is given together with {}", row.key);
                    parameters.wrong(SWIFT, what, "give only one of them");
                }
            }
            return Self::Swift { k, e0, n };
        }
        let (yield_stress, slope, ramps) = j2::hardening(parameters);
        // Only a hardening modulus has no last point.
        let beyond = if ramps.is_empty() { Beyond::Straight } else { Beyond::Constant };
        let points = j2::rows_of(yield_stress, slope, &ramps);
        let points: Vec<[f64; 2]> = points.iter().map(|row| [row[1], row[2]]).collect();
        Self::Lines(RampCurve::new(&points, 1.0, beyond))
    }

    /// Returns the yield stress and its slope at a plastic strain [force/length^2].
    pub fn at(&self, strain: f64) -> [f64; 2] {
        match self {
            Hardening::Lines(curve) => curve.at(strain),
            Hardening::Swift { k, e0, n } => {
                let value = k * (e0 + strain).powf(*n);
                [value, n * value / (e0 + strain)]
            }
        }
    }

    /// Returns the yield stress of the first `count` lanes [force/length^2]; `lanes` makes a group
    /// of their numbers.
    #[inline(always)]
    pub fn of_lanes<R: Real>(
        &self,
        strain: R,
        count: usize,
        lanes: &impl Fn(&[f64; LANES32]) -> R,
    ) -> R {
        match self {
            Hardening::Lines(curve) => curve.at(strain)[0],
            Hardening::Swift { .. } => {
                let mut of_lanes = [0.0; LANES32];
                for (lane, value) in of_lanes.iter_mut().enumerate().take(count) {
                    *value = self.at(strain.lane(lane))[0];
                }
                lanes(&of_lanes)
            }
        }
    }
}

/// Returns k, e0 and n.
fn swift(parameters: &mut Parameters<'_>) -> Option<[f64; 3]> {
    let list = match parameters.get(SWIFT)? {
        Param::List(list) => <[f64; 3]>::try_from(list.as_slice()).ok(),
        _ => None,
    };
    let sound =
        |&[k, e0, n]: &[f64; 3]| [k, e0, n].iter().all(|x| x.is_finite() && *x > 0.0) && n <= 1.0;
    let list = list.filter(sound);
    if list.is_none() {
        parameters.wrong(SWIFT, "is not [k, e0, n]", "give three numbers above 0, n at most 1");
    }
    Some(list.unwrap_or([1.0; 3]))
}
