//! Concrete of decks: constants by the strength in all units, cards as they are, what is refused.

use crate::base::{assert_refused, cube, list, model_of, number};
use crumple::input::job::Model;
use crumple_proto::partition::Material;

fn fitted(first: &str, last: &str) -> Model {
    model_of(&cube(&format!("*MAT_CSCM_CONCRETE\n{first}\n0\n{last}\n")))
}

fn concrete(model: &Model) -> &Material {
    model.settings.materials.iter().find(|m| m.law == "cscm").expect("concrete")
}

/// FHWA-HRT-05-062, ch. 3, at 30 MPa: moduli, meridian, cap, times of the rate. The strength in
/// unconfined compression that follows from the meridian is 30 MPa within the error of the fit.
#[test]
fn the_constants_are_those_of_the_strength() {
    let model = fitted("1,2.4e-9,1,0,1,1.05,0,0", "30.0,19.0,2");
    let material = concrete(&model);
    let e = number(material, "youngs_modulus");
    assert!((e / 26_357.0 - 1.0).abs() < 1e-4 && number(material, "poisson") == 0.15, "{e}");
    let [alpha, theta, lambda, beta] = list(material, "shear_surface")[..] else { panic!() };
    let limit = |j1: f64| alpha - lambda * (-beta * j1).exp() + theta * j1;
    assert!((3.0_f64.sqrt() * limit(30.0) / 30.0 - 1.0).abs() < 0.02, "{}", limit(30.0));
    let cap = list(material, "cap");
    assert!((cap[1] - 90.54).abs() < 0.01, "{cap:?}");
    let [tension, compression] =
        ["tension_rate", "compression_rate"].map(|key| list(material, key));
    assert!((tension[0] / 6.176e-5 - 1.0).abs() < 1e-3, "{tension:?}");
    assert!((compression[0] / 1.003e-4 - 1.0).abs() < 2e-3, "{compression:?}");
    assert!((tension[2] / 21.45 - 1.0).abs() < 1e-3, "{tension:?}");
    assert!((number(material, "erosion_strain") - 0.05).abs() < 1e-12);
    // CEB-FIP (1993): 0.030 N/mm at 10 MPa and 16 mm, by the power 0.7 of the strength.
    let coarse = fitted("1,2.4e-9", "20.0,16.0,2");
    let energy = number(concrete(&coarse), "tension_energy");
    assert!((energy / (0.030 * 2.0_f64.powf(0.7)) - 1.0).abs() < 1e-12, "{energy}");
}

/// The same concrete in all five systems of units: numbers with a dimension agree in SI.
#[test]
fn units_of_the_card_are_those_of_the_deck() {
    // Stress in Pa, length in m, time in s.
    let units = [
        (0, "2.4e-6", [1e9, 1e-3, 1e-3]),
        (1, "2.4e-3", [1e6, 1e-3, 1e-3]),
        (2, "2.4e-9", [1e6, 1e-3, 1.0]),
        (3, "2.25e-4", [6_894.757, 0.0254, 1.0]),
        (4, "2400.0", [1.0, 1.0, 1.0]),
    ];
    let si: Vec<[f64; 6]> = units
        .iter()
        .map(|(code, density, [stress, length, time])| {
            let [fpc, dagg] = [35e6 / stress, 0.016 / length];
            let model =
                fitted(&format!("1,{density},0,0,1"), &format!("{fpc:.6e},{dagg:.6e},{code}"));
            let material = concrete(&model);
            let rate = list(material, "tension_rate");
            [
                number(material, "youngs_modulus") * stress,
                list(material, "shear_surface")[0] * stress,
                list(material, "torsion")[3] / stress,
                list(material, "cap")[4] / (stress * stress),
                number(material, "compression_energy") * stress * length,
                rate[0] * time.powf(1.0 - rate[1]),
            ]
        })
        .collect();
    for values in &si {
        for (value, wanted) in values.iter().zip(si[4]) {
            assert!((value / wanted - 1.0).abs() < 1e-5, "{values:?} {:?}", si[4]);
        }
    }
}

const CARDS: &str = "*MAT_CSCM\n1,2.4e-6,0,0,0,0.0,0.0,0\n0\n11.46,12.55,14.5e-3,0.2965,10.5e-3,\
     19.29,0,0\n0.747,1.155,0.17,70.6,0.66,1.387,0.16,71.6\n5.0,90.5e-3,0.05,0.25,0.349\n\
     100.0,7e-3,0.1,7e-5,7e-5,,,\n";

#[test]
fn cards_with_all_constants_are_taken_as_they_are() {
    let model = model_of(&cube(CARDS));
    let material = concrete(&model);
    assert_eq!(list(material, "shear_surface"), [14.5e-3, 0.2965, 10.5e-3, 19.29]);
    assert_eq!(list(material, "extension"), [0.66, 1.387, 0.16, 71.6]);
    assert_eq!(list(material, "cap"), [5.0, 90.5e-3, 0.05, 0.25, 0.349]);
    let [power, energy] = ["compression_power", "tension_energy"].map(|key| number(material, key));
    assert_eq!([power, energy], [5.0, 7e-5]);
    assert!(!material.parameters.contains_key("tension_rate"));
    let [e, nu] = ["youngs_modulus", "poisson"].map(|key| number(material, key));
    assert!((e / (2.0 * (1.0 + nu)) - 11.46).abs() < 1e-9, "{e} {nu}");
    // With effects of the rate there is a card more.
    let rates = CARDS.replace("1,2.4e-6,0,0,0", "1,2.4e-6,0,0,1");
    let model = model_of(&cube(&format!("{rates}1e-4,0.78,2e-4,0.48,0.02,0.03\n")));
    let material = concrete(&model);
    assert_eq!(list(material, "tension_rate"), [2e-4, 0.48, 0.03]);
    assert_eq!(list(material, "compression_rate"), [1e-4, 0.78, 0.02]);
}

#[test]
fn what_is_not_supported_is_refused() {
    let concrete = |first: &str, second: &str, last: &str| {
        cube(&format!("*MAT_CSCM_CONCRETE\n{first}\n{second}\n{last}\n"))
    };
    for (deck, words) in [
        (concrete("1,2.4e-6,0,0,0,0,0,1", "0", ""), "`itretrc` = 1"),
        (concrete("1,2.4e-6,0,0,2", "0", ""), "`irate` = 2"),
        (concrete("1,2.4e-6", "0.5", ""), "`pred` = 0.5"),
        (concrete("1,2.4e-6", "0", "0.03,19,7"), "units is 7"),
        // Strength in MPa with units of GPa.
        (concrete("1,2.4e-6", "0", "30.0,19,0"), "fpc is 30000"),
        (cube(&CARDS.replace("19.29,0,0", "19.29,0.7,10")), "`nh` = 0.7"),
        (cube(&CARDS.replace("0.0,0.0,0\n0", "0.0,1.5,0\n0")), "recovery is 1.5"),
    ] {
        assert_refused(&deck, &[words]);
    }
}
