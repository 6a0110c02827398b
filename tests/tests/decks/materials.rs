//! Materials of decks: their laws and parameters, and cubes of each on a prescribed path. Units mm,
//! ms, kg, so kN, GPa and J.

use crate::base::{BASE, MOVES, assert_same_when_written, model_of};
use crumple::input::job::Model;
use crumple_tests::program::{crumple_with, run};
use std::fmt::Write;
use std::fs;

/// Returns a parameter of the first material, as TOML text.
fn parameter(model: &Model, key: &str) -> String {
    model.job.material[0].parameters.get(key).map_or(String::new(), |value| value.to_string())
}

fn model(cards: &str) -> Model {
    model_of(&format!("{BASE}{MOVES}{cards}"))
}

/// beta shares the plastic modulus; curves and tables by rate, and vp, become keys of `j2`. Curves
/// continue with their last slope.
#[test]
fn hardening_and_rates_of_metals() {
    let mixed = model("*MAT_003\n1,7.85e-6,200.0,0.3,0.25,0.5,0.25\n40.0,5.0,0.2,1.0\n");
    let modulus = 200.0 * 0.5 / 199.5;
    assert_eq!(parameter(&mixed, "hardening_modulus"), (0.25 * modulus).to_string());
    assert_eq!(parameter(&mixed, "kinematic_modulus"), (0.75 * modulus).to_string());
    assert_eq!(parameter(&mixed, "viscoplastic"), "true");
    let curves = "*DEFINE_CURVE\n5\n0.0,1.0\n1.0,1.5\n*DEFINE_TABLE\n9\n0.01\n10.0\n\
                  *DEFINE_CURVE\n6\n0.0,0.3\n0.2,0.4\n*DEFINE_CURVE\n7\n0.1,0.5\n0.2,0.6\n";
    let card = |lcss: i64, lcsr: i64| {
        model(&format!("*MAT_024\n1,7.85e-6,200.0,0.3\n0.0,0.0,{lcss},{lcsr}\n{curves}"))
    };
    let by_rate = card(9, 0);
    assert_eq!(
        parameter(&by_rate, "hardening_by_rate"),
        "[[0.01, 0.0, 0.3], [0.01, 0.2, 0.4], [0.01, 10.0, 5.300000000000002], [10.0, 0.0, 0.5], \
         [10.0, 0.1, 0.5], [10.0, 0.2, 0.6], [10.0, 10.0, 10.399999999999999]]"
    );
    assert_eq!(parameter(&by_rate, "viscoplastic"), "");
    let scaled = card(6, 5);
    assert_eq!(parameter(&scaled, "rate_factors"), "[[0.0, 1.0], [1.0, 1.5]]");
    assert_eq!(
        parameter(&scaled, "hardening"),
        "[[0.0, 0.3], [0.2, 0.4], [10.0, 5.300000000000002]]"
    );
    let flat = "*MAT_024\n1,7.85e-6,200.0,0.3\n0.0,0.0,8\n\
                *DEFINE_CURVE\n8\n0.0,0.3\n0.2,0.4\n0.3,0.4\n";
    assert_eq!(parameter(&model(flat), "hardening"), "[[0.0, 0.3], [0.2, 0.4], [0.3, 0.4]]");
}

/// A power law becomes a curve, whose first strain is that of the yield stress, a given one, or
/// that on the elastic line.
#[test]
fn a_power_law_becomes_a_curve() {
    let curve = |card: &str| -> Vec<[f64; 2]> {
        let of = model(&format!("*MAT_POWER_LAW_PLASTICITY\n1,7.85e-6,200.0,0.3,{card}\n"));
        let rows = of.job.material[0].parameters["hardening"].to_string();
        rows.trim_matches(['[', ']'])
            .split("], [")
            .map(|row| {
                let (strain, stress) = row.split_once(", ").expect("two numbers");
                [strain, stress].map(|number| number.parse().expect("a number"))
            })
            .collect()
    };
    let on_line = (200.0_f64 / 0.5).powf(1.0 / (0.2 - 1.0));
    for (card, first, n) in [
        ("0.5,0.2\n", on_line, 0.2),
        ("0.5,0.2\n0.01", 0.01, 0.2),
        ("0.5,0.2\n0.2", 0.4_f64.powi(5), 0.2),
        ("0.5,0.0\n", 1.0, 0.0),
    ] {
        let points = curve(card);
        assert!(points.len() > 5 && points[0][0] == 0.0, "{card}: {points:?}");
        for pair in points.windows(2).filter(|pair| pair[1][0] < 3.0) {
            let [middle, stress] = [0, 1].map(|c| 0.5 * (pair[0][c] + pair[1][c]));
            let wanted = 0.5 * (first + middle).powf(n);
            assert!((stress / wanted - 1.0).abs() < 1e-4, "{card} at {middle}: {stress} {wanted}");
        }
    }
    let yields = curve("0.5,0.2\n0.2")[0][1];
    assert!((yields - 0.2).abs() < 1e-12, "{yields}");
    let more = model("*MAT_018\n1,7.85e-6,200.0,0.3,0.5,0.2,40,5\n0,1,0.3\n");
    for (key, value) in
        [("cowper_symonds", "[40.0, 5.0]"), ("viscoplastic", "true"), ("failure_strain", "0.3")]
    {
        assert_eq!(parameter(&more, key), value, "{key}");
    }
    let refused = |card: &str, words: &str| {
        let card = format!("*MAT_018\n1,7.85e-6,200.0,0.3,{card}\n");
        crate::base::assert_refused(&format!("{BASE}{MOVES}{card}"), &[words]);
    };
    refused("0.5,1.2", "n is 1.2");
    refused("-0.5,0.2", "k is -0.5");
    refused("0.5,0.2\n-1.0", "sigy is -1");
}

