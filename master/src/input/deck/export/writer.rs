//! The text of a deck under construction: fields, parameters, sets, comments with keys of the job,
//! and an account of what has no card.

use crate::input::deck::number::shortest;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Columns per field.
const WIDTH: usize = 20;

/// Why a deck has something in a comment, or not at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::input::deck) enum LeftReason {
    /// There is no card for it.
    NoCard,
    /// A card has it with fewer digits, or in another form.
    Digits,
    /// The deck does not have it.
    Lost,
}

/// A deck under construction.
#[derive(Default)]
pub(in crate::input::deck) struct DeckWriter {
    /// Its cards.
    pub(in crate::input::deck) body: String,
    /// Numbers that are longer than a field.
    pub(super) parameters: Vec<f64>,
    /// Keys without a card.
    pub(in crate::input::deck) rest: Table,
    /// How many entries of each kind are not on cards alone.
    pub(super) left: BTreeMap<(String, LeftReason), usize>,
    /// Number of curves so far.
    pub(super) curves: u64,
    /// Largest id of a contact so far; ties and transducers are contacts, too.
    pub(super) contacts: u64,
    /// Number of sets of parts so far.
    pub(super) part_sets: u64,
    /// Number of sets of segments so far.
    pub(super) segment_sets: u64,
    /// Largest id of a set of nodes so far.
    pub(super) last_node_set: u64,
    /// Ids of sets of nodes so far.
    pub(super) node_set_ids: BTreeMap<Vec<u64>, u64>,
    /// Largest id of a system of axes so far.
    pub(super) systems: u64,
    /// Largest id of a node so far.
    pub(super) last_node: u64,
}

impl DeckWriter {
    pub(super) fn keyword(&mut self, name: &str) {
        self.body += &format!("*{name}\n");
    }

    /// Writes a line.
    pub(in crate::input::deck) fn text(&mut self, line: &str) {
        self.body += line;
        self.body.push('\n');
    }

    pub(super) fn card(&mut self, fields: &[CardValue]) {
        for field in fields {
            let text = match field {
                CardValue::Blank => String::new(),
                CardValue::Id(id) => id.to_string(),
                CardValue::Number(x) => self.number(*x),
            };
            self.body += &format!("{text:>WIDTH$}");
        }
        self.body.truncate(self.body.trim_end_matches(' ').len());
        self.body.push('\n');
    }

    /// Writes a card of words.
    pub(super) fn words(&mut self, words: &[&str]) {
        words.iter().for_each(|word| self.body += &format!("{word:>WIDTH$}"));
        self.body.push('\n');
    }

    /// Returns a number for a field, with all its digits.
    pub(super) fn number(&mut self, x: f64) -> String {
        shortest(x, WIDTH).unwrap_or_else(|| {
            let known = self.parameters.iter().position(|p| p.to_bits() == x.to_bits());
            let at = known.unwrap_or_else(|| {
                self.parameters.push(x);
                self.parameters.len() - 1
            });
            format!("&x{}", at + 1)
        })
    }

    /// Adds an entry to a list of keys without a card.
    pub(in crate::input::deck) fn entry(&mut self, list: &str, entry: Table) {
        self.note_leaves(list, &entry, LeftReason::NoCard);
        self.comment(list, entry);
    }

    /// Adds an entry with values that a card has with fewer digits, or in another form.
    pub(super) fn digits(&mut self, list: &str, entry: Table) {
        self.note_leaves(list, &entry, LeftReason::Digits);
        self.comment(list, entry);
    }

    /// Adds an entry that has no card at all.
    pub(super) fn whole(&mut self, list: &str, entry: Table) {
        self.note(list, LeftReason::NoCard, 1);
        self.comment(list, entry);
    }

    /// Counts entries of a kind that are not on cards alone.
    pub(super) fn note(&mut self, what: &str, reason: LeftReason, count: usize) {
        *self.left.entry((what.into(), reason)).or_default() += count;
    }

    /// Counts the keys of a table, without those that only name an entry.
    pub(super) fn note_leaves(&mut self, path: &str, table: &Table, reason: LeftReason) {
        for (key, value) in table.iter().filter(|(key, _)| !["name", "id"].contains(&key.as_str()))
        {
            let inner = format!("{path}.{key}");
            match value {
                Value::Table(inner_table) => self.note_leaves(&inner, inner_table, reason),
                Value::Array(items) if items.iter().any(Value::is_table) => {
                    let tables = items.iter().filter_map(Value::as_table);
                    tables.for_each(|table| self.note_leaves(&inner, table, reason));
                }
                _ => self.note(&inner, reason, 1),
            }
        }
    }

    /// Returns a line for each kind of entries that are not on cards alone.
    pub(super) fn left(&self) -> Vec<String> {
        let line = |((what, reason), count): (&(String, LeftReason), &usize)| match reason {
            LeftReason::NoCard => format!("{what}: no card for {count}"),
            LeftReason::Digits => format!("{what}: the cards do not hold all digits of {count}"),
            LeftReason::Lost => format!("{what}: {count} are not in the deck"),
        };
        self.left.iter().map(line).collect()
    }

    /// Adds an entry that is counted elsewhere.
    pub(super) fn comment(&mut self, list: &str, entry: Table) {
        let lists = self.rest.entry(list).or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(items) = lists {
            items.push(Value::Table(entry));
        }
    }

    /// Writes a card with an id and a name.
    pub(super) fn named_card(&mut self, id: u64, name: &str) {
        self.body += &format!("{id:>WIDTH$}{name}\n");
    }

