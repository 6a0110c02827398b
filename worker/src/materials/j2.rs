//! J2 (von Mises) plasticity with isotropic hardening in plane stress.
//!
//! Projected return of Simo & Hughes 1998, box 3.3. With `s = sig_x + sig_y`, `d = sig_y - sig_x`, `t = sig_xy` of
//! the elastic trial and the multiplier `x` [length^2/force],
//! ```text
//! sig_vm^2(x) = p / A^2 + q / B^2,   p = s^2/4,   q = 3/4 d^2 + 3 t^2,   A = 1 + E x / (3 (1-nu)),   B = 1 + 2 G x
//! y = d eps_p = 2/3 x sig_vm,        sig_vm(x) = sig_y(eps_p + y)
//! s <- s / A,   d <- d / B,   t <- t / B
//! ```
//! so the returned stress lies on the yield surface, whatever the size of the step. At the solution `x` is
//! `3/2 y / sig_y`, which makes it an equation for y without roots and with two functions that are linear in y
//! wherever hardening is:
//! ```text
//! v(y) = p / alpha^2 + q / beta^2 = 1,   alpha = sig_y + E y / (2 (1-nu)),   beta = sig_y + 3 G y
//! ```
//! Its solver takes Halley steps on `1/sqrt(v) = 1`, which is linear in pure shear and in equal biaxial stress and
//! nearly so elsewhere, with `sqrt(v)` as the rational function that agrees to the fourth power of v - 1.
//! Two or three steps reach 1e-10 of the yield stress.
//!
//! Yield stress `sig_y(eps_p)` [force/length^2], one of
//! - `yield_stress` and, if wanted, the plastic modulus `hardening_modulus`: `yield_stress + hardening_modulus eps_p`;
//! - `hardening = [[eps_p, sigma], ...]`: straight lines between points, constant beyond the last.
//!
//! `cowper_symonds = [C, p]` (Cowper & Symonds 1957) multiplies it by `1 + (rate/C)^(1/p)`; the rate is that of the
//! total effective strain, taken as isochoric, over the step: `sqrt(4/3 (e_x^2 + e_y^2 + e_x e_y + e_xy^2))/dt`.
//! It is not filtered and does not count while the trial is below the static yield stress.
//!
//! Left out: kinematic hardening, failure, transverse shear in the yield condition (as in most shell codes).

use super::parameters::Parameters;
use super::{Built, BuiltSolid, Elastic, Law, MAX_POINTS, PlaneStress, Points};
use crate::lanes::{Lane, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law { name: "j2", build, solid };

/// Columns per point: stress xx, yy, xy, effective plastic strain.
const COLUMNS: usize = 4;
/// How near the yield surface a returned stress has to be, as a fraction of the yield stress.
const TOLERANCE: f64 = 1e-10;
/// Halley steps before bisection takes over. Two or three do, unless a table turns up sharply.
const HALLEY_STEPS: usize = 20;
/// Halvings of the bracket; 60 leave nothing of it.
const BISECTIONS: usize = 60;

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
    Ok(Box::new(J2::new(elastic, yield_stress, slope, &ramps, rate)))
}