/// Criteria of failure become keys of the material that they name; the excluded value is none.
#[test]
fn added_failure_of_a_material() {
    let metal = "*MAT_024\n1,7.85e-6,200.0,0.3,0.25\n";
    let card = "*MAT_ADD_EROSION\n1,9.0,9.0,,-0.2\n-0.5,0.7,0.8\n";
    let eroding = model(&format!("{metal}{card}"));
    for (key, value) in [
        ("erosion_max_pressure", ""),
        ("erosion_min_pressure", "-0.5"),
        ("erosion_principal_stress", "0.7"),
        ("erosion_von_mises", "0.8"),
        ("erosion_plastic_strain", "0.2"),
    ] {
        assert_eq!(parameter(&eroding, key), value, "{key}");
    }
    // By default the first failed point removes its shell; -100 stands for all points.
    assert_eq!(parameter(&eroding, "erosion_failed_points"), "1.0");
    let all = model(&format!("{metal}*MAT_ADD_EROSION\n1,,,,0.4,,-100.0\n"));
    assert_eq!(parameter(&all, "erosion_failed_points"), "");
    let strained = model(&format!("{metal}*MAT_ADD_EROSION\n1,,,,0.4\n"));
    assert_eq!(parameter(&strained, "erosion_effective_strain"), "0.4");
    assert_eq!(parameter(&strained, "erosion_plastic_strain"), "");
    let text = format!("{BASE}{MOVES}{metal}*MAT_ADD_EROSION\n1,,,,0.4\n");
    assert_same_when_written(&text, "time.max_cycles=50", "*MAT_ADD_EROSION");
}

/// Damage, strains of failure and anisotropy become keys of `j2`, Johnson-Cook without temperature
/// one of `johnson_cook`; defaults of the cards that are no limits leave nothing behind.
#[test]
fn metals_with_damage_strains_and_anisotropy() {
    let curve = "*DEFINE_CURVE\n6\n0.0,0.3\n0.2,0.4\n";
    let damaged = model(&format!("*MAT_081\n1,7.85e-6,200.0,0.3,,,0.1\n,,6,,0.25\n{curve}"));
    assert_eq!(parameter(&damaged, "softening"), "[0.1, 0.25]");
    assert_eq!(
        parameter(&damaged, "hardening"),
        "[[0.0, 0.3], [0.2, 0.4], [10.0, 5.300000000000002]]"
    );
    let intact = model("*MAT_PLASTICITY_WITH_DAMAGE\n1,7.85e-6,200.0,0.3,0.25,0.5\n");
    assert_eq!(parameter(&intact, "softening"), "");
    // The base has a part of solids with this material, too; strains of failure are for shells.
    let thin = "*MAT_003\n7,7.85e-6,200.0,0.3,0.25\n*MAT_123\n1,7.85e-6,200.0,0.3,0.25\n\
                40.0,5.0,0,0,0,0.3,0.5,2\n";
    let stretched = model_of(&format!("{BASE}{MOVES}{thin}").replace("2,2,1\n", "2,2,7\n"));
    for (key, value) in [
        ("erosion_thinning", "0.3"),
        ("erosion_major_strain", "0.5"),
        ("cowper_symonds", "[40.0, 5.0]"),
        ("yield_stress", "0.25"),
    ] {
        assert_eq!(parameter(&stretched, key), value, "{key}");
    }
    // The sign of r is another treatment of thinning.
    let sheet = "*MAT_003\n7,7.85e-6,200.0,0.3,0.25\n*MAT_037\n1,7.85e-6,200.0,0.3,0.25,0.5,-1.5\n";
    let rolled = model_of(&format!("{BASE}{MOVES}{sheet}").replace("2,2,1\n", "2,2,7\n"));
    assert_eq!(parameter(&rolled, "lankford"), "1.5");
    // The limit before the rate; without a rate sigsat is the same.
    for (card, [a, b, limit]) in [
        ("0.3,0.4,0.5,0.01,,0.6,,1e-3", [0.3, 0.4, 0.6]),
        ("0.3,0.4,0.5,,,,0.5", [0.3, 0.4, 0.5]),
        ("0.3,0.4,0.5,0.01,,0.2,1e28,1e-3", [0.2, 0.0, 0.2]),
    ] {
        let limited = model(&format!("*MAT_098\n1,7.85e-6,200.0,0.3\n{card}\n"));
        let given = &limited.job.material[0].parameters;
        for (key, wanted) in [("a", a), ("b", b), ("largest_stress", limit)] {
            assert_eq!(given[key], toml::Value::from(wanted), "{card}: {key}");
        }
    }
    let viscous = model("*MAT_098\n1,7.85e-6,200.0,0.3,1.0\n0.3,0.4,0.5,0.01,,0.6,,1e-3\n");
    assert!(!viscous.job.material[0].parameters.contains_key("largest_stress"));
    let cook = model("*MAT_098\n1,7.85e-6,200.0,0.3\n0.3,0.4,0.5,0.01,0.6,1e28,1e28,0.001\n");
    assert_eq!(cook.job.material[0].law, "johnson_cook");
    for (key, value) in [
        ("a", "0.3"),
        ("b", "0.4"),
        ("n", "0.5"),
        ("c", "0.01"),
        ("reference_rate", "0.001"),
        ("damage", "[0.6, 0.0, 0.0, 0.0, 0.0]"),
        ("m", ""),
    ] {
        assert_eq!(parameter(&cook, key), value, "{key}");
    }
}

