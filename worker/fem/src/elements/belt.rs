//! Elements of seat belts. They have no force of their own: the belts of the worker compute the
//! tensions of all segments, because belt moves from one to another. The element gives its nodes an
//! owner and the stable step of a segment of the smallest length.

use super::spring::points;
use super::{
    Constructor, Discrete, Element, ElementEntry, ElementFields, ElementPass, ElementResult,
    PassTotals,
};
use crate::columns::ElementState;
use crate::piecewise_linear::PiecewiseLinear;
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "belt",
    shape: Shape::Line2,
    meaning: "Segment of a seat belt between two nodes.",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Discrete(build),
};

/// Number of corners.
const ENDS: usize = 2;

/// Parameters of segments of belts.
pub struct Belt {
    discrete: Discrete,
}

fn build(part: &Part) -> ElementResult {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(belt) = &part.belt else {
        say("belt", "it has belts but no [part.belt]".into(), "add it");
        return Err(problems);
    };
    if !part.material.is_empty() {
        say("material", "a part of belts has no material".into(), "remove it");
    }
    if part.element.is_some() {
        say("element", "a part of belts has one formulation".into(), "remove `element`");
    }
    if part.spring.is_some() || part.discrete_beam.is_some() {
        let what = "it has both [part.belt] and another table of two-node elements";
        say("belt", what.into(), "give belts their own part");
    }
    let numbers = [
        ("mass_per_length", belt.mass_per_length, true),
        ("min_length", belt.min_length, true),
        ("damping", belt.damping, false),
    ];
    for (key, value, above) in numbers {
        if !(value.is_finite() && value >= 0.0) || above && value == 0.0 {
            let wanted = if above { "above 0" } else { "0 or above" };
            say(&format!("belt.{key}"), format!("{key} is {value}"), &format!("give {wanted}"));
        }
    }
    let loading = ("belt.force_strain", &belt.force_strain, false);
    let unloading = ("belt.unloading", &belt.unloading, true);
    let mut steepest = 0.0_f64;
    for (key, curve, rises) in [loading, unloading] {
        if (rises && curve.is_empty()) || !points(key, curve, &mut say) {
            continue;
        }
        let falls = |p: &[[f64; 2]]| p[1][1] < p[0][1] || rises && p[1][1] == p[0][1];
        if curve[0] != [0.0; 2] {
            let what = format!("{key} begins with {:?}", curve[0]);
            say(key, what, "begin it with [0, 0]: without strain there is no tension");
        } else if let Some(p) = curve.windows(2).find(|p| falls(p)) {
            let what = format!("the force goes from {:?} to {:?}", p[0][1], p[1][1]);
            say(key, what, if rises { "let it ascend" } else { "let it not fall" });
        } else {
            steepest = steepest.max(PiecewiseLinear::new(curve, 0.0).steepest());
        }
    }
    if problems.is_empty()
        && !belt.unloading.is_empty()
        && !is_steeper(&belt.unloading, &belt.force_strain)
    {
        let what = "unloading is less steep than loading at the same force";
        let help = "the belt would give back more energy than it took: correct one of the curves";
        let mut say = |key: &str, what: String, help: &str| {
            problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
        };
        say("belt.unloading", what.into(), help);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    Ok(Box::new(Belt {
        discrete: Discrete {
            stiffness: steepest / belt.min_length,
            damping: belt.damping / belt.min_length,
            along_line: false,
            rotational: false,
        },
    }))
}

/// Returns true if an ascending curve for unloading is at each force at least as steep as that for
/// loading.
pub fn is_steeper(unloading: &[[f64; 2]], loading: &[[f64; 2]]) -> bool {
    let (down, up) = (PiecewiseLinear::new(unloading, 0.0), PiecewiseLinear::new(loading, 0.0));
    let forces = unloading.iter().chain(loading).map(|p| p[1]);
    let mut forces: Vec<f64> = forces.filter(|&force| force >= loading[0][1]).collect();
    forces.sort_unstable_by(f64::total_cmp);
    forces.dedup();
    // Loading whose last piece is level reaches no larger force.
    let top = loading.last().map_or(0.0, |p| p[1]);
    if loading.windows(2).last().is_none_or(|two| two[0][1] < two[1][1]) {
        forces.push(2.0 * forces.last().map_or(1.0, |last| last.max(f64::MIN_POSITIVE)));
    } else {
        forces.retain(|&force| force <= top);
    }
    // Between two forces, unloading has to need less way than loading.
    let way = |line: &PiecewiseLinear, from: f64, to: f64| line.first_at(to) - line.first_at(from);
    let slack = 1.0 + 1e-9;
    forces.windows(2).all(|f| way(&down, f[0], f[1]) <= slack * way(&up, f[0], f[1]))
}

impl Element for Belt {
    fn columns(&self) -> usize {
        0
    }

    fn names(&self) -> Vec<String> {
        Vec::new()
    }

    fn corner_mass(&self, _: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (0.0, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        pass.one_by_one::<ENDS>(0, |element, out| {
            let slot = element.index * ENDS;
            (out.force[slot], out.force[slot + 1]) = Default::default();
            (f64::INFINITY, true)
        })
    }

    fn stable_dt(&self, _: &[[f64; 3]], _: OwnSection) -> f64 {
        f64::INFINITY
    }

    fn discrete(&self) -> Option<Discrete> {
        Some(self.discrete)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unloading_has_to_be_as_steep_as_loading() {
        let loading = [[0.0, 0.0], [0.1, 1.0], [0.3, 2.0]];
        assert!(is_steeper(&[[0.0, 0.0], [0.05, 2.0]], &loading));
        assert!(is_steeper(&loading, &loading));
        assert!(!is_steeper(&[[0.0, 0.0], [0.3, 2.0]], &loading));
        assert!(!is_steeper(&[[0.0, 0.0], [0.1, 1.0], [0.5, 2.0]], &loading));
        // A limiter: its force stays below what unloading could have.
        let limiter = [[0.0, 0.0], [10.0, 4.0], [400.0, 4.0]];
        assert!(is_steeper(&[[0.0, 0.0], [5.0, 5.0]], &limiter));
        assert!(!is_steeper(&[[0.0, 0.0], [15.0, 5.0]], &limiter));
    }
}
