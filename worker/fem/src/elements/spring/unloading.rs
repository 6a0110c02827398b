//! Springs that unload from their loading curve `f_l` by a rule of their own. Tension and
//! compression are independent, and both curves pass through the origin.
//!
//! Between two curves: with the unloading curve `|f_u| <= |f_l|` and lines of the slope K,
//! ```text
//! F <- F + K ds,   limited to the range from f_u(s) to f_l(s)
//! ```
//! Beyond the points of both, `f_u` is not larger than `f_l` either.
//! K is at least the slope of both curves, so that a step of any size is exact as long as the
//! elongation keeps its direction. A spring that passes the origin begins again with F = 0. A
//! loop takes the area between the curves.
//!
//! Permanent set: with the largest elongation a so far and `d = q a`,
//! ```text
//! s >= a:   a <- s,   F = f_l(s)
//! s < a:    F = f_l(a) ((s - d)/(a - d))^2,   0 below d
//! ```
//! which gives back `f_l(a) (a - d)/3`; a curve with a smaller area up to a is refused. The slope
//! just below a is `2 f_l(a)/(a (1 - q))`. In steps that go from loading to unloading a mode grows
//! from 0.95 of the step of this slope on (measured), so that the step has its sum with the slope
//! of the loading curve.

use super::plastic::loading_fault;
use super::{AddSpringProblem, SpringLaw, number, points};
use crate::piecewise_linear::PiecewiseLinear;
use crumple_proto::job::{BetweenCurvesSpring, PermanentSetSpring};

/// Slack of comparisons of curves, for round-off.
const SLACK: f64 = 1.0 + 1e-9;

/// Returns a loading curve, or reports what is wrong.
fn loading_curve(
    key: &str,
    given: &[[f64; 2]],
    say: &mut AddSpringProblem<'_>,
) -> Option<PiecewiseLinear> {
    if !points(key, given, say) {
        return None;
    }
    let line = PiecewiseLinear::new(given, 0.0);
    if let Some(fault) = loading_fault(&line) {
        let name = key.rsplit('.').next().unwrap_or(key);
        let help = "give forces that are 0 at 0 and have the sign of the displacement, not all 0";
        say(key, format!("{name} {fault}"), help);
        return None;
    }
    Some(line)
}

/// Returns the force of a loading curve: one that falls ends at zero.
fn loaded(line: &PiecewiseLinear, way: f64) -> f64 {
    if way >= 0.0 { line.value(way).max(0.0) } else { line.value(way).min(0.0) }
}

/// A spring with a force between two curves.
pub struct BetweenCurves {
    loading: PiecewiseLinear,
    unloading: PiecewiseLinear,
    stiffness: f64,
}

/// Columns: elongation [length] and force [force] at the last step.
const WAY: usize = 0;
const FORCE: usize = 1;

impl BetweenCurves {
    /// Builds the law, or reports what is wrong.
    pub fn new(input: &BetweenCurvesSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let key = |name: &str| format!("between_curves.{name}");
        let stiffness = input.stiffness;
        let is_sound = number(&key("stiffness"), stiffness, "above 0", |k| k > 0.0, say);
        let loading = loading_curve(&key("loading"), &input.loading, say);
        let unloading = loading_curve(&key("unloading"), &input.unloading, say);
        let (loading, unloading) = (loading?, unloading?);
        if !is_sound {
            return None;
        }
        if unloading.slopes().any(|slope| slope < 0.0) {
            let help = "give ascending forces";
            say(&key("unloading"), "unloading descends".into(), help);
            return None;
        }
        let steepest = loading.slopes().chain(unloading.slopes()).fold(0.0, f64::max);
        if steepest > stiffness * SLACK {
            let what = format!("stiffness is {stiffness:?}, a curve has the slope {steepest:?}");
            say(&key("stiffness"), what, "give at least the largest slope of both curves");
            return None;
        }
        // Both are straight between these places.
        let mut places = loading.points().iter().chain(unloading.points()).map(|p| p[0]);
        let above = |&x: &f64| unloading.value(x).abs() > loaded(&loading, x).abs() * SLACK;
        if let Some(at) = places.find(above) {
            let what = format!("unloading has a larger force than loading at {at:?}");
            say(&key("unloading"), what, "give smaller forces");
            return None;
        }
        Some(Self { loading, unloading, stiffness })
    }
}

