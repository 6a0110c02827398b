//! Single precision against double: forces, energies, steps, laws, and what may not be lost.

use super::solid_testing::Solids;
use super::testing::{Noise, Patch, grid, material, part, triangles};
use crumple_proto::job::{HourglassForm, Part, Precision};
use crumple_proto::partition::{Material, Param};

const E: f64 = 210.0;
const NU: f64 = 0.3;
const YIELD: f64 = 0.25;
pub const BOTH: [Precision; 2] = [Precision::Double, Precision::Single];

fn steel(law: &str, more: &[(&str, Param)]) -> Material {
    let mut m = material(law, 7.85e-6, &[("youngs_modulus", E), ("poisson", NU)]);
    m.parameters.extend(more.iter().map(|(key, value)| (key.to_string(), value.clone())));
    m
}

/// Every law, with all that takes powers, logarithms and exponentials.
pub fn laws() -> [Material; 4] {
    let number = Param::Number;
    let table = Param::Table(vec![vec![0.0, YIELD], vec![0.02, 0.3], vec![0.05, 0.6]]);
    let rate = Param::List(vec![0.04, 5.0]);
    let damage = Param::List(vec![0.05, 3.44, -2.12, 0.002, 0.61]);
    let johnson_cook = [
        ("a", number(0.79)),
        ("b", number(0.51)),
        ("n", number(0.26)),
        ("c", number(0.014)),
        ("reference_rate", number(1e-3)),
        ("m", number(1.03)),
        ("melting_temperature", number(1793.0)),
        ("reference_temperature", number(293.0)),
        ("specific_heat", number(477.0)),
        ("damage", damage),
    ];
    [
        steel("elastic", &[]),
        steel("j2", &[("yield_stress", number(YIELD)), ("hardening_modulus", number(1.0))]),
        steel("j2", &[("hardening", table), ("cowper_symonds", rate), ("failure_strain", number(0.3))]),
        steel("johnson_cook", &johnson_cook),
    ]
}

/// Shells of every formulation.
pub fn shells(precision: Precision, steel: &Material, at: [f64; 3]) -> [Patch; 3] {
    let (nodes, quads) = grid(5, 3, 5.0, 3.0);
    let mut noise = Noise(5);
    let moved = |x: &[f64; 3]| std::array::from_fn(|i| at[i] + x[i] + if i < 2 { 0.1 } else { 0.02 } * noise.next());
    let nodes: Vec<[f64; 3]> = nodes.iter().map(moved).collect();
    let base = Part { thinning: true, warping: true, ..part(0.3) };
    let of = |name: &str| Part { element: Some(name.into()), ..base.clone() };
    [
        Patch::in_precision(precision, of("belytschko_tsay"), steel.clone(), &nodes, &quads),
        Patch::in_precision(precision, of("stabilised_quad"), steel.clone(), &nodes, &quads),
        Patch::in_precision(precision, base.clone(), steel.clone(), &nodes, &triangles(&quads)),
    ]
}

/// Shaken the same way in both precisions: strains of a few per cent in all, most of them plastic. Round-off of a step is
/// 6e-8 of the stress, and of the strain's 1e-3 there; forces agree to a few 1e-6, energies too.
#[test]
fn shells_give_nearly_the_forces_of_double_precision() {
    for steel in laws() {
        for kind in 0..3 {
            let ends = BOTH.map(|precision| {
                let [a, b, c] = shells(precision, &steel, [0.0; 3]);
                let mut patch = [a, b, c].into_iter().nth(kind).unwrap();
                let (mut noise, mut energy) = (Noise(11), [0.0; 2]);
                for _ in 0..60 {
                    for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
                        (0..3).for_each(|i| v[i] = 1.0 + 0.3 * noise.next());
                        (0..3).for_each(|i| w[i] = 0.1 * noise.next());
                    }
                    let totals = patch.step(0.01);
                    assert_eq!(totals.trouble, None, "{} {kind}", steel.law);
                    energy = [energy[0] + totals.internal, energy[1] + totals.hourglass];
                }
                (patch, energy)
            });
            let [(long, energy), (short, short_energy)] = ends;
            let (force, moment) = long.largest();
            let off = |a: &[[f64; 4]], b: &[[f64; 4]]| {
                a.iter().flatten().zip(b.iter().flatten()).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
            };
            // Corners beyond the last element are padding, of which there is more in one of them.
            let corners = 4 * long.quads.len();
            let off = [
                off(&long.force[..corners], &short.force[..corners]) / force,
                off(&long.moment[..corners], &short.moment[..corners]) / moment,
                (short_energy[0] / energy[0] - 1.0).abs(),
                (short_energy[1] / energy[1] - 1.0).abs(),
            ];
            assert!(off.iter().all(|&o| o < 2e-5), "{} {kind}: {off:?}", steel.law);
            assert!(off[0] > 1e-9, "{} {kind}: nothing was rounded, {off:?}", steel.law);
            let strain = |patch: &Patch| (0..patch.quads.len()).map(|e| patch.fields(e).plastic_strain).sum::<f64>();
            let (flowed, short_flowed) = (strain(&long), strain(&short));
            assert!(steel.law == "elastic" || flowed > 0.01, "{} {kind}: {flowed}", steel.law);
            assert!((short_flowed - flowed).abs() <= 2e-5 * flowed, "{} {kind}: {flowed} {short_flowed}", steel.law);
        }
    }
}

