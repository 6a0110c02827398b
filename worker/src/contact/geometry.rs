//! Nearest point of a segment: a bilinear quad or a triangle; where two edges pass each other.

use nalgebra::Vector3;

/// A point or vector.
pub type V3 = Vector3<f64>;

/// The point of a segment that is nearest to a given one.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Shape values N_k of the point at the segment's four nodes (a triangle's fourth is 0); they sum to 1.
    pub shape: [f64; 4],
    /// The point [length].
    pub point: V3,
    /// Unit normal of the segment there, by the right-hand rule over its nodes.
    pub normal: V3,
    /// Whether the nearest point lies on the rim.
    pub rim: bool,
}

/// Newton steps of the projection; a warped quad needs three to four.
const NEWTON: usize = 8;
/// Where two steps in a row end farther out than this, the nearest point is on the rim.
const FAR: f64 = 1.5;

/// Nearest point of segment `q` (its third node repeated for a triangle) to `p`. `None` for a segment without area.
pub fn nearest(p: &V3, q: &[V3; 4], triangle: bool) -> Option<Nearest> {
    if triangle { nearest_on_triangle(p, q) } else { nearest_on_quad(p, q) }
}

/// Whether a point is farther than `reach` from a segment for certain, which lies within the hull of its corners.
pub fn is_farther(at: &V3, q: &[V3; 4], reach: f64) -> bool {
    let centre = (q[0] + q[1] + q[2] + q[3]) * 0.25;
    let radius = q.iter().map(|p| (p - centre).norm_squared()).fold(0.0, f64::max).sqrt();
    (at - centre).norm_squared() > (reach + radius) * (reach + radius)
}

/// The same, told by the direction from about the nearest point, where [`is_farther`] goes by the segment's size.
pub fn is_apart(at: &V3, q: &[V3; 4], reach: f64) -> bool {
    // The nearest point of the parallelogram through the middles of the edges; without area no number, which is not apart.
    let from = at - (q[0] + q[1] + q[2] + q[3]) * 0.25;
    let (a, b) = ((q[1] + q[2] - q[0] - q[3]) * 0.25, (q[2] + q[3] - q[0] - q[1]) * 0.25);
    let (aa, bb, ab, fa, fb) = (a.dot(&a), b.dot(&b), a.dot(&b), from.dot(&a), from.dot(&b));
    let det = aa * bb - ab * ab;
    let within = |place: f64| place.clamp(-1.0, 1.0);
    let away = from - a * within((fa * bb - fb * ab) / det) - b * within((fb * aa - fa * ab) / det);
    // All of the hull lies beyond the plane through the corner that is nearest along any direction.
    let enough = reach * away.norm();
    q.iter().all(|p| (at - p).dot(&away) > enough)
}

/// Whether the point of a convex segment that is nearest to `at` lies on its rim for certain, and will until the two move by more
/// than `skin` against each other: the point is beyond an edge, seen in the mean plane. A segment without area has no such.
pub fn is_beside(at: &V3, q: &[V3; 4], skin: f64) -> bool {
    let (d1, d2) = (q[2] - q[0], q[3] - q[1]);
    let cross = d1.cross(&d2);
    let size = cross.norm();
    let edges = [0, 1, 2, 3].map(|k| q[(k + 1) % 4] - q[k]);
    let shortest = edges.iter().map(|e| e.norm_squared()).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min).sqrt();
    let warp = ((q[0] + q[2] - q[1] - q[3]).dot(&cross) / size).abs();
    // The normal turns by what moves the ends of the diagonals, and differs from the mean one by the warp, which may grow by
    // twice the skin meanwhile. An edge turns with its ends.
    let turn = 1.1 * skin * (d1.norm() + d2.norm()) / size + (warp + 3.0 * skin) / (shortest - skin).max(0.0);
    (0..4).any(|k| {
        let (out, from) = (edges[k].cross(&cross), at - q[k]);
        let lever = from.norm_squared().min((at - q[(k + 1) % 4]).norm_squared()).sqrt();
        from.dot(&out) > (skin + lever * turn) * out.norm()
    })
}