impl SpringLaw for BetweenCurves {
    fn names(&self) -> &'static [&'static str] {
        &["displacement", "force"]
    }

    fn force(&self, state: &mut [f64], way: f64, _: f64) -> f64 {
        let (mut before, mut force) = (state[WAY], state[FORCE]);
        if before * way <= 0.0 {
            (before, force) = (0.0, 0.0);
        }
        let outer = loaded(&self.loading, way);
        let inner = self.unloading.value(way).abs().min(outer.abs()).copysign(outer);
        let line = force + self.stiffness * (way - before);
        let force = line.max(inner.min(outer)).min(inner.max(outer));
        (state[WAY], state[FORCE]) = (way, force);
        force
    }

    fn steepest(&self) -> f64 {
        self.loading.steepest().max(self.stiffness)
    }
}

/// A spring that unloads to a permanent displacement.
pub struct PermanentSet {
    loading: PiecewiseLinear,
    fraction: f64,
}

/// Columns: the largest and the smallest elongation so far [length].
const TENSION: usize = 0;
const COMPRESSION: usize = 1;

impl PermanentSet {
    /// Builds the law, or reports what is wrong.
    pub fn new(input: &PermanentSetSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let fraction = input.fraction;
        let fits = |q: f64| (0.0..1.0).contains(&q);
        let is_sound = number("permanent_set.fraction", fraction, "from 0 to below 1", fits, say);
        let loading = loading_curve("permanent_set.loading", &input.loading, say)?;
        if !is_sound {
            return None;
        }
        for side in [1.0, -1.0] {
            if let Some(at) = gain(&loading, side, fraction) {
                let what =
                    format!("loading takes less work up to {at:?} than unloading gives back");
                let help = "give a curve that steepens less, or a larger fraction";
                say("permanent_set.loading", what, help);
                return None;
            }
        }
        Some(Self { loading, fraction })
    }
}

/// Returns an elongation on a side of the loading curve up to which the spring has taken less work
/// than it gives back, if there is one.
fn gain(loading: &PiecewiseLinear, side: f64, fraction: f64) -> Option<f64> {
    let inner = loading.points().iter().map(|p| side * p[0]).filter(|&x| x > 0.0);
    let mut places: Vec<f64> = std::iter::once(0.0).chain(inner).collect();
    places.sort_by(f64::total_cmp);
    places.push(4.0 * places[places.len() - 1] + 1.0);
    let mut taken = 0.0;
    for ends in places.windows(2) {
        let [x, end] = [ends[0], ends[1]];
        let force = side * loading.value(side * x);
        let slope = (side * loading.value(side * end) - force) / (end - x);
        // Work taken and given back, up to x + h in the piece: a parabola in h.
        let back = (1.0 - fraction) / 3.0;
        let left =
            |h: f64| taken + h * (force + 0.5 * slope * h) - back * (x + h) * (force + slope * h);
        let curvature = slope * (1.0 - 2.0 * back);
        let vertex = -(force - back * (force + slope * x)) / curvature;
        let slack = 1e-9 * (taken + (end - x) * (force + 0.5 * slope * (end - x)).abs());
        let middle = Some(vertex).filter(|h| (0.0..=end - x).contains(h));
        let worst = [Some(end - x), middle].into_iter().flatten();
        if let Some(h) = worst.into_iter().find(|&h| left(h) < -slack && force + slope * h >= 0.0) {
            return Some(side * (x + h));
        }
        taken += (end - x) * (force + 0.5 * slope * (end - x));
    }
    None
}

impl SpringLaw for PermanentSet {
    fn names(&self) -> &'static [&'static str] {
        &["reached in tension", "reached in compression"]
    }

    fn force(&self, state: &mut [f64], way: f64, _: f64) -> f64 {
        let column = if way >= 0.0 { TENSION } else { COMPRESSION };
        if way.abs() >= state[column].abs() {
            state[column] = way;
            return loaded(&self.loading, way);
        }
        let reached = state[column];
        let set = self.fraction * reached;
        let part = ((way - set) / (reached - set)).max(0.0);
        loaded(&self.loading, reached) * part * part
    }

    fn steepest(&self) -> f64 {
        let secants = self.loading.points().iter().filter(|p| p[0] != 0.0).map(|p| p[1] / p[0]);
        let ends = [f64::NEG_INFINITY, -f64::MIN_POSITIVE, 0.0, f64::INFINITY];
        let slopes = ends.map(|x| self.loading.slope(x));
        let secant = secants.chain(slopes).fold(0.0, f64::max);
        self.loading.steepest() + 2.0 * secant / (1.0 - self.fraction)
    }
}
