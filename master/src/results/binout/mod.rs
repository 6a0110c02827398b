//! `crumple export-binout`: exports the histories of a run as LS-DYNA's binary time histories, for
//! scripts and post-processors that read them.
//!
//! The export uses the tables after the run: `table.rs` reads them, `lsda.rs` writes the format.
//! It contains what the histories have and nothing else; `docs/guide/output.md` lists the channels
//! and what is left out. Names of branches and channels are those of LS-DYNA's own converter
//! (l2a).

mod lsda;
mod table;

use crate::results::{history, provenance};
use crumple_worker::vtu::write_whole;
use lsda::LsdaFile;
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;
use table::{HistoryInstant, ObjectHistory};

/// Name of the file: that of the first file of a family.
pub const NAME: &str = "binout0000";
/// Bytes of a title and of the name of an object.
const LONG: usize = 80;
/// Bytes of a version and a date.
const SHORT: usize = 10;
const AXES: [&str; 3] = ["x", "y", "z"];

/// A channel and the column of its values.
type Channel = (&'static str, &'static str);

const MATSUM: &[Channel] = &[
    ("internal_energy", "internal"),
    ("kinetic_energy", "kinetic"),
    ("hourglass_energy", "hourglass"),
    ("mass", "mass"),
    ("x_momentum", "momentum x"),
    ("y_momentum", "momentum y"),
    ("z_momentum", "momentum z"),
];
const NODOUT: &[Channel] = &[
    ("x_displacement", "displacement x"),
    ("y_displacement", "displacement y"),
    ("z_displacement", "displacement z"),
    ("x_velocity", "velocity x"),
    ("y_velocity", "velocity y"),
    ("z_velocity", "velocity z"),
    ("x_acceleration", "acceleration x"),
    ("y_acceleration", "acceleration y"),
    ("z_acceleration", "acceleration z"),
    ("x_coordinate", "x"),
    ("y_coordinate", "y"),
    ("z_coordinate", "z"),
];
const SECFORC: &[Channel] = &[
    ("x_force", "force x"),
    ("y_force", "force y"),
    ("z_force", "force z"),
    ("x_moment", "moment x"),
    ("y_moment", "moment y"),
    ("z_moment", "moment z"),
    ("x_centroid", "middle x"),
    ("y_centroid", "middle y"),
    ("z_centroid", "middle z"),
];
const RWFORC: &[Channel] =
    &[("x_force", "mean force x"), ("y_force", "mean force y"), ("z_force", "mean force z")];
const ABSTAT: &[Channel] = &[
    ("volume", "volume"),
    ("pressure", "pressure"),
    ("internal_energy", "energy"),
    ("total_mass", "mass"),
    ("gas_temp", "temperature"),
];
const FORCES: &[Channel] =
    &[("x_force", "force x"), ("y_force", "force y"), ("z_force", "force z")];

/// Exports the run in `dir`, prints the file written, and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    crate::stdout::ended(export(dir))
}

/// Writes the histories of the run in `dir` next to them. Returns a message about the file.
///
/// # Errors
/// There is no history or it is damaged, or the file cannot be written.
pub fn export(dir: &Path) -> Result<String, String> {
    let path = dir.join(history::FILE);
    let whole = ObjectHistory::read(&path, &[])?.ok_or_else(|| {
        format!("{}: there is no history; name the folder of a run", path.display())
    })?;
    let mut export = BinoutExport::new(dir, &whole)?;
    export.glstat(&whole)?;
    export.parts(dir)?;
    export.nodes(dir)?;
    export.contacts(dir)?;
    export.sections(dir)?;
    export.walls(dir)?;
    export.airbags(dir)?;
    let file = dir.join(NAME);
    let BinoutExport { out, branches, .. } = export;
    write_whole(&file, |to| out.write(to)).map_err(|error| error.to_string())?;
    Ok(format!("binout: {} in {}", branches.join(", "), file.display()))
}

/// The file, and what all its branches contain.
struct BinoutExport {
    out: LsdaFile,
    /// Cycle of each time.
    cycles: HashMap<String, i64>,
    title: String,
    date: String,
    summary: Value,
    branches: Vec<&'static str>,
}