fn bilinear(xi: f64, eta: f64) -> [f64; 4] {
    let (a, b, c, d) = (1.0 - xi, 1.0 + xi, 1.0 - eta, 1.0 + eta);
    [0.25 * a * c, 0.25 * b * c, 0.25 * b * d, 0.25 * a * d]
}

fn blend(shape: &[f64; 4], q: &[V3; 4]) -> V3 {
    q[0] * shape[0] + q[1] * shape[1] + q[2] * shape[2] + q[3] * shape[3]
}

fn tangents(xi: f64, eta: f64, q: &[V3; 4]) -> (V3, V3) {
    let t_xi = ((q[1] - q[0]) * (1.0 - eta) + (q[2] - q[3]) * (1.0 + eta)) * 0.25;
    let t_eta = ((q[3] - q[0]) * (1.0 - xi) + (q[2] - q[1]) * (1.0 + xi)) * 0.25;
    (t_xi, t_eta)
}

fn nearest_on_quad(p: &V3, q: &[V3; 4]) -> Option<Nearest> {
    let twist = (q[0] - q[1] + q[2] - q[3]) * 0.25;
    let (mut xi, mut eta) = (0.0f64, 0.0f64);
    for _ in 0..NEWTON {
        let (a, b) = tangents(xi, eta, q);
        let r = blend(&bilinear(xi, eta), q) - p;
        // Stationary |r|^2 / 2: gradient (a.r, b.r), Hessian with the twist's second-order term.
        let (g1, g2) = (a.dot(&r), b.dot(&r));
        let (h11, h22, h12) = (a.dot(&a), b.dot(&b), a.dot(&b));
        let exact = h12 + twist.dot(&r);
        let mixed = if h11 * h22 > 1.0001 * exact * exact { exact } else { h12 };
        let det = h11 * h22 - mixed * mixed;
        if det <= 1e-12 * (h11 + h22) * (h11 + h22) {
            return None;
        }
        let (d1, d2) = ((g1 * h22 - g2 * mixed) / det, (g2 * h11 - g1 * mixed) / det);
        // Far outside the rim decides anyway; a leash keeps warped quads from wandering.
        let before = xi.abs().max(eta.abs());
        (xi, eta) = ((xi - d1).clamp(-3.0, 3.0), (eta - d2).clamp(-3.0, 3.0));
        if d1.abs().max(d2.abs()) < 1e-12 || before > FAR && xi.abs().max(eta.abs()) > FAR {
            break;
        }
    }
    if xi.abs() <= 1.0 && eta.abs() <= 1.0 {
        let shape = bilinear(xi, eta);
        let (a, b) = tangents(xi, eta, q);
        return Some(Nearest { shape, point: blend(&shape, q), normal: a.cross(&b).try_normalize(0.0)?, rim: false });
    }
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let (k, s) = nearest_edge(p, q, 4)?;
    let ((xi0, eta0), (xi1, eta1)) = (corners[k], corners[(k + 1) % 4]);
    let (a, b) = tangents(xi0 + s * (xi1 - xi0), eta0 + s * (eta1 - eta0), q);
    let shape = edge_shape(k, (k + 1) % 4, s);
    Some(Nearest { shape, point: blend(&shape, q), normal: a.cross(&b).try_normalize(0.0)?, rim: true })
}

fn nearest_on_triangle(p: &V3, q: &[V3; 4]) -> Option<Nearest> {
    let (a, b) = (q[1] - q[0], q[2] - q[0]);
    let cross = a.cross(&b);
    let area2 = cross.norm_squared();
    let normal = cross.try_normalize(0.0)?;
    let r = p - q[0];
    let n1 = r.cross(&b).dot(&cross) / area2;
    let n2 = a.cross(&r).dot(&cross) / area2;
    let inside = [1.0 - n1 - n2, n1, n2, 0.0];
    if inside.iter().all(|&n| n >= 0.0) {
        return Some(Nearest { shape: inside, point: blend(&inside, q), normal, rim: false });
    }
    let (k, s) = nearest_edge(p, q, 3)?;
    let shape = edge_shape(k, (k + 1) % 3, s);
    Some(Nearest { shape, point: blend(&shape, q), normal, rim: true })
}

