//! What all workers must know alike before anything moves: the stable step, trouble, and the
//! master's orders.
//!
//! One global maximum per cycle, begun when the element forces are known and finished before
//! velocities become positions. The master takes no part: it only drops orders into mailboxes, and
//! the maximum of the order numbers seen tells all workers from which cycle on an order holds.

use crate::fem::blocks::Blocks;
use crate::fem::elements::PassTotals;
use crate::nodes::Nodes;
use crate::time::Clock;
use crumple_proto::ids::ElemId;
use crumple_proto::partition::Settings;
use crumple_proto::transport::{MaxReduction, RankLost, Tag, Transport};
use std::ops::Range;

/// What workers agree on in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepConsensus {
    /// Smallest stable step of all elements, or less if contact surfaces would pass through each
    /// other in it [time].
    pub stable_dt: f64,
    /// What contact leaves of it, infinite where nothing can pass anything [time].
    pub contact_dt: f64,
    /// Element that is in trouble, the first by id if there are several; by place in a mesh that
    /// was numbered anew.
    pub failure: Option<ElemId>,
    /// Last order that some worker has seen.
    pub order: u64,
    /// Largest relative motion as a fraction of what exterior copies cover.
    pub margin_used: f64,
    /// Whether elements have failed.
    pub eroded: bool,
    /// Whether workers that are apart tell each other of their motion in the next step.
    pub sync_distant: bool,
    /// No two nodes of contact surfaces had velocities that differ by more in the last step
    /// [length/time].
    pub spread: f64,
}

/// What a worker knows after its element forces.
#[derive(Clone, Copy, Debug)]
pub struct StepContribution {
    /// Of its elements.
    pub totals: PassTotals,
    /// Whether elements have failed since membership was settled.
    pub eroded: bool,
    /// How near the next check-in is, due at 1.
    pub distant_fraction: f64,
    /// Largest velocity components of the nodes of contact surfaces, then the largest of their
    /// negatives; minus infinity without any [length/time].
    pub velocities: [f64; 6],
    /// [`Contact::approach`](crate::contact::Contact::approach) of the step before [1/time].
    pub approach: f64,
}

/// What of the contact surface limits the step.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The smallest scale of a segment, infinite without contact [length].
    pub thinnest: f64,
    /// How far global searches look ahead, 0 before the first [length].
    pub skin: f64,
}

/// The maximum that is under way, and what this worker puts into it.
#[derive(Debug)]
pub struct StepReduction {
    reduction: MaxReduction,
    /// Last order that has arrived here.
    pub order: u64,
    /// Relative motion that this worker last saw.
    pub urgency: f64,
    /// Steps that elements and contact left when all last agreed; as [`Agreed`] [time].
    pub elements_dt: f64,
    /// See `elements_dt`.
    pub contact_dt: f64,
}

/// Step, trouble, order, urgency, failure, check-in, the range of the velocities of what can touch,
/// and how fast what is near passes.
pub const WORDS: usize = 13;
const VELOCITIES: Range<usize> = 6..12;
const APPROACH: usize = 12;

/// Ids count downwards from here, so that the lowest wins a maximum. They travel as the bits of a
/// float: those of positive ones are in the order of their values.
const TOP: u64 = 1 << 62;

fn as_float(id: ElemId) -> f64 {
    f64::from_bits(TOP - id.0)
}

fn of_float(float: f64) -> ElemId {
    ElemId(TOP - float.to_bits())
}

impl StepReduction {
    /// Nothing agreed yet.
    pub fn new() -> Self {
        let (elements_dt, contact_dt) = (f64::INFINITY, f64::INFINITY);
        Self {
            reduction: MaxReduction::new(WORDS, Tag::Maximum),
            order: 0,
            urgency: 0.0,
            elements_dt,
            contact_dt,
        }
    }

