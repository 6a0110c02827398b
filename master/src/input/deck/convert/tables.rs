//! Converts `*DEFINE_TABLE` and `*DEFINE_TABLE_2D` (LS-DYNA Keyword User's Manual, vol. I): curves
//! at ascending values.

use super::DeckConverter;
use super::curves::one;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;

/// A table, with the scale and the offset of its values applied.
#[derive(Clone, Debug)]
pub struct DeckTable {
    /// Value and the id of its curve, ascending by value.
    rows: Vec<(f64, i64)>,
    /// Place of the keyword.
    place: Place,
}

impl DeckConverter {
    /// Reads all tables; the curves must have been read.
    pub(super) fn tables(&mut self) {
        for keyword in ["DEFINE_TABLE", "DEFINE_TABLE_2D"] {
            for record in self.take_records(keyword) {
                self.table(keyword, &record);
            }
        }
    }

    fn table(&mut self, keyword: &str, record: &CardRecord) {
        let (id, place) = (record.integer("tbid"), record.place("tbid"));
        let (scale, offset) = (one(record.real("sfa")), record.real("offa"));
        let lines: Vec<_> = record.lines("value").collect();
        let value =
            |line: &crate::input::deck::record::CardLine| scale * (line.real("value") + offset);
        let values: Vec<f64> = lines.iter().map(|line| value(line)).collect();
        if values.is_empty() || values.windows(2).any(|two| two[0] >= two[1]) {
            let message = format!("the values of *{keyword} {id} do not ascend: {values:?}");
            let help = "give at least one value, one per line, each larger than the one before";
            self.trouble.error(place, message, help);
            return;
        }
        let ids: Vec<i64> = if keyword == "DEFINE_TABLE_2D" {
            lines.iter().map(|line| line.integer("curveid")).collect()
        } else {
            self.curves_after(place).into_iter().take(values.len()).collect()
        };
        if ids.len() < values.len() {
            let message = format!(
                "{} values of *{keyword} {id}, but {} *DEFINE_CURVE follow it",
                values.len(),
                ids.len()
            );
            let help = "put a curve for each value after the table, in the order of the values; or \
                        use *DEFINE_TABLE_2D with the ids of the curves";
            self.trouble.error(place, message, help);
            return;
        }
        let rows = values.into_iter().zip(ids).collect();
        if self.tables.insert(id, DeckTable { rows, place }).is_some() {
            let message = format!("there are two tables with the id {id}");
            self.trouble.error(place, message, "give each a different id");
        }
    }

    /// Returns the ids of the curves that follow `place` in its file, in their order there.
    fn curves_after(&self, place: Place) -> Vec<i64> {
        let Place::Deck { file: here, start: from, .. } = place else { return Vec::new() };
        let start = |curve: Place| match curve {
            Place::Deck { file, start, .. } if file == here && start > from => Some(start),
            _ => None,
        };
        let after = self.curves.iter().filter_map(|(&id, c)| Some((start(c.place)?, id)));
        let mut after: Vec<(u32, i64)> = after.collect();
        after.sort_unstable();
        after.into_iter().map(|(_, id)| id).collect()
    }

    /// Returns the rows [value, abscissa, ordinate] of a table by its id, ascending. Reports an
    /// error at `place`, or at the table, if the table or one of its curves is missing.
    pub(super) fn table_rows(&mut self, id: i64, place: Place) -> Option<Vec<Vec<f64>>> {
        let Some(table) = self.tables.get(&id).cloned() else {
            let known: Vec<String> = self.tables.keys().map(i64::to_string).collect();
            self.missing(place, "*DEFINE_TABLE", id, &known);
            return None;
        };
        let mut rows = Vec::new();
        for (value, curve) in table.rows {
            let points = self.curve(curve, table.place)?.points;
            rows.extend(points.iter().map(|&[x, y]| vec![value, x, y]));
        }
        Some(rows)
    }
}
