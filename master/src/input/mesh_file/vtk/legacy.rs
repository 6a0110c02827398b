//! Legacy files of VTK, versions 1 to 5.1: unstructured grids and surfaces.

use super::scalar::ScalarType;
use super::{VtkGrid, index_of};
use crate::input::deck::number;
use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::MeshReading;
use crate::input::mesh_file::shortened;

/// Fault of a section: description and cure.
type LegacyFault = (String, &'static str);

const COMPLETE: &str = "the file may be cut or edited: export it again";

/// Reads a file.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let mut file = LegacyReader { bytes, at: 0, line: 0, binary: false, grid: VtkGrid::default() };
    match file.read() {
        Ok(()) => super::add(file.grid, reading),
        Err((message, help)) => {
            let place = FilePlace { file: 0, line: file.line };
            reading.error("section", place, message, help);
        }
    }
}

/// Returns the points of a cell.
fn indices(cell: usize, row: &[f64]) -> Result<Vec<u64>, LegacyFault> {
    let index = |&point: &f64| {
        index_of(point).ok_or_else(|| (format!("cell {cell} has the point {point}"), COMPLETE))
    };
    row.iter().map(index).collect()
}

struct LegacyReader<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
    binary: bool,
    grid: VtkGrid,
}

/// The cells of a file while they are read.
#[derive(Default)]
struct CellLists {
    /// Points of each cell, with the type of a surface cell.
    cells: Vec<(Option<u64>, Vec<u64>)>,
    types: Option<Vec<f64>>,
}

impl<'a> LegacyReader<'a> {
    fn read(&mut self) -> Result<(), LegacyFault> {
        self.raw_line(); // version
        self.raw_line(); // title
        let form = self.raw_line().unwrap_or_default();
        self.binary = match form.trim().to_uppercase().as_str() {
            "ASCII" => false,
            "BINARY" => true,
            _ => {
                return Err((
                    format!("ASCII or BINARY is expected, not `{}`", shortened(form)),
                    COMPLETE,
                ));
            }
        };
        let dataset = self.words().unwrap_or_default();
        match dataset.as_slice() {
            ["DATASET", "UNSTRUCTURED_GRID" | "POLYDATA"] => {}
            ["DATASET", kind] => {
                let message = format!("the data set is a {kind}, and no mesh of cells");
                let help = "convert it to an unstructured grid (in ParaView the filter Append \
                            Datasets), and save it again";
                return Err((message, help));
            }
            _ => return Err(("the line DATASET is missing".into(), COMPLETE)),
        }
        let mut lists = CellLists::default();
        let mut of_cells = false;
        while let Some(words) = self.words() {
            self.section(&words, &mut lists, &mut of_cells)?;
        }
        self.finish(lists)
    }

    fn finish(&mut self, lists: CellLists) -> Result<(), LegacyFault> {
        let count = lists.cells.len();
        if let Some(types) = &lists.types
            && types.len() != count
        {
            return Err((format!("{count} cells have {} CELL_TYPES", types.len()), COMPLETE));
        }
        for (index, (own, points)) in lists.cells.into_iter().enumerate() {
            let Some(kind) = own
                .map(|kind| kind as f64)
                .or_else(|| lists.types.as_ref().map(|types| types[index]))
            else {
                return Err(("the section CELL_TYPES is missing".into(), COMPLETE));
            };
            let Some(kind) = index_of(kind) else {
                return Err((format!("cell {index} has the type {kind}"), COMPLETE));
            };
            self.grid.cells.push((kind, points));
        }
        Ok(())
    }

