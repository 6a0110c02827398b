//! Checkpoints of the engine: what is state, how it is captured, and how an engine continues.
//!
//! The state of elements, nodes and pairs is saved as in migration: a checkpoint has the message
//! that a worker would send if all its elements moved to one other worker. History columns have
//! names there, so new laws and elements need no code here. The rest of the state does not belong
//! to nodes or elements: it is the same on all workers ([`CommonState`]), or a sum of what one
//! worker did ([`WorkerState`]), which may go to any worker.

use super::{Engine, start_threads};
use crate::adaptivity::Adaptivity;
use crate::airbags::{Airbags, BagMemory};
use crate::constraints::{ConstraintState, Constraints};
use crate::contact::Contact;
use crate::contact::state::ContactState;
use crate::energy::Ledger;
use crate::fem::particles::Particles;
use crate::histories::{ContactSums, Histories};
use crate::loads::Loads;
use crate::math::rigid_motion::MotionTracker;
use crate::parallel::migrate::{distribute, pack_all};
use crate::parallel::pair_exchange::PairExchange;
use crate::parallel::partition::{Cuts, PartitionData, build_local_mesh};
use crate::parallel::reduction::StepReduction;
use crate::parallel::replicated_pairs::ReplicatedPairs;
use crate::time::Clock;
use crate::timer::Timer;
use crumple_proto::airbag::ResolvedAirbag;
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::MOST;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::merge_each;
use crumple_proto::partition::Settings;
use crumple_proto::report::{PHASES, PhaseSeconds};
use crumple_proto::transport::{RankLost, Transport};
use crumple_proto::wire;
use serde::{Deserialize, Serialize};

/// State that all workers have in common, as it is read.
#[derive(Debug, Deserialize)]
pub struct CommonState {
    /// Time, cycle and step sizes.
    pub clock: Clock,
    constraints: ConstraintState,
    /// Limits of the step due to elements and to contact [time].
    limits: [f64; 2],
    slow_dt: f64,
    /// See [`Contact::common`].
    started: Vec<bool>,
    /// See [`Contact::common`].
    contact_pairs: u64,
    /// Number of updates of the contact surface because elements have failed.
    erosions: u64,
    airbags: Vec<BagMemory>,
    /// Divisions of shells, if the job asks for them.
    pub adaptivity: Option<Adaptivity>,
}

impl CommonState {
    /// Checks that the state has the bodies, walls, ties and interfaces of a job.
    ///
    /// # Errors
    /// It has others: the reason.
    pub fn validate(&self, settings: &Settings) -> Result<(), String> {
        match &self.adaptivity {
            _ if self.adaptivity.is_some() != settings.adaptivity.is_some() => {
                return Err("only one of it and the job has adaptivity".into());
            }
            Some(adaptivity) => {
                adaptivity.validate(self.clock.cycle)?;
                let mut settings = settings.clone();
                adaptivity.extend(&mut settings);
                self.constraints.validate(&settings)?;
            }
            None => self.constraints.validate(settings)?,
        }
        let interfaces = settings.contact.as_ref().map_or(0, |contact| contact.each().count());
        if self.started.len() != interfaces {
            let count = self.started.len();
            return Err(format!("it has {count} contact interfaces, and the job has {interfaces}"));
        }
        let (bags, jobs) = (self.airbags.len(), settings.loads.airbags.len());
        if bags != jobs {
            return Err(format!("it has {bags} airbags, and the job has {jobs}"));
        }
        let is_other = |(bag, job): (&BagMemory, &ResolvedAirbag)| !bag.fits(job);
        if let Some(bag) = self.airbags.iter().zip(&settings.loads.airbags).position(is_other) {
            return Err(format!("airbag {bag} differs from that of the job"));
        }
        if self.limits.iter().chain([&self.slow_dt]).any(|dt| dt.is_nan() || *dt < 0.0) {
            return Err("its limit of the step is not a valid time".into());
        }
        if self.contact_pairs > MOST {
            return Err("its number of contact pairs is impossible".into());
        }
        if self.erosions > MOST {
            return Err("its number of renewals is impossible".into());
        }
        Ok(())
    }
}