/// Fields of metals that their laws do not have are refused, each by name.
#[test]
fn fields_of_metals_without_a_law_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    for (cards, words) in [
        ("*MAT_081\n1,7.85e-6,200.0,0.3,0.25,0.5,0.1\n", "give eppfr, above eppf"),
        ("*MAT_081\n1,7.85e-6,200.0,0.3,0.25,0.5,0.1\n,,,,0.2,,7\n", "`lcdm` = 7"),
        ("*MAT_081\n1,7.85e-6,200.0,0.3,0.25,0.5\n,,,,0.2\n", "`eppfr` = 0.2"),
        ("*MAT_123\n1,7.85e-6,200.0,0.3,0.25\n,,,,,-0.3\n", "`epsthin` = -0.3"),
        ("*MAT_098\n1,7.85e-6,200.0,0.3\n0.3,0.4,0.5,0.01,,,0.9\n", "`sigsat` = 0.9"),
        // One part of the base is of solids.
        ("*MAT_037\n1,7.85e-6,200.0,0.3,0.25,0.5,1.5\n", "lankford is for shells only"),
    ] {
        fs::write(&path, format!("{BASE}{MOVES}{cards}*END\n")).unwrap();
        let text = crumple::input::job::read(&path, &[]).err().expect(cards).to_string();
        assert!(text.contains(words), "{cards}: {text}");
    }
}

