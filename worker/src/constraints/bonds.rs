//! Bonds: springs that hold nodes near the faces from which their ties have released them, until
//! they have parted by the opening of the failure.
//!
//! A tie is rigid until it fails with the force `F_0` of its limit, in the direction n. Then s is
//! the position of the slave relative to its point on the face, in the axes of the face, less that
//! of the failure and without the part of it that is a compression. The force is
//!
//! `F = |F_0| (1 - D) (c s/q + (1 - c) n),  D = q/w,  c = min(1, q/s_0),  s_0 = |F_0|/k_0`,
//!
//! with the largest `q = |s|` so far and the opening w; the term with n only while `s . n` is the
//! largest so far. So it begins with `F_0`, falls linearly to zero as the slave moves away along n
//! with the work `|F_0| w/2` for any `k_0`, and returns to zero along a secant when the slave comes
//! back. No path gains energy: the first term has the energy `K s^2/2` with a K that never grows,
//! and the second one acts only against an advance. A step that turns an advance back errs by at
//! most `(F_0 dt)^2/(2 m)`. (Damage as in bilinear cohesive laws, such as
//! Camanho & Davila 2002, NASA/TM-2002-211737, section 2, with a rigid start. The mode at the
//! failure is kept: `|F_0|` is the limit in its direction.)
//!
//! The stiffness is `k_0 = STIFFNESS m/dt^2` with the mass of the tie and the step of the failure,
//! so that bonds raise no eigenvalue of the mesh by more than `2 STIFFNESS / dt^2`. Where the
//! factor of safety leaves no room for that, the step is shorter while bonds hold.
//!
//! The reaction is divided among the masters by their weights, and with it its moment if they
//! rotate. Without rotations of the masters the moment of the force about the point on the face,
//! of the order of force times opening, is not carried: angular momentum has this error, and a
//! turn of the face by an angle does the work moment times angle that the energy of bonds lacks.
//!
//! All workers have all bonds and compute the same values from the positions that the owners of
//! the nodes send.

use super::ties::failure::{ReleasedTie, face_axes};
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use crate::time::{StepSizes, stiffened};
use crate::work::{Work, WorkSum};
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::tie::Tie;
use crumple_proto::transport::{RankLost, Transport, gather_all};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap, HashSet};

/// Stiffness of bonds at their start, times the squared step over the mass. Elements at up to 0.97
/// of their stable step leave room for it.
const STIFFNESS: f64 = 0.1;

/// A bond.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Bond {
    tie: Tie,
    /// Size of the force at the failure [force], and its direction in the axes of the face.
    limit: f64,
    direction: [f64; 3],
    /// Relative position of the slave at the failure, in the axes of the face [length].
    origin: [f64; 3],
    /// Displacement from which on the force is that of the secant alone [length].
    first: f64,
    /// Largest displacement, and largest one along the direction [length].
    largest: f64,
    advance: f64,
    /// Bound of what it adds to the squared frequencies of the mesh [1/time^2].
    frequency2: f64,
}

impl Bond {
    /// Moves the slave to a relative position, in the axes of the face, and returns the force that
    /// draws it back [force].
    fn pull(&mut self, relative: V3) -> V3 {
        let mut s = relative - V3::from(self.origin);
        let mut direction = V3::from(self.direction);
        if s.z < 0.0 {
            (s.z, direction.z) = (0.0, 0.0);
        }
        let advance = s.dot(&direction);
        let advances = advance >= self.advance;
        self.largest = self.largest.max(s.norm());
        self.advance = self.advance.max(advance);
        let share = (self.largest / self.first).min(1.0);
        let secant = if self.largest > 0.0 { s * (share / self.largest) } else { V3::zeros() };
        let front = if advances { direction * (1.0 - share) } else { V3::zeros() };
        (secant + front) * (self.limit * (1.0 - self.damage()).max(0.0))
    }

    /// Returns the damage from 0 on; from 1 on there is no force.
    fn damage(&self) -> f64 {
        let opening = self.tie.failure.as_ref().map_or(0.0, |strength| strength.opening);
        self.largest / opening
    }

    /// Returns the nodes on which it depends.
    fn nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let corners = self.tie.failure.iter().flat_map(|strength| strength.corners);
        std::iter::once(self.tie.node).chain(self.tie.masters.iter().map(|m| m.0)).chain(corners)
    }
}

