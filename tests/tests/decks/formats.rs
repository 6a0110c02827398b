//! Keyword decks: formats that give the same model, decks with errors, decks that other programs
//! read, and export back to decks.
//!
//! A file in `decks/bad` begins with the expected contents of its report: one `$: text` for each
//! piece of text. The pipe and the Taylor bar are public examples: `decks/README.md`.

use crumple::input::job::{Model, read};
use crumple_tests::program::{self, crumple_with};
use crumple_tests::tools;
use std::fs;
use std::path::{Path, PathBuf};

fn decks(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("decks").join(name)
}

fn good(path: &Path) -> Model {
    read(path, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Returns everything with which a run starts, as text.
fn whole(model: &Model) -> String {
    let mut job = model.job.clone();
    job.mesh.deck = None;
    let (elements, nodes) = model.records();
    format!("{}\n{:?}\n{elements:?}\n{nodes:?}", serde_json::to_string(&job).unwrap(), model.mesh)
}

/// Returns the deck as another program would have saved it.
fn saved(name: &str, change: impl Fn(&str) -> String) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, change(&fs::read_to_string(decks(name)).unwrap())).unwrap();
    whole(&good(&path))
}

#[test]
fn all_formats_give_the_same_model() {
    let model = good(&decks("good/fixed.k"));
    assert_eq!((model.mesh.nodes.len(), model.mesh.elements.len()), (9, 5));
    assert_eq!(model.job.part[0].element.as_deref(), Some("stabilised_quad"));
    assert_eq!(
        (model.job.part[0].thickness, &model.job.part[0].parameters["points"]),
        (1.5, &3.into()),
        "values from parameters"
    );
    assert_eq!(model.job.title, "A small plate");
    assert_eq!(model.job.load[0].force, [0.0, 0.0, 0.75], "0.25 on each of three nodes");
    assert_eq!(model.job.curve[0].points, [[0.0, 0.0], [1.0, 2.0]], "curve with its scale");
    assert_eq!(model.mesh.node_sets["edge"], model.mesh.node_sets["set-1"]);
    let one = whole(&model);
    for name in ["good/long.k", "good/comma.k"] {
        assert_eq!(one, whole(&good(&decks(name))), "{name}");
    }
    assert_eq!(one, saved("good/fixed.k", |text| text.replace('\n', "\r\n")), "line ends");
    assert_eq!(
        one,
        saved("good/fixed.k", |text| text.replace('\n', "   \n")),
        "spaces at line ends"
    );
    assert_eq!(
        one,
        saved("good/fixed.k", |text| text.replace('\n', "\n$ a comment, with commas\n")),
        "comments"
    );
    let lower = |text: &str| {
        let line = |l: &str| if l.starts_with('*') { l.to_lowercase() } else { l.to_string() };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(one, saved("good/fixed.k", lower), "lower case, and no line end at the end");
    let tabs = |text: &str| text.lines().map(with_tabs).collect::<Vec<_>>().join("\n");
    assert_eq!(one, saved("good/fixed.k", tabs), "tabs");
    assert_eq!(
        one,
        saved("good/fixed.k", |text| text.replace("A plate in", "*ABOUT in \u{e9}")),
        "text before"
    );
}

/// Replaces blanks of a line by tabs wherever these reach a column that is a multiple of eight.
fn with_tabs(line: &str) -> String {
    let mut out = String::new();
    for (number, eight) in line.as_bytes().chunks(8).enumerate() {
        let text = String::from_utf8_lossy(eight);
        let cut = text.trim_end_matches(' ');
        let whole = eight.len() == 8 && cut.len() < 7 && number < line.len() / 8;
        out += if whole { cut } else { &text };
        if whole {
            out.push('\t');
        }
    }
    out
}

#[test]
fn every_bad_deck_reports_its_errors() {
    let mut count = 0;
    let mut failures = String::new();
    for entry in fs::read_dir(decks("bad")).unwrap() {
        let path = entry.unwrap().path();
        count += 1;
        let text = fs::read_to_string(&path).unwrap();
        let wanted: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("$: ")).collect();
        assert!(!wanted.is_empty(), "{} expects no text", path.display());
        let report = match read(&path, &[]) {
            Ok(_) => {
                failures += &format!("--- {} passes\n", path.display());
                continue;
            }
            Err(report) => report.to_string(),
        };
        for want in wanted.iter().filter(|want| !report.contains(**want)) {
            failures += &format!("--- {}: missing text: {want}\n{report}\n", path.display());
        }
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(count >= 25, "{count} bad decks");
}

/// Checks the whole text of a report, once.
#[test]
fn a_report_shows_the_card_and_underlines_the_field() {
    let Err(report) = read(&decks("bad/number.k"), &[]) else { panic!("it passes") };
    let report = report.to_string();
    let (head, rest) = report.split_once(" --> ").unwrap();
    assert_eq!(head, "error: *MAT_ELASTIC: `e` has to be a number, not `207.0x`\n ");
    let (_, rest) = rest.split_once("bad/number.k").unwrap();
    assert_eq!(
        rest,
        ":16:25\n   |\n16 |          1   7.85e-6    207.0x       0.3\n   |                         \
         ^^^^^^\n   = help: card 1: the \
         fields are mid ro e pr da db k, 10 columns each or with commas between them\n\n\
         1 error: nothing was run\n"
    );
}

#[test]
fn unsupported_keywords_are_reported() {
    let bad = decks("bad/unsupported.k");
    let allowed = read(&bad, &["mesh.allow_unsupported=true".into()])
        .unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(allowed.unsupported.len(), 3);
    assert!(
        allowed.unsupported[0].starts_with("*AIRBAG_HYBRID (")
            && allowed.unsupported[0].contains("unsupported.k:")
    );
    let named = "mesh.leave_out=[\"AIRBAG_HYBRID\", \"*load_thermal_constant\", \
                 \"LOAD_VOLUME_LOSS\"]";
    let left_out = read(&bad, &[named.into()]).unwrap_or_else(|report| panic!("{report}"));
    assert!(left_out.unsupported.is_empty());
    let run = program::run(crumple_with(&[
        "run",
        bad.to_str().unwrap(),
        "--allow-unsupported",
        "--workers",
        "1",
    ]))
    .with_code(0);
    assert_eq!(run.summary()["unsupported"].as_array().map(Vec::len), Some(3));
}

#[test]
fn includes_are_read_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(decks("good/fixed.k")).unwrap();
    let (before, rest) = text.split_once("*NODE\n").unwrap();
    let (nodes, after) = rest.split_once("*ELEMENT_SHELL\n").unwrap();
    fs::create_dir(folder.path().join("mesh")).unwrap();
    fs::write(folder.path().join("mesh/nodes.k"), format!("*KEYWORD\n*NODE\n{nodes}*END\nno more"))
        .unwrap();
    let elements = format!("*ELEMENT_SHELL\n{}", after.split("*END").next().unwrap());
    fs::write(folder.path().join("mesh/all.k"), format!("*KEYWORD\n*INCLUDE\nnodes.k\n{elements}"))
        .unwrap();
    let main = folder.path().join("main.k");
    fs::write(&main, format!("{before}*INCLUDE\nmesh/ +\nall.k\n*END\n")).unwrap();
    assert_eq!(whole(&good(&main)), whole(&good(&decks("good/fixed.k"))));
}

