//! A stability map: a measure, or the end of the runs, as colour over two settings, with
//! theoretical curves.

use super::ChartView;
use super::axis::{ChartAxis, short};
use super::canvas::{Anchor, BLACK, Colour, Sheet, WHITE};
use super::frame::{BOTTOM, ChartFrame, LEFT, LEGEND, RIGHT, SMALL, TOP};
use crate::analysis::study::grid::number;
use crate::analysis::study::results::PointResult;
use crate::analysis::study::spec::{ENDED, formula};

/// Colours of the scale from low to high: some of viridis (van der Walt and Smith 2015), of
/// uniform steps in lightness.
const SCALE: [Colour; 6] =
    [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];
/// Colours of completed runs, if the map shows only the end of the runs, and of failed runs.
const WELL: Colour = [120, 190, 225];
const FAILED: Colour = [70, 70, 70];
/// Height of the colour bar, and number of its strips.
const BAR: f64 = 200.0;
const STRIPS: usize = 64;
/// Minimum width and height of a cell that contains its number.
const ROOM: [f64; 2] = [44.0, 18.0];

/// Draws the map of a series.
///
/// # Errors
/// The series does not vary both settings, or their values are no numbers.
pub fn draw(view: &ChartView<'_>, series: usize) -> Result<Sheet, String> {
    let chart = view.chart;
    let name = &view.study.series[series].name;
    let key = |axis: &Option<String>| axis.clone().unwrap_or_default();
    let (x_key, y_key) = (key(&chart.x), key(&chart.y));
    let mut cells: Vec<([f64; 2], &PointResult)> = Vec::new();
    for (_, row) in view.rows().filter(|(_, r)| r.series == series) {
        let value = |key: &str| row.setting(key).and_then(number);
        let (Some(x), Some(y)) = (value(&x_key), value(&y_key)) else {
            return Err(format!(
                "chart `{}`: `{name}` has to vary {x_key} and {y_key}, both numeric",
                chart.file
            ));
        };
        cells.push(([x, y], row));
    }
    let edges = |c: usize, log: bool| edges(cells.iter().map(|cell| cell.0[c]).collect(), log);
    let (x_edges, y_edges) = (edges(0, view.is_log("x")), edges(1, view.is_log("y")));
    let ends = |e: &[f64]| (e[0], e[e.len() - 1]);
    let (x_ends, y_ends) = (ends(&x_edges), ends(&y_edges));
    let x = ChartAxis::between(x_ends.0, x_ends.1, view.is_log("x"), [LEFT, RIGHT]);
    let y = ChartAxis::between(y_ends.0, y_ends.1, view.is_log("y"), [BOTTOM, TOP]);
    let ended_only = chart.measure.as_deref() == Some(ENDED);
    let values = cells.iter().filter(|(_, r)| r.ended_well()).map(|(_, r)| view.value(r));
    let colours = ChartAxis::around(values, view.is_log("colour"), [0.0, 1.0]);
    let head = if view.study.series.len() > 1 {
        format!("{}: {name}", view.head())
    } else {
        view.head().into()
    };
    let mut frame = ChartFrame::new(&head, x, y, false);
    let mut words = Vec::new();
    for ([cx, cy], row) in worst_last(cells, view) {
        let [x0, x1] = around(&x_edges, cx).map(|e| frame.x.at(e));
        let [y0, y1] = around(&y_edges, cy).map(|e| frame.y.at(e));
        let value = view.value(row);
        let shade = colours.at(value);
        let fill = match row.ended_well() {
            false => FAILED,
            true if ended_only => WELL,
            true if shade.is_finite() => shaded(shade),
            true => WHITE,
        };
        frame.sheet.rectangle([x0, y0], [x1, y1], fill);
        frame.sheet.line(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]], WHITE, 0.5);
        let roomy = (x1 - x0).abs() > ROOM[0] && (y1 - y0).abs() > ROOM[1];
        let middle = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
        if !row.ended_well() {
            words.push((middle, "×".to_string(), 16.0, WHITE, fill));
        } else if roomy && !ended_only && value.is_finite() {
            let ink = if shade < 0.55 { WHITE } else { BLACK };
            words.push((middle, short(value), 11.5, ink, fill));
        }
    }
    curves(view, &mut frame)?;
    // Drawn over the curves, which may cross them, on a patch with the cell's colour.
    for (at, word, size, ink, fill) in words {
        let half = [0.33 * size * word.chars().count() as f64, 0.6 * size];
        frame.sheet.rectangle(
            [at[0] - half[0], at[1] - half[1]],
            [at[0] + half[0], at[1] + half[1]],
            fill,
        );
        frame.sheet.text(at, &word, size, Anchor::Middle, ink);
    }
    if ended_only {
        frame.entry("completed", |sheet, at| square(sheet, at, WELL));
    } else {
        bar(&mut frame, &colours, &view.measure_title(chart.error));
    }
    frame.entry("failed", |sheet, at| {
        square(sheet, at, FAILED);
        sheet.text(at, "×", 16.0, Anchor::Middle, WHITE);
    });
    let title =
        |given: &Option<String>, key: &str| given.clone().unwrap_or_else(|| key.to_string());
    Ok(frame.draw_axes(&title(&chart.x_title, &x_key), &title(&chart.y_title, &y_key)))
}

