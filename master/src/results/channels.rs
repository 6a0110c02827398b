//! Histories of single objects, such as a node or a wall: their names before a run, their values
//! after it, and filters of these values.

use super::figures::{seconds, signal};
use super::histories::{self, file_name};
use crate::input::job::{Model, nearest};
use crumple_proto::job::{FilterClass, ObjectTable};
use std::collections::HashSet;
use std::path::Path;

/// Most entries of one name that a message lists.
const LISTED: usize = 40;
/// Distance of two nodes, as a column.
const DISTANCE: &str = "distance";
/// Distance of two nodes minus that in the first row, as a column.
const CHANGE: &str = "distance change";
const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the message for an unknown name, with the nearest one and those that exist.
pub fn unknown(file: &str, path: &str, key: &str, there: &[String]) -> String {
    let within = if path == key { String::new() } else { format!(" (in `{path}`)") };
    let there: Vec<&str> = there.iter().map(String::as_str).collect();
    format!("{file} has no `{key}`{within}; {}", nearest(key, &there))
}

/// Returns the name of a column without its unit.
pub fn bare(column: &str) -> &str {
    column.split(" [").next().unwrap_or(column)
}

/// Returns the unit of a column; empty without one.
pub fn unit(column: &str) -> &str {
    let unit = column.split_once(" [").and_then(|(_, rest)| rest.strip_suffix(']'));
    unit.filter(|unit| *unit != "-").unwrap_or("")
}

/// Returns the reason why histories with this unit of time and this interval [time] cannot be
/// filtered, if there is one.
pub fn filter_error(class: FilterClass, unit_of_time: &str, interval: f64) -> Option<String> {
    match seconds(unit_of_time) {
        Some(second) => signal::too_coarse(second * interval, class.hertz()),
        None => Some(
            "a filter needs a known unit of time: set `units` of the job, such as \
             units = \"mm, ms, kg\""
                .into(),
        ),
    }
}

/// A file with one row per object and time: its columns and its objects.
#[derive(Clone, Debug)]
pub struct ObjectFile {
    table: ObjectTable,
    /// Names of the columns with their units.
    head: Vec<String>,
    /// Words that name each object.
    objects: Vec<Vec<String>>,
}

/// Columns for a quantity.
#[derive(Clone, Debug, PartialEq)]
enum Choice {
    /// One column, or the components of a vector.
    Columns(Vec<usize>),
    /// Coordinates, for the distance of two nodes; with `true` minus that of the first row.
    Distance(Vec<usize>, bool),
}

impl ObjectFile {
    /// Returns the file in a run of a job.
    ///
    /// # Errors
    /// The run will not have it.
    pub fn of_job(model: &Model, table: ObjectTable) -> Result<Self, String> {
        if histories::is_written(model, table) {
            let (head, objects) = (histories::head(model, table), histories::objects(model, table));
            return Ok(Self { table, head, objects });
        }
        let cure = match table {
            ObjectTable::Nodes => "add an [[output.node]] with the node",
            ObjectTable::Parts => "set output.parts = true",
            ObjectTable::Sections => "add an [[output.section]]",
            ObjectTable::Transducers => "add an [[output.transducer]]",
            ObjectTable::Walls if model.settings.walls.is_empty() => "it has no [[wall]]",
            ObjectTable::Walls => "set output.walls = true",
            ObjectTable::Contacts => "it needs contact of several parts, and output.contacts",
            ObjectTable::Airbags => "it has no [[airbag]]",
            ObjectTable::Belts => "it has no part with [part.belt]",
        };
        Err(format!("the job writes no {}: {cure}", file_name(table)))
    }

