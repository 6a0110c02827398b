//! A contact law and a material law that only this test has: one file, and one row added to a
//! table. Job keys, checks, schema, warnings and the run follow from the row.
//!
//! The tables and the schema belong to the process, and rows must be added before the first job is
//! read. So these tests are a binary of their own.

mod laws;

use clap::Parser;
use crumple::cli::{Cli, Command};
use crumple::run::checkpoint::find::newest_cycle;
use crumple_tests::manual::blocks;
use crumple_tests::{case, read, run_side_by_side};
use crumple_worker::contact::enforce::CONTACT_LAWS;
use crumple_worker::fem::materials::LAWS;
use std::path::Path;
use std::sync::Once;
use std::sync::atomic::Ordering;

/// Adds the rows of this test, before a job is read.
fn add() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        CONTACT_LAWS.add(&laws::sticky::LAW);
        CONTACT_LAWS.add(&laws::damper::LAW);
        CONTACT_LAWS.add(&laws::strict::LAW);
        LAWS.add(&laws::maxwell::LAW);
        LAWS.add(&laws::breaking::LAW);
        LAWS.add(&laws::ludwik::LAW);
    });
}

const STICKY: &str = "contact.law=sticky";

/// Returns the warnings and errors of the colliding bodies with these settings.
fn problems(sets: &[&str]) -> String {
    add();
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    match crumple::input::job::read(&case("tumble"), &sets) {
        Ok(model) => model.warnings.iter().map(|w| format!("{}: {w:?}\n", w.path)).collect(),
        Err(report) => report.to_string(),
    }
}

/// The law gets its number: stiffer contact gives other bits, a default gives those of the table,
/// and the number of workers changes none.
#[test]
fn an_added_contact_law_runs_with_its_own_key() {
    add();
    let digest = |sets: &[&str], workers| {
        let run = run_side_by_side(&read(&case("tumble"), sets), workers, 900, 0);
        assert!(run.pairs.iter().any(|pairs| !pairs.is_empty()), "there is contact");
        run.digest()
    };
    let plain = digest(&[STICKY], 1);
    assert_eq!(plain, digest(&[STICKY, "contact.stickiness=0.25"], 1), "the default");
    assert_eq!(plain, digest(&[STICKY], 3), "three workers");
    assert_ne!(plain, digest(&[STICKY, "contact.stickiness=0.1"], 1), "another value");
}

#[test]
fn keys_of_an_added_contact_law_are_checked_from_its_table() {
    let wrong = problems(&[STICKY, "contact.stickiness=-1.0"]);
    assert!(wrong.contains("`stickiness` is -1.0") && wrong.contains("from 0 to 1"), "{wrong}");
    let unknown = problems(&[STICKY, "contact.stickines=0.5"]);
    assert!(unknown.contains("`stickiness`"), "the nearest key is named: {unknown}");
    let word = problems(&[STICKY, "contact.stickiness=\"much\""]);
    assert!(word.contains("has to be a finite number"), "{word}");
    let idle = problems(&["contact.stickiness=0.5"]);
    assert!(idle.contains("does not use `stickiness`") && idle.contains("sticky"), "{idle}");
    let of_other = problems(&[STICKY, "contact.penalty_scale=0.5"]);
    assert!(of_other.contains("does not use `penalty_scale`"), "{of_other}");
    let used = problems(&[STICKY, "contact.stickiness=0.5", "contact.weighting=\"mass\""]);
    assert!(!used.contains("does not use"), "every law uses `weighting`: {used}");
}

/// A missing key is an error of the job, for the first table and for an interface with the law.
#[test]
fn a_required_key_without_a_value_is_reported() {
    let missing = problems(&["contact.law=strict"]);
    assert!(missing.contains("law \"strict\" has no `strict_scale`"), "{missing}");
    assert!(missing.contains("job.toml:") && missing.contains("| [contact]"), "{missing}");
    assert!(missing.contains("Factor on the coefficient"), "the meaning: {missing}");
    assert_eq!(problems(&["contact.law=strict", "contact.strict_scale=0.3"]), "");
    let interface = "contact.interface=[{ law = \"strict\" }]";
    let missing = problems(&[interface]);
    assert!(missing.contains("law \"strict\" has no `strict_scale`"), "{missing}");
    assert_eq!(problems(&[interface, "contact.strict_scale=0.3"]), "");
}

/// A second law of the same name would never be found.
#[test]
fn a_name_that_is_taken_is_refused() {
    add();
    let result = std::panic::catch_unwind(|| CONTACT_LAWS.add(&laws::sticky::LAW));
    let message = *result.expect_err("it is taken").downcast::<String>().expect("a message");
    assert!(message.contains("there is a row `sticky` already"), "{message}");
    assert_eq!(CONTACT_LAWS.iter().filter(|law| law.name == "sticky").count(), 1);
    let mut names: Vec<&str> = CONTACT_LAWS.iter().map(|law| law.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), CONTACT_LAWS.iter().count());
}

#[test]
fn the_schema_lists_added_laws() {
    add();
    let schema = crumple::input::reference::schema();
    let contact = &schema["$defs"]["ContactInput"]["properties"];
    assert_eq!(contact["stickiness"]["default"], 0.25);
    let names = contact["law"]["enum"].as_array().expect("names of laws");
    assert!(names.iter().any(|name| name == "sticky"));
    let page = crumple::input::reference::page();
    assert!(page.contains("| `sticky` | `stickiness` |"));
    assert!(page.contains("### `law = \"maxwell\"`") && page.contains("`relaxation_time`"));
}

