//! Content of a part, an instance or a file without parts: nodes, elements, sets, sections.

use super::blocks::{AbaqusBlock, DataLine};
use super::elements::{cell_of, face, is_rigid};
use super::nodes;
use super::sections::SectionBlock;
use crate::input::deck::{Affine, number};
use crate::input::mesh_file::cells::{Cell, CellUse};
use crate::input::mesh_file::content::{FileNode, FilePlace};
use crate::input::mesh_file::reading::{Fate, MeshReading};
use std::collections::{BTreeMap, HashMap, HashSet};

/// An element as it is in the file.
pub struct ScopeElement {
    pub id: u64,
    pub cell: Cell,
    /// Set of its block, or its type.
    pub block: String,
    pub rigid: bool,
    pub corners: Vec<u64>,
    /// Node in the direction n1 of a beam, seen from its first node.
    pub towards: Option<u64>,
    pub place: FilePlace,
}

/// A node of an instance that an element of the assembly names, as `INSTANCE.NODE`.
pub struct ForeignNode {
    pub instance: String,
    pub node: u64,
    /// Id of the element.
    pub element: u64,
    pub place: FilePlace,
}

/// A set of nodes or elements.
#[derive(Clone, Default)]
pub struct NamedIds {
    /// Name as it is written.
    pub name: String,
    pub ids: Vec<u64>,
    /// Index of the first id of each keyword that adds ids, and its place.
    starts: Vec<(usize, FilePlace)>,
    /// True if the program that wrote the file made it for itself.
    pub internal: bool,
}

impl NamedIds {
    /// Returns the place of the keyword that gave the id with this index.
    pub fn place(&self, index: usize) -> FilePlace {
        let after = self.starts.partition_point(|start| start.0 <= index);
        after.checked_sub(1).map_or(FilePlace::default(), |last| self.starts[last].1)
    }
}

/// A part, an instance, or a file without parts.
#[derive(Default)]
pub struct MeshScope {
    /// Name; empty for a file without parts.
    pub name: String,
    pub nodes: Vec<FileNode>,
    /// Axes of the nodes that follow.
    pub axes: Affine,
    pub elements: Vec<ScopeElement>,
    /// Nodes of other scopes; elements name them by [`foreign_id`] of the index.
    pub foreign: Vec<ForeignNode>,
    /// Sets by their name in capitals.
    pub node_sets: BTreeMap<String, NamedIds>,
    /// The same for elements.
    pub element_sets: BTreeMap<String, NamedIds>,
    pub sections: Vec<SectionBlock>,
    /// Sets of elements that are rigid, and the places of their bodies.
    pub rigid: Vec<(String, FilePlace)>,
}

/// How sets are written.
pub const SET_HELP: &str = "give ids or names of sets, with commas between them; with GENERATE \
                            first, last and step";

impl MeshScope {
    /// Reads a keyword that defines a part of a mesh. Returns false for all others.
    pub fn read(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) -> bool {
        match block.keyword.as_str() {
            "NODE" => self.nodes(block, reading),
            "SYSTEM" => self.axes = nodes::axes(block, reading).unwrap_or_default(),
            "ELEMENT" => self.elements(block, reading),
            "NSET" => self.node_set(block, reading),
            "ELSET" => self.element_set(block, reading),
            "SURFACE" => self.surface(block, reading),
            "SOLID SECTION"
            | "SHELL SECTION"
            | "SHELL GENERAL SECTION"
            | "MEMBRANE SECTION"
            | "BEAM SECTION"
            | "BEAM GENERAL SECTION" => self.section(block, reading),
            "RIGID BODY" => {
                let set = rigid_set(block, reading).map(String::from);
                self.rigid.extend(set.map(|set| (set, block.place)));
            }
            _ => return false,
        }
        true
    }

    fn nodes(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let first = self.nodes.len();
        self.nodes.extend(nodes::nodes(block, &self.axes, reading));
        if let Some(name) = block.value("NSET") {
            let ids = self.nodes[first..].iter().map(|node| node.id).collect::<Vec<_>>();
            add_ids(&mut self.node_sets, name, block, ids);
        }
    }

