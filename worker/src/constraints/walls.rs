//! Rigid walls: a node may not end a step behind a wall. Coulomb friction on the wall.
//!
//! Walls are at rest, have a prescribed motion, or have a mass and recoil along their normal
//! (`walls/push.rs`). Every worker has all walls and moves them identically. During the contact
//! iteration a wall with a mass keeps its velocity of the last step; the impulses of nodes on
//! it are computed after contact. Walls with a mass are processed first, so that none of them
//! changes the velocity of a node that another wall has stopped.

mod push;
mod shape;
#[cfg(test)]
mod tests;

use crate::constraints::prescribed::MotionCurve;
use crate::energy::WallWork;
use crate::math::row::{Row, V3, row, xyz};
use crate::math::threads;
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crate::work::Work;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::each_value;
use crumple_proto::ids::NodeId;
use crumple_proto::transport::{Mailbox, RankLost, Transport};
use crumple_proto::wall::{ResolvedWall, WallForm, WallMotion};
use push::{RecoilCandidate, collect, speed_after};
use serde::{Deserialize, Serialize};
pub(crate) use shape::SurfaceForm;
pub use shape::WallSurface;
use std::ops::Range;

/// Least number of nodes that a thread compares with the walls at a time.
const PIECE: usize = 1024;

/// One wall.
#[derive(Debug)]
pub struct Wall {
    job: ResolvedWall,
    /// Surface at the present time.
    pub surface: WallSurface,
    /// Coulomb friction coefficient.
    pub friction: f64,
    drive: Drive,
    /// Velocities at the last and the next mid-step [length/time].
    last: V3,
    next: V3,
    /// True if it stops nodes in this step.
    acts: bool,
    /// True for each node here that the wall acts on; empty if it acts on all.
    meets: Vec<bool>,
}

/// State of a wall, equal on all workers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WallState {
    surface: WallSurface,
    last: V3,
    next: V3,
    /// Position at the end of the step of a prescribed motion [length].
    to: Option<V3>,
}

impl WallState {
    /// Returns true if it is a state of a job's wall.
    pub fn fits(&self, job: &ResolvedWall) -> bool {
        let motion = [self.last, self.next, self.to.unwrap_or_default()];
        self.surface.fits(job) && motion.iter().flat_map(|v| v.iter()).all(|a| a.is_finite())
    }
}

/// Motion of a wall.
#[derive(Debug)]
enum Drive {
    Still,
    /// Mass of the wall [mass].
    Pushed(f64),
    /// Prescribed motion, and the position at the end of the step [length].
    Led(Box<MotionCurve>, V3),
}

/// All walls of the model.
#[derive(Debug, Default)]
pub struct Walls {
    walls: Vec<Wall>,
    /// Walls with a mass, followed by the others.
    order: Vec<usize>,
    /// Number of walls with a mass.
    pushed: usize,
    /// Impulse of each wall on owned nodes so far [force time].
    pub impulses: Vec<[ExactSum; 3]>,
    /// Number of walls that were there before the run continued; all of them in a new run.
    known: usize,
    near: Vec<RecoilCandidate>,
    mail: Mailbox,
}

impl Walls {
    /// Builds the walls of a job at time 0; `curves` are those of its loads.
    pub fn new(jobs: &[ResolvedWall], curves: &[Vec<[f64; 2]>]) -> Self {
        let walls: Vec<Wall> = jobs.iter().map(|job| Wall::new(job, curves)).collect();
        let (mut order, others): (Vec<usize>, Vec<usize>) =
            (0..walls.len()).partition(|&w| walls[w].softness() > 0.0);
        let pushed = order.len();
        order.extend(others);
        Self {
            order,
            pushed,
            impulses: vec![Default::default(); walls.len()],
            known: walls.len(),
            walls,
            near: Vec::new(),
            mail: Mailbox::default(),
        }
    }

    /// See [`ResolvedWall::inherit`].
    pub fn inherit(&mut self, new: NodeId, between: &[NodeId]) {
        self.walls.iter_mut().for_each(|wall| wall.job.inherit(new, between));
    }

