//! Encodes the scene for the page: 16-bit integers, as differences from the previous time,
//! compressed.
//!
//! Order of the file: corners of the faces (u32, each minus the one before); their two owners
//! (u32, plus one, zero for none); the ids of elements and nodes (lower words, then upper words, as
//! the corners); the parts of the elements (u16, index into the list of the description). Then for
//! each time: states of the elements (u8), workers (u16), the scalars (u16), the scalars of the
//! nodes, x, y and z of the nodes (u16); the nodes with a contact force (u32, each minus the one
//! before) and the components of their forces (bits of f32, likewise). Each column of u8 and u16 is
//! the difference from the same column at the previous time, in zigzag coding (0, -1, 1, -2, ...),
//! the lowest bytes of all numbers first, so that small changes give mostly zeros. `decode.js` is
//! the decoder.

use super::scene::PageScene;
use super::series::{ABSENT, FieldFrame, MeshSeries, NODE_SCALARS, SCALARS};
use super::surface::NO_ELEMENT;
use flate2::{Compression, write::ZlibEncoder};
use serde::Serialize;
use std::io::Write;

/// Code of a scalar that is not a number.
const NO_VALUE: u16 = u16::MAX;
/// Largest integer of a scalar.
const MOST_VALUE: f32 = (u16::MAX - 1) as f32;

/// Data that the page needs to decode the bytes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Number of faces.
    pub faces: usize,
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Ids of the parts.
    pub parts: Vec<u32>,
    /// Minimum and maximum of each scalar over all times; none if it has no value.
    pub ranges: Vec<Option<[f32; 2]>>,
    /// The same for the scalars of nodes.
    pub node_ranges: Vec<Option<[f32; 2]>>,
    /// Times.
    pub frames: Vec<Quantizer>,
    /// Number of nodes with a contact force at each time; empty if the run did not write them.
    pub forces: Vec<usize>,
    /// Number of elements that are hidden at some time because a node has no finite coordinates.
    pub nowhere: usize,
}

/// Mapping between integers and the coordinates of one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantizer {
    /// Simulated time [time].
    pub time: f64,
    /// Coordinates of the integer 0 [length].
    pub origin: [f64; 3],
    /// Length of one unit [length].
    pub unit: f64,
}

impl Quantizer {
    /// Returns the 16-bit grid around the coordinates. Its unit is a power of two and its origin
    /// a multiple of the unit, so that the grid is the same at most times and differences are
    /// small.
    fn around(time: f64, positions: impl Iterator<Item = [f32; 3]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for x in positions.filter(|x| x.iter().all(|c| c.is_finite())) {
            for c in 0..3 {
                (low[c], high[c]) = (low[c].min(f64::from(x[c])), high[c].max(f64::from(x[c])));
            }
        }
        let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
        // One integer at each end is reserved for rounding.
        let unit =
            if size > 0.0 { (size / f64::from(u16::MAX - 2)).log2().ceil().exp2() } else { 1.0 };
        let origin = low.map(|c| if c.is_finite() { (c / unit).floor() * unit } else { 0.0 });
        Self { time, origin, unit }
    }

    fn number(&self, x: f32, c: usize) -> u16 {
        ((f64::from(x) - self.origin[c]) / self.unit).round() as u16 // values outside are clamped
    }
}

