//! Contact: global search, local search, enforcement, and the history of pairs.
//!
//! 1. global search (`search.rs`), once in several steps: finds the segments that a node could
//!    touch before the next search, and the edges that an edge could touch
//! 2. local search (`local_search.rs` for nodes, `edges.rs` for edges, `facets.rs` for
//!    segments), every step: finds the pairs of this step among the near candidates
//!    (`near_list.rs`)
//! 3. enforcement: computes forces by a contact law (`enforce/`), iterated (`solver.rs`) over
//!    all pairs, including those of other workers (`pairs.rs`)
//!
//! Contact is serial and knows no constraint. What it needs from other workers and from the
//! constraints on its nodes is stated in `surroundings.rs`.
//!
//! The normal forces of a pair act on one line, at any of its points. Friction acts on the
//! surfaces, half a thickness away from the nodes. So it also rotates nodes, and their
//! rotational velocities are part of the sliding velocity, in all sweeps ([`Pair::lever`]).

mod acceleration;
pub mod approach;
pub mod beams;
mod candidates;
pub mod diagnostics;
pub mod edges;
pub mod enforce;
mod facets;
pub mod folds;
mod friction;
pub mod geometry;
pub mod interfaces;
pub mod kernels;
pub mod local_search;
mod near_list;
mod overlap;
pub mod pairs;
mod projections;
mod resultants;
pub mod search;
pub mod shell_offset;
mod solver;
pub mod state;
pub mod surface;
pub mod surroundings;
mod travel;

use crate::energy::{ContactWork, Work};
use crate::math::lanes::Lane;
use crate::math::row::{Row, V3, row, xyz};
use crate::math::vector_range::VectorRange;
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crumple_proto::ids::{NodeId, SegmentId};
use crumple_proto::job::Contact as ContactJob;
use crumple_proto::transport::RankLost;
use diagnostics::crossing::{self, Crossing};
use diagnostics::search_record::SearchRecord;
use edges::Edges;
use enforce::{Elasticity, Laws};
use facets::Facets;
use geometry::Sphere;
use interfaces::Interfaces;
use near_list::NearList;
use pairs::{Pair, PairHistory, PairTable, accelerated_velocity};
use projections::ProjectedPairs;
use search::{SEARCHES, Search};
use solver::ContactSolver;
use surface::{Segment, Surface};
use surroundings::{Exclusions, Peers, VelocityConstraint};
use travel::Travel;

/// Automatic single-surface contact of one worker.
pub struct Contact {
    laws: Laws,
    search_method: Search,
    skin: f64,
    by_mass: bool,
    /// Wave speed per part [length/time].
    speeds: Vec<f64>,
    with_edges: bool,
    /// True if each pair of edges has at least one beam.
    beams_only: bool,
    /// Segments and slaves that can be in contact.
    pub surface: Surface,
    /// Candidate segments per slave: start of each slave's run, and segments ascending.
    candidate_start: Vec<u32>,
    candidates: Vec<u32>,
    /// Candidates within reach of the next steps.
    near_list: NearList,
    /// Near candidates that may touch in a step.
    projected_pairs: ProjectedPairs,
    /// Motion since the near list was made, and the relative motion between the last search and
    /// that time [length].
    motion_since_near_list: Travel,
    motion_before_near_list: f64,
    /// Stiffness per segment, empty if the law does not use it [force/length].
    stiffness: Vec<f64>,
    /// Start of each slave's run in `pair_histories`, in the order of `surface.slaves`.
    history_start: Vec<u32>,
    pair_histories: Vec<PairHistory>,
    /// Indices of the slaves that have pair histories, and of those that have got their first
    /// one since the near list was made or made up to date; ascending.
    with_history: Vec<u32>,
    with_first_history: Vec<u32>,
    /// Edges that could touch each other, with their pair histories.
    edges: Edges,
    /// Segments that could touch each other, with their pair histories.
    facets: Facets,
    /// Pairs of this step: own pairs, and those of other workers that touch local nodes.
    pub table: PairTable,
    /// Velocities of touched nodes without contact, in the order of the table's `touched`
    /// [length/time].
    free_velocities: Vec<Row>,
    /// Rotational velocities of touched nodes without contact; empty if friction rotates none of
    /// them [1/time].
    free_spins: Vec<Row>,
    record: SearchRecord,
    /// Number of global searches so far.
    pub searches: u64,
    /// Number of sweeps so far.
    pub sweeps: u64,
    /// Largest number of accelerated sweeps in a step.
    accelerated: usize,
    /// Number of steps so far with accelerated sweeps, and number of steps whose sweeps ended
    /// before the forces of all pairs reached the required accuracy.
    pub unsettled: [u64; 2],
    /// Number of pairs with a stiffness lower than the job asks for, reduced for a stable step;
    /// summed over the steps so far.
    pub capped_pairs: u64,
    /// Largest penetration since the last query, as a fraction of the contact thickness.
    pub penetration: f64,
    /// Largest rate at which near slaves and segments passed each other in the last step, where
    /// it may limit the step, see [`approach`] [1/time].
    pub approach: f64,
    /// True per interface if its pairs were searched for in the last step. A penetration found
    /// in the first search of an interface counts as initial.
    interface_started: Vec<bool>,
}

