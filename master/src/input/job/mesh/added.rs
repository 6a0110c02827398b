//! Meshes that a job adds to its mesh (`[[mesh.add]]`): their ids, their place in space and the
//! names of their node sets.

use super::{Few, OwnLists, PlacedMesh};
use crate::input::deck::Affine;
use crate::input::job::validate::JobProblems;
use crate::input::job::walls::unit;
use crate::input::mesh_file::ImportRow;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::{AddedMeshInput, Job};
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode};
use crumple_proto::problem::Problem;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::Path;

/// Offsets of part ids are multiples of this number by default.
const ROUND_PARTS: u64 = 1000;
/// Offsets of ids of nodes and elements are multiples of this number by default.
const ROUND_IDS: u64 = 1_000_000;

/// A mesh as its file has it.
pub struct AddedFile {
    /// The file, as messages name it.
    pub file: String,
    /// Its format.
    pub format: &'static str,
    /// Its content.
    pub mesh: Mesh,
    /// Names of its parts by id, empty without one; none if parts have no sets of their own.
    pub parts: BTreeMap<u32, String>,
    /// Ids and offsets of its parts that have an offset.
    pub offsets: Vec<(u32, f64)>,
    /// Table of its content.
    pub rows: Vec<ImportRow>,
}

/// A mesh that was added: its ids and names in the job, for `crumple check`.
#[derive(Clone, Debug)]
pub struct AddedMesh {
    /// The file, as messages name it.
    pub file: String,
    /// Its format.
    pub format: &'static str,
    /// Number that was added to the ids of its parts.
    pub part_offset: u32,
    /// Number that was added to the ids of its nodes and elements.
    pub id_offset: u64,
    /// Ids of its parts in the file and in the job, and their names in the file.
    pub parts: Vec<(u32, u32, String)>,
    /// Names of node sets in the file and in the job, where they differ.
    pub renamed: Vec<(String, String)>,
    /// Table of its content.
    pub rows: Vec<ImportRow>,
}

/// Entities of a mesh that were added to another one.
pub(super) struct AddedRange {
    /// Path of the key that names the file.
    pub key: String,
    /// File and offsets, for messages.
    pub origin: String,
    /// Index of its first node.
    pub first_node: usize,
    /// Index of its first element.
    pub first_element: usize,
    /// Names of its node sets.
    pub sets: HashSet<String>,
}

/// Checks the numbers and names of all meshes that are added. Returns false if there is an error.
pub fn check(list: &[AddedMeshInput], findings: &mut JobProblems) -> bool {
    let mut is_good = true;
    for (index, added) in list.iter().enumerate() {
        let file = &added.file;
        let mut error = |key: &str, message: String, help: &str| {
            is_good = false;
            findings.add(Problem::error(format!("mesh.add.{index}.{key}"), message, help));
        };
        if file.is_empty() {
            error("file", "a mesh to add has no file".into(), "give the name of its file");
        }
        if added.scale <= 0.0 {
            let message = format!("mesh {file}: scale is {:?}", added.scale);
            let help = "give a factor above 0, such as 0.001 for a file in mm in a job in m; a \
                        negative one would turn elements inside out";
            error("scale", message, help);
        }
        if added.rotate.as_ref().is_some_and(|rotate| unit(rotate.axis).is_none()) {
            let message = format!("mesh {file}: the axis of its rotation has no direction");
            error("rotate.axis", message, "give a vector such as [0.0, 0.0, 1.0]");
        }
        if added.name.as_ref().is_some_and(String::is_empty) {
            let message = format!("mesh {file}: its name is empty");
            error("name", message, "give a name, or remove `name` for that of the file");
        }
    }
    is_good
}

