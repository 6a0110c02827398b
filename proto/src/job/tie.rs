//! Ties in a job.

use super::PartRef;
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
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set: the faces whose nodes are all in it are the surface; with `parts`, only those of
    /// these parts.
    #[serde(default)]
    pub faces: Option<String>,
    /// The nodes are tied to the solids of `parts` in which they are, not to a surface, as
    /// reinforcement is in concrete. Each has the displacement of its solid at its place, in a
    /// tetrahedron of ten nodes that of its corners. A node outside by more than `tolerance`, by
    /// default a thousandth of the diagonal of the box around the solid, is not tied. Nodes that
    /// these solids have themselves are left out.
    #[serde(default)]
    pub inside: bool,
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
    /// If no node is near enough to the surface, warn instead of an error.
    #[serde(default)]
    pub may_be_empty: bool,
    /// Limits at which nodes tied to a surface come off; then they are in contact as all others.
    #[serde(default)]
    pub failure: Option<TieFailureInput>,
}

/// Failure of tied nodes. A node comes off its face when `(N/normal)^n + (S/shear)^m >= 1`, with
/// the tension N perpendicular to the face and the shear S along it that its tie transmits;
/// compression does not count. With a limit of 0 its term is left out.
///
/// Damage over `opening` follows: the force between node and face, which at first is that of the
/// failure, falls linearly with the distance that they part. Until then it draws them back along
/// a secant; it never pushes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TieFailureInput {
    /// Kind of the limits: `force` on each node, or `stress` [force/length^2], the force over the
    /// node's share of the tied faces at the start.
    #[serde(default)]
    pub limits: TieLimits,
    /// Limit of the tension [force], or [force/length^2] with `stress`.
    #[serde(default)]
    pub normal: f64,
    /// Limit of the shear [force], or [force/length^2] with `stress`.
    #[serde(default)]
    pub shear: f64,
    /// Exponents n and m; default 2 and 2.
    #[serde(default = "squares")]
    pub exponents: [f64; 2],
    /// Distance over which the force falls to zero after the failure [length]; 0 for at once.
    #[serde(default)]
    pub opening: f64,
}

fn squares() -> [f64; 2] {
    [2.0; 2]
}

/// Meaning of the limits of a tie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TieLimits {
    /// Force on each node.
    #[default]
    Force,
    /// Force over area.
    Stress,
}
