//! Writes ties of nodes to surfaces, to the mean motion of nodes and to single nodes. Keys of a tie
//! without a field on its card are written after `$crumple:` with the name of the tie.

use super::faces::{corners, segments, sorted};
use super::rest::difference;
use super::writer::unique_names;
use super::{Blank, CardValue, DeckWriter, Id, Number, contact, most, named, table_of, value_of};
use crate::input::job::{Model, outer_faces};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{ContactInput, TieFailureInput, TieInput, TieLimits};
use crumple_proto::mesh::{Shape, free_faces};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Cards of one tie.
enum TieCards {
    /// To a surface.
    Surface(CardSurface),
    /// To the mean motion of nodes.
    Mean { slaves: Vec<u64>, masters: Vec<u64> },
    /// From all other nodes of a set to its first one.
    Node { all: Vec<u64> },
}

/// A surface to which nodes are tied.
enum CardSurface {
    /// All faces of parts.
    Parts(Vec<u32>),
    /// Single faces, of these parts.
    Faces { faces: Vec<[NodeId; 4]>, parts: Vec<u32> },
}

impl TieCards {
    /// Returns the cards of a tie, or `None` if there are none.
    fn new(tie: &TieInput, model: &Model) -> Option<Self> {
        let nodes = |set: &str| model.mesh.node_sets.get(set).map(|nodes| sorted(nodes));
        // Weights, and the node that a reader takes, follow the ids of the user. Only nodes of
        // elements have weights.
        let moves = |node: &NodeId| model.mesh.nodes.binary_search_by_key(node, |n| n.id).is_ok();
        let by_id = |set: &str| {
            let mut ids: Vec<u64> =
                nodes(set)?.iter().filter(|node| moves(node)).map(|node| node.label()).collect();
            ids.sort_unstable();
            Some(ids)
        };
        // The card of the format is for nodes of beams only.
        if tie.inside {
            return None;
        }
        if let Some(node) = tie.node {
            let slaves = by_id(&tie.nodes)?;
            let is_first = slaves.first().is_some_and(|&other| node < other);
            let all = [&[node][..], &slaves].concat();
            return (is_first && !tie.rotations).then_some(Self::Node { all });
        }
        if let Some(of) = &tie.mean_of {
            return Some(Self::Mean { slaves: by_id(&tie.nodes)?, masters: by_id(of)? });
        }
        let Some(set) = &tie.faces else {
            return Some(Self::Surface(CardSurface::Parts(tie.parts.clone())));
        };
        // A deck keeps the nodes of the segments, which must hold no other face.
        let free = free_faces(&model.mesh.elements);
        let of_part = |part: u32| tie.parts.is_empty() || tie.parts.contains(&part);
        let found = outer_faces(&model.mesh, &free, of_part, Some(&nodes(set)?));
        let faces: Vec<[NodeId; 4]> = found.iter().map(|&face| corners(model, face)).collect();
        let within = sorted(faces.as_flattened());
        let same = outer_faces(&model.mesh, &free, |_| true, Some(&within)) == found;
        let parts = parts_with(model, &within);
        same.then_some(Self::Surface(CardSurface::Faces { faces, parts }))
    }
}

