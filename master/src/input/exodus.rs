//! Reads meshes in the format GENESIS: EXODUS II without results (Schoof & Yarberry 1994,
//! SAND92-2137), in netCDF files of the classic formats or netCDF-4.
//!
//! An element block is a part, and its id is the id of the part. A node set keeps its name. A side
//! set becomes the set of the nodes of its sides. Attributes of shells named `thickness`, or the
//! only attribute of a block of shells, are thicknesses of single shells.

use crate::input::confine;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, Shape};
use crumple_proto::problem::Problem;
use netcdf_reader::{NcAttrValue, NcFile};
use std::collections::BTreeMap;
use std::path::Path;

/// Key of the job that names the file.
const KEY: &str = "mesh.exodus";
/// Maximum number of problems of one kind that are reported singly.
const MOST: usize = 5;

/// An element type: its names without the number of nodes, its shape, and the corners of its sides
/// in the order of EXODUS II (figure 4.2 and table 4.2 of the reference).
struct ElementType {
    names: &'static [&'static str],
    shape: Shape,
    sides: &'static [&'static [usize]],
}

const KINDS: [ElementType; 9] = [
    ElementType {
        names: &["HEX"],
        shape: Shape::Hex8,
        sides: &[
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[0, 4, 7, 3],
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
        ],
    },
    ElementType {
        names: &["TETRA", "TET"],
        shape: Shape::Tet4,
        sides: &[&[0, 1, 3], &[1, 2, 3], &[0, 3, 2], &[0, 2, 1]],
    },
    ElementType {
        names: &["TETRA", "TET"],
        shape: Shape::Tet10,
        sides: &[
            &[0, 1, 3, 4, 8, 7],
            &[1, 2, 3, 5, 9, 8],
            &[0, 3, 2, 7, 9, 6],
            &[0, 2, 1, 6, 5, 4],
        ],
    },
    ElementType {
        names: &["WEDGE"],
        shape: Shape::Wedge6,
        sides: &[&[0, 1, 4, 3], &[1, 2, 5, 4], &[0, 3, 5, 2], &[0, 2, 1], &[3, 4, 5]],
    },
    ElementType {
        names: &["SHELL"],
        shape: Shape::Quad4,
        sides: &[&[0, 1, 2, 3], &[0, 3, 2, 1], &[0, 1], &[1, 2], &[2, 3], &[3, 0]],
    },
    ElementType {
        names: &["QUAD"],
        shape: Shape::Quad4,
        sides: &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
    },
    ElementType {
        names: &["TRISHELL", "SHELL"],
        shape: Shape::Tri3,
        sides: &[&[0, 1, 2], &[0, 2, 1], &[0, 1], &[1, 2], &[2, 0]],
    },
    ElementType {
        names: &["TRI", "TRIANGLE"],
        shape: Shape::Tri3,
        sides: &[&[0, 1], &[1, 2], &[2, 0]],
    },
    ElementType {
        names: &["BEAM", "BAR", "ROD", "TRUSS"],
        shape: Shape::Beam2,
        sides: &[&[0, 1], &[0, 1]],
    },
];

/// Reads a file. Beams get a node that gives them a second axis: towards the global z axis, or the
/// x axis for beams within 30 degrees of z.
///
/// # Errors
/// The file cannot be read, is no EXODUS II model, or has elements that are not supported: all
/// problems.
pub fn read(path: &Path) -> Result<Mesh, Vec<Problem>> {
    read_with_names(path).map(|(mesh, _)| mesh)
}

/// Reads a file as [`read`] does. Also returns the names of blocks that have one, by part.
///
/// # Errors
/// As for [`read`].
pub fn read_with_names(path: &Path) -> Result<(Mesh, BTreeMap<u32, String>), Vec<Problem>> {
    confine::check(path).map_err(|error| vec![refused(path, &error)])?;
    let file = NcFile::open(path).map_err(|error| vec![unreadable(path, &error)])?;
    let mut reader = ExodusReader { file, path, part_names: BTreeMap::new(), problems: Vec::new() };
    let mesh = reader.mesh();
    match mesh {
        Some(mesh) if reader.problems.is_empty() => Ok((mesh, reader.part_names)),
        _ => Err(reader.problems),
    }
}

fn refused(path: &Path, error: &std::io::Error) -> Problem {
    Problem::error(KEY, format!("{} cannot be read: {error}", path.display()), "correct the path")
}