/// Objects of a branch: their rows, ids and names.
struct BranchObjects {
    places: Vec<usize>,
    ids: Vec<i64>,
    names: Vec<String>,
}

impl BranchObjects {
    /// Numbers all objects from 1. `name` gives the name of an object from its words.
    fn numbered(history: &ObjectHistory, name: impl Fn(&[String]) -> String) -> Self {
        let count = history.objects.len();
        let names = history.objects.iter().map(|words| name(words)).collect();
        Self { places: (0..count).collect(), ids: (1..=count as i64).collect(), names }
    }
}

impl BinoutExport {
    fn new(dir: &Path, whole: &ObjectHistory) -> Result<Self, String> {
        let cycle = whole.column("cycle")?;
        let mut cycles = HashMap::new();
        for instant in &whole.instants {
            let value = whole.values(instant, cycle, (&[0], f64::NAN))?[0];
            cycles.insert(instant.text.clone(), value as i64);
        }
        // A run that was lost has no summary.
        let text = std::fs::read_to_string(dir.join("summary.json")).unwrap_or_default();
        let summary: Value = serde_json::from_str(&text).unwrap_or_default();
        let title = summary["title"].as_str().unwrap_or_default().to_string();
        let date =
            provenance::Provenance::read(dir).map_or(String::new(), |p| p.last().began.clone());
        Ok(Self { out: LsdaFile::new(), cycles, title, date, summary, branches: Vec::new() })
    }

    /// Opens a branch and writes what each has.
    fn begin(&mut self, branch: &'static str, objects: Option<&BranchObjects>) {
        self.branches.push(branch);
        self.out.open(format!("/{branch}/metadata"));
        self.out.add_text("title", [&self.title[..]], LONG);
        self.out.add_text("version", [env!("CARGO_PKG_VERSION")], SHORT);
        self.out.add_text("date", [&self.date[..]], SHORT);
        if let Some(objects) = objects {
            self.out.add_integers("ids", &objects.ids);
            self.out.add_text("legend", objects.names.iter().map(String::as_str), LONG);
            self.out.add_integers("legend_ids", &objects.ids);
        }
    }

    /// Opens the folder of an instant, counted from 0.
    fn open(&mut self, branch: &str, number: usize, instant: &HistoryInstant) {
        self.out.open(format!("/{branch}/d{:06}", number + 1));
        self.out.add_reals("time", &[instant.time]);
        if let Some(cycle) = self.cycles.get(&instant.text) {
            self.out.add_integers("cycle", &[*cycle]);
        }
    }

