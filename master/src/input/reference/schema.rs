//! The schema of a job, completed with names of laws, formulations and generators, and with their
//! keys.

use crate::input::job::inline_sets::{KEYS_OF_SETS, LIST_OF_SETS};
use crate::input::job::laws::{ElementKey, contact_keys, element_keys};
use crate::input::job::node_sets::SET_KEYS;
use crumple_cases::GENERATORS;
use crumple_proto::job::{
    ContactInput, Interface, Job, MaterialSpec, MeshSource, Parallel, Part, SetInput,
};
use crumple_proto::mesh::Shape;
use crumple_worker::contact::enforce::CONTACT_LAWS;
use crumple_worker::contact::search::SEARCHES;
use crumple_worker::fem::elements::ELEMENTS;
use crumple_worker::fem::materials::{DIEM, EQUATION_OF_STATE, EROSION, GISSMO, LAWS, Law};
use crumple_worker::parallel::decomposition::BoxDecomposition;
use crumple_worker::parameter::{DefaultValue, Form, ParameterRow};
use schemars::JsonSchema;
use serde_json::{Map, Value, json};

/// The draft that most editors support. The schema needs no later one.
const DRAFT: &str = "http://json-schema.org/draft-07/schema#";

/// Returns the schema against which jobs are read: that of the types of a job, with the keys that
/// contact laws, elements and the decomposition publish.
pub fn job_schema() -> Value {
    let mut schema = Job::schema();
    for (row, laws) in contact_keys() {
        let mut entry = of_key(row);
        let laws: Vec<String> = laws.into_iter().map(|law| format!("`{law}`")).collect();
        entry["description"] = format!("{} Used by {}.", row.meaning, laws.join(", ")).into();
        of_type::<ContactInput>(&mut schema)["properties"][row.key] = entry;
    }
    for row in BoxDecomposition::KEYS {
        of_type::<Parallel>(&mut schema)["properties"][row.key] = of_key(row);
    }
    for key in element_keys() {
        of_type::<Part>(&mut schema)["properties"][key.key] = of_element_key(&key);
    }
    for row in CONTACT_LAWS.iter().flat_map(|law| law.parameters) {
        let mut entry = of_key(row);
        entry["type"] = json!([entry["type"], "null"]);
        entry["default"] = Value::Null;
        entry["description"] = "As in `[contact]`.".into();
        if let Some(Value::Array(words)) = entry.get_mut("enum") {
            words.push(Value::Null);
        }
        of_type::<Interface>(&mut schema)["properties"][row.key] = entry;
    }
    schema
}

/// Returns the schema of a type of a job.
///
/// # Panics
/// The schema has no such type.
fn of_type<T: JsonSchema>(schema: &mut Value) -> &mut Value {
    let name = T::schema_name();
    schema["$defs"].get_mut(&*name).unwrap_or_else(|| panic!("no schema of {name}"))
}

