//! The page in Chromium, as a user meets it.

use super::kills::process;
use crumple_tests::browser::Browser;
use crumple_tests::program::{root, send};
use crumple_tests::service::{Service, bars, children, endless};
use rustix::process::Signal;
use serde_json::json;
use std::time::Instant;

/// Opens the page with the token of an admin.
pub(crate) fn signed_in(service: &Service, browser: &mut Browser) {
    browser.open(&format!("http://{}/#token={}", service.host, service.token));
    browser.wait("the list of jobs is shown", "!document.getElementById('jobs').hidden");
}

/// Gives an order by its button and confirms it.
fn order(browser: &mut Browser, name: &str, values: &[(&str, &str)]) {
    let button = format!("button[data-order={name}]");
    browser.wait(
        format!("{name} is allowed"),
        &format!("!document.querySelector('{button}').disabled"),
    );
    browser.click(&button);
    browser.wait("the dialog is open", "document.getElementById('ask').open");
    for (field, value) in values {
        browser.evaluate(&format!("document.getElementById('{field}').value = '{value}'"));
    }
    browser.click("#ask button[value=yes]");
}

fn wait_for_log(browser: &mut Browser, text: &str) {
    let script = format!("document.getElementById('run-log').textContent.includes('{text}')");
    browser.wait(format!("the log has: {text}"), &script);
}

const STATES: &str = "Number(document.getElementById('run-picture').dataset.states)";
/// Pixels of the canvas, right after it is drawn.
const PIXELS: &str = "(() => { const p = views.run.picture; p.view.draw(); return \
                      p.canvas.toDataURL(); })()";
const COVERED: &str = "views.run.picture.view.covered()";

/// A user uploads a job, sees it crash, holds it, has a checkpoint written, lets it go on, ends it
/// early and opens its report. The console has no error.
#[test]
fn a_job_is_uploaded_watched_steered_and_reported() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    signed_in(&service, &mut browser);
    browser.picture("jobs");
    browser.click("nav a[href='#/new']");
    browser.wait("the form is shown", "!document.getElementById('new').hidden");
    browser.choose("#new-files", &[root().join("cases/jeep-frame/job.toml")]);
    browser.evaluate("document.getElementById('new-workers').value = 2");
    browser.picture("new");
    browser.click("#new-form button[value=run]");
    let submitted = Instant::now();
    browser.wait("there is a picture", &format!("{STATES} >= 1"));
    let covered = browser.evaluate(COVERED).as_f64().unwrap();
    assert!(covered > 0.01, "the model covers {covered} of the stage");
    let (first, time) = (browser.evaluate(PIXELS), "views.run.picture.model.frames[0].time");
    let began = browser.evaluate(time).as_f64().unwrap();
    browser.picture("running");
    browser.wait("the model moves", &format!("{time} > {began}"));
    let seconds = submitted.elapsed().as_secs_f64();
    println!("the job is seen moving {seconds:.1} s after its submission");
    browser.wait("the picture follows", &format!("{STATES} >= 3 && {time} > {began}"));
    assert_ne!(browser.evaluate(PIXELS), first, "the picture has changed");
    let text = browser.evaluate("document.getElementById('plots').innerText").to_string();
    for line in ["limit for high", "limit for low", "worker 1"] {
        assert!(text.contains(line), "{text}");
    }
    browser.evaluate("views.run.picture.boxes.click()");
    assert_eq!(browser.evaluate("views.run.picture.view.marks.length"), 2, "boxes of workers");
    browser.picture("boxes");
    order(&mut browser, "pause", &[]);
    wait_for_log(&mut browser, "pause: in effect in cycle");
    order(&mut browser, "checkpoint", &[]);
    wait_for_log(&mut browser, "checkpoint: in effect in cycle");
    assert!(service.folder(1).join("results/checkpoints").exists());
    // The run would pass a new end that is given while it goes on.
    let status = service.post("/api/jobs/1/orders", &json!({"request": "status"})).json();
    let end = (status["progress"]["time"].as_f64().unwrap() + 0.5).to_string();
    order(&mut browser, "set", &[("ask-key", "end_time"), ("ask-value", &end)]);
    wait_for_log(&mut browser, "end_time=");
    order(&mut browser, "continue", &[]);
    wait_for_log(&mut browser, "continue: in effect in cycle");
    service.wait_for(1, "completed");
    let report = browser
        .wait("there is a report", "document.querySelector('#run-report:not([hidden])')?.href");
    browser.picture("ended");
    browser.open(report.as_str().unwrap());
    browser.wait("the report is drawn", "document.documentElement.dataset.state === 'ready'");
    browser.picture("report");
    assert_eq!(browser.evaluate("document.documentElement.dataset.errors"), "0");
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}

/// The button that kills a job appears when it was asked to stop.
#[test]
fn a_job_that_hangs_is_killed_from_the_page() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    let id = service.submit(&endless());
    let supervisor = process(&service, id, 1);
    let runs = service.wait("the run has begun", |_| {
        let runs = children(supervisor);
        (!runs.is_empty()).then_some(runs)
    });
    service.wait_for(id, "running");
    runs.iter().chain([&supervisor]).for_each(|&pid| send(pid, Signal::STOP));
    signed_in(&service, &mut browser);
    browser.evaluate(&format!("location.hash = '#/job/{id}'"));
    let hidden = "document.querySelector('button[data-order=kill]').hidden";
    browser.wait("the job is shown", "!document.querySelector('[data-order=stop]').disabled");
    assert_eq!(browser.evaluate(hidden), true);
    order(&mut browser, "stop", &[]);
    browser.wait("the job can be killed", &format!("!{hidden}"));
    browser.picture("hangs");
    order(&mut browser, "kill", &[]);
    wait_for_log(&mut browser, "state: stopped killed");
    assert_eq!(browser.evaluate(hidden), true);
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}

