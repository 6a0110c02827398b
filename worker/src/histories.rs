//! History records of a worker besides the global sums: energies of parts, contact forces between
//! parts, nodes and sections. They are computed from the state only when a row is due. They do
//! not change the state.

use crate::airbags::Airbags;
use crate::constraints::belts::Belts;
use crate::contact::Contact;
use crate::fem::blocks::Blocks;
use crate::loads::Loads;
use crate::math::row::{Row, V3, xyz};
use crate::nodes::Nodes;
use crate::time::Clock;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::{
    ContactShare, HistoryRequests, HistoryShares, NodeGroup, NodeState, PartShare, SectionCut,
    SectionShare, merge_each,
};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::Settings;
use crumple_proto::place::ModelPlace;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// State of a worker from which its share of a row is computed.
#[derive(Clone, Copy)]
pub struct HistoryState<'a> {
    /// Settings.
    pub settings: &'a Settings,
    /// Time and step sizes.
    pub clock: &'a Clock,
    /// Nodal columns.
    pub nodes: &'a Nodes,
    /// Own elements.
    pub blocks: &'a Blocks,
    /// Loads.
    pub loads: &'a Loads,
    /// Airbags.
    pub airbags: &'a Airbags,
    /// Seat belts.
    pub belts: &'a Belts,
    /// Contact, if the job has any.
    pub contact: Option<&'a Contact>,
}

/// Local indices of the requested histories.
#[derive(Debug, Default)]
pub struct Histories {
    /// Owned nodes of all groups, ascending.
    nodes: Vec<u32>,
    sections: Vec<LocalSection>,
    /// Accelerations of the recorded nodes at the start of the present outer step, with
    /// subcycles. Later in the outer step they have no acceleration [length/time^2].
    accelerations: HashMap<NodeId, [f64; 3]>,
    /// Contact forces of the present outer step so far, with subcycles.
    felt: SurfaceForces,
    /// Contact forces of the complete previous outer step, with subcycles.
    felt_before: SurfaceForces,
}

/// Contact forces in an outer step: sums over its cycles so far, divided by its number of cycles
/// [force].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct SurfaceForces {
    between_parts: BTreeMap<[u32; 2], [ExactSum; 3]>,
    on_transducers: Vec<[ExactSum; 3]>,
}

impl SurfaceForces {
    /// Adds the `share` of the forces of a cycle.
    fn add(&mut self, share: f64, contact: &Contact, nodes: &Nodes, asked: &HistoryRequests) {
        if asked.contacts {
            contact.add_forces_between_parts(share, &mut self.between_parts);
        }
        self.on_transducers.resize(asked.transducers.len(), Default::default());
        contact.add_forces_on(&asked.transducers, share, nodes, &mut self.on_transducers);
    }

    fn contacts(&self) -> Vec<ContactShare<ExactSum>> {
        let share =
            |(&parts, force): (_, &[ExactSum; 3])| ContactShare { parts, force: force.clone() };
        self.between_parts.iter().map(share).collect()
    }
}

/// Local part of a section.
#[derive(Debug, Default)]
struct LocalSection {
    /// Slots of the element nodal forces of own elements at nodes of the section, the local node,
    /// and the number of cycles for which a force in the slot acts.
    corners: Vec<(usize, u32, f64)>,
    /// Owned nodes.
    nodes: Vec<u32>,
}

/// Contact forces that are state between outer steps: those of the complete outer step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactSums(SurfaceForces);

impl ContactSums {
    /// Checks that the forces are those of a job with these numbers of parts and transducers.
    ///
    /// # Errors
    /// They are not: the reason.
    pub fn validate(&self, parts: usize, transducers: usize) -> Result<(), String> {
        let known = |pair: &[u32; 2]| pair.iter().all(|&part| (part as usize) < parts);
        if !self.0.between_parts.keys().all(known) {
            return Err("it has contact forces of a part that the job does not have".into());
        }
        let count = self.0.on_transducers.len();
        if count > transducers {
            return Err(format!(
                "it has forces of {count} transducers, and the job has {transducers}"
            ));
        }
        Ok(())
    }

    /// Adds the forces of another worker.
    pub fn add(&mut self, o: &Self) {
        for (&parts, force) in &o.0.between_parts {
            merge_each(self.0.between_parts.entry(parts).or_default(), force);
        }
        let count = self.0.on_transducers.len().max(o.0.on_transducers.len());
        self.0.on_transducers.resize(count, Default::default());
        for (sum, force) in self.0.on_transducers.iter_mut().zip(&o.0.on_transducers) {
            merge_each(sum, force);
        }
    }
}

impl Histories {
    /// Returns the state at the start of an outer step.
    pub fn contact_sums(&self) -> ContactSums {
        // Nodes and sections are found for each partition. The start of an outer step sets the
        // accelerations, and replaces `felt_before`.
        let Self { nodes: _, sections: _, accelerations: _, felt, felt_before: _ } = self;
        ContactSums(felt.clone())
    }

    /// Sets the state at the start of an outer step.
    pub fn restore(&mut self, sums: ContactSums) {
        self.felt = sums.0;
    }

