//! Rigid walls as workers know them.

use crate::ids::NodeId;
use crate::loads::Motion;
use serde::{Deserialize, Serialize};

/// A rigid wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Name for histories.
    pub name: String,
    /// A point of a plane, a corner of a rectangle, the start of a cylinder's axis, at time 0
    /// [length].
    pub point: [f64; 3],
    /// Unit normal of a plane or a rectangle, unit vector along a cylinder's axis.
    pub direction: [f64; 3],
    /// How far it reaches.
    pub form: WallForm,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Nodes that meet it, ascending; all without.
    pub nodes: Option<Vec<NodeId>>,
    /// Nodes that do not, ascending.
    pub except: Vec<NodeId>,
    /// How it moves.
    pub motion: WallMotion,
}

/// Form of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallForm {
    /// A plane without end.
    Plane,
    /// A part of a plane.
    Rectangle {
        /// Unit vector along the first side; the second side has the direction normal x edge.
        edge: [f64; 3],
        /// Lengths of the sides, 0 for one without end [length].
        lengths: [f64; 2],
    },
    /// The mantle of a cylinder.
    Cylinder {
        /// Radius [length].
        radius: f64,
        /// Length, 0 for one without end [length].
        length: f64,
    },
}

/// How a wall moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallMotion {
    /// Not at all.
    Still,
    /// As nodes push it, along its normal.
    Pushed {
        /// Mass [mass].
        mass: f64,
        /// Velocity along the normal at time 0 [length/time].
        speed: f64,
    },
    /// As prescribed; its `nodes` are empty.
    Led(Motion),
}

impl Wall {
    /// A plane that stands still and stops all nodes.
    pub fn plane(point: [f64; 3], normal: [f64; 3], friction: f64) -> Self {
        Self {
            name: String::new(),
            point,
            direction: normal,
            form: WallForm::Plane,
            friction,
            nodes: None,
            except: Vec::new(),
            motion: WallMotion::Still,
        }
    }

    /// Whether a node meets it at all.
    pub fn allows(&self, node: NodeId) -> bool {
        let within = self.nodes.as_ref().is_none_or(|nodes| nodes.binary_search(&node).is_ok());
        within && self.except.binary_search(&node).is_err()
    }
}