    /// Finds the nodes that each wall acts on, among those present here.
    pub fn bind_local(&mut self, nodes: &Nodes) {
        for w in &mut self.walls {
            w.meets.clear();
            if w.job.nodes.is_some() || !w.job.except.is_empty() {
                w.meets.extend(nodes.id.iter().map(|&id| w.job.allows(id)));
            }
        }
    }

    /// Returns the states of all walls.
    pub fn state(&self) -> Vec<WallState> {
        // A new field is an error here: state has to be added, all else to the last list.
        let Self {
            walls,
            // See `sums`.
            impulses: _,
            // From the job.
            order: _,
            pushed: _,
            known: _,
            // For one step only.
            near: _,
            mail: _,
        } = self;
        let of = |wall: &Wall| {
            // Friction and mass are those of the job; `meets` is by local node, `acts` by time.
            let Wall { job: _, surface, friction: _, drive, last, next, acts: _, meets: _ } = wall;
            let to = if let Drive::Led(_, to) = drive { Some(*to) } else { None };
            WallState { surface: surface.clone(), last: *last, next: *next, to }
        };
        walls.iter().map(of).collect()
    }

    /// Returns the impulses, which are sums of this worker.
    pub fn sums(&self) -> Vec<[ExactSum; 3]> {
        self.impulses.clone()
    }

    /// Sets the states of all walls.
    pub fn restore(&mut self, states: &[WallState]) {
        self.known = states.len();
        for (wall, state) in self.walls.iter_mut().zip(states) {
            wall.surface = state.surface.clone();
            (wall.last, wall.next) = (state.last, state.next);
            if let (Drive::Led(_, to), Some(known)) = (&mut wall.drive, state.to) {
                *to = known;
            }
        }
    }

