//! Tables of the page of a job: the model and its cost, parts, materials, walls.

use super::super::tables;
use super::{ExpectedCost, UnitNames};
use crate::input::check::{figure, part_figures};
use crate::input::job::Model;
use crumple_proto::job::Part;
use crumple_proto::partition::{Material, Param};
use crumple_proto::wall::{ResolvedWall, WallForm};
use serde_json::{Map, Value, json};

/// Returns all tables as HTML.
pub(super) fn all(model: &Model, cost: &ExpectedCost, units: &UnitNames) -> String {
    let mut all = run(model, cost, units);
    all.insert("parts".into(), Value::Array(parts(model, units)));
    all.insert("materials".into(), Value::Array(materials(model)));
    all.insert("rigid walls".into(), Value::Array(walls(model, units)));
    tables::tables(&all, "Model and expected cost")
}

/// Returns a name with its unit.
fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.into() } else { format!("{name} [{unit}]") }
}

fn run(model: &Model, cost: &ExpectedCost, units: &UnitNames) -> Map<String, Value> {
    let (dt, at) = model.first_dt();
    let settings = &model.settings;
    let rows = [
        ("job".into(), json!(model.path.display().to_string())),
        ("nodes".into(), json!(model.mesh.nodes.len())),
        ("elements".into(), json!(model.mesh.elements.len())),
        (with_unit("mass", &units.mass), json!(model.total_mass())),
        (with_unit("mass added by scaling", &units.mass), json!(model.scaled_mass())),
        (with_unit("time step", &units.time), json!(dt)),
        ("step set by element".into(), json!(model.mesh.elements[at].id.label())),
        (with_unit("end time", &units.time), json!(settings.end_time)),
        ("cycles, at least".into(), json!(cost.cycles)),
        ("workers".into(), json!(cost.workers)),
        ("time of a cycle [ms of CPU]".into(), json!(1e3 * cost.cycle_s)),
        ("time of the run [s of CPU]".into(), json!(cost.cpu_s())),
        ("time of the run on these workers [s]".into(), json!(cost.wall_s())),
        ("memory [MB]".into(), json!(cost.memory_mb)),
    ];
    rows.into_iter().collect()
}

fn parts(model: &Model, units: &UnitNames) -> Vec<Value> {
    let figures = part_figures(model);
    let row = |(index, part): (usize, &Part)| {
        let f = &figures[index];
        json!({
            "id": part.id,
            "name": part.name,
            "formulation": model.blocks.names(part, index).join(", "),
            "material": part.materials().join(", "),
            with_unit("thickness", &units.length): f.thickness(part),
            "number of elements": f.elements,
            with_unit("mass", &units.mass): f.mass,
            with_unit("smallest step", &units.time):
                f.smallest_step.is_finite().then_some(model.settings.safety * f.smallest_step),
        })
    };
    model.settings.parts.iter().enumerate().map(row).collect()
}

fn materials(model: &Model) -> Vec<Value> {
    let used = |m: &&Material| {
        model.settings.parts.iter().any(|part| part.materials().contains(&&*m.name))
    };
    let row = |m: &Material| {
        let parameters: Vec<String> =
            m.parameters.iter().map(|(key, value)| format!("{key} {}", words(value))).collect();
        json!({
            "name": m.name,
            "law": m.law,
            "density": m.density,
            "parameters": parameters.join(", "),
        })
    };
    model.settings.materials.iter().filter(used).map(row).collect()
}

fn words(value: &Param) -> String {
    match value {
        Param::Flag(flag) => flag.to_string(),
        Param::Number(number) => figure(*number),
        Param::List(numbers) => format!("({} numbers)", numbers.len()),
        Param::Table(rows) => format!("({} rows)", rows.len()),
    }
}

fn walls(model: &Model, units: &UnitNames) -> Vec<Value> {
    let row = |(number, wall): (usize, &ResolvedWall)| {
        let form = match wall.form {
            WallForm::Plane => "plane",
            WallForm::Rectangle { .. } => "rectangle",
            WallForm::Cylinder { .. } => "cylinder",
            WallForm::Sphere { .. } => "sphere",
        };
        json!({
            "name": wall.label(number),
            "form": form,
            with_unit("point", &units.length): wall.point.map(figure).join(", "),
            "direction": wall.direction.map(figure).join(", "),
            "friction": wall.friction,
            "acts on": acting(wall),
        })
    };
    model.settings.walls.iter().enumerate().map(row).collect()
}

/// Returns the nodes on which a wall acts, in words.
fn acting(wall: &ResolvedWall) -> String {
    wall.nodes.as_ref().map_or("all nodes".into(), |nodes| format!("{} nodes", nodes.len()))
}
