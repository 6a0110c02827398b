//! Rows of nodal columns, and the vector of the worker.

use nalgebra::Vector3;

/// Three components and one of padding, so that a row fills one vector register.
pub type Row = [f64; 4];

/// Vector in space.
pub type V3 = Vector3<f64>;

/// Returns a row of three components.
#[inline]
pub fn row(a: [f64; 3]) -> Row {
    [a[0], a[1], a[2], 0.0]
}

/// Returns the three components of a row.
#[inline]
pub fn xyz(r: &Row) -> [f64; 3] {
    [r[0], r[1], r[2]]
}
