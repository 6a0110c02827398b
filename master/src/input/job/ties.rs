//! Ties of a job: search for the face of each tied node, checks, and conversion to numbers and
//! ids.

mod failure;
mod inside;
pub mod mean;
mod surface;

use super::state::{NodeSets, NodeStart};
use super::turning_nodes;
use super::validate::{JobProblems, nearest};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{Job, TieInput};
use crumple_proto::loads::PrescribedMotion;
use crumple_proto::mesh::{Mesh, free_faces};
use crumple_proto::problem::Problem;
use crumple_proto::rigid::RigidBody;
use crumple_proto::tie::Tie;
use crumple_worker::constraints::ties::project::Foot;
use std::collections::{BTreeMap, HashMap, HashSet};
use surface::TieSurface;

/// Displacement of a node onto its face, as a fraction of the face's diagonal, above which it is
/// reported.
const WARN_MOVE: f64 = 1e-3;
/// Relative difference between the initial velocities of a node and of its masters above which it
/// is reported.
const WARN_VELOCITY: f64 = 0.01;
/// Maximum number of node ids in a message.
const NAMED: usize = 5;
/// Number of ties in a chain from which the chain is taken for a circle.
const LONGEST_CHAIN: usize = 100;

/// A tied node with its entry in the job, its index in the mesh, and its position on the face.
struct Projected {
    tie: Tie,
    entry: usize,
    node: usize,
    point: [f64; 3],
    moved: f64,
}

/// Data of a job and its mesh that all entries need.
struct TieContext<'a> {
    job: &'a Job,
    mesh: &'a Mesh,
    sets: NodeSets<'a>,
    /// Free faces of solids.
    free: Vec<u16>,
    /// Thickness of each part, and of the thickest shell at each node [length].
    thick: HashMap<u32, f64>,
    shells: HashMap<NodeId, f64>,
    /// Nodes with rotations.
    turning: HashSet<NodeId>,
    /// Parts of rigid bodies.
    rigid: HashSet<u32>,
}

impl<'a> TieContext<'a> {
    fn new(job: &'a Job, mesh: &'a Mesh) -> Self {
        let thick: HashMap<u32, f64> = job.part.iter().map(|p| (p.id, p.thickness)).collect();
        Self {
            sets: NodeSets::new(job, mesh),
            free: free_faces(&mesh.elements),
            shells: surface::thickest_shells(mesh, &thick),
            thick,
            turning: turning_nodes(job, mesh),
            rigid: job.rigid.iter().flat_map(|r| r.parts.iter().copied()).collect(),
            job,
            mesh,
        }
    }

    /// Returns the coordinates of a node [length].
    fn place(&self, id: NodeId) -> [f64; 3] {
        self.sets.place(id).map_or([0.0; 3], |n| self.mesh.nodes[n].x)
    }
}

/// The ties of a job.
#[derive(Default)]
pub struct ResolvedTies {
    /// Ties by ascending node.
    pub ties: Vec<Tie>,
    /// Positions of tied nodes in the input, before they were moved [length].
    pub given: BTreeMap<NodeId, [f64; 3]>,
}

/// Finds the faces to which nodes are tied and moves the nodes onto them.
pub fn resolve(job: &Job, mesh: &mut Mesh, findings: &mut JobProblems) -> ResolvedTies {
    if job.tie.is_empty() {
        return ResolvedTies::default();
    }
    let mut projected: Vec<Projected> = Vec::new();
    let context = TieContext::new(job, mesh);
    for (entry, spec) in job.tie.iter().enumerate() {
        projected.extend(tied_nodes(spec, entry, &context, findings));
    }
    drop(context);
    projected.sort_by_key(|s| (s.tie.node, s.entry));
    // The first of several entries with a solid around a node counts.
    let is_inside = |s: &Projected| job.tie[s.entry].inside;
    projected.dedup_by(|later, first| {
        later.tie.node == first.tie.node && is_inside(later) && is_inside(first)
    });
    for pair in projected.windows(2).filter(|pair| pair[0].tie.node == pair[1].tie.node) {
        let message = format!(
            "node {} is tied twice: by {} and {}",
            pair[0].tie.node,
            name(job, pair[0].entry),
            name(job, pair[1].entry)
        );
        let help = "remove it from one of the sets";
        findings.add(Problem::error(format!("tie.{}.nodes", pair[1].entry), message, help));
    }
    let direct: Vec<Tie> = projected.iter().map(|s| s.tie.clone()).collect();
    failure::refuse_chains(&direct, findings);
    failure::refuse_partial_loads(job, mesh, &direct, findings);
    let mut given = BTreeMap::new();
    for s in &projected {
        let node = &mut mesh.nodes[s.node];
        given.insert(node.id, std::mem::replace(&mut node.x, s.point));
    }
    for entry in 0..job.tie.len() {
        report_moved(job, entry, &projected, findings);
    }
    ResolvedTies { ties: chained(job, projected, findings), given }
}

