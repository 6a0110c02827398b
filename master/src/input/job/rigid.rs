//! Rigid bodies of a job: checks, and conversion to numbers and ids.

use super::loads::{Curves, DOFS, dof_bits, motion_form};
use super::state::{NodeSets, NodeStart, are_apart};
use super::turning_nodes;
use super::validate::{JobProblems, nearest};
use super::walls::unit;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, Rigid, RigidLoad, RigidStop};
use crumple_proto::loads::PrescribedMotion;
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::rigid::{BodyLoad, BodyStop, RigidBody};
use std::collections::{BTreeSet, HashMap, HashSet};

/// All degrees of freedom of a node.
const ALL: u64 = 0b11_1111;

/// Resolves the rigid bodies of a job and their motions. Marks their nodes as fixed in `start`.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    sets: &NodeSets<'_>,
    start: &mut NodeStart,
    findings: &mut JobProblems,
) -> Vec<RigidBody> {
    let mut bodies: Vec<RigidBody> = Vec::new();
    if job.rigid.is_empty() {
        return bodies;
    }
    let mut owner: HashMap<NodeId, Vec<usize>> = HashMap::new();
    let context = BodyContext::new(job, mesh, sets);
    for (i, rigid) in job.rigid.iter().enumerate() {
        let path = format!("rigid.{i}");
        numbers(rigid, i, job, findings);
        let fixed = dof_bits(&rigid.fixed, &format!("{path}.fixed"), findings);
        let nodes = members(rigid, &path, &context, findings);
        let window = window(rigid, i, job, findings);
        let meets = |other: usize| match (bodies[other].window, window) {
            (Some(one), Some(own)) => !are_apart(one, own),
            _ => true,
        };
        let shared = |id: &NodeId| owner.get(id)?.iter().copied().find(|&o| meets(o));
        if let Some((other, first)) = nodes.iter().find_map(|id| Some((shared(id)?, *id))) {
            let message = format!(
                "rigid bodies `{}` and `{}` have nodes in common; the first is node {first}",
                job.rigid[other].name, rigid.name
            );
            findings.add(Problem::error(
                &path,
                message,
                "merge them into one body, or leave a row of elements between them",
            ));
        }
        nodes.iter().for_each(|id| owner.entry(*id).or_default().push(i));
        let held: Vec<NodeId> = nodes
            .iter()
            .copied()
            .filter(|&id| sets.place(id).is_some_and(|n| start.fixed[n] != 0))
            .collect();
        if let Some(first) = held.first() {
            let message = format!(
                "{} nodes of rigid body `{}` have another constraint or motion; \
                 the first is node {first}",
                held.len(),
                rigid.name
            );
            let help = "remove them from [[fix]], [[symmetry]] and [[motion]]; constrain the body \
                        by `fixed`, or move it by a [[motion]] with `rigid` (in a deck: cmo, con1 \
                        and con2 of its *MAT_RIGID, or *BOUNDARY_PRESCRIBED_MOTION_RIGID)";
            findings.add(Problem::error(&path, message, help));
        }
        let parts = (0u32..)
            .zip(&settings.parts)
            .filter(|(_, p)| rigid.parts.contains(&p.id))
            .map(|(k, _)| k)
            .collect();
        let (inertia, added_inertia) = (rigid.inertia, rigid.added_inertia);
        let (motions, stops, loads) = (Vec::new(), Vec::new(), Vec::new());
        bodies.push(RigidBody {
            nodes,
            parts,
            fixed,
            inertia,
            added_inertia,
            motions,
            window,
            stops,
            loads,
        });
    }
    for body in bodies.iter().filter(|body| body.window.is_none()) {
        body.nodes.iter().filter_map(|&id| sets.place(id)).for_each(|n| start.fixed[n] |= ALL);
    }
    motions(job, &mut bodies, findings);
    stops(job, &mut bodies, findings);
    loads(job, &mut bodies, findings);
    bodies
}

