//! J2 (von Mises) plasticity with isotropic hardening: in plane stress (`plane_stress`), in three dimensions (`solid`).
//! Both return the elastic trial to the yield surface along the flow rule, whatever the size of the step.
//!
//! Yield stress `sig_y(eps_p)` [force/length^2], one of
//! - `yield_stress` and, if wanted, the plastic modulus `hardening_modulus`: `yield_stress + hardening_modulus eps_p`;
//! - `hardening = [[eps_p, sigma], ...]`: straight lines between points, constant beyond the last.
//!
//! `cowper_symonds = [C, p]` (Cowper & Symonds 1957) multiplies it by `1 + (rate/C)^(1/p)`; the rate is that of the
//! total effective strain over the step, `sqrt(2/3 e:e)/dt` with the deviator e of the increment (in plane stress taken
//! as isochoric, so `e:e = 2 (e_x^2 + e_y^2 + e_x e_y + e_xy^2)`).
//! It is not filtered and does not count while the trial is below the static yield stress.
//!
//! Left out: kinematic hardening, failure, transverse shear in the yield condition (as in most shell codes).

mod plane_stress;
mod solid;

use super::parameters::Parameters;
use super::{Built, BuiltSolid, Elastic, Law};
use crate::lanes::Real;
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law { name: "j2", build, solid };

/// How near the yield surface a returned stress has to be, as a fraction of the yield stress.
const TOLERANCE: f64 = 1e-10;
struct J2 {
    elastic: Elastic,
    /// Yield stress at no plastic strain [force/length^2]. The return works in units of it, in which its powers
    /// neither overflow nor vanish, whatever the units of the job.
    yield_stress: f64,
    /// Slope there, in yield stresses.
    slope: f64,
    /// Plastic strains where the slope changes, and by how much, in yield stresses.
    ramps: Vec<(f64, f64)>,
    /// C [1/time] and 1/p.
    rate: Option<(f64, f64)>,
}

fn build(material: &Material) -> Built {
    let mut parameters = Parameters::new(material);
    let elastic = parameters.elastic();
    Ok(Box::new(read(parameters, elastic)?))
}

fn solid(material: &Material) -> BuiltSolid {
    let mut parameters = Parameters::new(material);
    let elastic = parameters.solid_elastic();
    Ok(Box::new(read(parameters, elastic)?))
}

/// The law with what is left to read.
fn read(mut parameters: Parameters<'_>, elastic: Elastic) -> Result<J2, Vec<Problem>> {
    let (yield_stress, slope, ramps) = hardening(&mut parameters);
    let rate = match parameters.get("cowper_symonds") {
        None => None,
        Some(Param::List(list)) if list.len() == 2 && list.iter().all(|v| v.is_finite() && *v > 0.0) => {
            Some((list[0], 1.0 / list[1]))
        }
        Some(_) => {
            parameters.wrong("cowper_symonds", "is not [C, p]", "give two numbers above 0: C in 1/time, and p");
            None
        }
    };
    parameters.finish()?;
    Ok(J2::new(elastic, yield_stress, slope, &ramps, rate))
}

/// Yield stress, first slope, and changes of slope.
fn hardening(parameters: &mut Parameters<'_>) -> (f64, f64, Vec<(f64, f64)>) {
    const TABLE: &str = "hardening";
    let yield_stress = parameters.optional("yield_stress", "above 0", |y| y > 0.0);
    let modulus = parameters.optional("hardening_modulus", "0 or above", |h| h >= 0.0);
    let single = parameters.given("yield_stress") || parameters.given("hardening_modulus");
    let Some(table) = parameters.get(TABLE) else {
        if !parameters.given("yield_stress") {
            let help = "give it, with hardening_modulus if it hardens, or give the table `hardening`";
            parameters.wrong("yield_stress", "is missing", help);
        }
        return (yield_stress.unwrap_or(1.0), modulus.unwrap_or(0.0), Vec::new());
    };
    if single {
        parameters.wrong(TABLE, "stands beside yield_stress or hardening_modulus", "give one or the other");
    }
    let rows: Vec<[f64; 2]> = match table {
        Param::Table(rows) => rows.iter().filter_map(|row| row.as_slice().try_into().ok()).collect(),
        _ => Vec::new(),
    };
    let complete = matches!(table, Param::Table(all) if !all.is_empty() && all.len() == rows.len());
    let fault = if !complete || rows.iter().flatten().any(|value| !value.is_finite()) {
        Some("is not a table of pairs")
    } else if rows[0][0] != 0.0 {
        Some("does not start at plastic strain 0")
    } else if rows.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
        Some("has plastic strains that do not rise from row to row")
    } else if rows[0][1] <= 0.0 || rows.windows(2).any(|pair| pair[1][1] < pair[0][1]) {
        Some("has a stress that is not above 0 or falls from one row to the next")
    } else {
        None
    };
    if let Some(fault) = fault {
        parameters.wrong(TABLE, fault, "give [[0, sigma], [eps_p, sigma], ...] with rising plastic strain");
        return (1.0, 0.0, Vec::new());
    }
    let mut slopes: Vec<f64> = rows.windows(2).map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).collect();
    slopes.push(0.0);
    let ramps = rows[1..].iter().zip(slopes.windows(2)).map(|(row, s)| (row[0], s[1] - s[0])).collect();
    (rows[0][1], slopes[0], ramps)
}

impl J2 {
    /// From stresses in the job's units.
    fn new(elastic: Elastic, yield_stress: f64, slope: f64, ramps: &[(f64, f64)], rate: Option<(f64, f64)>) -> Self {
        let ramps = ramps.iter().map(|&(start, change)| (start, change / yield_stress)).collect();
        Self { elastic, yield_stress, slope: slope / yield_stress, ramps, rate }
    }

    /// Yield stress and plastic modulus at a plastic strain. Ramps instead of a search: no lane waits for another.
    #[inline(always)]
    fn yield_curve<R: Real>(&self, eps_p: R) -> (R, R) {
        let mut modulus = R::splat(self.slope);
        let mut sig_y = modulus.mul_add(eps_p, R::splat(1.0));
        for &(start, change) in &self.ramps {
            let beyond = eps_p - R::splat(start);
            let change = R::select(beyond.gt(R::zero()), R::splat(change), R::zero());
            sig_y = change.mul_add(beyond, sig_y);
            modulus += change;
        }
        (sig_y, modulus)
    }

    /// Factor of Cowper and Symonds in the lanes of `mask`, one elsewhere; `square` is `e:e` of the strain increment's
    /// deviator.
    #[inline(always)]
    fn rate_factor<R: Real>(&self, square: R, dt: f64, mask: R::Mask) -> R {
        let Some((c, inv_p)) = self.rate else { return R::splat(1.0) };
        let rate = (R::splat(2.0 / 3.0) * square).sqrt() * R::splat(1.0 / (dt * c));
        R::select(mask, R::splat(1.0) + rate.powf_where(inv_p, mask), R::splat(1.0))
    }
}
