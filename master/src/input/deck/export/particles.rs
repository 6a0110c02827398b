//! Writes particles as cards: elements, and parts with their section, material and equation.

use super::{Blank, DeckWriter, Id, LeftReason, Number, line};
use crate::input::deck::convert::particles::{ParticleSize, sound_speed};
use crate::input::job::Model;
use crumple_proto::job::{Part, ParticlesInput};
use crumple_proto::mesh::{MeshElement, Shape};
use toml::{Table, Value};

/// Returns the mass of a particle [mass].
fn mass(fluid: &ParticlesInput) -> f64 {
    fluid.density * fluid.spacing.powi(3)
}

/// Writes a part of particles with an individual material and equation of state `mid`. Numbers
/// that a reader computes with other digits are written after `$crumple:`.
pub fn part(deck: &mut DeckWriter, part: &Part, fluid: &ParticlesInput, mid: u64) {
    let id = u64::from(part.id);
    let name = line(&part.name);
    deck.keyword("MAT_NULL_TITLE");
    deck.text(&format!("{name}, {id}"));
    let cutoff = if fluid.tension == 0.0 { Blank } else { Number(-fluid.tension) };
    deck.card(&[Id(mid), Number(fluid.density), cutoff]);
    let speed = equation(deck, fluid, mid);
    deck.keyword("SECTION_SPH");
    deck.card(&[Id(id), Number(fluid.smoothing), Number(1.0), Number(1.0)]);
    // Zeros on a card mean the defaults.
    let has_viscosity = fluid.viscosity != [0.0; 2];
    if has_viscosity {
        let [linear, quadratic] = fluid.viscosity.map(Number);
        deck.keyword("HOURGLASS");
        deck.card(&[Id(id), Blank, Blank, Blank, quadratic, linear]);
    }
    deck.keyword("PART");
    deck.text(&name);
    let hourglass = if has_viscosity { Id(id) } else { Blank };
    deck.card(&[Id(id), Id(id), Id(mid), Id(mid), hourglass]);

    let [mut without, mut digits] = [Table::new(), Table::new()];
    let spacing = ParticleSize::Mass(mass(fluid)).spacing(fluid.density);
    let read = [("spacing", fluid.spacing, spacing), ("sound_speed", fluid.sound_speed, speed)];
    for (key, x, _) in read.iter().filter(|(_, x, back)| x.to_bits() != back.to_bits()) {
        digits.insert(key.to_string(), (*x).into());
    }
    if !has_viscosity {
        without.insert("viscosity".into(), fluid.viscosity.to_vec().into());
    }
    if let Some(radius) = fluid.contact_radius {
        without.insert("contact_radius".into(), radius.into());
    }
    let entry = |own: Table| {
        Table::from_iter([("id".into(), Value::from(part.id)), ("particles".into(), own.into())])
    };
    if !without.is_empty() {
        deck.entry("part", entry(without));
    }
    if !digits.is_empty() {
        deck.digits("part", entry(digits));
    }
}

/// Writes the equation of state of a fluid. Returns the speed of sound that a reader has
/// [length/time].
fn equation(deck: &mut DeckWriter, fluid: &ParticlesInput, eosid: u64) -> f64 {
    if let Some(constants) = fluid.hugoniot {
        deck.keyword("EOS_GRUNEISEN");
        let numbers = [fluid.sound_speed].into_iter().chain(constants).map(Number);
        deck.card(&[Id(eosid)].into_iter().chain(numbers).collect::<Vec<_>>());
        return fluid.sound_speed;
    }
    let (exponent, modulus) = (fluid.exponent(), fluid.bulk_modulus() / fluid.exponent());
    deck.keyword("EOS_MURNAGHAN");
    deck.card(&[Id(eosid), Number(exponent), Number(modulus)]);
    sound_speed(modulus, exponent, fluid.density)
}

/// Writes the elements in the order of their ids. A reader numbers them from the largest id of
/// other elements on; other ids are counted as lost.
pub fn elements(deck: &mut DeckWriter, model: &Model) {
    let is_particle = |e: &&MeshElement| e.shape == Shape::Point1;
    let mut particles: Vec<&MeshElement> = model.mesh.elements.iter().filter(is_particle).collect();
    if particles.is_empty() {
        return;
    }
    particles.sort_unstable_by_key(|e| e.id);
    let others = model.mesh.elements.iter().filter(|e| !is_particle(e));
    let last = others.map(|e| e.id.label()).max().unwrap_or(0);
    let lost = particles.iter().zip(last + 1..).filter(|(e, id)| e.id.label() != *id).count();
    if lost > 0 {
        deck.note("element ids of particles", LeftReason::Lost, lost);
    }
    deck.keyword("ELEMENT_SPH");
    for e in particles {
        let part = model.job.part.iter().find(|part| part.id == e.part);
        let Some(fluid) = part.and_then(|part| part.particles.as_ref()) else { continue };
        deck.card(&[Id(e.nodes[0].label()), Id(u64::from(e.part)), Number(mass(fluid))]);
    }
}
