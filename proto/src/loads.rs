//! Loads and prescribed motion for workers, with names resolved to indices and sets to ids.

use crate::airbag::ResolvedAirbag;
use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// All external loads and motions of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResolvedLoads {
    /// Points `[time, factor]` of each curve, times ascending [time, 1].
    pub curves: Vec<Vec<[f64; 2]>>,
    /// Body loads.
    pub gravity: Vec<Gravity>,
    /// Nodal forces.
    pub forces: Vec<NodalForce>,
    /// Pressures.
    pub pressures: Vec<Pressure>,
    /// Airbags.
    pub airbags: Vec<ResolvedAirbag>,
    /// Prescribed motions; no two have a degree of freedom in common.
    pub motions: Vec<PrescribedMotion>,
    /// Mass-proportional damping [1/time], 0 for none.
    pub damping: f64,
    /// Index of the curve of the factor on `damping` [1]; without one it is 1.
    pub damping_curve: Option<usize>,
    /// Damping of parts.
    pub part_damping: Vec<PartDamping>,
    /// Dampers at nodes of boundaries that let waves out, in ascending id.
    pub absorbers: Vec<Absorber>,
}

/// Dampers between a node and the space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Absorber {
    /// Node.
    pub node: NodeId,
    /// Symmetric matrix, xx, yy, zz, xy, yz, zx: the force is minus its product with the velocity
    /// [mass/time].
    pub damping: [f64; 6],
}

/// Body load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gravity {
    /// Acceleration [length/time^2].
    pub acceleration: [f64; 3],
    /// Index of its curve; constant if `None`.
    pub curve: Option<usize>,
    /// Nodes on which it acts, ascending, with the fraction of their mass; all nodes if `None`.
    pub shares: Option<Vec<(NodeId, f64)>>,
}

/// Damping of parts in proportion to their masses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartDamping {
    /// Coefficient [1/time].
    pub coefficient: f64,
    /// Index of its curve; constant if `None`.
    pub curve: Option<usize>,
    /// Nodes outside of rigid bodies on which it acts, ascending, with the fraction of their mass.
    pub shares: Vec<(NodeId, f64)>,
    /// The same for members of rigid bodies.
    pub members: Vec<(NodeId, f64)>,
}

/// Force and moment on each of a set of nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodalForce {
    /// Nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Force on each node [force].
    pub force: [f64; 3],
    /// Moment on each node [force length].
    pub moment: [f64; 3],
    /// Index of its curve; constant if `None`.
    pub curve: Option<usize>,
}

/// Pressure on faces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressure {
    /// Faces as (element, index into [`crate::mesh::Shape::faces`]), ascending.
    pub faces: Vec<(ElemId, u8)>,
    /// Pressure, positive against the face's normal [force/length^2]; with `blast` a factor on its
    /// pressure.
    pub pressure: f64,
    /// Index of its curve; constant if `None`.
    pub curve: Option<usize>,
    /// Explosion that gives the pressure.
    pub blast: Option<Blast>,
}

/// Explosion of a charge of TNT.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blast {
    /// Mass of the charge [kg].
    pub mass: f64,
    /// Its position [length].
    pub position: [f64; 3],
    /// Time of the explosion [time].
    pub time: f64,
    /// True if it is on the ground, false if it is in free air.
    pub on_ground: bool,
    /// True if the pressure below that of the air counts.
    pub suction: bool,
    /// Units of length, time and pressure in m, s and Pa.
    pub si: [f64; 3],
}

impl Pressure {
    /// Returns the loaded faces of an element, as indices into [`crate::mesh::Shape::faces`].
    pub fn faces_of(&self, element: ElemId) -> impl Iterator<Item = u8> {
        let first = self.faces.partition_point(|f| f.0 < element);
        self.faces[first..].iter().take_while(move |f| f.0 == element).map(|f| f.1)
    }
}

/// Prescribed motion. The records of its nodes have its degrees of freedom as constrained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrescribedMotion {
    /// Nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Prescribed degrees of freedom: bits 0..6 are x, y, z, rx, ry, rz.
    pub dofs: u64,
    /// Quantity that `amount` is.
    pub form: MotionForm,
    /// Displacement, velocity, acceleration, rotational velocity or rotation, multiplied by the
    /// curve.
    pub amount: [f64; 3],
    /// Index of its curve; constant if `None`.
    pub curve: Option<usize>,
    /// Times of its begin and end [time]; it acts in the whole run if `None`. Outside of this
    /// window its degrees of freedom are free.
    pub window: Option<[f64; 2]>,
}

impl PrescribedMotion {
    /// Returns true if it acts in a step that starts at `time`.
    pub fn acts_at(&self, time: f64) -> bool {
        self.window.is_none_or(|[begin, end]| begin <= time && time < end)
    }
}

/// Quantity that a motion prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MotionForm {
    /// Displacement [length].
    Displacement,
    /// Velocity [length/time].
    Velocity,
    /// Acceleration, starting at rest [length/time^2].
    Acceleration,
    /// Rotational velocity about an axis through `centre` [1/time].
    Spin {
        /// Point on the axis [length].
        centre: [f64; 3],
    },
    /// Rotation about an axis through `centre` [rad].
    Rotation {
        /// Point on the axis [length].
        centre: [f64; 3],
    },
}

impl MotionForm {
    /// Returns the point on the axis of a rotation; `None` for a translation.
    pub fn centre(self) -> Option<[f64; 3]> {
        match self {
            Self::Spin { centre } | Self::Rotation { centre } => Some(centre),
            Self::Displacement | Self::Velocity | Self::Acceleration => None,
        }
    }

    /// Returns true if the curve is that of the place, not of its derivatives.
    pub fn is_place(self) -> bool {
        matches!(self, Self::Displacement | Self::Rotation { .. })
    }
}

impl ResolvedLoads {
    /// Returns true if a pressure or an airbag acts on a face of an element.
    pub fn presses(&self, element: ElemId) -> bool {
        self.pressures.iter().any(|p| p.faces_of(element).next().is_some())
            || self.airbags.iter().any(|bag| bag.faces_of(element).next().is_some())
    }

    /// Returns true if there is any load or prescribed motion.
    pub fn act(&self) -> bool {
        !(self.gravity.is_empty()
            && self.forces.is_empty()
            && self.pressures.is_empty()
            && self.airbags.is_empty()
            && self.motions.is_empty())
    }
}
