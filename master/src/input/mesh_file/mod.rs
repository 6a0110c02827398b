//! Mesh files of other programs: nodes, elements, parts, node sets and, where the format has them,
//! materials and sections.
//!
//! 1. [`FORMATS`]: the table of formats. A file is recognised by its content; its extension only
//!    gives a warning if it belongs to another format.
//! 2. one reader for each format: `gmsh`, `abaqus`, `nastran`, `vtk`, `stl`; EXODUS II is read by
//!    [`crate::input::exodus`]
//! 3. `reading.rs`: the file while it is read, its problems with their lines, the table of what
//!    became of its content; `content.rs`: what all readers return; `cells.rs`: types of cells;
//!    `boundary.rs`: elements that only bound others; `systems.rs`: coordinate systems of nodes;
//!    `signatures.rs`: signs of formats that are not read
//! 4. `import.rs`: `crumple import`, which writes a job for a mesh file
//!
//! No input may cause a panic here.

mod abaqus;
mod boundary;
mod cells;
mod content;
mod gmsh;
pub mod import;
mod nastran;
mod reading;
mod signatures;
mod stl;
pub mod systems;
mod vtk;

pub use content::{FileMaterial, FileMesh, FilePart, FileRate};
pub use reading::{Fate, ImportRow, table};

use crate::input::deck::{DeckFates, sniff};
use crate::input::{confine, deck, exodus};
use content::FilePlace;
use crumple_proto::problem::{Problem, Severity};
use reading::MeshReading;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Key of the job that names the file.
const KEY: &str = "mesh.file";

/// Name of the format of Abaqus.
pub const ABAQUS: &str = "Abaqus input";

/// A format of mesh files.
pub struct MeshFormat {
    /// Name.
    pub name: &'static str,
    /// Usual extensions, in lower case.
    pub extensions: &'static [&'static str],
    /// Returns true if a file with this begin and this length [byte] is of the format.
    recognises: fn(&[u8], usize) -> bool,
    reader: FormatReader,
}

/// Treatment of the files of a format.
enum FormatReader {
    /// Its bytes are read.
    Bytes(fn(&mut MeshReading, &[u8])),
    /// It is read by the reader of EXODUS II.
    Exodus,
    /// It is read by the reader of decks.
    Deck,
    /// It is not read; the cure.
    Refused(&'static str),
}

use FormatReader::{Bytes, Refused};

impl MeshFormat {
    /// Returns the cure for a file of a format that is not read.
    pub fn refusal(&self) -> Option<&'static str> {
        match self.reader {
            Refused(cure) => Some(cure),
            _ => None,
        }
    }
}

const fn refused(
    name: &'static str,
    extensions: &'static [&'static str],
    recognises: fn(&[u8], usize) -> bool,
    cure: &'static str,
) -> MeshFormat {
    MeshFormat { name, extensions, recognises, reader: Refused(cure) }
}

