//! Renumbers nodes and elements of a mesh whose neighbours have distant numbers.
//!
//! Columns of nodes and elements are in the order of ascending ids. If the nodes of consecutive
//! elements are scattered over the mesh, each corner is fetched from main memory. Such a mesh is
//! renumbered, and its own numbers become labels ([`crumple_proto::ids`]). A well numbered mesh
//! is unchanged to the last bit.
//!
//! Nodes are numbered part by part in levels around a node at an end of the part (Cuthill &
//! McKee, Reducing the bandwidth of sparse symmetric matrices, 1969; the end as in Gibbs, Poole &
//! Stockmeyer, SIAM J. Numer. Anal. 13, 1976). For a structured mesh this gives rows of elements.
//! Elements follow their first node.

use super::validate::JobProblems;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::initial;
use crumple_proto::mesh::{Mesh, MeshNode};
use crumple_proto::problem::Problem;
use std::collections::HashMap;

/// Number of consecutive nodes in a cache line.
const LINE: usize = 8;
/// Cache lines of each nodal column that a core keeps in addition to other data: 2048 nodes.
/// Elements read nine numbers of a node (coordinates, velocities and spins), together 0.15 MB.
const LINES: u32 = 256;
/// Largest number of lines fetched per element for a well numbered mesh. Rows fetch 0.1 to 0.3, a
/// shuffled mesh 4.
const IN_ORDER: f64 = 0.75;
/// Largest ratio of lines fetched after and before for which a mesh is renumbered.
const WORTH: f64 = 0.6;

/// Effect of renumbering: lines of nodes that an element fetches from main memory in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Renumbered {
    /// In the order of the user's ids.
    pub before: f64,
    /// In the new order.
    pub after: f64,
}

/// Renumbers a mesh if this brings the nodes of its elements closer together. `mesh` and `axes`
/// are sorted by id, before and after. Warns if the ids are too large for new numbers.
pub fn renumber(
    mesh: &mut Mesh,
    axes: &mut [(ElemId, [f64; 3])],
    findings: &mut JobProblems,
) -> Option<Renumbered> {
    let corners = corners(mesh);
    let mut order: Vec<u32> = (0..mesh.elements.len() as u32).collect();
    order.sort_by_key(|&e| mesh.elements[e as usize].part);
    let mut place: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    let before = fetched(&order, &corners, &place);
    if before <= IN_ORDER {
        return None;
    }
    levels(mesh, &corners).iter().zip(0..).for_each(|(&n, at)| place[n as usize] = at);
    order.sort_by_cached_key(|&e| {
        let first = corners.list(e).iter().map(|&n| place[n as usize]).min();
        (mesh.elements[e as usize].part, first)
    });
    let after = fetched(&order, &corners, &place);
    if after > WORTH * before {
        return None;
    }
    let Some((nodes, elements)) = placed(mesh, &place, &order) else {
        let message = format!(
            "node numbers of an element are far apart ({before:.1} cache lines fetched per element)"
        );
        let help = "use ids up to 4294967295, for which Crumple renumbers such a mesh internally; \
                    otherwise the run only takes longer";
        findings.add(Problem::warning("mesh", message, help));
        return None;
    };
    rename(mesh, axes, &nodes, &elements);
    Some(Renumbered { before, after })
}

/// Returns new ids by old ones; `None` if an id is too large.
fn placed(
    mesh: &Mesh,
    place: &[u32],
    order: &[u32],
) -> Option<(HashMap<NodeId, NodeId>, HashMap<ElemId, ElemId>)> {
    let node = |(node, &at): (&MeshNode, &u32)| {
        Some((node.id, NodeId::placed(u64::from(at), node.id.label())?))
    };
    let element = |(&e, at): (&u32, u64)| {
        let id = mesh.elements[e as usize].id;
        Some((id, ElemId::placed(at, id.label())?))
    };
    let nodes = mesh.nodes.iter().zip(place).map(node).collect::<Option<_>>()?;
    Some((nodes, order.iter().zip(0..).map(element).collect::<Option<_>>()?))
}

