//! Contact iteration: computes the forces of all pairs of a step, by sweeps over all of them or
//! by prediction and correction within a sweep. If the sweeps do not converge, accelerated
//! sweeps follow (`acceleration.rs`).

use crate::acceleration::{Acceleration, Forces};
use crate::enforce::{ContactLaw, Iteration, Laws, demand};
use crate::nesterov::NesterovMomentum;
use crate::pairs::{NodalLoad, Pair, PairTable, Peers, accelerated_velocity};
use crate::surroundings::{NodalForces, VelocityConstraint};
use crumple_fem::nodes::Nodes;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};
use crumple_proto::transport::RankLost;

/// State of the contact iteration: everything that the forces of pairs depend on and act on.
pub struct ContactSolver<'a, S> {
    /// Contact laws of all interfaces.
    pub laws: &'a Laws,
    /// Nodes; the velocities of touched nodes become those with contact and walls.
    pub nodes: &'a mut Nodes,
    /// Velocities without contact of the nodes in the table's `touched` [length/time].
    pub free: &'a [Row],
    /// Rotational velocities without contact of these nodes; empty if friction rotates none of
    /// them [1/time].
    pub free_spins: &'a [Row],
    /// Constraints on the nodes, and the other workers.
    pub around: &'a mut S,
    /// True if a pair touches a rigid body, on any worker.
    pub coupled: bool,
    /// Step sizes around the present time.
    pub steps: StepSizes,
    /// Largest number of accelerated sweeps if the plain sweeps do not converge, equal on all
    /// workers; 0 if no law converges.
    pub accelerated: usize,
    /// True if one of two pairs that close the same gap gets no force.
    pub removes_redundant: bool,
    /// Momentum of sweeps with split masses.
    pub momentum: &'a mut NesterovMomentum,
}

/// Largest squared norm of the residual of a sweep with usable forces, as a multiple of the least
/// one of the step: twice the norm. One pair that never settles can keep the norm constant, while
/// sweep by sweep the other forces become more accurate. In the sliding block of A07 sweeps with
/// lost forces had 1e4 and more.
const USABLE: f64 = 4.0;

/// Result of the sweeps of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolverOutcome {
    /// Number of sweeps.
    pub sweeps: u64,
    /// Number of pairs of all workers, if sweeps can be accelerated.
    pub pairs: u64,
    /// True if some sweeps were accelerated.
    pub accelerated: bool,
    /// True if the forces of own pairs are not accurate enough at the end. With accelerated
    /// sweeps it includes the pairs of all workers.
    pub unsettled: bool,
}

/// Kind of a sweep within a step.
#[derive(Clone, Copy)]
enum Stage {
    /// A plain sweep with its number, from 0.
    Plain(usize),
    /// An accelerated sweep.
    Accelerated,
}

/// Pairs that are updated together within a sweep: those of the interfaces with this iteration,
/// as long as their laws require more sweeps.
#[derive(Clone, Copy)]
struct Selection {
    iteration: Iteration,
    stage: Stage,
}

impl Selection {
    /// Returns the law of an own pair, or `None` if the pair is not selected.
    fn law<'a>(&self, pair: &Pair, laws: &'a Laws) -> Option<&'a dyn ContactLaw> {
        let of_interface = laws.of_interface(pair);
        let wants = match self.stage {
            Stage::Plain(sweep) => sweep < of_interface.sweeps,
            Stage::Accelerated => of_interface.converges,
        };
        (of_interface.iteration == self.iteration && wants).then_some(&*of_interface.law)
    }
}

/// Returns the forces of own pairs.
fn own_forces(t: &PairTable) -> Forces {
    t.pairs.iter().filter(|p| p.is_owned).map(|p| p.force).collect()
}

/// Sets the forces of own pairs.
fn set_own_forces(t: &mut PairTable, forces: Forces) {
    let own = t.pairs.iter_mut().filter(|p| p.is_owned);
    own.zip(forces).for_each(|(p, force)| p.force = force);
}

