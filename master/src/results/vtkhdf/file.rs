//! Appends steps to a VTKHDF file. A topology that is the same as in the step before is written
//! once.

use crate::results::snapshot::{Snapshot, SnapshotArray, Topology};
use crumple_worker::vtu::{Array, CELL_ARRAYS, NumberType, POINT_ARRAYS};
use rust_hdf5::{DatatypeMessage, H5Dataset, H5File, H5Group, H5Type, Hdf5Error};
use std::path::Path;

type Result<T> = std::result::Result<T, Hdf5Error>;

/// Rows per chunk: some ten kilobytes.
const CHUNK: usize = 4096;

/// A data set that grows along its first axis.
struct Growing {
    set: H5Dataset,
    /// Numbers per row; `None` for a one-dimensional set.
    width: Option<usize>,
    rows: usize,
}

impl Growing {
    fn create<T: H5Type>(
        group: &H5Group,
        name: &str,
        width: Option<usize>,
        chunk: usize,
    ) -> Result<Self> {
        let more = width.as_slice();
        let most: Vec<Option<usize>> =
            std::iter::once(None).chain(more.iter().map(|&w| Some(w))).collect();
        let set = group
            .new_dataset::<T>()
            .shape([&[0], more].concat())
            .chunk(&[&[chunk], more].concat())
            .max_shape(&most)
            .create(name)?;
        Ok(Self { set, width, rows: 0 })
    }

    fn append<T: H5Type>(&mut self, numbers: &[T]) -> Result<()> {
        let more = self.width.as_slice();
        let rows = numbers.len() / self.width.unwrap_or(1);
        if rows == 0 {
            return Ok(());
        }
        self.set.extend(&[&[self.rows + rows], more].concat())?;
        self.set.write_slice(
            &[&[self.rows], vec![0; more.len()].as_slice()].concat(),
            &[&[rows], more].concat(),
            numbers,
        )?;
        self.rows += rows;
        Ok(())
    }

    fn append_column(&mut self, column: &SnapshotArray) -> Result<()> {
        match column {
            SnapshotArray::F32(numbers) => self.append(numbers),
            SnapshotArray::U32(numbers) => self.append(numbers),
            SnapshotArray::I64(numbers) => self.append(numbers),
            SnapshotArray::U8(numbers) => self.append(numbers),
        }
    }
}

/// Arrays on points or cells, with the start of each step's values.
struct Arrays {
    values: Vec<Growing>,
    offsets: Vec<Growing>,
}

impl Arrays {
    fn create(root: &H5Group, steps: &H5Group, name: &str, arrays: &[Array]) -> Result<Self> {
        let (group, offsets) =
            (root.create_group(name)?, steps.create_group(&format!("{name}Offsets"))?);
        let create = |array: &Array| {
            let width = (array.components > 1).then_some(array.components);
            match array.kind {
                NumberType::F32 => Growing::create::<f32>(&group, array.name, width, CHUNK),
                NumberType::U32 => Growing::create::<u32>(&group, array.name, width, CHUNK),
                NumberType::I64 => Growing::create::<i64>(&group, array.name, width, CHUNK),
                NumberType::U8 => Growing::create::<u8>(&group, array.name, width, CHUNK),
            }
        };
        Ok(Self {
            values: arrays.iter().map(create).collect::<Result<_>>()?,
            offsets: arrays
                .iter()
                .map(|a| per_step::<i64>(&offsets, a.name))
                .collect::<Result<_>>()?,
        })
    }

    fn append(&mut self, columns: &[SnapshotArray]) -> Result<()> {
        for ((values, offsets), column) in
            self.values.iter_mut().zip(&mut self.offsets).zip(columns)
        {
            offsets.append(&[values.rows as i64])?;
            values.append_column(column)?;
        }
        Ok(())
    }
}

/// Creates a data set with a number for each step.
fn per_step<T: H5Type>(group: &H5Group, name: &str) -> Result<Growing> {
    Growing::create::<T>(group, name, None, 256)
}

