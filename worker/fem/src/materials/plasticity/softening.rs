//! Damage that grows with the plastic strain, around any plastic law (Lemaitre 1985, strain
//! equivalence):
//! ```text
//! sigma = (1 - D) sigma~,   D = (eps_p - start)/(rupture - start), from 0 to 1
//! ```
//! The law computes the effective stress sigma~. The state holds sigma, so that elements see only
//! the stress that acts. A point fails at D = 1 and has no stress from then on.
//!
//! Without regularisation the energy of rupture is in proportion to the size of the elements.

use crate::materials::parameters::Parameters;
use crate::materials::plasticity::Plasticity;
use crate::materials::{
    DefaultValue, Elastic, Form, ParameterRow, PlaneStress, PointReal, Points, Solid, SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Param;

/// The key of the plastic strains where damage starts and is complete.
const KEY: &str = "softening";

/// The parameter of laws with damage.
pub const ROW: ParameterRow = ParameterRow {
    key: KEY,
    form: Form::List("[start, rupture]"),
    otherwise: DefaultValue::Absent,
    range: None,
    meaning: "Effective plastic strains at which damage starts and at which it is complete; the \
              stress falls linearly to zero between them, and a point fails at the second.",
};

/// Reads the two plastic strains.
pub fn read(parameters: &mut Parameters<'_>) -> Option<[f64; 2]> {
    match parameters.get(KEY)? {
        Param::List(list)
            if list.len() == 2
                && list.iter().all(|x| x.is_finite())
                && list[0] >= 0.0
                && list[0] < list[1] =>
        {
            Some([list[0], list[1]])
        }
        _ => {
            let help = "give two plastic strains, the first at least 0 and below the second";
            parameters.wrong(KEY, "is not [start, rupture]", help);
            None
        }
    }
}

/// A law with damage.
struct Softening<L: ?Sized> {
    law: Box<L>,
    start: f64,
    /// 1 over the range of plastic strain.
    per_range: f64,
    names: Vec<&'static str>,
    /// Number of columns of stress and of the law.
    own: usize,
    /// Columns with those of stress.
    plastic_strain: usize,
    failed: usize,
}

impl<L: ?Sized> Softening<L> {
    fn new(law: Box<L>, [start, rupture]: [f64; 2], stress: usize, names: &[&'static str]) -> Self {
        let own = stress + names.len();
        let mut names = names.to_vec();
        let column = |names: &[&'static str], name| names.iter().position(|known| *known == name);
        let plastic_strain = column(&names, "plastic_strain").expect("plastic laws have one");
        let failed = column(&names, "failed").unwrap_or_else(|| {
            names.push("failed");
            names.len() - 1
        });
        Self {
            law,
            start,
            per_range: 1.0 / (rupture - start),
            names,
            own,
            plastic_strain: stress + plastic_strain,
            failed: stress + failed,
        }
    }

    /// Returns 1 - D.
    #[inline(always)]
    fn intact<R: Real>(&self, state: &[R]) -> R {
        let beyond = state[self.plastic_strain] - R::splat(self.start);
        let damage = Real::max(R::splat(self.per_range) * beyond, R::zero());
        Real::max(R::splat(1.0) - damage, R::zero())
    }

    /// Updates a point by `law`, which sees the effective stress. Returns 1 - D before and after.
    #[inline(always)]
    fn update_point<R: Real>(
        &self,
        stress: usize,
        state: &mut [R],
        law: impl FnOnce(&mut [R]),
    ) -> [R; 2] {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let alive = state[self.failed].lt(R::splat(0.5));
        let before = R::select(alive, self.intact(state), one);
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, *s / before, zero));
        let plastic_strain = state[self.plastic_strain];
        law(&mut state[..self.own]);
        // A failed point keeps its plastic strain, whatever the law inside does.
        let kept = R::select(alive, state[self.plastic_strain], plastic_strain);
        state[self.plastic_strain] = kept;
        let after = self.intact(state);
        let alive = R::both(R::both(alive, state[self.failed].lt(R::splat(0.5))), after.gt(zero));
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, after * *s, zero));
        state[self.failed] = R::select(alive, zero, one);
        [before, after]
    }
}

impl Softening<dyn PlaneStress> {
    #[inline(always)]
    fn shell<R: PointReal>(&self, points: Points<'_, R>, dt: f64) {
        let states = points.state.chunks_exact_mut(3 + self.names.len());
        for ((state, eps), through) in states.zip(points.strain).zip(points.thickness_strain) {
            self.update_point(3, state, |state| {
                let (strain, thickness_strain) =
                    (std::slice::from_ref(eps), std::slice::from_mut(through));
                R::update(&*self.law, Points { state, strain, thickness_strain }, dt);
            });
        }
    }
}

impl Softening<dyn Solid> {
    #[inline(always)]
    fn solid<R: PointReal>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (state, strain) = (point.state, point.strain);
        let mut left = R::splat(1.0);
        let [before, after] = self.update_point(6, state, |state| {
            left = R::update_solid(&*self.law, SolidPoint { state, strain }, dt);
        });
        left * (after / before)
    }
}

