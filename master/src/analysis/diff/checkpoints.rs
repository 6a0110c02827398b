//! Checkpoints of two runs: nodes and elements with all digits.

use super::{Comparison, Difference};
use crate::run::checkpoint::find::{DIR, folders};
use crate::run::checkpoint::manifest::Manifest;
use crumple_proto::checkpoint::read;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::partition::NodeRecord;
use crumple_worker::checkpoint::CheckpointPiece;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Nodes and elements of a checkpoint, or of a run in progress.
#[derive(Default)]
pub(super) struct SavedState {
    pub(super) nodes: BTreeMap<NodeId, NodeRecord>,
    pub(super) elements: BTreeMap<ElemId, ElementColumns>,
}

/// State of an element.
#[derive(Clone)]
pub(super) struct ElementColumns {
    /// Names of its columns; without names all of them are one quantity.
    pub(super) names: Arc<[String]>,
    pub(super) values: Vec<f64>,
}

/// Compares the checkpoints of the same cycles.
///
/// # Errors
/// A file of a checkpoint is damaged; the message names it.
pub(super) fn compare(dirs: [&Path; 2]) -> Result<Comparison, String> {
    let mut all = Comparison::default();
    let [a, b] = dirs.map(by_cycle);
    let both = a.keys().filter(|cycle| b.contains_key(cycle)).count();
    all.unpaired = a.len() + b.len() - 2 * both;
    for (&cycle, (folder, manifest)) in &a {
        let Some((other, of_other)) = b.get(&cycle) else { continue };
        let time = manifest.captured.time;
        let states = [SavedState::read(folder, manifest)?, SavedState::read(other, of_other)?];
        let found = [of_nodes(states.each_ref()), of_elements(states.each_ref())].concat();
        all.add((Some(cycle), time), found);
    }
    Ok(all)
}

/// Returns the complete checkpoints of a run.
fn by_cycle(dir: &Path) -> BTreeMap<u64, (PathBuf, Manifest)> {
    let whole = |folder: PathBuf| {
        let manifest = Manifest::read(&folder).ok()?;
        Some((manifest.captured.cycle, (folder, manifest)))
    };
    folders(&dir.join(DIR)).into_iter().filter_map(whole).collect()
}

impl SavedState {
    fn read(folder: &Path, manifest: &Manifest) -> Result<Self, String> {
        let mut state = Self::default();
        for record in &manifest.pieces {
            let words = read(folder, record)?;
            let piece = CheckpointPiece::new(&words)
                .map_err(|why| format!("{}: {why}", folder.join(&record.name).display()))?;
            state.nodes.extend(piece.share.nodes.into_iter().map(|node| (node.id, node)));
            let columns = |values| ElementColumns { names: Arc::new([]), values };
            let elements = piece.share.elements.into_iter();
            state.elements.extend(elements.map(|(e, values)| (e.id, columns(values))));
        }
        Ok(state)
    }
}

/// Returns the components of the state of a node. A node without rotational inertia has no
/// rotational velocity.
pub(super) fn components(node: &NodeRecord) -> [(&'static str, f64); 9] {
    let w = if node.inertia > 0.0 { node.w } else { [0.0; 3] };
    let [x, v] = [node.x, node.v];
    [
        ("position x", x[0]),
        ("position y", x[1]),
        ("position z", x[2]),
        ("velocity x", v[0]),
        ("velocity y", v[1]),
        ("velocity z", v[2]),
        ("rotational velocity x", w[0]),
        ("rotational velocity y", w[1]),
        ("rotational velocity z", w[2]),
    ]
}

/// The largest difference of each quantity so far, and the largest magnitude of the quantity.
#[derive(Default)]
struct LargestByQuantity(BTreeMap<String, (Option<Difference>, f64)>);

impl LargestByQuantity {
    fn add(&mut self, quantity: &str, place: impl FnOnce() -> String, values: [f64; 2]) {
        if !self.0.contains_key(quantity) {
            self.0.insert(quantity.into(), (None, 0.0));
        }
        let Some((largest, magnitude)) = self.0.get_mut(quantity) else { return };
        *magnitude = values.iter().fold(*magnitude, |known, value| known.max(value.abs()));
        if let Some(one) = Difference::between(quantity, place, values)
            && largest.as_ref().is_none_or(|known| one.by > known.by)
        {
            *largest = Some(one);
        }
    }

    /// Returns the differences. The first one is the largest, over the magnitude of its quantity.
    fn sorted(self) -> Vec<Difference> {
        let found = self.0.into_values();
        let found = found.filter_map(|(largest, magnitude)| Some((largest?, magnitude)));
        let share = |(one, magnitude): (Difference, f64)| {
            (one.by.unwrap_or_default() / magnitude.max(f64::MIN_POSITIVE), one)
        };
        let mut found: Vec<(f64, Difference)> = found.map(share).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, one)| one).collect()
    }
}

