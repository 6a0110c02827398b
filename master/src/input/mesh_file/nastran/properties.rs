//! Properties and materials of Nastran.

use super::BulkReader;
use super::cards::{BulkCard, FieldFault};
use crate::input::mesh_file::content::{FileMaterial, FilePlace};
use crate::input::mesh_file::reading::Fate;
use crumple_proto::job::{BeamInput, BeamSection};
use std::collections::HashSet;

/// A material and the place of its card.
pub struct BulkMaterial {
    values: FileMaterial,
    place: FilePlace,
}

/// Plastic strain up to which a constant hardening modulus is written.
const LAST_STRAIN: f64 = 1.0;

/// Returns true for cards of properties that elements name.
pub fn is_property(name: &str) -> bool {
    const KNOWN: &[&str] = &[
        "PSHELL", "PSOLID", "PCOMP", "PCOMPG", "PROD", "PTUBE", "PBAR", "PBARL", "PBEAM", "PBEAML",
    ];
    KNOWN.contains(&name)
}

/// Returns true for a composite.
fn is_composite(card: &BulkCard) -> bool {
    card.name.starts_with("PCOMP")
}

/// Returns true if only composites that no element has name a material. Fields with its id that are
/// no material count too: the material is then reported, as all others are.
fn is_of_unused_composites(material: &BulkCard, cards: &[BulkCard], used: &HashSet<u64>) -> bool {
    let id = material.text(0);
    let names = |card: &&BulkCard| card.fields.iter().skip(1).any(|field| field == id);
    let is_unused =
        |card: &BulkCard| card.id(0).ok().flatten().is_some_and(|id| !used.contains(&id));
    let mut of = cards
        .iter()
        .filter(|card| is_property(&card.name) || card.name == "CONROD")
        .filter(names)
        .peekable();
    of.peek().is_some() && of.all(|card| is_composite(card) && is_unused(card))
}

/// Returns true for cards of materials.
pub fn is_material(name: &str) -> bool {
    name.starts_with("MAT") || name == "TABLES1"
}

/// Returns the section of a truss with this area [length^2].
pub fn truss(area: f64) -> BeamInput {
    BeamInput { area, ..BeamInput::of(BeamSection::General) }
}

