//! `crumple export-deck`: writes a job as a keyword deck in the long format. Reading it back
//! gives the same bits.
//!
//! Numbers with too many digits for a field become parameters. Keys of the job without a card are
//! written after `$crumple:`, where other programs ignore them.

mod airbags;
mod barlat;
pub(in crate::input::deck) mod beams;
mod bodies;
mod cohesive;
mod composites;
pub(in crate::input::deck) mod contact;
mod curves;
mod damage;
mod discrete_beams;
mod faces;
mod gurson;
mod histories;
mod inertia;
mod initial;
mod joints;
mod loads;
mod materials;
mod mesh;
mod metals;
mod particles;
mod parts;
mod polymers;
mod pressure_dependent;
mod rest;
mod soft_materials;
mod springs;
mod stresses;
mod switches;
mod ties;
mod walls;
mod writer;

pub(in crate::input::deck) use parts::is_thick;
pub(in crate::input::deck) use rest::{adaptivity, differing, list};
pub(in crate::input::deck) use writer::{DeckWriter, line, named, table_of, value_of};

use crate::input::deck::convert::units::stated;
use crate::input::job::{Model, Report};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{CurveInput, Job};
use curves::TimeCurves;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use toml::Value;
use writer::CardValue::{self, Blank, Id, Number};
use writer::{LeftReason, id_in_name, points, points_with_id};

/// A job as a deck.
#[derive(Debug)]
pub struct ExportedDeck {
    /// Its text.
    pub text: String,
    /// Lines on what is not on cards alone, one for each kind, with the number of entries.
    pub left: Vec<String>,
}

/// Returns a model as a deck.
///
/// # Errors
/// A text if the model has something that a deck cannot have.
pub fn export(model: &Model) -> Result<ExportedDeck, String> {
    let job = &model.job;
    let used = used_names(job, "pressure");
    let is_used = |curve: &&CurveInput| used.contains(&curve.name);
    let mut deck = DeckWriter {
        curves: most("curve-", job.curve.iter().filter(is_used).map(|c| c.name.as_str())),
        last_node_set: most("set-", model.mesh.node_sets.keys().map(String::as_str)),
        systems: job.part.iter().map(|part| u64::from(part.id)).max().unwrap_or(0),
        last_node: model.mesh.nodes.iter().map(|n| n.id.label()).max().unwrap_or(0),
        ..DeckWriter::default()
    };
    deck.keyword("TITLE");
    deck.text(&line(&job.title));
    control(&mut deck, job);
    let mut next = 1 + model.settings.materials.len() as u64;
    let mut bodies = bodies::materials(&mut deck, model, next);
    next += bodies.materials.len() as u64;
    let equations = materials::write(&mut deck, model, &bodies.materials);
    bodies.inertia = inertia::of(model, &bodies.materials);
    parts::write(&mut deck, model, &bodies, &equations, next)?;
    let faces = faces::of_pressures(model);
    bodies.joint_sets = joints::sets_of_nodes(job, &bodies);
    let is_written = |name: &str| {
        let comes_back = faces.is_some() && !used.contains(name) && under_pressure(job, name);
        !comes_back && !bodies.joint_sets.contains(name)
    };
    let sets = node_sets(&mut deck, model, is_written);
    let set = |name: &str| Id(sets.get(name).copied().unwrap_or(0));
    let mut curves = TimeCurves::new(job);
    initial::write(&mut deck, job, set);
    loads::gravity(&mut deck, model, set, &mut curves);
    loads::damping(&mut deck, model, &mut curves);
    loads::on_nodes(&mut deck, model, set, &mut curves);
    faces::pressures(&mut deck, job, faces, &mut curves);
    airbags::write(&mut deck, model, &mut curves);
    let nodes = joints::write(&mut deck, job, &bodies);
    bodies::write(&mut deck, (model, &bodies), &nodes, set, &mut curves);
    walls::write(&mut deck, job, set, &mut curves);
    contact::write(&mut deck, job);
    ties::write(&mut deck, model, set);
    histories::write(&mut deck, model, set);
    mesh::write(&mut deck, model);
    stresses::write(&mut deck, model);
    rest::write(&mut deck, job, &mut curves);
    let left = deck.left();
    Ok(ExportedDeck { text: deck.finish(&model.path.display().to_string()), left })
}

/// Returns the largest number after `start` among names. A reader names curves and sets by their
/// ids, which must not collide with names in the job.
pub(in crate::input::deck) fn most<'n>(start: &str, names: impl Iterator<Item = &'n str>) -> u64 {
    names.filter_map(|name| name.strip_prefix(start)?.parse().ok()).max().unwrap_or(0)
}

