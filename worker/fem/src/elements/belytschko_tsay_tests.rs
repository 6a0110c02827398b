//! Tests of the properties that only the four-node shell of Belytschko, Lin & Tsay has.

use super::super::quad::tests::singles_and_lanes;
use super::super::testing::*;
use super::*;
use crate::materials;
use crumple_math::lanes::Lane;
use crumple_proto::mesh::OwnSection;
use crumple_proto::partition::{Material, Param};

const E: f64 = 210.0;
const NU: f64 = 0.3;

fn quad(part: Part, material: Material, nodes: [[f64; 3]; 4]) -> Patch {
    Patch::new(part, material, &nodes, &[[0, 1, 2, 3]])
}

/// A distorted flat quad.
const SKEW: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.1, 0.1, 0.0], [1.3, 0.9, 0.0], [-0.1, 1.2, 0.0]];

#[test]
fn bending_patch_is_exact_on_rectangles() {
    // w = 1e-3 (x^2 + xy + y^2)/2 and its slopes, scaled by 1e-6 so that squared slopes are
    // negligible.
    let (nodes, quads) = grid(2, 2, 0.24, 0.12);
    let mut patch = Patch::new(part(0.001), elastic(1e12, 0.25, 1.0), &nodes, &quads);
    for (x, (v, w)) in patch.x.iter().zip(patch.v.iter_mut().zip(&mut patch.w)) {
        let (x, y) = (x[0], x[1]);
        // tx = w,y and ty = -w,x.
        *v = [0.0, 0.0, 0.5e-9 * (x * x + x * y + y * y), 0.0];
        *w = [1e-9 * (0.5 * x + y), -1e-9 * (x + 0.5 * y), 0.0, 0.0];
    }
    patch.step(1.0);
    for element in 0..4 {
        let at = |c: usize| patch.history.element(element).at(5 + 4 * 3 + c);
        // At the outermost of five Gauss points, 0.906 of the face.
        let face = 0.906179845938664;
        let why = "squared slopes of 2e-10, at a stiffness of 1e12";
        assert_close(at(0) / face, -2.0 / 3.0, 1e-6, why);
        assert_close(at(1) / face, -2.0 / 3.0, 1e-6, why);
        assert_close(at(2) / face, -0.2, 1e-6, why);
        let stress = patch.fields(element).stress;
        assert!(
            stress[4].abs() < 1e-4 && stress[5].abs() < 1e-4,
            "round-off of rotations, no shear: {stress:?}"
        );
    }
}

#[test]
fn hourglass_forces_vanish_in_linear_fields() {
    for form in [HourglassForm::Stiffness, HourglassForm::Viscous] {
        for warp in [0.0, 0.05, 0.2] {
            let mut nodes = SKEW;
            nodes[1][2] = warp;
            let part = part(0.01).with("hourglass", form.word()).with("hourglass_coefficient", 0.1);
            let mut noise = Noise(17);
            for _ in 0..20 {
                let mut patch = quad(part.clone(), elastic(E, NU, 1.0), nodes);
                let g = QuadGeometry::new(&super::super::quad::coordinate_modes(&nodes));
                let l: [[f64; 3]; 3] =
                    std::array::from_fn(|_| std::array::from_fn(|_| 1e-9 * noise.next()));
                for (node, at) in nodes.into_iter().enumerate() {
                    // Linear in the coordinates of the plane; out of the plane, the corresponding
                    // rotation.
                    let x = g.frame.local(at);
                    let v: [f64; 3] = std::array::from_fn(|i| l[i][0] * x[0] + l[i][1] * x[1]);
                    let v = [v[0] - l[2][0] * x[2], v[1] - l[2][1] * x[2], v[2]];
                    let w: [f64; 3] = std::array::from_fn(|i| l[2][i] * x[0] + l[i][2] * x[1]);
                    patch.v[node][..3].copy_from_slice(&g.frame.global(v));
                    patch.w[node][..3].copy_from_slice(&g.frame.global([w[0], w[1], 0.0]));
                }
                patch.forces(1.0);
                let columns = patch.element.columns();
                for column in columns - HOURGLASS - DRILLING..columns - DRILLING {
                    let value = patch.history.element(0).at(column);
                    assert!(
                        value.abs() < 1e-12 * 1e-9 * E,
                        "round-off: warp {warp}, column {column}: {value:e}"
                    );
                }
            }
        }
    }
}

