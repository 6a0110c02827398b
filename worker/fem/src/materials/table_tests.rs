//! Checks that the tables of parameters list exactly the parameters that the laws read.

use super::{
    CohesivePoint, DefaultValue, LAWS, Law, Points, SolidPoint, build, build_cohesive, build_solid,
    elastic_of,
};
use crumple_proto::partition::{Material, Param};
use std::collections::BTreeMap;

/// Returns a material of this law with all required parameters, such that each omitted parameter
/// changes the result.
fn sample(law: &Law) -> Material {
    let number = |key: &str| match key {
        "youngs_modulus" | "melting_temperature" => 200.0,
        "poisson" => 0.45,
        "n" => 0.3,
        "yield_stress" | "a" | "b" => 0.2,
        "reference_rate" | "m" => 1.0,
        "specific_heat" => 1e4,
        "long_term_shear_modulus" | "decay_rate" | "shear_modulus" => 10.0,
        "compressive_strength" => 0.05,
        "tensile_strength" => 10.0,
        "youngs_modulus_b" | "bulk_modulus" => 100.0,
        "shape" => 2.0,
        "compacted_volume" => 0.3,
        "viscous_coefficient" => 0.1,
        "viscous_modulus" => 100.0,
        "stiffness_normal" => 20.0,
        "stiffness_shear" => 8.0,
        "strength" | "strength_normal" | "strength_shear" => 0.03,
        "separation_normal" | "separation_shear" => 0.05,
        "peak_share" => 0.2,
        "softening_share" => 0.5,
        "toughness_normal" => 1e-3,
        "toughness_shear" => 3e-3,
        "tension_energy" | "shear_energy" => 1e-4,
        "compression_energy" => 1e-2,
        other => panic!("{}: add a value of {other} to the sample", law.name),
    };
    let value = |key: &str| match key {
        "pressure" if law.name == "soil" => Param::Table(vec![vec![0.0, 0.0], vec![0.5, 5.0]]),
        "pressure" => Param::List(vec![80.0, 0.0, 0.0]),
        "intact_strength" => Param::List(vec![0.01, 0.6]),
        "hugoniot_elastic_limit" => Param::List(vec![3.0, 1.0]),
        "strength_constants" => Param::List(vec![0.8, 1.6, 0.6]),
        "crushing_point" => Param::List(vec![1e-4, 2e-3]),
        "locking_point" => Param::List(vec![0.1, 0.8]),
        "largest_surface" => Param::List(vec![40.0, 0.45, 1e-3]),
        "yield_surface" => Param::List(vec![20.0, 0.6, 3e-3]),
        "residual_surface" => Param::List(vec![0.45, 1e-3]),
        "damage_curve" => Param::Table(vec![vec![0.0, 0.0], vec![1e-3, 1.0], vec![1e-2, 0.0]]),
        "damage_scaling" => Param::List(vec![1.6, 1.35, 1.15]),
        "compaction" => Param::Table(vec![vec![0.0, 0.0, 100.0], vec![0.1, 5.0, 120.0]]),
        "yield_constants" => Param::List(vec![1e-4, 0.0, 0.0]),
        "coefficients" => Param::List(vec![1.0, 0.5, 0.0, 0.0, 0.0, 0.0]),
        "terms" => Param::Table(vec![vec![1.0, 2.0]]),
        "tension" => Param::Table(vec![vec![0.0, 0.5], vec![0.1, 1.0]]),
        "shear_terms" => Param::Table(vec![vec![10.0, 0.0], vec![20.0, 5.0]]),
        "moduli" => Param::List(vec![20.0, 10.0, 10.0, 5.0, 5.0, 5.0]),
        "crush_a" => Param::Table(vec![vec![0.0, 0.01], vec![0.6, 0.02]]),
        "compression" => Param::Table(vec![vec![0.0, 0.0], vec![0.5, 0.1]]),
        "curve" => Param::Table(vec![vec![-0.1, -0.33], vec![0.0, 0.0], vec![0.1, 0.27]]),
        "shear_surface" => Param::List(vec![0.0145, 0.2965, 0.0105, 19.3]),
        "torsion" => Param::List(vec![0.747, 1.2, 0.17, 71.0]),
        "extension" => Param::List(vec![0.66, 1.4, 0.16, 72.0]),
        "cap" => Param::List(vec![5.0, 0.09, 0.05, 0.25, 0.349]),
        key => Param::Number(number(key)),
    };
    let rows = law.constants.iter().chain(law.parameters);
    let wanted = rows.filter(|r| {
        matches!(r.otherwise, DefaultValue::Needed | DefaultValue::Depends(_)) || r.key == "m"
    });
    let mut parameters: BTreeMap<_, _> =
        wanted.map(|r| (r.key.to_string(), value(r.key))).collect();
    if law.name == "fluid" {
        let water = Param::List(vec![2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        parameters.insert("eos_polynomial".into(), water);
    }
    // Without voids their parameters have no effect.
    if law.name == "gurson" {
        parameters.insert("nucleation".into(), Param::List(vec![0.1, 0.0, 0.1]));
    }
    // Bulking and the least strain need damage.
    if law.name.starts_with("johnson_holmquist") {
        parameters.insert("damage".into(), Param::List(vec![1e-5, 1.0]));
    }
    if law.name == "cscm" {
        for key in ["tension_rate", "compression_rate"] {
            parameters.insert(key.into(), Param::List(vec![1e-3, 0.5, 0.05]));
        }
    }
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

/// Returns true if shells can have this law.
fn has_shells(law: &Law) -> bool {
    law.build.is_some()
}

fn last_help(problems: Option<Vec<crumple_proto::problem::Problem>>) -> String {
    problems.expect("the material has problems").pop().expect("a problem").help
}

#[test]
fn the_tables_name_what_laws_read() {
    for law in LAWS.iter() {
        let mut listed: Vec<String> =
            law.constants.iter().chain(law.parameters).map(|r| r.key.to_string()).collect();
        listed.sort();
        if has_shells(law) {
            assert_eq!(listed, read_by(law, |m| last_help(build(m).err())), "{}", law.name);
        }
        if law.solid.is_some() {
            assert_eq!(
                listed,
                read_by(law, |m| last_help(build_solid(m).err())),
                "{} of solids",
                law.name
            );
        }
        if law.cohesive.is_some() {
            let read = read_by(law, |m| last_help(build_cohesive(m).err()));
            assert_eq!(listed, read, "{} of cohesive elements", law.name);
        }
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
        assert!(elastic_of(&sample).is_ok(), "{}", law.name);
        let rows = law.constants.iter().chain(law.parameters);
        for row in rows.filter(|r| sample.parameters.contains_key(r.key)) {
            let mut less = sample.clone();
            less.parameters.remove(row.key);
            // The sample has neither `c` nor `damage`, so it needs no reference rate. Without `m`
            // it needs none of the thermal parameters.
            // Each effect of the rate needs the other one.
            let free =
                matches!(row.key, "reference_rate" | "m" | "shape" | "nucleation" | "damage");
            assert_eq!(elastic_of(&less).is_ok(), free, "{} without {}", law.name, row.key);
        }
    }
}

/// Returns sums of the stress over some steps with plastic flow and its reversal, in plane stress
/// and in three dimensions, and of the traction on a path with damage; zeros where the law is not
/// for such elements.
fn stress(material: &Material) -> [f64; 12] {
    let law = build(material).ok();
    let mut state = vec![0.0; 3 + law.as_ref().map_or(0, |law| law.history().len())];
    let solid = build_solid(material).ok();
    let mut solid_state = vec![0.0; 6 + solid.as_ref().map_or(0, |law| law.history().len())];
    let bond = build_cohesive(material).ok();
    let mut bond_state = vec![0.0; bond.as_ref().map_or(0, |law| law.history().len())];
    let mut sums = [0.0; 12];
    let mut opened = 0.0;
    for step in 0..20 {
        let sign = if step < 14 { 1.0 } else { -1.0 };
        let strain = [[1e-3, -3e-4, 2e-4].map(|e| sign * e)];
        if let Some(law) = &law {
            law.update_one(
                Points { state: &mut state, strain: &strain, thickness_strain: &mut [0.0] },
                1e-3,
            );
        }
        let strain = [1e-3, -3e-4, -2e-4, 2e-4, 0.0, 1e-4].map(|e| sign * e);
        if let Some(law) = &solid {
            law.update_one(SolidPoint { state: &mut solid_state, strain: &strain }, 1e-3);
        }
        opened += 1e-3 * sign;
        // The last step presses the faces together.
        let normal = if step == 19 { -opened } else { opened };
        let opening = [normal, opened, -2.0 * opened];
        let traction = bond.as_ref().map_or([0.0; 3], |law| {
            law.update(CohesivePoint { opening, history: &mut bond_state })
        });
        let stresses = state[..3].iter().chain(&solid_state[..6]).chain(&traction);
        for (sum, now) in sums.iter_mut().zip(stresses) {
            *sum += now;
        }
    }
    sums
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
            // Concrete needs smaller strains, on a path of its own tests.
            if law.name == "cscm" {
                continue;
            }
            assert_ne!(
                stress(&sample),
                with(if default == 1.0 { 0.5 } else { default + 0.05 }),
                "{}: {} makes no difference",
                law.name,
                row.key
            );
        }
    }
}
