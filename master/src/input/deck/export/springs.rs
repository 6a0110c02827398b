//! Writes springs and dampers as cards.

use super::{Blank, CardValue, DeckWriter, Id, Number, line, points};
use crumple_proto::job::{Part, SpringHardening, SpringInput, SpringSide};
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Writes a part of springs with a section and an individual material `mid`. A card has one law;
/// other keys of the part are written after `$crumple:`.
pub fn part(deck: &mut DeckWriter, part: &Part, spring: &SpringInput, mid: u64) {
    let id = u64::from(part.id);
    let mut rest = SpringInput::default();
    let projected = u64::from(spring.projected);
    if let Some(direction) = spring.direction {
        deck.keyword("DEFINE_SD_ORIENTATION");
        deck.card(&[&[Id(id), Id(projected)][..], &direction.map(Number)].concat());
    } else if let Some(nodes) = spring.direction_nodes {
        deck.keyword("DEFINE_SD_ORIENTATION");
        let head = [Id(id), Id(2 + projected), Blank, Blank, Blank];
        deck.card(&[&head[..], &nodes.map(Id)].concat());
    }
    let (keyword, fields) = law(deck, spring);
    if keyword.contains("SPRING") {
        (rest.damping, rest.force_rate) = (spring.damping, spring.force_rate.clone());
    }
    deck.keyword(keyword);
    deck.text(&format!("{}, {id}", line(&part.name)));
    deck.card(&[&[Id(mid)], &fields[..]].concat());
    deck.keyword("SECTION_DISCRETE");
    deck.card(&[Id(id), if spring.rotational { Id(1) } else { Blank }]);
    deck.card(&[]);
    deck.keyword("PART");
    deck.text(&line(&part.name));
    deck.card(&[Id(id), Id(id), Id(mid)]);
    let own: Table = match Value::try_from(&rest) {
        Ok(Value::Table(own)) => own,
        _ => return,
    };
    let none = Value::try_from(SpringInput::default()).unwrap_or(Value::Boolean(false));
    let own: Table = own.into_iter().filter(|(key, value)| none.get(key) != Some(value)).collect();
    if !own.is_empty() {
        deck.entry(
            "part",
            Table::from_iter([("id".into(), Value::from(part.id)), ("spring".into(), own.into())]),
        );
    }
}

/// Returns the keyword of a law and the fields of its card after the id; writes its curves.
fn law(deck: &mut DeckWriter, spring: &SpringInput) -> (&'static str, Vec<CardValue>) {
    if let Some(law) = &spring.elastoplastic {
        let fields = [law.stiffness, law.tangent_stiffness, law.yield_force];
        return ("MAT_SPRING_ELASTOPLASTIC_TITLE", fields.map(Number).to_vec());
    }
    if let Some(law) = &spring.hysteresis {
        let [loading, unloading] = [&law.loading, &law.unloading].map(|p| Id(points(deck, p)));
        let beta = f64::from(u8::from(law.hardening == SpringHardening::Isotropic));
        let [cyi, tyi] = law.yield_forces.unwrap_or_default();
        let fields = [loading, unloading, Number(beta), Number(tyi), Number(cyi)];
        return ("MAT_SPRING_GENERAL_NONLINEAR_TITLE", fields.to_vec());
    }
    if let Some(law) = &spring.maxwell {
        let fields = [
            Number(law.short_time_stiffness),
            Number(law.long_time_stiffness),
            Number(law.decay),
            law.cutoff_time.map_or(Blank, Number),
            law.cutoff_time.map_or(Blank, |_| Number(law.cutoff_force)),
            Id(u64::from(law.ageing)),
        ];
        return ("MAT_SPRING_MAXWELL_TITLE", fields.to_vec());
    }
    if let Some(law) = &spring.one_sided {
        let side = if law.carries == SpringSide::Tension { -1.0 } else { 1.0 };
        let curve = Id(points(deck, &law.loading));
        let fields = [curve, Number(law.unloading_stiffness), Number(side)];
        return ("MAT_SPRING_INELASTIC_TITLE", fields.to_vec());
    }
    let tables = [&spring.force_elongation, &spring.force_rate];
    let [elongation, rate] = tables.map(|table| (!table.is_empty()).then(|| points(deck, table)));
    let (keyword, field) = match (elongation, spring.stiffness, rate) {
        (Some(curve), _, _) => ("MAT_SPRING_NONLINEAR_ELASTIC_TITLE", Id(curve)),
        (None, stiffness, _) if stiffness != 0.0 => ("MAT_SPRING_ELASTIC_TITLE", Number(stiffness)),
        (None, _, Some(curve)) => ("MAT_DAMPER_NONLINEAR_VISCOUS_TITLE", Id(curve)),
        (None, _, None) => ("MAT_DAMPER_VISCOUS_TITLE", Number(spring.damping)),
    };
    (keyword, vec![field])
}

/// Writes the elements. Those of a part with a direction have an orientation with its id.
pub fn elements<'m>(
    deck: &mut DeckWriter,
    elements: impl Iterator<Item = &'m MeshElement>,
    parts: &[Part],
) {
    let has = |s: &SpringInput| s.direction.is_some() || s.direction_nodes.is_some();
    let is_directed = |part: &&Part| part.spring.as_ref().is_some_and(has);
    let directed: BTreeSet<u32> = parts.iter().filter(is_directed).map(|p| p.id).collect();
    let mut springs = elements.filter(|e| e.shape == Shape::Line2).peekable();
    if springs.peek().is_some() {
        deck.keyword("ELEMENT_DISCRETE");
    }
    for e in springs {
        deck.card(&[
            Id(e.id.label()),
            Id(u64::from(e.part)),
            Id(e.nodes[0].label()),
            Id(e.nodes[1].label()),
            if directed.contains(&e.part) { Id(u64::from(e.part)) } else { Blank },
        ]);
    }
}
