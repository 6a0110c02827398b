//! `crumple advise`: warnings of a run, and features that it did not need, part by part, with the
//! settings that remove them.
//!
//! All advice follows from `summary.json` and holds for the run that wrote it: another load may
//! need features that this one did not. Times are shares of the CPU time of that run. Elements of
//! all parts are assumed to be equally expensive.

use crate::input::job::units::is_metal;
use crate::results::summary::{Cpu, MeanMax, PartSummary};
use crate::results::warnings::EngineeringWarning;
use petgraph::unionfind::UnionFind;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Number of points that integrate linear bending exactly: two Gauss points are exact up to cubic
/// polynomials.
const ELASTIC_POINTS: usize = 2;
/// Plastic strain below which a part is a candidate for a rigid body: that of the 0.2 % proof
/// stress.
const PROOF_STRAIN: f64 = 0.002;
/// Ratio of hourglass energy to internal energy below which modes without stiffness of their own
/// have no influence.
const NO_HOURGLASS: f64 = 0.001;
/// Cost of `stabilised_quad` over that of `belytschko_tsay` (`cases/bench/RESULTS.md`).
const STABILISED: f64 = 1.2;
/// Largest difference between neighbouring elements, as a fraction of the largest value of a
/// field, at which the mesh resolves the field.
const RESOLVED: f64 = 0.1;

/// The part of `summary.json` that is read.
#[derive(Debug, Deserialize)]
struct SummaryPart {
    status: String,
    parts: Vec<PartSummary>,
    phase_s: BTreeMap<String, MeanMax>,
    cpu_s: Cpu,
    warnings: Vec<EngineeringWarning>,
}

/// A piece of advice.
#[derive(Clone, Debug, PartialEq)]
struct Advice {
    /// Observation and conclusion.
    why: String,
    /// Upper bound of the time that the advice saves [s].
    at_most: f64,
    /// Lines for the job file.
    settings: Vec<String>,
    /// Parts whose elements would cost nothing any more. Other advice on these parts saves
    /// nothing in addition.
    parts: Vec<u32>,
}

/// Prints advice on the run in `dir` and returns the exit code.
pub fn run(dir: &Path) -> u8 {
    match read(dir) {
        Ok(summary) => {
            crate::stdout::write(format_args!("{}", describe(&summary)));
            0
        }
        Err(why) => {
            eprintln!("error: {why}");
            crate::input::job::Report::EXIT_CODE
        }
    }
}

fn read(dir: &Path) -> Result<SummaryPart, String> {
    let path = dir.join("summary.json");
    let shown = path.display();
    let text = std::fs::read_to_string(&path)
        .map_err(|e| format!("{shown}: {e}; name the folder of a run"))?;
    let read: Result<SummaryPart, _> = serde_json::from_str(&text);
    let summary = read.map_err(|e| {
        format!("{shown}: {e}; if an older version of Crumple made the run, repeat it")
    })?;
    match summary.status.as_str() {
        "completed" => Ok(summary),
        other => Err(format!("{shown}: the run has {other}; advice needs a completed run")),
    }
}

fn describe(s: &SummaryPart) -> String {
    let mut out = String::new();
    let mut advice = rigid(s);
    let bodies: Vec<u32> = advice.iter().flat_map(|a| a.parts.iter().copied()).collect();
    advice.extend(
        [points(s, &bodies), law(s, &bodies), form(s), contact(s), mesh(s)].into_iter().flatten(),
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "part                  elements  plastic strain  largest jump to a neighbour  \
         hourglass/internal  contact"
    );
    for p in &s.parts {
        let contact = match (p.contact_near, p.contact_pairs) {
            (_, Some(true)) => "touched",
            (Some(true), _) => "came near",
            (Some(false), _) => "never near",
            (None, _) => "none in the job",
        };
        let _ = writeln!(
            out,
            "{:<20}  {:>8}  {:>14.4}  {:>26.4}   {:>18.5}  {contact}",
            called(p),
            p.elements,
            p.plastic_strain_max,
            p.strain_jump,
            hourglass_share(p)
        );
    }
    for warning in &s.warnings {
        let _ = writeln!(out, "\n# Warning: {}", warning.line());
    }
    for a in &advice {
        let total = s.cpu_s.total;
        let share = if total > 0.0 { 100.0 * a.at_most / total } else { 0.0 };
        let saving = match a.at_most {
            0.0 => "No further saving".to_string(),
            s => format!("Saves at most {s:.3} s of CPU time, {share:.0} % of the run"),
        };
        let _ = writeln!(out, "\n# {}\n# {saving}. In the job:", a.why);
        for line in &a.settings {
            let _ = writeln!(out, "{line}");
        }
    }
    if advice.is_empty() {
        let _ = writeln!(out, "\nno advice: every part needs its settings");
    }
    let _ = writeln!(
        out,
        "\n# This advice is valid for this run only. Another load may need these settings."
    );
    out
}

