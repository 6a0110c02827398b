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
use crumple_proto::job::ObjectTable;
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
    belts: Vec<String>,
    of_parts: Option<CsvTable>,
    of_walls: Option<CsvTable>,
    of_contacts: Option<(CsvTable, CsvTable)>,
    of_nodes: Option<CsvTable>,
    of_sections: Option<CsvTable>,
    of_transducers: Option<CsvTable>,
    of_airbags: Option<CsvTable>,
    of_belts: Option<CsvTable>,
    /// Indices of the parts in contact.
    touching: Vec<u32>,
    last_walls: (f64, Vec<[f64; 3]>),
}

/// Names of all files.
pub const NAMES: [&str; 9] = [
    "parts.csv",
    "walls.csv",
    "contacts.csv",
    "contact_pairs.csv",
    "nodes.csv",
    "sections.csv",
    "transducers.csv",
    "airbags.csv",
    "belts.csv",
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
        let units = Labels::from_units(&model.job.units);
        let open = |table: ObjectTable| {
            let head = || columns(table, &units).header(&units.time);
            is_written(model, table).then(|| tables.open(file_name(table), head())).transpose()
        };
        let pairs = || tables.open(NAMES[3], contact_pairs(&units).header(&units.time));
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
            belts: settings.belts.names(),
            of_parts: open(ObjectTable::Parts)?,
            of_walls: open(ObjectTable::Walls)?,
            of_contacts: match open(ObjectTable::Contacts)? {
                Some(parts) => Some((parts, pairs()?)),
                None => None,
            },
            of_nodes: open(ObjectTable::Nodes)?,
            of_sections: open(ObjectTable::Sections)?,
            of_transducers: open(ObjectTable::Transducers)?,
            of_airbags: open(ObjectTable::Airbags)?,
            of_belts: open(ObjectTable::Belts)?,
            touching: touching(model).collect(),
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
            &mut self.of_belts,
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
        if let Some(table) = &mut self.of_belts {
            for (name, belt) in self.belts.iter().zip(&shares.belts) {
                let [before, after] = belt.tensions;
                let locked = f64::from(u8::from(belt.locked));
                let numbers = [before, after, belt.length, belt.energy, locked];
                put(table, [time.clone(), name.clone()], numbers)?;
            }
            table.flush()?;
        }
        Ok(())
    }
}

/// Returns the name of a file.
pub fn file_name(table: ObjectTable) -> &'static str {
    match table {
        ObjectTable::Parts => NAMES[0],
        ObjectTable::Walls => NAMES[1],
        ObjectTable::Contacts => NAMES[2],
        ObjectTable::Nodes => NAMES[4],
        ObjectTable::Sections => NAMES[5],
        ObjectTable::Transducers => NAMES[6],
        ObjectTable::Airbags => NAMES[7],
        ObjectTable::Belts => NAMES[8],
    }
}

/// Returns true if a run of the job writes the file.
pub fn is_written(model: &Model, table: ObjectTable) -> bool {
    let (settings, asked) = (&model.settings, &model.settings.histories);
    match table {
        ObjectTable::Parts => model.job.output.parts,
        ObjectTable::Walls => model.job.output.walls && !settings.walls.is_empty(),
        ObjectTable::Contacts => asked.contacts,
        ObjectTable::Nodes => !asked.nodes.is_empty(),
        ObjectTable::Sections => !asked.sections.is_empty(),
        ObjectTable::Transducers => !asked.transducers.is_empty(),
        ObjectTable::Airbags => !settings.loads.airbags.is_empty(),
        ObjectTable::Belts => !settings.belts.is_empty(),
    }
}

/// Returns the head of the file in a run of the job.
pub fn head(model: &Model, table: ObjectTable) -> Vec<String> {
    let units = Labels::from_units(&model.job.units);
    columns(table, &units).header(&units.time)
}

/// Returns the number of columns that name the object of a row; they follow the time.
pub fn words(table: ObjectTable) -> usize {
    match table {
        ObjectTable::Parts | ObjectTable::Contacts | ObjectTable::Nodes => 2,
        ObjectTable::Sections
        | ObjectTable::Transducers
        | ObjectTable::Walls
        | ObjectTable::Airbags
        | ObjectTable::Belts => 1,
    }
}

