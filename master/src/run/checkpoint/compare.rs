//! Changes of the job that a run that continues may have.

use super::MasterState;
use super::find::Resumption;
use super::manifest::Stamp;
use crate::input::job::Model;
use crate::results::warnings::WarningKind;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{MeshSource, Restart};
use crumple_proto::mesh::Shape;
use crumple_proto::message::Changes;
use crumple_proto::partition::ElementRecord;
use crumple_proto::steering::{Change, Steer};
use crumple_worker::checkpoint::layout::{Layout, of_states, of_workers, trace};
use serde_json::Value;
use std::collections::HashSet;

/// Keys that may change, with all keys below them.
const FREE: [&str; 12] = [
    "title",
    "end_time",
    "output",
    "parallel",
    "checkpoint",
    "require",
    "restart",
    "time.max_cycles",
    "time.damping",
    "time.damping_curve",
    "time.dt_max",
    "time.dt_min_ratio",
];
/// Keys below them that may not change: rows are numbered from time 0.
const BOUND: [&str; 1] = ["output.history_interval"];
/// Keys of contact and of its interfaces that may not change: they say which surfaces touch, and at
/// which distance. With others, surfaces would penetrate each other from one step to the next.
const BOUND_CONTACT: [&str; 9] = [
    "edges",
    "beams",
    "parts",
    "against",
    "exclude",
    "thickness",
    "thickness_scale",
    "thickness_limit",
    "shell_offset",
];

/// Returns the job of a model as manifests name it.
pub fn stamp(model: &Model, set: Vec<String>) -> Stamp {
    let mut job = model.job.clone();
    job.mesh = MeshSource::default();
    // Without the bodies and walls that `restart` adds, and their effect on nodes.
    let (bodies, walls) = (job.restart.rigid.len(), job.restart.wall.len());
    job.rigid.truncate(job.rigid.len() - bodies);
    job.wall.truncate(job.wall.len() - walls);
    let (elements, mut nodes) = model.records();
    let added = &model.settings.rigid[model.settings.rigid.len() - bodies..];
    for id in added.iter().flat_map(|body| &body.nodes) {
        if let Ok(i) = nodes.binary_search_by_key(id, |n| n.id) {
            nodes[i].fixed = 0;
        }
    }
    let mut hash = blake3::Hasher::new();
    hash.update(bytemuck::cast_slice(&nodes));
    hash.update(bytemuck::cast_slice(&crumple_proto::wire::encode(&elements)));
    let file = std::fs::canonicalize(&model.path).unwrap_or_else(|_| model.path.clone());
    Stamp {
        file: file.to_string_lossy().into_owned(),
        set,
        job: serde_json::to_value(&job).unwrap_or_default(),
        mesh: hash.finalize().to_hex().to_string(),
        layout: layout(model, &elements),
    }
}

/// Returns the names of all columns and fields in the files of a checkpoint.
fn layout(model: &Model, elements: &[ElementRecord]) -> Layout {
    let mut kinds: Vec<(u32, Shape)> = elements.iter().map(|e| (e.part, e.shape)).collect();
    kinds.sort_unstable_by_key(|&(part, shape)| (part, shape as u8));
    kinds.dedup();
    let mut all = of_workers(&model.settings, kinds);
    all.extend(of_master());
    all
}

fn of_master() -> Layout {
    of_states(|tracer| {
        trace::<MasterState>(tracer);
        trace::<Steer>(tracer);
        trace::<Change>(tracer);
        trace::<WarningKind>(tracer);
    })
}

/// Returns the changes of the model that `new` has in addition to `old`.
///
/// # Errors
/// An old one is missing: a change cannot be taken back.
fn additional(old: &Restart, new: &Restart, parts: &[u32]) -> Result<Changes, String> {
    let missing = old.delete.iter().find(|id| !new.delete.contains(id));
    if let Some(id) = missing {
        return Err(format!("part {id} was deleted: `restart.delete` has to name it again"));
    }
    if !new.rigid.starts_with(&old.rigid) {
        let known = &old.rigid;
        return Err(format!(
            "`restart.rigid` has to begin with the parts of the earlier run, {known:?}"
        ));
    }
    if !new.velocity.starts_with(&old.velocity) {
        let count = old.velocity.len();
        return Err(format!(
            "`restart.velocity` has to begin with the {count} entries of the earlier run; add the \
             new ones after them"
        ));
    }
    if !new.wall.starts_with(&old.wall) {
        let count = old.wall.len();
        return Err(format!(
            "`restart.wall` has to begin with the {count} walls of the earlier run"
        ));
    }
    let index = |id: &u32| Some(parts.iter().position(|part| part == id)? as u32);
    Ok(Changes {
        delete: new.delete.iter().filter(|id| !old.delete.contains(id)).filter_map(index).collect(),
        velocities: new.velocity[old.velocity.len()..]
            .iter()
            .map(|v| (v.parts.iter().filter_map(index).collect(), v.velocity))
            .collect(),
    })
}

/// Checks that a part that is deleted has no tied nodes: their masses are those of others.
fn check_ties(model: &Model, changes: &Changes) -> Result<(), String> {
    let ids: Vec<u32> =
        changes.delete.iter().map(|&i| model.settings.parts[i as usize].id).collect();
    let tied: HashSet<NodeId> = model.settings.ties.iter().map(|t| t.node).collect();
    let held = model.mesh.elements.iter().filter(|e| ids.contains(&e.part)).find_map(|e| {
        let node = e.nodes.iter().find(|&n| tied.contains(n))?;
        Some((e.part, *node))
    });
    held.map_or(Ok(()), |(part, node)| {
        Err(format!("part {part} cannot be deleted: its node {node} is tied to a surface"))
    })
}

