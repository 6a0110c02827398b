//! A second decomposition, of contact alone: recursive coordinate bisection of the contact nodes
//! (Attaway et al. 1998, "dynamic load balancing for the contact detection", figure 8).
//!
//! Elements stay where they are. Space is cut so that each part has the same number of contact
//! nodes. The worker of a part searches for the contact of all nodes, edges and segments there,
//! whatever worker owns their elements. It gets copies of them and of the segments around them; the
//! serial search and the laws treat these like any others. The cuts are renewed with the ghosts and
//! start from the last ones.
//!
//! In the paper's figure, data go to the second decomposition and back in every step:
//!
//! | paper | here |
//! |---|---|
//! | new decomposition from the last cuts | [`bisect`], when ghosts are renewed |
//! | surfaces and nodes go to their workers | ghosts, at renewals; their motion in every step |
//! | serial search | unchanged |
//! | pairs go back to the owners of their nodes | exchange of pairs (`pair_exchange.rs`) |
//! | forces in the decomposition of the elements | each worker sums the forces on its own nodes |

use crate::contact::surface::{Segment, Surface};
use crate::math::rigid_motion::RigidMotion;
use crate::math::row::xyz;
use crate::nodes::Nodes;
use crumple_proto::boxes::{Aabb, Cut, CutTree};
use crumple_proto::transport::{
    MaxReduction, RankLost, Tag, Transport, exchange_all, gather_all, sum_all,
};

/// Number of bins between the trial positions of a cut in one round of counting.
const BINS: usize = 16;
/// Largest number of rounds per level of the tree. Each divides the distance from the median by the
/// number of bins.
const ROUNDS: usize = 6;
/// Number of contact nodes on the wrong side of a cut up to which it is accepted, as a fraction of
/// the contact nodes in the box.
const UNEVEN: f64 = 0.005;
/// Extent of a box along the axis of its last cut, as a fraction of the longest extent, from which
/// on the axis is kept.
const KEPT_AXIS: f64 = 0.5;
/// Half the width of the first trial positions around the last cut, as a fraction of the extent.
const NEAR_LAST: f64 = 0.02;

/// A box of the growing tree and the workers to whom its parts go.
struct BoxToCut {
    entry: usize,
    first: usize,
    count: usize,
}

impl BoxToCut {
    /// Returns the number of workers below the cut.
    fn below(&self) -> usize {
        self.count / 2
    }
}

/// Returns cuts into parts for `workers` workers with the same number of points of all workers that
/// `comm` connects. `before` are the last cuts for the same number of parts. Any number of parts is
/// possible. Collective.
///
/// # Errors
/// A worker is gone.
pub fn bisect(
    comm: &mut dyn Transport,
    workers: usize,
    before: Option<&CutTree>,
    points: &[[f64; 3]],
) -> Result<CutTree, RankLost> {
    let mut tree = CutTree { entries: vec![Cut::Leaf(0)] };
    let mut groups = vec![BoxToCut { entry: 0, first: 0, count: workers }];
    loop {
        groups.retain(|g| g.count > 1);
        if groups.is_empty() {
            return Ok(tree);
        }
        let mut group_of = vec![usize::MAX; tree.entries.len()];
        groups.iter().enumerate().for_each(|(i, g)| group_of[g.entry] = i);
        let mut members: Vec<Vec<[f64; 3]>> = vec![Vec::new(); groups.len()];
        for &p in points {
            if let Some(list) = members.get_mut(group_of[tree.entry_of(p)]) {
                list.push(p);
            }
        }
        let planes = cut_all(comm, &groups, before, &members)?;
        let mut next = Vec::new();
        for (group, (axis, at)) in groups.iter().zip(planes) {
            let below = tree.entries.len();
            tree.entries[group.entry] = Cut::Plane { axis, at, below, above: below + 1 };
            let (first, count) = (group.first, group.below());
            let halves = [(first, count), (first + count, group.count - count)];
            for (entry, (first, count)) in (below..).zip(halves) {
                tree.entries.push(Cut::Leaf(first));
                next.push(BoxToCut { entry, first, count });
            }
        }
        groups = next;
    }
}

