//! The job's tree of values under construction.

use crate::input::job::tree::{Entry, Node, NodeContent, Place};
use std::collections::{BTreeMap, BTreeSet};

/// A table of the job: keys with values and their places in the deck.
#[derive(Debug)]
pub struct JobTable {
    entries: BTreeMap<String, Entry>,
    place: Place,
}

impl JobTable {
    /// Creates an empty table; `place` is that of the keyword.
    pub fn new(place: Place) -> Self {
        Self { entries: BTreeMap::new(), place }
    }

    /// Sets a value.
    pub fn put(&mut self, key: &str, place: Place, value: impl Into<NodeContent>) {
        let node = Node { kind: located(value.into(), place), place };
        self.entries.insert(key.into(), Entry { key: place, node });
    }

    /// Removes a value.
    pub fn remove(&mut self, key: &str) {
        self.entries.remove(key);
    }

    /// Sets a value and returns the table.
    pub fn with(mut self, key: &str, place: Place, value: impl Into<NodeContent>) -> Self {
        self.put(key, place, value);
        self
    }

    /// Returns a copy of the keys and values.
    pub fn copy(&self) -> Self {
        Self { entries: self.entries.clone(), place: self.place }
    }

    /// Returns the place of the keyword.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Returns the integers of a list; `None` without the list.
    pub fn integers(&self, key: &str) -> Option<Vec<i64>> {
        let NodeContent::Array(items) = &self.entries.get(key)?.node.kind else { return None };
        let number =
            |node: &Node| if let NodeContent::Integer(i) = node.kind { Some(i) } else { None };
        Some(items.iter().filter_map(number).collect())
    }

    /// Returns a number of the table; `None` without the key.
    pub fn float(&self, key: &str) -> Option<f64> {
        match self.entries.get(key)?.node.kind {
            NodeContent::Float(x) => Some(x),
            _ => None,
        }
    }

    /// Returns the place of a key; `None` without it.
    pub fn place_of(&self, key: &str) -> Option<Place> {
        Some(self.entries.get(key)?.key)
    }

    /// Returns true if the table has a key.
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Returns true if the table has no keys.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns true if the table has a key that begins so.
    pub fn has_start(&self, start: &str) -> bool {
        self.entries.keys().any(|key| key.starts_with(start))
    }

    fn into_node(self) -> Node {
        Node { kind: NodeContent::Table(self.entries), place: self.place }
    }
}

/// Assigns the place of a list to its items without a place.
fn located(kind: NodeContent, place: Place) -> NodeContent {
    match kind {
        NodeContent::Array(items) => {
            let item = |node: Node| match node.place {
                Place::Whole => Node { kind: located(node.kind, place), place },
                _ => node,
            };
            NodeContent::Array(items.into_iter().map(item).collect())
        }
        other => other,
    }
}

impl From<f64> for NodeContent {
    fn from(x: f64) -> Self {
        NodeContent::Float(x)
    }
}

impl From<i64> for NodeContent {
    fn from(i: i64) -> Self {
        NodeContent::Integer(i)
    }
}

impl From<bool> for NodeContent {
    fn from(b: bool) -> Self {
        NodeContent::Boolean(b)
    }
}

impl From<&str> for NodeContent {
    fn from(text: &str) -> Self {
        NodeContent::String(text.into())
    }
}

impl From<String> for NodeContent {
    fn from(text: String) -> Self {
        NodeContent::String(text)
    }
}

impl From<JobTable> for NodeContent {
    fn from(table: JobTable) -> Self {
        NodeContent::Table(table.entries)
    }
}

impl<T: Into<NodeContent>> From<Vec<T>> for NodeContent {
    fn from(items: Vec<T>) -> Self {
        NodeContent::Array(
            items.into_iter().map(|item| Node { kind: item.into(), place: Place::Whole }).collect(),
        )
    }
}

impl<T: Into<NodeContent>, const N: usize> From<[T; N]> for NodeContent {
    fn from(items: [T; N]) -> Self {
        Vec::from(items).into()
    }
}

/// The whole job.
#[derive(Debug, Default)]
pub struct Tree {
    root: BTreeMap<String, Entry>,
}

impl Tree {
    /// Adds an entry to a list such as `part`.
    pub fn add(&mut self, list: &str, entry: JobTable) {
        let empty = || Entry {
            key: Place::Whole,
            node: Node { kind: NodeContent::Array(Vec::new()), place: Place::Whole },
        };
        let found = self.root.entry(list.into()).or_insert_with(empty);
        if let NodeContent::Array(items) = &mut found.node.kind {
            items.push(entry.into_node());
        }
    }

