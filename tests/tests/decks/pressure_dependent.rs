//! Ceramics, concrete in high pressures and soil of decks: keys by the cards, what is refused.

use crate::base::{assert_refused, cube, list, model_of, number};
use crumple_proto::partition::{Material, Param};

fn material_of(cards: &str) -> Material {
    model_of(&cube(cards)).settings.materials[0].clone()
}

/// Constants of an alumina; `FS` stands for the field fs.
const CERAMIC: &str = "*MAT_JOHNSON_HOLMQUIST_CERAMICS\n1,3.7e-6,90.16,0.93,0.31,0.0,0.6,0.6\n\
                       1e-3,0.2,1e20,2.79,1.46,1.0\n0.005,1.0,130.95,0.0,0.0,FS\n";
/// Constants by Holmquist, Johnson & Cook (1993), table 1.
const CONCRETE: &str = "*MAT_JOHNSON_HOLMQUIST_CONCRETE\n\
                        1,2.44e-6,14.86,0.79,1.6,0.007,0.61,0.048\n\
                        0.004,1e-3,0.01,7.0,0.016,0.001,0.8,0.1\n0.04,1.0,85.0,-171.0,208.0,FS\n";
const SOIL: &str = "*MAT_SOIL_AND_FOAM\n1,2e-6,0.02,0.5,1e-9,1e-5,0.3,-1e-5\n0\n\
                    0.0,-0.05,-0.1\n\n0.0,0.002,0.02\n\n";

#[test]
fn cards_of_ceramics_and_concrete_are_their_laws() {
    let failing = |cards: &str, fs: &str| material_of(&cards.replace("FS", fs));
    let material = failing(CERAMIC, "0");
    assert_eq!(material.law, "johnson_holmquist_ceramic");
    assert_eq!(list(&material, "intact_strength"), [0.93, 0.6]);
    assert_eq!(list(&material, "fractured_strength"), [0.31, 0.6]);
    assert_eq!(list(&material, "hugoniot_elastic_limit"), [2.79, 1.46]);
    assert_eq!(list(&material, "damage"), [0.005, 1.0]);
    assert_eq!(number(&material, "bulking"), 1.0);
    for absent in ["rate", "largest_strength", "failure_strain", "fails_in_tension"] {
        assert!(!material.parameters.contains_key(absent), "{absent}");
    }
    assert_eq!(number(&failing(CERAMIC, "1.5"), "failure_strain"), 1.5);
    let tears =
        |material: &Material, key: &str| material.parameters.get(key) == Some(&Param::Flag(true));
    assert!(tears(&failing(CERAMIC, "-1.0"), "fails_in_tension"));

    let material = failing(CONCRETE, "0");
    assert_eq!(material.law, "johnson_holmquist_concrete");
    assert_eq!(list(&material, "strength_constants"), [0.79, 1.6, 0.61]);
    assert_eq!(list(&material, "crushing_point"), [0.001, 0.016]);
    assert_eq!(list(&material, "locking_point"), [0.1, 0.8]);
    assert_eq!(list(&material, "rate"), [0.007, 1e-3]);
    assert_eq!(number(&material, "largest_strength"), 7.0);
    assert!(tears(&material, "fails_in_tension"));
    assert!(tears(&failing(CONCRETE, "-1.0"), "fails_in_damaged_tension"));
    assert_eq!(number(&failing(CONCRETE, "0.5"), "failure_strain"), 0.5);
    // Without a tensile strength all would fail at once.
    let weak = failing(&CONCRETE.replace("\n0.004,", "\n0.0,"), "0");
    assert!(!weak.parameters.contains_key("fails_in_tension"));
}

/// Points on the card and a curve give the same soil; the volume strain of the deck is ln V.
#[test]
fn soil_has_the_curve_of_its_points() {
    let material = material_of(SOIL);
    let curve = Param::Table(vec![vec![0.0, 0.0], vec![0.05, 0.002], vec![0.1, 0.02]]);
    assert_eq!(material.parameters.get("pressure"), Some(&curve));
    assert_eq!(number(&material, "tension_cutoff"), 1e-5);
    let by_curve = SOIL
        .replace("\n0\n", "\n0,0,7\n")
        .replace("*MAT_", "*DEFINE_CURVE\n7\n-0.1,0.02\n-0.05,0.002\n0.0,0.0\n*MAT_");
    assert_eq!(material_of(&by_curve).parameters, material.parameters);
    // The point at the start may be left out.
    let short =
        material_of(&SOIL.replace("0.0,-0.05,-0.1", "-0.05,-0.1").replace("0.0,0.002", "0.002"));
    assert_eq!(short.parameters, material.parameters);
    let reversible = material_of(&SOIL.replace("\n0\n", "\n1.0\n"));
    assert_eq!(reversible.parameters.get("reversible"), Some(&Param::Flag(true)));
}

#[test]
fn cards_with_other_meanings_are_refused() {
    for (deck, words) in [
        (SOIL.replace("-0.05,-0.1", "0.05,0.1"), "a volume strain is above 0"),
        (SOIL.replace("0.3,-1e-5", "0.3,1e-5"), "give a tension, below 0"),
        (SOIL.replace("\n0\n", "\n2\n"), "use 0 or 1"),
        (SOIL.replace("0.02,0.5,", "0.02,0.1,"), "at least the largest slope"),
        (SOIL.replace("0.0,0.002,0.02", "").replace("0.0,-0.05,-0.1", ""), "it has no pressure"),
        (CERAMIC.replace("FS", "0").replace("2.79,1.46", "1.46,2.79"), "below the stress"),
        (
            CERAMIC
                .replace("FS", "0")
                .replace("0.31,0.0,", "0.31,0.1,")
                .replace("1e-3,0.2", "0,0.2"),
            "the rate above 0",
        ),
        (CONCRETE.replace("FS", "0").replace("0.016,0.001", "0.001,0.016"), "the last the largest"),
    ] {
        assert_refused(&cube(&deck), &[words]);
    }
}
