//! Nodes of Nastran and their coordinate systems.
//!
//! The position of a node is that in the system of its field CP, or that of `GRDSET`; the mesh has
//! it in the basic system. The system of its displacements, CD, is that of the directions of bars
//! at the node, and of the components of its supports.

use super::BulkReader;
use super::cards::{BulkCard, FieldFault};
use crate::input::mesh_file::content::{FileNode, FilePlace};
use crate::input::mesh_file::reading::{Fate, MeshReading};
use crate::input::mesh_file::systems::{CoordinateKind, NodeSystem};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Cards of systems, and the kinds of their coordinates.
const SYSTEMS: &[(&str, CoordinateKind)] = &[
    ("CORD1R", CoordinateKind::Rectangular),
    ("CORD1C", CoordinateKind::Cylindrical),
    ("CORD1S", CoordinateKind::Spherical),
    ("CORD2R", CoordinateKind::Rectangular),
    ("CORD2C", CoordinateKind::Cylindrical),
    ("CORD2S", CoordinateKind::Spherical),
];

/// Cure for a system that is missing.
const MISSING_HELP: &str = "add its card, CORD2R, CORD2C, CORD2S, CORD1R, CORD1C or CORD1S, or \
                            export the nodes in the basic coordinate system, with a blank field";

/// Returns true for cards that place nodes.
pub fn places_nodes(name: &str) -> bool {
    name == "GRID" || name == "GRDSET" || kind_of(name).is_some()
}

/// Returns the kind of the coordinates of a card of a system.
fn kind_of(name: &str) -> Option<CoordinateKind> {
    SYSTEMS.iter().find(|row| row.0 == name).map(|row| row.1)
}

/// A node as its card gives it.
#[derive(Clone, Copy)]
struct BulkGrid {
    id: u64,
    /// System of its coordinates.
    system: u64,
    coordinates: [f64; 3],
    place: FilePlace,
}

/// A coordinate system as its card gives it.
struct SystemCard {
    card: String,
    kind: CoordinateKind,
    given: SystemPoints,
    place: FilePlace,
}

/// The three points of a system: its origin, one on the z axis and one in the plane of x and z.
enum SystemPoints {
    /// Their coordinates in another system.
    In(u64, [[f64; 3]; 3]),
    /// The nodes at them.
    Nodes([u64; 3]),
}

/// The coordinate systems of a file.
#[derive(Default)]
pub struct SystemTable {
    cards: BTreeMap<u64, SystemCard>,
    /// Nodes that give systems.
    grids: HashMap<u64, BulkGrid>,
    /// Systems that were asked for; `None` after an error.
    solved: HashMap<u64, Option<NodeSystem>>,
    /// Systems of displacements of the nodes that have one.
    displaced: HashMap<u64, u64>,
    /// The `GRDSET` that counts, if it gives a system.
    default: Option<FilePlace>,
}

impl SystemTable {
    /// Returns the number of nodes among these whose displacements have a system of their own.
    pub fn count_displaced(&self, nodes: &[u64]) -> usize {
        nodes.iter().filter(|node| self.displaced.contains_key(node)).count()
    }

    /// Returns the system of the displacements of a node.
    pub fn of_displacements(&self, node: u64) -> u64 {
        self.displaced.get(&node).copied().unwrap_or(0)
    }

    /// Returns true if there is a system with this id.
    pub fn has(&self, id: u64) -> bool {
        id == 0 || self.cards.contains_key(&id)
    }

