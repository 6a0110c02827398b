//! Linear viscoelasticity whose shear and bulk modulus decay as sums of exponentials (Prony
//! series), as in `*MAT_GENERAL_VISCOELASTIC`:
//! ```text
//! s = 2 int G(t - tau) e'(tau) d tau,    G(t) = sum G_k exp(-beta_k t)
//! p =   int K(t - tau) v'(tau) d tau,    K(t) = K + sum K_k exp(-gamma_k t)
//! ```
//! with the deviators s of the stress and e' of the strain rate, the mean stress p and the rate v'
//! of the volume strain. A term with a rate of zero is elastic.
//!
//! Exact for a constant strain rate in the step: each term that decays has its own part of the
//! stress, `v <- r v + 2 G_k w e`, `r = exp(-x)`, `w = (1 - r)/x`, `x = beta_k dt`. In plane stress
//! the strain through the thickness removes the stress there; the equation for it is linear.
//!
//! Valid for small strains and large rotations. Forces that an element computes from the elastic
//! constants do not relax: transverse shear, hourglass, drilling.
//!
//! Left out: times that shift with the temperature or the moisture, fits to tests.

use super::parameters::Parameters;
use super::{
    DefaultValue, Elastic, Form, Law, LawResult, ParameterRow, PlaneStress, Points, Solid,
    SolidLawResult, SolidPoint,
};
use crumple_math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;

const BULK: &str = "bulk_modulus";
const SHEAR_TERMS: &str = "shear_terms";
const BULK_TERMS: &str = "bulk_terms";
const FORM: &str = "[[modulus, decay rate], ...]";

/// Most terms of a series that decay.
const MOST_TERMS: usize = 18;

/// The row of this law.
pub const LAW: Law = Law {
    name: "general_viscoelastic",
    meaning: "Linear viscoelasticity with sums of decays of the shear and of the bulk modulus.",
    constants: &[ParameterRow {
        key: BULK,
        form: Form::Number,
        otherwise: DefaultValue::Needed,
        range: None,
        meaning: "Bulk modulus that does not decay, 0 or above [force/length^2].",
    }],
    parameters: &[
        ParameterRow {
            key: SHEAR_TERMS,
            form: Form::List(FORM),
            otherwise: DefaultValue::Needed,
            range: None,
            meaning: "Parts of the shear modulus [force/length^2] and the rates at which they \
                      decay [1/time]; a rate of 0 is a part that stays.",
        },
        ParameterRow {
            key: BULK_TERMS,
            form: Form::List(FORM),
            otherwise: DefaultValue::Absent,
            range: None,
            meaning: "The same for the bulk modulus, next to `bulk_modulus`.",
        },
    ],
    build: Some(build),
    solid: Some(solid),
    cohesive: None,
};

/// A part of a modulus that decays.
#[derive(Clone, Copy)]
struct PronyTerm {
    /// Modulus [force/length^2].
    modulus: f64,
    /// Rate of its decay, above 0 [1/time].
    rate: f64,
}

impl PronyTerm {
    /// Returns what a step `dt` [time] takes from the stress of the term, as a fraction, and the
    /// modulus of a strain of the step [force/length^2].
    #[inline(always)]
    fn over_step<R: Real>(&self, dt: f64) -> [R; 2] {
        let x = dt * self.rate;
        let lost = -(-x).exp_m1();
        let mean = if x > 0.0 { lost / x } else { 1.0 };
        [lost, mean * self.modulus].map(R::splat)
    }
}

/// A modulus: what stays, and terms that decay.
struct PronySeries {
    /// The part that stays [force/length^2].
    elastic: f64,
    terms: Vec<PronyTerm>,
}

impl PronySeries {
    /// Returns the modulus of fast loads [force/length^2].
    fn fast(&self) -> f64 {
        self.elastic + self.terms.iter().map(|term| term.modulus).sum::<f64>()
    }
}

