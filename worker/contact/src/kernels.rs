//! Position of points relative to segments: for one pair, or for several pairs in SIMD lanes,
//! written once over [`Real`].
//!
//! Products are not fused, and sums are evaluated in the order of components. Therefore the bits
//! are those of the same formulas in [`V3`].
use crumple_math::lanes::Real;
use crumple_math::row::V3;
use std::ops::{Add, Mul, Sub};

/// A point or vector.
#[derive(Clone, Copy, Debug)]
pub struct Vector<R>(pub [R; 3]);

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        Self([a + d, b + e, c + f])
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        Self([a - d, b - e, c - f])
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        let Self([a, b, c]) = self;
        Self([a * factor, b * factor, c * factor])
    }
}

impl From<V3> for Vector<f64> {
    fn from(v: V3) -> Self {
        Self([v.x, v.y, v.z])
    }
}

impl From<Vector<f64>> for V3 {
    fn from(v: Vector<f64>) -> Self {
        v.0.into()
    }
}

impl<R: Real> Vector<R> {
    #[inline(always)]
    fn dot(self, other: Self) -> R {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        a * d + b * e + c * f
    }
    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        let (Self([a, b, c]), Self([d, e, f])) = (self, other);
        Self([b * f - c * e, c * d - a * f, a * e - b * d])
    }
    /// Returns the square of its length.
    #[inline(always)]
    pub fn square(self) -> R {
        self.dot(self)
    }
    #[inline(always)]
    fn norm(self) -> R {
        self.square().sqrt()
    }
    #[inline(always)]
    fn over(self, divisor: R) -> Self {
        let Self([a, b, c]) = self;
        Self([a / divisor, b / divisor, c / divisor])
    }
    #[inline(always)]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self(choose(mask, yes.0, no.0))
    }
}

/// Points of segments that are nearest to given points; see [`super::geometry::Nearest`].
#[derive(Clone, Copy, Debug)]
pub struct Projection<R: Real> {
    /// Shape values at the segment's four nodes.
    pub shape: [R; 4],
    /// The point [length].
    pub point: Vector<R>,
    /// Unit normal there.
    pub normal: Vector<R>,
    /// True if the point is on the rim.
    pub rim: R::Mask,
    /// True if there is such a point. A segment without area has none.
    pub found: R::Mask,
}

/// Newton steps of the projection; a warped quad needs three to four.
const NEWTON: usize = 8;
/// Limit of xi and eta; where two successive steps end farther out, the nearest point is on the
/// rim.
const FAR: f64 = 1.5;
/// Coordinates xi, eta of a quad's corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

#[inline(always)]
fn number<R: Real>(mask: R::Mask) -> R {
    R::select(mask, R::splat(1.0), R::zero())
}

/// Returns `yes` in the lanes of `mask`, `no` in the other lanes.
#[inline(always)]
fn choose<R: Real, const N: usize>(mask: R::Mask, yes: [R; N], no: [R; N]) -> [R; N] {
    std::array::from_fn(|k| R::select(mask, yes[k], no[k]))
}

#[inline(always)]
fn not<R: Real>(mask: R::Mask) -> R::Mask {
    number::<R>(mask).le(R::zero())
}

/// Returns true if a lane is in a mask.
#[inline(always)]
pub fn is_in<R: Real>(mask: R::Mask, lane: usize) -> bool {
    number::<R>(mask).lane(lane) > 0.0
}

/// Computes the nearest points of segments `q` (the third node repeated for triangles) to `p`.
#[inline(always)]
pub fn project<R: Real>(p: Vector<R>, q: &[Vector<R>; 4], triangle: R::Mask) -> Projection<R> {
    if !R::any(triangle) {
        return on_quad(p, q);
    }
    let three = on_triangle(p, q);
    if !R::any(not::<R>(triangle)) {
        return three;
    }
    let four = on_quad(p, q);
    let pick = |a: R::Mask, b: R::Mask| {
        number::<R>(R::either(R::both(triangle, a), R::both(not::<R>(triangle), b)))
    };
    Projection {
        shape: choose(triangle, three.shape, four.shape),
        point: Vector::select(triangle, three.point, four.point),
        normal: Vector::select(triangle, three.normal, four.normal),
        rim: pick(three.rim, four.rim).gt(R::zero()),
        found: pick(three.found, four.found).gt(R::zero()),
    }
}

