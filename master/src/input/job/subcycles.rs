//! Finds slow elements, which are computed in the first cycle of an outer step only
//! (`worker/fem/src/assembly.rs`, [`Settings::subcycles`]).
//!
//! Slow elements are stable at the outer step and do not touch the small elements that control
//! the step: layers of neighbours are between them. Fast motion that could resonate with the slow
//! forces has half periods that fit into the outer step. It is too fast to travel in these layers
//! and decays across them (`cases/studies/README.md`).

use super::state::ElementStart;
use super::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Time;
use crumple_proto::mesh::{MAX_CORNERS, Mesh, MeshElement};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use std::collections::{HashMap, HashSet};

/// Relative round-off by which a stable step may be below the outer step.
const SLACK: f64 = 1e-9;
/// Numbers of subcycles that are tried for advice.
const CHOICES: std::ops::RangeInclusive<u64> = 2..=20;
/// Smallest fraction of element computations saved for which subcycles are recommended.
const WORTH: f64 = 0.2;

/// Elements by frequency of computation. Those of rigid parts and skins are in neither class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubcycleClasses {
    /// Number of elements computed in each cycle.
    pub fast: usize,
    /// Number of elements computed once per outer step.
    pub slow: usize,
}

impl SubcycleClasses {
    /// Counts the elements of each class.
    pub fn new(elements: &ElementStart) -> Self {
        let slow = elements.slow.iter().filter(|&&slow| slow).count();
        Self { fast: elements.stable_dt.iter().filter(|dt| dt.is_finite()).count() - slow, slow }
    }

    /// Returns the element computations in an outer step as a fraction of those without
    /// subcycles.
    pub fn work(&self, subcycles: u64) -> f64 {
        let all = (self.fast + self.slow).max(1) as f64;
        (self.fast as f64 + self.slow as f64 / subcycles as f64) / all
    }
}

/// Connections between nodes, as indices in the mesh.
struct Neighbours {
    /// Nodes of each element.
    elements: Vec<[u32; MAX_CORNERS]>,
    /// Groups of nodes that a tie or a rigid body joins; fast motion passes through them.
    joined: Vec<Vec<u32>>,
    nodes: usize,
    /// Elements that are computed in each cycle for any step: contact responds to their forces in
    /// the same cycle, or they average their volume strain with their neighbours.
    kept: Vec<bool>,
}

impl Neighbours {
    fn new(time: &Time, mesh: &Mesh, settings: &Settings, averages: &[bool]) -> Self {
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
        // The force of a tie that can fail is that of one cycle.
        let breakable = settings.ties.iter().filter(|tie| tie.failure.is_some());
        let held: HashSet<NodeId> =
            breakable.flat_map(|tie| tie.masters.iter().map(|m| m.0).chain([tie.node])).collect();
        let is_kept = |(e, &averages): (&MeshElement, &bool)| {
            touches(e.part)
                || averages
                || !held.is_empty() && e.corners().iter().any(|n| held.contains(n))
        };
        Self {
            elements: mesh.elements.iter().map(|e| e.nodes.map(|n| place[&n])).collect(),
            joined: settings.ties.iter().map(tied).chain(bodies).collect(),
            nodes: mesh.nodes.len(),
            kept: mesh.elements.iter().zip(averages).map(is_kept).collect(),
        }
    }

    /// Returns true for the slow elements, with `subcycles` subcycles and `layers` layers of
    /// other elements between them and the small ones.
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

/// Finds the slow elements. If there are none, or with one subcycle, all elements are computed in
/// each cycle.
pub fn divide(
    time: &Time,
    mesh: &Mesh,
    settings: &mut Settings,
    elements: &mut ElementStart,
    findings: &mut JobProblems,
) {
    if settings.subcycles <= 1 {
        return;
    }
    let neighbours = Neighbours::new(time, mesh, settings, &elements.averages);
    elements.slow = neighbours.slow(settings.subcycles, time.subcycle_layers, &elements.stable_dt);
    if !elements.slow.contains(&true) {
        let message = format!(
            "subcycles = {} leaves no slow element: a slow element is stable at the outer step, is \
             not near a small one, is not in contact and does not average its volume strain; all \
             elements are computed in each cycle",
            settings.subcycles
        );
        let help =
            "use fewer subcycles, name the parts that touch in contact.parts, or remove the key";
        findings.add(Problem::warning("time.subcycles", message, help));
        settings.subcycles = 1;
        elements.slow.clear();
    } else if time.subcycle_contact && settings.contact.is_some() {
        let message = "slow elements of parts in contact act once per outer step: friction and the \
                       energy balance are less accurate where a part rests or slides under load";
        findings.add(Problem::warning(
            "time.subcycle_contact",
            message,
            "compare with a run without this key",
        ));
    }
}

/// Returns the number of subcycles that saves most element computations, and the remaining
/// fraction of them; none if the saving is too small.
pub fn best(
    time: &Time,
    mesh: &Mesh,
    settings: &Settings,
    elements: &ElementStart,
) -> Option<(u64, f64)> {
    let stable_dt = &elements.stable_dt;
    let least = smallest(stable_dt);
    let deformable = stable_dt.iter().filter(|dt| dt.is_finite()).count();
    let work = |slow: usize, m: u64| SubcycleClasses { fast: deformable - slow, slow }.work(m);
    // Layers only reduce the number of slow elements.
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
    let neighbours = Neighbours::new(time, mesh, settings, &elements.averages);
    let slow = |m: u64| {
        neighbours.slow(m, time.subcycle_layers, stable_dt).into_iter().filter(|&slow| slow).count()
    };
    let left = choices.into_iter().map(|m| (m, work(slow(m), m)));
    left.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|best| best.1 <= 1.0 - WORTH)
}

fn smallest(stable_dt: &[f64]) -> f64 {
    stable_dt.iter().copied().fold(f64::INFINITY, f64::min)
}
