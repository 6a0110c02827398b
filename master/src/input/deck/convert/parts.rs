//! Converts `*PART`: material, section and hourglass control of elements. The sections of shells
//! are in `shells.rs`.

use super::DeckConverter;
use super::contact::Friction;
use super::discrete_beams::is_discrete;
use super::equations::PartEquation;
use super::inertia::DeckInertia;
use super::materials::DeckMaterial;
use super::sections::{self, DeckHourglass, DeckSection, SectionKind, Sections};
use super::solid_welds::WeldLimits;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::mesh::Shape;
use std::collections::HashMap;

/// Default hourglass coefficient in decks: LS-DYNA's QM.
const DEFAULT_HOURGLASS: f64 = 0.1;

/// A part of the deck.
#[derive(Debug)]
pub struct DeckPart {
    /// Degrees of freedom that a rigid part fixes; `None` if it is deformable.
    pub rigid: Option<Vec<&'static str>>,
    /// Name of its material.
    pub material: Option<String>,
    /// Its mass properties, if the deck gives them.
    pub inertia: Option<DeckInertia>,
    /// Place of the keyword.
    pub place: Place,
}

/// Shapes of a part's elements.
#[derive(Clone, Copy, Default)]
pub(super) struct Shapes {
    pub(super) quads: bool,
    pub(super) triangles: bool,
    /// Hexahedra.
    pub(super) solids: bool,
    /// Thick shells, which are hexahedra of the job.
    pub(super) thick_shells: bool,
    pub(super) tetrahedra: bool,
    pub(super) wedges: bool,
    pub(super) quadratic_tetrahedra: bool,
}

impl Shapes {
    /// Returns true if all solids are tetrahedra of ten nodes.
    pub(super) fn only_quadratic_tetrahedra(self) -> bool {
        self.quadratic_tetrahedra && !self.solids && !self.tetrahedra && !self.wedges
    }

    /// Returns true if some elements are no hexahedra.
    pub(super) fn have_others_than_hexahedra(self) -> bool {
        let solids = self.tetrahedra || self.wedges || self.quadratic_tetrahedra;
        solids || self.quads || self.triangles || self.thick_shells
    }

    /// Returns true if some elements are solids.
    pub(super) fn have_solids(self) -> bool {
        self.solids || self.tetrahedra || self.wedges || self.quadratic_tetrahedra
    }
}

/// Elements of a part.
#[derive(Clone, Copy)]
pub(super) struct PartElements<'a> {
    pub(super) shapes: Shapes,
    /// Shells with individual thicknesses at the corners, by index [length].
    pub(super) thickness: Option<&'a [(usize, [f64; 4])]>,
}

