//! How the forces of all pairs come about within a step: sweep after sweep over all of them, or by prediction and
//! correction in one.

use crate::contact::enforce::{ContactLaw, Iteration, Laws, Steps};
use crate::contact::geometry::V3;
use crate::contact::pairs::{Pair, PairTable, push};
use crate::nodes::{Nodes, Row};
use crate::rigid::Bodies;
use crate::wall::Walls;
use crumple_proto::transport::{Lost, Transport};

/// What all pairs act on.
pub struct Sweeps<'a> {
    /// The laws of all interfaces.
    pub laws: &'a Laws,
    /// Nodes; those that pairs touch are brought to the velocities with contact and walls.
    pub nodes: &'a mut Nodes,
    /// Velocities without contact of the nodes in the table's `touched` [length/time].
    pub free: &'a [Row],
    /// Rigid walls.
    pub walls: &'a Walls,
    /// Rigid bodies; their nodes go where the bodies go.
    pub bodies: &'a mut Bodies,
    /// Whether a pair touches a body, on any worker.
    pub coupled: bool,
    /// Steps around the present time.
    pub steps: Steps,
}

/// Pairs that are updated together within a sweep: those of the interfaces that iterate in this way, as long as their laws want to.
#[derive(Clone, Copy)]
struct Selection {
    iteration: Iteration,
    /// From 0.
    sweep: usize,
}

impl Selection {
    /// The law of an own pair, if the pair is one of them.
    fn law<'a>(&self, pair: &Pair, laws: &'a Laws) -> Option<&'a dyn ContactLaw> {
        let law = laws.of_pair(pair);
        (law.iteration() == self.iteration && self.sweep < law.sweeps()).then_some(law)
    }
}

/// What a worker and one that it has contact pairs in common with exchange in a step, told of pairs apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// Sweeps of both.
    pub sweeps: f64,
    /// Messages one way.
    pub messages: f64,
    /// Words that lead them, and words for every pair that the other is told of.
    pub words: [f64; 2],
}

impl Exchange {
    /// That of a step that takes `alone` sweeps on one worker, among workers that know after `quiet` rounds that none has changed
    /// anything. What `Sweeps::run` does, with the least that it may take: one message in a sweep for the forces; one more
    /// for guesses, or for the forces of a phase of pairs in order; and the rounds in which the phases are laid down, at least
    /// as many as it takes to know that they stand. The last sweep of one worker changes nothing; on several there are `quiet`
    /// such, as far as the laws let them. Where interfaces have several ways to iterate, each takes its messages in every sweep, and
    /// the forces are exchanged once more.
    pub fn of(laws: &Laws, alone: f64, quiet: u64) -> Self {
        let quiet = quiet as f64;
        let sweeps = (alone + quiet - 1.0).min(laws.sweeps() as f64).max(alone);
        let of_one = |iteration: &Iteration| match iteration {
            Iteration::Split | Iteration::Jacobi => [sweeps, 2.0 * sweeps, 3.0 * sweeps],
            Iteration::Correct { .. } => [2.0 * sweeps, 2.0 * sweeps, 6.0 * sweeps],
            Iteration::GaussSeidel => [quiet + 2.0 * sweeps, 2.0 * (quiet + sweeps), quiet + 6.0 * sweeps],
        };
        let common = if laws.iterations().len() > 1 { [sweeps, 2.0 * sweeps, 3.0 * sweeps] } else { [0.0; 3] };
        let add = |sum: [f64; 3], one: [f64; 3]| std::array::from_fn(|i| sum[i] + one[i]);
        let [messages, lead, each] = laws.iterations().iter().map(of_one).fold(common, add);
        Self { sweeps, messages, words: [lead, each] }
    }
}

