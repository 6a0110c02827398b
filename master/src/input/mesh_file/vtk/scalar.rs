//! Types of numbers of VTK.

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarType {
    /// Eight numbers in a byte, the first one in its highest bit.
    Bit,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

use ScalarType::{Bit, F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};

/// Names in legacy files and in XML; empty if a form does not have the type.
const NAMES: &[(&str, &str, ScalarType)] = &[
    ("bit", "", Bit),
    ("char", "Int8", I8),
    ("signed_char", "Int8", I8),
    ("unsigned_char", "UInt8", U8),
    ("short", "Int16", I16),
    ("unsigned_short", "UInt16", U16),
    ("int", "Int32", I32),
    ("unsigned_int", "UInt32", U32),
    ("long", "Int64", I64),
    ("unsigned_long", "UInt64", U64),
    ("vtktypeint64", "Int64", I64),
    ("vtktypeuint64", "UInt64", U64),
    ("vtkidtype", "Int64", I64),
    ("float", "Float32", F32),
    ("double", "Float64", F64),
];

impl ScalarType {
    /// Returns the type of this name in legacy files. There, ids have 32 bits.
    pub fn legacy(name: &str) -> Option<Self> {
        let name = name.to_lowercase();
        match name.as_str() {
            "vtkidtype" => Some(I32),
            _ => NAMES.iter().find(|row| row.0 == name).map(|row| row.2),
        }
    }

    /// Returns the type of this name in XML.
    pub fn xml(name: &str) -> Option<Self> {
        NAMES.iter().find(|row| row.1 == name && !name.is_empty()).map(|row| row.2)
    }

    /// Returns the size of this many numbers [byte]; `None` if it is too large.
    pub fn size(self, count: usize) -> Option<usize> {
        match self {
            Bit => Some(count.div_ceil(8)),
            _ => count.checked_mul(self.width()),
        }
    }

    /// Returns the size of a number, or of a group of bits [byte].
    fn width(self) -> usize {
        match self {
            Bit | I8 | U8 => 1,
            I16 | U16 => 2,
            I32 | U32 | F32 => 4,
            I64 | U64 | F64 => 8,
        }
    }

    /// Returns the numbers of these bytes. A rest that is no whole number is left out; bits come in
    /// groups of eight.
    pub fn numbers(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        if self == Bit {
            let bits = |byte: &u8| {
                let byte = *byte;
                (0..8).map(move |bit| f64::from(byte >> (7 - bit) & 1))
            };
            return bytes.iter().flat_map(bits).collect();
        }
        let of = |bytes: &[u8]| {
            let mut raw = [0u8; 8];
            let used = &mut raw[..bytes.len()];
            used.copy_from_slice(bytes);
            if big_endian {
                used.reverse();
            }
            let [a, b, c, d, ..] = raw;
            match self {
                I8 => f64::from(a as i8),
                Bit | U8 => f64::from(a),
                I16 => f64::from(i16::from_le_bytes([a, b])),
                U16 => f64::from(u16::from_le_bytes([a, b])),
                I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
                U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
                F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
                I64 => i64::from_le_bytes(raw) as f64,
                U64 => u64::from_le_bytes(raw) as f64,
                F64 => f64::from_le_bytes(raw),
            }
        };
        bytes.chunks_exact(self.width()).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_both_byte_orders() {
        assert_eq!(I16.numbers(&[1, 0, 255, 255, 9], false), [1.0, -1.0]);
        assert_eq!(I16.numbers(&[0, 1, 255, 255], true), [1.0, -1.0]);
        assert_eq!(F64.numbers(&2.5f64.to_be_bytes(), true), [2.5]);
        assert_eq!(F32.numbers(&2.5f32.to_le_bytes(), false), [2.5]);
        assert_eq!(U8.numbers(&[200], true), [200.0]);
    }

    /// Bits are in the order of the numbers from the highest one on: 0xa0 is 1, 0, 1.
    #[test]
    fn bits_fill_bytes_from_the_highest_one() {
        assert_eq!(Bit.numbers(&[0xa0], true)[..4], [1.0, 0.0, 1.0, 0.0]);
        assert_eq!([0, 1, 8, 9].map(|count| Bit.size(count)), [0, 1, 1, 2].map(Some));
        assert_eq!(ScalarType::legacy("signed_char"), Some(I8));
        assert_eq!(F64.size(usize::MAX), None);
    }
}