/// The file under construction.
pub struct VtkhdfWriter {
    file: H5File,
    steps: H5Group,
    count: i64,
    /// Points, cells and corners of each topology.
    numbers: [Growing; 3],
    points: Growing,
    connectivity: Growing,
    offsets: Growing,
    types: Growing,
    on_points: Arrays,
    on_cells: Arrays,
    times: Growing,
    /// Start of the topology of each step: part; cells; corners. Also its number of parts.
    part_offsets: Growing,
    topology_offsets: [Growing; 2],
    parts: Growing,
    point_offsets: Growing,
    /// Topology of the last step, and its start.
    last: (Topology, [i64; 3]),
}

impl VtkhdfWriter {
    /// Creates a file.
    pub fn create(path: &Path) -> Result<Self> {
        let file = H5File::create(path)?;
        let root = file.create_group("VTKHDF")?;
        root.set_attr_array_numeric("Version", &[2_i64, 0])?;
        let kind = b"UnstructuredGrid";
        let text = DatatypeMessage::FixedString { size: kind.len() as u32, padding: 0, charset: 0 };
        root.set_attr_typed("Type", text, kind.to_vec())?;
        let steps = root.create_group("Steps")?;
        let number = |name: &str| per_step::<i64>(&root, name);
        let of_step = |name: &str| per_step::<i64>(&steps, name);
        // One column, for the one topology of a grid.
        let of_topology = |name: &str| Growing::create::<i64>(&steps, name, Some(1), 256);
        Ok(Self {
            numbers: [
                number("NumberOfPoints")?,
                number("NumberOfCells")?,
                number("NumberOfConnectivityIds")?,
            ],
            points: Growing::create::<f32>(&root, "Points", Some(3), CHUNK)?,
            connectivity: Growing::create::<i64>(&root, "Connectivity", None, CHUNK)?,
            offsets: Growing::create::<i64>(&root, "Offsets", None, CHUNK)?,
            types: Growing::create::<u8>(&root, "Types", None, CHUNK)?,
            on_points: Arrays::create(&root, &steps, "PointData", POINT_ARRAYS)?,
            on_cells: Arrays::create(&root, &steps, "CellData", CELL_ARRAYS)?,
            times: per_step::<f64>(&steps, "Values")?,
            part_offsets: of_step("PartOffsets")?,
            topology_offsets: [of_topology("CellOffsets")?, of_topology("ConnectivityIdOffsets")?],
            parts: of_step("NumberOfParts")?,
            point_offsets: of_step("PointOffsets")?,
            last: (Topology::default(), [0; 3]),
            count: 0,
            file,
            steps,
        })
    }

    /// Appends a step.
    pub fn append(&mut self, snapshot: Snapshot) -> Result<()> {
        let topology = &snapshot.topology;
        if self.count == 0 || *topology != self.last.0 {
            self.last.1 =
                [self.numbers[0].rows, self.types.rows, self.connectivity.rows].map(|n| n as i64);
            let sizes = [topology.nodes.len(), topology.types.len(), topology.connectivity.len()];
            for (set, size) in self.numbers.iter_mut().zip(sizes) {
                set.append(&[size as i64])?;
            }
            self.connectivity.append(&topology.connectivity)?;
            self.offsets.append(&topology.offsets)?;
            self.types.append(&topology.types)?;
        }
        let [part, cells, corners] = self.last.1;
        self.times.append(&[snapshot.time])?;
        self.part_offsets.append(&[part])?;
        self.parts.append(&[1_i64])?;
        self.topology_offsets[0].append(&[cells])?;
        self.topology_offsets[1].append(&[corners])?;
        self.point_offsets.append(&[self.points.rows as i64])?;
        self.points.append(&snapshot.points)?;
        self.on_points.append(&snapshot.point_arrays)?;
        self.on_cells.append(&snapshot.cell_arrays)?;
        self.last.0 = snapshot.topology;
        self.count += 1;
        Ok(())
    }

    /// Ends the file.
    pub fn finish(self) -> Result<()> {
        self.steps.set_attr_numeric("NSteps", &self.count)?;
        self.file.close()
    }
}
