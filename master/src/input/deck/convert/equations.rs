//! Converts `*EOS_...` to keys of the materials of solids.

use super::DeckConverter;
use super::karagozian_case::COMPACTION;
use super::materials::DeckMaterial;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::{NodeContent, Place};
use std::collections::{BTreeMap, HashMap};

/// Keywords with constants, the keys of the job, and the fields that become their list.
const CONSTANTS: [(&str, &str, [&str; 6]); 2] = [
    (GRUNEISEN, "eos_gruneisen", ["c", "s1", "s2", "s3", "gamao", "a"]),
    ("EOS_LINEAR_POLYNOMIAL", "eos_polynomial", ["c1", "c2", "c3", "c4", "c5", "c6"]),
];

pub(super) const GRUNEISEN: &str = "EOS_GRUNEISEN";
const TABULATED: &str = "EOS_TABULATED";

/// The keyword for particles only.
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
        let others = [TABULATED, MURNAGHAN, COMPACTION];
        let names = CONSTANTS.map(|equation| equation.0).into_iter().chain(others);
        for keyword in names {
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
        for of_part in std::mem::take(&mut self.equations) {
            let PartEquation { ids: [part, mid, eosid], place } = of_part;
            let Some(material) = materials.get_mut(&mid) else { continue };
            if !material.takes_equation && !material.compacts {
                if eosid != 0 {
                    let why = "not used: the material has a pressure of its own; \
                               *MAT_JOHNSON_COOK, *MAT_ELASTIC_PLASTIC_HYDRO and *MAT_NULL take an \
                               equation of state";
                    self.map(format!("part {part}"), format!("eosid {eosid}"), why);
                }
                continue;
            }
            if eosid == 0 && material.needs_equation() {
                let message = format!(
                    "part {part}: its material {mid} has no pressure without an equation of state"
                );
                let help = "give eosid, the id of an *EOS_...";
                self.trouble.error(place, message, help);
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
            if material.compacts && other == part {
                self.compaction_of_part(&of_part, material);
            }
            if eosid == 0 || other != part || material.compacts {
                continue;
            }
            let Some(card) = self.equation_card(eosid, place) else { continue };
            let Some((key, value)) = self.pressure_key(&card, part, place) else { continue };
            self.fluid_of_solids([part, mid], material);
            if let Some(table) = &mut material.table {
                table.put(key, card.head, value);
                let used = format!("{key} of material {}", material.name);
                self.map(format!("part {part}"), format!("eosid {eosid}"), used);
                if let Some((pressure, at)) = material.least_pressure.take() {
                    table.put("eos_min_pressure", at, pressure);
                    let used = format!("eos_min_pressure of material {}", material.name);
                    self.map(format!("part {part}"), format!("cut-off {pressure:?}"), used);
                }
            }
        }
        let uncut = materials.iter().filter_map(|(mid, m)| Some((*mid, m.least_pressure?)));
        let uncut: BTreeMap<i64, (f64, Place)> = uncut.collect();
        for (mid, (pressure, at)) in uncut {
            let message = format!(
                "`pc` = {pressure:?} of material {mid} is ignored: no part of solids gives it an \
                 equation of state"
            );
            let help = "its tension has no limit; give its parts an eosid for a cut-off";
            self.trouble.warning(at, message, help);
        }
    }

    /// Returns the key of an equation of solids and its value. Reports one that they do not have.
    fn pressure_key(
        &mut self,
        card: &CardRecord,
        part: i64,
        place: Place,
    ) -> Option<(&'static str, NodeContent)> {
        let keyword = card.row.keyword.name;
        if let Some((_, key, fields)) = CONSTANTS.iter().find(|e| e.0 == keyword) {
            return Some((key, fields.map(|field| card.real(field)).into()));
        }
        if keyword == TABULATED {
            return Some(("eos_table", self.pressure_table(card)?.into()));
        }
        let only = match keyword {
            COMPACTION => "MAT_CONCRETE_DAMAGE_REL3",
            _ => "particles",
        };
        let message = format!("part {part}: {} is for {only} only", card.name());
        let help = "give it an *EOS_GRUNEISEN, *EOS_LINEAR_POLYNOMIAL or *EOS_TABULATED";
        self.trouble.error(place, message, help);
        None
    }

    /// Returns the rows -ln V, pressure and gamma T of an `*EOS_TABULATED`.
    fn pressure_table(&mut self, card: &CardRecord) -> Option<Vec<Vec<f64>>> {
        let gamma = card.real("gama");
        let mut rows: Vec<[f64; 3]> = if card.integer("lcc") != 0 {
            let cold = self.curve(card.integer("lcc"), card.place("lcc"))?.points;
            if gamma != 0.0 && card.integer("lct") == 0 {
                let why = "not used: there is no lct";
                self.map(card.name(), format!("gama {gamma}"), why);
            }
            let thermal = match card.integer("lct") {
                lct if lct != 0 && gamma != 0.0 => self.curve(lct, card.place("lct"))?.points,
                _ => cold.iter().map(|point| [point[0], 0.0]).collect(),
            };
            if !cold.iter().map(|p| p[0]).eq(thermal.iter().map(|p| p[0])) {
                let why = "a curve with other abscissas than those of lcc";
                self.unsupported_value(card, "lct", why);
            }
            cold.iter().zip(thermal).map(|(c, t)| [c[0], c[1], t[1]]).collect()
        } else {
            if card.integer("lct") != 0 {
                let why = "a curve of temperatures without one of pressures, lcc";
                self.unsupported_value(card, "lct", why);
            }
            let [ev, c, t] = ["ev", "c", "t"]
                .map(|name| card.lines(name).flat_map(|l| l.reals(name)).collect::<Vec<_>>());
            ev.into_iter().zip(c).zip(t).map(|((ev, c), t)| [ev, c, t]).collect()
        };
        // Blank points at the end are no points, but the origin may be the last one.
        let blank = rows.iter().rev().take_while(|row| **row == [0.0; 3]).count();
        rows.truncate(rows.len() - blank);
        if blank > 0 && rows.iter().all(|[ev, _, t]| *ev != 0.0 && *t == 0.0) {
            rows.push([0.0; 3]);
        }
        let mut rows: Vec<Vec<f64>> =
            rows.into_iter().map(|[ev, c, t]| vec![0.0 - ev, c, gamma * t]).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Some(rows)
    }

    /// Makes the material of a part of solids a fluid if it is an `*MAT_NULL`.
    fn fluid_of_solids(&mut self, [part, mid]: [i64; 2], material: &mut DeckMaterial) {
        let (Some(null), Some(table)) = (&material.fluid, &mut material.table) else { return };
        if let Some(skin) = self.skins.get(&mid) {
            let message = format!(
                "{}: material {mid} is a skin of the shells of part {skin} and a fluid of the \
                 solids of part {part}",
                null.name()
            );
            let help = "give the solids a material of their own";
            return self.trouble.error(null.place("mid"), message, help);
        }
        for key in ["youngs_modulus", "poisson"] {
            table.remove(key);
        }
        table.put("law", null.head, "fluid");
        table.put("viscosity", null.place("mu"), null.real("mu"));
        let cutoff = null.real("pc");
        if cutoff > 0.0 {
            let message = format!("{}: `pc` = {cutoff:?} is above 0", null.name());
            let help = "give minus the largest tension; 0 is none";
            self.trouble.error(null.place("pc"), message, help);
        }
        material.least_pressure = Some((cutoff.min(0.0), null.place("pc")));
        for (field, sign, key) in
            [("terod", 1.0, "erosion_volume_strain"), ("cerod", -1.0, "erosion_compression")]
        {
            let ratio = null.real(field);
            let strain = sign * ratio.ln();
            if ratio > 0.0 && strain > 0.0 {
                if table.has(key) {
                    let message =
                        format!("{}: `{field}` next to *MAT_ADD_EROSION voleps", null.name());
                    self.trouble.error(null.place(field), message, "keep one of them");
                } else {
                    table.put(key, null.place(field), strain);
                }
            } else if ratio != 0.0 {
                let message = format!("{}: `{field}` = {ratio:?} never fails", null.name());
                let help = "it is a ratio of volumes: terod is above 1, cerod from 0 to 1";
                self.trouble.error(null.place(field), message, help);
            }
        }
        let what = format!("law fluid of material {}", material.name);
        self.map(format!("part {part}"), null.name(), what);
    }

    /// Returns the cut-off of pressure that a material asks for, in `*MAT_JOHNSON_COOK` by spall 1,
    /// and its place. Reports a `pc` that is none: with other kinds of spall, or above 0. That of a
    /// fluid acts in parts of solids only.
    pub(super) fn least_pressure(
        &mut self,
        keyword: &str,
        record: &CardRecord,
    ) -> Option<(f64, Place)> {
        let (pc, place) = (record.real("pc"), record.place("pc"));
        let spall = match keyword {
            "MAT_JOHNSON_COOK" => record.real("spall"),
            // By default the pressure is cut off.
            "MAT_ELASTIC_PLASTIC_HYDRO" if record.real("spall") != 0.0 => record.real("spall"),
            "MAT_ELASTIC_PLASTIC_HYDRO" => 1.0,
            _ => return None,
        };
        if pc == 0.0 {
            if record.real("spall") != 0.0 {
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
