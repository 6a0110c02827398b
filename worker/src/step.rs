//! The time step: one cycle of the central-difference scheme. Start reading here.
//!
//! `STAGES` is the whole step. Every stage is a function of this file, and its time is booked for
//! the phase in its row.

use crate::coupling::ContactCoupling;
use crate::engine::{Engine, StepConsensus, StepFailure};
use crate::erosion;
use crate::fem::blocks::Portion;
use crate::fem::elements::PassTotals;
use crate::math::rigid_motion::RigidMotion;
use crate::parallel::followed::follow_nodes;
use crate::parallel::particles::sum_over_neighbours;
use crate::parallel::reduction::{Limits, StepContribution};
use crate::parallel::volumes::average_volumes;
use crate::time::ElementSet;
use crate::time::StepSizes;
use crate::work::CARRY_EVERY;
use crumple_proto::report::{PHASES, Phase};
use crumple_proto::transport::{RankLost, Transport};
use tracing::Level;

/// Share of the margin that displacements use from which the motion of the nodes is fitted in each
/// step. Below it, an upper bound of distances suffices in most steps.
const EXACT_FROM: f64 = 0.5;

/// The stages of a step from t to t + dt, in their order.
const STAGES: [StepStage; 18] = [
    with_particles(Phase::Elements, sum_over_particles),
    with_nodal_volumes(Phase::Elements, average_nodal_volumes),
    with_airbags(Phase::Elements, fill_airbags),
    with_followed_nodes(Phase::Elements, follow_directions),
    always(Phase::Elements, element_forces),
    always(Phase::Halo, exchange_element_forces),
    always(Phase::Assemble, accelerate),
    always(Phase::Constraints, constrain),
    with_contact(Phase::Search, fit_motion),
    with_contact(Phase::Halo, exchange_ghosts),
    with_contact(Phase::Search, find_candidates),
    with_contact(Phase::Local, project_pairs),
    with_contact(Phase::Halo, exchange_pairs),
    with_contact(Phase::Contact, enforce_contact),
    always(Phase::Constraints, react),
    always(Phase::Energy, balance_energy),
    always(Phase::Halo, agree),
    always(Phase::Advance, advance),
];

/// Advances the model by one step, with the same dt on every worker. Returns before positions
/// change if there is a failure; the last valid state is then kept.
///
/// # Errors
/// A worker is gone.
pub fn step(engine: &mut Engine, comm: &mut dyn Transport) -> Result<StepConsensus, RankLost> {
    let mut cycle = Cycle::new(engine);
    engine.timer.begin_cycle(engine.clock.cycle, comm);
    // A single worker has no load to share out.
    engine.blocks.timed = engine.timer.is_sampled() && comm.size() > 2;
    let has = |needs: Needs| match needs {
        Needs::Nothing => true,
        Needs::Contact => engine.contact.is_some(),
        Needs::Particles => engine.particles.is_some(),
        Needs::NodalVolumes => engine.blocks.volumes.is_some(),
        Needs::Airbags => !engine.airbags.is_empty(),
        Needs::FollowedNodes => !engine.settings.followed.is_empty(),
    };
    let due: [bool; STAGES.len()] = std::array::from_fn(|i| has(STAGES[i].needs));
    let logged = tracing::enabled!(Level::TRACE);
    let _step = logged.then(|| tracing::trace_span!("step", cycle = engine.clock.cycle).entered());
    for (stage, _) in STAGES.iter().zip(due).filter(|(_, due)| *due) {
        (stage.run)(engine, comm, &mut cycle)?;
        let took = engine.timer.lap_of_stage(stage.phase, comm);
        if logged {
            tracing::trace!(phase = PHASES[stage.phase as usize], ?took);
        }
        if cycle.agreed.failure.is_some() {
            return Ok(cycle.agreed); // all workers know it
        }
    }
    if cycle.agreed.eroded {
        engine.erode(comm)?; // new surfaces without failed elements
    }
    engine.release_broken_ties(comm)?;
    engine.switch_bodies(comm)?;
    engine.adapt(comm)?;
    Ok(cycle.agreed)
}

