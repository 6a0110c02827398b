//! Writes requested histories as cards: motion of nodes, sections, force transducers. Those that
//! no card holds, and all after them, are written after `$crumple:`, so that their order is kept.

use super::{Blank, CardValue, DeckWriter, Id, line};
use crate::input::job::Model;
use crumple_proto::histories::SectionCut;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{NodeHistory, TransducerHistory};
use crumple_proto::mesh::Shape;
use serde::Serialize;
use std::collections::HashMap;
use toml::Value;

/// Longest name on a card.
const LONGEST: usize = 70;
/// Most ids in a list on a line.
const PER_LINE: usize = 8;

/// Writes all histories.
pub fn write(deck: &mut DeckWriter, model: &Model, set: impl Fn(&str) -> CardValue) {
    nodes(deck, model, &set);
    sections(deck, model);
    transducers(deck, model, &set);
}

/// Writes entries without a card to a list of `[output]`.
fn without<T: Serialize>(deck: &mut DeckWriter, key: &str, entries: &[T]) {
    let tables: Vec<Value> = entries.iter().filter_map(|e| Value::try_from(e).ok()).collect();
    if tables.is_empty() {
        return;
    }
    deck.note(&format!("output.{key}"), super::LeftReason::NoCard, tables.len());
    let output = deck.rest.entry("output").or_insert_with(|| Value::Table(toml::Table::new()));
    if let Value::Table(output) = output {
        output.insert(key.into(), Value::Array(tables));
    }
}

/// Returns true for a name that a card holds and a reader returns.
fn fits(name: &str) -> bool {
    !name.is_empty() && name == line(name) && name.chars().count() <= LONGEST
}

/// Where the nodes of a history are on cards, in the order in which they are read.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum NodeCard {
    /// A node in axes of its own, with the number in its name.
    Accelerometer(u64),
    /// A node set with a title.
    Set,
    /// A list without a name.
    List,
    /// A node with a name.
    Named,
}

/// Returns the set whose title names a history of a set; `None` if no set has this name and these
/// nodes.
fn titled<'h>(history: &'h NodeHistory, model: &Model) -> Option<&'h str> {
    let set = history.nodes.as_deref()?;
    let title = if history.name.is_empty() { set } else { &history.name };
    let nodes = |name: &str| model.mesh.node_sets.get(name);
    (fits(title) && nodes(title).is_some() && nodes(title) == nodes(set)).then_some(title)
}

/// Returns the card of a history, or `None` if there is none: no card has nodes of a head.
fn node_card(history: &NodeHistory, model: &Model) -> Option<NodeCard> {
    let name = history.name.as_str();
    if history.head {
        return None;
    }
    if let Some(axes) = history.axes {
        let number = name.strip_prefix("accelerometer ")?.parse().ok()?;
        let same = history.nodes.is_none() && history.ids == axes[..1];
        return (same && name == format!("accelerometer {number}") && number > 0)
            .then_some(NodeCard::Accelerometer(number));
    }
    match (&history.nodes, history.ids.as_slice()) {
        (Some(_), []) => titled(history, model).map(|_| NodeCard::Set),
        (None, ids) if name.is_empty() && !ids.is_empty() => Some(NodeCard::List),
        (None, [_]) if fits(name) => Some(NodeCard::Named),
        _ => None,
    }
}

fn nodes(deck: &mut DeckWriter, model: &Model, set: impl Fn(&str) -> CardValue) {
    let all = &model.job.output.node;
    let cards: Vec<NodeCard> = all.iter().map_while(|history| node_card(history, model)).collect();
    let count = cards.chunk_by(|a, b| a <= b).next().map_or(0, <[_]>::len);
    for (history, card) in all.iter().zip(&cards[..count]) {
        let ids: Vec<CardValue> = history.ids.iter().map(|&id| Id(id)).collect();
        match card {
            NodeCard::Accelerometer(number) => {
                deck.keyword("ELEMENT_SEATBELT_ACCELEROMETER");
                let axes = history.axes.unwrap_or_default().map(Id);
                deck.card(&[&[Id(*number)], &axes[..]].concat());
            }
            NodeCard::Set => {
                deck.keyword("DATABASE_HISTORY_NODE_SET");
                deck.card(&[set(titled(history, model).unwrap_or_default())]);
            }
            NodeCard::List => {
                deck.keyword("DATABASE_HISTORY_NODE");
                ids.chunks(PER_LINE).for_each(|some| deck.card(some));
            }
            NodeCard::Named => {
                deck.keyword("DATABASE_HISTORY_NODE_ID");
                deck.named_card(history.ids.first().copied().unwrap_or(0), &history.name);
            }
        }
    }
    without(deck, "node", &all[count..]);
}

