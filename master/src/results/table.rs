//! Tables that grow with a run, as CSV files: a new one, or that of a run that continues. A file
//! that was removed or shortened meanwhile begins again, and the run goes on.

use crate::results::histories::NAMES;
use crate::results::{history, workers};
use csv::ByteRecord;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Seek, SeekFrom};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Mark of a file that was shorter than at the checkpoint; it stays next to the one that begins
/// again.
const SHORT: &str = "short";

/// A file that cannot be written, and the reason.
pub(crate) type Unwritten = (PathBuf, io::Error);

/// A table that is being written.
pub(crate) struct CsvTable {
    path: PathBuf,
    header: ByteRecord,
    writer: csv::Writer<File>,
}

impl CsvTable {
    /// Begins a file with its header.
    fn create(path: PathBuf, header: ByteRecord) -> Result<Self, Unwritten> {
        let failed = |error: io::Error| (path.clone(), error);
        let file = File::create(&path).map_err(failed)?;
        let mut writer = csv::Writer::from_writer(file);
        writer.write_byte_record(&header).map_err(|error| failed(error.into()))?;
        writer.flush().map_err(failed)?;
        Ok(Self { path, header, writer })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn write_record<T: AsRef<[u8]>>(
        &mut self,
        row: impl IntoIterator<Item = T>,
    ) -> csv::Result<()> {
        self.writer.write_record(row)
    }

    /// Hands all rows to the operating system.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// Makes the file and its folder again if they were removed. Returns the path if that was
    /// necessary: all rows so far are lost. Call it before rows are added.
    ///
    /// # Errors
    /// The file cannot be made.
    pub(crate) fn check(&mut self) -> io::Result<Option<PathBuf>> {
        let own = self.writer.get_ref().metadata()?;
        let is_own =
            |there: &std::fs::Metadata| (there.dev(), there.ino()) == (own.dev(), own.ino());
        match std::fs::metadata(&self.path) {
            Ok(there) if is_own(&there) => return Ok(None),
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let again = Self::create(self.path.clone(), self.header.clone());
        *self = again.map_err(|(_, error)| error)?;
        Ok(Some(self.path.clone()))
    }
}

/// The tables of a run, and the rows that they keep.
#[derive(Clone, Copy)]
pub struct Tables<'a> {
    /// Folder of the files.
    pub dir: &'a Path,
    /// Length to keep of each file, if the run continues from a checkpoint [byte].
    pub lengths: Option<&'a BTreeMap<String, u64>>,
}

impl Tables<'_> {
    /// Opens a file: a new one with this header, or the one of the run that continues, without the
    /// rows after the checkpoint.
    pub(crate) fn open<H: AsRef<[u8]>>(
        &self,
        name: &str,
        header: impl IntoIterator<Item = H>,
    ) -> Result<CsvTable, Unwritten> {
        let path = self.dir.join(name);
        let header = header.into_iter().collect();
        let Some(&length) = self.lengths.and_then(|lengths| lengths.get(name)) else {
            return CsvTable::create(path, header);
        };
        let failed = |error: io::Error| (path.clone(), error);
        let mut file = File::options().write(true).open(&path).map_err(failed)?;
        file.set_len(length).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        Ok(CsvTable { path, header, writer: csv::Writer::from_writer(file) })
    }

    /// Returns true for the name of a file that grows with the run.
    pub(crate) fn is_one(name: &str) -> bool {
        Self::names().any(|known| known == name)
    }

    fn names() -> impl Iterator<Item = &'static str> {
        NAMES.into_iter().chain([history::FILE, workers::FILE])
    }

    /// Returns the present length of each file.
    pub(crate) fn present(dir: &Path) -> BTreeMap<String, u64> {
        let length = |name: &str| std::fs::metadata(dir.join(name)).ok().map(|m| m.len());
        Self::names().filter_map(|name| Some((name.to_string(), length(name)?))).collect()
    }

    /// Removes from `lengths` the files that were removed or shortened since the checkpoint of
    /// `time`, so that they begin again. Keeps a shortened file under another name. Returns a
    /// warning for each.
    pub(crate) fn take_lost(
        dir: &Path,
        lengths: &mut BTreeMap<String, u64>,
        time: f64,
    ) -> Vec<String> {
        let mut warnings = Vec::new();
        lengths.retain(|name, length| {
            let path = dir.join(name);
            let there = std::fs::metadata(&path).ok().map(|m| m.len());
            if there.is_some_and(|there| there >= *length) {
                return true;
            }
            let kept = there.map(|_| dir.join(format!("{name}.{SHORT}")));
            let kept = kept.filter(|kept| std::fs::rename(&path, kept).is_ok());
            let kept =
                kept.map_or(String::new(), |kept| format!("; {} has the rest", kept.display()));
            warnings.push(format!(
                "{} was removed or shortened after the checkpoint: its rows until time {time:.6e} \
                 are lost, and it begins again with its header{kept}",
                path.display()
            ));
            false
        });
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_removed_table_begins_again_with_its_header() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        std::fs::create_dir(&out).unwrap();
        let tables = Tables { dir: &out, lengths: None };
        let mut table = tables.open("nodes.csv", ["time", "x"]).unwrap();
        let mut add = |row: [&str; 2]| {
            let lost = table.check().unwrap();
            table.write_record(row).unwrap();
            table.flush().unwrap();
            (lost, std::fs::read_to_string(out.join("nodes.csv")).unwrap())
        };
        assert_eq!(add(["0", "1"]), (None, "time,x\n0,1\n".into()));
        std::fs::remove_dir_all(&out).unwrap();
        assert_eq!(add(["1", "2"]), (Some(out.join("nodes.csv")), "time,x\n1,2\n".into()));
        std::fs::rename(out.join("nodes.csv"), out.join("other.csv")).unwrap();
        std::fs::write(out.join("nodes.csv"), "of another program").unwrap();
        assert_eq!(add(["2", "3"]), (Some(out.join("nodes.csv")), "time,x\n2,3\n".into()));
    }

    #[test]
    fn a_missing_or_shorter_table_is_named_and_the_others_are_kept() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        write("nodes.csv", "time\n0\n");
        write("parts.csv", "time\n0\n1\n");
        let names = ["nodes.csv", "parts.csv", "walls.csv"];
        let mut lengths: BTreeMap<String, u64> =
            names.iter().map(|name| (name.to_string(), 9)).collect();
        let lost = Tables::take_lost(dir.path(), &mut lengths, 0.5);
        assert_eq!(lengths.keys().collect::<Vec<_>>(), ["parts.csv"]);
        assert!(lost.len() == 2 && lost[0].contains("nodes.csv.short"), "{lost:?}");
        assert!(lost[1].contains("walls.csv") && lost[1].contains("5.000000e-1"), "{lost:?}");
    }
}
