//! Reads field files: the piece of one worker, and the series that names the pieces. Only files
//! of this program are read (`worker/src/vtu.rs`, `fields.rs`), and all their content is checked.
//! An error message names the file and the problem.

use bytemuck::Pod;
use crumple_worker::vtu::{self, Array, BYTE_ORDER, CELL_ARRAYS, NumberType, POINT_ARRAYS};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

/// End of the XML of a piece; the arrays follow.
const MARK: &[u8] = b"<AppendedData encoding=\"raw\">\n_";
/// Size of the length in bytes that precedes every array [bytes].
const LENGTH: usize = size_of::<u64>();

/// A step of a series in its collection.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldStep {
    /// Simulated time [time].
    pub time: f64,
    /// File that names its pieces.
    pub file: PathBuf,
}

/// The piece of one worker: its arrays by name.
pub struct PieceArrays {
    /// Simulated time [time].
    pub time: f64,
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    path: PathBuf,
    arrays: HashMap<String, StoredArray>,
    bytes: Vec<u8>,
}

/// Type and position of an array in the file.
struct StoredArray {
    kind: NumberType,
    bytes: Range<usize>,
}

/// Returns the steps of a collection (`.pvd`) in its order.
///
/// # Errors
/// The file is missing, or not in the format of this program.
pub fn steps(collection: &Path) -> Result<Vec<FieldStep>, String> {
    let text = text(collection)?;
    let broken = |why: &str| format!("{}: {why}", collection.display());
    let file = read_xml(&text, "Collection")
        .ok_or_else(|| broken("is not a complete collection of field files"))?;
    let step = |set: &Node| {
        let time: f64 = set.attribute("timestep")?.parse().ok()?;
        let file = same_folder(collection, set.attribute("file")?)?;
        time.is_finite().then_some(FieldStep { time, file })
    };
    let sets = file.descendants().filter(|node| node.has_tag_name("DataSet"));
    sets.map(|set| step(&set).ok_or_else(|| broken(&unread(&text, &set)))).collect()
}

/// Returns the files of the pieces that a step (`.pvtu`) names.
///
/// # Errors
/// The file is missing, or not in the format of this program.
pub fn pieces(step: &Path) -> Result<Vec<PathBuf>, String> {
    let text = text(step)?;
    let broken = |why: &str| format!("{}: {why}", step.display());
    let file = read_xml(&text, "PUnstructuredGrid")
        .ok_or_else(|| broken("is not a complete list of field pieces"))?;
    let pieces = file.descendants().filter(|node| node.has_tag_name("Piece"));
    let path = |piece: &Node| same_folder(step, piece.attribute("Source")?);
    pieces.map(|piece| path(&piece).ok_or_else(|| broken(&unread(&text, &piece)))).collect()
}

