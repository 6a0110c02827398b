//! `crumple check --html`: one page that shows a job before its run, in the viewer of the report.
//!
//! - `columns`: the mesh as a state without results, values of elements and nodes, node sets
//! - `conditions`: boundary conditions, loads and findings, as marks in the picture
//! - `tables`: the model, its parts, materials and walls, and what the run will cost

mod columns;
mod conditions;
mod tables;

use super::encode::PackedColumns;
use super::page::{self, PageKind, escape};
use super::sources::RunFiles;
use super::{MOST_BYTES, Made, facts, finish, fit, progress};
use crate::input::job::{Model, Report};
use columns::ModelColumns;
use crumple_proto::job::Part;
use crumple_proto::mesh::Mesh;
use crumple_worker::contact::diagnostics::initial_penetration::{Penetration, initial};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Instant;

/// Maximum number of rows of a list of findings.
const MOST_ROWS: usize = 50;

/// Expected cost of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedCost {
    /// Number of workers.
    pub workers: usize,
    /// Number of cycles at the first step.
    pub cycles: f64,
    /// CPU time of a cycle, without plasticity and later contact [s].
    pub cycle_s: f64,
    /// Memory of all workers and the master [MB].
    pub memory_mb: f64,
}

impl ExpectedCost {
    /// Returns the CPU time of the run [s].
    pub fn cpu_s(&self) -> f64 {
        self.cycles * self.cycle_s
    }

    /// Returns the wall time of the run if all workers have a core of their own [s].
    pub fn wall_s(&self) -> f64 {
        self.cpu_s() / self.workers.max(1) as f64
    }
}

/// Names of the units of a job, empty if they are not stated.
struct UnitNames {
    length: String,
    time: String,
    mass: String,
    velocity: String,
}

impl UnitNames {
    fn new(sources: &RunFiles) -> Self {
        let word = |i: usize| sources.unit_words().get(i).map_or(String::new(), |w| (*w).into());
        let length = sources.length_and_stress()[0].clone();
        Self { length, time: word(1), mass: word(2), velocity: sources.velocity() }
    }
}

/// Writes the page of a job that can run. `text` is the description that `crumple check` prints.
///
/// # Errors
/// The page cannot be written.
pub fn write(model: &Model, cost: &ExpectedCost, text: &str, path: &Path) -> Result<Made, String> {
    let began = Instant::now();
    let page = make(model, cost, text, &mut progress(false));
    finish(path, (page, Vec::new()), began)
}

/// Writes the page of a job that cannot run: only its problems.
///
/// # Errors
/// The page cannot be written.
pub fn write_refused(job: &Path, report: &Report, path: &Path) -> Result<Made, String> {
    let began = Instant::now();
    let warnings: Vec<(usize, String)> =
        report.problems.iter().map(|problem| (0, problem.to_string())).collect();
    let mut all = facts(&RunFiles::default(), None);
    all["setup"] = json!({
        "why": "There is no picture: the job has errors. Correct them, and check it again.",
    });
    let content = page::Content {
        kind: PageKind::Model,
        title: &job.display().to_string(),
        subtitle: "cannot run",
        warnings: &warnings,
        facts: &page::json(&all),
        ..page::Content::default()
    };
    finish(path, (page::page(&content), Vec::new()), began)
}

