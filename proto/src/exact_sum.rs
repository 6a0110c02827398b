//! Sums that do not depend on the order of their terms, so that they are equal for any
//! distribution of elements, nodes and pairs over workers.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// Number of digits for the range of `f64`, from 2^-1074, including the carry of a term.
const DIGITS: usize = 67;
/// Number of bits of a digit. A word overflows after 2^31 terms, unless [`ExactSum::carry`] makes
/// room for more.
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

impl Default for ExactSum {
    fn default() -> Self {
        Self::ZERO
    }
}

impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        self.digits() == other.digits() && self.words[DIGITS] == other.words[DIGITS]
    }
}

impl FromIterator<f64> for ExactSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::ZERO;
        terms.into_iter().for_each(|term| sum.add(term));
        sum
    }
}

impl ExactSum {
    /// The sum of no terms.
    pub const ZERO: Self = Self { words: [0; WORDS] };

    /// Adds a term.
    #[inline]
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
        // In two's complement only the highest of the three digits is negative.
        let signed = if term < 0.0 { -(mantissa as i128) } else { mantissa as i128 };
        let shifted = signed << (place % BITS);
        let digits = &mut self.words[place / BITS..][..3];
        digits[0] += i64::from(shifted as u32);
        digits[1] += i64::from((shifted >> BITS) as u32);
        digits[2] += (shifted >> (2 * BITS)) as i64;
    }

    /// Adds the terms of another sum.
    pub fn merge(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a += b);
    }

    /// Removes the terms of another sum.
    pub fn remove(&mut self, other: &Self) {
        self.words[..DIGITS].iter_mut().zip(&other.words).for_each(|(a, b)| *a -= b);
        self.words[DIGITS] += other.words[DIGITS];
    }

    /// Makes room for another 2^31 terms.
    pub fn carry(&mut self) {
        let mut digits = [0; DIGITS];
        digits.copy_from_slice(&self.words[..DIGITS]);
        // The sum of all terms is within the range: a negative one keeps a negative top digit.
        let over = carry(&mut digits);
        digits[DIGITS - 1] += over << BITS;
        self.words[..DIGITS].copy_from_slice(&digits);
    }

    /// Returns the words, to be added to those of other workers.
    pub fn words(&self) -> &[i64; WORDS] {
        &self.words
    }

    /// Returns the sum, rounded; NaN if a term was not finite.
    pub fn value(&self) -> f64 {
        Self::value_of(&self.words)
    }

    /// Returns true for a negative sum, and the digits of its magnitude.
    fn digits(&self) -> (bool, [i64; DIGITS]) {
        magnitude(&self.words)
    }

    /// Returns the value of summed words, NaN if a term was not finite. `words` has [`WORDS`]
    /// entries.
    pub fn value_of(words: &[i64]) -> f64 {
        if words[DIGITS] != 0 {
            return f64::NAN;
        }
        let (negative, digits) = magnitude(words);
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

/// Sign, number of the lowest digit, digits from there to the highest one that is not zero, number
/// of terms that are not finite.
#[derive(Serialize, Deserialize)]
struct PackedSum(bool, u8, Vec<u32>, u64);

impl Serialize for ExactSum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (negative, digits) = self.digits();
        let first = digits.iter().position(|&d| d != 0).unwrap_or(0);
        let end = digits.iter().rposition(|&d| d != 0).map_or(0, |last| last + 1);
        let shown = digits[first..end.max(first)].iter().map(|&d| d as u32).collect();
        PackedSum(negative, first as u8, shown, self.words[DIGITS] as u64).serialize(serializer)
    }
}

impl<'a> Deserialize<'a> for ExactSum {
    fn deserialize<D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        let PackedSum(negative, first, digits, others) = PackedSum::deserialize(deserializer)?;
        let mut sum = Self::ZERO;
        let place = usize::from(first)..usize::from(first) + digits.len();
        let words = sum.words[..DIGITS].get_mut(place);
        let words = words.ok_or_else(|| D::Error::custom("a sum has too many digits"))?;
        for (word, digit) in words.iter_mut().zip(digits) {
            *word = if negative { -i64::from(digit) } else { i64::from(digit) };
        }
        // More terms were never added; such a number could overflow.
        let others = i64::try_from(others).ok().filter(|&others| others < 1 << 53);
        sum.words[DIGITS] = others.ok_or_else(|| D::Error::custom("a sum has too many terms"))?;
        Ok(sum)
    }
}

/// Returns true for a negative sum, and the digits of its magnitude.
fn magnitude(words: &[i64]) -> (bool, [i64; DIGITS]) {
    let mut digits = [0i64; DIGITS];
    digits.copy_from_slice(&words[..DIGITS]);
    let negative = carry(&mut digits) < 0;
    if negative {
        digits.iter_mut().for_each(|d| *d = -*d);
        carry(&mut digits);
    }
    (negative, digits)
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
    use crate::wire::{decode, encode};
    use proptest::prelude::*;

    fn sum(terms: &[f64]) -> f64 {
        terms.iter().copied().collect::<ExactSum>().value()
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
            let [mut one, other] = [a, b].map(|part| part.iter().copied().collect::<ExactSum>());
            let added: Vec<i64> =
                one.words().iter().zip(other.words()).map(|(a, b)| a + b).collect();
            prop_assert_eq!(whole.to_bits(), ExactSum::value_of(&added).to_bits());
            let sent: ExactSum = decode(&encode(&other)).unwrap();
            prop_assert_eq!(&sent, &other);
            one.merge(&sent);
            prop_assert_eq!(whole.to_bits(), one.value().to_bits());
            // Digits that were carried are those of the same sum.
            let mut carried = one.clone();
            carried.carry();
            prop_assert_eq!(&carried, &one);
            let mut twice = one.clone();
            twice.merge(&one);
            carried.merge(&one);
            prop_assert_eq!(&carried, &twice);
            carried.remove(&one);
            prop_assert_eq!(&carried, &one);
            let plain: f64 = terms.iter().sum();
            let size: f64 = terms.iter().map(|t| t.abs()).sum();
            prop_assert!((whole - plain).abs() <= 40.0 * f64::EPSILON * size);
        }
    }
}
