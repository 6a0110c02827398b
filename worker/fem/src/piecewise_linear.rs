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
}
