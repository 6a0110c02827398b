//! Stable steps of springs from the masses at their ends, nodes without mass, and the reduced
//! steps of other elements at these nodes.
//!
//! The mass of a node is divided among the elements connected to it, because the frequencies of
//! parts of a model with their own fractions of mass bound those of the whole (Irons & Treharne
//! 1971). If there are only springs, they get all of it. Otherwise let q be the fraction of the
//! mass with which the springs are stable at the step of the smallest other element of the model,
//! but at most [`MOST`]. Springs get `q / (1 + q)` of the mass and elements the rest, which
//! reduces the step of elements by the factor `1 / sqrt(1 + q)`. Springs divide their part in
//! proportion to the mass that each of them needs.
//!
//! A node that is tied with an offset leaves its elements and springs the fraction [`ARM_SHARE`]
//! of their mass.
//!
//! Elements with less than their mass use the stable step of a single element. A regular mesh is
//! stable at a larger step, but this is not known for a mesh with springs or ties. `time.safety`
//! therefore remains available for other effects.

use super::laws::BuiltElements;
use super::state::{ElementStart, NodeSets, NodeStart};
use super::ties::mean::excess as tie_excess;
use super::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::rigid::RigidBody;
use crumple_worker::constraints::ties::ARM_SHARE;
use crumple_worker::fem::elements::Discrete;
use std::collections::HashMap;

/// Largest q, see above: elements lose at most a tenth of their step, and stiffer springs have a
/// shorter step.
const MOST: f64 = 0.2;

