//! Names of the entities of a deck in the job.

use crate::input::deck::record::CardRecord;

/// Returns a name for each record: its heading, or `kind` with its id, or with its number in the
/// list if it has no id. `fields` are those of the heading and of the id. Equal names get the
/// number as well.
pub fn names<'a>(
    records: impl IntoIterator<Item = &'a CardRecord>,
    kind: &str,
    fields: [&str; 2],
) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (record, number) in records.into_iter().zip(1..) {
        let mut name = match (record.word(fields[0]).trim(), record.integer(fields[1])) {
            ("", 0) => format!("{kind}{number}"),
            ("", id) => format!("{kind}{id}"),
            (heading, _) => heading.to_string(),
        };
        if names.contains(&name) {
            name += &format!(" ({number})");
        }
        names.push(name);
    }
    names
}