/// Returns the words that name each object of the file in a run of the job.
pub fn objects(model: &Model, table: ObjectTable) -> Vec<Vec<String>> {
    let (settings, asked) = (&model.settings, &model.settings.histories);
    let part = |i: usize| vec![settings.parts[i].id.to_string(), settings.parts[i].name.clone()];
    let nodes = |group: &NodeGroup| {
        let named = |id: NodeId| vec![group.name.clone(), id.to_string()];
        by_label(&group.nodes).into_iter().map(named).collect::<Vec<_>>()
    };
    match table {
        ObjectTable::Parts => (0..settings.parts.len()).map(part).collect(),
        ObjectTable::Contacts => touching(model).map(|i| part(i as usize)).collect(),
        ObjectTable::Nodes => asked.nodes.iter().flat_map(nodes).collect(),
        ObjectTable::Walls => {
            history::wall_names(&settings.walls).into_iter().map(|w| vec![w]).collect()
        }
        ObjectTable::Sections => asked.sections.iter().map(|s| vec![s.name.clone()]).collect(),
        ObjectTable::Transducers => {
            asked.transducers.iter().map(|t| vec![t.name.clone()]).collect()
        }
        ObjectTable::Airbags => {
            settings.loads.airbags.iter().map(|bag| vec![bag.name.clone()]).collect()
        }
        ObjectTable::Belts => settings.belts.names().into_iter().map(|name| vec![name]).collect(),
    }
}

/// Returns the indices of the parts in contact.
fn touching(model: &Model) -> impl Iterator<Item = u32> {
    let settings = &model.settings;
    let touches = |id: u32| settings.contact.as_ref().is_some_and(|c| c.takes_part(id));
    (0..settings.parts.len() as u32).filter(move |&i| touches(settings.parts[i as usize].id))
}

/// Returns the columns of a file.
fn columns(table: ObjectTable, units: &Labels) -> FileColumns {
    let Labels { length, velocity, acceleration, momentum, force, moment, mass, energy, .. } =
        units;
    let none: [(&str, &str); 0] = [];
    match table {
        ObjectTable::Parts => FileColumns::new(
            &["part", "name"],
            [("mass", mass), ("kinetic", energy), ("internal", energy), ("hourglass", energy)],
            [("momentum", momentum)],
        ),
        ObjectTable::Walls => FileColumns::new(
            &["wall"],
            none,
            [("impulse", momentum), ("mean force", force), ("displacement", length)],
        ),
        ObjectTable::Contacts => FileColumns::new(&["part", "name"], none, [("force", force)]),
        ObjectTable::Nodes => FileColumns::new(
            &["nodes", "id"],
            ["x", "y", "z"].map(|axis| (axis, length)),
            [("displacement", length), ("velocity", velocity), ("acceleration", acceleration)],
        ),
        ObjectTable::Sections => FileColumns::new(
            &["section"],
            none,
            [("force", force), ("moment", moment), ("middle", length)],
        ),
        ObjectTable::Transducers => FileColumns::new(&["transducer"], none, [("force", force)]),
        ObjectTable::Airbags => {
            let (volume, pressure) = (&format!("{length}^3"), &format!("{force}/{length}^2"));
            let kelvin = &"K".to_string();
            let state = [
                ("volume", volume),
                ("pressure", pressure),
                ("temperature", kelvin),
                ("mass", mass),
                ("energy", energy),
                ("mass in", mass),
                ("mass out", mass),
                ("enthalpy in", energy),
                ("enthalpy out", energy),
                ("work", energy),
            ];
            FileColumns::new(&["airbag"], state, none)
        }
        ObjectTable::Belts => {
            let number = &String::new();
            let state = [
                ("tension", force),
                ("tension beyond", force),
                ("length", length),
                ("energy", energy),
                ("locked", number),
            ];
            FileColumns::new(&["belt"], state, none)
        }
    }
}

/// Returns the columns of the forces between pairs of parts.
fn contact_pairs(units: &Labels) -> FileColumns {
    let none: [(&str, &str); 0] = [];
    FileColumns::new(&["on part", "from part"], none, [("force", &units.force)])
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

/// Columns of a file after the time.
struct FileColumns(Vec<String>);

impl FileColumns {
    /// Joins the columns that name the object, and scalars and vectors with their units.
    fn new<S: AsRef<str>, V: AsRef<str>>(
        words: &[&str],
        scalars: impl IntoIterator<Item = (&'static str, S)>,
        vectors: impl IntoIterator<Item = (&'static str, V)>,
    ) -> Self {
        let mut all: Vec<String> = words.iter().map(|name| name.to_string()).collect();
        all.extend(scalars.into_iter().map(|(name, unit)| format!("{name} [{}]", unit.as_ref())));
        for (name, unit) in vectors {
            all.extend(["x", "y", "z"].map(|axis| format!("{name} {axis} [{}]", unit.as_ref())));
        }
        Self(all)
    }

    fn header(self, time: &str) -> Vec<String> {
        std::iter::once(format!("time [{time}]")).chain(self.0).collect()
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
