//! Converts `*PART`: material, section and hourglass control of elements.

use super::DeckConverter;
use super::contact::Friction;
use super::materials::Material;
use super::sections::{self, DeckSection, Hourglass, SectionKind, Sections};
use super::tree::Table;
use crate::input::deck::record::Record;
use crate::input::job::tree::Place;
use crumple_proto::mesh::{MeshElement, Shape};
use crumple_worker::fem::elements::LARGEST_OFFSET;
use std::collections::{BTreeMap, HashMap};

/// Default hourglass coefficient of shells in decks: LS-DYNA's QM.
const DEFAULT_HOURGLASS: f64 = 0.1;
/// Difference of offsets over half the thickness that is round-off of the deck.
const SAME_OFFSET: f64 = 1e-6;

/// A part of the deck.
#[derive(Debug)]
pub struct Part {
    /// Degrees of freedom that a rigid part fixes; `None` if it is deformable.
    pub rigid: Option<Vec<&'static str>>,
    /// Name of its material.
    pub material: Option<String>,
    /// Place of the keyword.
    pub place: Place,
}

/// Shapes of a part's elements.
#[derive(Clone, Copy, Default)]
struct Shapes {
    quads: bool,
    triangles: bool,
    solids: bool,
}

impl DeckConverter {
    pub(super) fn parts(&mut self, materials: &HashMap<i64, Material>, sections: &Sections) {
        let mut shapes: HashMap<i64, Shapes> = HashMap::new();
        for element in self.rows.elements() {
            let of = shapes.entry(i64::from(element.part)).or_default();
            match element.shape {
                Shape::Quad4 => of.quads = true,
                Shape::Tri3 => of.triangles = true,
                Shape::Hex8 => of.solids = true,
                Shape::Line2 | Shape::Beam2 => {} // their sections have no conditions
            }
        }
        let own_thickness = self.thickness_of_elements();
        let mut names: Vec<String> = Vec::new();
        let mut taken: Vec<i64> = Vec::new();
        for record in self.take_records("PART") {
            let (id, place) = (record.integer("pid"), record.place("pid"));
            if self.parts.contains_key(&id) {
                self.trouble.error(
                    place,
                    format!("there are two *PART with the id {id}"),
                    "give each a different id",
                );
                continue;
            }
            let heading = record.word("heading").to_string();
            let name = match heading.is_empty() {
                true => format!("part-{id}"),
                false if names.contains(&heading) => format!("{heading} ({id})"),
                false => heading,
            };
            names.push(name.clone());
            let (mid, secid) = (record.integer("mid"), record.integer("secid"));
            let section = sections.by_id.get(&secid);
            if let Some(section) = section.filter(|s| s.kind == SectionKind::Discrete) {
                self.parts.insert(id, Part { rigid: None, material: None, place });
                self.spring_part(&record, section, &name);
                continue;
            }
            let material = materials.get(&mid);
            self.check_references(&record, (material, materials), (section, sections));
            let (Some(material), Some(section)) = (material, section) else {
                let part = Part { rigid: None, material: None, place };
                self.parts.insert(id, part);
                continue;
            };
            if record.integer("eosid") != 0 {
                self.unsupported_value(&record, "eosid", "an equation of state");
            }
            let mut table = Table::new(record.head)
                .with("id", place, id)
                .with("name", record.place("heading"), name)
                .with("material", record.place("mid"), material.name.as_str());
            self.contact_card(&record, id, section.kind, &mut table);
            let shapes = shapes.get(&id).copied().unwrap_or_default();
            match section.kind {
                SectionKind::Shell => self.shell(
                    &record,
                    section,
                    sections,
                    shapes,
                    own_thickness.get(&id),
                    &mut table,
                ),
                SectionKind::Solid => self.solid(&record, section, sections, shapes, &mut table),
                SectionKind::Beam => self.beam_part(&record, section, material, &mut table),
                SectionKind::Discrete => {}
            }
            self.check_material(&record, material, section.kind, &mut table);
            let part = Part {
                rigid: material.rigid.clone(),
                material: Some(material.name.clone()),
                place,
            };
            self.parts.insert(id, part);
            if !taken.contains(&mid) {
                taken.push(mid);
            }
            self.add("part", table);
        }
        self.used_materials = taken;
    }

