//! Seat belts: chains of segments with tension only, slip rings, retractors and pretensioners.
//!
//! A segment with the unstretched length l between nodes at the distance L has the strain
//! `L/l - 1` and a tension by its curve ([`curve`]), with damping in proportion to the rate of the
//! strain, `(dL/dt)/l - (L/l) (dl/dt)/l`, while it is under tension. The unstretched lengths change
//! where belt slides through a ring or comes out of a retractor ([`slip`]): there the tensions of
//! the present positions are in equilibrium with friction, or with the tension of the retractor.
//! This has no inertia, so the mass of a node stays as belt slides past it. Nodes pass rings and go
//! in and out of retractors ([`path`]); the impulse that changes the velocity of such a node acts
//! on the ring or retractor in the other direction. Wound up nodes follow their retractor on a
//! stiff spring with a damper.
//!
//! The mass M of a node is shared among its n segments. A segment of the stiffness k and the
//! damping c between two nodes is stable as long as `k mu dt^2 + 2 c mu dt <= 4`, as a spring, with
//! `mu = sum of n/M` over its nodes.
//!
//! Work: what belts and retractors take from the nodes is internal energy. What a pretensioner does
//! is external work.
//!
//! All workers have all belts and compute the same values from the motions that the owners of the
//! nodes send.

mod curve;
mod devices;
mod path;
mod sliding;
mod slip;

use super::rigid::Bodies;
use crate::energy::Ledger;
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crate::work::Work;
use bytemuck::{Pod, Zeroable};
use crumple_proto::belt::{BeltLaw, BeltSystem};
use crumple_proto::histories::BeltRecord;
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use curve::TensionCurve;
use devices::{PretensionerState, RetractorState, SensorState, SensorTimes};
use path::PathState;
use serde::{Deserialize, Serialize};
use sliding::{Slid, Sliding};
use std::collections::{BTreeMap, HashMap};

/// Period of the spring of wound up nodes over 2 pi, in steps.
const FOLLOWS: f64 = 10.0;

/// Motion of a node.
#[derive(Clone, Copy, Debug)]
struct BeltMotion {
    /// Coordinates [length].
    x: V3,
    /// Velocity at the last mid-step [length/time].
    v: V3,
    /// Largest inverse mass [1/mass].
    inv_mass: f64,
}

/// Motions of all nodes of belts and sensors.
type BeltMotions = HashMap<NodeId, BeltMotion>;

/// A motion as it is sent.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SentMotion {
    id: NodeId,
    x: [f64; 3],
    v: [f64; 3],
    inv_mass: f64,
}

/// State of a slip ring.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct RingState {
    /// Belt that has moved from the side after it to the side before it [length].
    slip: f64,
    /// Its rate in the last step [length/time].
    rate: f64,
    /// Tensions before and after it [force].
    tensions: [f64; 2],
    /// Energy that friction has dissipated [energy].
    dissipated: f64,
}

/// State of all belts between steps, equal on all workers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeltState {
    paths: Vec<PathState>,
    rings: Vec<RingState>,
    retractors: Vec<RetractorState>,
    pretensioners: Vec<PretensionerState>,
    sensors: Vec<SensorState>,
    /// Time between the velocities of the last two steps [time].
    mid: f64,
}

impl BeltState {
    /// Checks that it is a state of the belts of a job.
    ///
    /// # Errors
    /// It is not: the reason.
    pub fn validate(&self, job: &BeltSystem) -> Result<(), String> {
        let paths = self.paths.len() == job.paths.len()
            && self.paths.iter().zip(&job.paths).all(|(path, job)| path.fits(job));
        let counts = [
            (self.rings.len(), job.rings.len()),
            (self.retractors.len(), job.retractors.len()),
            (self.pretensioners.len(), job.pretensioners.len()),
            (self.sensors.len(), job.sensors.len()),
        ];
        let same = counts.iter().all(|(own, wanted)| own == wanted);
        if paths && same && self.retractors.iter().all(RetractorState::is_sound) {
            Ok(())
        } else {
            Err("its seat belts differ from those of the job".into())
        }
    }
}

