//! Compares a job with the schema of jobs: unknown keys, wrong types, missing keys, invalid
//! numbers.
//!
//! Faulty values are reported and then removed or replaced, so that later checks can look at the
//! rest.

use super::inline_sets;
use super::report::PlacedProblem;
use super::tree::{Entry, Node, NodeContent, Place};
use crumple_proto::job::PartRef;
use crumple_proto::problem::Problem;
use schemars::JsonSchema;
use serde_json::Value;
use std::collections::HashSet;
use std::sync::LazyLock;

pub(super) static SCHEMA: LazyLock<Value> = LazyLock::new(crate::input::reference::job_schema);

/// The problems so far, and the paths below which nothing more is reported.
#[derive(Debug, Default)]
pub struct JobProblems {
    /// The problems.
    pub(crate) list: Vec<PlacedProblem>,
    faulty: Vec<String>,
    in_mesh_file: bool,
}

impl JobProblems {
    /// Adds a problem, unless its path, or a path below it, is known to be faulty already.
    pub fn add(&mut self, problem: Problem) {
        if !self.is_faulty(&problem.path) && !self.any_faulty_below(&problem.path) {
            self.list.push(PlacedProblem::from(problem));
        }
    }

    /// Adds a problem at a given place, and suppresses further problems of its path.
    pub fn add_faulty(&mut self, problem: Problem, place: Option<Place>) {
        self.faulty.push(problem.path.clone());
        self.list.push(PlacedProblem { problem, place, in_mesh_file: self.in_mesh_file });
    }

    /// Returns true if the value at `path`, or a table that contains it, is faulty.
    pub fn is_faulty(&self, path: &str) -> bool {
        self.faulty.iter().any(|f| {
            path.strip_prefix(f.as_str()).is_some_and(|r| r.is_empty() || r.starts_with('.'))
        })
    }

    /// Returns true if anything at or below `path` is faulty.
    pub fn any_faulty_below(&self, path: &str) -> bool {
        self.faulty
            .iter()
            .any(|f| f.strip_prefix(path).is_some_and(|r| r.is_empty() || r.starts_with('.')))
    }

    fn depth(&self) -> usize {
        self.faulty.iter().map(|f| f.matches('.').count()).max().unwrap_or(0)
    }

    /// Returns true if any problem is an error.
    pub fn any_error(&self) -> bool {
        self.list.iter().any(|f| f.problem.severity == crumple_proto::problem::Severity::Error)
    }
}

/// Checks a whole job and repairs it so that it can be read as a job.
pub fn job(tree: &mut Node, findings: &mut JobProblems) {
    walk(tree, &SCHEMA, "", findings);
}

/// Checks and repairs a mesh file, whose keys are those of the job's `[mesh]`.
pub fn mesh_file(tree: &mut Node, findings: &mut JobProblems) {
    findings.in_mesh_file = true;
    walk(tree, &SCHEMA["$defs"]["MeshSource"], "mesh", findings);
    for key in
        ["file", "generator", "exodus", "add"].into_iter().filter(|key| tree.get(key).is_some())
    {
        let message = format!("a mesh file cannot have the key `{key}`");
        findings.add_faulty(
            Problem::error(
                join("mesh", key),
                message,
                "remove it: a mesh file holds nodes, elements and node sets",
            ),
            None,
        );
    }
    findings.in_mesh_file = false;
}

/// Adds the syntax errors of the mesh file.
pub fn mesh_file_syntax(errors: Vec<super::tree::SyntaxError>, findings: &mut JobProblems) {
    findings.in_mesh_file = true;
    for (message, help, place) in errors {
        findings.add_faulty(Problem::error("mesh", message, help), Some(place));
    }
    findings.in_mesh_file = false;
}

/// Returns true if jobs have a list of tables (`[[key]]`) with this key.
pub fn is_list_of_tables(key: &str) -> bool {
    let property = resolve(&SCHEMA["properties"][key]);
    property["type"] == "array" && resolve(&property["items"])["type"] == "object"
}

