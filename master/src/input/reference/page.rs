//! Reference page of jobs: every key with type, dimension, default and meaning.

use super::{INLINE_SET, schema};
use crumple_cases::GENERATORS;
use crumple_worker::contact::enforce::CONTACT_LAWS;
use crumple_worker::fem::elements::ELEMENTS;
use crumple_worker::fem::materials::{DIEM, ELASTIC, EQUATION_OF_STATE, EROSION, GISSMO, LAWS};
use crumple_worker::parameter::{DefaultValue, Form, ParameterRow};
use serde_json::Value;
use std::fmt::Write;

/// Words of which dimensions consist.
const DIMENSIONS: [&str; 6] = ["length", "time", "mass", "force", "energy", "temperature"];

const INTRODUCTION: &str = "\
# Job reference

Every key of a job file. The program generates this page from the types of a job and from its
tables of laws, elements and generators: `crumple schema --reference > cases/REFERENCE.md`. A test
compares this file with the output of the program.

The engine is unit-free: all numbers of a job are in one consistent set of units. The dimension `-`
marks a pure number. A job has a table `[name]` at most once, and may have a table `[[name]]`
several times. A *required* key has no default and must be in its table.

Editors know these keys too, see [the README](../README.md#job-files-in-an-editor).
";

/// Returns the whole page.
pub fn page() -> String {
    let schema = schema();
    let mut page = Page { schema: &schema, text: INTRODUCTION.to_string(), open: Vec::new() };
    page.table("", &schema);
    page.text
}

struct Page<'s> {
    schema: &'s Value,
    text: String,
    /// Types whose tables are being written. A table may have itself as a subtable.
    open: Vec<String>,
}