fn rename(
    mesh: &mut Mesh,
    axes: &mut [(ElemId, [f64; 3])],
    nodes: &HashMap<NodeId, NodeId>,
    elements: &HashMap<ElemId, ElemId>,
) {
    // A set may name nodes without elements.
    let node = |id: &mut NodeId| *id = nodes.get(id).copied().unwrap_or(*id);
    mesh.nodes.iter_mut().for_each(|n| node(&mut n.id));
    mesh.nodes.sort_unstable_by_key(|n| n.id);
    for e in &mut mesh.elements {
        e.id = elements[&e.id];
        e.nodes.iter_mut().for_each(node);
    }
    mesh.elements.sort_unstable_by_key(|e| e.id);
    axes.iter_mut().for_each(|axis| axis.0 = elements[&axis.0]);
    axes.sort_unstable_by_key(|axis| axis.0);
    mesh.initial.retain_mut(|point| {
        let element = elements.get(&point.element);
        point.element = element.copied().unwrap_or(point.element);
        element.is_some()
    });
    initial::sort(&mut mesh.initial);
    for set in mesh.node_sets.values_mut() {
        set.iter_mut().for_each(node);
        set.sort_unstable();
    }
}

/// Lists of numbers in one array.
struct NumberLists {
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl NumberLists {
    fn list(&self, list: u32) -> &[u32] {
        &self.items[self.starts[list as usize]..self.starts[list as usize + 1]]
    }
}

/// Returns the nodes of each element, as indices in the mesh.
fn corners(mesh: &Mesh) -> NumberLists {
    let lowest = mesh.nodes.first().map_or(0, |n| n.id.0);
    let position = |id: NodeId| {
        let close = id.0.wrapping_sub(lowest) as usize; // valid for ids without gaps
        let there = mesh.nodes.get(close).is_some_and(|n| n.id == id);
        let found = if there { Ok(close) } else { mesh.nodes.binary_search_by_key(&id, |n| n.id) };
        found.expect("a checked mesh has the nodes of its elements") as u32
    };
    let mut lists = NumberLists { starts: vec![0], items: Vec::new() };
    for e in &mesh.elements {
        lists.items.extend(e.corners().iter().map(|&id| position(id)));
        lists.starts.push(lists.items.len());
    }
    lists
}

/// Returns the elements at each of `nodes` nodes.
fn around(corners: &NumberLists, nodes: usize) -> NumberLists {
    let mut starts = vec![0; nodes + 1];
    corners.items.iter().for_each(|&n| starts[n as usize + 1] += 1);
    (0..nodes).for_each(|n| starts[n + 1] += starts[n]);
    let (mut items, mut next) = (vec![0; corners.items.len()], starts.clone());
    for e in 0..corners.starts.len() as u32 - 1 {
        for &n in corners.list(e) {
            items[next[n as usize]] = e;
            next[n as usize] += 1;
        }
    }
    NumberLists { starts, items }
}

/// Returns the mean number of node lines that an element fetches, for elements in `order` with
/// nodes at `place`. A line stays in the cache until [`LINES`] others have been fetched since its
/// last use.
fn fetched(order: &[u32], corners: &NumberLists, place: &[u32]) -> f64 {
    let mut used: Vec<Option<u32>> = vec![None; place.len().div_ceil(LINE)];
    let mut fetched = 0u32;
    for &node in order.iter().flat_map(|&e| corners.list(e)) {
        let line = place[node as usize] as usize / LINE;
        if used[line].is_none_or(|last| fetched - last >= LINES) {
            fetched += 1;
        }
        used[line] = Some(fetched);
    }
    f64::from(fetched) / order.len().max(1) as f64
}

/// Mark of a numbered node. A visited node has the number of the walk, any other node 0.
const NUMBERED: u32 = u32::MAX;

/// Returns all nodes, part by part, and in each connected piece of a part in levels from an end.
fn levels(mesh: &Mesh, corners: &NumberLists) -> Vec<u32> {
    let part = |e: u32| mesh.elements[e as usize].part;
    let around = around(corners, mesh.nodes.len());
    let mut walked = Walks { mesh, corners, around, seen: vec![0; mesh.nodes.len()] };
    let mut elements: Vec<u32> = (0..mesh.elements.len() as u32).collect();
    elements.sort_by_key(|&e| part(e));
    let (mut order, mut trial, mut walks) = (Vec::with_capacity(mesh.nodes.len()), Vec::new(), 0);
    for e in elements {
        while let Some(&first) =
            corners.list(e).iter().find(|&&n| walked.seen[n as usize] != NUMBERED)
        {
            let mut end = first;
            for _ in 0..2 {
                walks += 1;
                trial.clear();
                walked.walk(end, part(e), walks, &mut trial);
                end = *trial.last().expect("a walk has its start");
            }
            walked.walk(end, part(e), NUMBERED, &mut order);
        }
    }
    order
}

struct Walks<'a> {
    mesh: &'a Mesh,
    corners: &'a NumberLists,
    around: NumberLists,
    seen: Vec<u32>,
}

