//! Writes masses, constraints and initial velocities as cards.

use super::writer::exact_quotient;
use super::{Blank, CardValue, DeckWriter, Id, Number, list};
use crate::input::deck::convert::space::cosines;
use crumple_proto::job::{InitialVelocity, Job, Symmetry};

/// Writes the initial state of the model.
pub fn write(deck: &mut DeckWriter, job: &Job, set: impl Fn(&str) -> CardValue) {
    for (mass, id) in job.mass.iter().zip(1..) {
        deck.keyword("ELEMENT_MASS_NODE_SET");
        deck.card(&[Id(id), set(&mass.nodes), Number(mass.mass)]);
    }
    for fix in &job.fix {
        deck.keyword("BOUNDARY_SPC_SET");
        let held = ["x", "y", "z", "rx", "ry", "rz"]
            .map(|d| Id(u64::from(fix.dofs.iter().any(|f| f == d))));
        deck.card(&[&[set(&fix.nodes), Blank], held.as_slice()].concat());
    }
    planes(deck, &job.symmetry);
    velocities(deck, &job.initial_velocity, set);
}

/// Writes planes of symmetry.
fn planes(deck: &mut DeckWriter, planes: &[Symmetry]) {
    for plane in planes {
        let of = |c: &usize| plane.normal[*c].abs();
        let axis = (0..3).max_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or(0);
        // The displacement along the normal, and the rotations about the other two axes.
        let (dir, turns) = [(1, 5), (2, 6), (3, 4)][axis];
        deck.keyword("CONSTRAINED_GLOBAL");
        let head = [Id(dir), Id(turns), Id(dir)];
        let tail = [Number(plane.tolerance)];
        deck.card(&[&head[..], &plane.point.map(Number), &tail].concat());
    }
}

/// Writes initial velocities. A later one overrides an earlier one, so that all of them have the
/// same card, or none.
fn velocities(deck: &mut DeckWriter, all: &[InitialVelocity], set: impl Fn(&str) -> CardValue) {
    if all.iter().all(|v| v.spin == [0.0; 3]) {
        for initial in all {
            deck.keyword("INITIAL_VELOCITY");
            deck.card(&[initial.nodes.as_deref().map_or(Blank, &set)]);
            deck.card(&initial.velocity.map(Number));
        }
        return;
    }
    let turns: Option<Vec<(f64, [f64; 3])>> = all.iter().map(|v| turn(v.spin)).collect();
    let Some(turns) = turns else { return list(deck, "initial_velocity", all) };
    for (initial, (speed, along)) in all.iter().zip(turns) {
        let of = match &initial.nodes {
            Some(nodes) => [set(nodes), Id(3)],
            None => [Id(0), Id(3)],
        };
        deck.keyword("INITIAL_VELOCITY_GENERATION");
        let first = [of[0], of[1], Number(speed)];
        deck.card(&[&first[..], &initial.velocity.map(Number)].concat());
        deck.card(&[&initial.centre.map(Number)[..], &along.map(Number)].concat());
    }
}

/// Returns speed and direction of a rotation, if a reader has the same bits by them.
fn turn(spin: [f64; 3]) -> Option<(f64, [f64; 3])> {
    /// Largest number of neighbours of the speed to try; their directions have unit length.
    const TRIED: usize = 1000;
    let speed = spin.iter().map(|c| c * c).sum::<f64>().sqrt();
    if speed == 0.0 {
        return Some((0.0, [0.0; 3]));
    }
    let above = std::iter::successors(Some(speed), |x| Some(x.next_up()));
    let below = std::iter::successors(Some(speed.next_down()), |x| Some(x.next_down()));
    let speeds = above.zip(below).take(TRIED).flat_map(|(x, y)| [x, y]);
    let mut found = speeds.filter_map(|speed| {
        let [x, y, z] = spin.map(|c| exact_quotient(c, speed));
        Some((speed, [x?, y?, z?]))
    });
    found.find(|&(speed, along)| cosines(along).is_some_and(|read| read.map(|c| c * speed) == spin))
}
