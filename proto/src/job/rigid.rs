//! Rigid bodies in a job.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rigid body: all nodes of its parts, and those of a node set. Elements of the parts compute no
/// forces and do not limit the time step. They have mass and take part in contact.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rigid {
    /// Name in messages and for motions.
    pub name: String,
    /// Parts.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Additional node set.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Fixed degrees of freedom: any of x, y, z, rx, ry, rz, translations of the centre and
    /// rotations about the axes of space.
    #[serde(default)]
    pub fixed: Vec<String>,
    /// Mass of the elements of its parts [mass]; without it their mass by density and thickness.
    /// Other masses of its nodes are added.
    #[serde(default)]
    pub mass: Option<f64>,
    /// Centre of mass of the elements of its parts [length]; without it that of their masses. These
    /// are changed so that it is there; it has to be inside of the elements.
    #[serde(default)]
    pub centre: Option<[f64; 3]>,
    /// Inertia about the centre, xx, yy, zz, xy, yz, zx [mass length^2]; without it that of the
    /// nodal masses.
    #[serde(default)]
    pub inertia: Option<[f64; 6]>,
    /// Inertia of points that the body carries, each about itself, xx, yy, zz, xy, yz, zx
    /// [mass length^2]: it adds to `inertia`, or to that of the nodal masses. The masses of the
    /// points are `[[mass]]` of their nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_inertia: Option<[f64; 6]>,
    /// Time at which its parts become rigid [time]; they deform before. The body then has the mass,
    /// the momentum and the angular momentum of its nodes. The kinetic energy of their other motion
    /// counts as work of external forces.
    #[serde(default)]
    pub from: f64,
    /// Time at which its parts deform again, with the stresses that they had [time]; without it the
    /// end of the run.
    #[serde(default)]
    pub until: Option<f64>,
    /// Bounds of the motion of its centre, for a body that is rigid for the whole run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stop: Vec<RigidStop>,
    /// Forces and moments at its centre of mass, for a body that is rigid for the whole run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load: Vec<RigidLoad>,
}

/// Force at the centre of mass of a rigid body, and moment about it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidLoad {
    /// Force [force].
    #[serde(default)]
    pub force: [f64; 3],
    /// Moment [force length].
    #[serde(default)]
    pub moment: [f64; 3],
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<String>,
    /// Turns force and moment with the body; otherwise they keep their directions in space.
    #[serde(default)]
    pub follows: bool,
}

/// Stop of a rigid body: its centre may not move beyond bounds along a direction. The impact is
/// plastic, as on a wall, and the work is that of walls. A body that is beyond a bound when the
/// stop begins to act is not moved back: it goes no further, and follows a bound that moves
/// against it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidStop {
    /// Direction in space; it is normalised.
    pub direction: [f64; 3],
    /// Curve of the least displacement since time 0 along the direction [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<String>,
    /// Curve of the largest displacement since time 0 along the direction [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<String>,
    /// Makes the bounds those of the coordinate of the centre along the direction [length].
    #[serde(default)]
    pub position: bool,
    /// Time at which it begins to act [time].
    #[serde(default)]
    pub birth: f64,
    /// Time at which it ceases to act [time]; without it the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub death: Option<f64>,
}
