//! `crumple verify`: the catalogue of verification cases, each run in this process and compared
//! with its reference.
//!
//! - `catalogue.rs`: every entry, in order: its checks, the parts that are not covered and why
//! - `row.rs`: one quantity compared with its reference; `report.rs`: the table
//! - `scene.rs`: builds a job; `solids.rs`: builds meshes of solids for it; `bench.rs`: runs and
//!   observes it; `measure.rs`: quantities measured in a run
//! - one file per family of entries: `bars.rs`, `walls.rs`, `beams.rs`, ...
//!
//! A check builds its job as the text of a job file, so that all of it passes through the
//! reader. `DIR/jobs` holds every job that was run, for `crumple run`. Units are SI. Marks of
//! the sources: [V] read in the cited source, [D] derived, [C] computed for comparison with an
//! independent program, [U] not verified.

mod bars;
mod beam_contact;
mod beams;
pub mod bench;
pub mod catalogue;
mod contact;
mod crashes;
mod crush;
mod drum;
mod dynamic_relaxation;
mod edges;
mod elements;
mod experiments;
mod facets;
mod hertz;
mod invariance;
mod joints;
mod laws;
mod lines;
mod materials;
mod measure;
mod plates;
mod pressure_patch;
mod report;
mod ridges;
mod rigid;
pub mod row;
pub mod scene;
mod sections;
mod sheets;
mod sliding;
mod solid_bars;
mod solid_cells;
mod solid_patches;
pub mod solids;
mod stability;
mod stacks;
mod steps;
mod taylor;
mod walls;

pub use bench::Bench;
pub use catalogue::CATALOGUE;
pub use row::CheckRow;

use crumple::cli::VerifyArgs;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Exit codes of README.md.
const PASSED: u8 = 0;
const BAD_INPUT: u8 = 2;
const OUTSIDE: u8 = 3;

/// An entry of the catalogue.
pub struct Entry {
    /// Id, such as A01.
    pub id: &'static str,
    /// Title.
    pub title: &'static str,
    /// Checks of the entry; empty if none is possible yet.
    pub checks: &'static [Check],
    /// Parts of the entry that are not covered and why; empty if all are.
    pub open: &'static str,
}

/// A comparison that is run as a whole.
pub struct Check {
    /// Name, unique within its entry.
    pub name: &'static str,
    /// True if it takes at most a second or two: a test then runs it too.
    pub quick: bool,
    /// Function that runs the check; an error gives the reason why there is nothing to compare.
    pub run: fn(&Bench) -> Result<Vec<CheckRow>, String>,
}

/// Result of a check.
pub struct Outcome {
    /// Entry of the catalogue.
    pub id: &'static str,
    /// Name of the check.
    pub name: &'static str,
    /// Rows, or the reason why there are none.
    pub rows: Result<Vec<CheckRow>, String>,
}

impl Outcome {
    /// Returns true if all rows are within their tolerances.
    pub fn passes(&self) -> bool {
        self.rows.as_ref().is_ok_and(|rows| rows.iter().all(CheckRow::passes))
    }
}

