//! Rigid walls for workers.

use crate::ids::NodeId;
use crate::loads::PrescribedMotion;
use serde::{Deserialize, Serialize};

/// Rigid wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResolvedWall {
    /// Name in histories.
    pub name: String,
    /// Point of a plane, corner of a rectangle, start of a cylinder's axis or centre of a sphere,
    /// at time 0 [length].
    pub point: [f64; 3],
    /// Unit normal of a plane or rectangle, unit vector along the axis of a cylinder, any unit
    /// vector of a sphere.
    pub direction: [f64; 3],
    /// Shape and size.
    pub form: WallForm,
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Nodes that the wall acts on, ascending; all nodes if `None`.
    pub nodes: Option<Vec<NodeId>>,
    /// Nodes that the wall ignores, ascending.
    pub except: Vec<NodeId>,
    /// Motion of the wall.
    pub motion: WallMotion,
    /// Times at which it begins and ceases to stop nodes [time]; `None` for the whole run. It moves
    /// at all times.
    pub window: Option<[f64; 2]>,
}

/// Shape of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallForm {
    /// Infinite plane.
    Plane,
    /// Part of a plane.
    Rectangle {
        /// Unit vector along the first side; the second side has the direction normal x edge.
        edge: [f64; 3],
        /// Lengths of the sides, 0 if infinite [length].
        lengths: [f64; 2],
    },
    /// Lateral surface of a cylinder.
    Cylinder {
        /// Radius [length].
        radius: f64,
        /// Length, 0 if infinite [length].
        length: f64,
    },
    /// Surface of a sphere.
    Sphere {
        /// Radius [length].
        radius: f64,
    },
}

/// Motion of a wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallMotion {
    /// At rest.
    Still,
    /// Moved along its normal by the impulses of nodes.
    Pushed {
        /// Mass [mass].
        mass: f64,
        /// Velocity along the normal at time 0 [length/time].
        speed: f64,
    },
    /// Prescribed; its `nodes` are empty.
    Led(PrescribedMotion),
}

impl ResolvedWall {
    /// Returns the name in histories: its own, or its number in the list of all walls.
    pub fn label(&self, number: usize) -> String {
        if self.name.is_empty() { format!("wall {number}") } else { self.name.clone() }
    }

    /// Returns a plane at rest that acts on all nodes.
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
            window: None,
        }
    }

    /// Returns true if the wall stops nodes in a step that starts at `time`.
    pub fn acts_at(&self, time: f64) -> bool {
        self.window.is_none_or(|[birth, death]| birth <= time && time < death)
    }

    /// Adds a new node to the nodes that the wall acts on, and to those that it ignores, if all
    /// nodes between which it lies are among them.
    pub fn inherit(&mut self, new: NodeId, between: &[NodeId]) {
        for list in self.nodes.iter_mut().chain([&mut self.except]) {
            let has = |id: &NodeId| list.binary_search(id);
            if let (true, Err(at)) = (between.iter().all(|id| has(id).is_ok()), has(&new)) {
                list.insert(at, new);
            }
        }
    }

    /// Returns true if the wall acts on the node.
    pub fn allows(&self, node: NodeId) -> bool {
        let within = self.nodes.as_ref().is_none_or(|nodes| nodes.binary_search(&node).is_ok());
        within && self.except.binary_search(&node).is_err()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_between_nodes_of_a_set_belongs_to_it() {
        let ids = |list: &[u64]| list.iter().copied().map(NodeId).collect::<Vec<_>>();
        let plane = ResolvedWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0);
        let mut wall =
            ResolvedWall { nodes: Some(ids(&[1, 2, 9])), except: ids(&[4, 5]), ..plane.clone() };
        wall.inherit(NodeId(20), &ids(&[1, 2]));
        wall.inherit(NodeId(21), &ids(&[1, 3]));
        wall.inherit(NodeId(22), &ids(&[20, 9]));
        wall.inherit(NodeId(23), &ids(&[4, 5]));
        assert_eq!(wall.nodes, Some(ids(&[1, 2, 9, 20, 22])));
        assert_eq!(wall.except, ids(&[4, 5, 23]));
        let mut of_all = plane;
        of_all.inherit(NodeId(20), &ids(&[1, 2]));
        assert!(of_all.allows(NodeId(20)) && of_all.nodes.is_none() && of_all.except.is_empty());
    }
}
