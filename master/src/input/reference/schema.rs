//! The schema of a job, completed with names of laws, formulations and generators, and with their
//! keys.

use crumple_cases::GENERATORS;
use crumple_proto::job::{Contact, Job};
use crumple_proto::mesh::Shape;
use crumple_worker::contact::enforce::{CONTACT_LAWS, ITERATIONS, PENALTY_FORMS};
use crumple_worker::contact::search::SEARCHES;
use crumple_worker::fem::elements::ELEMENTS;
use crumple_worker::fem::materials::{DefaultValue, ELASTIC, LAWS, ParameterRow};
use serde_json::{Map, Value, json};

/// The draft that most editors support. The schema needs no later one.
const DRAFT: &str = "http://json-schema.org/draft-07/schema#";

/// Returns the JSON Schema of jobs for editors.
pub fn schema() -> Value {
    let mut schema = Job::schema();
    schema["$schema"] = DRAFT.into();
    let defs = &mut schema["$defs"];
    words(&mut defs["Contact"]["properties"]["search"], SEARCHES.iter().map(|s| s.name));
    for of in ["Contact", "Interface"] {
        let contact = &mut defs[of]["properties"];
        words(&mut contact["law"], CONTACT_LAWS.iter().map(|l| l.name).chain([Contact::NO_LAW]));
        words(&mut contact["iteration"], ITERATIONS.iter().map(|i| i.0));
        words(&mut contact["penalty_form"], PENALTY_FORMS.iter().copied());
    }
    words(
        &mut defs["Part"]["properties"]["element"],
        ELEMENTS.iter().filter(|e| e.shape != Shape::Tri3).map(|e| e.name),
    );
    words(&mut defs["MeshSource"]["properties"]["generator"], GENERATORS.iter().map(|g| g.name));
    let material = &mut defs["MaterialSpec"];
    words(&mut material["properties"]["law"], LAWS.iter().map(|l| l.name));
    material["allOf"] = LAWS.iter().map(|law| of_law(law.name, law.parameters)).collect();
    schema["allOf"] = GENERATORS.iter().map(of_generator).collect();
    schema
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
fn of_law(name: &str, parameters: &[ParameterRow]) -> Value {
    let all = || ELASTIC.iter().chain(parameters);
    let needed: Vec<&str> =
        all().filter(|p| p.otherwise == DefaultValue::Needed).map(|p| p.key).collect();
    let entry = |p: &ParameterRow| {
        let mut entry = json!({ "description": p.meaning });
        match p.otherwise {
            DefaultValue::Number(default) => entry["default"] = default.into(),
            DefaultValue::Needed | DefaultValue::Absent | DefaultValue::Depends(_) => {}
        }
        entry["type"] = if p.form == "number" { "number" } else { "array" }.into();
        (p.key.to_string(), entry)
    };
    let properties: Map<String, Value> = all().map(entry).collect();
    json!({
        "if": { "properties": { "law": { "const": name } } },
        "then": { "properties": properties, "required": needed }
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
