//! Loads: body forces, nodal forces, pressure on faces and of airbags, damping proportional to
//! mass of the model and of parts, and dampers at nodes of boundaries that let waves out.
//!
//! Pressure is added to the element nodal forces of the loaded element, so that the assembly sums
//! it in ascending element id with all other forces. Work is force times the mean of the
//! velocities before and after, as in the ledger.

use crate::blast::BlastOnFace;
use crate::curve::Curve;
use crate::fem::blocks::{Blocks, Portion};
use crate::math::row::{Row, row, xyz};
use crate::nodes::Nodes;
use crate::stateless;
use crate::time::ElementSet;
use crate::time::StepSizes;
use crate::work::{Work, WorkSum};
use crumple_proto::airbag::ResolvedAirbag;
use crumple_proto::exact_sum::ExactSum;
use crumple_proto::ids::NodeId;
use crumple_proto::loads::{Absorber, Gravity, PartDamping, Pressure, ResolvedLoads};
use nalgebra::{Matrix3, Vector3};

/// Loads on the nodes and elements of this worker, by local index.
#[derive(Debug, Default)]
pub struct Loads {
    curves: Vec<Curve>,
    /// Acceleration [length/time^2] and curve.
    gravity: Vec<(Row, Option<usize>)>,
    /// Body forces on parts.
    of_parts: Vec<PartGravity>,
    /// Damping of parts.
    damped_parts: Vec<LocalDamping>,
    forces: Vec<LocalForce>,
    pressures: Vec<Pressure>,
    airbags: Vec<ResolvedAirbag>,
    /// Gauge pressure of each airbag at the present time [force/length^2].
    pub airbag_pressures: Vec<f64>,
    faces: Vec<LoadedFace>,
    absorbers: Vec<LocalAbsorber>,
    /// Damping coefficient of the job [1/time].
    damping_given: f64,
    /// Curve of the factor on it [1]; without one it is 1.
    damping_curve: Option<usize>,
    /// Damping coefficient at the present time [1/time]; 0 before the first call of
    /// [`Loads::damp_at`].
    damping: f64,
    /// Acceleration of all body forces at the present time [length/time^2].
    falling: Row,
    /// Number of cycles for which a load on a local node acts. At a node with slow elements only
    /// it is the number of cycles of an outer step: such a node moves as with one long step.
    /// Empty without subcycles.
    cycles: Vec<f64>,
}

stateless!(Loads {
    curves,
    gravity,
    of_parts,
    damped_parts,
    forces,
    pressures,
    airbags,
    airbag_pressures,
    faces,
    absorbers,
    damping_given,
    damping_curve,
    damping,
    falling,
    cycles
});
stateless!(PartGravity { job, shares, falling });
stateless!(LocalDamping { job, shares, impulses, members, loads });
stateless!(LocalForce { job, nodes, factor });
stateless!(LoadedFace { source, slots, nodes, portion, rigid, cycles, shares, blast, force });

stateless!(LocalAbsorber { job, node, impulse });

/// Dampers of a local node.
#[derive(Debug)]
struct LocalAbsorber {
    job: Absorber,
    /// Local node, if it is here.
    node: Option<u32>,
    /// Impulse in the last step [force time].
    impulse: Row,
}

/// A body force on a fraction of the masses of some local nodes.
#[derive(Debug)]
struct PartGravity {
    job: Gravity,
    /// Local nodes with the fraction of their mass.
    shares: Vec<(u32, f64)>,
    /// Acceleration at the present time [length/time^2].
    falling: Row,
}

/// Damping of a fraction of the masses of some local nodes.
#[derive(Debug)]
struct LocalDamping {
    job: PartDamping,
    /// Local nodes outside of rigid bodies, with the fraction of their mass.
    shares: Vec<(u32, f64)>,
    /// Impulse and its moment on each of them in this step [force time, force length time].
    impulses: Vec<[Row; 2]>,
    /// Local members of rigid bodies, with the fraction of their mass.
    members: Vec<(u32, f64)>,
    /// Force and moment on each of them in this step [force, force length].
    loads: Vec<[Row; 2]>,
}

/// A force on some local nodes.
#[derive(Debug)]
struct LocalForce {
    job: crumple_proto::loads::NodalForce,
    nodes: Vec<u32>,
    /// Factor at the present time.
    factor: f64,
}

