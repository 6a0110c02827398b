//! A page of shapes and texts, written as SVG and PNG. No system font is needed: texts are set in
//! `sans.ttf`.

use plotters::backend::{BitMapBackend, SVGBackend};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{PathElement, Polygon, Text};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle, register_font,
};
use std::path::{Path, PathBuf};
use std::sync::Once;

/// Size of a page in its own units. A long legend increases the height.
pub const SIZE: [f64; 2] = [1000.0, 620.0];
/// Pixels per unit in both kinds of files.
const SCALE: f64 = 1.5;
/// Length of dashes and of the gaps between them.
const DASH: [f64; 2] = [8.0, 5.0];

/// The font and its name here. Every browser has a font of this name for the SVG files.
const FONT: &[u8] = include_bytes!("sans.ttf");
const FONT_NAME: &str = "sans-serif";

/// A colour: red, green, blue.
pub type Colour = [u8; 3];
/// Black.
pub const BLACK: Colour = [0, 0, 0];
/// White.
pub const WHITE: Colour = [255, 255, 255];
/// Light grey for grids.
pub const LIGHT: Colour = [222, 222, 222];
/// Grey for secondary content.
pub const GREY: Colour = [110, 110, 110];

/// Alignment of a text with respect to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centred there.
    Middle,
    /// The text ends there.
    End,
}

#[derive(Clone, Debug)]
enum DrawnShape {
    Line { points: Vec<[f64; 2]>, colour: Colour, width: f64 },
    Area { points: Vec<[f64; 2]>, colour: Colour },
    Text { at: [f64; 2], text: String, size: f64, anchor: Anchor, upright: bool, colour: Colour },
}

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    shapes: Vec<DrawnShape>,
    /// Required height, if that of [`SIZE`] is too small.
    needed: f64,
}

impl Sheet {
    /// Makes the page at least this high.
    pub fn reach(&mut self, height: f64) {
        self.needed = self.needed.max(height);
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: &[[f64; 2]], colour: Colour, width: f64) {
        self.shapes.push(DrawnShape::Line { points: points.to_vec(), colour, width });
    }