impl DeckConverter {
    pub(super) fn parts(&mut self, materials: &HashMap<i64, DeckMaterial>, sections: &Sections) {
        let shapes = self.shapes_of_parts();
        let own_thickness = self.thickness_of_elements();
        let mut names: Vec<String> = Vec::new();
        for record in self.take_records("PART") {
            let Some((id, name)) = self.new_part(&record, &mut names) else { continue };
            let place = record.place("pid");
            if record.integer("adpopt") != 0 {
                self.adaptive.insert(id, (record.integer("adpopt"), record.place("adpopt")));
            }
            let (mid, secid) = (record.integer("mid"), record.integer("secid"));
            let section = sections.by_id.get(&secid);
            let is_spring = section.is_some_and(|s| s.kind == SectionKind::Discrete);
            let is_discrete_beam = section.is_some_and(is_discrete);
            if (is_spring && !self.spring_laws.contains_key(&mid)
                || is_discrete_beam && !self.discrete_beam_laws.contains_key(&mid))
                && self.part_lacks(id, ("*MAT_...", "mid"), (mid, record.place("mid")))
            {
                continue;
            }
            if let Some(section) = section.filter(|_| is_spring) {
                self.parts
                    .insert(id, DeckPart { rigid: None, material: None, inertia: None, place });
                self.spring_part(&record, section, &name);
                continue;
            }
            if section.is_some_and(|section| section.kind == SectionKind::Belt) {
                self.parts
                    .insert(id, DeckPart { rigid: None, material: None, inertia: None, place });
                self.belt_part(&record, &name);
                continue;
            }
            if let Some(section) = section.filter(|_| is_discrete_beam) {
                self.discrete_beam_part(&record, section, &name);
                continue;
            }
            let material = materials.get(&mid);
            self.check_references(&record, (material, materials), (section, sections));
            if self.is_left_out(id) {
                continue;
            }
            let (Some(material), Some(section)) = (material, section) else {
                let part = DeckPart { rigid: None, material: None, inertia: None, place };
                self.parts.insert(id, part);
                continue;
            };
            if section.kind == SectionKind::Particle {
                let part = DeckPart { rigid: None, material: None, inertia: None, place };
                self.parts.insert(id, part);
                self.refuse_inertia(&record);
                self.particle_part(&record, &name, material, (section, sections));
                continue;
            }
            let elements = PartElements {
                shapes: shapes.get(&id).copied().unwrap_or_default(),
                thickness: own_thickness.get(&id).map(Vec::as_slice),
            };
            let table = self.part_table(&record, name, material, (section, sections), elements);
            if self.is_left_out(id) {
                continue;
            }
            if material.rigid.is_none() {
                self.refuse_inertia(&record);
            }
            let part = DeckPart {
                rigid: material.rigid.clone(),
                material: Some(material.name.clone()),
                inertia: self.inertia_card(&record),
                place,
            };
            self.parts.insert(id, part);
            if !self.used_materials.contains(&mid) {
                self.used_materials.push(mid);
            }
            self.add("part", table);
        }
        self.parts_with_layers(materials, sections, &mut names);
        self.remove_left_out();
        self.unused_sections(sections);
    }

    /// Refuses the mass properties of a part that is not rigid.
    fn refuse_inertia(&mut self, record: &CardRecord) {
        if record.line("tm").is_some() {
            let id = record.integer("pid");
            let message = format!("part {id}: *PART_INERTIA of a part that is not rigid");
            self.unsupported(record.place("tm"), message, "*PART_INERTIA".into());
        }
    }

    /// Returns id and name of a part, and adds the name to those taken; `None` after an error.
    pub(super) fn new_part(
        &mut self,
        record: &CardRecord,
        names: &mut Vec<String>,
    ) -> Option<(i64, String)> {
        let id = record.integer("pid");
        if self.parts.contains_key(&id) {
            let message = format!("there are two *PART with the id {id}");
            self.trouble.error(record.place("pid"), message, "give each a different id");
            return None;
        }
        let name = part_name(record, id, names);
        names.push(name.clone());
        Some((id, name))
    }

    pub(super) fn shapes_of_parts(&self) -> HashMap<i64, Shapes> {
        let mut all: HashMap<i64, Shapes> = HashMap::new();
        for &at in &self.rows.thick {
            all.entry(i64::from(self.rows.solids[at].part)).or_default().thick_shells = true;
        }
        let mut thick = self.rows.thick.iter().map(|&at| at + self.rows.shells.len()).peekable();
        for (at, element) in self.rows.elements().enumerate() {
            if thick.next_if_eq(&at).is_some() {
                continue;
            }
            let shapes = all.entry(i64::from(element.part)).or_default();
            match element.shape {
                Shape::Quad4 => shapes.quads = true,
                Shape::Tri3 => shapes.triangles = true,
                Shape::Hex8 => shapes.solids = true,
                Shape::Tet4 => shapes.tetrahedra = true,
                Shape::Tet10 => shapes.quadratic_tetrahedra = true,
                Shape::Wedge6 => shapes.wedges = true,
                // Their sections have no conditions.
                Shape::Line2
                | Shape::Beam2
                | Shape::Truss2
                | Shape::Point1
                // The part of a job makes hexahedra cohesive; decks have none yet.
                | Shape::Cohesive8 => {}
            }
        }
        all
    }

