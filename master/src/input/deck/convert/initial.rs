//! Converts `*INITIAL_VELOCITY...`.

use super::DeckConverter;
use super::sets::id;
use super::space::{cosines, cross};
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::{BTreeMap, HashSet};

/// Bits of a velocity, to find equal ones.
type Bits = [u64; 3];

/// An initial velocity of the job.
pub struct DeckVelocity {
    entry: JobTable,
    /// Its set of nodes; `None` for all nodes.
    set: Option<String>,
    velocity: [f64; 3],
    /// Rotational velocity and centre.
    spin: ([f64; 3], [f64; 3]),
}

impl DeckVelocity {
    /// Returns the velocity at a point.
    fn at(&self, x: [f64; 3]) -> [f64; 3] {
        let (spin, centre) = self.spin;
        let turned = cross(spin, [0, 1, 2].map(|c| x[c] - centre[c]));
        [0, 1, 2].map(|c| self.velocity[c] + turned[c])
    }
}

/// Largest difference of two motions that is round-off, as a fraction of the velocity.
const SAME_MOTION: f64 = 1e-9;
/// Consequence of a velocity that is left out.
pub const LOST: &str = "the initial velocity is left out: its nodes start without it";

impl DeckConverter {
    /// Converts initial velocities. Those of the cards of bodies come first.
    pub(super) fn initial_velocities(&mut self) {
        let of_bodies = self.velocities.len();
        for record in self.take_records("INITIAL_VELOCITY") {
            self.of_set(&record);
        }
        for record in self.take_records("INITIAL_VELOCITY_GENERATION") {
            self.generation(&record);
        }
        for record in self.take_records("INITIAL_VELOCITY_NODE") {
            let mut equal: BTreeMap<Bits, ([f64; 3], Vec<NodeId>, Place)> = BTreeMap::new();
            let lines: Vec<CardLine> = record.lines("nid").cloned().collect();
            for line in lines {
                let Some(v) = self.velocity(&line, ["vx", "vy", "vz"], "icid") else { continue };
                self.no_spin(&record, &line, ["vxr", "vyr", "vzr"]);
                let of =
                    equal.entry(v.map(f64::to_bits)).or_insert_with(|| (v, Vec::new(), line.place));
                of.1.extend(id(line.integer("nid")));
            }
            for (number, (v, nodes, place)) in equal.into_values().enumerate() {
                let name = format!("velocity-{}", number + 1);
                let name = self.rows.add_new_set(&name, nodes, place);
                self.initial(place, Some(name), v, None);
            }
        }
        let mut moved: BTreeMap<String, ([Bits; 2], Place)> = BTreeMap::new();
        for record in self.take_records("INITIAL_VELOCITY_RIGID_BODY") {
            let lines: Vec<CardLine> = record.lines("pid").cloned().collect();
            for line in lines {
                let (part, place) = (line.integer("pid"), line.place("pid"));
                if !self.has_part(part, place) {
                    continue;
                }
                let Some(v) = self.velocity(&line, ["vx", "vy", "vz"], "icid") else { continue };
                let Some(w) = self.velocity(&line, ["vxr", "vyr", "vzr"], "icid") else { continue };
                if let Some(body) = self.bodies.get(&part) {
                    let motion = [v, w].map(|v| v.map(f64::to_bits));
                    let other = moved.insert(body.clone(), (motion, place));
                    if let Some((_, first)) = other.filter(|(other, _)| *other != motion) {
                        let message = format!("the body of part {part} has two initial velocities");
                        let help = "the last card of a body counts: remove the other one";
                        self.trouble.warning(first, message, help);
                    }
                }
                let (parts, set) = self.body_of(part, place);
                let spin = (w != [0.0; 3]).then(|| (w, self.centre_of(&parts)));
                self.initial(line.place, Some(set), v, spin);
            }
        }
        let all = std::mem::take(&mut self.velocities);
        let is_new: Vec<bool> = (0..all.len())
            .map(|at| at >= of_bodies || !self.is_repeated(&all[at], &all[at + 1..]))
            .collect();
        for (velocity, _) in all.into_iter().zip(is_new).filter(|(_, is_new)| *is_new) {
            self.add("initial_velocity", velocity.entry);
        }
    }