    /// Returns the file of a run in `folder`.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn of_run(folder: &Path, table: ObjectTable) -> Result<Self, String> {
        let path = folder.join(file_name(table));
        let cannot = |error: csv::Error| format!("{}: {error}", path.display());
        let mut reader = csv::Reader::from_path(&path).map_err(cannot)?;
        let head = reader.headers().map_err(cannot)?.iter().map(String::from).collect();
        let (mut objects, mut known) = (Vec::new(), HashSet::new());
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).map_err(cannot)? {
            let object = words(&record, table);
            if known.insert(object.join(",")) {
                objects.push(object.into_iter().map(String::from).collect());
            }
        }
        Ok(Self { table, head, objects })
    }

    /// Returns the words of the object that `of` names.
    fn object(&self, of: &str) -> Result<&[String], String> {
        let is_named = |words: &&Vec<String>| {
            words.iter().any(|word| word == of) || (words.len() > 1 && words.join(" ") == of)
        };
        let named: Vec<&Vec<String>> = self.objects.iter().filter(is_named).collect();
        match named[..] {
            [one] => Ok(one),
            [] => {
                let labels: Vec<String> = self.objects.iter().map(|o| self.label(o)).collect();
                Err(unknown(file_name(self.table), of, of, &labels))
            }
            [first, ..] if named.iter().all(|words| *words == first) => {
                Err(format!("{} entries have the name `{of}`: rename them", named.len()))
            }
            _ => {
                let several: Vec<String> =
                    named.iter().take(LISTED).map(|words| words.join(" ")).collect();
                let count = named.len();
                Err(format!("`{of}` names {count} entries: name one of: {}", several.join(", ")))
            }
        }
    }

    /// Returns the shortest name of an object that is its own.
    fn label(&self, words: &[String]) -> String {
        let is_own =
            |word: &String| self.objects.iter().filter(|o| o.contains(word)).take(2).count() == 1;
        let name = match self.table {
            ObjectTable::Parts | ObjectTable::Contacts => words.last(),
            _ => words.first(),
        };
        match name.filter(|name| !name.is_empty() && is_own(name)) {
            Some(name) => name.clone(),
            None => words.join(" ").trim_end().into(),
        }
    }

    fn choose(&self, column: &str, is_relative: bool) -> Result<Choice, String> {
        let first = 1 + histories::words(self.table);
        let names: Vec<&str> = self.head.iter().skip(first).map(|name| bare(name)).collect();
        let place = |name: &str| names.iter().position(|other| *other == name).map(|at| first + at);
        let vector = |name: &str| -> Option<Vec<usize>> {
            AXES.iter().map(|axis| place(&format!("{name} {axis}"))).collect()
        };
        let has_distance = is_relative && self.table == ObjectTable::Nodes;
        if has_distance && (column == DISTANCE || column == CHANGE) {
            let places: Option<Vec<usize>> = AXES.iter().map(|axis| place(axis)).collect();
            if let Some(places) = places {
                return Ok(Choice::Distance(places, column == CHANGE));
            }
        }
        let whole = self.head.iter().skip(first).position(|name| name == column);
        if let Some(at) = whole.map(|at| first + at).or_else(|| place(column)) {
            return Ok(Choice::Columns(vec![at]));
        }
        vector(column).map(Choice::Columns).ok_or_else(|| {
            let bases = names.iter().filter_map(|name| name.strip_suffix(" x"));
            let distances = if has_distance { &[DISTANCE, CHANGE][..] } else { &[] };
            let all = names.iter().copied().chain(bases).chain(distances.iter().copied());
            let all: Vec<String> = all.map(String::from).collect();
            unknown(file_name(self.table), column, column, &all)
        })
    }

    /// Returns the key of a wrong name and the reason, if any.
    pub fn wrong_name(
        &self,
        of: &str,
        relative_to: Option<&str>,
        column: &str,
    ) -> Option<(&'static str, String)> {
        let object = |key: &'static str, name: &str| self.object(name).err().map(|why| (key, why));
        object("of", of)
            .or_else(|| relative_to.and_then(|name| object("relative_to", name)))
            .or_else(|| {
                self.choose(column, relative_to.is_some()).err().map(|why| ("history", why))
            })
    }

    /// Reads a quantity of the object `of`, or its difference from that of another object.
    ///
    /// # Errors
    /// A name is not there, or the file is damaged.
    pub fn read(
        &self,
        folder: &Path,
        of: &str,
        relative_to: Option<&str>,
        column: &str,
    ) -> Result<Channels, String> {
        let choice = self.choose(column, relative_to.is_some())?;
        let (Choice::Columns(places) | Choice::Distance(places, _)) = &choice;
        let mut rows = self.rows(folder, self.object(of)?, places)?;
        if let Some(other) = relative_to {
            rows = differences(rows, self.rows(folder, self.object(other)?, places)?);
        }
        if rows.is_empty() {
            return Err(format!("{} has no row of `{of}`", file_name(self.table)));
        }
        let mut channels: Vec<Vec<f64>> =
            (0..places.len()).map(|c| rows.iter().map(|row| row.1[c]).collect()).collect();
        if let Choice::Distance(_, is_change) = choice {
            let distances: Vec<f64> = (0..rows.len()).map(|row| size(&channels, row)).collect();
            let start = if is_change { distances[0] } else { 0.0 };
            channels = vec![distances.iter().map(|distance| distance - start).collect()];
        }
        Ok(Channels {
            times: rows.iter().map(|row| row.0).collect(),
            channels,
            unit: unit(&self.head[places[0]]).into(),
            unit_of_time: unit(&self.head[0]).into(),
        })
    }

    /// Reads time and values of each row of an object. A field without a number is NaN.
    fn rows(
        &self,
        folder: &Path,
        object: &[String],
        places: &[usize],
    ) -> Result<Vec<(f64, Vec<f64>)>, String> {
        let path = folder.join(file_name(self.table));
        let cannot = |error: csv::Error| format!("{}: {error}", path.display());
        let mut reader = csv::Reader::from_path(&path).map_err(cannot)?;
        let mut rows = Vec::new();
        let mut record = csv::StringRecord::new();
        let number =
            |field: Option<&str>| field.and_then(|field| field.parse().ok()).unwrap_or(f64::NAN);
        while reader.read_record(&mut record).map_err(cannot)? {
            if words(&record, self.table) == *object {
                let values = places.iter().map(|&at| number(record.get(at))).collect();
                rows.push((number(record.get(0)), values));
            }
        }
        Ok(rows)
    }
}

