//! Output that a job requests.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Files that are written, and their intervals.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between rows of the histories [time]; 0 for 1/200 of the run.
    pub history_interval: f64,
    /// Time between field files [time]; 0 for 1/20 of the run, negative for none.
    pub field_interval: f64,
    /// Additional times of field files [time].
    pub field_times: Vec<f64>,
    /// Write `parts.csv`: energies, mass and momentum of each part.
    pub parts: bool,
    /// Write `walls.csv` if there are rigid walls: impulse and force of each wall.
    pub walls: bool,
    /// Write `contacts.csv` and `contact_pairs.csv` if there is contact between parts: the force on
    /// each part, and between each pair of parts.
    pub contacts: bool,
    /// Also write the contact force on each node to the field files: the array `contact_force`.
    pub contact_forces: bool,
    /// Also write the stress and the plastic strain of all points through the thickness to the
    /// field files, as `stress_of_points` and `plastic_strain_of_points`: from the inner surface to
    /// the outer one. A d3plot database then has all points.
    pub points: bool,
    /// Also write strains to a d3plot database: of solids, and of shells at both surfaces.
    pub strains: bool,
    /// Also write the fields as a d3plot database, and the histories as a binout, at the end of the
    /// run.
    pub d3plot: bool,
    /// Also write the fields as one temporal VTKHDF file, at the end of the run. Needs a build with
    /// the feature `vtkhdf`.
    pub vtkhdf: bool,
    /// Also write the fields as an EXODUS II file, at the end of the run.
    pub exodus: bool,
    /// Nodes whose motion is written to `nodes.csv`.
    pub node: Vec<NodeHistory>,
    /// Sections whose force and moment are written to `sections.csv`.
    pub section: Vec<SectionHistory>,
    /// Force transducers: contact forces that are written to `transducers.csv`.
    pub transducer: Vec<TransducerHistory>,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            history_interval: 0.0,
            field_interval: 0.0,
            field_times: Vec::new(),
            parts: true,
            walls: true,
            contacts: true,
            contact_forces: false,
            points: false,
            strains: false,
            d3plot: false,
            vtkhdf: false,
            exodus: false,
            node: Vec::new(),
            section: Vec::new(),
            transducer: Vec::new(),
        }
    }
}

/// Nodes whose motion is written to `nodes.csv`: a node set, ids, or both.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeHistory {
    /// Name in the output; without it that of the node set.
    #[serde(default)]
    pub name: String,
    /// Node set.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Node ids.
    #[serde(default)]
    pub ids: Vec<u64>,
    /// Ids of three nodes. Displacement, velocity and acceleration are written in the axes of these
    /// nodes, which follow them, as an accelerometer has them: x from the first node to the second,
    /// z perpendicular to it and to the line from the first to the third. Coordinates are always
    /// global; without `axes` everything is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<[u64; 3]>,
    /// These are nodes of a head. Only such nodes have head injury criteria.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub head: bool,
}

/// Section whose force and moment are written to `sections.csv`: the forces that the elements on
/// one side of a node set exert on these nodes. The elements are those of `parts` and `elements`,
/// or those of all parts if both are empty. `side` selects those on one side.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionHistory {
    /// Name in the output; without it that of the node set.
    #[serde(default)]
    pub name: String,
    /// Node set.
    pub nodes: String,
    /// Parts whose elements are included.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Ids of elements that are included.
    #[serde(default)]
    pub elements: Vec<u64>,
    /// Direction from the mean position of the nodes. Only elements whose centre is on this side at
    /// the start are included.
    #[serde(default)]
    pub side: Option<[f64; 3]>,
}

/// Force transducer: the contact force on a surface A, from a surface B or from all bodies in
/// contact with A, is written to `transducers.csv`. A surface consists of the faces and nodes of
/// some parts, or of a node set (its nodes, and the faces whose nodes are all in it), or of the
/// intersection of both. The forces of a surface on itself cancel. For forces of rigid walls see
/// `walls.csv`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransducerHistory {
    /// Name in the output.
    #[serde(default)]
    pub name: String,
    /// Parts of surface A.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set of surface A.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Parts of surface B. Without these and `from_nodes`, all contact forces on A are included.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub from_parts: Vec<u32>,
    /// Node set of surface B.
    #[serde(default)]
    pub from_nodes: Option<String>,
}
