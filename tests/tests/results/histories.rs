//! Histories by kind, compared with closed forms, and the same values on any number of workers.
//! Units mm, ms, kg, so kN and J. Numbers in the files have ten digits: sums of them are
//! compared within that precision of the largest value of a column.

use crumple_tests::program::{Ended, crumple_with, run};
use crumple_verification::scene::Scene;
use std::fs;

/// Tolerance for ten digits, with a margin for sums of several numbers.
const DIGITS: f64 = 1e-8;
const RHO: f64 = 7.85e-6;

/// Rows of a history as texts, and its header.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(ended: &Ended, name: &str) -> Self {
        let text = fs::read_to_string(ended.out().join(name))
            .unwrap_or_else(|e| panic!("{name}: {e}: {}", ended.said()));
        let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect());
        Self { header: lines.next().expect("a header"), rows: lines.collect() }
    }

    fn at(&self, name: &str) -> usize {
        self.header
            .iter()
            .position(|h| h.starts_with(name))
            .unwrap_or_else(|| panic!("no {name} in {:?}", self.header))
    }

    /// Returns a column of the rows that have `word` in column `by`; of all rows if `by` is
    /// empty.
    fn column(&self, name: &str, by: &str, word: &str) -> Vec<f64> {
        let at = self.at(name);
        let kept = self.rows.iter().filter(|row| by.is_empty() || row[self.at(by)] == word);
        kept.map(|row| row[at].parse().expect("a number")).collect()
    }

    fn vector(&self, name: &str, by: &str, word: &str) -> Vec<[f64; 3]> {
        let [x, y, z] = ["x", "y", "z"].map(|c| self.column(&format!("{name} {c}"), by, word));
        x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()
    }
}

