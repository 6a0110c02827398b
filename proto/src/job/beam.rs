//! Cross sections of beams in a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cross section of a part of beams; its elements are the rows of `mesh.beams`. The second axis of
/// the section lies in the plane of the three nodes of an element, normal to the beam. The third
/// axis is normal to both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeamInput {
    /// Shape of the section.
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
    /// Wall thickness of a tube [length]; 0 for a solid round bar.
    #[serde(default)]
    pub wall: f64,
    /// Area of a general section [length^2].
    #[serde(default)]
    pub area: f64,
    /// Second moments of area of a general section, for bending about the second and the third axis
    /// [length^4]. 0 and 0 for a truss, which has no moments.
    #[serde(default)]
    pub second_moments: [f64; 2],
    /// Torsion constant of a general section [length^4].
    #[serde(default)]
    pub torsion: f64,
    /// Shear areas along the second and the third axis [length^2]. 0 (default) for a thin beam
    /// without shear deformation.
    #[serde(default)]
    pub shear_areas: [f64; 2],
    /// Makes the beams spot welds that break.
    #[serde(default)]
    pub weld: Option<Weld>,
    /// Contact radius of its beams [length]. Default for a tube: its outer radius. For a rectangle
    /// and a general section: the radius of the circle with the same area. For an I: that of the
    /// rectangle around it. Welds are in contact only if this is given. `contact.thickness_limit`
    /// bounds it by the length of the beam.
    #[serde(default)]
    pub contact_radius: Option<f64>,
    /// Axial stress over time, `[[time, stress], ...]` [time], [force/length^2], of beams that
    /// start with a preload, such as bolts. Until the last point, or the first one at which the
    /// stress is 0 again, all fibres have this stress, whatever the strain; before the first point
    /// its value. From then on the stress follows the strain. All stresses have one sign, and are
    /// below the yield stress of the law.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preload: Vec<[f64; 2]>,
    /// True if fibres keep their differences of stress during the preload, which is then the mean
    /// stress of a section: the beam resists bending.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub preload_bending: bool,
}

impl BeamInput {
    /// Returns a section of this shape without sizes.
    pub fn of(section: BeamSection) -> Self {
        BeamInput {
            section,
            height: 0.0,
            width: 0.0,
            flange: 0.0,
            web: 0.0,
            radius: 0.0,
            wall: 0.0,
            area: 0.0,
            second_moments: [0.0; 2],
            torsion: 0.0,
            shear_areas: [0.0; 2],
            weld: None,
            contact_radius: None,
            preload: Vec::new(),
            preload_bending: false,
        }
    }
}

/// Failure of a spot weld. It breaks when `(N/normal)^n + (V/shear)^m + (M/bending)^2 +
/// (T/torsion)^2 >= 1`, with the tension N, the shear force V, the larger bending moment M of its
/// ends and the torque T. From then on its forces are zero. With a limit of 0, its term is left
/// out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weld {
    /// Tension at which it breaks without other loads [force].
    #[serde(default)]
    pub normal: f64,
    /// Shear force at which it breaks without other loads [force].
    #[serde(default)]
    pub shear: f64,
    /// Bending moment at which it breaks without other loads [force length].
    #[serde(default)]
    pub bending: f64,
    /// Torque at which it breaks without other loads [force length].
    #[serde(default)]
    pub torsion: f64,
    /// Exponents n and m; default 2 and 2.
    #[serde(default = "squares")]
    pub exponents: [f64; 2],
}

fn squares() -> [f64; 2] {
    [2.0; 2]
}

/// Shape of the cross section of a beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BeamSection {
    /// `height` by `width`.
    Rectangle,
    /// `radius` and `wall`.
    Tube,
    /// Two flanges of `width` by `flange`, and a `web`; `height` is the total height.
    I,
    /// `area`, `second_moments` and `torsion` alone: four fibres at the radii of gyration. This is
    /// exact for elastic beams. A truss yields like one fibre, a beam in bending like four flanges.
    General,
}
