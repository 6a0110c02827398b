//! The scalar of the kernels: one `f64`, or several numbers in the lanes of a SIMD vector,
//! [`LANES`] of `f64` or [`LANES32`] of `f32`.
//!
//! Kernels are written once over [`Real`]. The value of a lane never depends on its position or
//! on other lanes. A kernel may branch on data only to skip work that would change no lane. So
//! loops that converge lane by lane keep converged lanes unchanged with [`Real::select`].
//!
//! In single precision, only operations within an element use `f32`. Nodal columns are `f64`, and
//! differences of corners are computed before they are rounded ([`Lanes::row`]). Element nodal
//! forces are sums of modes in `f64`, so that the forces of an element sum to zero as well as in
//! double precision.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use wide::f32x4;

/// Number of elements per vector in double precision.
pub const LANES: usize = 4;
/// Number of elements per vector in single precision.
pub const LANES32: usize = 8;

/// True if the machine has the instruction for a product and a sum that is rounded once.
const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "nvptx64"));

/// One number of each of [`LANES`] elements; also the row of a node: x, y, z, padding.
pub type Lane = wide::f64x4;
/// One `f32` number of each of [`LANES32`] elements.
pub type Lane32 = wide::f32x8;

/// Returns the vector instructions for which the kernels were compiled, in words.
pub fn vectors() -> String {
    let set = match () {
        _ if cfg!(target_feature = "avx2") => "AVX2",
        _ if cfg!(target_feature = "avx") => "AVX",
        _ if cfg!(target_feature = "sse2") => "SSE2",
        _ if cfg!(target_feature = "neon") => "NEON",
        _ => "no vectors",
    };
    let fused = if cfg!(target_feature = "fma") { " with fused multiply-add" } else { "" };
    format!("lanes of {LANES} f64 or {LANES32} f32, {set}{fused}")
}

/// The scalar of kernels.
///
/// `f64` and [`Lane`] give the same bits in each lane, for all operations.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// A boolean for each lane.
    type Mask: Copy;

    /// Distance from one to the next number.
    const EPSILON: f64;
    /// Smallest positive normal number.
    const SMALLEST: f64;
    /// The largest finite number.
    const LARGEST: f64;
    /// True if its numbers are shorter than `f64`.
    const SHORT: bool = Self::EPSILON > f64::EPSILON;

    /// Returns the same number in every lane.
    fn splat(value: f64) -> Self;
    /// Returns the number in lane `index`.
    fn lane(self, index: usize) -> f64;
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Returns `self` if it is less than `other`, else `other` (so `other` if either is NaN).
    fn min(self, other: Self) -> Self;
    /// Returns `self` if it is greater than `other`, else `other` (so `other` if either is NaN).
    fn max(self, other: Self) -> Self;
    /// Returns `self * factor + term`, rounded once if the machine has the instruction.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// Returns `term - self * factor`, rounded once if the machine has the instruction.
    fn neg_mul_add(self, factor: Self, term: Self) -> Self;
    /// Returns `self`, above zero, to the power `exponent` in the lanes of `mask`, one in others.
    fn powf_where(self, exponent: f64, mask: Self::Mask) -> Self;

    /// Returns the natural logarithm of a positive number.
    fn ln(self) -> Self;
    /// Returns the exponential.
    fn exp(self) -> Self;

    /// Returns `self < other`; this and the other comparisons are false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Returns `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// Returns `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// Returns `self >= other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// Returns `yes` in the lanes of `mask`, `no` in others.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Returns the lanes that are in both masks.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Returns the lanes that are in at least one mask.
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Returns true if any lane is in `mask`. Use it only to skip work that would change no lane.
    fn any(mask: Self::Mask) -> bool;

    /// Returns zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

impl Real for f64 {
    type Mask = bool;

