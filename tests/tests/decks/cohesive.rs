//! Cohesive elements of decks: parameters, what is refused, written decks. Units mm, ms, kg, so kN
//! and GPa.

use crate::base::{BASE, MOVES, assert_refused, assert_same_when_written, model_of};
use crumple::input::job::Model;
use crumple_proto::mesh::Shape;

const STEEL: &str = "*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n";
const MIXED: &str = "*MAT_138\n3,1e-6,1,2,20.0,8.0,8e-4,2.4e-3\n-2.0,0.04,,,0.192,1.5\n";

const TH: &str = "*MAT_185\n3,1e-6,1,1,0.03,0.04,0.1\n0.2,1.2,2.0,5.0\n";

const FLOWS: &str = "*MAT_240\n3,1e-6,1,1,4.0,1.6,0.2\n8e-4,9.0,8.0,0.04,7.0,6.0,0.4\n\
                     2.4e-3,,,0.025,,,-0.5\n";

/// The base with a second cube on the first one, on nodes of its own, and a part 3 of one element
/// without thickness between them.
fn bonded(section: &str, material: &str) -> String {
    let more = "*PART\nbond\n3,3,3\n*NODE\n21,0,0,10\n22,10,0,10\n23,10,10,10\n24,0,10,10\n\
                25,0,0,20\n26,10,0,20\n27,10,10,20\n28,0,10,20\n\
                *ELEMENT_SOLID\n2,2,21,22,23,24,25,26,27,28\n3,3,5,6,7,8,21,22,23,24\n";
    // The plate of the base would be inside the second cube.
    let base = BASE.replace(",12\n", ",40\n");
    format!("{base}{STEEL}{MOVES}{more}*SECTION_SOLID\n3,{section}\n{material}")
}

fn parameter(model: &Model, key: &str) -> String {
    let bond = model.job.material.iter().find(|m| m.law.starts_with("cohesive")).expect("a bond");
    bond.parameters.get(key).map_or(String::new(), |value| value.to_string())
}

