//! `crumple advise`: what a run did not need, part by part, and the settings that leave it out.
//!
//! Everything here follows from `summary.json`, and holds for the run that wrote it: another load may need what this
//! one did not. Times saved are shares of the phases of that run, elements of all parts taken as equally dear.

use crate::summary::{MeanMax, PartSummary};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Points that integrate linear bending exactly: two Gauss points are exact up to cubic polynomials.
const ELASTIC_POINTS: usize = 2;

/// What is read of `summary.json`.
#[derive(Debug, Deserialize)]
struct Summary {
    status: String,
    parts: Vec<PartSummary>,
    phase_s: BTreeMap<String, MeanMax>,
}

/// A suggestion.
#[derive(Clone, Debug, PartialEq)]
struct Advice {
    /// What was seen, and what follows from it.
    why: String,
    /// Seconds of the run that it concerns; what is saved is at most that.
    at_most: f64,
    /// Lines to paste.
    settings: Vec<String>,
}

/// Prints advice on the run in `dir`; gives the exit code.
pub fn run(dir: &Path) -> u8 {
    match read(dir) {
        Ok(summary) => {
            crate::say::write(format_args!("{}", describe(&summary)));
            0
        }
        Err(why) => {
            eprintln!("error: {why}");
            crate::job::Report::EXIT_CODE
        }
    }
}

fn read(dir: &Path) -> Result<Summary, String> {
    let path = dir.join("summary.json");
    let shown = path.display();
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{shown}: {e}; name the folder of a run"))?;
    let read: Result<Summary, _> = serde_json::from_str(&text);
    let summary = read.map_err(|e| format!("{shown}: {e}; runs of older versions have to be run again"))?;
    match summary.status.as_str() {
        "completed" => Ok(summary),
        other => Err(format!("{shown}: the run was {other}; advice needs one that completed")),
    }
}

fn describe(s: &Summary) -> String {
    let mut out = String::new();
    let total: f64 = s.phase_s.values().map(|p| p.mean).sum();
    let advice: Vec<Advice> = [points(s), law(s), contact(s)].into_iter().flatten().collect();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "part                  elements  plastic strain  contact");
    for p in &s.parts {
        let contact = match (p.contact_near, p.contact_pairs) {
            (_, Some(true)) => "touched",
            (Some(true), _) => "came near",
            (Some(false), _) => "never near",
            (None, _) => "none in the job",
        };
        let _ = writeln!(out, "{:<20}  {:>8}  {:>14.4}  {contact}", called(p), p.elements, p.plastic_strain_max);
    }
    for a in &advice {
        let share = if total > 0.0 { 100.0 * a.at_most / total } else { 0.0 };
        let _ =
            writeln!(out, "\n{}\n  concerns {:.3} s, {share:.0} % of the run; saves at most that", a.why, a.at_most);
        for line in &a.settings {
            let _ = writeln!(out, "    {line}");
        }
    }
    if advice.is_empty() {
        let _ = writeln!(out, "\nevery part needed what it was given");
    }
    let _ = writeln!(out, "\nThis holds for this run only: another load may need what this one did not.");
    out
}

fn called(p: &PartSummary) -> String {
    if p.name.is_empty() { p.id.to_string() } else { p.name.clone() }
}

fn seconds(s: &Summary, phases: &[&str]) -> f64 {
    phases.iter().filter_map(|p| s.phase_s.get(*p)).map(|p| p.mean).sum()
}

/// Share of the elements that some parts have.
fn share(s: &Summary, of: impl Fn(&PartSummary) -> bool) -> f64 {
    let count = |f: &dyn Fn(&PartSummary) -> bool| s.parts.iter().filter(|p| f(p)).map(|p| p.elements).sum::<u64>();
    count(&of) as f64 / count(&|_| true).max(1) as f64
}

fn names(s: &Summary, of: impl Fn(&PartSummary) -> bool) -> String {
    s.parts.iter().filter(|p| of(p)).map(called).collect::<Vec<_>>().join(", ")
}