fn walk(node: &mut Node, schema: &Value, path: &str, findings: &mut JobProblems) {
    let resolved = resolve(schema);
    if let Some(choices) = resolved["anyOf"].as_array() {
        return any_of(node, choices, schema, path, findings);
    }
    if let Some(choices) = resolved["oneOf"].as_array() {
        return one_word_of(node, choices, path, findings);
    }
    match (kind_of(resolved), &mut node.kind) {
        ("object", NodeContent::Table(_)) => table(node, resolved, path, findings),
        ("array", NodeContent::Array(_)) => list(node, resolved, schema, path, findings),
        ("string", NodeContent::String(_)) | ("boolean", NodeContent::Boolean(_)) => {}
        ("number", NodeContent::Integer(_)) => {}
        ("number", NodeContent::Float(x)) if x.is_finite() => {}
        ("integer", NodeContent::Integer(i)) if fits(*i, resolved) => {}
        ("", _) => {}
        _ => wrong(node, schema, path, findings),
    }
}

fn table(node: &mut Node, schema: &Value, path: &str, findings: &mut JobProblems) {
    let here = node.place;
    let NodeContent::Table(entries) = &mut node.kind else { return };
    let properties = schema["properties"].as_object();
    let mut unknown = Vec::new();
    for (key, entry) in entries.iter_mut() {
        let path = join(path, key);
        match properties.and_then(|p| p.get(key)) {
            Some(property) => walk(&mut entry.node, property, &path, findings),
            None if schema["additionalProperties"].is_object() => {
                walk(&mut entry.node, &schema["additionalProperties"], &path, findings);
            }
            None if schema["additionalProperties"] == false => unknown.push(key.clone()),
            None => {}
        }
    }
    for key in unknown {
        let entry = entries.remove(&key).expect("the key was found above");
        let known: Vec<&str> =
            properties.map(|p| p.keys().map(String::as_str).collect()).unwrap_or_default();
        let problem = Problem::error(
            join(path, &key),
            unknown_message(&key, path),
            unknown_help(&key, path, &known),
        );
        findings.add_faulty(problem, Some(entry.key));
    }
    for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        if entries.contains_key(key) {
            continue;
        }
        let property = &schema["properties"][key];
        let message = match path {
            "" => format!("the job has no `{key}`"),
            _ => format!("{} has no `{key}`", section(path)),
        };
        let card =
            if join(path, key) == "end_time" { "; in a deck *CONTROL_TERMINATION" } else { "" };
        let help =
            format!("add `{key} = ...`, {}: {}{card}", expected(property), description(property));
        findings.add_faulty(Problem::error(join(path, key), message, help), Some(here));
        entries.insert(key.to_string(), Entry { key: here, node: stand_in(property, here) });
    }
}

fn list(node: &mut Node, resolved: &Value, schema: &Value, path: &str, findings: &mut JobProblems) {
    let NodeContent::Array(items) = &mut node.kind else { return };
    let (least, most) = (resolved["minItems"].as_u64().unwrap_or(0), resolved["maxItems"].as_u64());
    let length = items.len() as u64;
    if length < least || most.is_some_and(|most| length > most) {
        return wrong(node, schema, path, findings);
    }
    let item_schema = &resolved["items"];
    // A mesh has millions of numbers, so no path is built for valid ones.
    let plain = resolve(item_schema)["type"].as_str().map(str::to_string);
    for (index, item) in items.iter_mut().enumerate() {
        match (plain.as_deref(), &item.kind) {
            (Some("number"), NodeContent::Integer(_)) => continue,
            (Some("number"), NodeContent::Float(x)) if x.is_finite() => continue,
            (Some("integer"), NodeContent::Integer(i)) if fits(*i, resolve(item_schema)) => {
                continue;
            }
            _ => walk(item, item_schema, &join(path, &index.to_string()), findings),
        }
    }
}

fn any_of(
    node: &mut Node,
    choices: &[Value],
    schema: &Value,
    path: &str,
    findings: &mut JobProblems,
) {
    let choices = || choices.iter().filter(|c| c["type"] != "null");
    // An optional word.
    if choices().count() == 1
        && let Some(words) = choices().find_map(|c| resolve(c)["oneOf"].as_array())
    {
        return one_word_of(node, words, path, findings);
    }
    let mut best: Option<(Node, JobProblems)> = None;
    for choice in choices() {
        let mut copy = node.clone();
        let mut tried =
            JobProblems { in_mesh_file: findings.in_mesh_file, ..JobProblems::default() };
        walk(&mut copy, choice, path, &mut tried);
        if tried.list.is_empty() {
            return;
        }
        // The choice that fails deepest inside the value is nearest to the intended one.
        if !tried.is_faulty(path) && best.as_ref().is_none_or(|(_, b)| tried.depth() > b.depth()) {
            best = Some((copy, tried));
        }
    }
    match best {
        Some((mended, tried)) => {
            *node = mended;
            findings.list.extend(tried.list);
            findings.faulty.extend(tried.faulty);
        }
        None => wrong(node, schema, path, findings),
    }
}

