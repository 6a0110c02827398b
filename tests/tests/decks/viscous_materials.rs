//! Viscoelastic materials and viscous foam of decks: keys by the cards, what is refused.

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

const SERIES: &str = "*MAT_GENERAL_VISCOELASTIC\n1,1e-6,BULK\n\n0.001,0.0\n0.004,0.3,KI\n\
                      0.002,5.0\n";

/// A Maxwell solid has the rate of its card, a Kelvin solid the reciprocal of its time; the moduli
/// of fast loads are the same.
#[test]
fn both_forms_of_one_decay_are_one_law() {
    let of = |fo: &str| {
        material_of(&format!("*MAT_KELVIN-MAXWELL_VISCOELASTIC\n1,1e-6,2.0,0.6,0.1,{fo}\n"))
    };
    let (maxwell, kelvin) = (of("0.25,0"), of("4.0,1"));
    assert_eq!(maxwell.law, "viscoelastic");
    assert_eq!(maxwell.parameters, kelvin.parameters);
    assert_eq!(number(&maxwell, "decay_rate"), 0.25);
    assert_eq!(number(&maxwell, "long_term_shear_modulus"), 0.1);
    let e = 9.0 * 2.0 * 0.6 / (3.0 * 2.0 + 0.6);
    assert_eq!(number(&maxwell, "youngs_modulus"), e);
    assert_eq!(
        of("0.25,0").parameters,
        material_of("*MAT_006\n1,1e-6,2.0,0.6,0.1,0.25\n").parameters
    );
}

/// Terms of the card are those of the law, with a bulk modulus or a series of it.
#[test]
fn series_of_decays_are_terms_of_the_law() {
    let elastic = material_of(&SERIES.replace("BULK", "0.02").replace("KI", ""));
    assert_eq!(elastic.law, "general_viscoelastic");
    assert_eq!(number(&elastic, "bulk_modulus"), 0.02);
    assert_eq!(table(&elastic, "shear_terms"), [[0.001, 0.0], [0.004, 0.3], [0.002, 5.0]]);
    assert!(!elastic.parameters.contains_key("bulk_terms"));
    let decays = material_of(&SERIES.replace("BULK", "").replace("KI", "0.02,0.5"));
    assert_eq!(number(&decays, "bulk_modulus"), 0.0);
    assert_eq!(table(&decays, "bulk_terms"), [[0.02, 0.5]]);
    // Shells and solids move as those of the deck that is written.
    let text = format!("{BASE}{MOVES}{}", SERIES.replace("BULK", "").replace("KI", "0.02,0.5"));
    assert_same_when_written(&text, "time.max_cycles=50", "*MAT_GENERAL_VISCOELASTIC");
}

#[test]
fn viscous_foam_has_the_constants_of_its_card() {
    let foam = material_of("*MAT_VISCOUS_FOAM\n1,1e-7,1e-3,4.0,0.02,0.1,0.2,0.05\n");
    assert_eq!(foam.law, "viscous_foam");
    for (key, value) in [
        ("youngs_modulus", 1e-3),
        ("stiffness_exponent", 4.0),
        ("viscous_coefficient", 0.02),
        ("viscous_modulus", 0.1),
        ("viscous_exponent", 0.2),
        ("poisson", 0.05),
    ] {
        assert_eq!(number(&foam, key), value, "{key}");
    }
}

#[test]
fn cards_with_other_meanings_are_refused() {
    let kelvin = "*MAT_061\n1,1e-6,2.0,0.6,0.1,";
    for (cards, words) in [
        (format!("{kelvin}0.0,1\n"), "the time dc is 0"),
        (format!("{kelvin}0.25,2\n"), "use 0 (Maxwell) or 1 (Kelvin)"),
        (SERIES.replace("BULK", "0.02").replace("KI", "0.02"), "give it as a ki with betaki 0"),
        (SERIES.replace("BULK", "0.02,1").replace("KI", ""), "`pcf` = 1"),
        (SERIES.replace("BULK", "0.02,0,1").replace("KI", ""), "an elastic layer"),
        (
            SERIES.replace("BULK", "0.02").replace("\n\n", "\n7,6\n").replace("KI", ""),
            "a fit to a test",
        ),
        ("*MAT_076\n1,1e-6,0.02\n\n".into(), "it has no shear modulus"),
        ("*MAT_062\n1,1e-7,1e-3,4.0,0.02,0.0,0.2,0.05\n".into(), "the damper would have no effect"),
    ] {
        assert_refused(&cube(&cards), &[words]);
    }
}
