//! The report page of a run: generated from the files of the run, and drawn by a browser without
//! errors.

use crumple_tests::program::{Ended, crumple_with, run};
use crumple_tests::tools;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Arguments of a run of a few milliseconds of two bars, on two workers.
const RUN: [&str; 4] = ["run", "cases/bars", "--workers", "2"];

fn bars(more: &[&str]) -> Ended {
    run(crumple_with(
        &[&RUN[..], &["--set", "time.max_cycles=60", "--set", "output.field_interval=0.01"], more]
            .concat(),
    ))
}

fn page(run: &Ended) -> String {
    fs::read_to_string(run.out().join("report.html"))
        .unwrap_or_else(|e| panic!("report.html: {e}: {}", run.said()))
}

/// Returns the text between two marks.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let rest = text.split_once(begin).unwrap_or_else(|| panic!("no {begin}")).1;
    rest.split_once(end).unwrap_or_else(|| panic!("no {end}")).0
}

fn facts(page: &str) -> serde_json::Value {
    let json = between(page, r#"<script type="application/json" id="facts">"#, "</script>");
    serde_json::from_str(json).expect("facts are JSON")
}

#[test]
fn a_run_leaves_a_page_and_report_makes_the_same_again() {
    let ended = bars(&[]).with_code(0);
    assert!(ended.said().contains("report.html"), "{}", ended.said());
    let first = page(&ended);
    let summary = ended.summary();
    let facts = facts(&first);
    let quads = summary["elements"]["quad4"].as_u64().unwrap();
    assert_eq!(facts["model"]["elements"].as_u64(), Some(quads), "all shells are visible");
    assert_eq!(facts["model"]["frames"].as_array().unwrap().len(), ended.read_fields());
    assert!(
        first.contains(summary["state_digest"].as_str().unwrap()),
        "the summary is on the page"
    );
    assert_eq!(facts["plots"]["plots"][0]["title"], "Energies");
    // The lines add up at every time to the total, which is constant.
    let lines = facts["plots"]["plots"][0]["lines"].as_array().unwrap();
    let line = |label: &str| -> Vec<f64> {
        let found = lines.iter().find(|line| line["label"] == label);
        found.map_or(Vec::new(), |l| {
            l["values"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
        })
    };
    let total = line("total");
    for (row, total_now) in total.iter().enumerate() {
        let at = |label| line(label).get(row).copied().unwrap_or(0.0);
        let given = at("contact work") + at("wall work") + at("external work");
        let sum = at("kinetic") + at("internal") + at("hourglass") - given;
        assert!(
            (sum - total_now).abs() < 1e-9 * total[0] && (total_now / total[0] - 1.0).abs() < 5e-3,
            "{sum} {total_now}"
        );
    }
    assert!(
        total.len() > 1 && line("internal").last().copied() > Some(0.01 * total[0]),
        "the energies change: {total:?}"
    );

    fs::remove_file(ended.out().join("report.html")).unwrap();
    run(crumple_with(&["report", &ended.out().display().to_string()])).with_code(0);
    assert!(page(&ended) == first, "the same results give the same page");
    // The page names damaged or missing files and shows the rest.
    let piece = ended.out().join("fields/step_000000/piece_001.vtu");
    let whole = fs::read(&piece).unwrap();
    fs::write(&piece, &whole[..whole.len() * 9 / 10]).unwrap();
    fs::remove_file(ended.out().join("history.csv")).unwrap();
    let said =
        run(crumple_with(&["report", &ended.out().display().to_string()])).with_code(0).said();
    assert!(
        said.contains("step_000000/piece_001.vtu: ends within array")
            && said.contains("history.csv: "),
        "{said}"
    );
    assert!(page(&ended).contains("Not read: "), "the page lists the problems");
}

/// Moving walls have a path over the times of the history, fixed walls have none; the page with
/// them has no error.
#[test]
fn walls_that_move_have_their_paths() {
    let ended =
        run(crumple_with(&["run", "tests/decks/scenes/sled.k", "--workers", "1"])).with_code(0);
    let walls = facts(&page(&ended))["walls"].clone();
    let path = |w: usize| walls[w]["path"].clone();
    let last = |w: usize, c: usize| {
        path(w)["moved"].as_array().unwrap().last().unwrap()[c].as_f64().unwrap()
    };
    assert!(
        (last(1, 2) - 4.0).abs() < 1e-8,
        "the roller ends at the value of its curve: {}",
        path(1)
    );
    // The sled moves back, along its normal only.
    assert!(last(0, 0).abs() > 0.1 && last(0, 1) == 0.0, "{}", path(0));
    assert!(!page(&ended).contains("drawn at their initial position"));
    fs::remove_file(ended.out().join("walls.csv")).unwrap();
    run(crumple_with(&["report", &ended.out().display().to_string()])).with_code(0);
    assert!(
        page(&ended).contains("drawn at their initial position"),
        "there is no file of \
        displacements"
    );
    let still = bars(&[]).with_code(0);
    assert!(facts(&page(&still))["walls"].as_array().unwrap().iter().all(|w| w["path"].is_null()));
}

#[test]
fn a_run_can_do_without_and_so_can_its_fields() {
    let ended = bars(&["--no-report"]).with_code(0);
    assert!(!ended.out().join("report.html").exists());
    let ended = bars(&["--set", "output.field_interval=-1"]).with_code(0);
    assert!(facts(&page(&ended))["model"].is_null());
}

#[test]
fn a_run_that_failed_has_a_page_that_says_why() {
    let ended = run(crumple_with(&[&RUN[..], &["--set", "time.safety=3"]].concat())).with_code(3);
    let page = page(&ended);
    let warnings = between(&page, r#"<section id="warnings""#, "</section>");
    let reason = ended.summary()["reason"].as_str().unwrap().split(':').next().unwrap().to_owned();
    assert!(warnings.contains("The run failed") && warnings.contains(&reason), "{warnings}");
    assert!(warnings.contains("safety = 3 is above 1"), "the warning of the job: {warnings}");
}

#[test]
fn a_folder_of_nothing_is_bad_input() {
    let dir = tempfile::tempdir().unwrap();
    let said =
        run(crumple_with(&["report", &dir.path().display().to_string()])).with_code(2).said();
    assert!(
        said.contains("contains no results of a run") && said.contains("summary.json"),
        "{said}"
    );
}

/// Returns the page after its scripts have run. Pictures are drawn by software, so that no
/// graphics card is needed.
fn opened(browser: &Path, page: &Path, fragment: &str, profile: &Path, more: &[&str]) -> String {
    let mut command = Command::new(browser);
    command.args([
        "--headless=new",
        "--no-sandbox",
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ]);
    command.args(["--window-size=1400,900", "--virtual-time-budget=20000", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", profile.display())).args(more);
    command.arg(format!("file://{}#{fragment}", page.display()));
    let ended = run(command);
    assert!(ended.took < Duration::from_secs(120));
    ended.said()
}

fn attribute(html: &str, name: &str) -> Option<String> {
    let tag = html.split_once("<html")?.1.split_once('>')?.0;
    Some(tag.split_once(&format!("data-{name}=\""))?.1.split_once('"')?.0.to_owned())
}

#[test]
fn a_browser_draws_the_page_without_a_fault() {
    let Some(browser) = tools::chromium() else { return };
    let profile = tempfile::tempdir().unwrap();
    let ended = bars(&[]).with_code(0);
    let file = ended.out().join("report.html");
    for fragment in
        ["check", "check&colour=part&edges=0&time=0.02", "check&colour=element class&view=top"]
    {
        let html = opened(&browser, &file, fragment, profile.path(), &[]);
        let say = |name| attribute(&html, name);
        assert_eq!(
            say("state").as_deref(),
            Some("ready"),
            "{:?} {}",
            say("why"),
            &html[..html.len().min(2000)]
        );
        assert_eq!(say("errors").as_deref(), Some("0"), "{:?}", say("why"));
        let covered: f64 = say("covered").unwrap().parse().unwrap();
        assert!(covered > 0.002, "the model covers {covered} of the stage");
        assert_eq!(
            html.matches("class=\"uplot").count(),
            facts(&page(&ended))["plots"]["plots"].as_array().unwrap().len()
        );
    }
    // Without WebGL, and without fields: no picture, but words, plots and tables.
    let html = opened(&browser, &file, "", profile.path(), &["--disable-3d-apis"]);
    assert_eq!(attribute(&html, "state").as_deref(), Some("without-picture"));
    assert!(
        html.contains("has no WebGL") && html.contains("class=\"uplot"),
        "{:?}",
        attribute(&html, "why")
    );
    let ended = bars(&["--set", "output.field_interval=-1"]).with_code(0);
    let html = opened(&browser, &ended.out().join("report.html"), "", profile.path(), &[]);
    assert_eq!(attribute(&html, "state").as_deref(), Some("without-picture"));
    assert!(html.contains("wrote no field files"));
}
