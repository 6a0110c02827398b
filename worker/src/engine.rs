//! The serial engine of one worker. It builds mesh, state and laws from its partition and owns
//! them.

mod adaptivity;
mod changes;
pub mod checkpoint;

use crate::adaptivity::Adaptivity;
use crate::airbags::Airbags;
use crate::constraints::Constraints;
use crate::contact::Contact;
use crate::contact::beams::with_edges;
use crate::contact::enforce::Elasticity;
use crate::energy::{Ledger, momentum_sums};
use crate::erosion::{EVERY, erode};
use crate::fem::blocks::Blocks;
use crate::fem::particles::Particles;
use crate::histories::{Histories, HistoryState};
use crate::loads::Loads;
use crate::math::rigid_motion::MotionTracker;
use crate::math::row::V3;
use crate::math::threads;
use crate::nodes::Nodes;
use crate::parallel::boxes::{ClassCounts, WorkerBoxes};
use crate::parallel::ghosts::Ghosts;
use crate::parallel::history_message::Memories;
use crate::parallel::migrate::{centre, distribute, gather_memories, migrate, stay};
use crate::parallel::pair_exchange::PairExchange;
use crate::parallel::partition::{Cuts, LocalMesh, PartitionData, build_local_mesh};
use crate::parallel::reduction::StepReduction;
pub use crate::parallel::reduction::{StepConsensus, StepFailure};
use crate::parallel::replicated_pairs::ReplicatedPairs;
use crate::parallel::surface_update::{Failures, update};
use crate::time::Clock;
use crate::timer::Timer;
use crumple_proto::boxes::CutTree;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::ids::ElemId;
use crumple_proto::mesh::{MAX_CORNERS, Shape};
use crumple_proto::message::ToMaster;
use crumple_proto::partition::Settings;
use crumple_proto::place::ModelPlace;
use crumple_proto::report::{
    Displacement, Energies, HistoryPart, Phase, PhaseSeconds, StepLoads, step_loads,
};
use crumple_proto::trace::Event;
use crumple_proto::transport::{RankLost, Tag, Transport};
use crumple_proto::wire::post;
use std::ops::Range;

/// State that the engine keeps while its local mesh is built again.
struct KeptState {
    slow_dt: f64,
    all_computed: bool,
    /// Last cuts of the second decomposition.
    last_cuts: Option<CutTree>,
}

/// The engine of one worker.
pub struct Engine {
    /// Settings, equal on all workers.
    pub settings: Settings,
    /// Boxes of all workers.
    pub tree: CutTree,
    /// Boxes of this worker at the last renewal.
    pub boxes: WorkerBoxes,
    /// Numbers of elements and nodes by class at the last renewal.
    pub classes: ClassCounts,
    /// Time, cycle and step sizes.
    pub clock: Clock,
    /// Nodal columns.
    pub nodes: Nodes,
    /// Own elements.
    pub blocks: Blocks,
    /// Connections to other workers: shared nodes and ghosts.
    pub halo: Ghosts,
    /// Particles, if the job has any.
    pub particles: Option<Particles>,
    /// Contact, if the job has any.
    pub contact: Option<Contact>,
    /// Contact pairs that other workers know.
    pub pair_exchange: PairExchange,
    /// Contact pairs of other workers whose forces this worker computes too.
    pub replicated_pairs: ReplicatedPairs,
    /// Loads.
    pub loads: Loads,
    /// Airbags.
    pub airbags: Airbags,
    /// Prescribed motion, rigid bodies, rigid walls, ties and their bonds.
    pub constraints: Constraints,
    /// Divisions of shells, if the job asks for them.
    pub adaptivity: Option<Adaptivity>,
    /// Energies.
    pub ledger: Ledger,
    /// Local indices of the nodes, sections and parts whose histories are recorded.
    histories: Histories,
    /// Energies at the start of the present outer step. Later in the outer step, energies of slow
    /// elements and of motion belong to different times.
    balance: Option<Energies<ExactSum>>,
    /// Motion of local nodes since the last repartition or membership update.
    pub motion: MotionTracker,
    /// The global reduction of each step.
    pub agreement: StepReduction,
    /// Time per phase.
    pub timer: Timer,
    /// Number of updates of the contact surface because elements have failed.
    pub erosions: u64,
    /// Own elements that were deleted, see `part.inverted`, and are not reported yet.
    pub inverted: Vec<crumple_proto::ids::ElemId>,
    /// Mean element centre at the last repartition or membership update [length].
    centre: [f64; 3],
}

