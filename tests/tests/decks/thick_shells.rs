//! Thick shells of decks: a cantilever against the beam, ids, what is refused, written decks. Units
//! mm, ms, kg, so kN and GPa.

use crate::base::{BASE, MOVES, STEEL, assert_refused, assert_same_when_written, model_of};
use crumple_proto::mesh::Shape;
use crumple_tests::{run_alone, run_side_by_side};
use std::fmt::Write;

/// Number of elements along the cantilever, its length, width and thickness.
const COUNT: usize = 10;
const SIZE: [f64; 3] = [100.0, 10.0, 4.0];

/// A cantilever of one row of thick shells with this section, clamped at x = 0, with a dead load
/// of 0.01 at its end and damping that is critical for the first mode.
fn cantilever(section: &str, material: &str) -> String {
    let mut text = "*KEYWORD\n*CONTROL_TERMINATION\n6.0\n*PART\nsheet\n1,1,1\n*NODE\n".to_string();
    let at = |i: usize, corner: usize| 1 + 4 * i + corner;
    for i in 0..=COUNT {
        for (corner, [y, z]) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].iter().enumerate()
        {
            let x = SIZE[0] * i as f64 / COUNT as f64;
            let _ = writeln!(text, "{},{x},{},{}", at(i, corner), y * SIZE[1], z * SIZE[2]);
        }
    }
    text += "*ELEMENT_TSHELL\n";
    for i in 0..COUNT {
        let face = |z: usize| {
            format!("{},{},{},{}", at(i, z), at(i + 1, z), at(i + 1, z + 1), at(i, z + 1))
        };
        let _ = writeln!(text, "{},1,{},{}", i + 1, face(0), face(2));
    }
    for n in 0..4 {
        let _ = write!(text, "*BOUNDARY_SPC_NODE\n{},0,1,1,1\n", at(0, n));
        let _ = write!(text, "*LOAD_NODE_POINT\n{},3,1,0.0025\n", at(COUNT, n));
    }
    text + "*DEFINE_CURVE\n1\n0,1\n100,1\n*DAMPING_GLOBAL\n,4.17\n*SECTION_TSHELL\n"
        + section
        + "\n"
        + material
}

/// The deflection is P L^3/(3 E I), with the share of shear.
#[test]
fn a_cantilever_bends_as_a_beam() {
    let model = model_of(&cantilever("1,1,,3", STEEL));
    assert_eq!(model.job.part[0].element.as_deref(), Some("thick_shell"));
    assert_eq!(model.job.part[0].parameters["points"].to_string(), "3");
    assert!(model.mesh.elements.iter().all(|e| e.shape == Shape::Hex8));
    let end = run_alone(&model, |_| {});
    let deflection = end.nodes.x.iter().map(|x| x[2]).fold(0.0, f64::max) - SIZE[2];
    let [length, width, t] = SIZE;
    let bending = 0.01 * length.powi(3) / (0.25 * 207.0 * width * t.powi(3));
    let shear = 0.01 * length / (5.0 / 6.0 * 207.0 / 2.6 * width * t);
    let wanted = bending + shear;
    assert!((deflection / wanted - 1.0).abs() < 0.01, "{deflection} {wanted}");
}

/// Any number of workers gives the same bits, with thick shells that flow.
#[test]
fn bits_do_not_depend_on_the_workers() {
    let flows = "*MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.001,1.0\n";
    let model = model_of(&cantilever("1,1,,3", flows));
    let digest = |workers| run_side_by_side(&model, workers, 400, 0).digest();
    let one = digest(1);
    assert!([2, 3, 4].into_iter().all(|workers| digest(workers) == one));
}

/// A composite section has angles, and a blank number of points is 2.
#[test]
fn sections_become_parameters() {
    let model = model_of(&cantilever("1", STEEL));
    assert_eq!(model.job.part[0].parameters["points"].to_string(), "2");
    let plies = "*MAT_ENHANCED_COMPOSITE_DAMAGE\n1,1.6e-6,120.0,9.0,,0.02\n5.0,3.0,5.0,,2\n\
                 0,0,0,1,0,0\n0,0,0,0,1,0\n0,0,0,0\n2.0,1.0,0.05,0.2,0.07,54\n";
    let model = model_of(&cantilever("1,1,,2,,,1\n30,-30", plies));
    assert_eq!(model.job.part[0].angles, [30.0, -30.0]);
}

/// Solids may have the ids of thick shells.
#[test]
fn ids_of_solids_are_kept_apart() {
    let more = "*PART\nsheet\n3,3,1\n*SECTION_TSHELL\n3,1,,3\n*NODE\n21,0,0,30\n22,9,0,30\n\
                23,9,9,30\n24,0,9,30\n25,0,0,32\n26,9,0,32\n27,9,9,32\n28,0,9,32\n\
                *ELEMENT_TSHELL\n1,3,21,22,23,24,25,26,27,28\n";
    let model = model_of(&format!("{BASE}{STEEL}{MOVES}{more}"));
    let mut ids: Vec<(u64, u32)> =
        model.mesh.elements.iter().map(|e| (e.id.label(), e.part)).collect();
    ids.sort_unstable();
    assert_eq!(ids, [(1, 1), (2, 1), (101, 2), (111, 3)]);
    assert!(model.warnings.iter().all(|w| !w.message.contains("sheet")), "{:?}", model.warnings);
}

#[test]
fn what_is_not_supported_is_refused() {
    let repeated = cantilever("1,1,,3", STEEL).replace("1,1,1,5,6,2,", "1,1,1,5,6,6,");
    let of_solids = cantilever("1,1,,3", STEEL).replace("ELEMENT_TSHELL", "ELEMENT_SOLID");
    let section = cantilever("1,1,,3", STEEL).replace("SECTION_TSHELL", "SECTION_SOLID");
    let shell = cantilever("1,2,,3\n4.0", STEEL).replace("SECTION_TSHELL", "SECTION_SHELL");
    let unknown = "*MAT_CONCRETE_DAMAGE\n1,1e-6,0.2\n";
    for (deck, words) in [
        (repeated, "thick shell 1 has repeated nodes"),
        (of_solids, "part 1 has solids and *SECTION_TSHELL 1"),
        (section, "part 1 has thick shells and *SECTION_SOLID 1"),
        (shell, "part 1 has thick shells and *SECTION_SHELL 1"),
        (cantilever("1,4,,3", STEEL), "`elform` = 4"),
        (cantilever("1,1,,30", STEEL), "points is 30"),
        (cantilever("1,1,,3", unknown), "MAT_CONCRETE_DAMAGE"),
    ] {
        assert_refused(&deck, &[words]);
    }
}

/// Written decks give the same bits.
#[test]
fn a_written_deck_gives_the_same_bits() {
    let until = "end_time=0.2";
    assert_same_when_written(&cantilever("1,1,,3", STEEL), until, "*ELEMENT_TSHELL");
    let flows = "*MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.001,1.0\n";
    assert_same_when_written(&cantilever("1,1,,5", flows), until, "*SECTION_TSHELL");
}