    /// Converts a part with a material and a section to a table of the job.
    fn part_table(
        &mut self,
        record: &CardRecord,
        name: String,
        material: &DeckMaterial,
        (section, sections): (&DeckSection, &Sections),
        elements: PartElements<'_>,
    ) -> JobTable {
        let id = record.integer("pid");
        self.equation_of(record, material, section.kind);
        let mut table = JobTable::new(record.head)
            .with("id", record.place("pid"), id)
            .with("name", record.place("heading"), name)
            .with("material", record.place("mid"), material.name.as_str());
        self.contact_card(record, id, section.kind, &mut table);
        match section.kind {
            SectionKind::Shell => {
                self.shell(record, material, (section, sections), elements, &mut table)
            }
            SectionKind::Solid => {
                let card = &section.record;
                let form = (card.integer("elform"), card.place("elform"));
                if !self.cohesive_part(record, form, material, elements.shapes, &mut table) {
                    self.solid(record, section, sections, elements.shapes, &mut table);
                }
            }
            SectionKind::ThickShell => {
                self.thick_shell(record, material, (section, sections), elements, &mut table)
            }
            SectionKind::Beam => self.beam_part(record, section, material, &mut table),
            SectionKind::Discrete | SectionKind::Particle | SectionKind::Belt => {}
        }
        self.check_material(record, material, section.kind, &mut table);
        let step = material.deletion_step.filter(|_| material.rigid.is_none());
        let deletes = match section.kind {
            SectionKind::Shell | SectionKind::ThickShell => true,
            SectionKind::Solid => material.cohesive.is_none(),
            _ => false,
        };
        match step {
            Some((step, place)) if deletes => table.put("deletion_step", place, step),
            Some((step, _)) => {
                let why = "not used: only shells and solids are deleted by their step";
                self.map(format!("part {id}"), format!("tdel {step}"), why);
            }
            None => {}
        }
        table
    }

    /// Reports a part without its material or its section.
    fn check_references(
        &mut self,
        record: &CardRecord,
        (material, materials): (Option<&DeckMaterial>, &HashMap<i64, DeckMaterial>),
        (section, sections): (Option<&DeckSection>, &Sections),
    ) {
        let [id, mid, secid] = ["pid", "mid", "secid"].map(|field| record.integer(field));
        if material.is_none() {
            let mut known: Vec<i64> = materials.keys().copied().collect();
            known.sort_unstable();
            let known: Vec<String> = known.iter().map(i64::to_string).collect();
            if self.spring_laws.contains_key(&mid) {
                let message =
                    format!("part {id} has no springs, and material {mid} is for springs only");
                self.trouble.error(
                    record.place("mid"),
                    message,
                    "give it another *MAT_..., or a *SECTION_DISCRETE",
                );
            } else if self.belts.laws().any(|law| *law == mid) {
                let message = format!("part {id}: material {mid} is for seat belts only");
                let help = "give it another *MAT_..., or a *SECTION_SEATBELT";
                self.trouble.error(record.place("mid"), message, help);
            } else if self.discrete_beam_laws.contains_key(&mid) {
                let message =
                    format!("part {id}: material {mid} is for discrete beams (elform 6) only");
                let help = "give it another *MAT_..., or a *SECTION_BEAM with elform 6";
                self.trouble.error(record.place("mid"), message, help);
            } else {
                let card = (mid, record.place("mid"));
                if !self.part_lacks(id, ("*MAT_...", "mid"), card) {
                    self.missing(card.1, "*MAT_...", mid, &known);
                }
            }
        }
        let card = (secid, record.place("secid"));
        if section.is_none() && !self.part_lacks(id, ("*SECTION_...", "secid"), card) {
            let mut known: Vec<i64> = sections.by_id.keys().copied().collect();
            known.sort_unstable();
            let known: Vec<String> = known.iter().map(i64::to_string).collect();
            self.missing(card.1, "*SECTION_...", secid, &known);
        }
    }

