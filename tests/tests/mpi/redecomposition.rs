//! Redecompositions that the master orders by what the workers report, without forcing: a *high*
//! one for displacement, a *low* one for imbalance, and none of a kind without its cause. On
//! threads and under MPI.

use crumple_tests::program::{Ended, crumple_with, mpi_or_skip, mpirun, run};

/// Transports, as far as they are there.
fn transports() -> Vec<&'static str> {
    if mpi_or_skip().is_some() { vec!["threads", "mpi"] } else { vec!["threads"] }
}

fn run_on(transport: &str, workers: usize, job: &str, sets: &[&str]) -> Ended {
    let mut args = vec!["run", job, "--no-report", "--set", "output.field_interval=-1"];
    sets.iter().for_each(|set| args.extend(["--set", set]));
    let number = workers.to_string();
    let command = match transport {
        "mpi" => mpirun(workers + 1, &args),
        _ => crumple_with(&[&args[..], &["--workers", &number]].concat()),
    };
    let ended = run(command).with_code(0);
    assert_eq!(ended.summary()["transport"], transport);
    ended
}

/// Returns the numbers of low and high redecompositions.
fn counts(r: &Ended) -> [u64; 2] {
    let s = r.summary();
    ["low", "high"].map(|kind| s["redecompositions"][kind].as_u64().expect("a number"))
}