    fn elements(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let name = block.value("TYPE").unwrap_or_default().to_uppercase();
        let Some((cell, width)) = cell_of(&name) else {
            let message = match name.is_empty() {
                true => "*ELEMENT has no TYPE".to_string(),
                false => format!("elements of type {name} are not supported"),
            };
            let help = "these are read: S3, S4, S4R, C3D4, C3D6, C3D8, C3D8R, B31, T3D2 and their \
                        variants. Use one of them, or remove the elements";
            reading.unsupported("element type", block.place, message, help);
            return;
        };
        let set = block.value("ELSET").filter(|set| !set.is_empty());
        let first = self.elements.len();
        let mut lines = block.data.iter();
        while let Some(line) = lines.next() {
            let mut fields: Vec<&str> = line.fields.iter().map(String::as_str).collect();
            let is_joint = matches!(cell, Cell::Joint(..));
            let mut open = line.open && !is_joint || width > 8;
            while fields.len() < width + 1 && open {
                let Some(next) = lines.next() else { break };
                fields.extend(next.fields.iter().map(String::as_str));
                open = next.open || width > 8;
            }
            // A connector or spring whose node is blank is held by the ground.
            fields.retain(|field| !is_joint || !field.is_empty());
            let Some((id, corners)) = self.numbers(&fields, line.place) else {
                let message = format!("`{}` is no element", line.fields.join(", "));
                let help = "write its id and its nodes, whole numbers with commas between them; \
                            in *ASSEMBLY, nodes of instances as INSTANCE.NODE";
                reading.error("element", line.place, message, help);
                continue;
            };
            let least = if is_joint { 1 } else { width };
            // A beam may have a third node for its direction.
            if corners.len() < least || corners.len() > width + usize::from(cell == Cell::Line) {
                let message =
                    format!("element {id} of type {name} has {} nodes, not {width}", corners.len());
                reading.error("width", line.place, message, "correct its nodes or its type");
                continue;
            }
            self.elements.push(ScopeElement {
                id,
                cell,
                block: set.unwrap_or(&name).to_string(),
                rigid: is_rigid(&name),
                corners: corners.iter().copied().take(width).collect(),
                towards: corners.get(width).copied(),
                place: line.place,
            });
        }
        if let Some(set) = set {
            let ids = self.elements[first..].iter().map(|e| e.id).collect::<Vec<_>>();
            add_ids(&mut self.element_sets, set, block, ids);
        }
    }

    /// Returns the id and the nodes of an element, `None` if a field is no number. A node of an
    /// instance gets an id here that stands for it.
    fn numbers(&mut self, fields: &[&str], place: FilePlace) -> Option<(u64, Vec<u64>)> {
        let (id, nodes) = fields.split_first()?;
        let element = id.parse().ok()?;
        let mut found = Vec::with_capacity(nodes.len());
        for text in nodes {
            if let Ok(node) = text.parse() {
                found.push(node);
                continue;
            }
            let (instance, node) = text.rsplit_once('.')?;
            let instance = instance.trim_matches('"').to_string();
            // `2.5` is a wrong number and no node of an instance.
            if instance.is_empty() || instance.starts_with(|c: char| c.is_ascii_digit()) {
                return None;
            }
            let node = node.parse().ok()?;
            found.push(foreign_id(self.foreign.len()));
            self.foreign.push(ForeignNode { instance, node, element, place });
        }
        Some((element, found))
    }

    fn node_set(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let mut ids = ids_of(block, &self.node_sets, reading);
        if let Some(set) = block.value("ELSET") {
            match self.element_sets.get(&set.to_uppercase()) {
                Some(found) if reading.has_room(found.ids.len(), block.place) => {
                    ids.extend(self.nodes_of(&found.ids));
                }
                Some(_) => {}
                None => {
                    let message = format!("there is no element set `{set}`");
                    reading.error("no set", block.place, message, "define it before this line");
                }
            }
        }
        if let Some(name) = set_name(block, "NSET", reading) {
            add_ids(&mut self.node_sets, name, block, ids);
        }
    }

    fn element_set(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let ids = ids_of(block, &self.element_sets, reading);
        if let Some(name) = set_name(block, "ELSET", reading) {
            add_ids(&mut self.element_sets, name, block, ids);
        }
    }

