//! Converts `*AIRBAG_...` (LS-DYNA Keyword User's Manual, vol. I).

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use std::collections::HashSet;

/// A bag whose pressure is a function of time.
const LOAD_CURVE: &str = "AIRBAG_LOAD_CURVE";
const KEYWORDS: [&str; 5] = [
    LOAD_CURVE,
    "AIRBAG_SIMPLE_PRESSURE_VOLUME",
    "AIRBAG_ADIABATIC_GAS_MODEL",
    "AIRBAG_SIMPLE_AIRBAG_MODEL",
    "AIRBAG_WANG_NEFSKE",
];

/// A gas: heat capacities at constant volume and pressure [energy/(mass temperature)].
#[derive(Clone, Copy)]
struct DeckGas {
    cv: f64,
    cp: f64,
}

impl DeckConverter {
    /// Converts all airbags. Parts, sets and curves must have been read.
    pub(super) fn airbags(&mut self) {
        let mut names = HashSet::new();
        for record in self.take_in_order(&KEYWORDS) {
            if record.row.keyword.name == LOAD_CURVE {
                self.pressure_by_time(&record);
                continue;
            }
            let Some(bag) = self.bag(&record, &mut names) else { continue };
            let bag = match record.row.keyword.name {
                "AIRBAG_SIMPLE_PRESSURE_VOLUME" => Some(self.pressure_by_volume(&record, bag)),
                "AIRBAG_ADIABATIC_GAS_MODEL" => self.closed_gas(&record, bag),
                "AIRBAG_WANG_NEFSKE" => self.wang_nefske(&record, bag),
                _ => self.simple_gas(&record, bag),
            };
            if let Some(bag) = bag {
                self.add("airbag", bag);
            }
        }
    }

    /// Returns the table of a bag with its name, which none of `names` is, and its surface.
    fn bag(&mut self, record: &CardRecord, names: &mut HashSet<String>) -> Option<JobTable> {
        let (sid, place) = (record.integer("sid"), record.place("sid"));
        let number = match record.integer("id") {
            0 => sid,
            id => id,
        };
        let first = match record.word("heading").trim() {
            "" => format!("airbag-{number}"),
            heading => heading.to_string(),
        };
        let mut others = (2..).map(|count| format!("{first}-{count}"));
        let mut name = first.clone();
        while !names.insert(name.clone()) {
            name = others.next()?;
        }
        let bag = JobTable::new(record.head).with("name", record.head, name);
        if record.integer("sidtyp") != 0 {
            let parts = self.part_set(sid, place);
            return (!parts.is_empty()).then(|| bag.with("parts", place, parts));
        }
        let Some(segments) = self.segment_sets.get(&sid).cloned() else {
            let known: Vec<String> = self.segment_sets.keys().map(i64::to_string).collect();
            self.missing(place, "*SET_SEGMENT", sid, &known);
            return None;
        };
        let (nodes, inwards) = self.nodes_of_surface(&segments, place, &record.name())?;
        let set = format!("airbag-surface-{sid}");
        if !self.rows.has_set(&set) {
            self.rows.add_set(set.clone(), nodes, place);
        }
        let mut bag = bag.with("nodes", place, set);
        if inwards {
            bag.put("normals_inwards", place, true);
        }
        Some(bag)
    }

    /// Adds the pressure of a bag over time to its surface, along the normals of its shells or
    /// segments.
    fn pressure_by_time(&mut self, record: &CardRecord) {
        let (sid, at) = (record.integer("sid"), record.place("sid"));
        let (lcid, place) = (record.integer("lcid"), record.place("lcid"));
        if lcid == 0 {
            let why = "a gas without a curve: use *AIRBAG_ADIABATIC_GAS_MODEL";
            return self.unsupported_card(record, "lcid", why);
        }
        if record.real("stime") != 0.0 {
            let why = "a delay: shift the points of the curve";
            return self.unsupported_card(record, "stime", why);
        }
        let Some(curve) = self.time_curve(lcid, place) else { return };
        self.map(record.name(), "a pressure over time", "a pressure on the surface of the bag");
        // A positive pressure acts against the normals of the elements.
        let table = |pressure: f64| {
            JobTable::new(record.head).with("pressure", place, pressure).with(
                "curve",
                place,
                curve.clone(),
            )
        };
        if record.integer("sidtyp") != 0 {
            let parts = self.part_set(sid, at);
            if !parts.is_empty() {
                self.add("pressure", table(-1.0).with("parts", at, parts));
            }
            return;
        }
        let Some(segments) = self.segment_sets.get(&sid).cloned() else {
            let known: Vec<String> = self.segment_sets.keys().map(i64::to_string).collect();
            return self.missing(at, "*SET_SEGMENT", sid, &known);
        };
        for (sign, group, nodes) in self.groups_of_faces(&segments, true) {
            let set = self.rows.add_new_set(&format!("airbag-pressure-{sid}"), nodes, group);
            self.add("pressure", table(-sign).with("nodes", at, set));
        }
    }