/// Returns axis and position of the cut of each group, whose points are `members`.
fn cut_all(
    comm: &mut dyn Transport,
    groups: &[BoxToCut],
    before: Option<&CutTree>,
    members: &[Vec<[f64; 3]>],
) -> Result<Vec<(usize, f64)>, RankLost> {
    let extents = extents(comm, members)?;
    let start = |(group, extent): (&BoxToCut, &Aabb)| {
        MedianSearch::new(extent, before.and_then(|tree| tree.entries.get(group.entry)))
    };
    let mut cuts: Vec<MedianSearch> = groups.iter().zip(&extents).map(start).collect();
    for _ in 0..ROUNDS {
        if cuts.iter().all(|c| c.is_done) {
            break;
        }
        let mut counts = vec![0_i64; cuts.len() * (BINS + 2)];
        for ((cut, points), counts) in cuts.iter().zip(members).zip(counts.chunks_mut(BINS + 2)) {
            points.iter().for_each(|p| counts[cut.bin(p[cut.axis])] += 1);
        }
        sum_all(comm, Tag::Renewal, &mut counts)?;
        for ((cut, group), counts) in cuts.iter_mut().zip(groups).zip(counts.chunks(BINS + 2)) {
            cut.narrow(counts, group.below() as f64 / group.count as f64);
        }
    }
    Ok(cuts.into_iter().map(|c| (c.axis, c.at)).collect())
}

/// Returns the boxes around the points of all workers in each group.
fn extents(comm: &mut dyn Transport, members: &[Vec<[f64; 3]>]) -> Result<Vec<Aabb>, RankLost> {
    let of_group = |points: &Vec<[f64; 3]>| {
        let b = Aabb::around(points.iter().copied());
        b.min.map(|x| -x).into_iter().chain(b.max)
    };
    let mine: Vec<f64> = members.iter().flat_map(of_group).collect();
    let mut largest = MaxReduction::new(mine.len(), Tag::Renewal);
    largest.begin(comm, &mine)?;
    let all = largest.finish(comm)?.chunks_exact(6);
    let corner = |of: &[f64]| std::array::from_fn(|c| of[c]);
    Ok(all.map(|b| Aabb { min: corner(&b[..3]).map(|x: f64| -x), max: corner(&b[3..]) }).collect())
}

/// Search for a cut with a given fraction of the points below it.
struct MedianSearch {
    axis: usize,
    /// Lower and upper end of the extent [length].
    extent: [f64; 2],
    /// Lower and upper end of the trial positions [length].
    window: [f64; 2],
    /// Best position so far [length].
    at: f64,
    is_done: bool,
}

impl MedianSearch {
    /// Starts in the box around the points, around the `last` cut if it fits.
    fn new(around: &Aabb, last: Option<&Cut>) -> Self {
        if around.is_empty() {
            let none = [0.0; 2];
            return Self { axis: 0, extent: none, window: none, at: 0.0, is_done: true };
        }
        let sides: [f64; 3] = std::array::from_fn(|c| around.max[c] - around.min[c]);
        let longest = (0..3).fold(0, |a, c| if sides[c] > sides[a] { c } else { a });
        let last = match last {
            Some(&Cut::Plane { axis, at, .. }) if sides[axis] >= KEPT_AXIS * sides[longest] => {
                Some((axis, at))
            }
            _ => None,
        };
        let axis = last.map_or(longest, |(axis, _)| axis);
        let extent = [around.min[axis], around.max[axis]];
        let near = NEAR_LAST * sides[axis];
        let within = |at: &f64| extent[0] + near < *at && *at < extent[1] - near;
        let window = last.map(|l| l.1).filter(within).map(|at| [at - near, at + near]);
        let at = 0.5 * (extent[0] + extent[1]);
        Self { axis, extent, window: window.unwrap_or(extent), at, is_done: false }
    }

    /// Returns the lower end of a bin; bin 1 is the first of the window.
    fn edge(&self, bin: usize) -> f64 {
        let [from, to] = self.window;
        if bin > BINS { to } else { from + (bin - 1) as f64 / BINS as f64 * (to - from) }
    }

    /// Returns the bin of a coordinate: 0 below the window, the last one above it.
    fn bin(&self, x: f64) -> usize {
        // The edges decide as in the tree: a point on a cut is above it.
        let [from, to] = self.window;
        let guess = ((x - from) / (to - from).max(f64::MIN_POSITIVE) * BINS as f64).floor();
        let mut bin = (guess.clamp(-1.0, BINS as f64) + 1.0) as usize;
        while bin > 0 && x < self.edge(bin) {
            bin -= 1;
        }
        while bin <= BINS && x >= self.edge(bin + 1) {
            bin += 1;
        }
        bin
    }