impl<S: VelocityConstraint + Peers> ContactSolver<'_, S> {
    /// Sweeps until all forces are accurate enough, or until the largest number of sweeps is
    /// reached.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn run(&mut self, t: &mut PairTable) -> Result<SolverOutcome, RankLost> {
        let touches = !t.pairs.is_empty() || self.coupled;
        let mut swept = if touches { self.run_plain_sweeps(t)? } else { SolverOutcome::default() };
        if let Some(pairs) = self.around.known_pairs()
            && !self.around.takes_part()
        {
            return Ok(SolverOutcome { pairs, ..swept });
        }
        if self.accelerated > 0 {
            let own = t.pairs.iter().filter(|p| p.is_owned && !p.is_replica).count();
            let mut counts = [i64::from(swept.unsettled), own as i64];
            self.around.sum(&mut counts)?;
            swept.unsettled = counts[0] > 0;
            swept.accelerated = swept.unsettled;
            swept.pairs = counts[1] as u64;
        }
        if swept.accelerated {
            self.run_accelerated_sweeps(t, &mut swept)?;
        }
        Ok(swept)
    }

    /// Makes plain sweeps, at most the number that the laws allow.
    fn run_plain_sweeps(&mut self, t: &mut PairTable) -> Result<SolverOutcome, RankLost> {
        if self.laws.converge() && self.removes_redundant {
            t.remove_redundant_forces(self.around, |p| self.laws.of_interface(p).converges)?;
        }
        // With prediction and correction, the masses of edges are split: a slave edge can be in
        // several pairs, and these do not include each other's corrections as pairs of one segment
        // do.
        let is_split = |pair: &Pair| match self.laws.of_interface(pair).iteration {
            Iteration::Split => true,
            Iteration::Correct { .. } => pair.key.is_edge(),
            Iteration::GaussSeidel => false,
        };
        t.compute_compliances(self.nodes, self.around, is_split);
        for p in t.pairs.iter_mut().filter(|p| p.is_owned) {
            p.approach_speed = demand(p, &p.relative_velocity(self.nodes), self.steps);
            p.opening_before = p.last_opening(self.nodes);
        }
        if self.laws.iterations().contains(&Iteration::GaussSeidel) {
            t.build_schedule(self.around)?;
        }
        self.apply_forces(t);
        self.apply_to_bodies(t, true)?;
        if self.laws.iterations().contains(&Iteration::Split) {
            t.start_activity();
            self.momentum.start(&t.pairs);
        }
        let mut swept = SolverOutcome::default();
        for sweep in 0..self.laws.sweeps() {
            swept.sweeps += 1;
            let left = self.sweep(t, Stage::Plain(sweep))?;
            let changed = left > 1.0;
            let quiet = if self.around.has_shared_pairs() {
                self.around.exchange_forces(&mut t.pairs, changed)?
            } else {
                !changed
            };
            self.apply_all_forces(t);
            // With rigid bodies all workers exchange data and stop after the same sweep.
            let over = if self.coupled { !self.apply_to_bodies(t, changed)? } else { quiet };
            swept.unsettled = !over && left > self.laws.coarse();
            if over {
                break;
            }
        }
        Ok(swept)
    }

    /// Makes accelerated sweeps until nothing changes on any worker. Each starts from forces
    /// that are extrapolated from the earlier sweeps. If they do not settle, the forces of the
    /// last sweep count whose residual is near the least one: extrapolation beyond a change of the
    /// closed pairs may have lost those of the sweeps after it.
    fn run_accelerated_sweeps(
        &mut self,
        t: &mut PairTable,
        swept: &mut SolverOutcome,
    ) -> Result<(), RankLost> {
        let mut acceleration = Acceleration::default();
        let (mut least, mut kept) = (f64::INFINITY, Forces::new());
        for left in (0..self.accelerated).rev() {
            swept.sweeps += 1;
            let before = own_forces(t);
            // A worker without pairs has no schedule. It takes part in the global reductions
            // only.
            let changed = !t.pairs.is_empty() && self.sweep(t, Stage::Accelerated)? > 1.0;
            let advice = acceleration.update(&t.pairs, &before, changed, self.around)?;
            swept.unsettled = advice.changed;
            least = least.min(advice.residual);
            if advice.residual <= USABLE * least {
                kept = own_forces(t);
            } else if left == 0 && advice.changed {
                set_own_forces(t, std::mem::take(&mut kept));
            }
            if let Some(forces) = advice.forces.filter(|_| left > 0) {
                set_own_forces(t, forces);
            }
            self.exchange_and_apply_forces(t, advice.changed)?;
            if !advice.changed {
                break;
            }
        }
        Ok(())
    }

    /// Applies the forces of own pairs and of other workers' pairs to nodes and bodies.
    fn exchange_and_apply_forces(
        &mut self,
        t: &mut PairTable,
        changed: bool,
    ) -> Result<(), RankLost> {
        if self.around.has_shared_pairs() {
            self.around.exchange_intermediate_forces(&mut t.pairs)?;
        }
        self.apply_forces(t);
        t.mark_all_changed();
        self.apply_to_bodies(t, changed)?;
        Ok(())
    }

    /// Makes one sweep over all pairs. Returns the largest residual of the own pairs, relative
    /// to the tolerance. The final forces are not sent to other workers yet.
    fn sweep(&mut self, t: &mut PairTable, stage: Stage) -> Result<f64, RankLost> {
        let iterations = self.laws.iterations();
        let mut undone: f64 = 0.0;
        for (left, &iteration) in (0..iterations.len()).rev().zip(iterations) {
            let some = Selection { iteration, stage };
            let most = match iteration {
                Iteration::Split => self.all_at_once(t, some),
                Iteration::GaussSeidel => t.sweep_in_order(
                    self,
                    |s| s.around,
                    |p, s| s.updated(p, some),
                    Self::apply_force_at,
                )?,
                Iteration::Correct { partition, little } => {
                    self.predict_and_correct(t, some, (partition, little))?
                }
            };
            undone = undone.max(most);
            if left > 0 {
                // The next interfaces use velocities that include these forces.
                if self.around.has_shared_pairs() {
                    self.around.exchange_intermediate_forces(&mut t.pairs)?;
                }
                self.apply_forces(t);
                t.mark_all_changed();
            }
        }
        Ok(undone)
    }

    /// Applies the forces of a sweep to nodes, if this is not done within the sweep.
    fn apply_all_forces(&mut self, t: &mut PairTable) {
        let iterations = self.laws.iterations();
        match iterations {
            // Gauss-Seidel sweeps apply the forces of own pairs and of other workers' pairs
            // themselves.
            [Iteration::GaussSeidel] => {}
            [Iteration::Split] => t.sum_changed_forces(|t, k| {
                self.apply_force_at(k as u32, t.touched[k], (&t.total[k], t.couples.get(k)));
            }),
            _ => self.apply_forces(t),
        }
        if self.coupled || iterations.len() > 1 {
            t.mark_all_changed();
        }
    }

    /// Applies the forces of all pairs to rigid bodies. Returns true if `changed` is true on any
    /// worker.
    fn apply_to_bodies(&mut self, t: &PairTable, changed: bool) -> Result<bool, RankLost> {
        if !self.coupled {
            return Ok(changed);
        }
        let forces = NodalForces { touched: &t.touched, total: &t.total, couples: &t.couples };
        self.around.apply_forces(self.nodes, forces, self.steps, changed)
    }

    /// Returns the new force of a selected pair and the residual of its present force, relative
    /// to the tolerance. Returns `None` if the force is not updated.
    fn updated(&self, p: &Pair, some: Selection) -> Option<(V3, f64)> {
        let law = some.law(p, self.laws)?;
        let velocity = p.relative_velocity(self.nodes);
        let all = matches!(some.stage, Stage::Accelerated);
        law.refine(p, &velocity, self.steps).filter(|&(_, left)| all || left > 1.0)
    }

    /// Updates the selected own pairs, all from the same state. Returns their largest residual,
    /// relative to the tolerance. Plain sweeps add momentum and update due pairs only.
    fn all_at_once(&mut self, t: &mut PairTable, some: Selection) -> f64 {
        let mut undone: f64 = 0.0;
        let (due, sweep) = match some.stage {
            Stage::Plain(sweep) => (t.take_due(), Some(sweep)),
            Stage::Accelerated => (t.own_pairs(), None),
        };
        for i in due {
            let pair = &t.pairs[i as usize];
            let Some((force, left)) = self.updated(pair, some) else {
                self.momentum.stop(i as usize, pair);
                continue;
            };
            let law = self.laws.of_interface(pair);
            // The last sweep of a law leaves the force of the law.
            let has_momentum = law.converges && sweep.is_some_and(|sweep| sweep + 1 < law.sweeps);
            let next =
                if has_momentum { self.momentum.advance(i as usize, pair, force) } else { force };
            t.set_force(i, next);
            undone = undone.max(left);
        }
        undone
    }

    /// Predicts the forces that all pairs still need and the motion of the segments under them,
    /// with each slave's mass and force divided among the segment's nodes. Then corrects the
    /// forces of own pairs. Returns infinity if a force has changed, else 0.
    fn predict_and_correct(
        &mut self,
        t: &mut PairTable,
        some: Selection,
        (partition, little): (f64, f64),
    ) -> Result<f64, RankLost> {
        for p in t.pairs.iter_mut().filter(|p| p.is_owned) {
            let velocity = p.relative_velocity(self.nodes);
            let guess = |law: &dyn ContactLaw| law.guess(p, &velocity, self.steps);
            p.predictor_force = some.law(p, self.laws).map_or(V3::zeros(), guess);
            if p.has_couple() && p.compliance[1] > 0.0 {
                let sliding = velocity - p.normal * velocity.dot(&p.normal);
                p.max_tangential_correction = (p.slip / self.steps.dt + sliding).norm()
                    / (self.steps.dt_damped * p.compliance[1]);
            }
        }
        if self.around.has_shared_pairs() {
            self.around.exchange_predictor_forces(&mut t.pairs)?;
        }
        let fraction = |p: &Pair| {
            if p.is_owned {
                p.partition_factor_of(partition, t.opposing_pairs(p, little))
            } else {
                1.0
            }
        };
        let fractions: Vec<f64> = t.pairs.iter().map(fraction).collect();
        t.pairs.iter_mut().zip(fractions).for_each(|(p, fraction)| p.partition_factor = fraction);
        // The slave of a pair has its present velocity; the segment has the velocity under all
        // predictor forces.
        let own = t.pairs.iter().filter(|p| p.is_owned);
        let slaves: Vec<V3> = own.map(|p| p.slave_velocity(self.nodes)).collect();
        for (k, &n) in t.touched.iter().enumerate() {
            if !t.couples.is_empty() {
                self.predict_turning(t, k, n);
                continue;
            }
            let (force, mass) = t.predicted_normal_load(k);
            self.set_velocity(n, self.predicted(n, &force, mass));
        }
        let mut undone: f64 = 0.0;
        for (p, slave) in t.pairs.iter_mut().filter(|p| p.is_owned).zip(slaves) {
            let moved = p.slave_velocity(self.nodes);
            let velocity = p.relative_velocity(self.nodes) + slave - moved;
            if let Some(force) =
                some.law(p, self.laws).and_then(|law| law.update(p, &velocity, self.steps))
            {
                p.force = force;
                undone = f64::INFINITY;
            }
        }
        Ok(undone)
    }

    /// Returns the velocity of node `n` under the predictor forces of the pairs on whose target
    /// side it is, with the masses of their slaves added to its own.
    fn predicted(&self, n: u32, force: &V3, mass: f64) -> Row {
        let total = self.nodes.contact_mass(n as usize) + mass;
        let inverse =
            self.nodes.inv_mass[n as usize].map(|i| if i > 0.0 { 1.0 / total } else { 0.0 });
        accelerated_velocity(
            &self.nodes.v_next[n as usize],
            &-force,
            &inverse,
            self.steps.dt_damped,
        )
    }

    /// Sets the predicted velocity and rotational velocity of node n if friction rotates nodes.
    /// The slaves that slide on node n add a part M of their mass there, which moves and rotates
    /// with the node. With the lever arm b and the inertia I, a force changes the velocity by
    /// `1/m / (1 + M (1/m + b^2/I))` and a moment changes the rotational velocity by the same
    /// with `1/I` in place of the first `1/m`.
    fn predict_turning(&mut self, t: &PairTable, k: usize, n: u32) {
        let guessed = t.predicted_load(k);
        let v = self.predicted(n, &guessed.force, guessed.mass);
        let (inv_mass, inv_inertia) =
            (self.nodes.inv_mass[n as usize], self.nodes.inv_inertia[n as usize]);
        let most = |inverse: &Row| inverse[0].max(inverse[1]).max(inverse[2]);
        let held =
            1.0 + guessed.sliding_mass * most(&inv_mass) + guessed.turned_mass * most(&inv_inertia);
        self.set_velocity(
            n,
            accelerated_velocity(
                &v,
                &-guessed.tangential_force,
                &inv_mass.map(|i| i / held),
                self.steps.dt_damped,
            ),
        );
        let spin = &self.nodes.w_next[n as usize];
        self.set_rotational_velocity(
            n,
            accelerated_velocity(
                spin,
                &guessed.couple,
                &inv_inertia.map(|i| i / held),
                self.steps.dt_damped,
            ),
        );
    }

    /// Sums the forces of all pairs on the nodes that they touch, and sets the velocities of
    /// these nodes with the forces and walls.
    fn apply_forces(&mut self, t: &mut PairTable) {
        t.sum_forces();
        for (k, total) in t.total.iter().enumerate() {
            self.apply_force_at(k as u32, t.touched[k], (total, t.couples.get(k)));
        }
    }

    fn apply_force_at(&mut self, k: u32, n: u32, (total, couple): NodalLoad<'_>) {
        let v = accelerated_velocity(
            &self.free[k as usize],
            total,
            &self.nodes.inv_mass[n as usize],
            self.steps.dt_damped,
        );
        self.set_velocity(n, v);
        if let Some(couple) = couple {
            let inverse = &self.nodes.inv_inertia[n as usize];
            self.set_rotational_velocity(
                n,
                accelerated_velocity(
                    &self.free_spins[k as usize],
                    couple,
                    inverse,
                    self.steps.dt_damped,
                ),
            );
        }
    }

    /// Sets the rotational velocity of node `n` to `w`, unless the node belongs to a rigid body.
    fn set_rotational_velocity(&mut self, n: u32, w: Row) {
        if !self.around.is_in_body(n) {
            self.nodes.w_next[n as usize] = w;
        }
    }

    /// Sets the velocity of node `n` to `v`, or to the velocity that a wall allows, unless the
    /// node belongs to a rigid body.
    fn set_velocity(&mut self, n: u32, v: Row) {
        if !self.around.is_in_body(n) {
            self.nodes.v_next[n as usize] =
                self.around.allowed_velocity(self.nodes, n, v, self.steps.dt);
        }
    }
}
