//! Discrete springs and dampers in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Properties of a part of springs and dampers; its elements are the rows of `mesh.springs`. The
/// force is the sum of a function of the elongation and a function of its rate. It acts along the
/// line between the two nodes; tension is positive.
///
/// A rotational spring (`rotational`) has a moment instead of a force, an angle in radians instead
/// of an elongation, and acts about the line or the direction.
///
/// Springs have no mass, so a free node at their end needs some mass. To connect a node to the
/// ground, use as second node one that a `[[fix]]` fixes in x, y and z; it needs no mass.
///
/// Instead of `stiffness` or `force_elongation` one of `elastoplastic`, `hysteresis`, `one_sided`
/// and `maxwell` gives the function of the elongation a memory. In a rotational spring their
/// forces are moments, their elongations angles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringInput {
    /// Stiffness [force/length].
    #[serde(default)]
    pub stiffness: f64,
    /// Force as a function of the elongation since the start, instead of `stiffness`: points
    /// `[elongation, force]` with ascending elongations. Outside its range it continues with its
    /// first and last slope [length, force].
    #[serde(default)]
    pub force_elongation: Vec<[f64; 2]>,
    /// Damping [force time/length].
    #[serde(default)]
    pub damping: f64,
    /// Force as a function of the rate of elongation, instead of `damping`, in the same form
    /// [length/time, force].
    #[serde(default)]
    pub force_rate: Vec<[f64; 2]>,
    /// True for a moment about the line or the direction, by the relative rotation of the second
    /// node against the first; both have to be nodes of rigid bodies, or fixed in all rotations.
    /// Stiffness and damping are then moments per angle and per rate.
    #[serde(default)]
    pub rotational: bool,
    /// Fixed direction of the force. The elongation is then the relative displacement in this
    /// direction, of the second node against the first. Springs of zero length need it.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
    /// Ids of two nodes: the direction is that from the first to the second one at each time,
    /// instead of a fixed one. Their motion changes it without a force on them, so they should be
    /// far from each other, and best nodes of a rigid body.
    #[serde(default)]
    pub direction_nodes: Option<[u64; 2]>,
    /// Makes the force act along the line between the two nodes of a spring, projected onto the
    /// plane normal to the direction, instead of along the direction.
    #[serde(default)]
    pub projected: bool,
    /// Bilinear plasticity.
    #[serde(default)]
    pub elastoplastic: Option<ElastoplasticSpring>,
    /// Different curves for loading and unloading.
    #[serde(default)]
    pub hysteresis: Option<HysteresisSpring>,
    /// Tension or compression only, with plastic elongation.
    #[serde(default)]
    pub one_sided: Option<OneSidedSpring>,
    /// A stiffness that relaxes.
    #[serde(default)]
    pub maxwell: Option<MaxwellSpring>,
}

/// Spring that yields at a force and hardens: its yield force grows alike in tension and
/// compression (isotropic hardening).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElastoplasticSpring {
    /// Elastic stiffness [force/length].
    pub stiffness: f64,
    /// Slope of the force over the elongation while it yields [force/length]; 0 (default) without
    /// hardening, below `stiffness`.
    #[serde(default)]
    pub tangent_stiffness: f64,
    /// Force at which it yields first [force].
    pub yield_force: f64,
}

/// Spring that follows one curve when its elongation grows further than before, and another one
/// otherwise. Both continue with their first and last slope. At equal forces the unloading curve
/// has to be at least as steep as the loading curve, because the spring would otherwise give back
/// more energy than it took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HysteresisSpring {
    /// Force over elongation of loading, tension and compression: points `[elongation, force]`
    /// with ascending elongations, through [0, 0] [length, force].
    pub loading: Vec<[f64; 2]>,
    /// Force over elongation of unloading, in the same form. Both numbers ascend; the origin of
    /// its elongation has no meaning, as the curve is shifted along the elongation to the point
    /// where unloading begins [length, force].
    pub unloading: Vec<[f64; 2]>,
    /// Effect of yielding in tension on compression, and the reverse.
    #[serde(default)]
    pub hardening: SpringHardening,
    /// Forces of first yield in compression and in tension, such as `[-2.0, 3.0]`, with isotropic
    /// hardening only [force]. Between them a spring that has not yielded follows its loading curve
    /// in both directions.
    #[serde(default)]
    pub yield_forces: Option<[f64; 2]>,
}

/// Effect of yielding of a spring in tension on compression, and the reverse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpringHardening {
    /// Nothing: tension and compression each continue at the point of the loading curve that they
    /// have reached. The curve may fall.
    #[default]
    Independent,
    /// The yield forces of both are at least as large as the largest force so far. The curve may
    /// not fall.
    Isotropic,
}

/// Spring that carries tension only or compression only, and keeps a part of its elongation when
/// it is unloaded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OneSidedSpring {
    /// Force over elongation, both positive also for compression: points that begin with [0, 0]
    /// [length, force]. The curve continues with its last slope.
    pub loading: Vec<[f64; 2]>,
    /// Stiffness of unloading [force/length]; the largest slope of `loading` if that is larger.
    #[serde(default)]
    pub unloading_stiffness: f64,
    /// Force that it carries.
    pub carries: SpringSide,
}

/// The force that a one-sided spring carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpringSide {
    /// Tension only.
    Tension,
    /// Compression only.
    Compression,
}

/// Spring whose stiffness relaxes from a short-time value to a long-time value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaxwellSpring {
    /// Stiffness against sudden elongation [force/length].
    pub short_time_stiffness: f64,
    /// Stiffness that remains [force/length].
    #[serde(default)]
    pub long_time_stiffness: f64,
    /// Rate of relaxation [1/time].
    pub decay: f64,
    /// True if the stiffness decays with the time since the start of the run, also without
    /// elongation. Otherwise (default) each increment of the elongation begins to relax when it
    /// occurs.
    #[serde(default)]
    pub ageing: bool,
    /// Time from which on the force is `cutoff_force` [time].
    #[serde(default)]
    pub cutoff_time: Option<f64>,
    /// Force after `cutoff_time`, tension positive [force].
    #[serde(default)]
    pub cutoff_force: f64,
}