    /// Takes the counts of all workers by bin and narrows the window to the place where the
    /// `fraction` of the points lies below.
    fn narrow(&mut self, counts: &[i64], fraction: f64) {
        if self.is_done {
            return;
        }
        let total = counts.iter().sum::<i64>() as f64;
        let target = fraction * total;
        let (mut below, mut bin) = (0.0, 0);
        while bin < BINS + 1 && below + counts[bin] as f64 <= target {
            below += counts[bin] as f64;
            bin += 1;
        }
        let above = below + counts[bin] as f64;
        // The bin has the place; its nearer end is the best position.
        let ends = [
            if bin == 0 { self.extent[0] } else { self.edge(bin) },
            if bin > BINS { self.extent[1] } else { self.edge(bin + 1) },
        ];
        let is_lower = target - below <= above - target;
        self.at = if is_lower { ends[0] } else { ends[1] };
        let wrong = if is_lower { target - below } else { above - target };
        self.is_done = wrong <= (UNEVEN * total).max(0.5) || self.window == ends;
        self.window = ends;
    }
}

/// Returns for each worker the box around the contact entities of these segments for which it
/// searches. A node is where it lies, a segment with its edges is at its first node
/// ([`Surface::collect_slaves_in`]).
pub fn boxes_of_parts(tree: &CutTree, segments: &[Segment], nodes: &Nodes) -> Vec<Aabb> {
    let mut parts = vec![Aabb::EMPTY; tree.workers()];
    for s in segments {
        let corners = s.nodes.map(|n| xyz(&nodes.x[n as usize]));
        let home = tree.worker_of(corners[0]);
        for corner in corners {
            parts[home].include(corner);
            parts[tree.worker_of(corner)].include(corner);
        }
    }
    parts
}

/// The parts of space in which the workers search, as one worker knows them.
#[derive(Debug)]
pub struct SearchRegions {
    /// Cuts between the parts.
    pub tree: CutTree,
    /// Boxes around the contact entities for which each worker searches.
    pub seeking: Vec<Aabb>,
    /// Other workers, and this one, that own such entities of this worker, with the box around
    /// these.
    sources: Vec<(usize, Aabb)>,
}