    fn surface(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let by_id = self.elements_by_id();
        let mut nodes = Vec::new();
        for line in &block.data {
            let set = field(line, 0);
            let of_nodes = is_node_surface(block);
            let sets = if of_nodes { &self.node_sets } else { &self.element_sets };
            let ids = match (set.parse::<u64>(), sets.get(&set.to_uppercase())) {
                (Ok(id), _) => vec![id],
                (_, Some(found)) => found.ids.clone(),
                _ => {
                    let message = format!("surface: there is no set `{set}`");
                    reading.error("no set", line.place, message, "define it before the surface");
                    continue;
                }
            };
            match of_nodes {
                true => nodes.extend(ids),
                false => nodes.extend(nodes_of_faces(&by_id, &ids, line, reading)),
            }
        }
        if let Some(name) = set_name(block, "NAME", reading) {
            add_ids(&mut self.node_sets, name, block, nodes);
        }
    }

    /// Returns its elements by their ids.
    pub fn elements_by_id(&self) -> HashMap<u64, &ScopeElement> {
        self.elements.iter().map(|element| (element.id, element)).collect()
    }

    /// Returns true if it has elements other than points, masses and springs.
    pub fn has_mesh(&self) -> bool {
        self.elements.iter().any(|element| element.cell.dimension() > 0)
    }

    /// Returns the ids of the elements of its rigid bodies. Reports a set that is missing.
    pub fn rigid_elements(&self, reading: &mut MeshReading) -> HashSet<u64> {
        let mut found = HashSet::new();
        for (name, place) in &self.rigid {
            match self.element_sets.get(&name.to_uppercase()) {
                Some(set) => found.extend(&set.ids),
                None => {
                    let message = format!("*RIGID BODY: there is no element set `{name}`");
                    reading.error("no set", *place, message, "correct ELSET=, or define the set");
                }
            }
        }
        found
    }

    fn section(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let Some(elements) = set_name(block, "ELSET", reading) else { return };
        self.sections.push(SectionBlock::read(block, elements, reading));
    }

    /// Returns the nodes of elements.
    pub fn nodes_of(&self, elements: &[u64]) -> Vec<u64> {
        let wanted: HashSet<&u64> = elements.iter().collect();
        let own = self.elements.iter().filter(|e| wanted.contains(&e.id));
        own.flat_map(|e| e.corners.iter().copied()).collect()
    }
}

/// Returns true if the lines of a surface name nodes.
pub fn is_node_surface(block: &AbaqusBlock) -> bool {
    block.value("TYPE").is_some_and(|kind| kind.eq_ignore_ascii_case("NODE"))
}

/// Returns the nodes of the faces of elements that a line of a surface names.
pub fn nodes_of_faces(
    elements: &HashMap<u64, &ScopeElement>,
    ids: &[u64],
    line: &DataLine,
    reading: &mut MeshReading,
) -> Vec<u64> {
    let side = field(line, 1);
    let mut nodes = Vec::new();
    let used = |e: &&&ScopeElement| matches!(e.cell.usage(), CellUse::Element(_));
    for element in ids.iter().filter_map(|id| elements.get(id)).filter(used) {
        match face(element.cell, side) {
            Some(corners) => nodes.extend(corners.iter().map(|&c| element.corners[c])),
            // Without a side: all faces that no other element has.
            None if side.is_empty() => nodes.extend(&element.corners),
            None => {
                let message = format!("element {} has no face {side}", element.id);
                let help = "solids have S1 to S6, shells SPOS, SNEG and E1 to E4";
                reading.error("face", line.place, message, help);
            }
        }
    }
    nodes
}

/// Returns the element set of a rigid body, and adds rows for the body.
pub fn rigid_set<'b>(block: &'b AbaqusBlock, reading: &mut MeshReading) -> Option<&'b str> {
    let advice = "nodes of a rigid body: [[rigid]] with nodes";
    for parameter in ["TIE NSET", "PIN NSET"] {
        if block.has(parameter) {
            reading.row(Fate::LeftOut, format!("*RIGID BODY, {parameter}"), 1, advice);
        }
    }
    if block.has("OFFSET") {
        reading.row(Fate::LeftOut, "*RIGID BODY, OFFSET", 1, "part.offset");
    }
    let set = block.value("ELSET").filter(|set| !set.is_empty());
    match set {
        Some(_) => {
            let became = "[[rigid]] with the parts of its elements; give it a mass or a motion";
            reading.row(Fate::Read, "*RIGID BODY", 1, became);
        }
        None => reading.row(Fate::LeftOut, "*RIGID BODY without ELSET", 1, advice),
    }
    set
}

