//! Conditions of particles: what a job with particles cannot have yet.

use super::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use std::collections::HashSet;

/// Reports what particles cannot be combined with.
pub fn check(job: &Job, mesh: &Mesh, settings: &Settings, findings: &mut JobProblems) {
    let is_particle = |shape: Shape| shape == Shape::Point1;
    let of_particles: HashSet<NodeId> =
        mesh.elements.iter().filter(|e| is_particle(e.shape)).map(|e| e.nodes[0]).collect();
    if of_particles.is_empty() {
        return;
    }
    if settings.subcycles > 1 {
        let help = "remove time.subcycles: the forces of particles are computed in every cycle";
        findings.add(Problem::error("time.subcycles", "particles have no subcycles", help));
    }
    if settings.has_second_decomposition() {
        let message = "the second decomposition of contact does not know particles";
        findings.add(Problem::error("parallel.contact", message, "use \"boxes\", the default"));
    }
    let mut seen = HashSet::new();
    let mut shared = mesh.elements.iter().filter(|e| match is_particle(e.shape) {
        true => !seen.insert(e.nodes[0]),
        false => e.corners().iter().any(|n| of_particles.contains(n)),
    });
    if let Some(first) = shared.next() {
        let message = format!(
            "{} elements have the node of a particle; the first is element {}",
            1 + shared.count(),
            first.id
        );
        findings.add(Problem::error("mesh", message, "give each particle a node of its own"));
    }
    for (i, rigid) in job.rigid.iter().enumerate() {
        let part = |id: &&u32| job.part.iter().any(|p| p.id == **id && p.particles.is_some());
        if let Some(id) = rigid.parts.iter().find(part) {
            let message = format!("part {id} has particles and cannot be rigid");
            findings.add(Problem::error(format!("rigid.{i}.parts"), message, "remove it"));
        }
    }
}