fn solid(material: &Material) -> BuiltSolid {
    let message = format!("material '{}': law 'j2' is for shells only", material.name);
    Err(vec![Problem::error("law", message, "give solids another law")])
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

/// A trial stress being returned, and where it has got to. Stresses in units of the initial yield stress.
#[derive(Clone, Copy)]
struct Return<R> {
    /// p and q of the trial.
    p: R,
    q: R,
    /// Plastic strain before the step.
    eps_p: R,
    /// Factor of the rate on the yield stress.
    scale: R,
    /// Increment of plastic strain.
    y: R,
}

/// The two denominators of v, the yield stress in them, and their slopes in y.
struct Denominators<R> {
    sig_y: R,
    alpha: R,
    beta: R,
    d_alpha: R,
    d_beta: R,
}

impl J2 {
    /// From stresses in the job's units.
    fn new(elastic: Elastic, yield_stress: f64, slope: f64, ramps: &[(f64, f64)], rate: Option<(f64, f64)>) -> Self {
        let ramps = ramps.iter().map(|&(start, change)| (start, change / yield_stress)).collect();
        Self { elastic, yield_stress, slope: slope / yield_stress, ramps, rate }
    }

    /// Slopes of alpha and beta in y beside hardening, in yield stresses.
    #[inline(always)]
    fn moduli(&self) -> [f64; 2] {
        let Elastic { youngs_modulus, poisson, .. } = self.elastic;
        [0.5 * youngs_modulus / (1.0 - poisson), 3.0 * self.elastic.shear_modulus()].map(|m| m / self.yield_stress)
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

    /// Factor of Cowper and Symonds in the lanes of `mask`, one elsewhere.
    #[inline(always)]
    fn rate_factor<R: Real>(&self, eps: [R; 3], dt: f64, mask: R::Mask) -> R {
        let Some((c, inv_p)) = self.rate else { return R::splat(1.0) };
        let e_xy = R::splat(0.5) * eps[2];
        let sum = eps[0].mul_add(eps[0] + eps[1], eps[1].mul_add(eps[1], e_xy * e_xy));
        let rate = (R::splat(4.0 / 3.0) * sum).sqrt() * R::splat(1.0 / (dt * c));
        R::select(mask, R::splat(1.0) + rate.powf_where(inv_p, mask), R::splat(1.0))
    }

    /// All points of a group.
    #[inline(always)]
    fn stress<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let [c11, c12, g] = self.elastic.plane_stress().map(R::splat);
        let per_yield2 = 1.0 / (self.yield_stress * self.yield_stress);
        let [of_s, of_d, of_t] = [0.25, 0.75, 3.0].map(|factor| R::splat(factor * per_yield2));
        let thinning = R::splat(self.elastic.thinning());
        let zero = R::zero();
        let n = points.strain.len().min(MAX_POINTS);
        let (strain, thickness_strain) = (&points.strain[..n], &mut points.thickness_strain[..n]);
        let states = &mut points.state.as_chunks_mut::<COLUMNS>().0[..n];

        // 1. Elastic trial, and which lanes yield.
        let idle = Return { p: zero, q: zero, eps_p: zero, scale: R::splat(1.0), y: zero };
        let mut returns = [idle; MAX_POINTS];
        let mut yields = [zero.gt(zero); MAX_POINTS];
        let (returns, yields) = (&mut returns[..n], &mut yields[..n]);
        let mut any = false;
        for k in 0..n {
            let (state, eps) = (&mut states[k], strain[k]);
            let dx = c11.mul_add(eps[0], c12 * eps[1]);
            let dy = c11.mul_add(eps[1], c12 * eps[0]);
            state[0] += dx;
            state[1] += dy;
            state[2] = g.mul_add(eps[2], state[2]);
            thickness_strain[k] = thinning.mul_add(dx + dy, -(eps[0] + eps[1]));
            let (s, d) = (state[0] + state[1], state[1] - state[0]);
            let p = of_s * s * s;
            let q = (of_d * d).mul_add(d, of_t * state[2] * state[2]);
            let sig_y = self.yield_curve(state[3]).0;
            let mut over = (p + q).gt(sig_y * sig_y);
            let mut scale = R::splat(1.0);
            if self.rate.is_some() && R::any(over) {
                scale = self.rate_factor(eps, dt, over);
                let scaled = scale * sig_y;
                over = (p + q).gt(scaled * scaled);
            }
            yields[k] = over;
            returns[k] = Return { p, q, eps_p: state[3], scale, y: zero };
            any |= R::any(over);
        }
        if !any {
            return;
        }

        // 2. Plastic strain of each lane; all points together, as they do not wait for one another.
        self.solve(returns, yields);

        // 3. Return.
        let half = R::splat(0.5);
        for k in 0..n {
            let (state, back, yields) = (&mut states[k], &returns[k], yields[k]);
            let Denominators { sig_y, alpha, beta, .. } = self.denominators(back);
            let both = sig_y / (alpha * beta);
            let (inv_a, inv_b) = (both * beta, both * alpha);
            let s0 = state[0] + state[1];
            let s = s0 * inv_a;
            let d = (state[1] - state[0]) * inv_b;
            state[0] = R::select(yields, half * (s - d), state[0]);
            state[1] = R::select(yields, half * (s + d), state[1]);
            state[2] = R::select(yields, state[2] * inv_b, state[2]);
            state[3] = R::select(yields, state[3] + back.y, state[3]);
            let eps_z = thickness_strain[k];
            thickness_strain[k] = R::select(yields, thinning.mul_add(s - s0, eps_z), eps_z);
        }
    }

    #[inline(always)]
    fn denominators<R: Real>(&self, back: &Return<R>) -> Denominators<R> {
        let [a, b] = self.moduli().map(R::splat);
        let (sig_y, modulus) = self.yield_curve(back.eps_p + back.y);
        let (sig_y, modulus) = (sig_y * back.scale, modulus * back.scale);
        Denominators {
            sig_y,
            alpha: a.mul_add(back.y, sig_y),
            beta: b.mul_add(back.y, sig_y),
            d_alpha: a + modulus,
            d_beta: b + modulus,
        }
    }

    /// Halley from y = 0; a lane that has arrived is frozen.
    #[inline(always)]
    fn solve<R: Real>(&self, returns: &mut [Return<R>], yields: &[R::Mask]) {
        for _ in 0..HALLEY_STEPS {
            let mut any = false;
            for (back, &yields) in returns.iter_mut().zip(yields) {
                any |= self.halley_step(back, yields);
            }
            if !any {
                return;
            }
        }
        for (back, &yields) in returns.iter_mut().zip(yields) {
            self.bisect(back, yields);
        }
    }

    /// Moves the lanes that are off the surface still; false if there were none.
    #[inline(always)]
    fn halley_step<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) -> bool {
        let Denominators { alpha, beta, d_alpha, d_beta, .. } = self.denominators(back);
        // v = n/d2 over the common denominator; sqrt(v) - 1 is half of v - 1 near the end.
        let (alpha2, beta2) = (alpha * alpha, beta * beta);
        let d2 = alpha2 * beta2;
        let n = back.p.mul_add(beta2, back.q * alpha2);
        let active = R::both(yields, (n - d2).abs().gt(R::splat(2.0 * TOLERANCE) * d2));
        if !R::any(active) {
            return false;
        }
        // -v'/2 = m/d^3 and v''/6 = z/d^4, but for the curvature of hardening.
        let (on_p, on_q) = (back.p * d_alpha * beta2, back.q * d_beta * alpha2);
        let m = on_p.mul_add(beta, on_q * alpha);
        let z = (on_p * d_alpha).mul_add(beta2, on_q * d_beta * alpha2);
        // Newton's step is top/below, with 4 (v^2 - 1)/(v^2 + 10 v + 5) for sqrt(v) - 1; then Halley's, with its one
        // division gathered.
        let d4 = d2 * d2;
        let e = n.mul_add(n, -d4);
        let top = R::splat(4.0) * n * alpha * beta * e;
        let below = R::splat(5.0).mul_add(d4, n.mul_add(n, R::splat(10.0) * n * d2)) * m;
        let curved = R::splat(6.0) * e * m.mul_add(m, -(z * n));
        let step = top * m / below.mul_add(m, curved);
        back.y = R::select(active, back.y + step, back.y);
        true
    }

    /// Halves the bracket between y = 0, which is outside the surface, and a y that is inside for sure.
    /// Lanes that arrived before stay where they are.
    #[cold]
    fn bisect<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) {
        let outside = |back: &Return<R>| {
            let Denominators { alpha, beta, .. } = self.denominators(back);
            let (alpha2, beta2) = (alpha * alpha, beta * beta);
            (back.p.mul_add(beta2, back.q * alpha2) - alpha2 * beta2, alpha2 * beta2)
        };
        let kept = back.y;
        let (off, scale) = outside(back);
        let wanting = R::both(yields, off.abs().gt(R::splat(2.0 * TOLERANCE) * scale));
        let mut low = R::zero();
        // alpha and beta are at least min(a, b) y, and v is 1 at the solution.
        let [a, b] = self.moduli();
        let mut high = (back.p + back.q).sqrt() * R::splat(1.0 / a.min(b));
        for _ in 0..BISECTIONS {
            back.y = R::splat(0.5) * (low + high);
            let out = outside(back).0.gt(R::zero());
            low = R::select(out, back.y, low);
            high = R::select(out, high, back.y);
        }
        back.y = R::select(wanting, back.y, kept);
    }
}

impl PlaneStress for J2 {
    fn history(&self) -> &'static [&'static str] {
        &["plastic_strain"]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.stress(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.stress(points, dt);
    }
}

#[cfg(test)]
#[path = "j2_tests.rs"]
mod tests;
