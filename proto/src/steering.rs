//! Orders of a user to a run in progress: what they change, and where they took effect.
//!
//! As text, in `summary.json` and for `crumple run --steering`, an order is `pause`, `continue`,
//! `checkpoint`, `stop`, or a change as `key=value`.

use serde::{Deserialize, Serialize};
use std::fmt::{Display, Formatter};
use std::str::FromStr;

/// Largest number of field files.
pub const MOST_FIELDS: f64 = 100_000.0;
/// Relative round-off of times that are compared.
const SLACK: f64 = 1e-9;

/// Change of a setting. Values are those of the keys of a job.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// `end_time` [time].
    EndTime(f64),
    /// `output.field_interval` [time].
    FieldInterval(f64),
    /// `output.history_interval` [time].
    HistoryInterval(f64),
    /// `parallel.imbalance`.
    Imbalance(f64),
    /// `parallel.low_every_at_least` [cycles].
    LowEveryAtLeast(u64),
}

/// Keys that may change, in the order of [`Change`].
pub const KEYS: [&str; 5] = [
    "end_time",
    "output.field_interval",
    "output.history_interval",
    "parallel.imbalance",
    "parallel.low_every_at_least",
];

impl Change {
    /// Returns the change of a key.
    ///
    /// # Errors
    /// The key may not change, or the value is out of its range; the message says what may be
    /// given.
    pub fn new(key: &str, value: f64) -> Result<Self, String> {
        let above = |least: f64, what: &str, change: Self| match value.is_finite() && value > least
        {
            true => Ok(change),
            false => Err(format!("{key} = {value:?}: give a number {what}")),
        };
        match key {
            "end_time" => above(0.0, "above 0", Self::EndTime(value)),
            "output.field_interval" => {
                above(f64::MIN, "above 0, or a negative one for none", Self::FieldInterval(value))
                    .and_then(|change| match value == 0.0 {
                        true => Err(format!("{key} = 0: give an interval, or -1 for none")),
                        false => Ok(change),
                    })
            }
            "output.history_interval" => above(0.0, "above 0", Self::HistoryInterval(value)),
            "parallel.imbalance" => above(1.0, "above 1", Self::Imbalance(value)),
            "parallel.low_every_at_least" => match value >= 0.0 && value.fract() == 0.0 {
                true => above(-1.0, "of cycles", Self::LowEveryAtLeast(value as u64)),
                false => Err(format!("{key} = {value:?}: give a whole number of cycles")),
            },
            _ => Err(format!(
                "{key} cannot change while a run is in progress; these can: {}",
                KEYS.join(", ")
            )),
        }
    }

    /// Returns the key and the new value.
    pub fn key_and_value(self) -> (&'static str, f64) {
        match self {
            Self::EndTime(value) => (KEYS[0], value),
            Self::FieldInterval(value) => (KEYS[1], value),
            Self::HistoryInterval(value) => (KEYS[2], value),
            Self::Imbalance(value) => (KEYS[3], value),
            Self::LowEveryAtLeast(value) => (KEYS[4], value as f64),
        }
    }
}

/// An order of a user.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Steer {
    /// The workers hold their state and wait.
    Pause,
    /// A paused run goes on.
    Continue,
    /// A checkpoint. The master asks for it by an order of its own.
    Checkpoint,
    /// End of the run with complete output, and a checkpoint before it if the job has checkpoints.
    Stop,
    /// Change of a setting.
    Set(Change),
}

impl Steer {
    /// Returns the new value, if it changes a setting.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Set(change) => Some(change.key_and_value().1),
            Self::Pause | Self::Continue | Self::Checkpoint | Self::Stop => None,
        }
    }
}

impl Display for Steer {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Pause => f.write_str("pause"),
            Self::Continue => f.write_str("continue"),
            Self::Checkpoint => f.write_str("checkpoint"),
            Self::Stop => f.write_str("stop"),
            Self::Set(change) => {
                let (key, value) = change.key_and_value();
                write!(f, "{key}={value:?}")
            }
        }
    }
}

impl FromStr for Steer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "pause" => Ok(Self::Pause),
            "continue" => Ok(Self::Continue),
            "checkpoint" => Ok(Self::Checkpoint),
            "stop" => Ok(Self::Stop),
            _ => {
                let (key, value) = text.split_once('=').ok_or_else(|| {
                    format!(
                        "`{text}` is no order: give pause, continue, checkpoint, stop, or \
                         key=value with one of {}",
                        KEYS.join(", ")
                    )
                })?;
                let value = value.trim();
                let number = value.parse().map_err(|_| format!("`{value}` is no number"))?;
                Change::new(key.trim(), number).map(Self::Set)
            }
        }
    }
}

