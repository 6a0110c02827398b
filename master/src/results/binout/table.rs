//! Reads the histories of a run as objects over time.

use std::collections::HashMap;
use std::path::Path;

/// A history: rows by time, and the objects to which they belong.
pub struct ObjectHistory {
    file: String,
    /// Names of the columns without units.
    columns: Vec<String>,
    /// Columns that name the object of a row.
    words: Vec<usize>,
    /// Words of each object, in the order in which they appear first.
    pub objects: Vec<Vec<String>>,
    /// Instants, in the order of the file.
    pub instants: Vec<HistoryInstant>,
}

/// Rows of one time.
pub struct HistoryInstant {
    /// Time as in the file, by which rows of several files are joined.
    pub text: String,
    /// Time [time].
    pub time: f64,
    /// Row of each object; none if it has none at this time.
    rows: Vec<Option<csv::StringRecord>>,
}

impl ObjectHistory {
    /// Reads a file whose rows belong to the objects that the columns `words` name; without words,
    /// each row is an instant of one object. Returns none if there is no such file.
    ///
    /// # Errors
    /// The file is damaged or lacks a column; the message names it.
    pub fn read(path: &Path, words: &[&str]) -> Result<Option<Self>, String> {
        if !path.is_file() {
            return Ok(None);
        }
        let file = path.display().to_string();
        let cannot = |error: csv::Error| format!("{file}: {error}");
        let mut reader = csv::Reader::from_path(path).map_err(cannot)?;
        let bare = |head: &str| head.split(" [").next().unwrap_or_default().to_string();
        let columns = reader.headers().map_err(cannot)?.iter().map(bare).collect();
        let mut history =
            Self { file, columns, words: Vec::new(), objects: Vec::new(), instants: Vec::new() };
        history.words = words.iter().map(|word| history.column(word)).collect::<Result<_, _>>()?;
        let time = history.column("time")?;
        let mut places: HashMap<Vec<String>, usize> = HashMap::new();
        for record in reader.records() {
            let record = record.map_err(|error| format!("{}: {error}", history.file))?;
            history.add(record, time, &mut places)?;
        }
        Ok(Some(history))
    }

    fn add(
        &mut self,
        record: csv::StringRecord,
        time: usize,
        places: &mut HashMap<Vec<String>, usize>,
    ) -> Result<(), String> {
        let key: Vec<String> = self.words.iter().map(|&word| record[word].to_string()).collect();
        let place = *places.entry(key.clone()).or_insert(self.objects.len());
        if place == self.objects.len() {
            self.objects.push(key);
        }
        // An object has one row at a time.
        let belongs = |last: &HistoryInstant| {
            last.text == record[time] && last.rows.get(place).is_none_or(Option::is_none)
        };
        if !self.instants.last().is_some_and(belongs) {
            let number = record[time].parse::<f64>();
            let time_of =
                number.map_err(|_| format!("{}: `{}` is not a time", self.file, &record[time]))?;
            let text = record[time].to_string();
            self.instants.push(HistoryInstant { text, time: time_of, rows: Vec::new() });
        }
        if let Some(last) = self.instants.last_mut() {
            last.rows.resize(last.rows.len().max(place + 1), None);
            last.rows[place] = Some(record);
        }
        Ok(())
    }

    /// Adds the instants of `other` that this history lacks, without rows.
    pub fn fill(&mut self, other: &Self) {
        let mut own = std::mem::take(&mut self.instants).into_iter().peekable();
        for one in &other.instants {
            let there = own.next_if(|own| own.text == one.text);
            let empty = || HistoryInstant { rows: Vec::new(), text: one.text.clone(), ..*one };
            self.instants.push(there.unwrap_or_else(empty));
        }
    }

    /// Returns the index of a column.
    ///
    /// # Errors
    /// There is no such column.
    pub fn column(&self, name: &str) -> Result<usize, String> {
        let place = self.columns.iter().position(|column| column == name);
        place.ok_or_else(|| format!("{}: there is no column `{name}`", self.file))
    }

    /// Returns the values of a column for the objects `of`, by their indices, at an instant.
    /// `absent` stands for the value of an object without a row.
    ///
    /// # Errors
    /// A value is not a number.
    pub fn values(
        &self,
        instant: &HistoryInstant,
        column: usize,
        (of, absent): (&[usize], f64),
    ) -> Result<Vec<f64>, String> {
        let value = |&place: &usize| match instant.rows.get(place) {
            Some(Some(row)) => row[column].parse::<f64>().map_err(|_| {
                let name = &self.columns[column];
                format!("{}: `{}` is no number of `{name}`", self.file, &row[column])
            }),
            _ => Ok(absent),
        };
        of.iter().map(value).collect()
    }
}
