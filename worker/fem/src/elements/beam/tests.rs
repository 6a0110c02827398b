//! Tests of one beam with prescribed motion of its ends.

use super::*;
use crate::columns::HistoryColumns;
use crate::elements::build_block;
use crate::elements::testing::{elastic, part, passed, settings};
use crumple_math::lanes::LANES;
use crumple_proto::job::{BeamInput, Part, Precision};
use crumple_proto::mesh::OwnSection;

fn rectangle() -> BeamInput {
    BeamInput {
        section: BeamSection::Rectangle,
        height: 0.4,
        width: 0.2,
        flange: 0.0,
        web: 0.0,
        radius: 0.0,
        wall: 0.0,
        area: 0.0,
        second_moments: [0.0; 2],
        torsion: 0.0,
        shear_areas: [0.0; 2],
        weld: None,
        contact_radius: None,
        preload: Vec::new(),
        preload_bending: false,
    }
}

fn beam(section: BeamInput) -> Box<dyn Element> {
    let part = Part { beam: Some(section), ..part(0.0) };
    build_block(&settings(part, elastic(2.0, 0.3, 1.0)), 0, Shape::Beam2)
        .unwrap_or_else(|e| panic!("{e:?}"))
}

/// Returns forces and moments of a beam whose ends move through `places` with rotational velocities
/// `w` in steps of 1.
fn led(section: BeamInput, places: &[[V3; 2]], w: &[[V3; 2]]) -> [V3; 3] {
    let beam = beam(section);
    let mut fresh = vec![0.0; beam.columns()];
    beam.start(&mut fresh, OwnSection::default());
    beam.orient(&mut fresh, [0.3, 1.0, 0.2]);
    let mut history = HistoryColumns::new(Precision::Double, 1, beam.columns());
    history.set(0, &fresh);
    let groups = [[0u32; LANES], [1; LANES]];
    let row = |v: V3| [v.x, v.y, v.z, 0.0];
    let (mut force, mut moment) = ([[0.0; 4]; 2 * LANES], [[0.0; 4]; 2 * LANES]);
    for (k, x) in places.iter().enumerate() {
        let before = places[k.saturating_sub(1)];
        let v = [0, 1].map(|c| row(x[c] - before[c]));
        let (x, w) = (x.map(row), if k == 0 { [[0.0; 4]; 2] } else { w[k - 1].map(row) });
        let nodes = crate::nodes::NodeView { x: &x, v: &v, w: &w };
        let out = crate::elements::ElementNodalForces { force: &mut force, moment: &mut moment };
        let dt = if k == 0 { 0.0 } else { 1.0 };
        let (groups, history) = (groups.as_flattened(), history.as_mut());
        let done = passed((1, LANES, LANES), |energies| {
            beam.forces(ElementPass {
                range: 0..1,
                count: 1,
                groups,
                history,
                unstrained: &mut [],
                nodes,
                dt,
                least_dt: 0.0,
                step_factors: &[],
                out,
                energies,
            })
        });
        assert_eq!(done.trouble, None);
    }
    [force[1], moment[0], moment[1]].map(|r| V3::new(r[0], r[1], r[2]))
}

/// A beam that is rotated by several full turns about a slanted axis in large steps, and moved, has
/// no force beyond round-off: 100 products of quaternions.
#[test]
fn no_rotation_strains_it() {
    let axis = V3::new(1.0, -2.0, 0.5).normalize() * 0.4;
    let turned = |k: usize, p: V3| {
        Rotation::from_scaled_axis(axis * k as f64) * p + V3::new(0.1, 0.2, -0.3) * k as f64
    };
    let ends = [V3::new(1.0, 0.2, 0.0), V3::new(3.0, 0.5, 0.4)];
    let places: Vec<[V3; 2]> = (0..=100).map(|k| ends.map(|p| turned(k, p))).collect();
    let [force, first, last] = led(rectangle(), &places, &[[axis; 2]; 100]);
    let largest = force.norm() + first.norm() + last.norm();
    assert!(largest < 1e-12, "round-off, with E A = 0.16: {largest}");
}

