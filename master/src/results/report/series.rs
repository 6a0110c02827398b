//! The field files of a run, joined over workers and times. Every node and element has one index;
//! its data are stored for each time.

use crate::results::field_file::{self, FieldStep, PieceArrays};
use crumple_proto::mesh::MAX_CORNERS;
use crumple_worker::vtu::{self, Array};
use nalgebra::Matrix3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A scalar per element or per node that the page can show.
pub struct Scalar {
    /// Its array in the field files.
    pub array: &'static Array,
    /// Its title on the page.
    pub title: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
    /// Its value, from the components of the array.
    of: fn(&[f32]) -> f32,
    /// True if 4096 steps are enough, which compress better than 65535.
    coarse: bool,
}

impl Scalar {
    /// Returns the step of its integers.
    pub fn unit(&self) -> f32 {
        if self.coarse { 16.0 } else { 1.0 }
    }

    /// Returns its values.
    ///
    /// # Errors
    /// The piece lacks the array.
    fn values(&self, piece: &PieceArrays) -> Result<Vec<f32>, String> {
        let components = piece.f32(self.array.name)?;
        Ok(components.chunks_exact(self.array.components).map(self.of).collect())
    }
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
    /// Length per time.
    Velocity,
}

/// A scalar that is the only component of its array.
const fn plain(array: &'static Array, title: &'static str, dimension: Dimension) -> Scalar {
    Scalar { array, title, dimension, of: |c| c[0], coarse: false }
}

/// A scalar from several components of an array.
const fn derived(
    array: &'static Array,
    title: &'static str,
    dimension: Dimension,
    of: fn(&[f32]) -> f32,
) -> Scalar {
    Scalar { array, title, dimension, of, coarse: true }
}

/// Scalars per element, in the order of the page.
pub const SCALARS: [Scalar; 6] = [
    plain(&vtu::PLASTIC_STRAIN, "plastic strain", Dimension::None),
    plain(&vtu::VON_MISES, "von Mises stress", Dimension::Stress),
    plain(&vtu::THICKNESS, "thickness", Dimension::Length),
    derived(&vtu::STRESS, "pressure", Dimension::Stress, pressure),
    derived(&vtu::STRESS, "largest principal stress", Dimension::Stress, largest_principal),
    derived(&vtu::STRESS, "triaxiality", Dimension::None, triaxiality),
];

/// Scalars per node, in the order of the page.
pub const NODE_SCALARS: [Scalar; 1] =
    [derived(&vtu::VELOCITY, "velocity", Dimension::Velocity, |v| {
        v.iter().map(|c| c * c).sum::<f32>().sqrt()
    })];

/// Returns minus the mean of the normal components of a stress xx, yy, zz, xy, yz, zx.
fn pressure(s: &[f32]) -> f32 {
    -(s[0] + s[1] + s[2]) / 3.0
}

/// Returns the largest principal stress.
fn largest_principal(s: &[f32]) -> f32 {
    if s.iter().any(|c| !c.is_finite()) {
        return f32::NAN;
    }
    let s = [0, 1, 2, 3, 4, 5].map(|i| f64::from(s[i]));
    Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).symmetric_eigenvalues().max()
        as f32
}

/// Returns the mean stress over the von Mises stress, both of the same point; none without stress.
fn triaxiality(s: &[f32]) -> f32 {
    let p = pressure(s);
    let normal: f32 = s[..3].iter().map(|c| (c + p).powi(2)).sum();
    let shear: f32 = s[3..6].iter().map(|c| c * c).sum();
    let von_mises = (1.5 * normal + 3.0 * shear).sqrt();
    if von_mises > LEAST_MISES * p.abs() { -p / von_mises } else { f32::NAN }
}

/// Von Mises stress over pressure below which the stress is hydrostatic to round-off.
const LEAST_MISES: f32 = 1e-4;

/// Shape of an element, from its VTK cell type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellShape {
    /// One corner.
    Point,
    /// Two corners.
    Line,
    /// Three corners.
    Triangle,
    /// Four corners.
    Quad,
    /// Eight corners: those of a face, then those opposite.
    Hexahedron,
    /// Four corners of a solid.
    Tetrahedron,
    /// Six corners: those of a triangle, then those opposite.
    Wedge,
    /// Four corners of a solid, then the nodes on its edges.
    QuadraticTetrahedron,
}

