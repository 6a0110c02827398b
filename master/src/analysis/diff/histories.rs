//! Histories of two runs, row by row. Columns with times of the machine and counts of workers are
//! left out. So is what equal runs have differently if they have different intervals or ends:
//! means and extremes since another row, and the last row, whose energies are one step older.

use super::{Comparison, Difference, paired};
use crate::results::histories::NAMES;
use crate::results::history;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Rows of one time.
struct RowsAtTime {
    time: f64,
    /// Fields of each row, by the words that name what it belongs to.
    rows: BTreeMap<String, Vec<String>>,
}

/// A history file.
struct HistoryTable {
    /// Columns that are compared.
    columns: Vec<String>,
    times: Vec<RowsAtTime>,
}

/// Compares the histories that both folders have.
///
/// # Errors
/// A file is damaged; the message names it.
pub(super) fn compare(folders: [&Path; 2]) -> Result<Comparison, String> {
    let mut all = Comparison::default();
    let mut found: BTreeMap<usize, Vec<Difference>> = BTreeMap::new();
    let main = folders.map(|dir| dir.join(history::FILE));
    if !main.iter().all(|path| path.exists()) {
        return Ok(all);
    }
    let [a, b] = [HistoryTable::read(&main[0])?, HistoryTable::read(&main[1])?];
    let mut moments = paired(&a.all_times(), &b.all_times());
    all.unpaired = a.times.len() + b.times.len() - 2 * moments.len();
    let rows = moments.len();
    moments.retain(|&(i, j)| (i + 1 == a.times.len()) == (j + 1 == b.times.len()));
    if moments.len() < rows {
        let note = "left out: the last row of one of the runs, with energies and forces of the \
                    step before";
        all.notes.push(note.into());
    }
    let mut since_others = BTreeSet::new();
    let at_time = |time: f64| moments.iter().position(|&(i, _)| a.times[i].time == time);
    for name in [history::FILE].into_iter().chain(NAMES) {
        let paths = folders.map(|dir| dir.join(name));
        if !paths.iter().all(|path| path.exists()) {
            continue;
        }
        let [x, y] = [HistoryTable::read(&paths[0])?, HistoryTable::read(&paths[1])?];
        let pairs = paired(&x.all_times(), &y.all_times());
        for (k, &(i, j)) in pairs.iter().enumerate() {
            let Some(moment) = at_time(x.times[i].time) else { continue };
            let mut differences = x.differences(name, &y, (i, j));
            let have_same_interval = match k {
                0 => i == 0 && j == 0,
                _ => pairs[k - 1] == (i - 1, j - 1), // indices of pairs increase
            };
            if !have_same_interval {
                let (of_rows, kept): (Vec<_>, Vec<_>) =
                    differences.into_iter().partition(|one| history::is_since_row(&one.quantity));
                since_others.extend(of_rows.into_iter().map(|one| one.quantity));
                differences = kept;
            }
            found.entry(moment).or_default().extend(differences);
        }
    }
    if !since_others.is_empty() {
        let names: Vec<String> = since_others.into_iter().collect();
        all.notes.push(format!(
            "left out where the rows before have different times, because they cover the interval \
             between rows: {}",
            names.join(", ")
        ));
    }
    for (moment, &(i, _)) in moments.iter().enumerate() {
        let (cycle, time) = (a.cycle(i), a.times[i].time);
        let here = found.remove(&moment).unwrap_or_default();
        all.add((cycle, time), here);
    }
    Ok(all)
}

impl HistoryTable {
    fn read(path: &Path) -> Result<Self, String> {
        let named = |error: csv::Error| format!("{}: {error}", path.display());
        let mut reader = csv::Reader::from_path(path).map_err(named)?;
        let header: Vec<String> =
            reader.headers().map_err(named)?.iter().map(String::from).collect();
        let end = header.iter().position(|name| *name == history::ACCOUNTS[0]);
        let end = end.unwrap_or(header.len());
        // Words that name the row follow the time and have no unit; only files by kind have them.
        let is_word = |name: &&String| end == header.len() && !name.ends_with(']');
        let words = header.get(1..end).unwrap_or_default().iter().take_while(is_word).count();
        let mut times: Vec<RowsAtTime> = Vec::new();
        for row in reader.records() {
            let row = row.map_err(named)?;
            let field = |at: usize| row.get(at).unwrap_or_default();
            let Ok(time) = field(0).parse::<f64>() else { continue };
            if times.last().is_none_or(|last| last.time != time) {
                times.push(RowsAtTime { time, rows: BTreeMap::new() });
            }
            let key = (1..=words).map(|at| format!("{} {}", header[at], field(at)));
            let key = key.collect::<Vec<_>>().join(", ");
            let fields = [0].into_iter().chain(words + 1..end).map(|at| field(at).to_string());
            times.last_mut().expect("a row has a time").rows.insert(key, fields.collect());
        }
        let columns = [0].into_iter().chain(words + 1..end).map(|at| header[at].clone());
        Ok(Self { columns: columns.collect(), times })
    }

    fn all_times(&self) -> Vec<f64> {
        self.times.iter().map(|rows| rows.time).collect()
    }

    /// Returns the cycle of a row of `history.csv`.
    fn cycle(&self, at: usize) -> Option<u64> {
        let column = self.columns.iter().position(|name| name == "cycle")?;
        self.times[at].rows.values().next()?.get(column)?.parse().ok()
    }

