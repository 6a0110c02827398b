//! Converts `*CONTROL_...`, `*DATABASE_...`, `*TITLE`: settings of the run.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::NodeContent;
use crate::input::job::tree::Place;

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
                    true => "mass is added at the start to elements with a smaller stable step",
                    false => {
                        "as for a negative dt2ms: mass is added at the start where needed, and \
                         never removed"
                    }
                };
                self.map("time step", format!("dt2ms {scaled}"), used);
            }
            if record.integer("erode") == 1 {
                self.eroding = Some(record.place("erode"));
                let used = "inverted = \"delete\" of all parts of solids, by dtmin, or 0.001 if it \
                            is blank; shells end the run";
                self.map("time step", "erode 1", used);
            }
            self.step_limit(&record);
        }
        for record in self.take_one("CONTROL_DYNAMIC_RELAXATION") {
            if record.integer("idrflg") > 0 {
                let why = "a relaxation before the run; run the preload in the time of the run, \
                           with time.damping";
                self.unsupported_value(&record, "idrflg", why);
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
            self.field_times(&record, dt > 0.0 || count > 0);
        }
        for record in self.take_one("DATABASE_EXTENT_BINARY") {
            // The last digit is for the strains, others are for rates and plastic strains.
            if record.integer("strflg") % 10 == 1 {
                self.tree.set_in("output", "strains", record.place("strflg"), true);
            }
        }
        for record in self.take_one("DAMPING_GLOBAL") {
            // A curve replaces the value of the card.
            let (id, place) = (record.integer("lcid"), record.place("lcid"));
            let given = match id {
                0 => Some(record.real("valdmp")),
                _ => self.constant_curve(id, place),
            };
            let at = if id == 0 { record.place("valdmp") } else { place };
            let factor = self.damping_factor(&record);
            if let Some(given) = given {
                self.tree.set_in("time", "damping", at, given * factor);
            } else if factor != 0.0
                && let Some(curve) = self.time_curve(id, place)
            {
                self.tree.set_in("time", "damping", at, factor);
                self.tree.set_in("time", "damping_curve", at, curve);
            }
        }
    }

    /// Converts `*CONTROL_ADAPTIVE`, for the parts that have been converted.
    pub(super) fn adaptivity(&mut self) {
        let records = self.take_one("CONTROL_ADAPTIVE");
        let (parts, others): (Vec<_>, Vec<_>) = std::mem::take(&mut self.adaptive)
            .into_iter()
            .partition(|(_, (value, _))| *value == 1 && !records.is_empty());
        for (id, (value, place)) in others {
            let message = format!("*PART: `adpopt` = {value} of part {id} is ignored");
            let help = "1 with *CONTROL_ADAPTIVE divides the shells of a part where they bend";
            self.trouble.warning(place, message, help);
        }
        let parts: Vec<i64> = parts.into_iter().map(|(id, _)| id).collect();
        for record in records {
            let kind = record.integer("adptyp");
            let angle = record.real("adptol");
            let bends = matches!(kind, 1 | 2) && (angle > 0.0 && angle < 180.0);
            if !bends || parts.is_empty() || record.integer("maxlvl") < 2 {
                let message = match (bends, parts.is_empty()) {
                    (true, true) => {
                        "*CONTROL_ADAPTIVE: no part has adpopt 1; the mesh stays as it is"
                    }
                    (true, false) => {
                        "*CONTROL_ADAPTIVE: maxlvl 1 has no refinement; the mesh stays as it is"
                    }
                    _ => {
                        "*CONTROL_ADAPTIVE: only adptyp 1 and 2 with an angle adptol refine the \
                         mesh; it stays as it is"
                    }
                };
                let help = "give a mesh that is fine enough where the sheet bends, or [adaptivity]";
                self.trouble.warning(record.head, message, help);
                continue;
            }
            let mut set = |key: &str, field: &str, value: NodeContent| {
                self.tree.set_in("adaptivity", key, record.place(field), value);
            };
            set("parts", "adptyp", parts.clone().into());
            set("angle", "adptol", angle.into());
            set("levels", "maxlvl", (record.integer("maxlvl") - 1).min(4).into());
            set("interval", "adpfreq", record.real("adpfreq").max(0.0).into());
            set("begin", "tbirth", record.real("tbirth").max(0.0).into());
            let end = record.real("tdeath");
            if end > record.real("tbirth") && end < 1e19 {
                set("end", "tdeath", end.into());
            }
            let used = "shells are divided by their own plastic bending angle, with a ring of \
                        neighbours";
            self.map("adaptivity", format!("adptyp {kind}, {angle} degrees"), used);
        }
    }

    /// Converts `*DAMPING_PART_MASS`, and checks `*DAMPING_PART_STIFFNESS`.
    pub(super) fn part_damping(&mut self) {
        for (record, parts, place) in self.damped_parts("DAMPING_PART_MASS") {
            let factor =
                if record.integer("flag") == 1 { self.damping_factor(&record) } else { 1.0 };
            let at = record.place("lcid");
            let Some(curve) = self.time_curve(record.integer("lcid"), at) else { continue };
            let table = JobTable::new(record.head)
                .with("coefficient", record.place("sf"), factor * record.real("sf"))
                .with("parts", place, parts)
                .with("curve", at, curve);
            self.add("damping", table);
        }
        for (record, ..) in self.damped_parts("DAMPING_PART_STIFFNESS") {
            if record.real("coef") < 0.0 {
                let why = "a damping by the stiffness, beta [time]: remove it, or damp low \
                           frequencies by *DAMPING_PART_MASS";
                self.unsupported_value(&record, "coef", why);
            }
        }
    }

    /// Returns the records of a keyword and of its form for sets, with the parts that they name and
    /// the place of these; a record without parts is reported.
    fn damped_parts(&mut self, keyword: &'static str) -> Vec<(CardRecord, Vec<i64>, Place)> {
        let single = self.take_records(keyword).into_iter().map(|record| (record, "pid"));
        let of_sets = self.take_records(&format!("{keyword}_SET"));
        let all: Vec<_> =
            single.chain(of_sets.into_iter().map(|record| (record, "psid"))).collect();
        let mut found = Vec::new();
        for (record, field) in all {
            let place = record.place(field);
            let parts = self.parts_named(field, record.integer(field), place);
            if !parts.is_empty() {
                found.push((record, parts, place));
            }
        }
        found
    }

    /// Returns the ordinate of a curve that is constant up to the end of the run; 0 without the
    /// curve, which is reported.
    fn constant_curve(&mut self, id: i64, place: Place) -> Option<f64> {
        let Some(curve) = self.curve(id, place) else { return Some(0.0) };
        let first = curve.points.first().map_or(0.0, |point| point[1]);
        let within = curve.points.iter().take_while(|point| point[0] <= self.end_time);
        let lasts = curve.points.last().is_some_and(|last| last[0] >= self.end_time);
        let begins = curve.points.first().is_some_and(|first| first[0] <= 0.0);
        let is_constant = begins && lasts && within.clone().all(|point| point[1] == first);
        // The point after the end gives the slope up to it.
        let after = curve.points.iter().find(|point| point[0] > self.end_time);
        let ends = within.last().is_some_and(|last| last[0] == self.end_time);
        let is_level = ends || after.is_none_or(|point| point[1] == first);
        (is_constant && is_level).then_some(first)
    }

    /// Converts the curve of the intervals of fields, if its abscissas are their times.
    fn field_times(&mut self, record: &CardRecord, has_interval: bool) {
        let (id, place) = (record.integer("lcdt"), record.place("lcdt"));
        let form = record.integer("ioopt");
        if id == 0 {
            return;
        }
        if form != 3 {
            let message = format!("{}: lcdt {id} is not used", record.name());
            let help = "the interval of fields is constant: give dt, or ioopt 3 for the times \
                        themselves";
            return self.trouble.warning(place, message, help);
        }
        let Some(curve) = self.curve(id, place) else { return };
        let end = self.end_time;
        let times: Vec<f64> = curve.points.iter().map(|point| point[0]).collect();
        let times: Vec<f64> = times.into_iter().filter(|t| (0.0..=end).contains(t)).collect();
        self.tree.set_in("output", "field_times", place, times);
        if !has_interval {
            self.tree.set_in("output", "field_interval", place, -1.0);
        }
    }

    /// Converts the curve that limits the time step. The limit of a job is constant: the smallest
    /// one of the run.
    fn step_limit(&mut self, record: &CardRecord) {
        let (id, place) = (record.integer("lctm"), record.place("lctm"));
        if id == 0 {
            return;
        }
        let Some(curve) = self.curve(id, place) else { return };
        // The point after the end has a share in the values before it.
        let count = 1 + curve.points.iter().take_while(|p| p[0] < self.end_time).count();
        let within = curve.points.iter().take(count).map(|p| p[1]);
        let (limit, most) =
            within.fold((f64::INFINITY, 0.0f64), |(least, most), dt| (least.min(dt), most.max(dt)));
        if !(limit.is_finite() && limit > 0.0) {
            let why = "a limit of the time step that is not above 0: give a curve above 0";
            return self.unsupported_value(record, "lctm", why);
        }
        self.tree.set_in("time", "dt_max", place, limit);
        if limit < most {
            let asked = format!("lctm {id}: steps of {limit} to {most}");
            self.map(record.name(), asked, format!("at most {limit} in the whole run"));
        }
    }

    /// Returns the factor on the damping of all degrees of freedom. If all factors of a deck are
    /// blank, they are 1; otherwise a blank one is 0.
    fn damping_factor(&mut self, record: &CardRecord) -> f64 {
        let moves = ["stx", "sty", "stz"].map(|f| record.real(f));
        let turns = ["srx", "sry", "srz"].map(|f| record.real(f));
        if moves.iter().chain(&turns).all(|&f| f == 0.0) {
            return 1.0;
        }
        if moves.iter().any(|&f| f != moves[0]) {
            let field = ["stx", "sty", "stz"].into_iter().find(|f| record.real(f) != moves[0]);
            let why = "damping that depends on the direction: give stx, sty and stz the same value";
            self.unsupported_value(record, field.unwrap_or("stx"), why);
        } else if turns.iter().any(|&f| f != moves[0]) {
            self.map(
                record.name(),
                format!("factors {moves:?} for displacements, {turns:?} for rotations"),
                format!("{} for both", moves[0]),
            );
        }
        moves[0]
    }

    /// Returns the records of a keyword that a deck needs once. Warns if there are more; the last
    /// one counts.
    pub(super) fn take_one(&mut self, name: &str) -> Vec<CardRecord> {
        let records = self.take_records(name);
        if let [_, .., last] = &records[..] {
            let message = format!("*{name} occurs {} times: the last one counts", records.len());
            self.trouble.warning(last.head, message, "remove the others");
        }
        records
    }
}