/// Returns the curve of a law. It is elastic up to its second point.
fn belt_curve(law: &BeltLaw) -> TensionCurve {
    TensionCurve::new(&law.loading, &law.unloading, law.loading[1][0])
}

/// All seat belts.
#[derive(Debug, Default)]
pub struct Belts {
    job: BeltSystem,
    /// Curves of the laws, and of the retractors.
    laws: Vec<TensionCurve>,
    reels: Vec<TensionCurve>,
    /// Nodes of belts and sensors, ascending.
    nodes: Vec<NodeId>,
    /// Number of segments at each node of a belt.
    segments_at: HashMap<NodeId, f64>,
    state: BeltState,
    /// Forces of this step on local nodes [force].
    acting: Vec<(u32, V3)>,
    /// Work of pretensioners in this step [energy].
    supplied: f64,
    /// Stable step of the belts alone [time].
    stable_dt: f64,
}

impl Belts {
    /// Builds the belts of a job before the start.
    pub fn new(job: &BeltSystem) -> Self {
        let mut segments_at: HashMap<NodeId, f64> = HashMap::new();
        for ends in job.paths.iter().flat_map(|path| path.nodes.windows(2)) {
            ends.iter().for_each(|node| *segments_at.entry(*node).or_default() += 1.0);
        }
        Self {
            laws: job.laws.iter().map(belt_curve).collect(),
            reels: job
                .retractors
                .iter()
                .map(|r| TensionCurve::new(&r.loading, &r.unloading, 0.0))
                .collect(),
            nodes: job.nodes(),
            segments_at,
            state: BeltState {
                paths: job.paths.iter().map(PathState::new).collect(),
                rings: vec![RingState::default(); job.rings.len()],
                retractors: vec![RetractorState::default(); job.retractors.len()],
                pretensioners: vec![PretensionerState::default(); job.pretensioners.len()],
                sensors: vec![SensorState::default(); job.sensors.len()],
                mid: 0.0,
            },
            job: job.clone(),
            acting: Vec::new(),
            supplied: 0.0,
            stable_dt: f64::INFINITY,
        }
    }

    /// Builds the belts of a run that continues.
    pub fn restore(job: &BeltSystem, state: BeltState) -> Self {
        Self { state, ..Self::new(job) }
    }

    /// Returns the state between steps.
    pub fn state(&self) -> &BeltState {
        // A new field is an error here: state has to be added. The others follow from the job or
        // belong to one step.
        let Self {
            job: _,
            laws: _,
            reels: _,
            nodes: _,
            segments_at: _,
            state,
            acting: _,
            supplied: _,
            stable_dt: _,
        } = self;
        state
    }

    /// Returns true if there are no belts.
    pub fn is_empty(&self) -> bool {
        self.job.is_empty()
    }

    /// Returns the stable step with belts [time].
    pub fn limit(&self, stable_dt: f64) -> f64 {
        stable_dt.min(self.stable_dt)
    }

    /// Returns the motions of all nodes of belts and sensors, from their owners.
    fn motions(
        &self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
        bodies: &Bodies,
    ) -> Result<BeltMotions, RankLost> {
        let own = |&id: &NodeId| {
            let n = nodes.local_index(id).filter(|&n| nodes.is_owned(n as usize))?;
            let inverse = bodies.largest_inv_mass(n, nodes);
            let inv_mass = inverse[..3].iter().copied().fold(0.0, f64::max);
            let (x, v) = (xyz(&nodes.x[n as usize]), xyz(&nodes.v[n as usize]));
            Some(SentMotion { id, x, v, inv_mass })
        };
        let all = gather_all(comm, self.nodes.iter().filter_map(own).collect::<Vec<_>>())?;
        let motion = |m: SentMotion| {
            (m.id, BeltMotion { x: m.x.into(), v: m.v.into(), inv_mass: m.inv_mass })
        };
        Ok(all.into_iter().flatten().map(motion).collect())
    }

