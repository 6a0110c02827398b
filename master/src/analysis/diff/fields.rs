//! Fields of two runs, node by node and element by element.

use super::{Comparison, Difference, paired};
use crate::results::field_file::{FieldStep, steps};
use crate::results::fields::{COLLECTION, DIR};
use crate::results::snapshot::{Snapshot, SnapshotArray};
use crumple_worker::vtu::{self, Array, CELL_ARRAYS, POINT_ARRAYS};
use std::path::Path;

/// Arrays that depend on the number of workers, or only name the point or cell.
const LEFT_OUT: [Array; 4] = [vtu::NODE_ID, vtu::ELEMENT_ID, vtu::WORKER, vtu::CLASS];

/// Compares the fields that both folders have.
///
/// # Errors
/// A field file is damaged; the message names it.
pub(super) fn compare(folders: [&Path; 2]) -> Result<Comparison, String> {
    let mut all = Comparison::default();
    let collections = folders.map(|dir| dir.join(DIR).join(COLLECTION));
    if !collections.iter().all(|path| path.exists()) {
        return Ok(all);
    }
    let [a, b] = [steps(&collections[0])?, steps(&collections[1])?];
    let times = |list: &[FieldStep]| list.iter().map(|step| step.time).collect::<Vec<_>>();
    let moments = paired(&times(&a), &times(&b));
    all.unpaired = a.len() + b.len() - 2 * moments.len();
    for (i, j) in moments {
        let found = differences(&Snapshot::read(&a[i])?, &Snapshot::read(&b[j])?);
        let time = a[i].time;
        all.add((None, time), found);
    }
    Ok(all)
}

/// Points or cells of a snapshot: their ids and their arrays.
struct Column<'a> {
    ids: &'a [i64],
    numbers: Vec<f64>,
}

/// Returns the largest difference of each component of each array.
fn differences(a: &Snapshot, b: &Snapshot) -> Vec<Difference> {
    let mut found = Vec::new();
    for (at, array) in POINT_ARRAYS.iter().enumerate().filter(|(_, a)| is_compared(a)) {
        let of = |s: &'_ Snapshot| numbers(&s.point_arrays[at]);
        let columns = [
            Column { ids: &a.topology.nodes, numbers: of(a) },
            Column { ids: &b.topology.nodes, numbers: of(b) },
        ];
        found.extend(of_array(array, "node", columns));
    }
    let ids = [a, b].map(element_ids);
    for (at, array) in CELL_ARRAYS.iter().enumerate().filter(|(_, a)| is_compared(a)) {
        let of = |s: &'_ Snapshot| numbers(&s.cell_arrays[at]);
        let columns =
            [Column { ids: &ids[0], numbers: of(a) }, Column { ids: &ids[1], numbers: of(b) }];
        found.extend(of_array(array, "element", columns));
    }
    found
}

fn is_compared(array: &Array) -> bool {
    LEFT_OUT.iter().all(|left| left.name != array.name)
}

fn element_ids(s: &Snapshot) -> Vec<i64> {
    let at = CELL_ARRAYS.iter().position(|array| array.name == vtu::ELEMENT_ID.name);
    match at.and_then(|at| s.cell_arrays.get(at)) {
        Some(SnapshotArray::I64(ids)) => ids.clone(),
        _ => Vec::new(),
    }
}

fn numbers(array: &SnapshotArray) -> Vec<f64> {
    match array {
        SnapshotArray::F32(all) => all.iter().map(|&a| f64::from(a)).collect(),
        SnapshotArray::U32(all) => all.iter().map(|&a| f64::from(a)).collect(),
        SnapshotArray::I64(all) => all.iter().map(|&a| a as f64).collect(),
        SnapshotArray::U8(all) => all.iter().map(|&a| f64::from(a)).collect(),
    }
}

/// Returns the largest difference of each component, and how many points or cells only one of the
/// snapshots has.
fn of_array(array: &Array, kind: &str, [a, b]: [Column<'_>; 2]) -> Vec<Difference> {
    let width = array.components;
    let mut largest: Vec<Option<Difference>> = vec![None; width];
    let (mut i, mut j) = (0, 0);
    let mut single = None;
    while i < a.ids.len() || j < b.ids.len() {
        let (x, y) = (a.ids.get(i), b.ids.get(j));
        if x != y {
            let (is_first, id) = match (x, y) {
                (Some(x), Some(y)) if x > y => (false, y),
                (Some(x), _) => (true, x),
                (None, Some(y)) => (false, y),
                (None, None) => break,
            };
            let values = if is_first { ["there", "missing"] } else { ["missing", "there"] };
            single.get_or_insert_with(|| Difference {
                quantity: kind.into(),
                place: format!("{kind} {id}"),
                values: values.map(String::from),
                by: None,
            });
            if is_first {
                i += 1
            } else {
                j += 1
            }
            continue;
        }
        for (c, known) in largest.iter_mut().enumerate() {
            let values = [a.numbers[width * i + c], b.numbers[width * j + c]];
            let name = component(array, c);
            let place = || format!("{kind} {}", a.ids[i]);
            if let Some(one) = Difference::between(&name, place, values)
                && known.as_ref().is_none_or(|known| one.by > known.by)
            {
                *known = Some(one);
            }
        }
        (i, j) = (i + 1, j + 1);
    }
    // Points that one of the runs lacks are named once, with the first array.
    let is_first = [POINT_ARRAYS[0].name, CELL_ARRAYS[0].name].contains(&array.name);
    single.filter(|_| is_first).into_iter().chain(largest.into_iter().flatten()).collect()
}

/// Returns the name of a component, such as `stress xy`.
fn component(array: &Array, at: usize) -> String {
    let axes: &[&str] = match array.components {
        3 => &["x", "y", "z"],
        6 => &["xx", "yy", "zz", "xy", "yz", "zx"],
        _ => return array.name.into(),
    };
    format!("{} {}", array.name, axes[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_of_a_component_names_its_node() {
        let of = |ids, numbers: &[f64]| Column { ids, numbers: numbers.to_vec() };
        let (all, some) = ([4, 7, 9], [4, 9]);
        let a = [0.0, 1.0, 2.0, 5.0, 5.0, 5.0, 3.0, 3.0, 3.0];
        let found = of_array(&vtu::VELOCITY, "node", [of(&all, &a), of(&all, &a)]);
        assert_eq!(found, []);
        let b = [0.0, 1.5, 2.0, 3.0, 2.0, 3.0];
        let found = of_array(&vtu::VELOCITY, "node", [of(&all, &a), of(&some, &b)]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((&found[0].place[..], found[0].by), ("node 9", Some(1.0)));
        assert_eq!(found[0].quantity, "velocity y");
        let found = of_array(&vtu::DISPLACEMENT, "node", [of(&all, &a), of(&some, &b)]);
        assert_eq!((&found[0].place[..], &found[0].values[1][..]), ("node 7", "missing"));
    }
}
