//! Bonds: springs that hold nodes near the faces from which their ties have released them, until
//! they have parted by the opening of the failure.
//!
//! A tie is rigid until it fails with the force `F_0` of its limit. From then on `r` is the
//! position of the slave relative to its point on the face, in the axes of the face, and `r_0`
//! that of the failure. The bond acts as if it had been stretched by `s_0 = |F_0|/k_0` before:
//! `s = r - r_0 + s_0 F_0/|F_0|`, without the part of it that is a compression. The force
//!
//! `F = |F_0| (1 - D) s/q,  D = (q - s_0)/w`,
//!
//! with the largest `q = |s|` so far and the opening w, begins with `F_0`, falls linearly to zero
//! as the slave moves away, and returns to zero along a secant when it comes back. Its work until
//! the end, `|F_0| w / 2`, does not depend on the stiffness `k_0`, and `F . ds` is dissipated or
//! stored, never gained: the secant is the gradient of an energy. (Damage as in bilinear cohesive
//! laws, such as Camanho & Davila 2002, NASA/TM-2002-211737, section 2, with a rigid start. The
//! mode at the failure is kept: `|F_0|` is the limit in its direction.)
//!
//! The stiffness is `k_0 = STIFFNESS m/dt^2` with the mass of the tie, so that bonds raise no
//! eigenvalue of the mesh by more than `2 STIFFNESS / dt^2`.
//!
//! The reaction is divided among the masters by their weights, and with it its moment if they
//! rotate. Without rotations of the masters the moment of the force about the point on the face,
//! of the order of force times opening, is not carried.
//!
//! All workers have all bonds and compute the same values from the positions that the owners of
//! the nodes send.

use super::ties::exchange::of_owners;
use super::ties::failure::face_axes;
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crate::work::{Work, WorkSum};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::tie::Tie;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap, HashSet};

/// Stiffness of bonds at their start, times the squared step over the mass. Elements at nine tenths
/// of their stable step leave room for 0.38.
const STIFFNESS: f64 = 0.2;

/// A bond.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Bond {
    tie: Tie,
    /// Size of the force at the failure [force].
    limit: f64,
    /// Relative position of the slave without force, in the axes of the face [length].
    origin: [f64; 3],
    /// Stretch at the failure, and largest one so far [length].
    first: f64,
    largest: f64,
}

impl Bond {
    /// Returns the stretch at a relative position, in the axes of the face [length].
    fn stretch(&self, relative: V3) -> V3 {
        let s = relative - V3::from(self.origin);
        V3::new(s.x, s.y, s.z.max(0.0))
    }

    /// Returns the damage, between 0 and 1; from 1 on there is no force.
    fn damage(&self) -> f64 {
        let opening = self.tie.failure.as_ref().map_or(0.0, |strength| strength.opening);
        (self.largest - self.first) / opening
    }

    /// Returns the nodes on which it depends.
    fn nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let corners = self.tie.failure.iter().flat_map(|strength| strength.corners);
        std::iter::once(self.tie.node).chain(self.tie.masters.iter().map(|m| m.0)).chain(corners)
    }
}

/// Positions of nodes of bonds [length].
type NodePlaces = HashMap<NodeId, V3>;

/// Returns the axes of the face of a tie, and the arm from its point on the face to its slave.
fn face_and_arm(tie: &Tie, places: &NodePlaces) -> Option<(nalgebra::Matrix3<f64>, V3)> {
    let strength = tie.failure.as_ref()?;
    let foot: V3 = tie.masters.iter().map(|(id, share)| places[id] * *share).sum();
    Some((face_axes(strength.corners.map(|id| places[&id])), places[&tie.node] - foot))
}

/// All bonds, by ascending slave. A checkpoint has all fields that are not skipped.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Bonds {
    all: Vec<Bond>,
    /// Forces and moments of this step on local nodes.
    #[serde(skip)]
    acting: Vec<(u32, [V3; 2])>,
}

impl Bonds {
    /// Checks that these are bonds of ties of a job.
    ///
    /// # Errors
    /// They are not: the reason.
    pub fn validate(&self, jobs: &[Tie]) -> Result<(), String> {
        let known = |tie: &Tie| {
            tie.failure.is_some()
                && jobs.binary_search_by_key(&tie.node, |j| j.node).is_ok_and(|i| jobs[i] == *tie)
        };
        match self.all.iter().find(|bond| !known(&bond.tie)) {
            Some(bond) => Err(format!("the job has no tie of node {} that fails", bond.tie.node)),
            None => Ok(()),
        }
    }

