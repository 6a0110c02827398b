//! Rigid walls as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid wall that nodes do not pass: a plane, a rectangle of one, or the mantle of a cylinder.
/// It stands still, goes where a curve leads it, or has a mass and gives way along its normal.
///
/// A rectangle or a cylinder stops what comes from outside, and lets be what is behind it. Degrees
/// of freedom that are fixed or prescribed feel no wall: nothing pushes them, and a wall with a
/// mass is not stopped by them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name for histories.
    #[serde(default)]
    pub name: String,
    /// A point of the wall: of a rectangle a corner, of a cylinder the start of its axis [length].
    pub point: [f64; 3],
    /// Normal of a plane or a rectangle, towards the side where the model is (made a unit vector).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Makes the plane a rectangle: direction of its first side from `point`, made square to the
    /// normal. The second side has the direction normal x edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<[f64; 3]>,
    /// Lengths of the two sides of a rectangle, 0 for one without end [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lengths: Option<[f64; 2]>,
    /// Direction of the axis of a cylinder, instead of `normal`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Radius of a cylinder [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Length of a cylinder, 0 for one without end. Its ends are open [length].
    #[serde(default)]
    pub length: f64,
    /// Coulomb friction coefficient.
    #[serde(default)]
    pub friction: f64,
    /// Node set that meets the wall; all nodes without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<String>,
    /// Node set that passes through the wall all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub except: Option<String>,
    /// Mass of a plane or rectangle that moves freely along its normal and not otherwise [mass].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Velocity at the start along its normal, of a wall with mass [length/time].
    #[serde(default)]
    pub speed: f64,
    /// Prescribed velocity of the wall [length/time].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Prescribed displacement of the wall, instead of a velocity; its curve has to start at 0
    /// [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<[f64; 3]>,
    /// Factor on the prescribed velocity or displacement over time; 1 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<String>,
}
