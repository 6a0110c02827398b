//! All histories of a run for the plot workbench of the page: the model (`history.csv`) and the
//! objects of the files by kind, at the times of `history.csv`.

use super::encode::PackedColumns;
use super::plots::named;
use serde::Serialize;
use std::collections::HashMap;
use std::path::Path;

/// Maximum number of values: 6 MB before compression. Longer histories are thinned.
const MOST_VALUES: usize = 1_500_000;
/// Maximum number of values in memory: 200 MB.
const MOST_IN_MEMORY: usize = 50_000_000;
/// Maximum number of columns. Objects beyond it are omitted.
const MOST_COLUMNS: usize = 2000;

/// A file with one row per object and time.
struct KindFile {
    name: &'static str,
    /// Kind of its objects.
    kind: &'static str,
    /// Number of columns after the time that name the object.
    words: usize,
}

const fn kind(name: &'static str, kind: &'static str, words: usize) -> KindFile {
    KindFile { name, kind, words }
}

/// The files. The first one has the times of all.
const FILES: [KindFile; 8] = [
    kind("history.csv", "model", 0),
    kind("walls.csv", "wall", 1),
    kind("sections.csv", "section", 1),
    kind("transducers.csv", "transducer", 1),
    kind("airbags.csv", "airbag", 1),
    kind("contacts.csv", "contact of part", 2),
    kind("nodes.csv", "node", 2),
    kind("parts.csv", "part", 2),
];

/// An object with its quantities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistoryObject {
    /// Kind.
    pub kind: &'static str,
    /// Name, empty for the model.
    pub name: String,
    /// Names and units of the quantities, in the order of their columns.
    pub quantities: Vec<[String; 2]>,
}

/// Description of the packed columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportHistories {
    /// Number of rows.
    pub rows: usize,
    /// Objects in the order of their columns.
    pub objects: Vec<HistoryObject>,
    /// Times [time].
    #[serde(skip)]
    time: Vec<f64>,
    /// Columns of all objects.
    #[serde(skip)]
    columns: Vec<Vec<f32>>,
    /// Number of rows of `history.csv`.
    #[serde(skip)]
    written: usize,
    /// Number of objects of the files.
    #[serde(skip)]
    existing: usize,
}

/// Header and first objects of a file.
struct Opened<'f> {
    file: &'f KindFile,
    reader: csv::Reader<std::fs::File>,
    quantities: Vec<[String; 2]>,
    objects: Vec<String>,
}

impl KindFile {
    /// Opens the file, and finds its objects from the rows of its first time. Returns none for a
    /// file that is absent or has no row.
    fn open(&self, dir: &Path) -> Option<Opened<'_>> {
        let reader =
            || csv::ReaderBuilder::new().flexible(true).from_path(dir.join(self.name)).ok();
        let mut rows = reader()?;
        let header = rows.headers().ok()?.clone();
        let quantities = header.iter().skip(1 + self.words).map(named).collect();
        let mut objects = Vec::new();
        let mut first = None;
        for record in rows.records().map_while(Result::ok) {
            let time = record.get(0)?.to_owned();
            if first.get_or_insert_with(|| time.clone()) != &time {
                break;
            }
            objects.push(self.object(&record));
        }
        (!objects.is_empty()).then_some(())?;
        Some(Opened { file: self, reader: reader()?, quantities, objects })
    }

    fn object(&self, record: &csv::StringRecord) -> String {
        let words: Vec<&str> =
            (1..=self.words).filter_map(|at| record.get(at)).filter(|w| !w.is_empty()).collect();
        words.join(" ")
    }
}

impl ReportHistories {
    /// Reads the histories of the run in `dir` as far as the files are intact, with all rows unless
    /// memory does not suffice for them.
    pub fn whole(dir: &Path) -> Self {
        Self::with_limits(dir, MOST_IN_MEMORY, MOST_COLUMNS)
    }

    /// Reads the histories of the run in `dir`, as far as the files are intact. Damage is named by
    /// the readers of the plots.
    pub fn read(dir: &Path) -> Self {
        Self::with_limits(dir, MOST_VALUES, MOST_COLUMNS)
    }

