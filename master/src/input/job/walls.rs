//! Rigid walls of a job: checks, and conversion to numbers and ids.

use super::loads::{Curves, starts_with_jump};
use super::state::{NodeSets, NodeStart, fastest_wave};
use super::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, WallInput};
use crumple_proto::loads::{MotionForm, PrescribedMotion};
use crumple_proto::mesh::Mesh;
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::rigid::RigidBody;
use crumple_proto::wall::{ResolvedWall, WallForm, WallMotion};
use crumple_worker::constraints::walls::WallSurface;
use crumple_worker::math::row::V3;
use std::collections::HashSet;

/// Speed at which a wall expels a node, as a fraction of the wave speed, above which it is
/// reported. Smaller speeds are round-off of the mesh.
const WARN_SPEED: f64 = 1e-6;
/// Fraction of the wave speed above which the run would fail, because no material carries such a
/// strain.
const THROWN: f64 = 0.1;
/// Largest part of an edge across the normal, as a fraction, for which it counts as parallel to
/// the normal.
const ALONG: f64 = 1e-6;

/// Direction of a sphere, which has no effect.
const UPWARDS: [f64; 3] = [0.0, 0.0, 1.0];

/// Checks everything of the walls that needs no mesh.
pub fn check(job: &Job, findings: &mut JobProblems) {
    for (i, wall) in job.wall.iter().enumerate() {
        for (key, message, help) in faults(wall) {
            findings.add(Problem::error(join(i, key), message, help));
        }
        if wall.mass.is_some() && job.time.damping > 0.0 {
            let message = "damping cannot be combined with a wall that has a mass: the wall would \
                           not receive all the momentum that it gives to nodes";
            let help = "remove time.damping, or prescribe the motion of the wall by `velocity`";
            findings.add(Problem::error(join(i, "mass"), message, help));
        }
    }
}

/// Faulty key (empty for the whole wall), message, advice.
type WallFault = (&'static str, String, &'static str);

fn faults(wall: &WallInput) -> Vec<WallFault> {
    let mut found = Vec::new();
    let mut say = |wrong: bool, key, message: &str, help| {
        if wrong {
            found.push((key, message.into(), help));
        }
    };
    shape_faults(wall, &mut say);
    rectangle_faults(wall, &mut say);
    motion_faults(wall, &mut say);
    let message = format!(
        "a wall begins at {:?} and ends at {:?}",
        wall.birth,
        wall.death.unwrap_or(f64::INFINITY)
    );
    let no_time = wall.birth < 0.0 || wall.death.is_some_and(|death| death <= wall.birth);
    say(no_time, "birth", &message, "give a `birth` of 0 or above, and a `death` above it");
    found
}

/// Adds a fault if its condition is true: condition, key, message, advice.
type AddFault<'a> = &'a mut dyn FnMut(bool, &'static str, &str, &'static str);

/// Finds faults of a plane, a cylinder or a sphere.
fn shape_faults(wall: &WallInput, say: AddFault<'_>) {
    let flat = wall.normal.is_some();
    let round = wall.axis.is_some();
    let ball = is_sphere(wall);
    let normal = "give the direction from the wall to the model, such as [1, 0, 0]";
    say(
        !flat && !round && !ball,
        "",
        "a wall has no normal",
        "give `normal`, or `axis` and `radius` of a cylinder, or `radius` of a sphere",
    );
    say(
        flat && round,
        "axis",
        "a wall has both a normal and an axis",
        "remove one: a cylinder has no `normal`",
    );
    let no_way = |given: Option<[f64; 3]>| given.is_some_and(|v| unit(v).is_none());
    let message =
        format!("the normal {:?} of a wall has no direction", wall.normal.unwrap_or_default());
    say(no_way(wall.normal), "normal", &message, normal);
    let message =
        format!("the axis {:?} of a wall has no direction", wall.axis.unwrap_or_default());
    say(
        no_way(wall.axis),
        "axis",
        &message,
        "give the direction along the cylinder, such as [0, 0, 1]",
    );
    let radius = "give a cylinder an `axis` and a `radius` above 0, a sphere a `radius` above 0";
    say(round && wall.radius.is_none(), "", "a wall has an axis without a radius", radius);
    say(
        flat && !round && wall.radius.is_some(),
        "radius",
        "a wall has both a normal and a radius",
        "remove one: planes have no radius, and a sphere has no normal",
    );
    say(
        wall.radius.is_some_and(|r| r <= 0.0),
        "radius",
        "the radius of a wall is not above 0",
        radius,
    );
    let length = "give a cylinder a length of 0 (infinite) or above; remove it from other walls";
    say(
        wall.length < 0.0 || wall.length > 0.0 && !round,
        "length",
        "the length of a wall is below 0, or the wall is no cylinder",
        length,
    );
}