    /// Returns a system; `None` if there is none, or after an error, which is reported once.
    pub fn system(&mut self, id: u64, reading: &mut MeshReading) -> Option<NodeSystem> {
        if id == 0 {
            return Some(NodeSystem::basic());
        }
        if let Some(known) = self.solved.get(&id) {
            return *known;
        }
        // Systems that wait for others: the last one needs none of those before it.
        let (mut path, mut is_open) = (vec![id], HashSet::from([id]));
        while let Some(&last) = path.last() {
            let is_done = |id: &u64| *id == 0 || self.solved.contains_key(id);
            let Some(card) = self.cards.get(&last).filter(|_| !is_done(&last)) else {
                path.pop();
                is_open.remove(&last);
                continue;
            };
            let Some(needs) = card.needs(last, &self.grids, reading) else {
                self.solved.insert(last, None);
                continue;
            };
            match needs.into_iter().find(|need| !is_done(need)) {
                None => {
                    let solved = self.solve(last, reading);
                    self.solved.insert(last, solved);
                }
                Some(need) if is_open.contains(&need) => {
                    let from = path.iter().position(|id| *id == need).unwrap_or(0);
                    let shown = path[from..].iter().map(u64::to_string).collect::<Vec<_>>();
                    let message = format!(
                        "{}: system {last} is given by system {need}, and that by this one: {} \
                         {need}",
                        card.card,
                        shown.join(" "),
                    );
                    let help = "give one of them in the basic system, with 0 for the system of its \
                                points";
                    reading.error("system", card.place, message, help);
                    self.solved.extend(path[from..].iter().map(|id| (*id, None)));
                }
                Some(need) if !self.cards.contains_key(&need) => {
                    let message = format!(
                        "{}: system {last} is given by system {need}, which is missing",
                        card.card
                    );
                    reading.error("system", card.place, message, MISSING_HELP);
                    self.solved.insert(last, None);
                }
                Some(need) => {
                    path.push(need);
                    is_open.insert(need);
                }
            }
        }
        self.solved.get(&id).copied().flatten()
    }

    /// Returns a system whose needs are solved. Reports points on a line.
    fn solve(&self, id: u64, reading: &mut MeshReading) -> Option<NodeSystem> {
        let card = self.cards.get(&id)?;
        let of = |system: u64| match system {
            0 => Some(NodeSystem::basic()),
            id => self.solved.get(&id).copied().flatten(),
        };
        let points = match card.given {
            SystemPoints::In(system, points) => {
                let system = of(system)?;
                points.map(|point| system.point(point))
            }
            SystemPoints::Nodes(nodes) => {
                let mut points = [[0.0; 3]; 3];
                for (point, node) in points.iter_mut().zip(nodes) {
                    let grid = self.grids.get(&node)?;
                    *point = of(grid.system)?.point(grid.coordinates);
                }
                points
            }
        };
        let found = NodeSystem::with_z(card.kind, points);
        if found.is_none() {
            let message = format!("{}: the three points of system {id} are on a line", card.card);
            let help = "give its origin, a point on its z axis, and one in its plane of x and z \
                        that is not on the z axis";
            reading.error("system", card.place, message, help);
        }
        found
    }
}

impl SystemCard {
    /// Returns the systems of its points. Reports a node that is missing and returns `None`.
    fn needs(
        &self,
        id: u64,
        grids: &HashMap<u64, BulkGrid>,
        reading: &mut MeshReading,
    ) -> Option<Vec<u64>> {
        let nodes = match &self.given {
            SystemPoints::In(system, _) => return Some(vec![*system]),
            SystemPoints::Nodes(nodes) => nodes,
        };
        let mut systems = Vec::new();
        for node in nodes {
            let Some(grid) = grids.get(node) else {
                let message =
                    format!("{}: system {id} has node {node}, which is missing", self.card);
                let help = "define the node, or correct the card";
                reading.error("system", self.place, message, help);
                return None;
            };
            systems.push(grid.system);
        }
        Some(systems)
    }
}

