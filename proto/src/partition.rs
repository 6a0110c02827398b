//! Data that a worker receives: settings for all workers, records of its elements and nodes.
//! The same records are sent at start-up and between workers when boxes are renewed.

use crate::adaptivity::AdaptivitySettings;
use crate::belt::BeltSystem;
use crate::histories::HistoryRequests;
use crate::ids::{ElemId, NodeId};
use crate::initial::InitialPoint;
use crate::job::{Compression, ContactInput, Part, Precision};
use crate::joint::ResolvedJoint;
use crate::loads::ResolvedLoads;
use crate::mesh::{CornerNodes, OwnSection, Shape};
use crate::rigid::RigidBody;
use crate::steering::{Change, OutputTimes, Planned, Steered};
use crate::tie::Tie;
use crate::wall::ResolvedWall;
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Settings of the job that all workers have. Only loaded nodes and faces, rigid bodies, ties
/// and history requests grow with the mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    /// End time of the run [time].
    pub end_time: f64,
    /// Safety factor: fraction of the smallest element step that is used.
    pub safety: f64,
    /// Largest number of cycles, 0 for no limit.
    pub max_cycles: u64,
    /// Smallest permitted ratio of the step to the first step; the run fails below it.
    pub dt_min_ratio: f64,
    /// Time between history rows [time].
    pub history_interval: f64,
    /// Times of field files, ascending [time].
    pub field_times: Vec<f64>,
    /// From what these times follow, and where the history interval was changed.
    pub output: OutputTimes,
    /// Orders with their cycles, ascending; without a pause.
    pub planned: Vec<Planned>,
    /// Histories that are recorded in addition to the sums, at every history interval.
    pub histories: HistoryRequests,
    /// Folder for field files.
    pub field_dir: String,
    /// True if field files have the contact force on each node.
    pub contact_forces: bool,
    /// Number of points through the thickness in field files; 0 for none.
    pub field_points: usize,
    /// Checkpoints.
    pub checkpoint: CheckpointSettings,
    /// Materials, in the job's order.
    pub materials: Vec<Material>,
    /// Parts in ascending id; the `part` of a record is an index into this list.
    #[serde(with = "parts_text")]
    pub parts: Vec<Part>,
    /// Indices of the parts with shells that have an offset of their own, ascending.
    pub with_own_offsets: Vec<u32>,
    /// Vectors from beams towards their second axes at the start, by ascending element id
    /// [length].
    pub axes: Vec<(ElemId, [f64; 3])>,
    /// Stress and plastic strain of elements at the start, sorted. A worker gets those of its
    /// elements, and none if the run continues from a checkpoint.
    pub initial: Vec<InitialPoint>,
    /// Indices of the parts of springs whose direction is that from one node to another, with
    /// these nodes; ascending.
    pub followed: Vec<(u32, [NodeId; 2])>,
    /// Floating-point precision of shell and solid kernels.
    pub precision: Precision,
    /// Rigid walls.
    pub walls: Vec<ResolvedWall>,
    /// Loads and prescribed motions.
    pub loads: ResolvedLoads,
    /// Rigid bodies; no two have a node in common.
    pub rigid: Vec<RigidBody>,
    /// Joints between rigid bodies.
    pub joints: Vec<ResolvedJoint>,
    /// Tied nodes, ascending.
    pub ties: Vec<Tie>,
    /// Hexahedra that fail together, ascending in each group.
    pub failure_groups: Vec<Vec<ElemId>>,
    /// Seat belts.
    pub belts: BeltSystem,
    /// Largest step [time], 0 for none.
    pub dt_max: f64,
    /// Number of cycles of an outer step; slow elements are computed in the first of them. 1 if
    /// all elements are computed in every cycle.
    pub subcycles: u64,
    /// Contact, if the model has any; default values of omitted lengths are filled in.
    #[serde(with = "contact_text")]
    pub contact: Option<ContactInput>,
    /// True if nodes can rotate, because there are shells, beams or rigid bodies. Otherwise no
    /// rotational columns are stored, migrated or sent.
    pub rotations: bool,
    /// Division of shells, if the job asks for it.
    pub adaptivity: Option<AdaptivitySettings>,
    /// Width b of the box buffer [length].
    pub buffer: f64,
    /// Number of cycles between forced redecompositions, 0 for none (for tests).
    pub force_every: u64,
    /// The workers that search for contact.
    pub contact_decomposition: ContactDecomposition,
    /// Number of threads of each worker.
    pub threads: usize,
}

/// The workers that search for contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactDecomposition {
    /// Each worker searches for the nodes, edges and segments that it owns.
    #[default]
    Boxes,
    /// A second decomposition divides the contact nodes; elements do not migrate.
    Rcb,
}

/// Settings of checkpoints.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CheckpointSettings {
    /// Folder for all checkpoints of the run.
    pub dir: String,
    /// Times after which a checkpoint is written, ascending [time].
    pub times: Vec<f64>,
    /// True if a run that is stopped writes a checkpoint.
    pub at_stop: bool,
    /// Compression of the files.
    pub compression: Compression,
    /// Time without progress of a file after which a run that ends gives it up [s].
    pub patience: f64,
}

