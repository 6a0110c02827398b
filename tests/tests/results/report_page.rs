//! The report page in Chromium, as an engineer uses it: every control, the formulas behind the
//! curves, files that are saved, links, print, and two runs in step.

use crumple_tests::browser::Browser;
use crumple_tests::program::{Ended, crumple_with, root, run};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// A short crush of a coarse tube, with the motion of nodes of its head.
pub fn crushed(more: &[&str]) -> Ended {
    let dir = tempfile::tempdir().unwrap();
    let job = fs::read_to_string(root().join("cases/tube/job.toml")).unwrap();
    let head = "name = \"head\"\nnodes = \"head\"\n";
    let nodes = format!("{head}head = true\n[[output.node]]\nname = \"foot\"\nids = [1]\n");
    assert!(job.contains(head), "the job has the nodes of its head");
    let job = job.replace(head, &nodes);
    fs::write(dir.path().join("job.toml"), job).unwrap();
    let folder = dir.path().display().to_string();
    let settings = [
        "end_time=0.4",
        "scene.elements=4",
        "output.history_interval=0.002",
        "output.field_interval=0.05",
    ];
    let mut args = vec!["run", &folder, "--workers", "1"];
    settings.iter().chain(more).for_each(|setting| args.extend(["--set", setting]));
    run(crumple_with(&args)).with_code(0)
}

/// Opens a page, and waits until its picture is drawn.
pub fn opened(page: &Path, fragment: &str) -> Option<Browser> {
    let mut browser = Browser::start()?;
    open(&mut browser, page, fragment);
    Some(browser)
}

fn open(browser: &mut Browser, page: &Path, fragment: &str) {
    browser.open("about:blank"); // a page does not look at a fragment again
    browser.open(&format!("file://{}#{fragment}", page.display()));
    browser.wait("the page is drawn", "document.documentElement.dataset.state === 'ready'");
}

pub fn sound(browser: &mut Browser) {
    assert_eq!(browser.evaluate("document.documentElement.dataset.errors"), "0");
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}

/// Drives the page by the ids of its controls, and notes which were used.
pub struct Controls {
    pub browser: Browser,
    pub used: BTreeSet<String>,
}

impl Controls {
    /// Sets the value of a list or field, or the state of a box, as a user does.
    pub fn set(&mut self, id: &str, value: impl Into<Value>) {
        let value = value.into();
        let key = if value.is_boolean() { "checked" } else { "value" };
        self.browser.evaluate(&format!(
            "(() => {{ const e = byId({id:?}); if (e.closest('[hidden]')) throw new \
            Error('hidden'); \
             e.{key} = {value}; if (e.{key} !== {value}) throw new Error(e.{key}); \
             e.dispatchEvent(new Event('input', {{ bubbles: true }})); \
             e.dispatchEvent(new Event('change', {{ bubbles: true }})); }})()"
        ));
        self.used.insert(id.into());
    }

    pub fn click(&mut self, id: &str) {
        self.browser.click(&format!("#{id}"));
        self.used.insert(id.into());
    }

    pub fn number(&mut self, script: &str) -> f64 {
        let value = self.browser.evaluate(script);
        value.as_f64().unwrap_or_else(|| panic!("{script}: {value}"))
    }

    pub fn text(&mut self, id: &str) -> String {
        let text = self.browser.evaluate(&format!("byId({id:?}).innerText"));
        text.as_str().unwrap_or_else(|| panic!("{id}: {text}")).to_owned()
    }

    /// The pixels of the picture of each run as text.
    fn pixels(&mut self) -> Vec<Value> {
        let pictures = self.browser.evaluate(
            "[crumple.view, crumple.second?.view].filter(Boolean).map((view) => (view.draw(), \
             view.canvas.toDataURL()))",
        );
        serde_json::from_value(pictures).unwrap()
    }

