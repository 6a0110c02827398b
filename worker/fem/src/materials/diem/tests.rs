//! Damage by onset and displacement against closed forms. Units mm, ms, kg.

use super::*;
use crate::materials::testing::{Cube, Sheet, material, problems, table};
use crumple_proto::partition::Param;

const E: f64 = 200.0;
const YIELD: f64 = 0.2;
const MODULUS: f64 = 0.3;
const SIZE: f64 = 2.0;

fn metal(modulus: f64, numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let own = [
        ("youngs_modulus", E),
        ("poisson", 0.3),
        ("yield_stress", YIELD),
        ("hardening_modulus", modulus),
    ];
    material("j2", &[&own, numbers].concat(), others)
}

/// A curve through a strain at one value of the measure, and other strains at other values.
fn onset(measure: f64, strain: f64) -> Param {
    table(&[[measure - 0.1, 3.0 * strain], [measure, strain], [measure + 0.1, 4.0 * strain]])
}

/// Paths of a cube: increment, free axes, and the measures without and with a factor of 0.3 of the
/// pressure: triaxiality, (q + k p)/tau, (q + k p)/s_1.
type OfPath = ([f64; 6], &'static [usize], [f64; 3]);

fn paths() -> [OfPath; 2] {
    let root = 3.0_f64.sqrt();
    [
        ([2e-5, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], [1.0 / 3.0, 2.0 * 0.9, 0.9]),
        ([0.0, 0.0, 0.0, 4e-5, 0.0, 0.0], &[], [0.0, root, root]),
    ]
}

fn follow(cube: &mut Cube, (strain, free, _): &OfPath) {
    match free.is_empty() {
        true => _ = cube.step(*strain, 1.0),
        false => cube.pull(*strain, free, 1.0),
    }
}

/// In tension and in shear each criterion begins at its strain; then the damage is the plastic
/// displacement over that to failure.
#[test]
fn each_criterion_has_a_closed_form() {
    let (begins, end) = (0.02, 0.05);
    for path in paths() {
        for (keys, measure) in CRITERIA.iter().zip(path.2) {
            let factor: Vec<_> = keys.pressure.map(|key| (key, 0.3)).into_iter().collect();
            let numbers = [&[(keys.displacement, end)], &factor[..]].concat();
            let law = metal(MODULUS, &numbers, &[(keys.onset, onset(measure, begins))]);
            let mut cube = Cube::new(&law);
            cube.set(SIZE_COLUMN, SIZE);
            loop {
                follow(&mut cube, &path);
                if cube.at("failed") == 1.0 {
                    break;
                }
                let strain = cube.at("plastic_strain");
                let damage = (SIZE * (strain - begins) / end).max(0.0);
                assert!(damage < 1.0, "{}: it fails", keys.onset);
                let exact = (YIELD + MODULUS * strain) * (1.0 - damage);
                let off = cube.von_mises() - exact;
                assert!(strain == 0.0 || off.abs() < 1e-8, "{} {strain}: {off}", keys.onset);
            }
            let strain = cube.at("plastic_strain");
            let exact = begins + end / SIZE;
            assert!((strain - exact).abs() < 5e-5, "{}: {strain} {exact}", keys.onset);
        }
    }
    let keys = &CRITERIA[0];
    let law =
        metal(MODULUS, &[(keys.displacement, end)], &[(keys.onset, onset(1.0 / 3.0, begins))]);
    let mut sheet = Sheet::new(&law);
    // Columns: plastic strain, w, u, size, damage, failure.
    assert_eq!(sheet.state.len(), 9);
    sheet.state[6] = SIZE;
    while sheet.state[8] == 0.0 {
        sheet.pull(2e-5, 1.0);
        let damage = (SIZE * (sheet.state[3] - begins) / end).max(0.0);
        let exact = (YIELD + MODULUS * sheet.state[3]) * (1.0 - damage);
        let is_plastic = sheet.state[3] > 0.0 && sheet.state[8] == 0.0;
        assert!(!is_plastic || (sheet.state[0] - exact).abs() < 1e-8);
        assert!((sheet.state[7] - damage.min(1.0)).abs() < 1e-12, "the damage of all criteria");
    }
}

/// The plastic work from onset to failure, times the size, is the fracture energy where the matrix
/// does not harden, whatever the size.
#[test]
fn the_fracture_energy_does_not_depend_on_the_size() {
    let keys = &CRITERIA[0];
    let energy = 0.004;
    for size in [0.5, 2.0, 5.0] {
        let law = metal(0.0, &[(keys.energy, energy)], &[(keys.onset, onset(1.0 / 3.0, 0.02))]);
        let mut cube = Cube::new(&law);
        cube.set(SIZE_COLUMN, size);
        let mut work = 0.0;
        while cube.at("failed") == 0.0 {
            let (strain, stress) = (cube.at("plastic_strain"), cube.state[0]);
            follow(&mut cube, &paths()[0]);
            let more = cube.at("plastic_strain") - strain;
            if cube.at("diem ductile onset") >= 1.0 {
                work += 0.5 * (stress + cube.state[0]) * more;
            }
        }
        assert!((work * size / energy - 1.0).abs() < 0.005, "{size}: {}", work * size);
    }
}

/// The larger damage of two criteria counts; those that are multiplied leave the product of what
/// each leaves.
#[test]
fn criteria_are_combined() {
    let measures = paths()[0].2;
    let numbers = [
        (CRITERIA[0].displacement, 0.05),
        (CRITERIA[1].displacement, 0.08),
        ("diem_shear_pressure", 0.3),
    ];
    let curves = [
        (CRITERIA[0].onset, onset(measures[0], 0.03)),
        (CRITERIA[1].onset, onset(measures[1], 0.02)),
    ];
    for multiplied in [false, true] {
        let flags = [0, 1].map(|k| (CRITERIA[k].multiplied, Param::Flag(multiplied)));
        let others = [&curves[..], &flags].concat();
        let mut cube = Cube::new(&metal(MODULUS, &numbers, &others));
        cube.set(SIZE_COLUMN, SIZE);
        while cube.at("failed") == 0.0 {
            let strain = cube.at("plastic_strain");
            let damages = [(0.03, 0.05), (0.02, 0.08)]
                .map(|(begins, end)| (SIZE * (strain - begins) / end).clamp(0.0, 1.0));
            let left = match multiplied {
                true => (1.0 - damages[0]) * (1.0 - damages[1]),
                false => 1.0 - damages[0].max(damages[1]),
            };
            let exact = (YIELD + MODULUS * strain) * left;
            assert!(strain == 0.0 || (cube.state[0] - exact).abs() < 1e-8, "{multiplied} {strain}");
            follow(&mut cube, &paths()[0]);
        }
        let first = if multiplied { 0.055 } else { 0.055_f64.min(0.06) };
        assert!((cube.at("plastic_strain") - first).abs() < 5e-5);
    }
}

/// In compression without any tension the principal stress gives no damage.
#[test]
fn compression_has_no_principal_damage() {
    let keys = &CRITERIA[2];
    let law = metal(MODULUS, &[(keys.displacement, 0.1)], &[(keys.onset, onset(0.0, 1e-4))]);
    let mut cube = Cube::new(&law);
    cube.set(SIZE_COLUMN, SIZE);
    (0..4000).for_each(|_| cube.pull([-2e-5, 0.0, 0.0, 0.0, 0.0, 0.0], &[1, 2], 1.0));
    assert!(cube.at("plastic_strain") > 0.05);
    assert_eq!(cube.at("diem principal onset"), 0.0);
}

/// Without a displacement to failure a point fails at onset.
#[test]
fn a_displacement_of_zero_fails_at_onset() {
    let keys = &CRITERIA[0];
    let law = metal(MODULUS, &[(keys.displacement, 0.0)], &[(keys.onset, onset(1.0 / 3.0, 0.02))]);
    let mut cube = Cube::new(&law);
    while cube.at("failed") == 0.0 {
        follow(&mut cube, &paths()[0]);
    }
    assert!((cube.at("plastic_strain") - 0.02).abs() < 2e-5);
}

#[test]
fn wrong_onsets_are_refused_at_once() {
    let numbers = [
        ("diem_shear_displacement", 1.0),
        ("diem_shear_pressure", 1.0),
        ("diem_failed_points", 0.5),
        ("diem_ductil", 1.0),
    ];
    let curves = [
        ("diem_ductile", table(&[[0.0, 0.1], [0.0, 0.2]])),
        ("diem_principal", table(&[[0.0, 0.1]])),
    ];
    let text = problems(&metal(MODULUS, &numbers, &curves));
    for words in [
        "diem_shear_displacement is given without diem_shear",
        "diem_shear_pressure is given without diem_shear",
        "diem_failed_points is 0.5",
        "diem_ductile is not such a curve",
        "diem_principal has no way to failure",
        "'diem_ductile'?",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let text = problems(&metal(MODULUS, &[("diem_failed_points", 1.0)], &[]));
    assert!(text.contains("without a criterion"), "{text}");
    let both = [("gissmo_failure_strain", onset(0.0, 0.1)), ("diem_ductile", onset(0.0, 0.1))];
    let text = problems(&metal(MODULUS, &[("diem_ductile_displacement", 1.0)], &both));
    assert!(text.contains("is given with gissmo_failure_strain"), "{text}");
    let glass = [("youngs_modulus", E), ("poisson", 0.3), ("diem_ductile_displacement", 1.0)];
    let text = problems(&material("elastic", &glass, &[("diem_ductile", onset(0.0, 0.1))]));
    assert!(text.contains("no plastic strain"), "{text}");
}
