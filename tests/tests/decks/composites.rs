//! Composites in decks: plies, layers, angles; what is refused; written decks. Units mm, ms, kg, so
//! kN, GPa and J.

use crate::base::{BASE, MOVES, model_of};
use crumple::input::job::Model;
use crumple_tests::program::{crumple_with, run};
use std::fs;

const PLY: &str = "*MAT_054\n1,1.58e-6,165.0,9.0,9.0,0.0185,0.0185,0.5\n5.6,2.8,5.6,0,2.0\n\
    0,0,0,1,0,0,15.0\n0,0,0,0,1,0,0.03,0.02\n0,2e-5,1.0,0.5,1.2,0.017,-0.013,0.55\n\
    1.59,2.56,0.185,0.073,0.09,54,0.5\n";
const STEEL: &str = "*MAT_024\n2,7.85e-6,207.0,0.3,0.25\n\n\n\n";

/// The plate of the base alone, as a part with layers.
fn composite(part: &str, materials: &str) -> String {
    let (from, to) = (BASE.find("*PART").unwrap(), BASE.find("*NODE").unwrap());
    let solid = BASE.find("*ELEMENT_SOLID").unwrap();
    format!("{}{part}{}{MOVES}{materials}", &BASE[..from], &BASE[to..solid])
}

const LAYERS: &str = "*PART_COMPOSITE\nplate\n1,16,,-1.0\n1,0.2,0.0,,1,0.2,90.0\n2,0.5\n";

fn parameter(model: &Model, key: &str) -> String {
    let ply = model.job.material.iter().find(|m| m.law == "orthotropic").expect("a ply");
    ply.parameters.get(key).map_or(String::new(), |value| value.to_string())
}