/// Makes the page of a job that can run.
fn make(model: &Model, cost: &ExpectedCost, text: &str, say: &mut dyn FnMut(&str)) -> String {
    let sources = RunFiles { summary: Some(about(model)), ..RunFiles::default() };
    let units = UnitNames::new(&sources);
    let (elements, nodes) = model.records();
    let penetrations = initial(&model.settings, &elements, &nodes).penetrations;
    let series = columns::series(model);
    // Half of the room is for values, sets and marks. Base64: four characters per three bytes.
    let (scene, description, picture) = fit(&series, MOST_BYTES / 2 / 4 * 3, say);
    let columns = ModelColumns::new(model, &penetrations, &units);
    let conditions = conditions::all(model, &penetrations, &units);
    let mut packed = PackedColumns::new();
    let scalars = columns.pack(&scene, &mut packed);
    let sets = columns::pack_sets(&model.mesh, &scene, &mut packed);
    let marks: Vec<Value> = conditions.iter().map(|c| c.pack(&scene.nodes, &mut packed)).collect();
    let mut all = facts(&sources, Some(&description));
    all["time_unit"] = json!(units.time);
    all["setup"] = json!({
        "scalars": scalars[0],
        "node_scalars": scalars[1],
        "sets": sets,
        "conditions": marks,
        "materials": materials_of_parts(model),
        "limiting": limiting(model),
        "penetrations": penetration_rows(&model.mesh, &penetrations),
    });
    let warnings: Vec<(usize, String)> =
        model.warnings.iter().map(|warning| (0, model.show(warning).to_string())).collect();
    let mut left_out = vec![format!(
        "Arrows and points of one kind are at most {}; the tables have the numbers of the model.",
        conditions::MOST_MARKS
    )];
    if scene.faces.len() < scene.faces_seen {
        left_out.push("The mesh is coarser than that of the run, for the size of the page.".into());
    }
    let name = model.path.display().to_string();
    let content = page::Content {
        kind: PageKind::Model,
        title: if model.job.title.is_empty() { &name } else { &model.job.title },
        subtitle: &subtitle(model, cost),
        warnings: &warnings,
        left_out: &left_out,
        tables: &(tables::all(model, cost, &units) + &described(text)),
        facts: &page::json(&all),
        pictures: [&picture, &[]],
        setup: &packed.finish(),
        ..page::Content::default()
    };
    page::page(&content)
}

/// Returns what the page of a run reads from `summary.json`.
fn about(model: &Model) -> Map<String, Value> {
    let parts = &model.settings.parts;
    let about = json!({
        "title": model.job.title,
        "units": model.job.units,
        "parts": parts.iter().map(|p| json!({"id": p.id, "name": p.name})).collect::<Vec<_>>(),
        "walls": model.job.wall,
    });
    about.as_object().cloned().unwrap_or_default()
}

fn subtitle(model: &Model, cost: &ExpectedCost) -> String {
    let units = match model.job.units.as_str() {
        "" => String::new(),
        units => format!(" · units {units}"),
    };
    format!(
        "before the run · {} elements, {} nodes, about {:.0} cycles{units}",
        model.mesh.elements.len(),
        model.mesh.nodes.len(),
        cost.cycles
    )
}

/// Returns the text of `crumple check` as a part of the page that opens by a click.
fn described(text: &str) -> String {
    format!(
        "<details class=\"table\"><summary>Text of crumple check</summary>\
         <pre>{}</pre></details>\n",
        escape(text)
    )
}

/// Returns the name of the material of each part, by the id of the part.
fn materials_of_parts(model: &Model) -> Map<String, Value> {
    let named = |p: &Part| (p.id.to_string(), json!(p.material));
    model.settings.parts.iter().map(named).collect()
}

/// Returns the elements with the smallest stable steps, ascending: element, part, step with the
/// safety factor, and the step over the smallest one.
fn limiting(model: &Model) -> Vec<Value> {
    let safety = model.settings.safety;
    let order = conditions::limiting(model);
    let least = order.first().map_or(1.0, |&e| model.elements.stable_dt[e]);
    let row = |&e: &usize| {
        let (element, dt) = (&model.mesh.elements[e], model.elements.stable_dt[e]);
        json!({
            "element": element.id.label(),
            "part": element.part,
            "step": safety * dt,
            "ratio": dt / least,
        })
    };
    order.iter().map(row).collect()
}

/// Returns the number of initial penetrations, and the deepest ones.
fn penetration_rows(mesh: &Mesh, found: &[Penetration]) -> Value {
    let mut order: Vec<&Penetration> = found.iter().collect();
    order.sort_by(|a, b| b.depth.total_cmp(&a.depth).then(a.node.label().cmp(&b.node.label())));
    let part_of = |p: &Penetration| mesh.elements.iter().find(|e| e.id == p.elem).map(|e| e.part);
    let row = |p: &&Penetration| {
        json!({
            "node": p.node.label(),
            "element": p.elem.label(),
            "part": part_of(p),
            "depth": p.depth,
            "unseen": p.unseen,
        })
    };
    json!({
        "count": found.len(),
        "rows": order.iter().take(MOST_ROWS).map(row).collect::<Vec<_>>(),
    })
}
