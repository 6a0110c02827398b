//! Quantities that all workers agree on before any node moves: the stable step, failures, and
//! the master's orders.
//!
//! There is one global maximum per cycle. It begins when the element forces are known and
//! finishes before velocities are integrated. The master takes no part: it only sends orders,
//! and the maximum of the order numbers that have arrived defines the cycle in which all
//! workers execute an order.

use crate::fem::blocks::Blocks;
use crate::fem::elements::PassTotals;
use crate::nodes::Nodes;
use crate::time::Clock;
use crumple_proto::ids::ElemId;
use crumple_proto::partition::Settings;
use crumple_proto::report::Displacement;
use crumple_proto::transport::{MaxReduction, RankLost, Tag, Transport};
use std::fmt;
use std::ops::Range;

/// Result of the reduction of a cycle, equal on all workers.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct StepConsensus {
    /// Smallest stable step of all elements, or less if contact surfaces would pass through
    /// each other in it [time].
    pub stable_dt: f64,
    /// Limit of the step due to contact, infinite without contact surfaces in relative motion
    /// [time].
    pub contact_dt: f64,
    /// Cause for which the step is not made.
    pub failure: Option<StepFailure>,
    /// Last order that has arrived at any worker.
    pub order: u64,
    /// Largest relative motion as a fraction of the motion that the ghosts allow.
    pub margin_used: f64,
    /// True if elements have failed on any worker.
    pub eroded: bool,
    /// True if distant workers exchange their motion in the next step.
    pub sync_distant: bool,
    /// Upper bound of the velocity difference of any two nodes of contact surfaces in the last
    /// step [length/time].
    pub spread: f64,
}

/// Cause for which a step is not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepFailure {
    /// Element that has failed numerically, the lowest id of several; ids with a place compare by
    /// it.
    Element(ElemId),
    /// An airbag has no valid state, see [`crate::airbags::Airbags::fault`].
    Airbag,
}

impl fmt::Display for StepFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Element(element) => write!(f, "in element {element}"),
            Self::Airbag => write!(f, "in an airbag"),
        }
    }
}

/// Contribution of one worker, known after its element forces.
#[derive(Clone, Copy, Debug)]
pub struct StepContribution {
    /// Totals over its elements.
    pub totals: PassTotals,
    /// True if elements have failed and are still in the contact surface.
    pub eroded: bool,
    /// Fraction of the permitted approach since distant workers last exchanged their motion; 1
    /// triggers an exchange.
    pub distant_fraction: f64,
    /// Largest velocity components of the nodes of contact surfaces, followed by the largest of
    /// their negatives; minus infinity without such nodes [length/time].
    pub velocities: [f64; 6],
    /// [`Contact::approach`](crate::contact::Contact::approach) of the step before [1/time].
    pub approach: f64,
}

/// Lengths of the contact surface that limit the step.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Smallest scale of a segment, infinite without contact [length].
    pub thinnest: f64,
    /// Skin of the global searches, 0 before the first [length].
    pub skin: f64,
}

/// Reduction in progress, and this worker's contribution.
#[derive(Debug)]
pub struct StepReduction {
    reduction: MaxReduction,
    /// Last order that has arrived at this worker.
    pub order: u64,
    /// Last displacement at this worker.
    pub displacement: Displacement,
    /// Limit of the step due to elements at the last reduction [time].
    pub elements_dt: f64,
    /// Limit of the step due to contact, see [`StepConsensus::contact_dt`] [time].
    pub contact_dt: f64,
}

/// Words of a contribution: stable step, failed element, order, margin used, erosion, approach
/// of distant workers, range of the velocities of contact surfaces, and the rate of approach.
pub const WORDS: usize = 13;
const VELOCITIES: Range<usize> = 6..12;
const APPROACH: usize = 12;

/// Ids are subtracted from this number, so that the lowest id has the maximum. They are sent as
/// the bits of a float: the bits of positive floats have the order of their values.
const TOP: u64 = 1 << 62;

fn as_float(id: ElemId) -> f64 {
    f64::from_bits(TOP - id.0)
}

fn of_float(float: f64) -> ElemId {
    ElemId(TOP - float.to_bits())
}

impl StepReduction {
    /// Returns a reduction without results.
    pub fn new() -> Self {
        let (elements_dt, contact_dt) = (f64::INFINITY, f64::INFINITY);
        Self {
            reduction: MaxReduction::new(WORDS, Tag::Maximum),
            order: 0,
            displacement: Displacement::default(),
            elements_dt,
            contact_dt,
        }
    }