/// Contact in messages is text, because the keys of contact laws are not fixed, and a message has
/// no names of fields. Text keeps all digits of a number.
mod contact_text {
    use super::ContactInput;
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(
        contact: &Option<ContactInput>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        let text = contact.as_ref().map(toml::to_string).transpose();
        text.map_err(S::Error::custom)?.serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<ContactInput>, D::Error> {
        let text = Option::<String>::deserialize(from)?;
        text.map(|text| toml::from_str(&text)).transpose().map_err(D::Error::custom)
    }
}

/// Parts in messages are text, one for each part, for the reason given for contact.
mod parts_text {
    use super::Part;
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(parts: &[Part], to: S) -> Result<S::Ok, S::Error> {
        let texts: Result<Vec<String>, _> = parts.iter().map(toml::to_string).collect();
        texts.map_err(S::Error::custom)?.serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Part>, D::Error> {
        let texts = Vec::<String>::deserialize(from)?;
        texts
            .iter()
            .map(|text| toml::from_str(text))
            .collect::<Result<_, _>>()
            .map_err(D::Error::custom)
    }
}

/// Cost of an element in a cycle in which it is not computed, or of a rigid one (its part of the
/// nodal update)
/// over its cost in a cycle in which it is.
const IDLE_COST: f64 = 0.25;

impl Settings {
    /// Changes a setting in a run, at the place where the order takes effect. Limits of the master
    /// are no settings of workers.
    pub fn change(&mut self, change: Change, at: &Steered) {
        match change {
            Change::EndTime(end) => self.end_time = end,
            Change::FieldInterval(interval) => self.output.field_interval = interval,
            Change::HistoryInterval(interval) => {
                self.history_interval = interval;
                self.output.change_rows(interval, at);
                return;
            }
            Change::Imbalance(_) | Change::LowEveryAtLeast(_) => return,
        }
        self.field_times = self.output.renewed(&self.field_times, at, self.end_time);
    }

    /// Returns true if a second decomposition divides the contact nodes. Elements then do not
    /// migrate.
    pub fn has_second_decomposition(&self) -> bool {
        self.contact.is_some() && self.contact_decomposition == ContactDecomposition::Rcb
    }

    /// Returns true if the elements of a part carry no force: it is rigid or has a null material.
    pub fn is_inactive(&self, part: u32) -> bool {
        let is_rigid = |body: &RigidBody| body.window.is_none() && body.parts.contains(&part);
        self.parts[part as usize].skin || self.rigid.iter().any(is_rigid)
    }

    /// Returns the mean cost of an element per cycle, over that of an element that is computed
    /// in every cycle; an estimate for the first boxes. Later ones follow from measured costs.
    pub fn load(&self, element: &ElementRecord) -> f64 {
        if self.is_inactive(element.part) {
            return IDLE_COST;
        }
        if element.slow { IDLE_COST + (1.0 - IDLE_COST) / self.subcycles as f64 } else { 1.0 }
    }
}

/// Material as workers see it: name of the law and its parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Material {
    /// Name that parts refer to.
    pub name: String,
    /// Name of the law in the worker's registry.
    pub law: String,
    /// Mass density [mass/length^3].
    pub density: f64,
    /// Parameters of the law.
    pub parameters: BTreeMap<String, Param>,
}

/// A material parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Param {
    /// One number.
    Number(f64),
    /// A list of numbers.
    List(Vec<f64>),
    /// A list of rows.
    Table(Vec<Vec<f64>>),
    /// True or false.
    Flag(bool),
}

/// Node with its complete state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct NodeRecord {
    /// Global id.
    pub id: NodeId,
    /// Constrained degrees of freedom, fixed or prescribed: bits 0..6 are x, y, z, rx, ry, rz.
    pub fixed: u64,
    /// Initial coordinates [length].
    pub x0: [f64; 3],
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Coordinates at the last classification of folded edges [length].
    pub seen: [f64; 3],
    /// Velocity at mid-step [length/time].
    pub v: [f64; 3],
    /// Rotational velocity at mid-step [1/time].
    pub w: [f64; 3],
    /// Lumped mass of elements plus added mass [mass]; before the first assembly, added mass
    /// only.
    pub mass: f64,
    /// Lumped rotational inertia [mass length^2].
    pub inertia: f64,
}

/// Element; its history columns are sent separately.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElementRecord {
    /// Global id.
    pub id: ElemId,
    /// Index into [`Settings::parts`].
    pub part: u32,
    /// Shape.
    pub shape: Shape,
    /// Corner nodes.
    pub nodes: CornerNodes,
    /// Faces of a solid that no other solid shares, one bit per face number.
    pub free_faces: u16,
    /// True if the element has failed and has left the contact surface.
    pub failed: bool,
    /// Values of a shell that replace those of its part.
    pub own: OwnSection,
    /// Factor on the density of the part, above 1 if mass scaling adds mass.
    pub mass_factor: f64,
    /// Fraction of its mass that its stable step is based on; the rest is used by springs and
    /// ties that share its nodes.
    pub share: f64,
    /// True if the element is computed in the first cycle of an outer step only, see
    /// [`Settings::subcycles`].
    pub slow: bool,
    /// Stable step, before the safety factor, of an element without a stable step of its own,
    /// from the masses of its nodes; infinite for all other elements [time].
    pub stable_dt: f64,
}
