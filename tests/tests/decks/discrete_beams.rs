//! Discrete beams in decks: cards and jobs, exports, errors. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, refused, with};
use crumple::input::job::{Model, read};
use crumple_proto::job::{
    AxisSpring, BeamAxis, BeamFailure, BetweenCurvesSpring, DiscreteBeamInput, TurningNode,
};
use crumple_proto::mesh::Shape;
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// Two parts of discrete beams between the cube and the plate; the second one has axes.
const PARTS: &str = "*PART\nlinear\n3,3,66\ncurves\n4,4,67\n\
    *SECTION_BEAM\n3,6,0,0,0,-1.0\n0.5,2.0e-3\n4,6\n0.25,3.0e-3,9\n\
    *DEFINE_COORDINATE_SYSTEM\n9,0,0,0,0,1,0\n-1,0,0\n\
    *ELEMENT_BEAM\n101,3,5,11\n102,4,6,12,7\n";
const LAWS: &str = "*MAT_LINEAR_ELASTIC_DISCRETE_BEAM\n66,4.0e-3,0.5,0.0,0.25,,2.0\n0.125\n\
    *MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM\n67,8.0e-3,5,,,,,6\n,,,,7\n\
    *DEFINE_CURVE\n5\n0.0,0.0\n1.0,0.5\n2.0,0.75\n\
    *DEFINE_CURVE\n6\n-1.0,-2.0\n1.0,3.0\n*DEFINE_CURVE\n7\n-1.0,-0.5\n0.0,0.0\n1.0,0.25\n";

fn beam(model: &Model, id: u32) -> DiscreteBeamInput {
    let part = model.job.part.iter().find(|part| part.id == id).expect("the part");
    part.discrete_beam.clone().expect("a discrete beam")
}

#[test]
fn cards_become_discrete_beams() {
    let model = with(&format!("{PARTS}{LAWS}"));
    let linear = beam(&model, 3);
    assert_eq!((linear.mass, linear.inertia), (2e-3, 2e-3));
    assert_eq!(
        (linear.axes, linear.turns_with),
        ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], TurningNode::First)
    );
    let springs: Vec<_> = linear.spring.iter().map(|s| (s.axis, s.stiffness, s.damping)).collect();
    let exact = [(BeamAxis::R, 0.5, 0.125), (BeamAxis::T, 0.25, 0.0), (BeamAxis::Rs, 2.0, 0.0)];
    assert_eq!(springs, exact);
    let curves = beam(&model, 4);
    assert_eq!((curves.mass, curves.inertia), (2e-3, 3e-3));
    assert_eq!(curves.axes, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    let axes: Vec<_> = curves.spring.iter().map(|s| s.axis).collect();
    assert_eq!(axes, [BeamAxis::R, BeamAxis::Rs, BeamAxis::Rt]);
    let both = [[-2.0, -0.75], [-1.0, -0.5], [0.0, 0.0], [1.0, 0.5], [2.0, 0.75]];
    assert_eq!(curves.spring[0].force_elongation, both, "the same in both directions");
    assert_eq!(curves.spring[1].force_rate, [[-1.0, -0.5], [0.0, 0.0], [1.0, 0.25]]);
    assert_eq!(curves.spring[2].force_elongation, [[-1.0, -2.0], [1.0, 3.0]]);
    let lines: Vec<_> = model.mesh.elements.iter().filter(|e| e.shape == Shape::Line2).collect();
    let ends: Vec<_> = lines.iter().map(|e| [e.nodes[0].0, e.nodes[1].0]).collect();
    assert_eq!(ends, [[5, 11], [6, 12]]);
}

/// A law with a card for each axis gives the springs of the other two laws.
#[test]
fn laws_with_a_card_for_each_axis_become_springs() {
    let general = "*MAT_GENERAL_SPRING_DISCRETE_BEAM\n66,4.0e-3\n1,0,0.5,0.125\n\n\
                   3,0,0.25\n\n5,0,9.0\n5\n*MAT_196\n67,8.0e-3\n5,0,2.0\n\
                   *DEFINE_CURVE\n5\n0.0,0.0\n1.0,0.5\n2.0,0.75\n";
    let model = with(&format!("{PARTS}{general}"));
    let first = beam(&model, 3);
    let springs: Vec<_> = first.spring.iter().map(|s| (s.axis, s.stiffness, s.damping)).collect();
    let exact = [(BeamAxis::R, 0.5, 0.125), (BeamAxis::T, 0.25, 0.0), (BeamAxis::Rs, 0.0, 0.0)];
    assert_eq!(springs, exact);
    let both = [[-2.0, -0.75], [-1.0, -0.5], [0.0, 0.0], [1.0, 0.5], [2.0, 0.75]];
    assert_eq!(first.spring[2].force_elongation, both);
    assert_eq!(beam(&model, 4).spring[0].axis, BeamAxis::Rs);

    // Without a curve of yield forces type 1 is elastic.
    let yields = general.replace("3,0,0.25", "3,1,0.25");
    assert_eq!(beam(&with(&format!("{PARTS}{yields}")), 3), first);

    let wrong = general.replace("1,0,0.5,0.125", "7,0,0.5");
    let said = refused(&format!("{PARTS}{wrong}"));
    assert!(said.contains("`dof` is 7"), "{said}");
    let wrong = general.replace("5,0,2.0\n", "5,0,2.0\n0,0,0.1,0.2,,5\n").replace("3,0,", "3,2,");
    let said = refused(&format!("{PARTS}{wrong}"));
    for words in
        ["`type` = 2 is not supported", "`c1` = 0.1 is not", "`c2` = 0.2 is", "`glcid` = 5"]
    {
        assert!(said.contains(words), "no {words} in\n{said}");
    }
}