/// Sums over the faces of a bag.
#[derive(Clone, Debug, Default)]
pub struct BagSums {
    /// Terms of the volume [length^3].
    pub volume: ExactSum,
    /// Sum of `k |g_a|^2/M_a` over faces and corners [length^4/mass].
    pub softness: ExactSum,
}

/// Source of a pressure.
#[derive(Clone, Copy, Debug)]
enum PressureSource {
    /// Index of a pressure.
    Pressure(usize),
    /// Index of an airbag, and how many of its faces meet at a corner at most.
    Airbag { bag: usize, meeting: u32 },
}

/// A face of an own element under pressure.
#[derive(Debug)]
struct LoadedFace {
    source: PressureSource,
    /// Slots of the element nodal forces, and local nodes, in order around the normal.
    slots: [usize; 4],
    nodes: [u32; 4],
    portion: Portion,
    /// True if the element is rigid: no other force is in its slots.
    rigid: bool,
    /// Number of cycles for which the force acts: those of an outer step for slow elements.
    cycles: f64,
    /// Factors on the forces of a linear face, see
    /// [`load_shares`](crumple_proto::mesh::Shape::load_shares).
    shares: [f64; 4],
    /// Explosion that gives the pressure on the face.
    blast: Option<BlastOnFace>,
    /// Last forces on its nodes [force].
    force: [Row; 4],
}

impl LoadedFace {
    fn is_in(&self, set: ElementSet) -> bool {
        set == ElementSet::All || self.cycles == 1.0
    }

    /// Returns the forces of a pressure on its corners, which are at `x` [force].
    fn of_pressure(&self, pressure: f64, x: &[Row; 4]) -> [Row; 4] {
        let mut forces = on_corners(pressure, x, self.nodes);
        for (force, share) in forces.iter_mut().zip(self.shares) {
            (0..3).for_each(|c| force[c] *= share);
        }
        forces
    }
}

impl Loads {
    /// Creates the loads of a job. No node is loaded before [`Loads::bind_local`].
    pub fn new(job: &ResolvedLoads) -> Self {
        Self {
            curves: job.curves.iter().map(|points| Curve::new(points)).collect(),
            gravity: job
                .gravity
                .iter()
                .filter(|g| g.shares.is_none())
                .map(|g| (row(g.acceleration), g.curve))
                .collect(),
            of_parts: job
                .gravity
                .iter()
                .filter(|g| g.shares.is_some())
                .map(|g| PartGravity { job: g.clone(), shares: Vec::new(), falling: [0.0; 4] })
                .collect(),
            damped_parts: job
                .part_damping
                .iter()
                .map(|d| LocalDamping {
                    job: d.clone(),
                    shares: Vec::new(),
                    impulses: Vec::new(),
                    members: Vec::new(),
                    loads: Vec::new(),
                })
                .collect(),
            forces: job
                .forces
                .iter()
                .map(|f| LocalForce { job: f.clone(), nodes: Vec::new(), factor: 0.0 })
                .collect(),
            pressures: job.pressures.clone(),
            airbags: job.airbags.clone(),
            airbag_pressures: Vec::new(),
            faces: Vec::new(),
            absorbers: job
                .absorbers
                .iter()
                .map(|a| LocalAbsorber { job: a.clone(), node: None, impulse: [0.0; 4] })
                .collect(),
            damping_given: job.damping,
            damping_curve: job.damping_curve,
            damping: 0.0,
            falling: [0.0; 4],
            cycles: Vec::new(),
        }
    }

