//! Converts parts of discrete beams: `*SECTION_BEAM` with elform 6 and the laws for it.

use super::DeckConverter;
use super::parts::DeckPart;
use super::sections::{DeckSection, SectionKind};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::{NodeContent, Place};
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::BTreeSet;

/// Keywords of the laws.
const LAWS: [&str; 3] = [LINEAR, "MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM", GENERAL];
const LINEAR: &str = "MAT_LINEAR_ELASTIC_DISCRETE_BEAM";
const GENERAL: &str = "MAT_GENERAL_SPRING_DISCRETE_BEAM";

/// Axes of the job, with the fields of stiffness and damping and those of their curves.
const AXES: [(&str, [&str; 2], [&str; 2]); 6] = [
    ("r", ["tkr", "tdr"], ["lcidtr", "lcidtdr"]),
    ("s", ["tks", "tds"], ["lcidts", "lcidtds"]),
    ("t", ["tkt", "tdt"], ["lcidtt", "lcidtdt"]),
    ("rr", ["rkr", "rdr"], ["lcidrr", "lcidrdr"]),
    ("rs", ["rks", "rds"], ["lcidrs", "lcidrds"]),
    ("rt", ["rkt", "rdt"], ["lcidrt", "lcidrdt"]),
];

/// Returns true for a section of discrete beams.
pub(super) fn is_discrete(section: &DeckSection) -> bool {
    section.kind == SectionKind::Beam && section.record.integer("elform") == 6
}

impl DeckConverter {
    /// Reads the laws.
    pub(super) fn discrete_beam_laws(&mut self) {
        for record in LAWS.iter().flat_map(|law| self.take_records(law)).collect::<Vec<_>>() {
            let (mid, place) = (record.integer("mid"), record.place("mid"));
            if self.discrete_beam_laws.insert(mid, record).is_some() {
                let message = format!("there are two materials with the id {mid}");
                self.trouble.error(place, message, "give each a different id");
            }
        }
    }

    /// Converts a part of discrete beams.
    pub(super) fn discrete_beam_part(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        name: &str,
    ) {
        let (pid, mid, card) = (record.integer("pid"), record.integer("mid"), &section.record);
        let place = record.place("pid");
        self.parts.insert(pid, DeckPart { rigid: None, material: None, inertia: None, place });
        let has_axes = card.integer("cid") != 0;
        if let Ok(part) = u32::try_from(pid) {
            self.discrete_beam_parts.insert(part, has_axes);
        }
        let Some(law) = self.discrete_beam_laws.get(&mid).cloned() else {
            let known: Vec<String> = self.discrete_beam_laws.keys().map(i64::to_string).collect();
            let what = "*MAT_..._DISCRETE_BEAM of the kinds 66, 67 and 196";
            return self.missing(record.place("mid"), what, mid, &known);
        };
        let (ro, vol) = (law.real("ro"), card.real("vol"));
        let mut table = JobTable::new(card.head)
            .with("mass", card.place("vol"), ro * vol)
            .with("inertia", card.place("iner"), card.real("iner"))
            .with("turns_with", card.place("scoor"), self.turning_node(card));
        if has_axes {
            match self.axes.get(&card.integer("cid")) {
                Some([x, y, _]) => {
                    table.put("axes", card.place("cid"), vec![x.to_vec(), y.to_vec()])
                }
                None => {
                    let known: Vec<String> = self.axes.keys().map(i64::to_string).collect();
                    let (at, id) = (card.place("cid"), card.integer("cid"));
                    self.missing(at, "*DEFINE_COORDINATE_...", id, &known);
                }
            }
        }
        let springs: Vec<JobTable> = match law.row.keyword.name {
            GENERAL => self.springs_by_cards(&law),
            _ => AXES.iter().filter_map(|axis| self.axis_spring(&law, axis)).collect(),
        };
        let used = format!("discrete beams with springs on {} axes", springs.len());
        self.map(format!("part {pid}"), format!("beams, elform 6, {}", law.name()), used);
        table.put("spring", law.head, springs);
        let part = JobTable::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("discrete_beam", card.head, table);
        self.add("part", part);
    }