/// Number of cycles between two searches for folds.
const FOLDS_EVERY: u64 = 64;

/// Returns the distance outside a worker's box within which it must know segments, so that the
/// global search covers the reach of the local search. It depends on the scales of segment and
/// nodes [length]. [`Surface::shift_reach`] is added to it.
pub fn search_reach(interfaces: &Interfaces, segment_scale: f64, largest_scale: f64) -> f64 {
    local_search::REACH * interfaces.most(segment_scale + largest_scale)
}

impl Contact {
    /// Creates contact with an empty surface.
    ///
    /// # Panics
    /// If a law or search is not in the tables. The master checks names before it sends the job
    /// to workers.
    pub fn new(job: &ContactJob, parts: &Elasticity) -> Self {
        let laws = Laws::new(job, parts);
        let accelerated = laws.accelerated();
        let method = SEARCHES
            .iter()
            .find(|s| s.name == job.search)
            .unwrap_or_else(|| panic!("no search {}", job.search));
        Self {
            interface_started: vec![false; laws.count()],
            facets: Facets::new(laws.by_segments()),
            laws,
            search_method: method.find,
            skin: job.skin,
            by_mass: job.weighting == "mass",
            speeds: parts.speeds.clone(),
            with_edges: parts.with_edges,
            beams_only: !job.edges,
            surface: Surface::default(),
            candidate_start: Vec::new(),
            candidates: Vec::new(),
            near_list: NearList::default(),
            projected_pairs: ProjectedPairs::default(),
            motion_since_near_list: Travel::none(),
            motion_before_near_list: 0.0,
            stiffness: Vec::new(),
            history_start: Vec::new(),
            pair_histories: Vec::new(),
            with_history: Vec::new(),
            with_first_history: Vec::new(),
            edges: Edges::default(),
            table: PairTable::default(),
            free_velocities: Vec::new(),
            free_spins: Vec::new(),
            record: SearchRecord::default(),
            searches: 0,
            sweeps: 0,
            accelerated,
            unsettled: [0; 2],
            capped_pairs: 0,
            penetration: 0.0,
            approach: 0.0,
        }
    }

