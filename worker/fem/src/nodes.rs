//! Nodal data, stored as columns. The first `local_count` nodes are local: nodes of own elements.
//! This worker integrates them, also those that other workers share; all compute the same bits.
//! The rest are ghost nodes: copies that contact needs.

use crate::step_data::StepData;
use crate::time::ElementSet;
use bytemuck::{Pod, Zeroable};
use crumple_math::lanes::Lane;
use crumple_math::row::{Row, row, xyz};
use crumple_math::threads;
use crumple_math::vector_range::VectorRange;
use crumple_proto::ids::NodeId;
use crumple_proto::partition::NodeRecord;
use std::ops::Range;

/// Nodal columns as elements see them, indexed by local node; the fourth component is padding.
#[derive(Clone, Copy)]
pub struct NodeView<'a> {
    /// Coordinates [length].
    pub x: &'a [Row],
    /// Velocities at mid-step [length/time].
    pub v: &'a [Row],
    /// Rotational velocities at mid-step [1/time].
    pub w: &'a [Row],
}

/// Mean velocities of a node in an outer step, see [`Nodes::mean_v`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct OuterStepMean {
    /// The node.
    pub id: NodeId,
    /// Velocity [length/time].
    pub v: [f64; 3],
    /// Rotational velocity [1/time].
    pub w: [f64; 3],
}

/// Columns over local nodes in ascending id, then over ghost nodes in ascending id. While contact
/// forces are computed, nodes of replicated pairs may follow them, in ascending id. The rotational
/// columns are empty if the model has no rotations.
#[derive(Debug, Default)]
pub struct Nodes {
    /// Number of this worker, counted from 0.
    pub me: u32,
    /// Number of local nodes.
    pub local_count: usize,
    /// True if nodes have rotations.
    pub rotations: bool,
    /// Global ids.
    pub id: Vec<NodeId>,
    /// Worker that owns the node: the lowest one of which it is a local node.
    pub owner: Vec<u32>,
    /// Bits 0..6: x, y, z, rx, ry, rz are fixed or prescribed.
    pub fixed: Vec<u8>,
    /// Initial coordinates [length].
    pub x0: Vec<Row>,
    /// Coordinates [length].
    pub x: Vec<Row>,
    /// Coordinates at the last update of folds, in the same cycle on all workers [length].
    pub seen: Vec<Row>,
    /// Displacements of local nodes in the last step [length].
    pub displacements: VectorRange,
    /// Velocities at the last mid-step [length/time].
    pub v: Vec<Row>,
    /// Rotational velocities at the last mid-step [1/time].
    pub w: Vec<Row>,
    /// Velocities at the next mid-step; without contact until contact is enforced [length/time].
    pub v_next: Vec<Row>,
    /// Rotational velocities at the next mid-step; without contact until contact is enforced
    /// [1/time]. Ghost nodes have them only if contact has friction.
    pub w_next: Vec<Row>,
    /// Force without contact; local nodes only [force].
    pub force: Vec<Row>,
    /// Moment; local nodes only [force length].
    pub moment: Vec<Row>,
    /// Lumped mass [mass].
    pub mass: Vec<f64>,
    /// Lumped rotational inertia [mass length^2].
    pub inertia: Vec<f64>,
    /// Inverse mass per component, zero if fixed or prescribed [1/mass].
    pub inv_mass: Vec<Row>,
    /// Sum of the velocities in the cycles of the outer step so far, over the number of its
    /// cycles; at the end of the outer step the mean. Empty without subcycles [length/time].
    pub mean_v: Vec<Row>,
    /// Rotational velocities as in `mean_v` [1/time].
    pub mean_w: Vec<Row>,
    /// Inverse rotational inertia per component, zero if fixed or prescribed [1/(mass length^2)].
    pub inv_inertia: Vec<Row>,
}

/// Data of a node on which the forces of contact pairs depend.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ContactNode {
    /// The node.
    pub id: NodeId,
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Velocity at the last mid-step, and at the next one without contact [length/time].
    pub v: [[f64; 3]; 2],
    /// Rotational velocity at the next mid-step without contact [1/time].
    pub w_next: [f64; 3],
    /// Inverse mass and inverse rotational inertia per component, as in [`Nodes`].
    pub inverse: [[f64; 3]; 2],
    /// Lumped mass [mass].
    pub mass: f64,
}

