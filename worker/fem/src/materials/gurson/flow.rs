//! Return of a stress to the surface of metals with voids.
//!
//! First by the cutting-plane method (Simo & Hughes 1998, sec. 3.6.2), which always ends. Its flow
//! has the direction at the start of its steps. Then the direction is that at the end, for the
//! closest point, found by iteration. If that does not converge, as in some steps of many times the
//! strain at yield, the first result is kept.

use super::super::hardening::Hardening;
use super::surface::{Equivalent, VoidSurface};

/// Steps of Newton's method; three to six are enough.
const STEPS: usize = 40;
/// Distance from the surface, as a fraction of the yield stress, that ends them.
const TOLERANCE: f64 = 1e-12;
/// Most directions of flow; two to four are enough for a step of an element.
const DIRECTIONS: usize = 40;
/// Largest change of the stress over that of the iteration before.
const LEAST_GAIN: f64 = 0.9;
/// Change of the stress, as a fraction of the yield stress, below which the direction is found.
const SAME_DIRECTION: f64 = 1e-10;

/// Result of a return.
pub struct VoidFlow {
    /// Stress on the surface, in the components of its space [force/length^2].
    pub stress: [f64; 3],
    /// Multiplier, `(1 - f) de`.
    pub multiplier: f64,
    /// Plastic volume strain.
    pub volume: f64,
    /// Plastic strain through the thickness of a sheet.
    pub thickness: f64,
}

/// Components of a stress in which it returns to the surface.
pub trait StressSpace {
    /// Returns von Mises stress and mean stress.
    fn invariants(&self, stress: [f64; 3]) -> [f64; 2];
    /// Returns the gradient of the equivalent stress, and its component through a sheet.
    fn direction(&self, stress: [f64; 3], gradient: Equivalent) -> ([f64; 3], f64);
    /// Returns the change of the stress by an elastic strain.
    fn stress_of(&self, strain: [f64; 3]) -> [f64; 3];
}

/// Stress of a solid: von Mises stress and mean stress; the deviator keeps its direction.
pub struct SolidSpace {
    /// Three times the shear modulus [force/length^2].
    pub three_g: f64,
    /// Bulk modulus [force/length^2].
    pub bulk: f64,
}

impl StressSpace for SolidSpace {
    fn invariants(&self, [mises, mean, _]: [f64; 3]) -> [f64; 2] {
        [mises.max(0.0), mean]
    }
    fn direction(&self, _stress: [f64; 3], gradient: Equivalent) -> ([f64; 3], f64) {
        ([gradient.of_mises, gradient.of_mean, 0.0], 0.0)
    }
    fn stress_of(&self, [mises, mean, _]: [f64; 3]) -> [f64; 3] {
        [self.three_g * mises, self.bulk * mean, 0.0]
    }
}

/// Stress of a sheet: xx, yy, xy. Strains have twice the component xy.
pub struct PlaneSpace {
    /// c11, c12, G [force/length^2].
    pub elastic: [f64; 3],
}

impl StressSpace for PlaneSpace {
    fn invariants(&self, [x, y, xy]: [f64; 3]) -> [f64; 2] {
        [(x * x - x * y + y * y + 3.0 * xy * xy).sqrt(), (x + y) / 3.0]
    }
    fn direction(&self, stress: [f64; 3], gradient: Equivalent) -> ([f64; 3], f64) {
        let [x, y, xy] = stress;
        let [mises, _] = self.invariants(stress);
        let of_mises = if mises > 0.0 { 0.5 * gradient.of_mises / mises } else { 0.0 };
        let third = gradient.of_mean / 3.0;
        let [along_x, along_y] = [2.0 * x - y, 2.0 * y - x].map(|s| of_mises * s + third);
        ([along_x, along_y, 6.0 * of_mises * xy], third - of_mises * (x + y))
    }
    fn stress_of(&self, [x, y, xy]: [f64; 3]) -> [f64; 3] {
        let [c11, c12, g] = self.elastic;
        [c11 * x + c12 * y, c11 * y + c12 * x, g * xy]
    }
}

