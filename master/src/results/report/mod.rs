//! `crumple report`: one page that shows a run, made only from the files in its folder.
//!
//! - `sources`: summary, history and log; `plots`, `single_forces`, `tables`: their display
//! - `series`: the field files, joined; `surface`: the visible faces
//! - `scene`: the selection for the page; `encode`: the selection as bytes
//! - `state`: one state of a run that is watched, for the page of the service
//! - `page`: the page; its scripts are in `master/assets/report`

mod encode;
mod page;
mod paths;
mod plots;
mod scene;
mod series;
mod single_forces;
mod sources;
pub mod state;
mod surface;
mod tables;
mod workers;

use crate::results::fields::{COLLECTION, DIR};
use crate::stdout::say;
use encode::Description;
use scene::PageScene;
use serde_json::json;
use series::{Dimension, MeshSeries, SCALARS};
use sources::RunFiles;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the page in the folder of a run.
pub const FILE: &str = "report.html";
/// Maximum size of the page [bytes]. A browser opens such a page at once, and it can be sent by
/// mail.
pub const MOST_BYTES: usize = 20_000_000;
/// Maximum number of times on a page. More cannot be distinguished in an animation of some
/// seconds.
const MOST_TIMES: usize = 300;
/// Minimum number of times. If the page is still too large, the mesh becomes coarser.
const LEAST_TIMES: usize = 12;
/// Reserve for the description of the picture, which grows with the number of times [bytes].
const DESCRIPTION: usize = 100_000;
/// Minimum interval between progress messages.
const PATIENCE: Duration = Duration::from_secs(1);

/// A finished page.
#[derive(Clone, Debug)]
pub struct Made {
    /// File of the page.
    pub path: PathBuf,
    /// Size [bytes].
    pub bytes: usize,
    /// Time to make it.
    pub took: Duration,
    /// Files that could not be read, and are missing.
    pub problems: Vec<String>,
}

/// Makes the page of the run in `dir` and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    match write(dir, false) {
        Ok(made) => {
            made.problems.iter().for_each(|problem| eprintln!("warning: {problem}"));
            say!("{made}");
            0
        }
        Err(why) => {
            eprintln!("error: {why}");
            crate::input::job::Report::EXIT_CODE
        }
    }
}

impl std::fmt::Display for Made {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (mb, s) = (self.bytes as f64 / 1e6, self.took.as_secs_f64());
        write!(
            f,
            "report in {} ({mb:.1} MB, made in {s:.1} s): open it in a browser",
            self.path.display()
        )
    }
}

/// Makes the page of the run in `dir`, completed or not. Unless `quiet` is true, prints progress
/// to standard error if it takes longer than a second.
///
/// # Errors
/// The folder has no results, or the page cannot be written.
pub fn write(dir: &Path, quiet: bool) -> Result<Made, String> {
    let began = Instant::now();
    let mut last = began;
    let mut say = |what: &str| {
        if !quiet && last.elapsed() > PATIENCE {
            last = Instant::now();
            eprintln!("report: {what}");
        }
    };
    let mut sources = RunFiles::read(dir);
    let collection = dir.join(DIR).join(COLLECTION);
    let series = match collection.exists() {
        true => series::read(&collection, MOST_TIMES, &mut sources.problems, &mut say),
        false => MeshSeries::default(),
    };
    if sources.summary.is_none() && sources.history.is_none() && series.frames.is_empty() {
        let mut missing = sources.problems;
        if !collection.exists() {
            missing.push(format!("{}: there is no such file", collection.display()));
        }
        return Err(format!(
            "{} contains no results of a run:\n  {}",
            dir.display(),
            missing.join("\n  ")
        ));
    }
    let (page, problems) = make(&sources, &series, MOST_BYTES, &mut say);
    let path = dir.join(FILE);
    crumple_worker::vtu::write_whole(&path, |out| out.write_all(page.as_bytes()))
        .map_err(|e| e.to_string())?;
    Ok(Made { path, bytes: page.len(), took: began.elapsed(), problems })
}

/// Removes the page of an older run.
pub fn forget(dir: &Path) {
    let _ = std::fs::remove_file(dir.join(FILE)); // the file may not exist
}

