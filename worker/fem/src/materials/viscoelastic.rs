//! Linear viscoelasticity whose shear modulus decays with one rate (Herrmann & Peterson 1968), as
//! in `*MAT_VISCOELASTIC`:
//! ```text
//! s = 2 int G(t - tau) e'(tau) d tau,   G(t) = G_long + (G - G_long) exp(-beta t)
//! ```
//! with the deviators s of the stress and e' of the strain rate. G and the bulk modulus, which does
//! not relax, follow from `youngs_modulus` and `poisson`: these are the constants of fast loads.
//!
//! Exact for a constant strain rate in the step: the part `v` of the deviator that decays becomes
//! `v <- r v + 2 (G - G_long) w e`, `r = exp(-x)`, `w = (1 - r)/x`, `x = beta dt`. In plane stress
//! the strain through the thickness removes the stress there.
//!
//! Valid for small strains and large rotations. Forces that an element computes from the elastic
//! constants do not relax: transverse shear, torsion, hourglass, drilling.

use super::parameters::Parameters;
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points, Solid,
    SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "viscoelastic",
    meaning: "Linear viscoelasticity with one decay of the shear modulus; `youngs_modulus` and \
              `poisson` are those of fast loads.",
    constants: ELASTIC,
    parameters: &[
        ParameterRow {
            key: "long_term_shear_modulus",
            form: Form::Number,
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Shear modulus of slow loads, at most that of fast loads [force/length^2].",
        },
        ParameterRow {
            key: "decay_rate",
            form: Form::Number,
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Rate at which the shear modulus decays from fast to slow loads [1/time].",
        },
    ],
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

struct Viscoelastic {
    elastic: Elastic,
    /// G_long [force/length^2].
    long_term: f64,
    /// beta [1/time].
    decay_rate: f64,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Viscoelastic, Vec<Problem>> {
    let shear = elastic.shear_modulus();
    let wanted = format!("from 0 to the shear modulus of fast loads, {shear}");
    let long_term = parameters.required("long_term_shear_modulus", &wanted, |g| {
        (0.0..=shear * (1.0 + 1e-9)).contains(&g)
    });
    let decay_rate = parameters.required("decay_rate", "0 or above", |rate| rate >= 0.0);
    if elastic.poisson == 0.5 {
        let help = "give a finite bulk modulus: 0.49 or 0.499 for a nearly incompressible material";
        parameters.wrong("poisson", "is 0.5", help);
    }
    parameters.finish()?;
    Ok(Viscoelastic { elastic, long_term, decay_rate })
}

/// Moduli of a step [force/length^2], and what is left of the decaying part.
struct Step<R> {
    bulk: R,
    /// Shear modulus of the step, and its part that decays.
    shear: R,
    decaying: R,
    /// r.
    left: R,
}

impl Viscoelastic {
    #[inline(always)]
    fn moduli<R: Real>(&self, dt: f64) -> Step<R> {
        let x = dt * self.decay_rate;
        let lost = -(-x).exp_m1();
        let mean = if x > 0.0 { lost / x } else { 1.0 };
        let decaying = mean * (self.elastic.shear_modulus() - self.long_term);
        let shear = self.long_term + decaying;
        let [bulk, shear, decaying, left] =
            [self.elastic.bulk_modulus(), shear, decaying, 1.0 - lost].map(R::splat);
        Step { bulk, shear, decaying, left }
    }

    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let Step { bulk, shear, decaying, left } = self.moduli(dt);
        let eps = point.strain;
        let third_strain = R::splat(1.0 / 3.0) * (eps[0] + eps[1] + eps[2]);
        let pressure = R::splat(3.0) * bulk * third_strain;
        let one = R::splat(1.0);
        let (stress, old) = point.state.split_at_mut(6);
        for c in 0..6 {
            // Twice the deviator of the strain.
            let (twice, mean) = if c < 3 {
                (R::splat(2.0) * (eps[c] - third_strain), pressure)
            } else {
                (eps[c], R::zero())
            };
            let lost = (left - one) * old[c];
            stress[c] += shear.mul_add(twice, mean) + lost;
            old[c] = left.mul_add(old[c], decaying * twice);
        }
        one
    }

    #[inline(always)]
    fn shell<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let Step { bulk, shear, decaying, left } = self.moduli(dt);
        let (one, two, third) = (R::splat(1.0), R::splat(2.0), R::splat(1.0 / 3.0));
        let through = one / R::splat(4.0 / 3.0).mul_add(shear, bulk);
        let coupling = R::splat(2.0 / 3.0).neg_mul_add(shear, bulk);
        let (states, _) = points.state.as_chunks_mut::<6>();
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
            let (stress, old) = state.split_at_mut(3);
            let decay = left - one;
            let old_z = -(old[0] + old[1]);
            let in_plane = eps[0] + eps[1];
            *eps_z = -through * coupling.mul_add(in_plane, decay * old_z);
            let third_strain = third * (in_plane + *eps_z);
            let pressure = R::splat(3.0) * bulk * third_strain;
            for c in 0..3 {
                let (twice, mean) = if c < 2 {
                    (two * (eps[c] - third_strain), pressure)
                } else {
                    (eps[2], R::zero())
                };
                stress[c] += shear.mul_add(twice, mean) + decay * old[c];
                old[c] = left.mul_add(old[c], decaying * twice);
            }
        }
    }
}