    /// Returns the owned nodes that start behind the planes that are new since the checkpoint, with
    /// the number of the wall and the depth [length]. A node that a step of size `dt` could have
    /// moved there does not count.
    pub fn behind_new<'a>(
        &'a self,
        nodes: &'a Nodes,
        dt: f64,
    ) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
        let planes = self.walls.iter().enumerate().skip(self.known);
        let planes = planes.filter(|(_, wall)| wall.job.form == WallForm::Plane);
        planes.flat_map(move |(w, wall)| {
            let owned = (0..nodes.local_count).filter(|&i| nodes.is_owned(i));
            let met = owned.filter(|&i| wall.meets.get(i) != Some(&false));
            met.filter_map(move |i| {
                let depth = -wall.surface.distance(&V3::from(xyz(&nodes.x[i])));
                let moved = dt * V3::from(xyz(&nodes.v[i])).norm();
                (depth > moved && nodes.fixed[i] & 7 != 7).then_some((w, i, depth))
            })
        })
    }

    /// Returns true if the model has no walls.
    pub fn is_empty(&self) -> bool {
        self.walls.is_empty()
    }

    /// Returns the walls, in the order of the job.
    pub fn each(&self) -> &[Wall] {
        &self.walls
    }

    /// Returns the number of walls with a mass; each of them needs a message to all other
    /// workers per step.
    pub fn pushed(&self) -> usize {
        self.pushed
    }

    /// Prepares a step: finds the walls that act, sets the velocities of walls with prescribed
    /// motion and stores the last velocities of all.
    pub fn start_step(&mut self, time: f64, dt: f64) {
        for w in &mut self.walls {
            w.acts = w.job.acts_at(time);
            w.last = w.next;
            if let Drive::Led(course, to) = &mut w.drive {
                *to = V3::from(w.job.point) + course.amount(time + dt);
                w.next = (*to - w.surface.position()) / dt;
            }
        }
    }

    /// Returns the velocity with which local node `i`, of velocity `v` without walls, ends the
    /// step in front of all walls [length/time]. It depends only on the states of the node and
    /// the walls, so all workers that hold the node compute the same.
    #[inline]
    pub fn stop(&self, nodes: &Nodes, i: usize, v: Row, dt: f64) -> Row {
        self.stop_at(&self.order, nodes, i, v, dt)
    }

    #[inline]
    fn stop_at(&self, which: &[usize], nodes: &Nodes, i: usize, mut v: Row, dt: f64) -> Row {
        for wall in which.iter().map(|&w| &self.walls[w]) {
            // The fast test here saves nearly all calls.
            if wall.misses(&nodes.x[i], &v, dt) {
                continue;
            }
            if let Some([normal, friction]) = wall.changes(nodes, i, &v, dt) {
                let change = normal + friction;
                for c in 0..3 {
                    v[c] += if nodes.inv_mass[i][c] > 0.0 { change[c] } else { 0.0 };
                }
            }
        }
        v
    }

    /// Keeps all local nodes in front of the walls, starting from their velocities in `v_next`,
    /// or from those in `pushed` for nodes of contact pairs (ascending). Adds the work on owned
    /// nodes to `work`.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn enforce(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        pushed: &[(u32, Row)],
        steps: StepSizes,
        work: &mut WallWork,
    ) -> Result<(), RankLost> {
        let dt = steps.dt;
        for k in 0..self.pushed {
            self.wall_contact(k, comm, nodes, pushed, dt)?;
        }
        let local = pushed.partition_point(|p| (p.0 as usize) < nodes.local_count);
        let (touched, ghosts) = pushed.split_at(local);
        touched.iter().for_each(|&(i, free)| nodes.v_next[i as usize] = free);
        self.enforce_on_local(nodes, steps, work);
        // Ghosts too, if a wall with a mass has changed its velocity since contact: contact
        // stores the slip of pairs.
        for &(i, free) in ghosts.iter().filter(|_| self.pushed > 0) {
            nodes.v_next[i as usize] = self.stop(nodes, i as usize, free, dt);
        }
        Ok(())
    }

    /// Keeps all local nodes in front of the walls, from their velocities in `v_next`. Adds the
    /// work on owned nodes to `work`.
    fn enforce_on_local(&mut self, nodes: &mut Nodes, steps: StepSizes, work: &mut WallWork) {
        // Nearly all nodes stay clear of all walls.
        let is_met = |&i: &usize| {
            let (x, v) = (&nodes.x[i], &nodes.v_next[i]);
            self.walls.iter().any(|w| !w.misses(x, v, steps.dt))
        };
        let met = |range: Range<usize>| range.filter(is_met).collect();
        let ranges = threads::ranges(nodes.local_count, PIECE);
        for i in threads::joined(threads::map(ranges, met)) {
            let free = nodes.v_next[i];
            nodes.v_next[i] = self.stop(nodes, i, free, steps.dt);
            if nodes.is_owned(i) && nodes.v_next[i] != free {
                let [of_walls, of_friction] = self.book(nodes, i, free, steps);
                work.total.add(of_walls);
                work.friction.add(of_friction);
            }
        }
    }

    /// Computes the velocity of the `k`-th wall with a mass from the nodes of all workers,
    /// after the walls before it have acted on them.
    fn wall_contact(
        &mut self,
        k: usize,
        comm: &mut dyn Transport,
        nodes: &Nodes,
        pushed: &[(u32, Row)],
        dt: f64,
    ) -> Result<(), RankLost> {
        let mut near = std::mem::take(&mut self.near);
        near.clear();
        let (before, at) = (&self.order[..k], self.order[k]);
        let mut pushed = pushed.iter().peekable();
        for i in 0..nodes.local_count {
            let free = pushed.next_if(|p| p.0 as usize == i).map_or(nodes.v_next[i], |p| p.1);
            if nodes.is_owned(i) {
                near.extend(self.walls[at].near(
                    nodes,
                    i,
                    &self.stop_at(before, nodes, i, free, dt),
                    dt,
                ));
            }
        }
        collect(comm, &mut near, &mut self.mail)?;
        let wall = &mut self.walls[at];
        if let Drive::Pushed(mass) = wall.drive {
            let normal = wall.surface.direction;
            wall.next = normal * speed_after(mass, wall.next.dot(&normal), &mut near);
        }
        self.near = near;
        Ok(())
    }

    /// Records the impulses that change the velocity of owned node `i` from `v` to its next
    /// one. Returns the work, and that of friction in the motion relative to the walls [energy].
    fn book(&mut self, nodes: &Nodes, i: usize, mut v: Row, steps: StepSizes) -> [Work; 2] {
        let (mut work, mut of_friction) = (Work::default(), Work::default());
        for &w in &self.order {
            let wall = &self.walls[w];
            let Some([normal, friction]) = wall.changes(nodes, i, &v, steps.dt) else { continue };
            let change = normal + friction;
            for c in (0..3).filter(|&c| nodes.inv_mass[i][c] > 0.0) {
                v[c] += change[c];
                let given = nodes.mass[i] * steps.given();
                let p = nodes.mass[i] * change[c] * steps.given();
                self.impulses[w][c].add(p);
                let [before, after] = [nodes.v[i][c], nodes.v_next[i][c]];
                work = work + Work::from_impulse(p, before, after);
                let [before, after] = [before - wall.last[c], after - wall.next[c]];
                of_friction = of_friction + Work::from_impulse(given * friction[c], before, after);
            }
        }
        [work, of_friction]
    }

    /// Applies the reaction to the impulse that a wall has exerted on a rigid body.
    pub fn give_way(&mut self, wall: usize, impulse: &V3) {
        let w = &mut self.walls[wall];
        w.next -= w.recoil(impulse);
    }

    /// Makes room in the sums of impulses for more terms.
    pub fn carry(&mut self) {
        self.impulses.iter_mut().flatten().for_each(ExactSum::carry);
    }

    /// Returns the impulse of a wall on owned nodes so far [force time].
    pub fn impulse(&self, wall: usize) -> [f64; 3] {
        each_value(&self.impulses[wall])
    }

    /// Returns the work of nodes and bodies on walls with a mass in the step [energy].
    pub fn work_on_masses(&self) -> Work {
        let on = |w: &Wall, mass: f64| w.work_in_motion(&((w.next - w.last) * mass));
        self.masses().map(|(w, mass)| on(w, mass)).sum()
    }

    /// Returns the kinetic energy of walls with a mass and their momentum at the present time;
    /// the momentum is that of the last mid-step if the run has `ended`.
    pub fn carried(&self, ended: bool) -> (f64, V3) {
        let kinetic = self.masses().map(|(w, mass)| 0.5 * mass * w.last.dot(&w.next)).sum();
        let velocity = |w: &Wall| if ended { w.next } else { (w.last + w.next) * 0.5 };
        (kinetic, self.masses().map(|(w, mass)| velocity(w) * mass).sum())
    }

    fn masses(&self) -> impl Iterator<Item = (&Wall, f64)> {
        self.order[..self.pushed].iter().filter_map(|&w| match self.walls[w].drive {
            Drive::Pushed(mass) => Some((&self.walls[w], mass)),
            _ => None,
        })
    }

    /// Ends the step: moves the walls to their new positions.
    pub fn advance(&mut self, dt: f64) {
        for w in &mut self.walls {
            let to = match &w.drive {
                Drive::Still => continue,
                Drive::Pushed(_) => w.surface.position() + w.next * dt,
                Drive::Led(_, to) => *to,
            };
            w.surface.move_to(&to);
        }
    }
}