    /// Finds the requested nodes and elements on this worker.
    pub fn bind_local(
        &mut self,
        asked: &HistoryRequests,
        subcycles: u64,
        nodes: &Nodes,
        blocks: &Blocks,
    ) {
        let own = |ids: &[crumple_proto::ids::NodeId]| -> Vec<u32> {
            let held = ids.iter().filter_map(|&id| nodes.local_index(id));
            held.filter(|&n| nodes.is_owned(n as usize)).collect()
        };
        let axes = |group: &NodeGroup| own(group.axes.as_ref().map_or(&[], |axes| &axes[..]));
        let of = |group: &NodeGroup| own(&group.nodes).into_iter().chain(axes(group));
        self.nodes = asked.nodes.iter().flat_map(of).collect();
        self.nodes.sort_unstable();
        self.nodes.dedup();
        self.sections.clear();
        if asked.sections.is_empty() {
            return;
        }
        let slots = blocks.first_slots();
        let place: HashMap<_, usize> =
            blocks.elements.iter().enumerate().map(|(i, e)| (e.record.id, i)).collect();
        let local = |section: &SectionCut| {
            let mut corners = Vec::new();
            for &i in section.elements.iter().filter_map(|id| place.get(id)) {
                let e = &blocks.elements[i];
                let at = (0..e.record.shape.corners())
                    .filter(|&c| section.nodes.binary_search(&e.record.nodes[c]).is_ok());
                let cycles = if e.record.slow { subcycles as f64 } else { 1.0 };
                corners.extend(at.map(|c| (slots[i] + c, e.nodes[c], cycles)));
            }
            LocalSection { corners, nodes: own(&section.nodes) }
        };
        self.sections = asked.sections.iter().map(local).collect();
    }

    /// Returns the accelerations of the recorded nodes at the start of an outer step
    /// [length/time^2].
    pub fn accelerations(&self, state: &HistoryState<'_>) -> HashMap<NodeId, [f64; 3]> {
        let of = |&n: &u32| (state.nodes.id[n as usize], mean_acceleration(state, n as usize));
        self.nodes.iter().map(of).collect()
    }

    /// Starts an outer step with these accelerations [length/time^2].
    pub fn start_outer_step(&mut self, accelerations: HashMap<NodeId, [f64; 3]>) {
        self.accelerations = accelerations;
        self.felt_before = std::mem::take(&mut self.felt);
    }

    /// Adds the contact forces of a cycle to the means over an outer step.
    pub fn record_contact(&mut self, settings: &Settings, contact: &Contact, nodes: &Nodes) {
        self.felt.add(1.0 / settings.subcycles as f64, contact, nodes, &settings.histories);
    }

    /// Returns this worker's shares of a row. Velocities are those before and after the present
    /// time or, if the run has `ended`, those of the last two mid-steps; forces are then those of
    /// the last step.
    pub fn shares(&self, state: &HistoryState<'_>, ended: bool) -> HistoryShares<ExactSum> {
        let asked = &state.settings.histories;
        // Contact reacts at once to the forces of slow elements: only means over an outer step
        // are meaningful.
        let mut of_step = SurfaceForces::default();
        let felt = match (state.settings.subcycles > 1, ended) {
            (true, true) => &self.felt,
            (true, false) => &self.felt_before,
            (false, _) => {
                if let Some(contact) = state.contact {
                    of_step.add(1.0, contact, state.nodes, asked);
                }
                &of_step
            }
        };
        let mut transducers = felt.on_transducers.clone();
        transducers.resize(asked.transducers.len(), Default::default());
        HistoryShares {
            parts: parts(state, ended),
            contacts: felt.contacts(),
            nodes: self.nodes.iter().map(|&n| self.node(state, n as usize, ended)).collect(),
            sections: self.sections(state),
            transducers,
            airbags: state.airbags.records(),
            belts: state.belts.records(),
        }
    }

    fn node(&self, state: &HistoryState<'_>, n: usize, ended: bool) -> NodeState {
        let motion = node(state, n, ended);
        if state.settings.subcycles == 1 {
            return motion;
        }
        let known = self.accelerations.get(&motion.id).copied();
        NodeState { a: known.unwrap_or_else(|| mean_acceleration(state, n)), ..motion }
    }

    fn sections(&self, state: &HistoryState<'_>) -> Vec<SectionShare<ExactSum>> {
        if self.sections.is_empty() {
            return Vec::new();
        }
        // The slots contain pressure too, which is no internal force of the element.
        let mut pressed: HashMap<usize, V3> = HashMap::new();
        for (slot, f) in state.loads.on_slots() {
            *pressed.entry(slot).or_default() += V3::from(xyz(f));
        }
        let at = |n: u32| V3::from(xyz(&state.nodes.x[n as usize]));
        let share = |section: &LocalSection| {
            let mut sums = SectionShare { nodes: section.nodes.len() as u64, ..Default::default() };
            for &(slot, n, cycles) in &section.corners {
                let pressed = pressed.get(&slot).copied().unwrap_or_default();
                let f = (-V3::from(xyz(&state.blocks.force[slot])) - pressed) / cycles;
                add(&mut sums.force, f);
                let mut moment = at(n).cross(&f);
                if let Some(m) = state.blocks.moment.get(slot) {
                    moment -= V3::from(xyz(m)) / cycles;
                }
                add(&mut sums.moment, moment);
            }
            section.nodes.iter().for_each(|&n| add(&mut sums.places, at(n)));
            sums
        };
        self.sections.iter().map(share).collect()
    }
}

