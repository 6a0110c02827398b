//! Mesh files of other programs: formats, parts and sets, jobs that `crumple import` writes.

use crate::base::{BASE, MOVES, STEEL};
use crumple::input::job;
use crumple::input::mesh_file::{Fate, ReadMesh, read};
use crumple_proto::mesh::Shape;
use crumple_proto::problem::Severity;
use crumple_tests::program::{crumple_with, root, run};
use std::fs;
use std::path::{Path, PathBuf};

fn meshes() -> PathBuf {
    root().join("tests/meshes")
}

fn good(file: &str) -> ReadMesh {
    let path = meshes().join(file);
    read(&path, false, None).unwrap_or_else(|problems| panic!("{}: {problems:?}", path.display()))
}

/// Returns the numbers of nodes, elements and parts, and the names of the node sets.
fn content(file: &str) -> (usize, usize, usize, Vec<String>) {
    let mesh = good(file).mesh;
    let sets = mesh.node_sets.keys().cloned().collect();
    (mesh.nodes.len(), mesh.elements.len(), mesh.parts.len(), sets)
}

/// Files of other projects (tests/meshes/third-party) have the numbers of nodes and elements that
/// these projects state, and those with cells that are not supported name them.
#[test]
fn files_of_other_projects_are_read() {
    for (file, nodes, elements, parts) in [
        ("meshio/insulated-2.2.msh", 67, 111, 2),
        ("meshio/insulated-4.1.msh", 67, 111, 2),
        ("meshio/element_elset.inp", 4, 2, 2),
        ("meshio/wInclude_main.inp", 3, 2, 1),
        ("meshio/06_color_scalars.vtk", 5, 2, 2),
        ("meshio/gh-935.vtk", 6, 2, 1),
        ("meshio/rbc_001.vtk", 500, 996, 1),
        ("pyvista/hexbeam.vtk", 99, 40, 1),
        ("meshio/00_raw_binary.vtu", 64, 162, 1),
        ("meshio/02_raw_compressed.vtu", 64, 162, 1),
        ("vtkio/box.vtu", 8, 6, 1),
        ("vtkio/cube_complex.vtk", 8, 6, 1),
        ("vtkio/tri_attrib_binary.vtk", 3, 1, 1),
        ("vtkio/hexahedron_ascii.vtu", 8, 1, 1),
        ("vtkio/hexahedron_binary.vtu", 8, 1, 1),
        ("vtkio/hexahedron_inline_binary.vtu", 8, 1, 1),
        ("vtkio/hexahedron_zlib.vtu", 8, 1, 1),
        ("vtkio/hexahedron_zlib_inline_binary.vtu", 8, 1, 1),
        ("numpy-stl/Moon.stl", 60, 116, 1),
        ("numpy-stl/dos.stl", 60, 116, 1),
        ("numpy-stl/Star.stl", 36, 68, 1),
        ("numpy-stl/Star-binary.stl", 36, 68, 1),
        ("meshioplusplus/column_0000.rad", 12, 2, 1),
        ("meshioplusplus/gmsh_tet10_0000.rad", 106, 43, 1),
        ("meshioplusplus/s4.inp", 4, 1, 1),
        ("meshioplusplus/mixed.inp", 10, 2, 2),
        ("meshioplusplus/cantilever_static.inp", 117, 48, 1),
        ("sim-plugin-abaqus/abaqus_e2e_cantilever.inp", 10, 4, 1),
        ("pynastran/solid_bending.bdf", 72, 186, 1),
    ] {
        let found = content(&format!("third-party/{file}"));
        assert_eq!((found.0, found.1, found.2), (nodes, elements, parts), "{file}");
    }
    for (file, wanted) in [
        ("meshio/02_structured.vtk", "the data set is a STRUCTURED_GRID"),
        ("meshio/cylinder.fem", "18 elements of type pyramid with 5 nodes"),
        ("vtkio/hexahedron_lz4.vtu", "data are compressed by vtkLZ4DataCompressor"),
        ("meshioplusplus/old_0000.rad", "the deck has the version 44 of the format"),
    ] {
        let problems = read(&meshes().join("third-party").join(file), false, None).err().unwrap();
        assert!(problems.iter().any(|p| p.message.contains(wanted)), "{file}: {problems:?}");
        assert!(problems.iter().all(|p| !p.help.is_empty()), "{file}: {problems:?}");
    }
    // Without its pyramids, the file of HyperMesh (Nastran) has the cells that meshio counts.
    let path = meshes().join("third-party/meshio/cylinder.fem");
    let found = read(&path, true, None).unwrap_or_else(|problems| panic!("{problems:?}")).mesh;
    let count = |shape| found.elements.iter().filter(|e| e.shape == shape).count();
    let counts = [Shape::Quad4, Shape::Tri3, Shape::Tet4].map(count);
    assert_eq!((found.nodes.len(), counts), (33, [18, 4, 63]));
}

