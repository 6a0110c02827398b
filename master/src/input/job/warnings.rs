//! Warnings about the numbers of a valid model.

use super::separate_bodies;
use super::state::{ElementStart, NodeStart, deformable_mass, fastest_wave, scaled_mass, smallest};
use super::units;
use crumple_proto::job::{ContactInput, Job, Part, Setting};
use crumple_proto::mesh::{Mesh, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use crumple_proto::wall::WallMotion;
use crumple_worker::contact::beams;
use std::collections::BTreeSet;

/// Mass added by mass scaling above which a warning is given, as a fraction of the structure's.
const MUCH_ADDED: f64 = 0.05;
/// Poisson's ratio above which solids with constant strain are much too stiff.
const MUCH_LOCKING: f64 = 0.45;
/// Step of one element over the median step below which a warning is given.
const MUCH_SMALLER: f64 = 0.1;

/// Returns warnings about the numbers of a valid model.
pub fn of_model(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    elements: &ElementStart,
    nodes: &NodeStart,
) -> Vec<Problem> {
    let mut warnings = Vec::new();
    warnings.extend(no_motion(settings, nodes));
    warnings.extend(speed_above_waves(job, nodes));
    warnings.extend(separate_bodies::without_contact(job, mesh, settings, elements, nodes));
    warnings.extend(parts_without_elements(job, settings, elements));
    let contact = settings.contact.as_ref();
    warnings.extend(contact.and_then(|c| beams_without_contact(c, settings, mesh)));
    warnings.extend(ties_at_walls(settings));
    warnings.extend(much_added_mass(elements));
    warnings.extend(one_small_element(mesh, elements));
    warnings.extend(solids_that_lock(job, mesh, elements));
    warnings
}

/// Warns about parts of tetrahedra and wedges that hardly change their volume and do not average
/// their volume strain: a thick cylinder of 8 wedges over the wall is 23 % too stiff at nu = 0.49.
fn solids_that_lock(job: &Job, mesh: &Mesh, elements: &ElementStart) -> Option<Problem> {
    let poisson = |part: &Part| {
        let material = job.material.iter().find(|m| m.name == part.material)?;
        units::number(material, "poisson")
    };
    // Rigid elements have no stable step.
    let deform = mesh.elements.iter().zip(&elements.stable_dt).filter(|(_, dt)| dt.is_finite());
    let constant = deform.filter(|(e, _)| matches!(e.shape, Shape::Tet4 | Shape::Wedge6));
    let parts: BTreeSet<u32> = constant.map(|(e, _)| e.part).collect();
    let locks = |(i, part): (usize, &'_ Part)| {
        let by_element = part.parameters.get("pressure") == Some(&Setting::from("element"));
        let nu = poisson(part).filter(|nu| *nu > MUCH_LOCKING)?;
        (by_element && parts.contains(&part.id)).then(|| (i, part.label(), nu))
    };
    let (i, label, nu) = job.part.iter().enumerate().find_map(locks)?;
    let message = format!(
        "part {label} has tetrahedra or wedges, pressure = \"element\" and Poisson's ratio \
         {nu}: they are too stiff where the volume cannot change"
    );
    let help = "use pressure = \"nodal\", the default, or hexahedra";
    Some(Problem::warning(format!("part.{i}.pressure"), message, help))
}

/// Warns if no node moves and nothing acts on the model.
fn no_motion(settings: &Settings, nodes: &NodeStart) -> Option<Problem> {
    let still =
        nodes.velocity.iter().flatten().chain(nodes.spin.iter().flatten()).all(|&c| c == 0.0);
    let led = settings.rigid.iter().any(|r| !r.motions.is_empty())
        || settings.walls.iter().any(|w| w.motion != WallMotion::Still);
    let message = "nothing moves: no node has an initial velocity, and there are no loads";
    let help = "add an [[initial_velocity]] or a load";
    let none = still && !led && !settings.loads.act();
    none.then(|| Problem::warning("initial_velocity", message, help))
}

/// Warns if a node starts with a speed above that of all waves.
fn speed_above_waves(job: &Job, nodes: &NodeStart) -> Option<Problem> {
    let fastest = fastest_wave(job);
    let speed = nodes
        .velocity
        .iter()
        .map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let message = format!(
        "a node starts with the speed {speed:.4e}, faster than any wave in the materials \
         ({fastest:.4e})"
    );
    let help = "check its units: velocities are in the length unit of the coordinates per time \
                unit of the job";
    let place =
        if job.initial_velocity.len() == 1 { "initial_velocity.0" } else { "initial_velocity" };
    (fastest > 0.0 && speed > fastest).then(|| Problem::warning(place, message, help))
}

fn parts_without_elements(
    job: &Job,
    settings: &Settings,
    elements: &ElementStart,
) -> impl Iterator<Item = Problem> {
    let parts = (0u32..).zip(&settings.parts);
    parts.filter(|(index, _)| !elements.part.contains(index)).map(|(_, part)| {
        let place = job.part.iter().position(|p| p.id == part.id).unwrap_or(0);
        let message = format!("part {} has no elements", part.label());
        let help = "remove it, or check the part ids of the mesh";
        Problem::warning(format!("part.{place}.id"), message, help)
    })
}

/// Warns if beams other than welds are not in contact.
fn beams_without_contact(
    contact: &ContactInput,
    settings: &Settings,
    mesh: &Mesh,
) -> Option<Problem> {
    let is_weld = |p: &Part| p.beam.as_ref().is_some_and(|b| b.weld.is_some());
    let without = |p: &&Part| {
        let is_bare = beams::has_bars(p) && !is_weld(p) && beams::half(contact, p).is_none();
        is_bare && mesh.elements.iter().any(|e| e.part == p.id)
    };
    let ids: Vec<String> =
        settings.parts.iter().filter(without).map(|p| p.id.to_string()).collect();
    let message = format!(
        "beams are not in contact: other parts pass through them (parts {})",
        ids.join(", ")
    );
    let help = "set contact.beams = true, or put shells around them where their contact matters";
    (!ids.is_empty()).then(|| Problem::warning("contact.beams", message, help))
}

/// Warns if rigid walls may meet tied nodes.
fn ties_at_walls(settings: &Settings) -> Option<Problem> {
    let meets = |t: &&Tie| settings.walls.iter().any(|w| w.allows(t.node));
    let count = settings.ties.iter().filter(meets).count();
    let message = format!(
        "{count} tied nodes do not touch rigid walls: walls act on the masters of tied nodes only"
    );
    let help = "tie the side away from the wall, or exclude the tied nodes by the wall's `except`";
    (count > 0).then(|| Problem::warning("wall", message, help))
}

fn much_added_mass(elements: &ElementStart) -> Option<Problem> {
    let structure = deformable_mass(elements);
    let added = scaled_mass(elements);
    let message =
        format!("mass scaling adds {:.1} % of the structure's mass", 100.0 * added / structure);
    let help = "use a smaller step, or a mesh without tiny elements";
    (added > MUCH_ADDED * structure)
        .then(|| Problem::warning("time.mass_scaling_dt", message, help))
}

/// Warns if a single element has a step much below the median.
fn one_small_element(mesh: &Mesh, elements: &ElementStart) -> Option<Problem> {
    // Rigid bodies and skins have no stable step.
    let mut steps: Vec<f64> =
        elements.stable_dt.iter().copied().filter(|dt| dt.is_finite()).collect();
    let middle = steps.len() / 2;
    let median = if steps.is_empty() {
        0.0
    } else {
        *steps.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let (at, dt) = smallest(&elements.stable_dt).filter(|&(_, dt)| dt < MUCH_SMALLER * median)?;
    let message = format!(
        "element {} alone sets the time step: its stable step is {:.0} times below the median",
        mesh.elements[at].id,
        median / dt
    );
    let help = "remesh it, or use time.subcycles or time.mass_scaling_dt";
    Some(Problem::warning("", message, help))
}
