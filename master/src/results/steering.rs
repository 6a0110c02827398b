//! Orders of users in results: the list in `summary.json`, and the plan of `crumple run --steering`
//! that repeats them.

use crumple_proto::steering::{Planned, Steer, Steered};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// An order that has taken effect, in `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SteeringRecord {
    /// Cycles completed before it.
    pub cycle: u64,
    /// Simulated time [time].
    #[serde(default)]
    pub time: f64,
    /// `pause`, `continue`, `checkpoint`, `stop`, or a change as `key=value`.
    pub order: String,
}

impl From<&Steered> for SteeringRecord {
    fn from(at: &Steered) -> Self {
        Self { cycle: at.cycle, time: at.time, order: at.steer.to_string() }
    }
}

/// Reads the orders of a file: a `summary.json`, or a list of records. A pause changes no result,
/// and is left out.
///
/// # Errors
/// The file cannot be read, or an order is wrong.
pub fn read(path: &Path) -> Result<Vec<Planned>, String> {
    let named = |why: String| format!("{}: {why}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| named(error.to_string()))?;
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| named(error.to_string()))?;
    let list = match value {
        serde_json::Value::Object(mut summary) => summary.remove("steering").ok_or_else(|| {
            named("no key `steering`: give the summary.json of a run, or a list of orders".into())
        })?,
        list => list,
    };
    let records: Vec<SteeringRecord> = serde_json::from_value(list).map_err(|error| {
        named(format!("{error}; give a list such as [{{\"cycle\": 120, \"order\": \"stop\"}}]"))
    })?;
    let planned = |record: &SteeringRecord| {
        let steer: Steer = record.order.parse().map_err(named)?;
        Ok(Planned { cycle: record.cycle, steer })
    };
    let mut plan: Vec<Planned> = records.iter().map(planned).collect::<Result<_, String>>()?;
    plan.retain(|p| !matches!(p.steer, Steer::Pause | Steer::Continue));
    plan.sort_by_key(|p| p.cycle); // stable: orders of one cycle keep their order
    Ok(plan)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::steering::Change;

    #[test]
    fn a_plan_is_read_from_a_summary_or_a_list() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("plan.json");
        let of = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read(&path)
        };
        let list = r#"[{"cycle": 9, "order": "stop"}, {"cycle": 3, "time": 0.5, "order": "pause"},
            {"cycle": 3, "order": "end_time=2.5"}]"#;
        let plan = [
            Planned { cycle: 3, steer: Steer::Set(Change::EndTime(2.5)) },
            Planned { cycle: 9, steer: Steer::Stop },
        ];
        assert_eq!(of(list).unwrap(), plan);
        assert_eq!(of(&format!("{{\"steering\": {list}}}")).unwrap(), plan);
        for (text, said) in [
            ("{}", "`steering`"),
            ("[3]", "\"cycle\": 120"),
            ("[{\"cycle\": 1, \"order\": \"halt\"}]", "pause, continue"),
            ("x", "plan.json"),
        ] {
            let why = of(text).unwrap_err();
            assert!(why.contains(said), "{why}");
        }
    }
}
