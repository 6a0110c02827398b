//! One step of all workers as one mesh: nodes and elements once, by ascending ids.

use crate::results::field_file::{FieldStep, PieceArrays, pieces};
use crumple_worker::vtu::{self, Array, CELL_ARRAYS, NumberType, POINT_ARRAYS};

/// Numbers of one array, all components of a point or cell together.
#[derive(Debug, PartialEq)]
pub enum SnapshotArray {
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 32-bit unsigned integers.
    U32(Vec<u32>),
    /// 64-bit integers.
    I64(Vec<i64>),
    /// Bytes.
    U8(Vec<u8>),
}

/// The cells, by the indices of their points.
#[derive(Debug, Default, PartialEq)]
pub struct Topology {
    /// Ids of the points. Another set of points is another topology.
    pub nodes: Vec<i64>,
    /// Corners of all cells.
    pub connectivity: Vec<i64>,
    /// Start of the corners of each cell, and the end of the last.
    pub offsets: Vec<i64>,
    /// VTK types of the cells.
    pub types: Vec<u8>,
}

/// A step.
#[derive(Debug)]
pub struct Snapshot {
    /// Simulated time [time].
    pub time: f64,
    /// Current coordinates, three per point [length].
    pub points: Vec<f32>,
    /// Cells.
    pub topology: Topology,
    /// One column for each of [`POINT_ARRAYS`].
    pub point_arrays: Vec<SnapshotArray>,
    /// One column for each of [`CELL_ARRAYS`].
    pub cell_arrays: Vec<SnapshotArray>,
}

/// Position of an entity: piece and index in it.
type EntityPosition = (usize, usize);

impl Snapshot {
    /// Joins the pieces of a step.
    ///
    /// # Errors
    /// A piece cannot be read.
    pub fn read(step: &FieldStep) -> Result<Self, String> {
        let pieces: Vec<PieceArrays> =
            pieces(&step.file)?.iter().map(|p| PieceArrays::read(p)).collect::<Result<_, _>>()?;
        let node_ids: Vec<Vec<i64>> =
            pieces.iter().map(|p| p.i64(vtu::NODE_ID.name)).collect::<Result<_, _>>()?;
        let element_ids: Vec<Vec<i64>> =
            pieces.iter().map(|p| p.i64(vtu::ELEMENT_ID.name)).collect::<Result<_, _>>()?;
        let (nodes, node_sources) = ascending(&node_ids);
        let (_, cell_sources) = ascending(&element_ids);
        let mut cells = Vec::new();
        for piece in &pieces {
            cells.push((piece.i64("connectivity")?, piece.i64("offsets")?, piece.u8("types")?));
        }
        let mut topology = Topology { offsets: vec![0], ..Topology::default() };
        for &(piece, cell) in &cell_sources {
            let (corners, ends, types) = &cells[piece];
            let begin = if cell == 0 { 0 } else { ends[cell - 1] as usize };
            for &corner in &corners[begin..ends[cell] as usize] {
                let id = node_ids[piece][corner as usize];
                topology.connectivity.push(nodes.partition_point(|&n| n < id) as i64);
            }
            topology.offsets.push(topology.connectivity.len() as i64);
            topology.types.push(types[cell]);
        }
        topology.nodes = nodes;
        let of = |arrays: &[Array], sources: &[EntityPosition]| {
            arrays
                .iter()
                .map(|array| column(&pieces, array, sources))
                .collect::<Result<Vec<_>, _>>()
        };
        Ok(Self {
            time: step.time,
            points: gathered(&pieces, vtu::POINTS.components, &node_sources, |p| {
                p.f32(vtu::POINTS.name)
            })?,
            topology,
            point_arrays: of(POINT_ARRAYS, &node_sources)?,
            cell_arrays: of(CELL_ARRAYS, &cell_sources)?,
        })
    }
}

/// Returns the ids of all pieces in ascending order, each once, and their positions.
fn ascending(ids: &[Vec<i64>]) -> (Vec<i64>, Vec<EntityPosition>) {
    let of = |(piece, ids): (usize, &Vec<i64>)| {
        ids.iter().enumerate().map(|(i, &id)| (id, (piece, i))).collect::<Vec<_>>()
    };
    let mut all: Vec<(i64, EntityPosition)> = ids.iter().enumerate().flat_map(of).collect();
    all.sort_unstable();
    all.dedup_by_key(|entry| entry.0);
    all.into_iter().unzip()
}

fn column(
    pieces: &[PieceArrays],
    array: &Array,
    sources: &[EntityPosition],
) -> Result<SnapshotArray, String> {
    let (name, width) = (array.name, array.components);
    Ok(match array.kind {
        NumberType::F32 => SnapshotArray::F32(gathered(pieces, width, sources, |p| p.f32(name))?),
        NumberType::U32 => SnapshotArray::U32(gathered(pieces, width, sources, |p| p.u32(name))?),
        NumberType::I64 => SnapshotArray::I64(gathered(pieces, width, sources, |p| p.i64(name))?),
        NumberType::U8 => SnapshotArray::U8(gathered(pieces, width, sources, |p| p.u8(name))?),
    })
}

fn gathered<T: Copy>(
    pieces: &[PieceArrays],
    width: usize,
    sources: &[EntityPosition],
    read: impl Fn(&PieceArrays) -> Result<Vec<T>, String>,
) -> Result<Vec<T>, String> {
    let columns: Vec<Vec<T>> = pieces.iter().map(read).collect::<Result<_, _>>()?;
    Ok(sources
        .iter()
        .flat_map(|&(piece, i)| &columns[piece][width * i..width * (i + 1)])
        .copied()
        .collect())
}
