//! Warning about a job without contact in which one body reaches another: they would pass through
//! each other. Bodies are what elements, ties, rigid bodies and joints connect. Their ways are
//! estimated from above, by initial velocities, prescribed motions, gravity, forces and pressures;
//! airbags are left out.

use super::state::{ElementStart, NodeStart};
use crate::input::mesh_file::systems::cross;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::loads::{MotionForm, PrescribedMotion};
use crumple_proto::mesh::{Mesh, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use petgraph::unionfind::UnionFind;
use std::collections::{BTreeMap, HashMap};

/// Largest number of bodies that are compared with each other.
const COMPARED: usize = 1000;
/// Way of one body against another below which it is at rest, as a fraction of the model's size.
const AT_REST: f64 = 1e-6;

/// Smallest and largest value of each component.
type ComponentBounds = [[f64; 2]; 3];

/// A body that can touch others.
struct SeparateBody {
    /// Box around its nodes [length].
    bounds: Aabb,
    /// Displacement of its nodes up to the end time, without gravity [length].
    way: ComponentBounds,
    /// Number of its elements by part id.
    parts: BTreeMap<u32, usize>,
    /// Its mass [mass].
    mass: f64,
    /// Largest force on it in each direction [force].
    force: ComponentBounds,
    /// Largest acceleration by gravity [length/time^2].
    gravity: ComponentBounds,
    /// True for the directions in which a node is held.
    held: [bool; 3],
    /// True if it has a surface, or particles.
    touches: bool,
}

/// Warns if the job says nothing about contact and a body reaches another one.
pub fn without_contact(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    elements: &ElementStart,
    nodes: &NodeStart,
) -> Option<Problem> {
    if job.contact.is_some() {
        return None;
    }
    let mut bodies = bodies(mesh, settings, elements, nodes);
    bodies.retain(|body| body.touches);
    bodies.truncate(COMPARED);
    let whole = Aabb::around(mesh.nodes.iter().map(|n| n.x));
    let size = (0..3).map(|c| whole.max[c] - whole.min[c]).fold(0.0, f64::max);
    let pairs =
        bodies.iter().enumerate().flat_map(|(i, a)| bodies[..i].iter().map(move |b| (b, a)));
    let end = settings.end_time;
    let (first, second) = pairs.into_iter().find(|(a, b)| reaches(a, b, AT_REST * size, end))?;
    let main = |body: &SeparateBody| {
        let most = body.parts.iter().max_by_key(|&(id, count)| (count, std::cmp::Reverse(id)));
        let part = most.and_then(|(id, _)| settings.parts.iter().find(|p| p.id == *id));
        part.map_or(String::new(), |p| format!("part {}", p.label()))
    };
    let (one, mut other) = (main(first), main(second));
    if one == other {
        other = format!("a separate piece of {other}");
    }
    let message = format!(
        "there is no contact: {one} and {other} are not connected, one moves towards the other, \
         and they may pass through each other"
    );
    let help = "add [contact], or write law = \"none\" in it if this is meant";
    Some(Problem::warning("contact", message, help))
}

/// Returns true if two bodies move relative to each other and may meet up to the time `end`. `rest`
/// is the way below which they are at rest [length]. Bodies that fall alike do not approach.
fn reaches(a: &SeparateBody, b: &SeparateBody, rest: f64, end: f64) -> bool {
    let way: ComponentBounds = std::array::from_fn(|c| {
        let falls = [a, b].map(|body| body.free_gravity(c).map(|g| 0.5 * end * end * g));
        let [of_a, of_b] = if falls[0] == falls[1] { [[0.0; 2]; 2] } else { falls };
        [
            a.way[c][0] + of_a[0] - b.way[c][1] - of_b[1],
            a.way[c][1] + of_a[1] - b.way[c][0] - of_b[0],
        ]
    });
    let moves = way.as_flattened().iter().any(|d| d.abs() > rest);
    moves
        && (0..3).all(|c| {
            let (low, high) =
                (a.bounds.min[c] + way[c][0].min(0.0), a.bounds.max[c] + way[c][1].max(0.0));
            low <= b.bounds.max[c] && b.bounds.min[c] <= high
        })
}

/// Returns the bodies, in the order of their first elements.
fn bodies(
    mesh: &Mesh,
    settings: &Settings,
    elements: &ElementStart,
    nodes: &NodeStart,
) -> Vec<SeparateBody> {
    let place: HashMap<NodeId, usize> =
        mesh.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect();
    let mut sets = connect(mesh, settings, &place);
    let mut number: HashMap<usize, usize> = HashMap::new();
    let mut bodies: Vec<SeparateBody> = Vec::new();
    for (i, e) in mesh.elements.iter().enumerate() {
        let body = *number.entry(sets.find_mut(place[&e.nodes[0]])).or_insert_with(|| {
            bodies.push(SeparateBody::new());
            bodies.len() - 1
        });
        let body = &mut bodies[body];
        *body.parts.entry(e.part).or_default() += 1;
        body.mass += elements.mass_with_scaling(i);
        body.touches |= e.shape.is_shell() || e.shape.is_solid() || e.shape == Shape::Point1;
    }
    let body_of = |n: usize| number.get(&sets.find(n)).copied();
    let end = settings.end_time;
    for (n, node) in mesh.nodes.iter().enumerate() {
        let Some(body) = body_of(n).map(|b| &mut bodies[b]) else { continue };
        body.bounds.include(node.x);
        body.mass += nodes.added_mass[n];
        for c in 0..3 {
            let way = nodes.velocity[n][c] * end;
            body.way[c] = [body.way[c][0].min(way), body.way[c][1].max(way)];
        }
    }
    hold(settings, nodes, &place, |n, c| {
        body_of(n).into_iter().for_each(|b| bodies[b].held[c] = true);
    });
    let loads = &settings.loads;
    for g in &loads.gravity {
        let range = scaled(g.acceleration, factors(&loads.curves, g.curve));
        let some: Vec<usize> = match &g.shares {
            None => (0..bodies.len()).collect(),
            Some(shares) => {
                let mut some: Vec<usize> =
                    shares.iter().filter_map(|(id, _)| body_of(place[id])).collect();
                some.sort_unstable();
                some.dedup();
                some
            }
        };
        some.into_iter().for_each(|b| add(&mut bodies[b].gravity, range));
    }
    for f in &loads.forces {
        let range = scaled(f.force, factors(&loads.curves, f.curve));
        for body in f.nodes.iter().filter_map(|id| body_of(place[id])) {
            add(&mut bodies[body].force, range);
        }
    }
    for p in &loads.pressures {
        let factor = factors(&loads.curves, p.curve);
        for (id, face) in &p.faces {
            let Ok(e) = mesh.elements.binary_search_by_key(id, |e| e.id) else { continue };
            let e = &mesh.elements[e];
            let Some(corners) = e.shape.faces().get(usize::from(*face)) else { continue };
            let [a, b, c, d] = corners.map(|i| mesh.nodes[place[&e.nodes[i]]].x);
            let [u, v] =
                [[a, c], [b, d]].map(|[from, to]| std::array::from_fn(|k| to[k] - from[k]));
            let normal = cross(u, v).map(|n| -0.5 * p.pressure * n);
            let body = body_of(place[&e.nodes[0]]);
            body.into_iter().for_each(|i| add(&mut bodies[i].force, scaled(normal, factor)));
        }
    }
    for body in &mut bodies {
        for c in (0..3).filter(|&c| !body.held[c]) {
            let per_mass = if body.mass > 0.0 { 1.0 / body.mass } else { 0.0 };
            for k in 0..2 {
                body.way[c][k] += 0.5 * end * end * body.force[c][k] * per_mass;
            }
        }
    }
    for motion in &loads.motions {
        // Motions of nodes lead each body once, by its first node.
        let mut led: Vec<usize> = motion.nodes.iter().filter_map(|id| body_of(place[id])).collect();
        led.sort_unstable();
        led.dedup();
        led.into_iter().for_each(|b| bodies[b].lead(motion, (&loads.curves, end)));
    }
    for rigid in &settings.rigid {
        let body = rigid.nodes.first().and_then(|id| body_of(place[id]));
        for (b, motion) in body.into_iter().flat_map(|b| rigid.motions.iter().map(move |m| (b, m)))
        {
            bodies[b].lead(motion, (&loads.curves, end));
        }
    }
    bodies
}

/// Joins the nodes of elements, ties, rigid bodies and joints, and all particles of a part.
fn connect(mesh: &Mesh, settings: &Settings, place: &HashMap<NodeId, usize>) -> UnionFind<usize> {
    let mut sets = UnionFind::new(mesh.nodes.len());
    let mut join = |a: NodeId, b: NodeId| {
        sets.union(place[&a], place[&b]);
    };
    let mut particles: HashMap<u32, NodeId> = HashMap::new();
    for e in &mesh.elements {
        e.corners().iter().for_each(|&n| join(e.nodes[0], n));
        if e.shape == Shape::Point1 {
            join(*particles.entry(e.part).or_insert(e.nodes[0]), e.nodes[0]);
        }
    }
    for tie in &settings.ties {
        tie.masters.iter().for_each(|(master, _)| join(tie.node, *master));
    }
    for body in &settings.rigid {
        body.nodes.iter().for_each(|&n| join(body.nodes[0], n));
    }
    let first = |body: usize| settings.rigid.get(body).and_then(|b| b.nodes.first()).copied();
    for joint in &settings.joints {
        if let Some((a, b)) = joint.first.and_then(first).zip(first(joint.second)) {
            join(a, b);
        }
    }
    sets
}

/// Calls `hold` for each node and direction that is fixed or prescribed; members of a rigid body
/// are as free as their body.
fn hold(
    settings: &Settings,
    nodes: &NodeStart,
    place: &HashMap<NodeId, usize>,
    mut hold: impl FnMut(usize, usize),
) {
    let mut fixed = nodes.fixed.clone();
    for body in &settings.rigid {
        body.nodes.iter().for_each(|id| fixed[place[id]] = body.fixed);
    }
    for (n, bits) in fixed.iter().enumerate() {
        (0..3).filter(|c| bits >> c & 1 == 1).for_each(|c| hold(n, c));
    }
}

impl SeparateBody {
    fn new() -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self {
            bounds: Aabb::EMPTY,
            way: [none; 3],
            parts: BTreeMap::new(),
            mass: 0.0,
            force: [[0.0; 2]; 3],
            gravity: [[0.0; 2]; 3],
            held: [false; 3],
            touches: false,
        }
    }

    /// Returns the smallest and largest acceleration by gravity in a direction in which no node is
    /// held; zero in others [length/time^2].
    fn free_gravity(&self, c: usize) -> [f64; 2] {
        if self.held[c] { [0.0; 2] } else { self.gravity[c] }
    }

    /// Adds a prescribed motion to its way.
    fn lead(&mut self, motion: &PrescribedMotion, (curves, end): (&[Vec<[f64; 2]>], f64)) {
        let factor = factors(curves, motion.curve);
        let time = match motion.form {
            MotionForm::Displacement => 1.0,
            MotionForm::Velocity => end,
            MotionForm::Acceleration => 0.5 * end * end,
            MotionForm::Spin { centre } | MotionForm::Rotation { centre } => {
                let far = |c: usize| {
                    (self.bounds.max[c] - centre[c])
                        .abs()
                        .max((self.bounds.min[c] - centre[c]).abs())
                };
                let most = 2.0 * (0..3).map(|c| far(c).powi(2)).sum::<f64>().sqrt();
                let turns = motion.amount != [0.0; 3] && factor != [0.0; 2];
                if turns {
                    add(&mut self.way, [[-most, most]; 3]);
                }
                return;
            }
        };
        let range = scaled(motion.amount, factor);
        let prescribed = |c: usize| motion.dofs >> c & 1 == 1;
        let of = |c: usize| if prescribed(c) { range[c].map(|d| d * time) } else { [0.0; 2] };
        add(&mut self.way, std::array::from_fn(of));
    }
}

