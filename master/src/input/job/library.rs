//! Library of materials: `use = "NAME"` in a `[[material]]`, and `crumple materials`.
//!
//! The data file has values in SI units with their sources. They are converted to the units of the
//! job and added to the entry before its keys are checked; keys of the job win.

use super::tree::{Entry, Node, NodeContent, Place};
use super::units::{Units, read};
use super::validate::{JobProblems, nearest};
use crate::cli::MaterialsArgs;
use crate::stdout;
use crumple_proto::problem::Problem;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

static LIBRARY: LazyLock<MaterialLibrary> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../assets/materials.toml"))
        .expect("the data file is read by a test")
});

/// Powers of length, time and mass.
type Powers = [i32; 3];

const NUMBER: Powers = [0, 0, 0];
const STRESS: Powers = [-1, -2, 1];
const RATE: Powers = [0, -1, 0];

/// Keys of the library: the dimension of their number, or those of the columns of their list.
/// Temperatures are in K in all units.
const KEYS: [(&str, &[Powers]); 16] = [
    ("density", &[[-3, 0, 1]]),
    ("youngs_modulus", &[STRESS]),
    ("poisson", &[NUMBER]),
    ("yield_stress", &[STRESS]),
    ("hardening_modulus", &[STRESS]),
    ("hardening", &[NUMBER, STRESS]),
    ("cowper_symonds", &[RATE, NUMBER]),
    ("a", &[STRESS]),
    ("b", &[STRESS]),
    ("n", &[NUMBER]),
    ("c", &[NUMBER]),
    ("m", &[NUMBER]),
    ("reference_rate", &[RATE]),
    ("reference_temperature", &[NUMBER]),
    ("melting_temperature", &[NUMBER]),
    ("specific_heat", &[[2, -2, 0]]),
];
/// Keys that every law has.
const ELASTIC: [&str; 3] = ["density", "youngs_modulus", "poisson"];
/// Keys that give the yield stress in two ways; a job that gives one of them replaces all.
const YIELD: [&str; 3] = ["yield_stress", "hardening_modulus", "hardening"];

/// The data file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialLibrary {
    /// Publications by their names.
    source: BTreeMap<String, String>,
    material: Vec<LibraryMaterial>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LibraryMaterial {
    name: String,
    /// State or grade of the material, empty if the name says all.
    about: String,
    law: String,
    values: BTreeMap<String, SourcedValue>,
}

/// A value with its source.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SourcedValue {
    /// A number, a list, or a list of lists, in SI units.
    value: toml::Value,
    /// Name of a publication.
    source: String,
    /// Row of the publication, or how the value is derived from it.
    #[serde(default)]
    how: String,
}

/// Adds the values of the library to all materials of a job with the key `use`.
pub fn expand(tree: &mut Node, findings: &mut JobProblems) {
    let units = match tree.get("units").map(|node| &node.kind) {
        Some(NodeContent::String(text)) => read(text),
        _ => None,
    };
    let NodeContent::Table(entries) = &mut tree.kind else { return };
    let materials = entries.get_mut("material").map(|entry| &mut entry.node.kind);
    let Some(NodeContent::Array(materials)) = materials else { return };
    for (i, material) in materials.iter_mut().enumerate() {
        let Some(Node { kind: NodeContent::String(name), place }) = material.get("use") else {
            continue;
        };
        let (name, place) = (name.clone(), *place);
        let known = find(&name);
        let mut error = |message: String, help: String| {
            let problem = Problem::error(format!("material.{i}.use"), message, help);
            findings.add_faulty(problem, Some(place));
        };
        if let Err(nearest) = &known {
            let help = format!("{nearest}; `crumple materials` lists them");
            error(format!("the library has no material `{name}`"), help);
        } else if units.is_none() {
            let message = format!("the values of `{name}` need the units of the job");
            let help = "name length, time and mass in `units`, such as units = \"mm, ms, kg\"";
            error(message, help.into());
        }
        // After an error, later stages need some values.
        let values = known.unwrap_or(&LIBRARY.material[0]);
        add(material, values, &units.unwrap_or(Units::SI), place);
    }
}

/// Returns the material with this name, or advice.
fn find(name: &str) -> Result<&'static LibraryMaterial, String> {
    let names: Vec<&str> = LIBRARY.material.iter().map(|m| m.name.as_str()).collect();
    LIBRARY.material.iter().find(|m| m.name == name).ok_or_else(|| nearest(name, &names))
}

