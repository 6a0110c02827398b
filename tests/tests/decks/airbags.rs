//! Airbags and fabric of decks: each card gives the gas, the vents and the law that it says. Units
//! mm, ms, kg, so kN, GPa and J.

use crate::base::model_of;
use crumple::input::job::{Model, read};
use crumple_proto::airbag::{BagLaw, GasLaw, VentFlow};
use crumple_tests::program::{crumple_with, run};
use crumple_worker::fem::materials::elastic_of;
use std::fmt::Write;
use std::fs;

/// A cube of six shells of fabric with the side 10, part 1, one of them with its normal inwards;
/// part set 7 and segment set 8 hold it.
const CUBE: &str = "*KEYWORD\n*CONTROL_TERMINATION\n0.5\n*PART\nbag\n1,1,1\n*SECTION_SHELL\n1,5\n\
    0.4\n*MAT_FABRIC\n1,0.9e-6,0.3,,,0.3\n0,0,0,1.0,,,,0.05\n*NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n\
    4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n8,0,10,10\n*ELEMENT_SHELL\n1,1,1,2,3,4\n\
    2,1,5,6,7,8\n3,1,1,2,6,5\n4,1,2,3,7,6\n5,1,3,4,8,7\n6,1,4,1,5,8\n*SET_PART_LIST\n7\n1\n\
    *SET_SEGMENT\n8\n1,2,3,4\n5,6,7,8\n1,2,6,5\n2,3,7,6\n3,4,8,7\n4,1,5,8\n\
    *DEFINE_CURVE\n21\n0.0,0.0\n0.1,1e-6\n1.0,1e-6\n*DEFINE_CURVE\n22\n0.0,500.0\n1.0,400.0\n\
    *DEFINE_CURVE\n23\n0.0,0.0\n1e-3,3.0\n";

fn gas(model: &Model) -> &GasLaw {
    match &model.settings.loads.airbags[0].law {
        BagLaw::Gas(gas) => gas,
        other => panic!("no gas: {other:?}"),
    }
}

/// All fields of a bag by Wang and Nefske: the gas at the start, its inflow by curves, an orifice
/// that pops open, leakage, and a rate of exit. Segments give the same surface as parts.
#[test]
fn a_bag_of_wang_and_nefske() {
    let card = |surface: &str| {
        format!(
            "{CUBE}*AIRBAG_WANG_NEFSKE_ID\n3,driver bag\n{surface}\n743.0,1040.0,0,22,21\n\
             0.7,0,,23,0.1,0,2.0\n1e-4,1.2e-9,1.0,23,1e-5,2e-5\n\n"
        )
    };
    let model = model_of(&card("7,1"));
    let bag = &model.settings.loads.airbags[0];
    assert_eq!((bag.name.as_str(), bag.faces.len(), bag.ambient_pressure), ("driver bag", 6, 1e-4));
    assert_eq!(bag.faces.iter().filter(|face| face.inwards).count(), 1, "the shell at z = 0");
    let gas = gas(&model);
    assert!((gas.pressure - 1.1e-4).abs() < 1e-18 && gas.cv == 743.0 && gas.cp == 1040.0);
    assert!((gas.temperature / (1e-4 / (297.0 * 1.2e-9)) - 1.0).abs() < 1e-12, "ambient density");
    let inflow = &gas.inflows[0];
    assert_eq!((inflow.rate, inflow.temperature, gas.inflows.len()), (1.0, 1.0, 1));
    let points = |curve: Option<usize>| model.settings.loads.curves[curve.unwrap()].clone();
    assert_eq!(points(inflow.curve)[1], [0.1, 1e-6]);
    assert_eq!(points(inflow.temperature_curve)[0], [0.0, 500.0]);
    let orifice = |k: usize| match &gas.vents[k].flow {
        VentFlow::Orifice { area, coefficient, .. } => (area.clone(), *coefficient),
        other => panic!("no orifice: {other:?}"),
    };
    assert_eq!(orifice(0), (vec![[0.0, 0.0], [1e-3, 3.0]], 0.7));
    assert_eq!((orifice(1), gas.vents[0].opening_pressure), ((vec![[0.0, 2.0]], 0.1), 2e-5));
    assert_eq!((gas.vents[1].opening_pressure, gas.vents.len()), (0.0, 3));
    assert!(matches!(&gas.vents[2].flow, VentFlow::Rate { points } if points.len() == 2));
    let by_segments = model_of(&card("8,0"));
    assert_eq!(by_segments.settings.loads.airbags[0].faces, bag.faces);
    assert!(!by_segments.job.airbag[0].normals_inwards);
    // Segments against all elements; the second bag of a name gets another one.
    let backwards = CUBE
        .replace("*SET_SEGMENT\n8\n1,2,3,4\n5,6,7,8\n", "*SET_SEGMENT\n8\n4,3,2,1\n8,7,6,5\n")
        .replace(
            "1,2,6,5\n2,3,7,6\n3,4,8,7\n4,1,5,8\n*DEF",
            "5,6,2,1\n6,7,3,2\n7,8,4,3\n8,5,1,4\n*DEF",
        );
    let twice =
        model_of(&card("8,0").replace(CUBE, &backwards).replace(
            "*AIRBAG",
            "*AIRBAG_SIMPLE_PRESSURE_VOLUME_ID\n3,driver bag\n8,0\n2e-4\n*AIRBAG",
        ));
    let names: Vec<&str> = twice.job.airbag.iter().map(|bag| bag.name.as_str()).collect();
    assert_eq!(names, ["driver bag", "driver bag-2"]);
    assert!(twice.job.airbag.iter().all(|bag| bag.normals_inwards));
    assert_eq!(twice.settings.loads.airbags[0].faces, bag.faces, "the volume decides");
}

