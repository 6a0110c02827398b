//! Files in the folder of a run other than the fields: summary, histories, log and job.

use super::histories::ReportHistories;
use super::paths::{self, WallPath};
use super::plots::{ColumnFile, Plots};
use super::tables::short;
use super::{single_forces, workers};
use crate::results::summary::RequirementResult;
use crate::results::warnings::EngineeringWarning;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::HashSet;
use std::path::Path;

/// Maximum number of warnings of the log on the page.
const MOST_SAID: usize = 50;
/// Largest relative energy error that crash codes accept.
const ACCEPTED_ERROR: f64 = 0.01;

/// All files that exist.
#[derive(Debug, Default)]
pub struct RunFiles {
    /// `summary.json`.
    pub summary: Option<Map<String, Value>>,
    /// `history.csv`.
    pub history: Option<ColumnFile>,
    /// Paths of the walls, in their order, from `walls.csv`.
    pub paths: Vec<WallPath>,
    /// Plots of the history and of the files with forces.
    pub plots: Plots,
    /// All histories.
    pub histories: ReportHistories,
    /// Warnings of the run, the most severe first.
    pub warnings: Vec<String>,
    /// Files that could not be read.
    pub problems: Vec<String>,
}

/// A rigid wall: a plane, a rectangle, a cylinder or a sphere, as in `[[wall]]` of the job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawnWall {
    /// A point of the wall: a corner of a rectangle, the start of a cylinder's axis, the centre of
    /// a sphere [length].
    pub point: [f64; 3],
    /// Normal of a plane or rectangle, towards the model.
    pub normal: Option<[f64; 3]>,
    /// Direction of the first side of a rectangle. The direction of the second is normal x edge.
    pub edge: Option<[f64; 3]>,
    /// Lengths of the sides, 0 for an infinite one [length].
    pub lengths: Option<[f64; 2]>,
    /// Direction of the axis of a cylinder.
    pub axis: Option<[f64; 3]>,
    /// Radius of a cylinder, or of a sphere, which has no direction [length].
    pub radius: Option<f64>,
    /// Length of a cylinder, 0 for an infinite one [length].
    #[serde(default)]
    pub length: f64,
    /// Displacement of a moving wall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<WallPath>,
}

impl RunFiles {
    /// Reads the files in the folder.
    pub fn read(dir: &Path) -> Self {
        let mut sources = Self::default();
        match summary(&dir.join("summary.json")) {
            Ok(summary) => sources.summary = Some(summary),
            Err(why) => sources.problems.push(why),
        }
        match ColumnFile::read(&dir.join("history.csv")) {
            Ok(history) => {
                sources.problems.extend(history.damage.clone());
                sources.plots = history.plots(sources.workers());
                let of_things =
                    single_forces::plots(dir, &sources.plots.time, &mut sources.problems);
                let after_walls =
                    sources.plots.plots.iter().position(|p| p.title == "Time step").unwrap_or(0);
                sources.plots.plots.splice(after_walls..after_walls, of_things);
                let of_workers = workers::plots(
                    dir,
                    &sources.plots.time,
                    sources.limits(),
                    &mut sources.problems,
                );
                sources.plots.plots.extend(of_workers);
                sources.history = Some(history);
            }
            Err(why) => sources.problems.push(why),
        }
        sources.histories = ReportHistories::read(dir, &sources.rigid_parts());
        sources.paths = paths::read(&dir.join("walls.csv"));
        let known = sources.engineering();
        sources.warnings = sources.of_summary();
        sources.warnings.extend(known.iter().map(EngineeringWarning::line));
        sources.warnings.extend(log(&dir.join("log.jsonl"), &known));
        sources
    }

    /// Returns the engineering warnings of the summary, which have their worst values.
    fn engineering(&self) -> Vec<EngineeringWarning> {
        let warnings = self.summary.as_ref().and_then(|s| s.get("warnings").cloned());
        warnings.and_then(|all| serde_json::from_value(all).ok()).unwrap_or_default()
    }