/// Finds faults of the sides of a rectangle.
fn rectangle_faults(wall: &WallInput, say: AddFault<'_>) {
    let round = wall.axis.is_some() || is_sphere(wall);
    let sides =
        "give a rectangle `edge`, the direction of its first side, and `lengths` of both sides";
    let rectangle = wall.edge.is_some() || wall.lengths.is_some();
    let half = wall.edge.is_some() != wall.lengths.is_some();
    say(half, "", "a wall has one of edge and lengths without the other", sides);
    let message = "a cylinder or a sphere has neither edge nor lengths";
    say(rectangle && round, "", message, "give `length` of a cylinder, or `radius` of a sphere");
    let short = wall.lengths.is_some_and(|l| l.iter().any(|&l| l < 0.0));
    say(
        short,
        "lengths",
        "the lengths of a wall are below 0",
        "they have to be above 0, or 0 for an infinite side",
    );
    let lost = wall.edge.is_some()
        && wall.normal.and_then(unit).is_some_and(|n| square(wall, &n).is_none());
    say(
        lost,
        "edge",
        "the edge of a wall is parallel to its normal",
        "give the direction of a side, at an angle to the normal",
    );
}

/// Finds faults of friction, mass and motion.
fn motion_faults(wall: &WallInput, say: AddFault<'_>) {
    let round = wall.axis.is_some() || is_sphere(wall);
    let led = wall.velocity.is_some() || wall.displacement.is_some();
    let message = format!("`friction` is {:?}", wall.friction);
    say(wall.friction < 0.0, "friction", &message, "it has to be 0 or above");
    let mass = "it has to be above 0; remove it for a fixed wall or one with prescribed motion";
    say(wall.mass.is_some_and(|m| m <= 0.0), "mass", "the mass of a wall is not above 0", mass);
    let guide = "remove it: only planes and rectangles have a mass, and move along their normal";
    say(wall.mass.is_some() && round, "mass", "a cylinder or a sphere cannot have a mass", guide);
    say(
        wall.mass.is_some() && led,
        "mass",
        "a wall with a mass cannot have a prescribed motion",
        "remove its mass, or its velocity or displacement",
    );
    let idle = wall.speed != 0.0 && wall.mass.is_none();
    say(
        idle,
        "speed",
        "a wall has a speed but no mass",
        "give it a `mass`, or prescribe its `velocity`",
    );
    let both = wall.velocity.is_some() && wall.displacement.is_some();
    say(both, "displacement", "a wall has both a velocity and a displacement", "give one of them");
    let unused = wall.curve.is_some() && !led;
    say(
        unused,
        "curve",
        "the curve of a wall has no effect",
        "give the wall a `velocity` or a `displacement`",
    );
}

