//! A mesh file while it is read: content, table of what became of it, problems.

use super::cells::{Cell, CellUse};
use super::content::{FileElement, FileMesh, FilePlace};
use crate::input::confine;
use crumple_proto::mesh::{OwnSection, Shape, solid_of_eight};
use crumple_proto::problem::Problem;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Maximum number of problems of one kind that are reported singly.
const MOST: usize = 10;

/// Maximum number of ids that sets get by ranges or from other sets.
const MOST_IDS: usize = 50_000_000;

/// Cure for an element with a node that is missing.
pub const NODE_HELP: &str = "define the node, or correct or remove the element";

/// Shapes of elements and their names in the table.
const SHAPES: [(Shape, &str); 7] = [
    (Shape::Quad4, "quads"),
    (Shape::Tri3, "triangles"),
    (Shape::Hex8, "solids"),
    (Shape::Tet4, "tetrahedra"),
    (Shape::Wedge6, "wedges"),
    (Shape::Tet10, "ten-node tetrahedra"),
    (Shape::Beam2, "beams"),
];

/// Fate of something in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is in the mesh or the job.
    Read,
    /// It is ignored.
    Ignored,
    /// It is left out, though it changes the result.
    LeftOut,
}

/// A row of the table of what became of the content of a file.
#[derive(Clone, Debug)]
pub struct ImportRow {
    /// Name in the file.
    pub what: String,
    /// Number of such entries.
    pub count: usize,
    /// Its fate.
    pub fate: Fate,
    /// Its meaning in the job, or what to write there instead.
    pub became: String,
}

/// A mesh file while it is read.
pub struct MeshReading {
    /// Names of the files: the one that the job names, and those that it includes.
    pub files: Vec<PathBuf>,
    /// Leave out what is not supported, instead of an error.
    pub allowed: bool,
    /// Content.
    pub mesh: FileMesh,
    /// Table of the content.
    pub rows: Vec<ImportRow>,
    problems: Vec<Problem>,
    counts: BTreeMap<&'static str, usize>,
    refused: BTreeMap<&'static str, (Cell, usize, FilePlace)>,
    /// Properties of elements that are not supported: number of elements, the first one, the cure.
    lacking: BTreeMap<&'static str, (usize, FilePlace, &'static str)>,
    /// Nodes that are missing, each with an error that names it.
    missing: HashSet<u64>,
    nodes_are_checked: bool,
    /// Number of ids that sets may still have.
    room: usize,
    /// The files without links and `..`.
    canonical: HashSet<PathBuf>,
}

impl MeshReading {
    /// Begins to read a file.
    pub fn new(path: &Path, allowed: bool) -> Self {
        MeshReading {
            files: vec![path.to_owned()],
            allowed,
            mesh: FileMesh::default(),
            rows: Vec::new(),
            problems: Vec::new(),
            counts: BTreeMap::new(),
            refused: BTreeMap::new(),
            lacking: BTreeMap::new(),
            missing: HashSet::new(),
            nodes_are_checked: false,
            room: MOST_IDS,
            canonical: std::fs::canonicalize(path).into_iter().collect(),
        }
    }

    /// Counts ids that sets get by ranges or from other sets. Reports an error and returns false
    /// if all sets together have too many.
    pub fn has_room(&mut self, ids: usize, place: FilePlace) -> bool {
        match self.room.checked_sub(ids) {
            Some(room) => {
                self.room = room;
                true
            }
            None => {
                let message = format!("the sets of the file have more than {MOST_IDS} ids");
                let help = "shorten the range or correct the names of sets; remove sets that the \
                            job does not need";
                self.error("ids", place, message, help);
                false
            }
        }
    }

    /// Counts an element with a property that is not supported. All of one property are reported
    /// together.
    pub fn lacks(&mut self, property: &'static str, place: FilePlace, cure: &'static str) {
        self.lacking.entry(property).or_insert((0, place, cure)).0 += 1;
    }

    /// Reports that an element has a node, as the file names it, that is missing.
    pub fn lacks_node(
        &mut self,
        element: u64,
        node: impl std::fmt::Display,
        place: FilePlace,
        help: &str,
    ) {
        let message = format!("element {element} has node {node}, which is missing");
        self.error("no node", place, message, help);
    }

    /// Reports that a set has nodes, as the file names them, that are missing.
    pub fn set_lacks(&mut self, name: &str, missing: &[u64], place: FilePlace) {
        let Some(first) = missing.first() else { return };
        let others = match missing.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        let message = format!("set `{name}` has node {first}{others}, which is missing");
        self.error("set", place, message, "add the node or correct the set");
    }

