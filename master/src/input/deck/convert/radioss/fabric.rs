//! Converts `/MAT/LAW19` (FABRI), an elastic fabric, and the axes of its yarns, which are on
//! `/PROP/TYPE9` (SH_ORTH). In Radioss a stress along a yarn in compression has the factor R_E; in
//! a job a fabric carries compression or not.

use super::StarterConverter;
use super::properties::StarterProperty;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Largest R_E that is no compression.
const NO_COMPRESSION: f64 = 0.01;

/// YarnAxes of a material: reference vector and angle [degrees], with the place of the vector.
type YarnAxes = ([f64; 3], f64, Place);

/// Fabrics and other materials of a deck whose axes are on properties.
#[derive(Debug, Default)]
pub struct Fabrics {
    /// YarnAxes by the id of the material; `None` before a part has them.
    axes: BTreeMap<i64, Option<YarnAxes>>,
}

impl Fabrics {
    /// Notes a material whose axes are those of its parts.
    pub(super) fn expect(&mut self, material: i64) {
        self.axes.insert(material, None);
    }
}

impl StarterConverter {
    /// Returns the table of a fabric, and its Young's modulus along the first yarns.
    pub(super) fn fabric(&mut self, record: &CardRecord, name: &str) -> (JobTable, f64) {
        let [first, second, nu] = ["e11", "e22", "nu12"].map(|field| record.real(field));
        let mut table = JobTable::new(record.head)
            .with("name", record.place("title"), name)
            .with("law", record.head, "fabric")
            .with("density", record.place("rho"), record.real("rho"))
            .with("youngs_modulus", record.place("e11"), first)
            .with("youngs_modulus_b", record.place("e22"), second)
            // In a job it is the contraction along the first yarns due to tension along the others.
            .with("poisson", record.place("nu12"), nu * second / first)
            .with("shear_modulus", record.place("g12"), record.real("g12"));
        let of = format!("material {}", record.integer("id"));
        match record.real_or("re", 1.0) {
            1.0 => table.put("compression", record.place("re"), true),
            share if share <= NO_COMPRESSION => {
                let asked = format!("R_E {share}: this share of the stress in compression");
                self.deck.map(of, asked, "no stress in compression");
            }
            _ => {
                let why = "a share of the stress in compression; use 1 (all) or 0.001 (none)";
                self.deck.unsupported_value(record, "re", why);
            }
        }
        self.fabrics.expect(record.integer("id"));
        (table, first)
    }

    /// Notes the axes that a part gives to its material.
    pub(super) fn note_axes(&mut self, record: &CardRecord, of: &StarterProperty) {
        let (part, material) = (record.integer("id"), record.integer("mat"));
        let is_orthotropic = of.record.row.keyword.name == "/PROP/TYPE9";
        let Some(known) = self.fabrics.axes.get(&material).copied() else {
            if is_orthotropic {
                let _ = ["vx", "vy", "vz", "phi"].map(|field| of.record.real(field));
                let asked = format!("axes of {}", of.record.name());
                self.deck.map(format!("part {part}"), asked, "not used: the material has none");
            }
            return;
        };
        if !is_orthotropic {
            let message =
                format!("part {part}: its material {material} has axes, which its property lacks");
            let what = format!("{} of a material with axes", of.record.name());
            return self.deck.unsupported(record.place("prop"), message, what);
        }
        let place = of.record.place("vx");
        let vector = ["vx", "vy", "vz"].map(|field| of.record.real(field));
        let axes = (vector, of.record.real("phi"), place);
        match known {
            _ if vector == [0.0; 3] => {
                let message = format!("{}: there is no reference vector", of.record.name());
                let help = "give vx, vy and vz: their projection is the axis of the first yarns";
                self.deck.trouble.error(place, message, help);
            }
            Some((other, angle, _)) if (other, angle) != (axes.0, axes.1) => {
                let message = format!("part {part}: its material {material} has other axes, too");
                let what = "a material with several axes".to_string();
                self.deck.unsupported(place, message, what);
            }
            _ => drop(self.fabrics.axes.insert(material, Some(axes))),
        }
    }

    /// Adds the axes of its parts to a material.
    pub(super) fn put_axes(&mut self, material: i64, table: &mut JobTable) {
        if let Some(&Some((vector, angle, place))) = self.fabrics.axes.get(&material) {
            table.put("direction", place, vector);
            if angle != 0.0 {
                table.put("angle", place, angle);
            }
        }
    }
}
