//! `crumple export-deck`: writes a job as a keyword deck in the long format. Reading it back
//! gives the same bits.
//!
//! Numbers with too many digits for a field become parameters. Keys of the job without a card are
//! written after `$crumple:`, where other programs ignore them.

mod barlat;
pub(in crate::input::deck) mod beams;
mod bodies;
mod cohesive;
mod composites;
pub(in crate::input::deck) mod contact;
mod curves;
mod discrete_beams;
mod faces;
mod loads;
mod materials;
mod springs;
mod walls;

use super::number::shortest;
use crate::input::job::{Model, Report};
use crumple_proto::job::{Job, Output, Parallel, Part, Setting, Time};
use crumple_proto::mesh::{MeshElement, OwnSection, Shape};
use crumple_worker::fem::elements::{COHESIVE, HourglassForm, formulation, points_of};
use curves::TimeCurves;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use toml::{Table, Value};

/// Columns per field.
const WIDTH: usize = 20;

/// A deck under construction.
#[derive(Default)]
pub(in crate::input::deck) struct DeckWriter {
    /// Its cards.
    pub(in crate::input::deck) body: String,
    /// Numbers that are longer than a field.
    parameters: Vec<f64>,
    /// Keys without a card.
    pub(in crate::input::deck) rest: Table,
    /// Number of curves so far.
    curves: u64,
    /// Number of sets of parts so far.
    part_sets: u64,
    /// Number of sets of segments so far.
    segment_sets: u64,
}

impl DeckWriter {
    fn keyword(&mut self, name: &str) {
        self.body += &format!("*{name}\n");
    }

    /// Writes a line.
    pub(in crate::input::deck) fn text(&mut self, line: &str) {
        self.body += line;
        self.body.push('\n');
    }

    fn card(&mut self, fields: &[CardValue]) {
        for field in fields {
            let text = match field {
                CardValue::Blank => String::new(),
                CardValue::Id(id) => id.to_string(),
                CardValue::Number(x) => self.number(*x),
            };
            self.body += &format!("{text:>WIDTH$}");
        }
        self.body.truncate(self.body.trim_end_matches(' ').len());
        self.body.push('\n');
    }

    /// Returns a number for a field, with all its digits.
    fn number(&mut self, x: f64) -> String {
        shortest(x, WIDTH).unwrap_or_else(|| {
            let known = self.parameters.iter().position(|p| p.to_bits() == x.to_bits());
            let at = known.unwrap_or_else(|| {
                self.parameters.push(x);
                self.parameters.len() - 1
            });
            format!("&x{}", at + 1)
        })
    }

    /// Adds an entry to a list of keys without a card.
    pub(in crate::input::deck) fn entry(&mut self, list: &str, entry: Table) {
        let lists = self.rest.entry(list).or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(items) = lists {
            items.push(Value::Table(entry));
        }
    }

    /// Writes a card with an id and a name.
    fn named_card(&mut self, id: u64, name: &str) {
        self.body += &format!("{id:>WIDTH$}{name}\n");
    }

    /// Writes a set of parts, and returns its id.
    fn part_set(&mut self, parts: &[u32]) -> u64 {
        self.part_sets += 1;
        let id = self.part_sets;
        self.keyword("SET_PART_LIST");
        self.card(&[Id(id)]);
        let parts: Vec<CardValue> = parts.iter().map(|&p| Id(u64::from(p))).collect();
        parts.chunks(8).for_each(|eight| self.card(eight));
        id
    }

    fn finish(self, job: &str) -> String {
        let mut head = format!(
            "*KEYWORD LONG=Y\n$ {} as a deck, by crumple {}\n",
            line(job),
            env!("CARGO_PKG_VERSION")
        );
        if !self.rest.is_empty() {
            head += "$ keys without a card, read by crumple only:\n";
            let text = toml::to_string(&self.rest).unwrap_or_default();
            text.lines().for_each(|l| head += &format!("$crumple: {l}\n"));
        }
        if !self.parameters.is_empty() {
            head += "*PARAMETER_EXPRESSION\n";
            self.parameters
                .iter()
                .enumerate()
                .for_each(|(i, x)| head += &format!("R x{},{x:e}\n", i + 1));
        }
        head + &self.body + "*END\n"
    }
}

