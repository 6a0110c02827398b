//! Adaptivity: checks of its numbers, and the shells that may be divided.

use super::resolve::NumberChecks;
use super::validate::JobProblems;
use crumple_proto::adaptivity::AdaptivitySettings;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{AdaptivityInput, GravityInput, Job, Part};
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_worker::fem::elements::points_of;
use std::collections::{BTreeSet, HashSet};

/// Largest numbers of levels and of rings. A shell of level 4 has 1/256 of the area.
const MOST: u32 = 4;
/// Largest number of checks in a run.
const MOST_CHECKS: f64 = 1e6;
/// Number of checks in a run, if the job has no interval.
const CHECKS: f64 = 100.0;

/// Checks the numbers of `[adaptivity]`.
pub fn check(given: &AdaptivityInput, job: &Job, numbers: &mut NumberChecks<'_>) {
    let mut need = |right: bool, key: &str, value: f64, wanted: &str| {
        numbers.need(right, &format!("adaptivity.{key}"), value, wanted);
    };
    need(given.angle > 0.0, "angle", given.angle, "above 0 degrees; 5 is usual");
    let least = job.end_time / MOST_CHECKS;
    need(
        given.interval == 0.0 || given.interval >= least,
        "interval",
        given.interval,
        "0 (a hundredth of the run), or at least a millionth of the run",
    );
    need(given.begin >= 0.0, "begin", given.begin, "a time, 0 or above");
    if let Some(end) = given.end {
        need(end > given.begin, "end", end, "after `begin`");
    }
    for (key, count, least) in [("levels", given.levels, 1), ("rings", given.rings, 0)] {
        if !(least..=MOST).contains(&count) {
            let help = format!("it has to be from {least} to {MOST}");
            let problem =
                Problem::error(format!("adaptivity.{key}"), format!("`{key}` is {count}"), help);
            numbers.findings.add(problem);
        }
    }
    let is_unknown = |id: &u32| job.part.iter().all(|part| part.id != *id);
    for (i, id) in given.parts.iter().enumerate().filter(|(_, id)| is_unknown(id)) {
        let path = format!("adaptivity.parts.{i}");
        let message = format!("there is no part {id}");
        numbers.findings.add(Problem::error(path, message, "name parts of the job"));
    }
    for (key, asked) in [("d3plot", job.output.d3plot), ("exodus", job.output.exodus)] {
        if asked {
            let message = "this format has one mesh for all times, and adaptivity changes the mesh";
            let help = "remove it, and open fields.pvd or output.vtkhdf in ParaView";
            numbers.findings.add(Problem::error(format!("output.{key}"), message, help));
        }
    }
    let changed = [("delete", &job.restart.delete), ("rigid", &job.restart.rigid)];
    for (key, _) in changed.into_iter().filter(|(_, parts)| !parts.is_empty()) {
        let message = "the parts of a run with adaptivity cannot be deleted or made rigid";
        let help = "remove it, or continue from a run without [adaptivity]";
        numbers.findings.add(Problem::error(format!("restart.{key}"), message, help));
    }
    if job.time.mass_scaling_dt > 0.0 {
        let message = "quarters of divided shells keep the factor of mass scaling of the shell, \
                       and their step is half of its step";
        let help = "take a larger `mass_scaling_dt` if the run has to keep its step";
        numbers.findings.add(Problem::warning("adaptivity", message, help));
    }
}

/// Returns what a job has that adaptivity does not work with, and what helps.
fn conflict(job: &Job) -> Option<(&'static str, &'static str)> {
    let parts_only = !job.damping.is_empty() || job.gravity.iter().any(GravityInput::is_partial);
    if job.time.subcycles > 1 {
        Some(("subcycles: divided shells change their class", "remove time.subcycles"))
    } else if parts_only {
        Some((
            "damping or gravity of single parts or nodes: new nodes would have none",
            "let them act on the whole model",
        ))
    } else if job.tie.iter().any(|tie| tie.failure.is_some()) {
        Some(("ties that fail", "remove `failure` from the ties"))
    } else {
        None
    }
}

