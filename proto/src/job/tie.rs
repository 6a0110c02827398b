//! Ties in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes tied to the surface on which they are at the start. Each node is moved onto the nearest
/// face and then follows the nodes of this face. The shape functions distribute its mass and the
/// forces on it to these nodes and give its velocity. So momentum and energy are conserved, and no
/// stable step becomes shorter.
///
/// Nodes tied to a face of a rigid body become members of the body. Walls do not act on tied nodes,
/// only on the nodes that they follow. If the initial velocity of a node differs from that of its
/// face, the difference of momentum goes to the face. If the element of its face fails, the node is
/// released.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TieInput {
    /// Name in messages.
    #[serde(default)]
    pub name: String,
    /// Node set that is tied (slaves).
    pub nodes: String,
    /// Parts whose shells and outer faces of solids are the surface.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Node set: the faces whose nodes are all in it are the surface; with `parts`, only those of
    /// these parts.
    #[serde(default)]
    pub faces: Option<String>,
    /// Id of a single master node, instead of a surface. The slaves have its displacements at any
    /// distance, so that angular momentum is not conserved.
    #[serde(default)]
    pub node: Option<u64>,
    /// Node set whose mean motion the slaves have, instead of a surface: translation and rotation
    /// of the rigid motion that fits these masters best. A force or moment on a slave acts on the
    /// masters as forces. The mass of a slave is divided among them; its rotational inertia is not
    /// carried.
    #[serde(default)]
    pub mean_of: Option<String>,
    /// Weights of the masters of `mean_of` in ascending order of their ids; equal if empty.
    #[serde(default)]
    pub weights: Vec<f64>,
    /// Largest distance of a node from a face [length]. Without it the larger of 0.6 of the
    /// thicknesses of both and a twentieth of the shorter diagonal of the face, as in LS-DYNA.
    /// Nodes at a larger distance are not tied, and a warning names them.
    #[serde(default)]
    pub tolerance: f64,
    /// Thicknesses of the side of the nodes and of the side of the faces for the default
    /// `tolerance` [length]; 0 for those of the parts.
    #[serde(default)]
    pub thicknesses: [f64; 2],
    /// Also tie rotations, to faces whose nodes have rotations.
    #[serde(default)]
    pub rotations: bool,
    /// Keep nodes at their initial positions, at the end of arms that rotate with the face. Only
    /// for faces whose nodes have rotations; nodes on faces of solids are moved in any case. A
    /// force on a node acts on the face with its moment.
    #[serde(default)]
    pub offset: bool,
}
