//! Corner vectors of a hexahedron as modes, its volume and its mean gradient.
//!
//! With `(xi, eta, zeta)_I` the signs of corner I, the modes are the sums over corners with the
//! signs `xi, eta, zeta, eta zeta, zeta xi, xi eta, xi eta zeta` (X1 to X7). The last four are the
//! hourglass modes. The volume of the trilinear solid is, with `[a b c] = a . (b x c)`,
//! ```text
//! 64 V = [X1 X2 X3] + ([X6 X2 X4] + [X5 X4 X3] + [X1 X6 X5]) / 3
//! ```
//! whose derivatives by the modes give the mean gradient of Flanagan & Belytschko 1981 (eq. 16)
//! exactly: `V B_I = dV/dx_I = sum over k of Gamma_kI dV/dX_k`. X7 is not in it.

use super::super::solid::corner;
use super::super::{GroupCorners, GroupNodes};
use crate::materials::PointLanes;
use crumple_math::lanes::{Real, cross, dot};

/// Modes of a vector at the corners.
pub type HexahedronModes<R> = [[R; 3]; 7];
/// Number of hourglass modes among them.
pub const HOURGLASS_MODES: usize = 4;

/// Volume and mean gradient at given coordinates.
pub struct Gradient<R> {
    /// 64 times the derivatives of the volume by the modes X1 to X6 [length^2].
    pub b: [[R; 3]; 6],
    /// 64 V [length^3].
    pub volume64: R,
    /// 64 times the Jacobian at the centre times 8 [length^3].
    pub centre: R,
}

impl<R: Real> Gradient<R> {
    /// Computes the gradient at the coordinates with these modes.
    #[inline(always)]
    pub fn new(x: &HexahedronModes<R>) -> Self {
        let third = R::splat(1.0 / 3.0);
        let [x1, x2, x3, x4, x5, x6, _] = *x;
        let [y4, y5, y6] = [x4, x5, x6].map(|v| v.map(|c| third * c));
        let centre = cross(x2, x3);
        let b = [
            cross_and(y6, x5, centre),
            cross_and(y4, x6, cross(x3, x1)),
            cross_and(y5, x4, cross(x1, x2)),
            cross_and(y6, x2, cross(x3, y5)),
            cross_and(y4, x3, cross(x1, y6)),
            cross_and(x2, y4, cross(y5, x1)),
        ];
        // The volume is of third degree in the modes, and the quadratic term of each derivative
        // occurs in it once: X1 . b1 contains [X1 X2 X3] and [X1 X6 X5]/3; the other two are in X4
        // . b4.
        let volume64 = dot(x1, b[0]) + dot(x4, b[3]);
        Self { b, volume64, centre: dot(x1, centre) }
    }

    /// Returns the lanes whose volume and whose Jacobian at the centre are positive.
    #[inline(always)]
    pub fn whole(&self) -> R::Mask {
        R::both(self.volume64.gt(R::zero()), self.centre.gt(R::zero()))
    }

    /// Returns the volume [length^3].
    #[inline(always)]
    pub fn volume(&self) -> R {
        R::splat(1.0 / 64.0) * self.volume64
    }

    /// Returns the mean gradient of `scale` times the field that has the modes `u`: component i by
    /// coordinate j.
    #[inline(always)]
    pub fn gradient_of(&self, u: &HexahedronModes<R>, scale: f64) -> [[R; 3]; 3] {
        let inverse = R::splat(scale) / self.volume64;
        let b = &self.b;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let mut sum = u[0][i] * b[0][j];
                for k in 1..6 {
                    sum = u[k][i].mul_add(b[k][j], sum);
                }
                sum * inverse
            })
        })
    }

    /// Returns the sum over corners of `B_I B_I'`: xx, yy, zz, xy, yz, zx [1/length^2]. `inverse`
    /// is one over `volume64`.
    #[inline(always)]
    pub fn gram(&self, inverse: R) -> [R; 6] {
        // All eight corners contain all the modes.
        let scale = R::splat(8.0) * inverse * inverse;
        let at = |i: usize, j: usize| {
            let mut sum = self.b[0][i] * self.b[0][j];
            for k in 1..6 {
                sum = self.b[k][i].mul_add(self.b[k][j], sum);
            }
            sum * scale
        };
        [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
    }
}

/// Returns `a x b + c`.
#[inline(always)]
fn cross_and<R: Real>(a: [R; 3], b: [R; 3], c: [R; 3]) -> [R; 3] {
    let at = |i: usize, j: usize, k: usize| a[j].mul_add(b[k], a[k].neg_mul_add(b[j], c[i]));
    [at(0, 1, 2), at(1, 2, 0), at(2, 0, 1)]
}

