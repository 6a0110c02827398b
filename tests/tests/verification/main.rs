//! The checks of the catalogue against the committed table `tests/verification.json`: the rows, the
//! verdict and the value of each. `deploy/verify.sh` also runs the slow checks. After a change of
//! results, examine the table that `crumple verify` writes, and commit it.

use crumple_verification::row::Tolerance;
use crumple_verification::{Bench, CATALOGUE, Check, CheckRow};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

/// Fraction of its tolerance by which a value may differ from the committed one. Results do not
/// depend on the width of the vectors, but other compilers and processors may round in another way.
/// A tenth lets no verdict creep away unnoticed.
const OF_TOLERANCE: f64 = 0.1;
/// The same as a fraction of the value, for tolerances that are close to rounding.
const OF_VALUE: f64 = 1e-6;

/// Committed value of a row, and true if it passes, by quantity and variant.
type Committed = BTreeMap<(String, String), (f64, bool)>;

fn table() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("verification.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn committed(table: &Value, id: &str, check: &str) -> Committed {
    let find = |list: &Value, key: &str, name: &str| {
        list.as_array().unwrap().iter().find(|e| e[key] == name).unwrap_or(&Value::Null).clone()
    };
    let checks = find(&table["entries"], "id", id)["checks"].clone();
    let rows = find(&checks, "name", check)["rows"].clone();
    let text = |v: &Value| v.as_str().unwrap().to_string();
    let number = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
    let row = |r: &Value| {
        let name = (text(&r["quantity"]), text(&r["variant"]));
        (name, (number(&r["ours"]), r["passes"].as_bool().unwrap()))
    };
    rows.as_array()
        .unwrap_or_else(|| panic!("{id} {check} is not in the table"))
        .iter()
        .map(row)
        .collect()
}

/// Returns the distance by which a value may differ from the committed one; none for rows without a
/// bound.
fn band(row: &CheckRow) -> Option<f64> {
    let tolerance = match row.tolerance {
        Tolerance::Relative(fraction) => fraction * row.reference.abs(),
        Tolerance::Absolute(distance) => distance,
        Tolerance::AtMost | Tolerance::AtLeast => row.reference.abs(),
        Tolerance::Recorded => return None,
    };
    Some((OF_TOLERANCE * tolerance).max(OF_VALUE * row.ours.abs()))
}

/// Returns why a row does not agree with the committed one, or `None` if it does.
fn difference(row: &CheckRow, then: Option<&(f64, bool)>) -> Option<String> {
    let name = format!("{} ({})", row.quantity, row.variant);
    let Some(&(value, passed)) = then else {
        return Some(format!("{name}: not in the table"));
    };
    if row.passes() != passed {
        return Some(format!("{name}: {} instead of {value}: another verdict", row.ours));
    }
    let band = band(row)?;
    let moved = match passed {
        true => (row.ours - value).abs(),
        // A known failure may become smaller.
        false => (row.ours - row.reference).abs() - (value - row.reference).abs(),
    };
    (moved.is_nan() || moved > band)
        .then(|| format!("{name}: {} instead of {value} +- {band:e}", row.ours))
}

/// Runs a check and returns its differences from the table.
fn differences(table: &Value, id: &str, check: &Check, bench: &Bench) -> Vec<String> {
    let rows = match (check.run)(bench) {
        Ok(rows) => rows,
        Err(why) => return vec![format!("{id} {}: {why}", check.name)],
    };
    let then = committed(table, id, check.name);
    let key = |r: &CheckRow| (r.quantity.clone(), r.variant.clone());
    let mut found: Vec<String> =
        rows.iter().filter_map(|r| difference(r, then.get(&key(r)))).collect();
    if rows.len() != then.len() {
        found.push(format!("{} rows instead of {}", rows.len(), then.len()));
    }
    let unexplained = rows.iter().filter(|r| !r.passes() && r.known.is_empty());
    found.extend(unexplained.map(|r| format!("{} ({}): no reason", r.quantity, r.variant)));
    found.into_iter().map(|text| format!("{id} {}: {text}", check.name)).collect()
}

