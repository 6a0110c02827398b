//! Seat belts in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Properties of a part of seat belts; its elements are the rows of `mesh.springs`. Elements that
/// share nodes form the paths of belts. A belt has tension along the line between its nodes and
/// nothing else: it takes no part in contact. At the nodes of `[[belts.ring]]` it slides, at those
/// of `[[belts.retractor]]` it is wound up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeltInput {
    /// Tension over the engineering strain `length / unstretched length - 1`: points
    /// `[strain, force]` that begin with [0, 0]. The force may not fall; beyond the last point it
    /// continues with the last slope. A belt that is shorter carries nothing [1, force].
    pub force_strain: Vec<[f64; 2]>,
    /// Tension over the strain when the belt is unloaded from beyond the second point of
    /// `force_strain`, in the same form; both numbers ascend. The curve is shifted along the strain
    /// to the largest strain so far, and has to be at least as steep as `force_strain` at the same
    /// force. Up to that point, and without this curve, the belt is elastic [1, force].
    #[serde(default)]
    pub unloading: Vec<[f64; 2]>,
    /// Mass per unstretched length; each element gives half of it to each of its nodes, where it
    /// stays [mass/length].
    pub mass_per_length: f64,
    /// Unstretched length down to which a ring or a retractor takes belt from an element; then its
    /// node passes. The stable step is that of elements of this length [length].
    pub min_length: f64,
    /// Tension per rate of the strain, in belts under tension [force time].
    #[serde(default)]
    pub damping: f64,
}

/// Devices of seat belts, and the lengths of their elements. The belts themselves are the elements
/// of parts with `[part.belt]`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeltsInput {
    /// Unstretched lengths of single elements as `[id, length]`; all others have the distance of
    /// their nodes [length].
    #[serde(default)]
    pub unstretched: Vec<[f64; 2]>,
    /// Slip rings.
    #[serde(default)]
    pub ring: Vec<SlipRingInput>,
    /// Retractors.
    #[serde(default)]
    pub retractor: Vec<RetractorInput>,
    /// Pretensioners.
    #[serde(default)]
    pub pretensioner: Vec<PretensionerInput>,
    /// Sensors of retractors and pretensioners.
    #[serde(default)]
    pub sensor: Vec<BeltSensorInput>,
}

/// Slip ring: a node of a belt through which the belt slides. The tensions on both sides have at
/// most the ratio `exp(friction * angle)`, with the angle by which the belt turns there; otherwise
/// belt moves to the side with the larger tension. The node belongs to the structure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlipRingInput {
    /// Name for output.
    pub name: String,
    /// Id of the node, between two elements of the belt.
    pub node: u64,
    /// Coefficient of friction; with `static_friction` that of fast slip.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of friction at rest; without it `friction`. At the rate v of the slip it is
    /// `friction + (static_friction - friction) * exp(-decay * |v|)`.
    #[serde(default)]
    pub static_friction: Option<f64>,
    /// Decay of the coefficient with the rate of the slip [time/length].
    #[serde(default)]
    pub decay: f64,
    /// Time from which on the belt does not slide any more [time].
    #[serde(default)]
    pub lock_time: Option<f64>,
}

/// Retractor: a node at which a belt is wound up. Until it locks, the belt has a constant tension
/// there. It locks after one of its sensors has been triggered, then `delay` has passed, then
/// `pull_out` of belt has been pulled out; without sensors never. Then `force_pull_out` gives the
/// tension; it begins where it has the tension of this time.
///
/// At its node the belt ends, or continues with elements of zero length, which are wound up: they
/// come out one by one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RetractorInput {
    /// Name for output.
    pub name: String,
    /// Id of the node.
    pub node: u64,
    /// Names of sensors that lock it.
    #[serde(default)]
    pub sensors: Vec<String>,
    /// Time from the sensor on until it can lock [time].
    #[serde(default)]
    pub delay: f64,
    /// Pull-out after this time until it locks [length].
    #[serde(default)]
    pub pull_out: f64,
    /// Tension over the pull-out: points `[pull-out, force]` from pull-out 0 on. The force may not
    /// fall; beyond the last point it continues with the last slope. The first force is the tension
    /// until it locks, and the smallest one after that [length, force].
    pub force_pull_out: Vec<[f64; 2]>,
    /// Tension when belt goes back: points `[pull-out, force]` that begin with [0, 0]; both numbers
    /// ascend. The curve is shifted to the largest pull-out so far. Without it the way back is that
    /// of `force_pull_out` [length, force].
    #[serde(default)]
    pub unloading: Vec<[f64; 2]>,
    /// Unstretched length of the element at the retractor beyond which a wound up one follows;
    /// without it twice the `min_length` of the belt, or the length of this element at the start if
    /// that is larger [length].
    #[serde(default)]
    pub fed_length: Option<f64>,
}

/// Pretensioner: it pulls belt into a retractor, from `delay` after one of its sensors has been
/// triggered until the end of its curve. Meanwhile no belt comes out, and then the retractor is
/// locked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PretensionerInput {
    /// Name for messages.
    pub name: String,
    /// Name of the retractor.
    pub retractor: String,
    /// Names of sensors that fire it.
    pub sensors: Vec<String>,
    /// Time from the sensor on until it fires [time].
    #[serde(default)]
    pub delay: f64,
    /// Length of belt that is pulled in, over the time since it has fired: points `[time, length]`
    /// that begin with [0, 0]. The length may not fall [time, length].
    pub pull_in: Vec<[f64; 2]>,
    /// Tension from which on it pulls nothing in; without it there is no limit [force].
    #[serde(default)]
    pub force_limit: Option<f64>,
}

/// Sensor: exactly one of `time`, `acceleration`, `pull_out_rate`, and `nodes` with `min_distance`
/// or `max_distance`. Once triggered it remains so.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeltSensorInput {
    /// Name to which retractors and pretensioners refer.
    pub name: String,
    /// Time at which it is triggered [time].
    #[serde(default)]
    pub time: Option<f64>,
    /// Acceleration of `node` along `direction`, in this sense, above which it is triggered
    /// [length/time^2].
    #[serde(default)]
    pub acceleration: Option<f64>,
    /// Id of the node of `acceleration`, of any element.
    #[serde(default)]
    pub node: Option<u64>,
    /// Direction of `acceleration`.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
    /// Rate of the pull-out of `retractor` above which it is triggered [length/time].
    #[serde(default)]
    pub pull_out_rate: Option<f64>,
    /// Name of the retractor of `pull_out_rate`.
    #[serde(default)]
    pub retractor: Option<String>,
    /// Time for which acceleration or rate have to be above their limit without a break [time].
    #[serde(default)]
    pub duration: f64,
    /// Ids of two nodes whose distance triggers it.
    #[serde(default)]
    pub nodes: Option<[u64; 2]>,
    /// Distance above which it is triggered [length].
    #[serde(default)]
    pub max_distance: Option<f64>,
    /// Distance below which it is triggered [length].
    #[serde(default)]
    pub min_distance: Option<f64>,
}