impl PieceArrays {
    /// Reads a piece and checks that all its arrays are complete.
    ///
    /// # Errors
    /// The file is missing, truncated, or not in the format of this program.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Self::parse(path, bytes).map_err(|why| format!("{}: {why}", path.display()))
    }

    fn parse(path: &Path, bytes: Vec<u8>) -> Result<Self, String> {
        let foreign = "is not a field file of this program";
        let head = bytes.windows(MARK.len()).position(|w| w == MARK).ok_or(foreign)?;
        let start = head + MARK.len();
        // The bytes after the mark are no XML, so the text before it is closed here.
        let head =
            std::str::from_utf8(&bytes[..head]).map_err(|_| foreign)?.to_owned() + "</VTKFile>";
        let file = read_xml(&head, "UnstructuredGrid").ok_or(foreign)?;
        let order = file.root_element().attribute("byte_order").ok_or(foreign)?;
        if order != BYTE_ORDER {
            return Err(format!("is from a machine with another byte order, {order}"));
        }
        let arrays_of = || file.descendants().filter(|node| node.has_tag_name("DataArray"));
        let time = arrays_of().find(|array| array.attribute("Name") == Some("TimeValue"));
        let time = time.and_then(|array| array.text()?.parse().ok()).ok_or(foreign)?;
        let piece = file.descendants().find(|node| node.has_tag_name("Piece")).ok_or(foreign)?;
        let count = |name| piece.attribute(name).and_then(|n| n.parse::<usize>().ok());
        let (points, cells) =
            (count("NumberOfPoints").ok_or(foreign)?, count("NumberOfCells").ok_or(foreign)?);
        let mut arrays = HashMap::new();
        for array in arrays_of().filter(|array| array.attribute("format") == Some("appended")) {
            let (name, stored) = stored(&head, &array, &bytes[start..])?;
            let numbers = stored.bytes.len() / size_of_kind(stored.kind);
            if numbers_due(&name, points, cells).is_some_and(|due| due != Some(numbers)) {
                return Err(format!(
                    "has {numbers} numbers in array `{name}` for {points} points and {cells} cells"
                ));
            }
            let bytes = start + stored.bytes.start..start + stored.bytes.end;
            arrays.insert(name, StoredArray { bytes, ..stored });
        }
        let piece = Self { time, points, cells, path: path.to_owned(), arrays, bytes };
        piece.check_cells()?;
        Ok(piece)
    }

    /// Checks that corners are points of the piece, and that each cell has corners.
    fn check_cells(&self) -> Result<(), String> {
        let (corners, ends) = (
            self.raw::<i64>("connectivity", NumberType::I64)?,
            self.raw::<i64>("offsets", NumberType::I64)?,
        );
        let in_order = ends.first().is_none_or(|&end| end > 0) && ends.is_sorted();
        if !in_order || ends.last().map_or(0, |&end| end) != corners.len() as i64 {
            return Err("has wrong offsets to the corners of cells".into());
        }
        match corners.iter().find(|&&corner| corner < 0 || corner >= self.points as i64) {
            Some(corner) => {
                Err(format!("has a cell with point {corner}, but {} points", self.points))
            }
            None => Ok(()),
        }
    }

    /// Returns an array of 32-bit floats, all components of a point or cell together.
    ///
    /// # Errors
    /// The piece has no such array of this type.
    pub fn f32(&self, name: &str) -> Result<Vec<f32>, String> {
        self.typed(name, NumberType::F32)
    }

    /// Returns an array of 32-bit unsigned integers.
    ///
    /// # Errors
    /// See [`Self::f32`].
    pub fn u32(&self, name: &str) -> Result<Vec<u32>, String> {
        self.typed(name, NumberType::U32)
    }

    /// Returns an array of 64-bit integers.
    ///
    /// # Errors
    /// See [`Self::f32`].
    pub fn i64(&self, name: &str) -> Result<Vec<i64>, String> {
        self.typed(name, NumberType::I64)
    }

    /// Returns an array of bytes.
    ///
    /// # Errors
    /// See [`Self::f32`].
    pub fn u8(&self, name: &str) -> Result<Vec<u8>, String> {
        self.typed(name, NumberType::U8)
    }

    /// Returns an array of any type as f64.
    ///
    /// # Errors
    /// The piece has no such array.
    pub fn array(&self, name: &str) -> Result<Vec<f64>, String> {
        match self.arrays.get(name).map(|stored| stored.kind) {
            Some(NumberType::U32) => Ok(self.u32(name)?.into_iter().map(f64::from).collect()),
            Some(NumberType::I64) => Ok(self.i64(name)?.into_iter().map(|i| i as f64).collect()),
            Some(NumberType::U8) => Ok(self.u8(name)?.into_iter().map(f64::from).collect()),
            Some(NumberType::F32) | None => {
                Ok(self.f32(name)?.into_iter().map(f64::from).collect())
            }
        }
    }

    /// Returns the number of components of an array of 32-bit floats on cells; 0 if there is no
    /// such array, or no cell.
    pub fn components(&self, name: &str) -> usize {
        let bytes = self.arrays.get(name).map_or(0, |stored| stored.bytes.len());
        (bytes / size_of::<f32>()).checked_div(self.cells).unwrap_or(0)
    }

    /// Returns the names of all arrays with their types and bytes, in no particular order.
    pub fn stored(&self) -> impl Iterator<Item = (&str, NumberType, &[u8])> {
        self.arrays
            .iter()
            .map(|(name, stored)| (name.as_str(), stored.kind, &self.bytes[stored.bytes.clone()]))
    }

    fn typed<T: Pod>(&self, name: &str, kind: NumberType) -> Result<Vec<T>, String> {
        self.raw(name, kind).map_err(|why| format!("{}: {why}", self.path.display()))
    }

    fn raw<T: Pod>(&self, name: &str, kind: NumberType) -> Result<Vec<T>, String> {
        let there = self.arrays.get(name).filter(|stored| stored.kind == kind);
        let stored =
            there.ok_or_else(|| format!("has no array `{name}` of {}", kind.vtk_name()))?;
        Ok(bytemuck::pod_collect_to_vec(&self.bytes[stored.bytes.clone()]))
    }
}