    /// Finds the loaded nodes and faces of this worker.
    pub fn bind_local(&mut self, nodes: &Nodes, blocks: &Blocks, subcycles: u64) {
        for f in &mut self.forces {
            f.nodes = f.job.nodes.iter().filter_map(|&id| nodes.local_index(id)).collect();
        }
        for absorber in &mut self.absorbers {
            absorber.node = nodes.local_index(absorber.job.node);
        }
        let local = |&(id, share): &(NodeId, f64)| Some((nodes.local_index(id)?, share));
        for g in &mut self.of_parts {
            g.shares = g.job.shares.iter().flatten().filter_map(local).collect();
        }
        for d in &mut self.damped_parts {
            d.shares = d.job.shares.iter().filter_map(local).collect();
            d.members = d.job.members.iter().filter_map(local).collect();
            d.impulses = vec![[[0.0; 4]; 2]; d.shares.len()];
            d.loads = vec![[[0.0; 4]; 2]; d.members.len()];
        }
        self.cycles.clear();
        let act = [self.gravity.len(), self.of_parts.len(), self.damped_parts.len()];
        if subcycles > 1 && (act != [0; 3] || !self.forces.is_empty()) {
            let of = |i| if blocks.has_subcycled_only(i) { subcycles as f64 } else { 1.0 };
            self.cycles.extend((0..nodes.local_count).map(of));
        }
        self.faces.clear();
        if self.pressures.is_empty() && self.airbags.is_empty() {
            return;
        }
        let slots = blocks.first_slots();
        for b in &blocks.blocks {
            for i in 0..b.count {
                let (e, slot) = (&blocks.elements[b.first + i], slots[b.first + i]);
                let face = |source, number: u8, inwards: bool| {
                    let (shape, number) = (e.record.shape, usize::from(number));
                    let corners = shape.faces()[number];
                    let order = match inwards {
                        false => [0, 1, 2, 3],
                        true if e.nodes[corners[2]] == e.nodes[corners[3]] => [0, 2, 1, 1],
                        true => [0, 3, 2, 1],
                    };
                    let corners = order.map(|c| corners[c]);
                    let shares = shape.load_shares(number);
                    LoadedFace {
                        source,
                        slots: corners.map(|c| slot + c),
                        nodes: corners.map(|c| e.nodes[c]),
                        portion: b.portion_of(i),
                        rigid: b.idle,
                        cycles: if b.slow { subcycles as f64 } else { 1.0 },
                        shares: order.map(|c| shares[c]),
                        blast: None,
                        force: [[0.0; 4]; 4],
                    }
                };
                for (p, pressure) in self.pressures.iter().enumerate() {
                    let source = PressureSource::Pressure(p);
                    let faces = pressure.faces_of(e.record.id);
                    let faces = faces.map(|number| face(source, number, false));
                    self.faces.extend(faces.filter_map(|face| with_blast(face, pressure, nodes)));
                }
                for (bag, airbag) in self.airbags.iter().enumerate() {
                    self.faces.extend(airbag.faces_of(e.record.id).map(|f| {
                        let source = PressureSource::Airbag { bag, meeting: f.meeting };
                        face(source, f.face, f.inwards)
                    }));
                }
            }
        }
    }

    /// Adds the terms of the own faces of each airbag to its sums. `inv_mass` gives the inverse
    /// masses of a local node [1/mass].
    pub fn measure_airbags(
        &self,
        nodes: &Nodes,
        inv_mass: impl Fn(u32) -> Row,
        sums: &mut [BagSums],
    ) {
        for face in &self.faces {
            let PressureSource::Airbag { bag, meeting } = face.source else { continue };
            let x = face.nodes.map(|n| nodes.x[n as usize]);
            let gradients = face.of_pressure(-1.0, &x);
            let (mut volume, mut softness) = (0.0, 0.0);
            for ((g, x), &n) in gradients.iter().zip(&x).zip(&face.nodes) {
                let inverse = inv_mass(n);
                for c in 0..3 {
                    volume += g[c] * (x[c] - self.airbags[bag].origin[c]) / 3.0;
                    softness += f64::from(meeting) * g[c] * g[c] * inverse[c];
                }
            }
            sums[bag].volume.add(volume);
            sums[bag].softness.add(softness);
        }
    }

    /// Adds pressure to the element nodal forces of a portion of the own elements. With
    /// [`ElementSet::All`] slow elements get the load of all cycles of the outer step.
    pub fn add_pressures(
        &mut self,
        blocks: &mut Blocks,
        nodes: &Nodes,
        time: f64,
        set: ElementSet,
        portion: Portion,
    ) {
        let due = |f: &&mut LoadedFace| f.portion == portion && f.is_in(set);
        for face in self.faces.iter_mut().filter(due).filter(|f| f.rigid) {
            face.slots.iter().for_each(|&s| blocks.force[s] = [0.0; 4]);
        }
        for face in self.faces.iter_mut().filter(due) {
            let pressure = match face.source {
                PressureSource::Pressure(p) => {
                    let p = &self.pressures[p];
                    let of_blast = face.blast.map_or(1.0, |blast| blast.pressure(time));
                    p.pressure * of_blast * factor(&self.curves, p.curve, time)
                }
                // Along the normals, which point outwards.
                PressureSource::Airbag { bag, .. } => -self.airbag_pressures[bag],
            };
            face.force =
                face.of_pressure(pressure * face.cycles, &face.nodes.map(|n| nodes.x[n as usize]));
            for (&slot, f) in face.slots.iter().zip(&face.force) {
                (0..3).for_each(|c| blocks.force[slot][c] -= f[c]);
            }
        }
    }