/// Runs `crumple verify`; returns the exit code.
pub fn run(args: &VerifyArgs) -> u8 {
    let named = |id: &str, e: &Entry| e.id.eq_ignore_ascii_case(id.trim());
    let unknown: Vec<&str> = args
        .only
        .iter()
        .map(String::as_str)
        .filter(|id| !CATALOGUE.iter().any(|e| named(id, e)))
        .collect();
    if !unknown.is_empty() {
        let near = |id: &&str| {
            let alike = |e: &&Entry| strsim::damerau_levenshtein(&id.to_uppercase(), e.id);
            CATALOGUE.iter().min_by_key(alike).map(|e| format!("{} ({})", e.id, e.title))
        };
        let near: Vec<String> = unknown.iter().filter_map(near).collect();
        let known: Vec<&str> = CATALOGUE.iter().map(|e| e.id).collect();
        eprintln!(
            "error: the catalogue has no entry {}; did you mean {}?",
            unknown.join(", "),
            near.join(", ")
        );
        eprintln!("  choose from {}", known.join(", "));
        return BAD_INPUT;
    }
    let wanted = |e: &&Entry| args.only.is_empty() || args.only.iter().any(|id| named(id, e));
    let entries: Vec<&Entry> = CATALOGUE.iter().filter(wanted).collect();
    let checks: Vec<(&'static str, &'static Check)> = CATALOGUE
        .iter()
        .filter(wanted)
        .flat_map(|e| e.checks.iter().map(|c| (e.id, c)))
        .filter(|(_, c)| c.quick || !args.quick)
        .collect();
    let jobs = args.out.join("jobs");
    if let Err(error) = std::fs::create_dir_all(&jobs) {
        eprintln!(
            "error: cannot create {}: {error}; choose another folder with --out",
            jobs.display()
        );
        return BAD_INPUT;
    }
    let mut outcomes = run_all(&checks, &Bench::new(Some(jobs)));
    refuse_repeats(&mut outcomes);
    let report = report::Report { entries: &entries, outcomes: &outcomes, quick: args.quick };
    crumple::stdout::write(format_args!("{}", report.markdown()));
    if let Err(error) = write(&args.out, &report) {
        eprintln!(
            "error: cannot write to {}: {error}; choose another folder with --out",
            args.out.display()
        );
        return BAD_INPUT;
    }
    if outcomes.iter().all(Outcome::passes) { PASSED } else { OUTSIDE }
}

/// Fails the later check if rows of an entry have the same name.
fn refuse_repeats(outcomes: &mut [Outcome]) {
    let mut seen = BTreeSet::new();
    for o in outcomes {
        let rows = o.rows.iter().flatten();
        let again = rows
            .filter(|r| !seen.insert((o.id, r.quantity.clone(), r.variant.clone())))
            .map(|r| (&r.quantity, &r.variant));
        if let Some((quantity, variant)) = again.last() {
            o.rows = Err(format!(
                "two rows of {} have the name {quantity}, {variant}: add their difference to the \
                 variants",
                o.id
            ));
        }
    }
}

fn write(out: &Path, report: &report::Report<'_>) -> std::io::Result<()> {
    std::fs::write(out.join("VERIFICATION.md"), report.markdown())?;
    std::fs::write(out.join("VERIFICATION_ROWS.md"), report.rows())?;
    std::fs::write(out.join("verification.json"), report.json())
}

/// Runs checks in parallel and shows the progress; returns outcomes in the order of the checks.
fn run_all(checks: &[(&'static str, &'static Check)], bench: &Bench) -> Vec<Outcome> {
    let bar = std::io::stderr().is_terminal().then(|| {
        let bar = ProgressBar::new(checks.len() as u64);
        let style = ProgressStyle::with_template(
            "{bar:20} {pos}/{len} elapsed {elapsed} remaining {eta} {wide_msg}",
        );
        style.into_iter().for_each(|s| bar.set_style(s));
        bar
    });
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(&(id, check)) = checks.get(index) else { return };
            let began = Instant::now();
            let outcome = Outcome { id, name: check.name, rows: (check.run)(bench) };
            let verdict = if outcome.passes() { "pass" } else { "FAIL" };
            let line =
                format!("{id} {}: {verdict} ({:.1} s)", check.name, began.elapsed().as_secs_f64());
            match &bar {
                Some(bar) => {
                    bar.println(line);
                    bar.inc(1);
                }
                None => eprintln!("{line}"),
            }
            done.lock().unwrap_or_else(|held| held.into_inner()).push((index, outcome));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..cores).for_each(|_| _ = scope.spawn(work)));
    bar.iter().for_each(|b| b.finish_and_clear());
    let mut done = done.into_inner().unwrap_or_else(|held| held.into_inner());
    done.sort_by_key(|d| d.0);
    done.into_iter().map(|d| d.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_with_equal_keys_are_refused() {
        let row = |quantity: &str| CheckRow::new(quantity, "lagrange", "", 1.0);
        let outcome = |id, quantities: &[&str]| Outcome {
            id,
            name: "x",
            rows: Ok(quantities.iter().map(|q| row(q)).collect()),
        };
        let mut all = [
            outcome("A01", &["a", "b"]),
            outcome("A03", &["a"]),
            outcome("A01", &["c"]),
            outcome("A01", &["d", "a"]),
        ];
        refuse_repeats(&mut all);
        assert_eq!(all.map(|o| o.rows.is_ok()), [true, true, true, false]);
    }
}