/// Returns the columns of `workers.csv` with these names, row by row.
fn reports<const N: usize>(r: &Ended, names: [&str; N]) -> Vec<[f64; N]> {
    let text = std::fs::read_to_string(r.out().join("workers.csv")).expect("workers.csv");
    let mut lines = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let place = names.map(|name| {
        let found = header.iter().position(|h| *h == name || h.starts_with(&format!("{name} [")));
        found.unwrap_or_else(|| panic!("no column {name} in {header:?}"))
    });
    let number = |field: &str| field.parse().unwrap_or_else(|_| panic!("{field} is no number"));
    lines.map(|fields| place.map(|p| number(fields[p]))).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

const BODIES: [&str; 2] = ["time.max_cycles=600", "parallel.imbalance=100"];

/// Bodies that fly at each other use up the margin. With a buffer that covers the whole motion
/// they do not.
#[test]
fn displacement_calls_for_a_high_one() {
    for transport in transports() {
        let near = run_on(transport, 2, "cases/tumble", &BODIES);
        let [low, high] = counts(&near);
        assert!(low == 0 && high > 1, "{transport}: {low} low, {high} high");
        for [moved, margin, share] in reports(&near, ["displacement", "margin", "share of margin"])
        {
            let ratio = if margin > 0.0 { moved / margin } else { 0.0 };
            assert!((ratio - share).abs() < 1e-5, "{moved} of {margin} is not {share}");
        }
        let shares = reports(&near, ["share of margin"]);
        assert!(largest(shares.iter().map(|r| r[0])) >= 0.7, "the cause is in the file");
        let why: Vec<String> = near
            .log()
            .iter()
            .filter(|e| e["fields"]["kind"] == "high")
            .map(|e| e["fields"]["why"].as_str().expect("a reason").to_owned())
            .collect();
        assert!(why.iter().all(|w| w.contains("displacement")), "{why:?}");

        let wide =
            run_on(transport, 2, "cases/tumble", &[&BODIES[..], &["parallel.buffer=400"]].concat());
        assert_eq!(counts(&wide), [0, 0], "{transport}: the margin covers the motion");
        assert_eq!(near.digest(), wide.digest());
        let moved = reports(&wide, ["displacement", "share of margin"]);
        assert!(largest(moved.iter().map(|r| r[0])) > 0.0 && moved.iter().all(|r| r[1] < 0.7));
    }
}

/// The front of a frame is strained by a wall and the rest is not, so the front costs more. The
/// same frame in free flight costs the same everywhere. The flight runs on threads only: with more
/// processes than cores, CPU time in the first cycles scatters by more than the limit.
#[test]
fn imbalance_calls_for_a_low_one() {
    for transport in transports() {
        // The imbalance decreases as the rest of the frame is strained too. It must still be above
        // the limit when the time lost by waiting exceeds the cost of a repartition.
        let sets = ["time.max_cycles=700", "parallel.imbalance=1.1"];
        let crash = run_on(transport, 4, "cases/jeep-frame", &sets);
        let [low, _] = counts(&crash);
        assert!(low > 0, "{transport}: {:?}", crash.summary()["imbalance"]);
        let of_crash = reports(&crash, ["cycles", "imbalance"]);
        assert!(largest(of_crash.iter().map(|r| r[1])) > 1.1, "the cause is in the file");

        if transport == "mpi" {
            continue;
        }
        let sets = ["time.max_cycles=700", "parallel.imbalance=1.25"];
        let flight = run_on(transport, 4, "cases/flight", &sets);
        assert_eq!(counts(&flight), [0, 0], "{transport}: {:?}", flight.summary()["imbalance"]);
    }
}

/// Each element has one class, the counts of the last reports are those of the summary, and the CPU
/// time of the phases is that of the cycles.
#[test]
fn the_file_of_the_workers_adds_up() {
    let r = run_on("threads", 3, "cases/tumble", &["time.max_cycles=205"]);
    let s = r.summary();
    let elements: u64 = s["elements"]["quad4"].as_u64().expect("a number");
    let names = ["worker", "cycle", "interior elements", "interface elements", "exterior elements"];
    let rows = reports(&r, names);
    assert_eq!(rows.len(), 3 * 21, "every 10 cycles and at the end");
    for cycle in (10..=200).step_by(10).chain([205]) {
        let of_cycle = || rows.iter().filter(|row| row[1] == f64::from(cycle));
        assert_eq!(of_cycle().count(), 3, "cycle {cycle}");
        assert_eq!(of_cycle().map(|row| row[2] + row[3]).sum::<f64>(), elements as f64);
    }
    for row in rows.iter().filter(|row| row[1] == 205.0) {
        for (class, value) in ["interior", "interface", "exterior"].iter().zip(&row[2..]) {
            assert_eq!(s["classes"][class][row[0] as usize].as_f64(), Some(*value), "{class}");
        }
    }
    let phases = ["elements", "assemble", "constraints", "halo", "search", "local", "contact"];
    let mut names: Vec<String> = phases.iter().map(|p| format!("cpu {p}")).collect();
    names.extend(["energy", "advance", "output"].map(|p| format!("cpu {p}")));
    let names: [&str; 10] = std::array::from_fn(|i| names[i].as_str());
    let spent: f64 = reports(&r, names).iter().flatten().sum();
    let loads: f64 = reports(&r, ["cycles", "load"]).iter().map(|r| r[0] * r[1]).sum();
    // The last report has 5 cycles, of which perhaps none is sampled.
    assert!(spent <= loads * (1.0 + 1e-4) && spent > 0.9 * loads, "{spent} of {loads}");
    let sent = reports(&r, ["messages"]).iter().map(|r| r[0]).sum::<f64>() / (3.0 * 205.0);
    let of_summary = s["cpu_s"]["messages_per_cycle"].as_f64().expect("a number");
    // The summary also counts the history and the final report.
    assert!(sent > 1.0 && sent <= of_summary && sent > 0.9 * of_summary, "{sent}, {of_summary}");
}

/// Redecompositions are printed with `-v` only.
#[test]
fn redecompositions_are_details() {
    let tumble = ["run", "cases/tumble", "--no-report", "--workers", "2"];
    let sets = ["--set", "output.field_interval=-1", "--set", "time.max_cycles=300"];
    let said = |more: &[&str]| {
        let ended = run(crumple_with(&[&tumble[..], &sets, more].concat())).with_code(0);
        assert!(counts(&ended)[1] > 0, "there is something to say");
        ended.said().matches("high redecomposition at T=").count() as u64
    };
    assert_eq!(said(&[]), 0);
    assert!(said(&["-v"]) > 0);
}