/// Springs on an axis that yield, with curves of rates and limits; scoor 2 lays r along the line.
#[test]
fn springs_that_yield_and_fail() {
    let plastic = "*MAT_068\n66,4.0e-3,0.5,0.25,0.25,,2.0,2.0\n0.125\n5\n9.0\n,0.75,0.75\n0.1\n\
                   *MAT_196\n67,8.0e-3\n1,1,100.0,0.5,2.0,4.0\n5,6\n2,0,3.0\n\n3,0,3.0\n\n\
                   *DEFINE_CURVE\n5\n0.0,0.5\n1.0,0.75\n*DEFINE_CURVE\n6\n0.0,0.0\n2.0,3.0\n";
    let parts = PARTS.replace("4,6\n0.25,3.0e-3,9", "4,6,0,0,0,2.0\n0.25,3.0e-3");
    let parts = parts.replace("102,4,6,12,7", "102,4,6,12");
    let model = with(&format!("{parts}{plastic}"));
    let first = beam(&model, 3);
    assert_eq!((first.failure, first.along_line), (BeamFailure::Together, false));
    let on = |beam: &DiscreteBeamInput, axis| -> AxisSpring {
        beam.spring.iter().find(|spring| spring.axis == axis).expect("a spring").clone()
    };
    let r = on(&first, BeamAxis::R);
    let law = r.yielding.expect("a law");
    assert_eq!((law.stiffness, &law.yield_force[..]), (0.5, &[[0.0, 0.5], [1.0, 0.75]][..]));
    assert_eq!((r.stiffness, r.damping, r.preload, r.failure_force), (0.0, 0.125, 0.1, Some(9.0)));
    let s = on(&first, BeamAxis::S);
    assert_eq!(
        (s.stiffness, s.failure_tension, s.failure_compression),
        (0.25, Some(0.75), Some(0.75))
    );
    let second = beam(&model, 4);
    assert_eq!((second.failure, second.turns_with), (BeamFailure::Any, TurningNode::Second));
    assert!(second.along_line);
    let r = on(&second, BeamAxis::R);
    assert_eq!(r.yielding.expect("a law").stiffness, 100.0);
    assert_eq!((r.failure_tension, r.failure_compression), (Some(4.0), Some(2.0)));
    assert_eq!(r.force_rate, [[-2.0, -4.0], [0.0, 0.0], [2.0, 4.0]], "with 0.5 of the rate");
    assert_eq!(r.damping, 0.0);

    let said = refused(&format!("{parts}{}", plastic.replace("3,0,3.0", "3,0,4.0")));
    assert!(said.contains("`scoor` = 2 is not supported: the springs on s and t differ"), "{said}");
    // Limits of tension alone would depend on the direction of s and t.
    let torn =
        plastic.replace("2,0,3.0\n", "2,0,3.0,,,1.0\n").replace("3,0,3.0\n", "3,0,3.0,,,1.0\n");
    let said = refused(&format!("{parts}{torn}"));
    assert!(said.contains("`scoor` = 2 is not supported"), "{said}");
    let parts = parts.replace("102,4,6,12", "102,4,6,17") + "*NODE\n17,10.0,0.0,10.0\n";
    let said = refused(&format!("{parts}{plastic}"));
    assert!(said.contains("the nodes of discrete beam 102 are at one place"), "{said}");
    let said = refused(&format!("{PARTS}{}", plastic.replace("66,4.0e-3,0.5", "66,4.0e-3,-5.0")));
    assert!(said.contains("`tkr` = -5 is not supported: a curve of elastic forces"), "{said}");
}