fn edge_shape(from: usize, to: usize, s: f64) -> [f64; 4] {
    let mut shape = [0.0; 4];
    shape[from] = 1.0 - s;
    shape[to] += s;
    shape
}

/// The edge nearest to `p` and the place on it, 0 to 1.
fn nearest_edge(p: &V3, q: &[V3; 4], corners: usize) -> Option<(usize, f64)> {
    let edge = |k: usize| {
        let (from, along) = (q[k], q[(k + 1) % corners] - q[k]);
        let length2 = along.norm_squared();
        let s = if length2 > 0.0 { ((p - from).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
        ((from + along * s - p).norm_squared(), k, s)
    };
    (0..corners).map(edge).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k, s)| (k, s))
}

/// Two edges whose sines of the angle between them is below this count as parallel: where they are nearest to each other
/// is then ill determined, and their ends tell as much.
const PARALLEL: f64 = 0.03;

/// The points of two edges that are nearest to each other, both between the ends.
#[derive(Clone, Copy, Debug)]
pub struct Passing {
    /// The places of the points along either edge, above 0 and below 1.
    pub along: [f64; 2],
    /// Unit vector along the cross product of the edges.
    pub normal: V3,
    /// Distance of the first edge from the second along `normal` [length].
    pub height: f64,
}