/// All formats. The first one that recognises a file reads it.
pub const FORMATS: &[MeshFormat] = &[
    MeshFormat {
        name: "Gmsh MSH",
        extensions: &["msh"],
        recognises: gmsh::recognises,
        reader: Bytes(gmsh::read),
    },
    refused(
        "LS-DYNA d3plot",
        &[],
        |head, _| signatures::is_d3plot(head),
        "it has results of a run: give its deck, or save the mesh in LS-PrePost as a keyword file",
    ),
    refused(
        "ParaView collection",
        &["pvd"],
        |head, _| {
            has_line(head, |line| line.contains("<VTKFile"))
                && has_line(head, |line| line.contains("<Collection"))
        },
        "it lists the files of all steps: give the .pvtu of a step, such as \
         fields/step_000010/fields.pvtu of a run",
    ),
    MeshFormat {
        name: "VTK XML",
        extensions: &["vtu", "vtp", "pvtu", "pvtp"],
        recognises: |head, _| has_line(head, |line| line.contains("<VTKFile")),
        reader: Bytes(vtk::read_xml),
    },
    MeshFormat {
        name: "VTK legacy",
        extensions: &["vtk"],
        recognises: |head, _| head.starts_with(b"# vtk DataFile"),
        reader: Bytes(vtk::read_legacy),
    },
    MeshFormat {
        name: "EXODUS II",
        extensions: &["g", "gen", "e", "ex2", "exo", "exodus"],
        recognises: |head, _| head.starts_with(b"CDF") || signatures::is_exodus_in_hdf5(head),
        reader: FormatReader::Exodus,
    },
    refused(
        "VTKHDF",
        &["vtkhdf"],
        |head, _| signatures::is_vtkhdf(head),
        "of a run of Crumple, give the .pvtu of a step, such as fields/step_000010/fields.pvtu; \
         save others in ParaView as .vtu",
    ),
    refused(
        "MED",
        &["med"],
        |head, _| signatures::is_med(head),
        "convert it, for example by Gmsh: gmsh FILE.med -save -o FILE.msh",
    ),
    refused(
        "CGNS",
        &["cgns"],
        |head, _| signatures::is_cgns(head),
        "convert it, for example by Gmsh: gmsh FILE.cgns -save -o FILE.msh",
    ),
    refused(
        "HDF5 with other content than EXODUS II, VTKHDF, MED or CGNS",
        &["h5", "hdf5"],
        |head, _| signatures::is_hdf5(head),
        "export the mesh again, for example as .msh or .vtu; if an .xdmf file belongs to it, \
         convert that: meshio convert FILE.xdmf FILE.vtu",
    ),
    refused(
        "XDMF",
        &["xdmf", "xmf"],
        |head, _| has_line(head, |line| line.contains("<Xdmf")),
        "convert it, for example by the Python package meshio: meshio convert FILE.xdmf FILE.vtu",
    ),
    refused(
        "LS-DYNA keyword deck",
        &["k", "key", "dyn"],
        |head, _| sniff::is_ls_dyna(head),
        "name it by mesh.deck of a job, to which [[mesh.add]] adds other meshes; or run it as it \
         is, under a name that ends in .k, .key or .dyn: crumple run FILE.k",
    ),
    MeshFormat {
        name: "Radioss starter",
        extensions: &["rad"],
        recognises: |head, _| sniff::is_radioss(head),
        reader: FormatReader::Deck,
    },
    refused(
        "STEP geometry",
        &["step", "stp"],
        |head, _| head.starts_with(b"ISO-10303-21"),
        "it has geometry and no mesh: mesh it, for example in Gmsh, and give the file of the mesh",
    ),
    refused(
        "Gmsh geometry",
        &["geo"],
        |head, _| has_line(head, |line| line.starts_with("Point(") || line.contains("OpenCASCADE")),
        "mesh it and give the file of the mesh: gmsh FILE.geo -2 -o FILE.msh",
    ),
    refused(
        "PLY",
        &["ply"],
        |head, _| head.starts_with(b"ply\n") || head.starts_with(b"ply\r"),
        "export the surface as STL",
    ),
    refused(
        "Wavefront OBJ",
        &["obj"],
        |head, _| signatures::is_obj(head),
        "export the surface as STL",
    ),
    refused("OFF", &["off"], |head, _| signatures::is_off(head), "export the surface as STL"),
    refused(
        "I-DEAS universal file",
        &["unv"],
        |head, _| has_line(head, |line| line.trim() == "2411" || line.trim() == "2412"),
        "convert it, for example by Gmsh: gmsh FILE.unv -save -o FILE.msh",
    ),
    refused(
        "Medit",
        // Own mesh files in TOML may have the extension .mesh too.
        &["meshb"],
        |head, _| has_line(head, |line| line.trim_start().starts_with("MeshVersionFormatted")),
        "convert it, for example by Gmsh: gmsh FILE.mesh -save -o FILE.msh",
    ),
    refused(
        "ANSYS CDB",
        &["cdb"],
        |head, _| {
            has_line(head, |line| {
                let line = line.trim_start().to_uppercase();
                ["NBLOCK,", "EBLOCK,", "/PREP7"].iter().any(|word| line.starts_with(word))
            })
        },
        "convert it, for example by the Python package mapdl-archive: \
         mapdl_archive.Archive(\"FILE.cdb\").grid.save(\"FILE.vtu\")",
    ),
    MeshFormat {
        name: ABAQUS,
        extensions: &["inp"],
        recognises: abaqus::recognises,
        reader: Bytes(abaqus::read),
    },
    MeshFormat {
        name: "Nastran bulk data",
        extensions: &["bdf", "nas", "dat", "fem", "blk"],
        recognises: nastran::recognises,
        reader: Bytes(nastran::read),
    },
    MeshFormat {
        name: "STL",
        extensions: &["stl"],
        recognises: stl::recognises,
        reader: Bytes(stl::read),
    },
];

/// Number of bytes at the begin of a file by which it is recognised.
const HEAD: usize = 64 * 1024;