    /// Does something that must change the pictures of all runs.
    pub fn changes(&mut self, what: &str, act: impl FnOnce(&mut Self)) {
        let before = self.pixels();
        act(self);
        for (run, (now, before)) in self.pixels().iter().zip(&before).enumerate() {
            assert_ne!(now, before, "{what} changes the picture of run {run}");
        }
    }

    /// No control of the page may be left. Contact forces are offered if there is contact between
    /// parts.
    fn all_are_used(&mut self) {
        let all = "[...document.querySelectorAll('button, input, select')].map((e) => e.id || \
                   (e.dataset.view ? 'view-' + e.dataset.view : e.className || 'part-box'))";
        let all: BTreeSet<String> = serde_json::from_value(self.browser.evaluate(all)).unwrap();
        let hidden = ["forces", "node-forces"].map(String::from);
        let left: Vec<_> = all.iter().filter(|id| !self.used.contains(*id)).collect();
        assert_eq!(left, hidden.iter().collect::<Vec<_>>(), "controls that no test uses");
    }
}

/// Every control is used once, by its effect. At the end no control of the page may be left.
#[test]
fn every_control_has_its_effect() {
    let ended = crushed(&[]);
    let page = ended.out().join("report.html");
    let Some(browser) = opened(&page, "") else { return };
    let mut page = Controls { browser, used: BTreeSet::new() };
    picture(&mut page);
    page.browser.picture("report-controls");
    picking(&mut page);
    workbench(&mut page, 1);
    page.browser.picture("report-workbench");
    figures(&mut page, &[(ended.summary(), String::new())]);
    leaving(&mut page);
    page.all_are_used();
    sound(&mut page.browser);
}

/// The same for two runs: each control of the picture changes both pictures, curves and figures
/// are there for both.
#[test]
fn every_control_of_two_runs_has_its_effect() {
    let runs = [crushed(&[]), crushed(&["part.tube.thickness=1.4"])];
    let folders = [0, 1].map(|i| runs[i].out().display().to_string());
    run(crumple_with(&["report", &folders[0], &folders[1]])).with_code(0);
    let Some(browser) = opened(&runs[0].out().join("compare.html"), "") else { return };
    let mut page = Controls { browser, used: BTreeSet::new() };
    picture(&mut page);
    picking(&mut page);
    workbench(&mut page, 2);
    let named = [0, 1].map(|i| (runs[i].summary(), format!(" ({})", folders[i])));
    figures(&mut page, &named);
    leaving(&mut page);
    page.all_are_used();
    sound(&mut page.browser);
}

fn picture(page: &mut Controls) {
    page.set("slider", "0.35");
    assert!(page.text("clock").contains("0.35"), "{}", page.text("clock"));
    page.set("speed", "4");
    page.click("play");
    page.browser
        .wait("it has played to its end", "!crumple.playing && crumple.time === crumple.end");
    let titles = page.browser.evaluate("crumple.ways.map((way) => way.title)");
    for title in titles.as_array().unwrap() {
        let number = page
            .browser
            .evaluate(&format!("String(crumple.ways.findIndex((way) => way.title === {title}))"));
        page.set("colour", number);
        let legend = page.text("legend");
        assert!(legend.contains(title.as_str().unwrap()), "{legend}");
    }
    for title in [
        "displacement",
        "velocity",
        "pressure",
        "largest principal stress",
        "triaxiality",
        "thickness change",
    ] {
        assert!(titles.as_array().unwrap().contains(&json!(title)), "{titles} has no {title}");
    }
    assert!(
        !titles.as_array().unwrap().contains(&json!("contact force")),
        "the job does not ask for it"
    );
    let way = |title: &str| format!("String(crumple.ways.findIndex((w) => w.title === {title:?}))");
    let strain = page.browser.evaluate(&way("plastic strain"));
    page.set("colour", strain);
    page.changes("another begin of the scale", |page| page.set("bottom", "-0.01"));
    page.changes("another end of the scale", |page| page.set("top", "0.37"));
    page.changes("smooth colours", |page| page.set("smooth", true));
    page.changes("no edges", |page| page.set("edges", false));
    page.changes("no walls", |page| page.set("walls", false));
    page.set("follow", true);
    for view in ["front", "side", "top", "iso"] {
        page.changes(view, |page| page.browser.click(&format!("[data-view={view}]")));
        page.used.insert(format!("view-{view}"));
    }
    page.changes("parallel lines of view", |page| page.set("parallel", true));
    page.changes("displacements times 3", |page| page.set("magnify", "3"));
    page.set("magnify", "1");
    page.changes("a section", |page| page.set("cut-axis", "y"));
    page.changes("its place", |page| page.set("cut-place", "-5"));
    page.changes("the other side", |page| page.set("cut-flip", true));
    page.set("cut-axis", "none");
    page.browser.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))");
    page.changes("a hidden part", |page| page.browser.click(".parts-list .eye"));
    page.changes("all parts", |page| page.click("parts-all"));
    page.changes("no part", |page| page.click("parts-none"));
    page.click("parts-all");
    page.changes("a transparent part", |page| page.browser.click(".parts-list input"));
    page.changes("its opacity", |page| page.set("opacity", "0.8"));
    page.used.extend(["eye".into(), "part-box".into()]);
    let way = page.browser.evaluate(&way("part"));
    page.set("colour", way);
    page.changes("the legend hides a part", |page| page.browser.click("#legend button"));
    page.click("parts-all");
}

