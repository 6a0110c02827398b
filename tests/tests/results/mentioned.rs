//! Runs of the jobs under `cases/` mention in their warnings what an engineer must know. The files
//! of each run are judged again, without the code that warns.

use crumple::results::field_file::{PieceArrays, pieces, steps};
use crumple_proto::mesh::{MAX_CORNERS, Shape};
use crumple_proto::quality::corner_jacobians;
use crumple_tests::program::{Ended, crumple_with, root, run};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Jobs and decks that take more than some seconds, without the ending of the file.
const LONG: [&str; 11] = [
    "beam/job",
    "bench/hex-bar",
    "brick-wall/job",
    "can-crush/job",
    "decks/airbag/airbag",
    "decks/ball-plate/ball_plate",
    "flight/job",
    "jeep-frame/job",
    "pipe-whip/job",
    "plate/slow",
    "tube-crush/job",
];

/// Returns the job files and decks under `cases/`, by their names.
fn jobs() -> BTreeMap<String, PathBuf> {
    let mut jobs = BTreeMap::new();
    for parent in ["cases", "cases/decks"] {
        for folder in fs::read_dir(root().join(parent)).unwrap() {
            let folder = folder.unwrap().path();
            let is_scene = folder.is_dir() && !folder.ends_with("studies");
            for file in is_scene.then(|| fs::read_dir(&folder).unwrap()).into_iter().flatten() {
                let file = file.unwrap().path();
                let marks: &[&str] = match file.extension().and_then(|e| e.to_str()) {
                    Some("toml") => &["end_time", "deck ="],
                    Some("k") => &["*CONTROL_TERMINATION"],
                    _ => continue,
                };
                let text = fs::read_to_string(&file).unwrap_or_default();
                if !marks.iter().any(|mark| text.contains(mark)) {
                    continue;
                }
                let name = file.strip_prefix(root().join("cases")).unwrap().with_extension("");
                jobs.insert(name.display().to_string(), file);
            }
        }
    }
    jobs
}

/// A warning that must be there: its kind, and the part; empty for the whole model.
type Expected = BTreeSet<(&'static str, String)>;

/// Returns the rows of a file of histories by their columns without units.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let bare = |name: &str| name.split(" [").next().unwrap().to_owned();
    let head: Vec<String> = lines.next().unwrap().split(',').map(bare).collect();
    let row = |line: &str| head.iter().cloned().zip(line.split(',').map(String::from)).collect();
    lines.map(row).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or(f64::NAN)
}

/// Returns the warnings that the histories ask for: hourglass energy above 10 % of the internal
/// energy of a part or 5 % in total, negative energy of contact above 1 % of the largest energy,
/// friction above 10 % of it, as much taken by contact without friction, a penetration of half of
/// the thickness. Energies below 0.1 % of the
/// largest one do not count.
fn of_histories(dir: &Path) -> Expected {
    let mut expected = Expected::new();
    let (mut most, mut most_at) = (0.0f64, BTreeMap::new());
    let history = rows(&dir.join("history.csv"));
    for row in &history {
        let [kinetic, internal, hourglass] =
            ["kinetic", "internal", "hourglass"].map(|column| number(row, column));
        most = most.max(kinetic + internal + hourglass);
        most_at.insert(row["time"].clone(), most);
        let (contact, friction) = (number(row, "contact work"), number(row, "friction work"));
        let found = [
            ("hourglass", hourglass > 0.001 * most && hourglass > 0.05 * internal),
            ("contact_energy", contact > 0.01 * most && most > 0.0),
            ("contact_loss", friction - contact > 0.1 * most),
            ("friction", -friction > 0.1 * most || friction > 0.01 * most),
            ("penetration", number(row, "penetration") > 0.5),
        ];
        expected.extend(found.iter().filter(|f| f.1).map(|f| (f.0, String::new())));
    }
    for row in rows(&dir.join("parts.csv")) {
        let (internal, hourglass) = (number(&row, "internal"), number(&row, "hourglass"));
        if hourglass > 0.001 * most_at[&row["time"]] && hourglass > 0.1 * internal {
            expected.insert(("hourglass", row["name"].clone()));
        }
    }
    expected
}

