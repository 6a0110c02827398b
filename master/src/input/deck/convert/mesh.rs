//! Converts nodes and elements line by line without intermediate data, because there may be
//! millions.

use crate::input::deck::Mapping;
use crate::input::deck::fields::{Fields, split};
use crate::input::deck::keywords::KeywordRow;
use crate::input::deck::number;
use crate::input::deck::parameters::{Parameter, reference};
use crate::input::deck::record::{Cards, layout};
use crate::input::deck::submodel::Submodel;
use crate::input::deck::table::Card;
use crate::input::deck::text::KeywordBlock;
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::initial::InitialPoint;
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, Shape, solid_of_eight};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// A line of a file: the file's number, first byte and one past the last.
type LineSpan = (u32, u32, u32);

/// Nodes and elements as written, and their places.
#[derive(Debug, Default)]
pub struct Rows {
    pub nodes: Vec<MeshNode>,
    pub shells: Vec<MeshElement>,
    pub solids: Vec<MeshElement>,
    pub springs: Vec<MeshElement>,
    pub beams: Vec<MeshElement>,
    pub particles: Vec<MeshElement>,
    node_lines: Vec<LineSpan>,
    shell_lines: Vec<LineSpan>,
    solid_lines: Vec<LineSpan>,
    spring_lines: Vec<LineSpan>,
    beam_lines: Vec<LineSpan>,
    particle_lines: Vec<LineSpan>,
    sets: BTreeMap<String, (Vec<NodeId>, Place)>,
    /// Names that two different node sets have, with the place of the second one.
    pub same_names: Vec<(String, Place)>,
    /// Nodes with constraint codes `tc` and `rc`, with a line that has these codes.
    pub held: BTreeMap<(i64, i64), (Vec<NodeId>, Place)>,
    /// Thicknesses of single shells at their corners [length], by index in `shells`.
    pub thickness: Vec<(usize, [f64; 4])>,
    /// Shells of more than four nodes, of which only the corners are added, with their places.
    pub curved: Vec<(ElemId, Place)>,
    /// Offsets of shells from their nodes, by index [length].
    pub offsets: Vec<(usize, f64)>,
    /// Thick shells, by index in `solids`, ascending.
    pub thick: Vec<usize>,
    index: HashMap<NodeId, usize>,
    /// Largest id of a node, 0 until it is needed.
    top: u64,
    /// Offsets added to the ids of solids, springs and beams.
    pub raised: [u64; 3],
    /// Elements that were removed.
    pub removed: Vec<MeshElement>,
    /// Stresses and plastic strains at the start.
    pub initial: Vec<InitialPoint>,
    /// Nodes of no element that stand for a rigid body: the job does not have them.
    pub stand_ins: BTreeSet<NodeId>,
}

/// Codes `tc` and `rc` of a node that neither moves nor turns.
const HELD_IN_PLACE: (i64, i64) = (7, 7);

/// One line of a keyword for mesh data during reading.
pub(super) struct MeshLine<'a, 'c> {
    cards: &'a mut Cards<'c>,
    block: &'a KeywordBlock,
    card: &'a Card,
    line: (u32, u32),
    fields: Fields,
    /// False if a field could not be read.
    pub(super) whole: bool,
}

impl MeshLine<'_, '_> {
    /// Returns the change of the file, if it has one.
    fn submodel(&self) -> Option<&Submodel> {
        self.cards.submodel.as_ref().map(|s| s.0)
    }

    /// Returns ids of an element and its part in the whole deck.
    fn ids(&self, id: ElemId, part: u64) -> (ElemId, u64) {
        self.submodel().map_or((id, part), |s| (s.element(id), s.part(part)))
    }

    /// Returns the id of a node in the whole deck.
    fn node(&self, id: u64) -> NodeId {
        self.submodel().map_or(NodeId(id), |s| s.node(NodeId(id)))
    }

    /// Returns true if the file is reflected.
    fn reflects(&self) -> bool {
        self.submodel().is_some_and(|s| s.map.reflects())
    }

