//! Requested histories of a job, in ids, and their checks.

use super::axes::NodeAxes;
use super::state::NodeSets;
use super::validate::{JobProblems, nearest};
use crumple_proto::histories::{
    HistoryRequests, NodeGroup, SectionCut, Transducer, TransducerSurface,
};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, NodeHistory, SectionHistory, TransducerHistory};
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use std::collections::HashSet;

/// Returns the histories to record.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> HistoryRequests {
    let touching = |id: u32| settings.contact.as_ref().is_some_and(|c| c.takes_part(id));
    let several = settings.parts.iter().filter(|p| touching(p.id)).count() > 1;
    let nodes: Vec<_> =
        job.output.node.iter().enumerate().map(|(i, n)| group(n, i, sets, findings)).collect();
    let rigid = |part: u32| {
        let place = settings.parts.iter().position(|p| p.id == part).map(|i| i as u32);
        let throughout = settings.rigid.iter().filter(|body| body.window.is_none());
        throughout.into_iter().any(|body| place.is_some_and(|p| body.parts.contains(&p)))
    };
    let all = job.output.section.iter().enumerate();
    let sections: Vec<_> =
        all.map(|(i, s)| section(s, i, job, mesh, sets, &rigid, findings)).collect();
    let all = job.output.transducer.iter().enumerate();
    let transducers: Vec<_> =
        all.map(|(i, t)| transducer(t, i, job, settings, sets, findings)).collect();
    HistoryRequests {
        contacts: job.output.contacts && several,
        nodes: nodes.into_iter().flatten().collect(),
        sections: sections.into_iter().flatten().collect(),
        transducers: transducers.into_iter().flatten().collect(),
    }
}

