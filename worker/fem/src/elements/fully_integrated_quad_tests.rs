//! Tests of the properties that only the fully integrated shell has.

use super::super::quad::tests::singles_and_lanes;
use super::super::testing::*;
use super::*;
use crate::materials;
use crumple_math::lanes::Lane;
use crumple_proto::mesh::OwnSection;
use crumple_proto::partition::{Material, Param};
use nalgebra::{DMatrix, DVector};

const E: f64 = 210.0;
const NU: f64 = 0.3;
/// Motion so small that its square is round-off.
const SMALL: f64 = 1e-12;
const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const HOURGLASS: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

fn quad(thickness: f64, material: Material, nodes: &[[f64; 3]]) -> Patch {
    Patch::new(part_of("fully_integrated_quad", thickness), material, nodes, &[[0, 1, 2, 3]])
}

/// Returns the force on the hourglass mode of displacements along an axis.
fn on_hourglass(patch: &Patch, axis: usize) -> f64 {
    (0..4).map(|c| 0.25 * HOURGLASS[c] * patch.corner(0, c).0[axis]).sum()
}

/// Beam bending of a rectangle in its plane has the energy of the beam for any side ratio and any
/// Poisson's ratio, and all of it is in the points: `u = c x y`, moment `E t h^3 c/12`.
#[test]
fn plane_bending_does_not_lock() {
    for nu in [0.0, 0.3, 0.499] {
        for (l, h) in [(1.0, 1.0), (4.0, 1.0), (1.0, 8.0)] {
            let (a, b, t) = (0.5 * l, 0.5 * h, 0.1);
            let corners = [[-a, -b, 0.0], [a, -b, 0.0], [a, b, 0.0], [-a, b, 0.0]];
            let mut patch = quad(t, elastic(E, nu, 1.0), &corners);
            for (v, x) in patch.v.iter_mut().zip(corners) {
                v[0] = SMALL * x[0] * x[1];
            }
            let totals = patch.forces(1.0);
            let beam = 0.5 * E * t * h * h * h / 12.0 * l * SMALL * SMALL;
            assert_close(totals.internal, beam, 1e-9 * beam, "round-off, and strains of 1e-12");
            assert!(
                totals.hourglass.abs() < 1e-9 * beam,
                "there is no hourglass energy: {}",
                totals.hourglass
            );
        }
    }
}

/// Every corner motion that is not rigid has stiffness, and the energy is the work.
#[test]
fn every_mode_is_resisted() {
    let skew = [[0.0, 0.0, 0.0], [1.1, 0.1, 0.0], [1.3, 0.9, 0.1], [-0.1, 1.2, 0.0]];
    for mode in 0..5 {
        let mut patch = quad(0.1, elastic(E, NU, 1.0), &skew);
        for (node, sign) in HOURGLASS.into_iter().enumerate() {
            if mode < 3 {
                patch.v[node][mode] = SMALL * sign
            } else {
                patch.w[node][mode - 3] = SMALL * sign
            }
        }
        let totals = patch.forces(1.0);
        let work = 0.5 * patch.power();
        assert_close(totals.internal + totals.hourglass, work, 1e-9 * work, "round-off");
        assert!(work > 1e-3 * E * 1e-3 * SMALL * SMALL, "mode {mode}: {work:e}");
    }
}

