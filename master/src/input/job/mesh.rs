//! The mesh of a job, from a generator, a file or the job itself, with the meshes that are added to
//! it, and its checks.

pub mod added;
mod elements;
mod stresses;

use super::report::PlacedProblem;
use super::validate::JobProblems;
use crate::input::deck::ListLengths;
use added::AddedRange;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::initial;
use crumple_proto::job::{AddedMeshInput, Job, MeshSource};
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, OwnSection, Shape, corner_nodes};
use crumple_proto::problem::Problem;
use crumple_worker::fem::elements::LARGEST_OFFSET;
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of problems of one kind that are reported singly.
const MAX_REPORTED: usize = 20;
/// Largest id that an f64 represents exactly.
const LARGEST_ID: f64 = 9_007_199_254_740_992.0;

/// A mesh, and the places of its entities in the job.
pub struct PlacedMesh {
    /// The mesh.
    pub mesh: Mesh,
    /// Where its entities are written.
    written: Written,
    /// The meshes that were added to it, in their order.
    added: Vec<AddedRange>,
    /// Nodes of no element that stand for a rigid body: it is reported that the model lacks them.
    stand_ins: BTreeSet<NodeId>,
}

/// Where the entities of a mesh are written.
enum Written {
    /// In rows: names and lengths of the lists of elements.
    Rows(ListLengths),
    /// Not in the job: the key that names the source.
    Elsewhere(&'static str),
}

impl PlacedMesh {
    /// Creates it from the mesh of a deck, whose elements are ordered by `lists`. Nodes of
    /// `stand_ins` that belong to no element are not reported.
    pub fn of_deck(mesh: Mesh, lists: ListLengths, stand_ins: BTreeSet<NodeId>) -> Self {
        PlacedMesh { mesh, written: Written::Rows(lists), added: Vec::new(), stand_ins }
    }

    /// Creates it from a mesh that a key of the job names.
    pub fn elsewhere(mesh: Mesh, key: &'static str) -> Self {
        let (added, stand_ins) = Default::default();
        PlacedMesh { mesh, written: Written::Elsewhere(key), added, stand_ins }
    }

    /// Makes the hexahedra of these parts cohesive elements.
    pub fn with_cohesive(mut self, parts: &[u32]) -> Self {
        if !parts.is_empty() {
            let hexahedra = self.mesh.elements.iter_mut().filter(|e| e.shape == Shape::Hex8);
            hexahedra.filter(|e| parts.contains(&e.part)).for_each(|e| e.shape = Shape::Cohesive8);
        }
        self
    }

    fn node_path(&self, index: usize) -> String {
        if let Some(added) = self.added.iter().rev().find(|a| a.first_node <= index) {
            return added.key.clone();
        }
        match self.written {
            Written::Rows(_) => format!("mesh.nodes.{index}"),
            Written::Elsewhere(key) => key.into(),
        }
    }

    fn element_path(&self, index: usize) -> String {
        if let Some(added) = self.added.iter().rev().find(|a| a.first_element <= index) {
            return added.key.clone();
        }
        let lists = match &self.written {
            Written::Rows(lists) => lists,
            Written::Elsewhere(key) => return (*key).into(),
        };
        let mut place = index;
        for (list, length) in lists {
            match place.checked_sub(*length) {
                None => return format!("mesh.{list}.{place}"),
                Some(beyond) => place = beyond,
            }
        }
        "mesh".into()
    }