/// An equation of state becomes a key of the material of parts of solids; shells have none.
#[test]
fn equations_of_state() {
    // Part 2 of the base is of solids, part 1 of shells.
    let metal = "*MAT_003\n1,7.85e-6,200.0,0.3,0.25\n*MAT_015\n7,8.93e-6,46.0,124.0,0.34\n\
                 0.09,0.292,0.31,0.025,1.09,1356.0,293.0,0.001\n383.0,-1.5,1.0\n";
    let with = |card: &str, eosid: i64| {
        let deck = format!("{BASE}{MOVES}{metal}{card}");
        deck.replace("2,2,1\n", &format!("2,2,7,{eosid}\n"))
    };
    let gruneisen = "*EOS_GRUNEISEN\n3,3940.0,1.489,,,2.02,0.47\n1.0\n";
    let polynomial = "*EOS_LINEAR_POLYNOMIAL\n3,0.0,139.0,260.0,500.0,2.0,0.5\n0.0,1.0\n";
    for (card, key, list) in [
        (gruneisen, "eos_gruneisen", "[3940.0, 1.489, 0.0, 0.0, 2.02, 0.47]"),
        (polynomial, "eos_polynomial", "[139.0, 260.0, 500.0, 2.0, 0.5, 0.0]"),
    ] {
        let model = model_of(&with(card, 3));
        let of = |name: &str| {
            let mut all = model.job.material.iter();
            let material = all.find(|m| m.name == name).expect(name);
            material.parameters.get(key).map_or(String::new(), |value| value.to_string())
        };
        assert_eq!(of("mat-7"), list);
        assert_eq!(of("mat-1"), "");
        let cut = model.job.material.iter().find_map(|m| m.parameters.get("eos_min_pressure"));
        assert_eq!(cut.map(|value| value.to_string()), Some("-1.5".into()));
        // The report says the same as the job.
        let said = crumple::input::check::describe(&model);
        assert!(said.contains("eos_min_pressure of material mat-7"), "{said}");
        let warned: Vec<_> = model.warnings.iter().filter(|w| w.message.contains("`pc`")).collect();
        assert!(warned.is_empty(), "{warned:?}");
    }
    // Other laws have a pressure of their own, and so have shells.
    let other =
        with(gruneisen, 3).replace("2,2,7,3\n", "2,2,1,3\n").replace("1,1,1\n", "1,1,1,3\n");
    let said = crumple::input::check::describe(&model_of(&other));
    for words in ["the material has a pressure of its own", "only solids have a pressure"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    for (card, eosid, words) in [
        (gruneisen.replace("2.02,0.47", "2.02,0.47,0.5"), 3, "`e0` = 0.5"),
        (polynomial.replace("3,0.0", "3,0.1"), 3, "`c0` = 0.1"),
        (polynomial.replace("0.0,1.0", "0.0,0.9"), 3, "`v0` = 0.9"),
        (gruneisen.to_string(), 4, "no *EOS_... with the id 4"),
        (
            format!("{gruneisen}*PART\nsecond\n9,2,7\n"),
            3,
            "part 9: its material 7 has the equation of state 3 in part 2, and 0 here",
        ),
    ] {
        fs::write(&path, format!("{}*END\n", with(&card, eosid))).unwrap();
        let text = crumple::input::job::read(&path, &[]).err().expect(words).to_string();
        assert!(text.contains(words), "{text}");
    }
}

/// A limit of tension that the engine does not have is a warning, and no key of the job.
#[test]
fn a_cut_off_of_pressure_that_does_not_act_is_ignored_aloud() {
    let eos = "*EOS_GRUNEISEN\n3,3940.0,1.489,,,2.02,0.47\n1.0\n";
    let with = |pc: &str, spall: &str, eosid: i64| {
        let metal = format!(
            "*MAT_003\n1,7.85e-6,200.0,0.3,0.25\n*MAT_015\n7,8.93e-6,46.0,124.0,0.34\n\
             0.09,0.292,0.31,0.025,1.09,1356.0,293.0,0.001\n383.0,{pc},{spall}\n"
        );
        let deck = format!("{BASE}{MOVES}{metal}{eos}");
        model_of(&deck.replace("2,2,1\n", &format!("2,2,7,{eosid}\n")))
    };
    for (pc, spall, eosid, message, help) in [
        ("-1.5", "0", 3, "`pc` = -1.5 with `spall` = 0 is ignored", "no element spalls"),
        ("-1.5", "2", 3, "`pc` = -1.5 with `spall` = 2 is ignored", "no element spalls"),
        ("-1.5", "3", 3, "`pc` = -1.5 with `spall` = 3 is ignored", "no element spalls"),
        ("1.5", "1", 3, "`pc` = 1.5 with `spall` = 1 is ignored", "is below 0"),
        ("-1.5", "1", 0, "`pc` = -1.5 of material 7 is ignored", "give its parts an eosid"),
    ] {
        let model = with(pc, spall, eosid);
        let found: Vec<_> = model.warnings.iter().filter(|w| w.message.contains("`pc`")).collect();
        let [warning] = &found[..] else { panic!("{pc} {spall} {eosid}: {found:?}") };
        assert!(warning.message.contains(message), "{}", warning.message);
        assert!(warning.help.contains(help), "{}", warning.help);
        assert!(model.job.material.iter().all(|m| !m.parameters.contains_key("eos_min_pressure")));
    }
    let said = crumple::input::check::describe(&with("0.0", "3", 3));
    assert!(said.contains("pc is 0, which is no limit of tension"), "{said}");
}

/// A card that asks for more than its law has says which field, and how to go on.
#[test]
fn what_a_law_does_not_have_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let fit = "*MAT_MOONEY-RIVLIN_RUBBER\n1,1e-6,0.49,0.0003,0.0001\n10.0,1.0,1.0,4\n";
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{MOVES}{fit}*END\n")).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("a fit").to_string();
    assert!(text.contains("`lcid` = 4") && text.contains("give a and b"), "{text}");
    // Both parts of the base have the material; one is of shells.
    let rubber = "*MAT_BLATZ-KO_RUBBER\n1,1e-6,0.001\n";
    fs::write(&path, format!("{BASE}{MOVES}{rubber}*END\n")).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("a shell").to_string();
    assert!(text.contains("blatz_ko' is for solids only"), "{text}");
}

