//! Layout and records of an EXODUS II file.

use crate::results::snapshot::{Snapshot, SnapshotArray};
use crumple_worker::vtu::{self, Array, CELL_ARRAYS, POINT_ARRAYS};
use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::rc::Rc;

/// Version of EXODUS II whose layout this is.
const VERSION: f32 = 8.03;
/// Length of names, with the final zero.
const NAME: usize = 33;
/// Suffixes of components. ParaView joins those of vectors.
const VECTOR: [&str; 3] = ["x", "y", "z"];
const TENSOR: [&str; 6] = ["_xx", "_yy", "_zz", "_xy", "_yz", "_zx"];
/// Variable of elements that is 1 as long as they have not failed.
const STATUS: &str = "status";

/// An element block.
struct WrittenBlock {
    id: i32,
    name: String,
    /// Name of the element type.
    kind: &'static str,
    corners: usize,
    /// Positions of its elements in the first step.
    elements: Vec<usize>,
}

/// The model of a run: what the first step has.
pub struct ExodusModel {
    nodes: Vec<i64>,
    elements: Vec<i64>,
    coordinates: [Vec<f32>; 3],
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    blocks: Vec<WrittenBlock>,
}

/// Returns the position of an array in a table.
fn position(arrays: &[Array], name: &str) -> usize {
    arrays.iter().position(|a| a.name == name).expect("the tables of the fields have it")
}

fn ids(column: &SnapshotArray) -> &[i64] {
    match column {
        SnapshotArray::I64(ids) => ids,
        _ => unreachable!("ids have 64 bits"),
    }
}

/// Returns the arrays that are variables of results. Ids are in the model, and parts are blocks.
fn variables(arrays: &'static [Array]) -> impl Iterator<Item = (usize, &'static Array)> {
    let model = [vtu::NODE_ID.name, vtu::ELEMENT_ID.name, vtu::PART.name];
    arrays.iter().enumerate().filter(move |(_, array)| !model.contains(&array.name))
}

/// Returns the names of the variables, one for each component.
fn names(arrays: &'static [Array]) -> Vec<String> {
    let of = |(_, array): (usize, &Array)| {
        // ParaView deforms the mesh by the vector of this name.
        let name = if array.name == vtu::DISPLACEMENT.name { "displ" } else { array.name };
        let suffixes: &[&str] = match array.components {
            3 => &VECTOR,
            6 => &TENSOR,
            _ => &[""],
        };
        suffixes.iter().map(|suffix| format!("{name}{suffix}")).collect::<Vec<_>>()
    };
    variables(arrays).flat_map(of).collect()
}

impl ExodusModel {
    /// Takes the model from the first step of a run; the names of parts are those of its job.
    ///
    /// # Errors
    /// An id has more than 31 bits, or a cell is of an unknown type.
    pub fn new(first: &Snapshot, part_names: &BTreeMap<u32, String>) -> Result<Self, String> {
        let topology = &first.topology;
        let elements = ids(&first.cell_arrays[position(CELL_ARRAYS, vtu::ELEMENT_ID.name)]);
        let too_large = topology.nodes.iter().chain(elements).find(|&&id| id > i64::from(i32::MAX));
        if let Some(id) = too_large {
            return Err(format!("{id} is too large an id for EXODUS II: use ids below 2^31"));
        }
        let SnapshotArray::F32(displacement) =
            &first.point_arrays[position(POINT_ARRAYS, vtu::DISPLACEMENT.name)]
        else {
            unreachable!("displacements have 32 bits");
        };
        let initial = |c: usize| {
            let all = first.points.chunks_exact(3).zip(displacement.chunks_exact(3));
            all.map(|(x, u)| x[c] - u[c]).collect()
        };
        Ok(Self {
            nodes: topology.nodes.clone(),
            elements: elements.to_vec(),
            coordinates: std::array::from_fn(initial),
            connectivity: topology.connectivity.clone(),
            offsets: topology.offsets.clone(),
            blocks: blocks(first, part_names)?,
        })
    }