impl BulkReader<'_> {
    /// Reads a property as a part.
    pub fn property(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let Some(id) = card.id(0)?.and_then(|id| u32::try_from(id).ok()) else {
            let help = "write the id in field 2; it is at most 4294967295";
            self.error("id", card, "the property has no id".into(), help);
            return Ok(());
        };
        if is_composite(card) && !self.used.contains(&u64::from(id)) {
            self.reading.row(Fate::Ignored, card.name.as_str(), 1, "no element has this composite");
            return Ok(());
        }
        let part = self.part(id);
        let material = card.id(1)?.filter(|_| !is_composite(card));
        if let Some(material) = material {
            if !self.materials.contains_key(&material) {
                let message = format!("property {id}: there is no material {material}");
                let help = "add its MAT1, or correct field 3";
                self.error("material", card, message, help);
            }
            self.reading.mesh.parts[part].material = Some(self.material_name(material));
        }
        match card.name.as_str() {
            "PSHELL" => {
                let thickness = card.real(2)?.filter(|&t| t > 0.0);
                if thickness.is_none() {
                    let message = format!("property {id} has no thickness above 0");
                    self.error("thickness", card, message, "write it in field 4");
                }
                self.reading.mesh.parts[part].thickness = thickness;
                // OptiStruct has ZOFFS here; a whole number of another program is none.
                if card.text(12).contains('.') {
                    let offset = card.real(12)?;
                    self.offsets.of_properties.extend(offset.map(|offset| (id, offset)));
                }
            }
            "PCOMP" | "PCOMPG" => {
                let message = format!("property {id} is a composite");
                let help = "use a PSHELL with one material";
                self.reading.unsupported("composite", card.place, message, help);
            }
            "PSOLID" => {}
            _ => {
                let beam = section(card)?;
                if beam.is_none() {
                    let message = format!("the section of {} {id} is not read", card.name);
                    let help = "areas and moments, and the types ROD, TUBE, BAR and symmetric I \
                                are read; part.beam is a placeholder in the job";
                    self.reading.warning(card.place, message, help);
                }
                self.reading.mesh.parts[part].beam = beam;
            }
        }
        Ok(())
    }

    /// Reads all materials.
    pub fn materials(&mut self, cards: &[BulkCard]) {
        for card in cards.iter().filter(|card| card.name.starts_with("MAT")) {
            match card.name.as_str() {
                "MAT1" => self.reported(card, Self::elastic),
                "MATS1" => {}
                name if is_of_unused_composites(card, cards, &self.used) => {
                    let became = "no element has a composite with it";
                    self.reading.row(Fate::Ignored, name, 1, became);
                }
                name => {
                    let message = format!("material {name} {} is not supported", card.text(0));
                    let help = "use an isotropic material, MAT1";
                    self.reading.unsupported("law", card.place, message, help);
                }
            }
        }
        for card in cards.iter().filter(|card| card.name == "MATS1") {
            self.reported(card, |reader, card| reader.plastic(card, cards));
        }
    }

    fn elastic(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let Some(id) = card.id(0)? else {
            self.error("id", card, "the material has no id".into(), "write the id in field 2");
            return Ok(());
        };
        let (mut e, g, mut nu) = (card.real(1)?, card.real(2)?, card.real(3)?);
        if let (Some(e), Some(g), None) = (e, g.filter(|&g| g > 0.0), nu) {
            nu = Some(e / (2.0 * g) - 1.0);
        }
        if let (None, Some(g)) = (e, g) {
            e = Some(2.0 * g * (1.0 + nu.unwrap_or(0.0)));
        }
        let density = card.real(4)?.filter(|&density| density > 0.0);
        if !e.is_some_and(|e| e > 0.0) || !(-1.0..0.5).contains(&nu.unwrap_or(0.0)) {
            let message = format!("material {id} has E = {} and nu = {}", shown(e), shown(nu));
            let help = "E has to be above 0, and nu at least -1 and below 0.5";
            self.error("material", card, message, help);
            return Ok(());
        }
        let values = FileMaterial {
            name: self.material_name(id),
            density,
            youngs_modulus: e,
            poisson: nu.or(Some(0.0)),
            ..FileMaterial::default()
        };
        let place = card.place;
        if let Some(before) = self.materials.insert(id, BulkMaterial { values, place }) {
            let before = self.reading.at(before.place);
            let message = format!("material {id} is defined twice, first at {before}");
            self.error("material twice", card, message, "give each material its own id");
        }
        Ok(())
    }

    /// Reads the yield curve of a material: bilinear, or a table over the total strain.
    fn plastic(&mut self, card: &BulkCard, cards: &[BulkCard]) -> Result<(), FieldFault> {
        let id = card.id(0)?.unwrap_or(0);
        let Some(modulus) = self.materials.get(&id).and_then(|m| m.values.youngs_modulus) else {
            let help = "a MATS1 belongs to the MAT1 with the same id";
            self.error("material", card, format!("there is no MAT1 {id}"), help);
            return Ok(());
        };
        if !card.text(2).eq_ignore_ascii_case("PLASTIC") {
            let message = format!("the type {} of MATS1 {id} is not supported", card.text(2));
            self.reading.unsupported("law", card.place, message, "use the type PLASTIC");
            return Ok(());
        }
        let mut rows = Vec::new();
        if let Some(table) = card.id(1)?.filter(|&table| table > 0) {
            let found =
                cards.iter().find(|c| c.name == "TABLES1" && c.text(0) == table.to_string());
            let Some(found) = found else {
                let message = format!("there is no TABLES1 {table}");
                self.error("material", card, message, "add the table, or correct field 3");
                return Ok(());
            };
            rows = table_rows(found, modulus)?;
        } else {
            let (slope, stress) = (card.real(3)?.unwrap_or(0.0), card.real(6)?.unwrap_or(0.0));
            rows.push([0.0, stress]);
            if slope > 0.0 {
                rows.push([LAST_STRAIN, stress + LAST_STRAIN * slope]);
            }
        }
        let grows = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        if rows.is_empty() || !grows || rows.iter().any(|row| row[1] <= 0.0) {
            let message = format!("MATS1 {id} has the plastic strains and yield stresses {rows:?}");
            let help = "yield stresses have to be above 0, and plastic strains have to grow";
            self.error("material", card, message, help);
        } else if let Some(material) = self.materials.get_mut(&id) {
            material.values.hardening = rows;
        }
        Ok(())
    }

    /// Adds the materials that properties name.
    pub fn add_materials(&mut self) {
        let used: Vec<String> =
            self.reading.mesh.parts.iter().filter_map(|part| part.material.clone()).collect();
        let materials = std::mem::take(&mut self.materials).into_values().map(|m| m.values);
        self.reading.mesh.materials.extend(materials.filter(|m| used.contains(&m.name)));
    }
}

