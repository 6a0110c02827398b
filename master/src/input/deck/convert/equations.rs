//! Converts `*EOS_...` to keys of the materials of solids.

use super::DeckConverter;
use super::materials::DeckMaterial;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::{BTreeMap, HashMap};

/// Keywords, the keys of the job, and the fields that become their list.
const EQUATIONS: [(&str, &str, [&str; 6]); 2] = [
    ("EOS_GRUNEISEN", "eos_gruneisen", ["c", "s1", "s2", "s3", "gamao", "a"]),
    ("EOS_LINEAR_POLYNOMIAL", "eos_polynomial", ["c1", "c2", "c3", "c4", "c5", "c6"]),
];

/// The keyword for particles.
pub(super) const MURNAGHAN: &str = "EOS_MURNAGHAN";

/// The equation of a part of solids.
#[derive(Debug)]
pub struct PartEquation {
    /// Part, material, equation; 0 for none.
    pub ids: [i64; 3],
    /// Place of the id of the equation.
    pub place: Place,
}

impl DeckConverter {
    /// Reads the cards of equations.
    pub(super) fn read_equations(&mut self) {
        for keyword in EQUATIONS.map(|equation| equation.0).into_iter().chain([MURNAGHAN]) {
            for record in self.take_records(keyword) {
                let (id, place) = (record.integer("eosid"), record.place("eosid"));
                self.starting_state(&record);
                if self.equation_cards.insert(id, record).is_some() {
                    let message = format!("there are two equations of state with the id {id}");
                    self.trouble.error(place, message, "give each a different id");
                }
            }
        }
    }

    /// Returns the card of the equation of state of a part. Reports one that does not exist.
    pub(super) fn equation_card(&mut self, eosid: i64, place: Place) -> Option<CardRecord> {
        let found = self.equation_cards.get(&eosid).cloned();
        if found.is_none() {
            let known: Vec<String> = self.equation_cards.keys().map(i64::to_string).collect();
            self.missing(place, "*EOS_...", eosid, &known);
        }
        found
    }

    /// Gives each material the equation of its parts.
    pub(super) fn equations_of_state(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        let mut first: BTreeMap<i64, [i64; 2]> = BTreeMap::new();
        for PartEquation { ids: [part, mid, eosid], place } in std::mem::take(&mut self.equations) {
            let Some(material) = materials.get_mut(&mid) else { continue };
            if !material.takes_equation {
                if eosid != 0 {
                    let why = "not used: only *MAT_JOHNSON_COOK takes an equation of state";
                    self.map(format!("part {part}"), format!("eosid {eosid}"), why);
                }
                continue;
            }
            let &mut [other, before] = first.entry(mid).or_insert([part, eosid]);
            if before != eosid {
                let message = format!(
                    "part {part}: its material {mid} has the equation of state {before} in part \
                     {other}, and {eosid} here"
                );
                let help = "give one of the parts a material of its own";
                self.trouble.error(place, message, help);
            }
            if eosid == 0 || other != part {
                continue;
            }
            let Some(card) = self.equation_card(eosid, place) else { continue };
            let of_solids = EQUATIONS.iter().find(|e| e.0 == card.row.keyword.name);
            let Some(&(_, key, fields)) = of_solids else {
                let message = format!("part {part}: {} is for particles only", card.name());
                let help = "give it an *EOS_GRUNEISEN or an *EOS_LINEAR_POLYNOMIAL";
                self.trouble.error(place, message, help);
                continue;
            };
            if let Some(table) = &mut material.table {
                table.put(key, card.place(fields[0]), fields.map(|field| card.real(field)));
                if let Some((pressure, at)) = material.least_pressure {
                    table.put("eos_min_pressure", at, pressure);
                }
                let used = format!("{key} of material {}", material.name);
                self.map(format!("part {part}"), format!("eosid {eosid}"), used);
            }
        }
    }

    /// Refuses a pressure and a volume at the start.
    fn starting_state(&mut self, record: &CardRecord) {
        if ![0.0, 1.0].contains(&record.real("v0")) {
            self.unsupported_value(record, "v0", "a volume at the start; use 1");
        }
        for (field, why) in
            [("e0", "an energy at the start; use 0"), ("c0", "a pressure at the start; use 0")]
        {
            if record.real(field) != 0.0 {
                self.unsupported_value(record, field, why);
            }
        }
    }
}
