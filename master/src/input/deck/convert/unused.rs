//! Reports fields with a value that does not reach the job: fields for which the table of keywords
//! has a fate, and fields for which no code has asked.

use super::DeckConverter;
use crate::input::deck::record::{CardLine, CardRecord, Given, Value};
use crate::input::deck::table::{Field, FieldFate};
use crate::input::job::tree::Place;
use std::collections::{BTreeSet, HashMap};

/// Values of one field of one keyword that do not reach the job.
struct UnusedValues {
    record: CardRecord,
    field: &'static str,
    /// Content and place of the first one.
    first: (String, Place),
    count: usize,
}

impl DeckConverter {
    /// Reports values that do not reach the job, once for each field of a keyword.
    pub(super) fn unused_fields(&mut self) {
        let mut found: Vec<UnusedValues> = Vec::new();
        let mut index: HashMap<(&'static str, &'static str), usize> = HashMap::new();
        let records = std::mem::take(&mut self.read);
        let problems = self.places_of_problems();
        let complete = !self.trouble.has_errors();
        for record in &records {
            // The code stops at a problem, and it does not ask for cards without a reference.
            let asked: u32 = record.all_lines().iter().map(CardLine::asked).sum();
            let whole = complete && asked > 1 && !is_reported(record, &problems);
            for (line, (field, value, asked)) in given(record) {
                let has_fate = record.row.unused(&field.name).is_some();
                if !has_fate && (asked || !whole) {
                    continue;
                }
                let key = (record.row.keyword.name, field.name.as_str());
                match index.get(&key) {
                    Some(&at) => found[at].count += 1,
                    None => {
                        index.insert(key, found.len());
                        let first = (text(&value.given), line.place(&field.name));
                        let record = record.clone();
                        found.push(UnusedValues { record, field: &field.name, first, count: 1 });
                    }
                }
            }
        }
        found.into_iter().for_each(|values| self.unused_values(&values));
    }

    fn unused_values(&mut self, values: &UnusedValues) {
        let UnusedValues { record, field, first: (value, place), count } = values;
        let more = match count {
            1 => String::new(),
            n => format!(", and {} more", n - 1),
        };
        let Some(unused) = record.row.unused(field) else {
            let message = format!("{}: `{field}` = {value} is not used{more}", record.name());
            let help = "other fields of the card make it void, or it has no counterpart here";
            return self.trouble.warning(*place, message, help);
        };
        match unused.fate {
            FieldFate::NoEffect => self.map(
                record.name(),
                format!("{field} {value}{more}"),
                format!("not used: {}", unused.why),
            ),
            FieldFate::Ignored => {
                let message = format!("{}: `{field}` = {value} is ignored{more}", record.name());
                self.trouble.warning(*place, message, unused.why);
            }
            FieldFate::Refused => {
                let message = format!(
                    "{}: `{field}` = {value} is not supported{more}: {}",
                    record.name(),
                    unused.why
                );
                self.unsupported(*place, message, format!("{} {field}", record.name()));
            }
        }
    }

    /// Returns file and first byte of everything that was reported so far.
    fn places_of_problems(&self) -> BTreeSet<(u32, u32)> {
        let unsupported = self.unsupported.iter().map(|u| u.place);
        let position = |place: Place| match place {
            Place::Deck { file, start, .. } => Some((file, start)),
            _ => None,
        };
        self.trouble.places().chain(unsupported).filter_map(position).collect()
    }
}

/// Returns all fields with a value, and their lines.
fn given(record: &CardRecord) -> impl Iterator<Item = (&CardLine, (&'static Field, &Value, bool))> {
    record.all_lines().iter().flat_map(|line| line.given().map(move |given| (line, given)))
}

/// Returns true if a problem was reported within a record or at its keyword.
fn is_reported(record: &CardRecord, problems: &BTreeSet<(u32, u32)>) -> bool {
    let start = |place: Place| match place {
        Place::Deck { file, start, .. } => Some((file, start)),
        _ => None,
    };
    let lines = record.all_lines();
    let ends = (lines.first().map(|l| l.place), lines.last().map(|l| l.place));
    let within = match ends {
        (Some(first), Some(Place::Deck { file, end, .. })) => start(first)
            .is_some_and(|first| problems.range(first..=(file, end).max(first)).next().is_some()),
        _ => false,
    };
    within || start(record.head).is_some_and(|head| problems.contains(&head))
}

fn text(given: &Given) -> String {
    match given {
        Given::Integer(i) => i.to_string(),
        Given::Real(x) => x.to_string(),
        Given::Word(word) => word.clone(),
        Given::Blank | Given::Wrong => String::new(),
    }
}