    /// Returns the definition of the file, with room for `steps` records.
    ///
    /// # Errors
    /// The library refuses a name.
    pub fn definition(&self, steps: usize) -> Result<DataSet, InvalidDataSet> {
        let mut data = DataSet::new();
        data.add_global_attr_string("title", "Crumple")?;
        data.add_global_attr_f32("api_version", vec![VERSION])?;
        data.add_global_attr_f32("version", vec![VERSION])?;
        data.add_global_attr_i32("floating_point_word_size", vec![4])?;
        data.add_global_attr_i32("file_size", vec![1])?;
        data.add_global_attr_i32("maximum_name_length", vec![NAME as i32 - 1])?;
        data.set_unlimited_dim("time_step", steps)?;
        let (on_nodes, on_elements) = (names(POINT_ARRAYS), element_names());
        for (name, size) in [
            ("len_string", 33),
            ("len_line", 81),
            ("len_name", NAME),
            ("four", 4),
            ("num_dim", 3),
            ("num_nodes", self.nodes.len()),
            ("num_elem", self.elements.len()),
            ("num_el_blk", self.blocks.len()),
            ("num_nod_var", on_nodes.len()),
            ("num_elem_var", on_elements.len()),
        ] {
            data.add_fixed_dim(name, size)?;
        }
        data.add_var_f64("time_whole", &["time_step"])?;
        data.add_var_i32("eb_status", &["num_el_blk"])?;
        data.add_var_i32("eb_prop1", &["num_el_blk"])?;
        data.add_var_attr_string("eb_prop1", "name", "ID")?;
        data.add_var_u8("eb_names", &["num_el_blk", "len_name"])?;
        for name in ["coordx", "coordy", "coordz"] {
            data.add_var_f32(name, &["num_nodes"])?;
        }
        data.add_var_u8("coor_names", &["num_dim", "len_name"])?;
        data.add_var_i32("node_num_map", &["num_nodes"])?;
        data.add_var_i32("elem_num_map", &["num_elem"])?;
        data.add_var_u8("name_nod_var", &["num_nod_var", "len_name"])?;
        data.add_var_u8("name_elem_var", &["num_elem_var", "len_name"])?;
        data.add_var_i32("elem_var_tab", &["num_el_blk", "num_elem_var"])?;
        for (block, b) in self.blocks.iter().zip(1..) {
            let [count, width] = [format!("num_el_in_blk{b}"), format!("num_nod_per_el{b}")];
            data.add_fixed_dim(&count, block.elements.len())?;
            data.add_fixed_dim(&width, block.corners)?;
            data.add_var_i32(&format!("connect{b}"), &[&count, &width])?;
            data.add_var_attr_string(&format!("connect{b}"), "elem_type", block.kind)?;
            for v in 1..=on_elements.len() {
                data.add_var_f32(&format!("vals_elem_var{v}eb{b}"), &["time_step", &count])?;
            }
        }
        for v in 1..=on_nodes.len() {
            data.add_var_f32(&format!("vals_nod_var{v}"), &["time_step", "num_nodes"])?;
        }
        Ok(data)
    }
}

/// Returns the names of the variables of elements.
fn element_names() -> Vec<String> {
    names(CELL_ARRAYS).into_iter().chain([STATUS.into()]).collect()
}

