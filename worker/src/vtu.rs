//! The fields of one worker at one time, as a `.vtu` file for ParaView (VTK XML, unstructured
//! grid, raw appended data).
//!
//! Names and types of the arrays are declared once, in [`POINT_ARRAYS`] and [`CELL_ARRAYS`]. A
//! piece with other arrays is refused. The master writes its `.pvtu` files from the same tables.
//! A file is written under a temporary name and then renamed, so that a run that is killed leaves
//! no incomplete file.

use crate::fem::materials::has_damage;
use crumple_proto::disk::{WatchedFile, watched};
use crumple_proto::mesh::Shape;
use crumple_proto::partition::Settings;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Number type of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// 32-bit float.
    F32,
    /// 32-bit unsigned integer.
    U32,
    /// 64-bit integer.
    I64,
    /// Byte.
    U8,
}

impl NumberType {
    /// Returns the name of the type in VTK.
    pub fn vtk_name(self) -> &'static str {
        match self {
            NumberType::F32 => "Float32",
            NumberType::U32 => "UInt32",
            NumberType::I64 => "Int64",
            NumberType::U8 => "UInt8",
        }
    }
}

/// Declaration of an array, for pieces and for the master's index files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// Name in ParaView.
    pub name: &'static str,
    /// Numbers per point or cell.
    pub components: usize,
    /// Number type.
    pub kind: NumberType,
}

impl Array {
    /// Returns this array with its values, point by point or cell by cell, with the components of
    /// one point adjacent.
    pub fn with<'a>(&self, values: impl Into<ArrayValues<'a>>) -> FieldColumn<'a> {
        FieldColumn { array: *self, values: values.into() }
    }
}

impl Array {
    /// Returns this array of one point as that of several points.
    pub fn of_points(self, points: usize) -> Self {
        Self { components: points * self.components, ..self }
    }
}

const fn array(name: &'static str, components: usize, kind: NumberType) -> Array {
    Array { name, components, kind }
}

/// Current coordinates [length].
pub const POINTS: Array = array("Points", 3, NumberType::F32);

/// Displacement since the start [length].
pub const DISPLACEMENT: Array = array("displacement", 3, NumberType::F32);
/// Velocity at mid-step [length/time].
pub const VELOCITY: Array = array("velocity", 3, NumberType::F32);
/// Rotational velocity at mid-step [1/time].
pub const ROTATIONAL_VELOCITY: Array = array("rotational_velocity", 3, NumberType::F32);
/// Contact force of the last step, zero for ghosts [force]. Only if the job asks for it
/// ([`OptionalArrays`]).
pub const CONTACT_FORCE: Array = array("contact_force", 3, NumberType::F32);
/// Global node id.
pub const NODE_ID: Array = array("node_id", 1, NumberType::I64);

/// Largest effective plastic strain over the thickness.
pub const PLASTIC_STRAIN: Array = array("plastic_strain", 1, NumberType::F32);
/// Largest damage over the thickness: 0 in intact material, 1 where the law fails. Only in jobs
/// with such a material ([`OptionalArrays`]).
pub const DAMAGE: Array = array("damage", 1, NumberType::F32);
/// Largest von Mises stress over the thickness [force/length^2].
pub const VON_MISES: Array = array("von_mises", 1, NumberType::F32);
/// Global stress at mid-surface: xx, yy, zz, xy, yz, zx, which is VTK's own order [force/length^2].
pub const STRESS: Array = array("stress", 6, NumberType::F32);
/// Current thickness [length].
pub const THICKNESS: Array = array("thickness", 1, NumberType::F32);
/// Stress of the points through the thickness, six components each as in [`STRESS`]
/// [force/length^2]. Only if the job asks for it; [`OptionalArrays`] has the number of points. An
/// element with fewer points repeats its last one.
pub const STRESS_OF_POINTS: Array = array("stress_of_points", 6, NumberType::F32);
/// Effective plastic strain of the same points.
pub const PLASTIC_STRAIN_OF_POINTS: Array = array("plastic_strain_of_points", 1, NumberType::F32);
/// Id of the part.
pub const PART: Array = array("part", 1, NumberType::U32);
/// Number of the worker that wrote the piece, counted from 0.
pub const WORKER: Array = array("worker", 1, NumberType::U32);
/// Number of the worker that searches for contact at the first node of the element, counted from 0.
/// Only with a second decomposition of contact ([`OptionalArrays`]).
pub const CONTACT_WORKER: Array = array("contact_worker", 1, NumberType::U32);
/// Class of the element on that worker: [`INTERIOR`], [`INTERFACE`] or [`EXTERIOR`].
pub const CLASS: Array = array("class", 1, NumberType::U8);
/// Global element id.
pub const ELEMENT_ID: Array = array("element_id", 1, NumberType::I64);

