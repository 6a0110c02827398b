//! Checks that the elements with a stress or a plastic strain at the start take it.

use super::laws::BuiltElements;
use super::validate::JobProblems;
use crumple_proto::ids::ElemId;
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_worker::fem::elements::points_of;
use std::collections::BTreeMap;

/// Stresses of a part at the start.
#[derive(Default)]
struct StressedPart {
    /// Elements with a stress that they do not take, and the first of them.
    without_stress: usize,
    /// Elements with a plastic strain that they do not take.
    without_strain: usize,
    /// A number of points through the thickness of its shells at which they are given.
    other_points: Option<usize>,
    first: Option<ElemId>,
}

/// Returns the stresses at the start for the settings. Reports parts whose laws take none: an error
/// unless the job allows unsupported content. Elements of rigid parts have no stress.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    blocks: &BuiltElements,
    findings: &mut JobProblems,
) -> Vec<InitialPoint> {
    let mut parts: BTreeMap<u32, StressedPart> = BTreeMap::new();
    for points in mesh.initial.chunk_by(|a, b| a.element == b.element) {
        let at = mesh.elements.binary_search_by_key(&points[0].element, |e| e.id);
        let Some(element) = at.ok().map(|at| &mesh.elements[at]) else { continue };
        let index = settings.parts.binary_search_by_key(&element.part, |part| part.id);
        let Ok(index) = index else { continue };
        if settings.is_inactive(index as u32) {
            continue;
        }
        let Some(taken) = blocks.element(index, element.shape).map(|e| e.taken_at_start()) else {
            continue;
        };
        let part = parts.entry(element.part).or_default();
        part.first.get_or_insert(element.id);
        part.without_stress += usize::from(!taken.stress && !points.iter().all(|p| p.is_zero()));
        let is_strained = points.iter().any(|p| p.plastic_strain > 0.0);
        part.without_strain += usize::from(taken.stress && !taken.plastic_strain && is_strained);
        let given = given_through_thickness(element, points);
        let own = points_of(&settings.parts[index]);
        part.other_points = part.other_points.or(given.filter(|&given| given != own));
    }
    for (id, found) in parts {
        let Some(place) = job.part.iter().position(|part| part.id == id) else { continue };
        report(job, settings, (place, &found), findings);
    }
    mesh.initial.clone()
}

/// Returns the number of points through the thickness of a shell; `None` for solids.
fn given_through_thickness(element: &MeshElement, points: &[InitialPoint]) -> Option<usize> {
    let first = points[0].number;
    element.shape.is_shell().then(|| points.iter().filter(|p| p.number == first).count())
}

fn report(
    job: &Job,
    settings: &Settings,
    (place, found): (usize, &StressedPart),
    findings: &mut JobProblems,
) {
    let part = &job.part[place];
    let material = settings.materials.iter().find(|material| material.name == part.material);
    let law = material.map_or("", |material| material.law.as_str());
    let first = found.first.map_or(String::new(), |id| format!(", the first is {id}"));
    let path = format!("part.{place}.material");
    if found.without_stress > 0 {
        let message = format!(
            "part {}: {} of its elements have a stress at the start{first}, which the law `{law}` \
             of material '{}' does not take with these elements",
            part.label(),
            found.without_stress,
            part.material
        );
        findings.add(match job.mesh.allow_unsupported {
            true => Problem::warning(path.clone(), message, "they start without stress"),
            false => Problem::error(
                path.clone(),
                message,
                "remove these stresses, give the part another material, or let its elements start \
                 without stress: --allow-unsupported, or mesh.allow_unsupported",
            ),
        });
    }
    if found.without_strain > 0 {
        let message = format!(
            "part {}: {} of its elements have a plastic strain at the start{first}, and the law \
             `{law}` has none",
            part.label(),
            found.without_strain
        );
        let help = "it has no effect; use a law with plastic flow if it matters";
        findings.add(Problem::warning(path.clone(), message, help));
    }
    if let Some(given) = found.other_points {
        let message = format!(
            "part {}: stresses at the start are given at {given} points through the thickness, and \
             its shells have {}",
            part.label(),
            points_of(part)
        );
        let help = "they get values between those at the given points, linear in the thickness; \
                    for exact ones use as many points";
        findings.add(Problem::warning(path, message, help));
    }
}
