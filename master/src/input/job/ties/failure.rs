//! Limits of ties that fail, as forces on single nodes, and the faces on which they act.

use super::{Projected, TieContext, name, named};
use crate::input::job::loads::outer_faces;
use crate::input::job::validate::JobProblems;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{Job, TieFailureInput, TieInput, TieLimits};
use crumple_proto::loads::PrescribedMotion;
use crumple_proto::mesh::{Mesh, MeshElement, face_key, once_each};
use crumple_proto::problem::Problem;
use crumple_proto::tie::{Tie, TieStrength};
use crumple_worker::constraints::ties::project::{FaceCorners, diagonal};
use nalgebra::Vector3;
use std::collections::{HashMap, HashSet};

/// Distance from the plane of a face, over its size, below which it is round-off.
const NO_SIDE: f64 = 1e-6;

/// Checks the limits of an entry; `path` returns the path of a key.
pub(super) fn check(spec: &TieInput, path: impl Fn(&str) -> String, findings: &mut JobProblems) {
    let Some(TieFailureInput { limits: _, normal, shear, exponents: [n, m], opening }) =
        spec.failure
    else {
        return;
    };
    let mut wrong = |key: &str, message: String, help: &str| {
        findings.add(Problem::error(path(key), message, help));
    };
    for (key, value) in [("normal", normal), ("shear", shear), ("opening", opening)] {
        if !(value >= 0.0 && value.is_finite()) {
            let help = "give a number from 0 on; 0 leaves the term out";
            wrong(&format!("failure.{key}"), format!("{key} of a tie is {value}"), help);
        }
    }
    if normal == 0.0 && shear == 0.0 {
        let help = "give `normal`, `shear` or both; or remove `failure`";
        wrong("failure", "the failure of a tie has no limit".into(), help);
    }
    if !(n > 0.0 && m > 0.0 && n.is_finite() && m.is_finite()) {
        let message = format!("exponents of a tie are {n}, {m}");
        wrong("failure.exponents", message, "give two numbers above 0; default 2 and 2");
    }
    if spec.node.is_some() || spec.mean_of.is_some() {
        let message = "a tie without a surface has a `failure`".to_string();
        wrong("failure", message, "name `parts` or `faces`: only ties to faces can fail");
    }
}

/// Returns the corners of a face, in an order that turns its normal towards the elements of a
/// node. `centre` is the mean centre of these [length].
pub(super) fn facing(
    corners: [NodeId; 4],
    places: &FaceCorners,
    point: [f64; 3],
    centre: [f64; 3],
) -> [NodeId; 4] {
    let [a, b, c, d] = places.map(Vector3::from);
    let normal = (c - a).cross(&(d - b));
    match normal.dot(&(Vector3::from(centre) - Vector3::from(point))) < 0.0 {
        true => [corners[0], corners[3], corners[2], corners[1]],
        false => corners,
    }
}

/// Returns the mean centre of the elements of each node [length].
pub(super) fn centres(context: &TieContext<'_>) -> HashMap<NodeId, [f64; 3]> {
    let mut sums: HashMap<NodeId, (Vector3<f64>, f64)> = HashMap::new();
    for element in &context.mesh.elements {
        let corners = element.corners();
        let sum: Vector3<f64> = corners.iter().map(|&n| Vector3::from(context.place(n))).sum();
        for &n in corners {
            let (of, count) = sums.entry(n).or_insert((Vector3::zeros(), 0.0));
            *of += sum / corners.len() as f64;
            *count += 1.0;
        }
    }
    sums.into_iter().map(|(n, (sum, count))| (n, (sum / count).into())).collect()
}

