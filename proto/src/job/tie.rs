//! Ties as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes tied to a surface where they are at the start: each is moved onto the face that is nearest
/// to it, and from then on is carried by that face's nodes. Its mass and what acts on it go to them
/// by the shape functions, and its velocity is theirs; so neither momentum nor energy is lost, and
/// no stable step becomes shorter.
///
/// A face that a rigid body moves makes its nodes members of the body. Walls let tied nodes be and
/// stop what carries them. A node that starts with another velocity than its face gives it the
/// difference of momentum. When the element of its face fails a node is let go.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tie {
    /// Name for people.
    #[serde(default)]
    pub name: String,
    /// Node set that is tied.
    pub nodes: String,
    /// Parts whose shells and outer faces of solids carry.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Node set: the faces all of whose nodes are in it carry, of `parts` only if these are given
    /// too.
    #[serde(default)]
    pub faces: Option<String>,
    /// Id of a node that carries instead of a surface: the others have its displacements, wherever
    /// they stand, so that angular momentum is not kept.
    #[serde(default)]
    pub node: Option<u64>,
    /// How far a node may be from a face [length]; without it 0.6 of the thicknesses of both, or a
    /// twentieth of the face's shorter diagonal, whichever is more, as LS-DYNA does. What is
    /// farther off is not tied, which is told.
    #[serde(default)]
    pub tolerance: f64,
    /// Thicknesses of the nodes' side and of the faces' side that the default `tolerance` goes by;
    /// 0 for those of the parts [length].
    #[serde(default)]
    pub thicknesses: [f64; 2],
    /// Tie rotations too, to faces whose nodes turn.
    #[serde(default)]
    pub rotations: bool,
    /// Leave nodes where they are, at the end of arms that turn with the face, if its nodes turn;
    /// the faces of solids have them moved all the same. What acts on a node acts on the face with
    /// its moment.
    #[serde(default)]
    pub offset: bool,
}
