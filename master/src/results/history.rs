//! `history.csv`: one row per history interval, summed over the workers' contributions.

use crate::input::job::{Model, fastest_wave};
use crate::results::histories::{Histories, NAMES};
use crate::results::workers;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::report::HistoryPart;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Name of the file.
const FILE: &str = "history.csv";

/// A complete row, summed over workers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HistoryRow {
    /// The sums; penetration is the maximum.
    pub sum: HistoryPart,
    /// Energy error as a fraction of the energy supplied.
    pub error: f64,
    /// Energy of velocity oscillations from step to step, as a fraction of the energy supplied
    /// or of the internal energy if that is larger. An unstable step keeps the energy balance, but
    /// oscillates.
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
    /// Sum over cycles of the slowest worker's CPU time so far [s].
    pub cpu_critical: f64,
    /// CPU time of redecompositions so far, maximum over workers [s].
    pub cpu_renewal: f64,
    /// Number of low redecompositions so far.
    pub low: u64,
    /// Number of high redecompositions so far.
    pub high: u64,
    /// Number of renewals because elements have failed, so far.
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
    most_came_in: f64,
    /// Largest sum of kinetic, internal and hourglass energy so far [energy].
    most: f64,
    /// Largest `created` so far.
    pub worst_created: f64,
}

/// The history of a run.
pub struct History {
    file: csv::Writer<File>,
    workers: usize,
    walls: Vec<String>,
    kinds: Histories,
    /// Sums over the workers that have contributed to a row, and their number.
    parts: BTreeMap<u64, (usize, HistoryPart<ExactSum>)>,
    /// The rows so far.
    pub course: Course,
    /// True with subcycles. The energy then oscillates about its balance by a fraction of the
    /// largest energy supplied so far, even if part of that energy has left the model.
    subcycled: bool,
    /// Work of contact that counts as zero [energy].
    round_off: f64,
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
pub(crate) fn wall_names(walls: &[crumple_proto::wall::Wall]) -> Vec<String> {
    walls.iter().enumerate().map(|(i, wall)| wall.label(i)).collect()
}

/// Returns the names of the walls that the run had from its start. Only these have columns in
/// `history.csv`.
fn first_walls(model: &Model) -> Vec<String> {
    let mut names = wall_names(&model.settings.walls);
    names.truncate(names.len() - model.job.restart.wall.len());
    names
}

/// A file that cannot be written, and the reason.
pub(crate) type Unwritten = (PathBuf, std::io::Error);

/// The files of the histories, and the rows that they keep.
#[derive(Clone, Copy)]
pub struct Tables<'a> {
    /// Folder of the files.
    pub dir: &'a Path,
    /// Length to keep of each file, if the run continues from a checkpoint [byte].
    pub lengths: Option<&'a BTreeMap<String, u64>>,
}

impl Tables<'_> {
    /// Opens a file: a new one with this header, or the one of the run that continues, without the
    /// rows after the checkpoint.
    pub(crate) fn open<H: AsRef<[u8]>>(
        &self,
        name: &str,
        header: impl IntoIterator<Item = H>,
    ) -> Result<csv::Writer<File>, Unwritten> {
        let path = self.dir.join(name);
        let failed = |error: std::io::Error| (path.clone(), error);
        if let Some(&length) = self.lengths.and_then(|lengths| lengths.get(name)) {
            let mut file = File::options().write(true).open(&path).map_err(failed)?;
            if file.metadata().map_err(failed)?.len() < length {
                let why = "the file is shorter than at the checkpoint: it was changed meanwhile";
                return Err(failed(std::io::Error::other(why)));
            }
            file.set_len(length).map_err(failed)?;
            file.seek(SeekFrom::End(0)).map_err(failed)?;
            return Ok(csv::Writer::from_writer(file));
        }
        let mut file = csv::Writer::from_path(&path).map_err(|error| failed(error.into()))?;
        file.write_record(header).map_err(|error| failed(error.into()))?;
        file.flush().map_err(failed)?;
        Ok(file)
    }

    /// Returns the present length of each file.
    pub(crate) fn present(dir: &Path) -> BTreeMap<String, u64> {
        let names = NAMES.iter().copied().chain([FILE, workers::FILE]);
        let length = |name: &str| std::fs::metadata(dir.join(name)).ok().map(|m| m.len());
        names.filter_map(|name| Some((name.to_string(), length(name)?))).collect()
    }
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
    let accounts = [
        "wall [s]",
        "cpu of all workers [s]",
        "cpu of the critical path [s]",
        "cpu of renewals [s]",
        "low redecompositions",
        "high redecompositions",
        "renewals after erosion",
        "interior elements",
        "interface elements",
        "exterior elements",
    ];
    header.extend(accounts.map(String::from));
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
            kinds: Histories::new(tables, model, course.last.as_ref().map(|row| &row.sum))?,
            file: tables.open(FILE, columns(model))?,
            workers,
            walls,
            parts: BTreeMap::new(),
            course,
            subcycled: model.settings.subcycles > 1,
            round_off: 0.5 * model.total_mass() * (STILL * fastest_wave(&model.job)).powi(2),
        })
    }

    /// Returns true if velocities oscillate more than in a stable motion. For steps `above_limit`
    /// it also returns true if the last rows have had much energy in oscillations for longer than
    /// a rebound.
    pub fn swings_on(&self, above_limit: bool) -> bool {
        let Some(last) = &self.course.last else { return false };
        let long = self.course.swings_from.is_some_and(|from| last.sum.cycle - from >= TURNING);
        (above_limit && long) || last.swing > MOST_SWING
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
        self.course.most_came_in =
            if self.subcycled { self.course.most_came_in.max(came_in) } else { came_in };
        let came_in = self.course.most_came_in;
        let error = if came_in > 0.0 { sum.energies.balance(initial) / came_in } else { 0.0 };
        let there = sum.energies.supplied(initial).max(sum.energies.internal);
        let swing = if there > 0.0 { sum.energies.swing / there } else { 0.0 };
        self.course.worst_error = self.course.worst_error.max(error.abs());
        self.course.penetration = self.course.penetration.max(sum.penetration);
        self.course.pairs = self.course.pairs.max(sum.pairs);
        let e = &sum.energies;
        self.course.most = self.course.most.max(e.kinetic.max(0.0) + e.internal + e.hourglass);
        let created = created(e.contact, self.course.most, self.round_off);
        self.course.worst_created = self.course.worst_created.max(created);
        let row = HistoryRow { sum, error, swing, created };
        let swings_from = self.course.swings_from.unwrap_or(row.sum.cycle);
        self.course.swings_from = (swing > MUCH_SWING).then_some(swings_from);
        self.write(&row, extras)?;
        self.kinds.write(&row.sum)?;
        self.course.first.get_or_insert_with(|| row.clone());
        self.course.last = Some(row);
        Ok(())
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
            s.controlling.map_or(String::new(), |id| id.to_string())
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
}
