//! Transverse shear of points with axes of their own.

use super::{SHEAR_CORRECTION, Section};
use crumple_math::lanes::Real;

impl Section {
    /// Returns increments of the transverse shear stress as products with one, from moduli that are
    /// means over the thickness in the axes of the points. In isotropic shells they are products of
    /// a modulus and a strain, whose sum with the stress is rounded once.
    #[cold]
    #[inline(never)]
    pub(super) fn transverse_shear<R: Real>(
        &self,
        moduli: &[[f64; 2]],
        points: &[R],
        gamma: [R; 2],
    ) -> [[R; 2]; 2] {
        // Mean of G_ca c^2 + G_bc s^2, G_ca s^2 + G_bc c^2 and (G_ca - G_bc) c s.
        let (mut xx, mut yy, mut xy) = (R::zero(), R::zero(), R::zero());
        for (k, [ca, bc]) in moduli.iter().enumerate() {
            let (c, s) = match self.direction {
                None => (R::splat(1.0), R::zero()),
                Some([cosine, sine]) => {
                    let point = &points[k * self.stride..];
                    (point[cosine] + R::splat(1.0), point[sine])
                }
            };
            let share = 0.5 * self.weight[k] * self.shear * SHEAR_CORRECTION;
            let [ca, bc] = [ca, bc].map(|modulus| R::splat(share * modulus));
            let (cc, ss) = (c * c, s * s);
            xx += cc * ca + ss * bc;
            yy += ss * ca + cc * bc;
            xy += c * s * (ca - bc);
        }
        let [x, y] = gamma;
        [[R::splat(1.0), xx * x + xy * y], [R::splat(1.0), yy * y + xy * x]]
    }
}
