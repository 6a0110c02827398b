//! Spot welds as solids in decks: limits, assemblies that fail together, what is refused. Units mm,
//! ms, kg, so kN and GPa.

use crate::base::{assert_refused, model_of};
use crumple::input::job::Model;
use crumple_proto::partition::Param;
use crumple_tests::program::{crumple_with, mpi_or_skip, mpirun, run};
use std::fs;

/// Two plates of steel with a weld of two solids of 2 by 2 by 1 between them; the upper plate is
/// pulled up on the side of the first solid. `cards` has the material 2 of the weld.
fn peel(cards: &str) -> String {
    let mut text = String::from(
        "*KEYWORD\n*CONTROL_TERMINATION\n0.5\n*PART\nlower\n1,1,1\nupper\n3,1,1\nweld\n2,2,2\n\
         *SECTION_SHELL\n1,2,1.0,3\n1.0\n*SECTION_SOLID\n2,1\n*MAT_ELASTIC\n1,7.85e-6,210.0,0.3\n\
         *NODE\n",
    );
    // Grids of three by two nodes at four heights: plates at 0 and 2, the weld from 0.5 to 1.5.
    for (level, z) in [0.0, 0.5, 1.5, 2.0].into_iter().enumerate() {
        for row in 0..2 {
            for column in 0..3 {
                let id = 10 * (level + 1) + 3 * row + column;
                text += &format!("{id},{},{},{z}\n", 2 * column, 2 * row);
            }
        }
    }
    for (part, first) in [(1, 10), (3, 40)] {
        text += "*ELEMENT_SHELL\n";
        for column in 0..2 {
            let n = first + column;
            text += &format!("{},{part},{n},{},{},{}\n", first + column, n + 1, n + 4, n + 3);
        }
    }
    text += "*ELEMENT_SOLID\n";
    for column in 0..2 {
        let n = 20 + column;
        let face = |n: usize| format!("{n},{},{},{}", n + 1, n + 4, n + 3);
        text += &format!("{},2,{},{}\n", 100 + column, face(n), face(n + 10));
    }
    text += "*SET_NODE_LIST\n1\n20,21,22,23,24,25\n*SET_NODE_LIST\n2\n30,31,32,33,34,35\n\
         *SET_PART_LIST\n3\n2\n*SET_PART_LIST\n4\n1,3\n\
         *CONTACT_SPOTWELD\n3,4,2,2\n\n\n\
         *SET_NODE_LIST\n5\n10,11,12,13,14,15\n*BOUNDARY_SPC_SET\n5,0,1,1,1,1,1,1\n\
         *SET_NODE_LIST\n6\n40,43\n*BOUNDARY_PRESCRIBED_MOTION_SET\n6,3,0,7\n\
         *DEFINE_CURVE\n7\n0,0\n0.1,0.5\n10,0.5\n";
    text + cards
}

const ASSEMBLY: &str = "*DEFINE_HEX_SPOTWELD_ASSEMBLY_2\n7\n100,101\n";

fn material(model: &Model) -> &std::collections::BTreeMap<String, Param> {
    &model.settings.materials.iter().find(|m| m.name == "mat-2").expect("the weld").parameters
}

/// Returns the limits of the normal and the shear stress.
fn limits(model: &Model) -> [f64; 2] {
    ["erosion_weld_normal_stress", "erosion_weld_shear_stress"].map(|key| {
        match material(model).get(key) {
            Some(Param::Number(limit)) => *limit,
            other => panic!("{key}: {other:?}"),
        }
    })
}

#[test]
fn limits_are_those_of_the_area_of_a_weld() {
    let forces = "*MAT_SPOTWELD\n2,7.85e-6,210.0,0.3,0.4,1.0\n0.0,2.0,1.6,1.6\n";
    // Each solid is a weld of 4 mm^2, or both are one of 8 mm^2.
    assert_eq!(limits(&model_of(&peel(forces))), [0.5, 0.4]);
    let together = model_of(&peel(&format!("{forces}{ASSEMBLY}")));
    assert_eq!(limits(&together), [0.25, 0.2]);
    assert_eq!(together.settings.failure_groups.len(), 1);
    assert_eq!(together.settings.failure_groups[0].len(), 2);
    let stresses = "*MAT_SPOTWELD_DAMAGE-FAILURE\n2,7.85e-6,210.0,0.3,0.4,1.0\n0.0,0.3,0.2\n\
                    0.0,1.0\n";
    let model = model_of(&peel(&format!("{stresses}{ASSEMBLY}")));
    assert_eq!(limits(&model), [0.3, 0.2]);
    let damage =
        "*MAT_SPOTWELD_DAMAGE-FAILURE\n2,7.85e-6,210.0,0.3,0.4,1.0\n0.1,2.0,1.6,1.6\n0.3\n";
    let model = model_of(&peel(damage));
    assert_eq!(material(&model).get("softening"), Some(&Param::List(vec![0.1, 0.3])));
    assert_eq!(material(&model).get("failure_strain"), None);
    // With damage the solids fail one by one, unless asff is 1.
    for (asff, groups) in [("0", 0), ("1", 1)] {
        let cards = damage.replace("\n0.3\n", &format!("\n0.3,0,0,0,{asff}\n"));
        let model = model_of(&peel(&format!("{cards}{ASSEMBLY}")));
        assert_eq!(model.settings.failure_groups.len(), groups, "asff {asff}");
    }
    let endless = "*MAT_SPOTWELD\n2,7.85e-6,210.0,0.3,0.4,1.0\n";
    let model = model_of(&peel(&format!("{endless}{ASSEMBLY}")));
    assert!(model.settings.failure_groups.is_empty());
}

