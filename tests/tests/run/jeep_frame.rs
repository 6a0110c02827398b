//! The jeep frame through the binary: the paper's counts, the files of a run, balances, and one
//! state for any number of workers.

use crumple_tests::program::{Ended, assert_finite, crumple_with, numbers, run};
use serde_json::Value;
use std::collections::BTreeSet;

fn jeep(workers: usize, end_time: &str) -> Ended {
    let workers = workers.to_string();
    let run_it = ["run", "cases/jeep-frame", "--set", "output.field_interval=5"];
    run(crumple_with(&[&run_it[..], &["--workers", &workers, "--end-time", end_time]].concat()))
        .with_code(0)
}

/// The scene of Wang 2007: 7208 shells, 7190 nodes, no deformation at the start: no warnings.
#[test]
fn check_gives_the_papers_counts_and_no_warning() {
    let check = run(crumple_with(&["check", "cases/jeep-frame"])).with_code(0).said();
    for text in ["7208 quads", "7190", "= 103.9 structure + 1300 lumped", "no warnings"] {
        assert!(check.contains(text), "missing text: {text}\n{check}");
    }
}

/// Bits do not depend on workers, and the balances of each run are correct. In this time the
/// horns begin to fold at the wall, and the first folds touch.
#[test]
fn ten_milliseconds_give_one_state_on_any_number_of_workers() {
    let runs = [1, 3, 7].map(|workers| jeep(workers, "10"));
    for r in &runs {
        assert_eq!(r.digest(), runs[0].digest(), "{} workers", r.summary()["workers"]);
        balances(r);
    }
    whole_summary(&runs[1].summary());
    history(&runs[1]);
    assert_eq!(runs[1].read_fields(), 3, "0, 5 and 10 ms");
}

/// The same checks with dense contact: folds lie on each other, and boxes are renewed several
/// times.
#[test]
fn twenty_milliseconds_with_contact_give_one_state_on_two_and_four_workers() {
    let (two, four) = (jeep(2, "20"), jeep(4, "20"));
    assert_eq!(two.digest(), four.digest());
    for r in [&two, &four] {
        balances(r);
        assert!(r.summary()["contact"]["pairs_max"].as_u64() > Some(0), "folds touch");
    }
    redecompositions(&four);
}

fn balances(r: &Ended) {
    let s = r.summary();
    assert_finite(&s, "summary");
    assert_eq!((s["status"].as_str(), s["reason"].as_str()), (Some("completed"), Some("end_time")));
    // Error of the trapezoid of forces over finite steps: 0.002 % here; crash codes are accepted
    // with 1 %.
    let error = s["energy"]["error_max"].as_f64().unwrap();
    assert!(error < 0.01, "energy error {error}");
    // 5 to 7 % with hourglass coefficient 0.01; above 8 % folds are too stiff to be reliable.
    let [hourglass, internal] = ["hourglass", "internal"].map(|k| s["energy"][k].as_f64().unwrap());
    assert!(hourglass < 0.08 * internal, "hourglass {hourglass} of {internal}");
    // Lagrange forces leave a gap of 1e-4 of the thickness. A segment that lies less than 0.02
    // in front of the tangent plane of another one adds no constraint (`PLANE` in
    // `contact/local_search.rs`), so a node that crosses over to it is up to 0.02 deep in it.
    // Folds flatter than the limit `SINKS` in `contact/folds.rs` are up to a tenth deep when
    // their contact with other folds begins: 0.059 here (0.13 with `SINKS` of 0.5). A node past
    // the middle of a shell has 1.
    let deepest = s["contact"]["penetration_max"].as_f64().unwrap();
    assert!(deepest < 0.1, "penetration {deepest}");
    // Momentum is that of the present time, the impulse that of the last mid-step: they differ
    // by the wall's force over half a step, 500 kN * 1.7e-3 ms = 0.8 of 18800 kg mm/ms.
    let m = &s["momentum"];
    let (start, end, wall) =
        (numbers(&m["start"]), numbers(&m["end"]), numbers(&m["wall_impulse"]));
    for c in 0..3 {
        let left = end[c] - start[c] - wall[c];
        assert!(left.abs() < 1e-3 * start[0].abs(), "component {c}: {left} of {}", start[0]);
    }
    // The barrier is flat and the frame symmetric, so there is no lateral force. Folds that lie
    // on each other amplify round-off: 1e-4 within 25 ms without contact, 7e-4 to 27e-4 with it.
    assert!(wall[0] > 100.0 && wall[1].abs() < 4e-3 * wall[0], "wall impulse {wall:?}");
}

