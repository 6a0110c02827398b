//! Loads and prescribed motion as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A factor over time that loads and motions refer to by name: linear between its points, constant
/// outside.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Name that loads refer to.
    pub name: String,
    /// `[time, factor]` with ascending times.
    pub points: Vec<[f64; 2]>,
}

/// Gravity, or another body force, on the whole model.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration of free fall [length/time^2].
    pub acceleration: [f64; 3],
    /// Factor over time; 1 without it.
    #[serde(default)]
    pub curve: Option<String>,
}

/// A force of constant direction on a node set.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Node set.
    pub nodes: String,
    /// Force on the whole set, shared equally by its nodes [force].
    #[serde(default)]
    pub force: [f64; 3],
    /// Moment on the whole set, shared equally by its nodes [force length].
    #[serde(default)]
    pub moment: [f64; 3],
    /// Factor over time; 1 without it.
    #[serde(default)]
    pub curve: Option<String>,
}

/// Pressure on faces; it follows them as they move. A positive pressure pushes against a face's
/// normal, which for a shell follows from the order of its nodes by the right-hand rule.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// Parts all of whose faces are loaded.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Node set: the faces all of whose nodes are in it are loaded, of `parts` only if these are
    /// given too.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Pressure [force/length^2].
    pub pressure: f64,
    /// Factor over time; 1 without it.
    #[serde(default)]
    pub curve: Option<String>,
}

/// Prescribed motion of a node set or a rigid body by exactly one of `velocity`, `displacement`,
/// `acceleration` and `spin`. Nothing that is met keeps the nodes from it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Node set; either this or `rigid`.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Name of a rigid body: its centre is moved, and it turns about its centre.
    #[serde(default)]
    pub rigid: Option<String>,
    /// Any of x, y, z, rx, ry, rz: what is prescribed; the rest stays free. If left out, x, y, z,
    /// and with `spin` all six (of a rigid body rx, ry, rz). Rotations named without `spin` are
    /// held.
    #[serde(default)]
    pub dofs: Vec<String>,
    /// Velocity [length/time].
    #[serde(default)]
    pub velocity: Option<[f64; 3]>,
    /// Displacement; its curve has to start at 0 [length].
    #[serde(default)]
    pub displacement: Option<[f64; 3]>,
    /// Acceleration from rest [length/time^2].
    #[serde(default)]
    pub acceleration: Option<[f64; 3]>,
    /// Rotational velocity about a fixed axis through `centre` [1/time].
    #[serde(default)]
    pub spin: Option<[f64; 3]>,
    /// A point of the axis [length]; not for a rigid body.
    #[serde(default)]
    pub centre: [f64; 3],
    /// Factor over time; 1 without it.
    #[serde(default)]
    pub curve: Option<String>,
}

/// A plane of symmetry: nodes on it do not leave it and turn about its normal only.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// A point of the plane [length].
    pub point: [f64; 3],
    /// Normal, along a coordinate axis.
    pub normal: [f64; 3],
    /// How far from the plane a node may be to count as on it [length]; 0 for a thousandth of the
    /// smallest side.
    #[serde(default)]
    pub tolerance: f64,
}