#[derive(Clone, Copy)]
enum CardValue {
    Blank,
    Id(u64),
    Number(f64),
}

use CardValue::{Blank, Id, Number};

/// Returns the text on one line.
pub(in crate::input::deck) fn line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect::<String>()
        .trim()
        .to_string()
}

/// Returns a model as a deck.
pub fn export(model: &Model) -> Result<String, String> {
    let particles = model.mesh.elements.iter().filter(|e| e.shape == Shape::Point1).count();
    if particles > 0 {
        return Err(format!(
            "{particles} particles cannot be written as a deck: remove them from the mesh"
        ));
    }
    let job = &model.job;
    let mut deck = DeckWriter {
        curves: most("curve-", job.curve.iter().map(|c| c.name.as_str())),
        ..DeckWriter::default()
    };
    deck.keyword("TITLE");
    deck.text(&line(&job.title));
    control(&mut deck, job);
    let mut next = 1 + model.settings.materials.len() as u64;
    let bodies = bodies::materials(&mut deck, job, &model.settings.materials, next);
    next += bodies.materials.len() as u64;
    materials::write(&mut deck, model, &bodies.materials);
    parts(&mut deck, model, &bodies.materials, next)?;
    let sets = node_sets(&mut deck, model);
    let set = |name: &str| Id(sets.get(name).copied().unwrap_or(0));
    let mut curves = TimeCurves::new(job);
    initial(&mut deck, job, set);
    loads::gravity(&mut deck, model, &mut curves);
    loads::on_nodes(&mut deck, model, set, &mut curves);
    faces::pressures(&mut deck, model, &mut curves);
    bodies::write(&mut deck, job, &bodies, set, &mut curves);
    walls::write(&mut deck, job, set, &mut curves);
    contact::write(&mut deck, job);
    faces::ties(&mut deck, model, set);
    mesh(&mut deck, model);
    left_over(&mut deck, job, &mut curves);
    Ok(deck.finish(&model.path.display().to_string()))
}

/// Returns the largest number after `start` among names. A reader names curves and sets by their
/// ids, which must not collide with names in the job.
pub(in crate::input::deck) fn most<'n>(start: &str, names: impl Iterator<Item = &'n str>) -> u64 {
    names.filter_map(|name| name.strip_prefix(start)?.parse().ok()).max().unwrap_or(0)
}

fn control(deck: &mut DeckWriter, job: &Job) {
    deck.keyword("CONTROL_TERMINATION");
    deck.card(&[Number(job.end_time), Id(job.time.max_cycles), Number(job.time.dt_min_ratio)]);
    deck.keyword("CONTROL_TIMESTEP");
    deck.card(&[Blank, Number(job.time.safety), Blank, Blank, Number(-job.time.mass_scaling_dt)]);
    if job.time.damping > 0.0 {
        deck.keyword("DAMPING_GLOBAL");
        deck.card(&[Blank, Number(job.time.damping)]);
    }
    let output = &job.output;
    if output.history_interval > 0.0 {
        deck.keyword("DATABASE_GLSTAT");
        deck.card(&[Number(output.history_interval)]);
    }
    if output.field_interval > 0.0 {
        deck.keyword("DATABASE_BINARY_D3PLOT");
        deck.card(&[Number(output.field_interval)]);
    }
}

/// Returns a name as the entry of a table.
pub(in crate::input::deck) fn named(name: &str) -> (String, Value) {
    ("name".into(), name.into())
}

/// Writes a curve through these points, and returns its id.
fn points(deck: &mut DeckWriter, pairs: &[[f64; 2]]) -> u64 {
    deck.curves += 1;
    let id = deck.curves;
    deck.keyword("DEFINE_CURVE");
    deck.card(&[Id(id)]);
    pairs.iter().for_each(|p| deck.card(&p.map(Number)));
    id
}

