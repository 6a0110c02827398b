//! Which candidates are near enough to be looked at in every step. Most of what a search finds is
//! not: its skin is there so that it need not be made often. This list is made over from the
//! search's, at a fraction of that skin, and leaves out only what the local search would turn away
//! in every step until then, as long as a slave that remembered nothing still does.

use crate::contact::candidates::{CandidatePair, PairBatch};
use crate::contact::geometry::{Sphere, V3};
use crate::contact::kernels::{are_separated, is_in, projects_outside};
use crate::contact::local_search::{has_history, reach, reach_of_old};
use crate::contact::pairs::PairHistory;
use crate::contact::surface::Surface;
use crate::math::lanes::{LANES, Lane};
use crate::nodes::{Nodes, xyz};

/// Skin of this list as a fraction of the search's, and at most of the scale of the thinnest
/// segment and of a short edge: more would not let small segments be told to lie beside each other.
const SKIN: f64 = 0.5;
const THIN: f64 = 0.5;
const SHORT: f64 = 0.125;
/// Least motion in a step that it provides for, as a fraction of that scale, so that it need not be
/// made over for nothing.
const STEP: f64 = 0.02;
/// With as many candidates a picker looks at them side by side.
const HELD: usize = 256;

/// Candidates that are near.
#[derive(Debug, Default)]
pub struct NearList {
    /// By slave, ascending, and of a slave by segment.
    pub list: Vec<CandidatePair>,
    /// Relative motion of two nodes that it holds for, and of a step that begins then [length].
    pub skin: f64,
    pub step: f64,
}

impl NearList {
    /// Bytes in use, spare room left out.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.list[..])
    }

    /// Takes from what a search with skin `skin` found for each slave what is near, and farther for
    /// what the slave remembers. In the step that begins two nodes move by `step` against each
    /// other. `spheres` are around the segments.
    pub fn renew<'a>(
        &mut self,
        (nodes, surface, spheres): (&Nodes, &Surface, &[Sphere]),
        (skin, step): (f64, f64),
        found: impl Fn(usize) -> &'a [u32],
        memory: impl Fn(usize) -> &'a [PairHistory],
    ) {
        self.skin = (SKIN * skin).min(THIN * surface.thinnest).min(SHORT * surface.short);
        self.step = (2.0 * step).max(STEP * surface.thinnest);
        self.list.clear();
        let mut picker =
            CandidateFilter::new(nodes, surface, (self.skin, self.step), |g| spheres[g]);
        for place in 0..surface.slaves.len() {
            picker.add_slave(place, found(place), memory(place), &mut self.list);
        }
        picker.finish(&mut self.list);
    }
}

/// Picks what slaves may meet of what was found for them, while two nodes move by `skin` against
/// each other and in a step by `step` [length].
pub struct CandidateFilter<'a, F> {
    nodes: &'a Nodes,
    surface: &'a Surface,
    skin: f64,
    step: f64,
    /// The sphere around a segment.
    sphere: F,
    /// Nodes of the segments on which a slave lies.
    ring: Vec<u32>,
    /// What is not yet looked at side by side, with the reach, skin and all [length].
    held: Vec<(CandidatePair, f64)>,
}

impl<'a, F: Fn(usize) -> Sphere> CandidateFilter<'a, F> {
    /// Nothing is looked at yet.
    pub fn new(
        nodes: &'a Nodes,
        surface: &'a Surface,
        (skin, step): (f64, f64),
        sphere: F,
    ) -> Self {
        Self { nodes, surface, skin, step, sphere, ring: Vec::new(), held: Vec::new() }
    }

    /// Looks at what was `found` for the slave at `place`; `near` gets what is, here or in
    /// [`Self::finish`], which has to follow the last.
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
            let of = CandidatePair {
                slave_index: place as u32,
                segment: g,
                shared_node_mask: ring,
                has_no_history: memory.is_empty(),
            };
            self.held.push((of, reach + self.skin));
        }
        if self.held.len() >= HELD {
            self.finish(near);
        }
    }

    /// Looks at all that is left.
    pub fn finish(&mut self, near: &mut Vec<CandidatePair>) {
        for some in self.held.chunks(LANES) {
            let four = PairBatch::of(self.surface, some, |s| s.0);
            let (at, q) = (four.slaves(&self.nodes.x), four.corners(&self.nodes.x));
            let reach = Lane::new(std::array::from_fn(|lane| some[lane.min(some.len() - 1)].1));
            let (apart, beside) =
                (are_separated(at, &q, reach), projects_outside(at, &q, self.skin));
            for (lane, &(of, _)) in some.iter().enumerate() {
                if !(is_in::<Lane>(apart, lane)
                    || of.shared_node_mask != 0 && is_in::<Lane>(beside, lane))
                {
                    near.push(of);
                }
            }
        }
        self.held.clear();
    }
}