/// Returns true if a line of text fits.
fn has_line(head: &[u8], fits: impl Fn(&str) -> bool) -> bool {
    head.split(|&b| b == b'\n')
        .any(|line| std::str::from_utf8(line).is_ok_and(|line| fits(line.trim_end_matches('\r'))))
}

/// Returns the begin of a text, for a message.
fn shortened(text: &str) -> String {
    text.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A mesh file that was read.
pub struct ReadMesh {
    /// Its format.
    pub format: &'static MeshFormat,
    /// Its content.
    pub mesh: FileMesh,
    /// Table of its content.
    pub rows: Vec<ImportRow>,
    /// Warnings.
    pub warnings: Vec<Problem>,
    /// The file, and those that it includes.
    pub files: Vec<PathBuf>,
    /// For a deck: what becomes of its content in a job that names it by `mesh.deck`.
    pub deck: Option<DeckFates>,
}

/// Returns the part of a file by which it is recognised: its begin, and all of an HDF5 file, whose
/// names may be anywhere.
fn signature_of(bytes: &[u8]) -> &[u8] {
    let length = if signatures::is_hdf5(bytes) { bytes.len() } else { bytes.len().min(HEAD) };
    &bytes[..length]
}

/// Returns the format of a file by its begin and its length [byte]; `None` if none fits.
pub fn format_of(head: &[u8], length: usize) -> Option<&'static MeshFormat> {
    FORMATS.iter().find(|format| (format.recognises)(head, length))
}

/// Returns true if a file is one of Crumple's own mesh files in TOML, by its content.
fn is_toml(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head).into_owned();
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    first.is_none_or(|line| line.starts_with('[') || line.contains('='))
}

/// Returns true if `mesh.file` is to be read as TOML: by its extension, or by its content.
pub fn is_own_format(path: &Path) -> bool {
    let extension = extension(path);
    if extension == "toml" {
        return true;
    }
    if confine::check(path).is_err() || format_by(&extension).is_some() {
        return false;
    }
    let head = || -> std::io::Result<(Vec<u8>, u64)> {
        let file = std::fs::File::open(path)?;
        let length = file.metadata()?.len();
        let mut head = Vec::new();
        file.take(HEAD as u64).read_to_end(&mut head)?;
        Ok((head, length))
    };
    head().is_ok_and(|(head, length)| format_of(&head, length as usize).is_none() && is_toml(&head))
}

/// Returns true if there is a format with this extension, in small letters.
pub fn reads(extension: &str) -> bool {
    format_by(extension).is_some()
}

/// Returns the format that an extension is for.
fn format_by(extension: &str) -> Option<&'static MeshFormat> {
    FORMATS.iter().find(|format| format.extensions.contains(&extension))
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Returns the problem of a case that is chosen for a mesh without cases.
pub fn without_cases(case: u64) -> Problem {
    let message = format!("case {case} is chosen, and the mesh is not from a deck with cases");
    Problem::error("mesh.case", message, "remove --case, and mesh.case from the job")
}

/// Reads a mesh file. With `allowed`, what is not supported is left out; `case` is that of a deck.
///
/// # Errors
/// All problems: the file cannot be read, is of no known format, or its content is faulty.
pub fn read(path: &Path, allowed: bool, case: Option<u64>) -> Result<ReadMesh, Vec<Problem>> {
    let shown = path.display();
    let one = |message: String, help: &str| vec![Problem::error(KEY, message, help)];
    let found = confine::check(path).and_then(|()| std::fs::read(path));
    let bytes = found.map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            one(format!("there is no file {shown}"), "correct the path")
        }
        _ if path.is_dir() => one(format!("{shown} is a folder"), "name a mesh file in it"),
        _ => one(format!("{shown} cannot be read: {error}"), "check its name and permissions"),
    })?;
    let Some(format) = format_of(signature_of(&bytes), bytes.len()) else {
        let (message, help) = unknown(path, bytes.is_empty());
        return Err(one(message, &help));
    };
    let mut reading = MeshReading::new(path, allowed);
    warn_of_extension(&mut reading, format, path);
    if let Some(case) = case.filter(|_| !matches!(format.reader, FormatReader::Deck | Refused(_))) {
        return Err(vec![without_cases(case)]);
    }
    let mut deck = None;
    match format.reader {
        Bytes(reader) => reader(&mut reading, &bytes),
        FormatReader::Exodus => match exodus::read_with_names(path) {
            Ok((mesh, names)) => {
                reading.mesh = FileMesh::from_mesh(&mesh);
                for part in &mut reading.mesh.parts {
                    part.name = names.get(&part.id).cloned().unwrap_or_default();
                }
            }
            Err(problems) => {
                return Err(problems
                    .into_iter()
                    .map(|p| Problem { path: KEY.into(), ..p })
                    .collect());
            }
        },
        FormatReader::Deck => deck = Some(read_deck(&mut reading, path, case)?),
        Refused(cure) => {
            let message = format!("{shown} is a file of the format {}", format.name);
            return Err(one(message, cure));
        }
    }
    reading.finish();
    if reading.has_errors() {
        return Err(reading.into_problems());
    }
    let (mesh, rows) = (std::mem::take(&mut reading.mesh), std::mem::take(&mut reading.rows));
    let files = std::mem::take(&mut reading.files);
    let warnings = reading.into_problems();
    debug_assert!(warnings.iter().all(|w| w.severity == Severity::Warning));
    Ok(ReadMesh { format, mesh, rows, warnings, files, deck })
}

