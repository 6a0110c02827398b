//! Springs along directions that follow two nodes, and springs in planes normal to a direction,
//! `*DEFINE_SD_ORIENTATION`, against closed forms. A free rigid cube turns about z at a constant
//! rate; nodes 1 and 2 are along its x axis, 1 and 5 along z. Units mm, ms, kg.

use crate::base::{BASE, STEEL, assert_refused, assert_same_when_written, model_of};
use crumple_proto::ids::NodeId;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::engine::Engine;

/// Rate of the cube [1/ms], and the end of the runs [ms].
const SPIN: f64 = 3.0;
const END: f64 = 0.5;

/// Returns the base with a cube that turns, a section and part 3 of springs of the material 11, and
/// more lines. Node 21 has the mass 0.02 kg.
fn deck(rotational: i32, law: &str, lines: &str) -> String {
    let base = BASE.replace("\n10.0\n", &format!("\n{END}\n")).replace("cube\n2,2,1\n", "");
    format!(
        "{base}{STEEL}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*PART_INERTIA\ncube\n2,2,2\n\
         5.0,5.0,5.0,0.00785\n0.3,0.0,0.0,0.3,0.0,0.3\n0.0,0.0,0.0,0.0,0.0,{SPIN}\n\
         *PART\nlink\n3,3,11\n*SECTION_DISCRETE\n3,{rotational}\n\n{law}\
         *NODE\n21,50.0,0.0,0.0\n*ELEMENT_MASS\n1,21,0.02\n{lines}"
    )
}

fn velocity(engine: &Engine, id: u64) -> [f64; 3] {
    let n = engine.nodes.local_index(NodeId(id)).expect("a node") as usize;
    std::array::from_fn(|c| engine.nodes.v[n][c])
}

/// A damper c between the ground and a mass m acts along `e = (cos w t, sin w t)`. In axes that
/// turn with e, the velocity (p, q) obeys `p' = -c/m p + w q`, `q' = -w p`, so
/// `p'' + c/m p' + w^2 p = 0`.
#[test]
fn a_damper_turns_with_its_nodes() {
    let (c, m, v0) = (0.05, 0.02, 2.0);
    let lines = "*ELEMENT_DISCRETE\n101,3,21,0,7\n*DEFINE_SD_ORIENTATION\n7,2,0,0,0,1,2\n\
                 *INITIAL_VELOCITY_NODE\n21,2.0,0.0,0.0\n";
    let text = deck(0, "*MAT_DAMPER_VISCOUS\n11,0.05\n", lines);
    let model = model_of(&text);
    let (decay, mut worst) = (0.5 * c / m, 0.0f64);
    let rate = (SPIN * SPIN - decay * decay).sqrt();
    let end = run_alone(&model, |engine| {
        // Velocities belong to the middle of the last step.
        let time = engine.clock.time - 0.5 * engine.clock.last_dt;
        let (cos, sin, fade) = ((rate * time).cos(), (rate * time).sin(), (-decay * time).exp());
        let p = v0 * fade * (cos - decay / rate * sin);
        // q' = -w p with q(0) = 0 gives this q, by p' = -c/m p + w q.
        let slope = -v0 * fade * (2.0 * decay * cos + (rate - decay * decay / rate) * sin);
        let q = (slope + 2.0 * decay * p) / SPIN;
        let (cos, sin) = ((SPIN * time).cos(), (SPIN * time).sin());
        let expected = [cos * p - sin * q, sin * p + cos * q];
        let v = velocity(engine, 21);
        (0..2).for_each(|k| worst = worst.max((v[k] - expected[k]).abs()));
    });
    println!("largest error {worst:.1e} of {v0}");
    // Damping is delayed by half a step: c dt/(2 m) = 2e-3 of the velocity.
    assert!(worst < 5e-3, "{worst}");
    let energy = end.ledger.energies(&end.nodes, &end.blocks).values();
    let [x, y, _] = velocity(&end, 21);
    let lost = 0.5 * m * (v0 * v0 - x * x - y * y);
    println!("energy {:.1e}", energy.internal / lost - 1.0);
    assert!((energy.internal / lost - 1.0).abs() < 5e-3, "{} of {lost}", energy.internal);
    let digest = |workers| run_side_by_side(&model, workers, 1_000_000, 7).digest();
    let one = run_side_by_side(&model, 1, 1_000_000, 0).digest();
    assert_eq!(digest(2), one);
    assert_eq!(digest(3), one);
    assert_same_when_written(&text, "end_time=0.05", "*DEFINE_SD_ORIENTATION");
}

