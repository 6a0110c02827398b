//! Which candidates are near enough to be looked at in every step. Most of what a search finds is not: its skin is there
//! so that it need not be made often. This list is made over from the search's, at a fraction of that skin, and leaves out
//! only what the local search would turn away in every step until then.

use crate::contact::geometry::{V3, is_beside, is_farther};
use crate::contact::local::reach;
use crate::contact::pairs::Memory;
use crate::contact::surface::Surface;
use crate::nodes::{Nodes, xyz};

/// Skin of this list as a fraction of the search's, and at most of the scale of the thinnest segment: a surface whose
/// segments are smaller than its thickness tells by little more whether it is folded over.
const SKIN: f64 = 0.5;
const THIN: f64 = 0.25;
/// Least motion in a step that it provides for, as a fraction of that scale, so that it need not be made over for nothing.
const STEP: f64 = 0.02;

/// A segment that a slave may touch.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Place in the surface's segments.
    pub segment: u32,
    /// Its nodes that a segment has on which the slave lies, bit by bit: of a shell next but one to the slave.
    pub ring: u8,
}

/// Candidates of each slave that are near.
#[derive(Debug, Default)]
pub struct Close {
    start: Vec<u32>,
    list: Vec<Candidate>,
    /// Relative motion of two nodes that it holds for, and of a step that begins then [length].
    pub skin: f64,
    pub step: f64,
}

impl Close {
    /// Candidates of the slave at `place` of the surface's slaves, segments ascending.
    pub fn of(&self, place: usize) -> &[Candidate] {
        &self.list[self.start[place] as usize..self.start[place + 1] as usize]
    }

    /// Bytes in use, spare room left out.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.start[..]) + size_of_val(&self.list[..])
    }

    /// Takes from what a search with skin `skin` found for each slave what is near, and all that the slave remembers.
    /// In the step that begins two nodes move by `step` against each other.
    pub fn renew<'a>(
        &mut self,
        nodes: &Nodes,
        surface: &Surface,
        (skin, step): (f64, f64),
        found: impl Fn(usize) -> &'a [u32],
        memory: impl Fn(usize) -> &'a [Memory],
    ) {
        self.skin = (SKIN * skin).min(THIN * surface.thinnest);
        self.step = (2.0 * step).max(STEP * surface.thinnest);
        self.start.clear();
        self.list.clear();
        let mut ring: Vec<u32> = Vec::new();
        for (place, &slave) in surface.slaves.iter().enumerate() {
            self.start.push(self.list.len() as u32);
            let found = found(place);
            if found.is_empty() {
                continue;
            }
            ring.clear();
            ring.extend(surface.around(place).flat_map(|s| s.nodes));
            let at = V3::from(xyz(&nodes.x[slave as usize]));
            for &g in found {
                let segment = &surface.segments[g as usize];
                let q = segment.corners(&nodes.x);
                let remembered = memory(place).iter().any(|m| m.is_of(segment.id));
                let limit = reach(surface, slave, segment, self.step) + self.skin;
                if !remembered && is_farther(&at, &q, limit) {
                    continue;
                }
                let shared = |k: usize| u8::from(!segment.is_solid() && ring.contains(&segment.nodes[k])) << k;
                let ring = (0..4).map(shared).sum();
                if remembered || ring == 0 || !is_beside(&at, &q, self.skin) {
                    self.list.push(Candidate { segment: g, ring });
                }
            }
        }
        self.start.push(self.list.len() as u32);
    }
}
