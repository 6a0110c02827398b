//! The quick checks of the catalogue, entry by entry: the set of passing and failing rows must
//! be that of the committed table `tests/verification.json`. After a change of results, examine
//! the table that `crumple verify` writes, and commit it.

use crumple_verification::{Bench, CATALOGUE, Row};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Quantity and variant of a row, and true if it passes.
type Verdicts = BTreeMap<(String, String), bool>;

fn committed(id: &str, check: &str) -> Verdicts {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("verification.json");
    let table: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let find = |list: &Value, key: &str, name: &str| {
        list.as_array().unwrap().iter().find(|e| e[key] == name).unwrap_or(&Value::Null).clone()
    };
    let checks = find(&table["entries"], "id", id)["checks"].clone();
    let rows = find(&checks, "name", check)["rows"].clone();
    let text = |v: &Value| v.as_str().unwrap().to_string();
    let row =
        |r: &Value| ((text(&r["quantity"]), text(&r["variant"])), r["passes"].as_bool().unwrap());
    rows.as_array()
        .unwrap_or_else(|| panic!("{id} {check} is not in the table"))
        .iter()
        .map(row)
        .collect()
}

fn quick(id: &str) {
    let entry = CATALOGUE.iter().find(|e| e.id == id).unwrap();
    let bench = Bench::new(None);
    for check in entry.checks.iter().filter(|c| c.quick) {
        let rows = (check.run)(&bench).unwrap_or_else(|why| panic!("{id} {}: {why}", check.name));
        for r in rows.iter().filter(|r| !r.passes()) {
            eprintln!(
                "{id} {} ({}): {} against {}; {}",
                r.quantity, r.variant, r.ours, r.reference, r.known
            );
        }
        let verdict = |r: &Row| ((r.quantity.clone(), r.variant.clone()), r.passes());
        let now: Verdicts = rows.iter().map(verdict).collect();
        assert_eq!(now.len(), rows.len(), "{id} {}: rows have the same name", check.name);
        let then = committed(id, check.name);
        let changed: Vec<_> =
            now.iter().filter(|(row, passes)| then.get(*row) != Some(*passes)).collect();
        assert!(
            changed.is_empty(),
            "{id} {}: results differ from the table: {changed:?}",
            check.name
        );
        assert_eq!(now.len(), then.len(), "{id} {}: rows of the table are missing", check.name);
    }
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