/// A cube of the deck: its card, and the energy per volume at the end of a press to 70 % of its
/// height, of the return, and of simple shear by one [J/mm^3].
struct Sample {
    card: &'static str,
    pressed: f64,
    returned: f64,
    sheared: f64,
}

const NU: f64 = 0.45;
const STRETCH: f64 = 0.7;

/// Energies of rubbers at the invariants I, II and J of the Cauchy-Green tensor.
fn mooney(i: f64, ii: f64, j: f64) -> f64 {
    let (a, b) = (0.0003, 0.0001);
    let d = (a * (5.0 * NU - 2.0) + b * (11.0 * NU - 5.0)) / (2.0 * (1.0 - 2.0 * NU));
    let third = j * j;
    a * (i - 3.0)
        + b * (ii - 3.0)
        + (0.5 * a + b) * (third.powi(-2) - 1.0)
        + d * (third - 1.0).powi(2)
}

fn bulk(shear: f64) -> f64 {
    2.0 * shear * (1.0 + NU) / (3.0 * (1.0 - 2.0 * NU))
}

fn polynomial(i: f64, ii: f64, j: f64) -> f64 {
    let (x, y) = (i * j.powf(-2.0 / 3.0) - 3.0, ii * j.powf(-4.0 / 3.0) - 3.0);
    0.0004 * x + 0.0001 * y + 0.00002 * x * x + 0.5 * bulk(0.001) * (j - 1.0).powi(2)
}

/// Two terms at the principal stretches.
fn ogden(stretches: [f64; 3]) -> f64 {
    let j: f64 = stretches.iter().product();
    let terms = [[0.0006, 1.3], [-0.0001, -2.0]];
    let shear = 0.5 * (0.0006 * 1.3 + 0.0001 * 2.0);
    let of = |[mu, alpha]: [f64; 2]| {
        let sum: f64 = stretches.iter().map(|l| (l * j.powf(-1.0 / 3.0)).powf(alpha)).sum();
        mu / alpha * (sum - 3.0)
    };
    terms.into_iter().map(of).sum::<f64>() + bulk(shear) * (j - 1.0 - j.ln())
}

fn blatz_ko(i: f64, j: f64) -> f64 {
    let beta = 0.463 / (1.0 - 2.0 * 0.463);
    0.5 * 0.001 * (i - 3.0 + (j.powf(-2.0 * beta) - 1.0) / beta)
}

fn samples() -> Vec<Sample> {
    let l = STRETCH;
    let press = |energy: fn(f64, f64, f64) -> f64| energy(l * l + 2.0, 2.0 * l * l + 1.0, l);
    // In simple shear by one both invariants are four; the stretches are the golden ratio.
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    // Area under the curve from 0 to 0.3: a triangle and a trapezium.
    let area = 0.5 * 0.05 * 1e-5 + 0.25 * 0.5 * (1e-5 + 2e-5);
    let elastic = |pressed, sheared| Sample { card: "", pressed, returned: 0.0, sheared };
    vec![
        Sample {
            card: "*MAT_MOONEY-RIVLIN_RUBBER\n1,1e-6,0.45,0.0003,0.0001\n",
            ..elastic(press(mooney), mooney(4.0, 4.0, 1.0))
        },
        Sample {
            card: "*MAT_HYPERELASTIC_RUBBER\n2,1e-6,0.45\n0.0004,0.0001,0.0,0.00002\n",
            ..elastic(press(polynomial), polynomial(4.0, 4.0, 1.0))
        },
        Sample {
            card: "*MAT_OGDEN_RUBBER\n3,1e-6,0.45\n0.0006,-0.0001\n1.3,-2.0\n",
            ..elastic(ogden([l, 1.0, 1.0]), ogden([golden, 1.0 / golden, 1.0]))
        },
        Sample {
            card: "*MAT_BLATZ-KO_RUBBER\n4,1e-6,0.001\n",
            ..elastic(blatz_ko(l * l + 2.0, l), blatz_ko(4.0, 1.0))
        },
        // Half of the energy is lost: (1 - hu) shape/(shape + 1) with hu 0 and shape 1.
        Sample {
            card: "*MAT_LOW_DENSITY_FOAM\n5,1e-7,0.0002,21,,1e-9\n1.0\n",
            pressed: area,
            returned: 0.5 * area,
            sheared: f64::NAN,
        },
        // The table has this curve at the rates of the run; unloading follows it.
        Sample {
            card: "*MAT_FU_CHANG_FOAM\n6,1e-7,0.0002,,,,,31\n",
            pressed: area,
            returned: 0.0,
            sheared: f64::NAN,
        },
        // All but the elastic energy at the end of the press is lost, and the foam is stress free
        // on the return.
        Sample {
            card: "*MAT_CRUSHABLE_FOAM\n7,1e-7,0.001,0.0,22,0.0\n",
            pressed: f64::NAN,
            returned: f64::NAN,
            sheared: f64::NAN,
        },
        // Slow loads have G_long; see below.
        Sample {
            card: "*MAT_VISCOELASTIC\n8,1e-6,0.005,0.001,0.0005,1000.0\n",
            pressed: f64::NAN,
            returned: f64::NAN,
            sheared: f64::NAN,
        },
    ]
}

