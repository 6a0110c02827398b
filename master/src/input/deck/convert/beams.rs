//! Converts `*ELEMENT_BEAM`, and the sections of its parts.

use super::DeckConverter;
use super::materials::DeckMaterial;
use super::sections::DeckSection;
use super::sets::id;
use super::solid_welds::WeldLimits;
use super::space::{cross, unit};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{MeshElement, Shape, corner_nodes};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Code of the standard section W, an I whose flanges are along the second axis.
const WIDE_FLANGE: i64 = 1;
/// Code of a third node that is not given.
const NONE: NodeId = NodeId(0);

impl DeckConverter {
    /// Converts elements. [`DeckConverter::orient_beams`] adds third nodes that are not given.
    pub(super) fn beams(&mut self) {
        let mut shown = Vec::new();
        for record in self.take_records("ELEMENT_BEAM") {
            let number = record.integer("eid");
            for field in ["rt1", "rr1", "rt2", "rr2"] {
                if record.integer(field) != 0 {
                    self.unsupported_value(&record, field, "releases at the ends of a beam");
                }
            }
            let ids = ["eid", "n1", "n2"].map(|field| id(record.integer(field)));
            let part = u32::try_from(record.integer("pid")).ok();
            let ([Some(own), Some(n1), Some(n2)], Some(part)) = (ids, part) else {
                let message = format!("{}: beam {number} has an invalid id", record.name());
                let help = "give whole numbers above 0; the largest part id is 4294967295";
                self.trouble.error(record.place("eid"), message, help);
                continue;
            };
            let place = record.line("eid").map_or(record.head, |line| line.place);
            let third =
                id(record.integer("n3")).filter(|n3| *n3 != n1 && *n3 != n2).unwrap_or(NONE);
            if let (Some(line), Some(from)) = (record.line("vx"), self.rows.at(n1)) {
                let along = ["vx", "vy", "vz"].map(|c| line.real(c));
                shown.push((
                    self.rows.beams.len(),
                    ([0, 1, 2].map(|c| from[c] + along[c]), line.place),
                ));
            }
            self.rows.beam(ElemId(own.0), part, [n1, n2, third], place);
        }
        self.show(&shown);
    }

    /// Adds third nodes at given points to beams.
    pub(super) fn show(&mut self, shown: &[(usize, ([f64; 3], crate::input::job::tree::Place))]) {
        let points: Vec<_> = shown.iter().map(|s| s.1).collect();
        let nodes = self.rows.add_nodes(&points);
        for ((index, _), third) in shown.iter().zip(nodes) {
            let beam = &mut self.rows.beams[*index];
            beam.nodes = corner_nodes(&[beam.nodes[0], beam.nodes[1], third]);
        }
    }

    /// Adds a third node to beams without one, if their section does not depend on it. Otherwise
    /// reports an error.
    pub(super) fn orient_beams(&mut self) {
        let (mut shown, mut wrong) = (Vec::new(), BTreeSet::new());
        for index in 0..self.rows.beams.len() {
            if self.discrete_beam(index) {
                continue;
            }
            let beam = self.rows.beams[index];
            if self.truss_parts.contains(&beam.part) {
                let ends = [beam.nodes[0], beam.nodes[1]];
                let truss = MeshElement::new(beam.id, beam.part, Shape::Truss2, &ends);
                self.rows.beams[index] = truss;
                continue;
            }
            if !self.parts.contains_key(&i64::from(beam.part)) {
                continue;
            }
            let place = self.rows.beam_place(index);
            if beam.nodes[2] != NONE {
                if self.turned_parts.contains(&beam.part)
                    && let Some(point) = self.third_axis(&beam)
                {
                    shown.push((index, (point, place)));
                }
                continue;
            }
            if !self.round_parts.contains(&beam.part) {
                let message =
                    format!("beam {} has no third node, and its section is not round", beam.id);
                let help =
                    "give n3, a node in the direction of the second axis; it may not be n1 or n2";
                self.trouble.error(place, message, help);
                wrong.insert(beam.id);
            } else if let [Some(from), Some(to)] =
                [beam.nodes[0], beam.nodes[1]].map(|n| self.rows.at(n))
                && let Some(along) = unit([0, 1, 2].map(|c| to[c] - from[c]))
            {
                // Perpendicular to the beam, and to the coordinate axis that is most nearly
                // perpendicular to it.
                let least =
                    (0..3).min_by(|&a, &b| along[a].abs().total_cmp(&along[b].abs())).unwrap_or(0);
                let mut axis = [0.0; 3];
                axis[least] = 1.0;
                let across = cross(along, axis);
                let length = (0..3).map(|c| (to[c] - from[c]).powi(2)).sum::<f64>().sqrt();
                shown.push((index, ([0, 1, 2].map(|c| from[c] + length * across[c]), place)));
            }
        }
        self.show(&shown);
        if !wrong.is_empty() {
            self.rows.remove(|e| e.shape == Shape::Beam2 && wrong.contains(&e.id));
        }
    }