    /// Keeps in mind that a node of the mesh is missing and that an error says so.
    pub fn reported(&mut self, nodes: impl IntoIterator<Item = u64>) {
        self.missing.extend(nodes);
    }

    /// Returns true if an error says that this node of the mesh is missing.
    pub fn is_reported(&self, node: u64) -> bool {
        self.missing.contains(&node)
    }

    /// Returns `FILE:LINE` of a place.
    pub fn at(&self, place: FilePlace) -> String {
        let file = self.files.get(place.file as usize).unwrap_or(&self.files[0]).display();
        if place.line == 0 { file.to_string() } else { format!("{file}:{}", place.line) }
    }

    /// Adds an error. After some of one kind, the others are counted.
    pub fn error(
        &mut self,
        kind: &'static str,
        place: FilePlace,
        message: impl std::fmt::Display,
        help: impl Into<String>,
    ) {
        let count = self.counts.entry(kind).or_insert(0);
        *count += 1;
        if *count <= MOST {
            let message = format!("{}: {message}", self.at(place));
            self.problems.push(Problem::error(super::KEY, message, help));
        }
    }

    /// Adds a warning.
    pub fn warning(
        &mut self,
        place: FilePlace,
        message: impl std::fmt::Display,
        help: impl Into<String>,
    ) {
        let message = format!("{}: {message}", self.at(place));
        self.problems.push(Problem::warning(super::KEY, message, help));
    }

    /// Reports what is not supported: an error, or a warning if it may be left out.
    pub fn unsupported(
        &mut self,
        kind: &'static str,
        place: FilePlace,
        message: impl std::fmt::Display,
        help: &str,
    ) {
        if self.allowed {
            self.warning(place, format!("{message}; it is left out"), help);
        } else {
            let help = format!("{help}, or leave it out with --allow-unsupported");
            self.error(kind, place, message, help);
        }
    }

    /// Returns true if there is an error.
    pub fn has_errors(&self) -> bool {
        !self.counts.is_empty()
    }

    /// Adds a row of the table.
    pub fn row(
        &mut self,
        fate: Fate,
        what: impl Into<String>,
        count: usize,
        became: impl Into<String>,
    ) {
        let (what, became) = (what.into(), became.into());
        match self.rows.iter_mut().find(|r| r.what == what && r.became == became) {
            Some(row) => row.count += count,
            None => self.rows.push(ImportRow { what, count, fate, became }),
        }
    }

    /// Adds an element of a cell type. An element whose type is not supported is counted.
    pub fn add_element(
        &mut self,
        (id, part): (u64, usize),
        cell: Cell,
        corners: &[u64],
        place: FilePlace,
    ) {
        let shape = match cell.usage() {
            CellUse::Element(shape) => shape,
            CellUse::Point => return,
            CellUse::Ignored(advice) => {
                self.row(Fate::Ignored, cell.name(), 1, advice);
                return;
            }
            CellUse::Refused(_) => {
                self.refused.entry(cell.name()).or_insert((cell, 0, place)).1 += 1;
                return;
            }
        };
        let (shape, corners) = match (shape, corners) {
            (Shape::Quad4, [a, b, c, d]) if c == d => (Shape::Tri3, vec![*a, *b, *c]),
            (Shape::Tri3 | Shape::Quad4, _) if matches!(cell, Cell::ByCorners(..)) => {
                let became = "by the corners: their other nodes are left out, unless other \
                              elements have them";
                self.row(Fate::Read, cell.name(), 1, became);
                (shape, corners.iter().copied().take(shape.corners()).collect())
            }
            (Shape::Hex8, _) => corners
                .first_chunk()
                .and_then(solid_of_eight)
                .unwrap_or_else(|| (shape, corners.to_vec())),
            _ => (shape, corners.to_vec()),
        };
        self.mesh.elements.push(FileElement {
            id,
            part,
            shape,
            corners,
            axis: None,
            own: OwnSection::default(),
            place,
        });
    }

    /// Reports cell types and properties of elements that are not supported.
    fn report_refused(&mut self) {
        for (name, (cell, count, place)) in std::mem::take(&mut self.refused) {
            let CellUse::Refused(cure) = cell.usage() else { continue };
            let message = match count {
                1 => format!("an element of type {name} is not supported"),
                n => format!("{n} elements of type {name} are not supported; this is the first"),
            };
            self.unsupported(name, place, message, cure);
            self.row(Fate::LeftOut, name, count, cure);
        }
        for (property, (count, place, cure)) in std::mem::take(&mut self.lacking) {
            let message = match count {
                1 => format!("an element has {property}, which is not supported"),
                n => format!("{n} elements have {property}, not supported; this is the first"),
            };
            self.unsupported(property, place, message, cure);
            self.row(Fate::LeftOut, property, count, cure);
        }
    }