/// Cards of the law with curves of loading and unloading, by its option.
fn unloading(option: &str) -> String {
    format!(
        "*MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM\n66,4.0e-3,{option}\n5,6,0,5\n\
         7,0,0,7\n8\n\n2.0,0.0,0.0,0.5,0.0,0.0,1.0\n1.0\n0.25\n\
         *DEFINE_CURVE\n5\n-1.0,-2.0\n0.0,0.0\n1.0,4.0\n\
         *DEFINE_CURVE\n6\n0.0,0.0\n1.0,3.0\n\
         *DEFINE_CURVE\n7\n-1.0,-1.0\n0.0,0.0\n1.0,2.0\n\
         *DEFINE_CURVE\n8\n-1.0,-0.5\n1.0,0.5\n"
    )
}

/// Each option of unloading becomes its law; curves are as they are.
#[test]
fn options_of_unloading_become_laws() {
    let of = |option: &str| {
        let second = "*MAT_067\n67,8.0e-3,5,,,,,6\n,,,,7\n";
        beam(&with(&format!("{PARTS}{}{second}", unloading(option))), 3)
    };
    let loading = [[-1.0, -2.0], [0.0, 0.0], [1.0, 4.0]];
    let below = [[-1.0, -1.0], [0.0, 0.0], [1.0, 2.0]];
    let elastic = of("0.0,0.0,0");
    assert_eq!(elastic.failure, BeamFailure::Together);
    let axes: Vec<_> = elastic.spring.iter().map(|s| s.axis).collect();
    assert_eq!(axes, [BeamAxis::R, BeamAxis::S, BeamAxis::Rr]);
    let r = &elastic.spring[0];
    assert_eq!(r.force_elongation, loading);
    assert_eq!(elastic.spring[1].force_elongation, [[0.0, 0.0], [1.0, 3.0]], "not mirrored");
    assert_eq!(r.force_rate, [[-1.0, -0.5], [1.0, 0.5]]);
    assert_eq!((r.failure_tension, r.failure_compression), (Some(2.0), Some(1.0)));
    assert_eq!((r.initial_displacement, elastic.spring[2].failure_tension), (0.25, Some(0.5)));
    let steep = of("8.0,9.0,2");
    let line = |stiffness| {
        let [loading, unloading] = [loading, below].map(|curve| curve.to_vec());
        Some(BetweenCurvesSpring { loading, unloading, stiffness })
    };
    assert_eq!(steep.spring[0].between_curves, line(8.0));
    assert_eq!(steep.spring[2].between_curves, line(9.0));
    assert_eq!(steep.spring[1].force_elongation, [[0.0, 0.0], [1.0, 3.0]]);
    let set = of("0.0,0.0,3,0.5").spring[0].permanent_set.clone().expect("a law");
    assert_eq!((&set.loading[..], set.fraction), (&loading[..], 0.5));
    let steeper = unloading("0.0,0.0,1").replace("-1.0,-1.0\n0.0,0.0\n1.0,2.0", "0.0,0.0\n1.0,5.0");
    let second = "*MAT_067\n67,8.0e-3,5,,,,,6\n,,,,7\n";
    let shifted = beam(&with(&format!("{PARTS}{steeper}{second}")), 3);
    let law = shifted.spring[0].hysteresis.clone().expect("a law");
    assert_eq!(
        (&law.loading[..], &law.unloading[..]),
        (&loading[..], &[[0.0, 0.0], [1.0, 5.0]][..])
    );

    let wrong = |cards: &str| refused(&format!("{PARTS}{cards}{second}"));
    for (option, words) in [
        ("0.0,0.0,1", "unloading is less steep than loading"),
        ("0.0,9.0,2", "`kt` = 0 is not supported: a stiffness that the program computes"),
        ("3.0,9.0,2", "stiffness is 3.0, a curve has the slope 4.0"),
        ("0.0,0.0,3,1.0", "fraction is 1"),
        ("0.0,0.0,4", "`iunld` = 4 is not supported"),
        ("0.0,0.0,0,0.0,0.0,2", "`iflag` = 2 is not supported"),
    ] {
        let said = wrong(&unloading(option));
        assert!(said.contains(words), "no {words} in\n{said}");
    }
    let said = wrong(&unloading("0.0,0.0,0").replace("\n8\n\n", "\n8\n9\n"));
    assert!(said.contains("damping that depends on the displacement"), "{said}");
}

