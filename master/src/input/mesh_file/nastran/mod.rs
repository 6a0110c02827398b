//! Nastran bulk data: nodes, elements, properties, elastic and plastic materials (MSC Nastran Quick
//! Reference Guide).
//!
//! A property is a part with its id. Constrained nodes of `SPC` and `SPC1` are node sets `spc_ID`,
//! and so are sets, as `set_ID` or with their names.

mod cards;
mod nodes;
mod offsets;
mod properties;
mod sets;

use super::boundary;
use super::cells::{Cell, CellUse};
use super::content::FilePlace;
use super::reading::{Fate, MeshReading};
use cards::{BulkCard, BulkText, FieldFault, NamedId, NamedKind};
use crumple_proto::mesh::Shape;
use nodes::SystemTable;
use offsets::BulkOffsets;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Returns true if a line begins bulk data or is a card of nodes or elements.
pub fn recognises(head: &[u8], _: usize) -> bool {
    super::has_line(head, |line| {
        let upper = line.to_uppercase();
        let word = upper.split([',', ' ', '\t']).next().unwrap_or_default().trim_end_matches('*');
        upper.starts_with("BEGIN BULK")
            || word == "GRID" && upper.len() > 4
            || word == "SOL"
            || ELEMENTS.iter().any(|row| row.0 == word)
                && upper.contains(|c: char| c.is_ascii_digit())
    })
}

/// Elements: card, numbers of nodes and their cells; the property is the second field.
const ELEMENTS: &[(&str, &[(usize, Cell)])] = &[
    ("CQUAD4", &[(4, Cell::Quad)]),
    ("CQUADR", &[(4, Cell::Quad)]),
    ("CTRIA3", &[(3, Cell::Triangle)]),
    ("CTRIAR", &[(3, Cell::Triangle)]),
    ("CHEXA", &[(8, Cell::Hexahedron), (20, Cell::SecondOrder("hexahedron with 20 nodes", 3))]),
    ("CPENTA", &[(6, Cell::Wedge), (15, Cell::SecondOrder("wedge with 15 nodes", 3))]),
    ("CTETRA", &[(4, Cell::Tetrahedron), (10, Cell::Tetrahedron10)]),
    ("CPYRAM", &[(5, Cell::Pyramid), (13, Cell::SecondOrder("pyramid with 13 nodes", 3))]),
    ("CPYRA", &[(5, Cell::Pyramid), (13, Cell::SecondOrder("pyramid with 13 nodes", 3))]),
    ("CQUAD8", &[(8, Cell::SecondOrder("quad with 8 nodes", 2))]),
    ("CTRIA6", &[(6, Cell::SecondOrder("triangle with 6 nodes", 2))]),
    ("CROD", &[(2, Cell::Line)]),
    ("CTUBE", &[(2, Cell::Line)]),
    ("CBAR", &[(2, Cell::Line)]),
    ("CBEAM", &[(2, Cell::Line)]),
    ("CSHEAR", &[(4, Cell::Other("shear panel", 2))]),
];

/// Fields of elements that are not read: cards, indices of the fields, their meaning, the cure.
const NOT_READ: &[(&[&str], &[usize], &str, &str)] = &[
    (&["CQUAD4", "CQUADR", "CTRIA3", "CTRIAR"], &[10, 11, 12, 13], CORNERS, CORNERS_CURE),
    (&["CBAR", "CBEAM"], &[8, 9], "pin flags (PA, PB)", "write 0, or use another connection"),
    (
        &["CBAR", "CBEAM"],
        &[10, 11, 12, 13, 14, 15],
        "offsets of its ends (W1A to W3B)",
        "move its nodes and leave the fields blank",
    ),
];
const CORNERS: &str = "thicknesses of its corners (T1 to T4)";
const CORNERS_CURE: &str = "leave the fields blank and give the thickness by PSHELL";