/// Finds the nodes that directions of springs follow; returns them with the indices of the parts.
pub fn followed(
    job: &Job,
    settings: &Settings,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Vec<(u32, [NodeId; 2])> {
    let mut all = Vec::new();
    for (part, index) in settings.parts.iter().zip(0..) {
        let Some(ids) = part.spring.as_ref().and_then(|spring| spring.direction_nodes) else {
            continue;
        };
        let place = job.part.iter().position(|p| p.id == part.id).unwrap_or(0);
        let path = format!("part.{place}.spring.direction_nodes");
        let mut fault = |message: String, help: &str| {
            let message = format!("part {}: {message}", part.label());
            findings.add(Problem::error(&path, message, help));
        };
        let [Some(first), Some(second)] = ids.map(|id| sets.labelled(id)) else {
            let unknown = ids.into_iter().find(|&id| sets.labelled(id).is_none());
            let id = unknown.unwrap_or_default();
            let message = format!(
                "the direction of its springs follows node {id}, which no \
                                   element has"
            );
            fault(message, "name nodes that elements have, best of a rigid body");
            continue;
        };
        if sets.coordinates(ids[0]) == sets.coordinates(ids[1]) {
            let message = format!(
                "the direction of its springs is that from node {} to node {}, which are at one \
                 place",
                ids[0], ids[1]
            );
            fault(message, "name two nodes that are apart");
        }
        all.push((index, [first, second]));
    }
    all
}

/// Data of a node for its springs.
#[derive(Clone, Copy, Default)]
struct SpringNode {
    /// Mass [mass].
    mass: f64,
    /// True if other elements are connected to it.
    shared: bool,
    /// True if its motion is fixed or prescribed, so that no force accelerates it.
    held: bool,
    /// True if its rotation is fixed or prescribed.
    turn_held: bool,
    /// Reciprocal of the fraction of its mass that a tie with an offset leaves its elements and
    /// springs; 0 without one.
    arm: f64,
    /// Index of its rigid body.
    body: Option<usize>,
    /// Fraction of its mass with which its springs are stable at the step of other elements.
    need: f64,
}

impl SpringNode {
    /// Returns the fraction of its mass that an offset leaves its elements and springs.
    fn arm_share(&self) -> f64 {
        if self.arm > 0.0 { 1.0 / self.arm } else { 1.0 }
    }
}

/// A spring of the mesh.
struct MeshSpring {
    /// Index of its element.
    element: usize,
    /// Indices of its nodes.
    nodes: [usize; 2],
    discrete: Discrete,
}

/// Sets the stable steps of springs in `start`, and the reduced steps of other elements at
/// springs and ties. Reports free nodes without mass, and springs without length.
pub fn steps(
    mesh: &Mesh,
    settings: &Settings,
    blocks: &BuiltElements,
    nodes: &NodeStart,
    start: &mut ElementStart,
    findings: &mut JobProblems,
) {
    let place: HashMap<NodeId, usize> =
        mesh.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect();
    let springs = find_springs(mesh, blocks, start, &place, findings);
    let ends = of_nodes(mesh, settings, nodes, start, &place);
    massless(mesh, &ends, findings);
    if springs.is_empty() && !ends.iter().any(|e| e.arm > 0.0) {
        return;
    }
    let bodies = settings.rigid.iter().map(|b| BodyMass::new(b, mesh, &ends, &place)).collect();
    let mut masses = Masses { mesh, ends, bodies };
    masses.without_inertia(&springs, findings);
    let needs = masses.needs(&springs, start);
    masses.add_needs(&springs, &needs);
    for (spring, &need) in springs.iter().zip(&needs).filter(|(_, need)| **need > 0.0) {
        let soft = spring.nodes.map(|n| masses.softness(n, &spring.discrete, Some(need)));
        start.stable_dt[spring.element] = spring.discrete.stable_dt(soft.iter().sum());
    }
    reduce_steps(&masses, blocks, start, &place);
}

/// Returns the springs of the mesh, and reports springs without length.
fn find_springs(
    mesh: &Mesh,
    blocks: &BuiltElements,
    start: &ElementStart,
    place: &HashMap<NodeId, usize>,
    findings: &mut JobProblems,
) -> Vec<MeshSpring> {
    let mut springs = Vec::new();
    let mut short: Vec<&MeshElement> = Vec::new();
    for (i, element) in mesh.elements.iter().enumerate().filter(|(_, e)| e.shape == Shape::Line2) {
        let formulation = blocks.element(start.part[i] as usize, element.shape);
        let Some(discrete) = formulation.and_then(|f| f.discrete()) else { continue };
        let nodes = [0, 1].map(|c| place[&element.nodes[c]]);
        if discrete.along_line && mesh.nodes[nodes[0]].x == mesh.nodes[nodes[1]].x {
            short.push(element);
        }
        springs.push(MeshSpring { element: i, nodes, discrete });
    }
    if let Some(first) = short.first() {
        let message =
            format!("{} springs have no length; the first is element {}", short.len(), first.id);
        findings.add(Problem::error("mesh", message, "give their part a `spring.direction`"));
    }
    springs
}

/// Masses of nodes and rigid bodies for springs.
struct Masses<'a> {
    mesh: &'a Mesh,
    ends: Vec<SpringNode>,
    bodies: Vec<BodyMass>,
}