/// A click into the picture picks the element that is drawn there: its outline is around the
/// pointer. Ids are those of the mesh.
fn picking(page: &mut Controls) {
    page.browser.click("[data-view=iso]");
    page.browser.click("#canvas");
    let picked = page.text("picked");
    assert!(picked.contains("element ") && picked.contains("nearest node"), "{picked}");
    let around = "(() => { const { picker, view } = crumple; const all = \
                  picker.corners().flatMap(([patches, corners]) => corners.map((c) => \
                  view.pixels(new THREE.Vector3(...patches.place(c, 0))))); const [x, y] = \
                  [view.canvas.clientWidth / 2, view.canvas.clientHeight / 2]; const inside = \
                  (v, at) \
                  => Math.min(...v) <= at + 1 && Math.max(...v) >= at - 1; return \
                  inside(all.map((p) \
                  => p.x), x) && inside(all.map((p) => p.y), y); })()";
    assert_eq!(page.browser.evaluate(around), true, "the element is around the pointer");
    page.click("picked-none");
    assert_eq!(page.browser.evaluate("byId('picked').hidden"), true);
    page.set("find-kind", "node");
    page.set("find-id", "3");
    page.click("find");
    assert!(page.text("picked").contains("node 3"), "{}", page.text("picked"));
    // Its displacement over time is that of the history of the same id.
    page.click("picked-course");
    let last = page.number("crumple.bench.curves.at(-1).y.at(-1)");
    let moved = "(() => { const p = crumple; const node = p.model.nodeIds.indexOf(3); const x = \
    (f) => \
                 [0, 1, 2].map((c) => f.grid.origin[c] + f.grid.unit * f.position[c][node]); \
                 const [a, \
                 b] = [x(p.model.frames[0]), x(p.model.frames.at(-1))]; return \
                 Math.hypot(...a.map((v, \
                 c) => v - b[c])); })()";
    let moved = page.number(moved);
    assert!(moved > 0.0 && (last / moved - 1.0).abs() < 1e-6, "{last} {moved}");
    page.set("find-kind", "element");
    page.set("find-id", "999999");
    page.click("find");
    assert!(page.text("words").contains("no element 999999"), "{}", page.text("words"));
    page.set("find-id", "2");
    page.click("find");
    assert!(page.text("picked").contains("element 2"), "{}", page.text("picked"));
}

