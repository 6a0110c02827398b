//! Converts the cards of a deck to a job: a tree of values as from a job file, and a mesh.

mod accelerations;
mod airbags;
mod barlat;
mod beams;
mod belts;
mod blast;
mod body_forces;
mod cohesive;
mod composites;
mod concrete;
mod contact;
mod control;
mod curves;
mod damage;
mod discrete_beams;
mod element_sets;
mod equations;
mod fabric;
mod gurson;
mod histories;
mod honeycomb;
pub(in crate::input::deck) mod inertia;
pub(in crate::input::deck) mod initial;
mod initial_stress;
mod interior;
mod joints;
mod karagozian_case;
mod left_out;
mod links;
mod loads;
mod materials;
pub mod mesh;
mod metals;
mod motion;
mod names;
mod node_ties;
pub(in crate::input::deck) mod particles;
mod parts;
mod polymers;
mod preloads;
mod pressure_dependent;
pub mod radioss;
mod rate_curves;
mod rigid;
mod sections;
pub(in crate::input::deck) mod segment_sets;
mod segments;
mod sensors;
mod sets;
mod shells;
mod soft_materials;
mod solid_welds;
pub(in crate::input::deck) mod space;
mod spring_laws;
mod springs;
mod stops;
mod switches;
mod tables;
mod tiebreaks;
mod ties;
mod transformation;
pub mod tree;
pub(in crate::input::deck) mod units;
mod unused;
mod vectors;
mod viscous_materials;
mod walls;
mod weld_histories;
mod welds;

use super::affine::Affine;
use super::diagnostics::Trouble;
use super::keywords::{self, KeywordRow};
use super::parameters::DeckParameters;
use super::record::{CardRecord, Cards};
use super::submodel::{CurveUnits, Submodel};
use super::table::Effect;
use super::text::{KeywordBlock, Texts};
use super::{Mapping, Unsupported};
use crate::input::job::tree::{Node, Place};
use crumple_proto::ids::NodeId;
use mesh::Rows;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use tree::{JobTable, Tree};