/// Encodes a scene; returns the description and the bytes.
pub fn encode(series: &MeshSeries, scene: &PageScene) -> (Description, Vec<u8>) {
    let mut out = PackedColumns::new();
    out.chain(scene.faces.iter().flat_map(|f| f.corners));
    for side in 0..2 {
        let owner = |o: u32| if o == NO_ELEMENT { 0 } else { o + 1 };
        out.chain(scene.faces.iter().map(|f| owner(f.owners[side])));
    }
    let ids_of_elements = scene.elements.iter().map(|&e| series.elements[e as usize].id);
    let ids_of_nodes = scene.nodes.iter().map(|&n| series.node_ids[n as usize]);
    out.ids(&ids_of_elements.collect::<Vec<_>>());
    out.ids(&ids_of_nodes.collect::<Vec<_>>());
    let mut parts: Vec<u32> =
        scene.elements.iter().map(|&e| series.elements[e as usize].part).collect();
    let of_element = parts.clone();
    parts.sort_unstable();
    parts.dedup();
    out.u16(of_element.iter().map(|p| parts.partition_point(|a| a < p) as u16));

    let of_elements = |s: usize| range(series, scene, &scene.elements, |frame| &frame.scalars[s]);
    let of_nodes = |s: usize| range(series, scene, &scene.nodes, |frame| &frame.node_scalars[s]);
    let ranges: Vec<_> = (0..SCALARS.len()).map(of_elements).collect();
    let node_ranges: Vec<_> = (0..NODE_SCALARS.len()).map(of_nodes).collect();
    let both = [&ranges[..], &node_ranges[..]];
    let mut before = EncodedColumns::new(scene);
    let mut hidden = vec![false; scene.elements.len()];
    let (mut grids, mut forces) = (Vec::new(), Vec::new());
    let has_forces = scene.frames.iter().any(|&k| !series.frames[k].contact_force.is_empty());
    for &k in &scene.frames {
        let (columns, grid) = EncodedColumns::at_time(series, scene, k, both, &before, &mut hidden);
        out.bytes(columns.state.iter().zip(&before.state).map(|(a, b)| a.wrapping_sub(*b)));
        for (now, then) in columns.numbers.iter().zip(&before.numbers) {
            out.u16(now.iter().zip(then).map(|(a, b)| zigzag16(a.wrapping_sub(*b))));
        }
        if has_forces {
            forces.push(pack_forces(&series.frames[k].contact_force, &scene.nodes, &mut out));
        }
        before = columns;
        grids.push(grid);
    }
    let description = Description {
        faces: scene.faces.len(),
        elements: scene.elements.len(),
        nodes: scene.nodes.len(),
        parts,
        ranges,
        node_ranges,
        frames: grids,
        forces,
        nowhere: hidden.iter().filter(|h| **h).count(),
    };
    (description, out.finish())
}

/// Adds the contact forces on these nodes of the series that are not zero; returns their number.
fn pack_forces(all: &[[f32; 3]], nodes: &[u32], out: &mut PackedColumns) -> usize {
    let force = |(place, &node): (u32, &u32)| {
        let force = all.get(node as usize).copied().unwrap_or_default();
        (force != [0.0; 3]).then_some((place, force))
    };
    let acting: Vec<(u32, [f32; 3])> = (0..).zip(nodes).filter_map(force).collect();
    out.chain(acting.iter().map(|a| a.0));
    (0..3).for_each(|c| out.chain(acting.iter().map(|a| a.1[c].to_bits())));
    acting.len()
}

/// Compression level. Level 9 saves half a per cent of the pictures of the brick wall and the
/// jeep frame, and takes two to three times as long.
const LEVEL: u32 = 6;

/// One time in integers.
struct EncodedColumns {
    state: Vec<u8>,
    /// Workers, scalars of elements, scalars of nodes, coordinates.
    numbers: [Vec<u16>; OF_ELEMENTS + NODE_SCALARS.len() + 3],
}

/// Number of columns with a number per element.
const OF_ELEMENTS: usize = 1 + SCALARS.len();

impl EncodedColumns {
    /// Creates the columns from which the first time is subtracted.
    fn new(scene: &PageScene) -> Self {
        let of_elements = || vec![0; scene.elements.len()];
        let column = |c| if c < OF_ELEMENTS { of_elements() } else { vec![0; scene.nodes.len()] };
        Self { state: vec![0; scene.elements.len()], numbers: std::array::from_fn(column) }
    }