/// Multiplies the limits of stresses by the areas of the nodes: their shares of the faces between
/// tied nodes that are not faces of the surface itself, `own`.
pub(super) fn scale(
    context: &TieContext<'_>,
    entry: usize,
    own: impl Fn(&(usize, usize)) -> bool,
    projected: &mut [Projected],
    findings: &mut JobProblems,
) {
    let TieContext { job, mesh, free, .. } = context;
    let given = job.tie[entry].failure.as_ref().map(|failure| failure.limits);
    if given != Some(TieLimits::Stress) {
        return;
    }
    let mut tied: Vec<NodeId> = projected.iter().map(|s| s.tie.node).collect();
    tied.sort_unstable();
    let mut areas: HashMap<NodeId, f64> = HashMap::new();
    let between = outer_faces(mesh, free, |_| true, Some(&tied));
    // A skin of shells has the nodes of the faces of its solids: the area is there once.
    let mut seen: HashSet<[NodeId; 4]> = HashSet::new();
    for (element, face) in between.into_iter().filter(|face| !own(face)) {
        let element = &mesh.elements[element];
        let corners = &element.shape.faces()[face];
        if !seen.insert(face_key(corners.map(|k| element.nodes[k]))) {
            continue;
        }
        let [a, b, c, d] = corners.map(|k| Vector3::from(context.place(element.nodes[k])));
        let area = 0.5 * (c - a).cross(&(d - b)).norm();
        let corners = once_each(corners);
        for &k in corners {
            *areas.entry(element.nodes[k]).or_default() += area / corners.len() as f64;
        }
    }
    let mut bare = Vec::new();
    for s in projected {
        let area = areas.get(&s.tie.node).copied().unwrap_or(0.0);
        let strength = s.tie.failure.as_mut();
        strength.into_iter().flat_map(|f| &mut f.limits).for_each(|limit| *limit *= area);
        if area == 0.0 {
            bare.push(s.tie.node);
        }
    }
    if !bare.is_empty() {
        let message = format!(
            "{}: {} nodes have no area, because no face has all its nodes among the tied ones: {}",
            name(job, entry),
            bare.len(),
            named(&bare)
        );
        let help = "add the other nodes of their faces to the set, or give the limits as forces \
                    (limits = \"force\")";
        findings.add(Problem::error(format!("tie.{entry}.failure.limits"), message, help));
    }
}

/// Reports nodes in the plane of their face, with elements on neither side of it, if their tension
/// has a limit. `centres` are the mean centres of the elements of nodes [length].
pub(super) fn refuse_without_side(
    context: &TieContext<'_>,
    entry: usize,
    centres: &HashMap<NodeId, [f64; 3]>,
    projected: &[Projected],
    findings: &mut JobProblems,
) {
    let place = |id: NodeId| Vector3::from(context.place(id));
    let has_no_side = |tie: &Tie| {
        let Some(strength) = tie.failure.as_ref().filter(|f| f.limits[0].is_finite()) else {
            return false;
        };
        let corners = strength.corners.map(place);
        let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1])).normalize();
        let foot: Vector3<f64> = tie.masters.iter().map(|&(id, share)| place(id) * share).sum();
        let centre = centres.get(&tie.node).map_or(foot, |&c| Vector3::from(c));
        let size = diagonal(&corners.map(Into::into));
        normal.dot(&(centre - foot)).abs() <= NO_SIDE * size
    };
    let nodes: Vec<NodeId> =
        projected.iter().map(|s| &s.tie).filter(|tie| has_no_side(tie)).map(|t| t.node).collect();
    if !nodes.is_empty() {
        let message = format!(
            "{}: {} nodes are in the plane of their face with elements on neither side, so that \
             tension and compression are the same: {}",
            name(context.job, entry),
            nodes.len(),
            named(&nodes)
        );
        let help = "put them half a thickness off the face; or give only a limit of the shear";
        findings.add(Problem::error(format!("tie.{entry}.failure"), message, help));
    }
}

/// Returns the limits of an entry and the face on which they act.
pub(super) fn strength(spec: &TieInput, corners: [NodeId; 4]) -> Option<TieStrength> {
    let limit = |given: f64| if given > 0.0 { given } else { f64::INFINITY };
    spec.failure.as_ref().map(|failure| TieStrength {
        limits: [limit(failure.normal), limit(failure.shear)],
        exponents: failure.exponents,
        opening: failure.opening,
        corners,
    })
}

