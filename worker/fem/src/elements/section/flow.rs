//! Plastic flow of a section in a step, for stresses that the points do not integrate: hourglass,
//! drilling and transverse shear.

use super::{POINTS, Section};
use crumple_math::lanes::Real;

/// Number of columns of a point from which the static yield stress follows, with those of stress.
pub const SAVED: usize = 5;

/// Columns of the points before a step, for [`Section::flow`]: stress, plastic strain and
/// temperature.
pub type PointsBefore<R, const N: usize> = [[R; SAVED]; N];

/// Means over the thickness, for membrane and (with the weight `3 zeta^2`) for bending.
struct Yielded<R> {
    /// Effective plastic strain.
    plastic_strain: [R; 2],
    /// Root mean square of the von Mises stress [force/length^2].
    stress: [R; 2],
    /// See `stress`, without the contribution of the strain rate to the yield stress.
    at_no_rate: [R; 2],
}

/// Effect of plastic flow in a step on stresses other than those of the points, for membrane and
/// for bending.
pub struct Flow<R> {
    /// Factor by which the radial return scales them.
    pub keep: [R; 2],
    /// Ratio of tangent to elastic stiffness.
    pub tangent: [R; 2],
}

impl Section {
    /// Returns the flow stress of the section, for limits on forces that the points do not
    /// integrate: the root mean square of the von Mises stress over all points, but at least
    /// `least` [force/length^2].
    #[cfg_attr(target_arch = "nvptx64", inline(always))]
    #[cfg_attr(not(target_arch = "nvptx64"), cold, inline(never))]
    pub fn flow_stress<R: Real, const N: usize>(&self, columns: &[R], least: f64) -> R {
        let mut mean_square = R::zero();
        let share = 0.5 / self.planar as f64;
        for section in columns.chunks_exact(self.each()) {
            for k in 0..self.count::<N>() {
                let square = von_mises_squared(&section[POINTS + k * self.stride..]);
                mean_square = R::splat(share * self.weight[k]).mul_add(square, mean_square);
            }
        }
        Real::max(mean_square.sqrt(), R::splat(least))
    }

    /// Saves the columns of the points that [`Self::flow`] needs from before a step. It writes to
    /// a reference, since a returned array would be copied once more.
    #[inline(always)]
    pub fn save_points<R: Real, const N: usize>(
        &self,
        columns: &[R],
        before: &mut PointsBefore<R, N>,
    ) {
        if self.plastic_strain.is_none() {
            return;
        }
        for (k, point) in before.iter_mut().take(self.count::<N>()).enumerate() {
            let columns = &columns[POINTS + k * self.stride..];
            // With a constant number of columns the copy stays in registers.
            point[..SAVED - 1].copy_from_slice(&columns[..SAVED - 1]);
            if self.stride >= SAVED {
                point[SAVED - 1] = columns[SAVED - 1];
            }
        }
    }

    /// Returns plastic strain and stress of points, for [`Self::flow`]. `column` is that of the
    /// plastic strain.
    fn yielded<'a, R: Real, const N: usize>(
        &self,
        column: usize,
        point: impl Fn(usize) -> &'a [R],
    ) -> Yielded<R> {
        let mut plastic_strain = [R::zero(); 2];
        for k in 0..self.count::<N>() {
            let weights = self.weights_of_means(k);
            for c in 0..2 {
                let weight = R::splat(weights[c]);
                plastic_strain[c] = weight.mul_add(point(k)[column], plastic_strain[c]);
            }
        }
        let stress = self.root_mean_squares::<R, N>(&point, |_, square| square);
        let at_no_rate = self.law.rate_dependent().map_or(stress, |law| {
            self.root_mean_squares::<R, N>(&point, |point, square| {
                let yields = law.static_yield_stress(&point[column..]);
                Real::min(square, yields * yields)
            })
        });
        Yielded { plastic_strain, stress, at_no_rate }
    }

    /// Returns the weights of a point in the means for membrane and bending.
    #[inline(always)]
    fn weights_of_means(&self, k: usize) -> [f64; 2] {
        let weight = 0.5 * self.weight[k];
        [weight, 3.0 * self.zeta[k] * self.zeta[k] * weight]
    }

    /// Returns the roots of the means of `of(point, square of the von Mises stress)`, for membrane
    /// and for bending.
    fn root_mean_squares<'a, R: Real, const N: usize>(
        &self,
        point: impl Fn(usize) -> &'a [R],
        of: impl Fn(&[R], R) -> R,
    ) -> [R; 2] {
        let mut squares = [R::zero(); 2];
        for k in 0..self.count::<N>() {
            let square = of(point(k), von_mises_squared(point(k)));
            let weights = self.weights_of_means(k);
            for c in 0..2 {
                squares[c] = R::splat(weights[c]).mul_add(square, squares[c]);
            }
        }
        squares.map(R::sqrt)
    }

    /// Returns the effect of plastic flow since `before` on stresses other than those of the
    /// points: `keep` is `sig / (sig + 3 G d eps_p)`, `tangent` is
    /// `d sig / (d sig + 3 G d eps_p)`. Both are one without plastic flow.
    #[inline(always)]
    pub fn flow<R: Real, const N: usize>(
        &self,
        columns: &[R],
        before: &PointsBefore<R, N>,
    ) -> Flow<R> {
        let one = R::splat(1.0);
        let none = Flow { keep: [one; 2], tangent: [one; 2] };
        let Some(column) = self.plastic_strain else { return none };
        let mut increase = R::zero();
        for (k, point) in before.iter().take(self.count::<N>()).enumerate() {
            increase += columns[POINTS + k * self.stride + column] - point[column];
        }
        if R::any(increase.gt(R::zero())) {
            self.plastic_flow(column, columns, before)
        } else {
            none
        }
    }

    /// Returns [`Self::flow`] of a group in which at least one element flows; the values of the
    /// others are exactly one.
    ///
    /// The strain rate of a step is unfiltered, so its contribution to the stress rises and falls
    /// with every wave. Only the rises would count, as hardening that does not exist; so `d sig`
    /// excludes it.
    #[cold]
    #[inline(never)]
    fn plastic_flow<R: Real, const N: usize>(
        &self,
        column: usize,
        columns: &[R],
        before: &PointsBefore<R, N>,
    ) -> Flow<R> {
        let one = R::splat(1.0);
        let before = self.yielded::<R, N>(column, |k| before[k].as_slice());
        let after = self.yielded::<R, N>(column, |k| &columns[POINTS + k * self.stride..]);
        let three_g = R::splat(3.0 * self.elastic.shear_modulus());
        let tiny = R::splat(R::SMALLEST);
        let left =
            |stress: R, lost: R| one - lost / Real::max(Real::max(stress, R::zero()) + lost, tiny);
        let (mut keep, mut tangent) = ([one; 2], [one; 2]);
        for c in 0..2 {
            let lost = three_g * (after.plastic_strain[c] - before.plastic_strain[c]);
            keep[c] = left(after.stress[c], lost);
            tangent[c] = left(after.at_no_rate[c] - before.at_no_rate[c], lost);
        }
        Flow { keep, tangent }
    }
}

/// Returns the square of the von Mises stress of a point in plane stress [force^2/length^4].
#[inline(always)]
pub(super) fn von_mises_squared<R: Real>(sig: &[R]) -> R {
    let [x, y, t] = [sig[0], sig[1], sig[2]];
    x.mul_add(x - y, y.mul_add(y, R::splat(3.0) * t * t))
}
