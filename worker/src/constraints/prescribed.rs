//! Prescribed motion: nodes that follow the job's curves, independent of all forces.
//!
//! Their records have the prescribed degrees of freedom as constrained, so that loads, contact
//! and walls use zero inverse mass there. Velocities are those that move a node to its position
//! at the end of the step. This position follows from its initial position and the exact
//! integral of the curve, so that no error accumulates. A motion that begins or ends within the run
//! moves its nodes by the increments of this integral, from where they are, and frees their degrees
//! of freedom outside of its window.

use crate::constraints::ties::Ties;
use crate::contact::Contact;
use crate::curve::Curve;
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use crate::stateless;
use crate::time::StepSizes;
use crate::work::{Work, WorkSum};
use crumple_proto::loads::{MotionForm, PrescribedMotion, ResolvedLoads};
use nalgebra::Rotation3;

/// All prescribed motions, by local indices.
#[derive(Debug, Default)]
pub struct Prescribed {
    motions: Vec<LocalMotion>,
    /// Motions with a window that act now, by number; `None` before the first step with a new
    /// local mesh.
    acting: Option<Vec<usize>>,
}

stateless!(Prescribed { motions, acting });

/// Displacement or rotation of a motion as a function of time.
#[derive(Debug)]
pub struct MotionCurve {
    /// Prescribed quantity.
    pub form: MotionForm,
    amount: V3,
    curve: Curve,
    /// Times of its begin and end, if it does not act in the whole run.
    window: Option<[f64; 2]>,
}

impl MotionCurve {
    /// Builds it from a motion; `curves` are those of the job.
    pub fn new(job: &PrescribedMotion, curves: &[Vec<[f64; 2]>]) -> Self {
        let curve = job.curve.map_or_else(Curve::one, |c| Curve::new(&curves[c]));
        Self { form: job.form, amount: V3::from(job.amount), curve, window: job.window }
    }

    /// Returns true if the motion does not act in the whole run.
    pub fn is_timed(&self) -> bool {
        self.window.is_some()
    }

    /// Returns true if the motion acts in a step that starts at `time`.
    pub fn acts_at(&self, time: f64) -> bool {
        self.window.is_none_or(|[begin, end]| begin <= time && time < end)
    }

    /// Returns the displacement or rotation in a step. An acceleration starts at rest at the begin
    /// of its window.
    pub fn increment(&self, time: f64, dt: f64) -> V3 {
        let change = self.amount(time + dt) - self.amount(time);
        match (self.form, self.window) {
            (MotionForm::Acceleration, Some([begin, _])) => {
                change - self.amount * (self.curve.integral(begin) * dt)
            }
            _ => change,
        }
    }

    /// Returns the displacement [length] or the rotation vector [rad] from time 0 to `time`.
    pub fn amount(&self, time: f64) -> V3 {
        let factor = match self.form {
            MotionForm::Displacement | MotionForm::Rotation { .. } => self.curve.value(time),
            MotionForm::Velocity | MotionForm::Spin { .. } => self.curve.integral(time),
            MotionForm::Acceleration => self.curve.second_integral(time),
        };
        self.amount * factor
    }
}

#[derive(Debug)]
struct LocalMotion {
    job: PrescribedMotion,
    course: MotionCurve,
    nodes: Vec<u32>,
    /// Its ghosts, if it has a window.
    copies: Vec<u32>,
}

impl Prescribed {
    /// Builds all motions of the job; none has nodes before [`Prescribed::bind_local`].
    pub fn new(job: &ResolvedLoads) -> Self {
        let course = |m: &PrescribedMotion| MotionCurve::new(m, &job.curves);
        let motion = |m: &PrescribedMotion| LocalMotion {
            job: m.clone(),
            course: course(m),
            nodes: Vec::new(),
            copies: Vec::new(),
        };
        Self { motions: job.motions.iter().map(motion).collect(), acting: None }
    }