/// [`CLASS`] of an own element that is wholly in the internal box.
pub const INTERIOR: u8 = 0;
/// [`CLASS`] of an own element that touches the buffer.
pub const INTERFACE: u8 = 1;
/// [`CLASS`] of a ghost element.
pub const EXTERIOR: u8 = 2;

/// Arrays on points, in the order of the file.
pub const POINT_ARRAYS: &[Array] = &[DISPLACEMENT, VELOCITY, ROTATIONAL_VELOCITY, NODE_ID];
/// Arrays on cells, in the order of the file.
pub const CELL_ARRAYS: &[Array] =
    &[PLASTIC_STRAIN, VON_MISES, STRESS, THICKNESS, PART, WORKER, CLASS, ELEMENT_ID];

/// Arrays that only some runs have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OptionalArrays {
    /// [`CONTACT_WORKER`].
    pub contact_worker: bool,
    /// [`CONTACT_FORCE`].
    pub contact_force: bool,
    /// [`DAMAGE`].
    pub damage: bool,
    /// Number of points of [`STRESS_OF_POINTS`] and [`PLASTIC_STRAIN_OF_POINTS`]; 0 without them.
    pub points: usize,
}

impl OptionalArrays {
    /// Returns those of a run.
    pub fn of(settings: &Settings) -> Self {
        Self {
            contact_worker: settings.has_second_decomposition(),
            contact_force: settings.contact_forces,
            damage: settings.materials.iter().any(has_damage),
            points: settings.field_points,
        }
    }

    /// Returns the arrays on cells, in the order of the file.
    pub fn cell_arrays(self) -> Vec<Array> {
        let contact_worker = self.contact_worker.then_some(CONTACT_WORKER);
        let damage = self.damage.then_some(DAMAGE);
        let points = [STRESS_OF_POINTS, PLASTIC_STRAIN_OF_POINTS]
            .map(|array| array.of_points(self.points))
            .into_iter()
            .filter(|_| self.points > 0);
        CELL_ARRAYS.iter().copied().chain(contact_worker).chain(damage).chain(points).collect()
    }

    /// Returns the arrays on points, in the order of the file.
    pub fn point_arrays(self) -> Vec<Array> {
        POINT_ARRAYS.iter().copied().chain(self.contact_force.then_some(CONTACT_FORCE)).collect()
    }
}

/// Returns the folder of an output time within the folder of the fields.
pub fn step_folder(step: usize) -> String {
    format!("step_{step:06}")
}

/// Returns the file of a worker's own elements within the folder of the output time.
pub fn piece_name(worker: usize) -> String {
    format!("piece_{worker:03}.vtu")
}

/// Returns the file of a worker's ghost elements within the folder of the output time.
pub fn exterior_name(worker: usize) -> String {
    format!("exterior_{worker:03}.vtu")
}

/// Byte order of the numbers, as VTK names it.
pub const BYTE_ORDER: &str =
    if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };

/// Values of one column.
#[derive(Clone, Copy, Debug)]
pub enum ArrayValues<'a> {
    /// 32-bit floats.
    F32(&'a [f32]),
    /// 32-bit unsigned integers.
    U32(&'a [u32]),
    /// 64-bit integers.
    I64(&'a [i64]),
    /// Bytes.
    U8(&'a [u8]),
}

impl<'a> ArrayValues<'a> {
    fn kind(&self) -> NumberType {
        match self {
            ArrayValues::F32(_) => NumberType::F32,
            ArrayValues::U32(_) => NumberType::U32,
            ArrayValues::I64(_) => NumberType::I64,
            ArrayValues::U8(_) => NumberType::U8,
        }
    }

    fn len(&self) -> usize {
        match self {
            ArrayValues::F32(v) => v.len(),
            ArrayValues::U32(v) => v.len(),
            ArrayValues::I64(v) => v.len(),
            ArrayValues::U8(v) => v.len(),
        }
    }

    fn bytes(&self) -> &'a [u8] {
        match self {
            ArrayValues::F32(v) => bytemuck::cast_slice(v),
            ArrayValues::U32(v) => bytemuck::cast_slice(v),
            ArrayValues::I64(v) => bytemuck::cast_slice(v),
            ArrayValues::U8(v) => v,
        }
    }
}

macro_rules! values_from {
    ($($number:ty => $variant:ident),*) => {$(
        impl<'a> From<&'a [$number]> for ArrayValues<'a> {
            fn from(values: &'a [$number]) -> Self {
                ArrayValues::$variant(values)
            }
        }
        impl<'a> From<&'a Vec<$number>> for ArrayValues<'a> {
            fn from(values: &'a Vec<$number>) -> Self {
                ArrayValues::$variant(values)
            }
        }
    )*};
}
values_from!(f32 => F32, u32 => U32, i64 => I64, u8 => U8);