    fn of_summary(&self) -> Vec<String> {
        let Some(summary) = &self.summary else {
            return vec![
                "The run has no summary: it was killed, it lost a worker, or it is still running."
                    .into(),
            ];
        };
        let text = |key: &str| summary.get(key).and_then(Value::as_str).unwrap_or("?");
        let mut warnings = Vec::new();
        match text("status") {
            "completed" => {}
            "stopped" => {
                warnings.push(format!("The run was stopped before its end: {}.", text("reason")))
            }
            other => warnings.push(format!("The run {other}: {}", text("reason"))),
        }
        let requirements = summary.get("requirements").and_then(Value::as_array);
        let read = |one: &Value| serde_json::from_value::<RequirementResult>(one.clone()).ok();
        let all = requirements.into_iter().flatten().filter_map(read);
        for one in all.filter(|one| !one.is_met) {
            let value = one.value.map_or("no value".into(), |v| short(v) + &one.suffix());
            let (name, limits) = (&one.name, one.limits());
            warnings
                .push(format!("Requirement `{name}` is not met: {value} (required: {limits})."));
        }
        let error = summary
            .get("energy")
            .and_then(|e| e.get("error_max"))
            .and_then(Value::as_f64)
            .unwrap_or(0.0);
        if error > ACCEPTED_ERROR {
            warnings.push(format!(
                "The energy balance has an error of up to {:.1} %; 1 % is usually acceptable.",
                100.0 * error
            ));
        }
        warnings
    }

    /// Returns the limits at which the master orders redecompositions, if they are known.
    fn limits(&self) -> Option<workers::RedecompositionLimits> {
        let limits = self.summary.as_ref()?.get("thresholds")?;
        let of = |key: &str| limits.get(key).and_then(Value::as_f64);
        Some(workers::RedecompositionLimits { margin: of("margin")?, imbalance: of("imbalance")? })
    }

    fn text(&self, key: &str) -> &str {
        self.summary.as_ref().and_then(|s| s.get(key)).and_then(Value::as_str).unwrap_or("")
    }

    /// Returns the title of the job, empty if it is not known.
    pub fn title(&self) -> &str {
        self.text("title")
    }

    /// Returns the units of the job as it states them.
    pub fn units(&self) -> &str {
        self.text("units")
    }

    /// Returns one line about the end of the run.
    pub fn ending(&self) -> String {
        let Some(summary) = &self.summary else { return String::new() };
        let number = |key: &str| {
            summary.get(key).and_then(Value::as_f64).map(super::tables::short).unwrap_or("?".into())
        };
        let unit = self.history.as_ref().map_or("", |h| h.unit("time"));
        let time = format!("{} {unit}", number("end_time"));
        format!(
            "{} at time {} after {} cycles",
            self.text("status"),
            time.trim_end(),
            number("cycles")
        )
    }

    /// Returns the number of workers.
    pub fn workers(&self) -> Option<u64> {
        self.summary.as_ref()?.get("workers")?.as_u64()
    }

    /// Returns the names of parts by their ids.
    pub fn part_names(&self) -> Map<String, Value> {
        let parts = self.summary.as_ref().and_then(|s| s.get("parts")?.as_array());
        let named = |p: &Value| Some((p.get("id")?.as_u64()?.to_string(), p.get("name")?.clone()));
        parts.into_iter().flatten().filter_map(named).collect()
    }

    /// Returns the ids of the parts that belong to a rigid body.
    fn rigid_parts(&self) -> Vec<u32> {
        let parts = self.summary.as_ref().and_then(|s| s.get("parts")?.as_array());
        let rigid = parts.into_iter().flatten().filter(|part| part["rigid"] == true);
        rigid.filter_map(|part| u32::try_from(part["id"].as_u64()?).ok()).collect()
    }

    /// Returns the names of the node groups of heads.
    pub fn heads(&self) -> Vec<String> {
        let heads = self.summary.as_ref().and_then(|s| s.get("heads").cloned());
        heads.and_then(|heads| serde_json::from_value(heads).ok()).unwrap_or_default()
    }

    /// Returns the rigid walls, with their known displacements.
    pub fn walls(&self) -> Vec<DrawnWall> {
        let with_path = |(w, value): (usize, &Value)| {
            let path = self.paths.get(w).filter(|path| path.moves()).cloned();
            Some(DrawnWall { path, ..DrawnWall::deserialize(value).ok()? })
        };
        self.all_walls().iter().enumerate().filter_map(with_path).collect()
    }

    /// Returns true if a wall moves, freely or as prescribed, and its displacement is not known.
    pub fn walls_move_unseen(&self) -> bool {
        let moves = |w: &Value| {
            ["mass", "velocity", "displacement"]
                .iter()
                .any(|key| w.get(key).is_some_and(|v| !v.is_null()))
        };
        self.all_walls().iter().skip(self.paths.len()).any(moves)
    }

    fn all_walls(&self) -> &[Value] {
        self.summary.as_ref().and_then(|s| s.get("walls")?.as_array()).map_or(&[], Vec::as_slice)
    }

