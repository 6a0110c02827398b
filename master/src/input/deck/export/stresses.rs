//! Writes stresses and plastic strains at the start as cards.

use super::{CardValue, DeckWriter, Id, LeftReason, Number};
use crate::input::job::Model;
use crumple_proto::initial::InitialPoint;

/// Writes the stresses of all shells and solids.
pub fn write(deck: &mut DeckWriter, model: &Model) {
    let elements = &model.mesh.elements;
    for (keyword, of_shells) in [("INITIAL_STRESS_SHELL", true), ("INITIAL_STRESS_SOLID", false)] {
        let mut headed = false;
        for points in model.mesh.initial.chunk_by(|a, b| a.element == b.element) {
            let id = points[0].element;
            let at = elements.binary_search_by_key(&id, |e| e.id);
            if at.is_ok_and(|at| elements[at].shape.is_shell() != of_shells) {
                continue;
            }
            let planes: Vec<_> = points.chunk_by(|a, b| a.number == b.number).collect();
            let each = planes[0].len();
            if planes.iter().any(|plane| plane.len() != each) {
                deck.note("mesh.stresses of elements", LeftReason::Lost, 1);
                continue;
            }
            if !headed {
                deck.keyword(keyword);
                headed = true;
            }
            let head = [Id(id.label()), Id(planes.len() as u64), Id(each as u64)];
            deck.card(&head[..if of_shells { 3 } else { 2 }]);
            points.iter().for_each(|point| deck.card(&card(point, of_shells)));
        }
    }
}

/// Returns the fields of a point.
fn card(point: &InitialPoint, of_shell: bool) -> Vec<CardValue> {
    let position = of_shell.then_some(Number(point.position));
    let stress = point.stress.map(Number);
    position.into_iter().chain(stress).chain([Number(point.plastic_strain)]).collect()
}