/// Data converted so far, and intermediate data.
pub struct DeckConverter {
    names: KeywordNames,
    /// Cards by keyword; each family of keywords takes its own.
    records: HashMap<&'static str, Vec<CardRecord>>,
    /// All records of supported keywords; they share what was asked for with `records`.
    read: Vec<CardRecord>,
    /// Nodes and elements.
    pub rows: Rows,
    /// Problems.
    pub trouble: Trouble,
    /// Requests of the deck and their settings.
    pub mapping: Vec<Mapping>,
    /// Content that the engine does not support.
    pub unsupported: Vec<Unsupported>,
    tree: Tree,
    curves: BTreeMap<i64, curves::DeckCurve>,
    tables: BTreeMap<i64, tables::DeckTable>,
    boxes: HashMap<i64, [[f64; 2]; 3]>,
    axes: HashMap<i64, [[f64; 3]; 3]>,
    node_sets: BTreeMap<i64, (Vec<NodeId>, Place)>,
    /// Titles of node sets that are names in the job, too.
    node_set_titles: BTreeMap<i64, String>,
    part_sets: BTreeMap<i64, Vec<(i64, Place)>>,
    segment_sets: BTreeMap<i64, Vec<segments::DeckSegment>>,
    /// Sets of elements, in the order of [`sets::ELEMENT_SETS`].
    element_sets: [sets::ElementSets; 4],
    parts: BTreeMap<i64, parts::DeckPart>,
    used_materials: Vec<i64>,
    /// Mass or volume of the particles of a part, with the place of its first particle.
    particle_sizes: BTreeMap<i64, (particles::ParticleSize, Place)>,
    /// Parts of solids with limits of welds, with their materials and places; materials of beams
    /// with such limits.
    weld_parts: Vec<(i64, i64, Place)>,
    weld_beams: BTreeSet<i64>,
    /// Parts of beams that come from welds of two nodes.
    welded_parts: BTreeSet<u32>,
    /// Materials of welds whose solids fail one by one.
    weld_alone: BTreeSet<i64>,
    /// Cards of equations of state.
    equation_cards: BTreeMap<i64, CardRecord>,
    /// Equations of state of parts of solids, in the order of the deck.
    equations: Vec<equations::PartEquation>,
    /// Scales of the forces of springs by part, with their places.
    spring_scales: BTreeMap<i64, (f64, Place)>,
    spring_laws: BTreeMap<i64, CardRecord>,
    discrete_beam_laws: BTreeMap<i64, CardRecord>,
    belts: belts::DeckBelts,
    /// Parts of discrete beams; true if their section has a coordinate system.
    discrete_beam_parts: BTreeMap<u32, bool>,
    /// Those whose axes lie along the line between the nodes.
    beams_along_lines: BTreeSet<u32>,
    /// Preloads of parts of beams.
    preloads: BTreeMap<i64, preloads::DeckPreload>,
    /// Parts of beams that need no orientation.
    round_parts: BTreeSet<u32>,
    /// Parts of beams whose sections have their height along the third axis.
    turned_parts: BTreeSet<u32>,
    /// Parts of beams that are trusses.
    truss_parts: BTreeSet<u32>,
    /// Directions of springs by part, with their places; `None` for the line between their nodes.
    spring_directions: BTreeMap<i64, (Option<springs::SpringOrientation>, Place)>,
    /// Ids of parts of shells with an offset; true if they have a contact thickness of their own.
    with_offset: Vec<(i64, bool)>,
    /// Individual friction of parts.
    part_friction: BTreeMap<i64, contact::Friction>,
    /// Ties with the numbers of their blocks.
    ties: Vec<(usize, JobTable)>,
    /// Contacts that are left of ties that fail.
    broken_contacts: Vec<CardRecord>,
    /// Names of rigid bodies by part.
    bodies: BTreeMap<i64, String>,
    /// Names of rigid bodies by node, for joints.
    node_bodies: HashMap<NodeId, String>,
    /// Inertias of nodes, xx, yy, zz, xy, yz, zx [mass length^2].
    node_inertias: BTreeMap<NodeId, ([f64; 6], Place)>,
    /// Stresses of elements at the start.
    stresses: initial_stress::DeckStresses,
    /// Initial velocities so far.
    velocities: Vec<initial::DeckVelocity>,
    end_time: f64,
    /// Parts of shells by the null material that makes them a skin.
    skins: BTreeMap<i64, i64>,
    /// Parts with an adpopt: its value and place.
    adaptive: BTreeMap<i64, (i64, Place)>,
    /// Place of the field that lets solids erode by their step, if it is set.
    eroding: Option<Place>,
    /// Materials and sections of unsupported keywords.
    left_out: left_out::LeftOutCards,
    /// Degrees of freedom that the deck fixes, in its order.
    fixes: Vec<motion::DeckFix>,
    /// Directions of `*DEFINE_VECTOR` by id, of any length.
    vectors: BTreeMap<i64, [f64; 3]>,
    /// Maps of `*DEFINE_TRANSFORMATION` so far.
    transformations: BTreeMap<i64, Affine>,
    /// Changes of files of `*INCLUDE_TRANSFORM`, in the order of the deck.
    submodels: Vec<Submodel>,
    curve_units: CurveUnits,
}

/// Names of keywords of a format, for messages.
pub struct KeywordNames {
    /// A set of nodes.
    node_set: &'static str,
    /// A part.
    part: &'static str,
    /// A curve.
    curve: &'static str,
    /// A coordinate system.
    system: &'static str,
}

/// Names in decks of LS-DYNA.
const LS_DYNA: KeywordNames = KeywordNames {
    node_set: "*SET_NODE_...",
    part: "*PART",
    curve: "*DEFINE_CURVE",
    system: "*DEFINE_COORDINATE_...",
};

