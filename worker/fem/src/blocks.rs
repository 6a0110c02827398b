//! All own elements, in blocks of one part and shape (`block.rs`), and their element nodal forces.
//!
//! A node sums its element nodal forces in ascending global element id, own and received ones
//! together: the sum has the same bits on every worker.

mod block;
mod particles;
mod places;
mod side_by_side;
mod steps;
mod volumes;

pub use block::Block;
pub use volumes::{NodalVolumes, RemoteVolume};

use crate::assembly::{AssemblyBatch, AssemblyPlan, ElementCorner};
use crate::elements::{ElementNodalForces, PassTotals};
use crate::nodes::{NodeView, Nodes};
use crate::step_data::StepData;
use crate::time::ElementSet;
use crumple_math::row::{Row, xyz};
use crumple_math::threads;
use crumple_proto::ids::ElemId;
use crumple_proto::initial::{InitialPoint, of_element};
use crumple_proto::mesh::MAX_CORNERS;
use crumple_proto::partition::{ElementRecord, Settings};
use crumple_proto::transport::thread_cpu;
use std::collections::HashSet;

/// An own element, with local node indices.
#[derive(Clone, Copy, Debug)]
pub struct LocalElement {
    /// The element as it is sent to other workers.
    pub record: ElementRecord,
    /// Local nodes of the corners; the last one is repeated.
    pub nodes: [u32; MAX_CORNERS],
    /// True if one of its nodes is shared with another worker.
    pub shared: bool,
    /// Its class at the last renewal; an element with a shared node is an interface element.
    pub class: Class,
}

/// Class of an own element (Wang et al. 2007, sec. 2.1). Exterior elements are no own elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// In the buffer around the box: other workers may need its nodal forces or a copy.
    Interface,
    /// In the internal box: no other worker needs it.
    Interior,
}

/// All own elements.
#[derive(Default)]
pub struct Blocks {
    /// Elements, block by block: in each block those at shared nodes, then the other interface
    /// elements, then interior ones.
    pub elements: Vec<LocalElement>,
    /// The blocks.
    pub blocks: Vec<Block>,
    /// Internal forces at corners, own then received [force].
    pub force: Vec<Row>,
    /// Internal moments at corners, empty without rotations [force length].
    pub moment: Vec<Row>,
    /// Stable step of own elements without mass, which their kernels do not compute [time].
    massless_dt: f64,
    /// True if an own element has scaled mass: the stable steps of the kernels are then not
    /// valid.
    mass_scaled: bool,
    /// Own elements, by block and index in the block, that may use only a part of their mass:
    /// their stable step is shorter than that of the kernel.
    weak: Vec<[usize; 2]>,
    /// True if [`Self::compute_all`] was called.
    pub all_computed: bool,
    /// True if the CPU time of batches is measured in this cycle, for [`Self::kernel_seconds`].
    pub timed: bool,
    /// Stable step below which solids of parts that delete inverted ones are deleted [time].
    pub least_dt: f64,
    /// Number of cycles of an outer step.
    subcycles: u64,
    /// Stable step over all own slow elements at their last computation, per cycle [time].
    pub slow_dt: f64,
    /// Local nodes with slow and with fast elements.
    between: Vec<u32>,
    /// Assembly in steps with all elements, and in steps without slow elements.
    plans: [AssemblyPlan; 2],
    /// Sums of forces and of moments of the nodes in [`AssemblyPlan::early`], with several threads.
    early_sums: [Vec<Row>; 2],
    /// Volume strain of nodes, if own elements average it.
    pub volumes: Option<NodalVolumes>,
}

/// Part of the own elements, by class, in the order of computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Portion {
    /// Groups with interface elements at shared nodes: other workers wait for their forces.
    Shared,
    /// The other groups with interface elements.
    Interface,
    /// Groups of interior elements.
    Interior,
}

impl Portion {
    /// All portions, in the order of computation.
    pub const ALL: [Self; 3] = [Self::Shared, Self::Interface, Self::Interior];
}

/// Number of elements in a batch: their forces and history fit into the second-level cache with
/// all other data.
const BATCH: usize = 256;

