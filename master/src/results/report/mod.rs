//! `crumple report`: one page that shows a run, made only from the files in its folder.
//!
//! - `histories`: all histories, for the plot workbench; `mass_centres`: displacements of rigid
//!   parts among them
//! - `sources`: summary, history and log; `plots`, `single_forces`, `tables`: their display
//! - `series`: the field files, joined; `surface`: the visible faces
//! - `scene`: the selection for the page; `encode`: the selection as bytes
//! - `state`: one state of a run that is watched, for the page of the service
//! - `model_page`: the page of a job before its run
//! - `page`: the page; its scripts are in `master/assets/report`

mod encode;
pub mod histories;
pub mod mass_centres;
pub mod model_page;
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
use page::escape;
use scene::PageScene;
use serde_json::json;
use series::{Dimension, MeshSeries, NODE_SCALARS, SCALARS, Scalar};
use sources::RunFiles;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the page in the folder of a run.
pub const FILE: &str = "report.html";
/// Name of the page of two runs, in the folder of the first one.
pub const PAIR_FILE: &str = "compare.html";
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

/// Makes the page of the run in `dir`, or with a second run the page of both in step, and returns
/// the exit code.
pub fn run(dir: &Path, second: Option<&Path>) -> u8 {
    let made = match second {
        Some(second) => write_pair(dir, second),
        None => write(dir, false),
    };
    match made {
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
    let mut say = progress(quiet);
    let run = read(dir, &mut say)?;
    finish(&dir.join(FILE), make(&run, None, MOST_BYTES, &mut say), began)
}

/// Makes the page of two runs in step, in the folder of the first one.
///
/// # Errors
/// A folder has no results, the runs have different units, or the page cannot be written.
fn write_pair(dir: &Path, second: &Path) -> Result<Made, String> {
    let began = Instant::now();
    let mut say = progress(false);
    let runs = [read(dir, &mut say)?, read(second, &mut say)?];
    let units = [0, 1].map(|i| runs[i].sources.units());
    if units[0] != units[1] {
        return Err(format!(
            "{} has the units `{}` and {} has `{}`: runs in different units cannot be compared",
            dir.display(),
            units[0],
            second.display(),
            units[1]
        ));
    }
    let names = [dir, second].map(|dir| dir.display().to_string());
    let other = SecondRun { run: &runs[1], names: [&names[0], &names[1]] };
    finish(&dir.join(PAIR_FILE), make(&runs[0], Some(&other), MOST_BYTES, &mut say), began)
}

/// Returns a function that prints progress to standard error if it takes longer than a second,
/// unless `quiet` is true.
fn progress(quiet: bool) -> impl FnMut(&str) {
    let mut last = Instant::now();
    move |what: &str| {
        if !quiet && last.elapsed() > PATIENCE {
            last = Instant::now();
            eprintln!("report: {what}");
        }
    }
}

fn finish(path: &Path, made: (String, Vec<String>), began: Instant) -> Result<Made, String> {
    let (page, problems) = made;
    crumple_worker::vtu::write_whole(path, |out| out.write_all(page.as_bytes()))
        .map_err(|e| e.to_string())?;
    Ok(Made { path: path.to_owned(), bytes: page.len(), took: began.elapsed(), problems })
}

/// A run with its fields.
#[derive(Debug, Default)]
struct ReadRun {
    sources: RunFiles,
    series: MeshSeries,
}

/// The second run of a page, and the names of both.
struct SecondRun<'a> {
    run: &'a ReadRun,
    names: [&'a str; 2],
}

/// Reads the results in a folder.
fn read(dir: &Path, say: &mut dyn FnMut(&str)) -> Result<ReadRun, String> {
    let mut sources = RunFiles::read(dir);
    let collection = dir.join(DIR).join(COLLECTION);
    let series = match collection.exists() {
        true => series::read(&collection, MOST_TIMES, &mut sources.problems, say),
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
    Ok(ReadRun { sources, series })
}

/// Removes the pages of an older run.
pub fn forget(dir: &Path) {
    for page in [FILE, PAIR_FILE] {
        let _ = std::fs::remove_file(dir.join(page)); // the file may not exist
    }
}

/// Makes the page, of at most `room` bytes, and lists the problems.
fn make(
    first: &ReadRun,
    second: Option<&SecondRun<'_>>,
    room: usize,
    say: &mut dyn FnMut(&str),
) -> (String, Vec<String>) {
    let runs: Vec<&ReadRun> = std::iter::once(first).chain(second.map(|s| s.run)).collect();
    let problems: Vec<String> = runs.iter().flat_map(|r| r.sources.problems.clone()).collect();
    // Lines about one of two runs begin with its name.
    let of = |i: usize, line: String| match second {
        Some(second) => format!("{}: {line}", second.names[i]),
        None => line,
    };
    let (mut warnings, mut left_out) = (Vec::new(), Vec::new());
    for (i, ReadRun { sources, .. }) in runs.iter().enumerate() {
        let unread = sources.problems.iter().map(|p| format!("Not read: {p}"));
        warnings.extend(sources.warnings.iter().cloned().chain(unread).map(|w| (i, of(i, w))));
        if let Some(history) = sources.history.as_ref().filter(|h| h.shown() < h.rows) {
            let line = format!(
                "The plots show {} of the {} rows of history.csv.",
                history.shown(),
                history.rows
            );
            left_out.push(of(i, line));
        }
        left_out.extend(sources.histories.left_out().into_iter().map(|line| of(i, line)));
    }
    let tables: String = (0..runs.len())
        .filter_map(|i| {
            let tables = tables::tables(runs[i].sources.summary.as_ref()?, "Run");
            let head = second.map_or(String::new(), |s| {
                format!("<section class=\"table\"><h2>{}</h2></section>\n", escape(s.names[i]))
            });
            Some(head + &tables)
        })
        .collect();
    let histories: Vec<Vec<u8>> = runs.iter().map(|r| r.sources.histories.packed()).collect();
    let (title, subtitle) = headline(&runs, second);
    let write = |warnings: &[(usize, String)], left_out: &[String], drawn: &[Option<Drawn>]| {
        let model = |i: usize| drawn.get(i).and_then(Option::as_ref).map(|d: &Drawn| &d.0);
        let picture =
            |i: usize| drawn.get(i).and_then(Option::as_ref).map_or(&[][..], |d: &Drawn| &d.1);
        let mut all = facts(&first.sources, model(0));
        if let Some(second) = second {
            all["second"] = facts(&second.run.sources, model(1));
            all["second"]["first_name"] = json!(second.names[0]);
            all["second"]["name"] = json!(second.names[1]);
        }
        let content = page::Content {
            title: &title,
            subtitle: &subtitle,
            warnings,
            left_out,
            tables: &tables,
            facts: &page::json(&all),
            pictures: [picture(0), picture(1)],
            histories: [&histories[0], histories.get(1).map_or(&[][..], Vec::as_slice)],
            ..page::Content::default()
        };
        page::page(&content)
    };
    let bare = write(&warnings, &left_out, &[]);
    let pictures = runs.iter().filter(|r| !r.series.frames.is_empty()).count();
    if pictures == 0 {
        return (bare, problems);
    }
    // Base64: four characters of the page per three bytes.
    let bytes = room.saturating_sub(bare.len() + pictures * DESCRIPTION) / pictures / 4 * 3;
    let mut drawn = Vec::new();
    for (i, ReadRun { sources, series }) in runs.iter().enumerate() {
        if series.frames.is_empty() {
            drawn.push(None);
            continue;
        }
        let (scene, description, picture) = fit(series, bytes, say);
        if description.nowhere > 0 {
            let line = format!(
                "{} elements are hidden at times when one of their nodes has non-finite \
                 coordinates.",
                description.nowhere
            );
            warnings.push((i, of(i, line)));
        }
        let lines = left_out_of(series, &scene, &description, sources);
        left_out.extend(lines.into_iter().map(|line| of(i, line)));
        drawn.push(Some((description, picture)));
    }
    (write(&warnings, &left_out, &drawn), problems)
}

/// Description and bytes of a picture.
type Drawn = (Description, Vec<u8>);

/// Returns title and subtitle of the page.
fn headline(runs: &[&ReadRun], second: Option<&SecondRun<'_>>) -> (String, String) {
    let units = match runs[0].sources.units() {
        "" => String::new(),
        units => format!("units {units}"),
    };
    let (title, mut lines) = match second {
        Some(SecondRun { names, .. }) => {
            let ending = |i: usize| format!("{}: {}", names[i], runs[i].sources.ending());
            (format!("{} and {}", names[0], names[1]), vec![ending(0), ending(1)])
        }
        None => (runs[0].sources.title().to_owned(), vec![runs[0].sources.ending()]),
    };
    lines.push(units);
    lines.retain(|line| !line.is_empty());
    (if title.is_empty() { "Crumple report".into() } else { title }, lines.join(" · "))
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
    out.push("Stress components and ghost elements are in fields/ only.".into());
    out
}

/// Returns the scalars of elements with their units, for the scripts.
fn scalars(sources: &RunFiles) -> Vec<serde_json::Value> {
    with_units(&SCALARS, sources)
}

/// Returns the scalars of nodes with their units, for the scripts.
fn node_scalars(sources: &RunFiles) -> Vec<serde_json::Value> {
    with_units(&NODE_SCALARS, sources)
}

fn with_units(scalars: &[Scalar], sources: &RunFiles) -> Vec<serde_json::Value> {
    let [length, stress] = sources.length_and_stress();
    let velocity = sources.velocity();
    let unit = |dimension| match dimension {
        Dimension::None => "",
        Dimension::Length => &length,
        Dimension::Stress => &stress,
        Dimension::Velocity => &velocity,
    };
    scalars.iter().map(|s| json!({ "title": s.title, "unit": unit(s.dimension) })).collect()
}

/// Returns the data of a run for the scripts.
fn facts(sources: &RunFiles, model: Option<&Description>) -> serde_json::Value {
    let [length, _] = sources.length_and_stress();
    json!({
        "time_unit": sources.history.as_ref().map_or("", |h| h.unit("time")),
        "length_unit": length,
        "force_unit": sources.force_unit(),
        "scalars": scalars(sources),
        "node_scalars": node_scalars(sources),
        "part_names": sources.part_names(),
        "heads": sources.heads(),
        "walls": sources.walls(),
        "plots": sources.plots,
        "histories": sources.histories,
        "model": model,
    })
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
        let run = ReadRun { series, ..ReadRun::default() };
        let made = |room| make(&run, None, room, &mut |_| {}).0;
        let whole = made(MOST_BYTES);
        assert!(!whole.contains("output times.") && !whole.contains("coarsened"));
        let bare = make(&ReadRun::default(), None, MOST_BYTES, &mut |_| {}).0.len();
        let picture = whole.len() - bare;
        let room = bare + DESCRIPTION + picture * 6 / 10;
        let fewer = made(room);
        assert!(
            fewer.len() <= room
                && fewer.contains("of the 40 output times.")
                && !fewer.contains("coarsened")
        );
        let room = bare + DESCRIPTION + picture / 10;
        let coarser = made(room);
        assert!(
            coarser.len() <= room
                && coarser.contains("shows 12 of the 40 output times")
                && coarser.contains("was coarsened")
        );
        assert!(made(0).len() < bare + DESCRIPTION, "the loop also ends without room");
        let both = SecondRun { run: &run, names: ["a<b", "c"] };
        let room = bare + 2 * DESCRIPTION + picture;
        let pair = make(&run, Some(&both), room, &mut |_| {}).0;
        assert!(
            pair.len() <= room && pair.matches("of the 40 output times.").count() == 2,
            "two runs share the room"
        );
        assert!(pair.contains("a&lt;b and c") && pair.contains("c: The picture shows"));
    }

    #[test]
    fn runs_in_different_units_are_not_compared() {
        let dirs = ["mm, ms, kg", "m, s, kg"].map(|units| {
            let dir = tempfile::tempdir().unwrap();
            let summary = json!({ "status": "completed", "units": units }).to_string();
            std::fs::write(dir.path().join("summary.json"), summary).unwrap();
            dir
        });
        let error = write_pair(dirs[0].path(), dirs[1].path()).unwrap_err();
        assert!(error.contains("`mm, ms, kg`") && error.contains("`m, s, kg`"), "{error}");
        let made = write_pair(dirs[0].path(), dirs[0].path()).unwrap();
        assert!(made.path.ends_with(PAIR_FILE));
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
        let mut writer = crate::results::fields::FieldSeries::new(&fields, Default::default());
        writer.add(0, 0.0, 2).unwrap();
        let made = write(dir.path(), true).unwrap();
        assert_eq!(made.problems.len(), 3, "summary and two pieces: {:?}", made.problems);
        assert!(
            made.problems[1].contains("piece_000.vtu")
                && made.problems[2].contains("piece_001.vtu")
        );
        let pair = dir.path().join(PAIR_FILE);
        std::fs::write(&pair, "").unwrap();
        forget(dir.path());
        assert!(!made.path.exists() && !pair.exists());
    }
}
