//! Converts joints between rigid bodies, and their resistance.

use super::DeckConverter;
use super::names::unique;
use super::sets::id;
use super::space::unit;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use std::collections::HashSet;
use std::f64::consts::TAU;

/// Keywords of joints, their kinds in a job, and true if they have an axis.
const KINDS: [(&str, &str, bool); 8] = [
    ("CONSTRAINED_JOINT_SPHERICAL", "spherical", false),
    ("CONSTRAINED_JOINT_REVOLUTE", "revolute", true),
    ("CONSTRAINED_JOINT_CYLINDRICAL", "cylindrical", true),
    ("CONSTRAINED_JOINT_PLANAR", "planar", true),
    ("CONSTRAINED_JOINT_TRANSLATIONAL", "translational", true),
    ("CONSTRAINED_JOINT_UNIVERSAL", "universal", true),
    ("CONSTRAINED_JOINT_LOCKING", "fixed", false),
    ("CONSTRAINED_JOINT_SCREW", "screw", true),
];
/// Smallest cosine of the angle between the axis of a joint and that of a system that it belongs
/// to: coordinates of a deck have few digits.
const ALIGNED: f64 = 0.999;
/// A stop that is never reached, for a blank one.
const FAR: f64 = 1e20;

/// A joint under construction.
struct DeckJoint {
    /// Id of the deck, if it gives one.
    id: Option<i64>,
    heading: String,
    kind: &'static str,
    bodies: [String; 2],
    axis: Option<[f64; 3]>,
    table: JobTable,
}

