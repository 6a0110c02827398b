//! Converts `*RIGIDWALL_...`.

use super::DeckConverter;
use super::names::names;
use super::sets::id;
use super::space::{cross, unit};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::NodeId;
use std::collections::HashSet;

/// Names of the faces of a box, the first one last.
const FACES: [&str; 5] = ["back", "low edge", "high edge", "low side", "high side"];

pub(super) const KEYWORDS: [&str; 5] = [
    "RIGIDWALL_PLANAR",
    "RIGIDWALL_GEOMETRIC_FLAT",
    "RIGIDWALL_GEOMETRIC_PRISM",
    "RIGIDWALL_GEOMETRIC_CYLINDER",
    "RIGIDWALL_GEOMETRIC_SPHERE",
];

impl DeckConverter {
    pub(super) fn walls(&mut self) {
        let records = self.take_in_order(&KEYWORDS);
        let names = names(&records, "wall-", ["heading", "wid"]);
        for ((record, number), name) in records.iter().zip(1..).zip(names) {
            self.wall(record, name, number);
        }
    }

    fn wall(&mut self, record: &CardRecord, name: String, number: usize) {
        let tail = ["xt", "yt", "zt"].map(|c| record.real(c));
        let normal = difference(record, ["xh", "yh", "zh"], tail);
        let friction = record.real("fric");
        if friction == 1.0 {
            self.map(&name, "fric 1: no sliding", "friction 1");
        } else if !(0.0..=1.0).contains(&friction) {
            self.unsupported_value(
                record,
                "fric",
                "codes for sliding; give a coefficient from 0 to 1",
            );
        }
        if record.real("soft") != 0.0 {
            let asked =
                format!("soft {}: nodes are stopped within some cycles", record.real("soft"));
            self.map(&name, asked, "nodes are stopped at once");
        }
        let round = record.line("radcyl").is_some();
        let direction = if round { "axis" } else { "normal" };
        let mut table = JobTable::new(record.head)
            .with("name", record.place("heading"), name.as_str())
            .with("point", record.place("xt"), tail)
            .with("friction", record.place("fric"), friction);
        if record.line("radsph").is_some() {
            table.put("radius", record.place("radsph"), record.real("radsph"));
        } else {
            table.put(direction, record.place("xh"), normal);
        }
        if round {
            table.put("radius", record.place("radcyl"), record.real("radcyl"));
            if record.real("lencyl") > 0.0 {
                table.put("length", record.place("lencyl"), record.real("lencyl"));
                self.map(
                    &name,
                    format!("a cylinder of length {}", record.real("lencyl")),
                    "its ends are open",
                );
            }
        }
        let (birth, death) = (record.real("birth"), record.real("death"));
        if birth != 0.0 {
            table.put("birth", record.place("birth"), birth);
        }
        if death > 0.0 && death < self.end_time {
            table.put("death", record.place("death"), death);
        }
        if record.line("lenl").is_some() {
            table.put(
                "edge",
                record.place("xhev"),
                difference(record, ["xhev", "yhev", "zhev"], tail),
            );
            table.put("lengths", record.place("lenl"), [record.real("lenl"), record.real("lenm")]);
        }
        if record.line("mass").is_some() {
            table.put("mass", record.place("mass"), record.real("mass"));
            table.put("speed", record.place("v0"), record.real("v0"));
        }
        if record.line("lcid").is_some() {
            self.led(record, &name, &mut table);
        }
        // Nodes that show the force of a wall are no part of the model.
        let shown = ["n1", "n2", "n3", "n4"].map(|field| id(record.integer(field)));
        self.rows.stand_ins.extend(shown.into_iter().flatten());
        self.stopped(record, &name, number, (tail, normal), &mut table);
        if record.line("lenp").is_some() {
            self.box_faces(record, &name, &table);
        }
        self.add("wall", table);
    }