impl Wall {
    fn new(job: &ResolvedWall, curves: &[Vec<[f64; 2]>]) -> Self {
        let surface = WallSurface::new(job);
        let (drive, velocity) = match &job.motion {
            WallMotion::Still => (Drive::Still, V3::zeros()),
            WallMotion::Pushed { mass, speed } => {
                (Drive::Pushed(*mass), surface.direction * *speed)
            }
            WallMotion::Led(motion) => (
                Drive::Led(Box::new(MotionCurve::new(motion, curves)), surface.position()),
                V3::zeros(),
            ),
        };
        let friction = job.friction;
        Self {
            job: job.clone(),
            surface,
            friction,
            drive,
            last: velocity,
            next: velocity,
            acts: job.acts_at(0.0),
            meets: Vec::new(),
        }
    }

    /// Returns the displacement since the start [length].
    pub fn displacement(&self) -> V3 {
        self.surface.position() - V3::from(self.job.point)
    }

    /// Returns the velocity at the next mid-step, as far as it is known [length/time].
    pub fn velocity(&self) -> V3 {
        self.next
    }

    /// Returns the work of an impulse in the motion of the wall [energy].
    pub fn work_in_motion(&self, impulse: &V3) -> Work {
        Work::from_impulses(&row((*impulse).into()), &row(self.last.into()), &row(self.next.into()))
    }

