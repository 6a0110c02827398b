//! Return to the yield surface of polymers: one unknown x, the plastic multiplier over the flow
//! potential g. It divides the deviator of the trial by `1 + 3 G x` and the pressure by
//! `1 + K a x`, so that `q` and `p` after a step are known for each x, and `x q` is the increment
//! of the effective plastic strain.

use super::{COLUMNS, FlowRatio, Polymer, STEPS_OF_MEAN};
use crate::materials::Elastic;
use crate::materials::tensor::{deviator, inner, trace};

/// Least `a` of the potential: with n of 0.5 the pressure does not flow, except where no deviator
/// is on the surface.
const LEAST_DILATANCY: f64 = 1e-6;
/// First bound of `3 G x`, its growth, and the bound of its growth.
const FIRST_BOUND: f64 = 1e-6;
const GROWTH: f64 = 8.0;
const LAST_BOUND: f64 = 1e24;
/// Most steps of the method, and the change of x at which it ends.
const MOST_STEPS: usize = 80;
const CLOSE: f64 = 1e-14;

/// The history of a point.
#[derive(Clone, Copy, Debug)]
pub struct PolymerState {
    /// Effective plastic strain of the shape.
    pub strain: f64,
    /// Plastic strain that a tensile test would have.
    pub tension: f64,
    /// Its rate [1/time].
    pub rate: f64,
    pub damage: f64,
    pub failed: f64,
}

impl PolymerState {
    pub fn read(columns: &[f64]) -> Self {
        let [strain, tension, rate, damage, failed]: [f64; COLUMNS] =
            std::array::from_fn(|c| columns[c]);
        Self { strain, tension, rate, damage, failed }
    }

    pub fn write(&self, columns: &mut [f64]) {
        let &Self { strain, tension, rate, damage, failed } = self;
        columns.copy_from_slice(&[strain, tension, rate, damage, failed]);
    }

    /// Returns the part of the effective stress that a point has.
    pub fn intact(&self) -> f64 {
        1.0 - self.damage
    }
}

/// An elastic trial: its deviator and pressure [force/length^2], and the strain through the
/// thickness of a sheet.
#[derive(Clone, Copy)]
pub struct PolymerTrial {
    deviator: [f64; 6],
    pressure: f64,
    thickness: f64,
}

/// The trial stresses of an element, of which the factors on deviator and pressure after the flow
/// select one.
pub trait TrialStress {
    fn elastic(&self) -> &Elastic;
    /// Returns the trial for which these factors of deviator and pressure leave the stress that the
    /// element can have.
    fn at(&self, deviator: f64, pressure: f64) -> PolymerTrial;
}

/// A point of a solid: there is one trial.
pub struct OfSolid {
    elastic: Elastic,
    trial: PolymerTrial,
}

impl OfSolid {
    pub fn new(elastic: Elastic, old: [f64; 6], strain: [f64; 6]) -> Self {
        let tensor: [f64; 6] =
            std::array::from_fn(|c| if c < 3 { strain[c] } else { 0.5 * strain[c] });
        let (shape, old_shape) = (deviator(&tensor), deviator(&old));
        let two_g = 2.0 * elastic.shear_modulus();
        let trial = PolymerTrial {
            deviator: std::array::from_fn(|c| two_g.mul_add(shape[c], old_shape[c])),
            pressure: -trace(&old) / 3.0 - elastic.bulk_modulus() * trace(&tensor),
            thickness: 0.0,
        };
        Self { elastic, trial }
    }
}

impl TrialStress for OfSolid {
    fn elastic(&self) -> &Elastic {
        &self.elastic
    }
    fn at(&self, _: f64, _: f64) -> PolymerTrial {
        self.trial
    }
}

/// A point of a sheet: the strain through the thickness leaves no stress there.
pub struct OfSheet {
    pub elastic: Elastic,
    /// Effective stress before the step, in the order of solids.
    pub old: [f64; 6],
    /// Strain increment xx, yy, and twice xy.
    pub strain: [f64; 3],
}

impl TrialStress for OfSheet {
    fn elastic(&self) -> &Elastic {
        &self.elastic
    }
    fn at(&self, a: f64, b: f64) -> PolymerTrial {
        let [xx, yy, xy] = self.strain;
        let (g, k) = (self.elastic.shear_modulus(), self.elastic.bulk_modulus());
        let (old, pressure) = (deviator(&self.old), -trace(&self.old) / 3.0);
        let in_plane = xx + yy;
        let known = a * (old[2] - 2.0 / 3.0 * g * in_plane) - b * (pressure - k * in_plane);
        let thickness = -known / (4.0 / 3.0 * g * a + k * b);
        let third = (in_plane + thickness) / 3.0;
        let direct = |c: usize, strain: f64| (2.0 * g).mul_add(strain - third, old[c]);
        PolymerTrial {
            deviator: [
                direct(0, xx),
                direct(1, yy),
                direct(2, thickness),
                g.mul_add(xy, old[3]),
                0.0,
                0.0,
            ],
            pressure: pressure - 3.0 * k * third,
            thickness,
        }
    }
}

/// Result of a step of a point that has not failed.
pub struct PolymerFlow {
    /// Effective stress [force/length^2].
    pub stress: [f64; 6],
    /// Strain through the thickness of a sheet.
    pub thickness: f64,
    /// Norm of the deviator over that of the trial.
    pub kept: f64,
}