/// An export has the cards; read again it is the same job, with the same bits.
#[test]
fn exported_discrete_beams_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [deck, again, radioss] =
        ["deck.k", "again.k", "again_0000.rad"].map(|name| folder.path().join(name));
    let text = format!("{BASE}{STEEL}{MOVES}{PARTS}{LAWS}*END\n").replace("\n10.0\n", "\n0.2\n");
    fs::write(&deck, text).unwrap();
    let [deck, again, radioss] = [&deck, &again, &radioss].map(|path| path.to_str().unwrap());
    let digest = |job| {
        run(crumple_with(&["run", job, "--workers", "1", "--no-report"])).with_code(0).digest()
    };
    run(crumple_with(&["export-deck", deck, "--out", again])).with_code(0);
    let text = fs::read_to_string(again).unwrap();
    for law in ["LINEAR", "NONLINEAR"] {
        let card = format!("*MAT_{law}_ELASTIC_DISCRETE_BEAM_TITLE\n");
        assert!(text.contains(&card), "no {card} in\n{text}");
    }
    let [first, second] = [deck, again].map(|path| read(path.as_ref(), &[]).expect("a deck"));
    (3..=4).for_each(|part| assert_eq!(beam(&first, part), beam(&second, part)));
    assert_eq!(digest(deck), digest(again));
    // The other laws; limits and preloads of those above.
    let second = "*MAT_196\n67,8.0e-3\n1,1,100.0,0.5,2.0,4.0\n9,0\n2,0,3.0\n5,5\n3,0,3.0\n5,5\n";
    let curves = "*DEFINE_CURVE\n9\n0.0,0.5\n1.0,0.75\n";
    let limited = LAWS.replace(",,,,7\n", ",,,,7\n0.1\n0.5\n,,0.7\n");
    let plastic = "*MAT_068\n67,8.0e-3,0.5,0.25,0.25\n0.125\n9\n9.0\n,0.75,0.75\n0.1\n";
    let parts = PARTS.replace("4,6\n0.25,3.0e-3,9", "4,6,0,0,0,-2.0\n0.25,3.0e-3");
    let parts = parts.replace("102,4,6,12,7", "102,4,6,12");
    let first = LAWS.split("*MAT_NONLINEAR").next().unwrap_or_default();
    let only = format!("*DEFINE_CURVE{}", LAWS.split_once("*DEFINE_CURVE").unwrap_or_default().1);
    for (parts, laws, card) in [
        (PARTS, limited, "NONLINEAR_ELASTIC"),
        (&parts, format!("{first}{only}{second}{curves}"), "GENERAL_SPRING"),
        (PARTS, format!("{first}{only}{plastic}{curves}"), "NONLINEAR_PLASTIC"),
        (PARTS, unloading("0.0,0.0,0"), "GENERAL_NONLINEAR_6DOF"),
        (PARTS, unloading("8.0,9.0,2"), "GENERAL_NONLINEAR_6DOF"),
    ] {
        let laws = match card {
            "GENERAL_NONLINEAR_6DOF" => format!("{first}{}", laws.replace("\n66,", "\n67,")),
            _ => laws,
        };
        let text = format!("{BASE}{STEEL}{MOVES}{parts}{laws}*END\n");
        fs::write(deck, text).unwrap();
        run(crumple_with(&["export-deck", deck, "--overwrite", "--out", again])).with_code(0);
        let text = fs::read_to_string(again).unwrap();
        let card = format!("*MAT_{card}_DISCRETE_BEAM_TITLE\n");
        assert!(text.contains(&card), "no {card} in\n{text}");
        let [first, second] = [deck, again].map(|path| read(path.as_ref(), &[]).expect("a deck"));
        (3..=4).for_each(|part| assert_eq!(beam(&first, part), beam(&second, part)));
    }
    let ended = run(crumple_with(&["convert", deck, radioss]));
    assert!(ended.said().contains("discrete beams cannot be written"), "{}", ended.said());
}

/// Errors are reported at once, and what is not supported is named.
#[test]
fn wrong_cards_are_named() {
    let bad = PARTS.replace("0.5,2.0e-3", "0.0,-2.0e-3");
    let said = refused(&format!("{bad}{LAWS}"));
    let line = format!("{BASE}{STEEL}{MOVES}{PARTS}").lines().position(|l| l == "0.5,2.0e-3");
    let place = format!("deck.k:{}", line.expect("the section") + 1);
    for what in [place.as_str(), "mass is 0", "inertia is -0.002"] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let said = refused(&format!("{}{LAWS}", PARTS.replace("3.0e-3,9", "3.0e-3,19")));
    assert!(said.contains("*DEFINE_COORDINATE_... with the id 19"), "{said}");
    let parts = PARTS.replace("0,-1.0", "0,2.0").replace("3,5,11\n", "3,5,11,8\n");
    let said = refused(&format!("{parts}{LAWS}"));
    for what in [
        "`scoor` = 2 is not supported: the springs on s and t differ",
        "discrete beam 101 has a third node",
    ] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let said = refused(&format!("{}{LAWS}", PARTS.replace("3,3,66", "3,3,1")));
    assert!(said.contains("no *MAT_..._DISCRETE_BEAM"), "{said}");
    let said = refused(&format!("{}{LAWS}", PARTS.replace("linear\n", "linear\n5,1,66\nothers\n")));
    assert!(said.contains("part 5: material 66 is for discrete beams"), "{said}");
}