/// Returns the times at which a body becomes rigid and deformable again; `None` for a body that is
/// rigid in the whole run. Reports keys that cannot be combined with such times.
fn window(rigid: &Rigid, i: usize, job: &Job, findings: &mut JobProblems) -> Option<[f64; 2]> {
    let path = |key: &str| format!("rigid.{i}.{key}");
    if rigid.from == 0.0 && rigid.until.is_none() {
        return None;
    }
    let mut refuse = |key: &str, message: &str, help: &str| {
        let message = format!("rigid body `{}` {message}", rigid.name);
        findings.add(Problem::error(path(key), message, help));
    };
    if rigid.from < 0.0 || rigid.until.is_some_and(|until| until <= rigid.from) {
        refuse("from", "ends before it begins", "give a `from` of 0 or above and a later `until`");
    }
    if rigid.from == 0.0 {
        let help = "give a `from` above 0; parts that are rigid first need a material that deforms";
        refuse("until", "begins at 0 and ends", help);
    }
    let has_inertia = rigid.inertia.is_some() || rigid.added_inertia.is_some();
    if rigid.mass.is_some() || has_inertia || rigid.centre.is_some() {
        let help = "remove them: they are those of its nodes at that time";
        refuse("mass", "becomes rigid in the run and has a mass or inertia, or a centre", help);
    }
    let joined = |name: &String| *name == rigid.name;
    if job.joint.iter().any(|joint| joint.bodies.iter().any(joined)) {
        refuse("from", "becomes rigid in the run and has a joint", "join a body of other parts");
    }
    if job.motion.iter().any(|motion| motion.rigid.as_ref().is_some_and(joined)) {
        let help = "move a node set, or make the body rigid for the whole run";
        refuse("from", "becomes rigid in the run and has a prescribed motion", help);
    }
    if !rigid.stop.is_empty() {
        let help = "remove it, or make the body rigid for the whole run";
        refuse("stop", "becomes rigid in the run and has a stop", help);
    }
    if !rigid.load.is_empty() {
        let help = "load its nodes by a [[load]], or make the body rigid for the whole run";
        refuse("load", "becomes rigid in the run and has a load", help);
    }
    if job.time.subcycles > 1 {
        refuse("from", "becomes rigid in a run with subcycles", "remove `time.subcycles`");
    }
    Some([rigid.from, rigid.until.unwrap_or(f64::MAX)])
}

/// Checks names, masses and inertias.
fn numbers(rigid: &Rigid, i: usize, job: &Job, findings: &mut JobProblems) {
    let path = |key: &str| format!("rigid.{i}.{key}");
    if rigid.name.is_empty() {
        findings.add(Problem::error(
            path("name"),
            "a rigid body has no name",
            "give it a name: motions refer to it by name",
        ));
    } else if job.rigid[..i].iter().any(|r| r.name == rigid.name) {
        let message = format!("two entries of [[rigid]] have the name `{}`", rigid.name);
        findings.add(Problem::error(path("name"), message, "give each its own name"));
    }
    for (k, id) in rigid.parts.iter().enumerate() {
        if !job.part.iter().any(|p| p.id == *id) {
            let ids: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
            let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
            let help = nearest(&id.to_string(), &ids);
            findings.add(Problem::error(
                path(&format!("parts.{k}")),
                format!("rigid: there is no part {id}"),
                help,
            ));
        }
    }
    if let Some(mass) = rigid.mass {
        if mass <= 0.0 {
            findings.add(Problem::error(
                path("mass"),
                format!("`mass` is {mass:?}"),
                "it has to be above 0",
            ));
        } else if rigid.parts.is_empty() {
            let help = "name its `parts`, or give its nodes a mass by a [[mass]]";
            findings.add(Problem::error(
                path("mass"),
                "`mass` is the mass of the body's parts, but the body has none",
                help,
            ));
        }
    }
    if rigid.centre.is_some_and(|centre| centre.iter().any(|x| !x.is_finite())) {
        findings.add(Problem::error(path("centre"), "`centre` is not finite", "give [x, y, z]"));
    }
    if rigid.centre.is_some() && rigid.parts.is_empty() {
        let message = "`centre` is that of the masses of the body's parts, but the body has none";
        findings.add(Problem::error(path("centre"), message, "name its `parts`, or remove it"));
    }
    if rigid.inertia.is_some_and(|inertia| !is_inertia(inertia, 0.0)) {
        let help = "give xx, yy, zz, xy, yz, zx of a positive definite matrix in which no moment \
                    exceeds the sum of the other two";
        findings.add(Problem::error(
            path("inertia"),
            "no distribution of mass has this inertia",
            help,
        ));
    }
    if let Some(added) = rigid.added_inertia {
        // The inertia of a bar about its axis may be zero.
        let largest = added.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        if added != [0.0; 6] && !is_inertia(added, 1e-6 * largest) {
            let help = "give xx, yy, zz, xy, yz, zx of a matrix without negative moments in which \
                        no moment exceeds the sum of the other two";
            let message = "no distribution of mass has this `added_inertia`";
            findings.add(Problem::error(path("added_inertia"), message, help));
        }
    }
}

