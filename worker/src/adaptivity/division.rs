//! Divisions of all workers: what each worker sends to the others, the ids of new elements and
//! nodes, and the masses that move.

use super::{Adaptivity, NewNode, lead, side};
use crate::fem::elements::{Element, build_block};
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, Settings};
use crumple_proto::transport::{RankLost, Transport, gather_all};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Division of a shell, as its worker sends it to all others.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub(crate) struct Division {
    pub id: ElemId,
    pub nodes: [NodeId; 4],
    /// Mass and rotational inertia of the shell at each corner [mass], [mass length^2].
    whole: [f64; 2],
    /// The same of its quarters.
    quarters: [[f64; 2]; 4],
}

/// A division with its new ids.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct NumberedDivision {
    pub of: Division,
    /// Ids of the quarters at the corners.
    pub quarters: [ElemId; 4],
    /// Nodes in the middle of the sides 0-1, 1-2, 2-3, 3-0.
    pub middles: [NodeId; 4],
    pub centre: NodeId,
}

impl NumberedDivision {
    /// Returns the new nodes, each with those between which it lies. Nodes that another division
    /// made too, or made before, are among them.
    pub fn made(&self) -> impl Iterator<Item = (NodeId, Vec<NodeId>)> + use<> {
        let Self { of: Division { nodes, .. }, middles, centre, .. } = *self;
        let ends = move |k: usize| (middles[k], side(nodes[k], nodes[(k + 1) % 4]).to_vec());
        (0..4).map(ends).chain([(centre, nodes.to_vec())])
    }

    /// Returns the quarter of the shell at a corner.
    pub fn quarter_of(&self, whole: &ElementRecord, corner: usize) -> ElementRecord {
        let nodes = self.nodes_of(corner);
        ElementRecord {
            id: self.quarters[corner],
            nodes: std::array::from_fn(|c| nodes[c.min(3)]),
            ..*whole
        }
    }

    /// Returns the nodes of the quarter at a corner, in the order of the corners of the shell, so
    /// that its axes are those of the shell.
    pub fn nodes_of(&self, corner: usize) -> [NodeId; 4] {
        let ([a, b, c, d], [ab, bc, cd, da]) = (self.of.nodes, self.middles);
        let m = self.centre;
        [[a, ab, m, da], [ab, b, bc, m], [m, bc, c, cd], [da, m, cd, d]][corner]
    }
}

/// Returns the corners of the quarter of a quad at one of its corners [length].
pub(crate) fn quarter_of_quad(x: &[[f64; 3]; 4], corner: usize) -> [[f64; 3]; 4] {
    let mean = |of: &[usize]| {
        [0, 1, 2].map(|c| of.iter().map(|&k| x[k][c]).sum::<f64>() / of.len() as f64)
    };
    let all = [0, 1, 2, 3];
    match corner {
        0 => [x[0], mean(&[0, 1]), mean(&all), mean(&[0, 3])],
        1 => [mean(&[0, 1]), x[1], mean(&[1, 2]), mean(&all)],
        2 => [mean(&all), mean(&[1, 2]), x[2], mean(&[2, 3])],
        _ => [mean(&[0, 3]), mean(&all), mean(&[2, 3]), x[3]],
    }
}

/// The formulations of the parts of divided shells.
pub(crate) struct Formulations<'a> {
    settings: &'a Settings,
    built: HashMap<u32, Box<dyn Element>>,
}

impl<'a> Formulations<'a> {
    /// Returns none yet: each is built when it is used.
    pub fn new(settings: &'a Settings) -> Self {
        Self { settings, built: HashMap::new() }
    }

    /// Returns that of the quads of a part.
    pub fn of(&mut self, part: u32) -> &dyn Element {
        let settings = self.settings;
        &**self.built.entry(part).or_insert_with(|| {
            let built = build_block(settings, part as usize, Shape::Quad4);
            built.unwrap_or_else(|problems| panic!("part {part} was built before: {problems:?}"))
        })
    }

    /// Returns the smallest stable step of the quarters of a shell with its slots at `x` [time]. It
    /// is that at the present shape and the mass of the start of a shell of that shape, and so an
    /// estimate.
    pub fn step_of_quarters(&mut self, e: &ElementRecord, x: &[[f64; 3]]) -> f64 {
        let corners = std::array::from_fn(|c| x[c]);
        let element = self.of(e.part);
        let steps = (0..4).map(|k| element.stable_dt(&quarter_of_quad(&corners, k), e.own));
        steps.fold(f64::INFINITY, f64::min) * (e.mass_factor * e.share).sqrt()
    }

