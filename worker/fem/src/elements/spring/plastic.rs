//! Springs with a plastic elongation: different curves for loading and unloading.
//!
//! With the loading curve `f_l` through the origin and the ascending unloading curve `f_u`, a
//! spring that has yielded has the force
//! ```text
//! F = f_u(s - d),   f_l(b) <= F <= f_l(a)
//! ```
//! with the shift d (its plastic elongation, up to the origin of `f_u`) and the abscissae
//! `b <= 0 <= a` of the loading curve that it has reached in compression and tension. Let
//! `s_a = d + f_u^-1(f_l(a))` be the elongation at which it yields in tension. Beyond it the force
//! follows the loading curve, shifted along the elongation:
//! ```text
//! s > s_a:   a <- a + s - s_a,   F = f_l(a),   d <- s - f_u^-1(F)
//! ```
//! and alike in compression. A spring that has not yielded follows `f_l` between the first values
//! of b and a, and yields at these elongations. All of it depends on the elongation only, so a step
//! of any size is exact. With isotropic hardening a yield force F makes b (or a) at least as large
//! as the abscissa where `f_l` reaches -F: for two slopes this is linear isotropic hardening (Simo
//! & Hughes 1998, sec. 1.2). A yield curve `F_y(p)` over the plastic elongation p, accumulated in
//! both directions, is the loading curve with the points `[p + F_y/k, F_y]` and straight unloading
//! of the slope k. A yield force moves b (or a) to the abscissa with the same p, so that the curve
//! may fall: `p = |a| - |f_l(a)|/k`.
//!
//! While it yields, `d` grows by `(1 - f_l'/f_u') ds`. The dissipated power `F dd/dt` is not
//! negative as long as `f_l' <= f_u'` at equal forces; other curves are refused.
//!
//! A force has at most the slope of the steepest piece of both curves.
//!
//! Left out: kinematic hardening; unloading curves that depend on where unloading begins.

use super::{AddSpringProblem, SpringLaw, number, points};
use crate::piecewise_linear::PiecewiseLinear;
use crumple_proto::job::{
    ElastoplasticSpring, HysteresisSpring, OneSidedSpring, SpringHardening, SpringSide,
    YieldingSpring,
};

/// Columns: 1 if it has yielded, else 0; d; a and b [length].
const YIELDED: usize = 0;
const SHIFT: usize = 1;
const TENSION: usize = 2;
const COMPRESSION: usize = 3;

/// Slope of the loading curve over that of the unloading curve, up to round-off.
const EQUAL_SLOPES: f64 = 1.0 + 1e-9;

/// Parameters of a spring with a plastic elongation.
pub struct Plastic {
    loading: PiecewiseLinear,
    unloading: PiecewiseLinear,
    /// Inverse of `unloading`.
    unloaded: PiecewiseLinear,
    /// First values of a and b [length].
    first: [f64; 2],
    coupling: SideCoupling,
    carries: Option<SpringSide>,
}

/// Effect of yielding in tension on compression, and the reverse.
enum SideCoupling {
    Independent,
    Isotropic,
    /// Both have the same plastic elongation: a and b over it.
    Accumulated([PiecewiseLinear; 2]),
}

impl Plastic {
    /// Builds bilinear plasticity, or reports what is wrong.
    pub fn elastoplastic(
        input: &ElastoplasticSpring,
        say: &mut AddSpringProblem<'_>,
    ) -> Option<Self> {
        let ElastoplasticSpring { stiffness, tangent_stiffness, yield_force } = *input;
        let mut sound = number("elastoplastic.stiffness", stiffness, "above 0", |k| k > 0.0, say);
        sound &= number("elastoplastic.yield_force", yield_force, "above 0", |f| f > 0.0, say);
        sound &= number(
            "elastoplastic.tangent_stiffness",
            tangent_stiffness,
            "0 or above, and below `stiffness`",
            |k| (0.0..stiffness).contains(&k),
            say,
        );
        if !sound {
            return None;
        }
        let at = yield_force / stiffness;
        let beyond = [2.0 * at, yield_force + tangent_stiffness * at];
        let loading = [beyond.map(|x| -x), [-at, -yield_force], [at, yield_force], beyond];
        let loading = PiecewiseLinear::new(&loading, 0.0);
        let unloading = PiecewiseLinear::new(&[], stiffness);
        let coupling = SideCoupling::Isotropic;
        Some(Self { first: [at, -at], coupling, ..Self::new(loading, unloading) })
    }

