//! Symmetric tensors of the laws, in the order xx, yy, zz, xy, yz, zx of the stress: products,
//! invariants, principal values, and the left Cauchy-Green tensor over a step.

use crumple_math::lanes::{Real, dot};

/// A symmetric tensor.
pub type Symmetric<R> = [R; 6];
/// A tensor, by rows.
type Matrix<R> = [[R; 3]; 3];

/// Most sweeps of the Jacobi method; five reach round-off.
const SWEEPS: usize = 10;

/// Returns the tensor by rows.
#[inline(always)]
pub fn full<R: Real>([xx, yy, zz, xy, yz, zx]: Symmetric<R>) -> Matrix<R> {
    [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]
}

/// Returns the symmetric part of a tensor.
#[inline(always)]
fn symmetric<R: Real>(m: &Matrix<R>) -> Symmetric<R> {
    let mean = |i: usize, j: usize| R::splat(0.5) * (m[i][j] + m[j][i]);
    [m[0][0], m[1][1], m[2][2], mean(0, 1), mean(1, 2), mean(2, 0)]
}

/// Returns the product with a symmetric tensor.
#[inline(always)]
fn times<R: Real>(a: &Matrix<R>, symmetric: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| dot(a[i], symmetric[j])))
}

/// Returns `a:b`.
#[inline(always)]
pub fn inner<R: Real>(a: &Symmetric<R>, b: &Symmetric<R>) -> R {
    let shear = dot([a[3], a[4], a[5]], [b[3], b[4], b[5]]);
    R::splat(2.0).mul_add(shear, dot([a[0], a[1], a[2]], [b[0], b[1], b[2]]))
}

/// Returns the trace.
#[inline(always)]
pub fn trace<R: Real>(a: &Symmetric<R>) -> R {
    a[0] + a[1] + a[2]
}

/// Returns the deviator. It is zero, bit for bit, if the direct components are equal.
#[inline(always)]
pub fn deviator<R: Real>(a: &Symmetric<R>) -> Symmetric<R> {
    let third = R::splat(1.0 / 3.0);
    let of = |i: usize, j: usize, k: usize| third * ((a[i] - a[j]) + (a[i] - a[k]));
    [of(0, 1, 2), of(1, 2, 0), of(2, 0, 1), a[3], a[4], a[5]]
}

/// Returns the square of a symmetric tensor.
#[inline(always)]
pub fn square<R: Real>(a: &Symmetric<R>) -> Symmetric<R> {
    let rows = full(*a);
    symmetric(&times(&rows, &rows))
}

/// Returns the determinant.
#[inline(always)]
fn determinant<R: Real>([xx, yy, zz, xy, yz, zx]: Symmetric<R>) -> R {
    let first = xx * yz.neg_mul_add(yz, yy * zz);
    let second = xy * zx.neg_mul_add(yz, xy * zz);
    let third = zx * zx.neg_mul_add(yy, xy * yz);
    first - second + third
}

/// Returns an upper bound of the largest principal value, which is reached in axial symmetry.
#[inline(always)]
pub fn largest_bound<R: Real>(a: &Symmetric<R>) -> R {
    let s = deviator(a);
    let third = R::splat(1.0 / 3.0) * trace(a);
    third + (R::splat(2.0 / 3.0) * inner(&s, &s)).sqrt()
}

/// Returns `J^2 - 1` of the left Cauchy-Green tensor `1 + b`, without loss of digits at small b.
#[inline(always)]
pub fn volume_change<R: Real>(b: &Symmetric<R>) -> R {
    let first = trace(b);
    let second = R::splat(0.5) * first.mul_add(first, -inner(b, b));
    first + second + determinant(*b)
}

/// Advances `b = B - 1` of the left Cauchy-Green tensor B by a strain increment (xx, yy, zz, twice
/// xy, yz, zx) in the middle of the step: `B <- f B f` with the stretch
/// `f = (1 + e/2) (1 - e/2)^-1`. A step and its reverse restore b.
#[inline(always)]
pub fn stretch<R: Real>(b: &Symmetric<R>, strain: &[R; 6]) -> Symmetric<R> {
    let half = R::splat(0.5);
    let e: Symmetric<R> = std::array::from_fn(|c| if c < 3 { strain[c] } else { half * strain[c] });
    // f = 1 + d with d = (1 - e/2)^-1 e, by the adjugate of a = 1 - e/2.
    let mut a = e.map(|x| -half * x);
    (0..3).for_each(|c| a[c] += R::splat(1.0));
    let [xx, yy, zz, xy, yz, zx] = a;
    let adjugate = full([
        yz.neg_mul_add(yz, yy * zz),
        zx.neg_mul_add(zx, xx * zz),
        xy.neg_mul_add(xy, xx * yy),
        xy.neg_mul_add(zz, zx * yz),
        yz.neg_mul_add(xx, xy * zx),
        zx.neg_mul_add(yy, xy * yz),
    ]);
    let per = R::splat(1.0) / determinant(a);
    let d = symmetric(&times(&adjugate, &full(e))).map(|x| per * x);
    // f B f = B + 2 d + d^2 + (d b + b d) + d b d.
    let (rows, old) = (full(d), full(*b));
    let once = times(&rows, &old);
    let (both, twice) = (symmetric(&once), symmetric(&times(&once, &rows)));
    let squared = square(&d);
    std::array::from_fn(|c| b[c] + (d[c] + d[c]) + squared[c] + (both[c] + both[c]) + twice[c])
}

