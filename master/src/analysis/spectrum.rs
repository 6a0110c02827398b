//! `crumple check --step`: largest stable step of the assembled system, from the engine's own
//! forces.
//!
//! A run uses a step that is safe for each element alone and for everything that shares its
//! nodes. The limit of the assembled system follows from its highest frequency. To find it, the
//! nodes of an engine are displaced by a very small d and back, at the current time of the run.
//! With the accelerations a of the two steps
//! ```text
//! a(x + d, rate d/dt) - a(x, rate -d/dt) = -(A + 2 C/dt) d = -B d
//! ```
//! for any loads. A is stiffness over mass and C damping over mass, which the engine takes from
//! the preceding mid-step. `v+ = v- - dt (A x + C v-)` is stable up to `dt^2 largest(B) = 4`.
//! With masses and inertias as weights B is symmetric, and Lanczos vectors give its largest
//! eigenvalue from below. All vectors are kept orthogonal to each other. The estimate is accepted
//! when its residual shows that an eigenvalue lies within `CLOSE` of it (Parlett 1998, theorem
//! 4.5.1), or when it has stopped growing.
//!
//! Included: elements with their present stress and shape, springs and dampers, ties, penalty and
//! mortar contact of present pairs, and the tangent of the material law from the present state.
//! Not included: future contact; members of rigid bodies, which count as fixed; dampers if there
//! is penalty or mortar contact, whose dashpots limit nothing. Bulk viscosity counts by half,
//! because it acts in compression only. Constraints of the Lagrange and kinematic laws add no
//! frequency. Rigid walls are removed: they can only lower the highest frequency, and one that
//! moves would give its nodes its velocity, however small the displacement.

use crate::input::job::Model;
use crate::run::embedded::Alone;
use crumple_proto::ids::NodeId;
use crumple_worker::constraints::walls::Walls;
use crumple_worker::math::row::Row;
use crumple_worker::step::step;
use crumple_worker::time::Clock;
use nalgebra::{DMatrix, SymmetricEigen};

/// Largest relative error of the eigenvalue.
const CLOSE: f64 = 0.01;
/// Number of vectors kept. After that, the iteration restarts with the best mode so far.
const VECTORS: usize = 40;
/// Maximum number of restarts.
const ROUNDS: usize = 8;
/// Relative growth of the eigenvalue in a round below which the iteration ends.
const GROWTH: f64 = 1e-3;
/// Largest displacement, over the shortest side.
const PUSH: f64 = 1e-7;

/// Result of the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Time at which it holds [time].
    pub time: f64,
    /// Largest stable step of the assembled system, infinite if there is no stiffness [time].
    pub limit: f64,
    /// Step of the run, with the safety factor [time].
    pub taken: f64,
    /// Node with the largest displacement in the mode of highest frequency.
    pub node: NodeId,
    /// Number of force evaluations with displaced nodes.
    pub pushes: usize,
    /// Bound on the relative error of the eigenvalue.
    pub residual: f64,
}

/// A degree of freedom: local node, component (0 to 2 translations, 3 to 5 rotations), and square
/// root of its mass or inertia.
struct FreeDof {
    node: usize,
    component: usize,
    root: f64,
}

impl FreeDof {
    /// Returns the displacement for the weighted displacement `y` [length]. A rotation counts as
    /// the displacement at the distance `side` [length].
    fn reach(&self, y: f64, side: f64) -> f64 {
        y.abs() / self.root * if self.component < 3 { 1.0 } else { side }
    }
}

struct Probe {
    alone: Alone,
    clock: Clock,
    /// Positions of nodes, and their positions at the preceding force evaluation [length].
    place: Vec<Row>,
    before: Vec<Row>,
    angle: Vec<Row>,
    free: Vec<FreeDof>,
    side: f64,
    /// True if contact has dashpots. They act at the end of the step and limit nothing.
    dashpots: bool,
}

/// Estimates the largest stable step at time `at`. The job first runs to this time on one engine.
///
/// # Errors
/// The job cannot run to this time, or it has two step sizes (subcycling).
pub fn assembled(model: &Model, at: f64) -> Result<Estimate, String> {
    if model.settings.subcycles > 1 {
        return Err(
            "a job with time.subcycles has two step sizes: check it with `--set time.subcycles=1`"
                .into(),
        );
    }
    let mut probe = Probe::new(model, at)?;
    let mut random = fastrand::Rng::with_seed(7);
    let mut start: Vec<f64> = probe.free.iter().map(|_| 2.0 * random.f64() - 1.0).collect();
    let (mut eigenvalue, mut residual, mut pushes) = (0.0f64, f64::INFINITY, 0);
    for _ in 0..ROUNDS {
        let round = probe.lanczos(&start)?;
        if !round.eigenvalue.is_finite() {
            return Err(
                "the forces of the model are not finite when its nodes move: no stable step exists"
                    .into(),
            );
        }
        pushes += round.pushes;
        let grown = round.eigenvalue > eigenvalue * (1.0 + GROWTH);
        (eigenvalue, residual) = (round.eigenvalue.max(eigenvalue), round.residual);
        start = round.mode;
        if !grown || residual < CLOSE {
            break;
        }
    }
    let strongest = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let moved =
        start.iter().zip(&probe.free).map(|(y, free)| free.reach(*y, probe.side)).enumerate();
    let node = moved.max_by(strongest).map_or(0, |(i, _)| probe.free[i].node);
    Ok(Estimate {
        time: probe.clock.time,
        limit: if eigenvalue > 0.0 { 2.0 / eigenvalue.sqrt() } else { f64::INFINITY },
        taken: probe.clock.dt,
        node: probe.alone.engine.nodes.id[node],
        pushes,
        residual,
    })
}

