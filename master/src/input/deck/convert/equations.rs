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
                let used = format!("{key} of material {}", material.name);
                self.map(format!("part {part}"), format!("eosid {eosid}"), used);
                if let Some((pressure, at)) = material.least_pressure.take() {
                    table.put("eos_min_pressure", at, pressure);
                    let used = format!("eos_min_pressure of material {}", material.name);
                    self.map(format!("part {part}"), format!("spall 1, pc {pressure:?}"), used);
                }
            }
        }
        let uncut = materials.iter().filter_map(|(mid, m)| Some((*mid, m.least_pressure?)));
        let uncut: BTreeMap<i64, (f64, Place)> = uncut.collect();
        for (mid, (pressure, at)) in uncut {
            let message = format!(
                "*MAT_JOHNSON_COOK: `pc` = {pressure:?} of material {mid} is ignored: no part of \
                 solids gives it an equation of state"
            );
            let help = "its tension has no limit; give its parts an eosid for a cut-off";
            self.trouble.warning(at, message, help);
        }
    }

    /// Returns the cut-off of pressure that a material asks for by spall 1, and its place. Reports
    /// a `pc` that is none: with other kinds of spall, or above 0.
    pub(super) fn least_pressure(&mut self, record: &CardRecord) -> Option<(f64, Place)> {
        let (pc, spall, place) = (record.real("pc"), record.real("spall"), record.place("pc"));
        if pc == 0.0 {
            if spall != 0.0 {
                let why = "not used: pc is 0, which is no limit of tension";
                self.map(record.name(), format!("spall {spall}"), why);
            }
            return None;
        }
        let help = match (spall == 1.0, pc < 0.0) {
            (true, true) => return Some((pc, place)),
            (true, false) => "a cut-off of tension is below 0; tension has no limit here",
            (false, _) => {
                "tension has no limit here, and no element spalls; spall 1 with an equation of \
                 state cuts off tension at pc"
            }
        };
        let message = format!("{}: `pc` = {pc:?} with `spall` = {spall} is ignored", record.name());
        self.trouble.warning(place, message, help);
        None
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