#[test]
fn what_is_not_supported_is_refused() {
    let forces = "*MAT_SPOTWELD\n2,7.85e-6,210.0,0.3,0.4,1.0\n0.0,2.0,1.6,1.6\n";
    let with = |third: &str| {
        format!("*MAT_SPOTWELD_DAMAGE-FAILURE\n2,7.85e-6,210.0,0.3,0.4\n0.1,0.3,0.2\n{third}\n")
    };
    for (cards, words) in [
        (format!("{forces}*DEFINE_HEX_SPOTWELD_ASSEMBLY\n7\n100,999\n"), "there is no solid 999"),
        (format!("{forces}{ASSEMBLY}{ASSEMBLY}"), "element 100 is in group `weld-7` already"),
        (with("0.0,3.0"), "use 0 (forces) or 1"),
        (with("0.05,1.0"), "complete at efail or before"),
        (with("0.3,1.0,0,0,0,0.5"), "another law"),
        (with("0.3,1.0,0,0,0,0,0,1"), "another course of damage"),
        ("*MAT_SPOTWELD\n2,7.85e-6,210.0,0.3,-4\n0.0,2.0,1.6,1.6\n".into(), "a curve of the yield"),
    ] {
        assert_refused(&peel(&cards), &[words]);
    }
    // The second solid is wider by half.
    let wide = peel(forces).replace("22,4,0,", "22,5,0,").replace("25,4,2,", "25,5,2,");
    let wide = wide.replace("32,4,0,", "32,5,0,").replace("35,4,2,", "35,5,2,");
    assert_refused(&wide, &["areas from 4.0000 to 6.0000"]);
    let wedge =
        peel(forces).replace("101,2,21,22,25,24,31,32,35,34", "101,2,21,22,25,25,31,32,35,35");
    assert_refused(&wedge, &["solid 101 is a spot weld with limits, and no hexahedron"]);
    let stresses = "*MAT_SPOTWELD_DAMAGE-FAILURE\n2,7.85e-6,210.0,0.3\n0.0,0.3,0.2\n0.0,1.0\n";
    let wedge = wedge.replace(forces, stresses);
    assert_refused(&wedge, &["erosion_weld_normal_stress is for hexahedra only"]);
}

/// The solid on the pulled side fails first. As an assembly the other one fails with it, on any
/// number of workers; alone it holds.
#[test]
fn an_assembly_fails_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let deck = path.to_str().unwrap();
    let weld = "*MAT_SPOTWELD_DAMAGE-FAILURE\n2,7.85e-6,210.0,0.3\n0.0,0.3,3.0\n0.0,1.0\n";
    let failed = |cards: &str, workers: &str| {
        fs::write(&path, format!("{}*END\n", peel(cards))).unwrap();
        let args = ["run", deck, "--workers", workers, "--set", "time.max_cycles=400"];
        let ended = run(crumple_with(&args)).with_code(0);
        let parts = ended.summary()["parts"].as_array().expect("parts").clone();
        let failed: u64 = parts.iter().filter_map(|part| part["failed"].as_u64()).sum();
        (failed, ended.digest())
    };
    assert_eq!(failed(weld, "1").0, 1);
    let both = format!("{weld}{ASSEMBLY}");
    let one = failed(&both, "1");
    assert_eq!(one.0, 2);
    assert_eq!(failed(&both, "2"), one);
    if mpi_or_skip().is_some() {
        let args = ["run", deck, "--set", "time.max_cycles=400"];
        assert_eq!(run(mpirun(3, &args)).with_code(0).digest(), one.1);
    }
}
