//! Default skin of the contact searches where a fragment of the start could pass through the
//! thinnest foil in one step of the elements. With a wide skin the searches know all that comes
//! near in the next steps, so that fragments and foils far from each other do not shorten the step.

use super::state::{ElementStart, NodeStart, smallest};
use crumple_proto::job::Part;
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::Settings;
use crumple_worker::parallel::reduction::skin_for;
use std::collections::HashMap;

/// Widest skin, in median sides of elements. With wider ones each node has tens of candidates.
const WIDEST: f64 = 2.0;

/// Widens the skin of a contact whose job gives none. `median` is the median side of the elements
/// [length].
pub(super) fn widen(
    settings: &mut Settings,
    mesh: &Mesh,
    nodes: &NodeStart,
    elements: &ElementStart,
    median: f64,
) {
    let Some(contact) = &settings.contact else { return };
    let Some((_, dt)) = smallest(&elements.stable_dt).filter(|(_, dt)| dt.is_finite()) else {
        return;
    };
    let dt = if settings.dt_max > 0.0 { dt.min(settings.dt_max) } else { dt };
    let parts: HashMap<u32, &Part> =
        settings.parts.iter().filter(|p| contact.takes_part(p.id)).map(|p| (p.id, p)).collect();
    let halves = mesh.elements.iter().filter(|e| e.shape.is_shell()).filter_map(|e| {
        let part = parts.get(&e.part)?;
        let own = if e.own.thickness > 0.0 { e.own.thickness } else { part.thickness };
        Some(0.5 * part.contact_thickness.unwrap_or(own) * part.contact_thickness_scale)
    });
    let thinnest = halves.fold(f64::INFINITY, f64::min);
    let extent = |c: usize| {
        let along = nodes.velocity.iter().map(|v| v[c]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let spread = (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt();
    if let (Some(skin), Some(contact)) = (skin_for(thinnest, spread, dt), &mut settings.contact) {
        contact.skin = contact.skin.max(skin.min(WIDEST * median));
    }
}
