//! Rigid walls in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rigid wall that nodes may not enter: a plane, a rectangle, the lateral surface of a cylinder, or
/// a sphere. It is at rest, has a prescribed motion, or has a mass and moves along its normal.
///
/// Planes and rectangles have a `normal`, cylinders an `axis` and a `radius`, spheres a `radius`
/// only. All but planes stop nodes that come from outside and ignore nodes behind them. A wall does
/// not act on fixed or prescribed degrees of freedom, and these do not stop a wall with a mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallInput {
    /// Name in histories.
    #[serde(default)]
    pub name: String,
    /// Point on the wall [length]: a corner of a rectangle, the start of the axis of a cylinder,
    /// the centre of a sphere.
    pub point: [f64; 3],
    /// Normal of a plane or a rectangle, towards the model; it is normalised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Makes the plane a rectangle: direction of its first side from `point`, made perpendicular to
    /// the normal. The second side has the direction normal x edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<[f64; 3]>,
    /// Lengths of the two sides of a rectangle [length]; 0 for an infinite side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lengths: Option<[f64; 2]>,
    /// Direction of the axis of a cylinder, instead of `normal`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Radius of a cylinder, or of a sphere, which has neither `normal` nor `axis` [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Length of a cylinder [length]; 0 for an infinite one. Its ends are open.
    #[serde(default)]
    pub length: f64,
    /// Coefficient of Coulomb friction.
    #[serde(default)]
    pub friction: f64,
    /// Node set that the wall acts on; without it all nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<String>,
    /// Node set that the wall ignores.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub except: Option<String>,
    /// Mass of a plane or rectangle that moves freely along its normal, and only along it [mass].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Initial velocity along its normal, of a wall with a mass [length/time].
    #[serde(default)]
    pub speed: f64,
    /// Prescribed velocity of the wall [length/time].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Prescribed displacement of the wall, instead of a velocity [length]. Its curve must start at
    /// 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<[f64; 3]>,
    /// Name of a curve, the factor over time of the prescribed velocity or displacement; without it
    /// 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<String>,
    /// Time at which it begins to stop nodes [time]. A wall moves at all times. A plane with a
    /// birth ignores the nodes that are behind it then, as other walls do.
    #[serde(default)]
    pub birth: f64,
    /// Time at which it ceases to stop nodes [time]; without it the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub death: Option<f64>,
}
