//! Checks of the requirements of a job, as far as they need no results.

use super::validate::JobProblems;
use crumple_proto::job::Job;
use crumple_proto::problem::Problem;

/// Reports requirements without a limit or with limits that exclude each other, quantities that
/// contradict themselves, and names that occur twice.
pub fn check(job: &Job, findings: &mut JobProblems) {
    for (index, one) in job.require.iter().enumerate() {
        let mut add = |key: &str, message: String, help: String| {
            findings.add(Problem::error(format!("require.{index}{key}"), message, help));
        };
        let name = &one.name;
        if name.is_empty() {
            add(".name", "a requirement has no name".into(), "name what it limits".into());
        }
        if job.require[..index].iter().any(|other| !name.is_empty() && other.name == *name) {
            let help = "give each requirement its own name".into();
            add(".name", format!("two requirements have the name `{name}`"), help);
        }
        for part in one.quantity.parts() {
            if !job.part.iter().any(|p| p.id == part) {
                let ids: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
                let help = format!("parts of the job: {}", ids.join(", "));
                add(".quantity", format!("requirement `{name}`: there is no part {part}"), help);
            }
        }
        match (one.below, one.above) {
            (None, None) => {
                let help = "add `below = ...`, `above = ...` or both".into();
                add("", format!("requirement `{name}` has no limit"), help);
            }
            (Some(below), Some(above)) if below < above => {
                let help = format!("no value is below {below} and above {above}: change one");
                add(".below", format!("no value meets requirement `{name}`"), help);
            }
            _ => {}
        }
        if let Some(time) = one.quantity.time_outside(job.end_time)
            && job.end_time > 0.0
        {
            let help = format!(
                "the run goes from 0 to end_time = {}, in the unit of time of the job",
                job.end_time
            );
            let message = format!("requirement `{name}`: no row has the time {time}");
            add(".quantity", message, help);
        }
        if let Some(why) = one.quantity.wrong() {
            add(".quantity", format!("requirement `{name}`: its quantity cannot be read"), why);
        }
    }
}
