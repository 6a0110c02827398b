//! Anisotropic plasticity of sheets (Barlat & Lian 1989), as in `*MAT_3-PARAMETER_BARLAT` (LS-DYNA
//! Keyword User's Manual, vol. II, material 36). Elasticity is isotropic. The yield surface is in
//! `barlat/surface.rs`; its parameters follow from the ratios of the plastic strains across and
//! through the sheet in tension at 0, 45 and 90 degrees to the axis a, the direction of rolling:
//! ```text
//! a = 2 - 2 sqrt(R0/(1 + R0) R90/(1 + R90)),   h = sqrt(R0/(1 + R0) (1 + R90)/R90)
//! ```
//! and p such that the ratio at 45 degrees is R45. With m = 2 and ratios of one it is the von Mises
//! condition.
//!
//! Yield stress in tension along a: `yield_stress` and `hardening_modulus`, the table `hardening`,
//! or `swift = [k, e0, n]`, `k (e0 + g)^n` with the effective plastic strain g.
//!
//! Each lane that yields is returned alone, in double precision.
//!
//! Not included: strain rates, kinematic hardening, ratios that change with the strain, transverse
//! shear in the yield condition.

mod surface;
#[cfg(test)]
mod tests;

use self::surface::{BarlatSurface, YieldState};
use super::axes::{ANGLE, DIRECTION, DIRECTION_COLUMNS, Orientation, stress_across, stress_along};
use super::hardening::{HARDENING, Hardening};
use super::parameters::Parameters;
use super::{
    DefaultValue, ELASTIC, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points,
};
use crumple_math::lanes::{LANES, LANES32, Lane, Lane32, Lanes, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law {
    name: "barlat",
    meaning: "Anisotropic plasticity of sheets (Barlat and Lian 1989).",
    constants: ELASTIC,
    parameters: &[
        DIRECTION,
        ANGLE,
        row(
            "exponent",
            DefaultValue::Number(8.0),
            "Exponent m, 2 or above: 6 of bcc metals, 8 of fcc metals.",
        ),
        row(
            RATIOS[0],
            DefaultValue::Number(1.0),
            "Plastic strain across over that through the sheet in tension along a.",
        ),
        row(RATIOS[1], DefaultValue::Number(1.0), "The same in tension at 45 degrees."),
        row(RATIOS[2], DefaultValue::Number(1.0), "The same in tension along b."),
        HARDENING[0],
        HARDENING[1],
        HARDENING[2],
        HARDENING[3],
    ],
    build: Some(build),
    solid: None,
    cohesive: None,
};

const RATIOS: [&str; 3] = ["lankford_0", "lankford_45", "lankford_90"];

const fn row(key: &'static str, otherwise: DefaultValue, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise, range: None, meaning }
}

/// Columns of a point: stress, effective plastic strain, direction of the axis a.
const STRAIN: usize = 3;
const COSINE: usize = 4;
const SINE: usize = 5;
const COLUMNS: usize = 6;
const HISTORY: [&str; 3] = ["plastic_strain", DIRECTION_COLUMNS[0], DIRECTION_COLUMNS[1]];

struct Barlat {
    elastic: Elastic,
    orientation: Orientation,
    surface: BarlatSurface,
    hardening: Hardening,
}

fn build(material: &Material) -> LawResult {
    Parameters::new(material).shell_law(read)
}

fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<Barlat, Vec<Problem>> {
    let orientation = Orientation::read(&mut parameters);
    let m = parameters.optional("exponent", "2 or above", |m| m >= 2.0).unwrap_or(8.0);
    let mut ratio = |key| parameters.optional(key, "above 0", |r| r > 0.0).unwrap_or(1.0);
    let surface = BarlatSurface::new(m, RATIOS.map(&mut ratio));
    if surface.is_none() {
        let help = "use a ratio nearer to those at 0 and 90 degrees";
        parameters.wrong(RATIOS[1], "cannot be reached with this exponent", help);
    }
    let hardening = Hardening::read(&mut parameters);
    parameters.finish()?;
    let surface = surface.expect("its absence is a problem");
    Ok(Barlat { elastic, orientation, surface, hardening })
}

impl Barlat {
    /// Updates the points of a group of so many lanes; `lanes` makes one of their numbers.
    #[inline(always)]
    fn points<R: Real>(
        &self,
        points: Points<'_, R>,
        count: usize,
        lanes: impl Fn(&[f64; LANES32]) -> R,
    ) {
        let [c11, c12, g] = self.elastic.plane_stress();
        let (v11, v12, vg) = (R::splat(c11), R::splat(c12), R::splat(g));
        let thinning = R::splat(self.elastic.thinning());
        let [h, p] = self.surface.weights().map(R::splat);
        let bound = R::splat(self.surface.bound());
        let (half, one) = (R::splat(0.5), R::splat(1.0));
        let states = points.state.as_chunks_mut::<COLUMNS>().0;
        for ((state, eps), eps_z) in
            states.iter_mut().zip(points.strain).zip(points.thickness_strain)
        {
            let before = [state[0], state[1], state[2]];
            state[0] = v11.mul_add(eps[0], v12.mul_add(eps[1], before[0]));
            state[1] = v11.mul_add(eps[1], v12.mul_add(eps[0], before[1]));
            state[2] = vg.mul_add(eps[2], before[2]);

            // Lanes that certainly stay below the yield stress need no powers.
            let (c, s) = (state[COSINE] + one, state[SINE]);
            let trial = stress_along([state[0], state[1], state[2]], c, s);
            let u = half * (trial[0] - h * trial[1]);
            let t = p * trial[2];
            let most = (half * (trial[0] + h * trial[1])).abs() + u.mul_add(u, t * t).sqrt();
            let yield_stress = self.hardening.of_lanes(state[STRAIN], count, &lanes);
            let near = (bound * most).gt(yield_stress);
            if R::any(near) {
                let marks = R::select(near, one, R::zero());
                let before = stress_along(before, c, s);
                let mut after = [[0.0; LANES32]; 4];
                let [of_a, of_b, of_ab, of_strain] = &mut after;
                let numbers = of_a.iter_mut().zip(of_b).zip(of_ab).zip(of_strain).take(count);
                for (lane, (((a, b), ab), strain)) in numbers.enumerate() {
                    let of = |v: &[R; 3]| v.map(|x| x.lane(lane));
                    let plastic_strain = state[STRAIN].lane(lane);
                    let trial = of(&trial);
                    let mut now = YieldState { stress: trial, plastic_strain };
                    let [limit, _] = self.hardening.at(plastic_strain);
                    if marks.lane(lane) > 0.5 && self.surface.equivalent(trial) > limit {
                        let before = YieldState { stress: of(&before), plastic_strain };
                        let hardening = |strain| self.hardening.at(strain);
                        now = self.surface.returned(before, trial, [c11, c12, g], &hardening);
                    }
                    *a = now.stress[0] - trial[0];
                    *b = now.stress[1] - trial[1];
                    *ab = now.stress[2] - trial[2];
                    *strain = now.plastic_strain;
                }
                let [a, b, ab, strain] = after.each_ref().map(&lanes);
                // The increment is turned, not the stress, which would gather round-off.
                let more = stress_across([a, b, ab], c, s);
                (0..3).for_each(|k| state[k] += more[k]);
                state[STRAIN] = strain;
            }
            let change = (state[0] - before[0]) + (state[1] - before[1]);
            *eps_z = thinning.mul_add(change, -(eps[0] + eps[1]));
        }
    }
}

impl PlaneStress for Barlat {
    fn history(&self) -> &[&'static str] {
        &HISTORY
    }
    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn initial_yield_stress(&self) -> f64 {
        self.hardening.at(0.0)[0]
    }
    fn orientation(&self, _point: usize) -> Option<Orientation> {
        Some(self.orientation)
    }
    fn update(&self, points: Points<'_, Lane>, _dt: f64) {
        self.points(points, LANES, |all| Lane::from_array(std::array::from_fn(|k| all[k])));
    }
    fn update_short(&self, points: Points<'_, Lane32>, _dt: f64) {
        self.points(points, LANES32, |all| Lane32::from_array(*all));
    }
    fn update_one(&self, points: Points<'_, f64>, _dt: f64) {
        self.points(points, 1, |all| all[0]);
    }
}