    /// Returns a length in the units of the whole deck, 0 for a blank.
    fn length(&mut self, index: usize) -> f64 {
        let given = self.real(index);
        self.submodel().map_or(given, |s| s.length(given))
    }

    fn text(&self, index: usize) -> &[u8] {
        self.fields.text(self.cards.texts.line(self.block, self.line), index)
    }

    /// Returns an integer, 0 for a blank.
    pub(super) fn integer(&mut self, index: usize) -> i64 {
        let text = self.text(index);
        if text.is_empty() {
            return 0;
        }
        let plain = plain_integer(text).or_else(|| number::integer(text));
        plain.unwrap_or_else(|| self.odd(index, "a whole number") as i64)
    }

    /// Returns a number, 0 for a blank.
    pub(super) fn real(&mut self, index: usize) -> f64 {
        let text = self.text(index);
        if text.is_empty() {
            return 0.0;
        }
        number::real(text).unwrap_or_else(|| self.odd(index, "a number"))
    }

    /// Returns an id, which must be larger than zero.
    pub(super) fn id(&mut self, index: usize) -> u64 {
        let id = self.integer(index);
        if id < 1 && self.whole {
            self.wrong(index, "an id above 0");
        }
        u64::try_from(id).unwrap_or(0)
    }

    /// Reads the nodes of a solid from field `first` on: four ids, and further ones that may be 0.
    fn corners(&mut self, first: usize, n: &mut [u64]) {
        for (c, node) in n.iter_mut().enumerate() {
            *node = if c < 4 { self.id(first + c) } else { self.integer(first + c).max(0) as u64 };
        }
    }

    /// Reads a parameter, or reports a field that cannot be read.
    fn odd(&mut self, index: usize, wanted: &str) -> f64 {
        let text = String::from_utf8_lossy(self.text(index)).into_owned();
        let value = reference(&text).and_then(|(minus, name)| {
            let value = match self.cards.parameters.get(name)? {
                Parameter::Integer(i) => *i as f64,
                Parameter::Real(x) => *x,
                Parameter::Text(_) => return None,
            };
            Some(if minus { -value } else { value })
        });
        value.filter(|x| wanted == "a number" || x.fract() == 0.0).unwrap_or_else(|| {
            self.wrong(index, wanted);
            0.0
        })
    }

    fn wrong(&mut self, index: usize, wanted: &str) {
        let (from, to) = self.fields.span(index);
        let text = String::from_utf8_lossy(self.text(index)).into_owned();
        let given = match (text.as_str(), reference(&text)) {
            ("", _) => "blank".into(),
            (_, Some((_, name))) if self.cards.parameters.get(name).is_none() => {
                format!("`{text}`: there is no parameter `{name}` yet")
            }
            _ => format!("`{text}`"),
        };
        let name = self.card.fields.get(index).map_or("", |f| f.name.as_str());
        let message = format!("{}: `{name}` has to be {wanted}, not {given}", self.block.shown());
        let place = self.block.span(self.line, from, to);
        self.cards.trouble.error(place, message, layout(self.card, self.block.format));
        self.cards.trouble.unsure();
        self.whole = false;
    }
}

/// Reads an integer that consists of digits only.
fn plain_integer(text: &[u8]) -> Option<i64> {
    if text.len() > 17 {
        return None;
    }
    text.iter().try_fold(0i64, |n, b| b.is_ascii_digit().then(|| n * 10 + i64::from(b - b'0')))
}