/// Checks every key that users rely on, and its type.
fn whole_summary(s: &Value) {
    for key in ["end_time", "cycles", "nodes", "workers", "wall_s", "grind_ns"] {
        assert!(s[key].is_number(), "{key}: {}", s[key]);
    }
    for (key, value) in [("status", "completed"), ("reason", "end_time"), ("transport", "threads")]
    {
        assert_eq!(s[key], value);
    }
    assert_eq!(
        (&s["nodes"], &s["elements"]["quad4"], &s["workers"]),
        (&7190.into(), &7208.into(), &3.into())
    );
    assert_eq!(s["end_time"].as_f64(), Some(10.0));
    let groups: [(&str, &[&str]); 5] = [
        (
            "energy",
            &["kinetic", "internal", "contact", "hourglass", "external", "total_initial", "error"],
        ),
        ("dt", &["first", "min", "last"]),
        ("redecompositions", &["low", "high"]),
        ("imbalance", &["mean", "max"]),
        ("contact", &["pairs_max", "penetration_max"]),
    ];
    for (group, keys) in groups {
        keys.iter()
            .for_each(|key| assert!(s[group][key].is_number(), "{group}.{key}: {}", s[group][key]));
    }
    assert_eq!(
        (numbers(&s["momentum"]["start"]).len(), numbers(&s["momentum"]["end"]).len()),
        (3, 3)
    );
    for (phase, seconds) in s["phase_s"].as_object().unwrap() {
        let (mean, max) = (seconds["mean"].as_f64().unwrap(), seconds["max"].as_f64().unwrap());
        assert!(0.0 <= mean && mean <= max * (1.0 + 1e-12), "{phase}: mean {mean}, max {max}");
    }
    let phases: f64 =
        s["phase_s"].as_object().unwrap().values().map(|p| p["mean"].as_f64().unwrap()).sum();
    let wall = s["wall_s"].as_f64().unwrap();
    assert!(phases > 0.5 * wall && phases < 1.1 * wall, "phases add up to {phases} s of {wall} s");
    let digest = s["state_digest"].as_str().unwrap();
    assert!(
        digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit()),
        "blake3 in hex: {digest}"
    );
    // 126 kJ: 1403.9 kg at 13.4112 mm/ms; the masses are sums of 7208 shells, exact to
    // round-off.
    let kinetic = 0.5 * 1403.9 * 13.4112f64.powi(2);
    let initial = s["energy"]["total_initial"].as_f64().unwrap();
    assert!(
        (initial / kinetic - 1.0).abs() < 1e-4,
        "{initial} J, and {kinetic} J from the printed mass with 6 digits"
    );
}

fn history(r: &Ended) {
    let h = r.history();
    for name in [
        "time [ms]",
        "cycle",
        "dt [ms]",
        "kinetic [J]",
        "internal [J]",
        "hourglass [J]",
        "contact work [J]",
    ] {
        assert!(h.header.iter().any(|c| c == name), "{name} not in {:?}", h.header);
    }
    for name in [
        "wall work [J]",
        "energy error [-]",
        "momentum x [kg mm/ms]",
        "pairs",
        "barrier mean force x [kN]",
    ] {
        assert!(h.header.iter().any(|c| c == name), "{name} not in {:?}", h.header);
    }
    assert!(
        h.header.iter().collect::<BTreeSet<_>>().len() == h.header.len(),
        "column names are \
        unique"
    );
    assert!(h.rows.iter().all(|row| row.len() == h.header.len()), "rows are complete");
    // A row every 0.25 ms, one at 0 and one at the end; the order of the last two depends on
    // round-off.
    assert!((41..=42).contains(&h.rows.len()), "{} rows", h.rows.len());
    let time = h.column("time");
    assert!(
        time[0] == 0.0
            && time.windows(2).all(|t| t[0] < t[1])
            && (time.last().unwrap() - 10.0).abs() < 1e-9
    );
}

/// Checks that the log has the redecompositions and their reasons.
fn redecompositions(r: &Ended) {
    let s = r.summary();
    let log = r.log();
    let of = |kind: &str| {
        let events = log.iter().filter(|e| e["fields"]["kind"] == kind);
        events
            .inspect(|e| assert!(e["fields"]["why"].as_str().is_some_and(|w| !w.is_empty()), "{e}"))
            .count() as u64
    };
    let counts = ["low", "high"].map(|kind| s["redecompositions"][kind].as_u64().unwrap());
    assert_eq!([of("low"), of("high")], counts, "events in the log and numbers in the summary");
    assert!(counts[0] + counts[1] > 0, "only the front is crushed, so boxes are renewed");
}
