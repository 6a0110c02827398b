//! VTK files: XML (`.vtu`, `.vtp`) and legacy (`.vtk`), as text, base64, raw or compressed data
//! (VTK User's Guide, "VTK file formats").
//!
//! An array of the cells such as `part`, `MaterialID`, `gmsh:physical` or `CellEntityIds` gives the
//! parts; without it all cells of one dimension are a part.

mod legacy;
mod scalar;
mod xml;

use super::boundary::{CellGroup, bounding};
use super::cells::Cell;
use super::content::{FileNode, FilePlace};
use super::reading::{Fate, MeshReading};
use std::collections::{BTreeMap, HashSet};

pub use legacy::read as read_legacy;
pub use xml::read as read_xml;

/// Arrays of cells that give parts, in small letters, the first one that is there.
const PART_ARRAYS: &[&str] = &[
    "part",
    "part_id",
    "partid",
    "materialid",
    "material_id",
    "material",
    "gmsh:physical",
    "cellentityids",
    "cell_tags",
    "elementblockids",
    "objectid",
    "block_id",
    "nastran:ref",
    "medit:ref",
];
const NODE_IDS: &[&str] = &["node_id", "globalnodeid", "globalnodeids", "globalpointids"];
const ELEMENT_IDS: &[&str] =
    &["element_id", "globalelementid", "globalelementids", "globalcellids"];

/// Content of a grid.
#[derive(Default)]
pub struct VtkGrid {
    points: Vec<[f64; 3]>,
    /// Type and points of each cell.
    cells: Vec<(u64, Vec<u64>)>,
    /// Arrays with one number for each point, by name.
    of_points: BTreeMap<String, Vec<f64>>,
    /// The same for cells.
    of_cells: BTreeMap<String, Vec<f64>>,
    /// Names of all other arrays.
    others: Vec<String>,
}

/// Id, type and corners of a cell.
type VtkCell = (u64, Cell, Vec<u64>);
/// Cells by part and dimension.
type VtkGroups = BTreeMap<(i64, usize), Vec<VtkCell>>;

/// Returns a cell and its corners, in the order of this program, for a cell type of VTK.
fn cell_of(kind: u64, corners: &[u64]) -> Option<(Cell, Vec<u64>)> {
    let same = corners.to_vec();
    let cell = match (kind, corners) {
        (1 | 2, _) => Cell::Point,
        (3, [_, _]) => Cell::Line,
        (5, [_, _, _]) | (7, [_, _, _]) => Cell::Triangle,
        (9, [_, _, _, _]) | (7, [_, _, _, _]) => Cell::Quad,
        (8, &[a, b, c, d]) => return Some((Cell::Quad, vec![a, b, d, c])),
        (10, [_, _, _, _]) => Cell::Tetrahedron,
        (11, &[a, b, c, d, e, f, g, h]) => {
            return Some((Cell::Hexahedron, vec![a, b, d, c, e, f, h, g]));
        }
        (12, _) if corners.len() == 8 => Cell::Hexahedron,
        (13, _) if corners.len() == 6 => Cell::Wedge,
        (14, _) if corners.len() == 5 => Cell::Pyramid,
        (4, _) => Cell::Other("polyline", 1),
        (6, _) => Cell::Other("triangle strip", 2),
        (7, _) => Cell::Other("polygon with 5 or more corners", 2),
        (21, _) => Cell::SecondOrder("line with 3 nodes", 1),
        (22 | 34, _) => Cell::SecondOrder("triangle with 6 nodes", 2),
        (23 | 28, _) => Cell::SecondOrder("quad with 8 or 9 nodes", 2),
        (24, _) => Cell::SecondOrder("tetrahedron with 10 nodes", 3),
        (25 | 29 | 33, _) => Cell::SecondOrder("hexahedron with 20 to 27 nodes", 3),
        (26 | 31 | 32, _) => Cell::SecondOrder("wedge with 15 or 18 nodes", 3),
        (27, _) => Cell::SecondOrder("pyramid with 13 nodes", 3),
        (42, _) => Cell::Other("polyhedron", 3),
        (68, _) => Cell::SecondOrder("curve of higher order", 1),
        (69 | 70, _) => Cell::SecondOrder("surface of higher order", 2),
        (71..=74, _) => Cell::SecondOrder("volume of higher order", 3),
        _ => return None,
    };
    Some((cell, same))
}

