//! Writes bodies, constraints, motions, loads, walls, masses and histories.

use super::{Gap, Real, StarterWriter, Whole, Word, list, named};
use crate::input::deck::convert::space::{cross, unit};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{JointInput, MotionInput, NodeHistory, PressureInput, WallInput};
use std::collections::BTreeSet;
use toml::{Table, Value};

const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
const DIRECTIONS: [&str; 6] = ["X", "Y", "Z", "XX", "YY", "ZZ"];
/// Distance up to which a wall looks for nodes, beyond all models.
const FAR: f64 = 1e20;

/// A motion of one degree of freedom.
struct MotionRow {
    keyword: &'static str,
    dof: usize,
    amount: f64,
}

impl StarterWriter<'_> {
    /// Writes rigid bodies, each with a main node at the mean position of its nodes.
    pub(super) fn bodies(&mut self) {
        let model = self.model;
        for (body, id) in model.job.rigid.iter().zip(1..) {
            let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
            if let Some(set) = body.nodes.as_ref().and_then(|s| model.mesh.node_sets.get(s)) {
                nodes.extend(set);
            }
            let of_parts = model.mesh.elements.iter().filter(|e| body.parts.contains(&e.part));
            nodes.extend(of_parts.flat_map(|e| e.corners()));
            let at = model.mesh.nodes.iter().filter(|n| nodes.contains(&n.id));
            let sum = at.clone().fold([0.0; 3], |s, n| [0, 1, 2].map(|c| s[c] + n.x[c]));
            let count = at.count().max(1) as f64;
            let main = self.new_node(sum.map(|s| s / count));
            let ids: Vec<u64> = nodes.iter().map(|n| n.label()).collect();
            let group = self.new_group(&format!("nodes of {}", body.name), &ids);
            self.titled("RBODY", id, &body.name);
            // Ikrem 1: walls stop the nodes of bodies.
            let head = [Whole(main), Gap, Gap, Gap, Gap, Gap, Whole(group), Whole(1)];
            self.card(&head);
            self.mains.insert(body.name.clone(), main);
            self.body_nodes.push((main, nodes));
            // A reader gives a body the name of no part.
            let is_part = model.settings.parts.iter().any(|p| p.name == body.name);
            let name = if is_part { format!("body-{id}") } else { body.name.clone() };
            let mut own = Table::from_iter([named(&name)]);
            self.body_names.insert(body.name.clone(), name);
            if let Some(mass) = body.mass {
                own.insert("mass".into(), mass.into());
            }
            for (key, numbers) in [
                ("centre", body.centre.map(|c| c.to_vec())),
                ("inertia", body.inertia.map(|i| i.to_vec())),
                ("added_inertia", body.added_inertia.map(|i| i.to_vec())),
            ] {
                own.extend(numbers.map(|numbers| (key.to_string(), Value::from(numbers))));
            }
            if body.from > 0.0 || body.until.is_some() {
                let name = &body.name;
                self.lose(format!(
                    "rigid body {name}: it is rigid in the whole run, not in a part"
                ));
                own.insert("from".into(), body.from.into());
                own.extend(body.until.map(|until| ("until".into(), until.into())));
            }
            if let (false, Ok(stops)) = (body.stop.is_empty(), Value::try_from(&body.stop)) {
                self.lose(format!("rigid body {}: it has no stops", body.name));
                own.insert("stop".into(), stops);
            }
            if let (false, Ok(loads)) = (body.load.is_empty(), Value::try_from(&body.load)) {
                self.lose(format!("rigid body {}: it has no loads at its centre", body.name));
                own.insert("load".into(), loads);
            }
            if own.len() > 1 {
                self.rest("rigid", own);
            }
        }
    }

    /// Leaves joints without a card; they name bodies as the reader does.
    pub(super) fn joints(&mut self) {
        let own = |name: &String| self.body_names.get(name).unwrap_or(name).clone();
        let renamed = |joint: &JointInput| JointInput {
            bodies: joint.bodies.iter().map(own).collect(),
            ..joint.clone()
        };
        let all: Vec<JointInput> = self.model.job.joint.iter().map(renamed).collect();
        list(&mut self.deck, "joint", &all);
    }

    pub(super) fn fixes(&mut self) {
        let model = self.model;
        let mut id = 0;
        for fix in &model.job.fix {
            id += 1;
            let group = self.group(&fix.nodes);
            self.bcs(id, &format!("fixed {}", fix.nodes), &fix.dofs, group);
        }
        for body in model.job.rigid.iter().filter(|b| !b.fixed.is_empty()) {
            id += 1;
            let main = self.mains.get(&body.name).copied().unwrap_or(0);
            let group = self.new_group(&format!("main node of {}", body.name), &[main]);
            self.bcs(id, &format!("fixed {}", body.name), &body.fixed, group);
        }
    }

    fn bcs(&mut self, id: u64, title: &str, dofs: &[String], group: u64) {
        let code = DOFS.map(|d| if dofs.iter().any(|own| own == d) { '1' } else { '0' });
        let code: String = code.iter().collect();
        self.titled("BCS", id, title);
        let text = format!("   {} {}{:>10}{group:>10}", &code[..3], &code[3..], 0);
        self.deck.text(&text);
    }

    /// Writes motions of one degree of freedom; if one has no card, none is written as a card.
    pub(super) fn motions(&mut self) {
        let model = self.model;
        let rows: Option<Vec<MotionRow>> = model.job.motion.iter().map(row).collect();
        let Some(rows) = rows else {
            let renamed = |motion: &MotionInput| {
                let own = motion.rigid.as_ref();
                let rigid = own.map(|name| self.body_names.get(name).unwrap_or(name).clone());
                MotionInput { rigid, ..motion.clone() }
            };
            let all: Vec<MotionInput> = model.job.motion.iter().map(renamed).collect();
            return list(&mut self.deck, "motion", &all);
        };
        for ((motion, row), id) in model.job.motion.iter().zip(rows).zip(1..) {
            let function = self.function(motion.curve.as_deref());
            let group = match (&motion.nodes, &motion.rigid) {
                (Some(set), _) => self.group(set),
                (None, Some(body)) => {
                    let main = self.mains.get(body).copied().unwrap_or(0);
                    self.new_group(&format!("main node of {body}, motion {id}"), &[main])
                }
                (None, None) => 0,
            };
            self.motion_card(row.keyword, id, (row.dof, row.amount), (function, group));
        }
    }

    fn motion_card(
        &mut self,
        keyword: &str,
        id: u64,
        (dof, amount): (usize, f64),
        (function, group): (u64, u64),
    ) {
        self.titled(keyword, id, &format!("motion {id}"));
        self.card(&[Whole(function), Word(DIRECTIONS[dof]), Whole(0), Whole(0), Whole(group)]);
        self.card(&[Real(1.0), Real(amount)]);
    }

    /// Writes initial velocities and masses.
    pub(super) fn initial(&mut self) {
        let model = self.model;
        let velocities = &model.job.initial_velocity;
        if velocities.iter().any(|v| v.spin != [0.0; 3]) {
            list(&mut self.deck, "initial_velocity", velocities);
        } else {
            for (velocity, id) in velocities.iter().zip(1..) {
                let group = self.moving_group(velocity.nodes.as_deref());
                self.titled("INIVEL/TRA", id, &format!("initial velocity {id}"));
                let [x, y, z] = velocity.velocity.map(Real);
                self.card(&[x, y, z, Whole(group)]);
            }
        }
        for (mass, id) in model.job.mass.iter().zip(1..) {
            let group = self.group(&mass.nodes);
            self.keyword(&format!("ADMAS/1/{id}"));
            self.deck.text(&format!("mass of {}", mass.nodes));
            self.card(&[Real(mass.mass), Whole(group)]);
        }
    }

    /// Returns the id of a group of the nodes of a set, or of all nodes, together with the main
    /// nodes of the bodies whose nodes all are in it: a body has the velocity of its main node.
    fn moving_group(&mut self, set: Option<&str>) -> u64 {
        let mesh = &self.model.mesh;
        let nodes: BTreeSet<NodeId> = match set {
            Some(set) => mesh.node_sets.get(set).into_iter().flatten().copied().collect(),
            None => mesh.nodes.iter().map(|n| n.id).collect(),
        };
        let is_whole = |of: &&(u64, BTreeSet<NodeId>)| of.1.is_subset(&nodes);
        let mains: Vec<u64> = self.body_nodes.iter().filter(is_whole).map(|of| of.0).collect();
        let is_part = |of: &&(u64, BTreeSet<NodeId>)| !is_whole(of) && !of.1.is_disjoint(&nodes);
        let partly = self.body_nodes.iter().filter(is_part).count();
        let of = set.unwrap_or("all nodes");
        if partly > 0 {
            self.lose(format!(
                "initial velocity of {of}: it moves a part of the nodes of {partly} bodies, which \
                 other programs ignore"
            ));
        }
        if let (Some(set), true) = (set, mains.is_empty()) {
            return self.group(set);
        }
        let there = |n: &&NodeId| mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok();
        let own = nodes.iter().filter(there).map(|n| n.label());
        let all: Vec<u64> = own.chain(mains).collect();
        self.new_group(&format!("{of} with main nodes"), &all)
    }

    /// Writes gravity, forces on nodes and pressure on parts.
    pub(super) fn loads(&mut self) {
        let model = self.model;
        let mut id = 0;
        if model.job.gravity.iter().any(|g| !g.parts.is_empty()) {
            return list(&mut self.deck, "gravity", &model.job.gravity);
        }
        for gravity in &model.job.gravity {
            let function = self.function(gravity.curve.as_deref());
            let group = gravity.nodes.as_deref().map_or(0, |nodes| self.group(nodes));
            for axis in (0..3).filter(|&axis| gravity.acceleration[axis] != 0.0) {
                id += 1;
                self.titled("GRAV", id, &format!("gravity {id}"));
                let head = [Whole(function), Word(DIRECTIONS[axis]), Gap, Gap, Whole(group), Gap];
                self.card(&[&head[..], &[Real(1.0), Real(gravity.acceleration[axis])]].concat());
            }
        }
        self.forces();
        let pressures = &model.job.pressure;
        let has_no_card =
            |p: &PressureInput| p.nodes.is_some() || p.pressure == 0.0 || p.blast.is_some();
        if pressures.iter().any(has_no_card) {
            return list(&mut self.deck, "pressure", pressures);
        }
        for (pressure, id) in pressures.iter().zip(1..) {
            let function = self.function(pressure.curve.as_deref());
            let surface = self.new_surface(&format!("faces of pressure {id}"), &pressure.parts);
            self.titled("PLOAD", id, &format!("pressure {id}"));
            let head = [Whole(surface), Whole(function), Gap, Gap, Gap, Gap];
            // A positive value acts along the normal in a deck, and against it in a job.
            self.card(&[&head[..], &[Real(1.0), Real(-pressure.pressure)]].concat());
        }
    }

    /// Writes forces on nodes. A deck loads each node, a job a set. If the sum over the nodes is
    /// not the force of the set to the last bit, all loads are left without a card.
    fn forces(&mut self) {
        let model = self.model;
        let mut cards = Vec::new();
        for load in &model.job.load {
            let nodes = model.mesh.node_sets.get(&load.nodes);
            let there = |n: &&NodeId| model.mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok();
            let count = nodes.map_or(0, |nodes| nodes.iter().filter(there).count()) as f64;
            let amounts = load.force.into_iter().chain(load.moment).enumerate();
            for (dof, amount) in amounts.filter(|a| a.1 != 0.0) {
                let one = amount / count;
                if count == 0.0 || one * count != amount {
                    return list(&mut self.deck, "load", &model.job.load);
                }
                cards.push((load, dof, one));
            }
        }
        for ((load, dof, amount), id) in cards.into_iter().zip(1..) {
            let function = self.function(load.curve.as_deref());
            let group = self.group(&load.nodes);
            self.titled("CLOAD", id, &format!("load of {}", load.nodes));
            let head = [Whole(function), Word(DIRECTIONS[dof]), Gap, Gap, Whole(group), Gap];
            self.card(&[&head[..], &[Real(1.0), Real(amount)]].concat());
        }
    }

    pub(super) fn walls(&mut self) {
        let model = self.model;
        for (wall, id) in model.job.wall.iter().zip(1..) {
            self.wall(wall, id);
        }
    }

    fn wall(&mut self, wall: &WallInput, id: u64) {
        let name = if wall.name.is_empty() { format!("wall-{id}") } else { wall.name.clone() };
        let mut exact = Table::from_iter([named(&name)]);
        let mut end = |key: &str, v: [f64; 3]| {
            let end = [0, 1, 2].map(|c| wall.point[c] + v[c]);
            if [0, 1, 2].map(|c| end[c] - wall.point[c]) != v {
                exact.insert(key.into(), Value::from(v.to_vec()));
            }
            end
        };
        let sides = rectangle(wall);
        let (keyword, end) = match (wall.axis, wall.normal) {
            (Some(axis), _) => ("RWALL/CYL", Some(end("axis", axis))),
            (None, Some(_)) if sides.is_some() => ("RWALL/PARAL", None),
            (None, Some(normal)) => ("RWALL/PLANE", Some(end("normal", normal))),
            (None, None) => ("RWALL/SPHER", None),
        };
        if let Some(edge) = wall.edge {
            exact.insert("edge".into(), Value::from(edge.to_vec()));
            exact.insert("lengths".into(), Value::from(wall.lengths.unwrap_or_default().to_vec()));
            exact.insert("normal".into(), Value::from(wall.normal.unwrap_or_default().to_vec()));
        }
        if wall.length != 0.0 {
            exact.insert("length".into(), wall.length.into());
        }
        if wall.birth > 0.0 || wall.death.is_some() {
            self.lose(format!("wall {name}: it stops nodes in the whole run, not in a part"));
            exact.insert("birth".into(), wall.birth.into());
            exact.extend(wall.death.map(|death| ("death".into(), death.into())));
        }
        let node = self.wall_motion(wall, &mut exact);
        let group = |w: &Self, set: &Option<String>| set.as_deref().map_or(0, |s| w.group(s));
        let (mut own, except) = (group(self, &wall.nodes), group(self, &wall.except));
        let mut reach = if wall.nodes.is_some() { 0.0 } else { FAR };
        // The search finds nodes in front of a wall only.
        if wall.nodes.is_none() && self.has_nodes_behind(wall) {
            let all: Vec<u64> = self.model.mesh.nodes.iter().map(|n| n.id.label()).collect();
            own = self.new_group(&format!("nodes of {name}"), &all);
            reach = 0.0;
        }
        self.titled(keyword, id, &name);
        let slide = if wall.friction > 0.0 { 2 } else { 0 };
        self.card(&[Whole(node.unwrap_or(0)), Whole(slide), Whole(own), Whole(except)]);
        self.card(&[Real(reach), Real(wall.friction), Real(2.0 * wall.radius.unwrap_or(0.0))]);
        match node {
            None => self.card(&wall.point.map(Real)),
            Some(_) => {
                let mass = wall.mass.unwrap_or(0.0);
                let normal = wall.normal.unwrap_or_default();
                let size = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
                let v = normal.map(|c| wall.speed * c / size);
                let along: f64 = (0..3).map(|c| normal[c] / size * v[c]).sum();
                if wall.mass.is_some() && along != wall.speed {
                    exact.insert("speed".into(), wall.speed.into());
                }
                let v = if wall.mass.is_some() { v } else { [0.0; 3] };
                self.card(&[Real(mass), Real(v[0]), Real(v[1]), Real(v[2])]);
            }
        }
        if let Some(end) = end {
            self.card(&end.map(Real));
        }
        for end in sides.into_iter().flatten() {
            self.card(&end.map(Real));
        }
        if exact.len() > 1 {
            self.rest("wall", exact);
        }
    }

    /// Returns true if nodes are behind a wall at the start: under its plane, or in it.
    fn has_nodes_behind(&self, wall: &WallInput) -> bool {
        let along = wall.axis.or(wall.normal);
        self.model.mesh.nodes.iter().any(|node| {
            let d = [0, 1, 2].map(|c| node.x[c] - wall.point[c]);
            let of = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
            match (along, wall.radius) {
                (Some(axis), Some(radius)) => {
                    of(d, d) - of(d, axis).powi(2) / of(axis, axis) < radius * radius
                }
                (Some(normal), None) => of(d, normal) < 0.0,
                (None, radius) => of(d, d) < radius.unwrap_or(0.0).powi(2),
            }
        })
    }

    /// Adds the node of a moving wall, with its motion along an axis.
    fn wall_motion(&mut self, wall: &WallInput, exact: &mut Table) -> Option<u64> {
        let forms =
            [("IMPVEL", "velocity", wall.velocity), ("IMPDISP", "displacement", wall.displacement)];
        let led = forms.into_iter().find_map(|(keyword, key, v)| Some((keyword, key, v?)));
        if wall.mass.is_none() && led.is_none() {
            return None;
        }
        let node = self.new_node(wall.point);
        let Some((keyword, key, v)) = led else { return Some(node) };
        let curve = wall.curve.as_deref();
        let alone = (0..3)
            .find(|&axis| v[axis] != 0.0)
            .filter(|&axis| (0..3).all(|c| c == axis || v[c] == 0.0));
        match alone {
            Some(axis) => {
                let function = self.function(curve);
                let group = self.new_group(&format!("node of {}", wall.name), &[node]);
                let id = self.model.job.motion.len() as u64 + node;
                self.motion_card(keyword, id, (axis, v[axis]), (function, group));
                Some(node)
            }
            None => {
                exact.insert(key.into(), Value::from(v.to_vec()));
                if let Some(curve) = curve {
                    exact.insert("curve".into(), curve.into());
                }
                None
            }
        }
    }

    /// Writes nodes whose motion is recorded.
    pub(super) fn histories(&mut self) {
        let model = self.model;
        if has_axes(&model.job.output.node) {
            return;
        }
        for (history, id) in model.job.output.node.iter().zip(1..) {
            let mut ids = history.ids.clone();
            if let Some(set) = history.nodes.as_ref().and_then(|s| model.mesh.node_sets.get(s)) {
                ids.extend(set.iter().map(|n| n.label()));
            }
            let own = history.nodes.clone().unwrap_or_else(|| format!("nodes {id}"));
            let title = if history.name.is_empty() { own } else { history.name.clone() };
            self.titled("TH/NODE", id, &title);
            self.deck.text("DEF");
            ids.iter().for_each(|&id| self.card(&[Whole(id), Whole(0)]));
        }
    }
}

