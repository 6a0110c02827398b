//! Points of a study: every combination of its settings. Each is checked as a job before any run.

use super::spec::{Measure, Reference, Study, flatten};
use crate::input::job::{self, Model};
use crate::results::quantity::{self, RunResults};
use std::collections::HashMap;
use std::path::Path;
use toml::Value;

/// A setting and its value.
pub type StudySetting = (String, Value);

/// One run of a study.
#[derive(Clone, Debug)]
pub struct Point {
    /// Index of the series; none for a reference run.
    pub series: Option<usize>,
    /// Settings that the series varies, in the order of its lists.
    pub varied: Vec<StudySetting>,
    /// All settings as `key=value` for `--set`.
    pub sets: Vec<String>,
    /// Hash of the job with all settings, its mesh and the version of this program.
    pub key: String,
}

/// All points, those of the series first.
pub struct StudyPlan {
    /// The points.
    pub points: Vec<Point>,
    /// Index of the reference point of each measure.
    pub reference: Vec<Option<usize>>,
}

impl StudyPlan {
    /// Returns all points of a study.
    ///
    /// # Errors
    /// A list has the wrong type or length, or the job has errors at some point; the text lists
    /// all of them.
    pub fn new(study: &Study) -> Result<Self, String> {
        let common = flatten(&study.set);
        let mut keys = Keys::default();
        let mut wrong = Vec::new();
        let mut refused: Vec<Refused> = Vec::new();
        let mut points = Vec::new();
        for (number, series) in study.series.iter().enumerate() {
            let combined = match (cross(&flatten(&series.grid)), zipped(&flatten(&series.zip))) {
                (Ok(grid), Ok(zip)) => zip
                    .into_iter()
                    .flat_map(|z| {
                        grid.clone()
                            .into_iter()
                            .map(move |g| z.iter().cloned().chain(g).collect::<Vec<StudySetting>>())
                    })
                    .collect::<Vec<_>>(),
                (Err(why), _) | (_, Err(why)) => {
                    wrong.push(format!("series `{}`: {why}", series.name));
                    continue;
                }
            };
            let fixed: Vec<StudySetting> =
                common.iter().cloned().chain(flatten(&series.set)).collect();
            for varied in combined {
                let sets: Vec<String> =
                    fixed.iter().chain(&varied).map(|(k, v)| format!("{k}={v}")).collect();
                match keys.key(&study.job, &sets) {
                    Ok(key) => points.push(Point { series: Some(number), varied, sets, key }),
                    Err(why) => {
                        let plain = without_values(&why, &sets);
                        match refused.iter_mut().find(|r| r.plain == plain) {
                            Some(same) => same.others += 1,
                            None => refused.push(Refused {
                                sets: sets.join(" "),
                                why,
                                plain,
                                others: 0,
                            }),
                        }
                    }
                }
            }
        }
        wrong.extend(refused.iter().map(Refused::text));
        if let Some(blank) = &keys.blank {
            let of = |m: &Measure| {
                quantity::unknown_name(&m.quantity, blank)
                    .map(|unknown| format!("measure `{}`: {}", m.name, unknown.why))
            };
            wrong.extend(study.measure.iter().filter_map(of));
            wrong.extend(
                quantity::unknown_name(&study.cost.quantity, blank)
                    .map(|unknown| format!("cost: {}", unknown.why)),
            );
        }
        let mut reference = Vec::new();
        for measure in &study.measure {
            let Some(Reference::Run { set }) = &measure.reference else {
                reference.push(None);
                continue;
            };
            let sets: Vec<String> =
                common.iter().chain(&flatten(set)).map(|(k, v)| format!("{k}={v}")).collect();
            match keys.key(&study.job, &sets) {
                Ok(key) => {
                    let there = points.iter().position(|p| p.series.is_none() && p.key == key);
                    reference.push(Some(there.unwrap_or(points.len())));
                    if there.is_none() {
                        points.push(Point { series: None, varied: flatten(set), sets, key });
                    }
                }
                Err(why) => wrong.push(format!(
                    "reference of `{}`: {}\n{why}",
                    measure.name,
                    sets.join(" ")
                )),
            }
        }
        if wrong.is_empty() { Ok(Self { points, reference }) } else { Err(wrong.join("\n")) }
    }
}

