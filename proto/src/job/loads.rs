//! Loads and prescribed motions in a job.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Factor as a function of time, which loads and motions refer to by name. It is linear between its
/// points and constant outside.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveInput {
    /// Name that loads and motions refer to.
    pub name: String,
    /// Points `[time, factor]` with ascending times.
    pub points: Vec<[f64; 2]>,
}

/// Gravity, or another body force, on the whole model or on some parts or nodes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravityInput {
    /// Acceleration of free fall [length/time^2].
    pub acceleration: [f64; 3],
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Parts on whose elements it acts, with their masses, those of mass scaling included; all
    /// masses if empty.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set on all masses of whose nodes it acts, those of `[[mass]]` included, instead of
    /// `parts`.
    #[serde(default)]
    pub nodes: Option<String>,
}

impl GravityInput {
    /// Returns true if it does not act on all masses.
    pub fn is_partial(&self) -> bool {
        !self.parts.is_empty() || self.nodes.is_some()
    }
}

/// Damping of some parts in proportion to their masses, in addition to `time.damping`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingInput {
    /// Coefficient: a force `-coefficient * mass * velocity` on every node of the parts, and the
    /// corresponding moment, with the share of the mass that their elements have [1/time].
    pub coefficient: f64,
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Parts on whose elements it acts, those of rigid bodies included. The rotation of a body
    /// whose inertia is given is damped at another rate, by that of its nodes over its own.
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
}

/// Force of constant direction on a node set.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadInput {
    /// Node set.
    pub nodes: String,
    /// Force on the whole set, in equal shares on its nodes [force].
    #[serde(default)]
    pub force: [f64; 3],
    /// Moment on the whole set, in equal shares on its nodes [force length].
    #[serde(default)]
    pub moment: [f64; 3],
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
}

/// Pressure on faces, which follows their motion. A positive pressure acts against the normal of a
/// face. The normal of a shell follows from the order of its nodes by the right-hand rule.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureInput {
    /// Parts whose faces are all loaded.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set. The faces whose nodes are all in the set are loaded; with `parts`, only those of
    /// these parts.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Pressure [force/length^2]; with `blast` a factor on its pressure.
    pub pressure: f64,
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Explosion that gives the pressure.
    #[serde(default)]
    pub blast: Option<BlastInput>,
}

/// Explosion of a charge (Kingery & Bulmash 1984).
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlastInput {
    /// Mass of the charge, as TNT [mass].
    pub mass: f64,
    /// Position of the charge [length].
    pub position: [f64; 3],
    /// Time of the explosion [time].
    #[serde(default)]
    pub time: f64,
    /// `ground`: on the ground, a hemispherical wave. `air`: in free air, a spherical wave.
    pub burst: Burst,
    /// The pressure below that of the air, after the positive phase, counts.
    #[serde(default = "yes")]
    pub suction: bool,
    /// Units of length, time and mass in m, s and kg; without it those that `units` names.
    #[serde(default)]
    pub si: Option<[f64; 3]>,
}

/// Place of an explosion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Burst {
    /// On the ground, which reflects its wave.
    Ground,
    /// In free air.
    Air,
}

/// Boundary that lets waves out of solids, as if the material continued behind it: on outer faces
/// of solids act the tractions `-rho c_p v_n` along the normal and `-rho c_s v_t` in the plane,
/// with the elastic wave speeds and the shape at the start (Lysmer & Kuhlemeyer 1969). Waves along
/// the normal leave; oblique ones are reflected in part. The energy that leaves is work of
/// external forces. Nodes of rigid bodies have no such forces.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NonReflectingInput {
    /// Parts whose outer faces all belong to it.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set. The faces whose nodes are all in the set belong to it; with `parts`, only those of
    /// these parts.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Lets waves of dilatation out.
    #[serde(default = "yes")]
    pub pressure_waves: bool,
    /// Lets shear waves out.
    #[serde(default = "yes")]
    pub shear_waves: bool,
}

fn yes() -> bool {
    true
}

/// Prescribed motion of a node set or a rigid body: exactly one of `velocity`, `displacement`,
/// `acceleration`, `spin` and `rotation`. Contact and walls do not change it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionInput {
    /// Node set; give either this or `rigid`.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Name of a rigid body. The motion applies to its centre and to the rotation about its centre.
    #[serde(default)]
    pub rigid: Option<String>,
    /// Prescribed degrees of freedom: any of x, y, z, rx, ry, rz. The others stay free. Default x,
    /// y, z; with `spin` or `rotation` all six, or rx, ry, rz for a rigid body. Without them,
    /// rotations that are named here are fixed.
    #[serde(default)]
    pub dofs: Vec<String>,
    /// Velocity [length/time].
    #[serde(default)]
    pub velocity: Option<[f64; 3]>,
    /// Displacement [length]. Its curve must start at 0.
    #[serde(default)]
    pub displacement: Option<[f64; 3]>,
    /// Acceleration, starting at rest [length/time^2].
    #[serde(default)]
    pub acceleration: Option<[f64; 3]>,
    /// Rotational velocity about a fixed axis through `centre` [1/time].
    #[serde(default)]
    pub spin: Option<[f64; 3]>,
    /// Rotation about a fixed axis through `centre`, as a vector along it [rad]. Its curve must
    /// start at 0.
    #[serde(default)]
    pub rotation: Option<[f64; 3]>,
    /// Point on the axis [length]; not for a rigid body.
    #[serde(default)]
    pub centre: [f64; 3],
    /// Name of a curve, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Time at which the motion begins [time]; its degrees of freedom are free before. A
    /// displacement and an acceleration then count from the place at this time.
    #[serde(default)]
    pub birth: f64,
    /// Time at which the motion ends and its degrees of freedom are free again [time]; without it
    /// the end of the run.
    #[serde(default)]
    pub death: Option<f64>,
}

/// Plane of symmetry: nodes on it stay in it and rotate about its normal only.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// Point on the plane [length].
    pub point: [f64; 3],
    /// Normal, parallel to a coordinate axis.
    pub normal: [f64; 3],
    /// Largest distance of a node that counts as on the plane [length]; 0 for a thousandth of the
    /// smallest side.
    #[serde(default)]
    pub tolerance: f64,
}
