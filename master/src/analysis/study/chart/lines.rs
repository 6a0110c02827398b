//! A measure over one setting, with a line for each series and each combination of its other
//! settings.

use super::ChartView;
use super::axis::ChartAxis;
use super::canvas::{GREY, Sheet, WHITE};
use super::frame::{BOTTOM, ChartFrame, LEFT, RIGHT, TOP, colour};
use super::map::curves;
use crate::analysis::study::grid::{number, plain, short};
use crate::analysis::study::results::PointResult;
use crate::analysis::study::spec::flatten;

/// Draws the chart.
///
/// # Errors
/// No point can be shown.
pub fn draw(view: &ChartView<'_>) -> Result<Sheet, String> {
    let chart = view.chart;
    let key = chart.x.clone().unwrap_or_default();
    let varying: Vec<&PointResult> =
        view.rows().map(|(_, r)| r).filter(|r| r.setting(&key).is_some()).collect();
    let log = [view.is_log("x"), view.is_log("y")];
    let in_words = varying.iter().any(|r| r.setting(&key).and_then(number).is_none());
    let mut words: Vec<String> = Vec::new();
    for word in varying.iter().filter_map(|r| r.setting(&key)).map(plain) {
        if in_words && !words.contains(&word) {
            words.push(word);
        }
    }
    let along = |r: &PointResult| -> f64 {
        let value = r.setting(&key);
        let place =
            || value.and_then(|v| words.iter().position(|w| *w == plain(v))).map(|i| i as f64);
        if in_words { place() } else { value.and_then(number) }.unwrap_or(f64::NAN)
    };
    let good = |r: &&&PointResult| {
        r.ended_well() && view.value(r).is_finite() && (!log[1] || view.value(r) > 0.0)
    };
    let shown: Vec<&PointResult> = varying.iter().filter(good).copied().collect();
    if shown.is_empty() {
        return Err(format!("chart `{}`: no point can be shown", chart.file));
    }
    let reference = view.table.references[view.measure_index()].filter(|_| !chart.error);
    let x = match in_words {
        true => ChartAxis::of_words(words.clone(), [LEFT, RIGHT]),
        false => ChartAxis::around(shown.iter().map(|r| along(r)), log[0], [LEFT, RIGHT]),
    };
    let y = ChartAxis::around(
        shown.iter().map(|r| view.value(r)).chain(reference),
        log[1],
        [BOTTOM, TOP],
    );
    let mut frame = ChartFrame::new(view.head(), x, y, true);
    if let Some(level) = reference.map(|r| frame.y.at(r)) {
        frame.sheet.dashed(&[[LEFT, level], [RIGHT, level]], GREY, 1.2);
        frame.entry("reference", |sheet, at| {
            sheet.dashed(&[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], GREY, 1.2)
        });
    }
    let mut groups: Vec<(String, Vec<&PointResult>)> = Vec::new();
    for row in shown.iter().copied() {
        let name = name(view, row, &key);
        match groups.iter_mut().find(|g| g.0 == name) {
            Some(group) => group.1.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    for (number, (name, mut rows)) in groups.into_iter().enumerate() {
        rows.sort_by(|a, b| along(a).total_cmp(&along(b)));
        let places: Vec<[f64; 2]> =
            rows.iter().filter_map(|r| frame.at(along(r), view.value(r))).collect();
        frame.sheet.line(&places, colour(number), 1.4);
        for at in &places {
            frame.sheet.marker(*at, number, 6.5, WHITE);
            frame.sheet.marker(*at, number, 5.5, colour(number));
        }
        frame.entry(&name, |sheet, at| {
            sheet.line(&[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], colour(number), 1.4);
            sheet.marker(at, number, 5.5, colour(number));
        });
    }
    curves(view, &mut frame)?;
    let hidden = varying.len() - shown.len();
    if hidden > 0 {
        frame.gap(8.0);
        frame.note(&format!(
            "{hidden} of {} points failed or have no value and are not shown",
            varying.len()
        ));
    }
    let x_title = chart.x_title.clone().unwrap_or(key);
    let y_title = chart.y_title.clone().unwrap_or_else(|| view.measure_title(chart.error));
    Ok(frame.draw_axes(&x_title, &y_title))
}

/// Returns the name of the line of a row: its series and its other varied settings. Settings that
/// vary together with the one along x are not part of it.
fn name(view: &ChartView<'_>, row: &PointResult, along: &str) -> String {
    let zipped: Vec<String> =
        flatten(&view.study.series[row.series].zip).into_iter().map(|(k, _)| k).collect();
    let with_x = |k: &String| k == along || zipped.iter().any(|z| z == along) && zipped.contains(k);
    let others = row
        .varied
        .iter()
        .filter(|(k, _)| !with_x(k))
        .map(|(k, v)| format!("{}={}", short(k), plain(v)));
    let words: Vec<String> = others.collect();
    let series = &view.study.series[row.series].name;
    if words.is_empty() { series.clone() } else { format!("{series}, {}", words.join(" ")) }
}