    fn section(
        &mut self,
        words: &[&str],
        lists: &mut CellLists,
        of_cells: &mut bool,
    ) -> Result<(), LegacyFault> {
        let tuples = |reader: &Self, of_cells: bool, lists: &CellLists| {
            if of_cells { lists.cells.len() } else { reader.grid.points.len() }
        };
        match words {
            ["POINTS", count, kind] => {
                let count = self.count(count, 3)?;
                let numbers = self.numbers(kind, 3 * count, "POINTS")?;
                self.grid.points = numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
            }
            ["CELLS", first, second] => self.cells(first, second, None, lists)?,
            ["POLYGONS", first, second] => self.cells(first, second, Some(7), lists)?,
            ["LINES", first, second] => self.cells(first, second, Some(3), lists)?,
            ["VERTICES", first, second] => self.cells(first, second, Some(2), lists)?,
            ["TRIANGLE_STRIPS", first, second] => self.cells(first, second, Some(6), lists)?,
            ["CELL_TYPES", count] => {
                let count = self.count(count, 1)?;
                lists.types = Some(self.numbers("int", count, "CELL_TYPES")?);
            }
            ["POINT_DATA", _] => *of_cells = false,
            ["CELL_DATA", _] => *of_cells = true,
            ["SCALARS", name, kind, rest @ ..] => {
                let components = rest.first().map_or(Ok(1), |count| self.count(count, 1))?;
                let count = components.saturating_mul(tuples(self, *of_cells, lists));
                let mark = (self.at, self.line);
                if self.words().is_none_or(|next| next[0] != "LOOKUP_TABLE") {
                    (self.at, self.line) = mark;
                }
                let numbers = self.numbers(kind, count, name)?;
                self.array(name, components, numbers, *of_cells);
            }
            ["LOOKUP_TABLE", _, count] => {
                let count = self.count(count, 1)?;
                self.colours(count.saturating_mul(4))?;
            }
            ["COLOR_SCALARS", name, count] => {
                let count = self.count(count, 1)?;
                self.colours(count.saturating_mul(tuples(self, *of_cells, lists)))?;
                self.grid.others.push((*name).into());
            }
            ["VECTORS" | "NORMALS", name, kind] => {
                self.skip(name, kind, 3, tuples(self, *of_cells, lists))?;
            }
            ["TENSORS", name, kind] => self.skip(name, kind, 9, tuples(self, *of_cells, lists))?,
            ["TEXTURE_COORDINATES", name, size, kind] => {
                let size = self.count(size, 1)?;
                self.skip(name, kind, size, tuples(self, *of_cells, lists))?;
            }
            ["GLOBAL_IDS" | "PEDIGREE_IDS", name, kind] => {
                let numbers = self.numbers(kind, tuples(self, *of_cells, lists), name)?;
                self.array(name, 1, numbers, *of_cells);
            }
            ["FIELD", _, count] => {
                for _ in 0..self.count(count, 0)? {
                    self.field_array(*of_cells)?;
                }
            }
            ["METADATA", ..] => {
                while self.raw_line().is_some_and(|line| !line.trim().is_empty()) {}
            }
            _ => {
                let message = format!("the section `{}` is not known", shortened(&words.join(" ")));
                return Err((message, COMPLETE));
            }
        }
        Ok(())
    }

    fn skip(
        &mut self,
        name: &str,
        kind: &str,
        components: usize,
        tuples: usize,
    ) -> Result<(), LegacyFault> {
        self.numbers(kind, components.saturating_mul(tuples), name)?;
        self.grid.others.push(name.into());
        Ok(())
    }

    /// Reads numbers of colours: bytes, or as text numbers from 0 to 1.
    fn colours(&mut self, count: usize) -> Result<(), LegacyFault> {
        self.numbers("unsigned_char", count, "colours").map(drop)
    }

    fn field_array(&mut self, of_cells: bool) -> Result<(), LegacyFault> {
        let mut words = self.words().unwrap_or_default();
        while words.first() == Some(&"METADATA") {
            while self.raw_line().is_some_and(|line| !line.trim().is_empty()) {}
            words = self.words().unwrap_or_default();
        }
        let [name, components, tuples, kind] = words[..] else {
            let message = format!("an array of a FIELD is expected, not `{}`", words.join(" "));
            return Err((message, COMPLETE));
        };
        let (components, tuples) = (self.count(components, 1)?, self.count(tuples, 1)?);
        if kind.eq_ignore_ascii_case("string") {
            for _ in 0..components.saturating_mul(tuples) {
                if self.raw_line().is_none() {
                    return Err((format!("the array `{name}` is cut"), COMPLETE));
                }
            }
            return Ok(());
        }
        let numbers = self.numbers(kind, components.saturating_mul(tuples), name)?;
        self.array(name, components, numbers, of_cells);
        Ok(())
    }

    fn array(&mut self, name: &str, components: usize, numbers: Vec<f64>, of_cells: bool) {
        if components != 1 {
            self.grid.others.push(name.into());
            return;
        }
        let arrays = if of_cells { &mut self.grid.of_cells } else { &mut self.grid.of_points };
        arrays.insert(name.into(), numbers);
    }