fn called(p: &PartSummary) -> String {
    if p.name.is_empty() { p.id.to_string() } else { p.name.clone() }
}

/// Returns the CPU time of some phases [s]: their share of the wall time of all phases except
/// waiting for other workers.
fn seconds(s: &SummaryPart, phases: &[&str]) -> f64 {
    let of = |wanted: &dyn Fn(&str) -> bool| -> f64 {
        s.phase_s.iter().filter(|(name, _)| wanted(name)).map(|(_, p)| p.mean).sum()
    };
    let all = of(&|name| name != "halo");
    if all > 0.0 { s.cpu_s.total * of(&|name| phases.contains(&name)) / all } else { 0.0 }
}

/// Returns the line with a comment that names its place in the job file.
fn in_part(p: &PartSummary, line: &str) -> [String; 2] {
    let entry =
        if p.name.is_empty() { format!("id = {}", p.id) } else { format!("name = \"{}\"", p.name) };
    [format!("# in the [[part]] with {entry}:"), line.to_string()]
}

/// Finds groups of connected parts with little plastic strain. Each group could be one rigid
/// body.
fn rigid(s: &SummaryPart) -> Vec<Advice> {
    let stiff =
        |p: &&PartSummary| p.elements > 0 && !p.rigid && p.plastic_strain_max <= PROOF_STRAIN;
    let count = s.parts.iter().map(|p| p.pieces.len()).sum();
    let mut sets = UnionFind::<usize>::new(count);
    let pieces = || s.parts.iter().filter(stiff).flat_map(|p| &p.pieces);
    let among: Vec<usize> = pieces().map(|p| p.number).collect();
    for piece in pieces() {
        for &other in piece.joined.iter().filter(|&other| among.contains(other)) {
            sets.union(piece.number, other);
        }
    }
    // In the order of the parts.
    let mut groups: Vec<(usize, Vec<&PartSummary>)> = Vec::new();
    for p in s.parts.iter().filter(stiff) {
        let mut roots: Vec<usize> =
            p.pieces.iter().map(|piece| sets.find_mut(piece.number)).collect();
        roots.dedup();
        // A rigid body would weld a part whose pieces are not connected by stiff parts.
        if let [root] = roots[..] {
            match groups.iter_mut().find(|(of, _)| *of == root) {
                Some((_, group)) => group.push(p),
                None => groups.push((root, vec![p])),
            }
        }
    }
    // If no part yielded, the stresses of the model matter, and rigid bodies have none.
    if s.parts.iter().filter(|p| p.elements > 0).count()
        == groups.iter().map(|(_, group)| group.len()).sum::<usize>()
    {
        return Vec::new();
    }
    let advise = |group: Vec<&PartSummary>| {
        let ids: Vec<String> = group.iter().map(|p| p.id.to_string()).collect();
        let names: Vec<String> = group.iter().map(|p| called(p)).collect();
        let strain = group.iter().map(|p| p.plastic_strain_max).fold(0.0, f64::max);
        let why = format!(
            "{}: one connected piece with a plastic strain of at most {strain:.4} at the end. A \
             rigid body neither deforms nor carries waves: compare a run with it",
            names.join(", ")
        );
        let settings = vec![
            "[[rigid]]".to_string(),
            format!("name = \"{}\"", names.join(" and ")),
            format!("parts = [{}]", ids.join(", ")),
        ];
        let within = |p: &PartSummary| group.iter().any(|g| g.id == p.id);
        let parts = group.iter().map(|p| p.id).collect();
        Advice { why, at_most: seconds(s, &["elements"]) * share(s, within), settings, parts }
    };
    groups.into_iter().map(|(_, group)| advise(group)).collect()
}

