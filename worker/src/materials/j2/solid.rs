//! J2 in three dimensions: radial return of Simo & Hughes 1998, box 3.1. With the deviator s of the elastic trial,
//! ```text
//! sig_vm = sqrt(3/2 s:s),   sig_vm - 3 G y = sig_y(eps_p + y),   s <- s (1 - 3 G y / sig_vm)
//! ```
//! The equation for y = d eps_p is piecewise linear. It is solved without iteration: from the slope at eps_p, then
//! corrected for each bend of the curve that the answer lies beyond.

use super::J2;
use crate::lanes::{Lane, Real, dot};
use crate::materials::{Elastic, Solid, SolidPoint};

/// Columns: stress xx, yy, zz, xy, yz, zx, effective plastic strain.
const COLUMNS: usize = 7;

impl J2 {
    #[inline(always)]
    fn solid_stress<R: Real>(&self, point: SolidPoint<'_, R>, dt: f64) {
        let third = R::splat(1.0 / 3.0);
        let g = R::splat(self.elastic.shear_modulus());
        let bulk = R::splat(self.elastic.bulk_modulus());
        let one = R::splat(1.0);
        let Some(state) = point.state.first_chunk_mut::<COLUMNS>() else { return };
        let eps = point.strain;

        // 1. Elastic trial, as mean and deviator.
        let bulk_strain = eps[0] + eps[1] + eps[2];
        let third_strain = third * bulk_strain;
        let old_mean = third * (state[0] + state[1] + state[2]);
        let mean = bulk.mul_add(bulk_strain, old_mean);
        let e: [R; 3] = std::array::from_fn(|c| eps[c] - third_strain);
        let direct: [R; 3] = std::array::from_fn(|c| (g + g).mul_add(e[c], state[c] - old_mean));
        let shear: [R; 3] = std::array::from_fn(|c| g.mul_add(eps[3 + c], state[3 + c]));

        // 2. Yield, in units of the initial yield stress.
        let per_yield = R::splat(1.0 / self.yield_stress);
        let square = R::splat(1.5) * (dot(direct, direct) + R::splat(2.0) * dot(shear, shear));
        let trial = square.sqrt() * per_yield;
        let (sig_y, modulus) = self.yield_curve(state[6]);
        let mut over = trial.gt(sig_y);
        let mut scale = one;
        if self.rate.is_some() && R::any(over) {
            let sheared = [eps[3], eps[4], eps[5]];
            scale = self.rate_factor(dot(e, e) + R::splat(0.5) * dot(sheared, sheared), dt, over);
            over = trial.gt(scale * sig_y);
        }

        // 3. Return.
        let mut factor = one;
        if R::any(over) {
            let three_g = R::splat(3.0) * g * per_yield;
            let y = R::select(over, self.radial(trial, three_g, scale, state[6], sig_y, modulus), R::zero());
            // The increment is nought in the lanes left out, and so is what they are multiplied by.
            factor = R::select(over, one - three_g * y / trial, one);
            state[6] += y;
        }
        for c in 0..3 {
            state[c] = factor.mul_add(direct[c], mean);
            state[3 + c] = factor * shear[c];
        }
    }

    /// Plastic strain increment that brings a trial beyond yield back.
    #[inline(always)]
    fn radial<R: Real>(&self, trial: R, three_g: R, scale: R, eps_p: R, sig_y: R, modulus: R) -> R {
        let mut slope = scale.mul_add(modulus, three_g);
        let mut y = (trial - scale * sig_y) / slope;
        for &(start, change) in &self.ramps {
            let bend = R::splat(start) - eps_p;
            // A bend behind is in the slope already.
            let change = R::select(bend.ge(R::zero()), scale * R::splat(change), R::zero());
            let ahead = y.gt(bend);
            let steeper = slope + R::select(ahead, change, R::zero());
            y = R::select(ahead, bend + (y - bend) * (slope / steeper), y);
            slope = steeper;
        }
        y
    }
}

impl Solid for J2 {
    fn history(&self) -> &'static [&'static str] {
        &["plastic_strain"]
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) {
        self.solid_stress(point, dt);
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) {
        self.solid_stress(point, dt);
    }
}