impl Rows {
    /// Reads lines with a node each.
    pub fn nodes(
        &mut self,
        cards: &mut Cards<'_>,
        card: &Card,
        (block, lines): (&KeywordBlock, &[(u32, u32)]),
    ) {
        self.nodes.reserve(lines.len());
        self.node_lines.reserve(lines.len());
        for &line in lines.iter().filter(|l| l.0 < l.1) {
            let mut numbers = start(cards, card, block, line);
            let mut id = NodeId(numbers.id(0));
            let mut x = [numbers.real(1), numbers.real(2), numbers.real(3)];
            if let Some(submodel) = numbers.submodel() {
                (id, x) = (submodel.node(id), submodel.point(x));
            }
            let held = if numbers.fields.count() > 4 {
                (numbers.integer(4), numbers.integer(5))
            } else {
                (0, 0)
            };
            if !numbers.whole {
                continue;
            }
            if held != (0, 0) {
                if numbers.submodel().is_some_and(|s| s.map.turns()) {
                    let message = "*NODE: tc and rc in a file that *INCLUDE_TRANSFORM turns act \
                                   along the axes of the whole deck";
                    let help = "check these directions: only points and vectors turn with the file";
                    let place = block.span(line, 0, (line.1 - line.0) as usize);
                    numbers.cards.trouble.warn_once("submodel axes NODE", place, message, help);
                }
                let entry = self.held.entry(held).or_insert_with(|| {
                    (Vec::new(), block.span(line, 0, (line.1 - line.0) as usize))
                });
                entry.0.push(id);
            }
            self.nodes.push(MeshNode { id, x });
            self.node_lines.push((block.file, line.0, line.1));
        }
    }

    /// Reads `*ELEMENT_SHELL`.
    pub fn shells(
        &mut self,
        cards: &mut Cards<'_>,
        row: &KeywordRow,
        options: &[&str],
        block: &KeywordBlock,
    ) {
        let card = &row.cards[0].0;
        let lines: Vec<_> = block.lines.iter().copied().filter(|l| l.0 < l.1).collect();
        self.shells.reserve(lines.len());
        self.shell_lines.reserve(lines.len());
        let has_offset = options.contains(&"OFFSET");
        let has_thickness = ["THICKNESS", "BETA"].iter().any(|o| options.contains(o));
        let step = 1 + usize::from(has_thickness) + usize::from(has_offset);
        for pair in lines.chunks(step) {
            let line = pair[0];
            let mut numbers = start(cards, card, block, line);
            let (id, part) = (ElemId(numbers.id(0)), numbers.id(1));
            let mut n: [u64; 4] =
                std::array::from_fn(|c| if c < 3 { numbers.id(2 + c) } else { 0 });
            n[3] = u64::try_from(numbers.integer(5)).unwrap_or(0);
            let is_curved = numbers.fields.count() > 6 && (6..10).any(|c| numbers.integer(c) != 0);
            if !numbers.whole {
                continue;
            }
            let (id, part) = numbers.ids(id, part);
            if is_curved {
                self.curved.push((id, block.span(line, 0, (line.1 - line.0) as usize)));
            }
            let mut n = n.map(|n| numbers.node(n));
            let triangle = n[3] == NodeId(0) || n[3] == n[2];
            let (shape, corners) =
                if triangle { (Shape::Tri3, &mut n[..3]) } else { (Shape::Quad4, &mut n[..]) };
            if numbers.reflects() {
                corners[1..].reverse();
            }
            let Some(part) = narrow(part, &mut numbers) else { continue };
            let mut angle = 0.0;
            if let (Some(&second), true) = (pair.get(1), has_thickness) {
                let mut numbers = start(cards, &row.cards[1].0, block, second);
                let t = std::array::from_fn(|c| numbers.length(c));
                if options.contains(&"THICKNESS") && t.iter().any(|&t| t != 0.0) {
                    self.thickness.push((self.shells.len(), t));
                }
                // A reflection turns the normal.
                angle = numbers.real(4) * if numbers.reflects() { -1.0 } else { 1.0 };
            }
            if let (Some(&last), true) = (pair.get(step - 1), has_offset) {
                let mut numbers = start(cards, &row.cards[2].0, block, last);
                self.offsets.push((self.shells.len(), numbers.length(0)));
            }
            let mut shell = MeshElement::new(id, part, shape, corners);
            shell.own.angle = angle;
            self.shells.push(shell);
            self.shell_lines.push((block.file, line.0, line.1));
        }
    }