#[inline(always)]
fn bilinear<R: Real>(xi: R, eta: R) -> [R; 4] {
    let (one, quarter) = (R::splat(1.0), R::splat(0.25));
    let (a, b, c, d) = (one - xi, one + xi, one - eta, one + eta);
    [quarter * a * c, quarter * b * c, quarter * b * d, quarter * a * d]
}

#[inline(always)]
fn blend<R: Real>(shape: &[R; 4], q: &[Vector<R>; 4]) -> Vector<R> {
    q[0] * shape[0] + q[1] * shape[1] + q[2] * shape[2] + q[3] * shape[3]
}

#[inline(always)]
fn tangents<R: Real>(xi: R, eta: R, q: &[Vector<R>; 4]) -> (Vector<R>, Vector<R>) {
    let (one, quarter) = (R::splat(1.0), R::splat(0.25));
    let t_xi = ((q[1] - q[0]) * (one - eta) + (q[2] - q[3]) * (one + eta)) * quarter;
    let t_eta = ((q[3] - q[0]) * (one - xi) + (q[2] - q[1]) * (one + xi)) * quarter;
    (t_xi, t_eta)
}

#[inline(always)]
fn clamp<R: Real>(a: R, low: f64, high: f64) -> R {
    a.max(R::splat(low)).min(R::splat(high))
}

#[inline(always)]
fn on_quad<R: Real>(p: Vector<R>, q: &[Vector<R>; 4]) -> Projection<R> {
    let twist = (q[0] - q[1] + q[2] - q[3]) * R::splat(0.25);
    let (mut xi, mut eta) = (R::zero(), R::zero());
    // Lanes that have converged stay unchanged.
    let (mut going, mut flat) = (R::splat(1.0), R::zero());
    for _ in 0..NEWTON {
        let (a, b) = tangents(xi, eta, q);
        let r = blend(&bilinear(xi, eta), q) - p;
        // Stationary |r|^2 / 2: gradient (a.r, b.r), Hessian with the twist's second-order term.
        let (g1, g2) = (a.dot(r), b.dot(r));
        let (h11, h22, h12) = (a.dot(a), b.dot(b), a.dot(b));
        let exact = h12 + twist.dot(r);
        let mixed = R::select((h11 * h22).gt(R::splat(1.0001) * exact * exact), exact, h12);
        let (det, size) = (h11 * h22 - mixed * mixed, h11 + h22);
        flat = flat.max(R::select(det.le(R::splat(1e-12) * size * size), going, R::zero()));
        let (d1, d2) = ((g1 * h22 - g2 * mixed) / det, (g2 * h11 - g1 * mixed) / det);
        // Far outside, the rim decides anyway. The clamp keeps the iteration bounded on warped
        // quads.
        let before = xi.abs().max(eta.abs());
        let goes = going.gt(R::zero());
        xi = R::select(goes, clamp(xi - d1, -3.0, 3.0), xi);
        eta = R::select(goes, clamp(eta - d2, -3.0, 3.0), eta);
        let far = R::both(before.gt(R::splat(FAR)), xi.abs().max(eta.abs()).gt(R::splat(FAR)));
        let there = R::either(d1.abs().max(d2.abs()).lt(R::splat(1e-12)), far);
        going = R::select(R::either(there, flat.gt(R::zero())), R::zero(), going);
        if !R::any(going.gt(R::zero())) {
            break;
        }
    }
    let one = R::splat(1.0);
    let mut rim = not::<R>(R::both(xi.abs().le(one), eta.abs().le(one)));
    let mut shape = bilinear(xi, eta);
    if R::any(rim) {
        let edge = nearest_edge::<R, 4>(p, q);
        shape = choose(rim, edge.shape, shape);
        [xi, eta] = choose(rim, edge.place, [xi, eta]);
        let leaves = R::both(rim, comes_nearer_inside(p, q, edge.place));
        if R::any(leaves) {
            let place = nearest_from(p, q, edge.place);
            let inner = bilinear(place[0], place[1]);
            let nearer = R::both(leaves, (blend(&inner, q) - p).square().lt(edge.far));
            shape = choose(nearer, inner, shape);
            [xi, eta] = choose(nearer, place, [xi, eta]);
            let within = R::both(xi.abs().lt(one), eta.abs().lt(one));
            rim = number::<R>(R::both(rim, not::<R>(R::both(nearer, within)))).gt(R::zero());
        }
    }
    let (a, b) = tangents(xi, eta, q);
    let cross = a.cross(b);
    let size = cross.norm();
    let found = R::both(size.gt(R::zero()), flat.le(R::zero()));
    Projection { shape, point: blend(&shape, q), normal: cross.over(size), rim, found }
}