/// Adding a curve adds one for each of the `runs`.
fn workbench(page: &mut Controls, runs: usize) {
    let first = page.browser.evaluate("crumple.bench.curves[0].label").to_string();
    assert!(
        first.contains("wall floor over displacement"),
        "force over displacement first: {first}"
    );
    page.click("bench-clear");
    page.set("bench-object", "model");
    page.set("bench-quantity", "kinetic");
    page.set("bench-over-object", "model");
    page.set("bench-over", "time");
    page.set("bench-operation", "integral");
    page.click("bench-add");
    assert_eq!(page.number("crumple.bench.curves.length"), runs as f64);
    for run in 0..runs {
        let sum = page.number(&format!("crumple.bench.curves[{run}].y.at(-1)"));
        let wanted = page.number(&format!(
            "(({{ histories: h }}) => integral(h.time, h.quantity(h.object('model'), \
             'kinetic').values).at(-1))(crumple.bench.runs[{run}])"
        ));
        assert!(sum > 0.0 && (sum / wanted - 1.0).abs() < 1e-12);
    }
    page.set("bench-operation", "value");
    page.set("bench-object", "wall floor");
    page.set("bench-quantity", "mean force (magnitude)");
    page.set("bench-filter", "CFC 600");
    page.click("bench-add");
    let table = page.text("bench-curves");
    assert!(table.contains("CFC 600 of wall floor") && table.contains("kN"), "{table}");
    let curves = 2.0 * runs as f64;
    assert_eq!(page.number("document.querySelectorAll('#bench-chart .peak').length"), curves);
    page.set("bench-marks", false);
    assert_eq!(page.number("document.querySelectorAll('#bench-chart .peak').length"), 0.0);
    page.set("bench-marks", true);
    page.browser.click("#bench-curves .remove");
    page.used.insert("remove".into());
    assert_eq!(page.number("crumple.bench.curves.length"), curves - 1.0);
    // A click into the chart selects the time of its nearest point.
    page.browser.evaluate("crumple.go(0)");
    page.browser.click("#bench-chart svg");
    assert!(page.number("crumple.time") > 0.0);
}

/// The tables have the values of the summaries, unless the user chooses otherwise. `runs` are these
/// with what follows the names of their objects.
fn figures(page: &mut Controls, runs: &[(Value, String)]) {
    let cells = |page: &mut Controls, table: &str| -> Vec<Vec<String>> {
        let all = format!(
            "[...byId('{table}').tBodies[0].rows].map((r) => [...r.cells].map((c) => \
             c.textContent))"
        );
        serde_json::from_value(page.browser.evaluate(&all)).unwrap()
    };
    let same = |shown: &str, known: &Value| {
        let (shown, known) = (shown.parse::<f64>().unwrap(), known.as_f64().unwrap());
        assert!((shown / known - 1.0).abs() < 1e-3, "{shown} on the page, {known} in the summary");
    };
    let heads = cells(page, "head-table");
    assert!(heads.iter().all(|row| row[0].starts_with("node head ")), "{heads:?}");
    let injuries = runs.iter().flat_map(|(summary, of_run)| {
        let all = summary["head_injury"].as_array().unwrap().iter();
        all.map(move |injury| (format!("{}{of_run}", injury["node"].as_str().unwrap()), injury))
    });
    let injuries: Vec<_> = injuries.collect();
    assert!(injuries.iter().all(|(name, _)| name.starts_with("node head ")), "{injuries:?}");
    let (_, injury) = injuries.iter().find(|(name, _)| *name == heads[0][0]).unwrap();
    same(&heads[0][1], &injury["peak_g"]);
    same(&heads[0][2], &injury["hic15"]);
    same(&heads[0][4], &injury["hic36"]);
    let rows = cells(page, "crush-table");
    assert_eq!(rows.len(), runs.len());
    for (row, (summary, of_run)) in rows.iter().zip(runs) {
        let crush = &summary["crush"][0];
        assert_eq!(format!("{}{of_run}", crush["force"].as_str().unwrap()), row[0]);
        for (place, key) in [(1, "peak"), (3, "mean"), (5, "stroke"), (6, "energy")] {
            same(&row[place], &crush[key]);
        }
        same(&row[7], &crush["specific_energy"]);
    }
    let numbers = |page: &mut Controls| -> Vec<Vec<f64>> {
        let number = |cell: &String| cell.parse::<f64>().unwrap();
        cells(page, "crush-table").iter().map(|r| r[1..].iter().map(number).collect()).collect()
    };
    let first = numbers(page);
    for row in &first {
        let [peak, _, mean, ratio, stroke, energy, specific] = row[..] else { panic!("{row:?}") };
        assert!((stroke - 0.4 * 15.0).abs() < 0.1, "the head moves at 15 mm/ms: {stroke}");
        assert!((mean * stroke / energy - 1.0).abs() < 1e-3);
        assert!((mean / peak / ratio - 1.0).abs() < 1e-3);
        assert!(specific > energy, "the tube has less than a kilogram");
    }
    let compare = |page: &mut Controls, what: &str, is_so: fn(&[f64], &[f64]) -> bool| {
        let now = numbers(page);
        assert!(now.iter().zip(&first).all(|(now, first)| is_so(now, first)), "{what}: {now:?}");
    };
    page.set("crush-direction", "z");
    compare(page, "it moves along z", |now, first| (now[4] / first[4] - 1.0).abs() < 0.01);
    page.set("crush-filter", "CFC 1000");
    compare(page, "the filter lowers the peak", |now, first| now[0] < first[0]);
    page.set("crush-mass", "part 1 tube");
    let other = page.browser.evaluate("byId('crush-over').options[1].value");
    page.set("crush-over", other);
    let before = page.text("head-table");
    assert!(before.contains("HIC15") && before.contains("node head"), "{before}");
    page.set("head-filter", "none");
    assert_ne!(page.text("head-table"), before);
}