/// Returns the smallest and largest factor of a curve, with 0.
fn factors(curves: &[Vec<[f64; 2]>], curve: Option<usize>) -> [f64; 2] {
    let Some(points) = curve.and_then(|i| curves.get(i)) else { return [0.0, 1.0] };
    points.iter().fold([0.0, 0.0], |[low, high], p| [p[1].min(low), p[1].max(high)])
}

/// Returns the range of a vector that is multiplied by a factor of a range.
fn scaled(vector: [f64; 3], factor: [f64; 2]) -> ComponentBounds {
    vector.map(|v| {
        let [a, b] = factor.map(|f| f * v);
        [a.min(b), a.max(b)]
    })
}

fn add(to: &mut ComponentBounds, more: ComponentBounds) {
    to.as_flattened_mut().iter_mut().zip(more.as_flattened()).for_each(|(a, b)| *a += b);
}

#[cfg(test)]
mod tests {
    use crate::input::job::read_text;
    use std::path::PathBuf;

    /// A square at z = 0 that is held, and one above it with a velocity.
    const JOB: &str = r#"
title = "Two squares"
units = "mm, ms, kg"
end_time = 1.0
[mesh]
nodes = [
    [1, 0.0, 0.0, 0.0], [2, 9.0, 0.0, 0.0], [3, 9.0, 9.0, 0.0], [4, 0.0, 9.0, 0.0],
    [5, 2.0, 2.0, 5.0], [6, 7.0, 2.0, 5.0], [7, 7.0, 7.0, 5.0], [8, 2.0, 7.0, 5.0],
]
shells = [[1, 1, 1, 2, 3, 4], [2, 2, 5, 6, 7, 8]]
[mesh.node_sets]
ground = [1, 2, 3, 4]
body = [5, 6, 7, 8]
[[material]]
name = "steel"
law = "elastic"
density = 7.85e-6
youngs_modulus = 207.0
poisson = 0.3
[[part]]
id = 1
name = "ground"
material = "steel"
thickness = 1.0
[[part]]
id = 2
name = "flyer"
material = "steel"
thickness = 1.0
[[fix]]
nodes = "ground"
dofs = ["x", "y", "z", "rx", "ry", "rz"]
"#;
    const FALLS: &str = "[[initial_velocity]]\nnodes = \"body\"\nvelocity = [0.0, 0.0, -10.0]\n";