/// Resolves the walls of a job in which [`check`] has found no errors.
pub fn resolve(job: &Job, sets: &NodeSets<'_>, findings: &mut JobProblems) -> Vec<ResolvedWall> {
    let curves = Curves::quietly(job);
    let mut walls = Vec::new();
    for (i, spec) in job.wall.iter().enumerate() {
        let mut set = |name: &Option<String>, key| {
            let name = name.as_ref()?;
            Some(sets.ids(name, join(i, key), findings).unwrap_or_default())
        };
        let (nodes, except) =
            (set(&spec.nodes, "nodes"), set(&spec.except, "except").unwrap_or_default());
        let curve = curves.find(&spec.curve, &join(i, "curve"), findings);
        let any = is_sphere(spec).then_some(UPWARDS);
        let Some(direction) = spec.normal.or(spec.axis).or(any).and_then(unit) else { continue };
        let form = match (spec.lengths, spec.radius) {
            (Some(lengths), _) if lengths != [0.0; 2] => {
                let Some(edge) = square(spec, &direction) else { continue };
                WallForm::Rectangle { edge, lengths }
            }
            (_, Some(radius)) if any.is_some() => WallForm::Sphere { radius },
            (_, Some(radius)) => WallForm::Cylinder { radius, length: spec.length },
            // An unlimited rectangle ignores nodes behind it; a plane would throw them out.
            _ if spec.birth > 0.0 => {
                WallForm::Rectangle { edge: across(&direction), lengths: [0.0; 2] }
            }
            _ => WallForm::Plane,
        };
        let given =
            [(MotionForm::Velocity, spec.velocity), (MotionForm::Displacement, spec.displacement)];
        let led = given.into_iter().find_map(|(form, amount)| Some((form, amount?)));
        let motion = match (spec.mass, led) {
            (Some(mass), _) => WallMotion::Pushed { mass, speed: spec.speed },
            (None, Some((form, amount))) => {
                if starts_with_jump(form, &curves, &spec.curve, curve) {
                    let help = "give it a curve that is 0 at time 0";
                    let message = "the displacement of a wall starts with a jump";
                    findings.add(Problem::error(join(i, "displacement"), message, help));
                }
                WallMotion::Led(PrescribedMotion {
                    nodes: Vec::new(),
                    dofs: 0b111,
                    form,
                    amount,
                    curve,
                    window: None,
                })
            }
            (None, None) => WallMotion::Still,
        };
        let (name, point, friction) = (spec.name.clone(), spec.point, spec.friction);
        let is_whole = spec.birth <= 0.0 && spec.death.is_none();
        let window = (!is_whole).then_some([spec.birth, spec.death.unwrap_or(f64::MAX)]);
        walls.push(ResolvedWall {
            name,
            point,
            direction,
            form,
            friction,
            nodes,
            except,
            motion,
            window,
        });
    }
    walls
}

/// Returns true for a sphere, which has a radius but no direction.
pub fn is_sphere(wall: &WallInput) -> bool {
    wall.radius.is_some() && wall.axis.is_none() && wall.normal.is_none()
}

fn join(i: usize, key: &str) -> String {
    if key.is_empty() { format!("wall.{i}") } else { format!("wall.{i}.{key}") }
}

/// Returns the unit vector along `v`, if it has a direction. The vector is scaled by its largest
/// component first, so that very small and very large vectors work too.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let scaled = v.map(|c| c / largest);
    let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
    (largest > 0.0 && length.is_finite()).then(|| scaled.map(|c| c / length))
}

/// Returns a unit vector perpendicular to a unit vector.
fn across(n: &[f64; 3]) -> [f64; 3] {
    // A unit vector has a component of 0.57 or more off the z axis, or along it.
    let flat = n[0].abs().max(n[1].abs()) > 0.5;
    let v = if flat { [n[1], -n[0], 0.0] } else { [0.0, n[2], -n[1]] };
    unit(v).unwrap_or([0.0, 0.0, 1.0])
}

/// Returns the edge of a rectangle, made perpendicular to its unit normal.
fn square(wall: &WallInput, normal: &[f64; 3]) -> Option<[f64; 3]> {
    let edge = unit(wall.edge?)?;
    let along: f64 = (0..3).map(|c| edge[c] * normal[c]).sum();
    let across = [0, 1, 2].map(|c| edge[c] - along * normal[c]);
    let size = across.iter().map(|c| c * c).sum::<f64>().sqrt();
    if size > ALONG { unit(across) } else { None }
}

