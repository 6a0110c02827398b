//! `summary.json`: how a run went.

use crate::analysis::connectivity::{Piece, pieces};
use crumple_proto::job::{Job, Part, Wall};
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::NodeRecord;
use crumple_proto::report::{FinalReport, PHASES, PartRecord};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// It reached its end.
    #[default]
    Completed,
    /// The user stopped it; the state is kept.
    Stopped,
    /// It could not go on.
    Failed,
}

/// Mean and largest over workers [s].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct MeanMax {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// Energies at the end [energy].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Energy {
    /// Kinetic.
    pub kinetic: f64,
    /// Internal.
    pub internal: f64,
    /// Work of contact on the nodes, friction included.
    pub contact: f64,
    /// Part of `contact` that friction did.
    pub friction: f64,
    /// Part of `contact` that pairs did that started inside each other's thickness, as long as they
    /// had not come apart.
    pub contact_starting: f64,
    /// Work of rigid walls on the nodes, and of these on walls that have a mass, friction included.
    pub wall: f64,
    /// Hourglass and drilling.
    pub hourglass: f64,
    /// Work of external loads.
    pub external: f64,
    /// Kinetic, internal and hourglass at the start.
    pub total_initial: f64,
    /// Unexplained at the end, a fraction.
    pub error: f64,
    /// Largest |error| of all history rows.
    pub error_max: f64,
    /// Most energy that contact has created, as a fraction of the most that there was.
    pub contact_created: f64,
}

/// Linear momentum [mass length/time].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Momentum {
    /// At the start.
    pub start: [f64; 3],
    /// At the end.
    pub end: [f64; 3],
    /// Impulse of all rigid walls.
    pub wall_impulse: [f64; 3],
}

/// Steps [time].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Steps {
    /// First.
    pub first: f64,
    /// Smallest.
    pub min: f64,
    /// Last.
    pub last: f64,
}

/// Redecompositions.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Redecompositions {
    /// Boxes recomputed.
    pub low: u64,
    /// Membership renewed.
    pub high: u64,
}

/// Contact.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ContactSummary {
    /// Most active pairs in a history row.
    pub pairs_max: u64,
    /// Largest penetration as a fraction of the pair's contact thickness.
    pub penetration_max: f64,
    /// Global searches, mean over workers.
    pub searches: f64,
    /// Sweeps per cycle, mean over workers.
    pub sweeps_per_cycle: f64,
    /// Steps with accelerated sweeps.
    pub accelerated_steps: u64,
    /// Steps that ended before the forces of all pairs were good enough.
    pub unsettled_steps: u64,
    /// Pairs whose penalty stiffness was lowered so that the step stays stable, mean over cycles.
    pub capped_per_cycle: f64,
}

/// CPU accounting of the workers, waiting left out; renewals are in neither sum of cycles [s].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Cpu {
    /// Sum over workers.
    pub total: f64,
    /// Sum over cycles of the slowest worker.
    pub critical_path: f64,
    /// Renewals of boxes and membership, the worker with most.
    pub renewal: f64,
    /// Messages sent per worker and cycle.
    pub messages_per_cycle: f64,
    /// Bytes sent per worker and cycle.
    pub bytes_per_cycle: f64,
}

/// A part: what it was given, and what it needed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PartSummary {
    /// Id.
    pub id: u32,
    /// Name.
    pub name: String,
    /// Law of its material.
    pub law: String,
    /// Name of its material.
    pub material: String,
    /// Integration points through the thickness.
    pub points: usize,
    /// Elements, without those that have failed.
    pub elements: u64,
    /// Elements that have failed.
    #[serde(default)]
    pub failed: u64,
    /// Those of them that were shells that were inverted, which `inverted = "delete"` of the part
    /// lets fail.
    #[serde(default)]
    pub inverted: u64,
    /// Largest effective plastic strain at the end.
    pub plastic_strain_max: f64,
    /// Largest von Mises stress at the end [force/length^2]; it may have been larger before.
    pub von_mises_end: f64,
    /// Largest difference of effective plastic strain between elements with a node in common, at
    /// the end; elements of different workers are not compared.
    pub strain_jump: f64,
    /// The same of von Mises stress [force/length^2].
    pub stress_jump: f64,
    /// Formulation of its four-node shells or its solids, if the job names one.
    pub element: String,
    /// Work of its stresses [energy].
    pub internal: f64,
    /// Work of its hourglass control and drilling stiffness [energy].
    pub hourglass: f64,
    /// Its connected pieces.
    pub pieces: Vec<Piece>,
    /// Whether it belongs to a rigid body.
    pub rigid: bool,
    /// Whether it ever came within contact reach and skin of anything; none without contact.
    pub contact_near: Option<bool>,
    /// Whether it ever had a contact pair; none without contact.
    pub contact_pairs: Option<bool>,
}