fn quick(id: &str) {
    let entry = CATALOGUE.iter().find(|e| e.id == id).unwrap();
    let (table, bench) = (table(), Bench::new(None));
    let checks = entry.checks.iter().filter(|c| c.quick);
    let found: Vec<String> = checks.flat_map(|c| differences(&table, id, c, &bench)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

macro_rules! entries {
    ($($name:ident $id:literal)*) => {
        $(#[test] fn $name() { quick($id) })*
        const TESTED: &[&str] = &[$($id),*];
    };
}

entries! {
    a01 "A01" a03 "A03" a05 "A05" a06 "A06" a07 "A07" a13 "A13" a14 "A14" a15 "A15" a16 "A16"
    a17 "A17" a19 "A19" a21 "A21" a22 "A22" a23 "A23" a24 "A24" a26 "A26" a27 "A27" a30 "A30"
    a31 "A31" a32 "A32" a33 "A33" a34 "A34" a35 "A35" a36 "A36" a37 "A37" a38 "A38" a39 "A39"
    a40 "A40" a41 "A41" a42 "A42" b06 "B06" b08 "B08" c01 "C01" c02 "C02" c03 "C03" c04 "C04"
    c06 "C06" c07 "C07" c10 "C10" c11 "C11" c13 "C13" c14 "C14" c15 "C15" c16 "C16" c18 "C18"
    c20 "C20"
}

#[test]
fn every_entry_with_a_quick_check_is_tested() {
    let quick: Vec<&str> =
        CATALOGUE.iter().filter(|e| e.checks.iter().any(|c| c.quick)).map(|e| e.id).collect();
    assert_eq!(quick, TESTED);
}

#[test]
#[ignore = "takes minutes: deploy/verify.sh runs it"]
fn slow_checks_agree_with_the_table() {
    let (table, bench) = (table(), Bench::new(None));
    let slow = CATALOGUE.iter().flat_map(|e| e.checks.iter().map(|c| (e.id, c)));
    let left = Mutex::new(slow.filter(|(_, c)| !c.quick));
    let found = Mutex::new(Vec::new());
    let work = || {
        loop {
            let next = left.lock().unwrap().next();
            let Some((id, check)) = next else { return };
            found.lock().unwrap().extend(differences(&table, id, check, &bench));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..cores).for_each(|_| _ = scope.spawn(work)));
    let found = found.into_inner().unwrap();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_failure_of_the_table_has_a_reason_and_a_source() {
    let table = table();
    let mut seen = 0;
    for entry in table["entries"].as_array().unwrap() {
        for check in entry["checks"].as_array().unwrap() {
            let rows =
                check["rows"].as_array().unwrap_or_else(|| panic!("{} failed", check["name"]));
            for row in rows.iter().filter(|row| row["passes"] == false) {
                let name = format!("{} {}, {}", entry["id"], row["quantity"], row["variant"]);
                assert_ne!(row["known"], "", "{name}: no reason");
                assert_ne!(row["source"], "", "{name}: no source");
                seen += 1;
            }
        }
    }
    assert!(seen > 0, "no failures: check that the table is read");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("VERIFICATION.md");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(!page.contains("\nOther:\n"), "say what each failure costs: LOSSES in report.rs");
}

#[test]
fn a_value_outside_its_band_is_a_difference() {
    let row = |ours| CheckRow::new("x", "", "", ours).near(100.0, 0.1, "");
    let differs = |ours, then| difference(&row(ours), Some(&then)).is_some();
    assert!(!differs(102.0, (101.1, true)) && differs(102.0, (100.9, true)));
    assert!(differs(120.0, (101.0, true)) && differs(102.0, (120.0, false)));
    assert!(!differs(120.9, (120.0, false)) && differs(121.1, (120.0, false)));
    assert!(!differs(112.0, (120.0, false)) && differs(f64::NAN, (120.0, false)));
}
