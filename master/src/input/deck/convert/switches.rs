//! Converts `*DEFORMABLE_TO_RIGID_AUTOMATIC`: parts that become rigid, and deformable again, at
//! given times.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, HashMap};

/// Switch of a part.
#[derive(Clone, Copy)]
struct Switch {
    part: i64,
    time: f64,
    /// True if the part becomes rigid.
    to_rigid: bool,
    /// Part whose body it joins, or 0.
    lead: i64,
    place: Place,
}

/// Parts that are rigid together.
struct RigidSpan {
    parts: Vec<i64>,
    from: f64,
    until: f64,
    place: Place,
}

impl DeckConverter {
    pub(super) fn switches(&mut self) {
        let mut switches: BTreeMap<i64, Vec<Switch>> = BTreeMap::new();
        for record in self.take_records("DEFORMABLE_TO_RIGID_AUTOMATIC") {
            for switch in self.switches_of(&record) {
                switches.entry(switch.part).or_default().push(switch);
            }
        }
        let mut spans: Vec<(Switch, f64)> = Vec::new();
        for list in switches.values_mut() {
            list.sort_by(|a, b| a.time.total_cmp(&b.time));
            self.spans_of_part(list, &mut spans);
        }
        // Parts that switch at the same times may be one body.
        spans.sort_by(|a, b| {
            let by_time = a.0.time.total_cmp(&b.0.time).then(a.1.total_cmp(&b.1));
            by_time.then(a.0.part.cmp(&b.0.part))
        });
        let groups = spans.chunk_by(|a, b| (a.0.time, a.1) == (b.0.time, b.1));
        let groups: Vec<Vec<(Switch, f64)>> = groups.map(<[_]>::to_vec).collect();
        for group in groups {
            for span in self.joined(&group) {
                self.add_span(&span);
            }
        }
    }

    /// Returns the switches of one card.
    fn switches_of(&mut self, record: &CardRecord) -> Vec<Switch> {
        if record.integer("code") != 0 {
            self.unsupported_card(
                record,
                "code",
                "give code 0 and the time of the switch as time1: conditions of forces do not act",
            );
            return Vec::new();
        }
        let time = record.real("time1");
        let mut found = Vec::new();
        for (field, kind, to_rigid, count) in
            [("rpid", "ptype", true, "d2r"), ("dpid", "dptype", false, "r2d")]
        {
            let lines: Vec<CardLine> = record.lines(field).cloned().collect();
            if record.integer(count) != lines.len() as i64 {
                let message = format!(
                    "{}: `{count}` is {}, but {} such lines follow",
                    record.name(),
                    record.integer(count),
                    lines.len()
                );
                let help = "give a line for each part, those of d2r first";
                self.trouble.error(record.place(count), message, help);
            }
            for line in lines {
                let (id, place) = (line.integer(field), line.place(field));
                let parts = match line.word(kind).to_ascii_uppercase().as_str() {
                    "PSET" => self.part_set(id, place),
                    _ if self.has_part(id, place) => vec![id],
                    _ => Vec::new(),
                };
                let lead = if to_rigid { line.integer("lrb") } else { 0 };
                found.extend(parts.into_iter().map(|part| Switch {
                    part,
                    time,
                    to_rigid,
                    lead,
                    place,
                }));
            }
        }
        found
    }

    /// Adds the times in which a part is rigid; its switches are in ascending time.
    fn spans_of_part(&mut self, switches: &[Switch], spans: &mut Vec<(Switch, f64)>) {
        let mut begun: Option<Switch> = None;
        let is_rigid = self.bodies.contains_key(&switches[0].part);
        for switch in switches {
            let part = switch.part;
            if is_rigid {
                let message = format!("part {part} is rigid in the whole run and switches");
                let help = "give it a material that deforms, and no *DEFORMABLE_TO_RIGID";
                return self.trouble.error(switch.place, message, help);
            }
            match (switch.to_rigid, begun) {
                (true, None) => begun = Some(*switch),
                (false, Some(first)) => {
                    spans.push((first, switch.time));
                    begun = None;
                }
                (true, Some(_)) | (false, None) => {
                    let now = if switch.to_rigid { "rigid" } else { "deformable" };
                    self.map(
                        format!("part {part}"),
                        format!("a switch at {} to {now}", switch.time),
                        "none: it is so already",
                    );
                }
            }
        }
        spans.extend(begun.map(|first| (first, f64::INFINITY)));
    }

    /// Joins parts with common nodes, or with the same lead, to one body.
    fn joined(&mut self, group: &[(Switch, f64)]) -> Vec<RigidSpan> {
        let index: HashMap<i64, usize> =
            group.iter().enumerate().map(|(k, (switch, _))| (switch.part, k)).collect();
        let mut root: Vec<usize> = (0..group.len()).collect();
        let mut owner: HashMap<NodeId, usize> = HashMap::new();
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for element in self.rows.elements() {
            let Some(&k) = index.get(&i64::from(element.part)) else { continue };
            for &node in element.corners() {
                pairs.push((*owner.entry(node).or_insert(k), k));
            }
        }
        for (k, (switch, _)) in group.iter().enumerate().filter(|(_, (s, _))| s.lead != 0) {
            match index.get(&switch.lead) {
                Some(&lead) => pairs.push((lead, k)),
                None => {
                    let message = format!(
                        "part {} becomes rigid with part {}, which does not switch at that time",
                        switch.part, switch.lead
                    );
                    let what = "*DEFORMABLE_TO_RIGID_AUTOMATIC lrb".to_string();
                    self.unsupported(switch.place, message, what);
                }
            }
        }
        for (a, b) in pairs {
            let (low, high) = (root[a].min(root[b]), root[a].max(root[b]));
            root.iter_mut().filter(|r| **r == high).for_each(|r| *r = low);
        }
        let mut spans: BTreeMap<usize, RigidSpan> = BTreeMap::new();
        for (k, &(switch, until)) in group.iter().enumerate() {
            let span = spans.entry(root[k]).or_insert_with(|| RigidSpan {
                parts: Vec::new(),
                from: switch.time,
                until,
                place: switch.place,
            });
            span.parts.push(switch.part);
        }
        spans.into_values().collect()
    }

    fn add_span(&mut self, span: &RigidSpan) {
        let &RigidSpan { ref parts, from, until, place } = span;
        let list: Vec<String> = parts.iter().map(i64::to_string).collect();
        let name = format!("rigid-{}-from-{from}", list.join("-"));
        let mut table = JobTable::new(place)
            .with("name", place, name)
            .with("parts", place, parts.clone())
            .with("from", place, from);
        let mut used = format!("rigid from {from}");
        if until.is_finite() {
            table.put("until", place, until);
            used += &format!(" until {until}, the elements compute forces all the time");
        }
        self.map(format!("parts {}", list.join(", ")), "switched to rigid", used);
        self.add("rigid", table);
    }
}
