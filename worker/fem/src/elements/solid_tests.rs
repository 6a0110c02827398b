//! Tests of tetrahedra with four and ten nodes and of wedges: rigid motion, patches, balance,
//! energy, stable step, lanes.

use super::solid_testing::block;
use super::testing::*;
use crumple_proto::job::Part;
use crumple_proto::mesh::{EDGES_OF_TET10, OwnSection};
use crumple_proto::partition::{Material, Param};
use std::collections::BTreeMap;

const E: f64 = 1e6;
const NU: f64 = 0.25;

/// Returns cubes cut into six tetrahedra each, around their diagonals.
fn tetrahedra_of(cells: &[[u32; 8]]) -> Vec<[u32; 4]> {
    let cut = |c: &[u32; 8]| {
        let around = [1, 2, 3, 7, 4, 5];
        let of = |i: usize| [c[0], c[around[i]], c[around[(i + 1) % 6]], c[6]];
        std::array::from_fn::<_, 6, _>(of)
    };
    cells.iter().flat_map(cut).collect()
}

/// Returns cubes cut into two wedges each.
fn wedges_of(cells: &[[u32; 8]]) -> Vec<[u32; 6]> {
    let cut =
        |c: &[u32; 8]| [[c[0], c[1], c[2], c[4], c[5], c[6]], [c[0], c[2], c[3], c[4], c[6], c[7]]];
    cells.iter().flat_map(cut).collect()
}

/// Returns tetrahedra with nodes in the middle of their edges, which are added to the nodes.
fn with_middles(nodes: &mut Vec<[f64; 3]>, cells: &[[u32; 4]]) -> Vec<[u32; 10]> {
    let mut known = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *known.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [from, to] = [a, b].map(|n| nodes[n as usize]);
            nodes.push([0, 1, 2].map(|i| 0.5 * (from[i] + to[i])));
            nodes.len() as u32 - 1
        })
    };
    let of = |c: &[u32; 4]| {
        let on_edges = EDGES_OF_TET10.map(|[a, b]: [usize; 2]| middle(c[a], c[b]));
        std::array::from_fn(|n| if n < 4 { c[n] } else { on_edges[n - 4] })
    };
    cells.iter().map(of).collect()
}

fn tetrahedron() -> Part {
    part_of("tetrahedron", 0.0).with("pressure", "element").with("bulk_viscosity", [0.0; 2])
}

fn wedge() -> Part {
    part_of("wedge", 0.0).with("pressure", "element").with("bulk_viscosity", [0.0; 2])
}

fn quadratic_tetrahedron() -> Part {
    part_of("quadratic_tetrahedron", 0.0).with("bulk_viscosity", [0.0; 2])
}

/// Returns a unit cube of eight cubes whose nodes are displaced by noise up to `by`.
fn distorted(by: f64) -> (Vec<[f64; 3]>, Vec<[u32; 8]>) {
    let (mut nodes, cells) = block([2, 2, 2], [1.0; 3]);
    let mut noise = Noise(11);
    nodes.iter_mut().flatten().for_each(|c| *c += by * noise.next());
    (nodes, cells)
}

fn tetrahedra(by: f64, law: Material) -> Patch<4> {
    let (nodes, cells) = distorted(by);
    Patch::new(tetrahedron(), law, &nodes, &tetrahedra_of(&cells))
}

fn wedges(by: f64, law: Material) -> Patch<6> {
    let (nodes, cells) = distorted(by);
    Patch::new(wedge(), law, &nodes, &wedges_of(&cells))
}

fn quadratic_tetrahedra(by: f64, law: Material) -> Patch<10> {
    let (mut nodes, cells) = distorted(by);
    let cells = with_middles(&mut nodes, &tetrahedra_of(&cells));
    Patch::new(quadratic_tetrahedron(), law, &nodes, &cells)
}

fn shake<const C: usize>(patch: &mut Patch<C>, size: f64) {
    let mut noise = Noise(5);
    patch.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = size * noise.next()));
}