    /// Adds bonds in place of ties that have failed with the forces of their limits, given in the
    /// axes of their faces. Those without an opening hold nothing. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn add(
        &mut self,
        comm: &mut dyn Transport,
        failed: Vec<(Tie, f64, [f64; 3])>,
        nodes: &Nodes,
        dt: f64,
    ) -> Result<(), RankLost> {
        for (tie, mass, force) in failed {
            let (limit, stiffness) = (V3::from(force).norm(), STIFFNESS * mass / (dt * dt));
            let opens = tie.failure.as_ref().is_some_and(|strength| strength.opening > 0.0);
            if opens && stiffness > 0.0 && limit > 0.0 {
                let first = limit / stiffness;
                let origin = (V3::from(force) * (-first / limit)).into();
                self.all.push(Bond { tie, limit, origin, first, largest: -1.0 });
            }
        }
        let places = self.places(comm, nodes)?;
        for bond in self.all.iter_mut().filter(|bond| bond.largest < 0.0) {
            if let Some((axes, arm)) = face_and_arm(&bond.tie, &places) {
                bond.origin = (V3::from(bond.origin) + axes.transpose() * arm).into();
            }
            bond.largest = bond.first;
        }
        self.all.sort_by_key(|bond| bond.tie.node);
        Ok(())
    }

    /// Removes the bonds of faces of elements that have failed on any worker. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn remove_failed(
        &mut self,
        comm: &mut dyn Transport,
        failed: &[ElemId],
    ) -> Result<(), RankLost> {
        if self.all.is_empty() {
            return Ok(());
        }
        let failed: HashSet<ElemId> = failed.iter().copied().collect();
        let lost = |bond: &&Bond| bond.tie.faces.iter().any(|elem| failed.contains(elem));
        let lost: Vec<NodeId> = self.all.iter().filter(lost).map(|bond| bond.tie.node).collect();
        let lost: HashSet<NodeId> = gather_all(comm, lost)?.into_iter().flatten().collect();
        self.all.retain(|bond| !lost.contains(&bond.tie.node));
        Ok(())
    }

    /// Returns the positions of all nodes of bonds, from their owners.
    fn places(&self, comm: &mut dyn Transport, nodes: &Nodes) -> Result<NodePlaces, RankLost> {
        let ids: BTreeSet<NodeId> = self.all.iter().flat_map(Bond::nodes).collect();
        let ids: Vec<NodeId> = ids.into_iter().collect();
        let states = of_owners(comm, nodes, &ids)?;
        Ok(ids.into_iter().zip(states).map(|(id, state)| (id, V3::from(state.x))).collect())
    }

    /// Adds the forces of bonds to those of local nodes, and removes bonds that have come apart.
    /// Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn add_forces(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        self.acting.clear();
        if self.all.is_empty() {
            return Ok(());
        }
        let places = self.places(comm, nodes)?;
        let Self { all, acting } = self;
        for bond in all.iter_mut() {
            let Some((axes, arm)) = face_and_arm(&bond.tie, &places) else { continue };
            let stretch = bond.stretch(axes.transpose() * arm);
            bond.largest = bond.largest.max(stretch.norm());
            if bond.damage() >= 1.0 {
                continue;
            }
            let pull = axes * stretch * (bond.limit * (1.0 - bond.damage()) / bond.largest);
            let mut act = |id: NodeId, force: V3, moment: V3| {
                if let Some(n) = nodes.local_index(id) {
                    acting.push((n, [force, moment]));
                }
            };
            act(bond.tie.node, -pull, V3::zeros());
            let moment = arm.cross(&pull);
            for &(id, share) in &bond.tie.masters {
                act(id, pull * share, moment * share);
            }
        }
        all.retain(|bond| bond.damage() < 1.0);
        for (n, [force, moment]) in acting.iter_mut() {
            let n = *n as usize;
            (0..3).for_each(|c| nodes.force[n][c] += force[c]);
            // Nodes without inertia do not rotate.
            if nodes.rotations && nodes.inertia[n] > 0.0 {
                (0..3).for_each(|c| nodes.moment[n][c] += moment[c]);
            } else {
                *moment = V3::zeros();
            }
        }
        Ok(())
    }

    /// Adds the work of bonds on owned nodes in the step, with final velocities, to `sum`.
    pub fn add_work(&self, nodes: &Nodes, steps: StepSizes, sum: &mut WorkSum) {
        let work = |vector: &V3, before: [f64; 3], after: [f64; 3]| -> Work {
            (0..3).map(|c| Work::from_impulse(vector[c], before[c], after[c])).sum()
        };
        let owned = self.acting.iter().filter(|(n, _)| nodes.is_owned(*n as usize));
        for (n, [force, moment]) in owned.map(|(n, both)| (*n as usize, both)) {
            let mut done = work(force, xyz(&nodes.v[n]), xyz(&nodes.v_next[n]));
            if *moment != V3::zeros() {
                done = done + work(moment, xyz(&nodes.w[n]), xyz(&nodes.w_next[n]));
            }
            sum.add(done * steps.dt_velocity);
        }
    }

    /// Returns true if there are no bonds.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty() && self.acting.is_empty()
    }
}