/// Makes the page, of at most `room` bytes, and lists the problems.
fn make(
    sources: &RunFiles,
    series: &MeshSeries,
    room: usize,
    say: &mut dyn FnMut(&str),
) -> (String, Vec<String>) {
    let problems = sources.problems.clone();
    let mut warnings = sources.warnings.clone();
    warnings.extend(problems.iter().map(|p| format!("Not read: {p}")));
    let mut left_out = Vec::new();
    if let Some(history) = sources.history.as_ref().filter(|h| h.shown() < h.rows) {
        left_out.push(format!(
            "The plots show {} of the {} rows of history.csv.",
            history.shown(),
            history.rows
        ));
    }
    let title = match sources.title() {
        "" => "Crumple report",
        title => title,
    };
    let units = match sources.units() {
        "" => String::new(),
        units => format!("units {units}"),
    };
    let lines = [sources.ending(), units];
    let subtitle =
        lines.iter().filter(|l| !l.is_empty()).map(String::as_str).collect::<Vec<_>>().join(" · ");
    let tables = sources.summary.as_ref().map_or(String::new(), tables::tables);
    let write =
        |warnings: &[String], left_out: &[String], model: Option<&Description>, picture: &[u8]| {
            let facts = facts(sources, model);
            let content = page::Content {
                title,
                subtitle: &subtitle,
                warnings,
                left_out,
                tables: &tables,
                facts: &facts,
                picture,
            };
            page::page(&content)
        };
    let bare = write(&warnings, &left_out, None, &[]);
    if series.frames.is_empty() {
        return (bare, problems);
    }
    // Base64: four characters of the page per three bytes.
    let bytes = room.saturating_sub(bare.len() + DESCRIPTION) / 4 * 3;
    let (scene, description, picture) = fit(series, bytes, say);
    if description.nowhere > 0 {
        let count = description.nowhere;
        warnings.push(format!(
            "{count} elements are hidden at times when one of their nodes has non-finite \
             coordinates."
        ));
    }
    left_out.extend(left_out_of(series, &scene, &description, sources));
    (write(&warnings, &left_out, Some(&description), &picture), problems)
}

/// Returns the scene with as many times and faces as fit into `room` bytes.
fn fit(
    series: &MeshSeries,
    room: usize,
    say: &mut dyn FnMut(&str),
) -> (PageScene, Description, Vec<u8>) {
    let whole = PageScene::new(series, surface::faces(series));
    let least = LEAST_TIMES.min(whole.frames.len());
    let mut times = whole.frames.len();
    let mut cubes = None;
    loop {
        let of_times = whole.with_times(times);
        let scene = cubes.map_or(of_times.clone(), |cubes| of_times.coarser(series, cubes));
        say(&format!("packing {} faces at {times} times", scene.faces.len()));
        let (description, picture) = encode::encode(series, &scene);
        if picture.len() <= room || cubes == Some(1) {
            return (scene, description, picture);
        }
        // Slightly below the share that fits, because fewer times differ more from each other.
        let share = 0.95 * room as f64 / picture.len() as f64;
        if times > least {
            times = ((times as f64 * share) as usize).clamp(least, times - 1);
        } else {
            let now = cubes.map_or((whole.faces.len() as f64).sqrt(), |cubes: usize| cubes as f64);
            cubes = Some(((now * share.sqrt().min(0.9)) as usize).max(1));
        }
    }
}

/// Lists the content that the picture does not show.
fn left_out_of(
    series: &MeshSeries,
    scene: &PageScene,
    description: &Description,
    sources: &RunFiles,
) -> Vec<String> {
    let mut out = Vec::new();
    let (shown, written) = (scene.frames.len(), series.written);
    if shown < written {
        out.push(format!("The picture shows {shown} of the {written} output times."));
    }
    if scene.faces.len() < scene.faces_seen {
        let (have, had) = (scene.faces.len(), scene.faces_seen);
        out.push(format!(
            "The mesh was coarsened by merging neighbouring nodes: {have} faces remain of {had}."
        ));
    }
    if scene.elements.len() < series.elements.len() && scene.faces.len() == scene.faces_seen {
        let inside = series.elements.len() - scene.elements.len();
        out.push(format!("{inside} solids in the interior are never visible and are omitted."));
    }
    if series.unknown_shapes > 0 {
        out.push("Elements of shapes that this page cannot draw are omitted.".into());
    }
    if sources.walls_move_unseen() {
        out.push(
            "Moving rigid walls are drawn at their initial position: there is no `walls.csv` \
             with their displacements."
                .into(),
        );
    }
    let unit = description.frames.iter().map(|f| f.unit).fold(0.0, f64::max);
    let [length, _] = sources.length_and_stress();
    let unit = format!("{} {length}", tables::short(unit));
    out.push(format!(
        "Coordinates are rounded to multiples of at most {}, values have 16 bits. Positions are \
         interpolated between output times, colours are those of the previous output time.",
        unit.trim_end()
    ));
    out.push("Stress components, velocities and ghost elements are in fields/ only.".into());
    out
}

