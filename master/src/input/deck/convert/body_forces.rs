//! Converts `*LOAD_RIGID_BODY`: forces at the centres of rigid bodies, and moments about them.

use super::DeckConverter;
use super::space::{cross, unit};
use super::stops::BodyEntries;
use super::tree::JobTable;
use crate::input::deck::record::CardLine;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;

const KEYWORD: &str = "LOAD_RIGID_BODY";
/// Consequence of a load that is left out.
const LOST: &str = "the load is left out: it does not act on the body";

/// Nodes whose plane a load follows: they have to be members of its body.
pub struct Follower {
    pid: i64,
    nodes: [NodeId; 3],
    place: Place,
}

impl DeckConverter {
    /// Reads all loads of rigid bodies, and the nodes that some of them follow.
    pub(super) fn body_forces(&mut self) -> (BodyEntries, Vec<Follower>) {
        let (mut all, mut followers) = (BodyEntries::new("load"), Vec::new());
        for record in self.take_records(KEYWORD) {
            let lines: Vec<CardLine> = record.lines("pid").cloned().collect();
            for line in &lines {
                if let Some(table) = self.body_force(line, &mut followers) {
                    all.add(line.integer("pid"), line.place("pid"), vec![table]);
                }
            }
        }
        (all, followers)
    }

    fn body_force(&mut self, line: &CardLine, followers: &mut Vec<Follower>) -> Option<JobTable> {
        let (pid, dof, place) = (line.integer("pid"), line.integer("dof"), line.place("dof"));
        let axis = |first: i64| [0, 1, 2].map(|c| if c == dof - first { 1.0 } else { 0.0 });
        let (key, direction) = match dof {
            1..=3 => ("force", self.in_global_axes(axis(1), line, "cid", LOST)?),
            5..=7 => ("moment", self.in_global_axes(axis(5), line, "cid", LOST)?),
            4 => ("force", self.normal(line, followers)?),
            8 => ("moment", self.normal(line, followers)?),
            _ => {
                let message = format!("*{KEYWORD}: `dof` is {dof}");
                let help = "give 1 to 3 for a force, 5 to 7 for a moment, 4 or 8 for one that \
                            follows the body";
                self.trouble.error(place, message, help);
                return None;
            }
        };
        let at = line.place("lcid");
        let curve = self.time_curve(line.integer("lcid"), at)?;
        let scale = line.real("sf");
        let mut table = JobTable::new(line.place)
            .with(key, place, direction.map(|c| scale * c))
            .with("curve", at, curve);
        if matches!(dof, 4 | 8) {
            table.put("follows", place, true);
            self.map(
                format!("*{KEYWORD} {pid}"),
                format!("dof {dof}"),
                format!("a {key} along the normal m1m2 x m1m3, which turns with the body"),
            );
        }
        Some(table)
    }

    /// Returns the normal of the plane of three nodes at the start, which belong to the body.
    fn normal(&mut self, line: &CardLine, followers: &mut Vec<Follower>) -> Option<[f64; 3]> {
        let mut points = [[0.0; 3]; 3];
        let mut nodes = [NodeId(0); 3];
        for (k, field) in ["m1", "m2", "m3"].into_iter().enumerate() {
            let id = line.integer(field);
            nodes[k] = NodeId(u64::try_from(id).unwrap_or(0));
            match self.rows.at(nodes[k]) {
                Some(x) => points[k] = x,
                None => {
                    self.missing(line.place(field), "node", id, &[]);
                    return None;
                }
            }
        }
        let place = line.place("m1");
        let from = |k: usize| [0, 1, 2].map(|c| points[k][c] - points[0][c]);
        let normal = unit(cross(from(1), from(2)));
        if normal.is_none() {
            let message = format!("*{KEYWORD}: m1, m2 and m3 are on one line");
            self.trouble.error(place, message, "give three nodes of the body off one line");
        }
        followers.push(Follower { pid: line.integer("pid"), nodes, place });
        normal
    }

    /// Reports loads that follow nodes of another part than their body.
    pub(super) fn check_followers(&mut self, followers: &[Follower]) {
        for Follower { pid, nodes, place } in followers {
            let Some(body) = self.bodies.get(pid) else { continue };
            let is_other = |node: &&NodeId| self.node_bodies.get(node) != Some(body);
            if let Some(other) = nodes.iter().find(is_other) {
                let message = format!(
                    "*{KEYWORD}: node {other} is no node of the body of part {pid}, and a load \
                     turns with its own body only"
                );
                self.unsupported(*place, message, format!("*{KEYWORD} m1"));
            }
        }
    }
}
