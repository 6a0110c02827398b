//! Discrete beams in a job.

use super::HysteresisSpring;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Properties of a part of discrete beams: six springs and dampers between two nodes, which may
/// coincide, along and about three axes r, s and t that rotate with the nodes. Its elements are
/// rows of `mesh.springs`. Forces act on the second node against the first; the moments of their
/// couple act on the nodes that rotate the axes, so that no net moment arises.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscreteBeamInput {
    /// Mass of an element, half of it at each node [mass].
    pub mass: f64,
    /// Rotational inertia of an element about any axis, half of it at each node [mass length^2].
    pub inertia: f64,
    /// Directions r and s at the start; s is made perpendicular to r, t is normal to both. Default:
    /// x and y.
    #[serde(default = "x_and_y")]
    pub axes: [[f64; 3]; 2],
    /// Nodes whose rotation the axes follow.
    #[serde(default)]
    pub turns_with: TurningNode,
    /// True if r lies along the line between the nodes, which must not coincide. The elongation on
    /// r is then the change of their distance, and the displacements on s and t are summed up from
    /// their rates. Before the start and in each step the axes turn to the line by the shortest
    /// rotation.
    #[serde(default)]
    pub along_line: bool,
    /// Springs and dampers, at most one for each axis. Other axes are free.
    #[serde(default)]
    pub spring: Vec<AxisSpring>,
    /// How the limits of the axes together make a beam fail. A beam that has failed carries no
    /// force.
    #[serde(default)]
    pub failure: BeamFailure,
}

fn x_and_y() -> [[f64; 3]; 2] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
}

/// Nodes whose rotation the axes of a discrete beam follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TurningNode {
    /// The mean of both.
    #[default]
    Both,
    /// The first node.
    First,
    /// The second node.
    Second,
}

/// How the limits of the axes of a discrete beam make it fail. A ratio is a displacement or a force
/// over its limit on an axis; axes without a limit have none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BeamFailure {
    /// The sum of the squares of the ratios reaches 1: that of all displacements, or that of all
    /// forces.
    #[default]
    Together,
    /// As `together`, with a sum for positive displacements and one for negative ones.
    BySign,
    /// One ratio reaches 1.
    Any,
}

/// Spring and damper of a discrete beam on one axis. On `rr`, `rs` and `rt` forces are moments,
/// elongations are angles in radians. One of `stiffness`, `force_elongation`, `yielding`,
/// `hysteresis`, `between_curves` and `permanent_set` gives the function of the displacement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisSpring {
    /// The axis.
    pub axis: BeamAxis,
    /// Stiffness [force/length].
    #[serde(default)]
    pub stiffness: f64,
    /// Force as a function of the displacement since the start, instead of `stiffness`: points
    /// with ascending displacements. Outside its range it continues with its first and last slope
    /// [length, force].
    #[serde(default)]
    pub force_elongation: Vec<[f64; 2]>,
    /// Damping [force time/length].
    #[serde(default)]
    pub damping: f64,
    /// Force as a function of the rate of the displacement, instead of `damping`, in the same form
    /// [length/time, force].
    #[serde(default)]
    pub force_rate: Vec<[f64; 2]>,
    /// A yield force over the plastic displacement.
    #[serde(default)]
    pub yielding: Option<YieldingSpring>,
    /// Different curves for loading and unloading.
    #[serde(default)]
    pub hysteresis: Option<HysteresisSpring>,
    /// Loading and unloading curves with steep lines between them.
    #[serde(default)]
    pub between_curves: Option<BetweenCurvesSpring>,
    /// Unloading along a parabola to a permanent displacement.
    #[serde(default)]
    pub permanent_set: Option<PermanentSetSpring>,
    /// Force from the start on, to which that of the displacement is added [force]. A spring that
    /// yields has it as elastic force.
    #[serde(default)]
    pub preload: f64,
    /// Displacement at the start [length].
    #[serde(default)]
    pub initial_displacement: f64,
    /// Positive displacement at which the beam fails, if it is the only one [length].
    #[serde(default)]
    pub failure_tension: Option<f64>,
    /// Size of the negative displacement at which the beam fails, if it is the only one [length].
    #[serde(default)]
    pub failure_compression: Option<f64>,
    /// Size of the force at which the beam fails, if it is the only one [force].
    #[serde(default)]
    pub failure_force: Option<f64>,
}

/// Spring that yields at a force which depends on its plastic displacement: the sum of all plastic
/// displacements so far, in both directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct YieldingSpring {
    /// Elastic stiffness [force/length].
    pub stiffness: f64,
    /// Yield force over plastic displacement: points with ascending displacements. Points from 0
    /// on are for both directions alike; points at negative displacements, with negative forces,
    /// are for compression. The curve continues with its last slope, and a force that has fallen to
    /// zero stays zero [length, force].
    pub yield_force: Vec<[f64; 2]>,
}

/// Spring with a force between two curves: it follows the loading curve while the displacement
/// grows, the unloading curve while it shrinks, and a straight line from one to the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BetweenCurvesSpring {
    /// Force over displacement of loading: points with ascending displacements, through [0, 0]
    /// [length, force].
    pub loading: Vec<[f64; 2]>,
    /// Force over displacement of unloading, in the same form, through [0, 0]; its forces ascend
    /// and are not larger than those of loading [length, force].
    pub unloading: Vec<[f64; 2]>,
    /// Slope of the lines between the curves, at least that of both curves [force/length].
    pub stiffness: f64,
}

/// Spring that unloads along a parabola from its largest displacement to a permanent one, where the
/// parabola has its vertex. Below it the spring has no force; loaded again it follows the same
/// parabola. Tension and compression are independent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PermanentSetSpring {
    /// Force over displacement of loading: points with ascending displacements, through [0, 0]
    /// [length, force].
    pub loading: Vec<[f64; 2]>,
    /// Permanent displacement over the largest one so far, from 0 to below 1.
    pub fraction: f64,
}

/// Axis of a spring of a discrete beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BeamAxis {
    /// Along r.
    R,
    /// Along s.
    S,
    /// Along t.
    T,
    /// About r.
    Rr,
    /// About s.
    Rs,
    /// About t.
    Rt,
}
