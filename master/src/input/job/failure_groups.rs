//! Solids that fail together.

use super::laws::BuiltElements;
use super::validate::JobProblems;
use crumple_proto::ids::ElemId;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use std::collections::HashMap;

/// Returns the elements of all groups, ascending in each.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    (settings, blocks): (&Settings, &BuiltElements),
    findings: &mut JobProblems,
) -> Vec<Vec<ElemId>> {
    if job.failure_group.is_empty() {
        return Vec::new();
    }
    let elements: HashMap<u64, &MeshElement> =
        mesh.elements.iter().map(|e| (e.id.label(), e)).collect();
    let fallible: HashMap<u32, bool> = (0..)
        .zip(&settings.parts)
        .map(|(at, part)| {
            let built = blocks.element(at, Shape::Hex8);
            (part.id, built.is_some_and(|element| element.failure_column().is_some()))
        })
        .collect();
    let can_fail = |element: &MeshElement| fallible.get(&element.part) == Some(&true);
    let mut owner: HashMap<u64, usize> = HashMap::new();
    let mut groups = Vec::new();
    for (index, group) in job.failure_group.iter().enumerate() {
        let path = format!("failure_group.{index}.elements");
        let name = &group.name;
        let mut wrong = |what: String, help: &str| {
            let message = format!("failure group `{name}`: {what}");
            findings.add(Problem::error(path.clone(), message, help));
        };
        if group.elements.len() < 2 {
            wrong("has fewer than two elements".into(), "list two solids or more, or remove it");
        }
        let mut ids = Vec::new();
        for &id in &group.elements {
            match elements.get(&id) {
                None => wrong(format!("there is no element {id}"), "list elements of the mesh"),
                Some(element) if element.shape != Shape::Hex8 => {
                    wrong(format!("element {id} is no hexahedron"), "list hexahedra only");
                }
                Some(element) if !can_fail(element) => {
                    let what = format!("element {id} of part {} cannot fail", element.part);
                    let help = "give its material a criterion of failure; thick shells and \
                                cohesive elements do not fail together";
                    wrong(what, help);
                }
                Some(element) => ids.push(element.id),
            }
            if let Some(other) = owner.insert(id, index) {
                let what = match other == index {
                    true => format!("element {id} is listed twice"),
                    false => {
                        let in_it = &job.failure_group[other].name;
                        format!("element {id} is in group `{in_it}` already")
                    }
                };
                wrong(what, "list each element once");
            }
        }
        ids.sort_unstable();
        groups.push(ids);
    }
    groups
}