/// Returns the required length of an array. The inner value is none if the length is not known:
/// for `connectivity`, and for arrays of later versions.
fn numbers_due(name: &str, points: usize, cells: usize) -> Option<Option<usize>> {
    let of = |arrays: &[Array], tuples: usize| {
        let array = arrays.iter().find(|a| a.name == name)?;
        Some(tuples.checked_mul(array.components))
    };
    let of_cells = ["offsets", "types"].contains(&name).then_some(Some(cells));
    of(&[vtu::POINTS, vtu::CONTACT_FORCE], points)
        .or(of(POINT_ARRAYS, points))
        .or(of(CELL_ARRAYS, cells))
        .or(of(&[vtu::DAMAGE], cells))
        .or(of_cells)
}

fn size_of_kind(kind: NumberType) -> usize {
    match kind {
        NumberType::F32 | NumberType::U32 => 4,
        NumberType::I64 => 8,
        NumberType::U8 => 1,
    }
}

/// Returns name and position of the array that `array` of the XML `head` declares. The position
/// is in the bytes after the XML.
fn stored(head: &str, array: &Node, bytes: &[u8]) -> Result<(String, StoredArray), String> {
    let unread = || format!("has an array that is damaged: {}", unread(head, array));
    let name = array.attribute("Name").ok_or_else(unread)?;
    let kinds = [NumberType::F32, NumberType::U32, NumberType::I64, NumberType::U8];
    let kind = kinds
        .into_iter()
        .find(|k| Some(k.vtk_name()) == array.attribute("type"))
        .ok_or_else(unread)?;
    let at = array.attribute("offset").and_then(|n| n.parse::<usize>().ok()).ok_or_else(unread)?;
    let torn = || format!("ends within array `{name}`: it is incomplete");
    let begin = at.checked_add(LENGTH).ok_or_else(unread)?;
    let length = bytes.get(at..begin).ok_or_else(torn)?;
    let length = u64::from_ne_bytes(length.try_into().map_err(|_| torn())?);
    let end = usize::try_from(length).ok().and_then(|l| begin.checked_add(l)).ok_or_else(torn)?;
    match bytes.get(begin..end) {
        None => Err(torn()),
        Some(data) if data.len() % size_of_kind(kind) != 0 => Err(unread()),
        Some(_) => Ok((name.to_owned(), StoredArray { kind, bytes: begin..end })),
    }
}

fn text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Returns the XML of a file of VTK with this type of content; none if it is no such file, or
/// incomplete.
fn read_xml<'t>(text: &'t str, content: &str) -> Option<Document<'t>> {
    let file = Document::parse(text).ok()?;
    let root = file.root_element();
    let is_it = root.has_tag_name("VTKFile") && root.attribute("type") == Some(content);
    is_it.then_some(file)
}

/// Returns a message that quotes a tag that cannot be read.
fn unread(text: &str, tag: &Node) -> String {
    format!("cannot read `{}`", &text[tag.range()])
}

/// Returns the path of a file that is named relative to another one. Only files in its folder or
/// below are allowed.
fn same_folder(file: &Path, name: &str) -> Option<PathBuf> {
    let inside = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
    (inside && !name.is_empty()).then(|| file.with_file_name("").join(name))
}

