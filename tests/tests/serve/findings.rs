//! Findings of `crumple check`, as data and on the page.

use crate::page::signed_in;
use crumple_tests::browser::Browser;
use crumple_tests::program::crumple;
use crumple_tests::service::{Service, bars};
use serde_json::{Value, json};
use std::fs;
use std::process::Command;

/// A deck whose fifth line has a script where a coordinate should be.
const DECK: &str = "*KEYWORD\n*CONTROL_TERMINATION\n       1.0\n*NODE\n\
    \x20      1<b onclick=x><script>window.hacked = 1</script>\n*NOTHING_KNOWN\n*END\n";

/// Returns the finding of the fifth line.
fn of_script(findings: &Value) -> &Value {
    let all = findings["findings"].as_array().unwrap();
    let found = all.iter().find(|finding| finding["place"]["line"] == 5);
    found.unwrap_or_else(|| panic!("{findings}"))
}

#[test]
fn the_command_prints_findings_as_json_and_the_service_gives_the_same() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("input")).unwrap();
    let deck = folder.path().join("input/main.k");
    fs::write(&deck, DECK).unwrap();
    let mut check = Command::new(crumple());
    check.args(["check", "--json", "input/main.k"]).current_dir(folder.path());
    let output = check.output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let finding = of_script(&printed);
    let place = &finding["place"];
    let line = DECK.lines().nth(4).unwrap();
    assert_eq!(finding["severity"], "error");
    assert_eq!(place["text"], line);
    let start = place["mark"]["start"].as_u64().unwrap() as usize;
    assert_eq!(start, line.find('<').unwrap(), "the field that is no number: {finding}");
    assert_eq!(place["column"], start + 1);
    let marked = format!("| {}{}", " ".repeat(start), "^".repeat(length(place)));
    assert!(printed["text"].as_str().unwrap().contains(&marked), "{printed}");

    let service = Service::start(&[]);
    let id = service.submit(&json!({"files": {"main.k": DECK}}));
    service.wait_for(id, "refused");
    let served = service.get(&format!("/api/jobs/{id}/check")).json();
    assert_eq!(served, printed);
    let set = service.submit(&bars(&["material.steel.density=-1"]));
    service.wait_for(set, "refused");
    let served = service.get(&format!("/api/jobs/{set}/check")).json();
    assert_eq!(served["findings"][0]["set"], "material.steel.density=-1", "{served}");
    assert_eq!(
        (&served["findings"][0]["place"], &served["memory_mb"]),
        (&Value::Null, &json!(0.0))
    );
}

fn length(place: &Value) -> usize {
    place["mark"]["length"].as_u64().unwrap() as usize
}

/// The form shows errors with their lines and marks, reached by keys; text of a deck stays text.
#[test]
fn the_form_shows_the_lines_of_a_deck_with_errors() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    signed_in(&service, &mut browser);
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("main.k");
    fs::write(&deck, DECK).unwrap();
    browser.evaluate("location.hash = '#/new'");
    browser.wait("the form is shown", "!document.getElementById('new').hidden");
    browser.choose("#new-files", &[deck]);
    browser.click("#new-form button[value=check]");
    let shown = "document.querySelector('#new-check-findings .finding-error') !== null";
    browser.wait("errors are shown", shown);
    let focused = "document.activeElement.id === 'new-check-title'";
    browser.wait("the result has the focus", focused);
    let title = browser.evaluate("document.activeElement.textContent").to_string();
    assert!(title.contains("cannot run") && title.contains("error"), "{title}");
    let item = "[...document.querySelectorAll('#new-check-findings .finding-error')].find((e) => \
                e.textContent.includes('line 5'))";
    let place = browser.evaluate(&format!("{item}.querySelector('.place').textContent"));
    assert_eq!(place, "input/main.k, line 5, column 9");
    let source = browser.evaluate(&format!("{item}.querySelector('.source').textContent"));
    let (line, mark) = source.as_str().unwrap().split_once('\n').unwrap();
    assert_eq!(line, format!("5 | {}", DECK.lines().nth(4).unwrap()));
    assert_eq!(mark.find('^'), line.find('<'), "{source}");
    assert_eq!(browser.evaluate("window.hacked ?? null"), Value::Null);
    let made = "document.querySelectorAll('#new script, #new b').length";
    assert_eq!(browser.evaluate(made), 0, "elements from the text of a deck");
    let reached = (0..40).any(|_| {
        browser.press("Tab");
        browser.evaluate(&format!("document.activeElement === {item}")) == true
    });
    assert!(reached, "the key Tab does not reach the finding");
    for (width, kind) in [(1400, "wide"), (390, "phone")] {
        browser.resize(width, 900);
        for dark in [false, true] {
            browser.darken(dark);
            browser.picture(&format!("findings-{kind}-{}", if dark { "dark" } else { "light" }));
        }
        let wide = browser.evaluate("document.documentElement.scrollWidth");
        assert!(wide.as_u64().unwrap() <= u64::from(width), "{width}: {wide}");
    }
    browser.click("#new-check-job");
    let open = "document.querySelector('#run-check[open] .finding-error .source') !== null";
    browser.wait("the page of the job shows them too", open);
    browser.picture("findings-of-job");
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}
