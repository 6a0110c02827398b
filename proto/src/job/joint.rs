//! Joints between rigid bodies in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Joint between two rigid bodies, or between a body and the ground. It acts without play and
/// without friction, unless `rotation` or `sliding` resists. Contact between the bodies is not
/// changed by it.
///
/// The angle about the axis and the distance along it are those of the second body against the
/// first one, and 0 at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointInput {
    /// Name in messages.
    pub name: String,
    /// Kind of the joint: what it leaves free.
    pub kind: JointKind,
    /// Names of two rigid bodies; with one name, that body is joined to the ground.
    pub bodies: Vec<String>,
    /// Point of both bodies that the joint keeps together or guides [length].
    pub point: [f64; 3],
    /// Axis, fixed in the first body (the only one, with the ground); all kinds but `spherical` and
    /// `fixed` have one. That of a `planar` joint is its normal, that of a `universal` joint its
    /// first axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Second axis of a universal joint, fixed in the second body and perpendicular to `axis` at
    /// the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_axis: Option<[f64; 3]>,
    /// Distance that a screw moves along its axis in a full turn; negative for a left-hand screw
    /// [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch: Option<f64>,
    /// Resistance against rotation about the axis of a revolute, cylindrical or screw joint: angles
    /// in radians, moments [force length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<JointResistance>,
    /// Resistance against sliding along the axis of a cylindrical or translational joint: distances
    /// [length], forces [force].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sliding: Option<JointResistance>,
}

/// Kind of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// A common point, all rotations are free.
    Spherical,
    /// A hinge: a common point, rotation about the axis is free.
    Revolute,
    /// Rotation about the axis and sliding along it are free.
    Cylindrical,
    /// Sliding along the axis is free.
    Translational,
    /// A common point, rotations about two axes are free, one in each body.
    Universal,
    /// Sliding in the plane across the axis and rotation about it are free.
    Planar,
    /// Rotation about the axis, which moves the body along the axis by the pitch.
    Screw,
    /// Nothing is free.
    Fixed,
}

/// Resistance of a joint: the sum of an elastic part, damping and friction; and stops.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointResistance {
    /// Stiffness [moment per radian, or force/length].
    pub stiffness: f64,
    /// Moment (or force) as a function of the angle (or distance), instead of `stiffness`: points
    /// `[angle, moment]` with ascending angles. Outside its range it continues with its first and
    /// last slope.
    pub table: Vec<[f64; 2]>,
    /// Damping [moment time per radian, or force time/length].
    pub damping: f64,
    /// Largest moment (or force) of Coulomb friction.
    pub friction: f64,
    /// Smallest and largest angle (or distance), with 0 between them. The joint stops there without
    /// rebound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stops: Option<[f64; 2]>,
}
