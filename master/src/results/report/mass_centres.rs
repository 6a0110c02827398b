//! Displacements of the mass centres of rigid parts, from their momenta in `parts.csv`: a rigid
//! body moves as a whole, so this is a displacement for crush figures without a node in the
//! histories.

use super::histories::HistoryObject;
use std::collections::BTreeMap;

/// Kind of these objects.
pub const MASS_CENTRE: &str = "mass centre of part";

/// Mass centres of the rigid parts of a file, by the numbers of the parts in it.
pub struct MassCentres {
    /// Places of the mass and of the first component of the momentum among the quantities.
    mass: usize,
    momentum: usize,
    length_unit: String,
    paths: BTreeMap<usize, MassCentrePath>,
}

/// Path of the mass centre of a part. Its velocity is the momentum over the mass, and its
/// displacement is the sum of trapezoids of the velocity, which is exact for constant accelerations
/// between rows. Otherwise an interval h adds an error of at most h^3/12 times the largest second
/// derivative of the velocity, and at a jump of the velocity of at most h/2 times the jump.
struct MassCentrePath {
    name: String,
    /// Time and velocity of the last row.
    last: Option<(f64, [f64; 3])>,
    displacement: [f64; 3],
    columns: [Vec<f32>; 3],
}

impl MassCentres {
    /// Prepares columns of `rows` rows for the parts with `rigid` ids. `parts` are the quantities
    /// and the objects of the file. Returns none if its columns or their units do not suffice.
    pub fn new(
        (quantities, objects): (&[[String; 2]], &[String]),
        time_unit: &str,
        rigid: &[u32],
        rows: usize,
    ) -> Option<Self> {
        let place = |name: &str| quantities.iter().position(|q| q[0] == name);
        let (mass, momentum) = (place("mass")?, place("momentum x")?);
        if place("momentum z")? != momentum + 2 {
            return None;
        }
        // Mass, then length over time.
        let velocity = quantities[momentum][1].strip_prefix(&quantities[mass][1])?.trim_start();
        let length_unit = velocity.strip_suffix(time_unit)?.strip_suffix('/')?.to_owned();
        let is_rigid = |name: &str| {
            let id = name.split(' ').next().and_then(|id| id.parse().ok());
            id.is_some_and(|id| rigid.contains(&id))
        };
        let path = |name: &String| MassCentrePath {
            name: name.clone(),
            last: None,
            displacement: [0.0; 3],
            columns: [0, 1, 2].map(|_| vec![f32::NAN; rows]),
        };
        let parts = objects.iter().enumerate().filter(|(_, name)| is_rigid(name));
        let paths = parts.map(|(at, name)| (at, path(name))).collect();
        Some(Self { mass, momentum, length_unit, paths })
    }

    /// Advances a part to a time, which may have a row in the columns. `value` returns the
    /// quantities. Rows without a place in the columns still count, so that a thinned history has
    /// the same path.
    pub fn advance(
        &mut self,
        part: usize,
        (time, row): (f64, Option<usize>),
        value: impl Fn(usize) -> f64,
    ) {
        let Some(path) = self.paths.get_mut(&part) else { return };
        let v = [0, 1, 2].map(|c| value(self.momentum + c) / value(self.mass));
        if let Some((before, old)) = path.last.replace((time, v)) {
            let h = time - before;
            (0..3).for_each(|c| path.displacement[c] += 0.5 * h * (old[c] + v[c]));
        }
        if let Some(row) = row {
            (0..3).for_each(|c| path.columns[c][row] = path.displacement[c] as f32);
        }
    }

    /// Returns the mass centres with their columns.
    pub fn into_objects(self) -> impl Iterator<Item = (HistoryObject, [Vec<f32>; 3])> {
        let quantity = |c: &str, unit: &str| [format!("displacement {c}"), unit.to_owned()];
        let unit = self.length_unit;
        self.paths.into_values().map(move |path| {
            let quantities = ["x", "y", "z"].map(|c| quantity(c, &unit)).to_vec();
            (HistoryObject { kind: MASS_CENTRE, name: path.name, quantities }, path.columns)
        })
    }
}