/// Returns the kind of set for elements of a shape: its keyword and its field on the card.
fn element_set(shape: Shape) -> Option<usize> {
    match shape {
        Shape::Beam2 | Shape::Truss2 | Shape::Point1 => None,
        Shape::Line2 => Some(2),
        _ => Some(usize::from(shape.is_shell())),
    }
}

/// Writes sections with the elements that they have in this model.
fn sections(deck: &mut DeckWriter, model: &Model) {
    let (cuts, all) = (&model.settings.histories.sections, &model.job.output.section);
    let of: HashMap<ElemId, (Shape, u32)> =
        model.mesh.elements.iter().map(|e| (e.id, (e.shape, e.part))).collect();
    // A reader leaves out the elements of rigid bodies, and discrete beams.
    let is_plain = |id: &ElemId| {
        let Some(&(shape, part)) = of.get(id) else { return false };
        let discrete = |p: &crumple_proto::job::Part| p.id == part && p.discrete_beam.is_some();
        element_set(shape).is_some()
            && !model.job.rigid.iter().any(|body| body.parts.contains(&part))
            && !model.job.part.iter().any(discrete)
    };
    let has_card = |cut: &SectionCut| fits(&cut.name) && cut.elements.iter().all(is_plain);
    let names = |count: usize| cuts[..count].iter().any(|cut| cut.name == cuts[count].name);
    let count = (0..cuts.len()).take_while(|&k| has_card(&cuts[k]) && !names(k)).count();
    for (cut, number) in cuts[..count].iter().zip(1..) {
        let nodes: Vec<u64> = cut.nodes.iter().map(|n: &NodeId| n.label()).collect();
        let nodes = Id(deck.node_set(&nodes));
        let mut fields = [Blank; 3];
        for (kind, keyword) in ["SET_SOLID", "SET_SHELL_LIST", "SET_DISCRETE"].iter().enumerate() {
            let own = cut.elements.iter().filter(|id| element_set(of[id].0) == Some(kind));
            let own: Vec<CardValue> = own.map(|id| Id(id.label())).collect();
            if !own.is_empty() {
                deck.keyword(keyword);
                deck.card(&[Id(number)]);
                own.chunks(PER_LINE).for_each(|some| deck.card(some));
                fields[kind] = Id(number);
            }
        }
        let [solids, shells, springs] = fields;
        deck.keyword("DATABASE_CROSS_SECTION_SET_ID");
        deck.named_card(number, &cut.name);
        deck.card(&[nodes, solids, Blank, shells, Blank, springs]);
    }
    without(deck, "section", &all[count..]);
}

fn transducers(deck: &mut DeckWriter, model: &Model, set: impl Fn(&str) -> CardValue) {
    let all = &model.job.output.transducer;
    let has_card = |t: &&TransducerHistory| {
        (t.name.is_empty() || fits(&t.name))
            && (t.parts.is_empty() || t.nodes.is_none())
            && (t.from_parts.is_empty() || t.from_nodes.is_none())
    };
    let count = all.iter().take_while(has_card).count();
    for transducer in &all[..count] {
        let mut side = |parts: &[u32], nodes: &Option<String>| match nodes {
            Some(nodes) => [set(nodes), Id(4)],
            None if parts.is_empty() => [Blank; 2],
            None => [Id(deck.part_set(parts)), Id(2)],
        };
        let [a, a_type] = side(&transducer.parts, &transducer.nodes);
        let [b, b_type] = side(&transducer.from_parts, &transducer.from_nodes);
        deck.keyword("CONTACT_FORCE_TRANSDUCER_PENALTY_ID");
        deck.contacts += 1;
        deck.named_card(deck.contacts, &transducer.name);
        deck.card(&[a, b, a_type, b_type]);
        deck.card(&[]);
        deck.card(&[]);
    }
    without(deck, "transducer", &all[count..]);
}