impl Masses<'_> {
    /// Returns the change of velocity of a node per unit impulse [1/mass], or for a rotational
    /// spring that of the rotational velocity [1/(mass length^2)]: with the part of its mass that a
    /// spring with this need gets, or with all of its mass.
    fn softness(&self, n: usize, discrete: &Discrete, need: Option<f64>) -> f64 {
        let end = &self.ends[n];
        let part = |all: f64| {
            need.map_or(1.0, |need| need / all * if end.shared { taken(all) } else { 1.0 })
        };
        if discrete.rotational {
            // Other nodes are refused.
            let of_body = |b| {
                let body: &BodyMass = &self.bodies[b];
                1.0 / (body.inertia * part(body.need))
            };
            return end.body.map_or(0.0, of_body);
        }
        let loose = 1.0 / (end.arm_share() * end.mass * part(end.need));
        let of_body = |b: &BodyMass| b.softness(&self.mesh.nodes[n].x) / part(b.need);
        let body = end.body.map_or(f64::INFINITY, |b| of_body(&self.bodies[b]));
        if end.held { 0.0 } else { loose.min(body) }
    }

    /// Returns the fraction of the masses at its ends with which each spring is stable at the step
    /// of the smallest other element, or of the stiffest spring if there are only springs.
    fn needs(&self, springs: &[MeshSpring], start: &ElementStart) -> Vec<f64> {
        let alone = |spring: &MeshSpring| {
            spring.nodes.map(|n| self.softness(n, &spring.discrete, None)).iter().sum()
        };
        let alone: Vec<f64> = springs.iter().map(alone).collect();
        let smallest = |steps: &mut dyn Iterator<Item = f64>| steps.fold(f64::INFINITY, f64::min);
        let least = smallest(&mut start.stable_dt.iter().copied());
        let both = springs.iter().zip(&alone);
        let step = if least.is_finite() {
            least
        } else {
            smallest(&mut both.clone().map(|(spring, &soft)| spring.discrete.stable_dt(soft)))
        };
        let need = |(spring, &soft): (&MeshSpring, &f64)| {
            if soft > 0.0 { spring.discrete.require(soft, step) } else { 0.0 }
        };
        both.map(need).collect()
    }

    /// Adds the needs of springs to those of their nodes and rigid bodies.
    fn add_needs(&mut self, springs: &[MeshSpring], needs: &[f64]) {
        for (spring, need) in springs.iter().zip(needs) {
            for &n in &spring.nodes {
                self.ends[n].need += need;
                self.ends[n].body.into_iter().for_each(|b| self.bodies[b].need += need);
            }
        }
    }

    /// Reports rotational springs at nodes without a rotational inertia of their own: rotations of
    /// other nodes belong to the elements there, which the step of the spring does not consider.
    fn without_inertia(&self, springs: &[MeshSpring], findings: &mut JobProblems) {
        let loose = |n: &usize| {
            let end = &self.ends[*n];
            let turns = end.body.is_some_and(|b| self.bodies[b].inertia > 0.0);
            !turns && !end.turn_held
        };
        let all = springs.iter().filter(|s| s.discrete.rotational).flat_map(|s| s.nodes);
        let found: Vec<usize> = all.filter(loose).collect();
        if let Some(&first) = found.first() {
            let message = format!(
                "{} ends of rotational springs are not nodes of rigid bodies with an inertia; the \
                 first is node {}",
                found.len(),
                self.mesh.nodes[first].id
            );
            let help = "put the node into a [[rigid]] body for the whole run, with `inertia` or \
                        `added_inertia` if its nodes lie on a line, or fix its rotations";
            findings.add(Problem::error("mesh", message, help));
        }
    }

    /// Returns the fraction of the mass of a node that springs and ties leave to other elements.
    fn left(&self, n: usize) -> f64 {
        let end = &self.ends[n];
        let need = end.body.map_or(end.need, |b| self.bodies[b].need);
        if end.held { 1.0 } else { end.arm_share() * (1.0 - taken(need)) }
    }
}

/// Reduces the steps of other elements at springs and ties.
fn reduce_steps(
    masses: &Masses<'_>,
    blocks: &BuiltElements,
    start: &mut ElementStart,
    place: &HashMap<NodeId, usize>,
) {
    for (i, element) in masses.mesh.elements.iter().enumerate() {
        let formulation = blocks.element(start.part[i] as usize, element.shape);
        let Some(formulation) =
            formulation.filter(|f| f.discrete().is_none() && start.stable_dt[i].is_finite())
        else {
            continue;
        };
        let left = element.corners().iter().map(|id| masses.left(place[id]));
        let share = left.fold(1.0, f64::min);
        if share < 1.0 {
            // Steps are later taken as proportional to the root of the fraction.
            let share = if formulation.has_dampers() { share * share } else { share };
            start.share[i] = share * formulation.single_element_step().powi(2);
            start.stable_dt[i] *= start.share[i].sqrt();
        }
    }
}

/// Returns the fraction of a mass that springs with this need get in addition to elements.
fn taken(need: f64) -> f64 {
    let q = need.min(MOST);
    q / (1.0 + q)
}

