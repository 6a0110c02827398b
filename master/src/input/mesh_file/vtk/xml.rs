//! XML files of VTK: unstructured grids and surfaces, with arrays as text, base64 or raw bytes,
//! also compressed by zlib. Lists of such files (`.pvtu`, `.pvtp`), which programs write that run
//! in parallel.

use super::scalar::ScalarType;
use super::{VtkGrid, index_of};
use crate::input::deck::number;
use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::MeshReading;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use roxmltree::{Document, Node};
use std::io::Read as _;

/// Fault of a file: description, cure, and the line if it is known.
struct XmlFault {
    message: String,
    help: &'static str,
    line: u32,
}

const NO_PIECE: &str = "it has no Piece";
const COMPLETE: &str = "the file may be cut or edited: export it again";
/// Largest size of a compressed array after it is unpacked [byte].
const LARGEST_ARRAY: usize = 1 << 31;
const DAMAGED: &str = "its data are damaged, cut, or above 2 GiB";
const OTHER_FORM: &str = "save it in another form, such as text (in ParaView: Data Mode Ascii)";

fn fault(message: impl Into<String>, help: &'static str) -> XmlFault {
    XmlFault { message: message.into(), help, line: 0 }
}

/// A piece in another file.
struct ListedPiece {
    /// Name of the file, relative to that of the list.
    source: String,
    line: u32,
}

/// Reads a file, and the pieces that it lists.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let report = |reading: &mut MeshReading, file: u32, fault: XmlFault| {
        reading.error("array", FilePlace { file, line: fault.line }, fault.message, fault.help);
    };
    let mut grid = VtkGrid::default();
    let listed = add_file(bytes, &mut grid).unwrap_or_else(|fault| {
        report(reading, 0, fault);
        Vec::new()
    });
    for piece in listed {
        let place = FilePlace { file: 0, line: piece.line };
        let Some((file, bytes)) = reading.include(&piece.source, place) else { continue };
        match add_file(&bytes, &mut grid) {
            Ok(nested) if nested.is_empty() => {}
            Ok(_) => {
                let message = format!("the piece `{}` is a list of pieces", piece.source);
                reading.error("piece", place, message, "name the pieces of that list here");
            }
            Err(fault) => report(reading, file, fault),
        }
    }
    if reading.has_errors() {
        return;
    }
    // Arrays that a piece lacks have fewer numbers than points or cells.
    let (points, cells) = (grid.points.len(), grid.cells.len());
    grid.of_points.retain(|_, array| array.len() == points);
    grid.of_cells.retain(|_, array| array.len() == cells);
    super::add(grid, reading);
}

/// Adds the pieces of a file to a grid. Returns those that it lists.
fn add_file(bytes: &[u8], grid: &mut VtkGrid) -> Result<Vec<ListedPiece>, XmlFault> {
    // Appended data are no XML, so the text before them is closed here.
    let mark = b"<AppendedData";
    let begin = bytes.windows(mark.len()).position(|window| window == mark);
    let head = &bytes[..begin.unwrap_or(bytes.len())];
    let text = std::str::from_utf8(head).map_err(|_| fault("it is no UTF-8 text", COMPLETE))?;
    let closed = match begin {
        Some(_) => format!("{text}</VTKFile>"),
        None => text.to_string(),
    };
    let document = Document::parse(&closed).map_err(|error| XmlFault {
        message: format!("it is no valid XML: {error}"),
        help: COMPLETE,
        line: error.pos().row,
    })?;
    let root = document.root_element();
    let attribute = |name: &str| root.attribute(name).unwrap_or_default();
    let kind = attribute("type");
    if ["PUnstructuredGrid", "PPolyData"].contains(&kind) {
        return listed(&document);
    }
    if !["UnstructuredGrid", "PolyData"].contains(&kind) {
        let help = "give the .vtu or .vtp file of one grid; convert others to an unstructured \
                    grid (in ParaView the filters Merge Blocks or Append Datasets)";
        return Err(fault(format!("the data set is `{kind}`, and no mesh of cells"), help));
    }
    let compressor = attribute("compressor");
    if !["", "vtkZLibDataCompressor"].contains(&compressor) {
        return Err(fault(format!("data are compressed by {compressor}"), OTHER_FORM));
    }
    let file = XmlReader {
        document: &document,
        appended: begin.map(|at| appended(&bytes[at..])).transpose()?,
        big_endian: attribute("byte_order") == "BigEndian",
        header: if attribute("header_type") == "UInt64" { 8 } else { 4 },
        compressed: !compressor.is_empty(),
    };
    file.grid(root, kind == "PolyData", grid)?;
    Ok(Vec::new())
}

