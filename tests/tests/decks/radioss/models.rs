//! Keywords of Radioss and the job that they become.

use super::{card, deck, mesh, model, moves, properties, reading, said, steel, with};
use crumple::input::job::Model;
use crumple_proto::mesh::Shape;

fn value<'m>(model: &'m Model, key: &str) -> &'m toml::Value {
    &model.job.material[0].parameters[key]
}

fn number(model: &Model, key: &str) -> f64 {
    value(model, key).as_float().unwrap_or_else(|| panic!("{key}"))
}

fn rows(model: &Model, key: &str) -> Vec<[f64; 2]> {
    let row = |r: &toml::Value| [0, 1].map(|c| r[c].as_float().unwrap());
    value(model, key).as_array().unwrap().iter().map(row).collect()
}

fn set(model: &Model, name: &str) -> Vec<u64> {
    let found = model.mesh.node_sets.get(name).unwrap_or_else(|| panic!("no {name}"));
    found.iter().map(|n| n.label()).collect()
}

/// Iflag 1: the engineering stress `(a + b eps^n) exp(-eps)` has its maximum, the given ultimate
/// stress, at the given engineering strain.
#[test]
fn an_ultimate_stress_gives_the_hardening() {
    let law =
        |numbers: &str| of_law(&format!("/MAT/LAW2/1\n=m\nr7.85e-6\nr200.0 r0.3 i1\n{numbers}"));
    let (yields, ultimate, strain) = (0.3, 0.5, 0.2f64);
    let found = law(&format!("r{yields} r{ultimate} r{strain}"));
    let [a, b, n] = ["a", "b", "n"].map(|key| number(&found, key));
    assert_eq!(a, yields);
    assert!(n > 0.0 && n < 1.0, "{n}");
    let engineering = |e: f64| (a + b * (1.0 + e).ln().powf(n)) / (1.0 + e);
    println!("b {b}, n {n}, {}", engineering(strain));
    assert!((engineering(strain) / ultimate - 1.0).abs() < 1e-12);
    for e in [0.5 * strain, 0.9 * strain, 1.1 * strain, 2.0 * strain] {
        assert!(engineering(e) < ultimate, "{e}: {}", engineering(e));
    }
    // Little hardening up to a large stress: a straight line that ends there.
    let steep = law("r0.3 r0.31 r0.3");
    let [b, s] = [number(&steep, "hardening_modulus"), 0.31 * 1.3];
    let plastic = 1.3f64.ln() - (s + 0.3) / 200.0;
    assert_eq!(steep.job.material[0].law, "j2");
    assert!((b / ((s - 0.3) / plastic) - 1.0).abs() < 1e-12, "{b}");
    // An ultimate stress below the yield stress: no hardening.
    for (numbers, words) in [
        ("r0.3 r0.5 r0", ""),
        ("r0.3 r0 r0.1", "stress is 0 at the strain 0.1"),
        ("r0.3 r0.5 r-0.1", "at the strain -0.1"),
    ] {
        let text = deck(&format!("/MAT/LAW2/1\n=m\nr7.85e-6\nr200.0 r0.3 i1\n{numbers}"));
        let found = reading(&(mesh() + &properties() + &moves() + &text), &[]);
        // A blank or zero strain is 1.
        assert_eq!(found.is_ok(), words.is_empty(), "{numbers}");
        assert!(found.err().is_none_or(|report| report.contains(words)), "{numbers}");
    }
    let flat = law("r0.3 r0.2 r0.1");
    assert_eq!((number(&flat, "yield_stress"), flat.job.material[0].law.as_str()), (0.3, "j2"));
    assert!(!flat.job.material[0].parameters.contains_key("hardening_modulus"));
}

/// Rubber whose terms Radioss fits to a function has the function itself, and the bulk modulus of
/// its slope at 0 and nu.
#[test]
fn rubber_of_a_function_has_the_function() {
    let with_points = |head: &str, points: &str| {
        let function = format!("/FUNCT/5\n=test\n{points}\n");
        let law = format!("/MAT/LAW69/2\n=gel\nr1e-6\n{head}\ni5\n{function}");
        let cube = "i2 i1 i0";
        mesh().replace(&card(cube), &card("i2 i2 i0"))
            + &properties()
            + &steel()
            + &moves()
            + &deck(&law)
    };
    let of = |head: &str| with_points(head, "r-0.4 r-2e-3\nr0 r0\nr0.5 r1e-3");
    let found = model(&of("i1 i0 r0.49 r1 i2 i-3"));
    let gel = found.job.material.iter().find(|m| m.law == "tabulated_rubber").expect("a rubber");
    let curve = gel.parameters["curve"].to_string();
    assert_eq!(curve, "[[-0.4, -0.002], [0.0, 0.0], [0.5, 0.001]]");
    let bulk = gel.parameters["bulk_modulus"].as_float().expect("a number");
    assert!((bulk / (2e-3 / (3.0 * 0.02)) - 1.0).abs() < 1e-12, "{bulk}");
    assert!(said(&found).contains("terms of Ogden fitted to the function"), "{}", said(&found));
    let report = reading(&of("i1 i5 r0.49"), &[]).err().expect("an error");
    assert!(report.contains("`fctbulk` = 5 is not supported"), "{report}");
    let report = reading(&of("i1 i0 r0.5"), &[]).err().expect("an error");
    assert!(report.contains("`nu` = 0.5 is not supported"), "{report}");
    let flat = with_points("i1 i0 r0.49", "r-0.4 r0\nr0 r0\nr0.5 r0");
    let report = reading(&flat, &[]).err().expect("an error");
    assert!(report.contains("`fct` = 5 is not supported"), "{report}");
}

