use super::*;

/// n Gauss points integrate polynomials of degree 2n - 1 exactly (Abramowitz & Stegun 25.4.29).
#[test]
fn gauss_points_integrate_what_they_should() {
    for n in 1..=MAX_POINTS {
        let (zeta, weight) = gauss_legendre(n);
        for degree in 0..2 * n {
            let sum: f64 = (0..n).map(|k| weight[k] * zeta[k].powi(degree as i32)).sum();
            let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
            assert!(
                (sum - exact).abs() < 1e-14,
                "round-off: {n} points, degree {degree}: {sum} for {exact}"
            );
        }
    }
}
