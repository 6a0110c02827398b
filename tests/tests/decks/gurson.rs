//! Metals with voids in decks: parameters, what is refused, written decks. Units mm, ms, kg, so kN
//! and GPa.

use crate::base::{BASE, MOVES, PULLED, assert_refused, assert_same_when_written, model_of};
use crumple_proto::partition::Param;

/// The base of this metal.
fn base(cards: &str) -> String {
    format!("{BASE}{MOVES}{cards}")
}

/// A card with these parts: after the first five fields, after the voids, and the last cards.
fn card(hardening: &str, voids: &str, rest: &str) -> String {
    format!("*MAT_GURSON\n1,7.85e-6,200.0,0.3,{hardening}\n{voids}\n{rest}\n")
}

/// Returns a parameter of the material; nothing if it is not given.
fn parameter(text: &str, key: &str) -> Option<Param> {
    let model = model_of(text);
    let material = &model.settings.materials[0];
    assert_eq!(material.law, "gurson");
    material.parameters.get(key).cloned()
}

const CURVE: &str = "*DEFINE_CURVE\n21\n0.0,0.3\n0.1,0.4\n";

#[test]
fn fields_become_parameters() {
    let voids = "0.05,0.002,0.3,0.1,0.04,0,1,0.2";
    let power = base(&card("0.4,5.0,1.5,1.0", voids, ""));
    let number = |x: f64| Some(Param::Number(x));
    for (key, value) in [
        ("q1", number(1.5)),
        ("q2", number(1.0)),
        ("void_fraction", number(0.002)),
        ("critical_void_fraction", number(0.05)),
        ("failure_void_fraction", number(0.2)),
        ("failed_points", number(1.0)),
        ("nucleation", Some(Param::List(vec![0.04, 0.3, 0.1]))),
        ("voids_only_grow", None),
        ("voids_close", None),
    ] {
        assert_eq!(parameter(&power, key), value, "{key}");
    }
    // The power law begins with sigy and the strain at yield.
    let Some(Param::List(swift)) = parameter(&power, "swift") else { panic!("no power law") };
    let [k, e0, n] = swift[..] else { panic!("{swift:?}") };
    assert!((k * e0.powf(n) - 0.4).abs() < 1e-14 && (e0, n) == (0.002, 0.2), "{swift:?}");

    let linear = base(&card("0.4,,1.5,1.0", "0.05,0.002,,,,10.0,2,0.2", ""));
    let Some(Param::Number(modulus)) = parameter(&linear, "hardening_modulus") else { panic!() };
    assert!((modulus - 200.0 * 10.0 / 190.0).abs() < 1e-12, "{modulus}");

    let rows = |rows: &[[f64; 2]]| Some(Param::Table(rows.iter().map(|r| r.to_vec()).collect()));
    let sizes = "0,0.1\n0.4,0.5\n1.0,5.0,0,0,0.2,0.1\n0,0,3,0,0,0,1";
    let points = base(&card("0.0,,1.5,1.0", "0.05,0.002,,,,,3,0.9", sizes));
    assert_eq!(parameter(&points, "failure_void_fractions"), rows(&[[1.0, 0.2], [5.0, 0.1]]));
    assert_eq!(parameter(&points, "failure_void_fraction"), None);
    assert_eq!(parameter(&points, "failed_points"), number(3.0));
    assert_eq!(parameter(&points, "voids_only_grow"), Some(Param::Flag(true)));
    let Some(Param::Table(hardening)) = parameter(&points, "hardening") else { panic!() };
    assert_eq!(hardening[..2], [[0.0, 0.4], [0.1, 0.5]]);

    let curves = "\n\n\n21,22,0,0,0,0,2";
    let more = "*DEFINE_CURVE\n22\n1.0,0.2\n4.0,0.1\n";
    let curves = base(
        &format!("{}{CURVE}{more}", card("", "0.05,0.002", curves))
            .replace("0.3,\n", "0.3,,,1.5,1.0\n"),
    );
    assert_eq!(parameter(&curves, "failure_void_fractions"), rows(&[[1.0, 0.2], [4.0, 0.1]]));
    assert_eq!(parameter(&curves, "voids_close"), Some(Param::Flag(true)));
}

#[test]
fn what_is_not_supported_is_refused() {
    let voids = "0.05,0.002,0.3,0.1,0.04,0,1,0.2";
    let of = |rest: &str| base(&card("0.4,5.0,1.5,1.0", voids, rest));
    for (text, words) in [
        (of("\n\n\n0,0,0,21"), "lcf0"),
        (of("\n\n\n0,0,0,0,0,0,4"), "use 0, 1 or 2"),
        (of("\n\n\n0,0,-50"), "number of points"),
        (of("\n\n\n0\n0.5"), "damage by shear"),
        (base(&card("0.4,0.5,1.5,1.0", voids, "")), "give n from 1 on"),
        (base(&card("0.4,5.0,0.0,1.0", voids, "")), "q1 is 0"),
        (base(&card("0.4,5.0,1.5,1.0", "0.3,0.002,-7,0.1,0.04,0,1,0.2", "")), "nucleation is not"),
        (
            base(&card("0.4,5.0,1.5,1.0", "0.3,0.002,0.3,0.1,0.04,0,1,0.2", "")),
            "critical_void_fraction is 0.3",
        ),
        (base(&card("0.4,5.0,1.5,1.0", "0,0,0,0,0,0,5", "")), "use 1, 2 or 3"),
    ] {
        assert_refused(&format!("{text}{CURVE}"), &[words]);
    }
}

/// A written deck gives the same bits, with each form of hardening.
#[test]
fn written_decks_are_the_same() {
    let base = base("").replace(MOVES, PULLED);
    let voids = "0.05,0.002,0.1,0.05,0.04,10.0,ATYP,0.2";
    for (hardening, atyp, rest) in [
        ("0.4,5.0,1.5,1.0", "1", ""),
        ("0.4,,1.5,1.0", "2", ""),
        (",,1.2,1.0", "1", "\n\n1.0,5.0,0,0,0.2,0.1\n21,0,3,0,0,0,1"),
    ] {
        let cards = card(hardening, &voids.replace("ATYP", atyp), rest);
        assert_same_when_written(
            &format!("{base}{cards}{CURVE}"),
            "time.max_cycles=300",
            "*MAT_GURSON_TITLE",
        );
    }
}
