//! Plane stress: projected return of Simo & Hughes 1998, box 3.3. With `s = sig_x + sig_y`, `d =
//! sig_y - sig_x`, `t = sig_xy` of the elastic trial and the multiplier `x` [length^2/force],
//! ```text
//! sig_vm^2(x) = p / A^2 + q / B^2,   p = s^2/4,   q = 3/4 d^2 + 3 t^2,
//! A = 1 + E x / (3 (1-nu)),   B = 1 + 2 G x
//! y = d eps_p = 2/3 x sig_vm,        sig_vm(x) = sig_y(eps_p + y)
//! s <- s / A,   d <- d / B,   t <- t / B
//! ```
//! so the returned stress lies on the yield surface, for any size of step. At the solution `x` is
//! `3/2 y / sig_y`. This gives an equation for y without roots, with two functions that are
//! linear in y if hardening is linear:
//! ```text
//! v(y) = p / alpha^2 + q / beta^2 = 1,   alpha = sig_y + E y / (2 (1-nu)),   beta = sig_y + 3 G y
//! ```
//! With Lankford's coefficient R the factors 1/4 of p, 3/4 and 3 of q are `c`, `d` and `4 d`, with
//! `c = 1/(2 (1 + R))` and `d = (1 + 2 R) c` (Hill 1948, the same in all directions of the sheet);
//! then `alpha = sig_y + 2 c E y / (1-nu)`, `beta = sig_y + 4 d G y`.
//! Its solver uses Halley steps on `1/sqrt(v) = 1`, which is linear in pure shear and in equal
//! biaxial stress and nearly linear otherwise. `sqrt(v)` is the rational function that agrees to
//! the fourth power of v - 1. Two or three steps reach 1e-10 of the yield stress.

use super::{Coefficients, Damage, Plasticity, tolerance};
use crate::materials::{Elastic, MAX_POINTS, PlaneStress, Points};
use crumple_math::lanes::{Lane, Lane32, Real};

/// Columns of stress per point: xx, yy, xy.
const STRESS: usize = 3;
/// Column of the effective plastic strain.
const STRAIN: usize = STRESS;
/// Usual number of points. With a local array for no more than these, its initial values cost less.
const FEW: usize = 5;
/// Halley steps before bisection. Two or three are enough, unless a table steepens abruptly.
const HALLEY_STEPS: usize = 20;
/// Number of bisections; 60 reduce the bracket to round-off.
const BISECTIONS: usize = 60;

/// The return of a trial stress, in units of the initial yield stress.
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

