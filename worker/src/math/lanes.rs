//! The scalar of the kernels: one `f64`, or several numbers side by side: [`LANES`] of `f64`,
//! [`LANES32`] of `f32`.
//!
//! Kernels are written once over [`Real`]. What one lane holds never depends on its place or on its
//! neighbours: a kernel may branch on data only to skip work that would leave every lane as it is,
//! so loops that stop lane by lane keep finished lanes frozen with [`Real::select`].
//!
//! In single precision only what happens within an element is short: nodal columns are `f64`,
//! differences of corners are taken before they are rounded ([`Lanes::row`]), and corner forces are
//! sums of modes taken after they are long again, so that the forces of an element add up to nought
//! as well as in double precision.

use crate::fem::materials::PointReal;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use wide::f32x4;

/// Elements that are worked on side by side in double precision.
pub const LANES: usize = 4;
/// The same in single precision.
pub const LANES32: usize = 8;

/// One number of each of [`LANES`] elements; also the row of a node: x, y, z, padding.
pub type Lane = wide::f64x4;
/// One short number of each of [`LANES32`] elements.
pub type Lane32 = wide::f32x8;

/// Vectors that the kernels were compiled for, in words.
pub fn vectors() -> String {
    let set = match () {
        _ if cfg!(target_feature = "avx2") => "AVX2",
        _ if cfg!(target_feature = "avx") => "AVX",
        _ if cfg!(target_feature = "sse2") => "SSE2",
        _ if cfg!(target_feature = "neon") => "NEON",
        _ => "no vectors",
    };
    let fused = if cfg!(target_feature = "fma") { " with fused products" } else { "" };
    format!("{LANES} f64 or {LANES32} f32 side by side, {set}{fused}")
}

/// What kernels compute with.
///
/// `f64` and [`Lane`] give the same bits lane by lane, whatever the operation.
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
    /// Yes or no for each lane.
    type Mask: Copy;

    /// Distance from one to the next number.
    const EPSILON: f64;
    /// The least number above nought that has all its digits.
    const SMALLEST: f64;
    /// The largest finite number.
    const LARGEST: f64;
    /// Whether its numbers are shorter than `f64`.
    const SHORT: bool = Self::EPSILON > f64::EPSILON;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// The number in lane `index`.
    fn lane(self, index: usize) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// `self` if it is less than `other`, else `other` (so `other` if either is not a number).
    fn min(self, other: Self) -> Self;
    /// `self` if it is greater than `other`, else `other` (so `other` if either is not a number).
    fn max(self, other: Self) -> Self;
    /// `self * factor + term`, rounded once where the machine can.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `term - self * factor`, rounded once where the machine can.
    fn neg_mul_add(self, factor: Self, term: Self) -> Self;
    /// `self`, above zero, to the power `exponent` in the lanes of `mask`, one elsewhere.
    fn powf_where(self, exponent: f64, mask: Self::Mask) -> Self;

    /// Natural logarithm of what is above zero.
    fn ln(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;

    /// `self < other`; false for what is not a number, as are the others.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// `self >= other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// `yes` in the lanes of `mask`, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Lanes that are in both.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Lanes that are in one of the two, or in both.
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Whether any lane is in `mask`. Use it only to skip work that would change nothing.
    fn any(mask: Self::Mask) -> bool;

    /// Nought in every lane.
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
        // Without the instruction, a fused product is a slow library call, and lanes round twice
        // too.
        if cfg!(target_feature = "fma") { self.mul_add(factor, term) } else { self * factor + term }
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        Real::mul_add(-self, factor, term)
    }
    #[inline(always)]
    fn powf_where(self, exponent: f64, mask: bool) -> Self {
        // As a lane computes it, to the last bit.
        if mask {
            Lane::splat(self).powf_where(exponent, Lane::splat(f64::from_bits(u64::MAX))).lane(0)
        } else {
            1.0
        }
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Real::ln(Lane::splat(self)).lane(0) // as a lane computes it, to the last bit
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

/// Numbers of one kind side by side.
macro_rules! lanes {
    ($lane:ty, $number:ident) => {
        impl Real for $lane {
            /// All bits of a lane set, or none.
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

/// `W` elements side by side.
pub trait Lanes<const W: usize>: PointReal {
    /// A row of a node, x, y, z and padding, in this precision.
    type Row: Copy;

    /// A row, rounded. Take differences of rows before that.
    fn row(row: Lane) -> Self::Row;
    /// The three components of the rows of `W` elements.
    fn from_rows(rows: [Self::Row; W]) -> [Self; 3];
    /// Rows that have three components; the fourth is nought.
    fn to_rows(components: [Self; 3]) -> [Lane; W];
    /// The number of each element.
    fn to_array(self) -> [f64; W];
    /// From the number of each element, rounded.
    fn from_array(numbers: [f64; W]) -> Self;
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

/// A row in single precision. By its instruction, where there is one: from arrays compilers make
/// conversions one by one.
#[inline(always)]
fn rounded(row: Lane) -> f32x4 {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    return bytemuck::cast(safe_arch::convert_to_m128_from_m256d(bytemuck::cast(row)));
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
    f32x4::new(row.to_array().map(|c| c as f32))
}

/// A row in double precision again.
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

/// Scalar product.
#[inline(always)]
pub fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Vector product.
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

    /// Pairs that cover signs, zeros, what is infinite and what is not a number.
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
                // ln and exp are good to an ulp or so each; ln reaches 58 here, of which the
                // exponent takes a part.
                assert!(
                    (ours / library - 1.0).abs() < 1e-14,
                    "{base}^{exponent}: {ours} against {library}"
                );
            }
            assert_eq!(0.0f64.powf_where(exponent, true), 0.0, "no rate, no factor");
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
                        // The sign of what is not a number is nobody's business.
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
