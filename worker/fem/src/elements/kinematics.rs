//! Axes of a shell, and finite strains and rotations from its velocity gradient.

use crumple_math::lanes::{Real, cross, dot};

/// Axes e1, e2 and normal of an element.
pub struct Frame<R> {
    pub e1: [R; 3],
    pub e2: [R; 3],
    pub n: [R; 3],
}

impl<R: Real> Frame<R> {
    /// Returns the components of a vector in these axes.
    #[inline(always)]
    pub fn local(&self, v: [R; 3]) -> [R; 3] {
        [dot(self.e1, v), dot(self.e2, v), dot(self.n, v)]
    }

    /// Returns the components of vectors in these axes, times `step`.
    #[inline(always)]
    pub fn increments<const N: usize>(&self, vectors: &[[R; 3]; N], step: R) -> [[R; 3]; N] {
        let mut increments = *vectors;
        for vector in &mut increments {
            let [x, y, z] = self.local(*vector);
            *vector = [x * step, y * step, z * step];
        }
        increments
    }

    /// Returns the vectors with these components in these axes.
    #[inline(always)]
    pub fn to_global<const N: usize>(&self, mut vectors: [[R; 3]; N]) -> [[R; 3]; N] {
        for vector in &mut vectors {
            *vector = self.global(*vector);
        }
        vectors
    }

    /// Returns the vector with these components in these axes.
    #[inline(always)]
    pub fn global(&self, v: [R; 3]) -> [R; 3] {
        std::array::from_fn(|i| {
            v[0].mul_add(self.e1[i], v[1].mul_add(self.e2[i], v[2] * self.n[i]))
        })
    }
}

/// Strain and rotation of the plane of an element in a step.
pub struct PlaneMotion<R> {
    /// Almansi strain xx, yy, xy.
    pub almansi: [R; 3],
    /// Logarithmic strain to second order: xx, yy, and twice xy.
    pub eps: [R; 3],
    /// Components xz and yz of K, computed as if I - K were a rotation.
    pub k_z: [R; 2],
    /// Axis of the rotation of the plane times its sine: about -y, about x, about the normal.
    pub sine: [R; 3],
    /// Ratio of the angle to its sine.
    pub angle: R,
}

impl<R: Real> PlaneMotion<R> {
    /// Computes the motion from `k[i][j]`, the increment of displacement i differentiated by
    /// coordinate j; see `quad.rs`.
    #[inline(always)]
    pub fn new(k: &[[R; 2]; 3]) -> Self {
        let half = R::splat(0.5);
        let product = |i: usize, j: usize| {
            k[0][i].mul_add(k[0][j], k[1][i].mul_add(k[1][j], k[2][i] * k[2][j]))
        };
        let e_xx = half.neg_mul_add(product(0, 0), k[0][0]);
        let e_yy = half.neg_mul_add(product(1, 1), k[1][1]);
        let e_xy = half * (k[0][1] + k[1][0] - product(0, 1));
        let eps_xy = e_xy.mul_add(e_xx + e_yy, e_xy);
        let xy2 = e_xy * e_xy;
        let eps = [e_xx.mul_add(e_xx, e_xx + xy2), e_yy.mul_add(e_yy, e_yy + xy2), eps_xy + eps_xy];
        // The third column of K, and from it the rotation angles of the plane.
        let k_xz = -(k[1][0].mul_add(k[2][1], k[1][1].neg_mul_add(k[2][0], k[2][0])));
        let k_yz = -(k[2][0].mul_add(k[0][1], k[0][0].neg_mul_add(k[2][1], k[2][1])));
        let sine = [half * (k[2][0] - k_xz), half * (k[2][1] - k_yz), half * (k[1][0] - k[0][1])];
        Self {
            almansi: [e_xx, e_yy, e_xy],
            eps,
            k_z: [k_xz, k_yz],
            sine,
            angle: angle_by_sine(dot(sine, sine)),
        }
    }
}

impl<R: Real> PlaneMotion<R> {
    /// Returns the increment of rotation of a node relative to that of the element, t_e, in axes
    /// that rotate with the element: `t + t_e x t / 2`, since exp(t) exp(-t_e) is exp(t - t_e + t_e
    /// x (t - t_e)/2 ...) (Baker, Campbell & Hausdorff). Without the second term each shear strain
    /// causes a stress in the other one at half the rotation of a step, like a force without a
    /// potential: the two shear modes of a square that spins grow by a factor e in about one
    /// revolution.
    #[inline(always)]
    pub fn offset_by(&self, t: [R; 3]) -> [R; 3] {
        let half = R::splat(0.5) * self.angle;
        let own = [half * self.sine[1], -(half * self.sine[0]), half * self.sine[2]];
        let more = cross(own, t);
        std::array::from_fn(|i| t[i] + more[i])
    }

    /// Returns [`Self::offset_by`] of several increments.
    #[inline(always)]
    pub fn offsets<const N: usize>(&self, mut increments: [[R; 3]; N]) -> [[R; 3]; N] {
        for increment in &mut increments {
            *increment = self.offset_by(*increment);
        }
        increments
    }
}

/// Returns the curvature increments xx, yy and twice xy from the gradients of the rotations tx and
/// ty.
#[inline(always)]
pub fn curvature<R: Real>(tx: [R; 2], ty: [R; 2]) -> [R; 3] {
    [ty[0], -tx[1], ty[1] - tx[0]]
}

/// Returns the components xx, yy and twice xy of a strain in axes that are rotated by a small
/// angle.
#[inline(always)]
pub fn rotated<R: Real>(angle: R, [xx, yy, xy]: [R; 3]) -> [R; 3] {
    [angle.mul_add(xy, xx), angle.neg_mul_add(xy, yy), (angle + angle).mul_add(yy - xx, xy)]
}

/// Returns the angle of the finite rotation over its sine, from the sine squared: `asin(s)/s` to
/// the seventh order, with an error of 1e-12 at a rotation of 4 degrees per step.
#[inline(always)]
fn angle_by_sine<R: Real>(sine_squared: R) -> R {
    let s = sine_squared;
    let [a, b, c] = [15.0 / 336.0, 3.0 / 40.0, 1.0 / 6.0].map(R::splat);
    s.mul_add(a, b).mul_add(s, c).mul_add(s, R::splat(1.0))
}

/// Returns a vector of length `e` along the cross product; zero if the product is zero, as in
/// elements that have failed and collapsed.
#[inline(always)]
pub fn along_normal<R: Real>(e: R, a: [R; 3], b: [R; 3]) -> [R; 3] {
    let normal = cross(a, b);
    let length = dot(normal, normal).sqrt();
    let scale = R::select(length.gt(R::zero()), e / length, R::zero());
    normal.map(|c| c * scale)
}
