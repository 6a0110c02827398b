//! The curve of a uniaxial test and its sum f (see [`tabulated`](super::tabulated)).

use crate::materials::polyline::AnchoredCurve;
use crumple_math::lanes::Real;

/// Terms of the sum. Their number is even: the argument of the rest has the sign of the strain.
const TERMS: usize = 8;
/// Stretches at which the check of a curve looks at the slope of f.
const CHECKS: usize = 1000;
/// Abscissas nearer than this, over their size, are one: a slope between them would be rounding.
const SAME: f64 = 1e-9;

/// Arguments of the sum at a strain, the same for all curves.
pub(super) struct CurveTerms<R> {
    /// Abscissas q of the terms, and their slopes over ln lambda of the term.
    places: [[R; 2]; TERMS],
    strain: R,
    /// ln lambda.
    logarithm: R,
}

impl<R: Real> CurveTerms<R> {
    /// Computes them for the lateral stretch `lambda^-power`.
    #[inline(always)]
    pub(super) fn new(power: f64, strain: R) -> Self {
        let one = R::splat(1.0);
        let logarithm = (one + strain).ln();
        let mut places = [neo_hookean(one + strain); TERMS];
        let mut share = 1.0;
        for place in &mut places[1..] {
            share *= -power;
            let term = (R::splat(share) * logarithm).exp() - one;
            *place = neo_hookean(one + term);
        }
        Self { places, strain, logarithm }
    }
}

/// The curve of a test and its sum f, or what one test has above another.
#[derive(Clone)]
pub(super) struct TestCurve {
    /// g over q.
    curve: AnchoredCurve,
    /// Abscissas q of the points.
    bends: Vec<f64>,
    /// Strains of the first and of the last point.
    ends: [f64; 2],
    /// p.
    power: f64,
    /// Slope of f over ln lambda at zero, in compression and in tension [force/length^2].
    at_zero: [f64; 2],
}

/// Returns `lambda^2 - 1/lambda`, the curve of a neo-Hookean rubber, and its slope over ln lambda.
#[inline(always)]
fn neo_hookean<R: Real>(stretch: R) -> [R; 2] {
    let per = R::splat(1.0) / stretch;
    let squared = stretch * stretch;
    [squared - per, squared + squared + per]
}

impl TestCurve {
    /// Creates the curve from at least two ascending points, one of them [0, 0].
    pub(super) fn new(points: &[[f64; 2]], power: f64) -> Self {
        let over_q = |&[strain, stress]: &[f64; 2]| {
            let stretch = 1.0 + strain;
            [neo_hookean(stretch)[0], stretch * stress]
        };
        let ends = [points[0][0], points[points.len() - 1][0]];
        Self::through(&points.iter().map(over_q).collect::<Vec<_>>(), ends, power)
    }

    /// Creates it from points of g over q.
    fn through(curve: &[[f64; 2]], ends: [f64; 2], power: f64) -> Self {
        // The slope of q over ln lambda is 3 at zero. A side without points has that of the other.
        let slopes: Vec<_> = curve
            .windows(2)
            .map(|two| 3.0 * (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]))
            .collect();
        let zero = curve.iter().filter(|point| point[0] < 0.0).count();
        let [down, up] = [zero.saturating_sub(1), zero.min(slopes.len() - 1)].map(|k| slopes[k]);
        let at_zero = [down - power * up, up - power * down].map(|s| s / (1.0 - power * power));
        Self {
            curve: AnchoredCurve::new(curve.iter().copied()),
            bends: curve.iter().map(|point| point[0]).collect(),
            ends,
            power,
            at_zero,
        }
    }

    /// Returns the points [q, g] of this curve less another one of the same power, at all points of
    /// both, with g of the other one.
    fn less(&self, other: &Self) -> Vec<[f64; 3]> {
        let mut bends = [&self.bends[..], &other.bends].concat();
        bends.sort_by(f64::total_cmp);
        let is_same = |next: f64, last: f64| {
            let is_near = next - last < SAME * (1.0 + last.abs());
            next == last || is_near && next != 0.0
        };
        bends.dedup_by(|next, last| is_same(*next, *last));
        let point = |q: f64| {
            let [own, below] = [self, other].map(|test| test.curve.at(q)[0]);
            [q, own - below, below]
        };
        bends.into_iter().map(point).collect()
    }

    /// Returns what this curve has above another one of the same power.
    pub(super) fn above(&self, other: &Self) -> Self {
        let points: Vec<[f64; 2]> = self.less(other).iter().map(|p| [p[0], p[1]]).collect();
        let ends = [self.ends[0].min(other.ends[0]), self.ends[1].max(other.ends[1])];
        Self::through(&points, ends, self.power)
    }

    /// Returns the stretch of a point, from the first to the last of both curves, at which the size
    /// of the stress is below that of another curve.
    pub(super) fn falls_below(&self, other: &Self) -> Option<f64> {
        let is_below = |&&[q, above, size]: &&[f64; 3]| above * q.signum() < -SAME * size.abs();
        self.less(other).iter().find(is_below).map(|&[q, ..]| stretch_at(q))
    }

    /// Returns the larger slope of f over ln lambda at zero, 2 G [force/length^2].
    pub(super) fn stiffness(&self) -> f64 {
        self.at_zero[0].max(self.at_zero[1])
    }

    /// Returns f and its slope over ln lambda at the arguments of a strain.
    #[inline(always)]
    pub(super) fn sum_of<R: Real>(&self, terms: &CurveTerms<R>) -> [R; 2] {
        let term = |[q, over]: [R; 2]| {
            let [value, slope] = self.curve.at(q);
            [value, slope * over]
        };
        let [mut value, mut slope] = term(terms.places[0]);
        let mut share = 1.0;
        for place in &terms.places[1..] {
            share *= -self.power;
            let [g, over] = term(*place);
            value += g;
            slope = R::splat(share).mul_add(over, slope);
        }
        let [below, above] = self.at_zero.map(R::splat);
        let is_pulled = terms.strain.ge(R::zero());
        let rest = R::splat(-self.power * share) * R::select(is_pulled, above, below);
        [rest.mul_add(terms.logarithm, value), slope + rest]
    }

    /// Returns f and its slope over ln lambda at a nominal strain.
    #[inline(always)]
    pub(super) fn sum<R: Real>(&self, strain: R) -> [R; 2] {
        self.sum_of(&CurveTerms::new(self.power, strain))
    }

    /// Returns a strain of the curve at which f does not grow.
    pub(super) fn falls(&self) -> Option<f64> {
        let [first, last] = self.ends;
        let step = (last - first) / CHECKS as f64;
        (0..=CHECKS).map(|k| first + step * k as f64).find(|&strain| self.sum(strain)[1] <= 0.0)
    }
}

/// Returns the stretch at an abscissa q, by bisection: q grows with the stretch.
fn stretch_at(q: f64) -> f64 {
    let (mut low, mut high) = (0.0, 2.0 + q.abs());
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if neo_hookean(middle)[0] < q { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
