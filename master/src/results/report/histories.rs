//! All histories of a run for the plot workbench of the page: the model (`history.csv`), the
//! objects of the files by kind, and the mass centres of rigid parts, at the times of
//! `history.csv`.

use super::encode::PackedColumns;
use super::mass_centres::{MASS_CENTRE, MassCentres};
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
const FILES: [KindFile; 9] = [
    kind("history.csv", "model", 0),
    kind("walls.csv", "wall", 1),
    kind("sections.csv", "section", 1),
    kind("transducers.csv", "transducer", 1),
    kind("airbags.csv", "airbag", 1),
    kind("belts.csv", "belt", 1),
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
    /// memory does not suffice for them. `rigid` are the ids of its rigid parts.
    pub fn whole(dir: &Path, rigid: &[u32]) -> Self {
        Self::with_limits(dir, rigid, MOST_IN_MEMORY, MOST_COLUMNS)
    }

    /// Reads the histories of the run in `dir`, as far as the files are intact. Damage is named by
    /// the readers of the plots. `rigid` are the ids of its rigid parts.
    pub fn read(dir: &Path, rigid: &[u32]) -> Self {
        Self::with_limits(dir, rigid, MOST_VALUES, MOST_COLUMNS)
    }

    fn with_limits(dir: &Path, rigid: &[u32], most_values: usize, most_columns: usize) -> Self {
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
        let Some(mut model) = FILES[0].open(dir) else { return Self::default() };
        let time_unit = model.reader.headers().ok().and_then(|head| head.get(0).map(named));
        let time_unit = time_unit.map_or(String::new(), |[_, unit]| unit);
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
        let mut centres = None;
        for file in files {
            let (first, wide) = (out.columns.len(), file.quantities.len());
            let place: HashMap<&String, usize> =
                file.objects.iter().enumerate().map(|(at, name)| (name, at)).collect();
            out.columns.resize(first + wide * file.objects.len(), vec![f32::NAN; out.rows]);
            let parts = (&file.quantities[..], &file.objects[..]);
            let mut of_rigid = (file.file.kind == "part")
                .then(|| MassCentres::new(parts, &time_unit, rigid, out.rows))
                .flatten();
            for record in file.reader.into_records().map_while(Result::ok) {
                let Some(time) = time_of(&record) else { continue };
                let row = row_of.get(&time.to_bits()).copied();
                let Some(&object) = place.get(&file.file.object(&record)) else { continue };
                let value = |quantity: usize| {
                    number(record.get(1 + file.file.words + quantity)).unwrap_or(f64::NAN)
                };
                if let Some(centres) = &mut of_rigid {
                    centres.advance(object, (time, row), value);
                }
                let Some(row) = row else { continue };
                for quantity in 0..wide {
                    out.columns[first + wide * object + quantity][row] = value(quantity) as f32;
                }
            }
            centres = of_rigid.or(centres);
        }
        for (object, columns) in centres.into_iter().flat_map(MassCentres::into_objects) {
            out.objects.push(object);
            out.columns.extend(columns);
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
        let of_files = self.objects.iter().filter(|object| object.kind != MASS_CENTRE).count();
        if of_files < self.existing {
            out.push(format!(
                "The plot workbench has {of_files} of the {} objects of the histories.",
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
        let h = ReportHistories::read(dir.path(), &[]);
        assert_eq!((h.rows, h.objects.len(), h.time[3]), (4, 3, 0.3));
        assert_eq!(h.objects[0].quantities[1], ["pairs".to_owned(), String::new()]);
        assert_eq!((h.objects[2].kind, h.objects[2].name.as_str()), ("node", "head 9"));
        assert_eq!(h.columns[0], [5.0, 4.0, 3.0, 2.0]);
        assert_eq!(h.columns[5][..3], [3.0, 5.0, 7.0]);
        assert!(h.columns[5][3].is_nan() && h.columns[3][2].is_nan());
        assert!(h.left_out().is_empty());
        assert_eq!(
            ReportHistories::read(tempfile::tempdir().unwrap().path(), &[]),
            ReportHistories::default()
        );
    }

    /// A rigid part that is stopped from 4 mm/ms within 2 ms, and goes back; the sum of trapezoids
    /// is exact for this motion. Its path has all rows, also those that the page leaves out.
    #[test]
    fn a_rigid_part_has_the_displacement_of_its_mass_centre() {
        let dir = tempfile::tempdir().unwrap();
        let mut history = String::from("time [ms],kinetic [J]\n");
        let mut parts = String::from(
            "time [ms],part,name,mass [kg],momentum x [kg mm/ms],momentum y [kg mm/ms],momentum z \
             [kg mm/ms]\n",
        );
        for i in 0..=30 {
            let t = 0.1 * f64::from(i);
            history += &format!("{t:.9e},1\n");
            let v = 4.0 - 2.0 * t;
            parts += &format!("{t:.9e},1,tube,1,0,0,9\n{t:.9e},12,ram,3,0,0,{:.9e}\n", 3.0 * v);
        }
        std::fs::write(dir.path().join("history.csv"), history).unwrap();
        std::fs::write(dir.path().join("parts.csv"), parts).unwrap();
        assert_eq!(ReportHistories::read(dir.path(), &[]).objects.len(), 3);
        let coarse = ReportHistories::with_limits(dir.path(), &[12], 40, 100);
        assert!(coarse.rows < 10 && coarse.left_out().len() == 1, "{:?}", coarse.left_out());
        for h in [ReportHistories::read(dir.path(), &[12]), coarse] {
            let last = h.objects.last().unwrap();
            assert_eq!((last.kind, last.name.as_str()), ("mass centre of part", "12 ram"));
            assert_eq!(last.quantities[2], ["displacement z".to_owned(), "mm".to_owned()]);
            for (t, z) in h.time().iter().zip(h.column(h.objects.len() - 1, 2)) {
                let exact = 4.0 * t - t * t;
                assert!((f64::from(*z) - exact).abs() < 1e-6, "single precision: {z} at {t}");
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_thinned_and_named() {
        let dir = folder();
        let h = ReportHistories::with_limits(dir.path(), &[], 8, 4);
        assert_eq!((h.objects.len(), h.rows), (2, 3), "rows 0, 2 and the last");
        assert_eq!(h.time, [0.0, 0.2, 0.3]);
        let said = h.left_out().join(" ");
        assert!(said.contains("3 of the 4 rows") && said.contains("2 of the 3 objects"), "{said}");
    }
}
