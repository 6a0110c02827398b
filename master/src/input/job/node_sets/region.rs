//! Rules by coordinates: regions of space, and distances from nodes.

use super::super::validate::JobProblems;
use crumple_proto::job::{SetInput, SetRule};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;
use std::collections::HashMap;

/// Region of space.
pub enum SetRegion {
    /// Smallest and largest coordinates [length].
    Box([f64; 3], [f64; 3]),
    /// Centre and radius [length].
    Sphere([f64; 3], f64),
    /// Point [length] and unit normal.
    Plane([f64; 3], [f64; 3]),
    /// Point [length] and unit normal.
    HalfSpace([f64; 3], [f64; 3]),
    /// Start of the axis, unit vector along it, radius and length [length].
    Cylinder([f64; 3], [f64; 3], f64, Option<f64>),
}

impl SetRegion {
    /// Returns the region of a rule; `None` if the rule has none or lacks keys.
    pub fn of(set: &SetInput) -> Option<SetRegion> {
        Some(match set.rule {
            SetRule::Box => SetRegion::Box(set.min?, set.max?),
            SetRule::Sphere => SetRegion::Sphere(set.point?, set.radius?),
            SetRule::Plane => SetRegion::Plane(set.point?, unit(set.normal?)),
            SetRule::HalfSpace => SetRegion::HalfSpace(set.point?, unit(set.normal?)),
            SetRule::Cylinder => {
                SetRegion::Cylinder(set.point?, unit(set.axis?), set.radius?, set.length)
            }
            _ => return None,
        })
    }

    /// Returns how far a point is outside, 0 or below if it is inside. At the edges of a box and
    /// of the ends of a cylinder this is the largest distance from one of the surfaces [length].
    pub fn outside(&self, x: [f64; 3]) -> f64 {
        match self {
            SetRegion::Box(min, max) => {
                (0..3).map(|c| (min[c] - x[c]).max(x[c] - max[c])).fold(f64::MIN, f64::max)
            }
            SetRegion::Sphere(centre, radius) => length(minus(x, *centre)) - radius,
            SetRegion::Plane(point, normal) => dot(minus(x, *point), *normal).abs(),
            SetRegion::HalfSpace(point, normal) => -dot(minus(x, *point), *normal),
            SetRegion::Cylinder(start, axis, radius, size) => {
                let from = minus(x, *start);
                let along = dot(from, *axis);
                let off = length(minus(from, axis.map(|a| a * along))) - radius;
                size.map_or(off, |size| off.max(-along).max(along - size))
            }
        }
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] - b[c])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let largest = a.iter().fold(0.0f64, |most, c| most.max(c.abs()));
    let scaled = a.map(|c| c / largest);
    let size = length(scaled);
    scaled.map(|c| c / size)
}

/// Returns those of `among` that are nearest to the point of a set. Reports an error and returns
/// `None` if there are fewer than requested.
pub fn nearest_nodes(
    set: &SetInput,
    i: usize,
    mesh: &Mesh,
    among: Vec<usize>,
    findings: &mut JobProblems,
) -> Option<Vec<usize>> {
    let (point, count) = (set.point?, set.count.unwrap_or(1) as usize);
    if count > among.len() && !set.allow_empty {
        let message = format!("set `{}`: there are only {} nodes", set.name, among.len());
        let help = match among.len() {
            0 => "give an `of` that has nodes, or `allow_empty = true`".to_string(),
            all => format!("take a `count` of at most {all}"),
        };
        findings.add(Problem::error(format!("set.{i}.count"), message, help));
        return None;
    }
    let mut by_distance: Vec<(f64, usize)> =
        among.into_iter().map(|n| (length(minus(mesh.nodes[n].x, point)), n)).collect();
    by_distance.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut nodes: Vec<usize> = by_distance.into_iter().take(count).map(|(_, n)| n).collect();
    nodes.sort_unstable();
    Some(nodes)
}

/// Returns those of `among` that are up to `distance` [length] from a node of `from`.
pub fn within(mesh: &Mesh, from: &[usize], distance: f64, among: &[usize]) -> Vec<usize> {
    let at = |n: usize| mesh.nodes[n].x;
    // Cells have the size of the distance, so that the nodes in question are in 27 of them.
    let size = if distance > 0.0 { distance } else { 1.0 };
    let cell = |x: [f64; 3]| x.map(|c| (c / size).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    from.iter().for_each(|&n| cells.entry(cell(at(n))).or_default().push(n));
    let is_near = |&n: &usize| {
        let middle = cell(at(n));
        (0..27i64).any(|k| {
            let step = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let there = cells.get(&[0, 1, 2].map(|c| middle[c].saturating_add(step[c])));
            there.into_iter().flatten().any(|&o| length(minus(at(n), at(o))) <= distance)
        })
    };
    among.iter().copied().filter(is_near).collect()
}