/// Computes the gradient of half the squared distance from `p` at a point of a quad, and its
/// second derivatives: along xi, along eta, mixed without and with the term of the twist
/// [length^2].
#[inline(always)]
fn derivatives<R: Real>(p: Vector<R>, q: &[Vector<R>; 4], [xi, eta]: [R; 2]) -> ([R; 2], [R; 4]) {
    let twist = (q[0] - q[1] + q[2] - q[3]) * R::splat(0.25);
    let (a, b) = tangents(xi, eta, q);
    let r = blend(&bilinear(xi, eta), q) - p;
    let mixed = a.dot(b);
    ([a.dot(r), b.dot(r)], [a.dot(a), b.dot(b), mixed, mixed + twist.dot(r)])
}

/// Returns true if the distance from `p` decreases from the nearest point of a quad's edges
/// towards the inside. Newton's method has then missed a nearest point inside: started from the
/// middle of a warped quad, it may diverge. On a plane quad, and wherever the rim is correct,
/// the distance increases towards the inside.
#[inline(always)]
fn comes_nearer_inside<R: Real>(p: Vector<R>, q: &[Vector<R>; 4], place: [R; 2]) -> R::Mask {
    /// Step of Newton's method below which it is round-off.
    const LITTLE: f64 = 1e-6;
    let ([g1, g2], [h11, h22, ..]) = derivatives(p, q, place);
    let falls =
        |at: R, g: R, h: R| R::both(at.abs().ge(R::splat(1.0)), (at * g).gt(h * R::splat(LITTLE)));
    R::either(falls(place[0], g1, h11), falls(place[1], g2, h22))
}

/// Runs Newton's method from a point of the rim, kept within the quad. Where it would leave the
/// quad, it moves along the rim.
#[inline(always)]
fn nearest_from<R: Real>(p: Vector<R>, q: &[Vector<R>; 4], [mut xi, mut eta]: [R; 2]) -> [R; 2] {
    for _ in 0..NEWTON {
        let ([g1, g2], [h11, h22, plain, exact]) = derivatives(p, q, [xi, eta]);
        let leaves = |at: R, g: R| R::both(at.abs().ge(R::splat(1.0)), (at * g).le(R::zero()));
        let (held1, held2) = (leaves(xi, g1), leaves(eta, g2));
        let mixed = R::select((h11 * h22).gt(R::splat(1.0001) * exact * exact), exact, plain);
        let mixed = R::select(R::either(held1, held2), R::zero(), mixed);
        let (g1, g2) = (R::select(held1, R::zero(), g1), R::select(held2, R::zero(), g2));
        let det = h11 * h22 - mixed * mixed;
        xi = clamp(xi - (g1 * h22 - g2 * mixed) / det, -1.0, 1.0);
        eta = clamp(eta - (g2 * h11 - g1 * mixed) / det, -1.0, 1.0);
    }
    [xi, eta]
}

#[inline(always)]
fn on_triangle<R: Real>(p: Vector<R>, q: &[Vector<R>; 4]) -> Projection<R> {
    let (a, b) = (q[1] - q[0], q[2] - q[0]);
    let cross = a.cross(b);
    let (area2, size) = (cross.square(), cross.norm());
    let r = p - q[0];
    let n1 = r.cross(b).dot(cross) / area2;
    let n2 = a.cross(r).dot(cross) / area2;
    let (zero, n0) = (R::zero(), R::splat(1.0) - n1 - n2);
    let rim = not::<R>(R::both(n0.ge(zero), R::both(n1.ge(zero), n2.ge(zero))));
    let mut shape = [n0, n1, n2, zero];
    if R::any(rim) {
        let edge = nearest_edge::<R, 3>(p, q);
        shape = choose(rim, edge.shape, shape);
    }
    Projection {
        shape,
        point: blend(&shape, q),
        normal: cross.over(size),
        rim,
        found: size.gt(zero),
    }
}