    /// Returns the differences of the rows of one moment, in the columns that both tables have.
    fn differences(&self, file: &str, other: &Self, (i, j): (usize, usize)) -> Vec<Difference> {
        let mut found = Vec::new();
        let (own, others) = (&self.times[i].rows, &other.times[j].rows);
        for (key, row) in own {
            let Some(theirs) = others.get(key) else {
                found.push(missing(file, key, ["there", "missing"]));
                continue;
            };
            for (at, name) in self.columns.iter().enumerate() {
                let Some(place) = other.columns.iter().position(|known| known == name) else {
                    continue;
                };
                found.extend(difference(file, name, key, [&row[at], &theirs[place]]));
            }
        }
        let new = others.keys().filter(|key| !own.contains_key(*key));
        found.extend(new.map(|key| missing(file, key, ["missing", "there"])));
        found
    }
}

fn missing(file: &str, key: &str, values: [&str; 2]) -> Difference {
    Difference {
        quantity: format!("{file}: row"),
        place: key.into(),
        values: values.map(String::from),
        by: None,
    }
}

/// Returns the difference of two fields if their texts differ.
fn difference(file: &str, name: &str, key: &str, texts: [&String; 2]) -> Option<Difference> {
    if texts[0] == texts[1] {
        return None;
    }
    let is_number = name.ends_with(']') || ["cycle", "pairs"].contains(&name);
    let by = match texts.map(|text| text.parse::<f64>()) {
        [Ok(x), Ok(y)] if is_number => Some((x - y).abs()),
        _ => None,
    };
    Some(Difference {
        quantity: format!("{file}: {name}"),
        place: key.into(),
        values: texts.map(String::clone),
        by,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        dir
    }

    /// Equal runs with other intervals: both have rows at 0, 3 and 4, the end of the shorter one.
    /// The penetration and the force of a wall cover the interval before a row, and the last row of
    /// the shorter run has the energy of an earlier step.
    #[test]
    fn rows_of_other_intervals_have_no_difference_of_means_and_extremes() {
        let head = "time [ms],cycle,kinetic [J],penetration [fraction of contact thickness],\
                    floor impulse x [kg mm/ms],floor mean force x [kN],wall [s]\n";
        let walls = "time [ms],wall,mean force x [kN],displacement x [mm]\n";
        let folder = |rows: &str, of_wall: &str| {
            let rows = rows.replace('\n', ",0\n");
            folder(&[
                ("history.csv", &format!("{head}{rows}")),
                ("walls.csv", &format!("{walls}{of_wall}")),
            ])
        };
        let a = folder(
            "0,0,5,0,0,0\n1,10,4,0.5,1,1\n2,20,3,0.1,2,1\n3,30,3,0.2,2,0\n4,40,2,0,2,0\n",
            "0,floor,0,0\n1,floor,1,0\n2,floor,1,0\n3,floor,0,7\n4,floor,0,7\n",
        );
        let b = folder(
            "0,0,5,0,0,0\n1.5,15,4,0.5,1,0.7\n3,30,3,0.3,2,0.7\n4,40,1.9,0,2,0\n6,60,1,0,2,0\n",
            "0,floor,0,0\n1.5,floor,0.7,0\n3,floor,0.7,7\n4,floor,0,7\n6,floor,0,7\n",
        );
        let found = compare([a.path(), b.path()]).unwrap();
        assert!(found.is_equal() && found.moments == 2, "{found:?}");
        assert!(found.notes[0].contains("the last row of one of the runs"), "{:?}", found.notes);
        for left_out in ["history.csv: penetration", "history.csv: floor mean", "walls.csv: mean"] {
            assert!(found.notes[1].contains(left_out), "{:?}", found.notes);
        }
        let other = folder(
            "0,0,5,0,0,0\n1,10,4,0.5,1,1\n2,20,3,0.1,2,1\n3,30,3,0.25,2,0\n4,40,2,0,2,0\n",
            "0,floor,0,0\n1,floor,1,0\n2,floor,1,0\n3,floor,0,7\n4,floor,0,7\n",
        );
        let found = compare([a.path(), other.path()]).unwrap();
        assert_eq!(found.parting.unwrap().moment, (Some(30), 3.0), "equal intervals are compared");
    }

    #[test]
    fn the_first_row_that_differs_and_the_largest_difference_are_found() {
        let head = "time [ms],cycle,kinetic [J],controlling element,wall [s]\n";
        let parts = "time [ms],part,name,mass [kg]\n";
        let a = folder(&[
            ("history.csv", &format!("{head}0,0,5,7,0\n1,9,4,7,0.1\n2,20,3,7,0.2\n3,30,2,7,0.3\n")),
            ("parts.csv", &format!("{parts}0,1,a,1\n1,1,a,1\n2,1,a,1\n2,2,b,2\n3,1,a,1\n")),
        ]);
        let b = folder(&[
            ("history.csv", &format!("{head}0,0,5,7,9\n1,9,4,7,9\n2,20,3,8,9\n3.1,31,1.5,7,9\n")),
            ("parts.csv", &format!("{parts}0,1,a,1\n1,1,a,1\n2,1,a,1\n2,2,b,2.5\n3.1,1,a,1\n")),
        ]);
        let found = compare([a.path(), b.path()]).unwrap();
        assert_eq!((found.moments, found.unpaired), (4, 0));
        let parting = found.parting.unwrap();
        assert_eq!(parting.moment, (Some(20), 2.0));
        assert_eq!(parting.equal_until, Some((Some(9), 1.0)));
        assert_eq!(parting.what.len(), 2, "{:?}", parting.what);
        assert_eq!(parting.what[1].place, "part 2, name b");
        let largest = &found.largest["history.csv: kinetic [J]"];
        assert_eq!((largest.by, &largest.place[..]), (Some(0.5), "time 3.000000e0"));
        let same = compare([a.path(), a.path()]).unwrap();
        assert!(same.is_equal() && same.moments == 4);
    }
}
