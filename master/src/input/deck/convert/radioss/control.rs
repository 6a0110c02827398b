//! Converts `/BEGIN`, `/UNIT`, `/TITLE` and the engine file: units and settings of the run.

use super::StarterConverter;
use crate::input::deck::record::CardRecord;

/// Oldest version whose cards have the columns of the table.
const OLDEST: i64 = 110;
/// Factor of steps without a card.
const SAFETY: f64 = 0.9;
/// Largest mass of mass scaling, as a fraction: a deck prescribes a step and accepts the mass.
const ANY_MASS: f64 = 1e9;
/// Units of mass, length and time without others.
const SYSTEM: [&str; 3] = ["kg", "m", "s"];
/// Units of a deck with other names in a job.
const NAMES: [(&str, &str); 5] =
    [("mg", "tonne"), ("t", "tonne"), ("ton", "tonne"), ("mus", "us"), ("sec", "s")];

impl StarterConverter {
    pub(super) fn control(&mut self) {
        // A noise is ignored with a warning.
        self.take(&["/RANDOM"]);
        for record in self.take(&["/TITLE"]) {
            let title = record.word("text").to_string();
            self.deck.tree.set("title", record.place("text"), title);
        }
        let begin = self.take(&["/BEGIN"]);
        let own = begin.first().map(units_of).unwrap_or_default();
        for record in &begin {
            self.begin(record);
        }
        self.other_units(&own);
        for record in self.take(&["/RUN"]) {
            self.deck.end_time = record.real("tend");
            let end = self.deck.end_time;
            self.deck.tree.set("end_time", record.place("tend"), end);
        }
        for (name, key, field) in [
            ("/TFILE", "history_interval", "dt"),
            ("/ANIM/DT", "field_interval", "dt"),
            ("/H3D/DT", "field_interval", "dt"),
        ] {
            for record in self.take(&[name]).iter().filter(|r| r.real(field) > 0.0) {
                self.deck.tree.set_in("output", key, record.place(field), record.real(field));
            }
        }
        for record in self.take(&["/DTIX"]).iter().filter(|r| r.real("dtmax") > 0.0) {
            let place = record.place("dtmax");
            self.deck.tree.set_in("time", "dt_max", place, record.real("dtmax"));
        }
        self.steps();
    }

    fn begin(&mut self, record: &CardRecord) {
        let version = record.integer("invers");
        if version != 0 && version < OLDEST {
            let message = format!("the deck has the version {version} of the format");
            let help = "its cards have other fields and columns: convert it to version 110 or \
                        later with the starter of Radioss";
            // Fields in other columns would only give misleading errors.
            self.deck.trouble.only(record.place("invers"), message, help);
        }
        let [mass, length, time] = units_of(record);
        if [&mass, &length, &time].iter().any(|unit| !unit.is_empty()) {
            self.unit_names = Some(format!("{length}, {time}, {mass}"));
        }
        if [&mass, &length, &time].iter().all(|unit| !unit.is_empty()) {
            let units = format!("{length}, {time}, {mass}");
            self.deck.tree.set("units", record.place("inmass"), units);
        }
        let work = ["wmass", "wlength", "wtime"].map(|field| unit(record.word(field)));
        if work.iter().any(|unit| !unit.is_empty()) && work != [mass, length, time] {
            self.deck.map(
                "units",
                format!("work units {}", work.join(", ")),
                "not used: results have the input units",
            );
        }
    }

    /// Reports entities in other units than those of the deck.
    fn other_units(&mut self, own: &[String; 3]) {
        // Units that /BEGIN leaves blank are those of the International System.
        let mut own = own.clone();
        for (unit, default) in own.iter_mut().zip(SYSTEM).filter(|(unit, _)| unit.is_empty()) {
            *unit = default.into();
        }
        let records = self.take(&["/UNIT"]);
        let known: Vec<String> = records.iter().map(|r| r.integer("id").to_string()).collect();
        for (unit, place) in std::mem::take(&mut self.units) {
            match records.iter().find(|r| r.integer("id") == unit) {
                Some(record) if units_of(record) == own => {}
                Some(record) => {
                    let message = format!(
                        "values in the units {} of /UNIT/{unit} are not converted",
                        units_of(record).join(", ")
                    );
                    let help = format!("give them in the units of /BEGIN: {}", own.join(", "));
                    self.deck.trouble.error(place, message, help);
                }
                None => self.deck.missing(place, "/UNIT", unit, &known),
            }
        }
        // A system without a reference is no problem.
        records.iter().for_each(|record| {
            units_of(record);
        });
    }

    /// Converts `/DT...`. A deck has factors for kinds of elements and nodes, a job has one: the
    /// smallest.
    fn steps(&mut self) {
        let records = self.take(&["/DT", "/DT/NODA", "/DT/BRICK", "/DT/NODA/CST"]);
        let scaled = records.iter().map(|r| (r.real("scale"), r.place("scale")));
        let mut scales: Vec<_> = scaled.filter(|(scale, _)| *scale > 0.0).collect();
        scales.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let [(least, place), ..] = scales[..] {
            self.deck.tree.set_in("time", "safety", place, least);
            if scales.iter().any(|(scale, _)| *scale != least) {
                let all: Vec<String> = scales.iter().map(|s| s.0.to_string()).collect();
                let asked = format!("factors {} of steps", all.join(", "));
                self.deck.map("/DT", asked, format!("the smallest, {least}, for all"));
            }
        }
        let scale = scales.first().map_or(SAFETY, |s| s.0);
        for record in records.iter().filter(|r| r.row.keyword.name == "/DT/NODA/CST") {
            let (least, place) = (record.real("dtmin"), record.place("dtmin"));
            if least <= 0.0 {
                continue;
            }
            self.deck.tree.set_in("time", "mass_scaling_dt", place, least / scale);
            self.deck.tree.set_in("time", "mass_scaling_limit", place, ANY_MASS);
            self.deck.map(
                "/DT/NODA/CST",
                format!("steps of nodes of at least {least}"),
                format!(
                    "steps of elements of at least {:.6e} before the safety factor; mass is added \
                     at the start only, without a limit (mass_scaling_limit {ANY_MASS:e})",
                    least / scale
                ),
            );
        }
    }
}

/// Returns the units of mass, length and time of a record.
fn units_of(record: &CardRecord) -> [String; 3] {
    ["inmass", "inlength", "intime"].map(|field| unit(record.word(field)))
}

/// Returns the name of a unit in a job.
fn unit(name: &str) -> String {
    // Mega and milli differ in a factor of 1e9.
    if ["mg", "Mm", "Ms"].contains(&name) {
        return name.into();
    }
    let lower = name.to_lowercase();
    NAMES.iter().find(|(of, _)| *of == lower).map_or(lower.clone(), |(_, own)| (*own).into())
}