/// Feature of a job that a stage belongs to.
#[derive(Clone, Copy)]
enum Needs {
    Nothing,
    Contact,
    Particles,
    NodalVolumes,
    Airbags,
    FollowedNodes,
}

/// A stage of the step.
struct StepStage {
    /// The phase for which its time is booked.
    phase: Phase,
    /// Its feature; jobs without it leave the stage out.
    needs: Needs,
    run: StageFunction,
}

type StageFunction = fn(&mut Engine, &mut dyn Transport, &mut Cycle) -> Result<(), RankLost>;

const fn always(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::Nothing, run }
}

const fn with_contact(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::Contact, run }
}

const fn with_particles(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::Particles, run }
}

const fn with_nodal_volumes(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::NodalVolumes, run }
}

const fn with_airbags(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::Airbags, run }
}

const fn with_followed_nodes(phase: Phase, run: StageFunction) -> StepStage {
    StepStage { phase, needs: Needs::FollowedNodes, run }
}

/// Values that one stage hands to a later one.
struct Cycle {
    /// Step sizes around t.
    steps: StepSizes,
    /// Elements that this cycle computes.
    set: ElementSet,
    /// Minima over own elements.
    totals: PassTotals,
    /// Motion of own nodes since the last renewal.
    drift: RigidMotion,
    /// True if contact needs rotational velocities of ghosts.
    couples: bool,
    /// Result of the global reduction.
    agreed: StepConsensus,
}

impl Cycle {
    fn new(engine: &mut Engine) -> Self {
        let clock = &engine.clock;
        engine.timer.recorder().iter_mut().for_each(|r| r.set_cycle(clock.cycle));
        Self {
            steps: clock.steps(engine.loads.damp_at(clock.time)),
            set: clock.element_set(&engine.settings),
            totals: PassTotals::NONE,
            drift: RigidMotion::none(),
            couples: false,
            agreed: StepConsensus::default(),
        }
    }
}

/// Sums over the neighbours of particles: their densities at the present time, and the forces
/// between them.
fn sum_over_particles(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    _: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, blocks, particles, .. } = engine;
    let Some(particles) = particles else { return Ok(()) };
    sum_over_neighbours(comm, nodes, blocks, particles, clock.last_dt)
}

/// Averages the volume strain of tetrahedra and wedges at their nodes, before their stress is
/// computed.
fn average_nodal_volumes(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    _: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, blocks, halo, .. } = engine;
    average_volumes(comm, nodes, blocks, halo, clock.last_dt)
}

/// Computes the volumes of airbags, and their gas at the present time.
fn fill_airbags(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, loads, airbags, constraints, .. } = engine;
    airbags.fill(comm, loads, (nodes, constraints), Some(clock))?;
    cycle.agreed.failure = airbags.fault().map(|_| StepFailure::Airbag);
    Ok(())
}

/// Stores the directions of springs that follow nodes, at the present time.
fn follow_directions(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    _: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { nodes, blocks, settings, .. } = engine;
    follow_nodes(comm, nodes, blocks, settings)
}

/// Computes the element nodal forces of internal stress and pressure, by class. Interface elements
/// at shared nodes come first: other interface elements and interior ones are computed while
/// messages travel.
fn element_forces(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, blocks, halo, loads, settings, .. } = engine;
    blocks.least_dt = clock.least_dt(settings);
    for portion in Portion::ALL {
        let dt = clock.last_dt;
        cycle.totals.add(&blocks.add_internal_forces(nodes, dt, cycle.set, portion));
        loads.add_pressures(blocks, nodes, clock.time, cycle.set, portion);
        if portion == Portion::Shared {
            halo.send_element_forces(comm, blocks, cycle.set)?;
        }
    }
    Ok(())
}