fn one_word_of(node: &mut Node, choices: &[Value], path: &str, findings: &mut JobProblems) {
    let words: Vec<&str> = choices.iter().filter_map(|c| c["const"].as_str()).collect();
    if let NodeContent::String(word) = &node.kind
        && words.contains(&word.as_str())
    {
        return;
    }
    let help = match &node.kind {
        NodeContent::String(word) => nearest(word, &words),
        _ => format!("choose one of: {}", words.join(", ")),
    };
    let message = format!("`{}` cannot be {}", last(path), given(node));
    findings.add_faulty(Problem::error(path, message, help), None);
    *node = Node {
        kind: NodeContent::String(words.first().copied().unwrap_or_default().into()),
        place: node.place,
    };
}

/// Reports a value of the wrong type and replaces it by one of the right type.
fn wrong(node: &mut Node, schema: &Value, path: &str, findings: &mut JobProblems) {
    let what = match last(path).parse::<usize>() {
        Ok(_) => format!("an entry of `{}`", last(list_path(path))),
        Err(_) => format!("`{}`", last(path)),
    };
    let message = format!("{what} has to be {}, not {}", expected(schema), given(node));
    let meaning = match description(schema) {
        own if own.is_empty() => list_description(path),
        own => own,
    };
    let kind = kind_of(resolve(schema));
    let help = match &node.kind {
        NodeContent::String(s) if s.trim().parse::<f64>().is_ok() && kind != "string" => {
            format!("write the number without quotes: {}", s.trim())
        }
        NodeContent::Float(x) if !x.is_finite() && kind == "number" => {
            format!("write a finite number: {meaning}")
        }
        NodeContent::Float(x) if x.fract() == 0.0 && kind == "integer" && x.abs() < 1e15 => {
            format!("write it without a point: {x}")
        }
        NodeContent::Table(_) if is_list_of_tables(path) => {
            format!("write [[{path}]] with two brackets for each entry")
        }
        NodeContent::Array(_) if kind == "object" => {
            format!("write [{path}] with one bracket, once")
        }
        _ if inline_sets::names_a_set(path) => {
            "write the name of a node set, part or rigid body, or a rule such as { rule = \"box\", \
             min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }"
                .into()
        }
        _ if is_part(schema) => {
            "write the id of a part, a whole number, or its name: `id` and `name` in its [[part]]"
                .into()
        }
        _ => meaning,
    };
    findings.add_faulty(Problem::error(path, message, help), None);
    *node = stand_in(schema, node.place);
}

/// Returns a value of the right type, so that reading can continue.
fn stand_in(schema: &Value, place: Place) -> Node {
    let resolved = resolve(schema);
    let first =
        |choices: &Value| choices.as_array().and_then(|c| c.first()).map(|c| stand_in(c, place));
    let kind = match kind_of(resolved) {
        "object" => {
            let required =
                resolved["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let entry = |key: &str| {
                let node = stand_in(&resolved["properties"][key], place);
                (key.to_string(), Entry { key: place, node })
            };
            NodeContent::Table(required.map(entry).collect())
        }
        "array" => {
            let least = resolved["minItems"].as_u64().unwrap_or(0);
            NodeContent::Array((0..least).map(|_| stand_in(&resolved["items"], place)).collect())
        }
        "number" => NodeContent::Float(1.0),
        "integer" => NodeContent::Integer(1),
        "boolean" => NodeContent::Boolean(false),
        _ => match first(&resolved["anyOf"]).or_else(|| first(&resolved["oneOf"])) {
            Some(node) => return node,
            None => NodeContent::String(resolved["const"].as_str().unwrap_or_default().into()),
        },
    };
    Node { kind, place }
}