/// Terms of the rubber of Ogden, without those of modulus 0; a blank nu is 0.495.
#[test]
fn rubber_has_its_terms() {
    let of = |head: &str, moduli: &str, exponents: &str| {
        let cube = "i2 i1 i0";
        let law = format!("/MAT/LAW42/2\n=rubber\nr1e-6\n{head}\n{moduli}\n_\n{exponents}\n_");
        assert!(mesh().contains(&card(cube)));
        mesh().replace(&card(cube), &card("i2 i2 i0"))
            + &properties()
            + &steel()
            + &moves()
            + &deck(&law)
    };
    let rubber = |text: &str| {
        let found = model(text).job.material.into_iter().find(|m| m.law == "ogden");
        found.expect("a rubber").parameters
    };
    let found = rubber(&of("r0.49", "r8e-4 r-2e-4 r0 r1e-3", "r2.0 r-2.0 r0 r3.5"));
    assert_eq!(found["terms"].to_string(), "[[0.0008, 2.0], [-0.0002, -2.0], [0.001, 3.5]]");
    assert_eq!(found["poisson"].as_float(), Some(0.49));
    assert_eq!(rubber(&of("_", "r8e-4", "r2.0"))["poisson"].as_float(), Some(0.495));
    for (head, words) in [
        ("r0.49 r0.1", "`sigcut` = 0.1"),
        ("r0.49 r0 _ i5", "`fctbulk` = 5"),
        ("r0.49 r0 _ i0 r1 i2", "`m` = 2"),
    ] {
        let report = reading(&of(head, "r8e-4", "r2.0"), &[]).err();
        let report = report.unwrap_or_else(|| panic!("no error: {words}"));
        assert!(report.contains(words), "{words}: {report}");
    }
    let mixed = reading(&of("r0.49", "r8e-4 r1e-4", "r2.0 r-2.0"), &[]).err().expect("an error");
    assert!(mixed.contains("mu alpha is not above 0"), "{mixed}");
}

/// Limits of the largest principal strain, with and without the strain at which the stress begins
/// to fall.
#[test]
fn the_largest_strain_fades_the_stress() {
    let law = |fail: &str| {
        of_law(&format!("/MAT/ELAST/1\n=m\nr7.85e-6\nr200.0 r0.3\n/FAIL/TENSSTRAIN/1\n{fail}"))
    };
    let fading = law("r0.1 r0.2");
    let keys = ["erosion_major_strain_start", "erosion_major_strain"];
    assert_eq!(keys.map(|key| number(&fading, key)), [0.1, 0.2]);
    assert!(said(&fading).contains("faded stress does not rise again"));
    // A shell goes with its first failed point.
    assert_eq!(number(&fading, "erosion_failed_points"), 1.0);
    let sudden = law("r0 r0 i0 r0.3");
    assert_eq!(number(&sudden, keys[1]), 0.3);
    assert!(!sudden.job.material[0].parameters.contains_key(keys[0]));
    assert!(!said(&sudden).contains("faded stress"), "{}", said(&sudden));
    let backwards = law("r0.3 r0.2");
    assert!(said(&backwards).contains("epst1 0.3 -> not used"), "{}", said(&backwards));
    for (fail, words) in [
        ("r0.1 r0.2 i7", "`fct` = 7"),
        ("r0.1 r0.2 i0 r0.15", "`epsf1` = 0.15"),
        ("r0.1 r0.2 i0 r0 r0.1", "`epsf2` = 0.1"),
        ("r0.1 r0.2 i0 r0 r0 i3", "`sflag` = 3"),
        ("r0.1 r0.2 i0 r0 r0 i2\ni9 r1 r1\ni8", "`fctel` = 9"),
    ] {
        let text = mesh()
            + &properties()
            + &moves()
            + &deck(&format!(
                "/MAT/ELAST/1\n=m\nr7.85e-6\nr200.0 r0.3\n/FAIL/TENSSTRAIN/1\n{fail}"
            ));
        let report = super::reading(&text, &[]).err().unwrap_or_else(|| panic!("{fail}"));
        assert!(report.contains(words), "{words}: {report}");
    }
}