    /// Returns the nodes that rotate the axes.
    fn turning_node(&mut self, card: &CardRecord) -> &'static str {
        match card.real("scoor") {
            0.0 => "both",
            -1.0 | -3.0 => "first",
            1.0 | 3.0 => "second",
            _ => {
                let why = "axes along the line between the nodes; use -3, -1, 0, 1 or 3";
                self.unsupported_value(card, "scoor", why);
                "both"
            }
        }
    }

    /// Returns the spring on an axis, if the law has one.
    fn axis_spring(
        &mut self,
        law: &CardRecord,
        &(axis, fields, curves): &(&str, [&str; 2], [&str; 2]),
    ) -> Option<JobTable> {
        let mut own = JobTable::new(law.head);
        let mut any = false;
        let mut put = |key: &str, place: Place, value: NodeContent| {
            any = true;
            own.put(key, place, value);
        };
        if law.row.keyword.name == LINEAR {
            for (field, key) in fields.into_iter().zip(["stiffness", "damping"]) {
                if law.real(field) != 0.0 {
                    put(key, law.place(field), law.real(field).into());
                }
            }
        } else {
            for (field, key) in curves.into_iter().zip(["force_elongation", "force_rate"]) {
                let id = law.integer(field);
                if id == 0 {
                    continue;
                }
                if let Some((place, points)) = self.force_curve(law, (id, law.place(field))) {
                    put(key, place, points);
                }
            }
        }
        let at = law.head;
        any.then(|| own.with("axis", at, axis))
    }

    /// Returns the points of a curve of forces, with its place. One that begins at the origin acts
    /// alike in both directions.
    fn force_curve(
        &mut self,
        law: &CardRecord,
        (id, place): (i64, Place),
    ) -> Option<(Place, NodeContent)> {
        let curve = self.curve(id, place)?;
        let mut points: Vec<Vec<f64>> = Vec::new();
        if curve.points.first() == Some(&[0.0, 0.0]) {
            let mirrored = curve.points[1..].iter().rev().map(|p| vec![-p[0], -p[1]]);
            points.extend(mirrored);
            let asked = format!("curve {id} begins at the origin");
            self.map(law.name(), asked, "the same in both directions");
        }
        points.extend(curve.points.iter().map(|p| p.to_vec()));
        Some((curve.place, points.into()))
    }

    /// Returns the springs of a law with a card for each axis.
    fn springs_by_cards(&mut self, law: &CardRecord) -> Vec<JobTable> {
        let [cards, curves] =
            ["dof", "flcid"].map(|field| law.lines(field).cloned().collect::<Vec<_>>());
        let mut springs: Vec<JobTable> = Vec::new();
        let mut seen = BTreeSet::new();
        for (k, card) in cards.iter().enumerate() {
            let (dof, place) = (card.integer("dof"), card.place("dof"));
            // Cards at the end may be left out.
            if dof == 0 {
                continue;
            }
            let axis = usize::try_from(dof - 1).ok().and_then(|axis| AXES.get(axis));
            let Some(&(axis, ..)) = axis.filter(|_| seen.insert(dof)) else {
                let message = format!("{}: `dof` is {dof}", law.name());
                let help = "give each of 1 to 6 once: along r, s, t, then about them";
                self.trouble.error(place, message, help);
                continue;
            };
            if card.integer("type") != 0 {
                let message = format!(
                    "{}: `type` is {}: springs that yield are not supported",
                    law.name(),
                    card.integer("type")
                );
                self.unsupported(card.place("type"), message, format!("{} type", law.name()));
                continue;
            }
            let mut own = JobTable::new(law.head).with("axis", place, axis);
            // The last card may be left out.
            let more = curves.get(k).map(|more| (more.integer("flcid"), more.place("flcid")));
            match more.filter(|(id, _)| *id != 0) {
                None => own.put("stiffness", card.place("k"), card.real("k")),
                Some(curve) => {
                    let Some((at, points)) = self.force_curve(law, curve) else { continue };
                    own.put("force_elongation", at, points);
                }
            }
            if card.real("d") != 0.0 {
                own.put("damping", card.place("d"), card.real("d"));
            }
            springs.push(own);
        }
        springs
    }

    /// Makes a beam of a part of discrete beams two nodes with a spring between them. Returns true
    /// if it is one.
    pub(super) fn discrete_beam(&mut self, index: usize) -> bool {
        let beam = self.rows.beams[index];
        let Some(&has_axes) = self.discrete_beam_parts.get(&beam.part) else { return false };
        let ends = [beam.nodes[0], beam.nodes[1]];
        if !has_axes && beam.nodes[2].0 != 0 {
            let message = format!(
                "*ELEMENT_BEAM: discrete beam {} has a third node (n3) and its section no cid; \
                 axes by n3 are not supported",
                beam.id
            );
            let place = self.rows.beam_place(index);
            self.unsupported(place, message, "*ELEMENT_BEAM n3 of discrete beams".into());
        }
        self.rows.beams[index] = MeshElement::new(beam.id, beam.part, Shape::Line2, &ends);
        true
    }
}
