//! Candidates of the slaves: the segments that each slave could touch before the next global
//! search.

use crate::diagnostics::search_record::SearchRecord;
use crate::geometry::Sphere;
use crate::reach::reach_of_old;
use crate::search::{Search, accepted};
use crate::search_reach;
use crate::surface::Surface;
use crate::surroundings::Exclusions;
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};
use crumple_math::threads;

/// Least number of segments that a thread examines at a time.
const PIECE: usize = 1024;

/// Candidates in the order of the surface's slaves.
#[derive(Default)]
pub struct SlaveCandidates {
    /// Start of each slave's run in `segments`, and their end; empty before a search.
    start: Vec<u32>,
    /// Segments; ascending for each slave.
    segments: Vec<u32>,
}

impl SlaveCandidates {
    /// Removes all. The next call of [`Self::search`] finds them again.
    pub fn clear(&mut self) {
        self.start.clear();
    }

    /// Returns true if a search has found the candidates of the present surface.
    pub fn are_known(&self) -> bool {
        !self.start.is_empty()
    }

    /// Returns the segments that the slave with index `i` could touch.
    #[inline]
    pub fn segments_of(&self, i: usize) -> &[u32] {
        &self.segments[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Returns the number of candidates.
    pub fn count(&self) -> usize {
        self.segments.len()
    }

    /// Returns the number of candidates of each slave.
    pub fn counts(&self) -> impl Iterator<Item = usize> + '_ {
        self.start.windows(2).map(|run| (run[1] - run[0]) as usize)
    }

    /// Returns the bytes in use, without spare capacity.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.start[..]) + size_of_val(&self.segments[..])
    }

    /// Finds the segments that each slave could touch before it moves by more than `skin`
    /// [length]. `spheres` surround the segments.
    pub fn search(
        &mut self,
        (surface, spheres, nodes, joined): (&Surface, &[Sphere], &Nodes, &dyn Exclusions),
        (method, skin): (Search, f64),
        record: &mut SearchRecord,
    ) {
        self.segments = Vec::new(); // freed first: memory use peaks in the search
        let found = {
            let (largest, added) = (surface.largest_scale(), surface.shift_reach() + skin);
            let bounds = |i: usize| {
                let g = &surface.segments[i];
                let reach = search_reach(&surface.interfaces, g.scale, largest);
                g.bounds(&nodes.x, reach + added)
            };
            let boxes = threads::collect(surface.segments.len(), PIECE, bounds);
            let points: Vec<[f64; 3]> =
                surface.slaves.iter().map(|&i| xyz(&nodes.x[i as usize])).collect();
            accepted(method, &boxes, &points, |g, p| {
                let (segment, slave) = (&surface.segments[g as usize], surface.slaves[p as usize]);
                let reach = reach_of_old(surface, slave, segment) + skin;
                let is_far = spheres[g as usize].is_farther(&V3::from(points[p as usize]), reach);
                let touches = || surface.interface(p as usize, segment).is_some();
                let is_other =
                    !segment.nodes.contains(&slave) && !joined.excludes(slave, &segment.nodes);
                !is_far && is_other && touches()
            })
        };
        for &[g, p] in &found {
            record.near(surface.slaves[p as usize], &surface.segments[g as usize]);
        }
        self.sort_by_slave(surface.slaves.len(), &found);
    }

    /// Sorts segments and slaves, segments ascending, to segments by slave. Segments stay
    /// ascending.
    fn sort_by_slave(&mut self, slaves: usize, found: &[[u32; 2]]) {
        self.start.clear();
        self.start.resize(slaves + 1, 0);
        found.iter().for_each(|&[_, p]| self.start[p as usize + 1] += 1);
        for i in 0..slaves {
            self.start[i + 1] += self.start[i];
        }
        let mut next = self.start.clone();
        self.segments.resize(found.len(), 0);
        for &[g, p] in found {
            self.segments[next[p as usize] as usize] = g;
            next[p as usize] += 1;
        }
    }
}