    /// Reads `*ELEMENT_SOLID`, on one line or on two: then the first line has no nodes, or zeros.
    pub fn solids(&mut self, cards: &mut Cards<'_>, row: &KeywordRow, block: &KeywordBlock) {
        let mut lines = block.lines.iter().copied().filter(|l| l.0 < l.1);
        while let Some(line) = lines.next() {
            let mut numbers = start(cards, &row.cards[0].0, block, line);
            let (id, part) = (ElemId(numbers.id(0)), numbers.id(1));
            let (id, part) = numbers.ids(id, part);
            let Some(part) = narrow(part, &mut numbers) else { continue };
            let mut whole = numbers.whole;
            let mut n = [0u64; 10];
            let is_zero = |c: usize| numbers.text(2 + c).iter().all(|b| *b == b'0');
            if !(0..8).all(is_zero) {
                numbers.corners(2, &mut n[..8]);
                whole = numbers.whole;
            } else if let Some(second) = lines.next() {
                let mut numbers = start(cards, &row.cards[1].0, block, second);
                numbers.corners(0, &mut n);
                whole &= numbers.whole;
            } else {
                let message = format!("*{} ends before the nodes of element {id}", block.name);
                cards.trouble.error(
                    block.span(line, 0, (line.1 - line.0) as usize),
                    message,
                    "give its nodes on this line or on the next line",
                );
                return;
            }
            if !whole {
                continue;
            }
            let submodel = cards.submodel.as_ref().map(|s| s.0);
            let node = |n: u64| match submodel {
                Some(submodel) => submodel.node(NodeId(n)),
                None => NodeId(n),
            };
            let found = match n[8..] {
                [0, 0] => {
                    for c in 4..8 {
                        n[c] = if n[c] == 0 { n[c - 1] } else { n[c] };
                    }
                    let n: [u64; 8] = std::array::from_fn(|c| n[c]);
                    solid_of_eight(&n.map(node))
                }
                _ => Some((Shape::Tet10, n.map(node).to_vec())),
            };
            let Some((shape, mut corners)) = found else {
                cards.trouble.error(
                    block.span(line, 0, (line.1 - line.0) as usize),
                    format!("solid {id} has repeated nodes and is no tetrahedron and no wedge"),
                    "mesh it with hexahedra, tetrahedra or wedges; pyramids are not supported",
                );
                continue;
            };
            if submodel.is_some_and(|s| s.map.reflects()) {
                reflect(shape, &mut corners);
            }
            self.solids.push(MeshElement::new(id, part, shape, &corners));
            self.solid_lines.push((block.file, line.0, line.1));
        }
    }

    /// Reads `*ELEMENT_TSHELL`: solids of eight nodes whose first four are one face.
    pub fn thick_shells(&mut self, cards: &mut Cards<'_>, row: &KeywordRow, block: &KeywordBlock) {
        for line in block.lines.iter().copied().filter(|l| l.0 < l.1) {
            let mut numbers = start(cards, &row.cards[0].0, block, line);
            let (id, part) = (ElemId(numbers.id(0)), numbers.id(1));
            let (id, part) = numbers.ids(id, part);
            let Some(part) = narrow(part, &mut numbers) else { continue };
            let mut n = [0u64; 8];
            numbers.corners(2, &mut n);
            if !numbers.whole {
                continue;
            }
            let reflects = numbers.reflects();
            let mut corners = n.map(|n| numbers.node(n)).to_vec();
            let different: BTreeSet<NodeId> = corners.iter().copied().collect();
            if different.len() < 8 {
                cards.trouble.error(
                    block.span(line, 0, (line.1 - line.0) as usize),
                    format!("thick shell {id} has repeated nodes: six-node ones are not supported"),
                    "mesh it with eight different nodes, or make it a wedge of *ELEMENT_SOLID",
                );
                continue;
            }
            if reflects {
                reflect(Shape::Hex8, &mut corners);
            }
            self.thick.push(self.solids.len());
            self.solids.push(MeshElement::new(id, part, Shape::Hex8, &corners));
            self.solid_lines.push((block.file, line.0, line.1));
        }
    }