    /// Returns the parts of the rigid body of a part, and the set of its nodes and extra nodes.
    fn body_of(&mut self, part: i64, place: Place) -> (Vec<i64>, String) {
        let Some(name) = self.bodies.get(&part) else {
            return (vec![part], self.nodes_of_parts(&[part]));
        };
        let parts: Vec<i64> =
            self.bodies.iter().filter(|body| body.1 == name).map(|body| *body.0).collect();
        let own = self.rows.nodes_of(|part| parts.contains(&i64::from(part)));
        // Nodes without elements have no mass, and no velocity.
        let connected = self.rows.nodes_of(|_| true);
        let of_body = self
            .node_bodies
            .iter()
            .filter(|(node, body)| *body == name && connected.binary_search(node).is_ok());
        let mut members: Vec<NodeId> = of_body.map(|(node, _)| *node).chain(own.clone()).collect();
        members.sort_unstable();
        members.dedup();
        let set = match members.len() == own.len() {
            true => self.nodes_of_parts(&parts),
            false => self.rows.add_new_set(&format!("velocity-body-{part}"), members, place),
        };
        (parts, set)
    }

    /// Returns true if a later velocity gives all nodes of a body the same motion: an exported deck
    /// has it on two cards.
    fn is_repeated(&self, body: &DeckVelocity, later: &[DeckVelocity]) -> bool {
        let of = |velocity: &DeckVelocity| {
            let name = velocity.set.as_deref()?;
            let by_id = || self.node_sets.get(&name.strip_prefix("set-")?.parse().ok()?);
            self.rows.set(name).or_else(|| Some(by_id()?.0.as_slice()))
        };
        let Some(own) = of(body) else { return false };
        let is_given = |other: &&DeckVelocity| {
            let Some(nodes) = of(other) else { return other.set.is_none() };
            let nodes: HashSet<&NodeId> = nodes.iter().collect();
            own.iter().all(|node| nodes.contains(node))
        };
        let Some(other) = later.iter().rfind(is_given) else { return false };
        let (spin, centre) = body.spin;
        let differs = |a: [f64; 3], b: [f64; 3]| {
            let size = a.iter().chain(&b).fold(0.0, |max: f64, v| max.max(v.abs()));
            a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME_MOTION * size)
        };
        !differs(spin, other.spin.0) && !differs(body.velocity, other.at(centre))
    }

    fn of_set(&mut self, record: &CardRecord) {
        let Some(line) = record.line("vx").cloned() else { return };
        let Some(head) = record.line("nsid").cloned() else { return };
        let v = ["vx", "vy", "vz"].map(|c| line.real(c));
        let Some(v) = self.in_global_axes(v, &head, "icid", LOST) else { return };
        self.no_spin(record, &line, ["vxr", "vyr", "vzr"]);
        let (nsid, boxid) = (record.integer("nsid"), record.integer("boxid"));
        let set = match (nsid, boxid) {
            (0, 0) => None,
            (0, _) => {
                let nodes = self.in_box(boxid, record.place("boxid"));
                if !self.boxes.contains_key(&boxid) {
                    return;
                }
                let name = format!("box-{boxid}");
                self.rows.add_set(name.clone(), nodes, record.place("boxid"));
                Some(name)
            }
            (_, 0) => match self.node_set(nsid, record.place("nsid")) {
                Some(set) => Some(set),
                None => return,
            },
            _ => return self.unsupported_card(record, "boxid", "a set together with a box"),
        };
        self.initial(line.place, set, v, None);
        if let Some(line) = record.line("vxe").cloned() {
            let v = ["vxe", "vye", "vze"].map(|c| line.real(c));
            self.no_spin(record, &line, ["vxre", "vyre", "vzre"]);
            if let Some(set) = self.node_set(record.integer("nsidex"), record.place("nsidex")) {
                self.initial(line.place, Some(set), v, None);
            }
        }
    }

    fn generation(&mut self, record: &CardRecord) {
        let (sid, place) = (record.integer("id"), record.place("id"));
        let set = match (sid, record.integer("styp")) {
            (0, _) => None,
            (_, 1) => {
                let parts = self.part_set(sid, place);
                if parts.is_empty() {
                    return;
                }
                Some(self.nodes_of_parts(&parts))
            }
            (_, 2) if self.has_part(sid, place) => Some(self.nodes_of_parts(&[sid])),
            (_, 3) => match self.node_set(sid, place) {
                Some(set) => Some(set),
                None => return,
            },
            (_, 2) => return,
            _ => {
                return self.unsupported_card(
                    record,
                    "styp",
                    "use 1 (set of parts), 2 (part) or 3 (set of nodes)",
                );
            }
        };
        if record.integer("phase") != 0 {
            self.unsupported_value(record, "phase", "velocities that start later");
        }
        if record.line("xc").is_none() {
            let used = "its defaults: no axis, phase 0";
            self.map("*INITIAL_VELOCITY_GENERATION", "no second card", used);
        }
        let Some(head) = record.line("omega").cloned() else { return };
        let Some(v) = self.velocity(&head, ["vx", "vy", "vz"], "icid") else { return };
        let omega = head.real("omega");
        let mut spin = None;
        // Without a spin, the axis and its point have no effect.
        let [mut along, point] =
            [["nx", "ny", "nz"], ["xc", "yc", "zc"]].map(|of| of.map(|c| record.real(c)));
        if omega != 0.0 {
            if along[0] == -999.0 {
                let [from, to] = [1, 2].map(|c| id(along[c] as i64).and_then(|n| self.rows.at(n)));
                let (Some(from), Some(to)) = (from, to) else {
                    let message = "the axis of the initial spin refers to nodes that do not exist";
                    return self.trouble.error(
                        record.place("ny"),
                        message,
                        "with nx = -999, give ids of nodes as ny and nz",
                    );
                };
                along = [0, 1, 2].map(|c| to[c] - from[c]);
            }
            match cosines(along) {
                Some(n) => {
                    spin = Some((n.map(|c| c * omega), point));
                }
                None => {
                    let message = "the axis of the initial spin has no direction";
                    self.trouble.error(
                        record.place("nx"),
                        message,
                        "give nx, ny, nz: a vector along the axis",
                    );
                }
            }
        }
        self.initial(place, set, v, spin);
    }

    /// Adds an initial velocity for [`DeckConverter::initial_velocities`].
    pub(super) fn initial(
        &mut self,
        place: Place,
        set: Option<String>,
        v: [f64; 3],
        spin: Option<([f64; 3], [f64; 3])>,
    ) {
        let mut table = JobTable::new(place).with("velocity", place, v);
        if let Some(set) = &set {
            table.put("nodes", place, set.clone());
        }
        if let Some((spin, centre)) = spin {
            table.put("spin", place, spin);
            table.put("centre", place, centre);
        }
        let spin = spin.unwrap_or_default();
        self.velocities.push(DeckVelocity { entry: table, set, velocity: v, spin });
    }

    fn velocity(&mut self, line: &CardLine, names: [&str; 3], system: &str) -> Option<[f64; 3]> {
        let v = names.map(|c| line.real(c));
        self.in_global_axes(v, line, system, LOST)
    }

    fn no_spin(&mut self, record: &CardRecord, line: &CardLine, names: [&str; 3]) {
        if let Some(name) = names.iter().find(|c| line.real(c) != 0.0) {
            let message =
                format!("{}: {name} = {} is not supported", record.name(), line.real(name));
            self.unsupported(line.place(name), message, format!("{} {name}", record.name()));
        }
    }

    /// Returns the centre of parts: the mean of the centres of their elements, weighted by area or
    /// volume.
    pub(super) fn centre_of(&mut self, parts: &[i64]) -> [f64; 3] {
        let (sizes, middles) = self.middles_of(parts);
        mean(&sizes, &middles)
    }

    /// Returns the areas of the shells or volumes of the solids of parts, and their middles.
    pub(super) fn middles_of(&mut self, parts: &[i64]) -> (Vec<f64>, Vec<[f64; 3]>) {
        let of_parts =
            |e: &&MeshElement| parts.contains(&i64::from(e.part)) && !e.shape.faces().is_empty();
        let elements: Vec<_> = self.rows.elements().filter(of_parts).copied().collect();
        elements.iter().map(|e| size_and_middle(e.shape, &self.corners_of(e))).unzip()
    }

    /// Returns the coordinates of the corners of an element; none if one has no node.
    fn corners_of(&mut self, element: &MeshElement) -> Vec<[f64; 3]> {
        let x: Option<Vec<[f64; 3]>> = element.corners().iter().map(|&n| self.rows.at(n)).collect();
        x.unwrap_or_default()
    }

    /// Returns the area of a shell or the volume of a solid; 0 if a corner has no node.
    pub(super) fn size_of(&mut self, element: &MeshElement) -> f64 {
        size(element.shape, &self.corners_of(element))
    }
}