    /// Returns a point in the direction of the third axis of a beam, from its first node; `None` if
    /// its third node does not show the second one, which is reported elsewhere.
    fn third_axis(&mut self, beam: &MeshElement) -> Option<[f64; 3]> {
        let [from, to, shows] = [0, 1, 2].map(|k| self.rows.at(beam.nodes[k]));
        let (from, to, shows) = (from?, to?, shows?);
        let along: [f64; 3] = std::array::from_fn(|c| to[c] - from[c]);
        let second: [f64; 3] = std::array::from_fn(|c| shows[c] - from[c]);
        let third = unit(cross(along, second))?;
        let length = along.iter().map(|l| l * l).sum::<f64>().sqrt();
        Some(std::array::from_fn(|c| from[c] + length * third[c]))
    }

    /// Converts a part of beams.
    pub(super) fn beam_part(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        material: &DeckMaterial,
        table: &mut JobTable,
    ) {
        let card = &section.record;
        let (pid, elform) = (record.integer("pid"), card.integer("elform"));
        if card.real("nsm") != 0.0 {
            self.unsupported_value(card, "nsm", "mass in addition to that of the material");
        }
        if card.real("scoor") != 0.0 {
            let message = format!("{}: `scoor` = {} is ignored", card.name(), card.real("scoor"));
            let help = "the axes of a beam are those of its middle";
            self.trouble.warning(card.place("scoor"), message, help);
        }
        if elform == 3 {
            return self.truss_part(record, card, table);
        }
        let mut beam = JobTable::new(card.head);
        let used = match elform {
            0 | 1 | 4 | 5 | 9 => self.integrated(card, &mut beam),
            2 | 13 => self.resultant(card, material, &mut beam),
            _ => {
                let why = "1, 4, 5 and 9 (integrated sections), 2 and 13 (resultants) and 3 \
                    (trusses) are supported";
                self.unsupported_card(card, "elform", why);
                None
            }
        };
        let Some((used, round)) = used else {
            let help = "give it a section that is supported".to_string();
            let why = "its section is not supported";
            return self.leave_out_part(pid, record.place("secid"), why, help);
        };
        if let Ok(part) = u32::try_from(pid) {
            if round {
                self.round_parts.insert(part);
            }
            if card.real("qr") < 0.0 && matches!(elform, 0 | 1 | 4 | 5 | 9) {
                self.turned_parts.insert(part);
            }
        }
        let shear = if beam.has("shear_areas") {
            "elastic shear deformation"
        } else {
            "no transverse shear"
        };
        let mut used = format!("corotational beam, section {used}; {shear}");
        if let Some((WeldLimits::Forces(limits), place)) = material.weld {
            let mut weld = JobTable::new(place);
            for (key, limit) in ["normal", "shear", "bending", "torsion"].into_iter().zip(limits) {
                weld.put(key, place, limit);
            }
            beam.put("weld", place, weld);
            used += "; breaks as a weld";
        }
        if let Some(preload) = self.preloads.remove(&pid) {
            beam.put("preload", preload.place, preload.points);
            if preload.bending {
                beam.put("preload_bending", preload.place, true);
            }
            used += "; starts with a preload";
        }
        let name = match elform {
            2 => "Belytschko-Schwer",
            4 | 5 => "Belytschko-Schwer, integrated",
            9 => "spot weld",
            13 => "linear Timoshenko",
            _ => "Hughes-Liu",
        };
        self.map(format!("part {pid}"), format!("beams, elform {elform} ({name})"), used);
        table.put("beam", card.head, beam);
    }

    /// Converts a part of trusses: a force along the line between two nodes.
    fn truss_part(&mut self, record: &CardRecord, card: &CardRecord, table: &mut JobTable) {
        let pid = record.integer("pid");
        if let Ok(part) = u32::try_from(pid) {
            self.truss_parts.insert(part);
        }
        let truss = JobTable::new(card.head).with("area", card.place("a"), card.real("a"));
        table.put("truss", card.head, truss);
        self.map(format!("part {pid}"), "beams, elform 3 (truss)", "trusses");
    }

