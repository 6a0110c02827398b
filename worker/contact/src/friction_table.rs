//! Coefficients of friction by contact pressure and sliding speed.
//!
//! The table is that of LS-DYNA's *CONTACT with FS = 2 (Keyword User's Manual, volume I, *CONTACT,
//! mandatory card 2, and volume II, *DEFINE_TABLE): curves of the coefficient over the sliding
//! speed at ascending pressures. Between them it is interpolated linearly; beyond the first and the
//! last one it is constant.

/// Coefficients of friction by pressure and speed.
#[derive(Clone, Debug)]
pub struct FrictionTable {
    /// Curves in ascending order of their pressures [force/length^2]: points of speed
    /// [length/time] and coefficient, with ascending speeds.
    curves: Vec<(f64, Vec<[f64; 2]>)>,
}

impl FrictionTable {
    /// Builds the table from rows of pressure, speed and coefficient; `None` without rows. The
    /// master checks their order.
    pub fn new(rows: &[[f64; 3]]) -> Option<Self> {
        let curve = |same: &[[f64; 3]]| (same[0][0], same.iter().map(|r| [r[1], r[2]]).collect());
        let curves: Vec<_> = rows.chunk_by(|a, b| a[0] == b[0]).map(curve).collect();
        (!curves.is_empty()).then_some(Self { curves })
    }

    /// Returns the largest coefficient.
    pub fn largest(&self) -> f64 {
        self.curves.iter().flat_map(|c| &c.1).map(|point| point[1]).fold(0.0, f64::max)
    }

    /// Computes the coefficient at a pressure [force/length^2] and a speed [length/time].
    pub fn coefficient(&self, pressure: f64, speed: f64) -> f64 {
        let at = |i: usize| {
            let curve = &self.curves[i].1;
            between(curve.len(), |k| curve[k][0], |k| curve[k][1], speed)
        };
        between(self.curves.len(), |i| self.curves[i].0, at, pressure)
    }
}

/// Interpolates linearly between `count` points with ascending places `place` and the values
/// `value`, with constant values beyond the ends.
fn between(
    count: usize,
    place: impl Fn(usize) -> f64,
    value: impl Fn(usize) -> f64,
    at: f64,
) -> f64 {
    let next = (0..count).find(|&i| at < place(i)).unwrap_or(count);
    if next == 0 || next == count {
        return value(next.min(count - 1));
    }
    let (a, b) = (place(next - 1), place(next));
    value(next - 1) + (value(next) - value(next - 1)) * (at - a) / (b - a)
}

#[cfg(test)]
mod tests {
    use super::FrictionTable;

    #[test]
    fn coefficients_are_interpolated_over_pressure_and_speed() {
        let rows = [
            [0.0, 0.0, 0.4],
            [0.0, 10.0, 0.2],
            [2.0, 0.0, 0.2],
            [2.0, 20.0, 0.1],
            [4.0, 0.0, 0.05],
        ];
        let table = FrictionTable::new(&rows).unwrap();
        let near = |at: [f64; 2], wanted: f64| {
            let found = table.coefficient(at[0], at[1]);
            assert!((found - wanted).abs() < 1e-15, "{at:?}: {found}, wanted {wanted}");
        };
        near([0.0, 0.0], 0.4);
        near([0.0, 5.0], 0.3);
        near([0.0, 99.0], 0.2);
        near([1.0, 10.0], 0.5 * (0.2 + 0.15));
        near([3.0, 5.0], 0.5 * (0.175 + 0.05));
        near([9.0, 5.0], 0.05);
        assert_eq!(table.largest(), 0.4);
        assert!(FrictionTable::new(&[]).is_none());
    }
}