/// Sets, sections and materials of files of other projects have the values in these files: an S4
/// with a density, a hexahedron and a wedge, a cantilever of solids, a plane one, a solid that
/// MSC.Patran wrote.
#[test]
fn materials_and_sets_of_other_projects_are_read() {
    let size = |read: &ReadMesh, set: &str| read.mesh.node_sets[set].len();
    let steel = |read: &ReadMesh| {
        let found = &read.mesh.materials[0];
        (found.name.clone(), found.density, found.youngs_modulus, found.poisson)
    };
    let shell = good("third-party/meshioplusplus/s4.inp");
    assert_eq!(shell.mesh.parts[0].thickness, Some(0.1));
    assert_eq!(steel(&shell), ("M".into(), Some(7.8e-9), Some(210e3), Some(0.3)));
    assert_eq!(shell.mesh.node_sets["FIX"], [1, 4]);
    let mixed = good("third-party/meshioplusplus/mixed.inp");
    let corners: Vec<_> = mixed.mesh.elements.iter().map(|e| &e.corners[..]).collect();
    assert_eq!(corners, [&[1, 2, 3, 4, 5, 6, 7, 8][..], &[2, 9, 3, 6, 10, 7]]);
    let parts: Vec<_> = mixed.mesh.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(parts, ["HEX", "WED"]);
    assert_eq!(steel(&mixed), ("M".into(), None, Some(210e3), Some(0.3)));
    let beam = good("third-party/meshioplusplus/cantilever_static.inp");
    assert_eq!((size(&beam, "FIX"), size(&beam, "TIP"), size(&beam, "E")), (9, 9, 117));
    assert_eq!(steel(&beam), ("STEEL".into(), Some(7.8e-9), Some(210e3), Some(0.3)));
    let plane = good("third-party/sim-plugin-abaqus/abaqus_e2e_cantilever.inp");
    assert_eq!(plane.mesh.elements[3].corners, [4, 5, 6, 7]);
    assert_eq!((&plane.mesh.node_sets["TIP"][..], size(&plane, "FIXED")), (&[5][..], 2));
    assert_eq!(steel(&plane), ("STEEL".into(), None, Some(200e9), Some(0.3)));
    assert_eq!(plane.mesh.parts[0].thickness, Some(1.0));
    let solid = good("third-party/pynastran/solid_bending.bdf");
    assert_eq!(solid.mesh.nodes[7].x, [0.499951, 0.73106, 1.49985]);
    assert_eq!(solid.mesh.elements[0].corners, [8, 13, 67, 33]);
    assert_eq!((size(&solid, "spc_1"), size(&solid, "spc_3")), (13, 72));
    assert_eq!(steel(&solid), ("mat_1".into(), Some(1.0), Some(3e7), Some(0.3)));
}

