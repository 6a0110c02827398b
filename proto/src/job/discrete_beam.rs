//! Discrete beams in a job.

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
    /// Springs and dampers, at most one for each axis. Other axes are free.
    #[serde(default)]
    pub spring: Vec<AxisSpring>,
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

/// Spring and damper of a discrete beam on one axis. On `rr`, `rs` and `rt` forces are moments,
/// elongations are angles in radians.
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
