//! Springs with a memory in decks: cards and jobs, exports, errors. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, refused, with};
use crumple::input::job::{Model, read};
use crumple_proto::job::{
    ElastoplasticSpring, HysteresisSpring, MaxwellSpring, OneSidedSpring, SpringHardening,
    SpringInput, SpringSide,
};
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// Four parts of springs, one for each law, at the corners of the plate. Those of part 4 are scaled
/// by 0.5.
const PARTS: &str = "*PART\nyields\n3,3,13\nloops\n4,3,16\nrelaxes\n5,3,17\ncrushes\n6,3,18\n\
    *SECTION_DISCRETE\n3\n\n\
    *ELEMENT_DISCRETE\n101,3,5,11\n102,4,6,12,0,0.5\n103,5,7,15\n104,6,8,14\n\
    *DEFINE_CURVE\n8\n-2.0,-6.0\n0.0,0.0\n1.0,4.0\n2.0,5.0\n\
    *DEFINE_CURVE\n9\n-1.0,-8.0\n0.0,0.0\n1.0,10.0\n\
    *DEFINE_CURVE\n10\n0.0,0.0\n1.0,2.0\n";
const LAWS: &str = "*MAT_SPRING_ELASTOPLASTIC\n13,4.0,0.5,0.75\n\
    *MAT_SPRING_GENERAL_NONLINEAR\n16,8,9,1.0,2.0,-3.0\n\
    *MAT_SPRING_MAXWELL\n17,4.0,1.0,0.25,8.0,0.125,1\n*MAT_SPRING_INELASTIC\n18,10,5.0,-1.0\n";

/// Returns the spring of a part.
fn spring(model: &Model, id: u32) -> SpringInput {
    let part = model.job.part.iter().find(|part| part.id == id).expect("the part");
    part.spring.clone().expect("a spring")
}

#[test]
fn cards_become_laws_with_a_memory() {
    let model = with(&format!("{PARTS}{LAWS}"));
    let elastoplastic =
        ElastoplasticSpring { stiffness: 4.0, tangent_stiffness: 0.5, yield_force: 0.75 };
    assert_eq!(spring(&model, 3).elastoplastic, Some(elastoplastic));
    let hysteresis = HysteresisSpring {
        loading: vec![[-2.0, -3.0], [0.0, 0.0], [1.0, 2.0], [2.0, 2.5]],
        unloading: vec![[-1.0, -4.0], [0.0, 0.0], [1.0, 5.0]],
        hardening: SpringHardening::Isotropic,
        yield_forces: Some([-1.5, 1.0]),
    };
    assert_eq!(spring(&model, 4).hysteresis, Some(hysteresis));
    let maxwell = MaxwellSpring {
        short_time_stiffness: 4.0,
        long_time_stiffness: 1.0,
        decay: 0.25,
        ageing: true,
        cutoff_time: Some(8.0),
        cutoff_force: 0.125,
    };
    assert_eq!(spring(&model, 5).maxwell, Some(maxwell));
    let one_sided = OneSidedSpring {
        loading: vec![[0.0, 0.0], [1.0, 2.0]],
        unloading_stiffness: 5.0,
        carries: SpringSide::Tension,
    };
    assert_eq!(spring(&model, 6).one_sided, Some(one_sided));
    let said = crumple::input::check::describe(&model);
    let line = "part 4: *MAT_SPRING_GENERAL_NONLINEAR scaled by 0.5 -> springs with hysteresis";
    assert!(said.contains(line), "{said}");
    // Blanks: no hardening, independent sides, no cutoff, compression.
    let blank = "*MAT_S03\n13,4.0,,0.75\n*MAT_S06\n16,8,9,,2.0\n*MAT_S07\n17,4.0,1.0,0.25\n\
                 *MAT_S08\n18,10\n";
    let model = with(&format!("{PARTS}{blank}"));
    assert_eq!(spring(&model, 3).elastoplastic.map(|law| law.tangent_stiffness), Some(0.0));
    let hysteresis = spring(&model, 4).hysteresis.expect("a law");
    assert_eq!(hysteresis.hardening, SpringHardening::Independent);
    assert_eq!(hysteresis.yield_forces, None);
    let maxwell = spring(&model, 5).maxwell.expect("a law");
    assert_eq!((maxwell.ageing, maxwell.cutoff_time), (false, None));
    let one_sided = spring(&model, 6).one_sided.expect("a law");
    assert_eq!(one_sided.carries, SpringSide::Compression);
    let unused = model.warnings.iter().any(|w| w.message.contains("`tyi` = 2 is not used"));
    assert!(unused, "tyi is for isotropic hardening");
}