/// Converts a deck. Returns the job; all other results are in the [`DeckConverter`].
pub fn build(texts: &Texts, leave_out: &[String], trouble: Trouble) -> (Node, DeckConverter) {
    let mut b = DeckConverter::new(trouble, LS_DYNA);
    b.collect(texts, leave_out);
    b.encrypted(texts);
    b.second_order();
    b.springs();
    b.belt_elements();
    b.discrete_beam_laws();
    b.beams();
    b.rows.number_apart(&mut b.mapping);
    b.particles();
    b.curves();
    b.control();
    b.implicit();
    b.sensors();
    b.tables();
    b.space();
    let mut materials = b.materials();
    let sections = b.sections();
    b.read_equations();
    b.read_preloads();
    b.parts(&materials, &sections);
    b.preloads_without_fibres();
    b.solid_welds(&mut materials);
    b.read_element_sets();
    b.segment_sets();
    b.sets();
    b.initial_stresses();
    b.node_transforms();
    b.welds();
    b.orient_beams();
    b.equations_of_state(&mut materials);
    b.units(&mut materials);
    b.spc();
    b.linear_equations();
    b.planes();
    b.links();
    b.vectors();
    b.rigid();
    b.switches();
    b.joints();
    b.fixes();
    b.motions();
    b.initial_velocities();
    b.masses();
    b.body_loads();
    b.part_damping();
    b.adaptivity();
    b.nodal_loads();
    b.pressures();
    b.non_reflecting();
    b.airbags();
    b.belts();
    b.walls();
    b.interior_contacts();
    b.tiebreaks();
    b.contacts(sections.defaults.shifted);
    b.ties();
    b.embedded();
    b.interpolations();
    b.node_sets_as_one();
    b.coincident_nodes();
    b.put_ties();
    b.histories();
    b.left_over();
    b.unused_fields();
    let sets = std::mem::take(&mut b.node_sets);
    for (id, (nodes, place)) in sets {
        b.rows.add_set(format!("set-{id}"), nodes, place);
    }
    b.without_lost_nodes();
    b.same_names();
    (std::mem::take(&mut b.tree).into_node(), b)
}

impl DeckConverter {
    /// Reports node sets that have the name of another one.
    fn same_names(&mut self) {
        for (name, place) in std::mem::take(&mut self.rows.same_names) {
            let message = format!("two node sets of the job have the name {name}");
            let help = "change the title or the id of one of them";
            self.trouble.error(place, message, help);
        }
    }

    /// Creates it without data.
    fn new(trouble: Trouble, names: KeywordNames) -> Self {
        Self {
            names,
            records: HashMap::new(),
            read: Vec::new(),
            rows: Rows::default(),
            trouble,
            mapping: Vec::new(),
            unsupported: Vec::new(),
            tree: Tree::default(),
            curves: BTreeMap::new(),
            tables: BTreeMap::new(),
            boxes: HashMap::new(),
            axes: HashMap::new(),
            node_sets: BTreeMap::new(),
            node_set_titles: BTreeMap::new(),
            part_sets: BTreeMap::new(),
            weld_parts: Vec::new(),
            weld_beams: BTreeSet::new(),
            welded_parts: BTreeSet::new(),
            weld_alone: BTreeSet::new(),
            segment_sets: BTreeMap::new(),
            element_sets: Default::default(),
            parts: BTreeMap::new(),
            used_materials: Vec::new(),
            particle_sizes: BTreeMap::new(),
            equation_cards: BTreeMap::new(),
            equations: Vec::new(),
            spring_scales: BTreeMap::new(),
            spring_laws: BTreeMap::new(),
            discrete_beam_laws: BTreeMap::new(),
            belts: belts::DeckBelts::default(),
            discrete_beam_parts: BTreeMap::new(),
            beams_along_lines: BTreeSet::new(),
            preloads: BTreeMap::new(),
            round_parts: BTreeSet::new(),
            turned_parts: BTreeSet::new(),
            truss_parts: BTreeSet::new(),
            spring_directions: BTreeMap::new(),
            with_offset: Vec::new(),
            part_friction: BTreeMap::new(),
            ties: Vec::new(),
            broken_contacts: Vec::new(),
            bodies: BTreeMap::new(),
            node_bodies: HashMap::new(),
            node_inertias: BTreeMap::new(),
            stresses: Default::default(),
            velocities: Vec::new(),
            end_time: 0.0,
            skins: BTreeMap::new(),
            adaptive: BTreeMap::new(),
            eroding: None,
            left_out: left_out::LeftOutCards::default(),
            fixes: Vec::new(),
            vectors: BTreeMap::new(),
            transformations: BTreeMap::new(),
            submodels: Vec::new(),
            curve_units: CurveUnits::default(),
        }
    }

