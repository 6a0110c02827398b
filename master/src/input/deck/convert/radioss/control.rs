//! Converts `/BEGIN`, `/UNIT`, `/TITLE` and the engine file: units and settings of the run.

use super::StarterConverter;
use crate::input::deck::record::CardRecord;

/// Oldest version with fields of ten columns.
const OLDEST: i64 = 51;
/// Largest mass of mass scaling, as a fraction: a deck prescribes a step and accepts the mass.
const ANY_MASS: f64 = 1e9;
/// Units of a deck with other names in a job.
const NAMES: [(&str, &str); 5] =
    [("mg", "tonne"), ("t", "tonne"), ("ton", "tonne"), ("mus", "us"), ("sec", "s")];

impl StarterConverter {
    pub(super) fn control(&mut self) {
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
            let help = "its fields have 8 and 16 columns, which are not read: convert it to \
                        version 51 or later, whose fields have 10 and 20";
            self.deck.trouble.error(record.place("invers"), message, help);
        }
        let [mass, length, time] = units_of(record);
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
        let records = self.take(&["/UNIT"]);
        let known: Vec<String> = records.iter().map(|r| r.integer("id").to_string()).collect();
        for (unit, place) in std::mem::take(&mut self.units) {
            match records.iter().find(|r| r.integer("id") == unit) {
                Some(record) if units_of(record) == *own => {}
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

    /// Converts `/DT...`. The last factor of the file applies.
    fn steps(&mut self) {
        for record in self.take(&["/DT", "/DT/NODA", "/DT/BRICK", "/DT/NODA/CST"]) {
            let scale = record.real("scale");
            if scale > 0.0 {
                self.deck.tree.set_in("time", "safety", record.place("scale"), scale);
            }
            if record.row.keyword.name != "/DT/NODA/CST" || record.real("dtmin") <= 0.0 {
                continue;
            }
            let place = record.place("dtmin");
            let (least, scale) = (record.real("dtmin"), if scale > 0.0 { scale } else { 0.9 });
            self.deck.tree.set_in("time", "mass_scaling_dt", place, least / scale);
            self.deck.tree.set_in("time", "mass_scaling_limit", place, ANY_MASS);
            self.deck.map(
                "/DT/NODA/CST",
                format!("steps of nodes of at least {least}"),
                format!(
                    "steps of elements of at least {:.6e} before the safety factor; mass is added \
                     at the start only",
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
    // Mg and mg differ in a factor of 1e9.
    if name == "mg" {
        return name.into();
    }
    let lower = name.to_lowercase();
    NAMES.iter().find(|(of, _)| *of == lower).map_or(lower.clone(), |(_, own)| (*own).into())
}