    /// Returns slots and forces of the last pressure, face by face [force].
    pub fn on_slots(&self) -> impl Iterator<Item = (usize, &Row)> {
        self.faces.iter().flat_map(|face| face.slots.iter().copied().zip(&face.force))
    }

    /// Returns how many times a load acts on a local node in this cycle.
    fn times(&self, i: usize, set: ElementSet) -> f64 {
        times(&self.cycles, i, set)
    }

    /// Adds body forces, the damping of members of rigid bodies and nodal forces to the forces of
    /// local nodes, in the order of the job. This damping takes the velocity before the step: a
    /// body has no frequency of its own, and is stable for a damping a up to `a dt = 2`.
    pub fn add_forces(&mut self, nodes: &mut Nodes, time: f64, set: ElementSet) {
        if !self.gravity.is_empty() {
            self.falling = [0.0; 4];
            for &(a, curve) in &self.gravity {
                let factor = factor(&self.curves, curve, time);
                (0..3).for_each(|c| self.falling[c] += factor * a[c]);
            }
            for (i, (f, m)) in nodes.force.iter_mut().zip(&nodes.mass).enumerate() {
                let m = m * self.times(i, set);
                (0..3).for_each(|c| f[c] += m * self.falling[c]);
            }
        }
        let cycles = &self.cycles;
        for g in &mut self.of_parts {
            let factor = factor(&self.curves, g.job.curve, time);
            (0..3).for_each(|c| g.falling[c] = factor * g.job.acceleration[c]);
            for &(n, share) in &g.shares {
                let n = n as usize;
                let m = nodes.mass[n] * share * times(cycles, n, set);
                (0..3).for_each(|c| nodes.force[n][c] += m * g.falling[c]);
            }
        }
        for d in &mut self.damped_parts {
            let damping = -d.job.coefficient * factor(&self.curves, d.job.curve, time);
            for (&(n, share), load) in d.members.iter().zip(&mut d.loads) {
                let n = n as usize;
                let by = damping * share * times(cycles, n, set);
                let force = xyz(&nodes.v[n]).map(|v| by * nodes.mass[n] * v);
                (0..3).for_each(|c| nodes.force[n][c] += force[c]);
                *load = [row(force), [0.0; 4]];
                if nodes.rotations {
                    let moment = xyz(&nodes.w[n]).map(|w| by * nodes.inertia[n] * w);
                    (0..3).for_each(|c| nodes.moment[n][c] += moment[c]);
                    load[1] = row(moment);
                }
            }
        }
        for load in &mut self.forces {
            load.factor = factor(&self.curves, load.job.curve, time);
        }
        for load in &self.forces {
            for n in load.nodes.iter().map(|&n| n as usize) {
                let factor = load.factor * self.times(n, set);
                (0..3).for_each(|c| nodes.force[n][c] += factor * load.job.force[c]);
                if nodes.rotations {
                    (0..3).for_each(|c| nodes.moment[n][c] += factor * load.job.moment[c]);
                }
            }
        }
    }

    /// Returns the acceleration of gravity that acts on all masses in this step [length/time^2].
    pub fn gravity(&self) -> Row {
        if self.gravity.is_empty() { [0.0; 4] } else { self.falling }
    }

