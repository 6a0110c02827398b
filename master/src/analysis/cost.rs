//! Cost of a scene: bytes and nanoseconds of elements, nodes and contact, by the features in use.
//!
//! Both are measured on engines with some hundred neighbouring elements of each part, or some
//! thousand for contact, set up from the job as on a worker. Bytes are those of the columns of
//! these engines. Times are the shortest of a few steps of the initial mesh, with unstrained
//! elements computed like all others. A step takes longer in motion, with a cold cache or on a
//! busy machine.

use crate::input::job::Model;
use crate::results::report::model_page::ExpectedCost;
use crumple_proto::belt::BeltSystem;
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::NodeId;
use crumple_proto::loads::ResolvedLoads;
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::report::Phase;
use crumple_proto::transport::{RankLost, threads};
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::BlockBytes;
use crumple_worker::parallel::migrate::item_bytes;
use crumple_worker::parallel::partition::PartitionData;
use crumple_worker::step::step;
use std::collections::HashMap;
use std::fmt::Write;

/// Number of elements of a part in a sample.
const SAMPLE: usize = 512;
/// Number of elements of a part in a sample for contact, so large that the free edges of the
/// sample have little influence.
const TOUCHING: usize = 4096;
/// Number of timed steps.
const STEPS: usize = 20;

/// A sample in an engine.
struct CostSample {
    elements: usize,
    /// Number of lane slots that the elements take.
    lanes: usize,
    nodes: usize,
    blocks: BlockBytes,
    /// Translational and rotational.
    columns: [usize; 2],
    contact: usize,
    /// Bytes of an element, a node and a pair history in a checkpoint.
    saved: [usize; 3],
    /// Shortest time of each phase [s].
    elements_s: f64,
    assemble_s: f64,
    advance_s: f64,
    /// Local search and enforcement, with the pairs of the initial mesh [s].
    contact_s: f64,
    /// First global search [s].
    search_s: f64,
}

/// Returns the tables that `crumple check` prints for `workers` workers, and the cost of the run;
/// memory and time are 0 if they cannot be estimated.
pub fn describe(model: &Model, workers: usize) -> (String, ExpectedCost) {
    let cycles = (model.settings.end_time / model.first_dt().0).ceil();
    let cycles = match model.settings.max_cycles {
        0 => cycles,
        most => cycles.min(most as f64),
    };
    let mut out = String::new();
    // Writing to a string cannot fail.
    let (memory_mb, cycle_s) = write(model, workers, &mut out).unwrap_or_else(|_| {
        out.push_str("\nno costs: the sample cannot be set up\n");
        (0.0, 0.0)
    });
    (out, ExpectedCost { workers, cycles, cycle_s, memory_mb })
}

/// A model as records, with its nodes by id.
struct ModelRecords<'a> {
    model: &'a Model,
    elements: &'a [ElementRecord],
    nodes: &'a [NodeRecord],
    record: HashMap<NodeId, &'a NodeRecord>,
}

impl<'a> ModelRecords<'a> {
    fn new(model: &'a Model, (elements, nodes): &'a (Vec<ElementRecord>, Vec<NodeRecord>)) -> Self {
        let record = nodes.iter().map(|r| (r.id, r)).collect();
        Self { model, elements, nodes, record }
    }

    /// Selects a sample of a part, see [`pick`].
    fn pick(&self, part: u32, count: usize) -> Vec<ElementRecord> {
        pick(self.elements, part, count, &self.record)
    }

    /// Runs some steps with some elements, see [`try_out`].
    fn try_out(&self, elements: &[ElementRecord], contact: bool) -> Result<CostSample, RankLost> {
        try_out(&quiet(self.model, contact), elements, &self.record)
    }
}

/// Costs of a scene, added up over its parts, nodes and contact.
#[derive(Default)]
struct SceneCosts {
    bytes: f64,
    /// CPU time of a cycle [s].
    cycle_s: f64,
    /// Bytes of a node for translation and rotation.
    columns: [f64; 2],
    /// Largest time of a node in a cycle, over all parts [s].
    node_s: f64,
    /// Bytes of a checkpoint.
    saved: usize,
    /// Bytes of an element, a node and a pair history in a checkpoint.
    saved_items: [usize; 3],
}