/// Cards that are ignored: name, and what to write in the job.
const IGNORED: &[(&str, &str)] = &[
    ("CONM2", "point masses: [[mass]]"),
    ("CONM1", "point masses: [[mass]]"),
    ("CELAS1", "springs: mesh.springs of a job with its own mesh"),
    ("CELAS2", "springs: mesh.springs of a job with its own mesh"),
    ("CBUSH", "springs: mesh.springs of a job with its own mesh"),
    ("CDAMP1", "dampers: mesh.springs of a job with its own mesh"),
    ("RBE2", "rigid connections: [[rigid]] with nodes"),
    ("RBE3", "distributed connections: [[tie]]"),
    ("RBAR", "rigid connections: [[rigid]] with nodes"),
    ("MPC", "constraints: [[tie]]"),
    ("FORCE", "forces: [[load]]"),
    ("MOMENT", "moments: [[load]]"),
    ("PLOAD", "pressure: [[pressure]]"),
    ("PLOAD2", "pressure: [[pressure]]"),
    ("PLOAD4", "pressure: [[pressure]]"),
    ("GRAV", "gravity: [[gravity]]"),
    ("TEMP", "temperatures"),
    ("TABLED1", "curves: [[curve]]"),
    ("TIC", "initial velocities: [[initial_velocity]]"),
    ("BCTABLE", "contact: [contact]"),
    ("BSURFS", "contact: [contact]"),
    ("PARAM", "options of the solver"),
    ("EIGRL", "options of the solver"),
];

/// Bulk data while it is read.
pub struct BulkReader<'a> {
    reading: &'a mut MeshReading,
    /// Names of properties, from comments.
    names: HashMap<u64, String>,
    /// Properties of elements.
    used: HashSet<u64>,
    /// Materials by id.
    materials: BTreeMap<u64, properties::BulkMaterial>,
    /// Coordinates of the nodes in the basic system [length].
    at: HashMap<u64, [f64; 3]>,
    systems: SystemTable,
    offsets: BulkOffsets,
}

/// Reads a file.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let BulkText { cards, control, names, .. } = cards::cards(reading, bytes);
    let (properties, sets): (Vec<_>, Vec<_>) = names
        .into_iter()
        .partition(|named| matches!(named.of, NamedKind::Property | NamedKind::Component));
    let is_element = |card: &&BulkCard| ELEMENTS.iter().any(|row| row.0 == card.name);
    // A field that cannot be read is reported with its element.
    let property = |card: &BulkCard| card.id(1).and_then(|id| Ok(id.or(card.id(0)?))).ok()?;
    let mut reader = BulkReader {
        reading,
        names: names_of_properties(properties),
        used: cards.iter().filter(is_element).filter_map(property).collect(),
        materials: BTreeMap::new(),
        at: HashMap::new(),
        systems: SystemTable::default(),
        offsets: BulkOffsets::default(),
    };
    // Beams need the coordinates of their nodes, and properties those of their materials.
    reader.nodes(&cards);
    reader.materials(&cards);
    for card in cards.iter().filter(|card| !nodes::places_nodes(&card.name)) {
        reader.card(card);
    }
    reader.rows_of_systems(&cards);
    // Sets name nodes and elements of the whole file.
    sets::read(&mut reader, &cards, &control, &sets);
    reader.add_materials();
    let offsets = reader.offsets;
    boundary::drop_bounding(reading);
    // A property with an error has no thickness.
    if !reading.has_errors() {
        offsets.assign(reading);
    }
    warn_of_mixed_parts(reading);
}

/// Returns the names of properties by id: their own, or that of the only component with this
/// property.
fn names_of_properties(named: Vec<NamedId>) -> HashMap<u64, String> {
    let (own, components): (Vec<_>, Vec<_>) =
        named.into_iter().partition(|named| named.of == NamedKind::Property);
    let mut names: HashMap<u64, String> = HashMap::new();
    let mut shared = HashSet::new();
    for component in components {
        if names.insert(component.id, component.name).is_some() {
            shared.insert(component.id);
        }
    }
    names.retain(|id, _| !shared.contains(id));
    names.extend(own.into_iter().map(|property| (property.id, property.name)));
    names
}

