//! Number of failed points through the thickness from which on a shell is removed.

use super::parameters::Parameters;

/// The number as given: none for all points, below 0 a percentage of the points.
pub struct FailedPoints(Option<f64>);

impl FailedPoints {
    /// The numbers that are possible.
    pub const WANTED: &str = "a whole number from 1 on, or from -100 to below 0";

    /// Reads the optional key.
    pub fn read(parameters: &mut Parameters<'_>, key: &'static str) -> Self {
        Self(parameters.optional(key, Self::WANTED, Self::is_possible))
    }

    /// Takes a possible number.
    pub fn new(number: Option<f64>) -> Self {
        Self(number)
    }

    /// Returns true if a number is possible.
    pub fn is_possible(n: f64) -> bool {
        n >= 1.0 && n.fract() == 0.0 || (-100.0..0.0).contains(&n)
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
