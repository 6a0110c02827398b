//! Affine maps of points, of which `*DEFINE_TRANSFORMATION` is a chain.

use super::convert::space::{cross, unit};

/// A map `p -> A p + b` of points of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Rows of A.
    linear: [[f64; 3]; 3],
    /// b [length].
    shift: [f64; 3],
}

/// The map that leaves all points in place.
const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Default for Affine {
    fn default() -> Self {
        Self { linear: UNIT, shift: [0.0; 3] }
    }
}

impl Affine {
    /// Returns a translation.
    pub fn translation(shift: [f64; 3]) -> Self {
        Self { linear: UNIT, shift }
    }

    /// Returns a scaling about the origin by a factor for each axis.
    pub fn scale(by: [f64; 3]) -> Self {
        let mut linear = [[0.0; 3]; 3];
        (0..3).for_each(|c| linear[c][c] = by[c]);
        Self { linear, shift: [0.0; 3] }
    }

    /// Returns a rotation by an angle [degree] about the line through `point` along `axis`, which
    /// is a unit vector. Multiples of 90 degrees are exact.
    pub fn rotation(axis: [f64; 3], point: [f64; 3], degrees: f64) -> Self {
        let (sine, cosine) = sine_cosine(degrees);
        let e = axis;
        let skew = [[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]];
        let entry = |r: usize, c: usize| {
            cosine * UNIT[r][c] + (1.0 - cosine) * e[r] * e[c] + sine * skew[r][c]
        };
        Self { linear: [0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c))), shift: [0.0; 3] }
            .about(point)
    }

    /// Returns the reflection at the plane through `point` with the unit vector `normal`.
    pub fn mirror(point: [f64; 3], normal: [f64; 3]) -> Self {
        let entry = |r: usize, c: usize| UNIT[r][c] - 2.0 * normal[r] * normal[c];
        Self { linear: [0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c))), shift: [0.0; 3] }
            .about(point)
    }

    /// Returns the rigid motion that takes the first point to the fourth, the line to the second
    /// one to that from the fourth to the fifth, and the plane of the first three to that of the
    /// last three; `None` if three of them are on one line.
    pub fn between(points: [[f64; 3]; 6]) -> Option<Self> {
        let [a, b, c, d, e, f] = points;
        let (from, to) = (axes(a, b, c)?, axes(d, e, f)?);
        let entry = |r: usize, s: usize| (0..3).map(|k| to[k][r] * from[k][s]).sum();
        let mut map =
            Self { linear: [0, 1, 2].map(|r| [0, 1, 2].map(|s| entry(r, s))), shift: [0.0; 3] };
        let turned = map.point(a);
        map.shift = [0, 1, 2].map(|k| d[k] - turned[k]);
        Some(map)
    }

    /// Returns the map with `point` as its fixed point in place of the origin.
    fn about(self, point: [f64; 3]) -> Self {
        let turned = self.direction(point);
        Self { shift: [0, 1, 2].map(|c| point[c] - turned[c]), ..self }
    }

    /// Returns the map that applies this one first, then `next`.
    pub fn then(&self, next: &Self) -> Self {
        let entry =
            |r: usize, c: usize| (0..3).map(|k| next.linear[r][k] * self.linear[k][c]).sum();
        let linear = [0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c)));
        Self { linear, shift: next.point(self.shift) }
    }

    /// Returns the image of a point [length].
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(p);
        [0, 1, 2].map(|c| turned[c] + self.shift[c])
    }

    /// Returns the image of a vector.
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|r| (0..3).map(|c| self.linear[r][c] * v[c]).sum())
    }

    /// Returns the image of an axial vector, such as a rotational velocity: a reflection reverses
    /// its sense.
    pub fn axial(&self, v: [f64; 3]) -> [f64; 3] {
        let sign = if self.reflects() { -1.0 } else { 1.0 };
        self.direction(v).map(|c| sign * c)
    }

    /// Returns the image of a symmetric tensor, `A T A'`.
    pub fn tensor(&self, t: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let half = t.map(|row| self.direction(row));
        let columns = [0, 1, 2].map(|c| self.direction([0, 1, 2].map(|r| half[r][c])));
        [0, 1, 2].map(|r| [0, 1, 2].map(|c| columns[c][r]))
    }

    /// Returns the image of a stress, xx, yy, zz, xy, yz, zx.
    pub fn stress(&self, stress: [f64; 6]) -> [f64; 6] {
        if !self.turns() {
            return stress;
        }
        let [xx, yy, zz, xy, yz, zx] = stress;
        let tensor = self.tensor([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]);
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].map(|(i, j)| tensor[i][j])
    }

    /// Returns the image of a box with sides along the axes; `None` if its sides are not along
    /// them after a rotation.
    pub fn sides(&self, sides: [[f64; 2]; 3]) -> Option<[[f64; 2]; 3]> {
        let mut image = [[0.0; 2]; 3];
        for (r, side) in image.iter_mut().enumerate() {
            let large = (0..3).map(|c| self.linear[r][c].abs()).fold(0.0, f64::max);
            let c = (0..3).find(|&c| self.linear[r][c].abs() == large)?;
            let is_other = |k: &usize| *k != c && self.linear[r][*k].abs() > 1e-12 * large;
            if (0..3).any(|k| is_other(&k)) {
                return None;
            }
            let ends = sides[c].map(|x| self.linear[r][c] * x + self.shift[r]);
            *side = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        }
        Some(image)
    }

    /// Returns true if it is a reflection, which turns elements inside out.
    pub fn reflects(&self) -> bool {
        let [a, b, c] = self.linear;
        let n = cross(a, b);
        (0..3).map(|k| n[k] * c[k]).sum::<f64>() < 0.0
    }

    /// Returns true if directions change.
    pub fn turns(&self) -> bool {
        self.linear != UNIT
    }

    /// Returns true if lengths change.
    pub fn stretches(&self) -> bool {
        let dot = |r: usize, s: usize| (0..3).map(|k| self.linear[k][r] * self.linear[k][s]).sum();
        let is_kept = |r: usize, s: usize| {
            let product: f64 = dot(r, s);
            (product - UNIT[r][s]).abs() < 1e-9
        };
        !(0..3).all(|r| (0..3).all(|s| is_kept(r, s)))
    }
}

