//! Files of Radioss decks: the engine file, includes, other formats, mesh files, imports.

use super::{card, deck, mesh, model, moves, properties, read_at, reading, said, steel, with};
use crumple::input::mesh_file;
use crumple_proto::job::Job;
use crumple_tests::manual::{Snippet, blocks};
use crumple_tests::program::{crumple_with, run};
use std::fs;
use std::path::Path;

/// The base without the keywords of the engine.
fn starter() -> String {
    let text = with("");
    let (_, rest) = text.split_once("/END/ENGINE\n").unwrap();
    rest.to_string() + "/END\n"
}

/// The engine file next to the starter gives the end of the run; without it a job can.
#[test]
fn the_engine_file_belongs_to_the_starter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(&path, starter()).unwrap();
    let report = read_at(&path, &[]).err().unwrap();
    assert!(report.contains("there is no engine file") && report.contains("plate_0001.rad"));
    assert!(report.contains("end_time"), "{report}");
    let job = folder.path().join("job.toml");
    fs::write(&job, "end_time = 3.0\n[mesh]\ndeck = \"plate_0000.rad\"\n").unwrap();
    assert_eq!(read_at(&job, &[]).unwrap().job.end_time, 3.0);
    let engine = folder.path().join("plate_0001.rad");
    fs::write(&engine, "#RADIOSS ENGINE\n/RUN/plate/1\n 7.5\n/VERS/2022\n/END\n").unwrap();
    assert_eq!(read_at(&path, &[]).unwrap().job.end_time, 7.5);
    let report = read_at(&engine, &[]).err().unwrap();
    assert!(report.contains("is an engine file") && report.contains("plate_0000.rad"), "{report}");
    // A mistake in it is named with its file.
    fs::write(&engine, "/RUN/plate/1\n7.5x\n").unwrap();
    let report = read_at(&path, &[]).err().unwrap();
    assert!(report.contains("plate_0001.rad:2") && report.contains("7.5x"), "{report}");
}

/// Damping of the whole model and of parts; the engine file has its own alpha, with other fields.
#[test]
fn damping_is_that_of_the_engine_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    let lines = "/DAMP/1
        =all
        r0.25 r0 i0 i0 r0 r0
        /DAMP/2
        =parts
        r0.5 r0 i900 i0 r0 r1e30
        /DAMP/3
        =cube
        r0.75 r0 i901 i0 r0 r1e30
        /GRNOD/PART/901
        =cube
        i2";
    let write = |text: &str, engine: &str| {
        fs::write(&path, starter().replace("/END\n", "") + text + "/END\n").unwrap();
        let engine = format!("/RUN/plate/1\n7.5\n{engine}/END\n");
        fs::write(folder.path().join("plate_0001.rad"), engine).unwrap();
        read_at(&path, &[])
    };
    // A group of all nodes is the whole model.
    let found = write(&deck(lines), "").unwrap().job;
    let of_parts = |job: &Job| {
        job.damping.iter().map(|d| (d.coefficient, d.parts.clone())).collect::<Vec<_>>()
    };
    assert_eq!((found.time.damping, of_parts(&found)), (0.75, vec![(0.75, vec![2])]));
    let found = write(&deck(lines), "/DAMP/1\n0.1 0\n/DAMP/3\n3.5\n").unwrap().job;
    assert_eq!((found.time.damping, of_parts(&found)), (0.6, vec![(3.5, vec![2])]));
    // No damping at all, with nothing that could be wrong.
    let found = write(&deck(lines), "/DAMP/1\n0 0\n/DAMP/2\n0 0\n/DAMP/3\n0 0\n").unwrap().job;
    assert_eq!((found.time.damping, found.damping.len()), (0.0, 0));
    for (text, engine, word) in [
        (lines.replace("r0.25 r0 ", "r0.25 r1e-4 "), "", "`beta` = 0.0001"),
        (lines.replace("i0 r0 r0", "i0 r2 r1e30"), "", "`tstart` = 2"),
        (lines.replace("i0 r0 r0", "i0 r0 r7"), "", "`tstop` = 7"),
        (lines.into(), "/DAMP/1\n0.1 1e-4\n", "`beta` = 0.0001"),
        (lines.into(), "/DAMP/4\n0.1\n", "no /DAMP with the id 4"),
        (lines.replace("PART/901", "NODE/901").replace("\n        i2", "\n i1 i2"), "", "parts"),
    ] {
        let report = write(&deck(&text), engine).err().unwrap_or_else(|| panic!("{word}"));
        assert!(report.contains(word), "missing: {word}\n{report}");
    }
}