/// Returns the adaptivity of a job, if it has any.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    findings: &mut JobProblems,
) -> Option<AdaptivitySettings> {
    let given = job.adaptivity.as_ref()?;
    if let Some((what, help)) = conflict(job) {
        let message = format!("no shell is divided: adaptivity does not work with {what}");
        let help = format!("{help}, or remove [adaptivity]");
        // The deck may be the one that asks for it; other programs leave it out too.
        let of_deck = job.mesh.deck.is_some();
        let report = if of_deck { Problem::warning } else { Problem::error };
        findings.add(report("adaptivity", message, help));
        return None;
    }
    let parts = parts(given, mesh, settings, findings);
    let is_open = |e: &&MeshElement| {
        let part = settings.parts.iter().position(|p| p.id == e.part);
        e.shape == Shape::Quad4 && part.is_some_and(|p| parts.contains(&(p as u32)))
    };
    let open: Vec<&MeshElement> = mesh.elements.iter().filter(is_open).collect();
    let kept = Fixed::new(mesh, settings);
    let kept: BTreeSet<ElemId> = open.iter().filter(|e| kept.has(e)).map(|e| e.id).collect();
    if kept.len() == open.len() {
        let message = "no shell may be divided: all are rigid, loaded by pressure, tied, recorded \
                       as a section or by a transducer, or share nodes with solids, beams, \
                       springs or bodies";
        findings.add(Problem::warning("adaptivity", message, "remove [adaptivity]"));
    }
    let first = (
        ElemId::following(mesh.elements.iter().map(|e| e.id)),
        NodeId::following(mesh.nodes.iter().map(|n| n.id)),
    );
    // All shells divided as often as possible.
    let most = open.len() as u64 * 4_u64.pow(given.levels) * 2;
    let (Some(first_element), Some(first_node)) = (
        first.0.filter(|element| element.has_room(most)),
        first.1.filter(|node| node.has_room(most)),
    ) else {
        let message = "there are no numbers left for new elements and nodes";
        findings.add(Problem::error("adaptivity", message, "give the mesh smaller numbers"));
        return None;
    };
    let whole = |given: f64, default: f64| if given > 0.0 { given } else { default };
    Some(AdaptivitySettings {
        kept: kept.into_iter().collect(),
        parts: parts.into_iter().collect(),
        angle: given.angle.to_radians(),
        rings: given.rings,
        levels: given.levels,
        window: [given.begin, given.end.unwrap_or(f64::INFINITY)],
        interval: whole(given.interval, job.end_time / CHECKS),
        first_element,
        first_node,
    })
}

/// Returns the indices of the parts whose quads may be divided.
fn parts(
    given: &AdaptivityInput,
    mesh: &Mesh,
    settings: &Settings,
    findings: &mut JobProblems,
) -> BTreeSet<u32> {
    let with_quads: HashSet<u32> =
        mesh.elements.iter().filter(|e| e.shape == Shape::Quad4).map(|e| e.part).collect();
    for (i, &id) in given.parts.iter().enumerate() {
        let path = format!("adaptivity.parts.{i}");
        let Some(part) = settings.parts.iter().find(|p| p.id == id) else { continue };
        if !with_quads.contains(&id) {
            let message = format!("part {} has no four-node shells", part.label());
            findings.add(Problem::warning(path, message, "remove it from the list"));
        }
    }
    let is_named = |id: u32| given.parts.is_empty() || given.parts.contains(&id);
    let all = (0..).zip(&settings.parts);
    let named: Vec<(u32, &Part)> =
        all.filter(|(_, p)| is_named(p.id) && with_quads.contains(&p.id)).collect();
    for (_, part) in &named {
        let what = match points_of(part) {
            1 => "one point through the thickness and no bending",
            2 => "two points through the thickness: all plastic strain counts as bending",
            _ => continue,
        };
        let message = format!("part {} has {what}", part.label());
        let help = "give it three or more `points`, or other parts to [adaptivity]";
        findings.add(Problem::warning("adaptivity", message, help));
    }
    named.into_iter().map(|(i, _)| i).collect()
}

/// Nodes, elements and parts that keep shells from being divided.
struct Fixed {
    nodes: HashSet<NodeId>,
    elements: HashSet<ElemId>,
    parts: HashSet<u32>,
}

impl Fixed {
    fn new(mesh: &Mesh, settings: &Settings) -> Self {
        let others = mesh.elements.iter().filter(|e| e.shape != Shape::Quad4);
        let mut nodes: HashSet<NodeId> =
            others.filter(|e| e.shape != Shape::Tri3).flat_map(|e| e.corners()).copied().collect();
        nodes.extend(settings.rigid.iter().flat_map(|body| &body.nodes));
        nodes.extend(settings.ties.iter().map(|tie| tie.node));
        nodes.extend(settings.loads.absorbers.iter().map(|a| a.node));
        let of_rigid = settings.rigid.iter().flat_map(|body| &body.parts).copied();
        let skins = (0..).zip(&settings.parts).filter(|(_, part)| part.skin).map(|(i, _)| i);
        let mut elements: HashSet<ElemId> =
            settings.ties.iter().flat_map(|tie| &tie.faces).copied().collect();
        elements.extend(settings.histories.sections.iter().flat_map(|s| &s.elements));
        let surfaces = settings.histories.transducers.iter().flat_map(|t| [&t.on, &t.from]);
        for set in surfaces.filter_map(|surface| surface.nodes.as_ref()) {
            let has = |n: &NodeId| set.binary_search(n).is_ok();
            let on = mesh.elements.iter().filter(|e| e.corners().iter().all(has));
            elements.extend(on.map(|e| e.id));
        }
        elements.extend(settings.loads.pressures.iter().flat_map(|p| &p.faces).map(|f| f.0));
        elements.extend(settings.loads.airbags.iter().flat_map(|b| &b.faces).map(|f| f.element));
        let ids = of_rigid.chain(skins).map(|i| settings.parts[i as usize].id);
        Self { nodes, elements, parts: ids.collect() }
    }

    fn has(&self, e: &MeshElement) -> bool {
        self.parts.contains(&e.part)
            || self.elements.contains(&e.id)
            || e.corners().iter().any(|n| self.nodes.contains(n))
    }
}
