//! The numbers of a job: range checks and defaults.

use super::validate::{JobProblems, nearest};
use super::{adaptivity, contact, requirements, walls};
use crate::features;
use crumple_proto::histories::HistoryRequests;
use crumple_proto::job::{ContactInput, Job, Part, ParticlesInput, Setting};
use crumple_proto::loads::ResolvedLoads;
use crumple_proto::partition::{CheckpointSettings, Material, Param, Settings};
use crumple_proto::problem::Problem;
use crumple_proto::steering::{MOST_FIELDS, OutputTimes};
use crumple_worker::contact::beams;
use crumple_worker::fem::elements::points_of;
use crumple_worker::parallel::decomposition::BoxDecomposition;
use crumple_worker::parameter::{Form, ParameterRow};
use std::collections::{BTreeMap, HashMap};

/// Checks everything of a job except its mesh. `workers_given` is true if the job sets the number
/// of workers.
pub fn check(job: &Job, workers_given: bool, findings: &mut JobProblems) {
    let mut numbers = NumberChecks { findings };
    numbers.need(job.end_time > 0.0, "end_time", job.end_time, "above 0");
    check_time(job, &mut numbers);
    check_output(job, &mut numbers);
    check_parallel(job, workers_given, &mut numbers);
    check_checkpoints(job, &mut numbers);
    parts_and_materials(job, numbers.findings);
    loads(job, &mut NumberChecks { findings });
    walls::check(job, findings);
    requirements::check(job, findings);
    if let Some(given) = &job.adaptivity {
        adaptivity::check(given, job, &mut NumberChecks { findings });
    }
    if let Some(contact) = &job.contact {
        contact::check(contact, job, &mut NumberChecks { findings });
    }
    if job.mesh.generator.is_none() && !job.scene.is_empty() {
        let message = "[scene] holds options of a mesh generator, but the job names none";
        findings.add(Problem::warning("scene", message, "add mesh.generator or remove [scene]"));
    }
    if job.part.is_empty() {
        findings.add(Problem::error(
            "",
            "the job has no [[part]]",
            "add one for each part id of the elements; in a deck a *PART",
        ));
    }
    super::units::check(job).into_iter().for_each(|warning| findings.add(warning));
}

/// Checks `[time]`.
fn check_time(job: &Job, numbers: &mut NumberChecks<'_>) {
    let time = &job.time;
    numbers.need(time.safety > 0.0, "time.safety", time.safety, "above 0; 0.9 is usual");
    if time.safety > 1.0 {
        let message = format!("safety = {} is above 1: the run will become unstable", time.safety);
        numbers.findings.add(Problem::warning("time.safety", message, "reduce it; 0.9 is usual"));
    }
    numbers.need(
        (0.0..1.0).contains(&time.dt_min_ratio),
        "time.dt_min_ratio",
        time.dt_min_ratio,
        "from 0 to below 1",
    );
    let limit = time.mass_scaling_limit;
    numbers.need(
        limit >= 0.0,
        "time.mass_scaling_limit",
        limit,
        "a fraction of the structure's mass, 0 or above",
    );
    numbers.need(
        time.mass_scaling_dt >= 0.0,
        "time.mass_scaling_dt",
        time.mass_scaling_dt,
        "0 (none) or above",
    );

    if time.subcycles == 0 {
        let help = "take 1 (all elements in each cycle), or the number of cycles in an outer step";
        numbers.findings.add(Problem::error(
            "time.subcycles",
            "subcycles is 0: an outer step has no cycle",
            help,
        ));
    }
    numbers.need(time.dt_max >= 0.0, "time.dt_max", time.dt_max, "0 (no limit) or above");
}

/// Checks `[output]`.
fn check_output(job: &Job, numbers: &mut NumberChecks<'_>) {
    let output = &job.output;
    let interval = output.history_interval;
    numbers.need(
        interval >= 0.0,
        "output.history_interval",
        interval,
        "0 (a two-hundredth of the run) or above",
    );
    for (index, &t) in output.field_times.iter().enumerate() {
        let path = format!("output.field_times.{index}");
        if job.end_time > 0.0 && (t < 0.0 || t > job.end_time) {
            let message = format!(
                "no field file can be written at {t}: the run is from time 0 to {}",
                job.end_time
            );
            numbers.findings.add(Problem::warning(path, message, "remove it, or change end_time"));
        }
    }
    if output.vtkhdf && !features::VTKHDF {
        numbers.findings.add(Problem::error(
            "output.vtkhdf",
            features::NO_VTKHDF,
            format!("{}, or remove the key", features::ADD_VTKHDF),
        ));
    }
    let files = job.end_time / output.field_interval;
    if output.field_interval > 0.0 && files > MOST_FIELDS {
        let help = format!("take an interval of at least {:?}", job.end_time / MOST_FIELDS);
        let message =
            format!("field_interval = {:?} gives {files:.0} field files", output.field_interval);
        numbers.findings.add(Problem::error("output.field_interval", message, help));
    }
}

