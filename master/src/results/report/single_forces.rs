//! Plots of forces on single objects: parts in contact (`contacts.csv`), force transducers
//! (`transducers.csv`) and sections (`sections.csv`). These files have one row per object and
//! time: the time, the name of the object, `force x`, `force y`, `force z`, and other columns.

use super::plots::{Plot, PlotLine, named};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Files, titles and notes of the plots.
const KINDS: [[&str; 3]; 3] = [
    [
        "contacts.csv",
        "Contact forces on parts",
        "Magnitude of the force on each part, in that cycle.",
    ],
    [
        "transducers.csv",
        "Force transducers",
        "Magnitude of the contact force on each surface, in that cycle.",
    ],
    ["sections.csv", "Forces of sections", "Magnitude of the force on one side of each section."],
];
/// Maximum number of lines of a plot. If there are more objects, those with the largest forces
/// are shown.
const MOST_LINES: usize = 8;

/// Returns a plot for each of the existing files, over the times of the history.
pub fn plots(dir: &Path, time: &[f64], problems: &mut Vec<String>) -> Vec<Plot> {
    let mut plots = Vec::new();
    for [file, title, note] in KINDS {
        let path = dir.join(file);
        if !path.exists() {
            continue;
        }
        match read(&path, time) {
            Ok((unit, lines)) => {
                let all = lines.len();
                let shown: Vec<PlotLine> = lines.into_iter().take(MOST_LINES).collect();
                let mut note = note.to_owned();
                if shown.len() < all {
                    note += &format!(" The {} largest of {all}.", shown.len());
                }
                if !shown.is_empty() {
                    plots.push(Plot { title: title.into(), unit, note, lines: shown });
                }
            }
            Err(why) => problems.push(format!("{}: {why}", path.display())),
        }
    }
    plots
}

/// Returns unit and lines, those with the largest forces first. Objects without any force are
/// omitted.
fn read(path: &Path, time: &[f64]) -> Result<(String, Vec<PlotLine>), String> {
    let mut reader =
        csv::ReaderBuilder::new().flexible(true).from_path(path).map_err(|e| e.to_string())?;
    let header: Vec<[String; 2]> =
        reader.headers().map_err(|e| e.to_string())?.iter().map(named).collect();
    let first = header.iter().position(|[name, _]| name == "force x").filter(|&first| first > 1);
    let first = first.ok_or("has no forces of named objects")?;
    // Times are written alike in all files, so equal times have equal bits.
    let row_of: HashMap<u64, usize> =
        time.iter().enumerate().map(|(row, t)| (t.to_bits(), row)).collect();
    let mut things: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let number = |at: usize| {
            record.get(at).and_then(|field| field.parse::<f64>().ok()).unwrap_or(f64::NAN)
        };
        let Some(&row) = row_of.get(&number(0).to_bits()) else { continue };
        let name = (1..first).filter_map(|at| record.get(at)).collect::<Vec<_>>().join(" ");
        let force = (first..first + 3).map(|at| number(at).powi(2)).sum::<f64>().sqrt();
        things.entry(name).or_insert_with(|| vec![f64::NAN; time.len()])[row] = force;
    }
    let most = |line: &PlotLine| line.values.iter().copied().fold(0.0, f64::max);
    let line = |(label, values)| PlotLine { label, values, steps: false };
    let mut lines: Vec<PlotLine> = things.into_iter().map(line).filter(|l| most(l) > 0.0).collect();
    lines.sort_by(|a, b| most(b).total_cmp(&most(a)));
    Ok((header[first][1].clone(), lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_with_forces_are_lines_the_largest_first() {
        let dir = tempfile::tempdir().unwrap();
        let mut text = String::from("time [ms],part,name,force x [kN],force y [kN],force z [kN]\n");
        for part in 0..12 {
            text += &format!(
                "0.0e0,{part},<p{part}>,0,0,0\n1.5e0,{part},<p{part}>,{},{},0\n",
                3 * part,
                4 * part
            );
        }
        text += "1.5e0,99"; // truncated
        std::fs::write(dir.path().join("contacts.csv"), text).unwrap();
        std::fs::write(dir.path().join("sections.csv"), "time [ms],section,moment x\n").unwrap();
        let mut problems = Vec::new();
        let plots = plots(dir.path(), &[0.0, 1.5, 2.0], &mut problems);
        assert_eq!(
            (plots.len(), plots[0].unit.as_str(), plots[0].lines.len()),
            (1, "kN", MOST_LINES)
        );
        assert_eq!(
            (plots[0].lines[0].label.as_str(), &plots[0].lines[0].values[..2]),
            ("11 <p11>", &[0.0, 55.0][..])
        );
        assert!(
            plots[0].lines[0].values[2].is_nan() && plots[0].note.ends_with("The 8 largest of 11.")
        );
        assert!(
            problems[0].ends_with("sections.csv: has no forces of named objects"),
            "{problems:?}"
        );
    }
}
