//! The 3D view by keys, on the page of a job and in its report.

use crate::page::signed_in;
use crumple_tests::browser::Browser;
use crumple_tests::service::{Service, bars};

/// Presses every key of the view named `view`, and checks what each does to the camera.
fn press_all(browser: &mut Browser, view: &str) {
    // Offset of the camera from its target, and the target.
    let camera = format!(
        "(() => {{ const {{ camera, controls }} = {view}; const t = controls.target.toArray(); \
         return [...camera.position.toArray().map((x, c) => x - t[c]), ...t]; }})()"
    );
    let look = |browser: &mut Browser| -> Vec<f64> {
        let numbers = browser.evaluate(&camera);
        numbers.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let distance = |at: &[f64]| at[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    // Round-off of one press, which rebuilds the position from angles.
    let same = |a: f64, b: f64, of: f64| (a - b).abs() < 1e-9 * of;
    browser.press("Home"); // the stage may have got another size since the first picture
    let home = look(browser);
    let scale = distance(&home);
    let pairs = [
        ("ArrowLeft", "ArrowRight"),
        ("ArrowUp", "ArrowDown"),
        ("+", "-"),
        ("Shift+ArrowLeft", "Shift+ArrowRight"),
        ("Shift+ArrowUp", "Shift+ArrowDown"),
    ];
    for (key, back) in pairs {
        let before = look(browser);
        browser.press(key);
        let after = look(browser);
        let turned = (0..3).any(|c| !same(before[c], after[c], scale));
        let moved = (3..6).any(|c| !same(before[c], after[c], scale));
        let zoomed = !same(distance(&before), distance(&after), scale);
        let expected = match key {
            "+" => (true, false, true),
            key if key.starts_with("Shift+") => (false, true, false),
            _ => (true, false, false),
        };
        assert_eq!((turned, moved, zoomed), expected, "{view}, {key}: {before:?} {after:?}");
        browser.press(back);
        let again = look(browser);
        let returned = (0..6).all(|c| same(before[c], again[c], scale));
        assert!(returned, "{view}, {back}: {before:?} {again:?}");
    }
    for key in ["ArrowUp", "+", "Shift+ArrowLeft"] {
        browser.press(key);
    }
    assert_ne!(look(browser), home);
    browser.press("Home");
    let reset = look(browser);
    assert!((0..6).all(|c| same(home[c], reset[c], scale)), "{view}: {home:?} {reset:?}");
}

/// Moves the focus to a canvas by the key Tab, and checks that its ring is visible and that its
/// label names the keys.
fn focus(browser: &mut Browser, canvas: &str) {
    let focused = format!("document.activeElement === document.querySelector('{canvas}')");
    let reached = (0..40).any(|_| {
        browser.press("Tab");
        browser.evaluate(&focused) == true
    });
    assert!(reached, "the key Tab does not reach {canvas}");
    let ring = "(() => { const s = getComputedStyle(document.activeElement); return \
                s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) >= 2; })()";
    assert_eq!(browser.evaluate(ring), true, "the focus of {canvas} is visible");
    let label = browser.evaluate("document.activeElement.getAttribute('aria-label')");
    for word in ["Arrow keys", "Plus and minus", "Shift", "Home"] {
        assert!(label.as_str().unwrap().contains(word), "{label}");
    }
}

#[test]
fn the_camera_moves_by_keys_on_the_page_and_in_the_report() {
    let Some(mut browser) = Browser::start() else { return };
    let service = Service::start(&[]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    signed_in(&service, &mut browser);
    browser.evaluate(&format!("location.hash = '#/job/{id}'"));
    let report = browser.wait(
        "there are a picture, plots and a report",
        "views.run.picture.model && document.querySelectorAll('#plots .uplot').length > 2 && \
         document.querySelector('#run-report:not([hidden])')?.href",
    );
    focus(&mut browser, "#run-picture canvas");
    press_all(&mut browser, "views.run.picture.view");
    browser.picture("camera");
    browser.open(report.as_str().unwrap());
    browser.wait("the report is drawn", "document.documentElement.dataset.state === 'ready'");
    let time = "crumple.time";
    let before = browser.evaluate(time);
    focus(&mut browser, "#canvas");
    press_all(&mut browser, "crumple.view");
    assert_eq!(browser.evaluate(time), before, "keys of the camera select no time");
    browser.picture("camera-of-report");
    let problems = browser.problems();
    assert!(problems.is_empty(), "{problems:#?}");
}
