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
//! constraints on its nodes is stated in `pairs/peers.rs` and `surroundings.rs`.
//!
//! The normal forces of a pair act on one line, at any of its points. Friction acts on the
//! surfaces, half a thickness away from the nodes. So it also rotates nodes, and their
//! rotational velocities are part of the sliding velocity, in all sweeps ([`Pair::lever`]).

pub mod acceleration;
pub mod approach;
pub mod beams;
mod candidates;
mod contact_frame;
mod detail;
pub mod diagnostics;
mod edge_sides;
pub mod edges;
pub mod enforce;
mod facets;
pub mod folds;
mod friction;
mod friction_table;
pub mod geometry;
pub mod impact;
pub mod interfaces;
pub mod kernels;
pub mod local_search;
mod near_list;
mod nesterov;
mod overlap;
mod pair_geometry;
pub mod pairs;
mod projections;
mod queries;
pub mod reach;
mod resultants;
pub mod search;
pub mod shell_offset;
mod slave_candidates;
mod slave_histories;
mod smooth_surface;
mod solver;
pub mod state;
pub mod surface;
pub mod surroundings;
#[cfg(test)]
mod testing;
mod travel;
mod waiting;
pub mod work;

use crate::work::ContactWork;
use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_fem::work::Work;
use crumple_math::lanes::Lane;
use crumple_math::row::{Row, row, xyz};
use crumple_math::threads;
use crumple_math::vector_range::VectorRange;
use crumple_proto::ids::NodeId;
use crumple_proto::job::ContactInput;
use crumple_proto::place::{ModelPlace, Peak};
use crumple_proto::transport::RankLost;
use detail::ContactDetail;
use diagnostics::search_record::SearchRecord;
use edges::Edges;
use enforce::{Elasticity, LawSets};
use facets::Facets;
use geometry::Sphere;
use interfaces::Interfaces;
use near_list::NearList;
use nesterov::NesterovMomentum;
use pairs::{Pair, PairHistory, PairTable, Peers};
use projections::{ProjectedPair, ProjectedPairs};
use search::{SEARCHES, Search};
use slave_candidates::SlaveCandidates;
use slave_histories::SlaveHistories;
use solver::ContactSolver;
use std::ops::Range;
use surface::Surface;
use surroundings::{Exclusions, VelocityConstraint};
use travel::Travel;

/// Automatic single-surface contact of one worker.
pub struct Contact {
    laws: LawSets,
    /// Number of pairs of all workers in the last step, if sweeps can be accelerated.
    pairs: u64,
    search_method: Search,
    skin: f64,
    by_mass: bool,
    /// Wave speed per part [length/time].
    speeds: Vec<f64>,
    with_edges: bool,
    /// Options of the local search of nodes.
    detail: ContactDetail,
    /// True if each pair of edges has at least one beam.
    beams_only: bool,
    /// Segments and slaves that can be in contact.
    pub surface: Surface,
    /// Segments that each slave could touch before the next search.
    candidates: SlaveCandidates,
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
    /// Pair histories of the slaves.
    histories: SlaveHistories,
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
    /// Momentum of sweeps.
    momentum: NesterovMomentum,
    record: SearchRecord,
    /// Number of global searches so far.
    pub searches: u64,
    /// Number of sweeps so far.
    pub sweeps: u64,
    /// Largest number of accelerated sweeps in a step.
    accelerated: usize,
    /// Number of steps so far with accelerated sweeps, and number of steps whose sweeps ended
    /// before the forces of all pairs reached the required accuracy. Steps in which the worker
    /// takes no part in the sums of the sweeps do not count.
    pub unsettled: [u64; 2],
    /// Number of pairs with a stiffness lower than the job asks for, reduced for a stable step;
    /// summed over the steps so far.
    pub capped_pairs: u64,
    /// Largest penetration since the last query, as a fraction of the contact thickness.
    pub penetration: f64,
    /// Node with this penetration.
    pub deepest: ModelPlace,
    /// Largest work of friction of a pair in a step since the last query [energy].
    pub sliding: Peak,
    /// Largest rate at which near slaves and segments passed each other in the last step, where
    /// it may limit the step, see [`approach`] [1/time].
    pub approach: f64,
    /// True per interface if its pairs were searched for in the last step. A penetration found
    /// in the first search of an interface counts as initial.
    interface_started: Vec<bool>,
}