    /// Raises the ids of thick shells if other solids have some of them, since both become solids
    /// of the job.
    fn number_thick_shells_apart(&mut self, mapping: &mut Vec<Mapping>) {
        if self.thick.is_empty() {
            return;
        }
        let thick: HashSet<usize> = self.thick.iter().copied().collect();
        let others = self.solids.iter().enumerate().filter(|(at, _)| !thick.contains(at));
        let taken: HashSet<ElemId> = others.map(|(_, e)| e.id).collect();
        if self.thick.iter().all(|&at| !taken.contains(&self.solids[at].id)) {
            return;
        }
        let most = self.solids.iter().map(|e| e.id.0).max().unwrap_or(0);
        let raise = (1..=15).map(|k| 10u64.pow(k)).find(|&raise| raise > most);
        let raise = raise.unwrap_or(10u64.pow(15));
        for &at in &self.thick {
            self.solids[at].id.0 = self.solids[at].id.0.saturating_add(raise);
        }
        mapping.push(Mapping {
            of: "thick shells".into(),
            asked: "ids that other solids have too".into(),
            used: format!("ids raised by {raise}"),
        });
    }

    /// Makes ids unique. A deck may use the same ids for solids, shells, springs and beams, a job
    /// may not. The ids of the later kinds are then raised.
    pub fn number_apart(&mut self, mapping: &mut Vec<Mapping>) {
        if self.solids.is_empty() && self.springs.is_empty() && self.beams.is_empty() {
            return;
        }
        self.number_thick_shells_apart(mapping);
        let mut seen: HashSet<ElemId> = self.shells.iter().map(|e| e.id).collect();
        let mut most = self.shells.iter().map(|e| e.id.0).max().unwrap_or(0);
        let lists = [
            ("solids", &mut self.solids),
            ("springs", &mut self.springs),
            ("beams", &mut self.beams),
        ];
        for ((kind, list), raised) in lists.into_iter().zip(&mut self.raised) {
            most = list.iter().map(|e| e.id.0).fold(most, u64::max);
            if list.iter().any(|e| seen.contains(&e.id)) {
                let mut raise = 10u64;
                while raise <= most && raise < 1_000_000_000_000_000 {
                    raise *= 10;
                }
                list.iter_mut().for_each(|e| e.id.0 = e.id.0.saturating_add(raise));
                most = most.saturating_add(raise);
                *raised = raise;
                mapping.push(Mapping {
                    of: kind.into(),
                    asked: "ids that other elements have too".into(),
                    used: format!("ids raised by {raise}"),
                });
            }
            seen.extend(list.iter().map(|e| e.id));
        }
    }

    /// Removes elements.
    pub fn remove(&mut self, is_gone: impl Fn(&MeshElement) -> bool) {
        let shells = new_indices(&self.shells, &is_gone);
        self.thickness.retain_mut(|entry| move_index(&shells, &mut entry.0));
        self.offsets.retain_mut(|entry| move_index(&shells, &mut entry.0));
        let solids = new_indices(&self.solids, &is_gone);
        self.thick.retain_mut(|index| move_index(&solids, index));
        let lists = [
            (&mut self.shells, &mut self.shell_lines),
            (&mut self.solids, &mut self.solid_lines),
            (&mut self.springs, &mut self.spring_lines),
            (&mut self.beams, &mut self.beam_lines),
            (&mut self.particles, &mut self.particle_lines),
        ];
        for (elements, lines) in lists {
            let mut gone = elements.iter().map(&is_gone).collect::<Vec<_>>().into_iter();
            lines.retain(|_| gone.next() == Some(false));
            self.removed.extend(elements.extract_if(.., |e| is_gone(e)));
        }
    }

    /// Returns the nodes that only removed elements have.
    pub fn lost_nodes(&self) -> HashSet<NodeId> {
        let mut lost: HashSet<NodeId> =
            self.removed.iter().flat_map(|e| e.corners()).copied().collect();
        if !lost.is_empty() {
            self.elements().flat_map(|e| e.corners()).for_each(|node| {
                lost.remove(node);
            });
        }
        lost
    }

