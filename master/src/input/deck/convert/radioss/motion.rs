//! Converts prescribed motion and initial velocities.

use super::StarterConverter;
use crate::input::deck::convert::initial::LOST;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;

/// Time from which on a limit is none.
const NEVER: f64 = 1e20;
const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
const DIRECTIONS: [&str; 6] = ["X", "Y", "Z", "XX", "YY", "ZZ"];

/// The motion of a group: which value, along which axis, with which curve.
pub struct StarterMotion {
    /// Key in the job.
    pub form: &'static str,
    /// Number of the degree of freedom, from 0 to 5.
    pub dof: usize,
    /// Value for the factor 1.
    pub amount: f64,
    /// Name of the curve.
    pub curve: String,
    /// Place of the card.
    pub place: Place,
}

impl StarterConverter {
    /// Converts motions; those of nodes of walls are kept for the walls.
    pub(super) fn motions(&mut self) {
        for record in self.take(&["/IMPVEL", "/IMPDISP", "/IMPACC"]) {
            let Some(line) = record.line("fct").cloned() else { continue };
            let (grnod, place) = (record.integer("grnod"), record.place("grnod"));
            self.only_plain(&record);
            if !self.acts(&record) {
                continue;
            }
            let Some(motion) = self.motion(&record, &line) else { continue };
            let Some(set) = self.deck.node_set(grnod, place) else { continue };
            let mut all = self.deck.node_sets[&grnod].0.clone();
            let count = all.len();
            self.without_inner_mains(&record, &mut all, false);
            let mut others = Vec::with_capacity(all.len());
            for node in &all {
                if self.wall_nodes.contains(node) {
                    let form = motion.form;
                    let copy = StarterMotion { curve: motion.curve.clone(), form, ..motion };
                    self.wall_motions.entry(*node).or_default().push(copy);
                } else if let Some(body) = self.mains.get(node) {
                    let (body, keeps_main) = (body.name.clone(), body.keeps_main);
                    if keeps_main {
                        let message = format!(
                            "{}/{}: it moves the centre of {body}, not its main node",
                            record.name(),
                            record.integer("id")
                        );
                        let help = "with icog 3 or 4 the main node is the centre of the body: move \
                                    it to the centre of its nodes, if the body turns";
                        self.deck.trouble.warning(place, message, help);
                    }
                    self.put_motion("rigid", body, &motion);
                } else {
                    others.push(*node);
                }
            }
            if others.len() == count {
                self.put_motion("nodes", set, &motion);
            } else if !others.is_empty() {
                let name = format!("motion-{}", record.integer("id"));
                let name = self.deck.rows.add_new_set(&name, others, place);
                self.put_motion("nodes", name, &motion);
            }
        }
    }

    fn motion(&mut self, record: &CardRecord, line: &CardLine) -> Option<StarterMotion> {
        let word = line.word("dir").to_ascii_uppercase();
        let Some(dof) = DIRECTIONS.iter().position(|d| *d == word) else {
            let message = format!("{}: `dir` has to be a direction, not `{word}`", record.name());
            let help = "give X, Y or Z, or XX, YY or ZZ for a rotation, in the columns 11 to 20";
            self.deck.trouble.error(line.place("dir"), message, help);
            return None;
        };
        let form = match (record.row.keyword.name, dof >= 3) {
            ("/IMPVEL", false) => "velocity",
            ("/IMPVEL", true) => "spin",
            ("/IMPDISP", false) => "displacement",
            ("/IMPACC", false) => "acceleration",
            _ => {
                let message = format!("{}: rotations are not supported", record.name());
                let what = format!("{} {word}", record.name());
                self.deck.unsupported(line.place("dir"), message, what);
                return None;
            }
        };
        let amount = or_one(record.real("fscale"));
        if line.integer("fct") == 0 && record.row.keyword.name != "/IMPVEL" {
            self.deck.missing(line.place("fct"), "/FUNCT", 0, &[]);
            return None;
        }
        let curve = self.time_function(line, or_one(record.real("ascale")))?;
        Some(StarterMotion { form, dof, amount, curve, place: record.head })
    }