    /// Builds a spring with a yield force over plastic elongation, or reports what is wrong.
    pub fn yielding(input: &YieldingSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let YieldingSpring { stiffness, yield_force } = input;
        let (stiffness, key) = (*stiffness, "yielding.yield_force");
        let mut sound = number("yielding.stiffness", stiffness, "above 0", |k| k > 0.0, say);
        sound &= points(key, yield_force, say);
        if !sound {
            return None;
        }
        if yield_force[0][0] < 0.0 && yield_force[yield_force.len() - 1][0] <= 0.0 {
            let help = "give points above 0 too, or points from 0 on for both directions";
            say(key, "yield_force has points of compression only".into(), help);
            return None;
        }
        let sides = [1.0, -1.0].map(|side| side_of(yield_force, side));
        for side in &sides {
            if let Some([at, _]) = side.iter().find(|p| p[1] < 0.0) {
                let what = format!("yield_force has the wrong sign at {at:?}");
                say(key, what, "give forces with the sign of the plastic elongation");
                return None;
            }
            if side.iter().all(|p| p[1] == 0.0) {
                say(key, "yield_force is zero".into(), "give forces other than 0");
                return None;
            }
            if side.windows(2).any(|p| p[1][1] - p[0][1] <= -stiffness * (p[1][0] - p[0][0])) {
                let help = "give a curve that falls less steeply, or a larger stiffness";
                say(key, "yield_force falls as steeply as `stiffness`".into(), help);
                return None;
            }
        }
        let abscissae = [(0, 1.0), (1, -1.0)].map(|(k, sign): (usize, f64)| {
            let at = |&[p, force]: &[f64; 2]| [p, sign * (p + force / stiffness)];
            PiecewiseLinear::new(&sides[k].iter().map(at).collect::<Vec<_>>(), 0.0)
        });
        let on_curve = |k: usize, sign: f64| -> Vec<[f64; 2]> {
            let points = sides[k].iter().zip(abscissae[k].points());
            points.map(|(own, at)| [at[1], sign * own[1]]).collect()
        };
        let mut curve: Vec<[f64; 2]> = on_curve(1, -1.0).into_iter().rev().collect();
        curve.extend(on_curve(0, 1.0));
        curve.dedup_by(|next, last| next[0] == last[0]);
        let first = [abscissae[0].value(0.0), abscissae[1].value(0.0)];
        let unloading = PiecewiseLinear::new(&[], stiffness);
        let coupling = SideCoupling::Accumulated(abscissae);
        Some(Self { first, coupling, ..Self::new(PiecewiseLinear::new(&curve, 0.0), unloading) })
    }

    /// Returns the forces at which it yields first, in compression and in tension.
    pub fn first_yield(&self) -> [f64; 2] {
        [self.first[1], self.first[0]].map(|at| self.loading.value(at))
    }

    /// Builds a spring with two curves, or reports what is wrong.
    pub fn hysteresis(input: &HysteresisSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let HysteresisSpring { loading, unloading, hardening, yield_forces } = input;
        let mut sound = points("hysteresis.loading", loading, say);
        sound &= points("hysteresis.unloading", unloading, say);
        if !sound {
            return None;
        }
        let isotropic = *hardening == SpringHardening::Isotropic;
        let [loading, unloading] = [loading, unloading].map(|p| PiecewiseLinear::new(p, 0.0));
        let mut refuse = |key: &str, what: String, help: &str| {
            say(&format!("hysteresis.{key}"), what, help);
            sound = false;
        };
        if let Some(fault) = loading_fault(&loading) {
            refuse("loading", format!("loading {fault}"), "tension has forces of 0 or above");
        }
        if isotropic && loading.slopes().any(|slope| slope < 0.0) {
            refuse(
                "loading",
                "loading descends".into(),
                "use `hardening = \"independent\"`, or a curve that does not descend",
            );
        }
        if unloading.slopes().any(|slope| slope <= 0.0) {
            refuse("unloading", "unloading does not ascend".into(), "give ascending forces");
        } else if let Some(force) = softer_unloading(&loading, &unloading) {
            refuse(
                "unloading",
                format!("unloading is less steep than loading at the force {force}"),
                "it would give back more energy than it took: give a steeper unloading curve",
            );
        }
        let coupling = if isotropic { SideCoupling::Isotropic } else { SideCoupling::Independent };
        let mut spring = Self { coupling, ..Self::new(loading, unloading) };
        match yield_forces {
            Some(_) if !isotropic => refuse(
                "yield_forces",
                "yield_forces are for isotropic hardening only".into(),
                "remove them, or use `hardening = \"isotropic\"`",
            ),
            &Some([below, above]) => {
                spring.first = [above, below].map(|force| spring.loading.first_at(force));
                let reached = |force: f64, at: f64| {
                    (spring.loading.value(at) - force).abs() <= 1e-9 * force.abs()
                };
                if !(below <= 0.0 && above >= 0.0) {
                    let help = "give the force in compression (0 or below), then that in tension";
                    refuse("yield_forces", format!("yield_forces are {below}, {above}"), help);
                } else if ![(above, 0), (below, 1)]
                    .iter()
                    .all(|&(f, k)| reached(f, spring.first[k]))
                {
                    refuse(
                        "yield_forces",
                        format!("loading does not reach the yield_forces {below}, {above}"),
                        "give smaller forces, or more points of `loading`",
                    );
                }
            }
            None => {}
        }
        sound.then_some(spring)
    }