    /// Reports a part without its material or its section.
    fn check_references(
        &mut self,
        record: &Record,
        (material, materials): (Option<&Material>, &HashMap<i64, Material>),
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
            } else {
                self.missing(record.place("mid"), "*MAT_...", mid, &known);
            }
        }
        if section.is_none() {
            let mut known: Vec<i64> = sections.by_id.keys().copied().collect();
            known.sort_unstable();
            let known: Vec<String> = known.iter().map(i64::to_string).collect();
            self.missing(record.place("secid"), "*SECTION_...", secid, &known);
        }
    }

    /// Makes a part of a null material a skin, and reports materials that its elements cannot have.
    fn check_material(
        &mut self,
        record: &Record,
        material: &Material,
        kind: SectionKind,
        table: &mut Table,
    ) {
        let id = record.integer("pid");
        match (material.skin, kind) {
            (false, _) => {}
            (true, SectionKind::Shell) => {
                table.put("skin", record.place("mid"), true);
                self.map(
                    format!("part {id}"),
                    "*MAT_NULL",
                    "a skin: it has contact and mass, and carries no load",
                );
            }
            (true, _) => {
                let message = format!("part {id}: *MAT_NULL is supported for shells only");
                self.unsupported(record.place("mid"), message, "*MAT_NULL".into());
            }
        }
        if let (Some((_, at)), true) = (material.weld, kind != SectionKind::Beam) {
            let message = format!("part {id}: limits of welds are supported for beams only");
            self.unsupported(at, message, "*MAT_SPOTWELD nrr".into());
        }
    }

    /// Converts the card of `*PART_CONTACT`: individual friction and contact thickness.
    fn contact_card(&mut self, record: &Record, id: i64, kind: SectionKind, table: &mut Table) {
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

    /// Converts a part of shells.
    fn shell(
        &mut self,
        record: &Record,
        section: &DeckSection,
        sections: &Sections,
        shapes: Shapes,
        own: Option<&Vec<(usize, [f64; 4])>>,
        table: &mut Table,
    ) {
        let card = &section.record;
        let id = record.integer("pid");
        let of = format!("part {id}");
        if shapes.solids {
            let message =
                format!("part {id} has solids and *SECTION_SHELL {}", card.integer("secid"));
            self.trouble.error(
                record.place("secid"),
                message,
                "give the solids a separate part with a *SECTION_SOLID",
            );
        }
        let elform = match card.integer("elform") {
            0 => sections.defaults.theory,
            given => given,
        };
        let corners = ["t1", "t2", "t3", "t4"].map(|t| card.real(t));
        let given = if corners[1..].iter().all(|&t| t == 0.0) { [corners[0]; 4] } else { corners };
        let mean = if given[1..].iter().all(|&t| t == given[0]) {
            given[0]
        } else {
            given.iter().sum::<f64>() / 4.0
        };
        let mut thickness = mean;
        if given.iter().any(|&t| t != mean) {
            self.map(
                &of,
                format!("thicknesses {given:?} at the corners"),
                format!("their mean {mean}"),
            );
        }
        if let Some(own) = own {
            thickness = self.own_thickness(id, own, given, mean);
        }
        table.put("thickness", card.place("t1"), thickness);
        match card.integer("nip") {
            0 => table.put("points", card.place("nip"), 2),
            n => table.put("points", card.place("nip"), n),
        }
        // LS-DYNA's nloc is the position of the nodes in the section, `offset` that of the middle
        // surface relative to the nodes.
        let of_section = if card.real("nloc") == 0.0 { 0.0 } else { -card.real("nloc") };
        let offset = self.own_offset((id, record.place("pid")), of_section, thickness);
        if offset != 0.0 {
            table.put("offset", card.place("nloc"), offset);
        }
        let of_this = |s: &MeshElement| i64::from(s.part) == id && s.own.offset.is_some();
        if offset != 0.0 || self.rows.shells.iter().any(of_this) {
            let own_contact_thickness =
                ["contact_thickness", "contact_thickness_scale"].iter().any(|key| table.has(key));
            self.with_offset.push((id, own_contact_thickness));
        }
        let Some(form) = sections::shell(elform) else {
            self.unsupported_value(
                card,
                "elform",
                "no formulation of shells is similar; use 2 or 16",
            );
            return;
        };
        table.put("element", card.place("elform"), form.element);
        let bt = form.element == "belytschko_tsay";
        let warping = form.warping || (matches!(elform, 2) && sections.defaults.warping.is_some());
        if bt && warping {
            table.put("warping", sections.defaults.warping.unwrap_or(card.place("elform")), true);
        }
        if let Some(place) = sections.defaults.thinning {
            table.put("thinning", place, true);
        }
        let mut used = if shapes.quads || !shapes.triangles {
            form.element.to_string()
        } else {
            String::new()
        };
        if bt && warping && !used.is_empty() {
            used += " with warping terms";
        }
        if shapes.triangles {
            let and = if used.is_empty() { "" } else { ", " };
            used += &format!("{and}c0_triangle");
        }
        if bt {
            let (form, origin) = self.hourglass(record, sections, table, false);
            used += &format!("; hourglass {form}{origin}");
        }
        let asked = match card.integer("elform") {
            0 => format!("shells, theory {elform}"),
            _ => format!("shells, elform {elform}"),
        };
        self.map(&of, asked, used);
        let shear = card.real("shrf");
        if (shear - 5.0 / 6.0).abs() > 1e-3 {
            self.map(&of, format!("shear factor {shear}"), "5/6");
        }
        if !matches!(card.real("qr"), 0.0) {
            self.map(&of, format!("qr {}: integration rule", card.real("qr")), "Gauss points");
        }
    }

    fn solid(
        &mut self,
        record: &Record,
        section: &DeckSection,
        sections: &Sections,
        shapes: Shapes,
        table: &mut Table,
    ) {
        let card = &section.record;
        let (id, elform) = (record.integer("pid"), card.integer("elform"));
        if shapes.quads || shapes.triangles {
            let message =
                format!("part {id} has shells and *SECTION_SOLID {}", card.integer("secid"));
            self.trouble.error(
                record.place("secid"),
                message,
                "give the shells a separate part with a *SECTION_SHELL",
            );
        }
        let Some(wanted) = sections::solid(elform) else {
            self.unsupported_value(
                card,
                "elform",
                "use the hexahedron with one point (1); 2 is converted to it",
            );
            return;
        };
        table.put("element", card.place("elform"), "hexahedron");
        let (form, origin) = match wanted {
            Some(form) => {
                table.put("hourglass", card.place("elform"), form);
                (form, "")
            }
            None => self.hourglass(record, sections, table, true),
        };
        let own = sections
            .hourglass
            .get(&record.integer("hgid"))
            .and_then(|h| h.1.map(|bulk| (bulk, h.2)));
        if let Some((bulk, place)) = own.or(sections.defaults.bulk) {
            table.put("bulk_viscosity", place, bulk);
        }
        self.map(
            format!("part {id}"),
            format!("solids, elform {elform}"),
            format!("hexahedron; hourglass {form}{origin}"),
        );
    }

    /// Converts the hourglass control of a part. Returns the name of the form and its origin.
    fn hourglass(
        &mut self,
        record: &Record,
        sections: &Sections,
        table: &mut Table,
        solids: bool,
    ) -> (&'static str, &'static str) {
        // LS-DYNA's default in explicit analysis for shells.
        let default = if solids { "assumed_strain" } else { "viscous" };
        let hgid = record.integer("hgid");
        let own = sections.hourglass.get(&hgid).map(|h| (h.0, h.2));
        if hgid != 0 && own.is_none() {
            let known: Vec<String> = sections.hourglass.keys().map(i64::to_string).collect();
            self.missing(record.place("hgid"), "*HOURGLASS", hgid, &known);
        }
        let Some((Hourglass { form, coefficient }, place)) = own.or(sections.defaults.hourglass)
        else {
            if !solids {
                table.put("hourglass", record.place("hgid"), default);
                table.put("hourglass_coefficient", record.place("hgid"), DEFAULT_HOURGLASS);
            }
            return (default, " (none in the deck)");
        };
        let name = match (form, solids) {
            (0, _) => default,
            (1..=3, _) => "viscous",
            (4 | 5, _) => "stiffness",
            (6 | 7 | 9 | 10, true) => "assumed_strain",
            _ => default,
        };
        table.put("hourglass", place, name);
        if name != "assumed_strain" && (coefficient > 0.0 || !solids) {
            let coefficient = if coefficient > 0.0 { coefficient } else { DEFAULT_HOURGLASS };
            table.put("hourglass_coefficient", place, coefficient);
        }
        let origin = match form {
            0 => " (ihq blank)",
            1..=5 => "",
            6 | 7 | 9 | 10 if solids => "",
            _ => " (this ihq is not available)",
        };
        (name, origin)
    }

    /// Returns the shells of each part with individual thicknesses at the corners, by index.
    fn thickness_of_elements(&self) -> BTreeMap<i64, Vec<(usize, [f64; 4])>> {
        let mut all: BTreeMap<i64, Vec<(usize, [f64; 4])>> = BTreeMap::new();
        for &(at, corners) in &self.rows.thickness {
            if let Some(shell) = self.rows.shells.get(at) {
                all.entry(i64::from(shell.part)).or_default().push((at, corners));
            }
        }
        all
    }

    /// Sets the thickness of shells to the mean of their corners. Corners without a thickness
    /// have that of the section. One point in the plane cannot resolve more. Returns the
    /// thickness of the part: that of its section, or of all its shells if it is uniform.
    fn own_thickness(
        &mut self,
        id: i64,
        own: &[(usize, [f64; 4])],
        corners: [f64; 4],
        mean: f64,
    ) -> f64 {
        let mean_of = |&(at, own): &(usize, [f64; 4])| {
            let shell = self.rows.shells.get(at)?;
            let n = shell.shape.corners();
            let all: [f64; 4] =
                std::array::from_fn(|c| if own[c] > 0.0 { own[c] } else { corners[c] });
            let even = all[1..n].iter().all(|&t| t == all[0]);
            Some((at, if even { all[0] } else { all[..n].iter().sum::<f64>() / n as f64 }))
        };
        let means: Vec<(usize, f64)> = own.iter().filter_map(mean_of).collect();
        let (least, most) =
            means.iter().fold((f64::INFINITY, 0.0_f64), |m, t| (m.0.min(t.1), m.1.max(t.1)));
        let covers =
            means.len() == self.rows.shells.iter().filter(|s| i64::from(s.part) == id).count();
        if covers && least == most {
            self.map(
                format!("part {id}"),
                format!("thickness {most} of all its shells"),
                "thickness of the part",
            );
            return most;
        }
        for &(at, thickness) in &means {
            self.rows.shells[at].own.thickness = thickness;
        }
        let asked = format!("thickness of {} of its shells, {least} to {most}", means.len());
        self.map(format!("part {id}"), asked, "one for each shell, the mean of its corners");
        let average = means.iter().map(|t| t.1).sum::<f64>() / means.len() as f64;
        if mean == 0.0 && covers { average } else { mean }
    }

    /// Returns the offset of the shells of a part over half their thickness: that of
    /// `*ELEMENT_SHELL_OFFSET`, if it is the same for all of them, or that of the section. Shells
    /// with another offset get their own.
    fn own_offset(&mut self, (id, place): (i64, Place), of_section: f64, thickness: f64) -> f64 {
        let mut offsets: BTreeMap<usize, f64> = BTreeMap::new();
        for &(at, offset) in &self.rows.offsets {
            if self.rows.shells.get(at).is_some_and(|s| i64::from(s.part) == id) {
                offsets.insert(at, offset);
            }
        }
        if offsets.is_empty() {
            return of_section;
        }
        for (&at, offset) in &mut offsets {
            let own = self.rows.shells[at].own.thickness;
            *offset *= 2.0 / if own > 0.0 { own } else { thickness };
        }
        let all = self.rows.shells.iter().filter(|s| i64::from(s.part) == id).count();
        let of_others = (offsets.len() < all).then_some(of_section);
        let (least, most) = offsets
            .values()
            .copied()
            .chain(of_others)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |m, r| (m.0.min(r), m.1.max(r)));
        let asked = format!("offsets of {} of its shells", offsets.len());
        if most - least <= SAME_OFFSET * (1.0 + most.abs()) {
            let used = format!("offset {most} of the part, over half the thickness");
            self.map(format!("part {id}"), asked, used);
            return most;
        }
        for (&at, &offset) in &offsets {
            self.rows.shells[at].own.offset = Some(offset);
        }
        if least.abs().max(most.abs()) > LARGEST_OFFSET {
            let message = format!(
                "part {id}: the offsets of its shells are {least} to {most} times half their \
                 thickness"
            );
            let help = "they have to be from -10 to 10 (-1 to 1 is usual)";
            self.trouble.error(place, message, help);
        }
        let used = format!("one for each shell, {least} to {most} over half the thickness");
        self.map(format!("part {id}"), asked, used);
        of_section
    }
}
