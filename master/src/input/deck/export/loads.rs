//! Writes gravity, damping of parts and forces on nodes as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number, TimeCurves, list};
use crate::input::job::Model;
use crumple_proto::job::{GravityInput, LoadInput};

/// Writes gravity, that of the whole model per axis. Decks accelerate the frame of reference, so
/// bodies accelerate in the opposite direction.
pub fn gravity(
    deck: &mut DeckWriter,
    model: &Model,
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    if model.job.gravity.iter().any(|g| !g.parts.is_empty()) {
        return list(deck, "gravity", &model.job.gravity);
    }
    for (axis, keyword) in ["LOAD_BODY_X", "LOAD_BODY_Y", "LOAD_BODY_Z"].into_iter().enumerate() {
        let is_along = |g: &&GravityInput| g.nodes.is_none() && g.acceleration[axis] != 0.0;
        for gravity in model.job.gravity.iter().filter(is_along) {
            let curve = curves.id(deck, gravity.curve.as_deref());
            deck.keyword(keyword);
            deck.card(&[Id(curve), Number(-gravity.acceleration[axis])]);
        }
    }
    for gravity in &model.job.gravity {
        let Some(nodes) = &gravity.nodes else { continue };
        let curve = curves.id(deck, gravity.curve.as_deref());
        deck.keyword("LOAD_BODY_GENERALIZED_SET_NODE");
        deck.card(&[set(nodes), Blank, Id(curve)]);
        deck.card(&gravity.acceleration.map(|a| Number(if a == 0.0 { 0.0 } else { -a })));
    }
}

/// Writes the damping of parts.
pub fn damping(deck: &mut DeckWriter, model: &Model, curves: &mut TimeCurves<'_>) {
    let time = &model.job.time;
    if let Some(name) = &time.damping_curve {
        let curve = curves.id(deck, Some(name));
        deck.keyword("DAMPING_GLOBAL");
        let factor = || Number(time.damping);
        deck.card(&[Id(curve), Blank, factor(), factor(), factor(), factor(), factor(), factor()]);
    }
    for damping in &model.job.damping {
        let curve = curves.id(deck, damping.curve.as_deref());
        let set = deck.part_set(&damping.parts);
        deck.keyword("DAMPING_PART_MASS_SET");
        deck.card(&[Id(set), Id(curve), Number(damping.coefficient)]);
    }
}

/// Writes forces and moments on node sets. A deck loads each node, a job a set. If the sum over
/// the nodes is not the force of the set to the last bit, all loads are written after
/// `$crumple:`.
pub fn on_nodes(
    deck: &mut DeckWriter,
    model: &Model,
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    let each = |load: &LoadInput| -> Option<Vec<(u64, f64)>> {
        let count = model.mesh.node_sets.get(&load.nodes).map_or(0, |nodes| {
            nodes
                .iter()
                .filter(|n| model.mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok())
                .count()
        }) as f64;
        let amounts = (1..).zip(load.force).chain((5..).zip(load.moment)).filter(|a| a.1 != 0.0);
        let exact = |(dof, amount): (u64, f64)| {
            let one = amount / count;
            (count > 0.0 && one * count == amount).then_some((dof, one))
        };
        amounts.map(exact).collect()
    };
    let cards: Option<Vec<Vec<(u64, f64)>>> = model.job.load.iter().map(each).collect();
    let Some(cards) = cards else { return list(deck, "load", &model.job.load) };
    for (load, cards) in model.job.load.iter().zip(cards).filter(|(_, cards)| !cards.is_empty()) {
        let curve = curves.id(deck, load.curve.as_deref());
        deck.keyword("LOAD_NODE_SET");
        for (dof, amount) in cards {
            deck.card(&[set(&load.nodes), Id(dof), Id(curve), Number(amount)]);
        }
    }
}
