//! Number of failed points through the thickness from which on a shell is removed.

use super::parameters::Parameters;

/// The number as given: none for all points, below 0 a percentage of the points.
pub struct FailedPoints(Option<f64>);

impl FailedPoints {
    /// Reads the optional key.
    pub fn read(parameters: &mut Parameters<'_>, key: &'static str) -> Self {
        let count = |n: f64| n >= 1.0 && n.fract() == 0.0 || (-100.0..0.0).contains(&n);
        let wanted = "a whole number from 1 on, or from -100 to below 0";
        Self(parameters.optional(key, wanted, count))
    }

    /// Returns the number of `points`, or `otherwise` if none was given.
    pub fn of(&self, points: usize, otherwise: usize) -> usize {
        match self.0 {
            None => otherwise,
            // Round-off must not make a whole percentage of the points one more.
            Some(n) if n < 0.0 => (-0.01 * n * points as f64 - 1e-9).ceil().max(1.0) as usize,
            Some(n) => (n as usize).min(points),
        }
    }
}
