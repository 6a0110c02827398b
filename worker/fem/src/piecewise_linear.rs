//! Functions that are given by points, for springs and joints.

/// A piecewise linear function, extrapolated beyond its ends.
#[derive(Clone, Debug)]
pub struct PiecewiseLinear(Vec<[f64; 2]>);

impl PiecewiseLinear {
    /// Builds the function from its points `[x, y]`, or through the origin with a slope if there
    /// are no points.
    ///
    /// # Panics
    /// With one point; see [`PiecewiseLinear::fault`].
    pub fn new(points: &[[f64; 2]], slope: f64) -> Self {
        assert!(points.len() != 1, "a line has two points");
        if points.is_empty() { Self(vec![[0.0, 0.0], [1.0, slope]]) } else { Self(points.to_vec()) }
    }

    fn slope_of(&self, piece: usize) -> f64 {
        let [[x0, y0], [x1, y1]] = [self.0[piece], self.0[piece + 1]];
        (y1 - y0) / (x1 - x0)
    }

    fn piece(&self, x: f64) -> usize {
        self.0[1..self.0.len() - 1].partition_point(|p| p[0] <= x)
    }

    /// Returns the value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        let piece = self.piece(x);
        self.0[piece][1] + self.slope_of(piece) * (x - self.0[piece][0])
    }

    /// Returns the slope at `x`, that after it at a point.
    pub fn slope(&self, x: f64) -> f64 {
        self.slope_of(self.piece(x))
    }

    /// Returns the largest size of a slope.
    pub fn steepest(&self) -> f64 {
        (0..self.0.len() - 1).map(|piece| self.slope_of(piece).abs()).fold(0.0, f64::max)
    }

    /// Returns its points `[x, y]`.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.0
    }

    /// Returns the slopes of its pieces, in their order.
    pub fn slopes(&self) -> impl Iterator<Item = f64> + use<'_> {
        (0..self.0.len() - 1).map(|piece| self.slope_of(piece))
    }

    /// Returns the inverse of an ascending function.
    pub fn inverse(&self) -> Self {
        Self(self.0.iter().map(|&[x, y]| [y, x]).collect())
    }

    /// Returns the `x` nearest to zero where a function through the origin that does not descend
    /// has the value `y`; its last point on that side if it never has.
    pub fn first_at(&self, y: f64) -> f64 {
        let last = self.0.len() - 2;
        let piece = match y >= 0.0 {
            true => (0..last).find(|&p| self.0[p + 1][1] >= y).unwrap_or(last),
            false => (1..=last).rev().find(|&p| self.0[p][1] <= y).unwrap_or(0),
        };
        let ([x, before], slope) = (self.0[piece], self.slope_of(piece));
        if slope > 0.0 {
            x + (y - before) / slope
        } else {
            self.0[piece + usize::from(y >= 0.0)][0]
        }
    }

    /// Returns the error in the points, if any.
    pub fn fault(points: &[[f64; 2]]) -> Option<String> {
        match points.windows(2).find(|p| p[1][0] <= p[0][0]) {
            Some(p) => Some(format!("does not ascend from {:?} to {:?}", p[0][0], p[1][0])),
            None if points.len() == 1 => Some("has one point only".into()),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_on_beyond_their_ends() {
        let line = PiecewiseLinear::new(&[[-1.0, -3.0], [0.0, 0.0], [2.0, 1.0]], 0.0);
        let at = [-2.0, -1.0, -0.5, 0.0, 1.0, 2.0, 4.0].map(|x| line.value(x));
        assert_eq!(at, [-6.0, -3.0, -1.5, 0.0, 0.5, 1.0, 2.0]);
        assert_eq!([-2.0, -0.5, 0.0, 4.0].map(|x| line.slope(x)), [3.0, 3.0, 0.5, 0.5]);
        assert_eq!((line.steepest(), PiecewiseLinear::new(&[], 7.0).value(-2.0)), (3.0, -14.0));
    }

    #[test]
    fn values_are_first_reached_next_to_zero() {
        let line = PiecewiseLinear::new(
            &[[-3.0, -2.0], [-2.0, -2.0], [0.0, 0.0], [2.0, 1.0], [3.0, 1.0], [4.0, 2.0]],
            0.0,
        );
        let at = [-3.0, -2.0, -1.0, 0.0, 0.5, 1.0, 1.5, 3.0].map(|y| line.first_at(y));
        assert_eq!(at, [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.5, 5.0]);
        let rising = PiecewiseLinear::new(&[[-1.0, -3.0], [0.0, 0.0], [2.0, 1.0]], 0.0);
        assert_eq!([-6.0, -1.5, 4.0].map(|y| rising.first_at(y)), [-2.0, -0.5, 8.0]);
        assert_eq!([-6.0, -1.5, 4.0].map(|y| rising.inverse().value(y)), [-2.0, -0.5, 8.0]);
    }
}
