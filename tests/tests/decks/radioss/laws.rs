//! Materials by name, their failure on solids, functions of the rate that cross. Units mm, ms, kg.

use super::{card, deck, mesh, model, moves, properties, reading, said};
use crumple::input::job::Model;

fn text_of(law: &str) -> String {
    mesh() + &properties() + &moves() + &deck(law)
}

fn numbers(model: &Model, keys: &[&str]) -> Vec<f64> {
    let law = &model.job.material[0];
    keys.iter().map(|key| law.parameters[*key].as_float().expect("a number")).collect()
}

/// The values of high-strength steel, in the units of the deck.
#[test]
fn a_material_of_the_format_has_its_values() {
    let found = model(&text_of("/MAT/PLAS_PREDEF/1\n=steel\n=HSS"));
    let law = &found.job.material[0];
    assert_eq!(law.law, "johnson_cook");
    let values = numbers(&found, &["a", "b", "n"]);
    let wanted = [0.3, 0.6114074651483, 0.3967613457219];
    for (value, wanted) in values.iter().zip(wanted) {
        assert!((value / wanted - 1.0).abs() < 1e-6, "{values:?}");
    }
    let elastic = [law.density, numbers(&found, &["youngs_modulus"])[0]];
    for (value, wanted) in elastic.iter().zip([7.85e-6, 210.0]) {
        assert!((value / wanted - 1.0).abs() < 1e-12, "{elastic:?}");
    }
    let report = reading(&text_of("/MAT/PLAS_PREDEF/1\n=steel\n=GOLD"), &[]).err();
    let report = report.expect("a report");
    assert!(report.contains("there is no material `GOLD`") && report.contains("UHSS"), "{report}");
    assert!(report.contains("1 error: nothing was run"), "{report}");
}

/// Localized necking is for shells: without any, it has no effect.
#[test]
fn localized_necking_is_for_shells() {
    let law = "/MAT/PLAS_PREDEF/1\n=steel\n=HSS\n/FAIL/BIQUAD/1\nr0 r0 r0 r0 r0\n\
               r1.0 i2 i3 r0.1 _ i0 r0\n";
    let report = reading(&text_of(law), &[]).err().expect("a report");
    assert!(report.contains("`sflag` = 3 is not supported"), "{report}");
    // The shells have another material.
    let plate = card("i1 i1 i0");
    let text = text_of(law).replacen(&plate, &card("i1 i2 i0"), 1)
        + &deck("/MAT/ELAST/2\n=other\nr7.85e-6\nr207.0 r0.3");
    let found = model(&text);
    let words = "`sflag` 3, localized necking, is for shells";
    assert!(said(&found).contains(words), "{}", said(&found));
    assert!(found.job.material.iter().any(|m| m.parameters.contains_key("gissmo_failure_strain")));
}

/// Functions that would cross beyond their last points only: the one of the larger rate goes on
/// with that of the smaller one.
#[test]
fn functions_that_cross_beyond_their_points_do_not_cross() {
    let law = "/FUNCT/8\n=y\nr0 r0.3\nr0.5 r0.4\n/FUNCT/9\n=z\nr0 r0.4\nr0.5 r0.45\n\
               /MAT/LAW36/1\n=m\nr7.85e-6\nr200 r0.3\ni2\n_\ni8 i9\nr1 r1\nr0 r0.5";
    let found = model(&text_of(law));
    let rows = found.job.material[0].parameters["hardening_by_rate"].as_array().expect("rows");
    let last = |rate: f64| -> Vec<f64> {
        let row = |row: &&toml::Value| row[0].as_float() == Some(rate);
        let row = rows.iter().rev().find(row).expect("a row");
        [1, 2].map(|c| row[c].as_float().expect("a number")).to_vec()
    };
    assert_eq!(last(0.0)[0], 10.0);
    // Slopes of 0.2 and 0.1 from 0.4 and 0.45 at 0.5: the smaller rate follows the larger one.
    assert!((last(0.5)[1] - (0.45 + 0.1 * 9.5)).abs() < 1e-12, "{:?}", last(0.5));
    assert!((last(0.0)[1] - last(0.5)[1]).abs() < 1e-12, "{:?}", last(0.0));
    assert!(said(&found).contains("cross beyond their last points"), "{}", said(&found));
}