    /// Removes nodes from all sets. Returns the names of the sets that have none left.
    pub fn remove_from_sets(&mut self, gone: &HashSet<NodeId>) -> BTreeSet<String> {
        let mut emptied = BTreeSet::new();
        for (name, (nodes, _)) in &mut self.sets {
            let before = nodes.len();
            nodes.retain(|node| !gone.contains(node));
            if before > 0 && nodes.is_empty() {
                emptied.insert(name.clone());
            }
        }
        emptied
    }

    /// Returns the ids of beams as the deck has them, and their parts.
    pub fn beams_of_deck(&self) -> Vec<(i64, u32)> {
        let written = |id: ElemId| id.0.saturating_sub(self.raised[2]) as i64;
        self.beams.iter().map(|e| (written(e.id), e.part)).collect()
    }

    /// Returns the id of a spring from that with which it was added.
    pub fn spring_id(&self, added: ElemId) -> ElemId {
        ElemId(added.0.saturating_add(self.raised[1]))
    }

    /// Adds a spring, which is written at `place`.
    pub fn spring(&mut self, id: ElemId, part: u32, ends: [NodeId; 2], place: Place) {
        let Place::Deck { file, start, end } = place else { return };
        self.springs.push(MeshElement::new(id, part, Shape::Line2, &ends));
        self.spring_lines.push((file, start, end));
    }

    /// Adds a shell, which is written at `place`.
    pub fn shell(&mut self, element: MeshElement, place: Place) {
        let Place::Deck { file, start, end } = place else { return };
        self.shells.push(element);
        self.shell_lines.push((file, start, end));
    }

    /// Adds a solid, which is written at `place`.
    pub fn solid(&mut self, element: MeshElement, place: Place) {
        let Place::Deck { file, start, end } = place else { return };
        self.solids.push(element);
        self.solid_lines.push((file, start, end));
    }

    /// Adds a beam, which is written at `place`. Its third corner defines the direction of its
    /// second axis.
    pub fn beam(&mut self, id: ElemId, part: u32, corners: [NodeId; 3], place: Place) {
        let Place::Deck { file, start, end } = place else { return };
        self.beams.push(MeshElement::new(id, part, Shape::Beam2, &corners));
        self.beam_lines.push((file, start, end));
    }

    /// Adds a particle, which is written at `place`.
    pub fn particle(&mut self, id: ElemId, part: u32, node: NodeId, place: Place) {
        let Place::Deck { file, start, end } = place else { return };
        self.particles.push(MeshElement::new(id, part, Shape::Point1, &[node]));
        self.particle_lines.push((file, start, end));
    }

    /// Returns the place of the `index`-th beam.
    pub fn beam_place(&self, index: usize) -> Place {
        self.beam_lines.get(index).map_or(Place::Whole, |&(file, start, end)| Place::Deck {
            file,
            start,
            end,
        })
    }

    /// Adds nodes that the deck does not have, to orient beams. Their places are those of the
    /// beams. Returns their ids.
    pub fn add_nodes(&mut self, at: &[([f64; 3], Place)]) -> Vec<NodeId> {
        at.iter().filter_map(|&(x, place)| self.add_node(x, place)).collect()
    }

    fn add_node(&mut self, x: [f64; 3], place: Place) -> Option<NodeId> {
        let Place::Deck { file, start, end } = place else { return None };
        if self.top == 0 {
            self.top = self.nodes.iter().map(|n| n.id.0).max().unwrap_or(0);
        }
        self.top = self.top.saturating_add(1);
        let id = NodeId(self.top);
        self.index.insert(id, self.nodes.len());
        self.nodes.push(MeshNode { id, x });
        self.node_lines.push((file, start, end));
        Some(id)
    }

