//! Converts damage that is added to any plastic material: `*MAT_ADD_DAMAGE_GISSMO`, and the same
//! model in `*MAT_ADD_EROSION` (LS-DYNA Keyword User's Manual, vol. II).

use super::DeckConverter;
use super::materials::{DeckMaterial, rows};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::HashMap;

/// Fields of the model that are not supported, with the reason. `*MAT_ADD_EROSION` has no `instf`.
const REFUSED: [(&str, &str); 8] = [
    ("instf", "F grows with the strain, and the exponent is a constant"),
    ("lcsrs", "the strain to failure has no strain rate"),
    ("shrf", "the factors of size are the same in all states of stress"),
    ("biaxf", "the factors of size are the same in all states of stress"),
    ("lcdlim", "damage has no limit"),
    ("midfail", "each point has its own damage"),
    ("soft", "elements at a crack have the same strain to failure"),
    ("lp2bi", "there is no bending indicator"),
];

impl DeckConverter {
    /// Adds `*MAT_ADD_DAMAGE_GISSMO` to the materials.
    pub(super) fn damage(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        for record in self.take_records("MAT_ADD_DAMAGE_GISSMO") {
            let (id, place) = (record.integer("mid"), record.place("mid"));
            let Some(material) = materials.get_mut(&id) else {
                let known: Vec<String> = materials.keys().map(i64::to_string).collect();
                self.missing(place, "*MAT_...", id, &known);
                continue;
            };
            let Some(table) = &mut material.table else { continue };
            self.gissmo(&record, "dtyp", table);
        }
    }

    /// Converts the fields of the model, which both keywords have. `kind` is the field that says
    /// what damage does.
    pub(super) fn gissmo(&mut self, record: &CardRecord, kind: &str, table: &mut JobTable) {
        match record.real(kind) {
            1.0 => {}
            0.0 => {
                let of = format!("material {}", record.integer("mid"));
                self.map(of, format!("GISSMO with {kind} 0"), "not used: it only shows the damage");
                return;
            }
            _ => {
                self.unsupported_value(record, kind, "damage by other histories; use 1");
                return;
            }
        }
        if let Some(first) = table.place_of("gissmo_failure_strain") {
            self.second_card(record, "damage", [first, record.place("lcsdg")]);
            return;
        }
        for (field, why) in REFUSED.iter().filter(|(field, _)| record.real(field) != 0.0) {
            self.unsupported_value(record, field, why);
        }
        let id = record.integer("lcsdg");
        if id <= 0 {
            self.unsupported_value(record, "lcsdg", "give a curve of the strain to failure");
            return;
        }
        self.damage_curve(record, ("lcsdg", id), "gissmo_failure_strain", table);
        let (critical, damage) = (record.real("ecrit"), record.real("dcrit"));
        if critical != 0.0 && damage != 0.0 {
            let of = format!("material {}", record.integer("mid"));
            self.map(of, format!("dcrit {damage}"), "not used: ecrit is given");
        }
        if critical < 0.0 {
            let id = -critical as i64;
            self.damage_curve(record, ("ecrit", id), "gissmo_critical_strain", table);
        } else if critical > 0.0 {
            let rows = vec![vec![0.0, critical]];
            table.put("gissmo_critical_strain", record.place("ecrit"), rows);
        } else {
            table.put("gissmo_critical_damage", record.place("dcrit"), damage);
        }
        table.put("gissmo_exponent", record.place("dmgexp"), record.real_or("dmgexp", 1.0));
        let fading = record.real_or("fadexp", 1.0);
        if fading < 0.0 {
            self.unsupported_value(record, "fadexp", "a curve over the size of the element");
        } else {
            table.put("gissmo_fading_exponent", record.place("fadexp"), fading);
        }
        match record.integer("lcregd") {
            0 => {}
            id if id < 0 => {
                let why = "factors over the triaxiality; give a curve over the size";
                self.unsupported_value(record, "lcregd", why);
            }
            id => self.damage_curve(record, ("lcregd", id), "gissmo_size_factors", table),
        }
        let points = record.real_or("numfip", 1.0);
        table.put("gissmo_failed_points", record.place("numfip"), points);
    }

    /// Reports that two cards give a material the same; both their places are named.
    pub(super) fn second_card(&mut self, record: &CardRecord, what: &str, places: [Place; 2]) {
        let id = record.integer("mid");
        for (place, which) in places.into_iter().zip(["first", "second"]) {
            let message = format!("material {id} has {what} by two cards: this is the {which} one");
            let help = "keep one of them: *MAT_ADD_DAMAGE_GISSMO, or *MAT_ADD_EROSION, which gives \
                        damage with idam 1";
            self.trouble.error(place, message, help);
        }
    }

    fn damage_curve(
        &mut self,
        record: &CardRecord,
        (field, id): (&str, i64),
        key: &str,
        table: &mut JobTable,
    ) {
        if self.tables.contains_key(&id) {
            self.unsupported_value(record, field, "a table; give a curve");
        } else if let Some(curve) = self.curve(id, record.place(field)) {
            table.put(key, record.place(field), rows(&curve.points));
        }
    }
}
