//! Honeycomb of decks: parameters, axes, problems, and a block that is crushed by a mass. Units mm,
//! ms, kg, so kN, GPa and J.

use crate::base::{BASE, MOVES, assert_refused, model_of};
use crumple::input::job::Model;
use crumple_tests::program::{Ended, crumple_with, run};
use std::fmt::Write;
use std::fs;

/// The base without its shells, which no honeycomb can have.
fn base() -> String {
    BASE.replace("plate\n1,1,1\n", "plate\n1,1,2\n") + "*MAT_ELASTIC\n2,7.85e-6,207.0,0.3\n"
}

fn model(cards: &str) -> Model {
    model_of(&format!("{}{MOVES}{cards}", base()))
}

/// Returns a parameter of the honeycomb, as TOML text.
fn parameter(model: &Model, key: &str) -> String {
    let mut materials = model.job.material.iter();
    let core = materials.find(|m| m.law == "honeycomb").expect("a honeycomb");
    core.parameters.get(key).map_or(String::new(), |value| value.to_string())
}

const CURVES: &str = "*DEFINE_CURVE\n21\n0.0,0.002\n0.8,0.02\n*DEFINE_CURVE\n22\n0.2,0.03\n\
    1.0,0.001\n*DEFINE_CURVE\n23\n0.0,1.0\n1.0,1.5\n";

/// Each field becomes a parameter; a blank modulus is that of the solid; a curve that begins above
/// zero is over the relative volume.
#[test]
fn fields_become_parameters() {
    let card = "*MAT_026\n1,8e-8,70.0,0.25,0.2,0.2\n21,22,0,22,0,21,0,23\n\
                1.0,0.1,,0.3,,0.2,2.0,1\n0,0,0,1.0,1.0,0.0\n-1.0,1.0,0.0,0.4,0.5\n";
    let volume = model(&format!("{card}{CURVES}"));
    for (key, value) in [
        ("youngs_modulus", "70.0"),
        ("poisson", "0.25"),
        ("yield_stress", "0.2"),
        ("compacted_volume", "0.2"),
        ("moduli", "[1.0, 0.1, 70.0, 0.3, 28.0, 0.2]"),
        ("crush_a", "[[0.0, 0.002], [0.8, 0.02]]"),
        ("crush_b", "[[0.0, 0.001], [0.8, 0.03]]"),
        ("crush_c", ""),
        ("crush_shear", "[[0.0, 0.001], [0.8, 0.03]]"),
        ("crush_bc", "[[0.0, 0.002], [0.8, 0.02]]"),
        ("rate_factors", "[[0.0, 1.0], [1.0, 1.5]]"),
        ("direction", "[1.0, 1.0, 0.0]"),
        ("direction_2", "[-1.0, 1.0, 0.0]"),
        ("tension_failure_strain", "0.4"),
        ("shear_failure_strain", "0.5"),
        ("directional", ""),
    ] {
        assert_eq!(parameter(&volume, key), value, "{key}");
    }
    assert!(volume.mapping.iter().any(|entry| entry.of == "material 1, lcb"));
    let own = model(&format!(
        "*MAT_126\n1,8e-8,70.0,0.25,0.2,0.2\n22\n1.0,0.1,0.1,0.3,0.3,0.2\n{CURVES}"
    ));
    assert_eq!(parameter(&own, "directional"), "true");
    assert_eq!(parameter(&own, "crush_a"), "[[0.2, 0.03], [1.0, 0.001]]");
    assert_eq!(parameter(&own, "direction"), "");
}

/// All problems of a honeycomb are named at once.
#[test]
fn what_a_honeycomb_does_not_have_is_refused() {
    for (card, words) in [
        (
            "*MAT_026\n1,8e-8,70.0,0.25,0.2,0.2\n21,99\n1.0,0.1,0.1,0.3,0.3,0.2,3.0,2\n",
            &["`aopt` = 3", "`macf` = 2", "no *DEFINE_CURVE with the id 99"][..],
        ),
        (
            "*MAT_126\n1,8e-8,70.0,0.25,0.2,0.2\n-21,21,21,21,,,,-1\n1.0,0.1,0.1,0.3,0.3,0.2,2.0\n\
             \n,,,-0.4,-5.0\n1,1,1,1,1,1\n",
            &[
                "`lca` = -21",
                "`lcsr` = -1",
                "`tsef` = -0.4",
                "`ssef` = -5",
                "without the vector of a1",
                "without the vector of d1",
            ],
        ),
        (
            "*MAT_026\n1,8e-8,70.0,0.25,0.2,1.2\n21\n1.0,0.1,0.1,-0.3,0.3,0.2\n",
            &["compacted_volume is 1.2", "moduli are not six moduli"],
        ),
    ] {
        assert_refused(&format!("{}{MOVES}{card}{CURVES}", base()), words);
    }
}

/// Elements along and across the block, its size [mm], the mass behind it [kg], its velocity
/// [mm/ms].
const ALONG: usize = 8;
const ACROSS: usize = 4;
const LENGTH: f64 = 40.0;
const WIDTH: f64 = 20.0;
const MASS: f64 = 0.2;
const SPEED: f64 = 10.0;
/// Crush stress at no strain, and its increase over the strain [GPa].
const CRUSH: [f64; 2] = [0.002, 0.002];

