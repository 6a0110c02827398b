//! One line for each case and the table of all rows, as Markdown, and all as JSON.

use super::row::{CheckRow, short};
use super::{Entry, Outcome};
use serde_json::{Value, json};
use std::fmt::Write;

/// Entries that were run, and their results.
pub struct Report<'a> {
    /// Selected entries.
    pub entries: &'a [&'a Entry],
    /// Outcomes of their checks, in order.
    pub outcomes: &'a [Outcome],
    /// True if slow checks were left out.
    pub quick: bool,
}

const HEAD: &str = "# Verification

Written by `crumple verify`: computed values compared with exact, published or computed references.
A line is one case. `bound` counts its quantities with a bound, `outside` those outside it. The last
columns name the quantity that uses most of its tolerance: the deviation over the allowed one, above
1 if it is outside. All quantities are in [the table of rows](VERIFICATION_ROWS.md).
";

/// Losses of a crash engineer by the known failures of these entries, the gravest first.
const LOSSES: [(&str, &[&str]); 8] = [
    (
        "Crush force and remaining deflection, on meshes of the usual size",
        &["B08", "B12", "B13", "B20"],
    ),
    ("Light parts between heavy ones", &["C15"]),
    ("Time and place at which sliding parts stop", &["A07", "C18"]),
    ("Impact times, contact areas and peaks with penalty laws", &["A01", "A10", "A11"]),
    ("Energy of many short contacts, friction of penalty laws in stick", &["A29"]),
    ("Distorted or twisted shells of Belytschko and Tsay", &["A21", "A30"]),
    ("Vibrations of coarse panels and beams", &["A15", "A16"]),
    ("Thick walls of few solids", &["C12"]),
];
/// The same of all other entries.
const OTHER_LOSS: &str = "Other";

const HEAD_OF_ROWS: &str = "# Verification: all rows

Written by `crumple verify`, in SI units. A row is one quantity of a run. Its variant names contact
law, element and mesh. Marks of the sources: [V] read in the cited source, [D] derived, [C] computed
with an independent program, [U] not verified. Rows without a tolerance are shown for orientation
only.

| case | quantity | variant | reference | ours | error | tolerance | source | |
|---|---|---|---|---|---|---|---|---|
";

