//! The d3plot database of a run, read back by an independent reader (lasso-python) and compared
//! bit for bit with the field files: deploy/read_d3plot.py. Without such a reader the tests
//! check only the files from outside.

use crumple_proto::mesh::MeshElement;
use crumple_tests::program::{Ended, crumple_with, root, run};
use crumple_tests::tools;
use crumple_verification::scene::Scene;
use std::fs;
use std::process::Command;

/// Exports in files of at most `size` MB, checks that there are `files` of them, and has them
/// read; returns the output of the reader.
fn export_and_read(ended: &Ended, size: &str, files: usize) -> Option<String> {
    let out = ended.out();
    let dir = out.to_str().unwrap();
    let said = run(crumple_with(&["export-d3plot", dir, "--file-size", size])).with_code(0).said();
    assert!(said.contains(&format!("in {files} files")), "{said}");
    let names = fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut family: Vec<String> = names.filter(|n| n.starts_with("d3plot")).collect();
    family.sort();
    let wanted: Vec<String> = (0..files)
        .map(|i| if i == 0 { "d3plot".into() } else { format!("d3plot{i:02}") })
        .collect();
    assert_eq!(family, wanted);
    for name in family {
        let bytes = fs::read(out.join(name)).unwrap();
        let end = bytes
            .chunks_exact(4)
            .rev()
            .map(|w| f32::from_ne_bytes(w.try_into().unwrap()))
            .find(|w| *w != 0.0);
        assert_eq!(
            (bytes.len() % 2048, end),
            (0, Some(-999_999.0)),
            "complete blocks, with a marker at the end"
        );
    }
    let mut reader = Command::new(tools::python("lasso.dyna, pyvista")?);
    reader.arg(root().join("deploy/read_d3plot.py")).arg(&out);
    Some(run(reader).with_code(0).said())
}

/// Shells of several parts with plastic strain, pieces of several workers, states in one file
/// and, written again, in several files.
#[test]
fn shells_read_back() {
    let args = ["run", "cases/tumble", "--quiet", "--workers", "3", "--end-time", "1.0"];
    let sets = ["--set", "output.field_interval=0.25", "--set", "parallel.force_every=50"];
    let ended = run(crumple_with(&[&args[..], &sets].concat())).with_code(0);
    export_and_read(&ended, "100", 2);
    // A state of 1200 shells has about 100 kB. The last export writes fewer files than the one
    // before it and must leave none of those behind.
    for (size, files) in [("0", 6), ("1", 2)] {
        let Some(said) = export_and_read(&ended, size, files) else { continue };
        assert!(
            said.contains("5 states, ")
                && said.contains("1200 shells, 0 solids, 0 gone: all agrees"),
            "{said}"
        );
    }
}

/// The database has no particles: the export says how many there are.
#[test]
fn elements_without_a_place_are_counted() {
    let args = ["run", "cases/splash", "--quiet", "--no-report", "--workers", "2"];
    let sets = ["--set", "output.field_interval=0.001", "--set", "time.max_cycles=8"];
    let ended = run(crumple_with(&[&args[..], &sets].concat()));
    let out = ended.out().to_string_lossy().into_owned();
    let said = run(crumple_with(&["export-d3plot", &out])).with_code(0).said();
    assert!(said.contains("not in it: 925 particles; crumple export-exodus"), "{said}");
}

