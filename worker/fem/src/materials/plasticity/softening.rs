//! Damage that grows with the plastic strain, around any plastic law (Lemaitre 1985, strain
//! equivalence):
//! ```text
//! sigma = (1 - D) sigma~,   D = (eps_p - start)/(rupture - start), from 0 to 1
//! ```
//! The law computes the effective stress sigma~. A point fails at D = 1.
//!
//! Without regularisation the energy of rupture is in proportion to the size of the elements.

use crate::materials::damaged::{DamageColumns, DamageLaw};
use crate::materials::parameters::Parameters;
use crate::materials::wrapped::{self, PointColumns};
use crate::materials::{
    DefaultValue, Form, LawResult, ParameterRow, PlaneStress, Solid, SolidLawResult,
};
use crumple_math::lanes::Real;
use crumple_proto::partition::Param;
use crumple_proto::problem::Problem;

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

/// Damage of a law.
struct Softening {
    start: f64,
    /// 1 over the range of plastic strain.
    per_range: f64,
    columns: DamageColumns,
}

impl Softening {
    fn new([start, rupture]: [f64; 2], columns: &mut PointColumns) -> Result<Self, Vec<Problem>> {
        let columns = DamageColumns::new(columns).expect("plastic laws have a plastic strain");
        Ok(Self { start, per_range: 1.0 / (rupture - start), columns })
    }
}

impl DamageLaw for Softening {
    fn columns(&self) -> &DamageColumns {
        &self.columns
    }

    #[inline(always)]
    fn intact<R: Real>(&self, state: &[R]) -> R {
        let beyond = state[self.columns.plastic_strain] - R::splat(self.start);
        let damage = Real::max(R::splat(self.per_range) * beyond, R::zero());
        Real::max(R::splat(1.0) - damage, R::zero())
    }

    #[inline(always)]
    fn holds<R: Real>(&self, _state: &[R], intact: R) -> R::Mask {
        intact.gt(R::zero())
    }
}

/// Adds damage to a law of shells, if `strains` are given.
pub fn shell(law: Box<dyn PlaneStress>, strains: Option<[f64; 2]>) -> LawResult {
    let Some(strains) = strains else { return Ok(law) };
    wrapped::shell(law, |columns| Softening::new(strains, columns))
}

/// Adds damage to a law of solids, if `strains` are given.
pub fn solid(law: Box<dyn Solid>, strains: Option<[f64; 2]>) -> SolidLawResult {
    let Some(strains) = strains else { return Ok(law) };
    wrapped::solid(law, |columns| Softening::new(strains, columns))
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
