//! Rubber and foam by a test: the curve of the specimen, what is refused.

use crate::base::{assert_refused, model_of};
use crumple::input::check::describe;
use crumple_proto::partition::{Material, Param};

/// A cube of 10 with the cards of a rubber, and the force over the change of length of a specimen
/// of 20 by 5 by 2.
fn cube(cards: &str) -> String {
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*PART\nblock\n1,1,1\n*SECTION_SOLID\n1,1\n\
         *NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n\
         8,0,10,10\n*ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n*DEFINE_CURVE\n7\n-2.0,-3.3\n0.0,0.0\n\
         2.0,2.7\n{cards}"
    )
}

/// Rubber has the bulk modulus, foam Poisson's ratio; length and area of the specimen divide.
#[test]
fn the_curve_is_that_of_the_specimen() {
    let rubber = "1,1.0e-9,500.0,0.1\n20.0,5.0,2.0,7,-1,1\n0,1.0\n";
    for (keyword, cards, key, value) in [
        ("MAT_SIMPLIFIED_RUBBER/FOAM", rubber, "bulk_modulus", 500.0),
        ("MAT_181", rubber, "bulk_modulus", 500.0),
        ("MAT_SIMPLIFIED_RUBBER", "1,1e-9\n20.0,5.0,2.0,7,0,0,0,0.2\n", "poisson", 0.2),
    ] {
        let model = model_of(&cube(&format!("*{keyword}\n{cards}")));
        let material = &model.settings.materials[0];
        assert_eq!(material.law, "tabulated_rubber");
        assert_eq!(material.parameters.get(key), Some(&Param::Number(value)));
        assert_eq!(material.parameters.len(), 2, "{:?}", material.parameters);
        let Some(Param::Table(points)) = material.parameters.get("curve") else { panic!() };
        let exact = [[-0.1, -0.33], [0.0, 0.0], [0.1, 0.27]];
        for (point, exact) in points.iter().zip(exact) {
            assert!(point.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-15), "{points:?}");
        }
        assert_eq!(points.len(), exact.len());
    }
}

/// Each field without an effect of its own kind has an error that names it.
#[test]
fn what_is_not_supported_is_refused() {
    let of = |first: &str, second: &str, third: &str| {
        cube(&format!("*MAT_SIMPLIFIED_RUBBER/FOAM\n1,1e-9,{first}\n20,5,2,{second}\n{third}\n"))
    };
    for (text, words) in [
        (of("500.0,0.1,100.0,0.1", "7", "0"), "friction"),
        (of("500.0", "7", "7"), "lcunld"),
        (of("500.0", "7", "0,0.5"), "unloading follows the curve; use 1"),
        (of("500.0", "7", "0,0,0,0,1"), "no relaxation"),
        (of("500.0", "7,0,0,0,20.0", "0"), "viscous stress"),
        (of("500.0", "9,2", &format!("0\n{TABLE}")), "use -1, 0 or 1"),
        (of("500.0", "9,-1,2", &format!("0\n{TABLE}")), "use 0 or 1"),
        (
            of("500.0", "9", &format!("0\n{}", TABLE.replace("2.0,5.4", "2.0,2.6"))),
            "lies below that of the rate before it",
        ),
        (of("0.01", "7", "0"), "2/3 of the shear modulus"),
    ] {
        assert_refused(&text, &[words]);
    }
}

/// Tests at two rates of the specimen: force over the change of length.
const TABLE: &str = "*DEFINE_TABLE\n9\n0.1\n1.0\n*DEFINE_CURVE\n10\n-2.0,-3.3\n0.0,0.0\n2.0,2.7\n\
                     *DEFINE_CURVE\n11\n-2.0,-6.6\n0.0,0.0\n2.0,5.4\n";

/// A table gives curves by the strain rate; tension, rtype and avgopt say which rate acts where.
#[test]
fn a_table_gives_curves_by_rate() {
    let of = |options: &str| {
        let text = format!("*MAT_181\n1,1e-9,500.0,0.1\n20,5,2,9,{options}\n0\n{TABLE}");
        model_of(&cube(&text))
    };
    let last = |material: &Material| {
        let Some(Param::Table(rows)) = material.parameters.get("curve_by_rate") else { panic!() };
        assert_eq!(
            rows.iter().map(|row| row[0]).collect::<Vec<_>>(),
            [0.1, 0.1, 0.1, 1.0, 1.0, 1.0]
        );
        [rows[3][2], rows[5][2]]
    };
    for (options, stresses, keys, words) in [
        ("", [-0.66, 0.54], 2, ""),
        ("-1,1,-0.5", [-0.66, 0.54], 4, ""),
        ("1,0,1", [-0.66, 0.54], 2, "unloading follows the slowest curve"),
        ("0", [-0.66, 0.27], 2, ""),
    ] {
        let model = of(options);
        let material = &model.settings.materials[0];
        let near = last(material).iter().zip(stresses).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near && material.parameters.len() == keys, "{options}: {:?}", material.parameters);
        assert!(describe(&model).contains(words), "{options}: {}", describe(&model));
        if keys == 4 {
            assert_eq!(material.parameters["nominal_rate"], Param::Flag(true));
            assert_eq!(material.parameters["rate_averaging_time"], Param::Number(0.5));
        }
    }
}