/// Corners are sums of modes in double precision: what an element does to itself vanishes as it does there.
#[test]
fn forces_of_an_element_add_up_to_nought() {
    let [law, ..] = laws();
    for mut patch in shells(Precision::Single, &law, [0.0; 3]) {
        let mut noise = Noise(3);
        patch.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = noise.next()));
        patch.step(0.01);
        let ([x, y, z], _) = patch.sums();
        let (force, _) = patch.largest();
        assert!(x.abs().max(y.abs()).max(z.abs()) < 1e-14 * force, "round-off of sums of {force}: {x:e} {y:e} {z:e}");
    }
}

/// Differences of corners are taken before they are rounded: far off and at great speed forces are what they are at home, but for
/// the last digits of coordinates, 1e7 of which have 2e-9 of a side's length.
#[test]
fn large_coordinates_and_speeds_cost_nothing() {
    let [law, ..] = laws();
    let runs = [([0.0; 3], 0.0), ([1e7, -2e7, 3e6], 1e4)].map(|(at, speed)| {
        shells(Precision::Single, &law, at).map(|mut patch| {
            let mut noise = Noise(3);
            patch.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = speed + noise.next()));
            patch.step(0.01);
            patch
        })
    });
    let [home, away] = runs;
    for (home, away) in home.iter().zip(&away) {
        let (force, _) = home.largest();
        for (a, b) in home.force.iter().flatten().zip(away.force.iter().flatten()) {
            assert!((a - b).abs() < 1e-6 * force, "{a} {b} of {force}");
        }
    }
}

pub fn solids(precision: Precision, steel: &Material, form: HourglassForm) -> Solids {
    let mut noise = Noise(17);
    let (mut nodes, mut cells) = (Vec::new(), Vec::new());
    let id = |i: u32, j: u32, k: u32| (k * 4 + j) * 4 + i;
    for k in 0..4 {
        for j in 0..4 {
            for i in 0..4 {
                nodes.push([i, j, k].map(|c| f64::from(c) + 0.1 * noise.next()));
                if i.max(j).max(k) < 3 {
                    let low = [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                    let [a, b, c, d] = low;
                    cells.push([a, b, c, d, a + 16, b + 16, c + 16, d + 16]);
                }
            }
        }
    }
    Solids::in_precision(precision, Part { hourglass: Some(form), ..part(0.0) }, steel.clone(), &nodes, &cells)
}

#[test]
fn solids_give_nearly_the_forces_of_double_precision() {
    for steel in laws() {
        for form in [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain] {
            let [long, short] = BOTH.map(|precision| {
                let mut all = solids(precision, &steel, form);
                let mut noise = Noise(29);
                for _ in 0..60 {
                    all.v.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] = 1.0 + 0.3 * noise.next()));
                    assert_eq!(all.step(0.01).trouble, None, "{}", steel.law);
                }
                all
            });
            let (size, sums) = (long.largest(), short.sums().0);
            for (a, b) in long.nodal().iter().flatten().zip(short.nodal().iter().flatten()) {
                assert!((a - b).abs() < 2e-5 * size, "{} {form:?}: {a} {b} of {size}", steel.law);
            }
            assert!(sums.iter().all(|s| s.abs() < 1e-13 * size), "{} {form:?}: {sums:?} of {size}", steel.law);
        }
    }
}

/// The step of single precision is never longer, and shorter by less than a thousandth; nu = 0 makes equal numbers of which the
/// difference is taken.
#[test]
fn the_stable_step_is_not_longer_than_in_double_precision() {
    let mut noise = Noise(41);
    for poisson in [0.0, 0.3, 0.49] {
        let law = material("elastic", 7.85e-6, &[("youngs_modulus", E), ("poisson", poisson)]);
        for round in 0..400 {
            // Squares and cubes first, then worse and worse.
            let size = 1e-3 * f64::from(round);
            let mut moved = |x: [f64; 3]| x.map(|c| 5.0 * c + size * noise.next());
            let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(&mut moved);
            let cube: [[f64; 3]; 8] = [0, 1, 2, 3, 4, 5, 6, 7]
                .map(|c| moved([[0.0, 1.0, 1.0, 0.0][c % 4], (c / 2 % 2) as f64, (c / 4) as f64]));
            let triangle = &[[0, 1, 2, 2]];
            let steps = BOTH.map(|precision| {
                let shell = |cells| Patch::in_precision(precision, part(1.0), law.clone(), &square, cells).forces(0.0);
                let mut solid =
                    Solids::in_precision(precision, part(0.0), law.clone(), &cube, &[[0, 1, 2, 3, 4, 5, 6, 7]]);
                [shell(&[[0, 1, 2, 3]]).stable_dt, shell(triangle).stable_dt, solid.forces(0.0).stable_dt]
            });
            for (long, short) in steps[0].iter().zip(steps[1]) {
                assert!(short <= *long && short > 0.999 * long, "nu {poisson}, round {round}: {long} {short}");
            }
        }
    }
}

/// A single step far beyond yield, up to a thousand times: powers of the trial stress must not leave the range of f32.
#[test]
fn large_trials_return_to_the_yield_surface() {
    let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for yield_stress in [YIELD, 1e-2, 1e-4] {
        let steel = steel("j2", &[("yield_stress", Param::Number(yield_stress))]);
        let mut patch =
            Patch::in_precision(Precision::Single, Part { points: 2, ..part(0.1) }, steel, &nodes, &[[0, 1, 2, 3]]);
        patch.forces(0.0);
        let strain = f64::min(0.3, 1e3 * yield_stress / E);
        patch.aim(1.0, |x| [x[0] * (1.0 + strain), x[1] * (1.0 - 0.2 * strain), 0.0], [0.0; 3]);
        assert_eq!(patch.step(1.0).trouble, None);
        let off = patch.fields(0).von_mises / yield_stress - 1.0;
        assert!(off.abs() < 1e-5, "yield stress {yield_stress}: off by {off:e}");
    }
}