impl<'a, const N: usize> From<&'a [[f32; N]]> for ArrayValues<'a> {
    fn from(values: &'a [[f32; N]]) -> Self {
        ArrayValues::F32(values.as_flattened())
    }
}
impl<'a, const N: usize> From<&'a Vec<[f32; N]>> for ArrayValues<'a> {
    fn from(values: &'a Vec<[f32; N]>) -> Self {
        ArrayValues::F32(values.as_flattened())
    }
}

/// An array with its values, made by [`Array::with`].
#[derive(Clone, Copy, Debug)]
pub struct FieldColumn<'a> {
    array: Array,
    values: ArrayValues<'a>,
}

/// Cells in VTK's layout: corners are indices into the points of the piece.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
}

impl Cells {
    /// Adds an element. Corners beyond those of its shape are ignored (a triangle repeats its
    /// third).
    pub fn push(&mut self, shape: Shape, corners: &[u32]) {
        self.connectivity
            .extend(corners[..shape.corners()].iter().map(|&corner| i64::from(corner)));
        self.offsets.push(self.connectivity.len() as i64);
        self.types.push(match shape {
            Shape::Tri3 => 5,
            Shape::Quad4 => 9,
            Shape::Hex8 | Shape::Cohesive8 => 12,
            Shape::Tet4 => 10,
            Shape::Wedge6 => 13,
            Shape::Tet10 => 24,
            Shape::Line2 | Shape::Beam2 | Shape::Truss2 => 3,
            Shape::Point1 => 1,
        });
    }

    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        self.types.len()
    }

    /// Returns true if there are no cells.
    pub fn is_empty(&self) -> bool {
        self.types.is_empty()
    }

    /// Removes all cells and keeps the memory.
    pub fn clear(&mut self) {
        self.connectivity.clear();
        self.offsets.clear();
        self.types.clear();
    }
}

/// The fields of one worker at one time.
#[derive(Clone, Copy, Debug)]
pub struct FieldPiece<'a> {
    /// Simulated time [time].
    pub time: f64,
    /// Current coordinates of the points [length].
    pub points: &'a [[f32; 3]],
    /// One column for each of [`POINT_ARRAYS`], in that order.
    pub point_arrays: &'a [FieldColumn<'a>],
    /// Cells.
    pub cells: &'a Cells,
    /// One column for each of [`cell_arrays`], in that order.
    pub cell_arrays: &'a [FieldColumn<'a>],
}

impl FieldPiece<'_> {
    /// Writes the piece and creates the folder if necessary.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        self.check().map_err(|why| {
            io::Error::new(io::ErrorKind::InvalidInput, format!("{}: {why}", path.display()))
        })?;
        write_whole(path, |file| self.write_to(file))
    }

    fn check(&self) -> Result<(), String> {
        let has = |array: Array| self.cell_arrays.iter().any(|c| c.array.name == array.name);
        let optional = OptionalArrays {
            contact_worker: has(CONTACT_WORKER),
            contact_force: self.point_arrays.len() > POINT_ARRAYS.len(),
            damage: has(DAMAGE),
            points: self
                .cell_arrays
                .iter()
                .find(|c| c.array.name == PLASTIC_STRAIN_OF_POINTS.name)
                .map_or(0, |c| c.array.components),
        };
        let points = self.points.len();
        check_columns("point", &optional.point_arrays(), self.point_arrays, points)?;
        check_columns("cell", &optional.cell_arrays(), self.cell_arrays, self.cells.len())?;
        let points = self.points.len() as i64;
        match self.cells.connectivity.iter().find(|&&corner| corner >= points) {
            Some(corner) => Err(format!("a cell uses point {corner}, but there are {points}")),
            None => Ok(()),
        }
    }

    fn write_to(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut appended = Appended::default();
        writeln!(out, r#"<?xml version="1.0"?>"#)?;
        writeln!(
            out,
            r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{BYTE_ORDER}" header_type="UInt64">"#
        )?;
        writeln!(out, "<UnstructuredGrid>")?;
        writeln!(
            out,
            r#"<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{}</DataArray></FieldData>"#,
            self.time
        )?;
        writeln!(
            out,
            r#"<Piece NumberOfPoints="{}" NumberOfCells="{}">"#,
            self.points.len(),
            self.cells.len()
        )?;
        writeln!(out, "<Points>")?;
        appended.declare(out, &POINTS.with(self.points))?;
        writeln!(out, "</Points>\n<Cells>")?;
        appended.declare(
            out,
            &array("connectivity", 1, NumberType::I64).with(&self.cells.connectivity),
        )?;
        appended.declare(out, &array("offsets", 1, NumberType::I64).with(&self.cells.offsets))?;
        appended.declare(out, &array("types", 1, NumberType::U8).with(&self.cells.types))?;
        writeln!(out, "</Cells>\n<PointData>")?;
        for column in self.point_arrays {
            appended.declare(out, column)?;
        }
        writeln!(out, "</PointData>\n<CellData>")?;
        for column in self.cell_arrays {
            appended.declare(out, column)?;
        }
        writeln!(
            out,
            "</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">"
        )?;
        appended.write_to(out)?;
        writeln!(out, "\n</AppendedData>\n</VTKFile>")
    }
}

