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

impl UnusedValues {
    /// Returns true if the table ignores the fields of both for one reason.
    fn ignored_with(&self, other: &Self) -> bool {
        let fate =
            |of: &Self| of.record.row.unused(of.field).map(|unused| (unused.fate, unused.why));
        let own = fate(self).filter(|(fate, _)| *fate == FieldFate::Ignored);
        own.is_some() && own == fate(other) && self.record.name() == other.record.name()
    }
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
        for values in found.chunk_by(|a, b| a.ignored_with(b)) {
            match values {
                [one] => self.unused_values(one),
                all => self.ignored_values(all),
            }
        }
    }

    /// Reports ignored fields that the table has together, such as the components of an inertia.
    fn ignored_values(&mut self, all: &[UnusedValues]) {
        let Some(UnusedValues { record, field, first: (_, place), .. }) = all.first() else {
            return;
        };
        let values: Vec<String> =
            all.iter().map(|values| format!("`{}` = {}", values.field, values.first.0)).collect();
        let more = match all.iter().map(|values| values.count).max() {
            None | Some(1) => String::new(),
            Some(most) => format!(", and in up to {} more", most - 1),
        };
        let message = format!("{}: {} are ignored{more}", record.name(), values.join(", "));
        let why = record.row.unused(field).map_or("", |unused| unused.why);
        self.trouble.warning(*place, message, why);
    }

    fn unused_values(&mut self, values: &UnusedValues) {
        let UnusedValues { record, field, first: (value, place), count } = values;
        let more = match count {
            1 => String::new(),
            n => format!(", and {} more", n - 1),
        };
        let Some(unused) = record.row.unused(field) else {
            let message = format!("{}: `{field}` = {value} is not used{more}", record.name());
            let keyword = record.row.keyword.name;
            return self.trouble.warning(*place, message, void_by(keyword, field));
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

const NO_EXPONENT: &str = "it needs p, the exponent of the strain rate";
const NO_RATE: &str = "it needs c, the strain rate that the exponent p belongs to";

/// Fields that other fields of their card make void: the beginning of keywords, fields, and why.
const VOID: &[(&str, &str, &str)] = &[
    (
        "MAT_",
        "sigy etan",
        "the curve of eps and es, or of lcss, has their place: leave them blank, or leave the \
         curve out",
    ),
    ("MAT_", "eps es", "lcss has their place: leave them blank, or leave lcss out"),
    ("MAT_PIECEWISE", "c", NO_EXPONENT),
    ("MAT_PLASTICITY_WITH", "c", NO_EXPONENT),
    ("MAT_MODIFIED_PIECEWISE", "c", NO_EXPONENT),
    ("MAT_PIECEWISE", "p", NO_RATE),
    ("MAT_PLASTICITY_WITH", "p", NO_RATE),
    ("MAT_MODIFIED_PIECEWISE", "p", NO_RATE),
    ("MAT_", "src", "it needs srp, the exponent of the strain rate"),
    ("MAT_", "srp", "it needs src, the strain rate that it scales"),
    ("MAT_", "vp", "the material has no rates, so it does not matter how they act"),
    ("CONTACT_TIED", "fs fd dc vc", "tied nodes do not slide, so they have no friction"),
    ("CONTACT_SPOTWELD", "fs fd dc vc", "tied nodes do not slide, so they have no friction"),
    ("CONTACT_FORCE", "fs fd dc vc", "the card measures forces and has no contact of its own"),
    ("CONTACT_", "fd dc", "fs is 0 or refers to other friction, so nothing scales with the speed"),
    (
        "BOUNDARY_PRESCRIBED",
        "lcid sf dof vad",
        "the motion ends before the start of the run or begins after its end",
    ),
    ("/IMPVEL", "fct dir", "the motion begins after the end of the run"),
    ("/IMPDISP", "fct dir", "the motion begins after the end of the run"),
    ("/IMPACC", "fct dir", "the motion begins after the end of the run"),
];

/// Returns why a field that the conversion reads elsewhere has not been read.
fn void_by(keyword: &str, field: &str) -> &'static str {
    let is_meant = |(begin, fields, _): &&(&str, &str, &str)| {
        keyword.starts_with(begin) && fields.split_whitespace().any(|name| name == field)
    };
    match VOID.iter().find(is_meant) {
        Some((_, _, why)) => why,
        None => {
            "another field of the card makes it void; cases/DECKS.md and cases/RADIOSS.md say \
             what it is for"
        }
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
