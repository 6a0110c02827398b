//! Converts composites: parts with layers, and materials of plies (LS-DYNA Keyword User's Manual,
//! vol. I, `*PART_COMPOSITE`; vol. II, materials 2, 22, 54 and 55).

use super::DeckConverter;
use super::materials::DeckMaterial;
use super::parts::{DeckPart, PartElements};
use super::sections::{DeckSection, SectionKind, Sections};
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use std::collections::HashMap;

/// Keywords of materials of this file.
pub const KEYWORDS: [&str; 3] = ["MAT_ORTHOTROPIC_ELASTIC", "MAT_COMPOSITE_DAMAGE", ENHANCED];
/// Keyword with strains of failure.
const ENHANCED: &str = "MAT_ENHANCED_COMPOSITE_DAMAGE";

/// Strengths: field and key.
const STRENGTHS: [(&str, &str); 5] = [
    ("xt", "strength_tension_a"),
    ("xc", "strength_compression_a"),
    ("yt", "strength_tension_b"),
    ("yc", "strength_compression_b"),
    ("sc", "strength_shear"),
];

/// A layer of a part: material, thickness [length], angle [degrees].
struct DeckLayer {
    mid: i64,
    place: Place,
    thickness: f64,
    angle: f64,
}

impl DeckConverter {
    /// Converts the parameters of a ply and returns Young's modulus along its fibres
    /// [force/length^2].
    pub(super) fn ply(&mut self, keyword: &str, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "orthotropic");
        for (field, key) in [
            ("ea", "youngs_modulus"),
            ("eb", "youngs_modulus_b"),
            ("prba", "poisson"),
            ("gab", "shear_modulus"),
        ] {
            table.put(key, record.place(field), record.real(field));
        }
        for (field, key) in [("gbc", "shear_modulus_bc"), ("gca", "shear_modulus_ca")] {
            positive(record, table, field, key, 1.0);
        }
        self.shell_axes(record, if keyword == ENHANCED { "mangle" } else { "beta" }, table);
        match keyword {
            ENHANCED => self.failure(record, table),
            "MAT_COMPOSITE_DAMAGE" => brittle_failure(record, table),
            _ => {}
        }
        record.real("ea")
    }

    /// Converts strengths and strains of failure.
    fn failure(&mut self, record: &CardRecord, table: &mut JobTable) {
        for (field, key) in STRENGTHS {
            positive(record, table, field, key, 1.0);
        }
        let chang = match record.real("crit") {
            0.0 | 54.0 => true,
            55.0 => false,
            _ => {
                self.unsupported_value(record, "crit", "use 54 or 55");
                true
            }
        };
        for field in ["soft", "soft2", "softg"] {
            if !matches!(record.real(field), 0.0 | 1.0) {
                self.unsupported_value(record, field, "plies next to failed elements keep theirs");
            }
        }
        positive(record, table, "beta", "shear_weight", 1.0);
        positive(record, table, "alph", "shear_nonlinearity", 1.0);
        if !chang {
            table.put("tsai_wu", record.place("crit"), true);
        }
        let [xt, yc] = ["xt", "yc"].map(|field| record.real(field));
        positive(record, table, "fbrt", "crushed_tension_a", xt);
        positive(record, table, "ycfac", "crushed_compression_a", yc);
        let strains = ["dfailt", "dfailc", "dfailm", "dfails", "efs"];
        let count = strains.iter().filter(|field| record.real(field) != 0.0).count();
        let tension = record.real("dfailt") > 0.0;
        if count > 0 && !(chang && (tension || count == 1 && record.real("efs") != 0.0)) {
            self.map(
                format!("material {}", record.integer("mid")),
                "strains of failure with crit 55, or without dfailt",
                "not used, except efs with crit 54: the format has them for crit 54 and dfailt",
            );
        }
        if chang && tension {
            positive(record, table, "dfailt", "failure_strain_tension_a", 1.0);
            positive(record, table, "dfailc", "failure_strain_compression_a", -1.0);
            positive(record, table, "dfailm", "failure_strain_b", 1.0);
            // The format has the component of the tensor.
            positive(record, table, "dfails", "failure_strain_shear", 2.0);
        }
        if chang {
            positive(record, table, "efs", "failure_strain_effective", 1.0);
        }
        let limits = ["slimt1", "slimc1", "slimt2", "slimc2", "slims"];
        let limits = limits.map(|field| record.real(field));
        if limits != [0.0; 5] {
            table.put("residual_strengths", record.place("slimt1"), limits);
        }
    }

    /// Converts the directions of the material in a shell: along the nodes 1 and 2 (aopt 0), the
    /// vector a (2), or the vector v across the normal (3), turned by the angle in a field.
    pub(super) fn shell_axes(&mut self, record: &CardRecord, angle: &str, table: &mut JobTable) {
        let mut turn = own_turn(record, angle);
        if turn != record.real(angle) {
            self.map(
                format!("material {}", record.integer("mid")),
                format!("{angle} {} with aopt 2", record.real(angle)),
                "not used: it is for aopt 0 and 3",
            );
        }
        let vector = |names: [&str; 3]| names.map(|name| record.real(name));
        let (a, v) = (vector(["a1", "a2", "a3"]), vector(["v1", "v2", "v3"]));
        match record.real("aopt") {
            0.0 => {}
            2.0 if a != [0.0; 3] => table.put("direction", record.place("a1"), a),
            3.0 if v != [0.0; 3] => {
                // The axis a is v x n.
                table.put("direction", record.place("v1"), v);
                turn -= 90.0;
            }
            given @ (2.0 | 3.0) => {
                let name = if given == 2.0 { "a" } else { "v" };
                let message = format!("{}: aopt {given} without a vector {name}", record.name());
                let help = format!(
                    "give {name}1, {name}2, {name}3, or aopt 0 for the side of the nodes 1 and 2"
                );
                self.trouble.error(record.place("aopt"), message, help);
            }
            _ => self.unsupported_value(record, "aopt", "use aopt 0, 2 or 3"),
        }
        if turn != 0.0 {
            table.put("angle", record.place(angle), turn);
        }
    }

    /// Turns the shells of a part that have an angle of their own, which replaces that of the
    /// material.
    pub(super) fn replace_angles(&mut self, id: i64, material: &DeckMaterial) {
        for shell in self.rows.shells.iter_mut().filter(|shell| i64::from(shell.part) == id) {
            if shell.own.angle != 0.0 {
                shell.own.angle -= material.turn;
            }
        }
    }

    /// Converts `*PART_COMPOSITE`.
    pub(super) fn parts_with_layers(
        &mut self,
        materials: &HashMap<i64, DeckMaterial>,
        sections: &Sections,
        names: &mut Vec<String>,
    ) {
        let shapes = self.shapes_of_parts();
        for record in self.take_records("PART_COMPOSITE") {
            let Some((id, name)) = self.new_part(&record, names) else { continue };
            let layers = layers(&record);
            let known = |layer: &DeckLayer| materials.contains_key(&layer.mid);
            for layer in layers.iter().filter(|layer| !known(layer)) {
                if !self.part_lacks(id, ("*MAT_...", "mid"), (layer.mid, layer.place)) {
                    let known: Vec<String> = materials.keys().map(i64::to_string).collect();
                    self.missing(layer.place, "*MAT_...", layer.mid, &known);
                }
            }
            if self.is_left_out(id) {
                continue;
            }
            let thickest = layers
                .iter()
                .filter(|layer| known(layer))
                .reduce(|a, b| if b.thickness > a.thickness { b } else { a });
            let place = record.place("pid");
            let material = thickest.map(|layer| &materials[&layer.mid]);
            let part = DeckPart {
                rigid: None,
                material: material.map(|material| material.name.clone()),
                inertia: None,
                place,
            };
            self.parts.insert(id, part);
            let Some(material) = material.filter(|_| layers.iter().all(known)) else { continue };
            for layer in &layers {
                if materials[&layer.mid].rigid.is_some() || materials[&layer.mid].skin {
                    let message = format!("part {id}: a layer of a rigid or null material");
                    self.unsupported(layer.place, message, "*PART_COMPOSITE".into());
                }
                if !self.used_materials.contains(&layer.mid) {
                    self.used_materials.push(layer.mid);
                }
            }
            let of_layer = |layer: &DeckLayer| {
                JobTable::new(layer.place)
                    .with("material", layer.place, materials[&layer.mid].name.as_str())
                    .with("thickness", layer.place, layer.thickness)
                    .with("angle", layer.place, layer.angle)
                    .with("points", layer.place, 1_i64)
            };
            let tables: Vec<JobTable> = layers.iter().map(of_layer).collect();
            let mut table = JobTable::new(record.head)
                .with("id", place, id)
                .with("name", record.place("heading"), name)
                .with("material", record.head, material.name.as_str())
                .with("layer", record.head, tables);
            self.contact_card(&record, id, SectionKind::Shell, &mut table);
            if record.real("marea") != 0.0 {
                self.unsupported_value(&record, "marea", "add its mass to the density of a layer");
            }
            let thickness = layers.iter().map(|layer| layer.thickness).sum();
            let elements = PartElements {
                shapes: shapes.get(&id).copied().unwrap_or_default(),
                thickness: None,
            };
            self.replace_angles(id, material);
            let section = DeckSection { kind: SectionKind::Shell, record: record.clone() };
            self.shell_offset(&record, &record, thickness, &mut table);
            self.shell_formulation(&record, &section, sections, elements, &mut table);
            let steps = layers.iter().filter_map(|layer| materials[&layer.mid].deletion_step);
            if let Some((step, place)) = steps.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
                table.put("deletion_step", place, step);
            }
            self.add("part", table);
        }
    }

    /// Sets the angles of the points of a section, for a material that has axes.
    pub(super) fn angles_of_points(
        &mut self,
        record: &CardRecord,
        card: &CardRecord,
        material: &DeckMaterial,
        table: &mut JobTable,
    ) {
        let angles: Vec<f64> = card.lines("angle").flat_map(|line| line.reals("angle")).collect();
        if card.integer("icomp") != 1 || angles.iter().all(|&angle| angle == 0.0) {
            return;
        }
        let count = usize::try_from(card.integer("nip")).unwrap_or(0);
        let angles = angles[..count.min(angles.len())].to_vec();
        let of = format!("part {}", record.integer("pid"));
        if table.has("membrane") {
            self.map(of, format!("angles {angles:?}"), "not used: a membrane has one point");
        } else if material.has_axes {
            table.put("angles", card.place("angle"), angles);
        } else {
            self.map(of, format!("angles {angles:?}"), "not used: the material has no axes");
        }
    }
}