    /// Notes the equation of state of a part; only solids that deform have one.
    fn equation_of(&mut self, record: &CardRecord, material: &DeckMaterial, kind: SectionKind) {
        let [pid, mid, eosid] = ["pid", "mid", "eosid"].map(|field| record.integer(field));
        let why = match kind {
            _ if material.rigid.is_some() => "not used: the part is rigid",
            SectionKind::Solid => {
                let place = record.place("eosid");
                let card = ("*EOS_...", "eosid");
                if material.needs_equation() && self.part_lacks(pid, card, (eosid, place)) {
                    return;
                }
                self.equations.push(PartEquation { ids: [pid, mid, eosid], place });
                return;
            }
            _ => "not used: only solids have a pressure of their own",
        };
        if eosid != 0 {
            self.map(format!("part {pid}"), format!("eosid {eosid}"), why);
        }
    }

    /// Makes a part of a null material a skin, and reports materials that its elements cannot have.
    fn check_material(
        &mut self,
        record: &CardRecord,
        material: &DeckMaterial,
        kind: SectionKind,
        table: &mut JobTable,
    ) {
        let id = record.integer("pid");
        if material.is_hydro && kind != SectionKind::Solid {
            let message =
                format!("part {id}: *MAT_ELASTIC_PLASTIC_HYDRO is supported for solids only");
            self.unsupported(record.place("mid"), message, "*MAT_ELASTIC_PLASTIC_HYDRO".into());
        }
        match (material.skin, kind) {
            (false, _) => {}
            (true, SectionKind::Shell) => {
                self.skins.entry(record.integer("mid")).or_insert(id);
                table.put("skin", record.place("mid"), true);
                for field in ["pc", "mu", "terod", "cerod"] {
                    if let Some(given) = material.fluid.as_ref().map(|card| card.real(field))
                        && given != 0.0
                    {
                        let why = "not used: it is for fluids and failure of solids";
                        self.map("*MAT_NULL", format!("{field} {given}"), why);
                    }
                }
                self.map(
                    format!("part {id}"),
                    "*MAT_NULL",
                    "a skin: it has contact and mass, and carries no load",
                );
            }
            // With an equation of state it is a fluid.
            (true, SectionKind::Solid) => {
                if table.has("hourglass") {
                    table.put("hourglass", record.place("mid"), "viscous");
                    let why = "viscous: a fluid has no stiffness against a change of shape";
                    self.map(format!("part {id}"), "hourglass control of *MAT_NULL", why);
                }
            }
            (true, _) => {
                let message = format!(
                    "part {id}: *MAT_NULL is supported for shells, solids and particles only"
                );
                self.unsupported(record.place("mid"), message, "*MAT_NULL".into());
            }
        }
        if let Some((limits, at)) = material.weld {
            let mid = record.integer("mid");
            match (kind, limits) {
                (SectionKind::Beam, WeldLimits::Forces(_)) => {
                    self.weld_beams.insert(mid);
                }
                (SectionKind::Solid, _) => self.weld_parts.push((id, mid, record.place("mid"))),
                (SectionKind::Beam, WeldLimits::Stresses(_)) => {
                    let message = format!("part {id}: limits of beams that are welds are forces");
                    self.unsupported(at, message, "*MAT_SPOTWELD_DAMAGE-FAILURE opt 1".into());
                }
                _ => {
                    let message =
                        format!("part {id}: limits of welds are supported for beams and solids");
                    self.unsupported(at, message, "*MAT_SPOTWELD nrr".into());
                }
            }
        }
    }