struct GeneralViscoelastic {
    elastic: Elastic,
    shear: PronySeries,
    bulk: PronySeries,
    /// Columns of shells and of solids.
    columns: [Vec<&'static str>; 2],
}

/// Names of the columns of the stress of a term of the shear modulus, in the order of solids, and
/// that of its mean stress if it is one of the bulk modulus.
macro_rules! names {
    ($($k:literal),*) => {
        [$((
            [
                concat!("decaying ", $k, " xx"),
                concat!("decaying ", $k, " yy"),
                concat!("decaying ", $k, " zz"),
                concat!("decaying ", $k, " xy"),
                concat!("decaying ", $k, " yz"),
                concat!("decaying ", $k, " zx"),
            ],
            concat!("decaying mean ", $k),
        )),*]
    };
}

const NAMES: [([&str; 6], &str); MOST_TERMS] =
    names!(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18);

fn build(material: &Material) -> LawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

fn solid(material: &Material) -> SolidLawResult {
    Ok(Box::new(read(Parameters::new(material))?))
}

fn read(mut parameters: Parameters<'_>) -> Result<GeneralViscoelastic, Vec<Problem>> {
    let density = parameters.density();
    let bulk = parameters.required(BULK, "0 or above", |k| k >= 0.0);
    if !parameters.given(SHEAR_TERMS) {
        parameters.wrong(SHEAR_TERMS, "is missing", format!("give {FORM}"));
    }
    let shear = series(&mut parameters, SHEAR_TERMS, 0.0);
    let bulk = series(&mut parameters, BULK_TERMS, bulk);
    let [g, k] = [shear.fast(), bulk.fast()];
    if parameters.given(SHEAR_TERMS) && g <= 0.0 {
        parameters.wrong(SHEAR_TERMS, "has no modulus above 0", "give a modulus above 0");
    }
    if k <= 0.0 {
        let help = "give a modulus above 0, or bulk_terms with one";
        parameters.wrong(BULK, format_args!("is {k} with all terms"), help);
    }
    parameters.finish()?;
    let elastic = Elastic {
        youngs_modulus: 9.0 * k * g / (3.0 * k + g),
        poisson: (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g)),
        density,
    };
    let of_term = |in_plane: bool| {
        NAMES[..shear.terms.len()].iter().flat_map(move |(tensor, _)| {
            let kept = [0, 1, 3].into_iter().filter(move |_| in_plane);
            kept.chain((0..6).filter(move |_| !in_plane)).map(|c| tensor[c])
        })
    };
    let of_mean = || NAMES[..bulk.terms.len()].iter().map(|(_, mean)| *mean);
    let columns = [true, false].map(|in_plane| of_term(in_plane).chain(of_mean()).collect());
    Ok(GeneralViscoelastic { elastic, shear, bulk, columns })
}

/// Reads a series; `elastic` is added to what stays.
fn series(parameters: &mut Parameters<'_>, key: &'static str, elastic: f64) -> PronySeries {
    let rows = parameters.rows::<2>(key, FORM).unwrap_or_default();
    if rows.iter().flatten().any(|x| *x < 0.0) {
        let help = "give moduli and rates of 0 or above: other ones would give energy";
        parameters.wrong(key, "has a number below 0", help);
    }
    let (stays, decays): (Vec<[f64; 2]>, Vec<[f64; 2]>) =
        rows.iter().partition(|row| row[1] == 0.0);
    let terms: Vec<PronyTerm> = decays
        .iter()
        .filter(|row| row[0] != 0.0)
        .map(|row| PronyTerm { modulus: row[0], rate: row[1] })
        .collect();
    if terms.len() > MOST_TERMS {
        let what = format!("has {} terms that decay", terms.len());
        parameters.wrong(key, what, format!("give {MOST_TERMS} at most"));
    }
    let elastic = elastic + stays.iter().map(|row| row[0]).sum::<f64>();
    PronySeries { elastic, terms: terms.into_iter().take(MOST_TERMS).collect() }
}

