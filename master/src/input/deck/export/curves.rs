//! Writes factors over time as curves. Without a curve in the job the factor is 1, for which a
//! deck needs a curve too. A curve that a reader has named by its id keeps this id, so that curves
//! do not become more with each export.

use super::{DeckWriter, id_in_name, named, points, points_with_id};
use crumple_proto::job::Job;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Name of the curve for the factor 1.
const CONSTANT: &str = "constant factor of 1";

/// Curves of a job that have been written to the deck.
pub struct TimeCurves<'j> {
    job: &'j Job,
    ids: BTreeMap<Option<String>, u64>,
    tables: Vec<String>,
}

impl<'j> TimeCurves<'j> {
    /// Starts without curves.
    pub fn new(job: &'j Job) -> Self {
        Self { job, ids: BTreeMap::new(), tables: Vec::new() }
    }

    fn points(&self, name: Option<&str>) -> Vec<[f64; 2]> {
        let found = name.and_then(|name| self.job.curve.iter().find(|c| c.name == name));
        // The curve extends beyond the end of the run, so that it covers all times.
        found.map_or(vec![[0.0, 1.0], [2.0 * self.job.end_time, 1.0]], |c| c.points.clone())
    }

    /// Returns the id of a curve, which is written at its first use. Must not be called between a
    /// keyword and its cards.
    pub fn id(&mut self, deck: &mut DeckWriter, name: Option<&str>) -> u64 {
        let key = name.map(String::from);
        if let Some(&id) = self.ids.get(&key) {
            return id;
        }
        let pairs = self.points(name);
        let id = match name.and_then(own_id) {
            Some(id) => points_with_id(deck, id, &pairs),
            None => points(deck, &pairs),
        };
        self.ids.insert(key, id);
        id
    }

    /// Writes the curve times a number, and returns its id.
    pub fn scaled(&self, deck: &mut DeckWriter, name: Option<&str>, scale: f64) -> u64 {
        let points_of: Vec<[f64; 2]> =
            self.points(name).iter().map(|p| [p[0], scale * p[1]]).collect();
        points(deck, &points_of)
    }

    /// Writes the curve after `$crumple:` too, unless a reader has it under its name by its card.
    /// Returns its name there.
    pub fn write_table(&mut self, deck: &mut DeckWriter, name: Option<&str>) -> String {
        let known = name.unwrap_or(CONSTANT).to_string();
        let is_on_card = own_id(&known).is_some() && self.ids.contains_key(&name.map(String::from));
        if !is_on_card && !self.tables.contains(&known) {
            let rows =
                self.points(name).into_iter().map(|p| Value::from(p.to_vec())).collect::<Vec<_>>();
            deck.comment(
                "curve",
                Table::from_iter([named(&known), ("points".into(), Value::from(rows))]),
            );
            self.tables.push(known.clone());
        }
        known
    }
}

/// Returns the id of a curve that a reader has named by it.
fn own_id(name: &str) -> Option<u64> {
    id_in_name("curve-", name)
}