impl Page<'_> {
    /// Writes a table of keys and its subtables. `name` is the heading, in brackets.
    fn table(&mut self, name: &str, table: &Value) {
        let properties = table["properties"].as_object().into_iter().flatten();
        let needed =
            |key: &str| table["required"].as_array().is_some_and(|r| r.iter().any(|k| k == key));
        let (tables, mut keys): (Vec<_>, Vec<_>) =
            properties.partition(|(_, p)| self.inner(p).is_some());
        keys.sort_by_key(|(key, _)| (!needed(key), key.as_str()));
        if !keys.is_empty() {
            self.head(&["key", "type", "dimension", "default", "meaning"]);
        }
        for (key, property) in keys {
            let (meaning, dimension) = split(&self.description(property));
            let numeric = self.is_numeric(property);
            let dimension =
                dimension.unwrap_or_else(|| if numeric { "-".into() } else { String::new() });
            let default =
                if needed(key) { "*required*".into() } else { default(&property["default"]) };
            self.row(&[&format!("`{key}`"), &self.form(property), &dimension, &default, &meaning]);
        }
        for (key, property) in tables {
            let Some((inner, many)) = self.inner(property) else { continue };
            let inner = inner.clone();
            let path = if name.is_empty() {
                key.clone()
            } else {
                format!("{}.{key}", name.trim_matches(['[', ']']))
            };
            let heading = if many { format!("[[{path}]]") } else { format!("[{path}]") };
            let mut meaning = self.description(property);
            let of_type = self.description(&inner);
            if of_type != meaning {
                meaning = format!("{meaning}\n\n{of_type}").trim().to_string();
            }
            let _ = write!(self.text, "\n## `{heading}`\n\n{meaning}\n");
            if key == "scene" {
                self.generators();
                continue;
            }
            self.open.extend(self.type_name(property).map(String::from));
            self.table(&heading, &inner);
            if self.type_name(property).is_some() {
                self.open.pop();
            }
            match key.as_str() {
                "material" => self.laws(),
                "part" => self.elements(),
                "contact" => self.contact_laws(),
                _ => {}
            }
        }
    }

    /// Returns the table that a property holds, and true if it may appear several times.
    fn inner<'a>(&'a self, property: &'a Value) -> Option<(&'a Value, bool)> {
        let is_open = |name| name == INLINE_SET || self.open.iter().any(|open| open == name);
        if self.type_name(property).is_some_and(is_open) {
            return None;
        }
        let resolved = self.resolve(property);
        if resolved["type"] == "array" {
            let items = self.resolve(&resolved["items"]);
            return items["properties"].is_object().then_some((items, true));
        }
        if let Some(choices) = resolved["anyOf"].as_array() {
            return choices.iter().find_map(|c| self.inner(c));
        }
        let free = resolved["type"] == "object" && resolved["additionalProperties"] == true;
        (free || resolved["properties"].is_object()).then_some((resolved, false))
    }

    /// Returns the name of the type of a property, of its items or of its choices.
    fn type_name<'a>(&'a self, property: &'a Value) -> Option<&'a str> {
        let choices = property["anyOf"].as_array().into_iter().flatten();
        let all = [property, &property["items"]].into_iter().chain(choices);
        all.filter_map(|one| one["$ref"].as_str()).find_map(|r| r.strip_prefix("#/$defs/"))
    }

    fn resolve<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
            Some(name) => &self.schema["$defs"][name],
            None => schema,
        }
    }

    /// Returns the description at the place of use, otherwise that of the type.
    fn description(&self, property: &Value) -> String {
        let of_type = || self.resolve(property)["description"].as_str();
        property["description"].as_str().or_else(of_type).unwrap_or_default().replace('\n', " ")
    }

    fn is_numeric(&self, property: &Value) -> bool {
        let resolved = self.resolve(property);
        let kind = |k: &Value| k == "number";
        match &resolved["type"] {
            Value::Array(kinds) => kinds.iter().any(kind),
            one => kind(one),
        }
    }

    /// Returns the form of the values of a property.
    fn form(&self, property: &Value) -> String {
        if self.type_name(property) == Some(INLINE_SET) && property["anyOf"].is_null() {
            return "rule".into();
        }
        let resolved = self.resolve(property);
        let choices = ["enum", "oneOf"].iter().find_map(|k| resolved[*k].as_array());
        if let Some(choices) = choices {
            let word = |c: &Value| c.as_str().or(c["const"].as_str()).map(|w| format!("`\"{w}\"`"));
            return choices.iter().filter_map(word).collect::<Vec<_>>().join(", ");
        }
        if let Some(choices) = resolved["anyOf"].as_array() {
            let forms: Vec<String> =
                choices.iter().filter(|c| c["type"] != "null").map(|c| self.form(c)).collect();
            return forms.join(" or ");
        }
        let kind = match &resolved["type"] {
            Value::Array(kinds) => kinds.iter().find(|k| *k != "null").unwrap_or(&Value::Null),
            one => one,
        };
        match kind.as_str().unwrap_or_default() {
            "number" => "number".into(),
            "integer" => "whole number".into(),
            "string" => "text".into(),
            "boolean" => "true or false".into(),
            "object" if resolved["properties"].is_object() => "table".into(),
            "object" => format!("table of: {}", self.form(&resolved["additionalProperties"])),
            "array" => {
                let items = match self.form(&resolved["items"]).as_str() {
                    one @ ("number" | "whole number" | "text") => format!("{one}s"),
                    "text or rule" => "texts or rules".to_string(),
                    "whole number or text" => "whole numbers or texts".to_string(),
                    list => match list.strip_prefix("list of ") {
                        Some(items) => format!("lists of {items}"),
                        None => format!("lists of {list}"),
                    },
                };
                match (resolved["minItems"].as_u64(), resolved["maxItems"].as_u64()) {
                    (Some(n), Some(most)) if n == most => format!("{n} {items}"),
                    _ => format!("list of {items}"),
                }
            }
            _ => "any".into(),
        }
    }

    fn laws(&mut self) {
        let own: Vec<&str> = LAWS
            .iter()
            .filter(|law| law.constants.len() < ELASTIC.len())
            .map(|law| law.name)
            .collect();
        let except =
            if own.is_empty() { String::new() } else { format!(" except `{}`", own.join("`, `")) };
        let _ = write!(self.text, "\nEvery law{except} has these keys:\n\n");
        self.parameters(ELASTIC);
        self.text += "\nEvery law can have these criteria of failure:\n\n";
        self.parameters(EROSION);
        self.text += "\nLaws with plastic flow can have damage:\n\n";
        self.parameters(GISSMO);
        self.text += "\nor damage from an onset on:\n\n";
        self.parameters(DIEM);
        self.text += "\nMaterials of solids can have an equation of state:\n\n";
        self.parameters(EQUATION_OF_STATE);
        for law in LAWS.iter() {
            let only = law.only_for().map_or(String::new(), |only| format!(" For {only} only."));
            let _ = write!(self.text, "\n### `law = \"{}\"`\n\n{}{only}\n", law.name, law.meaning);
            let own = if law.constants.len() < ELASTIC.len() { law.constants } else { &[] };
            let rows: Vec<ParameterRow> = own.iter().chain(law.parameters).copied().collect();
            if !rows.is_empty() {
                self.text.push('\n');
                self.parameters(&rows);
            }
        }
    }

    fn parameters(&mut self, rows: &[ParameterRow]) {
        self.columns(&["key", "type", "dimension", "default", "meaning"]);
        for row in rows {
            let (meaning, dimension) = split(row.meaning);
            let dimension = dimension.unwrap_or_else(|| "-".into());
            let default = match row.otherwise {
                DefaultValue::Needed => "*required*".into(),
                DefaultValue::Absent => "none".into(),
                DefaultValue::Number(n) => n.to_string(),
                DefaultValue::Whole(n) => n.to_string(),
                DefaultValue::Flag(flag) => flag.to_string(),
                DefaultValue::Word(word) => format!("`\"{word}\"`"),
                DefaultValue::Numbers(list) => format!("`{list:?}`"),
                DefaultValue::Depends(words) => words.into(),
            };
            let form = match row.form {
                Form::Number => "number".into(),
                Form::Whole => "whole number".into(),
                Form::Flag => "true or false".into(),
                Form::Word(words) => {
                    words.iter().map(|w| format!("`\"{w}\"`")).collect::<Vec<_>>().join(", ")
                }
                Form::Numbers(count) => format!("{count} numbers"),
                Form::List(form) => format!("`{form}`"),
            };
            self.row(&[&format!("`{}`", row.key), &form, &dimension, &default, &meaning]);
        }
    }

    fn elements(&mut self) {
        self.head(&["`element`", "shape", "its keys", "meaning"]);
        for row in ELEMENTS {
            let shape = format!("{} nodes", row.shape.corners());
            let keys: Vec<String> = row.keys().map(|row| format!("`{}`", row.key)).collect();
            self.row(&[&format!("`{}`", row.name), &shape, &keys.join(", "), row.meaning]);
        }
    }

    fn contact_laws(&mut self) {
        self.head(&["`law`", "its keys", "meaning"]);
        for row in CONTACT_LAWS.iter() {
            let keys: Vec<String> = row.keys().map(|p| format!("`{}`", p.key)).collect();
            self.row(&[&format!("`{}`", row.name), &keys.join(", "), row.meaning]);
        }
    }

    fn generators(&mut self) {
        for generator in GENERATORS {
            let _ = write!(self.text, "\n### `mesh.generator = \"{}\"`\n", generator.name);
            if generator.options.is_empty() {
                let _ = write!(self.text, "\nIt has no options.\n");
            } else {
                self.head(&["option", "default", "meaning"]);
                for (key, default, meaning) in generator.options {
                    self.row(&[&format!("`{key}`"), &default.to_string(), meaning]);
                }
            }
            self.sets(generator.name);
        }
    }

    /// Writes the node sets of a generator, with their sizes for its default options.
    fn sets(&mut self, generator: &str) {
        let Ok(mesh) = crumple_cases::generate(generator, &toml::Table::new()) else { return };
        let count = |(name, nodes): (&String, &Vec<_>)| format!("`{name}` ({})", nodes.len());
        let sets: Vec<String> = mesh.node_sets.iter().map(count).collect();
        if !sets.is_empty() {
            let _ = write!(
                self.text,
                "\nNode sets, with their number of nodes by default: {}.\n",
                sets.join(", ")
            );
        }
    }

    fn head(&mut self, names: &[&str]) {
        self.text.push('\n');
        self.columns(names);
    }

    fn columns(&mut self, names: &[&str]) {
        self.row(names);
        let _ = writeln!(self.text, "|{}", "---|".repeat(names.len()));
    }

    fn row(&mut self, cells: &[&str]) {
        let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
        let _ = writeln!(self.text, "| {} |", cells.join(" | "));
    }
}

