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

/// Pressure over the square of the density, and speed of sound [length/time], of a particle.
struct PressedParticle {
    pressure: f64,
    sound_speed: f64,
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

    /// Returns the neighbours of the own particle with the number `k`, ascending: their indices,
    /// the vector from the neighbour, and the gradient of the kernel over this vector.
    /// Positions are those a time `back` ago, with the velocities of the last mid-step.
    fn neighbours(&self, k: usize, back: f64) -> impl Iterator<Item = (usize, V3, f64)> + '_ {
        let own = &self.states[self.own[k] as usize];
        let h = self.fluid(own).smoothing;
        let at = move |s: &ParticleState| V3::from(s.x) - V3::from(s.v) * back;
        let here = at(own);
        self.candidates[self.starts[k]..self.starts[k + 1]].iter().filter_map(move |&j| {
            let other = &self.states[j as usize];
            let h = 0.5 * (h + self.fluid(other).smoothing);
            let apart = here - at(other);
            let r = apart.norm();
            (r > 0.0 && r < 2.0 * h).then(|| (j as usize, apart, slope_over_distance(r, h)))
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
            for (j, apart, slope) in self.neighbours(k, 0.5 * dt) {
                let other = &self.states[j];
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
        // A particle has some sixty neighbours: once for each of them would be much work.
        let pressed = |s: &ParticleState| {
            let fluid = self.fluid(s);
            let pressure = fluid.pressure(s.density) / (s.density * s.density);
            PressedParticle { pressure, sound_speed: fluid.sound_speed(s.density) }
        };
        let all: Vec<PressedParticle> = self.states.iter().map(pressed).collect();
        (0..self.own.len()).map(move |k| self.sums_of(k, &all))
    }

    /// Returns the sums of the own particle with the number `k`; `all` has the pressures of all.
    fn sums_of(&self, k: usize, all: &[PressedParticle]) -> ParticleSums {
        let own = &self.states[self.own[k] as usize];
        let fluid = self.fluid(own);
        let PressedParticle { pressure: mine, sound_speed: c } = all[self.own[k] as usize];
        let (mut force, mut largest) = (V3::zeros(), 0.0f64);
        for (j, apart, slope) in self.neighbours(k, 0.0) {
            let (other, its) = (&self.states[j], &all[j]);
            let of_other = self.fluid(other);
            let closing = (V3::from(own.v) - V3::from(other.v)).dot(&apart);
            let h = 0.5 * (fluid.smoothing + of_other.smoothing);
            let mu = (h * closing / (apart.norm_squared() + 0.01 * h * h)).min(0.0);
            let mean = |a: f64, b: f64| 0.5 * (a + b);
            let speed = mean(c, its.sound_speed);
            let [alpha, beta] = [0, 1].map(|i| mean(fluid.viscosity[i], of_other.viscosity[i]));
            let viscous = mu * (beta * mu - alpha * speed) / mean(own.density, other.density);
            let pressed = mine + its.pressure;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::job::ParticlesInput;

    const STEP: f64 = 1e-3;

    /// Returns particles of two fluids about a distance of 1 apart, with ids in no order.
    fn cloud() -> Vec<ParticleState> {
        let mut random = 1u64;
        let mut number = move || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        let state = |k: u64| ParticleState {
            id: ElemId(k * 75 % 343),
            part: k % 2,
            x: [k / 49, k / 7 % 7, k % 7].map(|c| c as f64 + 0.6 * number()),
            v: [0, 1, 2].map(|_| 50.0 * number()),
            density: 1e-6 * (1.0 + 0.1 * number()),
        };
        (0..343).map(state).collect()
    }

    fn fluid(smoothing: f64) -> Option<Fluid> {
        Some(Fluid::new(&ParticlesInput {
            spacing: 1.0,
            density: 1e-6,
            sound_speed: 1500.0,
            exponent: None,
            hugoniot: None,
            tension: 0.0,
            viscosity: [1.0, 2.0],
            smoothing,
            contact_radius: None,
        }))
    }

    /// Returns the sums of the particles that `is_own` selects, with all others within reach as
    /// ghosts, whose densities are those of `whole`.
    fn sums(
        cloud: &[ParticleState],
        is_own: impl Fn(&ParticleState) -> bool,
        whole: Option<&Particles>,
    ) -> (Particles, Vec<(ElemId, ParticleSums)>) {
        let fluids = vec![fluid(1.2), fluid(1.3)];
        let mut particles = Particles { fluids, smoothing: 1.3, ..Particles::default() };
        let mut own: Vec<ParticleState> = cloud.iter().filter(|s| is_own(s)).copied().collect();
        own.sort_by_key(|s| s.id);
        particles.start(own.iter().copied());
        let (bounds, _) = particles.bounds();
        let reach = particles.reach(100.0, STEP);
        let near = bounds.grown(reach);
        let ghosts: Vec<ParticleState> =
            cloud.iter().filter(|s| !is_own(s) && near.contains(s.x)).copied().collect();
        particles.find_candidates(&ghosts, reach);
        particles.update_densities(STEP);
        if let Some(whole) = whole {
            let densities: Vec<f64> = whole.densities(&ghosts).collect();
            particles.set_densities(&ghosts, &densities);
        }
        let sums = own.iter().map(|s| s.id).zip(particles.sums()).collect();
        (particles, sums)
    }

    /// The neighbours of two workers together are those of one: the sums have the same bits.
    #[test]
    fn sums_do_not_depend_on_the_owners() {
        let cloud = cloud();
        let (whole, all) = sums(&cloud, |_| true, None);
        let mut both = sums(&cloud, |s| s.x[0] + s.x[1] < 5.0, Some(&whole)).1;
        both.extend(sums(&cloud, |s| s.x[0] + s.x[1] >= 5.0, Some(&whole)).1);
        both.sort_by_key(|s| s.0);
        assert!(both == all);
    }

    /// Forces between two particles are opposite and along their line: their sum and their moment
    /// are the round-off of sums.
    #[test]
    fn forces_conserve_momentum_and_angular_momentum() {
        let cloud = cloud();
        let (whole, all) = sums(&cloud, |_| true, None);
        let forces = || all.iter().map(|s| V3::from(s.1.force));
        let size: f64 = forces().map(|f| f.norm()).sum();
        assert!(size > 0.0 && forces().sum::<V3>().norm() < 1e-14 * size, "{size}");
        let moment = |(id, sums): &(ElemId, ParticleSums)| {
            let state = &whole.states[whole.index_of(*id).unwrap()];
            V3::from(state.x).cross(&V3::from(sums.force))
        };
        assert!(all.iter().map(moment).sum::<V3>().norm() < 1e-13 * size);
    }
}
