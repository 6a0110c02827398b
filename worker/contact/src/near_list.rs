//! Near list: candidates that are close enough to be examined in every step. Most candidates of
//! a global search are not, because its skin is chosen so that searches are rare. The near list
//! is made again more often, with a fraction of that skin. It leaves out only candidates that
//! the local search would reject in every step until then. The candidates of a slave are selected
//! again when it gets its first history and could touch solids, because only slaves with history
//! touch some of their faces.
//!
//! A candidate that is out of reach in a step is left out until nodes have moved far enough
//! against each other to bring it within reach ([`Waiting`]).

use crate::candidates::{CandidatePair, PairBatch};
use crate::geometry::Sphere;
use crate::kernels::{distance_bound, is_in, projects_outside};
use crate::pairs::PairHistory;
use crate::reach::{has_history, reach, reach_of_old};
use crate::surface::Surface;
use crate::waiting::Waiting;
use crumple_fem::nodes::Nodes;
use crumple_math::lanes::{LANES, Lane, Real};
use crumple_math::row::{V3, xyz};
use crumple_math::threads;
use std::ops::Range;

/// Skin of the near list as a fraction of the skin of the search. It is at most [`THIN`] of the
/// scale of the thinnest segment and [`SHORT`] of the length of a short edge: with a larger
/// skin, a slave could not be shown to project outside small segments.
const SKIN: f64 = 0.5;
const THIN: f64 = 0.5;
const SHORT: f64 = 0.125;
/// Least motion per step that the near list allows, as a fraction of the scale of the thinnest
/// segment, so that it is not made again without need.
const STEP: f64 = 0.02;
/// Number of collected candidates from which a filter examines them in batches.
const HELD: usize = 256;
/// Least number of slaves whose candidates a thread selects at a time.
const PIECE: usize = 512;

/// Candidates that are near.
#[derive(Debug, Default)]
pub struct NearList {
    /// Candidates by slave, ascending, and for each slave by segment.
    pub list: Vec<CandidatePair>,
    /// Candidates that are out of reach.
    pub waiting: Waiting,
    /// Largest relative motion of two nodes for which the list is valid, and largest relative
    /// motion in a step that begins then [length].
    pub skin: f64,
    pub step: f64,
}

impl NearList {
    /// Returns the bytes in use, without spare capacity.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.list[..]) + self.waiting.bytes()
    }

    /// Removes all candidates.
    pub fn clear(&mut self) {
        self.list.clear();
        self.waiting.restart(0);
    }

    /// Filters the candidates of the last global search, which had the skin `skin` [length], to
    /// those within reach of each slave. Slaves with pair history have a larger reach. `step` is
    /// the relative motion of two nodes in the step that begins [length]. `found` and `memory`
    /// return the candidate segments and the pair histories of a slave by its index. `spheres`
    /// are the bounding spheres of the segments.
    pub fn renew<'a>(
        &mut self,
        (nodes, surface, spheres): (&Nodes, &Surface, &[Sphere]),
        (skin, step): (f64, f64),
        found: impl Fn(usize) -> &'a [u32] + Sync,
        memory: impl Fn(usize) -> &'a [PairHistory] + Sync,
    ) {
        self.skin = (SKIN * skin).min(THIN * surface.thinnest).min(SHORT * surface.short);
        self.step = (2.0 * step).max(STEP * surface.thinnest);
        self.clear();
        let limits = (self.skin, self.step);
        let of_range = |range: Range<usize>| {
            let mut near = Vec::new();
            let mut filter = CandidateFilter::new(nodes, surface, limits, |g| spheres[g]);
            for place in range {
                filter.add_slave(place, found(place), memory(place), &mut near);
            }
            filter.finish(&mut near);
            near
        };
        let pieces = threads::ranges(surface.slaves.len(), PIECE);
        self.list = threads::joined(threads::map(pieces, of_range));
        self.waiting.restart(self.list.len());
    }

    /// Selects the candidates of the slaves at these indices again, ascending: they have their
    /// first history. `found` and `memory` are as in [`Self::renew`].
    pub fn renew_slaves<'a>(
        &mut self,
        (nodes, surface): (&Nodes, &Surface),
        slaves: &[u32],
        found: impl Fn(usize) -> &'a [u32],
        memory: impl Fn(usize) -> &'a [PairHistory],
    ) {
        let is_solid = |&g: &u32| surface.segments[g as usize].is_solid();
        let could_touch_solids = |i: &&u32| found(**i as usize).iter().any(is_solid);
        let mut slaves = slaves.iter().filter(could_touch_solids).peekable();
        if slaves.peek().is_none() {
            return;
        }
        let sphere = |g: usize| Sphere::around(&surface.segments[g].corners(&nodes.x));
        let mut picker = CandidateFilter::new(nodes, surface, (self.skin, self.step), sphere);
        let (mut all, mut rest) = (Vec::with_capacity(self.list.len()), 0);
        for &i in slaves {
            let kept = self.list.partition_point(|n| n.slave_index < i);
            all.extend_from_slice(&self.list[rest..kept]);
            rest = self.list.partition_point(|n| n.slave_index <= i);
            picker.add_slave(i as usize, found(i as usize), memory(i as usize), &mut all);
            picker.finish(&mut all);
        }
        all.extend_from_slice(&self.list[rest..]);
        self.waiting.restart(all.len());
        self.list = all;
    }
}

