//! Writes a job as a Radioss starter file and its engine file. Reading them back gives the same
//! job.
//!
//! Keys of the job without a card are written after `$crumple:`, where other programs ignore them.
//! They are the list of losses, together with numbers that have more digits than a field.

mod conditions;
mod contact;
mod materials;
mod mesh;
mod parts;

use crate::input::deck::export::{
    DeckWriter, adaptivity, differing, is_thick, line, list, most, named,
};
use crate::input::deck::number::shortest;
use crate::input::deck::radioss::BEYOND;
use crate::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Checkpoint, Elements, Job, Output, Parallel, Part, Time};
use crumple_proto::mesh::Shape;
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Columns of a number and of an id.
const WIDTH: usize = 20;
const ID_WIDTH: usize = 10;
/// Largest whole number in a field.
const MOST: u64 = 9_999_999_999;
/// Version of the format.
const VERSION: u64 = 2022;
/// Names of units in a job and in a deck.
const UNITS: [(&str, &str); 2] = [("tonne", "Mg"), ("us", "mus")];

/// A deck in two files.
#[derive(Debug)]
pub struct StarterDeck {
    /// Text of the starter file.
    pub starter: String,
    /// Text of the engine file.
    pub engine: String,
    /// Losses: content of the job without a card, or with fewer digits; one text for each.
    pub losses: Vec<String>,
}

/// A field of a card.
#[derive(Clone, Copy)]
enum StarterField {
    /// Ten blank columns.
    Gap,
    /// A whole number in ten columns.
    Whole(u64),
    /// A number in twenty columns.
    Real(f64),
    /// A word in ten columns.
    Word(&'static str),
}

use StarterField::{Gap, Real, Whole, Word};

/// A deck under construction.
struct StarterWriter<'m> {
    model: &'m Model,
    deck: DeckWriter,
    losses: Vec<String>,
    /// Largest whole number in a field.
    largest: u64,
    /// Numbers that were rounded to the width of a field.
    rounded: usize,
    /// Ids of groups by the names of node sets.
    sets: BTreeMap<String, u64>,
    /// Largest ids so far: of groups, surfaces, functions and nodes.
    last: LastIds,
    /// Functions by the names of curves.
    functions: BTreeMap<Option<String>, u64>,
    /// Nodes that the deck needs and the model lacks: id and position.
    added: Vec<(u64, [f64; 3])>,
    /// Main node of each body by its name.
    mains: BTreeMap<String, u64>,
    /// Main node and nodes of each body.
    body_nodes: Vec<(u64, BTreeSet<NodeId>)>,
    /// Names that bodies have when the deck is read, by those in the job.
    body_names: BTreeMap<String, String>,
}

/// Largest ids that were given.
#[derive(Default)]
struct LastIds {
    group: u64,
    surface: u64,
    function: u64,
    node: u64,
}

