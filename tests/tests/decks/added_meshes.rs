//! Mesh files that a job adds to its mesh (`[[mesh.add]]`): a ball from an STL file that hits a
//! plate, and what `crumple import` says of a surface.

use crumple::input::job::read;
use crumple_tests::program::{crumple_with, root, run};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Radius of the ball in its file [mm].
const RADIUS: f64 = 1.0;

/// A plate of quads from a generator: nodes 1 to 81, elements 1 to 64, part 1, side 40 mm.
const PLATE: &str = "[mesh]\ngenerator = \"plate\"\n[scene]\nelements = 4\nside = 40.0\n";

/// Returns the text of an STL file: a ball of triangles about the origin, an octahedron whose
/// faces are divided twice.
fn ball() -> String {
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let sign = |bit: u32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let [x, y, z] = [[sign(0), 0.0, 0.0], [0.0, sign(1), 0.0], [0.0, 0.0, sign(2)]];
        let outwards = sign(0) * sign(1) * sign(2) > 0.0;
        triangles.push(if outwards { [x, y, z] } else { [y, x, z] });
    }
    let middle = |a: [f64; 3], b: [f64; 3]| {
        let sum: [f64; 3] = std::array::from_fn(|c| a[c] + b[c]);
        let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
        sum.map(|c| RADIUS * c / length)
    };
    for _ in 0..2 {
        let divided = |[a, b, c]: &[[f64; 3]; 3]| {
            let [ab, bc, ca] = [middle(*a, *b), middle(*b, *c), middle(*c, *a)];
            [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(divided).collect();
    }
    let mut text = String::from("solid ball\n");
    for corners in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            let _ = writeln!(text, "vertex {x:?} {y:?} {z:?}");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid ball\n"
}

/// Returns a job of a plate and of a rigid ball that falls on it, with the keys of the ball's mesh
/// and of its part. Units mm, ms, kg.
fn job(mesh: &str, add: &str, ball: u32) -> String {
    format!(
        "title = \"ball\"\nunits = \"mm, ms, kg\"\nend_time = 0.3\n{mesh}\
         [[mesh.add]]\nfile = \"ball.stl\"\n{add}\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         [[part]]\nid = 1\nname = \"plate\"\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[part]]\nid = {ball}\nname = \"ball\"\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[rigid]]\nname = \"ball\"\nparts = [{ball}]\nmass = 0.01\n\
         [[fix]]\nnodes = \"rim\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[initial_velocity]]\nnodes = \"ball\"\nvelocity = [0.0, 0.0, -10.0]\n\
         [contact]\n[output]\nhistory_interval = 0.02\nfield_interval = -1\n"
    )
}

/// Where the ball falls: of radius 6, its lowest point 2 above the plate.
const PLACE: &str = "scale = 6.0\nmove = [1.0, 0.5, 8.0]\n";

fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
}

/// A rigid ball from an STL file meets a deformable plate: both are in one job, contact acts, the
/// ball is slowed down, and the state has the same bits on one and on two workers. A plate from a
/// file of Gmsh is as good as one from a generator.
#[test]
fn a_ball_from_an_stl_file_falls_on_a_plate() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    write(folder.path(), &[("ball.stl", &ball()), ("job.toml", &job(PLATE, PLACE, 1001))]);
    let ended = ["1", "2"].map(|workers| {
        let words = ["run", path.to_str().unwrap(), "--no-report", "--workers", workers];
        run(crumple_with(&words)).with_code(0)
    });
    assert_eq!(ended[0].digest(), ended[1].digest());
    let forces = fs::read_to_string(ended[0].out().join("contacts.csv")).unwrap();
    let mut lines = forces.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let at = |name: &str| header.iter().position(|h| h.starts_with(name)).expect("a column");
    let (part, force) = (at("part"), at("force z"));
    let on_ball = lines.filter(|row| row[part] == "1001");
    let largest = on_ball.map(|row| row[force].parse().unwrap()).fold(0.0, f64::max);
    // The ball has 10 mm/ms and 0.01 kg; stopped within 0.3 ms it feels 0.3 kN at least.
    assert!(largest > 0.1, "the largest force on the ball is {largest} kN");

    let file = "cases/examples/gmsh-sphere/plate-and-sphere.msh";
    fs::copy(root().join(file), folder.path().join("plate.msh")).unwrap();
    let of_file = job("[mesh]\nfile = \"plate.msh\"\n", "", 1001)
        + "[[part]]\nid = 2\n\
        name = \"sphere\"\nmaterial = \"steel\"\nthickness = 1.0\n";
    let of_file = of_file.replace("[contact]\n", "");
    write(folder.path(), &[("job.toml", &of_file)]);
    let said = run(crumple_with(&["check", path.to_str().unwrap()])).with_code(0).said();
    assert!(said.contains("part 1 (ball) is part 1001"), "{said}");
}

/// `crumple import` of a surface alone says how to add it to another mesh; what it prints is right,
/// and the job says the same.
#[test]
fn an_import_of_a_surface_says_how_to_add_it() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("ball.stl"), folder.path().join("imported"));
    fs::write(&file, ball()).unwrap();
    let words = ["import", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let said = run(crumple_with(&words)).with_code(0).said();
    let start = said.find("[[mesh.add]]").unwrap_or_else(|| panic!("{said}"));
    assert!(said[..start].contains("All of the mesh is rigid"), "{said}");
    let written = fs::read_to_string(out.join("job.toml")).unwrap();
    assert!(written.contains("\n# [[mesh.add]]\n# file = \"ball.stl\"\n"), "{written}");
    let checked = run(crumple_with(&["check", out.to_str().unwrap()])).with_code(2).said();
    assert!(checked.contains("[[mesh.add]]"), "{checked}");

    let base = job(PLATE, "", 1001);
    let own = base.find("[[mesh.add]]").unwrap()..base.find("[[material]]").unwrap();
    let mut text = base.replace(&base[own], "");
    let second = text.find("[[part]]\nid = 1001").unwrap()..text.find("[[fix]]").unwrap();
    text.replace_range(second, "");
    text += &said[start..].replace("MATERIAL", "steel").replace("# move", "move");
    write(folder.path(), &[("job.toml", &text)]);
    let model = read(&folder.path().join("job.toml"), &[]).unwrap_or_else(|r| panic!("{r}"));
    assert_eq!(model.settings.rigid.len(), 1);
    let first = model.mesh.nodes.iter().find(|node| node.id.label() == 1_000_001).unwrap();
    assert_eq!(first.x[2], 100.0);

    let mesh = root().join("tests/meshes/made/block41.msh");
    let out = folder.path().join("block");
    let words = ["import", mesh.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let said = run(crumple_with(&words)).with_code(0).said();
    assert!(!said.contains("[[mesh.add]]"), "{said}");
}