/// Strains to failure in five tests become a curve over the triaxiality.
#[test]
fn parabolas_give_the_strain_to_failure() {
    let steel = "/MAT/PLAS_JOHNS/1\n=m\nr7.85e-6\nr200.0 r0.3\nr0.3 r0.2 r1.0\n";
    let law = |fail: &str| of_law(&format!("{steel}/FAIL/BIQUAD/1\n{fail}"));
    let at = |model: &Model, x: f64| {
        let rows = rows(model, "gissmo_failure_strain");
        rows.iter().find(|row| (row[0] - x).abs() < 1e-9).map(|row| row[1]).expect("a point")
    };
    let tests = [-1.0 / 3.0, 0.0, 1.0 / 3.0, 1.0 / 3.0f64.sqrt(), 2.0 / 3.0];
    let five = law("r2.0 r1.0 r0.6 r0.4 r0.9");
    for (x, c) in tests.into_iter().zip([2.0, 1.0, 0.6, 0.4, 0.9]) {
        assert!((at(&five, x) - c).abs() < 1e-12, "{x}");
    }
    assert_eq!(number(&five, "gissmo_failed_points"), 1.0);
    // The vertex at plane strain: 0.4 + 0.2 (x - x0)^2/(1/3 - x0)^2.
    let x0 = tests[3];
    let wanted = 0.4 + 0.2 * ((0.4 - x0) / (1.0 / 3.0 - x0)).powi(2);
    assert!((at(&five, 0.4) - wanted).abs() < 1e-12);
    let mild = law("r0 r0 r0.5");
    for (x, ratio) in tests.into_iter().zip([3.5, 1.6, 1.0, 0.6, 1.5]) {
        assert!((at(&mild, x) - 0.5 * ratio).abs() < 1e-12, "{x}");
    }
    let ratios = law("r0 r0 r0.5\nr0.5 i99 i1\nr4 r2 r0.5 r1\n_ i1 r0.7 r2");
    assert!((at(&ratios, 0.0) - 1.0).abs() < 1e-12);
    let keys = ["gissmo_failed_points", "gissmo_critical_damage", "gissmo_fading_exponent"];
    assert_eq!(keys.map(|key| number(&ratios, key)), [-50.0, 0.7, 2.0]);
    // A share of the thickness is one of the points.
    let thick = law("r0 r0 r0.5\nr0.5 i1");
    assert_eq!(number(&thick, keys[0]), -50.0);
    assert!(said(&thick).contains("pthick 0.5: a share of the thickness"), "{}", said(&thick));
    let has = |model: &Model| {
        let numbers = &model.job.material[0].parameters;
        keys[1..].iter().any(|key| numbers.contains_key(*key))
    };
    // A critical damage of 1 is no softening; a number in the first columns is the id of the card.
    for fail in ["r0 r0 r0.5\nr0 i1\n_ i1 r1.0 r2", "r0 r0 r0.5\nr0 i1\ni77"] {
        assert!(!has(&law(fail)), "{fail}");
    }
    assert!(has(&law("r0 r0 r0.5\nr0 i1\n_ i1 r0.7 r2\ni77")));
    let sized = law("r0 r0 r0.5\nr0 i2 i0 r0 _ i9 r4.0\n/FUNCT/9\n=f\nr0.5 r1.0\nr2.0 r0.8");
    assert_eq!(rows(&sized, "gissmo_size_factors"), [[2.0, 1.0], [8.0, 0.8]]);
    let refused = |law: &str, fail: &str| {
        let lines = deck(&format!("{law}/FAIL/BIQUAD/1\n{fail}"));
        let text = mesh() + &properties() + &moves() + &lines;
        super::reading(&text, &[]).err().unwrap_or_else(|| panic!("{fail}"))
    };
    let elastic = "/MAT/ELAST/1\n=m\nr7.85e-6\nr200.0 r0.3\n";
    for (law, fail, words) in [
        (steel, "r2 r1 r0.6 r0.4 r0.9\nr0 i0 i3 r0.2", "`sflag` = 3"),
        (steel, "r0 r0 r0.5\nr0 i8", "`mflag` = 8"),
        (steel, "r2 r1 r0.6 r0.4 r0", "c1 to c5 are [2.0, 1.0, 0.6, 0.4, 0.0]"),
        (steel, "r0 r0 r0.5\nr0\n_ i2", "`icoup` = 2"),
        (elastic, "r0 r0 r0.5", "/MAT/LAW1 has no plastic strain"),
    ] {
        let report = refused(law, fail);
        assert!(report.contains(words), "{words}: {report}");
    }
}

/// A deck with another material.
fn of_law(lines: &str) -> Model {
    model(&(mesh() + &properties() + &moves() + &deck(lines)))
}