const SIDE: f64 = 10.0;
/// End of the runs [ms].
const END: f64 = 60.0;

/// Writes a deck with a cube of each sample, whose tops move by `motion` (axis and distance) until
/// half of the run, and back until its end.
fn deck(samples: &[Sample], axis: u8, distance: f64, back: f64) -> String {
    let half = 0.5 * END;
    let mut text = format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n{END}\n*DATABASE_GLSTAT\n0.3\n*SECTION_SOLID\n1,1\n\
         *DEFINE_CURVE\n1\n0.0,0.0\n{half},{distance}\n{END},{back}\n\
         *DEFINE_CURVE\n21\n0.0,0.0\n0.05,1e-5\n0.55,3e-5\n0.9,1e-3\n\
         *DEFINE_CURVE\n22\n0.0,2e-5\n0.5,2e-5\n0.9,1e-4\n\
         *DEFINE_CURVE\n23\n0.0,0.0\n0.05,2e-5\n0.55,6e-5\n0.9,2e-3\n\
         *DEFINE_TABLE_2D\n31\n0.1,21\n10.0,23\n"
    );
    let (mut nodes, mut tops, mut sides) = (String::new(), String::new(), String::new());
    for (k, sample) in samples.iter().enumerate() {
        let id = k + 1;
        let _ = write!(text, "{}*PART\ncube {id}\n{id},1,{id}\n", sample.card);
        let first = 8 * k + 1;
        for corner in 0..8 {
            let x = f64::from(u8::from([1, 2, 5, 6].contains(&corner)));
            let y = f64::from(u8::from([2, 3, 6, 7].contains(&corner)));
            let z = f64::from(u8::from(corner >= 4));
            let [x, y, z] = [SIDE * x + 2.0 * SIDE * k as f64, SIDE * y, SIDE * z];
            let n = first + corner;
            let _ = writeln!(nodes, "{n},{x},{y},{z}");
            let set = if corner < 4 { &mut sides } else { &mut tops };
            let _ = writeln!(set, "{n}");
        }
        let corners: Vec<String> = (first..first + 8).map(|n| n.to_string()).collect();
        let _ = write!(text, "*ELEMENT_SOLID\n{id},{id},{}\n", corners.join(","));
    }
    let held = [1, 2, 3].map(|dof| u8::from(dof != axis));
    let [x, y, z] = held;
    let _ = write!(
        text,
        "*NODE\n{nodes}*SET_NODE_LIST\n1\n{tops}*SET_NODE_LIST\n2\n{sides}\
         *BOUNDARY_SPC_SET\n2,0,1,1,1\n*BOUNDARY_SPC_SET\n1,0,{x},{y},{z}\n\
         *BOUNDARY_PRESCRIBED_MOTION_SET\n1,{axis},2,1,1.0\n*END\n"
    );
    text
}

/// Runs a deck on 1, 2 and 3 workers with the same digest; returns the internal energy of each part
/// per volume at the middle and at the end.
fn energies(text: &str, parts: usize) -> Vec<[f64; 2]> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, text).unwrap();
    let runs = ["1", "2", "3"].map(|workers| {
        let deck = path.to_str().unwrap();
        let quiet = ["--set", "output.field_interval=-1"];
        run(crumple_with(&[&["run", deck, "--workers", workers], &quiet[..]].concat())).with_code(0)
    });
    for ended in &runs {
        assert_eq!(ended.digest(), runs[0].digest(), "any number of workers");
        let error = ended.summary()["energy"]["error_max"].as_f64().expect("a number");
        // The measured value was 1.6e-4: the prescribed velocities jump.
        assert!(error < 5e-4, "energy error {error}");
    }
    let text = fs::read_to_string(runs[0].out().join("parts.csv")).expect("energies of parts");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let column = header.iter().position(|h| h.starts_with("internal")).expect("a column");
    let rows: Vec<(f64, usize, f64)> = lines
        .map(|row| {
            let number = |text: &str| text.parse::<f64>().expect("a number");
            (number(row[0]), number(row[1]) as usize, number(row[column]) / SIDE.powi(3))
        })
        .collect();
    let at = |part: usize, time: f64| {
        let own = rows.iter().filter(|row| row.1 == part);
        own.min_by(|a, b| (a.0 - time).abs().total_cmp(&(b.0 - time).abs())).expect("a row").2
    };
    (1..=parts).map(|part| [at(part, 0.5 * END), at(part, END)]).collect()
}