impl Plasticity {
    /// Updates all points of a group, at most `MOST`, with `COLUMNS` columns each.
    #[inline(always)]
    fn stress<R: Real, const COLUMNS: usize, const MOST: usize>(
        &self,
        points: Points<'_, R>,
        dt: f64,
    ) {
        let Coefficients { plane_stress, thinning, per_yield2, anisotropy, .. } = self.coefficients;
        let [c11, c12, g] = plane_stress.map(R::splat);
        let [of_s, of_d, of_t] = anisotropy.factors().map(|factor| R::splat(factor * per_yield2));
        let thinning = R::splat(thinning);
        let zero = R::zero();
        let n = points.strain.len().min(MOST);
        let (strain, thickness_strain) = (&points.strain[..n], &mut points.thickness_strain[..n]);
        let states = &mut points.state.as_chunks_mut::<COLUMNS>().0[..n];
        // p and q of a stress.
        let squares = |state: &[R; COLUMNS]| {
            let (s, d) = (state[0] + state[1], state[1] - state[0]);
            [of_s * s * s, (of_d * d).mul_add(d, of_t * state[2] * state[2])]
        };

        // 1. Elastic trial, and the lanes that yield.
        let of_unit_strain = self.rate.of_unit_strain(dt);
        let mut yields = [zero.gt(zero); MOST];
        let mut scales = [R::splat(1.0); MOST];
        let mut any = false;
        for k in 0..n {
            let (state, eps) = (&mut states[k], strain[k]);
            let dx = c11.mul_add(eps[0], c12 * eps[1]);
            let dy = c11.mul_add(eps[1], c12 * eps[0]);
            state[0] += dx;
            state[1] += dy;
            state[2] = g.mul_add(eps[2], state[2]);
            thickness_strain[k] = thinning.mul_add(dx + dy, -(eps[0] + eps[1]));
            let [p, q] = squares(state);
            let sig_y = self.yield_curve(state[STRAIN]).0;
            let mut scale = self.thermal_factor(&state[STRAIN..]);
            let soft = scale * sig_y;
            let mut over = (p + q).gt(soft * soft);
            if self.rate.counts() && R::any(over) {
                scale = scale * self.rate_factor(square(eps), of_unit_strain, over);
                let scaled = scale * sig_y;
                over = (p + q).gt(scaled * scaled);
            }
            if COLUMNS > STRAIN + 1 {
                over = R::both(over, Self::alive(&state[STRAIN..]));
            }
            (yields[k], scales[k]) = (over, scale);
            any |= R::any(over);
        }
        if !any {
            if COLUMNS > STRAIN + 1 {
                states.iter_mut().for_each(|state| Self::zero_failed(state, STRAIN));
            }
            return;
        }

        // 2. Plastic strain of each lane, at all points together, since they are independent.
        // Elastic groups end before this: they need no trial in memory.
        let mut returns: [Return<R>; MOST] = std::array::from_fn(|k| {
            let state = &states[k.min(n - 1)];
            let [p, q] = squares(state);
            Return { p, q, eps_p: state[STRAIN], scale: scales[k], y: zero }
        });
        let (returns, yields) = (&mut returns[..n], &yields[..n]);
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
            let y = R::select(yields, back.y, zero);
            state[STRAIN] += y;
            let eps_z = thickness_strain[k];
            thickness_strain[k] = R::select(yields, thinning.mul_add(s - s0, eps_z), eps_z);
            if COLUMNS > STRAIN + 1 {
                let mean = R::splat(1.0 / 3.0 / self.yield_stress) * (state[0] + state[1]);
                let damage = Damage { y, sig_y, mean, square: square(strain[k]), dt };
                self.accumulate_damage(&damage, yields, &mut state[STRAIN..]);
                Self::zero_failed(state, STRAIN);
            }
        }
    }

    #[inline(always)]
    fn denominators<R: Real>(&self, back: &Return<R>) -> Denominators<R> {
        let [a, b] = self.coefficients.moduli.map(R::splat);
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

    /// Solves by Halley steps from y = 0. A converged lane does not change.
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

    /// Moves the lanes that are not converged. Returns false if there are none.
    #[inline(always)]
    fn halley_step<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) -> bool {
        let Denominators { mut alpha, mut beta, mut d_alpha, mut d_beta, .. } =
            self.denominators(back);
        let (mut p, mut q) = (back.p, back.q);
        if R::SHORT {
            // Use units of alpha: the powers up to the 18th of the trial stress below overflow
            // from 60 times yield.
            let unit = R::splat(1.0) / alpha;
            (alpha, beta) = (R::splat(1.0), beta * unit);
            (d_alpha, d_beta) = (d_alpha * unit, d_beta * unit);
            (p, q) = (p * unit * unit, q * unit * unit);
        }
        // v = n/d2 over the common denominator; sqrt(v) - 1 is half of v - 1 near the solution.
        let (alpha2, beta2) = (alpha * alpha, beta * beta);
        let d2 = alpha2 * beta2;
        let n = p.mul_add(beta2, q * alpha2);
        let active = R::both(yields, (n - d2).abs().gt(R::splat(2.0 * tolerance::<R>()) * d2));
        if !R::any(active) {
            return false;
        }
        // -v'/2 = m/d^3 and v''/6 = z/d^4, without the curvature of hardening.
        let (on_p, on_q) = (p * d_alpha * beta2, q * d_beta * alpha2);
        let m = on_p.mul_add(beta, on_q * alpha);
        let z = (on_p * d_alpha).mul_add(beta2, on_q * d_beta * alpha2);
        // Newton's step is top/below, with 4 (v^2 - 1)/(v^2 + 10 v + 5) for sqrt(v) - 1. Halley's
        // step follows, with a single division.
        let d4 = d2 * d2;
        let e = n.mul_add(n, -d4);
        let top = R::splat(4.0) * n * alpha * beta * e;
        let below = R::splat(5.0).mul_add(d4, n.mul_add(n, R::splat(10.0) * n * d2)) * m;
        let curved = R::splat(6.0) * e * m.mul_add(m, -(z * n));
        let step = top * m / below.mul_add(m, curved);
        back.y = R::select(active, back.y + step, back.y);
        true
    }

    /// Bisects the bracket between y = 0, which is outside the surface, and a y that is certainly
    /// inside. Converged lanes do not change.
    #[cfg_attr(target_arch = "nvptx64", inline(always))]
    #[cfg_attr(not(target_arch = "nvptx64"), cold)]
    fn bisect<R: Real>(&self, back: &mut Return<R>, yields: R::Mask) {
        let outside = |back: &Return<R>| {
            let Denominators { alpha, beta, .. } = self.denominators(back);
            let (alpha2, beta2) = (alpha * alpha, beta * beta);
            (back.p.mul_add(beta2, back.q * alpha2) - alpha2 * beta2, alpha2 * beta2)
        };
        let kept = back.y;
        let (off, scale) = outside(back);
        let wanting = R::both(yields, off.abs().gt(R::splat(2.0 * tolerance::<R>()) * scale));
        let mut low = R::zero();
        // alpha and beta are at least min(a, b) y, and v is 1 at the solution.
        let [a, b] = self.coefficients.moduli;
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

/// Returns `e:e` of the isochoric strain increment with these in-plane components.
#[inline(always)]
pub(super) fn square<R: Real>(eps: [R; 3]) -> R {
    let e_xy = R::splat(0.5) * eps[2];
    let sum = eps[0].mul_add(eps[0] + eps[1], eps[1].mul_add(eps[1], e_xy * e_xy));
    sum + sum
}

impl Plasticity {
    /// Updates the points of one element with COLUMNS columns each, at most N, as
    /// [`PlaneStress::update_one`] does, without a call through a table.
    #[inline(always)]
    pub fn update_points<R: Real, const N: usize, const COLUMNS: usize>(
        &self,
        points: Points<'_, R>,
        dt: f64,
    ) {
        self.stress::<R, COLUMNS, N>(points, dt);
    }

    #[inline(always)]
    fn points<R: Real>(&self, points: Points<'_, R>, dt: f64) {
        match (self.names().len(), points.strain.len() <= FEW) {
            (1, true) => self.stress::<R, 4, FEW>(points, dt),
            (1, false) => self.stress::<R, 4, MAX_POINTS>(points, dt),
            _ => self.stress::<R, 7, MAX_POINTS>(points, dt),
        }
    }
}

impl PlaneStress for Plasticity {
    fn history(&self) -> &'static [&'static str] {
        self.names()
    }
    fn initial_yield_stress(&self) -> f64 {
        self.yield_stress
    }

    fn rate_dependent(&self) -> Option<&Plasticity> {
        self.rate.counts().then_some(self)
    }

    fn adds_stress(&self) -> bool {
        true
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.points(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.points(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.points(points, dt);
    }
}

#[cfg(test)]
#[path = "plane_stress_tests.rs"]
mod tests;