/// Excess of a moment over the sum of the other two that rounding explains: moments of thin plates
/// are often given with three to five digits.
const ROUNDED: f64 = 1e-3;

/// Returns true if a distribution of mass has this inertia, to which a sphere is added, whose
/// moment may be 0.
fn is_inertia([xx, yy, zz, xy, yz, zx]: [f64; 6], sphere: f64) -> bool {
    let [xx, yy, zz] = [xx, yy, zz].map(|moment| moment + sphere);
    // Sylvester's criterion for a positive definite matrix, then the triangle inequality in these
    // axes, which holds for every body.
    let minor = xx * yy - xy * xy;
    let whole = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
    let triangle = |a: f64, b: f64, c: f64| a <= (1.0 + ROUNDED) * (b + c);
    let triangle = triangle(xx, yy, zz) && triangle(yy, zz, xx) && triangle(zz, xx, yy);
    xx > 0.0 && minor > 0.0 && whole > 0.0 && triangle
}

/// Data of a mesh that all bodies need.
struct BodyContext<'a> {
    mesh: &'a Mesh,
    sets: &'a NodeSets<'a>,
    /// Indices of the elements of each part.
    of_part: HashMap<u32, Vec<usize>>,
    /// Nodes with rotational inertia of their own.
    turning: HashSet<NodeId>,
}

impl<'a> BodyContext<'a> {
    fn new(job: &Job, mesh: &'a Mesh, sets: &'a NodeSets<'a>) -> Self {
        let mut of_part: HashMap<u32, Vec<usize>> = HashMap::new();
        for (at, e) in mesh.elements.iter().enumerate() {
            of_part.entry(e.part).or_default().push(at);
        }
        Self { mesh, sets, of_part, turning: turning_nodes(job, mesh) }
    }
}

/// Returns the nodes of a body, ascending.
fn members(
    rigid: &Rigid,
    path: &str,
    context: &BodyContext<'_>,
    findings: &mut JobProblems,
) -> Vec<NodeId> {
    let BodyContext { mesh, sets, of_part, turning } = context;
    if rigid.parts.is_empty() && rigid.nodes.is_none() {
        let help = "name `parts`, a node set as `nodes`, or both";
        findings.add(Problem::error(path, "a rigid body has no parts and no nodes", help));
    }
    let of_parts = rigid.parts.iter().filter_map(|part| of_part.get(part)).flatten();
    let mut nodes: BTreeSet<NodeId> =
        of_parts.flat_map(|&e| mesh.elements[e].corners()).copied().collect();
    if let Some(name) = &rigid.nodes {
        nodes.extend(sets.ids(name, format!("{path}.nodes"), findings).into_iter().flatten());
    }
    let at = |id: &NodeId| sets.place(*id).map(|n| mesh.nodes[n].x);
    let points: Vec<[f64; 3]> = nodes.iter().filter_map(at).collect();
    let turns = nodes.iter().any(|n| turning.contains(n));
    if !points.is_empty() && on_a_line(&points) && !turns {
        let message = format!("the nodes of rigid body `{}` lie on one line", rigid.name);
        findings.add(Problem::error(
            path,
            message,
            "give it at least three nodes off one line, or a node of a shell or beam",
        ));
    }
    nodes.into_iter().collect()
}

