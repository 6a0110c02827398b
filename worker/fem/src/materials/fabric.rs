//! Fabric of airbags and belts: elastic in its plane, without compression if it wrinkles.
//!
//! The stress is a function of the total logarithmic strain `(e_x, e_y, g_xy)` in the axes of the
//! element. Without other constants the fabric is isotropic. With `youngs_modulus_b` or
//! `shear_modulus` it has yarns along the axes a and b, with nu_ab/E_a = nu_ba/E_b:
//! ```text
//! s_a = C_aa e_a + C_ab e_b,  s_b = C_ab e_a + C_bb e_b,  s_ab = G g_ab
//! C_aa = E_a/(1 - nu_ab nu_ba),  C_ab = nu_ba C_aa,  C_bb = E_b/(1 - nu_ab nu_ba)
//! ```
//! Without compression the energy is the least one with additional contractions, which are the
//! wrinkles (tension field; Pipkin 1986, IMA J. Appl. Math. 36). For principal strains e_1 >= e_2
//! of the isotropic fabric: s_2 = 0 and s_1 = E e_1 if e_2 < -nu e_1, and no stress if also
//! e_1 < 0. In a fabric with yarns the same holds along a and b, each with its own modulus, and the
//! shear keeps its stress. So the stress stays that of an energy: a closed path of strain does no
//! work.
//!
//! A liner, the fraction r of the thickness, is isotropic and carries compression. Damping adds
//! `d C` times the strain increment of the step, d of critical damping at the highest frequency;
//! the stable step is shorter by `sqrt(1 + d^2) - d`.

use super::axes::{
    self, ANGLE, DIRECTION, DIRECTION_COLUMNS, Orientation, Orthotropic, linear, strain_along,
    stress_across,
};
use super::parameters::Parameters;
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;

/// The row of this law.
pub const LAW: Law = Law {
    name: "fabric",
    meaning: "Elastic fabric, without compression unless `compression` is true; `youngs_modulus` \
              is that of the yarns a, `poisson` the contraction along a due to tension along b.",
    constants: ELASTIC,
    parameters: &[
        number(
            "youngs_modulus_b",
            "Young's modulus of the yarns b; that of a if not given \
                                    [force/length^2].",
        ),
        number(
            "shear_modulus",
            "Shear modulus of the yarns; isotropic if not given \
                                 [force/length^2].",
        ),
        DIRECTION,
        ANGLE,
        ParameterRow {
            key: "compression",
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "True if the fabric carries compression.",
        },
        number(
            "damping",
            "Fraction of critical damping at the highest frequency, 0 to 0.5; 0.05 \
                           is usual.",
        ),
        number(
            "liner_fraction",
            "Fraction of the thickness that an isotropic liner has; it \
                                  carries compression.",
        ),
        number("liner_youngs_modulus", "Young's modulus of the liner [force/length^2]."),
        number("liner_poisson", "Poisson's ratio of the liner."),
    ],
    build: Some(build),
    solid: None,
    cohesive: None,
};

const fn number(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise: DefaultValue::Absent, range: None, meaning }
}

/// History columns: the total strain, and the direction of the yarns a in the axes of the element,
/// its cosine less 1.
const HISTORY: &[&str] =
    &["strain xx", "strain yy", "strain xy", DIRECTION_COLUMNS[0], DIRECTION_COLUMNS[1]];

/// Columns of a point.
const COLUMNS: usize = 8;