/// Checks `[parallel]`.
fn check_parallel(job: &Job, workers_given: bool, numbers: &mut NumberChecks<'_>) {
    let parallel = &job.parallel;
    if workers_given && parallel.workers == 0 {
        let help = "give at least 1, or leave `workers` out for one per core";
        numbers.findings.add(Problem::error(
            "parallel.workers",
            "0 workers cannot run a job",
            help,
        ));
    }
    for row in BoxDecomposition::KEYS {
        numbers.setting("parallel", row, parallel.parameters.get(row.key));
    }
}

fn check_checkpoints(job: &Job, numbers: &mut NumberChecks<'_>) {
    let checkpoint = &job.checkpoint;
    for (key, text, wanted) in [
        ("every", &checkpoint.every, checkpoint.interval().err()),
        ("in_memory", &checkpoint.in_memory, checkpoint.copy_interval().err()),
        ("patience", &checkpoint.patience, checkpoint.patience().err()),
    ] {
        if let Some(wanted) = wanted {
            let message = format!("`{key}` is \"{text}\"");
            numbers.findings.add(Problem::error(format!("checkpoint.{key}"), message, wanted));
        }
    }
    for (index, &t) in checkpoint.at.iter().enumerate() {
        numbers.need(t >= 0.0, &format!("checkpoint.at.{index}"), t, "a time, 0 or above");
    }
    if checkpoint.keep == 0 {
        let help = "take at least 1; `every = \"off\"` writes no checkpoints";
        numbers.findings.add(Problem::error("checkpoint.keep", "`keep` is 0", help));
    }
}

fn parts_and_materials(job: &Job, findings: &mut JobProblems) {
    let twice = |list: &str, key: &str, values: Vec<String>, findings: &mut JobProblems| {
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for (index, value) in values.iter().enumerate() {
            let path = format!("{list}.{index}.{key}");
            if value.is_empty() || findings.is_faulty(&path) {
                continue;
            }
            if let Some(first) = seen.insert(value, index) {
                let message = format!(
                    "two entries of [[{list}]] have the {key} `{value}`: numbers {} and {}",
                    first + 1,
                    index + 1
                );
                findings.add(Problem::error(path, message, format!("give each its own {key}")));
            }
        }
    };
    twice("part", "id", job.part.iter().map(|p| p.id.to_string()).collect(), findings);
    twice("part", "name", job.part.iter().map(|p| p.name.clone()).collect(), findings);
    twice("material", "name", job.material.iter().map(|m| m.name.clone()).collect(), findings);
    twice("wall", "name", job.wall.iter().map(|w| w.name.clone()).collect(), findings);
    for (index, material) in job.material.iter().enumerate() {
        if material.name.is_empty() {
            findings.add(Problem::error(
                format!("material.{index}.name"),
                "a material has no name",
                "give it a name: parts refer to it by name",
            ));
        }
    }
}

fn loads(job: &Job, numbers: &mut NumberChecks<'_>) {
    for (index, mass) in job.mass.iter().enumerate() {
        numbers.need(mass.mass > 0.0, &format!("mass.{index}.mass"), mass.mass, "above 0");
    }
    for (index, fix) in job.fix.iter().enumerate() {
        if fix.dofs.is_empty() {
            let path = format!("fix.{index}.dofs");
            numbers.findings.add(Problem::warning(
                path,
                "a [[fix]] with empty `dofs` fixes nothing",
                "name dofs, such as [\"x\", \"rz\"]",
            ));
        }
    }
}

/// Checks of numbers and words.
pub(super) struct NumberChecks<'f> {
    /// The problems found.
    pub findings: &'f mut JobProblems,
}