/// Returns the smallest ratio of the Jacobian at a corner of an element to its value at the start,
/// over all field files; infinite without any.
fn least_jacobian(dir: &Path) -> f64 {
    let mut first: BTreeMap<i64, [f64; MAX_CORNERS]> = BTreeMap::new();
    let mut least = f64::INFINITY;
    let collection = dir.join("fields/fields.pvd");
    let all = if collection.exists() { steps(&collection).unwrap() } else { Vec::new() };
    for step in all {
        for piece in pieces(&step.file).unwrap() {
            let piece = PieceArrays::read(&piece).unwrap();
            let points: Vec<f64> = piece.array("Points").unwrap();
            let (corners, ends) =
                (piece.i64("connectivity").unwrap(), piece.i64("offsets").unwrap());
            let kinds = piece.u8("types").unwrap();
            let mut begin = 0;
            for (cell, id) in piece.i64("element_id").unwrap().iter().enumerate() {
                let of_cell = &corners[begin..ends[cell] as usize];
                begin = ends[cell] as usize;
                let shape = match kinds[cell] {
                    5 => Shape::Tri3,
                    9 => Shape::Quad4,
                    10 => Shape::Tet4,
                    12 => Shape::Hex8,
                    13 => Shape::Wedge6,
                    24 => Shape::Tet10,
                    _ => continue,
                };
                let at = |&n: &i64| [0, 1, 2].map(|c| points[3 * n as usize + c]);
                let x: Vec<[f64; 3]> = of_cell.iter().map(at).collect();
                let now = corner_jacobians(shape, &x);
                let start = first.entry(*id).or_insert(now);
                let corners = start.iter().zip(now).filter(|(start, _)| **start > 0.0);
                least = corners.map(|(start, now)| now / start).fold(least, f64::min);
            }
        }
    }
    least
}

/// Checks that the run has all warnings that its files ask for.
fn judge(name: &str, ended: &Ended) {
    let mut expected = of_histories(&ended.out());
    let dt = &ended.summary()["dt"];
    if dt["min"].as_f64().unwrap() < 0.2 * dt["first"].as_f64().unwrap() {
        expected.insert(("time_step", String::new()));
    }
    let least = least_jacobian(&ended.out());
    let warnings = ended.summary()["warnings"].clone();
    let warnings = warnings.as_array().unwrap();
    let has = |kind: &str, part: Option<&str>| {
        let is_it = |w: &&serde_json::Value| {
            w["kind"] == kind
                && part.is_none_or(|p| w["part"].as_str().unwrap().trim_matches('`') == p)
        };
        warnings.iter().any(|w| is_it(&w))
    };
    for warning in warnings {
        let has_place = !["contact_loss", "contact_step", "unused_contact", "unused_wall"]
            .contains(&warning["kind"].as_str().unwrap());
        assert!(!has_place || warning["place"] != "", "{name}: no place in {warning:#}");
    }
    // The elements of these kinds have a part, which the histories do not name.
    expected.retain(|(kind, part)| {
        let any = ["penetration", "time_step"].contains(kind);
        !has(kind, (!any).then_some(part))
    });
    if least < 0.1 && !has("inversion", None) {
        expected.insert(("inversion", format!("{least}")));
    }
    assert!(expected.is_empty(), "{name} lacks the warnings {expected:?}; it has {warnings:#?}");
}

/// Runs the long jobs or the others on one worker to their ends. Returns the numbers of jobs and of
/// warnings.
fn judge_all(long: bool) -> (usize, usize) {
    let (mut count, mut warned) = (0, 0);
    for (name, path) in jobs().iter().filter(|(name, _)| LONG.contains(&name.as_str()) == long) {
        let job = path.display().to_string();
        let ended = run(crumple_with(&["run", &job, "--workers=1", "--no-report"])).with_code(0);
        judge(name, &ended);
        count += 1;
        warned += ended.summary()["warnings"].as_array().unwrap().len();
    }
    (count, warned)
}

#[test]
fn jobs_of_the_cases_mention_all_that_is_wrong() {
    let (jobs, warned) = judge_all(false);
    assert!(jobs > 15, "only {jobs} jobs found");
    assert!(warned > 5, "the scenes have hourglass energy and friction: {warned} warnings");
}

#[test]
#[ignore = "takes minutes: deploy/verify.sh runs it"]
fn long_jobs_of_the_cases_mention_all_that_is_wrong() {
    let (jobs, warned) = judge_all(true);
    assert_eq!(jobs, LONG.len(), "all of the long ones exist");
    assert!(warned > 0, "the frame and the tube have warnings");
}