    /// Returns the division of a shell with its corners at `x` at the start.
    pub fn division(&mut self, e: &ElementRecord, x: &[[f64; 3]; 4]) -> Division {
        let element = self.of(e.part);
        let at = |x: &[[f64; 3]; 4]| {
            let (mass, inertia) = element.corner_mass(x, e.own);
            [mass * e.mass_factor, inertia * e.mass_factor]
        };
        Division {
            id: e.id,
            nodes: std::array::from_fn(|c| e.nodes[c]),
            whole: at(x),
            quarters: std::array::from_fn(|corner| at(&quarter_of_quad(x, corner))),
        }
    }
}

/// Returns the divisions of all workers, sorted by element.
///
/// # Errors
/// A worker is gone.
pub(crate) fn gather(
    comm: &mut dyn Transport,
    own: Vec<Division>,
) -> Result<Vec<Division>, RankLost> {
    let mut all = gather_all(comm, own)?.concat();
    all.sort_unstable_by_key(|d| d.id);
    Ok(all)
}

impl Adaptivity {
    /// Gives the new elements and nodes of divisions after a cycle their ids.
    pub(crate) fn number(&mut self, divisions: &[Division], cycle: u64) -> Vec<NumberedDivision> {
        let mut numbered = Vec::with_capacity(divisions.len());
        for (&of, count) in divisions.iter().zip(self.divided()..) {
            let level = self.level(of.id) + 1;
            let first = self.settings.first_element.after(4 * count);
            let quarters: [ElemId; 4] = std::array::from_fn(|k| first.after(k as u64));
            self.levels.remove(&of.id);
            self.levels.extend(quarters.map(|id| (id, level)));
            let middles = std::array::from_fn(|k| self.middle(of.nodes[k], of.nodes[(k + 1) % 4]));
            let centre = self.new_node(of.nodes.to_vec());
            numbered.push(NumberedDivision { of, quarters, middles, centre });
        }
        self.divisions.extend(&numbered);
        self.cycles += cycle * numbered.len() as u64;
        numbered
    }

    fn new_node(&mut self, between: Vec<NodeId>) -> NodeId {
        let id = self.settings.first_node.after(self.nodes.len() as u64);
        lead(&mut self.led, id, &between);
        self.nodes.insert(id, NewNode { between, mass: [0.0; 2], follows: Vec::new() });
        id
    }

    /// Returns the node in the middle of a side; makes it if there is none.
    fn middle(&mut self, a: NodeId, b: NodeId) -> NodeId {
        let side = side(a, b);
        if let Some(&middle) = self.of_sides.get(&side) {
            return middle;
        }
        let id = self.new_node(side.to_vec());
        self.of_sides.insert(side, id);
        id
    }

    /// Returns the nodes in the middle of the sides of these divisions that exist already.
    pub(crate) fn known_middles(&self, divisions: &[Division]) -> BTreeSet<NodeId> {
        let sides = |d: &Division| {
            let nodes = d.nodes;
            (0..4).map(move |k| side(nodes[k], nodes[(k + 1) % 4]))
        };
        let middles = divisions.iter().flat_map(sides).filter_map(|s| self.of_sides.get(&s));
        middles.copied().collect()
    }

    /// Returns what divisions add to the masses and inertias of nodes, and adds it to those of the
    /// new nodes.
    pub(crate) fn add_masses(
        &mut self,
        divisions: &[NumberedDivision],
    ) -> BTreeMap<NodeId, [f64; 2]> {
        let mut added: BTreeMap<NodeId, [f64; 2]> = BTreeMap::new();
        let mut add = |node: NodeId, factor: f64, mass: [f64; 2]| {
            let sum = added.entry(node).or_default();
            (0..2).for_each(|k| sum[k] += factor * mass[k]);
        };
        for d in divisions {
            d.of.nodes.iter().for_each(|&n| add(n, -1.0, d.of.whole));
            for (corner, &mass) in d.of.quarters.iter().enumerate() {
                d.nodes_of(corner).iter().for_each(|&n| add(n, 1.0, mass));
            }
        }
        for (node, mass) in &added {
            if let Some(new) = self.nodes.get_mut(node) {
                (0..2).for_each(|k| new.mass[k] += mass[k]);
            }
        }
        added
    }
}
