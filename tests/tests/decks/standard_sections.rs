//! Standard sections of `*INTEGRATION_BEAM`: cards, the axes of an I, errors. Units mm, ms, kg.

use crate::base::{assert_refused, model_of};
use crumple_proto::ids::NodeId;
use crumple_tests::run_alone;
use std::fmt::Write as _;

/// Width and thickness of the flanges, depth, thickness of the web [mm], length [mm], tip force
/// [kN], Young's modulus and Poisson's ratio.
const I: [f64; 4] = [100.0, 10.0, 200.0, 6.0];
const LENGTH: f64 = 1000.0;
const FORCE: f64 = 10.0;
const E: f64 = 207.0;
const NU: f64 = 0.3;

/// Returns two cantilevers along x whose second axis is y, pulled along z and along y, and damped.
fn deck(rule: &str, lines: &str) -> String {
    let mut text = format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n40.0\n*DAMPING_GLOBAL\n0,0.84\n\
         *MAT_ELASTIC\n1,7.85e-6,{E},{NU}\n*PART\ncolumns\n1,1,1\n\
         *SECTION_BEAM\n1,1,1.0,-7\n0.0\n{rule}\
         *DEFINE_CURVE\n1\n0.0,1.0\n100.0,1.0\n\
         *LOAD_NODE_POINT\n9,3,1,{FORCE}\n19,2,1,{FORCE}\n\
         *BOUNDARY_SPC_NODE\n1,0,1,1,1,1,1,1\n11,0,1,1,1,1,1,1\n*NODE\n99,0,1e4,0\n"
    );
    for k in 0..9 {
        let x = LENGTH * f64::from(k) / 8.0;
        writeln!(text, "{},{x},0,0\n{},{x},50,0", 1 + k, 11 + k).unwrap();
    }
    text += "*ELEMENT_BEAM\n";
    for k in 0..8 {
        writeln!(text, "{0},1,{0},{1},99\n{2},1,{2},{3},99", 1 + k, 2 + k, 11 + k, 12 + k).unwrap();
    }
    text + lines
}

fn rule() -> String {
    let [width, flange, depth, web] = I;
    format!("*INTEGRATION_BEAM\n7,0,0.0,1,0\n{width},{flange},{depth},{web}\n")
}

/// The flanges are along the second axis: the tip moves by `F L^3/(3 E I) + F L/(G A)` along the
/// third axis with the large moment, and along the second with the small one.
#[test]
fn a_wide_flange_is_stiff_along_the_third_axis() {
    let text = deck(&rule(), "");
    let end = run_alone(&model_of(&text), |_| {});
    let moved = |id, axis: usize| {
        let n = end.nodes.local_index(NodeId(id)).expect("a node") as usize;
        end.nodes.x[n][axis] - end.nodes.x0[n][axis]
    };
    let [b, t, h, w] = I;
    let strong = (b * h.powi(3) - (b - w) * (h - 2.0 * t).powi(3)) / 12.0;
    let weak = (2.0 * t * b.powi(3) + (h - 2.0 * t) * w.powi(3)) / 12.0;
    let area = 2.0 * b * t + (h - 2.0 * t) * w;
    let tip = |moment: f64| {
        FORCE * LENGTH.powi(3) / (3.0 * E * moment) + FORCE * LENGTH * 2.0 * (1.0 + NU) / (E * area)
    };
    for (id, axis, moment) in [(9, 2, strong), (19, 1, weak)] {
        let (found, wanted) = (moved(id, axis), tip(moment));
        println!("axis {axis}: {found:.4}, {wanted:.4}");
        // Rotations of 0.0145 change the lever by 1e-4, the elements are exact for a tip force; the
        // moments of fibres differ by some per mille.
        assert!((found / wanted - 1.0).abs() < 1e-2, "axis {axis}: {found}, expected {wanted}");
    }
}

#[test]
fn sections_that_are_not_known_are_refused() {
    assert_refused(&deck("", ""), &["there is no *INTEGRATION_BEAM with the id 7"]);
    let other = rule().replace("7,0,0.0,1,0", "7,0,0.0,3,0");
    assert_refused(&deck(&other, ""), &["`icst` = 3", "W, an I with equal flanges"]);
    let offset = rule().replace("6\n", "6,1.0\n");
    assert_refused(&deck(&offset, ""), &["`sref` = 1"]);
    let points = rule().replace("7,0,0.0,1,0", "7,1,0.0,1,0") + "0.0,0.0,1.0\n";
    assert_refused(&deck(&points, ""), &["`nip` = 1"]);
}
