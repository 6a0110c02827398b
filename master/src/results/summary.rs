//! `summary.json`: the outcome of a run.

use crate::input::connectivity::{ConnectedPiece, pieces};
use crate::results::figures::{CrushFigures, HeadInjuryFigures};
use crate::results::steering::SteeringRecord;
use crate::results::warnings::EngineeringWarning;
use crumple_proto::exit_code::{COMPLETED, FAILED, STOPPED, UNMET};
use crumple_proto::job::{Job, Part, WallInput};
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::NodeRecord;
use crumple_proto::report::{FinalReport, PHASES, PartRecord};
use crumple_worker::fem::elements::points_of;
use crumple_worker::vtu;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;
use std::path::Path;

/// End of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunEnd {
    /// The run reached its end.
    #[default]
    Completed,
    /// The user stopped the run; the state is kept.
    Stopped,
    /// The run could not continue.
    Failed,
}

impl RunEnd {
    /// Returns the exit code of a run that ended in this way and meets its requirements.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Completed => COMPLETED,
            Self::Stopped => STOPPED,
            Self::Failed => FAILED,
        }
    }
}

/// Mean and maximum over workers [s].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct MeanMax {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
}

/// Energies at the end [energy].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct EnergySummary {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Internal energy.
    pub internal: f64,
    /// Work of contact on the nodes, friction included.
    pub contact: f64,
    /// Part of `contact` that is work of friction.
    pub friction: f64,
    /// Part of `contact` from pairs that started inside the contact thickness, as long as they
    /// have not separated.
    pub contact_starting: f64,
    /// Work of rigid walls on the nodes, and of nodes on walls with a mass, friction included.
    pub wall: f64,
    /// Work of friction on rigid walls, in the motion relative to them.
    pub wall_friction: f64,
    /// Hourglass and drilling energy.
    pub hourglass: f64,
    /// Work of external loads.
    pub external: f64,
    /// Kinetic, internal and hourglass energy at the start.
    pub total_initial: f64,
    /// Energy error at the end, as a fraction.
    pub error: f64,
    /// Largest |error| of all history rows.
    pub error_max: f64,
    /// Largest energy that contact has created, as a fraction of the largest energy so far.
    pub contact_created: f64,
}

/// Linear momentum [mass length/time].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct LinearMomentum {
    /// At the start.
    pub start: [f64; 3],
    /// At the end.
    pub end: [f64; 3],
    /// Impulse of all rigid walls.
    pub wall_impulse: [f64; 3],
}

/// Step sizes [time].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Steps {
    /// First.
    pub first: f64,
    /// Smallest.
    pub min: f64,
    /// Last.
    pub last: f64,
}

/// Number of redecompositions.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Redecompositions {
    /// Repartitions, with new boxes.
    pub low: u64,
    /// Membership updates.
    pub high: u64,
    /// Updates of the contact surface because elements have failed; the master does not order them.
    pub erosion: u64,
}

/// Limits at which the master orders a redecomposition.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct RedecompositionThresholds {
    /// Share of the margin used by the displacement of a worker: *high*.
    pub margin: f64,
    /// Imbalance: *low*.
    pub imbalance: f64,
}

/// Elements by class at the end, worker by worker.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ElementClasses {
    /// Own elements in the internal box.
    pub interior: Vec<u64>,
    /// Own elements in the buffer.
    pub interface: Vec<u64>,
    /// Ghost elements.
    pub exterior: Vec<u64>,
    /// Half the width of the buffer at the last renewal [length].
    pub half_buffer: f64,
}

/// Returns the elements by class.
pub fn classes(closings: &[FinalReport]) -> ElementClasses {
    let of = |class: usize| closings.iter().map(|c| c.classes[class]).collect();
    let half_buffer = closings.first().map_or(0.0, |c| c.half_buffer);
    ElementClasses { interior: of(0), interface: of(1), exterior: of(2), half_buffer }
}