/// In steady flow without hardening the force of the hourglass mode is that of the flow rule, after
/// any time. A unit square is sheared by g per step and bent in its plane by d = 1e-6 2/sqrt 3 at
/// the points; stress is normal to the rates, `sig_x = (2 d - nu d) 2 tau/g`,
/// `sig_y = (d - 2 nu d) 2 tau/g`, and the force of the mode is `t/(2 sqrt 3) (sig_x - nu sig_y)`.
#[test]
fn flow_leaves_the_modes_what_the_points_bear() {
    let (yields, t, g) = (0.25, 0.1, 1e-4);
    let steel =
        material("j2", 1.0, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", yields)]);
    let mut patch = quad(t, steel, &SQUARE);
    let mut held = Vec::new();
    for step in 1..=400 {
        for (v, (x, sign)) in patch.v.iter_mut().zip(patch.x.iter().zip(HOURGLASS)) {
            *v = [g * x[1] + 1e-6 * sign, 0.0, 0.0, 0.0];
        }
        patch.step(1.0);
        if step % 200 == 0 {
            held.push(on_hourglass(&patch, 0));
        }
    }
    let (tau, d) = (yields / 3.0_f64.sqrt(), 1e-6 * 2.0 / 3.0_f64.sqrt());
    let [x, y] = [2.0 - NU, 1.0 - 2.0 * NU].map(|c| c * d * 2.0 * tau / g);
    let wanted = t / (2.0 * 3.0_f64.sqrt()) * (x - NU * y);
    for held in held {
        assert_close(
            held,
            wanted,
            0.06 * wanted,
            "shear up to 0.04 rotates the axes; second order in d/g",
        );
    }
}

/// A square that is bent in its plane alone far beyond yield reaches the limit of its points, and
/// unloads elastically.
#[test]
fn the_limit_of_plane_bending_is_that_of_the_points() {
    let (yields, t) = (0.25, 0.1);
    let steel =
        material("j2", 1.0, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", yields)]);
    let mut patch = quad(t, steel, &SQUARE);
    let bend = |patch: &mut Patch, size: f64| {
        (0..4).for_each(|c| patch.v[c][0] = size * HOURGLASS[c]);
        patch.step(1.0);
    };
    (0..400).for_each(|_| bend(&mut patch, 2e-5));
    // Flow with eps_y = -nu eps_x: the stress normal to it, at yield.
    let (x, y) = (2.0 - NU, 1.0 - 2.0 * NU);
    let size = yields / (x * x - x * y + y * y).sqrt();
    let wanted = t / (2.0 * 3.0_f64.sqrt()) * size * (x - NU * y);
    let limit = on_hourglass(&patch, 0);
    assert_close(limit, wanted, 0.02 * wanted, "corners have moved by 0.8 % of the side");
    bend(&mut patch, -1e-6);
    let elastic = E * t / 16.0 * 4.0 / 3.0 * 4e-6;
    assert_close(limit - on_hourglass(&patch, 0), elastic, 0.03 * elastic, "as above");
}

/// Two of four failed points carry no stress while the others still do; with the third the element
/// fails.
#[test]
fn three_failed_points_of_four_are_a_failed_element() {
    let numbers =
        [("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25), ("failure_strain", 0.5)];
    for failed in 0..4 {
        let mut patch = quad(0.1, material("j2", 1.0, &numbers), &SQUARE);
        let each = 5 + 5 * 7;
        let mut state = patch.history.element(0).to_vec();
        assert_eq!(state.len(), 4 * each + DRILLING);
        for p in 0..failed {
            (0..5).for_each(|k| state[p * each + 5 + k * 7 + 6] = 1.0);
        }
        // Padding repeats the element, and its step would be counted.
        (0..patch.history.lanes()).for_each(|lane| patch.history.set(lane, &state));
        for (v, w) in patch.v.iter_mut().zip(&mut patch.w).skip(2) {
            (v[1], v[2], w[0]) = (1e-6, 1e-6, 1e-6);
        }
        let totals = patch.step(1.0);
        let force = (0..4).flat_map(|c| patch.corner(0, c).0).fold(0.0, |m: f64, f| m.max(f.abs()));
        let fields = patch.fields(0);
        assert_eq!(
            (fields.failed, force == 0.0),
            (failed > 2, failed > 2),
            "{failed} points: {force}"
        );
        assert_eq!(patch.element.failed(patch.history.element(0)), failed > 2);
        if failed > 2 {
            assert_eq!(
                (totals.stable_dt, totals.internal, fields.von_mises),
                (f64::INFINITY, 0.0, 0.0)
            );
            assert_eq!(fields.stress, [0.0; 6]);
        } else {
            // Membrane and shear, in proportion to the number of remaining points.
            let left = (4 - failed) as f64 / 4.0;
            let c11 = E / (1.0 - NU * NU);
            assert_close(fields.stress[1], left * c11 * 1e-6, 1e-5 * c11 * 1e-6, "strain of 1e-6");
            let shear = 5.0 / 6.0 * 0.5 * E / (1.0 + NU) * (1e-6 - 0.5e-6);
            assert!(
                fields.stress[4].abs() <= (1.0 + 1e-5) * 2.0 * left * shear,
                "{failed}: {:?}",
                fields.stress
            );
        }
    }
}

/// Each point thins separately; the thickness of the element is their mean.
#[test]
fn thinning_keeps_the_volume_of_plastic_flow() {
    let steel =
        material("j2", 7.8e-6, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25)]);
    let part = part_of("fully_integrated_quad", 0.1).with("thinning", true);
    let mut patch = Patch::new(part, steel, &SQUARE, &[[0, 1, 2, 3]]);
    for _ in 0..2000 {
        // The final shape is a trapezoid.
        patch.aim(1.0, |x| [x[0] * (1.00005 + 0.00005 * x[1]), x[1] * 1.00005, x[2]], [0.0; 3]);
        patch.step(1.0);
    }
    let area = 0.5 * (patch.x[1][0] + patch.x[2][0]) * patch.x[2][1];
    let off = 3.0 * 0.25 * (1.0 - 2.0 * NU) / E + 0.005;
    let fields = patch.fields(0);
    assert_close(
        fields.thickness * area / 0.1,
        1.0,
        off,
        "the elastic bulk strain, and variation of the Jacobian squared",
    );
    let state = patch.history.element(0).to_vec();
    let each = (state.len() - DRILLING) / PLANAR;
    let all: Vec<f64> = (0..PLANAR).map(|p| state[p * each]).collect();
    assert_close(fields.thickness, 0.25 * all.iter().sum::<f64>(), 1e-15, "round-off");
    let (low, high) = all.iter().fold((1.0_f64, 0.0_f64), |(l, h), &t| (l.min(t), h.max(t)));
    assert!(high > 1.02 * low, "the wide end thins more: {all:?}");
}

/// Returns stiffness over mass of a single element: squared frequencies, ascending.
fn spectrum(nodes: &[[f64; 3]; 4], t: f64, nu: f64) -> (Vec<f64>, f64) {
    let mut patch = quad(t, elastic(1.0, nu, 1.0), nodes);
    let fresh = patch.history.clone();
    let masses = patch.masses();
    let root = DVector::from_fn(24, |row, _| {
        let (mass, inertia) = masses[row / 6];
        (if row % 6 < 3 { mass } else { inertia }).sqrt()
    });
    let mut k = DMatrix::zeros(24, 24);
    for column in 0..24 {
        patch.history.clone_from(&fresh);
        patch.v.fill([0.0; 4]);
        patch.w.fill([0.0; 4]);
        let of = if column % 6 < 3 { &mut patch.v } else { &mut patch.w };
        of[column / 6][column % 3] = SMALL;
        patch.forces(1.0);
        for row in 0..24 {
            let (f, m) = patch.corner(0, row / 6);
            let value = if row % 6 < 3 { f[row % 3] } else { m[row % 3] };
            k[(row, column)] = value / SMALL / (root[row] * root[column]);
        }
    }
    let off = (&k - k.transpose()).abs().max();
    assert!(off < 1e-6 * k.abs().max(), "not symmetric by {off}");
    let mut all: Vec<f64> =
        (0.5 * (&k + k.transpose())).symmetric_eigenvalues().iter().copied().collect();
    all.sort_by(f64::total_cmp);
    (all, patch.element.stable_dt(nodes, OwnSection::default()))
}

/// The step is that of the highest frequency of a single element of any shape, or 1.05 of it (see
/// `quad.rs`); at nu = 0, where shear has the highest frequency, that frequency is up to 7 %
/// higher. All motions that are not rigid have stiffness.
#[test]
fn the_step_is_bounded_by_the_highest_frequency() {
    let mut noise = Noise(13);
    let mut worst = (0.0_f64, [[0.0; 3]; 4], 0.0, 0.0);
    for round in 0..300 {
        let ratio = [1.0, 1.0, 2.0, 5.0, 20.0][round % 5];
        let size = 0.4 * (round / 5) as f64 / 60.0;
        let warp = if round % 2 == 0 { 0.0 } else { 0.1 };
        let nodes = SQUARE.map(|[x, y, _]| {
            let skew = size * noise.next();
            [
                ratio * (x + size * noise.next()) + skew,
                y + size * noise.next(),
                warp * size * noise.next(),
            ]
        });
        for nu in [0.0, 0.3, 0.45] {
            for t in [0.01, 0.1, 0.5] {
                let (all, step) = spectrum(&nodes, t, nu);
                if step.is_nan() {
                    continue;
                }
                let highest = all[23].sqrt();
                let over = 0.5 * step * highest;
                if over > worst.0 {
                    worst = (over, nodes, nu, t);
                }
                assert!(
                    all[6] > 1e-12 * all[23],
                    "a deformation has no stiffness: {nodes:?}, t {t}: {all:?}"
                );
                assert!(
                    all[5].abs() < 1e-13 * all[23],
                    "rigid motion has a stiffness: {nodes:?}: {all:?}"
                );
            }
        }
    }
    eprintln!("{worst:?}");
    assert!(worst.0 < 1.09, "the default safety of 0.9 covers this: {worst:?}");
}

/// The kernel gives the same bits on scalars and on lanes.
#[test]
fn lanes_are_the_scalar_kernel() {
    let rate = ("cowper_symonds".to_string(), Param::List(vec![0.04, 5.0]));
    let mut steel =
        material("j2", 7.8e-6, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25)]);
    steel.parameters.extend([rate, ("failure_strain".to_string(), Param::Number(0.02))]);
    let part = part_of("fully_integrated_quad", 0.05).with("thinning", true);
    let law = materials::build(&steel).map_err(|p| format!("{p:?}")).unwrap();
    let section = Section::new(&part, &ROW.values(&part), law)
        .map_err(|p| format!("{p:?}"))
        .unwrap()
        .at_points(PLANAR);
    let shell = Shell(Quad(FullyIntegratedQuad { section, drilling: 0.01 }));
    let fields = singles_and_lanes(
        &shell,
        |g, modes, history| shell.0.0.respond::<Lane, 5>(g, modes, history, 0.5),
        |g, modes, history| shell.0.0.respond::<f64, 5>(g, modes, history, 0.5),
    );
    let plastic = fields.map(|fields| fields.plastic_strain);
    assert!(plastic[0] == 0.0 && plastic[3] > 0.0, "elastic and plastic lanes: {plastic:?}");
    assert!(!fields[0].failed && fields[3].failed, "intact and failed lanes");
}

