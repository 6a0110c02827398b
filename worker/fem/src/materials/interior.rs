//! Contact inside of solids, which keeps crushed elements from turning inside out: a pressure that
//! is added to that of any law where the volume is below a fraction a of that at the start.
//! ```text
//! p = M/2 ((a V_0/V)^2 - 1)
//! ```
//! with M the modulus of longitudinal waves of the law times a factor. Its work is unbounded as V
//! approaches zero. The modulus grows by `M (a V_0/V)^2`, so the element takes a shorter step.
//!
//! It acts on the volume: a body that is pressed flat and gives way to the sides is not held.

use super::Solid;
use super::wrapped::{self, LawModifier, PointColumns};
use crumple_math::lanes::Real;
use std::convert::Infallible;

/// Column of laws that keep the logarithm of the volume.
const OF_LAW: &str = "volume strain";

struct Interior {
    /// Logarithm of the fraction a.
    start: f64,
    /// M [force/length^2].
    modulus: f64,
    /// Factor on the modulus of the law.
    factor: f64,
    /// Columns: logarithm of the volume, added pressure, stiffening; failure, if the law can fail.
    volume: usize,
    pressure: usize,
    stiffening: usize,
    failed: Option<usize>,
    /// True if the law advances the volume.
    is_of_law: bool,
    /// True if the law gives a stiffening.
    stiffens: bool,
}

/// Adds the pressure to a law, below this fraction of the volume and with this factor.
pub fn with_interior_contact(law: Box<dyn Solid>, [fraction, factor]: [f64; 2]) -> Box<dyn Solid> {
    let elastic = law.elastic();
    let modulus = factor * (elastic.lame() + 2.0 * elastic.shear_modulus());
    let modifier = |columns: &mut PointColumns| -> Result<_, Infallible> {
        let of_law = columns.find(OF_LAW);
        let stiffens = columns.find("stiffening").is_some();
        Ok(Interior {
            start: fraction.ln(),
            modulus,
            factor,
            volume: of_law.unwrap_or_else(|| columns.add("interior volume strain")),
            pressure: columns.add("interior pressure"),
            stiffening: columns.add("stiffening"),
            failed: columns.find("failed"),
            is_of_law: of_law.is_some(),
            stiffens,
        })
    };
    match wrapped::solid(law, modifier) {
        Ok(law) => law,
    }
}

impl LawModifier for Interior {
    #[inline(always)]
    fn update<R: Real>(&self, state: &mut [R], strain: &[R], law: impl FnOnce(&mut [R]) -> R) -> R {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let before = state[self.pressure];
        (0..3).for_each(|c| state[c] += before);
        let left = law(state);
        if !self.is_of_law {
            state[self.volume] += strain[0] + strain[1] + strain[2];
        }
        let below = R::splat(self.start) - state[self.volume];
        let mut acts = below.gt(zero);
        if let Some(failed) = self.failed {
            acts = R::both(acts, state[failed].lt(R::splat(0.5)));
        }
        let of_law = if self.stiffens { state[self.stiffening] } else { zero };
        let (mut pressure, mut stiffer) = (zero, zero);
        if R::any(acts) {
            let below = R::select(acts, below, zero);
            let square = (below + below).exp();
            pressure = R::select(acts, R::splat(0.5 * self.modulus) * (square - one), zero);
            stiffer = R::select(acts, R::splat(self.factor) * square, zero);
        }
        state[self.pressure] = pressure;
        state[self.stiffening] = of_law + stiffer;
        (0..3).for_each(|c| state[c] -= pressure);
        left
    }

    fn averages_volume(&self, _of_law: bool) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::with_interior_contact;
    use crate::materials::testing::{Cube, material, table};
    use crumple_proto::partition::Material;

    /// Returns a cube of this law with a fraction of 0.2 and a factor of 0.5.
    fn cube(material: &Material) -> Cube {
        Cube::around(material, |law| with_interior_contact(law, [0.2, 0.5]))
    }

    /// Crushed along one axis to 2 % of the volume and back: the pressure, the stiffening, and no
    /// energy left; above the fraction the law alone. With a law that keeps the volume, and one
    /// that does not.
    #[test]
    fn the_pressure_begins_at_the_fraction() {
        let foam = [("compression", table(&[[0.0, 1e-3], [0.95, 2e-3]]))];
        let elastic = [("youngs_modulus", 1.0), ("poisson", 0.0)];
        for (law, others) in [("elastic", &[][..]), ("crushable_foam", &foam)] {
            let material = material(law, &elastic, others);
            let (mut cube, mut alone) = (cube(&material), Cube::new(&material));
            let steps = 40_000;
            let each = 0.02_f64.ln() / f64::from(steps);
            for step in 0..2 * steps {
                let eps = if step < steps { each } else { -each };
                for cube in [&mut cube, &mut alone] {
                    cube.step([eps, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
                }
                let volume = cube.strain[0].exp();
                let added = alone.state[0] - cube.state[0];
                let wanted = if volume < 0.2 { 0.25 * ((0.2 / volume).powi(2) - 1.0) } else { 0.0 };
                // The elements' strain increments and their sum differ by round-off and 1e-9.
                assert!((added - wanted).abs() < 1e-6 * (1.0 + wanted), "{law} {volume}: {added}");
                if law == "elastic" && volume < 0.199 {
                    let more = 0.5 * (0.2 / volume).powi(2);
                    assert!((cube.at("stiffening") - more).abs() < 1e-6 * more);
                }
                let across = alone.state[1] - cube.state[1];
                assert!((across - added).abs() < 1e-9 * (1.0 + wanted), "{law} {volume}");
            }
            let lost = cube.work - alone.work;
            assert!(lost.abs() < 1e-6, "{law}: {lost}");
        }
    }
}
