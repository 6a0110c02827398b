//! STL files, as text or binary: triangles of a surface. Corners with the same coordinates are one
//! node. Each solid of a text file is a rigid part; a binary file is one.

use super::cells::Cell;
use super::content::{FileNode, FilePlace};
use super::reading::{Fate, MeshReading};
use super::shortened;
use crate::input::deck::number;
use std::collections::HashMap;

/// Size of the header of a binary file, with the number of triangles [byte].
const HEADER: usize = 84;
/// Size of a triangle in a binary file [byte].
const TRIANGLE: usize = 50;

/// Largest number of bytes after the last triangle of a binary file.
const SURPLUS: usize = 128;

/// Returns true for text with `solid` and a facet, and for binary data of the right length.
pub fn recognises(head: &[u8], length: usize) -> bool {
    let fits = |count: usize| {
        let surplus = length.checked_sub(HEADER + TRIANGLE * count);
        count > 0 && surplus.is_some_and(|surplus| surplus <= SURPLUS)
    };
    is_text(head) || stated(head).is_some_and(fits)
}

fn is_text(head: &[u8]) -> bool {
    let head = head.to_ascii_lowercase();
    let has = |word: &[u8]| head.windows(word.len()).any(|window| window == word);
    head.trim_ascii_start().starts_with(b"solid") && (has(b"facet") || has(b"endsolid"))
}

/// Returns the number of triangles that a binary file states.
fn stated(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

/// Reads a file.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let mut surface = StlSurface { nodes: HashMap::new(), triangles: 0, degenerate: 0 };
    if is_text(&bytes[..bytes.len().min(super::HEAD)]) {
        surface.text(reading, bytes);
    } else {
        surface.binary(reading, bytes);
    }
    if surface.degenerate > 0 {
        let became = "left out: two of their corners are at one point";
        reading.row(Fate::Ignored, "triangles without area", surface.degenerate, became);
    }
    for part in &mut reading.mesh.parts {
        part.rigid = true;
    }
    if !reading.mesh.parts.is_empty() {
        let became = "a part for a [[rigid]] body; without one it is deformable";
        reading.row(Fate::Read, "surfaces", reading.mesh.parts.len(), became);
    }
}

/// A surface while it is read.
struct StlSurface {
    /// Nodes by the bits of their coordinates.
    nodes: HashMap<[u64; 3], u64>,
    triangles: u64,
    degenerate: usize,
}

impl StlSurface {
    fn binary(&mut self, reading: &mut MeshReading, bytes: &[u8]) {
        let part = reading.mesh.part_with_id(1, "");
        let count = stated(bytes).unwrap_or(0);
        let triangles = bytes.get(HEADER..).unwrap_or_default().chunks_exact(TRIANGLE).take(count);
        for (index, triangle) in triangles.enumerate() {
            let number = |at: usize| {
                let raw = [0, 1, 2, 3].map(|byte| triangle[at + byte]);
                f64::from(f32::from_le_bytes(raw))
            };
            let corners: [[f64; 3]; 3] =
                [12, 24, 36].map(|at| [number(at), number(at + 4), number(at + 8)]);
            if corners.iter().flatten().all(|x| x.is_finite()) {
                self.add(reading, part, &corners, FilePlace::default());
            } else {
                let message = format!("triangle {index} has the corners {corners:?}");
                let help = "coordinates have to be finite numbers; export the surface again";
                reading.error("not finite", FilePlace::default(), message, help);
            }
        }
    }

    fn text(&mut self, reading: &mut MeshReading, bytes: &[u8]) {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let mut corners: Vec<[f64; 3]> = Vec::new();
        let mut part = None;
        let mut open = FilePlace::default();
        for (line, number) in text.lines().zip(1..) {
            let place = FilePlace { file: 0, line: number };
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let keywords: Vec<String> =
                words.iter().take(2).map(|word| word.to_ascii_lowercase()).collect();
            let keywords: Vec<&str> = keywords.iter().map(String::as_str).collect();
            match keywords.as_slice() {
                [] | ["outer", "loop"] | ["endloop"] => {}
                ["solid", ..] => {
                    let id = reading.mesh.free_part_id();
                    part = Some(reading.mesh.part_with_id(id, &words[1..].join(" ")));
                    open = place;
                }
                ["facet", ..] => {
                    if !corners.is_empty() {
                        let message = "a facet begins before the last one has ended";
                        reading.error("facet", place, message, SHAPE);
                    }
                    corners.clear();
                }
                ["vertex", ..] => {
                    corners.extend(point(reading, &words[1..], place));
                }
                ["endfacet"] => {
                    match (<[[f64; 3]; 3]>::try_from(corners.as_slice()), part) {
                        (Ok(three), Some(part)) => self.add(reading, part, &three, place),
                        _ => {
                            let message =
                                format!("a facet with {} corners ends here", corners.len());
                            reading.error("facet", place, message, SHAPE);
                        }
                    }
                    corners.clear();
                }
                ["endsolid", ..] => {
                    if !corners.is_empty() {
                        let message = "the solid ends within a facet";
                        reading.error("facet", place, message, SHAPE);
                    }
                    corners.clear();
                    part = None;
                }
                _ => {
                    let message = format!("`{}` is no line of an STL file", shortened(line.trim()));
                    reading.error("line", place, message, SHAPE);
                }
            }
        }
        if part.is_some() {
            reading.error("end", open, "the solid has no endsolid", "the file may be cut");
        }
    }

    fn add(
        &mut self,
        reading: &mut MeshReading,
        part: usize,
        corners: &[[f64; 3]; 3],
        place: FilePlace,
    ) {
        let ids = corners.map(|x| {
            // Zero has two signs.
            let key = x.map(|c| (c + 0.0).to_bits());
            let next = self.nodes.len() as u64 + 1;
            *self.nodes.entry(key).or_insert_with(|| {
                reading.mesh.nodes.push(FileNode { id: next, x, place });
                next
            })
        });
        if ids[0] == ids[1] || ids[1] == ids[2] || ids[2] == ids[0] {
            self.degenerate += 1;
            return;
        }
        self.triangles += 1;
        reading.add_element((self.triangles, part), Cell::Triangle, &ids, place);
    }
}

/// How a facet is written.
const SHAPE: &str = "a facet is: facet normal x y z, outer loop, three lines vertex x y z, \
                     endloop, endfacet; export the surface again";

fn point(reading: &mut MeshReading, words: &[&str], place: FilePlace) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = words.iter().map(|w| number::real(w.as_bytes())).collect();
    let found = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    if found.is_none() {
        let message = format!("`vertex {}` has not three finite numbers", words.join(" "));
        reading.error("vertex", place, message, SHAPE);
    }
    found
}
