//! Converts `*SECTION_...` and `*HOURGLASS`: formulations and their parameters.

use super::DeckConverter;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A section.
#[derive(Debug)]
pub struct DeckSection {
    /// Kind of its elements.
    pub kind: SectionKind,
    /// Its card.
    pub record: CardRecord,
}

/// Kind of the elements of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionKind {
    /// Shells.
    Shell,
    /// Solids.
    Solid,
    /// Thick shells of eight nodes.
    ThickShell,
    /// Springs and dampers.
    Discrete,
    /// Beams.
    Beam,
    /// Particles.
    Particle,
    /// Seat belts.
    Belt,
}

/// Settings for all parts from `*CONTROL_SHELL`, `*CONTROL_HOURGLASS` and
/// `*CONTROL_BULK_VISCOSITY`.
#[derive(Clone, Copy, Debug)]
pub struct Defaults {
    pub theory: i64,
    pub warping: Option<Place>,
    pub thinning: Option<Place>,
    /// The setting that contact uses the offset of shells, if it is not zero, and its place.
    pub shifted: Option<(i64, Place)>,
    pub hourglass: Option<(DeckHourglass, Place)>,
    /// Place of the field that gives all shells a drilling stiffness.
    pub drilling: Option<Place>,
    pub bulk: Option<([f64; 2], Place)>,
}

/// An hourglass form: its number and coefficient, zero if not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckHourglass {
    pub form: i64,
    pub coefficient: f64,
}

/// All sections.
#[derive(Debug)]
pub struct Sections {
    pub by_id: HashMap<i64, DeckSection>,
    pub defaults: Defaults,
    pub hourglass: HashMap<i64, (DeckHourglass, Option<[f64; 2]>, Place)>,
}

impl Sections {
    /// Returns the linear and quadratic viscosity of parts with an hourglass control, 0 for none,
    /// and its place; `None` if the deck has none for them.
    pub fn bulk_viscosity(&self, hgid: i64) -> Option<([f64; 2], Place)> {
        let own = self.hourglass.get(&hgid).and_then(|h| h.1.map(|bulk| (bulk, h.2)));
        own.or(self.defaults.bulk)
    }
}

/// A formulation of shells: name in the job, and true if it includes warping or is a membrane.
pub struct DeckFormulation {
    pub element: &'static str,
    pub warping: bool,
    pub membrane: bool,
}

/// Returns the formulation of the engine nearest to one of the deck; `None` if there is none.
pub fn shell(elform: i64) -> Option<DeckFormulation> {
    let (element, warping) = match elform {
        1 | 2 | 3 | 4 | 11 | 17 => ("belytschko_tsay", false),
        5 | 9 => ("belytschko_tsay", false),
        10 => ("belytschko_tsay", true),
        6 | 7 | 8 | 16 | -16 | 18 | 20 | 21 | 25 | 26 => ("stabilised_quad", false),
        _ => return None,
    };
    Some(DeckFormulation { element, warping, membrane: matches!(elform, 5 | 9) })
}

/// Returns the hourglass form for a solid formulation that the engine's hexahedron can replace.
/// The outer `None` means that it cannot, the inner one that the form is not prescribed.
pub fn solid(elform: i64) -> Option<Option<&'static str>> {
    match elform {
        0 | 1 | 9 => Some(None),
        // Fully integrated: use the form with correct bending and without locking.
        2 | 3 | -1 | -2 => Some(Some("assumed_strain")),
        _ => None,
    }
}

/// Returns the volume strain of the tetrahedra that replace a formulation of tetrahedra or wedges.
pub fn pressure(elform: i64) -> Option<&'static str> {
    match elform {
        10 => Some("element"),
        // 16 and 17 have ten nodes; elements with four get the averaged volume strain too.
        13 | 15 | 16 | 17 => Some("nodal"),
        _ => None,
    }
}