/// Adds the law and the values that a material of a job does not have. If it has another law, adds
/// only those that every law has.
fn add(material: &mut Node, values: &LibraryMaterial, units: &Units, place: Place) {
    let NodeContent::Table(entries) = &mut material.kind else { return };
    let law = entries.get("law").map(|entry| &entry.node.kind);
    let other_law =
        law.is_some_and(|kind| !matches!(kind, NodeContent::String(law) if *law == values.law));
    let own_yield = YIELD.iter().any(|key| entries.contains_key(*key));
    let is_taken = |key: &str| match key {
        _ if other_law && !ELASTIC.contains(&key) => false,
        _ => !(own_yield && YIELD.contains(&key)),
    };
    let law = ("law".to_string(), toml::Value::from(values.law.as_str()));
    let keys = values.values.iter().filter(|(key, _)| is_taken(key));
    let keys = keys.map(|(key, value)| (key.clone(), converted(key, &value.value, units)));
    for (key, value) in keys.chain([law]) {
        if let Some(node) = Node::parse_value(&value.to_string(), place) {
            entries.entry(key).or_insert(Entry { key: place, node });
        }
    }
}

/// Returns a value of the library in other units.
fn converted(key: &str, value: &toml::Value, units: &Units) -> toml::Value {
    let columns = KEYS.iter().find(|(known, _)| *known == key).map_or(&[][..], |(_, all)| all);
    let number = |value: &toml::Value, powers: &Powers| {
        let si = value.as_float().or(value.as_integer().map(|i| i as f64)).unwrap_or(f64::NAN);
        toml::Value::Float(rounded(si / units.factor(*powers)))
    };
    let row = |items: &Vec<toml::Value>| {
        let items = items.iter().zip(columns).map(|(item, powers)| number(item, powers));
        toml::Value::Array(items.collect())
    };
    match value.as_array() {
        None => number(value, columns.first().unwrap_or(&NUMBER)),
        Some(rows) if rows.first().is_some_and(toml::Value::is_array) => {
            toml::Value::Array(rows.iter().filter_map(toml::Value::as_array).map(row).collect())
        }
        Some(items) => row(items),
    }
}

/// Returns a number with 12 digits, without the round-off of the conversion.
fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// `crumple materials`: prints materials with the sources of their values, and returns the exit
/// code.
pub fn run(args: &MaterialsArgs) -> u8 {
    stdout::ended(list(args))
}

/// Returns the text of the command.
///
/// # Errors
/// There is no such material, or the units cannot be read.
fn list(args: &MaterialsArgs) -> Result<String, String> {
    let Some(units) = read(&args.units) else {
        return Err(format!(
            "`{}` does not name units of length, time and mass; write them as \"mm, ms, kg\"",
            args.units
        ));
    };
    let chosen: Vec<&LibraryMaterial> = match &args.material {
        None => LIBRARY.material.iter().collect(),
        Some(name) => {
            let known = find(name);
            vec![known.map_err(|near| format!("the library has no material `{name}`; {near}"))?]
        }
    };
    let mut text = String::new();
    for material in &chosen {
        let about = if material.about.is_empty() { "" } else { ": " };
        text += &format!("# {}{about}{}\n", material.name, material.about);
        text += &format!("[[material]]\nname = \"{0}\"\nuse = \"{0}\"\n", material.name);
        text += &format!("# law = \"{}\"\n", material.law);
        for (key, value) in &material.values {
            let how = if value.how.is_empty() { "" } else { ", " };
            let number = converted(key, &value.value, &units);
            text += &format!("# {key} = {number}    [{}{how}{}]\n", value.source, value.how);
        }
        text.push('\n');
    }
    let used: BTreeSet<&str> =
        chosen.iter().flat_map(|m| m.values.values()).map(|value| value.source.as_str()).collect();
    text += &format!("# Units: {}, K. Sources:\n", args.units);
    let cited = LIBRARY.source.iter().filter(|(name, _)| used.contains(name.as_str()));
    text.extend(cited.map(|(name, publication)| format!("# [{name}] {publication}\n")));
    Ok(text.trim_end().to_string())
}

#[cfg(test)]
mod tests {
    use super::super::read_text;
    use super::*;

    fn job(units: &str, material: &str) -> String {
        format!(
            "units = \"{units}\"\nend_time = 1.0\n[mesh]\n\
             nodes = [[1, 0.0, 0.0, 0.0], [2, 1.0, 0.0, 0.0], [3, 0.0, 1.0, 0.0]]\n\
             shells = [[1, 1, 1, 2, 3]]\n[[part]]\nid = 1\nmaterial = \"x\"\nthickness = 0.1\n\
             [[material]]\nname = \"x\"\n{material}"
        )
    }

    fn parameters(units: &str, material: &str) -> toml::Table {
        let text = job(units, material);
        let model = read_text("library.toml".into(), text, &[]).unwrap_or_else(|r| panic!("{r}"));
        let material = &model.job.material[0];
        let mut all: toml::Table = material.parameters.clone().into_iter().collect();
        all.insert("density".into(), material.density.into());
        all.insert("law".into(), material.law.clone().into());
        all
    }

