//! Writes what has no card after `$crumple:`, and counts it.

use super::{DeckWriter, LeftReason, TimeCurves, table_of};
use crumple_proto::job::{Checkpoint, Elements, Job, Output, Parallel, Restart, Time};
use serde::Serialize;
use toml::{Table, Value};

/// Lists of `[output]` that cards hold.
const HISTORIES: [&str; 3] = ["node", "section", "transducer"];

/// Writes the settings without cards, if they are not the defaults, and lists that are never
/// written as cards.
pub fn write(deck: &mut DeckWriter, job: &Job, curves: &mut TimeCurves<'_>) {
    if !job.units.is_empty() {
        deck.note("units", LeftReason::NoCard, 1);
        deck.rest.insert("units".into(), job.units.clone().into());
    }
    let carried = ["safety", "max_cycles", "dt_min_ratio", "mass_scaling_dt", "damping", "dt_max"];
    differing(deck, "time", &job.time, &Time::default(), &carried);
    // Cards allow only intervals above zero.
    let intervals = [
        ("history_interval", job.output.history_interval),
        ("field_interval", job.output.field_interval),
    ];
    let carried = intervals.into_iter().filter(|i| i.1 > 0.0).map(|i| i.0);
    let carried: Vec<&str> = carried.chain(HISTORIES).collect();
    differing(deck, "output", &job.output, &Output::default(), &carried);
    differing(deck, "parallel", &job.parallel, &Parallel::default(), &[]);
    differing(deck, "elements", &job.elements, &Elements::default(), &[]);
    differing(deck, "checkpoint", &job.checkpoint, &Checkpoint::default(), &[]);
    differing(deck, "restart", &job.restart, &Restart::default(), &[]);
    // The reader of cards removes the limit if a deck asks for mass scaling.
    if job.time.mass_scaling_dt > 0.0 {
        let limit = Table::from_iter([(
            "mass_scaling_limit".to_string(),
            Value::from(job.time.mass_scaling_limit),
        )]);
        deck.note_leaves("time", &limit, LeftReason::NoCard);
        let time = deck.rest.entry("time").or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(time) = time {
            time.extend(limit);
        }
    }
    list(deck, "require", &job.require);
    if !job.placeholders.is_empty() {
        deck.note("placeholders", LeftReason::Lost, job.placeholders.len());
    }
    // Entries without cards refer to curves by their names.
    let referring = ["gravity", "pressure", "airbag", "load", "motion", "wall"];
    if referring.iter().any(|key| deck.rest.contains_key(*key)) {
        for curve in &job.curve {
            curves.write_table(deck, Some(&curve.name));
        }
    }
}

/// Writes a whole list without cards.
pub(in crate::input::deck) fn list(deck: &mut DeckWriter, name: &str, entries: &[impl Serialize]) {
    for entry in entries {
        deck.whole(name, table_of(entry));
    }
}

/// Adds the keys of a table that differ from the defaults, without those on cards.
pub(in crate::input::deck) fn differing<T: Serialize>(
    deck: &mut DeckWriter,
    name: &str,
    own: &T,
    default: &T,
    carried: &[&str],
) {
    let keys = difference(own, default, carried);
    if !keys.is_empty() {
        deck.note_leaves(name, &keys, LeftReason::NoCard);
        let table = deck.rest.entry(name).or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(table) = table {
            table.extend(keys);
        }
    }
}

/// Returns the keys of a table that differ from those of another one, without those on cards.
pub(super) fn difference<T: Serialize>(own: &T, default: &T, carried: &[&str]) -> Table {
    let default = table_of(default);
    let keys = table_of(own)
        .into_iter()
        .filter(|(key, value)| default.get(key) != Some(value) && !carried.contains(&key.as_str()));
    keys.collect()
}
