//! `crumple diff`: where the results of two runs part, and by how much. Histories are finest in
//! time; checkpoints name nodes and elements with all digits, fields with those of single
//! precision. With `--rerun`, both jobs run again until they part.

mod checkpoints;
mod fields;
mod histories;
mod rerun;

use crate::cli::DiffArgs;
use crate::results::provenance::Provenance;
use crate::stdout::{self, say};
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED, UNMET};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Largest number of quantities that are named where the results part.
const NAMED: usize = 8;

/// Cycle, if it is known, and simulated time [time].
type ResultMoment = (Option<u64>, f64);

/// A difference between two numbers, or two texts, of one quantity.
#[derive(Clone, Debug, PartialEq)]
struct Difference {
    /// The quantity, with its unit if the file has it.
    quantity: String,
    /// Where it is: a node, an element, a part, a time.
    place: String,
    /// Value of each run.
    values: [String; 2],
    /// Absolute difference; none for texts.
    by: Option<f64>,
}

impl Difference {
    /// Returns the difference of two numbers if they differ; `NaN` differs from all but `NaN`.
    fn between(quantity: &str, place: impl FnOnce() -> String, [a, b]: [f64; 2]) -> Option<Self> {
        if a == b || a.is_nan() && b.is_nan() {
            return None;
        }
        let values = [a, b].map(|value| format!("{value:e}"));
        let by = (a - b).abs();
        let by = Some(if by.is_nan() { f64::INFINITY } else { by });
        Some(Self { quantity: quantity.into(), place: place(), values, by })
    }
}

/// The first moment at which the results part.
#[derive(Clone, Debug, PartialEq)]
struct Parting {
    moment: ResultMoment,
    /// Last moment before at which they are equal.
    equal_until: Option<ResultMoment>,
    /// The differences.
    what: Vec<Difference>,
}

/// Comparison of one kind of files.
#[derive(Debug, Default)]
struct Comparison {
    /// Number of moments that both runs have.
    moments: usize,
    /// Number of moments that only one of them has.
    unpaired: usize,
    /// Last moment so far at which the results are equal.
    equal_until: Option<ResultMoment>,
    parting: Option<Parting>,
    /// Largest difference of each quantity.
    largest: BTreeMap<String, Difference>,
    /// Columns that are not compared, and why.
    notes: Vec<String>,
}

impl Comparison {
    /// Adds the differences of one moment that both runs have. Moments come in order of time.
    fn add(&mut self, moment: ResultMoment, found: Vec<Difference>) {
        self.moments += 1;
        for one in &found {
            let is_larger = |known: &Difference| one.by > known.by;
            if one.by.is_some() && self.largest.get(&one.quantity).is_none_or(is_larger) {
                let placed = Difference { place: at(&one.place, moment.1), ..one.clone() };
                self.largest.insert(one.quantity.clone(), placed);
            }
        }
        if found.is_empty() {
            self.equal_until = Some(moment);
        } else if self.parting.is_none() {
            let equal_until = self.equal_until;
            self.parting = Some(Parting { moment, equal_until, what: found });
        }
    }

    fn is_equal(&self) -> bool {
        self.parting.is_none()
    }
}

fn at(place: &str, time: f64) -> String {
    if place.is_empty() { format!("time {time:.6e}") } else { format!("{place}, time {time:.6e}") }
}

/// Compares two folders of results and prints where they part. Returns the exit code: 1 if they
/// differ.
pub fn run(args: &DiffArgs) -> u8 {
    match compare_and_rerun(args) {
        Ok(true) => COMPLETED,
        Ok(false) => UNMET,
        Err(problems) => {
            problems.iter().for_each(|why| eprintln!("error: {}", why.trim_end()));
            BAD_INPUT
        }
    }
}

/// Prints where the results part. Returns true if they are equal.
///
/// # Errors
/// The folders cannot be compared, or their runs cannot be repeated: the reasons.
fn compare_and_rerun(args: &DiffArgs) -> Result<bool, Vec<String>> {
    let (a, b) = (&args.first, &args.second);
    let compared = compare(a, b).map_err(|why| vec![why])?;
    stdout::write(format_args!("{}", compared.text));
    if args.rerun && compared.is_equal {
        say!("\nthe results are equal: nothing is run again");
    } else if args.rerun {
        let found = rerun::run([a, b], compared.differs_by)?;
        stdout::write(format_args!("{found}"));
    }
    Ok(compared.is_equal)
}

/// Comparison of two folders.
struct Compared {
    text: String,
    /// True if all that both folders have is equal.
    is_equal: bool,
    /// Cycle of the first row of the histories that differs.
    differs_by: Option<u64>,
}