/// Writes the parts. Parts of springs and discrete beams get individual materials, with ids from
/// `next` on.
fn parts(
    deck: &mut DeckWriter,
    model: &Model,
    rigid: &BTreeMap<u32, u64>,
    mut next: u64,
) -> Result<(), String> {
    let mut shapes: BTreeMap<u32, BTreeSet<bool>> = BTreeMap::new();
    for element in &model.mesh.elements {
        shapes.entry(element.part).or_default().insert(element.shape.is_shell());
    }
    let materials = &model.settings.materials;
    for part in &model.settings.parts {
        if let Some(spring) = &part.spring {
            springs::part(deck, part, spring, next);
            next += 1;
            continue;
        }
        if let Some(beam) = &part.discrete_beam {
            discrete_beams::part(deck, part, beam, next);
            next += 1;
            continue;
        }
        let of = shapes.get(&part.id).cloned().unwrap_or_default();
        if of.len() > 1 {
            return Err(format!(
                "part {} has shells and solids: give each its own part, as a deck requires",
                part.id
            ));
        }
        let plain =
            materials.iter().position(|m| m.name == part.material).map_or(0, |i| i as u64 + 1);
        let mid = rigid.get(&part.id).copied().unwrap_or(plain);
        if part.beam.is_some() || part.truss.is_some() {
            let law = materials.iter().find(|m| m.name == part.material);
            beams::part(deck, part, law.map_or("", |m| m.law.as_str()), mid)?;
            continue;
        }
        let shells = of.first().copied().unwrap_or(part.thickness > 0.0);
        let id = u64::from(part.id);
        if !part.layer.is_empty() && rigid.contains_key(&part.id) {
            return Err(format!(
                "part {}: a rigid part with layers cannot be written as a deck: give it a \
                 thickness and a material with the mean density",
                part.id
            ));
        }
        if !part.layer.is_empty() {
            let hourglass = hourglass(deck, part, shells);
            composites::part(deck, part, materials, hourglass);
            continue;
        }
        section(deck, part, shells);
        let hourglass = hourglass(deck, part, shells);
        deck.keyword("PART");
        deck.text(&line(&part.name));
        deck.card(&[Id(id), Id(id), Id(mid), Blank, if hourglass { Id(id) } else { Blank }]);
    }
    Ok(())
}

fn section(deck: &mut DeckWriter, part: &Part, shells: bool) {
    let id = u64::from(part.id);
    if !shells {
        deck.keyword("SECTION_SOLID");
        return deck.card(&[Id(id), Id(if is_cohesive(part) { cohesive::ELFORM } else { 1 })]);
    }
    deck.keyword("SECTION_SHELL");
    let mut first = vec![Id(id), Id(elform(part)), Number(1.0), Id(points_of(part) as u64)];
    if !part.angles.is_empty() {
        first.extend([Blank, Blank, Id(1)]);
    }
    deck.card(&first);
    let t = Number(part.thickness);
    if part.offset == 0.0 {
        deck.card(&[t]);
    } else {
        deck.card(&[t, t, t, t, Number(-part.offset)]);
    }
    let angles: Vec<CardValue> = part.angles.iter().map(|&angle| Number(angle)).collect();
    angles.chunks(8).for_each(|eight| deck.card(eight));
}

/// Returns the formulation of a part of shells in the format.
fn elform(part: &Part) -> u64 {
    let warping = part.parameters.get("warping") == Some(&Setting::Flag(true));
    match (part.element.as_deref(), warping) {
        (Some("belytschko_tsay"), _) if is_membrane(part) => 5,
        (Some("belytschko_tsay"), true) => 10,
        (Some("belytschko_tsay"), false) => 2,
        _ => 16,
    }
}

/// Returns true for a part of cohesive elements.
fn is_cohesive(part: &Part) -> bool {
    part.element.as_deref() == Some(COHESIVE)
}

/// Returns true for a part of membranes.
fn is_membrane(part: &Part) -> bool {
    part.parameters.get("membrane") == Some(&Setting::Flag(true))
}

