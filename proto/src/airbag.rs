//! Airbags for workers: closed surfaces of faces, and the law of the gas inside.

use crate::ids::ElemId;
use serde::{Deserialize, Serialize};

/// An airbag: a volume with uniform pressure inside a closed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResolvedAirbag {
    /// Name for output.
    pub name: String,
    /// Faces of the surface, ascending by element.
    pub faces: Vec<BagFace>,
    /// Point from which the volume is measured; on all planes of symmetry that close the surface
    /// [length].
    pub origin: [f64; 3],
    /// Constant volume in addition to that inside the surface [length^3].
    pub added_volume: f64,
    /// Pressure outside [force/length^2].
    pub ambient_pressure: f64,
    /// Relation of pressure and volume.
    pub law: BagLaw,
}

/// A face of the surface of an airbag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct BagFace {
    /// Its element.
    pub element: ElemId,
    /// Index into [`crate::mesh::Shape::faces`].
    pub face: u8,
    /// True if the normal of the face points into the bag.
    pub inwards: bool,
    /// Largest number of faces of the bag that meet at one of its nodes.
    pub meeting: u32,
}

impl ResolvedAirbag {
    /// Returns the faces of an element in the surface.
    pub fn faces_of(&self, element: ElemId) -> impl Iterator<Item = &BagFace> {
        let first = self.faces.partition_point(|f| f.element < element);
        self.faces[first..].iter().take_while(move |f| f.element == element)
    }
}

/// Relation of pressure and volume. Curves are indices into
/// [`crate::loads::ResolvedLoads::curves`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum BagLaw {
    /// An ideal gas with its energy.
    Gas(GasLaw),
    /// Gauge pressure in inverse proportion to the volume.
    Inverse {
        /// Gauge pressure at the initial volume [force/length^2].
        pressure: f64,
        /// Curve of its factor; constant if `None`.
        curve: Option<usize>,
    },
    /// Gauge pressure as a function of the volume.
    Table {
        /// Points `[volume over initial volume, gauge pressure]`, ascending
        /// [1, force/length^2].
        points: Vec<[f64; 2]>,
    },
}

/// An ideal gas with constant heat capacities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasLaw {
    /// Heat capacity at constant volume [energy/(mass temperature)].
    pub cv: f64,
    /// Heat capacity at constant pressure [energy/(mass temperature)].
    pub cp: f64,
    /// Absolute pressure at the start [force/length^2].
    pub pressure: f64,
    /// Temperature at the start [temperature].
    pub temperature: f64,
    /// Sources of gas.
    pub inflows: Vec<GasInflow>,
    /// Vents.
    pub vents: Vec<GasVent>,
}

/// A source of gas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasInflow {
    /// Mass rate, times its curve [mass/time].
    pub rate: f64,
    /// Curve of the rate; constant if `None`.
    pub curve: Option<usize>,
    /// Temperature of the gas, times its curve [temperature].
    pub temperature: f64,
    /// Curve of the temperature; constant if `None`.
    pub temperature_curve: Option<usize>,
}

/// A vent through which gas leaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasVent {
    /// How much gas leaves.
    pub flow: VentFlow,
    /// Gauge pressure at which it opens; it stays open then [force/length^2].
    pub opening_pressure: f64,
}

/// Flow through a vent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum VentFlow {
    /// Flow through an orifice.
    Orifice {
        /// Points `[absolute pressure, area]`; one point if the area is constant
        /// [force/length^2, length^2].
        area: Vec<[f64; 2]>,
        /// Coefficient of discharge, times its curve.
        coefficient: f64,
        /// Curve of the coefficient; constant if `None`.
        curve: Option<usize>,
    },
    /// Mass rate as a function of the pressure.
    Rate {
        /// Points `[gauge pressure, mass rate]` [force/length^2, mass/time].
        points: Vec<[f64; 2]>,
    },
}
