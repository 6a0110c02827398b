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

use super::laws::Blocks;
use super::state::{ElementStart, NodeStart};
use super::validate::Findings;
use crumple_proto::ids::NodeId;
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

/// Data of a node for its springs.
#[derive(Clone, Copy, Default)]
struct End {
    /// Mass [mass].
    mass: f64,
    /// True if other elements are connected to it.
    shared: bool,
    /// True if its motion is fixed or prescribed, so that no force accelerates it.
    held: bool,
    /// True if it is tied with an offset.
    has_arm: bool,
    /// Index of its rigid body.
    body: Option<usize>,
    /// Fraction of its mass with which its springs are stable at the step of other elements.
    need: f64,
}

/// Sets the stable steps of springs in `start`, and the reduced steps of other elements at
/// springs and ties. Reports free nodes without mass, and springs without length.
pub fn steps(
    mesh: &Mesh,
    settings: &Settings,
    blocks: &Blocks,
    nodes: &NodeStart,
    start: &mut ElementStart,
    findings: &mut Findings,
) {
    let place: HashMap<NodeId, usize> =
        mesh.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect();
    let mut springs: Vec<(usize, [usize; 2], Discrete)> = Vec::new();
    let mut short: Vec<&MeshElement> = Vec::new();
    for (i, element) in mesh.elements.iter().enumerate().filter(|(_, e)| e.shape == Shape::Line2) {
        let Some(formulation) = blocks.element(start.part[i] as usize, element.shape) else {
            continue;
        };
        let Some(discrete) = formulation.discrete() else { continue };
        let ends = [0, 1].map(|c| place[&element.nodes[c]]);
        if discrete.along_line && mesh.nodes[ends[0]].x == mesh.nodes[ends[1]].x {
            short.push(element);
        }
        springs.push((i, ends, discrete));
    }
    if let Some(first) = short.first() {
        let message =
            format!("{} springs have no length; the first is element {}", short.len(), first.id);
        findings.add(Problem::error("mesh", message, "give their part a `spring.direction`"));
    }
    let mut ends = of_nodes(mesh, settings, nodes, start, &place);
    massless(mesh, &ends, findings);
    if springs.is_empty() && !ends.iter().any(|e| e.has_arm) {
        return;
    }
    let mut bodies: Vec<BodyMass> =
        settings.rigid.iter().map(|b| BodyMass::new(b, mesh, &ends, &place)).collect();
    let softness = |n: usize, ends: &[End], bodies: &[BodyMass], need: Option<f64>| {
        let end = &ends[n];
        let part = |all: f64| {
            need.map_or(1.0, |need| need / all * if end.shared { taken(all) } else { 1.0 })
        };
        let arm = if end.has_arm { ARM_SHARE } else { 1.0 };
        let loose = 1.0 / (arm * end.mass * part(end.need));
        let of_body = |b: &BodyMass| b.softness(&mesh.nodes[n].x) / part(b.need);
        let body = end.body.map_or(f64::INFINITY, |b| of_body(&bodies[b]));
        if end.held { 0.0 } else { loose.min(body) }
    };
    let alone: Vec<f64> = springs
        .iter()
        .map(|s| s.1.map(|n| softness(n, &ends, &bodies, None)).iter().sum())
        .collect();
    let least = start.stable_dt.iter().copied().fold(f64::INFINITY, f64::min);
    let step = if least.is_finite() {
        least
    } else {
        springs
            .iter()
            .zip(&alone)
            .map(|((_, _, d), &soft)| d.stable_dt(soft))
            .fold(f64::INFINITY, f64::min)
    };
    let need = |discrete: &Discrete, soft: f64| {
        if soft > 0.0 { discrete.require(soft, step) } else { 0.0 }
    };
    let needs: Vec<f64> =
        springs.iter().zip(&alone).map(|((_, _, d), &soft)| need(d, soft)).collect();
    for ((_, at, _), need) in springs.iter().zip(&needs) {
        for &n in at {
            ends[n].need += need;
            ends[n].body.into_iter().for_each(|b| bodies[b].need += need);
        }
    }
    for ((i, at, discrete), &need) in springs.iter().zip(&needs) {
        if need > 0.0 {
            let soft = at.map(|n| softness(n, &ends, &bodies, Some(need)));
            start.stable_dt[*i] = discrete.stable_dt(soft.iter().sum());
        }
    }
    for (i, element) in mesh.elements.iter().enumerate() {
        let formulation = blocks.element(start.part[i] as usize, element.shape);
        let Some(formulation) =
            formulation.filter(|f| f.discrete().is_none() && start.stable_dt[i].is_finite())
        else {
            continue;
        };
        let left = |id: &NodeId| {
            let end = &ends[place[id]];
            let need = end.body.map_or(end.need, |b| bodies[b].need);
            let arm = if end.has_arm { ARM_SHARE } else { 1.0 };
            if end.held { 1.0 } else { arm * (1.0 - taken(need)) }
        };
        let share = element.corners().iter().map(left).fold(1.0, f64::min);
        if share < 1.0 {
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
) -> Vec<End> {
    let end = |(&mass, &fixed): (&f64, &u64)| End {
        mass,
        held: fixed & 0b111 == 0b111,
        ..End::default()
    };
    let mut ends: Vec<End> = nodes.added_mass.iter().zip(&nodes.fixed).map(end).collect();
    for (b, body) in settings.rigid.iter().enumerate() {
        for n in body.nodes.iter().filter_map(|id| place.get(id)) {
            (ends[*n].held, ends[*n].body) = (false, Some(b));
        }
    }
    for n in settings
        .ties
        .iter()
        .filter(|t| t.offset && settings.rotations)
        .filter_map(|t| place.get(&t.node))
    {
        ends[*n].has_arm = true;
    }
    for (i, element) in mesh.elements.iter().enumerate().filter(|(_, e)| e.shape != Shape::Line2) {
        let corners = element.corners();
        for n in corners.iter().filter_map(|id| place.get(id)) {
            ends[*n].mass += start.mass_with_scaling(i) / corners.len() as f64;
            ends[*n].shared = true;
        }
    }
    ends
}

/// Reports free nodes without mass.
fn massless(mesh: &Mesh, ends: &[End], findings: &mut Findings) {
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
    fn new(body: &RigidBody, mesh: &Mesh, ends: &[End], place: &HashMap<NodeId, usize>) -> Self {
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
