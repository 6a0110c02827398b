//! Tests of the properties that only the stabilised shell has.

use super::super::quad::tests::singles_and_lanes;
use super::super::testing::*;
use super::*;
use crate::materials;
use crumple_math::lanes::Lane;
use crumple_proto::partition::{Material, Param};

const E: f64 = 210.0;
const NU: f64 = 0.3;
/// Motion so small that its square is round-off.
const SMALL: f64 = 1e-12;

fn quad(thickness: f64, material: Material, nodes: &[[f64; 3]]) -> Patch {
    Patch::new(part_of("stabilised_quad", thickness), material, nodes, &[[0, 1, 2, 3]])
}

/// Beam bending of a rectangle in its plane has the energy of the beam for any side ratio and any
/// Poisson's ratio: `u = c x y`, `v = -c (x^2 + nu y^2)/2`, moment `E t h^3 c/12`. v is equal at
/// all corners.
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
            assert_close(totals.hourglass, beam, 1e-9 * beam, "round-off, and strains of 1e-12");
            assert!(
                totals.internal.abs() < 1e-9 * beam,
                "no strain at the centre: {}",
                totals.internal
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
        for (node, sign) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
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

/// Verification C11: rigid rotation of a warped square about any axis gives no force.
#[test]
fn warped_squares_turn_freely() {
    for warp in [0.05, 0.1, 0.2] {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, warp], [0.0, 1.0, 0.0]];
        for axis in 0..3 {
            let mut patch = quad(0.01, elastic(E, NU, 1.0), &corners);
            let angle: [f64; 3] = std::array::from_fn(|i| if i == axis { 0.02 } else { 0.0 });
            for _ in 0..50 {
                patch.aim(1.0, |x| rotate(angle, x), angle);
                patch.step(1.0);
            }
            let (force, moment) = patch.largest();
            assert!(
                force.max(moment) < 1e-12 * E * 0.01,
                "round-off: warp {warp}, axis {axis}: {force:e} {moment:e}"
            );
        }
    }
}

/// Yield stress of the square with plastic flow.
const YIELDS: f64 = 0.25;

