//! What a worker receives: settings for all, records of its elements and nodes.
//! The same records travel at start-up and from worker to worker when boxes are renewed.

use crate::histories::HistoryRequests;
use crate::ids::{ElemId, NodeId};
use crate::job::{Contact, Part, Precision};
use crate::loads::Loads;
use crate::mesh::{CornerNodes, Shape};
use crate::rigid::RigidBody;
use crate::tie::Tie;
use crate::wall::Wall;
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What every worker knows of the job; nothing in it but loaded nodes and faces, rigid bodies, ties
/// and what histories ask for grows with the mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    /// Simulated time to run to [time].
    pub end_time: f64,
    /// Fraction of the smallest element step that is used.
    pub safety: f64,
    /// Stop after this many cycles, 0 for no limit.
    pub max_cycles: u64,
    /// Stop as failed below this fraction of the first step.
    pub dt_min_ratio: f64,
    /// Time between history rows [time].
    pub history_interval: f64,
    /// Times of field files, ascending [time].
    pub field_times: Vec<f64>,
    /// What is recorded at every history interval beside the sums.
    pub histories: HistoryRequests,
    /// Folder for field files.
    pub field_dir: String,
    /// Materials, in the job's order.
    pub materials: Vec<Material>,
    /// Parts in ascending id; a record's `part` is an index into this.
    pub parts: Vec<Part>,
    /// Vectors from beams towards their second axes at the start, by ascending id [length].
    pub axes: Vec<(ElemId, [f64; 3])>,
    /// What shells and solids compute with.
    pub precision: Precision,
    /// Rigid walls.
    pub walls: Vec<Wall>,
    /// Loads and prescribed motions.
    pub loads: Loads,
    /// Rigid bodies; no two have a node in common.
    pub rigid: Vec<RigidBody>,
    /// Tied nodes, ascending.
    pub ties: Vec<Tie>,
    /// Largest step [time], 0 for none.
    pub dt_max: f64,
    /// Cycles of an outer step, in the first of which slow elements are computed; 1 if all elements
    /// always are.
    pub subcycles: u64,
    /// Contact, if the scene has any; lengths that the job left to a default are filled in.
    pub contact: Option<Contact>,
    /// Whether nodes can turn: there are shells, or rigid bodies. Without, no rotational column is
    /// kept, moved or sent.
    pub rotations: bool,
    /// Width b of the box buffer [length].
    pub buffer: f64,
    /// Ask for a redecomposition every so many cycles, 0 for never (for tests).
    pub force_every: u64,
}

/// What an element costs when it is not computed, its share of the motion of nodes, over what it
/// costs when it is.
const IDLE_COST: f64 = 0.25;

impl Settings {
    /// Mean cost of an element in a cycle, over that of one that is computed in each.
    pub fn load(&self, element: &ElementRecord) -> f64 {
        if element.slow { IDLE_COST + (1.0 - IDLE_COST) / self.subcycles as f64 } else { 1.0 }
    }
}

/// A material as a worker sees it: a law's name and a table of numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Material {
    /// Name that parts refer to.
    pub name: String,
    /// Name of the law in the worker's table.
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
}

/// A node with its whole state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct NodeRecord {
    /// Global id.
    pub id: NodeId,
    /// Bits 0..6: x, y, z, rx, ry, rz held fixed or prescribed.
    pub fixed: u64,
    /// Initial coordinates [length].
    pub x0: [f64; 3],
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Coordinates when it was last seen where surfaces are folded [length].
    pub seen: [f64; 3],
    /// Velocity at mid-step [length/time].
    pub v: [f64; 3],
    /// Rotational velocity at mid-step [1/time].
    pub w: [f64; 3],
    /// Lumped mass, elements and added mass together [mass]; before the first assembly, added mass
    /// only.
    pub mass: f64,
    /// Lumped rotational inertia [mass length^2].
    pub inertia: f64,
}

/// An element; its history columns travel beside it.
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
    /// Faces of a solid that no other solid repeats, as bits by their number.
    pub free_faces: u8,
    /// Whether it has failed and left the contact surface.
    pub failed: bool,
    /// Thickness at the start of a shell that has one of its own; 0 for that of its part [length].
    pub thickness: f64,
    /// Factor on the part's density, above 1 where mass scaling adds mass.
    pub mass_factor: f64,
    /// Fraction of its mass that its stable step counts on: springs and ties that share its nodes
    /// count on the rest.
    pub share: f64,
    /// Whether it is computed in the first cycle of an outer step only, see
    /// [`Settings::subcycles`].
    pub slow: bool,
    /// Stable step that the masses of its nodes leave an element that has none, before the safety
    /// factor; infinite for all others [time].
    pub stable_dt: f64,
}