    fn set_path(&self, name: &str) -> String {
        if let Some(added) = self.added.iter().find(|a| a.sets.contains(name)) {
            return added.key.clone();
        }
        match self.written {
            Written::Rows(_) => format!("mesh.node_sets.{name}"),
            Written::Elsewhere(key) => key.into(),
        }
    }
}

/// Generates the mesh with the job's `[scene]`. Reports an error and returns `None` if this
/// fails.
pub fn generate(name: &str, job: &Job, findings: &mut JobProblems) -> Option<PlacedMesh> {
    match crumple_cases::generate(name, &job.scene) {
        Ok(mesh) => Some(PlacedMesh::elsewhere(mesh, "mesh.generator")),
        Err(problems) => {
            problems.into_iter().for_each(|p| findings.add(p));
            None
        }
    }
}

/// Creates the mesh from rows of numbers; `None` if a row is not a valid node or element.
pub fn from_rows(source: &MeshSource, findings: &mut JobProblems) -> Option<PlacedMesh> {
    let mut few = Few::new(findings);
    let mut mesh = Mesh::default();
    for (index, &[id, x, y, z]) in source.nodes.iter().enumerate() {
        if id.fract() == 0.0 && (0.0..=LARGEST_ID).contains(&id) {
            mesh.nodes.push(MeshNode { id: NodeId(id as u64), x: [x, y, z] });
        } else {
            few.error(
                "node id",
                format!("mesh.nodes.{index}"),
                format!("{id} is not a valid node id"),
                "give a whole number from 0: a node is [id, x, y, z]",
            );
        }
    }
    for (index, row) in source.shells.iter().enumerate() {
        let kind = ElementList { list: "shells", called: "a shell", help: SHELL_ROW };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| match corners {
            [_, _, c, d] => Some(if c == d { Shape::Tri3 } else { Shape::Quad4 }),
            [_, _, _] => Some(Shape::Tri3),
            _ => None,
        }));
    }
    for (index, row) in source.solids.iter().enumerate() {
        let kind = ElementList { list: "solids", called: "a solid", help: SOLID_ROW };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| match corners.len() {
            4 => Some(Shape::Tet4),
            6 => Some(Shape::Wedge6),
            8 => Some(Shape::Hex8),
            10 => Some(Shape::Tet10),
            _ => None,
        }));
    }
    for (index, row) in source.beams.iter().enumerate() {
        let kind = ElementList {
            list: "beams",
            called: "a beam",
            help: "write [id, part id, n1, n2, n3]",
        };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| {
            (corners.len() == 3).then_some(Shape::Beam2)
        }));
    }
    for (index, row) in source.springs.iter().enumerate() {
        let kind = ElementList {
            list: "springs",
            called: "a spring",
            help: "write [id, part id, n1, n2]",
        };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| {
            (corners.len() == 2).then_some(Shape::Line2)
        }));
    }
    for (index, row) in source.trusses.iter().enumerate() {
        let kind =
            ElementList { list: "trusses", called: "a truss", help: "write [id, part id, n1, n2]" };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| {
            (corners.len() == 2).then_some(Shape::Truss2)
        }));
    }
    for (index, row) in source.particles.iter().enumerate() {
        let kind = ElementList {
            list: "particles",
            called: "a particle",
            help: "write [id, part id, n1]",
        };
        mesh.elements.extend(element(row, &kind, index, &mut few, |corners| {
            (corners.len() == 1).then_some(Shape::Point1)
        }));
    }
    OwnLists::of(source).assign(&mut mesh, &mut few);
    for (name, ids) in &source.node_sets {
        mesh.node_sets.insert(name.clone(), ids.iter().copied().map(NodeId).collect());
    }
    // Without this, references to an omitted row would be reported as errors.
    let lists = vec![
        ("shells", source.shells.len()),
        ("solids", source.solids.len()),
        ("beams", source.beams.len()),
        ("springs", source.springs.len()),
        ("trusses", source.trusses.len()),
        ("particles", source.particles.len()),
    ];
    let rows: usize = lists.iter().map(|list| list.1).sum();
    let whole = mesh.nodes.len() == source.nodes.len() && mesh.elements.len() == rows;
    whole.then_some(PlacedMesh::of_deck(mesh, lists, BTreeSet::new()))
}

