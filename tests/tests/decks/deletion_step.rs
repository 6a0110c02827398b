//! Elements that are deleted by their stable step, `tdel` of plastic materials. Units mm, ms, kg,
//! so kN and J.

use crate::base::{BASE, MOVES, assert_refused, model_of};
use crumple::input::check::describe;
use crumple_tests::program::{Ended, crumple_with, run};
use std::fs;

/// Side of a cube [mm], Young's modulus [GPa], density [kg/mm^3].
const SIDE: f64 = 10.0;
const E: f64 = 200.0;
const DENSITY: f64 = 8e-6;

/// Returns a deck with `count` cubes apart from each other, without Poisson's ratio and viscosity,
/// that stay elastic. Their tops move down by 0.3 sides within 1 ms, in the ratio of their number.
fn cubes(count: usize, tdel: f64, control: &str) -> String {
    let mut nodes = String::new();
    let mut rest = String::new();
    for cube in 0..count {
        let (first, x0) = (8 * cube, 3.0 * SIDE * cube as f64);
        for corner in 0..8 {
            let x = x0 + if [1, 2, 5, 6].contains(&corner) { SIDE } else { 0.0 };
            let y = if [2, 3, 6, 7].contains(&corner) { SIDE } else { 0.0 };
            let z = if corner > 3 { SIDE } else { 0.0 };
            nodes += &format!("{},{x},{y},{z}\n", first + corner + 1);
        }
        let ids: Vec<String> = (1..=8).map(|n| (first + n).to_string()).collect();
        let scale = -0.3 * SIDE * (cube + 1) as f64 / count as f64;
        let [low, top] = [&ids[..4], &ids[4..]].map(|ids| ids.join(","));
        let [cube, below] = [cube + 1, cube + 1001];
        rest += &format!(
            "*ELEMENT_SOLID\n{cube},1,{}\n*SET_NODE_LIST\n{cube}\n{top}\n\
             *SET_NODE_LIST\n{below}\n{low}\n\
             *BOUNDARY_PRESCRIBED_MOTION_SET\n{cube},3,2,9,{scale}\n\
             *BOUNDARY_SPC_SET\n{cube},0,1,1\n{below},0,1,1,1\n",
            ids.join(","),
        );
    }
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*CONTROL_BULK_VISCOSITY\n1e-9,1e-9\n{control}\
         *PART\ncubes\n1,1,1\n*SECTION_SOLID\n1,1\n\
         *MAT_PIECEWISE_LINEAR_PLASTICITY\n1,{DENSITY},{E},0.0,1000.0,0.0,0.0,{tdel}\n\n\n\n\
         *DEFINE_CURVE\n9\n0,0\n1,1\n2,2\n*NODE\n{nodes}{rest}*END\n"
    )
}

fn ran(deck: &str, workers: &str) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, deck).unwrap();
    let path = path.to_str().unwrap();
    let args = ["run", path, "--workers", workers, "--set", "output.field_interval=-1"];
    run(crumple_with(&args)).with_code(0)
}

/// Work on a cube up to a ratio of heights r without lateral strain and with nu = 0: the stress
/// E ln r on an area that does not change [J].
fn work(ratio: f64) -> f64 {
    E * SIDE.powi(3) * (ratio * ratio.ln() - ratio + 1.0)
}

/// With nu = 0 the step of a cube of height r h is `sqrt(r) h sqrt(rho/E)`: it is shorter by r, and
/// waves are slower by the density, which rises as 1/r. So a tdel of a fraction f of the first step
/// deletes the cube at r = f^2. Its energy stays from then on.
#[test]
fn a_cube_is_deleted_at_the_height_at_which_its_step_is_too_short() {
    let first = SIDE * (DENSITY / E).sqrt();
    let scaled = |factor: f64| format!("*CONTROL_TIMESTEP\n0,0.9,0,0,{}\n", -factor * first);
    // Added mass makes the step longer by its root: tdel counts with it.
    for (fraction, longer, control) in
        [(0.9, 1.0, String::new()), (0.95, 1.0, String::new()), (1.8, 2.0, scaled(2.0))]
    {
        let ended = ran(&cubes(1, fraction * first, &control), "1");
        let part = &ended.summary()["parts"][0];
        assert_eq!((part["failed"].as_u64(), part["inverted"].as_u64()), (Some(1), Some(1)));
        let ratio = (fraction / longer).powi(2);
        let (energy, expected) = (part["internal"].as_f64().expect("a number"), work(ratio));
        // The step in which the cube goes adds no work: r changes by 0.3 * 0.9 * h/c in a step, and
        // the work by E |ln r| times that.
        let step = 0.3 * 0.9 * longer * first;
        let tolerance = E * SIDE.powi(3) * ratio.ln().abs() * step / expected + 2e-3;
        let error = energy / expected - 1.0;
        println!(
            "fraction {fraction}: {energy} J, {expected} J, error {error:.2e}, {tolerance:.1e}"
        );
        assert!((-tolerance..2e-3).contains(&error), "{energy} of {expected}");
    }
    // Without it the cube carries to the end.
    let whole = ran(&cubes(1, 0.0, ""), "1");
    let part = &whole.summary()["parts"][0];
    assert_eq!(part["failed"].as_u64(), Some(0));
    // The last work is that of the step before the end: 38 of 10066 J.
    assert!((part["internal"].as_f64().unwrap() / work(0.7) - 1.0).abs() < 6e-3);
}

/// Cubes that are deleted at other times give the same bits on any number of workers.
#[test]
fn deletion_by_the_step_is_the_same_on_any_workers() {
    let deck = cubes(6, 0.9 * SIDE * (DENSITY / E).sqrt(), "");
    let runs = ["1", "2", "4"].map(|workers| ran(&deck, workers));
    // Cubes k of 6 reach r = 1 - 0.05 k, and are deleted at 0.81.
    assert_eq!(runs[0].summary()["parts"][0]["failed"].as_u64(), Some(3));
    runs.iter().for_each(|ended| assert_eq!(ended.digest(), runs[0].digest()));
}

/// All parts of shells and solids of the material have the step; a beam does not, with a word.
#[test]
fn tdel_becomes_a_step_of_parts() {
    let law = "*MAT_024\n1,7.85e-6,207.0,0.3,0.25,1.0,0.0,1e-5\n\n\n\n";
    let model = model_of(&format!("{BASE}{MOVES}{law}"));
    for part in &model.settings.parts {
        let step = part.parameters.get("deletion_step").and_then(|step| step.number());
        assert_eq!(step, Some(1e-5), "part {}", part.id);
    }
    let beams = "*PART\nbeam\n3,3,1\n*SECTION_BEAM\n3,1,1.0,2,1\n2.0,2.0,0.0,0.0\n\
                 *ELEMENT_BEAM\n1,3,1,11,2\n";
    let said = describe(&model_of(&format!("{BASE}{MOVES}{law}{beams}")));
    assert!(said.contains("part 3: tdel 0.00001 -> not used: only shells and solids"), "{said}");
    let negative = law.replace("1e-5", "-1e-5");
    assert_refused(&format!("{BASE}{MOVES}{negative}"), &["`tdel`", "a step below 0"]);
}