fn unreadable(path: &Path, error: &netcdf_reader::Error) -> Problem {
    let shown = path.display();
    if !path.is_file() {
        return Problem::error(KEY, format!("there is no file {shown}"), "correct the path");
    }
    let help = "give a GENESIS or EXODUS II file: netCDF-3 (classic, 64-bit offset, CDF-5) or \
                netCDF-4";
    Problem::error(KEY, format!("{shown} cannot be read as netCDF: {error}"), help)
}

/// An element block.
struct ExodusBlock {
    /// Id, which is the id of the part.
    id: u32,
    kind: &'static ElementType,
    /// Elements: indices of their nodes.
    corners: Vec<Vec<usize>>,
    /// Thickness of each shell; empty without [length].
    thickness: Vec<f64>,
}

struct ExodusReader<'a> {
    file: NcFile,
    path: &'a Path,
    part_names: BTreeMap<u32, String>,
    problems: Vec<Problem>,
}

impl ExodusReader<'_> {
    fn error(&mut self, message: impl std::fmt::Display, help: &str) {
        let message = format!("{}: {message}", self.path.display());
        self.problems.push(Problem::error(KEY, message, help));
    }

    /// Returns the size of a dimension, 0 if it is missing.
    fn size(&self, name: &str) -> usize {
        self.file.dimension(name).map_or(0, |d| d.size as usize)
    }

    /// Returns the numbers of a variable, or `None` if it is missing or cannot be read.
    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let array = self.file.read_variable_as_f64(name).ok()?;
        Some(array.into_iter().collect())
    }

    /// Returns ids of `count` blocks or sets; without the variable they are counted from 1.
    fn ids(&self, name: &str, count: usize) -> Vec<u64> {
        let known = self.numbers(name).filter(|ids| ids.len() == count);
        known.map_or_else(
            || (1..=count as u64).collect(),
            |ids| ids.into_iter().map(|id| id as u64).collect(),
        )
    }

    /// Returns names of blocks or sets; those that are missing or empty are `prefix_ID`.
    fn names(&self, name: &str, prefix: &str, ids: &[u64]) -> Vec<String> {
        let known = self.file.read_variable_as_strings(name).unwrap_or_default();
        let of = |(i, id): (usize, &u64)| {
            let name = known.get(i).map(|name| name.trim_end_matches('\0').trim());
            let name = name.filter(|name| !name.is_empty()).map(String::from);
            name.unwrap_or_else(|| format!("{prefix}_{id}"))
        };
        ids.iter().enumerate().map(of).collect()
    }

    fn mesh(&mut self) -> Option<Mesh> {
        let x = self.coordinates()?;
        let nodes = self.map("node_num_map", x.len());
        let mut mesh = Mesh::default();
        mesh.nodes.extend(nodes.iter().zip(&x).map(|(&id, &x)| MeshNode { id: NodeId(id), x }));
        let blocks = self.blocks(x.len());
        let count = blocks.iter().map(|b| b.corners.len()).sum();
        let elements = self.map("elem_num_map", count);
        let mut free = nodes.iter().copied().max().unwrap_or(0) + 1;
        let mut ids = elements.iter();
        for block in &blocks {
            for (i, corners) in block.corners.iter().enumerate() {
                let mut of: Vec<NodeId> = corners.iter().map(|&n| NodeId(nodes[n])).collect();
                if block.kind.shape == Shape::Beam2 {
                    let third = NodeId(free);
                    free += 1;
                    let x = off_axis([x[corners[0]], x[corners[1]]]);
                    mesh.nodes.push(MeshNode { id: third, x });
                    of.push(third);
                }
                let id = ElemId(*ids.next()?);
                let mut element = MeshElement::new(id, block.id, block.kind.shape, &of);
                element.own.thickness = block.thickness.get(i).copied().unwrap_or(0.0);
                mesh.elements.push(element);
            }
        }
        self.node_sets(&nodes, &mut mesh.node_sets);
        self.side_sets(&blocks, &nodes, &mut mesh.node_sets);
        Some(mesh)
    }

    /// Returns the coordinates of all nodes [length].
    fn coordinates(&mut self) -> Option<Vec<[f64; 3]>> {
        let (count, dimensions) = (self.size("num_nodes"), self.size("num_dim"));
        let help = "give a GENESIS or EXODUS II file with a model in three dimensions";
        if self.file.dimension("num_nodes").is_err() || self.file.dimension("num_dim").is_err() {
            self.error("the file has no EXODUS II model (dimension num_nodes or num_dim)", help);
            return None;
        }
        if dimensions != 3 {
            self.error(format!("the model has {dimensions} dimensions"), help);
            return None;
        }
        // One variable in files of version 2, three in later ones.
        let columns = match self.numbers("coord") {
            Some(all) if all.len() == 3 * count => {
                Some(all.chunks_exact(count.max(1)).map(<[f64]>::to_vec).collect::<Vec<_>>())
            }
            _ => {
                ["coordx", "coordy", "coordz"].map(|name| self.numbers(name)).into_iter().collect()
            }
        };
        let columns = columns.filter(|columns| columns.iter().all(|c| c.len() == count));
        let Some(columns) = columns.filter(|columns| columns.len() == 3) else {
            self.error("the coordinates of the nodes are missing or incomplete", "export it again");
            return None;
        };
        Some((0..count).map(|i| std::array::from_fn(|c| columns[c][i])).collect())
    }

    /// Returns the ids of nodes or elements; without a map they are counted from 1.
    fn map(&mut self, name: &str, count: usize) -> Vec<u64> {
        match self.numbers(name) {
            Some(ids) if ids.len() == count && ids.iter().all(|&id| id >= 1.0) => {
                ids.into_iter().map(|id| id as u64).collect()
            }
            None => (1..=count as u64).collect(),
            Some(ids) => {
                let what = format!("{name} has {} ids, of at least 1, for {count}", ids.len());
                self.error(what, "correct the map, or remove it: ids are then counted from 1");
                (1..=count as u64).collect()
            }
        }
    }

    /// Returns all element blocks that have elements. Blocks with problems are reported.
    fn blocks(&mut self, nodes: usize) -> Vec<ExodusBlock> {
        let ids = self.ids("eb_prop1", self.size("num_el_blk"));
        let names = self.names("eb_names", "block", &ids);
        let mut blocks = Vec::new();
        for (i, (&id, name)) in ids.iter().zip(&names).enumerate() {
            if self.size(&format!("num_el_in_blk{}", i + 1)) > 0 {
                let block = self.block(i + 1, id, &format!("block {id} ({name})"), nodes);
                // Names that stand for a missing one.
                let made = [format!("block_{id}"), format!("part_{id}")];
                if let Some(block) = block.as_ref().filter(|_| !made.contains(name)) {
                    self.part_names.insert(block.id, name.clone());
                }
                blocks.extend(block);
            }
        }
        blocks
    }

    fn block(&mut self, number: usize, id: u64, shown: &str, nodes: usize) -> Option<ExodusBlock> {
        let variable = format!("connect{number}");
        let attribute = self.file.variable(&variable).ok().and_then(|v| v.attribute("elem_type"));
        let named = match attribute.map(|a| &a.value) {
            Some(NcAttrValue::Chars(text)) => text.trim_end_matches('\0').trim().to_uppercase(),
            other => other.and_then(NcAttrValue::as_string).unwrap_or_default().to_uppercase(),
        };
        let width = self.size(&format!("num_nod_per_el{number}"));
        let base = named.trim_end_matches(|c: char| c.is_ascii_digit());
        let kind = KINDS.iter().find(|k| k.names.contains(&base) && k.shape.corners() == width);
        let (Some(kind), Ok(id)) = (kind, u32::try_from(id)) else {
            self.error(
                format!("{shown} has elements of type {named} with {width} nodes"),
                "these types are read: HEX with 8 nodes, TETRA with 4 or 10, WEDGE with 6, SHELL \
                 and QUAD with 4, TRI, TRISHELL and SHELL with 3, BEAM, BAR, ROD and TRUSS with 2. \
                 Mesh the block with one of them, or delete it",
            );
            return None;
        };
        let count = self.size(&format!("num_el_in_blk{number}"));
        let Some(corners) = self.numbers(&variable).filter(|c| c.len() == count * width) else {
            self.error(format!("{shown}: {variable} is missing or incomplete"), "export it again");
            return None;
        };
        let is_bad = |&n: &f64| !(1.0..=nodes as f64).contains(&n);
        let bad: Vec<usize> =
            (0..count).filter(|e| corners[e * width..(e + 1) * width].iter().any(is_bad)).collect();
        for e in bad.iter().take(MOST) {
            let row = &corners[e * width..(e + 1) * width];
            self.error(
                format!(
                    "{shown}: its element {} has the nodes {row:?}, and not all of them exist",
                    e + 1
                ),
                &format!("the file has nodes 1 to {nodes}"),
            );
        }
        if bad.len() > MOST {
            let more = bad.len() - MOST;
            self.error(
                format!("{shown}: {more} more elements have nodes that do not exist"),
                "correct them",
            );
        }
        let rows = corners.chunks_exact(width).map(|row| row.iter().map(|&n| n as usize - 1));
        let corners = if bad.is_empty() { rows.map(Iterator::collect).collect() } else { vec![] };
        let thickness = if kind.shape.is_shell() { self.thickness(number, count) } else { vec![] };
        bad.is_empty().then_some(ExodusBlock { id, kind, corners, thickness })
    }

    /// Returns the thickness of each shell of a block, or nothing.
    fn thickness(&self, number: usize, count: usize) -> Vec<f64> {
        let width = self.size(&format!("num_att_in_blk{number}"));
        let names = self.file.read_variable_as_strings(&format!("attrib_name{number}"));
        let names = names.unwrap_or_default();
        let is_thickness =
            |name: &String| name.trim_end_matches('\0').trim().eq_ignore_ascii_case("thickness");
        let Some(column) = names.iter().position(is_thickness).or((width == 1).then_some(0)) else {
            return Vec::new();
        };
        let all = self.numbers(&format!("attrib{number}")).filter(|a| a.len() == count * width);
        all.unwrap_or_default().chunks_exact(width.max(1)).map(|row| row[column]).collect()
    }

    fn node_sets(&mut self, nodes: &[u64], sets: &mut BTreeMap<String, Vec<NodeId>>) {
        let ids = self.ids("ns_prop1", self.size("num_node_sets"));
        let names = self.names("ns_names", "nodeset", &ids);
        for (i, (id, name)) in ids.iter().zip(names).enumerate() {
            let members = self.numbers(&format!("node_ns{}", i + 1)).unwrap_or_default();
            let found: Option<Vec<NodeId>> = members
                .iter()
                .map(|&n| nodes.get((n as usize).checked_sub(1)?).copied().map(NodeId))
                .collect();
            let Some(found) = found else {
                let what = format!("node set {id} ({name}) has a node that is not in the file");
                self.error(what, "correct the set");
                continue;
            };
            self.add_set(sets, name, &format!("nodeset_{id}"), found);
        }
    }

    /// Adds the nodes of the sides of each side set.
    fn side_sets(
        &mut self,
        blocks: &[ExodusBlock],
        nodes: &[u64],
        sets: &mut BTreeMap<String, Vec<NodeId>>,
    ) {
        let ids = self.ids("ss_prop1", self.size("num_side_sets"));
        let names = self.names("ss_names", "sideset", &ids);
        let elements: Vec<(&ElementType, &[usize])> =
            blocks.iter().flat_map(|b| b.corners.iter().map(|c| (b.kind, &c[..]))).collect();
        for (i, (id, name)) in ids.iter().zip(names).enumerate() {
            let [members, sides] = ["elem_ss", "side_ss"]
                .map(|name| self.numbers(&format!("{name}{}", i + 1)).unwrap_or_default());
            let corners = |(element, side): (&f64, &f64)| {
                let (kind, corners) = elements.get((*element as usize).checked_sub(1)?)?;
                let side = kind.sides.get((*side as usize).checked_sub(1)?)?;
                Some(side.iter().map(|&c| NodeId(nodes[corners[c]])))
            };
            let found: Option<Vec<_>> = members.iter().zip(&sides).map(corners).collect();
            let Some(found) = found.filter(|_| members.len() == sides.len()) else {
                let what = format!("side set {id} ({name}) has a side that is not in the file");
                self.error(what, "correct the set, or the blocks that have problems");
                continue;
            };
            let mut found: Vec<NodeId> = found.into_iter().flatten().collect();
            found.sort_unstable();
            found.dedup();
            self.add_set(sets, name, &format!("sideset_{id}"), found);
        }
    }

    /// Adds a set, under its second name if the first is taken.
    fn add_set(
        &mut self,
        sets: &mut BTreeMap<String, Vec<NodeId>>,
        name: String,
        second: &str,
        nodes: Vec<NodeId>,
    ) {
        let name = if sets.contains_key(&name) { second.to_string() } else { name };
        if sets.insert(name.clone(), nodes).is_some() {
            self.error(format!("two sets have the name {name}"), "give each set its own name");
        }
    }
}

