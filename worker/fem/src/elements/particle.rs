//! Particle of a weakly compressible fluid (smoothed particle hydrodynamics, Monaghan 1992).
//!
//! The mass of a particle is constant. Its density follows from the velocities of its neighbours,
//! the pressure from its density, and the forces between two particles from their pressures:
//! ```text
//! d rho_i/dt = sum_j m_j (v_i - v_j) . grad W_ij
//! p_i = (rho_0 c_0^2 / n) ((rho_i / rho_0)^n - 1), or that of an isentrope,  p_i >= -tension
//! f_ij = -m_i m_j (p_i / rho_i^2 + p_j / rho_j^2 + Pi_ij) grad W_ij
//! Pi_ij = (-alpha c mu + beta mu^2) / rho,  mu = min(h v_ij . x_ij / (x_ij^2 + h^2/100), 0)
//! ```
//! with means of h, rho, c, alpha and beta over the two particles. W is the cubic spline with the
//! support 2 h. The force of j on i is that of i on j with the other sign, bit for bit, and along
//! the line between them: momentum and angular momentum are conserved. Density and forces are sums
//! over neighbours (`particles.rs`); this file has the law of one particle, and its element, which
//! hands the sum to its node and adds up its work. As one particle does work on others, only the
//! sum of the internal energies of all particles has a meaning.
//!
//! Stable step: with the discrete gradient G the frequencies are `w = c |G|`. For the spline |G|
//! is below 0.85/h, the largest value of `k W(k)`, so that `dt w < 0.85` for `dt = h/c`. The linear
//! viscosity damps with a rate of at most `2 alpha c/h`; the velocities are half a step old, which
//! is stable as long as `(dt w)^2 + 2 dt (2 alpha c/h) <= 4`. The step
//! `h / (c + 1.2 (alpha c + 2 beta |mu|))` (Monaghan 1992, sec. 10.3, with the slope of the
//! quadratic term) is below this limit for any alpha.
//!
//! Left out: shear stress, heat, change of h with the density, corrections of the kernel at free
//! surfaces, damping of the tensile instability (without tension there is none).

use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, PassTotals,
    SingleElement,
};
use crate::columns::ElementState;
use crate::materials::{Equation, Isentrope};
use crumple_math::row::xyz;
use crumple_proto::job::{Part, ParticlesInput};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;
use std::f64::consts::PI;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "particle",
    shape: Shape::Point1,
    meaning: "Particle of a fluid, which its neighbours push (smoothed particle hydrodynamics).",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Discrete(build),
};

/// Number of columns of a particle: density [mass/length^3], stable step [time], force that acts on
/// it now and one step before [force].
pub const COLUMNS: usize = 8;
/// Column of the density.
pub const DENSITY: usize = 0;
/// Column of the stable step.
pub const STEP: usize = 1;
/// First column of the force.
pub const FORCE: usize = 2;
const BEFORE: usize = 5;

/// Numbers of the particles of a part.
#[derive(Clone, Debug)]
pub struct Fluid {
    /// Mass of a particle [mass].
    pub mass: f64,
    /// Smoothing length h [length].
    pub smoothing: f64,
    /// Density without pressure [mass/length^3].
    pub density: f64,
    sound_speed: f64,
    exponent: f64,
    /// Pressure by the equation of Mie and Gruneisen, in place of the exponent.
    isentrope: Option<Isentrope>,
    tension: f64,
    /// Coefficients alpha and beta of the artificial viscosity.
    pub viscosity: [f64; 2],
}

impl Fluid {
    /// Reads the numbers of a job.
    pub fn new(job: &ParticlesInput) -> Self {
        Self {
            mass: job.density * job.spacing.powi(3),
            smoothing: job.smoothing * job.spacing,
            density: job.density,
            sound_speed: job.sound_speed,
            exponent: job.exponent(),
            isentrope: job.hugoniot.map(|constants| {
                Isentrope::new(Equation::gruneisen(job.density, job.sound_speed, constants))
            }),
            tension: job.tension,
            viscosity: job.viscosity,
        }
    }

