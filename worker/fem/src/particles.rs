//! Sums over the neighbours of particles: densities and forces (`elements/particle.rs`).
//!
//! A worker has its own particles and, as ghosts, those of other workers within reach. They are
//! in ascending element id, and so are the neighbours of each: the sums have the same bits on any
//! worker, and a ghost more or less outside of the support changes nothing. Candidates come from
//! cells as wide as the reach.

use crate::elements::particle::{Fluid, slope_over_distance};
use bytemuck::{Pod, Zeroable};
use crumple_math::row::V3;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::ElemId;
use crumple_proto::job::Part;
use crumple_proto::partition::Settings;

/// State of a particle at the start of a step, as it is sent to other workers.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ParticleState {
    /// Its element.
    pub id: ElemId,
    /// Index of its part.
    pub part: u64,
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Velocity at the last mid-step [length/time].
    pub v: [f64; 3],
    /// Density [mass/length^3]: at the time before, and after [`Particles::update_densities`] now.
    pub density: f64,
}

/// Sums of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSums {
    /// Density [mass/length^3].
    pub density: f64,
    /// Force of its neighbours [force].
    pub force: [f64; 3],
    /// Stable step [time].
    pub stable_dt: f64,
}

/// The particles that a worker knows in a step.
#[derive(Default)]
pub struct Particles {
    fluids: Vec<Option<Fluid>>,
    /// Largest smoothing length [length].
    smoothing: f64,
    /// Own particles and ghosts, ascending.
    states: Vec<ParticleState>,
    /// Indices of the own particles, ascending.
    own: Vec<u32>,
    /// Candidates of each own particle, ascending: start of its range, and indices.
    starts: Vec<usize>,
    candidates: Vec<u32>,
    cells: Vec<([i64; 3], u32)>,
    densities: Vec<f64>,
}

/// Relative amount by which the reach is wider than computed, so that round-off loses no candidate.
const ROUND_OFF: f64 = 1e-6;

impl Particles {
    /// Returns an empty list for the parts of a job; `None` if the job has no particles.
    pub fn new(settings: &Settings) -> Option<Self> {
        let fluid = |part: &Part| part.particles.as_ref().map(Fluid::new);
        let fluids: Vec<Option<Fluid>> = settings.parts.iter().map(fluid).collect();
        let smoothing = fluids.iter().flatten().map(|f| f.smoothing).fold(0.0, f64::max);
        fluids.iter().any(Option::is_some).then(|| Self { fluids, smoothing, ..Self::default() })
    }

    /// Sets the own particles, in ascending id.
    pub fn start(&mut self, own: impl Iterator<Item = ParticleState>) {
        self.states.clear();
        self.states.extend(own);
    }

    /// Returns the box around the own particles, and their largest speed [length, length/time].
    pub fn bounds(&self) -> (Aabb, f64) {
        let speed = |s: &ParticleState| V3::from(s.v).norm();
        let fastest = self.states.iter().map(speed).fold(0.0, f64::max);
        (Aabb::around(self.states.iter().map(|s| s.x)), fastest)
    }

    /// Returns the distance within which particles are candidates, in a step after one of size `dt`
    /// [time] with this largest speed: two particles are neighbours at the middle of the last step
    /// or now [length].
    pub fn reach(&self, speed: f64, dt: f64) -> f64 {
        (2.0 * self.smoothing + speed * dt) * (1.0 + ROUND_OFF)
    }

    /// Returns the own particles in a box, ascending. There must be no ghosts yet.
    pub fn own_in(&self, near: &Aabb) -> Vec<ParticleState> {
        self.states.iter().filter(|s| near.contains(s.x)).copied().collect()
    }

    /// Adds ghosts, and finds the candidates of the own particles within `reach` [length].
    pub fn find_candidates(&mut self, ghosts: &[ParticleState], reach: f64) {
        let own: Vec<ElemId> = self.states.iter().map(|s| s.id).collect();
        self.states.extend(ghosts);
        self.states.sort_unstable_by_key(|s| s.id);
        self.own = own.iter().filter_map(|&id| self.index_of(id).map(|i| i as u32)).collect();
        let cell = |x: &[f64; 3]| x.map(|c| (c / reach).floor() as i64);
        self.cells.clear();
        self.cells.extend(self.states.iter().zip(0..).map(|(s, i)| (cell(&s.x), i)));
        self.cells.sort_unstable();
        self.candidates.clear();
        self.starts.clear();
        self.starts.push(0);
        for &i in &self.own {
            let x = V3::from(self.states[i as usize].x);
            let [a, b, c] = cell(&self.states[i as usize].x);
            let from = self.candidates.len();
            for (da, db) in (-1..=1).flat_map(|da| (-1..=1).map(move |db| (da, db))) {
                let first = [a + da, b + db, c - 1];
                let row = self.cells.partition_point(|cell| cell.0 < first);
                let row = self.cells[row..].iter();
                for &(_, j) in row.take_while(|cell| cell.0 <= [a + da, b + db, c + 1]) {
                    let other = &self.states[j as usize];
                    if j != i && (V3::from(other.x) - x).norm_squared() <= reach * reach {
                        self.candidates.push(j);
                    }
                }
            }
            self.candidates[from..].sort_unstable();
            self.starts.push(self.candidates.len());
        }
    }

