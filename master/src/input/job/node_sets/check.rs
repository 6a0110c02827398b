//! Checks of the keys of sets by rule.

use super::super::validate::{JobProblems, nearest};
use super::known_names;
use crumple_proto::job::{Job, SetInput, SetRule};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// Returns the keys that a rule needs, and those that it may have besides `name`, `rule`, `of` and
/// `allow_empty`.
fn keys(rule: SetRule) -> (&'static [&'static str], &'static [&'static str]) {
    match rule {
        SetRule::Part => (&["parts"], &[]),
        SetRule::Nodes => (&["ids"], &[]),
        SetRule::Box => (&["min", "max"], &["tolerance"]),
        SetRule::Sphere => (&["point", "radius"], &["tolerance"]),
        SetRule::Plane | SetRule::HalfSpace => (&["point", "normal"], &["tolerance"]),
        SetRule::Cylinder => (&["point", "axis", "radius"], &["length", "tolerance"]),
        SetRule::Nearest => (&["point"], &["count"]),
        SetRule::FreeEdges | SetRule::Boundary | SetRule::Surface => (&[], &[]),
        SetRule::Within => (&["from", "distance"], &[]),
        SetRule::Union | SetRule::Intersection | SetRule::Difference => (&["sets"], &[]),
    }
}

/// Returns the keys of rules, each with true if the set has it.
fn given(set: &SetInput) -> [(&'static str, bool); 14] {
    [
        ("sets", !set.sets.is_empty()),
        ("parts", !set.parts.is_empty()),
        ("ids", !set.ids.is_empty()),
        ("min", set.min.is_some()),
        ("max", set.max.is_some()),
        ("point", set.point.is_some()),
        ("normal", set.normal.is_some()),
        ("axis", set.axis.is_some()),
        ("radius", set.radius.is_some()),
        ("length", set.length.is_some()),
        ("count", set.count.is_some()),
        ("from", set.from.is_some()),
        ("distance", set.distance.is_some()),
        ("tolerance", set.tolerance.is_some()),
    ]
}

/// Reports the errors of all sets by rule. Returns true for each set without any.
pub fn check(job: &Job, mesh: &Mesh, findings: &mut JobProblems) -> Vec<bool> {
    let check_one = |(i, set): (usize, &SetInput)| {
        let faults = [name(set, i, job, mesh), rule(set), numbers(set), parts(set, job)];
        let faults: Vec<SetFault> = faults.into_iter().flatten().collect();
        let is_valid = faults.is_empty();
        for (key, message, help) in faults {
            let path = if key.is_empty() { format!("set.{i}") } else { format!("set.{i}.{key}") };
            findings.add(Problem::error(path, message, help));
        }
        is_valid
    };
    job.set.iter().enumerate().map(check_one).collect()
}

/// Faulty key (empty for the whole set), message, advice.
type SetFault = (String, String, String);

fn name(set: &SetInput, i: usize, job: &Job, mesh: &Mesh) -> Vec<SetFault> {
    let fault = |message: String, help: &str| vec![("name".into(), message, help.into())];
    if set.name.is_empty() {
        return fault("a set has no name".into(), "give it a name: other keys refer to it by name");
    }
    if job.set[..i].iter().any(|other| other.name == set.name) {
        let message = format!("two entries of [[set]] have the name `{}`", set.name);
        return fault(message, "give each its own name");
    }
    if known_names(job, mesh).any(|known| known == set.name) {
        let kind = match &set.name {
            name if mesh.node_sets.contains_key(name) => "a node set of the mesh",
            name if job.part.iter().any(|p| p.name == *name) => "a part",
            _ => "a rigid body",
        };
        let message = format!("`{}` is a set by rule and {kind}", set.name);
        return fault(message, "give the set another name");
    }
    Vec::new()
}

/// Finds missing keys, and keys of other rules.
fn rule(set: &SetInput) -> Vec<SetFault> {
    let (needed, allowed) = keys(set.rule);
    let listed = |keys: &[&str]| {
        let keys: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
        if keys.is_empty() { "no keys".into() } else { keys.join(", ") }
    };
    let help = match allowed {
        [] => format!("its rule has {}", listed(needed)),
        _ => format!("its rule has {}, and may have {}", listed(needed), listed(allowed)),
    };
    let mut faults = Vec::new();
    for (key, is_given) in given(set) {
        if needed.contains(&key) && !is_given {
            let message = format!("set `{}` has no `{key}`", set.name);
            faults.push((String::new(), message, help.clone()));
        } else if is_given && !needed.contains(&key) && !allowed.contains(&key) {
            let message = format!("the rule of set `{}` has no `{key}`", set.name);
            faults.push((key.into(), message, help.clone()));
        }
    }
    faults
}

/// Finds numbers out of range.
fn numbers(set: &SetInput) -> Vec<SetFault> {
    let mut faults = Vec::new();
    let mut need = |fits: bool, key: &str, value: String, wanted: &str| {
        if !fits {
            let message = format!("set `{}`: `{key}` is {value}", set.name);
            faults.push((key.into(), message, format!("it has to be {wanted}")));
        }
    };
    let of = |value: Option<f64>| format!("{:?}", value.unwrap_or_default());
    need(set.radius.is_none_or(|r| r > 0.0), "radius", of(set.radius), "above 0");
    need(set.length.is_none_or(|l| l > 0.0), "length", of(set.length), "above 0");
    need(set.distance.is_none_or(|d| d >= 0.0), "distance", of(set.distance), "0 or above");
    need(set.tolerance.is_none_or(|t| t >= 0.0), "tolerance", of(set.tolerance), "0 or above");
    need(set.count != Some(0), "count", "0".into(), "at least 1");
    for (key, direction) in [("normal", set.normal), ("axis", set.axis)] {
        let value = format!("{:?}", direction.unwrap_or_default());
        need(direction.is_none_or(|v| v != [0.0; 3]), key, value, "a direction, such as [0, 0, 1]");
    }
    if let (Some(min), Some(max)) = (set.min, set.max) {
        let is_box = (0..3).all(|c| min[c] <= max[c]);
        need(is_box, "max", format!("{max:?}"), &format!("at least `min`, {min:?}"));
    }
    faults
}

/// Finds ids of parts that the job does not have.
fn parts(set: &SetInput, job: &Job) -> Vec<SetFault> {
    let ids: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    let listed = set.parts.iter().enumerate();
    let missing = listed.filter(|(_, id)| !job.part.iter().any(|p| p.id == **id));
    let fault = |(k, id): (usize, &u32)| {
        let message = format!("set `{}`: there is no part {id}", set.name);
        (format!("parts.{k}"), message, nearest(&id.to_string(), &ids))
    };
    missing.map(fault).collect()
}