/// Returns the words of the object of a row.
fn words(record: &csv::StringRecord, table: ObjectTable) -> Vec<&str> {
    record.iter().skip(1).take(histories::words(table)).collect()
}

/// Returns the differences of two objects at the times of both.
fn differences(one: Vec<(f64, Vec<f64>)>, other: Vec<(f64, Vec<f64>)>) -> Vec<(f64, Vec<f64>)> {
    let mut other = other.into_iter().peekable();
    let difference = |(time, values): (f64, Vec<f64>)| {
        while other.next_if(|row| row.0 < time).is_some() {}
        let (_, minus) = other.next_if(|row| row.0 == time)?;
        Some((time, values.iter().zip(&minus).map(|(a, b)| a - b).collect()))
    };
    one.into_iter().filter_map(difference).collect()
}

/// Returns the value of a row: that of the only channel, or the magnitude of all.
fn size(channels: &[Vec<f64>], row: usize) -> f64 {
    match channels {
        [one] => one[row],
        all => all.iter().map(|channel| channel[row].powi(2)).sum::<f64>().sqrt(),
    }
}

/// A quantity over time: one channel, or the components of a vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Times [time].
    pub times: Vec<f64>,
    /// Values of each channel.
    pub channels: Vec<Vec<f64>>,
    /// Unit of the values; empty without one.
    pub unit: String,
    /// Unit of the times.
    pub unit_of_time: String,
}

