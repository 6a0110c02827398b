//! A projected pair with all that the local search needs to know of its node and segment.

use crate::geometry::Nearest;
use crate::pairs::{Pair, PairKey, padded};
use crate::projections::ProjectedPair;
use crate::shell_offset;
use crate::surface::{Segment, Surface};
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};

/// Limit for a surface that is folded over itself: distance from the fold over the height above
/// the surface. Above this limit the angle of the fold is below about 60 degrees.
const FOLDED: f64 = 0.5;

/// A projected pair with the data of its node and segment.
#[derive(Clone, Copy)]
pub struct PairGeometry<'a> {
    /// The segment.
    pub segment: &'a Segment,
    /// Local node of the slave.
    pub slave: u32,
    /// Index of the slave among the surface's slaves.
    pub slave_index: usize,
    /// Nodes of the segment in the mask of `CandidatePair::shared_node_mask`.
    pub shared_node_mask: u8,
    /// Contact interface of the two.
    pub interface: u16,
    /// Distance of the contact surfaces from the mesh, the sum of both half thicknesses
    /// [length].
    pub thickness: f64,
    /// Contact thickness [length].
    pub scale: f64,
    /// See [`Pair::speed`].
    pub speed: f64,
    /// True if the node's surface comes before the segment's.
    pub first: bool,
    /// Step size [time].
    pub dt: f64,
    /// See [`ProjectedPair::step`].
    pub step: f64,
    /// Projection of the slave onto the segment.
    pub near: &'a Nearest,
    /// Distance of the segment's middle surface from its nodes along its normal [length].
    pub offset: f64,
    /// Vector from the node to the middle surface of its own shells [length].
    pub shift: V3,
}

impl<'a> PairGeometry<'a> {
    /// Collects the data of a pair for a step of size `dt` [time]. Returns `None` if no interface
    /// has this slave and this segment.
    pub fn new(
        (nodes, surface): (&Nodes, &'a Surface),
        slave_index: usize,
        projected: &'a ProjectedPair,
        dt: f64,
    ) -> Option<Self> {
        let ProjectedPair { of, step, near } = projected;
        let (slave, segment) =
            (surface.slaves[slave_index], &surface.segments[of.segment as usize]);
        let interface = surface.interface(slave_index, segment)?;
        let (thickness, scale) = surface.sizes(interface, slave, segment);
        let around = surface.precedes(slave_index);
        let (first, speed) =
            (around < (segment.part, segment.id), surface.slower(around.0, segment.part));
        Some(Self {
            segment,
            slave,
            slave_index,
            shared_node_mask: of.shared_node_mask,
            interface,
            thickness,
            scale,
            speed,
            first,
            dt,
            step: *step,
            near,
            offset: surface.offset_of(interface, segment),
            shift: surface.shift_of_slave(interface, slave_index, &nodes.x),
        })
    }

    /// Returns the vector from the middle surface of the segment to a point, from the vector from
    /// its nearest point [length].
    pub fn relative_to_middle(&self, offset: &V3) -> V3 {
        if self.offset == 0.0 { *offset } else { offset - self.near.normal * self.offset }
    }

    /// Returns the shift of the node along a unit vector [length]. A node without shift has -0.0,
    /// whose sum with any number has the same bits.
    pub fn shift_along(&self, direction: &V3) -> f64 {
        if self.shift == V3::zeros() { -0.0 } else { self.shift.dot(direction) }
    }

    /// Returns true if the surface has folded over between a slave and a neighbouring shell, so
    /// that the slave is above the shell's inside. The rim of that shell is shared with the slave's
    /// own segments or with the next ones. Contact with the rim would make a mesh that is finer
    /// than its thickness touch itself in its plane and at every corner.
    pub fn has_folded_over(&self, nodes: &Nodes, offset: &V3) -> bool {
        let in_ring = |k: &usize| self.shared_node_mask >> k & 1 == 1;
        let near = self.near;
        let corners = if self.segment.is_triangle() { 3 } else { 4 };
        let (shared, others) = ((0..corners).filter(in_ring), (0..corners).filter(|k| !in_ring(k)));
        if near.rim || others.clone().next().is_none() {
            return false;
        }
        let at = |k: usize| V3::from(xyz(&nodes.x[self.segment.nodes[k] as usize]));
        let of_others = others.clone().map(at).sum::<V3>() / others.clone().count() as f64;
        let of_ring = shared.clone().map(at).sum::<V3>() / shared.count() as f64;
        let inside = others.map(|k| near.shape[k]).sum::<f64>() * (of_others - of_ring).norm();
        inside > FOLDED * offset.norm()
    }

    /// Returns the pair without history; it acts along `normal`, from this `side` of the segment.
    pub fn pair(&self, nodes: &Nodes, surface: &Surface, normal: V3, side: f64) -> Pair {
        let PairGeometry { segment, slave, near, .. } = *self;
        let [a, b, c, d] = near.shape;
        let shape = padded([1.0, a, b, c, d]);
        let [i, j, k, l] = segment.nodes;
        Pair {
            shape,
            weight: shape,
            normal,
            side,
            lever_arms: self.lever_arms(nodes, surface, &normal),
            interface: self.interface,
            contact_thickness: self.scale,
            speed: self.speed,
            slave_surface_first: self.first,
            is_owned: true,
            ..Pair::new(
                PairKey::of_node(nodes.id[slave as usize], segment.id),
                segment.id,
                [slave, i, j, k, l],
            )
        }
    }

    /// Returns the lever arms of friction on the slave and on the segment, in proportion to each
    /// other [length]; zero without friction.
    ///
    /// The contact surfaces are half a thickness away from the middle surfaces. A couple about the
    /// normal of a shell meets almost no stiffness. Therefore, where friction acts on the rim of
    /// one shell, the other side takes the couple: each half thickness is weighted with the square
    /// of the cosine between the pair's normal and the shell's normal.
    fn lever_arms(&self, nodes: &Nodes, surface: &Surface, normal: &V3) -> [f64; 2] {
        /// Limit of the weighted half thicknesses, as a fraction of their sum, at which both
        /// surfaces touch at their rims.
        const RIM: f64 = 1e-6;
        let PairGeometry { segment, slave, interface, near, .. } = *self;
        if !surface.interfaces.has_friction(interface) {
            return [0.0; 2];
        }
        let halves = surface.halves(interface, slave, segment);
        let shifted = self.offset != 0.0 || self.shift != V3::zeros();
        let facing = |s: &Segment| {
            let own = || s.middle_normal(&nodes.x).map_or(0.0, |n| n.dot(normal).powi(2));
            if s.is_line() { 1.0 } else { own() }
        };
        let shells = surface.around(self.slave_index).filter(|s| !s.is_solid());
        let ahead = shells.map(facing).reduce(f64::max).unwrap_or(1.0);
        let behind = if segment.is_line() { 1.0 } else { near.normal.dot(normal).powi(2) };
        if shifted {
            let towards = [-self.shift_along(normal), self.offset * near.normal.dot(normal)];
            let apart = (V3::from(xyz(&nodes.x[slave as usize])) - near.point).dot(normal);
            let weighted = [halves[0] * ahead, halves[1] * behind];
            return shell_offset::lever_arms(weighted, towards, apart, [ahead, behind]);
        }
        if halves[0] * ahead + halves[1] * behind <= RIM * (halves[0] + halves[1]) {
            return halves;
        }
        [halves[0] * ahead, halves[1] * behind]
    }
}