/// Contact statistics.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ContactSummary {
    /// Largest number of active pairs in a history row.
    pub pairs_max: u64,
    /// Largest penetration as a fraction of the pair's contact thickness.
    pub penetration_max: f64,
    /// Global searches, mean over workers.
    pub searches: f64,
    /// Sweeps per cycle, mean over workers.
    pub sweeps_per_cycle: f64,
    /// Number of steps with accelerated sweeps: the largest of any worker. Where pairs are few, a
    /// worker counts the steps in which it has nodes of pairs.
    pub accelerated_steps: u64,
    /// Number of steps that ended before the forces of all pairs had converged, counted alike.
    pub unsettled_steps: u64,
    /// Number of pairs with a penalty stiffness lowered for stability, mean over cycles.
    pub capped_per_cycle: f64,
}

/// CPU time of the workers without waiting, each summed over its threads [s]. Redecompositions are
/// in neither sum over cycles.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Cpu {
    /// Sum over cycles and workers.
    pub total: f64,
    /// Sum over cycles of the largest time of a worker without contact, plus the largest of
    /// contact.
    pub critical_path: f64,
    /// Redecompositions, maximum over workers.
    pub renewal: f64,
    /// Messages sent per worker and cycle.
    pub messages_per_cycle: f64,
    /// Bytes sent per worker and cycle.
    pub bytes_per_cycle: f64,
}

/// Continuation of a run from a checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RestartSummary {
    /// Cycle from which it continued.
    pub cycle: u64,
    /// Simulated time from which it continued [time].
    pub time: f64,
    /// Number of workers from there on.
    pub workers: usize,
    /// Transport from there on.
    pub transport: String,
    /// Changes of the job, as `key=value`.
    pub changes: Vec<String>,
}

/// Number and cost of the checkpoints of a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct CheckpointSummary {
    /// Number of checkpoints written by this process.
    pub written: u64,
    /// Size of the last one [byte].
    pub bytes: u64,
    /// Time for which the slowest worker did not advance, sum over checkpoints [s].
    pub copy_s: f64,
    /// Time for which the slowest worker wrote while it advanced, sum over checkpoints [s].
    pub write_s: f64,
}

/// A part: its settings, and its results.
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
    /// Number of elements without the failed ones.
    pub elements: u64,
    /// Number of failed elements.
    #[serde(default)]
    pub failed: u64,
    /// Number of failed elements that were inverted shells, which `inverted = "delete"` of the
    /// part deletes.
    #[serde(default)]
    pub inverted: u64,
    /// Largest effective plastic strain at the end.
    pub plastic_strain_max: f64,
    /// Largest von Mises stress at the end [force/length^2]. It may have been larger before.
    pub von_mises_end: f64,
    /// Largest difference of effective plastic strain between elements that share a node, at the
    /// end. Elements of different workers are not compared.
    pub strain_jump: f64,
    /// Largest difference of von Mises stress between such elements [force/length^2].
    pub stress_jump: f64,
    /// Formulation of its four-node shells or its solids, if the job names one.
    pub element: String,
    /// Work of its stresses [energy].
    pub internal: f64,
    /// Work of its hourglass control and drilling stiffness [energy].
    pub hourglass: f64,
    /// Its connected pieces.
    pub pieces: Vec<ConnectedPiece>,
    /// True if it belongs to a rigid body.
    pub rigid: bool,
    /// True if it was ever within contact reach and skin of another surface; none without
    /// contact.
    pub contact_near: Option<bool>,
    /// True if it ever had a contact pair; none without contact.
    pub contact_pairs: Option<bool>,
}