    /// Draws a dashed line through points.
    pub fn dashed(&mut self, points: &[[f64; 2]], colour: Colour, width: f64) {
        let (mut left, mut on) = (DASH[0], true);
        for pair in points.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let at = |s: f64| [0, 1].map(|c| a[c] + s / length * (b[c] - a[c]));
            let mut done = 0.0;
            while done < length {
                let next = length.min(done + left);
                if on {
                    self.line(&[at(done), at(next)], colour, width);
                }
                left -= next - done;
                if left <= 1e-6 {
                    // Round-off may leave a rest too small to be added to `done`.
                    on = !on;
                    left = DASH[usize::from(!on)];
                }
                done = next;
            }
        }
    }

    /// Draws a filled polygon.
    pub fn area(&mut self, points: &[[f64; 2]], colour: Colour) {
        self.shapes.push(DrawnShape::Area { points: points.to_vec(), colour });
    }

    /// Draws a filled rectangle between two corners.
    pub fn rectangle(&mut self, a: [f64; 2], b: [f64; 2], colour: Colour) {
        self.area(&[a, [b[0], a[1]], b, [a[0], b[1]]], colour);
    }

    /// Draws a text in one line, vertically centred at `at`.
    pub fn text(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor, colour: Colour) {
        self.shapes.push(DrawnShape::Text {
            at,
            text: text.into(),
            size,
            anchor,
            upright: false,
            colour,
        });
    }

    /// Draws a text that runs upwards, with its middle at `at`.
    pub fn upright(&mut self, at: [f64; 2], text: &str, size: f64) {
        let text = text.into();
        self.shapes.push(DrawnShape::Text {
            at,
            text,
            size,
            anchor: Anchor::Middle,
            upright: true,
            colour: BLACK,
        });
    }

    /// Draws the marker of a series: shape number `kind` of a list of different shapes.
    pub fn marker(&mut self, at: [f64; 2], kind: usize, size: f64, colour: Colour) {
        let corners: &[[f64; 2]] = match kind % 5 {
            0 => return self.area(&circle(at, size), colour),
            1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            2 => &[[0.0, -1.15], [1.1, 0.85], [-1.1, 0.85]],
            3 => &[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]],
            _ => &[[0.0, 1.15], [1.1, -0.85], [-1.1, -0.85]],
        };
        let points: Vec<[f64; 2]> =
            corners.iter().map(|c| [at[0] + size * c[0], at[1] + size * c[1]]).collect();
        self.area(&points, colour);
    }

    /// Draws a ring around a point.
    pub fn ring(&mut self, at: [f64; 2], radius: f64, colour: Colour, width: f64) {
        let mut points = circle(at, radius);
        points.push(points[0]);
        self.line(&points, colour, width);
    }

    /// Writes `PATH.svg` and `PATH.png`, and returns both paths.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, path: &Path) -> Result<[PathBuf; 2], String> {
        static REGISTERED: Once = Once::new();
        REGISTERED.call_once(|| register_font(FONT_NAME, FontStyle::Normal, FONT).unwrap_or(()));
        let named = |ending: &str| PathBuf::from(format!("{}.{ending}", path.display()));
        let (svg, png) = (named("svg"), named("png"));
        let size = (pixel(SIZE[0]) as u32, pixel(SIZE[1].max(self.needed)) as u32);
        self.paint(&SVGBackend::new(&svg, size).into_drawing_area(), &svg)?;
        self.paint(&BitMapBackend::new(&png, size).into_drawing_area(), &png)?;
        Ok([svg, png])
    }

    fn paint<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        path: &Path,
    ) -> Result<(), String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        area.fill(&rgb(WHITE)).map_err(|e| failed(&e))?;
        for shape in &self.shapes {
            match shape {
                DrawnShape::Line { points, colour, width } => {
                    let stroke_width = pixel(*width).max(1) as u32;
                    let style =
                        ShapeStyle { color: rgb(*colour).into(), filled: false, stroke_width };
                    area.draw(&PathElement::new(pixels(points), style))
                }
                DrawnShape::Area { points, colour } => {
                    let style =
                        ShapeStyle { color: rgb(*colour).into(), filled: true, stroke_width: 0 };
                    area.draw(&Polygon::new(pixels(points), style))
                }
                DrawnShape::Text { at, text, size, anchor, upright, colour } => {
                    let font = (FONT_NAME, size * SCALE).into_font();
                    let font =
                        if *upright { font.transform(FontTransform::Rotate270) } else { font };
                    let h = match anchor {
                        Anchor::Start => HPos::Left,
                        Anchor::Middle => HPos::Center,
                        Anchor::End => HPos::Right,
                    };
                    let colour = rgb(*colour);
                    let style = TextStyle::from(font).color(&colour).pos(Pos::new(h, VPos::Center));
                    area.draw(&Text::new(text.as_str(), (pixel(at[0]), pixel(at[1])), style))
                }
            }
            .map_err(|e| failed(&e))?;
        }
        area.present().map_err(|e| failed(&e))
    }
}

fn circle(at: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let angle = |i: i32| f64::from(i) * std::f64::consts::TAU / 24.0;
    (0..24).map(|i| [at[0] + radius * angle(i).cos(), at[1] + radius * angle(i).sin()]).collect()
}

fn rgb([r, g, b]: Colour) -> RGBColor {
    RGBColor(r, g, b)
}

fn pixel(x: f64) -> i32 {
    (x * SCALE).round() as i32
}

fn pixels(points: &[[f64; 2]]) -> Vec<(i32, i32)> {
    points.iter().map(|p| (pixel(p[0]), pixel(p[1]))).collect()
}