/// Warns of parts whose shells have an offset in a mesh file and none in the job: ids in the file
/// and in the job, and the offset. The first argument is the file and the key that names it;
/// `listed` are the offsets of single shells that the job gives: a job with any has decided.
pub fn warn_of_offsets(
    (file, key): (&str, &str),
    offsets: impl Iterator<Item = (u32, u32, f64)>,
    listed: &[[f64; 2]],
    job: &Job,
    findings: &mut JobProblems,
) {
    for (of_file, id, offset) in offsets.filter(|_| listed.is_empty()) {
        let part = job.part.iter().find(|part| part.id == id);
        if part.is_none_or(|part| part.offset != 0.0) {
            continue;
        }
        let message = format!(
            "{file}: the shells of its part {of_file} have the offset {offset:?} over half the \
             thickness, and part {id} of the job has none"
        );
        let help = format!(
            "write offset = {offset:?} in the [[part]] with id = {id}; without it their nodes are \
             on the middle surface"
        );
        findings.add(Problem::warning(key, message, help));
    }
}

/// Returns the map of the points of an added mesh; `None` if its axis has no direction.
fn placement(added: &AddedMeshInput) -> Option<Affine> {
    let mut map = Affine::scale([added.scale; 3]);
    if let Some(rotate) = &added.rotate {
        map = map.then(&Affine::rotation(unit(rotate.axis)?, rotate.point, rotate.angle));
    }
    Some(map.then(&Affine::translation(added.shift)))
}

/// Returns the next multiple of `round` above a number; `None` if it is too large.
fn next_multiple(above: u64, round: u64) -> Option<u64> {
    (above / round).checked_add(1)?.checked_mul(round)
}

/// A mesh that is being added.
struct Addition<'a> {
    /// Its number in the job.
    index: usize,
    input: &'a AddedMeshInput,
    from: AddedFile,
    findings: &'a mut JobProblems,
}

impl PlacedMesh {
    /// Adds the mesh with this number in the job, with the ids, place and names that the job gives
    /// it. Reports errors and returns `None` if its ids or names are taken.
    pub fn add(
        &mut self,
        from: AddedFile,
        (index, input): (usize, &AddedMeshInput),
        job: &Job,
        findings: &mut JobProblems,
    ) -> Option<AddedMesh> {
        let mut addition = Addition { index, input, from, findings };
        let (ids, part_ids) = (addition.id_offset(&self.mesh), addition.part_offset(&self.mesh));
        let (map, id_offset, part_offset) = (placement(input)?, ids?, part_ids?);
        let names = addition.names(&self.mesh, part_offset, job)?;
        let AddedFile { file, format, mut mesh, parts, offsets, rows } = addition.from;
        let findings = addition.findings;
        mesh.elements.iter_mut().for_each(|element| element.own.thickness *= input.scale);
        OwnLists::of_added(index, input).assign(&mut mesh, &mut Few::new(findings));
        let key = format!("mesh.add.{index}.file");
        let offsets = offsets.into_iter().map(|(id, offset)| (id, id + part_offset, offset));
        warn_of_offsets((&file, &key), offsets, &input.offsets, job, findings);
        self.added.push(AddedRange {
            key,
            origin: format!("{file} (its ids + {id_offset}, those of its parts + {part_offset})"),
            first_node: self.mesh.nodes.len(),
            first_element: self.mesh.elements.len(),
            sets: names.values().cloned().collect(),
        });
        let node = |id: NodeId| NodeId(id.0 + id_offset);
        self.mesh.initial.extend(mesh.initial.iter().map(|point| InitialPoint {
            element: ElemId(point.element.0 + id_offset),
            // Turned only: the map stretches by the scale.
            stress: map.stress(point.stress).map(|s| s / (input.scale * input.scale)),
            ..*point
        }));
        let of_job = |id: u32| id + part_offset;
        let ids: BTreeSet<u32> = mesh.elements.iter().map(|e| e.part).collect();
        let nodes = mesh.nodes.iter();
        self.mesh.nodes.extend(nodes.map(|n| MeshNode { id: node(n.id), x: map.point(n.x) }));
        self.mesh.elements.extend(mesh.elements.iter().map(|e| MeshElement {
            id: ElemId(e.id.0 + id_offset),
            part: of_job(e.part),
            nodes: e.nodes.map(node),
            ..*e
        }));
        for (name, ids) in mesh.node_sets {
            self.mesh.node_sets.insert(names[&name].clone(), ids.into_iter().map(node).collect());
        }
        let name = |id: u32| parts.get(&id).cloned().unwrap_or_default();
        Some(AddedMesh {
            parts: ids.into_iter().map(|id| (id, of_job(id), name(id))).collect(),
            renamed: names.into_iter().filter(|(old, new)| old != new).collect(),
            file,
            format,
            part_offset,
            id_offset,
            rows,
        })
    }
}

