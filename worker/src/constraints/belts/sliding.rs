//! Sliding of belts in a step, at the positions of the present time: rings and retractors take
//! turns until nothing moves any more.

use super::curve::TensionCurve;
use super::path::{BeltSide, PassedNode, PathState};
use super::slip::{BeltSpan, out_of_retractor, pulled_in, through_ring};
use super::{BeltMotions, BeltState};
use crumple_proto::belt::BeltSystem;
use crumple_proto::ids::NodeId;

/// Largest number of turns. Rings with several segments between them need two.
const TURNS: usize = 40;
/// Part of the length of a segment from which on a slip needs another turn.
const SETTLED: f64 = 1e-12;

/// Length over the smallest one up to which a segment has that: above 1 by round-off.
const CLOSE: f64 = 1.0 + 1e-9;

/// A node that has passed a ring, or has gone into a retractor or come out of it.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// The ring or retractor.
    pub anchor: NodeId,
    /// The node.
    pub node: NodeId,
    /// Its momentum less that before [mass length/time].
    pub impulse: [f64; 3],
}

/// Result of the sliding of a step, besides the lengths of segments.
#[derive(Clone, Debug, Default)]
pub struct Slid {
    /// Nodes that have passed, in their order.
    pub passages: Vec<Passage>,
    /// Work of pretensioners [energy].
    pub supplied: f64,
}

/// Belts that slide in a step.
pub struct Sliding<'a> {
    /// The belts of the job.
    pub job: &'a BeltSystem,
    /// Curves of the laws.
    pub laws: &'a [TensionCurve],
    /// Curves of the retractors.
    pub reels: &'a [TensionCurve],
    /// Motions of nodes; those that pass get new ones.
    pub motions: &'a mut BeltMotions,
    /// Present time, and the step to it [time].
    pub times: [f64; 2],
    /// Result.
    pub slid: Slid,
}

impl<'a> Sliding<'a> {
    /// Lets the belts slide. `pulled` is for each retractor the length that its pretensioner pulls
    /// in, with the limit of its tension; `None` if none works.
    pub fn slide(&mut self, state: &mut BeltState, pulled: &[Option<[f64; 2]>]) {
        let slips: Vec<f64> = state.rings.iter().map(|ring| ring.slip).collect();
        let pull_outs: Vec<f64> = state.retractors.iter().map(|r| r.pull_out).collect();
        let mut pulled = pulled.to_vec();
        let segments = state.paths.iter_mut().flat_map(|path| &mut path.segments);
        segments.for_each(|segment| segment.fed = 0.0);
        for _ in 0..TURNS {
            let mut settled = true;
            for (ring, before) in slips.iter().enumerate() {
                settled &= self.turn_ring(state, ring, *before);
            }
            for (retractor, before) in pull_outs.iter().enumerate() {
                settled &= self.turn_retractor(state, retractor, &mut pulled[retractor], *before);
            }
            if settled {
                break;
            }
        }
        let [_, step] = self.times;
        let rate = |moved: f64| if step > 0.0 { moved / step } else { 0.0 };
        state.rings.iter_mut().zip(&slips).for_each(|(r, s)| r.rate = rate(r.slip - s));
        let reels = state.retractors.iter_mut().zip(&pull_outs);
        reels.for_each(|(r, before)| r.rate = rate(r.pull_out - before));
    }

    /// Returns a segment as its neighbours see it, and its smallest length.
    fn span(&self, path: &PathState, index: usize, segment: usize) -> (BeltSpan<'a>, f64) {
        let law = self.job.paths[index].segments[segment].law;
        let state = &path.segments[segment];
        let span = BeltSpan {
            curve: &self.laws[law],
            distance: path.distance(segment, self.motions),
            length: state.length,
            largest: state.largest,
        };
        (span, self.job.laws[law].min_length)
    }

    /// Returns the rate of a length that has moved in this step [length/time].
    fn rate(&self, moved: f64) -> f64 {
        if self.times[1] > 0.0 { moved / self.times[1] } else { 0.0 }
    }