/// A deck of several files; a file that includes itself is an error.
#[test]
fn includes_are_read_and_cycles_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(folder.path().join("law.inc"), steel()).unwrap();
    let text = mesh() + &properties() + "#include law.inc\n" + &moves() + "/END\n";
    fs::write(&path, &text).unwrap();
    let found = read_at(&path, &[]).unwrap();
    assert_eq!(found.job.material[0].name, "steel");
    fs::write(folder.path().join("law.inc"), steel() + "#include law.inc\n").unwrap();
    let report = read_at(&path, &[]).err().unwrap();
    assert!(report.contains("includes itself"), "{report}");
}

/// A deck under the name of the other format is read with a warning; other files are named.
#[test]
fn other_formats_are_recognised_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let found = read_at(&write("plate.k", &(with("") + "/END\n")), &["end_time=2"]).unwrap();
    assert!(said(&found).contains("is a Radioss starter file, by its content"));
    let base = format!("{}{}{}*END\n", crate::base::BASE, crate::base::STEEL, crate::base::MOVES);
    let found = read_at(&write("plate_0000.rad", &base), &[]).unwrap();
    assert!(said(&found).contains("is an LS-DYNA keyword deck, by its content"));
    let report = read_at(&write("b_0000.rad", "ISO-10303-21;\nHEADER;\n"), &[]).err().unwrap();
    assert!(report.contains("is a file of the format STEP geometry"), "{report}");
}

/// `mesh.file` takes the mesh of a deck alone, and `crumple import` makes a job with the deck.
#[test]
fn a_deck_is_a_mesh_file_and_can_be_imported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(&path, with("/GRNOD/NODE/5\n=rim\ni11 i14") + "/END\n").unwrap();
    let found = mesh_file::read(&path, false, None).unwrap_or_else(|p| panic!("{p:?}"));
    assert_eq!((found.mesh.nodes.len(), found.mesh.elements.len()), (14, 3));
    let names: Vec<&str> = found.mesh.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["plate", "cube"]);
    assert_eq!(found.mesh.node_sets["rim"], [11, 14]);
    let job = folder.path().join("job.toml");
    let parts = "[[part]]\nid = 1\nmaterial = \"m\"\nthickness = 1.0\n[[part]]\nid = 2\n\
                 material = \"m\"\n";
    let text = "end_time = 1.0\n[mesh]\nfile = \"plate_0000.rad\"\n[[material]]\nname = \"m\"\n\
                law = \"elastic\"\ndensity = 7.85e-6\nyoungs_modulus = 207.0\npoisson = 0.3\n";
    fs::write(&job, format!("{text}{parts}")).unwrap();
    let warnings = read_at(&job, &[]).unwrap().warnings;
    assert!(warnings.iter().any(|w| w.help.contains("mesh.deck")), "{warnings:?}");
    let broken = folder.path().join("broken_0000.rad");
    fs::write(&broken, "/BEGIN\nx\n      2022         0\n/NODE\n        1x\n").unwrap();
    let problems = mesh_file::read(&broken, false, None).err().unwrap();
    assert!(problems[0].message.contains("broken_0000.rad:5: /NODE: `nid`"), "{problems:?}");
    let out = folder.path().join("imported");
    let args = ["import", path.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let said = run(crumple_with(&args)).with_code(0).said();
    // The table has the mesh and all keywords, and nothing that the job does not have.
    let columns = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for row in [
        "nodes 14 read nodes",
        "quads 2 read part 1 (plate)",
        "nodes of rim 2 read node set `rim`",
        "/MAT/LAW1 1 read law `elastic`",
        "/PROP/TYPE1 1 read shells. Ishell 24",
        "/INIVEL/TRA 1 read `[[initial_velocity]]`",
        "/PART 2 read `[[part]]`",
        "deck asked -> used",
        "part 2: solids, Isolid 24 -> hexahedron; hourglass assumed_strain",
    ] {
        assert!(columns.contains(row), "{row} is not in {said}");
    }
    for wrong in ["are not read", "placeholder", "node set `plate`"] {
        assert!(!said.contains(wrong), "{wrong} is in {said}");
    }
    assert!(said.contains("\nnext         crumple check "), "{said}");
    let imported = read_at(Path::new(&out), &[]).unwrap();
    assert_eq!((imported.job.end_time, imported.mesh.elements.len()), (10.0, 3));
}