impl Addition<'_> {
    fn error(&mut self, key: &str, message: String, help: String) {
        let message = format!("{}: {message}", self.from.file);
        let path = format!("mesh.add.{}.{key}", self.index);
        self.findings.add(Problem::error(path, message, help));
    }

    /// Returns the offset of nodes and elements. Reports an error and returns `None` if an id is
    /// taken or too large.
    fn id_offset(&mut self, mesh: &Mesh) -> Option<u64> {
        let ids = |mesh: &Mesh| -> Vec<u64> {
            let elements = mesh.elements.iter().map(|e| e.id.0);
            mesh.nodes.iter().map(|n| n.id.0).chain(elements).collect()
        };
        let free = next_multiple(ids(mesh).into_iter().max().unwrap_or(0), ROUND_IDS);
        let largest = ids(&self.from.mesh).into_iter().max().unwrap_or(0);
        let fits = |offset: &u64| {
            largest.checked_add(*offset).is_some_and(|largest| largest <= NodeId::LARGEST.0)
        };
        let cure = match free.filter(fits) {
            Some(free) => format!("remove id_offset, which is {free} then, or give another one"),
            None => "number the nodes and elements of both files with smaller ids".into(),
        };
        let Some(offset) = self.input.id_offset.or(free).filter(fits) else {
            let message = format!("its largest id {largest} with id_offset is above 9e15");
            self.error("id_offset", message, cure);
            return None;
        };
        if self.input.id_offset.is_none() {
            return Some(offset);
        }
        let nodes: HashSet<u64> = mesh.nodes.iter().map(|n| n.id.0).collect();
        let elements: HashSet<u64> = mesh.elements.iter().map(|e| e.id.0).collect();
        let own = &self.from.mesh;
        let taken = [
            ("node", taken(own.nodes.iter().map(|n| n.id.0), offset, &nodes)),
            ("element", taken(own.elements.iter().map(|e| e.id.0), offset, &elements)),
        ];
        let mut is_free = true;
        for (kind, (count, first)) in taken {
            let Some(first) = first else { continue };
            is_free = false;
            let message = format!(
                "with id_offset {offset}, {count} of its {kind}s have ids that the meshes before \
                 it have; the first is {kind} {first}, now {}",
                first + offset
            );
            self.error("id_offset", message, cure.clone());
        }
        is_free.then_some(offset)
    }

    /// Returns the offset of parts. Reports an error and returns `None` if an id is taken or too
    /// large.
    fn part_offset(&mut self, mesh: &Mesh) -> Option<u32> {
        let parts = |mesh: &Mesh| -> BTreeSet<u64> {
            mesh.elements.iter().map(|e| u64::from(e.part)).collect()
        };
        let (used, own) = (parts(mesh), parts(&self.from.mesh));
        let largest = own.last().copied().unwrap_or(0);
        let fits = |offset: &u64| largest + offset <= u64::from(u32::MAX);
        let free = next_multiple(used.last().copied().unwrap_or(0), ROUND_PARTS).filter(fits);
        let cure = match free {
            Some(free) => format!("remove part_offset, which is {free} then, or give another one"),
            None => "give a part_offset for which no part id is taken".into(),
        };
        let given = self.input.part_offset.map(u64::from);
        let Some(offset) = given.or(free).filter(fits) else {
            let message = format!("its part {largest} with part_offset is above {}", u32::MAX);
            self.error("part_offset", message, cure);
            return None;
        };
        if let Some(part) = own.iter().find(|part| used.contains(&(*part + offset))) {
            let message = format!(
                "with part_offset {offset}, its part {part} is part {}, which the meshes before it \
                 have",
                part + offset
            );
            self.error("part_offset", message, cure);
            return None;
        }
        u32::try_from(offset).ok()
    }

    /// Returns the names of its node sets in the job, by those in the file. Reports errors and
    /// returns `None` if one is taken in spite of the name before it.
    fn names(
        &mut self,
        mesh: &Mesh,
        part_offset: u32,
        job: &Job,
    ) -> Option<BTreeMap<String, String>> {
        let stem = || Path::new(&self.input.file).file_stem().unwrap_or_default().to_string_lossy();
        let before = self.input.name.clone().unwrap_or_else(|| stem().into_owned());
        let unnamed = self.from.parts.iter().filter(|(_, name)| name.is_empty());
        let of_parts: BTreeMap<String, String> = unnamed
            .map(|(id, _)| (format!("part_{id}"), format!("part_{}", id + part_offset)))
            .collect();
        // Every key that takes a node set takes the name of a part too.
        let used: HashSet<u32> = mesh.elements.iter().map(|e| e.part).collect();
        let parts = job.part.iter().filter(|part| used.contains(&part.id)).map(|part| &part.name);
        let others = parts.chain(job.set.iter().map(|set| &set.name));
        let mut taken: HashSet<String> = mesh.node_sets.keys().chain(others).cloned().collect();
        let mut names = BTreeMap::new();
        let mut doubled = Vec::new();
        for old in self.from.mesh.node_sets.keys() {
            let mut new = of_parts.get(old).unwrap_or(old).clone();
            if taken.contains(&new) {
                new = format!("{before}.{new}");
            }
            if !taken.insert(new.clone()) {
                doubled.push((old.clone(), new.clone()));
            }
            names.insert(old.clone(), new);
        }
        for (old, new) in &doubled {
            let message =
                format!("the names `{old}` and `{new}` for its node set `{old}` are both taken");
            self.error("name", message, "give it another `name`, which begins such names".into());
        }
        doubled.is_empty().then_some(names)
    }
}

