//! Comparison of the fields of two runs, node by node and element by element.

use crumple::results::field_file::{PieceArrays, pieces, steps};
use crumple_worker::vtu::{CELL_ARRAYS, CONTACT_FORCE, POINT_ARRAYS, POINTS};
use std::collections::BTreeMap;
use std::path::Path;

/// Arrays that belong to the partition.
const OF_PARTITION: [&str; 2] = ["worker", "class"];

/// Bits of the components of each node or element, by the name of the array and the id.
type Values = BTreeMap<(&'static str, i64), Vec<u64>>;

/// Reads the pieces of all workers of an output. Nodes that several workers have must be equal.
fn values(step: &Path) -> Values {
    let mut all = Values::new();
    for path in pieces(step).unwrap() {
        let piece = PieceArrays::read(&path).unwrap();
        let of_nodes = [POINTS, CONTACT_FORCE].into_iter().chain(POINT_ARRAYS.iter().copied());
        let of_nodes = of_nodes.map(|array| (array, "node_id"));
        let of_elements = CELL_ARRAYS.iter().map(|&array| (array, "element_id"));
        for (array, ids) in of_nodes.chain(of_elements) {
            let Ok(numbers) = piece.array(array.name) else { continue }; // the scene has none
            let ids = piece.i64(ids).unwrap();
            assert_eq!(numbers.len(), array.components * ids.len(), "{}", array.name);
            for (&id, entry) in ids.iter().zip(numbers.chunks(array.components)) {
                let bits: Vec<u64> = entry.iter().map(|x| x.to_bits()).collect();
                let known = all.entry((array.name, id)).or_insert_with(|| bits.clone());
                let is_same = *known == bits || OF_PARTITION.contains(&array.name);
                assert!(
                    is_same,
                    "{}: {} of {id} differs between workers",
                    path.display(),
                    array.name
                );
            }
        }
    }
    all.retain(|(name, _), _| !OF_PARTITION.contains(name));
    all
}

/// Checks that two runs have fields at the same times, with the same bits at every node and
/// element.
///
/// # Panics
/// When they differ, or cannot be read.
pub fn assert_same_fields(one: &Path, other: &Path) {
    let of = |folder: &Path| steps(&folder.join("fields/fields.pvd")).unwrap();
    let (a, b) = (of(one), of(other));
    assert_eq!(a.len(), b.len(), "{}: number of outputs", other.display());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a.time, b.time);
        let (known, found) = (values(&a.file), values(&b.file));
        assert!(known.keys().eq(found.keys()), "{}: other nodes or elements", b.file.display());
        for ((name, id), bits) in &known {
            let other = &found[&(*name, *id)];
            assert_eq!(bits, other, "{}: {name} of {id}", b.file.display());
        }
    }
}