/// Splits a description into the meaning and the dimension. The dimension is a text in brackets
/// that consists only of dimension words.
fn split(meaning: &str) -> (String, Option<String>) {
    let is_dimension = |inside: &str| {
        let mut words =
            inside.split(|c: char| !c.is_alphabetic()).filter(|w| !w.is_empty()).peekable();
        inside == "1"
            || inside.starts_with("1/") && words.clone().all(|w| DIMENSIONS.contains(&w))
            || words.peek().is_some()
                && words.all(|w| DIMENSIONS.contains(&w))
                && !inside.contains(',')
    };
    for (open, _) in meaning.match_indices('[') {
        let Some(length) = meaning[open..].find(']') else { continue };
        let inside = &meaning[open + 1..open + length];
        // Names of lists are in two brackets.
        let is_name = inside.starts_with('[') || meaning[..open].ends_with('[');
        if !is_name && is_dimension(inside) {
            let (before, after) = (meaning[..open].trim_end(), &meaning[open + length + 1..]);
            return (format!("{before}{after}"), Some(inside.to_string()));
        }
    }
    (meaning.to_string(), None)
}

/// Formats a default as in a job file.
fn default(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(s) if s.is_empty() => "none".into(),
        Value::Array(a) if a.is_empty() => "none".into(),
        Value::Object(o) if o.is_empty() => "none".into(),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), |n| n.to_string()),
        Value::String(s) => format!("`\"{s}\"`"),
        Value::Array(_) => format!("`{}`", value.to_string().replace(',', ", ")),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dimensions_are_distinguished_from_other_brackets() {
        let cut = |text: &str| split(text);
        assert_eq!(cut("A length [length]."), ("A length.".into(), Some("length".into())));
        assert_eq!(
            cut("Spin [1/time]; 0 for none."),
            ("Spin; 0 for none.".into(), Some("1/time".into()))
        );
        assert_eq!(cut("E [force/length^2]."), ("E.".into(), Some("force/length^2".into())));
        assert_eq!(
            cut("Nodes as `[id, x, y, z]` [length]."),
            ("Nodes as `[id, x, y, z]`.".into(), Some("length".into()))
        );
        assert_eq!(cut("`[time, factor]` pairs."), ("`[time, factor]` pairs.".into(), None));
        assert_eq!(cut("Two, `[0.06, 1.5]`."), ("Two, `[0.06, 1.5]`.".into(), None));
        assert_eq!(cut("Those of `[[mass]]`."), ("Those of `[[mass]]`.".into(), None));
    }

    /// Every key of every table needs a description; a new key without one fails here.
    #[test]
    fn every_key_has_a_meaning() {
        let page = page();
        let empty: Vec<&str> =
            page.lines().filter(|l| l.starts_with("| `") && l.ends_with("|  |")).collect();
        assert!(empty.is_empty(), "{empty:?}");
        assert!(
            page.contains("## `[[part]]`")
                && page.contains("### `law = \"j2\"`")
                && page.contains("jeep_frame")
        );
    }
}