/// Returns the angle that a field gives a material; none with aopt 2 [degrees].
pub fn own_turn(record: &CardRecord, angle: &str) -> f64 {
    if record.real("aopt") == 2.0 { 0.0 } else { record.real(angle) }
}

/// Converts strengths of a ply that loses the stress of what has failed.
fn brittle_failure(record: &CardRecord, table: &mut JobTable) {
    for (field, key) in STRENGTHS.into_iter().filter(|(field, _)| *field != "xc") {
        positive(record, table, field, key, 1.0);
    }
    positive(record, table, "alph", "shear_nonlinearity", 1.0);
    table.put("shear_weight", record.place("xt"), 1.0);
    table.put("shear_energy", record.place("alph"), true);
    table.put("residual_strengths", record.place("xt"), [0.0; 5]);
}

/// Sets a key to a field times a factor, if the product is above zero.
fn positive(record: &CardRecord, table: &mut JobTable, field: &str, key: &str, factor: f64) {
    let value = factor * record.real(field);
    if value > 0.0 {
        table.put(key, record.place(field), value);
    }
}

fn layers(record: &CardRecord) -> Vec<DeckLayer> {
    let of = |line: &CardLine, [mid, thick, b]: [&str; 3]| DeckLayer {
        mid: line.integer(mid),
        place: line.place(mid),
        thickness: line.real(thick),
        angle: line.real(b),
    };
    let mut all = Vec::new();
    for line in record.lines("mid1") {
        all.push(of(line, ["mid1", "thick1", "b1"]));
        if line.integer("mid2") != 0 {
            all.push(of(line, ["mid2", "thick2", "b2"]));
        }
    }
    all
}