    /// Finds the nodes that are present here.
    pub fn bind_local(&mut self, nodes: &Nodes) {
        for m in &mut self.motions {
            m.nodes = m.job.nodes.iter().filter_map(|&id| nodes.local_index(id)).collect();
            m.copies.clear();
            if m.course.is_timed() {
                let here = m.job.nodes.iter().filter_map(|&id| nodes.index_of(id));
                m.copies.extend(here.filter(|&n| n as usize >= nodes.local_count));
            }
        }
        self.acting = None;
    }

    /// Constrains the degrees of freedom of motions that begin, and frees those of motions that
    /// have ended.
    pub fn begin_step(&mut self, nodes: &mut Nodes, time: f64) {
        let timed = || self.motions.iter().enumerate().filter(|(_, m)| m.course.is_timed());
        let now: Vec<usize> =
            timed().filter(|(_, m)| m.course.acts_at(time)).map(|m| m.0).collect();
        if self.acting.as_ref() == Some(&now) {
            return;
        }
        let bind = |nodes: &mut Nodes, m: &LocalMotion, acts: bool| {
            let dofs = m.job.dofs as u8;
            for &n in m.nodes.iter().chain(&m.copies) {
                let fixed = &mut nodes.fixed[n as usize];
                *fixed = if acts { *fixed | dofs } else { *fixed & !dofs };
                nodes.invert_mass(n as usize);
            }
        };
        // A node may have another motion in the same direction at another time.
        timed().filter(|(k, _)| !now.contains(k)).for_each(|(_, m)| bind(nodes, m, false));
        now.iter().for_each(|&k| bind(nodes, &self.motions[k], true));
        self.acting = Some(now);
    }

    /// Sets the velocities with which local nodes reach their positions at the end of the step.
    pub fn apply(&self, nodes: &mut Nodes, time: f64, dt: f64) {
        for m in self.motions.iter().filter(|m| m.course.acts_at(time)) {
            let timed = m.course.is_timed();
            let increment = m.course.increment(time, dt);
            let next = if timed { increment } else { m.course.amount(time + dt) };
            let turns = m.job.form.centre().map(|centre| (V3::from(centre), Rotation3::new(next)));
            let spin = if turns.is_some() { increment / dt } else { V3::zeros() };
            for &n in &m.nodes {
                let i = n as usize;
                let start = V3::from(xyz(if timed { &nodes.x[i] } else { &nodes.x0[i] }));
                let place = match &turns {
                    Some((centre, rotation)) => centre + rotation * (start - centre),
                    None => start + next,
                };
                for c in 0..3 {
                    if m.job.dofs >> c & 1 == 1 {
                        nodes.v_next[i][c] = (place[c] - nodes.x[i][c]) / dt;
                    }
                    if nodes.rotations && m.job.dofs >> (c + 3) & 1 == 1 {
                        nodes.w_next[i][c] = spin[c];
                    }
                }
            }
        }
    }