impl GeneralViscoelastic {
    #[inline(always)]
    fn solid<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let eps = point.strain;
        let volume = eps[0] + eps[1] + eps[2];
        let third = R::splat(1.0 / 3.0) * volume;
        let two = R::splat(2.0);
        // Twice the deviator of the strain.
        let twice: [R; 6] =
            std::array::from_fn(|c| if c < 3 { two * (eps[c] - third) } else { eps[c] });
        let (stress, history) = point.state.split_at_mut(6);
        let (tensors, means) = history.split_at_mut(6 * self.shear.terms.len());
        let mut mean = R::splat(self.bulk.elastic) * volume;
        for (term, old) in self.bulk.terms.iter().zip(means) {
            let [lost, modulus] = term.over_step::<R>(dt);
            let change = modulus.mul_add(volume, -(lost * *old));
            *old += change;
            mean += change;
        }
        let elastic = R::splat(self.shear.elastic);
        let mut more = twice.map(|e| elastic * e);
        let (tensors, _) = tensors.as_chunks_mut::<6>();
        for (term, old) in self.shear.terms.iter().zip(tensors) {
            let [lost, modulus] = term.over_step::<R>(dt);
            for c in 0..6 {
                let change = modulus.mul_add(twice[c], -(lost * old[c]));
                old[c] += change;
                more[c] += change;
            }
        }
        for c in 0..6 {
            stress[c] += if c < 3 { more[c] + mean } else { more[c] };
        }
        R::splat(1.0)
    }

    #[inline(always)]
    fn shell<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let count = self.shear.terms.len();
        let stride = 3 + 3 * count + self.bulk.terms.len();
        let [two, third] = [2.0, 1.0 / 3.0].map(R::splat);
        let fresh = |series: &PronySeries| {
            let each = series.terms.iter().map(|term| term.over_step::<R>(dt)[1]);
            each.fold(R::splat(series.elastic), |sum, modulus| sum + modulus)
        };
        let (shear, bulk) = (fresh(&self.shear), fresh(&self.bulk));
        let through = R::splat(1.0) / R::splat(4.0 / 3.0).mul_add(shear, bulk);
        let coupling = R::splat(2.0 / 3.0).neg_mul_add(shear, bulk);
        let states = points.state.chunks_exact_mut(stride);
        for ((state, eps), eps_z) in states.zip(points.strain).zip(points.thickness_strain) {
            let (stress, history) = state.split_at_mut(3);
            let (tensors, means) = history.split_at_mut(3 * count);
            let (tensors, _) = tensors.as_chunks_mut::<3>();
            // Stress through the thickness that the terms lose.
            let mut lost_z = R::zero();
            for (term, old) in self.shear.terms.iter().zip(&*tensors) {
                lost_z -= term.over_step::<R>(dt)[0] * (old[0] + old[1]);
            }
            for (term, old) in self.bulk.terms.iter().zip(&*means) {
                lost_z += term.over_step::<R>(dt)[0] * *old;
            }
            let in_plane = eps[0] + eps[1];
            *eps_z = through * (lost_z - coupling * in_plane);
            let volume = in_plane + *eps_z;
            let deviator = third * volume;
            let twice = [two * (eps[0] - deviator), two * (eps[1] - deviator), eps[2]];
            let mut mean = R::splat(self.bulk.elastic) * volume;
            for (term, old) in self.bulk.terms.iter().zip(means) {
                let [lost, modulus] = term.over_step::<R>(dt);
                let change = modulus.mul_add(volume, -(lost * *old));
                *old += change;
                mean += change;
            }
            let elastic = R::splat(self.shear.elastic);
            let mut more = twice.map(|e| elastic * e);
            for (term, old) in self.shear.terms.iter().zip(tensors) {
                let [lost, modulus] = term.over_step::<R>(dt);
                for c in 0..3 {
                    let change = modulus.mul_add(twice[c], -(lost * old[c]));
                    old[c] += change;
                    more[c] += change;
                }
            }
            for c in 0..3 {
                stress[c] += if c < 2 { more[c] + mean } else { more[c] };
            }
        }
    }
}

impl PlaneStress for GeneralViscoelastic {
    fn history(&self) -> &[&'static str] {
        &self.columns[0]
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

impl Solid for GeneralViscoelastic {
    fn history(&self) -> &[&'static str] {
        &self.columns[1]
    }
    fn tensors(&self) -> usize {
        self.shear.terms.len()
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
#[path = "prony_tests.rs"]
mod tests;
