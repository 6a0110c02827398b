//! Converts `*CONTROL_...`, `*DATABASE_...`, `*TITLE`: settings of the run.

use super::DeckConverter;
use crate::input::deck::record::CardRecord;

impl DeckConverter {
    pub(super) fn control(&mut self) {
        for record in self.take_records("TITLE") {
            let title = record.word("text").to_string();
            self.tree.set("title", record.place("text"), title);
        }
        for record in self.take_one("CONTROL_TERMINATION") {
            self.end_time = record.real("endtim");
            self.tree.set("end_time", record.place("endtim"), self.end_time);
            if record.integer("endcyc") > 0 {
                self.tree.set_in(
                    "time",
                    "max_cycles",
                    record.place("endcyc"),
                    record.integer("endcyc"),
                );
            }
            if record.real("dtmin") > 0.0 {
                self.tree.set_in(
                    "time",
                    "dt_min_ratio",
                    record.place("dtmin"),
                    record.real("dtmin"),
                );
            }
        }
        for record in self.take_one("CONTROL_TIMESTEP") {
            if record.real("tssfac") > 0.0 {
                self.tree.set_in("time", "safety", record.place("tssfac"), record.real("tssfac"));
            }
            let scaled = record.real("dt2ms");
            if scaled != 0.0 {
                let place = record.place("dt2ms");
                self.tree.set_in("time", "mass_scaling_dt", place, scaled.abs());
                // A deck prescribes a step and accepts the mass that it needs. The run warns of
                // the fraction of added mass.
                self.tree.set_in("time", "mass_scaling_limit", place, 1e9);
                let used = match scaled < 0.0 {
                    true => "mass is added to elements with a smaller stable step",
                    false => {
                        "as for a negative dt2ms: mass is added where needed, and never removed"
                    }
                };
                self.map("time step", format!("dt2ms {scaled}"), used);
            }
            if record.integer("lctm") != 0 {
                self.unsupported_value(&record, "lctm", "a curve that limits the time step");
            }
        }
        for record in self.take_one("DATABASE_GLSTAT").into_iter().filter(|r| r.real("dt") > 0.0) {
            self.tree.set_in("output", "history_interval", record.place("dt"), record.real("dt"));
        }
        for record in self.take_one("DATABASE_BINARY_D3PLOT") {
            let (dt, count) = (record.real("dt"), record.integer("npltc"));
            if count > 0 && self.end_time > 0.0 {
                self.tree.set_in(
                    "output",
                    "field_interval",
                    record.place("npltc"),
                    self.end_time / count as f64,
                );
            } else if dt > 0.0 {
                self.tree.set_in("output", "field_interval", record.place("dt"), dt);
            }
        }
        for record in self.take_one("DAMPING_GLOBAL") {
            if record.integer("lcid") != 0 {
                self.unsupported_value(&record, "lcid", "time-dependent damping");
            }
            let factors = ["stx", "sty", "stz", "srx", "sry", "srz"];
            if factors.iter().any(|f| !matches!(record.real(f), 0.0 | 1.0)) {
                self.unsupported_value(&record, "stx", "damping that depends on the direction");
            }
            self.tree.set_in("time", "damping", record.place("valdmp"), record.real("valdmp"));
        }
    }

    /// Returns the records of a keyword that a deck needs once. Warns if there are more; the last
    /// one counts.
    fn take_one(&mut self, name: &str) -> Vec<CardRecord> {
        let records = self.take_records(name);
        if let [_, .., last] = &records[..] {
            let message = format!("*{name} occurs {} times: the last one counts", records.len());
            self.trouble.warning(last.head, message, "remove the others");
        }
        records
    }
}