/// Returns the masses of all nodes, and their constraints.
fn of_nodes(
    mesh: &Mesh,
    settings: &Settings,
    nodes: &NodeStart,
    start: &ElementStart,
    place: &HashMap<NodeId, usize>,
) -> Vec<SpringNode> {
    let end = |(&mass, &fixed): (&f64, &u64)| SpringNode {
        mass,
        held: fixed & 0b111 == 0b111,
        turn_held: fixed >> 3 & 0b111 == 0b111,
        ..SpringNode::default()
    };
    let mut ends: Vec<SpringNode> = nodes.added_mass.iter().zip(&nodes.fixed).map(end).collect();
    let whole_run = |(_, body): &(usize, &RigidBody)| body.window.is_none();
    for (b, body) in settings.rigid.iter().enumerate().filter(whole_run) {
        for n in body.nodes.iter().filter_map(|id| place.get(id)) {
            (ends[*n].held, ends[*n].turn_held, ends[*n].body) = (false, false, Some(b));
        }
    }
    for n in settings
        .ties
        .iter()
        .filter(|t| t.offset && settings.rotations && !t.mean)
        .filter_map(|t| place.get(&t.node))
    {
        ends[*n].arm = 1.0 / ARM_SHARE;
    }
    for tie in settings.ties.iter().filter(|t| t.mean) {
        let at = |id: &NodeId| mesh.nodes[place[id]].x;
        ends[place[&tie.node]].arm = tie_excess(tie, at);
    }
    // Springs have no mass; discrete beams have.
    for (i, element) in mesh.elements.iter().enumerate().filter(|(i, _)| start.mass[*i] != 0.0) {
        let corners = element.corners();
        let of_each = start.mass_with_scaling(i) / corners.len() as f64;
        let found = corners.iter().enumerate().filter_map(|(c, id)| Some((c, place.get(id)?)));
        for (c, n) in found {
            ends[*n].mass += of_each * element.shape.mass_share(c);
            ends[*n].shared = true;
        }
    }
    ends
}

/// Reports free nodes without mass.
fn massless(mesh: &Mesh, ends: &[SpringNode], findings: &mut JobProblems) {
    let without = |i: &usize| ends[*i].mass == 0.0 && !ends[*i].held && ends[*i].body.is_none();
    let found: Vec<usize> = (0..ends.len()).filter(without).collect();
    if let Some(&first) = found.first() {
        let message = format!(
            "{} free nodes have no mass; the first is node {}",
            found.len(),
            mesh.nodes[first].id
        );
        let help =
            "springs have no mass: add a [[mass]], or fix the node in x, y and z by a [[fix]]";
        findings.add(Problem::error("mesh", message, help));
    }
}

/// Mass properties of a rigid body for its springs.
struct BodyMass {
    mass: f64,
    centre: [f64; 3],
    /// Lower bound of its smallest moment of inertia [mass length^2].
    inertia: f64,
    /// Fraction of its mass with which its springs are stable at the step of other elements.
    need: f64,
}

impl BodyMass {
    fn new(
        body: &RigidBody,
        mesh: &Mesh,
        ends: &[SpringNode],
        place: &HashMap<NodeId, usize>,
    ) -> Self {
        let members = || {
            body.nodes
                .iter()
                .filter_map(|id| place.get(id))
                .map(|&n| (ends[n].mass, mesh.nodes[n].x))
        };
        let mass: f64 = members().map(|m| m.0).sum();
        let centre = [0, 1, 2].map(|c| members().map(|(m, x)| m * x[c]).sum::<f64>() / mass);
        let mut moments = body.inertia.unwrap_or_default();
        if body.inertia.is_none() {
            for (m, x) in members() {
                let [x, y, z] = [0, 1, 2].map(|c| x[c] - centre[c]);
                let of = [y * y + z * z, z * z + x * x, x * x + y * y, -x * y, -y * z, -z * x];
                moments.iter_mut().zip(of).for_each(|(j, of)| *j += m * of);
            }
        }
        if let Some(added) = body.added_inertia {
            moments.iter_mut().zip(added).for_each(|(j, of)| *j += of);
        }
        // The product of the other two moments is at most the square of half the trace.
        let [xx, yy, zz, xy, yz, zx] = moments;
        let determinant =
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
        Self { mass, centre, inertia: 4.0 * determinant / (xx + yy + zz).powi(2), need: 0.0 }
    }

    /// Returns an upper bound of the change of velocity at `x` per unit impulse there [1/mass].
    fn softness(&self, x: &[f64; 3]) -> f64 {
        let arm: f64 = (0..3).map(|c| (x[c] - self.centre[c]).powi(2)).sum();
        1.0 / self.mass + arm / self.inertia
    }
}
