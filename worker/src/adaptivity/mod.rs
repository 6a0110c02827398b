//! Adaptivity: four-node shells are divided into four where they bend.
//!
//! At each check, on all workers together:
//! 1. `marks.rs`: shells whose plastic bending angle has reached its limit are marked, then their
//!    neighbours. A marked shell next to a larger one marks it too, so that no side has more than
//!    one node in its middle.
//! 2. `division.rs`: every worker learns all divisions, sorted by element, and gives new nodes and
//!    elements the same ids. The worker that owns a divided shell makes its quarters, with the
//!    history of the shell, and the new nodes. Pair histories go over to the quarters.
//! 3. `hanging.rs`: a node in the middle of a side whose other shell is not divided is tied to the
//!    ends of the side.
//! 4. `engine.rs`: the local mesh is built again, and the step becomes shorter if a quarter needs
//!    it.
//!
//! A new node in the middle of a side has the mean position and the mean velocities of the ends, a
//! node in the centre those of the four corners. The surface and the linear momentum stay as they
//! are; the kinetic energy of velocity differences within the divided shells is lost and counts as
//! work of external forces. Forces that only stabilise an element begin at zero. Nothing is made
//! coarse again.
//!
//! The mesh after some checks does not depend on the number of workers: all lists are sorted by
//! global ids before they are numbered or summed.

mod division;
mod engine;
mod hanging;
mod marks;

use crumple_proto::adaptivity::AdaptivitySettings;
use crumple_proto::ids::{ElemId, NodeId};
use division::NumberedDivision;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Side of a shell: its nodes, the lower id first.
pub type Side = [NodeId; 2];

/// Returns the side between two nodes.
fn side(a: NodeId, b: NodeId) -> Side {
    if a < b { [a, b] } else { [b, a] }
}

/// The divisions so far, equal on all workers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Adaptivity {
    #[serde(skip)]
    settings: AdaptivitySettings,
    /// Number of checks so far.
    checks: u64,
    /// True if the step is short enough for the divisions of the next check, and the cycle until
    /// which that waits.
    ready: bool,
    waits_until: u64,
    /// All divisions, in their order, and the sum of the cycles after which they took place.
    divisions: Vec<NumberedDivision>,
    cycles: u64,
    /// Number of nodes made so far.
    made: u64,
    /// How often the elements that are quarters were divided.
    levels: BTreeMap<ElemId, u32>,
    /// Nodes in the middle of sides, with the mass and the rotational inertia that elements have
    /// there [mass], [mass length^2].
    middles: BTreeMap<NodeId, Middle>,
    /// The same nodes by side.
    of_sides: BTreeMap<Side, NodeId>,
    /// Sides with ends of one prescribed motion.
    led: BTreeSet<Side>,
}

/// Node in the middle of a side.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Middle {
    side: Side,
    mass: [f64; 2],
    /// The nodes that it follows, with their weights; empty if it is free.
    follows: Vec<(NodeId, f64)>,
}

impl Adaptivity {
    /// Returns the state at the start.
    pub fn new(settings: &AdaptivitySettings) -> Self {
        Self {
            led: settings.led.iter().copied().collect(),
            settings: settings.clone(),
            ..Self::default()
        }
    }

    /// Returns the number of elements divided so far.
    pub fn divided(&self) -> u64 {
        self.divisions.len() as u64
    }

    /// Returns the number of elements divided so far, and the number of element computations that
    /// their quarters have added until the end of a cycle.
    pub fn counts(&self, cycle: u64) -> [u64; 2] {
        [self.divided(), 3 * (self.divided() * cycle - self.cycles)]
    }

    /// Sets what the job says, after the state was read.
    pub fn with_settings(self, settings: &AdaptivitySettings) -> Self {
        Self { settings: settings.clone(), ..self }
    }

    /// Returns the nodes that hang, each with the ends of its side.
    pub fn hanging(&self) -> impl Iterator<Item = (NodeId, Side)> + '_ {
        let hanging = self.middles.iter().filter(|(_, middle)| !middle.follows.is_empty());
        hanging.map(|(&node, middle)| (node, middle.side))
    }

    /// Returns true if a check is due at this time.
    fn is_due(&self, time: f64) -> bool {
        time >= self.settings.time_of(self.checks) && time <= self.settings.window[1]
    }

    /// Counts the checks that are due at this time as one that is done.
    fn pass(&mut self, time: f64) {
        while self.is_due(time) {
            self.checks += 1;
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
    fn whole_side(&self, [a, b]: Side) -> Option<Side> {
        let halves = [(a, b), (b, a)];
        let of = |(middle, end): (NodeId, NodeId)| {
            self.middles.get(&middle).map(|m| m.side).filter(|side| side.contains(&end))
        };
        halves.into_iter().find_map(of)
    }
}
