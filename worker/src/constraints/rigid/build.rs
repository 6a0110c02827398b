//! Rigid bodies at the start of a run, after a checkpoint, and after each renewal: their members,
//! mass and inertia.

use super::body::{Body, Momentum};
use super::{Bodies, Member, NONE};
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::partition::Settings;
use crumple_proto::rigid::RigidBody;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use nalgebra::Matrix3;

/// A member, as it is sent to all workers at the start.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireMember {
    body: u64,
    node: NodeId,
    mass: f64,
    inertia: f64,
    x: [f64; 3],
    v: [f64; 3],
    w: [f64; 3],
}

impl Bodies {
    /// Builds all bodies; their members come from the workers that own them. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &Nodes,
    ) -> Result<Self, RankLost> {
        let mut all = Self::default();
        all.extend(comm, settings, nodes)?;
        Ok(all)
    }

    /// Builds the bodies of the job that are not there yet, from the present state of their
    /// members. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn extend(
        &mut self,
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &Nodes,
    ) -> Result<(), RankLost> {
        self.jobs = settings.rigid.clone();
        let first = self.bodies.len();
        if self.jobs.len() == first {
            return Ok(());
        }
        for job in &self.jobs[first..] {
            self.bodies.push(loose(job, &settings.loads.curves));
            self.arms.push(Vec::new());
            self.beyond.push(Matrix3::zeros());
            self.active.push(false);
        }
        let count = self.bodies.len();
        let rigid: Vec<usize> = (first..count).filter(|&b| self.jobs[b].is_rigid_at(0.0)).collect();
        self.activate(comm, settings, nodes, &rigid)?;
        self.joints.extend(&settings.joints, &self.bodies);
        self.share.resize(count, 0.0);
        self.damped.resize(count, [(V3::zeros(), V3::zeros()); 2]);
        Ok(())
    }

    /// Makes bodies rigid, with the present state of their members. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn activate(
        &mut self,
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &Nodes,
        which: &[usize],
    ) -> Result<(), RankLost> {
        let mut mine: Vec<WireMember> = Vec::new();
        for (b, job) in which.iter().map(|&b| (b, &self.jobs[b])) {
            let owned =
                job.nodes.iter().filter_map(|&id| nodes.local_index(id)).map(|n| n as usize);
            mine.extend(owned.filter(|&i| nodes.is_owned(i)).map(|i| WireMember {
                body: b as u64,
                node: nodes.id[i],
                mass: nodes.mass[i],
                inertia: nodes.inertia[i],
                x: xyz(&nodes.x[i]),
                v: xyz(&nodes.v[i]),
                w: xyz(&nodes.w[i]),
            }));
        }
        let parcels = gather_all(comm, mine)?;
        let mut members: Vec<WireMember> = parcels.concat();
        members.sort_unstable_by_key(|m| (m.body, m.node));
        for &b in which {
            let own: Vec<&WireMember> = members.iter().filter(|m| m.body == b as u64).collect();
            let (body, beyond) = assemble(&self.jobs[b], &settings.loads.curves, &own);
            self.arms[b] = own.iter().map(|m| V3::from(m.x) - body.centre).collect();
            self.bodies[b] = body;
            self.beyond[b] = beyond;
            self.active[b] = true;
        }
        Ok(())
    }

    /// Releases the members of a body.
    pub fn deactivate(&mut self, settings: &Settings, b: usize) {
        self.bodies[b] = loose(&self.jobs[b], &settings.loads.curves);
        self.arms[b].clear();
        self.beyond[b] = Matrix3::zeros();
        self.active[b] = false;
    }

    /// Returns the nodes of a body.
    pub fn nodes_of(&self, b: usize) -> &[NodeId] {
        &self.jobs[b].nodes
    }

    /// Checks that these are the bodies of a job, or its first ones.
    ///
    /// # Errors
    /// They are not: the reason.
    pub fn validate(&self, settings: &Settings) -> Result<(), String> {
        let jobs = &settings.rigid;
        if !self.joints.fits(&settings.joints) {
            return Err("it has other joints than the job".into());
        }
        let count = self.bodies.len();
        let lengths = [self.arms.len(), self.beyond.len(), self.share.len(), self.damped.len()];
        let lengths = [&lengths[..], &[self.active.len()]].concat();
        if count > jobs.len() || lengths.iter().any(|&length| length != count) {
            return Err(format!("it has {count} rigid bodies, and the job has {}", jobs.len()));
        }
        let members = self.arms.iter().zip(jobs).zip(&self.active);
        let other = |((arms, job), active): ((&Vec<V3>, &RigidBody), &bool)| {
            arms.len() != if *active { job.nodes.len() } else { 0 }
        };
        if let Some(body) = members.into_iter().position(other) {
            return Err(format!("rigid body {body} has other nodes in the job"));
        }
        match self.bodies.iter().zip(jobs).position(|(body, job)| !body.fits(job)) {
            Some(body) => Err(format!("rigid body {body} differs from that of the job")),
            None => Ok(()),
        }
    }

    /// Sets the definitions of bodies from a checkpoint.
    pub fn restore(&mut self, settings: &Settings) {
        let (jobs, curves) = (&settings.rigid, &settings.loads.curves);
        self.jobs = jobs.clone();
        self.joints.restore(&settings.joints);
        self.bodies.iter_mut().zip(jobs).for_each(|(body, job)| body.restore(job, curves));
    }

    /// Finds the members that are present here.
    pub fn bind_local(&mut self, nodes: &Nodes) {
        self.members.clear();
        self.copies.clear();
        self.body_of.clear();
        if self.jobs.is_empty() {
            return;
        }
        self.body_of.resize(nodes.len(), NONE);
        for (b, job) in self.jobs.iter().enumerate().filter(|(b, _)| self.active[*b]) {
            for (index, &id) in job.nodes.iter().enumerate() {
                if let Some(n) = nodes.index_of(id) {
                    self.body_of[n as usize] = b as u32;
                    let held = (n as usize) < nodes.local_count;
                    let list = if held { &mut self.members } else { &mut self.copies };
                    list.push(Member { local: n, body: b as u32, index: index as u32 });
                }
            }
        }
    }
}