/// A fabric has the moduli of its yarns along the axes of its property, and R_E is compression or
/// none.
#[test]
fn a_fabric_has_its_yarns_along_the_axes_of_its_property() {
    let sheet = card("i1 i1 i0");
    let text = |share: &str, more: &str| {
        let law = format!(
            "/MAT/FABRI/5\n=tissue\nr2e-7\nr0.2 r0.1 r0.3\nr0.076 r0.07 r0.07\n{share}\n\
             /PROP/SH_ORTH/5\n=tissue\ni1 i0 i0 i0\nr0 r0 r0 r0 r0\ni1 i0 r0.5\n\
             r0 r1 r0 r30\n/MAT/ELAST/1\n=steel\nr7.85e-6\nr207.0 r0.3\n{more}"
        );
        text_of(&law).replacen(&sheet, &card("i5 i5 i0"), 1)
    };
    let found = model(&text("r0.001", ""));
    let law = found.job.material.iter().find(|m| m.law == "fabric").expect("a fabric");
    let number = |key: &str| law.parameters[key].as_float().expect("a number");
    assert_eq!([number("youngs_modulus"), number("youngs_modulus_b")], [0.2, 0.1]);
    assert_eq!([number("poisson"), number("shear_modulus")], [0.3 * 0.1 / 0.2, 0.076]);
    assert_eq!(number("angle"), 30.0);
    assert_eq!(law.parameters["direction"].as_array().expect("a vector")[1].as_float(), Some(1.0));
    assert!(!law.parameters.contains_key("compression"));
    let whole = model(&text("r0", ""));
    assert!(whole.job.material.iter().any(|m| m.parameters.contains_key("compression")));
    let report = reading(&text("r0.2", ""), &[]).err().expect("a report");
    assert!(report.contains("`re` = 0.2 is not supported"), "{report}");
}

/// The yield condition of Hill is that of Barlat with the exponent 2. A function of the mean over
/// the directions becomes that of tension along the first axis: the same work for the same path.
#[test]
fn a_sheet_of_hill_yields_along_its_axes() {
    let sheet = card("i1 i1 i0");
    let property =
        "/PROP/SH_ORTH/5\n=sheet\ni1 i0 i0 i0\nr0 r0 r0 r0 r0\ni3 i0 r0.5\nr0 r1 r0 r30\n";
    let text = |iyield: &str, functions: &str, property: &str| {
        let law = format!(
            "/FUNCT/8\n=y\nr0 r0.3\nr0.5 r0.4\n/MAT/HILL_TAB/5\n=sheet\nr7.85e-6\nr207.0 r0.3\n_\n\
             r1.73 r1.34 r2.24 r0 {iyield}\n_\n{functions}\n{property}\
             /MAT/ELAST/1\n=steel\nr7.85e-6\nr207.0 r0.3\n"
        );
        text_of(&law).replacen(&sheet, &card("i5 i5 i0"), 1)
    };
    let law = |text: &str| {
        let found = model(text).job.material.into_iter().find(|m| m.law == "barlat");
        found.expect("a sheet").parameters
    };
    let first = |parameters: &std::collections::BTreeMap<String, toml::Value>| {
        let rows = parameters["hardening"].as_array().expect("rows");
        let number = |row: usize, c: usize| rows[row][c].as_float().expect("a number");
        [number(0, 1), number(1, 0), number(1, 1)]
    };
    let direct = law(&text("i1", "i8", property));
    let keys = ["exponent", "lankford_0", "lankford_45", "lankford_90", "angle"];
    assert_eq!(keys.map(|key| direct[key].as_float()), [2.0, 1.73, 1.34, 2.24, 30.0].map(Some));
    assert_eq!(first(&direct), [0.3, 0.5, 0.4]);
    let mean = first(&law(&text("i0", "i8 _ r2.0", property)));
    let r: f64 = (1.73 + 2.0 * 1.34 + 2.24) / 4.0;
    let along = (r / (1.0 + r) * (1.0 + 1.0 / 1.73)).sqrt();
    for (found, wanted) in mean.into_iter().zip([0.6 / along, 0.5 * along, 0.8 / along]) {
        assert!((found / wanted - 1.0).abs() < 1e-14, "{found} {wanted}");
    }
    for (text, words) in [
        (text("i1", "i8\ni8 _ r1.0 r0.1", property), "2 functions"),
        (text("i1", "i8", &property.replace("SH_ORTH", "SHELL")), "which its property lacks"),
        (text("i1", "i8", property).replace("1.73", "-1.0"), "r00 is -1"),
    ] {
        let report = reading(&text, &[]).err().expect("a report");
        assert!(report.contains(words), "{words}: {report}");
    }
}