    /// Returns the index of a particle.
    fn index_of(&self, id: ElemId) -> Option<usize> {
        self.states.binary_search_by_key(&id, |s| s.id).ok()
    }

    fn fluid(&self, state: &ParticleState) -> &Fluid {
        self.fluids[state.part as usize].as_ref().expect("only parts of particles have particles")
    }

    /// Returns the neighbours of the own particle with the number `k`, ascending: pairs of
    /// particles, the vector from the neighbour, and the gradient of the kernel over this vector.
    /// Positions are those a time `back` ago, with the velocities of the last mid-step.
    fn neighbours(
        &self,
        k: usize,
        back: f64,
    ) -> impl Iterator<Item = (&ParticleState, V3, f64)> + '_ {
        let own = &self.states[self.own[k] as usize];
        let h = self.fluid(own).smoothing;
        let at = move |s: &ParticleState| V3::from(s.x) - V3::from(s.v) * back;
        let here = at(own);
        self.candidates[self.starts[k]..self.starts[k + 1]].iter().filter_map(move |&j| {
            let other = &self.states[j as usize];
            let h = 0.5 * (h + self.fluid(other).smoothing);
            let apart = here - at(other);
            let r = apart.norm();
            (r > 0.0 && r < 2.0 * h).then(|| (other, apart, slope_over_distance(r, h)))
        })
    }

    /// Advances the densities of the own particles over the last step `dt` [time], with the
    /// gradients of the kernel at its middle.
    pub fn update_densities(&mut self, dt: f64) {
        let mut densities = std::mem::take(&mut self.densities);
        densities.clear();
        densities.extend(self.own.iter().enumerate().map(|(k, &i)| {
            let own = &self.states[i as usize];
            let mut rate = 0.0;
            for (other, apart, slope) in self.neighbours(k, 0.5 * dt) {
                let v = V3::from(own.v) - V3::from(other.v);
                rate += self.fluid(other).mass * slope * v.dot(&apart);
            }
            own.density + dt * rate
        }));
        for (&i, &density) in self.own.iter().zip(&densities) {
            self.states[i as usize].density = density;
        }
        self.densities = densities;
    }

    /// Returns the densities of these own particles [mass/length^3].
    pub fn densities<'a>(&'a self, of: &'a [ParticleState]) -> impl Iterator<Item = f64> + 'a {
        of.iter().filter_map(|s| self.index_of(s.id)).map(|i| self.states[i].density)
    }

    /// Sets the densities of ghosts [mass/length^3].
    pub fn set_densities(&mut self, of: &[ParticleState], densities: &[f64]) {
        for (s, &density) in of.iter().zip(densities) {
            if let Some(i) = self.index_of(s.id) {
                self.states[i].density = density;
            }
        }
    }

    /// Returns the sums of the own particles, ascending. The densities of all particles must be
    /// those of now.
    pub fn sums(&self) -> impl Iterator<Item = ParticleSums> + '_ {
        (0..self.own.len()).map(move |k| self.sums_of(k))
    }

    fn sums_of(&self, k: usize) -> ParticleSums {
        let own = &self.states[self.own[k] as usize];
        let fluid = self.fluid(own);
        let c = fluid.sound_speed(own.density);
        let over = |s: &ParticleState, f: &Fluid| f.pressure(s.density) / (s.density * s.density);
        let mine = over(own, fluid);
        let (mut force, mut largest) = (V3::zeros(), 0.0f64);
        for (other, apart, slope) in self.neighbours(k, 0.0) {
            let of_other = self.fluid(other);
            let closing = (V3::from(own.v) - V3::from(other.v)).dot(&apart);
            let h = 0.5 * (fluid.smoothing + of_other.smoothing);
            let mu = (h * closing / (apart.norm_squared() + 0.01 * h * h)).min(0.0);
            let mean = |a: f64, b: f64| 0.5 * (a + b);
            let speed = mean(c, of_other.sound_speed(other.density));
            let [alpha, beta] = [0, 1].map(|i| mean(fluid.viscosity[i], of_other.viscosity[i]));
            let viscous = mu * (beta * mu - alpha * speed) / mean(own.density, other.density);
            let pressed = mine + over(other, of_other);
            force -= apart * (fluid.mass * of_other.mass * (pressed + viscous) * slope);
            largest = largest.max(-mu);
        }
        ParticleSums {
            density: own.density,
            force: force.into(),
            stable_dt: fluid.stable_dt(c, largest),
        }
    }
}