    /// Returns the label of a velocity in the job's units, empty if they are not known.
    pub fn velocity(&self) -> String {
        match self.unit_words()[..] {
            [length, time, _, ..] => format!("{length}/{time}"),
            _ => String::new(),
        }
    }

    /// Returns the label of force in the job's units.
    pub fn force_unit(&self) -> String {
        match self.unit_words()[..] {
            ["mm", "ms", "kg", ..] => "kN".into(),
            ["mm", "s", "t" | "tonne", ..] | ["m", "s", "kg", ..] => "N".into(),
            [l, t, m, ..] => format!("{m} {l}/{t}^2"),
            _ => String::new(),
        }
    }

    /// Returns the words of the units: length, time, mass and others.
    pub fn unit_words(&self) -> Vec<&str> {
        self.units().split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect()
    }

    /// Returns labels of length and stress in the job's units, from their first three words:
    /// length, time, mass.
    pub fn length_and_stress(&self) -> [String; 2] {
        match self.unit_words()[..] {
            ["mm", "ms", "kg", ..] => ["mm".into(), "GPa".into()],
            ["mm", "s", "t" | "tonne", ..] => ["mm".into(), "MPa".into()],
            ["m", "s", "kg", ..] => ["m".into(), "Pa".into()],
            [l, t, m, ..] => [l.into(), format!("{m}/({l} {t}^2)")],
            _ => Default::default(),
        }
    }
}

/// Reads the summary of a run.
///
/// # Errors
/// The file is missing, or not JSON.
pub fn summary(path: &Path) -> Result<Map<String, Value>, String> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| format!("{shown}: {e}"))?;
    serde_json::from_str(&text).map_err(|e| format!("{shown}: {e}"))
}

/// Returns warnings and errors among the events of the log, each once, without those that are
/// `known` from the summary: the log has their first values. There are none without a log.
fn log(path: &Path, known: &[EngineeringWarning]) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let known: HashSet<(String, &str)> =
        known.iter().map(|one| (one.kind.name(), one.part.as_str())).collect();
    let is_new = |event: &Value| {
        let field = |key: &str| event["fields"][key].as_str();
        let of_kind = field("kind").zip(field("part"));
        !of_kind.is_some_and(|(kind, part)| known.contains(&(kind.into(), part)))
    };
    let events = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut lines = HashSet::new();
    let mut said: Vec<String> = events
        .filter(is_new)
        .filter_map(|event| warning(&event))
        .filter(|line| lines.insert(line.clone()))
        .collect();
    let more = said.len().saturating_sub(MOST_SAID);
    if more > 0 {
        said.truncate(MOST_SAID);
        said.push(format!("and {more} more warnings, in log.jsonl"));
    }
    said
}

