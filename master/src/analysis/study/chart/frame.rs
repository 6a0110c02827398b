//! Common parts of all charts: title, axes with titles and ticks, and a column on the right for
//! the legend.

use super::axis::ChartAxis;
use super::canvas::{Anchor, BLACK, Colour, GREY, LIGHT, SIZE, Sheet};

/// Left edge of the plot on the page.
pub const LEFT: f64 = 95.0;
/// Top edge of the plot.
pub const TOP: f64 = 62.0;
/// Right edge of the plot.
pub const RIGHT: f64 = 700.0;
/// Bottom edge of the plot.
pub const BOTTOM: f64 = 545.0;
/// Left edge of the legend.
pub const LEGEND: f64 = RIGHT + 24.0;

/// Size of texts: title, axis titles, ticks and legend.
const HEAD: f64 = 19.0;
const TITLE: f64 = 16.0;
/// See [`HEAD`].
pub const SMALL: f64 = 13.5;
/// Characters per line of the legend, and distance of its lines.
const LEGEND_WIDTH: usize = 34;
const LINE: f64 = 19.0;

/// Colours of series by Okabe and Ito (2008), which people with any kind of colour vision can
/// distinguish.
const COLOURS: [Colour; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [60, 60, 60],
];

/// Returns the colour of a series.
pub fn colour(series: usize) -> Colour {
    COLOURS[series % COLOURS.len()]
}

/// A page with axes. Further shapes are drawn over it.
pub struct ChartFrame {
    /// The page.
    pub sheet: Sheet,
    /// Scale along x.
    pub x: ChartAxis,
    /// Scale along y.
    pub y: ChartAxis,
    below: f64,
}

impl ChartFrame {
    /// Draws title and grid; [`ChartFrame::draw_axes`] draws the axes.
    pub fn new(head: &str, x: ChartAxis, y: ChartAxis, grid: bool) -> Self {
        let mut sheet = Sheet::default();
        sheet.text([LEFT, 28.0], head, HEAD, Anchor::Start, BLACK);
        if grid {
            for tick in x.ticks().iter().filter(|t| t.label.is_some()) {
                sheet.line(&[[x.at(tick.value), TOP], [x.at(tick.value), BOTTOM]], LIGHT, 0.5);
            }
            for tick in y.ticks().iter().filter(|t| t.label.is_some()) {
                sheet.line(&[[LEFT, y.at(tick.value)], [RIGHT, y.at(tick.value)]], LIGHT, 0.5);
            }
        }
        Self { sheet, x, y, below: TOP + 10.0 }
    }

    /// Returns the position of a point on the page, none if it is outside the plot.
    pub fn at(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let at = [self.x.at(x), self.y.at(y)];
        (self.x.holds(at[0]) && self.y.holds(at[1])).then_some(at)
    }

    /// Adds a line to the legend: `sign` draws a symbol at a position, and a long text is
    /// wrapped.
    pub fn entry(&mut self, text: &str, sign: impl Fn(&mut Sheet, [f64; 2])) {
        sign(&mut self.sheet, [LEGEND + 12.0, self.below + 2.0]);
        for line in wrap(text, LEGEND_WIDTH - 5) {
            self.sheet.text([LEGEND + 32.0, self.below + 2.0], &line, SMALL, Anchor::Start, BLACK);
            self.below += LINE;
        }
    }

    /// Adds a remark below the legend.
    pub fn note(&mut self, text: &str) {
        for line in wrap(text, LEGEND_WIDTH) {
            self.sheet.text([LEGEND, self.below], &line, SMALL, Anchor::Start, GREY);
            self.below += LINE;
        }
    }

    /// Reserves a height in the legend and returns its start.
    pub fn gap(&mut self, height: f64) -> f64 {
        self.below += height;
        self.below - height
    }

    /// Draws the axes and their titles, and returns the page.
    pub fn draw_axes(mut self, x_title: &str, y_title: &str) -> Sheet {
        let sheet = &mut self.sheet;
        sheet.reach(self.below + LINE);
        sheet.line(
            &[[LEFT, TOP], [RIGHT, TOP], [RIGHT, BOTTOM], [LEFT, BOTTOM], [LEFT, TOP]],
            BLACK,
            0.8,
        );
        for tick in self.x.ticks() {
            let at = self.x.at(tick.value);
            let long = if tick.label.is_some() { 7.0 } else { 4.0 };
            sheet.line(&[[at, BOTTOM], [at, BOTTOM + long]], BLACK, 0.8);
            tick.label
                .iter()
                .for_each(|l| sheet.text([at, BOTTOM + 19.0], l, SMALL, Anchor::Middle, BLACK));
        }
        for tick in self.y.ticks() {
            let at = self.y.at(tick.value);
            let long = if tick.label.is_some() { 7.0 } else { 4.0 };
            sheet.line(&[[LEFT - long, at], [LEFT, at]], BLACK, 0.8);
            tick.label
                .iter()
                .for_each(|l| sheet.text([LEFT - 11.0, at], l, SMALL, Anchor::End, BLACK));
        }
        sheet.text([0.5 * (LEFT + RIGHT), SIZE[1] - 30.0], x_title, TITLE, Anchor::Middle, BLACK);
        sheet.upright([24.0, 0.5 * (TOP + BOTTOM)], y_title, TITLE);
        self.sheet
    }
}

/// Breaks a text at blanks into lines of at most `width` characters. A longer word is not broken.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + word.chars().count() >= width {
            lines.push(word.into());
        } else {
            let blank = if lines[last].is_empty() { "" } else { " " };
            lines[last] = format!("{}{blank}{word}", lines[last]);
        }
    }
    lines
}