/// An order with the cycle in which it takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// Cycles completed before it. If no outer step begins there, it takes effect when the next
    /// one begins.
    pub cycle: u64,
    /// The order.
    pub steer: Steer,
}

/// An order that has taken effect, and the state of the clock there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Steered {
    /// The order.
    pub steer: Steer,
    /// Cycles completed.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// History rows written.
    pub rows: u64,
    /// Field outputs written.
    pub fields: u64,
}

/// Field outputs and history rows that a job asks for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OutputTimes {
    /// Time between field files [time], 0 or less for none.
    pub field_interval: f64,
    /// Additional times of field files [time].
    pub additional: Vec<f64>,
    /// Row from which rows have the present interval, and its time [time].
    pub rows_from: (u64, f64),
}

impl OutputTimes {
    /// Returns the times of field files up to the end of the run: start, end, multiples of the
    /// interval and the additional times; ascending, each once [time].
    pub fn fields_until(&self, end: f64) -> Vec<f64> {
        let interval = self.field_interval;
        let count = end / interval;
        let inside = |t: &f64| (0.0..=end).contains(t);
        let mut times: Vec<f64> = self.additional.iter().copied().filter(inside).collect();
        if interval > 0.0 && count <= MOST_FIELDS {
            let multiples = (0..=count.floor() as u64).map(|i| i as f64 * interval);
            times.extend(multiples.filter(|&t| t <= end));
            times.push(end);
        }
        times.sort_by(f64::total_cmp);
        times.dedup_by(|later, earlier| *later - *earlier <= SLACK * end);
        times
    }

    /// Returns the times of field files after a change: those of `times` that are written, and
    /// later ones [time].
    pub fn renewed(&self, times: &[f64], at: &Steered, end: f64) -> Vec<f64> {
        let written = times.iter().take(at.fields as usize).copied();
        let after = at.time * (1.0 + SLACK);
        written.chain(self.fields_until(end).into_iter().filter(|&t| t > after)).collect()
    }

    /// Lets rows have a new interval, at multiples of it.
    pub fn change_rows(&mut self, interval: f64, at: &Steered) {
        let next = (at.time / interval * (1.0 + SLACK)).floor() + 1.0;
        self.rows_from = (at.rows, next * interval);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_as_they_are_written() {
        let changes = [
            Change::EndTime(0.1 + 0.2),
            Change::FieldInterval(-1.0),
            Change::HistoryInterval(1e-300),
            Change::Imbalance(1.05),
            Change::LowEveryAtLeast(500),
        ];
        let plain = [Steer::Pause, Steer::Continue, Steer::Checkpoint, Steer::Stop];
        for steer in changes.map(Steer::Set).into_iter().chain(plain) {
            assert_eq!(steer.to_string().parse(), Ok(steer));
        }
        for (change, key) in changes.iter().zip(KEYS) {
            assert_eq!(change.key_and_value().0, key);
        }
    }

    #[test]
    fn wrong_orders_are_refused_with_what_is_allowed() {
        for (text, said) in [
            ("end_time=nan", "above 0"),
            ("end_time=-1", "above 0"),
            ("end_time=x", "no number"),
            ("output.field_interval=0", "-1 for none"),
            ("parallel.imbalance=1", "above 1"),
            ("parallel.low_every_at_least=2.5", "whole number"),
            ("time.end=3", "end_time, output.field_interval"),
            ("resume", "pause, continue"),
        ] {
            let why = text.parse::<Steer>().unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
    }

    #[test]
    fn later_fields_follow_the_new_interval_and_the_new_end() {
        let mut output = OutputTimes { field_interval: 0.5, ..OutputTimes::default() };
        let times = output.fields_until(1.0);
        assert_eq!(times, [0.0, 0.5, 1.0]);
        let steer = Steer::Pause;
        let at = Steered { steer, cycle: 7, time: 0.6, rows: 3, fields: 2 };
        assert_eq!(output.renewed(&times, &at, 1.5), [0.0, 0.5, 1.0, 1.5]);
        output.field_interval = 0.2;
        let fine = output.renewed(&times, &at, 1.0);
        assert_eq!(fine, [0.0, 0.5, 4.0 * 0.2, 1.0], "the multiple 0.6 is the present time");
        output.field_interval = -1.0;
        assert_eq!(output.renewed(&times, &at, 1.0), [0.0, 0.5]);
        output.change_rows(0.25, &at);
        assert_eq!(output.rows_from, (3, 0.75));
        output.change_rows(0.2, &at);
        assert!((output.rows_from.1 - 0.8).abs() < 1e-12, "{:?}", output.rows_from);
    }
}
