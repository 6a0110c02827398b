//! Tests of all shells: patch tests, rigid motion, balance of forces, energy, lanes.

use super::testing::*;
use super::{ElementNodalForces, ElementPass, HourglassForm};
use crate::nodes::NodeView;
use crumple_math::lanes::LANES;
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::partition::{Material, Param};

const E: f64 = 1e6;
const NU: f64 = 0.25;

/// Returns the distorted patch of MacNeal & Harder 1985: five quads, or ten triangles.
fn patch(part: Part, triangular: bool) -> Patch {
    let inner = [[0.04, 0.02], [0.18, 0.03], [0.16, 0.08], [0.08, 0.08]];
    let outer = [[0.0, 0.0], [0.24, 0.0], [0.24, 0.12], [0.0, 0.12]];
    let nodes: Vec<[f64; 3]> = outer.iter().chain(&inner).map(|p| [p[0], p[1], 0.0]).collect();
    let quads = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]];
    let cells = if triangular { triangles(&quads) } else { quads.to_vec() };
    Patch::new(part, elastic(E, NU, 1.0), &nodes, &cells)
}

/// Returns all shells of this crate, without options and with all of them, on the distorted patch
/// bent out of its plane.
fn shells() -> Vec<(String, Patch)> {
    let every = |(element, triangular): (&str, bool)| {
        let plain = part_of(element, 0.01);
        let all = plain
            .clone()
            .with("warping", true)
            .with("thinning", true)
            .with("drilling", 0.1)
            .with("points", 4)
            .with("hourglass", HourglassForm::Viscous.word());
        let with_offset = Part { offset: 1.0, ..all.clone() };
        let named = [
            (element.to_string(), plain),
            (format!("{element}, all options"), all),
            (format!("{element}, offset"), with_offset),
        ];
        named.map(|(name, part)| {
            let mut patch = patch(part, triangular);
            let mut noise = Noise(3);
            patch.x.iter_mut().for_each(|x| x[2] = 0.02 * noise.next());
            (name, patch)
        })
    };
    FORMULATIONS.into_iter().flat_map(every).collect()
}

fn shake(patch: &mut Patch, noise: &mut Noise, size: f64) {
    for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
        (0..3).for_each(|i| v[i] = size * noise.next());
        (0..3).for_each(|i| w[i] = 10.0 * size * noise.next());
    }
}

/// Verification A21: u = 1e-3 (x + y/2), v = 1e-3 (y + x/2) give 4000/3, 4000/3 and 400 in every
/// element.
#[test]
fn membrane_patch_is_exact() {
    for (element, triangular) in FORMULATIONS {
        // In one step of a strain so small that its square is round-off.
        let mut patch = patch(part_of(element, 0.001), triangular);
        stretch(&mut patch, 1e-12);
        patch.forces(1.0);
        check_membrane(&patch, 1e-9, 1e-9, "strain of 1e-12, and round-off");

        // In many steps to the full strain. The logarithmic strain differs by half of its square,
        // and the axes of differently shaped elements rotate relative to each other by a fraction
        // of it.
        let mut patch = self::patch(part_of(element, 0.001), triangular);
        stretch(&mut patch, 1e-6);
        (0..1000).for_each(|_| _ = patch.step(1.0));
        check_membrane(&patch, 1e-3, 1e-3, "strain of 1.5e-3");
    }
}

fn stretch(patch: &mut Patch, size: f64) {
    for (v, x) in patch.v.iter_mut().zip(&patch.x) {
        *v = [size * (x[0] + 0.5 * x[1]), size * (x[1] + 0.5 * x[0]), 0.0, 0.0];
    }
}

/// Checks the stresses of the patch over their largest, for any size, and the balance of its inner
/// nodes.
fn check_membrane(patch: &Patch, tolerance: f64, size: f64, why: &str) {
    let unit = if size < 1e-6 { 1e9 } else { 1.0 };
    for element in 0..patch.cells.len() {
        let stress = patch.fields(element).stress.map(|s| unit * s);
        for (c, wanted) in [(0, 4000.0 / 3.0), (1, 4000.0 / 3.0), (3, 400.0)] {
            assert_close(stress[c], wanted, tolerance * wanted, why);
        }
    }
    for node in 4..8 {
        let mut sum = [0.0; 3];
        for (e, quad) in patch.cells.iter().enumerate() {
            // The fourth corner of a triangle repeats its third, with zero force.
            for c in (0..4).filter(|&c| quad[c] == node) {
                (0..3).for_each(|i| sum[i] += patch.corner(e, c).0[i]);
            }
        }
        let largest = patch.largest().0;
        assert!(
            sum.iter().all(|f| f.abs() < tolerance * largest),
            "inner node: {sum:?} of {largest} ({why})"
        );
    }
}

