//! Curves of straight lines between points, as sums of ramps. Such a sum needs no search, so that
//! no lane waits for another.

use crumple_math::lanes::Real;

/// Course of a curve beyond its last point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// It keeps the last value.
    Constant,
    /// It keeps the last slope.
    Straight,
}

/// A curve; constant before its first point.
#[derive(Clone, Debug, PartialEq)]
pub struct RampCurve {
    /// Ordinate of the first point.
    first: f64,
    /// Abscissas at which the slope changes, and the change.
    ramps: Vec<(f64, f64)>,
}

impl RampCurve {
    /// Creates a curve from points with ascending abscissas; ordinates are multiplied by `scale`.
    pub fn new(points: &[[f64; 2]], scale: f64, beyond: Beyond) -> Self {
        let mut ramps = Vec::with_capacity(points.len());
        let mut slope = 0.0;
        for two in points.windows(2) {
            let next = scale * (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]);
            ramps.push((two[0][0], next - slope));
            slope = next;
        }
        if let (Some(last), Beyond::Constant) = (points.last(), beyond) {
            ramps.push((last[0], -slope));
        }
        Self { first: points.first().map_or(0.0, |p| scale * p[1]), ramps }
    }

    /// Returns the ordinate and the slope at an abscissa; at a point, the slope after it.
    #[inline(always)]
    pub fn at<R: Real>(&self, x: R) -> [R; 2] {
        let (mut value, mut slope) = (R::splat(self.first), R::zero());
        for &(start, change) in &self.ramps {
            let beyond = x - R::splat(start);
            let change = R::select(beyond.ge(R::zero()), R::splat(change), R::zero());
            value = change.mul_add(beyond, value);
            slope += change;
        }
        [value, slope]
    }

    /// Returns the integral from zero to an abscissa above zero.
    #[inline(always)]
    pub fn area<R: Real>(&self, x: R) -> R {
        let mut area = R::splat(self.first) * x;
        for &(start, change) in &self.ramps {
            let beyond = Real::max(x - R::splat(start), R::zero());
            area = R::splat(0.5 * change).mul_add(beyond * beyond, area);
        }
        area
    }
}

/// A curve through its points, which goes on beyond both ends. At zero it has its value there to
/// the last bit: it is that value, a slope, and changes of the slope on either side.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchoredCurve {
    at_zero: f64,
    /// Slope just below zero.
    slope: f64,
    /// Abscissas from zero on at which the slope changes, and the change.
    above: Vec<(f64, f64)>,
    /// The same below zero: the slope before the point less that after it.
    below: Vec<(f64, f64)>,
}

impl AnchoredCurve {
    /// Creates a curve from two points or more with ascending abscissas.
    ///
    /// # Panics
    /// With fewer points.
    pub fn new(points: impl Iterator<Item = [f64; 2]>) -> Self {
        let points: Vec<[f64; 2]> = points.collect();
        let slopes: Vec<f64> = points
            .windows(2)
            .map(|two| (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]))
            .collect();
        let inner = &points[1..points.len() - 1];
        let first = inner.partition_point(|point| point[0] < 0.0);
        let slope = slopes[first];
        let on_zero = points.iter().find(|point| point[0] == 0.0);
        let through = |[x, y]: [f64; 2]| y - slope * x;
        let at_zero = on_zero.map_or_else(|| through(points[first]), |point| point[1]);
        let change = |k: usize| slopes[k + 1] - slopes[k];
        Self {
            at_zero,
            slope,
            above: (first..inner.len()).map(|k| (inner[k][0], change(k))).collect(),
            below: (0..first).map(|k| (inner[k][0], -change(k))).collect(),
        }
    }

    /// Returns the ordinate at zero.
    pub fn at_zero(&self) -> f64 {
        self.at_zero
    }

    /// Returns the curve with the ordinate zero at zero, shifted.
    pub fn through_zero(self) -> Self {
        Self { at_zero: 0.0, ..self }
    }

    /// Returns the larger of the slopes on the two sides of zero.
    pub fn steepest_at_zero(&self) -> f64 {
        let kink = self.above.iter().find(|(x, _)| *x == 0.0);
        self.slope + kink.map_or(0.0, |(_, change)| change.max(0.0))
    }

    /// Returns the ordinate and the slope at an abscissa; at a point, the slope after it.
    #[inline(always)]
    pub fn at<R: Real>(&self, x: R) -> [R; 2] {
        let (zero, mut slope) = (R::zero(), R::splat(self.slope));
        let mut value = slope.mul_add(x, R::splat(self.at_zero));
        for (side, above) in [(&self.above, true), (&self.below, false)] {
            for &(start, change) in side {
                let beyond = x - R::splat(start);
                let counts = if above { beyond.ge(zero) } else { beyond.lt(zero) };
                let change = R::select(counts, R::splat(change), zero);
                value = change.mul_add(beyond, value);
                slope += change;
            }
        }
        [value, slope]
    }
}