/// Warns of each part whose elements are of several kinds: of the cards of properties with its id,
/// the last one counts.
fn warn_of_mixed_parts(reading: &mut MeshReading) {
    let kind = |shape: Shape| match shape {
        _ if shape.is_solid() => "solids",
        _ if shape.is_shell() => "shells",
        _ => "bars",
    };
    let mut first: BTreeMap<usize, BTreeMap<&str, FilePlace>> = BTreeMap::new();
    for element in &reading.mesh.elements {
        let kinds = first.entry(element.part).or_default();
        kinds.entry(kind(element.shape)).or_insert(element.place);
    }
    for (part, kinds) in first.into_iter().filter(|(_, kinds)| kinds.len() > 1) {
        let names: Vec<&str> = kinds.keys().copied().collect();
        let place = kinds.values().copied().max().unwrap_or_default();
        let message = format!(
            "property {} has {}; they are one part, with one material",
            reading.mesh.parts[part].id,
            names.join(" and ")
        );
        let help = "give each kind a property with an id of its own";
        reading.warning(place, message, help);
    }
}

impl BulkReader<'_> {
    /// Reads a card and reports a field that cannot be read.
    fn reported(
        &mut self,
        card: &BulkCard,
        read: impl FnOnce(&mut Self, &BulkCard) -> Result<(), FieldFault>,
    ) {
        if let Err(fault) = read(self, card) {
            let message = format!("{}: field {} is `{}`", card.name, fault.number, fault.text);
            let help = "fields have 8 columns, 16 after a name with `*`, or commas between them; \
                        ids are whole numbers and coordinates real numbers";
            self.reading.error("field", card.place, message, help);
        }
    }

    fn error(&mut self, kind: &'static str, card: &BulkCard, message: String, help: &str) {
        self.reading.error(kind, card.place, format!("{}: {message}", card.name), help);
    }

    fn card(&mut self, card: &BulkCard) {
        let name = card.name.as_str();
        if let Some((_, cells)) = ELEMENTS.iter().find(|row| row.0 == name) {
            self.reported(card, |reader, card| reader.element(card, cells));
            return;
        }
        match name {
            "CONROD" => self.reported(card, Self::conrod),
            "SPC" | "SPC1" => self.reported(card, Self::constrained),
            name if properties::is_property(name) => self.reported(card, Self::property),
            name if properties::is_material(name) || sets::is_set(name) => {}
            _ => {
                let advice = IGNORED.iter().find(|row| row.0 == name).map(|row| row.1);
                let advice = advice.unwrap_or("not needed for the mesh, or not supported");
                self.reading.row(Fate::Ignored, name, 1, advice);
            }
        }
    }

    fn element(&mut self, card: &BulkCard, cells: &[(usize, Cell)]) -> Result<(), FieldFault> {
        let Some(id) = card.id(0)? else {
            self.error("id", card, "the element has no id".into(), "write its id in field 2");
            return Ok(());
        };
        let property = card.id(1)?.unwrap_or(id);
        let most = cells.iter().map(|c| c.0).max().unwrap_or(0);
        let mut corners = Vec::new();
        for index in 0..most {
            corners.extend(card.id(2 + index)?.filter(|&node| node > 0));
        }
        let Some(&(width, cell)) = cells.iter().find(|(width, _)| corners.len() <= *width) else {
            return Ok(());
        };
        // Elements of second order may lack nodes on their sides.
        let is_read = matches!(cell.usage(), CellUse::Element(_));
        let least = if cells.len() > 1 && width == most && !is_read { cells[0].0 } else { width };
        if is_read && corners.len() < least && corners.len() > cells[0].0 {
            let message = format!("element {id} lacks nodes on its edges");
            let help = "write all nodes of the element, or its corners alone";
            self.error("edges", card, message, help);
            return Ok(());
        }
        if corners.len() < least {
            let message = format!("element {id} has {} nodes, not {width}", corners.len());
            self.error("width", card, message, "correct its nodes; a line may be missing");
            return Ok(());
        }
        let Ok(part) = u32::try_from(property) else {
            let message = format!("element {id} has property {property}");
            self.error("property", card, message, "ids of properties are at most 4294967295");
            return Ok(());
        };
        self.unsupported_fields(card)?;
        let offset = match card.name.as_str() {
            "CQUAD4" | "CQUADR" => card.real(7)?,
            "CTRIA3" | "CTRIAR" => card.real(6)?,
            _ => None,
        };
        self.offsets.of_elements.extend(offset.map(|offset| (id, offset)));
        let part = self.part(part);
        let before = self.reading.mesh.elements.len();
        self.reading.add_element((id, part), cell, &corners, card.place);
        if ["CBAR", "CBEAM"].contains(&card.name.as_str()) {
            let axis = self.direction(card, corners[0])?;
            if let Some(element) = self.reading.mesh.elements.get_mut(before) {
                element.axis = axis;
            }
        }
        Ok(())
    }

    /// Reports fields of an element that change its stiffness and are not read.
    fn unsupported_fields(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        for &(names, fields, property, cure) in NOT_READ {
            if !names.contains(&card.name.as_str()) {
                continue;
            }
            for &field in fields {
                if card.real(field)?.is_some_and(|value| value != 0.0) {
                    self.reading.lacks(property, card.place, cure);
                    break;
                }
            }
        }
        Ok(())
    }

    /// Returns the direction of the second axis of a bar: a vector, or towards a node. The vector
    /// has the components of the displacements of the first node, unless the first letter of OFFT
    /// is `B`, for those in the basic system.
    fn direction(&mut self, card: &BulkCard, first: u64) -> Result<Option<[f64; 3]>, FieldFault> {
        let is_node =
            !card.text(4).is_empty() && card.text(5).is_empty() && card.text(6).is_empty();
        if is_node && !card.text(4).contains('.') {
            let towards = card.id(4)?.and_then(|node| self.at.get(&node));
            let from = self.at.get(&first);
            return Ok(from.zip(towards).map(|(a, b)| std::array::from_fn(|c| b[c] - a[c])));
        }
        let mut axis = [0.0; 3];
        for (c, value) in axis.iter_mut().enumerate() {
            *value = card.real(4 + c)?.unwrap_or(0.0);
        }
        if axis.iter().all(|&c| c == 0.0) {
            return Ok(None);
        }
        let is_basic = card.text(7).to_uppercase().starts_with('B');
        Ok(Some(if is_basic { axis } else { self.in_basic_system(card, first, axis) }))
    }

    /// Reads a rod with its own area and material.
    fn conrod(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let (Some(id), Some(a), Some(b)) = (card.id(0)?, card.id(1)?, card.id(2)?) else {
            self.error("width", card, "id or nodes are missing".into(), "write id, n1, n2, ...");
            return Ok(());
        };
        let name = format!("rods_{}_{}", card.text(3), card.text(4));
        let known = self.reading.mesh.parts.iter().position(|part| part.name == name);
        let part = known.unwrap_or_else(|| {
            // Properties have their ids already, or get them later.
            let free = u32::MAX - self.reading.mesh.parts.len() as u32;
            self.reading.mesh.part_with_id(free, &name)
        });
        self.reading.mesh.parts[part].beam = card.real(4)?.map(properties::truss);
        self.reading.mesh.parts[part].material = card.id(3)?.map(|id| self.material_name(id));
        self.reading.add_element((id, part), Cell::Line, &[a, b], card.place);
        Ok(())
    }

    /// Reads the nodes of a support as a node set.
    fn constrained(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let Some(id) = card.id(0)? else { return Ok(()) };
        let mut nodes = Vec::new();
        if card.name == "SPC" {
            for index in [1, 4] {
                nodes.extend(card.id(index)?);
            }
        } else if card.text(3).eq_ignore_ascii_case("THRU") {
            let range = (card.id(2)?.unwrap_or(1), card.id(4)?.unwrap_or(0));
            let at = &self.at;
            nodes.extend(at.keys().copied().filter(|node| (range.0..=range.1).contains(node)));
        } else {
            for index in 2..card.fields.len() {
                nodes.extend(card.id(index)?);
            }
        }
        let name = format!("spc_{id}");
        let mut advice = String::from("the nodes are a node set; write a [[fix]] for it");
        let displaced = self.systems.count_displaced(&nodes);
        if displaced > 0 {
            advice += &format!(
                ", whose dofs are along the axes of the mesh; {displaced} of the nodes have others \
                 (CD)"
            );
        }
        self.reading.row(Fate::Ignored, format!("{} {id}", card.name), nodes.len(), advice);
        self.reading.mesh.add_set(&name, &name, nodes);
        Ok(())
    }

    /// Returns the index of the part of a property.
    fn part(&mut self, id: u32) -> usize {
        let name = self.names.get(&u64::from(id)).cloned().unwrap_or_default();
        self.reading.mesh.part_with_id(id, &name)
    }

    /// Returns the name of a material in the job.
    fn material_name(&self, id: u64) -> String {
        format!("mat_{id}")
    }
}