fn control(deck: &mut DeckWriter, job: &Job) {
    deck.keyword("CONTROL_TERMINATION");
    deck.card(&[Number(job.end_time), Id(job.time.max_cycles), Number(job.time.dt_min_ratio)]);
    let time = &job.time;
    let limit = match time.dt_max > 0.0 {
        true => Id(points(deck, &[[0.0, time.dt_max], [2.0 * job.end_time, time.dt_max]])),
        false => Blank,
    };
    deck.keyword("CONTROL_TIMESTEP");
    let scaled = Number(-time.mass_scaling_dt);
    deck.card(&[Blank, Number(time.safety), Blank, Blank, scaled, limit]);
    if job.time.damping > 0.0 && job.time.damping_curve.is_none() {
        deck.keyword("DAMPING_GLOBAL");
        deck.card(&[Blank, Number(job.time.damping)]);
    }
    if let Some(words) = stated(&job.units) {
        deck.keyword("CONTROL_UNITS");
        deck.words(&words);
    }
    let output = &job.output;
    if output.history_interval > 0.0 {
        deck.keyword("DATABASE_GLSTAT");
        deck.card(&[Number(output.history_interval)]);
    }
    let times = rest::times_of_fields(job);
    if output.field_interval > 0.0 || times.is_some() {
        let curve = times.map(|times| {
            // Curves need two points; fields end with the run.
            let after = Some(2.0 * job.end_time).filter(|_| times.len() < 2);
            let pairs: Vec<[f64; 2]> = times.into_iter().chain(after).map(|t| [t, 0.0]).collect();
            points(deck, &pairs)
        });
        deck.keyword("DATABASE_BINARY_D3PLOT");
        let interval = Some(output.field_interval).filter(|&dt| dt > 0.0);
        deck.card(&[interval.map_or(Blank, Number), curve.map_or(Blank, Id)]);
        if curve.is_some() {
            deck.card(&[Id(3)]);
        }
    }
    if output.strains {
        deck.keyword("DATABASE_EXTENT_BINARY");
        deck.card(&[Blank, Blank, Blank, Id(1)]);
    }
}

/// Returns the names to which the entries of a job refer. Those of curves, and of the nodes of the
/// entries of one list, count only if other entries use them.
fn used_names(job: &Job, list: &str) -> BTreeSet<String> {
    let mut table = table_of(job);
    table.remove("curve");
    if let Some(Value::Array(entries)) = table.get_mut(list) {
        entries.iter_mut().filter_map(Value::as_table_mut).for_each(|entry| {
            entry.remove("nodes");
        });
    }
    let mut names = BTreeSet::new();
    rest::add_texts(&Value::Table(table), &mut names);
    names
}

/// Returns true for a name that a reader of decks gives the nodes under a pressure.
fn under_pressure(job: &Job, name: &str) -> bool {
    name.starts_with("pressure-")
        && job.pressure.iter().any(|load| load.nodes.as_deref() == Some(name))
}

/// Writes all sets that others do not write, and returns their ids by name. A reader names a set by
/// its id, and once more by its title: both names have one card, so that sets do not become more
/// with each export.
fn node_sets<'m>(
    deck: &mut DeckWriter,
    model: &'m Model,
    is_written: impl Fn(&str) -> bool,
) -> BTreeMap<&'m str, u64> {
    let all = &model.mesh.node_sets;
    let number = |name: &str| id_in_name("set-", name);
    let mut titles: BTreeMap<&[NodeId], Vec<&str>> = BTreeMap::new();
    let is_title = |name: &str| number(name).is_none() && is_written(name);
    for (name, nodes) in all.iter().rev().filter(|(name, _)| is_title(name)) {
        titles.entry(nodes).or_default().push(name);
    }
    let mut ids = BTreeMap::new();
    for (name, nodes) in all {
        let Some(id) = number(name) else { continue };
        ids.insert(name.as_str(), id);
        if is_written(name) {
            let title = titles.get_mut(nodes.as_slice()).and_then(Vec::pop);
            write_named_set(deck, model, (id, title), nodes);
            ids.extend(title.map(|title| (title, id)));
        }
    }
    for (name, nodes) in all {
        if !ids.contains_key(name.as_str()) && is_written(name) {
            deck.last_node_set += 1;
            ids.insert(name, deck.last_node_set);
            write_named_set(deck, model, (deck.last_node_set, Some(name)), nodes);
        }
    }
    ids
}

/// Writes a set with its id and title.
fn write_named_set(
    deck: &mut DeckWriter,
    model: &Model,
    (id, title): (u64, Option<&str>),
    nodes: &[NodeId],
) {
    deck.keyword(if title.is_some() { "SET_NODE_LIST_TITLE" } else { "SET_NODE_LIST" });
    title.iter().for_each(|title| deck.text(&line(title)));
    deck.card(&[Id(id)]);
    let there = |n: &&NodeId| model.mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok();
    let nodes: Vec<u64> = nodes.iter().filter(there).map(|n| n.label()).collect();
    let fields: Vec<CardValue> = nodes.iter().map(|&n| Id(n)).collect();
    fields.chunks(8).for_each(|eight| deck.card(eight));
    deck.node_set_ids.insert(nodes, id);
}

/// Runs `crumple export-deck` and returns the exit code.
pub fn run(args: &crate::cli::ExportArgs) -> u8 {
    let refuse = |what: &dyn Display| {
        eprintln!("error: {what}");
        Report::EXIT_CODE
    };
    let model = match crate::input::job::read(&args.job, &args.set) {
        Ok(model) => model,
        Err(report) => {
            eprint!("{report}");
            return Report::EXIT_CODE;
        }
    };
    let ExportedDeck { text, left } = match export(&model) {
        Ok(deck) => deck,
        Err(what) => return refuse(&what),
    };
    if let Some(path) = args.out.as_ref().filter(|path| std::fs::symlink_metadata(path).is_ok())
        && !args.overwrite
    {
        let ways = "replace it with --overwrite, or choose another file with --out";
        return refuse(&format_args!("{} exists; {ways}", path.display()));
    }
    if !left.is_empty() {
        eprintln!("not on cards alone, but in comments that only Crumple reads:");
        left.iter().for_each(|what| eprintln!("  {what}"));
    }
    match &args.out {
        None => crate::stdout::write(format_args!("{text}")),
        Some(path) => {
            let size = text.len();
            if let Err(error) = std::fs::write(path, text) {
                return refuse(&format_args!("{} cannot be written: {error}", path.display()));
            }
            let kilobytes = size as f64 / 1000.0;
            crate::stdout::write(format_args!("written: {}, {kilobytes:.1} kB\n", path.display()));
        }
    }
    0
}
