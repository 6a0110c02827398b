//! Shapes of walls: planes, rectangles, cylinders, spheres.
//!
//! An infinite plane pushes out every node behind it. Nodes may be behind a limited surface, so
//! it stops only nodes that come from outside. A node comes from outside if it is no deeper
//! than its motion relative to the wall in one step. Therefore no node is pushed out faster
//! than its own speed.
use crate::math::row::V3;
use crumple_proto::wall::{ResolvedWall, WallForm};
use serde::{Deserialize, Serialize};

/// Depth due to round-off, over the size of the wall.
const ROUNDING: f64 = 1e-9;
/// Factor on the square of a radius for the fast test, above all errors of round-off.
const CLEAR: f64 = 1.0 + 1e-12;

/// Surface of a wall at the present time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WallSurface {
    /// Unit normal, or unit vector along the axis.
    pub direction: V3,
    place: V3,
    /// Distance of the plane from the origin along its normal [length].
    offset: f64,
    form: SurfaceForm,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum SurfaceForm {
    Plane,
    /// Directions and lengths of the sides; unlimited lengths are infinite.
    Rectangle([(V3, f64); 2]),
    Cylinder {
        radius: f64,
        /// Length; infinite if unlimited [length].
        length: f64,
    },
    Sphere {
        radius: f64,
    },
}

impl WallSurface {
    /// Builds the surface at time 0.
    pub fn new(job: &ResolvedWall) -> Self {
        let direction = V3::from(job.direction).normalize();
        let ends = |length: f64| if length > 0.0 { length } else { f64::INFINITY };
        let form = match job.form {
            WallForm::Plane => SurfaceForm::Plane,
            WallForm::Rectangle { edge, lengths: [first, second] } => {
                let edge = V3::from(edge);
                SurfaceForm::Rectangle([
                    (edge, ends(first)),
                    (direction.cross(&edge), ends(second)),
                ])
            }
            WallForm::Cylinder { radius, length } => {
                SurfaceForm::Cylinder { radius, length: ends(length) }
            }
            WallForm::Sphere { radius } => SurfaceForm::Sphere { radius },
        };
        let mut surface = Self { direction, place: V3::zeros(), offset: 0.0, form };
        surface.move_to(&V3::from(job.point));
        surface
    }

    /// Returns true if this is the surface of a job's wall, at any place.
    pub fn fits(&self, job: &ResolvedWall) -> bool {
        let wanted = Self::new(job);
        let place = [self.place.x, self.place.y, self.place.z, self.offset];
        self.direction == wanted.direction
            && self.form == wanted.form
            && place.iter().all(|a| a.is_finite())
    }

    /// Returns the reference point [length].
    pub fn position(&self) -> V3 {
        self.place
    }

    /// Moves the reference point to `place`.
    pub fn move_to(&mut self, place: &V3) {
        self.place = *place;
        self.offset = self.direction.dot(place);
    }

    /// Returns the distance of `x` in front of the surface, continued beyond its ends; negative
    /// behind [length].
    #[inline]
    pub fn distance(&self, x: &V3) -> f64 {
        match self.radius() {
            None => self.direction.dot(x) - self.offset,
            Some(radius) => self.outwards(&(x - self.place)).norm() - radius,
        }
    }

    /// Returns the unit normal at `x` and the distance of `x` in front of the surface [length],
    /// if the surface stops nodes there that move by at most `moved` in a step.
    pub fn near(&self, x: &V3, moved: f64) -> Option<(V3, f64)> {
        let gap = self.distance(x);
        let normal = match self.radius() {
            None => self.direction,
            Some(_) => self.outwards(&(x - self.place)).try_normalize(0.0)?,
        };
        self.is_constrained(x, gap, moved).then_some((normal, gap))
    }