    /// Writes a set of parts, and returns its id.
    pub(super) fn part_set(&mut self, parts: &[u32]) -> u64 {
        self.part_sets += 1;
        let id = self.part_sets;
        self.keyword("SET_PART_LIST");
        self.card(&[Id(id)]);
        let parts: Vec<CardValue> = parts.iter().map(|&p| Id(u64::from(p))).collect();
        parts.chunks(8).for_each(|eight| self.card(eight));
        id
    }

    /// Writes a set of nodes if no set has the same ones, and returns its id.
    pub(super) fn node_set(&mut self, nodes: &[u64]) -> u64 {
        if let Some(&id) = self.node_set_ids.get(nodes) {
            return id;
        }
        self.last_node_set += 1;
        self.node_set_with_id(self.last_node_set, nodes)
    }

    /// Writes a set of nodes with this id, and returns the id.
    pub(super) fn node_set_with_id(&mut self, id: u64, nodes: &[u64]) -> u64 {
        self.node_set_ids.insert(nodes.to_vec(), id);
        self.keyword("SET_NODE_LIST");
        self.card(&[Id(id)]);
        let nodes: Vec<CardValue> = nodes.iter().map(|&n| Id(n)).collect();
        nodes.chunks(8).for_each(|eight| self.card(eight));
        id
    }

    /// Returns the text of the deck of a job with this name.
    pub(super) fn finish(self, job: &str) -> String {
        let mut head = format!(
            "*KEYWORD LONG=Y\n$ {} as a deck, by crumple {}\n",
            line(job),
            env!("CARGO_PKG_VERSION")
        );
        if !self.rest.is_empty() {
            head += "$ keys without a card, read by crumple only:\n";
            let text = toml::to_string(&self.rest).expect("tables of a job are TOML");
            text.lines().for_each(|l| head += &format!("$crumple: {l}\n"));
        }
        if !self.parameters.is_empty() {
            head += "*PARAMETER_EXPRESSION\n";
            self.parameters
                .iter()
                .enumerate()
                .for_each(|(i, x)| head += &format!("R x{},{x:e}\n", i + 1));
        }
        head + &self.body + "*END\n"
    }
}

/// A field of a card.
#[derive(Clone, Copy)]
pub(super) enum CardValue {
    /// Blank columns.
    Blank,
    /// A whole number.
    Id(u64),
    /// A number.
    Number(f64),
}

use CardValue::{Id, Number};

/// Returns the text on one line.
pub(in crate::input::deck) fn line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect::<String>()
        .trim()
        .to_string()
}

/// Returns a value of a job as TOML.
///
/// # Panics
/// If TOML has no such value. All values of a job were read from TOML.
pub(in crate::input::deck) fn value_of(value: &impl Serialize) -> Value {
    Value::try_from(value).expect("values of a job are TOML")
}

/// Returns an entry of a job as a table.
///
/// # Panics
/// If it is none. All entries of a job were read from tables.
pub(in crate::input::deck) fn table_of(entry: &impl Serialize) -> Table {
    let Value::Table(table) = value_of(entry) else { panic!("an entry of a job is a table") };
    table
}

/// Returns the id in a name of the form `start` and id, which a reader gives a curve or a set.
pub(super) fn id_in_name(start: &str, name: &str) -> Option<u64> {
    let id = u64::from(name.strip_prefix(start)?.parse::<u32>().ok()?);
    (id > 0 && format!("{start}{id}") == name).then_some(id)
}

/// Returns a name for each entry, as on a card of a contact: the given one, or `kind` and its
/// number if it is empty. If two are equal, all get numbers, with another kind than any given name.
pub(super) fn unique_names<'n>(kind: &str, given: impl Iterator<Item = &'n str>) -> Vec<String> {
    /// Longest name on a card.
    const LONGEST: usize = 70;
    let given: Vec<&str> = given.collect();
    let name = |(number, given): (usize, &&str)| {
        let name: String = line(given).chars().take(LONGEST).collect();
        if name.is_empty() { format!("{kind} {number}") } else { name }
    };
    let names: Vec<String> = (1..).zip(&given).map(name).collect();
    let are_unique = names.iter().collect::<BTreeSet<_>>().len() == names.len();
    if are_unique {
        return names;
    }
    let mut kind = kind.to_string();
    while given.iter().any(|name| name.starts_with(&kind)) {
        kind.push('+');
    }
    (1..=names.len()).map(|number| format!("{kind} {number}")).collect()
}

/// Returns a name as the entry of a table.
pub(in crate::input::deck) fn named(name: &str) -> (String, Value) {
    ("name".into(), name.into())
}

/// Writes a curve through these points, and returns its id, which no other curve has.
pub(super) fn points(deck: &mut DeckWriter, pairs: &[[f64; 2]]) -> u64 {
    deck.curves += 1;
    points_with_id(deck, deck.curves, pairs)
}

/// Writes a curve with this id through these points, and returns the id.
pub(super) fn points_with_id(deck: &mut DeckWriter, id: u64, pairs: &[[f64; 2]]) -> u64 {
    deck.keyword("DEFINE_CURVE");
    deck.card(&[Id(id)]);
    pairs.iter().for_each(|p| deck.card(&p.map(Number)));
    id
}

/// Returns a number whose product with `divisor` is exactly `product`.
pub(super) fn exact_quotient(product: f64, divisor: f64) -> Option<f64> {
    let nearest = product / divisor;
    let near = [nearest, nearest.next_up(), nearest.next_down()];
    near.into_iter().find(|x| divisor * x == product)
}
