//! Converts `/RWALL/...`.

use super::StarterConverter;
use crate::input::deck::convert::space::{cross, unit};
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::NodeId;
use std::collections::BTreeSet;

/// Keywords of walls.
const KEYWORDS: [&str; 4] = ["/RWALL/PLANE", "/RWALL/CYL", "/RWALL/SPHER", "/RWALL/PARAL"];
/// Friction of nodes that a wall holds.
const TIED: f64 = 1.0;
/// Cosine of an angle that counts as right, and part of a speed across that counts as none.
const SMALL: f64 = 1e-6;

/// Shape of a wall: a point, and normal or axis, or the sides of a rectangle.
struct StarterWall {
    point: [f64; 3],
    normal: [f64; 3],
    sides: Option<[[f64; 3]; 2]>,
    radius: f64,
}

impl StarterConverter {
    /// Finds the nodes of walls, on which motions act.
    pub(super) fn find_wall_nodes(&mut self) {
        for name in KEYWORDS {
            for record in self.deck.records.get(name).into_iter().flatten() {
                self.wall_nodes.extend(super::groups::node(record.integer("node")));
            }
        }
    }

    pub(super) fn walls(&mut self) {
        let mut names: BTreeSet<String> = BTreeSet::new();
        for record in self.take(&KEYWORDS) {
            let id = record.integer("id");
            let title = record.word("title").trim().to_string();
            let is_taken = title.is_empty() || names.contains(&title);
            let name = if is_taken { format!("wall-{id}") } else { title };
            names.insert(name.clone());
            self.wall(&record, name);
        }
    }

    fn wall(&mut self, record: &CardRecord, name: String) {
        let node = super::groups::node(record.integer("node"));
        let Some(shape) = self.shape(record, node) else { return };
        let mut table = JobTable::new(record.head)
            .with("name", record.place("title"), name.as_str())
            .with("point", record.place("p1"), shape.point);
        let place = record.place("xm1");
        match record.row.keyword.name {
            "/RWALL/CYL" => table.put("axis", place, shape.normal),
            "/RWALL/SPHER" => {}
            _ => table.put("normal", place, shape.normal),
        }
        if shape.radius > 0.0 {
            table.put("radius", record.place("phi"), shape.radius);
        }
        if let Some([one, other]) = shape.sides {
            table.put("edge", place, one);
            table.put("lengths", place, [length(one), length(other)]);
        }
        table.put("friction", record.place("slide"), self.wall_friction(record, &name));
        if let Some(node) = node {
            self.moving(record, (&name, node), shape.normal, &mut table);
        }
        if !self.stopped(record, &name, &shape, &mut table) {
            return;
        }
        self.deck.add("wall", table);
    }

    /// Returns the shape of a wall. The point of a moving wall is its node.
    fn shape(&mut self, record: &CardRecord, node: Option<NodeId>) -> Option<StarterWall> {
        let name = record.row.keyword.name;
        let point = match node {
            None => ["p1", "p2", "p3"].map(|field| record.real(field)),
            Some(node) => match self.deck.rows.at(node) {
                Some(at) => at,
                None => {
                    let n = record.integer("node");
                    self.deck.missing(record.place("node"), "/NODE", n, &[]);
                    return None;
                }
            },
        };
        let is_round = matches!(name, "/RWALL/CYL" | "/RWALL/SPHER");
        // The diameter of a plane has no meaning.
        let radius = if is_round { 0.5 * record.real("phi") } else { 0.0 };
        let away = |fields: [&str; 3]| {
            let end = fields.map(|field| record.real(field));
            [0, 1, 2].map(|c| end[c] - point[c])
        };
        if name == "/RWALL/SPHER" {
            return Some(StarterWall { point, normal: [0.0; 3], sides: None, radius });
        }
        let first = away(["xm1", "ym1", "zm1"]);
        if name != "/RWALL/PARAL" {
            if first == [0.0; 3] {
                let message = format!("{}/{}: M1 is M", record.name(), record.integer("id"));
                let help = "give M1 on the side of the model (plane) or on the axis (cylinder)";
                self.deck.trouble.error(record.place("xm1"), message, help);
                return None;
            }
            return Some(StarterWall { point, normal: first, sides: None, radius });
        }
        let second = away(["xm2", "ym2", "zm2"]);
        let right = first.iter().zip(&second).map(|(a, b)| a * b).sum::<f64>().abs()
            <= SMALL * length(first) * length(second);
        match unit(cross(first, second)).filter(|_| right) {
            Some(normal) => {
                Some(StarterWall { point, normal, sides: Some([first, second]), radius })
            }
            None => {
                let message = format!(
                    "{}/{}: the sides M M1 and M M2 are not at a right angle",
                    record.name(),
                    record.integer("id")
                );
                let what = "/RWALL/PARAL without a right angle".to_string();
                self.deck.unsupported(record.place("xm2"), message, what);
                None
            }
        }
    }

    fn wall_friction(&mut self, record: &CardRecord, name: &str) -> f64 {
        let given = record.real("fric");
        match record.integer("slide") {
            0 => 0.0,
            1 => {
                let message = format!("{name}: Slide 1 ties nodes, here friction 1 holds them");
                let help = "nodes leave the wall when they rebound, and slide under large forces";
                self.deck.trouble.warning(record.place("slide"), message, help);
                TIED
            }
            2 => given,
            _ => {
                let why = "use 0 (sliding), 1 (tied) or 2 (friction)";
                self.deck.unsupported_value(record, "slide", why);
                given
            }
        }
    }

