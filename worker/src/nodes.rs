//! Nodal columns. The first `held` nodes carry own elements and are integrated here, also when
//! other workers hold them too: all compute the same bits. The rest are exterior: copies that
//! contact needs.

use crate::fem::elements::NodeView;
use bytemuck::{Pod, Zeroable};
use crumple_proto::ids::NodeId;
use crumple_proto::partition::NodeRecord;

/// Three components and padding, so that a row is one vector register.
pub type Row = [f64; 4];

/// A row from three components.
pub fn row(a: [f64; 3]) -> Row {
    [a[0], a[1], a[2], 0.0]
}

/// The three components of a row.
pub fn xyz(r: &Row) -> [f64; 3] {
    [r[0], r[1], r[2]]
}

/// A node's mean velocities in an outer step, see [`Nodes::mean_v`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct OuterStepMean {
    /// The node.
    pub id: NodeId,
    /// Of moving [length/time].
    pub v: [f64; 3],
    /// Of turning [1/time].
    pub w: [f64; 3],
}

/// Columns over local nodes; held nodes in ascending id, then exterior nodes in ascending id.
/// Where nothing can turn, the rotational columns are empty.
#[derive(Debug, Default)]
pub struct Nodes {
    /// This worker (0-based).
    pub me: u32,
    /// Number of held nodes.
    pub local_count: usize,
    /// Whether nodes can turn.
    pub rotations: bool,
    /// Global ids.
    pub id: Vec<NodeId>,
    /// Worker that owns the node: the lowest that holds it.
    pub owner: Vec<u32>,
    /// Bits 0..6: x, y, z, rx, ry, rz held fixed or prescribed.
    pub fixed: Vec<u8>,
    /// Initial coordinates [length].
    pub x0: Vec<Row>,
    /// Coordinates [length].
    pub x: Vec<Row>,
    /// Coordinates when it was last seen where surfaces are folded, in the same cycle by all
    /// workers [length].
    pub seen: Vec<Row>,
    /// Velocities at the last mid-step [length/time].
    pub v: Vec<Row>,
    /// Rotational velocities at the last mid-step [1/time].
    pub w: Vec<Row>,
    /// Velocities at the next mid-step; before contact is enforced, those without contact
    /// [length/time].
    pub v_next: Vec<Row>,
    /// Rotational velocities at the next mid-step; before contact is enforced, those without
    /// contact [1/time]. Of exterior nodes where contact has friction only.
    pub w_next: Vec<Row>,
    /// Force without contact [force]; held nodes only.
    pub force: Vec<Row>,
    /// Moment [force length]; held nodes only.
    pub moment: Vec<Row>,
    /// Lumped mass [mass].
    pub mass: Vec<f64>,
    /// Lumped rotational inertia [mass length^2].
    pub inertia: Vec<f64>,
    /// Inverse mass per component, zero where fixed or prescribed.
    pub inv_mass: Vec<Row>,
    /// Mean velocities in the cycles of the outer step so far, as fractions of all of its cycles;
    /// empty without subcycles [length/time].
    pub mean_v: Vec<Row>,
    /// The same of rotational velocities [1/time].
    pub mean_w: Vec<Row>,
    /// Inverse rotational inertia per component, zero where fixed or prescribed.
    pub inv_inertia: Vec<Row>,
}

impl Nodes {
    /// Held nodes of worker `me` from records sorted by id; they are its own until others are found
    /// to hold them.
    pub fn new(records: &[NodeRecord], me: u32, rotations: bool) -> Self {
        let mut n = Self { me, local_count: records.len(), rotations, ..Self::default() };
        records.iter().for_each(|r| n.push(r, me));
        n.force = vec![[0.0; 4]; n.local_count];
        n.moment = vec![[0.0; 4]; if rotations { n.local_count } else { 0 }];
        n
    }

    /// Appends one node.
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

    /// Brings the inverse masses of node `i` up to date.
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

    /// The whole state of node `i`; nought for what it does not have.
    pub fn record(&self, i: usize) -> NodeRecord {
        NodeRecord {
            id: self.id[i],
            fixed: self.fixed[i].into(),
            x0: xyz(&self.x0[i]),
            x: xyz(&self.x[i]),
            seen: xyz(&self.seen[i]),
            v: xyz(&self.v[i]),
            w: self.w.get(i).map_or([0.0; 3], xyz),
            mass: self.mass[i],
            inertia: self.inertia.get(i).copied().unwrap_or(0.0),
        }
    }

