//! Field files of runs as meshes: pieces of several workers, and of other programs that run in
//! parallel (`.pvtu`).

use crumple::input::job;
use crumple::input::mesh_file::{Fate, FileMesh, ReadMesh, read};
use crumple_tests::program::{crumple_with, root, run};
use std::fs;
use std::path::{Path, PathBuf};

/// The job of a plate of shells and a sphere of shells, in a folder of its own, imported from Gmsh.
struct ImportedModel {
    folder: tempfile::TempDir,
}

impl ImportedModel {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let job = folder.path().join("job");
        let words = [
            "import",
            "cases/examples/gmsh-sphere/plate-and-sphere.msh",
            "--out",
            job.to_str().unwrap(),
        ];
        run(crumple_with(&words)).with_code(0);
        Self { folder }
    }

    /// Returns the mesh of the job as its run has it.
    fn model(&self) -> job::Model {
        let job = self.folder.path().join("job");
        job::read(&job, &[]).unwrap_or_else(|report| panic!("{report}"))
    }

    /// Runs the job with some workers; returns the folder of its first field files.
    fn fields(&self, workers: usize) -> PathBuf {
        let out = self.folder.path().join(format!("out-{workers}"));
        let job = self.folder.path().join("job");
        let workers = format!("parallel.workers={workers}");
        let words = ["run", job.to_str().unwrap(), "--no-report", "--out", out.to_str().unwrap()];
        let sets =
            ["--set", "time.max_cycles=2", "--set", "contact.friction=0.1", "--set", &workers];
        run(crumple_with(&[&words[..], &sets].concat())).with_code(0);
        out.join("fields/step_000000")
    }
}

fn good(path: &Path) -> ReadMesh {
    read(path, false, None).unwrap_or_else(|problems| panic!("{}: {problems:?}", path.display()))
}

fn message(path: &Path) -> String {
    let problems = read(path, false, None).err().unwrap_or_else(|| panic!("{}", path.display()));
    assert!(problems.iter().all(|problem| !problem.help.is_empty()), "{problems:?}");
    problems[0].message.clone()
}

/// Returns everything of a mesh that a job gets.
fn whole(mesh: &FileMesh) -> String {
    let nodes: Vec<_> = mesh.nodes.iter().map(|node| (node.id, node.x)).collect();
    let elements: Vec<_> = mesh
        .elements
        .iter()
        .map(|e| (e.id, mesh.parts[e.part].id, e.shape, e.corners.clone()))
        .collect();
    format!("{nodes:?}\n{elements:?}\n{:?}", mesh.node_sets)
}

/// The fields of one worker have the nodes, elements and parts of the job. Coordinates are those of
/// the job in single precision, as fields have them.
#[test]
fn fields_of_one_worker_come_back_as_a_mesh() {
    let imported = ImportedModel::new();
    let mut model = imported.model();
    let found = good(&imported.fields(1).join("piece_000.vtu"));
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    model.mesh.nodes.sort_by_key(|node| node.id);
    let wanted: Vec<_> = model.mesh.nodes.iter().map(|n| (n.id.0, n.x.map(|x| x as f32))).collect();
    let nodes: Vec<_> = found.mesh.nodes.iter().map(|n| (n.id, n.x.map(|x| x as f32))).collect();
    assert_eq!(nodes, wanted);
    assert_eq!(nodes.len(), 1192);
    let of_job = |e: &crumple_proto::mesh::MeshElement| {
        (e.id.0, e.part, e.shape, e.corners().iter().map(|n| n.0).collect::<Vec<_>>())
    };
    let mut wanted: Vec<_> = model.mesh.elements.iter().map(of_job).collect();
    wanted.sort_by_key(|element| element.0);
    let parts = &found.mesh.parts;
    let mut elements: Vec<_> = found
        .mesh
        .elements
        .iter()
        .map(|e| (e.id, parts[e.part].id, e.shape, e.corners.clone()))
        .collect();
    elements.sort_by_key(|element| element.0);
    assert_eq!(elements, wanted);
    assert_eq!((elements.len(), parts.len()), (1358, 2));
}

