//! Contact forces of nodes in the field files: against the forces of parts, against the momentum
//! that two bars exchange, on any number of workers, and as arrows of the report.

use super::report_page::{opened, sound};
use crumple::results::field_file::{PieceArrays, pieces, steps};
use crumple_tests::fields::assert_same_fields;
use crumple_tests::program::{Ended, crumple_with, run};
use std::collections::BTreeSet;
use std::fs;

/// Momentum of a bar: density, length, width (one element), thickness, velocity.
const MOMENTUM: f64 = 7.85e-6 * 100.0 * 2.5 * 0.2 * 10.0;

/// Two bars, with field files and history rows of each step.
fn bars(workers: &str, more: &[&str]) -> Ended {
    let settings = [
        "output.contact_forces=true",
        "output.field_interval=1e-6",
        "output.history_interval=1e-6",
    ];
    let mut args = vec!["run", "cases/bars", "--quiet", "--workers", workers];
    settings.iter().chain(more).for_each(|setting| args.extend(["--set", setting]));
    run(crumple_with(&args)).with_code(0)
}

/// Returns the places of the nodes of part 2 in a piece.
fn nodes_of_second_bar(piece: &PieceArrays) -> BTreeSet<i64> {
    let (corners, parts) = (piece.i64("connectivity").unwrap(), piece.u32("part").unwrap());
    let quads = corners.chunks(4).zip(parts).filter(|(_, part)| *part == 2);
    quads.flat_map(|(quad, _)| quad.to_vec()).collect()
}

/// Returns time and x component of the force on the second bar and on both, of each field file.
fn forces(ended: &Ended) -> Vec<[f64; 3]> {
    let sum = |step: &crumple::results::field_file::FieldStep| {
        let mut sums = [step.time, 0.0, 0.0];
        for piece in pieces(&step.file).unwrap() {
            let piece = PieceArrays::read(&piece).unwrap();
            let second = nodes_of_second_bar(&piece);
            for (n, force) in piece.array("contact_force").unwrap().chunks(3).enumerate() {
                sums[1] += if second.contains(&(n as i64)) { force[0] } else { 0.0 };
                sums[2] += force[0];
            }
        }
        sums
    };
    steps(&ended.out().join("fields/fields.pvd")).unwrap().iter().map(sum).collect()
}

/// The forces on both bars are opposite, those on one are the contact force of its part in
/// `contacts.csv`, and their impulse is the momentum of the first bar, which stops.
#[test]
fn forces_of_nodes_add_up_to_those_of_parts_and_to_the_momentum() {
    let ended = bars("1", &[]);
    let forces = forces(&ended);
    let text = fs::read_to_string(ended.out().join("contacts.csv")).unwrap();
    let of_part: Vec<f64> = text
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|fields| fields[1] == "2")
        .map(|fields| fields[3].parse().unwrap())
        .collect();
    // A row has the force in its cycle, a field file that of the last cycle. The last row has none.
    assert!(forces.len() > 100 && of_part.len() >= forces.len() - 1, "{}", of_part.len());
    let largest = of_part.iter().fold(0.0f64, |most, f| most.max(f.abs()));
    assert!(largest > 0.0);
    for (i, [time, on_second, on_both]) in forces.iter().enumerate() {
        // Single precision in the files.
        assert!(on_both.abs() < 1e-5 * largest, "at {time}: {on_both}");
        let row = if i == 0 { 0.0 } else { of_part[i - 1] };
        assert!((on_second - row).abs() < 1e-5 * largest, "at {time}: {on_second} for {row}");
    }
    let impulse: f64 = forces.windows(2).map(|w| w[1][1] * (w[1][0] - w[0][0])).sum();
    // Part of the energy stays in waves: the restitution of 40 elements is above 0.95.
    assert!((impulse / MOMENTUM - 1.0).abs() < 0.05, "{impulse} for {MOMENTUM}");
}

/// The files have the same bits on 1, 2 and 3 workers, also if boxes are renewed often.
#[test]
fn forces_of_nodes_do_not_depend_on_workers() {
    let alone = bars("1", &[]);
    for workers in ["2", "3"] {
        let other = bars(workers, &["parallel.force_every=7"]);
        assert_eq!(other.digest(), alone.digest());
        assert!(other.summary()["redecompositions"]["high"].as_u64().unwrap() > 3);
        assert_same_fields(&alone.out(), &other.out());
    }
}

/// The page draws an arrow of five lines at each node with a force, and has the magnitude of the
/// force as a colour.
#[test]
fn forces_of_nodes_are_arrows_on_the_page() {
    let ended = bars("1", &["time.max_cycles=20"]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    browser.evaluate("crumple.go(crumple.times.at(-1))");
    browser.click("#node-forces");
    let drawn = "[crumple.model.frames.at(-1).forces.nodes.length, \
                 crumple.nodeForces.object.geometry.getAttribute('position').count]";
    let drawn: Vec<u64> = serde_json::from_value(browser.evaluate(drawn)).unwrap();
    assert!(drawn[0] >= 4, "two nodes of each bar touch: {drawn:?}");
    assert_eq!(drawn[1], 10 * drawn[0]);
    let values = "(() => { \
                  const way = crumple.ways.find((way) => way.title === 'contact force'); \
                  crumple.colour(way); \
                  const frame = crumple.model.frames.at(-1), { nodes, components } = frame.forces; \
                  const all = Array.from({ length: crumple.model.nodes }, \
                  (_, n) => way.node(frame, n)); \
                  const forces = Array.from(nodes, \
                  (_, i) => Math.hypot(...components.map((c) => c[i]))); \
                  return [all.filter((v) => v > 0).length, way.top, Math.max(...all), \
                  Math.max(...forces), Math.abs(all[nodes[0]] - forces[0])]; })()";
    let [acting, top, most, largest, off]: [f64; 5] =
        serde_json::from_value(browser.evaluate(values)).unwrap();
    assert_eq!(acting, drawn[0] as f64);
    assert!(top >= most && off < 1e-6 * largest, "{top} {most} {off}");
    assert!((most / largest - 1.0).abs() < 1e-6, "{most} for {largest}");
    sound(&mut browser);
}