    /// Returns false for a motion that begins after the end of the run. Reports one that begins or
    /// ends within it.
    fn acts(&mut self, record: &CardRecord) -> bool {
        let (start, stop, end) = (record.real("tstart"), record.real("tstop"), self.deck.end_time);
        // Without an engine file the end is that of a job, which is not known here.
        if start > 0.0 && end > 0.0 && start >= end {
            let name = format!("{}/{}", record.name(), record.integer("id"));
            let asked = format!("tstart {start}, not before the end of the run");
            self.deck.map(name, asked, "no motion");
            return false;
        }
        let why = "motion that begins or ends within the run";
        if start > 0.0 {
            self.deck.unsupported_value(record, "tstart", why);
        }
        if stop > 0.0 && stop < NEVER && (end <= 0.0 || stop < end) {
            self.deck.unsupported_value(record, "tstop", why);
        }
        true
    }

    fn put_motion(&mut self, key: &str, of: String, motion: &StarterMotion) {
        let &StarterMotion { form, dof, amount, place, .. } = motion;
        let mut value = [0.0; 3];
        value[dof % 3] = amount;
        if form == "spin" && key == "nodes" {
            let message = "rotations of single nodes are not supported".to_string();
            return self.deck.unsupported(place, message, "/IMPVEL of rotations".into());
        }
        let table = JobTable::new(place)
            .with(key, place, of)
            .with("dofs", place, vec![DOFS[dof]])
            .with(form, place, value)
            .with("curve", place, motion.curve.as_str());
        self.deck.add("motion", table);
    }

    pub(super) fn initial_velocities(&mut self) {
        for record in self.take(&["/INIVEL/TRA", "/INIVEL/ROT", "/INIVEL/AXIS"]) {
            let name = record.row.keyword.name;
            let (grnod, place) = (record.integer("grnod"), record.place("grnod"));
            let Some(line) = record.line("grnod").cloned() else { continue };
            let (v, spin) = match name {
                "/INIVEL/AXIS" => {
                    let v = ["vxt", "vyt", "vzt"].map(|field| record.real(field));
                    let word = record.word("dir").to_ascii_uppercase();
                    let Some(axis) = DIRECTIONS[..3].iter().position(|d| *d == word) else {
                        let message = format!("{name}: `dir` has to be an axis, not `{word}`");
                        let place = record.place("dir");
                        self.deck.trouble.error(place, message, "give X, Y or Z");
                        continue;
                    };
                    let mut spin = [0.0; 3];
                    spin[axis] = record.real("vr");
                    (v, spin)
                }
                _ => {
                    let v = ["vx", "vy", "vz"].map(|field| line.real(field));
                    let Some(v) = self.deck.in_global_axes(v, &line, "skew", LOST) else {
                        continue;
                    };
                    if name == "/INIVEL/ROT" { ([0.0; 3], v) } else { (v, [0.0; 3]) }
                }
            };
            if grnod == 0 {
                let message = format!("{name}: no group is given");
                let help = "give the id of a group of nodes; one of all nodes has the main nodes \
                            of bodies too";
                self.deck.trouble.error(place, message, help);
                continue;
            }
            let Some(mut set) = self.deck.node_set(grnod, place) else { continue };
            let mut all = self.deck.node_sets[&grnod].0.clone();
            self.warn_of_walls(&record, &all);
            let count = all.len();
            self.without_inner_mains(&record, &mut all, true);
            all.retain(|node| !self.wall_nodes.contains(node));
            if all.len() < count {
                if all.is_empty() {
                    continue;
                }
                set = self.deck.rows.add_new_set(&format!("{set} moved"), all.clone(), place);
            }
            self.velocity_of_group(&record, (set, all), (v, spin));
        }
        self.join_velocities();
    }

