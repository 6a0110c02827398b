//! Converts `*SENSOR_...`: switches of time become birth and death of walls and contacts. For all
//! others the report says what they would have switched.

use super::contact::KEYWORDS as CONTACTS;
use super::walls::KEYWORDS as WALLS;
use super::{DeckConverter, Unsupported};
use crate::input::deck::record::CardRecord;
use std::collections::BTreeMap;

/// Keywords of sensors.
const SENSORS: [&str; 6] = [
    "SENSOR_DEFINE_NODE",
    "SENSOR_DEFINE_NODE_SET",
    "SENSOR_DEFINE_ELEMENT",
    "SENSOR_DEFINE_FORCE",
    "SENSOR_DEFINE_MISC",
    "SENSOR_DEFINE_CALC-MATH",
];

/// Fields with the numbers of switches.
const SWITCHES: [&str; 7] = ["swit1", "swit2", "swit3", "swit4", "swit5", "swit6", "swit7"];

/// Types of entities, and what they are.
const ENTITIES: [(&str, &str); 15] = [
    ("AIRBAG", "airbag"),
    ("BAGVENTPOP", "vent of airbag"),
    ("CONTACT", "contact"),
    ("CNRB", "rigid body of nodes"),
    ("DEF2RIG", "switch to rigid"),
    ("ELESET", "erosion of element set"),
    ("FUNCTION", "function"),
    ("JOINT", "joint"),
    ("JOINTSTIF", "stiffness of joint"),
    ("PRESC-MOT", "prescribed motion"),
    ("PRESC-ORI", "prescribed orientation"),
    ("PRESSURE", "pressure"),
    ("RWALL", "rigid wall"),
    ("SPC", "fixed nodes"),
    ("SPOTWELD", "spot weld"),
];

/// A switch: the time at which it acts, if it depends on time alone, and its description.
struct DeckSwitch {
    time: Option<f64>,
    text: String,
}

impl DeckConverter {
    /// Puts the times of switches into the cards of walls and contacts, before these are converted.
    pub(super) fn sensors(&mut self) {
        let switches = self.switches_of_sensors();
        for record in self.take_records("SENSOR_CONTROL") {
            if !self.timed(&record, &switches) {
                self.without_control(&record, &switches);
            }
        }
    }

    /// Returns the switches by number.
    fn switches_of_sensors(&mut self) -> BTreeMap<i64, DeckSwitch> {
        let mut sensors: BTreeMap<i64, String> = BTreeMap::new();
        for keyword in SENSORS {
            for record in self.take_records(keyword) {
                sensors.insert(record.integer("sensid"), record.name());
            }
        }
        let mut switches = BTreeMap::new();
        for record in self.take_records("SENSOR_SWITCH") {
            let given = |field: &str, other: &str| match record.word(field) {
                "" => other.to_string(),
                word => word.to_ascii_uppercase(),
            };
            let (of, logic) = (given("type", "SENSOR"), given("logic", "LT"));
            let (sensid, value) = (record.integer("sensid"), record.real("value"));
            let later = record.real("timwin") + record.real("tdelay");
            let sign = if logic == "GT" { ">" } else { "<" };
            let measured = match (of.as_str(), sensors.get(&sensid)) {
                ("TIME", _) => "time".to_string(),
                (_, Some(name)) => format!("{name} {sensid}"),
                (_, None) => format!("sensor {sensid}, which is not in the deck,"),
            };
            let is_timed = of == "TIME" && logic == "GT";
            let switch = DeckSwitch {
                time: is_timed.then_some((value + later).max(0.0)),
                text: format!("{measured} {sign} {value}"),
            };
            switches.insert(record.integer("switid"), switch);
        }
        for record in self.take_records("SENSOR_SWITCH_CALC-LOGIC") {
            let of = SWITCHES.map(|field| record.integer(field)).into_iter().filter(|&id| id != 0);
            let of: Vec<String> = of.map(|id| id.to_string()).collect();
            let text = format!("a combination of the switches {}", of.join(", "));
            switches.insert(record.integer("switid"), DeckSwitch { time: None, text });
        }
        switches
    }