/// Returns the parts in contact that have any of these nodes.
fn parts_with(model: &Model, nodes: &[NodeId]) -> Vec<u32> {
    let found = model.mesh.elements.iter().filter(|e| {
        let touches = !e.shape.faces().is_empty() || e.shape == Shape::Point1;
        touches && e.corners().iter().any(|n| nodes.binary_search(n).is_ok())
    });
    found.map(|e| e.part).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Writes ties up to the first one without a card; it and all others stay in comments, so that
/// their order is kept.
pub fn write(deck: &mut DeckWriter, model: &Model, set: impl Fn(&str) -> CardValue) {
    let ties = &model.job.tie;
    let cards: Vec<TieCards> = ties.iter().map_while(|tie| TieCards::new(tie, model)).collect();
    let (with, without) = ties.split_at(cards.len());
    let names = unique_names("tie", ties.iter().map(|tie| tie.name.as_str()));
    // A reader names ties to a mean by their number. No other tie may have such a name.
    let is_mean = |i: usize| matches!(cards.get(i), Some(TieCards::Mean { .. }));
    let others = (0..).zip(ties).filter(|(i, _)| !is_mean(*i)).map(|(_, tie)| tie.name.as_str());
    let mut means = most("interpolation ", others);
    for ((tie, name), cards) in with.iter().zip(&names).zip(cards) {
        match cards {
            TieCards::Surface(surface) => {
                to_surface(deck, model, (tie, name), (set(&tie.nodes), surface));
            }
            TieCards::Mean { slaves, masters } => {
                for slave in slaves {
                    means += 1;
                    deck.keyword("CONSTRAINED_INTERPOLATION");
                    let ddof = if tie.rotations { 123_456 } else { 123 };
                    deck.card(&[Id(means), Id(slave), Id(ddof)]);
                    for (place, &master) in masters.iter().enumerate() {
                        let weight = tie.weights.get(place).copied().unwrap_or(1.0);
                        deck.card(&[Id(master), Id(123), Number(weight)]);
                    }
                }
            }
            TieCards::Node { all } => {
                let set = deck.node_set(&all);
                deck.keyword("CONSTRAINED_NODE_SET");
                deck.card(&[Id(set), Id(7)]);
            }
        }
    }
    for (tie, name) in without.iter().zip(&names[with.len()..]) {
        // A reader merges entries with the same name.
        let same = ties.iter().filter(|other| other.name == tie.name).count();
        let name = if same > 1 && !tie.name.is_empty() { name } else { &tie.name };
        deck.whole("tie", table_of(&TieInput { name: name.clone(), ..tie.clone() }));
    }
}

/// Writes a tie of a node set to a surface.
fn to_surface(
    deck: &mut DeckWriter,
    model: &Model,
    (tie, name): (&TieInput, &str),
    (nodes, surface): (CardValue, CardSurface),
) {
    let (surface, kind, parts) = match surface {
        CardSurface::Parts(parts) => (deck.part_set(&parts), 2, parts),
        CardSurface::Faces { faces, parts } => (segments(deck, &faces), 0, parts),
    };
    let TieKind { keyword, friction, limits, read } = kind_of(tie, model, &parts);
    deck.keyword(&format!("{keyword}_ID"));
    deck.contacts += 1;
    deck.named_card(deck.contacts, name);
    deck.card(&[nodes, Id(surface), Id(4), Id(kind)]);
    deck.card(&friction.map_or(vec![Number(0.0)], |c| contact::friction(&c).to_vec()));
    let [ahead, behind] = match tie.tolerance {
        t if t > 0.0 => [-t, 0.0],
        _ => read.thicknesses,
    };
    deck.card(&[Blank, Blank, Number(ahead), Number(behind)]);
    if let Some(limits) = limits {
        deck.card(&limits);
    }
    let mut own = Table::from_iter([named(name)]);
    let flags = [
        ("rotations", tie.rotations, read.rotations),
        ("offset", tie.offset, read.offset),
        ("may_be_empty", tie.may_be_empty, read.may_be_empty),
    ];
    for (key, given, _) in flags.into_iter().filter(|(_, given, read)| given != read) {
        own.insert(key.into(), given.into());
    }
    if tie.thicknesses != read.thicknesses {
        own.insert("thicknesses".into(), value_of(&tie.thicknesses));
    }
    if let (Some(given), Some(read)) = (&tie.failure, &read.failure) {
        let keys = difference(given, read, &[]);
        if !keys.is_empty() {
            own.insert("failure".into(), Value::Table(keys));
        }
    }
    if own.len() > 1 {
        deck.entry("tie", own);
    }
}

/// The card of a tie to a surface.
struct TieKind {
    keyword: String,
    /// The contact that follows a failure, if the card adds it.
    friction: Option<ContactInput>,
    /// The fields of the failure.
    limits: Option<Vec<CardValue>>,
    /// The tie that a reader has by the card.
    read: TieInput,
}

/// Returns the card of a tie to a surface of these parts.
fn kind_of(tie: &TieInput, model: &Model, parts: &[u32]) -> TieKind {
    let Some(failure) = &tie.failure else {
        let keyword = if tie.rotations { "SHELL_EDGE_TO_SURFACE" } else { "NODES_TO_SURFACE" };
        let option = if tie.offset { "_OFFSET" } else { "" };
        return TieKind {
            keyword: format!("CONTACT_TIED_{keyword}{option}"),
            friction: None,
            limits: None,
            read: TieInput { may_be_empty: false, ..tie.clone() },
        };
    };
    let strengths = [Number(failure.normal), Number(failure.shear)];
    let of_card = |opening: f64, exponents: [f64; 2]| {
        Some(TieFailureInput { opening, exponents, ..failure.clone() })
    };
    let plain = TieInput { rotations: false, offset: false, may_be_empty: false, ..tie.clone() };
    if failure.limits == TieLimits::Force {
        return TieKind {
            keyword: "CONTACT_TIEBREAK_NODES_ONLY".into(),
            friction: None,
            limits: Some([strengths, failure.exponents.map(Number)].concat()),
            read: TieInput { failure: of_card(0.0, failure.exponents), ..plain },
        };
    }
    // Damage and rotations have only cards that add a contact; these fit if the job has this
    // contact.
    let asks = failure.opening > 0.0 || tie.rotations;
    let nodes = model.mesh.node_sets.get(&tie.nodes).map_or(Vec::new(), |set| sorted(set));
    let touching = || contact::between(&model.job, [&parts_with(model, &nodes), parts]);
    match asks.then(touching).flatten() {
        Some(friction) => {
            let damage = [Number(failure.opening)];
            let (option, more) = match failure.opening > 0.0 {
                true => (Id(6), &damage[..]),
                false => (Number(-2.0), &[][..]),
            };
            TieKind {
                keyword: "CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE_TIEBREAK".into(),
                friction: Some(friction),
                limits: Some([&[option][..], &strengths, more].concat()),
                read: TieInput {
                    rotations: failure.opening == 0.0,
                    offset: true,
                    may_be_empty: true,
                    // These fields would be the thicknesses of the contact, too.
                    thicknesses: [0.0; 2],
                    failure: of_card(failure.opening, [2.0; 2]),
                    ..plain
                },
            }
        }
        None => {
            let offset = if tie.offset { Id(1) } else { Blank };
            TieKind {
                keyword: "CONTACT_TIEBREAK_SURFACE_TO_SURFACE_ONLY".into(),
                friction: None,
                limits: Some([&strengths[..], &[Blank, offset]].concat()),
                read: TieInput { offset: tie.offset, failure: of_card(0.0, [2.0; 2]), ..plain },
            }
        }
    }
}
