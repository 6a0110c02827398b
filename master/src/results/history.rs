//! `history.csv`: one row per history interval, summed over the workers' contributions.

use crate::input::job::{Model, fastest_wave};
use crate::results::histories::HistoryFiles;
use crate::results::table::{CsvTable, Tables, Unwritten};
use crumple_proto::checkpoint::MOST;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::report::HistoryPart;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the file.
pub(crate) const FILE: &str = "history.csv";

/// Last columns: times of this machine, and counts that depend on the number of workers.
pub(crate) const ACCOUNTS: [&str; 10] = [
    "wall [s]",
    "cpu of all workers [s]",
    "cpu of the critical path [s]",
    "cpu of renewals [s]",
    "low redecompositions",
    "high redecompositions",
    "surface updates",
    "interior elements",
    "interface elements",
    "exterior elements",
];

/// Returns true if a column has a mean or an extreme since the row before, so that it depends on
/// the interval of the rows.
pub(crate) fn is_since_row(column: &str) -> bool {
    let name = column.rsplit_once(" [").map_or(column, |(name, _)| name);
    name.ends_with("penetration")
        || ["x", "y", "z"].iter().any(|c| name.ends_with(&format!("mean force {c}")))
}

/// A complete row, summed over workers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HistoryRow {
    /// The sums; penetration is the maximum.
    pub sum: HistoryPart,
    /// Energy error as a fraction of the energy supplied.
    pub error: f64,
    /// Energy of velocity oscillations from step to step, as a fraction of the energy supplied,
    /// of the internal energy, or of the largest energy supplied so far if that is larger. An
    /// unstable step keeps the energy balance, but oscillates.
    pub swing: f64,
    /// Energy created by contact, as a fraction of the largest energy so far. Contact stores and
    /// dissipates energy, so the work of its forces on the nodes so far, friction included, is
    /// positive only if it creates energy. The energy balance does not show this, because it
    /// includes the work of contact as it is.
    pub created: f64,
}

/// Data of the master for a complete row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras {
    /// Wall time since the start [s].
    pub wall: f64,
    /// Sum over cycles and workers of the CPU time so far [s].
    pub cpu_total: f64,
    /// Sum over cycles of the largest CPU time without contact plus the largest of contact so far
    /// [s].
    pub cpu_critical: f64,
    /// CPU time of redecompositions so far, maximum over workers [s].
    pub cpu_renewal: f64,
    /// Number of low redecompositions so far.
    pub low: u64,
    /// Number of high redecompositions so far.
    pub high: u64,
    /// Number of updates of the contact surface because elements have failed, so far.
    pub erosions: u64,
    /// Interior, interface and exterior elements of all workers.
    pub classes: [u64; 3],
}

/// Extremes and last rows of a history: all that it knows of the rows so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Course {
    /// First complete row.
    pub first: Option<HistoryRow>,
    /// Last complete row.
    pub last: Option<HistoryRow>,
    /// Largest |error| so far.
    pub worst_error: f64,
    /// Largest penetration so far as a fraction of the contact thickness.
    pub penetration: f64,
    /// Largest number of pairs so far.
    pub pairs: u64,
    /// Cycle of the first of the last consecutive rows with much energy in oscillations from step
    /// to step.
    swings_from: Option<u64>,
    /// Largest energy supplied so far [energy].
    most_came_in: f64,
    /// Largest sum of kinetic, internal and hourglass energy so far [energy].
    pub most: f64,
    /// Largest `created` so far.
    pub worst_created: f64,
}

impl Course {
    /// Returns true if the cycles of its rows are possible ones.
    pub fn is_possible(&self) -> bool {
        let last = self.last.as_ref().map_or(0, |row| row.sum.cycle);
        last <= MOST && self.swings_from.is_none_or(|from| from <= last)
    }

    /// Appends a row.
    fn push(&mut self, row: HistoryRow) {
        let from = self.swings_from.unwrap_or(row.sum.cycle);
        self.swings_from = (row.swing > MUCH_SWING).then_some(from);
        self.first.get_or_insert_with(|| row.clone());
        self.last = Some(row);
    }

    /// Returns true if velocities oscillate more than in a stable motion, and much in the row
    /// before too: a load that begins suddenly changes them much in one step. For steps
    /// `above_limit` it also returns true if the last rows have had much energy in oscillations for
    /// longer than a rebound.
    pub fn swings_on(&self, above_limit: bool) -> bool {
        let Some(last) = &self.last else { return false };
        let cycles = self.swings_from.map_or(0, |from| last.sum.cycle - from);
        (above_limit && cycles >= TURNING) || (cycles > 0 && last.swing > MOST_SWING)
    }
}

