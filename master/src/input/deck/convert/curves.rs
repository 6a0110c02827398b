//! Converts `*DEFINE_CURVE`.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;

/// A curve with its scales and offsets applied.
#[derive(Clone, Debug)]
pub struct DeckCurve {
    /// Abscissa and ordinate.
    pub points: Vec<[f64; 2]>,
    /// Place of the keyword.
    pub place: Place,
    /// Places of its points.
    pub lines: Vec<Place>,
    /// True if it is for dynamic relaxation only.
    relaxes: bool,
    /// True if a load or motion uses it.
    used: bool,
    /// Times from which copies of it start.
    starts: Vec<f64>,
}

impl DeckCurve {
    /// Creates a curve that is not in use yet.
    pub(super) fn new(points: Vec<[f64; 2]>, place: Place, lines: Vec<Place>) -> Self {
        Self { points, place, lines, relaxes: false, used: false, starts: Vec::new() }
    }
}

impl DeckConverter {
    pub(super) fn curves(&mut self) {
        for record in self.take_records("DEFINE_CURVE") {
            let id = record.integer("lcid");
            let place = record.place("lcid");
            let (sfa, sfo) = (one(record.real("sfa")), one(record.real("sfo")));
            let (offa, offo) = (record.real("offa"), record.real("offo"));
            let units = self.curve_units.of(id, place, &mut self.trouble);
            let point = |line: &crate::input::deck::record::CardLine| {
                let (a, o) = (sfa * (line.real("a") + offa), sfo * (line.real("o") + offo));
                [a * units[0], o * units[1]]
            };
            let points: Vec<[f64; 2]> = record.lines("a").map(point).collect();
            let lines = record.lines("a").map(|line| line.place).collect();
            if points.is_empty() {
                let help = "give abscissa and ordinate, twenty columns each, one point per line";
                self.trouble.error(place, format!("*DEFINE_CURVE {id} has no points"), help);
            }
            let relaxes = self.relaxes(&record);
            let curve = DeckCurve { relaxes, ..DeckCurve::new(points, place, lines) };
            if self.curves.insert(id, curve).is_some() {
                self.trouble.error(
                    place,
                    format!("there are two *DEFINE_CURVE with the id {id}"),
                    "give each a different id",
                );
            }
        }
    }

    /// Returns a curve by its id. Reports an error at `place` if there is none.
    pub(super) fn curve(&mut self, id: i64, place: Place) -> Option<DeckCurve> {
        let found = self.curves.get(&id).cloned();
        if found.is_none() {
            let known: Vec<String> = self.curves.keys().map(i64::to_string).collect();
            self.missing(place, self.names.curve, id, &known);
        }
        found
    }

    /// Returns true if a curve is for dynamic relaxation only (sidr 1), not for the run.
    fn relaxes(&mut self, record: &CardRecord) -> bool {
        match record.integer("sidr") {
            0 => {}
            1 => return true,
            2 => self.map(
                format!("curve {}", record.integer("lcid")),
                "sidr 2: for dynamic relaxation and for the run",
                "for the run: there is no dynamic relaxation",
            ),
            _ => self.unsupported_value(record, "sidr", "use 0 (run), 1 or 2"),
        }
        false
    }

    /// Returns the name in the job of a copy of a curve whose first point is at a later time: that
    /// of what begins to act then. Otherwise as [`Self::time_curve`].
    pub(super) fn time_curve_from(&mut self, id: i64, place: Place, start: f64) -> Option<String> {
        let curve = self.curve(id, place)?;
        let first = curve.points.first().map_or(0.0, |p| p[0]);
        if curve.relaxes || start <= 0.0 || start == first {
            return self.time_curve(id, place);
        }
        let name = format!("curve-{id}-from-{start}");
        if !curve.starts.contains(&start) {
            let moved = |p: &[f64; 2]| vec![p[0] - first + start, p[1]];
            let points: Vec<Vec<f64>> = curve.points.iter().map(moved).collect();
            let table = JobTable::new(curve.place).with("name", curve.place, name.as_str()).with(
                "points",
                curve.place,
                points,
            );
            self.add("curve", table);
            self.curves.entry(id).and_modify(|c| c.starts.push(start));
        }
        Some(name)
    }

    /// Returns the name in the job of a curve for a load or a motion. The curve is added to the
    /// job at its first use. Returns `None` if there is no such curve, and for a curve of dynamic
    /// relaxation, which does not act in the run.
    pub(super) fn time_curve(&mut self, id: i64, place: Place) -> Option<String> {
        let curve = self.curve(id, place)?;
        if curve.relaxes {
            let message = format!("*DEFINE_CURVE {id} is for dynamic relaxation only (sidr is 1)");
            let help = "what uses it is left out: it does not act in the run, and there is no \
                        dynamic relaxation before it";
            self.trouble.warning(place, message, help);
            return None;
        }
        let name = format!("curve-{id}");
        if !curve.used {
            let mut table = JobTable::new(curve.place).with("name", curve.place, name.as_str());
            table.put(
                "points",
                curve.place,
                curve.points.iter().map(|p| p.to_vec()).collect::<Vec<_>>(),
            );
            self.add("curve", table);
            self.curves.entry(id).and_modify(|c| c.used = true);
            if curve.points.last().is_some_and(|p| p[0] < self.end_time) {
                let last = curve.points.last().map_or(0.0, |p| p[0]);
                let message =
                    format!("*DEFINE_CURVE {id} ends at {last}, before the end of the run");
                self.trouble.warning(
                    curve.place,
                    message,
                    "it keeps its last value; add points if it has to change",
                );
            }
        }
        Some(name)
    }
}

/// Returns the scale, or 1 for zero.
pub(super) fn one(scale: f64) -> f64 {
    if scale == 0.0 { 1.0 } else { scale }
}
