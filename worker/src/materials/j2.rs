//! J2 (von Mises) plasticity with isotropic hardening in plane stress.
//!
//! Projected return of Simo & Hughes 1998, box 3.3. With `s = sig_x + sig_y`, `d = sig_y - sig_x`, `t = sig_xy` of
//! the elastic trial and the multiplier `x` [length^2/force],
//! ```text
//! sig_vm^2(x) = (s^2/4) / A^2 + (3/4 d^2 + 3 t^2) / B^2,   A = 1 + E x / (3 (1-nu)),   B = 1 + 2 G x
//! d eps_p     = 2/3 x sig_vm,                              sig_vm(x) = sig_y(eps_p + d eps_p)
//! s <- s / A,   d <- d / B,   t <- t / B
//! ```
//! so the returned stress lies on the yield surface, whatever the size of the step. The equation is solved for
//! `1/sig_vm = 1/sig_y`: in pure shear and in equal biaxial stress the left side is linear in x, elsewhere nearly,
//! so that Newton needs one or two steps.
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
use super::{Elastic, Law, MAX_POINTS, PlaneStress, Points};
use crate::lanes::{Lane, Real};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// The row of this law.
pub const LAW: Law = Law { name: "j2", build };

/// Columns per point: stress xx, yy, xy, effective plastic strain.
const COLUMNS: usize = 4;
/// How near the yield surface a returned stress has to be, as a fraction of the yield stress.
const TOLERANCE: f64 = 1e-10;
/// Newton steps before bisection takes over. Two or three do, unless a table turns up sharply.
const NEWTON_STEPS: usize = 20;
/// Halvings of the bracket; 60 leave nothing of it.
const BISECTIONS: usize = 60;

struct J2 {
    elastic: Elastic,
    /// Yield stress at no plastic strain [force/length^2].
    yield_stress: f64,
    /// Slope there [force/length^2].
    slope: f64,
    /// Plastic strains where the slope changes, and by how much [force/length^2].
    ramps: Vec<(f64, f64)>,
    /// C [1/time] and 1/p.
    rate: Option<(f64, f64)>,
}