/// The history of a run.
pub struct History {
    file: CsvTable,
    workers: usize,
    walls: Vec<String>,
    kinds: HistoryFiles,
    /// Sums over the workers that have contributed to a row, and their number.
    parts: BTreeMap<u64, (usize, HistoryPart<ExactSum>)>,
    /// The rows so far.
    pub course: Course,
    /// Messages about rows that are lost because a file was removed.
    pub lost: Vec<String>,
    /// Number of these that the user knows.
    said: usize,
    /// True with subcycles. The energy then oscillates about its balance by a fraction of the
    /// largest energy supplied so far, even if part of that energy has left the model.
    subcycled: bool,
    /// Work of contact that counts as zero [energy].
    round_off: f64,
}

/// Returns the error of an energy balance over the energy that came in; infinity if the balance is
/// not a number, 0 if no energy came in [-].
fn relative_error(balance: f64, came_in: f64) -> f64 {
    match (balance.is_nan(), came_in > 0.0) {
        (true, _) => f64::INFINITY,
        (false, true) => balance / came_in,
        (false, false) => 0.0,
    }
}

/// Energy supplied, as a fraction of the largest so far, below which the error of the balance is
/// that of what has gone through the model: a tool that stops gives its energy back.
const LEAST_SHARE: f64 = 1e-3;
/// Returns the energy by which the error of the balance is divided, from the energy that came in
/// and its largest value so far [energy].
fn divisor(came_in: f64, most: f64, subcycled: bool) -> f64 {
    came_in.max(if subcycled { most } else { LEAST_SHARE * most })
}

/// Fraction of the energy in oscillations that a step above the stability limit soon reaches and
/// keeps. A stable step may reach it too: for a few cycles when a coarse bar rebounds from a
/// wall, or longer when the model hardly moves.
const MUCH_SWING: f64 = 0.1;
/// Number of cycles for which a stable motion may exceed this fraction at a rebound.
const TURNING: u64 = 50;
/// Fraction of the speed of sound below which a node is at rest for the work of contact. Forces
/// on nodes at rest are accurate to about a millionth of the velocity of the waves that caused
/// them.
const STILL: f64 = 1e-6;
/// Largest fraction of the stored energy that a stable vibration has in oscillations at its
/// turning point: `2 s^2`, where s is the step over the stable step.
const MOST_SWING: f64 = 2.0;

/// Names of derived units for a header.
pub(crate) struct Labels {
    pub(crate) length: String,
    pub(crate) time: String,
    pub(crate) mass: String,
    pub(crate) velocity: String,
    pub(crate) acceleration: String,
    pub(crate) energy: String,
    pub(crate) momentum: String,
    pub(crate) force: String,
    pub(crate) moment: String,
    angular: String,
}

impl Labels {
    /// Derives the names from the first three words of the job's units (length, time, mass), or
    /// from dimensions if the job has none.
    pub(crate) fn from_units(units: &str) -> Self {
        let words: Vec<&str> =
            units.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
        let (l, t, m) = match words[..] {
            [l, t, m, ..] => (l, t, m),
            _ => ("length", "time", "mass"),
        };
        let named = |energy: &str, force: &str| {
            (energy.to_string(), force.to_string(), format!("{force} {l}"))
        };
        let product = format!("{m} {l}^2/{t}^2");
        let (energy, force, moment) = match (l, t, m) {
            ("mm", "ms", "kg") => named("J", "kN"),
            ("mm", "s", "t" | "tonne") => named("mJ", "N"),
            ("m", "s", "kg") => named("J", "N"),
            ("in", "s", "slinch") => named("in lbf", "lbf"),
            ("ft", "s", "slug") => named("ft lbf", "lbf"),
            _ => (product.clone(), format!("{m} {l}/{t}^2"), product),
        };
        Self {
            length: l.into(),
            time: t.into(),
            mass: m.into(),
            velocity: format!("{l}/{t}"),
            acceleration: format!("{l}/{t}^2"),
            energy,
            momentum: format!("{m} {l}/{t}"),
            force,
            moment,
            angular: format!("{m} {l}^2/{t}"),
        }
    }
}

/// Returns the names of walls, or their numbers if they have no names.
pub(crate) fn wall_names(walls: &[crumple_proto::wall::ResolvedWall]) -> Vec<String> {
    walls.iter().enumerate().map(|(i, wall)| wall.label(i)).collect()
}

/// Returns the names of the walls that the run had from its start. Only these have columns in
/// `history.csv`.
fn first_walls(model: &Model) -> Vec<String> {
    let mut names = wall_names(&model.settings.walls);
    names.truncate(names.len() - model.job.restart.wall.len());
    names
}

