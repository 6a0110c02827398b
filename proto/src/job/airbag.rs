//! Airbags in a job.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Airbag: a volume inside a closed surface, with one pressure that acts on the surface. The
/// surface consists of the shells of some parts; edges in planes of symmetry may be open. Its
/// normals point outwards: they are turned if the volume shows what is inside. An ideal gas (`cv`,
/// `cp`) has inflows and vents; instead of it, `inverse_pressure` or `pressure_over_volume` gives
/// the pressure.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AirbagInput {
    /// Name for output.
    pub name: String,
    /// Parts whose shells and outer faces of solids form the surface.
    #[serde(default)]
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Node set. Only the faces whose nodes are all in the set are in the surface; with `parts`,
    /// only those of these parts.
    #[serde(default)]
    pub nodes: Option<String>,
    /// True if the normals of the elements point into the bag. It decides only where the volume at
    /// the start does not show what is inside, as in a flat bag.
    #[serde(default)]
    pub normals_inwards: bool,
    /// Constant volume in addition to that inside the surface, such as that of an inflator
    /// [length^3].
    #[serde(default)]
    pub added_volume: f64,
    /// Pressure outside, which acts on the surface from outside [force/length^2].
    #[serde(default)]
    pub ambient_pressure: f64,
    /// Heat capacity of the gas at constant volume [energy/(mass temperature)].
    #[serde(default)]
    pub cv: Option<f64>,
    /// Heat capacity of the gas at constant pressure [energy/(mass temperature)].
    #[serde(default)]
    pub cp: Option<f64>,
    /// Absolute pressure of the gas at the start; without it the ambient pressure
    /// [force/length^2].
    #[serde(default)]
    pub pressure: Option<f64>,
    /// Temperature of the gas at the start [temperature].
    #[serde(default)]
    pub temperature: Option<f64>,
    /// Sources of gas.
    #[serde(default)]
    pub inflow: Vec<InflowInput>,
    /// Vents, through which gas leaves.
    #[serde(default)]
    pub vent: Vec<VentInput>,
    /// Gauge pressure at the initial volume, without a gas: the pressure is in inverse proportion
    /// to the volume [force/length^2].
    #[serde(default)]
    pub inverse_pressure: Option<f64>,
    /// Name of the curve of `inverse_pressure`, the factor over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Gauge pressure over the volume, without a gas: points `[volume over initial volume,
    /// pressure]`, linear between them and constant outside [1, force/length^2].
    #[serde(default)]
    pub pressure_over_volume: Vec<[f64; 2]>,
}

/// Source of gas of an airbag.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowInput {
    /// Mass rate [mass/time].
    pub rate: f64,
    /// Name of a curve, the factor of the rate over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Temperature of the gas that comes in [temperature].
    pub temperature: f64,
    /// Name of a curve, the factor of the temperature over time; without it 1.
    #[serde(default)]
    pub temperature_curve: Option<String>,
}

/// Vent of an airbag: exactly one of `area`, `area_over_pressure` and `rate_over_pressure`. No gas
/// comes in through it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VentInput {
    /// Area of the orifice [length^2].
    #[serde(default)]
    pub area: Option<f64>,
    /// Area of the orifice over the absolute pressure: points `[pressure, area]`
    /// [force/length^2, length^2].
    #[serde(default)]
    pub area_over_pressure: Vec<[f64; 2]>,
    /// Mass rate over the gauge pressure: points `[pressure, rate]` [force/length^2, mass/time].
    #[serde(default)]
    pub rate_over_pressure: Vec<[f64; 2]>,
    /// Coefficient of discharge of an orifice; without it 1.
    #[serde(default)]
    pub coefficient: Option<f64>,
    /// Name of a curve, the factor of the coefficient over time; without it 1.
    #[serde(default)]
    pub curve: Option<String>,
    /// Gauge pressure at which the vent opens; it stays open then [force/length^2].
    #[serde(default)]
    pub opening_pressure: f64,
}
