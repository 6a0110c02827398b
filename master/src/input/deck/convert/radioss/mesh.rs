//! Converts nodes and elements line by line.

use super::StarterConverter;
use crate::input::deck::Unsupported;
use crate::input::deck::convert::mesh::start;
use crate::input::deck::keywords::KeywordRow;
use crate::input::deck::record::Cards;
use crate::input::deck::table::{Card, FieldFate};
use crate::input::deck::text::{KeywordBlock, Texts};
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{MeshElement, Shape, solid_of_eight};
use std::collections::HashSet;

/// Keywords of nodes and elements, with the number of nodes of an element that a line has.
const KEYWORDS: [(&str, usize); 10] = [
    ("/NODE", 0),
    ("/SHELL", 4),
    ("/SH3N", 3),
    ("/BRICK", 8),
    ("/TETRA4", 4),
    ("/TETRA10", 10),
    ("/PENTA6", 6),
    ("/BEAM", 3),
    ("/TRUSS", 2),
    ("/SPRING", 2),
];

/// Largest number that is added to ids.
const LARGEST_RAISE: u64 = 1_000_000_000_000_000;

/// Returns true for keywords of nodes and elements.
pub fn is_mesh(name: &str) -> bool {
    KEYWORDS.iter().any(|k| k.0 == name)
}

/// A line of an element, and its card.
type ElementLine<'a> = ((u32, u32), &'a Card);

/// An element as written.
struct StarterElement {
    id: ElemId,
    part: u32,
    nodes: Vec<NodeId>,
    /// Thickness of a single shell, or 0 [length].
    thickness: f64,
    /// Vector towards the second axis of a beam, zero without.
    axis: [f64; 3],
    place: Place,
}

impl StarterConverter {
    /// Reads a block of nodes or elements.
    pub(super) fn mesh_block(&mut self, texts: &Texts, block: &KeywordBlock, row: &KeywordRow) {
        let (header, lines) = match block.lines.split_first() {
            Some((&header, lines)) => (header, lines),
            None => return,
        };
        let [(ids, _), (card, _), of_nodes @ ..] = &row.cards[..] else { return };
        let mut cards = Cards::of(texts, &self.parameters, &mut self.deck.trouble);
        let mut numbers = start(&mut cards, ids, block, header);
        let name = row.keyword.name;
        if name == "/NODE" {
            let unit = numbers.integer(0);
            self.deck.rows.nodes(&mut cards, card, (block, lines));
            return self.note_unit(unit, block.place());
        }
        let (part, unit) = (numbers.id(0), numbers.integer(1));
        let is_whole = numbers.whole;
        self.note_unit(unit, block.place());
        let Some(part) = u32::try_from(part).ok().filter(|_| is_whole) else {
            if is_whole {
                let message = format!("{}: the part id {part} is too large", block.name);
                let help = "give part ids of at most 4294967295";
                self.deck.trouble.error(block.place(), message, help);
            }
            return;
        };
        let count = KEYWORDS.iter().find(|k| k.0 == name).map_or(0, |k| k.1);
        let mut lines = lines.iter().copied().filter(|l| l.0 < l.1);
        while let Some(line) = lines.next() {
            let second = match of_nodes.first() {
                None => None,
                Some((card, _)) => match lines.next() {
                    Some(line) => Some((line, card)),
                    None => return self.lacks_nodes(block, line),
                },
            };
            let lines = ((line, card), second);
            if let Some(element) = self.element(texts, block, row, lines, (part, count)) {
                self.add_element(name, element);
            }
        }
    }

    /// Reports an element whose second line is missing.
    fn lacks_nodes(&mut self, block: &KeywordBlock, line: (u32, u32)) {
        let message = format!("{} ends before the nodes of its last element", block.name);
        let help = "give the id of an element on a line, and its ten nodes on the next line";
        let place = block.span(line, 0, (line.1 - line.0) as usize);
        self.deck.trouble.error(place, message, help);
    }

