//! The ideal gas in an airbag: sources, vents and expansion (Wang & Nefske, SAE 880654).
//!
//! With the mass m, the internal energy U = m cv T and the volume V, `p V = (g - 1) U`, g = cp/cv:
//!
//! `dm/dt = sum of m_in - sum of m_out`
//! `dU/dt = sum of m_in cp T_in - sum of m_out cp T - p dV/dt`
//!
//! An orifice of area A and discharge coefficient C passes, with R = cp - cv and the pressure
//! ratio Q = p_out/p, which counts as at least (2/(g+1))^(g/(g-1)), where the flow is choked:
//!
//! `m_out = C A p/sqrt(R T) sqrt(2 g/(g-1) (Q^(2/g) - Q^((g+1)/g)))`
//!
//! Expansion uses the mean of the pressures before and after, as the ledger does for forces. So
//! the gas loses the energy that the surface gets, except for terms of third order in the step.

use crate::curve::Curve;
use crumple_proto::airbag::{GasInflow, GasLaw, GasVent, VentFlow};
use serde::{Deserialize, Serialize};

/// Largest part of the mass that a part of a step exchanges.
const PART: f64 = 0.02;
/// Largest number of parts of a step.
const MOST_PARTS: f64 = 1000.0;

/// State of a gas.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gas {
    /// Mass [mass].
    pub mass: f64,
    /// Internal energy [energy].
    pub energy: f64,
    /// Mass that has come in and that has left [mass].
    pub exchanged: [f64; 2],
    /// Enthalpy that has come in and that has left [energy].
    pub enthalpy: [f64; 2],
    /// For each vent, true once it is open.
    pub open: Vec<bool>,
}

/// Mass and enthalpy, or their rates.
#[derive(Clone, Copy, Debug, Default)]
struct GasFlow {
    mass: f64,
    enthalpy: f64,
}

/// Law of a gas with its curves.
#[derive(Debug)]
pub struct GasModel {
    law: GasLaw,
    ambient: f64,
    sources: Vec<[Curve; 2]>,
    /// Per vent: area over absolute pressure and coefficient over time, or rate over gauge
    /// pressure.
    vents: Vec<VentModel>,
}

#[derive(Debug)]
enum VentModel {
    Orifice { area: Curve, coefficient: f64, factor: Curve },
    Rate(Curve),
}

impl GasModel {
    /// Builds the model from its law. `curves` are those of the loads.
    pub fn new(law: &GasLaw, ambient: f64, curves: &[Vec<[f64; 2]>]) -> Self {
        let curve =
            |index: Option<usize>| index.map_or_else(Curve::one, |c| Curve::new(&curves[c]));
        let source = |s: &GasInflow| [curve(s.curve), curve(s.temperature_curve)];
        let vent = |v: &GasVent| match &v.flow {
            VentFlow::Orifice { area, coefficient, curve: factor } => VentModel::Orifice {
                area: Curve::new(area),
                coefficient: *coefficient,
                factor: curve(*factor),
            },
            VentFlow::Rate { points } => VentModel::Rate(Curve::new(points)),
        };
        Self {
            law: law.clone(),
            ambient,
            sources: law.inflows.iter().map(source).collect(),
            vents: law.vents.iter().map(vent).collect(),
        }
    }

    /// Returns the ratio of the heat capacities.
    pub fn exponent(&self) -> f64 {
        self.law.cp / self.law.cv
    }

    /// Returns the absolute pressure at the start [force/length^2].
    pub fn start_pressure(&self) -> f64 {
        self.law.pressure
    }

    /// Returns the gas at the start in a volume [length^3].
    pub fn start(&self, volume: f64) -> Gas {
        let GasLaw { cv, cp, pressure, temperature, .. } = self.law;
        Gas {
            mass: pressure * volume / ((cp - cv) * temperature),
            energy: pressure * volume / (self.exponent() - 1.0),
            open: vec![false; self.vents.len()],
            ..Gas::default()
        }
    }

    /// Returns the pressure in a volume [force/length^2].
    pub fn pressure(&self, gas: &Gas, volume: f64) -> f64 {
        (self.exponent() - 1.0) * gas.energy / volume
    }

