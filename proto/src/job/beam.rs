//! Cross sections of beams as they are written in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cross section of a part of beams, whose elements are the rows of `mesh.beams`. Its second axis
/// lies in the plane of the three nodes of an element, square to the beam; its third axis is square
/// to both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Form of the section.
    pub section: BeamSection,
    /// Height of a rectangle or an I along the second axis [length].
    #[serde(default)]
    pub height: f64,
    /// Width of a rectangle or an I along the third axis [length].
    #[serde(default)]
    pub width: f64,
    /// Thickness of each flange of an I [length].
    #[serde(default)]
    pub flange: f64,
    /// Thickness of the web of an I [length].
    #[serde(default)]
    pub web: f64,
    /// Outer radius of a tube [length].
    #[serde(default)]
    pub radius: f64,
    /// Wall of a tube, 0 for a solid round bar [length].
    #[serde(default)]
    pub wall: f64,
    /// Area of a general section [length^2].
    #[serde(default)]
    pub area: f64,
    /// Second moments of area of a general section, for bending about the second and the third
    /// axis; 0 and 0 for a truss, which bears no moments [length^4].
    #[serde(default)]
    pub second_moments: [f64; 2],
    /// Torsion constant of a general section [length^4].
    #[serde(default)]
    pub torsion: f64,
    /// Areas that bear the shear forces along the second and the third axis; 0 for a beam so thin
    /// that shear does not deform it, as it is without this [length^2].
    #[serde(default)]
    pub shear_areas: [f64; 2],
    /// Makes beams welds that break.
    #[serde(default)]
    pub weld: Option<Weld>,
    /// Radius with which its beams are met in contact [length]. Without it the outer radius of a
    /// tube, for a rectangle and a general section that of the circle of the same area, for an I
    /// that of the rectangle around it; welds take no part without it. `contact.thickness_limit`
    /// bounds it by the beam's length.
    #[serde(default)]
    pub contact_radius: Option<f64>,
}

/// When a beam breaks as a spot weld does: once `(N/normal)^n + (V/shear)^m + (M/bending)^2 +
/// (T/torsion)^2 >= 1`, with the tension N along it, the shear force V across it, the larger
/// bending moment M of its ends and the torque T. From then on it bears nothing. A limit of 0 is
/// none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weld {
    /// Tension that breaks it alone [force].
    #[serde(default)]
    pub normal: f64,
    /// Shear force that breaks it alone [force].
    #[serde(default)]
    pub shear: f64,
    /// Bending moment that breaks it alone [force length].
    #[serde(default)]
    pub bending: f64,
    /// Torque that breaks it alone [force length].
    #[serde(default)]
    pub torsion: f64,
    /// Exponents n and m; 2 and 2 without them.
    #[serde(default = "squares")]
    pub exponents: [f64; 2],
}

fn squares() -> [f64; 2] {
    [2.0; 2]
}

/// Form of a beam's cross section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BeamSection {
    /// `height` by `width`.
    Rectangle,
    /// `radius` and `wall`.
    Tube,
    /// Two flanges of `width` by `flange`, and a `web`; `height` over all.
    I,
    /// `area`, `second_moments` and `torsion` alone: four fibres at the radii of gyration. Elastic
    /// beams need no more; a truss yields as one fibre does, a beam that bends as four flanges.
    General,
}
