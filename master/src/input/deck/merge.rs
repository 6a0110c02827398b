//! Merges a job's own keys over those of its deck.

use crate::input::job::tree::{Entry, Node, NodeContent};
use std::collections::BTreeMap;

/// Merges `over` into `base`: its values win. Tables are merged key by key. Entries of lists such
/// as `[[part]]` are merged with the entry of the same id or name, or added if there is none. An
/// entry with the key `use` replaces the other one. A list in an entry replaces the other one if
/// its own entries have neither ids nor names, such as `layer` of a part.
pub fn merge(base: Node, over: Node) -> Node {
    within(base, over, false)
}

/// Merges nodes; `in_entry` is true for those of an entry of a list.
fn within(base: Node, over: Node, in_entry: bool) -> Node {
    match (base.kind, over.kind) {
        (NodeContent::Table(base), NodeContent::Table(own)) => {
            Node { kind: NodeContent::Table(tables(base, own, in_entry)), place: over.place }
        }
        (NodeContent::Array(base), NodeContent::Array(own))
            if own.iter().all(is_table)
                && base.iter().all(is_table)
                && !(in_entry && own.iter().all(is_nameless)) =>
        {
            Node { kind: NodeContent::Array(lists(base, own)), place: over.place }
        }
        (_, kind) => Node { kind, place: over.place },
    }
}

fn is_table(node: &Node) -> bool {
    matches!(node.kind, NodeContent::Table(_))
}

/// Returns true for an entry without an id and a name.
fn is_nameless(node: &Node) -> bool {
    ["id", "name"].iter().all(|key| node.get(key).is_none())
}

fn tables(
    mut base: BTreeMap<String, Entry>,
    over: BTreeMap<String, Entry>,
    in_entry: bool,
) -> BTreeMap<String, Entry> {
    for (key, entry) in over {
        let merged = match base.remove(&key) {
            Some(old) => Entry { key: entry.key, node: within(old.node, entry.node, in_entry) },
            None => entry,
        };
        base.insert(key, merged);
    }
    base
}

fn lists(mut base: Vec<Node>, over: Vec<Node>) -> Vec<Node> {
    for entry in over {
        let same = |node: &Node| {
            ["id", "name"].iter().any(|key| {
                match (node.get(key).map(|n| &n.kind), entry.get(key).map(|n| &n.kind)) {
                    (Some(NodeContent::Integer(a)), Some(NodeContent::Integer(b))) => a == b,
                    (Some(NodeContent::String(a)), Some(NodeContent::String(b))) => {
                        a == b && !a.is_empty()
                    }
                    _ => false,
                }
            })
        };
        match base.iter().position(same) {
            Some(at) => {
                let old = std::mem::replace(&mut base[at], Node::table(entry.place));
                // A material of the library takes the place of the other one.
                let is_from_library = entry.get("use").is_some();
                base[at] = if is_from_library { entry } else { within(old, entry, true) };
            }
            None => base.push(entry),
        }
    }
    base
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_of_the_library_replaces_another_one() {
        let base = "[[material]]\nname = \"a\"\nlaw = \"elastic\"\ndensity = 1.0\n";
        let over = "[[material]]\nname = \"a\"\nuse = \"steel DP600\"\n";
        let merged = merge(Node::parse(base).unwrap(), Node::parse(over).unwrap()).to_value();
        let material = merged["material"][0].as_table().unwrap();
        assert_eq!(material.keys().collect::<Vec<_>>(), ["name", "use"]);
    }

    /// A list of an entry whose items have no names is one value: its items are not added.
    #[test]
    fn layers_of_a_part_replace_others() {
        let of = |layers: &str| format!("[[part]]\nid = 1\nlayer = [{layers}]\n");
        let [base, over] = [of("{ points = 1 }, { points = 1 }"), of("{ points = 2 }")];
        let merged = merge(Node::parse(&base).unwrap(), Node::parse(&over).unwrap()).to_value();
        assert_eq!(merged["part"][0]["layer"].as_array().map(Vec::len), Some(1));
        assert_eq!(merged["part"][0]["layer"][0]["points"].as_integer(), Some(2));
    }

    #[test]
    fn the_jobs_own_keys_win_and_add() {
        let base = "end_time = 1.0\n[time]\nsafety = 0.8\ndamping = 2.0\n[[part]]\nid = 1\n\
                    name = \"a\"\nthickness = 1.0\n[[fix]]\nnodes = \"x\"\n[contact]\n\
                    parts = [1, 2]\n";
        let over = "[time]\nsafety = 0.5\n[[part]]\nid = 1\nthickness = 3.0\n[[part]]\nid = 2\n\
                    [[fix]]\nnodes = \"y\"\n[contact]\nparts = []\n";
        let merged = merge(Node::parse(base).unwrap(), Node::parse(over).unwrap()).to_value();
        assert_eq!(merged["time"]["safety"].as_float(), Some(0.5));
        assert_eq!(merged["time"]["damping"].as_float(), Some(2.0));
        assert_eq!(merged["part"][0]["thickness"].as_float(), Some(3.0));
        assert_eq!(merged["part"][0]["name"].as_str(), Some("a"));
        assert_eq!(merged["part"].as_array().map(Vec::len), Some(2));
        assert_eq!(merged["fix"].as_array().map(Vec::len), Some(2));
        assert_eq!(merged["contact"]["parts"].as_array().map(Vec::len), Some(0));
    }
}