/// Adds damage to a law of shells, if `strains` are given.
pub fn shell(law: Box<dyn PlaneStress>, strains: Option<[f64; 2]>) -> Box<dyn PlaneStress> {
    let Some(strains) = strains else { return law };
    let names = law.history().to_vec();
    Box::new(Softening::new(law, strains, 3, &names))
}

/// Adds damage to a law of solids, if `strains` are given.
pub fn solid(law: Box<dyn Solid>, strains: Option<[f64; 2]>) -> Box<dyn Solid> {
    let Some(strains) = strains else { return law };
    let names = law.history().to_vec();
    Box::new(Softening::new(law, strains, 6, &names))
}

impl PlaneStress for Softening<dyn PlaneStress> {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn elastic(&self) -> Elastic {
        self.law.elastic()
    }
    fn initial_yield_stress(&self) -> f64 {
        self.law.initial_yield_stress()
    }
    fn rate_dependent(&self) -> Option<&Plasticity> {
        self.law.rate_dependent()
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

impl Solid for Softening<dyn Solid> {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn tensors(&self) -> usize {
        self.law.tensors()
    }
    fn elastic(&self) -> Elastic {
        self.law.elastic()
    }
    fn averages_volume(&self) -> bool {
        self.law.averages_volume()
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
    use crumple_proto::partition::{Material, Param};

    const E: f64 = 200.0;
    const YIELD: f64 = 0.2;
    const START: f64 = 0.02;
    const RUPTURE: f64 = 0.06;

    fn metal(strains: &[f64], more: &[(&str, f64)]) -> Material {
        let numbers = [("youngs_modulus", E), ("poisson", 0.3), ("yield_stress", YIELD)];
        let numbers = [&numbers, more].concat();
        material("j2", &numbers, &[("softening", Param::List(strains.to_vec()))])
    }

    /// Stress of uniaxial tension without hardening: the yield stress until damage starts, then a
    /// straight line to zero at rupture; unloading has the modulus (1 - D) E.
    #[test]
    fn stress_falls_along_a_straight_line() {
        let law = metal(&[START, RUPTURE], &[]);
        let (mut sheet, mut cube) = (Sheet::new(&law), Cube::new(&law));
        for _ in 0..400 {
            sheet.pull(1e-4, 1.0);
            cube.pull([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
        }
        for (stress, eps_p) in
            [(sheet.state[0], sheet.state[3]), (cube.state[0], cube.at("plastic_strain"))]
        {
            let exact = YIELD * (1.0 - (eps_p - START) / (RUPTURE - START));
            assert!(eps_p > 0.038 && (stress - exact).abs() < 1e-9, "{stress} for {exact}");
        }
        let intact = 1.0 - (sheet.state[3] - START) / (RUPTURE - START);
        let loaded = sheet.state[0];
        sheet.pull(-1e-5, 1.0);
        let modulus = (loaded - sheet.state[0]) / 1e-5;
        assert!((modulus - intact * E).abs() < 1e-6 * E, "{modulus} for {}", intact * E);
    }

    /// Work to rupture per volume: yield stress times the mean of the two strains, and the elastic
    /// energy at yield, which damage dissipates; no stress afterwards, whatever the strain.
    #[test]
    fn work_to_rupture_and_no_stress_afterwards() {
        for more in [&[][..], &[("kinematic_modulus", 1e-9)]] {
            let mut cube = Cube::new(&metal(&[START, RUPTURE], more));
            let mut steps = 0;
            let mut work = 0.0;
            while cube.at("failed") == 0.0 {
                let before = cube.state[0];
                cube.pull([1e-5, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0);
                work += 0.5 * (before + cube.state[0]) * 1e-5;
                steps += 1;
                assert!(steps < 7000, "it must fail");
            }
            let exact = YIELD * (0.5 * (START + RUPTURE) + 0.5 * YIELD / E);
            // Yield and rupture fall within a step of 1e-5.
            assert!((work - exact).abs() < 1e-5 * exact, "{work} for {exact}");
            let reached = cube.at("plastic_strain");
            for strain in [[1e-3, 0.0, 0.0, 1e-3, 0.0, 0.0], [-0.1; 6]] {
                cube.step(strain, 1.0);
                assert!(cube.state[..6].iter().all(|s| *s == 0.0), "{:?}", cube.state);
            }
            assert_eq!(cube.at("plastic_strain").to_bits(), reached.to_bits());
        }
    }

    #[test]
    fn wrong_strains_are_refused() {
        for strains in [&[0.1][..], &[0.2, 0.1], &[-0.1, 0.1], &[0.0, f64::NAN]] {
            let text = problems(&metal(strains, &[]));
            assert!(text.contains("softening") && text.contains("below the second"), "{text}");
        }
    }
}