/// Returns the modes of corner values, from differences along edges, which are small.
#[inline(always)]
pub fn modes_of<T>(x: [T; 8]) -> [T; 7]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T>,
{
    let (e0, e1, e2, e3) = (x[1] - x[0], x[2] - x[3], x[5] - x[4], x[6] - x[7]);
    let (f0, f1, f2, f3) = (x[3] - x[0], x[2] - x[1], x[7] - x[4], x[6] - x[5]);
    let (low, high) = (e0 + e1, e2 + e3);
    let (turn_low, turn_high) = (e1 - e0, e3 - e2);
    let (f_low, f_high) = (f0 + f1, f2 + f3);
    [
        low + high,
        f_low + f_high,
        ((x[4] - x[0]) + (x[5] - x[1])) + ((x[6] - x[2]) + (x[7] - x[3])),
        f_high - f_low,
        high - low,
        turn_low + turn_high,
        turn_high - turn_low,
    ]
}

/// Returns the corner values, which are sums of modes with their signs.
#[inline(always)]
pub fn corners_of<T>(f: [T; 7]) -> [T; 8]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Neg<Output = T>,
{
    // Modes that are even in xi, and modes that are odd in xi.
    let (a0, a1) = ([f[1], f[2], f[3]], [f[0], f[5], f[4], f[6]]);
    let along = |sum: T, difference: T| (sum - difference, sum + difference);
    // Per (eta, zeta): the parts that are even in xi and odd in xi.
    let even = |eta: bool, zeta: bool| {
        let first = if eta { a0[0] } else { -a0[0] };
        let second = if zeta { first + a0[1] } else { first - a0[1] };
        if eta == zeta { second + a0[2] } else { second - a0[2] }
    };
    let odd = |eta: bool, zeta: bool| {
        let first = if eta { a1[0] + a1[1] } else { a1[0] - a1[1] };
        let second = if zeta { first + a1[2] } else { first - a1[2] };
        if eta == zeta { second + a1[3] } else { second - a1[3] }
    };
    let (x0, x1) = along(even(false, false), odd(false, false));
    let (x3, x2) = along(even(true, false), odd(true, false));
    let (x4, x5) = along(even(false, true), odd(false, true));
    let (x7, x6) = along(even(true, true), odd(true, true));
    [x0, x1, x2, x3, x4, x5, x6, x7]
}

/// Returns the modes of two nodal columns at the corners of a group.
#[inline(always)]
pub fn gather<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<8, W>,
    [one, other]: [&[[f64; 4]]; 2],
) -> [HexahedronModes<L>; 2] {
    // One length for both columns, so that one bounds check per node is enough.
    let n = one.len();
    let columns = [&one[..n], &other[..n]];
    let at = |c: usize| corner::<L, 8, W>(group, columns, c);
    // Written out, so that corners stay in registers.
    let c = [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)];
    let of = |k: usize| {
        let along = |i: usize| {
            modes_of([
                c[0][k][i], c[1][k][i], c[2][k][i], c[3][k][i], c[4][k][i], c[5][k][i], c[6][k][i],
                c[7][k][i],
            ])
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        std::array::from_fn(|m| [x[m], y[m], z[m]])
    };
    [of(0), of(1)]
}

/// Converts forces of modes to rows of corner forces.
#[inline(always)]
pub fn scatter<L: PointLanes<W>, const W: usize>(
    modes: &HexahedronModes<L>,
    force: &mut GroupCorners<8, W>,
) {
    if L::SHORT {
        let rows = modes.map(L::to_rows);
        for (lane, force) in force.iter_mut().enumerate() {
            *force = corners_of(rows.map(|rows| rows[lane])).map(|row| row.to_array());
        }
        return;
    }
    let [x, y, z]: [[L; 8]; 3] =
        std::array::from_fn(|i| corners_of(std::array::from_fn(|k| modes[k][i])));
    for c in 0..8 {
        for (lane, row) in L::to_rows([x[c], y[c], z[c]]).into_iter().enumerate() {
            force[lane][c] = row.to_array();
        }
    }
}

/// Returns the modes of the corners of one element.
pub fn modes_of_corners(x: &[[f64; 3]; 8]) -> HexahedronModes<f64> {
    let by_component: [[f64; 7]; 3] = std::array::from_fn(|i| modes_of(x.map(|corner| corner[i])));
    std::array::from_fn(|k| std::array::from_fn(|i| by_component[i][k]))
}