/// Parts that stayed elastic bend linearly: more points than two integrate the same.
fn points(s: &Summary) -> Option<Advice> {
    let idle = |p: &PartSummary| p.elements > 0 && p.plastic_strain_max == 0.0 && p.points > ELASTIC_POINTS;
    let settings: Vec<String> = s
        .parts
        .iter()
        .filter(|p| idle(p))
        .map(|p| format!("--set part.{}.points={ELASTIC_POINTS}", called(p)))
        .collect();
    let why = format!(
        "{}: no plastic strain anywhere at the end, so stress is linear through the thickness and {ELASTIC_POINTS} \
         points give the same resultants",
        names(s, idle)
    );
    // Membrane, shear, hourglass and gathering remain, whatever the points.
    (!settings.is_empty()).then(|| Advice { why, at_most: seconds(s, &["elements"]) * share(s, idle), settings })
}

/// Materials none of whose parts yielded need no plasticity, no hardening and no rates.
fn law(s: &Summary) -> Option<Advice> {
    let yielded = |name: &str| s.parts.iter().any(|p| p.material == name && p.plastic_strain_max > 0.0);
    let idle = |p: &PartSummary| p.elements > 0 && p.law != "elastic" && !yielded(&p.material);
    let mut materials: Vec<&str> = s.parts.iter().filter(|p| idle(p)).map(|p| p.material.as_str()).collect();
    materials.sort_unstable();
    materials.dedup();
    let line = |m: &&str| format!("[[material]] \"{m}\": law = \"elastic\", without hardening and rates");
    let settings: Vec<String> = materials.iter().map(line).collect();
    let why =
        format!("{}: no part of the material yielded, so neither hardening nor rates mattered", materials.join(", "));
    (!settings.is_empty()).then(|| Advice { why, at_most: seconds(s, &["elements"]) * share(s, idle), settings })
}

/// Parts that never came near to anything need no contact surface.
fn contact(s: &Summary) -> Option<Advice> {
    if s.parts.iter().all(|p| p.contact_near.is_none()) {
        return None;
    }
    let far = |p: &PartSummary| p.contact_near == Some(false);
    if s.parts.iter().all(|p| p.contact_pairs == Some(false)) {
        let why = "no contact pair was ever active: the job's [contact] had nothing to do".into();
        let at_most = seconds(s, &["search", "local", "contact"]);
        return Some(Advice { why, at_most, settings: vec!["leave out the table [contact]".into()] });
    }
    if !s.parts.iter().any(far) {
        return None;
    }
    let rest: Vec<String> = s.parts.iter().filter(|p| !far(p)).map(|p| p.id.to_string()).collect();
    let why = format!("{}: never within contact reach of anything, itself included", names(s, far));
    let settings = vec![format!("--set contact.parts=[{}]", rest.join(", "))];
    Some(Advice { why, at_most: seconds(s, &["search", "local"]) * share(s, far), settings })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(id: u32, plastic_strain_max: f64, near: bool, pairs: bool) -> PartSummary {
        PartSummary {
            id,
            name: format!("p{id}"),
            law: "j2".into(),
            material: format!("m{id}"),
            points: 5,
            elements: 10,
            plastic_strain_max,
            contact_near: Some(near),
            contact_pairs: Some(pairs),
            ..PartSummary::default()
        }
    }

    fn summary(parts: Vec<PartSummary>) -> Summary {
        let phases = [("elements", 4.0), ("search", 1.0), ("local", 1.0), ("contact", 2.0)];
        let phase_s = phases.map(|(name, s)| (name.to_string(), MeanMax { mean: s, max: s })).into();
        Summary { status: "completed".into(), parts, phase_s }
    }

    #[test]
    fn only_what_was_idle_is_called_so() {
        let s = summary(vec![part(1, 0.1, true, true), part(2, 0.0, false, false)]);
        let advice = points(&s).unwrap();
        assert_eq!((advice.at_most, &advice.settings[..]), (2.0, &["--set part.p2.points=2".to_string()][..]));
        assert!(law(&s).unwrap().why.starts_with("m2:"));
        assert_eq!(contact(&s).unwrap().settings, ["--set contact.parts=[1]"]);
    }

    #[test]
    fn a_run_that_used_everything_gets_no_advice() {
        let s = summary(vec![part(1, 0.1, true, true), part(2, 0.2, true, false)]);
        assert!(points(&s).is_none() && law(&s).is_none() && contact(&s).is_none());
        assert!(describe(&s).contains("every part needed what it was given"));
    }

    #[test]
    fn contact_without_pairs_can_go() {
        let s = summary(vec![part(1, 0.1, true, false), part(2, 0.2, false, false)]);
        assert_eq!(contact(&s).unwrap().at_most, 4.0);
    }
}
