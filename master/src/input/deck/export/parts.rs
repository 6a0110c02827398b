//! Writes parts with their sections and hourglass control.

use super::bodies::DeckBodies;
use super::{
    Blank, CardValue, DeckWriter, Id, Number, beams, cohesive, composites, discrete_beams, line,
    particles, springs,
};
use crate::input::job::Model;
use crumple_proto::job::{Part, Setting};
use crumple_proto::mesh::Shape;
use crumple_worker::fem::elements::{COHESIVE, HourglassForm, THICK_SHELL, formulation, points_of};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Writes the parts. Parts of springs, discrete beams and particles get individual materials,
/// with ids from `next` on.
pub fn write(
    deck: &mut DeckWriter,
    model: &Model,
    bodies: &DeckBodies,
    equations: &BTreeMap<&str, u64>,
    mut next: u64,
) -> Result<(), String> {
    let rigid = &bodies.materials;
    let mut shapes: BTreeMap<u32, Vec<Shape>> = BTreeMap::new();
    for element in &model.mesh.elements {
        let of = shapes.entry(element.part).or_default();
        if !of.contains(&element.shape) {
            of.push(element.shape);
        }
    }
    let materials = &model.settings.materials;
    let is_shell = |part: &Part| {
        let others = part.spring.is_some()
            || part.discrete_beam.is_some()
            || part.particles.is_some()
            || part.beam.is_some()
            || part.truss.is_some();
        !others && is_of_shells(part, shapes.get(&part.id).map_or(&[], Vec::as_slice))
    };
    let of_shells: Vec<&Part> = model.settings.parts.iter().filter(|part| is_shell(part)).collect();
    let common = shell_settings(deck, &of_shells);
    for part in &model.settings.parts {
        if part.belt.is_some() {
            return Err(format!(
                "part {} is a seat belt: seat belts cannot be written as a deck; leave its \
                 elements and [belts] out",
                part.label()
            ));
        }
        if let Some(spring) = &part.spring {
            springs::part(deck, part, spring, next);
            next += 1;
            continue;
        }
        if let Some(beam) = &part.discrete_beam {
            discrete_beams::part(deck, part, beam, next)?;
            next += 1;
            continue;
        }
        if let Some(fluid) = &part.particles {
            particles::part(deck, part, fluid, next);
            next += 1;
            continue;
        }
        let of = shapes.get(&part.id).map_or(&[][..], Vec::as_slice);
        let shells = is_of_shells(part, of);
        if of.iter().any(|shape| shape.is_shell() != shells) {
            return Err(format!(
                "part {} has shells and solids: give each its own part, as a deck requires",
                part.id
            ));
        }
        let plain =
            materials.iter().position(|m| m.name == part.material).map_or(0, |i| i as u64 + 1);
        let mid = rigid.get(&part.id).copied().unwrap_or(plain);
        if part.beam.is_some() || part.truss.is_some() {
            let law = materials.iter().find(|m| m.name == part.material);
            beams::part(deck, part, law.map_or("", |m| m.law.as_str()), mid)?;
            continue;
        }
        let id = u64::from(part.id);
        if !part.layer.is_empty() && rigid.contains_key(&part.id) {
            return Err(format!(
                "part {}: a rigid part with layers cannot be written as a deck: give it a \
                 thickness and a material with the mean density",
                part.id
            ));
        }
        if !part.layer.is_empty() && is_thick(part) {
            return Err(format!(
                "part {}: thick shells with layers cannot be written as a deck: give it a material \
                 and `angles`",
                part.id
            ));
        }
        if !part.layer.is_empty() {
            let hourglass = hourglass(deck, (model, part), of, common);
            composites::part(deck, part, materials, hourglass);
            continue;
        }
        if shells {
            shell_section(deck, part);
        } else if is_thick(part) {
            thick_section(deck, part);
        } else {
            deck.keyword("SECTION_SOLID");
            deck.card(&[Id(id), Id(solid_elform(part, of))]);
        }
        let hourglass = hourglass(deck, (model, part), of, common);
        let contact = contact_fields(part).filter(|_| shells);
        let inertia = bodies.inertia.get(&part.id);
        let own = if inertia.is_some() { "_INERTIA" } else { "" };
        deck.keyword(&format!("PART{own}{}", if contact.is_some() { "_CONTACT" } else { "" }));
        deck.text(&line(&part.name));
        let equation = equations.get(part.material.as_str()).filter(|_| mid == plain);
        let equation = equation.map_or(Blank, |&id| Id(id));
        deck.card(&[Id(id), Id(id), Id(mid), equation, if hourglass { Id(id) } else { Blank }]);
        inertia.iter().flat_map(|own| own.cards()).for_each(|card| deck.card(&card));
        if let Some(fields) = contact {
            deck.card(&[&[Blank; 4][..], &fields].concat());
        }
    }
    Ok(())
}