/// Returns the name of an entry in messages.
fn name(job: &Job, entry: usize) -> String {
    match job.tie[entry].name.as_str() {
        "" => format!("tie {}", entry + 1),
        name => format!("tie `{name}`"),
    }
}

/// Checks parts and numbers of an entry; `path` returns the path of a key.
fn check_entry(
    job: &Job,
    spec: &TieInput,
    path: impl Fn(&str) -> String,
    findings: &mut JobProblems,
) {
    for (k, id) in
        spec.parts.iter().enumerate().filter(|(_, id)| !job.part.iter().any(|p| p.id == **id))
    {
        let ids: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
        let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
        let help = nearest(&id.to_string(), &ids);
        findings.add(Problem::error(
            path(&format!("parts.{k}")),
            format!("tie: there is no part {id}"),
            help,
        ));
    }
    if spec.tolerance < 0.0 {
        let message = format!("tolerance is {}", spec.tolerance);
        findings.add(Problem::error(
            path("tolerance"),
            message,
            "give a length, or 0 for the default",
        ));
    }
    for (k, thickness) in spec.thicknesses.iter().enumerate().filter(|(_, t)| **t < 0.0) {
        let message = format!("a thickness is {thickness}");
        findings.add(Problem::error(
            path(&format!("thicknesses.{k}")),
            message,
            "give a length, or 0 for the thickness of the parts",
        ));
    }
}

/// Returns the tied nodes of one entry.
fn tied_nodes(
    spec: &TieInput,
    entry: usize,
    context: &TieContext<'_>,
    findings: &mut JobProblems,
) -> Vec<Projected> {
    let TieContext { job, mesh, sets, .. } = context;
    let path = |key: &str| format!("tie.{entry}.{key}");
    let nodes = sets.indices(&spec.nodes, path("nodes"), findings);
    check_entry(job, spec, path, findings);
    failure::check(spec, path, findings);
    if let Some(node) = spec.node {
        let carrier = sets.labelled(node).unwrap_or(NodeId(node));
        return to_node(spec, carrier, entry, nodes.unwrap_or_default(), mesh, findings);
    }
    if let Some(set) = &spec.mean_of {
        return mean::to_mean(spec, set, entry, nodes.unwrap_or_default(), context, findings);
    }
    if spec.inside {
        let Some(nodes) = nodes else { return Vec::new() };
        return inside::to_solids(spec, entry, &nodes, context, findings);
    }
    let surface = TieSurface::new(spec, entry, context, nodes.is_some(), findings);
    let (Some(surface), Some(nodes)) = (surface, nodes) else { return Vec::new() };
    let thickest = surface.thickest(&nodes);
    let mut found = surface.project(&nodes, thickest);
    let lost = nodes.iter().zip(&found).filter(|(_, foot)| foot.is_none());
    let lost: Vec<NodeId> = lost.map(|(&n, _)| mesh.nodes[n].id).collect();
    let place = (entry, "near enough to its surface");
    report_lost(job, place, (&lost, nodes.len()), findings);
    if !spec.offset {
        surface::keep_solids(mesh, &nodes, &mut found);
    }
    let tied = |(&node, foot): (&usize, Option<Foot>)| Some(surface.tied(entry, node, &foot?));
    let mut projected: Vec<Projected> = nodes.iter().zip(found).filter_map(tied).collect();
    surface.scale_limits(entry, &mut projected, findings);
    if job.contact.is_some() {
        surface.face_back(&mut projected, thickest);
    }
    projected
}