    fn at_time(
        series: &MeshSeries,
        scene: &PageScene,
        k: usize,
        [ranges, node_ranges]: [&[Option<[f32; 2]>]; 2],
        before: &Self,
        hidden: &mut [bool],
    ) -> (Self, Quantizer) {
        let frame = &series.frames[k];
        let at = |node: u32| frame.position.get(node as usize).copied().unwrap_or([f32::NAN; 3]);
        let grid = Quantizer::around(frame.time, scene.nodes.iter().map(|&n| at(n)));
        let mut columns = Self::new(scene);
        for (i, &e) in scene.elements.iter().enumerate() {
            let e = e as usize;
            let there = frame.state.get(e).copied().unwrap_or(ABSENT);
            let element = &series.elements[e];
            let nowhere =
                element.corners[..element.shape.corners()].iter().any(|&n| !at(n)[0].is_finite());
            hidden[i] |= there != ABSENT && nowhere;
            columns.state[i] = if nowhere { ABSENT } else { there };
            columns.numbers[0][i] = frame.worker.get(e).copied().unwrap_or(0);
            for (s, range) in ranges.iter().enumerate() {
                columns.numbers[1 + s][i] = number(&frame.scalars[s], e, *range, SCALARS[s].unit());
            }
        }
        let first = OF_ELEMENTS + NODE_SCALARS.len();
        for (i, &node) in scene.nodes.iter().enumerate() {
            for (s, range) in node_ranges.iter().enumerate() {
                columns.numbers[OF_ELEMENTS + s][i] =
                    number(&frame.node_scalars[s], node as usize, *range, NODE_SCALARS[s].unit());
            }
            for (c, x) in at(node).into_iter().enumerate() {
                let number =
                    if x.is_finite() { grid.number(x, c) } else { before.numbers[first + c][i] };
                columns.numbers[first + c][i] = number;
            }
        }
        (columns, grid)
    }
}

/// Returns the integer of a value of a column, a multiple of `unit`.
fn number(column: &[f32], place: usize, range: Option<[f32; 2]>, unit: f32) -> u16 {
    match (column.get(place).filter(|v| v.is_finite()), range) {
        (Some(v), Some([low, high])) if high > low => {
            (((v - low) / (high - low) * MOST_VALUE / unit).round() * unit).min(MOST_VALUE) as u16
        }
        (Some(_), Some(_)) => 0,
        _ => NO_VALUE,
    }
}

/// Returns minimum and maximum of a column over the times of the scene, at these places.
fn range<'s>(
    series: &'s MeshSeries,
    scene: &PageScene,
    places: &[u32],
    column: impl Fn(&'s FieldFrame) -> &'s Vec<f32>,
) -> Option<[f32; 2]> {
    let mut range: Option<[f32; 2]> = None;
    for &k in &scene.frames {
        let values = column(&series.frames[k]);
        for &v in places.iter().filter_map(|&p| values.get(p as usize)).filter(|v| v.is_finite()) {
            range = Some(range.map_or([v; 2], |[a, b]| [a.min(v), b.max(v)]));
        }
    }
    range
}

fn zigzag16(difference: u16) -> u16 {
    let signed = difference as i16;
    ((signed << 1) ^ (signed >> 15)) as u16
}

fn zigzag32(difference: u32) -> u32 {
    let signed = difference as i32;
    ((signed << 1) ^ (signed >> 31)) as u32
}

/// Columns on their way to compression, which cannot fail because it writes to memory.
pub struct PackedColumns(ZlibEncoder<Vec<u8>>);

impl PackedColumns {
    /// Creates a file without columns.
    pub fn new() -> Self {
        Self(ZlibEncoder::new(Vec::new(), Compression::new(LEVEL)))
    }

    /// Adds a column whose numbers are stored as differences from the previous one.
    pub fn chain(&mut self, numbers: impl Iterator<Item = u32>) {
        let mut last = 0u32;
        self.u32(numbers.map(|n| zigzag32(n.wrapping_sub(std::mem::replace(&mut last, n)))));
    }

