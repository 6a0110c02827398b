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
    /// Smallest stable step of all elements, or less if contact surfaces would pass through each other in it [time].
    pub stable_dt: f64,
    /// Element that is in trouble, the first by id if there are several; by place in a mesh that was numbered anew.
    pub trouble: Option<ElemId>,
    /// Last order that some worker has seen.
    pub order: u64,
    /// Largest relative motion as a fraction of what exterior copies cover.
    pub urgency: f64,
    /// Whether elements have failed.
    pub eroded: bool,
    /// Whether workers that are apart tell each other of their motion in the next step.
    pub check_in: bool,
    /// No two nodes of contact surfaces had velocities that differ by more in the last step [length/time].
    pub spread: f64,
}

/// What a worker knows after its element forces.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Of its elements.
    pub totals: PassTotals,
    /// Whether elements have failed since membership was settled.
    pub eroded: bool,
    /// How near the next check-in is, due at 1.
    pub parted: f64,
    /// Largest velocity components of the nodes of contact surfaces, then the largest of their negatives; minus
    /// infinity without any [length/time].
    pub velocities: [f64; 6],
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

/// Step, trouble, order, urgency, failure, check-in, and the range of the velocities of what can touch.
pub const WORDS: usize = 12;

/// Ids count downwards from here, so that the lowest wins a maximum. They travel as the bits of a float: those of positive
/// ones are in the order of their values.
const TOP: u64 = 1 << 62;

fn as_float(id: ElemId) -> f64 {
    f64::from_bits(TOP - id.0)
}

fn of_float(float: f64) -> ElemId {
    ElemId(TOP - float.to_bits())
}

impl Agreement {
    /// Nothing agreed yet.
    pub fn new() -> Self {
        Self { reduction: MaxReduction::new(WORDS), order: 0, urgency: 0.0 }
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
        known: &Known,
        clock: &Clock,
        settings: &Settings,
    ) -> Result<(), Lost> {
        let stable_dt = blocks.stable_step(nodes, known.totals.stable_dt);
        let collapsed = !blocks.elements.is_empty() && clock.has_collapsed(settings, stable_dt);
        let smallest = || if collapsed { blocks.smallest_step(nodes).map(|s| s.1) } else { None };
        let culprit = known.totals.trouble.map(|i| blocks.elements[i].record.id).or_else(smallest);
        let trouble = culprit.map_or(0.0, as_float);
        let step = if stable_dt.is_nan() { 0.0 } else { stable_dt };
        let mut words = [0.0; WORDS];
        let eroded = f64::from(known.eroded);
        words[..6].copy_from_slice(&[-step, trouble, self.order as f64, self.urgency, eroded, known.parted]);
        words[6..].copy_from_slice(&known.velocities);
        self.reduction.begin(wire, &words)
    }

    /// What all agree on; `thinnest` is the smallest scale of a contact surface [length].
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(&mut self, wire: &mut dyn Transport, thinnest: f64) -> Result<Agreed, Lost> {
        let max = self.reduction.finish(wire)?;
        let trouble = (max[1] > 0.0).then(|| of_float(max[1]));
        let spread = spread(&max[6..]);
        Ok(Agreed {
            stable_dt: (-max[0]).min(contact_dt(spread, thinnest)),
            trouble,
            order: max[2] as u64,
            urgency: max[3],
            eroded: max[4] > 0.0,
            check_in: max[5] >= 1.0,
            spread,
        })
    }

    /// The global minimum of a first stable step, contact included as in [`Agreement::finish`].
    ///
    /// # Errors
    /// A worker is gone.
    pub fn first_step(
        &mut self,
        wire: &mut dyn Transport,
        stable_dt: f64,
        velocities: [f64; 6],
        thinnest: f64,
    ) -> Result<f64, Lost> {
        let mut words = [0.0; WORDS];
        words[0] = -stable_dt;
        words[6..].copy_from_slice(&velocities);
        self.reduction.begin(wire, &words)?;
        let max = self.reduction.finish(wire)?;
        Ok((-max[0]).min(contact_dt(spread(&max[6..]), thinnest)))
    }
}

/// Step in which no two nodes of contact surfaces come nearer to each other than by the smallest sum of two scales: what
/// is about to touch is then seen before it is through (the reach of the local search is half as much again) [time].
fn contact_dt(spread: f64, thinnest: f64) -> f64 {
    if spread > 0.0 { 2.0 * thinnest / spread } else { f64::INFINITY }
}

/// Largest difference of two velocities within a range as in [`Known::velocities`], 0 without any [length/time].
fn spread(velocities: &[f64]) -> f64 {
    let range = [0, 1, 2].map(|c| velocities[c] + velocities[3 + c]);
    if range[0] >= 0.0 { range.iter().map(|r| r * r).sum::<f64>().sqrt() } else { 0.0 }
}

impl Default for Agreement {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_ids_as_floats_the_first_is_the_largest() {
        let last = ElemId::placed((1 << 28) - 1, u64::from(u32::MAX)).unwrap();
        let ids =
            [ElemId(0), ElemId(1), ElemId::LARGEST, ElemId::placed(0, 5).unwrap(), ElemId::placed(1, 2).unwrap(), last];
        for pair in ids.windows(2) {
            let floats = [as_float(pair[0]), as_float(pair[1])];
            assert!(floats[0] > floats[1] && floats[1] > 0.0 && floats[0].is_finite(), "{pair:?}: {floats:?}");
        }
        assert_eq!(ids.map(|id| of_float(as_float(id))), ids);
    }
}