/// Files, the link, and the jump from a warning.
fn leaving(page: &mut Controls) {
    let folder = tempfile::tempdir().unwrap();
    page.browser.keep_downloads(folder.path());
    let saved = |page: &mut Controls, id: &str, name: &str| {
        page.click(id);
        let path = folder.path().join(name);
        let began = std::time::Instant::now();
        while fs::metadata(&path).map_or(0, |about| about.len()) == 0 {
            assert!(began.elapsed().as_secs() < 200, "{name} is not saved");
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        let bytes = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        bytes
    };
    let csv = String::from_utf8(saved(page, "bench-csv", "curves.csv")).unwrap();
    // Each curve has a head, and an empty line before the next one.
    let lines = page.number("crumple.bench.curves.reduce((n, c) => n + c.x.length + 2, -1)");
    assert!(csv.starts_with("time [ms],") && csv.lines().count() as f64 == lines);
    assert!(saved(page, "bench-svg", "curves.svg").starts_with(b"<svg"));
    assert!(saved(page, "crush-csv", "crush.csv").starts_with(b"force,peak [kN]"));
    assert!(saved(page, "save-picture", "picture.png").starts_with(b"\x89PNG"));
    assert!(saved(page, "save-film", "film.webm").starts_with(b"\x1a\x45\xdf\xa3"), "EBML");
    page.browser.evaluate("crumple.go(0.3)");
    page.click("link");
    page.browser.wait("the link is there", "byId('words').textContent.includes('link')");
    let link = page.browser.evaluate("location.hash.slice(1)");
    let state = "[crumple.time, crumple.way.title, crumple.picker.name(), \
    byId('parallel').checked, \
                 crumple.view.surface.style.ghosts[0], \
                 crumple.view.camera.position.toArray().map((x) => x.toFixed(2)).join()]";
    let before = page.browser.evaluate(state);
    let path = page.browser.evaluate("location.pathname");
    open(&mut page.browser, Path::new(path.as_str().unwrap()), link.as_str().unwrap());
    assert_eq!(page.browser.evaluate(state), before, "{link}");
}

/// A warning with a time and an element has a button that shows both.
#[test]
fn a_warning_jumps_to_its_time_and_element() {
    let ended = crushed(&[]);
    let log = ended.out().join("log.jsonl");
    let line = json!({"level": "WARN", "fields": {"warning": "at time 2.000000e-1 part `tube`: it \
        folds; element 5 at (1, 2, 3). A cure"}});
    let text = fs::read_to_string(&log).unwrap_or_default();
    fs::write(&log, format!("{text}{line}\n")).unwrap();
    run(crumple_with(&["report", &ended.out().display().to_string()])).with_code(0);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    browser.click("#warnings li[data-element='5'] button");
    assert_eq!(browser.evaluate("crumple.time"), 0.2);
    assert_eq!(browser.evaluate("crumple.picker.name()"), "element 5");
    sound(&mut browser);
}

/// A rigid plate moves at 2 mm/ms until a wall stops it after 1 mm. Without a node in the
/// histories, its displacement is that of its mass centre, in the summary and on the page.
#[test]
fn a_rigid_part_gives_the_displacement_of_crush_figures() {
    let job = r#"
        title = "A rigid plate against a wall"
        units = "mm, ms, kg"
        end_time = 1.0
        [time]
        dt_max = 0.004              # rigid bodies have no stable step
        [mesh]
        nodes = [[1, 0.0, 0.0, 0.0], [2, 9.0, 0.0, 0.0], [3, 9.0, 9.0, 0.0], [4, 0.0, 9.0, 0.0]]
        shells = [[1, 1, 1, 2, 3, 4]]
        [[material]]
        name = "steel"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 207.0
        poisson = 0.3
        [[part]]
        id = 1
        name = "ram"
        material = "steel"
        thickness = 1.0
        [[rigid]]
        name = "ram"
        parts = [1]
        [[initial_velocity]]
        velocity = [0.0, 0.0, -2.0]
        [[wall]]
        name = "stop"
        point = [0.0, 0.0, -1.0]
        normal = [0.0, 0.0, 1.0]
    "#;
    let folder = tempfile::tempdir().unwrap();
    let crushed = |more: &str| {
        fs::write(folder.path().join("job.toml"), format!("{job}{more}")).unwrap();
        run(crumple_with(&["run", &folder.path().display().to_string()])).with_code(0)
    };
    let with_node = crushed("[[output.node]]\nname = \"corner\"\nids = [1]\n");
    let wanted = &with_node.summary()["crush"][0];
    assert_eq!(wanted["over"], "node corner 1", "a recorded displacement comes first");
    let ended = crushed("");
    let crush = &ended.summary()["crush"][0];
    assert_eq!(crush["over"], "mass centre of part 1 ram");
    let stroke = |crush: &Value| crush["stroke"].as_f64().unwrap();
    let half_interval = 0.5 * 1.0 / 200.0;
    assert!((stroke(crush) - stroke(wanted)).abs() <= 2.0 * half_interval, "{crush} {wanted}");
    assert!((stroke(wanted) - 1.0).abs() < 0.1, "{wanted}");
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let over = browser.evaluate("[...byId('crush-over').options].map((o) => o.value)");
    assert_eq!(over, json!(["mass centre of part 1 ram"]));
    let cell = "Number(byId('crush-table').tBodies[0].rows[0].cells[5].textContent)";
    let shown = browser.evaluate(cell).as_f64().unwrap();
    assert!((shown / stroke(crush) - 1.0).abs() < 1e-4, "{shown} {crush}");
    sound(&mut browser);
}

/// In seconds, the ticks of a crash are thousandths; each has its own label.
#[test]
fn ticks_of_short_times_differ() {
    let folder = tempfile::tempdir().unwrap();
    let row = |i: usize| format!("{:.9e},{i}\n", 1e-5 * i as f64);
    let rows: String = (0..=200).map(row).collect();
    let text = format!("time [s],kinetic [mJ]\n{rows}");
    fs::write(folder.path().join("history.csv"), text).unwrap();
    run(crumple_with(&["report", &folder.path().display().to_string()])).with_code(0);
    let Some(mut browser) = Browser::start() else { return };
    browser.open(&format!("file://{}", folder.path().join("report.html").display()));
    browser.wait("the plots", "document.documentElement.dataset.state === 'without-picture'");
    let axis = "crumple.plots.charts[0].plot.axes[0]";
    let ticks: Vec<f64> =
        serde_json::from_value(browser.evaluate(&format!("{axis}._splits"))).unwrap();
    let labels: Vec<String> =
        serde_json::from_value(browser.evaluate(&format!("{axis}._values"))).unwrap();
    assert!(ticks.len() > 3 && ticks.len() == labels.len(), "{ticks:?} {labels:?}");
    for (tick, label) in ticks.iter().zip(&labels) {
        assert!((label.parse::<f64>().unwrap() - tick).abs() < 1e-9, "{label} at {tick}");
    }
}

/// Contact forces of two bars are equal and opposite; their arrows are drawn at a link that asks
/// for them.
#[test]
fn contact_forces_are_arrows() {
    let ended = run(crumple_with(&[
        "run",
        "cases/bars",
        "--workers",
        "1",
        "--set",
        "output.field_interval=0.01",
    ]))
    .with_code(0);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "time=0") else { return };
    let parts = browser.evaluate("crumple.arrows.parts.length");
    assert_eq!(parts, 2);
    browser.evaluate(
        "(() => { const f = crumple.arrows.parts[0].force; const size = (i) => \
        Math.hypot(...f.map((q) \
         => q.values[i])); let best = 0; crumple.read.time.forEach((_, i) => { if (size(i) > \
         size(best)) best = i; }); crumple.go(crumple.read.time[best]); })()",
    );
    browser.click("#forces");
    let points = browser.evaluate("[...crumple.arrows.object.geometry.attributes.position.array]");
    let points: Vec<f64> = serde_json::from_value(points).unwrap();
    assert_eq!(points.len(), 2 * 10 * 3, "two arrows of five lines");
    let along =
        |arrow: usize| [0, 1, 2].map(|c| points[30 * arrow + 3 + c] - points[30 * arrow + c]);
    let (a, b) = (along(0), along(1));
    let size = a.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!(size > 0.0 && (0..3).all(|c| (a[c] + b[c]).abs() < 1e-3 * size), "{a:?} {b:?}");
    sound(&mut browser);
}

