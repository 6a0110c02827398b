//! Jobs and parts of jobs in the manual fit the schema of jobs, and complete ones are read.

use crumple_tests::manual::{blocks, pages};
use crumple_tests::program::root;
use serde_json::Value;
use std::fs;

/// The schema of jobs, without the keys that a job must have: the manual also shows parts of jobs.
fn schema_of_parts() -> Value {
    fn relax(value: &mut Value) {
        match value {
            Value::Object(map) => {
                map.remove("required");
                map.values_mut().for_each(relax);
            }
            Value::Array(list) => list.iter_mut().for_each(relax),
            _ => {}
        }
    }
    let mut schema = crumple::input::reference::schema();
    relax(&mut schema);
    schema
}

fn json(toml: &str) -> Result<Value, String> {
    let value: toml::Value = toml::from_str(toml).map_err(|error| error.to_string())?;
    serde_json::to_value(value).map_err(|error| error.to_string())
}

#[test]
fn jobs_of_the_cases_fit_the_schema() {
    let schema = crumple::input::reference::schema();
    let schema = jsonschema::draft7::new(&schema).expect("a sound schema");
    let (mut seen, mut wrong) = (0, Vec::new());
    for case in fs::read_dir(root().join("cases")).expect("the cases") {
        let path = case.expect("an entry").path().join("job.toml");
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let job = json(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        seen += 1;
        for error in schema.iter_errors(&job) {
            wrong.push(format!("{}: {}: {error}", path.display(), error.instance_path));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 8, "only {seen} jobs found");
}

#[test]
fn examples_of_jobs_fit_the_schema() {
    let schema = jsonschema::draft7::new(&schema_of_parts()).expect("a sound schema");
    let (mut seen, mut wrong) = (0, Vec::new());
    for page in pages("docs") {
        for block in blocks(&page).into_iter().filter(|block| block.language == "toml") {
            let place = format!("{page}:{}", block.line);
            let job = json(&block.text).unwrap_or_else(|error| panic!("{place}: {error}"));
            if job.get("series").is_some() {
                continue; // a study
            }
            let law = job["material"][0]["law"].as_str().unwrap_or_default();
            if ["ludwik", "maxwell"].contains(&law) {
                continue; // a law that the page adds: `added_laws/main.rs`
            }
            seen += 1;
            for error in schema.iter_errors(&job) {
                wrong.push(format!("{place}: {}: {error}", error.instance_path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 15, "only {seen} examples of jobs found");
}

/// The set by rule and the material of the library that the guide shows, in its complete job.
#[test]
fn sets_and_library_of_the_guide_are_read() {
    let blocks = blocks("docs/guide/jobs.md");
    let toml = || blocks.iter().filter(|block| block.language == "toml").map(|block| &block.text);
    let having = |word: &str| toml().find(|text| text.contains(word)).expect("an example");
    let text = [toml().next().unwrap(), having("[[set]]"), having("use = \"")].map(String::as_str);
    let model = crumple::input::job::read_text("job.toml".into(), text.concat(), &[]);
    let model = model.unwrap_or_else(|report| panic!("{report}"));
    let clamped: Vec<u64> = model.mesh.node_sets["clamped"].iter().map(|id| id.0).collect();
    assert_eq!(clamped, [1, 4]);
    let rail = model.job.material.iter().find(|m| m.name == "rail").unwrap();
    assert_eq!((rail.law.as_str(), rail.density), ("j2", 7.86e-6));
    assert_eq!(rail.parameters["poisson"].as_float(), Some(0.3));
}

#[test]
fn the_complete_job_of_the_guide_is_read() {
    let page = "docs/guide/jobs.md";
    let complete = blocks(page).into_iter().find(|block| block.language == "toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    let model = crumple::input::job::read_text(path, complete.text, &[]);
    let model = model.unwrap_or_else(|report| panic!("{page}: {report}"));
    let warnings: Vec<String> = model.warnings.iter().map(|w| format!("{w:?}")).collect();
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// The finished jobs of the tutorials are the examples of `crumple init`.
#[test]
fn finished_jobs_of_the_tutorials_are_examples() {
    let pages = [("gmsh-mesh", "gmsh-sphere"), ("abaqus-mesh", "abaqus-beam")];
    for (page, name) in pages {
        let page = format!("docs/tutorials/{page}.md");
        let example = crumple_cases::EXAMPLES.iter().find(|example| example.name == name).unwrap();
        let shown = blocks(&page).into_iter().find(|block| block.language == "toml").unwrap();
        assert_eq!(shown.text, example.job, "{page}");
    }
}

/// The schema for editors allows a rule where a key names a node set.
#[test]
fn a_rule_in_the_place_of_a_set_fits_the_schema() {
    let schema = jsonschema::draft7::new(&schema_of_parts()).expect("a sound schema");
    let errors = |row: &crumple::input::job::node_sets::SetKey, value: &str| {
        let job = json(&format!("[[{}]]\n{} = {value}\n", row.list, row.key)).unwrap();
        schema.iter_errors(&job).map(|error| error.to_string()).collect::<Vec<_>>()
    };
    for row in crumple::input::job::node_sets::SET_KEYS {
        let nested = "{ rule = \"union\", sets = [\"a\", { rule = \"nodes\", ids = [1] }] }";
        for value in ["\"a\"", nested] {
            assert_eq!(errors(row, value), Vec::<String>::new(), "{}.{}", row.list, row.key);
        }
        assert!(!errors(row, "{ rule = \"plain\" }").is_empty(), "{}.{}", row.list, row.key);
    }
}
