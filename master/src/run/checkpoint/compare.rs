//! Changes of the job that a run that continues may have.

use super::find::Resumption;
use super::manifest::Stamp;
use crate::input::job::Model;
use crumple_proto::job::MeshSource;
use serde_json::Value;

/// Keys that may change, with all keys below them.
const FREE: [&str; 9] = [
    "title",
    "end_time",
    "output",
    "parallel",
    "checkpoint",
    "time.max_cycles",
    "time.damping",
    "time.dt_max",
    "time.dt_min_ratio",
];
/// Keys below them that may not change: rows are numbered from time 0.
const BOUND: [&str; 1] = ["output.history_interval"];
/// Keys of contact that may not change: the histories of pairs, or the surfaces, depend on them.
const BOUND_CONTACT: [&str; 3] = ["contact.edges", "contact.interface", "contact.parts"];

/// Returns the job of a model as manifests name it.
pub fn stamp(model: &Model, set: Vec<String>) -> Stamp {
    let mut job = model.job.clone();
    job.mesh = MeshSource::default();
    let (elements, nodes) = model.records();
    let mut hash = blake3::Hasher::new();
    hash.update(bytemuck::cast_slice(&nodes));
    hash.update(bytemuck::cast_slice(&crumple_proto::wire::encode(&elements)));
    let file = std::fs::canonicalize(&model.path).unwrap_or_else(|_| model.path.clone());
    Stamp {
        file: file.to_string_lossy().into_owned(),
        set,
        job: serde_json::to_value(&job).unwrap_or_default(),
        mesh: hash.finalize().to_hex().to_string(),
    }
}

/// Returns the changes of a job, as `key=value`.
///
/// # Errors
/// A change is not possible: its key, and the reason.
pub fn changes(old: &Stamp, new: &Stamp) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    differences("", &old.job, &new.job, &mut found);
    for (key, _) in &found {
        let below =
            |list: &[&str]| list.iter().any(|f| key == f || key.starts_with(&format!("{f}.")));
        let contact = key.starts_with("contact.") && !below(&BOUND_CONTACT);
        if (!below(&FREE) && !contact) || below(&BOUND) {
            return Err(format!(
                "`{key}` differs from the job of the checkpoint, and the state depends on it; \
                 these may change: {}, and the law and the numbers of contact",
                FREE.join(", ")
            ));
        }
    }
    if old.mesh != new.mesh {
        return Err("the mesh, its supports or its initial state differ from those of the job of \
                    the checkpoint"
            .into());
    }
    Ok(found.into_iter().map(|(key, value)| format!("{key}={value}")).collect())
}

/// Prepares a model for a run that continues. Returns the changes of its job.
///
/// # Errors
/// A change is not possible; the message says why.
pub fn adapt(model: &mut Model, new: &Stamp, from: &Resumption) -> Result<Vec<String>, String> {
    let changes = changes(&from.manifest.stamp, new)?;
    let (captured, settings) = (&from.manifest.captured, &mut model.settings);
    if settings.end_time <= captured.time {
        return Err(format!(
            "end_time = {:?} is not after the time of the checkpoint, {:?}",
            settings.end_time, captured.time
        ));
    }
    // Defaults are fractions of the end time of the first run; rows keep their interval.
    settings.history_interval = from.master.history_interval;
    let done = (captured.fields as usize).min(from.master.field_times.len());
    let old = &from.master.field_times[..done];
    let later = settings.field_times.iter().filter(|&&t| t > captured.time);
    settings.field_times = match changes.is_empty() {
        true => from.master.field_times.clone(),
        false => old.iter().chain(later).copied().collect(),
    };
    Ok(changes)
}

fn differences(at: &str, old: &Value, new: &Value, found: &mut Vec<(String, String)>) {
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|k| !a.contains_key(*k)));
            for key in keys {
                let path = if at.is_empty() { key.clone() } else { format!("{at}.{key}") };
                let (x, y) = (a.get(key), b.get(key));
                differences(&path, x.unwrap_or(&Value::Null), y.unwrap_or(&Value::Null), found);
            }
        }
        (a, b) if a != b => found.push((at.into(), b.to_string())),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_what_the_state_does_not_depend_on_may_change() {
        let of = |job: Value| Stamp { job, ..Stamp::default() };
        let old = of(json!({"end_time": 1.0, "time": {"safety": 0.9, "damping": 0.0},
            "contact": {"law": "penalty", "edges": true}}));
        let with = |key: &str, value: Value| {
            let mut job = old.job.clone();
            *job.pointer_mut(key).unwrap() = value;
            changes(&old, &of(job))
        };
        assert_eq!(with("/end_time", json!(2.0)), Ok(vec!["end_time=2.0".into()]));
        assert_eq!(with("/time/damping", json!(0.5)), Ok(vec!["time.damping=0.5".into()]));
        assert_eq!(with("/contact/law", json!("soft")), Ok(vec!["contact.law=\"soft\"".into()]));
        assert!(with("/time/safety", json!(0.5)).unwrap_err().contains("`time.safety`"));
        assert!(with("/contact/edges", json!(false)).unwrap_err().contains("`contact.edges`"));
        let none = changes(
            &old,
            &of(json!({"end_time": 1.0, "time": {"safety": 0.9,
            "damping": 0.0}})),
        );
        assert!(none.unwrap_err().contains("`contact`"));
        let other = Stamp { mesh: "x".into(), ..old.clone() };
        assert!(changes(&old, &other).unwrap_err().contains("mesh"));
    }
}
