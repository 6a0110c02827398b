//! Names of the entities of a deck in the job.

use crate::input::deck::record::CardRecord;
use std::collections::HashSet;

/// Returns a name for each record: its heading, or `kind` with its id, or with its number in the
/// list if it has no id. `fields` are those of the heading and of the id. Equal names get the
/// number as well.
pub fn names<'a>(
    records: impl IntoIterator<Item = &'a CardRecord>,
    kind: &str,
    fields: [&str; 2],
) -> Vec<String> {
    let mut taken = HashSet::new();
    let name = |(record, number): (&CardRecord, i64)| {
        let name = match (record.word(fields[0]).trim(), record.integer(fields[1])) {
            ("", 0) => format!("{kind}{number}"),
            ("", id) => format!("{kind}{id}"),
            (heading, _) => heading.to_string(),
        };
        unique(name, number, &mut taken)
    };
    records.into_iter().zip(1..).map(name).collect()
}

/// Returns a name that is not yet taken, with a number as well if it was, and takes it.
pub fn unique(mut name: String, number: i64, taken: &mut HashSet<String>) -> String {
    while taken.contains(&name) {
        name += &format!(" ({number})");
    }
    taken.insert(name.clone());
    name
}
