//! VTK files: XML (`.vtu`, `.vtp`, their lists `.pvtu`, `.pvtp`) and legacy (`.vtk`), as text,
//! base64, raw or compressed data (VTK User's Guide, "VTK file formats").
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
use std::collections::{BTreeMap, HashMap, HashSet};

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

/// Flags of cells; the lowest bit is set if the cell is a ghost, which another piece has.
const GHOSTS: &[&str] = &["vtkghosttype"];
/// Levels of cells in older files: 0 for a cell of the piece, above 0 for a ghost.
const GHOST_LEVELS: &[&str] = &["vtkghostlevels"];

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
    /// Number of pieces of all files.
    pieces: usize,
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
        (24, _) if corners.len() == 10 => Cell::Tetrahedron10,
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

/// Returns true for a wedge whose first triangle has its normal outwards. VTK describes wedges so,
/// and most programs write them the other way round.
fn is_inside_out(kind: u64, corners: &[u64], points: &[[f64; 3]]) -> bool {
    let place = |k: usize| points.get(*corners.get(k)? as usize);
    let is_wedge = kind == 13 && corners.len() == 6;
    let (true, Some(a), Some(b), Some(c), Some(d)) =
        (is_wedge, place(0), place(1), place(2), place(3))
    else {
        return false;
    };
    let from_a = |x: &[f64; 3]| std::array::from_fn::<f64, 3, _>(|i| x[i] - a[i]);
    let (b, c, d) = (from_a(b), from_a(c), from_a(d));
    let normal = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2] < 0.0
}

/// Adds a grid to the mesh.
fn add(mut grid: VtkGrid, reading: &mut MeshReading) {
    let place = FilePlace::default();
    let nodes = point_ids(&grid, reading);
    let doubled = drop_doubled(&mut grid, &nodes);
    if doubled > 0 {
        let became = "other pieces have them, too; each is read once";
        reading.row(Fate::Ignored, "cells of several pieces", doubled, became);
    }
    let grid = &grid;
    let elements = cell_ids(grid, reading);
    let mut known = HashSet::with_capacity(nodes.len());
    let points = nodes.iter().zip(&grid.points).filter(|(id, _)| known.insert(**id));
    reading.mesh.nodes.extend(points.map(|(&id, &x)| FileNode { id, x, place }));
    // The order of pieces and points depends on the program; that of ids does not.
    reading.mesh.nodes.sort_by_key(|node| node.id);
    let parts = part_numbers(grid, reading);
    let mut groups = VtkGroups::new();
    for (index, (kind, corners_in_file)) in grid.cells.iter().enumerate() {
        let Some(corners) = points_of(index, corners_in_file, &nodes, reading) else { continue };
        let corners = if is_inside_out(*kind, corners_in_file, &grid.points) {
            [2, 1, 0, 5, 4, 3].map(|k| corners[k]).to_vec()
        } else {
            corners
        };
        let Some((cell, corners)) = cell_of(*kind, &corners) else {
            let message = format!("cell {index} has type {kind} and {} points", corners.len());
            let help = "types and numbers of points of VTK cells are expected; export it again";
            reading.error("cell type", place, message, help);
            continue;
        };
        let part = parts.as_ref().map_or(1, |(_, numbers)| numbers[index]);
        groups.entry((part, cell.dimension())).or_default().push((elements[index], cell, corners));
    }
    for group in groups.values_mut() {
        group.sort_by_key(|(id, ..)| *id);
    }
    add_groups(groups, reading);
    if let Some((name, _)) = &parts {
        reading.row(Fate::Read, format!("array {name}"), 1, "the parts of the cells");
    }
    let is_known = |name: &str| {
        let name = name.to_lowercase();
        [PART_ARRAYS, NODE_IDS, ELEMENT_IDS, GHOSTS]
            .iter()
            .any(|names| names.contains(&name.as_str()))
    };
    let numbers = grid.of_points.keys().chain(grid.of_cells.keys());
    for name in numbers.filter(|name| !is_known(name)).chain(&grid.others) {
        reading.row(Fate::Ignored, format!("array {name}"), 1, "a field");
    }
}

/// Returns the id of each point. Points of several pieces with one id and one position are one
/// node.
fn point_ids(grid: &VtkGrid, reading: &mut MeshReading) -> Vec<u64> {
    let count = grid.points.len();
    let given = named(&grid.of_points, NODE_IDS);
    let ids = given.and_then(|(_, array)| indices_of(array));
    let is_one_point = |ids: &Vec<u64>| {
        let mut at: HashMap<u64, [f64; 3]> = HashMap::with_capacity(count);
        let agrees = |(&id, &x): (&u64, &[f64; 3])| {
            at.insert(id, x).is_none_or(|before| grid.pieces > 1 && before == x)
        };
        ids.len() == count && ids.iter().zip(&grid.points).all(agrees)
    };
    if let Some(ids) = ids.filter(is_one_point) {
        return ids;
    }
    if let Some((name, _)) = given {
        not_unique(name, reading);
    }
    if grid.pieces > 1 {
        let message = format!(
            "the file has {} pieces, and no ids of points: points where pieces meet are not joined",
            grid.pieces
        );
        let help = "save the points with GlobalNodeId, or join them before (in ParaView: Clean to \
                    Grid, and save one piece)";
        reading.warning(FilePlace::default(), message, help);
    }
    (1..=count as u64).collect()
}