/// Returns the results of the parts over all workers. `parts` are those of the settings; workers
/// report in their order.
pub fn parts(
    job: &Job,
    outline: &MeshOutline,
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
            points: points_of(part),
            elements: all.elements,
            failed: all.failed,
            inverted: all.inverted,
            plastic_strain_max: all.plastic_strain,
            von_mises_end: all.von_mises,
            strain_jump: all.strain_jump,
            stress_jump: all.stress_jump,
            element: part.element.clone().unwrap_or_default(),
            internal: all.internal.value(),
            hourglass: all.hourglass.value(),
            pieces: outline.pieces.get(&part.id).cloned().unwrap_or_default(),
            rigid: job.rigid.iter().any(|r| r.parts.contains(&part.id)),
            contact_near: job.contact.as_ref().map(|_| all.near),
            contact_pairs: job.contact.as_ref().map(|_| all.touched),
        }
    };
    parts.iter().enumerate().map(of).collect()
}

/// Data of a mesh for the summary.
pub struct MeshOutline {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements by shape.
    pub elements: BTreeMap<String, usize>,
    /// See [`pieces()`].
    pub pieces: BTreeMap<u32, Vec<ConnectedPiece>>,
}

impl MeshOutline {
    /// Collects the data of this mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let mut elements = BTreeMap::new();
        for alike in mesh.elements.chunk_by(|a, b| a.shape == b.shape) {
            *elements.entry(format!("{:?}", alike[0].shape).to_lowercase()).or_insert(0) +=
                alike.len();
        }
        Self { nodes: mesh.nodes.len(), elements, pieces: pieces(mesh) }
    }
}

/// Division of shells in a run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AdaptivitySummary {
    /// Number of shells that were divided into four, with quarters that were divided again.
    pub divided: u64,
    /// Number of elements at the end.
    pub elements: u64,
    /// Number of nodes at the end.
    pub nodes: usize,
}

/// The whole file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Title of the job.
    pub title: String,
    /// Units of the job, as it states them.
    pub units: String,
    /// End of the run.
    pub status: RunEnd,
    /// Reason of the end.
    pub reason: String,
    /// Simulated time reached [time].
    pub end_time: f64,
    /// Number of cycles.
    pub cycles: u64,
    /// Number of nodes at the start.
    pub nodes: usize,
    /// Number of elements per type at the start.
    pub elements: BTreeMap<String, usize>,
    /// Number of workers.
    pub workers: usize,
    /// Number of threads of each worker.
    pub threads: usize,
    /// `threads` or `mpi`.
    pub transport: String,
    /// Wall time of the run [s].
    pub wall_s: f64,
    /// Wall time x workers x threads per element and cycle [ns].
    pub grind_ns: f64,
    /// Wall time per phase [s].
    pub phase_s: BTreeMap<String, MeanMax>,
    /// CPU time.
    pub cpu_s: Cpu,
    /// Energies.
    pub energy: EnergySummary,
    /// Momentum.
    pub momentum: LinearMomentum,
    /// Step sizes.
    pub dt: Steps,
    /// Redecompositions.
    pub redecompositions: Redecompositions,
    /// Limits at which the master orders them.
    pub thresholds: RedecompositionThresholds,
    /// Elements by class.
    pub classes: ElementClasses,
    /// Critical path over the mean CPU time of the workers.
    pub imbalance: MeanMax,
    /// Contact.
    pub contact: ContactSummary,
    /// Unsupported content of the deck that the run ignored, with file and line; see
    /// `--allow-unsupported`.
    pub unsupported: Vec<String>,
    /// Parts, by ascending id.
    pub parts: Vec<PartSummary>,
    /// Rigid walls of the job.
    pub walls: Vec<WallInput>,
    /// Division of shells, if the job asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptivity: Option<AdaptivitySummary>,
    /// Continuations from checkpoints.
    pub restarts: Vec<RestartSummary>,
    /// Orders of users, with the cycles in which they took effect; `crumple run --steering` repeats
    /// them.
    pub steering: Vec<SteeringRecord>,
    /// Checkpoints of the process that ended the run.
    pub checkpoints: CheckpointSummary,
    /// Rows of histories that are lost because a file was removed.
    pub lost: Vec<String>,
    /// Engineering warnings, in the order in which they were found. The file also has the message
    /// of each.
    #[serde(serialize_with = "with_messages")]
    pub warnings: Vec<EngineeringWarning>,
    /// Crush figures of each force, if an object moves.
    pub crush: Vec<CrushFigures>,
    /// Names of the node groups of heads.
    pub heads: Vec<String>,
    /// Head injury criteria of the nodes of heads.
    pub head_injury: Vec<HeadInjuryFigures>,
    /// Requirements of the job, if the run is complete.
    pub requirements: Vec<RequirementResult>,
    /// blake3 hash of the state; see [`state_digest`].
    pub state_digest: String,
}

