//! Folds whose ridges collide between nodes (C04).

use super::measure::position;
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::{Bench, Check};
use crumple_worker::contact::geometry::nearest;
use crumple_worker::engine::Engine;
use crumple_worker::math::row::V3;

/// Check of C04: roofs ridge on ridge.
pub const ROOFS: Check = Check { name: "roofs ridge on ridge", quick: true, run: roofs };
/// Check of C04: edges of three shells, rims, cages, and edges of solids.
pub const JOINTS: Check =
    Check { name: "joints, cages, a fold on a solid's edge", quick: true, run: joints };

/// Length of a body, its shells along it, and their thickness [m].
const LENGTH: f64 = 0.1;
const CELLS: usize = 5;
const THICKNESS: f64 = 1e-3;
/// Approach velocity [m/s] and initial gap [m].
const V: f64 = 5.0;
const AIR: f64 = 2e-4;
/// Duration of a run [s].
const END: f64 = 4e-3;

/// A sheet that is bent along its length, ridge up or down, with or without a post under the
/// ridge.
struct Roof {
    part: u32,
    /// Middle of the ridge [m].
    at: [f64; 3],
    /// Direction of the ridge in the plane, and slope of the flanks [degree].
    angle: f64,
    slope: f64,
    ridge_up: bool,
    post: bool,
    /// Shells along the ridge.
    cells: usize,
}

/// Nodes on the rims of a roof, to be held.
struct Feet(Vec<u32>);

impl Roof {
    fn build(&self, scene: &mut Scene) -> (Vec<u32>, Feet) {
        const FLANK: f64 = 0.03;
        let (sin, cos) = self.angle.to_radians().sin_cos();
        let (s, c) = self.slope.to_radians().sin_cos();
        let down = if self.ridge_up { -1.0 } else { 1.0 };
        let place = |x: f64, across: f64, height: f64| {
            let along = LENGTH * (x - 0.5);
            [
                self.at[0] + cos * along - sin * across,
                self.at[1] + sin * along + cos * across,
                self.at[2] + down * height,
            ]
        };
        let first = scene.count() + 1;
        let sheet = scene.grid(self.part, [self.cells, 4], |x, y| {
            let across = FLANK * (2.0 * y - 1.0);
            place(x, c * across, s * across.abs())
        });
        let mut feet: Vec<u32> =
            (0..=self.cells).flat_map(|i| [sheet.at(i, 0), sheet.at(i, 4)]).collect();
        if self.post {
            let ridge: Vec<u32> = (0..=self.cells).map(|i| sheet.at(i, 2)).collect();
            let mut next = ridge.iter().copied();
            let post = scene.grid_of(
                self.part,
                [self.cells, 1],
                |x, y| place(x, 0.0, FLANK * y),
                |scene, p| {
                    let on_ridge = (p[2] - self.at[2]).abs() < 1e-12;
                    if on_ridge { next.next().unwrap_or(0) } else { scene.node(p) }
                },
            );
            feet.extend((0..=self.cells).map(|i| post.at(i, 1)));
        }
        ((first..=scene.count()).collect(), Feet(feet))
    }
}

/// Surface of a body as faces and edges.
#[derive(Default)]
struct Skin {
    nodes: Vec<u32>,
    /// Corners; a triangle repeats its third.
    faces: Vec<[u32; 4]>,
    edges: Vec<[u32; 2]>,
}

/// Splits the bilinear surface between four corners into triangles. Two triangles would give a
/// warped quad an edge along its diagonal that is off the surface; loaded roofs warp by twice
/// the thickness.
fn facets(corners: [V3; 4]) -> impl Iterator<Item = [V3; 3]> {
    const CUTS: usize = 4;
    let [a, b, c, d] = corners;
    let at = move |i: usize, j: usize| {
        let (x, y) = (i as f64 / CUTS as f64, j as f64 / CUTS as f64);
        (a * (1.0 - x) + b * x) * (1.0 - y) + (d * (1.0 - x) + c * x) * y
    };
    let cells = (0..CUTS).flat_map(|i| (0..CUTS).map(move |j| (i, j)));
    cells.flat_map(move |(i, j)| {
        let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[p, q, r], [p, r, s]]
    })
}

