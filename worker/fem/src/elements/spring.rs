//! Discrete springs and dampers between two nodes.
//!
//! A rotational spring has the relative rotation about e instead of the elongation, summed from
//! the rotational velocities at mid-step, and a moment instead of the force.
//!
//! With the elongation s since the start and its rate r at the last mid-step, the force is
//! `F = f(s) + g(r)`, where f may have a memory ([`SpringLaw`]), along the unit vector e from the
//! first node to the second, or along a direction a: a fixed one, or that between two other nodes
//! at the present time, which columns hold. With `projected` it acts along the line between the
//! nodes in the plane normal to a: x is then `x - (x . a) a` of the vector x between the nodes, e
//! its unit vector, and s is measured by its length. The work follows from the forces at both
//! ends of a step and the velocity between them, so that the energy balance is that of the central
//! differences.
//!
//! Stable step (Belytschko, Liu & Moran 2000, sec. 6.2, with damping delayed by half a step):
//! between masses with the sum mu of their inverses the amplification polynomial
//! `z^2 - (2 - k mu dt^2 - c mu dt) z + 1 - c mu dt` has its roots within the unit circle as long
//! as `k mu dt^2 + 2 c mu dt <= 4`. The stiffness across a stretched spring, F / L, is below the
//! largest k as long as f(0) = 0, and with a plastic elongation as long as the elastic elongation
//! is below the length.

mod maxwell;
pub(super) mod plastic;
#[cfg(test)]
mod tests;
pub(super) mod unloading;

use self::maxwell::Maxwell;
use self::plastic::Plastic;
use super::{
    Constructor, Discrete, Element, ElementEntry, ElementFields, ElementPass, ElementResult,
    PassTotals, SingleElement,
};
use crate::columns::ElementState;
use crate::piecewise_linear::PiecewiseLinear;
use crumple_math::row::{V3, xyz};
use crumple_proto::job::{Part, SpringInput};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "spring",
    shape: Shape::Line2,
    meaning: "Spring and damper between two nodes, along their line or a fixed direction.",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Discrete(build),
};

/// Columns: 1 if it has started, else 0; length at the start [length], or the relative rotation;
/// force [force] or moment [force length] on the second corner.
const STARTED: usize = 0;
const LENGTH: usize = 1;
const FORCE: usize = 2;
/// Then those of the law.
const LAW: usize = 5;
/// Number of columns of a direction that follows nodes.
const DIRECTION: usize = 3;
/// Number of corners.
const ENDS: usize = 2;

/// Function of the elongation of springs, which may have a memory.
pub(super) trait SpringLaw: Send + Sync {
    /// Returns the names of its history columns; all start at zero.
    fn names(&self) -> &'static [&'static str];

    /// Returns the force at the elongation `way` [length] (or rotation) at the end of a step `dt`
    /// [time], and updates the history.
    fn force(&self, state: &mut [f64], way: f64, dt: f64) -> f64;

    /// Returns the largest change of the force with the elongation [force/length].
    fn steepest(&self) -> f64;
}

/// Elastic springs.
impl SpringLaw for PiecewiseLinear {
    fn names(&self) -> &'static [&'static str] {
        &[]
    }

    fn force(&self, _: &mut [f64], way: f64, _: f64) -> f64 {
        self.value(way)
    }

    fn steepest(&self) -> f64 {
        PiecewiseLinear::steepest(self)
    }
}

/// Reports a problem of a part: the key, what is wrong, and what to do.
pub(super) type AddSpringProblem<'a> = dyn FnMut(&str, String, &str) + 'a;

/// Result of a row of [`LAWS`]; `None` if the law reported problems.
pub(super) type SpringLawResult = Option<Box<dyn SpringLaw>>;

