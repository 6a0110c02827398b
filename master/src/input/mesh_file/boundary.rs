//! Groups of elements that only bound other elements: faces of solids, edges of shells. They are
//! sets of nodes and no parts.

use super::reading::{Fate, MeshReading};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A group of cells of one dimension.
pub struct CellGroup<'a> {
    /// Dimension of their geometry.
    pub dimension: usize,
    /// Ids of the nodes of each cell.
    pub cells: Vec<&'a [u64]>,
}

/// Returns for each group whether all its cells bound cells of higher dimension: each has its nodes
/// in common with one of them.
pub fn bounding(groups: &[CellGroup]) -> Vec<bool> {
    let mut at_node: [HashMap<u64, Vec<&[u64]>>; 2] = [HashMap::new(), HashMap::new()];
    for group in groups.iter().filter(|g| g.dimension >= 2) {
        for cell in &group.cells {
            for &node in *cell {
                at_node[group.dimension.min(3) - 2].entry(node).or_default().push(cell);
            }
        }
    }
    let bounds = |dimension: usize, cell: &[u64]| {
        let nodes: HashSet<u64> = cell.iter().copied().collect();
        let higher = at_node.iter().skip(dimension.max(1) - 1);
        higher
            .filter_map(|at| at.get(cell.first()?))
            .flatten()
            .any(|other| nodes.iter().all(|node| other.contains(node)))
    };
    let is_bound = |group: &CellGroup| group.cells.iter().all(|cell| bounds(group.dimension, cell));
    groups.iter().map(|g| g.dimension < 3 && !g.cells.is_empty() && is_bound(g)).collect()
}

/// Removes elements that only bound others from parts without section and material, and adds the
/// set of their nodes.
pub fn drop_bounding(reading: &mut MeshReading) {
    let mesh = &mut reading.mesh;
    let is_bare = |part: usize| {
        let part = &mesh.parts[part];
        part.material.is_none() && part.thickness.is_none() && part.beam.is_none()
    };
    // By part, dimension, and whether the part is bare.
    let mut by_part: BTreeMap<(usize, usize, bool), Vec<usize>> = BTreeMap::new();
    for (index, element) in mesh.elements.iter().enumerate() {
        let dimension = match element.shape {
            shape if shape.is_solid() => 3,
            shape if shape.is_shell() => 2,
            _ => 1,
        };
        by_part.entry((element.part, dimension, is_bare(element.part))).or_default().push(index);
    }
    let groups: Vec<CellGroup> = by_part
        .iter()
        .map(|((_, dimension, _), own)| CellGroup {
            dimension: *dimension,
            cells: own.iter().map(|&index| &mesh.elements[index].corners[..]).collect(),
        })
        .collect();
    let bounds = bounding(&groups);
    let mut dropped = HashSet::new();
    let mut rows = Vec::new();
    for (((part, dimension, bare), own), bounds) in by_part.iter().zip(bounds) {
        if *bare && bounds {
            let kind = if *dimension == 1 { "edges" } else { "faces" };
            let name = format!("{kind}_{}", mesh.parts[*part].id);
            let nodes = own.iter().flat_map(|&index| mesh.elements[index].corners.clone());
            let nodes: Vec<u64> = nodes.collect();
            mesh.add_set(&name, &name, nodes);
            rows.push((name, own.len()));
            dropped.extend(own.iter().copied());
        }
    }
    let mut index = 0;
    mesh.elements.retain(|_| {
        index += 1;
        !dropped.contains(&(index - 1))
    });
    for (name, count) in rows {
        let became = format!("only node set `{name}`: they have no property and bound others");
        reading.row(Fate::Read, name, count, became);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lower face of a cube and the edges of it bound the cube; a quad away from it does not,
    /// and its edge bounds only the quad.
    #[test]
    fn faces_and_edges_bound_and_others_do_not() {
        let group =
            |dimension, cells: &[&'static [u64]]| CellGroup { dimension, cells: cells.to_vec() };
        let groups = [
            group(3, &[&[1, 2, 3, 4, 5, 6, 7, 8]]),
            group(2, &[&[4, 3, 2, 1]]),
            group(2, &[&[4, 3, 2, 1], &[5, 6, 9, 10]]),
            group(1, &[&[2, 3], &[9, 10]]),
            group(1, &[&[9, 11]]),
            group(0, &[&[9]]),
        ];
        assert_eq!(bounding(&groups), [false, true, false, true, false, true]);
    }
}