    /// Lets belt slide, and adds the forces of belts to those of local nodes. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn add_forces(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        bodies: &Bodies,
        (time, steps): (f64, StepSizes),
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        let mut motions = self.motions(comm, nodes, bodies)?;
        let pulled = self.step_devices(&motions, time, steps);
        let mut sliding = Sliding {
            job: &self.job,
            laws: &self.laws,
            reels: &self.reels,
            motions: &mut motions,
            times: [time, steps.dt_before()],
            slid: Slid::default(),
        };
        sliding.slide(&mut self.state, &pulled);
        let Slid { passages, supplied } = sliding.slid;
        self.supplied = supplied;
        let mut forces: Vec<(NodeId, V3)> = Vec::new();
        for passage in &passages {
            let x = motions[&passage.node].x;
            if let Some(n) = nodes.local_index(passage.node) {
                nodes.relocate(n as usize, x.into(), steps.dt_before());
            }
            let push = V3::from(passage.impulse) / steps.dt_velocity;
            forces.extend([(passage.node, push), (passage.anchor, -push)]);
        }
        self.pull(&motions, [steps.dt_before(), steps.dt], &mut forces);
        self.state.mid = steps.dt_velocity;
        self.acting.clear();
        for (id, force) in forces {
            let Some(n) = nodes.local_index(id) else { continue };
            (0..3).for_each(|c| nodes.force[n as usize][c] += force[c]);
            self.acting.push((n, force));
        }
        Ok(())
    }

    /// Forgets the velocities that sensors of accelerations have seen: those of the model are new.
    pub fn forget_velocities(&mut self) {
        self.state.sensors.iter_mut().for_each(|sensor| sensor.forget_velocity());
    }

    /// Updates sensors, pretensioners and locks. Returns for each retractor the length that its
    /// pretensioner pulls in, with the limit of its tension; `None` if none works.
    fn step_devices(
        &mut self,
        motions: &BeltMotions,
        time: f64,
        steps: StepSizes,
    ) -> Vec<Option<[f64; 2]>> {
        let BeltState { retractors, pretensioners, sensors, mid, .. } = &mut self.state;
        let times = SensorTimes { now: time, step: steps.dt_before(), mid: *mid };
        for (state, job) in sensors.iter_mut().zip(&self.job.sensors) {
            state.update(job, motions, |r| retractors[r].rate, times);
        }
        let mut pulled = vec![None; retractors.len()];
        for (state, job) in pretensioners.iter_mut().zip(&self.job.pretensioners) {
            let wanted = state.update(job, sensors, (time, times.step));
            pulled[job.retractor] = wanted.map(|wanted| [wanted, job.force_limit]);
            if wanted.is_none() && state.has_just_ended() {
                retractors[job.retractor].lock(&self.reels[job.retractor]);
            }
        }
        let each = retractors.iter_mut().zip(&self.job.retractors).zip(&self.reels).zip(&pulled);
        for (((state, job), curve), pulled) in each {
            if pulled.is_none() {
                state.update(job, curve, sensors, time);
            }
        }
        pulled
    }

    /// Lists the forces of segments, and those that keep wound up nodes at their retractors. Sets
    /// the stable step. The steps are those before and after the present time [time].
    fn pull(
        &mut self,
        motions: &BeltMotions,
        [step, next]: [f64; 2],
        forces: &mut Vec<(NodeId, V3)>,
    ) {
        self.stable_dt = f64::INFINITY;
        for (index, job) in self.job.paths.iter().enumerate() {
            let path = &mut self.state.paths[index];
            let mut wound = vec![None; path.nodes.len()];
            for reel in self.job.retractors.iter().filter(|reel| reel.path == index) {
                let place = path.place(reel.node);
                let inside = if reel.before { 0..place } else { place + 1..path.nodes.len() };
                inside.for_each(|n| wound[n] = Some(reel.node));
            }
            for (k, segment) in path.segments.iter_mut().enumerate() {
                segment.tension = 0.0;
                if wound[k].is_some() || wound[k + 1].is_some() {
                    continue;
                }
                let ends = [path.nodes[k].0, path.nodes[k + 1].0];
                let law = job.segments[k].law;
                let (curve, damping) = (&self.laws[law], self.job.laws[law].damping);
                let [a, b] = ends.map(|id| &motions[&id]);
                let line = b.x - a.x;
                let (distance, along) = (line.norm(), line.try_normalize(0.0).unwrap_or_default());
                let strain = distance / segment.length - 1.0;
                segment.largest = segment.largest.max(strain);
                let elastic = if strain > 0.0 { curve.at(strain, segment.largest) } else { 0.0 };
                if elastic > 0.0 {
                    let fed = if step > 0.0 { segment.fed / step } else { 0.0 };
                    let parts = along.dot(&(b.v - a.v));
                    let rate = (parts - (1.0 + strain) * fed) / segment.length;
                    segment.tension = (elastic + damping * rate).max(0.0);
                    forces.push((ends[0], along * segment.tension));
                    forces.push((ends[1], -along * segment.tension));
                }
                let soft = ends.map(|id| self.segments_at[&id] * motions[&id].inv_mass);
                let softness = soft[0] + soft[1];
                let k = softness * curve.steepest() / segment.length;
                let c = softness * damping / segment.length;
                self.stable_dt = self.stable_dt.min(4.0 / (c + (c * c + 4.0 * k).sqrt()));
            }
            let period = FOLLOWS * next;
            let inside =
                || path.nodes.iter().zip(&wound).filter_map(|(n, reel)| Some((n.0, (*reel)?)));
            let mut masses: BTreeMap<NodeId, f64> = BTreeMap::new();
            for (id, reel) in inside().filter(|(id, _)| motions[id].inv_mass > 0.0) {
                *masses.entry(reel).or_default() += 1.0 / motions[&id].inv_mass;
            }
            for (id, reel) in inside() {
                let (own, to) = (&motions[&id], &motions[&reel]);
                if own.inv_mass > 0.0 {
                    let pull = (to.v - own.v) * (2.0 / period) + (to.x - own.x) / (period * period);
                    // The reel moves too, by the reaction of all of them.
                    let both = own.inv_mass * (1.0 + masses[&reel] * to.inv_mass);
                    let pull = pull / both;
                    forces.extend([(id, pull), (reel, -pull)]);
                }
            }
        }
    }

    /// Adds the work of belts on owned nodes in the step, with final velocities, to `links`, and
    /// that of pretensioners to `external`.
    pub fn add_work(&self, nodes: &Nodes, steps: StepSizes, ledger: &mut Ledger) {
        for (n, force) in &self.acting {
            let n = *n as usize;
            if nodes.is_owned(n) {
                let force = [force.x, force.y, force.z, 0.0];
                let work = Work::from_impulses(&force, &nodes.v[n], &nodes.v_next[n]);
                ledger.links.add(work * steps.dt_velocity);
            }
        }
        if nodes.me == 0 && self.supplied != 0.0 {
            // All workers know it: count it once.
            let work = Work { before: self.supplied, after: 0.0 };
            ledger.external.add(work);
            ledger.links.add(work * -1.0);
        }
    }

    /// Returns the values of segments, rings and retractors, in the order of
    /// [`BeltSystem::names`].
    pub fn records(&self) -> Vec<BeltRecord> {
        let segment = |s: &path::SegmentState| BeltRecord {
            tensions: [s.tension; 2],
            length: s.length,
            ..BeltRecord::default()
        };
        let ring = |r: &RingState| BeltRecord {
            tensions: r.tensions,
            length: r.slip,
            energy: r.dissipated,
            locked: false,
        };
        let retractor = |r: &RetractorState| BeltRecord {
            tensions: [r.tension; 2],
            length: r.pull_out,
            energy: r.absorbed,
            locked: r.is_locked(),
        };
        let segments = self.state.paths.iter().flat_map(|path| &path.segments).map(segment);
        let rings = self.state.rings.iter().map(ring);
        segments.chain(rings).chain(self.state.retractors.iter().map(retractor)).collect()
    }
}