/// Sorts cells so that the worst of several at the same position is drawn last, over the others.
fn worst_last<'a>(
    mut cells: Vec<([f64; 2], &'a PointResult)>,
    view: &ChartView<'_>,
) -> Vec<([f64; 2], &'a PointResult)> {
    cells.sort_by(|a, b| {
        let badness = |r: &PointResult| (!r.ended_well(), view.value(r));
        let (a, b) = (badness(a.1), badness(b.1));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    cells
}

/// Returns the edges between cells: half way between neighbours on the scale, and at the same
/// distance beyond the end values.
fn edges(mut values: Vec<f64>, log: bool) -> Vec<f64> {
    let on = |v: f64| if log { v.log10() } else { v };
    let off = |v: f64| if log { 10f64.powf(v) } else { v };
    values.sort_by(f64::total_cmp);
    values.dedup();
    let v: Vec<f64> = values.into_iter().map(on).collect();
    let n = v.len();
    let (first, last) = if n > 1 { (v[1] - v[0], v[n - 1] - v[n - 2]) } else { (1.0, 1.0) };
    let mut edges = vec![off(v[0] - 0.5 * first)];
    edges.extend(v.windows(2).map(|w| off(0.5 * (w[0] + w[1]))));
    edges.push(off(v[n - 1] + 0.5 * last));
    edges
}

/// Returns the two edges around a value.
fn around(edges: &[f64], value: f64) -> [f64; 2] {
    let at = edges.windows(2).find(|w| value >= w[0] && value <= w[1]);
    at.map_or([value, value], |w| [w[0], w[1]])
}

fn shaded(shade: f64) -> Colour {
    let s = shade.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let i = (s.floor() as usize).min(SCALE.len() - 2);
    let part = s - i as f64;
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(SCALE[i][c]), f64::from(SCALE[i + 1][c]));
        (a + part * (b - a)).round() as u8
    })
}

fn square(sheet: &mut Sheet, at: [f64; 2], colour: Colour) {
    sheet.rectangle([at[0] - 9.0, at[1] - 8.0], [at[0] + 9.0, at[1] + 8.0], colour);
}

/// Draws the colour bar with its ticks in the legend.
fn bar(frame: &mut ChartFrame, colours: &ChartAxis, title: &str) {
    frame.gap(8.0);
    frame.note(title);
    let top = frame.gap(BAR + 24.0) + 2.0;
    let y = |fraction: f64| top + BAR * (1.0 - fraction);
    let fraction = |strip: usize| strip as f64 / STRIPS as f64;
    for strip in 0..STRIPS {
        let (low, high) = (fraction(strip), fraction(strip + 1));
        frame.sheet.rectangle(
            [LEGEND, y(high)],
            [LEGEND + 22.0, y(low)],
            shaded(0.5 * (low + high)),
        );
    }
    for tick in colours.ticks() {
        let at = y(colours.at(tick.value));
        if let Some(label) =
            tick.label.filter(|_| colours.at(tick.value) >= 0.0 && colours.at(tick.value) <= 1.0)
        {
            frame.sheet.line(&[[LEGEND + 22.0, at], [LEGEND + 28.0, at]], BLACK, 0.8);
            frame.sheet.text([LEGEND + 33.0, at], &label, SMALL, Anchor::Start, BLACK);
        }
    }
}

/// Draws the theoretical curves over the chart, and adds them to the legend.
pub fn curves(view: &ChartView<'_>, frame: &mut ChartFrame) -> Result<(), String> {
    const SAMPLES: usize = 400;
    for (number, curve) in view.chart.curve.iter().enumerate() {
        let part = |i: usize| i as f64 / SAMPLES as f64;
        let places: Vec<Option<[f64; 2]>> = match &curve.formula {
            Some(text) => {
                let y = formula(text)?;
                let x = |i: usize| frame.x.value(part(i));
                (0..=SAMPLES).map(|i| frame.at(x(i), y(x(i)))).collect()
            }
            // Straight on the page, and cut at the edge of the plot.
            None => {
                let ends: Vec<[f64; 2]> =
                    curve.points.iter().map(|p| [frame.x.at(p[0]), frame.y.at(p[1])]).collect();
                let between = |w: &[[f64; 2]], i: usize| {
                    [0, 1].map(|c| w[0][c] + part(i) * (w[1][c] - w[0][c]))
                };
                let inside = |at: &[f64; 2]| frame.x.holds(at[0]) && frame.y.holds(at[1]);
                let all = ends.windows(2).flat_map(|w| (0..=SAMPLES).map(move |i| between(w, i)));
                all.map(|at| Some(at).filter(inside)).collect()
            }
        };
        let dashed = number % 2 == 1;
        for run in places.split(Option::is_none) {
            let run: Vec<[f64; 2]> = run.iter().flatten().copied().collect();
            stroke(&mut frame.sheet, &run, dashed);
        }
        frame.entry(&curve.name, |sheet, at| {
            stroke(sheet, &[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], dashed)
        });
    }
    Ok(())
}

/// Draws a dark line with a light border, visible on any colour.
fn stroke(sheet: &mut Sheet, points: &[[f64; 2]], dashed: bool) {
    const RED: Colour = [214, 39, 40];
    if points.len() < 2 {
        return;
    }
    sheet.line(points, WHITE, 4.5);
    if dashed { sheet.dashed(points, RED, 2.2) } else { sheet.line(points, RED, 2.2) }
}