/// Returns the element blocks: elements of one part and type, in ascending order of parts. A block
/// has the name of its part; without one, or with one that is too long or not its own, `part_ID`.
fn blocks(
    first: &Snapshot,
    part_names: &BTreeMap<u32, String>,
) -> Result<Vec<WrittenBlock>, String> {
    let name_of = |part: u32| {
        let name = part_names.get(&part).filter(|name| {
            name.len() < NAME && part_names.values().filter(|other| other == name).count() == 1
        });
        name.cloned().unwrap_or_else(|| format!("part_{part}"))
    };
    let SnapshotArray::U32(parts) = &first.cell_arrays[position(CELL_ARRAYS, vtu::PART.name)]
    else {
        unreachable!("ids of parts have 32 bits");
    };
    let types = &first.topology.types;
    let mut groups: BTreeMap<(u32, usize, u8), Vec<usize>> = BTreeMap::new();
    for (element, (&part, bounds)) in
        parts.iter().zip(first.topology.offsets.windows(2)).enumerate()
    {
        let corners = (bounds[1] - bounds[0]) as usize;
        groups.entry((part, corners, types[element])).or_default().push(element);
    }
    let mut free = parts.iter().copied().max().unwrap_or(0);
    let mut blocks: Vec<WrittenBlock> = Vec::new();
    for ((part, corners, kind), elements) in groups.into_iter().rev() {
        let kind = match (kind, corners) {
            (_, 8) => "HEX8",
            (10, _) => "TETRA4",
            (24, _) => "TETRA10",
            (13, _) => "WEDGE6",
            (_, 4) => "SHELL4",
            (_, 3) => "TRISHELL3",
            (_, 2) => "BEAM2",
            (_, 1) => "SPHERE",
            (kind, _) => return Err(format!("cells of VTK type {kind} with {corners} nodes")),
        };
        // The largest group of corners of a part has its id.
        let first = !blocks.iter().any(|b: &WrittenBlock| i64::from(b.id) == i64::from(part));
        let (id, name) = if first {
            (part, name_of(part))
        } else {
            free += 1;
            (free, format!("part_{part}_{}", kind.to_lowercase()))
        };
        let id = i32::try_from(id).map_err(|_| format!("part {part}: its id is too large"))?;
        blocks.push(WrittenBlock { id, name, kind, corners, elements });
    }
    blocks.reverse();
    Ok(blocks)
}

/// A buffered file that two owners write: the library, and the one who flushes it at the end.
struct Shared(Rc<RefCell<BufWriter<File>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().flush()
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}

/// The file under construction.
pub struct ExodusWriter<'a> {
    file: FileWriter<'a>,
    buffer: Rc<RefCell<BufWriter<File>>>,
    model: &'a ExodusModel,
    /// Values of the last step on nodes, for nodes that have no elements any more.
    last: Vec<Vec<f32>>,
}

/// Returns text of [`NAME`] bytes for each name, filled with zeros.
fn text<'n>(names: impl IntoIterator<Item = &'n str>) -> Vec<u8> {
    let of = |name: &str| {
        let mut bytes = name.as_bytes()[..name.len().min(NAME - 1)].to_vec();
        bytes.resize(NAME, 0);
        bytes
    };
    names.into_iter().flat_map(of).collect()
}

/// Makes an error a message.
fn said(error: impl std::fmt::Debug) -> String {
    format!("{error:?}")
}

