//! Converts `*CONSTRAINED_RIGID_BODY_STOPPERS`: bounds of the motion of rigid bodies.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Entries of one key of the bodies of a deck, by the part on their cards.
#[derive(Debug)]
pub struct BodyEntries {
    key: &'static str,
    by_part: BTreeMap<i64, (Place, Vec<JobTable>)>,
}

impl BodyEntries {
    /// Creates a list without entries.
    pub(super) fn new(key: &'static str) -> Self {
        Self { key, by_part: BTreeMap::new() }
    }

    /// Adds entries of the body of a part.
    pub(super) fn add(&mut self, pid: i64, place: Place, entries: Vec<JobTable>) {
        self.by_part.entry(pid).or_insert((place, Vec::new())).1.extend(entries);
    }

    /// Puts the entries of all parts that `belong` to a body into its table.
    pub(super) fn put(&mut self, table: &mut JobTable, belong: impl Fn(i64) -> bool) {
        let own: Vec<i64> = self.by_part.keys().copied().filter(|&pid| belong(pid)).collect();
        let found: Vec<(Place, Vec<JobTable>)> =
            own.iter().filter_map(|pid| self.by_part.remove(pid)).collect();
        if let Some(&(place, _)) = found.first() {
            let all: Vec<JobTable> = found.into_iter().flat_map(|(_, entries)| entries).collect();
            table.put(self.key, place, all);
        }
    }
}

impl DeckConverter {
    /// Reads all stops.
    pub(super) fn stops(&mut self) -> BodyEntries {
        let mut all = BodyEntries::new("stop");
        for record in self.take_records("CONSTRAINED_RIGID_BODY_STOPPERS") {
            let stops = self.stop(&record);
            all.add(record.integer("pid"), record.place("pid"), stops);
        }
        all
    }

    /// Reports entries of parts that are no rigid bodies.
    pub(super) fn entries_without_body(&mut self, entries: BodyEntries) {
        let known: Vec<String> = self.bodies.keys().map(i64::to_string).collect();
        for (pid, (place, _)) in entries.by_part {
            self.missing(place, "rigid part", pid, &known);
        }
    }

    /// Returns the entries of a card: one, or two if one bound is for the coordinate of the centre
    /// and the other for its displacement.
    fn stop(&mut self, record: &CardRecord) -> Vec<JobTable> {
        let direction = match record.integer("dir") {
            axis @ 1..=3 => [1, 2, 3].map(|c| if c == axis { 1.0 } else { 0.0 }),
            4 => {
                let lost = "the stop is left out: it does not bound the motion of the body";
                let (vid, place) = (record.integer("vid"), record.place("vid"));
                let Some(along) = self.vector(vid, place, lost) else { return Vec::new() };
                along
            }
            _ => {
                let why = "a stop of a rotation; use x, y, z or a vector (1 to 4), or the stop \
                           angles of a *CONSTRAINED_JOINT_STIFFNESS_GENERALIZED";
                self.unsupported_card(record, "dir", why);
                return Vec::new();
            }
        };
        let (birth, death) = (record.real("tb"), record.real("td"));
        let mut bounds: BTreeMap<bool, JobTable> = BTreeMap::new();
        for (field, key) in [("lcmin", "lower"), ("lcmax", "upper")] {
            let id = record.integer(field);
            if id == 0 {
                continue;
            }
            let place = record.place(field);
            let Some(curve) = self.time_curve(id.saturating_abs(), place) else { continue };
            let entry = bounds.entry(id > 0).or_insert_with(|| {
                let way = record.place("dir");
                let mut table = JobTable::new(record.head).with("direction", way, direction);
                if id > 0 {
                    table.put("position", place, true);
                }
                if birth > 0.0 {
                    table.put("birth", record.place("tb"), birth);
                }
                if death > 0.0 && death < self.end_time {
                    table.put("death", record.place("td"), death);
                }
                table
            });
            entry.put(key, place, curve);
        }
        if record.integer("lcmin") == 0 && record.integer("lcmax") == 0 {
            let message = format!("{}: it has no bound", record.name());
            let help = "it has no effect; give lcmax, lcmin, or both";
            self.trouble.warning(record.place("lcmax"), message, help);
        }
        bounds.into_values().collect()
    }
}