fn build(material: &Material) -> Result<Box<dyn PlaneStress>, Vec<Problem>> {
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
    Ok(Box::new(J2 { elastic, yield_stress, slope, ramps, rate }))
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

/// A trial stress being returned, and where it has got to.
#[derive(Clone, Copy)]
struct Return<R> {
    /// `s^2/4` and `3/4 d^2 + 3 t^2` of the trial [force^2/length^4].
    p: R,
    q: R,
    /// Plastic strain before the step.
    eps_p: R,
    /// Factor of the rate on the yield stress.
    scale: R,
    /// Multiplier [length^2/force].
    x: R,
    /// 1/A and 1/B at x.
    inv_a: R,
    inv_b: R,
}

impl J2 {
    /// Yield stress and plastic modulus at a plastic strain. Ramps instead of a search: no lane waits for another.
    #[inline(always)]
    fn yield_curve<R: Real>(&self, eps_p: R) -> (R, R) {
        let mut modulus = R::splat(self.slope);
        let mut sig_y = modulus.mul_add(eps_p, R::splat(self.yield_stress));
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
        // Where nothing is strained the power would be that of nought, which is nought: no lane needs a special case.
        R::select(mask, R::splat(1.0) + rate.powf_where(inv_p, mask), R::splat(1.0))
    }

    fn stress<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        let [c11, c12, g] = self.elastic.plane_stress().map(R::splat);
        let [quarter, three_quarters, three] = [0.25, 0.75, 3.0].map(R::splat);
        let thinning = R::splat(self.elastic.thinning());
        let zero = R::zero();
        let (states, _) = points.state.as_chunks_mut::<COLUMNS>();
        let n = points.strain.len().min(MAX_POINTS);

        // 1. Elastic trial, and which lanes yield.
        let idle = Return { p: zero, q: zero, eps_p: zero, scale: zero, x: zero, inv_a: zero, inv_b: zero };
        let mut returns = [idle; MAX_POINTS];
        let mut yields = [zero.gt(zero); MAX_POINTS];
        let mut any = false;
        for k in 0..n {
            let (state, eps) = (&mut states[k], points.strain[k]);
            let dx = c11.mul_add(eps[0], c12 * eps[1]);
            let dy = c11.mul_add(eps[1], c12 * eps[0]);
            state[0] += dx;
            state[1] += dy;
            state[2] = g.mul_add(eps[2], state[2]);
            points.thickness_strain[k] = thinning.mul_add(dx + dy, -(eps[0] + eps[1]));
            let (s, d) = (state[0] + state[1], state[1] - state[0]);
            let p = quarter * s * s;
            let q = three_quarters.mul_add(d * d, three * state[2] * state[2]);
            let sig_y = self.yield_curve(state[3]).0;
            yields[k] = (p + q).gt(sig_y * sig_y);
            let mut scale = R::splat(1.0);
            if self.rate.is_some() && R::any(yields[k]) {
                scale = self.rate_factor(eps, dt, yields[k]);
                let scaled = scale * sig_y;
                yields[k] = (p + q).gt(scaled * scaled);
            }
            returns[k] = Return { p, q, eps_p: state[3], scale, ..idle };
            any |= R::any(yields[k]);
        }
        if !any {
            return;
        }

        // 2. Multiplier of each lane; all points together, as they do not wait for one another.
        self.newton(&mut returns[..n], &yields[..n]);

        // 3. Return.
        let (half, two_thirds) = (R::splat(0.5), R::splat(2.0 / 3.0));
        for k in 0..n {
            let (state, back, yields) = (&mut states[k], &returns[k], yields[k]);
            let sig_vm = back.p.mul_add(back.inv_a * back.inv_a, back.q * back.inv_b * back.inv_b).sqrt();
            let s0 = state[0] + state[1];
            let s = s0 * back.inv_a;
            let d = (state[1] - state[0]) * back.inv_b;
            state[0] = R::select(yields, half * (s - d), state[0]);
            state[1] = R::select(yields, half * (s + d), state[1]);
            state[2] = R::select(yields, state[2] * back.inv_b, state[2]);
            state[3] = R::select(yields, two_thirds.mul_add(back.x * sig_vm, state[3]), state[3]);
            let eps_z = points.thickness_strain[k];
            points.thickness_strain[k] = R::select(yields, thinning.mul_add(s - s0, eps_z), eps_z);
        }
    }

    /// Newton on `1/sig_vm = 1/sig_y` from x = 0; a lane that has arrived is frozen.
    #[inline(always)]
    fn newton<R: Real>(&self, returns: &mut [Return<R>], yields: &[R::Mask]) {
        for _ in 0..NEWTON_STEPS {
            let mut any = false;
            for (back, &yields) in returns.iter_mut().zip(yields) {
                let (active, step) = self.newton_step(back, yields);
                any |= R::any(active);
                back.x = R::select(active, back.x + step, back.x);
            }
            if !any {
                return;
            }
        }
        for (back, &yields) in returns.iter_mut().zip(yields) {
            self.bisect(back, yields);
        }
    }

    /// Evaluates at x: which lanes are not on the surface yet, and the step that would take them there.
    #[inline(always)]
    fn newton_step<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) -> (R::Mask, R) {
        let (a, b) = self.moduli();
        let (a, b) = (R::splat(a), R::splat(b));
        let one = R::splat(1.0);
        let (big_a, big_b) = (a.mul_add(back.x, one), b.mul_add(back.x, one));
        let inv = one / (big_a * big_b);
        back.inv_a = inv * big_b;
        back.inv_b = inv * big_a;
        let p = back.p * back.inv_a * back.inv_a;
        let q = back.q * back.inv_b * back.inv_b;
        let u = p + q;
        let sig_vm = u.sqrt();
        let two_thirds = R::splat(2.0 / 3.0);
        let (sig_y, modulus) = self.yield_curve(two_thirds.mul_add(back.x * sig_vm, back.eps_p));
        let (sig_y, modulus) = (sig_y * back.scale, modulus * back.scale);
        let f = sig_vm - sig_y;
        // -d(sig_vm^2)/dx / 2, then the step on 1/sig_vm - 1/sig_y with its one division gathered.
        let w = a.mul_add(p * back.inv_a, b * q * back.inv_b);
        let below = w.mul_add(sig_y * sig_y, two_thirds * modulus * u * back.x.neg_mul_add(w, u));
        let step = f * u * sig_y / below;
        (R::both(yields, f.abs().gt(R::splat(TOLERANCE) * sig_y)), step)
    }

    /// Halves the bracket between x = 0, which is outside the surface, and an x that is inside for sure.
    #[cold]
    fn bisect<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) {
        let (a, b) = self.moduli();
        let sig_trial = (back.p + back.q).sqrt();
        let mut low = R::zero();
        // sig_vm(x) <= sig_trial / (1 + min(a, b) x), and the yield stress only grows.
        let mut high = sig_trial / R::splat(self.yield_stress * a.min(b));
        // Lanes that Newton brought home stay there: the state of each comes from its own x alone.
        let (wanting, _) = self.newton_step(back, yields);
        let kept = back.x;
        for _ in 0..BISECTIONS {
            back.x = R::splat(0.5) * (low + high);
            let (_, step) = self.newton_step(back, yields);
            let outside = step.gt(R::zero());
            low = R::select(outside, back.x, low);
            high = R::select(outside, high, back.x);
        }
        back.x = R::select(wanting, back.x, kept);
        self.newton_step(back, yields);
    }

    /// Slopes of A and B in x [force/length^2].
    #[inline(always)]
    fn moduli(&self) -> (f64, f64) {
        (self.elastic.youngs_modulus / (3.0 * (1.0 - self.elastic.poisson)), 2.0 * self.elastic.shear_modulus())
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