/// Returns the scalars with their units, for the scripts.
fn scalars(sources: &RunFiles) -> Vec<serde_json::Value> {
    let [length, stress] = sources.length_and_stress();
    let unit = |dimension| match dimension {
        Dimension::None => "",
        Dimension::Length => &length,
        Dimension::Stress => &stress,
    };
    SCALARS.iter().map(|s| json!({ "title": s.title, "unit": unit(s.dimension) })).collect()
}

/// Returns the data for the scripts.
fn facts(sources: &RunFiles, model: Option<&Description>) -> String {
    let [length, _] = sources.length_and_stress();
    page::json(&json!({
        "time_unit": sources.history.as_ref().map_or("", |h| h.unit("time")),
        "length_unit": length,
        "scalars": scalars(sources),
        "part_names": sources.part_names(),
        "walls": sources.walls(),
        "plots": sources.plots,
        "model": model,
    }))
}

#[cfg(test)]
mod tests {
    use super::surface::tests::row_of_cubes;
    use super::*;

    #[test]
    fn a_page_stays_below_its_limit_and_says_what_was_left_out() {
        let mut series = row_of_cubes(400, &[1; 400]);
        let frame = series.frames[1].clone();
        // Motion that does not compress.
        let mut random = fastrand::Rng::with_seed(1);
        for k in 2..40 {
            let mut next = frame.clone();
            next.time = f64::from(k);
            for c in next.position.iter_mut().flatten() {
                *c += random.f32();
            }
            series.frames.push(next);
        }
        series.written = series.frames.len();
        let sources = RunFiles::default();
        let whole = make(&sources, &series, MOST_BYTES, &mut |_| {}).0;
        assert!(!whole.contains("output times.") && !whole.contains("coarsened"));
        let bare = make(&sources, &MeshSeries::default(), MOST_BYTES, &mut |_| {}).0.len();
        let picture = whole.len() - bare;
        let room = bare + DESCRIPTION + picture * 6 / 10;
        let fewer = make(&sources, &series, room, &mut |_| {}).0;
        assert!(
            fewer.len() <= room
                && fewer.contains("of the 40 output times.")
                && !fewer.contains("coarsened")
        );
        let room = bare + DESCRIPTION + picture / 10;
        let coarser = make(&sources, &series, room, &mut |_| {}).0;
        assert!(
            coarser.len() <= room
                && coarser.contains("shows 12 of the 40 output times")
                && coarser.contains("was coarsened")
        );
        assert!(
            make(&sources, &series, 0, &mut |_| {}).0.len() < bare + DESCRIPTION,
            "the loop also ends without room"
        );
    }

    #[test]
    fn a_folder_without_a_run_is_refused_with_all_that_is_missing() {
        let dir = tempfile::tempdir().unwrap();
        let error = write(dir.path(), true).unwrap_err();
        for file in ["summary.json: ", "history.csv: ", "fields.pvd: "] {
            assert!(error.contains(file), "{error}");
        }
        assert!(!dir.path().join(FILE).exists());
    }

    #[test]
    fn a_run_without_fields_and_with_damaged_ones_has_a_page_that_says_so() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("history.csv"), "time [ms],kinetic [J]\n0,1\n1,nan\n")
            .unwrap();
        let made = write(dir.path(), true).unwrap();
        assert_eq!(made.problems.len(), 1, "{:?}", made.problems);
        let text = std::fs::read_to_string(&made.path).unwrap();
        assert_eq!(text.len(), made.bytes);
        assert!(text.contains("\"model\":null") && text.contains("\"values\":[1.0,null]"));

        let fields = dir.path().join("fields");
        std::fs::create_dir(&fields).unwrap();
        let mut writer = crate::results::fields::FieldSeries::new(&fields, false);
        writer.add(0, 0.0, 2).unwrap();
        let made = write(dir.path(), true).unwrap();
        assert_eq!(made.problems.len(), 3, "summary and two pieces: {:?}", made.problems);
        assert!(
            made.problems[1].contains("piece_000.vtu")
                && made.problems[2].contains("piece_001.vtu")
        );
        forget(dir.path());
        assert!(!made.path.exists());
    }
}
