//! Failure of ties: the force that a tie transmits, and the ties that it breaks.
//!
//! A tie gives its slave of mass m the acceleration a. With the forces f of elements, loads and
//! contact on the slave, the tie exerts `F = m a - f` on it. The normal of the face and the parts
//! of F along and across it are those of the present positions. With the tension N, the shear S
//! and their limits `N_0` and `S_0`, a tie breaks when `(N/N_0)^n + (S/S_0)^m >= 1`.
//!
//! The worker that owns a slave decides; all workers learn it in the same step. Slaves are
//! released some cycles later, see [`crate::erosion::EVERY`].

use super::{NONE, Ties};
use crate::contact::Contact;
use crate::math::row::{Row, V3, xyz};
use crate::nodes::Nodes;
use crate::time::StepSizes;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::tie::{Tie, TieStrength};
use crumple_proto::transport::{RankLost, Transport, gather_all};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Number of halvings of an interval until the factor in it is exact to round-off.
const HALVINGS: usize = 60;

/// Data of a tie that can fail, besides its definition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breakable {
    /// Numbers of the corners of its face in the list of masters.
    pub corners: [u32; 4],
    /// Mass on which the stiffness of a spring in its place may be based [mass].
    pub mass: f64,
}

/// A tie that has broken, and the force at its limit on its slave in the frame of the face
/// [force].
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Broken {
    slave: NodeId,
    force: [f64; 3],
}

/// A tie that has failed and holds no more.
pub struct ReleasedTie {
    /// Its definition.
    pub tie: Tie,
    /// Mass on which the stiffness of a spring in its place may be based [mass].
    pub mass: f64,
    /// Force on the slave at the limit, in the axes of the face [force].
    pub force: [f64; 3],
}

/// Ties that have broken and are not released yet, by slave, with the forces of their limits.
pub type BrokenTies = BTreeMap<NodeId, [f64; 3]>;

/// Returns the axes of a face as columns: two along it, then its normal.
pub fn face_axes(corners: [V3; 4]) -> Matrix3<f64> {
    let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1])).normalize();
    let along = corners[1] - corners[0];
    let first = (along - normal * along.dot(&normal)).normalize();
    Matrix3::from_columns(&[first, normal.cross(&first), normal])
}

/// Returns `(N/N_0)^n + (S/S_0)^m` for a force in the frame of the face; compression counts as 0.
fn load(strength: &TieStrength, force: &V3) -> f64 {
    let [n, m] = strength.exponents;
    let [tension, shear] = [force.z.max(0.0), force.x.hypot(force.y)];
    (tension / strength.limits[0]).powf(n) + (shear / strength.limits[1]).powf(m)
}

/// Returns the tension and shear of a force in the frame of the face, reduced to the limit that
/// it exceeds.
fn at_limit(strength: &TieStrength, force: &V3) -> V3 {
    let pulling = V3::new(force.x, force.y, force.z.max(0.0));
    let mut range = [0.0, 1.0];
    for _ in 0..HALVINGS {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(load(strength, &(pulling * middle)) >= 1.0)] = middle;
    }
    pulling * range[1]
}

impl Ties {
    /// Returns true if a tie can fail.
    pub fn can_fail(&self) -> bool {
        self.breakable.iter().any(Option::is_some)
    }

    /// Returns true if ties have broken that are not released yet.
    pub fn has_broken(&self) -> bool {
        !self.broken.is_empty()
    }