fn largest_stress<const C: usize>(patch: &Patch<C>) -> f64 {
    let all = (0..patch.cells.len()).flat_map(|e| patch.fields(e).stress);
    all.fold(0.0, |m: f64, s| m.max(s.abs()))
}

pub fn turn_once<const C: usize>(mut patch: Patch<C>) {
    let angle = [0.48, -0.64, 0.6].map(|c| c * std::f64::consts::TAU / 100.0);
    for step in 1..=100 {
        patch.go(|x| rotate(angle, x.map(|c| c + 0.01)));
        let (stress, force) = (largest_stress(&patch), patch.largest().0);
        assert!(stress < 1e-10 * E && force < 1e-10 * E, "step {step}: {stress:e} {force:e}");
    }
}

/// A rigid rotation with translation leaves no stress and no force.
#[test]
fn rigid_rotation_leaves_no_stress() {
    turn_once(tetrahedra(0.1, elastic(E, NU, 1.0)));
    turn_once(wedges(0.1, elastic(E, NU, 1.0)));
    turn_once(quadratic_tetrahedra(0.1, elastic(E, NU, 1.0)));
}

fn stretch<const C: usize>(mut patch: Patch<C>) {
    let size = 1e-12;
    for (v, x) in patch.v.iter_mut().zip(&patch.x) {
        let half = 0.5 * size * (x[0] + x[1] + x[2]);
        (0..3).for_each(|i| v[i] = half + 0.5 * size * x[i]);
    }
    patch.forces(1.0);
    for element in 0..patch.cells.len() {
        let stress = patch.fields(element).stress.map(|s| s * 1e-3 / size);
        for (c, stress) in stress.into_iter().enumerate() {
            let wanted = if c < 3 { 2000.0 } else { 400.0 };
            assert_close(stress, wanted, 1e-10 * wanted, "round-off, and a strain of 1e-12");
        }
    }
    let (inner, largest) = (patch.nodal().0[13], patch.largest().0);
    assert!(inner.iter().all(|f| f.abs() < 1e-10 * largest), "{inner:?} of {largest}");
}

/// Verification A21: a linear field gives one stress in all distorted elements, and the middle node
/// is in equilibrium.
#[test]
fn distorted_patch_is_exact() {
    stretch(tetrahedra(0.1, elastic(E, NU, 1.0)));
    stretch(wedges(0.1, elastic(E, NU, 1.0)));
    stretch(quadratic_tetrahedra(0.1, elastic(E, NU, 1.0)));
}

pub fn swing<const C: usize>(mut patch: Patch<C>) {
    let dt = 1e-3;
    let (mut work, mut booked, mut peak) = (0.0, 0.0, 0.0_f64);
    shake(&mut patch, 0.02);
    for step in 0..1000 {
        if step == 500 {
            assert_close(booked, work, 1e-3 * work, "strain steps of 2e-5; forces at two times");
            patch.v.iter_mut().flatten().for_each(|v| *v = -*v);
        }
        let before = patch.power();
        let totals = patch.step(dt);
        work += 0.5 * dt * (before + patch.power());
        booked += totals.internal + totals.hourglass;
        peak = peak.max(booked);
        let (force, moment) = patch.sums();
        let largest = patch.largest().0.max(1.0);
        let sums = force.iter().chain(&moment).fold(0.0, |m: f64, s| m.max(s.abs()));
        assert!(sums < 1e-11 * largest, "round-off: {force:?} {moment:?}");
    }
    assert!(peak > 0.0 && booked.abs() < 1e-6 * peak, "elastic: {booked:e} of {peak:e}");
}

/// Forces and moments of the elements balance in any motion, and the work that is booked is theirs.
#[test]
fn forces_balance_and_do_the_work_that_is_booked() {
    swing(tetrahedra(0.15, elastic(E, NU, 1.0)));
    swing(wedges(0.15, elastic(E, NU, 1.0)));
    swing(quadratic_tetrahedra(0.15, elastic(E, NU, 1.0)));
}

