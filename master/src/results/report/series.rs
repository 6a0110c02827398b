//! The field files of a run, joined over workers and times. Every node and element has one index;
//! its data are stored for each time.

use crate::results::field_file::{self, FieldStep, PieceArrays};
use crumple_worker::vtu::{self, Array};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A scalar per element that the page can show.
pub struct Scalar {
    /// Its array in the field files.
    pub array: &'static Array,
    /// Its title on the page.
    pub title: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
}

/// Dimension of a scalar. The page shows it in the units of the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Dimensionless.
    None,
    /// Length.
    Length,
    /// Force per area.
    Stress,
}

/// Scalars per element, in the order of the page.
pub const SCALARS: [Scalar; 3] = [
    Scalar { array: &vtu::PLASTIC_STRAIN, title: "plastic strain", dimension: Dimension::None },
    Scalar { array: &vtu::VON_MISES, title: "von Mises stress", dimension: Dimension::Stress },
    Scalar { array: &vtu::THICKNESS, title: "thickness", dimension: Dimension::Length },
];

/// Shape of an element, from its VTK cell type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellShape {
    /// Two corners.
    Line,
    /// Three corners.
    Triangle,
    /// Four corners.
    Quad,
    /// Eight corners: those of a face, then those opposite.
    Hexahedron,
}

impl CellShape {
    /// Returns the number of corners.
    pub fn corners(self) -> usize {
        match self {
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Quad => 4,
            Self::Hexahedron => 8,
        }
    }

    fn of_vtk(number: u8, corners: usize) -> Option<Self> {
        match (number, corners) {
            (3, 2) => Some(Self::Line),
            (5, 3) => Some(Self::Triangle),
            (9, 4) => Some(Self::Quad),
            (12, 8) => Some(Self::Hexahedron),
            _ => None,
        }
    }
}

/// Constant data of an element.
#[derive(Clone, Copy, Debug)]
pub struct SeriesElement {
    /// Shape.
    pub shape: CellShape,
    /// Indices of its nodes, as many as the shape has corners.
    pub corners: [u32; 8],
    /// Id of its part.
    pub part: u32,
}

/// Code of an absent element in [`FieldFrame::state`]. The code of a present one is its class plus
/// one.
pub const ABSENT: u8 = 0;

/// Data of one time. Columns are shorter if nodes and elements appear later in the series.
#[derive(Clone, Debug, Default)]
pub struct FieldFrame {
    /// Simulated time [time].
    pub time: f64,
    /// Coordinates, not finite for an absent node [length].
    pub position: Vec<[f32; 3]>,
    /// [`ABSENT`], or the class plus one.
    pub state: Vec<u8>,
    /// Worker that has the element.
    pub worker: Vec<u16>,
    /// A column for each of [`SCALARS`].
    pub scalars: [Vec<f32>; SCALARS.len()],
}

/// All times.
#[derive(Debug, Default)]
pub struct MeshSeries {
    /// Elements by index.
    pub elements: Vec<SeriesElement>,
    /// Number of nodes.
    pub nodes: usize,
    /// Times in their order.
    pub frames: Vec<FieldFrame>,
    /// Number of times that the run wrote. `frames` may be a selection of them.
    pub written: usize,
    /// Number of elements of unknown shapes.
    pub unknown_shapes: usize,
}

/// Maximum number of values before compression: several times the content of a page, and small
/// enough for memory.
const MOST_NUMBERS: usize = 40_000_000;

/// Reads the series that a collection names. Steps that cannot be read are omitted and listed in
/// `problems`. If there are more times than `most`, or too many for memory, they are thinned
/// evenly.
pub fn read(
    collection: &Path,
    most: usize,
    problems: &mut Vec<String>,
    say: &mut dyn FnMut(&str),
) -> MeshSeries {
    let mut reader = SeriesReader::default();
    let steps = field_file::steps(collection).unwrap_or_else(|why| {
        problems.push(why);
        Vec::new()
    });
    reader.series.written = steps.len();
    let mut chosen = spread(steps.len(), most);
    let mut at = 0;
    while let Some(&step) = chosen.get(at) {
        say(&format!("reading time {} of {}", at + 1, chosen.len()));
        match reader.frame(&steps[step]) {
            Ok(frame) => reader.series.frames.push(frame),
            Err(whys) => problems.extend(whys),
        }
        if at == 0 {
            // All times have about the size of the first.
            let s = &reader.series;
            let each = 3 * s.nodes + (SCALARS.len() + 1) * s.elements.len();
            chosen = spread(steps.len(), most.min(MOST_NUMBERS / each.max(1)).max(2));
        }
        at += 1;
    }
    reader.series
}

/// Reads the state of one time from its pieces.
///
/// # Errors
/// A piece cannot be read.
pub fn read_state(files: &[PathBuf], time: f64) -> Result<MeshSeries, String> {
    let mut reader = SeriesReader::default();
    let frame = reader.joined(files, time).map_err(|whys| whys.join("; "))?;
    reader.series.frames.push(frame);
    reader.series.written = 1;
    Ok(reader.series)
}