/// Least number of nodes of which a thread computes the motion at a time.
const PIECE: usize = 1024;

/// Returns the ranges of the rotational columns: those of nodes, or as many empty ones.
fn turning_ranges(ranges: &[Range<usize>], rotations: bool) -> Vec<Range<usize>> {
    ranges.iter().map(|range| if rotations { range.clone() } else { 0..0 }).collect()
}

/// Owner of the nodes that [`Nodes::push_contact_node`] appends.
const NOT_HELD: u32 = u32::MAX;

impl Nodes {
    /// Creates the local nodes of worker `me` from records in ascending id. All are owned by `me`
    /// until it is known which other workers share them.
    pub fn new(records: &[NodeRecord], me: u32, rotations: bool) -> Self {
        let mut n = Self { me, local_count: records.len(), rotations, ..Self::default() };
        records.iter().for_each(|r| n.push(r, me));
        n.force = vec![[0.0; 4]; n.local_count];
        n.moment = vec![[0.0; 4]; if rotations { n.local_count } else { 0 }];
        n
    }

    /// Appends a node.
    pub fn push(&mut self, r: &NodeRecord, owner: u32) {
        self.id.push(r.id);
        self.owner.push(owner);
        self.fixed.push(u8::try_from(r.fixed).expect("six bits"));
        self.x0.push(row(r.x0));
        self.x.push(row(r.x));
        self.seen.push(row(r.seen));
        self.v.push(row(r.v));
        self.v_next.push(row(r.v));
        self.mass.push(r.mass);
        self.inv_mass.push([0.0; 4]);
        if self.rotations {
            self.w.push(row(r.w));
            self.w_next.push(row(r.w));
            self.inertia.push(r.inertia);
            self.inv_inertia.push([0.0; 4]);
        }
        self.invert_mass(self.id.len() - 1);
    }

    /// Returns the data of node `i` on which contact forces depend; zero for properties that it
    /// does not have.
    pub fn contact_node(&self, i: usize) -> ContactNode {
        let turning = |rows: &[Row]| rows.get(i).map_or([0.0; 3], xyz);
        ContactNode {
            id: self.id[i],
            x: xyz(&self.x[i]),
            v: [xyz(&self.v[i]), xyz(&self.v_next[i])],
            w_next: turning(&self.w_next),
            inverse: [xyz(&self.inv_mass[i]), turning(&self.inv_inertia)],
            mass: self.mass[i],
        }
    }

    /// Appends a node of other workers that only contact forces use. [`Self::truncate`] removes
    /// such nodes.
    pub fn push_contact_node(&mut self, node: &ContactNode) {
        let [v, v_next] = node.v;
        let record =
            NodeRecord { id: node.id, x: node.x, v, mass: node.mass, ..NodeRecord::default() };
        self.push(&record, NOT_HELD);
        let i = self.len() - 1;
        (self.v_next[i], self.inv_mass[i]) = (row(v_next), row(node.inverse[0]));
        if self.rotations {
            (self.w_next[i], self.inv_inertia[i]) = (row(node.w_next), row(node.inverse[1]));
        }
    }

    /// Adds ghost nodes, given with their owners, which this worker does not have yet. Returns the
    /// new index of each ghost that it had, in ascending order of ids.
    pub fn add_ghosts(&mut self, added: impl IntoIterator<Item = (NodeRecord, u32)>) -> Vec<u32> {
        let had: Vec<NodeId> = self.id[self.local_count..].to_vec();
        let kept = (self.local_count..self.id.len()).map(|i| (self.record(i), self.owner[i]));
        let mut all: Vec<(NodeRecord, u32)> = kept.chain(added).collect();
        all.sort_unstable_by_key(|(record, _)| record.id);
        self.remove_ghosts();
        all.iter().for_each(|(record, owner)| self.push(record, *owner));
        had.iter().map(|&id| self.index_of(id).expect("a ghost that stays")).collect()
    }

    fn remove_ghosts(&mut self) {
        self.truncate(self.local_count);
    }