/// Least number of segments that a thread examines at a time.
const PIECE: usize = 1024;

/// Number of cycles between two searches for folds.
const FOLDS_EVERY: u64 = 64;

/// Returns the distance outside a worker's box within which it must know segments, so that the
/// global search covers the reach of the local search. It depends on the scales of segment and
/// nodes [length]. [`Surface::shift_reach`] is added to it.
pub fn search_reach(interfaces: &Interfaces, segment_scale: f64, largest_scale: f64) -> f64 {
    reach::REACH * interfaces.most(segment_scale + largest_scale)
}

impl Contact {
    /// Creates contact with an empty surface.
    ///
    /// # Panics
    /// If a law or search is not in the tables. The master checks names before it sends the job
    /// to workers.
    pub fn new(job: &ContactInput, parts: &Elasticity) -> Self {
        let laws = LawSets::new(job, parts);
        let first = laws.select(0);
        let accelerated = first.accelerated();
        let method = SEARCHES
            .iter()
            .find(|s| s.name == job.search)
            .unwrap_or_else(|| panic!("no search {}", job.search));
        Self {
            interface_started: vec![false; first.count()],
            facets: Facets::new(first.by_segments()),
            laws,
            pairs: 0,
            search_method: method.find,
            skin: job.skin,
            by_mass: job.weighting == "mass",
            speeds: parts.speeds.clone(),
            with_edges: parts.with_edges,
            detail: ContactDetail::new(job),
            beams_only: !job.edges,
            surface: Surface::default(),
            candidates: SlaveCandidates::default(),
            near_list: NearList::default(),
            projected_pairs: ProjectedPairs::default(),
            motion_since_near_list: Travel::none(),
            motion_before_near_list: 0.0,
            stiffness: Vec::new(),
            histories: SlaveHistories::default(),
            edges: Edges::default(),
            table: PairTable::default(),
            free_velocities: Vec::new(),
            free_spins: Vec::new(),
            momentum: NesterovMomentum::default(),
            record: SearchRecord::default(),
            searches: 0,
            sweeps: 0,
            accelerated,
            unsettled: [0; 2],
            capped_pairs: 0,
            penetration: 0.0,
            deepest: ModelPlace::default(),
            sliding: Peak::default(),
            approach: 0.0,
        }
    }

    /// Transfers the marks of nodes in the record of searches to the parts, because nodes get other
    /// indices.
    pub fn transfer_marks(&mut self, nodes: &Nodes) {
        self.record.renew(&self.surface.segments, nodes.len());
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
        self.surface.link_faces(nodes.len());
        if self.detail.smooth {
            self.surface.link_nodes(nodes.len());
        }
        self.surface.speeds.clone_from(&self.speeds);
        let stiffness =
            self.surface.segments.iter().map(|s| self.laws().segment_stiffness(s, &nodes.x0));
        self.stiffness = stiffness.collect::<Option<_>>().unwrap_or_default();
        self.candidates.clear();
        self.near_list.clear();
        self.histories.renew(&self.surface.slaves, |n| memory_of(nodes.id[n]));
        self.facets.renew(&self.surface, &self.stiffness, nodes, &memory_of);
        self.table.by_area = self.facets.are_wanted();
        if self.with_edges {
            self.edges = Edges::new(&self.surface, nodes, memory_of, self.beams_only);
        }
    }

    /// Returns true if workers check in every step if sweeps have converged on all of them, and
    /// accelerate the sweeps if not.
    pub fn accelerates(&self) -> bool {
        self.accelerated > 0 && self.laws().converge()
    }

    /// Returns true if the step before had so few pairs on all workers that each worker computes
    /// the forces of those that act on its nodes. Only with accelerated sweeps workers know the
    /// number of pairs.
    pub fn replicates_pairs(&self) -> bool {
        self.accelerates() && !LawSets::is_dense(self.pairs)
    }