/// Returns a model as a deck with this name.
///
/// # Errors
/// A text if the model has elements that a deck cannot have.
pub fn export(model: &Model, name: &str) -> Result<StarterDeck, String> {
    let particles = model.mesh.elements.iter().filter(|e| e.shape == Shape::Point1).count();
    if particles > 0 {
        return Err(format!(
            "{particles} particles cannot be written as a Radioss deck: remove them from the mesh"
        ));
    }
    if let Some(part) = model.settings.parts.iter().find(|p| p.discrete_beam.is_some()) {
        return Err(format!(
            "part {}: discrete beams cannot be written as a Radioss deck: remove them from the \
             mesh",
            part.id
        ));
    }
    if let Some(part) = model.settings.parts.iter().find(|p| p.belt.is_some()) {
        return Err(format!(
            "part {}: seat belts cannot be written as a Radioss deck: remove them from the mesh",
            part.id
        ));
    }
    if let Some(element) = model.mesh.elements.iter().find(|e| e.shape == Shape::Cohesive8) {
        return Err(format!(
            "part {}: cohesive elements cannot be written as a Radioss deck: remove them from the \
             mesh",
            element.part
        ));
    }
    if let Some(part) = model.settings.parts.iter().find(|part| is_thick(part)) {
        return Err(format!(
            "part {}: thick shells cannot be written as a Radioss deck: make them solids, or \
             shells of four nodes",
            part.id
        ));
    }
    let angled = |id: u32| model.mesh.elements.iter().any(|e| e.part == id && e.own.angle != 0.0);
    let is_composite = |p: &&Part| !p.layer.is_empty() || !p.angles.is_empty() || angled(p.id);
    if let Some(part) = model.settings.parts.iter().find(is_composite) {
        return Err(format!(
            "part {}: layers and angles of shells cannot be written as a Radioss deck: give it a \
             thickness and one material without axes",
            part.id
        ));
    }
    let mut shapes: BTreeMap<u32, [bool; 2]> = BTreeMap::new();
    for e in model.mesh.elements.iter().filter(|e| e.shape.is_solid()) {
        shapes.entry(e.part).or_default()[usize::from(e.shape == Shape::Tet10)] = true;
    }
    if let Some((part, _)) = shapes.iter().find(|(_, has)| **has == [true; 2]) {
        return Err(format!(
            "part {part} has tetrahedra of ten nodes and other solids: give each its own part, as \
             a Radioss deck requires"
        ));
    }
    let job = &model.job;
    let nodes = model.mesh.nodes.iter().map(|n| n.id.label());
    let mut w = StarterWriter {
        model,
        deck: DeckWriter::default(),
        losses: Vec::new(),
        largest: 0,
        rounded: 0,
        sets: BTreeMap::new(),
        last: LastIds {
            group: most("set-", model.mesh.node_sets.keys().map(String::as_str)),
            function: most("curve-", job.curve.iter().map(|c| c.name.as_str())),
            node: nodes.max().unwrap_or(0),
            ..LastIds::default()
        },
        functions: BTreeMap::new(),
        added: Vec::new(),
        mains: BTreeMap::new(),
        body_nodes: Vec::new(),
        body_names: BTreeMap::new(),
    };
    w.begin(name);
    w.materials();
    w.parts();
    w.groups();
    w.bodies();
    w.joints();
    w.fixes();
    w.motions();
    w.initial();
    w.loads();
    w.walls();
    w.contact();
    w.ties();
    w.histories();
    w.mesh();
    let engine = w.engine(name);
    if w.largest > MOST {
        return Err(format!(
            "the id {} has more digits than the {ID_WIDTH} columns of a field: renumber nodes and \
             elements",
            w.largest
        ));
    }
    w.left_over();
    Ok(w.finish(name, engine))
}