/// Returns plastic strain and yield stress of a table of stress over total strain. Its first point
/// is the origin, the second the yield point.
fn table_rows(table: &BulkCard, modulus: f64) -> Result<Vec<[f64; 2]>, FieldFault> {
    let mut rows = Vec::new();
    for index in (8..table.fields.len()).step_by(2) {
        if table.text(index).eq_ignore_ascii_case("ENDT") {
            break;
        }
        let (Some(strain), Some(stress)) = (table.real(index)?, table.real(index + 1)?) else {
            continue;
        };
        if strain > 0.0 {
            let plastic = strain - stress / modulus;
            // The yield point has no plastic strain, except for digits that the table lacks.
            rows.push([if rows.is_empty() { 0.0 } else { plastic }, stress]);
        }
    }
    Ok(rows)
}

fn shown(number: Option<f64>) -> String {
    number.map_or("nothing".into(), |number| number.to_string())
}

/// Returns the section of a property of bars; `None` if it is not read.
fn section(card: &BulkCard) -> Result<Option<BeamInput>, FieldFault> {
    let at = |index: usize| Ok(card.real(index)?.unwrap_or(0.0));
    let beam = match card.name.as_str() {
        "PROD" => truss(at(2)?),
        "PTUBE" => {
            BeamInput { radius: 0.5 * at(2)?, wall: at(3)?, ..BeamInput::of(BeamSection::Tube) }
        }
        // I1 is for bending about the third axis. PBEAM has the same order at its first end.
        "PBAR" | "PBEAM" => BeamInput {
            area: at(2)?,
            second_moments: [at(4)?, at(3)?],
            torsion: at(if card.name == "PBAR" { 5 } else { 6 })?,
            ..BeamInput::of(BeamSection::General)
        },
        _ => {
            let [a, b, c, d, e, f] = [at(8)?, at(9)?, at(10)?, at(11)?, at(12)?, at(13)?];
            match card.text(3).to_uppercase().as_str() {
                "ROD" => BeamInput { radius: a, ..BeamInput::of(BeamSection::Tube) },
                "TUBE" => BeamInput { radius: a, wall: a - b, ..BeamInput::of(BeamSection::Tube) },
                "BAR" => BeamInput { height: b, width: a, ..BeamInput::of(BeamSection::Rectangle) },
                "I" if b == c && e == f => BeamInput {
                    height: a,
                    width: b,
                    web: d,
                    flange: e,
                    ..BeamInput::of(BeamSection::I)
                },
                _ => return Ok(None),
            }
        }
    };
    let has_size = [beam.area, beam.radius, beam.height].iter().any(|&size| size > 0.0);
    Ok(has_size.then_some(beam))
}