/// Nearest point of the edges.
struct NearestOnEdges<R> {
    /// Squared distance [length^2].
    far: R,
    shape: [R; 4],
    /// Coordinates xi, eta of the point.
    place: [R; 2],
}

/// Computes the nearest point of the first `N` edges; of two at the same distance, that of the
/// first edge.
#[inline(always)]
fn nearest_edge<R: Real, const N: usize>(p: Vector<R>, q: &[Vector<R>; 4]) -> NearestOnEdges<R> {
    let edge = |k: usize| {
        let (from, along) = (q[k], q[(k + 1) % N] - q[k]);
        let length2 = along.square();
        let s = clamp((p - from).dot(along) / length2, 0.0, 1.0);
        let s = R::select(length2.gt(R::zero()), s, R::zero());
        let ([x0, y0], [x1, y1]) = (CORNERS[k], CORNERS[(k + 1) % 4]);
        let mut shape = [R::zero(); 4];
        (shape[k], shape[(k + 1) % N]) = (R::splat(1.0) - s, s);
        let place = [R::splat(x0) + s * R::splat(x1 - x0), R::splat(y0) + s * R::splat(y1 - y0)];
        NearestOnEdges { far: (from + along * s - p).square(), shape, place }
    };
    let mut best = edge(0);
    for k in 1..N {
        let other = edge(k);
        let nearer = other.far.lt(best.far);
        best.far = R::select(nearer, other.far, best.far);
        best.shape = choose(nearer, other.shape, best.shape);
        best.place = choose(nearer, other.place, best.place);
    }
    best
}

/// Computes the square of the distance of edges, ends included (Ericson, Real-Time Collision
/// Detection, 2005, 5.1.9) [length^2].
#[inline(always)]
pub fn separation<R: Real>(p: &[Vector<R>; 2], q: &[Vector<R>; 2]) -> R {
    let (u, w, from) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (uu, ww, uw, fu, fw) = (u.square(), w.square(), u.dot(w), from.dot(u), from.dot(w));
    let nearest =
        |num: R, den: R| R::select(den.gt(R::zero()), clamp(num / den, 0.0, 1.0), R::zero());
    let s = nearest(uw * fw - fu * ww, uu * ww - uw * uw);
    // Take the point of the other edge that is nearest to this point, and then again the nearest
    // one on this edge.
    let t = nearest(uw * s + fw, ww);
    let s = nearest(uw * t - fu, uu);
    (from + u * s - w * t).square()
}

/// Computes a lower bound of the distance of points from segments [length], along the direction
/// from an approximation of the nearest point. It is NaN for a point without such a direction.
#[inline(always)]
pub fn distance_bound<R: Real>(at: Vector<R>, q: &[Vector<R>; 4]) -> R {
    // The nearest point of the parallelogram through the middles of the edges. Any direction
    // gives a valid bound.
    let quarter = R::splat(0.25);
    let from = at - (q[0] + q[1] + q[2] + q[3]) * quarter;
    let (a, b) = ((q[1] + q[2] - q[0] - q[3]) * quarter, (q[2] + q[3] - q[0] - q[1]) * quarter);
    let (aa, bb, ab, fa, fb) = (a.square(), b.square(), a.dot(b), from.dot(a), from.dot(b));
    let det = aa * bb - ab * ab;
    let within = |place: R| clamp(place, -1.0, 1.0);
    let away = from - a * within((fa * bb - fb * ab) / det) - b * within((fb * aa - fa * ab) / det);
    // The whole hull lies beyond the plane through the corner that is nearest along any
    // direction.
    let [one, two, three, four] = q.map(|p| (at - p).dot(away));
    one.min(two).min(three.min(four)) / away.norm()
}