    /// Returns the pressure at a density [force/length^2].
    pub fn pressure(&self, density: f64) -> f64 {
        if let Some(isentrope) = &self.isentrope {
            return isentrope.at(density / self.density - 1.0).pressure.max(-self.tension);
        }
        let modulus = self.density * self.sound_speed * self.sound_speed;
        let over = (density / self.density).powf(self.exponent) - 1.0;
        (modulus / self.exponent * over).max(-self.tension)
    }

    /// Returns the speed of sound at a density [length/time].
    pub fn sound_speed(&self, density: f64) -> f64 {
        if let Some(isentrope) = &self.isentrope {
            return (isentrope.at(density / self.density - 1.0).slope / self.density).sqrt();
        }
        self.sound_speed * (density / self.density).powf(0.5 * (self.exponent - 1.0))
    }

    /// Returns the stable step at a speed of sound, with the largest |mu| of its neighbours
    /// [time].
    pub fn stable_dt(&self, sound_speed: f64, largest_mu: f64) -> f64 {
        let [alpha, beta] = self.viscosity;
        let viscous = alpha * sound_speed + 2.0 * beta * largest_mu;
        self.smoothing / (sound_speed + 1.2 * viscous)
    }
}

/// Returns `W'(r) / r` of the cubic spline with the smoothing length `h`, at the distance `r` above
/// 0 [1/length^5].
pub fn slope_over_distance(r: f64, h: f64) -> f64 {
    let q = r / h;
    let shape = if q < 1.0 {
        2.25 * q - 3.0
    } else if q < 2.0 {
        -0.75 * (2.0 - q) * (2.0 - q) / q
    } else {
        0.0
    };
    shape / (PI * h.powi(5))
}

/// A particle as an element.
pub struct Particle(Fluid);

fn build(part: &Part) -> ElementResult {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(job) = &part.particles else {
        let help = "add [part.particles] with spacing, density and sound_speed";
        say("particles", "it has particles but no [part.particles]".into(), help);
        return Err(problems);
    };
    if !part.material.is_empty() {
        say("material", "a part of particles has no material".into(), "remove it");
    }
    if part.element.is_some() {
        say("element", "a part of particles has one formulation".into(), "remove `element`");
    }
    if part.skin {
        say("skin", "particles cannot be a skin".into(), "remove `skin`");
    }
    let above_zero = [
        ("spacing", Some(job.spacing)),
        ("density", Some(job.density)),
        ("sound_speed", Some(job.sound_speed)),
        ("exponent", job.exponent),
        ("contact_radius", job.contact_radius),
    ];
    for (key, value) in above_zero.into_iter().filter_map(|(key, value)| Some((key, value?))) {
        if !(value > 0.0 && value.is_finite()) {
            say(&format!("particles.{key}"), format!("{key} is {value}"), "it has to be above 0");
        }
    }
    if job.hugoniot.is_some_and(|all| all.iter().any(|x| !x.is_finite())) {
        let help = "give [s1, s2, s3, gamma, a]; water has about [1.92, 0, 0, 0, 0]";
        say("particles.hugoniot", "hugoniot is not five numbers".into(), help);
    }
    if job.hugoniot.is_some() && job.exponent.is_some() {
        let what = "exponent is given next to hugoniot".into();
        say("particles.exponent", what, "remove one of them");
    }
    let [alpha, beta] = job.viscosity;
    let from_zero = [("tension", job.tension), ("viscosity.0", alpha), ("viscosity.1", beta)];
    for (key, value) in from_zero {
        if !(value >= 0.0 && value.is_finite()) {
            let what = format!("{key} is {value}");
            say(&format!("particles.{key}"), what, "it has to be 0 or above");
        }
    }
    if !(1.0..=2.0).contains(&job.smoothing) {
        let what = format!("smoothing is {}", job.smoothing);
        say("particles.smoothing", what, "it has to be from 1 to 2; 1.2 is usual");
    }
    if problems.is_empty() { Ok(Box::new(Particle(Fluid::new(job)))) } else { Err(problems) }
}

