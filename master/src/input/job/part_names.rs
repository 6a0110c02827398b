//! Names in lists of parts: `parts = ["bumper", 3]`.
//!
//! Each becomes the id of its part before the keys are checked. The schema knows which lists hold
//! parts: their entries are a [`PartRef`](crumple_proto::job::PartRef).

use super::tree::{Node, NodeContent};
use super::validate::{JobProblems, SCHEMA, is_part, join, nearest, resolve};
use crumple_proto::problem::Problem;
use serde_json::Value;

/// Replaces the names of parts by ids. Values keep their places.
pub fn replace(tree: &mut Node, findings: &mut JobProblems) {
    let known = known(tree);
    visit(tree, &SCHEMA, "", &mut |node, path| {
        let NodeContent::String(name) = &node.kind else { return };
        let ids: Vec<i64> = known.iter().filter(|(n, _)| n == name).map(|(_, id)| *id).collect();
        if ids.len() != 1 {
            findings.add_faulty(not_one(path, name, &ids, &known), Some(node.place));
        }
        // After a problem any part will do, so that later checks can look at the rest.
        let any = || known.first().map_or(1, |(_, id)| *id);
        node.kind = NodeContent::Integer(ids.first().copied().unwrap_or_else(any));
    });
}

/// Returns the names and ids of the parts that have a name.
fn known(tree: &Node) -> Vec<(String, i64)> {
    let Some(NodeContent::Array(parts)) = tree.get("part").map(|parts| &parts.kind) else {
        return Vec::new();
    };
    let named = |part: &Node| match (&part.get("name")?.kind, &part.get("id")?.kind) {
        (NodeContent::String(name), NodeContent::Integer(id)) if !name.is_empty() => {
            Some((name.clone(), *id))
        }
        _ => None,
    };
    parts.iter().filter_map(named).collect()
}

/// Returns the problem of a name that no part has, or several.
fn not_one(path: &str, name: &str, ids: &[i64], known: &[(String, i64)]) -> Problem {
    if !ids.is_empty() {
        let all = ids.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
        let message = format!("there are {} parts `{name}`: {all}", ids.len());
        return Problem::error(path, message, "give ids, or other names to the parts");
    }
    let names: Vec<&str> = known.iter().map(|(name, _)| &name[..]).collect();
    let help = match name.trim().parse::<u32>() {
        Ok(id) => format!("write the id of a part without quotes: {id}"),
        Err(_) if names.is_empty() => "no part has a name: give the ids of parts".into(),
        Err(_) => nearest(name, &names),
    };
    Problem::error(path, format!("there is no part `{name}`"), help)
}

/// Calls `found` with each entry of the lists of parts, and its path.
fn visit(node: &mut Node, schema: &Value, path: &str, found: &mut dyn FnMut(&mut Node, &str)) {
    if is_part(schema) {
        return found(node, path);
    }
    let schema = resolve(schema);
    for choice in schema["anyOf"].as_array().into_iter().flatten() {
        visit(node, choice, path, found);
    }
    match &mut node.kind {
        NodeContent::Table(entries) => {
            for (key, entry) in entries {
                if let Some(property) = schema["properties"].get(key) {
                    visit(&mut entry.node, property, &join(path, key), found);
                }
            }
        }
        // Rows of a mesh, of which there may be millions, are of no type with a name.
        NodeContent::Array(items) if schema["items"]["$ref"].is_string() => {
            for (index, item) in items.iter_mut().enumerate() {
                visit(item, &schema["items"], &join(path, &index.to_string()), found);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::job::{Model, read_text};

    /// Two shells of two parts.
    const JOB: &str = r#"
        end_time = 1.0
        [mesh]
        nodes = [[1, 0, 0, 0], [2, 1, 0, 0], [3, 1, 1, 0], [4, 0, 1, 0], [5, 2, 0, 0], [6, 2, 1, 0]]
        shells = [[1, 3, 1, 2, 3, 4], [2, 7, 2, 5, 6, 3]]
        [[material]]
        name = "steel"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 207.0
        poisson = 0.3
        [[part]]
        id = 3
        name = "bumper"
        material = "steel"
        thickness = 0.1
        [[part]]
        id = 7
        name = "rail"
        material = "steel"
        thickness = 0.1
    "#;

    fn read(more: &str, sets: &[&str]) -> Result<Model, String> {
        let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
        let read = read_text("parts.toml".into(), format!("{JOB}{more}"), &sets);
        read.map_err(|report| report.to_string())
    }

    fn problems(more: &str, sets: &[&str]) -> String {
        read(more, sets).err().expect("the job has an error")
    }

    #[test]
    fn lists_of_parts_take_names_and_ids() {
        let more = "[contact]\nlaw = \"penalty\"\nparts = [\"bumper\", 7]\n\
                    [[contact.interface]]\nparts = [\"rail\"]\nagainst = [\"bumper\"]\n\
                    [[gravity]]\nacceleration = [0.0, 0.0, 1.0]\nparts = [\"rail\", \"bumper\"]\n\
                    [[set]]\nname = \"s\"\nrule = \"part\"\nparts = [\"rail\"]\n\
                    [[output.transducer]]\nname = \"t\"\nparts = [3]\nfrom_parts = [\"rail\"]\n";
        let model =
            read(more, &["gravity.0.parts=[\"rail\"]"]).unwrap_or_else(|why| panic!("{why}"));
        let contact = model.job.contact.as_ref().unwrap();
        assert_eq!((&contact.parts[..], &contact.interface[0].parts[..]), (&[3, 7][..], &[7][..]));
        assert_eq!(contact.interface[0].against, [3]);
        assert_eq!(
            (&model.job.gravity[0].parts[..], &model.job.set[0].parts[..]),
            (&[7][..], &[7][..])
        );
        assert_eq!(model.job.output.transducer[0].from_parts, [7]);
    }

    #[test]
    fn a_name_that_no_part_has_is_an_error_with_its_place_and_all_names() {
        let why = problems("[[rigid]]\nname = \"body\"\nparts = [3,\n\"bumber\"]\n", &[]);
        let line = JOB.lines().count() + 4 - 1;
        let place = format!("parts.toml:{line}:");
        for text in
            [&place[..], "there is no part `bumber`", "did you mean `bumper`? known: bumper, rail"]
        {
            assert!(why.contains(text), "no `{text}` in {why}");
        }
        let why = problems("[[rigid]]\nname = \"body\"\nparts = [\"7\"]\n", &[]);
        assert!(why.contains("without quotes: 7"), "{why}");
        let why = problems("", &["restart.delete=[\"rails\"]"]);
        assert!(why.contains("there is no part `rails`"), "{why}");
    }

    /// No list of parts is forgotten: other lists of whole numbers have ids of nodes or elements.
    #[test]
    fn every_key_with_parts_takes_names() {
        for (name, table) in SCHEMA["$defs"].as_object().unwrap() {
            for (key, property) in table["properties"].as_object().into_iter().flatten() {
                let is_list_of_parts = ["parts", "from_parts", "against", "exclude", "delete"];
                if property["type"] == "array" && is_list_of_parts.contains(&&key[..]) {
                    assert!(is_part(&property["items"]), "{name}.{key}");
                }
            }
        }
    }
}