fn check_columns(
    place: &str,
    declared: &[Array],
    columns: &[FieldColumn<'_>],
    count: usize,
) -> Result<(), String> {
    if !columns.iter().map(|column| &column.array).eq(declared) {
        let names: Vec<_> = columns.iter().map(|column| column.array.name).collect();
        return Err(format!("{place} arrays {names:?} differ from the declared arrays"));
    }
    for FieldColumn { array, values } in columns {
        if values.kind() != array.kind {
            return Err(format!(
                "{place} array {}: {:?} values, but {:?} is declared",
                array.name,
                values.kind(),
                array.kind
            ));
        }
        if values.len() != count * array.components {
            let (have, need) = (values.len(), count * array.components);
            return Err(format!(
                "{place} array {}: {have} numbers, but {need} are expected",
                array.name
            ));
        }
    }
    Ok(())
}

/// The data blocks after the XML. Each is its length in bytes, then its values.
#[derive(Default)]
struct Appended<'a> {
    blocks: Vec<&'a [u8]>,
    offset: usize,
}

impl<'a> Appended<'a> {
    fn declare(&mut self, out: &mut dyn Write, column: &FieldColumn<'a>) -> io::Result<()> {
        let FieldColumn { array, values } = column;
        writeln!(
            out,
            r#"<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="appended" offset="{}"/>"#,
            array.kind.vtk_name(),
            array.name,
            array.components,
            self.offset
        )?;
        let bytes = values.bytes();
        self.offset += size_of::<u64>() + bytes.len();
        self.blocks.push(bytes);
        Ok(())
    }

    fn write_to(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(b"_")?;
        for block in &self.blocks {
            out.write_all(&(block.len() as u64).to_ne_bytes())?;
            out.write_all(block)?;
        }
        Ok(())
    }
}