/// A membrane resists stretching as the shell does. Curvature, transverse shear and drilling meet
/// no force at all.
#[test]
fn a_membrane_has_no_moments() {
    let (t, l, size) = (0.1, 2.0, 1e-9);
    let square = [[0.0, 0.0, 0.0], [l, 0.0, 0.0], [l, l, 0.0], [0.0, l, 0.0]];
    for membrane in [false, true] {
        let new = || quad(part(t).with("membrane", membrane), elastic(E, NU, 1.0), square);
        let largest =
            |rows: &[[f64; 4]]| rows.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut patch = new();
        for (w, x) in patch.w.iter_mut().zip(&patch.x) {
            *w = [size * x[1], size * (x[0] + 1.0), size * x[0], 0.0];
        }
        patch.forces(1.0);
        let resistance = largest(&patch.moment).max(largest(&patch.force));
        if membrane {
            assert!(resistance < 1e-12 * E * size, "{resistance}");
        } else {
            assert!(resistance > 1e-3 * E * size, "the shell bends: {resistance}");
        }
        let mut patch = new();
        patch.v.iter_mut().zip(&patch.x).for_each(|(v, x)| v[0] = size * x[0]);
        patch.forces(1.0);
        let wanted = E / (1.0 - NU * NU) * size * t * 0.5 * l;
        assert_close(patch.corner(0, 1).0[0], wanted, 1e-6 * wanted, "squared strains of 1e-9");
    }
}

/// The yarns of a fabric follow the vector that its material names, in any element, or the side of
/// the nodes 1 and 2 with an angle.
#[test]
fn yarns_of_a_fabric_follow_their_direction() {
    let (stiff, soft, t, l, size) = (100.0, 1.0, 0.1, 2.0, 1e-9);
    let square = [[0.0, 0.0, 0.0], [l, 0.0, 0.0], [l, l, 0.0], [0.0, l, 0.0]];
    let force = |first: usize, key: &str, value: Param| {
        let mut fabric = material(
            "fabric",
            1.0,
            &[("youngs_modulus", stiff), ("poisson", 0.0), ("youngs_modulus_b", soft)],
        );
        fabric.parameters.insert(key.into(), value);
        // The same square, numbered from another corner.
        let cell: [u32; 4] = std::array::from_fn(|c| ((c + first) % 4) as u32);
        let mut patch = Patch::new(part(t).with("membrane", true), fabric, &square, &[cell]);
        patch.v.iter_mut().zip(&patch.x).for_each(|(v, x)| v[0] = size * x[0]);
        patch.forces(1.0);
        let corner = (0..4).find(|c| cell[*c] == 1).unwrap();
        patch.corner(0, corner).0[0] / (size * t * 0.5 * l)
    };
    for first in 0..4 {
        let along = |x: f64, y: f64| force(first, "direction", Param::List(vec![x, y, 0.3]));
        assert_close(along(1.0, 0.0), stiff, 1e-6 * stiff, "pulled along the yarns a");
        assert_close(along(0.0, 2.0), soft, 1e-6 * stiff, "pulled along the yarns b");
        let turned = force(first, "angle", Param::Number(90.0));
        let wanted = if first % 2 == 0 { soft } else { stiff };
        assert_close(turned, wanted, 1e-6 * stiff, "at 90 degrees to the first side");
    }
}