/// The other bags: by volume, of constant mass, and the simple bag per mass and per mole.
#[test]
fn simple_bags() {
    let law = |card: &str| model_of(&format!("{CUBE}{card}")).settings.loads.airbags[0].clone();
    let by_volume = law("*AIRBAG_SIMPLE_PRESSURE_VOLUME\n7,1\n2e-4,3.0\n");
    assert_eq!(by_volume.law, BagLaw::Inverse { pressure: 3.0 * 2e-4, curve: None });
    // The number at the end of a name has no meaning.
    let numbered = model_of(&format!("{CUBE}*AIRBAG_SIMPLE_PRESSURE_VOLUME_1\n7,1\n2e-4,3.0\n"));
    assert_eq!(numbered.settings.loads.airbags, [by_volume]);
    assert!(numbered.mapping.iter().any(|entry| entry.asked == "the number 1"));
    let table = law("*AIRBAG_SIMPLE_PRESSURE_VOLUME\n7,1\n,,23\n");
    assert_eq!(table.law, BagLaw::Table { points: vec![[0.0, 0.0], [1e-3, 3.0]] });
    let closed = law("*AIRBAG_ADIABATIC_GAS_MODEL\n7,1\n,,1.4,2e-4,1e-4,1e-9\n");
    let BagLaw::Gas(gas) = &closed.law else { panic!("no gas") };
    assert!((gas.cp / gas.cv - 1.4).abs() < 1e-14 && gas.pressure == 2e-4);
    assert_eq!((closed.ambient_pressure, gas.vents.len()), (1e-4, 0));
    let simple = |numbers: &str| law(&format!("*AIRBAG_SIMPLE_AIRBAG_MODEL\n7,1\n{numbers}"));
    let by_mass = simple("743.0,1040.0,500.0,21,0.6,5.0,1e-4,1.2e-9\n23\n");
    let BagLaw::Gas(gas) = &by_mass.law else { panic!("no gas") };
    assert_eq!((gas.inflows[0].temperature, gas.vents.len()), (500.0, 2));
    let by_mole = simple("0.0,0.0,500.0,21,0.6,-23,1e-4\n0,293.0,29.12,0.0,0.028,8.314\n");
    let BagLaw::Gas(gas) = &by_mole.law else { panic!("no gas") };
    assert!((gas.cp - 1040.0).abs() < 1e-9 && (gas.cp - gas.cv - 8.314 / 0.028).abs() < 1e-9);
    assert_eq!((gas.temperature, gas.pressure), (293.0, 1e-4));
    // The ambient temperature of a gas by mole, and that of the gas at the start, which is first.
    let by_mole = |iabt: &str| {
        let start = format!("0.0,0.0,500,0,21,0,0{iabt}\n\n1e-4\n\n293.0,29.12,0.0,0.028,8.314\n");
        match law(&format!("*AIRBAG_WANG_NEFSKE\n7,1\n{start}")).law {
            BagLaw::Gas(gas) => gas.temperature,
            other => panic!("no gas: {other:?}"),
        }
    };
    assert_eq!([by_mole(""), by_mole(",310.0")], [293.0, 310.0]);
    let VentFlow::Orifice { area, .. } = &gas.vents[0].flow else { panic!("no orifice") };
    assert_eq!(area[1], [1e-3, 3.0]);
}

