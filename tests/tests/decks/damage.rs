//! Damage that decks add to materials: parameters, what is refused, written decks. Units mm, ms,
//! kg, so kN and GPa.

use crate::base::{BASE, MOVES, PULLED, assert_refused, assert_same_when_written, model_of};
use crumple::input::job::Model;
use crumple_tests::program::{crumple_with, run};
use std::fs;

const METAL: &str = "*MAT_024\n1,7.85e-6,207.0,0.3,0.25,1.0\n\n\n\n";
const CURVES: &str = "*DEFINE_CURVE\n31\n0.0,0.5\n0.33,0.3\n0.66,0.4\n*DEFINE_CURVE\n32\n0.0,0.2\n\
    0.66,0.1\n*DEFINE_CURVE\n33\n1.0,1.0\n20.0,0.6\n";

fn deck(cards: &str) -> String {
    format!("{BASE}{MOVES}{METAL}{cards}{CURVES}")
}

fn parameter(model: &Model, key: &str) -> String {
    let metal = model.job.material.iter().find(|m| m.law == "j2").expect("a metal");
    metal.parameters.get(key).map_or(String::new(), |value| value.to_string())
}

/// Both keywords give the same damage.
#[test]
fn fields_become_parameters() {
    let own = "*MAT_ADD_DAMAGE_GISSMO\n1,,1,,2\n31,-32,2.0,,1.5,33\n";
    let of_erosion = "*MAT_ADD_EROSION\n1,,,,,,2\n\n1,1,31,-32,2.0,,1.5,33\n";
    for card in [own, of_erosion] {
        let model = model_of(&deck(card));
        for (key, value) in [
            ("gissmo_failure_strain", "[[0.0, 0.5], [0.33, 0.3], [0.66, 0.4]]"),
            ("gissmo_critical_strain", "[[0.0, 0.2], [0.66, 0.1]]"),
            ("gissmo_critical_damage", ""),
            ("gissmo_exponent", "2.0"),
            ("gissmo_fading_exponent", "1.5"),
            ("gissmo_size_factors", "[[1.0, 1.0], [20.0, 0.6]]"),
            ("gissmo_failed_points", "2.0"),
        ] {
            assert_eq!(parameter(&model, key), value, "{key}: {card}");
        }
    }
    let fixed = model_of(&deck("*MAT_ADD_DAMAGE_GISSMO\n1,,1,,-67.0\n31,0.15\n"));
    for (key, value) in [
        ("gissmo_critical_strain", "[[0.0, 0.15]]"),
        ("gissmo_exponent", "1.0"),
        ("gissmo_fading_exponent", "1.0"),
        ("gissmo_size_factors", ""),
        ("gissmo_failed_points", "-67.0"),
    ] {
        assert_eq!(parameter(&fixed, key), value, "{key}");
    }
    let damage = model_of(&deck("*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31,,,0.3\n"));
    assert_eq!(parameter(&damage, "gissmo_critical_damage"), "0.3");
    assert_eq!(parameter(&damage, "gissmo_failed_points"), "1.0");
    // Damage that is only shown, and one that is not asked for.
    let shown = model_of(&deck("*MAT_ADD_DAMAGE_GISSMO\n1\n31\n"));
    assert_eq!(parameter(&shown, "gissmo_failure_strain"), "");
    assert!(shown.mapping.iter().any(|entry| entry.asked == "GISSMO with dtyp 0"));
    let none = model_of(&deck("*MAT_ADD_EROSION\n1,,,,-0.4,,3\n"));
    assert_eq!(parameter(&none, "gissmo_failure_strain"), "");
    assert_eq!(parameter(&none, "erosion_failed_points"), "3.0");
}

/// A material has one damage, and each criterion once: the error names the lines of both cards.
#[test]
fn two_cards_for_one_material_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let damage = "*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31,,,0.3\n";
    let erosion = "*MAT_ADD_EROSION\n1,,0.5\n\n1,1,31,0.2\n";
    for (cards, what, distance) in [
        (format!("{damage}{damage}"), "damage", 3),
        // The criteria of erosion are read first.
        (format!("{damage}{erosion}"), "damage", 4),
        (format!("{erosion}*MAT_ADD_EROSION\n1,,0.6\n"), "mxpres", 4),
    ] {
        let text = format!("{}*END\n", deck(&cards));
        fs::write(&path, &text).unwrap();
        let report = crumple::input::job::read(&path, &[]).err().expect("errors").to_string();
        let line_of = |which: &str| {
            let words = format!("material 1 has {what} by two cards: this is the {which} one");
            let after = report.split(&words).nth(1).unwrap_or_else(|| panic!("{words}: {report}"));
            let number = after.split("deck.k:").nth(1).expect("a place");
            number.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse::<usize>().unwrap()
        };
        assert_eq!(line_of("first").abs_diff(line_of("second")), distance, "{report}");
    }
    // The critical strain is used, not the critical damage.
    let mixed = model_of(&deck("*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31,0.15,,0.3\n"));
    assert_eq!(parameter(&mixed, "gissmo_critical_strain"), "[[0.0, 0.15]]");
    let said = mixed.mapping.iter().find(|entry| entry.asked == "dcrit 0.3").expect("a mapping");
    assert_eq!((said.of.as_str(), said.used.as_str()), ("material 1", "not used: ecrit is given"));
}