/// Reads the mesh of a deck: nodes, elements and groups of nodes. Returns what became of the deck.
fn read_deck(
    reading: &mut MeshReading,
    path: &Path,
    case: Option<u64>,
) -> Result<DeckFates, Vec<Problem>> {
    let allow_unsupported = reading.allowed;
    let choice = deck::DeckChoice { allow_unsupported, case, ..deck::DeckChoice::default() };
    let found = deck::mesh_of(path, &choice)?;
    reading.mesh = FileMesh::from_mesh(&found.mesh);
    reading.mesh.units = found.units;
    for (id, name) in found.parts {
        let part = reading.mesh.part_with_id(id, &name);
        reading.mesh.parts[part].name = name;
    }
    reading.files = found.files;
    let mut table = found.table;
    table.rows.splice(0..0, reading.summary());
    Ok(table)
}

/// Warns if the extension of a file is that of another format.
fn warn_of_extension(reading: &mut MeshReading, format: &MeshFormat, path: &Path) {
    let extension = extension(path);
    if let Some(other) = format_by(&extension).filter(|other| !std::ptr::eq(*other, format)) {
        let message = format!(
            "it is a file of the format {}, by its content; `.{extension}` is for {}",
            format.name, other.name
        );
        let usual = format.extensions.first().copied().unwrap_or_default();
        let help = format!("rename it: {} has .{usual}", format.name);
        reading.warning(FilePlace::default(), message, help);
    }
}

/// Returns message and help for a file of no known format.
fn unknown(path: &Path, empty: bool) -> (String, String) {
    let (shown, extension) = (path.display(), extension(path));
    let names: Vec<String> = FORMATS
        .iter()
        .filter(|f| !matches!(f.reader, Refused(_)))
        .map(|f| format!("{} (.{})", f.name, f.extensions.join(", .")))
        .collect();
    let message = match format_by(&extension) {
        _ if empty => format!("{shown} is empty"),
        Some(format) => format!("{shown} is no file of the format {} (.{extension})", format.name),
        None => format!("the format of {shown} is not known"),
    };
    (message, format!("export the mesh again, in one of these formats: {}", names.join("; ")))
}

/// Helps the tests of readers.
#[cfg(test)]
mod testing {
    use super::content::FileMesh;
    use super::reading::MeshReading;
    use std::path::Path;

    fn reading(reader: fn(&mut MeshReading, &[u8]), text: &str) -> MeshReading {
        let mut reading = MeshReading::new(Path::new("file"), false);
        reader(&mut reading, text.as_bytes());
        reading.finish();
        reading
    }

    /// Returns the mesh of a text without errors.
    pub fn mesh_of(reader: fn(&mut MeshReading, &[u8]), text: &str) -> FileMesh {
        let reading = reading(reader, text);
        let mesh = reading.mesh.clone();
        assert!(!reading.has_errors(), "{:?}\n{text}", reading.into_problems());
        mesh
    }

    /// Returns the messages of a text with errors. Each has a cure.
    pub fn errors_of(reader: fn(&mut MeshReading, &[u8]), text: &str) -> Vec<String> {
        let reading = reading(reader, text);
        assert!(reading.has_errors(), "it is read:\n{text}");
        let problems = reading.into_problems();
        assert!(problems.iter().all(|problem| !problem.help.is_empty()), "{problems:?}");
        problems.into_iter().map(|problem| problem.message).collect()
    }
}