/// Names of files as other systems write them, and existing files whose names differ only in
/// case.
#[test]
fn includes_of_other_systems_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(decks("good/fixed.k")).unwrap();
    let (before, rest) = text.split_once("*NODE\n").unwrap();
    fs::create_dir(folder.path().join("my meshes")).unwrap();
    fs::write(folder.path().join("my meshes/mesh 1.k"), format!("*KEYWORD\n*NODE\n{rest}"))
        .unwrap();
    let main = folder.path().join("main.k");
    let with = |name: &str| fs::write(&main, format!("{before}*INCLUDE\n{name}\n*END\n")).unwrap();
    for name in ["my meshes/mesh 1.k", "\"my meshes/mesh 1.k\"", "my meshes\\mesh 1.k"] {
        with(name);
        assert_eq!(whole(&good(&main)), whole(&good(&decks("good/fixed.k"))), "{name}");
    }
    with("My Meshes/Mesh 1.k");
    let report = read(&main, &[]).err().expect("another name").to_string();
    assert!(report.contains("there is my meshes/mesh 1.k"), "{report}");
}

/// The report names what a deck survives: a file cut short, a duplicate card, velocities in
/// other units.
#[test]
fn mistakes_in_decks_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let text = fs::read_to_string(decks("good/fixed.k")).unwrap();
    let message = |text: String| {
        fs::write(&path, text).unwrap();
        good(&path).warnings.iter().map(|w| format!("{}\n", w.message)).collect::<String>()
    };
    let plain = message(text.clone());
    for (said, text) in [
        ("the deck has no *END", text.split("*END").next().unwrap().to_string()),
        (
            "*CONTROL_TIMESTEP occurs 2 times: the last one counts",
            text.replacen("*PART", "*CONTROL_TIMESTEP\n\n*PART", 1),
        ),
        ("faster than any wave", text.replace("      -3.0", "  -3.0e+06")),
    ] {
        assert!(
            !plain.contains(said) && message(text.clone()).contains(said),
            "missing text: {said}\n{text}"
        );
    }
}