/// Finds parts whose mesh is finer than needed for their fields.
fn mesh(s: &SummaryPart) -> Option<Advice> {
    let fine = |p: &PartSummary| {
        let resolved = |jump: f64, largest: f64| jump <= RESOLVED * largest;
        p.elements > 0
            && !p.rigid
            && resolved(p.stress_jump, p.von_mises_end)
            && resolved(p.strain_jump, p.plastic_strain_max)
    };
    let why = format!(
        "{}: at the end, stress and plastic strain of neighbouring elements differ by at most a \
         tenth of the largest in the part; elements of twice the length may suffice. Earlier \
         differences may have been larger",
        names(s, fine)
    );
    // At most a quarter of the shells is left.
    let at_most = 0.75
        * seconds(s, &["elements", "assemble", "constraints", "local", "energy", "advance"])
        * share(s, fine);
    s.parts.iter().any(fine).then(|| Advice {
        why,
        at_most,
        settings: vec!["# a coarser mesh of these parts".into()],
        parts: vec![],
    })
}

/// Returns the share of some parts in the number of elements.
fn share(s: &SummaryPart, of: impl Fn(&PartSummary) -> bool) -> f64 {
    let count = |f: &dyn Fn(&PartSummary) -> bool| {
        s.parts.iter().filter(|p| f(p)).map(|p| p.elements).sum::<u64>()
    };
    count(&of) as f64 / count(&|_| true).max(1) as f64
}

fn names(s: &SummaryPart, of: impl Fn(&PartSummary) -> bool) -> String {
    s.parts.iter().filter(|p| of(p)).map(called).collect::<Vec<_>>().join(", ")
}

/// Returns a remark on parts whose saving is already counted for a rigid body.
fn besides(s: &SummaryPart, bodies: &[u32], idle: impl Fn(&PartSummary) -> bool) -> String {
    let also = names(s, |p| idle(p) && bodies.contains(&p.id));
    if also.is_empty() {
        also
    } else {
        format!(". Not counted here, because a rigid body saves it too: {also}")
    }
}

/// Returns hourglass energy over internal energy, 0 if there is no internal energy.
fn hourglass_share(p: &PartSummary) -> f64 {
    if p.internal > 0.0 { p.hourglass / p.internal } else { 0.0 }
}

/// Finds parts of stabilised quads with little hourglass strain. The cheaper formulation gives
/// the same result for them.
fn form(s: &SummaryPart) -> Option<Advice> {
    let idle = |p: &PartSummary| {
        p.elements > 0
            && !p.rigid
            && p.element == "stabilised_quad"
            && p.internal > 0.0
            && hourglass_share(p) <= NO_HOURGLASS
    };
    let settings: Vec<String> = s
        .parts
        .iter()
        .filter(|p| idle(p))
        .flat_map(|p| in_part(p, "element = \"belytschko_tsay\""))
        .collect();
    let why = format!(
        "{}: hourglass energy is at most {NO_HOURGLASS} of internal energy, so the form of \
         stabilisation has no measurable effect",
        names(s, idle)
    );
    let at_most = (1.0 - 1.0 / STABILISED) * seconds(s, &["elements"]) * share(s, idle);
    (!settings.is_empty()).then(|| Advice { why, at_most, settings, parts: vec![] })
}

/// Finds parts without plastic strain and with more than two points. They bend linearly, so two
/// points integrate the same. Parts in `bodies` are candidates for rigid bodies.
fn points(s: &SummaryPart, bodies: &[u32]) -> Option<Advice> {
    let idle = |p: &PartSummary| {
        p.elements > 0 && !p.rigid && p.plastic_strain_max == 0.0 && p.points > ELASTIC_POINTS
    };
    let settings: Vec<String> = s
        .parts
        .iter()
        .filter(|p| idle(p))
        .flat_map(|p| in_part(p, &format!("points = {ELASTIC_POINTS}")))
        .collect();
    let why = format!(
        "{}: no plastic strain at the end, so stress is linear through the thickness and \
         {ELASTIC_POINTS} points give the same resultants{}",
        names(s, idle),
        besides(s, bodies, idle)
    );
    let counted = |p: &PartSummary| idle(p) && !bodies.contains(&p.id);
    // Membrane, shear, hourglass and assembly costs do not depend on the number of points.
    let at_most = seconds(s, &["elements"]) * share(s, counted);
    (!settings.is_empty()).then(|| Advice { why, at_most, settings, parts: vec![] })
}