#[test]
fn rigid_rotation_leaves_no_stress() {
    let turn = std::f64::consts::TAU / 100.0;
    let axes =
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8], [0.48, -0.64, 0.6]];
    for (name, start) in shells() {
        for axis in axes {
            let mut patch = Patch {
                history: start.history.clone(),
                x: start.x.clone(),
                ..patch_like(&start, &name)
            };
            let angle = axis.map(|c: f64| c * turn);
            for step in 1..=100 {
                let drift = [0.01, -0.02, 0.03];
                // About the origin of the moment, which moves with the drift.
                let centre = drift.map(|d| d * f64::from(step - 1));
                let target = |x: [f64; 3]| {
                    let x = rotate(angle, std::array::from_fn(|i| x[i] - centre[i]));
                    std::array::from_fn(|i| x[i] + centre[i] + drift[i])
                };
                patch.aim(1.0, target, angle);
                patch.step(1.0);
                if [25, 50, 100].contains(&step) {
                    for element in 0..patch.cells.len() {
                        let fields = patch.fields(element);
                        let largest =
                            fields.stress.iter().fold(fields.von_mises, |m, s| m.max(s.abs()));
                        let why = "asin to seventh order at 3.6 degrees a step";
                        assert!(
                            largest < 1e-10 * E,
                            "{name}, axis {axis:?}, step {step}: {largest} ({why})"
                        );
                    }
                    let (force, moment) = patch.largest();
                    assert!(
                        force < 1e-10 * E * 0.01 * 0.1,
                        "{name}, axis {axis:?}, step {step}: force {force}"
                    );
                    assert!(
                        moment < 1e-10 * E * 0.01 * 0.01,
                        "{name}, axis {axis:?}, step {step}: moment {moment}"
                    );
                }
            }
        }
    }
}

/// Returns a patch of the same elements, for its element and connectivity.
fn patch_like(other: &Patch, name: &str) -> Patch {
    let again = shells().into_iter().find(|(n, _)| *n == name).expect("the name is in this list").1;
    assert_eq!(again.cells, other.cells);
    again
}

#[test]
fn forces_and_moments_balance_in_any_motion() {
    for (name, mut patch) in shells() {
        let mut noise = Noise(11);
        for step in 0..50 {
            shake(&mut patch, &mut noise, 1e-3);
            patch.step(1.0);
            let (force, moment) = patch.sums();
            let (largest_force, largest_moment) = patch.largest();
            let couple = largest_moment.max(largest_force * 0.1);
            assert!(
                force.iter().all(|f| f.abs() < 1e-13 * 40.0 * largest_force),
                "{name}, step {step}: {force:?}"
            );
            // Corner forces are in axes that are known to round-off, with arms of the patch's size.
            assert!(
                moment.iter().all(|m| m.abs() < 1e-13 * 40.0 * couple),
                "{name}, step {step}: {moment:?} {couple}"
            );
        }
    }
}

#[test]
fn reported_energy_is_the_work_of_corner_forces() {
    for (name, start) in shells() {
        let off = |steps: usize| {
            let mut patch = patch_like(&start, &name);
            let mut noise = Noise(23);
            shake(&mut patch, &mut noise, 1.0);
            let (shape_v, shape_w) = (patch.v.clone(), patch.w.clone());
            let (mut work, mut reported) = (0.0, 0.0);
            let dt = 1.0 / steps as f64;
            for step in 0..steps {
                // Forwards and half of the way back, with strains of a few per cent and rotations
                // of several degrees.
                let rate = 2e-3 * (4.0 * (step as f64 + 0.5) * dt).sin();
                let scale = |rows: &[[f64; 4]]| {
                    rows.iter().map(|r| r.map(|c| rate * c)).collect::<Vec<_>>()
                };
                (patch.v, patch.w) = (scale(&shape_v), scale(&shape_w));
                work += 0.5 * dt * patch.power();
                let totals = patch.step(dt);
                work += 0.5 * dt * patch.power();
                reported += totals.internal + totals.hourglass;
                assert_eq!(totals.trouble, None);
            }
            (work - reported).abs() / work.abs()
        };
        let (coarse, fine) = (off(200), off(800));
        assert!(coarse < 5e-3, "{name}: finite strain and rotation of a step: {coarse:e}");
        assert!(
            fine < 0.3 * coarse,
            "{name}: at least first order in the step: {coarse:e}, then {fine:e}"
        );
    }
}

