//! Beams and trusses in decks that are exported: read back, they give the same bits.

use crumple::input::job::{Model, read, read_text};
use crumple_proto::mesh::Shape;
use crumple_tests::program::{crumple_with, run};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// A chain of bars along a slanted line, one for each section, between heavy ends: a rectangle with
/// and without shear, a tube, a general section, a truss at the end. A moving wall far away
/// needs a node of its own in Radioss decks. Units mm, ms, kg.
fn job() -> String {
    let sections = [
        "[part.beam]\nsection = \"rectangle\"\nheight = 2.0\nwidth = 3.0\n\
         shear_areas = [5.0, 5.0]\n",
        "[part.beam]\nsection = \"rectangle\"\nheight = 2.1\nwidth = 3.3\n",
        "[part.beam]\nsection = \"tube\"\nradius = 1.7\nwall = 0.3\ncontact_radius = 0.2\n",
        "[part.beam]\nsection = \"general\"\narea = 4.0\nsecond_moments = [2.0, 1.0]\n\
         torsion = 2.5\n",
        "[part.truss]\narea = 1.3\n",
    ];
    let mut text =
        "title = \"bars\"\nunits = \"mm, ms, kg\"\nend_time = 1.0\n[mesh]\nnodes = [".to_string();
    let count = sections.len() as u32;
    let at = |n: u32| [10.0, 3.3, 1.7].map(|c| c * f64::from(n));
    for n in 0..=count {
        let [x, y, z] = at(n);
        let _ = write!(text, "[{}, {x:?}, {y:?}, {z:?}], ", n + 1);
    }
    // Third nodes, off the line in different directions.
    for n in 0..count {
        let [x, y, z] = at(n);
        let turn = 0.7 * f64::from(n);
        let _ = write!(text, "[{}, {x:?}, {:?}, {:?}], ", 101 + n, y + turn.cos(), z + turn.sin());
    }
    text += "]\nbeams = [";
    for n in 1..count {
        let _ = write!(text, "[{n}, {n}, {n}, {}, {}], ", n + 1, 100 + n);
    }
    let _ = write!(text, "]\ntrusses = [[{count}, {count}, {count}, {}]]\n", count + 1);
    text += "[[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
             youngs_modulus = 210.0\npoisson = 0.3\n";
    for (id, section) in (1..).zip(sections) {
        let _ = write!(text, "[[part]]\nid = {id}\nmaterial = \"steel\"\n{section}");
    }
    text + "[[fix]]\nnodes = { rule = \"nodes\", ids = [1] }\ndofs = [\"x\", \"y\", \"z\", \"rx\", \
            \"ry\", \"rz\"]\n[[initial_velocity]]\nnodes = { rule = \"nodes\", ids = [5, 6] }\n\
            velocity = [0.3, 1.0, -2.0]\n[[wall]]\nname = \"far\"\npoint = [0.0, 0.0, -500.0]\n\
            normal = [0.0, 0.0, 1.0]\nmass = 1.0\nspeed = 0.1\n"
}

fn digest(model: &Model) -> String {
    crumple_tests::run_side_by_side(model, 1, 200, 0).digest()
}

fn read_file(path: &Path) -> Model {
    read(path, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Cards of all sections, in both formats of decks.
#[test]
fn exported_bars_give_the_same_bits() {
    let model = read_text("bars.toml".into(), job(), &[]).unwrap_or_else(|r| panic!("{r}"));
    let wanted = digest(&model);
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("bars.toml");
    fs::write(&source, job()).unwrap();
    for name in ["bars.k", "bars_0000.rad"] {
        let path = folder.path().join(name);
        let asked = ["convert", &source.to_string_lossy(), &path.to_string_lossy()];
        run(crumple_with(&asked)).with_code(0);
        let again = read_file(&path);
        let count = |shape| again.mesh.elements.iter().filter(|e| e.shape == shape).count();
        assert_eq!((count(Shape::Beam2), count(Shape::Truss2)), (4, 1), "{name}");
        assert_eq!(again.settings.axes, model.settings.axes, "{name}");
        assert_eq!(digest(&again), wanted, "{name}");
    }
}

/// A file that exists is refused and unchanged, unless `--overwrite` is given; file and size are
/// printed.
#[test]
fn an_export_replaces_no_file_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let [source, deck] = ["bars.toml", "bars.k"].map(|name| folder.path().join(name));
    fs::write(&source, job()).unwrap();
    fs::write(&deck, "own").unwrap();
    let [source, out] = [&source, &deck].map(|path| path.to_string_lossy().into_owned());
    let said = run(crumple_with(&["export-deck", &source, "--out", &out])).with_code(2).said();
    assert!(said.contains("bars.k exists; replace it with --overwrite"), "{said}");
    assert_eq!(fs::read_to_string(&deck).unwrap(), "own");
    for option in ["--overwrite", "--force"] {
        let words = ["export-deck", &source, "--out", &out, option];
        let said = run(crumple_with(&words)).with_code(0).said();
        let size = fs::metadata(&deck).unwrap().len() as f64 / 1000.0;
        assert!(said.contains(&format!("written: {out}, {size:.1} kB\n")), "{said}");
        assert!(fs::read_to_string(&deck).unwrap().contains("*KEYWORD"), "{said}");
    }
}

/// Keys without a card are named, and a section without one is an error.
#[test]
fn what_has_no_card_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let [source, deck] = ["bars.toml", "bars.k"].map(|name| folder.path().join(name));
    fs::write(&source, job()).unwrap();
    let asked = ["export-deck", &source.to_string_lossy(), "--out", &deck.to_string_lossy()];
    let said = run(crumple_with(&asked)).with_code(0).said();
    assert!(said.contains("part.beam.contact_radius: no card for 1"), "{said}");
    let general = job().replace("law = \"elastic\"", "law = \"j2\"\nyield_stress = 0.3");
    fs::write(&source, general).unwrap();
    let said = run(crumple_with(&asked)).with_code(2).said();
    assert!(said.contains("a general section with the law j2 has no card"), "{said}");
}