impl Engine {
    /// Builds the engine for a new partition at time 0. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        settings: Settings,
        tree: CutTree,
        share: PartitionData,
    ) -> Result<Self, RankLost> {
        start_threads(&settings);
        let cuts = Cuts { boxes: &tree, contact: None };
        let mut local = build_local_mesh(comm, &settings, cuts, share, true)?;
        // From here on it is in the histories of the elements.
        let settings = Settings { initial: Vec::new(), ..settings };
        let mut constraints = Constraints::new(comm, &settings, &mut local.nodes)?;
        constraints.bind_local(comm, &mut local.nodes)?;
        if settings.subcycles > 1 {
            local.nodes.retain_outer_means(&[]);
        }
        let mut agreement = StepReduction::new();
        let own = local.blocks.smallest_step(&local.nodes).map_or(f64::INFINITY, |s| s.0);
        let surface = local.surface.as_ref();
        let velocities = surface.map_or([f64::NEG_INFINITY; 6], |s| s.velocities(&local.nodes));
        let thinnest = surface.map_or(f64::INFINITY, |s| s.thinnest);
        let mut stable_dt = agreement.first_step(comm, own, velocities, thinnest)?;
        let mut loads = Loads::new(&settings.loads);
        let mut airbags = Airbags::new(&settings.loads);
        if !airbags.is_empty() {
            loads.bind_local(&local.nodes, &local.blocks, settings.subcycles);
            airbags.fill(comm, &mut loads, (&local.nodes, &constraints), None)?;
            stable_dt = airbags.limit(stable_dt);
        }
        let mut engine = Self {
            clock: Clock::new(&settings, stable_dt),
            loads,
            airbags,
            constraints,
            particles: Particles::new(&settings),
            contact: settings.contact.as_ref().map(|c| Contact::new(c, &elasticity(&settings))),
            pair_exchange: PairExchange::default(),
            replicated_pairs: ReplicatedPairs::default(),
            motion: MotionTracker::since(&[]),
            adaptivity: Adaptivity::new(&settings),
            ledger: Ledger::default(),
            histories: Histories::default(),
            balance: None,
            timer: Timer::default(),
            erosions: 0,
            inverted: Vec::new(),
            centre: [0.0; 3],
            nodes: local.nodes,
            blocks: local.blocks,
            halo: local.halo,
            boxes: local.boxes,
            classes: local.classes,
            settings,
            tree,
            agreement,
        };
        engine.begin_partition(local.surface, |_| Vec::new());
        Ok(engine)
    }

    /// Moves elements to the workers that now own their boxes. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn renew(&mut self, comm: &mut dyn Transport, tree: CutTree) -> Result<(), RankLost> {
        self.renew_without(comm, tree, &[])
    }

    /// As [`Self::renew`], without the elements of some parts.
    fn renew_without(
        &mut self,
        comm: &mut dyn Transport,
        tree: CutTree,
        parts: &[u32],
    ) -> Result<(), RankLost> {
        self.tree = tree;
        let kept = self.kept();
        let local = self.take_local_mesh();
        let mut share = match self.settings.has_second_decomposition() {
            true => stay(comm, &local, self.contact.as_ref())?,
            false => migrate(comm, &self.tree, &local, self.contact.as_ref())?,
        };
        drop(local);
        if !parts.is_empty() {
            share.remove_parts(parts);
        }
        self.build_again(comm, share, kept)
    }

    /// Takes the own elements with their nodes and histories out of the engine, to change them.
    /// [`Self::settle`] follows. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    fn take_share(
        &mut self,
        comm: &mut dyn Transport,
    ) -> Result<(PartitionData, KeptState), RankLost> {
        let kept = self.kept();
        let local = self.take_local_mesh();
        Ok((stay(comm, &local, self.contact.as_ref())?, kept))
    }

    /// Builds the mesh of elements that [`Self::take_share`] returned and that have changed since.
    /// All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    fn settle(
        &mut self,
        comm: &mut dyn Transport,
        share: PartitionData,
        kept: KeptState,
    ) -> Result<(), RankLost> {
        let share = match self.settings.has_second_decomposition() {
            true => share,
            false => distribute(comm, &self.tree, &share)?,
        };
        self.build_again(comm, share, kept)
    }

    /// Returns what the engine keeps while its mesh is built again.
    fn kept(&mut self) -> KeptState {
        KeptState {
            slow_dt: self.blocks.slow_dt,
            all_computed: self.blocks.all_computed,
            last_cuts: self.halo.regions.take().map(|regions| regions.tree),
        }
    }

    /// Builds the local mesh and all that belongs to it. All workers call this together.
    fn build_again(
        &mut self,
        comm: &mut dyn Transport,
        mut share: PartitionData,
        kept: KeptState,
    ) -> Result<(), RankLost> {
        let means = std::mem::take(&mut share.means);
        let cuts = Cuts { boxes: &self.tree, contact: kept.last_cuts.as_ref() };
        let local = build_local_mesh(comm, &self.settings, cuts, share, false)?;
        let memories = local.memories;
        (self.nodes, self.blocks, self.halo) = (local.nodes, local.blocks, local.halo);
        (self.boxes, self.classes) = (local.boxes, local.classes);
        self.blocks.slow_dt = kept.slow_dt; // equal on all workers
        if kept.all_computed {
            self.blocks.compute_all();
        }
        if self.settings.subcycles > 1 {
            self.nodes.retain_outer_means(&means);
        }
        self.constraints.bind_local(comm, &mut self.nodes)?;
        self.begin_partition(local.surface, |id| memories.get(&id).cloned().unwrap_or_default());
        let took = self.timer.lap(Phase::Renewal);
        let ClassCounts { interior, interface, exterior, .. } = self.classes;
        tracing::debug!(interior, interface, exterior, ?took, "members renewed");
        self.record_classes();
        Ok(())
    }

    /// Takes the local mesh out of the engine, to send parts of it.
    fn take_local_mesh(&mut self) -> LocalMesh {
        LocalMesh {
            nodes: std::mem::take(&mut self.nodes),
            blocks: std::mem::take(&mut self.blocks),
            halo: std::mem::take(&mut self.halo),
            surface: None,
            boxes: self.boxes,
            classes: self.classes,
            memories: Memories::default(),
        }
    }

    /// Returns true if each worker computes the forces of all pairs that act on its nodes in this
    /// step. Not in jobs with rigid bodies: a worker does not know the bodies of nodes that it does
    /// not have.
    pub fn replicates_pairs(&self) -> bool {
        self.settings.rigid.is_empty()
            && self.contact.as_ref().is_some_and(Contact::replicates_pairs)
    }

    /// Records the numbers of elements by class, if a recorder is on.
    pub fn record_classes(&mut self) {
        let ClassCounts { interior, interface, exterior, .. } = self.classes;
        let event = Event::Classes([interior, interface, exterior]);
        self.timer.recorder().iter_mut().for_each(|r| r.moment(event));
    }

    /// Removes failed elements from the contact surface. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn erode(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let cycle = self.clock.cycle;
        let _span = tracing::debug_span!("redecomposition", kind = "erosion", cycle).entered();
        self.timer.recorder().iter_mut().for_each(|r| r.moment(Event::Erosion));
        let groups = &self.settings.failure_groups;
        let failures = erode(comm, &mut self.blocks, &self.nodes, &self.halo, groups)?;
        self.inverted.extend(failures.own.iter().filter(|&&id| self.blocks.is_deleted(id)));
        let released = self.constraints.release_failed(comm, &failures.own, &mut self.nodes)?;
        self.erosions += u64::from(self.contact.is_some());
        // Released nodes have another mass, which others have to learn. The second decomposition
        // has to find who searches for new segments.
        if released || self.settings.has_second_decomposition() {
            self.renew(comm, self.tree.clone())
        } else {
            self.update_surface(comm, &failures)
        }
    }

    /// Releases the slaves of ties that have broken, in some cycles. All workers call this
    /// together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn release_broken_ties(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        let due = self.clock.cycle.is_multiple_of(EVERY) && self.constraints.ties.has_broken();
        if !due {
            return Ok(());
        }
        let cycle = self.clock.cycle;
        let _span = tracing::debug_span!("redecomposition", kind = "ties", cycle).entered();
        let dt = self.clock.steps(0.0).dt_stable;
        self.constraints.release_broken(comm, &mut self.nodes, dt)?;
        self.renew(comm, self.tree.clone())
    }

    /// Updates the contact surface after failures; elements and boxes stay.
    fn update_surface(
        &mut self,
        comm: &mut dyn Transport,
        failures: &Failures,
    ) -> Result<(), RankLost> {
        let Some(contact) = &mut self.contact else {
            self.timer.lap(Phase::Renewal);
            return Ok(());
        };
        contact.transfer_marks(&self.nodes); // ghosts may get other indices
        let memories = gather_memories(comm, &self.nodes, &self.halo, contact)?;
        let mesh = (&mut self.nodes, &self.blocks, &mut self.halo);
        let (surface, reference) = (&mut contact.surface, self.motion.reference());
        let updated = update(comm, &self.settings, mesh, surface, failures, reference)?;
        if let Some(surface) = updated.surface {
            let memory_of = |id| memories.get(&id).cloned().unwrap_or_default();
            self.classes.count_exterior(&surface, &self.nodes);
            contact.renew(surface, &self.nodes, memory_of);
            self.record_classes();
        }
        if updated.has_new_ghosts {
            self.constraints.bind_local(comm, &mut self.nodes)?;
        }
        self.timer.lap(Phase::Renewal);
        Ok(())
    }

    fn begin_partition(
        &mut self,
        surface: Option<crate::contact::surface::Surface>,
        memory_of: impl Fn(crumple_proto::ids::NodeId) -> Vec<crate::contact::pairs::PairHistory>,
    ) {
        if let (Some(contact), Some(surface)) = (&mut self.contact, surface) {
            contact.renew(surface, &self.nodes, memory_of);
            let slack = self.halo.slack(&self.nodes);
            self.motion.restart(&self.nodes.x[..self.nodes.local_count], slack);
        }
        self.loads.bind_local(&self.nodes, &self.blocks, self.settings.subcycles);
        self.histories.bind_local(
            &self.settings.histories,
            self.settings.subcycles,
            &self.nodes,
            &self.blocks,
        );
        self.agreement.displacement = Displacement::default();
        self.centre = self.mean_centre();
    }

    /// Returns the mean displacement of own elements since the last repartition or membership
    /// update [length].
    pub fn drift(&self) -> [f64; 3] {
        let now = self.mean_centre();
        std::array::from_fn(|c| now[c] - self.centre[c])
    }

    fn mean_centre(&self) -> [f64; 3] {
        /// Number of elements that a thread sums at a time.
        const PIECE: usize = 1024;
        let (elements, x) = (&self.blocks.elements, &self.nodes.x);
        let of_piece = |piece: Range<usize>| {
            let mut sum = V3::zeros();
            for e in &elements[piece] {
                sum += V3::from(centre(x, e.nodes, e.record.shape));
            }
            sum
        };
        let sums = threads::map(threads::ranges_of_size(elements.len(), PIECE), of_piece);
        (sums.into_iter().sum::<V3>() / elements.len().max(1) as f64).into()
    }

    /// Returns the centre of an own element [length].
    pub fn centre_of(&self, nodes: [u32; MAX_CORNERS], shape: Shape) -> [f64; 3] {
        centre(&self.nodes.x, nodes, shape)
    }

    /// Calls `f` with the centre and the load of every own element, without and with contact. The
    /// sum of all loads is that of `seconds`, the CPU time of a cycle by phase [s].
    ///
    /// The time of each phase is divided by what causes it: element forces by the measured cost of
    /// each kernel, the global search by slaves and candidates, the local search by near
    /// candidates, and contact forces by pairs, of which each costs at most `pair_s` [s]. All other
    /// time goes with the nodes, and so with the number of elements.
    pub fn for_each_load(
        &self,
        seconds: &PhaseSeconds,
        pair_s: f64,
        mut f: impl FnMut([f64; 3], StepLoads),
    ) {
        let elements = &self.blocks.elements;
        // Each node counts for one element.
        let mut element_of = vec![u32::MAX; self.nodes.local_count];
        for (e, i) in elements.iter().zip(0..) {
            e.nodes.iter().for_each(|&n| {
                let first = &mut element_of[n as usize];
                *first = (*first).min(i);
            });
        }
        let on_elements = |counts: &mut dyn Iterator<Item = (u32, usize)>| {
            let mut weights = vec![0.0; elements.len()];
            for (node, count) in counts {
                if let Some(&i) = element_of.get(node as usize) {
                    weights[i as usize] += count as f64;
                }
            }
            weights
        };
        let mut loads = vec![[0.0; 2]; elements.len()];
        let mut rest = step_loads(seconds);
        let mut share_out = |phase: Phase, weights: &[f64], most: f64| {
            let sum = weights.iter().sum::<f64>();
            let kind = usize::from(Phase::OF_CONTACT.contains(&phase));
            if sum > 0.0 {
                let of_phase = seconds[phase as usize].min(most * sum);
                loads.iter_mut().zip(weights).for_each(|(l, w)| l[kind] += of_phase / sum * w);
                rest[kind] -= of_phase;
            }
        };
        share_out(Phase::Elements, &self.blocks.kernel_seconds(), f64::INFINITY);
        if let Some(contact) = &self.contact {
            let candidates = &mut contact.count_candidates().map(|(n, count)| (n, 1 + count));
            share_out(Phase::Search, &on_elements(candidates), f64::INFINITY);
            let near = on_elements(&mut contact.count_near());
            share_out(Phase::Local, &near, f64::INFINITY);
            let pairs = &mut contact.owned_pair_nodes().map(|n| (n, 1));
            share_out(Phase::Contact, &on_elements(pairs), pair_s);
        }
        let rest = rest.map(|r| r / elements.len().max(1) as f64);
        for (e, [motion, contact]) in elements.iter().zip(loads) {
            let load = [motion + rest[0], contact + rest[1]];
            f(self.centre_of(e.nodes, e.record.shape), load);
        }
    }

    /// Sends a history row if one is due. The velocities before and after the present time must
    /// both be known.
    ///
    /// # Errors
    /// The master is gone.
    pub fn write_history(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        if self.settings.subcycles > 1 {
            if self.clock.starts_outer_step(&self.settings) {
                self.balance = Some(self.energies(false));
                let accelerations = self.histories.accelerations(&self.history_state());
                self.histories.start_outer_step(accelerations);
            }
            if let Some(contact) = &self.contact {
                self.histories.record_contact(&self.settings, contact, &self.nodes);
            }
        }
        if self.clock.is_history_due(&self.settings) {
            self.timer.lap_of_stage(Phase::Advance, comm);
            self.send_row(comm, false)?;
            self.timer.lap_of_stage(Phase::Output, comm);
        }
        Ok(())
    }

    fn history_state(&self) -> HistoryState<'_> {
        HistoryState {
            settings: &self.settings,
            clock: &self.clock,
            nodes: &self.nodes,
            blocks: &self.blocks,
            loads: &self.loads,
            airbags: &self.airbags,
            belts: &self.constraints.belts,
            contact: self.contact.as_ref(),
        }
    }

    /// Returns the energies at the present time or, if the run has `ended`, at the previous time.
    ///
    /// With subcycles the balance of [`crate::energy::Ledger::energies`] holds at the start of an
    /// outer step. At a node with only slow or only fast elements it always holds. Nodes with both
    /// oscillate within an outer step of m steps dt. There the conserved energy has, to second
    /// order, the additional term `-(dt^2/12) (2 m - 1) (m - 1) sum f_s f_f/M`, with the forces f_s
    /// of slow and f_f of fast elements on a node of mass M. It counts as kinetic energy here.
    pub fn energies(&self, ended: bool) -> Energies<ExactSum> {
        let mut energies = self.ledger.energies(&self.nodes, &self.blocks);
        if self.settings.subcycles > 1 {
            let (m, dt) = (self.settings.subcycles as f64, self.clock.dt);
            let factor = -dt * dt / 12.0 * (2.0 * m - 1.0) * (m - 1.0);
            let coupling = self.blocks.subcycle_coupling(&self.nodes);
            coupling.for_each(|term| energies.kinetic.add(factor * term));
        }
        if self.nodes.me == 0 {
            energies.kinetic.add(self.constraints.bodies.beyond().0);
            energies.kinetic.add(self.constraints.walls.carried(ended).0);
        }
        energies
    }

    /// Sends a history row. The last row, after the run has `ended`, has the energies of the
    /// previous time; with subcycles those of the start of the last outer step.
    ///
    /// # Errors
    /// The master is gone.
    pub fn send_row(&mut self, comm: &mut dyn Transport, ended: bool) -> Result<(), RankLost> {
        let (nodes, blocks, history) = (&self.nodes, &self.blocks, self.history_state());
        let ((smallest, flattest), (sums, shares)) = threads::both(
            || (blocks.smallest_step(nodes), blocks.flattest(nodes)),
            || (momentum_sums(nodes, ended), self.histories.shares(&history, ended)),
        );
        let (mut momentum, mut angular_momentum) = sums;
        let balance = self.balance.clone().filter(|_| ended);
        let energies = balance.unwrap_or_else(|| self.energies(ended));
        if self.nodes.me == 0 {
            let (angular, carried) =
                (self.constraints.bodies.beyond().1, self.constraints.walls.carried(ended).1);
            (0..3).for_each(|c| angular_momentum[c].add(angular[c]));
            (0..3).for_each(|c| momentum[c].add(carried[c]));
        }
        let place = |(_, id): (f64, ElemId)| self.blocks.place(id, &self.nodes);
        let (penetration, deepest, sliding) =
            self.contact.as_mut().map_or_else(Default::default, |c| {
                let (depth, at) = (&mut c.penetration, &mut c.deepest);
                (std::mem::take(depth), std::mem::take(at), std::mem::take(&mut c.sliding))
            });
        let row = HistoryPart {
            row: self.clock.rows,
            cycle: self.clock.cycle,
            time: self.clock.time,
            dt: self.clock.dt,
            energies,
            momentum,
            angular_momentum,
            wall_impulse: self.constraints.walls.impulses.clone(),
            wall_displacement: self
                .constraints
                .walls
                .each()
                .iter()
                .map(|w| w.displacement().into())
                .collect(),
            pairs: self.contact.as_ref().map_or(0, |c| c.owned_pairs().count() as u64),
            penetration,
            deepest,
            sliding,
            corner_left: flattest.map_or(f64::INFINITY, |f| f.0),
            flattest: flattest.map_or_else(ModelPlace::default, place),
            controlling_dt: smallest.map_or(f64::INFINITY, |s| s.0),
            controlling: smallest.map_or_else(ModelPlace::default, place),
            contact_dt: self.agreement.contact_dt,
            shares,
        };
        self.clock.rows += 1;
        post(comm, 0, Tag::Report, &ToMaster::History(Box::new(row)))
    }
}

/// Starts the threads of this worker. If the system refuses, the worker has one thread; results
/// have the same bits.
pub(super) fn start_threads(settings: &Settings) {
    if let Err(why) = threads::start(settings.threads) {
        tracing::warn!(why, "the worker has a single thread");
    }
}

/// Returns the elastic constants of all parts for contact. Parts whose material cannot be built
/// are refused before the start.
fn elasticity(settings: &Settings) -> Elasticity {
    let of = |part: &crumple_proto::job::Part| {
        // The stiffest layer counts.
        let names = part.materials();
        let materials = settings.materials.iter().filter(|m| names.contains(&m.name.as_str()));
        let elastic = materials
            .filter_map(crate::fem::materials::contact_constants)
            .reduce(|a, b| if b.0 > a.0 { b } else { a });
        let fluid = part.particles.as_ref().map(|p| (p.bulk_modulus(), p.sound_speed));
        elastic.or(fluid).unwrap_or_default()
    };
    let (moduli, speeds) = settings.parts.iter().map(of).unzip();
    Elasticity {
        safety: settings.safety,
        moduli,
        speeds,
        with_edges: with_edges(settings),
        ..Elasticity::default()
    }
}
