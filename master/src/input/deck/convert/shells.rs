//! Converts the sections of shells: thickness, offset and element formulation of a part.

use super::DeckConverter;
use super::materials::DeckMaterial;
use super::parts::PartElements;
use super::sections::{self, DeckSection, Sections};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::mesh::MeshElement;
use crumple_worker::fem::elements::{LARGEST_OFFSET, THICK_SHELL};
use std::collections::BTreeMap;

/// Thickness over the side of a square as large as the mean shell of a rigid part whose section has
/// none. It is far below the errors of contact by the size of the shells, and contact needs one
/// above 0.
const STAND_IN: f64 = 0.01;

/// Difference of offsets over half the thickness that is round-off of the deck.
const SAME_OFFSET: f64 = 1e-6;

impl DeckConverter {
    /// Converts a part of shells.
    pub(super) fn shell(
        &mut self,
        record: &CardRecord,
        material: &DeckMaterial,
        (section, sections): (&DeckSection, &Sections),
        elements: PartElements<'_>,
        table: &mut JobTable,
    ) {
        let card = &section.record;
        let id = record.integer("pid");
        self.refuse_other_shapes(record, section, elements.shapes);
        let mut thickness = self.shell_thickness(id, card, elements);
        if thickness == 0.0 && material.rigid.is_some() {
            thickness = self.stand_in_thickness(id, (record, card), material);
        }
        table.put("thickness", card.place("t1"), thickness);
        if card.real("marea") != 0.0 {
            self.mass_of_area(id, card, material, thickness, table);
        }
        match card.integer("nip") {
            0 => table.put("points", card.place("nip"), 2),
            n => table.put("points", card.place("nip"), n),
        }
        self.shell_offset(record, card, thickness, table);
        self.shell_formulation(record, section, sections, elements, table);
        self.angles_of_points(record, card, material, table);
        self.replace_angles(id, material);
    }

    /// Converts a part of thick shells.
    pub(super) fn thick_shell(
        &mut self,
        record: &CardRecord,
        material: &DeckMaterial,
        (section, sections): (&DeckSection, &Sections),
        elements: PartElements<'_>,
        table: &mut JobTable,
    ) {
        let card = &section.record;
        let id = record.integer("pid");
        self.refuse_other_shapes(record, section, elements.shapes);
        let elform = card.integer("elform");
        let differs = match elform {
            0 | 1 | 6 => "",
            2 => "; it has one point in its plane, not four",
            3 | 5 | 7 => "; the law is in plane stress at its points",
            _ => {
                self.unsupported_value(card, "elform", "use a thick shell with one point (1)");
                return;
            }
        };
        table.put("element", card.place("elform"), THICK_SHELL);
        let points = if card.integer("nip") == 0 { 2 } else { card.integer("nip") };
        table.put("points", card.place("nip"), points);
        if let Some(place) = self.eroding {
            table.put("inverted", place, "delete");
        }
        let of = format!("part {id}");
        self.map(&of, format!("thick shells, elform {elform}"), format!("{THICK_SHELL}{differs}"));
        if record.integer("hgid") != 0 || sections.defaults.hourglass.is_some() {
            self.map(&of, "hourglass control", "not used: the formulation has its own");
        }
        self.section_factors(&of, card);
        self.angles_of_points(record, card, material, table);
    }

    /// Lists shear factor and rule of integration of a section that the engine has not.
    fn section_factors(&mut self, of: &str, card: &CardRecord) {
        let shear = card.real("shrf");
        if (shear - 5.0 / 6.0).abs() > 1e-3 {
            self.map(of, format!("shear factor {shear}"), "5/6");
        }
        if card.real("qr") != 0.0 {
            self.map(of, format!("qr {}: integration rule", card.real("qr")), "Gauss points");
        }
    }

    /// Returns the thickness of the shells of a rigid part whose section has none: rigid shells
    /// have no stiffness that would need one, but a mass, and a thickness in contact [length].
    fn stand_in_thickness(
        &mut self,
        id: i64,
        (record, card): (&CardRecord, &CardRecord),
        material: &DeckMaterial,
    ) -> f64 {
        let (mut area, mut count) = (0.0, 0);
        for index in 0..self.rows.shells.len() {
            let shell = self.rows.shells[index];
            if i64::from(shell.part) == id {
                area += self.size_of(&shell);
                count += 1;
            }
        }
        if count == 0 {
            return 0.0;
        }
        let thickness = STAND_IN * (area / f64::from(count)).sqrt();
        let mass = material.density * area * thickness;
        self.map(
            format!("part {id}"),
            "rigid shells without a thickness",
            format!(
                "thickness {thickness:.3e}, {STAND_IN} of their side, in contact too, and the mass \
                 {mass:.3e}"
            ),
        );
        let is_held = material.rigid.as_ref().is_some_and(|fixed| fixed.len() == 6);
        if !is_held && record.line("tm").is_none() {
            let message = format!(
                "part {id} is rigid and can move, and its shells have no thickness: it has the \
                 mass {mass:.3e} of the thickness {thickness:.3e}"
            );
            let help = "give t1 of its section, or the mass by *PART_INERTIA; without effect if \
                        its motion is prescribed or its body has other masses";
            self.trouble.warning(card.place("t1"), message, help);
        }
        thickness
    }

