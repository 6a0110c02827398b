//! Histories by kind in addition to `history.csv`: `parts.csv`, `walls.csv`, `contacts.csv` and
//! `contact_pairs.csv`, `nodes.csv`, `sections.csv`, `transducers.csv`, `airbags.csv`. Each row
//! holds one object at one time, so that files of many parts stay readable and programs can filter.
//! Rows have the times of `history.csv` and refer to the same instants.

use crate::input::job::Model;
use crate::input::job::axes::NodeAxes;
use crate::results::history::{self, Labels};
use crate::results::table::{CsvTable, Tables, Unwritten};
use crumple_proto::histories::NodeGroup;
use crumple_proto::ids::NodeId;
use crumple_proto::report::HistoryPart;
use std::collections::HashMap;
use std::io;

/// The files of a run. Files of kinds that the scene does not have, or that the job does not
/// request, are absent.
pub struct HistoryFiles {
    /// Id and name per part of the settings.
    parts: Vec<(u32, String)>,
    walls: Vec<String>,
    groups: Vec<NodeGroup>,
    sections: Vec<String>,
    transducers: Vec<String>,
    airbags: Vec<String>,
    of_parts: Option<CsvTable>,
    of_walls: Option<CsvTable>,
    of_contacts: Option<(CsvTable, CsvTable)>,
    of_nodes: Option<CsvTable>,
    of_sections: Option<CsvTable>,
    of_transducers: Option<CsvTable>,
    of_airbags: Option<CsvTable>,
    /// Indices of the parts in contact.
    touching: Vec<u32>,
    last_walls: (f64, Vec<[f64; 3]>),
}

/// Names of all files.
pub const NAMES: [&str; 8] = [
    "parts.csv",
    "walls.csv",
    "contacts.csv",
    "contact_pairs.csv",
    "nodes.csv",
    "sections.csv",
    "transducers.csv",
    "airbags.csv",
];

impl HistoryFiles {
    /// Creates the files and removes those of an older run, or continues after the row `last`.
    ///
    /// # Errors
    /// A file cannot be written or removed.
    pub(crate) fn new(
        tables: Tables<'_>,
        model: &Model,
        last: Option<&HistoryPart>,
    ) -> Result<Self, Unwritten> {
        remove_old_files(tables)?;
        let (settings, asked) = (&model.settings, &model.settings.histories);
        let files = FileOpener { tables, units: Labels::from_units(&model.job.units) };
        let with_walls = model.job.output.walls && !settings.walls.is_empty();
        let touches = |id: u32| settings.contact.as_ref().is_some_and(|c| c.takes_part(id));
        let touching = (0..settings.parts.len() as u32)
            .filter(|&i| touches(settings.parts[i as usize].id))
            .collect();
        Ok(Self {
            parts: settings.parts.iter().map(|p| (p.id, p.name.clone())).collect(),
            walls: history::wall_names(&settings.walls),
            groups: asked
                .nodes
                .iter()
                .map(|group| NodeGroup { nodes: by_label(&group.nodes), ..group.clone() })
                .collect(),
            sections: asked.sections.iter().map(|s| s.name.clone()).collect(),
            transducers: asked.transducers.iter().map(|t| t.name.clone()).collect(),
            airbags: settings.loads.airbags.iter().map(|bag| bag.name.clone()).collect(),
            of_parts: model.job.output.parts.then(|| files.parts()).transpose()?,
            of_walls: with_walls.then(|| files.walls()).transpose()?,
            of_contacts: asked.contacts.then(|| files.contacts()).transpose()?,
            of_nodes: (!asked.nodes.is_empty()).then(|| files.nodes()).transpose()?,
            of_sections: (!asked.sections.is_empty()).then(|| files.sections()).transpose()?,
            of_transducers: (!asked.transducers.is_empty())
                .then(|| files.transducers())
                .transpose()?,
            of_airbags: (!settings.loads.airbags.is_empty())
                .then(|| files.airbags())
                .transpose()?,
            touching,
            last_walls: {
                let (time, mut impulses) =
                    last.map_or((0.0, Vec::new()), |row| (row.time, row.wall_impulse.clone()));
                impulses.resize(settings.walls.len(), [0.0; 3]); // walls may be new
                (time, impulses)
            },
        })
    }

    /// Returns all files.
    pub(crate) fn tables(&mut self) -> impl Iterator<Item = &mut CsvTable> {
        let contacts = self.of_contacts.iter_mut().flat_map(|(parts, pairs)| [parts, pairs]);
        let single = [
            &mut self.of_parts,
            &mut self.of_walls,
            &mut self.of_nodes,
            &mut self.of_sections,
            &mut self.of_transducers,
            &mut self.of_airbags,
        ];
        single.into_iter().flatten().chain(contacts)
    }