    /// Adds a fixed node at the position of another one, for data written at `place`; `None` if
    /// there is no such node.
    pub fn ground(&mut self, at: NodeId, place: Place) -> Option<NodeId> {
        let x = self.at(at)?;
        let id = self.add_node(x, place)?;
        self.held.entry(HELD_IN_PLACE).or_insert_with(|| (Vec::new(), place)).0.push(id);
        Some(id)
    }

    /// Adds a node set. A name that another set has is noted in `same_names`.
    pub fn add_set(&mut self, name: String, nodes: Vec<NodeId>, place: Place) {
        match self.sets.get(&name) {
            Some(known) if !same_nodes(&known.0, &nodes) => self.same_names.push((name, place)),
            _ => drop(self.sets.insert(name, (nodes, place))),
        }
    }

    /// Adds a node set under the name that its author gave it, and returns this name; if a set with
    /// other nodes has it, that with a number.
    pub fn add_named_set(&mut self, name: &str, nodes: Vec<NodeId>, place: Place) -> String {
        match self.sets.get(name) {
            Some(known) if same_nodes(&known.0, &nodes) => name.to_string(),
            _ => self.add_new_set(name, nodes, place),
        }
    }

    /// Adds a node set under a name that no other set has: the given one, or that with a number.
    /// Returns the name.
    pub fn add_new_set(&mut self, name: &str, nodes: Vec<NodeId>, place: Place) -> String {
        let names = std::iter::once(name.to_string()).chain((2..).map(|n| format!("{name} {n}")));
        let own = names.into_iter().find(|own| !self.has_set(own)).unwrap_or_default();
        self.add_set(own.clone(), nodes, place);
        own
    }

    /// Returns the nodes of the set with this name.
    pub fn set(&self, name: &str) -> Option<&[NodeId]> {
        self.sets.get(name).map(|(nodes, _)| nodes.as_slice())
    }

    /// Returns true if there is a set of this name.
    pub fn has_set(&self, name: &str) -> bool {
        self.sets.contains_key(name)
    }

    /// Returns shells, then solids, then springs, then beams, then particles.
    pub fn elements(&self) -> impl Iterator<Item = &MeshElement> {
        let solid = self.shells.iter().chain(&self.solids);
        solid.chain(&self.springs).chain(&self.beams).chain(&self.particles)
    }

