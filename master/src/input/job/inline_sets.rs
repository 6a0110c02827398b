//! Rules of node sets in the place of their name: `nodes = { rule = "plane", ... }`.
//!
//! Each rule becomes an entry of `[[set]]` before the keys are checked. Its name is the path of the
//! key, such as `fix.0.nodes`, unless it has one.

use super::node_sets::SET_KEYS;
use super::tree::{Entry, Node, NodeContent};

/// Keys of a set by rule that name another set.
pub const KEYS_OF_SETS: [&str; 2] = ["of", "from"];
/// Key of a set by rule with a list of names.
pub const LIST_OF_SETS: &str = "sets";

/// Returns true if the key with this path, such as `fix.0.nodes`, names a node set.
pub fn names_a_set(path: &str) -> bool {
    let mut keys = path.split('.').filter(|key| key.parse::<usize>().is_err());
    let (last, list) = (keys.next_back().unwrap_or_default(), keys.collect::<Vec<_>>().join("."));
    let of_rule = list == "set" && (KEYS_OF_SETS.contains(&last) || last == LIST_OF_SETS);
    of_rule || SET_KEYS.iter().any(|row| row.list == list && row.key == last)
}

/// Moves the rules of a job to `[[set]]` and puts their names in their places. Values keep their
/// places.
pub fn hoist(tree: &mut Node) {
    let mut made = Vec::new();
    for row in SET_KEYS {
        let Some(entries) = row.list.split('.').try_fold(&mut *tree, |node, key| entry(node, key))
        else {
            continue;
        };
        let NodeContent::Array(entries) = &mut entries.kind else { continue };
        for (i, one) in entries.iter_mut().enumerate() {
            if let Some(node) = entry(one, row.key) {
                take(node, format!("{}.{i}.{}", row.list, row.key), &mut made);
            }
        }
    }
    if let Some(Node { kind: NodeContent::Array(sets), .. }) = entry(tree, "set") {
        for (i, set) in sets.iter_mut().enumerate() {
            take_inner(set, &format!("set.{i}"), &mut made);
        }
    }
    let mut done = 0;
    while done < made.len() {
        let mut set = made[done].clone();
        let name = match set.get("name") {
            Some(Node { kind: NodeContent::String(name), .. }) => name.clone(),
            _ => String::new(),
        };
        take_inner(&mut set, &name, &mut made);
        made[done] = set;
        done += 1;
    }
    let (NodeContent::Table(keys), Some(first)) = (&mut tree.kind, made.first()) else { return };
    let place = first.place;
    let list = keys.entry("set".into()).or_insert_with(|| Entry {
        key: place,
        node: Node { kind: NodeContent::Array(Vec::new()), place },
    });
    // Something else than a list is reported by the check against the schema.
    if let NodeContent::Array(list) = &mut list.node.kind {
        list.extend(made);
    }
}

/// Returns the value of a key of a table.
fn entry<'n>(node: &'n mut Node, key: &str) -> Option<&'n mut Node> {
    match &mut node.kind {
        NodeContent::Table(keys) => keys.get_mut(key).map(|entry| &mut entry.node),
        _ => None,
    }
}

/// Moves the rules in a set by rule to `made`.
fn take_inner(set: &mut Node, path: &str, made: &mut Vec<Node>) {
    for key in KEYS_OF_SETS {
        if let Some(node) = entry(set, key) {
            take(node, format!("{path}.{key}"), made);
        }
    }
    if let Some(Node { kind: NodeContent::Array(sets), .. }) = entry(set, LIST_OF_SETS) {
        for (i, node) in sets.iter_mut().enumerate() {
            take(node, format!("{path}.{LIST_OF_SETS}.{i}"), made);
        }
    }
}

/// Moves a rule to `made` and leaves its name, which is `path` if it has none.
fn take(node: &mut Node, path: String, made: &mut Vec<Node>) {
    let NodeContent::Table(keys) = &mut node.kind else { return };
    let place = node.place;
    let name = keys.entry("name".into()).or_insert_with(|| Entry {
        key: place,
        node: Node { kind: NodeContent::String(path), place },
    });
    let name = name.node.clone();
    made.push(std::mem::replace(node, name));
}
