//! `--set section.key=value`: values of a job from the command line.
//!
//! An entry of a list such as `[[part]]` is addressed by its `name`, by its `id` if such entries
//! have one, and by its position from 0 if they have neither.

use super::tree::{Entry, Node, NodeContent, Place, split_first};
use super::validate::{JobProblems, is_list_of_tables, nearest};
use crumple_proto::problem::Problem;

/// Inserts every `key=value` into the tree. Unknown keys are inserted too, because the check
/// against the schema reports them.
pub fn apply(tree: &mut Node, sets: &[String], findings: &mut JobProblems) {
    for (index, argument) in sets.iter().enumerate() {
        let place = Place::Set(index as u32);
        if let Err((message, help)) = apply_one(tree, argument, place, findings) {
            findings.add_faulty(
                Problem::error(format!("--set {argument}"), message, help),
                Some(place),
            );
        }
    }
}

type Wrong = (String, String);

fn apply_one(
    tree: &mut Node,
    argument: &str,
    place: Place,
    findings: &mut JobProblems,
) -> Result<(), Wrong> {
    let Some((path, value)) = argument.split_once('=') else {
        return Err((
            "an argument of --set has no value".into(),
            "write --set section.key=value".into(),
        ));
    };
    let (path, value) = (path.trim(), value.trim());
    if path.is_empty() || path.split('.').any(|key| key.trim().is_empty()) {
        return Err((
            format!("`{path}` is not a valid key"),
            "write --set section.key=value".into(),
        ));
    }
    let value = match Node::parse_value(value, place) {
        Some(node) => node,
        None if value.starts_with(['[', '{', '"', '\'']) => {
            return Err((
                format!("the value `{value}` cannot be read"),
                "write it as in a job file".into(),
            ));
        }
        None => Node { kind: NodeContent::String(value.into()), place },
    };
    if path == "include" || path.starts_with("include.") {
        let help = "write `include` in the job file; set its keys by their own paths";
        return Err(("--set cannot include files".into(), help.into()));
    }
    if path.starts_with("contact.") && tree.get("contact").is_none() {
        let message = "--set turns contact on: the job has no [contact]";
        findings.add(Problem::warning("contact", message, "remove it to run without contact"));
    }
    put(tree, path, path, value, place)
}

fn put(node: &mut Node, rest: &str, whole: &str, value: Node, place: Place) -> Result<(), Wrong> {
    if rest.is_empty() {
        *node = value;
        return Ok(());
    }
    let before = whole[..whole.len() - rest.len()].trim_end_matches('.');
    match &mut node.kind {
        NodeContent::Table(entries) => {
            let known = split_first(rest, entries.keys().map(String::as_str))
                .map(|(k, tail)| (k.to_string(), tail));
            let (key, tail) = match known {
                Some(known) => known,
                None => {
                    let (key, tail) = rest.split_once('.').unwrap_or((rest, ""));
                    if before.is_empty() && !tail.is_empty() && is_list_of_tables(key) {
                        return Err((
                            format!("the job has no [[{key}]]"),
                            format!("add one to the job: `{whole}` has no entry to change"),
                        ));
                    }
                    entries.insert(key.to_string(), Entry { key: place, node: Node::table(place) });
                    (key.to_string(), tail)
                }
            };
            let entry = entries.get_mut(&key).expect("found or inserted above");
            put(&mut entry.node, tail, whole, value, place)
        }
        NodeContent::Array(items) => {
            let (index, tail) = find_entry(items, rest, before)?;
            put(&mut items[index], tail, whole, value, place)
        }
        _ => Err((
            format!("`{before}` is a single value and contains no `{rest}`"),
            format!("write --set {before}=..."),
        )),
    }
}