/// Returns the largest velocity after 2000 steps over that at the start.
pub fn growth<const C: usize>(mut patch: Patch<C>, dt: f64) -> f64 {
    let masses = patch.masses();
    shake(&mut patch, 1e-9);
    let fastest = |patch: &Patch<C>| patch.v.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    for _ in 0..2000 {
        patch.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| {});
        let now = fastest(&patch);
        if now.is_nan() || now > 1e-3 {
            break;
        }
    }
    fastest(&patch) / 1e-9
}

/// Elements are stable at their own step, and the true limit is not far above it. The limit is that
/// of a block of equal elements, which is above that of a single one.
#[test]
fn the_stable_step_is_below_the_limit_and_near_it() {
    for nu in [0.0, 0.3, 0.45] {
        for size in [[2.0, 2.0, 2.0], [2.0, 2.0, 0.4]] {
            let (nodes, cells) = block([2, 2, 2], size);
            let law = || elastic(1.0, nu, 1.0);
            let tetrahedra = || Patch::new(tetrahedron(), law(), &nodes, &tetrahedra_of(&cells));
            let wedges = || Patch::new(wedge(), law(), &nodes, &wedges_of(&cells));
            let dt = tetrahedra().stable_dt();
            let [below, above] = [0.99, 1.7].map(|share| growth(tetrahedra(), share * dt));
            assert!(below < 100.0 && above > 1e4, "tetrahedra {nu} {size:?}: {below:e} {above:e}");
            let dt = wedges().stable_dt();
            let [below, above] = [0.99, 1.7].map(|share| growth(wedges(), share * dt));
            assert!(below < 100.0 && above > 1e4, "wedges {nu} {size:?}: {below:e} {above:e}");
            let mut nodes = nodes.clone();
            let cells = with_middles(&mut nodes, &tetrahedra_of(&cells));
            let quadratic = || Patch::new(quadratic_tetrahedron(), law(), &nodes, &cells);
            let dt = quadratic().stable_dt();
            let [below, above] = [0.99, 1.5].map(|share| growth(quadratic(), share * dt));
            assert!(below < 100.0 && above > 1e4, "ten nodes {nu} {size:?}: {below:e} {above:e}");
        }
    }
}