/// Warns of nodes whose initial velocity differs from that of their masters.
fn report_velocities<'t>(
    ties: impl Iterator<Item = &'t Tie>,
    sets: &NodeSets<'_>,
    start: &NodeStart,
    findings: &mut JobProblems,
) {
    let velocity = |id: NodeId| sets.place(id).map_or([0.0; 3], |n| start.velocity[n]);
    let unlike = |tie: &&Tie| {
        let own = velocity(tie.node);
        let carried = tie.masters.iter().map(|&(id, share)| velocity(id).map(|v| v * share));
        let carried = carried.fold([0.0; 3], |sum, v| [0, 1, 2].map(|c| sum[c] + v[c]));
        let size = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        size([0, 1, 2].map(|c| own[c] - carried[c])) > WARN_VELOCITY * size(own).max(size(carried))
            && !tie.offset
    };
    let nodes: Vec<NodeId> = ties.filter(unlike).map(|t| t.node).collect();
    if !nodes.is_empty() {
        let message = format!(
            "{} tied nodes have other initial velocities than their masters, and share their \
             momentum with them: {}",
            nodes.len(),
            named(&nodes)
        );
        findings.add(Problem::warning(
            "tie",
            message,
            "give both sides of a tie the same initial velocity",
        ));
    }
}

/// Returns nodes that have the displacements of another node.
fn to_node(
    spec: &TieInput,
    carrier: NodeId,
    entry: usize,
    nodes: Vec<usize>,
    mesh: &Mesh,
    findings: &mut JobProblems,
) -> Vec<Projected> {
    let mut wrong = |key: &str, message: String, help: &str| {
        findings.add(Problem::error(format!("tie.{entry}.{key}"), message, help));
    };
    if !spec.parts.is_empty() || spec.faces.is_some() || spec.offset || spec.inside {
        wrong(
            "node",
            "a tie with a `node` also has `parts`, `faces`, `offset` or `inside`".into(),
            "remove them: a tie to a node has no surface",
        );
    }
    if !mesh.nodes.iter().any(|n| n.id == carrier) {
        wrong("node", format!("no element has node {carrier}"), "name a node of the mesh");
    }
    if nodes.iter().any(|&n| mesh.nodes[n].id == carrier) {
        wrong("nodes", format!("node {carrier} is tied to itself"), "remove it from the set");
    }
    let tied = |node: usize| Projected {
        tie: Tie {
            node: mesh.nodes[node].id,
            masters: vec![(carrier, 1.0)],
            near: Vec::new(),
            faces: Vec::new(),
            rotations: spec.rotations,
            offset: false,
            mean: false,
            failure: None,
        },
        entry,
        node,
        point: mesh.nodes[node].x,
        moved: 0.0,
    };
    nodes.into_iter().map(tied).collect()
}

/// Sorts shape values, merges those of the same node, and scales their sum to 1.
fn whole(shares: &mut Vec<(NodeId, f64)>) {
    shares.sort_by_key(|s| s.0);
    shares.dedup_by(|later, first| {
        let same = later.0 == first.0;
        first.1 += if same { later.1 } else { 0.0 };
        same
    });
    let sum: f64 = shares.iter().map(|s| s.1).sum();
    shares.iter_mut().for_each(|s| s.1 /= sum);
}

fn named(nodes: &[NodeId]) -> String {
    let list: Vec<String> = nodes.iter().take(NAMED).map(|n| n.to_string()).collect();
    format!("{}{}", list.join(", "), if nodes.len() > NAMED { ", ..." } else { "" })
}

/// Reports nodes of an entry that are not at `place`, out of a number of nodes.
fn report_lost(
    job: &Job,
    (entry, place): (usize, &str),
    (lost, count): (&[NodeId], usize),
    findings: &mut JobProblems,
) {
    if lost.is_empty() {
        return;
    }
    let path = format!("tie.{entry}.nodes");
    let help = "give a larger `tolerance`, or remove them from the set";
    if lost.len() == count {
        let message = format!("{}: none of its {count} nodes is {place}", name(job, entry));
        findings.add(match job.tie[entry].may_be_empty {
            true => Problem::warning(path, message, "if this is meant, remove the tie"),
            false => Problem::error(path, message, help),
        });
    } else {
        let message = format!(
            "{}: {} of {count} nodes are not {place} and it does not tie them: {}",
            name(job, entry),
            lost.len(),
            named(lost)
        );
        findings.add(Problem::warning(path, message, help));
    }
}

