//! Factors over time: linear between points, constant outside, with exact integrals from time 0.

/// A piecewise linear factor.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Time [time] and factor, in ascending time.
    points: Vec<[f64; 2]>,
    /// First and second integral from the first point to each point [time], [time^2].
    integrals: Vec<[f64; 2]>,
}

impl Curve {
    /// Creates a curve through points `[time, factor]`: at least one, in ascending time.
    pub fn new(points: &[[f64; 2]]) -> Self {
        let mut integrals = vec![[0.0; 2]];
        for pair in points.windows(2) {
            let [[t0, y0], [t1, y1]] = [pair[0], pair[1]];
            let (h, last) = (t1 - t0, integrals[integrals.len() - 1]);
            integrals.push(beyond(last, y0, (y1 - y0) / h, h));
        }
        Self { points: points.to_vec(), integrals }
    }

    /// Returns the curve that is 1 at all times.
    pub fn one() -> Self {
        Self::new(&[[0.0, 1.0]])
    }

    /// Returns the factor at `time` [time].
    pub fn value(&self, time: f64) -> f64 {
        let (i, slope) = self.piece(time);
        match i {
            Some(i) => self.points[i][1] + slope * (time - self.points[i][0]),
            None => self.points[0][1],
        }
    }

    /// Returns the slope at `time`, that after it at a point [1/time].
    pub fn slope(&self, time: f64) -> f64 {
        self.piece(time).1
    }

    /// Returns the integral of the factor from 0 to `time` [time].
    pub fn integral(&self, time: f64) -> f64 {
        self.since_first(time)[0] - self.since_first(0.0)[0]
    }

    /// Returns the integral of [`Curve::integral`] from 0 to `time` [time^2].
    pub fn second_integral(&self, time: f64) -> f64 {
        let [first, second] = self.since_first(0.0);
        self.since_first(time)[1] - second - first * time
    }

    /// Returns the last point at or before `time` and the slope after it.
    fn piece(&self, time: f64) -> (Option<usize>, f64) {
        let after = self.points.partition_point(|p| p[0] <= time);
        let slope = match (after.checked_sub(1), self.points.get(after)) {
            (Some(i), Some(next)) => (next[1] - self.points[i][1]) / (next[0] - self.points[i][0]),
            _ => 0.0,
        };
        (after.checked_sub(1), slope)
    }

    /// Returns the first and second integral from the first point to `time`.
    fn since_first(&self, time: f64) -> [f64; 2] {
        let (i, slope) = self.piece(time);
        let at = i.unwrap_or(0);
        beyond(self.integrals[at], self.points[at][1], slope, time - self.points[at][0])
    }
}

/// Returns the first and second integral at a time `h` after the point where they are `from`, on
/// a line that starts at `y`.
fn beyond(from: [f64; 2], y: f64, slope: f64, h: f64) -> [f64; 2] {
    let first = from[0] + h * (y + 0.5 * slope * h);
    [first, from[1] + h * (from[0] + h * (0.5 * y + slope * h / 6.0))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_linear_between_points_and_constant_outside() {
        let c = Curve::new(&[[1.0, 2.0], [3.0, 6.0], [4.0, 0.0]]);
        for (t, y) in
            [(-1.0, 2.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0), (3.5, 3.0), (4.0, 0.0), (9.0, 0.0)]
        {
            assert_eq!(c.value(t), y, "at {t}");
        }
        assert_eq!(Curve::one().value(7.0), 1.0);
    }

    /// References: by hand, 2 t up to 1, then the trapezoids; and a sum by the midpoint rule,
    /// whose error is h^2/24 times the curvature.
    #[test]
    fn integrals_start_at_time_0_wherever_the_points_are() {
        for shift in [0.0, -1.5, 0.7] {
            let c = Curve::new(&[[1.0 + shift, 2.0], [3.0 + shift, 6.0], [4.0 + shift, 0.0]]);
            let (h, mut first, mut second) = (1e-4, 0.0, 0.0);
            for i in 0..50_000 {
                let y = c.value((i as f64 + 0.5) * h);
                second += h * (first + 0.5 * h * y);
                first += h * y;
            }
            assert!((c.integral(5.0) - first).abs() < 1e-6, "{} {first}", c.integral(5.0));
            assert!(
                (c.second_integral(5.0) - second).abs() < 1e-6,
                "{} {second}",
                c.second_integral(5.0)
            );
            assert_eq!([c.integral(0.0), c.second_integral(0.0)], [0.0; 2]);
        }
        let c = Curve::new(&[[1.0, 2.0], [3.0, 6.0], [4.0, 0.0]]);
        assert_eq!(
            [c.integral(1.0), c.integral(3.0), c.integral(4.0), c.integral(6.0)],
            [2.0, 10.0, 13.0, 13.0]
        );
    }
}