impl DeckConverter {
    pub(super) fn sections(&mut self) -> Sections {
        let mut by_id = HashMap::new();
        let kinds = [
            ("SECTION_SHELL", SectionKind::Shell),
            ("SECTION_SOLID", SectionKind::Solid),
            ("SECTION_TSHELL", SectionKind::ThickShell),
            ("SECTION_BEAM", SectionKind::Beam),
            ("SECTION_DISCRETE", SectionKind::Discrete),
            ("SECTION_SPH", SectionKind::Particle),
            ("SECTION_SEATBELT", SectionKind::Belt),
        ];
        for (keyword, kind) in kinds {
            for record in self.take_records(keyword) {
                let (id, place) = (record.integer("secid"), record.place("secid"));
                if by_id.insert(id, DeckSection { kind, record }).is_some() {
                    self.trouble.error(
                        place,
                        format!("there are two sections with the id {id}"),
                        "give each a different id",
                    );
                }
            }
        }
        let mut hourglass = HashMap::new();
        for record in self.take_records("HOURGLASS") {
            let form =
                DeckHourglass { form: record.integer("ihq"), coefficient: record.real("qm") };
            for field in ["qb", "qw"] {
                let given = record.real(field);
                if given != 0.0 && given != form.coefficient {
                    let message = format!("{}: `{field}` = {given} is ignored", record.name());
                    let help = "bending and warping modes have the coefficient qm";
                    self.trouble.warning(record.place(field), message, help);
                }
            }
            let given = record.real("q1") != 0.0 || record.real("q2") != 0.0;
            let bulk = given.then(|| [record.real("q2"), record.real("q1")]);
            hourglass.insert(record.integer("hgid"), (form, bulk, record.place("ihq")));
        }
        Sections { by_id, defaults: self.defaults(), hourglass }
    }

    /// Notes sections that no part refers to; their fields need no reports.
    pub(super) fn unused_sections(&mut self, sections: &Sections) {
        let is_section = |record: &CardRecord| record.row.keyword.name.starts_with("SECTION_");
        let others = self.read.iter().filter(|record| !is_section(record));
        let used: BTreeSet<i64> =
            others.flat_map(|r| r.lines("secid")).map(|line| line.integer("secid")).collect();
        let unused = sections.by_id.iter().filter(|(id, _)| !used.contains(id));
        let unused: BTreeMap<i64, &DeckSection> = unused.map(|(id, of)| (*id, of)).collect();
        for (id, section) in unused {
            let card = &section.record;
            self.map(format!("{} {id}", card.name()), "no part refers to it", "not used");
            let place = card.place("secid");
            self.read.retain(|r| !is_section(r) || r.place("secid") != place);
        }
    }

    fn defaults(&mut self) -> Defaults {
        let mut d = Defaults {
            theory: 2,
            warping: None,
            thinning: None,
            shifted: None,
            hourglass: None,
            drilling: None,
            bulk: None,
        };
        for record in self.take_records("CONTROL_SHELL") {
            if record.integer("theory") != 0 {
                d.theory = record.integer("theory");
            }
            if record.integer("bwc") == 1 {
                d.warping = Some(record.place("bwc"));
            }
            if matches!(record.integer("istupd"), 1 | 4) {
                d.thinning = Some(record.place("istupd"));
            }
            if record.integer("drcpsid") != 0 {
                d.drilling = Some(record.place("drcpsid"));
            }
            if record.integer("cntco") != 0 {
                d.shifted = Some((record.integer("cntco"), record.place("cntco")));
            }
        }
        for record in self.take_records("CONTROL_HOURGLASS") {
            let form =
                DeckHourglass { form: record.integer("ihq"), coefficient: record.real("qh") };
            d.hourglass =
                (form.form != 0 || form.coefficient != 0.0).then(|| (form, record.place("ihq")));
        }
        for record in self.take_records("CONTROL_BULK_VISCOSITY") {
            let or = |x: f64, default: f64| if x == 0.0 { default } else { x };
            d.bulk = Some((
                [or(record.real("q2"), 0.06), or(record.real("q1"), 1.5)],
                record.place("q1"),
            ));
        }
        d
    }
}