impl Skin {
    /// Collects the faces, edges and nodes of the elements of some parts, by the engine's
    /// numbers of parts and nodes.
    fn new(e: &Engine, parts: impl Fn(u32) -> bool) -> Self {
        let mut skin = Self::default();
        for element in e.blocks.elements.iter().filter(|el| parts(el.record.part)) {
            for face in element.record.shape.faces() {
                let n = face.map(|c| element.nodes[c]);
                skin.faces.push(n);
                skin.edges
                    .extend((0..4).map(|k| [n[k].min(n[(k + 1) % 4]), n[k].max(n[(k + 1) % 4])]));
                skin.nodes.extend(n);
            }
        }
        skin.edges.retain(|e| e[0] != e[1]);
        skin.edges.sort_unstable();
        skin.edges.dedup();
        skin.nodes.sort_unstable();
        skin.nodes.dedup();
        skin
    }

    fn at(e: &Engine, n: u32) -> V3 {
        V3::from(position(e, n + 1))
    }

    /// Counts the points at which edges of `self` go through faces of `other`.
    fn pierces(&self, other: &Self, e: &Engine) -> usize {
        let volume = |a: &V3, b: &V3, c: &V3, d: &V3| (b - a).cross(&(c - a)).dot(&(d - a));
        let through = |p: &V3, q: &V3, [a, b, c]: &[V3; 3]| {
            let apart = volume(a, b, c, p) * volume(a, b, c, q) < 0.0;
            let turns = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
            apart && (turns.iter().all(|&t| t > 0.0) || turns.iter().all(|&t| t < 0.0))
        };
        let facets: Vec<[V3; 3]> =
            other.faces.iter().flat_map(|f| facets(f.map(|n| Self::at(e, n)))).collect();
        let ends = self.edges.iter().map(|edge| edge.map(|n| Self::at(e, n)));
        ends.map(|[p, q]| facets.iter().filter(|t| through(&p, &q, t)).count()).sum()
    }

    /// Returns the smallest distance of the two [m].
    fn distance(&self, other: &Self, e: &Engine) -> f64 {
        let mut least = f64::INFINITY;
        for [i, j] in &self.edges {
            let (p, q) = (Self::at(e, *i), Self::at(e, *j));
            for [k, l] in &other.edges {
                least = least.min(between(p, q, Self::at(e, *k), Self::at(e, *l)));
            }
        }
        for (nodes, faces) in [(&self.nodes, &other.faces), (&other.nodes, &self.faces)] {
            for &n in nodes {
                let p = Self::at(e, n);
                for f in faces {
                    let near = nearest(&p, &f.map(|n| Self::at(e, n)), f[2] == f[3]);
                    least = least.min(near.map_or(f64::INFINITY, |near| (p - near.point).norm()));
                }
            }
        }
        least
    }
}

/// Returns the distance of two line segments: Ericson, Real-Time Collision Detection (2005),
/// 5.1.9.
fn between(p: V3, q: V3, r: V3, s: V3) -> f64 {
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, e, f, c, b) = (u.dot(&u), v.dot(&v), v.dot(&w), u.dot(&w), u.dot(&v));
    let det = a * e - b * b;
    let first = if det > 0.0 { ((b * f - c * e) / det).clamp(0.0, 1.0) } else { 0.0 };
    let second = (b * first + f) / e;
    let (first, second) = match second {
        t if t < 0.0 => ((-c / a).clamp(0.0, 1.0), 0.0),
        t if t > 1.0 => (((b - c) / a).clamp(0.0, 1.0), 1.0),
        t => (first, t),
    };
    (w + u * first - v * second).norm()
}