/// Bytes of the columns of elements, by use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockBytes {
    /// History columns of laws and elements.
    pub history: usize,
    /// Element nodal forces, and sums of nodes with several threads.
    pub force: usize,
    /// Element nodal moments, and sums as of forces.
    pub moment: usize,
    /// Records, connectivity, flags of groups, and assembly plans.
    pub connectivity: usize,
}

/// A corner of another worker's element at a local node.
#[derive(Clone, Copy, Debug)]
pub struct RemoteCorner {
    /// Local node.
    pub node: u32,
    /// The element.
    pub elem: ElemId,
    /// True if the element is slow.
    pub slow: bool,
}

impl Blocks {
    /// Returns the state at the start of an outer step that all workers have in common:
    /// [`Self::slow_dt`].
    pub fn common_state(&self) -> f64 {
        // A new field is an error here: state has to be added, all else to the last lists.
        let Self {
            slow_dt,
            // Saved with the elements.
            elements: _,
            blocks: _,
            // Computed for each partition.
            massless_dt: _,
            mass_scaled: _,
            weak: _,
            subcycles: _,
            least_dt: _,
            between: _,
            plans: _,
            // Computed in each step before they are used.
            volumes: _,
            force: _,
            moment: _,
            early_sums: _,
            all_computed: _,
            timed: _,
        } = self;
        *slow_dt
    }

    /// Sorts elements into blocks, each with its [`Block::columns`], empty for a new element.
    ///
    /// # Panics
    /// If a part cannot be built; the master checks all parts before it distributes
    /// elements.
    pub fn new(settings: &Settings, elements: Vec<(LocalElement, Vec<f64>)>) -> Self {
        let mut elements = elements;
        let block_of = |e: &LocalElement| (e.record.part, e.record.shape as u8, e.record.slow);
        elements.sort_by_key(|(e, _)| (block_of(e), !e.shared, e.class, e.record.id));
        let (elements, histories): (Vec<_>, Vec<_>) = elements.into_iter().unzip();
        let mut blocks: Vec<Block> = Vec::new();
        let mut first = 0;
        for run in elements.chunk_by(|a, b| block_of(a) == block_of(b)) {
            let base = blocks.last().map_or(0, |b| b.base + b.corner_slots());
            blocks.push(Block::new(
                settings,
                run,
                &histories[first..first + run.len()],
                [first, base],
            ));
            first += run.len();
        }
        let is_weak = |block: usize, i: &usize| {
            let record = &elements[blocks[block].first + i].record;
            record.share < 1.0 && !record.failed && !blocks[block].idle
        };
        let weak = (0..blocks.len()).flat_map(|block| {
            let places = (0..blocks[block].count).filter(move |i| is_weak(block, i));
            places.map(move |i| [block, i])
        });
        let weak = weak.collect();
        let mut all = Self {
            weak,
            mass_scaled: elements.iter().any(|e: &LocalElement| {
                e.record.mass_factor != 1.0 && !settings.is_inactive(e.record.part)
            }),
            massless_dt: elements
                .iter()
                .map(|e| e.record.stable_dt / cycles_of(&e.record, settings.subcycles))
                .fold(f64::INFINITY, f64::min),
            elements,
            blocks,
            all_computed: false,
            timed: false,
            force: Vec::new(),
            moment: Vec::new(),
            subcycles: settings.subcycles,
            least_dt: 0.0,
            slow_dt: f64::INFINITY,
            between: Vec::new(),
            plans: Default::default(),
            early_sums: Default::default(),
            volumes: None,
        };
        all.force = vec![[0.0; 4]; all.own_slots()];
        all.moment = vec![[0.0; 4]; if settings.rotations { all.own_slots() } else { 0 }];
        all
    }

    /// Returns each own element with its internal energy so far, and its hourglass and drilling
    /// energy [energy].
    pub fn energies(&self) -> impl Iterator<Item = (&LocalElement, [f64; 2])> {
        self.blocks.iter().flat_map(|b| {
            let own = self.elements[b.first..b.first + b.count].iter();
            own.enumerate().map(|(i, e)| (e, b.energies(i)))
        })
    }