/// Each of the five modes alone has its stiffness.
#[test]
fn hourglass_modes_have_their_stiffness() {
    let (t, l, r, size) = (0.1, 2.0, 0.05, 1e-9);
    let square = [[0.0, 0.0, 0.0], [l, 0.0, 0.0], [l, l, 0.0], [0.0, l, 0.0]];
    let bb = 2.0 / (l * l);
    let g = 0.5 * E / (1.0 + NU);
    let membrane = r * E * t * l * l * bb / 8.0;
    let w = r * SHEAR_CORRECTION * g * t * t * t * bb / 12.0;
    let theta = r * E * t * t * t * l * l * bb / 192.0;
    for (mode, stiffness) in [(0, membrane), (1, membrane), (2, w), (3, theta), (4, theta)] {
        let part = part(t).with("hourglass_coefficient", r);
        let mut patch = quad(part, elastic(E, NU, 1.0), square);
        for (node, h) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
            if mode < 3 {
                patch.v[node][mode] = size * h
            } else {
                patch.w[node][mode - 3] = size * h
            }
        }
        patch.forces(1.0);
        let (force, moment) = patch.corner(0, 0);
        let value = if mode < 3 { force[mode] } else { moment[mode - 3] };
        assert_close(
            value,
            4.0 * stiffness * size,
            1e-7 * stiffness * size,
            "strains of 1e-9 squared",
        );
    }
}

/// Each mode and the spin of the nodes are driven far beyond yield and back. A plastic part reaches
/// its fraction of the plastic capacity of a square; the force of an elastic part keeps growing.
#[test]
fn stabilising_forces_of_a_plastic_part_are_bounded() {
    let (t, l, sig, size) = (0.1, 2.0, 0.25, 1.0);
    let square = [[0.0, 0.0, 0.0], [l, 0.0, 0.0], [l, l, 0.0], [0.0, l, 0.0]];
    let membrane = 0.03 * sig * t * l / 4.0;
    let bending = 0.03 * sig * t * t * l / 16.0;
    let twist = 0.03 * sig * t * t / (2.0 * 3.0_f64.sqrt());
    let drilling = 0.01 * sig * t * t * l / 16.0;
    let bounds = [membrane, membrane, twist, bending, bending, drilling];
    let law = |law: &str, more: &[(&str, f64)]| {
        let mut numbers = vec![("youngs_modulus", E), ("poisson", NU)];
        numbers.extend(more);
        material(law, 1.0, &numbers)
    };
    let after = |form: HourglassForm, material: &Material, mode: usize, steps: &[f64]| {
        let mut patch = quad(part(t).with("hourglass", form.word()), material.clone(), square);
        for &sense in steps {
            for (node, h) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
                match mode {
                    0..3 => patch.v[node][mode] = sense * size * h,
                    3 | 4 => patch.w[node][mode - 3] = sense * size * h,
                    _ => patch.w[node][2] = sense * size,
                }
            }
            // Fast enough that the viscous form also reaches its bound.
            patch.forces(1e-3);
        }
        let (force, moment) = patch.corner(0, 0);
        if mode < 3 { force[mode] } else { moment[(mode - 3).min(2)] }
    };
    let steel = law("j2", &[("yield_stress", sig)]);
    let (there, back) = ([1.0; 800], [vec![1.0; 800], vec![-1.0; 800]].concat());
    for (mode, bound) in bounds.into_iter().enumerate() {
        for form in [HourglassForm::Stiffness, HourglassForm::Viscous] {
            assert_close(after(form, &steel, mode, &there), bound, 1e-12 * bound, "round-off");
            assert_close(after(form, &steel, mode, &back), -bound, 1e-12 * bound, "round-off");
        }
        let elastic = after(HourglassForm::Stiffness, &law("elastic", &[]), mode, &there);
        assert!(elastic > 1.5 * bound, "mode {mode}: {elastic} is not much more than {bound}");
    }
}

/// One point needs only the area between the diagonals: a concave quad has the strain of any linear
/// field.
#[test]
fn concave_quads_are_sound_and_collapsed_ones_are_trouble() {
    let dart = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
    let mut patch = quad(part(0.1), elastic(E, NU, 1.0), dart);
    for (x, v) in patch.x.iter().zip(patch.v.iter_mut()) {
        *v = [1e-6 * x[0], 0.0, 0.0, 0.0];
    }
    assert!(patch.forces(1.0).trouble.is_none());
    let stress = patch.fields(0).stress;
    assert_close(stress[0], 1e-6 * E / (1.0 - NU * NU), 1e-11 * E, "strains of 1e-6 squared");
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 1e-9, 0.0], [3.0, 0.0, 0.0]];
    assert!(quad(part(0.1), elastic(E, NU, 1.0), line).forces(1.0).trouble.is_some());
}

