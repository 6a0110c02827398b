//! History columns of the elements of a block, group by group, in the lanes of its kernels.

use crumple_math::lanes::{LANES, LANES32, Lane, Lane32, Lanes, Real};
use crumple_proto::job::Precision;

/// Columns in double or single precision.
#[derive(Clone)]
pub enum HistoryStorage<D, S> {
    /// Groups of [`LANES`] elements.
    Double(D),
    /// Groups of [`LANES32`] elements.
    Single(S),
}

/// Columns of a block, mutable, for its kernels.
pub type HistoryColumnsMut<'a> = HistoryStorage<&'a mut [Lane], &'a mut [Lane32]>;

impl HistoryColumnsMut<'_> {
    /// Returns the number of elements per group.
    pub fn lanes(&self) -> usize {
        match self {
            Self::Double(_) => LANES,
            Self::Single(_) => LANES32,
        }
    }

    /// Cuts the columns of `all` groups into those of the first `groups` groups and the rest.
    pub fn split_at(self, groups: usize, all: usize) -> (Self, Self) {
        match self {
            Self::Double(columns) => {
                let (first, rest) = columns.split_at_mut(groups * (columns.len() / all));
                (Self::Double(first), Self::Double(rest))
            }
            Self::Single(columns) => {
                let (first, rest) = columns.split_at_mut(groups * (columns.len() / all));
                (Self::Single(first), Self::Single(rest))
            }
        }
    }
}

/// All columns of a block.
#[derive(Clone)]
pub struct HistoryColumns {
    /// Number of columns per element.
    each: usize,
    numbers: HistoryStorage<Vec<Lane>, Vec<Lane32>>,
}

impl HistoryColumns {
    /// Creates `each` columns of zeros for each of `elements` elements.
    pub fn new(precision: Precision, elements: usize, each: usize) -> Self {
        let numbers = match precision {
            Precision::Double => {
                HistoryStorage::Double(vec![Lane::ZERO; elements.div_ceil(LANES) * each])
            }
            Precision::Single => {
                HistoryStorage::Single(vec![Lane32::ZERO; elements.div_ceil(LANES32) * each])
            }
        };
        Self { each, numbers }
    }

    /// Returns the number of elements per group.
    pub fn lanes(&self) -> usize {
        match self.numbers {
            HistoryStorage::Double(_) => LANES,
            HistoryStorage::Single(_) => LANES32,
        }
    }

    /// Returns the bytes in use.
    pub fn bytes(&self) -> usize {
        match &self.numbers {
            HistoryStorage::Double(columns) => size_of_val(&columns[..]),
            HistoryStorage::Single(columns) => size_of_val(&columns[..]),
        }
    }

    /// Returns the columns of one element.
    pub fn element(&self, element: usize) -> ElementState<'_> {
        ElementState { columns: self, element }
    }

    /// Sets the columns of one element, rounded in single precision.
    pub fn set(&mut self, element: usize, state: &[f64]) {
        match &mut self.numbers {
            HistoryStorage::Double(columns) => set(columns, self.each, element, state),
            HistoryStorage::Single(columns) => set(columns, self.each, element, state),
        }
    }

    /// Sets one column of an element, rounded in single precision.
    #[inline]
    pub fn set_column(&mut self, element: usize, column: usize, value: f64) {
        let each = self.each;
        match &mut self.numbers {
            HistoryStorage::Double(columns) => {
                columns[element / LANES * each + column].as_mut_array()[element % LANES] = value;
            }
            HistoryStorage::Single(columns) => {
                columns[element / LANES32 * each + column].as_mut_array()[element % LANES32] =
                    value as f32;
            }
        }
    }

    /// Returns the columns for kernels.
    pub fn as_mut(&mut self) -> HistoryColumnsMut<'_> {
        match &mut self.numbers {
            HistoryStorage::Double(columns) => HistoryStorage::Double(columns),
            HistoryStorage::Single(columns) => HistoryStorage::Single(columns),
        }
    }
}

/// The columns of one element.
#[derive(Clone, Copy)]
pub struct ElementState<'a> {
    columns: &'a HistoryColumns,
    element: usize,
}

impl ElementState<'_> {
    /// Returns the value of a column.
    #[inline]
    pub fn at(&self, column: usize) -> f64 {
        let (e, each) = (self.element, self.columns.each);
        match &self.columns.numbers {
            HistoryStorage::Double(columns) => columns[e / LANES * each + column].lane(e % LANES),
            HistoryStorage::Single(columns) => {
                columns[e / LANES32 * each + column].lane(e % LANES32)
            }
        }
    }

    /// Returns true if all columns that `which` selects are zero.
    pub fn is_zero_where(&self, which: impl Fn(usize) -> bool) -> bool {
        (0..self.columns.each).all(|c| !which(c) || self.at(c) == 0.0)
    }

    /// Returns the values of all columns.
    pub fn to_vec(&self) -> Vec<f64> {
        (0..self.columns.each).map(|column| self.at(column)).collect()
    }
}

fn set<L: Lanes<W>, const W: usize>(columns: &mut [L], each: usize, element: usize, state: &[f64]) {
    for (column, &s) in columns[element / W * each..][..each].iter_mut().zip(state) {
        let mut numbers = column.to_array();
        numbers[element % W] = s;
        *column = L::from_array(numbers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inserted_columns_come_out_next_to_old_ones() {
        for precision in [Precision::Double, Precision::Single] {
            let mut columns = HistoryColumns::new(precision, 9, 3);
            let state = |element: usize| [0, 1, 2].map(|column| (10 * element + column) as f64);
            (0..9).rev().for_each(|element| columns.set(element, &state(element)));
            assert!(
                (0..9).all(|element| columns.element(element).to_vec() == state(element)),
                "{precision:?}"
            );
            columns.set(4, &[0.1, 0.0, 0.0]);
            let rounded = if precision == Precision::Double { 0.1 } else { f64::from(0.1f32) };
            assert_eq!(
                (columns.element(4).at(0), columns.element(5).to_vec()),
                (rounded, state(5).to_vec())
            );
            let numbers = columns.bytes() / 3;
            assert_eq!(
                numbers,
                if precision == Precision::Double { 12 * 8 } else { 16 * 4 },
                "whole groups"
            );
        }
    }
}