fn add(sums: &mut [ExactSum; 3], term: V3) {
    (0..3).for_each(|c| sums[c].add(term[c]));
}

/// Returns the energies, masses and momenta of own elements by part. Nodal masses are those of
/// the elements; masses added by `[[mass]]` belong to no part. A term of the exact sums is that of
/// one element, since they take longer than plain sums over its corners.
fn parts(state: &HistoryState<'_>, ended: bool) -> Vec<PartShare<ExactSum>> {
    let (nodes, blocks) = (state.nodes, state.blocks);
    let mut parts = vec![PartShare::<ExactSum>::default(); state.settings.parts.len()];
    for (e, energies) in blocks.energies() {
        let part = &mut parts[e.record.part as usize];
        part.internal.add(energies[0]);
        part.hourglass.add(energies[1]);
        let at = || ModelPlace { element: Some(e.record.id), ..ModelPlace::default() };
        part.most_hourglass.raise(energies[1], at);
    }
    let worst: Vec<Option<ElemId>> =
        parts.iter().map(|part| part.most_hourglass.at.element).collect();
    for e in &blocks.elements {
        let part = e.record.part as usize;
        if worst[part] == Some(e.record.id) {
            parts[part].most_hourglass.at = Blocks::place_of(e, nodes);
        }
    }
    let dot = |a: &Row, b: &Row| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for b in &blocks.blocks {
        for e in &blocks.elements[b.first..b.first + b.count] {
            let part = &mut parts[e.record.part as usize];
            let x = e.nodes.map(|n| xyz(&nodes.x0[n as usize]));
            let (mass, inertia) = b.element.corner_mass(&x, e.record.own);
            let (mass, inertia) = (mass * e.record.mass_factor, inertia * e.record.mass_factor);
            let (mut kinetic, mut momentum) = (0.0, [0.0; 3]);
            let corners = e.record.shape.corners();
            for (c, n) in e.nodes[..corners].iter().map(|&n| n as usize).enumerate() {
                let share = e.record.shape.mass_share(c);
                let (v, next) = (&nodes.v[n], &nodes.v_next[n]);
                let turning = if nodes.rotations {
                    inertia * dot(&nodes.w[n], &nodes.w_next[n])
                } else {
                    0.0
                };
                kinetic += 0.5 * share * (mass * dot(v, next) + turning);
                let at = |c: usize| if ended { v[c] } else { 0.5 * (v[c] + next[c]) };
                (0..3).for_each(|c| momentum[c] += share * mass * at(c));
            }
            part.mass.add(mass * corners as f64);
            part.kinetic.add(kinetic);
            (0..3).for_each(|c| part.momentum[c].add(momentum[c]));
        }
    }
    parts
}

/// Returns the acceleration of a local node at the start of an outer step [length/time^2]. Forces
/// of slow elements act in one cycle only, so only means over an outer step are meaningful. The
/// present velocity is ahead of its mean by half of its change in an outer step.
fn mean_acceleration(state: &HistoryState<'_>, n: usize) -> [f64; 3] {
    let (nodes, clock) = (state.nodes, state.clock);
    let (before, after) = (&nodes.v[n], &nodes.v_next[n]);
    match nodes.mean_v.get(n).filter(|_| clock.last_dt > 0.0) {
        Some(mean) => [0, 1, 2].map(|c| {
            let now = before[c] + 0.5 * clock.last_dt * (after[c] - before[c]) / clock.mid();
            (now - mean[c]) / (0.5 * state.settings.subcycles as f64 * clock.last_dt)
        }),
        // At the start all strains are zero: only loads and initial contact act.
        None => [0, 1, 2]
            .map(|c| if clock.mid() > 0.0 { (after[c] - before[c]) / clock.mid() } else { 0.0 }),
    }
}

/// Returns the motion of a local node. The velocity is that of the present time or, if the run
/// has `ended`, of the last mid-step.
fn node(state: &HistoryState<'_>, n: usize, ended: bool) -> NodeState {
    let (nodes, clock) = (state.nodes, state.clock);
    let (before, after) = (&nodes.v[n], &nodes.v_next[n]);
    let (mid, sign) = if ended { (clock.last_mid, -1.0) } else { (clock.mid(), 1.0) };
    let a = [0, 1, 2].map(|c| if mid > 0.0 { sign * (after[c] - before[c]) / mid } else { 0.0 });
    let since = if ended { 0.0 } else { 0.5 * clock.last_dt };
    let (x, x0) = (xyz(&nodes.x[n]), xyz(&nodes.x0[n]));
    let (u, v) = ([0, 1, 2].map(|c| x[c] - x0[c]), [0, 1, 2].map(|c| before[c] + since * a[c]));
    NodeState { id: nodes.id[n], x, u, v, a }
}