/// The kernel gives the same bits on scalars and on lanes.
#[test]
fn lanes_are_the_scalar_kernel() {
    let rate = ("cowper_symonds".to_string(), Param::List(vec![0.04, 5.0]));
    let mut steel =
        material("j2", 7.8e-6, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25)]);
    steel.parameters.extend([rate]);
    for hourglass in [HourglassForm::Stiffness, HourglassForm::Viscous] {
        let part = part(0.05).with("thinning", true);
        let law = || materials::build(&steel).map_err(|p| format!("{p:?}")).unwrap();
        let section = || {
            Section::new(&part, &ROW.values(&part), law()).map_err(|p| format!("{p:?}")).unwrap()
        };
        let shell = Shell(Quad(BelytschkoTsay {
            membrane: false,
            section: section(),
            hourglass,
            hourglass_coefficient: 0.05,
            warping: true,
            drilling: 0.01,
        }));
        let wide = singles_and_lanes(
            &shell,
            |g, modes, history| shell.0.0.respond::<Lane, 5>(g, modes, history, 0.5),
            |g, modes, history| shell.0.0.respond::<f64, 5>(g, modes, history, 0.5),
        );
        let plastic = wide.map(|fields| fields.plastic_strain);
        assert!(plastic[0] == 0.0 && plastic[3] > 0.0, "elastic and plastic lanes: {plastic:?}");
    }
}

#[test]
fn stable_step_is_that_of_waves_or_little_more_than_a_lone_element_bears() {
    let c = (E / (7.8e-6 * (1.0 - NU * NU))).sqrt();
    let step = |nodes: [[f64; 3]; 4]| {
        let mut patch = quad(part(1.0), elastic(E, NU, 7.8e-6), nodes);
        let dt = patch.element.stable_dt(&nodes, OwnSection::default());
        assert_eq!(
            patch.forces(1.0).stable_dt.to_bits(),
            dt.to_bits(),
            "the kernel and the single call give the same bits"
        );
        dt * c
    };
    let square = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 5.0, 0.0], [0.0, 5.0, 0.0]];
    assert_close(step(square), 1.05 * 5.0 / (1.0 + NU).sqrt(), 1e-12, "round-off");
    // Area over the longest side, for which a single element is stable to more than 0.952 of it.
    assert_close(step(square.map(|x| [3.0 * x[0], x[1], 0.0])), 5.0, 1e-12, "round-off");
    let trapezoid = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
    assert_close(step(trapezoid), 6.0 / 4.0, 1e-12, "round-off");
    let (mass, inertia) = quad(part(1.0), elastic(E, NU, 7.8e-6), square)
        .element
        .corner_mass(&square, OwnSection::default());
    assert_close(mass, 7.8e-6 * 25.0 / 4.0, 1e-18, "round-off");
    let floor = 25.0 / (4.0 * (2.75 / (1.0 - NU) - 1.0));
    assert_close(
        inertia,
        mass * floor,
        1e-18,
        "round-off; a thin section uses A/11.7 for nu = 0.3",
    );
}

#[test]
fn thinning_keeps_the_volume_of_plastic_flow() {
    let steel =
        material("j2", 7.8e-6, &[("youngs_modulus", E), ("poisson", NU), ("yield_stress", 0.25)]);
    let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut patch = quad(part(0.1).with("thinning", true), steel, nodes);
    for _ in 0..2000 {
        patch.aim(1.0, |x| [x[0] * 1.0001, x[1] * 1.00005, x[2]], [0.0; 3]);
        patch.step(1.0);
    }
    let area = patch.x[2][0] * patch.x[2][1];
    let elastic = 3.0 * 0.25 * (1.0 - 2.0 * NU) / E;
    assert_close(
        patch.fields(0).thickness * area / 0.1,
        1.0,
        elastic,
        "only the elastic bulk strain remains",
    );
}