impl BulkReader<'_> {
    /// Reads all nodes, in the basic system, and the systems that they need.
    pub fn nodes(&mut self, cards: &[BulkCard]) {
        for card in cards.iter().filter(|card| kind_of(&card.name).is_some()) {
            self.reported(card, Self::coordinate_system);
        }
        let default = cards.iter().find(|card| card.name == "GRDSET");
        let mut systems = [0; 2];
        if let Some(card) = default {
            self.reported(card, |_, card| {
                systems = [card.id(1)?.unwrap_or(0), displacements(card).unwrap_or(0)];
                Ok(())
            });
        }
        let mut grids = Vec::new();
        for card in cards.iter().filter(|card| card.name == "GRID") {
            self.reported(card, |reader, card| {
                grids.extend(reader.grid(card, systems)?);
                Ok(())
            });
        }
        let of_systems: HashSet<u64> = self.systems.cards.values().flat_map(given_nodes).collect();
        let wanted = grids.iter().filter(|grid| of_systems.contains(&grid.id));
        self.systems.grids = wanted.map(|grid| (grid.id, *grid)).collect();
        for grid in grids {
            self.place(grid);
        }
        self.systems.default = default.map(|card| card.place).filter(|_| systems != [0; 2]);
    }

    /// Reads a node.
    fn grid(
        &mut self,
        card: &BulkCard,
        [of_position, of_displacements]: [u64; 2],
    ) -> Result<Option<BulkGrid>, FieldFault> {
        let Some(id) = card.id(0)? else {
            self.error("id", card, "the node has no id".into(), "write GRID, id, , x, y, z");
            return Ok(None);
        };
        let system = card.id(1)?.unwrap_or(of_position);
        let mut coordinates = [0.0; 3];
        for (axis, x) in coordinates.iter_mut().enumerate() {
            *x = card.real(axis + 2)?.unwrap_or(0.0);
        }
        let displaced = displacements(card).unwrap_or(of_displacements);
        if displaced > 0 {
            self.systems.displaced.insert(id, displaced);
        }
        Ok(Some(BulkGrid { id, system, coordinates, place: card.place }))
    }

    /// Adds a node to the mesh. Reports that its system is missing.
    fn place(&mut self, grid: BulkGrid) {
        let BulkGrid { id, system, coordinates, place } = grid;
        if !self.systems.has(system) {
            let message =
                format!("GRID: node {id} is in coordinate system {system}, which is missing");
            self.reading.error("system", place, message, MISSING_HELP);
        }
        let of_node = self.systems.system(system, self.reading);
        // A node whose system has an error is kept, so that no others follow.
        let x = of_node.unwrap_or(NodeSystem::basic()).point(coordinates);
        self.at.insert(id, x);
        self.reading.mesh.nodes.push(FileNode { id, x, place });
    }

    /// Reads a coordinate system, or two on one card of systems at nodes.
    fn coordinate_system(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let Some(kind) = kind_of(&card.name) else { return Ok(()) };
        if card.name.starts_with("CORD2") {
            let mut points = [[0.0; 3]; 3];
            for (index, value) in points.iter_mut().flatten().enumerate() {
                *value = card.real(2 + index)?.unwrap_or(0.0);
            }
            let given = SystemPoints::In(card.id(1)?.unwrap_or(0), points);
            return self.add_system(card, 0, (kind, given));
        }
        for first in [0, 4].into_iter().filter(|&first| first == 0 || !card.text(first).is_empty())
        {
            let mut nodes = [0; 3];
            for (index, node) in nodes.iter_mut().enumerate() {
                *node = card.id(first + 1 + index)?.unwrap_or(0);
            }
            self.add_system(card, first, (kind, SystemPoints::Nodes(nodes)))?;
        }
        Ok(())
    }

    /// Adds a system whose id is in the field with this index.
    fn add_system(
        &mut self,
        card: &BulkCard,
        index: usize,
        (kind, given): (CoordinateKind, SystemPoints),
    ) -> Result<(), FieldFault> {
        let Some(id) = card.id(index)?.filter(|&id| id > 0) else {
            let help = "write the id, a whole number above 0";
            self.error("id", card, "the coordinate system has no id".into(), help);
            return Ok(());
        };
        let added = SystemCard { card: card.name.clone(), kind, given, place: card.place };
        if let Some(before) = self.systems.cards.insert(id, added) {
            let before = self.reading.at(before.place);
            let message = format!("coordinate system {id} is defined twice, first at {before}");
            self.error("system twice", card, message, "give each system its own id");
        }
        Ok(())
    }

    /// Adds rows for the systems and for `GRDSET`, after all nodes and elements.
    pub fn rows_of_systems(&mut self, cards: &[BulkCard]) {
        let SystemTable { cards: systems, solved, default, .. } = &self.systems;
        for (id, system) in systems {
            let (fate, became) = match solved.contains_key(id) {
                true => (Fate::Read, "coordinates and directions, in the basic system now"),
                false => (Fate::Ignored, "no node has coordinates in it, and no bar a direction"),
            };
            self.reading.row(fate, system.card.as_str(), 1, became);
        }
        for card in cards.iter().filter(|card| card.name == "GRDSET") {
            let (fate, became) = match *default == Some(card.place) {
                true => (Fate::Read, "the systems of the nodes that name none"),
                false => (Fate::Ignored, "it gives no system of coordinates"),
            };
            self.reading.row(fate, "GRDSET", 1, became);
        }
    }

    /// Returns a vector at a node, whose components are those of its displacements, in the basic
    /// system. Reports that the system is missing.
    pub fn in_basic_system(
        &mut self,
        card: &BulkCard,
        node: u64,
        components: [f64; 3],
    ) -> [f64; 3] {
        let id = self.systems.of_displacements(node);
        if !self.systems.has(id) {
            let message = format!(
                "the direction is in the system {id} of the displacements of node {node}, which \
                 is missing"
            );
            self.error("system", card, message, MISSING_HELP);
        }
        let system = self.systems.system(id, self.reading).unwrap_or(NodeSystem::basic());
        let at = self.at.get(&node).copied().unwrap_or_default();
        system.direction(at, components)
    }
}