impl Sweeps<'_> {
    /// Sweeps until all forces are good enough or the law has had enough; returns the number of sweeps.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn run(&mut self, t: &mut PairTable, wire: &mut dyn Transport) -> Result<u64, Lost> {
        let iterations = self.laws.iterations();
        t.soften(self.nodes, self.bodies, |pair| self.laws.of_pair(pair).iteration());
        if iterations.contains(&Iteration::GaussSeidel) {
            t.lay_order(wire)?;
        }
        self.feel(t);
        self.move_bodies(t, wire, true)?;
        let mut sweeps = 0;
        for sweep in 0..self.laws.sweeps() {
            sweeps += 1;
            let mut changed = false;
            for (left, &iteration) in (0..iterations.len()).rev().zip(iterations) {
                let some = Selection { iteration, sweep };
                changed |= match iteration {
                    Iteration::Split | Iteration::Jacobi => self.all_at_once(t, some),
                    Iteration::GaussSeidel => t.sweep_in_order(wire, self, |p, s| s.updated(p, some), Self::feel_at)?,
                    Iteration::Correct { partition, little } => self.correct(t, some, (partition, little), wire)?,
                };
                if left > 0 {
                    // The next interfaces feel what these have come to.
                    if t.is_common() {
                        t.swap_between(wire)?;
                    }
                    self.feel(t);
                    t.look_at_all();
                }
            }
            let quiet = if t.is_common() { t.swap_forces(wire, changed)? } else { !changed };
            // One by one, what own and others' pairs have come to has been felt within the sweep.
            if iterations != [Iteration::GaussSeidel] {
                self.feel(t);
                if iterations.len() > 1 {
                    t.look_at_all();
                }
            }
            if self.coupled {
                t.look_at_all();
                // All workers hear of each other, and end together.
                if !self.move_bodies(t, wire, changed)? {
                    break;
                }
                continue;
            }
            if quiet {
                break;
            }
        }
        Ok(sweeps)
    }

    /// Lets rigid bodies feel the forces of all pairs; whether `changed` holds on any worker.
    fn move_bodies(&mut self, t: &PairTable, wire: &mut dyn Transport, changed: bool) -> Result<bool, Lost> {
        if !self.coupled {
            return Ok(changed);
        }
        self.bodies.feel(wire, self.nodes, (&t.touched, &t.total), self.walls, self.steps, changed)
    }

    fn updated(&self, p: &Pair, some: Selection) -> Option<V3> {
        let law = some.law(p, self.laws)?;
        law.update(p, &p.relative_velocity(&self.nodes.next_v), self.steps)
    }

    /// Some of the own pairs, from the same state; whether a force has changed.
    fn all_at_once(&self, t: &mut PairTable, some: Selection) -> bool {
        let mut changed = false;
        for p in t.pairs.iter_mut().filter(|p| p.own) {
            if let Some(force) = self.updated(p, some) {
                p.force = force;
                changed = true;
            }
        }
        changed
    }

    /// Guesses what all pairs still need, sees how segments would move under that, each slave's mass and force shared
    /// among a segment's nodes, and corrects the forces of own pairs; whether one has changed.
    fn correct(
        &mut self,
        t: &mut PairTable,
        some: Selection,
        (partition, little): (f64, f64),
        wire: &mut dyn Transport,
    ) -> Result<bool, Lost> {
        for p in t.pairs.iter_mut().filter(|p| p.own) {
            let guess = |law: &dyn ContactLaw| law.guess(p, &p.relative_velocity(&self.nodes.next_v), self.steps);
            p.guess = some.law(p, self.laws).map_or(V3::zeros(), guess);
        }
        if t.is_common() {
            t.swap_guesses(wire)?;
        }
        let fraction = |p: &Pair| if p.own { p.turn_of(partition, t.opposed(p, little)) } else { 1.0 };
        let fractions: Vec<f64> = t.pairs.iter().map(fraction).collect();
        t.pairs.iter_mut().zip(fractions).for_each(|(p, fraction)| p.turn = fraction);
        // The slave of a pair is taken where it goes now, the segment where all guesses would take it.
        let own = t.pairs.iter().filter(|p| p.own);
        let slaves: Vec<V3> = own.map(|p| p.slave_velocity(&self.nodes.next_v)).collect();
        for (k, &n) in t.touched.iter().enumerate() {
            let (force, mass) = t.pressed_on(k);
            let total = self.nodes.contact_mass(n as usize) + mass;
            let inverse = self.nodes.inv_mass[n as usize].map(|i| if i > 0.0 { 1.0 / total } else { 0.0 });
            self.bring(n, push(&self.nodes.next_v[n as usize], &-force, &inverse, self.steps.push));
        }
        let mut changed = false;
        for (p, slave) in t.pairs.iter_mut().filter(|p| p.own).zip(slaves) {
            let moved = p.slave_velocity(&self.nodes.next_v);
            let velocity = p.relative_velocity(&self.nodes.next_v) + slave - moved;
            if let Some(force) = some.law(p, self.laws).and_then(|law| law.update(p, &velocity, self.steps)) {
                p.force = force;
                changed = true;
            }
        }
        Ok(changed)
    }

    /// Adds up the forces of all pairs on the nodes that they touch and lets these feel them, and walls.
    fn feel(&mut self, t: &mut PairTable) {
        t.add_up();
        for (k, total) in t.total.iter().enumerate() {
            self.feel_at(k as u32, t.touched[k], total);
        }
    }

    fn feel_at(&mut self, k: u32, n: u32, total: &V3) {
        let v = push(&self.free[k as usize], total, &self.nodes.inv_mass[n as usize], self.steps.push);
        self.bring(n, v);
    }

    /// Node `n` goes with velocity `v` unless a wall stops it, or it belongs to a rigid body.
    fn bring(&mut self, n: u32, v: Row) {
        if self.bodies.of(n).is_some() {
            return;
        }
        let n = n as usize;
        self.nodes.next_v[n] = self.walls.stop(self.nodes, n, v, self.steps.dt);
    }
}
