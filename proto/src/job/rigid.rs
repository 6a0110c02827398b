//! Rigid bodies as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid body: all nodes of its parts, and those of a set. Elements of the parts compute no
/// forces and do not limit the time step; they carry mass and take part in contact.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rigid {
    /// Name for people and for motions.
    pub name: String,
    /// Parts.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Node set, in addition.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Any of x, y, z, rx, ry, rz: translations of the centre and rotations about the axes of space
    /// that are held.
    #[serde(default)]
    pub fixed: Vec<String>,
    /// Mass of the elements of its parts [mass]; theirs by density and thickness if left out. What
    /// else its nodes carry comes on top.
    #[serde(default)]
    pub mass: Option<f64>,
    /// Inertia about the centre, xx, yy, zz, xy, yz, zx [mass length^2]; that of the nodal masses
    /// if left out.
    #[serde(default)]
    pub inertia: Option<[f64; 6]>,
}