/// Cubes of all soft materials, pressed and released, and sheared: the internal energy is that of
/// the closed forms, the energy balances, and the number of workers changes no bit.
#[test]
fn cubes_of_rubber_and_foam_have_the_energy_of_their_closed_forms() {
    let samples = samples();
    let pressed = energies(&deck(&samples, 3, -(1.0 - STRETCH) * SIDE, 0.0), samples.len());
    let sheared = energies(&deck(&samples, 1, SIDE, SIDE), samples.len());
    for (k, sample) in samples.iter().enumerate() {
        let ([middle, end], [shear, _]) = (pressed[k], sheared[k]);
        let name = sample.card.lines().next().unwrap_or_default();
        let near = |got: f64, exact: f64, what: &str| {
            // The bulk viscosity and the row of the history are one part in a thousand.
            let off = (got - exact).abs() / sample.pressed.abs();
            assert!(exact.is_nan() || off < 5e-3, "{name} {what}: {got:e} for {exact:e}");
        };
        near(middle, sample.pressed, "pressed");
        near(end, sample.returned, "returned");
        near(shear, sample.sheared, "sheared");
    }
    // Crushed by a constant stress to 30 %; of this 2e-5^2/(2 E) returns.
    let [crushed, left] = pressed[6];
    let elastic = 2e-5f64.powi(2) / (2.0 * 0.001);
    assert!((crushed / (0.3 * 2e-5 - elastic) - 1.0).abs() < 1e-2, "{crushed:e}");
    assert!((left / (0.3 * 2e-5 - 2.0 * elastic) - 1.0).abs() < 2e-2, "{left:e}");
    // Stress G_long sin(gamma) of simple shear in axes that turn with the spin.
    let [slow, _] = sheared[7];
    assert!((slow / (0.0005 * (1.0 - 1.0f64.cos())) - 1.0).abs() < 1e-3, "{slow:e}");
}

