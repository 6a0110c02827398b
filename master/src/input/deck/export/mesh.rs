//! Writes nodes and elements.

use super::parts::is_thick;
use super::{Blank, DeckWriter, Id, Number, beams, particles, springs};
use crate::input::job::Model;
use crumple_proto::job::Part;
use crumple_proto::mesh::{MeshElement, OwnSection, Shape};
use std::collections::BTreeSet;

/// Writes all nodes and elements.
pub fn write(deck: &mut DeckWriter, model: &Model) {
    deck.keyword("NODE");
    for node in &model.mesh.nodes {
        let [x, y, z] = model.given_position(node).map(Number);
        deck.card(&[Id(node.id.label()), x, y, z]);
    }
    let discrete: BTreeSet<u32> =
        model.settings.parts.iter().filter(|p| p.discrete_beam.is_some()).map(|p| p.id).collect();
    let springs = model.mesh.elements.iter().filter(|e| !discrete.contains(&e.part));
    springs::elements(deck, springs, &model.settings.parts);
    beams::elements(deck, model, &discrete);
    particles::elements(deck, model);
    let thick: BTreeSet<u32> =
        model.settings.parts.iter().filter(|p| is_thick(p)).map(|p| p.id).collect();
    for keyword in ["ELEMENT_SHELL", "ELEMENT_SOLID", "ELEMENT_TSHELL"] {
        let of = |e: &MeshElement| match keyword {
            "ELEMENT_SHELL" => e.shape.is_shell(),
            "ELEMENT_TSHELL" => e.shape == Shape::Hex8 && thick.contains(&e.part),
            _ => {
                let is_thick = e.shape == Shape::Hex8 && thick.contains(&e.part);
                !is_thick && (e.shape.is_solid() || e.shape == Shape::Cohesive8)
            }
        };
        if !model.mesh.elements.iter().any(of) {
            continue;
        }
        // The card of THICKNESS has the angle, too.
        for option in ["", "_THICKNESS", "_BETA", "_OFFSET", "_THICKNESS_OFFSET", "_BETA_OFFSET"] {
            let has = |e: &OwnSection| {
                let card = match (e.thickness > 0.0, e.angle != 0.0) {
                    (true, _) => "_THICKNESS",
                    (false, true) => "_BETA",
                    (false, false) => "",
                };
                option.strip_prefix(card) == Some(if e.offset.is_some() { "_OFFSET" } else { "" })
            };
            let mut some = model.mesh.elements.iter().filter(|e| of(e) && has(&e.own));
            let mut elements = some.by_ref().peekable();
            if elements.peek().is_some() {
                deck.keyword(&format!("{keyword}{option}"));
            }
            elements.for_each(|element| write_element(deck, element, &model.job.part));
        }
    }
}

fn write_element(deck: &mut DeckWriter, element: &MeshElement, parts: &[Part]) {
    let mut fields = vec![Id(element.id.label()), Id(u64::from(element.part))];
    if element.shape == Shape::Tet10 {
        deck.card(&fields);
        deck.card(&element.nodes.map(|n| Id(n.label())));
        return;
    }
    let corners: &[usize] = match element.shape {
        Shape::Tri3 => &[0, 1, 2, 2],
        Shape::Quad4 => &[0, 1, 2, 3],
        Shape::Tet4 => &[0, 1, 2, 3, 3, 3, 3, 3],
        Shape::Wedge6 => &[0, 2, 5, 3, 1, 1, 4, 4],
        _ => &[0, 1, 2, 3, 4, 5, 6, 7],
    };
    fields.extend(corners.iter().map(|&c| Id(element.nodes[c].label())));
    deck.card(&fields);
    let own = element.own;
    if own.thickness > 0.0 || own.angle != 0.0 {
        let t = if own.thickness > 0.0 { Number(own.thickness) } else { Blank };
        let angle = if own.angle != 0.0 { Number(own.angle) } else { Blank };
        deck.card(&[t, t, t, t, angle]);
    }
    if let Some(offset) = own.offset {
        let of_part = || parts.iter().find(|p| p.id == element.part).map_or(0.0, |p| p.thickness);
        let thickness = if own.thickness > 0.0 { own.thickness } else { of_part() };
        deck.card(&[Number(0.5 * offset * thickness)]);
    }
}