struct Fabric {
    /// Constants that bound the stiffness, for the stable step.
    bound: Elastic,
    yarns: Option<Orthotropic>,
    /// Isotropic constants: modulus and Poisson's ratio.
    isotropic: [f64; 2],
    compression: bool,
    /// d.
    damping: f64,
    /// Fraction of the liner, its C11, C12 and G [force/length^2].
    liner: [f64; 4],
    orientation: Orientation,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn read(
    mut parameters: Parameters<'_>,
    elastic: Elastic,
) -> Result<Fabric, Vec<crumple_proto::problem::Problem>> {
    let positive = |value: f64| value > 0.0;
    let eb = parameters.optional("youngs_modulus_b", "above 0", positive);
    let g = parameters.optional("shear_modulus", "above 0", positive);
    let orientation = Orientation::read(&mut parameters);
    let compression = parameters.flag("compression");
    let damping = parameters.optional("damping", "from 0 to 0.5", |d| (0.0..=0.5).contains(&d));
    let damping = damping.unwrap_or(0.0);
    let fraction =
        parameters.optional("liner_fraction", "from 0 to 1", |f| (0.0..=1.0).contains(&f));
    let modulus = parameters.optional("liner_youngs_modulus", "above 0", positive);
    let poisson =
        parameters.optional("liner_poisson", "from 0 to 0.5", |p| (0.0..=0.5).contains(&p));
    let fraction = fraction.unwrap_or(0.0);
    if fraction > 0.0 && modulus.is_none() {
        parameters.wrong(
            "liner_fraction",
            "is given without the modulus of the liner",
            "give `liner_youngs_modulus`, and `liner_poisson` if it is not 0",
        );
    }
    let of_liner = Elastic {
        youngs_modulus: modulus.unwrap_or(1.0),
        poisson: poisson.unwrap_or(0.0),
        ..elastic
    };
    let isotropic = [elastic.youngs_modulus, elastic.poisson];
    let yarns = (eb.is_some() || g.is_some()).then(|| {
        let (ea, eb) = (elastic.youngs_modulus, eb.unwrap_or(elastic.youngs_modulus));
        let g = g.unwrap_or(elastic.shear_modulus());
        Orthotropic::new(&mut parameters, [ea, eb, g], elastic.poisson, "fabric")
    });
    parameters.finish()?;
    let [l11, l12, lg] = of_liner.plane_stress();
    let liner = [fraction, l11, l12, lg];
    let bound = bound(elastic, yarns, liner, damping);
    Ok(Fabric { bound, yarns, isotropic, compression, damping, liner, orientation })
}

/// Returns isotropic constants with a stiffness that is nowhere below that of the fabric, damping
/// included.
fn bound(elastic: Elastic, yarns: Option<Orthotropic>, liner: [f64; 4], damping: f64) -> Elastic {
    let [c11, c12, g] = elastic.plane_stress();
    let [caa, cab, cbb, g] = yarns.map_or([c11, c12, c11, g], |y| [y.caa, y.cab, y.cbb, y.g]);
    let [fraction, l11, l12, lg] = liner;
    let mix = |fabric: f64, liner: f64| (1.0 - fraction) * fabric + fraction * liner;
    let mixed = [mix(caa, l11), mix(cab, l12), mix(cbb, l11), mix(g, lg)];
    let undamped = axes::bound(mixed, elastic.density);
    let shorter = (1.0 + damping * damping).sqrt() - damping;
    Elastic { youngs_modulus: undamped.youngs_modulus / (shorter * shorter), ..undamped }
}

impl Fabric {
    fn stress<R: Real>(&self, points: Points<'_, R>) {
        let (states, _) = points.state.as_chunks_mut::<COLUMNS>();
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
            let total: [R; 3] = std::array::from_fn(|c| state[3 + c] + eps[c]);
            let (c, s) = (state[6] + R::splat(1.0), state[7]);
            let damped = self.linear(*eps, c, s);
            let of_fabric = if self.compression {
                self.linear(total, c, s)
            } else {
                match &self.yarns {
                    Some(yarns) => along_yarns(total, c, s, |e| tension(yarns, e)),
                    None => self.tension_field(total),
                }
            };
            let [fraction, l11, l12, lg] = self.liner.map(R::splat);
            let of_liner = linear(total, [l11, l12, l11, lg]);
            for k in 0..3 {
                let elastic =
                    (R::splat(1.0) - fraction).mul_add(of_fabric[k], fraction * of_liner[k]);
                state[k] = R::splat(self.damping).mul_add(damped[k], elastic);
                state[3 + k] = total[k];
            }
            *eps_z = R::zero();
        }
    }