impl PlaneStress for Viscoelastic {
    fn history(&self) -> &'static [&'static str] {
        &["decaying xx", "decaying yy", "decaying xy"]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.shell(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.shell(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.shell(points, dt);
    }
}

impl Solid for Viscoelastic {
    fn history(&self) -> &'static [&'static str] {
        &["decaying xx", "decaying yy", "decaying zz", "decaying xy", "decaying yz", "decaying zx"]
    }
    fn tensors(&self) -> usize {
        1
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.solid(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.solid(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.solid(point, dt)
    }
}

#[cfg(test)]
mod tests {
    use crate::materials::testing::{Cube, Sheet, material, problems};

    /// Moduli in MPa, times in ms: K = 2, fast G = 0.6, slow G = 0.1, decay 0.5.
    const BULK: f64 = 2.0;
    const FAST: f64 = 0.6;
    const SLOW: f64 = 0.1;
    const DECAY: f64 = 0.5;

    fn gel() -> crumple_proto::partition::Material {
        let e = 9.0 * BULK * FAST / (3.0 * BULK + FAST);
        let nu = (3.0 * BULK - 2.0 * FAST) / (2.0 * (3.0 * BULK + FAST));
        let numbers = [
            ("youngs_modulus", e),
            ("poisson", nu),
            ("long_term_shear_modulus", SLOW),
            ("decay_rate", DECAY),
        ];
        material("viscoelastic", &numbers, &[])
    }

    /// Shear at a constant rate for a time, then held: the stress is the integral of the decaying
    /// modulus, exactly, for any steps.
    #[test]
    fn shear_relaxes_by_the_closed_form() {
        let (rate, ramp) = (2e-3, 3.0);
        let (mut cube, mut sheet) = (Cube::new(&gel()), Sheet::new(&gel()));
        let mut time = 0.0;
        for step in 0..60 {
            let dt = if step % 2 == 0 { 0.05 } else { 0.15 };
            let gamma = if step < 30 { rate * dt } else { 0.0 };
            cube.step([0.0, 0.0, 0.0, 0.0, gamma, 0.0], dt);
            sheet.step([0.0, 0.0, gamma], dt);
            time += dt;
            let since = (time - ramp).max(0.0);
            let loaded = time.min(ramp);
            let decays = ((-DECAY * since).exp() - (-DECAY * (since + loaded)).exp()) / DECAY;
            let exact = rate * (SLOW * loaded + (FAST - SLOW) * decays);
            for (name, got) in [("cube", cube.state[4]), ("sheet", sheet.state[2])] {
                assert!((got / exact - 1.0).abs() < 1e-12, "{name} at {time}: {got} for {exact}");
            }
        }
        assert!(cube.state[4] < 0.5 * FAST * rate * ramp, "it has relaxed");
    }

    /// A held uniaxial strain with free sides: at first the stress is that of the fast moduli, in
    /// the end that of the slow ones. The pressure does not relax.
    #[test]
    fn uniaxial_stress_goes_from_fast_to_slow_moduli() {
        let young = |g: f64| 9.0 * BULK * g / (3.0 * BULK + g);
        let eps = 1e-3;
        let (mut cube, mut sheet) = (Cube::new(&gel()), Sheet::new(&gel()));
        let pull = |cube: &mut Cube, sheet: &mut Sheet, eps: f64, dt: f64| {
            cube.pull([eps, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], dt);
            sheet.pull(eps, dt);
        };
        pull(&mut cube, &mut sheet, eps, 1e-9);
        for got in [cube.state[0], sheet.state[0]] {
            assert!((got / (young(FAST) * eps) - 1.0).abs() < 1e-8, "{got}");
        }
        (0..400).for_each(|_| pull(&mut cube, &mut sheet, 0.0, 0.2));
        for got in [cube.state[0], sheet.state[0]] {
            assert!((got / (young(SLOW) * eps) - 1.0).abs() < 1e-8, "{got}");
        }
        assert!((sheet.strain[3] - sheet.strain[1]).abs() < 1e-12, "the sides are alike");

        let mut squeezed = Cube::new(&gel());
        squeezed.step([-eps, -eps, -eps, 0.0, 0.0, 0.0], 1.0);
        (0..100).for_each(|_| _ = squeezed.step([0.0; 6], 1.0));
        assert!((squeezed.state[0] / (-3.0 * BULK * eps) - 1.0).abs() < 1e-12);
    }

    /// A closed cycle of strain costs work.
    #[test]
    fn a_closed_cycle_gives_no_energy() {
        let mut cube = Cube::new(&gel());
        for cycle in 0..5 {
            let before = cube.work;
            for step in 0..400 {
                let sign = if (100..300).contains(&step) { -1.0 } else { 1.0 };
                cube.step([0.0, 0.0, 0.0, sign * 1e-4, 0.0, 0.0], 0.02);
            }
            assert!(cube.work - before > 1e-6, "cycle {cycle}: {}", cube.work - before);
        }
    }

    #[test]
    fn a_slow_modulus_above_the_fast_one_is_refused() {
        let numbers = [
            ("youngs_modulus", 1.0),
            ("poisson", 0.25),
            ("long_term_shear_modulus", 0.5),
            ("decay_rate", -1.0),
        ];
        let text = problems(&material("viscoelastic", &numbers, &[]));
        assert!(text.contains("fast loads, 0.4") && text.contains("decay_rate is -1"), "{text}");
    }
}