/// Writes a deck with a block of honeycomb whose nodes at one end have the mass, moving along its
/// axis a, which is y, towards a wall.
fn block(card: &str) -> String {
    let mut nodes = String::new();
    let mut elements = String::new();
    let mut masses = String::new();
    let across = ACROSS + 1;
    let id = |i: usize, j: usize, k: usize| 1 + i + across * (k + across * j);
    let at_edge = |i: usize| if [0, ACROSS].contains(&i) { 0.5 } else { 1.0 };
    for j in 0..=ALONG {
        for k in 0..across {
            for i in 0..across {
                let [x, z] = [i, k].map(|c| WIDTH * c as f64 / ACROSS as f64);
                let y = LENGTH * j as f64 / ALONG as f64;
                let _ = writeln!(nodes, "{},{x},{y},{z}", id(i, j, k));
                if j == ALONG {
                    let share = at_edge(i) * at_edge(k) / (ACROSS * ACROSS) as f64;
                    let n = id(i, j, k);
                    let _ = writeln!(masses, "{n},{n},{}", share * MASS);
                }
            }
        }
    }
    for j in 0..ALONG {
        for k in 0..ACROSS {
            for i in 0..ACROSS {
                let low =
                    |j: usize| [id(i, j, k), id(i + 1, j, k), id(i + 1, j, k + 1), id(i, j, k + 1)];
                // The face at the smaller y last: the element is not inside out.
                let corners = [low(j + 1), low(j)].concat();
                let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
                let _ = writeln!(elements, "{},1,{}", id(i, j, k), corners.join(","));
            }
        }
    }
    let end = CRUSH[0] + CRUSH[1];
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n1.5\n*DATABASE_RWFORC\n0.05\n\
         *CONTROL_BULK_VISCOSITY\n1e-9,1e-9\n*PART\ncore\n1,1,1\n\
         *SECTION_SOLID\n1,0\n{card}*DEFINE_CURVE\n1\n0.0,{}\n1.0,{end}\n\
         *DEFINE_CURVE\n2\n0.0,0.0002\n1.0,0.001\n*NODE\n{nodes}*ELEMENT_SOLID\n{elements}\
         *ELEMENT_MASS\n{masses}*INITIAL_VELOCITY\n0\n0.0,-{SPEED},0.0\n\
         *RIGIDWALL_PLANAR_ID\n1\n0\n0,-0.01,0,0,1,0\n*END\n",
        CRUSH[0]
    )
}

/// Runs a deck on 1, 2 and 3 workers with the same digest.
fn on_three(text: &str) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, text).unwrap();
    let [one, two, three] = ["1", "2", "3"].map(|workers| {
        let deck = path.to_str().unwrap();
        let quiet = ["--set", "output.field_interval=-1"];
        run(crumple_with(&[&["run", deck, "--workers", workers], &quiet[..]].concat())).with_code(0)
    });
    for ended in [&two, &three] {
        assert_eq!(ended.digest(), one.digest(), "any number of workers");
    }
    let error = one.summary()["energy"]["error_max"].as_f64().expect("a number");
    assert!(error < 2e-3, "energy error {error}");
    one
}

/// Impulses on the wall over time [ms, kg mm/ms].
fn impulses(ended: &Ended) -> Vec<[f64; 2]> {
    let text = fs::read_to_string(ended.out().join("walls.csv")).expect("a history of the wall");
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let number = |text: &str| text.parse::<f64>().expect("a number");
    rows.map(|row| [number(row[0]), number(row[3])]).collect()
}

/// A block of either honeycomb between a mass and a wall is crushed along its axis a with the force
/// of its curve; it follows from the motion of the mass, `M x'' = -A f(x/L)`.
#[test]
fn a_block_between_a_mass_and_a_wall_has_the_force_of_its_curve() {
    for name in ["*MAT_HONEYCOMB", "*MAT_MODIFIED_HONEYCOMB"] {
        let card = format!(
            "{name}\n1,8e-8,70.0,0.3,0.2,0.1\n1,2,2,2\n1.0,0.1,0.1,0.3,0.1,0.1,2.0\n\
             0,0,0,0.0,1.0,0.0\n0.0,1.0,1.0\n"
        );
        let ended = on_three(&block(&card));
        let rows = impulses(&ended);
        let at = |time: f64| {
            let near =
                rows.iter().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs()));
            *near.expect("a row")
        };
        let ([from, before], [to, after]) = (at(0.3), at(1.4));
        let (mut x, mut v, mut time, mut impulse) = (0.0, SPEED, 0.0, 0.0);
        let dt = 1e-5;
        while time < to {
            let force = WIDTH * WIDTH * (CRUSH[0] + CRUSH[1] * x / LENGTH);
            impulse += if time >= from { dt * force } else { 0.0 };
            v -= dt * force / MASS;
            x += dt * v;
            time += dt;
        }
        let got = (after - before).abs();
        // The block has 0.6 % of the mass. Without a bulk viscosity the measured value was 0.2 %;
        // the default one adds 3 %, since it follows the modulus of compaction.
        assert!((got / impulse - 1.0).abs() < 5e-3, "{name}: {got} for {impulse}");
        assert!(x > 0.2 * LENGTH, "it is crushed far: {x}");
    }
}