/// In a file with an offset of curves the negative id of the critical curve moves too.
#[test]
fn ids_of_curves_have_the_offset_of_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let (path, own) = (folder.path().join("deck.k"), folder.path().join("own.k"));
    let card = "*MAT_ADD_DAMAGE_GISSMO\n1,,1,,2\n31,-32,2.0,,1.5,33\n";
    fs::write(&own, format!("*KEYWORD\n{METAL}{card}{CURVES}*END\n")).unwrap();
    // Another curve has the id without the offset.
    let other = "*DEFINE_CURVE\n32\n0.0,7.0\n1.0,8.0\n";
    let include = "*INCLUDE_TRANSFORM\nown.k\n0,0,0,0,0,500\n";
    fs::write(&path, format!("{BASE}{MOVES}{other}{include}\n\n\n*END\n")).unwrap();
    let model = crumple::input::job::read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(parameter(&model, "gissmo_critical_strain"), "[[0.0, 0.2], [0.66, 0.1]]");
}

#[test]
fn what_is_not_supported_is_refused() {
    let alone = "*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31,-99,1.0,,-32,-33,2\n32,0.5,0.4,32,1,,0.7,1\n";
    let with_criteria =
        "*MAT_ADD_EROSION\n1\n\n1,1,31,,,0.3\n1,0.5,3,32,0.5,0.4,32,1\n,0.7,1\n32\n";
    for (card, words) in [
        (
            alone,
            &["no *DEFINE_CURVE with the id 99", "`fadexp` = -32", "`lcregd` = -33", "`instf` = 2"]
                [..],
        ),
        (with_criteria, &["`sizflg` = 1", "`lcfld` = 32"]),
        ("*MAT_ADD_DAMAGE_GISSMO\n1,,61\n31\n", &["`dtyp` = 61"]),
        ("*MAT_ADD_DAMAGE_GISSMO\n7,,1\n31\n", &["no *MAT_... with the id 7"]),
        ("*MAT_ADD_EROSION\n1\n\n2,1,31\n", &["`idam` = 2"]),
        // Without damage the forming limits follow directly.
        ("*MAT_ADD_EROSION\n1\n\n0\n32\n", &["`lcfld` = 32"]),
        ("*MAT_ADD_DAMAGE_GISSMO\n1,,1\n33,,,1.0\n", &["gissmo_critical_damage is 1"]),
    ] {
        assert_refused(&deck(card), words);
    }
    for card in [alone, with_criteria] {
        let of_both = ["`shrf` = 0.5", "`biaxf` = 0.4", "`lcdlim` = 32", "`midfail` = 1"];
        assert_refused(&deck(card), &of_both);
        assert_refused(&deck(card), &["`lcsrs` = 32", "`soft` = 0.7", "`lp2bi` = 1"]);
    }
    // A law without plastic strain.
    let text = format!(
        "{BASE}{MOVES}*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31\n\
         {CURVES}"
    );
    assert_refused(&text, &["no plastic strain"]);
}

/// A plate that is torn has the same digest on 1, 2 and 3 workers, and as a written deck; elements
/// of it fail.
#[test]
fn a_torn_plate_has_one_digest() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let card = "*MAT_ADD_DAMAGE_GISSMO\n1,,1,,2\n31,-32,2.0,,1.5,33\n";
    let text = format!("{}{PULLED}", deck(card).replace(MOVES, ""));
    fs::write(&path, format!("{text}*END\n")).unwrap();
    let until = "end_time=0.7";
    let ended = |workers: &str| {
        let quiet = ["--set", "output.field_interval=-1", "--set", until];
        let asked = ["run", path.to_str().unwrap(), "--workers", workers];
        run(crumple_with(&[&asked[..], &quiet[..]].concat())).with_code(0)
    };
    let one = ended("1");
    let failed = &one.summary()["parts"][0]["failed"];
    assert!(failed.as_u64().is_some_and(|n| n > 0), "{failed}");
    for workers in ["2", "3"] {
        assert_eq!(one.digest(), ended(workers).digest(), "{workers} workers");
    }
    assert_same_when_written(&text, until, "*MAT_ADD_DAMAGE_GISSMO");
}