    fn pressure_by_volume(&mut self, record: &CardRecord, mut bag: JobTable) -> JobTable {
        let (cn, lcid) = (record.real("cn"), record.integer("lcid"));
        let beta = super::curves::one(record.real("beta"));
        let place = record.place("cn");
        if lcid != 0 {
            self.points_of(&mut bag, "pressure_over_volume", record, "lcid", lcid);
        } else if cn < 0.0 {
            bag.put("inverse_pressure", place, beta);
            if let Some(curve) = self.time_curve(-cn as i64, place) {
                bag.put("curve", place, curve);
            }
        } else {
            bag.put("inverse_pressure", place, beta * cn);
        }
        bag
    }

    /// Completes a bag with a gas of constant mass. Its gas constant is 1 and, without a density,
    /// its temperature too. Both have no effect on the pressure.
    fn closed_gas(&mut self, record: &CardRecord, bag: JobTable) -> Option<JobTable> {
        let (gamma, p0, ro) = (record.real("gamma"), record.real("p0"), record.real("ro"));
        if gamma <= 1.0 {
            let help = "give the ratio of heat capacities, such as 1.4";
            self.trouble.error(record.place("gamma"), format!("gamma is {gamma}"), help);
            return None;
        }
        let cv = 1.0 / (gamma - 1.0);
        let temperature = if ro > 0.0 && p0 > 0.0 { p0 / ro } else { 1.0 };
        let bag = bag
            .with("cv", record.place("gamma"), cv)
            .with("cp", record.place("gamma"), gamma * cv)
            .with("pressure", record.place("p0"), p0)
            .with("ambient_pressure", record.place("pe"), record.real("pe"))
            .with("temperature", record.place("ro"), temperature);
        Some(bag)
    }

    /// Returns the heat capacities per mass, and reports values that are not possible.
    fn heat_capacities(&mut self, record: &CardRecord) -> Option<DeckGas> {
        let (cv, cp, place) = (record.real("cv"), record.real("cp"), record.place("cv"));
        let gas = if cv > 0.0 {
            DeckGas { cv, cp }
        } else {
            if record.real("b") != 0.0 {
                self.unsupported_value(record, "b", "a heat capacity that depends on temperature");
            }
            let (a, mw) = (record.real("a"), record.real("mw"));
            if mw <= 0.0 {
                let help = "give cv and cp, or with cv 0 the values a, mw and gasc per mole";
                self.trouble.error(place, "the gas has neither cv nor mw", help);
                return None;
            }
            DeckGas { cv: (a - record.real("gasc")) / mw, cp: a / mw }
        };
        if !(gas.cv > 0.0 && gas.cp > gas.cv) {
            let message =
                format!("the gas has the heat capacities cv {} and cp {}", gas.cv, gas.cp);
            self.trouble.error(place, message, "cp has to be larger than cv, and cv above 0");
            return None;
        }
        Some(gas)
    }

    /// Adds gas, ambient pressure and the state at the start. Without `initial` the temperature is
    /// that of the ambient density, or else that of the inflow.
    fn put_gas(
        &mut self,
        record: &CardRecord,
        (over, initial): (f64, f64),
        bag: JobTable,
    ) -> Option<JobTable> {
        let gas = self.heat_capacities(record)?;
        let (pe, ro, ambient) = (record.real("pe"), record.real("ro"), record.real("text"));
        let temperature = if initial > 0.0 {
            initial
        } else if record.real("cv") == 0.0 && ambient > 0.0 {
            ambient
        } else if pe > 0.0 && ro > 0.0 {
            pe / ((gas.cp - gas.cv) * ro)
        } else {
            record.real("t")
        };
        if temperature <= 0.0 {
            let message = "the gas has no temperature at the start";
            let help = "give the ambient pressure pe and density ro, or the temperature t";
            self.trouble.error(record.place("ro"), message, help);
            return None;
        }
        let mut bag = bag
            .with("cv", record.place("cv"), gas.cv)
            .with("cp", record.place("cp"), gas.cp)
            .with("ambient_pressure", record.place("pe"), pe)
            .with("temperature", record.place("ro"), temperature);
        if over != 0.0 {
            bag.put("pressure", record.place("pover"), pe + over);
        }
        Some(bag)
    }

    fn simple_gas(&mut self, record: &CardRecord, bag: JobTable) -> Option<JobTable> {
        let mut bag = self.put_gas(record, (0.0, 0.0), bag)?;
        let place = record.place("lcid");
        let mut inflow = Vec::new();
        if record.integer("lcid") != 0
            && let Some(curve) = self.time_curve(record.integer("lcid"), place)
        {
            let table = JobTable::new(place)
                .with("rate", place, 1.0)
                .with("curve", place, curve)
                .with("temperature", record.place("t"), record.real("t"));
            inflow.push(table);
        }
        let mut vents = Vec::new();
        let (mu, area) = (record.real("mu"), record.real("area"));
        if mu < 0.0 {
            self.unsupported_value(record, "mu", "a shape factor as a function of pressure");
        } else if mu > 0.0 && area != 0.0 {
            let place = record.place("area");
            let mut vent = JobTable::new(place).with("coefficient", record.place("mu"), mu);
            if area > 0.0 {
                vent.put("area", place, area);
            } else {
                self.points_of(&mut vent, "area_over_pressure", record, "area", -area as i64);
            }
            vents.push(vent);
        } else if area != 0.0 {
            self.no_vent(record, "area", "mu");
        }
        vents.extend(self.vent_by_rate(record, "lou"));
        put_tables(&mut bag, "inflow", inflow);
        put_tables(&mut bag, "vent", vents);
        Some(bag)
    }