impl Point {
    /// Returns a short name of the point: its series and the varied settings.
    pub fn label(&self, study: &Study) -> String {
        let name = self.series.map_or("reference", |s| study.series[s].name.as_str());
        let mut settings: Vec<String> =
            self.varied.iter().map(|(k, v)| format!("{}={}", short(k), plain(v))).collect();
        settings.dedup(); // the same setting of several parts
        if settings.is_empty() { name.into() } else { format!("{name}, {}", settings.join(" ")) }
    }
}

/// Returns the last word of a key.
pub fn short(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// Returns a value without quotes.
pub fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

/// Returns a value as a number, none if it is not one.
pub fn number(value: &Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|i| i as f64))
}

fn values<'a>(key: &str, value: &'a Value) -> Result<&'a [Value], String> {
    match value.as_array() {
        Some(list) if !list.is_empty() => Ok(list),
        _ => Err(format!("`{key}` has to be a list of values: {key} = [...]")),
    }
}

fn cross(lists: &[StudySetting]) -> Result<Vec<Vec<StudySetting>>, String> {
    let mut all = vec![Vec::new()];
    for (key, list) in lists {
        let list = values(key, list)?;
        let with = |point: &Vec<StudySetting>, value: &Value| {
            [&point[..], &[(key.clone(), value.clone())]].concat()
        };
        all =
            all.iter().flat_map(|point| list.iter().map(move |value| with(point, value))).collect();
    }
    Ok(all)
}

fn zipped(lists: &[StudySetting]) -> Result<Vec<Vec<StudySetting>>, String> {
    let Some((first, list)) = lists.first() else { return Ok(vec![Vec::new()]) };
    let length = values(first, list)?.len();
    let mut all = vec![Vec::new(); length];
    for (key, list) in lists {
        let list = values(key, list)?;
        if list.len() != length {
            return Err(format!(
                "zip: `{key}` has {} values and `{first}` {length}; give lists of equal length",
                list.len()
            ));
        }
        all.iter_mut()
            .zip(list)
            .for_each(|(point, value)| point.push((key.clone(), value.clone())));
    }
    Ok(all)
}

/// Points whose job has the same error, which is reported once.
struct Refused {
    /// Settings of the first point.
    sets: String,
    why: String,
    /// `why` without the values of the settings, which differ between points.
    plain: String,
    others: usize,
}

fn without_values(why: &str, sets: &[String]) -> String {
    sets.iter().fold(why.to_string(), |text, set| {
        text.replace(set, set.split('=').next().unwrap_or_default())
    })
}

impl Refused {
    fn text(&self) -> String {
        let others = match self.others {
            0 => String::new(),
            1 => "\nthe same at another point".into(),
            n => format!("\nthe same at {n} other points"),
        };
        format!("{}\n{}{others}", self.sets, self.why.trim_end())
    }
}

/// Computes hashes of points. Points with equal hashes are the same run.
#[derive(Default)]
struct Keys {
    meshes: HashMap<String, blake3::Hash>,
    /// Names that a run of the first valid point will write.
    blank: Option<RunResults>,
}

impl Keys {
    /// Returns the key of a job with settings.
    ///
    /// # Errors
    /// The job has errors; the text lists all of them.
    fn key(&mut self, job: &Path, sets: &[String]) -> Result<String, String> {
        let model = job::read(job, sets).map_err(|report| report.to_string())?;
        self.blank.get_or_insert_with(|| RunResults::blank(&model));
        let written = serde_json::to_string(&model.job).map_err(|error| error.to_string())?;
        let source = serde_json::to_string(&(&model.job.mesh, &model.job.scene))
            .map_err(|error| error.to_string())?;
        let mesh = *self.meshes.entry(source).or_insert_with(|| mesh_hash(&model));
        let mut hasher = blake3::Hasher::new();
        hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.update(mesh.as_bytes()).update(written.as_bytes());
        Ok(hasher.finalize().to_hex()[..16].to_string())
    }
}

fn mesh_hash(model: &Model) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for node in &model.mesh.nodes {
        hasher.update(&node.id.0.to_le_bytes());
        for c in node.x {
            hasher.update(&c.to_le_bytes());
        }
    }
    for element in &model.mesh.elements {
        hasher.update(&element.id.0.to_le_bytes()).update(&element.part.to_le_bytes());
        for n in element.nodes {
            hasher.update(&n.0.to_le_bytes());
        }
    }
    for (name, nodes) in &model.mesh.node_sets {
        hasher.update(name.as_bytes()).update(&nodes.len().to_le_bytes());
        for n in nodes {
            hasher.update(&n.0.to_le_bytes());
        }
    }
    hasher.finalize()
}