fn job(text: &str, sets: &[&str]) -> Ended {
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("job.toml");
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    run(crumple_with(&[&["run", path, "--quiet"], sets].concat())).with_code(0)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// Returns the largest difference of two vectors' components.
fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// Runs the two bars, with a row in every cycle.
fn bars(workers: &str) -> Ended {
    let sets = ["--set", "output.history_interval=1e-9", "--set", "output.field_interval=-1"];
    run(crumple_with(
        &[&["run", "cases/bars", "--quiet", "--workers", workers], &sets[..]].concat(),
    ))
    .with_code(0)
}

/// The values of the parts add up to those of the model, and the contact force on a bar changes
/// its momentum. With the impulse F mid between two mid-steps, and the momentum at a time as the
/// mean of those before and after, `P(n+1) - P(n) = (F(n) mid(n) + F(n+1) mid(n+1)) / 2`.
#[test]
fn parts_add_up_and_contact_changes_their_momentum() {
    let ended = bars("1");
    let (all, parts) = (ended.history(), Table::read(&ended, "parts.csv"));
    for name in ["kinetic", "internal", "hourglass"] {
        let (one, two) = (parts.column(name, "part", "1"), parts.column(name, "part", "2"));
        let whole = all.column(name);
        let scale = largest(&all.column("kinetic"));
        for ((a, b), sum) in one.iter().zip(&two).zip(&whole) {
            assert!((a + b - sum).abs() < DIGITS * scale, "{name}: {a} + {b}, expected {sum}");
        }
    }
    let mass = parts.column("mass", "part", "1");
    let side = 100.0 / 40.0;
    assert!(
        (mass[0] / (RHO * 0.2 * side * 100.0) - 1.0).abs() < DIGITS,
        "a bar one quad wide: {}",
        mass[0]
    );

    let contacts = Table::read(&ended, "contacts.csv");
    let (f1, f2) = (contacts.vector("force", "part", "1"), contacts.vector("force", "part", "2"));
    assert!(
        f1.iter().zip(&f2).all(|(a, b)| (0..3).all(|c| a[c] == -b[c])),
        "the forces on both parts are opposite"
    );
    let pairs = Table::read(&ended, "contact_pairs.csv").vector("force", "on part", "1");
    let felt: Vec<[f64; 3]> = f1.iter().copied().filter(|f| *f != [0.0; 3]).collect();
    assert!(
        felt.len() > 20 && pairs.iter().copied().filter(|f| *f != [0.0; 3]).eq(felt),
        "there is one pair of parts"
    );

    let dt = all.column("dt");
    // The last row is for the previous time, with the step after it.
    let rows = dt.len() - 1;
    let mid = |n: usize| 0.5 * (dt[n] + if n > 0 { dt[n - 1] } else { 0.0 });
    let momentum = parts.vector("momentum", "part", "1");
    let scale = largest(&momentum.iter().map(|p| p[0]).collect::<Vec<_>>());
    for n in 1..rows {
        let impulse = 0.5 * (f1[n - 1][0] * mid(n - 1) + f1[n][0] * mid(n));
        let change = momentum[n][0] - momentum[n - 1][0];
        assert!((change - impulse).abs() < DIGITS * scale, "row {n}: {change}, expected {impulse}");
    }
}

/// The files are the same on any number of workers, to round-off of their sums. The state is the
/// same to the bit, with and without these files.
#[test]
fn workers_make_no_difference() {
    let scene = |workers: &str, more: &[&str]| {
        let args = ["run", "cases/tumble", "--quiet", "--end-time", "1.5", "--workers", workers];
        let sets = ["--set", "output.history_interval=0.05", "--set", "output.field_interval=-1"];
        let forced = ["--set", "parallel.force_every=40"];
        run(crumple_with(&[&args[..], &sets, &forced, more].concat())).with_code(0)
    };
    let alone = scene("1", &[]);
    let off = ["output.parts=false", "output.contacts=false"].map(|s| ["--set", s]);
    let without = scene("1", off.as_flattened());
    assert_eq!(alone.digest(), without.digest());
    assert!(
        !without.out().join("parts.csv").exists() && !without.out().join("contacts.csv").exists()
    );
    let touched = Table::read(&alone, "contacts.csv")
        .vector("force", "", "")
        .iter()
        .filter(|f| **f != [0.0; 3])
        .count();
    assert!(touched > 10, "rows with contact: {touched}");
    for workers in ["2", "4"] {
        let several = scene(workers, &[]);
        assert_eq!(alone.digest(), several.digest(), "{workers} workers");
        for (name, first) in [("parts.csv", 3), ("contacts.csv", 3), ("contact_pairs.csv", 3)] {
            let (a, b) = (Table::read(&alone, name), Table::read(&several, name));
            assert_eq!(a.rows.len(), b.rows.len(), "{name}");
            for c in first..a.header.len() {
                let numbers =
                    |t: &Table| t.rows.iter().map(|r| r[c].parse().unwrap()).collect::<Vec<f64>>();
                let (x, y) = (numbers(&a), numbers(&b));
                let scale = largest(&x);
                let differ = x.iter().zip(&y).find(|(x, y)| (**x - **y).abs() > DIGITS * scale);
                assert_eq!(differ, None, "{name}, {}: {workers} workers", a.header[c]);
            }
        }
    }
}

/// Transducers on each part, and on one part from another, have the same digits on any number of
/// workers, add up to the contact forces on parts, and do not change the state.
#[test]
fn transducers_have_the_same_digits_on_any_workers() {
    let asked = "output.transducer=[{ name = \"on 2\", parts = [2] }, { name = \"2 from 1\", parts \
                 = [2], from_parts = [1] }, \
                 { name = \"1 from 2\", parts = [1], from_parts = [2] }]";
    let scene = |workers: &str, more: &[&str]| {
        let args = ["run", "cases/tumble", "--quiet", "--end-time", "1.5", "--workers", workers];
        let sets = ["--set", "output.history_interval=0.05", "--set", "output.field_interval=-1"];
        let forced = ["--set", "parallel.force_every=40"];
        run(crumple_with(&[&args[..], &sets, &forced, more].concat())).with_code(0)
    };
    let [one, two, four] = ["1", "2", "4"].map(|workers| scene(workers, &["--set", asked]));
    assert_eq!(scene("1", &[]).digest(), one.digest(), "transducers do not change the run");
    let table = Table::read(&one, "transducers.csv");
    for several in [two, four] {
        assert_eq!(Table::read(&several, "transducers.csv").rows, table.rows);
    }
    let of = |name: &str| table.vector("force", "transducer", name);
    let part = Table::read(&one, "contacts.csv").vector("force", "part", "2");
    let scale = largest(part.as_flattened());
    assert!(
        scale > 0.0 && part.iter().filter(|f| **f != [0.0; 3]).count() > 5,
        "part 2 has \
        contact forces"
    );
    assert!(part.iter().zip(of("on 2")).all(|(a, b)| apart(*a, b) < DIGITS * scale));
    assert!(
        of("2 from 1").iter().zip(of("1 from 2")).all(|(a, b)| apart(*a, b.map(|c| -c)) == 0.0)
    );
}

/// Returns a strip of ten quads of side 5 along x, thickness 4, parts 1 (the first half) and 2.
fn strip(more: &str) -> String {
    let mut scene = Scene::default();
    let nodes: Vec<[u32; 2]> =
        (0..=10).map(|i| [0.0, 5.0].map(|y| scene.node([5.0 * i as f64, y, 0.0]))).collect();
    for (i, ends) in nodes.windows(2).enumerate() {
        let [[a, b], [c, d]] = [ends[0], ends[1]];
        scene.shell(1 + i as u32 / 5, &[a, c, d, b]);
    }
    for (name, at) in [("held", 0), ("middle", 5), ("tip", 10)] {
        scene.set_named(name, &nodes[at]);
    }
    format!(
        "units = \"mm, ms, kg\"\n{more}\n{}\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = {RHO:?}\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 4.0\n[[part]]\nid = 2\n\
         material = \"steel\"\nthickness = 4.0\n",
        scene.mesh_text()
    )
}

/// Returns the strip held at its left end, damped until it is at rest; sections in its middle,
/// from either side.
fn held_strip(load: &str) -> String {
    strip(&format!(
        "end_time = 4.0\n[[fix]]\nnodes = \"held\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \
         \"rz\"]\n\
         [time]\ndamping = 16.7\n[output]\nfield_interval = -1\nhistory_interval = 0.1\n\
         [[output.node]]\nnodes = \"tip\"\nids = [11, 12]\nname = \"seen\"\n\
         [[output.section]]\nname = \"left\"\nnodes = \"middle\"\nparts = [1]\n\
         [[output.section]]\nname = \"right\"\nnodes = \"middle\"\nside = [1.0, 0.0, 0.0]\n{load}"
    ))
}

/// Returns the mean position of nodes in the last row.
fn place(nodes: &Table, ids: [&str; 2]) -> [f64; 3] {
    let of = |id: &str| ["x [", "y [", "z ["].map(|c| *nodes.column(c, "id", id).last().unwrap());
    let (a, b) = (of(ids[0]), of(ids[1]));
    std::array::from_fn(|c| 0.5 * (a[c] + b[c]))
}

/// A strip at rest under a force at its tip has that force in every section, and its moment
/// about the middle of the deformed section. The remaining motion is `exp(-8.35 * 4)` of the
/// slowest mode, critically damped: 3e-15, times its time.
#[test]
fn sections_carry_the_applied_load() {
    let force = [0.5, 0.0, 2e-3];
    for workers in ["1", "2"] {
        let load = format!("[[load]]\nnodes = \"tip\"\nforce = {force:?}\n");
        let ended = job(&held_strip(&load), &["--workers", workers]);
        let (sections, nodes) =
            (Table::read(&ended, "sections.csv"), Table::read(&ended, "nodes.csv"));
        let (middle, tip) = (place(&nodes, ["11", "12"]), place(&nodes, ["21", "22"]));
        assert!(tip[2] > 0.01, "the strip bends: {tip:?}");
        let arm: [f64; 3] = std::array::from_fn(|c| tip[c] - middle[c]);
        let turn = [
            arm[1] * force[2] - arm[2] * force[1],
            arm[2] * force[0] - arm[0] * force[2],
            arm[0] * force[1] - arm[1] * force[0],
        ];
        for (name, sign) in [("right", 1.0), ("left", -1.0)] {
            let f = *sections.vector("force", "section", name).last().unwrap();
            let m = *sections.vector("moment", "section", name).last().unwrap();
            let c = *sections.vector("middle", "section", name).last().unwrap();
            let signed = |v: [f64; 3]| v.map(|c| sign * c);
            assert!(
                apart(f, signed(force)) < DIGITS * force[0],
                "{name}: force {f:?}, applied {force:?}"
            );
            assert!(
                apart(m, signed(turn)) < 1e-7 * turn[1].abs(),
                "{name}: moment {m:?}, expected {turn:?}"
            );
            assert!(apart(c, middle) < DIGITS * tip[0], "{c:?}, expected {middle:?}");
        }
    }
}

/// Pressure on a section's own elements is no force in the section. With the right half under a
/// pressure p, the section carries the load beyond its nodes: p times the area, minus the half
/// element that the nodes carry themselves.
#[test]
fn pressure_on_the_elements_of_a_section_does_not_count() {
    let p = 1e-6;
    let ended = job(
        &held_strip(&format!("[[pressure]]\nparts = [2]\npressure = {p:?}\n")),
        &["--workers", "1"],
    );
    let force =
        *Table::read(&ended, "sections.csv").vector("force", "section", "right").last().unwrap();
    let wanted = -p * (125.0 - 12.5);
    // The strip bends by a thousandth of its length, which rotates the direction of the pressure
    // but does not shorten the strip.
    assert!((force[2] / wanted - 1.0).abs() < 1e-5, "{force:?}, expected {wanted}");
}

/// Vertical throw: `v = v0 - g t` and `u = v0 t - g t^2 / 2`.
#[test]
fn nodes_fall() {
    let (g, v0) = (100.0, 10.0);
    let text = strip(&format!(
        "end_time = 0.02\n[[gravity]]\nacceleration = [0.0, 0.0, -{g:?}]\n[[initial_velocity]]\n\
         velocity = [0.0, 0.0, {v0:?}]\n\
         [output]\nfield_interval = -1\nhistory_interval = 1e-9\n[[output.node]]\nids = [3]\n"
    ));
    let nodes = Table::read(&job(&text, &["--workers", "2"]), "nodes.csv");
    let [u, v, a] =
        ["displacement", "velocity", "acceleration"].map(|name| nodes.vector(name, "id", "3"));
    let times = nodes.column("time", "", "");
    // The last row has the velocity of the previous mid-step, see the README.
    assert!(times.len() > 20);
    for (((t, u), v), a) in times.iter().zip(&u).zip(&v).zip(&a).take(times.len() - 1) {
        assert!(
            (v[2] - v0 + g * t).abs() < DIGITS * v0 && (a[2] + g).abs() < 1e-7 * g,
            "{t}: {v:?} {a:?}"
        );
        // The shape of the strip is constant, so steps change by round-off only and the scheme
        // is exact.
        assert!((u[2] - v0 * t + 0.5 * g * t * t).abs() < DIGITS, "{t}: {u:?}");
    }
}

/// The impulse of a wall is the change of momentum. With P(n) the mean of the momenta of the
/// mid-steps around it, `P(n) - P(n-1) = (I(n) - I(n-2)) / 2`. Mean forces times the times
/// between rows are the impulse.
#[test]
fn walls_change_the_momentum() {
    let text = strip(
        "end_time = 0.03\n[[wall]]\nname = \"barrier\"\npoint = [-0.01, 0.0, 0.0]\n\
         normal = [1.0, 0.0, 0.0]\n\
         [[initial_velocity]]\nvelocity = [-10.0, 0.0, 0.0]\n[output]\nfield_interval = -1\n\
         history_interval = 1e-9\n",
    );
    for workers in ["1", "2"] {
        let ended = job(&text, &["--workers", workers]);
        let (walls, all) = (Table::read(&ended, "walls.csv"), ended.history());
        let (times, momentum) = (all.column("time"), all.column("momentum x"));
        let impulse: Vec<f64> =
            walls.vector("impulse", "wall", "barrier").iter().map(|p| p[0]).collect();
        let last = times.len() - 1;
        assert!(
            impulse[last] > 1.5 * momentum[0].abs(),
            "an elastic bar rebounds: {} of {}",
            impulse[last],
            momentum[0]
        );
        for n in 2..last {
            let (change, given) =
                (momentum[n] - momentum[n - 1], 0.5 * (impulse[n] - impulse[n - 2]));
            assert!(
                (change - given).abs() < DIGITS * momentum[0].abs(),
                "row {n}: {change}, expected {given}"
            );
        }
        let mean = walls.vector("mean force", "wall", "barrier");
        let summed: f64 = (1..=last).map(|n| mean[n][0] * (times[n] - times[n - 1])).sum();
        assert!(
            ((summed + impulse[0]) / impulse[last] - 1.0).abs() < 1e-6,
            "{summed}, expected {}",
            impulse[last]
        );
    }
}