/// A single regular ten-node tetrahedron: its step is at least 0.76 of that at which it becomes
/// unstable, and below it. Distorted ones with curved edges are stable at their own step.
#[test]
fn the_step_of_a_regular_ten_node_tetrahedron_is_near_its_limit() {
    let mut nodes = vec![[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
    let cells = with_middles(&mut nodes, &[[0, 1, 2, 3]]);
    for nu in [0.0, 0.3, 0.49] {
        let single = || Patch::new(quadratic_tetrahedron(), elastic(1.0, nu, 1.0), &nodes, &cells);
        let dt = single().stable_dt();
        let [below, above] = [0.995, 1.0 / 0.76].map(|share| growth(single(), share * dt));
        assert!(below < 100.0 && above > 1e4, "{nu}: {below:e} {above:e}");
        for seed in 1..20 {
            let mut noise = Noise(seed);
            let mut moved = nodes.clone();
            let by = |n: usize| if n < 4 { 0.5 } else { 0.1 };
            moved.iter_mut().enumerate().for_each(|(n, x)| {
                x.iter_mut().for_each(|c| *c += by(n) * noise.next());
            });
            let curved =
                || Patch::new(quadratic_tetrahedron(), elastic(1.0, nu, 1.0), &moved, &cells);
            let dt = curved().stable_dt();
            if dt.is_nan() {
                continue; // inverted
            }
            let below = growth(curved(), 0.995 * dt);
            assert!(below < 100.0, "{nu}, seed {seed}: {below:e}");
        }
    }
}

/// Ten-node tetrahedra represent a quadratic displacement: a bar of one layer in pure bending has
/// the curvature of the beam. Corner and edge nodes have their shares of the mass.
#[test]
fn ten_node_tetrahedra_bend_exactly() {
    let (mut nodes, cells) = block([3, 1, 1], [3.0, 1.0, 1.0]);
    let cells = with_middles(&mut nodes, &tetrahedra_of(&cells));
    let mut bar = Patch::new(quadratic_tetrahedron(), elastic(E, NU, 1.0), &nodes, &cells);
    let mass: Vec<f64> = bar.masses().iter().map(|m| m.0).collect();
    assert_close(mass.iter().sum(), 3.0, 1e-14, "the mass of the bar");
    let kappa = 1e-8;
    // Pure bending about z (Timoshenko & Goodier 1970, sec. 102), with y from the middle.
    bar.go(|[x, y, z]| {
        let (y0, z0) = (y - 0.5, z - 0.5);
        [
            x + kappa * x * y0,
            y - 0.5 * kappa * (x * x + NU * (y0 * y0 - z0 * z0)),
            z - NU * kappa * y0 * z0,
        ]
    });
    let (force, _) = bar.nodal();
    let moment: f64 = (0..nodes.len())
        .filter(|&n| nodes[n][0] == 3.0)
        .map(|n| (nodes[n][1] - 0.5) * force[n][0])
        .sum();
    assert_close(moment, E * kappa / 12.0, 1e-6 * E * kappa, "E I kappa");
    let largest = bar.largest().0;
    for n in (0..nodes.len()).filter(|&n| nodes[n][0] > 0.0 && nodes[n][0] < 3.0) {
        let at_rest = force[n].iter().all(|f| f.abs() < 1e-6 * largest);
        assert!(at_rest, "node {n} at {:?}: {:?} of {largest:e}", nodes[n], force[n]);
    }
}

/// The triangles of a wedge that turn against each other meet the torsional stiffness of a prism.
#[test]
fn a_wedge_resists_the_twist_that_its_points_do_not_see() {
    let (height, angle) = (2.0, 1e-6);
    let corner = |k: usize, z: f64| {
        let phi = std::f64::consts::TAU * k as f64 / 3.0;
        [phi.cos(), phi.sin(), z]
    };
    let nodes: Vec<_> = (0..6).map(|k| corner(k % 3, height * (k / 3) as f64)).collect();
    let mut prism = Patch::new(wedge(), elastic(E, NU, 1.0), &nodes, &[[0, 1, 2, 3, 4, 5]]);
    prism.go(|x| rotate([0.0, 0.0, if x[2] > 0.0 { angle } else { -angle }], x));
    let moment = (3..6).map(|c| {
        let (force, x) = (prism.corner(0, c).0, nodes[c]);
        x[0] * force[1] - x[1] * force[0]
    });
    // The side is sqrt 3; the torsional constant is sqrt(3)/80 a^4.
    let (side, shear): (f64, f64) = (3.0_f64.sqrt(), E / (2.0 * (1.0 + NU)));
    let wanted = shear * 3.0_f64.sqrt() / 80.0 * side.powi(4) * 2.0 * angle / height;
    assert_close(moment.sum(), wanted, 1e-4 * wanted, "small angles");
}

pub fn alone<const C: usize>(law: &Material, mut all: Patch<C>, part: Part) {
    let nodes: Vec<[f64; 3]> = all.x.iter().map(|x| [x[0], x[1], x[2]]).collect();
    let cell = |e: usize| Patch::new(part.clone(), law.clone(), &nodes, &[all.cells[e]]);
    let mut single: Vec<Patch<C>> = (0..all.cells.len()).map(cell).collect();
    let mut noise = Noise(9);
    for _ in 0..40 {
        for v in &mut all.v {
            let size = 0.03 * noise.next();
            (0..3).for_each(|i| v[i] = size * noise.next());
        }
        let together = all.step(0.01);
        let mut stable_dt = f64::INFINITY;
        for (e, one) in single.iter_mut().enumerate() {
            one.v.clone_from(&all.v);
            stable_dt = stable_dt.min(one.step(0.01).stable_dt);
            let bits = |row: Vec<f64>| row.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            let [wide, own] = [all.history.element(e), one.history.element(0)];
            assert_eq!(bits(wide.to_vec()), bits(own.to_vec()), "{} element {e}", law.law);
            (0..C).for_each(|c| assert_eq!(all.corner(e, c), one.corner(0, c)));
        }
        assert_eq!(together.stable_dt.to_bits(), stable_dt.to_bits());
    }
}

/// All laws: each lane gives the result of its element alone, with elements next to each other that
/// yield and fail.
#[test]
fn every_lane_is_what_it_would_be_alone() {
    for law in laws_of_solids() {
        alone(&law, tetrahedra(0.1, law.clone()), tetrahedron());
        if law.law != "fluid" {
            alone(&law, wedges(0.1, law.clone()), wedge());
        }
        alone(&law, quadratic_tetrahedra(0.1, law.clone()), quadratic_tetrahedron());
    }
}

fn pull<const C: usize>(mut patch: Patch<C>) {
    for step in 0..100 {
        patch.go(|x| [1.002 * x[0], x[1], x[2]]);
        if step == 5 {
            assert!(patch.largest().0 > 1.0 && !patch.fields(0).failed);
        }
    }
    let totals = patch.go(|x| [3.0 * x[0], x[1], x[2]]);
    let fields = (0..patch.cells.len()).map(|e| patch.fields(e)).collect::<Vec<_>>();
    assert!(fields.iter().all(|f| f.failed && f.von_mises == 0.0));
    assert_eq!((patch.largest().0, totals.internal, totals.trouble), (0.0, 0.0, None));
    assert_eq!(totals.stable_dt, f64::INFINITY);
}

/// Checks that an inverted element of a part that deletes them fails, also one whose step is too
/// short, and that one with coordinates that are not finite does not.
fn lose<const C: usize>(make: impl Fn(Part) -> Patch<C>, part: &Part, law: &str) {
    let mirrored = |x: [f64; 3]| [x[0], x[1], -x[2]];
    let mut stopping = make(part.clone());
    let trouble = stopping.go(mirrored).trouble;
    if trouble.is_none() && stopping.fields(0).failed {
        return; // its law has failed by itself
    }
    assert!(trouble.is_some(), "{law} in {:?} stops by default", part.element);
    let deleting = part.clone().with("inverted", "delete");
    let mut patch = make(deleting.clone());
    patch.go(|x| [1.001 * x[0], x[1], x[2]]);
    assert!(!patch.fields(0).failed);
    let checks = |patch: &mut Patch<C>, totals: Passed| {
        let name = format!("{law} in {:?}", part.element);
        for e in 0..patch.cells.len() {
            let state = patch.history.element(e);
            assert!(patch.fields(e).failed && patch.element.is_deleted(state), "{name} {e}");
            let kept = state.to_vec();
            assert!(kept.iter().all(|value| value.is_finite()), "{name} {e}: {kept:?}");
        }
        assert_eq!(patch.largest().0, 0.0, "{name}");
        assert_eq!((totals.internal, totals.trouble), (0.0, None));
        assert_eq!(totals.stable_dt, f64::INFINITY);
    };
    for _ in 0..3 {
        let totals = patch.go(mirrored);
        checks(&mut patch, totals);
    }
    // This step is reached by compression.
    let mut patch = make(deleting.clone());
    let start = patch.go(|x| x).stable_dt;
    patch.least_dt = 0.7 * start;
    let mut steps = 0;
    while !patch.fields(0).failed {
        patch.go(|x| [x[0], x[1], 0.95 * x[2]]);
        steps += 1;
        assert!(steps < 100, "{law} in {:?} must be deleted", part.element);
    }
    // Other laws stiffen fast.
    assert!(
        law != "elastic" || steps > 5,
        "{law} in {:?}: not before its step is short, {steps}",
        part.element
    );
    // A law may have failed before. What is deleted stays so, whatever the law marks.
    let is_deleted = |patch: &Patch<C>| patch.element.is_deleted(patch.history.element(0));
    let deleted = is_deleted(&patch);
    assert!(deleted || law != "elastic");
    for _ in 0..3 {
        let totals = patch.go(|x| [x[0], x[1], 0.9 * x[2]]);
        assert!(is_deleted(&patch) || !deleted, "{law} in {:?}", part.element);
        assert_ne!(totals.trouble, Some(0));
    }
    let mut patch = make(deleting);
    patch.x[0][0] = f64::NAN;
    assert!(patch.go(|x| x).trouble.is_some() && !patch.fields(0).failed);
}

/// All laws, with damage and criteria of failure, too: they have marks of failure of their own.
#[test]
fn inverted_solids_are_deleted_where_a_part_permits_it() {
    let mut laws = laws_of_solids();
    let mut eroding = material("elastic", 1.0, &[("youngs_modulus", E), ("poisson", NU)]);
    laws.push(eroding.clone());
    eroding.parameters.insert("erosion_volume_strain".into(), Param::Number(-3.0));
    laws.push(eroding);
    let (nodes, cells) = distorted(0.05);
    let hexahedron = part_of("hexahedron", 0.0).with("bulk_viscosity", [0.0; 2]);
    let mut more = nodes.clone();
    let quadratic = with_middles(&mut more, &tetrahedra_of(&cells));
    for law in laws {
        let (of, name) = (|| law.clone(), law.law.as_str());
        let viscous = hexahedron.clone().with("hourglass", "viscous");
        let hexahedron = if name == "fluid" { &viscous } else { &hexahedron };
        lose(|part| Patch::new(part, of(), &nodes, &cells), hexahedron, name);
        lose(|part| Patch::new(part, of(), &nodes, &tetrahedra_of(&cells)), &tetrahedron(), name);
        let tens = |part| Patch::new(part, of(), &more, &quadratic);
        lose(tens, &quadratic_tetrahedron(), name);
        if name != "fluid" {
            lose(|part| Patch::new(part, of(), &nodes, &wedges_of(&cells)), &wedge(), name);
        }
    }
}

/// A failed element has no force, limits no step and is not reported as trouble.
#[test]
fn a_failed_element_lets_go() {
    let numbers =
        [("youngs_modulus", E), ("poisson", NU), ("yield_stress", 1e3), ("failure_strain", 0.05)];
    let brittle = || material("j2", 1.0, &numbers);
    pull(tetrahedra(0.1, brittle()));
    pull(wedges(0.1, brittle()));
    pull(quadratic_tetrahedra(0.1, brittle()));
}

pub fn crush<const C: usize>(fresh: impl Fn() -> Patch<C>) {
    assert_eq!(fresh().go(|x| x).trouble, None);
    assert_eq!(fresh().go(|x| [x[0], x[1], 0.4 * x[2]]).trouble, Some(0), "strained by 0.86");
    let mut mirrored = fresh();
    assert!(mirrored.go(|x| [x[0], x[1], -x[2]]).trouble.is_some(), "inside out");
    let corners = mirrored.corners(0);
    assert!(mirrored.element.stable_dt(&corners, OwnSection::default()).is_nan());
    mirrored.v[3][1] = f64::NAN;
    assert!(mirrored.forces(1.0).trouble.is_some());
}

/// An inverted element, one with wild strain or numbers that are none is trouble.
#[test]
fn an_inverted_or_wildly_strained_element_is_trouble() {
    crush(|| tetrahedra(0.0, elastic(E, NU, 1.0)));
    crush(|| wedges(0.0, elastic(E, NU, 1.0)));
    crush(|| quadratic_tetrahedra(0.0, elastic(E, NU, 1.0)));
}
