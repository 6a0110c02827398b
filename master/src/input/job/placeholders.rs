//! Placeholders of `crumple import`: values that a mesh file does not have.

use crumple_proto::job::Job;
use crumple_proto::problem::Problem;

/// Warns of each value that is a placeholder, and of each entry that names no value.
pub fn check(job: &Job) -> Vec<Problem> {
    let of = |(index, key): (usize, &String)| match path(job, key) {
        Some(path) => Problem::warning(
            path,
            format!("`{key}` is a placeholder, not a value of your model"),
            format!("set it, then remove \"{key}\" from `placeholders`"),
        ),
        None => Problem::warning(
            format!("placeholders.{index}"),
            format!("`{key}` names no value of the job"),
            "remove it from `placeholders`",
        ),
    };
    job.placeholders.iter().enumerate().map(of).collect()
}

/// Returns the path of a key that gives parts and materials by name or id.
fn path(job: &Job, key: &str) -> Option<String> {
    let (list, rest) = key.split_once('.').unwrap_or((key, ""));
    let parts = || job.part.iter().map(|p| [p.name.clone(), p.id.to_string()].to_vec());
    let names: Vec<Vec<String>> = match list {
        "part" => parts().collect(),
        "material" => job.material.iter().map(|m| vec![m.name.clone()]).collect(),
        _ => return (key == "end_time").then(|| key.to_string()),
    };
    // A name may contain points.
    let below = |name: &str| match rest.strip_prefix(name)? {
        "" => Some(String::new()),
        tail => tail.starts_with('.').then(|| tail.to_string()),
    };
    let found = names.iter().enumerate().find_map(|(index, names)| {
        let named = names.iter().filter(|name| !name.is_empty());
        named.filter_map(|name| below(name)).next().map(|tail| (index, tail))
    });
    found.map(|(index, tail)| format!("{list}.{index}{tail}"))
}