/// A point on the surface.
pub struct Yielding<'a> {
    /// The surface.
    pub surface: &'a VoidSurface,
    /// See [`VoidSurface::weakening`].
    pub weakening: f64,
    /// Yield stress of the matrix.
    pub hardening: &'a Hardening,
    /// Plastic strain of the matrix at the start.
    pub strain: f64,
    /// Share of the matrix in the volume.
    pub matrix: f64,
}

fn product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Yielding<'_> {
    /// Returns the flow of a trial stress outside of the surface.
    pub fn flow(&self, space: &impl StressSpace, trial: [f64; 3]) -> VoidFlow {
        let first = self.cutting_planes(space, trial);
        let limit = self.hardening.at(self.strain)[0];
        let same = SAME_DIRECTION * limit;
        // The end moves against its change by the flow times the curvature of the surface, about
        // the excess of the trial over the yield stress.
        let share = (limit / self.equivalent(space, trial).stress).min(1.0);
        let (mut before, mut size) = (first.stress, f64::INFINITY);
        for _ in 0..DIRECTIONS {
            let Some(flow) = self.along(space, trial, before, first.multiplier) else { break };
            let change = (0..3).map(|k| (flow.stress[k] - before[k]).abs()).fold(0.0, f64::max);
            if change <= same {
                return flow;
            }
            if change > LEAST_GAIN * size {
                break;
            }
            (0..3).for_each(|k| before[k] += share * (flow.stress[k] - before[k]));
            size = change;
        }
        first
    }

    fn equivalent(&self, space: &impl StressSpace, stress: [f64; 3]) -> Equivalent {
        self.surface.equivalent(space.invariants(stress), self.weakening)
    }

    /// Returns the excess over the yield stress, the yield stress, and the modulus of hardening
    /// after a flow.
    fn excess(&self, equivalent: f64, multiplier: f64) -> [f64; 3] {
        let [limit, slope] = self.hardening.at(self.strain + multiplier / self.matrix);
        [equivalent - limit, limit, slope / self.matrix]
    }

    /// Returns the flow by the cutting-plane method. If it does not reach the surface, all stress
    /// is reduced to it in proportion: the equivalent stress is homogeneous.
    fn cutting_planes(&self, space: &impl StressSpace, trial: [f64; 3]) -> VoidFlow {
        let mut flow = VoidFlow { stress: trial, multiplier: 0.0, volume: 0.0, thickness: 0.0 };
        for step in 0..=STEPS {
            let now = self.equivalent(space, flow.stress);
            let [off, limit, modulus] = self.excess(now.stress, flow.multiplier);
            if off.abs() <= TOLERANCE * limit {
                break;
            }
            if step == STEPS {
                let kept = (limit / now.stress).min(1.0);
                flow.stress = flow.stress.map(|s| s * kept);
                break;
            }
            let (direction, through) = space.direction(flow.stress, now);
            let along = space.stress_of(direction);
            let multiplier = off / (product(direction, along) + modulus);
            (0..3).for_each(|k| flow.stress[k] -= multiplier * along[k]);
            flow.multiplier += multiplier;
            flow.volume += now.of_mean * multiplier;
            flow.thickness += through * multiplier;
        }
        flow
    }

    /// Returns the flow along the gradient at the stress `end`, by Newton's method from a
    /// multiplier; nothing if the surface is not met.
    fn along(
        &self,
        space: &impl StressSpace,
        trial: [f64; 3],
        end: [f64; 3],
        mut multiplier: f64,
    ) -> Option<VoidFlow> {
        let gradient = self.equivalent(space, end);
        let (direction, through) = space.direction(end, gradient);
        let along = space.stress_of(direction);
        for _ in 0..STEPS {
            let stress = std::array::from_fn(|k| trial[k] - multiplier * along[k]);
            let now = self.equivalent(space, stress);
            let [off, limit, modulus] = self.excess(now.stress, multiplier);
            if off.abs() <= TOLERANCE * limit {
                return Some(VoidFlow {
                    stress,
                    multiplier,
                    volume: gradient.of_mean * multiplier,
                    thickness: through * multiplier,
                });
            }
            let slope = product(space.direction(stress, now).0, along) + modulus;
            multiplier += off / slope;
            if !(slope > 0.0 && multiplier >= 0.0) {
                return None;
            }
        }
        None
    }
}