/// Fields that a bag cannot have are refused with their values.
#[test]
fn fields_of_bags_without_a_counterpart() {
    let refused = |card: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deck.k");
        fs::write(&path, format!("{CUBE}{card}*END\n")).unwrap();
        read(&path, &[]).err().unwrap_or_else(|| panic!("it passes: {card}")).to_string()
    };
    let simple = "743.0,1040.0,500.0,21,0.6,5.0,1e-4,1.2e-9\n";
    for (head, field) in [
        ("7,1,5", "`rbid` = 5"),
        ("7,1,0,2.0", "`vsca` = 2"),
        ("7,1,0,1.0,1.0,3.0", "`vini` = 3"),
        ("7,1,0,,,,,0.5", "`spsf` = 0.5"),
    ] {
        let report = refused(&format!("*AIRBAG_SIMPLE_AIRBAG_MODEL\n{head}\n{simple}"));
        assert!(report.contains(field), "missing: {field}\n{report}");
    }
    for (card, text) in [
        ("*AIRBAG_SIMPLE_AIRBAG_MODEL\n9,1\n743.0,1040.0\n", "no *SET_PART_... with the id 9"),
        ("*AIRBAG_SIMPLE_AIRBAG_MODEL\n7,1\n1040.0,743.0\n", "cp has to be larger than cv"),
        ("*AIRBAG_SIMPLE_AIRBAG_MODEL\n7,1\n\n", "neither cv nor mw"),
        ("*AIRBAG_WANG_NEFSKE\n7,1\n743.0,1040.0,500,0,21,9.0\n\n1e-4,1e-9\n\n", "`tvol` = 9"),
        ("*AIRBAG_WANG_NEFSKE\n7,1\n743.0,1040.0,500,0,21\n\n1e-4,1e-9\n\n0.5\n", "`tdp` = 0.5"),
        (
            "*AIRBAG_WANG_NEFSKE\n7,1\n743.0,1040.0,0,22,21\n\n1e-4\n\n",
            "no temperature at the start",
        ),
        ("*AIRBAG_ADIABATIC_GAS_MODEL\n7,1\n,,0.9,2e-4\n", "gamma is 0.9"),
        ("*AIRBAG_HYBRID\n7,1\n", "*AIRBAG_HYBRID"),
    ] {
        let report = refused(card);
        assert!(report.contains(text), "missing: {text}\n{report}");
    }
    // Without one of its sides the bag is open.
    let open = CUBE.replace("6,1,4,1,5,8\n", "");
    let report = refused_text(&format!("{open}*AIRBAG_SIMPLE_AIRBAG_MODEL\n7,1\n{simple}"));
    assert!(
        report.contains("4 of its edges are open") && report.contains("4-1")
            || report.contains("1-4"),
        "{report}"
    );
}

fn refused_text(deck: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    // The segments name the missing side too.
    let deck = deck.replace("4,1,5,8\n", "");
    fs::write(&path, format!("{deck}*END\n")).unwrap();
    read(&path, &[]).err().expect("an open bag").to_string()
}

