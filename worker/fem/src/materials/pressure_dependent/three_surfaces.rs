//! Strength of concrete by three surfaces and three invariants (Malvar, Crawford, Wesevich & Simons
//! 1997, A plasticity concrete material model for DYNA3D, Int. J. Impact Eng. 19):
//! ```text
//! S_m = a0 + p/(a1 + a2 p)    largest strength,   p >= f_c/3
//! S_m = 3 (p + f_t)/(2 psi)   below, so that the tensile meridian psi S_m is a line through f_t
//! S_y = a0y + p/(a1y + a2y p)  first yield,   S_r = p/(a1f + a2f p)  residual
//! S = eta S_m + (1 - eta) S_y up to the peak of eta, and with S_r beyond it
//! q <= S r(psi, theta)
//! ```
//! q is the von Mises stress, theta the Lode angle, 0 on the tensile meridian, and r the ratio of
//! Willam and Warnke (1975), psi there and 1 on the compressive meridian. psi is linear between:
//! ```text
//! p/f_c   0     1/3                  2 alpha/3                    3      8.45
//! psi     1/2   1/2 + 3 f_t/(2 f_c)  alpha f_c/S_m, alpha = 1.15  0.753  1
//! ```
//! The strength f_c of a bar in compression follows from `S_m(f_c/3) = f_c`.
//!
//! The source does not say how S_y goes on in tension: here it falls on a line to 0 at `p = -f_t`.
//! S_y and S_r are at most S_m.

/// Ratio of the strengths under equal pressure along two axes and along one.
const BIAXIAL: f64 = 1.15;
/// Pressures over f_c beyond which psi is known, and psi.
const CONFINED: [[f64; 2]; 2] = [[3.0, 0.753], [8.45, 1.0]];

/// The three surfaces.
pub(super) struct ThreeSurfaces {
    /// a0, a1, a2 of the largest strength, and of first yield; a1f, a2f of the residual strength.
    pub(super) largest: [f64; 3],
    pub(super) first: [f64; 3],
    pub(super) residual: [f64; 2],
    /// f_t [force/length^2].
    pub(super) tension: f64,
    /// f_c [force/length^2].
    pub(super) compression: f64,
    /// Pressures and psi.
    ratios: [[f64; 2]; 5],
}

/// Damage: eta, and whether it is beyond its peak.
#[derive(Clone, Copy)]
pub(super) struct DamageState {
    pub(super) eta: f64,
    pub(super) softens: bool,
}

/// Returns the strength of a bar in compression by the surface of the largest strength; none if the
/// surface has none.
pub(super) fn bar_strength([a0, a1, a2]: [f64; 3]) -> Option<f64> {
    let over = |f: f64| a0 + f / 3.0 / (a1 + a2 * f / 3.0) - f;
    let mut high = (1..200).map(|k| a0 * 1.1_f64.powi(k)).find(|f| over(*f) <= 0.0)?;
    let mut low = high / 1.1;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if over(middle) > 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

impl ThreeSurfaces {
    /// Creates the surfaces; `compression` is the strength of a bar.
    pub(super) fn new(
        [largest, first]: [[f64; 3]; 2],
        residual: [f64; 2],
        [tension, compression]: [f64; 2],
    ) -> Self {
        let f = compression;
        let biaxial = 2.0 / 3.0 * BIAXIAL * f;
        let [a0, a1, a2] = largest;
        let at_biaxial = BIAXIAL * f / (a0 + biaxial / (a1 + a2 * biaxial));
        let mut ratios = [
            [0.0, 0.5],
            [f / 3.0, 0.5 + 1.5 * tension / f],
            [biaxial, at_biaxial],
            [CONFINED[0][0] * f, CONFINED[0][1]],
            [CONFINED[1][0] * f, CONFINED[1][1]],
        ];
        // A corner of the section would become sharper with the pressure.
        for k in 1..ratios.len() {
            ratios[k][1] = ratios[k][1].clamp(ratios[k - 1][1], 1.0);
        }
        Self { largest, first, residual, tension, compression, ratios }
    }

    /// Returns psi, the strength on the tensile meridian over that on the compressive one.
    pub(super) fn ratio(&self, pressure: f64) -> f64 {
        let ratios = &self.ratios;
        let next = ratios.partition_point(|point| point[0] <= pressure);
        if next == 0 || next == ratios.len() {
            return ratios[next.saturating_sub(1)][1];
        }
        let [low, high] = [ratios[next - 1], ratios[next]];
        low[1] + (high[1] - low[1]) * (pressure - low[0]) / (high[0] - low[0])
    }

    /// Returns the largest strength on the compressive meridian [force/length^2].
    pub(super) fn largest(&self, pressure: f64) -> f64 {
        let [a0, a1, a2] = self.largest;
        if pressure >= self.compression / 3.0 {
            a0 + pressure / (a1 + a2 * pressure)
        } else {
            1.5 * (pressure + self.tension).max(0.0) / self.ratio(pressure)
        }
    }

    /// Returns the strength in this pressure at the Lode angle of `cos 3 theta` [force/length^2].
    pub(super) fn strength(&self, pressure: f64, cos3: f64, damage: DamageState) -> f64 {
        let largest = self.largest(pressure);
        let [a0, a1, a2] = self.first;
        let [a1f, a2f] = self.residual;
        let other = if damage.softens {
            let pressed = pressure.max(0.0);
            pressed / (a1f + a2f * pressed)
        } else if pressure >= 0.0 {
            a0 + pressure / (a1 + a2 * pressure)
        } else {
            a0 * (1.0 + pressure / self.tension).max(0.0)
        };
        let other = other.min(largest);
        let meridian = damage.eta.mul_add(largest - other, other);
        meridian * willam_warnke(self.ratio(pressure), cos3)
    }
}

/// Returns the radius at a Lode angle over that on the compressive meridian (Willam & Warnke 1975).
pub(super) fn willam_warnke(psi: f64, cos3: f64) -> f64 {
    let cos = (cos3.clamp(-1.0, 1.0).acos() / 3.0).cos();
    let (left, twice) = (1.0 - psi * psi, 2.0 * psi - 1.0);
    let root = (4.0 * left * cos * cos + 5.0 * psi * psi - 4.0 * psi).max(0.0).sqrt();
    (2.0 * left * cos + twice * root) / (4.0 * left * cos * cos + twice * twice)
}