/// Verification C16: large simple shear gives the same stress and force for any first corner.
#[test]
fn numbering_does_not_matter() {
    let mut noise = Noise(31);
    let spins: [[f64; 3]; 4] =
        std::array::from_fn(|_| std::array::from_fn(|_| 0.01 * noise.next()));
    for element in QUADS {
        let mut first = None;
        for turn in 0..4 {
            let corner = |c: usize| (c + turn) % 4;
            let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.02], [0.0, 1.0, 0.0]];
            let part = part_of(element, 0.05)
                .with("warping", true)
                .with("drilling", 0.1)
                .with("hourglass_coefficient", 0.1);
            let order: [u32; 4] = std::array::from_fn(|c| corner(c) as u32);
            let mut patch = Patch::new(part, elastic(E, NU, 1.0), &nodes, &[order]);
            for (w, spin) in patch.w.iter_mut().zip(&spins) {
                w[..3].copy_from_slice(spin);
            }
            for _ in 0..200 {
                (0..4).for_each(|node| {
                    patch.v[node] = [0.01 * nodes[node][1] + 1e-3 * spins[node][0], 0.0, 0.0, 0.0]
                });
                patch.step(1.0);
            }
            let stress = patch.fields(0).stress;
            let mut forces = [([0.0; 3], [0.0; 3]); 4];
            (0..4).for_each(|c| forces[corner(c)] = patch.corner(0, c));
            let (stress0, forces0) = *first.get_or_insert((stress, forces));
            for c in 0..6 {
                assert_close(stress[c], stress0[c], 1e-11 * E, "round-off over 200 steps");
            }
            for node in 0..4 {
                for i in 0..3 {
                    assert_close(
                        forces[node].0[i],
                        forces0[node].0[i],
                        1e-11 * E * 0.05,
                        "round-off over 200 steps",
                    );
                    assert_close(
                        forces[node].1[i],
                        forces0[node].1[i],
                        1e-12 * E * 0.05,
                        "round-off over 200 steps",
                    );
                }
            }
        }
        // Axes that follow one edge or the other would give 2 G and 1.159 G.
        let shear = first.unwrap().0[3] / (0.5 * E / (1.0 + NU));
        assert!(
            shear > 1.159 && shear < 2.0,
            "{element}: the bisector is between the edges: {shear}"
        );
    }
}

/// Verification A26: stress in simple shear by 2, in closed form in axes that rotate by half of the
/// angle of the sides: `asinh gamma` and `1 - sqrt(1 + gamma^2)` times G in them. The error is of
/// second order in the step; in the axes of the end of the step it was of first order.
#[test]
fn finite_shear_is_of_second_order_in_the_step() {
    let gamma = 2.0f64;
    let (t, n) = (gamma.asinh(), 1.0 - gamma.hypot(1.0));
    let (s, c) = gamma.atan().sin_cos();
    let wanted = [n * c + t * s, t * c - n * s].map(|stress| stress * 0.5 * E / (1.0 + NU));
    for element in QUADS {
        let off = |steps: usize| {
            let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            let mut patch =
                Patch::new(part_of(element, 0.05), elastic(E, NU, 1.0), &nodes, &[[0, 1, 2, 3]]);
            (0..4).for_each(|node| {
                patch.v[node] = [gamma / steps as f64 * nodes[node][1], 0.0, 0.0, 0.0]
            });
            (0..steps).for_each(|_| _ = patch.step(1.0));
            let stress = patch.fields(0).stress;
            (stress[0] / wanted[0] - 1.0).abs().max((stress[3] / wanted[1] - 1.0).abs())
        };
        let (coarse, fine) = (off(100), off(200));
        assert!(coarse < 5e-4, "{element}: {coarse:e}");
        assert!(fine < 0.3 * coarse, "{element}: {coarse:e}, then {fine:e}");
    }
}