/// Writes hourglass control and viscosity of a part. Returns true if there are any.
fn hourglass(deck: &mut DeckWriter, part: &Part, shells: bool) -> bool {
    let solids = !shells && !is_cohesive(part);
    let by_card = solids || part.element.as_deref() == Some("belytschko_tsay");
    let given = |key: &str| part.parameters.get(key);
    let form = match given("hourglass") {
        // A deck without a form means the viscous form, so the job's default must be written.
        None if shells && by_card => 4,
        None if solids => 6,
        Some(Setting::Word(word)) if word == HourglassForm::Viscous.word() => 1,
        Some(Setting::Word(word)) if word == HourglassForm::Stiffness.word() => 4,
        Some(Setting::Word(word)) if word == HourglassForm::AssumedStrain.word() => 6,
        _ => 0,
    };
    // Cards cannot hold a coefficient without a form, or for a form that has none.
    let default = || {
        let shape = if shells { Shape::Quad4 } else { Shape::Hex8 };
        let row = formulation(part, shape).filter(|_| by_card)?;
        Some(row.values(part).number("hourglass_coefficient"))
    };
    let coefficient = given("hourglass_coefficient").and_then(Setting::number).or_else(default);
    // Zeros on a card mean the defaults.
    let coefficient =
        coefficient.filter(|&c| c != 0.0 && by_card && (shells || matches!(form, 1 | 4)));
    let viscosity = match given("bulk_viscosity") {
        Some(Setting::List(list)) if !list.iter().all(|b| *b == 0.0) => list.as_slice(),
        _ => &[],
    };
    let on_card = |key: &str| match key {
        "points" => shells,
        "hourglass" | "warping" | "membrane" => by_card,
        "hourglass_coefficient" => coefficient.is_some(),
        "bulk_viscosity" => !viscosity.is_empty(),
        _ => false,
    };
    let mut own = Table::from_iter([("id".to_string(), Value::from(part.id))]);
    for (key, value) in part.parameters.iter().filter(|(key, _)| !on_card(key)) {
        own.extend(Value::try_from(value).ok().map(|value| (key.clone(), value)));
    }
    // A deck has no drilling stiffness for this formulation.
    if let (Some("belytschko_tsay"), None, false) =
        (part.element.as_deref(), given("drilling"), is_membrane(part))
        && let Some(row) = formulation(part, Shape::Quad4)
    {
        own.insert("drilling".into(), row.values(part).number("drilling").into());
    }
    if part.element.as_deref() == Some("fully_integrated_quad") {
        own.insert("element".into(), "fully_integrated_quad".into());
    }
    if part.skin {
        own.insert("skin".into(), true.into());
    }
    if let Some(thickness) = part.contact_thickness {
        own.insert("contact_thickness".into(), thickness.into());
    }
    if part.contact_thickness_scale != 1.0 {
        own.insert("contact_thickness_scale".into(), part.contact_thickness_scale.into());
    }
    if own.len() > 1 {
        deck.entry("part", own);
    }
    let any = (by_card && (form != 0 || coefficient.is_some())) || !viscosity.is_empty();
    if any {
        let [linear, quadratic] = viscosity.try_into().unwrap_or_default();
        deck.keyword("HOURGLASS");
        let (q1, q2) = (Number(quadratic), Number(linear));
        deck.card(&[
            Id(u64::from(part.id)),
            Id(form),
            Number(coefficient.unwrap_or(0.0)),
            Blank,
            q1,
            q2,
        ]);
    }
    any
}

/// Writes all sets, and returns their ids by name.
fn node_sets<'m>(deck: &mut DeckWriter, model: &'m Model) -> BTreeMap<&'m str, u64> {
    let mut ids = BTreeMap::new();
    let first = 1 + most("set-", model.mesh.node_sets.keys().map(String::as_str));
    for ((name, nodes), id) in model.mesh.node_sets.iter().zip(first..) {
        deck.keyword("SET_NODE_LIST_TITLE");
        deck.text(&line(name));
        deck.card(&[Id(id)]);
        let there = |n: &&crumple_proto::ids::NodeId| {
            model.mesh.nodes.binary_search_by_key(*n, |m| m.id).is_ok()
        };
        let nodes: Vec<CardValue> = nodes.iter().filter(there).map(|n| Id(n.label())).collect();
        nodes.chunks(8).for_each(|eight| deck.card(eight));
        ids.insert(name.as_str(), id);
    }
    ids
}