#[test]
fn a_jobs_own_keys_go_before_its_decks() {
    let folder = tempfile::tempdir().unwrap();
    let deck = decks("good/fixed.k");
    let text = format!(
        "end_time = 2.0\n[mesh]\ndeck = {:?}\nnode_sets = {{ tip = [9] }}\n[[part]]\nid = 7\n\
         thickness = 4.0\n\
         [[fix]]\nnodes = \"tip\"\ndofs = [\"x\"]\n",
        deck
    );
    let path = folder.path().join("job.toml");
    fs::write(&path, text).unwrap();
    let (job, plain) = (good(&path).job, good(&deck).job);
    assert_eq!(
        (job.end_time, job.part[0].thickness, &job.part[0].name),
        (2.0, 4.0, &plain.part[0].name)
    );
    assert_eq!(
        (job.part[1].thickness, job.fix.len()),
        (plain.part[1].thickness, plain.fix.len() + 1)
    );
    let set = read(&path, &["part.plate.thickness=5".into()])
        .unwrap_or_else(|report| panic!("{report}"))
        .job;
    assert_eq!(set.part[0].thickness, 5.0, "the command line overrides both");
    fs::write(&path, "end_time = 1.0\n[mesh]\ndeck = \"nowhere.k\"\n").unwrap();
    let Err(report) = read(&path, &[]) else { panic!("it passes") };
    let report = report.to_string();
    assert!(
        report.contains("nowhere.k cannot be read") && report.contains("3 | deck = \"nowhere.k\""),
        "{report}"
    );
}

#[test]
fn check_reports_the_conversion_of_a_deck() {
    let text = crumple::input::check::describe(&good(&decks("good/fixed.k")));
    for said in [
        "asked -> used",
        "shells, elform 16 -> stabilised_quad, c0_triangle",
        "contact 1: single surface -> every part with every other and itself",
        "units: not given in a deck -> mm, ms, kg",
    ] {
        assert!(text.contains(said), "missing text: {said}\n{text}");
    }
}

#[test]
fn public_decks_are_what_they_are() {
    let pipe = good(&program::root().join("cases/pipe-whip/pipe.k"));
    assert_eq!(
        (pipe.mesh.nodes.len(), pipe.mesh.elements.len(), pipe.job.part.len()),
        (2049, 1704, 4)
    );
    assert_eq!(pipe.job.rigid.len(), 2, "pipe and end are one body, the bracket is a second one");
    let taylor = good(&decks("taylor/input.k"));
    assert_eq!(taylor.job.units, "mm, s, tonne (guessed)");
    assert_eq!(taylor.job.part[0].element.as_deref(), Some("hexahedron"));
}