/// Returns the number of ids that are taken with this offset, and the first one without it.
fn taken(ids: impl Iterator<Item = u64>, offset: u64, used: &HashSet<u64>) -> (usize, Option<u64>) {
    let mut taken = ids.filter(|id| used.contains(&(id + offset)));
    let first = taken.next();
    (usize::from(first.is_some()) + taken.count(), first)
}

#[cfg(test)]
mod tests {
    use crate::input::job::{Model, Report, read};
    use crumple_proto::ids::NodeId;
    use std::fs;
    use std::path::Path;

    /// A tetrahedron of four triangles: nodes 1 to 4, the first one at the origin.
    const STL: &str = "solid tip\nfacet\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\n\
        endloop\nendfacet\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\n\
        endfacet\nfacet\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n\
        facet\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n\
        endsolid tip\n";
    /// A mesh in TOML: a shell with a thickness of its own, and a beam.
    const ROWS: &str = "nodes = [[1, 0.0, 0.0, 0.0], [2, 2.0, 0.0, 0.0], [3, 2.0, 1.0, 0.0], \
        [4, 0.0, 1.0, 0.0], [5, 0.0, 0.0, 5.0]]\nshells = [[1, 7, 1, 2, 3, 4]]\n\
        beams = [[2, 8, 1, 2, 5]]\nthicknesses = [[1, 0.5]]\nnode_sets = { corner = [3] }\n";

