//! Default skin of the contact searches where a body with an initial velocity could pass through
//! the thinnest shell in one step of the elements. With a wide skin the searches know all that
//! comes near in the next steps, so that fast bodies and thin shells far from each other do not
//! shorten the step.

use super::state::{ElementStart, NodeStart, smallest};
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::Settings;
use crumple_worker::contact::surface::ContactParts;
use crumple_worker::parallel::reduction::{near_pairs_decide, skin_for};
use std::collections::HashMap;

/// Widest skin, in median sides of elements: around a node of a sheet lie 16 segments within two
/// sides. Other values were not tried.
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
    if settings.contact.is_none() {
        return;
    }
    let Some((_, dt)) = smallest(&elements.stable_dt).filter(|(_, dt)| dt.is_finite()) else {
        return;
    };
    let dt = if settings.dt_max > 0.0 { dt.min(settings.dt_max) } else { dt };
    let places: HashMap<u32, u32> = settings.parts.iter().map(|p| p.id).zip(0..).collect();
    let parts = ContactParts::from_settings(settings);
    let halves = mesh
        .elements
        .iter()
        .filter(|e| e.shape.is_shell())
        .filter_map(|e| parts.half_thickness(*places.get(&e.part)?, e.own.thickness));
    let thinnest = parts.least(halves.fold(f64::INFINITY, f64::min));
    let extent = |c: usize| {
        let along = nodes.velocity.iter().map(|v| v[c]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let spread = (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt();
    let Some(skin) = skin_for(thinnest, spread, dt).map(|skin| skin.min(WIDEST * median)) else {
        return;
    };
    if let Some(contact) = settings.contact.as_mut().filter(|_| near_pairs_decide(thinnest, skin)) {
        contact.skin = contact.skin.max(skin);
    }
}
