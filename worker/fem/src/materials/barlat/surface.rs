//! Yield surface of Barlat & Lian 1989 in plane stress, and the return of a trial stress to it.
//!
//! Along the axes of the material, with `K1 = (s_a + h s_b)/2`, `u = (s_a - h s_b)/2` and
//! `K2 = sqrt(u^2 + (p s_ab)^2)`,
//! ```text
//! s_eq^m = (a |K1 + K2|^m + a |K1 - K2|^m + (2 - a) |2 K2|^m)/2
//! ```
//! is homogeneous and convex. With the flow rule `d eps_p = d g n`, `n = d s_eq/d s`, the rate of
//! plastic work is `s_eq d g`: g is the effective plastic strain. The return is the closest point
//! of Simo & Hughes 1998, ch. 3: with the elastic trial t and the stiffness C
//! ```text
//! r = s - t + y C n(s) = 0,   f = s_eq(s) - s_y(g + y) = 0
//! ```
//! by Newton's method from the stress on the ray of the trial. A step that it does not solve is
//! divided into two.

/// A stress along the axes a, b, and the shear stress [force/length^2]; or three such numbers.
pub type Three = [f64; 3];

/// Largest error of the yield condition, as a fraction of the yield stress.
const TOLERANCE: f64 = 1e-12;
/// Newton steps; close to the solution each of them squares the error.
const STEPS: usize = 25;
/// Times that a step may be divided into two.
const DIVISIONS: usize = 12;
/// Share of K1 below which K2 is zero: there the function of K2 is even.
const NO_DEVIATOR: f64 = 1e-9;

/// Parameters of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarlatSurface {
    m: f64,
    a: f64,
    h: f64,
    p: f64,
}

/// Equivalent stress, its gradient and its matrix of second derivatives.
struct Derivatives {
    value: f64,
    first: Three,
    second: [Three; 3],
}

/// A stress with its effective plastic strain.
#[derive(Clone, Copy, Debug)]
pub struct YieldState {
    pub stress: Three,
    pub plastic_strain: f64,
}

impl BarlatSurface {
    /// Returns the surface with the exponent m, 2 or above, and the ratios of the plastic strains
    /// across and through the sheet in tension at 0, 45 and 90 degrees to the axis a; `None` if no
    /// p gives that at 45 degrees.
    pub fn new(m: f64, [r0, r45, r90]: [f64; 3]) -> Option<Self> {
        let shares = [r0, r90].map(|r| r / (1.0 + r));
        let a = 2.0 - 2.0 * (shares[0] * shares[1]).sqrt();
        let h = (shares[0] / shares[1]).sqrt();
        let of = |p: f64| Self { m, a, h, p };
        // The ratio grows with p, as shear makes the sheet contract across.
        let (mut low, mut high) = (1e-3, 1e3);
        if !(of(low).ratio_at_45() < r45 && r45 < of(high).ratio_at_45()) {
            return None;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if of(middle).ratio_at_45() < r45 { low = middle } else { high = middle }
        }
        Some(of(0.5 * (low + high)))
    }

    /// Ratio of the plastic strains across and through the sheet in tension at 45 degrees.
    fn ratio_at_45(&self) -> f64 {
        let [a, b, ab] = self.derivatives([0.5; 3]).first;
        0.5 * (ab - a - b) / (a + b)
    }

    /// Returns a factor on `|K1| + K2` that gives no less than the equivalent stress.
    pub fn bound(&self) -> f64 {
        // Each of |K1 +- K2| is |K1| + K2 at most, and 2 K2 twice of it.
        (self.a + 0.5 * (2.0 - self.a) * 2.0_f64.powf(self.m)).powf(1.0 / self.m)
    }

    /// Returns h and p.
    pub fn weights(&self) -> [f64; 2] {
        [self.h, self.p]
    }

    /// Returns the equivalent stress [force/length^2].
    pub fn equivalent(&self, [a, b, ab]: Three) -> f64 {
        let (k1, k2) = (0.5 * (a + self.h * b), (0.5 * (a - self.h * b)).hypot(self.p * ab));
        let scale = k1.abs() + k2;
        if scale == 0.0 {
            return 0.0;
        }
        let term = |k: f64| (k.abs() / scale).powf(self.m);
        let sum = self.a * (term(k1 + k2) + term(k1 - k2)) + (2.0 - self.a) * term(2.0 * k2);
        scale * (0.5 * sum).powf(1.0 / self.m)
    }