impl CellShape {
    /// Returns the number of corners.
    pub fn corners(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Quad => 4,
            Self::Hexahedron => 8,
            Self::Tetrahedron => 4,
            Self::Wedge => 6,
            Self::QuadraticTetrahedron => 10,
        }
    }

    fn of_vtk(number: u8, corners: usize) -> Option<Self> {
        match (number, corners) {
            (1, 1) => Some(Self::Point),
            (3, 2) => Some(Self::Line),
            (5, 3) => Some(Self::Triangle),
            (9, 4) => Some(Self::Quad),
            (12, 8) => Some(Self::Hexahedron),
            (10, 4) => Some(Self::Tetrahedron),
            (13, 6) => Some(Self::Wedge),
            (24, 10) => Some(Self::QuadraticTetrahedron),
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
    pub corners: [u32; MAX_CORNERS],
    /// Id of its part.
    pub part: u32,
    /// Id.
    pub id: u64,
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
    /// A column for each of [`NODE_SCALARS`].
    pub node_scalars: [Vec<f32>; NODE_SCALARS.len()],
    /// Contact forces on the nodes; empty if the run did not write them [force].
    pub contact_force: Vec<[f32; 3]>,
}

/// All times.
#[derive(Debug, Default)]
pub struct MeshSeries {
    /// Elements by index.
    pub elements: Vec<SeriesElement>,
    /// Ids of the nodes by index.
    pub node_ids: Vec<u64>,
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
            let (nodes, elements) = (s.node_ids.len(), s.elements.len());
            let each = (3 + NODE_SCALARS.len()) * nodes + (SCALARS.len() + 1) * elements;
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
        let node_scalars: Vec<_> =
            NODE_SCALARS.iter().map(|s| s.values(piece)).collect::<Result<_, _>>()?;
        let forces = piece.f32(vtu::CONTACT_FORCE.name).unwrap_or_default(); // on request
        let ids = piece.i64(vtu::NODE_ID.name)?;
        for (at, (id, x)) in ids.iter().zip(points.chunks_exact(3)).enumerate() {
            let next = self.node_of.len() as u32;
            let node = *self.node_of.entry(*id).or_insert(next);
            if node == next {
                self.series.node_ids.push(*id as u64);
            }
            put(&mut frame.position, node, [x[0], x[1], x[2]], [f32::NAN; 3]);
            for (column, values) in frame.node_scalars.iter_mut().zip(&node_scalars) {
                put(column, node, values[at], f32::NAN);
            }
            if let Some(&[x, y, z]) = forces.get(3 * at..3 * at + 3) {
                put(&mut frame.contact_force, node, [x, y, z], [0.0; 3]);
            }
            nodes.push(node);
        }
        let (corners, ends) = (piece.i64("connectivity")?, piece.i64("offsets")?);
        let (kinds, ids_of_cells) = (piece.u8("types")?, piece.i64(vtu::ELEMENT_ID.name)?);
        let (parts, classes) = (piece.u32(vtu::PART.name)?, piece.u8(vtu::CLASS.name)?);
        let workers = piece.u32(vtu::WORKER.name)?;
        let scalars: Vec<_> = SCALARS.iter().map(|s| s.values(piece)).collect::<Result<_, _>>()?;
        let mut begin = 0;
        for cell in 0..piece.cells {
            let of_cell = &corners[begin..ends[cell] as usize];
            begin = ends[cell] as usize;
            let Some(shape) = CellShape::of_vtk(kinds[cell], of_cell.len()) else {
                self.series.unknown_shapes += 1;
                continue;
            };
            let next = self.series.elements.len() as u32;
            let element = *self.element_of.entry(ids_of_cells[cell]).or_insert(next);
            if element == next {
                let mut numbers = [0; MAX_CORNERS];
                numbers
                    .iter_mut()
                    .zip(of_cell)
                    .for_each(|(n, &corner)| *n = nodes[corner as usize]);
                self.series.elements.push(SeriesElement {
                    shape,
                    corners: numbers,
                    part: parts[cell],
                    id: ids_of_cells[cell] as u64,
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

    /// Uniaxial tension of 3 along a turned axis, and the same with a pressure of 2.
    #[test]
    fn invariants_of_a_stress() {
        let n = [0.6f32, 0.0, 0.8];
        let uniaxial = [n[0] * n[0], 0.0, n[2] * n[2], 0.0, 0.0, n[2] * n[0]].map(|c| 3.0 * c);
        assert!((pressure(&uniaxial) + 1.0).abs() < 1e-6);
        assert!((largest_principal(&uniaxial) - 3.0).abs() < 1e-6);
        assert!((triaxiality(&uniaxial) - 1.0 / 3.0).abs() < 1e-6);
        let mut pressed = uniaxial;
        pressed[..3].iter_mut().for_each(|c| *c -= 2.0);
        assert!((pressure(&pressed) - 1.0).abs() < 1e-6);
        assert!((largest_principal(&pressed) - 1.0).abs() < 1e-6);
        assert!((triaxiality(&pressed) + 1.0 / 3.0).abs() < 1e-6);
        assert!(
            triaxiality(&[0.0; 6]).is_nan()
                && triaxiality(&[-1.0, -1.0, -1.0, 0., 0., 0.]).is_nan()
        );
        assert!(largest_principal(&[f32::NAN; 6]).is_nan());
    }

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
