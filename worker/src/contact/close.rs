//! Which candidates are near enough to be looked at in every step. Most of what a search finds is not: its skin is there
//! so that it need not be made often. This list is made over from the search's, at a fraction of that skin, and leaves out
//! only what the local search would turn away in every step until then, as long as a slave that remembered nothing still does.

use crate::contact::geometry::{V3, is_apart, is_beside, is_farther};
use crate::contact::local::{is_known, reach, reach_of_old};
use crate::contact::pairs::Memory;
use crate::contact::surface::Surface;
use crate::nodes::{Nodes, xyz};

/// Skin of this list as a fraction of the search's, and at most of the scale of the thinnest segment and of a short edge: more would
/// not let small segments be told to lie beside each other.
const SKIN: f64 = 0.5;
const THIN: f64 = 0.5;
const SHORT: f64 = 0.125;
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

/// A slave and what it may touch, segments ascending.
pub struct Near<'a> {
    /// Its place in the surface's slaves.
    pub place: usize,
    /// Whether it remembered nothing when the list was made, which then leaves out what one with memories may meet.
    pub is_lone: bool,
    /// What it may touch.
    pub candidates: &'a [Candidate],
}

/// A slave's run in the list, which begins where the one before ends.
#[derive(Debug)]
struct Run {
    place: u32,
    end: u32,
    is_lone: bool,
}

/// Candidates that are near, by slave.
#[derive(Debug, Default)]
pub struct Close {
    runs: Vec<Run>,
    list: Vec<Candidate>,
    /// Relative motion of two nodes that it holds for, and of a step that begins then [length].
    pub skin: f64,
    pub step: f64,
}

impl Close {
    /// Forgets all of it.
    pub fn clear(&mut self) {
        self.runs.clear();
        self.list.clear();
    }

    /// Slaves that have candidates, ascending.
    pub fn near(&self) -> impl Iterator<Item = Near<'_>> {
        let mut start = 0;
        self.runs.iter().map(move |run| {
            let candidates = &self.list[start..run.end as usize];
            start = run.end as usize;
            Near { place: run.place as usize, is_lone: run.is_lone, candidates }
        })
    }

    /// Bytes in use, spare room left out.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.runs[..]) + size_of_val(&self.list[..])
    }

    /// Takes from what a search with skin `skin` found for each slave what is near, and farther for what the slave remembers.
    /// In the step that begins two nodes move by `step` against each other.
    pub fn renew<'a>(
        &mut self,
        nodes: &Nodes,
        surface: &Surface,
        (skin, step): (f64, f64),
        found: impl Fn(usize) -> &'a [u32],
        memory: impl Fn(usize) -> &'a [Memory],
    ) {
        self.skin = (SKIN * skin).min(THIN * surface.thinnest).min(SHORT * surface.short);
        self.step = (2.0 * step).max(STEP * surface.thinnest);
        self.clear();
        let mut ring = Vec::new();
        for place in 0..surface.slaves.len() {
            let (memory, before) = (memory(place), self.list.len());
            pick(nodes, surface, (place, found(place), memory), (self.skin, self.step), &mut ring, &mut self.list);
            if self.list.len() > before {
                let (place, end) = (place as u32, self.list.len() as u32);
                self.runs.push(Run { place, end, is_lone: memory.is_empty() });
            }
        }
    }
}

/// Appends to `near` what the slave at `place` may meet of what was `found` for it, while two nodes move by `skin` against each other
/// and in a step by `step` [length].
pub fn pick(
    nodes: &Nodes,
    surface: &Surface,
    (place, found, memory): (usize, &[u32], &[Memory]),
    (skin, step): (f64, f64),
    ring: &mut Vec<u32>,
    near: &mut Vec<Candidate>,
) {
    if found.is_empty() {
        return;
    }
    ring.clear();
    ring.extend(surface.around(place).flat_map(|s| s.nodes));
    let slave = surface.slaves[place];
    let at = V3::from(xyz(&nodes.x[slave as usize]));
    for &g in found {
        let segment = &surface.segments[g as usize];
        let q = segment.corners(&nodes.x);
        let limit = match is_known(segment, memory) {
            true => reach_of_old(surface, slave, segment),
            false => reach(surface, slave, segment, step),
        };
        if is_farther(&at, &q, limit + skin) {
            continue;
        }
        let shared = |k: usize| u8::from(!segment.is_solid() && ring.contains(&segment.nodes[k])) << k;
        let ring = (0..4).map(shared).sum();
        let is_turned_away = ring != 0 && is_beside(&at, &q, skin) || is_apart(&at, &q, limit + skin);
        if !is_turned_away {
            near.push(Candidate { segment: g, ring });
        }
    }
}
