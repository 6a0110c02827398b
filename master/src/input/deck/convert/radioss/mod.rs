//! Converts the cards of a Radioss deck to a job: a tree of values as from a job file, and a mesh.
//!
//! It uses the data and the tables of [`DeckConverter`], as decks of LS-DYNA do.

mod biquad;
mod bodies;
mod contact;
mod control;
mod fabric;
mod functions;
mod groups;
mod hill;
mod histories;
mod inner_bodies;
mod loads;
mod materials;
mod mesh;
mod motion;
mod parameters;
mod parts;
mod predefined;
mod properties;
mod surfaces;
mod ties;
mod walls;

use super::left_out::{BY_CHOICE, NOT_SUPPORTED};
use super::parts::DeckPart;
use super::{DeckConverter, KeywordNames};
use crate::input::deck::Unsupported;
use crate::input::deck::diagnostics::Trouble;
use crate::input::deck::keywords::KeywordRow;
use crate::input::deck::parameters::DeckParameters;
use crate::input::deck::radioss::keywords;
use crate::input::deck::record::{CardRecord, Cards};
use crate::input::deck::table::Effect;
use crate::input::deck::text::{KeywordBlock, Texts};
use crate::input::job::tree::{Node, Place};
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use surfaces::StarterSurface;

/// Names in decks of Radioss.
const RADIOSS: KeywordNames =
    KeywordNames { node_set: "/GRNOD/...", part: "/PART", curve: "/FUNCT", system: "/SKEW/FIX" };

/// Material of a part, property of a part and subset, as its card has them.
#[derive(Clone, Copy, Debug)]
struct StarterPart {
    property: i64,
    material: i64,
    subset: i64,
}

