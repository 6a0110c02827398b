//! What all workers must know alike before anything moves: the stable step, trouble, and the master's orders.
//!
//! One global maximum per cycle, begun when the element forces are known and finished before velocities become
//! positions. The master takes no part: it only drops orders into mailboxes, and the maximum of the order numbers
//! seen tells all workers from which cycle on an order holds.

use crate::blocks::Blocks;
use crate::elements::PassTotals;
use crate::nodes::Nodes;
use crate::time::Clock;
use crumple_proto::ids::ElemId;
use crumple_proto::partition::Settings;
use crumple_proto::transport::{Lost, MaxReduction, Transport};

/// What workers agree on in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreed {
    /// Smallest stable step of all elements [time].
    pub stable_dt: f64,
    /// Element that is in trouble, the lowest id if there are several.
    pub trouble: Option<ElemId>,
    /// Last order that some worker has seen.
    pub order: u64,
    /// Largest relative motion as a fraction of what exterior copies cover.
    pub urgency: f64,
}

/// The maximum that is under way, and what this worker puts into it.
#[derive(Debug)]
pub struct Agreement {
    reduction: MaxReduction,
    /// Last order that has arrived here.
    pub order: u64,
    /// Relative motion that this worker last saw.
    pub urgency: f64,
}

/// Ids count downwards from here, so that the lowest wins a maximum.
const TOP: f64 = ElemId::LARGEST.0 as f64 + 1.0;

impl Agreement {
    /// Nothing agreed yet.
    pub fn new() -> Self {
        Self { reduction: MaxReduction::new(4), order: 0, urgency: 0.0 }
    }

    /// Puts in what this worker knows after its element forces.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn begin(
        &mut self,
        wire: &mut dyn Transport,
        blocks: &Blocks,
        nodes: &Nodes,
        totals: &PassTotals,
        clock: &Clock,
        settings: &Settings,
    ) -> Result<(), Lost> {
        let scaled = || blocks.smallest_step(nodes).map_or(f64::INFINITY, |s| s.0);
        let stable_dt = if blocks.mass_scaled { scaled() } else { totals.stable_dt };
        let collapsed = !blocks.elements.is_empty() && clock.has_collapsed(settings, stable_dt);
        let smallest = || if collapsed { blocks.smallest_step(nodes).map(|s| s.1) } else { None };
        let culprit = totals.trouble.map(|i| blocks.elements[i].record.id).or_else(smallest);
        let trouble = culprit.map_or(0.0, |id| TOP - id.0 as f64);
        let step = if stable_dt.is_nan() { 0.0 } else { stable_dt };
        self.reduction.begin(wire, &[-step, trouble, self.order as f64, self.urgency])
    }

    /// What all agree on.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(&mut self, wire: &mut dyn Transport) -> Result<Agreed, Lost> {
        let max = self.reduction.finish(wire)?;
        let trouble = (max[1] > 0.0).then(|| ElemId((TOP - max[1]) as u64));
        Ok(Agreed { stable_dt: -max[0], trouble, order: max[2] as u64, urgency: max[3] })
    }

    /// The global minimum of a first stable step.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn first_step(&mut self, wire: &mut dyn Transport, stable_dt: f64) -> Result<f64, Lost> {
        self.reduction.begin(wire, &[-stable_dt, 0.0, 0.0, 0.0])?;
        Ok(-self.reduction.finish(wire)?[0])
    }
}

impl Default for Agreement {
    fn default() -> Self {
        Self::new()
    }
}