    /// Returns the nodes of all elements of the parts that `of` accepts, ascending.
    pub fn nodes_of(&self, of: impl Fn(u32) -> bool) -> Vec<NodeId> {
        let mut nodes: Vec<NodeId> =
            self.elements().filter(|e| of(e.part)).flat_map(|e| e.corners()).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the coordinates of a node [length].
    pub fn at(&mut self, id: NodeId) -> Option<[f64; 3]> {
        if self.index.len() != self.nodes.len() {
            self.index = self.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect();
        }
        self.index.get(&id).map(|&i| self.nodes[i].x)
    }

    /// Moves nodes to new coordinates.
    pub fn move_nodes(
        &mut self,
        nodes: &BTreeSet<NodeId>,
        place: impl Fn(NodeId, [f64; 3]) -> [f64; 3],
    ) {
        for node in self.nodes.iter_mut().filter(|node| nodes.contains(&node.id)) {
            node.x = place(node.id, node.x);
        }
    }

    /// Returns the number of elements of each kind, in the order of [`Rows::finish`].
    pub fn lists(&self) -> ListLengths {
        vec![
            ("shells", self.shells.len()),
            ("solids", self.solids.len()),
            ("springs", self.springs.len()),
            ("beams", self.beams.len()),
            ("particles", self.particles.len()),
        ]
    }

    /// Returns the mesh and the places of its data.
    pub fn finish(self) -> (Mesh, Places) {
        let mut elements = self.shells;
        elements.extend(self.solids);
        elements.extend(self.springs);
        elements.extend(self.beams);
        elements.extend(self.particles);
        let places = Places {
            nodes: self.node_lines,
            shells: self.shell_lines,
            solids: self.solid_lines,
            springs: self.spring_lines,
            beams: self.beam_lines,
            particles: self.particle_lines,
            sets: self.sets.iter().map(|(name, (_, place))| (name.clone(), *place)).collect(),
        };
        let node_sets = self.sets.into_iter().map(|(name, (nodes, _))| (name, nodes)).collect();
        let mut initial = self.initial;
        if !self.removed.is_empty() && !initial.is_empty() {
            let there: HashSet<ElemId> = elements.iter().map(|e| e.id).collect();
            initial.retain(|point| there.contains(&point.element));
        }
        (Mesh { nodes: self.nodes, elements, node_sets, initial }, places)
    }
}

/// Returns true if two sets have the same nodes.
fn same_nodes(a: &[NodeId], b: &[NodeId]) -> bool {
    let of = |nodes: &[NodeId]| nodes.iter().copied().collect::<BTreeSet<NodeId>>();
    a == b || of(a) == of(b)
}

/// Returns the index of each element after some are removed; `None` for these.
fn new_indices(
    elements: &[MeshElement],
    is_gone: impl Fn(&MeshElement) -> bool,
) -> Vec<Option<usize>> {
    let mut next = 0..;
    elements.iter().map(|e| if is_gone(e) { None } else { next.next() }).collect()
}

/// Replaces an index by the new one; returns false if its element is removed.
fn move_index(new: &[Option<usize>], index: &mut usize) -> bool {
    let moved = new.get(*index).copied().flatten();
    *index = moved.unwrap_or(*index);
    moved.is_some()
}

/// Returns a line of a block, split into the fields of a card.
pub(super) fn start<'a, 'c>(
    cards: &'a mut Cards<'c>,
    card: &'a Card,
    block: &'a KeywordBlock,
    line: (u32, u32),
) -> MeshLine<'a, 'c> {
    let fields = split(cards.texts.line(block, line), card, block.format);
    MeshLine { cards, block, card, line, fields, whole: true }
}

/// Orders the corners of a solid whose nodes are reflected so that its volume is above 0.
fn reflect(shape: Shape, corners: &mut [NodeId]) {
    let pairs: &[(usize, usize)] = match shape {
        Shape::Hex8 => &[(1, 3), (5, 7)],
        Shape::Wedge6 => &[(1, 2), (4, 5)],
        // Nodes on edges go with their corners.
        Shape::Tet10 => &[(1, 2), (4, 6), (8, 9)],
        _ => &[(1, 2)],
    };
    pairs.iter().for_each(|&(a, b)| corners.swap(a, b));
}

/// Returns the id of a part, which has 32 bits.
fn narrow(part: u64, numbers: &mut MeshLine<'_, '_>) -> Option<u32> {
    let narrow = u32::try_from(part).ok();
    if narrow.is_none() {
        numbers.wrong(1, "a part id of at most 4294967295");
    }
    narrow.filter(|_| numbers.whole)
}

/// Names of the lists of elements in a job's `[mesh]`, with their lengths.
pub type ListLengths = Vec<(&'static str, usize)>;

/// Places of the mesh data.
#[derive(Debug, Default)]
pub struct Places {
    nodes: Vec<LineSpan>,
    shells: Vec<LineSpan>,
    solids: Vec<LineSpan>,
    springs: Vec<LineSpan>,
    beams: Vec<LineSpan>,
    particles: Vec<LineSpan>,
    sets: BTreeMap<String, Place>,
}

impl Places {
    /// Returns the line for a path such as `mesh.shells.17`.
    pub fn place_of(&self, path: &str) -> Option<Place> {
        let rest = path.strip_prefix("mesh.")?;
        let (list, rest) = rest.split_once('.')?;
        let lines = match list {
            "nodes" => &self.nodes,
            "shells" => &self.shells,
            "solids" => &self.solids,
            "springs" => &self.springs,
            "beams" => &self.beams,
            "particles" => &self.particles,
            "node_sets" => return self.sets.get(rest).copied(),
            _ => return None,
        };
        let index = rest.split('.').next()?.parse::<usize>().ok()?;
        lines.get(index).map(|&(file, start, end)| Place::Deck { file, start, end })
    }
}
