//! The page of a job before its run (`crumple check --html`): its data against closed forms, and
//! every control in Chromium.

use super::report_page::{Controls, opened, sound};
use crumple_tests::program::{crumple_with, root, run};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A rectangle of 8 by 4, next to it a parallelogram with sides of 8 and 4 that include 60 degrees,
/// a square of 2 by 2 at the height 0.4 over the rectangle, and a truss of length 1.
const JOB: &str = r#"
title = "Plate & cover"
units = "mm, ms, kg"
end_time = 0.1
[mesh]
nodes = [
  [1, 0, 0, 0], [2, 8, 0, 0], [3, 8, 4, 0], [4, 0, 4, 0],
  [5, 14.92820323027551, 4, 0], [6, 14.92820323027551, 8, 0], [7, 8, 0, -1],
  [11, 3, 1, 0.4], [12, 5, 1, 0.4], [13, 5, 3, 0.4], [14, 3, 3, 0.4],
]
shells = [[1, 1, 1, 2, 3, 4], [2, 1, 2, 5, 6, 3], [3, 2, 11, 12, 13, 14]]
trusses = [[10, 3, 2, 7]]
node_sets = { left = [1, 4], right = [5, 6], tip = [7], cover = [11, 12, 13, 14] }
[[material]]
name = "steel"
law = "elastic"
density = 7.85e-6
youngs_modulus = 200.0
poisson = 0.3
[[material]]
name = "wire"
law = "elastic"
density = 7.85e-6
youngs_modulus = 200.0
poisson = 0.3
[[part]]
id = 1
name = "plate"
material = "steel"
thickness = 0.8
[[part]]
id = 2
name = "cover"
material = "steel"
thickness = 0.6
[[part]]
id = 3
name = "strut"
material = "wire"
[part.truss]
area = 0.1
[[fix]]
nodes = "left"
dofs = ["x", "y", "z"]
[[motion]]
nodes = "right"
dofs = ["x"]
velocity = [2.0, 0.0, 0.0]
[[initial_velocity]]
nodes = "cover"
velocity = [0.0, 0.0, -3.0]
[[load]]
nodes = "tip"
force = [0.0, 0.0, -0.1]
[[pressure]]
parts = [2]
pressure = 0.01
[[gravity]]
acceleration = [0.0, 0.0, -9.81e-3]
[[mass]]
nodes = "tip"
mass = 0.5
[[wall]]
name = "floor"
point = [0.0, 0.0, -5.0]
normal = [0.0, 0.0, 1.0]
[[wall]]
name = "ball"
point = [4.0, 2.0, 6.0]
radius = 1.0
[contact]
[output]
"#;

/// Step of a truss of length 1 with the safety factor: 0.9 L sqrt(rho/E).
fn truss_step() -> f64 {
    0.9 * (7.85e-6f64 / 200.0).sqrt()
}

/// Checks a job with a page, and returns the page.
fn checked(job: &str, more: &[&str], code: i32) -> (TempDir, PathBuf, String) {
    let dir = tempfile::tempdir().unwrap();
    let page = dir.path().join("page.html");
    let name = page.display().to_string();
    let args = [&["check", job, "--workers", "2", "--html", &name], more].concat();
    let said = run(crumple_with(&args)).with_code(code).said();
    assert!(said.contains("page.html (") && said.contains("MB"), "{said}");
    let text = fs::read_to_string(&page).unwrap();
    (dir, page, text)
}

fn written(job: &str) -> (TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("job.toml");
    fs::write(&path, job).unwrap();
    (dir, path.display().to_string())
}

fn facts(page: &str) -> Value {
    let begin = r#"<script type="application/json" id="facts">"#;
    let json = page.split_once(begin).unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(json).unwrap()
}

/// Number and values of the condition with a title.
fn condition(facts: &Value, title: &str) -> (u64, String) {
    let all = facts["setup"]["conditions"].as_array().unwrap();
    let found = all.iter().find(|c| c["title"] == title);
    let found = found.unwrap_or_else(|| panic!("no {title}: {all:?}"));
    (found["count"].as_u64().unwrap(), found["detail"].as_str().unwrap().into())
}

fn close(value: &Value, exact: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value}"));
    assert!((value - exact).abs() <= 1e-6 * exact.abs(), "{value} is not {exact}");
}

