//! Writes given mass, centre and inertia of rigid bodies on the cards of their leading parts.

use super::{Blank, CardValue, Id, Number};
use crate::input::deck::convert::inertia::round_off;
use crate::input::deck::convert::initial::{mean, size_and_middle};
use crate::input::deck::convert::space::cross;
use crate::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Part, Rigid};
use std::collections::{BTreeMap, BTreeSet};

/// Cards of the inertia of a rigid body.
#[derive(Debug)]
pub struct InertiaCards {
    mass: f64,
    centre: [f64; 3],
    /// Components xx, yy, zz, xy, yz, zx.
    tensor: [f64; 6],
    /// Velocity [length/time] and rotational velocity [1/time] at the start.
    motion: [[f64; 3]; 2],
    /// False if a reader takes a given centre for that of the elements.
    pub has_centre: bool,
}

impl InertiaCards {
    /// Returns its three cards.
    pub fn cards(&self) -> [Vec<CardValue>; 3] {
        let [xx, yy, zz, xy, yz, zx] = self.tensor.map(Number);
        let zero = Id(0);
        let centre = self.centre.map(Number);
        [
            [&centre[..], &[Number(self.mass), zero, Blank]].concat(),
            vec![xx, xy, zx, yy, yz, zz],
            self.motion.as_flattened().iter().map(|&v| Number(v)).collect(),
        ]
    }
}

/// Returns the cards of all bodies that have some, by their leading parts. A card has mass and
/// inertia together, and belongs to a part of shells or solids. `rigid` has the parts with a rigid
/// material.
pub fn of(model: &Model, rigid: &BTreeMap<u32, u64>) -> BTreeMap<u32, InertiaCards> {
    let cards = |body: &Rigid| Some((*body.parts.first()?, InertiaCards::new(model, body)?));
    let found = model.job.rigid.iter().filter_map(cards);
    found.filter(|(lead, _)| rigid.contains_key(lead)).collect()
}

impl InertiaCards {
    fn new(model: &Model, body: &Rigid) -> Option<Self> {
        let (mass, tensor) = (body.mass?, body.inertia?);
        let lead = model.job.part.iter().find(|part| Some(&part.id) == body.parts.first())?;
        if !is_of_faces(lead) {
            return None;
        }
        let (mut sizes, mut masses, mut middles) = (Vec::new(), Vec::new(), Vec::new());
        let mut nodes: BTreeSet<NodeId> = BTreeSet::new();
        for (element, own) in model.mesh.elements.iter().zip(&model.elements.mass) {
            if !body.parts.contains(&element.part) || element.shape.faces().is_empty() {
                continue;
            }
            let place = |id: &NodeId| model.mesh.nodes.binary_search_by_key(id, |n| n.id).ok();
            let corners = element.corners().iter().filter_map(place);
            let corners: Vec<[f64; 3]> = corners.map(|at| model.mesh.nodes[at].x).collect();
            let (size, middle) = size_and_middle(element.shape, &corners);
            sizes.push(size);
            masses.push(*own);
            middles.push(middle);
            nodes.extend(element.corners());
        }
        if sizes.is_empty() {
            return None;
        }
        let of_elements = mean(&sizes, &middles);
        let centre = body.centre.unwrap_or_else(|| mean(&masses, &middles));
        let away = (0..3).map(|c| (centre[c] - of_elements[c]).powi(2)).sum::<f64>().sqrt();
        let bound = round_off(mass, tensor);
        // A reader that takes this centre for a given one would change the masses.
        if body.centre.is_none() && away > 0.5 * bound {
            return None;
        }
        let motion = motion(model, &nodes, centre);
        Some(Self { mass, centre, tensor, motion, has_centre: away > 2.0 * bound })
    }
}

/// Returns true for a part of shells or solids with one material.
fn is_of_faces(part: &Part) -> bool {
    let Part { beam, truss, spring, discrete_beam, particles, .. } = part;
    let others = [beam.is_some(), truss.is_some(), spring.is_some(), discrete_beam.is_some()];
    !others.contains(&true) && particles.is_none() && part.layer.is_empty()
}

/// Returns velocity and rotational velocity of a body with these nodes, if one initial velocity
/// acts on all of them. Programs that take the motion of the body from its card need it there.
fn motion(model: &Model, nodes: &BTreeSet<NodeId>, centre: [f64; 3]) -> [[f64; 3]; 2] {
    let all = model.job.initial_velocity.iter().rev();
    let mut counts = all.map(|initial| {
        let set = initial.nodes.as_ref().map(|set| model.mesh.node_sets.get(set));
        let inside = match set {
            None => nodes.len(),
            Some(set) => {
                let set: BTreeSet<&NodeId> = set.into_iter().flatten().collect();
                nodes.iter().filter(|node| set.contains(node)).count()
            }
        };
        (initial, inside)
    });
    match counts.find(|(_, inside)| *inside > 0) {
        Some((initial, inside)) if inside == nodes.len() => {
            let arm = [0, 1, 2].map(|c| centre[c] - initial.centre[c]);
            let turned = cross(initial.spin, arm);
            [[0, 1, 2].map(|c| initial.velocity[c] + turned[c]), initial.spin]
        }
        _ => [[0.0; 3]; 2],
    }
}