/// Returns true if a history has axes, for which there is no card. Then all histories of nodes are
/// written as keys, so that they keep their order.
pub(super) fn has_axes(histories: &[NodeHistory]) -> bool {
    histories.iter().any(|history| history.axes.is_some())
}

/// Returns the ends of both sides of a rectangle; `None` if the wall is none.
fn rectangle(wall: &WallInput) -> Option<[[f64; 3]; 2]> {
    let (normal, edge) = (wall.normal.filter(|_| wall.axis.is_none())?, wall.edge?);
    let [one, other] = wall.lengths.filter(|sizes| sizes.iter().all(|s| *s > 0.0))?;
    let first = unit(edge)?;
    let second = unit(cross(normal, first))?;
    let end = |way: [f64; 3], size: f64| [0, 1, 2].map(|c| wall.point[c] + size * way[c]);
    Some([end(first, one), end(second, other)])
}

/// Returns the card of a motion; `None` if it has none.
fn row(motion: &MotionInput) -> Option<MotionRow> {
    if motion.birth > 0.0 || motion.death.is_some() || motion.rotation.is_some() {
        return None;
    }
    let [dof] = motion.dofs.as_slice() else { return None };
    let dof = DOFS.iter().position(|d| d == dof)?;
    let (keyword, v, first) =
        match (motion.velocity, motion.displacement, motion.acceleration, motion.spin) {
            (Some(v), None, None, None) => ("IMPVEL", v, 0),
            (None, Some(u), None, None) => ("IMPDISP", u, 0),
            (None, None, Some(a), None) => ("IMPACC", a, 0),
            (None, None, None, Some(w)) if motion.rigid.is_some() => ("IMPVEL", w, 3),
            _ => return None,
        };
    let along = dof.checked_sub(first).filter(|&c| c < 3)?;
    let is_alone = v[along] != 0.0 && (0..3).all(|c| c == along || v[c] == 0.0);
    is_alone.then_some(MotionRow { keyword, dof, amount: v[along] })
}
