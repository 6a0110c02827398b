//! Contact at the middle surface of shells with an offset (`shell_offset` in `[contact]`).
//!
//! The middle surface of such a shell is not in its nodal plane. A segment has the signed distance
//! from its nodes to its middle surface along its own normal ([`Segment::offset`]), an edge and a
//! slave node the shift, a vector that follows from the segments around them. Nearest points are
//! those of the nodal surface. The gap is that of the middle surfaces at these points: with the
//! normal `N` of the pair from the segment to the slave
//!
//! ```text
//! gap = |x - p - o n| + m . N - thickness,   N = (x - p - o n)/|x - p - o n|
//! ```
//!
//! with the slave at `x` with the shift `m`, its nearest point `p`, and the offset `o` and normal
//! `n` of the segment there. Above the inside of a segment, `N` is `n` or `-n`, and the gap is
//! exact. Around a rim `N` turns about the shifted rim. The force still acts at `x` and `p`, so at
//! a rim it has the moment of the part of `o n` perpendicular to `N`, which is not balanced.
//!
//! Nothing is evaluated unless an interface uses offsets and a shell has one.

use crate::folds::{Edge, EdgeTable};
use crate::geometry::{EdgeProjection, Nearest};
use crate::surface::{Segment, Surface};
use crumple_math::row::{Row, V3};

/// Largest shift of a node or an edge, as a multiple of the largest offset of the surface. Two
/// segments at a right angle need `sqrt(2)`, three `sqrt(3)`, to lie with both (or all) middle
/// surfaces.
const LARGEST_SHIFT: f64 = 2.0;
/// Smallest mean product of the normals around a node by which shifts are lengthened.
const SHARPEST: f64 = 0.25;
/// Distance of the nodes of a pair along its normal below which friction has no lever arm, as a
/// fraction of the half thicknesses.
const NO_ARM: f64 = 1e-9;

impl Surface {
    /// Returns true if an interface uses the offsets of shells and the surface has some.
    pub fn is_shifted(&self, interface: u16) -> bool {
        self.largest_offset > 0.0 && self.interfaces.has_shell_offset(interface)
    }

    /// Returns the largest distance by which the shifts of both sides of a pair and the smooth
    /// surface can bring it into contact from farther away [length].
    pub fn shift_reach(&self) -> f64 {
        2.0 * LARGEST_SHIFT * self.largest_offset + self.largest_rise()
    }

    /// Returns the offset of a segment in an interface [length].
    pub fn offset_of(&self, interface: u16, segment: &Segment) -> f64 {
        if self.is_shifted(interface) { segment.offset } else { 0.0 }
    }

    /// Returns the vector from the nodes of a segment to its middle surface in an interface
    /// [length].
    pub fn shift_of_segment(&self, interface: u16, segment: &Segment, x: &[Row]) -> V3 {
        let offset = self.offset_of(interface, segment);
        if offset == 0.0 {
            return V3::zeros();
        }
        segment.middle_normal(x).map_or(V3::zeros(), |n| n * offset)
    }

    /// Returns the vector from the slave with index `place` in `slaves` to the middle surface in
    /// an interface [length].
    pub fn shift_of_slave(&self, interface: u16, place: usize, x: &[Row]) -> V3 {
        if !self.is_shifted(interface) {
            return V3::zeros();
        }
        self.shift(self.around(place), x)
    }

    /// Returns the distance of the middle surfaces of the slave with index `place` in `slaves`, at
    /// `at`, and of the nearest point of a shell segment in an interface [length].
    pub fn distance(
        &self,
        (interface, place): (u16, usize),
        segment: &Segment,
        (at, near): (&V3, &Nearest),
        x: &[Row],
    ) -> f64 {
        let apart = at - near.point - near.normal * self.offset_of(interface, segment);
        let shift = self.shift_of_slave(interface, place, x);
        let between = (apart + shift).dot(&near.normal);
        if !near.rim && apart.dot(&near.normal) * between < 0.0 {
            return between.abs();
        }
        let direction = apart.try_normalize(0.0).unwrap_or(near.normal);
        apart.norm() + shift.dot(&direction)
    }

    /// Returns the vector from a node or an edge between these segments to their middle surfaces
    /// [length]. Solids and beams do not count.
    ///
    /// The mean of the segments' vectors `o n` is too short where they meet at an angle. It is
    /// divided by the mean of `|n_g . n_h|` over all pairs of their normals. For two segments with
    /// the same offset, and for three at right angles, the result lies on all middle surfaces. The
    /// senses of the normals do not matter, and the result has no jump when an angle changes.
    pub fn shift<'a>(&self, segments: impl Iterator<Item = &'a Segment>, x: &[Row]) -> V3 {
        let shells = segments.filter(|s| !s.is_solid() && !s.is_line());
        let all: Vec<(V3, f64)> =
            shells.filter_map(|s| Some((s.middle_normal(x)?, s.offset))).collect();
        let sum: V3 = all.iter().map(|(normal, offset)| normal * *offset).sum();
        if sum == V3::zeros() {
            return sum;
        }
        let count = all.len() as f64;
        let along = |(g, _): &(V3, f64)| all.iter().map(|(h, _)| g.dot(h).abs()).sum::<f64>();
        let alike = all.iter().map(along).sum::<f64>() / (count * count);
        (sum / (count * alike.max(SHARPEST))).cap_magnitude(LARGEST_SHIFT * self.largest_offset)
    }
}

impl EdgeTable {
    /// Returns the vector from an edge to the middle surface of its shells in an interface, zero
    /// without offsets [length].
    pub fn shift(&self, edge: &Edge, (surface, interface): (&Surface, u16), x: &[Row]) -> V3 {
        if !surface.is_shifted(interface) {
            return V3::zeros();
        }
        surface.shift(self.segments(edge).iter().map(|&g| &surface.segments[g as usize]), x)
    }
}

impl EdgeProjection {
    /// Returns the projection with the distance of the middle surfaces; `shifts` are those of the
    /// two edges [length].
    pub fn shifted(&self, shifts: &[V3; 2]) -> Self {
        if *shifts == [V3::zeros(); 2] {
            return *self; // without a change of the sign of a zero
        }
        let height = self.height + (shifts[0] - shifts[1]).dot(&self.normal);
        Self { height, ..*self }
    }
}

/// Returns the lever arms of friction on both sides of a pair with shifts [length]: the distances
/// of the contact surface from their nodes. `halves` are their half thicknesses, `towards` the
/// shifts towards the other side, `apart` the distance of the nodes along the normal. The sum of
/// the arms is `apart`; what is missing is divided by `weights`. Nodes in one plane have no arms.
pub fn lever_arms(halves: [f64; 2], towards: [f64; 2], apart: f64, weights: [f64; 2]) -> [f64; 2] {
    if apart.abs() <= NO_ARM * (halves[0] + halves[1]) {
        return [0.0; 2];
    }
    let arms = [halves[0] + towards[0], halves[1] + towards[1]];
    let missing = apart - arms[0] - arms[1];
    let sum = weights[0] + weights[1];
    let part = if sum > 0.0 { weights[0] / sum } else { 0.5 };
    [arms[0] + missing * part, arms[1] + missing * (1.0 - part)]
}