/// A deck of another project that Radioss itself has run: its materials, supports, velocity and
/// end are those of its two files, and it runs.
#[test]
fn a_radioss_deck_of_another_project_runs() {
    let path = meshes().join("third-party/meshioplusplus/column_0000.rad");
    let model = job::read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    let law = &model.job.material[0].parameters;
    assert_eq!((model.job.material[0].name.as_str(), model.job.end_time), ("steel", 0.004));
    for (key, value) in [("youngs_modulus", 210.0), ("poisson", 0.3)] {
        assert_eq!(law[key], value.into(), "{key}");
    }
    assert_eq!(model.job.material[0].density, 7.8e-6);
    let set = |name: &str| model.mesh.node_sets[name].iter().map(|id| id.0).collect::<Vec<_>>();
    assert_eq!((set("bottom"), set("top")), (vec![1, 2, 3, 4], vec![9, 10, 11, 12]));
    assert_eq!(model.job.initial_velocity[0].velocity, [0.0, 0.0, -1.0]);
    assert_eq!((model.job.fix.len(), model.job.part[0].name.as_str()), (1, "column"));
    let out = tempfile::tempdir().unwrap();
    let words = ["run", path.to_str().unwrap(), "--no-report", "--out"];
    let ended = run(crumple_with(&[&words[..], &[out.path().to_str().unwrap()]].concat()));
    assert!(ended.with_code(0).said().contains("state_digest"));
}

/// The same mesh in all forms that Gmsh writes: a block of solids, a plate, and the top of the
/// block, which is a group but no part. The coordinates and corners agree bit by bit in MSH.
#[test]
fn all_forms_of_one_mesh_agree() {
    let first = good("made/block41.msh").mesh;
    for file in ["block41-binary.msh", "block22.msh", "block22-binary.msh"] {
        let other = good(&format!("made/{file}")).mesh;
        let points = |mesh: &crumple::input::mesh_file::FileMesh| {
            let mut points: Vec<_> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
            points.sort_by_key(|point| point.0);
            points
        };
        assert_eq!(points(&first), points(&other), "{file}");
        let corners = |mesh: &crumple::input::mesh_file::FileMesh| {
            let part = |index: usize| mesh.parts[index].name.clone();
            let of = mesh.elements.iter().map(|e| (e.corners.clone(), part(e.part)));
            let mut corners: Vec<_> = of.collect();
            corners.sort();
            corners
        };
        assert_eq!(corners(&first), corners(&other), "{file}");
        assert_eq!(first.node_sets, other.node_sets, "{file}");
    }
    assert_eq!(first.node_sets["top"].len(), 9);
    for file in ["block.inp", "block.bdf", "block.vtk", "block-binary.vtk"] {
        let found = content(&format!("made/{file}"));
        assert_eq!((found.0, found.1, found.2), (36, 12, 2), "{file}");
    }
    let shapes = |file: &str| {
        let mesh = good(file).mesh;
        let solids = mesh.elements.iter().filter(|e| e.shape == Shape::Hex8).count();
        (solids, mesh.elements.len() - solids)
    };
    assert_eq!(shapes("made/block.bdf"), (8, 4));
    for file in ["block.stl", "block-binary.stl"] {
        let found = content(&format!("made/{file}"));
        assert_eq!((found.0, found.1, found.2), (18, 16, 1), "{file}");
    }
}

/// Sections, materials, sets and places of instances of an Abaqus file, and a job that checks.
#[test]
fn an_abaqus_file_gives_a_whole_job() {
    let read = good("broken/plate.inp");
    let mesh = &read.mesh;
    assert_eq!(
        (mesh.parts[0].thickness, mesh.parts[0].material.as_deref()),
        (Some(0.1), Some("Steel"))
    );
    let steel = &mesh.materials[0];
    assert_eq!(
        (steel.density, steel.youngs_modulus, steel.poisson),
        (Some(7.85e-9), Some(207e3), Some(0.3))
    );
    assert_eq!(steel.hardening, [[0.0, 300.0], [0.5, 500.0]]);
    // The instance is moved by 1 along z.
    assert!(mesh.nodes.iter().all(|node| node.x[2] == 1.0));
    assert_eq!(mesh.node_sets["rim"], [1, 2, 3]);
    assert_eq!((&mesh.node_sets["corner"][..], mesh.node_sets["top"].len()), (&[1][..], 6));
    assert!(read.rows.iter().any(|row| row.what == "*HEADING" && row.fate == Fate::Ignored));
}

