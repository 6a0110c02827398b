//! Mesh files that a job adds to its mesh.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Mesh file that is added to the mesh of the job. Its ids are increased, so that they are those of
/// no other mesh; then it is scaled, turned and moved, in this order.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AddedMeshInput {
    /// Mesh file in the folder of the job, in any format that `mesh.file` reads.
    pub file: String,
    /// Begin of the names of its node sets that are names in another mesh too: such a set becomes
    /// `NAME.SET`. Default: the name of the file without its ending.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Number that is added to the ids of its parts. Default: the next multiple of 1000 above the
    /// ids of the parts of the meshes before; `crumple check` prints it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part_offset: Option<u32>,
    /// Number that is added to the ids of its nodes and elements. Default: the next multiple of
    /// 1,000,000 above the ids of the meshes before; `crumple check` prints it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id_offset: Option<u64>,
    /// Factor on the lengths of its file, such as 0.001 for a file in mm in a job in m. Thicknesses
    /// of single shells in the file are among them.
    #[serde(default = "unchanged")]
    pub scale: f64,
    /// Rotation, after `scale`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<RotationInput>,
    /// Displacement, after `scale` and `rotate` [length].
    #[serde(default, rename = "move")]
    pub shift: [f64; 3],
    /// Thicknesses of single shells as `[id, thickness]` [length], in place of those of the file or
    /// of their part. Ids are those of the file, without `id_offset`; `scale` does not apply.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thicknesses: Vec<[f64; 2]>,
    /// Offsets of single shells as `[id, offset]`, over half the thickness as `part.offset`, in
    /// place of those of the file or of their part. Ids are those of the file, without `id_offset`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub offsets: Vec<[f64; 2]>,
    /// Angles of single shells as `[id, angle]`, as in `[mesh]` [degrees]. Ids are those of the
    /// file, without `id_offset`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub angles: Vec<[f64; 2]>,
}

/// Returns the factor that changes no length.
fn unchanged() -> f64 {
    1.0
}

/// Rotation about a line, by the right-hand rule.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationInput {
    /// Direction of the line; it is normalised.
    pub axis: [f64; 3],
    /// Angle in degrees. Multiples of 90 are exact.
    pub angle: f64,
    /// Point on the line [length].
    #[serde(default)]
    pub point: [f64; 3],
}
