//! Sensors, retractors and pretensioners of seat belts: their states in time.

use super::BeltMotions;
use super::curve::TensionCurve;
use crate::curve::Curve;
use crate::math::row::V3;
use crumple_proto::belt::{BeltSensor, Pretensioner, Retractor};
use serde::{Deserialize, Serialize};

/// State of a sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorState {
    /// Time at which it was triggered [time].
    pub since: Option<f64>,
    /// Time for which its limit has been exceeded [time].
    held: f64,
    /// Velocity of its node in the last step [length/time].
    before: Option<[f64; 3]>,
}

/// Times of a step that sensors need.
#[derive(Clone, Copy, Debug)]
pub struct SensorTimes {
    /// Present time [time].
    pub now: f64,
    /// Step to this time [time].
    pub step: f64,
    /// Time between the velocities of the last step and the present ones [time].
    pub mid: f64,
}

impl SensorState {
    /// Forgets the velocity before, so that the next step has no acceleration.
    pub fn forget_velocity(&mut self) {
        self.before = None;
    }

    /// Looks at the model. `rates` are those of the pull-out of retractors [length/time].
    pub fn update(
        &mut self,
        sensor: &BeltSensor,
        motions: &BeltMotions,
        rates: impl Fn(usize) -> f64,
        times: SensorTimes,
    ) {
        let (above, duration) = match sensor {
            BeltSensor::Time(time) => (times.now >= *time, 0.0),
            BeltSensor::Acceleration { node, direction, limit, duration } => {
                // A node whose part was deleted has no acceleration.
                let now = motions.get(node).map(|motion| motion.v);
                let before = std::mem::replace(&mut self.before, now.map(Into::into));
                let known = now.zip(before).filter(|_| times.mid > 0.0);
                let along = |(now, before): (V3, [f64; 3])| {
                    (now - V3::from(before)).dot(&V3::from(*direction)) / times.mid
                };
                (known.is_some_and(|both| along(both) > *limit), *duration)
            }
            BeltSensor::PullOutRate { retractor, limit, duration } => {
                (rates(*retractor) > *limit, *duration)
            }
            BeltSensor::Distance { nodes, limits } => {
                let ends = nodes.map(|node| motions.get(&node).map(|motion| motion.x));
                let distance = ends[0].zip(ends[1]).map(|(a, b)| (b - a).norm());
                (distance.is_some_and(|d| d < limits[0] || d > limits[1]), 0.0)
            }
        };
        self.held = if above { self.held + times.step } else { 0.0 };
        if above && self.since.is_none() && self.held >= duration {
            self.since = Some(times.now);
        }
    }
}

/// Returns true if the delay after the first of some sensors has passed.
fn is_due(sensors: &[usize], states: &[SensorState], delay: f64, now: f64) -> bool {
    sensors.iter().filter_map(|&s| states[s].since).any(|since| now >= since + delay)
}

/// State of a retractor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RetractorState {
    /// Belt that has come out [length].
    pub pull_out: f64,
    /// Its rate in the last step [length/time].
    pub rate: f64,
    /// Tension of the belt [force].
    pub tension: f64,
    /// Energy that it has taken up [energy].
    pub absorbed: f64,
    /// Pull-out when the delay after its sensor had passed [length].
    armed: Option<f64>,
    /// Pull-out at which its curve begins, once it is locked [length].
    origin: Option<f64>,
    /// Largest pull-out of its curve so far [length].
    largest: f64,
}

impl RetractorState {
    /// Returns true if it is locked.
    pub fn is_locked(&self) -> bool {
        self.origin.is_some()
    }

    /// Locks it if the time has come.
    pub fn update(
        &mut self,
        job: &Retractor,
        curve: &TensionCurve,
        sensors: &[SensorState],
        now: f64,
    ) {
        if self.armed.is_none() && is_due(&job.sensors, sensors, job.delay, now) {
            self.armed = Some(self.pull_out);
        }
        let out = self.armed.is_some_and(|armed| self.pull_out - armed >= job.pull_out);
        if out && !self.is_locked() {
            self.lock(curve);
        }
    }

    /// Locks it: its curve begins where it has the present tension.
    pub fn lock(&mut self, curve: &TensionCurve) {
        let way = curve.way_at(self.tension);
        self.origin = Some(self.pull_out - way);
        self.largest = way;
    }

    /// Returns its tension with more pulled out [force].
    pub fn holds(&self, curve: &TensionCurve, more: f64) -> f64 {
        match self.origin {
            Some(origin) => {
                let way = self.pull_out + more - origin;
                curve.at(way, self.largest).max(curve.first())
            }
            None => curve.first(),
        }
    }

    /// Moves the belt by a length.
    pub fn advance(&mut self, curve: &TensionCurve, moved: f64) {
        let tensions = [0.0, moved].map(|moved| self.holds(curve, moved));
        self.pull_out += moved;
        self.absorbed += 0.5 * (tensions[0] + tensions[1]) * moved;
        if let Some(origin) = self.origin {
            self.largest = self.largest.max(self.pull_out - origin);
        }
    }

    /// Returns true if it is a possible state.
    pub fn is_sound(&self) -> bool {
        let Self { pull_out, rate, tension, absorbed, armed, origin, largest } = self;
        let numbers = [pull_out, rate, tension, absorbed, largest];
        numbers.into_iter().chain(armed).chain(origin).all(|n| n.is_finite())
    }
}

/// State of a pretensioner.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PretensionerState {
    /// Time at which it has fired [time].
    fired: Option<f64>,
    /// True if it has come to the end of its curve.
    done: bool,
    /// True if its retractor has been locked after that.
    locked: bool,
}

impl PretensionerState {
    /// Fires it if the time has come. Returns the length that it wants to pull in during the step
    /// to the present time, while it works [length].
    pub fn update(
        &mut self,
        job: &Pretensioner,
        sensors: &[SensorState],
        (now, step): (f64, f64),
    ) -> Option<f64> {
        if self.fired.is_none() && is_due(&job.sensors, sensors, job.delay, now) {
            self.fired = Some(now);
        }
        let since = now - self.fired.filter(|_| !self.done)?;
        let curve = Curve::new(&job.pull_in);
        let end = job.pull_in.last().map_or(0.0, |p| p[0]);
        self.done = since >= end;
        Some(curve.value(since) - curve.value((since - step).max(0.0)))
    }

    /// Returns true once after the end of its curve: then its retractor locks.
    pub fn has_just_ended(&mut self) -> bool {
        self.done && !std::mem::replace(&mut self.locked, true)
    }
}