    /// Sets a new surface and the pair histories of its slaves. The next call of
    /// [`Self::refresh_candidates`] searches again.
    pub fn renew(
        &mut self,
        surface: Surface,
        nodes: &Nodes,
        memory_of: impl Fn(NodeId) -> Vec<PairHistory>,
    ) {
        self.record.renew(&self.surface.segments, nodes.len());
        self.surface = surface;
        self.surface.link_faces(nodes.local_count);
        self.surface.speeds.clone_from(&self.speeds);
        let stiffness =
            self.surface.segments.iter().map(|s| self.laws.segment_stiffness(s, &nodes.x0));
        self.stiffness = stiffness.collect::<Option<_>>().unwrap_or_default();
        self.pair_histories.clear();
        self.history_start.clear();
        self.candidate_start.clear();
        self.near_list.clear();
        self.with_history.clear();
        for (i, &s) in (0..).zip(&self.surface.slaves) {
            self.history_start.push(self.pair_histories.len() as u32);
            let start = self.pair_histories.len();
            self.pair_histories
                .extend(memory_of(nodes.id[s as usize]).into_iter().filter(|m| m.name.is_node()));
            self.pair_histories[start..].sort_unstable_by_key(|m| (m.age > 0, m.name));
            if self.pair_histories.len() > start {
                self.with_history.push(i);
            }
        }
        self.history_start.push(self.pair_histories.len() as u32);
        self.facets.renew(&self.surface, &self.stiffness, nodes, &memory_of);
        self.table.by_area = self.facets.are_wanted();
        if self.with_edges {
            self.edges = Edges::new(&self.surface, nodes, memory_of, self.beams_only);
        }
    }

    /// Returns the bytes in use without pairs and without spare capacity of lists: surface,
    /// candidates, and the data that decides when to search.
    pub fn bytes(&self) -> usize {
        let lists = [
            &self.candidate_start,
            &self.candidates,
            &self.history_start,
            &self.with_history,
            &self.with_first_history,
        ];
        self.surface.bytes()
            + lists.iter().map(|l| size_of_val(&l[..])).sum::<usize>()
            + size_of_val(&self.stiffness[..])
            + self.motion_since_near_list.bytes()
            + self.near_list.bytes()
            + self.projected_pairs.bytes()
            + self.record.bytes()
            + self.edges.bytes()
            + self.facets.bytes()
    }

    /// Returns the pair histories of each slave. Histories of edges are listed at all nodes of
    /// their pairs, those of segments at the segments' own nodes.
    pub fn pair_histories(&self) -> impl Iterator<Item = (u32, &[PairHistory])> {
        let run = |i: usize| {
            &self.pair_histories[self.history_start[i] as usize..self.history_start[i + 1] as usize]
        };
        let of_nodes = self.surface.slaves.iter().enumerate().map(move |(i, &s)| (s, run(i)));
        let others = self.edges.pair_histories().chain(self.facets.pair_histories());
        of_nodes.chain(others.map(|(n, m)| (n, std::slice::from_ref(m))))
    }

    /// Returns the edges that have passed through a surface, see [`crossing`].
    pub fn crossings(&self, nodes: &Nodes, time: f64) -> Vec<Crossing> {
        crossing::crossings(&self.surface, nodes, time, self.search_method)
    }

    /// Returns true if workers check in every step if sweeps have converged on all of them, and
    /// accelerate the sweeps if not.
    pub fn accelerates(&self) -> bool {
        self.accelerated > 0 && self.laws.converge()
    }

    /// Returns the range of the velocities of nodes that can be in contact, see
    /// [`Surface::velocities`].
    pub fn velocities(&self, nodes: &Nodes) -> [f64; 6] {
        self.surface.velocities(nodes)
    }

    /// Returns true if a part ever was near to contact, and true if it ever had a pair, as far
    /// as this worker knows.
    pub fn record_of(&self, part: usize) -> (bool, bool) {
        self.record.part_seen(&self.surface.segments, part)
    }