/// The page of a job has its conditions with their numbers, the element with the smallest step
/// (length over the speed of sound in a bar), and the initial penetrations (half of both
/// thicknesses minus the distance).
#[test]
fn the_page_of_a_job_has_the_numbers_of_the_model() {
    let (_dir, job) = written(JOB);
    let (_out, _, page) = checked(&job, &[], 0);
    let facts = facts(&page);
    for (title, count, words) in [
        ("fixed x y z", 2, ""),
        ("prescribed velocity", 2, "(2, 0, 0), in x"),
        ("initial velocity", 4, "up to 3 mm/ms"),
        ("gravity", 11, "(0, 0, -0.00981)"),
        ("force", 1, "(0, 0, -0.1) on each node"),
        ("pressure", 1, "0.01"),
        ("lumped mass", 1, "0.5 kg in total"),
        ("initial penetrations", 4, "up to 0.3 mm"),
        ("smallest time steps", 4, ""),
    ] {
        assert_eq!(condition(&facts, title), (count, words.into()), "{title}");
    }
    let setup = &facts["setup"];
    let limiting = setup["limiting"].as_array().unwrap();
    assert_eq!((&limiting[0]["element"], &limiting[0]["part"]), (&json!(10), &json!(3)));
    close(&limiting[0]["step"], truss_step());
    assert_eq!(limiting.len(), 4);
    assert!(limiting.windows(2).all(|w| w[0]["ratio"].as_f64() <= w[1]["ratio"].as_f64()));
    let rows = setup["penetrations"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for (row, node) in rows.iter().zip(11..) {
        assert_eq!((&row["node"], &row["element"]), (&json!(node), &json!(1)));
        close(&row["depth"], 0.5 * (0.8 + 0.6) - 0.4);
    }
    let sets: Vec<&str> =
        setup["sets"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert!(["cover", "left", "right", "tip"].iter().all(|name| sets.contains(name)), "{sets:?}");
    assert_eq!(setup["materials"], json!({"1": "steel", "2": "steel", "3": "wire"}));
    assert_eq!(facts["walls"].as_array().unwrap().len(), 2);
    // Areas of the rectangle and the parallelogram, in the table of parts.
    let mass = (8.0 * 4.0 + 8.0 * 4.0 * 60f64.to_radians().sin()) * 0.8 * 7.85e-6;
    let shown = format!("<td class=\"number\">{mass:.4e}</td>");
    assert!(page.contains(&shown), "{shown}");
    let cycles = (0.1 / truss_step()).ceil();
    assert!(page.contains(&format!("about {cycles:.0} cycles")), "{cycles}");
    for words in ["Plate &amp; cover", "4 nodes start inside the thickness", "memory [MB]"] {
        assert!(page.contains(words), "the page lacks {words}");
    }
}

/// A deck: the sled is a wall with a mass, the roller a moving wall, springs hang on fixed nodes.
#[test]
fn the_page_of_a_deck_has_its_walls_and_conditions() {
    let deck = root().join("tests/decks/scenes/sled.k").display().to_string();
    let (_out, _, page) = checked(&deck, &[], 0);
    let facts = facts(&page);
    assert_eq!(condition(&facts, "fixed x y z").0, 2);
    assert_eq!(condition(&facts, "initial velocity"), (45, "up to 10 mm/ms".into()));
    let (_, sled) = condition(&facts, "wall with a mass");
    assert!(sled.contains("sled: mass 0.02 kg, 2 mm/ms along its normal"), "{sled}");
    let (_, roller) = condition(&facts, "moving wall");
    assert!(roller.contains("roller: (0, 0, 1), times curve `curve-2`"), "{roller}");
    assert_eq!(facts["model"]["elements"], json!(32 + 4), "shells and springs");
}

/// A job with errors has a page with the errors, and the exit code of errors.
#[test]
fn the_page_of_a_job_that_cannot_run_lists_its_errors() {
    let (_dir, job) = written(&JOB.replace("nodes = \"tip\"\nmass", "nodes = \"top\"\nmass"));
    let (_out, file, page) = checked(&job, &[], 2);
    assert!(page.contains("there is no node set `top`"), "the error is on the page");
    let Some(mut browser) = crumple_tests::browser::Browser::start() else { return };
    browser.open(&format!("file://{}", file.display()));
    let state = "document.documentElement.dataset.state === 'without-picture'";
    browser.wait("the page is there", state);
    let said = browser.evaluate("byId('absent').innerText").to_string();
    assert!(said.contains("the job has errors"), "{said}");
    sound(&mut browser);
}

/// A mesh file: thickness, warpage and fixed nodes of a job with `mesh.file`.
#[test]
fn the_page_of_a_job_with_a_mesh_file() {
    let dir = tempfile::tempdir().unwrap();
    let (mesh, rest) = JOB.split_once("[[material]]").unwrap();
    let (head, mesh) = mesh.split_once("[mesh]\n").unwrap();
    fs::write(dir.path().join("mesh.toml"), mesh).unwrap();
    let job = format!("{head}[mesh]\nfile = \"mesh.toml\"\n[[material]]{rest}");
    let path = dir.path().join("job.toml");
    fs::write(&path, job).unwrap();
    let (_out, _, page) = checked(&path.display().to_string(), &[], 0);
    assert_eq!(condition(&facts(&page), "initial penetrations").0, 4);
}

/// Values of the page in the browser are those of closed forms: aspect and skew of a parallelogram,
/// Jacobian of a rectangle, steps, thickness, velocity and penetration.
#[test]
fn values_in_the_browser_have_their_closed_forms() {
    let (_dir, job) = written(JOB);
    let (_out, page, _) = checked(&job, &[], 0);
    let Some(mut browser) = opened(&page, "") else { return };
    let element = |title: &str, id: u64| {
        format!(
            "crumple.setup.scalars.find((s) => s.title === {title:?}).values[\
             crumple.model.elementIds.indexOf({id})]"
        )
    };
    let node = |title: &str, id: u64| {
        format!(
            "crumple.setup.nodeScalars.find((s) => s.title === {title:?}).values[\
             crumple.model.nodeIds.indexOf({id})]"
        )
    };
    for (script, exact) in [
        (element("aspect ratio", 1), 2.0),
        (element("aspect ratio", 2), 2.0),
        (element("aspect ratio", 3), 1.0),
        (element("skew", 2), 30.0),
        (element("Jacobian ratio", 1), 1.0),
        (element("thickness", 1), 0.8),
        (element("thickness", 3), 0.6),
        (element("time step", 10), truss_step()),
        (node("initial velocity", 12), 3.0),
        (node("lumped mass", 7), 0.5),
        (node("initial penetration", 13), 0.3),
        (node("initial penetration", 1), 0.0),
    ] {
        close(&browser.evaluate(&script), exact);
    }
    let nan = browser.evaluate(&format!("Number.isNaN({})", element("thickness", 10)));
    assert_eq!(nan, true, "a truss has no thickness");
    // The arrow of the pressure points against the normal of the cover, from its middle.
    let arrow = "(() => { const { setup } = crumple; const p = setup.conditions.find((c) => \
                 c.title === 'pressure'); return p.columns.map((c) => c[0]); })()";
    let arrow: Vec<f64> = serde_json::from_value(browser.evaluate(arrow)).unwrap();
    let exact = [4.0, 2.0, 0.4, 0.0, 0.0, -0.01];
    assert!(arrow.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-6), "{arrow:?}");
    let set = "(() => { const { setup, model } = crumple; const set = setup.sets.find((s) => \
               s.name === 'right'); return Array.from(set.nodes, (n) => model.nodeIds[n]); })()";
    assert_eq!(browser.evaluate(set), json!([5, 6]));
    sound(&mut browser);
}

/// Every control of the page is used once, by its effect. At the end none may be left.
#[test]
fn every_control_of_the_page_before_the_run_has_its_effect() {
    let (_dir, job) = written(JOB);
    let (_out, page, _) = checked(&job, &[], 0);
    let Some(browser) = opened(&page, "") else { return };
    let mut page = Controls { browser, used: BTreeSet::new() };
    page.browser.picture("model-page");
    picture(&mut page);
    conditions(&mut page);
    lists(&mut page);
    leaving(&mut page);
    let all = "[...document.querySelectorAll('button, input, select')].filter((e) => \
               !e.closest('.of-run')).map((e) => e.id || (e.dataset.view ? 'view-' + \
               e.dataset.view : e.className || 'part-box'))";
    let all: BTreeSet<String> = serde_json::from_value(page.browser.evaluate(all)).unwrap();
    // There are no contact forces before the run.
    let hidden = ["forces", "node-forces"].map(String::from);
    let left: Vec<_> = all.iter().filter(|id| !page.used.contains(*id)).collect();
    assert_eq!(left, hidden.iter().collect::<Vec<_>>(), "controls that no test uses");
    sound(&mut page.browser);
}

fn picture(page: &mut Controls) {
    let titles = page.browser.evaluate("crumple.ways.map((way) => way.title)");
    let titles: Vec<String> = serde_json::from_value(titles).unwrap();
    for wanted in [
        "part",
        "material",
        "thickness",
        "time step",
        "aspect ratio",
        "warpage",
        "Jacobian ratio",
        "skew",
        "initial velocity",
        "initial penetration",
    ] {
        assert!(titles.iter().any(|title| title == wanted), "{titles:?} lacks {wanted}");
    }
    for (number, title) in titles.iter().enumerate() {
        page.set("colour", number.to_string());
        let legend = page.text("legend");
        assert!(legend.contains(title), "{legend}");
    }
    let step = titles.iter().position(|title| title == "time step").unwrap();
    page.set("colour", step.to_string());
    assert!(page.text("legend").contains("time step [ms]"));
    page.changes("another end of the scale", |page| page.set("top", "0.1"));
    page.changes("another begin of the scale", |page| page.set("bottom", "-0.01"));
    page.changes("smooth colours", |page| page.set("smooth", true));
    page.changes("no edges", |page| page.set("edges", false));
    page.changes("no walls", |page| page.set("walls", false));
    page.set("walls", true);
    for view in ["front", "side", "top", "iso"] {
        page.changes(view, |page| page.browser.click(&format!("[data-view={view}]")));
        page.used.insert(format!("view-{view}"));
    }
    page.changes("parallel lines of view", |page| page.set("parallel", true));
    page.changes("a section", |page| page.set("cut-axis", "x"));
    page.changes("another place of the section", |page| page.set("cut-place", "3"));
    page.changes("its other side", |page| page.set("cut-flip", true));
    page.set("cut-axis", "none");
    page.browser.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))");
    page.changes("no parts", |page| page.click("parts-none"));
    page.changes("all parts", |page| page.click("parts-all"));
    page.changes("a hidden part", |page| page.browser.click("#parts-list .eye"));
    page.browser.click("#parts-list .eye");
    page.changes("a transparent part", |page| {
        page.browser.click("#parts-list input[type=checkbox]");
    });
    page.changes("its opacity", |page| page.set("opacity", "0.9"));
    page.used.extend(["eye".into(), "part-box".into()]);
}