    /// Returns the state at the start of a step, equal on all workers: the limits of the step due
    /// to elements and to contact [time].
    pub fn limits(&self) -> [f64; 2] {
        // A new field is an error here: state has to be added, all else to the last list.
        let Self {
            elements_dt,
            contact_dt,
            // Orders are numbered from the start of a process; a restart has a new partition.
            reduction: _,
            order: _,
            displacement: _,
        } = self;
        [*elements_dt, *contact_dt]
    }

    /// Begins the reduction with this worker's contribution.
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
            self.displacement.share,
            eroded,
            known.distant_fraction,
        ]);
        words[VELOCITIES].copy_from_slice(&known.velocities);
        words[APPROACH] = known.approach;
        self.reduction.begin(comm, &words)
    }

    /// Completes the messages of the reduction. Workers with much contact then let no other wait.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn complete(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        self.reduction.complete(comm)
    }

    /// Finishes the reduction and returns its result.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(
        &mut self,
        comm: &mut dyn Transport,
        limits: Limits,
    ) -> Result<StepConsensus, RankLost> {
        let max = self.reduction.finish(comm)?;
        let trouble = (max[1] > 0.0).then(|| StepFailure::Element(of_float(max[1])));
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

    /// Returns the global minimum of the first stable step, contact included as in
    /// [`StepReduction::finish`] [time].
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

/// Largest approach of two nodes in a step over the skin of the searches, such that the near
/// list stays complete. Half of the skin covers [`STEPS`](crate::contact::approach::STEPS)
/// steps of the length that the near list provides for, while velocities may increase by a
/// fifth.
const OF_SKIN: f64 = 0.5 / (2.0 * crate::contact::approach::STEPS * 1.2);

/// Returns true if pairs near each other can allow a longer step than the smallest scale of the
/// surface, with a skin of the searches [length].
pub fn near_pairs_decide(thinnest: f64, skin: f64) -> bool {
    OF_SKIN * skin > 2.0 * thinnest
}

/// Returns the skin [length] with which nodes of these velocities do not shorten a step `dt` unless
/// they are near each other; `None` if they do not shorten it for any skin. `thinnest` is the
/// smallest scale of a segment [length], `spread` the largest velocity difference [length/time].
pub fn skin_for(thinnest: f64, spread: f64, dt: f64) -> Option<f64> {
    (dt * spread > 2.0 * thinnest).then(|| dt * spread / OF_SKIN)
}

/// Returns the largest step in which contact detects a pair before its slave passes through the
/// target [time]. It is the larger of two steps. In the first, no two nodes of contact surfaces
/// approach each other by more than the smallest sum of two scales; the reach of the local
/// search is half as large again. In the second, near pairs approach by no more than the sum of
/// their own scales, where `approach` is the largest rate, and other nodes by no more than
/// searches look ahead.
fn contact_dt(spread: f64, approach: f64, limits: Limits) -> f64 {
    if spread <= 0.0 {
        return f64::INFINITY;
    }
    let near = if approach > 0.0 { 1.0 / approach } else { f64::INFINITY };
    (2.0 * limits.thinnest / spread).max(near.min(OF_SKIN * limits.skin / spread))
}

/// Returns the largest difference of two velocities within a range as in
/// [`StepContribution::velocities`], 0 without any [length/time].
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

    /// A fast fragment and a thin foil do not limit the step unless they are near each other.
    #[test]
    fn the_step_goes_by_what_is_near() {
        let limits = Limits { thinnest: 0.01, skin: 1.0 };
        let step =
            |spread: f64, approach: f64, limits: Limits| contact_dt(spread, approach, limits);
        assert_eq!(step(0.0, 0.0, limits), f64::INFINITY);
        assert_eq!(step(2.0, 0.0, Limits { skin: 0.0, ..limits }), 0.01, "before the first search");
        assert_eq!(step(2.0, 0.0, limits), 0.5 * OF_SKIN, "no near pair");
        assert_eq!(step(2.0, 50.0, limits), 0.02, "a near pair");
        assert_eq!(step(2.0, 100.0, limits), 0.01, "the fastest and thinnest pair");
        let skin = skin_for(0.01, 2.0, 0.3).unwrap();
        let limits_of_it = Limits { thinnest: 0.01, skin };
        assert!((step(2.0, 0.0, limits_of_it) - 0.3).abs() < 1e-15, "a skin for this step");
        assert!(near_pairs_decide(0.01, skin) && !near_pairs_decide(0.5, 1.0));
        assert_eq!(skin_for(0.01, 2.0, 0.009), None, "no foil is passed in this step");
        assert_eq!(
            step(2.0, 0.0, Limits { thinnest: 0.5, ..limits }),
            0.5,
            "a skin that is small against the scales"
        );
    }

    #[test]
    fn of_ids_as_floats_the_first_is_the_largest() {
        let last = ElemId::placed((1 << 27) - 1, u64::from(u32::MAX)).unwrap();
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