    /// Returns a job of a plate (nodes 1 to 9, elements 1 to 4, part 1) and of shells in these
    /// parts, with these keys. Units mm, ms, kg.
    fn job(parts: &[u32], keys: &str) -> String {
        let part = |id: &u32| format!("[[part]]\nid = {id}\nmaterial = \"a\"\nthickness = 1.0\n");
        format!(
            "end_time = 1.0\n[[material]]\nname = \"a\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
             youngs_modulus = 207.0\npoisson = 0.3\n[[initial_velocity]]\n\
             velocity = [0.0, 0.0, 1.0]\n[scene]\nelements = 1\n[mesh]\n\
             generator = \"plate\"\n{}{keys}",
            [1].iter().chain(parts).map(part).collect::<String>()
        )
    }

    fn read_in(folder: &Path, files: &[(&str, &str)]) -> Result<Model, Report> {
        for (name, text) in files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        read(&folder.join("job.toml"), &[])
    }

    fn model_of(files: &[(&str, &str)]) -> Model {
        let folder = tempfile::tempdir().unwrap();
        read_in(folder.path(), files).unwrap_or_else(|report| panic!("{report}"))
    }

    fn report_of(files: &[(&str, &str)]) -> String {
        let folder = tempfile::tempdir().unwrap();
        read_in(folder.path(), files).map(|_| ()).unwrap_err().to_string()
    }

    fn labels(ids: &[NodeId]) -> Vec<u64> {
        ids.iter().map(|id| id.label()).collect()
    }

    /// Returns the coordinates of the node with this id in the job [length].
    fn place(model: &Model, id: u64) -> [f64; 3] {
        model.mesh.nodes.iter().find(|node| node.id.label() == id).expect("the node").x
    }

    fn assert_says(said: &str, wanted: &[&str]) {
        wanted.iter().for_each(|wanted| assert!(said.contains(wanted), "{wanted} not in {said}"));
    }

    /// Default offsets are the next multiples of 1000 and 1,000,000, also for a second copy of a
    /// file. Sets of the same name get the name of the mesh, and rules know the parts.
    #[test]
    fn ids_and_names_are_those_of_no_other_mesh() {
        let keys = "[[set]]\nname = \"low\"\nrule = \"nearest\"\npoint = [0.0, 0.0, 9.0]\n\
                    of = \"tip\"\n\
                    [[mesh.add]]\nfile = \"a.stl\"\nmove = [0.0, 0.0, 9.0]\n\
                    [[mesh.add]]\nfile = \"a.stl\"\nmove = [0.0, 0.0, 50.0]\n\
                    [[mesh.add]]\nfile = \"a.stl\"\nname = \"last\"\nmove = [0.0, 0.0, 90.0]\n\
                    part_offset = 50\nid_offset = 500\n";
        let text = job(&[1001, 2001, 51], keys);
        let model = model_of(&[("job.toml", &text), ("a.stl", STL)]);
        let mesh = &model.mesh;
        assert_eq!((mesh.nodes.len(), mesh.elements.len()), (9 + 3 * 4, 4 + 3 * 4));
        let elements = |part: u32| {
            let own = mesh.elements.iter().filter(|e| e.part == part);
            own.map(|e| e.id.label()).collect::<Vec<_>>()
        };
        assert_eq!(elements(2001), [2_000_001, 2_000_002, 2_000_003, 2_000_004]);
        assert_eq!(elements(51), [501, 502, 503, 504]);
        let set = |name: &str| labels(&mesh.node_sets[name]);
        assert_eq!(set("tip"), [1_000_001, 1_000_002, 1_000_003, 1_000_004]);
        assert_eq!(set("a.tip"), [2_000_001, 2_000_002, 2_000_003, 2_000_004]);
        assert_eq!((set("last.tip"), set("low")), (vec![501, 502, 503, 504], vec![1_000_001]));
        let said = crate::input::check::describe(&model);
        let first = "added mesh   a.stl: STL, part_offset 1000, id_offset 1000000\n  part 1 (tip) \
                     is part 1001\n";
        let others = [
            "added mesh   a.stl: STL, part_offset 2000, id_offset 2000000",
            "node set `tip` is `a.tip`",
            "added mesh   a.stl: STL, part_offset 50, id_offset 500",
            "node set `tip` is `last.tip`",
        ];
        assert_says(&said, &[&[first][..], &others].concat());
        assert_eq!(model.files().iter().filter(|file| file.ends_with("a.stl")).count(), 1);
    }

