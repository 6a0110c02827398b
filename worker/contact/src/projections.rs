//! Finds the near segments within reach of their slaves in a step and projects the slaves onto
//! them, in batches over all slaves.

use crate::candidates::{CandidatePair, PairBatch};
use crate::geometry::Nearest;
use crate::kernels::{distance_bound, is_in, project, projects_outside};
use crate::near_list::NearList;
use crate::pairs::PairHistory;
use crate::reach::{has_history, reach, reach_of_old};
use crate::surface::Surface;
use crumple_fem::nodes::Nodes;
use crumple_math::lanes::{LANES, Lane, Real};
use crumple_math::row::{V3, xyz};
use crumple_math::threads;
use std::ops::Range;

/// A candidate pair that may touch in the step, with its projection.
#[derive(Debug)]
pub struct ProjectedPair {
    /// The candidate pair.
    pub of: CandidatePair,
    /// Largest relative motion of the slave and a node of the segment in the step, without
    /// contact [length].
    pub step: f64,
    /// Nearest point of the segment to the slave.
    pub near: Nearest,
}

/// Candidates of a step that are due, and their projections.
#[derive(Debug, Default)]
pub struct ProjectedPairs {
    /// Indices of the candidates that may be within reach.
    due: Vec<u32>,
    /// Buffers of the threads.
    pieces: Vec<Piece>,
}

/// Candidates that a thread examines: all of some slaves that are due.
#[derive(Debug, Default)]
struct Piece {
    /// Those out of reach, and the path of the nodes up to which they are [length].
    deferred: Vec<(u32, f64)>,
    /// Candidate pairs within reach, with their largest relative motion [length].
    reached: Vec<(CandidatePair, f64)>,
    /// Projected pairs in the order of the candidates.
    projected: Vec<ProjectedPair>,
}

/// Least number of candidates that a thread examines at a time.
const PIECE: usize = 512;

impl ProjectedPairs {
    /// Returns the bytes in use, without spare capacity.
    pub fn bytes(&self) -> usize {
        let of_piece = |p: &Piece| {
            size_of_val(&p.deferred[..])
                + size_of_val(&p.reached[..])
                + size_of_val(&p.projected[..])
        };
        size_of_val(&self.due[..]) + self.pieces.iter().map(of_piece).sum::<usize>()
    }

    /// Projects the candidates of the near list that are within reach, and calls `then` with the
    /// projected pairs of some slaves at a time, slaves ascending. Returns the results of `then`.
    /// `path` is the path of the nodes since the list was made [length]. `memory` returns the
    /// pair histories of a slave by its index; `dt` is the step size [time].
    pub fn project<'a, T: Send>(
        &mut self,
        (nodes, surface): (&Nodes, &Surface),
        (near, path): (&mut NearList, f64),
        memory: impl Fn(u32) -> &'a [PairHistory] + Sync,
        dt: f64,
        then: impl Fn(&[ProjectedPair]) -> T + Sync,
    ) -> Vec<T> {
        near.waiting.find_due(path, &mut self.due);
        let mut rest = &self.due[..];
        let ranges = threads::ranges(rest.len(), PIECE);
        self.pieces.resize_with(ranges.len(), Piece::default);
        let slave_of = |i: u32| near.list[i as usize].slave_index;
        let cut = |(piece, range): (_, Range<usize>)| {
            let mut end = range.len().min(rest.len());
            while (1..rest.len()).contains(&end) && slave_of(rest[end]) == slave_of(rest[end - 1]) {
                end += 1;
            }
            let due;
            (due, rest) = rest.split_at(end);
            (due, piece)
        };
        let pieces = self.pieces.iter_mut().zip(ranges).map(cut).collect();
        let list = &*near;
        let results = threads::map(pieces, |(due, piece): (&[u32], &mut Piece)| {
            piece.project((nodes, surface), (list, path), due, &memory, dt);
            then(&piece.projected)
        });
        let deferred = self.pieces.iter().flat_map(|p| &p.deferred);
        deferred.for_each(|&(i, until)| near.waiting.defer(i, until));
        near.waiting.update_blocks(&self.due);
        results
    }
}