/// The pipe as in its deck: the spinning part is rigid and touches nothing. Then the pipe whip
/// that a job makes of it.
#[test]
fn the_pipe_runs_to_its_end_on_any_workers() {
    let run = |job: &str, workers: &str| {
        program::run(crumple_with(&["run", job, "--workers", workers])).with_code(0)
    };
    for job in ["cases/pipe-whip/pipe.k", "cases/pipe-whip"] {
        let one = run(job, "1");
        let summary = one.summary();
        assert_eq!(summary["end_time"], 20.0);
        let error = summary["energy"]["error_max"].as_f64().unwrap();
        assert!(error < 1e-3, "{job}: {error}; 3e-5 was measured, the limit is 1 %");
        for workers in ["2", "4"] {
            assert_eq!(one.digest(), run(job, workers).digest(), "{job} on {workers} workers");
        }
        let strained = summary["parts"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|p| p["plastic_strain_max"].as_f64() > Some(0.05));
        let wanted = if job.ends_with("pipe.k") { 0 } else { 2 };
        assert_eq!(strained.count(), wanted, "{job}: the whip bends one pipe and dents the other");
        // No node of the struck pipe comes out on the far side of the striking pipe.
        let through = summary["contact"]["penetration_max"].as_f64().unwrap();
        assert!(through < 0.5, "{job}: {through} of the contact thickness");
    }
}

/// B01 by a deck: the quarter bar of the Taylor deck with the missing planes of symmetry, and
/// the copper and velocity of B01.
#[test]
fn the_taylor_bar_shortens_as_the_published_one() {
    let copper = [
        "material.mat-1.density=8.93e-9",
        "material.mat-1.youngs_modulus=117000",
        "material.mat-1.poisson=0.35",
        "material.mat-1.yield_stress=400",
        "material.mat-1.hardening_modulus=100",
        // B01 hardens isotropically, the deck (beta 0) by back stress.
        "material.mat-1.kinematic_modulus=0",
        "initial_velocity.0.velocity=[0,227000,0]",
    ];
    let model = crumple_tests::read(&decks("taylor/symmetric.toml"), &copper);
    let engine = crumple_tests::run_alone(&model, |_| {});
    // Nodes of the axis: x = z = 0 at the start.
    let axis = model
        .mesh
        .nodes
        .iter()
        .filter(|n| n.x[0].abs() < 1e-6 && n.x[2].abs() < 1e-6)
        .map(|n| n.id);
    let axis: std::collections::BTreeSet<_> = axis.collect();
    let own = (0..engine.nodes.local_count).filter(|&i| axis.contains(&engine.nodes.id[i]));
    let y: Vec<f64> = own.map(|i| engine.nodes.x[i][1]).collect();
    let length =
        y.iter().copied().fold(f64::MIN, f64::max) - y.iter().copied().fold(f64::MAX, f64::min);
    // Lengths scale with the bar: 21.43 of 32.4 mm (B01). 2 %: this bar is thicker (L/D 3.75,
    // not 5.06), its foot is not held to the wall, and it has five cells on its radius; the
    // measured error was 1.5 %.
    assert!((length / 30.0 / (21.43 / 32.4) - 1.0).abs() < 0.02, "{length}");
}

#[test]
fn an_independent_reader_agrees() {
    let Some(python) = tools::python("dynars") else { return };
    let mut command = std::process::Command::new(python);
    let decks = ["cases/pipe-whip/pipe.k", "tests/decks/taylor/input.k"];
    command.arg("deploy/compare_decks.py").arg(program::crumple()).args(decks);
    program::run(command).with_code(0);
}

#[test]
fn an_exported_job_gives_the_same_digest() {
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("frame.k");
    let deck = deck.to_str().unwrap();
    let few =
        ["--set", "time.max_cycles=40", "--set", "output.field_interval=-1", "--workers", "1"];
    let digest = |job: &str| {
        program::run(crumple_with(&[&["run", job], few.as_slice()].concat())).with_code(0).digest()
    };
    let scenes =
        ["jeep-frame", "tumble", "block", "twist", "pipe-whip", "beam", "hertz", "panel", "slide"];
    for job in scenes.map(|name| format!("cases/{name}")) {
        let job = job.as_str();
        program::run(crumple_with(&["export-deck", job, "--out", deck, "--overwrite"]))
            .with_code(0);
        assert_eq!(digest(job), digest(deck), "{job}");
    }
}