/// Returns true for a part of shells; without elements, for one with a thickness.
fn is_of_shells(part: &Part, shapes: &[Shape]) -> bool {
    shapes.first().map_or(part.thickness > 0.0, |shape| shape.is_shell())
}

/// Settings of all parts of shells on one card.
#[derive(Clone, Copy)]
struct ShellSettings {
    /// All parts of shells become thinner.
    thinning: bool,
    /// Parts have the default drilling stiffness.
    drilling: bool,
}

/// Writes settings that all parts of shells have in common.
fn shell_settings(deck: &mut DeckWriter, all: &[&Part]) -> ShellSettings {
    let is_thin =
        |part: &&Part| !part.skin && part.parameters.get("thinning") == Some(&Setting::Flag(true));
    let thinning = !all.is_empty() && all.iter().all(is_thin);
    let stiff =
        all.iter().filter(|part| may_drill(part) && !part.parameters.contains_key("drilling"));
    let stiff: Vec<u32> = stiff.map(|part| part.id).collect();
    let set = if stiff.is_empty() { Blank } else { Id(deck.part_set(&stiff)) };
    if thinning || !stiff.is_empty() {
        deck.keyword("CONTROL_SHELL");
        deck.card(&[Blank, Blank, Blank, if thinning { Id(1) } else { Blank }]);
        deck.card(&[]);
        deck.card(&[]);
        deck.card(&[Blank, Blank, Blank, Blank, Blank, set]);
    }
    ShellSettings { thinning, drilling: !stiff.is_empty() }
}

/// Returns true for a part whose formulation has no drilling stiffness in a deck without a card
/// for it.
fn may_drill(part: &Part) -> bool {
    part.element.as_deref() == Some("belytschko_tsay") && !is_membrane(part)
}

/// Returns thickness and scale of a part in contact as fields; `None` if both are the defaults, or
/// if the card of a part has no such fields.
fn contact_fields(part: &Part) -> Option<[CardValue; 2]> {
    let scale = part.contact_thickness_scale;
    let has_own = part.contact_thickness.is_some() || scale != 1.0;
    let fits = part.contact_thickness.is_none_or(|t| t > 0.0) && scale > 0.0;
    (has_own && fits && part.layer.is_empty()).then(|| {
        let thickness = part.contact_thickness.map_or(Blank, Number);
        [thickness, if scale == 1.0 { Blank } else { Number(scale) }]
    })
}

fn shell_section(deck: &mut DeckWriter, part: &Part) {
    let id = u64::from(part.id);
    deck.keyword("SECTION_SHELL");
    let mut first = vec![Id(id), Id(elform(part)), Number(1.0), Id(points_of(part) as u64)];
    if !part.angles.is_empty() {
        first.extend([Blank, Blank, Id(1)]);
    }
    deck.card(&first);
    let t = Number(part.thickness);
    if part.offset == 0.0 {
        deck.card(&[t]);
    } else {
        deck.card(&[t, t, t, t, Number(-part.offset)]);
    }
    let angles: Vec<CardValue> = part.angles.iter().map(|&angle| Number(angle)).collect();
    angles.chunks(8).for_each(|eight| deck.card(eight));
}

/// Writes the section of a part of thick shells.
fn thick_section(deck: &mut DeckWriter, part: &Part) {
    let points = formulation(part, Shape::Hex8).map_or(2, |row| row.values(part).whole("points"));
    deck.keyword("SECTION_TSHELL");
    let composite = if part.angles.is_empty() { Blank } else { Id(1) };
    let (id, shear) = (Id(u64::from(part.id)), Number(5.0 / 6.0));
    deck.card(&[id, Id(1), shear, Id(points as u64), Blank, Blank, composite]);
    let angles: Vec<CardValue> = part.angles.iter().map(|&angle| Number(angle)).collect();
    angles.chunks(8).for_each(|eight| deck.card(eight));
}

/// Returns true for a part of thick shells.
pub(in crate::input::deck) fn is_thick(part: &Part) -> bool {
    part.element.as_deref() == Some(THICK_SHELL)
}

/// Returns the formulation of a part of solids in the format. Without hexahedra it is one of
/// tetrahedra or wedges: in other programs, formulation 1 takes them for collapsed hexahedra.
fn solid_elform(part: &Part, shapes: &[Shape]) -> u64 {
    let has = |shape| shapes.contains(&shape);
    if is_cohesive(part) {
        cohesive::ELFORM
    } else if shapes.is_empty() || has(Shape::Hex8) {
        1
    } else if has(Shape::Tet4) {
        if has_own_pressure(part) { 10 } else { 13 }
    } else if has(Shape::Wedge6) {
        15
    } else {
        16
    }
}

