//! The energy ledger: work in, stored, dissipated, lost. Sums are for reports; nothing is decided from them.

use crate::contact::ContactWork;
use crate::elements::PassTotals;
use crate::nodes::{Nodes, Row, xyz};
use crumple_proto::report::Energies;
use nalgebra::Vector3;

/// What has accumulated on this worker.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ledger {
    internal: f64,
    hourglass: f64,
    contact: ContactWork,
    wall: f64,
    external: f64,
    /// Contact, wall and external work of the last step alone.
    last: (ContactWork, f64, f64),
}

impl Ledger {
    /// Books a pass over elements.
    pub fn book_elements(&mut self, t: &PassTotals) {
        self.internal += t.internal;
        self.hourglass += t.hourglass;
    }

    /// Books the work of contact in a step.
    pub fn book_contact(&mut self, work: ContactWork) {
        self.contact.total += work.total;
        self.contact.friction += work.friction;
        self.last.0 = work;
    }

    /// Books the work of walls in a step.
    pub fn book_wall(&mut self, work: f64) {
        self.wall += work;
        self.last.1 = work;
    }

    /// Books the work of loads, damping and prescribed motion in a step.
    pub fn book_external(&mut self, work: f64) {
        self.external += work;
        self.last.2 = work;
    }

    /// Energies at the present time, between the mid-steps with velocities `v` and `next_v`: kinetic energy is the mean
    /// of both, and of the work between them half has been done.
    pub fn energies(&self, nodes: &Nodes) -> Energies {
        Energies {
            kinetic: 0.5 * (kinetic(nodes, &nodes.v, false) + kinetic(nodes, &nodes.next_v, true)),
            internal: self.internal,
            hourglass: self.hourglass,
            contact: self.contact.total - 0.5 * self.last.0.total,
            friction: self.contact.friction - 0.5 * self.last.0.friction,
            wall: self.wall - 0.5 * self.last.1,
            external: self.external - 0.5 * self.last.2,
        }
    }
}

/// Kinetic energy of owned nodes with velocities `v` and the rotational velocities of the same mid-step [energy].
fn kinetic(nodes: &Nodes, v: &[Row], next: bool) -> f64 {
    let w = if next { &nodes.next_w } else { &nodes.w };
    let of = |i: usize| {
        let square = |r: &Row| r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
        let turning = if nodes.rotations { nodes.inertia[i] * square(&w[i]) } else { 0.0 };
        0.5 * (nodes.mass[i] * square(&v[i]) + turning)
    };
    (0..nodes.held).filter(|&i| nodes.is_own(i)).map(of).sum()
}

/// Linear and angular momentum of owned nodes about the origin at mid-step velocities.
/// Nodes have no memory of where between two times they are; angular momentum uses present positions.
pub fn momentum(nodes: &Nodes) -> ([f64; 3], [f64; 3]) {
    let (mut p, mut l) = (Vector3::zeros(), Vector3::zeros());
    for i in (0..nodes.held).filter(|&i| nodes.is_own(i)) {
        // Mean of the velocities before and after: those of the present time.
        let mean = |a: &Row, b: &Row| 0.5 * (Vector3::from(xyz(a)) + Vector3::from(xyz(b)));
        let v = mean(&nodes.v[i], &nodes.next_v[i]);
        p += nodes.mass[i] * v;
        l += nodes.mass[i] * Vector3::from(xyz(&nodes.x[i])).cross(&v);
        if nodes.rotations {
            l += nodes.inertia[i] * mean(&nodes.w[i], &nodes.next_w[i]);
        }
    }
    (p.into(), l.into())
}