/// Curves at ascending values, linear between them; constant outside the values.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveFamily {
    values: Vec<f64>,
    curves: Vec<RampCurve>,
}

impl CurveFamily {
    /// Creates curves from rows [value, abscissa, ordinate], ordered by value and abscissa.
    pub fn new(rows: &[[f64; 3]], scale: f64, beyond: Beyond) -> Self {
        let groups = rows.chunk_by(|a, b| a[0] == b[0]);
        let curve = |rows: &[[f64; 3]]| {
            let points: Vec<[f64; 2]> = rows.iter().map(|row| [row[1], row[2]]).collect();
            RampCurve::new(&points, scale, beyond)
        };
        let (values, curves) = groups.map(|rows| (rows[0][0], curve(rows))).unzip();
        Self { values, curves }
    }

    /// Returns the first value, and an abscissa, at which a curve lies below that of the value
    /// before it, from the abscissa 0 to `last`.
    pub fn crossing(&self, last: f64) -> Option<[f64; 2]> {
        self.curves.windows(2).zip(&self.values[1..]).find_map(|(two, &value)| {
            let bends = two.iter().flat_map(|curve| curve.ramps.iter().map(|&(start, _)| start));
            let mut places = bends.chain([0.0, last]).filter(|&x| x <= last);
            let falls = |&x: &f64| {
                let [low, high] = [two[0].at(x)[0], two[1].at(x)[0]];
                high < low - 1e-9 * low.abs()
            };
            places.find(falls).map(|x| [value, x])
        })
    }

    /// Returns the curve of the smallest value.
    pub fn lowest(&self) -> &RampCurve {
        &self.curves[0]
    }

    /// Returns the ordinate, its slope over the abscissa, and its slope over the value.
    #[inline(always)]
    pub fn at<R: Real>(&self, value: R, x: R) -> [R; 3] {
        let [mut below, mut slope] = self.curves[0].at(x);
        let (mut sum, mut over) = (below, R::zero());
        let mut below_slope = slope;
        for (two, curve) in self.values.windows(2).zip(&self.curves[1..]) {
            let per = R::splat(1.0 / (two[1] - two[0]));
            let share = (value - R::splat(two[0])) * per;
            let inside = R::both(share.ge(R::zero()), share.lt(R::splat(1.0)));
            let share = Real::min(Real::max(share, R::zero()), R::splat(1.0));
            let [above, above_slope] = curve.at(x);
            sum = share.mul_add(above - below, sum);
            slope = share.mul_add(above_slope - below_slope, slope);
            over = R::select(inside, (above - below) * per, over);
            (below, below_slope) = (above, above_slope);
        }
        [sum, slope, over]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve of three points and its integral, in units of round-off.
    #[test]
    fn a_curve_goes_through_its_points_and_has_its_area() {
        let points = [[0.5, 2.0], [1.0, 3.0], [2.0, 1.0]];
        let constant = RampCurve::new(&points, 2.0, Beyond::Constant);
        let straight = RampCurve::new(&points, 2.0, Beyond::Straight);
        for (x, [value, slope]) in
            [(0.0, [4.0, 0.0]), (0.5, [4.0, 4.0]), (0.75, [5.0, 4.0]), (1.5, [4.0, -4.0])]
        {
            assert_eq!((constant.at(x), straight.at(x)), ([value, slope], [value, slope]), "{x}");
        }
        assert_eq!((constant.at(3.0), straight.at(3.0)), ([2.0, 0.0], [-2.0, -4.0]));
        let area = 0.5 * 4.0 + 0.5 * 5.0 + 1.0 * 4.0;
        assert!((constant.area(2.0) - area).abs() < 1e-14, "{}", constant.area(2.0));
    }

    /// Halfway between two values the ordinate is the mean; outside it is that of the last value.
    #[test]
    fn a_family_is_linear_between_its_values() {
        let rows = [[1.0, 0.0, 1.0], [1.0, 1.0, 2.0], [3.0, 0.0, 5.0], [3.0, 1.0, 10.0]];
        let family = CurveFamily::new(&rows, 1.0, Beyond::Straight);
        assert_eq!(family.at(2.0, 0.5), [(1.5 + 7.5) / 2.0, 3.0, 3.0]);
        assert_eq!(family.at(0.0, 0.5), [1.5, 1.0, 0.0]);
        assert_eq!(family.at(9.0, 0.5), [7.5, 5.0, 0.0]);
        assert_eq!(family.lowest().at(0.5), [1.5, 1.0]);
        assert_eq!(family.crossing(9.0), None);
        let rows = [[1.0, 0.0, 1.0], [1.0, 1.0, 2.0], [3.0, 0.0, 1.5], [3.0, 1.0, 2.1]];
        let family = CurveFamily::new(&rows, 1.0, Beyond::Straight);
        assert_eq!([family.crossing(1.2), family.crossing(2.0)], [None, Some([3.0, 2.0])]);
    }
}