    /// Reads all blocks by the table of keywords.
    fn collect(&mut self, texts: &Texts, leave_out: &[String]) {
        let mut parameters = DeckParameters::default();
        let left_out = |name: &str| {
            leave_out.iter().any(|l| l.trim_start_matches('*').eq_ignore_ascii_case(name))
        };
        for block in &texts.blocks {
            // An entry applies with and without options, and for all names of a keyword.
            if left_out(&block.name) || left_out(keywords::without_options(&block.name)) {
                self.left_out.note(texts, block, &parameters, left_out::BY_CHOICE);
                if block.name == "INCLUDE_TRANSFORM" {
                    self.submodels.push(Submodel::default());
                }
                continue;
            }
            match keywords::find(&block.name) {
                Some((row, _))
                    if left_out(row.keyword.name)
                        || row.keyword.aliases.iter().any(|alias| left_out(alias)) =>
                {
                    self.left_out.note(texts, block, &parameters, left_out::BY_CHOICE);
                }
                Some((row, options)) => self.block(texts, block, row, &options, &mut parameters),
                None => match keywords::instead_of(&block.name) {
                    Some(help) => {
                        let message = format!("*{} is not read", block.name);
                        self.trouble.warn_once(&block.name, block.place(), message, help);
                    }
                    None => self.unknown(texts, block, &parameters),
                },
            }
        }
    }

    /// Notes encrypted parts of the deck.
    fn encrypted(&mut self, texts: &Texts) {
        for &place in &texts.encrypted {
            let message = "a part of the deck is encrypted by PGP: only a program with the key of \
                           its vendor can read it"
                .to_string();
            let what = "an encrypted part".to_string();
            let lost = "the cards in it are missing; ask its vendor for open ones".into();
            self.unsupported.push(Unsupported { place, message, what, lost });
        }
    }

    /// Notes elements with nodes between their corners.
    fn second_order(&mut self) {
        for (id, place) in std::mem::take(&mut self.rows.curved) {
            let message = format!(
                "*ELEMENT_SHELL: element {id} has nodes n5 to n8 between its corners, which is not \
                 supported"
            );
            let what = "*ELEMENT_SHELL of eight nodes".to_string();
            let lost = "these shells have their corners only".into();
            self.unsupported.push(Unsupported { place, message, what, lost });
        }
    }

    /// Notes a keyword that the table does not have.
    fn unknown(&mut self, texts: &Texts, block: &KeywordBlock, parameters: &DeckParameters) {
        if block.name.starts_with("CONTROL_IMPLICIT_") {
            return self.left_out.implicit(block);
        }
        self.left_out.note(texts, block, parameters, left_out::NOT_SUPPORTED);
        let near = match keywords::near(&block.name) {
            Some(near) => format!("; the nearest supported keyword is *{near}"),
            None => String::new(),
        };
        let message = format!("*{} is not supported{near}", block.name);
        let what = format!("*{}", block.name);
        let lost = left_out::lost(&block.name).into();
        self.unsupported.push(Unsupported { place: block.place(), message, what, lost });
    }