/// The line of a spring between fixed nodes along y, in the plane normal to a direction that turns
/// by w t from x, has the length `L |cos w t|`.
#[test]
fn a_line_is_projected_along_a_direction_that_turns() {
    let lines = "*NODE\n22,50.0,10.0,0.0\n*ELEMENT_DISCRETE\n101,3,21,22,7\n\
                 *DEFINE_SD_ORIENTATION_TITLE\naxis\n7,3,0,0,0,1,2\n\
                 *BOUNDARY_SPC_NODE\n21,0,1,1,1,1,1,1\n22,0,1,1,1,1,1,1\n";
    let text = deck(0, "*MAT_SPRING_ELASTIC\n11,4.0\n", lines);
    let (mut worst, mut count) = (0.0f64, 0);
    run_alone(&model_of(&text), |engine| {
        let time = engine.clock.time - engine.clock.last_dt; // forces are those before the step
        let of_spring = |b: &&crumple_worker::fem::blocks::Block| {
            b.element.names().contains(&"direction x".to_string())
        };
        let block = engine.blocks.blocks.iter().find(of_spring).expect("springs");
        let force: Vec<f64> = (2..5).map(|column| block.state(0).at(column)).collect();
        let (cos, sin) = ((SPIN * time).cos(), (SPIN * time).sin());
        // Along y - n (n . y), n = (cos, sin).
        let amount = 4.0 * 10.0 * (cos.abs() - 1.0);
        let expected = [-sin * cos.signum() * amount, cos.abs() * amount, 0.0];
        (0..3).for_each(|c| worst = worst.max((force[c] - expected[c]).abs()));
        count += 1;
    });
    println!("largest error {worst:.1e} of 40 in {count} steps");
    // The turn of the body in a step is off by (w dt)^3/12.
    assert!(count > 100 && worst < 1e-3, "{worst}");
    assert_same_when_written(&text, "end_time=0.05", "*DEFINE_SD_ORIENTATION");
}

/// A spring whose nodes are apart along x and z acts in the plane normal to z: it swings along x
/// with `sqrt(k/m)`, and nothing holds its motion along z.
#[test]
fn a_spring_acts_in_the_plane_normal_to_a_vector() {
    let lines = "*NODE\n22,40.0,0.0,30.0\n*ELEMENT_DISCRETE\n101,3,22,21,7\n\
                 *DEFINE_SD_ORIENTATION\n7,1,0,0,5.0\n\
                 *BOUNDARY_SPC_NODE\n22,0,1,1,1,1,1,1\n*INITIAL_VELOCITY_NODE\n21,1.0,0.0,-3.0\n";
    let text = deck(0, "*MAT_SPRING_ELASTIC\n11,0.8\n", lines);
    let rate = (0.8f64 / 0.02).sqrt();
    let mut worst = 0.0f64;
    run_alone(&model_of(&text), |engine| {
        let time = engine.clock.time;
        let n = engine.nodes.local_index(NodeId(21)).expect("the mass") as usize;
        let x = engine.nodes.x[n];
        let expected = [50.0 + (rate * time).sin() / rate, 0.0, -3.0 * time];
        (0..3).for_each(|c| worst = worst.max((x[c] - expected[c]).abs()));
    });
    println!("largest error {worst:.1e} of {:.2}", 1.0 / rate);
    // The period is off by (w dt)^2/24 = 5e-6.
    assert!(worst < 1e-5, "{worst}");
    assert_same_when_written(&text, "end_time=0.05", "*DEFINE_SD_ORIENTATION");
}

/// A rotational damper about the axis of the body slows it: `w = w0 exp(-c t/I)`.
#[test]
fn a_rotational_damper_follows_the_axis_of_a_body() {
    let lines = "*ELEMENT_DISCRETE\n101,3,1,0,7\n*DEFINE_SD_ORIENTATION\n7,2,0,0,0,1,5\n";
    // No element has the node of the mass here.
    let text = deck(1, "*MAT_DAMPER_VISCOUS\n11,0.6\n", lines);
    let text = text.replace("*ELEMENT_MASS\n1,21,0.02\n", "");
    let end = run_alone(&model_of(&text), |_| {});
    let spin = end.constraints.bodies.bodies[0].last_spin.z;
    let time = end.clock.time - 0.5 * end.clock.last_dt;
    let expected = SPIN * (-0.6 * time / 0.3).exp();
    println!("spin {spin}, {expected}, {:.1e}", spin / expected - 1.0);
    // Damping is delayed by half a step: c dt/(2 I) = 2e-3.
    assert!((spin / expected - 1.0).abs() < 5e-3, "{spin} of {expected}");
}

/// Directions without nodes, and nodes that no element has, are named.
#[test]
fn wrong_directions_are_named() {
    let law = "*MAT_SPRING_ELASTIC\n11,4.0\n";
    let with = |card: &str| {
        deck(0, law, &format!("*ELEMENT_DISCRETE\n101,3,21,0,7\n*DEFINE_SD_ORIENTATION\n{card}\n"))
    };
    for (card, words) in [
        ("7,2,0,0,0,1", "vid 7 has no direction"),
        ("7,4,1,0,0", "vid 7 has no direction"),
        ("7,1", "vid 7 has no direction"),
        ("7,2,0,0,0,1,99", "follows node 99, which no element has"),
        ("7,2,0,0,0,1,1", "which are at one place"),
        ("7,1,0,0,1", "give their part a `spring.direction`"),
    ] {
        assert_refused(&with(card), &[words]);
    }
}
