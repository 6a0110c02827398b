//! What a job asks to be written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is written, how often.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between rows of the histories [time]; 0 for a two-hundredth of the run.
    pub history_interval: f64,
    /// Time between field files [time]; 0 for a twentieth of the run, negative for none.
    pub field_interval: f64,
    /// Further times of field files [time].
    pub field_times: Vec<f64>,
    /// Write `parts.csv`: energies, mass and momentum of each part.
    pub parts: bool,
    /// Write `walls.csv`, where there are rigid walls: impulse and force of each.
    pub walls: bool,
    /// Write `contacts.csv` and `contact_pairs.csv`, where there is contact between parts: the
    /// force on each part, and between each two.
    pub contacts: bool,
    /// Write the fields as a d3plot database too, when the run is over.
    pub d3plot: bool,
    /// Write the fields as one temporal VTKHDF file too, when the run is over; needs a build with
    /// the feature `vtkhdf`.
    pub vtkhdf: bool,
    /// Nodes whose motion is written to `nodes.csv`.
    pub node: Vec<NodeHistory>,
    /// Sections whose force and moment are written to `sections.csv`.
    pub section: Vec<SectionHistory>,
    /// Force transducers, whose contact forces are written to `transducers.csv`.
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
            d3plot: false,
            vtkhdf: false,
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
    /// Name for people; the node set's without it.
    #[serde(default)]
    pub name: String,
    /// Node set.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Node ids.
    #[serde(default)]
    pub ids: Vec<u64>,
}

/// A section whose force and moment are written to `sections.csv`: what elements on one side of a
/// node set put on these nodes. The elements are those of `parts` and `elements`, or of any part;
/// `side` takes those of one side of them.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionHistory {
    /// Name for people; the node set's without it.
    #[serde(default)]
    pub name: String,
    /// Node set.
    pub nodes: String,
    /// Parts whose elements count.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Ids of elements that count.
    #[serde(default)]
    pub elements: Vec<u64>,
    /// Direction from the middle of the nodes: only elements whose centre lies to this side of it
    /// at the start count.
    #[serde(default)]
    pub side: Option<[f64; 3]>,
}

/// A force transducer: the contact force on a surface A, from a surface B or from all that touches
/// it, is written to `transducers.csv`. A surface is the faces and nodes of some parts, or of a
/// node set (its nodes, and the faces all of whose nodes are in it), or what both have in common.
/// What a surface exerts on itself cancels. Rigid walls are in `walls.csv`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransducerHistory {
    /// Name for people.
    #[serde(default)]
    pub name: String,
    /// Parts of surface A.
    #[serde(default)]
    pub parts: Vec<u32>,
    /// Node set of surface A.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Parts of surface B; without these and `from_nodes` all that touches A counts.
    #[serde(default)]
    pub from_parts: Vec<u32>,
    /// Node set of surface B.
    #[serde(default)]
    pub from_nodes: Option<String>,
}