    /// Returns the stress of the fabric with compression for a strain.
    fn linear<R: Real>(&self, e: [R; 3], c: R, s: R) -> [R; 3] {
        let Some(yarns) = &self.yarns else {
            let [youngs_modulus, poisson] = self.isotropic;
            let constants = Elastic { youngs_modulus, poisson, density: 0.0 }.plane_stress();
            let [c11, c12, g] = constants.map(R::splat);
            return linear(e, [c11, c12, c11, g]);
        };
        let constants = [yarns.caa, yarns.cab, yarns.cbb, yarns.g].map(R::splat);
        along_yarns(e, c, s, |e| linear(e, constants))
    }

    /// Returns the stress of the isotropic fabric without compression.
    fn tension_field<R: Real>(&self, [x, y, xy]: [R; 3]) -> [R; 3] {
        let [modulus, poisson] = self.isotropic;
        let (zero, half, nu) = (R::zero(), R::splat(0.5), R::splat(poisson));
        let c11 = R::splat(modulus / (1.0 - poisson * poisson));
        let (mean, turned) = (half * (x + y), [half * (x - y), half * xy]);
        let radius = turned[0].mul_add(turned[0], turned[1] * turned[1]).sqrt();
        let (e1, e2) = (mean + radius, mean - radius);
        let taut = e2.gt(-(nu * e1));
        let s1 = R::select(taut, c11 * nu.mul_add(e2, e1), R::splat(modulus) * e1);
        let s2 = R::select(taut, c11 * nu.mul_add(e1, e2), zero);
        let slack = R::both(e1.le(zero), e2.le(-(nu * e1)));
        let (s1, s2) = (R::select(slack, zero, s1), R::select(slack, zero, s2));
        // Cosine and sine of twice the angle of the first principal direction.
        let inverse = R::select(radius.gt(zero), R::splat(1.0) / radius, zero);
        let inverse = R::select(radius.gt(zero), inverse, zero);
        let (sum, difference) = (half * (s1 + s2), half * (s1 - s2) * inverse);
        let along = difference * turned[0];
        [sum + along, sum - along, difference * turned[1]]
    }
}

/// Returns the stress in the axes of the yarns, which carry no compression.
fn tension<R: Real>(yarns: &Orthotropic, [a, b, ab]: [R; 3]) -> [R; 3] {
    let zero = R::zero();
    let Orthotropic { caa, cab, cbb, ea, eb, g } = *yarns;
    let [caa, cab, cbb, ea, eb, g] = [caa, cab, cbb, ea, eb, g].map(R::splat);
    let (sa, sb) = (caa.mul_add(a, cab * b), cab.mul_add(a, cbb * b));
    let both = R::both(sa.gt(zero), sb.gt(zero));
    // With one of them slack the other has its own modulus.
    let (alone_a, alone_b) = (Real::max(ea * a, zero), Real::max(eb * b, zero));
    let only_a = R::select(sb.le(zero), alone_a, zero);
    let only_b = R::select(sa.le(zero), alone_b, zero);
    [R::select(both, sa, only_a), R::select(both, sb, only_b), g * ab]
}

/// Returns the stress in the axes of the element by a law in the axes of the yarns, whose axis a
/// has the direction (c, s).
fn along_yarns<R: Real>(strain: [R; 3], c: R, s: R, law: impl Fn([R; 3]) -> [R; 3]) -> [R; 3] {
    stress_across(law(strain_along(strain, c, s)), c, s)
}

impl PlaneStress for Fabric {
    fn history(&self) -> &'static [&'static str] {
        HISTORY
    }
    fn elastic(&self) -> Elastic {
        self.bound
    }
    fn thins(&self) -> bool {
        false
    }
    fn orientation(&self, _point: usize) -> Option<Orientation> {
        self.yarns.map(|_| self.orientation)
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.stress(points);
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.stress(points);
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.stress(points);
    }
}

#[cfg(test)]
#[path = "fabric_tests.rs"]
mod tests;