    /// Writes the rows of one time, from the sums over workers.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&mut self, row: &HistoryPart) -> csv::Result<()> {
        let (time, shares) = (number(row.time), &row.shares);
        if let Some(table) = &mut self.of_parts {
            for ((id, name), p) in self.parts.iter().zip(&shares.parts) {
                let numbers =
                    [p.mass, p.kinetic, p.internal, p.hourglass].into_iter().chain(p.momentum);
                put(table, [time.clone(), id.to_string(), name.clone()], numbers)?;
            }
            table.flush()?;
        }
        if let Some(table) = &mut self.of_walls {
            let (before, last) = &self.last_walls;
            let dt = row.time - before;
            for (w, (name, impulse)) in self.walls.iter().zip(&row.wall_impulse).enumerate() {
                // The wall's force on the model, mean since the last row.
                let mean =
                    [0, 1, 2].map(|c| if dt > 0.0 { (impulse[c] - last[w][c]) / dt } else { 0.0 });
                let gone = row.wall_displacement.get(w).copied().unwrap_or_default();
                put(
                    table,
                    [time.clone(), name.clone()],
                    impulse.iter().copied().chain(mean).chain(gone),
                )?;
            }
            self.last_walls = (row.time, row.wall_impulse.clone());
            table.flush()?;
        }
        if let Some((parts, pairs)) = &mut self.of_contacts {
            let mut sums: HashMap<u32, [f64; 3]> = HashMap::new();
            for pair in &shares.contacts {
                let id = |k: usize| self.parts[pair.parts[k] as usize].0.to_string();
                put(pairs, [time.clone(), id(0), id(1)], pair.force)?;
                for (part, sign) in pair.parts.iter().zip([1.0, -1.0]) {
                    let sum = sums.entry(*part).or_default();
                    (0..3).for_each(|c| sum[c] += sign * pair.force[c]);
                }
            }
            for part in &self.touching {
                let (id, name) = &self.parts[*part as usize];
                let force = sums.get(part).copied().unwrap_or_default();
                put(parts, [time.clone(), id.to_string(), name.clone()], force)?;
            }
            parts.flush()?;
            pairs.flush()?;
        }
        if let Some(table) = &mut self.of_nodes {
            let state = |id: &NodeId| {
                let at = shares.nodes.binary_search_by_key(id, |n| n.id).ok()?;
                shares.nodes.get(at)
            };
            for NodeGroup { name, nodes, axes } in &self.groups {
                let current = axes.and_then(|nodes| {
                    let [a, b, c] = nodes.map(|id| state(&id).map(|n| n.x));
                    NodeAxes::new([a?, b?, c?])
                });
                // Without a node of the axes, or with all of them on one line, there is nothing to
                // write: global components would look like those before.
                if axes.is_some() && current.is_none() {
                    continue;
                }
                let turned = |v: [f64; 3]| current.map_or(v, |axes| axes.of(v));
                for id in nodes {
                    let Some(n) = state(id) else { continue };
                    let numbers = [n.x, turned(n.u), turned(n.v), turned(n.a)];
                    put(
                        table,
                        [time.clone(), name.clone(), id.to_string()],
                        numbers.into_iter().flatten(),
                    )?;
                }
            }
            table.flush()?;
        }
        if let Some(table) = &mut self.of_sections {
            for (name, share) in self.sections.iter().zip(&shares.sections) {
                let (middle, moment) = share.about_midsurface();
                put(
                    table,
                    [time.clone(), name.clone()],
                    share.force.into_iter().chain(moment).chain(middle),
                )?;
            }
            table.flush()?;
        }
        if let Some(table) = &mut self.of_transducers {
            for (name, force) in self.transducers.iter().zip(&shares.transducers) {
                put(table, [time.clone(), name.clone()], *force)?;
            }
            table.flush()?;
        }
        if let Some(table) = &mut self.of_airbags {
            for (name, bag) in self.airbags.iter().zip(&shares.airbags) {
                let numbers = [bag.volume, bag.pressure, bag.temperature, bag.mass, bag.energy];
                let moved = [bag.mass_in, bag.mass_out, bag.enthalpy_in, bag.enthalpy_out];
                let numbers = numbers.into_iter().chain(moved).chain([bag.work]);
                put(table, [time.clone(), name.clone()], numbers)?;
            }
            table.flush()?;
        }
        Ok(())
    }
}

/// Opens the files, each with its columns and their units.
struct FileOpener<'a> {
    tables: Tables<'a>,
    units: Labels,
}