/// Returns the names of the columns of a job's `history.csv`, with their units.
pub fn columns(model: &Model) -> Vec<String> {
    let (u, walls) = (Labels::from_units(&model.job.units), first_walls(model));
    let mut header = vec![format!("time [{}]", u.time), "cycle".into(), format!("dt [{}]", u.time)];
    for name in [
        "kinetic",
        "internal",
        "hourglass",
        "contact work",
        "friction work",
        "wall work",
        "external work",
    ] {
        header.push(format!("{name} [{}]", u.energy));
    }
    header.push("energy error [-]".into());
    header.extend(["x", "y", "z"].map(|c| format!("momentum {c} [{}]", u.momentum)));
    header.extend(["x", "y", "z"].map(|c| format!("angular momentum {c} [{}]", u.angular)));
    header.extend([
        "pairs".into(),
        "penetration [fraction of contact thickness]".into(),
        "controlling element".into(),
    ]);
    for wall in &walls {
        header.extend(["x", "y", "z"].map(|c| format!("{wall} impulse {c} [{}]", u.momentum)));
        header.extend(["x", "y", "z"].map(|c| format!("{wall} mean force {c} [{}]", u.force)));
    }
    header.extend(ACCOUNTS.map(String::from));
    header
}

impl History {
    /// Creates the file and the histories by kind, or continues those of a `course`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn new(
        tables: Tables<'_>,
        workers: usize,
        model: &Model,
        course: Course,
    ) -> Result<Self, Unwritten> {
        let walls = first_walls(model);
        Ok(Self {
            kinds: HistoryFiles::new(tables, model, course.last.as_ref().map(|row| &row.sum))?,
            file: tables.open(FILE, columns(model))?,
            workers,
            walls,
            parts: BTreeMap::new(),
            course,
            lost: Vec::new(),
            said: 0,
            subcycled: model.settings.subcycles > 1,
            round_off: 0.5 * model.total_mass() * (STILL * fastest_wave(&model.job)).powi(2),
        })
    }

    /// Adds a worker's contribution, and writes the row when it is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_part(&mut self, part: HistoryPart<ExactSum>, extras: Extras) -> csv::Result<()> {
        let number = part.row;
        match self.parts.entry(number) {
            Entry::Vacant(entry) => drop(entry.insert((1, part))),
            Entry::Occupied(mut entry) => {
                entry.get_mut().0 += 1;
                entry.get_mut().1.merge(&part);
            }
        }
        if self.parts[&number].0 < self.workers {
            return Ok(());
        }
        let sum = self.parts.remove(&number).unwrap_or_default().1.values();
        // The initial energy is that of the first row minus the work done until then.
        let initial = self.course.first.as_ref().map_or(&sum, |f| &f.sum).energies.balance(0.0);
        let came_in = initial.max(sum.energies.external.abs()).max(sum.energies.internal.abs());
        self.course.most_came_in = self.course.most_came_in.max(came_in);
        let divisor = divisor(came_in, self.course.most_came_in, self.subcycled);
        let error = relative_error(sum.energies.balance(initial), divisor);
        let there =
            sum.energies.supplied(initial).max(sum.energies.internal).max(self.course.most_came_in);
        let swing = if there > 0.0 { sum.energies.swing / there } else { 0.0 };
        self.course.worst_error = self.course.worst_error.max(error.abs());
        self.course.penetration = self.course.penetration.max(sum.penetration);
        self.course.pairs = self.course.pairs.max(sum.pairs);
        let e = &sum.energies;
        self.course.most = self.course.most.max(e.kinetic.max(0.0) + e.internal + e.hourglass);
        let created = created(e.contact, self.course.most, self.round_off);
        self.course.worst_created = self.course.worst_created.max(created);
        let row = HistoryRow { sum, error, swing, created };
        self.check_files()?;
        self.write(&row, extras)?;
        self.kinds.write(&row.sum)?;
        self.course.push(row);
        Ok(())
    }

    /// Makes files again that were removed, and keeps a message about each.
    ///
    /// # Errors
    /// A file cannot be made.
    pub fn check_files(&mut self) -> io::Result<()> {
        let mut lost: Vec<PathBuf> = Vec::new();
        for table in self.kinds.tables().chain([&mut self.file]) {
            lost.extend(table.check()?);
        }
        lost.iter().for_each(|path| self.add_lost(path));
        Ok(())
    }

    /// Returns the messages about lost rows that are new since the last call.
    pub fn take_unsaid(&mut self) -> Vec<String> {
        let from = std::mem::replace(&mut self.said, self.lost.len());
        self.lost[from..].to_vec()
    }

    /// Keeps a message about a file that was removed and made again.
    pub fn add_lost(&mut self, path: &Path) {
        let until = self.course.last.as_ref().map_or(0.0, |row| row.sum.time);
        self.lost.push(format!(
            "{} was removed during the run: its rows until time {until:.6e} are lost, and it \
             begins again with its header",
            path.display()
        ));
    }

    fn write(&mut self, row: &HistoryRow, extras: Extras) -> csv::Result<()> {
        let s = &row.sum;
        let e = &s.energies;
        let number = |a: f64| format!("{a:.9e}");
        let mut record = vec![number(s.time), s.cycle.to_string(), number(s.dt)];
        let energies = [
            e.kinetic,
            e.internal,
            e.hourglass,
            e.contact,
            e.friction,
            e.wall,
            e.external,
            row.error,
        ];
        record.extend(energies.into_iter().chain(s.momentum).chain(s.angular_momentum).map(number));
        record.extend([s.pairs.to_string(), number(s.penetration)]);
        let of_contact = s.contact_dt < s.controlling_dt;
        let controlling = if of_contact {
            "contact".into()
        } else {
            s.controlling.element.map_or(String::new(), |id| id.to_string())
        };
        record.push(controlling);
        for (w, impulse) in s.wall_impulse.iter().enumerate().take(self.walls.len()) {
            let before = self
                .course
                .last
                .as_ref()
                .map_or((0.0, [0.0; 3]), |l| (l.sum.time, l.sum.wall_impulse[w]));
            let dt = s.time - before.0;
            record.extend(impulse.map(number));
            // The wall's force on the model, mean since the last row.
            record.extend(
                (0..3)
                    .map(|c| number(if dt > 0.0 { (impulse[c] - before.1[c]) / dt } else { 0.0 })),
            );
        }
        record.extend(
            [extras.wall, extras.cpu_total, extras.cpu_critical, extras.cpu_renewal].map(number),
        );
        let counts = [extras.low, extras.high, extras.erosions].into_iter().chain(extras.classes);
        record.extend(counts.map(|n| n.to_string()));
        self.file.write_record(&record)?;
        Ok(self.file.flush()?)
    }
}

