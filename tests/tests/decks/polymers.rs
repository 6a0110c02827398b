//! Thermoplastics of decks: keys by the cards, what is refused, the deck that is written.

use crate::base::{BASE, MOVES, assert_refused, assert_same_when_written, cube, model_of, number};
use crumple_proto::partition::{Material, Param};

fn material_of(cards: &str) -> Material {
    model_of(&cube(cards)).settings.materials[0].clone()
}

fn table(material: &Material, key: &str) -> Vec<Vec<f64>> {
    match material.parameters.get(key) {
        Some(Param::Table(rows)) => rows.clone(),
        other => panic!("{key}: {other:?}"),
    }
}

const CURVES: &str = "*DEFINE_CURVE\n5\n0,0.03\n0.5,0.03\n*DEFINE_CURVE\n6\n0,0.04\n0.5,0.04\n\
                      *DEFINE_CURVE\n7\n0,0.02\n0.5,0.02\n*DEFINE_CURVE\n8\n0,0.35\n0.2,0.1\n\
                      *DEFINE_CURVE\n9\n0,0\n0.5,0.3\n*DEFINE_CURVE\n10\n0,0.05\n0.5,0.05\n\
                      *DEFINE_TABLE_2D\n20\n0.001,5\n1.0,10\n";

/// Returns the cards with numint, the second and third card, and the fourth.
fn samp(numint: &str, curves: &str, damage: &str, form: &str) -> String {
    format!(
        "*MAT_SAMP-1\n1,1e-6,2.2,0.74,2.0,0.35,0,{numint}\n{curves}\n{damage}\n{form}\n{CURVES}"
    )
}

#[test]
fn cards_of_polymers_are_keys_of_the_law() {
    let law = material_of(&samp("2", "5,6,7,0,0.2", "9,0.4,0.1", "0,0,0,0,1,1.2"));
    assert_eq!(law.law, "polymer");
    assert_eq!([number(&law, "youngs_modulus"), number(&law, "poisson")], [2.0, 0.35]);
    for (key, stress) in [("tension", 0.03), ("compression", 0.04), ("shear", 0.02)] {
        assert_eq!(table(&law, key), [[0.0, stress], [0.5, stress]], "{key}");
    }
    assert_eq!(table(&law, "damage"), [[0.0, 0.0], [0.5, 0.3]]);
    for (key, value) in [
        ("plastic_poisson", 0.2),
        ("convexity", 1.2),
        ("failure_strain", 0.4),
        ("fading_strain", 0.1),
        ("failed_points", 2.0),
    ] {
        assert_eq!(number(&law, key), value, "{key}");
    }
    // Without limits, by rate, with a curve of the flow.
    let law = material_of(&samp("", "20,,,,0.3,8", "", ""));
    let rows = table(&law, "tension_by_rate");
    assert!(rows.contains(&vec![0.001, 0.5, 0.03]) && rows.contains(&vec![1.0, 0.0, 0.05]));
    assert_eq!(table(&law, "plastic_poisson_curve"), [[0.0, 0.35], [0.2, 0.1]]);
    for absent in ["plastic_poisson", "failure_strain", "failed_points", "damage", "convexity"] {
        assert!(!law.parameters.contains_key(absent), "{absent}");
    }
    // Failure is switched off; Poisson's ratio is lowered to that of the flow.
    let law = material_of(&samp("", "5,,,,0.2", "0,0.4", "0,0,0,-1,2"));
    assert_eq!(number(&law, "poisson"), 0.2);
    assert!(!law.parameters.contains_key("failure_strain"));
}

/// Shells and solids move as those of the deck that is written.
#[test]
fn written_cards_give_the_same_motion() {
    for cards in
        [samp("2", "5,6,7,0,0.2", "9,0.4,0.1", "0,0,0,0,1,1.2"), samp("", "20,6,,,0.3", "", "")]
    {
        let text = format!("{BASE}{MOVES}{cards}");
        assert_same_when_written(&text, "time.max_cycles=50", "*MAT_SAMP-1");
    }
}

#[test]
fn cards_with_other_meanings_are_refused() {
    for (cards, words) in [
        (samp("", "5,,,6", "", ""), "`lcid_b` = 6"),
        (samp("", "5,,,,-1.0", "", ""), "associated flow"),
        (samp("", "5,20,,,0.2", "", ""), "a table over the rate"),
        (samp("", "5,,7,,0.2", "", ""), "shear is given without compression"),
        (samp("", "5,,,,0.2", "-9", ""), "those without damage"),
        (samp("", "5,,,,0.2", "0,-9", ""), "give a strain"),
        (samp("", "5,,,,0.2", "0,0.4,0.1,9", ""), "`lcid_tri` = 9"),
        (samp("", "5,,,,0.2", "0,0.4", "0,0,0,1"), "failure by triaxiality"),
        (samp("", "5,,,,0.2", "", "0,0,0,0,3"), "use 0, 1 or 2"),
        (samp("", "5,,,,0.7", "", ""), "plastic_poisson is 0.7"),
    ] {
        assert_refused(&cube(&cards), &[words]);
    }
}