#[test]
fn lanes_do_not_see_their_neighbours() {
    let table = [[0.0, 0.25], [0.01, 0.3], [0.05, 0.35]];
    let rate = Param::List(vec![0.04, 5.0]);
    for (element, triangular) in FORMULATIONS {
        let (nodes, quads) = grid(4, 1, 4.0, 1.0);
        let mut noise = Noise(5);
        let nodes: Vec<_> = nodes.iter().map(|x| x.map(|c| c + 0.05 * noise.next())).collect();
        let quads =
            if triangular { triangles(&quads).into_iter().step_by(2).collect() } else { quads };
        let mut material: Material =
            material("j2", 7.8e-6, &[("youngs_modulus", 210.0), ("poisson", 0.3)]);
        material
            .parameters
            .insert("hardening".into(), Param::Table(table.map(|row| row.to_vec()).into()));
        material.parameters.insert("cowper_symonds".into(), rate.clone());
        let part = part_of(element, 0.1).with("warping", true).with("thinning", true);
        let orders = [[0, 1, 2, 3], [2, 3, 1, 0], [1, 1, 1, 1], [3, 0, 3, 2]];
        let runs = orders.map(|order| {
            let quads = order.map(|element: usize| quads[element]);
            let mut patch = Patch::new(part.clone(), material.clone(), &nodes, &quads);
            let mut noise = Noise(9);
            for _ in 0..30 {
                // Nodes to the right move more: some elements stay elastic, some flow.
                for node in 0..patch.x.len() {
                    let size = 1e-3 * 10.0_f64.powf(patch.x[node][0] - 3.0);
                    (0..3).for_each(|i| patch.v[node][i] = size * noise.next());
                    (0..3).for_each(|i| patch.w[node][i] = size * noise.next());
                }
                patch.step(1.0);
            }
            patch
        });
        for (run, order) in runs.iter().zip(orders) {
            for (lane, element) in order.into_iter().enumerate() {
                let bits = |patch: &Patch, lane: usize| -> Vec<u64> {
                    let forces =
                        patch.force[lane * 4..][..4].iter().chain(&patch.moment[lane * 4..][..4]);
                    let history = patch.history.element(lane).to_vec();
                    forces.flatten().copied().chain(history).map(f64::to_bits).collect()
                };
                assert!(
                    bits(run, lane) == bits(&runs[0], element),
                    "element {element} in lane {lane} of {order:?}"
                );
            }
        }
        let strains: Vec<_> =
            (0..LANES).map(|element| runs[0].fields(element).plastic_strain).collect();
        assert!(
            strains.contains(&0.0) && strains.iter().any(|&e| e > 0.005),
            "elastic and plastic elements: {strains:?}"
        );
    }
}

#[test]
fn padding_adds_nothing_and_ranges_add_up() {
    for (element, triangular) in FORMULATIONS {
        let (nodes, quads) = grid(5, 2, 5.0, 2.0);
        let cells = if triangular { triangles(&quads)[..10].to_vec() } else { quads };
        let mut patch = Patch::new(part_of(element, 0.1), elastic(E, NU, 1.0), &nodes, &cells);
        shake(&mut patch, &mut Noise(2), 1e-4);
        let (history, x) = (patch.history.clone(), patch.x.clone());
        let whole = patch.step(1.0);
        let force = patch.force.clone();
        let single: f64 = (0..10)
            .map(|index| {
                let mut one = Patch::new(
                    part_of(element, 0.1),
                    elastic(E, NU, 1.0),
                    &nodes,
                    &cells[index..=index],
                );
                (one.v, one.w) = (patch.v.clone(), patch.w.clone());
                one.step(1.0).internal
            })
            .sum();
        assert_close(whole.internal, single, 1e-13 * single, "round-off of a sum of ten");

        (patch.history, patch.x) = (history, x);
        for (x, v) in patch.x.iter_mut().zip(&patch.v) {
            (0..3).for_each(|i| x[i] += v[i]);
        }
        let mut internal = 0.0;
        patch.force.fill([0.0; 4]);
        for range in [2..3, 0..2] {
            let nodes = NodeView { x: &patch.x, v: &patch.v, w: &patch.w };
            let out = ElementNodalForces { force: &mut patch.force, moment: &mut patch.moment };
            let lanes = patch.history.lanes();
            let (groups, history) = (&patch.groups[..], patch.history.as_mut());
            let done = passed((10, groups.len() / 4, lanes), |energies| {
                patch.element.forces(ElementPass {
                    range,
                    count: 10,
                    groups,
                    history,
                    unstrained: &mut patch.unstrained,
                    nodes,
                    dt: 1.0,
                    least_dt: 0.0,
                    step_factors: &[],
                    out,
                    energies,
                })
            });
            internal += done.internal;
        }
        assert_close(whole.internal, internal, 1e-14 * internal, "round-off of two sums");
        assert!(force[..40] == patch.force[..40], "the same bits for any split into ranges");
    }
}