/// Runs a scene in which parts up to `last` fall on the others, with every law, and compares
/// their smallest distance.
fn compare(
    bench: &Bench,
    name: &str,
    last: u32,
    touch: f64,
    build: impl Fn(&mut Scene),
) -> Result<Vec<CheckRow>, String> {
    const EVERY: u64 = 5;
    const TOUCH: &str = "sum of the half thicknesses; penalty laws penetrate";
    let mut all = Vec::new();
    for law in bench.laws().chain(["mortar"]) {
        let mut scene = Scene::new(END);
        scene.elastic("steel", STEEL);
        build(&mut scene);
        scene.add(&format!("[contact]\nlaw = \"{law}\""));
        let (mut through, mut least) = (0, f64::INFINITY);
        let mut skins = None;
        let run = bench.watch(&format!("C04 {law} {name}"), &scene, |e| {
            let [above, below] = skins
                .get_or_insert_with(|| [Skin::new(e, |p| p < last), Skin::new(e, |p| p >= last)]);
            if e.clock.cycle.is_multiple_of(EVERY) {
                through = through.max(above.pierces(below, e) + below.pierces(above, e));
                least = least.min(above.distance(below, e));
            }
        })?;
        let variant = format!("{law}, {name}");
        let crossed = run
            .engine
            .contact
            .as_ref()
            .map_or(0, |c| c.crossings(&run.engine.nodes, run.engine.clock.time).len());
        let created = run.energies.contact / run.initial;
        all.push(
            CheckRow::new("edges through surfaces, most on the way", &variant, "", through as f64)
                .at_most(0.0, "exact"),
        );
        all.push(
            CheckRow::new("edges seen in surfaces", &variant, "", crossed as f64)
                .at_most(0.0, "exact"),
        );
        let row = CheckRow::new("least distance / touching distance", &variant, "", least / touch)
            .at_least(0.8, TOUCH);
        all.push(row);
        all.push(
            CheckRow::new("work of contact / energy at the start", &variant, "", created)
                .at_most(1e-3, "contact gives no energy; limit of the catalogue for part A"),
        );
        all.extend(run.energy_rows(&variant, 0.01));
    }
    Ok(all)
}

/// Collides two roofs, the upper one upside down and free, the lower one on its feet. The ridges
/// cross between nodes.
fn roofs(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    // Heavy loads flatten the ridges.
    for (angle, slope, load) in
        [(90.0, 45.0, 0.0), (30.0, 45.0, 0.0), (90.0, 15.0, 3.0), (30.0, 15.0, 3.0)]
    {
        let loaded = if load > 0.0 { format!(" under {load} kg") } else { String::new() };
        let name = format!("roofs of {slope} degrees{loaded}, ridges crossing at {angle}");
        all.extend(compare(bench, &name, 1, THICKNESS, |scene| {
            let sloping = |part, z: f64, angle, ridge_up| Roof {
                slope,
                ..roof(part, [0.0, 0.0, z], angle, ridge_up)
            };
            let (above, rims) = sloping(1, HALF_GAP, angle, false).build(scene);
            if load > 0.0 {
                scene.mass(&rims.0, load);
            }
            let (_, feet) = sloping(2, -HALF_GAP, 0.0, true).build(scene);
            add_shell_parts(scene);
            scene.start(&above, [0.0, 0.0, -V], [0.0; 3]);
            scene.fix(&feet.0, "x y z");
        })?);
    }
    Ok(all)
}

/// Distance of the ridges from the plane between them [m].
const HALF_GAP: f64 = 0.5 * (THICKNESS + AIR);

/// Collides joints of shells and solids: a narrow plate on the rims of a T, a ridge on a ridge
/// with a post, a cage of angles, a ridge on the edge of a solid.
fn joints(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all =
        compare(bench, "a plate on the stem and the flange of a T", 1, THICKNESS, plate_on_t)?;
    all.extend(compare(bench, "a ridge on a ridge with a post", 1, THICKNESS, ridge_on_post)?);
    all.extend(compare(bench, "a cage of angles under 1 kg", 1, THICKNESS, cage)?);
    all.extend(compare(bench, "a ridge on a solid's edge", 1, 0.5 * THICKNESS, ridge_on_solid)?);
    Ok(all)
}

/// Returns a roof of 45 degrees without a post.
fn roof(part: u32, at: [f64; 3], angle: f64, ridge_up: bool) -> Roof {
    Roof { part, at, angle, slope: 45.0, ridge_up, post: false, cells: CELLS }
}