impl StarterWriter<'_> {
    fn keyword(&mut self, name: &str) {
        self.deck.text(&format!("/{name}"));
    }

    /// Writes a keyword with an id and a title.
    fn titled(&mut self, name: &str, id: u64, title: &str) {
        self.keyword(&format!("{name}/{id}"));
        self.deck.text(&heading(title));
    }

    fn card(&mut self, fields: &[StarterField]) {
        let mut text = String::new();
        for field in fields {
            text += &match field {
                Gap => format!("{:>ID_WIDTH$}", ""),
                Whole(id) => {
                    self.largest = self.largest.max(*id);
                    format!("{id:>ID_WIDTH$}")
                }
                Word(word) => format!("{word:>ID_WIDTH$}"),
                Real(x) => format!("{:>WIDTH$}", self.number(*x)),
            };
        }
        self.deck.text(text.trim_end());
    }

    /// Returns a number for a field; one with more digits is rounded.
    fn number(&mut self, x: f64) -> String {
        shortest(x, WIDTH).unwrap_or_else(|| {
            self.rounded += 1;
            let mut digits = (0..WIDTH).rev().map(|digits| format!("{x:.digits$e}"));
            digits.find(|text| text.len() <= WIDTH).unwrap_or_default()
        })
    }

    /// Writes a list of ids.
    fn ids(&mut self, ids: &[u64]) {
        for ten in ids.chunks(10) {
            let fields: Vec<StarterField> = ten.iter().map(|&id| Whole(id)).collect();
            self.card(&fields);
        }
    }

    /// Notes something that the deck does not have.
    fn lose(&mut self, what: impl Into<String>) {
        self.losses.push(what.into());
    }

    /// Adds keys of an entry of a list that have no card.
    fn rest(&mut self, list: &str, entry: Table) {
        self.deck.entry(list, entry);
    }

    fn begin(&mut self, name: &str) {
        let job = &self.model.job;
        self.keyword("BEGIN");
        self.deck.text(&heading(name));
        self.card(&[Whole(VERSION), Whole(0)]);
        let words: Vec<&str> = job.units.split(',').map(str::trim).collect();
        let plain = |word: &&&str| word.chars().all(|c| c.is_ascii_alphabetic()) && word.len() < 9;
        match &words[..] {
            [length, time, mass] if words.iter().filter(plain).count() == 3 => {
                let own = |word: &str| {
                    UNITS
                        .iter()
                        .find(|(of, _)| *of == word)
                        .map_or(word.to_string(), |u| u.1.into())
                };
                let text = format!("{:>20}{:>20}{:>20}", own(mass), own(length), own(time));
                self.deck.text(&text);
                self.deck.text(&text);
            }
            _ if job.units.is_empty() => {}
            _ => {
                self.deck.rest.insert("units".into(), job.units.clone().into());
            }
        }
        self.keyword("TITLE");
        self.deck.text(&heading(&job.title));
    }

    /// Returns the id of a group by the name of its node set, 0 if there is none.
    fn group(&self, name: &str) -> u64 {
        self.sets.get(name).copied().unwrap_or(0)
    }

    fn groups(&mut self) {
        let sets = &self.model.mesh.node_sets;
        for (name, nodes) in sets {
            let there = |n: &&crumple_proto::ids::NodeId| {
                self.model.mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok()
            };
            let ids: Vec<u64> = nodes.iter().filter(there).map(|n| n.label()).collect();
            let id = self.new_group(name, &ids);
            self.sets.insert(name.clone(), id);
        }
    }

    /// Writes a group of nodes and returns its id.
    fn new_group(&mut self, title: &str, ids: &[u64]) -> u64 {
        self.last.group += 1;
        let id = self.last.group;
        self.titled("GRNOD/NODE", id, title);
        self.ids(ids);
        id
    }

    /// Writes a surface of parts and returns its id.
    fn new_surface(&mut self, title: &str, parts: &[u32]) -> u64 {
        self.last.surface += 1;
        let id = self.last.surface;
        self.titled("SURF/PART", id, title);
        let parts: Vec<u64> = parts.iter().map(|&p| u64::from(p)).collect();
        self.ids(&parts);
        id
    }

    /// Adds a node that the model does not have, and returns its id.
    fn new_node(&mut self, at: [f64; 3]) -> u64 {
        self.last.node += 1;
        self.added.push((self.last.node, at));
        self.last.node
    }

    /// Returns the id of the function of a curve, which is written at its first use. Must not be
    /// called between a keyword and its cards.
    fn function(&mut self, curve: Option<&str>) -> u64 {
        let key = curve.map(String::from);
        if let Some(&id) = self.functions.get(&key) {
            return id;
        }
        let job: &Job = &self.model.job;
        let end = BEYOND * job.end_time;
        let found = curve.and_then(|name| job.curve.iter().find(|c| c.name == name));
        let points =
            found.map_or(vec![[0.0, 1.0], [end, 1.0]], |c| constant_beyond(&c.points, end));
        let id = self.new_function(curve.unwrap_or("factor of 1"), &points);
        self.functions.insert(key, id);
        id
    }

    /// Writes a function through these points, and returns its id.
    fn new_function(&mut self, title: &str, points: &[[f64; 2]]) -> u64 {
        self.last.function += 1;
        let id = self.last.function;
        self.titled("FUNCT", id, title);
        for point in points {
            self.card(&point.map(Real));
        }
        id
    }

    /// Returns the text of the engine file.
    fn engine(&mut self, name: &str) -> String {
        let (time, output) = (&self.model.job.time, &self.model.job.output);
        let mut text = format!("#RADIOSS ENGINE\n/VERS/{VERSION}\n");
        text += &format!("/RUN/{name}/1\n{:e}\n", self.model.job.end_time);
        let least = time.mass_scaling_dt * time.safety;
        if least > 0.0 {
            text += &format!("/DT/NODA/CST\n{:e} {least:e}\n", time.safety);
        } else {
            text += &format!("/DT\n{:e} 0\n", time.safety);
        }
        if time.dt_max > 0.0 {
            text += &format!("/DTIX\n0 {:e}\n", time.dt_max);
        }
        if output.history_interval > 0.0 {
            text += &format!("/TFILE\n{:e}\n", output.history_interval);
        }
        if output.field_interval > 0.0 {
            text += &format!("/ANIM/DT\n0 {:e}\n", output.field_interval);
        }
        text + "/END\n"
    }

    /// Writes tables of the job without a card.
    fn left_over(&mut self) {
        let stressed = self.model.mesh.initial.chunk_by(|a, b| a.element == b.element).count();
        if stressed > 0 {
            self.lose(format!("stresses at the start of {stressed} elements"));
        }
        let job = &self.model.job;
        let deck = &mut self.deck;
        differing(deck, "time", &job.time, &Time::default(), &["safety", "dt_max"]);
        if let Some(Value::Table(time)) = deck.rest.get_mut("time")
            && time.get("mass_scaling_dt").is_some()
        {
            time.insert("mass_scaling_limit".into(), job.time.mass_scaling_limit.into());
        }
        let intervals = [
            ("history_interval", job.output.history_interval),
            ("field_interval", job.output.field_interval),
        ];
        let mut carried: Vec<&str> =
            intervals.into_iter().filter(|i| i.1 > 0.0).map(|i| i.0).collect();
        if !conditions::has_axes(&job.output.node) {
            carried.push("node");
        }
        differing(deck, "output", &job.output, &Output::default(), &carried);
        differing(deck, "parallel", &job.parallel, &Parallel::default(), &[]);
        differing(deck, "elements", &job.elements, &Elements::default(), &[]);
        differing(deck, "checkpoint", &job.checkpoint, &Checkpoint::default(), &[]);
        adaptivity(deck, job);
        list(deck, "symmetry", &job.symmetry);
        list(deck, "airbag", &job.airbag);
        list(deck, "non_reflecting", &job.non_reflecting);
        list(deck, "failure_group", &job.failure_group);
        list(deck, "damping", &job.damping);
        list(deck, "require", &job.require);
        let referring = ["pressure", "airbag", "load", "motion", "wall"];
        let damped = job.time.damping_curve.is_some();
        if damped || referring.iter().any(|key| deck.rest.contains_key(*key)) {
            list(deck, "curve", &job.curve);
        }
    }

    fn finish(mut self, name: &str, engine: String) -> StarterDeck {
        let mut head = format!(
            "#RADIOSS STARTER\n# {} as a Radioss deck, by crumple {}\n",
            line(name),
            env!("CARGO_PKG_VERSION")
        );
        let mut losses = losses_of(&self.deck.rest);
        losses.append(&mut self.losses);
        if self.rounded > 0 {
            let count = self.rounded;
            losses.push(format!("{count} numbers are rounded to the {WIDTH} columns of a field"));
        }
        if !self.deck.rest.is_empty() {
            head += "# keys without a card, read by crumple only:\n";
            let text = toml::to_string(&self.deck.rest).unwrap_or_default();
            text.lines().for_each(|l| head += &format!("$crumple: {l}\n"));
        }
        StarterDeck { starter: head + &self.deck.body + "/END\n", engine, losses }
    }
}

