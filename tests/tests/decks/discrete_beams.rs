//! Discrete beams in decks: cards and jobs, exports, errors. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, refused, with};
use crumple::input::job::{Model, read};
use crumple_proto::job::{BeamAxis, DiscreteBeamInput, TurningNode};
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

    let wrong = general.replace("1,0,0.5,0.125", "7,0,0.5").replace("3,0,0.25", "3,1,0.25");
    let wrong = wrong.replace("5,0,2.0\n", "5,0,2.0,0.0,-1.0\n0,5\n");
    let said = refused(&format!("{PARTS}{wrong}"));
    for words in [
        "`dof` is 7",
        "springs that yield are not supported",
        "failure of discrete beams",
        "depend on the rate of the displacement",
    ] {
        assert!(said.contains(words), "no {words} in\n{said}");
    }
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
    let laws = LAWS.replace("2.0\n0.125\n", "2.0\n0.125\n0.1\n");
    let laws = laws.replace(",,,,7\n", ",,,,7\n0.0\n0.5\n,,0.7\n");
    let said = refused(&format!("{parts}{laws}"));
    for what in [
        "`scoor` = 2 is not supported",
        "discrete beam 101 has a third node",
        "`for` = 0.1 is not supported: a preload",
        "`ffailr` = 0.5 is not supported: failure",
        "`ufailt` = 0.7 is not supported: failure",
    ] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let said = refused(&format!("{}{LAWS}", PARTS.replace("3,3,66", "3,3,1")));
    assert!(said.contains("no *MAT_..._DISCRETE_BEAM"), "{said}");
    let said = refused(&format!("{}{LAWS}", PARTS.replace("linear\n", "linear\n5,1,66\nothers\n")));
    assert!(said.contains("part 5: material 66 is for discrete beams"), "{said}");
}