/// Removes cells of several pieces that another piece has: ghosts, and later cells with id and
/// points of an earlier one. Returns their number. `nodes` are the ids of the points.
fn drop_doubled(grid: &mut VtkGrid, nodes: &[u64]) -> usize {
    if grid.pieces < 2 {
        return 0;
    }
    let count = grid.cells.len();
    let column = |names| named(&grid.of_cells, names).map(|(_, array)| array);
    let (ghosts, levels, ids) = (column(GHOSTS), column(GHOST_LEVELS), column(ELEMENT_IDS));
    let mut seen = HashSet::new();
    let mut is_kept = |cell: usize| {
        let is_ghost = ghosts
            .is_some_and(|flags| index_of(flags[cell]).is_some_and(|f| f % 2 == 1))
            || levels.is_some_and(|levels| levels[cell] > 0.0);
        let again = ids.is_some_and(|ids| {
            let points = &grid.cells[cell].1;
            let points: Vec<Option<&u64>> =
                points.iter().map(|&p| nodes.get(usize::try_from(p).ok()?)).collect();
            !seen.insert((ids[cell].to_bits(), points))
        });
        !is_ghost && !again
    };
    let kept: Vec<bool> = (0..count).map(&mut is_kept).collect();
    let keep = |array: &mut Vec<f64>| {
        let mut kept = kept.iter();
        array.retain(|_| kept.next() == Some(&true));
    };
    grid.of_cells.values_mut().for_each(keep);
    let mut of_cells = kept.iter();
    grid.cells.retain(|_| of_cells.next() == Some(&true));
    count - grid.cells.len()
}

/// Returns the id of each cell.
fn cell_ids(grid: &VtkGrid, reading: &mut MeshReading) -> Vec<u64> {
    let count = grid.cells.len();
    let given = named(&grid.of_cells, ELEMENT_IDS);
    let ids = given.and_then(|(_, array)| indices_of(array));
    let mut seen = HashSet::with_capacity(count);
    let is_unique = |ids: &Vec<u64>| ids.len() == count && ids.iter().all(|id| seen.insert(*id));
    ids.filter(is_unique).unwrap_or_else(|| {
        if let Some((name, _)) = given {
            not_unique(name, reading);
        }
        (1..=count as u64).collect()
    })
}

fn not_unique(name: &str, reading: &mut MeshReading) {
    let became = "not used: ids are different whole numbers from 0; they are counted from 1";
    reading.row(Fate::Ignored, format!("array {name}"), 1, became);
}

/// Returns the array that gives the parts of the cells, and its numbers.
fn part_numbers<'a>(
    grid: &'a VtkGrid,
    reading: &mut MeshReading,
) -> Option<(&'a String, Vec<i64>)> {
    let (name, array) =
        named(&grid.of_cells, PART_ARRAYS).filter(|(_, a)| a.len() == grid.cells.len())?;
    let whole = |&number: &f64| {
        (number.fract() == 0.0 && number.abs() < LARGEST_INDEX).then_some(number as i64)
    };
    let numbers: Option<Vec<i64>> = array.iter().map(whole).collect();
    if numbers.is_none() {
        let became = "not used: the numbers of parts are whole numbers";
        reading.row(Fate::Ignored, format!("array {name}"), 1, became);
    }
    Some((name, numbers?))
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
    // Numbers that can be ids of parts keep them; the others get free ids after them.
    let is_part = |((_, dimension), bounds): (&(i64, usize), &bool)| !bounds && *dimension > 0;
    let parts = groups.keys().zip(&bounds).filter(|row| is_part(*row));
    for ((part, _), _) in parts {
        if let Some(id) = u32::try_from(*part).ok().filter(|&id| id > 0) {
            reading.mesh.part_with_id(id, "");
        }
    }
    let mut used: HashSet<u32> = HashSet::new();
    for (((part, dimension), group), bounds) in groups.iter().zip(bounds) {
        if bounds || *dimension == 0 {
            let name = format!("part_{part}_{}", ["points", "lines", "faces", "cells"][*dimension]);
            let became = format!("node set `{name}`: they bound others");
            reading.row(Fate::Read, name.clone(), group.len(), became);
            let nodes = group.iter().flat_map(|(_, _, corners)| corners.iter().copied());
            reading.mesh.add_set(&name, &name, nodes);
            continue;
        }
        let id = u32::try_from(*part).ok().filter(|&id| id > 0 && used.insert(id));
        let id = id.unwrap_or_else(|| {
            let id = reading.mesh.free_part_id();
            let kind = ["points", "lines", "faces", "cells"][*dimension];
            let what = format!("{kind} of part number {part}");
            reading.row(Fate::Read, what, group.len(), format!("part {id}"));
            id
        });
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

/// Whole numbers below this one are exact in `f64`.
const LARGEST_INDEX: f64 = 9e15;

/// Returns a number that is an index or id: a whole number from 0.
fn index_of(number: f64) -> Option<u64> {
    (number.fract() == 0.0 && (0.0..LARGEST_INDEX).contains(&number)).then_some(number as u64)
}

fn indices_of(numbers: &[f64]) -> Option<Vec<u64>> {
    numbers.iter().copied().map(index_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_whole_numbers_from_0() {
        let found = [0.0, 7.0, -1.0, 1.5, f64::NAN, f64::INFINITY, 1e19].map(index_of);
        assert_eq!(found, [Some(0), Some(7), None, None, None, None, None]);
    }

    /// Voxels and pixels of VTK count along the axes; the corners here go around.
    #[test]
    fn voxels_and_pixels_become_hexahedra_and_quads() {
        let voxel = cell_of(11, &[0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(voxel, Some((Cell::Hexahedron, vec![0, 1, 3, 2, 4, 5, 7, 6])));
        assert_eq!(cell_of(8, &[0, 1, 2, 3]), Some((Cell::Quad, vec![0, 1, 3, 2])));
        assert_eq!(cell_of(11, &[0, 1, 2, 3]), None);
    }
}