/// Result of one set of vectors.
struct Round {
    eigenvalue: f64,
    residual: f64,
    mode: Vec<f64>,
    pushes: usize,
}

impl Probe {
    fn new(model: &Model, at: f64) -> Result<Self, String> {
        let mut alone = Alone::new(model).map_err(|lost| lost.to_string())?;
        let early = |engine: &crumple_worker::engine::Engine| {
            engine.clock.time + 0.5 * engine.clock.dt < at
        };
        while early(&alone.engine) && !alone.engine.clock.is_over(&alone.engine.settings) {
            alone.forward()?;
        }
        if early(&alone.engine) {
            return Err(format!("the run ends at {}, before {at}", alone.engine.clock.time));
        }
        let engine = &mut alone.engine;
        engine.constraints.walls = Walls::default();
        engine.blocks.compute_all();
        engine.loads.stop_damping(); // acts in the middle of the step and limits nothing
        let held = engine.nodes.local_count;
        let place = engine.nodes.x[..held].to_vec();
        let mut clock = engine.clock.clone();
        clock.dt = clock.whole_dt;
        (clock.last_dt, clock.last_mid) = (clock.dt, clock.dt);
        // Forces of the present time, so that from here on only the displacements strain
        // elements.
        alone.forward()?;
        let nodes = &alone.engine.nodes;
        let mut free = Vec::new();
        for node in 0..held {
            let mut add = |component: usize, inverse: f64, mass: f64| {
                if inverse > 0.0 && mass > 0.0 {
                    free.push(FreeDof { node, component, root: mass.sqrt() });
                }
            };
            (0..3).for_each(|c| add(c, nodes.inv_mass[node][c], nodes.mass[node]));
            if nodes.rotations {
                (0..3).for_each(|c| add(3 + c, nodes.inv_inertia[node][c], nodes.inertia[node]));
            }
        }
        if free.is_empty() {
            return Err("no node is free to move".into());
        }
        let side = model.quality.min_side.value;
        if side.is_nan() || side <= 0.0 {
            return Err(
                "no element has a length to displace nodes by: springs of zero length have no \
                 stable step"
                    .into(),
            );
        }
        let angle = vec![[0.0; 4]; nodes.w.len()];
        let dashpots = model
            .job
            .contact
            .as_ref()
            .is_some_and(|c| c.each().any(|c| ["penalty", "mortar"].contains(&c.law.as_str())));
        Ok(Self { alone, clock, before: place.clone(), place, angle, free, side, dashpots })
    }

    /// Returns the accelerations with the nodes displaced by `by` from their positions. Nodes
    /// reach these positions in one step from their previous ones.
    fn accelerations(&mut self, by: Option<&[f64]>) -> Result<Vec<f64>, String> {
        let lost = |lost: crumple_proto::transport::RankLost| lost.to_string();
        let (dt, held) = (self.clock.dt, self.place.len());
        let Alone { engine, comm, .. } = &mut self.alone;
        engine.clock = self.clock.clone();
        let nodes = &mut engine.nodes;
        nodes.x[..held].copy_from_slice(&self.place);
        nodes.v_next[..held].fill([0.0; 4]);
        nodes.w_next.fill([0.0; 4]);
        for (y, free) in by.into_iter().flatten().zip(&self.free) {
            let rate = y / dt;
            match free.component {
                c @ 0..3 => nodes.v_next[free.node][c] = rate,
                c => nodes.w_next[free.node][c - 3] = rate,
            }
        }
        engine.constraints.ties.update_slave_velocities(comm, nodes, dt).map_err(lost)?;
        for i in 0..held {
            for c in 0..3 {
                nodes.x[i][c] += dt * nodes.v_next[i][c];
                nodes.v[i][c] = (nodes.x[i][c] - self.before[i][c]) / dt;
            }
            self.before[i] = nodes.x[i];
        }
        for (i, angle) in self.angle.iter_mut().enumerate().take(nodes.w_next.len()) {
            let now = nodes.w_next[i].map(|w| dt * w);
            nodes.w[i] = std::array::from_fn(|c| (now[c] - angle[c]) / dt);
            *angle = now;
        }
        let (v, w) = (nodes.v[..held].to_vec(), nodes.w.clone());
        if let Some(element) = step(engine, comm).map_err(lost)?.failure {
            let (push, time) = (PUSH * self.side, self.clock.time);
            return Err(format!(
                "element {element} cannot be computed at time {time:e} when its nodes move by \
                 {push:e}: it inverts or has no size; correct it, or choose another time \
                 (`--step=T`)"
            ));
        }
        let mid = self.clock.mid();
        let gained = |free: &FreeDof| match free.component {
            c @ 0..3 => (engine.nodes.v[free.node][c] - v[free.node][c]) / mid,
            c => (engine.nodes.w[free.node][c - 3] - w[free.node][c - 3]) / mid,
        };
        Ok(self.free.iter().map(gained).collect())
    }