fn group(
    asked: &NodeHistory,
    i: usize,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Option<NodeGroup> {
    let path = format!("output.node.{i}");
    if asked.nodes.is_none() && asked.ids.is_empty() {
        let help = "name a node set as `nodes`, list node `ids`, or remove the entry";
        findings.add(Problem::error(path, "a history of nodes has no nodes", help));
        return None;
    }
    let mut nodes: Vec<NodeId> = Vec::new();
    let mut whole = true;
    if let Some(name) = &asked.nodes {
        match sets.ids(name, format!("{path}.nodes"), findings) {
            Some(ids) => nodes.extend(ids),
            None => whole = false,
        }
    }
    for (k, &id) in asked.ids.iter().enumerate() {
        let Some(node) = sets.labelled(id) else {
            let message = format!("a history names node {id}, which no element has");
            let help = "list ids of nodes that elements have, or remove this one";
            findings.add(Problem::error(format!("{path}.ids.{k}"), message, help));
            whole = false;
            continue;
        };
        nodes.push(node);
    }
    nodes.sort_unstable();
    nodes.dedup();
    let axes = match &asked.axes {
        Some(ids) => {
            let axes = axes(*ids, &format!("{path}.axes"), sets, findings);
            whole &= axes.is_some();
            axes
        }
        None => None,
    };
    whole.then_some(NodeGroup { name: group_name(asked, i), nodes, axes })
}

/// Returns the name of entry `i` of `[[output.node]]` in the output.
fn group_name(asked: &NodeHistory, i: usize) -> String {
    match (&asked.name, &asked.nodes) {
        (name, _) if !name.is_empty() => name.clone(),
        (_, Some(set)) => set.clone(),
        _ => format!("nodes {i}"),
    }
}

/// Returns the names of the node groups of heads.
pub fn heads(job: &Job) -> Vec<String> {
    let nodes = job.output.node.iter().enumerate();
    nodes.filter(|(_, asked)| asked.head).map(|(i, asked)| group_name(asked, i)).collect()
}

/// Returns the nodes of axes. Reports nodes that are not there, and axes without a plane.
fn axes(
    ids: [u64; 3],
    path: &str,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Option<[NodeId; 3]> {
    let mut found = [NodeId(0); 3];
    for (k, id) in ids.into_iter().enumerate() {
        let Some(node) = sets.labelled(id) else {
            let message = format!("axes of a history name node {id}, which no element has");
            let help = "list ids of nodes that elements have, or remove `axes`";
            findings.add(Problem::error(path, message, help));
            return None;
        };
        found[k] = node;
    }
    let places = ids.map(|id| sets.coordinates(id).unwrap_or_default());
    if NodeAxes::new(places).is_none() {
        let message =
            format!("the nodes {}, {} and {} of axes are on one line", ids[0], ids[1], ids[2]);
        let help = "give three nodes that span a plane";
        findings.add(Problem::error(path, message, help));
        return None;
    }
    Some(found)
}

/// Returns true if all these parts exist. Otherwise reports the missing ones.
fn are_parts(parts: &[u32], path: &str, what: &str, job: &Job, findings: &mut JobProblems) -> bool {
    let missing: Vec<_> =
        parts.iter().enumerate().filter(|(_, id)| !job.part.iter().any(|p| p.id == **id)).collect();
    for (k, id) in &missing {
        let ids: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
        let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
        let message = format!("{what}: there is no part {id}");
        findings.add(Problem::error(
            format!("{path}.{k}"),
            message,
            nearest(&id.to_string(), &ids),
        ));
    }
    missing.is_empty()
}

fn transducer(
    asked: &TransducerHistory,
    i: usize,
    job: &Job,
    settings: &Settings,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Option<Transducer> {
    let path = format!("output.transducer.{i}");
    if asked.parts.is_empty() && asked.nodes.is_none() {
        let help =
            "name its `parts`, its `nodes`, or both: all contact forces together sum to zero";
        findings.add(Problem::error(path, "a force transducer has no surface", help));
        return None;
    }
    let touches = |id: u32| settings.contact.as_ref().is_some_and(|c| c.takes_part(id));
    if settings.contact.is_none() {
        let help = "give the job a [contact] table, or remove the transducer";
        findings.add(Problem::warning(
            path.clone(),
            "a force transducer needs contact, and the job has none",
            help,
        ));
    } else if !asked.parts.is_empty() && !asked.parts.iter().any(|&p| touches(p)) {
        let help = "name parts of `contact.parts`, or remove the transducer";
        findings.add(Problem::warning(
            path.clone(),
            "the parts of a force transducer are not in contact",
            help,
        ));
    }
    let mut surface = |parts: &[u32],
                       nodes: &Option<String>,
                       keys: [&str; 2]|
     -> Option<TransducerSurface> {
        let known =
            are_parts(parts, &format!("{path}.{}", keys[0]), "a force transducer", job, findings);
        let mut places: Vec<u32> = (0..)
            .zip(&settings.parts)
            .filter(|(_, p)| parts.contains(&p.id))
            .map(|p| p.0)
            .collect();
        places.sort_unstable();
        let nodes = match nodes {
            None => None,
            Some(name) => Some(sets.ids(name, format!("{path}.{}", keys[1]), findings)?),
        };
        known.then_some(TransducerSurface { parts: places, nodes })
    };
    let on = surface(&asked.parts, &asked.nodes, ["parts", "nodes"]);
    let from = surface(&asked.from_parts, &asked.from_nodes, ["from_parts", "from_nodes"]);
    let name =
        if asked.name.is_empty() { format!("transducer {}", i + 1) } else { asked.name.clone() };
    Some(Transducer { name, on: on?, from: from? })
}

fn section(
    asked: &SectionHistory,
    i: usize,
    job: &Job,
    mesh: &Mesh,
    sets: &NodeSets<'_>,
    rigid: &dyn Fn(u32) -> bool,
    findings: &mut JobProblems,
) -> Option<SectionCut> {
    let path = format!("output.section.{i}");
    let nodes = sets.ids(&asked.nodes, format!("{path}.nodes"), findings);
    let is_valid = check_section(asked, &path, job, mesh, findings);
    let nodes = nodes.filter(|_| is_valid)?;
    let found = elements_of_section(asked, &nodes, mesh, sets);
    if found.is_empty() {
        let message = format!(
            "a section has no elements: none of the requested elements has a node of `{}`",
            asked.nodes
        );
        let help = "name other `parts`, `elements` or another `side`";
        findings.add(Problem::error(path, message, help));
        return None;
    }
    if found.iter().all(|e| rigid(e.part)) {
        let message = "a section has rigid elements only, in which no forces are computed";
        findings.add(Problem::error(path, message, "take elements of a deformable part"));
        return None;
    }
    let name = if asked.name.is_empty() { asked.nodes.clone() } else { asked.name.clone() };
    Some(SectionCut { name, nodes, elements: found.into_iter().map(|e| e.id).collect() })
}

/// Checks parts, elements and side of a section. Returns false if there is an error.
fn check_section(
    asked: &SectionHistory,
    path: &str,
    job: &Job,
    mesh: &Mesh,
    findings: &mut JobProblems,
) -> bool {
    let mut is_valid =
        are_parts(&asked.parts, &format!("{path}.parts"), "a section", job, findings);
    if !asked.elements.is_empty() {
        let there: HashSet<u64> = mesh.elements.iter().map(|e| e.id.label()).collect();
        for (k, id) in asked.elements.iter().enumerate().filter(|(_, id)| !there.contains(id)) {
            let message = format!("a section: there is no element {id}");
            let help = "list ids of elements of the mesh";
            findings.add(Problem::error(format!("{path}.elements.{k}"), message, help));
            is_valid = false;
        }
    }
    if asked.parts.is_empty() && asked.elements.is_empty() && asked.side.is_none() {
        let help = "name `parts`, `elements` or a `side`: the forces of all elements at a node sum \
                    to the force that accelerates it";
        findings.add(Problem::error(path, "a section has no elements", help));
        is_valid = false;
    }
    if let Some(side) = asked.side.filter(|s| s.iter().all(|c| *c == 0.0)) {
        let message = format!("the side {side:?} of a section has no direction");
        let help = "give the direction from the nodes to the elements";
        findings.add(Problem::error(format!("{path}.side"), message, help));
        is_valid = false;
    }
    is_valid
}

/// Returns the requested elements with a node of the section, on its side.
fn elements_of_section<'m>(
    asked: &SectionHistory,
    nodes: &[NodeId],
    mesh: &'m Mesh,
    sets: &NodeSets<'_>,
) -> Vec<&'m MeshElement> {
    let place = |id: NodeId| sets.place(id).map_or([0.0; 3], |n| mesh.nodes[n].x);
    let mean = |ids: &[NodeId]| -> [f64; 3] {
        std::array::from_fn(|c| ids.iter().map(|&id| place(id)[c]).sum::<f64>() / ids.len() as f64)
    };
    let middle = mean(nodes);
    let of_side = |e: &MeshElement| {
        let centre = mean(e.corners());
        asked
            .side
            .is_none_or(|side| (0..3).map(|c| side[c] * (centre[c] - middle[c])).sum::<f64>() > 0.0)
    };
    let listed = |e: &MeshElement| {
        asked.parts.is_empty() && asked.elements.is_empty()
            || asked.parts.contains(&e.part)
            || asked.elements.contains(&e.id.label())
    };
    let ends = |e: &MeshElement| e.corners().iter().any(|n| nodes.binary_search(n).is_ok());
    mesh.elements.iter().filter(|e| listed(e) && ends(e) && of_side(e)).collect()
}