/// The base becomes two parts with their formulations, the units and the end of the run.
#[test]
fn the_base_becomes_a_job() {
    let model = model(&with("/TITLE\n=a plate"));
    assert_eq!((model.job.title.as_str(), model.job.units.as_str()), ("a plate", "mm, ms, kg"));
    assert_eq!((model.job.end_time, model.mesh.elements.len()), (10.0, 3));
    let [plate, cube] = &model.job.part[..] else { panic!("two parts") };
    assert_eq!((plate.name.as_str(), plate.thickness), ("plate", 1.0));
    assert_eq!(plate.element.as_deref(), Some("stabilised_quad"));
    assert_eq!(cube.element.as_deref(), Some("hexahedron"));
    let said = said(&model);
    assert!(said.contains("Ishell 24") && said.contains("hourglass assumed_strain"), "{said}");
    let start = &model.job.initial_velocity[0];
    assert_eq!((start.velocity, start.nodes.as_deref()), ([1.0, 0.0, 0.0], Some("set-900")));
}

#[test]
fn plastic_laws_keep_their_numbers() {
    let head = "=m\nr7.85e-6\nr200.0 r0.3";
    let linear = of_law(&format!("/MAT/LAW2/1\n{head}\nr0.3 r0.5 r1 r0.2\n_\n_"));
    assert_eq!(linear.job.material[0].law, "j2");
    assert_eq!(
        ["yield_stress", "hardening_modulus", "failure_strain"].map(|k| number(&linear, k)),
        [0.3, 0.5, 0.2]
    );
    let cook = of_law(&format!(
        "/MAT/PLAS_JOHNS/1\n{head}\nr0.3 r0.4 r0.5 r0.8\nr0.01 r1e-3\nr1.1 r1700 r3.6e-3 r293"
    ));
    assert_eq!(cook.job.material[0].law, "johnson_cook");
    assert_eq!(
        ["a", "b", "n", "c", "reference_rate"].map(|k| number(&cook, k)),
        [0.3, 0.4, 0.5, 0.01, 1e-3]
    );
    assert_eq!(number(&cook, "specific_heat"), 3.6e-3 / 7.85e-6, "per mass, not per volume");
    assert_eq!(number(&cook, "taylor_quinney"), 1.0, "all plastic work is heat");
    assert_eq!(value(&cook, "damage").as_array().unwrap()[0].as_float(), Some(0.8));
    let fails = of_law(&format!(
        "/MAT/LAW2/1\n{head}\nr0.3 r0.4 r0.5\n_\n_\n/FAIL/JOHNSON/1\nr0.1 r1.2 r-2 r0.01 r0\nr1e-3"
    ));
    assert_eq!(value(&fails, "damage").as_array().unwrap()[1].as_float(), Some(1.2));
    assert_eq!(number(&fails, "reference_rate"), 1e-3);
    let cowper = of_law(&format!("/MAT/COWPER/1\n{head}\nr0.3 r0.5 r1\nr40 r5\nr0.7"));
    assert_eq!(number(&cowper, "yield_stress"), 0.3);
    let pair = value(&cowper, "cowper_symonds").as_array().unwrap();
    assert_eq!((pair[0].as_float(), pair[1].as_float()), (Some(40.0), Some(5.0)));
    // A function is the yield stress itself; a largest stress ends it.
    let function = "/FUNCT/8\n=y\nr0 r300\nr0.1 r400\nr0.3 r500\n";
    let law = |limit: &str| {
        let power = format!("r0 r0 r1 r1 {limit}");
        let card = format!("/MAT/COWPER/1\n{head}\n{power}\nr40 r5\n_\ni8 _ r1e-3\n{function}");
        rows(&of_law(&card), "hardening")
    };
    let found = law("r0");
    for (row, wanted) in found.iter().zip([[0.0, 0.3], [0.1, 0.4], [0.3, 0.5]]) {
        assert!((0..2).all(|c| (row[c] - wanted[c]).abs() < 1e-15), "{found:?}");
    }
    let limited = law("r0.45");
    assert_eq!(limited.len(), 3, "{limited:?}");
    assert!((limited[2][0] - 0.2).abs() < 1e-12 && limited[2][1] == 0.45, "{limited:?}");
    let none = deck(&format!("/MAT/LAW44/1\n{head}\nr0 r0.5 r0.4"));
    let none = reading(&(mesh() + &properties() + &moves() + &none), &[]);
    assert!(none.err().is_some_and(|report| report.contains("`a` is blank or not above 0")));
    // A power law as straight lines: each point is on it.
    let power = rows(&of_law(&format!("/MAT/LAW44/1\n{head}\nr0.3 r0.5 r0.4")), "hardening");
    assert!(power.len() > 50 && power[0] == [0.0, 0.3]);
    let off = |p: &[f64; 2]| (p[1] - (0.3 + 0.5 * p[0].powf(0.4))).abs();
    assert!(power[1..].iter().all(|p| off(p) < 1e-15), "{power:?}");
}

