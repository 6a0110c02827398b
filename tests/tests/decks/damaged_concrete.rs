//! Concrete of three surfaces in decks (MAT_072R3): constants as given and by the strength, the
//! compaction by an equation of state, what is refused.

use crate::base::{assert_refused, cube, list, model_of, number};
use crumple::input::check::describe;
use crumple_proto::partition::{Material, Param};

/// A part with the equation of state 9.
fn with_equation(material: &str) -> String {
    cube(material).replace("block\n1,1,1", "block\n1,1,1,9")
}

fn material_of(text: &str) -> Material {
    model_of(text).settings.materials[0].clone()
}

fn rows(material: &Material, key: &str) -> Vec<Vec<f64>> {
    match material.parameters.get(key) {
        Some(Param::Table(rows)) => rows.clone(),
        other => panic!("{key}: {other:?}"),
    }
}

/// All constants of a concrete in GPa.
const GIVEN: &str = "*MAT_CONCRETE_DAMAGE_REL3\n1,2.4e-6,0.19\n\
                     3.8e-3,0.0134,0.4463,1.78,1.6,0.5,0.4417\n100.0,2,1.0,0,0,0,25.4,13\n\
                     0,8e-6,2.4e-5,4e-5,5.6e-5,7.2e-5,8.8e-5,3.2e-4\n\
                     5.2e-4,5.7e-4,1.0,10.0,1e10,1.15,0.0101,0.625\n\
                     0,0.85,0.97,0.99,1.0,0.99,0.97,0.5\n0.1,0,0,0,0,1.35,2.61,5.67\n";
const POINTS: &str = "*EOS_TABULATED_COMPACTION\n9,0,0,1\n\
                      0.0,-0.0015,-0.0101,-0.0943,0\n\n0.0,0.0217,0.0763,0.4745,0\n\n\n\n\
                      14.5,14.5,15.5,26.5,0\n\n";

#[test]
fn constants_are_taken_as_they_are() {
    let model = model_of(&with_equation(&format!("{GIVEN}{POINTS}")));
    let material = &model.settings.materials[0];
    assert_eq!(material.law, "karagozian_case_concrete");
    assert_eq!(number(material, "tensile_strength"), 3.8e-3);
    assert_eq!(list(material, "largest_surface"), [0.0134, 0.4463, 1.78]);
    assert_eq!(list(material, "yield_surface"), [0.0101, 0.625, 5.67]);
    assert_eq!(list(material, "residual_surface"), [0.4417, 2.61]);
    assert_eq!(list(material, "damage_scaling"), [1.6, 1.35, 1.15]);
    assert_eq!(list(material, "dilatancy"), [0.5, 1.0]);
    let curve = rows(material, "damage_curve");
    assert_eq!(curve.len(), 13);
    assert_eq!((curve[4][..] == [5.6e-5, 1.0], curve[12][..] == [1e10, 0.0]), (true, true));
    let compaction = rows(material, "compaction");
    assert_eq!(compaction.len(), 4);
    assert_eq!(compaction[2], [0.0101, 0.0763, 15.5]);
    let words: Vec<&str> = model.warnings.iter().map(|w| w.message.as_str()).collect();
    for field in ["slambda", "locwidth"] {
        assert!(words.iter().any(|w| w.contains(field)), "{field}: {words:?}");
    }
    // Curves instead of points.
    let curves = "*EOS_TABULATED_COMPACTION\n9,0,0,1,7,0,8\n*DEFINE_CURVE\n7\n-0.0943,0.4745\n\
                  -0.0101,0.0763\n-0.0015,0.0217\n0,0\n*DEFINE_CURVE\n8\n-0.0943,26.5\n\
                  -0.0101,15.5\n-0.0015,14.5\n0,14.5\n";
    let by_curves = material_of(&with_equation(&format!("{GIVEN}{curves}")));
    assert_eq!(by_curves.parameters, material.parameters);
}

/// The same concrete in GPa, MPa and psi has the same numbers over its strength: the bar of 45.4
/// MPa has that strength on the largest surface.
#[test]
fn constants_follow_from_the_strength() {
    for (fc, ucf) in [(0.0454, 145_037.7), (45.4, 145.0377), (6584.7, 1.0)] {
        let text = format!("*MAT_072R3\n1,2.4e-6,0.19\n0,{}\n0,0,0,0,{ucf}\n\n\n\n\n", -fc);
        let model = model_of(&cube(&text));
        let material = &model.settings.materials[0];
        let near = |value: f64, exact: f64| {
            assert!((value / exact - 1.0).abs() < 1e-4, "{ucf}: {value} {exact}");
        };
        let [a0, a1, a2] = list(material, "largest_surface")[..] else { panic!() };
        near(a0 + fc / 3.0 / (a1 + a2 * fc / 3.0), fc);
        let psi: f64 = 6584.71;
        near(number(material, "tensile_strength") / fc, 1.58 * psi.powf(2.0 / 3.0) / psi);
        let compaction = rows(material, "compaction");
        near(compaction[0][2] / fc, 14_530.0 / 45.4);
        near(compaction[9][1] / compaction[0][2], 0.2916);
        assert_eq!(rows(material, "damage_curve").len(), 13);
        assert!(describe(&model).contains("from memory"), "{}", describe(&model));
    }
    // Given numbers and an equation of state replace those by the strength.
    let text = "*MAT_072R3\n1,2.4e-6,0.19\n4e-3,-0.0454,0,0,0.8\n0,0,0,0,145037.7\n\n\n\n\n";
    let material = material_of(&with_equation(&format!("{text}{POINTS}")));
    assert_eq!(number(&material, "tensile_strength"), 4e-3);
    assert_eq!(list(&material, "damage_scaling"), [0.8, 1.35, 1.15]);
    assert_eq!(rows(&material, "compaction").len(), 4);
}

#[test]
fn what_concrete_does_not_have_is_refused() {
    let by_strength = |first: &str, second: &str| {
        cube(&format!("*MAT_072R3\n1,2.4e-6,0.19\n{first}\n{second}\n\n\n\n\n"))
    };
    let elastic =
        "*MAT_JOHNSON_COOK\n1,7.8e-6,80.0,207.0,0.3\n0.3,0.5,0.3,0.01\n477.0,0,1e-3,0\n\n";
    for (deck, words) in [
        (cube(GIVEN), "has no pressure"),
        (by_strength("0,-45.4", "0,0,0,0,0"), "psi over the unit of stress"),
        (by_strength("0,-45.4", "0,0,0,0,145,-1"), "give a curve of factors"),
        (by_strength("0,-45.4", "0,0,0,0,145,0,0,10"), "the card has 13 points"),
        (with_equation(&format!("{elastic}{POINTS}")), "MAT_CONCRETE_DAMAGE_REL3 only"),
        (
            with_equation(&format!("{GIVEN}*EOS_GRUNEISEN\n9,4e3,1.5,0,0,1.9\n")),
            "give it an *EOS_TABULATED_COMPACTION",
        ),
        (
            with_equation(&format!("{GIVEN}{}", POINTS.replace("15.5,26.5", "5.5,26.5"))),
            "moduli that do not decrease",
        ),
    ] {
        assert_refused(&deck, &[words]);
    }
}