    /// Returns the depth [length] of a point at `x` inside a round surface that does not stop it,
    /// because the point is deeper than it moves in a step, by `moved`.
    pub fn depth_of_ignored(&self, x: &V3, moved: f64) -> Option<f64> {
        let depth = -self.distance(x);
        // Taken to lie on the surface, the point shows if the surface extends to it.
        let within = self.is_constrained(x, 0.0, moved);
        (self.radius().is_some() && within && !self.is_constrained(x, -depth, moved))
            .then_some(depth)
    }

    /// Returns true if a point at `x` with velocity `v` relative to the surface is certainly in
    /// front of it after `dt`: the fast test for nearly all nodes.
    #[inline(always)]
    pub fn cannot_reach(&self, x: &V3, v: &V3, dt: f64) -> bool {
        match self.radius() {
            None => self.gap_after(x, v, dt) >= 0.0,
            Some(radius) => {
                let to = self.outwards(&(x - self.place + v * dt));
                to.norm_squared() > CLEAR * radius * radius
            }
        }
    }

    #[inline(always)]
    fn gap_after(&self, x: &V3, v: &V3, dt: f64) -> f64 {
        self.direction.dot(x) - self.offset + dt * self.direction.dot(v)
    }

    /// Returns the unit normal and the gap, negative, of a point at `x` after `dt`, if the
    /// surface stops it. `v` is its velocity relative to the surface in the step, `before` the
    /// one in the step before.
    pub fn contact_point(&self, x: &V3, v: &V3, before: &V3, dt: f64) -> Option<(V3, f64)> {
        if let Some(radius) = self.radius() {
            let from = self.outwards(&(x - self.place));
            let to = from + self.outwards(v) * dt;
            let gap = to.norm() - radius;
            if gap >= 0.0 || !self.is_constrained(x, from.norm() - radius, dt * before.norm()) {
                return None;
            }
            return Some((to.try_normalize(0.0).or_else(|| from.try_normalize(0.0))?, gap));
        }
        let gap = self.gap_after(x, v, dt);
        let limited = !matches!(self.form, SurfaceForm::Plane);
        if gap >= 0.0 || limited && !self.is_constrained(x, self.distance(x), dt * before.norm()) {
            return None;
        }
        Some((self.direction, gap))
    }

    /// Returns true if the surface extends to `x`, at the distance `gap` in front of it, and
    /// `x` comes from outside when it has moved by `moved` relative to the surface.
    fn is_constrained(&self, x: &V3, gap: f64, moved: f64) -> bool {
        let from = x - self.place;
        let within = |along: &V3, length: f64| {
            (0.0..=length).contains(&along.dot(&from)) || length.is_infinite()
        };
        let deepest = |size: f64| -(moved + ROUNDING * size);
        match self.form {
            SurfaceForm::Plane => true,
            SurfaceForm::Rectangle(sides) => {
                let size = sides.iter().map(|s| s.1).filter(|l| l.is_finite()).fold(0.0, f64::max);
                gap >= deepest(size) && sides.iter().all(|(along, length)| within(along, *length))
            }
            SurfaceForm::Cylinder { radius, length } => {
                gap >= deepest(radius) && within(&self.direction, length)
            }
            SurfaceForm::Sphere { radius } => gap >= deepest(radius),
        }
    }

    /// Returns the radius of a round surface.
    #[inline(always)]
    fn radius(&self) -> Option<f64> {
        match self.form {
            SurfaceForm::Plane | SurfaceForm::Rectangle(_) => None,
            SurfaceForm::Cylinder { radius, .. } | SurfaceForm::Sphere { radius } => Some(radius),
        }
    }

    /// Returns the part of a vector from the reference point of a round surface that leads away
    /// from the axis of a cylinder, or from the centre of a sphere.
    #[inline(always)]
    fn outwards(&self, v: &V3) -> V3 {
        match self.form {
            SurfaceForm::Sphere { .. } => *v,
            _ => v - self.direction * self.direction.dot(v),
        }
    }
}