/// Functions for several rates become a table by the rate; each continues with its last slope.
#[test]
fn functions_of_several_rates_are_a_table() {
    let functions = "/FUNCT/8\n=y\nr0 r300\nr0.1 r400\n/FUNCT/9\n=z\nr0 r150\nr0.1 r190\n";
    let law = |fcts: &str, rates: &str| {
        format!(
            "{functions}/MAT/LAW36/1\n=m\nr7.85e-6\nr200 r0.3\ni2\n_\n{fcts}\n\
             r1e-3 r2.5e-3\n{rates}"
        )
    };
    let found = of_law(&law("i8 i9", "r0 r0.5"));
    let table: Vec<Vec<f64>> = value(&found, "hardening_by_rate")
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row.as_array().unwrap().iter().map(|c| c.as_float().unwrap()).collect())
        .collect();
    let [first, second] = [0.0, 0.5].map(|rate| {
        table.iter().filter(|row| row[0] == rate).map(|row| [row[1], row[2]]).collect::<Vec<_>>()
    });
    for (rows, [start, end]) in [(first, [0.3, 0.4]), (second, [0.375, 0.475])] {
        for (row, wanted) in rows.iter().zip([[0.0, start], [0.1, end]]) {
            assert!((0..2).all(|c| (row[c] - wanted[c]).abs() < 1e-12), "{row:?}, {wanted:?}");
        }
        let slope = (rows[2][1] - rows[1][1]) / (rows[2][0] - rows[1][0]);
        assert!((slope - 1.0).abs() < 1e-9, "{rows:?}");
    }
    let text = mesh() + &properties() + &moves() + &deck(&law("i8", "r0"));
    let report = reading(&text, &[]).err().unwrap_or_else(|| panic!("one function of two"));
    assert!(report.contains("has 1 of 2 functions"), "{report}");
}

/// With a rate, `a + b eps^n` of Johnson and Cook is at most sigmax, and the rate scales both.
#[test]
fn a_largest_stress_with_a_rate_is_that_of_the_law() {
    let head = "=m\nr7.85e-6\nr200.0 r0.3";
    for (numbers, [a, b, largest]) in
        [("r0.3 r0.5 r0.4 r0 r0.6", [0.3, 0.5, 0.6]), ("r0.3 r0.5 r0.4 r0 r0.2", [0.2, 0.0, 0.2])]
    {
        let found = of_law(&format!("/MAT/LAW2/1\n{head}\n{numbers}\nr0.01 r1e-3 i1"));
        let material = &found.job.material[0];
        assert_eq!(material.law, "johnson_cook");
        for (key, wanted) in [("a", a), ("b", b), ("largest_stress", largest), ("c", 0.01)] {
            assert_eq!(material.parameters[key], toml::Value::from(wanted), "{key} of {numbers}");
        }
    }
}

/// A largest stress ends the hardening; with a rate the law of Cowper and Symonds alone has it.
#[test]
fn a_largest_stress_ends_the_hardening() {
    let head = "=m\nr7.85e-6\nr200.0 r0.3";
    for (law, more) in [("LAW2", ""), ("LAW44", "\nr40 r5")] {
        let numbers = "r0.3 r0.5 r0.4 r0 r0.6";
        let found = of_law(&format!("/MAT/{law}/1\n{head}\n{numbers}{more}"));
        assert_eq!(found.job.material[0].law, "j2", "{law}");
        let lines = rows(&found, "hardening");
        let (last, before) = (lines[lines.len() - 1], &lines[1..lines.len() - 1]);
        assert_eq!(last[1], 0.6);
        assert!((last[0] / (0.3f64 / 0.5).powf(2.5) - 1.0).abs() < 1e-12, "{law}: {last:?}");
        let off = |p: &[f64; 2]| (p[1] - (0.3 + 0.5 * p[0].powf(0.4))).abs();
        assert!(before.len() > 40 && before.iter().all(|p| off(p) < 1e-15), "{lines:?}");
    }
    let flat = of_law(&format!("/MAT/LAW2/1\n{head}\nr0.3 r0.5 r0.4 r0 r0.2"));
    assert_eq!(rows(&flat, "hardening"), [[0.0, 0.2]]);
    for (text, words) in [
        ("/MAT/LAW2/1\n{head}\nr0.3 r0.5 r0.4 r0 r0.6\nr0.01 r1e-3 i2", "`icc` = 2"),
        ("/MAT/LAW44/1\n{head}\nr0.3 r0.5 r0.4 r0 r0.6\nr40 r5 i2", "`icc` = 2"),
    ] {
        let text = mesh() + &properties() + &moves() + &deck(&text.replace("{head}", head));
        let report = reading(&text, &[]).err().unwrap_or_else(|| panic!("no errors: {words}"));
        assert!(report.contains(words), "{report}");
    }
}

