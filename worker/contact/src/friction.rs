//! Friction that depends on the contact pressure: a largest shear stress, and coefficients by
//! pressure and sliding speed.
//!
//! The table of coefficients is that of LS-DYNA's *CONTACT with FS = 2 (Keyword User's Manual,
//! volume I, *CONTACT, mandatory card 2, and volume II, *DEFINE_TABLE): curves of the coefficient
//! over the sliding speed at ascending pressures. Between them it is interpolated linearly;
//! beyond the first and the last one it is constant. The largest shear stress is VC of the same
//! card.
//!
//! The pressure of a node is that of all its pairs on its part of the surface, a mean over the
//! last steps. Two segments and two edges have an area of contact of their own; their pressure is
//! the normal force of the step before over this area. Two edges are strips, each as wide as its
//! edge is thick in contact. They have the parallelogram in common that both strips cover, but no
//! more than the shorter and the narrower of them.

use crate::folds::Edge;
use crate::pairs::Pair;
use crate::surface::Surface;
use crumple_fem::nodes::Nodes;
use crumple_math::row::Row;

/// Coefficients of friction by pressure and speed.
#[derive(Clone, Debug)]
pub struct FrictionTable {
    /// Curves in ascending order of their pressures [force/length^2]: points of speed
    /// [length/time] and coefficient, with ascending speeds.
    curves: Vec<(f64, Vec<[f64; 2]>)>,
}

impl FrictionTable {
    /// Builds the table from rows of pressure, speed and coefficient; `None` without rows. The
    /// master checks their order.
    pub fn new(rows: &[[f64; 3]]) -> Option<Self> {
        let curve = |same: &[[f64; 3]]| (same[0][0], same.iter().map(|r| [r[1], r[2]]).collect());
        let curves: Vec<_> = rows.chunk_by(|a, b| a[0] == b[0]).map(curve).collect();
        (!curves.is_empty()).then_some(Self { curves })
    }

    /// Returns the largest coefficient.
    pub fn largest(&self) -> f64 {
        self.curves.iter().flat_map(|c| &c.1).map(|point| point[1]).fold(0.0, f64::max)
    }

    /// Computes the coefficient at a pressure [force/length^2] and a speed [length/time].
    pub fn coefficient(&self, pressure: f64, speed: f64) -> f64 {
        let at = |i: usize| {
            let curve = &self.curves[i].1;
            between(curve.len(), |k| curve[k][0], |k| curve[k][1], speed)
        };
        between(self.curves.len(), |i| self.curves[i].0, at, pressure)
    }
}

/// Interpolates linearly between `count` points with ascending places `place` and the values
/// `value`, with constant values beyond the ends.
fn between(
    count: usize,
    place: impl Fn(usize) -> f64,
    value: impl Fn(usize) -> f64,
    at: f64,
) -> f64 {
    let next = (0..count).find(|&i| at < place(i)).unwrap_or(count);
    if next == 0 || next == count {
        return value(next.min(count - 1));
    }
    let (a, b) = (place(next - 1), place(next));
    value(next - 1) + (value(next) - value(next - 1)) * (at - a) / (b - a)
}

impl Surface {
    /// Sets the friction of an own pair in this step. Its force and its pressure must be those of
    /// its history.
    pub fn set_friction(&self, p: &mut Pair, nodes: &Nodes) {
        let speed = || {
            // Velocities of other workers' nodes are known only without contact.
            let velocity = p.relative_velocity(nodes);
            (velocity - p.normal * velocity.dot(&p.normal)).norm()
        };
        if !self.interfaces.has_friction_by_pressure(p.interface) {
            p.friction_coefficient = self.interfaces.friction(p.interface, speed, 0.0);
            return;
        }
        let area = match (p.key.is_node(), p.key.is_segment()) {
            (true, _) => self.area_of(p, &nodes.x, |_| true),
            (_, true) => p.area,
            _ => p.edge_area,
        };
        let of_pair = || if area > 0.0 { p.force.dot(&p.normal).max(0.0) / area } else { 0.0 };
        let pressure = if p.key.is_node() { p.pressure } else { of_pair() };
        p.friction_coefficient = self.interfaces.friction(p.interface, speed, pressure);
        let limit = self.interfaces.friction_limit(p.interface);
        if limit < f64::INFINITY && area > 0.0 {
            p.limit_friction(limit, area);
        }
    }
}

/// Computes the area of contact of two edges in an interface; 0 if its friction does not depend
/// on the pressure [length^2].
pub fn edge_area((surface, interface): (&Surface, u16), edges: [&Edge; 2], x: &[Row]) -> f64 {
    if !surface.interfaces.has_friction_by_pressure(interface) {
        return 0.0;
    }
    let width = |e: &Edge| 2.0 * surface.interfaces.measure(interface, (e.half, e.scale)).1;
    let [a, b] = edges.map(|e| {
        let [p, q] = e.ends(x);
        q - p
    });
    let (lengths, widths) = ([a.norm(), b.norm()], edges.map(width));
    let most = lengths[0].min(lengths[1]) * widths[0].min(widths[1]);
    let sine = a.cross(&b).norm() / (lengths[0] * lengths[1]);
    if sine * most > widths[0] * widths[1] { widths[0] * widths[1] / sine } else { most }
}

#[cfg(test)]
mod tests {
    use super::FrictionTable;

    #[test]
    fn coefficients_are_interpolated_over_pressure_and_speed() {
        let rows = [
            [0.0, 0.0, 0.4],
            [0.0, 10.0, 0.2],
            [2.0, 0.0, 0.2],
            [2.0, 20.0, 0.1],
            [4.0, 0.0, 0.05],
        ];
        let table = FrictionTable::new(&rows).unwrap();
        let near = |at: [f64; 2], wanted: f64| {
            let found = table.coefficient(at[0], at[1]);
            assert!((found - wanted).abs() < 1e-15, "{at:?}: {found}, wanted {wanted}");
        };
        near([0.0, 0.0], 0.4);
        near([0.0, 5.0], 0.3);
        near([0.0, 99.0], 0.2);
        near([1.0, 10.0], 0.5 * (0.2 + 0.15));
        near([3.0, 5.0], 0.5 * (0.175 + 0.05));
        near([9.0, 5.0], 0.05);
        assert_eq!(table.largest(), 0.4);
        assert!(FrictionTable::new(&[]).is_none());
    }
}