    /// Finds the ties that the forces of this step break. `falling` is the acceleration of
    /// gravity, which acts on the mass that slaves have given to their masters [length/time^2].
    /// Velocities at the end of the step must be known. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn find_broken(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
        contact: Option<&Contact>,
        (steps, falling): (StepSizes, Row),
    ) -> Result<(), RankLost> {
        if !self.can_fail() || steps.dt_velocity <= 0.0 {
            return Ok(());
        }
        let mut found = Vec::new();
        for t in self.local_slaves.iter().map(|&t| t as usize) {
            let (tie, n) = (&self.definitions[t], self.slave_index[t] as usize);
            let Some((strength, breakable)) = tie.failure.as_ref().zip(self.breakable[t]) else {
                continue;
            };
            if !nodes.is_owned(n) || self.broken.contains_key(&tie.node) {
                continue;
            }
            let mass = self.slave_masses[t][0];
            // The share of damping that the tie transmits.
            let damped = steps.given() - 1.0;
            let inertial = V3::from_fn(|c, _| {
                let (v, next) = (nodes.v[n][c], nodes.v_next[n][c]);
                mass * ((next - v + damped * (next + v)) / steps.dt_velocity - falling[c])
            });
            let touching = contact.map_or(V3::zeros(), |contact| contact.force_on(n as u32));
            let force = inertial - V3::from(xyz(&nodes.force[n])) - touching;
            let corners = breakable.corners.map(|c| V3::from(self.master_place(c as usize, nodes)));
            // The face pulls the slave against the normal.
            let held = -(face_axes(corners).transpose() * force);
            if load(strength, &held) >= 1.0 {
                let force = at_limit(strength, &held).into();
                found.push(Broken { slave: tie.node, force });
            }
        }
        let all = gather_all(comm, found)?;
        self.broken.extend(all.into_iter().flatten().map(|b| (b.slave, b.force)));
        Ok(())
    }

    /// Releases the slaves of broken ties, and returns these by ascending slave.
    pub fn release_broken(&mut self, nodes: &mut Nodes) -> Vec<ReleasedTie> {
        let broken = std::mem::take(&mut self.broken);
        let gone = |t: &usize| broken.contains_key(&self.definitions[*t].node);
        let gone: BTreeSet<usize> = (0..self.definitions.len()).filter(gone).collect();
        let of = |&t: &usize| {
            let tie = self.definitions[t].clone();
            let mass = self.breakable[t].map_or(0.0, |b| b.mass);
            ReleasedTie { force: broken[&tie.node], mass, tie }
        };
        let released = gone.iter().map(of).collect();
        self.release(&gone, nodes);
        released
    }

    /// Returns the numbers of corners of faces and the masses of springs, from the masses of the
    /// masters before they have those of slaves; empty if no tie can fail.
    ///
    /// A spring between a slave of mass m and masters with weights N and masses M has the energy
    /// `k |v_s - sum N v|^2 / 2`, at most `k |v_s|^2 + k sum N |v|^2`. With `k = c m_b` for each
    /// slave b, the sum over all springs is at most c times `sum m |v_s|^2 + sum M |v|^2` if `m_b
    /// <= m` and `sum N m_b <= M` at each master. So no eigenvalue of the springs exceeds 2 c.
    pub(super) fn breakable_of(&self, own: &[f64]) -> Vec<Option<Breakable>> {
        if self.definitions.iter().all(|tie| tie.failure.is_none()) {
            return Vec::new();
        }
        let mut hung = vec![0.0; own.len()];
        for (shares, masses) in self.shares.iter().zip(&self.slave_masses) {
            shares.iter().for_each(|&(c, share)| hung[c as usize] += share * masses[0]);
        }
        let number = |id: NodeId| self.masters.binary_search(&id).map_or(NONE, |c| c as u32);
        let of = |t: usize| {
            let (tie, shares) = (&self.definitions[t], &self.shares[t]);
            let strength = tie.failure.as_ref()?;
            let least =
                |all: f64, &(c, _): &(u32, f64)| all.min(own[c as usize] / hung[c as usize]);
            let mass = self.slave_masses[t][0] * shares.iter().fold(1.0, least);
            Some(Breakable { corners: strength.corners.map(number), mass })
        };
        (0..self.definitions.len()).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strength(exponents: [f64; 2]) -> TieStrength {
        let corners = [NodeId(1), NodeId(2), NodeId(3), NodeId(4)];
        TieStrength { limits: [4.0, 3.0], exponents, opening: 0.0, corners }
    }

    /// The criterion at its limits, with both parts, and under compression.
    #[test]
    fn tension_and_shear_break_a_tie_but_compression_does_not() {
        let of = |x, y, z| load(&strength([2.0, 2.0]), &V3::new(x, y, z));
        assert_eq!(of(0.0, 0.0, 4.0), 1.0);
        assert_eq!(of(0.0, -3.0, 0.0), 1.0);
        assert_eq!(of(0.0, 0.0, -100.0), 0.0);
        assert!((of(3.0 * 0.6, 0.0, 4.0 * 0.8) - 1.0).abs() < 1e-15);
        assert!((load(&strength([1.0, 3.0]), &V3::new(1.5, 0.0, 2.0)) - 0.625).abs() < 1e-15);
        let only_shear = TieStrength { limits: [f64::INFINITY, 3.0], ..strength([2.0, 2.0]) };
        assert_eq!(load(&only_shear, &V3::new(0.0, 3.0, 1e9)), 1.0);
    }

    /// A force above the limit is reduced along its direction, without its compression.
    #[test]
    fn forces_are_reduced_to_the_limit() {
        for exponents in [[2.0, 2.0], [1.5, 3.0]] {
            let strength = strength(exponents);
            let force = V3::new(2.0, -2.0, 3.5);
            let limit = at_limit(&strength, &force);
            assert!((load(&strength, &limit) - 1.0).abs() < 1e-14);
            assert!(limit.cross(&force).norm() < 1e-14 && limit.norm() < force.norm());
            let pushed = at_limit(&strength, &V3::new(0.0, 6.0, -5.0));
            assert!((pushed - V3::new(0.0, 3.0, 0.0)).norm() < 1e-14, "{pushed}");
        }
    }

    /// The axes of a face are orthonormal and turn with it; a triangle repeats a corner.
    #[test]
    fn axes_of_faces() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let axes = face_axes(corners.map(V3::from));
        assert!((axes - Matrix3::identity()).norm() < 1e-15, "{axes}");
        let triangle = [corners[0], corners[1], corners[2], corners[2]].map(V3::from);
        assert!((face_axes(triangle) - Matrix3::identity()).norm() < 1e-15);
    }
}