    /// Converts a control of a wall or a contact that is on in one interval of time. Returns false
    /// if it is another one.
    fn timed(&mut self, record: &CardRecord, switches: &BTreeMap<i64, DeckSwitch>) -> bool {
        let (keywords, id, fields): (Vec<&str>, &str, [&str; 2]) =
            match record.word("type").to_ascii_uppercase().as_str() {
                "RWALL" => (WALLS.to_vec(), "wid", ["birth", "death"]),
                "CONTACT" => (CONTACTS.map(|c| c.0).to_vec(), "cid", ["bt", "dt"]),
                _ => return false,
            };
        let own = switches_of(record);
        let times: Option<Vec<f64>> = own.iter().map(|id| switches.get(id)?.time).collect();
        let Some(times) = times else { return false };
        let is_on = !record.word("initstt").eq_ignore_ascii_case("OFF");
        let (birth, death) = match (is_on, &times[..]) {
            (true, []) => (None, None),
            (true, &[off]) if off > 0.0 => (None, Some(off)),
            (false, &[on]) => (Some(on), None),
            (false, &[on, off]) if on < off => (Some(on), Some(off)),
            _ => return false,
        };
        if record.integer("nrep") != 0 {
            return false;
        }
        let typeid = record.integer("typeid");
        let all =
            keywords.iter().filter_map(|keyword| Some((*keyword, self.records.get(keyword)?)));
        let found: Vec<(&str, usize)> = all
            .flat_map(|(keyword, records)| {
                let fits = move |(_, r): &(usize, &CardRecord)| r.integer(id) == typeid;
                records.iter().enumerate().filter(fits).map(move |(at, _)| (keyword, at))
            })
            .collect();
        let &[(keyword, at)] = &found[..] else { return false };
        let Some(entity) = self.records.get_mut(keyword).and_then(|all| all.get_mut(at)) else {
            return false;
        };
        // A card with times of its own has two sources for them.
        let has_own = entity.real(fields[0]) > 0.0
            || entity.real(fields[1]) > 0.0 && entity.real(fields[1]) < self.end_time;
        if has_own {
            return false;
        }
        for (field, time) in fields.into_iter().zip([birth, death]) {
            time.into_iter().for_each(|time| entity.put(field, time));
        }
        let name = entity.name();
        let part = match (birth, death) {
            (None, None) => "on for the whole run".to_string(),
            (None, Some(off)) => format!("on until {off}"),
            (Some(on), None) => format!("on from {on}"),
            (Some(on), Some(off)) => format!("on from {on} until {off}"),
        };
        let asked = format!("{} {}", record.name(), record.integer("cntlid"));
        self.map(format!("{name} {typeid}"), asked, part);
        true
    }

    /// Reports a control that is not converted.
    fn without_control(&mut self, record: &CardRecord, switches: &BTreeMap<i64, DeckSwitch>) {
        let (of, typeid) = (record.word("type").to_ascii_uppercase(), record.integer("typeid"));
        let entity = ENTITIES.iter().find(|e| e.0 == of).map_or(of.as_str(), |e| e.1);
        let text = |id: &i64| match switches.get(id) {
            Some(switch) => format!("switch {id} ({})", switch.text),
            None => format!("switch {id}, which is not in the deck"),
        };
        let own: Vec<String> = switches_of(record).iter().map(text).collect();
        let by = if own.is_empty() { "no switch".into() } else { own.join(", then ") };
        let first = if record.word("initstt").eq_ignore_ascii_case("OFF") { "off" } else { "on" };
        let name = format!("{} {}", record.name(), record.integer("cntlid"));
        let message = format!(
            "{name}: {entity} {typeid}, {first} at the start, would be switched by {by}, which is \
             not supported: give times on its own card, if it has them"
        );
        let lost = format!("{entity} {typeid} acts as its own card says, in the whole run");
        let place = record.place("type");
        self.unsupported.push(Unsupported { place, message, what: name, lost });
    }
}

/// Returns the numbers of the switches of a control, in order.
fn switches_of(record: &CardRecord) -> Vec<i64> {
    SWITCHES.into_iter().map(|field| record.integer(field)).filter(|&id| id != 0).collect()
}
