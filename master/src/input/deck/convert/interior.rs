//! Converts `*CONTACT_INTERIOR`: contact inside of the solids of parts, with the attributes of
//! their set.

use super::DeckConverter;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::{Entry, Node, NodeContent, Place};

const KEY: &str = "interior_contact";
const SETS: [&str; 3] = ["SET_PART_LIST", "SET_PART_LIST_GENERATE", "SET_PART_ADD"];

/// Fraction of the volume and factor on the modulus, where the set gives none.
const FRACTION: f64 = 0.1;
const FACTOR: f64 = 1.0;

impl DeckConverter {
    pub(super) fn interior_contacts(&mut self) {
        for record in self.take_records("CONTACT_INTERIOR") {
            for line in record.lines("psid") {
                let (psid, place) = (line.integer("psid"), line.place("psid"));
                let parts = self.part_set(psid, place);
                let set = self.set_of_parts(psid);
                let value = self.interior_of(psid, set.as_ref());
                for part in parts {
                    self.put_interior(part, place, value);
                }
            }
        }
    }

    /// Returns the card of a set of parts.
    fn set_of_parts(&self, psid: i64) -> Option<CardRecord> {
        let mut sets = self.read.iter().filter(|record| SETS.contains(&record.row.keyword.name));
        sets.find(|record| record.integer("sid") == psid).cloned()
    }

    /// Returns the fraction and the factor that the attributes of a set give.
    fn interior_of(&mut self, psid: i64, set: Option<&CardRecord>) -> [f64; 2] {
        let of = |field: &str| set.map_or(0.0, |set| set.real(field));
        let [factor, fraction, modulus, kind] = ["da1", "da2", "da3", "da4"].map(of);
        let or = |given: f64, default: f64| if given > 0.0 { given } else { default };
        let (fraction, factor) = (or(fraction, FRACTION), or(factor, FACTOR));
        let mut asked = "contact inside of solids below a share of their thickness".to_string();
        if modulus > 0.0 {
            asked += &format!(", with the modulus {modulus}");
        }
        if kind == 2.0 {
            asked += ", also in shear (type 2)";
        }
        let used = format!(
            "interior_contact [{fraction}, {factor}]: a pressure below that share of the volume, \
             with the modulus of the material in confined compression times {factor}"
        );
        self.map(format!("set of parts {psid}"), asked, used);
        [fraction, factor]
    }

    /// Sets the key of a deformable part of solids; the contact acts in no other.
    fn put_interior(&mut self, part: i64, place: Place, value: [f64; 2]) {
        let is_rigid = self.parts.get(&part).is_some_and(|part| part.rigid.is_some());
        let thick: Vec<usize> = self.rows.thick.clone();
        let has_solids = self
            .rows
            .solids
            .iter()
            .enumerate()
            .any(|(at, solid)| i64::from(solid.part) == part && !thick.contains(&at));
        let keys = self.tree.part(part).filter(|_| has_solids && !is_rigid);
        let Some(keys) = keys.filter(|keys| {
            let element = keys.get("element").map(|entry| &entry.node.kind);
            !matches!(element, Some(NodeContent::String(word)) if word == "cohesive")
        }) else {
            let why = "not used: only deformable solids have it";
            self.map(format!("part {part}"), "contact inside of solids", why);
            return;
        };
        if keys.contains_key(KEY) {
            let why = "not used: another set of *CONTACT_INTERIOR has the part already";
            self.map(format!("part {part}"), format!("contact inside of solids, {value:?}"), why);
            return;
        }
        let item = |x: f64| Node { kind: NodeContent::Float(x), place };
        let node = Node { kind: NodeContent::Array(value.map(item).into()), place };
        keys.insert(KEY.into(), Entry { key: place, node });
    }
}