    const EPSILON: f64 = f64::EPSILON;
    const SMALLEST: f64 = f64::MIN_POSITIVE;
    const LARGEST: f64 = f64::MAX;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // Without the instruction, a fused product is a slow library call; vectors then round
        // twice too.
        if FUSED { self.mul_add(factor, term) } else { self * factor + term }
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        Real::mul_add(-self, factor, term)
    }
    #[inline(always)]
    fn powf_where(self, exponent: f64, mask: bool) -> Self {
        // Computed as in a vector: the same bits.
        if mask {
            Lane::splat(self).powf_where(exponent, Lane::splat(f64::from_bits(u64::MAX))).lane(0)
        } else {
            1.0
        }
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Real::ln(Lane::splat(self)).lane(0) // computed as in a vector: the same bits
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Real::exp(Lane::splat(self)).lane(0)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }
    #[inline(always)]
    fn ge(self, other: Self) -> bool {
        self >= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn both(a: bool, b: bool) -> bool {
        a && b
    }
    #[inline(always)]
    fn either(a: bool, b: bool) -> bool {
        a || b
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
}

/// Implements [`Real`] for a vector type.
macro_rules! lanes {
    ($lane:ty, $number:ident) => {
        impl Real for $lane {
            /// A lane has all bits set, or none.
            type Mask = $lane;

            const EPSILON: f64 = $number::EPSILON as f64;
            const SMALLEST: f64 = $number::MIN_POSITIVE as f64;
            const LARGEST: f64 = $number::MAX as f64;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                <$lane>::splat(value as $number)
            }
            #[inline(always)]
            fn lane(self, index: usize) -> f64 {
                self.as_array()[index] as f64
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.fast_min(other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.fast_max(other)
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, term)
            }
            #[inline(always)]
            fn neg_mul_add(self, factor: Self, term: Self) -> Self {
                self.mul_neg_add(factor, term)
            }
            #[inline]
            fn powf_where(self, exponent: f64, mask: Self) -> Self {
                let power = (self.ln() * <$lane>::splat(exponent as $number)).exp();
                Real::select(mask, power, <$lane>::splat(1.0))
            }
            #[inline]
            fn ln(self) -> Self {
                self.ln()
            }
            #[inline]
            fn exp(self) -> Self {
                self.exp()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self {
                self.simd_lt(other)
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self {
                self.simd_le(other)
            }
            #[inline(always)]
            fn gt(self, other: Self) -> Self {
                self.simd_gt(other)
            }
            #[inline(always)]
            fn ge(self, other: Self) -> Self {
                self.simd_ge(other)
            }
            #[inline(always)]
            fn select(mask: Self, yes: Self, no: Self) -> Self {
                mask.select(yes, no)
            }
            #[inline(always)]
            fn both(a: Self, b: Self) -> Self {
                a & b
            }
            #[inline(always)]
            fn either(a: Self, b: Self) -> Self {
                a | b
            }
            #[inline(always)]
            fn any(mask: Self) -> bool {
                mask.any()
            }
        }
    };
}
lanes!(wide::f64x4, f64);
lanes!(wide::f32x8, f32);

/// Values of `W` elements in a vector.
pub trait Lanes<const W: usize>: Real {
    /// A row of a node, x, y, z and padding, in this precision.
    type Row: Copy;

    /// Returns a row, rounded. Compute differences of rows before this.
    fn row(row: Lane) -> Self::Row;
    /// Returns the three components of the rows of `W` elements.
    fn from_rows(rows: [Self::Row; W]) -> [Self; 3];
    /// Returns rows of three components; the fourth is zero.
    fn to_rows(components: [Self; 3]) -> [Lane; W];
    /// Returns the number of each element.
    fn to_array(self) -> [f64; W];
    /// Returns a vector of the numbers of each element, rounded.
    fn from_array(numbers: [f64; W]) -> Self;
}

/// One element per thread, for devices with thousands of threads.
impl Lanes<1> for f64 {
    type Row = Lane;

    #[inline(always)]
    fn row(row: Lane) -> Lane {
        row
    }
    #[inline(always)]
    fn from_rows([row]: [Lane; 1]) -> [Self; 3] {
        let [x, y, z, _] = row.to_array();
        [x, y, z]
    }
    #[inline(always)]
    fn to_rows([x, y, z]: [Self; 3]) -> [Lane; 1] {
        [Lane::new([x, y, z, 0.0])]
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 1] {
        [self]
    }
    #[inline(always)]
    fn from_array([number]: [f64; 1]) -> Self {
        number
    }
}

impl Lanes<LANES> for Lane {
    type Row = Lane;

    #[inline(always)]
    fn row(row: Lane) -> Lane {
        row
    }
    #[inline(always)]
    fn from_rows(rows: [Lane; LANES]) -> [Self; 3] {
        let [x, y, z, _] = Lane::transpose(rows);
        [x, y, z]
    }
    #[inline(always)]
    fn to_rows([x, y, z]: [Self; 3]) -> [Lane; LANES] {
        Lane::transpose([x, y, z, Lane::splat(0.0)])
    }
    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        self.to_array()
    }
    #[inline(always)]
    fn from_array(numbers: [f64; LANES]) -> Self {
        Lane::new(numbers)
    }
}

/// `map` of short arrays that is inlined in every case: `[T; N]::map` becomes a call in large
/// kernels, with its lanes in memory.
pub trait Each<T> {
    /// The array with elements of another type.
    type Of<U>;

    /// Returns the array of `f` of each element.
    fn each<U>(self, f: impl Fn(T) -> U) -> Self::Of<U>;
}

macro_rules! each {
    ($($count:literal: $($name:ident)*;)*) => {$(
        impl<T> Each<T> for [T; $count] {
            type Of<U> = [U; $count];

            #[inline(always)]
            fn each<U>(self, f: impl Fn(T) -> U) -> [U; $count] {
                let [$($name),*] = self;
                [$(f($name)),*]
            }
        }
    )*};
}
each! { 2: a b; 3: a b c; 4: a b c d; 7: a b c d e f g; }

/// Returns a row in single precision, by the machine's instruction if there is one: from arrays,
/// compilers convert one number at a time.
#[inline(always)]
fn rounded(row: Lane) -> f32x4 {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    return bytemuck::cast(safe_arch::convert_to_m128_from_m256d(bytemuck::cast(row)));
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
    f32x4::new(row.to_array().map(|c| c as f32))
}

/// Returns a row in double precision.
#[inline(always)]
fn widened(row: f32x4) -> Lane {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    return bytemuck::cast(safe_arch::convert_to_m256d_from_m128(bytemuck::cast(row)));
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
    Lane::new(row.to_array().map(f64::from))
}

impl Lanes<LANES32> for Lane32 {
    type Row = f32x4;

    #[inline(always)]
    fn row(row: Lane) -> f32x4 {
        rounded(row)
    }
    #[inline(always)]
    fn from_rows([a, b, c, d, e, f, g, h]: [f32x4; LANES32]) -> [Self; 3] {
        let (low, high) = (f32x4::transpose([a, b, c, d]), f32x4::transpose([e, f, g, h]));
        std::array::from_fn(|i| bytemuck::cast([low[i], high[i]]))
    }
    #[inline(always)]
    fn to_rows(components: [Self; 3]) -> [Lane; LANES32] {
        let [x, y, z]: [[f32x4; 2]; 3] = components.map(bytemuck::cast);
        let half = |k: usize| f32x4::transpose([x[k], y[k], z[k], f32x4::ZERO]);
        let ([a, b, c, d], [e, f, g, h]) = (half(0), half(1));
        [a, b, c, d, e, f, g, h].map(widened)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; LANES32] {
        self.to_array().map(f64::from)
    }
    #[inline(always)]
    fn from_array(numbers: [f64; LANES32]) -> Self {
        Lane32::new(numbers.map(|c| c as f32))
    }
}

/// Returns the scalar product.
#[inline(always)]
pub fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Returns the vector product.
#[inline(always)]
pub fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of these cover signs, zeros, infinity and NaN.
    const NUMBERS: [f64; 9] =
        [0.0, -0.0, 1.0, -2.5, 1e-300, 3e200, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];

    fn all<R: Real>(a: R, b: R, c: R) -> Vec<R> {
        let mask = a.gt(b);
        vec![
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.sqrt(),
            a.abs(),
            a.min(b),
            a.max(b),
            a.mul_add(b, c),
            a.neg_mul_add(b, c),
            R::select(mask, a, b),
            R::select(a.lt(b), a, c),
            R::select(a.le(b), a, c),
            R::select(a.ge(b), a, c),
            R::select(R::both(mask, c.ge(b)), a, c),
            R::select(R::either(mask, c.ge(b)), a, c),
            a.powf_where(0.3, mask),
            a.ln(),
            a.exp(),
        ]
    }

    #[test]
    fn powers_are_those_of_the_library() {
        for exponent in [0.2, 0.1, 1.0 / 3.9] {
            for k in -600..=600 {
                let base = 1.1f64.powi(k) * 1.234567;
                let (ours, library) = (base.powf_where(exponent, true), base.powf(exponent));
                // ln and exp have an error of about an ulp each. ln reaches 58 here, and the
                // exponent multiplies it by less than one.
                assert!(
                    (ours / library - 1.0).abs() < 1e-14,
                    "{base}^{exponent}: {ours}, library {library}"
                );
            }
            assert_eq!(0.0f64.powf_where(exponent, true), 0.0, "zero for a zero rate");
        }
    }

    #[test]
    fn lanes_round_as_one_number_does() {
        for shift in 0..NUMBERS.len() {
            for other in 0..NUMBERS.len() {
                let pick = |offset: usize| -> [f64; LANES] {
                    std::array::from_fn(|lane| NUMBERS[(lane + offset) % NUMBERS.len()])
                };
                let (a, b, c) = (pick(shift), pick(other), pick(shift + other));
                let wide = all(Lane::new(a), Lane::new(b), Lane::new(c));
                for lane in 0..LANES {
                    for (index, (w, s)) in
                        wide.iter().zip(all(a[lane], b[lane], c[lane])).enumerate()
                    {
                        let w = w.lane(lane);
                        // The sign of NaN is not defined.
                        assert!(
                            w.to_bits() == s.to_bits() || w.is_nan() && s.is_nan(),
                            "operation {index}: {w} {s}"
                        );
                    }
                }
            }
        }
    }
}