    /// Checks ids and references, and adds rows for all that was read.
    pub fn finish(&mut self) {
        self.report_refused();
        self.check_nodes();
        self.check_elements();
        self.check_sets();
        if self.mesh.elements.is_empty() && !self.has_errors() {
            self.error(
                "empty",
                FilePlace::default(),
                "the file has no elements that can be used",
                "export shells, solids or beams together with their nodes",
            );
        }
        self.drop_empty_parts();
        for (old, id, name) in self.mesh.make_names_unique() {
            let became = format!("part {id} ({name}): another part has its name");
            self.row(Fate::Read, format!("part {old}"), 1, became);
        }
        let (lost, emptied) = self.mesh.prune();
        for name in emptied {
            self.row(Fate::Ignored, format!("node set {name}"), 1, "no element has its nodes");
        }
        self.mesh.add_sets_of_parts();
        if lost > 0 {
            self.row(Fate::Ignored, "nodes in no element", lost, "left out");
        }
        let rows = self.summary();
        self.rows.splice(0..0, rows);
    }

    /// Removes parts without elements.
    fn drop_empty_parts(&mut self) {
        let mesh = &mut self.mesh;
        let mut used = vec![false; mesh.parts.len()];
        mesh.elements.iter().for_each(|element| used[element.part] = true);
        let place: Vec<usize> = used
            .iter()
            .scan(0, |next, &used| {
                *next += usize::from(used);
                Some(next.saturating_sub(1))
            })
            .collect();
        mesh.elements.iter_mut().for_each(|element| element.part = place[element.part]);
        let parts = std::mem::take(&mut mesh.parts).into_iter().zip(&used);
        let (kept, lost): (Vec<_>, Vec<_>) = parts.partition(|(_, used)| **used);
        mesh.parts = kept.into_iter().map(|(part, _)| part).collect();
        for (part, _) in lost.into_iter().filter(|(part, _)| part.material.is_some()) {
            let what = format!("part {} {}", part.id, part.name);
            self.row(Fate::Ignored, what.trim_end(), 1, "it has no elements");
        }
    }

    /// Returns the rows of nodes, shapes, node sets and materials.
    pub fn summary(&self) -> Vec<ImportRow> {
        let mut rows = Vec::new();
        let mut read = |what: String, count: usize, became: String| {
            if count > 0 {
                rows.push(ImportRow { what, count, fate: Fate::Read, became });
            }
        };
        let mut counts = vec![[0; SHAPES.len()]; self.mesh.parts.len()];
        for element in &self.mesh.elements {
            let shape = SHAPES.iter().position(|(shape, _)| *shape == element.shape);
            shape.into_iter().for_each(|shape| counts[element.part][shape] += 1);
        }
        read("nodes".into(), self.mesh.nodes.len(), "nodes".into());
        for (index, part) in self.mesh.parts.iter().enumerate() {
            for ((_, name), count) in SHAPES.iter().zip(counts[index]) {
                let called =
                    if part.name.is_empty() { String::new() } else { format!(" ({})", part.name) };
                read((*name).into(), count, format!("part {}{called}", part.id));
            }
        }
        for (name, ids) in &self.mesh.node_sets {
            read(format!("nodes of {name}"), ids.len(), format!("node set `{name}`"));
        }
        for material in &self.mesh.materials {
            let became = format!("[[material]] `{}`, law {}", material.name, material.law());
            read(format!("material {}", material.name), 1, became);
        }
        rows
    }

    /// Checks the ids and coordinates of the nodes, once: a reader whose own checks need them calls
    /// this after its last node.
    pub fn check_nodes(&mut self) {
        if std::mem::replace(&mut self.nodes_are_checked, true) {
            return;
        }
        let nodes = std::mem::take(&mut self.mesh.nodes);
        let mut first: HashMap<u64, FilePlace> = HashMap::with_capacity(nodes.len());
        for node in &nodes {
            if let Some(before) = first.insert(node.id, node.place) {
                let before = self.at(before);
                let message = format!("node {} is defined twice, first at {before}", node.id);
                self.error("node twice", node.place, message, "give each node a unique id");
            }
            if !node.x.iter().all(|x| x.is_finite()) {
                let message = format!("node {} has the coordinates {:?}", node.id, node.x);
                let help = "coordinates have to be finite numbers; export the mesh again";
                self.error("not finite", node.place, message, help);
            }
        }
        self.mesh.nodes = nodes;
    }