    /// Updates the candidates if the motion of nodes may have used up the skin of the search,
    /// and the near list if the motion may have used up its own skin. Also computes
    /// [`Self::approach`]. `dt` is the step size, `stable` the limit of the step due to the
    /// elements, and `limit` that due to contact [time].
    pub fn refresh_candidates(
        &mut self,
        nodes: &Nodes,
        joined: &dyn Exclusions,
        (time, dt): (f64, f64),
        [stable, limit]: [f64; 2],
    ) {
        let velocity = |i: usize| Lane::new(nodes.v_next[i]);
        let spread = VectorRange::side_by_side(nodes.v_next.len(), velocity).diameter();
        // If this is false, no node passes the thinnest segment within one stable step of the
        // elements.
        let fast = stable * spread > self.surface.thinnest;
        // A step can grow to its limits at once.
        let longest = dt.max(stable.min(limit));
        let ahead = if fast { longest * spread } else { 0.0 };
        self.refresh(nodes, joined, dt * spread, ahead);
        self.approach = if fast { self.approach_rate(nodes, time, longest) } else { 0.0 };
    }

    /// Returns the largest rate at which slaves pass near segments [1/time].
    fn approach_rate(&self, nodes: &Nodes, time: f64, dt: f64) -> f64 {
        let s = &self.surface;
        let of_slave = |(i, &slave): (usize, &u32)| {
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
            self.candidates.segments_of(i).iter().filter_map(of_pair).fold(0.0, f64::max)
        };
        let of_piece =
            |piece: Range<usize>| piece.map(|i| of_slave((i, &s.slaves[i]))).fold(0.0, f64::max);
        let pieces = threads::map(threads::ranges(s.slaves.len(), PIECE), of_piece);
        let of_nodes = pieces.into_iter().fold(0.0, f64::max);
        of_nodes.max(self.edges.approach_rate(nodes, s, (time, dt)))
    }

