//! Tables of hardening curves by strain rate that cross. Units mm, ms, kg.

use super::base::{BASE, MOVES, assert_refused, model_of};
use super::fates::said;

/// Curves with these last points, from 0.3 and 0.4 at no plastic strain.
fn table(slow: &str, fast: &str) -> String {
    format!(
        "{BASE}{MOVES}*MAT_024\n1,7.85e-6,200.0,0.3\n0.0,0.0,9\n*DEFINE_TABLE\n9\n0.01\n10.0\n\
         *DEFINE_CURVE\n6\n0.0,0.3\n{slow}\n*DEFINE_CURVE\n7\n0.0,0.4\n{fast}\n"
    )
}

/// Beyond their points, the curve of the smaller rate follows the other one where it would be above
/// it. Before its last point it is as given, and the other one is not below it.
#[test]
fn curves_cross_beyond_their_points_only() {
    for (slow, fast) in [("0.5,0.4", "0.5,0.45"), ("1.0,0.6", "0.2,0.41"), ("0.1,0.39", "2,0.5")] {
        let model = model_of(&table(slow, fast));
        assert!(said(&model).contains("cross beyond their last points"), "{}", said(&model));
    }
    let apart = said(&model_of(&table("0.5,0.35", "0.5,0.5")));
    assert!(!apart.contains("cross beyond"), "{apart}");
}

/// Curves that cross where they are given are refused.
#[test]
fn curves_that_cross_within_their_points_are_refused() {
    let words = "the yield stress must not fall as the rate grows";
    assert_refused(&table("0.5,0.6", "0.5,0.5"), &[words]);
}