    /// Returns own elements that have failed and are still in the contact surface, as indices
    /// into `elements`.
    pub fn newly_failed(&self) -> impl Iterator<Item = usize> + '_ {
        let fallible = self.blocks.iter().filter(|b| b.element.can_fail());
        fallible.flat_map(|b| {
            let has = move |i: &usize| b.element.failed(b.state(*i));
            (0..b.count)
                .filter(has)
                .map(|i| b.first + i)
                .filter(|&i| !self.elements[i].record.failed)
        })
    }

    /// Lets these own elements fail as by their law, if they can.
    pub fn fail(&mut self, ids: &HashSet<ElemId>) {
        for b in &mut self.blocks {
            let Some(column) = b.element.failure_column() else { continue };
            let own = self.elements[b.first..b.first + b.count].iter().enumerate();
            let members = own.filter(|(_, e)| ids.contains(&e.record.id)).map(|(i, _)| i);
            // Those that have failed keep their mark: it says why.
            let alive: Vec<usize> = members.filter(|&i| !b.element.failed(b.state(i))).collect();
            alive.into_iter().for_each(|i| b.history.set_column(i, column, 1.0));
        }
    }

    /// Returns true if an own element was deleted because it was inverted, or its step too short.
    pub fn is_deleted(&self, id: ElemId) -> bool {
        let deleting = |b: &&Block| b.element.can_fail();
        self.blocks.iter().filter(deleting).any(|b| {
            let place =
                self.elements[b.first..b.first + b.count].iter().position(|e| e.record.id == id);
            place.is_some_and(|i| b.element.is_deleted(b.state(i)))
        })
    }

    /// Stores the present direction of the own elements of a part that follow two nodes.
    pub fn set_directions(&mut self, part: u32, direction: [f64; 3]) {
        for b in &mut self.blocks {
            let is_of_part = self.elements[b.first].record.part == part;
            let Some(first) = b.element.followed_direction().filter(|_| is_of_part) else {
                continue;
            };
            for index in 0..b.count {
                for (c, &component) in direction.iter().enumerate() {
                    b.history.set_column(index, first + c, component);
                }
            }
        }
    }

    /// Computes forces of unstrained elements too from now on, so that timings of kernels
    /// represent strained elements.
    pub fn compute_all(&mut self) {
        self.all_computed = true;
        self.blocks.iter_mut().for_each(|b| b.unstrained.fill(false));
    }

    /// Returns the bytes in use, without unused capacity.
    pub fn bytes(&self) -> BlockBytes {
        let groups = |b: &Block| size_of_val(&b.groups[..]) + size_of_val(&b.unstrained[..]);
        let lists = self.plans.iter().map(AssemblyPlan::bytes).sum::<usize>();
        let records =
            size_of_val(&self.elements[..]) + self.blocks.iter().map(groups).sum::<usize>();
        BlockBytes {
            history: self.blocks.iter().map(Block::history_bytes).sum(),
            force: size_of_val(&self.force[..]) + size_of_val(&self.early_sums[0][..]),
            moment: size_of_val(&self.moment[..]) + size_of_val(&self.early_sums[1][..]),
            connectivity: records + lists + self.volumes.as_ref().map_or(0, NodalVolumes::bytes),
        }
    }

    /// Returns the data of elements that a step with all elements reads and writes.
    pub fn step_data(&self) -> [StepData; 5] {
        let active = || self.blocks.iter().filter(|b| !b.idle);
        let groups = |b: &Block| size_of_val(&b.groups[..]) + size_of_val(&b.unstrained[..]);
        let row = |data, bytes, reads, writes| StepData { data, bytes, reads, writes };
        let force = size_of_val(&self.force[..]) + size_of_val(&self.moment[..]);
        [
            row("history columns", active().map(Block::column_bytes).sum(), 1, 1),
            row("energies of elements", active().map(Block::energy_bytes).sum(), 1, 1),
            row("nodes of elements", active().map(groups).sum(), 1, 0),
            row("element nodal forces", force, 1, 1),
            row("lists of the assembly", self.plans[0].bytes(), 1, 0),
        ]
    }

    /// Returns the measured CPU time of the kernel of each element per cycle, in the order of
    /// `elements` [s]. It is the mean over its batch, so it depends on formulation, law, points and
    /// state of the elements; elements without forces have none. Batches that were not measured
    /// yet count as the mean of the others, or as 1 if none was.
    pub fn kernel_seconds(&self) -> Vec<f64> {
        let mut seconds = vec![0.0; self.elements.len()];
        let slow = if self.subcycles > 1 { 1.0 / self.subcycles as f64 } else { 1.0 };
        for (plan, share) in self.plans.iter().zip([slow, 1.0 - slow]).filter(|p| p.1 > 0.0) {
            let elements = |batch: &AssemblyBatch| {
                let b = &self.blocks[batch.block];
                let [from, to] = [batch.groups.start, batch.groups.end].map(|g| g * b.lanes());
                b.first + from..b.first + to.min(b.count)
            };
            let (sum, count) = plan
                .batches
                .iter()
                .flatten()
                .filter(|batch| batch.cost > 0.0)
                .fold((0.0, 0), |s, b| (s.0 + b.cost, s.1 + elements(b).len()));
            let mean = if count > 0 { sum / count as f64 } else { 1.0 };
            for batch in plan.batches.iter().flatten() {
                let range = elements(batch);
                let each = if batch.cost > 0.0 { batch.cost / range.len() as f64 } else { mean };
                seconds[range].iter_mut().for_each(|s| *s += share * each);
            }
        }
        seconds
    }

    /// Returns the number of slots of own elements.
    pub fn own_slots(&self) -> usize {
        self.blocks.iter().map(Block::corner_slots).sum()
    }

    /// Returns the first slot of each element, in the order of `elements`.
    pub fn first_slots(&self) -> Vec<usize> {
        self.blocks.iter().flat_map(|b| (0..b.count).map(|i| b.base + b.slots * i)).collect()
    }

    /// Builds the assembly plans. Received corners use the slots after the own ones. Nodes of
    /// loaded elements are assembled at the end, since loads are added to their slots until then.
    pub fn build_assembly(
        &mut self,
        held: usize,
        foreign: &[RemoteCorner],
        is_loaded: impl Fn(ElemId) -> bool,
    ) {
        let (own, count) = (self.own_slots(), self.elements.len());
        // Own elements, then received corners, in ascending element id: the order of summation.
        let mut order: Vec<(ElemId, u32)> =
            self.elements.iter().zip(0..).map(|(e, i)| (e.record.id, i)).collect();
        order.extend(foreign.iter().zip(count as u32..).map(|(f, i)| (f.elem, i)));
        order.sort_unstable();
        let slots = self.first_slots();
        let corners = |i: usize| match self.elements.get(i) {
            Some(e) => {
                ElementCorner { nodes: &e.nodes[..e.record.shape.corners()], first: slots[i] }
            }
            None => ElementCorner {
                nodes: std::slice::from_ref(&foreign[i - count].node),
                first: own + i - count,
            },
        };
        let loaded = self.elements.iter().zip(&slots).filter(|(e, _)| is_loaded(e.record.id));
        let loaded: Vec<_> =
            loaded.map(|(e, &first)| first..first + e.record.shape.corners()).collect();
        let is_slow = |i: usize| {
            self.elements.get(i).map_or_else(|| foreign[i - count].slow, |e| e.record.slow)
        };
        let of = |set: ElementSet| {
            let is_in = |i: &usize| set == ElementSet::All || !is_slow(*i);
            let picked = order.iter().map(|o| o.1 as usize).filter(is_in);
            let mut plan = AssemblyPlan::new(held, picked.map(corners));
            let batches = Portion::ALL.map(|portion| self.batches(portion, set));
            let runs = batches.each_ref().map(|batches| match threads::count() {
                1 => Vec::new(),
                _ => threads::ranges(batches.len(), 1),
            });
            plan.build_batches(batches, runs, own, &loaded, |batch| {
                self.blocks[batch.block].slots_of(&batch.groups)
            });
            plan
        };
        let fast = if self.subcycles > 1 { of(ElementSet::Fast) } else { AssemblyPlan::default() };
        self.plans = [of(ElementSet::All), fast];
        let early = self.plans.iter().filter(|plan| plan.is_cut()).map(|plan| plan.early.len());
        let early = early.max().unwrap_or(0);
        let turning = if self.moment.is_empty() { 0 } else { early };
        self.early_sums = [early, turning].map(|count| vec![[0.0; 4]; count]);
        if self.subcycles > 1 {
            let corners = |i: usize| self.plans.each_ref().map(|plan| plan.slots_of(i).len());
            let is_between =
                |i: &usize| matches!(corners(*i), [all, fast] if 0 < fast && fast < all);
            self.between = (0..held).filter(is_between).map(|i| i as u32).collect();
        }
        self.force.resize(own + foreign.len(), [0.0; 4]);
        if !self.moment.is_empty() {
            self.moment.resize(own + foreign.len(), [0.0; 4]);
        }
    }

    /// Returns the batches of the groups of a portion.
    fn batches(&self, portion: Portion, set: ElementSet) -> Vec<AssemblyBatch> {
        let cut = |(block, b): (usize, &Block)| {
            let groups = match portion {
                _ if b.idle || b.slow && set == ElementSet::Fast => 0..0,
                _ => b.groups_of(portion),
            };
            let (end, size) = (groups.end, BATCH / b.lanes());
            groups
                .step_by(size)
                .map(move |g| AssemblyBatch {
                    block,
                    groups: g..(g + size).min(end),
                    nodes: 0..0,
                    cost: 0.0,
                })
                .collect::<Vec<_>>()
        };
        self.blocks.iter().enumerate().flat_map(cut).collect()
    }

    /// Computes internal forces of a portion, batch by batch, and assembles the nodes that are
    /// complete after a batch. A failure is returned as an index into `elements`.
    ///
    /// With [`ElementSet::All`] slow elements use the mean motion of the previous outer step. Their
    /// forces act in one cycle for all cycles of the outer step.
    pub fn add_internal_forces(
        &mut self,
        nodes: &mut Nodes,
        dt: f64,
        set: ElementSet,
        portion: Portion,
    ) -> PassTotals {
        let mut totals = PassTotals { stable_dt: self.massless_dt, ..PassTotals::NONE };
        if set == ElementSet::All && portion == Portion::Shared {
            self.slow_dt = f64::INFINITY;
        }
        let mut plan = std::mem::take(&mut self.plans[set as usize]);
        let mut batches = std::mem::take(&mut plan.batches[portion as usize]);
        let mut clock = self.timed.then(thread_cpu);
        // The kernels do not know the steps of scaled masses.
        let least_dt = if self.mass_scaled { 0.0 } else { self.least_dt };
        if plan.is_cut() {
            let runs = &plan.runs[portion as usize];
            let steps = [dt, least_dt];
            totals.add(&self.compute_side_by_side(nodes, steps, &plan, (&mut batches, runs)));
        } else {
            for batch in &mut batches {
                totals.add(&self.compute(nodes, [dt, least_dt], batch));
                self.assemble_at(&plan, nodes, &plan.early[batch.nodes.clone()]);
                if let Some(before) = &mut clock {
                    let now = thread_cpu();
                    batch.add_cost(now.saturating_sub(*before));
                    *before = now;
                }
            }
        }
        plan.batches[portion as usize] = batches;
        self.plans[set as usize] = plan;
        totals.stable_dt = totals.stable_dt.min(self.slow_dt);
        totals
    }

    /// Computes a batch.
    fn compute(
        &mut self,
        nodes: &Nodes,
        [dt, least_dt]: [f64; 2],
        batch: &AssemblyBatch,
    ) -> PassTotals {
        let b = &mut self.blocks[batch.block];
        let slots = b.base..b.base + b.corner_slots();
        let moment =
            if self.moment.is_empty() { &mut [][..] } else { &mut self.moment[slots.clone()] };
        let out = ElementNodalForces { force: &mut self.force[slots], moment };
        let (view, steps) = motion_of(b, nodes, [dt, least_dt], self.subcycles);
        let pass = b.forces(batch.groups.clone(), view, steps, out);
        if b.slow {
            let filled = b.slots_of(&batch.groups);
            let turning = if self.moment.is_empty() { 0..0 } else { filled.clone() };
            let columns = [&mut self.force[filled], &mut self.moment[turning]];
            act_for_cycles(columns, self.subcycles);
        }
        self.complete(batch, pass)
    }

    /// Returns the totals of a batch that has been computed: trouble as an index into `elements`,
    /// and a stable step of fast elements.
    fn complete(&mut self, batch: &AssemblyBatch, mut pass: PassTotals) -> PassTotals {
        let b = &self.blocks[batch.block];
        if b.slow {
            self.slow_dt = self.slow_dt.min(pass.stable_dt / self.subcycles as f64);
            pass.stable_dt = f64::INFINITY;
        }
        pass.trouble = pass.trouble.map(|i| b.first + i);
        pass
    }

    /// Returns true if local node `i` has slow elements and no others.
    pub fn has_subcycled_only(&self, i: usize) -> bool {
        self.plans[1].slots_of(i).is_empty() && !self.plans[0].slots_of(i).is_empty()
    }

    /// Returns the terms `f_s f_f / m` of owned nodes with slow and fast elements, at the
    /// start of an outer step [energy/time^2]. f_s are the forces of slow elements, f_f all
    /// others but contact forces, m masses or inertias.
    pub fn subcycle_coupling<'a>(&'a self, nodes: &'a Nodes) -> impl Iterator<Item = f64> + 'a {
        let cycles = self.subcycles as f64;
        let [all, fast] = &self.plans;
        let product = move |column: &[Row], force: &Row, inverse: &Row, i: usize| {
            let sum = |plan: &AssemblyPlan, c: usize| {
                plan.slots_of(i).iter().map(|&s| column[s as usize][c]).sum::<f64>()
            };
            let of = |c: usize| {
                let slow = sum(fast, c) - sum(all, c);
                inverse[c] * (slow / cycles) * (force[c] - slow)
            };
            (0..3).map(of).sum::<f64>()
        };
        let of = move |i: usize| {
            let turning = match self.moment.is_empty() {
                true => 0.0,
                false => product(&self.moment, &nodes.moment[i], &nodes.inv_inertia[i], i),
            };
            product(&self.force, &nodes.force[i], &nodes.inv_mass[i], i) + turning
        };
        self.between.iter().map(|&i| i as usize).filter(move |&i| nodes.is_owned(i)).map(of)
    }

    /// Assembles the local nodes that are not assembled yet. Several threads also give the nodes
    /// the sums that they have computed with the elements.
    pub fn assemble(&self, nodes: &mut Nodes, set: ElementSet) {
        let plan = &self.plans[set as usize];
        match plan.is_cut() {
            true => self.assemble_side_by_side(plan, nodes),
            false => self.assemble_at(plan, nodes, &plan.late),
        }
    }

    fn assemble_at(&self, plan: &AssemblyPlan, nodes: &mut Nodes, which: &[u32]) {
        let which = which.iter().map(|&i| [i as usize; 2]);
        if self.moment.is_empty() {
            plan.assemble((&self.force, 0), &mut nodes.force, which);
        } else {
            let sums = [&mut nodes.force[..], &mut nodes.moment[..]];
            plan.assemble_both(([&self.force, &self.moment], 0), sums, which);
        }
    }

    /// Stores the shape from which the mass is computed in the history of new elements.
    pub fn measure(&mut self, nodes: &Nodes) {
        for b in &mut self.blocks {
            for place in 0..b.unstrained.len() * b.lanes() {
                let e = &self.elements[b.first + place.min(b.count - 1)];
                let mut history = b.history.element(place).to_vec();
                let x = e.nodes.map(|n| xyz(&nodes.x0[n as usize]));
                b.element.measure(&mut history, &x, e.record.own);
                b.history.set(place, &history);
            }
        }
    }

    /// Gives new elements their stress and plastic strain at the start. `initial` is sorted.
    pub fn set_initial(&mut self, nodes: &Nodes, initial: &[InitialPoint]) {
        if initial.is_empty() {
            return;
        }
        for b in self.blocks.iter_mut().filter(|b| !b.idle) {
            let lanes = b.lanes();
            for place in 0..b.unstrained.len() * lanes {
                let e = &self.elements[b.first + place.min(b.count - 1)];
                let points = of_element(initial, e.record.id);
                if points.is_empty() {
                    continue;
                }
                let mut history = b.history.element(place).to_vec();
                let x = e.nodes.map(|n| xyz(&nodes.x0[n as usize]));
                b.element.set_initial(&mut history, &x, points);
                b.history.set(place, &history);
                let is_strained = !b.element.is_unstrained(b.history.element(place));
                b.unstrained[place / lanes] &= !is_strained;
            }
        }
    }

    /// Writes the corner masses and inertias of own elements of the `counted` parts, at initial
    /// coordinates, into the slots.
    pub fn set_corner_masses(&mut self, nodes: &Nodes, counted: impl Fn(u32) -> bool) {
        self.force.fill([0.0; 4]);
        let slots = self.first_slots();
        for b in &self.blocks {
            let own = b.first..b.first + b.count;
            if !counted(self.elements[b.first].record.part) {
                continue;
            }
            for (e, &slot) in self.elements[own.clone()].iter().zip(&slots[own]) {
                let x = e.nodes.map(|n| xyz(&nodes.x0[n as usize]));
                let (m, j) = b.element.corner_mass(&x, e.record.own);
                for c in 0..e.record.shape.corners() {
                    let factor = e.record.mass_factor * e.record.shape.mass_share(c);
                    self.force[slot + c] = [m * factor, j * factor, 0.0, 0.0];
                }
            }
        }
    }

    /// Adds the corner masses to the nodes, in ascending element id.
    pub fn assemble_masses(&mut self, nodes: &mut Nodes) {
        for i in 0..nodes.local_count {
            for &slot in self.plans[0].slots_of(i) {
                nodes.mass[i] += self.force[slot as usize][0];
                if nodes.rotations {
                    nodes.inertia[i] += self.force[slot as usize][1];
                }
            }
            nodes.invert_mass(i);
        }
        // Rigid elements do not overwrite their slots.
        self.force.fill([0.0; 4]);
    }

    /// Removes the corner masses in the slots from the nodes, in ascending element id.
    pub fn remove_masses(&mut self, nodes: &mut Nodes) {
        for i in 0..nodes.local_count {
            let (mut mass, mut inertia) = (0.0, 0.0);
            for &slot in self.plans[0].slots_of(i) {
                mass += self.force[slot as usize][0];
                inertia += self.force[slot as usize][1];
            }
            if mass > 0.0 {
                nodes.mass[i] -= mass;
                if nodes.rotations {
                    nodes.inertia[i] -= inertia;
                }
                nodes.invert_mass(i);
            }
        }
        self.force.fill([0.0; 4]);
    }
}

/// Lets forces and moments of slow elements act in one cycle for all cycles of the outer step.
fn act_for_cycles(columns: [&mut [Row]; 2], subcycles: u64) {
    for column in columns {
        column.as_flattened_mut().iter_mut().for_each(|f| *f *= subcycles as f64);
    }
}

/// Returns the motion that the elements of a block see, and their last step and least stable step
/// [time]: slow elements use the mean motion of the previous outer step.
fn motion_of<'a>(
    block: &Block,
    nodes: &'a Nodes,
    steps: [f64; 2],
    subcycles: u64,
) -> (NodeView<'a>, [f64; 2]) {
    match block.slow {
        true => (nodes.mean_view(), steps.map(|step| subcycles as f64 * step)),
        false => (nodes.view(), steps),
    }
}

/// Returns the number of cycles between two computations of an element.
fn cycles_of(record: &ElementRecord, subcycles: u64) -> f64 {
    if record.slow { subcycles as f64 } else { 1.0 }
}
