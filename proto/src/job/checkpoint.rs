//! Checkpoints that a job requests.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Checkpoints: complete states, from which `crumple run --resume` continues.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Checkpoint {
    /// Wall time between two checkpoints, such as `"30 s"`, `"10 min"` or `"2 h"`; `"off"` for
    /// none, also when the run is stopped. A signal USR1 requests one in any case.
    pub every: String,
    /// Simulated times after which a checkpoint is written [time].
    pub at: Vec<f64>,
    /// Number of checkpoints that are kept, at least 1. Older ones are removed.
    pub keep: usize,
    /// Longest wall time between two copies of the state in memory, as in `every`; `"off"` for
    /// none. The last copy is written if the run fails. Copies take at most a 200th of the time.
    pub in_memory: String,
    /// Wall time without progress of a file, as in `every`, after which a run that ends gives up
    /// its checkpoint. A run that waits for another of its files ends after ten times as long.
    pub patience: String,
    /// Compression of the files: `none` or `zstd`.
    pub compression: Compression,
}

impl Default for Checkpoint {
    fn default() -> Self {
        Self {
            every: "10 min".into(),
            at: Vec::new(),
            keep: 2,
            in_memory: "30 s".into(),
            patience: "60 s".into(),
            compression: Compression::default(),
        }
    }
}

/// Compression of the files of a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Compression {
    /// No compression.
    #[default]
    None,
    /// Zstandard, at its fastest level.
    Zstd,
}

/// Longest interval, so that a time can be computed from it.
const LONGEST: f64 = 1e9;

impl Checkpoint {
    /// Returns the interval between two checkpoints, `None` for none.
    ///
    /// # Errors
    /// The text is no interval; the message describes valid ones.
    pub fn interval(&self) -> Result<Option<Duration>, &'static str> {
        interval(&self.every)
    }

    /// Returns the longest interval between two copies in memory, `None` for none.
    ///
    /// # Errors
    /// As [`Self::interval`].
    pub fn copy_interval(&self) -> Result<Option<Duration>, &'static str> {
        interval(&self.in_memory)
    }

    /// Returns the time without progress of a file after which a run that ends gives it up.
    ///
    /// # Errors
    /// As [`Self::interval`]; the time must not be `off`.
    pub fn patience(&self) -> Result<Duration, &'static str> {
        interval(&self.patience)?.ok_or("write a number above 0 and a unit, such as \"60 s\"")
    }
}

/// Returns the wall time that a text describes, `None` for `off`.
fn interval(text: &str) -> Result<Option<Duration>, &'static str> {
    const WANTED: &str = "write a number above 0 and a unit, such as \"30 s\", \"10 min\" or \
                          \"2 h\", or \"off\"";
    let text = text.trim();
    if text == "off" {
        return Ok(None);
    }
    let split = text.find(|c: char| c.is_ascii_alphabetic()).ok_or(WANTED)?;
    let (number, unit) = text.split_at(split);
    let seconds = match unit {
        "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(WANTED),
    };
    let number: f64 = number.trim().parse().map_err(|_| WANTED)?;
    let seconds = number * seconds;
    if seconds > 0.0 && seconds <= LONGEST {
        Ok(Some(Duration::from_secs_f64(seconds)))
    } else {
        Err(WANTED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_have_a_number_and_a_unit() {
        let of = |text: &str| Checkpoint { every: text.into(), ..Checkpoint::default() }.interval();
        assert_eq!(of("10 min"), Ok(Some(Duration::from_secs(600))));
        assert_eq!(of("0.5s"), Ok(Some(Duration::from_millis(500))));
        assert_eq!(of("2 h"), Ok(Some(Duration::from_secs(7200))));
        assert_eq!(of("off"), Ok(None));
        for bad in ["", "10", "min", "-1 s", "0 s", "nan s", "1e300 h", "10 days", "1 s s"] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