fn report_moved(job: &Job, entry: usize, projected: &[Projected], findings: &mut JobProblems) {
    let moved: Vec<&Projected> =
        projected.iter().filter(|s| s.entry == entry && s.moved > WARN_MOVE).collect();
    let Some(most) = moved.iter().max_by(|a, b| a.moved.total_cmp(&b.moved)) else { return };
    let of = if job.tie[entry].inside { "box around its solid" } else { "its face" };
    let message = format!(
        "{}: {} nodes are moved onto its surface; node {} most, by {:.1} % of the diagonal of {of}",
        name(job, entry),
        moved.len(),
        most.tie.node,
        100.0 * most.moved
    );
    findings.add(Problem::warning(
        format!("tie.{entry}.nodes"),
        message,
        "place these nodes on the surface in the mesh",
    ));
}

/// Replaces masters that are tied nodes themselves by their own masters.
fn chained(job: &Job, projected: Vec<Projected>, findings: &mut JobProblems) -> Vec<Tie> {
    let own: HashMap<NodeId, Vec<(NodeId, f64)>> =
        projected.iter().map(|s| (s.tie.node, s.tie.masters.clone())).collect();
    let on: HashMap<NodeId, Vec<ElemId>> =
        projected.iter().map(|s| (s.tie.node, s.tie.faces.clone())).collect();
    let kinds: HashMap<NodeId, (bool, bool)> =
        projected.iter().map(|s| (s.tie.node, (s.tie.rotations, s.tie.offset))).collect();
    let mut ties = Vec::with_capacity(projected.len());
    for Projected { mut tie, entry, .. } in projected {
        let cannot = |&(rotations, offset): &(bool, bool)| {
            tie.offset || offset || tie.rotations && !rotations
        };
        let wrong = tie.masters.iter().find(|c| kinds.get(&c.0).is_some_and(cannot));
        if let Some((carrier, _)) = wrong {
            let message = format!(
                "{}: node {} is tied to node {carrier}, which is itself tied",
                name(job, entry),
                tie.node
            );
            let help = "use no offsets in a chain of ties, and tie rotations only to masters with \
                        tied rotations; or leave a row of elements between the ties";
            findings.add(Problem::error(format!("tie.{entry}"), message, help));
            continue;
        }
        let mut rounds = 0;
        while tie.masters.iter().any(|c| own.contains_key(&c.0)) && rounds < LONGEST_CHAIN {
            rounds += 1;
            tie.faces.extend(tie.masters.iter().filter_map(|c| on.get(&c.0)).flatten());
            let next = |&(node, share): &(NodeId, f64)| match own.get(&node) {
                Some(next) => next.iter().map(|&(n, s)| (n, s * share)).collect(),
                None => vec![(node, share)],
            };
            tie.masters = tie.masters.iter().flat_map(next).collect();
            whole(&mut tie.masters);
            if tie.masters.iter().any(|c| c.0 == tie.node) {
                rounds = LONGEST_CHAIN;
            }
        }
        if rounds == LONGEST_CHAIN {
            let message = format!(
                "{}: node {} is tied in a circle: its masters are tied to it",
                name(job, entry),
                tie.node
            );
            let help = "tie only one side to the other";
            findings.add(Problem::error(format!("tie.{entry}"), message, help));
            break;
        }
        tie.faces.sort_unstable();
        tie.faces.dedup();
        ties.push(tie);
    }
    ties
}

/// Removes tied nodes from motions: if all masters of a node have a prescribed motion, the node
/// follows them. Reports tied nodes that can come off, and would have no motion then.
pub fn lead(ties: &[Tie], motions: &mut [PrescribedMotion], findings: &mut JobProblems) {
    failure::refuse_motion(ties, motions, findings);
    let tied: HashSet<NodeId> = ties.iter().map(|t| t.node).collect();
    motions.iter_mut().for_each(|m| m.nodes.retain(|n| !tied.contains(n)));
}