fn on_a_line(points: &[[f64; 3]]) -> bool {
    let from = |p: &[f64; 3]| [0, 1, 2].map(|c| p[c] - points[0][c]);
    let square = |d: [f64; 3]| d.iter().map(|c| c * c).sum::<f64>();
    let along = points
        .iter()
        .map(from)
        .max_by(|a, b| square(*a).total_cmp(&square(*b)))
        .unwrap_or_default();
    let off = |d: [f64; 3]| {
        square([
            d[1] * along[2] - d[2] * along[1],
            d[2] * along[0] - d[0] * along[2],
            d[0] * along[1] - d[1] * along[0],
        ])
    };
    let far = square(along);
    // 1e-9 of the length is below the precision of coordinates in mesh files.
    points.iter().map(from).all(|d| off(d) <= 1e-18 * far * far)
}

/// Resolves the motions that name a body.
fn motions(job: &Job, bodies: &mut [RigidBody], findings: &mut JobProblems) {
    let curves = Curves::quietly(job);
    for (i, m) in job.motion.iter().enumerate() {
        let Some(name) = &m.rigid else { continue };
        let path = format!("motion.{i}");
        let Some(body) = job.rigid.iter().position(|r| r.name == *name) else {
            let names: Vec<&str> = job.rigid.iter().map(|r| r.name.as_str()).collect();
            let message = format!("there is no rigid body `{name}`");
            findings.add(Problem::error(format!("{path}.rigid"), message, nearest(name, &names)));
            continue;
        };
        if m.nodes.is_some() {
            let help = "give either `nodes` or `rigid`";
            findings.add(Problem::error(
                &path,
                "a motion has both a node set and a rigid body",
                help,
            ));
        }
        if m.centre != [0.0; 3] {
            let help = "remove `centre`: a rigid body rotates about its own centre";
            findings.add(Problem::error(
                format!("{path}.centre"),
                "the motion of a rigid body has a `centre`",
                help,
            ));
        }
        let Some((motion, dofs)) = motion_form(m, i, &curves, findings) else { continue };
        let spins = motion.form.centre().is_some();
        let dofs = dofs.unwrap_or(if spins { 0b11_1000 } else { 0b111 });
        let body = &mut bodies[body];
        let meets = |m: &&PrescribedMotion| match (m.window, motion.window) {
            (Some(one), Some(other)) => !are_apart(one, other),
            _ => true,
        };
        let others = body.motions.iter().filter(meets);
        let taken = others.fold(body.fixed, |bits, m| bits | m.dofs) & dofs;
        if taken != 0 {
            let names: Vec<&str> =
                (0..6).filter(|b| taken >> b & 1 == 1).map(|b| DOFS[b]).collect();
            let message = format!(
                "rigid body `{name}` is not free to follow this motion in {}",
                names.join(", ")
            );
            let help =
                "remove them from its `fixed` or from the other motion, or name other `dofs` here";
            findings.add(Problem::error(&path, message, help));
        }
        body.motions.push(PrescribedMotion { dofs, ..motion });
    }
}

