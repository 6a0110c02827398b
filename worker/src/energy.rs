//! The energy ledger: external work, stored, dissipated and lost energy. The sums are for reports
//! only; no decision of a worker depends on them.
//!
//! All sums are exact, and each of their terms belongs to one node, element, pair, wall or body.
//! So they do not depend on the distribution of these over workers.

use crate::contact::work::ContactWork;
use crate::fem::blocks::Blocks;
use crate::math::row::{Row, xyz};
use crate::nodes::Nodes;
use crate::work::{CARRY_EVERY, WorkSum};
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::histories::each_value;
use crumple_proto::report::Energies;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Work of walls so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WallWork {
    /// Work of walls on nodes and bodies, and of these on walls with a mass.
    pub total: WorkSum,
    /// Work of friction in the motion of nodes and bodies relative to their walls.
    pub friction: WorkSum,
}

/// Work accumulated on this worker.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Work of contact forces.
    pub contact: ContactWork,
    /// Work of walls.
    pub wall: WallWork,
    /// Work of loads, damping and prescribed motion.
    pub external: WorkSum,
    /// Work of joints on rigid bodies and of bonds on nodes: minus what they store and absorb.
    pub links: WorkSum,
}

impl Ledger {
    /// Adds the ledger of another worker.
    pub fn add(&mut self, o: &Self) {
        let Self { contact: ContactWork { total, friction, starting }, wall, external, links } = o;
        let WallWork { total: of_walls, friction: of_wall_friction } = wall;
        self.contact.total.merge(total);
        self.contact.friction.merge(friction);
        self.contact.starting.merge(starting);
        self.wall.total.merge(of_walls);
        self.wall.friction.merge(of_wall_friction);
        self.external.merge(external);
        self.links.merge(links);
    }

    /// Begins a step, before its first work is added.
    pub fn begin_step(&mut self, cycle: u64) {
        let Self { contact: ContactWork { total, friction, starting }, wall, external, links } =
            self;
        let WallWork { total: of_walls, friction: of_wall_friction } = wall;
        let of_contact = [total, friction, starting];
        let others = [of_walls, of_wall_friction, external, links];
        for sum in of_contact.into_iter().chain(others) {
            sum.begin_step(cycle.is_multiple_of(CARRY_EVERY));
        }
    }

    /// Returns the energies at the present time, between the mid-steps with velocities v- and v+
    /// (`v` and `v_next`). Kinetic energy is `m v- . v+ / 2`; internal work uses the trapezoidal
    /// rule in the force. Then the central-difference scheme keeps the balance to round-off while
    /// the step is constant: `m (v+ - v-) = dt f` gives `K(n+1) - K(n) = dt v(n+1/2) . (f(n) +
    /// f(n+1)) / 2`.
    ///
    /// Between two steps these are the energies of the time at which the finished step began.
    pub fn energies(&self, nodes: &Nodes, blocks: &Blocks) -> Energies<ExactSum> {
        let (kinetic, swing) = kinetic(nodes);
        let of_elements =
            |kind: usize| -> ExactSum { blocks.energies().map(|(_, e)| e[kind]).collect() };
        let mut internal = of_elements(0);
        internal.remove(&self.links.at_present());
        Energies {
            kinetic,
            swing,
            internal,
            hourglass: of_elements(1),
            contact: self.contact.total.at_present(),
            friction: self.contact.friction.at_present(),
            starting: self.contact.starting.at_present(),
            wall: self.wall.total.at_present(),
            wall_friction: self.wall.friction.at_present(),
            external: self.external.at_present(),
        }
    }
}

/// Returns the kinetic energy of owned nodes at the present time, and by how much the mean of the
/// squared velocities gives more, `m |v+ - v-|^2 / 4` [energy].
fn kinetic(nodes: &Nodes) -> (ExactSum, ExactSum) {
    let product = |a: &Row, b: &Row| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let change = |a: &Row, b: &Row| (0..3).map(|c| (b[c] - a[c]) * (b[c] - a[c])).sum::<f64>();
    let swing = |i: usize| 0.25 * nodes.mass[i] * change(&nodes.v[i], &nodes.v_next[i]);
    let of = |i: usize| {
        let turning = if nodes.rotations {
            nodes.inertia[i] * product(&nodes.w[i], &nodes.w_next[i])
        } else {
            0.0
        };
        0.5 * (nodes.mass[i] * product(&nodes.v[i], &nodes.v_next[i]) + turning)
    };
    let own = || (0..nodes.local_count).filter(|&i| nodes.is_owned(i));
    (own().map(of).collect(), own().map(swing).collect())
}

/// Returns the kinetic energy of owned nodes at the last mid-step [energy].
pub fn kinetic_at_mid_step(nodes: &Nodes) -> ExactSum {
    let square = |a: &Row| a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    let of = |i: usize| {
        let turning = if nodes.rotations { nodes.inertia[i] * square(&nodes.w[i]) } else { 0.0 };
        0.5 * (nodes.mass[i] * square(&nodes.v[i]) + turning)
    };
    (0..nodes.local_count).filter(|&i| nodes.is_owned(i)).map(of).collect()
}

/// Linear momentum [mass length/time] and angular momentum about the origin [mass length^2/time].
pub type Momenta<N = f64> = ([N; 3], [N; 3]);

/// Returns the momenta of owned nodes at the last mid-step. Positions at mid-step are not stored;
/// angular momentum uses present positions.
pub fn momentum(nodes: &Nodes) -> Momenta {
    let (linear, angular) = momentum_sums(nodes, true);
    (each_value(&linear), each_value(&angular))
}

/// Returns the momenta of owned nodes as exact sums: at the last mid-step if the run has `ended`,
/// otherwise at the present time, within a step, with the mean of the velocities before and after.
pub fn momentum_sums(nodes: &Nodes, ended: bool) -> Momenta<ExactSum> {
    let (mut linear, mut angular) = Momenta::<ExactSum>::default();
    let next = if ended { [&nodes.v, &nodes.w] } else { [&nodes.v_next, &nodes.w_next] };
    let mean = |a: &Row, b: &Row| 0.5 * (Vector3::from(xyz(a)) + Vector3::from(xyz(b)));
    for i in (0..nodes.local_count).filter(|&i| nodes.is_owned(i)) {
        let p = nodes.mass[i] * mean(&nodes.v[i], &next[0][i]);
        let mut l = Vector3::from(xyz(&nodes.x[i])).cross(&p);
        if nodes.rotations {
            l += nodes.inertia[i] * mean(&nodes.w[i], &next[1][i]);
        }
        (0..3).for_each(|c| {
            linear[c].add(p[c]);
            angular[c].add(l[c]);
        });
    }
    (linear, angular)
}