/// Damage from an onset on: keys by the criteria, with their curves.
#[test]
fn criteria_of_onset_become_parameters() {
    let card = "*MAT_ADD_DAMAGE_DIEM\n1,3,0,,-50\n0,31,,,1\n0,0,0.2\n1,32,0.3\n1,1,0.05\n4,33,0.1\n\
                0,1,0.0\n";
    let model = model_of(&deck(card));
    for (key, value) in [
        ("diem_ductile", "[[0.0, 0.5], [0.33, 0.3], [0.66, 0.4]]"),
        ("diem_ductile_displacement", "0.2"),
        ("diem_ductile_multiplied", ""),
        ("diem_shear", "[[0.0, 0.2], [0.66, 0.1]]"),
        ("diem_shear_pressure", "0.3"),
        ("diem_shear_displacement", ""),
        ("diem_shear_energy", "0.05"),
        ("diem_shear_multiplied", "true"),
        ("diem_principal", "[[1.0, 1.0], [20.0, 0.6]]"),
        ("diem_principal_pressure", "0.1"),
        ("diem_principal_displacement", "0.0"),
        ("diem_failed_points", "-50.0"),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    // Damage that is only shown is none.
    let shown = model_of(&deck("*MAT_ADD_DAMAGE_DIEM\n1,1\n0,31\n0,-1,0.2\n"));
    assert_eq!(parameter(&shown, "diem_failed_points"), "");
    let asked = "DIEM with dityp 0 and dctyp -1";
    assert!(shown.mapping.iter().any(|entry| entry.asked == asked));
    // The next criterion is not read.
    let one = model_of(&deck(&card.replace("1,3,0,", "1,1,0,")));
    assert_eq!(parameter(&one, "diem_shear"), "");
}

/// In a file with other units and an offset of curves, ids, displacements and energies change.
#[test]
fn criteria_of_onset_have_the_units_of_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let (path, own) = (folder.path().join("deck.k"), folder.path().join("own.k"));
    let card = "*MAT_ADD_DAMAGE_DIEM\n1,2\n0,31\n0,0,0.2\n1,32\n1,0,0.05\n";
    // All curves of a file with other units have a use.
    let curves = CURVES.split("*DEFINE_CURVE\n33").next().expect("curves");
    fs::write(&own, format!("*KEYWORD\n{METAL}{card}{curves}*END\n")).unwrap();
    // Lengths in the file are 10 times those of the deck, masses twice.
    let include = "*INCLUDE_TRANSFORM\nown.k\n0,0,0,0,0,500\n\n2.0,1.0,10.0\n\n";
    fs::write(&path, format!("{BASE}{MOVES}{include}*END\n")).unwrap();
    let model = crumple::input::job::read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(parameter(&model, "diem_ductile_displacement"), "2.0");
    assert_eq!(parameter(&model, "diem_shear_energy"), "0.1");
    assert_eq!(parameter(&model, "diem_shear"), "[[0.0, 0.2], [0.66, 0.1]]");
}

#[test]
fn criteria_of_onset_that_are_not_supported_are_refused() {
    let head = "*MAT_ADD_DAMAGE_DIEM\n1,1";
    let gissmo = "*MAT_ADD_DAMAGE_GISSMO\n1,,1\n31,,,0.3\n";
    for (card, words) in [
        (format!("{head}\n2,31\n0,0,0.2\n"), "`dityp` = 2 is not supported: criteria of thin"),
        (format!("{head}\n0,31,,,,33\n0,0,0.2\n"), "`p5` = 33"),
        (format!("{head}\n0,31\n0,0,0.2,,0.5,33\n"), "`q4` = 33"),
        (format!("{head}\n0,31\n0,0,-3\n"), "`q1` = -3"),
        (format!("{head}\n0,31\n0,2,0.2\n"), "`dctyp` = 2"),
        ("*MAT_ADD_DAMAGE_DIEM\n1,2\n0,31\n0,0,0.2\n1,32\n".into(), "give 1 to 5 criteria"),
        (format!("{head}\n0,99\n0,0,0.2\n"), "no *DEFINE_CURVE with the id 99"),
        ("*MAT_ADD_DAMAGE_DIEM\n1,2\n0,31\n0,0,0.2\n0,32\n0,0,0.2\n".into(), "give each one once"),
        ("*MAT_ADD_DAMAGE_DIEM\n1,3\n0,31\n0,0,0.2\n".into(), "give 1 to 5 criteria"),
        ("*MAT_ADD_DAMAGE_DIEM\n7,1\n0,31\n0,0,0.2\n".into(), "no *MAT_... with the id 7"),
        (format!("{gissmo}{head}\n0,31\n0,0,0.2\n"), "has damage by two cards"),
    ] {
        assert_refused(&deck(&card), &[words]);
    }
}
