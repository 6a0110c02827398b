//! Seat belts of a job: paths from the elements of parts with `[part.belt]`, their lengths and
//! masses. `devices.rs` has rings, retractors, pretensioners and sensors.

mod devices;

use super::state::{NodeSets, NodeStart};
use super::validate::JobProblems;
use crumple_proto::belt::{BeltLaw, BeltPath, BeltSegment, BeltSystem};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{BeltInput, Job};
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Part of the distance of two nodes by which an element may be shorter than the smallest length.
const SLACK: f64 = 1e-9;

/// Finds the belts of a job and checks their devices. Adds their masses to the nodes.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    sets: &NodeSets<'_>,
    nodes: &mut NodeStart,
    findings: &mut JobProblems,
) -> BeltSystem {
    let parts: Vec<(u32, &BeltInput)> =
        settings.parts.iter().filter_map(|p| Some((p.id, p.belt.as_ref()?))).collect();
    let laws: HashMap<u32, usize> = parts.iter().map(|p| p.0).zip(0..).collect();
    let mut elements: Vec<&MeshElement> =
        mesh.elements.iter().filter(|e| laws.contains_key(&e.part)).collect();
    elements.sort_by_key(|e| e.id);
    for part in job.restart.delete.iter().filter(|part| laws.contains_key(part)) {
        let message = format!("part {part} is a seat belt");
        let help = "leave it out here: a run continues with all its belts";
        findings.add(Problem::error("restart.delete", message, help));
    }
    in_contact(job, &laws, findings);
    let place: HashMap<NodeId, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let mut space = BeltSpace { job, place, lengths: HashMap::new(), findings };
    space.read_lengths(&elements);
    let paths = space.paths(&elements, &laws);
    let mut system = BeltSystem {
        laws: parts.iter().map(|(_, belt)| law(belt)).collect(),
        paths,
        ..BeltSystem::default()
    };
    devices::resolve(&mut system, &mut space, sets);
    space.check_lengths(&mut system);
    for element in &elements {
        let law = parts[laws[&element.part]].1;
        let mass = 0.5 * law.mass_per_length * space.length(element);
        for node in element.corners() {
            if let Some(n) = sets.place(*node) {
                nodes.added_mass[n] += mass;
            }
        }
    }
    system
}

fn law(belt: &BeltInput) -> BeltLaw {
    BeltLaw {
        loading: belt.force_strain.clone(),
        unloading: belt.unloading.clone(),
        damping: belt.damping,
        min_length: belt.min_length,
    }
}

/// Warns of belts that the job names for contact.
fn in_contact(job: &Job, laws: &HashMap<u32, usize>, findings: &mut JobProblems) {
    let Some(contact) = &job.contact else { return };
    for (i, one) in contact.each().enumerate() {
        let path = if i == 0 { "contact".into() } else { format!("contact.interface.{}", i - 1) };
        for (key, parts) in [("parts", &one.parts), ("against", &one.against)] {
            if let Some(part) = parts.iter().find(|part| laws.contains_key(part)) {
                let message = format!("part {part} is a seat belt, which takes no part in contact");
                let help = "remove it here; lead the belt over bodies by [[belts.ring]]";
                findings.add(Problem::warning(format!("{path}.{key}"), message, help));
            }
        }
    }
}

/// Marks the nodes that nothing but their belt moves: they may pass rings and go into retractors.
pub fn loosen(settings: &mut Settings, mesh: &Mesh, sets: &NodeSets<'_>, nodes: &NodeStart) {
    if settings.belts.is_empty() {
        return;
    }
    let belts: HashSet<ElemId> =
        settings.belts.paths.iter().flat_map(|path| &path.segments).map(|s| s.element).collect();
    let others = mesh.elements.iter().filter(|e| !belts.contains(&e.id));
    let mut held: HashSet<NodeId> = others.flat_map(|e| e.corners()).copied().collect();
    held.extend(settings.rigid.iter().flat_map(|body| &body.nodes));
    for tie in &settings.ties {
        held.insert(tie.node);
        held.extend(tie.partners());
    }
    held.extend(settings.loads.motions.iter().flat_map(|motion| &motion.nodes));
    held.extend(settings.loads.forces.iter().flat_map(|load| &load.nodes));
    held.extend(settings.walls.iter().filter_map(|wall| wall.nodes.as_ref()).flatten());
    let mut seen: HashSet<NodeId> = HashSet::new();
    let of_paths = settings.belts.paths.iter().flat_map(|path| &path.nodes);
    held.extend(of_paths.filter(|node| !seen.insert(**node)));
    held.extend(settings.belts.rings.iter().map(|ring| ring.node));
    held.extend(settings.belts.retractors.iter().map(|retractor| retractor.node));
    let ends = settings.belts.paths.iter().flat_map(|path| {
        let ends = [path.nodes.first(), path.nodes.last()];
        let is_reel = |n: &&NodeId| {
            settings.belts.retractors.iter().any(|r| {
                path.nodes.contains(&r.node) && (r.before == (path.nodes.first() == Some(*n)))
            })
        };
        ends.into_iter().flatten().filter(|n| !is_reel(n)).copied().collect::<Vec<_>>()
    });
    held.extend(ends.collect::<Vec<_>>());
    for path in &mut settings.belts.paths {
        let is_loose = |id: &NodeId| {
            let fixed = sets.place(*id).is_none_or(|n| nodes.fixed[n] & 0b111 != 0);
            !held.contains(id) && !fixed
        };
        path.loose = path.nodes.iter().map(is_loose).collect();
    }
}

