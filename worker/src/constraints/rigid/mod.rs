//! Rigid bodies: nodes that move together, on any number of workers.
//!
//! Every worker has all bodies and computes the same bits for each: the forces on members are
//! gathered from their owners and summed in ascending node id. Contact is coupled within its
//! sweeps: all forces on a body change the velocities of all its nodes before any force is
//! updated again.
//!
//! Joints between bodies act whenever the momenta of bodies change: without contact, in its sweeps,
//! after each impulse of a wall, and at the end of the step.
//!
//! No other force moves members. Their velocities take them exactly from position to position,
//! `x = c + R r`.

pub mod body;
mod build;
mod joint_rows;
mod joints;
#[cfg(test)]
mod tests;
mod walls;

use crate::constraints::walls::Walls;
use crate::contact::surroundings::NodalForces;
use crate::energy::Ledger;
use crate::math::row::{Row, V3, row, xyz};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use body::{Body, Momentum};
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::rigid::RigidBody;
use crumple_proto::transport::{Mailbox, RankLost, Tag, Transport, words_of};
use joints::Joints;
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use walls::{WallCandidate, WallContact, WallImpulse};

/// Index that marks a node that is no member.
const NONE: u32 = u32::MAX;

/// Force and moment on a member, about the centre of the body.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct NodalWrench {
    body: u64,
    node: NodeId,
    force: [f64; 3],
    angular: [f64; 3],
}

/// A member that is present here.
#[derive(Clone, Copy, Debug)]
struct Member {
    local: u32,
    body: u32,
    /// Index in the body's list.
    index: u32,
}

/// Contact of a worker's nodes with a body in a step.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct BodyContact {
    /// Number of touched members.
    count: u64,
    /// Largest compliance of a touched member, as a multiple of that of its nodal mass.
    heaviest: f64,
}

/// Number of words of the force and moment on a member in messages.
pub const ACTING_WORDS: usize = words_of::<NodalWrench>();
/// Number of words per body in the messages of [`Bodies::prepare_contact`].
pub const MET_WORDS: usize = words_of::<BodyContact>();

/// All rigid bodies. A checkpoint has all fields that are not skipped: those are derived from the
/// job and the local mesh, or belong to one step.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Bodies {
    #[serde(skip)]
    jobs: Vec<RigidBody>,
    /// The bodies, in the order of the job.
    pub bodies: Vec<Body>,
    /// True for the bodies that are rigid at present. The others have no members here, and unit
    /// mass.
    active: Vec<bool>,
    /// Difference between the inertia that the job prescribes and that of the nodal masses;
    /// sums over nodes do not contain it.
    beyond: Vec<Matrix3<f64>>,
    /// Positions of all members relative to the centre at time 0, per body in ascending node id
    /// [length].
    arms: Vec<Vec<V3>>,
    #[serde(skip)]
    members: Vec<Member>,
    /// Ghosts that are members.
    #[serde(skip)]
    copies: Vec<Member>,
    /// Body of each node here; empty without bodies.
    #[serde(skip)]
    body_of: Vec<u32>,
    /// Joints between the bodies.
    joints: Joints,
    /// Momenta without contact, walls and joints.
    free: Vec<Momentum>,
    /// Factor on the compliance of single nodal masses that contact uses, per body.
    share: Vec<f64>,
    /// True if contact pairs involve a body in this step.
    coupled: bool,
    /// Damping impulses on each body in this step: without contact, and on its contact forces.
    damped: Vec<[(V3, V3); 2]>,
    /// Impulses of walls and bounds in this step.
    #[serde(skip)]
    pushes: Vec<WallImpulse>,
    /// Velocities of walls after the impulses of bodies.
    wall_velocities: Vec<V3>,
    #[serde(skip)]
    acting: Vec<NodalWrench>,
    #[serde(skip)]
    met: Vec<BodyContact>,
    #[serde(skip)]
    mail: Mailbox,
}