/// Returns `most` of the numbers below `count`, evenly spaced, with the first and the last; all
/// of them if they are no more.
pub fn spread(count: usize, most: usize) -> Vec<usize> {
    match most {
        _ if count <= most => (0..count).collect(),
        0 | 1 => vec![count - 1],
        _ => (0..most).map(|i| (2 * i * (count - 1) + most - 1) / (2 * (most - 1))).collect(),
    }
}

/// A series under construction: indices of nodes and elements by id.
#[derive(Default)]
struct SeriesReader {
    series: MeshSeries,
    node_of: HashMap<i64, u32>,
    element_of: HashMap<i64, u32>,
}

impl SeriesReader {
    /// Joins the pieces of a step. The step is rejected if one of them cannot be read.
    fn frame(&mut self, step: &FieldStep) -> Result<FieldFrame, Vec<String>> {
        let files = field_file::pieces(&step.file).map_err(|why| vec![why])?;
        self.joined(&files, step.time)
    }

    fn joined(&mut self, files: &[PathBuf], time: f64) -> Result<FieldFrame, Vec<String>> {
        let (pieces, whys): (Vec<_>, Vec<_>) =
            files.iter().map(|file| PieceArrays::read(file)).partition(Result::is_ok);
        let whys: Vec<String> = whys.into_iter().filter_map(Result::err).collect();
        if !whys.is_empty() {
            return Err(whys);
        }
        let mut frame = FieldFrame { time, ..FieldFrame::default() };
        for piece in pieces.into_iter().flatten() {
            self.join(&piece, &mut frame).map_err(|why| vec![why])?;
        }
        Ok(frame)
    }

    fn join(&mut self, piece: &PieceArrays, frame: &mut FieldFrame) -> Result<(), String> {
        let points = piece.f32(vtu::POINTS.name)?;
        let mut nodes = Vec::with_capacity(piece.points);
        for (id, x) in piece.i64(vtu::NODE_ID.name)?.iter().zip(points.chunks_exact(3)) {
            let next = self.node_of.len() as u32;
            let node = *self.node_of.entry(*id).or_insert(next);
            put(&mut frame.position, node, [x[0], x[1], x[2]], [f32::NAN; 3]);
            nodes.push(node);
        }
        self.series.nodes = self.node_of.len();
        let (corners, ends) = (piece.i64("connectivity")?, piece.i64("offsets")?);
        let (kinds, ids) = (piece.u8("types")?, piece.i64(vtu::ELEMENT_ID.name)?);
        let (parts, classes) = (piece.u32(vtu::PART.name)?, piece.u8(vtu::CLASS.name)?);
        let workers = piece.u32(vtu::WORKER.name)?;
        let scalars: Vec<_> =
            SCALARS.iter().map(|s| piece.f32(s.array.name)).collect::<Result<_, _>>()?;
        let mut begin = 0;
        for cell in 0..piece.cells {
            let of_cell = &corners[begin..ends[cell] as usize];
            begin = ends[cell] as usize;
            let Some(shape) = CellShape::of_vtk(kinds[cell], of_cell.len()) else {
                self.series.unknown_shapes += 1;
                continue;
            };
            let next = self.series.elements.len() as u32;
            let element = *self.element_of.entry(ids[cell]).or_insert(next);
            if element == next {
                let mut numbers = [0; 8];
                numbers
                    .iter_mut()
                    .zip(of_cell)
                    .for_each(|(n, &corner)| *n = nodes[corner as usize]);
                self.series.elements.push(SeriesElement {
                    shape,
                    corners: numbers,
                    part: parts[cell],
                });
            }
            put(&mut frame.state, element, classes[cell].saturating_add(1), ABSENT);
            put(&mut frame.worker, element, workers[cell].try_into().unwrap_or(u16::MAX), 0);
            for (column, values) in frame.scalars.iter_mut().zip(&scalars) {
                put(column, element, values[cell], f32::NAN);
            }
        }
        Ok(())
    }
}

/// Stores a value in a column, which is extended if necessary.
fn put<T: Clone>(column: &mut Vec<T>, place: u32, value: T, none: T) {
    let place = place as usize;
    if column.len() <= place {
        column.resize(place + 1, none);
    }
    column[place] = value;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_spread_evenly_with_the_first_and_the_last() {
        assert_eq!(spread(3, 5), [0, 1, 2]);
        assert_eq!(spread(11, 3), [0, 5, 10]);
        assert_eq!(spread(10, 4), [0, 3, 6, 9]);
        assert_eq!(spread(7, 1), [6]);
        for count in 2..60 {
            for most in 2..count {
                let chosen = spread(count, most);
                assert_eq!((chosen.len(), chosen[0], chosen[most - 1]), (most, 0, count - 1));
                assert!(chosen.windows(2).all(|w| w[0] < w[1]), "{chosen:?}");
            }
        }
    }
}