/// Lists of thicknesses, offsets and angles of single shells, and of stresses, of a mesh.
pub struct OwnLists<'a> {
    thicknesses: &'a [[f64; 2]],
    offsets: &'a [[f64; 2]],
    angles: &'a [[f64; 2]],
    stresses: &'a [[f64; 10]],
    /// Path of the table that has the lists.
    path: String,
    /// Begin of messages.
    of: String,
}

impl<'a> OwnLists<'a> {
    /// Returns the lists of the mesh of a job, without those that are added to it.
    pub fn of(source: &'a MeshSource) -> Self {
        let MeshSource { thicknesses, offsets, angles, stresses, .. } = source;
        let (path, of) = ("mesh".into(), String::new());
        OwnLists { thicknesses, offsets, angles, stresses, path, of }
    }

    /// Returns the lists of the mesh with this number that is added.
    fn of_added(index: usize, input: &'a AddedMeshInput) -> Self {
        let AddedMeshInput { thicknesses, offsets, angles, file, .. } = input;
        let (path, of) = (format!("mesh.add.{index}"), format!("{file}: "));
        OwnLists { thicknesses, offsets, angles, stresses: &[], path, of }
    }

    /// Assigns the values to the elements of a mesh. Reports rows that do not fit it.
    fn assign(&self, mesh: &mut Mesh, few: &mut Few<'_>) {
        self.assign_one(mesh, &THICKNESS, self.thicknesses, few);
        self.assign_one(mesh, &OFFSET, self.offsets, few);
        self.assign_one(mesh, &ANGLE, self.angles, few);
        stresses::assign(mesh, self.stresses, &self.path, few);
    }
}

/// Assigns values of their own to elements, from the lists of a job.
pub fn with_own_sections(
    mut read: PlacedMesh,
    lists: &OwnLists<'_>,
    findings: &mut JobProblems,
) -> PlacedMesh {
    lists.assign(&mut read.mesh, &mut Few::new(findings));
    read
}

/// A list of values of single shells.
struct OwnValue {
    /// Key of the list below `mesh`.
    list: &'static str,
    /// Name of a value in messages.
    called: &'static str,
    fits: fn(f64) -> bool,
    wanted: &'static str,
    set: fn(&mut OwnSection, f64),
}

const THICKNESS: OwnValue = OwnValue {
    list: "thicknesses",
    called: "thickness",
    fits: |t| t > 0.0 && t.is_finite(),
    wanted: "above 0",
    set: |own, t| own.thickness = t,
};
const OFFSET: OwnValue = OwnValue {
    list: "offsets",
    called: "offset",
    fits: |offset| offset.abs() <= LARGEST_OFFSET,
    wanted: "from -10 to 10 (-1 to 1 is usual)",
    set: |own, offset| own.offset = Some(offset),
};
const ANGLE: OwnValue = OwnValue {
    list: "angles",
    called: "angle",
    fits: f64::is_finite,
    wanted: "a number of degrees",
    set: |own, angle| own.angle = angle,
};

impl OwnLists<'_> {
    fn assign_one(&self, mesh: &mut Mesh, value: &OwnValue, rows: &[[f64; 2]], few: &mut Few<'_>) {
        if rows.is_empty() {
            return;
        }
        let OwnValue { list, called, wanted, .. } = value;
        let OwnLists { path, of, .. } = self;
        let at: FxHashMap<ElemId, usize> =
            mesh.elements.iter().enumerate().map(|(i, e)| (e.id, i)).collect();
        let mut given = FxHashSet::with_capacity_and_hasher(rows.len(), FxBuildHasher);
        for (index, &[id, number]) in rows.iter().enumerate() {
            let path = || format!("{path}.{list}.{index}");
            let whole = id.fract() == 0.0 && (0.0..=LARGEST_ID).contains(&id);
            let Some(&place) = at.get(&ElemId(id as u64)).filter(|_| whole) else {
                few.error(
                    "no shell",
                    path(),
                    format!("{of}there is no element {id}"),
                    &format!("a row is [id of a shell, {called}]"),
                );
                continue;
            };
            let element = &mut mesh.elements[place];
            if !element.shape.is_shell() {
                let message = format!("{of}element {id} is not a shell and has no {called}");
                few.error("no shell", path(), message, "remove this row");
            }
            if !(value.fits)(number) {
                let message = format!("{of}element {id}: its {called} is {number:?}");
                let help = format!(
                    "it has to be {wanted}; without a row a shell has the {called} of its part"
                );
                few.error(called, path(), message, &help);
            }
            if !given.insert(place) {
                let message =
                    format!("{of}element {id} is given {} {called} twice", article(called));
                few.error("given twice", path(), message, "remove one of the two rows");
            }
            (value.set)(&mut element.own, number);
        }
    }
}