/// The table of an import says what is ignored, and what is left out if that is allowed.
#[test]
fn an_import_says_what_a_deck_loses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(&path, with("/ANALY\ni0\n/MAT/LAW70/9\n=foam\n/XYZ/1\n=x") + "/END\n").unwrap();
    let out = folder.path().join("imported");
    let args = ["import", path.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let said = run(crumple_with(&args)).with_code(2).said();
    assert!(said.contains("/MAT/LAW70 is not supported yet: foam"), "{said}");
    assert!(said.contains("/XYZ is not supported"), "{said}");
    assert!(!out.exists());
    let args = [&args[..], &["--allow-unsupported"]].concat();
    let said = run(crumple_with(&args)).with_code(0).said();
    let fate = |keyword: &str| {
        let row = said.lines().find(|line| line.trim_start().starts_with(keyword));
        row.unwrap_or_else(|| panic!("{keyword} is not in {said}")).to_string()
    };
    assert!(fate("/ANALY").contains("ignored"), "{said}");
    assert!(fate("/MAT/LAW70").contains("left out  foam"), "{said}");
    assert!(fate("/XYZ").contains("left out  not supported"), "{said}");
    assert!(said.contains("plate_0000.rad:") && said.contains("is not read"), "{said}");
}

/// Decks of this format have no cases: a choice of one is an error, not ignored.
#[test]
fn a_case_of_this_format_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate_0000.rad");
    fs::write(&path, with("") + "/END\n").unwrap();
    let report = read_at(&path, &["mesh.case=2"]).err().expect("errors");
    assert!(report.contains("the deck has no cases, and case 2 is chosen"), "{report}");
    let problems = mesh_file::read(&path, false, Some(2)).err().expect("errors");
    assert!(problems[0].message.contains("case 2 is chosen"), "{problems:?}");
}

/// Keys after `$crumple:` override the cards; a keyword can be left out.
#[test]
fn keys_in_comments_and_keywords_left_out() {
    let text = with("/FAIL/JOHNSON/9\nr0.1");
    assert!(reading(&text, &[]).is_err());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plate_0000.rad"), &text).unwrap();
    let job = folder.path().join("job.toml");
    let keys = "[mesh]\ndeck = \"plate_0000.rad\"\nleave_out = [\"/fail/johnson\"]\n";
    fs::write(&job, keys).unwrap();
    assert!(read_at(&job, &[]).is_ok());
    let keyed = "$crumple: [time]\n$crumple: safety = 0.25\n".to_string() + &with("");
    assert_eq!(model(&keyed).job.time.safety, 0.25);
}

/// The deck that the guide shows runs as it is, and its converted form too.
#[test]
fn the_deck_of_the_guide_runs() {
    let blocks = blocks("docs/guide/radioss.md");
    let of = |block: &&Snippet| block.language == "text" && block.text.starts_with("/RUN/");
    let text = &blocks.iter().find(of).expect("a deck").text;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fall_0000.rad");
    fs::write(&path, text).unwrap();
    let model = read_at(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!((model.mesh.elements.len(), model.job.wall.len()), (2, 1));
    let ended = run(crumple_with(&["run", path.to_str().unwrap(), "--no-report"])).with_code(0);
    // The plate begins 1 mm above the wall at 1 mm/ms and stays on it.
    let impulse = fs::read_to_string(ended.out().join("walls.csv")).unwrap();
    let last = impulse.lines().last().unwrap().split(',').nth(4).unwrap();
    let momentum = 7.85e-6 * 20.0 * 10.0 * 1.0;
    assert!(last.parse::<f64>().unwrap().abs() > 0.9 * momentum, "{last} of {momentum}");
}

/// Parameters stand for values in fields above and below them, and for the thickness of a property.
#[test]
fn parameters_stand_for_values() {
    let lines = "/PARAMETER/GLOBAL/REAL/1
        =thickness
        wwall r1.25
        /PARAMETER/GLOBAL/REAL_EXPR/2
        =twice
        wtwice w2*wall
        /PARAMETER/GLOBAL/INTEGER/3
        =points
        wpoints i3";
    let parts = properties().replace(&card("i3 i0 r1.0"), &card("w&points i0 w&twice"));
    assert!(parts.contains("&twice"), "{parts}");
    let text = |lines: &str| mesh() + &parts + &steel() + &moves() + &deck(lines);
    let found = model(&text(lines));
    let sheet = found.job.part.iter().find(|part| part.thickness > 0.0).expect("shells");
    assert_eq!(sheet.thickness, 2.5);
    for (lines, words) in [
        (lines.replace("wtwice ", "wtwo "), "define it with /PARAMETER/GLOBAL/REAL or INTEGER"),
        (lines.replace("2*wall", "2*wal"), "parameter `twice`: there is no parameter `wal` yet"),
        (lines.replace("wtwice w2*wall", "wwall w2"), "parameter `wall` has two values"),
    ] {
        let report = reading(&text(&lines), &[]).err().expect("a report");
        assert!(report.contains(words), "{report}");
    }
}