    /// Returns B times a vector weighted with the square roots of the masses.
    fn push(&mut self, y: &[f64]) -> Result<Vec<f64>, String> {
        let apart = |(y, free): (&f64, &FreeDof)| free.reach(*y, self.side);
        let scale = PUSH * self.side / y.iter().zip(&self.free).map(apart).fold(0.0, f64::max);
        let by: Vec<f64> =
            y.iter().zip(&self.free).map(|(y, free)| scale * y / free.root).collect();
        let there = self.accelerations(Some(&by))?;
        let mut back = self.accelerations(None)?;
        if self.dashpots {
            // Rates there and back are opposite. Without them, the acceleration on the way back
            // is twice that at rest minus the one with rates.
            let still = self.accelerations(None)?;
            back.iter_mut().zip(still).for_each(|(back, still)| *back = 2.0 * still - *back);
        }
        let of =
            |((there, back), free): ((&f64, &f64), &FreeDof)| (back - there) * free.root / scale;
        Ok(there.iter().zip(&back).zip(&self.free).map(of).collect())
    }

    /// Runs Lanczos iterations from `start`, at most [`VECTORS`] vectors.
    fn lanczos(&mut self, start: &[f64]) -> Result<Round, String> {
        let mut vectors = vec![scaled(start, 1.0 / dot(start, start).sqrt())];
        let (mut diagonal, mut off_diagonal): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        loop {
            let last = vectors.last().expect("there is a first vector").clone();
            let mut next = self.push(&last)?;
            diagonal.push(dot(&next, &last));
            // Two passes remove round-off.
            for _ in 0..2 {
                for vector in &vectors {
                    let along = dot(&next, vector);
                    next.iter_mut().zip(vector).for_each(|(n, v)| *n -= along * v);
                }
            }
            let rest = dot(&next, &next).sqrt();
            let (eigenvalue, weights) = largest(&diagonal, &off_diagonal);
            let residual =
                rest * weights.last().expect("one weight per vector").abs() / eigenvalue.abs();
            let pushes = diagonal.len();
            // With zero remainder the vectors span all stiff modes. With zero eigenvalue there is
            // no stiffness.
            let residual = if rest == 0.0 || eigenvalue == 0.0 { 0.0 } else { residual };
            if residual < CLOSE || pushes == VECTORS.min(self.free.len()) || !eigenvalue.is_finite()
            {
                let mut mode = vec![0.0; start.len()];
                for (vector, weight) in vectors.iter().zip(&weights) {
                    mode.iter_mut().zip(vector).for_each(|(m, v)| *m += weight * v);
                }
                return Ok(Round { eigenvalue, residual, mode, pushes });
            }
            off_diagonal.push(rest);
            vectors.push(scaled(&next, 1.0 / rest));
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn scaled(a: &[f64], by: f64) -> Vec<f64> {
    a.iter().map(|a| by * a).collect()
}

/// Maximum number of iterations for the eigenvalues of a small matrix.
const ITERATIONS: usize = 1000;

/// Returns the largest eigenvalue of a symmetric tridiagonal matrix and its unit eigenvector, NaN
/// if there is none.
fn largest(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, Vec<f64>) {
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off_diagonal[i.min(j)],
        _ => 0.0,
    };
    let n = diagonal.len();
    let Some(eigen) =
        SymmetricEigen::try_new(DMatrix::from_fn(n, n, entry), f64::EPSILON, ITERATIONS)
    else {
        return (f64::NAN, vec![0.0; n]);
    };
    let (place, value) = eigen.eigenvalues.argmax();
    (value, eigen.eigenvectors.column(place).iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of n equal masses between walls has the eigenvalues `2 - 2 cos(k pi/(n + 1))`.
    #[test]
    fn a_chain_has_its_highest_frequency() {
        for n in [1, 2, 7, 40] {
            let (value, vector) = largest(&vec![2.0; n], &vec![-1.0; n - 1]);
            let theta = n as f64 * std::f64::consts::PI / (n + 1) as f64;
            assert!((value - (2.0 - 2.0 * theta.cos())).abs() < 1e-9, "{n}: {value}");
            let wanted = (theta * n as f64).sin() * (2.0 / (n + 1) as f64).sqrt();
            assert!(
                (vector[n - 1].abs() - wanted.abs()).abs() < 1e-6,
                "{n}: {} for {wanted}",
                vector[n - 1]
            );
        }
    }
}