    fn with_limits(dir: &Path, most_values: usize, most_columns: usize) -> Self {
        let mut files: Vec<Opened<'_>> = FILES.iter().filter_map(|file| file.open(dir)).collect();
        if files.first().is_none_or(|file| file.file.words > 0) {
            return Self::default(); // without history.csv there are no times
        }
        let mut out = Self::default();
        for file in &mut files {
            out.existing += file.objects.len();
            let room = most_columns.saturating_sub(out.width()) / file.quantities.len().max(1);
            file.objects.truncate(room);
            let object = |name: &String| HistoryObject {
                kind: file.file.kind,
                name: name.clone(),
                quantities: file.quantities.clone(),
            };
            out.objects.extend(file.objects.iter().map(object));
        }
        let number = |field: Option<&str>| field.and_then(|f| f.parse::<f64>().ok());
        let time_of = |record: &csv::StringRecord| number(record.get(0));
        let Some(model) = FILES[0].open(dir) else { return Self::default() };
        let all: Vec<f64> = model
            .reader
            .into_records()
            .map_while(Result::ok)
            .map_while(|record| time_of(&record))
            .collect();
        out.written = all.len();
        let every = (out.width() * all.len()).div_ceil(most_values.max(1)).max(1);
        let kept = |row: &usize| row.is_multiple_of(every) || row + 1 == all.len();
        out.time = (0..all.len()).filter(kept).map(|row| all[row]).collect();
        out.rows = out.time.len();
        // Times are written alike in all files, so equal times have equal bits.
        let row_of: HashMap<u64, usize> =
            out.time.iter().enumerate().map(|(row, t)| (t.to_bits(), row)).collect();
        for file in files {
            let (first, wide) = (out.columns.len(), file.quantities.len());
            let place: HashMap<&String, usize> =
                file.objects.iter().enumerate().map(|(at, name)| (name, at)).collect();
            out.columns.resize(first + wide * file.objects.len(), vec![f32::NAN; out.rows]);
            for record in file.reader.into_records().map_while(Result::ok) {
                let row = time_of(&record).and_then(|time| row_of.get(&time.to_bits()));
                let object = place.get(&file.file.object(&record));
                let (Some(&row), Some(&object)) = (row, object) else { continue };
                for quantity in 0..wide {
                    let value = number(record.get(1 + file.file.words + quantity));
                    let column = &mut out.columns[first + wide * object + quantity];
                    column[row] = value.map_or(f32::NAN, |v| v as f32);
                }
            }
        }
        out
    }

    /// Returns the number of columns.
    fn width(&self) -> usize {
        self.objects.iter().map(|object| object.quantities.len()).sum()
    }

    /// Returns the times of the rows [time].
    pub fn time(&self) -> &[f64] {
        &self.time
    }

    /// Returns the values of a quantity of an object over the rows, not finite where there is none.
    pub fn column(&self, object: usize, quantity: usize) -> &[f32] {
        let before: usize = self.objects[..object].iter().map(|o| o.quantities.len()).sum();
        &self.columns[before + quantity]
    }

    /// Returns the packed columns for `histories.js`: the two words of each time, the lower ones
    /// first, then the bits of each column.
    pub fn packed(&self) -> Vec<u8> {
        let mut out = PackedColumns::new();
        let bits: Vec<u64> = self.time.iter().map(|t| t.to_bits()).collect();
        out.chain(bits.iter().map(|b| *b as u32));
        out.chain(bits.iter().map(|b| (b >> 32) as u32));
        for column in &self.columns {
            out.chain(column.iter().map(|v| v.to_bits()));
        }
        out.finish()
    }

    /// Lists the content of the files that is not on the page.
    pub fn left_out(&self) -> Vec<String> {
        let mut out = Vec::new();
        if self.rows < self.written {
            out.push(format!(
                "The plot workbench has {} of the {} rows of the histories; its filters see only \
                 these.",
                self.rows, self.written
            ));
        }
        if self.objects.len() < self.existing {
            out.push(format!(
                "The plot workbench has {} of the {} objects of the histories.",
                self.objects.len(),
                self.existing
            ));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        write("history.csv", "time [ms],kinetic [J],pairs\n0,5,0\n1e-1,4,1\n2e-1,3,2\n3e-1,2,3\n");
        write(
            "nodes.csv",
            "time [ms],nodes,id,x [mm],acceleration x [mm/ms^2]\n0,head,7,1,2\n0,head,9,1,3\n\
             1e-1,head,7,1,4\n1e-1,head,9,1,5\n2e-1,head,7,1,nan\n2e-1,head,9,1,7\n9,head,7,1,1\n",
        );
        dir
    }

    #[test]
    fn objects_have_their_quantities_at_the_times_of_the_history() {
        let dir = folder();
        let h = ReportHistories::read(dir.path());
        assert_eq!((h.rows, h.objects.len(), h.time[3]), (4, 3, 0.3));
        assert_eq!(h.objects[0].quantities[1], ["pairs".to_owned(), String::new()]);
        assert_eq!((h.objects[2].kind, h.objects[2].name.as_str()), ("node", "head 9"));
        assert_eq!(h.columns[0], [5.0, 4.0, 3.0, 2.0]);
        assert_eq!(h.columns[5][..3], [3.0, 5.0, 7.0]);
        assert!(h.columns[5][3].is_nan() && h.columns[3][2].is_nan());
        assert!(h.left_out().is_empty());
        assert_eq!(
            ReportHistories::read(tempfile::tempdir().unwrap().path()),
            ReportHistories::default()
        );
    }

    #[test]
    fn what_does_not_fit_is_thinned_and_named() {
        let dir = folder();
        let h = ReportHistories::with_limits(dir.path(), 8, 4);
        assert_eq!((h.objects.len(), h.rows), (2, 3), "rows 0, 2 and the last");
        assert_eq!(h.time, [0.0, 0.2, 0.3]);
        let said = h.left_out().join(" ");
        assert!(said.contains("3 of the 4 rows") && said.contains("2 of the 3 objects"), "{said}");
    }
}