/// Returns true for a key of contact, or of one of its interfaces, that may change.
fn is_free_contact(key: &str) -> bool {
    let Some(key) = key.strip_prefix("contact.") else { return false };
    let of_interface = key.strip_prefix("interface.").and_then(|key| key.split_once('.'));
    let own = of_interface.map_or(key, |(_, key)| key);
    own != "interface" && !BOUND_CONTACT.contains(&own)
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
        if !(below(&FREE) || is_free_contact(key)) || below(&BOUND) {
            return Err(format!(
                "`{key}` differs from the job of the checkpoint, and the state depends on it; \
                 these may change: {}; and the keys of contact and its interfaces without {}",
                FREE.join(", "),
                BOUND_CONTACT.join(", ")
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

/// Returns true if one of the texts `key=value` sets `key`, a key below it, or one above it.
fn sets(texts: &[String], key: &str) -> bool {
    let is_below = |a: &str, b: &str| a == b || a.starts_with(&format!("{b}."));
    texts.iter().any(|text| {
        let own = text.split('=').next().unwrap_or(text).trim();
        is_below(own, key) || is_below(key, own)
    })
}

/// Prepares a model for a run that continues, with the `key=value` of its command in `asked`.
/// Returns the changes of its job.
///
/// # Errors
/// A change is not possible; the message says why.
pub fn adapt(
    model: &mut Model,
    new: &Stamp,
    asked: &[String],
    from: &mut Resumption,
) -> Result<Vec<String>, String> {
    let changes = changes(&from.manifest.stamp, new)?;
    let before = from.manifest.stamp.job.get("restart").cloned();
    let before: Restart = before.and_then(|r| serde_json::from_value(r).ok()).unwrap_or_default();
    let parts: Vec<u32> = model.settings.parts.iter().map(|p| p.id).collect();
    from.changes = additional(&before, &model.job.restart, &parts)?;
    check_ties(model, &from.changes)?;
    let (captured, settings) = (&from.manifest.captured, &mut model.settings);
    // Values that orders of users have changed, unless they are changed again, or this command
    // gives them.
    let known = &from.master;
    let is_new = |key: &str| sets(&changes, key) || sets(asked, key);
    if !is_new("end_time") {
        settings.end_time = known.end_time;
    }
    let limits = &mut model.decomposition;
    if !is_new("parallel.imbalance") {
        limits.imbalance = known.imbalance;
    }
    if !is_new("parallel.low_every_at_least") {
        limits.low_every_at_least = known.low_every_at_least;
    }
    if !is_new("output") {
        settings.output = known.output.clone();
    }
    settings.output.rows_from = known.output.rows_from;
    if settings.planned.is_empty() {
        settings.planned = known.planned.clone();
    }
    settings.planned.retain(|p| p.cycle > captured.cycle);
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
    settings.field_times = match is_new("end_time") || is_new("output") {
        false => from.master.field_times.clone(),
        true => old.iter().chain(later).copied().collect(),
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
        (Value::Array(a), Value::Array(b))
            if a.len() == b.len() && a.iter().chain(b).all(Value::is_object) =>
        {
            for (i, (x, y)) in a.iter().zip(b).enumerate() {
                differences(&format!("{at}.{i}"), x, y, found);
            }
        }
        (a, b) if a != b => found.push((at.into(), b.to_string())),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_of_the_master_has_names() {
        let all = of_master();
        assert!(all["MasterState"].contains(&"wall_s: F64".to_string()), "{all:?}");
        assert!(all.contains_key("Course") && all["Steer"].len() == 5, "{:?}", all.keys());
    }

    use crumple_proto::job::PartVelocity;
    use serde_json::json;

    #[test]
    fn a_text_sets_its_key_and_all_above_and_below_it() {
        let texts = ["output={vtkhdf=true}".into(), "time.max_cycles = 5".into()];
        assert!(sets(&texts, "output.field_interval") && sets(&texts, "output"));
        assert!(sets(&texts, "time.max_cycles") && sets(&texts, "time"));
        assert!(!sets(&texts, "time.max") && !sets(&texts, "end_time"));
    }

    /// Entries of earlier continuations have to come first, and are not applied again.
    #[test]
    fn velocities_of_earlier_runs_are_not_set_again() {
        let of = |values: &[f64]| Restart {
            velocity: values
                .iter()
                .map(|&v| PartVelocity { parts: vec![7], velocity: [v, 0.0, 0.0] })
                .collect(),
            ..Restart::default()
        };
        let between = |old: &[f64], new: &[f64]| {
            additional(&of(old), &of(new), &[3, 7]).map(|c| c.velocities)
        };
        assert_eq!(between(&[1.0], &[1.0]), Ok(vec![]));
        assert_eq!(between(&[1.0], &[1.0, 2.0]), Ok(vec![(vec![1], [2.0, 0.0, 0.0])]));
        assert!(between(&[1.0], &[2.0]).unwrap_err().contains("begin with the 1 entries"));
        assert!(between(&[1.0], &[]).is_err());
    }

    #[test]
    fn only_what_the_state_does_not_depend_on_may_change() {
        let of = |job: Value| Stamp { job, ..Stamp::default() };
        let old = of(json!({"end_time": 1.0, "time": {"safety": 0.9, "damping": 0.0},
            "contact": {"law": "penalty", "edges": true,
                "interface": [{"parts": [1], "friction": 0.1}]}}));
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
        let friction = with("/contact/interface/0/friction", json!(0.2));
        assert_eq!(friction, Ok(vec!["contact.interface.0.friction=0.2".into()]));
        for (key, value) in
            [("/contact/interface/0/parts", json!([2])), ("/contact/interface", json!([]))]
        {
            assert!(with(key, value).unwrap_err().contains("`contact.interface"), "{key}");
        }
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