fn compare(a: &Path, b: &Path) -> Result<Compared, String> {
    let folders = [a, b];
    if let Some(missing) = folders.iter().find(|folder| !folder.is_dir()) {
        return Err(format!(
            "there is no folder {}: give the folders of two runs",
            missing.display()
        ));
    }
    let kinds = [
        ("histories", histories::compare(folders)?),
        ("checkpoints", checkpoints::compare(folders)?),
        ("fields", fields::compare(folders)?),
    ];
    let summaries = folders.map(summary);
    if kinds.iter().all(|(_, kind)| kind.moments == 0) && summaries.iter().any(Option::is_none) {
        return Err(format!(
            "{} and {} have no results of the same moments: give the folders of two runs of one \
             job",
            a.display(),
            b.display()
        ));
    }
    let mut out = String::new();
    // Writing to a string cannot fail.
    for (folder, summary) in folders.iter().zip(&summaries) {
        let _ = writeln!(out, "{}: {}", folder.display(), ending(summary.as_ref()));
    }
    let [first, second] = summaries.each_ref().map(|summary| Some(&summary.as_ref()?["end_time"]));
    let end_together = first == second;
    let digests = summaries.map(|summary| digest(summary.as_ref()));
    let ends = match &digests {
        [Some(x), Some(y)] => Some(x == y),
        _ => None,
    };
    let verdict = match ends {
        Some(true) => "the final states are equal",
        Some(false) => "the final states differ",
        None => "at least one of the runs has no final state",
    };
    let _ = writeln!(out, "{verdict}");
    for line in inputs(folders) {
        let _ = writeln!(out, "{line}");
    }
    for (name, kind) in &kinds {
        describe(&mut out, name, kind);
    }
    largest(&mut out, &kinds);
    let differs_by = kinds[0].1.parting.as_ref().and_then(|parting| parting.moment.0);
    let is_equal = ends != Some(false) && kinds.iter().all(|(_, kind)| kind.is_equal());
    if ends == Some(false) && kinds.iter().all(|(_, kind)| kind.is_equal()) {
        out += match end_together {
            true => "\nno difference before the end: find it with --rerun\n",
            false => "\nno difference before the end of the shorter run\n",
        };
    }
    Ok(Compared { text: out, is_equal, differs_by })
}

fn summary(dir: &Path) -> Option<Value> {
    serde_json::from_slice(&std::fs::read(dir.join("summary.json")).ok()?).ok()
}

fn digest(summary: Option<&Value>) -> Option<String> {
    summary?["state_digest"].as_str().map(String::from)
}

fn ending(summary: Option<&Value>) -> String {
    let Some(s) = summary else { return "no summary.json: the run has not ended".into() };
    format!(
        "{} after {} cycles at time {:.6e}, state_digest {}",
        s["status"].as_str().unwrap_or("?"),
        s["cycles"],
        s["end_time"].as_f64().unwrap_or(f64::NAN),
        s["state_digest"].as_str().unwrap_or("?")
    )
}

/// Returns a line for each difference of program, changes and input files.
fn inputs(folders: [&Path; 2]) -> Vec<String> {
    let [a, b] = match folders.map(Provenance::read) {
        [Ok(a), Ok(b)] => [a, b],
        [Err(why), _] | [_, Err(why)] => return vec![format!("inputs are not compared: {why}")],
    };
    let (a, b) = (a.last(), b.last());
    let mut lines = Vec::new();
    let mut add = |what: &str, x: String, y: String| {
        if x != y {
            lines.push(format!("  {what}: {x} / {y}"));
        }
    };
    add("program", a.program(), b.program());
    add("machine", a.host.clone(), b.host.clone());
    add("workers", a.workers.to_string(), b.workers.to_string());
    let sets = |set: &[String]| if set.is_empty() { "none".into() } else { set.join(" ") };
    add("--set", sets(&a.set), sets(&b.set));
    let sum = |list: &[crate::results::provenance::InputFile], name: &Path| {
        let found = list.iter().find(|file| file.path.file_name() == name.file_name());
        found.map_or("not read".into(), |file| format!("sha256 {}", file.sha256))
    };
    let mut paths: Vec<&Path> = Vec::new();
    for file in a.files.iter().chain(&b.files) {
        if !paths.iter().any(|known| known.file_name() == file.path.file_name()) {
            paths.push(&file.path);
        }
    }
    for path in paths {
        add(&path.display().to_string(), sum(&a.files, path), sum(&b.files, path));
    }
    match lines.is_empty() {
        true => vec!["program, changes and input files are equal".into()],
        false => {
            ["the inputs differ (first / second):".to_string()].into_iter().chain(lines).collect()
        }
    }
}