    /// Converts the card of `*PART_CONTACT`: individual friction and contact thickness.
    pub(super) fn contact_card(
        &mut self,
        record: &CardRecord,
        id: i64,
        kind: SectionKind,
        table: &mut JobTable,
    ) {
        if !record.has("CONTACT") {
            return;
        }
        self.part_friction.insert(id, Friction::from_record(record));
        for (field, key) in [("optt", "contact_thickness"), ("sft", "contact_thickness_scale")] {
            let value = record.real(field);
            if value > 0.0 && kind == SectionKind::Shell {
                table.put(key, record.place(field), value);
            } else if value > 0.0 {
                self.map(
                    format!("part {id}"),
                    format!("{field} {value}"),
                    "not used: it is for shells only",
                );
            }
        }
    }

    fn solid(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        sections: &Sections,
        shapes: Shapes,
        table: &mut JobTable,
    ) {
        let card = &section.record;
        let (id, elform) = (record.integer("pid"), card.integer("elform"));
        self.refuse_other_shapes(record, section, shapes);
        let has_others = shapes.tetrahedra || shapes.wedges || shapes.quadratic_tetrahedra;
        let became = match (sections::solid(elform), sections::pressure(elform)) {
            (Some(_), _) if shapes.only_quadratic_tetrahedra() => {
                "tetrahedra of ten nodes".to_string()
            }
            (Some(_), _) if has_others && !shapes.solids => "tetrahedra or wedges".to_string(),
            (Some(wanted), _) => {
                table.put("element", card.place("elform"), "hexahedron");
                let (form, origin) = match wanted {
                    Some(form) => {
                        table.put("hourglass", card.place("elform"), form);
                        let message = format!(
                            "part {id}: elform {elform} has several points per element, here there \
                             is one"
                        );
                        let help = "compare with a finer mesh where solids bend";
                        self.trouble.warning(card.place("elform"), message, help);
                        (form, "")
                    }
                    None => self.hourglass(record, sections, table, true),
                };
                format!("hexahedron; hourglass {form}{origin}")
            }
            (None, Some(_)) if shapes.only_quadratic_tetrahedra() => {
                "tetrahedra of ten nodes".to_string()
            }
            (None, Some(pressure)) if !shapes.solids => {
                if shapes.tetrahedra {
                    table.put("element", card.place("elform"), "tetrahedron");
                }
                // The default averages with the laws that allow it.
                if pressure == "element" {
                    table.put("pressure", card.place("elform"), pressure);
                }
                let foams = if pressure == "nodal" { "; element with foams" } else { "" };
                format!("tetrahedra or wedges; pressure {pressure}{foams}")
            }
            _ => {
                let help = "use the hexahedron with one point (1), which 2 is converted to; 10, \
                            13, 16 and 17 are for tetrahedra, 15 is for wedges, 19 for cohesive \
                            elements";
                self.unsupported_value(card, "elform", help);
                return;
            }
        };
        if let Some((bulk, place)) = sections.bulk_viscosity(record.integer("hgid")) {
            table.put("bulk_viscosity", place, bulk);
        }
        if let Some(place) = self.eroding {
            table.put("inverted", place, "delete");
        }
        self.map(format!("part {id}"), format!("solids, elform {elform}"), became);
    }

    /// Reports the elements of a part that its section is not for.
    pub(super) fn refuse_other_shapes(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        shapes: Shapes,
    ) {
        let [id, secid] = ["pid", "secid"].map(|field| record.integer(field));
        let kinds = [
            (SectionKind::Shell, shapes.quads || shapes.triangles, "shells", "*SECTION_SHELL"),
            (SectionKind::Solid, shapes.have_solids(), "solids", "*SECTION_SOLID"),
            (SectionKind::ThickShell, shapes.thick_shells, "thick shells", "*SECTION_TSHELL"),
        ];
        let own = kinds.iter().find(|kind| kind.0 == section.kind).map_or("", |kind| kind.3);
        for (_, _, elements, wanted) in kinds.iter().filter(|k| k.0 != section.kind && k.1) {
            let message = format!("part {id} has {elements} and {own} {secid}");
            let help = format!("give the {elements} a separate part with a {wanted}");
            self.trouble.error(record.place("secid"), message, help);
        }
    }

