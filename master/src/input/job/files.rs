//! Files of a job: the job file itself, and the mesh from a generator, a file, a deck or the job.

use super::report::SourceFile;
use super::tree::{Node, Place};
use super::validate::JobProblems;
use super::{SourceFiles, mesh, validate};
use crate::input::{confine, deck, mesh_file};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, MeshSource};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::path::{Path, PathBuf};

/// Remedy for a file that a job names and that is not there.
const MISSING: &str = "correct the name, or put the file there; a job for a service needs all \
                       files that it names: crumple submit JOB FILE ..., or its whole folder";
/// Largest job or mesh file that is read [byte], because places in it have 32 bits.
const LARGEST_FILE: u64 = u32::MAX as u64;

/// Reads the mesh from the source that the job names. Reports errors and returns `None` if there
/// is no mesh to check.
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
        mesh::PlacedMesh::of_deck(mesh, deck.lists)
    } else if !check_sources(given, count, findings) {
        return None;
    } else if let Some(file) = &given.file {
        let file = in_folder(file);
        if mesh_file::is_own_format(&file) {
            return read_toml_mesh(given, &file, sources, findings);
        }
        let mut mesh = read_foreign_mesh(&file, given, sources, findings)?;
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
    let own = [&given.thicknesses[..], &given.offsets, &given.angles];
    Some(mesh::with_own_sections(read, own, findings))
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
             mesh.shells or mesh.solids"
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

/// Reads a mesh file of another program. Reports errors and returns `None` if it is faulty.
fn read_foreign_mesh(
    file: &Path,
    given: &MeshSource,
    sources: &mut SourceFiles,
    findings: &mut JobProblems,
) -> Option<Mesh> {
    match mesh_file::read(file, given.allow_unsupported, given.case) {
        Ok(read) => {
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
    let MeshSource { thicknesses, offsets, angles, .. } = given;
    if !check_own_sets(given, findings) {
        return None;
    }
    let lists =
        [("mesh.thicknesses", thicknesses), ("mesh.offsets", offsets), ("mesh.angles", angles)];
    if let Some((key, _)) = lists.into_iter().find(|(_, list)| !list.is_empty()) {
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
    let tree = parsed.as_ref().cloned().unwrap_or_else(|_| Node::table(Place::Whole));
    sources.mesh = Some(SourceFile { file: file.display().to_string(), text, tree });
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