    /// Points are scaled, then turned about a line, then moved. Right angles are exact. Thicknesses
    /// of single shells are scaled, and second axes of beams turn with their nodes.
    #[test]
    fn a_mesh_is_scaled_then_turned_then_moved() {
        let keys = "[part.beam]\nsection = \"tube\"\nradius = 1.0\n[[mesh.add]]\n\
                    file = \"rows.toml\"\nscale = 10.0\nmove = [100.0, 0.0, 3.0]\n\
                    rotate = { axis = [0.0, 0.0, 2.0], angle = 90, point = [10.0, 0.0, 0.0] }\n";
        let text = job(&[1007, 1008], keys);
        // The part of beams has no thickness.
        let (head, tail) = text.split_at(text.find("id = 1008").unwrap());
        let text = format!("{head}{}", tail.replacen("thickness = 1.0\n", "", 1));
        let model = model_of(&[("job.toml", &text), ("rows.toml", ROWS)]);
        // About x = 10: from x = 0 to y = -10, from x = 20 to y = 10.
        assert_eq!(
            [1, 2, 3, 4].map(|id| place(&model, 1_000_000 + id)),
            [[110.0, -10.0, 3.0], [110.0, 10.0, 3.0], [100.0, 10.0, 3.0], [100.0, -10.0, 3.0]]
        );
        let shell = model.mesh.elements.iter().find(|e| e.id.label() == 1_000_001).unwrap();
        assert_eq!((shell.part, shell.own.thickness), (1007, 5.0));
        assert_eq!(labels(&model.mesh.node_sets["corner"]), [1_000_003]);
        let (beam, axis) = model.settings.axes[0];
        assert_eq!((beam.label(), axis), (1_000_002, [0.0, 0.0, 50.0]));
    }

    /// Values of single shells that the job gives for an added mesh are for the ids of its file.
    /// The same file without them keeps its own. Lengths of the job are not scaled.
    #[test]
    fn an_added_mesh_has_values_of_its_own_for_single_shells() {
        let beam = "[part.beam]\nsection = \"tube\"\nradius = 1.0\n";
        let keys = "[[mesh.add]]\nfile = \"rows.toml\"\nscale = 10.0\nmove = [9.0, 0.0, 3.0]\n\
                    thicknesses = [[1, 0.25]]\noffsets = [[1, -1.0]]\nangles = [[1, 30.0]]\n\
                    [[mesh.add]]\nfile = \"rows.toml\"\nscale = 10.0\nmove = [9.0, 0.0, 90.0]\n";
        let mut text = job(&[1007, 1008, 2007, 2008], "");
        // The parts of beams have no thickness.
        for id in ["id = 1008", "id = 2008"] {
            let (head, tail) = text.split_at(text.find(id).unwrap());
            text = format!("{head}{}", tail.replacen("thickness = 1.0\n", beam, 1));
        }
        let model = model_of(&[("job.toml", &(text + keys)), ("rows.toml", ROWS)]);
        let own = |id: u64| model.mesh.elements.iter().find(|e| e.id.label() == id).unwrap().own;
        let first = own(1_000_001);
        assert_eq!((first.thickness, first.offset, first.angle), (0.25, Some(-1.0), 30.0));
        let second = own(2_000_001);
        assert_eq!((second.thickness, second.offset, second.angle), (5.0, None, 0.0));
        // Element 1 of the plate has the same id as the shell in its file.
        let plate = own(1);
        assert_eq!((plate.thickness, plate.offset, plate.angle), (0.0, None, 0.0));
    }