impl<'a> ExodusWriter<'a> {
    /// Creates the file and writes the model.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path, model: &'a ExodusModel, data: &'a DataSet) -> Result<Self, String> {
        let file = File::create(path).map_err(|error| error.to_string())?;
        let buffer = Rc::new(RefCell::new(BufWriter::with_capacity(1 << 20, file)));
        let output = Box::new(Shared(buffer.clone()));
        let name = path.to_string_lossy();
        let mut file = FileWriter::open_seek_write(&name, output).map_err(said)?;
        file.set_def(data, Version::Offset64Bit, 0).map_err(said)?;
        let mut writer = Self { file, buffer, model, last: Vec::new() };
        writer.write_model()?;
        Ok(writer)
    }

    fn write_model(&mut self) -> Result<(), String> {
        let Self { file, model, last, .. } = self;
        let (blocks, elements) = (&model.blocks, &model.elements);
        let small = |ids: &[i64]| ids.iter().map(|&id| id as i32).collect::<Vec<i32>>();
        let mut integers = |name: &str, values: &[i32]| file.write_var_i32(name, values);
        integers("eb_status", &vec![1; blocks.len()]).map_err(said)?;
        integers("eb_prop1", &blocks.iter().map(|b| b.id).collect::<Vec<_>>()).map_err(said)?;
        integers("node_num_map", &small(&model.nodes)).map_err(said)?;
        // Elements are numbered block by block.
        let order = blocks.iter().flat_map(|b| &b.elements);
        let map: Vec<i64> = order.map(|&e| elements[e]).collect();
        integers("elem_num_map", &small(&map)).map_err(said)?;
        let on_elements = element_names();
        integers("elem_var_tab", &vec![1; blocks.len() * on_elements.len()]).map_err(said)?;
        for (block, b) in blocks.iter().zip(1..) {
            let corners = block.elements.iter().flat_map(|&e| {
                let bounds = model.offsets[e] as usize..model.offsets[e + 1] as usize;
                model.connectivity[bounds].iter().map(|&corner| corner as i32 + 1)
            });
            integers(&format!("connect{b}"), &corners.collect::<Vec<_>>()).map_err(said)?;
        }
        for (name, values) in ["coordx", "coordy", "coordz"].into_iter().zip(&model.coordinates) {
            file.write_var_f32(name, values).map_err(said)?;
        }
        let on_nodes = names(POINT_ARRAYS);
        for (name, bytes) in [
            ("eb_names", text(blocks.iter().map(|b| &b.name[..]))),
            ("coor_names", text(["x", "y", "z"])),
            ("name_nod_var", text(on_nodes.iter().map(String::as_str))),
            ("name_elem_var", text(on_elements.iter().map(String::as_str))),
        ] {
            file.write_var_u8(name, &bytes).map_err(said)?;
        }
        *last = vec![vec![0.0; model.nodes.len()]; on_nodes.len()];
        Ok(())
    }

    /// Writes a step as a record. A step may lack nodes and elements of the first one.
    ///
    /// # Errors
    /// It has others, or the file cannot be written.
    pub fn write_step(&mut self, record: usize, step: &Snapshot) -> Result<(), String> {
        let Self { file, model, last, .. } = self;
        file.write_record_f64("time_whole", record, &[step.time]).map_err(said)?;
        let places = |known: &[i64], ids: &[i64], what: &str| -> Result<Vec<usize>, String> {
            let place = |id: &i64| {
                known.binary_search(id).map_err(|_| {
                    format!("{what} {id} of time {} is not in the first step", step.time)
                })
            };
            ids.iter().map(place).collect()
        };
        let nodes = places(&model.nodes, &step.topology.nodes, "node")?;
        let components = variables(POINT_ARRAYS)
            .flat_map(|(i, a)| (0..a.components).map(move |c| (i, a.components, c)));
        for ((column, width, component), (values, v)) in components.zip(last.iter_mut().zip(1..)) {
            scatter(&step.point_arrays[column], (width, component), &nodes, values);
            file.write_record_f32(&format!("vals_nod_var{v}"), record, values).map_err(said)?;
        }
        let present = ids(&step.cell_arrays[position(CELL_ARRAYS, vtu::ELEMENT_ID.name)]);
        let elements = places(&model.elements, present, "element")?;
        let mut number = 0;
        let mut write = |values: &[f32]| -> Result<(), String> {
            number += 1;
            for (block, b) in model.blocks.iter().zip(1..) {
                let name = format!("vals_elem_var{number}eb{b}");
                let of_block: Vec<f32> = block.elements.iter().map(|&e| values[e]).collect();
                file.write_record_f32(&name, record, &of_block).map_err(said)?;
            }
            Ok(())
        };
        for (column, array) in variables(CELL_ARRAYS) {
            for component in 0..array.components {
                let mut values = vec![0.0; model.elements.len()];
                let from = &step.cell_arrays[column];
                scatter(from, (array.components, component), &elements, &mut values);
                write(&values)?;
            }
        }
        let mut status = vec![0.0; model.elements.len()];
        elements.iter().for_each(|&e| status[e] = 1.0);
        write(&status)
    }

    /// Completes the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(self) -> Result<(), String> {
        self.file.close().map_err(said)?;
        let ended = self.buffer.borrow_mut().flush();
        ended.map_err(|error| error.to_string())
    }
}

/// Stores one component of a column at the places of its points or cells.
fn scatter(
    column: &SnapshotArray,
    (width, component): (usize, usize),
    places: &[usize],
    values: &mut [f32],
) {
    let at = |i: usize| width * i + component;
    for (i, &place) in places.iter().enumerate() {
        values[place] = match column {
            SnapshotArray::F32(from) => from[at(i)],
            SnapshotArray::U32(from) => from[at(i)] as f32,
            SnapshotArray::I64(from) => from[at(i)] as f32,
            SnapshotArray::U8(from) => f32::from(from[at(i)]),
        };
    }
}