/// Selects the candidates that slaves may touch while two nodes move by `skin` relative to each
/// other, and by `step` in a step [length].
pub struct CandidateFilter<'a, F> {
    nodes: &'a Nodes,
    surface: &'a Surface,
    skin: f64,
    step: f64,
    /// Function that returns the bounding sphere of a segment by its index.
    sphere: F,
    /// Nodes of the segments around the slave.
    ring: Vec<u32>,
    /// Candidates that are not examined in batches yet, with their reach including the skin
    /// [length].
    held: Vec<(CandidatePair, f64)>,
}

impl<'a, F: Fn(usize) -> Sphere> CandidateFilter<'a, F> {
    /// Creates a filter without candidates.
    pub fn new(
        nodes: &'a Nodes,
        surface: &'a Surface,
        (skin, step): (f64, f64),
        sphere: F,
    ) -> Self {
        Self { nodes, surface, skin, step, sphere, ring: Vec::new(), held: Vec::new() }
    }

    /// Adds the candidate segments `found` of the slave at index `place`. Those that are near
    /// are appended to `near`, now or in [`Self::finish`], which must be called after the last
    /// slave.
    pub fn add_slave(
        &mut self,
        place: usize,
        found: &[u32],
        memory: &[PairHistory],
        near: &mut Vec<CandidatePair>,
    ) {
        if found.is_empty() {
            return;
        }
        let surface = self.surface;
        self.ring.clear();
        self.ring.extend(surface.around(place).flat_map(|s| s.nodes));
        let slave = surface.slaves[place];
        let at = V3::from(xyz(&self.nodes.x[slave as usize]));
        for &g in found {
            let segment = &surface.segments[g as usize];
            let reach = match has_history(segment, memory) {
                true => reach_of_old(surface, slave, segment),
                false => reach(surface, slave, segment, self.step),
            };
            if (self.sphere)(g as usize).is_farther(&at, reach + self.skin) {
                continue;
            }
            let shared = |k: usize| {
                u8::from(!segment.is_solid() && self.ring.contains(&segment.nodes[k])) << k
            };
            let ring: u8 = (0..4).map(shared).sum();
            if ring != 0 && surface.has_lines && segment.is_line() {
                continue; // a line cannot fold over
            }
            let of =
                CandidatePair { slave_index: place as u32, segment: g, shared_node_mask: ring };
            self.held.push((of, reach + self.skin));
        }
        if self.held.len() >= HELD {
            self.finish(near);
        }
    }

    /// Examines all collected candidates and appends those that are near.
    pub fn finish(&mut self, near: &mut Vec<CandidatePair>) {
        for some in self.held.chunks(LANES) {
            let four = PairBatch::gather(self.surface, some, |s| s.0);
            let (at, q) = (four.slaves(&self.nodes.x), four.corners(&self.nodes.x));
            let reach = Lane::new(std::array::from_fn(|lane| some[lane.min(some.len() - 1)].1));
            let (apart, outside) =
                (distance_bound(at, &q).gt(reach), projects_outside(at, &q, self.skin));
            for (lane, &(of, _)) in some.iter().enumerate() {
                if !(is_in::<Lane>(apart, lane)
                    || of.shared_node_mask != 0 && is_in::<Lane>(outside, lane))
                {
                    near.push(of);
                }
            }
        }
        self.held.clear();
    }
}