/// Returns true for points whose nearest point on a convex segment certainly lies on the rim,
/// and will lie there until the two move by more than `skin` against each other [length]. Such a
/// point is outside an edge, seen in the mean plane. The result is false for segments without
/// area.
#[inline(always)]
pub fn projects_outside<R: Real>(at: Vector<R>, q: &[Vector<R>; 4], skin: f64) -> R::Mask {
    let (d1, d2) = (q[2] - q[0], q[3] - q[1]);
    let cross = d1.cross(d2);
    let (size, skin) = (cross.norm(), R::splat(skin));
    let mut shortest = R::splat(f64::INFINITY);
    for k in 0..4 {
        let length = (q[(k + 1) % 4] - q[k]).square();
        shortest = R::select(length.gt(R::zero()), length.min(shortest), shortest);
    }
    let shortest = shortest.sqrt();
    let warp = ((q[0] + q[2] - q[1] - q[3]).dot(cross) / size).abs();
    // The normal turns by the displacement of the diagonals' ends. It differs from the mean
    // normal by the warp, which may grow by twice the skin. An edge turns with its ends.
    let turn = R::splat(1.1) * skin * (d1.norm() + d2.norm()) / size
        + (warp + R::splat(3.0) * skin) / (shortest - skin).max(R::zero());
    let mut most = R::zero();
    for k in 0..4 {
        let (out, from) = ((q[(k + 1) % 4] - q[k]).cross(cross), at - q[k]);
        let lever = from.square().min((at - q[(k + 1) % 4]).square()).sqrt();
        let is_beyond = from.dot(out).gt((skin + lever * turn) * out.norm());
        most = R::select(is_beyond, R::splat(1.0), most);
    }
    most.gt(R::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_math::lanes::{LANES, Lane};
    use proptest::prelude::*;

    fn side_by_side(of: [Vector<f64>; LANES]) -> Vector<Lane> {
        Vector(std::array::from_fn(|c| Lane::new(of.map(|v| v.0[c]))))
    }

    fn vector() -> impl Strategy<Value = Vector<f64>> {
        prop::array::uniform3(-2.0..2.0f64).prop_map(Vector)
    }

    proptest! {
        /// A kernel may branch, but no lane may affect the results of other lanes.
        #[test]
        fn several_pairs_side_by_side_get_the_bits_of_each(
            corners in prop::array::uniform4(prop::array::uniform4(vector())),
            at in prop::array::uniform4(vector()),
            triangle in prop::array::uniform4(any::<bool>()),
            flat in prop::array::uniform4(0..10),
            skin in 0.0..0.3f64,
        ) {
            // Per segment: some are triangles, some have no area.
            let mut q = corners;
            for lane in 0..LANES {
                if flat[lane] == 0 {
                    q[lane] = [q[lane][0]; 4];
                }
                if triangle[lane] {
                    q[lane][3] = q[lane][2];
                }
            }
            let wide: [Vector<Lane>; 4] = std::array::from_fn(|k| side_by_side(q.map(|q| q[k])));
            let three = Lane::new(triangle.map(|t| if t { 1.0 } else { 0.0 })).gt(Lane::splat(0.5));
            let all = project(side_by_side(at), &wide, three);
            let outside = projects_outside(side_by_side(at), &wide, skin);
            let far = distance_bound(side_by_side(at), &wide);
            for lane in 0..LANES {
                let one = project(at[lane], &q[lane], triangle[lane]);
                prop_assert_eq!(is_in::<Lane>(all.found, lane), one.found);
                prop_assert_eq!(
                    is_in::<Lane>(outside, lane),
                    projects_outside(at[lane], &q[lane], skin)
                );
                prop_assert_eq!(
                    far.lane(lane).to_bits(),
                    distance_bound(at[lane], &q[lane]).to_bits()
                );
                if one.found {
                    prop_assert_eq!(is_in::<Lane>(all.rim, lane), one.rim);
                    let numbers = |shape: [f64; 4], point: [f64; 3], normal: [f64; 3]| {
                        let all = shape.into_iter().chain(point).chain(normal);
                        all.map(f64::to_bits).collect::<Vec<_>>()
                    };
                    let of = |v: Vector<Lane>| v.0.map(|c| c.lane(lane));
                    let ours =
                        numbers(all.shape.map(|n| n.lane(lane)), of(all.point), of(all.normal));
                    prop_assert_eq!(ours, numbers(one.shape, one.point.0, one.normal.0));
                }
            }
        }
    }
}