    /// Converts a section with integrated fibres. Returns its name, and true if it is round.
    fn integrated(
        &mut self,
        card: &CardRecord,
        beam: &mut JobTable,
    ) -> Option<(&'static str, bool)> {
        if card.real("qr") < 0.0 {
            return self.section_of_rule(card, beam);
        }
        for (first, last) in [("ts1", "ts2"), ("tt1", "tt2")] {
            if card.real(last) != 0.0 && card.real(last) != card.real(first) {
                self.unsupported_value(card, last, "sections that change along a beam");
            }
        }
        for field in ["nsloc", "ntloc"] {
            if card.real(field) != 0.0 {
                self.unsupported_value(card, field, "an offset of the reference line");
            }
        }
        let (along_s, along_t) = (card.real("ts1"), card.real("tt1"));
        let tube = match (card.integer("elform"), card.real("cst")) {
            (5 | 9, 0.0) => true,
            (_, cst) if cst == 0.0 || cst == 1.0 => cst == 1.0,
            _ => {
                self.unsupported_card(card, "cst", "use 0 (rectangle) or 1 (tube)");
                return None;
            }
        };
        if tube {
            beam.put("section", card.place("cst"), "tube");
            beam.put("radius", card.place("ts1"), 0.5 * along_s);
            if along_t > 0.0 {
                beam.put("wall", card.place("tt1"), 0.5 * (along_s - along_t));
            }
            shear(card, 0.25 * PI * (along_s.powi(2) - along_t.powi(2)), beam);
            return Some(("tube", true));
        }
        beam.put("section", card.place("cst"), "rectangle");
        beam.put("height", card.place("ts1"), along_s);
        beam.put("width", card.place("tt1"), along_t);
        shear(card, along_s * along_t, beam);
        Some(("rectangle", false))
    }

    /// Converts the section of an integration rule. Its web is along the third axis of the beams,
    /// which [`DeckConverter::orient_beams`] turns, because that of a job is along the second.
    fn section_of_rule(
        &mut self,
        card: &CardRecord,
        beam: &mut JobTable,
    ) -> Option<(&'static str, bool)> {
        const RULE: &str = "INTEGRATION_BEAM";
        // Sections read whole numbers as numbers.
        let number = -card.real("qr") as i64;
        let rules = self.records.get(RULE).map_or(&[][..], Vec::as_slice);
        let Some(rule) = rules.iter().find(|rule| rule.integer("irid") == number).cloned() else {
            let known: Vec<String> =
                rules.iter().map(|rule| rule.integer("irid").to_string()).collect();
            self.missing(card.place("qr"), "*INTEGRATION_BEAM", number, &known);
            return None;
        };
        if rules.iter().filter(|other| other.integer("irid") == number).count() > 1 {
            let message = format!("there are two *INTEGRATION_BEAM with the id {number}");
            self.trouble.error(rule.place("irid"), message, "give each a different id");
        }
        if rule.integer("icst") != WIDE_FLANGE {
            let why = "1 (W, an I with equal flanges) is supported; give elform 2 with the area \
                       and the moments of the section";
            self.unsupported_card(&rule, "icst", why);
            return None;
        }
        if rule.integer("nip") != 0 {
            self.unsupported_value(&rule, "nip", "points of an own rule");
        }
        beam.put("section", rule.place("icst"), "i");
        for (key, field) in [("height", "d3"), ("width", "d1"), ("flange", "d2"), ("web", "d4")] {
            beam.put(key, rule.place(field), rule.real(field));
        }
        let [width, flange, depth, web] = ["d1", "d2", "d3", "d4"].map(|field| rule.real(field));
        shear(card, 2.0 * width * flange + (depth - 2.0 * flange) * web, beam);
        Some(("i, with its web along the third axis", false))
    }

    /// Converts a section with given area and moments.
    fn resultant(
        &mut self,
        card: &CardRecord,
        material: &DeckMaterial,
        beam: &mut JobTable,
    ) -> Option<(&'static str, bool)> {
        beam.put("section", card.head, "general");
        beam.put("area", card.place("a"), card.real("a"));
        if !material.elastic {
            let why = "resultants are elastic only; use *MAT_ELASTIC, or elform 1 with a section";
            self.unsupported_value(card, "elform", why);
        }
        if card.real("ist") != 0.0 {
            self.unsupported_value(card, "ist", "axes other than the principal axes");
        }
        let (about_s, about_t) = (card.real("iss"), card.real("itt"));
        let torsion = if card.real("j") > 0.0 { card.real("j") } else { about_s + about_t };
        beam.put("second_moments", card.place("iss"), [about_s, about_t]);
        beam.put("torsion", card.place("j"), torsion);
        let bears = card.real("sa");
        if bears > 0.0 {
            beam.put("shear_areas", card.place("sa"), [bears; 2]);
        } else if card.integer("elform") == 13 {
            self.unsupported_value(card, "sa", "Timoshenko beams need their shear area");
        }
        Some(("general", about_s == about_t))
    }
}

/// Sets the shear areas of a section with shear deformation.
fn shear(card: &CardRecord, area: f64, beam: &mut JobTable) {
    if matches!(card.integer("elform"), 0 | 1 | 9) {
        beam.put("shear_areas", card.place("shrf"), [card.real("shrf") * area; 2]);
    }
}
