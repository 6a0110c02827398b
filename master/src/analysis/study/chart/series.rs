//! Curves given as numbers, for commands that measure without a study.

use super::axis::ChartAxis;
use super::canvas::WHITE;
use super::frame::{BOTTOM, ChartFrame, LEFT, RIGHT, TOP, colour};
use std::path::{Path, PathBuf};

/// A named curve.
pub struct Polyline {
    /// Name in the legend.
    pub name: String,
    /// True for a dashed line without markers.
    pub dashed: bool,
    /// Index of its colour; curves may share one.
    pub colour: usize,
    /// Points, with x from 1 and y in percent.
    pub points: Vec<[f64; 2]>,
}

/// Draws percentages over powers of two, writes them as `PATH.svg` and `PATH.png`, and returns
/// both paths.
///
/// # Errors
/// A file cannot be written.
pub fn percent_over_doublings(
    head: &str,
    titles: [&str; 2],
    curves: &[Polyline],
    path: &Path,
) -> Result<[PathBuf; 2], String> {
    let all = || curves.iter().flat_map(|c| &c.points);
    let most = all().map(|p| p[0]).fold(1.0, f64::max);
    let words = (0..=most.log2().ceil() as u32).map(|power| 2u64.pow(power).to_string()).collect();
    let top = all().map(|p| p[1]).fold(100.0, f64::max);
    let y = ChartAxis::between(0.0, 1.04 * top, false, [BOTTOM, TOP]);
    let mut frame = ChartFrame::new(head, ChartAxis::of_words(words, [LEFT, RIGHT]), y, true);
    for curve in curves {
        let places: Vec<[f64; 2]> =
            curve.points.iter().filter_map(|p| frame.at(p[0].log2(), p[1])).collect();
        let (tint, number) = (colour(curve.colour), curve.colour);
        if curve.dashed {
            frame.sheet.dashed(&places, tint, 1.4);
            frame.entry(&curve.name, |sheet, at| {
                sheet.dashed(&[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], tint, 1.4)
            });
            continue;
        }
        frame.sheet.line(&places, tint, 1.4);
        for at in &places {
            frame.sheet.marker(*at, number, 6.5, WHITE);
            frame.sheet.marker(*at, number, 5.5, tint);
        }
        frame.entry(&curve.name, |sheet, at| {
            sheet.line(&[[at[0] - 14.0, at[1]], [at[0] + 14.0, at[1]]], tint, 1.4);
            sheet.marker(at, number, 5.5, tint);
        });
    }
    frame.draw_axes(titles[0], titles[1]).write(path)
}