/// Warning in the file, with the line that the program prints.
#[derive(Serialize)]
struct WarningWithMessage<'a> {
    #[serde(flatten)]
    warning: &'a EngineeringWarning,
    message: String,
}

fn with_messages<S: Serializer>(warnings: &[EngineeringWarning], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(
        warnings.iter().map(|one| WarningWithMessage { warning: one, message: one.line() }),
    )
}

impl Summary {
    /// Returns the exit code of the run.
    pub fn exit_code(&self) -> u8 {
        let is_met = self.requirements.iter().all(|one| one.is_met);
        if is_met { self.status.exit_code() } else { UNMET }
    }

    /// Writes the file as a whole.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        vtu::write_whole(path, |out| out.write_all(text.as_bytes()))
    }
}

/// A requirement, and the value that the run has.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RequirementResult {
    /// Name of the requirement.
    pub name: String,
    /// Value; none if it cannot be read from the results.
    pub value: Option<f64>,
    /// Unit of value and limits; empty if it is not known.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Time of the row with the value, if it is the smallest or largest one [time].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Unit of that time.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit_of_time: String,
    /// Largest value that meets the requirement.
    pub below: Option<f64>,
    /// Smallest value that meets the requirement.
    pub above: Option<f64>,
    /// True if the value meets the requirement.
    pub is_met: bool,
    /// Why there is no value; empty if there is one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
}

impl RequirementResult {
    /// Returns the requirement as a line for the log.
    pub fn line(&self) -> String {
        let verdict = if self.is_met { "PASS" } else { "FAIL" };
        let value = match self.value {
            Some(value) => format!("{value:.6e}{}", self.suffix()),
            None => self.why.clone(),
        };
        format!("{verdict}  {}: {value} (required: {})", self.name, self.limits())
    }

    /// Returns what follows the value: its unit and the time of an extreme.
    pub fn suffix(&self) -> String {
        let spaced = |word: &str| if word.is_empty() { String::new() } else { format!(" {word}") };
        let time = self.time.map(|t| format!(" at time {t:.4e}{}", spaced(&self.unit_of_time)));
        spaced(&self.unit) + &time.unwrap_or_default()
    }

    /// Returns the limits as text.
    pub fn limits(&self) -> String {
        let limit = |word: &str, limit: Option<f64>| limit.map(|l| format!("{word} {l}"));
        let limits = [limit("below", self.below), limit("above", self.above)];
        limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// Returns the blake3 hash (hex) of the little-endian f64 bits of position, velocity and
/// rotational velocity of all nodes, by ascending label. A node without rotational inertia has no
/// rotational velocity.
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

/// Returns the names of the parts that have one in the summary of a run, by their ids.
pub fn part_names(dir: &Path) -> BTreeMap<u32, String> {
    let text = std::fs::read_to_string(dir.join("summary.json")).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let name = |part: &serde_json::Value| {
        let name = part["name"].as_str().filter(|name| !name.is_empty())?;
        Some((u32::try_from(part["id"].as_u64()?).ok()?, name.to_string()))
    };
    summary["parts"].as_array().into_iter().flatten().filter_map(name).collect()
}

/// Returns the wall time per phase over workers [s].
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