/// Returns the system of the displacements of a node or of `GRDSET`; `None` if the field is blank
/// or no id of a system: a fluid has -1.
fn displacements(card: &BulkCard) -> Option<u64> {
    card.text(5).parse().ok()
}

/// Returns the nodes that give a system.
fn given_nodes(card: &SystemCard) -> Vec<u64> {
    match card.given {
        SystemPoints::In(..) => Vec::new(),
        SystemPoints::Nodes(nodes) => nodes.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use crate::input::mesh_file::nastran::read;
    use crate::input::mesh_file::testing::{errors_of, mesh_of};
    use std::fmt::Write as _;

    /// System 1 has its origin at (1, 0, 0), z along Y of the mesh, x along Z, so y along X.
    const FIRST: &str = "CORD2R,1,0,1.,0.,0.,1.,5.,0.\n+,1.,7.,2.\n";
    /// System 2 in system 1: its origin is at 1 on the z axis there, which is (1, 1, 0). Its z is
    /// along z there, which is Y; its x along y there, which is X; so its y is along -Z.
    const SECOND: &str = "CORD2C,2,1,0.,0.,1.,0.,0.,2.\n+,0.,1.,1.\n";
    /// System 3 in the cylindrical system 2, with the same origin: its z is at 90 degrees there,
    /// which is -Z, its x at 0 degrees, which is X; so its y is along -Y.
    const THIRD: &str = "CORD2S,3,2,0.,0.,0.,1.,90.,0.\n+,1.,0.,0.\n";
    /// Nodes with the origin (0, 0, 1), z along Z and x along Y, so y along -X.
    const NODES: &str = "GRID,11,0,0.,0.,1.\nGRID,12,0,0.,0.,2.\nGRID,13,0,0.,1.,1.\n";

    /// Returns a triangle whose first node has these fields after its id.
    fn triangle(cards: &str, node: &str) -> String {
        format!(
            "{cards}GRID,1,{node}\nGRID,98,0,50.,0.,0.\nGRID,99,0,0.,50.,0.\n\
             CTRIA3,1,1,1,98,99\n"
        )
    }

    /// Returns the coordinates of the node with these fields [length].
    fn place(cards: &str, node: &str) -> [f64; 3] {
        let mesh = mesh_of(read, &triangle(cards, node));
        mesh.nodes.iter().find(|node| node.id == 1).expect("node 1").x
    }

    /// Systems are given in others, in any order of the cards. Right angles are exact.
    #[test]
    fn nodes_are_in_the_basic_system() {
        let all = format!("{THIRD}{SECOND}{FIRST}");
        assert_eq!(place(&all, ",2.,3.,4."), [2.0, 3.0, 4.0]);
        assert_eq!(place(&all, "1,2.,3.,4."), [4.0, 4.0, 2.0]);
        // 2 along y at 90 degrees, 3 along z.
        assert_eq!(place(&all, "2,2.,90.,3."), [1.0, 4.0, -2.0]);
        // 90 degrees from z, then 90 degrees about it: 2 along y.
        assert_eq!(place(&all, "3,2.,90.,90."), [1.0, -1.0, 0.0]);
    }

    /// A card has one or two systems at nodes. One of the nodes is in a system itself: (1, -1, 1)
    /// of system 1 is at (0, 1, 1), as node 13 in `NODES`.
    #[test]
    fn systems_are_given_by_nodes() {
        for (cards, node) in [
            ("CORD1R,4,11,12,13\n", "4,1.,2.,3."),
            ("CORD1C,5,11,12,13,6,11,12,13\n", "6,2.,90.,3."),
        ] {
            let wanted = if node.starts_with('4') { [-2.0, 1.0, 4.0] } else { [-2.0, 0.0, 4.0] };
            assert_eq!(place(&format!("{NODES}{cards}"), node), wanted, "{cards}");
            let other = NODES.replace("GRID,13,0,0.,1.,1.", "GRID,13,1,1.,-1.,1.");
            assert_eq!(place(&format!("{FIRST}{other}{cards}"), node), wanted, "{cards}");
        }
    }

    /// `GRDSET` is for nodes with a blank field; 0 is the basic system.
    #[test]
    fn a_default_system_is_for_blank_fields() {
        let cards = format!("{FIRST}GRDSET,,1\n");
        assert_eq!(place(&cards, ",2.,3.,4."), [4.0, 4.0, 2.0]);
        assert_eq!(place(&cards, "0,2.,3.,4."), [2.0, 3.0, 4.0]);
    }

    /// The vector of a bar is along the axes of the displacements of its first node, here radial at
    /// (3, 4, 0), unless OFFT begins with `B`.
    #[test]
    fn directions_of_bars_are_in_the_system_of_displacements() {
        let axis = |node: &str, offt: &str| {
            let text = format!(
                "CORD2C,7,,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\nGRID,1,,3.,4.,0.{node}\n\
                 GRID,2,,3.,4.,9.\nCBAR,1,1,1,2,5.,0.,0.{offt}\n"
            );
            mesh_of(read, &text).elements[0].axis.expect("a direction")
        };
        let radial = axis(",7", "");
        assert!((radial[0] - 3.0).abs() < 1e-14 && (radial[1] - 4.0).abs() < 1e-14, "{radial:?}");
        assert_eq!(axis(",7", ",BGG"), [5.0, 0.0, 0.0]);
        assert_eq!(axis("", ""), [5.0, 0.0, 0.0]);
        assert_eq!(axis(",-1", ""), [5.0, 0.0, 0.0]);
    }

    /// A long chain of systems is solved without recursion: each is 1 along x of the one before it.
    #[test]
    fn a_long_chain_of_systems_is_solved() {
        let mut cards = String::new();
        for id in (1..=30_000_u32).rev() {
            let _ = writeln!(cards, "CORD2R,{id},{},1.,0.,0.,1.,0.,1.\n+,2.,0.,0.", id - 1);
        }
        assert_eq!(place(&cards, "30000,0.,2.,0."), [30_000.0, 2.0, 0.0]);
    }

    /// Each fault is one error with its line, card and ids, however many systems and nodes depend
    /// on it. A system that no node has may be wrong.
    #[test]
    fn wrong_systems_are_errors_at_their_cards() {
        let second = SECOND.replace("CORD2C,2,1", "CORD2C,2,3");
        for (cards, wanted) in [
            (format!("{SECOND}{THIRD}"), ":1: CORD2C: system 2 is given by system 1, which is mi"),
            (
                format!("{THIRD}{second}"),
                ":3: CORD2C: system 2 is given by system 3, and that by this one: 3 2 3",
            ),
            (
                format!(
                    "{THIRD}{}",
                    SECOND.replace("2,1,0.,0.,1.,0.,0.,2.", "2,0,0.,0.,1.,0.,0.,1.")
                ),
                ":3: CORD2C: the three points of system 2 are on a line",
            ),
            ("CORD1R,3,11,12,13\n".into(), ":1: CORD1R: system 3 has node 11, which is missing"),
            (
                format!("CORD1R,3,11,12,13\n{}", NODES.replace("GRID,12,0", "GRID,12,3")),
                ":1: CORD1R: system 3 is given by system 3, and that by this one: 3 3",
            ),
            ("".into(), ":1: GRID: node 1 is in coordinate system 3, which is missing"),
            (
                format!("{THIRD}{SECOND}{FIRST}{THIRD}"),
                ":7: CORD2S: coordinate system 3 is defined twice, first at file:1",
            ),
        ] {
            let found = errors_of(read, &triangle(&cards, "3,1.,0.,0."));
            assert!(found.len() == 1 && found[0].contains(wanted), "`{wanted}`: {found:?}");
            let is_unused = !wanted.contains("twice");
            if is_unused {
                mesh_of(read, &triangle(&cards, ",1.,0.,0.").replace("GRID,12,3", "GRID,12,0"));
            }
        }
    }
}