/// Returns the formulation of a part of shells in the format.
pub(super) fn elform(part: &Part) -> u64 {
    let warping = part.parameters.get("warping") == Some(&Setting::Flag(true));
    match (part.element.as_deref(), warping) {
        (Some("belytschko_tsay"), _) if is_membrane(part) => 5,
        (Some("belytschko_tsay"), true) => 10,
        (Some("belytschko_tsay"), false) => 2,
        _ => 16,
    }
}

/// Returns true for a part of cohesive elements.
fn is_cohesive(part: &Part) -> bool {
    part.element.as_deref() == Some(COHESIVE)
}

/// Returns true for a part of solids with the volume strain of each element.
fn has_own_pressure(part: &Part) -> bool {
    part.parameters.get("pressure") == Some(&Setting::Word("element".to_string()))
}

/// Returns true for a part of membranes.
fn is_membrane(part: &Part) -> bool {
    part.parameters.get("membrane") == Some(&Setting::Flag(true))
}

/// Writes hourglass control and viscosity of a part. Returns true if there are any.
fn hourglass(
    deck: &mut DeckWriter,
    (model, part): (&Model, &Part),
    shapes: &[Shape],
    common: ShellSettings,
) -> bool {
    let shells = is_of_shells(part, shapes);
    let solids = !shells && !is_cohesive(part) && !is_thick(part);
    let by_card = solids || part.element.as_deref() == Some("belytschko_tsay");
    let given = |key: &str| part.parameters.get(key);
    let form = match given("hourglass") {
        // A deck without a form means the viscous form, so the job's default must be written.
        None if shells && by_card => 4,
        None if solids => 6,
        Some(Setting::Word(word)) if word == HourglassForm::Viscous.word() => 1,
        Some(Setting::Word(word)) if word == HourglassForm::Stiffness.word() => 4,
        Some(Setting::Word(word)) if word == HourglassForm::AssumedStrain.word() => 6,
        _ => 0,
    };
    // Cards cannot hold a coefficient without a form, or for a form that has none.
    let default = || {
        let shape = if shells { Shape::Quad4 } else { Shape::Hex8 };
        let row = formulation(part, shape).filter(|_| by_card)?;
        Some(row.values(part).number("hourglass_coefficient"))
    };
    let coefficient = given("hourglass_coefficient").and_then(Setting::number).or_else(default);
    // Zeros on a card mean the defaults.
    let coefficient =
        coefficient.filter(|&c| c != 0.0 && by_card && (shells || matches!(form, 1 | 4)));
    let viscosity = match given("bulk_viscosity") {
        Some(Setting::List(list)) if !list.iter().all(|b| *b == 0.0) => list.as_slice(),
        _ => &[],
    };
    let on_card = |key: &str| match key {
        "points" => shells || is_thick(part),
        "hourglass" | "warping" | "membrane" => by_card,
        "hourglass_coefficient" => coefficient.is_some(),
        "bulk_viscosity" => !viscosity.is_empty(),
        "pressure" => has_own_pressure(part) && solid_elform(part, shapes) == 10,
        "thinning" => shells && common.thinning,
        "drilling" => {
            let is_zero = given("drilling").and_then(Setting::number) == Some(0.0);
            is_zero && may_drill(part) && !common.drilling
        }
        _ => cohesive::is_on_card(key, part),
    };
    let mut own = Table::from_iter([("id".to_string(), Value::from(part.id))]);
    for (key, value) in part.parameters.iter().filter(|(key, _)| !on_card(key)) {
        own.extend(Value::try_from(value).ok().map(|value| (key.clone(), value)));
    }
    own.extend(cohesive::differing(part, &model.settings.parts));
    if part.element.as_deref() == Some("fully_integrated_quad") {
        own.insert("element".into(), "fully_integrated_quad".into());
    }
    if part.skin {
        own.insert("skin".into(), true.into());
    }
    let without = contact_fields(part).is_none() || !shells;
    if let Some(thickness) = part.contact_thickness.filter(|_| without) {
        own.insert("contact_thickness".into(), thickness.into());
    }
    if part.contact_thickness_scale != 1.0 && without {
        own.insert("contact_thickness_scale".into(), part.contact_thickness_scale.into());
    }
    if own.len() > 1 {
        deck.entry("part", own);
    }
    let any = (by_card && (form != 0 || coefficient.is_some())) || !viscosity.is_empty();
    if any {
        let [linear, quadratic] = viscosity.try_into().unwrap_or_default();
        deck.keyword("HOURGLASS");
        let (q1, q2) = (Number(quadratic), Number(linear));
        deck.card(&[
            Id(u64::from(part.id)),
            Id(form),
            Number(coefficient.unwrap_or(0.0)),
            Blank,
            q1,
            q2,
        ]);
    }
    any
}
