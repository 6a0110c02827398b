//! Yield surface of Gurson, Tvergaard and Needleman as an equivalent stress, and voids.

/// Newton steps for the equivalent stress; five to ten are enough.
const NEWTON_STEPS: usize = 60;
/// Relative change that ends them.
const TOLERANCE: f64 = 1e-14;
/// Smallest `1 - q1 f*`: so much of the strength is left in a point without a failure fraction.
const LEAST_INTACT: f64 = 1e-3;

/// Nucleation of voids, a normal distribution over the plastic strain.
pub struct Nucleation {
    /// Void fraction of all particles f_N.
    pub fraction: f64,
    /// Mean strain.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
}

impl Nucleation {
    /// Returns the void fraction that forms per plastic strain.
    pub fn rate(&self, strain: f64) -> f64 {
        let away = (strain - self.mean) / self.deviation;
        let peak = self.fraction / (self.deviation * (2.0 * std::f64::consts::PI).sqrt());
        peak * (-0.5 * away * away).exp()
    }
}

/// Equivalent stress, and its derivatives in the von Mises stress and the mean stress.
#[derive(Clone, Copy, Debug, Default)]
pub struct Equivalent {
    /// Yield stress of the matrix at which the stress is on the surface [force/length^2].
    pub stress: f64,
    /// Derivative in the von Mises stress.
    pub of_mises: f64,
    /// Derivative in the mean stress.
    pub of_mean: f64,
}

/// The yield surface.
pub struct VoidSurface {
    /// q1.
    pub q1: f64,
    /// q2.
    pub q2: f64,
    /// Void fraction f_c from which on voids coalesce.
    pub critical: f64,
}

impl VoidSurface {
    /// Returns `q1 f*`, with the void fraction at failure, infinite without failure.
    pub fn weakening(&self, voids: f64, failure: f64) -> f64 {
        let beyond = voids - self.critical;
        let effective = if beyond > 0.0 && failure.is_finite() {
            let ultimate = 1.0 / self.q1;
            self.critical + (ultimate - self.critical) / (failure - self.critical) * beyond
        } else {
            voids
        };
        (self.q1 * effective).clamp(0.0, 1.0 - LEAST_INTACT)
    }

    /// Returns true if the stress is inside the surface of this yield stress of the matrix.
    pub fn holds(&self, [mises, mean]: [f64; 2], weakening: f64, yield_stress: f64) -> bool {
        let [q, w] = [mises / yield_stress, 1.5 * self.q2 * mean / yield_stress];
        let intact = 1.0 - weakening;
        let half = (0.5 * w).sinh();
        q * q + 4.0 * weakening * half * half <= intact * intact
    }

    /// Returns the equivalent stress of a von Mises stress and a mean stress (positive in tension).
    ///
    /// Its inverse s is the zero of `(q s)^2 + 2 q1 f* (cosh(3/2 q2 p s) - 1) - (1 - q1 f*)^2`, an
    /// ascending convex function of s: Newton steps from above stay above.
    pub fn equivalent(&self, [mises, mean]: [f64; 2], weakening: f64) -> Equivalent {
        let intact = 1.0 - weakening;
        let w = 1.5 * self.q2 * mean.abs();
        let of_mises = if mises > 0.0 { intact / mises } else { f64::INFINITY };
        let of_mean = if w > 0.0 && weakening > 0.0 {
            (1.0 + intact * intact / (2.0 * weakening)).acosh() / w
        } else {
            f64::INFINITY
        };
        let mut s = of_mises.min(of_mean);
        if s.is_infinite() {
            return Equivalent::default();
        }
        let mut slope = 0.0;
        for _ in 0..NEWTON_STEPS {
            let half = (0.5 * w * s).sinh();
            let value = (mises * s).powi(2) + 4.0 * weakening * half * half - intact * intact;
            slope = 2.0 * mises * mises * s + 2.0 * weakening * w * (w * s).sinh();
            let step = value / slope;
            s -= step;
            if step.abs() <= TOLERANCE * s {
                break;
            }
        }
        let of_p = 3.0 * self.q2 * weakening * s * (w * s).sinh();
        Equivalent {
            stress: 1.0 / s,
            of_mises: 2.0 * mises / slope,
            of_mean: of_p.copysign(mean) / (s * s * slope),
        }
    }
}