/// Where edges `p` and `q`, by their ends, are nearest to each other. `None` if that is at an end, or if they are parallel.
pub fn passing(p: &[V3; 2], q: &[V3; 2]) -> Option<Passing> {
    let (u, w, apart) = (p[1] - p[0], q[1] - q[0], q[0] - p[0]);
    let cross = u.cross(&w);
    let size2 = cross.norm_squared();
    if size2 <= PARALLEL * PARALLEL * u.norm_squared() * w.norm_squared() {
        return None;
    }
    let along = [apart.cross(&w), apart.cross(&u)].map(|a| a.dot(&cross) / size2);
    let between = along.iter().all(|&a| a > 0.0 && a < 1.0);
    let normal = cross / size2.sqrt();
    between.then(|| Passing { along, normal, height: -apart.dot(&normal) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn where_edges_pass_is_the_nearest_of_many_points() {
        let p = [V3::new(0.0, 0.1, 0.3), V3::new(2.0, -0.2, 0.5)];
        let q = [V3::new(0.8, -1.0, -0.4), V3::new(1.3, 1.5, 0.1)];
        let at = |e: &[V3; 2], a: f64| e[0] + (e[1] - e[0]) * a;
        let found = passing(&p, &q).unwrap();
        let offset = at(&p, found.along[0]) - at(&q, found.along[1]);
        assert!((offset - found.normal * found.height).norm() < 1e-15, "the offset is along the normal");
        let grid = (0..=400).flat_map(|i| (0..=400).map(move |j| (i as f64 / 400.0, j as f64 / 400.0)));
        let best = grid.map(|(a, b)| (at(&p, a) - at(&q, b)).norm()).fold(f64::INFINITY, f64::min);
        assert!(offset.norm() <= best + 1e-15 && offset.norm() > best - 1e-4, "{} and {best} on a grid", offset.norm());
        let back = passing(&q, &p).unwrap();
        assert!((back.height - found.height).abs() < 1e-15 && (back.normal + found.normal).norm() < 1e-15);
    }

    #[test]
    fn edges_that_end_before_they_pass_or_run_side_by_side_do_not_pass() {
        let p = [V3::zeros(), V3::x()];
        let over = |x: f64, y: f64| [V3::new(x, y, 1.0), V3::new(x, y + 2.0, 1.0)];
        assert!((passing(&p, &over(0.3, -0.5)).unwrap().height + 1.0).abs() < 1e-15, "along x cross y, it is below");
        assert!(passing(&p, &over(1.1, -0.5)).is_none(), "beside the end of the first");
        assert!(passing(&p, &over(0.3, 0.1)).is_none(), "before the start of the second");
        assert!(passing(&p, &[V3::z(), V3::new(1.0, 0.02, 1.0)]).is_none(), "parallel, but for a fiftieth");
        assert!(passing(&p, &[V3::z(), V3::z()]).is_none(), "no length");
    }

    fn warped() -> [V3; 4] {
        [V3::new(0.0, 0.0, 0.2), V3::new(2.0, 0.1, -0.2), V3::new(2.2, 1.9, 0.3), V3::new(-0.1, 2.0, -0.1)]
    }

    #[test]
    fn projection_on_a_warped_quad_is_the_nearest_of_many_points() {
        let q = warped();
        for p in [V3::new(1.0, 1.2, 0.8), V3::new(2.6, 1.0, 0.4), V3::new(-0.5, -0.7, 0.3), V3::new(0.3, 1.9, -0.9)] {
            let found = nearest(&p, &q, false).unwrap();
            let grid = (0..=400).flat_map(|i| (0..=400).map(move |j| (i as f64 / 200.0 - 1.0, j as f64 / 200.0 - 1.0)));
            let best = grid.map(|(xi, eta)| (blend(&bilinear(xi, eta), &q) - p).norm()).fold(f64::INFINITY, f64::min);
            let d = (found.point - p).norm();
            assert!(d <= best + 1e-12 && d > best - 1e-4, "{d} against {best} on a grid of 0.005");
            assert!((found.shape.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn triangle_inside_edge_and_corner() {
        let q = [V3::zeros(), V3::x(), V3::y(), V3::y()];
        let n = nearest(&V3::new(0.25, 0.25, 3.0), &q, true).unwrap();
        assert!(!n.rim && (n.shape[0] - 0.5).abs() < 1e-15 && n.normal == V3::z());
        let n = nearest(&V3::new(0.5, -2.0, 0.0), &q, true).unwrap();
        assert!(n.rim && n.shape == [0.5, 0.5, 0.0, 0.0]);
        let n = nearest(&V3::new(-1.0, -2.0, 0.0), &q, true).unwrap();
        assert!(n.rim && n.shape == [1.0, 0.0, 0.0, 0.0]);
    }

    proptest! {
        /// What the near list leaves out stays out of reach, or beside, while point and corners move by half the skin each.
        #[test]
        fn what_is_far_or_beside_stays_so_within_the_skin(
            corners in prop::array::uniform4(prop::array::uniform3(-0.2..0.2f64)),
            triangle in any::<bool>(),
            at in prop::array::uniform3(-2.5..2.5f64),
            moves in prop::array::uniform5(prop::array::uniform3(-1.0..1.0f64)),
            skin in 0.0..0.3f64,
            reach in 0.1..1.5f64,
        ) {
            let square = [V3::zeros(), V3::x(), V3::new(1.0, 1.0, 0.0), V3::y()];
            let mut q: [V3; 4] = std::array::from_fn(|k| square[k] + V3::from(corners[k]));
            if triangle {
                q[3] = q[2];
            }
            let at = V3::from(at);
            // No longer than half the skin.
            let moved = |k: usize| V3::from(moves[k]) * (0.5 * skin / 3.0f64.sqrt());
            let (then, mut later) = (at + moved(4), q);
            (0..4).for_each(|k| later[k] += moved(if triangle { k.min(2) } else { k }));
            let Some(near) = nearest(&then, &later, triangle) else { return Ok(()) };
            if is_farther(&at, &q, reach + skin) || is_apart(&at, &q, reach + skin) {
                prop_assert!((then - near.point).norm() > reach);
            }
            if is_beside(&at, &q, skin) {
                // The local search turns away either.
                prop_assert!(is_beside(&then, &later, 0.0) || near.rim);
            }
            // A plane segment that is convex: beside it is beside its rim. Of what is bent in its plane or warped that much nothing is said.
            let flat = q.map(|p| V3::new(p.x, p.y, 0.0));
            if is_beside(&at, &flat, 0.0) {
                prop_assert!(nearest(&at, &flat, triangle).is_none_or(|n| n.rim));
            }
        }
    }

    #[test]
    fn a_segment_without_area_has_no_nearest_point() {
        assert!(nearest(&V3::z(), &[V3::zeros(), V3::x(), V3::x() * 2.0, V3::x()], false).is_none());
    }
}