impl Element for Particle {
    fn columns(&self) -> usize {
        COLUMNS
    }

    fn names(&self) -> Vec<String> {
        let names = ["density", "stable step", "force x", "force y", "force z"];
        let before = ["force before x", "force before y", "force before z"];
        names.into_iter().chain(before).map(String::from).collect()
    }

    fn start(&self, history: &mut [f64], _: OwnSection) {
        (history[DENSITY], history[STEP]) = (self.0.density, self.first_step());
    }

    fn corner_mass(&self, _: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (self.0.mass, 0.0)
    }

    /// Takes the sums over neighbours from the columns, where they are before the pass.
    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<1>(COLUMNS, |element, out| {
            let SingleElement { index, nodes: [node], state, internal } = element;
            let v = xyz(&nodes.v[node]);
            for c in 0..3 {
                let now = state[FORCE + c];
                let before = std::mem::replace(&mut state[BEFORE + c], now);
                *internal -= 0.5 * dt * (before + now) * v[c];
                out.force[index][c] = -now;
            }
            (state[STEP], state[DENSITY] > 0.0 && state.iter().all(|s| s.is_finite()))
        })
    }

    fn stable_dt(&self, _: &[[f64; 3]], _: OwnSection) -> f64 {
        self.first_step()
    }

    fn stable_dt_now(&self, history: ElementState<'_>, _: &[[f64; 3]]) -> f64 {
        history.at(STEP)
    }

    fn fluid(&self) -> Option<&Fluid> {
        Some(&self.0)
    }

    fn failed(&self, _: ElementState<'_>) -> bool {
        false
    }

    fn can_fail(&self) -> bool {
        false
    }

    fn fields(&self, history: ElementState<'_>, _: &[[f64; 3]]) -> ElementFields {
        let p = self.0.pressure(history.at(DENSITY));
        ElementFields { stress: [-p, -p, -p, 0.0, 0.0, 0.0], ..ElementFields::default() }
    }
}

impl Particle {
    /// Returns the stable step without pressure and motion [time].
    fn first_step(&self) -> f64 {
        self.0.stable_dt(self.0.sound_speed, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `W'` integrates to -1 over `4 pi r^3 / 3`: by parts, the kernel has the volume 1.
    #[test]
    fn the_kernel_has_the_volume_one() {
        let (h, n) = (0.7, 4000);
        let dr = 2.0 * h / n as f64;
        let term = |k: usize| {
            let r = (k as f64 + 0.5) * dr;
            slope_over_distance(r, h) * r.powi(4) * dr
        };
        let volume = -4.0 / 3.0 * PI * (0..n).map(term).sum::<f64>();
        assert!((volume - 1.0).abs() < 1e-6, "{volume}");
    }

    #[test]
    fn the_pressure_rises_with_the_square_of_the_speed_of_sound() {
        for hugoniot in [None, Some([1.9, 0.0, 0.0, 0.4, 0.0])] {
            check_speed_of_sound(hugoniot);
        }
    }

    fn check_speed_of_sound(hugoniot: Option<[f64; 5]>) {
        let job = ParticlesInput {
            spacing: 1.0,
            density: 2.0,
            sound_speed: 3.0,
            exponent: None,
            hugoniot,
            tension: 0.5,
            viscosity: [1.0, 2.0],
            smoothing: 1.2,
            contact_radius: None,
        };
        let fluid = Fluid::new(&job);
        let small = 1e-6;
        for density in [2.0, 2.2] {
            let slope = (fluid.pressure(density + small) - fluid.pressure(density)) / small;
            let exact = fluid.sound_speed(density).powi(2);
            assert!((slope / exact - 1.0).abs() < 1e-5, "{slope} {exact}");
        }
        assert_eq!(fluid.pressure(2.0), 0.0);
        assert_eq!(fluid.pressure(1.0), -0.5, "no more than the tension");
    }
}
