//! Pressure of concrete by its compaction, as in `*EOS_TABULATED_COMPACTION`: a curve over the
//! logarithm of the volume in loading, and a modulus of unloading by the largest compaction.
//! ```text
//! p = C(e_max) - K(e_max) (e_max - e),   e = -ln V
//! ```
//! C and K are linear between the rows and C goes on with its last slope. Beyond the last row K is
//! constant.

use super::super::parameters::Parameters;

/// Points between two rows at which the work of unloading is checked.
const CHECKS: usize = 20;

/// Part by which digits of a card may differ.
const ROUNDED: f64 = 1e-6;

/// Rows of volume strain -ln V, pressure and modulus of unloading.
pub(super) struct CompactionTable(Vec<[f64; 3]>);

impl CompactionTable {
    /// Reads a table, or reports what is wrong.
    pub(super) fn read(parameters: &mut Parameters<'_>, key: &'static str) -> Self {
        let form = "[volume strain, pressure, bulk modulus]";
        let Some(rows) = parameters.rows::<3>(key, form) else {
            let help = "give [[0, 0, bulk modulus], [volume strain, pressure, bulk modulus], ...]";
            parameters.wrong(key, "is missing", help);
            return Self(vec![[0.0, 0.0, 1.0]; 2]);
        };
        let ascends = rows
            .windows(2)
            .all(|two| two[0][0] < two[1][0] && two[0][1] < two[1][1] && two[0][2] <= two[1][2]);
        let starts = rows.first().is_some_and(|row| row[..2] == [0.0, 0.0] && row[2] > 0.0);
        if rows.len() < 2 || !ascends || !starts {
            let help = format!(
                "give two rows {form} and more from [0, 0, bulk modulus] on, strains and pressures \
                 that increase, and moduli that do not decrease"
            );
            parameters.wrong(key, "is not such a table", help);
            return Self(vec![[0.0, 0.0, 1.0]; 2]);
        }
        let table = Self(rows);
        if let Some(strain) = table.gives_energy() {
            let what = format!("gives back more work in unloading near the strain {strain:.4}");
            let help = "use larger bulk moduli, at least the slope of the pressure";
            parameters.wrong(key, what, help);
        }
        table
    }

    /// Returns pressure, its slope, modulus of unloading and its slope after this largest strain
    /// [force/length^2].
    fn loaded(&self, most: f64) -> [f64; 4] {
        let rows = &self.0;
        let next = rows.partition_point(|row| row[0] <= most).clamp(1, rows.len() - 1);
        let [low, high] = [rows[next - 1], rows[next]];
        let per = 1.0 / (high[0] - low[0]);
        let [slope, change] = [1, 2].map(|c| per * (high[c] - low[c]));
        let beyond = most - low[0];
        let pressure = slope.mul_add(beyond, low[1]);
        if most >= rows[rows.len() - 1][0] {
            return [pressure, slope, high[2], 0.0];
        }
        [pressure, slope, change.mul_add(beyond, low[2]), change]
    }

    /// Returns the modulus of unloading after this largest strain [force/length^2].
    pub(super) fn modulus(&self, most: f64) -> f64 {
        self.loaded(most)[2]
    }

    /// Returns the pressure at a strain after this largest one [force/length^2].
    pub(super) fn pressure(&self, most: f64, strain: f64) -> f64 {
        let [pressure, _, modulus, _] = self.loaded(most);
        modulus.mul_add(strain - most, pressure)
    }

    /// Returns a strain at which loading takes less work than unloading from there gives back more:
    /// `d(p^2/2 K) > p de`.
    fn gives_energy(&self) -> Option<f64> {
        let rows = &self.0;
        let last = rows[rows.len() - 1][0];
        let inside = rows.windows(2).flat_map(|two| {
            let step = (two[1][0] - two[0][0]) / CHECKS as f64;
            (0..CHECKS).map(move |k| two[0][0] + step * k as f64)
        });
        let gives = |&strain: &f64| {
            let [pressure, slope, modulus, change] = self.loaded(strain);
            slope / modulus - 0.5 * pressure * change / (modulus * modulus) > 1.0 + ROUNDED
        };
        inside.chain([last]).find(gives)
    }
}