impl Report<'_> {
    /// Returns one line for each case as Markdown, with known shortcomings and what is missing.
    pub fn markdown(&self) -> String {
        let mut text = String::from(HEAD);
        let rows = || self.outcomes.iter().filter_map(|o| o.rows.as_ref().ok()).flatten();
        let gated = rows().filter(|r| r.verdict() != "recorded").count();
        let failed = rows().filter(|r| !r.passes()).count();
        let broken = self.outcomes.iter().filter(|o| o.rows.is_err()).count();
        let run = self.entries.iter().filter(|e| self.outcomes(e).next().is_some()).count();
        let quick = if self.quick { " (quick checks only)" } else { "" };
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "\n{run} of {} entries run{quick}; {gated} quantities with a bound, \
             {failed} outside it; {broken} checks could not be run.\n",
            self.entries.len()
        );
        text.push_str("| case | subject | bound | outside | nearest to its bound | share |\n");
        text.push_str("|---|---|---|---|---|---|\n");
        self.entries.iter().for_each(|entry| text.push_str(&self.summary(entry)));
        let known = || rows().filter(|r| !r.known.is_empty());
        if known().next().is_some() {
            text.push_str("\n## Known shortcomings\n\n");
            // An explanation of rows of several entries is written once.
            let mut said: Vec<(&str, Vec<String>)> = Vec::new();
            for outcome in self.outcomes {
                for row in
                    outcome.rows.iter().flatten().filter(|r| !r.known.is_empty() && !r.passes())
                {
                    match said.iter_mut().find(|s| s.0 == row.known) {
                        Some((_, of)) if of.iter().any(|name| name.starts_with(outcome.id)) => {}
                        Some((_, of)) => of.push(outcome.id.into()),
                        None => {
                            said.push((row.known, vec![format!("{} {}", outcome.id, row.quantity)]))
                        }
                    }
                }
            }
            let others = (OTHER_LOSS, &[][..]);
            for (loss, _) in LOSSES.into_iter().chain([others]) {
                let own: Vec<_> = said.iter().filter(|s| loss_of(&s.1[0]) == loss).collect();
                if !own.is_empty() {
                    let _ = writeln!(text, "{loss}:\n");
                    for (why, of) in own {
                        let _ = writeln!(text, "- {}: {why}", of.join(", "));
                    }
                    text.push('\n');
                }
            }
        }
        let open: Vec<_> = self.entries.iter().filter(|e| !e.open.is_empty()).collect();
        if !open.is_empty() {
            let blank = if text.ends_with("\n\n") { "" } else { "\n" };
            text.push_str(blank);
            text.push_str(
                "## Not covered\n\n| case | | what is missing, and why |\n|---|---|---|\n",
            );
            for e in open {
                let _ = writeln!(text, "| {} | {} | {} |", e.id, e.title, e.open);
            }
        }
        text
    }

    /// Returns the line of a case.
    fn summary(&self, entry: &Entry) -> String {
        let rows = || self.outcomes(entry).filter_map(|o| o.rows.as_ref().ok()).flatten();
        let bound = rows().filter(|r| r.verdict() != "recorded").count();
        let outside = rows().filter(|r| !r.passes()).count();
        let shares = rows().filter_map(|r| Some((r.share().filter(|s| !s.is_nan())?, r)));
        let nearest = shares.max_by(|a, b| a.0.total_cmp(&b.0));
        let (name, share) = nearest.map_or((String::new(), String::new()), |(share, r)| {
            (format!("{}, {}", r.quantity.replace('|', "\\|"), r.variant), format!("{share:.2}"))
        });
        let broken: String = self
            .outcomes(entry)
            .filter_map(|o| Some(format!("; **{}: {}**", o.name, o.rows.as_ref().err()?)))
            .collect();
        format!(
            "| {} | {}{broken} | {bound} | {outside} | {name} | {share} |\n",
            entry.id, entry.title
        )
    }

    /// Returns the table of all rows as Markdown.
    pub fn rows(&self) -> String {
        let mut text = String::from(HEAD_OF_ROWS);
        for entry in self.entries {
            for outcome in self.outcomes(entry) {
                match &outcome.rows {
                    Ok(rows) => rows.iter().for_each(|r| text.push_str(&line(entry.id, r))),
                    Err(why) => {
                        let _ = writeln!(
                            text,
                            "| {} | {} | | | | | | {why} | **FAIL** |",
                            entry.id, outcome.name
                        );
                    }
                }
            }
        }
        text
    }

    /// Returns the table as JSON.
    pub fn json(&self) -> String {
        let entry = |e: &&Entry| {
            let checks: Vec<Value> = self.outcomes(e).map(check).collect();
            json!({ "id": e.id, "title": e.title, "checks": checks, "not_covered": e.open })
        };
        let entries: Vec<Value> = self.entries.iter().map(entry).collect();
        format!("{:#}\n", json!({ "quick": self.quick, "entries": entries }))
    }

    fn outcomes<'b>(&'b self, entry: &Entry) -> impl Iterator<Item = &'b Outcome> + use<'b> {
        let id = entry.id;
        self.outcomes.iter().filter(move |o| o.id == id)
    }
}

/// Returns what a failure costs, by the name of its entry at the start of its label.
fn loss_of(label: &str) -> &'static str {
    let of = LOSSES.iter().find(|(_, ids)| ids.iter().any(|id| label.starts_with(id)));
    of.map_or(OTHER_LOSS, |(loss, _)| loss)
}

fn line(id: &str, r: &CheckRow) -> String {
    let with_unit = |x: f64| match (x.is_nan(), r.unit) {
        (true, _) => "-".into(),
        (false, "") => short(x),
        (false, unit) => format!("{} {unit}", short(x)),
    };
    format!(
        "| {id} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        r.quantity.replace('|', "\\|"),
        r.variant,
        with_unit(r.reference),
        with_unit(r.ours),
        r.error_text(),
        r.tolerance_text(),
        r.source,
        r.verdict()
    )
}

fn check(o: &Outcome) -> Value {
    let row = |r: &CheckRow| {
        let mut value = json!(r);
        value["passes"] = json!(r.passes());
        value
    };
    match &o.rows {
        Ok(rows) => json!({ "name": o.name, "rows": rows.iter().map(row).collect::<Vec<_>>() }),
        Err(why) => json!({ "name": o.name, "error": why }),
    }
}
