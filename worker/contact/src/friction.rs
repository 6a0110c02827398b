//! Friction that depends on the contact pressure: a largest shear stress (VC of LS-DYNA's
//! *CONTACT), and coefficients by pressure and sliding speed (`friction_table.rs`).
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
            (true, _) => self.area_of((p.nodes[0], &p.normal), &nodes.x, |_| true),
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