/// Sums of one worker.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WorkerState {
    ledger: Ledger,
    wall_impulses: Vec<[ExactSum; 3]>,
    contact: ContactState,
    contact_sums: ContactSums,
    seconds: PhaseSeconds,
    /// Messages and bytes sent.
    pub sent: [u64; 2],
    /// True after a warning that an edge crosses a surface.
    pub crossed: bool,
    /// Number of deleted elements named in warnings.
    pub named: u64,
}

impl WorkerState {
    /// Checks that the sums are those of the walls, parts and transducers of a job.
    ///
    /// # Errors
    /// They are others: the reason.
    pub fn validate(&self, settings: &Settings) -> Result<(), String> {
        if self.wall_impulses.len() > settings.walls.len() {
            let (count, walls) = (self.wall_impulses.len(), settings.walls.len());
            return Err(format!("it has sums of {count} walls, and the job has {walls}"));
        }
        self.contact.validate(settings.parts.len())?;
        self.contact_sums.validate(settings.parts.len(), settings.histories.transducers.len())?;
        if self.seconds.iter().any(|s| !s.is_finite() || *s < 0.0) {
            return Err("its CPU time is not a valid time".into());
        }
        if self.sent.iter().chain([&self.named]).any(|&count| count > MOST) {
            return Err("its number of messages is impossible".into());
        }
        Ok(())
    }

    /// Adds the sums of another worker.
    pub fn add(&mut self, o: &Self) {
        self.ledger.add(&o.ledger);
        let walls = self.wall_impulses.len().max(o.wall_impulses.len());
        self.wall_impulses.resize(walls, Default::default());
        for (a, b) in self.wall_impulses.iter_mut().zip(&o.wall_impulses) {
            merge_each(a, b);
        }
        self.contact.add(&o.contact);
        self.contact_sums.add(&o.contact_sums);
        (0..PHASES.len()).for_each(|i| self.seconds[i] += o.seconds[i]);
        (0..2).for_each(|i| self.sent[i] += o.sent[i]);
        self.crossed |= o.crossed;
        self.named += o.named;
    }
}

/// The words of a worker's file, and those of the common state.
pub struct Copied {
    /// Elements, nodes and pair histories, as in migration.
    pub parcel: Vec<u64>,
    /// Sums of this worker.
    pub own: WorkerState,
    /// Common state; empty except on the first worker.
    pub common: Vec<u64>,
}