/// Each quarter of a divided shell has the stress of the point next to its corner. With
/// `u = (x y, 2 x y)` and no Poisson's ratio the stress is E (y, 2 x); it is that of the side of
/// the corner.
#[test]
fn quarters_have_the_stress_of_the_point_next_to_their_corner() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let mut patch = quad(0.1, elastic(E, 0.0, 1.0), &corners);
    for (v, [x, y, _]) in patch.v.iter_mut().zip(corners) {
        (v[0], v[1]) = (SMALL * x * y, 2.0 * SMALL * x * y);
    }
    patch.forces(1.0);
    let whole = patch.history.element(0).to_vec();
    let names = patch.element.names();
    let column = |name: &str| names.iter().position(|n| n == name).expect("a column");
    for (corner, [x, y, _]) in corners.into_iter().enumerate() {
        // The quarter is the shell of half the size.
        let small = corners.map(|c| c.map(|v| 0.5 * v));
        let quarter = patch.element.quarter(&whole, corner, &small, OwnSection::default());
        let quarter = quarter.expect("quads can be divided");
        for point in 0..4 {
            let stress = |axis: &str| quarter[column(&format!("point {point}.0 stress {axis}"))];
            let wanted = [y, 2.0 * x].map(|side| E * SMALL * side / 3.0_f64.sqrt());
            for (found, wanted) in [stress("xx"), stress("yy")].into_iter().zip(wanted) {
                assert_close(found, wanted, 1e-6 * E * SMALL, "one point at 1/sqrt(3)");
            }
        }
        let volumes = ["volume at start", "inertia"].map(|n| column(&format!("point 0 {n}")));
        assert_close(quarter[volumes[0]], 0.1, 1e-15, "that of its own area 1");
        assert!(quarter[volumes[1]] < whole[volumes[1]], "its own inertia");
    }
}