/// Names of the fields of a stiffness for each axis of its system.
struct StiffnessFields {
    keyword: &'static str,
    /// Key of the joint.
    key: &'static str,
    /// Kinds of joints that have this key.
    kinds: &'static [&'static str],
    curve: [&'static str; 3],
    damping: [&'static str; 3],
    /// Stiffness before friction and at stops; 0 makes both inactive.
    stiffness: [&'static str; 3],
    friction: [&'static str; 3],
    stops: [[&'static str; 2]; 3],
    /// Factor on stops.
    scale: f64,
}

const STIFFNESSES: [StiffnessFields; 2] = [
    StiffnessFields {
        keyword: "CONSTRAINED_JOINT_STIFFNESS_GENERALIZED",
        key: "rotation",
        kinds: &["revolute", "cylindrical", "screw"],
        curve: ["lcidph", "lcidt", "lcidps"],
        damping: ["dlcidph", "dlcidt", "dlcidps"],
        stiffness: ["esph", "est", "esps"],
        friction: ["fmph", "fmt", "fmps"],
        stops: [["nsaph", "psaph"], ["nsat", "psat"], ["nsaps", "psaps"]],
        scale: TAU / 360.0,
    },
    StiffnessFields {
        keyword: "CONSTRAINED_JOINT_STIFFNESS_TRANSLATIONAL",
        key: "sliding",
        kinds: &["cylindrical", "translational"],
        curve: ["lcidx", "lcidy", "lcidz"],
        damping: ["dlcidx", "dlcidy", "dlcidz"],
        stiffness: ["esx", "esy", "esz"],
        friction: ["ffx", "ffy", "ffz"],
        stops: [["nsdx", "psdx"], ["nsdy", "psdy"], ["nsdz", "psdz"]],
        scale: 1.0,
    },
];

impl DeckConverter {
    /// Converts joints. Rigid bodies are known.
    pub(super) fn joints(&mut self) {
        let mut joints: Vec<DeckJoint> = Vec::new();
        for record in self.take_in_order(&KINDS.map(|kind| kind.0)) {
            let name = record.row.keyword.name;
            if let Some(&(_, kind, has_axis)) = KINDS.iter().find(|kind| kind.0 == name) {
                joints.extend(self.joint(&record, kind, has_axis));
            }
        }
        for fields in &STIFFNESSES {
            for record in self.take_records(fields.keyword) {
                self.joint_stiffness(&record, fields, &mut joints);
            }
        }
        // Joints without an id get numbers that no other one has.
        let mut free = joints.iter().filter_map(|joint| joint.id).max().unwrap_or(0);
        let mut names = HashSet::new();
        for mut joint in joints {
            let id = joint.id.unwrap_or_else(|| {
                free += 1;
                free
            });
            let name = match joint.heading.as_str() {
                "" => format!("joint-{id}"),
                heading => heading.to_string(),
            };
            let name = unique(name, id, &mut names);
            joint.table.put("name", joint.table.place(), name);
            self.add("joint", joint.table);
        }
    }

    fn joint(
        &mut self,
        record: &CardRecord,
        kind: &'static str,
        has_axis: bool,
    ) -> Option<DeckJoint> {
        let place = record.place("n1");
        let id = record.has("ID").then(|| record.integer("jid"));
        let first = self.body_with(record, "n1");
        let second = self.body_with(record, "n2");
        let start = self.joint_node(record, "n1")?;
        let bodies = [first?, second?];
        self.check_pairs(record, &bodies);
        let mut table = JobTable::new(place)
            .with("kind", record.head, kind)
            .with("bodies", place, bodies.clone().to_vec())
            .with("point", place, start);
        let mut axis = None;
        if has_axis {
            let along = self.direction(record, ["n1", "n3"])?;
            table.put("axis", record.place("n3"), along);
            axis = Some(along);
        }
        if kind == "universal" {
            table.put("second_axis", record.place("n4"), self.direction(record, ["n2", "n4"])?);
        }
        if kind == "screw" {
            table.put("pitch", record.place("parm"), TAU * record.real("parm"));
        }
        let heading = record.word("heading").trim().to_string();
        Some(DeckJoint { id, heading, kind, bodies, axis, table })
    }

    /// Reports nodes of a joint that are not of the body of n1 or n2.
    fn check_pairs(&mut self, record: &CardRecord, bodies: &[String; 2]) {
        let pairs = [("n3", 0), ("n4", 1), ("n5", 0), ("n6", 1)];
        for (field, end) in pairs.into_iter().filter(|(field, _)| record.integer(field) != 0) {
            let found = self.body_with(record, field);
            if found.is_some_and(|body| body != bodies[end]) {
                let message = format!(
                    "{}: node {} is not of the rigid body of n{}",
                    record.name(),
                    record.integer(field),
                    end + 1
                );
                let help = "n1, n3 and n5 are nodes of one body, n2, n4 and n6 of the other";
                self.trouble.error(record.place(field), message, help);
            }
        }
    }

    /// Returns the name of the rigid body of a node. Reports an error if it has none.
    fn body_with(&mut self, record: &CardRecord, field: &str) -> Option<String> {
        let node = record.integer(field);
        let found = id(node).and_then(|node| self.node_bodies.get(&node).cloned());
        if found.is_none() && !self.trouble.is_unsure() {
            let message = format!("{}: node {node} belongs to no rigid body", record.name());
            let help = "name a node of a part with *MAT_RIGID, of *CONSTRAINED_EXTRA_NODES or of \
                        *CONSTRAINED_NODAL_RIGID_BODY";
            self.trouble.error(record.place(field), message, help);
        }
        found
    }

    fn joint_node(&mut self, record: &CardRecord, field: &str) -> Option<[f64; 3]> {
        let node = record.integer(field);
        let at = id(node).and_then(|node| self.rows.at(node));
        if at.is_none() {
            self.missing(record.place(field), "node", node, &[]);
        }
        at
    }

    /// Returns the direction from one node to another one. Reports an error if it has none.
    fn direction(&mut self, record: &CardRecord, fields: [&str; 2]) -> Option<[f64; 3]> {
        let [from, to] = fields.map(|field| self.joint_node(record, field));
        let (from, to) = (from?, to?);
        let found = unit([0, 1, 2].map(|c| to[c] - from[c]));
        if found.is_none() {
            let [a, b] = fields;
            let message = format!("{}: {a} and {b} have the same position", record.name());
            self.trouble.error(record.place(b), message, "name two nodes on the axis of the joint");
        }
        found
    }

    /// Adds a resistance to its joint.
    fn joint_stiffness(
        &mut self,
        record: &CardRecord,
        fields: &StiffnessFields,
        joints: &mut [DeckJoint],
    ) {
        let place = record.place("cida");
        let cida = record.integer("cida");
        let Some(axes) = self.axes.get(&cida).copied() else {
            let known: Vec<String> = self.axes.keys().map(i64::to_string).collect();
            let lost = "the stiffness is left out: nothing resists the joint";
            return self.missing_for(place, ("*DEFINE_COORDINATE_...", cida), &known, lost);
        };
        let cidb = record.integer("cidb");
        let is_same = |other: &[[f64; 3]; 3]| (0..3).all(|k| cosine(&axes[k], &other[k]) > ALIGNED);
        if cidb != 0 && !self.axes.get(&cidb).is_some_and(is_same) {
            let why = "the system of the second body has to have the axes of cida at the start";
            self.unsupported_value(record, "cidb", why);
        }
        let bodies = ["pida", "pidb"].map(|field| {
            let part = record.integer(field);
            let found = self.bodies.get(&part).cloned();
            if found.is_none() && self.has_part(part, record.place(field)) {
                let message = format!("part {part} is not rigid");
                let help = "give it a *MAT_RIGID, or name a part that has one";
                self.trouble.error(record.place(field), message, help);
            }
            found
        });
        let [Some(first), Some(second)] = bodies else { return };
        let jid = record.integer("jid");
        let swapped = |joint: &DeckJoint| joint.bodies == [second.as_str(), first.as_str()];
        let is_meant = |joint: &DeckJoint| {
            let between = joint.bodies == [first.as_str(), second.as_str()] || swapped(joint);
            let is_named = jid == 0 || joint.id == Some(jid);
            fields.kinds.contains(&joint.kind) && between && is_named
        };
        // Axis of the system that is that of the joint.
        let along = |joint: &DeckJoint| {
            let axis = joint.axis.unwrap_or_default();
            (0..3).find(|&k| cosine(&axes[k], &axis).abs() > ALIGNED)
        };
        let fits = |joint: &DeckJoint| is_meant(joint) && along(joint).is_some();
        // Two bodies can have several joints, such as the hinges of a door, each with a stiffness.
        let is_free = |joint: &DeckJoint| fits(joint) && !joint.table.has(fields.key);
        let Some(at) = joints.iter().position(is_free) else {
            if joints.iter().any(fits) {
                let message = format!("{}: this joint has another one", record.name());
                let help = "give each joint one stiffness, with the sums of their curves";
                return self.trouble.error(record.place("pida"), message, help);
            }
            if joints.iter().any(is_meant) {
                let why = "the axis of the joint is no axis of this system";
                return self.unsupported_card(record, "cida", why);
            }
            let message =
                format!("{}: no joint of these bodies has a `{}`", record.name(), fields.key);
            return self.unsupported(record.place("pida"), message, record.name());
        };
        let joint = &mut joints[at];
        let found = along(joint);
        let sign =
            found.map_or(1.0, |k| cosine(&axes[k], &joint.axis.unwrap_or_default()).signum());
        let sign = if swapped(joint) { -sign } else { sign };
        let mut table = None;
        for k in 0..3 {
            if Some(k) == found {
                table = Some(self.resistance(record, fields, k, sign));
                continue;
            }
            let [low, high] = fields.stops[k];
            for field in [fields.curve[k], fields.damping[k], fields.friction[k], low, high] {
                if record.real(field) != 0.0 || record.integer(field) != 0 {
                    self.unsupported_value(record, field, "the joint is not free about this axis");
                }
            }
        }
        if let Some(table) = table {
            joint.table.put(fields.key, place, table);
        }
    }

    /// Returns the resistance along axis `k`; `sign` is -1 if the joint counts the other way.
    fn resistance(
        &mut self,
        record: &CardRecord,
        fields: &StiffnessFields,
        k: usize,
        sign: f64,
    ) -> JobTable {
        let mut table = JobTable::new(record.head);
        let (curve, rates, friction) = (fields.curve[k], fields.damping[k], fields.friction[k]);
        if record.integer(curve) != 0
            && let Some(found) = self.curve(record.integer(curve), record.place(curve))
        {
            let mut points: Vec<Vec<f64>> =
                found.points.iter().map(|p| vec![sign * p[0], sign * p[1]]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            table.put("table", record.place(curve), points);
        }
        if record.integer(rates) != 0
            && let Some(found) = self.curve(record.integer(rates), record.place(rates))
        {
            let moved = found.points.iter().filter(|p| **p != [0.0, 0.0]);
            let slopes: Vec<f64> = moved.map(|p| p[1] / p[0]).collect();
            let first = slopes.first().copied().unwrap_or(0.0);
            if slopes.iter().all(|slope| (slope - first).abs() <= 1e-6 * first.abs()) {
                table.put("damping", record.place(rates), first);
            } else {
                self.unsupported_value(
                    record,
                    rates,
                    "damping has to be a line through the origin",
                );
            }
        }
        // Without this stiffness the format has neither friction nor stops.
        let acts = record.real(fields.stiffness[k]) != 0.0;
        let unused: Vec<&str> = [friction, fields.stops[k][0], fields.stops[k][1]]
            .into_iter()
            .filter(|field| !acts && record.real(field) != 0.0)
            .collect();
        if !unused.is_empty() {
            let of = format!("{}, {}", record.name(), unused.join(" and "));
            let asked = format!("friction or stops with {} = 0", fields.stiffness[k]);
            self.map(of, asked, "none: it is 0, so they are inactive");
            return table;
        }
        match record.real(friction) {
            0.0 => {}
            limit if limit < 0.0 => {
                self.unsupported_value(record, friction, "friction by a curve");
            }
            limit => table.put("friction", record.place(friction), limit),
        }
        let [low, high] = fields.stops[k].map(|field| fields.scale * record.real(field).abs());
        if low != 0.0 || high != 0.0 {
            let or = |stop: f64| if stop == 0.0 { FAR } else { stop };
            let stops = if sign > 0.0 { [-or(low), or(high)] } else { [-or(high), or(low)] };
            table.put("stops", record.place(fields.stops[k][0]), stops);
        }
        table
    }
}

/// Returns the cosine of the angle between two unit vectors.
fn cosine(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}