/// The belts of a job under examination.
struct BeltSpace<'a> {
    job: &'a Job,
    /// Coordinates of the nodes [length].
    place: HashMap<NodeId, [f64; 3]>,
    /// Unstretched lengths that the job gives, by labels of elements [length].
    lengths: HashMap<u64, f64>,
    findings: &'a mut JobProblems,
}

impl BeltSpace<'_> {
    fn fault(&mut self, path: impl Into<String>, message: String, help: impl Into<String>) {
        self.findings.add(Problem::error(path.into(), message, help.into()));
    }

    /// Reads `belts.unstretched`.
    fn read_lengths(&mut self, elements: &[&MeshElement]) {
        let known: HashSet<u64> = elements.iter().map(|e| e.id.label()).collect();
        for (k, &[id, length]) in self.job.belts.unstretched.iter().enumerate() {
            let path = format!("belts.unstretched.{k}");
            if !(id >= 0.0 && id.fract() == 0.0 && known.contains(&(id as u64))) {
                let help = "give ids of elements of parts with [part.belt]";
                self.fault(path, format!("no element {id} belongs to a belt"), help);
            } else if !(length > 0.0 && length.is_finite()) {
                let message = format!("the unstretched length of element {id} is {length}");
                self.fault(path, message, "give a length above 0");
            } else {
                self.lengths.insert(id as u64, length);
            }
        }
    }

    /// Returns the distance of two nodes [length].
    fn distance(&self, a: NodeId, b: NodeId) -> f64 {
        let (a, b) = (self.place[&a], self.place[&b]);
        (0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt()
    }

    /// Returns the unstretched length of an element [length].
    fn length(&self, element: &MeshElement) -> f64 {
        let [a, b, ..] = element.nodes;
        self.lengths.get(&element.id.label()).copied().unwrap_or_else(|| self.distance(a, b))
    }

    /// Returns the paths of all elements: chains that end at nodes with one element, or with three
    /// and more.
    fn paths(&mut self, elements: &[&MeshElement], laws: &HashMap<u32, usize>) -> Vec<BeltPath> {
        let mut at: BTreeMap<NodeId, Vec<usize>> = BTreeMap::new();
        for (k, element) in elements.iter().enumerate() {
            element.corners().iter().for_each(|n| at.entry(*n).or_default().push(k));
        }
        let mut used = vec![false; elements.len()];
        let mut paths = Vec::new();
        for first in 0..elements.len() {
            let ends = [elements[first].nodes[0], elements[first].nodes[1]];
            let Some(end) = ends.into_iter().find(|n| at[n].len() != 2) else { continue };
            if used[first] {
                continue;
            }
            let mut path = BeltPath { nodes: vec![end], ..BeltPath::default() };
            let (mut node, mut next) = (end, Some(first));
            while let Some(k) = next {
                used[k] = true;
                let element = elements[k];
                let [a, b, ..] = element.nodes;
                node = if a == node { b } else { a };
                path.nodes.push(node);
                path.segments.push(BeltSegment {
                    element: element.id,
                    law: laws[&element.part],
                    length: self.length(element),
                });
                next = at[&node].iter().copied().find(|&k| !used[k] && at[&node].len() == 2);
            }
            path.loose = vec![false; path.nodes.len()];
            paths.push(path);
        }
        if let Some(k) = used.iter().position(|used| !used) {
            let message = format!("the belt with element {} is a closed loop", elements[k].id);
            self.fault("mesh", message, "give it two ends, which may be at the same place");
        }
        paths
    }

    /// Sets the lengths of wound up segments to zero, and checks those of all others.
    fn check_lengths(&mut self, system: &mut BeltSystem) {
        for (index, path) in system.paths.iter_mut().enumerate() {
            let mut wound = vec![false; path.segments.len()];
            for reel in system.retractors.iter().filter(|r| r.path == index) {
                let place = path.nodes.iter().position(|n| *n == reel.node).unwrap_or(0);
                let inside = if reel.before { 0..place } else { place..path.segments.len() };
                inside.for_each(|k| wound[k] = true);
            }
            for (segment, wound) in path.segments.iter_mut().zip(wound) {
                let (id, length) = (segment.element, segment.length);
                let least = system.laws[segment.law].min_length;
                if wound && length > 0.0 {
                    segment.length = 0.0;
                } else if wound || length == 0.0 {
                    let message = format!("element {id} of a belt has no length");
                    let help = "give its length in `belts.unstretched`, move its nodes apart, or \
                                put a [[belts.retractor]] at its end";
                    self.fault("mesh", message, help);
                } else if length < least * (1.0 - SLACK) {
                    let message = format!(
                        "element {id} of a belt has the unstretched length {length:.4e}, below \
                         its min_length {least:.4e}"
                    );
                    let help = "reduce `belt.min_length` of its part, which reduces the step, or \
                                use longer elements";
                    self.fault("mesh", message, help);
                }
            }
        }
    }
}