/// Writes the tables. Returns the memory of the run [MB] and the CPU time of a cycle [s].
fn write(
    model: &Model,
    workers: usize,
    out: &mut String,
) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let records = model.records();
    let scene = ModelRecords::new(model, &records);
    let mut costs = SceneCosts::default();
    write_parts(&scene, &mut costs, out)?;
    write_nodes(&scene, &mut costs, out)?;
    write_contact(&scene, &mut costs, out)?;
    write_checkpoint(&scene, &mut costs, out)?;
    write_rates(model, out)?;
    Ok((write_totals(&scene, &costs, workers, out)?, costs.cycle_s))
}

/// Measures a sample of each part, and writes the table of parts.
fn write_parts(
    scene: &ModelRecords<'_>,
    costs: &mut SceneCosts,
    out: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut rows = String::new();
    for number in 0..scene.model.settings.parts.len() as u32 {
        let count = scene.elements.iter().filter(|e| e.part == number).count();
        if count > 0 {
            let sample = scene.try_out(&scene.pick(number, SAMPLE), false)?;
            write_part(scene, (number, count), &sample, costs, &mut rows)?;
        }
    }
    writeln!(
        out,
        "\ncost per cycle: bytes are exact, times are from {STEPS} steps of up to {SAMPLE} \
         elements of each part; bytes and times of contact are from up to {TOUCHING}"
    )?;
    writeln!(
        out,
        "  part                  elements   history  forces  moments  connectivity  ns/cycle"
    )?;
    out.push_str(&rows);
    Ok(())
}

/// Writes the row of a part with `count` elements.
fn write_part(
    scene: &ModelRecords<'_>,
    (number, count): (u32, usize),
    sample: &CostSample,
    costs: &mut SceneCosts,
    out: &mut String,
) -> std::fmt::Result {
    let settings = &scene.model.settings;
    let part = &settings.parts[number as usize];
    let per_element = |b: usize| b as f64 / sample.elements as f64;
    let blocks = &sample.blocks;
    let bytes = [blocks.history, blocks.force, blocks.moment, blocks.connectivity].map(per_element);
    let rigid = is_idle(scene.model, number);
    let ns = if rigid { 0.0 } else { 1e9 * sample.elements_s / sample.elements as f64 };
    let name = if part.name.is_empty() { part.id.to_string() } else { part.name.clone() };
    let rigid = if rigid { "  rigid or skin: no forces" } else { "" };
    let [history, force, moment, connectivity] = bytes;
    writeln!(
        out,
        "  {name:<20} {count:>9}  {history:>8.0} {force:>7.0} {moment:>8.0} \
         {connectivity:>13.0}  {ns:>8.1}{rigid}"
    )?;
    let cycles = |e: &ElementRecord| if e.slow { settings.subcycles as f64 } else { 1.0 };
    let elements = scene.elements.iter().filter(|e| e.part == number);
    let computed: f64 = elements.map(|e| 1.0 / cycles(e)).sum();
    costs.bytes += bytes.iter().sum::<f64>() * count as f64;
    costs.cycle_s += 1e-9 * ns * computed;
    costs.saved += sample.saved[0] * count;
    costs.saved_items = sample.saved;
    costs.node_s = costs.node_s.max((sample.assemble_s + sample.advance_s) / sample.nodes as f64);
    costs.columns = sample.columns.map(|b| b as f64 / sample.nodes as f64);
    Ok(())
}

fn write_nodes(
    scene: &ModelRecords<'_>,
    costs: &mut SceneCosts,
    out: &mut String,
) -> std::fmt::Result {
    let count = scene.nodes.len() as f64;
    let turning = if scene.model.settings.rotations { "" } else { " (no rotations)" };
    let [translation, rotation] = costs.columns;
    costs.bytes += (translation + rotation) * count;
    costs.cycle_s += costs.node_s * count;
    writeln!(
        out,
        "  per node: {translation:.0} bytes for translation, {rotation:.0} for rotation{turning}; \
         {:.1} ns/cycle for assembly, acceleration and motion",
        1e9 * costs.node_s
    )
}