/// Properties, beams with a direction, a bilinear material and supports of a Nastran file.
#[test]
fn a_nastran_file_gives_a_whole_job() {
    let mesh = good("broken/plate.bdf").mesh;
    let beam = mesh.elements.iter().find(|e| e.shape == Shape::Beam2).unwrap();
    assert_eq!(beam.axis, Some([0.0, 0.0, 1.0]));
    assert_eq!(mesh.parts[beam.part].beam.as_ref().unwrap().radius, 0.2);
    assert_eq!(mesh.materials[0].hardening, [[0.0, 300.0], [1.0, 700.0]]);
    assert_eq!(mesh.node_sets["spc_1"], [1, 2]);
    let third = mesh.to_mesh();
    // The node for the direction follows those of the file.
    assert_eq!(third.nodes.last().unwrap().x, [2.0, 0.0, 1.0]);
}

/// A mesh with a wrong extension is read by its content, with a warning that names both formats.
#[test]
fn a_wrong_extension_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let plate = |name: &str| fs::read(meshes().join("broken").join(name)).unwrap();
    for (content, name, wanted) in [
        ("plate.bdf", "a.inp", ["Nastran bulk data", "`.inp` is for Abaqus input"]),
        ("plate.inp", "a.bdf", ["Abaqus input", "`.bdf` is for Nastran bulk data"]),
        ("plate.msh", "a.vtk", ["Gmsh MSH", "`.vtk` is for VTK legacy"]),
        ("plate.vtk", "a.vtu", ["VTK legacy", "`.vtu` is for VTK XML"]),
        ("plate.stl", "a.msh", ["STL", "`.msh` is for Gmsh MSH"]),
        ("plate.vtu", "a.stl", ["VTK XML", "`.stl` is for STL"]),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, plate(content)).unwrap();
        let found = read(&path, false, None).unwrap_or_else(|problems| panic!("{problems:?}"));
        let message = &found.warnings[0].message;
        assert!(wanted.iter().all(|text| message.contains(text)), "{message}");
    }
    // Formats that are not read are named with the way out.
    for (text, name, wanted) in [
        ("*KEYWORD\n*END\n", "a.msh", "LS-DYNA keyword deck"),
        ("ISO-10303-21;\nHEADER;\n", "a.msh", "STEP geometry"),
        ("ply\nformat ascii 1.0\n", "a.stl", "PLY"),
        ("# made\n MeshVersionFormatted 2\nDimension 3\n", "a.mesh", "Medit"),
        ("Point(1) = {0, 0, 0};\n", "a.msh", "Gmsh geometry"),
        ("hello\n", "a.msh", "is no file of the format Gmsh MSH"),
        ("hello\n", "a.xyz", "is not known"),
        ("", "a.inp", "is empty"),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let problems = read(&path, false, None).err().unwrap();
        assert!(problems[0].message.contains(wanted), "{name}: {problems:?}");
        assert!(!problems[0].help.is_empty(), "{name}");
    }
    let problems = read(Path::new("/nowhere/a.msh"), false, None).err().unwrap();
    assert!(problems[0].message.contains("there is no file"), "{problems:?}");
}