/// Solids with the property of thick shells: points along s, from the first four nodes to the
/// others.
#[test]
fn thick_shells_have_their_points() {
    let block = deck("/PROP/SOLID/2\n=block\ni24");
    let of = |numbers: &str| {
        let thick = deck(&format!("/PROP/TYPE20/2\n=thick\n{numbers}"));
        mesh() + &properties().replace(&block, &thick) + &steel() + &moves()
    };
    assert!(properties().contains(&block));
    for (numbers, points) in
        [("i14", 2.0), ("i14 i0 _ _ i10 i252", 5.0), ("i15", 3.0), ("i15 i0 _ _ i0 i7", 7.0)]
    {
        let model = model(&of(numbers));
        let part = &model.job.part[1];
        assert_eq!(part.element.as_deref(), Some("thick_shell"), "{numbers}");
        assert_eq!(part.parameters["points"].number(), Some(points), "{numbers}");
    }
    let by_default =
        of("_").replace("/PROP/TYPE20", &format!("{}/PROP/TYPE20", deck("/DEF_SOLID\ni15")));
    assert_eq!(model(&by_default).job.part[1].parameters["points"].number(), Some(3.0));
    for (numbers, words) in [("i16", "`isolid` = 16"), ("i14 i0 _ _ i1", "`icstr` = 1")] {
        let report = reading(&of(numbers), &[]).err().unwrap_or_else(|| panic!("{words}"));
        assert!(report.contains(words), "{report}");
    }
}

/// A table of the yield stress is scaled and goes on with its last slope, as in Radioss.
#[test]
fn a_yield_table_continues_with_its_last_slope() {
    let law = "/FUNCT/9\n=y\nr0 r300\nr0.1 r400\n/MAT/LAW36/1\n=m\nr7.85e-6\nr200 r0.3 r0.6\ni1\n\
               _\ni9\nr1e-3\nr0";
    let model = of_law(law);
    let found = rows(&model, "hardening");
    assert_eq!(found[..2], [[0.0, 0.3], [0.1, 0.4]]);
    let slope = (found[2][1] - 0.4) / (found[2][0] - 0.1);
    // The differences of three decimal numbers.
    assert!((slope - 1.0).abs() < 1e-12 && found.len() == 3, "{found:?}");
    assert_eq!(number(&model, "failure_strain"), 0.6);
}

/// Nodes by ids, parts, boxes, ranges, groups, elements and general sets.
#[test]
fn groups_have_their_nodes() {
    let model = model(&with(
        "/GRNOD/NODE/1
        =some
        i11 i12 i13
        /GRNOD/PART/2
        =of plate
        i1
        /BOX/RECTA/1
        =low
        i0
        r-1 r-1 r-1
        r11 r1 r1
        /GRNOD/BOX/3
        =in box
        i1
        /GRNOD/GENE/4
        =range
        i3 i5
        /GRNOD/GRNOD/5
        =sum
        i1 i4 i-3
        /GRSHEL/SHEL/7
        =second
        i2
        /GRNOD/GRSHEL/6
        =of shell
        i7
        /SET/GENERAL/8
        =general
        wPART i1
        wNODE_D i13
        /SUBSET/3
        =none",
    ));
    assert_eq!(set(&model, "set-1"), [11, 12, 13]);
    assert_eq!(set(&model, "some"), [11, 12, 13], "under its title too");
    assert_eq!(set(&model, "set-2"), [11, 12, 13, 14, 15, 16]);
    assert_eq!(set(&model, "set-3"), [1, 2]);
    assert_eq!(set(&model, "set-4"), [3, 4, 5]);
    assert_eq!(set(&model, "set-5"), [3, 4, 5, 11, 12, 13]);
    assert_eq!(set(&model, "set-6"), [12, 13, 15, 16]);
    assert_eq!(set(&model, "set-8"), [11, 12, 14, 15, 16]);
}

/// Conditions on a main node act on its body, those on other nodes stay.
#[test]
fn a_main_node_stands_for_its_body() {
    let lines = "/NODE
        i90 r5 r5 r5
        /GRNOD/PART/2
        =cube nodes
        i2
        /GRNOD/NODE/3
        =main and corner
        i90 i11
        /RBODY/1
        =the cube
        i90 i0 i0 i0 r2.5 i2
        /FUNCT/1
        =one
        r0 r1
        r10 r1
        /IMPVEL/1
        =drive
        i1 wZ i0 i0 i3
        r0 r-2
        /IMPVEL/2
        =after the end of the run
        i1 wX i0 i0 i3
        r0 r-2 r10
        /CLOAD/1
        =pull
        i1 wY i0 i0 i3 _ r1 r0.25
        /TH/NODE/4
        =of the body
        wDEF
        i90 i0
        /TH/NODE/5
        =of both
        wDEF
        i90 i0
        i11 i0
        /BCS/1
        =held";
    let deck = with(lines) + "   110 001         0         3\n";
    let model = model(&deck);
    let body = &model.job.rigid[0];
    let [of_body, of_node] = [&body.load[0].force, &model.job.load[0].force];
    assert_eq!([of_body, of_node], [&[0.0, 0.25, 0.0]; 2], "on body and corner");
    let [history] = &model.job.output.node[..] else { panic!("one history") };
    let nodes = set(&model, history.nodes.as_deref().expect("a set"));
    assert_eq!((&*history.name, nodes), ("of both", vec![11]));
    assert!(said(&model).contains("/TH/NODE/4: node 90, the main node of a body"));
    let kept = deck.replace(&card("i90 i0 i0 i0 r2.5 i2"), &card("i90 i0 i0 i0 r2.5 i2 i0 i3"));
    let refused = reading(&kept, &[]).err().expect("a lever");
    assert!(refused.contains("not at the centre of the body"), "{refused}");
    let (before, after) = kept.split_once("/CLOAD/1").unwrap();
    let without = before.to_string() + &after[after.find("/TH/NODE/4").unwrap()..];
    assert!(said(&self::model(&without)).contains("it moves the centre of the cube, not its main"));
    assert_eq!((body.name.as_str(), &body.parts[..], &body.nodes), ("the cube", &[2][..], &None));
    assert_eq!(model.job.mass[0].mass, 2.5, "of the main node");
    assert_eq!(body.fixed, ["rz", "x", "y"]);
    assert_eq!(model.job.fix[0].dofs, ["x", "y", "rz"]);
    assert_eq!(set(&model, &model.job.fix[0].nodes), [11]);
    let [of_body, of_node] = &model.job.motion[..] else { panic!("two motions") };
    assert_eq!(of_body.rigid.as_deref(), Some("the cube"));
    assert_eq!(of_body.velocity, Some([0.0, 0.0, -2.0]));
    assert_eq!(set(&model, of_node.nodes.as_ref().unwrap()), [11]);
}