    fn check_elements(&mut self) {
        let elements = std::mem::take(&mut self.mesh.elements);
        let known: HashSet<u64> = self.mesh.nodes.iter().map(|n| n.id).collect();
        let before = self.missing.clone();
        let mut first: HashMap<u64, FilePlace> = HashMap::with_capacity(elements.len());
        for element in &elements {
            if let Some(other) = first.insert(element.id, element.place) {
                let other = self.at(other);
                let message = format!("element {} is defined twice, first at {other}", element.id);
                self.error("element twice", element.place, message, "give each a unique id");
            }
            let missing = |node: &&u64| !known.contains(node) && !before.contains(node);
            if let Some(node) = element.corners.iter().find(missing) {
                self.lacks_node(element.id, node, element.place, NODE_HELP);
                let all = element.corners.iter().copied().filter(|node| !known.contains(node));
                self.missing.extend(all);
            }
            let corners = &element.corners;
            if let Some(twice) = (1..corners.len()).find(|&i| corners[..i].contains(&corners[i])) {
                let message = format!("element {} has node {} twice", element.id, corners[twice]);
                let help = match element.shape {
                    Shape::Hex8 => {
                        "a solid needs eight different nodes; with repeated nodes it can be a \
                         tetrahedron or a wedge, but no pyramid: mesh it again"
                    }
                    _ => "correct or remove the element; a triangle repeats its last node only",
                };
                self.error("repeated", element.place, message, help);
            }
        }
        self.mesh.elements = elements;
    }

    fn check_sets(&mut self) {
        let known: HashSet<u64> = self.mesh.nodes.iter().map(|n| n.id).collect();
        let mut wrong = Vec::new();
        for (name, ids) in &self.mesh.node_sets {
            let missing = ids.iter().copied();
            let missing = missing.filter(|id| !known.contains(id) && !self.missing.contains(id));
            wrong.push((name.clone(), missing.collect::<Vec<u64>>()));
        }
        for (name, missing) in wrong {
            self.set_lacks(&name, &missing, FilePlace::default());
        }
    }

    /// Returns all problems.
    pub fn into_problems(self) -> Vec<Problem> {
        let mut problems = self.problems;
        for (kind, count) in self.counts.iter().filter(|(_, count)| **count > MOST) {
            let message = format!("{} more problems of this kind ({kind})", count - MOST);
            problems.push(Problem::error(super::KEY, message, "correct the first ones first"));
        }
        problems
    }

    /// Reads a file that the first one includes. Reports an error if it cannot be read.
    pub fn include(&mut self, name: &str, place: FilePlace) -> Option<(u32, Vec<u8>)> {
        let from = self.files.get(place.file as usize).unwrap_or(&self.files[0]);
        let path = from.parent().unwrap_or(Path::new("")).join(name);
        // One file has many paths.
        let canonical = confine::check(&path).and_then(|()| std::fs::canonicalize(&path));
        if canonical.is_ok_and(|canonical| !self.canonical.insert(canonical)) {
            let help = "remove one of the two, or give each its own file";
            self.error("include", place, format!("`{name}` is included twice"), help);
            return None;
        }
        match confine::check(&path).and_then(|()| std::fs::read(&path)) {
            Ok(bytes) => {
                self.files.push(path);
                Some((self.files.len() as u32 - 1, bytes))
            }
            Err(error) => {
                let message = format!("the included file `{name}` cannot be read: {error}");
                let help = "correct its name: it is relative to the file that includes it";
                self.error("include", place, message, help);
                None
            }
        }
    }
}

/// Returns the table of what became of the content of a file.
pub fn table(rows: &[ImportRow]) -> String {
    let rows: Vec<[String; 4]> = std::iter::once(["in the file", "count", "fate", "became"])
        .map(|head| head.map(String::from))
        .chain(rows.iter().map(|row| {
            let fate = match row.fate {
                Fate::Read => "read",
                Fate::Ignored => "ignored",
                Fate::LeftOut => "left out",
            };
            [row.what.clone(), row.count.to_string(), fate.into(), row.became.clone()]
        }))
        .collect();
    let width = |c: usize| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0);
    let (first, second, third) = (width(0), width(1), width(2));
    let line = |[what, count, fate, became]: &[String; 4]| {
        format!("  {what:first$}  {count:>second$}  {fate:third$}  {became}\n")
    };
    rows.iter().map(line).collect()
}