/// Settings that have a card of the format are written as one, so that other programs see them;
/// the result has the same bits.
#[test]
fn exported_cards_say_what_other_programs_have_to_know() {
    let folder = tempfile::tempdir().unwrap();
    let run = |job: &str, sets: &[&str]| {
        let ended = program::run(crumple_with(
            &[&["run", job, "--workers", "1", "--no-report"], sets].concat(),
        ));
        ended.with_code(0).digest()
    };
    // Vectors and factors that cards have in other digits; a spring that is also a damper; a
    // spring with a direction.
    let odd = [
        "wall.roller.displacement=[0.0, 0.3, 1.7]",
        "wall.sled.normal=[1.0, 0.1, 0.03]",
        "part.spring.spring.damping=0.003",
        "part.damper.spring.direction=[1.0, 0.2, 0.0]",
    ];
    let odd = odd.map(|set| ["--set", set]);
    let first = folder.path().join("first.k");
    let again = folder.path().join("again.k");
    let [first, again] = [&first, &again].map(|path| path.to_str().unwrap());
    for (job, cards, lists) in [
        (
            "tests/decks/scenes/sled.k",
            &[
                "*MAT_SPRING_NONLINEAR_ELASTIC_TITLE",
                "*MAT_DAMPER_VISCOUS_TITLE",
                "*SECTION_DISCRETE",
                "*ELEMENT_DISCRETE",
                "*RIGIDWALL_PLANAR_FINITE_MOVING_ID",
                "*RIGIDWALL_GEOMETRIC_CYLINDER_MOTION_ID",
                "*INITIAL_VELOCITY",
                "*DEFINE_CURVE",
            ][..],
            &["[[wall]]", "[[motion]]", "[[curve]]"][..],
        ),
        (
            "tests/decks/scenes/bodies.toml",
            &[
                "*MAT_RIGID_TITLE",
                "*CONSTRAINED_RIGID_BODIES",
                "*CONSTRAINED_NODAL_RIGID_BODY_SPC_TITLE",
                "*BOUNDARY_PRESCRIBED_MOTION_RIGID",
                "*LOAD_BODY_Y",
                "*LOAD_BODY_Z",
                "*LOAD_NODE_SET",
                "*CONTACT_AUTOMATIC_SINGLE_SURFACE",
            ],
            &["[[motion]]", "[[gravity]]", "[[load]]", "[[curve]]"],
        ),
        (
            "tests/decks/scenes/faces.toml",
            &[
                "*SET_SEGMENT",
                "*LOAD_SEGMENT_SET",
                "*CONTACT_TIED_NODES_TO_SURFACE_ID",
                "*CONTACT_TIED_SHELL_EDGE_TO_SURFACE_OFFSET_ID",
                "*CONSTRAINED_INTERPOLATION",
            ],
            &["[[pressure]]", "[[tie]]", "[[curve]]"],
        ),
    ] {
        let digest = |job| run(job, &[]);
        let one = digest(job);
        program::run(crumple_with(&["export-deck", job, "--out", first, "--overwrite"]))
            .with_code(0);
        let text = fs::read_to_string(first).unwrap();
        for card in cards {
            assert!(text.lines().any(|line| line == *card), "{job}: no {card} in\n{text}");
        }
        for list in lists {
            assert!(
                !text.lines().any(|line| line.strip_prefix("$crumple: ") == Some(list)),
                "{job}: {list} in\n{text}"
            );
        }
        assert_eq!(one, digest(first), "{job}");
        // A second export: names from a deck must not be mistaken for others.
        program::run(crumple_with(&["export-deck", first, "--out", again, "--overwrite"]))
            .with_code(0);
        assert_eq!(one, digest(again), "{job}, exported twice");
    }
    let sled = "tests/decks/scenes/sled.k";
    let wanted = run(sled, odd.as_flattened());
    assert_ne!(wanted, run(sled, &[]), "the values affect the run");
    program::run(crumple_with(
        &[&["export-deck", sled, "--overwrite", "--out", first], odd.as_flattened()].concat(),
    ))
    .with_code(0);
    assert_eq!(wanted, run(first, &[]));
}

#[test]
fn the_page_of_keywords_is_current() {
    let page = crumple::input::deck::reference::page();
    expect_test::expect_file!["../../../cases/DECKS.md"].assert_eq(&page);
}
