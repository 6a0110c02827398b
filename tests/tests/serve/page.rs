//! The page in Chromium, as a user meets it.

use crumple_tests::browser::Browser;
use crumple_tests::program::root;
use crumple_tests::service::Service;

/// Opens the page with the token of an admin.
fn signed_in(service: &Service, browser: &mut Browser) {
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
    browser.wait("there is a picture", &format!("{STATES} >= 1"));
    let covered = browser.evaluate(COVERED).as_f64().unwrap();
    assert!(covered > 0.01, "the model covers {covered} of the stage");
    let (first, time) = (browser.evaluate(PIXELS), "views.run.picture.model.frames[0].time");
    let began = browser.evaluate(time).as_f64().unwrap();
    browser.picture("running");
    browser.wait("the picture follows", &format!("{STATES} >= 3 && {time} > {began}"));
    assert_ne!(browser.evaluate(PIXELS), first, "the picture has changed");
    order(&mut browser, "pause", &[]);
    wait_for_log(&mut browser, "pause: in effect in cycle");
    order(&mut browser, "checkpoint", &[]);
    wait_for_log(&mut browser, "checkpoint: in effect in cycle");
    assert!(service.folder(1).join("results/checkpoints").exists());
    order(&mut browser, "continue", &[]);
    wait_for_log(&mut browser, "continue: in effect in cycle");
    let end = browser.evaluate(time).as_f64().unwrap() + 0.5;
    let end = [("ask-key", "end_time"), ("ask-value", &*end.to_string())];
    order(&mut browser, "set", &end);
    wait_for_log(&mut browser, "end_time=");
    service.wait_for(1, "completed");
    let report = browser.wait(
        "there is a report",
        "(() => { const a = document.getElementById('run-report'); return !a.hidden && a.href; })()",
    );
    browser.picture("ended");
    browser.open(report.as_str().unwrap());
    browser.wait("the report is drawn", "document.documentElement.dataset.state === 'ready'");
    browser.picture("report");
    assert_eq!(browser.evaluate("document.documentElement.dataset.errors"), "0");
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}
