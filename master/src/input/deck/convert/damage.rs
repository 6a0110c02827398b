//! Converts damage that is added to any plastic material: `*MAT_ADD_DAMAGE_GISSMO`, and the same
//! model in `*MAT_ADD_EROSION`; `*MAT_ADD_DAMAGE_DIEM` (LS-DYNA Keyword User's Manual, vol. II).

use super::DeckConverter;
use super::materials::{DeckMaterial, rows};
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
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

/// Criteria by dityp: keys of the curve, of the factor of the pressure, of the displacement, of the
/// energy, and of the multiplication.
const ONSETS: [(i64, [&str; 5]); 3] = [
    (
        0,
        [
            "diem_ductile",
            "",
            "diem_ductile_displacement",
            "diem_ductile_energy",
            "diem_ductile_multiplied",
        ],
    ),
    (
        1,
        [
            "diem_shear",
            "diem_shear_pressure",
            "diem_shear_displacement",
            "diem_shear_energy",
            "diem_shear_multiplied",
        ],
    ),
    (
        4,
        [
            "diem_principal",
            "diem_principal_pressure",
            "diem_principal_displacement",
            "diem_principal_energy",
            "diem_principal_multiplied",
        ],
    ),
];

impl DeckConverter {
    /// Adds `*MAT_ADD_DAMAGE_GISSMO` to the materials.
    pub(super) fn damage(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        for record in self.take_records("MAT_ADD_DAMAGE_GISSMO") {
            let Some(table) = self.damaged_material(&record, materials) else { continue };
            self.gissmo(&record, "dtyp", table);
        }
    }

    /// Returns the material of a card of damage, if it can have any; it is missing with an error.
    fn damaged_material<'m>(
        &mut self,
        record: &CardRecord,
        materials: &'m mut HashMap<i64, DeckMaterial>,
    ) -> Option<&'m mut JobTable> {
        let id = record.integer("mid");
        if !materials.contains_key(&id) {
            let known: Vec<String> = materials.keys().map(i64::to_string).collect();
            self.missing(record.place("mid"), "*MAT_...", id, &known);
        }
        materials.get_mut(&id)?.table.as_mut()
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

    /// Adds `*MAT_ADD_DAMAGE_DIEM` to the materials.
    pub(super) fn damage_from_onset(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        for record in self.take_records("MAT_ADD_DAMAGE_DIEM") {
            let Some(table) = self.damaged_material(&record, materials) else { continue };
            let has_gissmo = table.place_of("gissmo_failure_strain");
            if let Some(first) = table.place_of("diem_failed_points").or(has_gissmo) {
                self.second_card(&record, "damage", [first, record.place("mid")]);
                continue;
            }
            let count = record.real("ndiemc");
            let [onsets, evolutions] =
                ["dityp", "detyp"].map(|field| record.lines(field).cloned().collect::<Vec<_>>());
            let complete = onsets.len().min(evolutions.len());
            if !(1.0..=5.0).contains(&count) || complete < count as usize {
                let message = format!("{}: ndiemc is {count}", record.name());
                let help = "give 1 to 5 criteria, each with its two cards";
                self.trouble.error(record.place("ndiemc"), message, help);
                continue;
            }
            let mut any = false;
            for (onset, evolution) in onsets.iter().zip(&evolutions).take(count as usize) {
                any |= self.onset(&record, [onset, evolution], table);
            }
            if any {
                let points = record.real_or("numfip", 1.0);
                table.put("diem_failed_points", record.place("numfip"), points);
            }
        }
    }

    /// Converts a criterion, wholly or not at all. Returns false if it was not converted.
    fn onset(
        &mut self,
        record: &CardRecord,
        [onset, evolution]: [&CardLine; 2],
        table: &mut JobTable,
    ) -> bool {
        let kind = onset.integer("dityp");
        let keys = ONSETS.iter().find(|(dityp, _)| *dityp == kind).map(|(_, keys)| keys);
        let (id, growth) = (onset.integer("p1"), evolution.real("q1"));
        let taken = keys.is_some_and(|keys| table.place_of(keys[0]).is_some());
        let refused: Vec<(&CardLine, &str, &str)> = [
            (onset, "dityp", keys.is_none(), "criteria of thin sheets (FLD, MSFLD)"),
            (onset, "dityp", taken, "a criterion that stands before; give each one once"),
            (onset, "p1", self.tables.contains_key(&id), "a table over the strain rate"),
            (
                onset,
                "p5",
                onset.real("p5") != 0.0,
                "a factor by the size of the element on the strain at onset",
            ),
            (evolution, "q1", growth < 0.0, "a table over the triaxiality and the damage"),
            (
                evolution,
                "q3",
                evolution.real("q3") != 0.0,
                "damage that is not linear in the displacement",
            ),
            (
                evolution,
                "q4",
                evolution.real("q4") != 0.0,
                "a factor by the size of the element on q1",
            ),
            (evolution, "detyp", !(0..=1).contains(&evolution.integer("detyp")), "use 0 or 1"),
            (evolution, "dctyp", !(-1..=1).contains(&evolution.integer("dctyp")), "use 0 or 1"),
        ]
        .into_iter()
        .filter_map(|(line, field, is_refused, why)| is_refused.then_some((line, field, why)))
        .collect();
        for (line, field, why) in &refused {
            let value = line.real(field);
            let message = format!("{}: `{field}` = {value} is not supported: {why}", record.name());
            let lost = format!("the criterion of {} {field}", record.name());
            self.unsupported(line.place(field), message, lost);
        }
        let Some(keys) = keys.filter(|_| refused.is_empty()) else { return false };
        if evolution.integer("dctyp") == -1 {
            let of = format!("material {}", record.integer("mid"));
            let asked = format!("DIEM with dityp {kind} and dctyp -1");
            self.map(of, asked, "not used: it only shows the damage");
            return false;
        }
        let Some(curve) = self.curve(id, onset.place("p1")) else { return false };
        table.put(keys[0], onset.place("p1"), rows(&curve.points));
        if onset.real("p2") != 0.0 && !keys[1].is_empty() {
            table.put(keys[1], onset.place("p2"), onset.real("p2"));
        }
        let by_energy = evolution.integer("detyp") == 1;
        table.put(keys[if by_energy { 3 } else { 2 }], evolution.place("q1"), growth);
        if evolution.integer("dctyp") == 1 {
            table.put(keys[4], evolution.place("dctyp"), true);
        }
        true
    }

    /// Reports that two cards give a material the same; both their places are named.
    pub(super) fn second_card(&mut self, record: &CardRecord, what: &str, places: [Place; 2]) {
        let id = record.integer("mid");
        for (place, which) in places.into_iter().zip(["first", "second"]) {
            let message = format!("material {id} has {what} by two cards: this is the {which} one");
            let help = "keep one of them: *MAT_ADD_DAMAGE_GISSMO, *MAT_ADD_DAMAGE_DIEM, or \
                        *MAT_ADD_EROSION, which gives damage with idam 1";
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