/// Returns the indefinite article of a word.
fn article(word: &str) -> &'static str {
    if word.starts_with(['a', 'o']) { "an" } else { "a" }
}

const SHELL_ROW: &str = "write [id, part id, n1, n2, n3, n4], or three nodes for a triangle";
const SOLID_ROW: &str = "write [id, part id, n1, ..., n8]: the nodes of a face, then those of the \
                         opposite face; a wedge has six nodes, a tetrahedron four";

/// A list of elements, with its names in messages.
struct ElementList {
    list: &'static str,
    called: &'static str,
    help: &'static str,
}

/// Returns the element of a row. Reports an error and returns `None` if it is invalid. `shape`
/// returns the shape for a list of corners.
fn element(
    row: &[u64],
    kind: &ElementList,
    index: usize,
    few: &mut Few<'_>,
    shape: impl Fn(&[u64]) -> Option<Shape>,
) -> Option<MeshElement> {
    let path = || format!("mesh.{}.{index}", kind.list);
    let (&[id, part], corners) = row.split_first_chunk().unwrap_or((&[0, 0], &[]));
    let Some(shape) = shape(corners) else {
        let message = format!("{} cannot be a list of {} numbers", kind.called, row.len());
        few.error("row", path(), message, kind.help);
        return None;
    };
    let Ok(part) = u32::try_from(part) else {
        let message = format!("element {id}: {part} is not a valid part id");
        few.error("part id", path(), message, "part ids are at most 4294967295");
        return None;
    };
    let given = if shape == Shape::Beam2 { corners } else { &corners[..shape.corners()] };
    let nodes: Vec<NodeId> = given.iter().copied().map(NodeId).collect();
    Some(MeshElement::new(ElemId(id), part, shape, &nodes))
}

/// Vectors from beams towards their second axes [length].
pub type Axes = Vec<(ElemId, [f64; 3])>;