/// Finds materials none of whose parts yielded. They need no plasticity, hardening or strain
/// rates.
fn law(s: &SummaryPart, bodies: &[u32]) -> Option<Advice> {
    let yielded =
        |name: &str| s.parts.iter().any(|p| p.material == name && p.plastic_strain_max > 0.0);
    let can_yield = |p: &PartSummary| is_metal(&p.law);
    let idle = |p: &PartSummary| p.elements > 0 && can_yield(p) && !yielded(&p.material);
    let mut materials: Vec<&str> =
        s.parts.iter().filter(|p| idle(p)).map(|p| p.material.as_str()).collect();
    materials.sort_unstable();
    materials.dedup();
    let line = |m: &&str| {
        let what = "# keep only its parameters density, youngs_modulus and poisson".to_string();
        [
            format!("# in the [[material]] with name = \"{m}\":"),
            "law = \"elastic\"".to_string(),
            what,
        ]
    };
    let settings: Vec<String> = materials.iter().flat_map(line).collect();
    let why = format!(
        "{}: no part of the material yielded, so hardening and strain rates had no effect",
        materials.join(", ")
    ) + &besides(s, bodies, idle);
    let at_most = seconds(s, &["elements"]) * share(s, |p| idle(p) && !bodies.contains(&p.id));
    (!settings.is_empty()).then(|| Advice { why, at_most, settings, parts: vec![] })
}

