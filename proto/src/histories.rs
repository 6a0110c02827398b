//! Histories by kind: requests of a job, in ids, and the contributions of workers to each
//! history interval.

use crate::exact_sum::ExactSum;
use crate::ids::{ElemId, NodeId};
use crate::place::Peak;
use serde::{Deserialize, Serialize};

/// Histories that are recorded in addition to the sums of `history.csv`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HistoryRequests {
    /// Contact forces between parts.
    pub contacts: bool,
    /// Groups of nodes.
    pub nodes: Vec<NodeGroup>,
    /// Sections.
    pub sections: Vec<SectionCut>,
    /// Force transducers.
    pub transducers: Vec<Transducer>,
}

/// Nodes whose motion is recorded.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NodeGroup {
    /// Name for output.
    pub name: String,
    /// The nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Nodes whose axes the motion is written in, if these are not the global ones.
    pub axes: Option<[NodeId; 3]>,
}

/// Section through the model: nodes, and the elements on one side that end at them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SectionCut {
    /// Name for output.
    pub name: String,
    /// The nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The elements, ascending; each has at least one of the nodes.
    pub elements: Vec<ElemId>,
}

/// Force transducer: the contact force on a surface, from another surface or from all.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Transducer {
    /// Name for output.
    pub name: String,
    /// Surface whose force is recorded.
    pub on: TransducerSurface,
    /// Surface that exerts the force.
    pub from: TransducerSurface,
}

/// Subset of the contact surface: by parts, by nodes, or by both. Without either it is the
/// whole surface.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct TransducerSurface {
    /// Indices of the parts, ascending; all parts if empty.
    pub parts: Vec<u32>,
    /// The nodes, ascending; all nodes if `None`.
    pub nodes: Option<Vec<NodeId>>,
}

impl TransducerSurface {
    /// Returns true if an entity of this part with these nodes belongs to the surface.
    pub fn has(&self, part: u32, nodes: &[NodeId]) -> bool {
        let own = |set: &Vec<NodeId>| nodes.iter().all(|n| set.binary_search(n).is_ok());
        (self.parts.is_empty() || self.parts.binary_search(&part).is_ok())
            && self.nodes.as_ref().is_none_or(own)
    }
}

/// Contributions of one worker at one time, as exact sums, or those of all workers, as numbers;
/// empty where nothing is requested. Those of parts are always there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistoryShares<N = f64> {
    /// Per part, in the order of the settings.
    pub parts: Vec<PartShare<N>>,
    /// Pairs of parts that touch, ascending.
    pub contacts: Vec<ContactShare<N>>,
    /// Nodes of all groups that this worker owns, ascending.
    pub nodes: Vec<NodeState>,
    /// Per section.
    pub sections: Vec<SectionShare<N>>,
    /// Contact force on the surface of each transducer [force].
    pub transducers: Vec<[N; 3]>,
    /// State of each airbag, equal on all workers.
    pub airbags: Vec<BagState>,
    /// Values of each segment, ring and retractor of seat belts, equal on all workers.
    pub belts: Vec<BeltRecord>,
}

/// Sums over the elements of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartShare<N = f64> {
    /// Mass [mass].
    pub mass: N,
    /// Kinetic energy of that mass [energy].
    pub kinetic: N,
    /// Internal energy: stored elastically and dissipated plastically [energy].
    pub internal: N,
    /// Hourglass and drilling energy [energy].
    pub hourglass: N,
    /// Element with the most hourglass and drilling energy [energy].
    pub most_hourglass: Peak,
    /// Linear momentum [mass length/time].
    pub momentum: [N; 3],
}

/// Contact force between two parts; the first has the lower index.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactShare<N = f64> {
    /// Indices into the parts of the settings.
    pub parts: [u32; 2],
    /// Force on the first part [force].
    pub force: [N; 3],
}

/// Motion of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeState {
    /// The node.
    pub id: NodeId,
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Displacement since the start [length].
    pub u: [f64; 3],
    /// Velocity [length/time].
    pub v: [f64; 3],
    /// Acceleration [length/time^2].
    pub a: [f64; 3],
}