    /// Returns the keys of an entry of `part` by the id of the part.
    pub fn part(&mut self, id: i64) -> Option<&mut BTreeMap<String, Entry>> {
        let parts = &mut self.root.get_mut("part")?.node.kind;
        let NodeContent::Array(items) = parts else { return None };
        items.iter_mut().find_map(|item| {
            let NodeContent::Table(keys) = &mut item.kind else { return None };
            let is_it = matches!(keys.get("id")?.node.kind, NodeContent::Integer(i) if i == id);
            is_it.then_some(keys)
        })
    }

    /// Sets a key of the top level.
    pub fn set(&mut self, key: &str, place: Place, value: impl Into<NodeContent>) {
        let node = Node { kind: located(value.into(), place), place };
        self.root.insert(key.into(), Entry { key: place, node });
    }

    /// Sets a key of a table such as `time`.
    pub fn set_in(&mut self, table: &str, key: &str, place: Place, value: impl Into<NodeContent>) {
        let fresh = || Entry { key: place, node: Node::table(place) };
        let found = self.root.entry(table.into()).or_insert_with(fresh);
        if let NodeContent::Table(entries) = &mut found.node.kind {
            let node = Node { kind: located(value.into(), place), place };
            entries.insert(key.into(), Entry { key: place, node });
        }
    }

    /// Removes the entries of all lists whose node set is one of these, or only their set if they
    /// have parts as well. Returns the names of their lists with their places, and the names of
    /// rigid bodies among them.
    pub fn remove_entries_of(
        &mut self,
        sets: &BTreeSet<String>,
    ) -> (Vec<(String, Place)>, BTreeSet<String>) {
        let mut removed = Vec::new();
        let before = self.bodies();
        for (name, entry) in &mut self.root {
            let mut places = Vec::new();
            remove_of(&mut entry.node, sets, &mut places);
            removed.extend(places.into_iter().map(|place| (name.clone(), place)));
        }
        (removed, &before - &self.bodies())
    }

    /// Returns the names of all rigid bodies.
    fn bodies(&self) -> BTreeSet<String> {
        let list = self.root.get("rigid").map(|entry| &entry.node.kind);
        let Some(NodeContent::Array(items)) = list else { return BTreeSet::new() };
        let name = |item: &Node| match &item.kind {
            NodeContent::Table(keys) => Some(text(&keys.get("name")?.node)?.to_string()),
            _ => None,
        };
        items.iter().filter_map(name).collect()
    }

    /// Removes the entries of all lists, such as motions and joints, that refer to one of these
    /// rigid bodies. Returns their places with its name.
    pub fn remove_entries_on(&mut self, bodies: &BTreeSet<String>) -> Vec<(Place, String)> {
        let mut found = Vec::new();
        for entry in self.root.values_mut() {
            let NodeContent::Array(items) = &mut entry.node.kind else { continue };
            items.retain(|item| {
                let name = bodies_of(item).find(|name| bodies.contains(*name));
                found.extend(name.map(|name| (item.place, name.to_string())));
                name.is_none()
            });
        }
        found
    }

    /// Returns the tree.
    pub fn into_node(self) -> Node {
        Node { kind: NodeContent::Table(self.root), place: Place::Whole }
    }
}

/// Returns the text of a node; `None` for another kind of node.
fn text(node: &Node) -> Option<&str> {
    if let NodeContent::String(text) = &node.kind { Some(text) } else { None }
}

/// Returns the names of the rigid bodies that an entry refers to.
fn bodies_of(item: &Node) -> impl Iterator<Item = &str> {
    let of = |key: &str| match &item.kind {
        NodeContent::Table(keys) => keys.get(key).map(|entry| &entry.node),
        _ => None,
    };
    let pair: &[Node] = match of("bodies").map(|node| &node.kind) {
        Some(NodeContent::Array(pair)) => pair,
        _ => &[],
    };
    of("rigid").into_iter().chain(pair).filter_map(text)
}

/// Removes the entries below a node whose node set is one of these, see
/// [`Tree::remove_entries_of`].
fn remove_of(node: &mut Node, sets: &BTreeSet<String>, places: &mut Vec<Place>) {
    match &mut node.kind {
        NodeContent::Table(keys) => {
            keys.values_mut().for_each(|entry| remove_of(&mut entry.node, sets, places));
        }
        NodeContent::Array(items) => items.retain_mut(|item| {
            remove_of(item, sets, places);
            let NodeContent::Table(keys) = &mut item.kind else { return true };
            let set = keys.get("nodes").map(|entry| &entry.node.kind);
            if !matches!(set, Some(NodeContent::String(name)) if sets.contains(name)) {
                return true;
            }
            places.push(item.place);
            keys.remove("nodes");
            keys.contains_key("parts")
        }),
        _ => {}
    }
}
