//! The committed reference of jobs equals the output of the program, and the schema for editors
//! agrees with the reader.

use crumple::input::job::read;
use crumple::input::reference::{page, schema};
use serde_json::Value;
use std::path::Path;

#[test]
fn the_committed_reference_is_current() {
    expect_test::expect_file!["../../cases/REFERENCE.md"].assert_eq(&page());
}

/// The keys that the schema adds to the checks of the reader are those of the tables of the
/// reader: the schema knows every key and word of the shipped jobs.
#[test]
fn the_schema_knows_what_shipped_jobs_say() {
    let schema = schema();
    let branch = |list: &Value, is: &dyn Fn(&Value) -> bool| -> Option<Value> {
        list.as_array()?
            .iter()
            .find(|b| is(&b["if"]["properties"]))
            .map(|b| b["then"]["properties"].clone())
    };
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases");
    let mut seen = 0;
    for folder in std::fs::read_dir(&cases).unwrap() {
        let path = folder.unwrap().path().join("job.toml");
        if !path.is_file() {
            continue;
        }
        seen += 1;
        let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
        for material in &model.job.material {
            let law = |p: &Value| p["law"]["const"] == *material.law;
            let keys = branch(&schema["$defs"]["MaterialSpec"]["allOf"], &law)
                .expect("a law of the table");
            assert!(
                material.parameters.keys().all(|k| keys[k]["description"].is_string()),
                "{}",
                material.name
            );
        }
        if let Some(generator) = &model.job.mesh.generator {
            let named = |p: &Value| p["mesh"]["properties"]["generator"]["const"] == **generator;
            let scene = branch(&schema["allOf"], &named).expect("a generator of the table");
            let keys = &scene["scene"]["properties"];
            assert!(
                model.job.scene.keys().all(|k| keys[k]["description"].is_string()),
                "{}",
                path.display()
            );
        }
        let law = &schema["$defs"]["ContactInput"]["properties"]["law"]["enum"];
        let known = |name: &str| law.as_array().is_some_and(|l| l.iter().any(|w| w == name));
        assert!(model.job.contact.as_ref().is_none_or(|c| known(&c.law)), "{}", path.display());
    }
    assert!(seen > 5, "{seen} jobs");
}
