//! Where a wall is: planes, rectangles, cylinders.
//!
//! A plane without end pushes out whatever is behind it. What is limited has a behind where nodes
//! may be: it stops those only that come from outside. A node counts as coming from there if it is
//! no deeper than it moves against the wall in a step, so that none is ever thrown out with more
//! than its own speed.

use crate::contact::geometry::V3;
use crumple_proto::wall::{Wall as WallJob, WallForm};

/// Depth of round-off, as a fraction of the wall's size.
const ROUNDING: f64 = 1e-9;

/// A wall's surface where it is now.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Unit normal, or unit vector along the axis.
    pub direction: V3,
    place: V3,
    /// Distance of the plane from the origin along its normal [length].
    offset: f64,
    form: Form,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Plane,
    /// Directions and lengths of the sides; infinite without end.
    Rectangle([(V3, f64); 2]),
    Cylinder {
        radius: f64,
        /// Infinite without end.
        length: f64,
    },
}

impl Surface {
    /// At time 0.
    pub fn new(job: &WallJob) -> Self {
        let direction = V3::from(job.direction).normalize();
        let ends = |length: f64| if length > 0.0 { length } else { f64::INFINITY };
        let form = match job.form {
            WallForm::Plane => Form::Plane,
            WallForm::Rectangle { edge, lengths: [first, second] } => {
                let edge = V3::from(edge);
                Form::Rectangle([(edge, ends(first)), (direction.cross(&edge), ends(second))])
            }
            WallForm::Cylinder { radius, length } => {
                Form::Cylinder { radius, length: ends(length) }
            }
        };
        let mut surface = Self { direction, place: V3::zeros(), offset: 0.0, form };
        surface.move_to(&V3::from(job.point));
        surface
    }

    /// Its point [length].
    pub fn position(&self) -> V3 {
        self.place
    }

    /// Brings its point to `place`.
    pub fn move_to(&mut self, place: &V3) {
        self.place = *place;
        self.offset = self.direction.dot(place);
    }

    /// How far `x` is in front of the surface, continued beyond its ends; negative behind [length].
    #[inline]
    pub fn distance(&self, x: &V3) -> f64 {
        match self.form {
            Form::Plane | Form::Rectangle(_) => self.direction.dot(x) - self.offset,
            Form::Cylinder { radius, .. } => self.off_axis(&(x - self.place)).norm() - radius,
        }
    }

    /// Unit normal at `x`, and how far `x` is in front of the surface, if it stops what is there
    /// and moves by `moved` at most in a step.
    pub fn near(&self, x: &V3, moved: f64) -> Option<(V3, f64)> {
        let gap = self.distance(x);
        let normal = match self.form {
            Form::Plane | Form::Rectangle(_) => self.direction,
            Form::Cylinder { .. } => self.off_axis(&(x - self.place)).try_normalize(0.0)?,
        };
        self.constrain_velocity(x, gap, moved).then_some((normal, gap))
    }

    /// Whether a point at `x` with velocity `v` against the surface is in front of it after `dt`
    /// for certain: the quick answer for nearly all nodes.
    #[inline(always)]
    pub fn cannot_reach(&self, x: &V3, v: &V3, dt: f64) -> bool {
        !matches!(self.form, Form::Cylinder { .. }) && self.gap_after(x, v, dt) >= 0.0
    }

    #[inline(always)]
    fn gap_after(&self, x: &V3, v: &V3, dt: f64) -> f64 {
        self.direction.dot(x) - self.offset + dt * self.direction.dot(v)
    }

    /// Unit normal and depth, negative, at which a point at `x` would be after `dt`, if the surface
    /// keeps it from there. `v` is its velocity against the surface in the step, `before` that
    /// against the surface in the step before.
    pub fn contact_point(&self, x: &V3, v: &V3, before: &V3, dt: f64) -> Option<(V3, f64)> {
        if let Form::Cylinder { radius, .. } = self.form {
            let from = self.off_axis(&(x - self.place));
            let to = from + self.off_axis(v) * dt;
            let gap = to.norm() - radius;
            if gap >= 0.0 || !self.constrain_velocity(x, from.norm() - radius, dt * before.norm()) {
                return None;
            }
            return Some((to.try_normalize(0.0).or_else(|| from.try_normalize(0.0))?, gap));
        }
        let gap = self.gap_after(x, v, dt);
        let limited = !matches!(self.form, Form::Plane);
        if gap >= 0.0
            || limited && !self.constrain_velocity(x, self.distance(x), dt * before.norm())
        {
            return None;
        }
        Some((self.direction, gap))
    }

    /// Whether the surface reaches as far as `x`, which is `gap` in front of it, and `x` comes from
    /// outside if it has moved by `moved` against it.
    fn constrain_velocity(&self, x: &V3, gap: f64, moved: f64) -> bool {
        let from = x - self.place;
        let within = |along: &V3, length: f64| {
            (0.0..=length).contains(&along.dot(&from)) || length.is_infinite()
        };
        let deepest = |size: f64| -(moved + ROUNDING * size);
        match self.form {
            Form::Plane => true,
            Form::Rectangle(sides) => {
                let size = sides.iter().map(|s| s.1).filter(|l| l.is_finite()).fold(0.0, f64::max);
                gap >= deepest(size) && sides.iter().all(|(along, length)| within(along, *length))
            }
            Form::Cylinder { radius, length } => {
                gap >= deepest(radius) && within(&self.direction, length)
            }
        }
    }

    fn off_axis(&self, v: &V3) -> V3 {
        v - self.direction * self.direction.dot(v)
    }
}