/// Writes the initial state of the model: masses, constraints, velocities.
fn initial(deck: &mut DeckWriter, job: &Job, set: impl Fn(&str) -> CardValue) {
    for (mass, id) in job.mass.iter().zip(1..) {
        deck.keyword("ELEMENT_MASS_NODE_SET");
        deck.card(&[Id(id), set(&mass.nodes), Number(mass.mass)]);
    }
    for fix in &job.fix {
        deck.keyword("BOUNDARY_SPC_SET");
        let held = ["x", "y", "z", "rx", "ry", "rz"]
            .map(|d| Id(u64::from(fix.dofs.iter().any(|f| f == d))));
        deck.card(&[&[set(&fix.nodes), Blank], held.as_slice()].concat());
    }
    // Rotational velocities are vectors, but cards have a unit vector and a speed, which differ
    // in the last bit.
    let plain = job.initial_velocity.iter().all(|v| v.spin == [0.0; 3]);
    for initial in job.initial_velocity.iter().filter(|_| plain) {
        deck.keyword("INITIAL_VELOCITY");
        deck.card(&[initial.nodes.as_deref().map_or(Blank, &set)]);
        deck.card(&initial.velocity.map(Number));
    }
    if !plain {
        list(deck, "initial_velocity", &job.initial_velocity);
    }
}

fn mesh(deck: &mut DeckWriter, model: &Model) {
    deck.keyword("NODE");
    for node in &model.mesh.nodes {
        let [x, y, z] = model.given_position(node).map(Number);
        deck.card(&[Id(node.id.label()), x, y, z]);
    }
    let discrete: BTreeSet<u32> =
        model.settings.parts.iter().filter(|p| p.discrete_beam.is_some()).map(|p| p.id).collect();
    let springs = model.mesh.elements.iter().filter(|e| !discrete.contains(&e.part));
    springs::elements(deck, springs);
    beams::elements(deck, model, &discrete);
    for (keyword, shells) in [("ELEMENT_SHELL", true), ("ELEMENT_SOLID", false)] {
        let of = |shape: Shape| match shells {
            true => shape.is_shell(),
            false => shape.is_solid() || shape == Shape::Cohesive8,
        };
        if !model.mesh.elements.iter().any(|e| of(e.shape)) {
            continue;
        }
        // The card of THICKNESS has the angle, too.
        for option in ["", "_THICKNESS", "_BETA", "_OFFSET", "_THICKNESS_OFFSET", "_BETA_OFFSET"] {
            let has = |e: &OwnSection| {
                let card = match (e.thickness > 0.0, e.angle != 0.0) {
                    (true, _) => "_THICKNESS",
                    (false, true) => "_BETA",
                    (false, false) => "",
                };
                option.strip_prefix(card) == Some(if e.offset.is_some() { "_OFFSET" } else { "" })
            };
            let mut some = model.mesh.elements.iter().filter(|e| of(e.shape) && has(&e.own));
            let mut elements = some.by_ref().peekable();
            if elements.peek().is_some() {
                deck.keyword(&format!("{keyword}{option}"));
            }
            elements.for_each(|element| write_element(deck, element, &model.job.part));
        }
    }
}

fn write_element(deck: &mut DeckWriter, element: &MeshElement, parts: &[Part]) {
    let mut fields = vec![Id(element.id.label()), Id(u64::from(element.part))];
    if element.shape == Shape::Tet10 {
        deck.card(&fields);
        deck.card(&element.nodes.map(|n| Id(n.label())));
        return;
    }
    let corners: &[usize] = match element.shape {
        Shape::Tri3 => &[0, 1, 2, 2],
        Shape::Quad4 => &[0, 1, 2, 3],
        Shape::Tet4 => &[0, 1, 2, 3, 3, 3, 3, 3],
        Shape::Wedge6 => &[0, 2, 5, 3, 1, 1, 4, 4],
        _ => &[0, 1, 2, 3, 4, 5, 6, 7],
    };
    fields.extend(corners.iter().map(|&c| Id(element.nodes[c].label())));
    deck.card(&fields);
    let own = element.own;
    if own.thickness > 0.0 || own.angle != 0.0 {
        let t = if own.thickness > 0.0 { Number(own.thickness) } else { Blank };
        let angle = if own.angle != 0.0 { Number(own.angle) } else { Blank };
        deck.card(&[t, t, t, t, angle]);
    }
    if let Some(offset) = own.offset {
        let of_part = || parts.iter().find(|p| p.id == element.part).map_or(0.0, |p| p.thickness);
        let thickness = if own.thickness > 0.0 { own.thickness } else { of_part() };
        deck.card(&[Number(0.5 * offset * thickness)]);
    }
}