/// Sums of the forces that the elements of a section exert on its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SectionShare<N = f64> {
    /// Force [force].
    pub force: [N; 3],
    /// Moment about the origin [force length].
    pub moment: [N; 3],
    /// Sum of the coordinates of the owned nodes [length].
    pub places: [N; 3],
    /// Number of owned nodes.
    pub nodes: u64,
}

/// State of an airbag. Without a gas, only volume, pressure and work are not zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BagState {
    /// Volume [length^3].
    pub volume: f64,
    /// Absolute pressure [force/length^2].
    pub pressure: f64,
    /// Mass of the gas [mass].
    pub mass: f64,
    /// Temperature of the gas [temperature].
    pub temperature: f64,
    /// Internal energy of the gas [energy].
    pub energy: f64,
    /// Mass that has come in [mass].
    pub mass_in: f64,
    /// Mass that has left [mass].
    pub mass_out: f64,
    /// Enthalpy of the gas that has come in [energy].
    pub enthalpy_in: f64,
    /// Enthalpy of the gas that has left [energy].
    pub enthalpy_out: f64,
    /// Work on the surface, including that against the ambient pressure [energy].
    pub work: f64,
}

/// Values of a segment, a ring or a retractor of a seat belt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeltRecord {
    /// Tension before and after a ring; of a segment or at a retractor twice the same [force].
    pub tensions: [f64; 2],
    /// Unstretched length of a segment, slip through a ring, pull-out of a retractor [length].
    pub length: f64,
    /// Energy that friction in a ring has dissipated or a retractor has taken up [energy].
    pub energy: f64,
    /// True for a retractor that is locked.
    pub locked: bool,
}

/// Adds the sums `b` of another worker to the sums `a`.
pub fn merge_each(a: &mut [ExactSum; 3], b: &[ExactSum; 3]) {
    a.iter_mut().zip(b).for_each(|(a, b)| a.merge(b));
}

/// Returns sums as numbers.
pub fn each_value(sums: &[ExactSum; 3]) -> [f64; 3] {
    sums.each_ref().map(ExactSum::value)
}

impl HistoryShares<ExactSum> {
    /// Adds the contributions of another worker at the same time.
    pub fn merge(&mut self, o: &Self) {
        for (a, b) in self.parts.iter_mut().zip(&o.parts) {
            a.mass.merge(&b.mass);
            a.kinetic.merge(&b.kinetic);
            a.internal.merge(&b.internal);
            a.hourglass.merge(&b.hourglass);
            a.most_hourglass.raise(b.most_hourglass.value, || b.most_hourglass.at);
            merge_each(&mut a.momentum, &b.momentum);
        }
        for b in &o.contacts {
            match self.contacts.binary_search_by_key(&b.parts, |a| a.parts) {
                Ok(i) => merge_each(&mut self.contacts[i].force, &b.force),
                Err(i) => self.contacts.insert(i, b.clone()),
            }
        }
        self.nodes.extend(&o.nodes);
        self.nodes.sort_by_key(|n| n.id);
        for (a, b) in self.sections.iter_mut().zip(&o.sections) {
            merge_each(&mut a.force, &b.force);
            merge_each(&mut a.moment, &b.moment);
            merge_each(&mut a.places, &b.places);
            a.nodes += b.nodes;
        }
        for (a, b) in self.transducers.iter_mut().zip(&o.transducers) {
            merge_each(a, b);
        }
    }

    /// Returns the contributions as numbers.
    pub fn values(&self) -> HistoryShares {
        let part = |p: &PartShare<ExactSum>| PartShare {
            mass: p.mass.value(),
            kinetic: p.kinetic.value(),
            internal: p.internal.value(),
            hourglass: p.hourglass.value(),
            most_hourglass: p.most_hourglass,
            momentum: each_value(&p.momentum),
        };
        let contact = |c: &ContactShare<ExactSum>| ContactShare {
            parts: c.parts,
            force: each_value(&c.force),
        };
        let section = |s: &SectionShare<ExactSum>| SectionShare {
            force: each_value(&s.force),
            moment: each_value(&s.moment),
            places: each_value(&s.places),
            nodes: s.nodes,
        };
        HistoryShares {
            parts: self.parts.iter().map(part).collect(),
            contacts: self.contacts.iter().map(contact).collect(),
            nodes: self.nodes.clone(),
            sections: self.sections.iter().map(section).collect(),
            transducers: self.transducers.iter().map(each_value).collect(),
            airbags: self.airbags.clone(),
            belts: self.belts.clone(),
        }
    }
}