/// Returns a field of a line; empty if it is missing.
pub fn field(line: &DataLine, index: usize) -> &str {
    line.fields.get(index).map_or("", String::as_str)
}

/// Returns a whole number from 0; `None` if the field is none.
pub fn id_of(line: &DataLine, index: usize) -> Option<u64> {
    number::integer(field(line, index).as_bytes()).and_then(|id| u64::try_from(id).ok())
}

/// Returns a number, `None` if the field is empty.
///
/// # Errors
/// The field is no number: its text.
pub fn number_of(line: &DataLine, index: usize) -> Result<Option<f64>, &str> {
    match field(line, index) {
        "" => Ok(None),
        text => number::real(text.as_bytes()).map(Some).ok_or(text),
    }
}

/// Returns the name of a set that a parameter gives. Reports an error if it is missing.
pub fn set_name<'b>(
    block: &'b AbaqusBlock,
    parameter: &str,
    reading: &mut MeshReading,
) -> Option<&'b str> {
    let name = block.value(parameter).filter(|name| !name.is_empty());
    if name.is_none() {
        let message = format!("*{} has no parameter {parameter}", block.keyword);
        reading.error("parameter", block.place, message, format!("write {parameter}=NAME"));
    }
    name
}

/// Returns the id that stands for a node of another scope: no file has ids that large.
pub fn foreign_id(index: usize) -> u64 {
    u64::MAX - index as u64
}

/// Adds the ids of a keyword to a set.
fn add_ids(
    sets: &mut BTreeMap<String, NamedIds>,
    name: &str,
    block: &AbaqusBlock,
    ids: impl IntoIterator<Item = u64>,
) {
    // Names of surfaces and of blocks of nodes or elements are always those of the user.
    let internal = block.keyword.ends_with("SET") && block.has("INTERNAL");
    let new = || NamedIds { name: name.into(), internal, ..NamedIds::default() };
    let set = sets.entry(name.to_uppercase()).or_insert_with(new);
    set.starts.push((set.ids.len(), block.place));
    set.ids.extend(ids);
}

/// Returns the ids of the lines of a set: numbers, names of sets, or ranges; each id once.
pub fn ids_of(
    block: &AbaqusBlock,
    known: &BTreeMap<String, NamedIds>,
    reading: &mut MeshReading,
) -> Vec<u64> {
    let mut ids = Vec::new();
    for line in &block.data {
        if block.has("GENERATE") {
            let step = if field(line, 2).is_empty() { Some(1) } else { id_of(line, 2) };
            match (id_of(line, 0), id_of(line, 1), step) {
                (Some(first), Some(last), Some(step)) if step > 0 && first <= last => {
                    let count = ((last - first) / step).saturating_add(1);
                    if reading.has_room(usize::try_from(count).unwrap_or(usize::MAX), line.place) {
                        ids.extend((first..=last).step_by(step as usize));
                    }
                }
                _ => {
                    let message = format!("`{}` is no range", line.fields.join(", "));
                    reading.error("range", line.place, message, SET_HELP);
                }
            }
            continue;
        }
        for text in line.fields.iter().filter(|text| !text.is_empty()) {
            match (text.parse::<u64>(), known.get(&text.to_uppercase())) {
                (Ok(id), _) => ids.push(id),
                (_, Some(set)) if reading.has_room(set.ids.len(), line.place) => {
                    ids.extend(&set.ids);
                }
                (_, Some(_)) => {}
                _ => {
                    let message = format!("`{text}` is no id and no set that was defined before");
                    reading.error("no set", line.place, message, SET_HELP);
                }
            }
        }
    }
    ids.sort_unstable();
    ids.dedup();
    ids
}