    fn block(
        &mut self,
        texts: &Texts,
        block: &KeywordBlock,
        row: &'static KeywordRow,
        options: &[&'static str],
        parameters: &mut DeckParameters,
    ) {
        let name = row.keyword.name;
        match row.keyword.effect {
            Effect::Harmless => {
                let message = format!("*{} is not read", block.name);
                self.trouble.warn_once(name, block.place(), message, row.keyword.note);
                return;
            }
            Effect::NotYet => {
                let message = format!("*{} is not supported yet: {}", block.name, row.keyword.note);
                self.unsupported(block.place(), message, format!("*{}", block.name));
                self.left_out.note(texts, block, parameters, left_out::NOT_SUPPORTED);
            }
            Effect::Model => {}
        }
        let end = block.name.rsplit('_').next().unwrap_or_default();
        if keywords::is_number_of_bag(name, end) {
            let used = "not used: the cards are those of the name without it";
            self.map(format!("*{}", block.name), format!("the number {end}"), used);
        }
        if name == "PARAMETER_DUPLICATION" {
            return parameters.read_duplication(block, texts, &mut self.trouble);
        }
        if name.starts_with("PARAMETER") {
            return parameters.read(block, texts, &mut self.trouble);
        }
        let submodel = block.submodel.checked_sub(1).map(|k| k as usize);
        let submodel = submodel.map(|k| self.submodels.get(k).cloned().unwrap_or_default());
        let mut cards = Cards {
            texts,
            parameters,
            trouble: &mut self.trouble,
            submodel: submodel.as_ref().map(|s| (s, &mut self.curve_units)),
        };
        match name {
            "NODE" => self.rows.nodes(&mut cards, &row.cards[0].0, (block, &block.lines)),
            "ELEMENT_SHELL" => self.rows.shells(&mut cards, row, options, block),
            "ELEMENT_SOLID" => self.rows.solids(&mut cards, row, block),
            "INITIAL_STRESS_SHELL" | "INITIAL_STRESS_SOLID" => {
                self.stresses.read(&mut cards, row, options, block);
            }
            "ELEMENT_TSHELL" => self.rows.thick_shells(&mut cards, row, block),
            _ => {
                let records = cards.records(row, options, block);
                if row.keyword.effect != Effect::Model {
                    return;
                }
                self.read.extend(records.iter().cloned());
                match name {
                    "DEFINE_TRANSFORMATION" => {
                        records.iter().for_each(|r| self.transformation(r, submodel.is_some()));
                    }
                    "INCLUDE_TRANSFORM" => {
                        let outer = submodel.unwrap_or_default();
                        records.iter().for_each(|r| self.include_transform(r, &outer));
                    }
                    _ => self.records.entry(name).or_default().extend(records),
                }
            }
        }
    }

    /// Takes all records of a keyword, which no other code needs.
    fn take_records(&mut self, name: &str) -> Vec<CardRecord> {
        self.records.remove(name).unwrap_or_default()
    }

    /// Takes all records of some keywords, in the order of the deck.
    fn take_in_order(&mut self, keywords: &[&str]) -> Vec<CardRecord> {
        let mut all: Vec<CardRecord> =
            keywords.iter().flat_map(|keyword| self.take_records(keyword)).collect();
        all.sort_by_key(|record| record.block);
        all
    }

    /// Notes unsupported content; `what` is its name in the summary.
    fn unsupported(&mut self, place: Place, message: String, what: String) {
        let lost = format!("{what} has no effect");
        self.unsupported.push(Unsupported { place, message, what, lost });
    }

    /// Notes a value that the engine does not support; the other fields of the card act.
    fn unsupported_value(&mut self, record: &CardRecord, field: &str, why: &str) {
        let lost = format!("the card acts as if `{field}` were blank");
        self.unsupported_field(record, field, why, lost);
    }

    /// Notes a value that the engine does not support, and without which the card has no effect.
    fn unsupported_card(&mut self, record: &CardRecord, field: &str, why: &str) {
        let lost = format!("the whole card of {} has no effect", record.name());
        self.unsupported_field(record, field, why, lost);
    }

    fn unsupported_field(&mut self, record: &CardRecord, field: &str, why: &str, lost: String) {
        let value = record.line(field).map_or(String::new(), |l| l.real(field).to_string());
        let message = format!("{}: `{field}` = {value} is not supported: {why}", record.name());
        let what = format!("{} {field}={value}", record.name());
        self.unsupported.push(Unsupported { place: record.place(field), message, what, lost });
    }

    /// Notes a request of the deck and the settings used for it.
    fn map(&mut self, of: impl Into<String>, asked: impl Into<String>, used: impl Into<String>) {
        let entry = Mapping { of: of.into(), asked: asked.into(), used: used.into() };
        if !self.mapping.contains(&entry) {
            self.mapping.push(entry);
        }
    }

    /// Returns the name of the node set with this id. Reports an error at `place` if there is
    /// none.
    fn node_set(&mut self, id: i64, place: Place) -> Option<String> {
        if self.node_sets.contains_key(&id) {
            return Some(format!("set-{id}"));
        }
        let known: Vec<String> = self.node_sets.keys().map(i64::to_string).collect();
        self.missing(place, self.names.node_set, id, &known);
        None
    }

    /// Returns the existing parts of a set. Reports an error at `place` if there is no such set.
    fn part_set(&mut self, id: i64, place: Place) -> Vec<i64> {
        let Some(parts) = self.part_sets.get(&id).cloned() else {
            let known: Vec<String> = self.part_sets.keys().map(i64::to_string).collect();
            self.missing(place, "*SET_PART_...", id, &known);
            return Vec::new();
        };
        parts.into_iter().filter(|&(pid, place)| self.has_part(pid, place)).map(|p| p.0).collect()
    }

    /// Returns true if there is a part with this id. Otherwise reports an error at `place`.
    fn has_part(&mut self, id: i64, place: Place) -> bool {
        if self.parts.contains_key(&id) {
            return true;
        }
        let known: Vec<String> = self.parts.keys().map(i64::to_string).collect();
        self.missing(place, self.names.part, id, &known);
        false
    }

    /// Returns the part of a field `pid`, or those of the set of a field `psid`; none after a
    /// report.
    fn parts_named(&mut self, field: &str, id: i64, place: Place) -> Vec<i64> {
        match field {
            "psid" => self.part_set(id, place),
            _ if self.has_part(id, place) => vec![id],
            _ => Vec::new(),
        }
    }

    /// Returns the name of a node set with all nodes of these parts.
    fn nodes_of_parts(&mut self, parts: &[i64]) -> String {
        let mut parts = parts.to_vec();
        parts.sort_unstable();
        parts.dedup();
        let names: Vec<String> = parts.iter().map(i64::to_string).collect();
        let word = if parts.len() == 1 { "part" } else { "parts" };
        let name = format!("{word}-{}", names.join("-"));
        if !self.rows.has_set(&name) {
            let nodes = self.rows.nodes_of(|part| parts.contains(&i64::from(part)));
            self.rows.add_set(name.clone(), nodes, Place::Whole);
        }
        name
    }

    /// Reports that a record refers to something that does not exist, where it depends on the
    /// card what the model lacks then.
    fn missing(&mut self, place: Place, what: &str, id: i64, known: &[String]) {
        self.missing_for(place, (what, id), known, "the card acts without it, or has no effect");
    }

    /// Reports that a record refers to something that does not exist. Something that is left out
    /// has been reported: then it is a warning; `lost` is what the model lacks.
    fn missing_for(&mut self, place: Place, (what, id): (&str, i64), known: &[String], lost: &str) {
        if self.trouble.is_unsure() {
            return;
        }
        if let Some(reason) = self.left_out.reason(what, id) {
            let message = format!("there is no {what} with the id {id}: {reason}");
            return self.trouble.warning(place, message, lost);
        }
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let help = match known.is_empty() {
            true => format!("add a {what} with this id"),
            false => format!(
                "add it, or correct the id; {}",
                crate::input::job::nearest(&id.to_string(), &known)
            ),
        };
        self.trouble.error(place, format!("there is no {what} with the id {id}"), help);
    }

    /// Reports records of known keywords that no code has converted.
    fn left_over(&mut self) {
        // Sections have their rules by now.
        for name in ["COMMENT", "CONTROL_ENERGY", "CONTROL_CONTACT", "INTEGRATION_BEAM"] {
            self.take_records(name);
        }
        let left: Vec<CardRecord> =
            std::mem::take(&mut self.records).into_values().flatten().collect();
        for record in left {
            let message = format!("{} is not supported", record.name());
            self.unsupported(record.head, message, record.name());
        }
    }

    /// Adds an entry to a list of the job.
    fn add(&mut self, list: &str, entry: JobTable) {
        self.tree.add(list, entry);
    }
}