#[test]
fn failures_are_reported() {
    for (element, triangular) in FORMULATIONS {
        let (nodes, quads) = grid(4, 1, 4.0, 1.0);
        let cells = if triangular { triangles(&quads) } else { quads };
        let fresh = || Patch::new(part_of(element, 0.1), elastic(E, NU, 1.0), &nodes, &cells);
        assert_eq!(fresh().step(1.0).trouble, None);
        for spoil in [
            // NaN, a stretch by more than half, and (quads) a corner pushed across the diagonal.
            &(|patch: &mut Patch| patch.v[3][1] = f64::NAN) as &dyn Fn(&mut Patch),
            &|patch| patch.w[3][1] = f64::NAN,
            &|patch| patch.v[3][2] = f64::INFINITY,
            &|patch| patch.aim(1.0, |x| [3.0 * x[0], x[1], x[2]], [0.0; 3]),
            &|patch| patch.w[2][1] = 50.0,
        ] {
            let mut patch = fresh();
            spoil(&mut patch);
            assert!(patch.step(1.0).trouble.is_some());
        }
    }
    for element in QUADS {
        let (nodes, quads) = grid(4, 1, 4.0, 1.0);
        let mut patch = Patch::new(part_of(element, 0.1), elastic(E, NU, 1.0), &nodes, &quads);
        let element = &patch.element;
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert!(element.stable_dt(&line, OwnSection::default()).is_nan(), "a line has no area");
        patch.x[0] = [1.0, 1.0, 0.0, 0.0];
        assert!(
            patch.forces(1.0).trouble.is_some(),
            "the step also reports a corner that coincides with the opposite one"
        );
    }
}

#[test]
fn set_up_reports_all_errors() {
    let part = Part { element: Some("belytchko_tsay".into()), thickness: -1.0, ..part(1.0) }
        .with("points", 11);
    let paths = |part: &Part, material: Material, shape| {
        let problems = super::build_block(&settings(part.clone(), material), 0, shape)
            .err()
            .expect("it is wrong");
        problems.into_iter().map(|problem| (problem.path, problem.help)).collect::<Vec<_>>()
    };
    let found = paths(&part, elastic(-1.0, 0.3, 1.0), Shape::Quad4);
    assert_eq!(found[0].0, "material.0.youngs_modulus");
    assert_eq!(found[1].0, "part.0.element");
    assert!(found[1].1.contains("'belytschko_tsay'"), "{}", found[1].1);

    // Triangles have one formulation and need no name. The section is checked even if the material
    // is wrong.
    let found: Vec<_> = paths(&part, elastic(-1.0, 0.3, 1.0), Shape::Tri3)
        .into_iter()
        .map(|found| found.0)
        .collect();
    assert_eq!(found, ["material.0.youngs_modulus", "part.0.thickness", "part.0.points"]);

    let astray = Part { material: "sheat".into(), ..self::part(1.0) };
    let found = paths(&astray, elastic(1.0, 0.3, 1.0), Shape::Quad4);
    assert_eq!(found[0].0, "part.0.material");
    assert!(found[0].1.contains("'sheet'"), "{}", found[0].1);
}