/// On paper the page has no controls, and nothing is wider than the paper.
#[test]
fn the_page_fits_paper() {
    let ended = crushed(&[]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let pdf = browser.printed();
    assert!(pdf.starts_with(b"%PDF"));
    assert_eq!(browser.evaluate("byId('print').classList.contains('made')"), true);
    browser.resize(703, 1000); // A4 without margins, at 96 pixels per inch
    browser.print_media(true);
    let wide = browser.evaluate(
        "[...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > \
         document.documentElement.clientWidth + 1).map((e) => `${e.tagName} ${e.id} \
         ${e.className}`)",
    );
    assert_eq!(wide, json!([]), "wider than the paper");
    let shown = browser.evaluate(
        "[getComputedStyle(byId('controls')).display, \
        getComputedStyle(byId('print')).display]",
    );
    assert_eq!(shown, json!(["none", "block"]));
    browser.picture("report-print");
    sound(&mut browser);
}

/// Two runs are in step: one time, one camera, one scale, and plots with the lines of both.
#[test]
fn two_runs_are_compared_in_step() {
    let runs = [crushed(&[]), crushed(&["part.tube.thickness=1.4"])];
    let folders = [0, 1].map(|i| runs[i].out().display().to_string());
    let said = run(crumple_with(&["report", &folders[0], &folders[1]])).with_code(0).said();
    assert!(said.contains("compare.html"), "{said}");
    let file = runs[0].out().join("compare.html");
    assert!(fs::metadata(&file).unwrap().len() < 20_000_000);
    let Some(mut browser) = opened(&file, "time=0.3&colour=von Mises stress") else { return };
    let state = "[crumple.second.way.title, crumple.second.way.top === crumple.way.top, \
                 crumple.second.model.frames[crumple.second.frame].time <= 0.3]";
    assert_eq!(browser.evaluate(state), json!(["von Mises stress", true, true]));
    browser.click("[data-view=top]");
    let cameras = "[crumple.view, crumple.second.view].map((v) => \
                   v.camera.position.toArray().map((x) => x.toFixed(6)))";
    let cameras = browser.evaluate(cameras);
    assert_eq!(cameras[0], cameras[1], "one camera");
    browser.evaluate("(() => { byId('smooth').click(); byId('parallel').click(); })()");
    let same = "crumple.second.view.surface.style.smooth && crumple.second.view.parallel";
    assert_eq!(browser.evaluate(same), true);
    let plots = browser.evaluate("document.getElementById('plots').innerText").to_string();
    for folder in &folders {
        assert!(plots.contains(&format!("total ({folder})")), "{plots}");
    }
    let labels = browser.evaluate("crumple.bench.curves.map((c) => c.label)").to_string();
    assert!(folders.iter().all(|folder| labels.contains(folder)), "{labels}");
    let rows =
        "[...byId('crush-table').tBodies[0].rows].map((r) => Number(r.cells[1].textContent))";
    let peaks: Vec<f64> = serde_json::from_value(browser.evaluate(rows)).unwrap();
    assert!(peaks.len() == 2 && peaks[1] > 1.1 * peaks[0], "a thicker tube is stronger: {peaks:?}");
    browser.picture("report-pair");
    sound(&mut browser);

    // Histories of the second run are not taken for those of the first one.
    fs::remove_file(runs[0].out().join("history.csv")).unwrap();
    run(crumple_with(&["report", &folders[0], &folders[1]])).with_code(0);
    open(&mut browser, &file, "");
    assert_eq!(browser.evaluate("crumple.read"), Value::Null);
    let labels = browser.evaluate("crumple.bench.curves.map((c) => c.label)").to_string();
    assert!(labels.contains(&folders[1]) && !labels.contains(&folders[0]), "{labels}");
    sound(&mut browser);
}

/// Particles are drawn as points, and can be picked.
#[test]
fn particles_are_drawn_and_picked() {
    let scene = root().join("cases/splash").display().to_string();
    let settings =
        ["scene.radius=3", "scene.shells=8", "end_time=0.02", "output.field_interval=0.01"];
    let mut args = vec!["run", &scene, "--workers", "1"];
    settings.iter().for_each(|setting| args.extend(["--set", setting]));
    let ended = run(crumple_with(&args)).with_code(0);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let points = "crumple.view.surface.points";
    let count = browser.evaluate(&format!("{points}.seen.filter((e) => e >= 0).length"));
    assert!(count.as_f64().is_some_and(|count| count > 50.0), "{count}");
    let drawn = browser.evaluate(&format!("[{points}.object.isPoints, {points}.object.visible]"));
    assert_eq!(drawn, json!([true, true]));
    // The outermost particle, which no other one hides.
    let picked = browser.evaluate(&format!(
        "(() => {{ const p = {points}; \
         const at = (i) => crumple.view.pixels(new THREE.Vector3(...p.place(i, 0))); \
         let best = 0; \
         for (let i = 1; i < p.seen.length; i++) if (at(i).x < at(best).x) best = i; \
         crumple.picker.at(at(best).x, at(best).y); \
         return [crumple.picker.element, p.seen[best]]; }})()"
    ));
    assert_eq!(picked[0], picked[1], "the particle under the pointer");
    let outline = "crumple.picker.outline.geometry.getAttribute('position').array";
    let extent = browser.evaluate(&format!("Math.max(...{outline}) - Math.min(...{outline})"));
    assert!(extent.as_f64().is_some_and(|extent| extent > 0.0), "a cross marks it: {extent}");
    sound(&mut browser);
}