/// Position of a node [length].
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct NodePlace {
    id: NodeId,
    x: [f64; 3],
}

/// Positions of nodes of bonds [length].
type NodePlaces = HashMap<NodeId, V3>;

/// Returns the axes of the face of a tie, and the arm from its point on the face to its slave; none
/// if a node is not there any more.
fn face_and_arm(tie: &Tie, places: &NodePlaces) -> Option<(nalgebra::Matrix3<f64>, V3)> {
    let place = |id: &NodeId| places.get(id).copied();
    let mut foot = V3::zeros();
    for (id, share) in &tie.masters {
        foot += place(id)? * *share;
    }
    let [a, b, c, d] = tie.failure.as_ref()?.corners.each_ref().map(place);
    Some((face_axes([a?, b?, c?, d?]), place(&tie.node)? - foot))
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

    /// Adds bonds in place of ties that have failed. Those without an opening hold nothing. `dt` is
    /// the stable step [time]. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn add(
        &mut self,
        comm: &mut dyn Transport,
        failed: Vec<ReleasedTie>,
        nodes: &Nodes,
        dt: f64,
    ) -> Result<(), RankLost> {
        let ratio = STIFFNESS / (dt * dt);
        let before = self.all.len();
        for ReleasedTie { tie, mass, force } in failed {
            let (limit, stiffness) = (V3::from(force).norm(), ratio * mass);
            let opens = tie.failure.as_ref().is_some_and(|strength| strength.opening > 0.0);
            if opens && stiffness > 0.0 && limit > 0.0 {
                self.all.push(Bond {
                    tie,
                    limit,
                    direction: (V3::from(force) / limit).into(),
                    origin: [0.0; 3],
                    first: limit / stiffness,
                    largest: 0.0,
                    advance: 0.0,
                    frequency2: 2.0 * ratio,
                });
            }
        }
        let places = self.places(comm, nodes)?;
        let mut added = self.all.split_off(before);
        added.retain_mut(|bond| {
            let found = face_and_arm(&bond.tie, &places);
            if let Some((axes, arm)) = found {
                bond.origin = (axes.transpose() * arm).into();
            }
            found.is_some()
        });
        self.all.append(&mut added);
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

    /// Returns the stable step without the bonds, or so much less that the step with the factor
    /// `safety` is stable with them [time]. The usual factor leaves room for them, and a change of
    /// the step would change the energy of vibrations.
    pub fn limit(&self, stable_dt: f64, safety: f64) -> f64 {
        if self.all.is_empty() {
            return stable_dt;
        }
        let frequency2 = self.all.iter().map(|bond| bond.frequency2).fold(0.0, f64::max);
        stable_dt.min(stiffened(stable_dt, frequency2) / safety)
    }

    /// Returns the positions of all nodes of bonds that a worker owns.
    fn places(&self, comm: &mut dyn Transport, nodes: &Nodes) -> Result<NodePlaces, RankLost> {
        let ids: BTreeSet<NodeId> = self.all.iter().flat_map(Bond::nodes).collect();
        let own = |id: NodeId| {
            let n = nodes.local_index(id).map(|n| n as usize).filter(|&n| nodes.is_owned(n))?;
            Some(NodePlace { id, x: xyz(&nodes.x[n]) })
        };
        let all = gather_all(comm, ids.into_iter().filter_map(own).collect::<Vec<_>>())?;
        Ok(all.into_iter().flatten().map(|place| (place.id, V3::from(place.x))).collect())
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
        // All workers have the same bonds and positions.
        all.retain_mut(|bond| {
            let Some((axes, arm)) = face_and_arm(&bond.tie, &places) else { return false };
            let pull = axes * bond.pull(axes.transpose() * arm);
            if bond.damage() >= 1.0 {
                return false;
            }
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
            true
        });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::tie::TieStrength;

    /// Pieces of a straight part of a path.
    const PIECES: u32 = 400;

    fn bond(opening: f64) -> Bond {
        let corners = [NodeId(1), NodeId(2), NodeId(3), NodeId(4)];
        let strength = TieStrength { limits: [1.0; 2], exponents: [2.0; 2], opening, corners };
        let tie = Tie {
            node: NodeId(5),
            masters: Vec::new(),
            near: Vec::new(),
            faces: Vec::new(),
            rotations: false,
            offset: false,
            mean: false,
            failure: Some(strength),
        };
        let (direction, origin) = ([0.6, 0.0, 0.8], [0.3, -0.2, 0.1]);
        let (first, largest, advance, frequency2) = (0.2, 0.0, 0.0, 1.0);
        Bond { tie, limit: 3.0, direction, origin, first, largest, advance, frequency2 }
    }

    /// Along the direction of the failure the force falls from its limit to zero, with the work
    /// under this line.
    #[test]
    fn the_force_falls_linearly_to_zero() {
        let (opening, steps) = (1.5, 3000);
        let mut bond = bond(opening);
        let (origin, along) = (V3::from(bond.origin), V3::from(bond.direction));
        let (mut work, mut last) = (0.0, 0.0);
        for k in 0..=steps {
            let s = opening * f64::from(k) / f64::from(steps);
            let force = bond.pull(origin + along * s);
            let exact = 3.0 * (1.0 - s / opening);
            assert!((force - along * exact).norm() < 1e-12, "{s}: {force}");
            work +=
                if k > 0 { 0.5 * (force.norm() + last) * opening / f64::from(steps) } else { 0.0 };
            last = force.norm();
        }
        assert!((work / (0.5 * 3.0 * opening) - 1.0).abs() < 1e-12, "{work}");
        assert!(bond.damage() >= 1.0 - 1e-12);
    }

    /// It returns along a secant, and does not push when the slave is pressed onto the face.
    #[test]
    fn a_slave_that_comes_back_is_drawn_along_a_secant() {
        let mut bond = bond(1.5);
        let (origin, along) = (V3::from(bond.origin), V3::from(bond.direction));
        bond.pull(origin + along * 0.6);
        for s in [0.5, 0.25, 0.0] {
            let force = bond.pull(origin + along * s);
            assert!((force - along * (3.0 * 0.6 * s / 0.6)).norm() < 1e-12, "{s}: {force}");
        }
        assert_eq!(bond.pull(origin + V3::new(0.0, 0.0, -2.0)), V3::zeros());
    }

    /// On random paths that begin and end at the failure no energy is gained, also if the slave
    /// hardly moves or goes against the force at first. The force jumps where an advance begins, so
    /// that the work errs by at most the largest force times the length of a piece of the path.
    #[test]
    fn closed_paths_gain_no_energy() {
        let mut random = fastrand::Rng::with_seed(7);
        for path in 0..300 {
            let mut bond = bond(1.5);
            let origin = V3::from(bond.origin);
            let reach = [0.02, 0.2, 1.0][path % 3];
            let mut place = || reach * (2.0 * random.f64() - 1.0);
            let mut points: Vec<V3> = (0..6).map(|_| V3::from_fn(|_, _| place())).collect();
            points.push(V3::zeros());
            let (mut from, mut work) = (V3::zeros(), 0.0);
            for to in points {
                for k in 0..PIECES {
                    let at = |k: f64| from + (to - from) * (k / f64::from(PIECES));
                    let force = bond.pull(origin + at(f64::from(k) + 0.5));
                    work += force.dot(&((to - from) / f64::from(PIECES)));
                }
                from = to;
            }
            let piece = 2.0 * 3.0_f64.sqrt() * reach / f64::from(PIECES);
            assert!(work > -3.0 * piece, "path {path}: {work}");
        }
    }

    /// A bond adds 0.2/dt^2 to the squared frequencies. Elements at nine tenths of their stable
    /// step leave room for it, at 0.99 they do not: `1/step^2 = 0.99^2 + 0.2/4`.
    #[test]
    fn the_step_is_shorter_only_without_room() {
        let bonds = Bonds { all: vec![Bond { frequency2: 0.2, ..bond(1.0) }], acting: Vec::new() };
        assert_eq!(bonds.limit(1.0 / 0.9, 0.9), 1.0 / 0.9);
        let step = 0.99 * bonds.limit(1.0 / 0.99, 0.99);
        assert!((1.0 / (step * step) - (0.99 * 0.99 + 0.05)).abs() < 1e-12, "{step}");
        assert_eq!(Bonds::default().limit(1.0, 1.8), 1.0, "any factor without bonds");
    }
}