impl SectionShare {
    /// Returns the centre of the section's nodes [length] and the moment about it [force
    /// length]. `self` must be the sum over all workers.
    pub fn about_midsurface(&self) -> ([f64; 3], [f64; 3]) {
        let (c, f) = (self.places.map(|x| x / self.nodes.max(1) as f64), self.force);
        let turn =
            [c[1] * f[2] - c[2] * f[1], c[2] * f[0] - c[0] * f[2], c[0] * f[1] - c[1] * f[0]];
        (c, std::array::from_fn(|k| self.moment[k] - turn[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_parts_add_up_by_name_and_nodes_come_in_order() {
        let pair = |a, b, f: f64| ContactShare {
            parts: [a, b],
            force: [f, 0.0, -f].map(|f| ExactSum::from_iter([f])),
        };
        let node = |id| NodeState { id: NodeId(id), ..NodeState::default() };
        let mut one = HistoryShares {
            contacts: vec![pair(0, 3, 1.0)],
            nodes: vec![node(2), node(9)],
            ..HistoryShares::default()
        };
        let other = HistoryShares {
            contacts: vec![pair(0, 1, 4.0), pair(0, 3, 2.0)],
            nodes: vec![node(5)],
            ..HistoryShares::default()
        };
        one.merge(&other);
        assert_eq!(one.contacts, [pair(0, 1, 4.0), pair(0, 3, 3.0)]);
        assert_eq!(one.nodes, [node(2), node(5), node(9)]);
        assert_eq!(one.values().contacts[1].force, [3.0, 0.0, -3.0]);
    }

    /// 1 + 1e-16 - 1 is 0 in this order and another number in others.
    #[test]
    fn the_sum_of_a_transducer_does_not_depend_on_the_workers_of_its_pairs() {
        let of = |forces: &[f64]| HistoryShares {
            transducers: vec![[forces.iter().copied().collect(), ExactSum::ZERO, ExactSum::ZERO]],
            ..HistoryShares::default()
        };
        for (one, two) in [(of(&[1.0, -1.0]), of(&[1e-16])), (of(&[1e-16, -1.0]), of(&[1.0]))] {
            let mut sum = one;
            sum.merge(&two);
            assert_eq!(sum.values().transducers, [[1e-16, 0.0, 0.0]]);
        }
    }

    #[test]
    fn a_surface_is_what_parts_and_nodes_have_in_common() {
        let ids = |ids: &[u64]| ids.iter().map(|&n| NodeId(n)).collect::<Vec<_>>();
        let surface = TransducerSurface { parts: vec![2, 5], nodes: Some(ids(&[1, 3, 4])) };
        assert!(surface.has(5, &ids(&[4, 1])));
        assert!(!surface.has(3, &ids(&[1])) && !surface.has(2, &ids(&[1, 2])));
        assert!(TransducerSurface::default().has(9, &ids(&[7])));
    }

    /// Two forces of 5 along z at y = 1 and y = 3 give 10 at the centre, and no moment about
    /// it. With the nodes at y = 0 and y = 2 they give a moment of 10 about x.
    #[test]
    fn the_moment_is_about_the_middle_of_the_nodes() {
        let of = |places: [f64; 3]| SectionShare {
            force: [0.0, 0.0, 10.0],
            moment: [20.0, 0.0, 0.0],
            places,
            nodes: 2,
        };
        assert_eq!(of([0.0, 4.0, 0.0]).about_midsurface(), ([0.0, 2.0, 0.0], [0.0; 3]));
        assert_eq!(of([0.0, 2.0, 0.0]).about_midsurface(), ([0.0, 1.0, 0.0], [10.0, 0.0, 0.0]));
    }
}