fn describe(out: &mut String, name: &str, kind: &Comparison) {
    let others = match kind.unpaired {
        0 => String::new(),
        n => format!("; {n} moments are only in one of the folders"),
    };
    let _ = match (&kind.parting, kind.moments) {
        (None, 0) => writeln!(out, "\n{name}: no moment is in both folders{others}"),
        (None, n) => writeln!(out, "\n{name}: equal at {n} moments{others}"),
        (Some(parting), _) => writeln!(out, "\n{name}: first difference {}", named(parting)),
    };
    for note in &kind.notes {
        let _ = writeln!(out, "  {note}");
    }
    let what = kind.parting.as_ref().map_or(&[][..], |parting| &parting.what);
    what.iter().take(NAMED).for_each(|one| *out += &line(one));
    if what.len() > NAMED {
        let _ = writeln!(out, "  and {} more", what.len() - NAMED);
    }
}

/// Returns the line for a difference.
fn line(one: &Difference) -> String {
    let place = if one.place.is_empty() { String::new() } else { format!("{}: ", one.place) };
    format!("  {place}{} {} / {}\n", one.quantity, one.values[0], one.values[1])
}

fn named(parting: &Parting) -> String {
    let named = |(cycle, time): ResultMoment| match cycle {
        Some(cycle) => format!("cycle {cycle}, time {time:.6e}"),
        None => format!("time {time:.6e}"),
    };
    let before = match parting.equal_until {
        Some(moment) => format!("equal until {}", named(moment)),
        None => "no earlier moment is in both folders".into(),
    };
    format!("by {} ({before})", named(parting.moment))
}

fn largest(out: &mut String, kinds: &[(&str, Comparison)]) {
    if kinds.iter().all(|(_, kind)| kind.largest.is_empty()) {
        return;
    }
    let _ = writeln!(out, "\nlargest difference of each quantity (first / second)");
    for (name, kind) in kinds {
        for one in kind.largest.values() {
            let by = one.by.unwrap_or_default();
            let [a, b] = &one.values;
            let _ =
                writeln!(out, "  {name}: {}  {by:.3e}  ({a} / {b}) {}", one.quantity, one.place);
        }
    }
}

/// Returns the indices of the moments that both runs have. Times of rows follow the steps of a run:
/// after the runs have parted, those of one row differ by less than an interval. Where they differ
/// by more, the runs have different intervals, and only equal times are those of one moment.
fn paired(a: &[f64], b: &[f64]) -> Vec<(usize, usize)> {
    let spacing = |times: &[f64]| match times {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        _ => f64::INFINITY,
    };
    let interval = spacing(a).min(spacing(b));
    // The last row is at the end of a run, whatever its interval.
    let row = a.len().min(b.len()).saturating_sub(2);
    let drift = a.get(row).zip(b.get(row)).map_or(0.0, |(x, y)| (x - y).abs());
    let tolerance = if interval.is_finite() && drift < interval { 0.25 * interval } else { 0.0 };
    let (mut i, mut j, mut pairs) = (0, 0, Vec::new());
    while let (Some(x), Some(y)) = (a.get(i), b.get(j)) {
        if (x - y).abs() <= tolerance {
            pairs.push((i, j));
            (i, j) = (i + 1, j + 1);
        } else if x < y {
            i += 1;
        } else {
            j += 1;
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_paired_by_time_and_others_are_left_out() {
        assert_eq!(paired(&[0.0, 1.0, 2.0], &[0.0, 1.1, 2.05]), [(0, 0), (1, 1), (2, 2)]);
        assert_eq!(paired(&[0.0, 1.0, 2.0], &[0.0, 2.0, 4.0]), [(0, 0), (2, 1)]);
        assert_eq!(paired(&[1.0], &[1.0]), [(0, 0)]);
        let rows = |interval: f64| (0..=200).map(|i| f64::from(i) * interval).collect::<Vec<_>>();
        let of_others = paired(&rows(1.0), &rows(1.25));
        assert_eq!(of_others.len(), 41, "only rows at multiples of 5 are at equal times");
        assert_eq!(paired(&[1.0], &[1.5]), []);
    }

    #[test]
    fn a_difference_of_numbers_is_exact() {
        let between = |a, b| Difference::between("x", String::new, [a, b]);
        assert_eq!(between(1.0, 1.0), None);
        assert_eq!(between(f64::NAN, f64::NAN), None);
        assert_eq!(between(1.0, 1.0 + f64::EPSILON).unwrap().by, Some(f64::EPSILON));
        assert_eq!(between(1.0, f64::NAN).unwrap().by, Some(f64::INFINITY));
    }
}
