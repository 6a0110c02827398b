//! Converts functions, boxes and systems.

use super::StarterConverter;
use super::motion::or_one;
use crate::input::deck::convert::curves::DeckCurve;
use crate::input::deck::convert::space::{cross, unit};
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::radioss::BEYOND;
use crate::input::deck::record::CardLine;
use crate::input::job::tree::Place;

impl StarterConverter {
    pub(super) fn functions(&mut self) {
        for record in self.take(&["/FUNCT", "/FUNCT_SMOOTH"]) {
            let (id, place, name) = (record.integer("id"), record.place("id"), record.name());
            let point = |line: &CardLine| [line.real("x"), line.real("y")];
            let mut points: Vec<[f64; 2]> = record.lines("x").map(point).collect();
            let mut lines: Vec<Place> = record.lines("x").map(|line| line.place).collect();
            if points.is_empty() {
                let help = "give abscissa and ordinate, twenty columns each, one point per line";
                self.deck.trouble.error(place, format!("{name}/{id} has no points"), help);
            }
            if record.row.keyword.name == "/FUNCT_SMOOTH" {
                let [x, y] = ["ascalex", "fscaley"].map(|field| or_one(record.real(field)));
                let [right, up] = ["ashiftx", "fshifty"].map(|field| record.real(field));
                points.iter_mut().for_each(|p| *p = [x * p[0] + right, y * p[1] + up]);
                // Points in another order are reported as those of other functions.
                if points.is_sorted_by(|a, b| a[0] < b[0]) {
                    points = smooth_steps(&points);
                    lines = vec![place; points.len()];
                    let used = format!("{STEPS} straight lines for each step");
                    self.deck.map(format!("{name}/{id}"), "smooth steps", used);
                }
            }
            let curve = DeckCurve::new(points, place, lines);
            if self.deck.curves.insert(id, curve).is_some() {
                self.twice(&name, id, place);
            }
        }
    }

    /// Reports that two entities have one id.
    pub(super) fn twice(&mut self, name: &str, id: i64, place: Place) {
        let message = format!("there are two {name} with the id {id}");
        self.deck.trouble.error(place, message, "give each a different id");
    }

    /// Reads boxes and systems.
    pub(super) fn systems(&mut self) {
        for record in self.take(&["/BOX/RECTA"]) {
            let mut corners = [["xp1", "yp1", "zp1"], ["xp2", "yp2", "zp2"]]
                .map(|names| names.map(|field| record.real(field)));
            for (field, corner) in ["n1", "n2"].into_iter().zip(&mut corners) {
                let node = record.integer(field);
                match super::groups::node(node) {
                    _ if node == 0 => {}
                    Some(id) if self.deck.rows.at(id).is_some() => {
                        *corner = self.deck.rows.at(id).unwrap_or_default();
                    }
                    _ => self.deck.missing(record.place(field), "/NODE", node, &[]),
                }
            }
            let sides = [0, 1, 2].map(|c| {
                let (a, b) = (corners[0][c], corners[1][c]);
                [a.min(b), a.max(b)]
            });
            self.deck.boxes.insert(record.integer("id"), sides);
        }
        for record in self.take(&["/SKEW/FIX"]) {
            let id = record.integer("id");
            // The origin has no influence on directions.
            let _ = ["ox", "oy", "oz"].map(|field| record.real(field));
            let second = ["x1", "y1", "z1"].map(|field| record.real(field));
            let third = ["x2", "y2", "z2"].map(|field| record.real(field));
            let first = unit(cross(second, third));
            let axes = first.and_then(|x| {
                let y = unit(second)?;
                Some([x, y, unit(cross(x, y))?])
            });
            match axes {
                Some(axes) => {
                    self.deck.axes.insert(id, axes);
                }
                None => {
                    let message = format!("/SKEW/FIX/{id} has no axes");
                    let help = "give vectors along its second and its third axis that are not \
                                parallel";
                    self.deck.trouble.error(record.place("x1"), message, help);
                }
            }
        }
    }

    /// Returns the name in the job of a function of time, which is added at its first use. Values
    /// of Radioss continue with the last slope of a function; the curve gets such points.
    pub(super) fn time_function(&mut self, line: &CardLine, scale: f64) -> Option<String> {
        let (id, place) = (line.integer("fct"), line.place("fct"));
        if id == 0 {
            return self.put_curve("factor of 1".into(), vec![[0.0, 1.0], [1.0, 1.0]], line.place);
        }
        let curve = self.deck.curve(id, place)?;
        let stretched: Vec<[f64; 2]> = curve.points.iter().map(|p| [p[0] * scale, p[1]]).collect();
        let points = extended(stretched, self.deck.end_time);
        if points == curve.points {
            let name = format!("curve-{id}");
            return self.put_curve(name, points, curve.place);
        }
        self.deck.map(
            format!("function {id}"),
            match scale == 1.0 {
                true => "continues with its last slope".to_string(),
                false => format!("abscissa scaled by {scale}, continues with its last slope"),
            },
            "points are added, far beyond the end of the run",
        );
        let name = match scale == 1.0 {
            true => format!("curve-{id}"),
            false => {
                self.made_curves += 1;
                format!("curve-{id} scaled {}", self.made_curves)
            }
        };
        self.put_curve(name, points, curve.place)
    }