    /// Keeps the first `count` nodes, at least all local ones.
    pub fn truncate(&mut self, count: usize) {
        let local = count.max(self.local_count);
        self.id.truncate(local);
        self.owner.truncate(local);
        self.fixed.truncate(local);
        self.mass.truncate(local);
        self.inertia.truncate(local);
        let Self { x0, x, seen, v, w, v_next, w_next, inv_mass, inv_inertia, .. } = self;
        for rows in [x0, x, seen, v, w, v_next, w_next, inv_mass, inv_inertia] {
            rows.truncate(local);
        }
    }

    /// Recomputes the inverse mass and inertia of node `i`.
    #[inline]
    pub fn invert_mass(&mut self, i: usize) {
        let inverse = |m: f64| if m > 0.0 { 1.0 / m } else { 0.0 };
        let free = |bit: usize, a: f64| if self.fixed[i] >> bit & 1 == 1 { 0.0 } else { a };
        let im = inverse(self.mass[i]);
        self.inv_mass[i] = [free(0, im), free(1, im), free(2, im), 0.0];
        if self.rotations {
            let ii = inverse(self.inertia[i]);
            self.inv_inertia[i] = [free(3, ii), free(4, ii), free(5, ii), 0.0];
        }
    }

    /// Returns the state of node `i`; zero for properties that it does not have.
    pub fn record(&self, i: usize) -> NodeRecord {
        // A new field is an error here: state has to be added, all else to the last lists.
        let Self {
            id,
            fixed,
            x0,
            x,
            seen,
            v,
            w,
            mass,
            inertia,
            // See `mean`.
            mean_v: _,
            mean_w: _,
            // Computed for each partition.
            me: _,
            local_count: _,
            rotations: _,
            owner: _,
            inv_mass: _,
            inv_inertia: _,
            // Computed in each step before they are used.
            v_next: _,
            w_next: _,
            force: _,
            moment: _,
            // After a new partition contact searches again and does not need them.
            displacements: _,
        } = self;
        NodeRecord {
            id: id[i],
            fixed: fixed[i].into(),
            x0: xyz(&x0[i]),
            x: xyz(&x[i]),
            seen: xyz(&seen[i]),
            v: xyz(&v[i]),
            w: w.get(i).map_or([0.0; 3], xyz),
            mass: mass[i],
            inertia: inertia.get(i).copied().unwrap_or(0.0),
        }
    }

    /// Computes velocities at the next mid-step from forces and moments, without contact and
    /// walls. `mid` is the velocity step [time].
    pub fn accelerate(&mut self, mid: f64) {
        let ranges = threads::ranges(self.local_count, PIECE);
        let next = threads::cut(&mut self.v_next, &ranges);
        let turning = threads::cut(&mut self.w_next[..], &turning_ranges(&ranges, self.rotations));
        let pieces = ranges.into_iter().zip(next.into_iter().zip(turning)).collect();
        threads::map(pieces, |(range, (next, turning))| {
            for (i, next) in range.clone().zip(next) {
                let (v, force, inverse) = (&self.v[i], &self.force[i], &self.inv_mass[i]);
                *next = std::array::from_fn(|c| v[c] + mid * force[c] * inverse[c]);
            }
            for (i, next) in range.zip(turning) {
                let (w, moment, inverse) = (&self.w[i], &self.moment[i], &self.inv_inertia[i]);
                *next = std::array::from_fn(|c| w[c] + mid * moment[c] * inverse[c]);
            }
        });
    }

    /// Moves local nodes to the next time, by the step `dt` [time].
    pub fn advance(&mut self, dt: f64) {
        std::mem::swap(&mut self.v, &mut self.v_next);
        // Ghosts get those of their owners before contact with friction or output reads them.
        std::mem::swap(&mut self.w, &mut self.w_next);
        let ranges = threads::ranges(self.local_count, PIECE);
        let x = threads::cut(&mut self.x, &ranges);
        let pieces = ranges.into_iter().zip(x).collect();
        let moved = threads::map(pieces, |(range, x)| {
            let v = &self.v[range];
            VectorRange::from_vectors(x.len(), |i| {
                let by = Lane::splat(dt) * Lane::new(v[i]);
                x[i] = (Lane::new(x[i]) + by).to_array();
                by
            })
        });
        self.displacements = VectorRange::of_all(moved);
    }