fn conditions(page: &mut Controls) {
    page.changes("no conditions", |page| page.click("conditions-none"));
    page.changes("one condition", |page| page.browser.click("#conditions-table .condition"));
    page.used.insert("condition".into());
    page.changes("all conditions", |page| page.click("conditions-all"));
    page.changes("larger arrows", |page| page.set("arrow-size", "2.5"));
    let rows = page.number("byId('conditions-table').tBodies[0].rows.length");
    assert_eq!(rows, 9.0);
}

fn lists(page: &mut Controls) {
    let set = "[...byId('set').options].find((o) => o.textContent === 'right').value";
    let set = page.browser.evaluate(set);
    page.changes("the set", |page| page.set("set", set));
    assert_eq!(page.text("set-words"), "2 nodes");
    page.changes("no marks of small steps", |page| page.set("limiting-marks", false));
    let table = page.text("limiting-table");
    assert!(table.contains("3 strut"), "{table}");
    page.browser.click("#limiting-table .show");
    assert!(page.text("picked").contains("element 10"), "{}", page.text("picked"));
    page.browser.click("#penetrations-table .show");
    page.used.insert("show".into());
    let picked = page.text("picked");
    for words in ["node 11", "initial penetration", "0.3 mm", "initial velocity", "cover"] {
        assert!(picked.contains(words), "{picked} lacks {words}");
    }
    page.set("find-kind", "element");
    page.set("find-id", "2");
    page.click("find");
    let picked = page.text("picked");
    for words in ["element 2", "1 plate", "steel", "30 degrees", "0.8 mm"] {
        assert!(picked.contains(words), "{picked} lacks {words}");
    }
    page.click("picked-none");
}

fn leaving(page: &mut Controls) {
    let folder = tempfile::tempdir().unwrap();
    page.browser.keep_downloads(folder.path());
    page.click("save-picture");
    let path: &Path = &folder.path().join("picture.png");
    let began = std::time::Instant::now();
    while fs::metadata(path).map_or(0, |about| about.len()) == 0 {
        assert!(began.elapsed().as_secs() < 200, "the picture is not saved");
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    page.click("link");
    page.browser.wait("the link is there", "byId('words').textContent.includes('link')");
}