impl Bodies {
    /// Returns the local indices of members with forces or moments, contact excepted. Workers
    /// send these to each other for owned nodes.
    pub fn acted_on<'a>(&'a self, nodes: &'a Nodes) -> impl Iterator<Item = u32> + 'a {
        let pushed = |n: usize| {
            nodes.force[n] != [0.0; 4] || nodes.moment.get(n).is_some_and(|m| *m != [0.0; 4])
        };
        self.members.iter().map(|m| m.local).filter(move |&n| pushed(n as usize))
    }

    /// Returns the local members of some bodies, with the velocity and the rotational velocity that
    /// their body gives them at the last mid-step.
    pub fn carried<'a>(
        &'a self,
        of: &'a [usize],
        nodes: &'a Nodes,
    ) -> impl Iterator<Item = (usize, V3, V3)> + 'a {
        let active = of.iter().filter(|&&b| self.active[b]);
        active.map(|&b| (&self.bodies[b], &self.jobs[b])).flat_map(move |(body, job)| {
            let spin = body.last_spin;
            let local = job.nodes.iter().filter_map(|&id| nodes.local_index(id));
            local.map(move |n| {
                let arm = V3::from(xyz(&nodes.x[n as usize])) - body.centre;
                (n as usize, body.last.velocity + spin.cross(&arm), spin)
            })
        })
    }

    /// Returns the bodies that become rigid, and those that deform again, at a time.
    pub fn due(&self, time: f64) -> Vec<usize> {
        let bodies = self.jobs.iter().zip(&self.active).enumerate();
        let changes = bodies.filter(|(_, (job, active))| job.is_rigid_at(time) != **active);
        changes.map(|(b, _)| b).collect()
    }

    /// Returns true if a body of a job is rigid for the rest of the run.
    pub fn has_settled(&self, b: usize, job: &RigidBody) -> bool {
        self.active.get(b) == Some(&true) && job.stays_rigid()
    }

    /// Returns true if a body is rigid at present.
    pub fn is_active(&self, body: usize) -> bool {
        self.active[body]
    }

    /// Returns true if there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Returns the body of node `n`, if it is a member.
    pub fn body_of(&self, n: u32) -> Option<usize> {
        self.body_of.get(n as usize).filter(|&&b| b != NONE).map(|&b| b as usize)
    }

    /// Returns true if a node and a segment belong to one body, so that they cannot move
    /// relative to each other.
    pub fn share_body(&self, slave: u32, segment: &[u32; 4]) -> bool {
        self.body_of(slave).is_some_and(|b| segment.iter().all(|&n| self.body_of(n) == Some(b)))
    }

    /// Computes the momenta at the next mid-step with joints, without contact and walls, and the
    /// velocities of local members from them.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn accelerate(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        time: f64,
        steps: StepSizes,
    ) -> Result<(), RankLost> {
        if self.is_empty() {
            return Ok(());
        }
        self.acting.clear();
        for m in self.members.iter().filter(|m| nodes.is_owned(m.local as usize)) {
            let i = m.local as usize;
            if nodes.force[i] == [0.0; 4] && nodes.moment[i] == [0.0; 4] {
                continue; // as for most members
            }
            let (force, moment) = (V3::from(xyz(&nodes.force[i])), V3::from(xyz(&nodes.moment[i])));
            let arm = V3::from(xyz(&nodes.x[i])) - self.bodies[m.body as usize].centre;
            act(
                &mut self.acting,
                m.body as usize,
                nodes.id[i],
                &force,
                &(arm.cross(&force) + moment),
            );
        }
        self.gather(comm, false)?;
        for body in &mut self.bodies {
            body.start_step(time, steps.dt);
        }
        self.push_all(steps.dt_velocity);
        for body in &mut self.bodies {
            body.add_loads(time, steps.dt_velocity);
        }
        let b = steps.given() - 1.0;
        for (body, damped) in self.bodies.iter_mut().zip(&mut self.damped) {
            *damped = [body.damp(b), (V3::zeros(), V3::zeros())];
        }
        self.free.clear();
        self.free.extend(self.bodies.iter().map(|b| b.next));
        self.coupled = false;
        self.joints.start_step(&self.bodies, steps);
        self.joints.solve(&mut self.bodies);
        let motions: Vec<(V3, V3)> =
            self.bodies.iter().map(|b| (b.next.velocity, b.spin(&b.next.angular))).collect();
        for m in &self.members {
            let (velocity, spin) = motions[m.body as usize];
            let arm =
                V3::from(xyz(&nodes.x[m.local as usize])) - self.bodies[m.body as usize].centre;
            nodes.v_next[m.local as usize] = row((velocity + spin.cross(&arm)).into());
        }
        Ok(())
    }

    /// Sets the rotational velocities of local members to those of their bodies.
    pub fn turn(&self, nodes: &mut Nodes) {
        for m in &self.members {
            nodes.w_next[m.local as usize] =
                row(self.bodies[m.body as usize].present_spin().into());
        }
    }

    /// Prepares the contact sweeps over the nodes `touched`. Returns true if contact pairs
    /// involve a body on any worker.
    ///
    /// Simultaneous updates converge if the assumed compliances bound the real one. Two bounds
    /// hold: the compliances of the body's nodal masses as if they were not connected, and the
    /// compliances of its k touched nodes, each times k. The smaller bound is used, as a factor
    /// on the former. With `couples`, forces F come with moments m. With the arm r from the
    /// centre to a node and the inverse s of the smallest inertia, the response of a body is at
    /// most `|F|^2/M + s |r x F + m|^2 <= |F|^2 (1/M + 2 s r^2) + 2 s |m|^2`.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn prepare_contact(
        &mut self,
        comm: &mut dyn Transport,
        touched: &[u32],
        nodes: &Nodes,
        couples: bool,
    ) -> Result<bool, RankLost> {
        if self.is_empty() {
            return Ok(false);
        }
        let mut met = std::mem::take(&mut self.met);
        met.clear();
        met.resize(self.bodies.len(), BodyContact::default());
        for &n in touched.iter().filter(|&&n| nodes.is_owned(n as usize)) {
            let Some(b) = self.body_of(n) else { continue };
            let (body, i) = (&self.bodies[b], n as usize);
            let arm = V3::from(xyz(&nodes.x[i])) - body.centre;
            let times = if couples { 2.0 } else { 1.0 };
            let mut heavy =
                nodes.mass[i] * (1.0 / body.mass + times * arm.norm_squared() * body.softest);
            if couples {
                heavy = heavy.max(2.0 * nodes.inertia[i] * body.softest);
            }
            met[b].count += 1;
            met[b].heaviest = met[b].heaviest.max(heavy);
        }
        self.mail.start();
        self.mail.extend(&met);
        self.mail.exchange_with_all(comm, Tag::Bodies, |mail| {
            for (sum, theirs) in met.iter_mut().zip(mail.rest::<BodyContact>()) {
                sum.count += theirs.count;
                sum.heaviest = sum.heaviest.max(theirs.heaviest);
            }
        })?;
        self.coupled = met.iter().any(|m| m.count > 0);
        for ((share, body), m) in self.share.iter_mut().zip(&self.bodies).zip(&met) {
            let factor = (m.count as f64 * m.heaviest).min(1.0);
            *share = if body.is_prescribed() { 0.0 } else { factor };
        }
        self.met = met;
        Ok(self.coupled)
    }

    /// Returns the inverse mass that contact uses at local node `n` [1/mass].
    pub fn inv_mass(&self, n: u32, nodes: &Nodes) -> Row {
        match self.body_of(n) {
            Some(b) if nodes.mass[n as usize] > 0.0 => [self.share[b] / nodes.mass[n as usize]; 4],
            _ => nodes.inv_mass[n as usize],
        }
    }

    /// Returns an inverse mass of local node `n` with which forces on all members of a body at once
    /// move them no less than the body does [1/mass].
    ///
    /// Free members would move more than the body, whose mass is the sum of theirs. An inertia that
    /// the job prescribes can be smaller than that of the nodal masses. The response to a moment is
    /// then larger by at most the ratio of the largest nodal to the smallest prescribed inertia.
    pub fn largest_inv_mass(&self, n: u32, nodes: &Nodes) -> Row {
        let Some(b) = self.body_of(n) else { return nodes.inv_mass[n as usize] };
        let (body, mass) = (&self.bodies[b], nodes.mass[n as usize]);
        if body.is_prescribed() || mass == 0.0 {
            return [0.0; 4];
        }
        let times = match self.beyond[b] == Matrix3::zeros() {
            true => 1.0,
            false => ((body.inertia - self.beyond[b]).norm() * body.softest).max(1.0),
        };
        [times / mass, times / mass, times / mass, 0.0]
    }

    /// Returns the inverse rotational inertia that contact uses at local node `n` [1/(mass
    /// length^2)].
    pub fn inv_inertia(&self, n: u32, nodes: &Nodes) -> Row {
        match self.body_of(n) {
            Some(b) if nodes.inertia[n as usize] > 0.0 => {
                [self.share[b] / nodes.inertia[n as usize]; 4]
            }
            _ => nodes.inv_inertia[n as usize],
        }
    }

    /// Applies contact forces to bodies, then the walls; updates the velocities of the touched
    /// nodes. Returns true if `changed` is true on any worker.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn apply_contact(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        forces: NodalForces<'_>,
        walls: &Walls,
        steps: StepSizes,
        changed: bool,
    ) -> Result<bool, RankLost> {
        let NodalForces { touched, total, couples } = forces;
        self.acting.clear();
        for (k, (&n, force)) in
            touched.iter().zip(total).enumerate().filter(|(_, (n, _))| nodes.is_owned(**n as usize))
        {
            if let Some(b) = self.body_of(n) {
                let arm = V3::from(xyz(&nodes.x[n as usize])) - self.bodies[b].centre;
                let angular =
                    couples.get(k).map_or(arm.cross(force), |couple| arm.cross(force) + couple);
                act(&mut self.acting, b, nodes.id[n as usize], force, &angular);
            }
        }
        let changed = self.gather(comm, changed)?;
        for (body, free) in self.bodies.iter_mut().zip(&self.free) {
            body.next = *free;
        }
        self.push_all(steps.dt_velocity);
        self.slow_all(steps);
        self.joints.solve(&mut self.bodies);
        self.keep_out(walls, steps.dt);
        for &n in touched {
            if let Some(b) = self.body_of(n) {
                let body = &self.bodies[b];
                let arm = V3::from(xyz(&nodes.x[n as usize])) - body.centre;
                nodes.v_next[n as usize] = row(body.velocity_at(&arm).into());
                if !couples.is_empty() {
                    nodes.w_next[n as usize] = row(body.present_spin().into());
                }
            }
        }
        Ok(changed)
    }

    /// Applies the impulses of bodies during the contact iteration to walls that have a mass;
    /// nodes come into contact with these walls afterwards.
    pub fn add_wall_impulses(&self, walls: &mut Walls) {
        if self.coupled {
            self.push_walls(walls);
        }
    }

    fn push_walls(&self, walls: &mut Walls) {
        let of_walls = self.pushes.iter().filter_map(|p| Some((p.wall?, &p.impulse)));
        of_walls.for_each(|(wall, impulse)| walls.give_way(wall, impulse));
    }

    /// Computes the motion of bodies in the step, once all forces are known, and the velocities
    /// of members, ghosts included. Returns the work on bodies that sums over nodes do not
    /// contain, on the first worker only.
    pub fn finish(
        &mut self,
        nodes: &mut Nodes,
        walls: &mut Walls,
        time: f64,
        steps: StepSizes,
        ledger: &mut Ledger,
    ) {
        if self.is_empty() {
            return;
        }
        if !self.coupled {
            self.keep_out(walls, steps.dt);
            self.push_walls(walls);
        }
        let turn = |all: &mut [Body]| all.iter_mut().for_each(|b| b.rotate(time, steps.dt));
        turn(&mut self.bodies);
        self.joints.close(&mut self.bodies, steps, turn);
        // Ghosts too: contact stores the slip of pairs, independent of the owner of their
        // nodes.
        let frames: Vec<(V3, Matrix3<f64>)> =
            self.bodies.iter().map(|b| b.next_frame(steps.dt)).collect();
        let per_dt = 1.0 / steps.dt;
        for m in self.members.iter().chain(&self.copies) {
            let ((centre, turn), i) = (&frames[m.body as usize], m.local as usize);
            let place = centre + turn * self.arms[m.body as usize][m.index as usize];
            (0..3).for_each(|c| nodes.v_next[i][c] = (place[c] - nodes.x[i][c]) * per_dt);
        }
        for m in self.members.iter().chain(&self.copies) {
            nodes.w_next[m.local as usize] = row(self.bodies[m.body as usize].next_spin.into());
        }
        if nodes.me == 0 {
            self.book(walls, steps, ledger);
        }
    }

    /// Records the impulses of walls and the work of walls, stops, damping and constraints.
    fn book(&self, walls: &mut Walls, steps: StepSizes, ledger: &mut Ledger) {
        // Impulse of a wall, without the part that damping takes.
        let given = steps.given();
        for p in &self.pushes {
            let body = &self.bodies[p.body];
            let felt = body.work(&p.impulse, &p.arm.cross(&p.impulse));
            ledger.wall.total.add(felt * given);
            ledger.external.add(felt * (1.0 - given));
            if let Some(wall) = p.wall {
                (0..3).for_each(|c| walls.impulses[wall][c].add(p.impulse[c] * given));
                let felt = body.work(&p.friction, &p.arm.cross(&p.friction));
                let on_wall = walls.each()[wall].work_in_motion(&p.friction);
                ledger.wall.friction.add((felt + on_wall * -1.0) * given);
            }
        }
        if !self.joints.is_empty() {
            let of_joints = self.joints.impulses(self.bodies.len());
            for (body, (impulse, angular)) in self.bodies.iter().zip(&of_joints) {
                // As for walls, damping takes a part of forces.
                let felt = body.work(impulse, angular);
                ledger.links.add(felt * given);
                ledger.external.add(felt * (1.0 - given));
            }
        }
        for (body, damped) in self.bodies.iter().zip(&self.damped) {
            ledger.external.add(body.prescribed_work());
            let (impulse, angular) = &body.loaded;
            ledger.external.add(body.work(impulse, angular));
            for (impulse, angular) in damped {
                ledger.external.add(body.work(impulse, angular));
            }
        }
    }

    /// Ends the step: moves bodies and their local members to their new positions.
    pub fn advance(&mut self, nodes: &mut Nodes, dt: f64) {
        self.bodies.iter_mut().for_each(|b| b.advance(dt));
        self.joints.advance(&self.bodies);
        let frames: Vec<(V3, Matrix3<f64>)> = self.bodies.iter().map(Body::frame).collect();
        for m in &self.members {
            let (centre, turn) = &frames[m.body as usize];
            // Their velocities brought them there already, except for round-off.
            nodes.x[m.local as usize] =
                row((centre + turn * self.arms[m.body as usize][m.index as usize]).into());
        }
    }

    /// Returns kinetic energy and angular momentum of the inertia that nodal masses do not
    /// contain; the energy uses the rotational velocities before and after the step.
    pub fn beyond(&self) -> (f64, V3) {
        let (mut energy, mut angular) = (0.0, V3::zeros());
        for (body, inertia) in self.bodies.iter().zip(&self.beyond) {
            let own = |spin: &V3| body.turn.inverse_transform_vector(spin);
            let (before, after) = (own(&body.last_spin), own(&body.next_spin));
            energy += 0.5 * before.dot(&(inertia * after));
            angular += body.turn * (inertia * (before + after)) * 0.5;
        }
        (energy, angular)
    }

    /// Applies the impulses of the gathered forces, in ascending node id.
    fn push_all(&mut self, mid: f64) {
        for run in self.acting.chunk_by(|a, b| a.body == b.body) {
            let (force, angular) = added_up(run);
            self.bodies[run[0].body as usize].add_impulse(&(force * mid), &(angular * mid));
        }
    }

    /// Applies damping to the forces that have just been added.
    fn slow_all(&mut self, steps: StepSizes) {
        let by = steps.dt_damped - steps.dt_velocity;
        if by == 0.0 {
            return;
        }
        self.damped.iter_mut().for_each(|d| d[1] = (V3::zeros(), V3::zeros()));
        for run in self.acting.chunk_by(|a, b| a.body == b.body) {
            let (body, (force, angular)) = (run[0].body as usize, added_up(run));
            self.damped[body][1] = self.bodies[body].apply_damping(force * by, angular * by);
        }
    }

    /// Gathers the forces on other workers' members, in ascending (body, node). Returns true if
    /// `flag` is true on any worker.
    fn gather(&mut self, comm: &mut dyn Transport, flag: bool) -> Result<bool, RankLost> {
        let Self { acting, mail, .. } = self;
        let mut any = flag;
        mail.start();
        mail.push(u64::from(flag));
        mail.extend(acting);
        mail.exchange_with_all(comm, Tag::Bodies, |mail| {
            any |= mail.take::<u64>() != 0;
            acting.extend_from_slice(mail.rest());
        })?;
        self.acting.sort_unstable_by_key(|a| (a.body, a.node));
        Ok(any)
    }

    /// Keeps members in front of walls, and centres within their bounds.
    fn keep_out(&mut self, walls: &Walls, dt: f64) {
        self.pushes.clear();
        if walls.is_empty() && self.bodies.iter().all(|body| body.limits.is_empty()) {
            return;
        }
        self.wall_velocities.clear();
        self.wall_velocities.extend(walls.each().iter().map(|w| w.velocity()));
        let mut meeting = WallContact {
            walls,
            velocity: &mut self.wall_velocities,
            dt,
            pushes: &mut self.pushes,
        };
        let joined = !self.joints.is_empty();
        let speed = |body: &Body, arms: &[V3]| {
            let far = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
            body.next.velocity.norm() + far * body.present_spin().norm()
        };
        // Joints may give a body the speed of any other one.
        let fastest = if joined {
            self.bodies.iter().zip(&self.arms).map(|(b, arms)| speed(b, arms)).fold(0.0, f64::max)
        } else {
            0.0
        };
        let mut near: Vec<Vec<WallCandidate>> = Vec::new();
        for (b, (arms, job)) in self.arms.iter().zip(&self.jobs).enumerate() {
            let mut list = meeting.find_candidates(&self.bodies[b], (arms, &job.nodes), fastest);
            if !joined {
                meeting.sweep(&mut self.bodies[b], &mut list);
            }
            near.push(list);
        }
        if joined {
            meeting.sweep_with_joints(&mut self.bodies, &mut self.joints, &mut near);
        }
        for (b, list) in near.iter().enumerate() {
            meeting.record(b, list);
        }
    }
}

/// Returns the sum of forces and moments on one body, in order.
fn added_up(run: &[NodalWrench]) -> (V3, V3) {
    run.iter().fold((V3::zeros(), V3::zeros()), |sum, a| {
        (sum.0 + V3::from(a.force), sum.1 + V3::from(a.angular))
    })
}

/// Appends the force and moment on an owned member, unless both are zero.
fn act(acting: &mut Vec<NodalWrench>, body: usize, node: NodeId, force: &V3, angular: &V3) {
    if *force != V3::zeros() || *angular != V3::zeros() {
        acting.push(NodalWrench {
            body: body as u64,
            node,
            force: (*force).into(),
            angular: (*angular).into(),
        });
    }
}