#[test]
fn fields_become_parameters() {
    let model = model_of(&bonded("19", MIXED));
    for (key, value) in [
        ("density_per_area", "true"),
        ("stiffness_normal", "20.0"),
        ("stiffness_shear", "8.0"),
        ("toughness_normal", "0.0008"),
        ("toughness_shear", "0.0024"),
        ("strength_normal", "0.04"),
        ("strength_shear", "0.024999999999999998"),
        ("benzeggagh_kenane", "2.0"),
        ("stiffness_exponent", "1.5"),
        ("power_exponent", ""),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    let part = model.job.part.iter().find(|p| p.id == 3).expect("the bond");
    assert_eq!(part.element.as_deref(), Some("cohesive"));
    let key = |key: &str| part.parameters[key].to_string();
    assert_eq!((key("integration"), key("failed_points")), ("gauss".into(), "2".into()));
    let cohesive = model.mesh.elements.iter().filter(|e| e.shape == Shape::Cohesive8).count();
    assert_eq!(cohesive, 1);
    let elastic = "*MAT_COHESIVE_ELASTIC\n3,1e-6,1,-3,8.0,20.0,0.04\n";
    let model = model_of(&bonded("19", elastic));
    for (key, value) in [
        ("stiffness_normal", "20.0"),
        ("stiffness_shear", "8.0"),
        ("strength_normal", "0.04"),
        ("strength_shear", ""),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    let part = model.job.part.iter().find(|p| p.id == 3).expect("the bond");
    let key = |key: &str| part.parameters[key].to_string();
    assert_eq!((key("integration"), key("failed_points")), ("nodes".into(), "3".into()));
}

#[test]
fn a_law_with_a_plateau_has_its_shares() {
    let model = model_of(&bonded("19", TH));
    for (key, value) in [
        ("density_per_area", "true"),
        ("strength", "0.03"),
        ("separation_normal", "0.04"),
        ("separation_shear", "0.1"),
        ("peak_share", "0.1"),
        ("softening_share", "0.6"),
        ("pressure_factor", "5.0"),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    // Those of shells have no effect, and a blank penetration stiffness lets the faces pass.
    let more = "*MAT_COHESIVE_TH\n3,1e-6,1,1,0.03,0.04,0.1,0.2\n0.2,1.2,2.0,,-1,1,1\n1.0,1.0\n";
    let model = model_of(&bonded("19", more));
    assert_eq!(parameter(&model, "pressure_factor"), "0.0");
    let warns = |words: &str| model.warnings.iter().any(|w| w.message.contains(words));
    assert!(warns("`stfsf` is blank or 0"), "{:?}", model.warnings);
}

#[test]
fn a_law_that_flows_has_stiffnesses_and_shares_of_work() {
    let model = model_of(&bonded("19", FLOWS));
    for (key, value) in [
        ("density_per_area", "true"),
        ("stiffness_normal", "20.0"),
        ("stiffness_shear", "8.0"),
        ("toughness_normal", "0.0008"),
        ("toughness_shear", "0.0024"),
        ("strength_normal", "0.04"),
        ("strength_shear", "0.025"),
        ("plateau_normal", "0.4"),
    ] {
        assert_eq!(parameter(&model, key), value, "{key}");
    }
    // Flow ends half of the way from yield to separation: there are openings u_1, u_2, u_f with
    // u_2 = (u_1 + u_f)/2 and the work S (u_f + u_2 - u_1)/2.
    let (yields, strength, work) = (0.025 / 8.0, 0.025, 2.4e-3);
    let share: f64 = parameter(&model, "plateau_shear").parse().unwrap();
    let softens = yields + share * work / strength;
    let ends = 2.0 * softens - yields;
    let wanted = 0.5 * strength * (ends + softens - yields);
    assert!((wanted / work - 1.0).abs() < 1e-12, "{share}: {wanted}");
}

#[test]
fn what_is_not_supported_is_refused() {
    let without = MIXED.replace(",0.192,", ",,");
    for (section, material, words) in [
        ("1", MIXED, &["its material is for cohesive elements only"][..]),
        ("20", MIXED, &["its material is for cohesive elements only"]),
        ("19", STEEL.replace("\n1,", "\n3,").as_str(), &["is not for cohesive elements"]),
        ("19", without.as_str(), &["neither `s` nor `utd` is given", "2 giic/utd"]),
        (
            "19",
            "*MAT_138\n3,1e-6,2,1,20.0,8.0,-8e-4,2.4e-3\n1.0,-4,0.02\n",
            &["`roflg` = 2", "`gic` = -0.0008"],
        ),
        (
            "19",
            "*MAT_138\n3,1e-6,1,7,20.0,8.0,8e-5,2.4e-3\n1.0,0.1,0.02\n",
            &["toughness_normal is 0.00008", "failed_points is 7"],
        ),
        (
            "19",
            "*MAT_138\n3,1e-6,,2.5,20.0,8.0,8e-4,2.4e-3\n1.0,0.04,0.02\n",
            &["`intfail` = 2.5 is not supported"],
        ),
        (
            "19",
            "*MAT_185\n3,1e-6,1,1,0.03,0.04,0.1\n0.2,1.2,-2.0,5.0\n",
            &["`lamdaf` is -2", "give it above 0, such as 1"],
        ),
        (
            "19",
            "*MAT_185\n3,1e-6,1,1,0.03,0.04,0.1\n0.2,0.1,2.0,-5.0\n",
            &["softening_share is 0.05", "pressure_factor is -5"],
        ),
        ("19", FLOWS.replace(",0.2\n", "\n").as_str(), &["`thick` is blank", "give the thickness"]),
        ("19", FLOWS.replace(",0.2\n", ",0.2,1\n").as_str(), &["`inicrt` = 1 is not supported"]),
        (
            "19",
            FLOWS.replace("8e-4,", "-8e-4,").as_str(),
            &["`g1c_0` = -0.0008 is not supported: there are no rates"],
        ),
        (
            "19",
            FLOWS.replace(",0.025,", ",-0.025,").as_str(),
            &["`s0` = -0.025 is not supported: there are no rates"],
        ),
        ("19", FLOWS.replace(",-0.5\n", ",-0.5,4\n").as_str(), &["lcg2c"]),
        ("19", FLOWS.replace(",-0.5\n", ",0.99\n").as_str(), &["plateau_shear is 0.99"]),
        (
            "19",
            "*MAT_138\n3,1e-6,0,1,20.0,8.0,8e-4,2.4e-3\n1.0,0.04,0.02\n",
            &["has no thickness, and so no mass", "density_per_area = true (roflg 1"],
        ),
    ] {
        assert_refused(&bonded(section, material), words);
    }
}

/// A written deck has the same digest as the one it was read from.
#[test]
fn a_written_deck_is_the_same_model() {
    let elastic = "*MAT_184\n3,1e-6,1,-3,8.0,20.0,0.04\n";
    let power = "*MAT_138\n3,1e-6,1,1,20.0,8.0,8e-4,2.4e-3\n1.5,0.04,0.02\n";
    // The upper cube lifts off.
    let nodes = (21..29).map(|node| format!("{node},0,0,1.0\n")).collect::<String>();
    let lift = format!("*INITIAL_VELOCITY_NODE\n{nodes}");
    for material in [MIXED, power, elastic, TH, FLOWS] {
        let text = bonded("19", material).replace(MOVES, "");
        let words = "*MAT_COHESIVE_";
        assert_same_when_written(&format!("{text}{lift}"), "time.max_cycles=200", words);
    }
}