/// Nodes and parts of the elements of a group.
type StarterGroup = (BTreeSet<NodeId>, BTreeSet<i64>);
/// Nodes, part and kind of an element.
type StarterEntry = (Vec<NodeId>, i64, &'static str);

/// Data of a Radioss deck converted so far.
pub struct StarterConverter {
    deck: DeckConverter,
    /// Values of the cards of parts.
    parts: BTreeMap<i64, StarterPart>,
    /// Parts of subsets.
    subsets: BTreeMap<i64, BTreeSet<i64>>,
    /// Surfaces by id.
    surfaces: BTreeMap<i64, StarterSurface>,
    /// Parts of lines by id.
    lines: BTreeMap<i64, BTreeSet<i64>>,
    /// Elements of groups by kind and id: their nodes and parts.
    element_groups: BTreeMap<(&'static str, i64), StarterGroup>,
    /// Index of elements in the rows by id, for groups.
    elements: HashMap<ElemId, Vec<StarterEntry>>,
    /// Bodies by their main node.
    mains: BTreeMap<NodeId, bodies::StarterBody>,
    /// Bodies that are parts of others, by their main nodes.
    inner_bodies: BTreeMap<NodeId, bodies::StarterBody>,
    /// Groups of groups and of surfaces, until these are known.
    later: Vec<CardRecord>,
    /// Ids of groups by their titles.
    titles: BTreeMap<String, Vec<i64>>,
    /// Names of parts and bodies.
    names: BTreeSet<String>,
    /// Nodes of elements, empty until they are needed.
    used: BTreeSet<NodeId>,
    /// Nodes of walls.
    wall_nodes: BTreeSet<NodeId>,
    /// Motions of nodes of walls.
    wall_motions: BTreeMap<NodeId, Vec<motion::StarterMotion>>,
    /// Main nodes of the bodies with nodes that have an initial velocity: true if the main node
    /// has one too, and the place of the group.
    moved: BTreeMap<NodeId, (bool, Place)>,
    /// Initial velocities so far.
    velocities: Vec<motion::StarterVelocity>,
    /// Vectors that show the second axis of beams, by index.
    shown: Vec<(usize, (NodeId, [f64; 3]), Place)>,
    /// Numbers added to the ids of triangles and of trusses.
    raised: [u64; 2],
    /// Tetrahedra whose nodes were put in order.
    turned: usize,
    /// Ids of units that entities refer to, with their places.
    units: Vec<(i64, Place)>,
    /// Materials with the axes of their parts.
    fabrics: fabric::Fabrics,
    /// Units of the deck, as the job has them; `None` without units in `/BEGIN`.
    unit_names: Option<String>,
    /// Names of values.
    parameters: DeckParameters,
    /// Number of curves that were made from others.
    made_curves: usize,
    /// Names of the curves of the job.
    curve_names: BTreeSet<String>,
}

/// Converts a deck. Returns the job; all other results are in the [`DeckConverter`].
pub fn build(texts: &Texts, leave_out: &[String], trouble: Trouble) -> (Node, DeckConverter) {
    let mut b = StarterConverter::new(trouble);
    b.collect(texts, leave_out);
    b.show_axes();
    b.turn_tetrahedra();
    b.kinds_apart();
    b.deck.rows.number_apart(&mut b.deck.mapping);
    b.control();
    b.functions();
    b.systems();
    let materials = b.materials();
    let properties = b.properties();
    b.parts(&materials, &properties);
    b.deck.orient_beams();
    b.subsets();
    b.element_groups();
    b.groups();
    b.surfaces();
    b.find_wall_nodes();
    b.bodies();
    b.fix();
    b.loads();
    b.put_bodies();
    b.deck.fixes();
    b.motions();
    b.initial_velocities();
    b.damping();
    b.masses();
    b.pressures();
    b.walls();
    b.contacts();
    b.ties();
    b.histories();
    b.deck.left_over();
    b.deck.unused_fields();
    b.name_groups();
    b.deck.without_lost_nodes();
    b.deck.same_names();
    let mut deck = b.deck;
    (std::mem::take(&mut deck.tree).into_node(), deck)
}

impl StarterConverter {
    fn new(trouble: Trouble) -> Self {
        Self {
            deck: DeckConverter::new(trouble, RADIOSS),
            parts: BTreeMap::new(),
            subsets: BTreeMap::new(),
            surfaces: BTreeMap::new(),
            lines: BTreeMap::new(),
            element_groups: BTreeMap::new(),
            elements: HashMap::new(),
            mains: BTreeMap::new(),
            inner_bodies: BTreeMap::new(),
            later: Vec::new(),
            titles: BTreeMap::new(),
            names: BTreeSet::new(),
            used: BTreeSet::new(),
            wall_nodes: BTreeSet::new(),
            wall_motions: BTreeMap::new(),
            moved: BTreeMap::new(),
            velocities: Vec::new(),
            shown: Vec::new(),
            raised: [0; 2],
            turned: 0,
            units: Vec::new(),
            fabrics: fabric::Fabrics::default(),
            unit_names: None,
            parameters: DeckParameters::of("/PARAMETER/GLOBAL/REAL or INTEGER"),
            made_curves: 0,
            curve_names: BTreeSet::new(),
        }
    }

    /// Reads all blocks by the table of keywords.
    fn collect(&mut self, texts: &Texts, leave_out: &[String]) {
        let is_left_out = |name: &str| leave_out.iter().any(|l| l.eq_ignore_ascii_case(name));
        self.read_parameters(texts, &is_left_out);
        for block in &texts.blocks {
            match keywords::find(&block.name) {
                _ if is_left_out(&block.name) => self.note(texts, block, BY_CHOICE),
                Some(row) if is_left_out(row.keyword.name) => self.note(texts, block, BY_CHOICE),
                Some(row) => self.block(texts, block, row),
                None => self.unknown(texts, block),
            }
        }
    }

    fn block(&mut self, texts: &Texts, block: &KeywordBlock, row: &'static KeywordRow) {
        let name = row.keyword.name;
        match row.keyword.effect {
            Effect::Harmless => {
                let message = format!("{} is not read", block.name);
                let trouble = &mut self.deck.trouble;
                trouble.warn_once(name, block.place(), message, row.keyword.note);
                return;
            }
            Effect::NotYet => {
                let message = format!("{} is not supported yet: {}", block.name, row.keyword.note);
                self.deck.unsupported(block.place(), message, block.name.clone());
                self.note(texts, block, NOT_SUPPORTED);
                return;
            }
            Effect::Model => {}
        }
        if mesh::is_mesh(name) {
            return self.mesh_block(texts, block, row);
        }
        if name.starts_with(parameters::PARAMETER) {
            return;
        }
        let mut cards = Cards::of(texts, &self.parameters, &mut self.deck.trouble);
        for record in cards.records(row, &[], block) {
            self.note_unit(record.integer("unit"), record.place("unit"));
            self.deck.read.push(record.clone());
            self.deck.records.entry(name).or_default().push(record);
        }
    }

    /// Notes a block that is not converted, and why.
    fn note(&mut self, texts: &Texts, block: &KeywordBlock, why: &str) {
        self.deck.left_out.note(texts, block, &self.parameters, why);
    }

    /// Notes that an entity refers to units.
    fn note_unit(&mut self, unit: i64, place: Place) {
        if unit != 0 {
            self.units.push((unit, place));
        }
    }

    /// Notes a keyword that the table does not have.
    fn unknown(&mut self, texts: &Texts, block: &KeywordBlock) {
        self.note(texts, block, NOT_SUPPORTED);
        let near = match keywords::near(&block.name) {
            Some(near) => format!("; the nearest supported keyword is {near}"),
            None => String::new(),
        };
        let message = format!("{} is not supported{near}", block.name);
        let lost = format!("the model lacks what {} gives", block.name);
        let what = block.name.clone();
        self.deck.unsupported.push(Unsupported { place: block.place(), message, what, lost });
    }

    /// Returns all records of keywords in the order of the deck.
    fn take(&mut self, names: &[&str]) -> Vec<CardRecord> {
        self.deck.take_in_order(names)
    }

    /// Returns the existing part of an id, or reports that there is none.
    fn part(&mut self, id: i64, place: Place) -> Option<i64> {
        self.deck.has_part(id, place).then_some(id)
    }

    /// Adds a part that messages about references know.
    fn add_part(&mut self, id: i64, place: Place, material: Option<String>) {
        let part = DeckPart { rigid: None, material, inertia: None, place };
        self.deck.parts.insert(id, part);
    }
}
