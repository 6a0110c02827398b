//! Linear viscoelasticity with one relaxation time tau (Maxwell 1867): `d sigma/dt = C d eps/dt -
//! sigma/tau`, with the elastic C of plane stress or of three dimensions.
//!
//! Exact for a constant strain rate in the step: `sigma <- r sigma + w C eps`, `r = exp(-x)`,
//! `w = (1 - r)/x`, `x = dt/tau`. Valid for small strains and large rotations.
//!
//! Left out: a long-term modulus; a bulk modulus that does not relax.

use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;
use crumple_worker::fem::materials::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, Parameters, PlaneStress,
    Points, Solid, SolidLawResult, SolidPoint,
};
use crumple_worker::math::lanes::{Lane, Lane32, Real};

/// The row of this law.
pub static LAW: Law = Law {
    name: "maxwell",
    meaning: "Linear viscoelasticity with one relaxation time.",
    constants: ELASTIC,
    parameters: PARAMETERS,
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

const PARAMETERS: &[ParameterRow] = &[ParameterRow {
    key: "relaxation_time",
    form: Form::Number,
    otherwise: DefaultValue::Needed,
    range: None,
    meaning: "Time in which stress falls to 1/e at constant strain [time].",
}];

struct Maxwell {
    elastic: Elastic,
    /// tau [time].
    relaxation_time: f64,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn solid(material: &Material) -> SolidLawResult {
    Parameters::new(material).solid_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Maxwell, Vec<Problem>> {
    let relaxation_time = parameters.required("relaxation_time", "above 0", |t| t > 0.0);
    parameters.finish()?;
    Ok(Maxwell { elastic, relaxation_time })
}

impl Maxwell {
    /// r and w of a step `dt` [time].
    fn factors(&self, dt: f64) -> [f64; 2] {
        let x = dt / self.relaxation_time;
        let relaxed = -(-x).exp_m1();
        [1.0 - relaxed, if x > 0.0 { relaxed / x } else { 1.0 }]
    }

    #[inline(always)]
    fn stress<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let [c11, c12, g] = self.elastic.plane_stress().map(R::splat);
        let [r, w] = self.factors(dt).map(R::splat);
        let poisson = self.elastic.poisson;
        let through = R::splat(-poisson / (1.0 - poisson));
        let (states, _) = points.state.as_chunks_mut::<3>();
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
            let dx = c11.mul_add(eps[0], c12 * eps[1]);
            let dy = c11.mul_add(eps[1], c12 * eps[0]);
            state[0] = r.mul_add(state[0], w * dx);
            state[1] = r.mul_add(state[1], w * dy);
            state[2] = r.mul_add(state[2], w * g * eps[2]);
            *eps_z = through * (eps[0] + eps[1]);
        }
    }

    #[inline(always)]
    fn solid_stress<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let (lame, g) = (R::splat(self.elastic.lame()), R::splat(self.elastic.shear_modulus()));
        let [r, w] = self.factors(dt).map(R::splat);
        let eps = point.strain;
        let pressure = lame * (eps[0] + eps[1] + eps[2]);
        for c in 0..3 {
            let direct = (g + g).mul_add(eps[c], pressure);
            point.state[c] = r.mul_add(point.state[c], w * direct);
            point.state[3 + c] = r.mul_add(point.state[3 + c], w * g * eps[3 + c]);
        }
        r
    }
}

impl PlaneStress for Maxwell {
    fn history(&self) -> &'static [&'static str] {
        &[]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.stress(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.stress(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.stress(points, dt);
    }
}

impl Solid for Maxwell {
    fn history(&self) -> &'static [&'static str] {
        &[]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.solid_stress(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.solid_stress(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.solid_stress(point, dt)
    }
}

#[cfg(test)]
mod tests {
    use super::build;
    use crumple_proto::partition::{Material, Param};
    use crumple_worker::fem::materials::Points;

    const TAU: f64 = 4.0;

    fn gel() -> Material {
        let numbers = [("youngs_modulus", 2.0), ("poisson", 0.25), ("relaxation_time", TAU)];
        let parameters =
            numbers.into_iter().map(|(key, n)| (key.to_string(), Param::Number(n))).collect();
        Material { name: "gel".into(), law: "maxwell".into(), density: 1e-6, parameters }
    }

    /// A constant rate for tau in one step, then constant strain for tau in ten steps.
    #[test]
    fn stress_is_the_exact_solution() {
        let law = build(&gel()).expect("a sound material");
        let mut state = [0.0; 3];
        let mut step = |eps: f64, dt: f64| {
            let strain = [[eps, 0.0, 0.0]];
            law.update_one(
                Points { state: &mut state, strain: &strain, thickness_strain: &mut [0.0] },
                dt,
            );
            state[0]
        };
        let (c, eps, left) = (2.0 / (1.0 - 0.0625), 1e-3, (-1.0_f64).exp());
        let pulled = step(eps, TAU);
        assert!((pulled / (c * eps * (1.0 - left)) - 1.0).abs() < 1e-14, "{pulled}");
        let relaxed = (0..10).fold(0.0, |_, _| step(0.0, 0.1 * TAU));
        assert!((relaxed / (pulled * left) - 1.0).abs() < 1e-14, "ten products: {relaxed}");
    }
}
