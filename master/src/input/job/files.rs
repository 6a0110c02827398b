//! Files of a job: the job file itself, the mesh from a generator, a file, a deck or the job, and
//! the meshes that are added to it.

use super::mesh::added::{self, AddedFile};
use super::report::{PlacedProblem, SourceFile};
use super::tree::{Node, Place, SyntaxError};
use super::validate::JobProblems;
use super::{SourceFiles, mesh, validate};
use crate::input::mesh_file::FileMesh;
use crate::input::{confine, deck, mesh_file};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{AddedMeshInput, Job, MeshSource};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::path::{Path, PathBuf};

/// Remedy for a file that a job names and that is not there.
const MISSING: &str = "correct the name, or put the file there; a job for a service needs all \
                       files that it names: crumple submit JOB FILE ..., or its whole folder";
/// Largest job or mesh file that is read [byte], because places in it have 32 bits.
const LARGEST_FILE: u64 = u32::MAX as u64;

/// Reads the mesh from the source that the job names, and the meshes that it adds. Reports errors
/// and returns `None` if there is no mesh to check.
pub(super) fn read_mesh(
    job: &Job,
    path: &Path,
    deck: Option<deck::Deck>,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<mesh::PlacedMesh> {
    if findings.any_faulty_below("mesh") {
        return None;
    }
    let first = read_first(job, path, deck, sources, findings);
    let list = &job.mesh.add;
    let mut is_whole = added::check(list, findings);
    let read = |(index, input)| read_added(&job.mesh, (index, input), path, sources, findings);
    let read: Vec<Option<AddedFile>> = list.iter().enumerate().map(read).collect();
    let mut mesh = first?;
    for (file, of) in read.into_iter().zip(list.iter().enumerate()) {
        match file.and_then(|file| mesh.add(file, of, job, findings)) {
            Some(added) => sources.added.push(added),
            None => is_whole = false,
        }
    }
    is_whole.then_some(mesh)
}

/// Reads the mesh from the source that the job names, without those that are added to it.
fn read_first(
    job: &Job,
    path: &Path,
    deck: Option<deck::Deck>,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<mesh::PlacedMesh> {
    let given = &job.mesh;
    let own_sets = || {
        let own = given.node_sets.iter();
        own.map(|(name, ids)| (name.clone(), ids.iter().copied().map(NodeId).collect()))
    };
    let in_folder = |name: &String| path.parent().unwrap_or(Path::new("")).join(name);
    let count = count_sources(given);
    let foreign = given.file.as_ref().filter(|file| !mesh_file::is_own_format(&in_folder(file)));
    if let Some(case) = given.case.filter(|_| given.deck.is_none() && foreign.is_none()) {
        findings.add(mesh_file::without_cases(case));
    }
    let read = if let Some(deck) = deck.filter(|_| count == 0) {
        let mut mesh = deck.mesh;
        mesh.node_sets.extend(own_sets());
        mesh::PlacedMesh::of_deck(mesh, deck.lists, deck.stand_ins)
    } else if !check_sources(given, count, findings) {
        return None;
    } else if let Some(file) = &given.file {
        let file = in_folder(file);
        if mesh_file::is_own_format(&file) {
            return read_toml_mesh(given, &file, sources, findings);
        }
        let mut mesh = read_foreign_mesh(&file, job, sources, findings)?;
        mesh.node_sets.extend(own_sets());
        mesh::PlacedMesh::elsewhere(mesh, "mesh.file")
    } else if let Some(generator) = &given.generator {
        mesh::generate(generator, job, findings)?
    } else if let Some(exodus) = &given.exodus {
        sources.mesh_files = vec![in_folder(exodus)];
        match crate::input::exodus::read(&in_folder(exodus)) {
            Ok(mut mesh) => {
                mesh.node_sets.extend(own_sets());
                mesh::PlacedMesh::elsewhere(mesh, "mesh.exodus")
            }
            Err(problems) => {
                problems.into_iter().for_each(|problem| findings.add(problem));
                return None;
            }
        }
    } else {
        return mesh::from_rows(given, findings);
    };
    Some(mesh::with_own_sections(read, &mesh::OwnLists::of(given), findings))
}

/// Returns the number of meshes that the job gives without a deck.
fn count_sources(given: &MeshSource) -> usize {
    let MeshSource { nodes, shells, solids, beams, springs, trusses, particles, .. } = given;
    let has_rows = !(nodes.is_empty()
        && shells.is_empty()
        && solids.is_empty()
        && beams.is_empty()
        && springs.is_empty()
        && trusses.is_empty()
        && particles.is_empty());
    let sources =
        [given.generator.is_some(), given.file.is_some(), given.exodus.is_some(), has_rows];
    sources.iter().filter(|&&given| given).count()
}

/// Reports a job without a mesh or with several, and keys that its mesh cannot have. Returns false
/// if there is an error.
fn check_sources(given: &MeshSource, count: usize, findings: &mut JobProblems) -> bool {
    if count != 1 {
        let (message, one) = match count {
            0 => ("the job has no mesh", "give"),
            _ => ("the job has more than one mesh", "give one of"),
        };
        let help = format!(
            "{one} mesh.generator, mesh.file, mesh.deck, mesh.exodus, or mesh.nodes with \
             mesh.shells or mesh.solids; [[mesh.add]] adds further mesh files to it"
        );
        findings.add(Problem::error("mesh", message, help));
        return false;
    }
    given.generator.is_none() || check_own_sets(given, findings)
}

/// Reports node sets of a job whose mesh defines its own. Returns false if there is an error.
fn check_own_sets(given: &MeshSource, findings: &mut JobProblems) -> bool {
    if !given.node_sets.is_empty() {
        findings.add(Problem::error(
            "mesh.node_sets",
            "mesh.node_sets is for mesh.nodes, meshes of other programs or a deck only",
            "remove them: a generator or a mesh file in TOML defines its own node sets",
        ));
    }
    given.node_sets.is_empty()
}

/// Returns the ids and offsets of the parts of a mesh file that have an offset.
fn offsets_of(mesh: &FileMesh) -> Vec<(u32, f64)> {
    mesh.parts.iter().filter_map(|part| Some((part.id, part.offset?))).collect()
}

/// Reads a mesh file of another program. Reports errors and returns `None` if it is faulty.
fn read_foreign_mesh(
    file: &Path,
    job: &Job,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<Mesh> {
    match mesh_file::read(file, job.mesh.allow_unsupported, job.mesh.case) {
        Ok(read) => {
            let shown = file.display().to_string();
            let offsets = offsets_of(&read.mesh).into_iter().map(|(id, offset)| (id, id, offset));
            let listed = &job.mesh.offsets;
            added::warn_of_offsets((&shown, "mesh.file"), offsets, listed, job, findings);
            sources.mesh_rows = read.rows;
            sources.mesh_files = read.files;
            read.warnings.into_iter().for_each(|warning| findings.add(warning));
            if read.deck.is_some() {
                let message = format!(
                    "{}: materials, properties, loads and interfaces of the deck are not read",
                    file.display()
                );
                let help = "name the file by mesh.deck instead, and they are those of the job";
                findings.add(Problem::warning("mesh.file", message, help));
            }
            Some(read.mesh.to_mesh())
        }
        Err(problems) => {
            problems.into_iter().for_each(|problem| findings.add(problem));
            None
        }
    }
}

fn read_toml_mesh(
    given: &MeshSource,
    file: &Path,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<mesh::PlacedMesh> {
    let MeshSource { thicknesses, offsets, angles, stresses, .. } = given;
    if !check_own_sets(given, findings) {
        return None;
    }
    let lists = [
        ("mesh.thicknesses", !thicknesses.is_empty()),
        ("mesh.offsets", !offsets.is_empty()),
        ("mesh.angles", !angles.is_empty()),
        ("mesh.stresses", !stresses.is_empty()),
    ];
    if let Some((key, _)) = lists.into_iter().find(|(_, given)| *given) {
        let message = format!("{key} is not for a mesh file in TOML");
        findings.add(Problem::error(key, message, "write them in the mesh file"));
        return None;
    }
    let text = match load(file) {
        Ok(text) => text,
        Err(problem) => {
            findings.add(Problem { path: "mesh.file".into(), ..problem });
            return None;
        }
    };
    sources.mesh_files = vec![file.to_owned()];
    let parsed = Node::parse(&text);
    sources.mesh = Some(source_of(file, text, &parsed));
    rows_of(parsed, findings)
}

/// Returns a mesh file in TOML as a source of problems.
fn source_of(file: &Path, text: String, parsed: &Result<Node, Vec<SyntaxError>>) -> SourceFile {
    let tree = parsed.as_ref().cloned().unwrap_or_else(|_| Node::table(Place::Whole));
    SourceFile { file: file.display().to_string(), text, tree }
}

/// Returns the mesh of a file in TOML. Reports errors and returns `None` if it is faulty.
fn rows_of(
    parsed: Result<Node, Vec<SyntaxError>>,
    findings: &mut JobProblems,
) -> Option<mesh::PlacedMesh> {
    let mut tree = match parsed {
        Ok(tree) => tree,
        Err(errors) => {
            validate::mesh_file_syntax(errors, findings);
            return None;
        }
    };
    validate::mesh_file(&mut tree, findings);
    if findings.any_faulty_below("mesh") {
        return None;
    }
    match tree.to_value().try_into::<MeshSource>() {
        Ok(source) => mesh::from_rows(&source, findings),
        Err(error) => {
            findings.add(Problem::error("mesh", error.message(), "correct the mesh file"));
            None
        }
    }
}

/// Reads a mesh that the job adds. Reports errors and returns `None` if it is faulty.
fn read_added(
    given: &MeshSource,
    (index, input): (usize, &AddedMeshInput),
    path: &Path,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<AddedFile> {
    let key = format!("mesh.add.{index}.file");
    let path = path.parent().unwrap_or(Path::new("")).join(&input.file);
    let file = input.file.clone();
    let mut add = |problem: Problem| findings.add(Problem { path: key.clone(), ..problem });
    if mesh_file::is_own_format(&path) {
        sources.mesh_files.push(path.clone());
        let mesh = added_rows(&path, add)?;
        let (parts, offsets, rows) = Default::default();
        return Some(AddedFile { file, format: "TOML", mesh, parts, offsets, rows });
    }
    match mesh_file::read(&path, given.allow_unsupported, None) {
        Ok(read) => {
            sources.mesh_files.extend(read.files);
            read.warnings.into_iter().for_each(&mut add);
            if read.deck.is_some() {
                let message = format!(
                    "{file}: materials, properties, loads and interfaces of the deck are not read"
                );
                let help = "write them in the job, or name this file by mesh.deck and add the \
                            other one to it";
                add(Problem::warning("", message, help));
            }
            let parts = read.mesh.parts.iter().map(|part| (part.id, part.name.clone())).collect();
            let offsets = offsets_of(&read.mesh);
            let (format, mesh) = (read.format.name, read.mesh.to_mesh());
            Some(AddedFile { file, format, mesh, parts, offsets, rows: read.rows })
        }
        Err(problems) => {
            problems.into_iter().for_each(add);
            None
        }
    }
}

/// Reads a mesh in TOML that the job adds. Its problems name the line in this file.
fn added_rows(path: &Path, mut add: impl FnMut(Problem)) -> Option<Mesh> {
    let text = load(path).map_err(&mut add).ok()?;
    let parsed = Node::parse(&text);
    let source = source_of(path, text, &parsed);
    let mut found = JobProblems::default();
    let mesh = rows_of(parsed, &mut found);
    for PlacedProblem { problem, place, .. } in found.list {
        let below = problem.path.strip_prefix("mesh.").unwrap_or_default();
        let line = source.line(place.unwrap_or_else(|| source.tree.locate(below)));
        let message = format!("{}:{line}: {}", source.file, problem.message);
        add(Problem { message, ..problem });
    }
    mesh.map(|placed| placed.mesh)
}

/// Returns the job file for a path of the command line.
pub(super) fn job_file(path: &Path) -> Result<PathBuf, Problem> {
    let shown = path.display();
    if let Err(error) = confine::check(path) {
        return Err(Problem::error("", error.to_string(), "name a file in that folder"));
    }
    if path.is_dir() {
        let inside = path.join("job.toml");
        if inside.is_file() {
            return Ok(inside);
        }
        return Err(Problem::error(
            "",
            format!("the folder {shown} holds no job.toml"),
            "name a job file, or a folder with one",
        ));
    }
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        _ if !path.exists() => {
            let help =
                "name a .toml job file, a .k or _0000.rad deck, or a folder that holds job.toml";
            Err(Problem::error("", format!("there is no file {shown}"), help))
        }
        "toml" | "k" | "key" | "dyn" | "rad" => Ok(path.to_path_buf()),
        known if mesh_file::reads(known) => match deck::sniff::of_file(path) {
            Some(format) => {
                let (name, ending) = format.names();
                let message = format!("{shown} is {name}, by its content");
                Err(Problem::error("", message, format!("rename it so that it ends in {ending}")))
            }
            None => Err(Problem::error(
                "",
                format!("{shown} is a mesh file, not a job"),
                "write a job for it: crumple import FILE --out FOLDER, then crumple run FOLDER",
            )),
        },
        _ => Err(Problem::error(
            "",
            format!("{shown} is not a .toml file"),
            "name a .toml file, a .k, .key, .dyn or _0000.rad deck, or a folder with job.toml",
        )),
    }
}

pub(super) fn load(path: &Path) -> Result<String, Problem> {
    let shown = path.display();
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            Problem::error("", format!("there is no file {shown}"), MISSING)
        }
        _ => Problem::error(
            "",
            format!("{shown} cannot be read: {error}"),
            "check its name and permissions",
        ),
    };
    confine::check(path).map_err(cannot)?;
    let length = std::fs::metadata(path).map_err(cannot)?.len();
    if length > LARGEST_FILE {
        return Err(Problem::error("", format!("{shown} is larger than 4 GiB"), "split the model"));
    }
    let bytes = std::fs::read(path).map_err(cannot)?;
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..good].iter().filter(|&&b| b == b'\n').count();
        Problem::error("", format!("{shown}:{line}: not UTF-8 text"), "save the file as UTF-8")
    })
}