/// Checks ids, connectivity and shapes, removes nodes that no element uses, and sorts all
/// entities by id. Returns the mesh and the vectors from beams towards their second axes,
/// ascending. Beams have two nodes afterwards.
///
/// `parts` are the ids of the job's parts, `None` if the parts have errors.
pub fn check(read: PlacedMesh, parts: Option<&[u32]>, findings: &mut JobProblems) -> (Mesh, Axes) {
    let before = findings.list.len();
    let mut few = Few::new(findings);
    let at = check_nodes(&read, &mut few);
    elements::check(&read, &at, parts, &mut few);
    for (name, ids) in &read.mesh.node_sets {
        let unknown: Vec<NodeId> = ids.iter().copied().filter(|id| !at.contains_key(id)).collect();
        if let Some(first) = unknown.first() {
            let message = match unknown.len() {
                1 => format!("node set `{name}`: there is no node {}", first.0),
                n => format!(
                    "node set `{name}`: {n} of its nodes do not exist; the first is node {}",
                    first.0
                ),
            };
            few.error(
                "set",
                read.set_path(name),
                message,
                "add the node or remove it from the set",
            );
        }
    }
    let turned: FxHashSet<NodeId> =
        read.mesh.elements.iter().filter(|e| e.shape == Shape::Beam2).map(|e| e.nodes[2]).collect();
    let used: FxHashSet<NodeId> =
        read.mesh.elements.iter().flat_map(|e| e.corners()).copied().collect();
    let unused: Vec<(usize, NodeId)> = read
        .mesh
        .nodes
        .iter()
        .enumerate()
        .filter(|(_, n)| {
            !used.contains(&n.id) && !turned.contains(&n.id) && !read.stand_ins.contains(&n.id)
        })
        .map(|(i, n)| (i, n.id))
        .collect();
    if let (Some(&(index, first)), false) = (unused.first(), read.mesh.elements.is_empty()) {
        let message = match unused.len() {
            1 => format!("node {first} belongs to no element and is left out"),
            n => format!(
                "{n} nodes belong to no element and are left out; the first is node {first}"
            ),
        };
        few.findings.add(Problem::warning(
            read.node_path(index),
            message,
            "remove them from the mesh, or connect them",
        ));
    }
    drop(few);
    for PlacedProblem { problem, .. } in &mut findings.list[before..] {
        if let Some(added) = read.added.iter().find(|added| added.key == problem.path) {
            problem.message = format!("{}: {}", added.origin, problem.message);
        }
    }
    let mut mesh = read.mesh;
    mesh.nodes.retain(|n| used.contains(&n.id));
    mesh.nodes.sort_by_key(|n| n.id);
    mesh.elements.sort_by_key(|e| e.id);
    initial::sort(&mut mesh.initial);
    let mut axes = Axes::new();
    for e in mesh.elements.iter_mut().filter(|e| e.shape == Shape::Beam2) {
        if let (Some(from), Some(to)) = (at.get(&e.nodes[0]), at.get(&e.nodes[2])) {
            axes.push((e.id, [0, 1, 2].map(|c| to[c] - from[c])));
        }
        e.nodes = corner_nodes(&e.nodes[..2]);
    }
    for ids in mesh.node_sets.values_mut() {
        ids.sort_unstable();
        ids.dedup();
    }
    (mesh, axes)
}

fn check_nodes(read: &PlacedMesh, few: &mut Few<'_>) -> FxHashMap<NodeId, [f64; 3]> {
    let count = read.mesh.nodes.len();
    let mut at = FxHashMap::with_capacity_and_hasher(count, FxBuildHasher);
    for (index, node) in read.mesh.nodes.iter().enumerate() {
        if node.id > NodeId::LARGEST {
            let message = format!("node id {} is too large", node.id.0);
            few.error("node id", read.node_path(index), message, "use node ids below 9e15");
        }
        if !node.x.iter().all(|c| c.is_finite()) {
            let message = format!("node {} has the coordinates {:?}", node.id, node.x);
            few.error(
                "not finite",
                read.node_path(index),
                message,
                "coordinates have to be finite numbers",
            );
        }
        if at.insert(node.id, node.x).is_some() {
            let message = format!("node {} is defined twice", node.id);
            few.error("node twice", read.node_path(index), message, "give each node a unique id");
        }
    }
    at
}

/// Reports the first problems of each kind singly and counts the others.
struct Few<'f> {
    findings: &'f mut JobProblems,
    counts: BTreeMap<&'static str, (usize, String)>,
}

impl<'f> Few<'f> {
    fn new(findings: &'f mut JobProblems) -> Self {
        Few { findings, counts: BTreeMap::new() }
    }

    fn error(&mut self, kind: &'static str, path: String, message: String, help: &str) {
        let entry = self.counts.entry(kind).or_insert((0, String::new()));
        entry.0 += 1;
        if entry.0 <= MAX_REPORTED {
            entry.1.clone_from(&path);
            self.findings.add(Problem::error(path, message, help));
        }
    }
}

impl Drop for Few<'_> {
    fn drop(&mut self) {
        for (kind, (count, path)) in std::mem::take(&mut self.counts) {
            if count > MAX_REPORTED {
                let message =
                    format!("{} more problems of this kind ({kind})", count - MAX_REPORTED);
                self.findings.add(Problem::error(path, message, ""));
            }
        }
    }
}