impl Walks<'_> {
    /// Appends the nodes without a number in the order in which they are reached from `start`
    /// through elements of a part. Nodes reached from the same node are ordered by their number
    /// of elements.
    fn walk(&mut self, start: u32, part: u32, walk: u32, order: &mut Vec<u32>) {
        let mut at = order.len();
        self.seen[start as usize] = walk;
        order.push(start);
        while at < order.len() {
            let new = order.len();
            let elements = self.around.list(order[at]).iter();
            for &e in elements.filter(|&&e| self.mesh.elements[e as usize].part == part) {
                for &node in self.corners.list(e) {
                    let seen = &mut self.seen[node as usize];
                    if *seen != NUMBERED && *seen != walk {
                        *seen = walk;
                        order.push(node);
                    }
                }
            }
            order[new..].sort_unstable_by_key(|&n| (self.around.list(n).len(), n));
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::mesh::{MeshElement, Shape};
    use std::collections::BTreeMap;

    const SIDE: u64 = 120;

    /// Returns a square of quads, with ids times `step` modulo their number: 1 keeps them in
    /// rows. Its upper half is part 2.
    fn square(step: u64) -> Mesh {
        let nodes = (SIDE + 1) * (SIDE + 1);
        let id = |i: u64, j: u64| NodeId((i * (SIDE + 1) + j) * step % nodes);
        let all = |n: u64| (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
        let element = |(i, j): (u64, u64)| {
            let corners = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            MeshElement::new(
                ElemId((i * SIDE + j) * step % (SIDE * SIDE)),
                1 + (i >= SIDE / 2) as u32,
                Shape::Quad4,
                &corners,
            )
        };
        let mut mesh = Mesh {
            nodes: all(SIDE + 1)
                .map(|(i, j)| MeshNode { id: id(i, j), x: [i as f64, j as f64, 0.0] })
                .collect(),
            elements: all(SIDE).map(element).collect(),
            node_sets: BTreeMap::from([(
                "edge".into(),
                (0..=SIDE).map(|j| id(0, j)).chain([NodeId(1 << 40)]).collect(),
            )]),
            initial: Vec::new(),
        };
        mesh.nodes.sort_by_key(|n| n.id);
        mesh.elements.sort_by_key(|e| e.id);
        mesh
    }

    /// Returns the content of a mesh by labels: nodes, elements, and its set.
    fn labels(mesh: &Mesh) -> [BTreeMap<u64, Vec<u64>>; 3] {
        let of = |e: &MeshElement| [&[u64::from(e.part)][..], &e.nodes.map(NodeId::label)].concat();
        [
            mesh.nodes.iter().map(|n| (n.id.label(), n.x.map(f64::to_bits).to_vec())).collect(),
            mesh.elements.iter().map(|e| (e.id.label(), of(e))).collect(),
            mesh.node_sets["edge"].iter().map(|n| (n.label(), Vec::new())).collect(),
        ]
    }

    #[test]
    fn a_mesh_in_rows_stays_as_it_is() {
        let (mut mesh, mut axes) = (square(1), vec![]);
        assert_eq!(renumber(&mut mesh, &mut axes, &mut JobProblems::default()), None);
        assert_eq!(mesh, square(1));
    }

    /// Rows and layers as large as the cache, or of a power of two, are in order too.
    #[test]
    fn long_rows_and_large_layers_stay_as_they_are() {
        for count in [[2047, 6, 0], [2046, 5, 0], [63, 63, 4], [44, 90, 3], [1, 511, 12]] {
            let given = boxes(count);
            let mut mesh = given.clone();
            assert_eq!(
                renumber(&mut mesh, &mut [], &mut JobProblems::default()),
                None,
                "{count:?}"
            );
            assert_eq!(mesh, given);
        }
    }

    /// Returns quads or solids in rows, with nodes numbered along the first count, then the
    /// second.
    fn boxes([a, b, c]: [u64; 3]) -> Mesh {
        let id = |i: u64, j: u64, k: u64| NodeId((k * (b + 1) + j) * (a + 1) + i);
        let face = |i, j, k| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
        let element = |n: u64| {
            let (i, j, k) = (n % a, n / a % b, n / (a * b));
            match c {
                0 => MeshElement::new(ElemId(n), 1, Shape::Quad4, &face(i, j, 0)),
                _ => MeshElement::new(
                    ElemId(n),
                    1,
                    Shape::Hex8,
                    &[face(i, j, k), face(i, j, k + 1)].concat(),
                ),
            }
        };
        let nodes =
            (0..(a + 1) * (b + 1) * (c + 1)).map(|n| MeshNode { id: NodeId(n), x: [0.0; 3] });
        Mesh {
            nodes: nodes.collect(),
            elements: (0..a * b * c.max(1)).map(element).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_scattered_mesh_gets_places_as_good_as_rows_and_keeps_its_labels() {
        let (given, mut axes) = (square(6007), vec![(ElemId(3), [1.0; 3]), (ElemId(70), [2.0; 3])]);
        let mut mesh = given.clone();
        let done = renumber(&mut mesh, &mut axes, &mut JobProblems::default())
            .expect("neighbours are thousands apart");
        assert!(done.before > 1.0 && done.after < 0.2, "{done:?}");
        assert_eq!(labels(&mesh), labels(&given));
        assert!(mesh.nodes.is_sorted_by_key(|n| n.id) && mesh.elements.is_sorted_by_key(|e| e.id));
        assert!(mesh.elements.is_sorted_by_key(|e| e.part), "part by part");
        assert!(mesh.node_sets["edge"].is_sorted());
        let sides: BTreeMap<u64, f64> = axes.iter().map(|a| (a.0.label(), a.1[0])).collect();
        assert_eq!(sides, BTreeMap::from([(3, 1.0), (70, 2.0)]));
        assert!(
            axes.iter().all(|a| mesh.elements.iter().any(|e| e.id == a.0))
                && axes.is_sorted_by_key(|a| a.0)
        );
        let place = |n: NodeId| (n.0 >> 32) & 0xfff_ffff;
        let apart = |e: &MeshElement| {
            let places = e.corners().iter().map(|&n| place(n));
            places.clone().max().unwrap() - places.min().unwrap()
        };
        let widest = mesh.elements.iter().filter(|e| e.part == 1).map(apart).max().unwrap();
        assert!(widest < 3 * SIDE, "the corners of an element lie within {widest} places");
    }

    #[test]
    fn ids_that_leave_no_room_for_a_place_stay_as_they_are() {
        let mut mesh = square(6007);
        mesh.nodes.last_mut().unwrap().id = NodeId(1 << 33);
        let lost = mesh.nodes[mesh.nodes.len() - 2].id.0 + 1;
        mesh.elements
            .iter_mut()
            .flat_map(|e| &mut e.nodes)
            .filter(|n| n.0 == lost)
            .for_each(|n| *n = NodeId(1 << 33));
        let given = mesh.clone();
        let mut findings = JobProblems::default();
        assert_eq!(renumber(&mut mesh, &mut [], &mut findings), None);
        assert_eq!(mesh, given);
        assert_eq!(findings.list.len(), 1, "and the user gets a warning");
    }
}
