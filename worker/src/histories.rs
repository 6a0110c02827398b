//! What a worker records at every history interval beside sums: its parts' energies, contact between parts, nodes and
//! sections. Read off the state when a row is due; nothing of it is felt by the state, and no step computes any of it.

use crate::blocks::Blocks;
use crate::engine::Engine;
use crate::nodes::{Nodes, Row, xyz};
use crumple_proto::histories::{Asked, NodeState, PartShare, Section, SectionShare, Shares};
use nalgebra::Vector3;
use std::collections::HashMap;

type V3 = Vector3<f64>;

/// Where on this worker is what histories ask for.
#[derive(Debug, Default)]
pub struct Histories {
    /// Owned nodes of all groups, ascending.
    nodes: Vec<u32>,
    sections: Vec<LocalSection>,
}

/// What a worker has of a section.
#[derive(Debug, Default)]
struct LocalSection {
    /// Corner slots of own elements at the section's nodes, and these nodes.
    corners: Vec<(usize, u32)>,
    /// Owned nodes.
    nodes: Vec<u32>,
}

impl Histories {
    /// Finds what is asked for among the nodes and elements that are here.
    pub fn settle(&mut self, asked: &Asked, nodes: &Nodes, blocks: &Blocks) {
        let own = |ids: &[crumple_proto::ids::NodeId]| -> Vec<u32> {
            let held = ids.iter().filter_map(|&id| nodes.held_number(id));
            held.filter(|&n| nodes.is_own(n as usize)).collect()
        };
        self.nodes = asked.nodes.iter().flat_map(|group| own(&group.nodes)).collect();
        self.nodes.sort_unstable();
        self.nodes.dedup();
        self.sections.clear();
        if asked.sections.is_empty() {
            return;
        }
        let slots = blocks.first_slots();
        let place: HashMap<_, usize> = blocks.elements.iter().enumerate().map(|(i, e)| (e.record.id, i)).collect();
        let local = |section: &Section| {
            let mut corners = Vec::new();
            for &i in section.elements.iter().filter_map(|id| place.get(id)) {
                let e = &blocks.elements[i];
                let at =
                    (0..e.record.shape.corners()).filter(|&c| section.nodes.binary_search(&e.record.nodes[c]).is_ok());
                corners.extend(at.map(|c| (slots[i] + c, e.nodes[c])));
            }
            LocalSection { corners, nodes: own(&section.nodes) }
        };
        self.sections = asked.sections.iter().map(local).collect();
    }

    /// This worker's shares of a row. Velocities are those before and after the present time or, when the run has `ended`,
    /// those of the last two mid-steps; forces are then those of the last step.
    pub fn shares(&self, engine: &Engine, ended: bool) -> Shares {
        let asked = &engine.settings.histories;
        Shares {
            parts: if asked.parts { parts(engine, ended) } else { Vec::new() },
            contacts: match &engine.contact {
                Some(contact) if asked.contacts => contact.forces_between_parts(),
                _ => Vec::new(),
            },
            nodes: self.nodes.iter().map(|&n| node(engine, n as usize, ended)).collect(),
            sections: self.sections(engine),
            transducers: match &engine.contact {
                Some(contact) if !asked.transducers.is_empty() => {
                    contact.forces_on_transducers(&asked.transducers, &engine.nodes)
                }
                _ => Vec::new(),
            },
        }
    }

    fn sections(&self, engine: &Engine) -> Vec<SectionShare> {
        if self.sections.is_empty() {
            return Vec::new();
        }
        // Pressure lies in the slots too, and is no force of the element.
        let mut pressed: HashMap<usize, V3> = HashMap::new();
        for (slot, f) in engine.loads.on_slots() {
            *pressed.entry(slot).or_default() += V3::from(xyz(f));
        }
        let at = |n: u32| V3::from(xyz(&engine.nodes.x[n as usize]));
        let share = |section: &LocalSection| {
            let (mut force, mut moment) = (V3::zeros(), V3::zeros());
            for &(slot, n) in &section.corners {
                let pressed = pressed.get(&slot).copied().unwrap_or_default();
                let f = -V3::from(xyz(&engine.blocks.force[slot])) - pressed;
                force += f;
                moment += at(n).cross(&f);
                if let Some(m) = engine.blocks.moment.get(slot) {
                    moment -= V3::from(xyz(m));
                }
            }
            let places = section.nodes.iter().map(|&n| at(n)).sum::<V3>();
            let nodes = section.nodes.len() as u64;
            SectionShare { force: force.into(), moment: moment.into(), places: places.into(), nodes }
        };
        self.sections.iter().map(share).collect()
    }
}

/// What the own elements of each part have. A node's mass is that of the corners at it; what `[[mass]]` adds is in no part.
fn parts(engine: &Engine, ended: bool) -> Vec<PartShare> {
    let (nodes, blocks) = (&engine.nodes, &engine.blocks);
    let share = |energy: &[f64; 2]| PartShare { internal: energy[0], hourglass: energy[1], ..PartShare::default() };
    let mut parts: Vec<PartShare> = blocks.by_part.iter().map(share).collect();
    let dot = |a: &Row, b: &Row| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for b in &blocks.blocks {
        for e in &blocks.elements[b.first..b.first + b.count] {
            let part = &mut parts[e.record.part as usize];
            let (mass, inertia) = b.element.corner_mass(&e.nodes.map(|n| xyz(&nodes.x0[n as usize])));
            let (mass, inertia) = (mass * e.record.mass_factor, inertia * e.record.mass_factor);
            for n in e.nodes[..e.record.shape.corners()].iter().map(|&n| n as usize) {
                let (v, next) = (&nodes.v[n], &nodes.next_v[n]);
                let turning = if nodes.rotations { inertia * dot(&nodes.w[n], &nodes.next_w[n]) } else { 0.0 };
                part.mass += mass;
                part.kinetic += 0.5 * (mass * dot(v, next) + turning);
                let at = |c: usize| if ended { v[c] } else { 0.5 * (v[c] + next[c]) };
                (0..3).for_each(|c| part.momentum[c] += mass * at(c));
            }
        }
    }
    parts
}

/// The motion of a held node: velocity at the present time, or at the last mid-step when the run has `ended`.
fn node(engine: &Engine, n: usize, ended: bool) -> NodeState {
    let (nodes, clock) = (&engine.nodes, &engine.clock);
    let (before, after) = (&nodes.v[n], &nodes.next_v[n]);
    let (mid, sign) = if ended { (clock.last_mid, -1.0) } else { (clock.mid(), 1.0) };
    let a = [0, 1, 2].map(|c| if mid > 0.0 { sign * (after[c] - before[c]) / mid } else { 0.0 });
    let since = if ended { 0.0 } else { 0.5 * clock.last_dt };
    let (x, x0) = (xyz(&nodes.x[n]), xyz(&nodes.x0[n]));
    let (u, v) = ([0, 1, 2].map(|c| x[c] - x0[c]), [0, 1, 2].map(|c| before[c] + since * a[c]));
    NodeState { id: nodes.id[n], x, u, v, a }
}
