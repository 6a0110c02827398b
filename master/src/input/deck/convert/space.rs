//! Boxes and coordinate systems.

use super::DeckConverter;
use crate::input::deck::record::{CardLine, CardRecord};
use crumple_proto::ids::NodeId;

impl DeckConverter {
    pub(super) fn space(&mut self) {
        for record in self.take_records("DEFINE_BOX") {
            let range = |low: &str, high: &str| [record.real(low), record.real(high)];
            let sides = [range("xmn", "xmx"), range("ymn", "ymx"), range("zmn", "zmx")];
            self.boxes.insert(record.integer("boxid"), sides);
        }
        for record in self.take_records("DEFINE_COORDINATE_SYSTEM") {
            let point = |names: [&str; 3]| names.map(|n| record.real(n));
            if record.integer("cidl") != 0 {
                self.unsupported_value(&record, "cidl", "points in another coordinate system");
            }
            let (o, l, p) =
                (point(["xo", "yo", "zo"]), point(["xl", "yl", "zl"]), point(["xp", "yp", "zp"]));
            self.system(&record, o, l, p);
        }
        for record in self.take_records("DEFINE_COORDINATE_VECTOR") {
            if record.integer("nid") != 0 {
                self.unsupported_value(&record, "nid", "axes that rotate with a node");
            }
            let vector = |names: [&str; 3]| names.map(|n| record.real(n));
            let (x, in_plane) = (vector(["xx", "yx", "zx"]), vector(["xv", "yv", "zv"]));
            self.system(&record, [0.0; 3], x, in_plane);
        }
        for record in self.take_records("DEFINE_COORDINATE_NODES") {
            let dir = record.word("dir");
            if !(dir.is_empty() || dir.eq_ignore_ascii_case("x")) {
                let message = format!("*DEFINE_COORDINATE_NODES: dir = {dir} is not supported");
                self.unsupported(
                    record.place("dir"),
                    message,
                    "*DEFINE_COORDINATE_NODES dir".into(),
                );
            }
            if record.integer("flag") != 0 {
                self.map(
                    "coordinate system",
                    "flag 1: axes that rotate with their nodes",
                    "fixed axes from the initial positions of the nodes",
                );
            }
            let mut points = [[0.0; 3]; 3];
            for (point, name) in points.iter_mut().zip(["n1", "n2", "n3"]) {
                let id = record.integer(name);
                match self.rows.at(NodeId(u64::try_from(id).unwrap_or(0))) {
                    Some(x) => *point = x,
                    None => self.missing(record.place(name), "node", id, &[]),
                }
            }
            let [o, l, p] = points;
            self.system(&record, o, l, p);
        }
    }

    /// Adds axes given by an origin, a point on the x axis and one in the x-y plane.
    fn system(&mut self, record: &CardRecord, o: [f64; 3], l: [f64; 3], p: [f64; 3]) {
        let from = |a: [f64; 3]| [0, 1, 2].map(|c| a[c] - o[c]);
        let axes = unit(from(l)).and_then(|x| {
            let z = unit(cross(x, from(p)))?;
            Some([x, cross(z, x), z])
        });
        match axes {
            Some(axes) => {
                self.axes.insert(record.integer("cid"), axes);
            }
            None => {
                let message = format!(
                    "{} {}: its points are on one line",
                    record.name(),
                    record.integer("cid")
                );
                let help = "give an origin, a point on the x axis, and a point in the x-y plane \
                    off this axis";
                self.trouble.error(record.place("cid"), message, help);
            }
        }
    }

    /// Returns a vector in global axes that is given in the system of `field`; unchanged without
    /// a system. Returns `None` after a report if there is no such system; `lost` is what the
    /// model lacks then.
    pub(super) fn in_global_axes(
        &mut self,
        v: [f64; 3],
        line: &CardLine,
        field: &str,
        lost: &str,
    ) -> Option<[f64; 3]> {
        let id = line.integer(field);
        if id == 0 {
            return Some(v);
        }
        let Some(axes) = self.axes.get(&id) else {
            let known: Vec<String> = self.axes.keys().map(i64::to_string).collect();
            self.missing_for(line.place(field), (self.names.system, id), &known, lost);
            return None;
        };
        Some([0, 1, 2].map(|c| (0..3).map(|a| v[a] * axes[a][c]).sum()))
    }

    /// Returns true if the axes of a system are the global ones.
    pub(super) fn is_plain(&self, id: i64) -> bool {
        let plain = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        id == 0 || self.axes.get(&id) == Some(&plain)
    }
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the unit vector; `None` if it has no direction.
pub fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let scaled = v.map(|c| c / largest);
    let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
    (largest > 0.0 && largest.is_finite()).then(|| scaled.map(|c| c / length))
}

/// Returns direction cosines: a vector of unit length as it is, another one normalised, so that
/// a direction that is written with all digits keeps them.
pub fn cosines(v: [f64; 3]) -> Option<[f64; 3]> {
    /// Difference of the square of a length from 1 that is round-off.
    const ROUNDED: f64 = 1e-12;
    let square: f64 = v.iter().map(|c| c * c).sum();
    if (square - 1.0).abs() <= ROUNDED { Some(v) } else { unit(v) }
}