impl Channels {
    /// Returns time and value of each row, after a filter of each channel.
    ///
    /// # Errors
    /// The filter needs more rows or a known unit of time.
    pub fn curve(self, filter: Option<FilterClass>) -> Result<Vec<[f64; 2]>, String> {
        let Self { mut times, mut channels, unit_of_time, .. } = self;
        if let Some(class) = filter {
            let is_whole = |row: &usize| channels.iter().all(|channel| channel[*row].is_finite());
            let kept: Vec<usize> = (0..times.len()).filter(is_whole).collect();
            times = kept.iter().map(|&row| times[row]).collect();
            let span = times.last().zip(times.first()).map_or(f64::NAN, |(end, from)| end - from);
            let interval = span / times.len().saturating_sub(1) as f64;
            if let Some(why) = filter_error(class, &unit_of_time, interval) {
                return Err(why);
            }
            let second = seconds(&unit_of_time).unwrap_or(f64::NAN);
            let in_seconds: Vec<f64> = times.iter().map(|time| second * time).collect();
            let filtered = |channel: &Vec<f64>| {
                let values: Vec<f64> = kept.iter().map(|&row| channel[row]).collect();
                signal::filtered(&in_seconds, &values, class.hertz())
            };
            channels = channels.iter().map(filtered).collect::<Result<_, _>>()?;
        }
        Ok(times.iter().enumerate().map(|(row, time)| [*time, size(&channels, row)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::fmt::Write;

    /// Writes two nodes `head` and `foot`, and a group `rail` of two nodes. The head oscillates at
    /// 300 Hz in x with the amplitude 2 and in y with 1.5; its distance from the foot falls from 50
    /// to 40.
    fn nodes() -> (tempfile::TempDir, ObjectFile) {
        let folder = tempfile::tempdir().unwrap();
        let mut text = String::from(
            "time [ms],nodes,id,x [mm],y [mm],z [mm],acceleration x [mm/ms^2],\
             acceleration y [mm/ms^2],acceleration z [mm/ms^2]\n",
        );
        for i in 0..=10_000 {
            let t = f64::from(i) * 0.01;
            let wave = (TAU * 0.3 * t).sin();
            let fall = 0.1 * t;
            writeln!(text, "{t:.9e},head,7,30,40,0,{},{},0", 2.0 * wave, 1.5 * wave).unwrap();
            writeln!(text, "{t:.9e},foot,8,{},{},0,0,0,0", 0.6 * fall, 0.8 * fall).unwrap();
            writeln!(text, "{t:.9e},rail,9,0,0,0,0,0,0\n{t:.9e},rail,11,0,0,0,0,0,0").unwrap();
        }
        std::fs::write(folder.path().join("nodes.csv"), text).unwrap();
        let file = ObjectFile::of_run(folder.path(), ObjectTable::Nodes).unwrap();
        (folder, file)
    }

    fn peak(curve: &[[f64; 2]]) -> f64 {
        // Away from the ends, where a wave is cut off.
        curve[2000..8000].iter().fold(0.0, |most, row| most.max(row[1].abs()))
    }

    /// CFC 180 has the gain -3 dB at 300 Hz, for a component and for the magnitude of a vector.
    #[test]
    fn a_filter_acts_on_the_components_of_a_vector() {
        let (folder, file) = nodes();
        let read = |column: &str| file.read(folder.path(), "head", None, column).unwrap();
        let half = 0.5f64.sqrt();
        for (column, size) in [("acceleration x", 2.0), ("acceleration", 2.5)] {
            let plain = peak(&read(column).curve(None).unwrap());
            let smooth = peak(&read(column).curve(Some(FilterClass::Cfc180)).unwrap());
            // 333 rows per period; the corridor of the standard is wider.
            assert!((plain / size - 1.0).abs() < 1e-4, "{column}: {plain}");
            assert!((smooth / (size * half) - 1.0).abs() < 5e-3, "{column}: {smooth}");
        }
        assert_eq!(read("acceleration x [mm/ms^2]").unit, "mm/ms^2");
        let why = Channels { unit_of_time: "time".into(), ..read("x") };
        assert!(why.curve(Some(FilterClass::Cfc60)).unwrap_err().contains("set `units`"));
    }

    #[test]
    fn two_nodes_have_a_distance_and_differences() {
        let (folder, file) = nodes();
        let read = |column: &str| {
            let channels = file.read(folder.path(), "7", Some("foot 8"), column).unwrap();
            (channels.unit.clone(), channels.curve(None).unwrap())
        };
        let (unit, distance) = read("distance");
        assert_eq!((unit.as_str(), distance[0]), ("mm", [0.0, 50.0]));
        let (_, change) = read("distance change");
        // Both nodes are on one line through the origin; ten digits in the file.
        assert!((change[10_000][1] + 10.0).abs() < 1e-9, "{:?}", change[10_000]);
        assert!((read("x").1[5000][1] - 27.0).abs() < 1e-9);
    }

    #[test]
    fn wrong_names_are_answered_with_those_that_exist() {
        let (_folder, file) = nodes();
        let why = |of: &str, relative_to: Option<&str>, column: &str| {
            file.wrong_name(of, relative_to, column).unwrap_or_default()
        };
        assert_eq!(why("head", None, "acceleration"), ("", String::new()));
        let (key, text) = why("haed", None, "x");
        assert!(key == "of" && text.contains("did you mean `head`? known: head, foot, rail 9"));
        let (key, text) = why("rail", None, "x");
        assert!(key == "of" && text.contains("names 2 entries: name one of: rail 9, rail 11"));
        let (key, text) = why("head", Some("fot"), "x");
        assert!(key == "relative_to" && text.contains("did you mean `foot`?"), "{text}");
        let (key, text) = why("head", None, "aceleration");
        assert!(key == "history" && text.contains("did you mean `acceleration`?"), "{text}");
        assert!(why("head", None, "distance").1.contains("has no `distance`"));
        assert_eq!(why("head", Some("foot"), "distance"), ("", String::new()));
    }
}
