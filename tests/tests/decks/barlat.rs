//! Sheets of Barlat and Lian in decks: parameters, what is refused, written decks. Units mm, ms,
//! kg, so kN and GPa.

use crate::base::{BASE, MOVES, PULLED, assert_refused, assert_same_when_written, model_of};
use crumple::input::job::Model;

/// The base with a cube of steel and a plate of these cards.
fn plate(cards: &str) -> String {
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    format!("{base}{MOVES}*MAT_ELASTIC\n2,7.85e-6,207.0,0.3\n{cards}")
}

const CURVE: &str = "*DEFINE_CURVE\n21\n0.0,0.12\n0.1,0.2\n0.4,0.25\n";

fn parameter(model: &Model, key: &str) -> String {
    let sheet = model.job.material.iter().find(|m| m.law == "barlat").expect("a sheet");
    sheet.parameters.get(key).map_or(String::new(), |value| value.to_string())
}

#[test]
fn fields_become_parameters() {
    let linear = "*MAT_036\n1,2.7e-6,70.0,0.33,1,0.7,0.12\n8,0.67,0.43,0.71\n2\n0,0,0,1,1,0\n";
    let model = model_of(&plate(linear));
    for (key, value) in [
        ("youngs_modulus", "70.0"),
        ("poisson", "0.33"),
        ("exponent", "8.0"),
        ("lankford_0", "0.67"),
        ("lankford_45", "0.43"),
        ("lankford_90", "0.71"),
        ("yield_stress", "0.12"),
        ("hardening_modulus", "0.7070707070707071"),
        ("direction", "[1.0, 1.0, 0.0]"),
        ("angle", ""),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    // e0 given; the strain spi; the stress spi; the elastic line: k e0^n = E e0.
    let swift = |e0: &str| {
        let card =
            format!("*MAT_036\n1,2.7e-6,70.0,0.33,2,0.5,0.2\n8,1,1,1,,{e0}\n3\n\n0,1,0,,,,20\n");
        let model = model_of(&plate(&card));
        assert_eq!(parameter(&model, "angle"), "-70.0");
        assert_eq!(parameter(&model, "direction"), "[0.0, 1.0, 0.0]");
        let list = parameter(&model, "swift");
        let numbers: Vec<f64> = list
            .trim_matches(['[', ']'])
            .split(", ")
            .map(|n| n.parse().expect("a number"))
            .collect();
        assert_eq!((numbers[0], numbers[2]), (0.5, 0.2));
        numbers[1]
    };
    assert_eq!([swift("0.003"), swift(",0.004")], [0.003, 0.004]);
    let start = swift(",0.15");
    assert!((0.5 * start.powf(0.2) - 0.15).abs() < 1e-12, "{start}");
    let start = swift("");
    assert!((0.5 * start.powf(0.2) - 70.0 * start).abs() < 1e-12, "{start}");
    let curve = "*MAT_036\n1,2.7e-6,70.0,0.33,3\n6,1.8,1.3,2.2,21\n0\n\n0,0,0,0,0,0,30\n";
    let model = model_of(&plate(&format!("{curve}{CURVE}")));
    assert_eq!(
        parameter(&model, "hardening"),
        "[[0.0, 0.12], [0.1, 0.2], [0.4, 0.25], [10.0, 1.8499999999999994]]"
    );
    assert_eq!(parameter(&model, "angle"), "30.0");
}

#[test]
fn what_is_not_supported_is_refused() {
    for (card, words) in [
        (
            "*MAT_036\n1,2.7e-6,70.0,0.33,4,0.5,0.2\n8,-31,1,1\n1.0,40.0,5.0\n",
            &["`hr` = 4", "`r00` = -31", "`aopt` = 1", "`c` = 40", "`p` = 5"][..],
        ),
        (
            "*MAT_036\n1,2.7e-6,70.0,0.33,1,80.0,0.2\n8,1,1,1\n",
            &["the tangent modulus 80 is not below"],
        ),
        ("*MAT_036\n1,2.7e-6,70.0,0.33,3\n1.5,1,1,1,99\n", &["no *DEFINE_CURVE with the id 99"]),
        (
            "*MAT_036\n1,2.7e-6,70.0,0.33,1,0.5,0.2\n1.5,1,0,1\n",
            &["exponent is 1.5", "lankford_45 is 0"],
        ),
    ] {
        assert_refused(&plate(card), words);
    }
}

/// A written deck has the same digest as the one it was read from, with plastic flow.
#[test]
fn a_written_deck_is_the_same_model() {
    let cards = [
        "*MAT_036\n1,2.7e-6,70.0,0.33,1,0.7,0.012\n8,0.67,0.43,0.71\n2\n0,0,0,1,1,0\n".to_string(),
        "*MAT_036\n1,2.7e-6,70.0,0.33,2,0.05,0.2\n8,1,1,1,,0.004\n3\n\n0,1,0,,,,20\n".to_string(),
        format!("*MAT_036\n1,2.7e-6,70.0,0.33,3\n6,1.8,1.3,2.2,21\n0\n\n0,0,0,0,0,0,30\n{CURVE}"),
    ];
    for card in &cards {
        let text = format!("{}{PULLED}", plate(card).replace(MOVES, ""));
        assert_same_when_written(&text, "time.max_cycles=300", "*MAT_3-PARAMETER_BARLAT_TITLE");
    }
}