/// An export has the cards of the laws; read again it is the same job, with the same bits.
#[test]
fn exported_laws_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [deck, again, radioss] =
        ["deck.k", "again.k", "again_0000.rad"].map(|name| folder.path().join(name));
    let held = "*BOUNDARY_SPC_NODE\n5,0,1,1,1\n6,0,1,1,1\n7,0,1,1,1\n8,0,1,1,1\n";
    let text =
        format!("{BASE}{STEEL}{MOVES}{PARTS}{LAWS}{held}*END\n").replace("\n10.0\n", "\n0.5\n");
    fs::write(&deck, text).unwrap();
    let [deck, again, radioss] = [&deck, &again, &radioss].map(|path| path.to_str().unwrap());
    let digest = |job| {
        run(crumple_with(&["run", job, "--workers", "1", "--no-report"])).with_code(0).digest()
    };
    run(crumple_with(&["export-deck", deck, "--out", again])).with_code(0);
    let text = fs::read_to_string(again).unwrap();
    for law in ["ELASTOPLASTIC", "GENERAL_NONLINEAR", "MAXWELL", "INELASTIC"] {
        assert!(text.contains(&format!("*MAT_SPRING_{law}_TITLE\n")), "no {law} in\n{text}");
    }
    assert!(!text.contains("spring"), "keys without a card in\n{text}");
    let [first, second] = [deck, again].map(|path| read(path.as_ref(), &[]).expect("a deck"));
    (3..=6).for_each(|part| assert_eq!(spring(&first, part), spring(&second, part)));
    assert_eq!(digest(deck), digest(again));
    run(crumple_with(&["export-deck", deck, "--out", radioss])).with_code(0);
    let third = read(radioss.as_ref(), &[]).expect("a deck");
    (3..=6).for_each(|part| assert_eq!(spring(&first, part), spring(&third, part)));
}

/// Errors of several laws are reported at once, at their lines.
#[test]
fn wrong_laws_are_named_at_their_lines() {
    let lines = "*MAT_SPRING_ELASTOPLASTIC\n13,4.0,5.0,-1.0\n\
                 *MAT_SPRING_GENERAL_NONLINEAR\n16,9,8\n\
                 *MAT_SPRING_MAXWELL\n17,4.0,6.0\n*MAT_SPRING_INELASTIC\n18,8\n";
    let said = refused(&format!("{PARTS}{lines}"));
    let line = format!("{BASE}{STEEL}{MOVES}{PARTS}").lines().count() + 2;
    for what in [
        &format!("deck.k:{line}"),
        "yield_force is -1",
        "tangent_stiffness is 5",
        "unloading is less steep than loading",
        "long_time_stiffness is 6",
        "loading begins at [-2.0, -6.0]",
    ] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let kinematic = LAWS.replace("8,9,1.0", "8,9,0.5").replace("5.0,-1.0", "5.0,2.0");
    let said = refused(&format!("{PARTS}{kinematic}"));
    assert!(said.contains("`beta` = 0.5 is not supported: kinematic hardening"), "{said}");
    assert!(said.contains("`ctf` = 2 is not supported"), "{said}");
    let said = refused(&format!("{PARTS}{}", LAWS.replace("16,8,9", "16,48,49")));
    assert!(said.contains("with the id 48") && said.contains("with the id 49"), "{said}");
}