    fn derivatives(&self, [s_a, s_b, s_ab]: Three) -> Derivatives {
        let Self { m, a, h, p } = *self;
        let (k1, u, t) = (0.5 * (s_a + h * s_b), 0.5 * (s_a - h * s_b), p * s_ab);
        let scale = k1.abs() + u.hypot(t);
        let k2 = u.hypot(t).max(NO_DEVIATOR * scale);
        // In units of the scale: powers of stresses neither overflow nor underflow.
        let power = |k: f64| (k.abs() / scale).powf(m - 2.0);
        let (plus, minus, twice) = (k1 + k2, k1 - k2, 2.0 * k2);
        let [at_plus, at_minus, at_twice] =
            [(plus, a), (minus, a), (twice, 2.0 - a)].map(|(k, c)| 0.5 * c * power(k));
        // G = s_eq^m, its derivatives by K1 and K2.
        let g = (at_plus * plus * plus + at_minus * minus * minus + at_twice * twice * twice)
            / (scale * scale);
        let g1 = m * (at_plus * plus + at_minus * minus) / scale;
        let g2 = m * (at_plus * plus - at_minus * minus + 2.0 * at_twice * twice) / scale;
        let curved = m * (m - 1.0);
        let g11 = curved * (at_plus + at_minus);
        let g12 = curved * (at_plus - at_minus);
        let g22 = curved * (at_plus + at_minus + 4.0 * at_twice);
        let root = g.powf(1.0 / m);
        let factor = root / (m * g);
        let fall = 1.0 - 1.0 / m;
        let (f1, f2) = (factor * g1, factor * g2);
        let by = |gij: f64, gi: f64, gj: f64| factor / scale * (gij - fall * gi * gj / g);
        let [f11, f12, f22] = [by(g11, g1, g1), by(g12, g1, g2), by(g22, g2, g2)];
        // K2 is the length of (u, t).
        let (cos, sin) = (u / k2, t / k2);
        let d1 = [0.5, 0.5 * h, 0.0];
        let d2 = [0.5 * cos, -0.5 * h * cos, p * sin];
        let (du, dt) = ([0.5, -0.5 * h, 0.0], [0.0, 0.0, p]);
        let second = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let bent = (du[i] * du[j] + dt[i] * dt[j] - d2[i] * d2[j]) / k2;
                f11 * d1[i] * d1[j]
                    + f12 * (d1[i] * d2[j] + d2[i] * d1[j])
                    + f22 * d2[i] * d2[j]
                    + f2 * bent
            })
        });
        let first = std::array::from_fn(|i| f1 * d1[i] + f2 * d2[i]);
        Derivatives { value: scale * root, first, second }
    }

    /// Returns the stress and the plastic strain after an elastic trial beyond the surface.
    /// `before` is the state before the step, `stiffness` C_aa, C_ab and G of the isotropic sheet,
    /// `hardening` gives the yield stress and its slope at a plastic strain.
    pub fn returned(
        &self,
        before: YieldState,
        trial: Three,
        stiffness: Three,
        hardening: &impl Fn(f64) -> [f64; 2],
    ) -> YieldState {
        let mut parts = 1_u32;
        for _ in 0..DIVISIONS {
            if let Some(after) = self.in_parts(parts, before, trial, stiffness, hardening) {
                return after;
            }
            parts *= 2;
        }
        // Not reached in tests with trials of a hundred times the yield stress; the ray at least
        // ends on the surface.
        let [yield_stress, _] = hardening(before.plastic_strain);
        let factor = yield_stress / self.equivalent(trial);
        YieldState { stress: trial.map(|s| factor * s), ..before }
    }

    fn in_parts(
        &self,
        parts: u32,
        before: YieldState,
        trial: Three,
        stiffness: Three,
        hardening: &impl Fn(f64) -> [f64; 2],
    ) -> Option<YieldState> {
        let part = 1.0 / f64::from(parts);
        let more: Three = std::array::from_fn(|i| part * (trial[i] - before.stress[i]));
        (0..parts).try_fold(before, |state, _| {
            let trial = std::array::from_fn(|i| state.stress[i] + more[i]);
            let elastic = YieldState { stress: trial, ..state };
            if self.equivalent(trial) <= hardening(state.plastic_strain)[0] {
                return Some(elastic);
            }
            self.closest(elastic, stiffness, hardening)
        })
    }

    /// Returns the closest point to a trial stress by Newton's method; `None` if it does not
    /// converge.
    fn closest(
        &self,
        trial: YieldState,
        [c11, c12, g]: Three,
        hardening: &impl Fn(f64) -> [f64; 2],
    ) -> Option<YieldState> {
        let YieldState { stress: trial, plastic_strain: before } = trial;
        let times_c = |v: Three| [c11 * v[0] + c12 * v[1], c12 * v[0] + c11 * v[1], g * v[2]];
        let [yield_stress, _] = hardening(before);
        let factor = yield_stress / self.equivalent(trial);
        let mut stress = trial.map(|s| factor * s);
        let along = times_c(self.derivatives(stress).first);
        let length = |v: Three| v[0].hypot(v[1]).hypot(v[2]);
        let mut y = (1.0 - factor) * length(trial) / length(along);
        for _ in 0..STEPS {
            let Derivatives { value, first, second } = self.derivatives(stress);
            let [sig_y, modulus] = hardening(before + y);
            let along = times_c(first);
            let rest: Three = std::array::from_fn(|i| stress[i] - trial[i] + y * along[i]);
            let off = value - sig_y;
            if off.abs() <= TOLERANCE * sig_y && length(rest) <= TOLERANCE * sig_y {
                return (y >= 0.0).then_some(YieldState { stress, plastic_strain: before + y });
            }
            // (1 + y C N) ds = -rest - dy C n
            let columns = second.map(times_c);
            let matrix: [Three; 3] = std::array::from_fn(|i| {
                std::array::from_fn(|j| f64::from(u8::from(i == j)) + y * columns[j][i])
            });
            let [by_rest, by_along] = solve(matrix, [rest, along])?;
            let dot = |v: Three| first[0] * v[0] + first[1] * v[1] + first[2] * v[2];
            let step = (off - dot(by_rest)) / (dot(by_along) + modulus);
            stress = std::array::from_fn(|i| stress[i] - by_rest[i] - step * by_along[i]);
            y += step;
            if !(y.is_finite() && stress.iter().all(|s| s.is_finite()) && stress != [0.0; 3]) {
                return None;
            }
        }
        None
    }
}

/// Solves with two right sides by Cramer's rule; `None` if the matrix is singular.
fn solve(matrix: [Three; 3], right: [Three; 2]) -> Option<[Three; 2]> {
    let [a, b, c] = [0, 1, 2].map(|j| matrix.map(|row| row[j]));
    let cross = |a: Three, b: Three| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: Three, b: Three| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, rows[0]);
    (determinant != 0.0).then(|| right.map(|v| rows.map(|row| dot(row, v) / determinant)))
}
