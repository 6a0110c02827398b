//! Sums that do not depend on the order of their terms, so that they are equal for any
//! distribution of pairs over workers.

/// Number of digits for the range of `f64`, from 2^-1074, including the carry of a term.
const DIGITS: usize = 67;
/// Number of bits of a digit. A word overflows after 2^31 terms.
const BITS: usize = 32;
/// Number of words of a sum in a message.
pub const WORDS: usize = DIGITS + 1;

/// A sum of `f64` in fixed point over their whole range, exact for all terms (Kulisch, *Computer
/// Arithmetic and Validity*, 2013, ch. 8; Neal, arXiv:1505.05571, sec. 2). The words of two sums
/// are added as integers.
#[derive(Clone, Debug)]
pub struct ExactSum {
    /// Digit d has the unit 2^(32 d - 1074). The last word counts terms that are not finite.
    words: [i64; WORDS],
}

impl ExactSum {
    /// The sum of no terms.
    pub const ZERO: Self = Self { words: [0; WORDS] };

    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        if !term.is_finite() {
            self.words[DIGITS] += 1;
            return;
        }
        let bits = term.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as usize;
        let fraction = bits & ((1 << 52) - 1);
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        let place = exponent.max(1) - 1;
        let mut rest = u128::from(mantissa) << (place % BITS);
        let sign = if term < 0.0 { -1 } else { 1 };
        for digit in &mut self.words[place / BITS..][..3] {
            *digit += sign * i64::from(rest as u32);
            rest >>= BITS;
        }
    }

    /// Returns the words, to be added to those of other workers.
    pub fn words(&self) -> &[i64; WORDS] {
        &self.words
    }

    /// Returns the value of summed words, NaN if a term was not finite. `words` has [`WORDS`]
    /// entries.
    pub fn value(words: &[i64]) -> f64 {
        if words[DIGITS] != 0 {
            return f64::NAN;
        }
        let mut digits = [0i64; DIGITS];
        digits.copy_from_slice(&words[..DIGITS]);
        let negative = carry(&mut digits) < 0;
        if negative {
            digits.iter_mut().for_each(|d| *d = -*d);
            carry(&mut digits);
        }
        let Some(top) = digits.iter().rposition(|&d| d != 0) else { return 0.0 };
        // Three digits have more bits than a mantissa. Two factors are used, since a single power
        // of two may be out of range.
        let lowest = top.saturating_sub(2);
        let scale = (BITS * lowest) as i32 - 1074;
        let head = digits[lowest..=top]
            .iter()
            .rev()
            .fold(0.0, |sum, &d| sum * 2f64.powi(BITS as i32) + d as f64);
        let size = head * 2f64.powi(scale / 2) * 2f64.powi(scale - scale / 2);
        if negative { -size } else { size }
    }
}

/// Brings all digits into 0..2^32 and returns the carry of the highest digit.
fn carry(digits: &mut [i64; DIGITS]) -> i64 {
    let mut carried = 0;
    for digit in digits {
        let sum = *digit + carried;
        carried = sum >> BITS;
        *digit = sum - (carried << BITS);
    }
    carried
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sum(terms: &[f64]) -> f64 {
        let mut sum = ExactSum::ZERO;
        terms.iter().for_each(|&t| sum.add(t));
        ExactSum::value(sum.words())
    }

    #[test]
    fn sums_are_exact_where_plain_ones_are_not() {
        assert_eq!(sum(&[]), 0.0);
        assert_eq!(sum(&[1e300, 1.0, -1e300, 1e-300, -1.0]), 1e-300);
        assert_eq!(sum(&[f64::MIN_POSITIVE / 4.0, 0.0]), f64::MIN_POSITIVE / 4.0);
        assert_eq!(sum(&[-3.0, 1.25]), -1.75);
        assert_eq!(sum(&[f64::MAX]), f64::MAX);
        assert!(sum(&[1.0, f64::NAN]).is_nan() && sum(&[f64::INFINITY]).is_nan());
    }

    proptest! {
        #[test]
        fn the_order_of_terms_and_their_distribution_do_not_matter(
            terms in prop::collection::vec(any::<i64>().prop_map(|m| m as f64), 1..40),
            powers in prop::collection::vec(-300i32..300, 40),
            cut in 0usize..40,
        ) {
            let terms: Vec<f64> =
                terms.iter().zip(&powers).map(|(m, &p)| m * 2f64.powi(p)).collect();
            let mut reversed = terms.clone();
            reversed.reverse();
            let whole = sum(&terms);
            prop_assert_eq!(whole.to_bits(), sum(&reversed).to_bits());
            let (a, b) = terms.split_at(cut.min(terms.len()));
            let halves = [a, b].map(|part| {
                let mut sum = ExactSum::ZERO;
                part.iter().for_each(|&t| sum.add(t));
                sum
            });
            let added: Vec<i64> =
                halves[0].words().iter().zip(halves[1].words()).map(|(a, b)| a + b).collect();
            prop_assert_eq!(whole.to_bits(), ExactSum::value(&added).to_bits());
            let plain: f64 = terms.iter().sum();
            let size: f64 = terms.iter().map(|t| t.abs()).sum();
            prop_assert!((whole - plain).abs() <= 40.0 * f64::EPSILON * size);
        }
    }
}