impl Engine {
    /// Copies the state. An outer step must begin. All workers call this together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn copy_state(&mut self, comm: &mut dyn Transport) -> Result<Copied, RankLost> {
        let local = self.take_local_mesh();
        let parcel = pack_all(comm, &local, self.contact.as_ref());
        (self.nodes, self.blocks, self.halo) = (local.nodes, local.blocks, local.halo);
        // A new field is an error here: state has to be added, all else to the last list.
        let Self {
            clock,
            constraints,
            agreement,
            contact,
            blocks,
            ledger,
            histories,
            timer,
            erosions,
            airbags,
            adaptivity,
            // Saved with elements and nodes.
            nodes: _,
            // From the job, or computed for each partition.
            settings: _,
            tree: _,
            boxes: _,
            classes: _,
            halo: _,
            particles: _,
            pair_exchange: _,
            replicated_pairs: _,
            loads: _,
            motion: _,
            centre: _,
            // Set when an outer step begins; empty between steps.
            balance: _,
            inverted: _,
        } = self;
        #[derive(Serialize)]
        struct CheckpointView<'a, C: Serialize> {
            clock: &'a Clock,
            constraints: C,
            limits: [f64; 2],
            slow_dt: f64,
            started: &'a [bool],
            contact_pairs: u64,
            erosions: u64,
            airbags: Vec<BagMemory>,
            adaptivity: &'a Option<Adaptivity>,
        }
        let (started, contact_pairs) = contact.as_ref().map_or((&[][..], 0), Contact::common);
        let view = CheckpointView {
            clock,
            constraints: constraints.state(),
            limits: agreement.limits(),
            slow_dt: blocks.common_state(),
            started,
            contact_pairs,
            erosions: *erosions,
            airbags: airbags.state(),
            adaptivity,
        };
        let traffic = comm.traffic();
        Ok(Copied {
            parcel: parcel?,
            own: WorkerState {
                ledger: ledger.clone(),
                wall_impulses: constraints.walls.sums(),
                contact: contact.as_ref().map(Contact::state).unwrap_or_default(),
                contact_sums: histories.contact_sums(),
                seconds: timer.saved(),
                sent: [traffic.messages, traffic.bytes],
                crossed: false,
                named: 0,
            },
            common: if comm.rank() == 1 { wire::encode(&view) } else { Vec::new() },
        })
    }

    /// Builds the engine of a run that continues. `share` are the elements that this worker has
    /// read, from anywhere; they move to the workers whose boxes have them. All workers call this
    /// together.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn restore(
        comm: &mut dyn Transport,
        mut settings: Settings,
        tree: CutTree,
        share: PartitionData,
        (common, own): (CommonState, WorkerState),
    ) -> Result<Self, RankLost> {
        start_threads(&settings);
        common.constraints.settle(&mut settings);
        let adaptivity = common.adaptivity.and_then(|state| state.with_settings(&settings));
        if let Some(adaptivity) = &adaptivity {
            adaptivity.extend(&mut settings);
        }
        let mut share = distribute(comm, &tree, &share)?;
        let means = std::mem::take(&mut share.means);
        let cuts = Cuts { boxes: &tree, contact: None };
        let mut local = build_local_mesh(comm, &settings, cuts, share, false)?;
        let memories = local.memories;
        if settings.subcycles > 1 {
            local.nodes.retain_outer_means(&means);
        }
        let mut constraints = Constraints::restore(&settings, common.constraints);
        let known_bodies = constraints.bodies.bodies.len();
        constraints.bodies.extend(comm, &settings, &local.nodes)?;
        constraints.bind_local(comm, &mut local.nodes)?;
        let walls = constraints.walls.impulses.len();
        constraints.walls.impulses = own.wall_impulses;
        constraints.walls.impulses.resize(walls, Default::default());
        let mut agreement = StepReduction::new();
        [agreement.elements_dt, agreement.contact_dt] = common.limits;
        let mut timer = Timer::default();
        timer.seconds = own.seconds;
        let mut histories = Histories::default();
        histories.restore(own.contact_sums);
        let contact = settings.contact.as_ref();
        let mut airbags = Airbags::new(&settings.loads);
        airbags.restore(common.airbags);
        let mut engine = Self {
            clock: common.clock,
            loads: Loads::new(&settings.loads),
            airbags,
            constraints,
            particles: Particles::new(&settings),
            contact: contact.map(|c| Contact::new(c, &super::elasticity(&settings))),
            pair_exchange: PairExchange::default(),
            replicated_pairs: ReplicatedPairs::default(),
            motion: MotionTracker::since(&[]),
            adaptivity,
            ledger: own.ledger,
            histories,
            balance: None,
            timer,
            erosions: common.erosions,
            inverted: Vec::new(),
            centre: [0.0; 3],
            boxes: local.boxes,
            classes: local.classes,
            nodes: local.nodes,
            blocks: local.blocks,
            halo: local.halo,
            settings,
            tree,
            agreement,
        };
        engine.blocks.slow_dt = common.slow_dt;
        if known_bodies < engine.settings.rigid.len() {
            let before = engine.energies(true).stored();
            let new: Vec<usize> = (known_bodies..engine.settings.rigid.len()).collect();
            engine.carry_members(&new);
            let after = engine.energies(true).stored();
            engine.ledger.external.transfer(&before, &after);
            engine.renew(comm, engine.tree.clone())?; // ghosts of members are constrained too
        }
        engine.begin_partition(local.surface, |id| memories.get(&id).cloned().unwrap_or_default());
        if let Some(contact) = &mut engine.contact {
            contact.restore(own.contact, (common.started, common.contact_pairs));
        }
        Ok(engine)
    }
}