    /// Returns the temperature; 0 without any gas [temperature].
    pub fn temperature(&self, gas: &Gas) -> f64 {
        if gas.mass > 0.0 { gas.energy / (gas.mass * self.law.cv) } else { 0.0 }
    }

    /// Lets gas in and out from `time` to `time + dt` in a constant volume.
    ///
    /// # Errors
    /// More gas leaves in a part of the step than there is.
    pub fn exchange(
        &self,
        gas: &mut Gas,
        volume: f64,
        time: f64,
        dt: f64,
    ) -> Result<(), &'static str> {
        let gauge = self.pressure(gas, volume) - self.ambient;
        for (open, vent) in gas.open.iter_mut().zip(&self.law.vents) {
            *open |= gauge >= vent.opening_pressure;
        }
        let source = self.sources(time, dt);
        let leaving = self.outflow(gas, volume, time).mass * dt;
        let parts = (source.mass.max(leaving) / (PART * gas.mass)).ceil();
        let parts = if parts >= 1.0 { parts.min(MOST_PARTS) } else { 1.0 };
        let h = dt / parts;
        let [mass_in, enthalpy_in] = [source.mass, source.enthalpy].map(|all| all / parts);
        for part in 0..parts as usize {
            // The midpoint rule.
            let at = time + part as f64 * h;
            let first = self.outflow(gas, volume, at);
            let mut middle = gas.clone();
            middle.mass += 0.5 * (mass_in - h * first.mass);
            middle.energy += 0.5 * (enthalpy_in - h * first.enthalpy);
            let out = self.outflow(&middle, volume, at + 0.5 * h);
            let (mass_out, enthalpy_out) = (h * out.mass, h * out.enthalpy);
            gas.mass += mass_in - mass_out;
            gas.energy += enthalpy_in - enthalpy_out;
            if !(middle.mass >= 0.0 && gas.mass >= 0.0 && gas.energy >= 0.0) {
                return Err("more gas leaves in a step than it has. Correct its vents and units");
            }
            gas.exchanged[1] += mass_out;
            gas.enthalpy[1] += enthalpy_out;
        }
        gas.exchanged[0] += source.mass;
        gas.enthalpy[0] += source.enthalpy;
        Ok(())
    }

    /// Changes the volume, from one where the pressure on the surface is `pressure`. Returns the
    /// work of the gas.
    ///
    /// # Errors
    /// The volume changes too much for one step.
    pub fn expand(
        &self,
        gas: &mut Gas,
        pressure: f64,
        [from, to]: [f64; 2],
    ) -> Result<f64, &'static str> {
        let half = 0.5 * (to - from);
        let share = 1.0 + half * (self.exponent() - 1.0) / to;
        let energy = (gas.energy - pressure * half) / share;
        if !(share > 0.0 && energy >= 0.0) {
            return Err("its volume changes too much in one step. Reduce `time.safety`, or give \
                        it an `added_volume`");
        }
        Ok(std::mem::replace(&mut gas.energy, energy) - energy)
    }

    /// Returns the mass and enthalpy that the sources add from `time` to `time + dt`.
    fn sources(&self, time: f64, dt: f64) -> GasFlow {
        let mut sum = GasFlow::default();
        for (source, [rate, temperature]) in self.law.inflows.iter().zip(&self.sources) {
            let mass = source.rate * (rate.integral(time + dt) - rate.integral(time));
            let heat = self.law.cp * source.temperature * temperature.value(time + 0.5 * dt);
            sum = GasFlow { mass: sum.mass + mass, enthalpy: sum.enthalpy + mass * heat };
        }
        sum
    }

    /// Returns the rates at which gas leaves.
    fn outflow(&self, gas: &Gas, volume: f64, time: f64) -> GasFlow {
        let (pressure, temperature) = (self.pressure(gas, volume), self.temperature(gas));
        if temperature <= 0.0 || pressure <= self.ambient {
            return GasFlow::default();
        }
        let open = self.vents.iter().zip(&gas.open).filter(|(_, open)| **open);
        let mass = open.map(|(vent, _)| match vent {
            VentModel::Orifice { area, coefficient, factor } => {
                let area = coefficient * factor.value(time) * area.value(pressure);
                area * self.flux(pressure, temperature)
            }
            VentModel::Rate(rate) => rate.value(pressure - self.ambient),
        });
        let mass = mass.sum::<f64>();
        GasFlow { mass, enthalpy: mass * self.law.cp * temperature }
    }

    /// Returns the flow through an orifice per area, from a pressure above the ambient one
    /// [mass/(length^2 time)].
    fn flux(&self, pressure: f64, temperature: f64) -> f64 {
        let g = self.exponent();
        let choked = (2.0 / (g + 1.0)).powf(g / (g - 1.0));
        let ratio = (self.ambient / pressure).max(choked);
        let speed = 2.0 * g / (g - 1.0) * (ratio.powf(2.0 / g) - ratio.powf((g + 1.0) / g));
        pressure / ((self.law.cp - self.law.cv) * temperature).sqrt() * speed.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CV: f64 = 0.718;
    const CP: f64 = 1.005;

    fn law(pressure: f64) -> GasLaw {
        let (inflows, vents) = (Vec::new(), Vec::new());
        GasLaw { cv: CV, cp: CP, pressure, temperature: 300.0, inflows, vents }
    }

    fn vent(area: f64, opening_pressure: f64) -> GasVent {
        let flow = VentFlow::Orifice { area: vec![[0.0, area]], coefficient: 0.5, curve: None };
        GasVent { flow, opening_pressure }
    }

    /// Gas that fills an evacuated tank of constant volume at T_in has the temperature g T_in:
    /// its enthalpy becomes internal energy.
    #[test]
    fn filling_an_empty_tank_heats_the_gas_by_the_ratio_of_heat_capacities() {
        let inflow =
            GasInflow { rate: 2.0, curve: None, temperature: 400.0, temperature_curve: None };
        let model = GasModel::new(&GasLaw { inflows: vec![inflow], ..law(0.0) }, 0.0, &[]);
        let mut gas = model.start(3.0);
        (0..50).for_each(|i| model.exchange(&mut gas, 3.0, 0.1 * f64::from(i), 0.1).unwrap());
        assert!((model.temperature(&gas) / (400.0 * CP / CV) - 1.0).abs() < 1e-12);
        assert!((gas.mass - 10.0).abs() < 1e-11 && (gas.exchanged[0] - 10.0).abs() < 1e-11);
        let pressure = 10.0 * (CP - CV) * 400.0 * CP / CV / 3.0;
        assert!((model.pressure(&gas, 3.0) / pressure - 1.0).abs() < 1e-12);
    }

    /// p V^g is constant, with an error of second order in the step.
    #[test]
    fn a_closed_gas_follows_the_isentrope() {
        let errors = [50, 100].map(|steps| {
            let model = GasModel::new(&law(2.0), 0.0, &[]);
            let (mut gas, mut work) = (model.start(4.0), 0.0);
            let volume = |i: i32| 4.0 - 2.5 * f64::from(i) / f64::from(steps);
            for i in 0..steps {
                let pressure = model.pressure(&gas, volume(i));
                work += model.expand(&mut gas, pressure, [volume(i), volume(i + 1)]).unwrap();
            }
            assert!((gas.energy + work - 8.0 / (CP / CV - 1.0)).abs() < 1e-10);
            model.pressure(&gas, 1.5) / (2.0 * (4.0f64 / 1.5).powf(CP / CV)) - 1.0
        });
        assert!(errors[1].abs() < 2e-4, "{errors:?}");
        assert!((errors[0] / errors[1] - 4.0).abs() < 0.1, "second order: {errors:?}");
    }

    /// Choked flow has the mass rate C A p sqrt(g/(R T)) (2/(g+1))^((g+1)/(2(g-1))). Subsonic flow
    /// has density times velocity at the Mach number M in the orifice, where temperature and
    /// pressure are below those of the gas at rest by k = 1 + (g-1)/2 M^2 and k^(g/(g-1)). A small
    /// difference of pressure gives C A sqrt(2 rho dp).
    #[test]
    fn an_orifice_passes_what_its_closed_forms_say() {
        let (g, r) = (CP / CV, CP - CV);
        let model = GasModel::new(&law(5.0), 1.0, &[]);
        let choked =
            5.0 * (g / (r * 300.0)).sqrt() * (2.0 / (g + 1.0)).powf((g + 1.0) / (2.0 * (g - 1.0)));
        assert!((model.flux(5.0, 300.0) / choked - 1.0).abs() < 1e-12);
        for mach in [0.1, 0.5, 0.9, 1.0f64] {
            let colder = 1.0 + 0.5 * (g - 1.0) * mach * mach;
            let pressure = colder.powf(g / (g - 1.0));
            let density = 1.0 / (r * 300.0 / colder);
            let exact = density * mach * (g * r * 300.0 / colder).sqrt();
            assert!((model.flux(pressure, 300.0) / exact - 1.0).abs() < 1e-12, "{mach}");
        }
        let density = 1.001 / (r * 300.0);
        let slow = (2.0 * density * 0.001f64).sqrt();
        assert!(
            (model.flux(1.001, 300.0) / slow - 1.0).abs() < 2e-3,
            "{}",
            model.flux(1.001, 300.0)
        );
    }

    /// A tank that empties through a choked orifice follows the isentrope of its density,
    /// p = p0 (1 + (g-1)/2 t/tau)^(-2g/(g-1)) with tau = m0 / (flow at the start).
    #[test]
    fn a_tank_empties_through_a_choked_orifice_as_the_closed_form_says() {
        let g = CP / CV;
        let model = GasModel::new(&GasLaw { vents: vec![vent(0.2, 0.0)], ..law(50.0) }, 1.0, &[]);
        let mut gas = model.start(1.0);
        gas.open = vec![true];
        let tau = gas.mass / model.outflow(&gas, 1.0, 0.0).mass;
        let energy = gas.energy;
        (0..100).for_each(|i| {
            model.exchange(&mut gas, 1.0, 0.01 * tau * f64::from(i), 0.01 * tau).unwrap()
        });
        let exact = 50.0 * (1.0 + 0.5 * (g - 1.0)).powf(-2.0 * g / (g - 1.0));
        assert!(exact > 2.0, "still choked: {exact}");
        let error = model.pressure(&gas, 1.0) / exact - 1.0;
        assert!(error.abs() < 1e-4, "second order, 1% of the mass per step: {error}");
        assert!((gas.energy + gas.enthalpy[1] - energy).abs() < 1e-10 * energy);
    }

    /// A vent opens at its pressure and stays open; nothing flows in through it.
    #[test]
    fn a_vent_opens_once_and_no_gas_flows_back() {
        let law = GasLaw { vents: vec![vent(0.2, 3.0)], ..law(3.0) };
        let model = GasModel::new(&law, 1.0, &[]);
        let mut gas = model.start(1.0);
        model.exchange(&mut gas, 1.0, 0.0, 1.0).unwrap();
        assert_eq!((gas.exchanged[1], gas.open[0]), (0.0, false), "a gauge pressure of 2");
        model.exchange(&mut gas, 0.5, 1.0, 1e-3).unwrap();
        assert!(gas.exchanged[1] > 0.0 && gas.open[0], "a gauge pressure of 5");
        (0..2000).for_each(|i| model.exchange(&mut gas, 1.0, f64::from(i), 1.0).unwrap());
        let pressure = model.pressure(&gas, 1.0);
        assert!((pressure - 1.0).abs() < 1e-2, "the ambient pressure: {pressure}");
        let left = gas.mass;
        model.exchange(&mut gas, 2.0, 0.0, 1.0).unwrap();
        assert_eq!(gas.mass, left, "below the ambient pressure");
    }

    /// A vent that would empty the gas within a part of a step, and a volume that falls to a
    /// hundredth in one step, are errors.
    #[test]
    fn a_gas_that_a_step_would_use_up_is_an_error() {
        let rate =
            GasVent { flow: VentFlow::Rate { points: vec![[0.0, 1e9]] }, opening_pressure: 0.0 };
        let model = GasModel::new(&GasLaw { vents: vec![rate], ..law(50.0) }, 1.0, &[]);
        let mut gas = model.start(1.0);
        let lost = model.exchange(&mut gas, 1.0, 0.0, 1.0).unwrap_err();
        assert!(lost.starts_with("more gas leaves"), "{lost}");
        let closed = GasModel::new(&law(50.0), 1.0, &[]);
        let mut gas = closed.start(1.0);
        let fallen = closed.expand(&mut gas, 50.0, [1.0, 0.01]).unwrap_err();
        assert!(fallen.starts_with("its volume changes too much"), "{fallen}");
    }
}
