//! Integration through the thickness: Gauss-Legendre points of a section or of its layers.

use crate::materials::MAX_LAYER_POINTS;
use crate::parameter::Values;
use crumple_proto::job::{LayerInput, Part};
use crumple_proto::problem::Problem;

/// Returns the problem of angles that are not one for each point.
pub fn fault_of_angles(part: &Part, values: &Values<'_>) -> Option<Problem> {
    let angles = part.angles.len();
    if angles == 0 {
        return None;
    }
    // Only shells have points; others are reported elsewhere.
    let points = if values.has("points") { values.whole("points") } else { angles };
    if part.layer.is_empty() && angles == points {
        return None;
    }
    let (what, help) = if part.layer.is_empty() {
        (format!("{angles} angles and {points} points"), "give one angle for each of its `points`")
    } else {
        ("both layers and `angles`".to_string(), "give each layer its `angle`")
    };
    let message = format!("part {}: it has {what}", part.label());
    Some(Problem::error("angles", message, help))
}

/// Points through the thickness with weights on (-1, 1), from the inner surface to the outer one.
pub struct IntegrationRule {
    /// Number of points.
    pub points: usize,
    /// Their places.
    pub zeta: [f64; MAX_LAYER_POINTS],
    /// Their weights.
    pub weight: [f64; MAX_LAYER_POINTS],
}

impl IntegrationRule {
    /// Returns the rule of layers with Gauss-Legendre points each.
    pub fn of_layers(layers: &[LayerInput]) -> Self {
        let (mut zeta, mut weight) = ([0.0; MAX_LAYER_POINTS], [0.0; MAX_LAYER_POINTS]);
        let whole: f64 = layers.iter().map(|layer| layer.thickness).sum();
        let (mut points, mut below) = (0, 0.0);
        for layer in layers {
            let share = layer.thickness / whole;
            let (own, weights) = gauss_legendre(layer.points);
            for (z, w) in own.iter().zip(weights).take(layer.points) {
                zeta[points] = 2.0 * (below + 0.5 * (z + 1.0) * share) - 1.0;
                weight[points] = w * share;
                points += 1;
            }
            below += share;
        }
        Self { points, zeta, weight }
    }
}

/// Computes points and weights on (-1, 1), ascending, by Newton's method on the Legendre
/// polynomial.
pub fn gauss_legendre(n: usize) -> ([f64; MAX_LAYER_POINTS], [f64; MAX_LAYER_POINTS]) {
    let (mut zeta, mut weight) = ([0.0; MAX_LAYER_POINTS], [0.0; MAX_LAYER_POINTS]);
    // The lower half and the middle; the others follow by symmetry.
    for k in 0..n.div_ceil(2) {
        // Minus the cosine of pi r, by the quotient of Bhaskara, with an error of 0.002 for r up to
        // one half: `cos` itself has other bits with each library.
        let r = (k as f64 + 0.75) / (n as f64 + 0.5);
        let mut z = (4.0 * r * r - 1.0) / (1.0 + r * r);
        let mut slope = 0.0;
        for _ in 0..50 {
            let (mut p0, mut p1) = (1.0, z);
            for j in 2..=n {
                let j = j as f64;
                (p0, p1) = (p1, ((2.0 * j - 1.0) * z * p1 - (j - 1.0) * p0) / j);
            }
            slope = n as f64 * (z * p1 - p0) / (z * z - 1.0);
            z -= p1 / slope;
        }
        // Odd rules have a point in the middle; it is set to zero so that round-off cannot make the
        // section asymmetric.
        zeta[k] = if 2 * k + 1 == n { 0.0 } else { z };
        weight[k] = 2.0 / ((1.0 - z * z) * slope * slope);
    }
    for k in 0..n / 2 {
        zeta[n - 1 - k] = -zeta[k];
        weight[n - 1 - k] = weight[k];
    }
    (zeta, weight)
}