fn warning(event: &Value) -> Option<String> {
    event.get("level")?.as_str().filter(|level| ["WARN", "ERROR"].contains(level))?;
    let fields = event.get("fields")?.as_object()?;
    let text = |key: &str| fields.get(key).and_then(Value::as_str);
    let worker = fields.get("worker").map_or(String::new(), |w| format!("worker {w}: "));
    match (text("warning"), text("message")) {
        (Some(warning), _) => Some(format!("{worker}{warning}")),
        (_, Some("trouble")) => None, // the summary gives it as the reason
        (_, Some(message)) => {
            let others =
                fields.iter().filter(|(key, _)| !["message", "worker"].contains(&key.as_str()));
            let others: String = others.map(|(key, value)| format!(", {key} {value}")).collect();
            Some(format!("{worker}{message}{others}"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_begin_with_how_the_run_ended() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        write(
            "summary.json",
            r#"{"status": "failed", "reason": "cycle 3: an element inverts",
                "energy": {"error_max": 0.25}, "end_time": 0.5, "cycles": 3,
                "units": "mm, ms, kg", "workers": 2, "parts": [{"id": 4, "name": "a<b"}],
                "requirements": [{"name": "cycles", "value": 3.0, "above": 5.0, "is_met": false,
                                  "unit": "J", "time": 0.25, "unit_of_time": "ms"},
                                 {"name": "nodes", "value": 9.0, "above": 5.0, "is_met": true},
                                 {"name": "peak", "value": null, "below": 2.0, "is_met": false}],
                "walls": [{"name": "", "point": [0, 0, 1.5], "normal": [0, 0, 1]},
                          {"point": "nowhere", "mass": null}]}"#,
        );
        write(
            "log.jsonl",
            "{\"level\":\"INFO\",\"fields\":{\"message\":\"dealt out\"}}\n\
             {\"level\":\"WARN\",\
             \"fields\":{\"worker\":1,\"warning\":\"an edge has gone through\"}}\n\
             {\"level\":\"ERROR\",\"fields\":{\"message\":\"trouble\",\"worker\":0}}\n\
             {\"level\":\"ERROR\",\
             \"fields\":{\"message\":\"worker ends\",\"worker\":0,\"lost\":\"rank 2\"}}\n{\"lev",
        );
        let s = RunFiles::read(dir.path());
        let wanted = [
            "The run failed: cycle 3: an element inverts",
            "Requirement `cycles` is not met: 3 J at time 2.5000e-1 ms (required: above 5).",
            "Requirement `peak` is not met: no value (required: below 2).",
            "The energy balance has an error of up to 25.0 %; 1 % is usually acceptable.",
            "worker 1: an edge has gone through",
            "worker 0: worker ends, lost \"rank 2\"",
        ];
        assert_eq!(s.warnings, wanted);
        assert_eq!(s.problems.len(), 1, "{:?}", s.problems);
        assert!(s.problems[0].contains("history.csv: "), "{:?}", s.problems);
        assert_eq!((s.length_and_stress(), s.workers()), (["mm".into(), "GPa".into()], Some(2)));
        assert_eq!(s.part_names()["4"], "a<b");
        let walls = s.walls();
        assert!(!s.walls_move_unseen());
        assert_eq!(
            (walls.len(), walls[0].point, walls[0].normal),
            (1, [0.0, 0.0, 1.5], Some([0.0, 0.0, 1.0]))
        );
        assert_eq!(s.ending(), "failed at time 0.5 after 3 cycles");
    }

    #[test]
    fn an_empty_folder_has_two_problems_and_says_what_it_lacks() {
        let dir = tempfile::tempdir().unwrap();
        let s = RunFiles::read(dir.path());
        assert_eq!(s.problems.len(), 2);
        assert!(s.warnings[0].starts_with("The run has no summary"), "{:?}", s.warnings);
    }

    /// The log has the first value of a warning, the summary its worst one.
    #[test]
    fn a_warning_of_the_summary_is_not_taken_from_the_log() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        let event = |kind: &str, part: &str, warning: &str| {
            let fields = serde_json::json!({"kind": kind, "part": part, "warning": warning});
            format!("{}\n", serde_json::json!({"level": "WARN", "fields": fields}))
        };
        let all = [
            event("inversion", "`a`", "at time 1.240000e-3 part `a`: 9 %"),
            event("inversion", "`b`", "at time 1.500000e-3 part `b`: 8 %"),
            event("friction", "", "at time 1.600000e-3 much friction"),
        ];
        write("log.jsonl", &all.concat());
        write(
            "summary.json",
            r#"{"status": "completed", "warnings": [{"kind": "inversion", "part": "`a`",
                "cycle": 12, "time": 1.24e-3, "value": -0.15, "worst_time": 1.8e-3,
                "what": "-15 %", "place": "element 7 at (1, 2, 3)", "cure": "Refine"}]}"#,
        );
        let s = RunFiles::read(dir.path());
        let wanted = [
            "at time 1.800000e-3 part `a`: -15 % (since time 1.240000e-3, cycle 12); element 7 at \
             (1, 2, 3). Refine",
            "at time 1.500000e-3 part `b`: 8 %",
            "at time 1.600000e-3 much friction",
        ];
        assert_eq!(s.warnings, wanted);
        std::fs::remove_file(dir.path().join("summary.json")).unwrap();
        let s = RunFiles::read(dir.path());
        assert_eq!(s.warnings.len(), 4, "without a summary the log has all: {:?}", s.warnings);
    }

    #[test]
    fn a_log_that_says_much_is_cut() {
        let dir = tempfile::tempdir().unwrap();
        let line = |i| {
            format!("{{\"level\":\"WARN\",\"fields\":{{\"message\":\"edge {i}\"}}}}\n").repeat(2)
        };
        let all: String = (0..MOST_SAID + 7).map(line).collect();
        std::fs::write(dir.path().join("log.jsonl"), all).unwrap();
        let said = log(&dir.path().join("log.jsonl"), &[]);
        assert_eq!(
            (said.len(), said[MOST_SAID].as_str()),
            (MOST_SAID + 1, "and 7 more warnings, in log.jsonl")
        );
    }
}