    /// Gives a part its own material, whose density includes the mass per area of the section.
    fn mass_of_area(
        &mut self,
        id: i64,
        card: &CardRecord,
        material: &DeckMaterial,
        thickness: f64,
        table: &mut JobTable,
    ) {
        let (mut area, mut volume) = (0.0, 0.0);
        for index in 0..self.rows.shells.len() {
            let shell = self.rows.shells[index];
            if i64::from(shell.part) == id {
                let own = shell.own.thickness;
                let of_shell = self.size_of(&shell);
                area += of_shell;
                volume += of_shell * if own > 0.0 { own } else { thickness };
            }
        }
        // Shells without nodes or thickness are reported elsewhere.
        let (marea, Some(own)) = (card.real("marea"), material.table.as_ref()) else { return };
        if !(volume > 0.0 && material.density > 0.0) {
            return;
        }
        let density = material.density + marea * area / volume;
        let name = format!("{} of part {id}", material.name);
        let place = card.place("marea");
        let mut own = own.copy().with("name", place, name.as_str()).with("density", place, density);
        // The added mass takes no heat.
        if let Some(heat) = own.float("specific_heat") {
            own.put("specific_heat", place, heat * material.density / density);
        }
        self.add("material", own);
        table.put("material", place, name.as_str());
        self.map(
            format!("part {id}"),
            format!("marea {marea}: mass per area"),
            format!("density {density:.6e} in place of {:.6e}", material.density),
        );
    }

    /// Returns the thickness of a part of shells: that of its elements, or the mean of the corners
    /// of its section [length].
    fn shell_thickness(&mut self, id: i64, card: &CardRecord, elements: PartElements<'_>) -> f64 {
        let corners = ["t1", "t2", "t3", "t4"].map(|t| card.real(t));
        let given = if corners[1..].iter().all(|&t| t == 0.0) { [corners[0]; 4] } else { corners };
        let mean = if given[1..].iter().all(|&t| t == given[0]) {
            given[0]
        } else {
            given.iter().sum::<f64>() / 4.0
        };
        if given.iter().any(|&t| t != mean) {
            self.map(
                format!("part {id}"),
                format!("thicknesses {given:?} at the corners"),
                format!("their mean {mean}"),
            );
        }
        match elements.thickness {
            Some(own) => self.own_thickness(id, own, given, mean),
            None => mean,
        }
    }

    /// Converts the offset of the middle surface, and notes parts of shells that have one.
    pub(super) fn shell_offset(
        &mut self,
        record: &CardRecord,
        card: &CardRecord,
        thickness: f64,
        table: &mut JobTable,
    ) {
        let id = record.integer("pid");
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
    }

    /// Converts the formulation of shells with its hourglass control, and lists what differs.
    pub(super) fn shell_formulation(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        sections: &Sections,
        elements: PartElements<'_>,
        table: &mut JobTable,
    ) {
        let card = &section.record;
        let of = format!("part {}", record.integer("pid"));
        let (elform, asked) = match card.integer("elform") {
            0 => {
                let theory = sections.defaults.theory;
                (theory, format!("shells, theory {theory}"))
            }
            given => (given, format!("shells, elform {given}")),
        };
        let Some(form) = sections::shell(elform) else {
            let why = match elform {
                12..=15 => {
                    "a plane or axisymmetric model; models here have three dimensions: mesh the \
                     body with solids"
                }
                _ => "no formulation of shells is similar; use 2 or 16",
            };
            self.unsupported_value(card, "elform", why);
            return;
        };
        table.put("element", card.place("elform"), form.element);
        let bt = form.element == "belytschko_tsay";
        let warping = form.warping || (matches!(elform, 2) && sections.defaults.warping.is_some());
        if bt && warping {
            table.put("warping", sections.defaults.warping.unwrap_or(card.place("elform")), true);
        }
        if form.membrane {
            table.put("membrane", card.place("elform"), true);
            table.put("points", card.place("nip"), 1);
        } else if bt {
            self.drilling(record, sections, table);
        }
        if let Some(place) = sections.defaults.thinning {
            table.put("thinning", place, true);
        }
        let mut used = Vec::new();
        if elements.shapes.quads || !elements.shapes.triangles {
            let terms = match (form.membrane, bt && warping) {
                (true, _) => " as a membrane, one point in the plane",
                (_, true) => " with warping terms",
                _ => "",
            };
            used.push(format!("{}{terms}", form.element));
        }
        if elements.shapes.triangles {
            used.push("c0_triangle".to_string());
        }
        let mut used = used.join(", ");
        if bt {
            let (form, origin) = self.hourglass(record, sections, table, false);
            used += &format!("; hourglass {form}{origin}");
        } else if record.integer("hgid") != 0 {
            self.map(&of, "hourglass control", "not used: the formulation has its own");
        }
        self.map(&of, asked, used);
        self.section_factors(&of, card);
    }

    /// Removes the drilling stiffness of a part, which these formulations do not have in decks
    /// unless `*CONTROL_SHELL` gives it.
    fn drilling(&mut self, record: &CardRecord, sections: &Sections, table: &mut JobTable) {
        match sections.defaults.drilling {
            None => table.put("drilling", record.place("secid"), 0.0),
            Some(_) => self.map(
                "*CONTROL_SHELL",
                "drcpsid: drilling stiffness of some parts",
                "drilling stiffness of all parts",
            ),
        }
    }

    /// Returns the shells of each part with individual thicknesses at the corners, by index.
    pub(super) fn thickness_of_elements(&self) -> BTreeMap<i64, Vec<(usize, [f64; 4])>> {
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
    pub(super) fn own_thickness(
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