fn add_shell_parts(scene: &mut Scene) {
    (1..=2).for_each(|part| scene.part(part, "steel", THICKNESS, "points = 3"));
}

/// Returns the places along a ridge at which it has nodes [m].
fn along_ridge() -> impl Iterator<Item = f64> {
    (0..=CELLS).map(|i| LENGTH * (i as f64 / CELLS as f64 - 0.5))
}

/// The T lies on its side, so that the rims of the stem and of half the flange are up.
fn plate_on_t(scene: &mut Scene) {
    const ARM: f64 = 0.025;
    let z = HALF_GAP;
    let plate = scene.grid(1, [5, 1], |x, y| [0.012 * (y - 0.5), LENGTH * (x - 0.5), z]);
    let tip = ARM / 2f64.sqrt();
    let joint: Vec<u32> = along_ridge().map(|x| scene.node([x, 0.0, -z - tip])).collect();
    let mut feet = joint.clone();
    for (across, up) in [(tip, 0.0), (-tip, 0.0), (tip, -2.0 * tip)] {
        let ends: Vec<u32> = joint
            .iter()
            .map(|&n| {
                let [x, ..] = scene.at(n);
                scene.node([x, across, -z + up])
            })
            .collect();
        (0..CELLS)
            .for_each(|i| _ = scene.shell(2, &[joint[i], joint[i + 1], ends[i + 1], ends[i]]));
        if up < 0.0 {
            feet.extend(ends);
        }
    }
    add_shell_parts(scene);
    scene.start(plate.all(), [0.0, 0.0, -V], [0.0; 3]);
    scene.fix(&feet, "x y z");
}

fn ridge_on_post(scene: &mut Scene) {
    let (above, _) = roof(1, [0.0, 0.0, HALF_GAP], 90.0, false).build(scene);
    let (_, feet) = Roof { post: true, ..roof(2, [0.0, 0.0, -HALF_GAP], 0.0, true) }.build(scene);
    add_shell_parts(scene);
    scene.start(&above, [0.0, 0.0, -V], [0.0; 3]);
    scene.fix(&feet.0, "x y z");
}

/// Three angles across three others, under 1 kg.
fn cage(scene: &mut Scene) {
    let mut above = Vec::new();
    for (k, cells) in [(-1.0, 5), (0.0, 4), (1.0, 5)] {
        let part = |part, ridge_up, at, angle| Roof { cells, ..roof(part, at, angle, ridge_up) };
        above.extend(part(1, false, [0.045 * k, 0.0, HALF_GAP], 90.0).build(scene).0);
        let (_, feet) = part(2, true, [0.0, 0.045 * k, -HALF_GAP], 0.0).build(scene);
        scene.fix(&feet.0, "x y z");
    }
    add_shell_parts(scene);
    scene.mass(&above, 1.0);
    scene.start(&above, [V, 0.5 * V, -V], [0.0; 3]);
}

/// A ridge on a bar that stands on an edge.
fn ridge_on_solid(scene: &mut Scene) {
    const DIAGONAL: f64 = 0.02;
    let (above, _) = roof(1, [0.0, 0.0, 0.5 * THICKNESS + AIR], 90.0, false).build(scene);
    let mut bottom = Vec::new();
    let ring: Vec<[u32; 4]> = along_ridge()
        .map(|x| {
            let ring =
                [(0.0, 0.0), (-DIAGONAL, -DIAGONAL), (0.0, -2.0 * DIAGONAL), (DIAGONAL, -DIAGONAL)];
            let nodes = ring.map(|(y, z)| scene.node([x, y, z]));
            bottom.push(nodes[2]);
            nodes
        })
        .collect();
    for pair in ring.windows(2) {
        let [[a, b, c, d], [e, f, g, h]] = [pair[0], pair[1]];
        scene.solid(2, [a, b, c, d, e, f, g, h]);
    }
    scene.part(1, "steel", THICKNESS, "points = 3");
    scene.solid_part(2, "steel", "");
    scene.start(&above, [0.0, 0.0, -V], [0.0; 3]);
    scene.fix(&bottom, "x y z");
}