/// Returns `R a R'` of the symmetric tensor a at the start of `state`.
#[inline(always)]
pub fn rotated<R: Real>(turn: &Matrix<R>, state: &[R]) -> Symmetric<R> {
    let [xx, yy, zz, xy, yz, zx]: [R; 6] = std::array::from_fn(|c| state[c]);
    let columns = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    let half: [[R; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| dot(turn[i], columns[j])));
    // Written out, because a loop over pairs of indices becomes a call, which moves all registers
    // to memory.
    let at = |i: usize, j: usize| dot(half[i], turn[j]);
    [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
}

/// Principal values and their directions: `directions[i][k]` is component i of direction k.
pub struct Principal<R> {
    pub values: [R; 3],
    directions: Matrix<R>,
}

impl<R: Real> Principal<R> {
    /// Computes them by Jacobi rotations (Golub & Van Loan 2013, sec. 8.5).
    #[inline(always)]
    pub fn new(tensor: &Symmetric<R>) -> Self {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let mut a = full(*tensor);
        let mut v = full([one, one, one, zero, zero, zero]);
        let small = R::splat(0.25 * R::EPSILON);
        for _ in 0..SWEEPS {
            let mut any = false;
            for (p, q, r) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                let (off, size) = (a[p][q], a[p][p].abs() + a[q][q].abs());
                let turns = off.abs().gt(small * size);
                any |= R::any(turns);
                let apart = a[q][q] - a[p][p];
                let twice = off + off;
                let below = apart.abs() + apart.mul_add(apart, twice * twice).sqrt();
                let sign = R::select(apart.lt(zero), -one, one);
                let tangent = R::select(R::both(turns, below.gt(zero)), sign * twice / below, zero);
                let c = one / tangent.mul_add(tangent, one).sqrt();
                let s = tangent * c;
                a[p][p] = tangent.neg_mul_add(off, a[p][p]);
                a[q][q] = tangent.mul_add(off, a[q][q]);
                a[p][q] = R::select(turns, zero, off);
                a[q][p] = a[p][q];
                let (pr, qr) = (a[p][r], a[q][r]);
                a[p][r] = s.neg_mul_add(qr, c * pr);
                a[q][r] = s.mul_add(pr, c * qr);
                (a[r][p], a[r][q]) = (a[p][r], a[q][r]);
                for row in &mut v {
                    let (vp, vq) = (row[p], row[q]);
                    row[p] = s.neg_mul_add(vq, c * vp);
                    row[q] = s.mul_add(vp, c * vq);
                }
            }
            if !any {
                break;
            }
        }
        Self { values: [a[0][0], a[1][1], a[2][2]], directions: v }
    }

    /// Returns the tensor with these principal values in the same directions.
    #[inline(always)]
    pub fn compose(&self, values: [R; 3]) -> Symmetric<R> {
        let scaled: Matrix<R> =
            std::array::from_fn(|i| std::array::from_fn(|k| values[k] * self.directions[i][k]));
        symmetric(&times(&scaled, &self.directions))
    }

    /// Returns the normal components of a tensor in these directions.
    #[inline(always)]
    pub fn normal(&self, tensor: &Symmetric<R>) -> [R; 3] {
        let rows = full(*tensor);
        std::array::from_fn(|k| {
            let n = std::array::from_fn(|i| self.directions[i][k]);
            dot(n, rows.map(|row| dot(row, n)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::testing::Noise;

    /// Random tensors: the principal values have the invariants, and compose the tensor again.
    #[test]
    fn principal_values_compose_the_tensor() {
        let mut noise = Noise(9);
        for k in 0..1000 {
            let mut a: Symmetric<f64> = std::array::from_fn(|_| noise.next());
            if k % 4 == 0 {
                a[3] = 0.0;
                a[1] = a[0];
            }
            let principal = Principal::new(&a);
            let [x, y, z] = principal.values;
            assert!((x * y * z - determinant(a)).abs() < 1e-14, "{a:?}");
            assert!((largest_bound(&a) - x.max(y).max(z)) > -1e-14, "{a:?}");
            for (got, exact) in principal.compose(principal.values).into_iter().zip(a) {
                assert!((got - exact).abs() < 1e-14, "{got} for {exact}");
            }
            for (got, exact) in principal.normal(&a).into_iter().zip(principal.values) {
                assert!((got - exact).abs() < 1e-14, "{got} for {exact}");
            }
        }
    }

    /// Stretch along an axis is exact; a step and its reverse leave nothing; the volume is that of
    /// the stretches.
    #[test]
    fn a_stretch_is_exact_and_can_be_reversed() {
        let mut b = [0.0; 6];
        let increment = 2.0 * (1.5 - 1.0) / (1.5 + 1.0);
        b = stretch(&b, &[increment, 0.0, -0.2, 0.0, 0.0, 0.0]);
        let thin: f64 = 0.9 / 1.1;
        assert!((b[0] - 1.25).abs() < 1e-15 && (b[2] - (thin * thin - 1.0)).abs() < 1e-15);
        assert!((volume_change(&b) - (2.25 * thin * thin - 1.0)).abs() < 1e-15);
        let before = b;
        let shear = [0.01, -0.02, 0.005, 0.03, -0.01, 0.02];
        b = stretch(&stretch(&b, &shear), &shear.map(|x: f64| -x));
        assert!(b.iter().zip(before).all(|(a, b)| (a - b).abs() < 1e-15), "{b:?} {before:?}");
    }
}
