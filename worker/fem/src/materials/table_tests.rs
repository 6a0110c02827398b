//! Checks that the tables of parameters list exactly the parameters that the laws read.

use super::{DefaultValue, ELASTIC, LAWS, Law, Points, SolidPoint, build, build_solid};
use crumple_proto::partition::{Material, Param};
use std::collections::BTreeMap;

/// Returns a material of this law with all required parameters, such that each omitted parameter
/// changes the result.
fn sample(law: &Law) -> Material {
    let number = |key: &str| match key {
        "youngs_modulus" | "melting_temperature" => 200.0,
        "poisson" | "n" => 0.3,
        "yield_stress" | "a" | "b" => 0.2,
        "reference_rate" | "m" => 1.0,
        "specific_heat" => 1e4,
        other => panic!("{}: add a value of {other} to the sample", law.name),
    };
    let rows = ELASTIC.iter().chain(law.parameters);
    let wanted = rows.filter(|r| {
        matches!(r.otherwise, DefaultValue::Needed | DefaultValue::Depends(_)) || r.key == "m"
    });
    let parameters = wanted.map(|r| (r.key.to_string(), Param::Number(number(r.key)))).collect();
    Material { name: "sample".into(), law: law.name.into(), density: 7.85e-6, parameters }
}

/// Returns the keys that a law reads; it lists them in the error for an unknown key.
fn read_by(law: &Law, of: fn(&Material) -> String) -> Vec<String> {
    let parameters = BTreeMap::from([("no such key".to_string(), Param::Number(1.0))]);
    let help = of(&Material { name: "m".into(), law: law.name.into(), density: 1.0, parameters });
    let (_, list) =
        help.split_once("known: ").expect("the error of an unknown key lists the known ones");
    let mut keys: Vec<String> = list.split(", ").map(String::from).collect();
    keys.sort();
    keys
}

fn last_help(problems: Option<Vec<crumple_proto::problem::Problem>>) -> String {
    problems.expect("the material has problems").pop().expect("a problem").help
}

#[test]
fn the_tables_name_what_laws_read() {
    for law in LAWS.iter() {
        let mut listed: Vec<String> =
            ELASTIC.iter().chain(law.parameters).map(|r| r.key.to_string()).collect();
        listed.sort();
        assert_eq!(listed, read_by(law, |m| last_help(build(m).err())), "{}", law.name);
        assert_eq!(
            listed,
            read_by(law, |m| last_help(build_solid(m).err())),
            "{} of solids",
            law.name
        );
        assert!(
            law.parameters.iter().all(|r| r.meaning.ends_with('.')) && law.meaning.ends_with('.')
        );
    }
}

/// Required parameters cannot be omitted; all others can.
#[test]
fn the_tables_say_what_may_be_left_out() {
    for law in LAWS.iter() {
        let sample = sample(law);
        assert!(build(&sample).is_ok(), "{}", law.name);
        for row in
            ELASTIC.iter().chain(law.parameters).filter(|r| sample.parameters.contains_key(r.key))
        {
            let mut less = sample.clone();
            less.parameters.remove(row.key);
            // The sample has neither `c` nor `damage`, so it needs no reference rate. Without `m`
            // it needs none of the thermal parameters.
            let free = matches!(row.key, "reference_rate" | "m");
            assert_eq!(build(&less).is_ok(), free, "{} without {}", law.name, row.key);
        }
    }
}

/// Returns the stress after some steps with plastic flow, in plane stress and in three
/// dimensions.
fn stress(material: &Material) -> [f64; 9] {
    let law = build(material).expect("a valid material");
    let mut state = vec![0.0; 3 + law.history().len()];
    let solid = build_solid(material).expect("a valid material");
    let mut solid_state = vec![0.0; 6 + solid.history().len()];
    for _ in 0..20 {
        let strain = [[1e-3, -3e-4, 2e-4]];
        law.update_one(
            Points { state: &mut state, strain: &strain, thickness_strain: &mut [0.0] },
            1e-3,
        );
        let strain = [1e-3, -3e-4, -2e-4, 2e-4, 0.0, 1e-4];
        solid.update_one(SolidPoint { state: &mut solid_state, strain: &strain }, 1e-3);
    }
    std::array::from_fn(|i| if i < 3 { state[i] } else { solid_state[i - 3] })
}

/// A number that is not given has the value of the table: the same bits.
#[test]
fn the_tables_give_the_defaults() {
    for law in LAWS.iter() {
        let sample = sample(law);
        for row in law.parameters {
            let DefaultValue::Number(default) = row.otherwise else { continue };
            let with = |value: f64| {
                let mut material = sample.clone();
                material.parameters.insert(row.key.into(), Param::Number(value));
                stress(&material)
            };
            assert_eq!(stress(&sample), with(default), "{}: {}", law.name, row.key);
            assert_ne!(
                stress(&sample),
                with(default + 0.05),
                "{}: {} makes no difference",
                law.name,
                row.key
            );
        }
    }
}