/// A mesh file under the name of a deck is named, alone and as `mesh.deck`, and its lines are not
/// read as cards. So is a deck under the name of a mesh file.
#[test]
fn mesh_files_and_decks_under_each_others_names_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let report = |path: &Path| match job::read(path, &[]) {
        Ok(_) => panic!("{} is read", path.display()),
        Err(report) => report.to_string(),
    };
    fs::write(at("job.toml"), "end_time = 1.0\n[mesh]\ndeck = \"deck.k\"\n").unwrap();
    for (content, format) in [
        ("broken/plate.inp", "Abaqus input"),
        ("made/assembly.inp", "Abaqus input"),
        ("third-party/meshio/element_elset.inp", "Abaqus input"),
        ("broken/plate.bdf", "Nastran bulk data"),
        ("third-party/meshio/cylinder.fem", "Nastran bulk data"),
        ("broken/plate.msh", "Gmsh MSH"),
        ("made/block22-binary.msh", "Gmsh MSH"),
        ("broken/plate.stl", "STL"),
        ("made/block-binary.stl", "STL"),
        ("broken/plate.vtk", "VTK legacy"),
        ("broken/plate.vtu", "VTK XML"),
    ] {
        fs::copy(meshes().join(content), at("deck.k")).unwrap();
        for path in [at("deck.k"), at("job.toml")] {
            let report = report(&path);
            let wanted = format!("deck.k is a file of the format {format}, not a deck");
            assert!(report.contains(&wanted) && report.contains("crumple import"), "{report}");
            assert!(report.contains("1 error"), "{content}: {report}");
        }
    }
    let keyword = format!("{BASE}{STEEL}{MOVES}*END\n");
    let bare = keyword.replace("*KEYWORD\n", "");
    for (text, name) in [
        (&keyword, "deck.inp"),
        (&bare, "deck.inp"),
        (&keyword, "deck.bdf"),
        (&bare, "deck.dat"),
        (&keyword, "deck.msh"),
    ] {
        fs::write(at(name), text).unwrap();
        let report = report(&at(name));
        assert!(report.contains(&format!("{name} is an LS-DYNA keyword deck")), "{report}");
        assert!(report.contains("ends in .k"), "{report}");
        let problems = read(&at(name), false, None).err().unwrap();
        assert!(problems[0].message.contains("of the format LS-DYNA keyword deck"), "{problems:?}");
        assert!(problems[0].help.contains("mesh.deck"), "{problems:?}");
        assert!(problems[0].help.contains(".k, .key or .dyn"), "{problems:?}");
        let job = format!("[mesh]\ndeck = \"{name}\"\n");
        fs::write(at("named.toml"), job).unwrap();
        let model = job::read(&at("named.toml"), &[]).unwrap_or_else(|report| panic!("{report}"));
        assert_eq!(model.mesh.elements.len(), 3, "{name}");
    }
    let radioss = crate::radioss::with("") + "/END\n";
    fs::write(at("starter.inp"), radioss).unwrap();
    let report = report(&at("starter.inp"));
    assert!(report.contains("is a Radioss starter file"), "{report}");
    assert!(report.contains("ends in _0000.rad"), "{report}");
}

/// A starter without parts is a mesh: its job has placeholders and the units of the deck, and runs.
/// An old version is the only error, because its columns are others.
#[test]
fn a_radioss_mesh_without_parts_becomes_a_job_with_placeholders() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tet").to_string_lossy().into_owned();
    let file = "tests/meshes/third-party/meshioplusplus/gmsh_tet10_0000.rad";
    let said = run(crumple_with(&["import", file, "--out", &out])).with_code(0).said();
    assert!(said.contains("it has no /PART: the job has only its nodes"), "{said}");
    assert!(said.contains("units        mm, s, tonne: as the file says"), "{said}");
    assert!(said.contains("placeholders end_time, material.placeholder"), "{said}");
    let job = fs::read_to_string(Path::new(&out).join("job.toml")).unwrap();
    for line in [
        "file = \"gmsh_tet10_0000.rad\"",
        "id = 3000001",
        "density = 7.85e-9",
        "youngs_modulus = 207000.0",
    ] {
        assert!(job.contains(line), "{line}: {job}");
    }
    run(crumple_with(&["check", &out])).with_code(0);

    let old = meshes().join("third-party/meshioplusplus/old_0000.rad");
    let problems = read(&old, false, None).err().unwrap();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].message.contains("the version 44 of the format"), "{problems:?}");
    let report = job::read(&old, &[]).err().expect("it is too old").to_string();
    assert!(report.contains("the version 44") && !report.contains("has to be"), "{report}");
}