    /// Reports an hourglass control that a part refers to and that does not exist.
    pub(super) fn check_hourglass(&mut self, record: &CardRecord, sections: &Sections) {
        let hgid = record.integer("hgid");
        if hgid != 0 && !sections.hourglass.contains_key(&hgid) {
            let known: Vec<String> = sections.hourglass.keys().map(i64::to_string).collect();
            self.missing(record.place("hgid"), "*HOURGLASS", hgid, &known);
        }
    }

    /// Converts the hourglass control of a part. Returns the name of the form and its origin.
    /// Without any, the format has the viscous form with the coefficient 0.1.
    pub(super) fn hourglass(
        &mut self,
        record: &CardRecord,
        sections: &Sections,
        table: &mut JobTable,
        solids: bool,
    ) -> (&'static str, &'static str) {
        let hgid = record.integer("hgid");
        let own = sections.hourglass.get(&hgid).map(|h| (h.0, h.2));
        self.check_hourglass(record, sections);
        let given = own.or(sections.defaults.hourglass);
        let none = DeckHourglass { form: 0, coefficient: 0.0 };
        let (DeckHourglass { form, mut coefficient }, place) =
            given.unwrap_or((none, record.place("hgid")));
        let (name, origin) = match (form, solids) {
            (0, _) if given.is_none() => ("viscous", " (none in the deck)"),
            (0, _) => ("viscous", " (ihq blank)"),
            (1..=3, _) => ("viscous", ""),
            (4 | 5, _) => ("stiffness", ""),
            (6 | 7 | 9 | 10, true) => ("assumed_strain", ""),
            (6 | 7 | 9 | 10, false) => ("viscous", " (this ihq is for solids)"),
            (16, _) => {
                let message = format!(
                    "part {}: ihq 16 has no counterpart: its elements have the viscous control",
                    record.integer("pid")
                );
                let help = "give the part an hgid, the id of a *HOURGLASS with ihq 1 to 10";
                self.trouble.warning(place, message, help);
                coefficient = 0.0;
                ("viscous", " (in place of ihq 16)")
            }
            (8, true) if own.is_none() => {
                let message = format!(
                    "part {}: ihq 8 of *CONTROL_HOURGLASS is for shells: its solids have the \
                     viscous control",
                    record.integer("pid")
                );
                let help = "give the part an hgid, the id of a *HOURGLASS for solids";
                self.trouble.warning(place, message, help);
                coefficient = 0.0;
                ("viscous", " (ihq 8 is for shells)")
            }
            _ => {
                let message =
                    format!("part {}: ihq {form} is not supported", record.integer("pid"));
                self.unsupported(place, message, format!("*HOURGLASS ihq {form}"));
                // The coefficient belongs to that form.
                coefficient = 0.0;
                ("viscous", "")
            }
        };
        table.put("hourglass", place, name);
        if name != "assumed_strain" {
            let coefficient = if coefficient == 0.0 { DEFAULT_HOURGLASS } else { coefficient };
            table.put("hourglass_coefficient", place, coefficient);
        } else if coefficient != 0.0 && coefficient != 1.0 {
            self.map(
                format!("part {}", record.integer("pid")),
                format!("ihq {form} with qm {coefficient}"),
                "assumed_strain, which has no coefficient",
            );
        }
        (name, origin)
    }
}

/// Returns the name of a part, other than those of earlier parts.
fn part_name(record: &CardRecord, id: i64, names: &[String]) -> String {
    let heading = record.word("heading").to_string();
    match heading.is_empty() {
        true => format!("part-{id}"),
        false if names.contains(&heading) => format!("{heading} ({id})"),
        false => heading,
    }
}