/// Finds parts that were never near another surface. They need no contact.
fn contact(s: &SummaryPart) -> Option<Advice> {
    if s.parts.iter().all(|p| p.contact_near.is_none()) {
        return None;
    }
    let far = |p: &PartSummary| p.contact_near == Some(false);
    if s.parts.iter().all(|p| p.contact_pairs == Some(false)) {
        let why = "no contact pair was ever active: [contact] had no effect".into();
        let at_most = seconds(s, &["search", "local", "contact"]);
        return Some(Advice {
            why,
            at_most,
            settings: vec!["# remove [contact]".into()],
            parts: vec![],
        });
    }
    if !s.parts.iter().any(far) {
        return None;
    }
    let rest: Vec<String> = s.parts.iter().filter(|p| !far(p)).map(|p| p.id.to_string()).collect();
    let why =
        format!("{}: never within contact reach of any part, including itself", names(s, far));
    let settings = vec!["# in [contact]:".into(), format!("parts = [{}]", rest.join(", "))];
    Some(Advice {
        why,
        at_most: seconds(s, &["search", "local"]) * share(s, far),
        settings,
        parts: vec![],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::connectivity::ConnectedPiece;
    use crate::results::warnings::WarningKind;

    fn part(id: u32, plastic_strain_max: f64, near: bool, pairs: bool) -> PartSummary {
        PartSummary {
            id,
            name: format!("p{id}"),
            law: "j2".into(),
            material: format!("m{id}"),
            points: 5,
            elements: 10,
            plastic_strain_max,
            strain_jump: 0.5 * plastic_strain_max,
            von_mises_end: 0.2,
            stress_jump: 0.1,
            contact_near: Some(near),
            contact_pairs: Some(pairs),
            ..PartSummary::default()
        }
    }

    #[test]
    fn the_warnings_of_the_run_are_shown_with_their_cure() {
        let warning = EngineeringWarning {
            kind: WarningKind::Hourglass,
            part: "p1".into(),
            cycle: 7,
            time: 0.5,
            value: 0.2,
            worst_time: 0.5,
            what: "too much".into(),
            place: String::new(),
            cure: "Change it".into(),
        };
        let mut s = summary(vec![part(1, 0.1, true, true)]);
        assert!(!describe(&s).contains("Warning"));
        s.warnings.push(warning);
        let shown = describe(&s);
        assert!(shown.contains("# Warning: at time 5.000000e-1 part p1: too much. Change it"));
    }

    fn summary(parts: Vec<PartSummary>) -> SummaryPart {
        let phases = [("elements", 4.0), ("search", 1.0), ("local", 1.0), ("contact", 2.0)];
        let phase_s =
            phases.map(|(name, s)| (name.to_string(), MeanMax { mean: s, max: s })).into();
        let cpu_s = Cpu { total: 8.0, ..Cpu::default() };
        let warnings = Vec::new();
        SummaryPart { status: "completed".into(), parts, phase_s, cpu_s, warnings }
    }

    #[test]
    fn only_what_was_idle_is_called_so() {
        let s = summary(vec![part(1, 0.1, true, true), part(2, 0.0, false, false)]);
        let advice = points(&s, &[]).unwrap();
        assert_eq!(
            (advice.at_most, &advice.settings[..]),
            (2.0, &["# in the [[part]] with name = \"p2\":".to_string(), "points = 2".into()][..])
        );
        assert!(law(&s, &[]).unwrap().why.starts_with("m2:"));
        let as_body = points(&s, &[2]).unwrap();
        assert_eq!(as_body.at_most, 0.0, "a rigid body saves it already");
        assert!(as_body.why.ends_with("saves it too: p2"));
        assert_eq!(contact(&s).unwrap().settings, ["# in [contact]:", "parts = [1]"]);
    }

    #[test]
    fn a_run_that_used_everything_gets_no_advice() {
        let s = summary(vec![part(1, 0.1, true, true), part(2, 0.2, true, false)]);
        assert!(points(&s, &[]).is_none() && law(&s, &[]).is_none() && contact(&s).is_none());
        assert!(describe(&s).contains("every part needs its settings"));
    }

    /// Parts 2 and 3 are connected, part 4 has two pieces of which part 2 holds only one, and
    /// part 1 yielded.
    #[test]
    fn what_hangs_together_without_yield_may_be_rigid() {
        let mut parts =
            vec![part(1, 0.1, true, true), part(2, 0.001, true, true), part(3, 0.0, true, true)];
        parts.push(part(4, 0.0, true, true));
        let piece = |number, joined: &[usize]| ConnectedPiece { number, joined: joined.to_vec() };
        parts[0].pieces = vec![piece(0, &[1, 4])];
        parts[1].pieces = vec![piece(1, &[0, 2, 3])];
        parts[2].pieces = vec![piece(2, &[1])];
        parts[3].pieces = vec![piece(3, &[1]), piece(4, &[0])];
        let advice = rigid(&summary(parts));
        assert_eq!(advice.len(), 1);
        assert_eq!(advice[0].settings, ["[[rigid]]", "name = \"p2 and p3\"", "parts = [2, 3]"]);
        assert_eq!(advice[0].at_most, 2.0, "half of the elements' four seconds");
    }

    #[test]
    fn a_mesh_is_too_fine_where_neighbours_hardly_differ() {
        let mut parts = vec![part(1, 0.1, true, true), part(2, 0.1, true, true)];
        (parts[0].strain_jump, parts[0].stress_jump) = (0.01, 0.01);
        assert!(mesh(&summary(parts)).unwrap().why.starts_with("p1:"));
    }

    #[test]
    fn a_stabilisation_that_did_nothing_can_go() {
        let mut parts = vec![part(1, 0.1, true, true), part(2, 0.1, true, true)];
        for (p, hourglass) in parts.iter_mut().zip([0.5e-3, 0.01]) {
            (p.element, p.internal, p.hourglass) = ("stabilised_quad".into(), 1.0, hourglass);
        }
        let advice = form(&summary(parts)).unwrap();
        assert_eq!(
            advice.settings,
            ["# in the [[part]] with name = \"p1\":", "element = \"belytschko_tsay\""]
        );
    }

    #[test]
    fn contact_without_pairs_can_go() {
        let s = summary(vec![part(1, 0.1, true, false), part(2, 0.2, false, false)]);
        assert_eq!(contact(&s).unwrap().at_most, 4.0);
    }
}