/// Adds a grid to the mesh.
fn add(grid: &VtkGrid, reading: &mut MeshReading) {
    let place = FilePlace::default();
    let ids = |arrays: &BTreeMap<String, Vec<f64>>, names: &[&str], count: usize| {
        named(arrays, names)
            .map(|(_, ids)| ids)
            .filter(|ids| are_ids(ids, count))
            .map_or_else(|| (1..=count as u64).collect(), |ids| as_ids(ids))
    };
    let nodes: Vec<u64> = ids(&grid.of_points, NODE_IDS, grid.points.len());
    let elements: Vec<u64> = ids(&grid.of_cells, ELEMENT_IDS, grid.cells.len());
    let points = nodes.iter().zip(&grid.points);
    reading.mesh.nodes.extend(points.map(|(&id, &x)| FileNode { id, x, place }));
    let parts = named(&grid.of_cells, PART_ARRAYS).filter(|(_, a)| a.len() == grid.cells.len());
    let mut groups = VtkGroups::new();
    for (index, (kind, corners)) in grid.cells.iter().enumerate() {
        let Some(corners) = points_of(index, corners, &nodes, reading) else { continue };
        let Some((cell, corners)) = cell_of(*kind, &corners) else {
            let message = format!("cell {index} has type {kind} and {} points", corners.len());
            let help = "types and numbers of points of VTK cells are expected; export it again";
            reading.error("cell type", place, message, help);
            continue;
        };
        let part = parts.map_or(1, |(_, array)| array[index] as i64);
        groups.entry((part, cell.dimension())).or_default().push((elements[index], cell, corners));
    }
    add_groups(groups, reading);
    if let Some((name, _)) = parts {
        reading.row(Fate::Read, format!("array {name}"), 1, "the parts of the cells");
    }
    for name in &grid.others {
        reading.row(Fate::Ignored, format!("array {name}"), 1, "a field");
    }
}

fn add_groups(groups: VtkGroups, reading: &mut MeshReading) {
    let cells: Vec<CellGroup> = groups
        .iter()
        .map(|((_, dimension), group)| CellGroup {
            dimension: *dimension,
            cells: group.iter().map(|(_, _, corners)| &corners[..]).collect(),
        })
        .collect();
    let bounds = bounding(&cells);
    for (((part, dimension), group), bounds) in groups.iter().zip(bounds) {
        if bounds || *dimension == 0 {
            let name = format!("part_{part}_{}", ["points", "lines", "faces", "cells"][*dimension]);
            let became = format!("node set `{name}`: they bound others");
            reading.row(Fate::Read, name.clone(), group.len(), became);
            let nodes = group.iter().flat_map(|(_, _, corners)| corners.iter().copied());
            reading.mesh.add_set(&name, &name, nodes);
            continue;
        }
        let free = |id: &u32| !reading.mesh.parts.iter().any(|p| p.id == *id);
        let id = u32::try_from(*part).ok().filter(|&id| id > 0).filter(free);
        let id = id.unwrap_or_else(|| reading.mesh.free_part_id());
        let index = reading.mesh.part_with_id(id, "");
        for (element, cell, corners) in group {
            reading.add_element((*element, index), *cell, corners, FilePlace::default());
        }
    }
}

/// Returns the ids of the points of a cell. Reports a cell with a point that is missing.
fn points_of(
    index: usize,
    corners: &[u64],
    nodes: &[u64],
    reading: &mut MeshReading,
) -> Option<Vec<u64>> {
    let found = corners.iter().map(|&c| nodes.get(usize::try_from(c).ok()?).copied());
    let found: Option<Vec<u64>> = found.collect();
    if found.is_none() {
        let message = format!(
            "cell {index} has the points {corners:?}, and the file has points 0 to {}",
            nodes.len().saturating_sub(1)
        );
        let help = "the connectivity is damaged: export the file again";
        reading.error("no point", FilePlace::default(), message, help);
    }
    found
}

/// Returns the first of these arrays that is there; names may be in any case.
fn named<'a>(
    arrays: &'a BTreeMap<String, Vec<f64>>,
    names: &[&str],
) -> Option<(&'a String, &'a Vec<f64>)> {
    names.iter().find_map(|name| arrays.iter().find(|(known, _)| known.to_lowercase() == *name))
}

/// Returns true for whole numbers from 0, all different.
fn are_ids(numbers: &[f64], count: usize) -> bool {
    let mut seen = HashSet::with_capacity(numbers.len());
    let is_id = |&x: &f64| x.fract() == 0.0 && (0.0..9e15).contains(&x);
    numbers.len() == count && numbers.iter().all(|x| is_id(x) && seen.insert(x.to_bits()))
}

fn as_ids(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|&x| x as u64).collect()
}
