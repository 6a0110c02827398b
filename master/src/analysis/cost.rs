//! Cost of a scene: bytes and nanoseconds of elements, nodes and contact, by the features in use.
//!
//! Both are measured on engines with some hundred neighbouring elements of each part, or some
//! thousand for contact, set up from the job as on a worker. Bytes are those of the columns of
//! these engines. Times are the shortest of a few steps of the initial mesh, with unstrained
//! elements computed like all others. A step takes longer in motion, with a cold cache or on a
//! busy machine.

use crate::input::job::Model;
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::NodeId;
use crumple_proto::loads::Loads;
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
struct Sample {
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

/// Returns the tables that `crumple check` prints for `workers` workers, and the memory of the run
/// in total [MB]; 0 if it cannot be estimated.
pub fn describe(model: &Model, workers: usize) -> (String, f64) {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let memory_mb = write(model, workers, &mut out).unwrap_or_else(|_| {
        out.push_str("\nno costs: the sample cannot be set up\n");
        0.0
    });
    (out, memory_mb)
}

fn write(
    model: &Model,
    workers: usize,
    out: &mut String,
) -> Result<f64, Box<dyn std::error::Error>> {
    let (elements, nodes) = model.records();
    let record: HashMap<NodeId, &NodeRecord> = nodes.iter().map(|r| (r.id, r)).collect();
    let (mut bytes, mut element_s, mut rows) = (0.0, 0.0, String::new());
    let (mut parted, mut node_s) = (Vec::new(), 0.0f64);
    let (mut columns, mut saved, mut saved_items) = ([0.0f64; 2], 0, [0; 3]);
    for (number, part) in (0u32..).zip(&model.settings.parts) {
        let count = elements.iter().filter(|e| e.part == number).count();
        if count == 0 {
            continue;
        }
        let s = try_out(&quiet(model, false), &pick(&elements, number, SAMPLE, &record), &record)?;
        if model.settings.contact.is_some() {
            parted.extend(pick(&elements, number, TOUCHING, &record));
        }
        let each = |b: usize| b as f64 / s.elements as f64;
        let rigid = is_idle(model, number);
        let ns = if rigid { 0.0 } else { 1e9 * s.elements_s / s.elements as f64 };
        let of =
            [s.blocks.history, s.blocks.force, s.blocks.moment, s.blocks.connectivity].map(each);
        let name = if part.name.is_empty() { part.id.to_string() } else { part.name.clone() };
        let rigid = if rigid { "  rigid or skin: no forces" } else { "" };
        let [history, force, moment, connectivity] = of;
        writeln!(
            rows,
            "  {name:<20} {count:>9}  {history:>8.0} {force:>7.0} {moment:>8.0} \
             {connectivity:>13.0}  {ns:>8.1}{rigid}"
        )?;
        bytes += of.iter().sum::<f64>() * count as f64;
        saved += s.saved[0] * count;
        saved_items = s.saved;
        let cycles =
            |e: &&ElementRecord| if e.slow { model.settings.subcycles as f64 } else { 1.0 };
        let computed: f64 =
            elements.iter().filter(|e| e.part == number).map(|e| 1.0 / cycles(&e)).sum();
        element_s += 1e-9 * ns * computed;
        node_s = node_s.max((s.assemble_s + s.advance_s) / s.nodes as f64);
        columns = s.columns.map(|b| b as f64 / s.nodes as f64);
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
    let all = nodes.len() as f64;
    let turning = if model.settings.rotations { "" } else { " (no rotations)" };
    writeln!(
        out,
        "  per node: {:.0} bytes for translation, {:.0} for rotation{turning}; {:.1} ns/cycle \
         for assembly, acceleration and motion",
        columns[0],
        columns[1],
        1e9 * node_s
    )?;
    bytes += (columns[0] + columns[1]) * all;
    let mut cycle_s = element_s + node_s * all;
    if model.settings.contact.is_some() {
        let sample = try_out(&quiet(model, true), &parted, &record)?;
        let each = write_contact(model, &sample, out)?;
        bytes += each.bytes * elements.len() as f64;
        cycle_s += each.cycle_s * elements.len() as f64;
    } else {
        writeln!(out, "  contact: none, 0 bytes, 0 ns")?;
    }
    let ([_, of_node, of_pair], count) = (saved_items, elements.len().max(1));
    saved += of_node * nodes.len();
    writeln!(
        out,
        "  checkpoint: {:.1} MB without compression, {} bytes per element with its nodes; \
         {of_node} more for each further worker that has a node, {of_pair} for a contact pair at \
         each node that keeps it",
        1e-6 * saved as f64,
        saved / count
    )?;
    if model.job.checkpoint.copy_interval().unwrap_or_default().is_some() {
        writeln!(out, "  copy in memory (checkpoint.in_memory): as many bytes as a checkpoint")?;
        bytes += saved as f64;
    }
    write_rates(model, out)?;
    let master = (size_of::<ElementRecord>() * elements.len()
        + size_of::<NodeRecord>() * nodes.len()) as f64;
    let memory_mb = 1e-6 * (bytes + master);
    writeln!(
        out,
        "  total: {:.1} MB with {:.1} MB of the master, {:.1} MB per worker of {workers}",
        memory_mb,
        1e-6 * master,
        1e-6 * bytes / workers as f64
    )?;
    let cycles = (model.settings.end_time / model.first_dt().0).ceil();
    writeln!(
        out,
        "  a cycle takes about {:.3} ms of CPU time, the run of at least {cycles:.0} cycles \
         {:.1} s, without plasticity and later contact",
        1e3 * cycle_s,
        cycle_s * cycles
    )?;
    Ok(memory_mb)
}

/// Cost of contact for one element.
struct ContactCost {
    bytes: f64,
    /// Time of a cycle [s].
    cycle_s: f64,
}

/// Writes the line of contact, and returns its cost for one element.
fn write_contact(
    model: &Model,
    sample: &Sample,
    out: &mut String,
) -> Result<ContactCost, std::fmt::Error> {
    let each = |number: f64| number / sample.elements as f64;
    let (bytes, cycle_s) = (each(sample.contact as f64), each(sample.contact_s));
    let has_friction =
        model.settings.contact.iter().flat_map(|c| c.each()).any(|c| c.friction > 0.0);
    let friction = if has_friction { "with friction" } else { "no friction" };
    writeln!(
        out,
        "  contact: {bytes:.0} bytes and {:.1} ns/cycle per element for the initial mesh, \
         {friction}; a global search, not in every cycle, {:.0} ns per element",
        1e9 * cycle_s,
        1e9 * each(sample.search_s)
    )?;
    Ok(ContactCost { bytes, cycle_s })
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
    let (elements, nodes) = model.records();
    let record: HashMap<NodeId, &NodeRecord> = nodes.iter().map(|r| (r.id, r)).collect();
    let of_part = |number: u32| {
        let picked = pick(&elements, number, SAMPLE, &record);
        if picked.is_empty() || is_idle(model, number) {
            return Ok(0.0);
        }
        try_out(&quiet(model, false), &picked, &record).map(|s| s.elements_s / s.lanes as f64)
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
    model.settings.parts[part as usize].skin
        || model.settings.rigid.iter().any(|r| r.parts.contains(&part))
}

/// Returns the settings without loads, constraints and output.
fn quiet(model: &Model, contact: bool) -> Settings {
    let mut settings = model.settings.clone();
    settings.walls.clear();
    settings.rigid.clear();
    settings.field_times.clear();
    settings.loads = Loads::default();
    settings.history_interval = f64::MAX;
    settings.contact = settings.contact.filter(|_| contact);
    settings
}

/// Runs some steps with some elements.
fn try_out(
    settings: &Settings,
    elements: &[ElementRecord],
    record: &HashMap<NodeId, &NodeRecord>,
) -> Result<Sample, RankLost> {
    let corners = elements.iter().flat_map(|e| e.nodes).filter_map(|n| record.get(&n).map(|&&r| r));
    let share = PartitionData {
        elements: elements.iter().map(|&e| (e, Vec::new())).collect(),
        nodes: corners.collect(),
        ..PartitionData::default()
    };
    let mut ends = threads::connect(2);
    let (mut comm, _master) = (ends.remove(1), ends.remove(0)); // messages stay unread
    let mut engine = Engine::new(&mut comm, settings.clone(), CutTree::single(), share)?;
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
    Ok(Sample {
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