/// Starts the global reduction of the step, and receives the element nodal forces of other workers
/// at shared nodes.
fn exchange_element_forces(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { settings, clock, nodes, blocks, halo, contact, agreement, .. } = engine;
    let eroded =
        clock.cycle.is_multiple_of(erosion::EVERY) && blocks.newly_failed().next().is_some();
    let contribution = StepContribution {
        totals: cycle.totals,
        eroded,
        distant_fraction: halo.distant_fraction(),
        velocities: contact.as_ref().map_or([f64::NEG_INFINITY; 6], |c| c.velocities(nodes)),
        approach: contact.as_ref().map_or(0.0, |c| c.approach),
    };
    agreement.begin(comm, blocks, nodes, &contribution, clock, settings)?;
    halo.recv_element_forces(comm, blocks, cycle.set)
}

/// Sums up the nodal forces in ascending element id, which gives the same bits on any number of
/// workers, and computes the velocities that they cause, without constraints and contact.
fn accelerate(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, blocks, loads, constraints, .. } = engine;
    constraints.begin_step(nodes, clock.time);
    blocks.assemble(nodes, cycle.set);
    loads.add_forces(nodes, clock.time, cycle.set);
    constraints.distribute_forces(comm, nodes, (clock.time, cycle.steps))?;
    nodes.accelerate(cycle.steps.dt_velocity);
    loads.apply_damping(nodes, cycle.steps.dt_velocity);
    loads.damp_parts(nodes, clock.time, cycle.steps.dt_velocity);
    loads.absorb_waves(nodes, cycle.steps.dt_velocity);
    Ok(())
}

/// Imposes prescribed motions and rigid bodies on the velocities without contact. Contact also
/// needs the velocities of tied slaves.
fn constrain(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, contact, constraints, .. } = engine;
    cycle.couples = contact.as_ref().is_some_and(|c| c.has_couples(nodes));
    constraints.constrain(comm, nodes, contact.as_ref(), clock.time, cycle.steps)
}

/// Follows the local nodes by a rigid motion, which is fitted in some steps. It shows how long
/// ghosts stay valid.
fn fit_motion(
    engine: &mut Engine,
    _: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { nodes, halo, motion, agreement, .. } = engine;
    if !halo.links.is_empty() {
        let near_limit = agreement.displacement.share > EXACT_FROM;
        cycle.drift =
            motion.follow(&nodes.x[..nodes.local_count], &nodes.displacements, near_limit);
    }
    Ok(())
}

/// Updates the ghosts: their coordinates, and velocities without contact.
fn exchange_ghosts(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { nodes, halo, agreement, .. } = engine;
    if !halo.links.is_empty() {
        agreement.displacement = halo.exchange_ghosts(comm, nodes, &cycle.drift, cycle.couples)?;
    }
    Ok(())
}

/// Global contact search: finds the segments and edges that are near each slave.
fn find_candidates(
    engine: &mut Engine,
    _: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, contact, constraints, agreement, .. } = engine;
    let Some(contact) = contact else { return Ok(()) };
    contact.update_folds(nodes, clock.cycle);
    let time = (clock.time, cycle.steps.dt);
    contact.refresh_candidates(nodes, constraints, time, agreement.limits());
    Ok(())
}

/// Local contact search: projects slaves onto the near segments and selects the contact pairs.
fn project_pairs(
    engine: &mut Engine,
    _: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, contact, constraints, .. } = engine;
    let Some(contact) = contact else { return Ok(()) };
    contact.find_pairs(nodes, constraints, clock.time, cycle.steps);
    Ok(())
}