/// Returns a point off the line between the ends of a beam, see [`read`].
pub(super) fn off_axis([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    let along: [f64; 3] = std::array::from_fn(|c| b[c] - a[c]);
    let length = along.iter().map(|l| l * l).sum::<f64>().sqrt();
    let axis = if along[2].abs() > 0.866 * length { 0 } else { 2 };
    let mut point = a;
    point[axis] += if length > 0.0 { length } else { 1.0 };
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use netcdf_writer::{NcFileBuilder, NcWriteFormat, NcWriteOptions};

    /// Changes of the file that tests make.
    #[derive(Clone, Copy, Default)]
    struct Faults {
        wedge: bool,
        corner: bool,
        plane: bool,
        set: bool,
    }

    fn add_names(file: &mut NcFileBuilder, variable: &str, names: &[&str]) {
        let rows = file.add_dimension(format!("dim_{variable}"), names.len() as u64).unwrap();
        let width = file.add_dimension(format!("len_{variable}"), 33).unwrap();
        let variable = file.add_char_variable(variable, &[rows, width]).unwrap();
        file.write_char_variable_strings(variable, names).unwrap();
    }

    /// Writes two cubes one above the other, a shell on top and a beam, in one of the formats.
    fn model(format: NcWriteFormat, faults: Faults) -> Vec<u8> {
        let mut file = NcFileBuilder::new();
        let dimensions = if faults.plane { 2 } else { 3 };
        for (name, size) in [
            ("num_dim", dimensions),
            ("num_nodes", 12),
            ("num_elem", 4),
            ("num_el_blk", 3),
            ("num_node_sets", 2),
            ("num_side_sets", 1),
        ] {
            file.add_dimension(name, size).unwrap();
        }
        let nodes = file.add_dimension("n", 12).unwrap();
        for (name, axis) in [("coordx", 0), ("coordy", 1), ("coordz", 2)] {
            let at = |n: usize| match axis {
                0 => f64::from(u8::from(matches!(n % 4, 1 | 2))),
                1 => f64::from(u8::from(n % 4 > 1)),
                _ => (n / 4) as f64,
            };
            let values: Vec<f64> = (0..12).map(at).collect();
            let variable = file.add_variable::<f64>(name, &[nodes]).unwrap();
            file.write_variable(variable, &values).unwrap();
        }
        let last = if faults.corner { 99 } else { 12 };
        let cubes: Vec<i32> = (1..=8).chain(5..=11).chain([last]).collect();
        let hex = if faults.wedge { "WEDGE6" } else { "HEX8" };
        let blocks: [(&str, usize, &[i32]); 3] =
            [(hex, 8, &cubes), ("SHELL4", 4, &[9, 10, 11, 12]), ("BEAM", 2, &[1, 5])];
        for (number, (kind, width, corners)) in (1..).zip(blocks) {
            let count = (corners.len() / width) as u64;
            let rows = file.add_dimension(format!("num_el_in_blk{number}"), count).unwrap();
            let columns = file.add_dimension(format!("num_nod_per_el{number}"), width as u64);
            let name = format!("connect{number}");
            let variable = file.add_variable::<i32>(&name, &[rows, columns.unwrap()]).unwrap();
            let kind = NcAttrValue::Chars(kind.into());
            file.add_variable_attribute(variable, "elem_type", kind).unwrap();
            file.write_variable(variable, corners).unwrap();
        }
        let mut integers = |name: &str, values: &[i32]| {
            let size = file.add_dimension(format!("dim_{name}"), values.len() as u64).unwrap();
            let variable = file.add_variable::<i32>(name, &[size]).unwrap();
            file.write_variable(variable, values).unwrap();
        };
        integers("eb_prop1", &[10, 20, 30]);
        integers("elem_num_map", &[101, 102, 201, 301]);
        integers("ns_prop1", &[1, 2]);
        integers("node_ns1", &[1, 2, 3, 4]);
        integers("node_ns2", &[if faults.set { 13 } else { 12 }]);
        integers("ss_prop1", &[7]);
        // Lower side of the first cube, upper side of the second, first edge of the shell.
        integers("elem_ss1", &[1, 2, 3]);
        integers("side_ss1", &[5, 6, 3]);
        add_names(&mut file, "ns_names", &["base", ""]);
        let rows = file.add_dimension("num_att_in_blk2", 1).unwrap();
        let thickness = file.add_variable::<f64>("attrib2", &[rows]).unwrap();
        file.write_variable(thickness, &[0.25]).unwrap();
        file.to_vec(NcWriteOptions { format }).unwrap().1
    }

    fn read_bytes(bytes: &[u8]) -> Result<Mesh, Vec<Problem>> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        read(file.path())
    }

    #[test]
    fn blocks_and_sets_of_all_formats_are_read() {
        for format in [
            NcWriteFormat::Classic,
            NcWriteFormat::Offset64,
            NcWriteFormat::Cdf5,
            NcWriteFormat::Nc4,
        ] {
            let mesh = read_bytes(&model(format, Faults::default())).unwrap();
            let parts: Vec<(u64, u32, Shape)> =
                mesh.elements.iter().map(|e| (e.id.0, e.part, e.shape)).collect();
            let wanted = [
                (101, 10, Shape::Hex8),
                (102, 10, Shape::Hex8),
                (201, 20, Shape::Quad4),
                (301, 30, Shape::Beam2),
            ];
            assert_eq!(parts, wanted, "{format:?}");
            assert_eq!(mesh.elements[1].corners(), [5, 6, 7, 8, 9, 10, 11, 12].map(NodeId));
            assert_eq!(mesh.elements[2].own.thickness, 0.25);
            // The beam is parallel to z, so its second axis is x.
            assert_eq!(mesh.nodes.len(), 13);
            assert_eq!(mesh.elements[3].nodes[2].0, 13);
            assert_eq!(mesh.nodes[12].x, [1.0, 0.0, 0.0]);
            let set = |name: &str| mesh.node_sets[name].iter().map(|n| n.0).collect::<Vec<_>>();
            assert_eq!(set("base"), [1, 2, 3, 4]);
            assert_eq!(set("nodeset_2"), [12]);
            assert_eq!(set("sideset_7"), [1, 2, 3, 4, 9, 10, 11, 12]);
        }
    }

    #[test]
    fn all_problems_are_reported_with_their_blocks_and_sets() {
        let faulty = |faults| {
            let problems = read_bytes(&model(NcWriteFormat::Classic, faults)).unwrap_err();
            problems.iter().map(|p| format!("{} {}\n", p.message, p.help)).collect::<String>()
        };
        let said = faulty(Faults { wedge: true, set: true, ..Faults::default() });
        assert!(said.contains("block 10 (block_10) has elements of type WEDGE6"), "{said}");
        assert!(said.contains("HEX with 8 nodes"), "{said}");
        assert!(
            said.contains("node set 2 (nodeset_2) has a node that is not in the file"),
            "{said}"
        );
        let said = faulty(Faults { corner: true, ..Faults::default() });
        assert!(said.contains("block 10 (block_10): its element 2 has the nodes"), "{said}");
        let said = faulty(Faults { plane: true, ..Faults::default() });
        assert!(said.contains("the model has 2 dimensions"), "{said}");
    }

    #[test]
    fn other_files_and_cut_files_are_refused() {
        let good = model(NcWriteFormat::Classic, Faults::default());
        for (bytes, wanted) in [
            (&b"*KEYWORD\n*END\n"[..], "cannot be read as netCDF"),
            (&good[..good.len() / 2], ""),
            (&good[..100], "cannot be read as netCDF"),
        ] {
            let problems = read_bytes(bytes).unwrap_err();
            assert!(problems[0].message.contains(wanted), "{problems:?}");
        }
        let problems = read(Path::new("/nowhere/model.g")).unwrap_err();
        assert!(problems[0].message.contains("there is no file"), "{problems:?}");
    }

    /// Broken bytes at any place: a mesh or problems, never a panic.
    #[test]
    fn mutated_files_do_not_panic() {
        let mut random = fastrand::Rng::with_seed(7);
        for format in [NcWriteFormat::Classic, NcWriteFormat::Nc4] {
            let good = model(format, Faults::default());
            for _ in 0..300 {
                let mut bytes = good.clone();
                for _ in 0..random.usize(1..=8) {
                    let place = random.usize(..bytes.len());
                    bytes[place] = random.u8(..);
                }
                let _ = read_bytes(&bytes);
            }
        }
    }
}