/// Formats that are not read are named with a cure, whatever the extension. Names of groups in HDF5
/// may be anywhere in the file.
#[test]
fn formats_that_are_not_read_are_named_with_a_cure() {
    let folder = tempfile::tempdir().unwrap();
    let hdf5 = |names: &str| {
        let mut bytes = b"\x89HDF\r\n\x1a\n".to_vec();
        bytes.resize(100_000, 0);
        [&bytes[..], names.as_bytes(), &[0; 64]].concat()
    };
    // The control words of a plot of eight nodes, in words of four and of eight bytes.
    let mut words = [0u64; 64];
    words[11..23].copy_from_slice(&[1, 0, 0, 0, 4, 8, 6, 20, 0, 1, 1, 0]);
    let plot4: Vec<u8> = words.iter().flat_map(|&w| (w as u32).to_le_bytes()).collect();
    let plot8: Vec<u8> = words.iter().flat_map(|&w| w.to_le_bytes()).collect();
    let other = "HDF5 with other content than EXODUS II, VTKHDF, MED or CGNS";
    let texts = [
        ("XDMF", "meshio convert", "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"3.0\">\n</Xdmf>\n"),
        ("Wavefront OBJ", "STL", "# a cube\no cube\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("OFF", "STL", "# a triangle\nOFF\n3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ("ANSYS CDB", "mapdl-archive", "/COM,ANSYS RELEASE 19.0\n/PREP7\nNBLOCK,6,SOLID,8,8\n"),
        (
            "ParaView collection",
            ".pvtu of a step",
            "<VTKFile type=\"Collection\">\n<Collection>\n</Collection>\n</VTKFile>\n",
        ),
        ("CGNS", "gmsh FILE.cgns", "@(#)ADF Database Version A02011>\n"),
    ];
    let mut files: Vec<(&str, &str, Vec<u8>)> = vec![
        ("MED", "gmsh FILE.med", hdf5("ENS_MAA")),
        ("CGNS", "gmsh FILE.cgns", hdf5("CGNSLibraryVersion")),
        ("VTKHDF", ".pvtu of a step", hdf5("VTKHDF")),
        (other, "export the mesh again", hdf5("data0")),
        ("LS-DYNA d3plot", "give its deck", plot4),
        ("LS-DYNA d3plot", "give its deck", plot8),
    ];
    files.extend(texts.map(|(format, cure, text)| (format, cure, text.as_bytes().to_vec())));
    for (format, cure, bytes) in files {
        for name in ["file", "file.msh", "file.inp"] {
            let path = folder.path().join(name);
            fs::write(&path, &bytes).unwrap();
            let problems = read(&path, false, None).err().expect("it is not read");
            assert_eq!(problems.len(), 1, "{format}: {problems:?}");
            let said = format!("{name} is a file of the format {format}");
            assert!(problems[0].message.ends_with(&said), "{format}: {problems:?}");
            assert!(problems[0].help.contains(cure), "{format}: {problems:?}");
        }
    }
    // A netCDF-4 file of EXODUS II is one.
    let path = folder.path().join("model.g");
    fs::write(&path, hdf5("num_nodes")).unwrap();
    let problems = read(&path, false, None).err().expect("it is cut");
    assert!(problems[0].message.contains("cannot be read as netCDF"), "{problems:?}");
}

/// Elements that are not supported are an error with a cure; with `allowed` they are left out.
#[test]
fn unsupported_elements_are_refused_or_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.inp");
    let text = fs::read_to_string(meshes().join("broken/plate.inp")).unwrap();
    let more = "*Element, type=C3D5\n9, 1, 2, 5, 4, 3\n*Element, type=MASS\n10, 1\n*Nset, nset=rim";
    fs::write(&path, text.replace("*Nset, nset=rim", more)).unwrap();
    let problems = read(&path, false, None).err().unwrap();
    assert!(problems[0].message.contains("pyramid with 5 nodes"), "{problems:?}");
    assert!(problems[0].help.contains("hexahedra") && problems[0].help.contains("--allow"));
    let found = read(&path, true, None).unwrap_or_else(|problems| panic!("{problems:?}"));
    assert_eq!((found.mesh.elements.len(), found.warnings.len()), (2, 1));
    assert_eq!(found.warnings[0].severity, Severity::Warning);
    let fate = |what: &str| found.rows.iter().find(|row| row.what == what).map(|row| row.fate);
    assert_eq!(fate("pyramid with 5 nodes"), Some(Fate::LeftOut));
    assert_eq!(fate("point mass"), Some(Fate::Ignored));
}

