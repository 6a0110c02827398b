//! Node sets that a rule defines, in a job.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Node set by a rule: all nodes of the mesh at time 0, or those of `of`, that fit the rule. Every
/// key that takes a node set takes its name, and the name of a part or of a rigid body too; if
/// nothing has this name, the id of a part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetInput {
    /// Name. No other set, part or rigid body has it.
    pub name: String,
    /// Rule that the nodes fit.
    pub rule: SetRule,
    /// Set, part or rigid body of which the rule takes nodes; without it the whole mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// Sets, parts or rigid bodies that `union`, `intersection` and `difference` combine.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<String>,
    /// Parts of `part`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node ids of `nodes`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ids: Vec<u64>,
    /// Smallest coordinates of a box [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<[f64; 3]>,
    /// Largest coordinates of a box [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<[f64; 3]>,
    /// Centre of a sphere, point on a plane, start of the axis of a cylinder, or the point that
    /// `nearest` looks from [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Normal of a plane or a half space; it is normalised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Direction of the axis of a cylinder; it is normalised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Radius of a sphere or a cylinder [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Length of a cylinder from `point` along its axis [length]; without it the cylinder is
    /// infinite in both directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Number of nodes of `nearest`; without it 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// Set, part or rigid body from whose nodes `within` measures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Largest distance of `within` [length].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// Distance outside of a box, sphere, plane, half space or cylinder up to which a node counts
    /// as inside [length]; without it a thousandth of the shortest side of an element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Let the set be empty. Other sets may use it then; a key that needs nodes still reports it.
    #[serde(default)]
    pub allow_empty: bool,
}

/// Rule of a node set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SetRule {
    /// Nodes of `parts`.
    #[default]
    Part,
    /// Nodes with these `ids`.
    Nodes,
    /// Nodes from `min` to `max`.
    Box,
    /// Nodes up to `radius` from `point`.
    Sphere,
    /// Nodes on the plane through `point` with this `normal`.
    Plane,
    /// Nodes on the plane through `point`, and on the side to which `normal` points.
    HalfSpace,
    /// Nodes up to `radius` from the line from `point` along `axis`, over a `length`.
    Cylinder,
    /// The `count` nodes nearest to `point`; of several at the same distance those with the lowest
    /// ids.
    Nearest,
    /// Nodes of the edges of shells that no other shell of the mesh has.
    FreeEdges,
    /// Nodes of the edges of shells, and of the faces of solids, that no other element of `of` has.
    Boundary,
    /// Nodes of shells, and of the faces of solids that no other solid of the mesh has.
    Surface,
    /// Nodes up to `distance` from the nearest node of `from`, with the nodes of `from`.
    Within,
    /// Nodes in any of `sets`.
    Union,
    /// Nodes in all of `sets`.
    Intersection,
    /// Nodes of the first of `sets` that are in none of the others.
    Difference,
}
