//! Gmsh MSH files of the versions 4.1 and 2.2, as text or binary (Gmsh reference manual, chapter
//! "File formats").
//!
//! A physical group becomes a node set with its name. It is also a part, unless all its elements
//! bound others, as the faces of solids and the edges of shells do. In a file without physical
//! groups each entity of the highest dimension is a part.

mod groups;
mod stream;
mod v2;
mod v4;

use super::cells::Cell;
use super::content::{FileNode, FilePlace};
use super::reading::{Fate, MeshReading};
use super::shortened;
use crumple_proto::mesh::Shape;
use std::collections::BTreeMap;
use stream::{MshForm, MshStream, RowFault};

/// Returns true if a file is an MSH file. Version 1 begins with `$NOD`.
pub fn recognises(head: &[u8], _: usize) -> bool {
    super::has_line(head, |line| matches!(line.trim(), "$MeshFormat" | "$NOD"))
}

/// Dimension and tag of an entity or a physical group.
pub type DimensionTag = (usize, i64);

/// An element as it is in the file.
pub struct MshElement {
    id: u64,
    cell: Cell,
    /// Tag of its entity.
    entity: i64,
    /// Tags of its physical groups.
    groups: Vec<i64>,
    corners: Vec<u64>,
    place: FilePlace,
}

/// Content of the sections.
#[derive(Default)]
pub struct MshContent {
    names: BTreeMap<DimensionTag, String>,
    /// Physical groups of the entities.
    entities: BTreeMap<DimensionTag, Vec<i64>>,
    nodes: Vec<FileNode>,
    elements: Vec<MshElement>,
    /// True if an element of several groups is there once for each of them.
    repeats: bool,
}

/// An MSH file while it is read.
pub struct MshReader<'a, 'b> {
    stream: MshStream<'a>,
    reading: &'b mut MeshReading,
    content: MshContent,
}

/// Element types of MSH: number, nodes, cell. Gmsh has one order for all elements of a mesh, so
/// that shells next to tetrahedra with 10 nodes have nodes on their sides too.
const TYPES: &[(i64, usize, Cell)] = &[
    (1, 2, Cell::Line),
    (2, 3, Cell::Triangle),
    (3, 4, Cell::Quad),
    (4, 4, Cell::Tetrahedron),
    (5, 8, Cell::Hexahedron),
    (6, 6, Cell::Wedge),
    (7, 5, Cell::Pyramid),
    (8, 3, Cell::SecondOrder("line with 3 nodes", 1)),
    (9, 6, Cell::ByCorners("triangle with 6 nodes", Shape::Tri3)),
    (10, 9, Cell::ByCorners("quad with 9 nodes", Shape::Quad4)),
    (11, 10, Cell::Tetrahedron10),
    (12, 27, Cell::SecondOrder("hexahedron with 27 nodes", 3)),
    (13, 18, Cell::SecondOrder("wedge with 18 nodes", 3)),
    (14, 14, Cell::SecondOrder("pyramid with 14 nodes", 3)),
    (15, 1, Cell::Point),
    (16, 8, Cell::ByCorners("quad with 8 nodes", Shape::Quad4)),
    (17, 20, Cell::SecondOrder("hexahedron with 20 nodes", 3)),
    (18, 15, Cell::SecondOrder("wedge with 15 nodes", 3)),
    (19, 13, Cell::SecondOrder("pyramid with 13 nodes", 3)),
    (20, 9, Cell::SecondOrder("triangle with 9 nodes", 2)),
    (21, 10, Cell::SecondOrder("triangle with 10 nodes", 2)),
    (26, 4, Cell::SecondOrder("line with 4 nodes", 1)),
    (29, 20, Cell::SecondOrder("tetrahedron with 20 nodes", 3)),
];

/// Returns cell and number of nodes of an element type.
fn cell_of(number: i64) -> Result<(Cell, usize), RowFault> {
    let found = TYPES.iter().find(|(known, ..)| *known == number);
    found.map(|&(_, nodes, cell)| (cell, nodes)).ok_or_else(|| RowFault {
        message: format!("element type {number} is not known"),
        fatal: true,
    })
}

/// How to write the file again.
const AGAIN: &str = "save it again, for example: gmsh FILE.msh -save -format msh41 -o NEW.msh";
const COMPLETE: &str = "the file may be cut or edited: export it again from Gmsh";

/// Reads a file.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let (stream, content) = (MshStream::new(bytes), MshContent::default());
    let mut reader = MshReader { stream, reading, content };
    reader.file();
    let (mut content, reading) = (reader.content, reader.reading);
    // Gmsh has the last two edges in another order.
    let quadratic = content.elements.iter_mut().filter(|e| e.cell == Cell::Tetrahedron10);
    quadratic.for_each(|e| e.corners.swap(8, 9));
    if !reading.has_errors() {
        groups::add(content, reading);
    }
}

impl MshReader<'_, '_> {
    fn place(&self) -> FilePlace {
        FilePlace { file: 0, line: self.stream.line }
    }

    fn fault(&mut self, section: &str, fault: &RowFault) {
        let place = self.place();
        self.reading.error("row", place, format!("{section}: {}", fault.message), COMPLETE);
    }