    /// Damps the velocities without contact; contact forces act on velocities by
    /// [`StepSizes::dt_damped`]. With the damping a, `v+ = ((1 - b) v- + mid f/m) / (1 + b)`, `b
    /// = a mid / 2` (Belytschko, Liu & Moran 2000, box 6.1, with C = a M).
    pub fn apply_damping(&self, nodes: &mut Nodes, mid: f64) {
        if self.damping > 0.0 {
            let b = 0.5 * self.damping * mid;
            for i in 0..nodes.local_count {
                for c in (0..3).filter(|&c| nodes.inv_mass[i][c] > 0.0) {
                    nodes.v_next[i][c] = (nodes.v_next[i][c] - b * nodes.v[i][c]) / (1.0 + b);
                }
            }
            for ((next, w), inverse) in nodes
                .w_next
                .iter_mut()
                .zip(&nodes.w)
                .zip(&nodes.inv_inertia)
                .take(nodes.local_count)
            {
                for c in (0..3).filter(|&c| inverse[c] > 0.0) {
                    next[c] = (next[c] - b * w[c]) / (1.0 + b);
                }
            }
        }
    }

    /// Damps the velocities without contact of the nodes of damped parts, as
    /// [`Self::apply_damping`]. Contact does not know this damping: at a body at rest its forces
    /// are smaller by the fraction b.
    pub fn damp_parts(&mut self, nodes: &mut Nodes, time: f64, mid: f64) {
        for d in &mut self.damped_parts {
            let half = 0.5 * mid * d.job.coefficient * factor(&self.curves, d.job.curve, time);
            for (&(n, share), impulse) in d.shares.iter().zip(&mut d.impulses) {
                let (i, b) = (n as usize, half * share);
                *impulse = [[0.0; 4]; 2];
                let slow = |next: &mut f64, before: f64, mass: f64| {
                    let change = -b * (*next + before) / (1.0 + b);
                    *next += change;
                    mass * change
                };
                for c in (0..3).filter(|&c| nodes.inv_mass[i][c] > 0.0) {
                    impulse[0][c] = slow(&mut nodes.v_next[i][c], nodes.v[i][c], nodes.mass[i]);
                }
                if nodes.rotations {
                    for c in (0..3).filter(|&c| nodes.inv_inertia[i][c] > 0.0) {
                        impulse[1][c] =
                            slow(&mut nodes.w_next[i][c], nodes.w[i][c], nodes.inertia[i]);
                    }
                }
            }
        }
    }

    /// Sets the coefficient of the damping of all masses for a step that starts at `time`, and
    /// returns it [1/time].
    pub fn damp_at(&mut self, time: f64) -> f64 {
        self.damping = self.damping_given * factor(&self.curves, self.damping_curve, time);
        self.damping
    }

    /// Removes all damping.
    pub fn stop_damping(&mut self) {
        (self.damping_given, self.damping) = (0.0, 0.0);
        self.damped_parts.clear();
    }