fn steel() -> Material {
    material("j2", 1.0, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", YIELDS)])
}

/// Returns the stabilising force of a square after 1000 steps of shear at 1e-4 per step, which
/// varies by the fraction `wave` from step to step, and of bending in the plane at 1e-6 per step.
fn gathered(material: Material, wave: f64) -> f64 {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut patch = quad(0.1, material, &square);
    let column = patch.element.columns() - DRILLING - 4;
    for step in 0..1000 {
        let shear = 1e-4 * if step % 2 == 0 { 1.0 + wave } else { 1.0 - wave };
        for (v, (x, sign)) in patch.v.iter_mut().zip(patch.x.iter().zip([1.0, -1.0, 1.0, -1.0])) {
            *v = [shear * x[1] + 1e-6 * sign, 0.0, 0.0, 0.0];
        }
        assert!(patch.step(1.0).hourglass >= 0.0);
    }
    patch.history.element(0).at(column)
}

/// A strain rate that rises and falls raises the stress in every other step. That is not hardening:
/// the stabilising force relaxes as it does at a steady rate.
#[test]
fn waves_in_the_rate_do_not_stiffen() {
    let mut rated = steel();
    // At 1e-4 the strain rate adds a third.
    rated.parameters.insert("cowper_symonds".to_string(), Param::List(vec![0.01, 5.0]));
    let (steady, wavy) = (gathered(rated.clone(), 0.0), gathered(rated, 0.5));
    assert_close(wavy, steady, 0.2 * steady, "the factor of the return is not linear in the rate");
}

/// In steady plastic flow the stabilising force is that of a few steps, not that of an elastic
/// material.
#[test]
fn flow_relaxes_the_stabilising_forces() {
    let (plain, flowing) = (gathered(elastic(E, NU, 1.0), 0.0), gathered(steel(), 0.0));
    // Elastic: E t/16 times Jxx = 4/3, times four times the corners' 1e-3.
    assert_close(plain, E * 0.1 / 16.0 * (4.0 / 3.0) * 4e-3, 0.05 * plain, "shear of a tenth");
    // Relaxation with the rate 3 G d eps_p / sig_y and d eps_p = 1e-4/sqrt(3) leaves the growth of
    // some steps, each of which is the smallest without hardening.
    let steps = YIELDS / (3.0 * 0.5 * E / (1.0 + NU) * 1e-4 / 3.0_f64.sqrt());
    assert_close(
        flowing,
        0.01 * plain / 1000.0 * steps,
        0.2 * flowing,
        "as above, plus one step of the return",
    );
}

/// Bending of a rectangle in and out of its plane varies over it, while its centre stays elastic.
/// Far beyond yield and back the forces are those of the plastic moments `sig t h^2/4` of its
/// section in the plane and `sig t^2/4` per length out of it, for any coefficient.
#[test]
fn stabilising_forces_of_a_plastic_part_reach_the_plastic_moment() {
    let (t, l, h) = (0.1, 2.0, 1.0);
    let corners = [[0.0, 0.0, 0.0], [l, 0.0, 0.0], [l, h, 0.0], [0.0, h, 0.0]];
    let (in_plane, out) = (YIELDS * t * h * h / 4.0, YIELDS * t * t / 4.0);
    // Two opposite forces on a side of the length h make the moment in the plane.
    let of_x = in_plane / h;
    let of_y = of_x * l / h;
    // A curvature that varies from -1 to 1 is one half on average; a side has two nodes.
    let (of_tx, of_ty) = (out * l / 4.0, out * h / 4.0);
    for coefficient in [0.0, 0.01, 1.0] {
        for (mode, bound) in [of_x, of_y, of_tx, of_ty].into_iter().enumerate() {
            let part = part_of("stabilised_quad", t).with("hourglass_coefficient", coefficient);
            let mut patch = Patch::new(part, steel(), &corners, &[[0, 1, 2, 3]]);
            for sense in [1.0, -1.0] {
                for (node, sign) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
                    match mode {
                        0 | 1 => patch.v[node][mode] = sense * sign,
                        _ => patch.w[node][mode - 2] = sense * sign,
                    }
                }
                for _ in 0..800 {
                    assert!(patch.forces(1e-3).internal.abs() < 1e-9, "the centre is elastic");
                }
                let (force, moment) = patch.corner(0, 0);
                let reached = if mode < 2 { force[mode] } else { moment[mode - 2] };
                assert_close(reached, sense * bound, 1e-9 * bound, "round-off");
            }
        }
    }
}

/// The kernel gives the same bits on scalars and on lanes.
#[test]
fn lanes_are_the_scalar_kernel() {
    let rate = ("cowper_symonds".to_string(), Param::List(vec![0.04, 5.0]));
    let mut steel =
        material("j2", 7.8e-6, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25)]);
    steel.parameters.extend([rate]);
    let part = part_of("stabilised_quad", 0.05).with("thinning", true);
    let law = materials::build(&steel).map_err(|p| format!("{p:?}")).unwrap();
    let section =
        Section::new(&part, &ROW.values(&part), law).map_err(|p| format!("{p:?}")).unwrap();
    let shell = Shell(Quad(StabilisedQuad { section, drilling: 0.01, least_stiffness: 0.03 }));
    let fields = singles_and_lanes(
        &shell,
        |g, modes, history| shell.0.0.respond::<Lane, 5>(g, modes, history, 0.5),
        |g, modes, history| shell.0.0.respond::<f64, 5>(g, modes, history, 0.5),
    );
    let plastic = fields.map(|fields| fields.plastic_strain);
    assert!(plastic[0] == 0.0 && plastic[3] > 0.0, "elastic and plastic lanes: {plastic:?}");
}