impl Piece {
    /// Projects the candidates `due` that are within reach.
    fn project<'a>(
        &mut self,
        (nodes, surface): (&Nodes, &Surface),
        (near, path): (&NearList, f64),
        due: &[u32],
        memory: impl Fn(u32) -> &'a [PairHistory],
        dt: f64,
    ) {
        self.deferred.clear();
        self.reached.clear();
        self.projected.clear();
        for some in due.chunks(LANES) {
            self.retain_reached(nodes, surface, (near, path), some, &memory, dt);
        }
        for some in self.reached.chunks(LANES) {
            let four = PairBatch::gather(surface, some, |s| s.0);
            let found = project(four.slaves(&nodes.x), &four.corners(&nodes.x), four.triangles());
            for (lane, &(of, step)) in some.iter().enumerate() {
                let segment = four.segment[lane];
                let near = match surface.has_lines && segment.is_line() {
                    true => segment
                        .nearest(&V3::from(xyz(&nodes.x[four.slave[lane] as usize])), &nodes.x),
                    false => Nearest::from_lane(&found, lane),
                };
                self.projected.extend(near.map(|near| ProjectedPair { of, step, near }));
            }
        }
    }

    /// Selects pairs by cheap tests before the projection: the slave must be within reach of the
    /// segment. If the segment must fold over to be touched, the slave must not project outside
    /// the segment. `some` are indices of candidates; those out of reach are not due before the
    /// nodes have moved by what is missing.
    fn retain_reached<'a>(
        &mut self,
        nodes: &Nodes,
        surface: &Surface,
        (near, path): (&NearList, f64),
        some: &[u32],
        memory: impl Fn(u32) -> &'a [PairHistory],
        dt: f64,
    ) {
        let four = PairBatch::gather(surface, some, |&i| near.list[i as usize]);
        let (at, q) = (four.slaves(&nodes.x), four.corners(&nodes.x));
        let v = four.slaves(&nodes.v_next);
        let apart = four.corners(&nodes.v_next).map(|of| (of - v).square());
        let step = (apart[0].max(apart[1]).max(apart[2].max(apart[3])).sqrt() * Lane::splat(dt))
            .to_array();
        let [new, old]: [[f64; LANES]; 2] = [
            std::array::from_fn(|lane| {
                reach(surface, four.slave[lane], four.segment[lane], step[lane])
            }),
            std::array::from_fn(|lane| reach_of_old(surface, four.slave[lane], four.segment[lane])),
        ];
        let distance = distance_bound(at, &q);
        let (beyond_new, beyond_old) = (distance.gt(Lane::new(new)), distance.gt(Lane::new(old)));
        let distance = distance.to_array();
        let ring = some.iter().any(|&i| near.list[i as usize].shared_node_mask != 0);
        let is_turned_away = if ring { projects_outside(at, &q, 0.0) } else { Lane::splat(0.0) };
        for (lane, &i) in some.iter().enumerate() {
            let (of, segment) = (near.list[i as usize], four.segment[lane]);
            let goes_over =
                |m: &PairHistory| segment.is_solid() && surface.is_adjacent(m.segment(), segment);
            let is_kept =
                || memory(of.slave_index).iter().any(|m| m.is_of(segment.id) || goes_over(m));
            let reaches =
                !is_in::<Lane>(beyond_new, lane) || !is_in::<Lane>(beyond_old, lane) && is_kept();
            if !reaches {
                let limit = match has_history(segment, memory(of.slave_index)) {
                    true => old[lane],
                    false => reach(surface, four.slave[lane], segment, near.step),
                };
                self.deferred.push((i, path + (distance[lane] - limit)));
            } else if !(of.shared_node_mask != 0 && is_in::<Lane>(is_turned_away, lane)) {
                self.reached.push((of, step[lane]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pairs::{Pair, PairKey};
    use crate::surface::{NOT_LOCAL, Segment};
    use crumple_fem::testing::nodes_at;
    use crumple_proto::ids::{NodeId, SegmentId};

    /// Returns six nodes on a bent strip of a quad, a triangle and a solid's face, and four
    /// slaves above it with their velocities.
    fn scene() -> (Nodes, Surface) {
        let strip = [
            [0.0, 0.0, 0.0],
            [1.0, 0.1, 0.0],
            [1.1, 1.0, 0.1],
            [0.0, 1.0, 0.0],
            [2.0, 0.0, -0.2],
            [2.1, 1.0, 0.0],
        ];
        let above = [[0.4, 0.4, 0.1], [0.95, 0.5, 0.12], [1.6, 0.3, 0.05], [0.2, 1.1, 0.1]];
        let mut nodes = nodes_at(&[&strip[..], &above[..]].concat());
        nodes.v_next[6..]
            .iter_mut()
            .zip(1..)
            .for_each(|(v, k)| *v = [0.1, 0.0, -0.05 * f64::from(k), 0.0]);
        let segment = |(i, (nodes, half)): (usize, ([u32; 4], f64))| Segment {
            id: SegmentId(8 * (i as u64 + 1)),
            nodes,
            behind: [NOT_LOCAL; 4],
            half_thickness: half,
            offset: 0.0,
            scale: 0.1,
            part: 0,
            own: true,
            searched: true,
        };
        let faces = [([0, 1, 2, 3], 0.1), ([1, 4, 2, 2], 0.1), ([2, 4, 5, 1], 0.0)];
        let mut surface = Surface {
            segments: faces.into_iter().enumerate().map(segment).collect(),
            slaves: (6..10).collect(),
            node_half: vec![0.1; 10],
            node_scale: vec![0.1; 10],
            ..Surface::default()
        };
        surface.link_faces(10);
        (nodes, surface)
    }

    /// The projection of a pair is the same for any other pairs in its batch and for any batch
    /// size.
    #[test]
    fn a_pair_meets_in_company_where_it_meets_alone() {
        let (nodes, surface) = scene();
        let past =
            Pair::new(PairKey::of_node(NodeId(8), SegmentId(16)), SegmentId(16), [7, 1, 4, 2, 2])
                .to_history();
        let remembered = [past];
        let memory = |place: u32| if place == 1 { &remembered[..] } else { &[] };
        let asked: Vec<CandidatePair> = (0..4)
            .flat_map(|place| (0..3).map(move |segment| (place, segment)))
            .map(|(place, segment)| CandidatePair {
                slave_index: place,
                segment,
                shared_node_mask: (place == 3) as u8,
            })
            .collect();
        let meet = |asked: &[CandidatePair]| {
            let mut meetings = ProjectedPairs::default();
            let mut near = NearList { list: asked.to_vec(), ..NearList::default() };
            near.waiting.restart(asked.len());
            let result = |m: &ProjectedPair| {
                let numbers =
                    m.near.shape.into_iter().chain([m.step]).chain(m.near.point.iter().copied());
                let bits: Vec<u64> =
                    numbers.chain(m.near.normal.iter().copied()).map(f64::to_bits).collect();
                (m.of.slave_index, m.of.segment, m.near.rim, bits)
            };
            let results = |projected: &[ProjectedPair]| projected.iter().map(result).collect();
            let found: Vec<Vec<_>> =
                meetings.project((&nodes, &surface), (&mut near, 0.0), memory, 1.0, results);
            found.concat()
        };
        let alone: Vec<_> = asked.iter().flat_map(|n| meet(std::slice::from_ref(n))).collect();
        assert!(
            (4..asked.len()).contains(&alone.len()),
            "only some candidates touch: {}",
            alone.len()
        );
        for company in [1, 3, 5, 7, 12] {
            let together: Vec<_> = asked.chunks(company).flat_map(&meet).collect();
            assert_eq!(together, alone, "in batches of {company}");
        }
    }
}