/// All points through the thickness, three and five of them; strains of a sheet that is stretched
/// by a tenth: ln 1.1 along, and at both surfaces.
#[test]
fn points_and_strains_read_back() {
    for points in ["3", "5"] {
        let more = format!("part.1.points={points}");
        let args = ["run", "cases/tube-crush", "--quiet", "--no-report", "--workers", "2"];
        let sets = ["--set", "output.points=true", "--set", "time.max_cycles=400", "--set", &more];
        let ended = run(crumple_with(&[&args[..], &sets].concat()));
        if let Some(said) = export_and_read(&ended, "100", 2) {
            assert!(said.contains(&format!("{points} points of shells")), "{said}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheet.toml");
    fs::write(
        &path,
        r#"
        end_time = 0.1
        [mesh]
        nodes = [[1, 0.0, 0.0, 0.0], [2, 10.0, 0.0, 0.0], [3, 10.0, 10.0, 0.0], [4, 0.0, 10.0, 0.0]]
        shells = [[1, 1, 1, 2, 3, 4]]
        [[material]]
        name = "steel"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 210.0
        poisson = 0.3
        [[part]]
        id = 1
        material = "steel"
        thickness = 1.0
        [output]
        field_interval = 0.1
        d3plot = true
        strains = true
        [[curve]]
        name = "ramp"
        points = [[0.0, 0.0], [0.1, 1.0]]
        [[motion]]
        nodes = { rule = "nodes", ids = [1, 4] }
        velocity = [0.0, 0.0, 0.0]
        [[motion]]
        nodes = { rule = "nodes", ids = [2, 3] }
        displacement = [1.0, 0.0, 0.0]
        curve = "ramp"
        "#,
    )
    .unwrap();
    let ended = run(crumple_with(&["run", &path.to_string_lossy(), "--quiet"])).with_code(0);
    let Some(python) = tools::python("lasso.dyna, pyvista") else { return };
    let mut reader = Command::new(python);
    reader.arg(root().join("deploy/read_d3plot.py")).arg(ended.out());
    let said = run(reader).with_code(0).said();
    let strain = (1.1_f64).ln();
    assert!(said.contains(&format!("strains of shells: {strain:.4} at most")), "{said}");
}

/// Solids, written at the end of the run because the job requests it.
#[test]
fn solids_read_back() {
    let args = ["run", "cases/can-crush", "--quiet", "--workers", "2", "--end-time", "0.05"];
    let sets = ["--set", "output.field_interval=0.05", "--set", "output.d3plot=true"];
    let ended = run(crumple_with(&[&args[..], &sets].concat())).with_code(0);
    assert!(ended.out().join("d3plot01").is_file(), "{}", ended.said());
    if let Some(said) = export_and_read(&ended, "100", 2) {
        assert!(
            said.contains("2 states, ")
                && said.contains("0 shells, 7152 solids, 0 gone: all agrees"),
            "{said}"
        );
    }
}

/// Tetrahedra with four and ten nodes and wedges, of which the format has the corners.
#[test]
fn tetrahedra_and_wedges_read_back() {
    for (nodes, count) in [("4", 384), ("6", 128), ("10", 384)] {
        let cut = format!("scene.nodes={nodes}");
        let args = ["run", "cases/block", "--quiet", "--no-report", "--workers", "2"];
        let sets = ["--set", &cut, "--end-time", "0.05", "--set", "output.exodus=true"];
        let ended = run(crumple_with(&[&args[..], &sets].concat())).with_code(0);
        let Some(said) = export_and_read(&ended, "100", 2) else { continue };
        assert!(said.contains(&format!("0 shells, {count} solids, 0 gone: all agrees")), "{said}");
        let mut reader = Command::new(tools::python("pyvista").expect("it was there"));
        reader.arg(root().join("deploy/read_exodus.py")).arg(ended.out());
        run(reader).with_code(0);
        // The file is a mesh too.
        let mesh = crumple::input::exodus::read(&ended.out().join("fields.exo")).unwrap();
        let of_kind = |e: &&MeshElement| e.corners().len().to_string() == nodes;
        assert_eq!(mesh.elements.iter().filter(of_kind).count(), count);
    }
}

/// Shells that tear next to a solid that does not. Failed elements are absent from the fields
/// and marked in the database. Every second node and element id is missing, and the ids of
/// elements are not in the order of the mesh.
#[test]
fn failed_elements_are_marked() {
    let mut scene = Scene::default();
    let strip = scene.lattice(9, [4, 1], |i, j| [5.0 * i as f64, 5.0 * j as f64, 0.0]);
    scene.set_named("held", &strip.row(0));
    scene.set_named("pulled", &strip.row(4));
    scene.block(2, [1, 1, 1], |u| [5.0 * u[0], 5.0 * u[1], 50.0 + 5.0 * u[2]]);
    scene.renumber(
        |node| if node <= 10 { 2 * node + 1 } else { 89 + node },
        |element| if element <= 4 { 22 - 2 * element } else { 7 },
    );
    let text = format!(
        "title = \"Torn strip\"\nunits = \"mm, ms, kg\"\nend_time = 0.3\n{}\
         [[material]]\nname = \"weak\"\nlaw = \"j2\"\ndensity = 7.85e-6\nyoungs_modulus = 200.0\n\
         poisson = 0.3\n\
         yield_stress = 0.2\nfailure_strain = 0.05\n\
         [[part]]\nid = 9\nname = \"strip\"\nmaterial = \"weak\"\nthickness = 1.0\n[[part]]\n\
         id = 2\nmaterial = \"weak\"\n\
         [[fix]]\nnodes = \"held\"\ndofs = [\"x\", \"y\", \"z\"]\n[[motion]]\nnodes = \"pulled\"\n\
         velocity = [20.0, 0.0, 0.0]\n\
         [output]\nfield_interval = 0.05\n",
        scene.mesh_text()
    );
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("torn.toml");
    fs::write(&path, text).unwrap();
    let args = ["run", path.to_str().unwrap(), "--quiet", "--workers", "2"];
    let ended = run(crumple_with(&args)).with_code(0);
    if let Some(said) = export_and_read(&ended, "100", 2) {
        assert!(
            said.contains("18 nodes, 4 shells, 1 solids, ") && !said.contains(" 0 gone"),
            "{said}"
        );
    }
}

/// Springs are in the fields, but not in the database; the shells next to them are in both.
#[test]
fn springs_are_left_out() {
    let args = ["run", "tests/decks/scenes/sled.k", "--quiet", "--workers", "2", "--no-report"];
    let ended = run(crumple_with(&args)).with_code(0);
    if let Some(said) = export_and_read(&ended, "100", 2) {
        assert!(said.contains("47 nodes, 32 shells, 0 solids, 0 gone: all agrees"), "{said}");
    }
}

#[test]
fn a_folder_without_fields_is_refused() {
    let there = tempfile::tempdir().unwrap();
    let said =
        run(crumple_with(&["export-d3plot", there.path().to_str().unwrap()])).with_code(2).said();
    assert!(
        said.contains("fields.pvd")
            && said.contains("name the folder of a run that has written fields"),
        "{said}"
    );
}