    /// Velocities at the next mid-step from forces and moments, contact and walls not yet felt.
    pub fn accelerate(&mut self, mid: f64) {
        for i in 0..self.local_count {
            for c in 0..4 {
                self.v_next[i][c] = self.v[i][c] + mid * self.force[i][c] * self.inv_mass[i][c];
            }
        }
        let turning =
            self.w_next.iter_mut().zip(&self.w).zip(self.moment.iter().zip(&self.inv_inertia));
        for ((next, w), (moment, inverse)) in turning {
            for c in 0..4 {
                next[c] = w[c] + mid * moment[c] * inverse[c];
            }
        }
    }

    /// Moves held nodes to the next time.
    pub fn advance(&mut self, dt: f64) {
        std::mem::swap(&mut self.v, &mut self.v_next);
        for (x, v) in self.x[..self.local_count].iter_mut().zip(&self.v) {
            (0..4).for_each(|c| x[c] += dt * v[c]);
        }
        let turning = self.local_count.min(self.w_next.len());
        self.w[..turning].swap_with_slice(&mut self.w_next[..turning]);
    }

    /// Takes the velocities of a cycle into the mean over an outer step of so many cycles; with
    /// `begins` it is the first of them.
    pub fn accumulate_outer_means(&mut self, subcycles: u64, begins: bool) {
        let share = 1.0 / subcycles as f64;
        for (mean, v) in [(&mut self.mean_v, &self.v), (&mut self.mean_w, &self.w)] {
            for (mean, v) in mean.iter_mut().zip(v) {
                (0..4).for_each(|c| {
                    mean[c] = share.mul_add(v[c], if begins { 0.0 } else { mean[c] })
                });
            }
        }
    }

    /// The mean velocities of node `i`, if they are kept.
    pub fn mean(&self, i: usize) -> Option<OuterStepMean> {
        let v = xyz(self.mean_v.get(i)?);
        Some(OuterStepMean { id: self.id[i], v, w: self.mean_w.get(i).map_or([0.0; 3], xyz) })
    }

    /// Keeps mean velocities of held nodes from now on; `means` are those from where they were kept
    /// before.
    pub fn retain_outer_means(&mut self, means: &[OuterStepMean]) {
        self.mean_v = vec![[0.0; 4]; self.local_count];
        self.mean_w = vec![[0.0; 4]; if self.rotations { self.local_count } else { 0 }];
        for mean in means {
            let i = self.local_index(mean.id).expect("means come with their nodes") as usize;
            self.mean_v[i] = row(mean.v);
            if self.rotations {
                self.mean_w[i] = row(mean.w);
            }
        }
    }

    /// What slow elements see when an outer step begins: the mean velocities of the one before.
    pub fn mean_view(&self) -> NodeView<'_> {
        NodeView { x: &self.x[..self.local_count], v: &self.mean_v, w: &self.mean_w }
    }

    /// What elements see.
    pub fn view(&self) -> NodeView<'_> {
        NodeView { x: &self.x, v: &self.v, w: &self.w }
    }

    /// Bytes of the columns of moving and of turning, spare room of lists left out.
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

    /// Number of local nodes, exterior ones included.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Mass of node `i` as contact meets it: a tied node, whose carriers have its mass, still has
    /// it there [mass].
    pub fn contact_mass(&self, i: usize) -> f64 {
        let [x, y, z, _] = self.inv_mass[i];
        let inverse = x.max(y).max(z);
        if self.mass[i] > 0.0 || inverse == 0.0 { self.mass[i] } else { 1.0 / inverse }
    }

    /// Whether this worker owns node `i`.
    pub fn is_owned(&self, i: usize) -> bool {
        i < self.local_count && self.owner[i] == self.me
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Local number of a held node.
    pub fn local_index(&self, id: NodeId) -> Option<u32> {
        self.id[..self.local_count].binary_search(&id).ok().map(|i| i as u32)
    }

    /// Local number of a node, held or exterior.
    pub fn index_of(&self, id: NodeId) -> Option<u32> {
        let exterior = || {
            self.id[self.local_count..]
                .binary_search(&id)
                .ok()
                .map(|i| (self.local_count + i) as u32)
        };
        self.local_index(id).or_else(exterior)
    }
}