    /// Builds a spring for tension or compression only, or reports what is wrong.
    pub fn one_sided(input: &OneSidedSpring, say: &mut AddSpringProblem<'_>) -> Option<Self> {
        let OneSidedSpring { loading, unloading_stiffness, carries } = input;
        let mut sound = points("one_sided.loading", loading, say);
        sound &= number(
            "one_sided.unloading_stiffness",
            *unloading_stiffness,
            "0 or above",
            |k| k >= 0.0,
            say,
        );
        let key = "one_sided.loading";
        if sound && loading[0] != [0.0, 0.0] {
            let [x, y] = loading[0];
            say(key, format!("loading begins at [{x:?}, {y:?}]"), "begin with [0.0, 0.0]");
            sound = false;
        }
        if sound && loading.iter().any(|p| p[1] < 0.0) {
            say(key, "loading has negative forces".into(), "give positive forces");
            sound = false;
        }
        if sound && loading[1][1] == 0.0 && loading.iter().all(|p| p[1] == 0.0) {
            say(key, "its springs carry no force".into(), "give forces above 0");
            sound = false;
        }
        if !sound {
            return None;
        }
        let curve = match carries {
            SpringSide::Tension => loading.clone(),
            SpringSide::Compression => loading.iter().rev().map(|p| p.map(|x| -x)).collect(),
        };
        let loading = PiecewiseLinear::new(&curve, 0.0);
        let stiffness = loading.slopes().fold(*unloading_stiffness, f64::max);
        let unloading = PiecewiseLinear::new(&[], stiffness);
        Some(Self { carries: Some(*carries), ..Self::new(loading, unloading) })
    }

    fn new(loading: PiecewiseLinear, unloading: PiecewiseLinear) -> Self {
        let unloaded = unloading.inverse();
        let coupling = SideCoupling::Independent;
        Self { loading, unloading, unloaded, first: [0.0; 2], coupling, carries: None }
    }

    /// Returns the yield force in tension (a >= 0) or compression that belongs to an abscissa of
    /// the loading curve. A curve that falls ends at zero.
    fn yield_force(&self, at: f64, tension: bool) -> f64 {
        let force = self.loading.value(at);
        if tension { force.max(0.0) } else { force.min(0.0) }
    }
}

impl SpringLaw for Plastic {
    fn names(&self) -> &'static [&'static str] {
        &["yielded", "plastic elongation", "reached in tension", "reached in compression"]
    }

    fn force(&self, state: &mut [f64], way: f64, _: f64) -> f64 {
        let yielded = state[YIELDED] > 0.5;
        let [tension, compression] = match yielded {
            true => [state[TENSION], state[COMPRESSION]],
            false => self.first,
        };
        let shift = state[SHIFT];
        let yields_at = |reached: f64, tension: bool| match yielded {
            true => shift + self.unloaded.value(self.yield_force(reached, tension)),
            false => reached,
        };
        let beyond = match self.carries {
            Some(SpringSide::Compression) => 0.0,
            _ => (way - yields_at(tension, true)).max(0.0),
        };
        let below = match self.carries {
            Some(SpringSide::Tension) => 0.0,
            _ => (way - yields_at(compression, false)).min(0.0),
        };
        if beyond == 0.0 && below == 0.0 {
            let force = match yielded {
                true => self.unloading.value(way - shift),
                false => self.loading.value(way),
            };
            return match self.carries {
                Some(SpringSide::Tension) => force.max(0.0),
                Some(SpringSide::Compression) => force.min(0.0),
                None => force,
            };
        }
        let [mut tension, mut compression] = [tension + beyond, compression + below];
        let force = match beyond > 0.0 {
            true => self.yield_force(tension, true),
            false => self.yield_force(compression, false),
        };
        match &self.coupling {
            SideCoupling::Independent => {}
            SideCoupling::Isotropic if beyond > 0.0 => {
                compression = compression.min(self.loading.first_at(-force));
            }
            SideCoupling::Isotropic => tension = tension.max(self.loading.first_at(-force)),
            SideCoupling::Accumulated(abscissae) => {
                let unloaded = self.unloaded.value(force.abs());
                match beyond > 0.0 {
                    true => compression = abscissae[1].value(tension - unloaded),
                    false => tension = abscissae[0].value(-compression - unloaded),
                }
            }
        }
        state[YIELDED] = 1.0;
        state[SHIFT] = way - self.unloaded.value(force);
        (state[TENSION], state[COMPRESSION]) = (tension, compression);
        force
    }

    fn steepest(&self) -> f64 {
        self.loading.steepest().max(self.unloading.steepest())
    }
}