/// Returns the pieces of a list.
fn listed(document: &Document) -> Result<Vec<ListedPiece>, XmlFault> {
    let pieces = document.descendants().filter(|node| node.has_tag_name("Piece"));
    let pieces: Vec<ListedPiece> = pieces
        .map(|piece| {
            let line = document.text_pos_at(piece.range().start).row;
            let source = piece.attribute("Source").filter(|source| !source.is_empty());
            source.map(|source| ListedPiece { source: source.into(), line }).ok_or(XmlFault {
                message: "the Piece has no Source".into(),
                help: "write the name of its .vtu or .vtp file: Source=\"NAME\"",
                line,
            })
        })
        .collect::<Result<_, _>>()?;
    if pieces.is_empty() {
        return Err(fault(NO_PIECE, COMPLETE));
    }
    Ok(pieces)
}

/// Appended data: bytes after the mark, and whether they are base64.
#[derive(Clone, Copy)]
struct AppendedData<'a> {
    bytes: &'a [u8],
    base64: bool,
}

fn appended(bytes: &[u8]) -> Result<AppendedData<'_>, XmlFault> {
    let end = bytes.iter().position(|&b| b == b'>').unwrap_or(0);
    let tag = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let start = bytes.iter().skip(end).position(|&b| b == b'_').map(|at| end + at + 1);
    let Some(start) = start else {
        return Err(fault("the appended data have no begin `_`", COMPLETE));
    };
    Ok(AppendedData { bytes: &bytes[start..], base64: tag.contains("base64") })
}

struct XmlReader<'a, 'd> {
    document: &'d Document<'a>,
    appended: Option<AppendedData<'d>>,
    big_endian: bool,
    /// Size of the numbers before the data of an array [byte].
    header: usize,
    compressed: bool,
}

impl XmlReader<'_, '_> {
    fn grid(&self, root: Node, surface: bool, grid: &mut VtkGrid) -> Result<(), XmlFault> {
        let before = grid.pieces;
        for piece in root.descendants().filter(|node| node.has_tag_name("Piece")) {
            grid.pieces += 1;
            self.piece(piece, surface, grid)?;
        }
        if grid.pieces == before { Err(fault(NO_PIECE, COMPLETE)) } else { Ok(()) }
    }