    /// Moves local node `i` to the coordinates `to` [length] after the end of the step `dt` [time].
    /// [`Nodes::displacements`] then contain both displacements of the node together, if it is
    /// moved once.
    pub fn relocate(&mut self, i: usize, to: [f64; 3], dt: f64) {
        let before = self.x[i];
        self.x[i] = row(to);
        let in_step = Lane::splat(dt) * Lane::new(self.v[i]);
        self.displacements.include(in_step + Lane::new(self.x[i]) - Lane::new(before));
    }

    /// Adds the velocities of a cycle to the mean over an outer step of `subcycles` cycles.
    /// With [`ElementSet::All`] the outer step begins.
    pub fn accumulate_outer_means(&mut self, subcycles: u64, set: ElementSet) {
        let share = 1.0 / subcycles as f64;
        for (mean, v) in [(&mut self.mean_v, &self.v), (&mut self.mean_w, &self.w)] {
            for (mean, v) in mean.iter_mut().zip(v) {
                (0..4).for_each(|c| {
                    let before = if set == ElementSet::All { 0.0 } else { mean[c] };
                    mean[c] = share.mul_add(v[c], before)
                });
            }
        }
    }

    /// Returns the mean velocities of node `i`, if they are kept.
    pub fn mean(&self, i: usize) -> Option<OuterStepMean> {
        let v = xyz(self.mean_v.get(i)?);
        Some(OuterStepMean { id: self.id[i], v, w: self.mean_w.get(i).map_or([0.0; 3], xyz) })
    }

    /// Keeps mean velocities of local nodes from now on. `means` are those that the previous
    /// workers of the nodes kept.
    pub fn retain_outer_means(&mut self, means: &[OuterStepMean]) {
        self.mean_v = vec![[0.0; 4]; self.local_count];
        self.mean_w = vec![[0.0; 4]; if self.rotations { self.local_count } else { 0 }];
        for mean in means {
            let i = self.local_index(mean.id).expect("the node of a mean is local") as usize;
            self.mean_v[i] = row(mean.v);
            if self.rotations {
                self.mean_w[i] = row(mean.w);
            }
        }
    }