    fn ids(&mut self, ids: &[u64]) {
        self.chain(ids.iter().map(|id| *id as u32));
        self.chain(ids.iter().map(|id| (id >> 32) as u32));
    }

    fn bytes(&mut self, bytes: impl Iterator<Item = u8>) {
        let bytes: Vec<u8> = bytes.collect();
        let _ = self.0.write_all(&bytes);
    }

    fn u16(&mut self, numbers: impl Iterator<Item = u16>) {
        let numbers: Vec<u16> = numbers.collect();
        (0..2).for_each(|place| self.bytes(numbers.iter().map(|n| n.to_le_bytes()[place])));
    }

    fn u32(&mut self, numbers: impl Iterator<Item = u32>) {
        let numbers: Vec<u32> = numbers.collect();
        (0..4).for_each(|place| self.bytes(numbers.iter().map(|n| n.to_le_bytes()[place])));
    }

    /// Returns the bytes of all columns.
    pub fn finish(self) -> Vec<u8> {
        self.0.finish().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface::{faces, tests::row_of_cubes};
    use super::*;
    use std::io::Read;

    /// The decoded bytes, read as by `decode.js`.
    struct Unpacked {
        bytes: Vec<u8>,
        at: usize,
    }

    impl Unpacked {
        fn new(packed: &[u8]) -> Self {
            let mut bytes = Vec::new();
            flate2::read::ZlibDecoder::new(packed).read_to_end(&mut bytes).unwrap();
            Self { bytes, at: 0 }
        }

        fn column(&mut self, count: usize, width: usize) -> Vec<u32> {
            let planes = &self.bytes[self.at..self.at + width * count];
            self.at += width * count;
            (0..count)
                .map(|i| (0..width).map(|b| u32::from(planes[b * count + i]) << (8 * b)).sum())
                .collect()
        }

        fn difference(&mut self, count: usize, width: usize, before: &[u32]) -> Vec<u32> {
            let mask = if width == 4 { u32::MAX } else { 0xffff };
            let un = |z: u32| (z >> 1) ^ (z & 1).wrapping_neg();
            self.column(count, width)
                .iter()
                .zip(before)
                .map(|(z, b)| b.wrapping_add(un(*z)) & mask)
                .collect()
        }

        fn chain(&mut self, count: usize) -> Vec<u32> {
            let mut last = 0u32;
            let un = |z: u32| (z >> 1) ^ (z & 1).wrapping_neg();
            let next = |z: &u32| {
                last = last.wrapping_add(un(*z));
                last
            };
            self.column(count, 4).iter().map(next).collect()
        }
    }

    #[test]
    fn what_is_packed_comes_out_again_to_half_a_unit() {
        let mut series = row_of_cubes(4, &[1, 3, 0, 2]);
        series.frames[1].scalars[0][1] = f32::NAN;
        series.frames[1].contact_force = vec![[0.0; 3]; series.node_ids.len()];
        series.frames[1].contact_force[7] = [1.5, 0.0, -2.0];
        let scene = PageScene::new(&series, faces(&series));
        let (d, packed) = encode(&series, &scene);
        let mut read = Unpacked::new(&packed);
        let corners = read.chain(4 * d.faces);
        let owners = [read.chain(d.faces), read.chain(d.faces)];
        for (i, face) in scene.faces.iter().enumerate() {
            assert_eq!(corners[4 * i..4 * i + 4], face.corners);
            assert_eq!([owners[0][i], owners[1][i]], face.owners.map(|o| o.wrapping_add(1)));
        }
        for ids in [&series.elements.iter().map(|e| e.id).collect::<Vec<_>>(), &series.node_ids] {
            let (low, high) = (read.chain(ids.len()), read.chain(ids.len()));
            for (i, id) in ids.iter().enumerate() {
                assert_eq!(u64::from(low[i]) + (u64::from(high[i]) << 32), *id);
            }
        }
        assert_eq!(read.column(d.elements, 2), [0, 1, 0, 1]);
        assert_eq!((d.parts.clone(), d.nowhere), (vec![0, 1], 0));
        let coordinates = OF_ELEMENTS + NODE_SCALARS.len();
        let mut state = vec![0; d.elements];
        let mut numbers = vec![vec![0; d.elements]; 1 + SCALARS.len()];
        numbers.extend(vec![vec![0; d.nodes]; NODE_SCALARS.len() + 3]);
        for (k, grid) in d.frames.iter().enumerate() {
            let frame = &series.frames[k];
            let change = read.column(d.elements, 1);
            state.iter_mut().zip(change).for_each(|(s, c)| *s = (*s + c) & 0xff);
            assert_eq!(state, frame.state.iter().map(|s| u32::from(*s)).collect::<Vec<_>>());
            for column in &mut numbers {
                *column = read.difference(column.len(), 2, column);
            }
            assert_eq!(numbers[0], [0, 1, 2, 3]);
            for (s, range) in d.ranges.iter().enumerate() {
                let [low, high] = range.unwrap();
                for (e, &number) in numbers[1 + s].iter().enumerate() {
                    let value = frame.scalars[s][e];
                    let back = low + number as f32 / MOST_VALUE * (high - low);
                    assert_eq!(number == u32::from(NO_VALUE), value.is_nan());
                    assert!(
                        value.is_nan()
                            || (back - value).abs()
                                <= 0.51 * SCALARS[s].unit() / MOST_VALUE * (high - low)
                    );
                }
            }
            let [low, high] = d.node_ranges[0].unwrap();
            for (n, &number) in numbers[OF_ELEMENTS].iter().enumerate() {
                let back = low + number as f32 / MOST_VALUE * (high - low);
                let off = (back - frame.node_scalars[0][n]).abs();
                assert!(off <= 0.51 * NODE_SCALARS[0].unit() / MOST_VALUE * (high - low));
            }
            let nodes = read.chain(d.forces[k]);
            let force = [0, 1, 2].map(|_| read.chain(d.forces[k]));
            if k == 1 {
                assert_eq!(nodes, [7]);
                assert_eq!(force.map(|c| f32::from_bits(c[0])), [1.5, 0.0, -2.0]);
            }
            for (n, x) in frame.position.iter().enumerate() {
                for c in 0..3 {
                    let back = grid.origin[c] + f64::from(numbers[coordinates + c][n]) * grid.unit;
                    assert!((back - f64::from(x[c])).abs() <= 0.5 * grid.unit, "{back} {}", x[c]);
                }
            }
        }
        assert_eq!(read.at, read.bytes.len());
    }

    /// A grid has at most twice the unit that 16 bits need, and stays the same while the model
    /// only translates.
    #[test]
    fn a_travelling_model_keeps_its_grid() {
        let positions =
            |shift: f32| (0..100).map(move |i| [i as f32 + shift, 0.0, -3.0 * i as f32]);
        let (a, b) =
            (Quantizer::around(0.0, positions(0.0)), Quantizer::around(1.0, positions(5000.0)));
        assert_eq!(a.unit, b.unit);
        let least = 297.0 / 65535.0;
        assert!(a.unit >= least && a.unit <= 2.01 * least, "{a:?}");
        assert_eq!((a.number(1e9, 0), a.number(-1e9, 0)), (u16::MAX, 0));
        assert_eq!(
            Quantizer::around(0.0, [[f32::NAN; 3]].into_iter()),
            Quantizer { time: 0.0, origin: [0.0; 3], unit: 1.0 }
        );
    }

    #[test]
    fn an_element_with_a_node_that_is_nowhere_is_hidden_and_counted() {
        let mut series = row_of_cubes(3, &[1, 1, 1]);
        series.frames[1].position[0] = [f32::NAN; 3];
        let scene = PageScene::new(&series, faces(&series));
        let (d, _) = encode(&series, &scene);
        assert_eq!(d.nowhere, 1);
        assert!(d.frames[1].origin.iter().all(|c| c.is_finite()));
    }
}
