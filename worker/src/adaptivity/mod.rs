//! Adaptivity: four-node shells are divided into four where they bend.
//!
//! At each check, on all workers together:
//! 1. `marks.rs`: shells whose plastic bending angle has reached its limit are marked, then their
//!    neighbours. A marked shell next to a larger one marks it too, if that may be divided.
//! 2. `division.rs`: every worker learns all divisions, sorted by element, and gives new nodes and
//!    elements the same ids. `quarters.rs`: the worker that owns a divided shell makes its
//!    quarters, with the history of the shell, and the new nodes. `pair_histories.rs`: the
//!    histories of contact pairs go over to the quarters.
//! 3. `hanging.rs`: a node in the middle of a side whose other shell is not divided is tied to the
//!    ends of the side.
//! 4. `worker/src/engine/adaptivity.rs`: the local mesh is built again, and the step becomes
//!    shorter if a quarter needs it.
//!
//! A new node in the middle of a side has the mean position and the mean velocities of the ends, a
//! node in the centre those of the four corners. So the surface stays as it is, and so does the
//! linear momentum if opposite sides of the divided shells are equal. The kinetic energy of
//! velocity differences within the divided shells is lost and counts as work of external forces.
//! Forces that only stabilise an element begin at zero. Nothing is made coarse again.
//!
//! The mesh after some checks does not depend on the number of workers: all lists are sorted by
//! global ids before they are numbered or summed.

pub(crate) mod division;
pub(crate) mod hanging;
pub(crate) mod marks;
mod pair_histories;
pub(crate) mod quarters;

use crumple_proto::adaptivity::AdaptivitySettings;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::{NodeRecord, Settings};
use crumple_proto::report::DivisionCounts;
use division::NumberedDivision;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Side of a shell: its nodes, the lower id first.
type ShellSide = [NodeId; 2];

/// Returns the side between two nodes.
fn side(a: NodeId, b: NodeId) -> ShellSide {
    if a < b { [a, b] } else { [b, a] }
}

/// The divisions so far, equal on all workers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Adaptivity {
    #[serde(skip)]
    settings: AdaptivitySettings,
    /// Time of the next check [time].
    next_check: f64,
    /// True if the step is short enough for the divisions of the next check, and the cycle until
    /// which that waits.
    pub(crate) ready: bool,
    pub(crate) waits_until: u64,
    /// All divisions, in their order, and the sum of the cycles after which they took place.
    divisions: Vec<NumberedDivision>,
    cycles: u64,
    /// How often the elements that are quarters were divided.
    levels: BTreeMap<ElemId, u32>,
    /// All new nodes.
    nodes: BTreeMap<NodeId, NewNode>,
    /// Those in the middle of sides, by side.
    of_sides: BTreeMap<ShellSide, NodeId>,
    /// Nodes of each prescribed motion, new ones too, and its degrees of freedom.
    #[serde(skip)]
    led: Vec<(BTreeSet<NodeId>, u64)>,
}

/// A node that a division has made.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct NewNode {
    /// The ends of its side, or the corners of its shell.
    between: Vec<NodeId>,
    /// Mass and rotational inertia that elements have there [mass], [mass length^2].
    mass: [f64; 2],
    /// The nodes that it follows, with their weights; empty if it is free.
    follows: Vec<(NodeId, f64)>,
}

impl Adaptivity {
    /// Returns the state at the start of a job with adaptivity.
    pub fn new(settings: &Settings) -> Option<Self> {
        let begin = settings.adaptivity.as_ref()?.window[0];
        Self { next_check: begin, ..Self::default() }.with_settings(settings)
    }

    /// Sets what the job says, after the state was read; `None` if the job has no adaptivity.
    pub fn with_settings(self, settings: &Settings) -> Option<Self> {
        let motions = &settings.loads.motions;
        let led = motions.iter().map(|m| (m.nodes.iter().copied().collect(), m.dofs)).collect();
        let mut all = Self { settings: settings.adaptivity.clone()?, led, ..self };
        for (new, between) in all.divisions.iter().flat_map(NumberedDivision::made) {
            lead(&mut all.led, new, &between);
        }
        Some(all)
    }

    /// Checks that the state can be that after a cycle.
    ///
    /// # Errors
    /// It cannot: the reason.
    pub fn validate(&self, cycle: u64) -> Result<(), String> {
        let follows = |node: &NewNode| node.follows.iter().all(|(_, w)| *w > 0.0 && *w <= 1.0);
        if self.cycles > self.divided() * cycle
            || !self.next_check.is_finite()
            || !self.nodes.values().all(|node| !node.between.is_empty() && follows(node))
        {
            return Err("its divisions of shells are impossible".into());
        }
        Ok(())
    }

    /// Returns the number of elements divided so far.
    pub fn divided(&self) -> u64 {
        self.divisions.len() as u64
    }

    /// Returns the number of divisions, and that of the element computations that their quarters
    /// have added until the end of a cycle.
    pub fn counts(&self, cycle: u64) -> DivisionCounts {
        let divided = self.divided();
        DivisionCounts { divided, computed: 3 * (divided * cycle - self.cycles) }
    }

    /// Returns the nodes that hang, each with the nodes between which it lies.
    pub fn hanging(&self) -> impl Iterator<Item = (NodeId, &[NodeId])> + '_ {
        let hanging = self.nodes.iter().filter(|(_, node)| !node.follows.is_empty());
        hanging.map(|(&id, node)| (id, &node.between[..]))
    }

    /// Returns true if a check is due at this time.
    pub(crate) fn is_due(&self, time: f64) -> bool {
        time >= self.next_check && time <= self.settings.window[1]
    }

    /// Counts the checks that are due at this time as one that is done.
    pub(crate) fn pass(&mut self, time: f64) {
        let interval = self.settings.interval;
        self.next_check += interval * ((time - self.next_check) / interval).floor();
        if self.next_check <= time {
            self.next_check += interval;
        }
    }

    /// Returns true if an element of this part may be divided once more.
    fn may_divide(&self, part: u32, id: ElemId) -> bool {
        self.settings.parts.binary_search(&part).is_ok()
            && self.level(id) < self.settings.levels
            && self.settings.kept.binary_search(&id).is_err()
    }

    fn level(&self, id: ElemId) -> u32 {
        self.levels.get(&id).copied().unwrap_or(0)
    }

    /// Returns the side of which this one is a half, if there is one.
    fn whole_side(&self, [a, b]: ShellSide) -> Option<ShellSide> {
        let of = |(middle, end): (NodeId, NodeId)| match self.nodes.get(&middle)?.between[..] {
            [p, q] if end == p || end == q => Some([p, q]),
            _ => None,
        };
        [(a, b), (b, a)].into_iter().find_map(of)
    }

    /// Returns true if one prescribed motion has all these nodes.
    fn are_led(&self, between: &[NodeId]) -> bool {
        self.led.iter().any(|(nodes, _)| between.iter().all(|id| nodes.contains(id)))
    }

    /// Returns the degrees of freedom of a node that are fixed, without the prescribed ones.
    fn held(&self, node: &NodeRecord) -> u64 {
        let of_node = self.led.iter().filter(|(nodes, _)| nodes.contains(&node.id));
        node.fixed & !of_node.fold(0, |all, (_, dofs)| all | dofs)
    }
}

/// Adds a new node to the motions that all nodes have between which it lies.
fn lead(led: &mut [(BTreeSet<NodeId>, u64)], new: NodeId, between: &[NodeId]) {
    for (nodes, _) in led {
        if between.iter().all(|id| nodes.contains(id)) {
            nodes.insert(new);
        }
    }
}