/// Returns the largest difference of each component of the nodes, the largest one first.
pub(super) fn of_nodes([a, b]: [&SavedState; 2]) -> Vec<Difference> {
    let mut largest = LargestByQuantity::default();
    for (id, node) in &a.nodes {
        let Some(other) = b.nodes.get(id) else { continue };
        for ((name, x), (_, y)) in components(node).into_iter().zip(components(other)) {
            largest.add(name, || format!("node {id}"), [x, y]);
        }
    }
    largest.sorted()
}

/// Returns the largest difference of each column of the elements, the largest one first.
pub(super) fn of_elements([a, b]: [&SavedState; 2]) -> Vec<Difference> {
    let mut largest = LargestByQuantity::default();
    for (id, own) in &a.elements {
        let Some(other) = b.elements.get(id) else { continue };
        let place = || format!("element {id}");
        let counts = [own, other].map(|columns| columns.values.len() as f64);
        if counts[0] != counts[1] {
            largest.add("number of columns", place, counts);
            continue;
        }
        for (at, (&x, &y)) in own.values.iter().zip(&other.values).enumerate() {
            let name = own.names.get(at).map_or("history of elements", String::as_str);
            largest.add(name, place, [x, y]);
        }
    }
    largest.sorted()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(x: f64, v: f64, column: f64) -> SavedState {
        let node = NodeRecord { x: [x; 3], v: [v; 3], ..Default::default() };
        let names = Arc::new(["stress".to_string(), "strain".to_string()]);
        SavedState {
            nodes: [1, 2].map(|i| (NodeId(i), NodeRecord { id: NodeId(i), ..node })).into(),
            elements: [(ElemId(5), ElementColumns { names, values: vec![0.0, column] })].into(),
        }
    }

    #[test]
    fn the_smallest_difference_of_a_node_or_an_element_is_seen() {
        let [a, same] = [state(1.0, 0.0, 2.0), state(1.0, 0.0, 2.0)];
        assert_eq!((of_nodes([&a, &same]), of_elements([&a, &same])), (vec![], vec![]));
        let other = state(1.0, 0.0, 2.0 + 4e-16);
        assert_eq!(of_nodes([&a, &other]), []);
        let found = of_elements([&a, &other]);
        let named = (found.len(), &found[0].place[..], &found[0].quantity[..]);
        assert_eq!(named, (1, "element 5", "strain"));
        let found = of_nodes([&a, &state(1.5, 0.0, 2.0)]);
        assert_eq!((found.len(), &found[0].place[..]), (3, "node 1"));
    }

    /// A velocity has changed by a tenth, all positions by less, in larger numbers.
    #[test]
    fn the_largest_difference_over_the_magnitude_of_its_quantity_is_first() {
        let (a, mut b) = (state(1000.0, 1.0, 2.0), state(1001.0, 1.0, 2.0));
        b.nodes.get_mut(&NodeId(2)).unwrap().v[1] = 1.1;
        let found = of_nodes([&a, &b]);
        let names: Vec<&str> = found.iter().map(|one| &one.quantity[..]).collect();
        assert_eq!(names, ["velocity y", "position x", "position y", "position z"]);
        assert_eq!(found[0].place, "node 2");
    }

    #[test]
    fn a_node_without_inertia_has_no_rotation_and_other_columns_are_a_difference() {
        let (a, mut b) = (state(1.0, 1.0, 2.0), state(1.0, 1.0, 2.0));
        b.nodes.get_mut(&NodeId(1)).unwrap().w = [1.0; 3];
        assert_eq!(of_nodes([&a, &b]), []);
        b.elements.get_mut(&ElemId(5)).unwrap().values.push(0.0);
        let found = of_elements([&a, &b]);
        assert_eq!((found.len(), &found[0].quantity[..]), (1, "number of columns"));
    }
}