    /// Updates the lists for nodes that move by at most `step` against each other in this step, and
    /// by `longest` in one of the next steps [length]; `longest` is 0 if no node can pass a
    /// segment.
    fn refresh(&mut self, nodes: &Nodes, joined: &dyn Exclusions, step: f64, longest: f64) {
        let fresh = self.candidates.are_known();
        // The candidates must include all that can come near in the next steps. If this needs
        // more than half the skin, the step is limited by the whole surface instead.
        let ahead = approach::STEPS * (2.0 * longest).max(self.near_list.step);
        let ahead = if longest > 0.0 && ahead <= 0.5 * self.skin { ahead } else { 0.0 };
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
        let sphere = |i: usize| Sphere::around(&self.surface.segments[i].corners(&nodes.x));
        let spheres = threads::collect(self.surface.segments.len(), PIECE, sphere);
        if !fresh || self.motion_before_near_list + self.near_list.skin + ahead > self.skin {
            self.searches += 1;
            self.candidates.search(
                (&self.surface, &spheres, nodes, joined),
                (self.search_method, self.skin),
                &mut self.record,
            );
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
        self.near_list.renew(
            (nodes, &self.surface, &spheres),
            (self.skin, step),
            |i| self.candidates.segments_of(i),
            |i| self.histories.of_slave(i),
        );
        self.histories.forget_first();
        self.pick(nodes);
    }

    /// Finds the edges that each edge could touch before the next search.
    fn search_edges(&mut self, nodes: &Nodes, joined: &dyn Exclusions) {
        self.edges.search(&self.surface, nodes, joined, self.search_method, self.skin);
    }

    /// Finds the edges and segments that could touch others before the near list is made again.
    fn pick(&mut self, nodes: &Nodes) {
        self.edges.pick(nodes, &self.surface, (self.near_list.skin, self.near_list.step));
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

    /// Finds the pairs of the nodes, edges and segments for which this worker searches that are
    /// active in this step.
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
        self.find_pairs_of_slaves(nodes, &alive, steps.dt, &mut pairs);
        let with_segments = self.facets.are_wanted();
        if with_segments {
            pairs.retain(|p| !self.facets.covers(nodes, (&self.surface, &alive), joined, p));
        }
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
        // Slaves are in the order of their local indices. Ghosts come after local nodes.
        if !pairs.is_sorted_by_key(|p| p.key) {
            pairs.sort_unstable_by_key(|p| p.key);
        }
        let started = std::mem::replace(&mut self.interface_started, alive);
        self.complete_pairs(nodes, &started, steps, &mut pairs);
        self.table.pairs = pairs;
        if self.by_mass {
            self.table.weight_by_mass(nodes);
        }
    }

    /// Appends the active pairs of the slaves, with their stiffness if the law uses it. `dt` is the
    /// step size [time].
    fn find_pairs_of_slaves(
        &mut self,
        nodes: &Nodes,
        alive: &[bool],
        dt: f64,
        pairs: &mut Vec<Pair>,
    ) {
        self.near_list.renew_slaves(
            (nodes, &self.surface),
            self.histories.with_first(),
            |i| self.candidates.segments_of(i),
            |i| self.histories.of_slave(i),
        );
        self.histories.forget_first();
        let near = (&mut self.near_list, self.motion_since_near_list.path());
        let (surface, histories, detail) = (&self.surface, &self.histories, self.detail);
        let history = |i: u32| histories.of_slave(i as usize);
        let find = |projected: &[ProjectedPair]| {
            let (mut finds, mut pairs) = (Vec::new(), Vec::new());
            for projected in projected.chunk_by(|a, b| a.of.slave_index == b.of.slave_index) {
                let i = projected[0].of.slave_index;
                local_search::find_pairs(
                    (nodes, detail),
                    (surface, alive),
                    i as usize,
                    projected,
                    history(i),
                    dt,
                    (&mut finds, &mut pairs),
                );
            }
            pairs
        };
        let found = self.projected_pairs.project((nodes, surface), near, history, dt, find);
        pairs.extend(found.into_iter().flatten());
        if !self.stiffness.is_empty() {
            for p in pairs {
                let at = self.surface.segments.binary_search_by_key(&p.segment, |s| s.id);
                p.stiffness = at.map_or(0.0, |i| self.stiffness[i]);
            }
        }
    }

    /// Sets the values of the pairs that do not depend on the search: initial gaps of interfaces
    /// that had not `started` in the last step, lever arms, friction and the first force. Records
    /// the nodes that are touched and the largest penetration.
    fn complete_pairs(
        &mut self,
        nodes: &Nodes,
        started: &[bool],
        steps: StepSizes,
        pairs: &mut [Pair],
    ) {
        let with_masses = self.laws().predict();
        for p in pairs {
            if !started[p.interface as usize] {
                p.initial_gap = p.tolerated_gap;
            }
            p.lever(nodes);
            if with_masses {
                p.set_slave_mass(nodes);
            }
            self.surface.set_friction(p, nodes);
            self.record.touched(&p.nodes);
            p.force = self.laws().of_pair(p).initial_force(p, steps);
            let penetration = p.penetration / p.contact_thickness;
            if penetration >= self.penetration && penetration > 0.0 {
                let deepest = place_of(&self.surface, p, nodes);
                if penetration > self.penetration || deepest.is_before(&self.deepest) {
                    (self.penetration, self.deepest) = (penetration, deepest);
                }
            }
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
            laws: self.laws.select(self.pairs),
            nodes,
            free,
            free_spins,
            around,
            coupled,
            steps,
            accelerated,
            // Force weights by mass do not show which node a node faces.
            removes_redundant: !self.by_mass,
            momentum: &mut self.momentum,
        };
        let swept = sweeps.run(t)?;
        self.pairs = swept.pairs;
        self.sweeps += swept.sweeps;
        for (count, is_so) in self.unsettled.iter_mut().zip([swept.accelerated, swept.unsettled]) {
            *count += u64::from(is_so);
        }
        Ok(())
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
            let area =
                surface.area_of((p.nodes[0], &p.normal), &nodes.x, |n| t.bears(n, &p.normal));
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
            self.sliding.raise(2.0 * slid.abs(), || place_of(&self.surface, p, nodes));
            if p.initial_gap < 0.0 {
                work.starting.add(p.work(nodes, steps.dt_velocity));
            }
            let law = self.laws.select(self.pairs).of_pair(p);
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
        let t = &self.table;
        self.histories.store(&self.surface.slaves, &t.pairs);
        self.edges.store_history(t.pairs.iter());
        self.facets.store_history(t.pairs.iter());
    }
}

/// Returns the place of a pair: the first of its nodes on this worker, and the part of its segment.
fn place_of(surface: &Surface, pair: &Pair, nodes: &Nodes) -> ModelPlace {
    let node = pair.nodes.iter().find(|&&n| n != surface::NOT_LOCAL).map(|&n| n as usize);
    let segment = surface.segments.binary_search_by_key(&pair.segment, |s| s.id).ok();
    ModelPlace {
        element: None,
        node: node.map(|n| nodes.id[n]),
        part: segment.map(|i| surface.segments[i].part),
        x: node.map_or([0.0; 3], |n| xyz(&nodes.x[n])),
    }
}