/// Measures the contact of a sample of all parts, and writes its line.
fn write_contact(
    scene: &ModelRecords<'_>,
    costs: &mut SceneCosts,
    out: &mut String,
) -> Result<(), Box<dyn std::error::Error>> {
    let settings = &scene.model.settings;
    let Some(contact) = &settings.contact else {
        writeln!(out, "  contact: none, 0 bytes, 0 ns")?;
        return Ok(());
    };
    let parts = 0..settings.parts.len() as u32;
    let picked: Vec<ElementRecord> = parts.flat_map(|part| scene.pick(part, TOUCHING)).collect();
    let sample = scene.try_out(&picked, true)?;
    let per_element = |number: f64| number / sample.elements as f64;
    let (bytes, cycle_s) = (per_element(sample.contact as f64), per_element(sample.contact_s));
    let has_friction = contact.each().any(|c| c.friction > 0.0);
    let friction = if has_friction { "with friction" } else { "no friction" };
    writeln!(
        out,
        "  contact: {bytes:.0} bytes and {:.1} ns/cycle per element for the initial mesh, \
         {friction}; a global search, not in every cycle, {:.0} ns per element",
        1e9 * cycle_s,
        1e9 * per_element(sample.search_s)
    )?;
    costs.bytes += bytes * scene.elements.len() as f64;
    costs.cycle_s += cycle_s * scene.elements.len() as f64;
    Ok(())
}

/// Writes the lines of a checkpoint and of its copy in memory.
fn write_checkpoint(
    scene: &ModelRecords<'_>,
    costs: &mut SceneCosts,
    out: &mut String,
) -> std::fmt::Result {
    let [_, of_node, of_pair] = costs.saved_items;
    costs.saved += of_node * scene.nodes.len();
    writeln!(
        out,
        "  checkpoint: {:.1} MB without compression, {} bytes per element with its nodes; \
         {of_node} more for each further worker that has a node, {of_pair} for a contact pair at \
         each node that keeps it",
        1e-6 * costs.saved as f64,
        costs.saved / scene.elements.len().max(1)
    )?;
    if scene.model.job.checkpoint.copy_interval().unwrap_or_default().is_some() {
        writeln!(out, "  copy in memory (checkpoint.in_memory): as many bytes as a checkpoint")?;
        costs.bytes += costs.saved as f64;
    }
    Ok(())
}

/// Writes the totals of the run. Returns its memory [MB].
fn write_totals(
    scene: &ModelRecords<'_>,
    costs: &SceneCosts,
    workers: usize,
    out: &mut String,
) -> Result<f64, std::fmt::Error> {
    let master = (size_of_val(scene.elements) + size_of_val(scene.nodes)) as f64;
    let memory_mb = 1e-6 * (costs.bytes + master);
    writeln!(
        out,
        "  total: {memory_mb:.1} MB with {:.1} MB of the master, {:.1} MB per worker of {workers}",
        1e-6 * master,
        1e-6 * costs.bytes / workers as f64
    )?;
    let cycles = (scene.model.settings.end_time / scene.model.first_dt().0).ceil();
    writeln!(
        out,
        "  a cycle takes about {:.3} ms of CPU time, the run of at least {cycles:.0} cycles \
         {:.1} s, without plasticity and later contact",
        1e3 * costs.cycle_s,
        costs.cycle_s * cycles
    )?;
    Ok(memory_mb)
}

/// Names the materials whose strain rates are not part of the times.
fn write_rates(model: &Model, out: &mut String) -> std::fmt::Result {
    let rated =
        |m: &&crumple_proto::partition::Material| m.parameters.contains_key("cowper_symonds");
    let rates: Vec<&str> =
        model.settings.materials.iter().filter(rated).map(|m| m.name.as_str()).collect();
    if !rates.is_empty() {
        writeln!(
            out,
            "  strain rates of {}: they cost time at points that yield, which is not included",
            rates.join(", ")
        )?;
    }
    Ok(())
}

/// Returns the time of the force computation of one element of each part in a step [s], zero for
/// rigid parts and for parts without elements.
///
/// # Errors
/// A sample could not be set up.
pub fn element_seconds(model: &Model) -> Result<Vec<f64>, RankLost> {
    let records = model.records();
    let scene = ModelRecords::new(model, &records);
    let of_part = |number: u32| {
        let picked = scene.pick(number, SAMPLE);
        if picked.is_empty() || is_idle(model, number) {
            return Ok(0.0);
        }
        scene.try_out(&picked, false).map(|s| s.elements_s / s.lanes as f64)
    };
    (0..model.settings.parts.len() as u32).map(of_part).collect()
}