#[test]
fn walls_interfaces_and_ties_find_their_parts() {
    let lines = "/GRNOD/PART/2
        =cube nodes
        i2
        /GRNOD/NODE/4
        =rim
        i11 i14
        /SURF/PART/1
        =both
        i1 i2
        /SURF/SEG/2
        =top
        i1 i5 i6 i7 i8
        /RWALL/PLANE/1
        =floor
        i0 i2 i2
        r0 r0.2
        r0 r0 r-1
        r0 r0 r0
        /RWALL/SPHER/2
        =ball
        i0 i0
        r99 r0 r4.0
        r0 r0 r-9
        /INTER/TYPE24/1
        =all
        i1
        i0 _ _ i1
        _
        r0 r0.1 _ _ r0 r5
        _
        /INTER/TYPE7/2
        =plate on top
        i4 i2 i0 i0 i1000
        r0
        r0
        r1 r0.3 r0.5
        _
        i4
        r0.2 r3.0
        _
        /INTER/TYPE2/3
        =tied
        i4 i2 i0 i5 _ _ _ _ r3.0";
    let model = model(&with(lines));
    let [floor, ball] = &model.job.wall[..] else { panic!("two walls") };
    assert_eq!((floor.normal, floor.friction), (Some([0.0, 0.0, 1.0]), 0.2));
    assert_eq!(floor.nodes.as_deref(), Some("set-2"));
    assert_eq!((ball.radius, ball.friction, &ball.nodes), (Some(2.0), 0.0, &None));
    let contact = model.job.contact.as_ref().unwrap();
    assert_eq!(
        (&contact.parts[..], contact.friction, contact.death),
        (&[1, 2][..], 0.1, Some(5.0))
    );
    assert!(contact.edges, "Iedge 1");
    let pair = &contact.interface[0];
    assert_eq!((&pair.parts[..], &pair.against[..]), (&[1][..], &[2][..]));
    assert_eq!(
        (pair.friction, pair.friction_dynamic, pair.friction_decay),
        (Some(0.3), Some(0.2), Some(3.0))
    );
    assert_eq!(pair.thickness, Some(0.5), "a constant gap");
    let tie = &model.job.tie[0];
    assert_eq!((tie.tolerance, tie.rotations, tie.offset), (3.0, true, true));
    assert_eq!(set(&model, tie.faces.as_ref().unwrap()), [5, 6, 7, 8]);
}

/// Forces act on each node of a group; gravity and pressure on the model and on surfaces.
#[test]
fn loads_have_their_amounts() {
    let lines = "/FUNCT/1
        =ramp
        r0 r0
        r2 r1
        /GRNOD/NODE/1
        =two
        i11 i12
        /SURF/PART/1
        =plate
        i1
        /CLOAD/1
        =pull
        i1 wY i0 i0 i1 _ r1 r0.25
        /GRAV/1
        =fall
        i1 wZ i0 i0 i0 _ r1 r-9.81e-3
        /PLOAD/1
        =press
        i1 i1 i0 _ _ _ r2 r0.5
        /ADMAS/0/1
        =each
        r0.1 i1
        /ADMAS/5/2
        =single
        r0.3 i13
        /TH/NODE/1
        =watched
        wDEF
        i12 i0";
    let model = model(&with(lines));
    assert_eq!(model.job.load[0].force, [0.0, 0.5, 0.0], "0.25 on each of two nodes");
    assert_eq!(model.job.gravity[0].acceleration, [0.0, 0.0, -9.81e-3]);
    assert_eq!(
        (model.job.pressure[0].pressure, &model.job.pressure[0].parts[..]),
        (-0.5, &[1][..])
    );
    let curve = |name: &Option<String>| {
        let name = name.as_ref().unwrap();
        model.job.curve.iter().find(|c| c.name == *name).unwrap().points.clone()
    };
    // It goes on with its slope beyond the end of the run.
    assert_eq!(curve(&model.job.load[0].curve), [[0.0, 0.0], [2.0, 1.0], [1e4, 5e3]]);
    assert_eq!(curve(&model.job.pressure[0].curve), [[0.0, 0.0], [4.0, 1.0], [1e4, 2.5e3]]);
    let masses: Vec<f64> = model.job.mass.iter().map(|m| m.mass).collect();
    assert_eq!(masses, [0.2, 0.3]);
    assert_eq!(model.job.output.node[0].name, "watched");
}