    /// Lets belt slide through a ring, whose slip was `before` when the step began. Returns true if
    /// none did.
    fn turn_ring(&mut self, state: &mut BeltState, ring: usize, before: f64) -> bool {
        let job = &self.job.rings[ring];
        let (path, own) = (&mut state.paths[job.path], &mut state.rings[ring]);
        let place = path.place(job.node);
        let (Some(first), Some(second)) =
            (BeltSide::Before.segment(place), BeltSide::After.segment(place))
        else {
            return true;
        };
        let sides = [first, second].map(|segment| self.span(path, job.path, segment));
        let tensions = sides.map(|(span, _)| span.pull(0.0));
        own.tensions = tensions;
        if self.times[0] >= job.lock_time || tensions == [0.0; 2] {
            return true;
        }
        let [fast, rest] = job.friction;
        let friction = fast + (rest - fast) * (-job.decay * own.rate.abs()).exp();
        let ratio = (friction * self.wrap(path, place)).exp();
        let tight = usize::from(tensions[1] > tensions[0]);
        let ([(to, _), (from, least)], short) = match tight {
            0 => ([sides[0], sides[1]], BeltSide::After),
            _ => ([sides[1], sides[0]], BeltSide::Before),
        };
        let moved = through_ring(&to, &from, ratio, least);
        let is_short = from.length - moved <= CLOSE * least;
        let after = [to.pull(moved), from.pull(-moved)];
        let (into, out) = if tight == 0 { (first, second) } else { (second, first) };
        let length = from.length;
        own.slip += if tight == 0 { moved } else { -moved };
        // The tensions before are those of positions for which belt has not moved yet.
        own.dissipated += moved * (after[0] - after[1]).max(0.0);
        own.tensions = if tight == 0 { after } else { [after[1], after[0]] };
        for (segment, moved) in [(into, moved), (out, -moved)] {
            path.segments[segment].length += moved;
            path.segments[segment].fed += moved;
        }
        let beyond = is_short && after[0] > ratio * after[1];
        if beyond {
            let rate = self.rate((own.slip - before).abs());
            if let Some(put) = path.pass((place, short), least, rate, self.motions) {
                self.book(job.node, put);
                return false;
            }
        }
        moved <= SETTLED * length
    }

    /// Lets belt out of a retractor or takes it in; its pull-out was `before` when the step began.
    /// Returns true if nothing moved.
    fn turn_retractor(
        &mut self,
        state: &mut BeltState,
        retractor: usize,
        pulled: &mut Option<[f64; 2]>,
        before: f64,
    ) -> bool {
        let job = &self.job.retractors[retractor];
        let (path, own) = (&mut state.paths[job.path], &mut state.retractors[retractor]);
        let place = path.place(job.node);
        let open = if job.before { BeltSide::After } else { BeltSide::Before };
        let Some(mouth) = open.segment(place).filter(|&s| s < path.segments.len()) else {
            return true;
        };
        let (span, least) = self.span(path, job.path, mouth);
        let (moved, wants_more) = match pulled {
            Some([wanted, limit]) => {
                let moved = pulled_in(&span, *wanted, *limit, least);
                *wanted -= moved;
                (-moved, *wanted > 0.0 && span.pull(-moved) < *limit)
            }
            None => {
                let curve = &self.reels[retractor];
                let moved = out_of_retractor(&span, |more| own.holds(curve, more), least);
                (moved, own.holds(curve, moved) > span.pull(moved))
            }
        };
        let before_move = std::mem::replace(&mut own.tension, span.pull(moved));
        if pulled.is_some() {
            own.pull_out += moved;
            self.slid.supplied -= 0.5 * (before_move + own.tension) * moved;
        } else {
            own.advance(&self.reels[retractor], moved);
        }
        let length = span.length;
        path.segments[mouth].length += moved;
        path.segments[mouth].fed += moved;
        if length + moved <= CLOSE * least && wants_more {
            if let Some(node) = path.wind_up(place, open) {
                let to = self.motions[&job.node];
                self.book(job.node, PassedNode { node, x: to.x, v: to.v });
                return false;
            }
        } else {
            let rate = self.rate(own.pull_out - before);
            let put = path.unwind((place, open), (least, job.fed_length), rate, self.motions);
            if let Some(put) = put {
                self.book(job.node, put);
                return false;
            }
        }
        moved.abs() <= SETTLED * length
    }

    /// Returns the angle by which a belt turns at a node.
    fn wrap(&self, path: &PathState, place: usize) -> f64 {
        let at = |n: usize| self.motions[&path.nodes[n].0].x;
        let (into, out) = (at(place) - at(place - 1), at(place + 1) - at(place));
        into.cross(&out).norm().atan2(into.dot(&out))
    }

    /// Moves a node that has passed.
    fn book(&mut self, anchor: NodeId, put: PassedNode) {
        let motion = self.motions.get_mut(&put.node).expect("a node of a belt");
        let mass = if motion.inv_mass > 0.0 { 1.0 / motion.inv_mass } else { 0.0 };
        let impulse = ((put.v - motion.v) * mass).into();
        (motion.x, motion.v) = (put.x, put.v);
        self.slid.passages.push(Passage { anchor, node: put.node, impulse });
    }
}