/// A job of `crumple import` can run as it is; its placeholders are warnings at their lines, and
/// so is an entry of the list that names nothing.
#[test]
fn an_imported_job_runs_and_names_its_placeholders() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("plate");
    let out = out.to_str().unwrap();
    let import = |file: &str| run(crumple_with(&["import", file, "--out", out]));
    let said = import("tests/meshes/made/block41.msh").with_code(0).said();
    for wanted in ["Gmsh MSH", "part 2 (block)", "node set `top`", "bound others", "job.toml"] {
        assert!(said.contains(wanted), "{wanted} is not in {said}");
    }
    let said = import("tests/meshes/made/block41.msh").with_code(2).said();
    assert!(said.contains("job.toml exists") && said.contains("--out"), "{said}");
    let said = run(crumple_with(&["check", out])).with_code(0).said();
    for wanted in [
        "`end_time` is a placeholder",
        "`part.plate.thickness` is a placeholder",
        "`material.placeholder` is a placeholder",
        "mesh file",
        "nothing moves",
    ] {
        assert!(said.contains(wanted), "{wanted} is not in {said}");
    }
    let set = ["--set", "time.max_cycles=2", "--set", "placeholders=[\"part.x.beam\"]"];
    let results = folder.path().join("out");
    let mut words = vec!["run", out, "--no-report", "--out", results.to_str().unwrap()];
    words.extend(set);
    let ended = run(crumple_with(&words)).with_code(0);
    assert!(ended.said().contains("`part.x.beam` names no value"), "{}", ended.said());
}

/// The parts of a mesh file under a job: sets that the job adds, and a part that it lacks.
#[test]
fn a_job_names_a_mesh_file_as_any_other_mesh() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(meshes().join("broken/plate.msh"), folder.path().join("plate.msh")).unwrap();
    let text = "end_time = 1.0\n[mesh]\nfile = \"plate.msh\"\n[mesh.node_sets]\none = [1]\n\
                [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
                youngs_modulus = 207.0\npoisson = 0.3\n[[part]]\nid = 3\nmaterial = \"steel\"\n\
                thickness = 0.1\n";
    let check = |text: &str| {
        let path = folder.path().join("job.toml");
        fs::write(&path, text).unwrap();
        job::read(&path, &[])
    };
    let model = check(text).unwrap_or_else(|report| panic!("{report}"));
    let sets: Vec<_> = model.mesh.node_sets.keys().map(String::as_str).collect();
    assert_eq!(sets, ["one", "plate", "rim"]);
    let report = check(&text.replace("id = 3", "id = 4")).err().unwrap().to_string();
    assert!(
        report.contains("2 elements belong to part 3, which the job does not have"),
        "{report}"
    );
    let report = check(&text.replace("plate.msh", "../plate.msh")).err().unwrap().to_string();
    assert!(report.contains("there is no file"), "{report}");
    // EXODUS files may be given by the same key.
    fs::write(folder.path().join("plate.msh"), b"CDF\x01 no more").unwrap();
    let report = check(text).err().unwrap().to_string();
    assert!(report.contains("cannot be read as netCDF"), "{report}");
}