/// Beams, trusses, springs, tetrahedra and wedges.
#[test]
fn other_elements_have_their_properties() {
    let lines = "/NODE
        i20 r0 r0 r30
        i21 r10 r0 r30
        i22 r20 r0 r30
        i23 r0 r10 r30
        i24 r0 r0 r40
        i25 r10 r0 r40
        i26 r0 r10 r40
        /BEAM/3
        i1 i20 i21 i23
        /TRUSS/4
        i1 i21 i22
        /SPRING/5
        i1 i22 i13
        /TETRA4/6
        i5 i20 i23 i21 i24
        /PENTA6/7
        i6 i20 i21 i23 i24 i25 i26
        /PART/3
        =beam
        i3 i1
        /PART/4
        =truss
        i4 i1
        /PART/5
        =spring
        i5 i0
        /PART/6
        =tet
        i6 i1
        /PART/7
        =wedge
        i6 i1
        /PROP/BEAM/3
        =b
        _
        r0 r0
        r4 r2 r1 r3
        /PROP/TRUSS/4
        =t
        r2.5
        /PROP/SPRING/5
        =s
        r0.4
        r1.5 r0.2
        _
        _
        /PROP/SOLID/6
        =v
        i1 i0 _ i0 i0 i0 i3";
    let model = model(&with(lines));
    let part = |name: &str| model.job.part.iter().find(|p| p.name == name).unwrap();
    let beam = part("beam").beam.as_ref().unwrap();
    assert_eq!((beam.area, beam.second_moments, beam.torsion), (4.0, [2.0, 1.0], 3.0));
    assert_eq!(part("truss").truss.as_ref().unwrap().area, 2.5);
    let spring = part("spring").spring.as_ref().unwrap();
    assert_eq!((spring.stiffness, spring.damping), (1.5, 0.2));
    assert_eq!(model.job.mass[0].mass, 0.4, "half on each end");
    let count = |shape| model.mesh.elements.iter().filter(|e| e.shape == shape).count();
    for shape in [Shape::Beam2, Shape::Truss2, Shape::Line2, Shape::Tet4, Shape::Wedge6] {
        assert_eq!(count(shape), 1, "{shape:?}");
    }
    assert!(said(&model).contains("negative volume"), "the tetrahedron is turned");
}

/// A smooth function is a curve with points on its steps.
#[test]
fn smooth_functions_are_curves() {
    let lines = "/FUNCT_SMOOTH/1
        =step
        r0 r0 r0 r1
        r0 r0
        r2 r8
        /GRNOD/NODE/1
        =one
        i11
        /CLOAD/1
        =pull
        i1 wY i0 i0 i1 _ r1 r0.25";
    let points = model(&with(lines)).job.curve[0].points.clone();
    let at = |t: f64| points.iter().find(|p| p[0] == t).map(|p| p[1]);
    assert_eq!([at(0.0), at(1.0), at(2.0), at(4.0)], [1.0, 5.0, 9.0, 9.0].map(Some));
}

/// The keywords of the engine set the run.
#[test]
fn the_engine_file_sets_the_run() {
    let text = with("").replacen(
        "/END/ENGINE",
        "/TFILE\n0.25\n/ANIM/DT\n0.0 2.5\n/DT\n0.67 0\n/DT/NODA/CST\n0.5 1e-4\n/DTIX\n0, 0.125\n\
         /PRINT/-10\n/END/ENGINE",
        1,
    );
    // The line that ends the keywords of the engine may be left out.
    for text in [&text.replace("/END/ENGINE\n", ""), &text] {
        let model = model(text);
        assert_eq!(model.job.output.history_interval, 0.25);
        assert_eq!(model.job.output.field_interval, 2.5);
        let time = &model.job.time;
        assert_eq!((time.safety, time.mass_scaling_dt, time.dt_max), (0.5, 2e-4, 0.125));
    }
    let said = said(&model(&text));
    for part in ["/PRINT is not read", "the smallest, 0.5, for all", "without a limit"] {
        assert!(said.contains(part), "{part}\n{said}");
    }
}
