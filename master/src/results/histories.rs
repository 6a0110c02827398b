//! Histories by kind in addition to `history.csv`: `parts.csv`, `walls.csv`, `contacts.csv` and
//! `contact_pairs.csv`, `nodes.csv`, `sections.csv`, `transducers.csv`. Each row holds one object
//! at one time, so that files of many parts stay readable and programs can filter. Rows have the
//! times of `history.csv` and refer to the same instants.

use crate::input::job::Model;
use crate::results::history::{self, Labels};
use crate::results::table::{Table, Tables, Unwritten};
use crumple_proto::ids::NodeId;
use crumple_proto::report::HistoryPart;
use std::collections::HashMap;
use std::io;

/// The files of a run. Files of kinds that the scene does not have, or that the job does not
/// request, are absent.
pub struct Histories {
    /// Id and name per part of the settings.
    parts: Vec<(u32, String)>,
    walls: Vec<String>,
    groups: Vec<(String, Vec<NodeId>)>,
    sections: Vec<String>,
    transducers: Vec<String>,
    of_parts: Option<Table>,
    of_walls: Option<Table>,
    of_contacts: Option<(Table, Table)>,
    of_nodes: Option<Table>,
    of_sections: Option<Table>,
    of_transducers: Option<Table>,
    /// Indices of the parts in contact.
    touching: Vec<u32>,
    last_walls: (f64, Vec<[f64; 3]>),
}

/// Names of all files.
pub const NAMES: [&str; 7] = [
    "parts.csv",
    "walls.csv",
    "contacts.csv",
    "contact_pairs.csv",
    "nodes.csv",
    "sections.csv",
    "transducers.csv",
];

impl Histories {
    /// Creates the files and removes those of an older run, or continues after the row `last`.
    ///
    /// # Errors
    /// A file cannot be written or removed.
    pub(crate) fn new(
        tables: Tables<'_>,
        model: &Model,
        last: Option<&HistoryPart>,
    ) -> Result<Self, Unwritten> {
        let is_kept = |name: &&str| tables.lengths.is_some_and(|l| l.contains_key(*name));
        for path in NAMES.iter().filter(|name| !is_kept(name)).map(|name| tables.dir.join(name)) {
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err((path, error)),
                _ => {}
            }
        }
        let (settings, asked) = (&model.settings, &model.settings.histories);
        let u = Labels::from_units(&model.job.units);
        let begin = |name: &str, columns: &[(&str, &str)]| -> Result<Table, Unwritten> {
            let header = columns.iter().map(|(name, unit)| match *unit {
                "" => name.to_string(),
                unit => format!("{name} [{unit}]"),
            });
            let first = [format!("time [{}]", u.time)];
            tables.open(name, first.into_iter().chain(header))
        };
        let of_parts = asked.parts.then(|| {
            let (e, p) = (u.energy.as_str(), u.momentum.as_str());
            let energies = [("kinetic", e), ("internal", e), ("hourglass", e)];
            let momentum = [("momentum x", p), ("momentum y", p), ("momentum z", p)];
            let first = [("part", ""), ("name", ""), ("mass", u.mass.as_str())];
            begin(NAMES[0], &[&first[..], &energies, &momentum].concat())
        });
        let f = u.force.as_str();
        let force = [("force x", f), ("force y", f), ("force z", f)];
        let of_walls = (model.job.output.walls && !settings.walls.is_empty()).then(|| {
            let p = u.momentum.as_str();
            let impulse = [("impulse x", p), ("impulse y", p), ("impulse z", p)];
            let mean = [("mean force x", f), ("mean force y", f), ("mean force z", f)];
            let l = u.length.as_str();
            let gone = [("displacement x", l), ("displacement y", l), ("displacement z", l)];
            begin(NAMES[1], &[&[("wall", "")][..], &impulse, &mean, &gone].concat())
        });
        let of_contacts = asked.contacts.then(|| {
            let parts = begin(NAMES[2], &[&[("part", ""), ("name", "")][..], &force].concat())?;
            Ok::<_, Unwritten>((
                parts,
                begin(NAMES[3], &[&[("on part", ""), ("from part", "")][..], &force].concat())?,
            ))
        });
        let of_nodes = (!asked.nodes.is_empty()).then(|| {
            let (l, v, a) = (u.length.as_str(), u.velocity.as_str(), u.acceleration.as_str());
            let columns = [
                [("x", l), ("y", l), ("z", l)],
                [("displacement x", l), ("displacement y", l), ("displacement z", l)],
                [("velocity x", v), ("velocity y", v), ("velocity z", v)],
                [("acceleration x", a), ("acceleration y", a), ("acceleration z", a)],
            ];
            begin(NAMES[4], &[&[("nodes", ""), ("id", "")][..], columns.as_flattened()].concat())
        });
        let of_sections = (!asked.sections.is_empty()).then(|| {
            let (l, m) = (u.length.as_str(), u.moment.as_str());
            let moment = [("moment x", m), ("moment y", m), ("moment z", m)];
            let middle = [("middle x", l), ("middle y", l), ("middle z", l)];
            begin(NAMES[5], &[&[("section", "")][..], &force, &moment, &middle].concat())
        });
        let of_transducers = (!asked.transducers.is_empty())
            .then(|| begin(NAMES[6], &[&[("transducer", "")][..], &force].concat()));
        let touches = |id: u32| settings.contact.as_ref().is_some_and(|c| c.takes_part(id));
        let touching = (0..settings.parts.len() as u32)
            .filter(|&i| touches(settings.parts[i as usize].id))
            .collect();
        Ok(Self {
            parts: settings.parts.iter().map(|p| (p.id, p.name.clone())).collect(),
            walls: history::wall_names(&settings.walls),
            groups: asked.nodes.iter().map(|g| (g.name.clone(), by_label(&g.nodes))).collect(),
            sections: asked.sections.iter().map(|s| s.name.clone()).collect(),
            transducers: asked.transducers.iter().map(|t| t.name.clone()).collect(),
            of_parts: of_parts.transpose()?,
            of_walls: of_walls.transpose()?,
            of_contacts: of_contacts.transpose()?,
            of_nodes: of_nodes.transpose()?,
            of_sections: of_sections.transpose()?,
            of_transducers: of_transducers.transpose()?,
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
    pub(crate) fn tables(&mut self) -> impl Iterator<Item = &mut Table> {
        let contacts = self.of_contacts.iter_mut().flat_map(|(parts, pairs)| [parts, pairs]);
        let single = [
            &mut self.of_parts,
            &mut self.of_walls,
            &mut self.of_nodes,
            &mut self.of_sections,
            &mut self.of_transducers,
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
            for (name, nodes) in &self.groups {
                for id in nodes {
                    let Ok(at) = shares.nodes.binary_search_by_key(id, |n| n.id) else { continue };
                    let n = &shares.nodes[at];
                    let numbers = [n.x, n.u, n.v, n.a];
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
        Ok(())
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
    table: &mut Table,
    words: [String; N],
    numbers: impl IntoIterator<Item = f64>,
) -> csv::Result<()> {
    table.write_record(words.into_iter().chain(numbers.into_iter().map(number)))
}
