//! Converts fixed degrees of freedom and prescribed motions.

use super::DeckConverter;
use super::materials::held;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::Unsupported;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::Shape;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

const DOFS: [(&str, &str); 6] = [
    ("dofx", "x"),
    ("dofy", "y"),
    ("dofz", "z"),
    ("dofrx", "rx"),
    ("dofry", "ry"),
    ("dofrz", "rz"),
];

/// Time from which on a constraint never ends.
pub(super) const NEVER: f64 = 1e20;

/// Degrees of freedom that the deck fixes for some nodes.
#[derive(Debug)]
pub struct DeckFix {
    /// Name of their set.
    set: String,
    /// True if the set has to be added.
    is_new: bool,
    nodes: Vec<NodeId>,
    dofs: Vec<&'static str>,
    place: Place,
}

/// Direction and degrees of freedom of a prescribed motion.
struct DirectedMotion {
    /// Unit vector along the motion, or along the axis of the rotation.
    direction: [f64; 3],
    /// Names of the degrees of freedom.
    dofs: Vec<&'static str>,
    rotation: bool,
}

impl DeckConverter {
    /// Reads `*BOUNDARY_SPC_...`, and the constraint codes on the cards of nodes.
    pub(super) fn spc(&mut self) {
        for record in self.take_records("BOUNDARY_SPC_SET") {
            let (dofs, nsid, place) =
                (self.dofs(&record), record.integer("nsid"), record.place("nsid"));
            if let Some(set) = self.node_set(nsid, place) {
                let nodes = self.node_sets[&nsid].0.clone();
                self.fixes.push(DeckFix { set, is_new: false, nodes, dofs, place });
            }
        }
        for record in self.take_records("BOUNDARY_SPC_SET_BIRTH_DEATH") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            if let Some(set) = self.node_set(nsid, place) {
                let nodes = self.node_sets[&nsid].0.clone();
                self.hold_for_a_time(&record, (set, false), nodes, place);
            }
        }
        for record in self.take_records("BOUNDARY_SPC_NODE_BIRTH_DEATH") {
            let (node, place) = (record.integer("nid"), record.place("nid"));
            let nodes: Vec<NodeId> = id(node).into_iter().collect();
            self.hold_for_a_time(&record, (format!("spc-{node}"), true), nodes, place);
        }
        let mut nodes: BTreeMap<Vec<&'static str>, (Vec<NodeId>, Place)> = BTreeMap::new();
        for record in self.take_records("BOUNDARY_SPC_NODE") {
            let dofs = self.dofs(&record);
            let of = nodes.entry(dofs).or_insert_with(|| (Vec::new(), record.place("nid")));
            of.0.extend(id(record.integer("nid")));
        }
        for (dofs, (nodes, place)) in nodes {
            self.fix_nodes("spc", dofs, nodes, place);
        }
        for ((tc, rc), (nodes, place)) in std::mem::take(&mut self.rows.held) {
            let mut dofs = held(tc as f64, ["x", "y", "z"]);
            dofs.extend(held(rc as f64, ["rx", "ry", "rz"]));
            self.fix_nodes("node", dofs, nodes, place);
        }
    }

    /// Fixes nodes from birth to death: by a motion at rest, or for the whole run. A new set is
    /// added.
    fn hold_for_a_time(
        &mut self,
        record: &CardRecord,
        (set, is_new): (String, bool),
        nodes: Vec<NodeId>,
        place: Place,
    ) {
        let (dofs, birth) = (self.dofs(record), record.real("birth").max(0.0));
        let death = record.real_or("death", NEVER);
        if birth == 0.0 && death >= NEVER {
            self.fixes.push(DeckFix { set, is_new, nodes, dofs, place });
            return;
        }
        // A motion without names would hold x, y and z.
        if dofs.is_empty() {
            return;
        }
        let set = if is_new { self.rows.add_new_set(&set, nodes, place) } else { set };
        let mut table = JobTable::new(record.head)
            .with("nodes", place, set)
            .with("dofs", place, dofs)
            .with("velocity", place, [0.0; 3])
            .with("birth", record.place("birth"), birth);
        if death < NEVER {
            table.put("death", record.place("death"), death);
        }
        self.add("motion", table);
    }

    /// Converts `*CONSTRAINED_GLOBAL`: nodes on a plane that are fixed as on one of symmetry.
    pub(super) fn planes(&mut self) {
        for record in self.take_records("CONSTRAINED_GLOBAL") {
            for line in record.lines("tc") {
                let place = line.place("dir");
                let [tc, rc, dir] = ["tc", "rc", "dir"].map(|field| line.integer(field));
                // The code of two axes is that of the first one of them in their cycle, plus 3.
                let turns = match dir {
                    1 => 5,
                    2 => 6,
                    3 => 4,
                    _ => 0,
                };
                if (tc, rc) != (dir, turns) || turns == 0 {
                    let message = format!(
                        "{}: tc {tc} and rc {rc} with dir {dir} are not supported: they are not \
                         those of a plane of symmetry along an axis",
                        record.name()
                    );
                    let what = format!("{} tc={tc} rc={rc} dir={dir}", record.name());
                    let lost = "give its nodes a *BOUNDARY_SPC_SET".into();
                    self.unsupported.push(Unsupported { place, message, what, lost });
                    continue;
                }
                let normal = [1, 2, 3].map(|axis| if axis == dir { 1.0 } else { 0.0 });
                let table = JobTable::new(place)
                    .with("point", line.place("x"), ["x", "y", "z"].map(|c| line.real(c)))
                    .with("normal", place, normal)
                    .with("tolerance", line.place("tol"), line.real("tol"));
                self.add("symmetry", table);
            }
        }
    }

    /// Fixes degrees of freedom of a set with this name, which is added if it is new.
    pub(super) fn fix_set(
        &mut self,
        (set, is_new): (String, bool),
        nodes: Vec<NodeId>,
        dofs: Vec<&'static str>,
        place: Place,
    ) {
        self.fixes.push(DeckFix { set, is_new, nodes, dofs, place });
    }

    pub(super) fn fix_nodes(
        &mut self,
        kind: &str,
        dofs: Vec<&'static str>,
        mut nodes: Vec<NodeId>,
        place: Place,
    ) {
        nodes.sort_unstable();
        nodes.dedup();
        let set = format!("{kind}-{}", dofs.join("-"));
        self.fixes.push(DeckFix { set, is_new: true, nodes, dofs, place });
    }

    /// Returns the degrees of freedom of a rigid body that constraints of all its nodes fix, and
    /// removes its nodes from these constraints. Nodes that cannot move along an axis prevent the
    /// rotations that would move them along it.
    pub(super) fn body_held(&mut self, nodes: &BTreeSet<NodeId>) -> BTreeSet<&'static str> {
        let mut held: HashMap<NodeId, BTreeSet<&'static str>> = HashMap::new();
        for fix in &self.fixes {
            for node in fix.nodes.iter().filter(|n| nodes.contains(n)) {
                held.entry(*node).or_default().extend(&fix.dofs);
            }
        }
        let all = held.values().next().cloned().unwrap_or_default();
        if all.is_empty() || held.len() < nodes.len() || held.values().any(|own| *own != all) {
            return BTreeSet::new();
        }
        self.release(nodes);
        let x: Vec<[f64; 3]> = nodes.iter().filter_map(|&n| self.rows.at(n)).collect();
        let is_wide = |c: usize| x.iter().any(|point| point[c] != x[0][c]);
        let mut fixed = all;
        for (axis, turns) in ["x", "y", "z"].into_iter().zip([[1, 2], [2, 0], [0, 1]]) {
            let [one, other] = turns;
            if fixed.contains(axis) {
                // A rotation about one axis moves nodes that are apart along the other one.
                fixed.extend(is_wide(other).then_some(["rx", "ry", "rz"][one]));
                fixed.extend(is_wide(one).then_some(["rx", "ry", "rz"][other]));
            }
        }
        fixed
    }

    /// Returns what constraints of some nodes of a rigid body fix of it, with the place of one of
    /// them, and removes its nodes from these constraints: the fixed directions, and all rotations
    /// about the centre that would move a node along one of them.
    pub(super) fn held_by_some(
        &mut self,
        nodes: &BTreeSet<NodeId>,
        centre: [f64; 3],
    ) -> Option<(BTreeSet<&'static str>, Place)> {
        let mut held: Vec<(NodeId, Vec<&'static str>, Place)> = Vec::new();
        for fix in &self.fixes {
            let own = fix.nodes.iter().filter(|n| nodes.contains(n));
            held.extend(own.map(|node| (*node, fix.dofs.clone(), fix.place)));
        }
        let place = held.first()?.2;
        self.release(nodes);
        let all: Vec<[f64; 3]> = nodes.iter().filter_map(|&n| self.rows.at(n)).collect();
        let offset = |x: &[f64; 3], c: usize| (x[c] - centre[c]).abs();
        let size = all.iter().flat_map(|x| [0, 1, 2].map(|c| offset(x, c))).fold(0.0, f64::max);
        let mut fixed = BTreeSet::new();
        for (node, dofs, _) in held {
            let x = self.rows.at(node)?;
            for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
                if dofs.contains(&axis) {
                    // A rotation about b moves nodes along c that are off the centre along d.
                    let pairs = [(1, 2), (2, 1)].map(|(b, d)| ((c + b) % 3, (c + d) % 3));
                    let turns = pairs.into_iter().filter(|&(_, d)| offset(&x, d) > 1e-6 * size);
                    fixed.extend(turns.map(|(b, _)| ["rx", "ry", "rz"][b]));
                }
            }
            fixed.extend(dofs);
        }
        Some((fixed, place))
    }

    /// Returns what constraints of single nodes of a rigid body fix of it, where they mean the same
    /// for the body: constraints of its centre, and those of a node that fix with an axis the
    /// rotations that move the node along it. Removes the nodes from these constraints.
    pub(super) fn held_as_body(
        &mut self,
        nodes: &BTreeSet<NodeId>,
        centre: Option<NodeId>,
    ) -> BTreeSet<&'static str> {
        let is_own = |node: &NodeId| nodes.contains(node) || Some(*node) == centre;
        let mut held: BTreeMap<NodeId, BTreeSet<&'static str>> = BTreeMap::new();
        for fix in &self.fixes {
            for node in fix.nodes.iter().copied().filter(is_own) {
                held.entry(node).or_default().extend(&fix.dofs);
            }
        }
        let all: BTreeSet<&'static str> = held.values().flatten().copied().collect();
        let moves = |node: &NodeId, dofs: &BTreeSet<&'static str>| {
            let turns = [("x", ["ry", "rz"]), ("y", ["rz", "rx"]), ("z", ["rx", "ry"])];
            let is_free = |axis: &&(&str, [&str; 2])| {
                dofs.contains(axis.0) && axis.1.iter().any(|turn| !all.contains(turn))
            };
            Some(*node) != centre && turns.iter().any(|axis| is_free(&axis))
        };
        if held.iter().any(|(node, dofs)| moves(node, dofs)) {
            return BTreeSet::new();
        }
        self.release(&held.keys().copied().collect());
        all
    }

    /// Removes nodes from all constraints.
    fn release(&mut self, nodes: &BTreeSet<NodeId>) {
        for fix in &mut self.fixes {
            let before = fix.nodes.len();
            fix.nodes.retain(|n| !nodes.contains(n));
            if fix.nodes.len() < before && !fix.is_new {
                (fix.set, fix.is_new) = (format!("{}-deformable", fix.set), true);
            }
        }
    }

    /// Adds all constraints of nodes. Nodes that only give beams their axes need none.
    pub(super) fn fixes(&mut self) {
        let beams = self.rows.elements().filter(|e| e.shape == Shape::Beam2);
        let mut axes: HashSet<NodeId> = beams.map(|e| e.nodes[2]).collect();
        self.rows.elements().flat_map(|e| e.corners()).for_each(|node| {
            axes.remove(node);
        });
        for DeckFix { set, is_new, nodes, dofs, place } in std::mem::take(&mut self.fixes) {
            if dofs.is_empty() || nodes.is_empty() && is_new {
                continue;
            }
            if !nodes.is_empty() && nodes.iter().all(|node| axes.contains(node)) {
                let asked = format!("constraints of {} nodes for axes of beams", nodes.len());
                self.map(&set, &asked, "none: these nodes are corners of no element");
                continue;
            }
            if is_new {
                self.rows.add_set(set.clone(), nodes, place);
            }
            let table = JobTable::new(place).with("nodes", place, set).with("dofs", place, dofs);
            self.add("fix", table);
        }
    }

    fn dofs(&mut self, record: &CardRecord) -> Vec<&'static str> {
        let cid = record.integer("cid");
        if !self.is_plain(cid) {
            self.unsupported_value(
                record,
                "cid",
                "constraints along axes other than the global ones",
            );
        }
        DOFS.iter().filter(|(field, _)| record.integer(field) == 1).map(|(_, dof)| *dof).collect()
    }

    /// Converts `*BOUNDARY_PRESCRIBED_MOTION_...`.
    pub(super) fn motions(&mut self) {
        for record in self.take_records("BOUNDARY_PRESCRIBED_MOTION_SET") {
            let (nsid, place) = (record.integer("nsid"), record.place("nsid"));
            let Some(set) = self.node_set(nsid, place) else { continue };
            self.motion(&record, "nodes", set, place);
        }
        for record in self.take_records("BOUNDARY_PRESCRIBED_MOTION_NODE") {
            let (nid, place) = (record.integer("nid"), record.place("nid"));
            let name = format!("motion-node-{nid}");
            self.rows.add_set(name.clone(), id(nid).into_iter().collect(), place);
            self.motion(&record, "nodes", name, place);
        }
        for record in self.take_records("BOUNDARY_PRESCRIBED_MOTION_RIGID") {
            let (pid, place) = (record.integer("pid"), record.place("pid"));
            match self.bodies.get(&pid).cloned() {
                Some(body) => self.motion(&record, "rigid", body, place),
                None => {
                    let known: Vec<String> = self.bodies.keys().map(i64::to_string).collect();
                    self.missing(place, "rigid part", pid, &known);
                }
            }
        }
    }

    /// Returns what a card prescribes of nodes or of a rigid body, as `key` says.
    fn course(&mut self, record: &CardRecord, key: &str) -> Option<DirectedMotion> {
        let (dof, vad) = (record.integer("dof"), record.integer("vad"));
        let (translations, rotations) = (["x", "y", "z"], ["rx", "ry", "rz"]);
        let unit = |axis: usize| [0, 1, 2].map(|c| if c == axis { 1.0 } else { 0.0 });
        match dof {
            1..=3 => {
                let axis = dof as usize - 1;
                let dofs = vec![translations[axis]];
                Some(DirectedMotion { direction: unit(axis), dofs, rotation: false })
            }
            5..=7 => {
                let axis = dof as usize - 5;
                let dofs = vec![rotations[axis]];
                Some(DirectedMotion { direction: unit(axis), dofs, rotation: true })
            }
            9..=11 if matches!(vad, 0 | 2) && key == "nodes" => {
                let axis = dof as usize - 9;
                let dofs = [1, 2].map(|next| translations[(axis + next) % 3]).to_vec();
                Some(DirectedMotion { direction: unit(axis), dofs, rotation: true })
            }
            4 | 8 | -4 | -8 => {
                let lost = "the motion is left out";
                let along = self.vector(record.integer("vid"), record.place("vid"), lost)?;
                let length = along.iter().map(|c| c * c).sum::<f64>().sqrt();
                if length == 0.0 {
                    let message = format!("{}: its vector has no length", record.name());
                    let help = "give the *DEFINE_VECTOR a head that is not its tail";
                    self.trouble.error(record.place("vid"), message, help);
                    return None;
                }
                let direction = along.map(|c| c / length);
                let names = if dof.abs() == 8 { rotations } else { translations };
                let axis = (0..3).find(|&c| direction[c].abs() > 1.0 - 1e-12);
                let dofs = match axis {
                    _ if dof < 0 => names.to_vec(),
                    Some(axis) => vec![names[axis]],
                    None => {
                        let why = "a motion along a vector that is not parallel to an axis, and \
                                   free across it; use dof -4 or -8, which fix it across";
                        self.unsupported_card(record, "dof", why);
                        return None;
                    }
                };
                Some(DirectedMotion { direction, dofs, rotation: dof.abs() == 8 })
            }
            _ => {
                self.unsupported_card(
                    record,
                    "dof",
                    "use x, y, z (1, 2, 3), rotations about them (5, 6, 7), a vector (4, -4, 8, \
                     -8), or rotations of nodes about a parallel axis (9, 10, 11) by velocity or \
                     displacement",
                );
                None
            }
        }
    }

    fn motion(&mut self, record: &CardRecord, key: &str, of: String, place: Place) {
        let (dof, vad) = (record.integer("dof"), record.integer("vad"));
        let (birth, death) = (record.real("birth"), record.real("death"));
        if death != 0.0 && death <= birth {
            let message = format!("{}: its death is not after its birth", record.name());
            let help = "give a death above the birth, or 0 for none";
            return self.trouble.error(record.place("death"), message, help);
        }
        let Some(DirectedMotion { direction, dofs, rotation }) = self.course(record, key) else {
            return;
        };
        let form = match (vad, rotation) {
            (0, false) => "velocity",
            (1, false) => "acceleration",
            (2, false) => "displacement",
            (0, true) => "spin",
            (2, true) if key == "rigid" || dof > 8 => "rotation",
            _ => {
                return self.unsupported_card(
                    record,
                    "vad",
                    "use velocity (0), for translations acceleration (1) or displacement (2), or \
                     for rotations of rigid parts the rotation (2)",
                );
            }
        };
        if form == "acceleration" && birth > 0.0 {
            let why = "an acceleration that begins later; give the velocity or the displacement";
            return self.unsupported_card(record, "birth", why);
        }
        let lcid = record.integer("lcid");
        let Some(curve) = self.time_curve_from(lcid, record.place("lcid"), birth) else {
            return;
        };
        let factor = if record.real("sf") == 0.0 { 1.0 } else { record.real("sf") };
        let amount = direction.map(|c| factor * c);
        let mut table = JobTable::new(record.head);
        if dof > 8 {
            let axis = dof as usize - 9;
            // Both offsets are in the order of the axes after that of the rotation.
            let mut centre = [0.0; 3];
            centre[(axis + 1) % 3] = record.real("offset1");
            centre[(axis + 2) % 3] = record.real("offset2");
            table.put("centre", record.place("offset1"), centre);
        }
        let mut table = table
            .with(key, place, of)
            .with("dofs", record.place("dof"), dofs)
            .with(form, record.place("vad"), amount)
            .with("curve", record.place("lcid"), curve);
        if birth > 0.0 {
            table.put("birth", record.place("birth"), birth);
            let counts = ["displacement", "rotation"].contains(&form);
            let from = if counts { ", and counts from the place then" } else { "" };
            self.map(
                record.name(),
                format!("{form} with birth {birth}"),
                format!("its curve starts at this time{from}"),
            );
        }
        if death != 0.0 && death < self.end_time {
            table.put("death", record.place("death"), death);
        }
        self.add("motion", table);
    }
}