    fn wang_nefske(&mut self, record: &CardRecord, bag: JobTable) -> Option<JobTable> {
        let gc = record.real("gc");
        if gc != 0.0 && gc != 1.0 {
            self.unsupported_value(record, "gc", "units that are not consistent: convert the deck");
        }
        let state = (record.real("pover"), record.real("iabt"));
        let mut bag = self.put_gas(record, state, bag)?;
        let place = record.place("lcmt");
        let mut inflow = Vec::new();
        if let Some(curve) = self.time_curve(record.integer("lcmt"), place) {
            let mut table =
                JobTable::new(place).with("rate", place, 1.0).with("curve", place, curve);
            match record.integer("lct") {
                0 => table.put("temperature", record.place("t"), record.real("t")),
                lct => {
                    let place = record.place("lct");
                    table.put("temperature", place, 1.0);
                    if let Some(curve) = self.time_curve(lct, place) {
                        table.put("temperature_curve", place, curve);
                    }
                }
            }
            inflow.push(table);
        }
        let exit = self.orifice(record, ["c23", "lcc23", "a23", "lca23"], record.real("ppop"));
        let leak = self.orifice(record, ["cp23", "lccp23", "ap23", "lcap23"], 0.0);
        let vents = exit.into_iter().chain(leak).chain(self.vent_by_rate(record, "lcefr"));
        let vents = vents.collect();
        put_tables(&mut bag, "inflow", inflow);
        put_tables(&mut bag, "vent", vents);
        Some(bag)
    }

    /// Returns a vent from the fields of its coefficient, the curve of that, its area, and the
    /// curve of that.
    fn orifice(
        &mut self,
        record: &CardRecord,
        fields: [&str; 4],
        opening: f64,
    ) -> Option<JobTable> {
        let [coefficient, factor, area, over_pressure] = fields;
        let (c, lcc) = (record.real(coefficient), record.integer(factor));
        let (a, lca) = (record.real(area), record.integer(over_pressure));
        if c < 0.0 || a < 0.0 {
            let field = if c < 0.0 { coefficient } else { area };
            self.unsupported_value(record, field, "a part or curve by a negative value");
            return None;
        }
        if a == 0.0 && lca == 0 {
            return None;
        }
        if c == 0.0 && lcc == 0 {
            self.no_vent(record, if a != 0.0 { area } else { over_pressure }, coefficient);
            return None;
        }
        let mut vent = JobTable::new(record.place(area));
        if c > 0.0 {
            vent.put("coefficient", record.place(coefficient), c);
        } else {
            let curve = self.time_curve(lcc, record.place(factor))?;
            vent.put("curve", record.place(factor), curve);
        }
        if a > 0.0 {
            vent.put("area", record.place(area), a);
        } else {
            self.points_of(&mut vent, "area_over_pressure", record, over_pressure, lca);
        }
        if opening > 0.0 {
            vent.put("opening_pressure", record.place("ppop"), opening);
        }
        Some(vent)
    }

    /// Returns a vent with a curve of its mass rate over gauge pressure, if there is one.
    fn vent_by_rate(&mut self, record: &CardRecord, field: &str) -> Option<JobTable> {
        let lcid = record.integer(field);
        if lcid == 0 {
            return None;
        }
        let mut vent = JobTable::new(record.place(field));
        self.points_of(&mut vent, "rate_over_pressure", record, field, lcid);
        Some(vent)
    }

    /// Warns of an area without a coefficient.
    fn no_vent(&mut self, record: &CardRecord, area: &str, coefficient: &str) {
        let message = format!("{}: `{area}` has no effect: no gas leaves there", record.name());
        let help = format!("give a `{coefficient}` above 0, or remove the area");
        self.trouble.warning(record.place(area), message, help);
    }

    /// Puts the points of a curve over pressure or volume into a table.
    fn points_of(
        &mut self,
        table: &mut JobTable,
        key: &str,
        record: &CardRecord,
        field: &str,
        id: i64,
    ) {
        let place = record.place(field);
        if let Some(curve) = self.curve(id, place) {
            let rows: Vec<Vec<f64>> = curve.points.iter().map(|p| p.to_vec()).collect();
            table.put(key, curve.place, rows);
        }
    }
}

/// Puts a list of tables into a table, unless it is empty.
fn put_tables(table: &mut JobTable, key: &str, entries: Vec<JobTable>) {
    if let Some(place) = entries.first().map(JobTable::place) {
        table.put(key, place, entries);
    }
}