impl FileOpener<'_> {
    fn open(&self, name: &str, columns: FileColumns<'_>) -> Result<CsvTable, Unwritten> {
        self.tables.open(name, columns.header(&self.units.time))
    }

    fn parts(&self) -> Result<CsvTable, Unwritten> {
        let (mass, energy) = (self.units.mass.as_str(), self.units.energy.as_str());
        let scalars =
            [("mass", mass), ("kinetic", energy), ("internal", energy), ("hourglass", energy)];
        let columns = FileColumns {
            words: &["part", "name"],
            scalars: &scalars,
            vectors: &[("momentum", &self.units.momentum)],
        };
        self.open(NAMES[0], columns)
    }

    fn walls(&self) -> Result<CsvTable, Unwritten> {
        let Labels { momentum, force, length, .. } = &self.units;
        let vectors: [(&str, &str); 3] =
            [("impulse", momentum), ("mean force", force), ("displacement", length)];
        self.open(
            NAMES[1],
            FileColumns { words: &["wall"], vectors: &vectors, ..FileColumns::default() },
        )
    }

    fn contacts(&self) -> Result<(CsvTable, CsvTable), Unwritten> {
        let open = |name: &str, words: &[&str]| {
            let vectors: [(&str, &str); 1] = [("force", &self.units.force)];
            self.open(name, FileColumns { words, vectors: &vectors, ..FileColumns::default() })
        };
        Ok((open(NAMES[2], &["part", "name"])?, open(NAMES[3], &["on part", "from part"])?))
    }

    fn nodes(&self) -> Result<CsvTable, Unwritten> {
        let Labels { length, velocity, acceleration, .. } = &self.units;
        let vectors: [(&str, &str); 3] =
            [("displacement", length), ("velocity", velocity), ("acceleration", acceleration)];
        let place = ["x", "y", "z"].map(|axis| (axis, length.as_str()));
        self.open(
            NAMES[4],
            FileColumns { words: &["nodes", "id"], scalars: &place, vectors: &vectors },
        )
    }

    fn sections(&self) -> Result<CsvTable, Unwritten> {
        let Labels { force, moment, length, .. } = &self.units;
        let vectors: [(&str, &str); 3] = [("force", force), ("moment", moment), ("middle", length)];
        self.open(
            NAMES[5],
            FileColumns { words: &["section"], vectors: &vectors, ..FileColumns::default() },
        )
    }

    fn transducers(&self) -> Result<CsvTable, Unwritten> {
        let columns = FileColumns {
            words: &["transducer"],
            vectors: &[("force", &self.units.force)],
            ..FileColumns::default()
        };
        self.open(NAMES[6], columns)
    }

    fn airbags(&self) -> Result<CsvTable, Unwritten> {
        let Labels { length, force, mass, energy, .. } = &self.units;
        let (volume, pressure) = (format!("{length}^3"), format!("{force}/{length}^2"));
        let scalars = [
            ("volume", volume.as_str()),
            ("pressure", pressure.as_str()),
            ("temperature", "K"),
            ("mass", mass.as_str()),
            ("energy", energy.as_str()),
            ("mass in", mass.as_str()),
            ("mass out", mass.as_str()),
            ("enthalpy in", energy.as_str()),
            ("enthalpy out", energy.as_str()),
            ("work", energy.as_str()),
        ];
        let columns =
            FileColumns { words: &["airbag"], scalars: &scalars, ..FileColumns::default() };
        self.open(NAMES[7], columns)
    }
}

/// Removes the files of an older run, except those that a checkpoint continues.
fn remove_old_files(tables: Tables<'_>) -> Result<(), Unwritten> {
    let is_kept = |name: &&str| tables.lengths.is_some_and(|l| l.contains_key(*name));
    for path in NAMES.iter().filter(|name| !is_kept(name)).map(|name| tables.dir.join(name)) {
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err((path, error)),
            _ => {}
        }
    }
    Ok(())
}

/// Columns of a file after the time. Scalars and vectors are names with units.
#[derive(Default)]
struct FileColumns<'c> {
    words: &'c [&'c str],
    scalars: &'c [(&'c str, &'c str)],
    vectors: &'c [(&'c str, &'c str)],
}

impl FileColumns<'_> {
    fn header(self, time: &str) -> Vec<String> {
        let Self { words, scalars, vectors } = self;
        let mut header = vec![format!("time [{time}]")];
        header.extend(words.iter().map(|name| name.to_string()));
        header.extend(scalars.iter().map(|(name, unit)| format!("{name} [{unit}]")));
        for (name, unit) in vectors {
            header.extend(["x", "y", "z"].map(|axis| format!("{name} {axis} [{unit}]")));
        }
        header
    }
}

/// Returns the nodes in the order of the user's ids.
fn by_label(nodes: &[NodeId]) -> Vec<NodeId> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable_by_key(|n| n.label());
    nodes
}

fn number(a: f64) -> String {
    format!("{a:.9e}")
}

/// Writes a row of words and then numbers.
fn put<const N: usize>(
    table: &mut CsvTable,
    words: [String; N],
    numbers: impl IntoIterator<Item = f64>,
) -> csv::Result<()> {
    table.write_record(words.into_iter().chain(numbers.into_iter().map(number)))
}