fn find_entry<'p>(items: &[Node], rest: &'p str, list: &str) -> Result<(usize, &'p str), Wrong> {
    let name = |item: &Node| match item.get("name").map(|n| &n.kind) {
        Some(NodeContent::String(name)) if !name.is_empty() => Some(name.clone()),
        _ => None,
    };
    let id = |item: &Node| match item.get("id").map(|n| &n.kind) {
        Some(NodeContent::Integer(id)) => Some(id.to_string()),
        _ => None,
    };
    let names: Vec<Option<String>> = items.iter().map(name).collect();
    let ids: Vec<Option<String>> = items.iter().map(id).collect();
    let positions: Vec<Option<String>> = match ids.iter().any(Option::is_some) {
        true => Vec::new(),
        false => (0..items.len()).map(|i| Some(i.to_string())).collect(),
    };
    for called in [&names, &ids, &positions] {
        if let Some((word, tail)) = split_first(rest, called.iter().flatten().map(String::as_str)) {
            let index =
                called.iter().position(|c| c.as_deref() == Some(word)).expect("found above");
            return Ok((index, tail));
        }
    }
    let wanted = rest.split('.').next().unwrap_or(rest);
    let known: Vec<&str> =
        [&names, &ids, &positions].into_iter().flatten().flatten().map(String::as_str).collect();
    let by = if positions.is_empty() { "name or id" } else { "name or position" };
    Err((format!("`{list}` has no entry with the {by} `{wanted}`"), nearest(wanted, &known)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOB: &str = "end_time = 1.0\n\
                       [[part]]\nid = 7\nname = \"rail\"\nthickness = 2.0\n\
                       [[part]]\nid = 1\nthickness = 3.0\n\
                       [[wall]]\npoint = [0, 0, 0]\n\
                       [[material]]\nname = \"AA6061.T6\"\ndensity = 1.0\n";

    fn set(argument: &str) -> (Node, JobProblems) {
        let (mut tree, mut findings) = (Node::parse(JOB).unwrap(), JobProblems::default());
        apply(&mut tree, &[argument.to_string()], &mut findings);
        (tree, findings)
    }

    fn number(tree: &Node, list: &str, index: usize, key: &str) -> Option<f64> {
        let value = tree.to_value();
        let x = &value.get(list)?.as_array()?[index].get(key)?.clone();
        x.as_float().or(x.as_integer().map(|i| i as f64))
    }

    #[test]
    fn entries_go_by_name_id_or_position() {
        assert_eq!(number(&set("part.rail.thickness=5").0, "part", 0, "thickness"), Some(5.0));
        assert_eq!(number(&set("part.7.thickness=5").0, "part", 0, "thickness"), Some(5.0));
        assert_eq!(number(&set("part.1.thickness=5").0, "part", 1, "thickness"), Some(5.0));
        assert_eq!(number(&set("wall.0.friction=0.1").0, "wall", 0, "friction"), Some(0.1));
        assert_eq!(
            number(&set("material.AA6061.T6.density=2.5").0, "material", 0, "density"),
            Some(2.5)
        );
        assert_eq!(
            set("wall.0.point.1=4").0.to_value()["wall"][0]["point"][1].as_integer(),
            Some(4)
        );
    }

    #[test]
    fn a_section_that_is_absent_is_made() {
        let (tree, findings) = set("time.safety=0.5");
        assert_eq!(tree.to_value()["time"]["safety"].as_float(), Some(0.5));
        assert!(findings.list.is_empty());
        assert!(set("contact.friction=0.2").1.list[0].problem.message.contains("turns contact on"));
    }

    #[test]
    fn bare_words_are_text() {
        assert_eq!(set("title=crash test").0.to_value()["title"].as_str(), Some("crash test"));
        assert_eq!(set("title=\"a = b\"").0.to_value()["title"].as_str(), Some("a = b"));
        assert_eq!(set("title=").0.to_value()["title"].as_str(), Some(""));
    }

    #[test]
    fn keys_that_cannot_be_set_are_reported() {
        for (argument, said) in [
            ("part.rial.thickness=5", "did you mean `rail`"),
            ("part.0.thickness=5", "no entry with the name or id `0`"),
            ("wall.3.friction=1", "no entry with the name or position `3`"),
            ("fix.0.dofs=[]", "no [[fix]]"),
            ("end_time.x=1", "single value"),
            ("end_time", "has no value"),
            ("=3", "is not a valid key"),
            ("part..x=3", "is not a valid key"),
            ("wall.0.point=[1,", "cannot be read"),
        ] {
            let (_, findings) = set(argument);
            let text = findings
                .list
                .iter()
                .map(|f| format!("{} {}", f.problem.message, f.problem.help))
                .collect::<String>();
            assert!(text.contains(said), "{argument}: {text}");
        }
    }
}