/// Resolves the loads of bodies.
fn loads(job: &Job, bodies: &mut [RigidBody], findings: &mut JobProblems) {
    let curves = Curves::quietly(job);
    for (i, (rigid, body)) in job.rigid.iter().zip(bodies).enumerate() {
        for (k, load) in rigid.load.iter().enumerate() {
            let path = format!("rigid.{i}.load.{k}");
            let RigidLoad { force, moment, follows, .. } = *load;
            if !force.iter().chain(&moment).all(|c| c.is_finite()) {
                let message = format!("a load of rigid body `{}` is not finite", rigid.name);
                findings.add(Problem::error(&path, message, "give three numbers each"));
            }
            if [force, moment] == [[0.0; 3]; 2] {
                let message = format!("a load of rigid body `{}` is zero", rigid.name);
                findings.add(Problem::error(&path, message, "give `force`, `moment`, or both"));
            }
            let curve = curves.find(&load.curve, &format!("{path}.curve"), findings);
            body.loads.push(BodyLoad { force, moment, curve, follows });
        }
    }
}

/// Resolves the stops of bodies. The motions of the bodies are known.
fn stops(job: &Job, bodies: &mut [RigidBody], findings: &mut JobProblems) {
    let curves = Curves::quietly(job);
    for (i, (rigid, body)) in job.rigid.iter().zip(bodies).enumerate() {
        for (k, stop) in rigid.stop.iter().enumerate() {
            let path = format!("rigid.{i}.stop.{k}");
            let mut refuse = |key: &str, message: &str, help: &str| {
                let message = format!("a stop of rigid body `{}` {message}", rigid.name);
                let path = if key.is_empty() { path.clone() } else { format!("{path}.{key}") };
                findings.add(Problem::error(path, message, help));
            };
            let Some(direction) = unit(stop.direction) else {
                let help = "give a vector that is not zero, such as [1, 0, 0]";
                refuse("direction", "has no direction", help);
                continue;
            };
            if stop.lower.is_none() && stop.upper.is_none() {
                refuse("", "has no bound", "give `lower`, `upper`, or both: names of curves");
            }
            if stop.birth < 0.0 || stop.death.is_some_and(|death| death <= stop.birth) {
                let message = format!(
                    "begins at {:?} and ends at {:?}",
                    stop.birth,
                    stop.death.unwrap_or(f64::INFINITY)
                );
                let help = "give a `birth` of 0 or above, and a `death` above it";
                refuse("birth", &message, help);
            }
            let held = body.motions.iter().fold(body.fixed, |bits, m| bits | m.dofs);
            if (0..3).all(|c| direction[c] == 0.0 || held >> c & 1 == 1) {
                let help = "remove the stop, or free its direction in `fixed` and in [[motion]]";
                refuse("direction", "acts along a direction in which the body cannot move", help);
            }
            if let Some((key, value)) = beyond_at_start(stop, &curves) {
                let message =
                    format!("does not admit the place at the start: `{key}` is {value:?}");
                let help = "a displacement is 0 at the start: give a lower bound of 0 or below, an \
                            upper one of 0 or above, or `position = true` for coordinates";
                refuse(key, &message, help);
            }
            let mut find = |key: &str, name: &Option<String>| {
                curves.find(name, &format!("{path}.{key}"), findings)
            };
            let (lower, upper) = (find("lower", &stop.lower), find("upper", &stop.upper));
            let is_whole = stop.birth <= 0.0 && stop.death.is_none();
            let window = (!is_whole).then_some([stop.birth, stop.death.unwrap_or(f64::MAX)]);
            let of_position = stop.position;
            body.stops.push(BodyStop { direction, lower, upper, of_position, window });
        }
    }
}

/// Returns the bound of a displacement that does not contain 0 at the start, and its value.
fn beyond_at_start(stop: &RigidStop, curves: &Curves<'_>) -> Option<(&'static str, f64)> {
    if stop.position || stop.birth > 0.0 {
        return None;
    }
    let start = |name: &Option<String>| curves.start(name.as_ref()?);
    let lower = start(&stop.lower).filter(|&value| value > 0.0).map(|value| ("lower", value));
    lower.or(start(&stop.upper).filter(|&value| value < 0.0).map(|value| ("upper", value)))
}
