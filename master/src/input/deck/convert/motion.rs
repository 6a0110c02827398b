//! Converts fixed degrees of freedom and prescribed motions.

use super::DeckConverter;
use super::materials::held;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::BTreeMap;

const DOFS: [(&str, &str); 6] = [
    ("dofx", "x"),
    ("dofy", "y"),
    ("dofz", "z"),
    ("dofrx", "rx"),
    ("dofry", "ry"),
    ("dofrz", "rz"),
];

impl DeckConverter {
    /// Converts `*BOUNDARY_SPC_...`, and the constraint codes on the cards of nodes.
    pub(super) fn spc(&mut self) {
        for record in self.take_records("BOUNDARY_SPC_SET") {
            let dofs = self.dofs(&record);
            if let Some(set) = self.node_set(record.integer("nsid"), record.place("nsid")) {
                self.fix(set, dofs, record.place("nsid"));
            }
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

    fn fix_nodes(
        &mut self,
        kind: &str,
        dofs: Vec<&'static str>,
        mut nodes: Vec<NodeId>,
        place: Place,
    ) {
        nodes.sort_unstable();
        nodes.dedup();
        let name = format!("{kind}-{}", dofs.join("-"));
        self.rows.add_set(name.clone(), nodes, place);
        self.fix(name, dofs, place);
    }

    fn fix(&mut self, set: String, dofs: Vec<&'static str>, place: Place) {
        if !dofs.is_empty() {
            self.add(
                "fix",
                JobTable::new(place).with("nodes", place, set).with("dofs", place, dofs),
            );
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

    fn motion(&mut self, record: &CardRecord, key: &str, of: String, place: Place) {
        let (dof, vad) = (record.integer("dof"), record.integer("vad"));
        for (field, plain) in [("death", 1e28), ("birth", 0.0)] {
            let given = record.real(field);
            if given != plain && !(field == "death" && (given == 0.0 || given >= self.end_time)) {
                self.unsupported_value(record, field, "motion that begins or ends within the run");
            }
        }
        let (axis, rotation) = match dof {
            1..=3 => (dof as usize - 1, false),
            5..=7 => (dof as usize - 5, true),
            _ => {
                return self.unsupported_value(
                    record,
                    "dof",
                    "use x, y, z (1, 2, 3), or rotations about them (5, 6, 7)",
                );
            }
        };
        let form = match (vad, rotation) {
            (0, false) => "velocity",
            (1, false) => "acceleration",
            (2, false) => "displacement",
            (0, true) => "spin",
            _ => {
                return self.unsupported_value(
                    record,
                    "vad",
                    "use velocity (0), or for translations acceleration (1) or displacement (2)",
                );
            }
        };
        let Some(curve) = self.time_curve(record.integer("lcid"), record.place("lcid")) else {
            return;
        };
        let mut amount = [0.0; 3];
        amount[axis] = if record.real("sf") == 0.0 { 1.0 } else { record.real("sf") };
        let dofs = if rotation { ["rx", "ry", "rz"] } else { ["x", "y", "z"] };
        let table = JobTable::new(record.head)
            .with(key, place, of)
            .with("dofs", record.place("dof"), vec![dofs[axis]])
            .with(form, record.place("vad"), amount)
            .with("curve", record.place("lcid"), curve);
        self.add("motion", table);
    }
}