/// Writes the settings without cards, if they are not the defaults, and lists that are never
/// written as cards.
fn left_over(deck: &mut DeckWriter, job: &Job, curves: &mut TimeCurves<'_>) {
    if !job.units.is_empty() {
        deck.rest.insert("units".into(), job.units.clone().into());
    }
    let carried = ["safety", "max_cycles", "dt_min_ratio", "mass_scaling_dt", "damping"];
    differing(deck, "time", &job.time, &Time::default(), &carried);
    // Cards allow only intervals above zero.
    let intervals = [
        ("history_interval", job.output.history_interval),
        ("field_interval", job.output.field_interval),
    ];
    let carried: Vec<&str> = intervals.into_iter().filter(|i| i.1 > 0.0).map(|i| i.0).collect();
    differing(deck, "output", &job.output, &Output::default(), &carried);
    differing(deck, "parallel", &job.parallel, &Parallel::default(), &[]);
    // The reader of cards removes the limit if a deck asks for mass scaling.
    if job.time.mass_scaling_dt > 0.0 {
        let limit = Table::from_iter([(
            "mass_scaling_limit".to_string(),
            Value::from(job.time.mass_scaling_limit),
        )]);
        let time = deck.rest.entry("time").or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(time) = time {
            time.extend(limit);
        }
    }
    list(deck, "symmetry", &job.symmetry);
    list(deck, "airbag", &job.airbag);
    // Entries without cards refer to curves by their names.
    let referring = ["gravity", "pressure", "airbag", "load", "motion", "wall"];
    if referring.iter().any(|key| deck.rest.contains_key(*key)) {
        for curve in &job.curve {
            curves.write_table(deck, Some(&curve.name));
        }
    }
}

pub(in crate::input::deck) fn list(
    deck: &mut DeckWriter,
    name: &str,
    entries: &[impl serde::Serialize],
) {
    if let Ok(value @ Value::Array(_)) = Value::try_from(entries)
        && !entries.is_empty()
    {
        deck.rest.insert(name.into(), value);
    }
}

/// Adds the keys of a table that differ from the defaults, without those on cards.
pub(in crate::input::deck) fn differing<T: serde::Serialize>(
    deck: &mut DeckWriter,
    name: &str,
    own: &T,
    default: &T,
    carried: &[&str],
) {
    let (Ok(Value::Table(own)), Ok(Value::Table(default))) =
        (Value::try_from(own), Value::try_from(default))
    else {
        return;
    };
    let keys = own
        .into_iter()
        .filter(|(key, value)| default.get(key) != Some(value) && !carried.contains(&key.as_str()));
    let keys: Table = keys.collect();
    if !keys.is_empty() {
        deck.rest.insert(name.into(), Value::Table(keys));
    }
}

/// Returns the keys of a job in the comments of a deck, by their tables.
pub(in crate::input::deck) fn keys_in_comments(deck: &str) -> Vec<String> {
    let lines = deck.lines().filter_map(|line| line.strip_prefix("$crumple: "));
    let mut found: Vec<String> = Vec::new();
    let mut table = String::new();
    for line in lines {
        if line.starts_with('[') {
            table = line.trim_matches(['[', ']']).to_string();
        } else if let Some((key, value)) = line.split_once(" = ") {
            match key {
                "name" | "id" => table += &format!(" {value}"),
                _ => found.push(format!("{table}: no card for {key}")),
            }
        }
    }
    found.dedup();
    found
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
    let text = match export(&model) {
        Ok(text) => text,
        Err(what) => return refuse(&what),
    };
    let left = keys_in_comments(&text);
    if !left.is_empty() {
        eprintln!("without a card, in comments that only Crumple reads:");
        left.iter().for_each(|what| eprintln!("  {what}"));
    }
    match &args.out {
        None => crate::stdout::write(format_args!("{text}")),
        Some(path) => {
            if let Err(error) = std::fs::write(path, text) {
                return refuse(&format_args!("{} cannot be written: {error}", path.display()));
            }
        }
    }
    0
}