    fn piece(&self, piece: Node, surface: bool, grid: &mut VtkGrid) -> Result<(), XmlFault> {
        let first = grid.points.len() as u64;
        let points = self.required(piece, "Points", None)?;
        if points.len() % 3 != 0 {
            let message = format!("Points has {} numbers, not three for each point", points.len());
            return Err(self.at(piece, message));
        }
        grid.points.extend(points.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        self.stated(piece, "NumberOfPoints", points.len() / 3)?;
        let before = grid.cells.len();
        let lists: &[(&str, u64)] = match surface {
            true => &[("Verts", 2), ("Lines", 3), ("Strips", 6), ("Polys", 7)],
            false => &[("Cells", 0)],
        };
        for (list, kind) in lists {
            let Some(cells) = child(piece, list) else { continue };
            if surface && child_array(cells, "connectivity").is_none() {
                continue;
            }
            let connectivity = self.required(piece, list, Some("connectivity"))?;
            let offsets = self.required(piece, list, Some("offsets"))?;
            let types = match surface {
                true => vec![*kind as f64; offsets.len()],
                false => self.required(piece, list, Some("types"))?,
            };
            if types.len() != offsets.len() {
                let message =
                    format!("{} offsets and {} types of cells", offsets.len(), types.len());
                return Err(self.at(cells, message));
            }
            let mut start = 0;
            for (&offset, &kind) in offsets.iter().zip(&types) {
                let end = index_of(offset).map(|end| end as usize);
                let Some((row, end)) =
                    end.and_then(|end| Some((connectivity.get(start..end)?, end)))
                else {
                    let message = format!("offset {offset} of the cells is wrong");
                    return Err(self.at(cells, message));
                };
                let index = |&point: &f64| index_of(point).and_then(|p| first.checked_add(p));
                let Some(points) = row.iter().map(index).collect() else {
                    return Err(self.at(cells, format!("a cell has the points {row:?}")));
                };
                let Some(kind) = index_of(kind) else {
                    return Err(self.at(cells, format!("a cell has the type {kind}")));
                };
                grid.cells.push((kind, points));
                start = end;
            }
        }
        if !surface {
            self.stated(piece, "NumberOfCells", grid.cells.len() - before)?;
        }
        self.data(piece, "PointData", grid)?;
        self.data(piece, "CellData", grid)
    }

    /// Checks a count that a piece states.
    fn stated(&self, piece: Node, name: &str, found: usize) -> Result<(), XmlFault> {
        match piece.attribute(name).map(str::parse::<usize>) {
            Some(Ok(stated)) if stated == found => Ok(()),
            stated => {
                let stated = stated.and_then(Result::ok).map_or("none".into(), |n| n.to_string());
                Err(self.at(piece, format!("{name} is {stated}, and the arrays have {found}")))
            }
        }
    }

    /// Reads arrays with one component that can be ids or parts.
    fn data(&self, piece: Node, section: &str, grid: &mut VtkGrid) -> Result<(), XmlFault> {
        let Some(data) = child(piece, section) else { return Ok(()) };
        for array in data.children().filter(|node| node.has_tag_name("DataArray")) {
            let name = array.attribute("Name").unwrap_or("(no name)").to_string();
            let components = array.attribute("NumberOfComponents").unwrap_or("1");
            let kind = array.attribute("type").and_then(ScalarType::xml);
            if components != "1" || kind.is_none() {
                if !grid.others.contains(&name) {
                    grid.others.push(name);
                }
                continue;
            }
            let numbers = self.numbers(array)?;
            let arrays = match section {
                "PointData" => &mut grid.of_points,
                _ => &mut grid.of_cells,
            };
            arrays.entry(name).or_default().extend(numbers);
        }
        Ok(())
    }

    fn required(
        &self,
        piece: Node,
        section: &str,
        name: Option<&str>,
    ) -> Result<Vec<f64>, XmlFault> {
        let found = child(piece, section).and_then(|node| match name {
            Some(name) => child_array(node, name),
            None => child(node, "DataArray"),
        });
        match found {
            Some(array) => self.numbers(array),
            None => {
                let name = name.unwrap_or("coordinates");
                Err(self.at(piece, format!("{section} has no array of {name}")))
            }
        }
    }

    fn at(&self, node: Node, message: String) -> XmlFault {
        let line = self.document.text_pos_at(node.range().start).row;
        XmlFault { message, help: COMPLETE, line }
    }

    /// Returns the numbers of an array.
    fn numbers(&self, array: Node) -> Result<Vec<f64>, XmlFault> {
        let name = array.attribute("Name").unwrap_or("Points").to_string();
        let broken = |why: &str| self.at(array, format!("array `{name}`: {why}"));
        let kind = array.attribute("type").unwrap_or_default();
        let scalar =
            ScalarType::xml(kind).ok_or_else(|| broken(&format!("`{kind}` is no number type")))?;
        let text = array.text().unwrap_or_default();
        match array.attribute("format").unwrap_or("ascii") {
            "ascii" => text
                .split_ascii_whitespace()
                .map(|word| {
                    number::real(word.as_bytes())
                        .ok_or_else(|| broken(&format!("`{word}` is no finite number")))
                })
                .collect(),
            "binary" => {
                let bytes = decoded(text.trim().as_bytes()).ok_or_else(|| broken("no base64"))?;
                let bytes = self.unpacked(&bytes).ok_or_else(|| broken(DAMAGED))?;
                Ok(scalar.numbers(&bytes, self.big_endian))
            }
            "appended" => {
                let offset = array.attribute("offset").and_then(|text| text.parse::<usize>().ok());
                let data = self.appended.ok_or_else(|| broken("there are no appended data"))?;
                let rest = offset.and_then(|offset| data.bytes.get(offset..));
                let rest = rest.ok_or_else(|| broken("its offset is beyond the data"))?;
                let bytes = match data.base64 {
                    true => decoded(rest).and_then(|bytes| self.unpacked(&bytes)),
                    false => self.unpacked(rest),
                };
                let bytes = bytes.ok_or_else(|| broken(DAMAGED))?;
                Ok(scalar.numbers(&bytes, self.big_endian))
            }
            other => Err(broken(&format!("the format `{other}` is not known"))),
        }
    }

    /// Returns the data of an array after its header: lengths, and packed blocks.
    fn unpacked(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let head = |index: usize| {
            let range = index.checked_mul(self.header)?..(index + 1).checked_mul(self.header)?;
            let kind = if self.header == 8 { ScalarType::U64 } else { ScalarType::U32 };
            kind.numbers(bytes.get(range)?, self.big_endian).first().map(|&n| n as usize)
        };
        if !self.compressed {
            let start = self.header;
            return Some(bytes.get(start..start.checked_add(head(0)?)?)?.to_vec());
        }
        let blocks = head(0)?;
        let mut at = blocks.checked_add(3)?.checked_mul(self.header)?;
        bytes.get(..at)?;
        let size = head(1)?;
        let mut found = Vec::new();
        for block in 0..blocks {
            let end = at.checked_add(head(3 + block)?)?;
            let most = found.len().checked_add(size).filter(|&most| most <= LARGEST_ARRAY)?;
            let packed = flate2::read::ZlibDecoder::new(bytes.get(at..end)?);
            // A block that is longer than its header states is damaged.
            packed.take(size as u64 + 1).read_to_end(&mut found).ok()?;
            if found.len() > most {
                return None;
            }
            at = end;
        }
        Some(found)
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn child_array<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    let mut arrays = node.children().filter(|child| child.has_tag_name("DataArray"));
    arrays.find(|array| array.attribute("Name") == Some(name))
}

/// Returns the bytes of base64 data up to the first other character. Headers of compressed data end
/// with padding of their own.
fn decoded(text: &[u8]) -> Option<Vec<u8>> {
    let is_data = |b: &u8| b.is_ascii_alphanumeric() || [b'+', b'/', b'='].contains(b);
    let text: Vec<u8> = text
        .iter()
        .copied()
        .filter(|b| !b.is_ascii_whitespace())
        .take_while(|b| is_data(b))
        .collect();
    let mut found = Vec::new();
    let mut rest = &text[..];
    while !rest.is_empty() {
        let padding = rest.iter().position(|&b| b == b'=').unwrap_or(rest.len());
        let end = padding + rest[padding..].iter().take_while(|&&b| b == b'=').count();
        // Data of the next array may follow without a mark, cut here to whole groups.
        let piece = &rest[..end];
        let piece = if padding == rest.len() { &piece[..piece.len() / 4 * 4] } else { piece };
        found.extend(STANDARD.decode(piece).ok()?);
        rest = &rest[end..];
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    /// A block of 100 bytes is unpacked if its header states 100 bytes. If it states fewer, or more
    /// than an array may have, the data are damaged.
    #[test]
    fn blocks_have_the_size_of_their_header() {
        let document = Document::parse("<a/>").unwrap();
        let file = XmlReader {
            document: &document,
            appended: None,
            big_endian: false,
            header: 4,
            compressed: true,
        };
        let mut encoder =
            flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&[7; 100]).unwrap();
        let packed = encoder.finish().unwrap();
        let unpacked = |size: u32| {
            let numbers = [1, size, 0, packed.len() as u32];
            let mut bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            bytes.extend(&packed);
            file.unpacked(&bytes)
        };
        assert_eq!(unpacked(100), Some(vec![7; 100]));
        assert_eq!(unpacked(99), None);
        assert_eq!(unpacked(u32::MAX), None);
    }
}