    fn file(&mut self) {
        let Some(version) = self.header() else { return };
        self.content.repeats = version == 22;
        while let Some(line) = self.stream.text_line() {
            let Some(section) = line.strip_prefix('$') else {
                if !line.is_empty() {
                    let place = self.place();
                    let message = format!("a section is expected, not `{}`", shortened(line));
                    self.reading.error("section", place, message, COMPLETE);
                    return;
                }
                continue;
            };
            self.section(section, version);
            let place = self.place();
            if !self.stream.skip_to(&format!("$End{section}")) {
                let message = format!("section ${section} has no $End{section}");
                self.reading.error("section", place, message, COMPLETE);
                return;
            }
        }
        for (missing, name) in [
            (self.content.nodes.is_empty(), "Nodes"),
            (self.content.elements.is_empty(), "Elements"),
        ] {
            if missing && !self.reading.has_errors() {
                let message = format!("the file has no ${name}");
                self.reading.error("section", FilePlace::default(), message, COMPLETE);
            }
        }
    }

    /// Reads the header and returns the version times ten.
    fn header(&mut self) -> Option<u32> {
        loop {
            match self.stream.text_line() {
                Some("$MeshFormat") => break,
                Some("$NOD") => {
                    let message = "MSH files of version 1 are not read";
                    self.reading.error("version", self.place(), message, AGAIN);
                    return None;
                }
                Some(_) => {}
                None => return None,
            }
        }
        let line = self.stream.text_line().unwrap_or_default();
        let place = self.place();
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [version, form, size] = words[..] else {
            let message = format!("$MeshFormat has to be `version type size`, not `{line}`");
            self.reading.error("version", place, message, AGAIN);
            return None;
        };
        let known = match version {
            "4.1" => 41,
            "2" | "2.0" | "2.1" | "2.2" => 22,
            _ => {
                let message = format!("version {version} of MSH is not read, 4.1 and 2.2 are");
                self.reading.error("version", place, message, AGAIN);
                return None;
            }
        };
        if !matches!((form, size), ("0" | "1", "4" | "8")) {
            let message = format!("$MeshFormat has type {form} and size {size}");
            let help = "type is 0 (text) or 1 (binary), size 4 or 8; save the file again";
            self.reading.error("version", place, message, help);
            return None;
        }
        if form == "1" {
            let size = if size == "8" { 8 } else { 4 };
            self.stream.form = MshForm::Binary { big_endian: false, size };
            match self.stream.int() {
                Ok(1) => {}
                Ok(16_777_216) => self.stream.form = MshForm::Binary { big_endian: true, size },
                _ => {
                    let message = "the integer 1 that follows $MeshFormat is missing";
                    self.reading.error("version", place, message, COMPLETE);
                    return None;
                }
            }
        }
        if !self.stream.skip_to("$EndMeshFormat") {
            self.reading.error("version", place, "$MeshFormat has no end", COMPLETE);
            return None;
        }
        Some(known)
    }

    fn section(&mut self, name: &str, version: u32) {
        let read = match (name, version) {
            ("PhysicalNames", _) => {
                self.physical_names();
                Ok(())
            }
            ("Entities", 41) => self.entities(),
            ("Nodes", 41) => self.nodes_4(),
            ("Elements", 41) => self.elements_4(),
            ("Nodes", _) => self.nodes_2(),
            ("Elements", _) => self.elements_2(),
            ("PartitionedEntities", _) => {
                let message = "the mesh is partitioned";
                let help = "save it without partitions (Mesh > Unpartition in Gmsh)";
                self.reading.error("partition", self.place(), message, help);
                Ok(())
            }
            _ => {
                let meaning = match name {
                    "NodeData" | "ElementData" | "ElementNodeData" => "a field of results",
                    "Periodic" => "periodic entities: use [[tie]]",
                    "Comments" => "a comment",
                    _ => "not needed for a mesh",
                };
                self.reading.row(Fate::Ignored, format!("${name}"), 1, meaning);
                Ok(())
            }
        };
        if let Err(fault) = read {
            self.fault(&format!("${name}"), &fault);
        }
    }

    /// Reads names of physical groups: they are text also in binary files.
    fn physical_names(&mut self) {
        let form = std::mem::replace(&mut self.stream.form, MshForm::Text);
        let wanted = self.stream.text_line().and_then(|line| line.parse::<usize>().ok());
        let mut found = 0;
        while !self.stream.at_section() {
            let line = self.stream.text_line().unwrap_or_default();
            let mut words = line.splitn(3, ' ');
            let mut integer = || words.next()?.parse::<i64>().ok();
            let (dimension, tag) = (integer(), integer());
            let name = words.next().map(|name| name.trim().trim_matches('"'));
            match (dimension, tag, name) {
                (Some(dimension @ 0..=3), Some(tag), Some(name)) => {
                    self.content.names.insert((dimension as usize, tag), name.into());
                    found += 1;
                }
                _ if line.is_empty() => {}
                _ => {
                    let message = format!("`{}` is no physical group", shortened(line));
                    let help = "write dimension, tag and name: 2 1 \"plate\"";
                    self.reading.error("name", self.place(), message, help);
                }
            }
        }
        if wanted.is_none_or(|wanted| wanted != found) && !self.reading.has_errors() {
            let message = format!("$PhysicalNames has {found} names, not the number it states");
            self.reading.error("name", self.place(), message, COMPLETE);
        }
        self.stream.form = form;
    }

    /// Checks the number of rows of a section.
    fn check_count(&mut self, section: &str, stated: u64, found: usize) {
        if stated != found as u64 && !self.reading.has_errors() {
            let message = format!("{section} states {stated} entries and has {found}");
            self.reading.error("count", self.place(), message, COMPLETE);
        }
        // Rows after the last one would be lost.
        let is_text = self.stream.form == MshForm::Text;
        if is_text && !self.stream.at_section() && !self.reading.has_errors() {
            let message = format!("{section} has more rows after the {stated} that it states");
            self.reading.error("count", self.place(), message, COMPLETE);
        }
    }
}