    /// Lets the dampers of nodes act on the velocities without contact, in the middle of the step
    /// as [`Self::apply_damping`]: `(M + mid/2 C) (v+ - v*) = -mid/2 C (v- + v*)` with the velocity
    /// v* without them. The step stays stable at the stable step of the elements.
    pub fn absorb_waves(&mut self, nodes: &mut Nodes, mid: f64) {
        for absorber in &mut self.absorbers {
            absorber.impulse = [0.0; 4];
            let Some(i) = absorber.node.map(|n| n as usize) else { continue };
            let (mass, half) = (nodes.mass[i], 0.5 * mid);
            if mass <= 0.0 {
                continue;
            }
            let [xx, yy, zz, xy, yz, zx] = absorber.job.damping.map(|c| half * c);
            let damping = Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz);
            let sum = |c: usize| nodes.v[i][c] + nodes.v_next[i][c];
            let mut force = -(damping * Vector3::new(sum(0), sum(1), sum(2)));
            let mut matrix = damping + Matrix3::from_diagonal_element(mass);
            for c in (0..3).filter(|&c| nodes.inv_mass[i][c] == 0.0) {
                matrix.set_row(c, &Matrix3::identity().row(c));
                matrix.set_column(c, &Matrix3::identity().column(c));
                force[c] = 0.0;
            }
            let Some(inverse) = matrix.try_inverse() else { continue };
            let change = inverse * force;
            for c in 0..3 {
                nodes.v_next[i][c] += change[c];
                absorber.impulse[c] = mass * change[c];
            }
        }
    }

    /// Adds the work done on owned nodes and elements in the step to `sum`. The velocities at its
    /// end must be known.
    pub fn add_work(&self, nodes: &Nodes, steps: StepSizes, set: ElementSet, sum: &mut WorkSum) {
        let mid = steps.dt_velocity;
        let moved = |f: &Row, i: usize| Work::from_impulses(f, &nodes.v[i], &nodes.v_next[i]);
        let turned = |f: &Row, i: usize| Work::from_impulses(f, &nodes.w[i], &nodes.w_next[i]);
        let own = || (0..nodes.local_count).filter(|&i| nodes.is_owned(i));
        if !self.gravity.is_empty() {
            own().for_each(|i| {
                sum.add(moved(&self.falling, i) * (nodes.mass[i] * self.times(i, set) * mid));
            });
        }
        for g in &self.of_parts {
            let shares = g.shares.iter().map(|&(n, share)| (n as usize, share));
            for (i, share) in shares.filter(|s| nodes.is_owned(s.0)) {
                let mass = nodes.mass[i] * share * self.times(i, set);
                sum.add(moved(&g.falling, i) * (mass * mid));
            }
        }
        for d in &self.damped_parts {
            let of = |i: usize, [f, m]: &[Row; 2]| {
                moved(f, i) + if nodes.rotations { turned(m, i) } else { Work::default() }
            };
            let members = d.members.iter().map(|s| s.0 as usize).zip(&d.loads);
            for (i, load) in members.filter(|&(i, _)| nodes.is_owned(i)) {
                sum.add(of(i, load) * mid);
            }
            let others = d.shares.iter().map(|s| s.0 as usize).zip(&d.impulses);
            for (i, impulse) in others.filter(|&(i, _)| nodes.is_owned(i)) {
                sum.add(of(i, impulse));
            }
        }
        for load in &self.forces {
            let (f, m) = (row(load.job.force), row(load.job.moment));
            let of = |i: usize| {
                moved(&f, i) + if nodes.rotations { turned(&m, i) } else { Work::default() }
            };
            let owned = load.nodes.iter().map(|&n| n as usize).filter(|&i| nodes.is_owned(i));
            owned.for_each(|i| sum.add(of(i) * (self.times(i, set) * load.factor * mid)));
        }
        for face in self.faces.iter().filter(|f| f.is_in(set)) {
            let corners = face.nodes.iter().zip(&face.force);
            sum.add(corners.map(|(&n, f)| moved(f, n as usize)).sum::<Work>() * mid);
        }
        for absorber in &self.absorbers {
            let owned = absorber.node.map(|n| n as usize).filter(|&i| nodes.is_owned(i));
            owned.into_iter().for_each(|i| sum.add(moved(&absorber.impulse, i)));
        }
        if self.damping > 0.0 {
            own().for_each(|i| sum.add(self.damped(nodes, i, mid)));
        }
    }

    /// Returns the work of damping on node `i` [energy].
    fn damped(&self, nodes: &Nodes, i: usize, mid: f64) -> Work {
        let b = 0.5 * self.damping * mid;
        let part = |inv: &Row, mass: f64, v: &Row, next: &Row| {
            let free = (0..3).filter(|&c| inv[c] > 0.0);
            free.map(|c| Work::from_impulse(-mass * b * (v[c] + next[c]), v[c], next[c]))
                .sum::<Work>()
        };
        let moved = part(&nodes.inv_mass[i], nodes.mass[i], &nodes.v[i], &nodes.v_next[i]);
        if !nodes.rotations {
            return moved;
        }
        moved + part(&nodes.inv_inertia[i], nodes.inertia[i], &nodes.w[i], &nodes.w_next[i])
    }
}

/// Returns how many times a load acts on a local node in a cycle.
fn times(cycles: &[f64], i: usize, set: ElementSet) -> f64 {
    let cycles = cycles.get(i).copied().unwrap_or(1.0);
    if set == ElementSet::All || cycles == 1.0 { cycles } else { 0.0 }
}