/// Returns the schema of a key of `[[part]]`, with what its formulations say of it.
fn of_element_key(key: &ElementKey) -> Value {
    let (_, first) = key.rows[0];
    let mut entry = of_key(first);
    let names = |rows: &[&'static str]| {
        rows.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    };
    let mut meanings: Vec<(&str, Vec<&'static str>)> = Vec::new();
    let mut defaults: Vec<(String, Vec<&'static str>)> = Vec::new();
    for (element, row) in &key.rows {
        let default = of_key(row)["default"].to_string().replace('"', "`");
        put(&mut meanings, row.meaning, element.name);
        put(&mut defaults, default, element.name);
    }
    let mut text: Vec<String> = meanings
        .iter()
        .map(|(meaning, users)| match meanings.len() {
            1 => format!("{meaning} Used by {}.", names(users)),
            _ => format!("{}: {meaning}", names(users)),
        })
        .collect();
    if defaults.len() > 1 {
        let each = defaults.iter().map(|(value, users)| format!("{value} ({})", names(users)));
        text.push(format!("Default: {}.", each.collect::<Vec<_>>().join(", ")));
        let fields = entry.as_object_mut().expect("a schema is a table");
        fields.remove("default");
    }
    if let (Form::Word(_), Some(entry)) = (first.form, entry.as_object_mut()) {
        entry.retain(|field, _| field == "default");
        let words = key.words().into_iter().map(|word| json!({ "const": word }));
        entry.insert("oneOf".into(), words.collect());
    }
    entry["description"] = text.join(" ").into();
    entry
}

/// Adds a user to the entry with this value; without one, adds an entry.
fn put<T: PartialEq>(list: &mut Vec<(T, Vec<&'static str>)>, value: T, user: &'static str) {
    match list.iter_mut().find(|(known, _)| *known == value) {
        Some((_, users)) => users.push(user),
        None => list.push((value, vec![user])),
    }
}

/// Returns the schema of the values of a key.
fn of_key(row: &ParameterRow) -> Value {
    let mut entry = json!({ "description": row.meaning });
    match row.otherwise {
        DefaultValue::Number(default) => entry["default"] = default.into(),
        DefaultValue::Whole(default) => entry["default"] = default.into(),
        DefaultValue::Flag(default) => entry["default"] = default.into(),
        DefaultValue::Word(default) => entry["default"] = default.into(),
        DefaultValue::Numbers(default) => entry["default"] = default.into(),
        DefaultValue::Needed | DefaultValue::Absent | DefaultValue::Depends(_) => {}
    }
    match row.form {
        Form::Number => entry["type"] = "number".into(),
        Form::Whole => {
            entry["type"] = "integer".into();
            entry["format"] = "uint".into();
            entry["minimum"] = 0.into();
        }
        Form::Flag => entry["type"] = "boolean".into(),
        Form::Word(words) => {
            entry["type"] = "string".into();
            entry["enum"] = words.into();
        }
        Form::Numbers(count) => {
            entry["type"] = "array".into();
            entry["items"] = json!({ "type": "number" });
            (entry["minItems"], entry["maxItems"]) = (count.into(), count.into());
        }
        Form::List(_) => entry["type"] = "array".into(),
    }
    entry
}

/// Returns the JSON Schema of jobs for editors.
pub fn schema() -> Value {
    let mut schema = job_schema();
    schema["$schema"] = DRAFT.into();
    let contact = &mut of_type::<ContactInput>(&mut schema)["properties"];
    words(&mut contact["search"], SEARCHES.iter().map(|s| s.name));
    let laws = || CONTACT_LAWS.iter().map(|l| l.name).chain([ContactInput::NO_LAW]);
    words(&mut contact["law"], laws());
    words(&mut of_type::<Interface>(&mut schema)["properties"]["law"], laws());
    words(
        &mut of_type::<Part>(&mut schema)["properties"]["element"],
        ELEMENTS.iter().filter(|e| e.shape != Shape::Tri3).map(|e| e.name),
    );
    words(
        &mut of_type::<MeshSource>(&mut schema)["properties"]["generator"],
        GENERATORS.iter().map(|g| g.name),
    );
    rules_as_names(&mut schema);
    let material = of_type::<MaterialSpec>(&mut schema);
    words(&mut material["properties"]["law"], LAWS.iter().map(|l| l.name));
    // The library gives the law and its values.
    let needed = material["required"].take();
    let own = json!({ "if": { "not": { "required": ["use"] } }, "then": { "required": needed } });
    let laws = LAWS.iter().map(of_law);
    material["allOf"] = laws.chain([own]).collect();
    material["required"] = json!(["name"]);
    // A deck may have what a job must have.
    let needed = schema["required"].take();
    let from_deck = json!({ "properties": { "mesh": { "required": ["deck"] } } });
    let needed = json!({ "if": from_deck, "else": { "required": needed } });
    schema["allOf"] = GENERATORS.iter().map(of_generator).chain([needed]).collect();
    schema["required"] = json!(["mesh"]);
    schema
}

/// Name of the type of a rule in the place of the name of a set.
pub const INLINE_SET: &str = "InlineSet";

/// Allows a rule where a key names a node set.
fn rules_as_names(schema: &mut Value) {
    let mut rule = of_type::<SetInput>(schema).clone();
    let needed = rule["required"].as_array().into_iter().flatten().filter(|key| *key != "name");
    rule["required"] = needed.cloned().collect();
    schema["$defs"][INLINE_SET] = rule;
    for row in SET_KEYS {
        let place = row.list.split('.').chain([row.key]);
        let pointer = place
            .fold(String::new(), |at, key| format!("{}/properties/{key}", resolved(schema, at)));
        allow_rule(schema.pointer_mut(&pointer));
    }
    for of in [SetInput::schema_name().as_ref(), INLINE_SET] {
        let keys = &mut schema["$defs"][of]["properties"];
        KEYS_OF_SETS.iter().for_each(|key| allow_rule(keys.get_mut(*key)));
        allow_rule(keys.get_mut(LIST_OF_SETS).and_then(|list| list.get_mut("items")));
    }
}

/// Returns the JSON pointer of the table at `pointer`, or of the entries of the list there.
fn resolved(schema: &Value, pointer: String) -> String {
    let mut at = pointer;
    while let Some(here) = schema.pointer(&at) {
        match here["$ref"].as_str() {
            Some(target) => at = target.trim_start_matches('#').to_string(),
            None if here["items"].is_object() => at += "/items",
            None => break,
        }
    }
    at
}

/// Allows a rule besides the name.
///
/// # Panics
/// There is no such property.
fn allow_rule(property: Option<&mut Value>) {
    let property = property.expect("a key that names a set is in the schema");
    let kind = property["type"].take();
    if let Some(table) = property.as_object_mut() {
        table.remove("type");
    }
    property["anyOf"] = json!([{ "type": kind }, { "$ref": format!("#/$defs/{INLINE_SET}") }]);
}

/// Restricts a property to these words, or to null if the key is optional.
fn words(property: &mut Value, allowed: impl Iterator<Item = &'static str>) {
    let mut list: Vec<Value> = allowed.map(Value::from).collect();
    if property["type"].is_array() {
        list.push(Value::Null);
    }
    property["enum"] = list.into();
}

/// Returns the schema of the parameters of a law, for materials with this law.
fn of_law(law: &Law) -> Value {
    let common = || EROSION.iter().chain(GISSMO).chain(DIEM).chain(EQUATION_OF_STATE);
    let all = || law.constants.iter().chain(law.parameters).chain(common());
    let needed: Vec<&str> =
        all().filter(|p| p.otherwise == DefaultValue::Needed).map(|p| p.key).collect();
    let entry = |p: &ParameterRow| (p.key.to_string(), of_key(p));
    let properties: Map<String, Value> = all().map(entry).collect();
    json!({
        "if": { "properties": { "law": { "const": law.name } }, "required": ["law"] },
        "then": {
            "properties": properties,
            "anyOf": [{ "required": ["use"] }, { "required": needed }]
        }
    })
}

/// Returns the schema of the options of a generator, for jobs with this generator.
fn of_generator(generator: &crumple_cases::Generator) -> Value {
    let entry = |&(key, default, meaning): &crumple_cases::OptionRow| {
        (key.to_string(), json!({ "type": "number", "default": default, "description": meaning }))
    };
    let options: Map<String, Value> = generator.options.iter().map(entry).collect();
    json!({
        "if": { "properties": { "mesh": {
            "properties": { "generator": { "const": generator.name } },
            "required": ["generator"]
        } } },
        "then": { "properties": { "scene": {
            "properties": options,
            "additionalProperties": false
        } } }
    })
}