/// Builds a law with a memory if its key is given.
type SpringConstructor = fn(&SpringInput, &mut AddSpringProblem<'_>) -> Option<SpringLawResult>;

/// Laws with a memory: key in `[part.spring]`, and constructor.
const LAWS: &[(&str, SpringConstructor)] = &[
    ("elastoplastic", |input, say| {
        Some(boxed(Plastic::elastoplastic(input.elastoplastic.as_ref()?, say)))
    }),
    ("hysteresis", |input, say| Some(boxed(Plastic::hysteresis(input.hysteresis.as_ref()?, say)))),
    ("one_sided", |input, say| Some(boxed(Plastic::one_sided(input.one_sided.as_ref()?, say)))),
    ("maxwell", |input, say| Some(boxed(Maxwell::new(input.maxwell.as_ref()?, say)))),
];

pub(super) fn boxed(law: Option<impl SpringLaw + 'static>) -> SpringLawResult {
    Some(Box::new(law?))
}

/// Parameters of springs.
pub struct Spring {
    elongation: Box<dyn SpringLaw>,
    rate: PiecewiseLinear,
    direction: Option<V3>,
    /// True if columns hold the direction.
    follows: bool,
    /// True if the line between the nodes is projected along the direction.
    projected: bool,
    rotational: bool,
}

fn build(part: &Part) -> ElementResult {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(spring) = &part.spring else {
        say(
            "spring",
            "it has springs but no [part.spring]".into(),
            "add it, with stiffness or damping",
        );
        return Err(problems);
    };
    if !part.material.is_empty() {
        say("material", "a part of springs has no material".into(), "remove it");
    }
    if part.element.is_some() {
        say("element", "a part of springs has one formulation".into(), "remove `element`");
    }
    let [elastic, viscous] = [
        (ELONGATION, spring.stiffness, &spring.force_elongation),
        (RATE, spring.damping, &spring.force_rate),
    ]
    .map(|(keys, number, points)| {
        let mut own = |key: &str, what: String, help: &str| {
            say(&format!("spring.{key}"), what, help);
        };
        force_line(keys, number, points, &mut own)
    });
    let mut laws = Vec::new();
    for (key, law) in LAWS {
        let mut own = |key: &str, what: String, help: &str| {
            say(&format!("spring.{key}"), what, help);
        };
        laws.extend(law(spring, &mut own).map(|law| (*key, law)));
    }
    let of_elongation = [!spring.force_elongation.is_empty(), spring.stiffness != 0.0];
    let of_elongation = ELONGATION.into_iter().zip(of_elongation);
    let of_elongation = of_elongation.filter_map(|(key, given)| given.then_some(key));
    let given: Vec<&str> = laws.iter().map(|law| law.0).chain(of_elongation).collect();
    if !laws.is_empty() && given.len() > 1 {
        let what = format!("a spring has both {} and {}", given[0], given[1]);
        say(&format!("spring.{}", given[0]), what, "give one of them");
    }
    if laws.is_empty()
        && spring.stiffness == 0.0
        && spring.damping == 0.0
        && spring.force_elongation.is_empty()
        && spring.force_rate.is_empty()
    {
        say(
            "spring",
            "its springs carry no force".into(),
            "give stiffness, damping or a table of forces",
        );
    }
    let direction = spring.direction.map(|d| V3::from(d).try_normalize(0.0));
    if direction == Some(None) {
        say(
            "spring.direction",
            "the direction of its springs is zero".into(),
            "give a direction such as [0, 0, 1]",
        );
    }
    let follows = spring.direction_nodes.is_some();
    if follows && spring.direction.is_some() {
        let what = "its springs have both direction and direction_nodes".into();
        say("spring.direction_nodes", what, "give one of them");
    }
    if spring.projected && !follows && spring.direction.is_none() {
        let what = "its springs are projected along no direction".into();
        say("spring.projected", what, "give `direction` or `direction_nodes`");
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    Ok(Box::new(Spring {
        elongation: laws.pop().and_then(|law| law.1).unwrap_or_else(|| Box::new(elastic)),
        rate: viscous,
        direction: direction.flatten(),
        follows,
        projected: spring.projected,
        rotational: spring.rotational,
    }))
}

/// Keys of the force over the elongation and over its rate: the table, and the coefficient that
/// stands for a straight line.
pub(super) const ELONGATION: [&str; 2] = ["force_elongation", "stiffness"];
pub(super) const RATE: [&str; 2] = ["force_rate", "damping"];

/// Returns the line of a table or a coefficient with these `keys`; without force after reporting a
/// problem.
pub(super) fn force_line(
    [table, coefficient]: [&str; 2],
    value: f64,
    points: &[[f64; 2]],
    say: &mut AddSpringProblem<'_>,
) -> PiecewiseLinear {
    let mut sound = number(coefficient, value, "0 or above", |value| value >= 0.0, say);
    if value != 0.0 && !points.is_empty() {
        say(table, format!("a spring has both {table} and {coefficient}"), "give one of them");
        sound = false;
    }
    if !points.is_empty() && !self::points(table, points, say) {
        sound = false;
    }
    if sound { PiecewiseLinear::new(points, value) } else { PiecewiseLinear::new(&[], 0.0) }
}

/// Reports a number that is not in its range, or not finite. Returns true if it is.
pub(super) fn number(
    key: &str,
    value: f64,
    range: &str,
    fits: impl Fn(f64) -> bool,
    say: &mut AddSpringProblem<'_>,
) -> bool {
    let sound = value.is_finite() && fits(value);
    if !sound {
        let name = key.rsplit('.').next().unwrap_or(key);
        say(key, format!("{name} is {value}"), &format!("it has to be {range}"));
    }
    sound
}

/// Reports the error in the points of a curve, if any. Returns true if there is none.
pub(super) fn points(key: &str, points: &[[f64; 2]], say: &mut AddSpringProblem<'_>) -> bool {
    let name = key.rsplit('.').next().unwrap_or(key);
    let fault = match PiecewiseLinear::fault(points) {
        None if points.is_empty() => Some("has no points".into()),
        None if !points.iter().flatten().all(|x| x.is_finite()) => Some("is not finite".into()),
        fault => fault,
    };
    if let Some(fault) = &fault {
        let help = "give at least two points with ascending first numbers";
        say(key, format!("{name} {fault}"), help);
    }
    fault.is_none()
}

impl Spring {
    /// Returns the length between two points, and the unit vector along which it is measured, with
    /// the columns of the element.
    fn measure(&self, between: &V3, state: &[f64]) -> (f64, V3) {
        let free = |line: &V3| (line.norm(), line.try_normalize(0.0).unwrap_or_default());
        let held = || state[self.direction_column()..].first_chunk::<DIRECTION>();
        let followed = || held().map(|direction| V3::from(*direction)).unwrap_or_default();
        let direction = if self.follows { Some(followed()) } else { self.direction };
        match direction {
            None => free(between),
            Some(normal) if self.projected => free(&(between - normal * normal.dot(between))),
            Some(along) => (along.dot(between), along),
        }
    }

    /// Returns the first column of a direction that follows nodes, after those of the law.
    fn direction_column(&self) -> usize {
        LAW + self.elongation.names().len()
    }
}

impl Element for Spring {
    fn columns(&self) -> usize {
        self.direction_column() + if self.follows { DIRECTION } else { 0 }
    }

    fn followed_direction(&self) -> Option<usize> {
        self.follows.then(|| self.direction_column())
    }

    fn names(&self) -> Vec<String> {
        let names = match self.rotational {
            true => ["started", "rotation", "moment x", "moment y", "moment z"],
            false => ["started", "length", "force x", "force y", "force z"],
        };
        let followed = ["direction x", "direction y", "direction z"];
        let followed = followed.into_iter().take(self.columns() - self.direction_column());
        let own = names.iter().chain(self.elongation.names()).copied().chain(followed);
        own.map(String::from).collect()
    }

    fn corner_mass(&self, _: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (0.0, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<ENDS>(self.columns(), |element, out| {
            let SingleElement { index, nodes: ends, state, internal } = element;
            let rates = if self.rotational { nodes.w } else { nodes.v };
            let [x, v] = [nodes.x, rates]
                .map(|rows| V3::from(xyz(&rows[ends[1]])) - V3::from(xyz(&rows[ends[0]])));
            let (length, along) = self.measure(&x, state);
            let rate = along.dot(&v);
            if self.rotational {
                state[LENGTH] += rate * dt;
            } else if state[STARTED] == 0.0 {
                state[LENGTH] = length;
            }
            state[STARTED] = 1.0;
            let way = if self.rotational { state[LENGTH] } else { length - state[LENGTH] };
            let elastic = self.elongation.force(&mut state[LAW..], way, dt);
            let force = along * (elastic + self.rate.value(rate));
            let slot = index * ENDS;
            let target = if self.rotational { &mut out.moment } else { &mut out.force };
            for c in 0..3 {
                let before = std::mem::replace(&mut state[FORCE + c], force[c]);
                *internal += 0.5 * (before + force[c]) * v[c] * dt;
                (target[slot][c], target[slot + 1][c]) = (-force[c], force[c]);
            }
            (f64::INFINITY, force.iter().all(|f| f.is_finite()))
        })
    }

    fn stable_dt(&self, _: &[[f64; 3]], _: OwnSection) -> f64 {
        f64::INFINITY
    }

    fn discrete(&self) -> Option<Discrete> {
        let (stiffness, damping) = (self.elongation.steepest(), self.rate.steepest());
        Some(Discrete {
            stiffness,
            damping,
            along_line: self.projected || !self.follows && self.direction.is_none(),
            rotational: self.rotational,
        })
    }

    fn failed(&self, _: ElementState<'_>) -> bool {
        false
    }

    fn can_fail(&self) -> bool {
        false
    }

    fn fields(&self, _: ElementState<'_>, _: &[[f64; 3]]) -> ElementFields {
        ElementFields::default()
    }
}