/// The bag of a deck runs: its gas fills it, and the deck that is written from it gives the same
/// bits.
#[test]
fn a_bag_of_a_deck_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (deck, out) = (folder.path().join("bag.k"), folder.path().join("out"));
    let fabric = "*MAT_FABRIC\n1,0.9e-6,0.3,,,0.3\n0,0,0,1.0,,,,0.05\n";
    // Fabric has no card in decks that are written.
    let mut text = CUBE.replace(fabric, "*MAT_ELASTIC\n1,0.9e-6,0.3,0.3\n");
    writeln!(
        text,
        "*AIRBAG_SIMPLE_AIRBAG_MODEL\n7,1\n743.0,1040.0,500.0,21,0.6,5.0,1e-4,1.2e-9\n*END"
    )
    .unwrap();
    fs::write(&deck, text).unwrap();
    let path = |path: &std::path::Path| path.to_str().unwrap().to_string();
    let digest_of = |deck: &std::path::Path, out: &std::path::Path| {
        let args =
            ["run", &path(deck), "--out", &path(out), "--quiet", "--no-report", "--workers", "2"];
        run(crumple_with(&args)).with_code(0);
        let summary = fs::read_to_string(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        summary["state_digest"].as_str().expect("a digest").to_owned()
    };
    let digest = digest_of(&deck, &out);
    let table = fs::read_to_string(out.join("airbags.csv")).unwrap();
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    let number = |column: usize| last[column].parse::<f64>().unwrap();
    assert_eq!(last[1], "airbag-7");
    assert!(number(2) > 1000.0 && number(3) > 1e-4, "it grows: {table}");
    assert!((number(7) / 4.5e-7 - 1.0).abs() < 0.05, "mass in: {}", number(7));
    let said = run(crumple_with(&["export-binout", &path(&out)])).with_code(0).said();
    assert!(said.contains("abstat in "), "{said}");
    let again = folder.path().join("again.k");
    let args = ["export-deck", &path(&deck), "--out", &path(&again)];
    run(crumple_with(&args)).with_code(0);
    assert_eq!(digest_of(&again, &folder.path().join("again")), digest);
}

/// A fabric with yarns: both moduli, the shear modulus, the direction, and no compression; a liner.
#[test]
fn fabric_with_yarns_and_liner() {
    let card = "*MAT_FABRIC\n1,0.9e-6,0.3,0.2,,0.1\n0.02,0,0,1.0,0.05,0.3,0.1,0.05\n\
                2.0\n,,,0,0,1\n,,,,,,30.0\n";
    let text = CUBE.replace("*MAT_FABRIC\n1,0.9e-6,0.3,,,0.3\n0,0,0,1.0,,,,0.05\n", card);
    let model = model_of(&format!("{text}*INITIAL_VELOCITY\n0\n1.0\n"));
    let of = |key: &str| model.job.material[0].parameters.get(key).map(|v| v.to_string());
    for (key, value) in [
        ("youngs_modulus", "0.3"),
        ("youngs_modulus_b", "0.2"),
        ("poisson", "0.1"),
        ("shear_modulus", "0.02"),
        ("direction", "[0.0, 0.0, 1.0]"),
        ("liner_fraction", "0.1"),
        ("liner_youngs_modulus", "0.05"),
        ("damping", "0.05"),
    ] {
        assert_eq!(of(key).as_deref(), Some(value), "{key}");
    }
    assert_eq!(of("compression"), None, "cse 1");
    assert!(elastic_of(&model.settings.materials[0]).is_ok());
    let part = &model.job.part[0];
    assert_eq!(part.element.as_deref(), Some("belytschko_tsay"));
    assert!(part.parameters.contains_key("membrane"), "elform 5");
}

/// A pressure over time acts along the normals of shells or segments, without a gas.
#[test]
fn a_bag_with_a_pressure_over_time() {
    let card = |surface: &str| model_of(&format!("{CUBE}*AIRBAG_LOAD_CURVE\n{surface}\n0.0,21\n"));
    let of_parts = card("7,1");
    let [load] = &of_parts.settings.loads.pressures[..] else { panic!("one pressure") };
    assert_eq!((load.pressure, load.faces.len(), load.curve.is_some()), (-1.0, 6, true));
    assert!(of_parts.job.airbag.is_empty());
    // The shell at z = 0 has the other sense than its segment in this set.
    let backwards = CUBE.replace("8\n1,2,3,4\n", "8\n4,3,2,1\n");
    let model = model_of(&format!("{backwards}*AIRBAG_LOAD_CURVE\n8,0\n0.0,21\n"));
    let faces = |sign: f64| {
        let of = model.settings.loads.pressures.iter().filter(|p| p.pressure == sign);
        of.map(|p| p.faces.len()).sum::<usize>()
    };
    assert_eq!((faces(-1.0), faces(1.0)), (5, 1));
}