/// Returns the matrix of an inertia xx, yy, zz, xy, yz, zx.
fn matrix([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

/// Returns a body without members, which nothing moves.
fn loose(job: &RigidBody, curves: &[Vec<[f64; 2]>]) -> Body {
    let still = Momentum::new(V3::zeros(), V3::zeros());
    Body::new(job, curves, 1.0, Matrix3::identity(), V3::zeros(), still)
}

/// Builds a body from its members in ascending node id, with the momenta of the nodes. Returns
/// it with its inertia minus theirs.
fn assemble(
    job: &RigidBody,
    curves: &[Vec<[f64; 2]>],
    members: &[&WireMember],
) -> (Body, Matrix3<f64>) {
    let (mut mass, mut first, mut momentum) = (0.0, V3::zeros(), V3::zeros());
    for m in members {
        mass += m.mass;
        first += V3::from(m.x) * m.mass;
        momentum += V3::from(m.v) * m.mass;
    }
    let (centre, velocity) = (first / mass, momentum / mass);
    let (mut own, mut angular) = (Matrix3::zeros(), V3::zeros());
    for m in members {
        let arm = V3::from(m.x) - centre;
        own += (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * m.mass;
        own += Matrix3::identity() * m.inertia;
        angular += arm.cross(&(V3::from(m.v) - velocity)) * m.mass + V3::from(m.w) * m.inertia;
    }
    let mut inertia = job.inertia.map_or(own, matrix);
    if let Some(added) = job.added_inertia {
        inertia += matrix(added);
    }
    if job.inertia.is_some() || job.added_inertia.is_some() {
        // Rotational velocity of the nodes, with the inertia of the body.
        angular = inertia * own.try_inverse().map_or(V3::zeros(), |i| i * angular);
    }
    (Body::new(job, curves, mass, inertia, centre, Momentum::new(velocity, angular)), inertia - own)
}