#[test]
fn plies_and_layers() {
    let model = model_of(&composite(LAYERS, &format!("{PLY}{STEEL}")));
    for (key, value) in [
        ("youngs_modulus", "165.0"),
        ("youngs_modulus_b", "9.0"),
        ("poisson", "0.0185"),
        ("shear_modulus", "5.6"),
        ("shear_modulus_bc", "2.8"),
        ("shear_modulus_ca", "5.6"),
        ("direction", "[1.0, 0.0, 0.0]"),
        ("angle", ""),
        ("strength_tension_a", "2.56"),
        ("strength_compression_a", "1.59"),
        ("strength_tension_b", "0.073"),
        ("strength_compression_b", "0.185"),
        ("strength_shear", "0.09"),
        ("shear_weight", "0.5"),
        ("shear_nonlinearity", "0.00002"),
        ("crushed_tension_a", "1.28"),
        ("crushed_compression_a", "0.222"),
        ("failure_strain_tension_a", "0.017"),
        ("failure_strain_compression_a", "0.013"),
        ("failure_strain_b", "0.03"),
        ("failure_strain_shear", "0.04"),
        ("failure_strain_effective", "0.55"),
        ("residual_strengths", ""),
        ("tsai_wu", ""),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    let part = &model.job.part[0];
    let layers: Vec<_> =
        part.layer.iter().map(|l| (l.material.as_str(), l.thickness, l.angle, l.points)).collect();
    assert_eq!(layers, [("mat-1", 0.2, 0.0, 1), ("mat-1", 0.2, 90.0, 1), ("mat-2", 0.5, 0.0, 1)]);
    assert!((part.thickness - 0.9).abs() < 1e-12 && part.offset == 1.0);
    assert_eq!(part.material, "mat-2", "that of the thickest layer");
    let long = LAYERS.replace("COMPOSITE", "COMPOSITE_LONG").replace(",,1,0.2,90", "\n1,0.2,90");
    let long = model_of(&composite(&long, &format!("{PLY}{STEEL}")));
    assert_eq!(long.job.part[0].layer, part.layer);
}

/// Tsai-Wu, residual strengths, and the axis a across a vector; an elastic ply.
#[test]
fn other_options_of_plies() {
    let text = "*MAT_055\n1,1.58e-6,165.0,9.0,9.0,0.0185\n5.6,2.8,5.6,0,3.0\n0,0,0,0,0,0,30.0\n\
                0,1,0\n0,0,0,0,1.2,0.017,-0.013\n1.59,2.56,0.185,0.073,0.09,55,0.5\n\n\
                0.01,0.375,0.1,1.0,1.0\n";
    let model = model_of(&composite("*PART_COMPOSITE\nplate\n1,2\n1,0.2\n", text));
    for (key, value) in [
        ("tsai_wu", "true"),
        ("shear_weight", "0.5"),
        ("failure_strain_tension_a", ""),
        ("residual_strengths", "[0.01, 0.375, 0.1, 1.0, 1.0]"),
        ("direction", "[0.0, 1.0, 0.0]"),
        ("angle", "-60.0"),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    let elastic = "*MAT_ORTHOTROPIC_ELASTIC\n1,1.58e-6,165.0,9.0,9.0,0.0185\n5.6,2.8,5.6,0\n\n\
                   0,0,0,0,0,0,45.0\n";
    let model = model_of(&composite("*PART_COMPOSITE\nplate\n1,2\n1,0.2\n", elastic));
    assert_eq!(
        (parameter(&model, "angle"), parameter(&model, "strength_shear")),
        ("45.0".into(), String::new())
    );
    // The angle of a shell replaces that of the material.
    let turned = composite("*PART_COMPOSITE\nplate\n1,2\n1,0.2\n", elastic)
        .replace("*ELEMENT_SHELL\n", "*ELEMENT_SHELL_BETA\n")
        .replace("1,1,11,12,15,14\n", "1,1,11,12,15,14\n,,,,20.0\n")
        .replace("2,1,12,13,16,15\n", "2,1,12,13,16,15\n\n");
    let angles: Vec<f64> = model_of(&turned).mesh.elements.iter().map(|e| e.own.angle).collect();
    assert_eq!(angles, [-25.0, 0.0]);
}

/// Angles of the points of a section, and of single shells.
#[test]
fn angles_of_points_and_shells() {
    let text = format!("{BASE}{MOVES}{PLY}")
        .replace("1,2,1.0,3\n1.0\n", "1,2,1.0,3,,,1\n1.0\n0.0,45.0,90.0\n")
        .replace("cube\n2,2,1\n", "cube\n2,2,2\n")
        .replace("*ELEMENT_SHELL\n", "*ELEMENT_SHELL_BETA\n")
        .replace("1,1,11,12,15,14\n", "1,1,11,12,15,14\n,,,,20.0\n")
        .replace("2,1,12,13,16,15\n", "2,1,12,13,16,15\n,,,,-5.0\n");
    let model = model_of(&format!("{text}{STEEL}"));
    assert_eq!(model.job.part[0].angles, [0.0, 45.0, 90.0]);
    let angles: Vec<f64> = model.mesh.elements.iter().take(2).map(|e| e.own.angle).collect();
    assert_eq!(angles, [20.0, -5.0]);
}

/// A ply that loses the stress of what has failed has the energy of its shear in the criteria.
#[test]
fn brittle_plies() {
    let card = "*MAT_022\n1,1.6e-6,165.0,9.0,,0.0185\n5.6,3.2,5.6,,2\n,,,1.0,0,0\n\n\
                0.09,2.56,0.073,0.185,2e-5\n*MAT_003\n7,7.85e-6,200.0,0.3,0.25\n";
    let model = model_of(&format!("{BASE}{MOVES}{card}").replace("2,2,1\n", "2,2,7\n"));
    let ply = &model.settings.materials[0];
    assert_eq!(ply.law, "orthotropic");
    for (key, value) in [
        ("strength_tension_a", 2.56),
        ("strength_tension_b", 0.073),
        ("strength_compression_b", 0.185),
        ("strength_shear", 0.09),
        ("shear_nonlinearity", 2e-5),
        ("shear_weight", 1.0),
    ] {
        assert_eq!(crate::base::number(ply, key), value, "{key}");
    }
    assert_eq!(crate::base::list(ply, "residual_strengths"), [0.0; 5]);
    assert_eq!(crate::base::list(ply, "direction"), [1.0, 0.0, 0.0]);
    assert!(ply.parameters.contains_key("shear_energy"));
    assert!(!ply.parameters.contains_key("strength_compression_a"));
    let text = format!("{BASE}{MOVES}{card}");
    crate::base::assert_refused(&text, &["orthotropic' is for shells only"]);
}

#[test]
fn what_plies_and_layers_do_not_have_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let ply = format!("{PLY}{STEEL}");
    for (text, words) in [
        (composite(LAYERS, &ply.replace("2e-5,1.0", "2e-5,0.6")), "`soft` = 0.6"),
        (composite(LAYERS, &ply.replace("5.6,0,2.0", "5.6,0,4.0")), "use aopt 0, 2 or 3"),
        (composite(LAYERS, &ply.replace(",5.6,0,2.0", ",5.6,0,2.0,1.0")), "2way"),
        (composite(&LAYERS.replace("2,0.5", "7,0.5"), &ply), "there is no *MAT_... with the id 7"),
        (composite(&LAYERS.replace("2,0.5", "2,-0.5"), &ply), "layer 3 has the thickness -0.5"),
        (composite(&LAYERS.replace("1,16,", "1,5,"), &ply), "a membrane has one point"),
        (composite(&format!("{LAYERS}{}", "1,0.1\n".repeat(38)), &ply), "have 41 points"),
    ] {
        fs::write(&path, format!("{text}*END\n")).unwrap();
        let said = run(crumple_with(&["check", path.to_str().unwrap()])).with_code(2).said();
        assert!(said.contains(words), "{words}: {said}");
        assert!(said.contains("deck.k:"), "{said}");
    }
}

/// A deck that is written has the cards of the format, and gives the same bits.
#[test]
fn a_written_composite_gives_the_same_digest() {
    let folder = tempfile::tempdir().unwrap();
    let [deck, again] = ["deck.k", "again.k"].map(|name| folder.path().join(name));
    let [deck_text, again_text] = [&deck, &again].map(|path| path.to_str().unwrap());
    let text = composite(LAYERS, &format!("{PLY}{STEEL}"))
        .replace("*ELEMENT_SHELL\n", "*ELEMENT_SHELL_BETA\n")
        .replace("1,1,11,12,15,14\n", "1,1,11,12,15,14\n,,,,20.0\n")
        .replace("2,1,12,13,16,15\n", "2,1,12,13,16,15\n\n")
        .replace("*INITIAL_VELOCITY\n0\n1.0\n", "*INITIAL_VELOCITY_NODE\n13,20.0,5.0,3.0\n");
    fs::write(&deck, format!("{text}*END\n")).unwrap();
    let digest_after = |cycles: usize, path: &str| {
        let cycles = format!("time.max_cycles={cycles}");
        let few = ["run", path, "--set", &cycles, "--set", "output.field_interval=-1"];
        run(crumple_with(&few)).with_code(0).digest()
    };
    let digest = |path: &str| digest_after(200, path);
    run(crumple_with(&["export-deck", deck_text, "--out", again_text])).with_code(0);
    let written = fs::read_to_string(&again).unwrap();
    for card in ["*PART_COMPOSITE_LONG", "*MAT_ENHANCED_COMPOSITE_DAMAGE_TITLE", "_BETA"] {
        assert!(written.contains(card), "{card}: {written}");
    }
    assert_eq!(digest(deck_text), digest(again_text));
    // A job whose plies do not lose strength when their matrix is crushed.
    let job = "cases/composite-tube";
    run(crumple_with(&["export-deck", job, "--out", again_text, "--overwrite"])).with_code(0);
    assert_eq!(digest_after(1500, job), digest_after(1500, again_text));
}