    /// Rows that do not fit an added mesh name the file, the shell, the line and the cure.
    #[test]
    fn values_of_single_shells_fit_their_added_mesh() {
        let keys = "[[mesh.add]]\nfile = \"rows.toml\"\n\
                    thicknesses = [[1_000_001, 0.25], [1, 0.0]]\n\
                    offsets = [[2, 1.0], [1, 11.0]]\nangles = [[1, 5.0], [1, 6.0]]\n";
        let report = report_of(&[("job.toml", &job(&[], keys)), ("rows.toml", ROWS)]);
        assert_says(
            &report,
            &[
                "rows.toml: there is no element 1000001",
                "a row is [id of a shell, thickness]",
                "rows.toml: element 1: its thickness is 0.0",
                "rows.toml: element 2 is not a shell and has no offset",
                "rows.toml: element 1: its offset is 11.0",
                "rows.toml: element 1 is given an angle twice",
                "job.toml:",
            ],
        );
    }

    /// The nodes of an Abaqus plate are on its top face. A job whose part has no offset has a
    /// warning with the value to write, which is gone once it is written.
    #[test]
    fn an_offset_of_a_file_that_the_job_lacks_is_warned_of() {
        let plate = "*NODE\n1, 0., 0., 9.\n2, 1., 0., 9.\n3, 1., 1., 9.\n4, 0., 1., 9.\n\
                     *ELEMENT, TYPE=S4, ELSET=skin\n1, 1, 2, 3, 4\n\
                     *SHELL SECTION, ELSET=skin, OFFSET=SPOS\n0.5,\n";
        let warnings = |job: &str| {
            let model = model_of(&[("job.toml", job), ("plate.inp", plate)]);
            model.warnings.iter().map(|w| model.show(w).to_string()).collect::<String>()
        };
        let added = job(&[1001], "[[mesh.add]]\nfile = \"plate.inp\"\n");
        assert_says(
            &warnings(&added),
            &[
                "plate.inp: the shells of its part 1 have the offset -1.0 over half the thickness, \
                 and part 1001 of the job has none",
                "write offset = -1.0 in the [[part]] with id = 1001",
            ],
        );
        let given = added.replace("id = 1001\n", "id = 1001\noffset = -1.0\n");
        assert!(!warnings(&given).contains("have the offset"));
        let listed =
            added.replace("file = \"plate.inp\"\n", "file = \"plate.inp\"\noffsets = [[1, 0.0]]\n");
        assert!(!warnings(&listed).contains("have the offset"), "zero is meant");
        let (source, file) = ("generator = \"plate\"", "file = \"plate.inp\"");
        assert_says(
            &warnings(&job(&[], "").replace(source, file)),
            &["part 1 of the job has none"],
        );
    }

    /// All errors come at once, each with its line in the job, file, entity and cure.
    #[test]
    fn errors_of_added_meshes_come_at_once() {
        let keys = "[[mesh.add]]\nfile = \"a.stl\"\nid_offset = 0\npart_offset = 0\n\
                    [[mesh.add]]\nfile = \"gone.stl\"\n[[mesh.add]]\nfile = \"deck.k\"\n\
                    [[mesh.add]]\nfile = \"rows.toml\"\nscale = -1.0\nname = \"\"\n\
                    [[mesh.add]]\nfile = \"bad.stl\"\nrotate = { axis = [0, 0, 0], angle = 1 }\n";
        let report = report_of(&[
            ("job.toml", &job(&[], keys)),
            ("a.stl", STL),
            ("deck.k", "*KEYWORD\n*NODE\n1,0,0,0\n*END\n"),
            ("rows.toml", &ROWS.replace("[3, 2.0, 1.0, 0.0]", "[3, 2.0, 1.0]")),
            ("bad.stl", &STL.replacen("vertex", "vertix", 1)),
        ]);
        assert_says(
            &report,
            &[
                "a.stl: with id_offset 0, 4 of its nodes have ids that the meshes before it have; \
                 the first is node 1, now 1",
                "a.stl: with id_offset 0, 4 of its elements have ids",
                "remove id_offset, which is 1000000 then",
                "a.stl: with part_offset 0, its part 1 is part 1, which the meshes before it have",
                "remove part_offset, which is 1000 then",
                "gone.stl",
                "deck.k is a file of the format LS-DYNA keyword deck",
                "to which [[mesh.add]] adds other meshes",
                "mesh rows.toml: scale is -1.0",
                "mesh rows.toml: its name is empty",
                "rows.toml:1: an entry of `nodes` has to be a list of 4 finite numbers",
                "mesh bad.stl: the axis of its rotation has no direction",
                "bad.stl:4: `vertix 0 0 0`",
                "job.toml:",
            ],
        );
        assert!(report.matches(" = help: ").count() >= report.matches("error: ").count());
    }