    /// Writes a branch: the channels of its objects, and those that `derive` computes from them.
    /// `absent` is the value of an object without a row.
    fn branch(
        &mut self,
        (branch, channels): (&'static str, &[Channel]),
        history: &ObjectHistory,
        (objects, absent): (&BranchObjects, f64),
        derive: impl Fn(&HashMap<&str, Vec<f64>>) -> Vec<(&'static str, Vec<f64>)>,
    ) -> Result<(), String> {
        for (number, instant) in history.instants.iter().enumerate() {
            self.open(branch, number, instant);
            let mut known = HashMap::new();
            for (channel, column) in channels {
                let column = history.column(column)?;
                let values = history.values(instant, column, (&objects.places, absent))?;
                self.out.add_reals(channel, &values);
                known.insert(*channel, values);
            }
            for (channel, values) in derive(&known) {
                self.out.add_reals(channel, &values);
            }
        }
        Ok(())
    }

    /// Energies of the whole model. Energies that contact and walls have taken are positive.
    fn glstat(&mut self, whole: &ObjectHistory) -> Result<(), String> {
        let names = ["dt", "kinetic", "internal", "hourglass", "contact work", "wall work"];
        let columns: Vec<usize> =
            names.iter().map(|name| whole.column(name)).collect::<Result<_, _>>()?;
        let external = whole.column("external work")?;
        let has_walls = self.summary["walls"].as_array().is_some_and(|walls| !walls.is_empty());
        self.begin("glstat", None);
        let mut initial = None;
        for (number, instant) in whole.instants.iter().enumerate() {
            let value = |column: usize| -> Result<f64, String> {
                Ok(whole.values(instant, column, (&[0], f64::NAN))?[0])
            };
            let mut numbers = [0.0; 6];
            for (number, column) in numbers.iter_mut().zip(&columns) {
                *number = value(*column)?;
            }
            let [dt, kinetic, internal, hourglass, contact, wall] = numbers;
            let external = value(external)?;
            let total = kinetic + internal + hourglass - contact - wall;
            // The initial energy is that of the first row minus the work done until then.
            let supplied = *initial.get_or_insert(total - external) + external;
            self.open("glstat", number, instant);
            for (channel, value) in [
                ("time_step", dt),
                ("kinetic_energy", kinetic),
                ("internal_energy", internal),
                ("hourglass_energy", hourglass),
                ("sliding_interface_energy", -contact),
                ("external_work", external),
                ("total_energy", total),
                // A model at rest has no energy yet.
                ("energy_ratio", if supplied == 0.0 { 1.0 } else { total / supplied }),
            ] {
                self.out.add_reals(channel, &[value]);
            }
            if has_walls {
                self.out.add_reals("stonewall_energy", &[-wall]);
            }
        }
        Ok(())
    }

    /// Energies, mass and momentum of parts, and from these the velocity of their centres of mass.
    fn parts(&mut self, dir: &Path) -> Result<(), String> {
        let Some(history) = ObjectHistory::read(&dir.join("parts.csv"), &["part", "name"])? else {
            return Ok(());
        };
        let mut objects = BranchObjects::numbered(&history, |words| words[1].clone());
        objects.ids = ids(&history, 0)?;
        self.begin("matsum", Some(&objects));
        self.branch(("matsum", MATSUM), &history, (&objects, f64::NAN), |known| {
            let momenta = ["x_momentum", "y_momentum", "z_momentum"];
            let names = ["x_rbvelocity", "y_rbvelocity", "z_rbvelocity"];
            let velocity = |momentum: &str| {
                known[momentum].iter().zip(&known["mass"]).map(|(p, m)| p / m).collect()
            };
            names.into_iter().zip(momenta.map(velocity)).collect()
        })
    }

    /// Motion of nodes. A node of several groups appears once, with the name of the first.
    fn nodes(&mut self, dir: &Path) -> Result<(), String> {
        let Some(history) = ObjectHistory::read(&dir.join("nodes.csv"), &["nodes", "id"])? else {
            return Ok(());
        };
        let all = ids(&history, 1)?;
        let mut first: HashMap<i64, usize> = HashMap::new();
        for (place, id) in all.iter().enumerate() {
            first.entry(*id).or_insert(place);
        }
        let mut places: Vec<usize> = first.into_values().collect();
        places.sort_unstable();
        let objects = BranchObjects {
            ids: places.iter().map(|&place| all[place]).collect(),
            names: places.iter().map(|&place| history.objects[place][0].clone()).collect(),
            places,
        };
        self.begin("nodout", Some(&objects));
        self.branch(("nodout", NODOUT), &history, (&objects, f64::NAN), |_| Vec::new())
    }

    /// Contact forces: on the first surface of each transducer, or else of each part on each other
    /// part. LS-DYNA has one table for both, whose ids must not mean two things.
    fn contacts(&mut self, dir: &Path) -> Result<(), String> {
        let transducers = ObjectHistory::read(&dir.join("transducers.csv"), &["transducer"])?;
        let words = ["on part", "from part"];
        let (history, absent) = match transducers {
            Some(history) => (history, f64::NAN),
            // Pairs of parts without contact at a time have no row: their force is zero.
            None => match ObjectHistory::read(&dir.join("contact_pairs.csv"), &words)? {
                Some(mut history) => {
                    // The forces on parts have a row at all times.
                    let parts = ObjectHistory::read(&dir.join("contacts.csv"), &["part"])?;
                    parts.iter().for_each(|parts| history.fill(parts));
                    (history, 0.0)
                }
                None => return Ok(()),
            },
        };
        let name = |words: &[String]| match words {
            [on, from] => format!("part {on} from part {from}"),
            _ => words.concat(),
        };
        if history.objects.is_empty() {
            return Ok(()); // there was no contact
        }
        let objects = BranchObjects::numbered(&history, name);
        self.begin("rcforc", Some(&objects));
        // One entry per force, on the side that LS-DYNA calls the slave or surface A.
        self.out.add_integers("side", &vec![0; objects.ids.len()]);
        self.out.add_integers("single", &vec![1; objects.ids.len()]);
        self.branch(("rcforc", FORCES), &history, (&objects, absent), |_| Vec::new())
    }

    /// Forces and moments of sections.
    fn sections(&mut self, dir: &Path) -> Result<(), String> {
        let Some(history) = ObjectHistory::read(&dir.join("sections.csv"), &["section"])? else {
            return Ok(());
        };
        let objects = BranchObjects::numbered(&history, |words| words.concat());
        self.begin("secforc", Some(&objects));
        // No section moves with a rigid body, an accelerometer or a system of axes.
        for name in ["rigidbody", "accelerometer", "coordinate_system"] {
            self.out.add_integers(name, &vec![0; objects.ids.len()]);
        }
        self.branch(("secforc", SECFORC), &history, (&objects, f64::NAN), |known| {
            vec![
                ("total_force", lengths(AXES.map(|axis| &known[&*format!("{axis}_force")][..]))),
                ("total_moment", lengths(AXES.map(|axis| &known[&*format!("{axis}_moment")][..]))),
            ]
        })
    }

    /// Volume and gas of airbags; the pressure is absolute.
    fn airbags(&mut self, dir: &Path) -> Result<(), String> {
        let Some(history) = ObjectHistory::read(&dir.join("airbags.csv"), &["airbag"])? else {
            return Ok(());
        };
        let objects = BranchObjects::numbered(&history, |words| words.concat());
        self.begin("abstat", Some(&objects));
        self.branch(("abstat", ABSTAT), &history, (&objects, f64::NAN), |known| {
            let density = known["total_mass"].iter().zip(&known["volume"]).map(|(m, v)| m / v);
            vec![("density", density.collect())]
        })
    }

    /// Forces of walls on the model. Cylinders have no normal.
    fn walls(&mut self, dir: &Path) -> Result<(), String> {
        let Some(history) = ObjectHistory::read(&dir.join("walls.csv"), &["wall"])? else {
            return Ok(());
        };
        let objects = BranchObjects::numbered(&history, |words| words.concat());
        let normal = |wall: usize, c: usize| self.summary["walls"][wall]["normal"][c].as_f64();
        let normals: Vec<[f64; 3]> = (0..objects.ids.len())
            .map(|wall| [0, 1, 2].map(|c| normal(wall, c).unwrap_or(f64::NAN)))
            .map(|n| n.map(|c| c / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()))
            .collect();
        self.begin("rwforc/forces", Some(&objects));
        self.branch(("rwforc/forces", RWFORC), &history, (&objects, f64::NAN), |known| {
            let force = AXES.map(|axis| &known[&*format!("{axis}_force")][..]);
            let along =
                |(wall, n): (usize, &[f64; 3])| (0..3).map(|c| force[c][wall] * n[c]).sum::<f64>();
            vec![("normal_force", normals.iter().enumerate().map(along).collect())]
        })
    }
}

/// Returns the ids of the objects of a history, in the word with this index.
fn ids(history: &ObjectHistory, word: usize) -> Result<Vec<i64>, String> {
    let id = |words: &Vec<String>| {
        words[word].parse().map_err(|_| format!("`{}` is no id in a history", words[word]))
    };
    history.objects.iter().map(id).collect()
}

/// Returns the lengths of vectors.
fn lengths([x, y, z]: [&[f64]; 3]) -> Vec<f64> {
    (0..x.len()).map(|i| (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt()).collect()
}