/// Sends contact pairs to the other workers that own their nodes.
fn exchange_pairs(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    _: &mut Cycle,
) -> Result<(), RankLost> {
    let replicates = comm.size() > 2 && engine.replicates_pairs();
    let Engine { nodes, halo, contact, pair_exchange, replicated_pairs, agreement, .. } = engine;
    let Some(contact) = contact else { return Ok(()) };
    replicated_pairs.clear();
    if replicates {
        pair_exchange.clear();
        replicated_pairs.gather(comm, nodes, &mut contact.table, |n| halo.users_of(n))?;
        return agreement.complete(comm);
    }
    pair_exchange.exchange_pairs(comm, nodes, halo, &mut contact.table)
}

/// Applies the contact forces, with which gaps at t + dt are not negative.
fn enforce_contact(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { nodes, contact, constraints, pair_exchange, replicated_pairs, .. } = engine;
    let Some(contact) = contact else { return Ok(()) };
    let mut around =
        ContactCoupling { comm, constraints, pair_exchange, replicated: replicated_pairs };
    contact.enforce(nodes, &mut around, cycle.steps)?;
    replicated_pairs.remove(nodes, &mut contact.table);
    Ok(())
}

/// Lets constraints react to contact, in the order that [`Constraints`] states.
///
/// [`Constraints`]: crate::constraints::Constraints
fn react(engine: &mut Engine, comm: &mut dyn Transport, cycle: &mut Cycle) -> Result<(), RankLost> {
    let Engine { clock, nodes, contact, constraints, ledger, loads, .. } = engine;
    ledger.begin_step(clock.cycle);
    if clock.cycle.is_multiple_of(CARRY_EVERY) {
        constraints.walls.carry();
    }
    constraints.react(comm, nodes, contact.as_ref(), (clock.time, cycle.steps), ledger)?;
    constraints.find_broken(comm, nodes, contact.as_ref(), (cycle.steps, loads.gravity()))
}

/// Adds the work of the step to the ledger. The velocities at its end are final here.
fn balance_energy(
    engine: &mut Engine,
    _: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    let Engine { clock, nodes, contact, ledger, loads, constraints, .. } = engine;
    if let Some(contact) = contact {
        contact.finish_step(nodes, cycle.steps, &mut ledger.contact);
    }
    let external = &mut ledger.external;
    let now = (clock.time, cycle.steps);
    constraints.add_prescribed_work(nodes, contact.as_ref(), now, external);
    loads.add_work(nodes, cycle.steps, cycle.set, external);
    Ok(())
}

/// Ends the global reduction: all workers get the same next step, failures and requests.
fn agree(engine: &mut Engine, comm: &mut dyn Transport, cycle: &mut Cycle) -> Result<(), RankLost> {
    let Engine { settings, clock, halo, contact, agreement, .. } = engine;
    let thinnest = contact.as_ref().map_or(f64::INFINITY, |c| c.surface.thinnest);
    // In the first cycle the approach of near pairs is not known yet.
    let skin = settings.contact.as_ref().filter(|_| clock.cycle > 0).map_or(0.0, |c| c.skin);
    cycle.agreed = agreement.finish(comm, Limits { thinnest, skin })?;
    halo.track_approach(clock.last_dt * cycle.agreed.spread, cycle.agreed.sync_distant);
    Ok(())
}

/// Writes the history row if one is due, while the velocities before and after t are known, and
/// moves nodes, rigid bodies, walls and the clock to t + dt.
fn advance(
    engine: &mut Engine,
    comm: &mut dyn Transport,
    cycle: &mut Cycle,
) -> Result<(), RankLost> {
    engine.write_history(comm)?;
    let Engine { settings, clock, nodes, constraints, airbags, .. } = engine;
    nodes.advance(cycle.steps.dt);
    if settings.subcycles > 1 {
        nodes.accumulate_outer_means(settings.subcycles, cycle.set);
    }
    constraints.advance(nodes, cycle.steps.dt);
    clock.advance();
    let stable_dt = airbags.limit(cycle.agreed.stable_dt);
    let stable_dt = constraints.bonds.limit(stable_dt, settings.safety);
    let stable_dt = constraints.belts.limit(stable_dt);
    clock.select_dt(settings, stable_dt);
    Ok(())
}