    /// Returns the view of slow elements at the start of an outer step: mean velocities of the
    /// previous outer step.
    #[inline]
    pub fn mean_view(&self) -> NodeView<'_> {
        NodeView { x: &self.x[..self.local_count], v: &self.mean_v, w: &self.mean_w }
    }

    /// Returns the view of elements: coordinates and velocities.
    #[inline]
    pub fn view(&self) -> NodeView<'_> {
        NodeView { x: &self.x, v: &self.v, w: &self.w }
    }

    /// Returns the bytes of the translational and the rotational columns, without unused
    /// capacity.
    pub fn bytes(&self) -> [usize; 2] {
        let rows =
            |columns: &[&Vec<Row>]| columns.iter().map(|c| size_of_val(&c[..])).sum::<usize>();
        let named =
            size_of_val(&self.id[..]) + size_of_val(&self.owner[..]) + size_of_val(&self.fixed[..]);
        let moving = [
            &self.x0,
            &self.x,
            &self.seen,
            &self.v,
            &self.v_next,
            &self.mean_v,
            &self.force,
            &self.inv_mass,
        ];
        let turning = [&self.w, &self.w_next, &self.mean_w, &self.moment, &self.inv_inertia];
        [
            named + size_of_val(&self.mass[..]) + rows(&moving),
            size_of_val(&self.inertia[..]) + rows(&turning),
        ]
    }

    /// Returns the data of local nodes that a step without contact reads and writes.
    pub fn step_data(&self) -> Vec<StepData> {
        let each = self.local_count * size_of::<Row>();
        let row = |data, bytes, reads, writes| StepData { data, bytes, reads, writes };
        let mut rows = vec![
            // Elements read coordinates and velocities; the end of a step changes coordinates.
            row("coordinates", each, 2, 1),
            row("velocities", each, 2, 0),
            row("velocities of the next step", each, 1, 1),
            row("nodal forces", each, 1, 1),
            row("inverse masses", each, 1, 0),
        ];
        if self.rotations {
            rows.extend([
                row("rotational velocities", each, 2, 0),
                row("rotational velocities of the next step", each, 1, 1),
                row("nodal moments", each, 1, 1),
                row("inverse inertias", each, 1, 0),
            ]);
        }
        rows
    }

    /// Returns the number of local and ghost nodes.
    #[inline]
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Returns the mass of node `i` in contact [mass]. The mass of a tied node is at its masters;
    /// in contact the node still has it.
    #[inline]
    pub fn contact_mass(&self, i: usize) -> f64 {
        let [x, y, z, _] = self.inv_mass[i];
        let inverse = x.max(y).max(z);
        if self.mass[i] > 0.0 || inverse == 0.0 { self.mass[i] } else { 1.0 / inverse }
    }

    /// Returns true if this worker owns node `i`.
    #[inline]
    pub fn is_owned(&self, i: usize) -> bool {
        i < self.local_count && self.owner[i] == self.me
    }

    /// Returns true if there are no nodes.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Returns the index of a local node.
    #[inline]
    pub fn local_index(&self, id: NodeId) -> Option<u32> {
        self.id[..self.local_count].binary_search(&id).ok().map(|i| i as u32)
    }

    /// Returns the index of a local or ghost node. Call it only while there are no other nodes.
    #[inline]
    pub fn index_of(&self, id: NodeId) -> Option<u32> {
        debug_assert!(self.owner.last() != Some(&NOT_HELD), "there are nodes after the ghosts");
        self.index_among(id, self.len())
    }

    /// Returns the index of a node among the first `count`, local nodes and ghosts.
    #[inline]
    pub fn index_among(&self, id: NodeId, count: usize) -> Option<u32> {
        let exterior = || {
            self.id[self.local_count..count]
                .binary_search(&id)
                .ok()
                .map(|i| (self.local_count + i) as u32)
        };
        self.local_index(id).or_else(exterior)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node that a device moves after the step has both displacements together.
    #[test]
    fn displacements_contain_those_after_the_step() {
        let at = |id: u64| NodeRecord {
            id: NodeId(id),
            v: [2.0, 0.0, 0.0],
            mass: 1.0,
            ..NodeRecord::default()
        };
        let mut nodes = Nodes::new(&[at(1), at(2)], 0, false);
        nodes.advance(0.5);
        assert_eq!(nodes.displacements.diameter(), 0.0, "both nodes move by 1");
        nodes.relocate(1, [1.0, 3.0, 0.0], 0.5);
        assert_eq!(nodes.x, [row([1.0, 0.0, 0.0]), row([1.0, 3.0, 0.0])]);
        assert_eq!(nodes.displacements.diameter(), 3.0);
    }

    /// Ghosts stay in ascending id, and those that stay keep their state.
    #[test]
    fn new_ghosts_are_put_among_the_others() {
        let record = |id: u64| NodeRecord {
            id: NodeId(id),
            x: [id as f64, 0.5, -0.0],
            v: [0.0, id as f64, 0.0],
            w: [0.0, 0.0, id as f64],
            mass: 2.0 * id as f64,
            inertia: 3.0,
            fixed: id % 64,
            ..NodeRecord::default()
        };
        let mut nodes = Nodes::new(&[record(12), record(30)], 1, true);
        assert!(nodes.add_ghosts([10, 20].map(|id| (record(id), 0))).is_empty());
        let before = [2, 3].map(|i| nodes.record(i));
        let moved = nodes.add_ghosts([15, 25, 5].map(|id| (record(id), 2)));
        assert_eq!(moved, [3, 5], "10 and 20");
        assert_eq!(nodes.id, [12, 30, 5, 10, 15, 20, 25].map(NodeId));
        assert_eq!(nodes.owner, [1, 1, 2, 0, 2, 0, 2]);
        let after: Vec<NodeRecord> = moved.iter().map(|&i| nodes.record(i as usize)).collect();
        assert_eq!(after, before);
        let rows =
            [&nodes.x, &nodes.v, &nodes.w, &nodes.w_next, &nodes.inv_mass, &nodes.inv_inertia];
        assert!(rows.iter().all(|rows| rows.len() == 7) && nodes.local_count == 2);
    }
}