/// Ends that rotate by 2e-3 relative to the line and to each other, and separate by 1e-3: the
/// textbook stiffness, also after a large rotation.
#[test]
fn it_has_the_stiffness_of_a_beam() {
    let (e, g, length) = (2.0, 1.0 / 1.3, 2.0);
    let (iy, iz, area) = (0.4 * 0.008 / 12.0, 0.2 * 0.064 / 12.0, 0.08);
    for turn in [Rotation::identity(), Rotation::from_euler_angles(0.4, 1.2, -0.7)] {
        // Axes of the section: the vector towards the second one is (0.3, 1, 0.2).
        let along = V3::x();
        let third = along.cross(&V3::new(0.3, 1.0, 0.2)).normalize();
        let axes = frame(&along, &third.cross(&along));
        let start = [V3::zeros(), along * length];
        let whole = start.map(|p| turn * p);
        let stretched = [whole[0], whole[1] + turn * along * 1e-3];
        let own = [V3::new(1e-3, 2e-3, 0.0), V3::new(-1e-3, 0.0, 2e-3)];
        let rates = [[turn.scaled_axis(); 2], own.map(|w| turn * (axes * w))];
        let [force, first, last] = led(rectangle(), &[start, whole, stretched], &rates)
            .map(|f| axes.inverse() * (turn.inverse() * f));
        let torsion = 0.229 * 0.4 * 0.008;
        let about = |i: f64, near: f64, far: f64| e * i / length * (4.0 * near + 2.0 * far);
        let expected = [
            V3::new(g * torsion / length * 2e-3, about(iy, 2e-3, 0.0), about(iz, 0.0, 2e-3)),
            V3::new(-g * torsion / length * 2e-3, about(iy, 0.0, 2e-3), about(iz, 2e-3, 0.0)),
        ];
        assert!((force.x / (e * area * 1e-3 / length) - 1.0).abs() < 1e-9, "{force}");
        for (ours, exact) in [first, last].iter().zip(expected) {
            assert!(
                (ours.x / exact.x - 1.0).abs() < 0.01,
                "constant to three digits: {ours} {exact}"
            );
            assert!(
                (ours.y / exact.y - 1.0).abs() < 1e-3 && (ours.z / exact.z - 1.0).abs() < 1e-3,
                "{ours} {exact}"
            );
        }
        let shear = (first + last) / (length + 1e-3);
        assert!(
            (force.z - shear.y).abs() < 1e-6 * shear.norm()
                && (force.y + shear.z).abs() < 1e-6 * shear.norm()
        );
    }
}

/// Equal rotations of both ends also shear a short beam: `12 E I/(L (1 + phi))` per rotation
/// (Przemieniecki 1968, eq. 5.116); opposite rotations do not. Once fibres yield the moments are
/// those of the fibres, and the shear strain follows from them.
#[test]
fn short_beams_shear() {
    let (e, g, length) = (2.0, 1.0 / 1.3, 2.0);
    let areas = [0.05, 0.07];
    let job = BeamInput { shear_areas: areas, ..rectangle() };
    let start = [V3::zeros(), V3::x() * length];
    let third = V3::x().cross(&V3::new(0.3, 1.0, 0.2)).normalize();
    let axes = frame(&V3::x(), &third.cross(&V3::x()));
    let places = [start; 11];
    let of = |axis: V3, signs: [f64; 2]| {
        let rates = [signs.map(|sign| axes * axis * (1e-4 * sign)); 10];
        let [force, first, last] = led(job.clone(), &places, &rates).map(|f| axes.inverse() * f);
        (force, first.dot(&axis), last.dot(&axis))
    };
    for (axis, i, area) in
        [(V3::y(), 0.4 * 0.008 / 12.0, areas[1]), (V3::z(), 0.2 * 0.064 / 12.0, areas[0])]
    {
        let phi = 12.0 * e * i / (g * area * length * length);
        assert!(phi > 0.01, "shear is not negligible: {phi}");
        let (force, first, last) = of(axis, [1.0, 1.0]);
        let exact = 6.0 * e * i / length / (1.0 + phi) * 1e-3;
        assert!(
            (first / exact - 1.0).abs() < 1e-5 && (last / exact - 1.0).abs() < 1e-5,
            "{first} {last} {exact}"
        );
        assert!(
            (force.norm() / (2.0 * exact / length) - 1.0).abs() < 1e-5,
            "{force} balances the moments"
        );
        let (_, first, last) = of(axis, [1.0, -1.0]);
        let exact = 2.0 * e * i / length * 1e-3;
        assert!(
            (first / exact - 1.0).abs() < 1e-5 && (last / exact + 1.0).abs() < 1e-5,
            "{first} {last} {exact}"
        );
    }
}