    /// Every value has a dimension and a source, every source is used, names are unique, and every
    /// material builds its law in every system of units.
    #[test]
    fn the_data_file_is_complete() {
        let library = &*LIBRARY;
        assert!(library.material.len() >= 12, "{}", library.material.len());
        let names: BTreeSet<&str> = library.material.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names.len(), library.material.len());
        let mut used = BTreeSet::new();
        for material in &library.material {
            for (key, value) in &material.values {
                assert!(KEYS.iter().any(|(known, _)| known == key), "{}: {key}", material.name);
                assert!(library.source.contains_key(&value.source), "{}: {key}", material.name);
                used.insert(value.source.as_str());
            }
            for units in ["mm, ms, kg", "m, s, kg", "mm, s, t", "in, s, kg"] {
                parameters(units, &format!("use = \"{}\"", material.name));
            }
        }
        assert_eq!(used.len(), library.source.len(), "{used:?}");
    }

    /// Values of copper after Johnson and Cook (1983) in mm, ms, kg: GPa, 1/ms, and mm^2/(ms^2 K),
    /// which is J/(kg K).
    #[test]
    fn values_are_in_the_units_of_the_job() {
        let of = |all: &toml::Table, key: &str| all[key].as_float().unwrap();
        let all = parameters("mm, ms, kg", "use = \"copper OFHC\"");
        let wanted = [
            ("density", 8.96e-6),
            ("youngs_modulus", 130.0),
            ("a", 0.09),
            ("b", 0.292),
            ("n", 0.31),
            ("reference_rate", 0.001),
            ("specific_heat", 383.0),
            ("melting_temperature", 1356.0),
        ];
        for (key, value) in wanted {
            assert_eq!(of(&all, key), value, "{key}");
        }
        let tonnes = parameters("t, mm, s", "use = \"copper OFHC\"");
        assert_eq!([of(&tonnes, "density"), of(&tonnes, "a")], [8.96e-9, 90.0]);
        let steel = parameters("mm, ms, kg", "use = \"steel mild\"");
        assert_eq!(steel["cowper_symonds"], toml::Value::from(vec![0.0404, 5.0]));
        assert_eq!(steel["hardening"][0], toml::Value::from(vec![0.0, 0.21]));
    }

    #[test]
    fn keys_of_the_job_win() {
        let all = parameters("m, s, kg", "use = \"steel mild\"\nyield_stress = 3e8\npoisson = 0.3");
        assert_eq!(
            (all["yield_stress"].as_float(), all["poisson"].as_float()),
            (Some(3e8), Some(0.3))
        );
        assert!(!all.contains_key("hardening"), "replaced by the yield stress of the job");
        let all = parameters("m, s, kg", "use = \"copper OFHC\"\nlaw = \"elastic\"");
        let keys: BTreeSet<&str> = all.keys().map(String::as_str).collect();
        assert_eq!(keys, BTreeSet::from(["density", "law", "poisson", "youngs_modulus"]));
    }

    #[test]
    fn errors_name_the_material_and_the_remedy() {
        for (units, material, said) in [
            ("mm, ms, kg", "use = \"steel DP60\"", "did you mean `steel DP600`"),
            ("mm, ms, kg", "use = \"steel DP60\"", "the library has no material `steel DP60`"),
            ("SI", "use = \"steel mild\"", "need the units of the job"),
            ("mm, ms, kg", "use = 3", "`use` has to be text in quotes"),
            ("mm, ms, kg", "use = \"PMMA\"\nhardening = [[0.0, 1.0]]", "hardening"),
        ] {
            let report = read_text("library.toml".into(), job(units, material), &[]);
            let report = report.map(|_| ()).unwrap_err().to_string();
            assert!(report.contains(said), "{said}: {report}");
        }
        let report = read_text("library.toml".into(), job("SI", "use = \"steel mild\""), &[]);
        assert_eq!(report.map(|_| ()).unwrap_err().errors(), 1, "no error but that of the units");
    }

    #[test]
    fn the_command_prints_values_and_sources() {
        let args = |material: Option<&str>, units: &str| MaterialsArgs {
            material: material.map(String::from),
            units: units.into(),
        };
        let text = list(&args(Some("iron Armco"), "mm, ms, kg")).unwrap();
        assert!(text.contains("# a = 0.175    [jc1983]"), "{text}");
        assert!(text.contains("[jc1983] G. R. Johnson and W. H. Cook"), "{text}");
        assert!(!text.contains("[eos]"), "sources of other materials: {text}");
        assert!(list(&args(None, "m, s, kg")).unwrap().matches("[[material]]").count() >= 12);
        assert!(list(&args(Some("iron"), "m, s, kg")).unwrap_err().contains("no material `iron`"));
        assert!(list(&args(None, "SI")).unwrap_err().contains("does not name units"));
    }
}