    /// Reads a list of cells: before version 5 each with its number of points, from then on as
    /// offsets and points.
    fn cells(
        &mut self,
        first: &str,
        second: &str,
        kind: Option<u64>,
        lists: &mut CellLists,
    ) -> Result<(), LegacyFault> {
        let (first, second) = (self.count(first, 0)?, self.count(second, 1)?);
        let mark = (self.at, self.line);
        let next = self.words().unwrap_or_default();
        if let ["OFFSETS", offsets] = next[..] {
            let ends = self.numbers(offsets, first, "OFFSETS")?;
            let points = match self.words().as_deref() {
                Some(["CONNECTIVITY", kind]) => self.numbers(kind, second, "CONNECTIVITY")?,
                _ => return Err(("CONNECTIVITY is missing after OFFSETS".into(), COMPLETE)),
            };
            for (cell, pair) in ends.windows(2).enumerate() {
                let range = index_of(pair[0]).zip(index_of(pair[1]));
                let row = range.and_then(|(a, b)| points.get(a as usize..b as usize));
                let Some(row) = row else {
                    let message = format!("OFFSETS {} to {} are wrong", pair[0], pair[1]);
                    return Err((message, COMPLETE));
                };
                lists.cells.push((kind, indices(cell, row)?));
            }
            return Ok(());
        }
        (self.at, self.line) = mark;
        let numbers = self.numbers("int", second, "CELLS")?;
        let mut at = 0;
        for cell in 0..first {
            let count = numbers.get(at).copied().and_then(index_of);
            let row = count.and_then(|n| numbers.get(at + 1..(at + 1).saturating_add(n as usize)));
            let Some(row) = row else {
                let message = format!("cell {cell} is missing or not complete");
                return Err((message, COMPLETE));
            };
            lists.cells.push((kind, indices(cell, row)?));
            at += 1 + row.len();
        }
        Ok(())
    }

    /// Returns a count. The file has to be long enough for so many numbers.
    fn count(&self, word: &str, least: usize) -> Result<usize, LegacyFault> {
        let found = word.parse::<usize>().ok();
        let fits = |&count: &usize| count.saturating_mul(least) <= self.bytes.len();
        found.filter(fits).ok_or_else(|| {
            (
                format!("`{}` is no count, or the file is too short for it", shortened(word)),
                COMPLETE,
            )
        })
    }

    fn numbers(&mut self, kind: &str, count: usize, of: &str) -> Result<Vec<f64>, LegacyFault> {
        let Some(scalar) = ScalarType::legacy(kind) else {
            return Err((format!("`{}` is no type of numbers", shortened(kind)), COMPLETE));
        };
        if self.binary {
            let end = scalar.size(count).and_then(|n| n.checked_add(self.at));
            let found = end.and_then(|end| self.bytes.get(self.at..end));
            let Some(found) = found else {
                let message = format!("{of}: the file ends before its {count} numbers");
                return Err((message, COMPLETE));
            };
            self.at += found.len();
            let mut numbers = scalar.numbers(found, true);
            numbers.truncate(count);
            return Ok(numbers);
        }
        let mut numbers = Vec::new();
        while numbers.len() < count {
            let Some(word) = self.word() else {
                let message = format!("{of} has {} numbers, not {count}", numbers.len());
                return Err((message, COMPLETE));
            };
            match number::real(word.as_bytes()) {
                Some(number) => numbers.push(number),
                None => {
                    let message = format!("{of}: `{}` is no finite number", shortened(word));
                    return Err((message, "correct it, or export the file again"));
                }
            }
        }
        Ok(numbers)
    }

    /// Returns the next word of text.
    fn word(&mut self) -> Option<&'a str> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += u32::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then(|| std::str::from_utf8(&rest[..length]).unwrap_or("\u{fffd}"))
    }

    fn raw_line(&mut self) -> Option<&'a str> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        self.line += 1;
        Some(std::str::from_utf8(&rest[..length]).unwrap_or("\u{fffd}"))
    }

    /// Returns the words of the next line with text.
    fn words(&mut self) -> Option<Vec<&'a str>> {
        loop {
            let words: Vec<&str> = self.raw_line()?.split_ascii_whitespace().collect();
            if !words.is_empty() {
                return Some(words);
            }
        }
    }
}