/// Returns the mean of points with weights, the origin if these are 0.
pub(in crate::input::deck) fn mean(weights: &[f64], points: &[[f64; 3]]) -> [f64; 3] {
    let total: f64 = weights.iter().sum();
    let along = |c: usize| weights.iter().zip(points).map(|(w, x)| w * x[c]).sum::<f64>();
    if total > 0.0 { [0, 1, 2].map(|c| along(c) / total) } else { [0.0; 3] }
}

/// Returns the area of a shell or the volume of a solid with these corners, and their mean.
pub(in crate::input::deck) fn size_and_middle(shape: Shape, x: &[[f64; 3]]) -> (f64, [f64; 3]) {
    let mean = |c: usize| x.iter().map(|x| x[c]).sum::<f64>() / x.len().max(1) as f64;
    (size(shape, x), [0, 1, 2].map(mean))
}

/// Returns the area of a shell or the volume of a solid; 0 without corners, and for other shapes.
fn size(shape: Shape, x: &[[f64; 3]]) -> f64 {
    if x.is_empty() {
        return 0.0;
    }
    let from = |a: usize, b: usize| [0, 1, 2].map(|c| x[b][c] - x[a][c]);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let triple = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        let n = super::space::cross(a, b);
        (0..3).map(|i| n[i] * c[i]).sum::<f64>().abs()
    };
    let tetrahedron =
        |a: usize, b: usize, c: usize, d: usize| triple(from(a, b), from(a, c), from(a, d)) / 6.0;
    match shape {
        Shape::Tri3 => 0.5 * length(super::space::cross(from(0, 1), from(0, 2))),
        Shape::Quad4 => 0.5 * length(super::space::cross(from(0, 2), from(1, 3))),
        Shape::Tet4 | Shape::Tet10 => tetrahedron(0, 1, 2, 3),
        Shape::Wedge6 => {
            tetrahedron(0, 1, 2, 3) + tetrahedron(1, 2, 3, 4) + tetrahedron(2, 3, 4, 5)
        }
        Shape::Hex8 => {
            // Edges between the centres of opposite faces.
            let middle = |corners: [usize; 4]| {
                [0, 1, 2].map(|c| corners.iter().map(|&k| x[k][c]).sum::<f64>() / 4.0)
            };
            let edge = |a, b| {
                let (a, b) = (middle(a), middle(b));
                [0, 1, 2].map(|c| b[c] - a[c])
            };
            triple(
                edge([0, 3, 4, 7], [1, 2, 5, 6]),
                edge([0, 1, 4, 5], [2, 3, 6, 7]),
                edge([0, 1, 2, 3], [4, 5, 6, 7]),
            )
        }
        Shape::Line2 | Shape::Beam2 | Shape::Truss2 | Shape::Point1 | Shape::Cohesive8 => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wedge of half a cube, a tetrahedron of a sixth and the cube itself.
    #[test]
    fn sizes_of_solids_are_their_volumes() {
        let cube: Vec<[f64; 3]> = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 2.0],
            [2.0, 0.0, 2.0],
            [2.0, 2.0, 2.0],
            [0.0, 2.0, 2.0],
        ]
        .into();
        let corners = |which: &[usize]| which.iter().map(|&c| cube[c]).collect::<Vec<_>>();
        assert!((size(Shape::Hex8, &cube) - 8.0).abs() < 1e-14);
        assert!((size(Shape::Wedge6, &corners(&[0, 1, 2, 4, 5, 6])) - 4.0).abs() < 1e-14);
        assert!((size(Shape::Tet4, &corners(&[0, 1, 3, 4])) - 8.0 / 6.0).abs() < 1e-14);
        assert!((size(Shape::Quad4, &corners(&[0, 1, 2, 3])) - 4.0).abs() < 1e-14);
    }
}
