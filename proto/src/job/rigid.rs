//! Rigid bodies in a job.

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
    /// Inertia about the centre, xx, yy, zz, xy, yz, zx [mass length^2]; without it that of the
    /// nodal masses.
    #[serde(default)]
    pub inertia: Option<[f64; 6]>,
    /// Time at which its parts become rigid [time]; they deform before. The body then has the mass,
    /// the momentum and the angular momentum of its nodes. The kinetic energy of their other motion
    /// counts as work of external forces.
    #[serde(default)]
    pub from: f64,
    /// Time at which its parts deform again, with the stresses that they had [time]; without it the
    /// end of the run.
    #[serde(default)]
    pub until: Option<f64>,
}