    /// Returns the inverse mass: change of velocity along the normal per unit impulse [1/mass].
    pub fn softness(&self) -> f64 {
        if let Drive::Pushed(mass) = self.drive { 1.0 / mass } else { 0.0 }
    }

    /// Returns the change of the wall's velocity due to an impulse that it exerts, with
    /// opposite sign [length/time].
    pub fn recoil(&self, impulse: &V3) -> V3 {
        self.surface.direction * (self.surface.direction.dot(impulse) * self.softness())
    }

    /// Returns true if the wall stops nodes in this step.
    pub fn acts(&self) -> bool {
        self.acts
    }

    /// Returns true if the wall acts on the node.
    pub fn admits(&self, node: NodeId) -> bool {
        self.job.allows(node)
    }

    /// Returns true if node `i` does not meet the wall. Nodes of replicated pairs come after those
    /// that `meets` knows.
    #[inline]
    fn excludes(&self, nodes: &Nodes, i: usize) -> bool {
        match self.meets.get(i) {
            Some(&met) => !met,
            None => !self.meets.is_empty() && !self.job.allows(nodes.id[i]),
        }
    }

    /// Returns true if a node at `x` with velocity `v` stays clear of the wall in the step, as
    /// most nodes do.
    #[inline(always)]
    fn misses(&self, x: &Row, v: &Row, dt: f64) -> bool {
        !self.acts
            || self.surface.cannot_reach(&V3::from(xyz(x)), &(V3::from(xyz(v)) - self.next), dt)
    }

    /// Returns the change of the velocity `v` that keeps local node `i` in front of the wall, and
    /// the change by friction [length/time].
    #[inline]
    fn changes(&self, nodes: &Nodes, i: usize, v: &Row, dt: f64) -> Option<[V3; 2]> {
        if self.excludes(nodes, i) || self.misses(&nodes.x[i], v, dt) {
            return None;
        }
        let (x, v) = (V3::from(xyz(&nodes.x[i])), V3::from(xyz(v)));
        let against = v - self.next;
        let (along, gap) = self.surface.contact_point(&x, &against, &(v - self.last), dt)?;
        let normal = -gap / dt;
        let sliding = against - along * along.dot(&against);
        let speed = sliding.norm();
        let held =
            if speed > self.friction * normal { self.friction * normal / speed } else { 1.0 };
        Some([along * normal, -(sliding * held)])
    }

    /// Returns owned node `i` with velocity `v` as a candidate for a wall with a mass, if it
    /// may touch the wall in this step.
    fn near(&self, nodes: &Nodes, i: usize, v: &Row, dt: f64) -> Option<RecoilCandidate> {
        if !self.acts || self.meets.get(i) == Some(&false) {
            return None;
        }
        let normal = self.surface.direction;
        let free = (0..3)
            .filter(|&c| nodes.inv_mass[i][c] > 0.0)
            .map(|c| normal[c] * normal[c])
            .sum::<f64>();
        let (x, v) = (V3::from(xyz(&nodes.x[i])), V3::from(xyz(v)));
        // Nodes only slow down the wall: nodes beyond its reach at its last velocity remain
        // beyond.
        let against = v - self.last;
        self.surface.contact_point(&x, &against, &against, dt).filter(|_| free > 0.0)?;
        let touching = self.surface.distance(&x) / dt + normal.dot(&v);
        Some(RecoilCandidate { node: nodes.id[i], mass: nodes.mass[i] * free, touching })
    }
}
