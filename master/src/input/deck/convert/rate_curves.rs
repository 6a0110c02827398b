//! Hardening curves by strain rate, one for each rate. A curve is known up to its last point and
//! continues with its last slope. Beyond their last points, the curve of a smaller rate may not be
//! above that of a larger one: the stress would fall as the rate grows. What is given stays as it
//! is, and the law checks it.

use super::DeckConverter;
use super::materials::hardening_curve;
use crate::input::deck::BEYOND_ALL_STRAINS;

/// RatePoints [plastic strain, stress].
type RatePoints = Vec<[f64; 2]>;

/// A curve that continues beyond its last given point.
#[derive(Clone, Debug, PartialEq)]
struct RateCurve {
    points: RatePoints,
    /// Last plastic strain that is given.
    end: f64,
}

impl DeckConverter {
    /// Returns the rows [rate, plastic strain, stress] of curves in ascending order of their rates;
    /// `of` names the material.
    pub(super) fn rate_rows(&mut self, of: &str, curves: Vec<(f64, RatePoints)>) -> Vec<Vec<f64>> {
        let (rates, given): (Vec<f64>, Vec<RatePoints>) = curves.into_iter().unzip();
        let (continued, has_changed) = continued(given);
        if has_changed {
            let asked = "curves by the strain rate that cross beyond their last points";
            let used = "there the curve of a smaller rate is not above that of a larger one";
            self.map(of, asked, used);
        }
        let rows = rates.into_iter().zip(continued);
        rows.flat_map(|(rate, points)| points.into_iter().map(move |p| vec![rate, p[0], p[1]]))
            .collect()
    }
}

/// Continues curves beyond their last points. Returns true if one of them does not simply go on
/// with its last slope.
fn continued(given: Vec<RatePoints>) -> (Vec<RatePoints>, bool) {
    let curve = |points: RatePoints| {
        let end = points.last().map_or(0.0, |last| last[0]);
        RateCurve { points: hardening_curve(points), end }
    };
    let first: Vec<RateCurve> = given.into_iter().map(curve).collect();
    let mut curves = first.clone();
    if curves.iter().any(|curve| !ascends(&curve.points)) {
        // The law reports it.
        return (curves.into_iter().map(|curve| curve.points).collect(), false);
    }
    // From the largest rate down: not above what is given of the curve of the next rate.
    for k in (0..curves.len().saturating_sub(1)).rev() {
        let above = curves[k + 1].clone();
        curves[k].bound(&above, f64::min);
    }
    // And up: not below the curve of the rate before it.
    for k in 1..curves.len() {
        let below = curves[k - 1].clone();
        curves[k].bound(&below, f64::max);
    }
    let has_changed = curves != first;
    (curves.into_iter().map(|curve| curve.points).collect(), has_changed)
}

impl RateCurve {
    /// Bounds the curve beyond its last given point by another one; it never falls.
    fn bound(&mut self, other: &RateCurve, choose: fn(f64, f64) -> f64) {
        let least = at(&self.points, self.end);
        let strains = self.strains_beyond(other);
        let chosen = |x: f64| choose(at(&self.points, x), at(&other.points, x)).max(least);
        if strains.iter().all(|&x| chosen(x) == at(&self.points, x)) {
            return;
        }
        let mut points = self.points.clone();
        points.retain(|p| p[0] <= self.end);
        points.extend(strains.iter().map(|&x| [x, chosen(x)]));
        self.points = points;
    }