    /// Converts the motion of a wall with a node: prescribed, or of its mass.
    fn moving(
        &mut self,
        record: &CardRecord,
        (name, node): (&str, NodeId),
        normal: [f64; 3],
        table: &mut JobTable,
    ) {
        let mass = record.real("p1");
        let v = ["p2", "p3", "p4"].map(|field| record.real(field));
        let motions = self.wall_motions.remove(&node).unwrap_or_default();
        if let [motion] = &motions[..]
            && matches!(motion.form, "velocity" | "displacement")
        {
            let mut way = [0.0; 3];
            way[motion.dof] = motion.amount;
            table.put(motion.form, motion.place, way);
            table.put("curve", motion.place, motion.curve.as_str());
            self.deck.map(name, "its node has a prescribed motion", "so does the wall");
            return;
        }
        if !motions.is_empty() {
            let message = format!("{name}: its node has several motions, or accelerations");
            let what = "several motions of a wall".to_string();
            return self.deck.unsupported(record.place("node"), message, what);
        }
        let along = unit(normal).unwrap_or_default();
        let speed: f64 = (0..3).map(|c| along[c] * v[c]).sum();
        let across = [0, 1, 2].map(|c| v[c] - speed * along[c]);
        let is_flat = matches!(record.row.keyword.name, "/RWALL/PLANE" | "/RWALL/PARAL");
        if mass > 0.0 && is_flat && length(across) <= SMALL * length(v) {
            table.put("mass", record.place("p1"), mass);
            table.put("speed", record.place("p2"), speed);
            self.deck.map(name, "a wall with a mass", "it moves along its normal only");
        } else if mass <= 0.0 && v == [0.0; 3] {
            self.deck.map(name, "a node without mass and velocity", "a wall at rest");
        } else {
            let message = format!(
                "{name}: a wall that moves freely is supported only if it is flat, has a mass and \
                 moves along its normal"
            );
            self.deck.unsupported(record.place("p1"), message, "free motion of a wall".into());
        }
    }

    /// Converts the nodes that the wall stops. Returns false if there are none.
    fn stopped(
        &mut self,
        record: &CardRecord,
        name: &str,
        shape: &StarterWall,
        table: &mut JobTable,
    ) -> bool {
        let (reach, place) = (record.real("d"), record.place("grnod1"));
        let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
        let added = record.integer("grnod1");
        if added != 0 && self.deck.node_set(added, place).is_some() {
            nodes.extend(&self.deck.node_sets[&added].0);
        }
        let used = self.used_nodes().clone();
        if reach > 0.0 {
            for &node in &used {
                let at = self.deck.rows.at(node).map(|x| shape.distance(x));
                let near = at.is_some_and(|d| (0.0..=reach).contains(&d));
                nodes.extend(near.then_some(node));
            }
        }
        let removed = record.integer("grnod2");
        let gone: BTreeSet<NodeId> =
            match removed != 0 && self.deck.node_set(removed, record.place("grnod2")).is_some() {
                true => self.deck.node_sets[&removed].0.iter().copied().collect(),
                false => BTreeSet::new(),
            };
        let of_bodies = self.nodes_without_walls(name, &nodes);
        let is_all = used.is_subset(&nodes);
        let is_group = of_bodies.is_empty();
        let gone: BTreeSet<NodeId> = gone.union(&of_bodies).copied().collect();
        let left: Vec<NodeId> = nodes.difference(&gone).copied().collect();
        if left.is_empty() {
            let message = format!("{name} is left out: it stops no nodes");
            let help = "name them by grnd_ID1, or give the distance d up to which it looks for \
                        nodes";
            self.deck.trouble.warning(place, message, help);
            return false;
        }
        if is_all && !gone.is_empty() && is_group {
            table.put("except", record.place("grnod2"), format!("set-{removed}"));
        } else if !is_all && gone.is_empty() && reach <= 0.0 {
            table.put("nodes", place, format!("set-{added}"));
        } else if !is_all || !gone.is_empty() {
            let set = self.deck.rows.add_new_set(&format!("{name} nodes"), left, place);
            table.put("nodes", place, set);
        }
        true
    }
}

impl StarterConverter {
    /// Returns those of the nodes that belong to bodies whose nodes walls do not stop.
    fn nodes_without_walls(&mut self, name: &str, nodes: &BTreeSet<NodeId>) -> BTreeSet<NodeId> {
        let mut found = BTreeSet::new();
        for body in self.mains.values().filter(|body| !body.in_walls) {
            let own: Vec<NodeId> = body.nodes.intersection(nodes).copied().collect();
            if !own.is_empty() {
                let asked = format!("Ikrem 0 of the body {}", body.name);
                self.deck.map(name, asked, format!("does not stop its {} nodes", own.len()));
            }
            found.extend(own);
        }
        found
    }
}

impl StarterWall {
    /// Returns the distance of a point from the wall, or from its plane [length]; negative behind
    /// it.
    fn distance(&self, x: [f64; 3]) -> f64 {
        let d = [0, 1, 2].map(|c| x[c] - self.point[c]);
        let Some(along) = unit(self.normal) else { return length(d) - self.radius };
        let height: f64 = (0..3).map(|c| d[c] * along[c]).sum();
        match self.radius > 0.0 {
            true => length([0, 1, 2].map(|c| d[c] - height * along[c])) - self.radius,
            false => height,
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