/// Two jobs have one camera, one time and one scale of colours.
#[test]
fn two_jobs_are_shown_in_step() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    let ids = [bars(&[]), bars(&["end_time=0.1"])].map(|job| service.submit(&job));
    ids.iter().for_each(|id| drop(service.wait_for(*id, "completed")));
    signed_in(&service, &mut browser);
    browser.evaluate("location.hash = '#/job/1'");
    browser
        .wait("the job is shown", "views.run.id === 1 && !document.getElementById('run').hidden");
    browser.wait("there is a picture", "!!views.run.picture.model");
    browser.evaluate("document.querySelector('#run-compare input').value = 2");
    browser.click("#run-compare button");
    let both = |what: &str| format!("views.compare.pictures.every((p) => {what})");
    browser.wait("both have pictures", &both("p.model"));
    browser
        .wait("there are plots", "document.querySelectorAll('#compare-plots .uplot').length === 5");
    browser.picture("compare");
    let cameras = "(() => { const [a, b] = views.compare.pictures.map((p) => \
                   p.view.camera.position.toArray().map((x) => x.toPrecision(6)).join()); \
                   return a === b && a; })()";
    let before = browser.wait("the cameras are the same", cameras);
    browser.click("#compare-picture-second [data-view=top]");
    let after = browser.wait("the cameras are the same", cameras);
    assert_ne!(before, after, "the camera has moved");
    let tops = both("p.tops === views.compare.pictures[0].tops");
    assert_eq!(browser.evaluate(&tops), true);
    browser.evaluate("document.getElementById('compare-time').focus()");
    browser.press("Home");
    browser.wait("both are at the start", &both("p.model.frames[0].time === 0"));
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}

/// All pages fit a phone, are dark where the system is, and a job is started with keys alone.
#[test]
fn the_page_fits_a_phone_and_is_used_by_keys() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    let mut only = bars(&[]);
    only["check_only"] = json!(true);
    only["name"] = json!("a name that is so long that it has to be broken on a phone, ".repeat(3));
    let waits = service.submit(&only);
    service.wait_for(waits, "checked");
    signed_in(&service, &mut browser);
    let pages =
        [("#/", "jobs"), ("#/new", "new"), ("#/job/1", "run"), ("#/compare/1/1", "compare")];
    for dark in [false, true] {
        browser.darken(dark);
        for (hash, section) in pages {
            for (width, kind) in [(390, "phone"), (1400, "wide")] {
                browser.resize(width, 844);
                browser.evaluate(&format!("location.hash = '{hash}'"));
                let shown = format!("!document.getElementById('{section}').hidden");
                browser.wait(format!("{section} is shown"), &shown);
                if ["run", "compare"].contains(&section) {
                    let drawn =
                        format!("document.querySelectorAll('#{section} .uplot').length > 2");
                    browser.wait("there are plots", &drawn);
                    browser.wait(
                        "there is a picture",
                        &format!(
                            "views.{section}.close && \
                        document.querySelector('#{section} .absent').hidden"
                        ),
                    );
                }
                let theme = if dark { "dark" } else { "light" };
                browser.picture(&format!("{section}-{kind}-{theme}"));
                let wide = browser.evaluate("document.documentElement.scrollWidth");
                assert!(wide.as_u64().unwrap() <= u64::from(width), "{section}, {width}: {wide}");
                let paper = browser.evaluate("getComputedStyle(document.body).backgroundColor");
                let paper = paper.as_str().unwrap();
                assert_eq!(paper, if dark { "rgb(20, 23, 26)" } else { "rgb(251, 251, 250)" });
            }
        }
    }
    // Keys: to the job that waits, to its button, and yes.
    browser.evaluate("location.hash = '#/'");
    let focused = |what: &str| format!("document.activeElement?.matches('{what}')");
    let walk = |browser: &mut Browser, to: &str| {
        let reached = (0..60).any(|_| {
            browser.press("Tab");
            browser.evaluate(&focused(to)) == true
        });
        assert!(reached, "the key Tab does not reach {to}");
    };
    browser.wait("the jobs are listed", "document.querySelector('[data-job]') !== null");
    walk(&mut browser, &format!("[data-job=\"{waits}\"]"));
    browser.press("Enter");
    // The stream repeats the states of the job; in the first of them the button cannot be reached.
    wait_for_log(&mut browser, "state: checked");
    browser.wait("the job is shown", "!document.querySelector('[data-order=resume]').disabled");
    walk(&mut browser, "[data-order=resume]");
    browser.press("Enter");
    browser.wait("the dialog is open", "document.getElementById('ask').open");
    walk(&mut browser, "#ask [value=yes]");
    browser.press("Enter");
    service.wait("the job has started", |service| {
        (service.job(waits)["state"] == "completed").then_some(())
    });
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}