/// Returns a title as a line that is neither a keyword nor a comment.
fn heading(title: &str) -> String {
    let text = line(title);
    if text.starts_with(['/', '#', '$']) { format!(" {text}") } else { text }
}

/// Returns points beyond which a function is constant where it continues with its slopes: a
/// function of Radioss does, a curve of a job does not.
fn constant_beyond(points: &[[f64; 2]], end: f64) -> Vec<[f64; 2]> {
    let mut all = points.to_vec();
    if let [first, second, ..] = points
        && first[0] > 0.0
        && first[1] != second[1]
    {
        all.insert(0, [0.0, first[1]]);
    }
    if let [.., before, last] = points
        && last[0] < end
        && before[1] != last[1]
    {
        all.push([end, last[1]]);
    }
    all
}

/// Returns the keys without a card, one text for each entry.
fn losses_of(rest: &Table) -> Vec<String> {
    let keys = |table: &Table| {
        let names = table.keys().filter(|key| !["name", "id"].contains(&key.as_str()));
        names.cloned().collect::<Vec<_>>().join(", ")
    };
    let mut found: BTreeSet<String> = BTreeSet::new();
    for (key, value) in rest {
        match value {
            Value::Array(items) => {
                for (number, item) in (1..).zip(items) {
                    let Value::Table(table) = item else { continue };
                    let of = ["name", "id"].iter().find_map(|k| table.get(*k));
                    let of = of.map_or(number.to_string(), |v| v.to_string());
                    found.insert(format!("{key} {of}: no card for {}", keys(table)));
                }
            }
            Value::Table(table) => {
                found.insert(format!("{key}: no card for {}", keys(table)));
            }
            _ => {
                found.insert(format!("no card for {key}"));
            }
        }
    }
    found.into_iter().collect()
}