/// What became of the parts, over all workers; `parts` are those of the settings, in whose order
/// workers report.
pub fn parts(
    job: &Job,
    outline: &Outline,
    parts: &[Part],
    closings: &[FinalReport],
) -> Vec<PartSummary> {
    let of = |(number, part): (usize, &Part)| {
        let mut all = PartRecord::default();
        closings.iter().filter_map(|c| c.parts.get(number)).for_each(|p| all.add(p));
        let law = job
            .material
            .iter()
            .find(|m| m.name == part.material)
            .map_or(String::new(), |m| m.law.clone());
        PartSummary {
            id: part.id,
            name: part.name.clone(),
            law,
            material: part.material.clone(),
            points: if part.thickness > 0.0 { part.points } else { 1 }, // only shells have more
            elements: all.elements,
            failed: all.failed,
            inverted: all.inverted,
            plastic_strain_max: all.plastic_strain,
            von_mises_end: all.von_mises,
            strain_jump: all.strain_jump,
            stress_jump: all.stress_jump,
            element: part.element.clone().unwrap_or_default(),
            internal: all.internal,
            hourglass: all.hourglass,
            pieces: outline.pieces.get(&part.id).cloned().unwrap_or_default(),
            rigid: job.rigid.iter().any(|r| r.parts.contains(&part.id)),
            contact_near: job.contact.as_ref().map(|_| all.near),
            contact_pairs: job.contact.as_ref().map(|_| all.touched),
        }
    };
    parts.iter().enumerate().map(of).collect()
}

/// What the summary tells of a mesh.
pub struct Outline {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements by shape.
    pub elements: BTreeMap<String, usize>,
    /// See [`pieces()`].
    pub pieces: BTreeMap<u32, Vec<Piece>>,
}

impl Outline {
    /// Of this mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let mut elements = BTreeMap::new();
        for e in &mesh.elements {
            *elements.entry(format!("{:?}", e.shape).to_lowercase()).or_insert(0) += 1;
        }
        Self { nodes: mesh.nodes.len(), elements, pieces: pieces(mesh) }
    }
}

/// The whole file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// What the scene is, as the job says.
    pub title: String,
    /// Units of the job, as it says.
    pub units: String,
    /// How it ended.
    pub status: Status,
    /// Why.
    pub reason: String,
    /// Simulated time reached [time].
    pub end_time: f64,
    /// Cycles done.
    pub cycles: u64,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements per type.
    pub elements: BTreeMap<String, usize>,
    /// Number of workers.
    pub workers: usize,
    /// `threads` or `mpi`.
    pub transport: String,
    /// Wall time of the run [s].
    pub wall_s: f64,
    /// Nanoseconds of wall time x workers per element per cycle.
    pub grind_ns: f64,
    /// Wall time per phase [s].
    pub phase_s: BTreeMap<String, MeanMax>,
    /// CPU accounting.
    pub cpu_s: Cpu,
    /// Energies.
    pub energy: Energy,
    /// Momentum.
    pub momentum: Momentum,
    /// Steps.
    pub dt: Steps,
    /// Redecompositions.
    pub redecompositions: Redecompositions,
    /// max/mean step cost over workers.
    pub imbalance: MeanMax,
    /// Contact.
    pub contact: ContactSummary,
    /// What the deck has and the run went on without, with file and line; see
    /// `--allow-unsupported`.
    pub unsupported: Vec<String>,
    /// Parts, in ascending id.
    pub parts: Vec<PartSummary>,
    /// Rigid walls of the job.
    pub walls: Vec<Wall>,
    /// blake3 of the state; see [`state_digest`].
    pub state_digest: String,
}

/// blake3 (hex) of the little-endian f64 bits of, per node in ascending label, position, velocity
/// and rotational velocity. A node without rotational inertia has no rotational velocity.
pub fn state_digest(nodes: &mut [NodeRecord]) -> String {
    nodes.sort_unstable_by_key(|n| n.id.label());
    let mut hasher = blake3::Hasher::new();
    for n in nodes {
        let turning: &[f64] = if n.inertia > 0.0 { &n.w } else { &[] };
        for a in n.x.iter().chain(&n.v).chain(turning) {
            hasher.update(&a.to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// Seconds per phase over workers.
pub fn phases(closings: &[FinalReport]) -> BTreeMap<String, MeanMax> {
    let of = |p: usize| {
        let seconds = closings.iter().map(|c| c.phases[p]);
        MeanMax {
            mean: seconds.clone().sum::<f64>() / closings.len().max(1) as f64,
            max: seconds.fold(0.0, f64::max),
        }
    };
    PHASES.iter().enumerate().map(|(p, name)| (name.to_string(), of(p))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::NodeId;

    #[test]
    fn the_digest_does_not_depend_on_the_order_and_feels_every_bit() {
        let node = |id, x: f64| NodeRecord {
            id: NodeId(id),
            x: [x, 0.0, 0.0],
            inertia: 1.0,
            ..Default::default()
        };
        let a = state_digest(&mut [node(1, 1.0), node(2, 2.0)]);
        assert_eq!(a, state_digest(&mut [node(2, 2.0), node(1, 1.0)]));
        assert_ne!(a, state_digest(&mut [node(1, 1.0), node(2, 2.0 + 4e-16)]));
    }
}
