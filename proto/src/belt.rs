//! Seat belts for workers: paths of segments over nodes, rings, retractors and their sensors.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// All seat belts of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeltSystem {
    /// Laws of the segments.
    pub laws: Vec<BeltLaw>,
    /// Paths; no two have an element in common.
    pub paths: Vec<BeltPath>,
    /// Slip rings.
    pub rings: Vec<SlipRing>,
    /// Retractors.
    pub retractors: Vec<Retractor>,
    /// Pretensioners; no retractor has two.
    pub pretensioners: Vec<Pretensioner>,
    /// Sensors.
    pub sensors: Vec<BeltSensor>,
}

/// Properties of a part of belts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeltLaw {
    /// Points `[strain, force]`, from [0, 0] on [1, force].
    pub loading: Vec<[f64; 2]>,
    /// The same for unloading; empty if it is as loading.
    pub unloading: Vec<[f64; 2]>,
    /// Force per rate of the strain [force time].
    pub damping: f64,
    /// Smallest unstretched length [length].
    pub min_length: f64,
}

/// Belt from one end to another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeltPath {
    /// Nodes in their order at the start; rings and retractors are among them.
    pub nodes: Vec<NodeId>,
    /// For each node, true if it may pass a ring or go into a retractor: it has a mass, belongs to
    /// this belt only, and nothing else moves it.
    pub loose: Vec<bool>,
    /// Segments between the nodes.
    pub segments: Vec<BeltSegment>,
}

/// Segment of a belt at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeltSegment {
    /// Its element.
    pub element: ElemId,
    /// Index of its law; the same for all segments of a path with rings or retractors.
    pub law: usize,
    /// Unstretched length [length].
    pub length: f64,
}

/// Slip ring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlipRing {
    /// Name for output.
    pub name: String,
    /// Its node.
    pub node: NodeId,
    /// Index of its path.
    pub path: usize,
    /// Coefficients of friction: of fast slip, at rest.
    pub friction: [f64; 2],
    /// Decay of the coefficient with the rate of the slip [time/length].
    pub decay: f64,
    /// Time from which on it is locked, infinite for never [time].
    pub lock_time: f64,
}

/// Retractor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Retractor {
    /// Name for output.
    pub name: String,
    /// Its node.
    pub node: NodeId,
    /// Index of its path.
    pub path: usize,
    /// True if what comes before its node in the path is wound up, false for what comes after it.
    pub before: bool,
    /// Indices of the sensors that lock it.
    pub sensors: Vec<usize>,
    /// Time from the sensor on [time].
    pub delay: f64,
    /// Pull-out after that until it locks [length].
    pub pull_out: f64,
    /// Points `[pull-out, force]` from pull-out 0 on [length, force].
    pub loading: Vec<[f64; 2]>,
    /// Points for unloading, from [0, 0] on; empty if it is as loading.
    pub unloading: Vec<[f64; 2]>,
    /// Length of the segment next to it beyond which a wound up node comes out [length].
    pub fed_length: f64,
}

/// Pretensioner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pretensioner {
    /// Index of its retractor.
    pub retractor: usize,
    /// Indices of its sensors.
    pub sensors: Vec<usize>,
    /// Time from the sensor on [time].
    pub delay: f64,
    /// Points `[time, length]` from [0, 0] on [time, length].
    pub pull_in: Vec<[f64; 2]>,
    /// Largest tension at which it pulls; infinite without a limit [force].
    pub force_limit: f64,
}

/// Sensor; it is triggered by the first of these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum BeltSensor {
    /// A time has come [time].
    Time(f64),
    /// A node has had an acceleration above the limit for a time.
    Acceleration {
        /// The node.
        node: NodeId,
        /// Unit vector.
        direction: [f64; 3],
        /// Limit [length/time^2].
        limit: f64,
        /// Time [time].
        duration: f64,
    },
    /// The belt has come out of a retractor with a rate above the limit for a time.
    PullOutRate {
        /// Index of the retractor.
        retractor: usize,
        /// Limit [length/time].
        limit: f64,
        /// Time [time].
        duration: f64,
    },
    /// The distance of two nodes is outside of the limits [length].
    Distance {
        /// The nodes.
        nodes: [NodeId; 2],
        /// Smallest and largest distance [length].
        limits: [f64; 2],
    },
}

impl BeltSystem {
    /// Returns true if there are no belts.
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Returns all nodes of belts and sensors, ascending.
    pub fn nodes(&self) -> Vec<NodeId> {
        let of_sensors = self.sensors.iter().flat_map(|sensor| match sensor {
            BeltSensor::Acceleration { node, .. } => vec![*node],
            BeltSensor::Distance { nodes, .. } => nodes.to_vec(),
            BeltSensor::Time(_) | BeltSensor::PullOutRate { .. } => Vec::new(),
        });
        let of_paths = self.paths.iter().flat_map(|path| path.nodes.iter().copied());
        let mut nodes: Vec<NodeId> = of_paths.chain(of_sensors).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the names of the rows of `belts.csv`: segments by their elements, rings, retractors.
    pub fn names(&self) -> Vec<String> {
        let segments = self.paths.iter().flat_map(|path| &path.segments);
        let segments = segments.map(|segment| format!("element {}", segment.element));
        let rings = self.rings.iter().map(|ring| format!("ring {}", ring.name));
        let retractors = self.retractors.iter().map(|r| format!("retractor {}", r.name));
        segments.chain(rings).chain(retractors).collect()
    }
}
