//! Pressure of a fluid without shocks and heat, as a function of its density alone: the isentrope
//! of an equation of state through the state at the start. Particles have it, whose internal
//! energies have a meaning only as a sum.
//!
//! With `mu = rho/rho_0 - 1` and the energy E per volume at the start,
//! `dE/dmu = p(mu, E)/(1+mu)^2`. This equation is integrated once, by Runge and Kutta's rule of
//! fourth order, and E is interpolated between its nodes by cubics with the slopes there. Without
//! Gruneisen's coefficient the pressure is that of the equation, exactly.

use super::equation_of_state::Equation;

/// Distance of the nodes in mu.
const STEP: f64 = 1.0 / 256.0;
/// Range of the nodes, from expansion to compression. Beyond it the energy is that of its end.
const RANGE: [f64; 2] = [-0.5, 1.5];

/// Least slope over the bulk modulus: the speed of sound of a spray is a tenth of that of the
/// fluid.
const LEAST_SLOPE: f64 = 0.01;

/// The isentrope of an equation.
#[derive(Clone, Debug)]
pub struct Isentrope {
    equation: Equation,
    /// Energies at the nodes from [`RANGE`] on, and their slopes [force/length^2].
    nodes: Vec<[f64; 2]>,
    /// mu of the first node.
    first: f64,
}

/// A state of the isentrope.
pub struct IsentropeState {
    /// Pressure [force/length^2].
    pub pressure: f64,
    /// Its derivative by mu [force/length^2].
    pub slope: f64,
}

impl Isentrope {
    /// Integrates an equation.
    pub fn new(equation: Equation) -> Self {
        let slope = |mu: f64, e: f64| equation.pressure(mu, e)[0] / ((1.0 + mu) * (1.0 + mu));
        let side = |end: f64| {
            let h = STEP.copysign(end);
            let mut all = Vec::new();
            let mut e = 0.0;
            for k in 1..=(end.abs() / STEP) as usize {
                let mu = h * (k - 1) as f64;
                let k1 = slope(mu, e);
                let k2 = slope(mu + 0.5 * h, e + 0.5 * h * k1);
                let k3 = slope(mu + 0.5 * h, e + 0.5 * h * k2);
                let k4 = slope(mu + h, e + h * k3);
                e += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                let at_node = [e, slope(mu + h, e)];
                if at_node.iter().any(|x| !x.is_finite()) {
                    break;
                }
                all.push(at_node);
            }
            all
        };
        let mut nodes = side(RANGE[0]);
        nodes.reverse();
        let first = -STEP * nodes.len() as f64;
        nodes.push([0.0, slope(0.0, 0.0)]);
        nodes.extend(side(RANGE[1]));
        Self { equation, nodes, first }
    }

    /// Returns the state at `mu`.
    pub fn at(&self, mu: f64) -> IsentropeState {
        let energy = self.energy(mu);
        let [pressure, d_mu, d_energy] = self.equation.pressure(mu, energy);
        let last = self.first + STEP * (self.nodes.len() - 1) as f64;
        let of_energy = if (self.first..=last).contains(&mu) {
            d_energy * pressure / ((1.0 + mu) * (1.0 + mu))
        } else {
            0.0
        };
        // Far in expansion a fluid without tension has no pressure and no stiffness of its own.
        let least = LEAST_SLOPE * self.equation.bulk_modulus();
        IsentropeState { pressure, slope: (d_mu + of_energy).max(least) }
    }

    fn energy(&self, mu: f64) -> f64 {
        let place = ((mu - self.first) / STEP).clamp(0.0, (self.nodes.len() - 1) as f64);
        let Some(last) = self.nodes.len().checked_sub(2) else { return 0.0 };
        let low = (place as usize).min(last);
        let [[e0, s0], [e1, s1]] = [self.nodes[low], self.nodes[low + 1]];
        let t = place - low as f64;
        let (rest, [s0, s1]) = (1.0 - t, [s0 * STEP, s1 * STEP]);
        // The cubic through both values with both slopes.
        rest * rest * ((1.0 + 2.0 * t) * e0 + t * s0) + t * t * ((3.0 - 2.0 * t) * e1 - rest * s1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DENSITY: f64 = 1e-6;
    const C: f64 = 1480.0;

    /// Without Gruneisen's coefficient it is the Hugoniot of the equation.
    #[test]
    fn a_cold_fluid_has_the_pressure_of_its_equation() {
        let s = 2.48;
        let water = Isentrope::new(Equation::gruneisen(DENSITY, C, [s, 0.0, 0.0, 0.0, 0.0]));
        for mu in [-0.3, -0.01, 0.0, 1e-4, 0.1, 0.4] {
            let bulk = DENSITY * C * C;
            let d = 1.0 - (s - 1.0) * mu;
            let exact = bulk * if mu > 0.0 { mu * (1.0 + mu) / (d * d) } else { mu };
            let got = water.at(mu).pressure;
            assert!((got - exact).abs() < 1e-14 * bulk, "{mu}: {got} for {exact}");
        }
    }

    /// Against the same equation by small steps of a rule of second order, whose error is below the
    /// bound; the slope against a difference of pressures, with an error of 1e-7.
    #[test]
    fn energy_is_the_work_of_the_pressure() {
        let constants = [1.97, 0.0, 0.0, 0.5, 0.1];
        let equation = Equation::gruneisen(DENSITY, C, constants);
        let water = Isentrope::new(equation.clone());
        for end in [-0.2, 0.3] {
            let (n, mut e) = (400_000, 0.0);
            let h = end / n as f64;
            for k in 0..n {
                // Midpoint rule.
                let mu = h * k as f64;
                let slope = |mu: f64, e: f64| equation.pressure(mu, e)[0] / (1.0 + mu).powi(2);
                let half = e + 0.5 * h * slope(mu, e);
                e += h * slope(mu + 0.5 * h, half);
            }
            let exact = equation.pressure(end, e)[0];
            let got = water.at(end);
            assert!((got.pressure / exact - 1.0).abs() < 1e-9, "{end}: {} {exact}", got.pressure);
            let small = 1e-6;
            let slope = (water.at(end + small).pressure - water.at(end - small).pressure) / 2e-6;
            assert!((got.slope / slope - 1.0).abs() < 1e-6, "{end}: {} {slope}", got.slope);
        }
    }

    /// The speed of sound exists at any density.
    #[test]
    fn the_slope_is_above_zero() {
        for gamma in [0.0, 0.5, 1.0, 2.0] {
            let water =
                Isentrope::new(Equation::gruneisen(DENSITY, C, [1.9, 0.0, 0.0, gamma, 0.0]));
            for k in -99..100 {
                let slope = water.at(0.01 * f64::from(k)).slope;
                assert!(slope > 0.0 && slope.is_finite(), "{gamma} {k}: {slope}");
            }
        }
    }

    /// Compression beyond the pole of the Hugoniot has no finite pressure.
    #[test]
    fn beyond_the_pole_there_is_no_pressure() {
        let water = Isentrope::new(Equation::gruneisen(DENSITY, C, [2.48, 0.0, 0.0, 0.5, 0.0]));
        assert!(water.at(0.6).pressure.is_finite());
        assert!(!water.at(0.7).pressure.is_finite());
    }
}