/// Selects a sample of a part: the elements nearest to the middle one by id, ascending.
fn pick(
    elements: &[ElementRecord],
    part: u32,
    count: usize,
    record: &HashMap<NodeId, &NodeRecord>,
) -> Vec<ElementRecord> {
    let first = |e: &ElementRecord| record.get(&e.nodes[0]).map_or([0.0; 3], |n| n.x);
    let mut all: Vec<&ElementRecord> = elements.iter().filter(|e| e.part == part).collect();
    if all.len() > count {
        let middle = first(all[all.len() / 2]);
        let far = |e: &&ElementRecord| {
            first(e).iter().zip(middle).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        all.select_nth_unstable_by(count - 1, |a, b| {
            far(a).total_cmp(&far(b)).then(a.id.cmp(&b.id))
        });
        all.truncate(count);
        all.sort_unstable_by_key(|e| e.id);
    }
    all.into_iter().copied().collect()
}

fn is_idle(model: &Model, part: u32) -> bool {
    model.settings.is_inactive(part)
}

/// Returns the settings without loads, constraints and output.
fn quiet(model: &Model, contact: bool) -> Settings {
    let mut settings = model.settings.clone();
    settings.walls.clear();
    settings.rigid.clear();
    settings.belts = BeltSystem::default();
    settings.field_times.clear();
    settings.loads = ResolvedLoads::default();
    settings.history_interval = f64::MAX;
    settings.contact = settings.contact.filter(|_| contact);
    settings
}

/// Runs some steps with some elements.
fn try_out(
    settings: &Settings,
    elements: &[ElementRecord],
    record: &HashMap<NodeId, &NodeRecord>,
) -> Result<CostSample, RankLost> {
    let corners = elements.iter().flat_map(|e| e.nodes).filter_map(|n| record.get(&n).map(|&&r| r));
    let share = PartitionData {
        elements: elements.iter().map(|&e| (e, Vec::new())).collect(),
        nodes: corners.collect(),
        ..PartitionData::default()
    };
    let mut ends = threads::connect(2);
    let (mut comm, _master) = (ends.remove(1), ends.remove(0)); // messages stay unread
    // The cost of one core.
    let alone = Settings { threads: 1, ..settings.clone() };
    let mut engine = Engine::new(&mut comm, alone, CutTree::single(), share)?;
    engine.blocks.compute_all();
    let mut least = [f64::INFINITY; 4];
    let mut search_s = 0.0;
    for number in 0..STEPS {
        let whole = engine.clock.starts_outer_step(settings);
        let before = engine.timer.seconds;
        engine.timer.restart();
        if step(&mut engine, &mut comm)?.failure.is_some() {
            break;
        }
        let spent = |phases: &[Phase]| -> f64 {
            phases.iter().map(|&p| engine.timer.seconds[p as usize] - before[p as usize]).sum()
        };
        if number == 0 {
            search_s = spent(&[Phase::Search]);
        }
        if !whole {
            continue; // without slow elements
        }
        let now = [
            &[Phase::Elements][..],
            &[Phase::Assemble],
            &[Phase::Constraints, Phase::Energy, Phase::Advance],
            &[Phase::Local, Phase::Contact],
        ];
        least.iter_mut().zip(now).for_each(|(l, phases)| *l = l.min(spent(phases)));
    }
    let [elements_s, assemble_s, advance_s, contact_s] =
        least.map(|s| if s.is_finite() { s } else { 0.0 });
    Ok(CostSample {
        elements: elements.len(),
        lanes: engine.blocks.blocks.iter().map(|b| b.count.next_multiple_of(b.lanes())).sum(),
        nodes: engine.nodes.len(),
        blocks: engine.blocks.bytes(),
        columns: engine.nodes.bytes(),
        contact: engine.contact.as_ref().map_or(0, |c| c.bytes()),
        saved: item_bytes(engine.blocks.blocks.first().map_or(0, |b| b.state(0).to_vec().len())),
        elements_s,
        assemble_s,
        advance_s,
        contact_s,
        search_s,
    })
}