/// Bars of the added material, with its required parameter, a wrong one, and none.
#[test]
fn an_added_material_law_is_read_and_runs() {
    add();
    let bars = |more: &str| {
        let text = std::fs::read_to_string(case("bars").join("job.toml")).expect("the job of bars");
        let text = text.replacen("law = \"elastic\"", &format!("law = \"maxwell\"\n{more}"), 1);
        assert!(text.contains("maxwell"), "the bars are elastic");
        crumple::input::job::read_text(case("bars").join("job.toml"), text, &[])
    };
    let model = bars("relaxation_time = 1e-3").unwrap_or_else(|report| panic!("{report}"));
    let run = |model| run_side_by_side(model, 2, 100, 0).digest();
    let elastic = read(&case("bars"), &[]);
    assert_ne!(run(&model), run(&elastic), "stress relaxes");
    let missing = bars("").err().expect("a required parameter is missing").to_string();
    assert!(missing.contains("relaxation_time is missing"), "{missing}");
    let unknown = bars("relaxation = 1.0").err().expect("an unknown parameter").to_string();
    assert!(unknown.contains("did you mean 'relaxation_time'"), "{unknown}");
}

/// A worker thread panics: the run ends with code 4, keeps its checkpoints, and continues from
/// there with the bits of a run without the fault.
#[test]
fn a_panic_of_a_worker_ends_with_code_4_and_keeps_the_checkpoint() {
    add();
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(case("tumble").join("job.toml")).unwrap();
    let is_flow = |line: &&str| !line.starts_with("hardening");
    let text: Vec<&str> = text.lines().filter(is_flow).collect();
    let law = "law = \"breaking\"\nrelaxation_time = 1.0";
    let text = text.join("\n").replacen("law = \"j2\"", law, 1);
    let job = folder.path().join("job.toml");
    std::fs::write(&job, text).unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let launch = |words: &[&str]| {
        let words = [&["crumple", "run", "--no-report", "--quiet"], words].concat();
        let Command::Run(args) = Cli::parse_from(words).command else { panic!("it is a run") };
        crumple::run::launch::run(&args)
    };
    let job = job.to_string_lossy();
    let cycles = "--set=time.max_cycles=500";
    let often = "--set=checkpoint.every=\"0.02 s\"";
    let [whole, out] = [at("whole"), at("out")];
    assert_eq!(launch(&[&job, cycles, "--workers=1", "--out", &whole]), 0);
    laws::breaking::IS_SLOW.store(true, Ordering::Relaxed);
    let lost = std::thread::scope(|scope| {
        let words = [&job, cycles, often, "--workers=2", "--out", &out];
        let run = scope.spawn(move || launch(&words));
        while newest_cycle(Path::new(&out)).is_none() {
            assert!(!run.is_finished(), "the run ended before its first checkpoint");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        laws::breaking::BREAKS.store(true, Ordering::Relaxed);
        let code = run.join().unwrap();
        laws::breaking::BREAKS.store(false, Ordering::Relaxed);
        laws::breaking::IS_SLOW.store(false, Ordering::Relaxed);
        code
    });
    assert_eq!(lost, 4);
    assert!(newest_cycle(Path::new(&out)).is_some());
    assert_eq!(launch(&["--resume", &out, "--workers=3"]), 0);
    let digest = |out: &str| {
        let text = std::fs::read_to_string(Path::new(out).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        summary["state_digest"].clone()
    };
    assert_eq!(digest(&whole), digest(&out));
}

/// The job and the law of the tutorial. Johnson and Cook's law is the same law here.
#[test]
fn the_material_of_the_tutorial_has_the_bits_of_the_law_that_it_repeats() {
    add();
    let page = blocks("docs/tutorials/new-material.md");
    let job = page.into_iter().find(|block| block.language == "toml").expect("a job");
    let digest = |law: &str, b: f64| {
        let path = case("plate").join("job.toml");
        let sets = [format!("material.0.law={law}"), format!("material.0.b={b:?}")];
        let model = crumple::input::job::read_text(path, job.text.clone(), &sets);
        let model = model.unwrap_or_else(|report| panic!("{report}"));
        run_side_by_side(&model, 2, 200, 0).digest()
    };
    assert_eq!(digest("ludwik", 0.5), digest("johnson_cook", 0.5));
    assert_ne!(digest("ludwik", 0.5), digest("ludwik", 0.6), "the plate yields");
}

/// The damper of the developer's guide acts, by its coefficient, and on any number of workers.
#[test]
fn the_contact_law_of_the_guide_runs() {
    add();
    let digest = |scale: f64, workers| {
        let sets = ["contact.law=damper".into(), format!("contact.damper_scale={scale:?}")];
        let sets: Vec<&str> = sets.iter().map(|set: &String| &set[..]).collect();
        let run = run_side_by_side(&read(&case("tumble"), &sets), workers, 900, 0);
        assert!(run.pairs.iter().any(|pairs| !pairs.is_empty()), "there is contact");
        run.digest()
    };
    assert_eq!(digest(0.35, 1), digest(0.35, 3), "three workers");
    assert_ne!(digest(0.35, 1), digest(0.2, 1), "another coefficient");
}
