//! Joints of a job: checks, and conversion to indices and directions.

use super::validate::{JobProblems, nearest};
use super::walls::unit;
use crumple_proto::job::{Job, JointInput, JointKind, JointResistance};
use crumple_proto::joint::{Resistance, ResolvedJoint};
use crumple_proto::problem::Problem;
use crumple_worker::piecewise_linear::PiecewiseLinear;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Largest cosine of the angle between the axes of a universal joint: they are perpendicular but
/// for the precision of coordinates in a deck.
const SQUARE: f64 = 1e-3;
/// Stops from which on there is none.
const FAR: f64 = 1e19;

/// Checks the joints of a job and resolves them. `job.rigid` and the resolved bodies have the same
/// order.
pub fn resolve(job: &Job, findings: &mut JobProblems) -> Vec<ResolvedJoint> {
    let each = job.joint.iter().enumerate();
    each.filter_map(|(i, joint)| JointCheck { i, joint, findings }.resolve(job)).collect()
}

/// A joint under examination.
struct JointCheck<'a> {
    i: usize,
    joint: &'a JointInput,
    findings: &'a mut JobProblems,
}

impl JointCheck<'_> {
    fn fault(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let path = if key.is_empty() {
            format!("joint.{}", self.i)
        } else {
            format!("joint.{}.{key}", self.i)
        };
        let message = format!("joint `{}`: {}", self.joint.name, message.into());
        self.findings.add(Problem::error(path, message, help));
    }

    fn resolve(&mut self, job: &Job) -> Option<ResolvedJoint> {
        let joint = self.joint;
        if joint.name.is_empty() {
            self.fault("name", "it has no name", "give it a name");
        } else if job.joint[..self.i].iter().any(|other| other.name == joint.name) {
            self.fault("name", "two joints have this name", "give each its own name");
        }
        let bodies = self.bodies(job);
        let axes = self.axes();
        let lead = self.lead();
        let turns =
            matches!(joint.kind, JointKind::Revolute | JointKind::Cylindrical | JointKind::Screw);
        let slides = matches!(joint.kind, JointKind::Cylindrical | JointKind::Translational);
        let rotation = self.resistance("rotation", joint.rotation.as_ref(), turns);
        let sliding = self.resistance("sliding", joint.sliding.as_ref(), slides);
        let (first, second) = bodies?;
        let axes = axes?;
        let point = joint.point;
        let kind = joint.kind;
        Some(ResolvedJoint { kind, first, second, point, axes, lead: lead?, rotation, sliding })
    }

    /// Returns the indices of the bodies; the ground is the first one.
    fn bodies(&mut self, job: &Job) -> Option<(Option<usize>, usize)> {
        let names: Vec<&str> = job.rigid.iter().map(|body| body.name.as_str()).collect();
        let mut found = Vec::new();
        for (k, name) in self.joint.bodies.iter().enumerate() {
            match names.iter().position(|known| known == name) {
                Some(body) => found.push(body),
                None => self.fault(
                    &format!("bodies.{k}"),
                    format!("there is no rigid body `{name}`"),
                    nearest(name, &names),
                ),
            }
        }
        let count = self.joint.bodies.len();
        if !(1..=2).contains(&count) {
            let help = "name two rigid bodies, or one for a joint with the ground";
            self.fault("bodies", format!("it names {count} bodies"), help);
            return None;
        }
        match found[..] {
            [body] if count == 1 => Some((None, body)),
            [first, second] if first == second => {
                self.fault("bodies", "both ends are the same body", "name two rigid bodies");
                None
            }
            [first, second] => Some((Some(first), second)),
            _ => None,
        }
    }

    /// Returns the axis, the second axis and their normal.
    fn axes(&mut self) -> Option<[[f64; 3]; 3]> {
        let joint = self.joint;
        let without = matches!(joint.kind, JointKind::Spherical | JointKind::Fixed);
        if without && joint.axis.is_some() {
            self.fault("axis", "joints of this kind have no axis", "remove `axis`");
        }
        let axis = match joint.axis {
            _ if without => Vector3::x(),
            None => {
                self.fault("", "it has no axis", "give `axis`, such as [0, 0, 1]");
                return None;
            }
            Some(axis) => self.unit("axis", axis)?,
        };
        let mut second = None;
        match (joint.kind, joint.second_axis) {
            (JointKind::Universal, None) => {
                let help =
                    "give `second_axis`, the axis of the second body, perpendicular to `axis`";
                self.fault("", "a universal joint has no second axis", help);
                return None;
            }
            (JointKind::Universal, Some(given)) => {
                let given = self.unit("second_axis", given)?;
                if given.dot(&axis).abs() > SQUARE {
                    let help = "give a direction perpendicular to `axis`";
                    self.fault("second_axis", "its axes are not perpendicular", help);
                }
                second = (given - axis * axis.dot(&given)).try_normalize(0.0);
            }
            (_, Some(_)) => {
                self.fault("second_axis", "only universal joints have one", "remove it");
            }
            (_, None) => {}
        }
        // Any direction across the axis: away from the coordinate axis that is next to it.
        let across = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
        let second = second.unwrap_or(across);
        Some([axis.into(), second.into(), axis.cross(&second).into()])
    }

    fn unit(&mut self, key: &str, given: [f64; 3]) -> Option<Vector3<f64>> {
        let unit = unit(given).map(Vector3::from);
        if unit.is_none() {
            self.fault(key, "the direction is zero", "give a direction, such as [0, 0, 1]");
        }
        unit
    }

    /// Returns the distance per radian of a screw, 0 for other kinds.
    fn lead(&mut self) -> Option<f64> {
        match (self.joint.kind, self.joint.pitch) {
            (JointKind::Screw, Some(pitch)) if pitch != 0.0 => Some(pitch / TAU),
            (JointKind::Screw, _) => {
                let help = "give `pitch`, the distance of a full turn; a `revolute` joint has none";
                self.fault("pitch", "a screw has no pitch", help);
                None
            }
            (_, Some(_)) => {
                self.fault("pitch", "only screws have a pitch", "remove it, or take kind `screw`");
                None
            }
            (_, None) => Some(0.0),
        }
    }

    fn resistance(
        &mut self,
        key: &str,
        given: Option<&JointResistance>,
        is_free: bool,
    ) -> Option<Resistance> {
        let given = given?;
        if !is_free {
            let help = "remove it; `rotation` is for revolute, cylindrical and screw joints, \
                        `sliding` for cylindrical and translational ones";
            self.fault(key, format!("joints of this kind have no `{key}`"), help);
        }
        let values = [
            ("stiffness", given.stiffness),
            ("damping", given.damping),
            ("friction", given.friction),
        ];
        for (name, value) in values {
            if value.is_nan() || value < 0.0 {
                let path = format!("{key}.{name}");
                self.fault(&path, format!("`{name}` is {value:?}"), "it has to be 0 or above");
            }
        }
        let path = format!("{key}.table");
        if given.stiffness != 0.0 && !given.table.is_empty() {
            self.fault(&path, "it has both `stiffness` and `table`", "give one of them");
        }
        if let Some(fault) = PiecewiseLinear::fault(&given.table) {
            let help = "give at least two points with ascending first numbers";
            self.fault(&path, format!("`table` {fault}"), help);
        }
        if given.stops.is_some_and(|[low, high]| !(low <= 0.0 && high >= 0.0 && low < high)) {
            let help = "give the smallest and the largest value with 0, the start, between them";
            self.fault(&format!("{key}.stops"), "the start is not between its stops", help);
        }
        let table = match given.stiffness {
            0.0 => given.table.clone(),
            stiffness => vec![[0.0, 0.0], [1.0, stiffness]],
        };
        let far = |stop: f64| if stop.abs() < FAR { stop } else { f64::INFINITY.copysign(stop) };
        let stops = given.stops.map_or([f64::NEG_INFINITY, f64::INFINITY], |stops| stops.map(far));
        Some(Resistance { table, damping: given.damping, friction: given.friction, stops })
    }
}