/// Returns the schema that `$ref` points to, or the schema itself.
pub(super) fn resolve(schema: &Value) -> &Value {
    match schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
        Some(name) => &SCHEMA["$defs"][name],
        None => schema,
    }
}

/// Returns true if values of this schema are parts, by id or name.
pub(super) fn is_part(schema: &Value) -> bool {
    schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/"))
        == Some(&*PartRef::schema_name())
}

/// Returns the name of the type; of an optional type the one that is not null.
fn kind_of(schema: &Value) -> &str {
    match &schema["type"] {
        Value::String(name) => name,
        Value::Array(names) => {
            names.iter().filter_map(Value::as_str).find(|n| *n != "null").unwrap_or("")
        }
        _ => "",
    }
}

fn fits(i: i64, schema: &Value) -> bool {
    let most = if schema["format"] == "uint32" { i64::from(u32::MAX) } else { i64::MAX };
    i >= schema["minimum"].as_i64().unwrap_or(i64::MIN) && i <= most
}

fn expected(schema: &Value) -> String {
    let resolved = resolve(schema);
    if let Some(choices) = resolved["anyOf"].as_array() {
        let all: Vec<String> =
            choices.iter().filter(|c| c["type"] != "null").map(expected).collect();
        return all.join(" or ");
    }
    if let Some(choices) = resolved["oneOf"].as_array() {
        let all: Vec<&str> = choices.iter().filter_map(|c| c["const"].as_str()).collect();
        return format!("one of {}", all.join(", "));
    }
    match kind_of(resolved) {
        "object" => "a table".into(),
        "string" => "text in quotes".into(),
        "boolean" => "true or false".into(),
        "number" => "a finite number".into(),
        "integer" if resolved["minimum"].is_number() => {
            format!("a whole number from {}", resolved["minimum"])
        }
        "integer" => "a whole number".into(),
        "array" => {
            let items = match kind_of(resolve(&resolved["items"])) {
                _ if is_part(&resolved["items"]) => "ids or names of parts",
                "number" => "finite numbers",
                "integer" => "whole numbers",
                "string" => "texts",
                "object" => "tables",
                _ => "lists",
            };
            match resolved["minItems"].as_u64() {
                Some(n) => format!("a list of {n} {items}"),
                None => format!("a list of {items}"),
            }
        }
        _ => "of another type".into(),
    }
}

fn given(node: &Node) -> String {
    match &node.kind {
        NodeContent::Table(_) => "a table".into(),
        NodeContent::Array(items) => match items.len() {
            1 => "a list of 1 entry".into(),
            n => format!("a list of {n} entries"),
        },
        NodeContent::String(s) => format!("the text \"{}\"", s.escape_debug()),
        NodeContent::Integer(i) => format!("{i}"),
        NodeContent::Float(x) if x.is_nan() => "nan".into(),
        NodeContent::Float(x) => format!("{x:?}"),
        NodeContent::Boolean(b) => format!("{b}"),
        NodeContent::Datetime(_) => "a date".into(),
    }
}

/// Returns the description of a key in the schema.
fn description(schema: &Value) -> String {
    let own = schema["description"].as_str().or_else(|| resolve(schema)["description"].as_str());
    own.unwrap_or_default().replace('\n', " ").trim_end_matches('.').to_string()
}

/// Returns the description of the list that contains an entry such as `mesh.nodes.3.1`.
fn list_description(path: &str) -> String {
    let mut schema: &Value = &SCHEMA;
    for key in list_path(path).split('.') {
        schema = resolve(schema);
        schema = if key.parse::<usize>().is_ok() {
            &schema["items"]
        } else {
            &schema["properties"][key]
        };
    }
    match description(schema) {
        none if none.is_empty() => {
            "give a number, a list of numbers, or a list of such lists".into()
        }
        meaning => meaning,
    }
}

/// Returns true if a problem is that of a missing key.
pub fn is_missing_key(problem: &Problem) -> bool {
    problem.message.contains(" has no `")
}

fn unknown_message(key: &str, path: &str) -> String {
    match path {
        "" => format!("unknown key `{key}`"),
        _ => format!("unknown key `{key}` in {}", section(path)),
    }
}

