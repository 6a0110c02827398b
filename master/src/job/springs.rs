//! Springs: the stable step that the masses at their ends leave them, and nodes that have none.
//!
//! A node's mass is shared among what is fastened there, since the frequencies of parts of a model that keep to their shares
//! bound those of the whole (Irons & Treharne 1971). Springs get all of it where there is nothing else, and otherwise a fifth: the
//! other elements then lose a tenth of their step at most, `1 / sqrt(1 + 1/5) = 0.91`, which is what the usual safety of
//! 0.9 leaves. Among each other they share by the frequencies that they would have alone.

use super::laws::Blocks;
use super::state::{ElementStart, NodeStart};
use super::validate::Findings;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::rigid::RigidBody;
use crumple_worker::elements::Discrete;
use std::collections::HashMap;

/// Part of a node's mass that springs count on where other elements are fastened too.
const SHARE: f64 = 0.2;

/// What springs see of a node.
#[derive(Clone, Copy, Default)]
struct End {
    /// Mass [mass].
    mass: f64,
    /// Whether other elements are fastened there.
    shared: bool,
    /// Whether it is held or led: nothing pushes it.
    held: bool,
    /// Index of its rigid body.
    body: Option<usize>,
    /// Sum of the squared frequencies of its springs [1/time^2].
    squares: f64,
}

/// Sets the stable steps of springs in `start`; says which free nodes have no mass, and which springs no length.
pub fn steps(
    mesh: &Mesh,
    settings: &Settings,
    blocks: &Blocks,
    nodes: &NodeStart,
    start: &mut ElementStart,
    findings: &mut Findings,
) {
    let place: HashMap<NodeId, usize> = mesh.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect();
    let mut springs: Vec<(usize, [usize; 2], Discrete)> = Vec::new();
    let mut short: Vec<&MeshElement> = Vec::new();
    for (i, element) in mesh.elements.iter().enumerate().filter(|(_, e)| e.shape == Shape::Line2) {
        let Some(formulation) = blocks.element(start.part[i] as usize, element.shape) else { continue };
        let Some(discrete) = formulation.discrete() else { continue };
        let ends = [0, 1].map(|c| place[&element.nodes[c]]);
        if discrete.along_line && mesh.nodes[ends[0]].x == mesh.nodes[ends[1]].x {
            short.push(element);
        }
        springs.push((i, ends, discrete));
    }
    if let Some(first) = short.first() {
        let message = format!("{} springs have no length; the first is element {}", short.len(), first.id);
        findings.add(Problem::error("mesh", message, "give their part a `spring.direction`"));
    }
    let mut ends = of_nodes(mesh, settings, nodes, start, &place);
    massless(mesh, &ends, findings);
    if springs.is_empty() {
        return;
    }
    let mut bodies: Vec<Heavy> = settings.rigid.iter().map(|b| Heavy::of(b, mesh, &ends, &place)).collect();
    let softness = |n: usize, ends: &[End], bodies: &[Heavy], square: Option<f64>| {
        let part = |all: f64| square.filter(|s| *s > 0.0).map_or(1.0, |s| s / all);
        let end = &ends[n];
        let with_others = if end.shared && square.is_some() { SHARE } else { 1.0 };
        let loose = 1.0 / (end.mass * with_others * part(end.squares));
        let of_body = |b: &Heavy| b.softness(&mesh.nodes[n].x) / (with_others * part(b.squares));
        let body = end.body.map_or(f64::INFINITY, |b| of_body(&bodies[b]));
        if end.held { 0.0 } else { loose.min(body) }
    };
    let alone: Vec<f64> = springs
        .iter()
        .map(|(_, at, discrete)| {
            discrete.stable_dt(at.map(|n| softness(n, &ends, &bodies, None)).iter().sum()).powi(-2)
        })
        .collect();
    for ((_, at, _), square) in springs.iter().zip(&alone) {
        for &n in at {
            ends[n].squares += square;
            ends[n].body.into_iter().for_each(|b| bodies[b].squares += square);
        }
    }
    for ((i, at, discrete), &square) in springs.iter().zip(&alone) {
        let soft = at.map(|n| softness(n, &ends, &bodies, Some(square)));
        start.stable_dt[*i] = discrete.stable_dt(soft.iter().sum());
    }
}

/// Masses of all nodes, and what holds them.
fn of_nodes(
    mesh: &Mesh,
    settings: &Settings,
    nodes: &NodeStart,
    start: &ElementStart,
    place: &HashMap<NodeId, usize>,
) -> Vec<End> {
    let end = |(&mass, &fixed): (&f64, &u64)| End { mass, held: fixed & 0b111 == 0b111, ..End::default() };
    let mut ends: Vec<End> = nodes.added_mass.iter().zip(&nodes.fixed).map(end).collect();
    for (b, body) in settings.rigid.iter().enumerate() {
        for n in body.nodes.iter().filter_map(|id| place.get(id)) {
            (ends[*n].held, ends[*n].body) = (false, Some(b));
        }
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

/// Says which free nodes have no mass.
fn massless(mesh: &Mesh, ends: &[End], findings: &mut Findings) {
    let without = |i: &usize| ends[*i].mass == 0.0 && !ends[*i].held && ends[*i].body.is_none();
    let found: Vec<usize> = (0..ends.len()).filter(without).collect();
    if let Some(&first) = found.first() {
        let message = format!("{} free nodes have no mass; the first is node {}", found.len(), mesh.nodes[first].id);
        let help = "springs have none: add a [[mass]], or hold the node in x, y and z by a [[fix]]";
        findings.add(Problem::error("mesh", message, help));
    }
}

/// A rigid body as springs see it.
struct Heavy {
    mass: f64,
    centre: [f64; 3],
    /// No more than its smallest moment of inertia [mass length^2].
    inertia: f64,
    /// Sum of the squared frequencies of its springs [1/time^2].
    squares: f64,
}

impl Heavy {
    fn of(body: &RigidBody, mesh: &Mesh, ends: &[End], place: &HashMap<NodeId, usize>) -> Self {
        let members = || body.nodes.iter().filter_map(|id| place.get(id)).map(|&n| (ends[n].mass, mesh.nodes[n].x));
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
        // The other two moments multiply to no more than the square of half the trace.
        let [xx, yy, zz, xy, yz, zx] = moments;
        let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
        Self { mass, centre, inertia: 4.0 * determinant / (xx + yy + zz).powi(2), squares: 0.0 }
    }

    /// No less than the change of velocity at `x` per unit impulse there [1/mass].
    fn softness(&self, x: &[f64; 3]) -> f64 {
        let arm: f64 = (0..3).map(|c| (x[c] - self.centre[c]).powi(2)).sum();
        1.0 / self.mass + arm / self.inertia
    }
}