    /// Puts in what this worker knows after its element forces.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn begin(
        &mut self,
        comm: &mut dyn Transport,
        blocks: &Blocks,
        nodes: &Nodes,
        known: &StepContribution,
        clock: &Clock,
        settings: &Settings,
    ) -> Result<(), RankLost> {
        let stable_dt = blocks.stable_step(nodes, known.totals.stable_dt);
        let collapsed = !blocks.elements.is_empty() && clock.has_collapsed(settings, stable_dt);
        let smallest = || if collapsed { blocks.smallest_step(nodes).map(|s| s.1) } else { None };
        let culprit = known.totals.trouble.map(|i| blocks.elements[i].record.id).or_else(smallest);
        let trouble = culprit.map_or(0.0, as_float);
        let step = if stable_dt.is_nan() { 0.0 } else { stable_dt };
        let mut words = [0.0; WORDS];
        let eroded = f64::from(known.eroded);
        words[..6].copy_from_slice(&[
            -step,
            trouble,
            self.order as f64,
            self.urgency,
            eroded,
            known.distant_fraction,
        ]);
        words[VELOCITIES].copy_from_slice(&known.velocities);
        words[APPROACH] = known.approach;
        self.reduction.begin(comm, &words)
    }

    /// What all agree on.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(
        &mut self,
        comm: &mut dyn Transport,
        limits: Limits,
    ) -> Result<StepConsensus, RankLost> {
        let max = self.reduction.finish(comm)?;
        let trouble = (max[1] > 0.0).then(|| of_float(max[1]));
        let spread = spread(&max[VELOCITIES]);
        (self.elements_dt, self.contact_dt) = (-max[0], contact_dt(spread, max[APPROACH], limits));
        Ok(StepConsensus {
            stable_dt: self.elements_dt.min(self.contact_dt),
            contact_dt: self.contact_dt,
            failure: trouble,
            order: max[2] as u64,
            margin_used: max[3],
            eroded: max[4] > 0.0,
            sync_distant: max[5] >= 1.0,
            spread,
        })
    }

    /// The global minimum of a first stable step, contact included as in [`Agreement::finish`].
    ///
    /// # Errors
    /// A worker is gone.
    pub fn first_step(
        &mut self,
        comm: &mut dyn Transport,
        stable_dt: f64,
        velocities: [f64; 6],
        thinnest: f64,
    ) -> Result<f64, RankLost> {
        let mut words = [0.0; WORDS];
        words[0] = -stable_dt;
        words[VELOCITIES].copy_from_slice(&velocities);
        self.reduction.begin(comm, &words)?;
        let max = self.reduction.finish(comm)?;
        let limits = Limits { thinnest, skin: 0.0 };
        (self.elements_dt, self.contact_dt) =
            (-max[0], contact_dt(spread(&max[VELOCITIES]), 0.0, limits));
        Ok(self.elements_dt.min(self.contact_dt))
    }
}

/// Part of the skin of searches by which two nodes come nearer in a step at most, for what is near
/// to be known in time: [`STEPS`](crate::contact::approach::STEPS) of them, each as long as the
/// list of near candidates provides for, in half of the skin; and velocities may grow by a fifth
/// meanwhile.
const OF_SKIN: f64 = 0.5 / (2.0 * crate::contact::approach::STEPS * 1.2);

/// Step in which nothing is through what it meets before it is seen: no two nodes of contact
/// surfaces come nearer to each other than by the smallest sum of two scales (the reach of the
/// local search is half as much again); or, if that is longer, no two that are near than by the sum
/// of their own ones, `approach` being the largest rate, and others no more than searches look
/// ahead [time].
fn contact_dt(spread: f64, approach: f64, limits: Limits) -> f64 {
    if spread <= 0.0 {
        return f64::INFINITY;
    }
    let near = if approach > 0.0 { 1.0 / approach } else { f64::INFINITY };
    (2.0 * limits.thinnest / spread).max(near.min(OF_SKIN * limits.skin / spread))
}

/// Largest difference of two velocities within a range as in [`Known::velocities`], 0 without any
/// [length/time].
fn spread(velocities: &[f64]) -> f64 {
    let range = [0, 1, 2].map(|c| velocities[c] + velocities[3 + c]);
    if range[0] >= 0.0 { range.iter().map(|r| r * r).sum::<f64>().sqrt() } else { 0.0 }
}

impl Default for StepReduction {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One fast fragment and one foil do not set the step unless they are near each other.
    #[test]
    fn the_step_goes_by_what_is_near() {
        let limits = Limits { thinnest: 0.01, skin: 1.0 };
        let step =
            |spread: f64, approach: f64, limits: Limits| contact_dt(spread, approach, limits);
        assert_eq!(step(0.0, 0.0, limits), f64::INFINITY);
        assert_eq!(step(2.0, 0.0, Limits { skin: 0.0, ..limits }), 0.01, "before the first search");
        assert_eq!(step(2.0, 0.0, limits), 0.5 * OF_SKIN, "nothing near");
        assert_eq!(step(2.0, 50.0, limits), 0.02, "a near pair");
        assert_eq!(step(2.0, 100.0, limits), 0.01, "the fastest and the thinnest are that pair");
        assert_eq!(
            step(2.0, 0.0, Limits { thinnest: 0.5, ..limits }),
            0.5,
            "a skin that is little beside the scales"
        );
    }

    #[test]
    fn of_ids_as_floats_the_first_is_the_largest() {
        let last = ElemId::placed((1 << 28) - 1, u64::from(u32::MAX)).unwrap();
        let ids = [
            ElemId(0),
            ElemId(1),
            ElemId::LARGEST,
            ElemId::placed(0, 5).unwrap(),
            ElemId::placed(1, 2).unwrap(),
            last,
        ];
        for pair in ids.windows(2) {
            let floats = [as_float(pair[0]), as_float(pair[1])];
            assert!(
                floats[0] > floats[1] && floats[1] > 0.0 && floats[0].is_finite(),
                "{pair:?}: {floats:?}"
            );
        }
        assert_eq!(ids.map(|id| of_float(as_float(id))), ids);
    }
}