    /// Reads an element with `count` nodes: its line, and the one of its nodes if they have their
    /// own.
    fn element(
        &mut self,
        texts: &Texts,
        block: &KeywordBlock,
        row: &KeywordRow,
        ((line, card), second): (ElementLine<'_>, Option<ElementLine<'_>>),
        (part, count): (u32, usize),
    ) -> Option<StarterElement> {
        let mut cards = Cards::of(texts, &self.parameters, &mut self.deck.trouble);
        let mut numbers = start(&mut cards, card, block, line);
        let id = ElemId(numbers.id(0));
        let mut nodes = Vec::with_capacity(count);
        if let Some((line, card)) = second {
            let is_whole = numbers.whole;
            let mut numbers = start(&mut cards, card, block, line);
            nodes.extend((0..count).map(|field| NodeId(numbers.id(field))));
            let place = block.span(line, 0, (line.1 - line.0) as usize);
            let (thickness, axis) = (0.0, [0.0; 3]);
            return (is_whole && numbers.whole).then_some(StarterElement {
                id,
                part,
                nodes,
                thickness,
                axis,
                place,
            });
        }
        for field in 1..=count {
            let needed = card.fields.get(field).is_some_and(|f| f.needed);
            // The fourth node of a shell may be 0 for a triangle.
            let n = match needed && !(row.keyword.name == "/SHELL" && field == 4) {
                true => numbers.id(field),
                false => u64::try_from(numbers.integer(field)).unwrap_or(0),
            };
            nodes.push(NodeId(n));
        }
        let mut value = |field: &str| card.index(field).map_or(0.0, |at| numbers.real(at));
        let thickness = value("thick");
        let axis = ["vx", "vy", "vz"].map(&mut value);
        let refused: Vec<&str> = row
            .keyword
            .unused
            .iter()
            .filter(|u| u.fate == FieldFate::Refused && value(u.names) != 0.0)
            .map(|u| u.names)
            .collect();
        let is_whole = numbers.whole;
        let place = block.span(line, 0, (line.1 - line.0) as usize);
        for field in refused {
            let why = row.unused(field).map_or("", |u| u.why);
            let name = row.keyword.name;
            let message = format!("{name}: `{field}` of element {id} is not supported: {why}");
            let lost = format!("elements act as if `{field}` were blank");
            let what = format!("{name} {field}");
            self.deck.unsupported.push(Unsupported { place, message, what, lost });
        }
        is_whole.then_some(StarterElement { id, part, nodes, thickness, axis, place })
    }

    fn add_element(&mut self, name: &str, element: StarterElement) {
        let StarterElement { id, part, nodes, thickness, axis, place } = element;
        let rows = &mut self.deck.rows;
        match name {
            "/SHELL" | "/SH3N" => {
                let is_triangle = nodes.len() == 3 || nodes[3] == NodeId(0) || nodes[3] == nodes[2];
                let (shape, corners) = match is_triangle {
                    true => (Shape::Tri3, &nodes[..3]),
                    false => (Shape::Quad4, &nodes[..]),
                };
                if thickness > 0.0 {
                    rows.thickness.push((rows.shells.len(), [thickness; 4]));
                }
                rows.shell(MeshElement::new(id, part, shape, corners), place);
            }
            "/BRICK" => {
                let corners: [NodeId; 8] =
                    std::array::from_fn(|c| nodes.get(c).copied().unwrap_or(NodeId(0)));
                match solid_of_eight(&corners) {
                    Some((shape, corners)) => {
                        rows.solid(MeshElement::new(id, part, shape, &corners), place);
                    }
                    None => {
                        let message = format!(
                            "solid {id} has repeated nodes and is no tetrahedron and no wedge"
                        );
                        let help = "mesh it with hexahedra, tetrahedra or wedges; pyramids are \
                                    not supported";
                        self.deck.trouble.error(place, message, help);
                    }
                }
            }
            "/TETRA4" => rows.solid(MeshElement::new(id, part, Shape::Tet4, &nodes), place),
            "/TETRA10" => rows.solid(MeshElement::new(id, part, Shape::Tet10, &nodes), place),
            "/PENTA6" => rows.solid(MeshElement::new(id, part, Shape::Wedge6, &nodes), place),
            "/SPRING" => rows.spring(id, part, [nodes[0], nodes[1]], place),
            "/TRUSS" => {
                self.deck.truss_parts.insert(part);
                rows.beam(id, part, [nodes[0], nodes[1], NodeId(0)], place);
            }
            _ => {
                let ends = [nodes[0], nodes[1]];
                let third = if ends.contains(&nodes[2]) { NodeId(0) } else { nodes[2] };
                if third == NodeId(0) && axis != [0.0; 3] {
                    self.shown.push((rows.beams.len(), (ends[0], axis), place));
                }
                rows.beam(id, part, [ends[0], ends[1], third], place);
            }
        }
    }