    /// Names that stay taken, ids that are too large, an element that cannot be computed, and a
    /// part that the job lacks.
    #[test]
    fn entities_of_added_meshes_are_named() {
        let rows = ROWS.replace("corner", "rim");
        let keys = "[[mesh.add]]\nfile = \"rows.toml\"\nid_offset = 9_000_000_000_000_000\n\
                    part_offset = 4_294_967_290\n[[mesh.add]]\nfile = \"rows.toml\"\n\
                    [[mesh.add]]\nfile = \"rows.toml\"\n";
        let report = report_of(&[("job.toml", &job(&[], keys)), ("rows.toml", &rows)]);
        assert_says(
            &report,
            &[
                "rows.toml: its largest id 5 with id_offset is above 9e15",
                "rows.toml: its part 8 with part_offset is above 4294967295",
                "rows.toml: the names `rim` and `rows.rim` for its node set `rim` are both taken",
            ],
        );
        let flat =
            ROWS.replace("[4, 0.0, 1.0", "[4, 0.5, 0.0").replace("[3, 2.0, 1.0", "[3, 1.0, 0.0");
        let keys = "[[mesh.add]]\nfile = \"rows.toml\"\n";
        let report = report_of(&[("job.toml", &job(&[], keys)), ("rows.toml", &flat)]);
        assert_says(
            &report,
            &[
                "rows.toml (its ids + 1000000, those of its parts + 1000): element 1000001",
                "belongs to part 1007, which the job does not have",
                "add a [[part]] with id = 1007",
            ],
        );
    }

    /// An included job adds files next to itself. A mesh that takes the place of that of an
    /// included job is a warning that names both.
    #[test]
    fn included_jobs_add_meshes_and_lose_theirs_with_a_warning() {
        let base = job(&[1001], "[[mesh.add]]\nfile = \"a.stl\"\nmove = [0.0, 0.0, 9.0]\n");
        let include = "include = [\"parts/base.toml\"]\n";
        let warnings = |job: &str, base: &str| {
            let files = [("job.toml", job), ("parts/base.toml", base), ("parts/a.stl", STL)];
            let model = model_of(&[&files[..], &[("rows.toml", ROWS)]].concat());
            assert_eq!(model.added_meshes().len(), 1);
            model.warnings.iter().map(|w| model.show(w).to_string()).collect::<String>()
        };
        let said = warnings(include, &base);
        assert!(!said.contains("replaced"), "{said}");
        let same = format!("{include}[mesh]\ngenerator = \"plate\"\n");
        let said = warnings(&same, &base);
        assert!(!said.contains("replaced"), "{said}");

        let other = base.replace("generator = \"plate\"", "file = \"old.msh\"");
        let own = format!(
            "{include}[mesh]\nfile = \"rows.toml\"\n[[part]]\nid = 7\nmaterial = \"a\"\n\
             thickness = 1.0\n[[part]]\nid = 8\nmaterial = \"a\"\n[part.beam]\n\
             section = \"tube\"\nradius = 1.0\n"
        );
        let said = warnings(&own, &other);
        assert_says(
            &said,
            &[
                "mesh.file = \"parts/old.msh\" of ",
                "base.toml is replaced by mesh.file = \"rows.toml\": a job has one [mesh]",
                "job.toml:3:1",
                "name a file of them in a [[mesh.add]]",
            ],
        );
    }
}