/// Returns the name of the first worker's piece in a step's folder, then those of the other
/// workers, up to the first that is missing.
pub fn pieces_of_folder(step: &Path) -> Vec<PathBuf> {
    (0..)
        .map(|worker| step.join(vtu::piece_name(worker)))
        .take_while(|path| path.is_file())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::fields::FieldSeries;
    use crumple_proto::mesh::Shape;
    use crumple_worker::vtu::Cells;
    use std::fs;

    fn write_triangle(path: &Path) {
        let mut cells = Cells::default();
        cells.push(Shape::Tri3, &[0, 1, 2]);
        let zero = vec![[0.0_f32; 3]; 3];
        vtu::FieldPiece {
            time: 0.125,
            points: &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]],
            point_arrays: &[
                vtu::DISPLACEMENT.with(&zero),
                vtu::VELOCITY.with(&zero),
                vtu::ROTATIONAL_VELOCITY.with(&zero),
                vtu::NODE_ID.with(&vec![4_i64, 5, 6]),
            ],
            cells: &cells,
            cell_arrays: &[
                vtu::PLASTIC_STRAIN.with(&vec![0.5_f32]),
                vtu::VON_MISES.with(&vec![0.25_f32]),
                vtu::STRESS.with(&vec![[1.0, 2.0, 3.0, 4.0, 5.0, 6.0_f32]]),
                vtu::THICKNESS.with(&vec![2.0_f32]),
                vtu::PART.with(&vec![7_u32]),
                vtu::WORKER.with(&vec![0_u32]),
                vtu::CLASS.with(&vec![vtu::INTERFACE]),
                vtu::ELEMENT_ID.with(&vec![9_i64]),
            ],
        }
        .write(path)
        .unwrap();
    }

    #[test]
    fn a_series_is_read_back_as_it_was_written() {
        let dir = tempfile::tempdir().unwrap();
        let mut series = FieldSeries::new(dir.path(), Default::default());
        for (index, time) in [(0, 0.0), (3, 0.125)] {
            write_triangle(&dir.path().join(vtu::step_folder(index)).join(vtu::piece_name(0)));
            series.add(index, time, 1).unwrap();
        }
        let steps = steps(&dir.path().join(crate::results::fields::COLLECTION)).unwrap();
        assert_eq!(steps.iter().map(|s| s.time).collect::<Vec<_>>(), [0.0, 0.125]);
        let files = pieces(&steps[1].file).unwrap();
        assert_eq!(files, pieces_of_folder(&dir.path().join(vtu::step_folder(3))));
        let piece = PieceArrays::read(&files[0]).unwrap();
        assert_eq!((piece.time, piece.points, piece.cells), (0.125, 3, 1));
        assert_eq!(piece.f32("Points").unwrap()[6..], [0.0, 1.0, 0.5]);
        assert_eq!(piece.i64("node_id").unwrap(), [4, 5, 6]);
        assert_eq!(piece.u32("part").unwrap(), [7]);
        assert_eq!(piece.u8("class").unwrap(), [vtu::INTERFACE]);
        assert_eq!(piece.array("stress").unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert!(piece.u32("class").unwrap_err().ends_with("has no array `class` of UInt32"));
    }

    /// A file that is cut anywhere, or that has any one byte of its head changed, is either read
    /// completely or rejected with its name, without a panic.
    #[test]
    fn damage_is_reported_with_the_name_of_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("piece_000.vtu");
        write_triangle(&path);
        let whole = fs::read(&path).unwrap();
        let end = whole.windows(17).rposition(|w| w == b"\n</AppendedData>\n").unwrap();
        for length in 0..end {
            let error = PieceArrays::parse(&path, whole[..length].to_vec()).err();
            assert!(error.is_some(), "cut at {length} of {end}");
        }
        for place in 0..end {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x15;
            let _ = PieceArrays::parse(&path, damaged); // another valid number may be read
        }
        fs::write(&path, &whole[..end - 1]).unwrap();
        let error = PieceArrays::read(&path).err().unwrap();
        assert!(
            error.ends_with("piece_000.vtu: ends within array `element_id`: it is incomplete"),
            "{error}"
        );
        let error = PieceArrays::read(&dir.path().join("none.vtu")).err().unwrap();
        assert!(error.contains("none.vtu: "), "{error}");
    }

    #[test]
    fn names_that_lead_out_of_the_folder_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("fields.pvtu");
        for name in ["../secret.vtu", "/etc/passwd", ""] {
            let text = format!(
                "<VTKFile type=\"PUnstructuredGrid\">\n<Piece Source=\"{name}\"/>\n</VTKFile>\n"
            );
            fs::write(&path, text).unwrap();
            assert!(pieces(&path).unwrap_err().contains("cannot read `<Piece"), "{name}");
        }
    }
}
