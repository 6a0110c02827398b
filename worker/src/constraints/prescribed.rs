//! Prescribed motion: nodes that follow the job's curves, independent of all forces.
//!
//! Their records have the prescribed degrees of freedom as constrained, so that loads, contact
//! and walls use zero inverse mass there. Velocities are those that move a node to its position
//! at the end of the step. This position follows from its initial position and the exact
//! integral of the curve, so that no error accumulates.

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
}

stateless!(Prescribed { motions });

/// Displacement or rotation of a motion as a function of time.
#[derive(Debug)]
pub struct MotionCurve {
    /// Prescribed quantity.
    pub form: MotionForm,
    amount: V3,
    curve: Curve,
}

impl MotionCurve {
    /// Builds it from a motion; `curves` are those of the job.
    pub fn new(job: &PrescribedMotion, curves: &[Vec<[f64; 2]>]) -> Self {
        let curve = job.curve.map_or_else(Curve::one, |c| Curve::new(&curves[c]));
        Self { form: job.form, amount: V3::from(job.amount), curve }
    }

    /// Returns the displacement [length] or the rotation vector [rad] from time 0 to `time`.
    pub fn amount(&self, time: f64) -> V3 {
        let factor = match self.form {
            MotionForm::Displacement => self.curve.value(time),
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
}

impl Prescribed {
    /// Builds all motions of the job; none has nodes before [`Prescribed::bind_local`].
    pub fn new(job: &ResolvedLoads) -> Self {
        let course = |m: &PrescribedMotion| MotionCurve::new(m, &job.curves);
        let motion = |m: &PrescribedMotion| LocalMotion {
            job: m.clone(),
            course: course(m),
            nodes: Vec::new(),
        };
        Self { motions: job.motions.iter().map(motion).collect() }
    }

    /// Finds the nodes that are present here.
    pub fn bind_local(&mut self, nodes: &Nodes) {
        for m in &mut self.motions {
            m.nodes = m.job.nodes.iter().filter_map(|&id| nodes.local_index(id)).collect();
        }
    }

    /// Sets the velocities with which local nodes reach their positions at the end of the step.
    pub fn apply(&self, nodes: &mut Nodes, time: f64, dt: f64) {
        for m in &self.motions {
            let (now, next) = (m.course.amount(time), m.course.amount(time + dt));
            let turns = match m.job.form {
                MotionForm::Spin { centre } => Some((V3::from(centre), Rotation3::new(next))),
                _ => None,
            };
            let spin = if turns.is_some() { (next - now) / dt } else { V3::zeros() };
            for &n in &m.nodes {
                let i = n as usize;
                let start = V3::from(xyz(&nodes.x0[i]));
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
        steps: StepSizes,
        sum: &mut WorkSum,
    ) {
        for m in &self.motions {
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
            p.add_work(&nodes, (None, &Ties::default()), sizes, &mut work);
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
        let (nodes, _) =
            moved(MotionForm::Spin { centre }, (axis * rate).into(), &[[0.0, 1.0]], 95);
        let off = (0..3).map(|c| (nodes.x[0][c] - nodes.x0[0][c]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "round-off: 63 radians times eps times a radius of 3: {off}");
        assert!((V3::from(xyz(&nodes.w[0])) - axis * rate).norm() < 1e-12);
    }
}