/// A general section with the area and moments of a rectangle gives its forces, to round-off of
/// sums over fibres; without moments it has a force along its line alone.
#[test]
fn a_general_section_is_its_moments() {
    let [area, about_y, about_z, torsion] = FibreSection::new(&rectangle()).moments();
    let none =
        BeamInput { section: BeamSection::General, height: 0.0, width: 0.0, area, ..rectangle() };
    let general = BeamInput { second_moments: [about_y, about_z], torsion, ..none.clone() };
    let ends = [V3::new(1.0, 0.2, 0.0), V3::new(3.0, 0.5, 0.4)];
    let moved = [ends[0], ends[1] + V3::new(1e-3, 2e-3, -1e-3)];
    let turns = [[V3::zeros(); 2], [V3::new(1e-3, 2e-3, 0.0), V3::new(-1e-3, 0.0, 2e-3)]];
    let of = |section| led(section, &[ends, moved, moved], &turns);
    let (wanted, ours, truss) = (of(rectangle()), of(general), of(none));
    for (ours, wanted) in ours.iter().zip(&wanted) {
        assert!((ours - wanted).norm() < 1e-12 * wanted.norm(), "{ours} {wanted}");
    }
    let line = (moved[1] - moved[0]).normalize();
    assert_eq!(truss[1..], [V3::zeros(); 2]);
    assert!(
        (truss[0] - line * wanted[0].dot(&line)).norm() < 1e-12 * wanted[0].norm(),
        "{}",
        truss[0]
    );
}

/// Each limit alone, at a half and at the whole of it; tension only; combined loads add up.
#[test]
fn welds_break_at_their_limits() {
    let weld = Weld { normal: 2.0, shear: 3.0, bending: 5.0, torsion: 7.0, exponents: [1.0, 4.0] };
    let broken = |along, across, bent, torque| weld_is_broken(&weld, along, across, bent, torque);
    assert!(
        broken(2.0, 0.0, 0.0, 0.0) && !broken(1.99, 0.0, 0.0, 0.0) && !broken(-9.0, 0.0, 0.0, 0.0)
    );
    assert!(
        broken(0.0, 3.0, 0.0, 0.0) && broken(0.0, 0.0, 5.0, 0.0) && broken(0.0, 0.0, 0.0, -7.0)
    );
    assert!(!broken(0.5, 1.5, 2.5, 3.5), "1/4 + 1/16 + 1/4 + 1/4");
    assert!(broken(0.88, 1.5, 2.5, 3.5), "0.44 + 1/16 + 1/4 + 1/4");
    let unlimited = Weld { normal: 0.0, shear: 0.0, bending: 0.0, ..weld };
    assert!(
        !weld_is_broken(&unlimited, 1e9, 1e9, 1e9, 0.0)
            && weld_is_broken(&unlimited, 0.0, 0.0, 0.0, 7.0)
    );
}