/// Reports ties that can fail between elements of parts, or at nodes, with a gravity or a damping
/// of their own. Its force on the mass of the slaves is not known to their ties, and after a
/// failure slaves and masters would keep the shares that they had together.
pub(super) fn refuse_partial_loads(
    job: &Job,
    mesh: &Mesh,
    ties: &[Tie],
    findings: &mut JobProblems,
) {
    let breakable: Vec<&Tie> = ties.iter().filter(|tie| tie.failure.is_some()).collect();
    if breakable.is_empty() {
        return;
    }
    let faces: HashSet<ElemId> =
        breakable.iter().flat_map(|tie| tie.faces.iter().copied()).collect();
    let slaves: HashSet<NodeId> = breakable.iter().map(|tie| tie.node).collect();
    let meets = |e: &&MeshElement| {
        faces.contains(&e.id) || e.corners().iter().any(|node| slaves.contains(node))
    };
    let parts: HashSet<u32> = mesh.elements.iter().filter(meets).map(|e| e.part).collect();
    let sets = job.gravity.iter().enumerate().filter_map(|(i, g)| Some((i, g.nodes.as_ref()?)));
    let tied: HashSet<NodeId> =
        mesh.elements.iter().filter(meets).flat_map(|e| e.corners().to_vec()).collect();
    for (entry, name) in sets {
        let own = mesh.node_sets.get(name).into_iter().flatten();
        if let Some(node) = own.into_iter().find(|node| tied.contains(node)) {
            let message = format!(
                "ties that can fail join elements of node {node}, which has a gravity of its own: \
                 its force on tied nodes is not known to their ties, nor divided again after a \
                 failure"
            );
            let help = "let the gravity act on all, without `nodes`; or remove `failure`";
            findings.add(Problem::error(format!("gravity.{entry}.nodes"), message, help));
        }
    }
    let gravity = job.gravity.iter().map(|g| &g.parts).enumerate();
    let damping = job.damping.iter().map(|d| &d.parts).enumerate();
    let all =
        gravity.map(|entry| ("gravity", entry)).chain(damping.map(|entry| ("damping", entry)));
    for (what, (entry, own)) in all {
        if let Some(part) = own.iter().find(|part| parts.contains(part)) {
            let message = format!(
                "ties that can fail join part {part}, which has a {what} of its own: its force on \
                 tied nodes is not known to their ties, nor divided again after a failure"
            );
            let help = match what {
                "gravity" => "let the gravity act on all, without `parts`; or remove `failure`",
                _ => "use `time.damping`, which acts on all; or remove `failure`",
            };
            findings.add(Problem::error(format!("{what}.{entry}.parts"), message, help));
        }
    }
}

/// Reports ties that can fail with slaves in a prescribed motion, which they would not have after
/// the failure.
pub(super) fn refuse_motion(
    ties: &[Tie],
    motions: &[PrescribedMotion],
    findings: &mut JobProblems,
) {
    let breakable: HashSet<NodeId> =
        ties.iter().filter(|tie| tie.failure.is_some()).map(|tie| tie.node).collect();
    for (entry, motion) in motions.iter().enumerate() {
        let nodes: Vec<NodeId> =
            motion.nodes.iter().filter(|n| breakable.contains(n)).copied().collect();
        if !nodes.is_empty() {
            let message = format!(
                "{} tied nodes can come off and have a prescribed motion that they would lose: {}",
                nodes.len(),
                named(&nodes)
            );
            let help = "remove them from [[motion]], or from the nodes of the tie";
            findings.add(Problem::error(format!("motion.{entry}.nodes"), message, help));
        }
    }
}

/// Reports ties that can fail and have tied nodes among the corners of their faces, or whose slave
/// carries another tied node.
pub(super) fn refuse_chains(ties: &[Tie], findings: &mut JobProblems) {
    if ties.iter().all(|tie| tie.failure.is_none()) {
        return;
    }
    let of = |id: &NodeId| ties.binary_search_by_key(id, |t| t.node).ok().map(|at| &ties[at]);
    let mut chained: Vec<NodeId> = Vec::new();
    for tie in ties {
        let corners = tie.failure.iter().flat_map(|f| f.corners.iter());
        let meets =
            |id: &NodeId| of(id).is_some_and(|t| t.failure.is_some() || tie.failure.is_some());
        if tie.masters.iter().map(|m| &m.0).chain(corners).any(meets) {
            chained.push(tie.node);
        }
    }
    if !chained.is_empty() {
        let message = format!(
            "{} nodes are in a chain of ties of which one can fail: {}",
            chained.len(),
            named(&chained)
        );
        let help = "tie each node of a face only to one side: leave a row of elements between \
                    the ties, or use a tie without `failure`";
        findings.add(Problem::error("tie", message, help));
    }
}