/// Adds the explosion of a pressure to a face; `None` if the face is too far away for it. A
/// pressure below zero acts on the other side of the face.
fn with_blast(face: LoadedFace, pressure: &Pressure, nodes: &Nodes) -> Option<LoadedFace> {
    let Some(blast) = &pressure.blast else { return Some(face) };
    let x = face.nodes.map(|n| Vector3::from(xyz(&nodes.x0[n as usize])));
    let [a, b, c, d] = x;
    let middle =
        if face.nodes[2] == face.nodes[3] { (a + b + c) / 3.0 } else { (a + b + c + d) / 4.0 };
    let normal = (c - a).cross(&(d - b)) * pressure.pressure.signum();
    let on_face = BlastOnFace::new(blast, middle.into(), normal.into())?;
    Some(LoadedFace { blast: Some(on_face), ..face })
}

/// Returns the factor of a load at `time`.
fn factor(curves: &[Curve], curve: Option<usize>, time: f64) -> f64 {
    curve.map_or(1.0, |c| curves[c].value(time))
}

/// Returns the forces of a pressure on the corners `x` of a face [force]: exact integrals of `-p
/// N_i n` over the triangle or the bilinear quad. Their work is proportional to the swept volume,
/// and the forces on a closed surface sum to zero.
fn on_corners(pressure: f64, x: &[Row; 4], nodes: [u32; 4]) -> [Row; 4] {
    let [a, b, c, d] = x.map(|r| Vector3::new(r[0], r[1], r[2]));
    if nodes[2] == nodes[3] {
        let each = (b - a).cross(&(c - a)) * (-pressure / 6.0);
        let f = row(each.into());
        return [f, f, f, [0.0; 4]];
    }
    // x(xi, eta) has the tangents along_xi + eta twist and along_eta + xi twist.
    let (along_xi, along_eta) = ((b - a + c - d) * 0.25, (c - b + d - a) * 0.25);
    let twist = (a - b + c - d) * 0.25;
    let (mean, by_xi, by_eta) =
        (along_xi.cross(&along_eta), along_xi.cross(&twist), twist.cross(&along_eta));
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(xi, eta)| row(((mean + (by_xi * xi + by_eta * eta) / 3.0) * -pressure).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a bilinear quad the forces are the integral of -p N_i n, here by a fine midpoint rule
    /// (error below h^2). Over a flat quad each force is a quarter of p A.
    #[test]
    fn corner_forces_are_the_integral_of_the_pressure() {
        let flat = [
            [0.0, 0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0, 0.0],
            [2.0, 3.0, 0.0, 0.0],
            [0.0, 3.0, 0.0, 0.0],
        ];
        assert_eq!(on_corners(0.5, &flat, [0, 1, 2, 3]), [[0.0, 0.0, -0.75, 0.0]; 4]);
        let thirds = on_corners(0.5, &[flat[0], flat[1], flat[2], flat[2]], [0, 1, 2, 2]);
        assert_eq!(
            thirds,
            [[0.0, 0.0, -0.5, 0.0], [0.0, 0.0, -0.5, 0.0], [0.0, 0.0, -0.5, 0.0], [0.0; 4]]
        );

        let q = [
            [0.0, 0.0, 0.3, 0.0],
            [2.0, 0.1, -0.2, 0.0],
            [2.3, 1.9, 0.4, 0.0],
            [-0.2, 2.2, 0.0, 0.0],
        ];
        let exact = on_corners(1.0, &q, [0, 1, 2, 3]);
        let v = q.map(|r| Vector3::new(r[0], r[1], r[2]));
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let mut sum = [Vector3::zeros(); 4];
        let n = 200;
        for i in 0..n * n {
            let at = |k: i32| (f64::from(k) + 0.5) * 2.0 / f64::from(n) - 1.0;
            let (xi, eta) = (at(i / n), at(i % n));
            let tangent = |along: usize| -> Vector3<f64> {
                let slope = |(s, t): (f64, f64)| {
                    0.25 * if along == 0 { s * (1.0 + t * eta) } else { t * (1.0 + s * xi) }
                };
                signs.iter().zip(v).map(|(&st, p)| p * slope(st)).sum()
            };
            let area = tangent(0).cross(&tangent(1)) * (4.0 / f64::from(n * n));
            for (f, (s, t)) in sum.iter_mut().zip(signs) {
                *f -= area * (0.25 * (1.0 + s * xi) * (1.0 + t * eta));
            }
        }
        for (f, s) in exact.iter().zip(sum) {
            assert!((Vector3::new(f[0], f[1], f[2]) - s).norm() < 1e-4, "{f:?} {s}");
        }
    }
}
