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

/// Nodes and elements of a checkpoint.
#[derive(Default)]
struct SavedState {
    nodes: BTreeMap<NodeId, NodeRecord>,
    /// History columns.
    elements: BTreeMap<ElemId, Vec<f64>>,
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
        let found = differences(&states);
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
            state.elements.extend(piece.share.elements.into_iter().map(|(e, own)| (e.id, own)));
        }
        Ok(state)
    }
}

/// Returns the largest difference of each component of the nodes, and that of the columns of the
/// elements.
fn differences([a, b]: &[SavedState; 2]) -> Vec<Difference> {
    let mut largest: BTreeMap<String, Difference> = BTreeMap::new();
    let mut add = |quantity: &str, place: &dyn Fn() -> String, values: [f64; 2]| {
        if let Some(one) = Difference::between(quantity, place, values)
            && largest.get(quantity).is_none_or(|known| one.by > known.by)
        {
            largest.insert(quantity.into(), one);
        }
    };
    for (id, node) in &a.nodes {
        let Some(other) = b.nodes.get(id) else { continue };
        let vectors = [
            ("position", node.x, other.x),
            ("velocity", node.v, other.v),
            ("rotational velocity", node.w, other.w),
        ];
        for (name, x, y) in vectors {
            for (c, axis) in ["x", "y", "z"].iter().enumerate() {
                add(&format!("{name} {axis}"), &|| format!("node {id}"), [x[c], y[c]]);
            }
        }
    }
    for (id, own) in &a.elements {
        let Some(other) = b.elements.get(id) else { continue };
        for (&x, &y) in own.iter().zip(other) {
            add("history of elements", &|| format!("element {id}"), [x, y]);
        }
    }
    largest.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_difference_of_a_node_or_an_element_is_seen() {
        let state = |x: f64, column: f64| SavedState {
            nodes: [1, 2]
                .map(|i| (NodeId(i), NodeRecord { x: [x; 3], ..Default::default() }))
                .into(),
            elements: [(ElemId(5), vec![0.0, column])].into(),
        };
        assert_eq!(differences(&[state(1.0, 2.0), state(1.0, 2.0)]), []);
        let found = differences(&[state(1.0, 2.0), state(1.0, 2.0 + 4e-16)]);
        assert_eq!((found.len(), &found[0].place[..]), (1, "element 5"));
        let found = differences(&[state(1.0, 2.0), state(1.5, 2.0)]);
        assert_eq!((found.len(), &found[0].place[..]), (3, "node 1"));
    }
}
