//! Distances up to which candidates are examined, and surfaces touch.

use crate::pairs::PairHistory;
use crate::surface::{Segment, Surface};

/// Largest distance of a candidate that is examined, as a multiple of the contact thickness (of
/// the scale where solids take part). The global search must reach as far; its reach is computed
/// from this number.
pub const REACH: f64 = 1.5;
/// Predicted gap below which a pair is active, as a fraction of the contact thickness.
pub const ACTIVE: f64 = 0.02;
/// Distance behind a solid's face up to which a node without history counts as a new contact, as
/// a fraction of the scale. Such a node may have passed between two faces in the step before.
pub const BEHIND: f64 = 0.2;
/// Distance outside the border of a solid's face up to which a node still touches it, as a
/// fraction of the scale.
pub const OUTSIDE: f64 = 0.02;

/// Returns the distance beyond which a slave and a segment without common history are no pair in
/// a step [length]. In that step they move by `step` against each other [length]. No gap closes
/// from farther away, and no new contact is as far behind a solid's face.
pub fn reach(surface: &Surface, slave: u32, segment: &Segment, step: f64) -> f64 {
    /// Factor for solids: contact with a face is judged where the face is at the end of the
    /// step, warped and turned.
    const TURNED: f64 = 1.25;
    let most = |sum| surface.interfaces.most(sum);
    let scale = most(surface.node_scale[slave as usize] + segment.scale);
    let added = surface.shift_reach();
    let before =
        most(surface.node_half[slave as usize] + segment.half_thickness) + ACTIVE * scale + step;
    let near = match segment.is_solid() {
        true => TURNED * (before.max(BEHIND * scale) + OUTSIDE * scale + step + added),
        false => before + added,
    };
    near.min(REACH * scale + added)
}

/// Returns the distance as in [`reach`] for a segment that has history with the slave [length].
pub fn reach_of_old(surface: &Surface, slave: u32, segment: &Segment) -> f64 {
    REACH * surface.interfaces.most(surface.node_scale[slave as usize] + segment.scale)
        + surface.shift_reach()
}

/// Returns true if a segment is not new to a slave with these pair histories. Faces of solids
/// take over the history of neighbouring faces.
pub fn has_history(segment: &Segment, memory: &[PairHistory]) -> bool {
    if segment.is_solid() { !memory.is_empty() } else { memory.iter().any(|m| m.is_of(segment.id)) }
}
