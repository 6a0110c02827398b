//! Formulas of the report page: filters, head injury criteria, integrals.

use super::report_page::{crushed, opened, sound};
use crumple_tests::browser::Browser;

/// Gain of a filter class for a sine of `ratio` times the class, far from the ends [dB].
fn gain(browser: &mut Browser, class: u32, ratio: f64) -> f64 {
    let script = format!(
        "(() => {{ const rate = 1000 * {class}, count = Math.ceil(8 * 1000 / Math.min({ratio}, \
        1)); \
         const x = Float64Array.from({{ length: count }}, (_, i) => i / rate); \
         const y = filtered(x, x.map((t) => Math.sin(2 * Math.PI * {class} * {ratio} * t)), \
         {class}, 1); \
         const inside = y.subarray(Math.floor(count / 4), Math.floor(3 * count / 4)); \
         return 20 * Math.log10(inside.reduce((most, v) => Math.max(most, Math.abs(v)), 0)); }})()"
    );
    browser.evaluate(&script).as_f64().unwrap()
}

/// SAE J211-1 gives a corridor for each class: pass band within 0.5 dB, down to -1 dB at its end;
/// from 0.5 to -4 dB at 5/3 of the class; beyond it not above a fall of 9 dB per octave and not
/// below one of 24 dB per octave, as long as the upper limit is above -40 dB. The formulas of its
/// annex C have -3 dB at 5/3 of the class.
#[test]
fn filters_stay_in_the_corridor_of_the_standard() {
    let ended = crushed(&["end_time=0.01"]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    for class in [60, 180, 600, 1000] {
        for ratio in [0.1, 0.3, 0.6] {
            let gain = gain(&mut browser, class, ratio);
            assert!((-0.5..0.5).contains(&gain), "CFC {class} at {ratio}: {gain} dB");
        }
        assert!((-1.0..0.5).contains(&gain(&mut browser, class, 1.0)));
        let corner = gain(&mut browser, class, 5.0 / 3.0);
        let half = 20.0 * 0.5f64.sqrt().log10();
        assert!((corner - half).abs() < 0.02, "CFC {class}: {corner} dB at the corner");
        for octaves in [0.5, 1.0, 2.0, 3.0] {
            let gain = gain(&mut browser, class, 5.0 / 3.0 * f64::exp2(octaves));
            let corridor = -4.0 - 24.0 * octaves..0.5 - 9.0 * octaves;
            assert!(corridor.contains(&gain), "CFC {class}, {octaves} octaves: {gain} dB");
        }
    }
    // No delay, and constants and straight lines pass, also at the ends.
    let line = "(() => { const x = Float64Array.from({ length: 500 }, (_, i) => i / 1e4); \
                const y = filtered(x, x.map((t) => 3 + 40 * t), 180, 1); \
                return Math.max(...y.map((v, i) => Math.abs(v - 3 - 40 * x[i]))); })()";
    assert!(browser.evaluate(line).as_f64().unwrap() < 1e-9);
    let refused = "(() => { try { const x = Float64Array.from({ length: 100 }, (_, i) => i); \
                   filtered(x, x, 60, 1e-2); } catch (error) { return error.message; } })()";
    let said = browser.evaluate(refused).to_string();
    assert!(said.contains("reduce output.history_interval"), "{said}");
    sound(&mut browser);
}

/// Closed forms: a constant acceleration has HIC = T a^2.5 for the longest window T; a half sine of
/// amplitude A and duration T has HIC = 2/pi (sin x)^2.5 / x^1.5 T A^2.5 with tan x = 5/3 x
/// (0.4146 T A^2.5); a force that grows with the displacement does the work F u/2.
#[test]
fn figures_have_their_closed_forms() {
    let ended = crushed(&["end_time=0.01"]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let mut value = |script: &str| browser.evaluate(script).as_f64().unwrap();
    let time = "Float64Array.from({ length: 20001 }, (_, i) => i * 1e-5)";
    let constant = value(&format!(
        "(() => {{ const t = {time}; return headInjury(t, \
        t.map(() => 60), 0.015).value; }})()"
    ));
    assert!((constant / (0.015 * 60f64.powf(2.5)) - 1.0).abs() < 1e-9, "{constant}");
    // Rows 2 ms apart: windows of 14 ms, not of 16.
    let coarse = "Float64Array.from({ length: 101 }, (_, i) => i * 2e-3)";
    let whole =
        value(&format!("(() => headInjury({coarse}, {coarse}.map(() => 60), 0.015).value)()"));
    assert!((whole / (0.014 * 60f64.powf(2.5)) - 1.0).abs() < 1e-9, "{whole}");
    let sine = value(&format!(
        "(() => {{ const t = {time}; return headInjury(t, t.map((t) => \
        t < 0.03 ? 80 * Math.sin(Math.PI * t / 0.03) : 0), 0.036).value; }})()"
    ));
    let mut x = 1.0f64;
    (0..100).for_each(|_| x = (5.0 / 3.0 * x).atan());
    let share = 2.0 / std::f64::consts::PI * x.sin().powf(2.5) / x.powf(1.5);
    assert!((share - 0.4146).abs() < 1e-4, "{share}");
    let exact = share * 0.03 * 80f64.powf(2.5);
    assert!((sine / exact - 1.0).abs() < 1e-4, "{sine} for {exact}: 3000 rows per pulse");
    // Down to -30 with the force 2 u, then back to -20 with a larger one, which does not count.
    let crush = "(() => { const u = Float64Array.from({ length: 401 }, (_, i) => \
                 (i <= 300 ? -0.1 * i : -30 + 0.1 * (i - 300))); \
                 return crushOf(u, u.map((v, i) => (i <= 300 ? 2 * v : 100))); })()";
    let figures = browser.evaluate(crush);
    let exact = [
        ("peak", 60.0),
        ("at", 30.0),
        ("stroke", 30.0),
        ("energy", 900.0),
        ("mean", 30.0),
        ("efficiency", 0.5),
    ];
    for (key, exact) in exact {
        let value = figures[key].as_f64().unwrap();
        assert!((value / exact - 1.0).abs() < 1e-9, "{key}: {value} for {exact}");
    }
    let twice = "(() => { const t = Float64Array.from({ length: 101 }, (_, i) => i / 100); \
                 const v = integral(t, t.map(() => 6)); return integral(t, v)[100]; })()";
    assert!((browser.evaluate(twice).as_f64().unwrap() - 3.0).abs() < 1e-12);
    sound(&mut browser);
}