/// Writes a file under the name `PATH.partial` and renames it when it is complete. Creates the
/// folder if necessary. Errors name the file. Each operation is under watch (`proto/src/disk.rs`),
/// not the time that `fill` needs besides.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let partial = PathBuf::from(format!("{}.partial", path.display()));
    let write = || {
        if let Some(folder) = path.parent() {
            watched(folder, || fs::create_dir_all(folder))?;
        }
        let file = WatchedFile::open(&partial, |path| File::create(path))?;
        let mut file = BufWriter::with_capacity(1 << 20, file);
        fill(&mut file)?;
        file.into_inner().map_err(|e| e.into_error())?;
        watched(path, || fs::rename(&partial, path))
    };
    write().map_err(|error| {
        let _ = fs::remove_file(&partial); // report the first error
        io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes a quad and a triangle, with different values at each point and cell.
    fn write_two_cells(path: &Path) -> io::Result<()> {
        let points: Vec<[f32; 3]> = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.5],
            [0.0, 1.0, 0.0],
            [2.0, 0.5, 0.25],
        ];
        let mut cells = Cells::default();
        cells.push(Shape::Quad4, &[0, 1, 2, 3]);
        cells.push(Shape::Tri3, &[1, 4, 2, 2]);
        let vectors: Vec<[f32; 3]> = (0..5).map(|i| [i as f32, -0.5, 0.1]).collect();
        let stress: Vec<[f32; 6]> = vec![[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [-1.0; 6]];
        let node_id: Vec<i64> = vec![11, 12, 13, 14, 1 << 40];
        FieldPiece {
            time: 65.8,
            points: &points,
            point_arrays: &[
                DISPLACEMENT.with(&vectors),
                VELOCITY.with(&vectors),
                ROTATIONAL_VELOCITY.with(&vectors),
                NODE_ID.with(&node_id),
            ],
            cells: &cells,
            cell_arrays: &[
                PLASTIC_STRAIN.with(&vec![0.0_f32, 0.25]),
                VON_MISES.with(&vec![0.1_f32, 0.2]),
                STRESS.with(&stress),
                THICKNESS.with(&vec![2.5_f32, 2.5]),
                PART.with(&vec![1_u32, 2]),
                WORKER.with(&vec![3_u32, 3]),
                CLASS.with(&vec![INTERIOR, INTERFACE]),
                ELEMENT_ID.with(&vec![7_i64, 9]),
            ],
        }
        .write(path)
    }

    fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
        let start = element
            .find(&format!(" {name}=\""))
            .unwrap_or_else(|| panic!("no {name} in {element}"));
        element[start..].split('"').nth(1).unwrap()
    }

    /// Returns the type and the bytes of the array `name`, found by its offset.
    fn read_array(file: &[u8], name: &str) -> (String, Vec<u8>) {
        let marker = b"<AppendedData encoding=\"raw\">\n_";
        let end = file.windows(marker.len()).position(|window| window == marker).unwrap();
        let header = std::str::from_utf8(&file[..end]).unwrap();
        let element =
            header.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
        let start = end + marker.len() + attribute(element, "offset").parse::<usize>().unwrap();
        let length = u64::from_ne_bytes(file[start..start + 8].try_into().unwrap()) as usize;
        (attribute(element, "type").to_owned(), file[start + 8..start + 8 + length].to_vec())
    }

    #[test]
    fn a_piece_reads_back() {
        let dir = scratch("reads-back");
        let path = dir.join("step_000001").join(piece_name(3));
        write_two_cells(&path).unwrap();
        let file = fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&file);
        assert!(text.contains(r#"<Piece NumberOfPoints="5" NumberOfCells="2">"#));
        assert!(text.contains(r#"format="ascii">65.8</DataArray>"#));
        assert!(text.ends_with("\n</AppendedData>\n</VTKFile>\n"));

        let longs = |name| {
            let (kind, bytes) = read_array(&file, name);
            assert_eq!(kind, "Int64");
            bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned::<i64>).collect::<Vec<_>>()
        };
        assert_eq!(longs("connectivity"), [0, 1, 2, 3, 1, 4, 2]);
        assert_eq!(longs("offsets"), [4, 7]);
        assert_eq!(longs("node_id"), [11, 12, 13, 14, 1 << 40]);
        assert_eq!(longs("element_id"), [7, 9]);
        assert_eq!(read_array(&file, "types"), ("UInt8".into(), vec![9, 5]));
        assert_eq!(read_array(&file, "class"), ("UInt8".into(), vec![0, 1]));
        let (kind, bytes) = read_array(&file, "stress");
        assert_eq!(kind, "Float32");
        let stress: Vec<f32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        assert_eq!(stress[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for array in POINT_ARRAYS.iter().chain(CELL_ARRAYS) {
            assert_eq!(read_array(&file, array.name).0, array.kind.vtk_name());
        }
        let names: Vec<_> =
            fs::read_dir(path.parent().unwrap()).unwrap().map(|f| f.unwrap().file_name()).collect();
        assert_eq!(names, ["piece_003.vtu"], "the partial file is gone");
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn undeclared_arrays_are_refused() {
        let dir = scratch("refused");
        let path = dir.join(piece_name(0));
        let cells = Cells::default();
        let none: &[f32] = &[];
        let columns = [DISPLACEMENT, VELOCITY, ROTATIONAL_VELOCITY].map(|array| array.with(none));
        let piece = FieldPiece {
            time: 0.0,
            points: &[],
            point_arrays: &columns,
            cells: &cells,
            cell_arrays: &[],
        };
        let error = piece.write(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        assert!(error.to_string().contains("differ from the declared arrays"), "{error}");

        let long = check_columns("cell", &[PART], &[PART.with(&vec![1_u32, 2])], 3).unwrap_err();
        assert!(long.contains("part: 2 numbers, but 3"), "{long}");
        let kind = check_columns("cell", &[PART], &[PART.with(&vec![1_i64])], 1).unwrap_err();
        assert!(kind.contains("I64 values, but U32"), "{kind}");
        assert!(!path.exists());
    }

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let dir = scratch("old-file");
        let path = dir.join(piece_name(0));
        write_two_cells(&path).unwrap();
        let before = fs::read(&path).unwrap();
        let error = write_whole(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("piece_000.vtu: disk full"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), before);
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        fs::remove_dir_all(dir).unwrap();
    }

    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("crumple-vtu-{name}-{}", std::process::id()))
    }
}