/// Reports ties of the nodes of a body that becomes rigid in the run.
fn refuse_timed(ties: &[Tie], body: &RigidBody, findings: &mut JobProblems) {
    let is_member = |id: &NodeId| body.nodes.binary_search(id).is_ok();
    let meets = |tie: &&Tie| is_member(&tie.node) || tie.masters.iter().any(|m| is_member(&m.0));
    let nodes: Vec<NodeId> = ties.iter().filter(meets).map(|tie| tie.node).collect();
    if !nodes.is_empty() {
        let message = format!(
            "{} ties have nodes of a body that becomes rigid in the run: {}",
            nodes.len(),
            named(&nodes)
        );
        let help = "make the body rigid for the whole run, or leave a row of elements between";
        findings.add(Problem::error("tie", message, help));
    }
}

/// Adds tied nodes on rigid bodies to the bodies. Reports nodes that are fixed, moved or rigid
/// already and so cannot be tied.
pub fn join(
    ties: &mut Vec<Tie>,
    bodies: &mut [RigidBody],
    sets: &NodeSets<'_>,
    start: &mut NodeStart,
    findings: &mut JobProblems,
) {
    let mut body_of: HashMap<NodeId, usize> = HashMap::new();
    for (b, body) in bodies.iter().enumerate() {
        if body.window.is_some() {
            refuse_timed(ties, body, findings);
        }
        body_of.extend(body.nodes.iter().map(|&n| (n, b)));
    }
    let fixed = |id: NodeId| sets.place(id).map_or(0, |n| start.fixed[n]);
    let mut list = |nodes: Vec<NodeId>, what: &str, help: &str| {
        if !nodes.is_empty() {
            let message = format!("{} tied nodes {what}: {}", nodes.len(), named(&nodes));
            findings.add(Problem::error("tie", message, help));
        }
    };
    let nodes = |of: &dyn Fn(&Tie) -> bool| {
        ties.iter().filter(|t| of(t)).map(|t| t.node).collect::<Vec<_>>()
    };
    let rigid = nodes(&|t| body_of.contains_key(&t.node));
    list(rigid, "belong to rigid bodies", "tie the nodes of the other side to the body");
    // A constraint of all masters also constrains their node.
    let held = nodes(&|t| {
        let all = t.masters.iter().fold(u64::MAX, |bits, c| bits & fixed(c.0));
        let tied = if t.rotations { 0b11_1111 } else { 0b111 };
        !body_of.contains_key(&t.node) && fixed(t.node) & tied & !all != 0
    });
    let help = "remove them from the tie's nodes, or from [[fix]], [[symmetry]] and [[motion]]";
    list(held, "have another constraint or motion", help);
    let breaking =
        nodes(&|t| t.failure.is_some() && t.masters.iter().any(|c| body_of.contains_key(&c.0)));
    let help = "tie the nodes of the body to the other side, or remove `failure`";
    list(breaking, "can fail and are on faces of rigid bodies, whose members they become", help);
    let body = |t: &Tie| {
        let mut all = t.masters.iter().map(|c| body_of.get(&c.0).copied());
        let first = all.next().flatten();
        (first, all.all(|b| b == first))
    };
    let split = nodes(&|t| {
        let any = t.masters.iter().any(|c| body_of.contains_key(&c.0));
        any && !matches!(body(t), (Some(_), true))
    });
    list(
        split,
        "are on faces that are only partly rigid",
        "leave a row of elements between, or make the whole face rigid",
    );
    report_velocities(ties.iter().filter(|t| body(t).0.is_none()), sets, start, findings);
    ties.retain(|tie| match body(tie) {
        (Some(b), true) => {
            bodies[b].nodes.push(tie.node);
            sets.place(tie.node).into_iter().for_each(|n| start.fixed[n] |= 0b11_1111);
            false
        }
        _ => true,
    });
    for body in bodies {
        body.nodes.sort_unstable();
        body.nodes.dedup();
    }
}