/// Reports nodes that start behind walls, given the length `dt` of the first step [time]. Infinite
/// planes expel them: a speed of more than a tenth of the wave speed of the materials is an error.
/// Cylinders and spheres let them pass. Rectangles do too, but nodes may well be behind them.
/// Walls that the section `restart` adds are not there at the start.
pub fn behind(
    job: &Job,
    settings: &Settings,
    mesh: &Mesh,
    start: &NodeStart,
    dt: f64,
    findings: &mut JobProblems,
) {
    let wave = fastest_wave(job);
    let first = &settings.walls[..settings.walls.len().saturating_sub(job.restart.wall.len())];
    let free = (0..mesh.nodes.len()).filter(|&n| start.fixed[n] & 7 != 7);
    let free: Vec<usize> = free.collect();
    let bodies = || settings.rigid.iter().filter(|body| body.window.is_none());
    let members = |body: &RigidBody| body.nodes.clone();
    let of_bodies: HashSet<NodeId> = bodies().flat_map(members).collect();
    let of_led_bodies: HashSet<NodeId> = bodies().filter(|b| is_led(b)).flat_map(members).collect();
    for (w, wall) in first.iter().enumerate() {
        let (path, name) = (format!("wall.{w}"), wall.label(w));
        let surface = WallSurface::new(wall);
        let met = free.iter().filter(|&&n| wall.allows(mesh.nodes[n].id));
        match wall.form {
            WallForm::Plane => {
                let depths = met
                    .filter(|&&n| !of_bodies.contains(&mesh.nodes[n].id))
                    .map(|&n| (-surface.distance(&V3::from(mesh.nodes[n].x)), mesh.nodes[n].id));
                let deep = depths.filter(|d| d.0 / dt > WARN_SPEED * wave);
                let Some((nodes, id, most)) = deepest(deep) else { continue };
                let message = format!(
                    "{nodes} behind wall `{name}`, node {id} by {most:.3e}: \
                     the first step would expel it with the speed {:.3e}",
                    most / dt
                );
                let help = "move the wall, reverse its normal (it points to the model), or exclude \
                            these nodes by `nodes` or `except`";
                findings.add(match most / dt > THROWN * wave {
                    true => Problem::error(path, message, help),
                    false => Problem::warning(path, message, help),
                });
            }
            WallForm::Cylinder { .. } | WallForm::Sphere { .. } if wall.acts_at(0.0) => {
                let meets = met.filter(|&&n| !of_led_bodies.contains(&mesh.nodes[n].id));
                let deep = meets.filter_map(|&n| {
                    let speed = V3::from(start.velocity[n]).norm();
                    let depth = surface.depth_of_ignored(&mesh.nodes[n].x.into(), dt * speed)?;
                    Some((depth, mesh.nodes[n].id))
                });
                let Some((nodes, id, most)) = deepest(deep) else { continue };
                let message = format!(
                    "{nodes} inside wall `{name}`, node {id} by {most:.3e}: \
                     cylinders and spheres stop only nodes from outside, so these pass through it"
                );
                let help = "move the wall away, make its `radius` smaller, or exclude these nodes \
                            by `nodes` or `except` if they are to pass";
                findings.add(Problem::warning(path, message, help));
            }
            _ => {}
        }
    }
}

/// Returns true if a body has no translation that a wall could change.
fn is_led(body: &RigidBody) -> bool {
    body.motions.iter().fold(body.fixed, |all, motion| all | motion.dofs) & 7 == 7
}

/// Returns the number of nodes in words, the deepest node, and its depth [length], if there is any.
fn deepest(depths: impl Iterator<Item = (f64, NodeId)>) -> Option<(String, NodeId, f64)> {
    let (count, (most, id)) = depths.fold((0, (0.0, NodeId(0))), |(count, most), d| {
        (count + 1, if d.0 > most.0 { d } else { most })
    });
    let nodes = if count == 1 { "1 node starts".into() } else { format!("{count} nodes start") };
    (count > 0).then_some((nodes, id, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_become_unit_vectors() {
        let normal = unit([3e-200, 0.0, 4e-200]).unwrap();
        assert!((normal[0] - 0.6).abs() < 1e-15 && (normal[2] - 0.8).abs() < 1e-15);
        assert_eq!((unit([0.0; 3]), unit([f64::INFINITY, 0.0, 0.0])), (None, None));
        let wall = WallInput { edge: Some([1.0, 2.0, 5.0]), ..WallInput::default() };
        let edge = square(&wall, &[0.0, 0.0, 1.0]).unwrap();
        assert!(edge[2].abs() < 1e-15 && (edge[1] - 2.0 * edge[0]).abs() < 1e-15);
    }
}