/// Returns sine and cosine of an angle [degree]. Multiples of 90 degrees are exact.
pub fn sine_cosine(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        angle => angle.to_radians().sin_cos(),
    }
}

/// Returns the axes along the first line of three points, in their plane, and across it.
fn axes(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let from = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    let x = unit(from(b))?;
    let z = unit(cross(x, from(c)))?;
    Some([x, cross(z, x), z])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3]) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-14), "{a:?} {b:?}");
    }

    /// A rotation by 90 degrees about a line parallel to z, a reflection, and their chain, which
    /// applies the first one first. Right angles are exact.
    #[test]
    fn maps_and_their_chain() {
        let turn = Affine::rotation([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 90.0);
        assert_eq!(turn.point([2.0, 0.0, 5.0]), [1.0, 1.0, 5.0]);
        let mirror = Affine::mirror([0.0, 3.0, 0.0], [0.0, 1.0, 0.0]);
        assert_eq!(mirror.point([1.0, 1.0, 5.0]), [1.0, 5.0, 5.0]);
        assert_eq!(turn.then(&mirror).point([2.0, 0.0, 5.0]), [1.0, 5.0, 5.0]);
        assert!(mirror.reflects() && !turn.reflects() && !turn.stretches());
        assert_eq!(mirror.axial([0.0, 0.0, 1.0]), [0.0, 0.0, -1.0], "a spin in the mirror");
        assert!(Affine::scale([1.0, 2.0, 1.0]).stretches());
        let oblique = Affine::rotation([0.6, 0.0, 0.8], [1.0, 2.0, 3.0], 360.0 / 7.0);
        let round = (0..7).fold(Affine::default(), |all, _| all.then(&oblique));
        close(round.point([4.0, 5.0, 6.0]), [4.0, 5.0, 6.0]);
    }

    /// Six points give the rigid motion between two triangles, whatever their sizes.
    #[test]
    fn six_points_give_a_rigid_motion() {
        let motion = Affine::rotation([0.6, 0.0, 0.8], [1.0, 2.0, 3.0], 50.0)
            .then(&Affine::translation([7.0, 8.0, 9.0]));
        let from = [[0.0, 1.0, 0.0], [2.0, 1.0, 0.5], [0.5, 3.0, 1.0]];
        let [d, e, f] = from.map(|p| motion.point(p));
        // The second and third target only give a line and a plane.
        let far = [0, 1, 2].map(|k| d[k] + 3.0 * (e[k] - d[k]));
        let found = Affine::between([from[0], from[1], from[2], d, far, f]).unwrap();
        close(found.point([4.0, -5.0, 6.0]), motion.point([4.0, -5.0, 6.0]));
        assert_eq!(Affine::between([d, d, f, d, e, f]), None, "no line");
    }

    /// A box stays one after a right angle only; a tensor transforms as the sum of `v v'`.
    #[test]
    fn boxes_and_tensors() {
        let turn = Affine::rotation([0.0, 0.0, 1.0], [0.0; 3], 90.0);
        let sides = [[1.0, 2.0], [3.0, 5.0], [-1.0, 1.0]];
        assert_eq!(turn.sides(sides), Some([[-5.0, -3.0], [1.0, 2.0], [-1.0, 1.0]]));
        assert_eq!(Affine::rotation([0.0, 0.0, 1.0], [0.0; 3], 45.0).sides(sides), None);
        let v = [1.0, 2.0, 3.0];
        let image = turn.direction(v);
        let square = |v: [f64; 3]| v.map(|a| v.map(|b| a * b));
        assert_eq!(turn.tensor(square(v)), square(image));
    }
}