impl NumberChecks<'_> {
    /// Reports an error unless `right` is true for the `value` at a path. `wanted` describes the
    /// valid values.
    pub fn need(&mut self, right: bool, path: &str, value: f64, wanted: &str) {
        if !right {
            let key = path.rsplit('.').next().unwrap_or(path);
            self.findings.add(Problem::error(
                path,
                format!("`{key}` is {value:?}"),
                format!("it has to be {wanted}"),
            ));
        }
    }

    /// Reports an error if the value of a key of the table at `path` is not valid; `None` if it is
    /// not given. The schema checks its type.
    pub fn setting(&mut self, path: &str, row: &ParameterRow, value: Option<&Setting>) {
        let path = format!("{path}.{}", row.key);
        match (value, row.form, row.range) {
            (Some(Setting::Word(word)), Form::Word(known), _) => self.word(&path, word, known),
            (Some(value), _, Some(range)) => {
                let value = value.number().unwrap_or(f64::NAN);
                self.need((range.fits)(value), &path, value, range.wanted);
            }
            _ => {}
        }
    }

    /// Reports an error unless a word at a path is one of the `known` ones.
    pub fn word(&mut self, path: &str, word: &str, known: &[&str]) {
        if !known.contains(&word) {
            let key = path.rsplit('.').next().unwrap_or(path);
            self.findings.add(Problem::error(
                path,
                format!("there is no {key} `{word}`"),
                nearest(word, known),
            ));
        }
    }
}

/// Returns the largest number of points through the thickness of any part of shells, at least 1.
fn most_points(parts: &[Part]) -> usize {
    let shells = parts.iter().filter(|p| p.thickness > 0.0);
    shells.map(points_of).max().unwrap_or(1)
}

/// Returns the settings of all workers with defaults, and for each of their parts its index in
/// the job. Default lengths follow from the smallest and the median side of the mesh's elements.
/// Walls, loads, rigid bodies and parts with offsets of single shells are added later. `own` holds
/// the parts with shells of individual thickness, with the largest of these [length].
pub fn settings(
    job: &Job,
    sides: Option<(f64, f64)>,
    own: &BTreeMap<u32, f64>,
) -> (Settings, Vec<usize>) {
    /// Largest buffer in smallest sides. With a larger one, workers would copy much of a fine
    /// zone in a coarse mesh.
    const COARSE: f64 = 4.0;
    let decomposition = BoxDecomposition::new(&job.parallel);
    let (mut smallest, mut median) = sides.unwrap_or((0.0, 0.0));
    // The spacing is the side of a particle.
    for spacing in job.part.iter().filter_map(|p| Some(p.particles.as_ref()?.spacing)) {
        smallest = if smallest > 0.0 { spacing.min(smallest) } else { spacing };
        median = if median > 0.0 { median } else { spacing };
    }
    let mut order: Vec<usize> = (0..job.part.len()).collect();
    order.sort_by_key(|&i| job.part[i].id);
    let parts: Vec<Part> = order.iter().map(|&i| job.part[i].clone()).collect();
    let or = |given: f64, default: f64| if given > 0.0 { given } else { default };
    let contact = job.contact.clone().map(|contact| {
        let touches = |part: &&Part| contact.takes_part(part.id);
        let thickness = |part: &Part| {
            let shell = || own.get(&part.id).map_or(part.thickness, |t| t.max(part.thickness));
            let radius = part.particles.as_ref().map(ParticlesInput::radius);
            let radius = radius.or_else(|| beams::half(&contact, part));
            radius.map_or_else(shell, |radius| 2.0 * radius)
        };
        let thickest = parts.iter().filter(touches).map(thickness).fold(0.0, f64::max);
        let skin = (0.25 * median).max((0.4 * thickest).min(median));
        ContactInput { skin: or(contact.skin, skin), ..contact }
    });
    let settings = Settings {
        end_time: job.end_time,
        safety: job.time.safety,
        max_cycles: job.time.max_cycles,
        dt_min_ratio: job.time.dt_min_ratio,
        history_interval: or(job.output.history_interval, job.end_time / 200.0),
        field_times: output_times(job).fields_until(job.end_time),
        output: output_times(job),
        planned: Vec::new(),
        histories: HistoryRequests::default(),
        contact_forces: job.output.contact_forces && contact.is_some(),
        field_points: if job.output.points { most_points(&parts) } else { 0 },
        field_dir: String::new(),
        checkpoint: checkpoint_settings(job),
        materials: job.material.iter().map(material).collect(),
        parts,
        with_own_offsets: Vec::new(),
        axes: Vec::new(),
        initial: Vec::new(),
        followed: Vec::new(),
        precision: job.elements.precision,
        walls: Vec::new(),
        loads: ResolvedLoads::default(),
        rigid: Vec::new(),
        joints: Vec::new(),
        ties: Vec::new(),
        failure_groups: Vec::new(),
        belts: Default::default(),
        dt_max: job.time.dt_max,
        subcycles: job.time.subcycles.max(1),
        contact,
        rotations: true,
        adaptivity: None,
        buffer: or(decomposition.buffer, median.min(COARSE * smallest)),
        force_every: decomposition.force_every,
        contact_decomposition: decomposition.contact,
        threads: decomposition.threads,
    };
    (settings, order)
}