    /// Gives a velocity to the nodes of a group. That of a main node holds for its body.
    fn velocity_of_group(
        &mut self,
        record: &CardRecord,
        (set, all): (String, Vec<NodeId>),
        (v, spin): ([f64; 3], [f64; 3]),
    ) {
        let place = record.place("grnod");
        let is_main = |node: &&NodeId| self.mains.contains_key(node);
        let mains: Vec<NodeId> = all.iter().filter(is_main).copied().collect();
        for (main, body) in &self.mains {
            let moves = all.binary_search(main).is_ok();
            if moves || all.iter().any(|n| body.nodes.contains(n)) {
                self.moved.entry(*main).or_insert((false, place)).0 |= moves;
            }
        }
        let rotates = record.row.keyword.name == "/INIVEL/ROT";
        let rest: Vec<NodeId> = all.iter().filter(|n| !mains.contains(n)).copied().collect();
        if rotates && !rest.is_empty() {
            let message = "/INIVEL/ROT: spins of single nodes are not supported".to_string();
            self.deck.unsupported(record.head, message, "/INIVEL/ROT of nodes".into());
        } else if mains.is_empty() {
            self.put_velocity(place, Some(set), (v, spin), [0.0; 3]);
        } else if !rest.is_empty() {
            let name = format!("velocity-{}", record.integer("id"));
            let name = self.deck.rows.add_new_set(&name, rest, place);
            self.put_velocity(place, Some(name), (v, spin), [0.0; 3]);
        }
        for main in mains {
            let Some(body) = self.mains.get(&main) else { continue };
            let (known, nodes) = (body.set.clone(), body.nodes.clone());
            let centre = match rotates {
                true => self.deck.rows.at(main).unwrap_or_default(),
                false => [0.0; 3],
            };
            let name = known.unwrap_or_else(|| {
                let name = format!("{} all nodes", body.name);
                self.deck.rows.add_new_set(&name, nodes.into_iter().collect(), place)
            });
            if let Some(body) = self.mains.get_mut(&main) {
                body.set = Some(name.clone());
            }
            self.put_velocity(place, Some(name), (v, spin), centre);
        }
    }

    /// Notes an initial velocity. [`StarterConverter::join_velocities`] adds it to the job.
    fn put_velocity(
        &mut self,
        place: Place,
        nodes: Option<String>,
        (v, spin): ([f64; 3], [f64; 3]),
        centre: [f64; 3],
    ) {
        let completes = |known: &&mut StarterVelocity| {
            let (turns, moves) = (spin != [0.0; 3], v != [0.0; 3]);
            let is_other = match turns {
                true => known.spin == [0.0; 3] && !moves,
                false => known.velocity == [0.0; 3] && known.spin != [0.0; 3],
            };
            known.nodes == nodes && nodes.is_some() && is_other
        };
        let same = self.velocities.iter_mut().find(completes);
        match same {
            // A translation and a rotation of one body, on two cards.
            Some(known) => {
                known.velocity = [0, 1, 2].map(|c| known.velocity[c] + v[c]);
                known.spin = [0, 1, 2].map(|c| known.spin[c] + spin[c]);
                if spin != [0.0; 3] {
                    known.centre = centre;
                }
            }
            None => {
                let own = StarterVelocity { nodes, velocity: v, spin, centre, place };
                self.velocities.push(own);
            }
        }
    }

    fn join_velocities(&mut self) {
        for (main, (_, place)) in self.moved.iter().filter(|(_, (by_main, _))| !by_main) {
            let Some(body) = self.mains.get(main) else { continue };
            let message = format!(
                "nodes of the body {} have an initial velocity, its main node {} has none",
                body.name,
                main.label()
            );
            let help = "Radioss gives a body the velocity of its main node, here it has that of \
                        its nodes: add the main node to the group";
            self.deck.trouble.warning(*place, message, help);
        }
        for known in std::mem::take(&mut self.velocities) {
            let place = known.place;
            let mut table = JobTable::new(place);
            if let Some(set) = known.nodes {
                table.put("nodes", place, set);
            }
            table.put("velocity", place, known.velocity);
            if known.spin != [0.0; 3] {
                table.put("spin", place, known.spin);
                table.put("centre", place, known.centre);
            }
            self.deck.add("initial_velocity", table);
        }
    }
}

/// An initial velocity of a group.
pub struct StarterVelocity {
    nodes: Option<String>,
    velocity: [f64; 3],
    spin: [f64; 3],
    centre: [f64; 3],
    place: Place,
}

/// Returns a scale, or 1 for zero.
pub fn or_one(scale: f64) -> f64 {
    if scale == 0.0 { 1.0 } else { scale }
}