/// A null material of solids is a fluid with the pressure of its part; limits of its volume are
/// criteria of failure. The table of the pressure may be in the card or in curves.
#[test]
fn null_solids_are_fluids() {
    let metal = "*MAT_003\n1,7.85e-6,200.0,0.3,0.25\n";
    let null = "*MAT_NULL\n7,1.0e-6,-0.25,1e-6,2.0,0.5\n";
    let listed = "*EOS_TABULATED\n3,0.5\n0.1,0.0,-0.1,-0.2\n\n-5.0,0.0,0.3,1.5\n\n\
                  0.8,0.8,0.8,1.2\n\n";
    let curves = "*EOS_TABULATED\n3,0.5,,,21,22\n*DEFINE_CURVE\n21\n-0.2,1.5\n-0.1,0.3\n0.0,0.0\n\
                  0.1,-5.0\n*DEFINE_CURVE\n22\n-0.2,1.2\n-0.1,0.8\n0.0,0.8\n0.1,0.8\n";
    let with = |null: &str, eos: &str, eosid: i64| {
        let deck = format!("{BASE}{MOVES}{metal}{null}{eos}");
        deck.replace("2,2,1\n", &format!("2,2,7,{eosid}\n"))
    };
    for eos in [listed, curves] {
        let model = model_of(&with(null, eos, 3));
        let fluid = model.job.material.iter().find(|m| m.name == "mat-7").expect("the fluid");
        assert_eq!(fluid.law, "fluid");
        for (key, value) in [
            ("viscosity", "0.000001"),
            ("eos_min_pressure", "-0.25"),
            ("eos_table", "[[-0.1, -5.0, 0.4], [0.0, 0.0, 0.4], [0.1, 0.3, 0.4], [0.2, 1.5, 0.6]]"),
        ] {
            let got = fluid.parameters.get(key).map(|value| value.to_string());
            assert_eq!(got.as_deref(), Some(value), "{key}");
        }
        for key in ["erosion_volume_strain", "erosion_compression"] {
            let limit = fluid.parameters.get(key).and_then(|value| value.as_float());
            assert_eq!(limit, Some(2.0f64.ln()), "{key}");
        }
        assert!(!fluid.parameters.contains_key("youngs_modulus"));
    }
    // Without a limit no tension is carried.
    let model = model_of(&with("*MAT_NULL\n7,1.0e-6\n", listed, 3));
    let cut = model.job.material.iter().find_map(|m| m.parameters.get("eos_min_pressure"));
    assert_eq!(cut.and_then(|value| value.as_float()), Some(0.0));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    for (deck, words) in [
        (with(null, listed, 0), "part 2: its material 7 has no pressure without an equation"),
        (with(&null.replace("-0.25", "0.25"), listed, 3), "`pc` = 0.25 is above 0"),
        (with(&null.replace("2.0,0.5", "0.5,0.5"), listed, 3), "`terod` = 0.5 never fails"),
        (with(null, &curves.replace("-0.1,0.8", "-0.15,0.8"), 3), "`lct` = 22"),
        (with(null, &listed.replace("0.0,0.3,1.5", "0.2,0.3,1.5"), 3), "C has to be 0"),
        (
            with(null, listed, 3).replace("1,1,1\n", "1,1,7\n"),
            "give the solids a material of their",
        ),
        (
            with(null, &format!("{listed}*MAT_ADD_EROSION\n7,,,,,0.5\n\n"), 3),
            "`terod` next to *MAT_ADD_EROSION voleps",
        ),
        (
            with(null, "*EOS_MURNAGHAN\n3,7.0,0.343\n", 3),
            "part 2: *EOS_MURNAGHAN is for particles only",
        ),
    ] {
        fs::write(&path, format!("{deck}*END\n")).unwrap();
        let text = crumple::input::job::read(&path, &[]).err().expect(words).to_string();
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// A limit of the principal strain holds for solids too, and solids whose step falls are deleted
/// where the deck says so; shells are not.
#[test]
fn solids_erode_by_their_strain_and_step() {
    let lines = "*MAT_ADD_EROSION\n1\n,,,0.3\n*CONTROL_TIMESTEP\n0.0,0.9,0,0.0,0.0,0,1\n";
    let model = model_of(&format!("{BASE}{MOVES}*MAT_003\n1,7.85e-6,200.0,0.3,0.25\n{lines}"));
    assert_eq!(parameter(&model, "erosion_major_strain"), "0.3");
    let inverted = |id: u32| {
        let part = model.settings.parts.iter().find(|p| p.id == id).expect("a part");
        format!("{:?}", part.parameters.get("inverted"))
    };
    assert!(inverted(2).contains("delete") && !inverted(1).contains("delete"));
}

/// A metal without a bulk modulus takes it from the equation of state of its part.
#[test]
fn a_hydrodynamic_metal_has_the_shear_modulus_of_its_card() {
    let metal = "*MAT_003\n1,7.85e-6,200.0,0.3,0.25\n";
    let eos = "*EOS_GRUNEISEN\n3,3940.0,1.489,,,2.02,0.47\n";
    let with = |hydro: &str, eosid: i64| {
        let deck = format!("{BASE}{MOVES}{metal}{hydro}{eos}");
        deck.replace("2,2,1\n", &format!("2,2,7,{eosid}\n"))
    };
    let shear = |hydro: &str| {
        let model = model_of(&with(hydro, 3));
        let material = model.job.material.iter().find(|m| m.name == "mat-7").expect("the metal");
        assert_eq!(material.law, "j2");
        let number = |key: &str| material.parameters.get(key).and_then(|value| value.as_float());
        let [e, nu] = ["youngs_modulus", "poisson"].map(|key| number(key).expect(key));
        assert!((e / (2.0 * (1.0 + nu)) - 46.0).abs() < 1e-12);
        material.parameters.clone()
    };
    let linear = shear("*MAT_ELASTIC_PLASTIC_HYDRO\n7,8.93e-6,46.0,0.3,0.5,-1.5,0.8\n");
    for (key, value) in [
        ("yield_stress", 0.3),
        ("hardening_modulus", 0.5),
        ("eos_min_pressure", -1.5),
        ("failure_strain", 0.8),
    ] {
        assert_eq!(linear.get(key).and_then(|value| value.as_float()), Some(value), "{key}");
    }
    let curve = shear("*MAT_010_SPALL\n7,8.93e-6,46.0\n,,2.0\n0.0,0.1\n\n0.3,0.4\n\n");
    let hardening = curve.get("hardening").map(|value| value.to_string());
    assert_eq!(hardening.as_deref(), Some("[[0.0, 0.3], [0.1, 0.4], [10.0, 10.300000000000002]]"));
    assert!(!curve.contains_key("eos_min_pressure"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{}*END\n", with("*MAT_010\n7,8.93e-6,46.0,0.3\n", 0))).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("no pressure").to_string();
    assert!(text.contains("its material 7 has no pressure"), "{text}");
    let shells = with("*MAT_010\n7,8.93e-6,46.0,0.3\n", 3).replace("1,1,1\n", "1,1,7\n");
    fs::write(&path, format!("{shells}*END\n")).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("shells").to_string();
    assert!(text.contains("part 1: *MAT_ELASTIC_PLASTIC_HYDRO is supported for solids"), "{text}");
}