fn unknown_help(key: &str, path: &str, known: &[&str]) -> String {
    // A slip of one letter is more likely than the wrong section.
    if let Some(near) = near(key, known)
        && key.len() > 2
        && strsim::damerau_levenshtein(key, near) == 1
    {
        return suggestion(Some(near), "keys here", known);
    }
    // It may be correct but in the wrong section.
    for (name, property) in SCHEMA["properties"].as_object().into_iter().flatten() {
        let resolved = resolve(property);
        let object = match resolved["anyOf"].as_array() {
            Some(choices) => resolve(&choices[0]),
            None if kind_of(resolved) == "array" => resolve(&resolved["items"]),
            None => resolved,
        };
        if name != path && object["properties"].get(key).is_some() {
            let brackets =
                if is_list_of_tables(name) { format!("[[{name}]]") } else { format!("[{name}]") };
            return format!("`{key}` belongs in {brackets}; keys here: {}", known.join(", "));
        }
    }
    if !path.is_empty() && SCHEMA["properties"].get(key).is_some() {
        return format!("`{key}` belongs at the top of the file; keys here: {}", known.join(", "));
    }
    suggestion(near(key, known), "keys here", known)
}

/// Returns "did you mean ...", and all known words.
pub fn nearest(word: &str, known: &[&str]) -> String {
    suggestion(near(word, known), "known", known)
}

fn suggestion(near: Option<&str>, intro: &str, known: &[&str]) -> String {
    const LISTED: usize = 40;
    let mut seen = HashSet::new();
    let known: Vec<&str> = known.iter().copied().filter(|word| seen.insert(*word)).collect();
    let mut all = known.iter().take(LISTED).copied().collect::<Vec<_>>().join(", ");
    if known.len() > LISTED {
        all += &format!(" and {} more", known.len() - LISTED);
    }
    match (near, known.is_empty()) {
        (_, true) => "there is none".into(),
        (Some(near), _) => format!("did you mean `{near}`? {intro}: {all}"),
        (None, _) => format!("{intro}: {all}"),
    }
}

/// Returns the known word that is most similar to this one, if any is similar.
pub fn near<'k>(word: &str, known: &[&'k str]) -> Option<&'k str> {
    let word = word.to_lowercase();
    let score = |k: &str| {
        let k = k.to_lowercase();
        let inside = word.len() > 2 && (k.contains(&word) || (k.len() > 2 && word.contains(&k)));
        let edits = strsim::normalized_damerau_levenshtein(&word, &k);
        if inside { edits.max(0.65) } else { edits.max(strsim::jaro(&word, &k) - 0.15) }
    };
    let (best, near) = known.iter().map(|k| (score(k), *k)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best >= 0.6).then_some(near)
}

/// Returns the name of the table at `path` for messages.
fn section(path: &str) -> String {
    let mut parts = path.split('.');
    let head = parts.next().unwrap_or_default();
    match parts.next() {
        Some(index) if is_list_of_tables(head) => match index.parse::<usize>() {
            Ok(index) => format!("[[{head}]] number {}", index + 1),
            Err(_) => format!("[{path}]"),
        },
        _ => format!("[{path}]"),
    }
}

/// Returns the path of a list from the path of a number in it.
fn list_path(path: &str) -> &str {
    path.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.')
}

fn last(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_words() {
        let known = ["thickness", "hourglass", "hourglass_coefficient", "id"];
        assert_eq!(near("thicknes", &known), Some("thickness"));
        assert_eq!(near("Thickness", &known), Some("thickness"));
        assert_eq!(near("hourglas_coef", &known), Some("hourglass_coefficient"));
        assert_eq!(near("zzz", &known), None);
    }

    #[test]
    fn stand_ins_are_what_the_schema_asks_for() {
        for schema in SCHEMA["$defs"].as_object().unwrap().values() {
            let (mut node, mut findings) = (stand_in(schema, Place::Whole), JobProblems::default());
            walk(&mut node, schema, "", &mut findings);
            assert!(findings.list.is_empty(), "{schema} {findings:?}");
        }
    }

    #[test]
    fn every_default_reads_as_written() {
        let mut tree = Node::parse("end_time = 1\n[mesh]\n").unwrap();
        let mut findings = JobProblems::default();
        job(&mut tree, &mut findings);
        assert!(findings.list.is_empty(), "{findings:?}");
    }
}
