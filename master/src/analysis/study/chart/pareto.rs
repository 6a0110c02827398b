//! Error over cost on logarithmic axes, with the Pareto front: the points that no other point
//! beats in both.

use super::axis::ChartAxis;
use super::canvas::{Anchor, BLACK, Sheet, WHITE};
use super::frame::{BOTTOM, ChartFrame, LEFT, RIGHT, TOP, colour};
use super::{ChartView, dash};

/// Draws the chart.
///
/// # Errors
/// No point can be shown.
pub fn draw(view: &ChartView<'_>) -> Result<Sheet, String> {
    let m = view.measure_index();
    let shown: Vec<_> =
        view.rows().filter(|(_, r)| r.ended_well() && r.errors[m] > 0.0 && r.cost > 0.0).collect();
    if shown.is_empty() {
        return Err(format!(
            "chart `{}`: no point has an error and a cost above 0",
            view.chart.file
        ));
    }
    let x = ChartAxis::around(shown.iter().map(|(_, r)| r.cost), true, [LEFT, RIGHT]);
    let y = ChartAxis::around(shown.iter().map(|(_, r)| r.errors[m]), true, [BOTTOM, TOP]);
    let mut frame = ChartFrame::new(view.head(), x, y, true);
    let front = view.table.front(m, |r| view.shows_series(r.series) && r.errors[m] > 0.0);
    let place =
        |f: &ChartFrame, i: usize| f.at(view.table.rows[i].cost, view.table.rows[i].errors[m]);
    let corners: Vec<[f64; 2]> = front.iter().filter_map(|&i| place(&frame, i)).collect();
    frame.sheet.dashed(&staircase(&corners), BLACK, 1.2);
    for &(i, row) in &shown {
        if let Some(at) = place(&frame, i) {
            frame.sheet.marker(at, row.series, 6.5, WHITE);
            frame.sheet.marker(at, row.series, 5.5, colour(row.series));
        }
    }
    for (number, at) in corners.iter().enumerate() {
        frame.sheet.ring(*at, 9.0, BLACK, 1.2);
        frame.sheet.text(
            [at[0] - 12.0, at[1] + 13.0],
            &(number + 1).to_string(),
            13.0,
            Anchor::Middle,
            BLACK,
        );
    }
    for s in (0..view.study.series.len()).filter(|&s| view.shows_series(s)) {
        frame.entry(&view.study.series[s].name, |sheet, at| sheet.marker(at, s, 5.5, colour(s)));
    }
    frame.entry("Pareto front: smallest error at no more cost", |sheet, at| {
        sheet.dashed(&[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], BLACK, 1.2);
        sheet.ring(at, 7.0, BLACK, 1.2);
    });
    frame.gap(8.0);
    for (number, &i) in front.iter().enumerate() {
        let digit = (number + 1).to_string();
        frame.entry(&view.table.rows[i].label, |sheet, at| {
            sheet.text(at, &digit, 13.0, Anchor::Middle, BLACK)
        });
    }
    let all = view.rows().count();
    let failed = view.rows().filter(|(_, r)| !r.ended_well()).count();
    frame.gap(8.0);
    if failed > 0 {
        frame.note(&format!("{failed} of {all} points failed and are not shown"));
    }
    if all > failed + shown.len() {
        frame.note(&format!("without error or cost, not shown: {}", all - failed - shown.len()));
    }
    let cost = &view.study.cost;
    let x_title = view
        .chart
        .x_title
        .clone()
        .unwrap_or_else(|| format!("{} [{}]", cost.name, dash(&cost.unit)));
    let y_title = view.chart.y_title.clone().unwrap_or_else(|| view.measure_title(true));
    Ok(frame.draw_axes(&x_title, &y_title))
}

/// Returns the staircase through points. It runs along x first, then along y, because up to the
/// next point the previous one is the best.
fn staircase(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut stairs = Vec::new();
    for (i, p) in points.iter().enumerate() {
        if i > 0 {
            stairs.push([p[0], points[i - 1][1]]);
        }
        stairs.push(*p);
    }
    stairs
}
