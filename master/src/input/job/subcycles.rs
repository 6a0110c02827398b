//! Which elements are slow: computed in the first cycle of an outer step only
//! (`worker/src/fem/assembly.rs`, [`Settings::subcycles`]).
//!
//! The slow ones bear the outer step, and do not touch the small ones that set the step: layers of
//! neighbours lie between. Fast motion that could resonate with the slow forces, of half periods
//! that fit into the outer step, is too fast to travel in these layers and dies away across them
//! (`cases/studies/README.md`).

use super::state::ElementStart;
use super::validate::Findings;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Time;
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use std::collections::HashMap;

/// Steps within round-off of the outer step bear it.
const SLACK: f64 = 1e-9;
/// Subcycles that are looked at for advice.
const CHOICES: std::ops::RangeInclusive<u64> = 2..=20;
/// Fraction of the computations of elements that subcycles have to save to be worth a word.
const WORTH: f64 = 0.2;

/// Elements by how often they are computed; those of rigid parts and skins are in neither.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classes {
    /// In each cycle.
    pub fast: usize,
    /// Once in an outer step.
    pub slow: usize,
}

impl Classes {
    /// Counts them.
    pub fn new(elements: &ElementStart) -> Self {
        let slow = elements.slow.iter().filter(|&&slow| slow).count();
        Self { fast: elements.stable_dt.iter().filter(|dt| dt.is_finite()).count() - slow, slow }
    }

    /// Computations of elements in an outer step as a fraction of those without subcycles.
    pub fn work(&self, subcycles: u64) -> f64 {
        let all = (self.fast + self.slow).max(1) as f64;
        (self.fast as f64 + self.slow as f64 / subcycles as f64) / all
    }
}

/// Which nodes, by their places in the mesh, are next to each other.
struct Neighbours {
    /// Of each element.
    elements: Vec<[u32; 8]>,
    /// That a tie or a rigid body joins: fast motion passes through.
    joined: Vec<Vec<u32>>,
    nodes: usize,
    /// Elements that are computed in each cycle whatever their step: contact answers to their
    /// forces in the cycle in which they come.
    kept: Vec<bool>,
}

impl Neighbours {
    fn new(time: &Time, mesh: &Mesh, settings: &Settings) -> Self {
        let place: HashMap<NodeId, u32> =
            mesh.nodes.iter().zip(0..).map(|(n, i)| (n.id, i)).collect();
        let places = |nodes: &mut dyn Iterator<Item = NodeId>| -> Vec<u32> {
            nodes.filter_map(|n| place.get(&n).copied()).collect()
        };
        let tied = |tie: &Tie| {
            places(&mut std::iter::once(tie.node).chain(tie.masters.iter().map(|c| c.0)))
        };
        let bodies = settings.rigid.iter().map(|body| places(&mut body.nodes.iter().copied()));
        let touching = settings.contact.as_ref().filter(|_| !time.subcycle_contact);
        let touches = |part: u32| touching.is_some_and(|c| c.takes_part(part));
        Self {
            elements: mesh.elements.iter().map(|e| e.nodes.map(|n| place[&n])).collect(),
            joined: settings.ties.iter().map(tied).chain(bodies).collect(),
            nodes: mesh.nodes.len(),
            kept: mesh.elements.iter().map(|e| touches(e.part)).collect(),
        }
    }

    /// The elements that are slow with so many subcycles, and so many layers of others between them
    /// and the small ones.
    fn slow(&self, subcycles: u64, layers: u64, stable_dt: &[f64]) -> Vec<bool> {
        let outer = subcycles as f64 * smallest(stable_dt) * (1.0 - SLACK);
        let bears = |(&dt, &kept): (&f64, &bool)| dt.is_finite() && dt >= outer && !kept;
        let mut slow: Vec<bool> = stable_dt.iter().zip(&self.kept).map(bears).collect();
        let mut near = vec![false; self.nodes];
        for _ in 0..layers {
            let fast = slow.iter().zip(stable_dt).map(|(slow, dt)| !slow && dt.is_finite());
            for (nodes, _) in self.elements.iter().zip(fast).filter(|e| e.1) {
                nodes.iter().for_each(|&n| near[n as usize] = true);
            }
            for joined in &self.joined {
                if joined.iter().any(|&n| near[n as usize]) {
                    joined.iter().for_each(|&n| near[n as usize] = true);
                }
            }
            let mut grown = false;
            for (nodes, slow) in self.elements.iter().zip(&mut slow).filter(|e| *e.1) {
                *slow = !nodes.iter().any(|&n| near[n as usize]);
                grown |= !*slow;
            }
            if !grown {
                break;
            }
        }
        slow
    }
}

/// Finds the slow elements; without any, or with one subcycle, all are computed in each cycle.
pub fn divide(
    time: &Time,
    mesh: &Mesh,
    settings: &mut Settings,
    elements: &mut ElementStart,
    findings: &mut Findings,
) {
    if settings.subcycles <= 1 {
        return;
    }
    let neighbours = Neighbours::new(time, mesh, settings);
    elements.slow = neighbours.slow(settings.subcycles, time.subcycle_layers, &elements.stable_dt);
    if !elements.slow.contains(&true) {
        let message = format!(
            "subcycles = {} leaves no slow element, that bears so many of the smallest step, is not next to a small one and in no \
             contact: all are computed in each cycle",
            settings.subcycles
        );
        let help = "take fewer, name the parts that touch in contact.parts, or take the key out";
        findings.add(Problem::warning("time.subcycles", message, help));
        settings.subcycles = 1;
        elements.slow.clear();
    } else if time.subcycle_contact && settings.contact.is_some() {
        let message = "elements of parts in contact act once in so many cycles: friction and the balance of energy suffer where \
                       something rests or slides under load";
        findings.add(Problem::warning(
            "time.subcycle_contact",
            message,
            "compare with a run without it",
        ));
    }
}

/// The number of subcycles that saves most of the computations of elements, and what it leaves of
/// them, if that is worth a word.
pub fn best(
    time: &Time,
    mesh: &Mesh,
    settings: &Settings,
    elements: &ElementStart,
) -> Option<(u64, f64)> {
    let stable_dt = &elements.stable_dt;
    let least = smallest(stable_dt);
    let deformable = stable_dt.iter().filter(|dt| dt.is_finite()).count();
    let work = |slow: usize, m: u64| Classes { fast: deformable - slow, slow }.work(m);
    // Layers only take from the slow ones.
    let at_most = |m: u64| {
        stable_dt
            .iter()
            .filter(|&&dt| dt.is_finite() && dt >= m as f64 * least * (1.0 - SLACK))
            .count()
    };
    let choices: Vec<u64> = CHOICES.filter(|&m| work(at_most(m), m) <= 1.0 - WORTH).collect();
    if choices.is_empty() {
        return None;
    }
    let neighbours = Neighbours::new(time, mesh, settings);
    let slow = |m: u64| {
        neighbours.slow(m, time.subcycle_layers, stable_dt).into_iter().filter(|&slow| slow).count()
    };
    let left = choices.into_iter().map(|m| (m, work(slow(m), m)));
    left.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|best| best.1 <= 1.0 - WORTH)
}

fn smallest(stable_dt: &[f64]) -> f64 {
    stable_dt.iter().copied().fold(f64::INFINITY, f64::min)
}