    /// Adds the work of the constraint on owned nodes in the step to `sum`. The constraint
    /// exerts the forces that the prescribed velocities need in addition to all others, contact
    /// included.
    pub fn add_work(
        &self,
        nodes: &Nodes,
        (contact, ties): (Option<&Contact>, &Ties),
        (time, steps): (f64, StepSizes),
        sum: &mut WorkSum,
    ) {
        for m in self.motions.iter().filter(|m| m.course.acts_at(time)) {
            for &n in m.nodes.iter().filter(|&&n| nodes.is_owned(n as usize)) {
                let i = n as usize;
                let turned = contact.map_or(V3::zeros(), |k| k.couple_on(n));
                let pushed = contact.map_or(V3::zeros(), |k| {
                    k.force_on(n) + ties.contact_force_on_master(n, nodes)
                });
                for c in 0..3 {
                    if m.job.dofs >> c & 1 == 1 {
                        let (a, b) = (nodes.v[i][c], nodes.v_next[i][c]);
                        let impulse = nodes.mass[i] * (b - a)
                            - steps.dt_velocity * (nodes.force[i][c] + pushed[c]);
                        sum.add(Work::from_impulse(impulse, a, b));
                    }
                    if nodes.rotations && m.job.dofs >> (c + 3) & 1 == 1 {
                        let (a, b) = (nodes.w[i][c], nodes.w_next[i][c]);
                        let impulse = nodes.inertia[i] * (b - a)
                            - steps.dt_velocity * (nodes.moment[i][c] + turned[c]);
                        sum.add(Work::from_impulse(impulse, a, b));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::NodeId;
    use crumple_proto::partition::NodeRecord;

    fn moved(form: MotionForm, amount: [f64; 3], curve: &[[f64; 2]], steps: usize) -> (Nodes, f64) {
        let record = NodeRecord {
            id: NodeId(3),
            fixed: 63,
            x0: [3.0, 1.0, 0.5],
            x: [3.0, 1.0, 0.5],
            mass: 2.0,
            inertia: 0.4,
            ..NodeRecord::default()
        };
        let mut nodes = Nodes::new(&[record], 0, true);
        let motion = PrescribedMotion {
            nodes: vec![NodeId(3), NodeId(9)],
            dofs: 63,
            form,
            amount,
            curve: Some(0),
            window: None,
        };
        let mut p = Prescribed::new(&ResolvedLoads {
            curves: vec![curve.to_vec()],
            motions: vec![motion],
            ..ResolvedLoads::default()
        });
        p.bind_local(&nodes);
        let dt = 2.0 / steps as f64;
        let mut work = WorkSum::default();
        let sizes = StepSizes { dt, dt_velocity: dt, dt_damped: dt, dt_stable: dt };
        for i in 0..steps {
            nodes.accelerate(dt);
            p.apply(&mut nodes, i as f64 * dt, dt);
            let time = i as f64 * dt;
            p.add_work(&nodes, (None, &Ties::default()), (time, sizes), &mut work);
            nodes.advance(dt);
        }
        (nodes, work.total())
    }

    /// Each form of motion ends at its integral, to round-off. The work equals the kinetic
    /// energy at the last mid-step, because no other force acts.
    #[test]
    fn nodes_go_where_they_have_to_and_the_work_is_their_kinetic_energy() {
        let ramp = [[0.0, 0.0], [2.0, 1.0]];
        for (form, distance) in [
            (MotionForm::Displacement, 1.0),
            (MotionForm::Velocity, 1.0),
            (MotionForm::Acceleration, 2.0 / 3.0),
        ] {
            let (nodes, work) = moved(form, [0.0, -4.0, 2.0], &ramp, 50);
            let x = nodes.x[0];
            assert!(
                (x[0] - 3.0).abs()
                    + (x[1] - 1.0 + 4.0 * distance).abs()
                    + (x[2] - 0.5 - 2.0 * distance).abs()
                    < 1e-14
            );
            let v = nodes.v[0];
            let kinetic = v[1] * v[1] + v[2] * v[2];
            assert!(
                (work - kinetic).abs() < 1e-13 * kinetic,
                "round-off of 50 sums: {work} {kinetic}"
            );
        }
    }

    /// Ten revolutions about an inclined axis in 95 steps end at the start, to round-off of the
    /// angle.
    #[test]
    fn rotation_is_exact() {
        let centre = [1.0, -1.0, 0.0];
        let rate = 10.0 * std::f64::consts::TAU / 2.0;
        let axis = V3::new(1.0, 2.0, -2.0) / 3.0;
        for (form, curve) in [
            (MotionForm::Spin { centre }, &[[0.0, 1.0]][..]),
            (MotionForm::Rotation { centre }, &[[0.0, 0.0], [2.0, 2.0]]),
        ] {
            let (nodes, _) = moved(form, (axis * rate).into(), curve, 95);
            let off = (0..3).map(|c| (nodes.x[0][c] - nodes.x0[0][c]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-13, "round-off: 63 radians times eps times a radius of 3: {off}");
            assert!((V3::from(xyz(&nodes.w[0])) - axis * rate).norm() < 1e-11, "{form:?}");
        }
    }
}