/// Returns the settings of checkpoints; their folder is known when the run begins.
fn checkpoint_settings(job: &Job) -> CheckpointSettings {
    let mut times = job.checkpoint.at.clone();
    times.sort_by(f64::total_cmp);
    CheckpointSettings {
        dir: String::new(),
        times,
        at_stop: job.checkpoint.interval().is_ok_and(|every| every.is_some()),
        compression: job.checkpoint.compression,
        patience: job.checkpoint.patience().map_or(0.0, |patience| patience.as_secs_f64()),
    }
}

fn material(spec: &crumple_proto::job::MaterialSpec) -> Material {
    let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap_or(0.0);
    let list =
        |v: &toml::Value| v.as_array().map(|items| items.iter().map(number).collect::<Vec<f64>>());
    // The schema allows only numbers, flags, lists and lists of lists.
    let param = |v: &toml::Value| match v.as_array() {
        None => v.as_bool().map_or_else(|| Param::Number(number(v)), Param::Flag),
        Some(rows) if rows.first().is_some_and(toml::Value::is_array) => {
            Param::Table(rows.iter().filter_map(list).collect())
        }
        Some(items) => Param::List(items.iter().map(number).collect()),
    };
    Material {
        name: spec.name.clone(),
        law: spec.law.clone(),
        density: spec.density,
        parameters: spec
            .parameters
            .iter()
            .map(|(key, value)| (key.clone(), param(value)))
            .collect(),
    }
}

/// Returns the field outputs that a job asks for.
fn output_times(job: &Job) -> OutputTimes {
    let field_interval = match job.output.field_interval {
        0.0 => job.end_time / 20.0,
        given => given,
    };
    let additional = job.output.field_times.clone();
    OutputTimes { field_interval, additional, ..OutputTimes::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(text: &str) -> Job {
        toml::from_str(&format!("end_time = 1.0\n[mesh]\n{text}")).unwrap()
    }

    /// `true` stays a flag: no law takes it for the number 1.
    #[test]
    fn a_flag_of_a_material_is_no_number() {
        let text = "[[material]]\nname = \"a\"\nlaw = \"j2\"\ndensity = 1.0\n\
                    youngs_modulus = true\npoisson = 1\n";
        let parameters = super::material(&job(text).material[0]).parameters;
        assert_eq!(parameters["youngs_modulus"], Param::Flag(true));
        assert_eq!(parameters["poisson"], Param::Number(1.0));
    }

    fn fields(job: &Job) -> Vec<f64> {
        output_times(job).fields_until(job.end_time)
    }

    #[test]
    fn field_times_are_regular_and_end_with_the_run() {
        assert_eq!(fields(&job("[output]\nfield_interval = 0.4")), [0.0, 0.4, 0.8, 1.0]);
        assert_eq!(
            fields(&job("[output]\nfield_interval = 0.5\nfield_times = [0.5, 0.25]")),
            [0.0, 0.25, 0.5, 1.0]
        );
        assert_eq!(fields(&job("")).len(), 21);
        assert_eq!(fields(&job("[output]\nfield_interval = -1\nfield_times = [2.0, 0.3]")), [0.3]);
    }

    #[test]
    fn buffers_are_of_the_median_side_and_of_four_of_the_smallest_at_most() {
        let buffer =
            |text: &str, sides| settings(&job(text), Some(sides), &BTreeMap::new()).0.buffer;
        assert_eq!(buffer("", (1.0, 3.0)), 3.0);
        assert_eq!(buffer("", (1.0, 10.0)), 4.0, "a fine zone in a coarse mesh");
        assert_eq!(buffer("[parallel]\nbuffer = 7.0", (1.0, 10.0)), 7.0, "as given");
    }
}