/// Returns a side (1 tension, -1 compression) of a curve of yield forces as points of positive
/// numbers from 0 on, without forces below zero at its end. A curve without negative plastic
/// elongations is the same on both sides. Where a curve changes its sign at 0 both sides begin at
/// or above zero.
fn side_of(curve: &[[f64; 2]], side: f64) -> Vec<[f64; 2]> {
    let sign = if curve[0][0] < 0.0 { side } else { 1.0 };
    let line = PiecewiseLinear::new(curve, 0.0);
    let own = curve.iter().filter(|p| sign * p[0] > 0.0).map(|p| p.map(|x| sign * x));
    let mut points: Vec<[f64; 2]> = own.collect();
    if sign < 0.0 {
        points.reverse();
    }
    let start = sign * line.value(0.0);
    points.insert(0, [0.0, if curve[0][0] < 0.0 { start.max(0.0) } else { start }]);
    let slope = line.slope(sign * f64::INFINITY);
    let [mut at, mut force] = points[points.len() - 1];
    if slope < 0.0 && force > 0.0 {
        (at, force) = (at - force / slope, 0.0);
        points.push([at, force]);
    }
    points.push([at + 1.0, force + slope.max(0.0)]);
    points
}

/// Returns the error in a loading curve, if any: it passes through the origin, and its forces have
/// the sign of the elongation.
pub(super) fn loading_fault(loading: &PiecewiseLinear) -> Option<String> {
    let largest = loading.points().iter().map(|p| p[1].abs()).fold(0.0, f64::max);
    let at_origin = loading.value(0.0);
    if at_origin.abs() > 1e-9 * largest {
        return Some(format!("has the force {at_origin} at 0, not 0"));
    }
    if largest == 0.0 {
        return Some("has no forces".into());
    }
    let wrong = |p: &&[f64; 2]| p[0] * p[1] < 0.0;
    let wrong = loading.points().iter().find(wrong);
    wrong.map(|[x, y]| format!("has the force {y:?} at {x:?}"))
}

/// Returns a force at which the unloading curve is less steep than the loading curve, if there is
/// one.
fn softer_unloading(loading: &PiecewiseLinear, unloading: &PiecewiseLinear) -> Option<f64> {
    let pieces = |line: &PiecewiseLinear| -> Vec<([f64; 2], f64)> {
        let points = line.points();
        let last = points.len() - 2;
        let range = |(piece, slope): (usize, f64)| {
            let mut ends = [points[piece][1], points[piece + 1][1]];
            // Lines continue beyond their ends.
            if piece == 0 && slope != 0.0 {
                ends[0] = -slope.signum() * f64::INFINITY;
            }
            if piece == last && slope != 0.0 {
                ends[1] = slope.signum() * f64::INFINITY;
            }
            (ends, slope)
        };
        line.slopes().enumerate().map(range).collect()
    };
    let (loading, unloading) = (pieces(loading), pieces(unloading));
    let pairs = loading.iter().flat_map(|l| unloading.iter().map(move |u| (l, u)));
    pairs.filter(|(l, u)| l.1 > u.1 * EQUAL_SLOPES).find_map(|((l, _), (u, _))| {
        // Loading ascends here, as unloading does.
        let (from, to) = (l[0].max(u[0]), l[1].min(u[1]));
        let inside = if from.is_finite() { from } else { to };
        (from < to).then_some(if inside.is_finite() { inside } else { 0.0 })
    })
}