    /// Adds a curve to the job, unless it is there. Returns its name.
    fn put_curve(&mut self, name: String, points: Vec<[f64; 2]>, place: Place) -> Option<String> {
        if !self.curve_names.insert(name.clone()) {
            return Some(name);
        }
        let rows: Vec<Vec<f64>> = points.iter().map(|p| p.to_vec()).collect();
        let table = JobTable::new(place).with("name", place, name.as_str());
        self.deck.add("curve", table.with("points", place, rows));
        Some(name)
    }

    /// Returns the points of a function.
    pub(super) fn points_of(&mut self, id: i64, place: Place) -> Option<Vec<[f64; 2]>> {
        self.deck.curve(id, place).map(|curve| curve.points)
    }
}

/// Returns points that continue with the first and the last slope, from time 0 to far beyond the
/// end of the run: a job can move it, and gives it if there is no engine file.
fn extended(mut points: Vec<[f64; 2]>, end: f64) -> Vec<[f64; 2]> {
    let own = points.last().map_or(0.0, |p| p[0]);
    let end = BEYOND * if end > 0.0 { end } else { own };
    let slope = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    if points.len() < 2 {
        return points;
    }
    let first = slope(points[0], points[1]);
    if points[0][0] > 0.0 && first.is_finite() && first != 0.0 {
        points.insert(0, [0.0, points[0][1] - first * points[0][0]]);
    }
    let [.., before, last] = points[..] else { return points };
    let rate = slope(before, last);
    if last[0] < end && rate.is_finite() && rate != 0.0 {
        points.push([end, last[1] + rate * (end - last[0])]);
    }
    points
}

/// Number of straight lines for a smooth step. They deviate from it by at most
/// `10 / sqrt(3) / (8 STEPS^2)` of its height, 2e-4.
const STEPS: usize = 64;

/// Returns points on the smooth steps `10 s^3 - 15 s^4 + 6 s^5` between given points, and a point
/// on either side with the value there, so that the function is constant beyond them (Radioss
/// reference guide, /FUNCT_SMOOTH).
fn smooth_steps(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let [Some(&first), Some(&last)] = [points.first(), points.last()] else { return Vec::new() };
    let width = if last[0] > first[0] { last[0] - first[0] } else { 1.0 };
    let mut all = vec![[first[0] - width, first[1]], first];
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        all.extend((1..=STEPS).map(|i| {
            let s = i as f64 / STEPS as f64;
            let rise = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
            [from[0] + s * (to[0] - from[0]), from[1] + rise * (to[1] - from[1])]
        }));
    }
    all.push([last[0] + width, last[1]]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_steps_have_their_values_and_are_constant_beyond() {
        let all = smooth_steps(&[[0.0, 0.0], [2.0, 60.0], [4.0, 20.0]]);
        assert_eq!((all.len(), all[0], all[1]), (2 * STEPS + 3, [-4.0, 0.0], [0.0, 0.0]));
        let at = |x: f64| all.iter().find(|p| p[0] == x).unwrap()[1];
        assert_eq!([at(1.0), at(2.0), at(3.0), at(4.0), at(8.0)], [30.0, 60.0, 40.0, 20.0, 20.0]);
        // 10/64 - 15/256 + 6/1024
        assert_eq!(at(0.5), 60.0 * 0.103515625);
        assert_eq!(smooth_steps(&[[1.0, 3.0]]), [[0.0, 3.0], [1.0, 3.0], [2.0, 3.0]]);
    }

    /// A function goes on with its slopes beyond its points; a constant one needs no points.
    #[test]
    fn functions_continue_with_their_slopes() {
        let ramp = vec![[1.0, 2.0], [2.0, 4.0]];
        assert_eq!(extended(ramp.clone(), 0.0)[3], [2e3, 4e3], "the end is not known");
        assert_eq!(extended(ramp, 3.0), [[0.0, 0.0], [1.0, 2.0], [2.0, 4.0], [3e3, 6e3]]);
        let flat = vec![[0.0, 1.0], [1.0, 1.0]];
        assert_eq!(extended(flat.clone(), 3.0), flat);
        let long = vec![[0.0, 0.0], [9e3, 1.0]];
        assert_eq!(extended(long.clone(), 3.0), long);
    }
}