/// The pieces of two workers are one mesh, the same as that of one worker, also with the doubled
/// elements of their ghosts; the job that `crumple import` writes has all files.
#[test]
fn fields_of_two_workers_are_the_mesh_of_one() {
    let imported = ImportedModel::new();
    let (one, two) = (imported.fields(1), imported.fields(2));
    let alone = good(&one.join("fields.pvtu"));
    assert_eq!(whole(&alone.mesh), whole(&good(&one.join("piece_000.vtu")).mesh));
    let joined = good(&two.join("fields.pvtu"));
    assert_eq!(whole(&joined.mesh), whole(&alone.mesh));
    assert!(joined.warnings.is_empty() && joined.files.len() == 3, "{:?}", joined.files);
    let pieces = [0, 1].map(|worker| good(&two.join(format!("piece_00{worker}.vtu"))).mesh);
    let nodes: usize = pieces.iter().map(|piece| piece.nodes.len()).sum();
    assert!(nodes > 1192 && pieces.iter().all(|piece| !piece.elements.is_empty()), "{nodes}");

    // With the pieces of the ghosts, elements are there twice.
    let list = fs::read_to_string(two.join("fields.pvtu")).unwrap();
    let ghosts = "<Piece Source=\"exterior_000.vtu\"/>\n<Piece Source=\"exterior_001.vtu\"/>\n";
    let end = "</PUnstructuredGrid>";
    fs::write(two.join("all.pvtu"), list.replace(end, &format!("{ghosts}{end}"))).unwrap();
    let all = good(&two.join("all.pvtu"));
    assert_eq!(whole(&all.mesh), whole(&alone.mesh));
    let row = all.rows.iter().find(|row| row.what == "cells of several pieces").unwrap();
    let ghosts = [0, 1].map(|worker| good(&two.join(format!("exterior_00{worker}.vtu"))).mesh);
    let doubled: usize = ghosts.iter().map(|piece| piece.elements.len()).sum();
    assert!(row.fate == Fate::Ignored && row.count == doubled && doubled > 0, "{row:?}");

    let out = imported.folder.path().join("again");
    let list = two.join("fields.pvtu");
    let words = ["import", list.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let said = run(crumple_with(&words)).with_code(0).said();
    assert!(said.contains("VTK XML") && said.contains("part 2"), "{said}");
    let model = job::read(&out, &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!((model.mesh.nodes.len(), model.mesh.elements.len()), (1192, 1358));
}

/// A plate in two pieces of other programs, as files with a list.
fn listed(folder: &Path, change: impl Fn(&str) -> String) -> PathBuf {
    let text = fs::read_to_string(root().join("tests/meshes/made/pieces.vtu")).unwrap();
    let (head, rest) = text.split_at(text.find("<Piece").unwrap());
    let (pieces, tail) = rest.split_at(rest.find("</UnstructuredGrid>").unwrap());
    let second = pieces.rfind("<Piece").unwrap();
    for (name, piece) in [("left.vtu", &pieces[..second]), ("right.vtu", &pieces[second..])] {
        fs::write(folder.join(name), change(&format!("{head}{piece}{tail}"))).unwrap();
    }
    let list = folder.join("plate.pvtu");
    let text = "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\">\n<PUnstructuredGrid \
                GhostLevel=\"1\">\n<Piece Source=\"left.vtu\"/>\n<Piece Source=\"right.vtu\"/>\n\
                </PUnstructuredGrid>\n</VTKFile>\n";
    fs::write(&list, text).unwrap();
    list
}

/// Pieces of others are joined by their ids; without ids they stay as they are, with a warning.
/// Ghosts of others have a flag, and are left out.
#[test]
fn pieces_of_other_programs_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let whole_file = good(&root().join("tests/meshes/made/pieces.vtu"));
    let found = good(&listed(folder.path(), str::to_string));
    assert_eq!(whole(&found.mesh), whole(&whole_file.mesh));
    let found = good(&listed(folder.path(), |text| text.replace("GlobalNodeId", "level")));
    assert_eq!((found.mesh.nodes.len(), found.mesh.elements.len()), (8, 2));
    assert!(found.warnings[0].message.contains("2 pieces"), "{:?}", found.warnings);
    for (name, ghost) in [("vtkGhostType", 1), ("vtkGhostLevels", 2)] {
        let flag = |text: &str| {
            let value = if text.contains("2 0 0") { ghost } else { 0 };
            let array = format!(
                "<CellData>\n<DataArray type=\"UInt8\" Name=\"{name}\" format=\"ascii\">{value}\
                 </DataArray>\n</CellData>\n</Piece>"
            );
            text.replace("</Piece>", &array)
        };
        let found = good(&listed(folder.path(), flag));
        assert_eq!((found.mesh.nodes.len(), found.mesh.elements.len()), (4, 1), "{name}");
    }
}

/// A list with a wrong piece is an error that names the piece and the line.
#[test]
fn wrong_pieces_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let list = listed(folder.path(), str::to_string);
    let text = fs::read_to_string(&list).unwrap();
    let with = |old: &str, new: &str| {
        assert!(text.contains(old), "{old}");
        fs::write(&list, text.replace(old, new)).unwrap();
        message(&list)
    };
    let found = with("right.vtu", "gone.vtu");
    assert!(found.contains("plate.pvtu:4: the included file `gone.vtu` cannot be read"), "{found}");
    let found = with("right.vtu", "left.vtu");
    assert!(found.contains("plate.pvtu:4: `left.vtu` is included twice"), "{found}");
    let found = with(" Source=\"right.vtu\"", "");
    assert!(found.contains("plate.pvtu:4: the Piece has no Source"), "{found}");
    let found = with("<Piece Source=\"left.vtu\"/>\n<Piece Source=\"right.vtu\"/>\n", "");
    assert!(found.contains("it has no Piece"), "{found}");
    fs::write(folder.path().join("inner.pvtu"), &text).unwrap();
    let found = with("right.vtu", "inner.pvtu");
    assert!(found.contains("plate.pvtu:4: the piece `inner.pvtu` is a list of pieces"), "{found}");
    // A fault in a piece has the file and the line of the piece.
    let right = folder.path().join("right.vtu");
    let piece = fs::read_to_string(&right).unwrap();
    fs::write(&right, piece.replacen("NumberOfCells=\"1\"", "NumberOfCells=\"3\"", 1)).unwrap();
    fs::write(&list, &text).unwrap();
    let found = message(&list);
    assert!(found.contains("right.vtu:") && found.contains("NumberOfCells is 3"), "{found}");
}
