//! Adaptivity in a job.

use super::PartRef;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Division of four-node shells where they bend, so that a crush starts coarse and becomes fine
/// where it folds.
///
/// At each check a shell whose plastic bending angle has reached `angle` is divided into four. The
/// parts of it keep its thickness, stress and history. A node in the middle of a side whose other
/// shell is not divided follows the ends of this side, as a tied node does. The smallest shell
/// controls the step, so that each level halves it.
///
/// Shells are not divided if they are rigid, loaded by pressure, tied, recorded as a section or by
/// a transducer with a node set, or share nodes with solids, beams, springs or rigid bodies.
/// Concave shells wait until they are not. Triangles are never divided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptivityInput {
    /// Parts whose shells may be divided; all parts with four-node shells if empty.
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Plastic bending angle of a shell, from side to side, from which on it is divided [degree]:
    /// twice the effective plastic strain of bending at its outer fibres, times its side, over its
    /// thickness.
    pub angle: f64,
    /// Number of rings of neighbours that are divided with a shell, so that a fold that moves on
    /// finds small shells.
    pub rings: u32,
    /// Largest number of divisions of a shell of the mesh: 1 for quarters, 2 for sixteenths.
    pub levels: u32,
    /// Time between two checks [time]; 0 for a hundredth of the run.
    pub interval: f64,
    /// Time of the first check [time].
    pub begin: f64,
    /// Time after which there is no check [time]; the end of the run without it.
    pub end: Option<f64>,
}

impl Default for AdaptivityInput {
    fn default() -> Self {
        Self {
            parts: Vec::new(),
            angle: 5.0,
            rings: 1,
            levels: 1,
            interval: 0.0,
            begin: 0.0,
            end: None,
        }
    }
}