    /// Raises the ids of triangles and trusses that quads and beams have too: ids are unique for
    /// each keyword only, and these share a list.
    pub(super) fn kinds_apart(&mut self) {
        let trusses = self.deck.truss_parts.clone();
        let rows = &mut self.deck.rows;
        let is_triangle = |e: &MeshElement| e.shape == Shape::Tri3;
        let is_truss = |e: &MeshElement| trusses.contains(&e.part);
        self.raised = [raise(&mut rows.shells, is_triangle), raise(&mut rows.beams, is_truss)];
        for (kind, raised) in ["triangles", "trusses"].into_iter().zip(self.raised) {
            if raised > 0 {
                let used = format!("ids raised by {raised}");
                self.deck.map(kind, "ids that other elements have too", used);
            }
        }
    }

    /// Adds third nodes to beams whose second axis a vector shows.
    pub(super) fn show_axes(&mut self) {
        let mut points = Vec::new();
        for (index, (node, axis), place) in std::mem::take(&mut self.shown) {
            if let Some(from) = self.deck.rows.at(node) {
                points.push((index, ([0, 1, 2].map(|c| from[c] + axis[c]), place)));
            }
        }
        self.deck.show(&points);
    }

    /// Exchanges two nodes of tetrahedra with a negative volume, as Radioss does.
    pub(super) fn turn_tetrahedra(&mut self) {
        for index in 0..self.deck.rows.solids.len() {
            let solid = self.deck.rows.solids[index];
            // Nodes between corners go with them.
            let pairs: &[(usize, usize)] = match solid.shape {
                Shape::Tet4 => &[(1, 2)],
                Shape::Tet10 => &[(1, 2), (4, 6), (8, 9)],
                _ => continue,
            };
            let mut corners = [[0.0; 3]; 4];
            let found = solid.nodes[..4].iter().zip(&mut corners).all(|(&n, x)| {
                self.deck.rows.at(n).is_some_and(|at| {
                    *x = at;
                    true
                })
            });
            if found && volume(&corners) < 0.0 {
                let nodes = &mut self.deck.rows.solids[index].nodes;
                pairs.iter().for_each(|&(a, b)| nodes.swap(a, b));
                self.turned += 1;
            }
        }
        if self.turned > 0 {
            let asked = format!("{} of them have a negative volume", self.turned);
            self.deck.map("tetrahedra", asked, "two of their nodes are exchanged");
        }
    }
}

/// Raises the ids of some elements of a list above all others, if an element that is not one of
/// them has the same id. Returns the number that is added.
fn raise(list: &mut [MeshElement], is_one: impl Fn(&MeshElement) -> bool) -> u64 {
    let others: HashSet<ElemId> = list.iter().filter(|e| !is_one(e)).map(|e| e.id).collect();
    if !list.iter().any(|e| is_one(e) && others.contains(&e.id)) {
        return 0;
    }
    let most = list.iter().map(|e| e.id.0).max().unwrap_or(0);
    let mut raised = 10u64;
    while raised <= most && raised < LARGEST_RAISE {
        raised *= 10;
    }
    for element in list.iter_mut().filter(|e| is_one(e)) {
        element.id.0 = element.id.0.saturating_add(raised);
    }
    raised
}

/// Returns six times the volume of a tetrahedron [length^3].
fn volume(x: &[[f64; 3]; 4]) -> f64 {
    let edge = |n: usize| [0, 1, 2].map(|c| x[n][c] - x[0][c]);
    let (a, b, c) = (edge(1), edge(2), edge(3));
    let across = crate::input::deck::convert::space::cross(a, b);
    (0..3).map(|k| across[k] * c[k]).sum()
}