    /// Returns the active pairs of owned nodes after the last local search: ids of the slave, or
    /// its lower node, and of the segment.
    pub fn owned_pairs(&self) -> impl Iterator<Item = (NodeId, SegmentId)> + '_ {
        self.table.pairs.iter().filter(|p| p.is_owned).map(|p| (p.key.slave, p.segment))
    }

    /// Returns local nodes of the slaves of own pairs, to estimate the load.
    pub fn owned_pair_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.table.pairs.iter().filter(|p| p.is_owned).map(|p| p.nodes[0])
    }

    /// Returns the active pairs of owned nodes and edges after the last local search.
    pub fn owned_table(&self) -> impl Iterator<Item = &Pair> {
        self.table.pairs.iter().filter(|p| p.is_owned)
    }

    /// Returns the slaves that have near candidates, each with their number. Call it after
    /// [`Self::refresh_candidates`].
    pub fn count_near(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let runs = self.near_list.list.chunk_by(|a, b| a.slave_index == b.slave_index);
        runs.map(|run| (self.surface.slaves[run[0].slave_index as usize], run.len()))
    }

    /// Returns the slaves, each with the number of candidates that the last global search found
    /// for it.
    pub fn count_candidates(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        let runs = self.candidate_start.windows(2).map(|run| (run[1] - run[0]) as usize);
        self.surface.slaves.iter().copied().zip(runs)
    }

    /// Returns the number of candidates of the last global search.
    pub fn candidates(&self) -> u64 {
        self.candidates.len() as u64
    }

    /// Returns the laws of the interfaces.
    pub fn laws(&self) -> &Laws {
        &self.laws
    }

    /// Updates the candidates if the motion of nodes may have used up the skin of the search,
    /// and the near list if the motion may have used up its own skin. Also computes
    /// [`Self::approach`]. `dt` is the step size and `stable` the stable step of the elements
    /// [time].
    pub fn refresh_candidates(
        &mut self,
        nodes: &Nodes,
        joined: &dyn Exclusions,
        (time, dt): (f64, f64),
        stable: f64,
    ) {
        let velocities = VectorRange::of(nodes.v_next.len(), |i| Lane::new(nodes.v_next[i]));
        let spread = velocities.diameter();
        // If this is false, no node passes the thinnest segment within one stable step of the
        // elements.
        let fast = stable * spread > self.surface.thinnest;
        self.refresh(nodes, joined, dt * spread, fast);
        self.approach = if fast { self.approach_rate(nodes, time, dt) } else { 0.0 };
    }

    /// Returns the largest rate at which slaves pass near segments [1/time].
    fn approach_rate(&self, nodes: &Nodes, time: f64, dt: f64) -> f64 {
        let s = &self.surface;
        let of_slave = |(i, &slave): (usize, &u32)| {
            let found = &self.candidates
                [self.candidate_start[i] as usize..self.candidate_start[i + 1] as usize];
            let of_pair = |&g: &u32| {
                let segment = &s.segments[g as usize];
                let interface =
                    s.interface(i, segment).filter(|&k| !s.interfaces.is_over(k, time))?;
                Some(approach::rate(
                    nodes,
                    slave,
                    segment,
                    (s.sizes(interface, slave, segment).1, s.shift_reach()),
                    dt,
                ))
            };
            found.iter().filter_map(of_pair).fold(0.0, f64::max)
        };
        let of_nodes = s.slaves.iter().enumerate().map(of_slave).fold(0.0, f64::max);
        of_nodes.max(self.edges.approach_rate(nodes, s, (time, dt)))
    }

    fn refresh(&mut self, nodes: &Nodes, joined: &dyn Exclusions, step: f64, fast: bool) {
        let fresh = !self.candidate_start.is_empty();
        // The candidates must include all that can come near in the next steps. If this needs
        // more than half the skin, the step is limited by the whole surface instead.
        let ahead = approach::STEPS * (2.0 * step).max(self.near_list.step);
        let ahead = if fast && ahead <= 0.5 * self.skin { ahead } else { 0.0 };
        let is_valid = |moved: f64| {
            let used_up = self.motion_before_near_list + moved + ahead > self.skin;
            moved <= self.near_list.skin && step <= self.near_list.step && !used_up
        };
        if fresh {
            self.motion_since_near_list.advance(nodes);
            if !is_valid(self.motion_since_near_list.bound()) {
                self.motion_since_near_list.fit(&nodes.x);
            }
        }
        let moved = if fresh { self.motion_since_near_list.bound() } else { 0.0 };
        if fresh && is_valid(moved) {
            if self.edges.is_stale() {
                self.search_edges(nodes, joined);
                self.pick(nodes);
            }
            return;
        }
        self.motion_since_near_list.restart(nodes);
        self.motion_before_near_list += moved;
        let spheres: Vec<Sphere> =
            self.surface.segments.iter().map(|s| Sphere::around(&s.corners(&nodes.x))).collect();
        if !fresh || self.motion_before_near_list + self.near_list.skin + ahead > self.skin {
            self.search(nodes, &spheres, joined);
            self.search_edges(nodes, joined);
            self.facets.search(
                (&self.surface, &spheres),
                nodes,
                joined,
                self.search_method,
                self.skin,
            );
            self.motion_before_near_list = 0.0;
        } else if self.edges.is_stale() {
            self.search_edges(nodes, joined);
        }
        let found = |i: usize| {
            &self.candidates[self.candidate_start[i] as usize..self.candidate_start[i + 1] as usize]
        };
        let memory = |i: usize| {
            &self.pair_histories[self.history_start[i] as usize..self.history_start[i + 1] as usize]
        };
        self.near_list.renew((nodes, &self.surface, &spheres), (self.skin, step), found, memory);
        self.with_first_history.clear();
        self.pick(nodes);
    }

    /// Finds the edges that each edge could touch before the next search.
    fn search_edges(&mut self, nodes: &Nodes, joined: &dyn Exclusions) {
        self.edges.search(&self.surface, nodes, joined, self.search_method, self.skin);
    }

    /// Finds the edges and segments that could touch others before the near list is made again.
    fn pick(&mut self, nodes: &Nodes) {
        let path = self.motion_since_near_list.path();
        self.edges.pick(nodes, &self.surface, (self.near_list.skin, self.near_list.step), path);
        self.edges
            .near()
            .for_each(|(slave, g)| self.record.near(slave, &self.surface.segments[g as usize]));
        self.facets.pick(nodes, &self.surface, self.near_list.skin, self.near_list.step);
        self.facets.near(&self.surface).for_each(|(slave, met)| self.record.near(slave, met));
    }

    /// Updates the folds of the surfaces in some cycles, the same cycles on all workers. Ghost
    /// nodes must have the positions that their owners have.
    pub fn update_folds(&mut self, nodes: &mut Nodes, cycle: u64) {
        if self.with_edges && cycle.is_multiple_of(FOLDS_EVERY) {
            nodes.seen.clone_from(&nodes.x);
            self.edges.update_folds(&self.surface, nodes);
        }
    }

    /// Finds the segments that each slave could touch before it moves by more than the skin.
    fn search(&mut self, nodes: &Nodes, spheres: &[Sphere], joined: &dyn Exclusions) {
        self.searches += 1;
        self.candidates = Vec::new(); // freed first: memory use peaks in the search
        let s = &self.surface;
        // Slaves by segment.
        let (mut found, mut count) = (Vec::new(), vec![0u32; s.segments.len()]);
        {
            let (largest, added) = (s.largest_scale(), s.shift_reach() + self.skin);
            let bounds = |g: &Segment| {
                g.bounds(&nodes.x, search_reach(&s.interfaces, g.scale, largest) + added)
            };
            let boxes: Vec<_> = s.segments.iter().map(bounds).collect();
            let points: Vec<[f64; 3]> =
                s.slaves.iter().map(|&i| xyz(&nodes.x[i as usize])).collect();
            (self.search_method)(&boxes, &points, &mut |g, p| {
                let (segment, slave) = (&s.segments[g as usize], s.slaves[p as usize]);
                let reach = local_search::reach_of_old(s, slave, segment) + self.skin;
                let is_far = spheres[g as usize].is_farther(&V3::from(points[p as usize]), reach);
                let touches = || s.interface(p as usize, segment).is_some();
                let is_other =
                    !segment.nodes.contains(&slave) && !joined.excludes(slave, &segment.nodes);
                if !is_far && is_other && touches() {
                    found.push(p);
                    count[g as usize] += 1;
                    self.record.near(slave, segment);
                }
            });
        }
        // Segments by slave; they stay ascending.
        self.candidate_start.clear();
        self.candidate_start.resize(s.slaves.len() + 1, 0);
        found.iter().for_each(|&p| self.candidate_start[p as usize + 1] += 1);
        for i in 0..s.slaves.len() {
            self.candidate_start[i + 1] += self.candidate_start[i];
        }
        let mut next = self.candidate_start.clone();
        self.candidates.resize(found.len(), 0);
        let segments = (0u32..).zip(&count).flat_map(|(g, &n)| std::iter::repeat_n(g, n as usize));
        for (g, p) in segments.zip(found) {
            self.candidates[next[p as usize] as usize] = g;
            next[p as usize] += 1;
        }
    }

    /// Finds the pairs of own nodes, edges and segments that are active in this step.
    pub fn find_pairs(
        &mut self,
        nodes: &Nodes,
        joined: &dyn Exclusions,
        time: f64,
        steps: StepSizes,
    ) {
        let is_alive = |i| self.surface.interfaces.is_alive(i, time);
        let alive: Vec<bool> = (0..self.surface.interfaces.count() as u16).map(is_alive).collect();
        let mut pairs = std::mem::take(&mut self.table.pairs);
        pairs.clear();
        let memory = |i: usize| {
            &self.pair_histories[self.history_start[i] as usize..self.history_start[i + 1] as usize]
        };
        let found = |i: usize| {
            &self.candidates[self.candidate_start[i] as usize..self.candidate_start[i + 1] as usize]
        };
        self.near_list.renew_slaves(
            (nodes, &self.surface),
            &self.with_first_history,
            found,
            memory,
        );
        self.with_first_history.clear();
        let near = (&mut self.near_list, self.motion_since_near_list.path());
        self.projected_pairs.project(nodes, &self.surface, near, |i| memory(i as usize), steps.dt);
        for meetings in
            self.projected_pairs.all.chunk_by(|a, b| a.of.slave_index == b.of.slave_index)
        {
            let i = meetings[0].of.slave_index as usize;
            local_search::find_pairs(
                nodes,
                (&self.surface, &alive),
                i,
                meetings,
                memory(i),
                steps.dt,
                &mut pairs,
            );
        }
        if !self.stiffness.is_empty() {
            for p in &mut pairs {
                let at = self.surface.segments.binary_search_by_key(&p.segment, |s| s.id);
                p.stiffness = at.map_or(0.0, |i| self.stiffness[i]);
            }
        }
        let with_segments = self.facets.are_wanted();
        if with_segments {
            pairs.retain(|p| !self.facets.covers(nodes, (&self.surface, &alive), joined, p));
        }
        let of_nodes = pairs.len();
        self.edges.find_pairs(
            nodes,
            (&self.surface, &alive),
            &self.stiffness,
            (steps.dt, self.motion_since_near_list.path()),
            &mut pairs,
        );
        if with_segments {
            pairs.iter_mut().for_each(|p| p.area = p.contact_thickness * p.contact_thickness);
            self.facets.find_pairs(nodes, (&self.surface, &alive), steps.dt, &mut pairs);
        }
        if pairs.len() > of_nodes {
            pairs.sort_unstable_by_key(|p| p.key);
        }
        let begun = std::mem::replace(&mut self.interface_started, alive);
        for p in &mut pairs {
            if !begun[p.interface as usize] {
                p.initial_gap = p.tolerated_gap;
            }
            p.lever(nodes);
            p.set_slave_mass(nodes);
            self.surface.set_friction(p, nodes);
            self.record.touched(&p.nodes);
            p.force = self.laws.of_pair(p).initial_force(p, steps);
            self.penetration = self.penetration.max(p.penetration / p.contact_thickness);
        }
        self.table.pairs = pairs;
        if self.by_mass {
            self.table.weight_by_mass(nodes);
        }
    }

    /// Computes the contact forces and sets the velocities of the touched nodes to those with
    /// contact and constraints. Call it after the pairs of other workers are in the table.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn enforce(
        &mut self,
        nodes: &mut Nodes,
        around: &mut (impl VelocityConstraint + Peers),
        steps: StepSizes,
    ) -> Result<(), RankLost> {
        let accelerated = if self.accelerates() { self.accelerated } else { 0 };
        let couples = self.has_couples(nodes);
        let t = &mut self.table;
        self.free_velocities.clear();
        self.free_velocities.extend(t.touched.iter().map(|&n| nodes.v_next[n as usize]));
        self.free_spins.clear();
        if !t.couples.is_empty() {
            self.free_spins.extend(t.touched.iter().map(|&n| nodes.w_next[n as usize]));
        }
        let coupled = around.prepare(nodes, &t.touched, couples)?;
        let (free, free_spins) = (&self.free_velocities[..], &self.free_spins[..]);
        let mut sweeps = ContactSolver {
            laws: &self.laws,
            nodes,
            free,
            free_spins,
            around,
            coupled,
            steps,
            accelerated,
        };
        let swept = sweeps.run(t)?;
        self.sweeps += swept.sweeps;
        for (count, is_so) in self.unsettled.iter_mut().zip([swept.accelerated, swept.unsettled]) {
            *count += u64::from(is_so);
        }
        Ok(())
    }

    /// Returns the nodes that pairs touch, ascending, with their velocities after contact but
    /// before walls [length/time].
    pub fn contact_forces<'a>(
        &'a self,
        nodes: &'a Nodes,
        steps: StepSizes,
    ) -> impl Iterator<Item = (u32, Row)> + 'a {
        let touched = self.table.touched.iter().zip(&self.table.total).zip(&self.free_velocities);
        touched.map(move |((&n, f), free)| {
            (n, accelerated_velocity(free, f, &nodes.inv_mass[n as usize], steps.dt_damped))
        })
    }

    /// Returns the contact force on local node `n` in this step [force].
    pub fn force_on(&self, n: u32) -> V3 {
        self.table.touched.binary_search(&n).map_or(V3::zeros(), |k| self.table.total[k])
    }

    /// Returns the moment of friction on local node `n` in this step [force length].
    pub fn couple_on(&self, n: u32) -> V3 {
        let place = self.table.touched.binary_search(&n).ok();
        place.and_then(|k| self.table.couples.get(k).copied()).unwrap_or(V3::zeros())
    }

    /// Returns true if friction can rotate nodes on any worker. Then the workers need the
    /// rotational velocities of other workers' nodes.
    pub fn has_couples(&self, nodes: &Nodes) -> bool {
        nodes.rotations && self.surface.interfaces.have_friction()
    }

    /// Updates the pressure on the slaves of own pairs whose friction depends on it.
    fn update_pressures(&mut self, nodes: &Nodes) {
        let (surface, t) = (&self.surface, &self.table);
        if !surface.interfaces.have_friction_by_pressure() {
            return;
        }
        let is_limited = |p: &Pair| {
            p.is_owned
                && p.key.is_node()
                && surface.interfaces.has_friction_by_pressure(p.interface)
        };
        let noted = |(q, p): (usize, &Pair)| {
            let area = surface.area_of(p, &nodes.x, |n| t.bears(n, &p.normal));
            (q, self.force_on(p.nodes[0]).dot(&p.normal), area)
        };
        let all: Vec<(usize, f64, f64)> =
            t.pairs.iter().enumerate().filter(|(_, p)| is_limited(p)).map(noted).collect();
        for (q, pressed, area) in all {
            self.table.pairs[q].note_pressure(pressed, area);
        }
    }

    /// Adds the work of contact with the current velocities to `work`, and stores the pair
    /// histories of the slaves.
    pub fn finish_step(&mut self, nodes: &Nodes, steps: StepSizes, work: &mut ContactWork) {
        self.update_pressures(nodes);
        let t = &mut self.table;
        for p in t.pairs.iter_mut().filter(|p| p.is_owned) {
            let velocity = p.relative_velocity(nodes);
            let sheared = p.force - p.normal * p.force.dot(&p.normal);
            // Friction uses the velocity of the next mid-step; half of its work is done by the
            // present time.
            let slid = 0.5 * steps.dt_velocity * sheared.dot(&velocity);
            work.friction.add(Work { before: slid, after: slid });
            if p.initial_gap < 0.0 {
                work.starting.add(p.work(nodes, steps.dt_velocity));
            }
            let law = self.laws.of_pair(p);
            p.slip = law.slip(p, &velocity, steps);
            self.capped_pairs += u64::from(law.is_capped(p, steps));
        }
        for (&n, f) in t.touched.iter().zip(&t.total).filter(|(n, _)| nodes.is_owned(**n as usize))
        {
            let (before, after) = (&nodes.v[n as usize], &nodes.v_next[n as usize]);
            let impulse = row((f * steps.dt_velocity).into());
            work.total.add(Work::from_impulses(&impulse, before, after));
        }
        for (&n, couple) in
            t.touched.iter().zip(&t.couples).filter(|(n, _)| nodes.is_owned(**n as usize))
        {
            let (before, after) = (&nodes.w[n as usize], &nodes.w_next[n as usize]);
            let impulse = row((couple * steps.dt_velocity).into());
            work.total.add(Work::from_impulses(&impulse, before, after));
        }
        self.store_histories();
        let t = &self.table;
        self.edges.store_history(t.pairs.iter());
        self.facets.store_history(t.pairs.iter());
    }

    /// Stores the pair histories of the slaves.
    fn store_histories(&mut self) {
        let slaves = &self.surface.slaves;
        let before = std::mem::take(&mut self.pair_histories);
        let with_history = std::mem::take(&mut self.with_history);
        let mut had = with_history.iter().map(|&i| i as usize).peekable();
        let pairs = &self.table.pairs;
        let mut own = pairs.iter().filter(|p| p.is_owned && p.key.is_node()).peekable();
        // Most slaves have neither a pair nor a history. Their runs start where the next one does.
        let mut next = 0;
        loop {
            let paired =
                own.peek().map(|p| next + slaves[next..].partition_point(|&s| s < p.nodes[0]));
            let Some(i) = paired.into_iter().chain(had.peek().copied()).min() else { break };
            let old = self.history_start[i] as usize..self.history_start[i + 1] as usize;
            let start = self.pair_histories.len();
            self.history_start[next..=i].fill(start as u32);
            next = i + 1;
            while let Some(p) = own.next_if(|p| p.nodes[0] == slaves[i]) {
                self.pair_histories.push(p.to_history());
            }
            if had.next_if_eq(&i).is_none() {
                self.with_first_history.push(i as u32);
            }
            // Pairs of this step come first, then lost pairs, both in ascending order.
            for m in &before[old] {
                if !self.pair_histories[start..].iter().any(|n| n.name == m.name) {
                    self.pair_histories.extend(m.after_loss());
                }
            }
            self.pair_histories[start..].sort_unstable_by_key(|m| (m.age > 0, m.name));
            if self.pair_histories.len() > start {
                self.with_history.push(i as u32);
            }
        }
        self.history_start[next..].fill(self.pair_histories.len() as u32);
    }
}