    fn warned(more: &str) -> Option<String> {
        let model = read_text(PathBuf::from("job.toml"), format!("{JOB}{more}"), &[]);
        let warnings = model.expect("a job that can run").warnings;
        warnings.into_iter().map(|w| w.to_string()).find(|w| w.contains("there is no contact"))
    }

    #[test]
    fn a_body_that_reaches_another_one_needs_contact() {
        let text = warned(FALLS).expect("a warning");
        assert!(text.contains("part 1 (ground) and part 2 (flyer)"), "{text}");
        assert!(text.contains("add [contact], or write law = \"none\""), "{text}");
        let load = "[[load]]\nnodes = \"body\"\nforce = [0.0, 0.0, -1.0]\n";
        assert!(warned(load).is_some());
        let gravity = "[[gravity]]\nacceleration = [0.0, 0.0, -20.0]\n";
        assert!(warned(gravity).is_some(), "it falls by 10");
    }

    #[test]
    fn bodies_that_do_not_meet_need_no_contact() {
        assert_eq!(warned(&FALLS.replace("-10.0", "-4.0")), None, "it does not get there");
        assert_eq!(warned(&FALLS.replace("-10.0", "10.0")), None, "it flies away");
        let gravity = "[[gravity]]\nacceleration = [0.0, 0.0, -20.0]\n";
        let free = JOB.split("[[fix]]").next().unwrap();
        let read = |text: String| read_text(PathBuf::from("job.toml"), text, &[]).unwrap();
        let falling = read(format!("{free}{gravity}"));
        assert!(falling.warnings.iter().all(|w| !w.message.contains("no contact")), "both fall");
        assert_eq!(warned(&format!("{FALLS}[contact]\nlaw = \"none\"\n")), None, "it is meant");
    }

    #[test]
    fn bodies_that_an_element_connects_need_no_contact() {
        let text = format!("{JOB}{FALLS}").replace("7, 8]]", "7, 8], [3, 2, 3, 4, 8, 7]]");
        let model = read_text(PathBuf::from("job.toml"), text, &[]).expect("a job that can run");
        assert!(model.warnings.iter().all(|w| !w.message.contains("there is no contact")));
    }
}
