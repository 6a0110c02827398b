//! The time step: one cycle of the central-difference scheme. Start reading here.

use crate::constraints::ties::ContactExclusions;
use crate::energy::Work;
use crate::engine::{Engine, Phase, StepConsensus};
use crate::erosion;
use crate::parallel::reduction::{Limits, StepContribution};
use crumple_proto::transport::{RankLost, Transport};

/// Advances the model by one central-difference step from t to t + dt, with the same dt on every
/// worker. Returns before positions change if any worker reports a failure; the last valid state
/// is then kept.
///
/// # Errors
/// A worker is gone.
pub fn step(engine: &mut Engine, comm: &mut dyn Transport) -> Result<StepConsensus, RankLost> {
    let steps = engine.clock.steps(engine.loads.damping);
    engine.timer.recorder().iter_mut().for_each(|r| r.set_cycle(engine.clock.cycle));
    let Engine {
        settings,
        clock,
        nodes,
        blocks,
        halo,
        contact,
        walls,
        ledger,
        motion,
        timer,
        loads,
        prescribed,
        bodies,
        ties,
        ..
    } = engine;

    // False in the cycles of an outer step that leave slow elements out.
    let all = clock.starts_outer_step(settings);
    // Elements at shared nodes come first. The other elements are computed while messages travel.
    let mut totals = blocks.add_internal_forces(nodes, clock.last_dt, all, true);
    loads.add_pressures(blocks, nodes, clock.time, [all, true]);
    halo.send_element_forces(comm, blocks, all)?;
    totals.add(&blocks.add_internal_forces(nodes, clock.last_dt, all, false));
    loads.add_pressures(blocks, nodes, clock.time, [all, false]);
    ledger.book_elements(&totals);
    timer.lap(Phase::Elements);
    let eroded =
        clock.cycle.is_multiple_of(erosion::EVERY) && blocks.newly_failed().next().is_some();
    let velocities = contact.as_ref().map_or([f64::NEG_INFINITY; 6], |c| c.velocities(nodes));
    let approach = contact.as_ref().map_or(0.0, |c| c.approach);
    let known = StepContribution {
        totals,
        eroded,
        distant_fraction: halo.distant_fraction(),
        velocities,
        approach,
    };
    engine.agreement.begin(comm, blocks, nodes, &known, clock, settings)?;
    halo.recv_element_forces(comm, blocks, all)?;
    timer.lap(Phase::Halo);
    blocks.assemble(nodes, all); // ascending element id: same bits on any number of workers
    loads.add_forces(nodes, clock.time, all);
    ties.distribute_forces(comm, nodes)?;
    nodes.accelerate(steps.dt_velocity); // without contact and walls
    loads.apply_damping(nodes, steps.dt_velocity);
    prescribed.apply(nodes, clock.time, steps.dt); // inverse mass is zero there
    bodies.accelerate(comm, nodes, clock.time, steps)?;
    walls.start_step(clock.time, steps.dt);
    timer.lap(Phase::Assemble);

    if let Some(contact) = contact {
        // The contact search needs velocities of slaves without contact.
        ties.update_slave_velocities(comm, nodes, steps.dt)?;
        let spins = contact.has_couples(nodes);
        if spins {
            bodies.turn(nodes);
        }
        if !halo.links.is_empty() {
            let drift = motion.update(&nodes.x[..nodes.local_count]);
            timer.lap(Phase::Search);
            engine.agreement.urgency = halo.exchange_ghosts(comm, nodes, &drift, spins)?;
            timer.lap(Phase::Halo);
        }
        contact.update_folds(nodes, clock.cycle);
        let joined = ContactExclusions { bodies, ties };
        contact.refresh_candidates(
            nodes,
            joined,
            (clock.time, steps.dt),
            engine.agreement.elements_dt,
        );
        timer.lap(Phase::Search);
        contact.find_pairs(nodes, joined, clock.time, steps);
        timer.lap(Phase::Local);
        contact.share_pairs(comm, nodes, halo)?;
        timer.lap(Phase::Halo);
        contact.enforce(comm, nodes, walls, bodies, steps)?; // gap(t + dt) >= 0
        timer.lap(Phase::Contact);
    }
    if let Some(contact) = contact {
        // Masters reach walls with these forces.
        ties.distribute_contact_forces(comm, nodes, contact, steps)?;
    }
    let mut on_walls = Work::default();
    if !walls.is_empty() {
        bodies.add_wall_impulses(walls);
        let mut pushed: Vec<_> =
            contact.iter().flat_map(|c| c.contact_forces(nodes, steps)).collect();
        ties.add_contact_forces(&mut pushed, nodes, steps);
        on_walls = walls.enforce(comm, nodes, &pushed, steps)?;
        timer.lap(Phase::Advance);
    }
    let on_bodies = bodies.finish(nodes, walls, clock.time, steps);
    ties.update_slave_velocities(comm, nodes, steps.dt)?;
    if nodes.me == 0 {
        on_walls += walls.work_on_masses(); // all workers know it: count it once
    }
    ledger.book_wall(on_walls + on_bodies.wall);
    if let Some(contact) = contact {
        ledger.book_contact(contact.finish_step(nodes, steps)); // velocities after walls
        timer.lap(Phase::Contact);
    }

    let led = prescribed.work(nodes, (contact.as_ref(), ties), steps);
    ledger.book_external(loads.work(nodes, steps, all) + led + on_bodies.external);

    let thinnest = contact.as_ref().map_or(f64::INFINITY, |c| c.surface.thinnest);
    // In the first cycle the approach of near pairs is not known yet.
    let skin = settings.contact.as_ref().filter(|_| clock.cycle > 0).map_or(0.0, |c| c.skin);
    let agreed = engine.agreement.finish(comm, Limits { thinnest, skin })?;
    halo.track_approach(clock.last_dt * agreed.spread, agreed.sync_distant);
    timer.lap(Phase::Halo);
    if agreed.failure.is_none() {
        // Here the velocities before and after the present time are both known.
        engine.write_history(comm)?;
        engine.nodes.advance(steps.dt);
        if engine.settings.subcycles > 1 {
            engine.nodes.accumulate_outer_means(engine.settings.subcycles, all);
        }
        engine.bodies.advance(&mut engine.nodes, steps.dt);
        engine.walls.advance(steps.dt);
        engine.clock.advance();
        engine.clock.select_dt(&engine.settings, agreed.stable_dt);
        engine.timer.lap(Phase::Advance);
        if agreed.eroded {
            engine.erode(comm)?; // new surfaces without failed elements
        }
    }
    Ok(agreed)
}