/// Returns the energy created by contact as a fraction of the largest energy so far. `work` is
/// the work of contact forces; a value up to `round_off` counts as zero.
fn created(work: f64, most: f64, round_off: f64) -> f64 {
    if work > round_off { work / most.max(work) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_creates_what_it_gives_beyond_what_it_took() {
        assert_eq!(created(-3.0, 10.0, 1e-9), 0.0, "it dissipates");
        assert_eq!(created(1e-10, 1e-10, 1e-9), 0.0, "next to nothing moves");
        assert_eq!(created(0.5, 10.0, 1e-9), 0.05);
        assert_eq!(created(2.0, 1.0, 1e-9), 1.0, "all of it");
    }

    #[test]
    fn energies_that_are_not_numbers_have_no_small_error() {
        assert_eq!(relative_error(0.5, 10.0), 0.05);
        assert_eq!(relative_error(0.5, 0.0), 0.0, "no energy");
        assert_eq!(
            [0.0, 10.0].map(|came_in| relative_error(f64::NAN, came_in)),
            [f64::INFINITY; 2]
        );
    }

    /// Round-off of energy that a tool gave back is no error; a hundredth of that energy is one.
    #[test]
    fn a_tool_that_rests_hides_no_gain_of_energy() {
        let rest = divisor(0.0, 10.0, false);
        assert_eq!([rest, divisor(5.0, 10.0, false), divisor(5.0, 10.0, true)], [0.01, 5.0, 10.0]);
        assert!(relative_error(1e-11, rest) < 1e-8);
        assert!(relative_error(0.1, rest) > 1.0);
    }

    /// Rows with these energies in oscillations, one each ten cycles.
    fn swings_on(swings: &[f64], above_limit: bool) -> bool {
        let mut course = Course::default();
        for (cycle, &swing) in (0..).step_by(10).zip(swings) {
            let mut row = HistoryRow { swing, ..HistoryRow::default() };
            row.sum.cycle = cycle;
            course.push(row);
        }
        course.swings_on(above_limit)
    }

    #[test]
    fn a_sudden_load_is_no_unstable_step() {
        assert!(!swings_on(&[0.0, 200.0], false), "it begins");
        assert!(!swings_on(&[0.0, 200.0, 0.7], false), "the step after");
        assert!(swings_on(&[0.0, 0.2, 3.0], false), "more from row to row");
        assert!(!swings_on(&[0.2; 5], true), "a rebound");
        assert!(swings_on(&[0.2; 6], true), "longer than a rebound");
        assert!(!swings_on(&[0.2; 6], false), "below the limit");
    }
}