/// State of a step with one value of x.
struct TriedFlow {
    /// Distance from the surface, a stress squared; above 0 outside.
    beyond: f64,
    /// A0 of the surface.
    scale: f64,
    trial: PolymerTrial,
    /// Factors of deviator and pressure.
    factors: [f64; 2],
    /// Increment of the effective plastic strain.
    flow: f64,
    /// Rate of the plastic strain in tension after it [1/time].
    rate: f64,
}

/// Returns the square of the largest von Mises stress at a pressure, below 0 where there is none. A
/// surface with an apex has a mirror image beyond it, where nothing is elastic.
fn largest_square([a0, a1, a2]: [f64; 3], p: f64) -> f64 {
    /// Part of A1^2 by which the surface of a cone can miss its apex by round-off.
    const ROUND_OFF: f64 = 1e-9;
    let square = p.mul_add(a2.mul_add(p, a1), a0);
    if a2 <= 0.0 || a1 * a1 * (1.0 + ROUND_OFF) < 4.0 * a0 * a2 {
        return square;
    }
    let least = -0.5 * a1 / a2;
    let is_beyond = if least < 0.0 { p < least } else { p > least };
    if is_beyond { 2.0 * (a0 - 0.25 * a1 * a1 / a2) - square } else { square }
}

impl Polymer {
    /// Returns the coefficients A0, A1, A2 of the surface at these plastic strains and this rate.
    fn surface(&self, strain: f64, tension: f64, rate: f64) -> [f64; 3] {
        let t = self.tension.at(rate, tension)[0];
        let factor = match self.has_rates {
            true => t / self.tension.lowest().at(tension)[0],
            false => 1.0,
        };
        let c = self.compression.as_ref().map_or(t, |curve| factor * curve.at(tension)[0]);
        let s = match &self.shear {
            Some(curve) => factor * curve.at(0.5 * 3f64.sqrt() * strain)[0],
            None => 2.0 / 3f64.sqrt() * c * t / (c + t),
        };
        let product = c * t;
        let s = s.max(self.convexity * (product / 3.0).sqrt());
        let square = 3.0 * s * s;
        [square, 3.0 * square * (c - t) / product, 9.0 * (product - square) / product]
    }

    /// Returns the plastic Poisson's ratio at a plastic strain in tension.
    fn flow_ratio(&self, tension: f64) -> f64 {
        match &self.ratio {
            FlowRatio::Constant(ratio) => *ratio,
            FlowRatio::OverStrain(curve) => curve.at(tension)[0],
        }
    }

    /// Advances the effective stress over a step, and plastic strains and rate.
    pub fn flow(&self, space: &impl TrialStress, state: &mut PolymerState, dt: f64) -> PolymerFlow {
        let ratio = self.flow_ratio(state.tension);
        let per = 1.5 / (1.0 + ratio);
        let dilatancy = (4.5 * (1.0 - 2.0 * ratio) / (1.0 + ratio)).max(LEAST_DILATANCY);
        let three_g = 3.0 * space.elastic().shear_modulus();
        let bulk = space.elastic().bulk_modulus() * dilatancy / three_g;
        // y is 3 G x.
        let tried = |y: f64| -> TriedFlow {
            let [a, b] = [1.0 / (1.0 + y), 1.0 / (1.0 + bulk * y)];
            let trial = space.at(a, b);
            let q = a * (1.5 * inner(&trial.deviator, &trial.deviator)).sqrt();
            let p = b * trial.pressure;
            let flow = y * q / three_g;
            // In the same step, since a yield stress by the rate before it would oscillate.
            let rate = match self.has_rates && dt > 0.0 {
                true => state.rate + (per * flow / dt - state.rate) / STEPS_OF_MEAN,
                false => state.rate,
            };
            let surface = self.surface(state.strain + flow, state.tension + per * flow, rate);
            let beyond = q * q - largest_square(surface, p);
            TriedFlow { beyond, scale: surface[0], trial, factors: [a, b], flow, rate }
        };
        let mut end = tried(0.0);
        if end.beyond > 0.0 {
            end = root(tried, end.beyond);
        }
        let TriedFlow { trial, factors: [a, b], flow, rate, .. } = end;
        state.strain += flow;
        state.tension += per * flow;
        state.rate = rate;
        let pressure = b * trial.pressure;
        let stress =
            std::array::from_fn(|c| a * trial.deviator[c] - if c < 3 { pressure } else { 0.0 });
        PolymerFlow { stress, thickness: trial.thickness, kept: a }
    }
}

/// Returns the flow that ends on the surface, from `beyond` the surface without flow: bounds that
/// grow, then the Illinois method (Dowell & Jarratt 1971).
fn root(tried: impl Fn(f64) -> TriedFlow, beyond: f64) -> TriedFlow {
    let (mut low, mut of_low) = (0.0, beyond);
    let mut high = FIRST_BOUND;
    let mut end = tried(high);
    while end.beyond > 0.0 && high < LAST_BOUND {
        (low, of_low) = (high, end.beyond);
        high *= GROWTH;
        end = tried(high);
    }
    let mut of_high = end.beyond;
    let mut last_low = None;
    for _ in 0..MOST_STEPS {
        if end.beyond.abs() <= CLOSE * end.scale || high - low <= CLOSE * high {
            break;
        }
        let y = high - of_high * (high - low) / (of_high - of_low);
        let y = if y > low && y < high { y } else { 0.5 * (low + high) };
        end = tried(y);
        let is_low = end.beyond > 0.0;
        if is_low {
            (low, of_low) = (y, end.beyond);
        } else {
            (high, of_high) = (y, end.beyond);
        }
        if last_low == Some(is_low) {
            if is_low { of_high *= 0.5 } else { of_low *= 0.5 }
        }
        last_low = Some(is_low);
    }
    end
}