    /// Adds the faces of a box behind its first face.
    fn box_faces(&mut self, record: &CardRecord, name: &str, first: &JobTable) {
        let tail = ["xt", "yt", "zt"].map(|c| record.real(c));
        let lengths = ["lenl", "lenm", "lenp"].map(|c| record.real(c));
        let normal = unit(difference(record, ["xh", "yh", "zh"], tail));
        let edge = difference(record, ["xhev", "yhev", "zhev"], tail);
        let across = normal.and_then(|n| unit(cross(n, edge)));
        let (Some(n), Some(m)) = (normal, across) else {
            let help = "give a head off the tail, and an edge off the normal";
            return self.trouble.error(record.place("xh"), format!("{name} has no sides"), help);
        };
        if lengths.iter().any(|length| *length <= 0.0) {
            return self.unsupported_card(record, "lenp", "give all three lengths of the box");
        }
        let l = cross(m, n);
        let [long, wide, deep] = lengths;
        let back = |v: [f64; 3]| v.map(|c| -c);
        let at = |way: [f64; 3], by: f64| [0, 1, 2].map(|c| tail[c] + by * way[c]);
        let faces = [
            (at(n, -deep), back(n), m, [wide, long]),
            (tail, back(l), m, [wide, deep]),
            (at(l, long), l, back(n), [deep, wide]),
            (tail, back(m), back(n), [deep, long]),
            (at(m, wide), m, l, [long, deep]),
        ];
        for (face, (point, normal, edge, sizes)) in FACES.iter().zip(faces) {
            let place = record.place("lenp");
            let table = first
                .copy()
                .with("name", record.place("heading"), format!("{name} {face}"))
                .with("point", place, point)
                .with("normal", place, normal)
                .with("edge", place, edge)
                .with("lengths", place, sizes);
            self.add("wall", table);
        }
        self.map(name, "a box", "six rectangles, each with its forces");
    }

    /// Converts the prescribed motion of a wall.
    fn led(&mut self, record: &CardRecord, name: &str, table: &mut JobTable) {
        let way = ["vx", "vy", "vz"].map(|c| record.real(c));
        let length = way.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 {
            let help = "give vx, vy and vz, the direction cosines of its motion";
            return self.trouble.error(
                record.place("vx"),
                format!("{name} has no direction of motion"),
                help,
            );
        }
        let Some(curve) = self.time_curve(record.integer("lcid"), record.place("lcid")) else {
            return;
        };
        let form = match record.integer("opt") {
            0 => "velocity",
            1 => "displacement",
            _ => {
                return self.unsupported_card(
                    record,
                    "opt",
                    "give 0 for velocities or 1 for displacements",
                );
            }
        };
        // Direction cosines have few digits in fixed columns, so they are used as a direction,
        // not as a factor.
        table.put(form, record.place("vx"), way.map(|c| c / length));
        table.put("curve", record.place("lcid"), curve);
        if (length - 1.0).abs() > 1e-3 {
            self.map(name, format!("a direction of motion of length {length}"), "a unit vector");
        }
    }

    /// Converts the nodes that the wall stops: all nodes, if the deck selects none.
    fn stopped(
        &mut self,
        record: &CardRecord,
        name: &str,
        number: usize,
        (tail, normal): ([f64; 3], [f64; 3]),
        table: &mut JobTable,
    ) {
        let (nsid, boxid, offset) =
            (record.integer("nsid"), record.integer("boxid"), record.real("offset"));
        let set = if nsid == 0 { None } else { self.node_set(nsid, record.place("nsid")) };
        if boxid != 0 || offset != 0.0 {
            let field = if boxid != 0 { "boxid" } else { "offset" };
            let mut nodes: Vec<NodeId> = match (&set, boxid) {
                (Some(_), _) => self.node_sets[&nsid].0.clone(),
                (None, 0) => self.rows.nodes_of(|_| true),
                (None, _) => self.in_box(boxid, record.place("boxid")),
            };
            if set.is_some() && boxid != 0 {
                let inside: HashSet<NodeId> =
                    self.in_box(boxid, record.place("boxid")).into_iter().collect();
                nodes.retain(|n| inside.contains(n));
            }
            if offset != 0.0 {
                let size = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
                let away = |x: [f64; 3]| {
                    (0..3).map(|c| normal[c] * (x[c] - tail[c])).sum::<f64>().abs() / size
                };
                nodes.retain(|&n| self.rows.at(n).is_some_and(|x| away(x) <= offset));
            }
            let chosen = format!("wall-{number}-nodes");
            let asked = format!("stops nodes by nsid {nsid}, boxid {boxid}, offset {offset:?}");
            self.map(name, asked, format!("the {} nodes of {chosen}", nodes.len()));
            nodes.sort_unstable();
            self.rows.add_set(chosen.clone(), nodes, record.place(field));
            table.put("nodes", record.place(field), chosen);
        } else if let Some(set) = set {
            table.put("nodes", record.place("nsid"), set);
        }
        let nsidex = record.integer("nsidex");
        if nsidex != 0
            && let Some(set) = self.node_set(nsidex, record.place("nsidex"))
        {
            table.put("except", record.place("nsidex"), set);
        }
    }
}

/// Returns the vector from tail to head.
fn difference(record: &CardRecord, head: [&str; 3], tail: [f64; 3]) -> [f64; 3] {
    let head = head.map(|c| record.real(c));
    [0, 1, 2].map(|c| head[c] - tail[c])
}
