//! Writes what has no card after `$crumple:`, and counts it.

use super::{DeckWriter, LeftReason, TimeCurves, table_of};
use crate::input::deck::convert::units::stated;
use crumple_proto::job::{Checkpoint, Elements, Job, Output, Parallel, Restart, Time};
use serde::Serialize;
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Lists of `[output]` that cards hold.
const HISTORIES: [&str; 3] = ["node", "section", "transducer"];

/// Interval of fields that a reader gives a job with times alone.
const ONLY_TIMES: f64 = -1.0;
/// Largest number of times of fields by their interval on a curve.
const MOST_TIMES: f64 = 2000.0;

/// Writes the settings without cards, if they are not the defaults, and lists that are never
/// written as cards.
pub fn write(deck: &mut DeckWriter, job: &Job, curves: &mut TimeCurves<'_>) {
    if !job.units.is_empty() && stated(&job.units).is_none() {
        deck.note("units", LeftReason::NoCard, 1);
        deck.rest.insert("units".into(), job.units.clone().into());
    }
    let carried = [
        "safety",
        "max_cycles",
        "dt_min_ratio",
        "mass_scaling_dt",
        "damping",
        "damping_curve",
        "dt_max",
    ];
    differing(deck, "time", &job.time, &Time::default(), &carried);
    // Cards allow only intervals above zero.
    let output = &job.output;
    let only_times = output.field_interval == ONLY_TIMES && times_of_fields(job).is_some();
    let is_carried = [
        ("history_interval", output.history_interval > 0.0),
        ("field_interval", output.field_interval > 0.0 || only_times),
        ("field_times", only_times),
        ("strains", true),
    ];
    let carried = is_carried.into_iter().filter(|key| key.1).map(|key| key.0);
    let carried: Vec<&str> = carried.chain(HISTORIES).collect();
    differing(deck, "output", &job.output, &Output::default(), &carried);
    differing(deck, "parallel", &job.parallel, &Parallel::default(), &[]);
    differing(deck, "elements", &job.elements, &Elements::default(), &[]);
    differing(deck, "checkpoint", &job.checkpoint, &Checkpoint::default(), &[]);
    adaptivity(deck, job);
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
    list(deck, "non_reflecting", &job.non_reflecting);
    list(deck, "failure_group", &job.failure_group);
    list(deck, "require", &job.require);
    if !job.placeholders.is_empty() {
        deck.note("placeholders", LeftReason::Lost, job.placeholders.len());
    }
    // Entries without cards refer to curves by their names.
    let mut texts = BTreeSet::new();
    deck.rest.values().for_each(|entries| add_texts(entries, &mut texts));
    for curve in job.curve.iter().filter(|curve| texts.contains(&curve.name)) {
        curves.write_table(deck, Some(&curve.name));
    }
}

/// Adds all texts in a value.
pub(super) fn add_texts(value: &Value, texts: &mut BTreeSet<String>) {
    match value {
        Value::String(text) => drop(texts.insert(text.clone())),
        Value::Array(items) => items.iter().for_each(|item| add_texts(item, texts)),
        Value::Table(table) => table.values().for_each(|item| add_texts(item, texts)),
        _ => {}
    }
}

/// Returns the times of all fields for a curve, in ascending order; `None` if an interval is enough
/// or if there are too many. Other programs take no interval together with a curve, so that it has
/// the times of both: Crumple reads the additional ones from the comments.
pub(super) fn times_of_fields(job: &Job) -> Option<Vec<f64>> {
    let output = &job.output;
    let mut times = output.field_times.clone();
    if times.is_empty() || output.field_interval == 0.0 {
        return None;
    }
    if output.field_interval > 0.0 {
        let count = job.end_time / output.field_interval;
        if count > MOST_TIMES {
            return None;
        }
        times.extend((0..=count as u32).map(|n| f64::from(n) * output.field_interval));
    }
    let is_ordered = output.field_times.is_sorted();
    let within = output.field_times.iter().all(|t| (0.0..=job.end_time).contains(t));
    times.sort_by(f64::total_cmp);
    times.dedup();
    (is_ordered && within).then_some(times)
}

/// Writes `[adaptivity]`, if the job has it.
pub(in crate::input::deck) fn adaptivity(deck: &mut DeckWriter, job: &Job) {
    if let Some(given) = &job.adaptivity {
        let table = table_of(given);
        deck.note_leaves("adaptivity", &table, LeftReason::NoCard);
        deck.rest.insert("adaptivity".into(), Value::Table(table));
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