impl SearchRegions {
    /// Cuts space for the contact nodes of all workers, starting from the last cuts. `surface` has
    /// own segments only. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        before: Option<&CutTree>,
        surface: &Surface,
        nodes: &Nodes,
    ) -> Result<Self, RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        let place = |n: u32| xyz(&nodes.x[n as usize]);
        let on_surface = |&i: &usize| nodes.is_owned(i) && surface.node_scale[i] > 0.0;
        let points: Vec<[f64; 3]> =
            (0..nodes.local_count).filter(on_surface).map(|i| place(i as u32)).collect();
        let tree = bisect(comm, workers, before, &points)?;
        let parts = boxes_of_parts(&tree, &surface.segments, nodes);
        let packed = |b: &Aabb| if b.is_empty() { Vec::new() } else { vec![b.min, b.max] };
        let parcels = exchange_all(comm, parts.iter().map(packed).collect())?;
        let unpacked = |(w, corners): (usize, &Vec<[f64; 3]>)| match corners[..] {
            [min, max] => Some((w, Aabb { min, max })),
            _ => None,
        };
        let sources: Vec<(usize, Aabb)> = parcels.iter().enumerate().filter_map(unpacked).collect();
        debug_assert!(parts[me].is_empty() || sources.iter().any(|s| s.0 == me));
        let mine = Aabb::around(sources.iter().flat_map(|(_, b)| [b.min, b.max]));
        let all = gather_all(comm, vec![mine.min, mine.max])?;
        let seeking = all.iter().map(|b| Aabb { min: b[0], max: b[1] }).collect();
        Ok(Self { tree, seeking, sources })
    }

    /// Returns a bound on the relative displacement of an entity of this worker's search and a node
    /// that follows `other` [length]. `motion` returns the motion of a worker.
    pub fn relative_motion(
        &self,
        other: &RigidMotion,
        motion: impl Fn(usize) -> RigidMotion,
    ) -> f64 {
        let of_source = |(w, b): &(usize, Aabb)| motion(*w).relative_motion(other, b);
        self.sources.iter().map(of_source).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::transport::threads::{Threads, connect};

    /// Returns points in a box of 8 by 3 by 1, denser at its lower end.
    fn cloud(count: usize) -> Vec<[f64; 3]> {
        let point = |i: usize| {
            let [u, v, w] = [0.754_877_666, 0.569_840_290, 0.362].map(|g| (g * i as f64).fract());
            [8.0 * u * u, 3.0 * v, w]
        };
        (0..count).map(point).collect()
    }

    /// Returns the cuts that several workers find together, each with every `workers`th point, and
    /// the largest number of messages of a worker.
    fn cuts(workers: usize, before: Option<&CutTree>, points: &[[f64; 3]]) -> (CutTree, u64) {
        let mut ends = connect(workers + 1);
        let _master = ends.remove(0);
        let run = |(me, mut end): (usize, Threads)| {
            let mine: Vec<_> = points.iter().skip(me).step_by(workers).copied().collect();
            let tree = bisect(&mut end, workers, before, &mine).unwrap();
            (tree, end.traffic().messages)
        };
        let all: Vec<(CutTree, u64)> = std::thread::scope(|scope| {
            let run = &run;
            let start = |end| scope.spawn(move || run(end));
            let threads: Vec<_> = ends.into_iter().enumerate().map(start).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        assert!(all.iter().all(|(tree, _)| *tree == all[0].0), "all workers find the same cuts");
        let most = all.iter().map(|a| a.1).max().unwrap();
        (all.into_iter().next().unwrap().0, most)
    }

    fn largest_share(tree: &CutTree, points: &[[f64; 3]]) -> f64 {
        let mut counts = vec![0_usize; tree.workers()];
        points.iter().for_each(|&p| counts[tree.worker_of(p)] += 1);
        let most = counts.into_iter().max().unwrap() as f64;
        most * tree.workers() as f64 / points.len() as f64
    }

    #[test]
    fn every_part_has_as_many_points_for_any_number_of_workers() {
        let points = cloud(20_000);
        for workers in 1..=9 {
            let (tree, _) = cuts(workers, None, &points);
            assert_eq!(tree.workers(), workers);
            let share = largest_share(&tree, &points);
            // Up to four levels. Each may add a share of UNEVEN to a half of its points or less.
            let levels = f64::from(workers.next_power_of_two().ilog2());
            assert!(share < (1.0 + 3.0 * UNEVEN).powf(levels) + 1e-9, "{workers}: {share}");
        }
    }

    /// The cuts do not depend on how the points are distributed over the workers.
    #[test]
    fn one_process_with_all_points_finds_the_same_cuts() {
        let points = cloud(3000);
        let mut alone = connect(2);
        let tree = bisect(&mut alone[1], 5, None, &points).unwrap();
        assert_eq!(tree, cuts(5, None, &points).0);
    }

    /// Points that move a little: the search that starts from the last cuts needs fewer messages
    /// and keeps the axes.
    #[test]
    fn a_search_from_the_last_cuts_takes_fewer_messages() {
        let points = cloud(20_000);
        let (first, _) = cuts(8, None, &points);
        let moved: Vec<_> = points.iter().map(|&[x, y, z]| [x + 0.03, y, 0.9 * z]).collect();
        let ((from_scratch, many), (from_last, few)) =
            (cuts(8, None, &moved), cuts(8, Some(&first), &moved));
        assert!(few < many, "{few} messages, {many} from scratch");
        assert!(largest_share(&from_last, &moved) < 1.04);
        assert!(largest_share(&from_scratch, &moved) < 1.04);
        let axes = |tree: &CutTree| -> Vec<usize> {
            let axis = |cut: &Cut| match cut {
                Cut::Plane { axis, .. } => *axis,
                Cut::Leaf(_) => 3,
            };
            tree.entries.iter().map(axis).collect()
        };
        assert_eq!(axes(&from_last), axes(&first));
    }

    /// Points in planes cannot be divided within a plane, and no points at all still give a tree.
    #[test]
    fn planes_of_points_and_no_points_have_cuts_too() {
        let layers: Vec<[f64; 3]> =
            (0..4000).map(|i| [f64::from(i % 10), f64::from(i / 10 % 2), 0.0]).collect();
        let (tree, _) = cuts(4, None, &layers);
        assert!(largest_share(&tree, &layers) < 1.25);
        let (tree, _) = cuts(3, None, &[]);
        assert_eq!(tree.workers(), 3);
        let (same, _) = cuts(3, None, &[[1.0; 3]; 50]);
        assert_eq!(same.workers(), 3);
    }
}