    /// Returns the strains beyond the last given point where the slope of a choice between this
    /// curve and another one, or the last given stress, may change.
    fn strains_beyond(&self, other: &RateCurve) -> Vec<f64> {
        let level = [[0.0, at(&self.points, self.end)]];
        let mut all: Vec<f64> = self.points.iter().chain(&other.points).map(|p| p[0]).collect();
        all.extend([self.end, BEYOND_ALL_STRAINS]);
        all.retain(|&x| x >= self.end);
        for lines in [&self.points[..], &level[..]] {
            all.sort_by(f64::total_cmp);
            let gap = |x: f64| at(&other.points, x) - at(lines, x);
            let crossings: Vec<f64> = all
                .windows(2)
                .filter(|two| gap(two[0]) * gap(two[1]) < 0.0)
                .map(|two| {
                    let [low, high] = [gap(two[0]), gap(two[1])];
                    two[0] + (two[1] - two[0]) * low / (low - high)
                })
                .collect();
            all.extend(crossings);
        }
        all.sort_by(f64::total_cmp);
        all.dedup();
        all.retain(|&x| x > self.end);
        all
    }
}

/// Returns true if the strains ascend from row to row.
fn ascends(points: &[[f64; 2]]) -> bool {
    !points.is_empty() && points.windows(2).all(|two| two[0][0] < two[1][0])
}

/// Returns the stress at a strain; constant outside of the points.
fn at(points: &[[f64; 2]], x: f64) -> f64 {
    let next = points.partition_point(|p| p[0] < x);
    match (next.checked_sub(1).map(|k| points[k]), points.get(next)) {
        (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some([_, y]), None) | (None, Some(&[_, y])) => y,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest amount by which the curve of a rate is below the one before it.
    fn worst(curves: &[RatePoints]) -> f64 {
        let strains: Vec<f64> = (0..=1000).map(|k| f64::from(k) * 0.01).collect();
        let fall = |two: &[RatePoints], x: f64| at(&two[0], x) - at(&two[1], x);
        let falls = curves.windows(2).flat_map(|two| strains.iter().map(move |&x| fall(two, x)));
        falls.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Curves that do not cross keep their last slopes.
    #[test]
    fn curves_that_do_not_cross_go_on() {
        let given = vec![vec![[0.0, 1.0], [0.5, 1.2]], vec![[0.0, 1.5], [0.4, 1.9]]];
        let (found, has_changed) = continued(given);
        assert!(!has_changed);
        assert!((at(&found[0], 10.0) - 5.0).abs() < 1e-12, "{found:?}");
        assert!((at(&found[1], 10.0) - 11.5).abs() < 1e-12, "{found:?}");
    }

    /// Given points stay; beyond them the stress does not fall as the rate grows, and no curve
    /// falls: with a steep curve of a small rate, a short one of a small rate, a short one of a
    /// large rate, and three of them.
    #[test]
    fn continuations_do_not_cross() {
        let steep = vec![[0.0, 1.0], [0.5, 2.0], [1.0, 3.0]];
        let flat = vec![[0.0, 2.0], [0.5, 3.0], [1.0, 3.1]];
        let short = vec![[0.0, 1.0], [0.1, 1.9]];
        let high = vec![[0.0, 3.5], [0.05, 3.5]];
        for given in [
            vec![steep.clone(), flat.clone()],
            vec![short.clone(), flat.clone()],
            vec![flat.clone(), high.clone()],
            vec![short.clone(), flat.clone(), high.clone()],
            vec![steep, flat, high],
        ] {
            let (found, has_changed) = continued(given.clone());
            assert!(has_changed, "{given:?}");
            assert!(worst(&found) <= 1e-12, "{given:?}: {found:?}");
            for (curve, given) in found.iter().zip(&given) {
                assert_eq!(&curve[..given.len()], &given[..], "what is given");
                assert!(curve.windows(2).all(|two| two[0][0] < two[1][0]), "{curve:?}");
                assert!(curve.windows(2).all(|two| two[0][1] <= two[1][1]), "{curve:?}");
            }
        }
    }

    /// Curves that cross where they are given stay as they are.
    #[test]
    fn curves_that_cross_are_left_to_the_law() {
        let given = vec![vec![[0.0, 1.0], [1.0, 2.0]], vec![[0.0, 1.5], [1.0, 1.6]]];
        let (found, _) = continued(given.clone());
        assert!(found.iter().zip(&given).all(|(f, g)| f[..2] == g[..]), "{found:?}");
        assert!(worst(&found) > 0.3);
    }
}
